"""A complete camera in a result: named as a whole in a system file, in the bill, in what is evaluated."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import pytest

from uwopt.api.evaluating import evaluate
from uwopt.api.solving import solve
from uwopt.errors import MissionError
from uwopt.mission.system import load_system

WHOLE = "olympus-tg6-nauticam"
SYSTEM = {"complete": WHOLE, "light": "blue-robotics-lumen-r2", "light_count": 1, "light_baseline_m": 0.5}


def mission(**sections: Any) -> dict[str, Any]:
    """A small mission at 40 m, in which compacts do well."""
    return {
        "practice": "bare", "objective": "cost", "vehicle": {"altitude_m": 1.5, "speed_m_s": 0.2, "light_count": 1},
        "requirements": {"max_gsd_mm": 2.0, "min_swath_m": 0.8, "frame_interval_s": 4, "min_snr_db": 10},
        "scenes": [{"water": "II", "seafloor": 0.2, "depth_m": 40}],
        "catalog": {"complete": "only", "lights": ["blue-robotics-lumen-r2"], "complete_cameras": [WHOLE]},
    } | sections  # fmt: skip


@pytest.fixture(scope="module")
def solved() -> Any:
    """What is recommended where that camera alone may be used."""
    return solve(mission())


def test_bill_holds_one_camera_complete(solved: Any) -> None:
    rows = {row.kind: row for row in solved.best.bom}
    assert list(rows) == ["complete", "light"]
    assert (rows["complete"].id, rows["complete"].unit_price) == (WHOLE, 449.0 + 1300.0)  # camera and housing
    assert solved.best.totals.cost.value == pytest.approx(449.0 + 1300.0 + rows["light"].unit_price)
    assert solved.best.hardware.complete.id == WHOLE
    assert [part.id for part in solved.best.hardware.named.values()] == [WHOLE, "blue-robotics-lumen-r2"]


def test_account_of_complete_cameras_adds_up(solved: Any) -> None:
    proof = solved.certificate
    assert proof.loaded == proof.evaluated + sum(item.count for item in proof.discarded)
    assert proof.selected == 2  # it with one lamp, landscape and portrait
    assert "1 complete camera, 1 light " in proof.scope
    assert asdict(proof.parts_left) == {
        "cameras": 0, "lenses": 0, "ports": 0, "lights": 1, "housings": 0, "complete_cameras": 1, "generic": 0,
        "places": 1,
    }  # fmt: skip


def test_system_names_it_and_is_evaluated_as_solve_found_it(solved: Any) -> None:
    best = solved.best
    settings = best.scenes[0].settings
    given = {name: settings[name] for name in ("f_number", "exposure_ms", "dim_frac", "frame_rate_hz")}
    given["gain"] = 10.0 ** (settings["gain_db"] / 20.0)
    given_system = {"orientation": best.hardware.orientation, "settings": given, "light_baseline_m": None}
    made = evaluate(mission(), SYSTEM | given_system)
    assert made.best.totals.cost.value == pytest.approx(best.totals.cost.value)
    for name in ("gsd_mm", "snr_db", "swath_m"):
        assert made.best.scenes[0].figures[name] == pytest.approx(best.scenes[0].figures[name], rel=1e-6)


def test_what_runs_on_its_own_battery_draws_nothing_from_the_vehicle() -> None:
    # the lamp's 15 W at its full level are all that is drawn; the battery's class lasts 120 min
    made = evaluate(mission(catalog={"complete": "only", "host": "estimate"}), SYSTEM)
    totals = made.best.totals
    assert totals.power_w == totals.light_power_w > 0.0
    assert totals.run_time_h == pytest.approx(2.0)
    assert {row.kind: row.power_w for row in made.best.bom} == {"complete": 0.0, "light": totals.power_w}


def test_rest_and_computer_are_not_bought_for_what_runs_on_its_own() -> None:
    asked = {"complete": "only", "host": "estimate", "rest": "estimate", "housing": "required"}
    made = evaluate(mission(catalog=asked), SYSTEM)
    kinds = {row.id for row in made.best.bom}
    assert {WHOLE, "rest-lamp-connection", "rest-spares", "rest-pressure-test"} <= kinds
    assert not kinds & {"host-computer", "rest-camera-connection"}
    paid = sum(row.count * row.unit_price for row in made.best.bom)
    assert made.best.totals.cost.value == pytest.approx(paid)
    assert made.best.objective_value == pytest.approx(paid)  # what the search minimises


def test_system_with_a_piece_beside_it_is_refused() -> None:
    with pytest.raises(MissionError, match="lens and complete are both given; keep one of them"):
        load_system(SYSTEM | {"lens": "kowa-lm8jc"})
    with pytest.raises(MissionError, match=r"complete = .* is not in the catalogue; did you mean"):
        evaluate(mission(), SYSTEM | {"complete": "olympus-tg6-nautica"})


def test_pieces_with_other_parts_do_not_fit() -> None:
    torn = {"camera": f"{WHOLE} camera", "lens": "sony-rx0 lens", "port": f"{WHOLE} port"}
    made = evaluate(mission(), {**SYSTEM, "complete": None, **torn})
    missed = {margin.requirement for margin in made.best.scenes[0].margins if not margin.satisfied}
    assert "fits: complete" in missed


def test_mission_that_does_not_ask_says_so_of_a_system() -> None:
    made = evaluate(mission(catalog={}), SYSTEM)
    assert any("complete cameras are not asked for" in note.message for note in made.best.warnings)

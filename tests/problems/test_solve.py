"""Every mission in problems/ is solved, and what is claimed there holds when it is looked at again.

No number of ours is repeated here. The claims are checked against each other and by other ways: the account
of combinations is added up, the design is handed back to `evaluate` as a plain system, and discarded
combinations are attacked by a generic solver.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from thorough import drawn

import uwopt
from uwopt.api import doubting
from uwopt.api.common import prepared
from uwopt.forward.assembly import load_catalog
from uwopt.objectives.objective import Objective
from uwopt.results.design import Design
from uwopt.results.result import Result
from uwopt.solvers.recommend import design_of, seek

PROBLEMS = Path(__file__).parents[2] / "problems"
MISSIONS = sorted(p.stem for p in PROBLEMS.glob("*.yaml") if not p.stem.endswith(".system"))
SETTINGS = (
    "f_number", "exposure_ms", "pulse_ms", "gain", "dim_frac", "frame_rate_hz", "focus_distance_m",
)  # fmt: skip
N_ATTACKED = drawn(4, 40)
#: Physics paper where it was made for, and for the worked example.
ON_PAPER = drawn(("paper-tool-window", "reef-mosaic"), tuple(MISSIONS))
#: Physics full: by default one of each kind - colour and a shutter, flashes, two cameras, parts to be made, daylight.
#: The README's commands solve two more, the front of another has its optimum at its end.
IN_FULL = drawn(["awi-ofobs", "mbari-lass-2013", "ooi-camhd", "usgs-squid5", "whoi-abe"], MISSIONS)
#: Physics full with all that is told beside the proof, and not second opinions and prices alone. Nothing here looks at
#: that but for numbers that are not finite, and physics paper tells it too.
DOUBTED = drawn((), tuple(MISSIONS))


def as_system(design: Design) -> dict[str, Any]:
    """A design as the system file a person would write of it."""
    hardware = design.hardware
    system: dict[str, Any] = {kind: hardware[kind]["id"] for kind in ("camera", "lens", "port", "light")}
    for key in ("camera_count", "light_count", "orientation", "light_mounts"):
        system[key] = hardware[key]
    system["scenes"] = {
        scene.name: {key: scene.settings[key] for key in SETTINGS if scene.settings[key] is not None}
        for scene in design.scenes
    }
    return system


def numbers_that_are_not_finite(value: Any) -> list[float]:
    """All NaN and infinite numbers in nested plain values."""
    if isinstance(value, dict):
        return [bad for item in value.values() for bad in numbers_that_are_not_finite(item)]
    if isinstance(value, list):
        return [bad for item in value for bad in numbers_that_are_not_finite(item)]
    return [value] if isinstance(value, float) and not math.isfinite(value) else []


def assert_proven(result: Result) -> None:
    """The certificate is complete, its gap is closed, and its account adds up to what was loaded.

    Only what can be set is called optimal.
    """
    proof, best = result.certificate, result.recommendation
    assert best is not None
    assert all(scene.settings_to_set is not None for scene in best.scenes)
    assert result.status == "optimal"
    assert proof is not None
    assert proof.complete
    assert proof.gap_rel is not None
    assert abs(proof.gap_rel) <= 1e-9  # the bound that the project promises for closed forms
    assert proof.loaded == proof.evaluated + sum(item["count"] for item in proof.discarded)
    assert all(item["count"] >= 0 for item in proof.discarded)
    assert 0 < proof.evaluated <= proof.selected <= proof.loaded


def assert_bill_adds_up(design: Design) -> None:
    """The rows of the bill sum to the cost, the mass and the power of the whole, as it is set."""
    design = design.as_set
    totals, bill = design.totals, design.bom
    figures = {name: max(scene.figures[name] for scene in design.scenes) for name in ("cost", "power_w")}
    assert sum(row.to_buy * (row.unit_price or 0.0) for row in bill) == pytest.approx(figures["cost"])
    assert sum(row.count * (row.unit_mass_kg or 0.0) for row in bill) == pytest.approx(totals.mass_kg)
    assert sum(row.power_w or 0.0 for row in bill) == pytest.approx(figures["power_w"])


def assert_no_runner_up_is_better(result: Result) -> None:
    """Runners-up are feasible, sorted, and not better; all objectives of these missions are minimised."""
    values = [design.objective_value for design in result.runners_up]
    assert result.objective["direction"].startswith("min")
    assert all(design.feasible for design in result.runners_up)
    assert values == sorted(values)
    # 1e-9 relative: below that two designs count as equal and part ids decide
    assert all(v >= result.objective["value"] * (1 - 1e-9) for v in values)


@pytest.mark.parametrize(
    ("name", "physics"), [*((name, "paper") for name in ON_PAPER), *((name, "full") for name in IN_FULL)]
)
def test_mission_is_solved_and_its_claims_hold(
    name: str, physics: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    mission = PROBLEMS / f"{name}.yaml"
    if physics == "full" and name not in DOUBTED:
        monkeypatch.setattr(doubting, "doubts_of", lambda *given: {})
    result = uwopt.solve(mission, physics=physics, audit=N_ATTACKED)
    best = result.recommendation
    assert best is not None
    assert best.feasible
    assert_proven(result)
    assert_no_runner_up_is_better(result)
    assert_bill_adds_up(best)
    assert numbers_that_are_not_finite(result.to_dict()) == []
    assert result.audit is not None
    assert result.audit["tried"] == N_ATTACKED
    assert result.audit["passed"], result.audit["better"]

    again = uwopt.evaluate(mission, as_system(best), physics=physics)
    missed = [m for scene in again.best.scenes for m in scene.margins if not m.satisfied]
    assert missed == []
    assert again.status == "feasible"
    # 1e-6: the settings pass through milliseconds and back, nothing else is between the two numbers
    assert again.objective["value"] == pytest.approx(best.objective_value, rel=1e-6)


def test_settings_to_set_keep_the_information_that_was_asked_for() -> None:
    """Rounding loses a step of gain or so beside the mark on the ring, not the light that was chosen."""
    some = {"cameras": ["allied*"], "lenses": ["thorlabs"]}
    mission = prepared(PROBLEMS / "reef-mosaic.yaml", None, "information").with_changes(catalog=some)
    goal = Objective.of(mission.objective)
    sought = seek(mission, load_catalog(mission), goal, generic="never", top=1)
    best = design_of(sought, sought.outcome.best[0])
    assert best.rounded is not None and best.objective_value
    assert best.rounded["feasible"]
    exact, marked = best.scenes[0].settings, best.scenes[0].settings_to_set
    assert exact["f_number"] is not None and marked is not None and marked["f_number"] is not None
    at_mark = as_system(best)  # the exact settings but for the mark, and the gain that keeps the level
    own = next(iter(at_mark["scenes"].values()))
    own["gain"] *= (marked["f_number"] / exact["f_number"]) ** 2
    own["f_number"] = marked["f_number"]
    reached = uwopt.evaluate(mission, at_mark).objective["value"]
    assert reached > 0.9 * best.objective_value
    assert best.rounded["objective_value"] > 0.98 * reached

"""The exact search and `uwopt.solve` at extreme numbers, on catalogues of one, of identical and of near parts."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import extreme_cases as cases
import numpy as np
import pytest
import small_catalogues as small
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from thorough import THOROUGH

import uwopt
from uwopt.catalog.records import exact
from uwopt.forward.parts import Parts
from uwopt.solvers.exact.account import Outcome

EXAMPLES = 60 if THOROUGH else 4
PHYSICS = ("full", "paper")


def by_turns(names: Iterable[str]) -> list[tuple[str, str]]:
    """Each name with one of the two kinds of physics, by turns; with both before a release."""
    return [
        (physics, name) for i, name in enumerate(names) for physics in (PHYSICS if THOROUGH else [PHYSICS[i % 2]])
    ]


SAME = 1e-9  # below that two designs count as equal and part ids decide


def plain(physics: str = "full", **sections: Any) -> dict[str, Any]:
    made = cases.mission(physics, **sections)
    vehicle = {"orientation": "landscape", "light_count": [1, 2], "speed_m_s": 0.3}
    made["vehicle"] = {**made["vehicle"], **vehicle, **sections.get("vehicle", {})}
    made["requirements"] = {
        "overlap": 0.3,
        "max_blur_px": 1.0,
        "min_snr": 3.0,
        **sections.get("requirements", {}),
    }
    return made


def best_of(outcome: Outcome) -> float:
    """Value of the optimum, infinite where nothing is feasible; the proof is complete."""
    assert outcome.complete and outcome.account.adds_up()
    values = [found.minimised for found in outcome.best]
    assert not any(math.isnan(v) or math.isinf(v) for v in values)
    assert values == pytest.approx(sorted(values), rel=1e-9)  # what differs by less is a tie
    if not values:
        return math.inf
    assert outcome.lower_bound <= values[0]
    return values[0]


# ---------------------------------------------------------------- sizes


@pytest.mark.parametrize(("physics", "objective"), by_turns(["power", "cost", "snr_db"]))
def test_one_part_identical_parts_and_parts_1e_12_apart(physics: str, objective: str) -> None:
    """All catalogues have one optimum; a step of 1e-12 neither hides the best nor makes another."""
    one = cases.one_of_each()
    single = cases.searched(one, plain(physics), objective)
    assert len(single.best) == 1
    for step in (0.0, 1e-12):
        many = cases.searched(cases.copies(one, 3, step_rel=step), plain(physics), objective)
        assert best_of(many) == pytest.approx(best_of(single), rel=1e-9)
        found = {(f.camera, f.lens, f.port, f.light) for f in many.best}
        assert len(found) == len(many.best) == 4  # other hardware each
        assert (many.best[0].camera, many.best[0].lens, many.best[0].port, many.best[0].light) == (0, 0, 0, 0)


# ---------------------------------------------------------------- numbers


FEASIBLE: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "1 cm": ({"vehicle": {"altitude_m": 0.01}, "requirements": {"min_snr": 0.01, "max_blur_px": 1e4}}, {}),
    "at rest": ({"vehicle": {"speed_m_s": 0.0}, "requirements": {"overlap": 0.99, "frame_interval_s": 1.0}}, {}),
    "20 m/s": ({"vehicle": {"speed_m_s": 20.0}, "requirements": {"overlap": 0.0}}, {}),
    "SNR 0.1": ({"requirements": {"min_snr": 0.1}}, {}),
    "no read noise": ({}, {"camera": {"read_noise_e": exact(0.0)}}),
    "well of 100": ({}, {"camera": {"saturation_e": exact(100.0)}}),
    "well of 1e7, 1e7 lm": ({}, {"camera": {"saturation_e": exact(1e7)}, "light": {"flux_lm": exact(1e7)}}),
}  # fmt: skip
IMPOSSIBLE: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "100 m": ({"vehicle": {"altitude_m": 100.0}}, {}),
    "20 m/s at 99 %": ({"vehicle": {"speed_m_s": 20.0}, "requirements": {"overlap": 0.99}}, {}),
    "SNR 1e4": ({"requirements": {"min_snr": 1e4}}, {}),
    "1 lm": ({}, {"light": {"flux_lm": exact(1.0)}}),
    "black floor": ({"scene": {"seafloor": 0.0}}, {}),
    "focus within 500 mm": ({"requirements": {"min_dof_m": 0.1}}, {"lens": {"focal_length_mm": 500.0}}),
    "glass ball": ({}, {"port": {"outer_radius_mm": 10.0001}}),
}  # fmt: skip


@pytest.mark.parametrize(("physics", "name"), by_turns(FEASIBLE))
def test_extremes_that_can_be_met(physics: str, name: str) -> None:
    wanted, parts = FEASIBLE[name]
    assert best_of(cases.searched(cases.one_of_each(**parts), plain(physics, **wanted))) > 0.0


@pytest.mark.parametrize(("physics", "name"), by_turns(IMPOSSIBLE))
def test_extremes_that_cannot_be_met_are_proven_infeasible(physics: str, name: str) -> None:
    wanted, parts = IMPOSSIBLE[name]
    assert best_of(cases.searched(cases.one_of_each(**parts), plain(physics, **wanted))) == math.inf


@pytest.mark.parametrize("physics", PHYSICS)
@pytest.mark.parametrize(
    "water", [(0.0, 0.0), (0.2, 0.0), (0.0, 0.2), (100.0, 0.0), (0.0, 500.0), (500.0, 500.0)], ids=str
)
def test_waters(physics: str, water: tuple[float, float], tmp_path: Path) -> None:
    a, b = water
    file = cases.flat_water(tmp_path, a_per_m=a, b_per_m=b, kd_per_m=a)
    found = best_of(cases.searched(cases.one_of_each(), plain(physics, scene={"water": file})))
    assert math.isinf(found) == (a + b >= 100)


# ---------------------------------------------------------------- uwopt.solve


@pytest.mark.parametrize(
    ("wanted", "status"),
    [({"vehicle": {"speed_m_s": 0.0}}, "optimal"), ({"vehicle": {"altitude_m": 100.0}}, "infeasible"),
     ({"requirements": {"min_snr": 1e4}}, "infeasible"), ({"scene": {"seafloor": 0.0}}, "infeasible")],
    ids=str,
)  # fmt: skip
def test_solve_says_what_is_possible(wanted: dict[str, Any], status: str) -> None:
    mission = plain("paper", **wanted)
    mission["scene"]["depth_m"] = 50 + mission["vehicle"]["altitude_m"]
    result = uwopt.solve(
        {**mission, "catalog": {"cameras": ["flir-bfs-u3-3"], "lenses": ["kowa-lm8"], "generic": "never"}}
    )
    assert result.status == status
    assert cases.not_finite(result.to_dict()) == []
    if status == "infeasible":
        assert result.infeasible is not None and result.infeasible["requirements"]
    else:
        cases.assert_sound(result)


# ---------------------------------------------------------------- invariances


def random_case(seed: int) -> tuple[Parts, dict[str, Any], Any]:
    rng = np.random.default_rng(seed)
    parts, wanted = small.parts(rng, 2), small.mission(rng)
    wanted["physics"] = "paper" if seed % 2 else "full"
    return parts, wanted, "cost" if seed % 3 else "power"


def value(parts: Parts, wanted: dict[str, Any], objective: Any) -> float:
    return best_of(cases.searched(parts, wanted, objective))


def no_worse(new: float, old: float) -> bool:
    return new <= old + SAME * abs(old) if math.isfinite(old) else True


quick = settings(
    max_examples=EXAMPLES, deadline=None, derandomize=not THOROUGH, suppress_health_check=list(HealthCheck)
)
seeds = st.integers(1000, 1_000_000)


@quick
@given(seed=seeds, order=st.randoms(use_true_random=False))
def test_the_order_of_the_catalogue_changes_nothing(seed: int, order: Any) -> None:
    parts, wanted, objective = random_case(seed)
    columns = [list(c) for c in (parts.cameras, parts.lenses, parts.ports, parts.lights)]
    for column in columns:
        order.shuffle(column)
    here, there = value(parts, wanted, objective), value(Parts(*map(tuple, columns)), wanted, objective)  # type: ignore[arg-type]
    assert here == there or here == pytest.approx(there, rel=SAME)


@quick
@given(seed=seeds, kind=st.sampled_from(["cameras", "lenses", "ports", "lights"]))
def test_a_part_added_never_makes_the_optimum_worse(seed: int, kind: str) -> None:
    parts, wanted, objective = random_case(seed)
    more = getattr(random_case(seed + 1)[0], kind)[0]
    larger = replace(parts, **{kind: (*getattr(parts, kind), replace(more, id="added"))})
    assert no_worse(value(larger, wanted, objective), value(parts, wanted, objective))


@quick
@given(seed=seeds, room=st.floats(1.0, 3.0))
def test_more_tolerance_never_raises_the_optimum(seed: int, room: float) -> None:
    """Every requirement that is asked for made easier by the same factor."""
    parts, wanted, objective = random_case(seed)
    eased = dict(wanted["requirements"])
    for key in eased.keys() & {"max_blur_px", "max_skew_px", "frame_interval_s"}:
        eased[key] *= room
    for key in eased.keys() & {"min_dof_m", "min_contrast", "min_uniformity", "overlap"}:
        eased[key] /= room
    if "min_snr_db" in eased:
        eased["min_snr_db"] -= 20 * math.log10(room)
    if "highlight_ratio" in eased:
        eased["highlight_ratio"] = max(1.0, eased["highlight_ratio"] / room)
    easier = {**wanted, "requirements": eased}
    assert no_worse(value(parts, easier, objective), value(parts, wanted, objective))

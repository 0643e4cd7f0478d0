"""Physics `auto` against `full`: what is left out may not matter more than the tolerance."""

from __future__ import annotations

from collections.abc import Set
from typing import Any

import numpy as np
import pytest
from effects_cases import random_mission, random_system
from thorough import THOROUGH, drawn

from uwopt.api.evaluating import evaluate
from uwopt.forward.effects import choose
from uwopt.model.effects import Effects
from uwopt.results.result import Result

CASES_A_CHUNK, CHUNKS = drawn((8, 1), (25, 20))  # 500 random scenes and systems before a release
#: Of these 500 those in which bounds are nearest to what the effects change, and what can be left out of each.
VEILS = frozenset({"forward_veil", "backscatter", "multiple_scattering"})
SHARP: dict[tuple[int, int], Set[str]] = {
    (8, 5): {"window_angle"},
    (11, 18): {"window_angle", "forward_veil"}, (13, 22): {"window_angle", "backscatter"},
    (10, 10): {"window_angle", "sunlight"}, (16, 18): {"window_angle", *VEILS},
    (12, 6): {"backscatter"}, **dict.fromkeys([(1, 19), (13, 9), (13, 10)], VEILS),
    (3, 3): {"backscatter", "forward_veil"}, (10, 22): VEILS | {"sunlight"},
}  # fmt: skip
if THOROUGH:
    SHARP |= {
        (12, 5): {"window_angle"}, (15, 5): {"backscatter"},
        **dict.fromkeys([(6, 9), (7, 7), (11, 23), (17, 12)], VEILS),
        (6, 6): {"backscatter", "forward_veil"},  # the sun shines
        (9, 19): {"backscatter"},  # the sun shines on after the pulse and softens the image, which a result tells
        (17, 18): {"backscatter", "forward_veil", "sunlight"}, (13, 18): VEILS | {"sunlight"},
    }
MOST_TOLERANCE = 0.5  # the most that a mission may allow
RATIOS = (
    "overlap",
    "saturation_fraction",
    "mean_level",
    "min_contrast",
    "min_uniformity",
    "min_mtf_half_nyquist",
)


def distance(name: str, one: float | None, other: float | None) -> float:
    """Change of a figure in the contract's measure: ratios absolutely, decibels by a tenth, the rest relatively."""
    if one is None or other is None:
        return 0.0 if one == other else np.inf
    if name.endswith("_db"):
        return abs(one - other) / 10.0
    if name in (*RATIOS, "contrast"):  # shares; a saturation beyond 1 is no share and counts relatively
        return abs(one - other) / max(1.0, abs(other))
    return abs(one - other) / max(abs(other), 1e-12)


def random_case(seed: tuple[int, int]) -> tuple[dict[str, Any], dict[str, Any]]:
    """A random mission and system."""
    rng = np.random.default_rng(seed)
    mission, system = random_mission(rng), random_system(rng)
    if mission["objective"] == "information":
        mission["requirements"]["min_swath_m"] = 0.1
    return mission, system


def assert_near(full: Result, auto: Result, tolerance: float, seed: tuple[int, int]) -> None:
    """No figure that counts differs by more than the tolerance."""
    assert full.design is not None and auto.design is not None
    objective = full.objective["name"]
    pairs = [(objective, auto.design.objective_value, full.design.objective_value)]
    for ours, theirs in zip(auto.design.scenes, full.design.scenes, strict=True):
        values = {m.requirement: m.value for m in theirs.margins}
        pairs += [(m.requirement, m.value, values[m.requirement]) for m in ours.margins]
    for name, ours_value, theirs_value in pairs:
        moved = distance(name, ours_value, theirs_value)
        assert moved <= tolerance * (1 + 1e-9), (seed, name, ours_value, theirs_value)


def bounds_left_out(auto: Result) -> dict[str, float]:
    """Effects that there are and that were left out, with the bound of each."""
    return {e["name"]: e["bound"] for e in auto.physics["effects"] if not e["kept"] and e["bound"] > 0}


@pytest.mark.parametrize("seed", SHARP, ids=str)
def test_no_effect_changes_more_than_its_bound(seed: tuple[int, int]) -> None:
    """The tolerance is made just what the least bounds add up to, one more at a time: no room is left for a bound
    that is too low."""
    mission, system = random_case(seed)
    full = evaluate(mission, system, physics="full")
    bounds = sorted(e["bound"] for e in full.physics["effects"] if e["bound"])
    left_out: set[str] = set()
    for spent in np.cumsum(bounds):
        if spent <= MOST_TOLERANCE:
            mission["tolerance"] = float(spent) * (1 + 1e-9)
            auto = evaluate(mission, system, physics="auto")
            left_out |= set(bounds_left_out(auto))
            assert_near(full, auto, mission["tolerance"], seed)
    assert left_out == SHARP[seed]  # a case that leaves nothing out says nothing


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_auto_stays_within_its_tolerance_of_full(chunk: int) -> None:
    left_out = 0
    for number in range(CASES_A_CHUNK):
        mission, system = random_case((chunk, number))
        full, auto = (evaluate(mission, system, physics=physics) for physics in ("full", "auto"))
        left_out += len(bounds_left_out(auto))
        assert sum(e["bound"] for e in auto.physics["effects"] if not e["kept"]) <= mission["tolerance"] * (
            1 + 1e-12
        )
        assert_near(full, auto, mission["tolerance"], (chunk, number))
    assert left_out > 0  # a contract that never leaves anything out says nothing


def test_an_effect_left_out_has_no_figure_of_its_own() -> None:
    rng = np.random.default_rng(1)
    mission, system = random_mission(rng), random_system(rng)
    mission["scene"].update(water="I", sun_lux=0.0)
    mission["vehicle"]["altitude_m"], mission["tolerance"] = 0.2, 0.4
    mission["requirements"] = {"frame_interval_s": 2.0}
    mission["objective"] = "power"
    result = evaluate(mission, system, physics="auto")
    kept = {e["name"]: e["kept"] for e in result.physics["effects"]}
    assert not kept["backscatter"] and not kept["forward_veil"]
    figures = result.design.scenes[0].figures  # type: ignore[union-attr]
    assert figures["electrons_backscatter"] is None and figures["electrons_forward"] is None


def test_orders_of_daylight_are_kept_where_the_sun_shines() -> None:
    rng = np.random.default_rng(1)
    mission, system = random_mission(rng), random_system(rng)
    mission["scene"].update(water="I", sun_lux=0.0, depth_m=5.0)
    mission["vehicle"]["altitude_m"], mission["tolerance"] = 0.2, 0.4
    mission["requirements"], mission["objective"] = {"frame_interval_s": 2.0}, "power"
    kept = []
    for sun_lux in (0.0, 100_000.0):
        mission["scene"]["sun_lux"] = sun_lux
        effects = evaluate(mission, system, physics="auto").physics["effects"]
        kept.append(next(e["kept"] for e in effects if e["name"] == "multiple_scattering"))
    assert kept == [False, True]


def test_smallest_bounds_are_left_out_until_the_tolerance_is_spent() -> None:
    bounds = {"forward_veil": 0.003, "backscatter": 0.0015, "window_angle": 0.001, "sunlight": 0.0,
              "image_curvature": float("inf"), "lateral_colour": 0.0}  # fmt: skip
    kept = {i.name: i.kept for i in choose({name: (b, 0.0) for name, b in bounds.items()}, 0.004)}
    assert kept == {"forward_veil": True, "backscatter": False, "sunlight": False, "window_angle": False,
                    "image_curvature": True, "lateral_colour": False}  # fmt: skip


def test_every_effect_is_listed_in_the_lights_order() -> None:
    assert [i.name for i in choose(dict.fromkeys(Effects.names(), (0.0, 0.0)), 0.005)] == list(
        Effects.names()
    )

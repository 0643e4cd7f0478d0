"""Other makers' best systems are those of searches of their own, whatever an earlier search has listed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from uwopt.api.searching import Searches
from uwopt.forward.assembly import load_catalog
from uwopt.mission.mission import load_mission
from uwopt.objectives.goal import goal_of
from uwopt.solvers.explain.other_makers import beside_best
from uwopt.solvers.recommend import Sought, design_of

PROBLEMS = Path(__file__).parents[2] / "problems"
FEW = {
    "cameras": ["avt-alvium-1800-c-234m", "basler-daa1280-54um", "flir-bfly-u3-23s6m"], "generic": "never",
    "lenses": ["fujinon-hf9ha-1b", "thorlabs-mvl16m1"],
    "lights": ["arctic-rays-dragonfish-mini-strobe-65deg*", "blue-robotics-lumen*"],
    "ports": ["blue-robotics-4-in-acrylic-end-cap-2026", "blue-robotics-4-in-dome-plastic-ring-2026"],
}  # fmt: skip


@pytest.fixture(scope="module")
def sought() -> Sought:
    base = load_mission(PROBLEMS / "reef-mosaic.yaml").to_dict()
    vehicle = base["vehicle"] | {"altitude_tolerance_m": 0.0}
    few = base["catalog"] | FEW
    mission = load_mission(base | {"catalog": few, "vehicle": vehicle})
    return Searches(load_catalog(mission), goal_of(mission), 1).of(mission).sought


def test_listed_imagers_change_no_makers_best_system(sought: Sought, monkeypatch: pytest.MonkeyPatch) -> None:
    goal = goal_of(sought.problem.mission)
    best = design_of(sought, sought.outcome.best[0], with_rounding=False)
    assert sought.search.every_imager is not None
    listed = beside_best(sought.selection, sought.search, goal, best)
    monkeypatch.setattr(sought.search, "every_imager", None)
    anew = beside_best(sought.selection, sought.search, goal, best)
    assert {one.maker for one in anew if one.outcome == "worse"} >= {"Basler", "Teledyne FLIR"}
    assert [replace(one, values={}) for one in listed] == [replace(one, values={}) for one in anew]
    for ours, theirs in zip(listed, anew, strict=True):
        assert ours.values == pytest.approx(theirs.values, rel=1e-6)


def test_makers_are_held_against_the_best_by_the_same_numbers(sought: Sought) -> None:
    # what was chosen over scenarios has 10 W where it is set; by central numbers it is as the makers' systems are
    goal = goal_of(sought.problem.mission)
    best = design_of(sought, sought.outcome.best[0], with_rounding=False)
    plain = beside_best(sought.selection, sought.search, goal, best)
    chosen = replace(best, objective_value=10.0)
    listed = beside_best(sought.selection, sought.search, goal, chosen, central=best.objective_value)
    told = [one.text for one in listed if one.outcome == "worse" and "more" in one.text]
    assert told == [
        f"{one.text} than the best with every estimate at its likeliest value"
        for one in plain if one.outcome == "worse" and "more" in one.text
    ]  # fmt: skip
    assert told

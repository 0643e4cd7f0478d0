"""Parts to be made where nothing that is sold does: of as few kinds as serve as well as all."""

from __future__ import annotations

from itertools import chain, combinations
from typing import Any

import pytest

import uwopt
from uwopt.api import doubting, searching
from uwopt.api.watch import Watch
from uwopt.errors import MissionError
from uwopt.forward.assembly import load_catalog
from uwopt.mission.mission import load_mission
from uwopt.objectives.goal import goal_of
from uwopt.solvers.beside import cores
from uwopt.solvers.recommend import seek
from uwopt.solvers.warm import searches

KINDS = ("housing", "port", "light")
DOME = "blue-robotics-4-in-dome-aluminium-ring-2026"  # rated to 1000 m


def survey(**catalog: Any) -> dict[str, Any]:
    """A survey at 1000 m: no lamp that is sold gives light enough, and a port is sold for that depth."""
    return {
        "practice": "bare", "physics": "paper", "scene": {"water": "IB", "seafloor": 0.2, "depth_m": 1000},
        "vehicle": {"altitude_m": 3.0, "speed_m_s": 0.7, "light_count": [1, 4], "light_baseline_m": 1.0},
        "requirements": {
            "overlap": 0.43, "max_blur_px": 1.0, "min_dof_m": 1.0, "min_snr_db": 25, "max_gsd_mm": 1.2,
            "min_swath_m": 1.6, "mean_level": 0.3,
        },
        "catalog": {
            "cameras": ["avt-alvium-1800-c-234m"], "lenses": ["thorlabs-mvl16m1", "raspberry-pi-16*"],
            "ports": [DOME, "generic-dome-*"], **catalog,
        },
    }  # fmt: skip


def shallow(objective: str) -> dict[str, Any]:
    """The same from 2 m above the floor at 100 m, for which all that it takes is sold."""
    asked = survey()
    asked["scene"]["depth_m"], asked["vehicle"]["altitude_m"] = 100, 2.0
    asked["requirements"] |= {"min_snr_db": 20, "min_swath_m": 0.8}
    return asked | {"objective": objective}


def best_with(kinds: tuple[str, ...], asked: dict[str, Any] | None = None) -> float | None:
    """The optimum with parts to be made of some kinds; None where nothing fits."""
    mission = load_mission(asked or survey())
    best = seek(mission, load_catalog(mission), goal_of(mission), generic=kinds, top=1).outcome.best  # type: ignore[arg-type]
    return best[0].minimised if best else None


def test_a_port_that_is_sold_stays_where_only_lamps_have_to_be_made() -> None:
    every = {kinds: best_with(kinds) for size in range(4) for kinds in combinations(KINDS, size)}
    fits = {kinds for kinds, best in every.items() if best is not None}
    assert () not in fits and ("port",) not in fits and ("light",) in fits
    whole, some = every[KINDS], every["light",]
    assert whole is not None and some is not None and whole < some  # a dome to be made would be a little better
    result = uwopt.solve(survey(), confidence="central", quick=True, top=1)
    assert result.best is not None
    made = {kind for kind, part in result.best.hardware.parts.items() if part.generic}
    assert made == {"light"}
    assert result.best.objective_value == pytest.approx(some, rel=1e-9)
    assert result.certificate.adds_up()
    assert searches.Warm().best(load_mission(survey())).lower_bound == pytest.approx(some, rel=1e-9)


def test_what_was_searched_with_parts_of_all_kinds_is_not_searched_again(monkeypatch: pytest.MonkeyPatch) -> None:
    mission = load_mission(survey())
    asked = list[Any]()

    def counted(*args: Any, **named: Any) -> Any:
        asked.append(named["generic"])
        return seek(*args, **named)

    monkeypatch.setattr(searching, "seek", counted)
    found = searching.Searches(load_catalog(mission), goal_of(mission)).of(mission)
    assert asked.count("allow") == 1
    every = searching.of_all_parts(found.sought, Watch())
    assert asked.count("allow") == 1
    assert every.outcome.best[0].minimised == pytest.approx(best_with(KINDS), rel=1e-9)


@pytest.mark.parametrize(("gain", "expected"), [(0.1, {"light"}), (0.03, {"light", "port"})])
def test_more_kinds_are_made_where_they_gain_enough(
    gain: float, expected: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The dome to be made takes 3.9 % less power: worth it where 3 % are, not where it must be 10 %."""
    monkeypatch.setattr(searching, "GENERIC_GAIN", gain)
    monkeypatch.setattr(searches, "GENERIC_GAIN", gain)
    result = uwopt.solve(survey(), confidence="central", quick=True, top=1)
    assert result.best is not None
    assert {kind for kind, part in result.best.hardware.parts.items() if part.generic} == expected
    assert searches.Warm().best(load_mission(survey())).lower_bound == pytest.approx(result.best.objective_value)


@pytest.mark.parametrize("gain", [0.0, 0.03, 0.1])
def test_few_kinds_are_the_same_and_searched_once_whoever_asks_of_them(
    gain: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On one core no search is made twice; of two, one takes what the other asks of no kinds again."""
    monkeypatch.setattr(searching, "GENERIC_GAIN", gain)
    mission, asked, made = load_mission(survey()), list[Any](), list[Any]()
    goal, catalog = goal_of(mission), load_catalog(mission)

    def counted(*args: Any, **named: Any) -> Any:
        asked.append((named["generic"], named.get("enough", False)))
        return seek(*args, **named)

    monkeypatch.setattr(searching, "seek", counted)
    for count in (1, 2):
        asked.clear()
        with cores(count):
            found = searching.Searches(catalog, goal).of(mission).sought
        assert len(set(asked)) == len(asked)
        made.append((found.selection.generic, found.outcome.best[0].minimised, [*asked]))
    (kinds, value, alone), (of_two, same, here) = made
    assert kinds == of_two and value == same
    assert len(here) <= len(alone) and set(here) <= set(alone) and (gain or len(here) < len(alone))


@pytest.mark.parametrize("objective", ["cost", "power"])
def test_parts_to_be_made_are_told_of_where_they_are_much_better_than_all_that_is_sold(objective: str) -> None:
    sold, every = best_with((), shallow(objective)), best_with(KINDS, shallow(objective))
    assert sold is not None and every is not None
    seen = list[Any]()
    result = uwopt.solve(shallow(objective), confidence="central", quick=True, top=1, first=seen.append)
    assert result.certificate is not None and result.certificate.lower_bound == pytest.approx(sold, rel=1e-9)
    assert seen[0].best == result.best and seen[0].generic_alternative is None  # told later: nobody waits for it
    made = result.generic_alternative
    assert (made is not None) == (every < 0.9 * sold) == (objective == "cost")
    if made is not None:
        assert made.objective_value == pytest.approx(every, rel=1e-9)
        assert any(part.generic for part in made.hardware.parts.values())


def test_no_more_parts_are_looked_at_where_few_kinds_are_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """By hand: few kinds stay within 1.1 of the best of all, so that none of all is below 1 / 1.1 > 0.9 of theirs."""
    asked = list[Any]()
    monkeypatch.setattr(doubting, "if_made", lambda *of: asked.append(of))
    assert uwopt.solve(survey(), confidence="central", quick=True, top=1).best is not None and asked == []
    assert uwopt.solve(shallow("cost"), confidence="central", quick=True, top=1).best is not None and len(asked) == 1


def test_kinds_that_may_be_made_can_be_listed() -> None:
    for kinds in chain.from_iterable(combinations(KINDS, size) for size in (1, 2)):
        asked = uwopt.solve(survey(generic=list(kinds)), confidence="central", quick=True, top=1, explain=False)
        expected = best_with(kinds)
        assert (asked.best is None) == (expected is None)
        if asked.best is not None:
            assert asked.best.objective_value == pytest.approx(expected, rel=1e-9)
    assert load_mission(survey(generic="Light")).catalog.generic == ("light",)
    assert load_mission(survey(generic=[])).catalog.generic == "never"
    again = load_mission(load_mission(survey(generic=["port", "housing"])).to_dict()).catalog.generic
    assert again == ("port", "housing")


@pytest.mark.parametrize(("given", "said"), [("lamp", "fallback, allow, never"), (["camera"], "light, port, housing")])
def test_a_kind_that_nobody_makes_is_refused(given: Any, said: str) -> None:
    with pytest.raises(MissionError, match=said):
        load_mission(survey(generic=given))

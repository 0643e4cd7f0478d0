"""Questions why nothing fits whose answer is soon known are asked of all imagers, and none twice."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml
from test_least_change import mission

from uwopt.api.common import prepared
from uwopt.catalog.catalogue import Catalog
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.assembly import load_catalog
from uwopt.mission.mission import Mission, load_mission
from uwopt.objectives.objective import Objective
from uwopt.results.basis import WhyNothing
from uwopt.solvers.exact.account import Account, Outcome
from uwopt.solvers.exact.certificate import certificate
from uwopt.solvers.exact.search import Search
from uwopt.solvers.infeasible.freed_rules import of_lamps, suspects_of
from uwopt.solvers.infeasible.joint_changes import first_of_all, least_set
from uwopt.solvers.infeasible.least_change import same_hardware
from uwopt.solvers.infeasible.relaxer import Relaxer
from uwopt.solvers.infeasible.singles import Singles
from uwopt.solvers.infeasible.trials import BRIGHT, Trials
from uwopt.solvers.infeasible.why_nothing import why_nothing
from uwopt.solvers.recommend import Sought, seek

POWER = Objective.of("power")
JOBS = Path(__file__).resolve().parents[2] / "problems" / "jobs"


def test_a_few_imagers_that_were_all_looked_at_in_vain_are_not_looked_at_again(parts, catalog, monkeypatch):
    wanted = mission(parts, min_snr_db=100.0)  # more electrons than the pixel holds
    one = Singles(Trials(wanted, catalog, POWER, "never"))
    few, tried = Relaxer.seek, []

    def among_few(self: Relaxer, mission: Mission, goal: Objective, freed: set[str], *_: Any, **more: Any) -> Sought:
        tried.append(*freed)
        return few(self, mission, goal, freed, enough=True, few_first=False)

    monkeypatch.setattr(Relaxer, "among_few", among_few)
    one._try_among("max_blur_px", 250, NEVER)
    one._try_among("max_blur_px", 250, NEVER)
    assert tried == ["max_blur_px"]
    one._try_among("max_blur_px", 2000, NEVER)
    assert tried == ["max_blur_px"] * 2


def test_a_search_ends_where_its_time_does_not_suffice_to_list_its_imagers(parts, catalog):
    wanted = mission(parts, min_swath_m=9.0)  # the one lens sees 1.42 m
    trials = Trials(wanted, catalog, POWER, "never", like=seek(wanted, catalog, POWER, generic="never", top=1))
    free = trials.without(["min_swath_m"])
    cut = trials.relaxer.seek(free, POWER, {"min_swath_m"}, deadline=Deadline(0.0, lambda: 1.0), enough=True).outcome
    assert not cut.best and not cut.complete and len(cut.imagers) == 0
    assert trials.relaxer.seek(free, POWER, {"min_swath_m"}, enough=True).outcome.best


def test_clearer_water_is_found_by_few_searches_where_imagers_are_few(monkeypatch):
    """A wall at 2 m in the second murkiest water of all; of a large catalogue it takes a time that depends on it."""
    text = (JOBS / "harbour-wall.yaml").read_text(encoding="utf-8")
    text = text.replace("visibility_m: 3.0", "water: 7C").replace("distance_m: 0.8", "distance_m: 2.0")
    wanted = prepared(load_mission(yaml.safe_load(text)), None, None, "central").without_gain_cap
    catalog, searches = load_catalog(wanted), [0]
    known = seek(wanted, catalog, POWER, generic="allow", top=1)
    run = Search.run

    def counted(self: Search) -> Outcome:
        searches[0] += 1
        return run(self)

    monkeypatch.setattr(Search, "run", counted)
    proof = certificate(known.selection, known.problem, known.outcome, POWER)
    trials = Trials(wanted, catalog, POWER, "allow", Deadline(12.0, lambda: float(searches[0])), like=known)
    assert [move.name for move in why_nothing(trials, proof).moves] == ["water"]


def test_what_gives_together_is_found_where_the_brightest_takes_too_long(parts, catalog, monkeypatch):
    """Without swath and pixel any design fits, 0 dB asked; the brightest of all is never known."""
    wanted = mission(parts, min_swath_m=9.0, max_gsd_mm=1e-3)
    seek_one = Relaxer.seek

    def slow(self: Relaxer, mission: Mission, goal: Objective, freed: set[str], **more: Any) -> Sought:
        late = {"deadline": Deadline(0.0, lambda: 1.0)} if goal is BRIGHT else {}
        return seek_one(self, mission, goal, freed, **more | late)

    monkeypatch.setattr(Relaxer, "seek", slow)
    trials = Trials(wanted, catalog, POWER, "never")
    found = first_of_all(trials, ["min_snr", "min_swath_m", "max_gsd_mm"])
    assert found is not None and found.outcome.best


def test_limits_that_give_together_are_drawn_in_as_far_as_their_hardware_reaches(parts, catalog):
    wanted = mission(parts, min_swath_m=9.0, min_snr_db=60.0)  # the design of least power has 0 dB
    trials = Trials(wanted, catalog, POWER, "never")
    found = seek(trials.without(["min_swath_m", "min_snr"]), catalog, POWER, generic="never", top=1)
    limits = {one.name: one.needed for one in least_set(trials, (["min_swath_m", "min_snr"], found))[0]}
    assert same_hardware(found, trials.with_limits(wanted, limits)).outcome.best
    for name, by in (("min_swath_m", 1.01), ("min_snr", 1.01)):
        assert not same_hardware(found, trials.with_limits(wanted, {**limits, name: by * limits[name]})).outcome.best


def test_all_imagers_are_asked_first_only_where_bounds_settle_what_is_asked(parts, catalog):
    """The lens sees 1.42 m, whatever the light; 0.25 px of blur leave light that must be tried."""
    for asked, tried in ((dict(min_swath_m=9.0), False), (dict(min_snr_db=30.0, max_blur_px=0.25), True)):
        wanted = mission(parts, **asked)
        known = seek(wanted, catalog, POWER, generic="never", top=1)
        assert not known.outcome.best and bool(known.outcome.account.evaluated) is tried
        assert Relaxer(wanted, catalog, "never", known).is_soon_known() is not tried


def asked_in_vain(wanted: Mission, catalog: Catalog, searches: float) -> WhyNothing:
    """Why nothing fits, as far as so many searches tell."""
    known, run, count = seek(wanted, catalog, POWER, generic="never", top=1), Search.run, [0]
    assert not known.outcome.best

    def counted(self: Search) -> Outcome:
        count[0] += 1
        return run(self)

    proof = certificate(known.selection, known.problem, known.outcome, POWER)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Search, "run", counted)
        clock = Deadline(searches, lambda: float(count[0]))
        return why_nothing(Trials(wanted, catalog, POWER, "never", clock, like=known), proof)


def fits(wanted: Mission, catalog: Catalog, **weaker: float) -> bool:
    """Whether something does, with other numbers asked."""
    asked = wanted.with_changes(requirements={**wanted.to_dict()["requirements"], **weaker})
    return bool(seek(asked, catalog, POWER, generic="never", top=1).outcome.best)


def test_what_the_last_rules_speak_of_is_asked_first_and_drawn_in(parts, catalog):
    """Of seven requirements and keys the one that is in the way is told within fewer searches than there are."""
    wanted = mission(parts, min_snr_db=70.0)
    (told,) = asked_in_vain(wanted, catalog, 6.0).relaxations
    assert told.name == "min_snr" and told.needed is not None
    assert fits(wanted, catalog, min_snr=None, min_snr_db=told.needed)


def test_requirements_that_nothing_meets_by_themselves_are_told_to_have_to_give(parts, catalog, monkeypatch):
    """Light for 120 dB no pixel holds, and parts for 100 USD are not sold, whatever else is asked."""
    wanted = mission(parts, min_snr_db=120.0).with_changes(limits={"cost": 100.0})
    why = asked_in_vain(wanted, catalog, 1e9)
    assert sorted(why.unmet) == ["cost", "min_snr"] and not why.relaxations
    dear = mission(parts).with_changes(limits={"cost": 100.0})
    assert asked_in_vain(dear, catalog, 1e9).unmet == ["cost"]
    monkeypatch.setattr(Relaxer, "is_soon_known", lambda self, freed=(): True)
    dark = mission(parts, min_snr_db=40.0, max_blur_px=0.5).with_changes(limits={"power_w": 6.0})
    assert asked_in_vain(dark, catalog, 1e9).unmet == []  # the lamp of 200 W has light for 40 dB


@pytest.mark.parametrize(
    ("lost", "evaluated", "suspects"),
    [
        ({"max_gsd_mm": 9, "light": 3, "cost": 5}, 0, ["cost", "min_snr"]),  # lamps decide last, most first
        ({"max_gsd_mm": 9, "min_swath_m": 7}, 0, ["min_swath_m", "max_gsd_mm"]),  # the last rule first
        ({"max_gsd_mm": 9}, 4, ["min_snr"]),  # tried in vain: no settings
        ({"mount": 9, "image_circle": 2}, 0, []),  # nobody asked for that
    ],
)  # fmt: skip
def test_likeliest_in_the_way_is_what_the_last_designs_fall_by(lost, evaluated, suspects):
    account = Account(100, evaluated, dict(lost))
    assert suspects_of(account, ["min_snr", "max_gsd_mm", "min_swath_m", "cost"]) == suspects


@pytest.mark.parametrize(("tally", "suspects"), [
    ({"max_gsd_mm": 3, "cost": 6}, ["min_snr"]),  # by themselves 6 of 10 imagers are too dear: no lamp makes them so
    ({"max_gsd_mm": 3, "cost": 4}, ["cost", "min_snr"]),  # with lamps more are
    ({}, ["cost", "min_snr"]),  # of a large catalogue no imagers are listed
])  # fmt: skip
def test_what_imagers_lose_by_themselves_is_not_their_last_fall(tally, suspects):
    account = Account(100, 0, {"max_gsd_mm": 30, "cost": 60, "light": 10})
    imagers = [None] * (10 - sum(tally.values()))
    made = of_lamps(SimpleNamespace(account=account, imagers=ListOf(imagers, SimpleNamespace(discarded=tally))))
    assert suspects_of(made, ["min_snr", "max_gsd_mm", "cost"]) == suspects


class ListOf(list):
    """Imagers with the tally of those that are not among them."""

    def __init__(self, given: list, tally: Any):
        super().__init__(given)
        self.tally = tally

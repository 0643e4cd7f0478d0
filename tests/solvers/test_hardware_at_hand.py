"""Hardware that comes near is asked of every other change; of a large catalogue too a few imagers are tried first."""

from __future__ import annotations

from contextlib import nullcontext
from types import SimpleNamespace

import pytest
from test_any_lighting import POWER, reef, searched

from uwopt.deadline import NEVER, Deadline
from uwopt.forward.assembly import load_catalog, selected
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.weakened import without
from uwopt.solvers.exact import search as searching
from uwopt.solvers.exact.account import Account
from uwopt.solvers.exact.certificate import certificate
from uwopt.solvers.infeasible import relaxer as relaxing
from uwopt.solvers.infeasible.freed_rules import OF_LAMPS
from uwopt.solvers.infeasible.least_change import CLOSER, in_rounds
from uwopt.solvers.infeasible.moves import Mover
from uwopt.solvers.infeasible.relaxer import Relaxer
from uwopt.solvers.infeasible.singles import Singles
from uwopt.solvers.infeasible.trials import BRIGHT, Trials
from uwopt.solvers.infeasible.why_nothing import draw_by_hardware, why_nothing
from uwopt.solvers.recommend import Sought, seek

DARK_DB = 38.0  # a little more than their lamps give in this water


def trials() -> Trials:
    """The reef with a little too little light."""
    wanted = reef(DARK_DB)
    return Trials(wanted, load_catalog(wanted), POWER, "never", like=searched(wanted))


def found_without(name: str) -> Sought:
    """What fits without one requirement."""
    free = without(reef(DARK_DB), name)
    assert free is not None
    return seek(free, load_catalog(free), BRIGHT if name == "min_snr" else POWER, generic="never", top=1)


@pytest.fixture
def no_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a moved key none ends, among a few imagers or among all."""
    cut = SimpleNamespace(best=[], complete=False, interrupted=False, account=Account())
    for name in ("_seek", "_among_few"):
        monkeypatch.setattr(Mover, name, lambda self, *_, **__: SimpleNamespace(outcome=cut))


def test_a_key_that_the_nearest_hardware_needs_moved_is_told_without_a_search(no_search):
    mover = Mover(trials())
    mover.try_hardware(found_without("min_snr"), NEVER)
    assert [(far.tried.key.name, far.value) for far in mover.helpful] == [("water", "I")]
    assert {one.key.name for one in mover.left} - {*OF_LAMPS} == {"altitude_m", "speed_m_s"}
    assert not mover.useless, "that one hardware does not fit proves nothing"


def test_a_requirement_without_which_known_hardware_fits_helps():
    singles = Singles(trials())
    open_before = dict(singles.useless)
    singles.try_hardware(found_without("mean_level"), NEVER)
    assert {one.name for one in singles.helpful} == {"min_snr", "mean_level"}
    assert all(one.found.outcome.best and searched(one.mission).outcome.best for one in singles.helpful)
    assert singles.useless == open_before


def test_what_hardware_does_is_told_where_no_search_of_a_moved_key_ends(no_search):
    asked = trials()
    like = asked.like
    assert like is not None
    why = why_nothing(asked, certificate(like.selection, like.problem, like.outcome, POWER))
    assert [(move.name, move.needed, move.nearest) for move in why.moves] == [("water", "I", False)]


def test_of_a_catalogue_too_large_to_list_a_few_pairs_are_tried_first(monkeypatch):
    monkeypatch.setattr(searching, "MOST_IMAGERS", 0)
    monkeypatch.setattr(relaxing, "FEW_PAIRS", 4)
    few = trials().relaxer
    free = found_without("min_snr").problem.mission
    assert few.are_too_many
    found = few.among_few(free, BRIGHT, {"min_snr"})
    assert found is not None and found.outcome.best
    assert found.outcome.account.total < searched(free).outcome.account.total


def test_what_helps_is_drawn_in_by_its_hardware_before_all_else_is_asked() -> None:
    """Once each, in a second at most; what is drawn in already, and what time does not reach, is left."""
    given_s: list[float] = []

    def step(turn: Deadline) -> None:
        given_s.append(turn.left_s)

    far, near = (SimpleNamespace(gap=gap, step=step) for gap in (1.0, 0.4))
    trials = SimpleNamespace(deadline=Deadline(9.0, lambda: 0.0), over=False, until_interrupted=nullcontext)
    singles = SimpleNamespace(trials=trials, helpful=[far, near])
    mover = SimpleNamespace(helpful=[SimpleNamespace(drawn=far), SimpleNamespace(drawn=None)])
    draw_by_hardware(singles, mover)
    assert given_s == [1.0, 1.0]
    trials.over = True
    draw_by_hardware(singles, mover)
    assert len(given_s) == 2


END_CAP, DOME = "blue-robotics-4-in-acrylic-end-cap-2026", "blue-robotics-4-in-dome-plastic-ring-2026"


def lasting(hours: float, *ports: str) -> Mission:
    """The reef for so long, behind these ports."""
    base = reef(20.0).to_dict()
    vehicle, limits = base["vehicle"] | {"duration_h": hours}, base["limits"] | {"storage_gb": 1e6}
    catalog = base["catalog"] | {"ports": list(ports or (END_CAP, DOME))}
    return load_mission(base | {"vehicle": vehicle, "catalog": catalog, "limits": limits})


def test_a_shorter_mission_may_have_parts_that_a_long_one_may_not():
    season, catalog = lasting(2000.0), load_catalog(reef(20.0))
    found = Relaxer(season, catalog, "never").seek(lasting(20.0), POWER, {"duration_h"}, enough=True)
    assert [len(selected(one, catalog, generic="never").ports) for one in (season, lasting(20.0))] == [1, 2]
    assert len(found.selection.ports) == 2


def test_a_mission_is_drawn_in_to_what_its_parts_last() -> None:
    """Acrylic is rated for two weeks: with hours alone moved that is what remains, whatever else the hardware does."""
    season = lasting(2000.0, END_CAP)
    catalog = load_catalog(season)
    rated_h = catalog.part(END_CAP).rated_time_h
    mover = Mover(Trials(season, catalog, POWER, "never", like=searched(season)))
    mover.try_all()
    in_rounds([move.drawn for move in mover.helpful if move.drawn is not None], NEVER)
    told = {move.name: move.told() for move in mover.helpful}
    assert rated_h == 336.0 and told["duration_h"].needed == pytest.approx(rated_h, rel=CLOSER)
    assert told["duration_h"].needed <= rated_h

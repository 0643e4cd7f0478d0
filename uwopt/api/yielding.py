"""A mission that nothing meets with all of good practice: what of it gives way, as little as possible, and its note."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from uwopt.api.practice_known import PracticeKnown, on_hardware
from uwopt.catalog.catalogue import Catalog
from uwopt.deadline import Deadline, effort_s
from uwopt.errors import MissionError
from uwopt.forward.assembly import load_catalog
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.mission.strictness import Asking
from uwopt.mission.yielding import SNR_AT, SNR_LESS, YIELDS, Yield, with_yields, yields_of
from uwopt.objectives.goal import goal_of
from uwopt.results.design import (
    PRACTICE_IN_VAIN,
    PRACTICE_UNTRIED,
    PRACTICE_WOULD_YIELD,
    PRACTICE_YIELDS,
    Design,
    Note,
)
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.infeasible.relaxer import ANY
from uwopt.solvers.one_hardware import best_of, problem_of
from uwopt.solvers.recommend import Sought, design_of, leans, seek, within_reach
from uwopt.solvers.warm.parts import PartIds
from uwopt.tolerances import LUCK
from uwopt.units import ratio_to_db

if TYPE_CHECKING:
    from uwopt.api.counting import Counts

YIELD_S = 20.0  # of work, for what has to give way where no time is given: what is recommended hangs on it
ASKED_S = 60.0  # of work, to learn whether anything has to, likewise
GIVEN_SHARE = 0.5  # of a time that is given
A_QUESTION = 0.25  # of what is left of that, for one that need not be answered: else the first dear proof takes it all
WITNESSES = 2  # hardware that fitted last, which is asked before all other
SUREST = 2  # hardware of those counted, for which it is asked what would make it hold
MORE_SHARE = 0.25  # of what is open that is asked about first: that something fits takes a fifth of that nothing does
TRIED_SET = 5  # of the best, of which one at least has to have settings
KnownToHold = dict[tuple[Any, ...], float]  # in how many scenarios hardware holds in a mission, 0: in less than so many
ROOM_DB = 1.0  # of signal to noise that is left where it can be: settings come in steps, and estimates may be wrong


@dataclass(frozen=True)
class GivenWay:
    """What of good practice has given way; where nothing fits with as little of it as may be, the proof of that."""

    yields: tuple[Yield, ...] = ()
    in_vain: Sought | None = None  # the search that proves it, where it was made here
    is_in_vain: bool = False  # whether it is proven
    is_least: bool = True  # whether less is known not to do; else time was over


def gives_way(
    mission: Mission, catalog: Catalog, like: Problem, deadline: Deadline, known: PracticeKnown | None = None
) -> GivenWay:
    """What of good practice has to give way so that something fits; nothing where that is not enough.

    They give way in their order until something fits; then all but the last come back one by one, the latest first, as
    far as something still fits. So no key that has given way could be kept beside those that are kept. For a decibel to
    spare, as what fits by a hair cannot be set, no key gives way that does so after the last of these, unless what was
    found indeed cannot be set.

    known : of missions like this; what it tells is not searched for, and what is found goes into it
    """
    known = PracticeKnown() if known is None else known
    patience = patience_of(deadline)
    lifted = mission.without_gain_cap
    every = yields_of(lifted)
    just = _least(lifted, every, catalog, like, patience, known, roomy=False)
    roomy = with_room(lifted) if just.yields else None
    if roomy is None:
        return just
    paths = {one.path for one in just.yields if not one.chooses_parts}
    last = max((place for place, one in enumerate(every) if one.path in paths), default=-1)
    few = tuple(one for place, one in enumerate(every) if place <= last or one in just.yields)
    with_more = _least(roomy, few, catalog, like, patience, known, roomy=True)
    if not with_more.yields and not _can_be_set(with_yields(lifted, just.yields), catalog, like, patience, known):
        with_more = _least(roomy, every, catalog, like, patience, known, roomy=True)
    return with_more if with_more.yields else just


def _can_be_set(
    mission: Mission, catalog: Catalog, like: Problem, deadline: Deadline, known: PracticeKnown
) -> bool:
    """Whether any of the best of a mission has settings to type in; so it is taken to be where time is over."""
    if known.can_be_set(mission):
        return True
    sought = seek(
        mission, catalog, goal_of(mission), generic=mission.catalog.generic_at_last, top=TRIED_SET, deadline=deadline,
        like=like, whole=True,
    )  # fmt: skip
    if not sought.outcome.best:
        return True
    for found in within_reach(sought, deadline):
        design = design_of(sought, found, deadline=deadline)
        if design.is_settable and (found is sought.outcome.best[0] or not leans(design)):
            if design.rounded is not None:
                known.set_in(mission)
            return True
    return False


def patience_of(deadline: Deadline, work_s: float = YIELD_S) -> Deadline:
    """How long it may be asked what has to give way: with less time more gives way than has to."""
    if math.isfinite(deadline.left_s):
        return deadline.part(GIVEN_SHARE)
    return deadline.or_after(work_s, effort_s)


def gives_way_alone(mission: Mission, deadline: Deadline, known: PracticeKnown | None = None) -> GivenWay:
    """As `gives_way`, of a mission that no search is known of."""
    known, catalog = PracticeKnown() if known is None else known, load_catalog(mission)
    return gives_way(mission, catalog, known.scenes_like(mission, catalog), deadline, known)


def gives_way_if_any(mission: Mission, catalog: Catalog, deadline: Deadline, known: PracticeKnown) -> tuple[Yield, ...]:
    """What gives way in a mission of which it is not known whether something meets all of good practice.

    Nothing where that is not answered in the time that it may take.
    """
    lifted, like = mission.without_gain_cap, known.scenes_like(mission, catalog)
    YieldTrials(lifted, catalog, like, patience_of(deadline, ASKED_S), known).fits((), part=1.0)
    return gives_way(mission, catalog, like, deadline, known).yields if known.fits(lifted) is False else ()


def with_room(mission: Mission) -> Mission | None:
    """A mission that asks for a little more signal to noise; None where it asks for none, or no more can be asked."""
    asked = mission.requirements
    if asked.min_snr is None:
        return None
    more = {"min_snr": None, "min_snr_db": float(ratio_to_db(asked.min_snr)) + ROOM_DB}
    try:
        return mission.with_changes(requirements={**mission.to_dict()["requirements"], **more})
    except MissionError:
        return None


def with_least_practice(mission: Mission, catalog: Catalog, like: Problem, deadline: Deadline) -> Sought | None:
    """Anything that fits where all gives way that may, or that nothing does; None where nothing may give way."""
    lifted = mission.without_gain_cap
    every = yields_of(lifted)
    return _anything(with_yields(lifted, every), catalog, like, deadline) if every else None


def _anything(mission: Mission, catalog: Catalog, like: Problem, deadline: Deadline) -> Sought:
    """A search for anything that fits, of all parts that the mission allows."""
    return seek(
        mission, catalog, ANY, generic=mission.catalog.generic_at_last, top=1, deadline=deadline, enough=True,
        like=like, whole=True,
    )  # fmt: skip


def _least(
    lifted: Mission, every: tuple[Yield, ...], catalog: Catalog, like: Problem, patience: Deadline,
    known: PracticeKnown, *, roomy: bool,
) -> GivenWay:  # fmt: skip
    """The least that gives way of all that may in a mission; nothing where no yielding is enough."""
    if not every:
        return GivenWay()
    asked = YieldTrials(lifted, catalog, like, patience, known)
    for guess in known.guesses(every, roomy=roomy):
        asked.fits(guess)
    if not asked.fits(every, part=1.0):
        known.last[roomy] = ()
        return GivenWay(in_vain=asked.in_vain.get(frozenset(every)), is_in_vain=frozenset(every) in asked.missing)
    asked.unanswered = False
    known.last[roomy] = _fewest(lifted, every, asked.fits)
    return GivenWay(known.last[roomy], is_least=not asked.unanswered)


@dataclass
class YieldTrials:
    """Questions whether something fits in a mission where some of good practice has given way, and what follows."""

    mission: Mission
    catalog: Catalog
    like: Problem
    patience: Deadline
    known: PracticeKnown
    fitting: list[frozenset[Yield]] = field(default_factory=list)
    missing: list[frozenset[Yield]] = field(default_factory=list)
    fitted: list[tuple[Problem, Found]] = field(default_factory=list)  # the last first
    in_vain: dict[frozenset[Yield], Sought] = field(default_factory=dict)  # searches that prove that nothing fits
    unanswered: bool = False  # whether it was not known of some in time
    before: list[PartIds] = field(init=False)  # hardware that fitted in earlier missions, the last first

    def __post_init__(self) -> None:
        self.before = [*self.known.hardware]

    def fits(self, given_way: Collection[Yield], part: float = A_QUESTION) -> bool:
        """Whether something fits where these have given way, as far as that is found in time; on known hardware always.

        part : of the time that is left, for a search of all parts
        """
        some = frozenset(given_way)
        if any(one <= some for one in self.fitting):
            return True
        if any(some <= one for one in self.missing):
            return False
        weaker = with_yields(self.mission, given_way)
        found = self.known.fits(weaker)
        if found is None:
            found = self._on_hardware(weaker) or self._anywhere(weaker, some, part)
        if found is None:
            self.unanswered = True
        else:
            (self.fitting if found else self.missing).append(some)
        return bool(found)

    def _on_hardware(self, weaker: Mission) -> bool | None:
        """Whether hardware fits that did in this mission or an earlier one; None: other hardware may."""
        if any(_fits_alone(problem, found, weaker) for problem, found in self.fitted[:WITNESSES]):
            return True
        for ids in self.before:
            sought = on_hardware(ids, weaker, self.catalog, self.like)
            if sought is not None and sought.outcome.best:
                self.before.remove(ids)  # it is among what fitted here
                self._take(sought)
                return True
        return None

    def _anywhere(self, weaker: Mission, some: frozenset[Yield], part: float) -> bool | None:
        """Whether anything of all parts fits; None where that is not known in time."""
        if self.patience.passed():
            return None
        patience = self.patience.part(part)
        sought = _anything(weaker, self.catalog, self.like, patience)
        self._take(sought)
        if sought.outcome.best:
            return True
        if sought.outcome.complete:
            self.in_vain[some] = sought
        return False if sought.outcome.complete else None

    def _take(self, sought: Sought) -> None:
        self.known.take(sought)
        self.fitted[:0] = [(sought.problem, found) for found in sought.outcome.best]


def _fits_alone(problem: Problem, found: Found, mission: Mission) -> bool:
    """Whether hardware that fits in a mission is known to in another one."""
    if mission.required_depth_m > problem.mission.required_depth_m:
        return False  # it may not be rated for that
    alone = problem_of(problem, found, mission=mission, scenes=problem.scenes_for(mission))
    return math.isfinite(best_of(alone, ANY))


def all_to_hold(asked: Mission, given_way: Collection[Yield]) -> tuple[Yield, ...]:
    """What has given way so that anything fits, and all that may give way so that it holds as often as is asked.

    That is reserves, colour, and what the frame may have less than its mean: certainty has not to be got by
    frames that are dark or soft at their edges.

    asked : the mission with all of good practice
    """
    return _in_order(given_way, [one for one in yields_of(asked) if one.for_certainty])


def fewest_to_hold(
    asked: Mission, given_way: Collection[Yield], every: Sequence[Yield], counts: Counts, deadline: Deadline,
    known: KnownToHold,
) -> tuple[Yield, ...] | None:  # fmt: skip
    """The least that has to give way so that some hardware holds as often as is asked, where with `every` it does.

    What gave way so that anything fits comes back, the latest first, where that is not needed beside the rest. None
    where no hardware that was counted can be recommended with all of them either: it tells nothing of less.

    asked : the mission with all of good practice
    given_way : what of it has given way so that anything fits
    every : that and what else may give way, the last of each key
    counts : of hardware where some of that has given way
    """
    base = with_yields(asked, given_way)
    patience = patience_of(deadline)
    last = {one.path: YIELDS.index(one) for one in every}
    further = tuple(
        one for one in yields_of(asked)
        if YIELDS.index(one) <= last.get(one.path, -1)
        and with_yields(asked, _in_order(given_way, [one])).to_dict() != base.to_dict()
    )  # fmt: skip

    def held(gone: Collection[Yield], least: float) -> float:
        return most_held(counts, with_yields(asked, gone), known, least)

    least = min(share_to_hold(counts), held(_in_order(given_way, further), 0.0))
    if not least:
        return None

    def holds(more: Collection[Yield]) -> bool:
        return not patience.passed() and held(_in_order(given_way, more), least) >= least

    few = _in_order(given_way, _fewest(base, further, holds))
    for one in reversed([one for one in few if one in given_way]):
        rest = tuple(other for other in few if other is not one)
        if not patience.passed() and held(rest, least) >= least:
            few = rest
    return few


def share_to_hold(counts: Counts) -> float:
    """Share of the scenarios of a choice in which hardware has to hold to do so as often as asked in others too."""
    share = counts.seen.share
    return min(share + LUCK * math.sqrt(share * (1.0 - share) / counts.seen.scenarios.count), 1.0)


def most_held(counts: Counts, mission: Mission, known: KnownToHold, least: float = 0.0) -> float:
    """In how many of the same scenarios any of the hardware that held most often holds in a mission like that.

    As it can be recommended: at a stop at which it fits at likeliest values as well.

    known : what is counted so of hardware that is counted again, for the same mission
    least : whether it does in as many is all that is asked; 0: in how many
    """
    from uwopt.solvers.confidence.counted import names
    from uwopt.solvers.confidence.eased import MovedKeys

    problem, goal, seen, most = counts.sought.problem, counts.sought.goal, counts.seen, 0.0
    if mission.required_depth_m > problem.mission.required_depth_m:
        return 0.0  # none may be rated for that
    enough = least or share_to_hold(counts)
    asks = Asking.of(mission)
    for one in sorted(seen.tried, key=lambda one: one.held, reverse=True)[:SUREST]:
        key = names(problem, one.found), asks
        if key not in known and (*key, least) in known:
            continue
        if key not in known:
            held = MovedKeys(problem, goal, seen.scenarios, least).held_as_set(mission, one.found)
            known[key if held >= least else (*key, least)] = held
        most = max(most, known.get(key, 0.0))
        if most >= enough:
            break
    return most


def _fewest(
    mission: Mission, known: tuple[Yield, ...], fits: Callable[[Collection[Yield]], bool]
) -> tuple[Yield, ...]:
    """The first of these with which it fits, but for what is not needed then; with all of them it does."""
    few, enough = 0, len(known)  # so many of the first do not do, and so many do
    while enough - few > 1:
        middle = enough - max(1, round(MORE_SHARE * (enough - few)))
        few, enough = (few, middle) if fits(known[:middle]) else (middle, enough)
    given_way = known[:enough]
    for one in reversed(known[: enough - 1]):
        rest = tuple(other for other in given_way if other is not one)
        overruled = with_yields(mission, rest).to_dict() == with_yields(mission, given_way).to_dict()
        if overruled or fits(rest):
            given_way = rest
    return given_way


def _in_order(given_way: Collection[Yield], more: Collection[Yield]) -> tuple[Yield, ...]:
    """All of them as they give way, but for those that a later one overrules."""
    every = [one for one in YIELDS if one in given_way or one in more]
    last = {one.path: one for one in every}
    return tuple(one for one in every if last[one.path] is one)


def less_practice_note(weakest: Sought) -> Note:
    """That something fits where all of good practice gives way that may, that even so nothing does, or neither."""
    if weakest.outcome.best:
        text = "with good practice relaxed something fits: uwopt solve relaxes what it must, and says what"
        return Note(PRACTICE_WOULD_YIELD, "practice", text)
    if not weakest.outcome.complete:
        text = (
            "whether something fits with good practice relaxed is not known in this time: what would help is told of "
            "the mission with all of it, and uwopt solve may relax some of it"
        )
        return Note(PRACTICE_UNTRIED, "practice", text)
    text = (
        "nothing fits even with good practice relaxed as far as uwopt may; the changes below are for the mission so "
        "relaxed; once one is made, uwopt solve relaxes only what it must"
    )
    return Note(PRACTICE_IN_VAIN, "practice", text)


def in_vain_note() -> Note:
    """That nothing fits with as little of good practice as may be, where nothing else is told of that."""
    return Note(PRACTICE_IN_VAIN, "practice", "nothing fits even with good practice relaxed as far as uwopt may")


def reached_text(values_db: Iterable[float | None], where: str) -> str:
    """` (95 % of which reach 21 dB at the worst distance)`: the least of what is known of 95 % of the frame; or ""."""
    known = [float(value) for value in values_db if value is not None]
    return f" (95 % of which reach {min(known):.1f} dB {where})" if known else ""


def yield_notes(
    given_way: Collection[Yield], winner: Design | None = None, *, to_hold: bool = False
) -> list[Note]:
    """What has given way, and what the winner's darkest places get where the SNR holds in the mean.

    to_hold : whether any of it did so that something holds as often as is asked
    """
    if not given_way:
        return []
    scenes = [] if winner is None else winner.as_set.scenes
    worst = [one.value for scene in scenes for one in scene.margins if one.requirement == "min_snr_db"]
    usual = [scene.figures.get("snr_db_p05") for scene in scenes]
    of_frame = {
        SNR_LESS: reached_text(worst, "at the worst distance"), SNR_AT: reached_text(usual, "at the middle distance"),
    }  # fmt: skip
    words = (one.words + of_frame.get(one.key, "") for one in given_way)
    often = " as often as is asked" if to_hold else ""
    text = f"nothing meets all of good practice{often}; what was relaxed: " + "; ".join(words)
    return [Note(PRACTICE_YIELDS, ", ".join(one.path for one in given_way), text)]

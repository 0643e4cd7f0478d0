"""Hardware that is likely to hold as often as asked, counted: of what is sold, or where that does not, of all parts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from uwopt.api.common import halfway
from uwopt.api.searching import leaves_out_generic, of_all_parts
from uwopt.api.watch import STAGES, Watch
from uwopt.deadline import Deadline, OutOfTimeError, effort_s, unheard
from uwopt.forward.problem import Problem
from uwopt.solvers.beside import ahead
from uwopt.solvers.confidence.counted import Counted, Looked, rank
from uwopt.solvers.confidence.roomy import LESS_WORSE
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.confidence.search import count_near, look
from uwopt.solvers.exact.lightings import Lighting
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.one_hardware import among
from uwopt.solvers.recommend import Sought

ALL_PARTS = "parts to be made that may hold more often"  # where there is no time for them
CERTAINTY_S = 15.0  # of work, where no time is given
SOLD_SHARE = 0.7  # of it, until parts to be made are looked at where those that are sold do not hold
NEAR_SHARE = 0.5  # of what is left then, for what differs by a part from what is sold, before parts are made
MADE_S = 25.0  # of work, where no time is given, for parts to be made and the most certain of what is sold
MADE_SHARE = 0.6  # of it, or of what is left of the time, for these: the rest is for what is sold
MORE_OFTEN = 0.05  # of the scenarios, in which more parts to be made must hold where some have to be made anyway
KNOWN = 4  # hardware of a mission like this that is counted first


@dataclass(frozen=True)
class Counts:
    """What was counted for a mission; what is compared with it later is counted too."""

    sought: Sought  # the search that its places are of
    seen: Looked
    of_all_parts: bool = False  # whether parts to be made were taken though what is sold fits at likeliest values


def counts_of(
    sought: Sought, watch: Watch, before: Counts | None = None, given: Deadline | None = None
) -> Counts | None:  # fmt: skip
    """How often hardware holds that is likely to at the mission's confidence; None where there is no time.

    before : what was counted for a mission that differs in a few keys: its waters and its hardware are known
    given : the time that a person gives, none maybe: then parts to be made have `MADE_S` of their own
    """
    asked = sought.problem.mission.confidence
    like = None if before is None else waters_of(before, sought.problem)
    known = [] if before is None else known_hardware(before, sought.problem)
    others = leaves_out_generic(sought)

    def of_sold(patience: Deadline) -> Looked:
        first = patience.part(SOLD_SHARE) if others else patience
        return look(sought, asked, first, watch.progress, with_room=others, like=like, known=known)

    seen = watch.within("certainty", of_sold, None)
    if seen is None:
        return None
    if others and seen.held < seen.share:
        count_near(seen, watch.deadline, NEAR_SHARE)
    if others and seen.held < seen.share:
        patience = watch.deadline if given is None else given.or_after(MADE_S, effort_s)
        surer, seen = surer_or_surest(sought, seen, watch.until(patience), before)
        if surer is not None:
            return surer
    return Counts(sought, seen)


def worth_making(sought: Sought, seen: Looked) -> float:
    """Share of the scenarios in which more parts to be made must hold to be taken for what was counted."""
    if sought.selection.generic == "never":
        return halfway(seen.held, seen.share)
    return min(seen.held + MORE_OFTEN, seen.share)


def waters_of(before: Counts, problem: Problem) -> Scenarios | None:
    """Scenarios of a mission like this as it sees them; None where its water, heights or doubts are others."""
    mission, old = problem.mission, before.sought.problem
    same = mission.doubt == old.mission.doubt and mission.seed == old.mission.seed
    if not same or old.scenes_for(mission) is None:
        return None
    return before.seen.scenarios.seen_by(mission, problem.scenes)


def known_hardware(before: Counts, problem: Problem) -> list[Found]:
    """What was best in a mission like this, or held most often where none did, by its places among these parts."""
    made, mounts = list[Found](), problem.mounts
    low, high = problem.count_range
    for one in sorted(before.seen.tried, key=lambda one: rank(one, before.seen.share))[:KNOWN]:
        try:
            found = among(problem, one.found, before.sought.problem)
        except ValueError:
            continue
        if found.lighting.mount in mounts and low <= found.count <= high:
            optics = int(problem.lights.optics_index[found.light])
            lighting = Lighting(optics, mounts.index(found.lighting.mount), found.lighting.mount)
            made.append(replace(found, lighting=lighting))
    return made


def surer_or_surest(
    sold: Sought, seen: Looked, watch: Watch, before: Counts | None = None
) -> tuple[Counts | None, Looked]:
    """Parts to be made that hold as often as asked; else the surest of what is sold, looked for at the same time."""
    patience = watch.deadline
    made_s, rest_s = (share * patience.left_s for share in (MADE_SHARE, 1.0 - MADE_SHARE))

    def surest() -> tuple[list[Counted], bool, dict[Any, Any]]:
        """What is counted then, and how light changes with the water: all else of the scenarios is known here."""
        rest = replace(patience, end_s=patience.clock() + rest_s)  # whoever works it out
        made = rest.within(STAGES["certainty"], lambda: look(sold, seen.asked, rest, unheard, before=seen), seen)
        return made.tried, made.complete, made.scenarios.responses

    with ahead(surest, lists=[patience.left_out]) as further:
        surer = surer_of_all_parts(sold, seen, watch.until(patience.at_most(made_s)), before)
        if surer is not None:
            return surer, seen
        with watch.stage("certainty"):
            tried, complete, responses = further()
    seen.scenarios.responses.update(responses)
    return None, replace(seen, tried=tried, complete=complete)


def surer_of_all_parts(sought: Sought, sold: Looked, watch: Watch, before: Counts | None = None) -> Counts | None:
    """The same search with parts to be made, and what was counted of them: where only they hold as often as asked.

    Or where they come at least halfway to that from what is sold; where some kinds have to be made anyway, where they
    hold more often at all. None where what is sold holds as often, no other parts do so much better, none were left
    out, or time is out.
    """
    worth = worth_making(sought, sold)
    if sold.held >= sold.share or not leaves_out_generic(sought):
        return None

    def found() -> Counts | None:
        with watch.timed("search_generic"):
            every = of_all_parts(sought, watch, whole=True)
        if not every.outcome.complete:
            raise OutOfTimeError
        with watch.stage("certainty"):
            like = sold.scenarios.seen_by(every.problem.mission, every.problem.scenes)
            known = [] if before is None else known_hardware(before, every.problem)
            # hardware with less room than in half of the scenarios may do where it need not hold in as many
            seen = look(
                every, sold.asked, watch.deadline, watch.progress, with_room=worth > LESS_WORSE[0], like=like,
                known=known,
            )
        return Counts(every, seen, of_all_parts=True) if seen.held >= worth else None

    return watch.deadline.within(ALL_PARTS, found, None)

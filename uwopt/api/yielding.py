"""A mission that nothing meets with all of good practice: what of it gives way, as little as possible, and its note."""

from __future__ import annotations

from collections.abc import Collection

from uwopt.catalog.catalogue import Catalog
from uwopt.deadline import Deadline, effort_s
from uwopt.errors import MissionError
from uwopt.forward.assembly import Generic
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.mission.yielding import SNR_AT, SNR_LESS, Yield, with_yields, yields_of
from uwopt.results.design import PRACTICE_YIELDS, Design, Note
from uwopt.solvers.explain.relaxed import ANY
from uwopt.solvers.recommend import seek
from uwopt.units import ratio_to_db

YIELD_S = 20.0  # of work, for what has to give way: what is recommended hangs on it
ROOM_DB = 1.0  # of signal to noise that is left where it can be: settings come in steps, and estimates may be wrong


def gives_way(
    mission: Mission, catalog: Catalog, like: Problem, deadline: Deadline
) -> tuple[Yield, ...]:
    """What of good practice has to give way so that something fits; nothing where that is not enough.

    They give way in their order until something fits; then all but the last come back one by one, the latest first, as
    far as something still fits, with a decibel to spare if anything does: what fits by a hair cannot be set. So no key
    that has given way could be kept beside those that are kept.
    """
    patience = deadline.or_after(YIELD_S, effort_s).at_most(YIELD_S)
    lifted = mission.without_gain_cap
    roomy = with_room(lifted)
    return (roomy is not None and _least(roomy, catalog, like, patience)) or _least(lifted, catalog, like, patience)


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


def _least(lifted: Mission, catalog: Catalog, like: Problem, patience: Deadline) -> tuple[Yield, ...]:
    """The least that gives way of a mission; nothing where no yielding is enough."""
    generic: Generic = "never" if lifted.catalog.generic == "never" else "allow"

    def fits(given_way: Collection[Yield]) -> bool:
        weaker = with_yields(lifted, given_way)
        found = seek(
            weaker, catalog, ANY, generic=generic, top=1, deadline=patience, enough=True, like=like
        )
        return bool(found.outcome.best)

    known = yields_of(lifted)
    if not known or not fits(known):
        return ()
    few, enough = 0, len(known)  # so many of the first do not do, and so many do
    while enough - few > 1 and not patience.passed():
        middle = (few + enough) // 2
        few, enough = (few, middle) if fits(known[:middle]) else (middle, enough)
    given_way = known[:enough]
    for one in reversed(known[: enough - 1]):
        rest = tuple(other for other in given_way if other is not one)
        overruled = with_yields(lifted, rest).to_dict() == with_yields(lifted, given_way).to_dict()
        if overruled or (not patience.passed() and fits(rest)):
            given_way = rest
    return given_way


def yield_notes(given_way: Collection[Yield], winner: Design | None = None) -> list[Note]:
    """What has given way, and what the winner's darkest places get where the SNR holds in the mean."""
    if not given_way:
        return []
    reached = [scene.figures.get("snr_db_p05") for scene in winner.as_set.scenes] if winner is not None else []
    known = [float(value) for value in reached if value is not None]
    of_frame = f" (95 % of which reach {min(known):.0f} dB)" if known else ""
    words = (one.words + (of_frame if one.key in (SNR_AT, SNR_LESS) else "") for one in given_way)
    text = "nothing meets all of good practice; what has given way: " + "; ".join(words)
    return [Note(PRACTICE_YIELDS, ", ".join(one.path for one in given_way), text)]

"""What a requirement costs as a whole: the best system where it is not asked for, beside the one where it is.

Nothing that is allowed now is forbidden then, so that the best is no worse; a search for something better, below what
is known, says by how much, or that nothing is.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from uwopt.catalog.choose import ToBeMade
from uwopt.deadline import Deadline
from uwopt.mission.weakened import RELAXABLE, without
from uwopt.solvers.explain.prices import SAME_REL
from uwopt.solvers.infeasible.relaxer import Relaxer
from uwopt.solvers.recommend import Sought

TURN = 0.4  # of the time left: what one search may take of it


def without_each(
    sought: Sought, keys: Sequence[str], generic: ToBeMade, deadline: Deadline
) -> Iterator[tuple[str, float]]:
    """Requirements by their keys, and the objective as it is reported of the best system without each, as time allows.

    sought : a complete search, whose parts, light and imagers are known
    """
    goal = sought.goal
    mission, best = sought.problem.mission, sought.outcome.best[0].minimised
    relaxer, ceiling = Relaxer(mission, sought.selection.catalog, generic, sought), best - goal.step(SAME_REL, best)
    for name, (section, key, _) in RELAXABLE.items():
        weaker = without(mission, section, key) if key in keys else None
        if weaker is None or deadline.passed():
            continue
        found = relaxer.seek(
            weaker, goal, {name}, deadline=deadline.at_most(TURN * deadline.left_s), ceiling=ceiling
        ).outcome  # fmt: skip
        if found.interrupted:
            raise KeyboardInterrupt
        if found.complete:
            yield key, goal.reported(found.best[0].minimised if found.best else best)

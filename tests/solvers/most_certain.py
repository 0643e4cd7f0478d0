"""What is recommended of the hardware that is likely to hold, without the rest of `solve`."""

from __future__ import annotations

from uwopt.deadline import NEVER, Deadline, Progress, unheard
from uwopt.solvers.confidence import search
from uwopt.solvers.confidence.search import Certain
from uwopt.solvers.recommend import Sought


def most_certain(
    sought: Sought, asked: float | str, deadline: Deadline = NEVER, report: Progress = unheard
) -> Certain | None:
    """The best that holds in the share of scenarios asked for; else that which holds most often."""
    looked = search.look(sought, asked, deadline, report)
    return search.best_counted(looked, deadline, report)

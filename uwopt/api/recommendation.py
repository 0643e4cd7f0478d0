"""What is recommended for a mission, before it becomes a result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from uwopt.mission.mission import Mission
from uwopt.mission.yielding import Yield
from uwopt.results.certainty import Confidence
from uwopt.results.design import Design
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.recommend import Sought

if TYPE_CHECKING:
    from uwopt.api.counting import Counts
    from uwopt.solvers.confidence.search import Certain


@dataclass(frozen=True)
class Recommendation:
    """What is recommended for a mission, before anything else is told of it."""

    mission: Mission  # with what of good practice has given way
    sought: Sought  # with what is recommended at its head
    proven: Outcome  # of the search at likeliest values
    design: Design
    listed: Sought | None = None  # the search whose next best are listed beside it; None: none are
    counted: Confidence | None = None  # how often it holds, where that was counted
    counts: Counts | None = None  # of all hardware that it was chosen of in the doubt
    choice: Certain | None = None  # of that hardware, with the scenarios that it was made on
    is_best: bool = True  # whether nothing that holds as often can be better, as far as that was counted
    given_way: tuple[Yield, ...] = ()
    to_hold: bool = False  # whether any of it did so that something holds as often as is asked
    cut: bool = False  # whether a person wants no more

    @property
    def is_proven(self) -> bool:
        """Whether the search that it is of was completed."""
        return self.sought.outcome.complete

    @property
    def is_cut_short(self) -> bool:
        """Whether a person wants no more, of this or of a search for it."""
        return self.cut or self.sought.outcome.interrupted

    @property
    def is_enough(self) -> bool:
        """Whether it holds as often as is asked, as far as that was counted."""
        return self.counted is None or self.counted.enough

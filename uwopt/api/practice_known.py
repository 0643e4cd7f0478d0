"""What is known of practice in earlier missions: what fits where, on which hardware, and what gave way last.

Where one mission asks for no less than another, what meets it meets the other; so a table of many missions, of which
each is asked what of good practice has to give way, makes few searches of all parts, and answers each as if it were
alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from uwopt.catalog.catalogue import Catalog
from uwopt.forward.assembly import build_problem, selected
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.mission.strictness import Asking
from uwopt.mission.yielding import Yield
from uwopt.solvers.infeasible.relaxer import ANY
from uwopt.solvers.recommend import Sought
from uwopt.solvers.warm.parts import PartIds, ids_of, only

MOST_MISSIONS = 200  # that something meets, or nothing does
MOST_HARDWARE = 4


@dataclass
class PracticeKnown:
    """Missions that something meets, or nothing, or something that can be set; hardware and keys of the last ones."""

    met: list[Asking] = field(default_factory=list)
    missed: list[Asking] = field(default_factory=list)
    settable: list[Asking] = field(default_factory=list)
    hardware: list[PartIds] = field(default_factory=list)
    last: dict[bool, tuple[Yield, ...]] = field(default_factory=dict)  # with room for a little more light, or without
    like: Problem | None = None  # of the last mission, whose scenes may be those of the next

    def fits(self, mission: Mission) -> bool | None:
        """Whether something fits in a mission; None where no earlier one tells."""
        asks = Asking.of(mission)
        if any(one.asks_no_more(asks) for one in self.missed):
            return False
        return True if any(asks.asks_no_more(one) for one in self.met) else None

    def scenes_like(self, mission: Mission, catalog: Catalog) -> Problem:
        """Tables whose scenes are those of a mission: of an earlier one, where it has the same."""
        if self.like is None or self.like.scenes_for(mission) is None:
            self.like = build_problem(mission, selected(mission, catalog, generic=mission.catalog.generic_at_last))
        return self.like

    def can_be_set(self, mission: Mission) -> bool:
        """Whether something that can be set is known to fit in a mission."""
        asks = Asking.of(mission)
        return any(asks.asks_no_more(one) for one in self.settable)

    def set_in(self, mission: Mission) -> None:
        """Something that fits in a mission can be set."""
        self.settable = [*self.settable[1 - MOST_MISSIONS :], Asking.of(mission)]

    def take(self, sought: Sought) -> None:
        """What a search for anything that fits has shown."""
        asks, outcome = Asking.of(sought.problem.mission), sought.outcome
        if outcome.best:
            self.met = [*self.met[1 - MOST_MISSIONS :], asks]
            ids = ids_of(sought.problem, outcome.best[0])
            self.hardware = [ids, *(one for one in self.hardware if one != ids)][:MOST_HARDWARE]
        elif outcome.complete:
            self.missed = [*self.missed[1 - MOST_MISSIONS :], asks]

    def guesses(self, every: Sequence[Yield], *, roomy: bool) -> Iterator[tuple[Yield, ...]]:
        """What gave way last and that which is just not enough then: asked first, they are most often the answer."""
        last = self.last.get(roomy, ())
        if last and all(one in every for one in last):
            yield last
            yield tuple(every[: every.index(last[-1])])


def on_hardware(ids: PartIds, mission: Mission, catalog: Catalog, like: Problem) -> Sought | None:
    """A search of a mission on known hardware alone; None where it does not allow that."""
    few = only(selected(mission, catalog, generic=mission.catalog.generic_at_last), ids)
    if not (few.completes if "complete" in ids else few.cameras and few.lenses and few.ports):
        return None
    problem = build_problem(mission, few, scenes=like.scenes_for(mission))
    return Sought.of(few, problem, ANY, enough=True, whole=True)

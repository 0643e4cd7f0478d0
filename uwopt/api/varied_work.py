"""What all parts of a table of `uwopt.whatif` share: its points, what gives way at all of them, switches, a spider."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from uwopt.api.search_notes import patience_warnings
from uwopt.api.varied import At, Switches, Systems, VariedGrid
from uwopt.api.yielding import gives_way_alone
from uwopt.deadline import Deadline, Progress, processor_s, unheard
from uwopt.errors import MissionError
from uwopt.forward.scene_checks import check_physical
from uwopt.mission.mission import Mission
from uwopt.mission.varying import Value, Varied, VariedMission
from uwopt.mission.yielding import Yield, with_given_way, yields_of
from uwopt.objectives.objective import Objective
from uwopt.results.design import Note
from uwopt.results.whatif import SpiderLine, Switch
from uwopt.solvers.warm.searches import Warm
from uwopt.units import unit_suffix

SPIDER_FACTORS = (0.8, 0.9, 1.0, 1.1, 1.2)
MOST_ASKED = 2  # points of which it is asked what gives way, where the mission as it stands has no system
SWITCHES_S = 30.0  # of the processor, for where systems take over, where no time is given


@dataclass
class Work:
    """What all parts of one table share."""

    base: VariedMission
    goal: Objective
    systems: Systems
    deadline: Deadline
    say: Progress = unheard  # how far it is
    certain: bool = False  # whether hardware has to hold in the doubt
    n_searches: int = 0
    notes: list[Note] = field(default_factory=list)
    given_way: tuple[Yield, ...] | None = None  # of good practice, for the mission as it stands; None: not asked yet
    fits_nothing: bool = False  # whether the mission as it stands has no system that was found, even with less of that
    asked_at: int = 0  # points of which that was asked instead
    relaxed_at: str = ""  # that of which it gives way, where it is not the mission as it stands
    to_hold: bool = False  # whether any of it gives way so that something holds as often as is asked
    told: Callable[[VariedGrid, At], object] = lambda grid, at: None  # of each point that is solved
    is_line: bool = False  # of a table that begins again as a whole
    patience_share: float = 1.0  # of the time for where systems take over
    began_s: float = field(default_factory=time.perf_counter)

    def grid_of(self, keys: Sequence[Varied]) -> VariedGrid:
        """A grid over keys, with a sweep of its own."""
        made = VariedGrid(self.base, tuple(keys), self.systems, Warm(self.deadline))
        if self.certain:
            from uwopt.api.certain_points import CertainPoints

            made.certain = CertainPoints(self.systems, self.deadline).point
        return made

    def solve_all(self, grid: VariedGrid) -> None:
        """Every point of a grid, until the time is over.

        Where nothing fits at one, it is asked whether good practice has to give way for the mission as it stands, and
        if so what does at every point: so all points ask for the same, and what `solve` answers is among them. Where
        that has no system either way, what gives way for the first of the points that has one so, of the first few.
        """
        order = grid.order()
        for number, at in enumerate(order):
            if self.deadline.passed():
                break
            values = ", ".join(f"{key.name} {key_value_text(value)}" for key, value in zip(grid.keys, at, strict=True))
            self.say(number / len(order), f"point {number + 1} of {len(order)}: {values}")
            point = grid.solve(at)
            self.told(grid, at)
            if point.status == "infeasible" and not self.given_way:
                if self.given_way is None:
                    self.ask_practice(grid)
                if self.fits_nothing and self.asked_at < MOST_ASKED:
                    self.ask_practice_at(grid, at, values)
                if grid.given_way and not self.is_line:
                    self.solve_all(grid)
                if grid.given_way:
                    return
        self.n_searches += grid.warm.n_searches
        if not self.is_line:
            self.tell_left_out(grid)

    def tell_left_out(self, grid: VariedGrid) -> None:
        """How many points there was no time for."""
        order = grid.order()
        if left := sum(at not in grid.points for at in order):
            self.deadline.left_out.append(f"{left} of {len(order)} points")

    def ask_practice(self, grid: VariedGrid) -> None:
        """What of good practice gives way for the mission as it stands, in a grid that begins again if any does."""
        self.given_way, mission = (), self.base.base
        if yields_of(mission):
            self.say(0.0, "what of good practice has to be relaxed")
            self.fits_nothing = self.relax(grid, mission)

    def ask_practice_at(self, grid: VariedGrid, at: At, values: str) -> None:
        """What of good practice gives way at a point, in a grid that begins again if any does."""
        self.asked_at += 1
        self.say(0.0, f"what of good practice has to be relaxed at {values}")
        self.relax(grid, grid.mission(at))
        if self.given_way:
            self.relaxed_at = values

    def relax(self, grid: VariedGrid, mission: Mission) -> bool:
        """Let what gives way in `solve` of a mission do so in a grid, which begins again if any does.

        Whether that mission has no system even so.
        """
        if self.certain:
            from uwopt.api.certain_points import gives_way_with_certainty

            self.given_way, self.to_hold, in_vain = gives_way_with_certainty(mission, self.deadline)
        else:
            answer = grid.warm.best(mission)
            nothing = answer.found is None and answer.complete
            self.given_way = gives_way_alone(mission, self.deadline).yields if nothing else ()
            in_vain = nothing and not self.given_way
        if self.given_way:
            grid.begin_again(self.given_way)
        return in_vain

    def switches(self, grid: VariedGrid) -> list[Switch]:
        """Where other systems take over."""
        if self.certain:  # between points another search would have to count
            between = Switches(grid, self.deadline, self.say)
            return [*(between.coarse(k, a, b) for k, a, b in grid.changes()), *between.at_rims(searched=False)]
        by_itself = math.isfinite(self.deadline.end_s)
        patience = self.deadline if by_itself else Deadline.after(self.patience_share * SWITCHES_S, processor_s)
        before = grid.warm.n_searches
        made = Switches(grid, patience, self.say).all()
        self.n_searches += grid.warm.n_searches - before
        self.notes += [] if by_itself else patience_warnings(patience, SWITCHES_S, self.began_s)
        return made

    def spider(self, lines: list[SpiderLine]) -> None:
        """Each stated quantity alone, into a list that an interruption leaves as it is."""
        stated = [*self.base.stated_numbers()]
        signs = tuple(key.stricter(self.base.base) * (1 if float(key.values[0]) > 0 else -1) for key in stated)
        warm = Warm(self.deadline)
        if self.given_way is None:
            self.ask_practice(VariedGrid(self.base, (), self.systems, warm))
        for number, (key, sign) in enumerate(zip(stated, signs, strict=True)):
            self.say(number / len(stated), f"{key.section}.{key.name}, 20 % either way")
            if self.deadline.passed():
                self.deadline.left_out.append(f"{len(stated) - number} of {len(stated)} quantities")
                break
            lines.append(self._spider_line(warm, key, sign))
        self.n_searches += warm.n_searches

    def _spider_line(self, warm: Warm, key: Varied, sign: int) -> SpiderLine:
        """One quantity; what the mission does not allow is no point."""
        factors = sorted(SPIDER_FACTORS, reverse=sign < 0)
        points = []
        for factor in [1.0, *(factor for factor in factors if factor != 1.0)]:  # what is listed there serves all
            try:
                mission = self.base.base if factor == 1.0 else self.base.scaled(key, factor)
                mission = with_given_way(mission, self.given_way or ())
                check_physical(mission)
            except MissionError:
                continue
            answer = warm.best(mission, ahead=factor == 1.0 or sign * (factor - 1.0) < 0.0)
            points.append(self.systems.point((factor,), answer))
        points.sort(key=lambda point: float(point.values[0]))
        return SpiderLine(f"{key.section}.{key.name}", key_unit(key, self.base.base), float(key.values[0]), points)


def key_value_text(value: Value) -> str:
    """A value in a line."""
    return value if isinstance(value, str) else f"{value:.6g}"


def key_unit(key: Varied, mission: Mission) -> str:
    """The unit of a key's values."""
    if not key.is_numeric:
        return ""
    return mission.limits.currency if key.name == "cost" else unit_suffix(key.name).lstrip("_")

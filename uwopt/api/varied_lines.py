"""Parts of a table of `uwopt.whatif` that have one value of a key, such as a water: solved side by side."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

from uwopt.api.varied import At, Systems, VariedGrid, murkiness
from uwopt.api.varied_work import Work
from uwopt.api.watch import Watch
from uwopt.mission.varying import Varied
from uwopt.results.design import Note
from uwopt.results.whatif import Switch, WhatIfPoint, WinningSystem
from uwopt.solvers.beside import SHARES, side_by_side, tell
from uwopt.solvers.warm.parts import PartIds

PRACTICE = ("given_way", "fits_nothing", "asked_at", "relaxed_at", "to_hold")  # what `Work` knows of it
POINTS_SHARE = 0.75  # of a line's time, for its points; the rest for where systems take over


class LineShare(NamedTuple):
    """How far a line of a table is."""

    line: int
    share: float
    what: str


class LinePoint(NamedTuple):
    """A point of a line that is solved, and what is best there."""

    at: At
    point: WhatIfPoint
    system: tuple[WinningSystem, PartIds] | None


@dataclass(frozen=True)
class SolvedLine:
    """What is known of a line of a table, or of what lies between two, beside the points."""

    systems: list[tuple[WinningSystem, PartIds]]  # in the order in which they were met
    switches: list[Switch]  # between these
    notes: list[Note]
    n_searches: int
    practice: dict[str, Any]  # what `Work` knows of it
    points_s: float  # how long its points took
    switches_s: float


@dataclass
class Lines:
    """The parts of a table that have one value of a key, such as a water: solved side by side, each by itself.

    So nobody can tell from a table on how many cores it was made. What is solved is heard of at once, and kept where a
    person wants no more. Where other systems take over from a line to the next is looked for afterwards.
    """

    work: Work
    grid: VariedGrid
    watch: Watch
    keys: list[tuple[Varied, ...]]  # of each line
    shares: list[float] = field(default_factory=list)  # how far each is
    met: dict[At, tuple[WinningSystem, PartIds]] = field(default_factory=dict)  # at the points that are solved
    began_s: float = field(default_factory=time.perf_counter)

    def solve(self) -> list[Switch]:
        """All points of the grid, and where other systems take over. Raises KeyboardInterrupt, with what is solved in
        the grid."""
        work, murky = self.work, [murkiness(keys) for keys in self.keys]
        try:
            lines = self._side_by_side(self._line, sorted(range(len(murky)), key=lambda line: -murky[line]))
        finally:
            self._place_systems()
            self._time([])
        is_known = bool(work.given_way)
        asked = max(lines, key=lambda line: (bool(line.practice["given_way"]), line.practice["given_way"] is not None))
        for name, value in asked.practice.items():
            setattr(work, name, value)
        if work.given_way and not is_known:
            self.grid.begin_again(work.given_way)
            self.met.clear()
            return self.solve()
        work.tell_left_out(self.grid)
        seams = self.grid.seam_keys(self.keys)
        lines += self._side_by_side(partial(self._seam, seams), range(len(seams)))
        self._time(lines)
        work.notes += {note.code: note for line in lines for note in line.notes}.values()
        every = [(switch, line) for line in lines for switch in line.switches]
        return [self._renumbered(*one) for one in sorted(every, key=lambda one: self._place(one[0]))]

    def _side_by_side(self, solve: Callable[[int], SolvedLine], order: Sequence[int]) -> list[SolvedLine]:
        """What each number's work makes, in rising order; they are begun in another."""
        self.shares = [0.0] * len(order)
        works = [partial(solve, number) for number in order]
        made = side_by_side(works, lists=[self.work.deadline.left_out], hears=self._hear)
        self.work.n_searches += sum(line.n_searches for line in made)
        return [made[[*order].index(number)] for number in range(len(made))]

    def _line(self, number: int) -> SolvedLine:
        """One line by itself, which ends early where good practice gives way: then all begin again."""
        work, own = self._own(self.keys[number], Systems(self.work.goal))
        work.say, began_s = partial(self._say, number, 0.0, POINTS_SHARE), time.perf_counter()
        work.solve_all(own)
        points_s = time.perf_counter() - began_s
        if own.given_way and not self.work.given_way:
            return self._made(work, None, points_s)
        work.say = partial(self._say, number, POINTS_SHARE, 1.0 - POINTS_SHARE)
        return self._made(work, own, points_s)

    def _seam(self, seams: list[tuple[Varied, ...]], number: int) -> SolvedLine:
        """Where systems take over between the points of two lines."""
        known = self.work.systems
        work, own = self._own(seams[number], Systems(known.objective, [*known.found], [*known.parts]))
        own.points = {at: self.grid.points[at] for at in own.every if at in self.grid.points}
        own.along = self.grid.apart
        work.say = partial(self._say, number, 0.0, 1.0)
        return self._made(work, own, 0.0)

    def _own(self, keys: tuple[Varied, ...], systems: Systems) -> tuple[Work, VariedGrid]:
        """What solves a part of the grid by itself, and that part."""
        work = replace(
            self.work, systems=systems, notes=[], n_searches=0, is_line=True, told=self._told,
            patience_share=SHARES / len(self.keys),
        )  # fmt: skip
        own, grid = work.grid_of(keys), self.grid
        own.given_way, own.missions, own.refused = grid.given_way, {**grid.missions}, grid.refused
        return work, own

    @staticmethod
    def _made(work: Work, own: VariedGrid | None, points_s: float) -> SolvedLine:
        """What is known of a part of the grid, where its switches are found; None: they are not wanted."""
        began_s = time.perf_counter()
        switches = [] if own is None else work.switches(own)
        return SolvedLine(
            [*zip(work.systems.found, work.systems.parts, strict=True)], switches, work.notes, work.n_searches,
            {name: getattr(work, name) for name in PRACTICE}, points_s, time.perf_counter() - began_s,
        )  # fmt: skip

    @staticmethod
    def _say(number: int, begins: float, part: float, share: float, what: str) -> None:
        tell(LineShare(number, begins + part * share, what))

    @staticmethod
    def _told(grid: VariedGrid, at: At) -> None:
        point, known = grid.points[at], grid.systems
        system = None if point.system is None else (known.found[point.system], known.parts[point.system])
        tell(LinePoint(at, point, system))

    def _hear(self, told: LineShare | LinePoint) -> None:
        """Here, whoever solves a line."""
        if isinstance(told, LineShare):
            self.shares[told.line] = told.share
            self.work.say(sum(self.shares) / len(self.shares), told.what)
            return
        self.grid.points[told.at] = told.point
        if told.system is not None:
            self.met[told.at] = told.system

    def _time(self, lines: Sequence[SolvedLine]) -> None:
        """How long points and switches have taken on all cores, by their shares of what each line took."""
        points_s, switches_s = (sum(getattr(line, name) for line in lines) for name in ("points_s", "switches_s"))
        share = points_s / (points_s + switches_s) if lines else 1.0
        lasted_s = time.perf_counter() - self.began_s
        self.watch.timing_s.update(points=share * lasted_s, switches=(1.0 - share) * lasted_s)

    def _place_systems(self) -> None:
        """The table's numbers of systems in place of the lines' own."""
        for at in self.grid.order():
            if at in self.met:
                place = self.work.systems.place_of(*self.met[at])
                self.grid.points[at] = replace(self.grid.points[at], system=place)

    def _renumbered(self, switch: Switch, line: SolvedLine) -> Switch:
        """A switch of a line between the table's systems."""
        first, second = (
            None if one is None else self.work.systems.place_of(*line.systems[one])
            for one in (switch.first, switch.second)
        )
        return replace(switch, first=first, second=second)

    def _place(self, switch: Switch) -> tuple[Any, ...]:
        """Of a switch among all: along each key from line to line, rising."""
        names = [key.key for key in self.grid.keys]
        others = [
            line.index(other) for other, line in zip(switch.others, self.grid.lines, strict=True) if other is not None
        ]
        return names.index(switch.key), others, switch.low

"""The points of a table over varied keys: their order, what is kept of each, and where systems change."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from uwopt.deadline import Deadline
from uwopt.errors import MissionError
from uwopt.forward.scene_checks import check_physical
from uwopt.mission.keys import JERLOV_TYPES
from uwopt.mission.mission import Mission
from uwopt.mission.varying import Value, Varied, VariedMission
from uwopt.mission.yielding import Yield, with_given_way
from uwopt.objectives.objective import Objective
from uwopt.results.whatif import Switch, WhatIfPoint, WinningSystem
from uwopt.solvers.beside import shares
from uwopt.solvers.exact.ranking import ids_in
from uwopt.solvers.recommend import check_claim, evaluated
from uwopt.solvers.warm.parts import PartIds, ids_of, joined_ids
from uwopt.solvers.warm.searches import Warm, WarmAnswer, weakest_first
from uwopt.units import ratio_to_db

At = tuple[Value, ...]
NO_IDS: PartIds = {}  # where nothing is searched among parts
SHARP = 1e-2  # of the way between two neighbouring points: how sharp a switch is told
FEWEST = 4  # points of half a line
DEEPEST = 3  # other systems found between two, one within another


@dataclass
class Systems:
    """The systems that are best somewhere, by the order in which they were met."""

    objective: Objective
    found: list[WinningSystem] = field(default_factory=list)
    parts: list[PartIds] = field(default_factory=list)

    def index(self, answer: WarmAnswer) -> int | None:
        """Of the system that an answer has found; one that is met for the first time is evaluated and compared."""
        if answer.found is None or answer.sought is None:
            return None
        one, problem = answer.found, answer.sought.problem
        generic = any(part.generic for part in problem.parts.of(one).values())
        system = WinningSystem(*ids_in(problem.parts, one), problem.lamps_carried(one), generic)
        if system not in self.found:
            check_claim(evaluated(problem, one, self.objective), one, self.objective)
        return self.place_of(system, ids_of(problem, one))

    def place_of(self, system: WinningSystem, parts: PartIds = NO_IDS) -> int:
        """The index of a system, which is remembered with the ids of its parts."""
        if system not in self.found:
            self.found.append(system)
            self.parts.append(parts)
        return self.found.index(system)

    def point(self, values: Sequence[Value], answer: WarmAnswer) -> WhatIfPoint:
        """What is kept of an answer."""
        system, one = self.index(answer), answer.found
        status = "stopped" if not answer.complete else "infeasible" if one is None else "optimal"
        if one is None or answer.sought is None:
            return WhatIfPoint(list(values), status)
        settings = one.settings[0]
        figures = {
            "power_w": one.power_w, "cost": one.cost, "mass_kg": one.mass_kg, "snr_db": one.snr_db,
            "gsd_mm": float(answer.sought.outcome.imagers.gsd_mm[one.imager]), "f_number": settings["f_number"],
            "exposure_ms": 1e3 * settings["exposure_s"], "gain_db": float(ratio_to_db(settings["gain"])),
            "dim_frac": settings["level"], "frame_rate_hz": settings["rate_hz"],
        }  # fmt: skip
        gap = self.objective.share(max(one.minimised - answer.lower_bound, 0.0), one.minimised)
        return WhatIfPoint(
            list(values), status, system, self.objective.reported(one.minimised), gap, figures, not answer.capped
        )


@dataclass
class VariedGrid:
    """All choices of values of the varied keys, solved one by one."""

    base: VariedMission
    keys: tuple[Varied, ...]
    systems: Systems
    warm: Warm
    certain: Callable[[At, Mission], WhatIfPoint] | None = None  # in place of the central optimum
    given_way: tuple[Yield, ...] = ()  # of good practice, at every point
    missions: dict[At, Mission] = field(default_factory=dict)
    points: dict[At, WhatIfPoint] = field(default_factory=dict)
    refused: dict[At, str] = field(default_factory=dict)  # points that are no mission, and why
    along: int | None = None  # the only key along which neighbours are looked at

    @cached_property
    def signs(self) -> tuple[int, ...]:
        """Of each key 1 where more of it asks for more, -1 where less does, 0 where that is not sure."""
        return tuple(key.stricter(self.base.base) for key in self.keys)

    @cached_property
    def lines(self) -> list[tuple[Value, ...]]:
        """The values of each key in the order in which they are solved: from what asks for least, else rising."""
        made = []
        for key, sign in zip(self.keys, self.signs, strict=True):
            values = sorted(key.values, key=float) if key.is_numeric else list(key.values)
            made.append(tuple(values[::-1] if sign < 0 else values))
        return made

    @property
    def every(self) -> list[At]:
        """All points."""
        return [*itertools.product(*self.lines)]

    def order(self) -> list[At]:
        """All points in the order in which they are solved: of those alike in all else what asks for less first."""
        every = [at for at in self.every if at not in self.refused]
        return [every[place] for place in weakest_first([self.mission(at) for at in every])]

    @cached_property
    def apart(self) -> int | None:
        """Which key parts the table into lines that are solved side by side; None: it is one line.

        One of words, between which nothing is, beside one of numbers; else one of numbers of which neither more nor
        less is sure to ask for more, so that searches at one value help little at the next.
        """
        numeric = [key.is_numeric for key in self.keys]
        words = [k for k, is_number in enumerate(numeric) if not is_number] if any(numeric) else []
        unsure = [k for k, sign in enumerate(self.signs) if numeric[k] and not sign]
        return next(iter(words + unsure), None)

    def line_keys(self) -> list[tuple[Varied, ...]]:
        """The keys of each line: a value of the key that parts them, or, of one alone, half of its values."""
        k = self.apart
        if k is None:
            return [self.keys]
        values = self.lines[k]
        parts = [values[n : n + 1] for n in range(len(values))]
        if len(self.keys) == 1:
            parts = [values[part] for part in shares(len(values), FEWEST)]
        return [(*self.keys[:k], replace(self.keys[k], values=part), *self.keys[k + 1 :]) for part in parts]

    def seam_keys(self, lines: Sequence[tuple[Varied, ...]]) -> list[tuple[Varied, ...]]:
        """The keys of what lies between neighbouring lines: the last value of one and the first of the next."""
        k = self.apart
        if k is None or not self.keys[k].is_numeric:
            return []
        return [
            (*one[:k], replace(one[k], values=(one[k].values[-1], other[k].values[0])), *one[k + 1 :])
            for one, other in itertools.pairwise(lines)
        ]

    def mission(self, at: At) -> Mission:
        """The mission at a point; raises MissionError where its keys contradict each other."""
        if at not in self.missions:
            made = self.base.with_values(dict(zip(self.keys, at, strict=True)))
            # what is varied does not give way: a point states it
            self.missions[at] = with_given_way(made, self.given_way)
        return self.missions[at]

    def begin_again(self, given_way: tuple[Yield, ...]) -> None:
        """Forget what is solved: from now on these have given way at every point."""
        self.given_way = given_way
        for known in (self.missions, self.points, self.systems.found, self.systems.parts):
            known.clear()

    def solve(self, at: At) -> WhatIfPoint:
        """The optimum at a point, on the grid or between its points."""
        if at not in self.points and self.certain is not None:
            self.points[at] = self.certain(at, self.mission(at))
        if at not in self.points:
            on_grid = all(value in line for value, line in zip(at, self.lines, strict=True))
            ahead = on_grid and any(
                sign and value != line[-1]
                for value, line, sign in zip(at, self.lines, self.signs, strict=True)
            )
            self.points[at] = self.systems.point(at, self.warm.best(self.mission(at), ahead=ahead))
        return self.points[at]

    def changes(self) -> Iterator[tuple[int, At, At]]:
        """Neighbours along each numeric key of which the best systems differ: the key's index, and both."""
        for k, a, b in self.neighbours():
            if self.is_told(a) and self.is_told(b) and self.points[a].system != self.points[b].system:
                yield k, a, b

    def is_told(self, at: At) -> bool:
        """Whether it is known what is best at a point, or that nothing fits; time may have been over before."""
        point = self.points.get(at)
        return point is not None and (point.system is not None or point.status == "infeasible")

    def rims(self) -> Iterator[tuple[int, At, At]]:
        """Neighbours of which one is no mission, and the other has a system: the key's index, that one, the refused."""
        for k, a, b in self.neighbours():
            for inside, outside in ((a, b), (b, a)):
                if outside in self.refused and inside in self.points and self.points[inside].system is not None:
                    yield k, inside, outside

    def is_mission(self, at: At) -> bool:
        """Whether the keys do not contradict each other or the rest of the mission at a point."""
        try:
            check_physical(self.mission(at))
        except MissionError:
            return False
        return True

    def neighbours(self) -> Iterator[tuple[int, At, At]]:
        """Points beside each other along each numeric key: the key's index, the one with less, the one with more."""
        for k, key in enumerate(self.keys):
            if not key.is_numeric or self.along not in (None, k):
                continue
            others = [values if n != k else values[:1] for n, values in enumerate(self.lines)]
            for fixed in itertools.product(*others):
                line = [(*fixed[:k], value, *fixed[k + 1 :]) for value in sorted(key.values, key=float)]
                yield from ((k, a, b) for a, b in itertools.pairwise(line))


def murkiness(keys: Sequence[Varied]) -> int:
    """How murky the water of a line is by the table of Jerlov types; the murkier, the longer a line takes."""
    return max(JERLOV_TYPES.index(value) if value in JERLOV_TYPES else 0 for key in keys for value in key.values[:1])


@dataclass
class Switches:
    """Where another system takes over, between neighbouring points of a grid."""

    grid: VariedGrid
    deadline: Deadline
    say: Callable[[float, str], None]

    def all(self) -> list[Switch]:
        """Each as sharp as the time allows."""
        changes, made = [*self.grid.changes()], list[Switch]()
        for number, (k, a, b) in enumerate(changes):
            self.say(number / len(changes), f"where systems take over, {number + 1} of {len(changes)}")
            made += self.between(k, a, b, SHARP * (float(b[k]) - float(a[k])))
        return made + self.at_rims()

    def at_rims(self, *, searched: bool = True) -> list[Switch]:
        """Where missions end, beside points that are none; searched: what wins just before that is looked for."""
        return [switch for rim in self.grid.rims() for switch in self._at_rim(*rim, searched)]

    def _at_rim(self, k: int, inside: At, outside: At, searched: bool) -> list[Switch]:
        """From a solved point to where the mission begins to contradict itself, which takes no search to know."""
        grid, near, far = self.grid, inside, outside
        self.say(0.0, f"where missions end, beside {grid.keys[k].key} {float(inside[k]):.6g}")
        step = abs(float(outside[k]) - float(inside[k]))
        while abs(float(far[k]) - float(near[k])) > SHARP * step:
            middle = (*inside[:k], 0.5 * (float(near[k]) + float(far[k])), *inside[k + 1 :])
            near, far = (middle, far) if grid.is_mission(middle) else (near, middle)
        made, is_known = list[Switch](), near == inside
        if searched and not is_known and not self.deadline.passed():
            a, b = sorted((inside, near), key=lambda at: float(at[k]))
            is_known = grid.solve(near).status in ("optimal", "infeasible")
            if grid.points[a].system != grid.points[b].system:
                made = self.between(k, a, b, SHARP * step)
        last = grid.points.get(near, grid.points[inside])
        if last.system is None:
            return made
        others = [None if n == k else value for n, value in enumerate(inside)]
        ends, systems = (float(near[k]), float(far[k])), (last.system, None)
        (low, high), (first, second) = (ends, systems) if ends[0] < ends[1] else (ends[::-1], systems[::-1])
        proven = is_known and last.status in ("optimal", "infeasible")
        return [*made, Switch(grid.keys[k].key, others, low, high, first, second, proven)]

    def coarse(self, k: int, a: At, b: At) -> Switch:
        """Between two solved points, no sharper than they are apart."""
        others = [None if n == k else value for n, value in enumerate(a)]
        first, second = self.grid.points[a], self.grid.points[b]
        proven = {first.status, second.status} <= {"optimal", "infeasible"}
        key = self.grid.keys[k].key
        return Switch(key, others, float(a[k]), float(b[k]), first.system, second.system, proven)

    def between(self, k: int, a: At, b: At, sharp: float, depth: int = DEEPEST) -> list[Switch]:
        """The switches between two solved points: found between their two systems, then proven on both sides."""
        grid = self.grid
        if self._is_sharp(k, a, b, sharp, depth):
            return [self.coarse(k, a, b)]
        low, high = self._bisected(k, a, b, sharp)
        if not grid.signs[k] and any(n != k and key.is_numeric for n, key in enumerate(grid.keys)):
            found = self.coarse(k, a, b)  # a map has too many to search all parts at each
            return [replace(found, low=float(low[k]), high=float(high[k]), proven=False)]
        made = []
        for left, right in itertools.pairwise(dict.fromkeys((a, low, high, b))):
            if grid.solve(left).system != grid.solve(right).system:
                made += self.between(k, left, right, sharp, depth - 1)
        return made

    def first(self, k: int, near: At, far: At, sharp: float, depth: int = DEEPEST) -> Switch:
        """The switch next to the first of two solved points; what lies beyond it is not searched."""
        a, b = sorted((near, far), key=lambda at: float(at[k]))
        if self._is_sharp(k, a, b, sharp, depth):
            return self.coarse(k, a, b)
        way = [near, *self._bisected(k, a, b, sharp), far]
        if near == b:
            way[1:3] = way[2:0:-1]
        for left, right in itertools.pairwise(dict.fromkeys(way)):
            if self.grid.solve(left).system != self.grid.solve(right).system:
                return self.first(k, left, right, sharp, depth - 1)
        raise AssertionError("two points have the same system")

    def _is_sharp(self, k: int, a: At, b: At, sharp: float, depth: int) -> bool:
        """Whether two solved points are close enough, or nothing closer is looked for."""
        if float(b[k]) - float(a[k]) <= sharp or depth == 0:
            return True
        if self.deadline.passed():
            self.deadline.left_out.append("how sharp all switches are")
            return True
        return False

    def _bisected(self, k: int, a: At, b: At, sharp: float) -> tuple[At, At]:
        """Where the first of two systems is no longer the better one."""
        grid, first = self.grid, self.grid.points[a].system
        names = [one for one in (first, grid.points[b].system) if one is not None]
        parts = joined_ids([grid.systems.parts[one] for one in names])
        low, high = float(a[k]), float(b[k])
        while high - low > sharp:
            middle = 0.5 * (low + high)
            at = (*a[:k], middle, *a[k + 1 :])
            is_first = grid.systems.index(grid.warm.among(grid.mission(at), parts)) == first
            low, high = (middle, high) if is_first else (low, middle)
        return (*a[:k], low, *a[k + 1 :]), (*a[:k], high, *a[k + 1 :])

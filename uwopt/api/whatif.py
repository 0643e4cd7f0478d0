"""`uwopt.whatif`: the certified optimum over values of a mission's keys, and where another system takes over."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

from uwopt.api.common import Source, central_notes, given, time_warnings
from uwopt.api.floats import own_float_rules
from uwopt.api.search_notes import patience_warnings
from uwopt.api.varied import At, Switches, Systems, VariedGrid, murkiness
from uwopt.api.watch import Watch
from uwopt.api.yielding import gives_way_alone, yield_notes
from uwopt.deadline import Deadline, Progress, processor_s, unheard
from uwopt.errors import MissionError
from uwopt.forward.scene_checks import check_physical
from uwopt.mission.doubt import CENTRAL
from uwopt.mission.mission import Mission
from uwopt.mission.varying import Asked, Value, Varied, VariedMission
from uwopt.mission.yielding import Yield, with_given_way, yields_of
from uwopt.objectives.goal import goal_of
from uwopt.objectives.objective import Objective
from uwopt.quantities import AT_LIKELIEST
from uwopt.results.basis import ObjectiveValue
from uwopt.results.design import Note
from uwopt.results.version import __version__
from uwopt.results.whatif import SpiderLine, Switch, VariedKey, WhatIf, WhatIfPoint, WinningSystem
from uwopt.solvers.beside import SHARES, side_by_side, tell
from uwopt.solvers.warm.parts import PartIds
from uwopt.solvers.warm.searches import Warm
from uwopt.units import unit_suffix

MOST_KEYS, MOST_POINTS = 2, 10_000
SPIDER_FACTORS = (0.8, 0.9, 1.0, 1.1, 1.2)
MOST_ASKED = 2  # points of which it is asked what gives way, where the mission as it stands has no system
SWITCHES_S = 30.0  # of the processor, for where systems take over, where no time is given
PRACTICE = ("given_way", "fits_nothing", "asked_at", "relaxed_at", "to_hold")
POINTS_SHARE = 0.75  # of a line's time, for its points; the rest for where systems take over
HOLDS = "--confidence holds it at every point"


@own_float_rules
def whatif(
    mission: Source | Mission,
    vary: Asked | None = None,
    *,
    spider: bool = False,
    objective: str | Mapping[str, float] | None = None,
    physics: str | None = None,
    confidence: float | str | None = None,
    seconds: float | None = None,
    hold_practice: bool = False,
    progress: Progress | None = None,
) -> WhatIf:
    """The optimum at every choice of values of one or two keys, each proven over the whole catalogue.

    Parameters
    ----------
    mission : file name, mapping or Mission
    vary : values by key, as a sequence or as text: {"speed_m_s": "0.2:2:40", "water": ["I", "II", "1C"]}
    spider : also vary each number that the mission states alone, by 20 % either way
    confidence : share of the scenarios in which hardware must hold at every point, or `ends`; without, likeliest values
    seconds : for all of it; what is solved by then is kept
    hold_practice : as of `solve`; else what gives way for the mission as it stands does at every point

    Raises
    ------
    MissionError : a key does not exist, a range is empty, or values contradict the rest of the mission
    """
    if vary is not None and not isinstance(vary, Mapping):
        raise MissionError(f'whatif: vary = {str(vary)[:60]!r} is no mapping; as {{"speed_m_s": "0.2:2:40"}}')
    base = VariedMission(mission, given(objective=objective, physics=physics, confidence=confidence))
    check_physical(base.base)
    keys = tuple(base.varied(key, values) for key, values in (vary or {}).items())
    check_keys(keys, spider=spider)
    goal, watch = goal_of(base.base), Watch.begun(seconds, progress)
    systems = Systems(goal)
    certain = confidence is not None and base.base.confidence != CENTRAL
    if certain and spider:
        raise MissionError(f"whatif: --spider is told {AT_LIKELIEST}; leave out --confidence")
    given_way = () if hold_practice else None
    work = Work(base, goal, systems, watch.deadline, watch.progress, certain, given_way=given_way)
    grid = work.grid_of(keys)
    status, switches, lines = "complete", list[Switch](), list[SpiderLine]()
    try:
        if keys:
            work.notes += check_points(grid)
            if spider and work.given_way is None:
                work.ask_practice(grid)
            if len(lines_keys := grid.line_keys()) > 1:
                switches = Lines(work, grid, watch, lines_keys).solve()
            else:
                with watch.timed("points"):
                    work.solve_all(grid)
                with watch.timed("switches"):
                    switches = work.switches(grid)
        if spider:
            with watch.timed("spider"):
                work.spider(lines)
    except KeyboardInterrupt:
        if not (grid.points or lines):
            raise
        status = "interrupted"
    points = in_given_order(grid)
    unheld = [] if certain else central_notes(base.base, HOLDS)
    if status == "complete" and watch.deadline.passed():
        status = "stopped"
    return WhatIf(
        status=status,
        mission=with_given_way(base.base, work.given_way or ()).to_dict(),
        objective=ObjectiveValue(goal.name, goal.direction, None, goal.unit(base.base.limits.currency)),
        uwopt_version=__version__,
        keys=[
            VariedKey(key.key, unit_of(key, base.base), list(key.values), sign)
            for key, sign in zip(keys, grid.signs, strict=True)
        ],
        points=points,
        systems=systems.found,
        switches=switches,
        spider=lines,
        warnings=[
            *yield_notes(work.given_way or (), to_hold=work.to_hold), *notes_of(points, keys, status),
            *full_practice_notes(points, work), *unheld, *work.notes, *time_warnings(watch.deadline),
        ],
        timing_s=watch.total(),
        n_searches=work.n_searches,
        mission_file=base.base.source_file,
        confidence=base.base.confidence if certain else CENTRAL,
        gave_way=[one.path for one in work.given_way or ()],
    )


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
            values = ", ".join(f"{key.name} {shown(value)}" for key, value in zip(grid.keys, at, strict=True))
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
        return SpiderLine(f"{key.section}.{key.name}", unit_of(key, self.base.base), float(key.values[0]), points)


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


def for_certainty(work: Work) -> bool:
    """Whether `solve` could let more of good practice give way so that something holds as often at another point."""
    return any(one.for_certainty for one in yields_of(with_given_way(work.base.base, work.given_way or ())))


def full_practice_notes(points: Sequence[WhatIfPoint], work: Work) -> list[Note]:
    """That all of good practice is asked where nothing fits, though `solve` would let it give way there."""
    relaxed = []
    if work.given_way and work.relaxed_at:
        text = (
            "what of good practice is relaxed at every point is what uwopt solve relaxes at "
            f"{work.relaxed_at}, for the mission as it stands has no system with less of it either"
        )
        relaxed = [Note("practice_at", "practice", text)]
    if work.certain and any(point.status == "infeasible" and point.figures for point in points):
        where = f"at {work.relaxed_at}" if relaxed else "in the mission as it stands"
        text = (
            f"every point is held to what is left of good practice {where}; where something holds less often than is "
            "asked, uwopt solve relaxes more of it"
        )
        return [*relaxed, Note("practice_held", "practice", text)] if for_certainty(work) else relaxed
    if relaxed:
        return relaxed
    if work.given_way or not yields_of(work.base.base) or all(point.status != "infeasible" for point in points):
        return []
    why = "with less of it the mission as it stands has no system either" if work.fits_nothing else (
        "the mission as it stands keeps it"
    )  # fmt: skip
    text = (
        f"all of good practice is asked at every point, for {why}; at a point where nothing fits with it, uwopt solve "
        "relaxes some of it, and may find a system"
    )
    return [Note("practice_held", "practice", text)]


def check_keys(keys: Sequence[Varied], *, spider: bool) -> None:
    """One or two keys, each once, of not too many values."""
    names = [(key.section, key.name, key.scene) for key in keys]
    if not keys and not spider:
        raise MissionError(
            "whatif: no key is varied; write such as --vary speed_m_s=0.2:2:40 (from:to:how many), or --spider"
        )
    if len(keys) > MOST_KEYS:
        raise MissionError(f"whatif: {len(keys)} keys are varied; a map has {MOST_KEYS} at most, so leave some out")
    if len(set(names)) < len(names):
        raise MissionError(f"whatif: {keys[0].name} is varied twice; give all its values at once")
    count = math.prod(len(key.values) for key in keys)
    if count > MOST_POINTS:
        raise MissionError(f"whatif: {count} points are asked for, {MOST_POINTS} at most are solved; take fewer values")


def check_points(grid: VariedGrid) -> list[Note]:
    """Set points aside whose values contradict each other or the rest of the mission, and say why.

    Raises MissionError where all do, or no mission takes a value of a key.
    """
    every = grid.every
    for at in every:
        try:
            check_physical(grid.mission(at))
        except MissionError as fault:
            grid.refused[at] = fault.faults[0]
    if not grid.refused:
        return []
    at, why = next(iter(grid.refused.items()))
    for one, fault in grid.refused.items():
        for key, value in zip(grid.keys, one, strict=True):
            alone = f"{key.name} = {value!r} "  # of what no mission takes the fault says all there is to say
            if alone in fault and not (key.is_numeric and grid.base.is_allowed(key, value)):
                raise MissionError(f"whatif: vary {key.key}: {value!r} {fault.partition(alone)[2]}")
    values = ", ".join(f"{key.key} = {shown(value)}" for key, value in zip(grid.keys, at, strict=True))
    count = len(grid.refused)
    more = f" ({count} of {len(every)} points are like that)" if count > 1 else ""
    told = f"at {values} the mission contradicts itself{more}: {why}"
    if count == len(every):
        raise MissionError(f"whatif: {told}")
    return [Note("contradiction", "", f"{told.rstrip('.;')}; nothing can fit there, and nothing was looked for")]


def shown(value: Value) -> str:
    """A value in a line."""
    return value if isinstance(value, str) else f"{value:.6g}"


def in_given_order(grid: VariedGrid) -> list[WhatIfPoint]:
    """The points of the grid that are solved, or are none, in the order of the values as they were given."""
    places = [{value: n for n, value in enumerate(key.values)} for key in grid.keys]
    known = {at: WhatIfPoint(list(at), "infeasible") for at in grid.refused} | grid.points
    on_grid = [at for at in known if all(v in place for v, place in zip(at, places, strict=True))]
    on_grid.sort(key=lambda at: [place[v] for v, place in zip(at, places, strict=True)])
    return [known[at] for at in on_grid]


def unit_of(key: Varied, mission: Mission) -> str:
    """The unit of a key's values."""
    if not key.is_numeric:
        return ""
    return mission.limits.currency if key.name == "cost" else unit_suffix(key.name).lstrip("_")


def notes_of(points: Sequence[WhatIfPoint], keys: Sequence[Varied], status: str) -> list[Note]:
    """What to know of a table."""
    notes = []
    if status == "interrupted":
        notes.append(Note("interrupted", "", "interrupted: the table holds what was solved by then"))
    if any(point.beyond_gain_cap for point in points):
        text = "at some points nothing fits below reserve.max_gain_db, and the gain is higher"
        notes.append(Note("gain_cap", "reserve.max_gain_db", text))
    if points and all(point.status == "infeasible" for point in points):
        names = " and ".join(key.key for key in keys)
        text = f"nothing fits at any value of {names}; uwopt explain says what would help"
        notes.append(Note("infeasible", "", text))
    return notes

"""`uwopt.whatif`: the certified optimum over values of a mission's keys, and where another system takes over."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from uwopt.api.common import Source, central_notes, given, time_warnings
from uwopt.api.floats import own_float_rules
from uwopt.api.varied import Systems, VariedGrid
from uwopt.api.varied_lines import Lines
from uwopt.api.varied_work import Work, key_unit, key_value_text
from uwopt.api.watch import Watch
from uwopt.api.yielding import yield_notes
from uwopt.deadline import Progress
from uwopt.errors import MissionError
from uwopt.forward.scene_checks import check_physical
from uwopt.mission.doubt import CENTRAL
from uwopt.mission.mission import Mission
from uwopt.mission.varying import Asked, Varied, VariedMission
from uwopt.mission.yielding import with_given_way, yields_of
from uwopt.objectives.goal import goal_of
from uwopt.quantities import AT_LIKELIEST
from uwopt.results.basis import ObjectiveValue
from uwopt.results.design import Note
from uwopt.results.version import __version__
from uwopt.results.whatif import SpiderLine, Switch, VariedKey, WhatIf, WhatIfPoint

MOST_KEYS, MOST_POINTS = 2, 10_000
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
            VariedKey(key.key, key_unit(key, base.base), list(key.values), sign)
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
    values = ", ".join(f"{key.key} = {key_value_text(value)}" for key, value in zip(grid.keys, at, strict=True))
    count = len(grid.refused)
    more = f" ({count} of {len(every)} points are like that)" if count > 1 else ""
    told = f"at {values} the mission contradicts itself{more}: {why}"
    if count == len(every):
        raise MissionError(f"whatif: {told}")
    return [Note("contradiction", "", f"{told.rstrip('.;')}; nothing can fit there, and nothing was looked for")]


def in_given_order(grid: VariedGrid) -> list[WhatIfPoint]:
    """The points of the grid that are solved, or are none, in the order of the values as they were given."""
    places = [{value: n for n, value in enumerate(key.values)} for key in grid.keys]
    known = {at: WhatIfPoint(list(at), "infeasible") for at in grid.refused} | grid.points
    on_grid = [at for at in known if all(v in place for v, place in zip(at, places, strict=True))]
    on_grid.sort(key=lambda at: [place[v] for v, place in zip(at, places, strict=True)])
    return [known[at] for at in on_grid]


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

"""Lines of a tender: what a part must fulfil, what else is asked of its maker, and which parts would do.

Limits are found by the certified search of the system with its part made worse (`solvers.explain.specification`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from uwopt.catalog.columns import COLUMNS, REQUIRED, Column
from uwopt.catalog.parts.part import KINDS, OF_A_DESIGN, Kind
from uwopt.deadline import NEVER, Deadline
from uwopt.errors import ResultError
from uwopt.evaluation.design_model import DesignModel
from uwopt.evaluation.recompute import replayed
from uwopt.forward.enclosures import BODY, sizes_at_worst
from uwopt.objectives.goal import goal_of
from uwopt.objectives.objective import Objective
from uwopt.report.order.maker_words import NOT_THEIRS, words_for
from uwopt.report.order.other_parts import AS_GOOD, other_systems
from uwopt.report.text import words
from uwopt.report.text.certainty import held_text
from uwopt.report.text.formats import margin_ends
from uwopt.report.text.not_counted import depth_m
from uwopt.report.text.stated import cells_of
from uwopt.results.design import BillRow, Design
from uwopt.results.result import Result
from uwopt.solvers.explain.specification import PropertyLimit, changed, specification
from uwopt.units import format_difference, format_number, unit_told

#: What is asked of every maker beside the facts of the part.
COMMERCIAL = (
    ("manufacturer", "maker", "text"), ("model", "model that is offered", "text"),
    ("named_part", "is it the part named above?", "yes or no"), ("price", "price of one piece", "a number"),
    ("currency", "currency of the price", "three letters"), ("price_date", "day of the quote", "YYYY-MM-DD"),
    ("valid_until", "the quote holds until", "YYYY-MM-DD"), ("lead_time_weeks", "lead time", "weeks"),
)  # fmt: skip
NOT_ASKED = ("id", "price", "price_low", "price_high", "manufacturer", "model", "currency", *NOT_THEIRS)
ALWAYS = ("depth_rating_m", "mass_g", "trigger_delay_us", "trigger_jitter_us")
#: Facts without which no search uses a part of its own, or which tell whether it fits.
VITAL: dict[str, tuple[str, ...]] = {
    "camera": ("shutter", "colour", "mounts", "interface", "max_frame_rate_hz"), "lens": ("mounts", "image_circle_mm"),
    "port": ("mount", "outer_radius_mm", "thickness_mm"), "housing": ("inner_diameter_mm", "inner_length_mm", "ports"),
    "light": ("beam_angle_deg", "beam_medium", "supply", "trigger", "supply_v_min", "supply_v_max"),
}  # fmt: skip
LOOSE = 5.0  # times worse than the named part: no part that is offered comes near to it
ROOM_FOR = {"inner_diameter_mm": "housing_diameter_mm", "inner_length_mm": "housing_length_mm"}  # its requirement
SIZES = (*BODY, "length_mm", "diameter_mm")  # of cameras and lenses, which take up room
EMPTY: Mapping[str, float] = {}
OF_FIELDS = {"qe_scale": "qe"}  # the record's field by the column that states it


@dataclass(frozen=True)
class AskedFact:
    """One fact that a maker is asked for: its column in a file of parts, and what is known and needed of it."""

    key: str
    words: str
    unit: str
    needed: str
    stays_best: str
    together: str
    named: str  # value of the part that is named
    known: str  # published | estimated | not known
    loose: bool = False  # whether parts of its kind have it anyway


@dataclass(frozen=True)
class TenderLine:
    """One part to be offered."""

    kind: Kind
    part_id: str
    name: str
    generic: bool
    count: int
    alternatives: tuple[str, ...]
    rival: str
    facts: tuple[AskedFact, ...]


def lines_of(result: Result, name: str, deadline: Deadline = NEVER) -> list[TenderLine]:
    """The lines of a result's system; raises ResultError where it has none.

    Parts that are not begun in time go without limits; the deadline notes which.
    """
    if result.best is None:
        raise ResultError(f"{name}: holds no system, so there is nothing to ask for; solve a mission that has one.")
    return tender_lines(result, result.best, deadline)


def falls_short(result: Result) -> str:
    """What a system that is tendered misses, as nobody should order it unawares; empty where it does what is asked."""
    design, known = result.best, result.confidence
    assert design is not None
    missed = {m.requirement: m for m in design.as_set.missed}
    if missed:
        by = {name: " against ".join(margin_ends(m, design.totals.cost)) for name, m in missed.items()}
        told = [f"{words.requirement_name(name)} ({ends})" for name, ends in by.items()]
        return f"This system misses what is asked: {words.listed(told)}"
    return "" if known is None or known.enough else f"This system is not certain enough: it {held_text(known)}"


def tender_lines(result: Result, design: Design, deadline: Deadline) -> list[TenderLine]:
    """A line a part that is to be bought, its limits found anew by the model."""
    made = replayed(result, design)
    problem, hardware = made.model.problem, made.model.hardware
    goal = goal_of(problem.mission)
    lines: list[TenderLine] = []
    found: dict[Kind, list[PropertyLimit]] = {}
    for row in design.bom:
        kind = next((kind for kind in KINDS if kind == row.kind), None)
        if kind is None or not row.to_buy:
            continue
        rival, name = nearest_rival(result, kind, goal)
        limits: list[PropertyLimit] = []
        if kind in OF_A_DESIGN and design.hardware.complete is None:
            if deadline.passed():
                deadline.left_out.append(f"the limits of the {kind}")
            else:
                limits = found[kind] = specification(problem, hardware, goal, kind, rival)
        room_mm = room_at_limits(made.model, found) if kind == "housing" and found else {}
        lines.append(line_of(result, row, kind, limits, name, room_mm))
    return lines


def room_at_limits(model: DesignModel, found: Mapping[Kind, Sequence[PropertyLimit]]) -> dict[str, float]:
    """What camera and lens take up in the housing where each is as large as its maker is told, by requirement [mm].

    No more than the housing that is named has room for: a larger camera leaves room for a smaller lens.
    """
    parts = model.problem.parts.of(model.hardware)
    largest = {
        kind: changed(parts[kind], {
            one.name: one.together for one in found.get(kind, ()) if one.name in SIZES and one.together is not None
        })
        for kind in ("camera", "lens")
    }  # fmt: skip
    sizes = sizes_at_worst(largest["camera"], largest["lens"], model.spacer_m, model.port)
    return {name: 1e3 * min(needed, had) for name, (needed, had) in sizes.items()}


def nearest_rival(result: Result, kind: str, goal: Objective) -> tuple[float, str]:
    """The minimised objective of the best system with another part of a kind that is not as good, and its id.

    One that is better by likeliest values, and was passed over for how often it holds, is no limit to stay below.
    """
    best = result.best
    assert best is not None
    own = best.hardware.parts[kind].id if kind in best.hardware.parts else ""
    for other in other_systems(result):
        differs = other.hardware.get(kind) not in (None, own)
        if differs and other.objective_value is not None and (other.worse_frac or 0.0) > AS_GOOD:
            value = goal.minimised(other.objective_value)
            if best.objective_value is None or value > goal.minimised(best.objective_value):
                return value, other.hardware[kind]
    return math.inf, ""


def line_of(
    result: Result, row: BillRow, kind: Kind, limits: Sequence[PropertyLimit], rival: str,
    room_mm: Mapping[str, float],
) -> TenderLine:  # fmt: skip
    """One line with its facts."""
    own = row.id
    others = [one.hardware[kind] for one in other_systems(result) if one.hardware.get(kind) not in (None, own)]
    if kind == "camera":  # the same images, whoever delivers
        others = [str(item["part"]) for item in (result.robustness or {}).get("siblings") or []] + others
    name = f"{row.manufacturer} {row.model}".strip() or own
    facts = tuple(facts_of(result, kind, own, limits, room_mm))
    return TenderLine(kind, own, name, row.generic, row.to_buy, tuple(dict.fromkeys(others)), rival, facts)


def facts_of(
    result: Result, kind: Kind, part_id: str, limits: Sequence[PropertyLimit], room_mm: Mapping[str, float]
) -> Iterator[AskedFact]:
    """What a maker is asked of a part: what limits it, what every part must say, what is not known of this one."""
    by_key: dict[str, list[PropertyLimit]] = {}
    for limit in limits:
        by_key.setdefault(OF_FIELDS.get(limit.name, limit.name), []).append(limit)
    doubted = {a.path.rpartition(".")[2]: a for a in result.assumptions if a.part == part_id}
    published = cells_of(part_id)
    wanted = [*by_key, *REQUIRED[kind], *(name for name in doubted if name in COLUMNS[kind])]
    wanted += [*VITAL.get(kind, ()), *ALWAYS]
    for key in dict.fromkeys(wanted):
        column = COLUMNS[kind].get(key)
        if column is None or key in NOT_ASKED:
            continue
        known = "estimated" if key in doubted else "published" if published.get(key) else "not known"
        value = published.get(key, "")
        if not value and key in doubted and isinstance(doubted[key].value, (int, float)):
            value = format_number(float(doubted[key].value), 3)
        ends = by_key.get(key, [])
        told = [limit_texts(limit, column) for limit in ends]
        needed, best, together = (" and ".join(filter(None, texts)) for texts in zip(*told, strict=True)) if told else (
            "", "", ""
        )  # fmt: skip
        if beside := needed_beside(result, kind, key, room_mm):
            needed = together = beside
        loose = bool(ends) and all(one.together is None or may_be_far(one.together / one.value) for one in ends)
        yield AskedFact(key, words_for(column), column_unit(column), needed, best, together, value, known, loose)


def may_be_far(ratio: float) -> bool:
    """Whether a number may differ so much from the named part's that no part that is offered comes near to it."""
    return abs(math.log(ratio)) > math.log(LOOSE)


def needed_beside(result: Result, kind: Kind, key: str, room_mm: Mapping[str, float] = EMPTY) -> str:
    """What a fact must be for other reasons than the light: depth, room for camera and lens, what fits or is asked for.

    Empty where nothing is.
    """
    if key == "depth_rating_m":
        deep_m = depth_m(result)
        return "" if deep_m is None else f"at least {format_number(deep_m)} m"
    if kind == "housing" and key in ROOM_FOR:
        needed_mm = room_needed_mm(result, ROOM_FOR[key])
        if needed_mm is None:
            return ""
        most_mm = max(needed_mm, room_mm.get(ROOM_FOR[key], 0.0))
        return f"at least {format_number(float(math.ceil(round(most_mm, 6))))} mm"
    if key == "mounts":
        return " or ".join(shared_mounts(result))
    if kind == "camera" and key in ("colour", "shutter"):
        return ", ".join(sorted(asked_words(result, key)))
    return ""


def room_needed_mm(result: Result, requirement: str) -> float | None:
    """What camera and lens take up in the housing; None where nothing holds it."""
    assert result.best is not None
    known = [m.value for m in result.best.as_set.margins if m.requirement == requirement]
    return max((value for value in known if value is not None), default=None)


def shared_mounts(result: Result) -> list[str]:
    """The mounts that camera and lens share, as the catalogue states them."""
    assert result.best is not None
    camera, lens = (cells_of(result.best.hardware.parts[kind].id).get("mounts", "") for kind in ("camera", "lens"))
    return sorted(({*camera.split("|")} & {*lens.split("|")}) - {""})


def asked_words(result: Result, key: str) -> set[str]:
    """What the scenes ask of a camera in a word, where they do."""
    places = [result.mission, *(result.mission.get("scenes") or [])]
    asked = {(place.get("requirements") or {}).get(key) for place in places}
    return {str(word) for word in asked - {None, "any"}}


def column_unit(column: Column) -> str:
    """The unit of a column's numbers; of words what may stand there."""
    if column.form != "number":
        return column.allowed() if column.form == "choice" else ""
    return unit_told(column.name)


def limit_texts(limit: PropertyLimit, column: Column) -> tuple[str, str, str]:
    """Limits in words: alone, to stay the best, and all together; rounded to the safe side."""
    if limit.name in OF_FIELDS:  # a scale of a whole curve
        told = [f"{format_number(100.0 * end / limit.value, 3)} % of the named part's at each wavelength"
                if end is not None else "" for end in (limit.feasible, limit.best, limit.together)]  # fmt: skip
        told = [text and f"at least {text}" for text in told]
        return told[0], told[1], told[2]
    ends = (limit.feasible, limit.best, limit.together)
    feasible, best, together = (end_text(end, limit, column) for end in ends)
    return feasible, best, together


def end_text(end: float | None, limit: PropertyLimit, column: Column) -> str:
    """One limit in words: `at least 27 400 lm`; empty where none was found."""
    if end is None:
        return ""
    digits = 2 - math.floor(math.log10(abs(end)))
    outward = math.ceil if limit.more_is_better else math.floor
    safe = outward(round(end * 10.0**digits, 6)) / 10.0**digits
    if column.whole:
        safe = float(outward(end))
    way = "at least" if limit.more_is_better else "at most"
    return f"{way} {format_difference(safe, column_unit(column))}"

"""A front as aligned text for people: the named picks, a few points between them, how the solvers did."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from uwopt.report.text import formats, words
from uwopt.report.text.layout import Block, Text, block, columns, evenly, more_in_files, note_blocks, sentence
from uwopt.report.text.nothing_fits import infeasible_block
from uwopt.report.text.verdict import axis_name, verdict
from uwopt.results.design import lamps_in_words
from uwopt.results.front import FrontMethod, FrontObjective, FrontPoint, FrontResult
from uwopt.units import count_text, format_number

SET_BY_HAND = ("power", "snr_db", "contrast", "information")  # what steps of settings move
WHY_AS_SET = "Irises stand at marked stops; exposure, gain and light go by steps. In brackets: from the exact value."
NONE_TO_SET = "no settings to type in were found"
MOST_ROWS = 12  # of points; the files and the page hold all


def front_blocks(front: FrontResult) -> Iterator[Block | Text]:
    """The front block by block, each ending with an empty line."""
    first, second = verdict(front)
    name = formats.one_line(front.mission.get("name") or "mission", 80)
    yield block(f"{name}: {front.status}", [sentence(words.as_sentence(text)) for text in (first, second)])
    if front.points:
        yield picks_block(front)
        yield from as_set_blocks(front)
        yield points_block(front)
    if front.methods:
        yield methods_block(front)
    if front.infeasible:
        yield infeasible_block(front)
    yield from note_blocks(front.warnings)
    if front.timing_s:
        yield sentence(f"Took {words.run_time_sentence(front.timing_s)}.", "dim")


def picks_block(front: FrontResult) -> Block:
    """The points that have a name, and what each is made of."""
    heads = [(axis_name(objective), "right") for objective in front.objectives]
    table = columns(("pick", "left"), ("point", "left"), *heads, ("system", "left"))
    for pick in front.picks:
        point = front.point(pick.point)
        table.add_row(
            Text(pick.name),
            Text(point.id),
            *(Text(text) for text in value_texts(front, point)),
            Text(parts_text(point)),
        )
    notes = [sentence(f"{pick.name}: {pick.definition}", "dim") for pick in front.picks]
    return block("Named points", [table, *notes])


def as_set_blocks(front: FrontResult) -> Iterator[Block]:
    """What the named points are at settings to type in, and how far that is from the exact ones of the front."""
    objectives = [objective for objective in front.objectives if objective.name in SET_BY_HAND]
    known = {pick.name: (point := front.point(pick.point), front.values_as_set(point)) for pick in front.picks}
    if not objectives or all(values is None for _, values in known.values()):
        return
    table = columns(("pick", "left"), *((axis_name(objective), "right") for objective in objectives))
    for name, (point, values) in known.items():
        cells = [NONE_TO_SET] + [""] * (len(objectives) - 1)
        if values is not None:
            cells = [as_set_text(objective, point.values[objective.name], values) for objective in objectives]
        table.add_row(Text(formats.one_line(name, 40)), *map(Text, cells))
    yield block("The same at settings to type in", [sentence(WHY_AS_SET, "dim"), table])


def as_set_text(objective: FrontObjective, exact: float, as_set: Mapping[str, float]) -> str:
    """`59.92 kbit/m² (-0.94 %)`, `33.20 dB (-0.38 dB)`: a value at settings to type in, and how far from the exact."""
    value = as_set[objective.name]
    told = formats.quantity(value, objective.unit, 4)
    if objective.unit == "dB":
        return f"{told} ({round(value - exact, 2) + 0.0:+.2f} dB)"  # adding 0 makes +0 of -0
    return f"{told} ({round(100.0 * (value / exact - 1.0), 1) + 0.0:+.1f} %)" if exact else told


def points_block(front: FrontResult) -> Block:
    """Points evenly along the front."""
    shown = points_shown(front.points)
    heads = [(axis_name(objective), "right") for objective in front.objectives]
    table = columns(("point", "left"), *heads, ("system", "left"), ("pick", "left"))
    names = pick_names(front)
    for point in shown:
        texts = [Text(text) for text in value_texts(front, point)]
        table.add_row(Text(point.id), *texts, Text(parts_text(point)), Text(names.get(point.id, "")))
    return block("The front, at exact settings", [table, *more_in_files(len(front.points) - len(shown), "point")])


def points_shown(points: Sequence[FrontPoint]) -> list[FrontPoint]:
    """The first, the last and some between, of every choice of hardware one if there is room."""
    if len(points) <= MOST_ROWS:
        return list(points)
    firsts = {point.curve: n for n, point in reversed(list(enumerate(points)))}
    places = sorted(firsts.values()) if len(firsts) <= MOST_ROWS else []
    even = evenly(range(len(points)), MOST_ROWS)
    places += [place for place in even if place not in places][: MOST_ROWS - len(places)]
    return [points[place] for place in sorted(places)]


def value_texts(front: FrontResult, point: FrontPoint) -> list[str]:
    """The objectives with their units."""
    return [words.axis_text(objective, point) for objective in front.objectives]


def parts_text(point: FrontPoint) -> str:
    """Hardware by ids."""
    hardware = point.design.hardware
    *ids, light = (words.part_id(part) for part in hardware.named.values())
    return " + ".join([*ids, lamps_in_words(hardware.light_count, light)])


def methods_block(front: FrontResult) -> Block:
    """How each solver did."""
    heads = [(head, "left" if n < 2 else "right") for n, head in enumerate(METHOD_HEADS)]
    table = columns(*heads)
    for row in method_rows(front):
        table.add_row(*(Text(text) for text in row))
    note = (
        "hypervolume: share of the box from the best corner to 1.1 times the front's range, logarithms of power"
        " and cost"
    )
    return block("Solvers", [table, sentence(note, "dim")])


def pick_names(front: FrontResult) -> dict[str, str]:
    """The names of a point's picks, by the point's id."""
    names: dict[str, list[str]] = {}
    for pick in front.picks:
        names.setdefault(pick.point, []).append(formats.one_line(pick.name, 40))
    return {point: ", ".join(own) for point, own in names.items()}


def method_rows(front: FrontResult) -> list[list[str]]:
    """How each method did, in words."""
    return [method_texts(method) for method in front.methods]


METHOD_HEADS = (
    "method", "status", "time", "points", "evaluations", "hypervolume", "of the exact one", "IGD+",
)  # fmt: skip


def method_texts(method: FrontMethod) -> list[str]:
    """One method in words; dashes where a figure has no meaning."""
    bound = method.hypervolume_bound
    most = "" if bound is None else f" (at most {format_number(bound, 5)})"
    ratio = method.hypervolume_ratio
    return [
        formats.one_line(method.name, 30), formats.one_line(method.status, 30),
        formats.quantity(method.seconds, "s", 2),
        count_text(method.n_points), count_text(method.evaluations),
        format_number(method.hypervolume, 5) + most,
        formats.quantity(None) if ratio is None else formats.share(ratio), formats.quantity(method.igd_plus, "", 2),
    ]  # fmt: skip

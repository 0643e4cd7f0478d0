"""A table over varied keys as text for people: where which system wins, a few points, how the optimum moves."""

from __future__ import annotations

import math
from collections.abc import Iterator

from uwopt.catalog.records import OF_A_DESIGN
from uwopt.report.text import formats, words
from uwopt.report.text.layout import Block, Text, block, columns, evenly, more_in_files, note_blocks, sentence
from uwopt.report.text.nothing_fits import more_time
from uwopt.results.whatif import KeyValue, SpiderLine, Switch, WhatIf, WhatIfPoint, WinningSystem
from uwopt.units import counted, format_quantity

MOST_ROWS = 14  # of points; the files hold all
MOST_SENTENCES = 24  # of switches


def whatif_blocks(table: WhatIf) -> Iterator[Block | Text]:
    """The table block by block, each ending with an empty line."""
    name = formats.one_line(table.mission.get("name") or "mission", 80)
    yield block(f"{name}: what if", [sentence(text) for text in opening(table)])
    if table.switches:
        yield block("Where another system takes over", switch_lines(table))
    if table.systems:
        yield systems_block(table)
    if table.points:
        yield points_block(table)
    if table.spider:
        yield spider_block(table)
    yield from note_blocks(table.warnings)
    yield sentence(f"Took {words.run_time_sentence(table.timing_s)}.", "dim")


def opening(table: WhatIf) -> list[str]:
    """What was varied, and how many systems are best somewhere."""
    goal = f"{table.objective.direction} {formats.one_line(table.objective.name, 60)}"
    made = []
    if table.keys:
        fits = sum(point.system is not None for point in table.points)
        known = sum(point.status != "stopped" or point.system is not None for point in table.points)
        every = math.prod(len(key.values) for key in table.keys)
        best = len({*(point.system for point in table.points), *winners_between(table)} - {None})
        keys = " and ".join(formats.one_line(key.key, 60) for key in table.keys)
        proven = all(point.status in ("optimal", "infeasible") for point in table.points)
        if known < every:
            cut = "Interrupted" if table.status == "interrupted" else "Stopped by a limit"
            some = f"with {known} of {every} points over {keys} known" if known else (
                f"before any of {counted(every, 'point')} over {keys} was known"
            )  # fmt: skip
            made.append(f"{cut} {some}. {more_time(table)}.")
        if known:
            made.append(
                f"{counted(known, 'point')} over {keys}, {goal}: something fits at {fits} of them, "
                f"{counted(best, 'system')} win{'s' if best == 1 else ''} somewhere"
                f"{'; each is proven over the whole catalogue' if proven else ''}."
            )
        if known and table.confidence != "central":
            share = table.confidence
            often = "at every end" if isinstance(share, str) else f"in {100.0 * share:g} % of the scenarios"
            made.append(f"Each holds {often} of what is uncertain; the objective is its median over them.")
    if table.spider:
        made.append(f"Each number that the mission states, alone, by 20 % either way, {goal}.")
    return made


# ---------------------------------------------------------------- switches


def winners_between(table: WhatIf) -> set[int | None]:
    """The systems that win beside a switch, some of them between points alone."""
    return {system for switch in table.switches for system in (switch.first, switch.second)}


def switch_lines(table: WhatIf) -> list[Text]:
    """A sentence a switch, under the values of the other keys."""
    lines, before = list[Text](), None
    for switch in table.switches[:MOST_SENTENCES]:
        others = others_text(table, switch)
        if others and others != before:
            lines.append(Text(f"{others}:"))
        before = others
        lines.append(sentence(("- " if not others else "  - ") + switch_text(table, switch)))
    return [*lines, *more_in_files(len(table.switches) - MOST_SENTENCES, "change")]


def others_text(table: WhatIf, switch: Switch) -> str:
    """`water II`; empty where only one key is varied."""
    return ", ".join(
        f"{formats.one_line(key.key, 40)} {varied_value_text(value, key.unit)}"
        for key, value in zip(table.keys, switch.others, strict=True)
        if value is not None
    )


def switch_text(table: WhatIf, switch: Switch) -> str:
    """`beyond speed_m_s 0.71 m/s another camera: avt-...`."""
    unit = next(key.unit for key in table.keys if key.key == switch.key)
    low, high = formats.quantities_apart(switch.low, switch.high, unit=unit)
    key = formats.one_line(switch.key, 40)
    where = nowhere = f"beyond {key} {low}"
    if switch.high - switch.low > 0.02 * max(abs(switch.low), abs(switch.high)):
        where = f"between {key} {low} and {high}"
        nowhere = f"beyond some {key} between {low} and {high}"
    if switch.second is None:
        return f"{nowhere} nothing fits"
    if switch.first is None:
        return f"{nowhere} something fits: {formats.one_line(table.systems[switch.second].parts, 300)}"
    said = f"{where} {change_text(table.systems[switch.first], table.systems[switch.second])}"
    return said if switch.proven else f"{said} (of these two systems)"


def change_text(first: WinningSystem, second: WinningSystem) -> str:
    """What is different in the second of two systems."""
    other = [kind for kind in OF_A_DESIGN if first[kind] != second[kind]]
    told = [f"another {kind}, {formats.one_line(second[kind], 90)}" for kind in other]
    if first.light_count != second.light_count:
        told.append(f"{counted(second.light_count, 'light')} instead of {first.light_count}")
    made = " (a part to be made)" if second.generic and not first.generic else ""
    return words.listed(told) + made


# ---------------------------------------------------------------- tables


def systems_block(table: WhatIf) -> Block:
    """The systems that are best somewhere, by number."""
    grid = columns(("no.", "right"), ("wins at", "right"), ("system", "left"))
    for index, system in enumerate(table.systems):
        wins = sum(point.system == index for point in all_points(table))
        made = " (with a part to be made)" if system.generic else ""
        where = str(wins or "between")  # points, or none of them
        grid.add_row(Text(str(index + 1)), Text(where), Text(formats.one_line(system.parts, 300) + made))
    return block("Systems", [grid])


def all_points(table: WhatIf) -> list[WhatIfPoint]:
    """Those of the table and of its spider."""
    return [*table.points, *(point for line in table.spider for point in line.points)]


def points_block(table: WhatIf) -> Block:
    """Points evenly over the table."""
    shown = evenly(table.points, MOST_ROWS)
    unit = table.objective.unit
    heads = [(formats.one_line(key.key, 40), "right") for key in table.keys]
    goal = formats.one_line(table.objective.name, 40)
    beside = [name for name in ("power", "cost") if name != table.objective.name]
    grid = columns(*heads, (goal, "right"), *((name, "right") for name in beside), ("no.", "right"))
    currency = table.mission.get("limits", {}).get("currency", "")
    for point in shown:
        figures = point.figures
        cost = formats.money(figures["cost"], currency) if "cost" in figures else formats.quantity(None)
        texts = {"power": formats.quantity(figures.get("power_w"), "W"), "cost": cost}
        best = "nothing fits" if point.system is None else format_quantity(point.objective, unit, 4)
        grid.add_row(
            *(Text(varied_value_text(value, key.unit)) for key, value in zip(table.keys, point.values, strict=True)),
            Text(best if point.status != "stopped" or point.system is not None else "not known"),
            *(Text(texts[name]) for name in beside),
            Text("" if point.system is None else str(point.system + 1)),
        )
    left = len(table.points) - len(shown)
    return block("Some of the points" if left else "All points", [grid, *more_in_files(left, "point")])


def varied_value_text(value: KeyValue, unit: str) -> str:
    """A value with its unit."""
    return formats.one_line(value, 40) if isinstance(value, str) else format_quantity(value, unit, 4)


def spider_block(table: WhatIf) -> Block:
    """How the optimum moves with each quantity, the one that moves it most first."""
    grid = columns(("quantity", "left"), ("as it is", "right"), ("- 20 %", "right"), ("+ 20 %", "right"))
    for line in sorted(table.spider, key=lambda line: -moved_by(line)):
        ends = [next((p for p in line.points if p.values[0] == factor), None) for factor in (0.8, 1.2)]
        texts = [end_text(table, line, point) for point in ends]
        grid.add_row(Text(line.key), Text(format_quantity(line.base, line.unit)), *(Text(text) for text in texts))
    return block(f"{words.capital(formats.one_line(table.objective.name, 40))} by each quantity alone", [grid])


def end_text(table: WhatIf, line: SpiderLine, point: WhatIfPoint | None) -> str:
    """The optimum at one end of a quantity; a mark where the system is another."""
    if point is None:
        return "not allowed"
    if point.objective is None:
        return "nothing fits" if point.status == "infeasible" else "not known"
    base = next((p for p in line.points if p.values[0] == 1.0), None)
    mark = "" if base is None or base.system == point.system else " *"
    return format_quantity(point.objective, table.objective.unit, 4) + mark


def moved_by(line: SpiderLine) -> float:
    """How far the optimum moves over a quantity's points; infinitely where something fits at some alone."""
    values = [point.objective for point in line.points]
    known = [value for value in values if value is not None]
    return float("inf") if known and len(known) < len(values) else max(known, default=0.0) - min(known, default=0.0)


def short_system(table: WhatIf, index: int) -> str:
    """A system's number with what is not the same in all systems of a table, for a legend."""
    system = table.systems[index]
    differ = [kind for kind in OF_A_DESIGN if len({one[kind] for one in table.systems}) > 1] or list(OF_A_DESIGN)
    told = [formats.one_line(system[kind], 48) for kind in differ]
    if len({one.light_count for one in table.systems}) > 1:
        told.append(counted(system.light_count, "light"))
    return f"{index + 1}: {' + '.join(told)}{' (a part to be made)' if system.generic else ''}"

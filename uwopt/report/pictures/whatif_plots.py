"""Plots of a table over varied keys: the optimum with its switch points, the map of systems, the spider.

Plain Plotly figures as in `plots`. Where systems are told by colour, it is that of the map of systems.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import Any

from uwopt.report.pictures.plots import DASHES, GREY, Plot, axis, layout, numbers
from uwopt.report.pictures.system_maps import (
    COLOURS,
    YELLOW,
    colour_of,
    grid_of,
    hover,
    is_numeric,
    markup_free,
    middle_of,
    switches_at,
    system_map,
    titled,
)
from uwopt.report.text import formats
from uwopt.report.text.whatif_tables import change_text, moved_by, varied_value_text
from uwopt.results.whatif import KeyValue, SpiderLine, Switch, WhatIf, WhatIfPoint
from uwopt.units import symbol

SYMBOLS = ("circle", "square", "diamond", "cross", "triangle-up", "x", "star")
LINES = ("solid", *(dash for dash in DASHES if dash != "solid"))
DARK_COLOURS = tuple(colour for colour in COLOURS if colour != YELLOW)  # a yellow line is hardly seen on white
APART = 0.06  # of an axis: labels that are closer hide each other
MOST_SPOKES = 10  # lines of a spider with a name each; the table below it has all
MOVES = 1e-3  # of the optimum: what moves it less is drawn with all that moves nothing


def whatif_figures(table: WhatIf) -> dict[str, Plot]:
    """All plots of a table by name."""
    made: dict[str, Plot] = {}
    if table.points:
        fits = any(point.objective is not None for point in table.points)  # else there is no optimum to draw
        over_two = len(table.keys) == 2 and is_numeric(table, 0) == is_numeric(table, 1)
        if fits and not over_two:
            made["optimum"] = line_plot(table)
        drawn = system_map(table)
        if drawn is not None:
            made["map"] = drawn
        if fits and over_two:
            made["values"] = value_map(table)
    if table.spider:
        made["spider"] = spider_plot(table)
    return made


def goal_title(table: WhatIf) -> str:
    """The objective with its unit."""
    unit = f" [{symbol(table.objective.unit)}]" if table.objective.unit else ""
    return formats.one_line(table.objective.name, 60) + unit


# ---------------------------------------------------------------- one numeric key


def line_plot(table: WhatIf) -> Plot:
    """The optimum over the numeric key, a line for each value of the other; diamonds are switches.

    Lines differ in their dashes and are named at their ends; marks have the colours of the systems.
    """
    along = next((n for n in range(len(table.keys)) if is_numeric(table, n)), 0)
    other = 1 - along if len(table.keys) == 2 else None
    values: list[KeyValue | None] = [None] if other is None else list(table.keys[other].values)
    data: list[dict[str, Any]] = []
    for number, value in enumerate(values):
        own = [p for p in table.points if other is None or p.values[other] == value]
        if is_numeric(table, along):
            own.sort(key=lambda p: float(p.values[along]))
        name = "optimum" if value is None or other is None else (
            f"{formats.one_line(table.keys[other].key, 30)} {varied_value_text(value, table.keys[other].unit)}"
        )  # fmt: skip
        data.append({
            "type": "scatter", "mode": "lines+markers", "name": markup_free(name), "showlegend": False,
            "x": [p.values[along] for p in own], "y": [p.objective for p in own],
            "line": {"color": GREY, "width": 2, "dash": LINES[number % len(LINES)]},
            "marker": {
                "size": 7, "color": [colour_of(p.system) for p in own], "line": {"color": GREY, "width": 0.5}
            },
            "text": [hover(table, p) for p in own], "hovertemplate": "%{x}: %{y}<br>%{text}", "connectgaps": False,
        })  # fmt: skip
        marks = switch_marks(table, along, value, own, first=number == 0) if is_numeric(table, along) else None
        if marks is not None:
            data.append(marks)
        if value is not None:
            data.append(end_name(own, along, markup_free(name), marks["x"][-1:] if marks else []))
    return {
        "data": [trace for trace in data if trace["x"]],
        "layout": layout(
            height=460, xaxis=axis(titled(table, along)), yaxis=axis(goal_title(table), rangemode="tozero"),
        ) | {"margin": {"l": 64, "r": 16 if other is None else 110, "t": 16, "b": 52}},
    }  # fmt: skip


def end_name(points: Sequence[WhatIfPoint], along: int, name: str, mark: Sequence[float]) -> dict[str, Any]:
    """A line's name at its last point at which something fits, or at its last mark where that is farther."""
    last = [point for point in points if point.objective is not None][-1:]
    at = [max(p.values[along], *mark) if mark else p.values[along] for p in last]
    return {
        "type": "scatter", "mode": "text", "x": at, "y": [p.objective for p in last],
        "text": [f"   {name}"] * len(last), "textposition": "middle right", "showlegend": False, "hoverinfo": "skip",
        "cliponaxis": False,
    }  # fmt: skip


def switch_marks(
    table: WhatIf, along: int, other: KeyValue | None, points: Sequence[WhatIfPoint], *, first: bool
) -> dict[str, Any]:
    """Diamonds on one line where the system changes, with the numbers of both where there is room."""
    mine = sorted(switches_at(table, along, other), key=middle_of)
    places = [(middle_of(s), optimum_between(points, along, middle_of(s)), s) for s in mine]
    known = [place for place in places if place[1] is not None]
    values = [float(value) for value in table.keys[along].values]
    room, last, said = APART * (max(values) - min(values)), float("-inf"), list[str]()
    for x, _, switch in known:
        said.append(f"{number_of(switch.first)} → {number_of(switch.second)}" if x - last >= room else "")
        last = x if said[-1] else last
    return {
        "type": "scatter", "mode": "markers+text", "name": "another system takes over", "legendgroup": "switch",
        "showlegend": first, "x": numbers([x for x, _, _ in known]), "y": numbers([y for _, y, _ in known]),
        "marker": {"symbol": "diamond-open", "size": 13, "color": GREY, "line": {"width": 2}},
        "text": said, "textposition": "top center", "textfont": {"size": 11},
        "hovertext": [switch_hover(table, switch) for _, _, switch in known],
        "hovertemplate": "%{x}<br>%{hovertext}<extra></extra>",
    }  # fmt: skip


def number_of(system: int | None) -> str:
    """As the table of systems counts."""
    return "–" if system is None else str(system + 1)


def switch_hover(table: WhatIf, switch: Switch) -> str:
    """What changes there."""
    if switch.first is None or switch.second is None:
        return "nothing fits beyond" if switch.second is None else "something fits beyond"
    return "beyond: " + markup_free(change_text(table.systems[switch.first], table.systems[switch.second]))


def optimum_between(points: Sequence[WhatIfPoint], along: int, x: float) -> float | None:
    """The optimum at a place between points; that of the nearer side where the other has none."""
    for a, b in itertools.pairwise(points):
        low, high = float(a.values[along]), float(b.values[along])
        if low <= x <= high:
            if a.objective is None or b.objective is None:
                return b.objective if a.objective is None else a.objective
            share = (x - low) / (high - low) if high > low else 0.0
            return a.objective + share * (b.objective - a.objective)
    return None


# ---------------------------------------------------------------- two keys


def value_map(table: WhatIf) -> Plot:
    """The optimum itself over two keys."""
    xs, ys, points = grid_of(table)
    rows = [[points.get((x, y)) for x in xs] for y in ys]
    return {
        "data": [{
            "type": "heatmap", "x": list(xs), "y": list(ys), "colorscale": "Viridis",
            "z": [[None if p is None else p.objective for p in row] for row in rows],
            "colorbar": {"title": {"text": goal_title(table)}},
            "hovertemplate": "%{x}, %{y}: %{z}<extra></extra>",
        }],
        "layout": layout(height=520, xaxis=axis(titled(table, 0)), yaxis=axis(titled(table, 1))),
    }  # fmt: skip


# ---------------------------------------------------------------- spider


def spider_plot(table: WhatIf) -> Plot:
    """The optimum over each quantity in per cent of what the mission states, the steepest first.

    Marks are open where another system wins than as the mission stands. Quantities that move nothing share a line.
    """
    lines = sorted(table.spider, key=lambda line: -moved_by(line))
    moving, less = first_of(line for line in lines if moves(line))
    data: list[dict[str, Any]] = [
        {
            "type": "scatter", "mode": "lines", "name": f"{len(less)} more, which move less", "legendgroup": "less",
            "showlegend": number == 0, "x": changes_pct(line), "y": [p.objective for p in line.points],
            "connectgaps": False, "line": {"color": GREY, "width": 1, "dash": "dot"}, "legendrank": 1001,
            "text": [markup_free(line.key)] * len(line.points), "hovertemplate": "%{text}: %{x} %: %{y}<extra></extra>",
        }
        for number, line in enumerate(less)
    ]  # fmt: skip
    for number, line in enumerate(moving):
        base, mark = system_as_stated(line), SYMBOLS[number % len(SYMBOLS)]
        colour = DARK_COLOURS[number % len(DARK_COLOURS)]
        data.append({
            "type": "scatter", "mode": "lines+markers", "name": markup_free(line.key),
            "x": changes_pct(line), "y": [p.objective for p in line.points], "connectgaps": False,
            "line": {"color": colour, "width": 2, "dash": LINES[number % len(LINES)]},
            "marker": {
                "size": 9, "color": colour, "line": {"width": 2, "color": colour},
                "symbol": [mark if p.system == base else f"{mark}-open" for p in line.points],
            },
            "text": [hover(table, p) for p in line.points],
            "hovertemplate": "%{x} %: %{y}<br>%{text}",
        })  # fmt: skip
    still = [line for line in lines if not moves(line)]
    if still:
        widest = max(still, key=lambda line: len(line.points))
        data.append({
            "type": "scatter", "mode": "lines", "name": f"{len(still)} more, which move nothing",
            "x": changes_pct(widest), "y": [p.objective for p in widest.points], "connectgaps": False,
            "line": {"color": GREY, "width": 1}, "hoverinfo": "skip",
        })  # fmt: skip
    return {
        "data": data,
        "layout": layout(height=520, xaxis=axis("change of the quantity [%]"), yaxis=axis(goal_title(table))),
    }


def first_of(lines: Iterable[SpiderLine]) -> tuple[list[SpiderLine], list[SpiderLine]]:
    """Those that a legend can name, and the rest."""
    some = list(lines)
    return some[:MOST_SPOKES], some[MOST_SPOKES:]


def changes_pct(line: SpiderLine) -> list[Any]:
    """By how much the points of a line are more than what the mission states."""
    return numbers([100.0 * (float(p.values[0]) - 1.0) for p in line.points])


def system_as_stated(line: SpiderLine) -> int | None:
    """The system that wins as the mission stands."""
    return next((p.system for p in line.points if float(p.values[0]) == 1.0), None)


def moves(line: SpiderLine) -> bool:
    """Whether a quantity moves the optimum by more than a mark."""
    return moved_by(line) > MOVES * max((abs(p.objective) for p in line.points if p.objective is not None), default=0.0)

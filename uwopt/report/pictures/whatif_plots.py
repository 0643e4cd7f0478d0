"""Plots of a table over varied keys: the optimum with its switch points, the map of systems, the spider.

Plain Plotly figures as in `plots`; systems have one colour each in all of them.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

from uwopt.report.pictures.plots import (
    BLUE,
    DASHES,
    GREEN,
    GREY,
    PURPLE,
    VERMILLION,
    Plot,
    axis,
    layout,
    numbers,
)
from uwopt.report.text import formats
from uwopt.report.text.whatif_tables import change_text, short_system, spread, value_text
from uwopt.results.whatif import KeyValue, Switch, WhatIf, WhatIfPoint
from uwopt.units import symbol

COLOURS = (BLUE, VERMILLION, GREEN, "#e69f00", PURPLE, "#56b4e9", "#b2912f", "#4d4d4d", "#f15854", "#decf3f", "#60bd68")
NOTHING = "rgba(128,128,128,0.25)"  # where nothing fits
SYMBOLS = ("circle", "square", "diamond", "cross", "triangle-up", "x", "star")


def whatif_figures(table: WhatIf) -> dict[str, Plot]:
    """All plots of a table by name."""
    made: dict[str, Plot] = {}
    if table.points:
        numeric = [key for key in table.keys if all(isinstance(value, (int, float)) for value in key.values)]
        if len(table.keys) == 2 and len(numeric) != 1:
            made["map"] = map_plot(table)
            made["values"] = value_map(table)
        else:
            made["optimum"] = line_plot(table)
    if table.spider:
        made["spider"] = spider_plot(table)
    return made


def titled(table: WhatIf, index: int) -> str:
    """A key with its unit."""
    key = table.keys[index]
    return formats.one_line(key.key, 40) + (f" [{symbol(key.unit)}]" if key.unit else "")


def goal_title(table: WhatIf) -> str:
    """The objective with its unit."""
    unit = f" [{symbol(table.objective.unit)}]" if table.objective.unit else ""
    return formats.one_line(table.objective.name, 60) + unit


def colour_of(system: int | None) -> str:
    """A system's colour."""
    return NOTHING if system is None else COLOURS[system % len(COLOURS)]


def hover(table: WhatIf, point: WhatIfPoint) -> str:
    """What a point says of itself."""
    if point.system is None:
        return "nothing fits" if point.status == "infeasible" else "not known"
    parts = formats.one_line(table.systems[point.system].parts, 200)
    return f"{point.system + 1}: {markup_free(parts)}"


def markup_free(text: str) -> str:
    """Text in which Plotly finds no markup."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


# ---------------------------------------------------------------- one numeric key


def line_plot(table: WhatIf) -> Plot:
    """The optimum over the numeric key, a line for each value of the other; diamonds are switches."""
    along = next((n for n, key in enumerate(table.keys) if not isinstance(key.values[0], str)), 0)
    other = 1 - along if len(table.keys) == 2 else None
    values: list[KeyValue | None] = [None] if other is None else list(table.keys[other].values)
    data: list[dict[str, Any]] = []
    for number, value in enumerate(values):
        own = [p for p in table.points if other is None or p.values[other] == value]
        if not isinstance(table.keys[along].values[0], str):
            own.sort(key=lambda p: float(p.values[along]))
        name = "optimum" if value is None or other is None else (
            f"{formats.one_line(table.keys[other].key, 30)} {value_text(value, table.keys[other].unit)}"
        )  # fmt: skip
        data.append({
            "type": "scatter", "mode": "lines+markers", "name": markup_free(name),
            "x": [p.values[along] for p in own], "y": [p.objective for p in own],
            "line": {"color": COLOURS[number % len(COLOURS)], "width": 2, "dash": DASHES[(number + 2) % len(DASHES)]},
            "marker": {"size": 5}, "text": [hover(table, p) for p in own], "hovertemplate": "%{x}: %{y}<br>%{text}",
            "connectgaps": False,
        })  # fmt: skip
        data.append(switch_marks(table, along, value, own, COLOURS[number % len(COLOURS)], first=number == 0))
    return {
        "data": [trace for trace in data if trace["x"]],
        "layout": layout(
            height=460, xaxis=axis(titled(table, along)), yaxis=axis(goal_title(table), rangemode="tozero"),
        ),
    }  # fmt: skip


def switch_marks(
    table: WhatIf, along: int, other: KeyValue | None, points: Sequence[WhatIfPoint], colour: str, *, first: bool
) -> dict[str, Any]:
    """Diamonds on one line where the system changes."""
    mine = [s for s in table.switches if s.key == table.keys[along].key and (other is None or other in s.others)]
    places = [(0.5 * (s.low + s.high), between(points, along, 0.5 * (s.low + s.high)), s) for s in mine]
    known = [place for place in places if place[1] is not None]
    return {
        "type": "scatter", "mode": "markers", "name": "another system", "legendgroup": "switch", "showlegend": first,
        "x": numbers([x for x, _, _ in known]), "y": numbers([y for _, y, _ in known]),
        "marker": {"symbol": "diamond-open", "size": 11, "color": colour, "line": {"width": 2}},
        "text": [switch_hover(table, switch) for _, _, switch in known], "hovertemplate": "%{x}<br>%{text}",
    }  # fmt: skip


def switch_hover(table: WhatIf, switch: Switch) -> str:
    """What changes there."""
    if switch.first is None or switch.second is None:
        return "nothing fits beyond" if switch.second is None else "something fits beyond"
    return "beyond: " + markup_free(change_text(table.systems[switch.first], table.systems[switch.second]))


def between(points: Sequence[WhatIfPoint], along: int, x: float) -> float | None:
    """The optimum at a place between points; that of the nearer side where the other has none."""
    for a, b in itertools.pairwise(points):
        low, high = float(a.values[along]), float(b.values[along])
        if low <= x <= high:
            if a.objective is None or b.objective is None:
                return b.objective if a.objective is None else a.objective
            share = (x - low) / (high - low) if high > low else 0.0
            return a.objective + share * (b.objective - a.objective)
    return None


# ---------------------------------------------------------------- maps


def grid_of(table: WhatIf) -> tuple[list[KeyValue], list[KeyValue], dict[tuple[KeyValue, ...], WhatIfPoint]]:
    """Values along both axes, rising where they are numbers, and the points by their values."""
    axes = [
        sorted(key.values, key=float) if not any(isinstance(v, str) for v in key.values) else list(key.values)
        for key in table.keys
    ]
    return axes[0], axes[1], {tuple(point.values): point for point in table.points}


def map_plot(table: WhatIf) -> Plot:
    """Which system wins where: a colour each, and the boundaries between them as sharp as they were found."""
    xs, ys, points = grid_of(table)
    used = sorted({point.system for point in table.points if point.system is not None})
    place = {system: n + 1 for n, system in enumerate(used)}
    rows = [[points.get((x, y)) for x in xs] for y in ys]
    many = len(used) + 1
    steps = [NOTHING, *(colour_of(system) for system in used)]
    scale = [[share, colour] for n, colour in enumerate(steps) for share in (n / many, (n + 1) / many)]
    data: list[dict[str, Any]] = [{
        "type": "heatmap", "x": list(xs), "y": list(ys), "zmin": 0, "zmax": many, "colorscale": scale,
        "showscale": False, "opacity": 0.6, "xgap": 0, "ygap": 0,
        "z": [[None if p is None else 0.5 + (0 if p.system is None else place[p.system]) for p in row] for row in rows],
        "text": [["" if p is None else hover(table, p) for p in row] for row in rows],
        "hovertemplate": "%{x}, %{y}<br>%{text}<extra></extra>",
    }]  # fmt: skip
    data += [named_square(markup_free(short_system(table.systems[one], one)), colour_of(one)) for one in used]
    if any(point.system is None for point in table.points):
        data.append(named_square("nothing fits", GREY))
    data += boundary(table, xs, ys)
    axes = {"xaxis": axis(titled(table, 0)), "yaxis": axis(titled(table, 1))}
    below = {"orientation": "v", "x": 0, "y": -0.18, "yanchor": "top"}
    return {"data": data, "layout": layout(height=560 + 22 * len(used), legend=below, **axes)}


def named_square(name: str, colour: str) -> dict[str, Any]:
    """A square in the legend."""
    marker = {"symbol": "square", "size": 12, "color": colour}
    return {"type": "scatter", "mode": "markers", "x": [None], "y": [None], "name": name, "marker": marker}


def boundary(table: WhatIf, xs: Sequence[KeyValue], ys: Sequence[KeyValue]) -> list[dict[str, Any]]:
    """Lines through the switches on the edges of each cell of the grid; none where an axis has no numbers."""
    if any(isinstance(value, str) for value in (*xs, *ys)):
        return []
    on_x, on_y = dict[KeyValue, list[Switch]](), dict[KeyValue, list[Switch]]()
    for switch in table.switches:
        if switch.key == table.keys[0].key and switch.others[1] is not None:
            on_x.setdefault(switch.others[1], []).append(switch)
        elif switch.others[0] is not None:
            on_y.setdefault(switch.others[0], []).append(switch)

    def inside(found: Sequence[Switch], low: float, high: float) -> list[float]:
        middles = [0.5 * (switch.low + switch.high) for switch in found]
        return [middle for middle in middles if low <= middle <= high]

    line_x: list[float | None] = []
    line_y: list[float | None] = []
    for x0, x1 in itertools.pairwise(map(float, xs)):
        for y0, y1 in itertools.pairwise(map(float, ys)):
            ends = [(x, y) for y in (y0, y1) for x in inside(on_x.get(y, ()), x0, x1)]
            ends += [(x, y) for x in (x0, x1) for y in inside(on_y.get(x, ()), y0, y1)]
            if len(ends) < 2:
                continue
            middle = (sum(x for x, _ in ends) / len(ends), sum(y for _, y in ends) / len(ends))
            pairs = [(ends[0], ends[1])] if len(ends) == 2 else [(end, middle) for end in ends]
            for a, b in pairs:
                line_x += [a[0], b[0], None]
                line_y += [a[1], b[1], None]
    return [{
        "type": "scatter", "mode": "lines", "name": "boundary", "x": line_x, "y": line_y, "hoverinfo": "skip",
        "line": {"color": GREY, "width": 2}, "connectgaps": False,
    }]  # fmt: skip


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
    """The optimum over each quantity in per cent of what the mission states; the steepest first."""
    data = []
    for number, line in enumerate(sorted(table.spider, key=lambda line: -spread(line))):
        data.append({
            "type": "scatter", "mode": "lines+markers", "name": markup_free(line.key),
            "x": numbers([100.0 * (float(p.values[0]) - 1.0) for p in line.points]),
            "y": [p.objective for p in line.points], "connectgaps": False,
            "line": {"color": COLOURS[number % len(COLOURS)], "width": 2, "dash": DASHES[(number + 2) % len(DASHES)]},
            "marker": {"size": 7, "symbol": SYMBOLS[number % len(SYMBOLS)]},
            "text": [hover(table, p) for p in line.points], "hovertemplate": "%{x} %: %{y}<br>%{text}",
        })  # fmt: skip
    return {
        "data": data,
        "layout": layout(height=520, xaxis=axis("change of the quantity [%]"), yaxis=axis(goal_title(table))),
    }

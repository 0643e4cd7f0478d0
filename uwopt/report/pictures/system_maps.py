"""Which system wins where: regions over two numbers, strips over one, each as sharp as the switches are known.

Plain Plotly figures as in `plots`; a system has one colour in all plots of a table, and its number in the map.
"""

from __future__ import annotations

import itertools
import textwrap
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from uwopt.report.pictures.plots import BLUE, GREEN, GREY, PURPLE, VERMILLION, Plot, axis, layout
from uwopt.report.text import formats
from uwopt.report.text.whatif_tables import short_system, varied_value_text
from uwopt.results.whatif import KeyValue, Switch, WhatIf, WhatIfPoint
from uwopt.units import symbol

YELLOW = "#f0e442"
#: Okabe and Ito's, then darker ones of Tol's muted scheme; a colour that comes twice is told by its system's number.
COLOURS = (BLUE, VERMILLION, GREEN, "#e69f00", PURPLE, "#56b4e9", YELLOW, "#4d4d4d", "#882255", "#999933", "#aa4499")
NOTHING = "rgba(128,128,128,0.25)"  # where nothing fits
LINE = "#1a1a1a"
STRIP_PX = 46
LEGEND_LETTERS = 42  # of a line of a legend, which is as wide as a telephone
MOST_NAMED = 8  # systems in a legend
Place = tuple[float, float]


def colour_of(system: int | None) -> str:
    """A system's colour."""
    return NOTHING if system is None else COLOURS[system % len(COLOURS)]


def titled(table: WhatIf, index: int) -> str:
    """A key with its unit."""
    key = table.keys[index]
    return formats.one_line(key.key, 40) + (f" [{symbol(key.unit)}]" if key.unit else "")


def markup_free(text: str) -> str:
    """Text in which Plotly finds no markup."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def system_text(table: WhatIf, system: int | None, *, status: str = "infeasible") -> str:
    """A system by its number and parts."""
    if system is None:
        return "nothing fits" if status == "infeasible" else "not known"
    return f"{system + 1}: {markup_free(formats.one_line(table.systems[system].parts, 200))}"


def hover(table: WhatIf, point: WhatIfPoint) -> str:
    """What a point says of itself."""
    return system_text(table, point.system, status=point.status)


def is_numeric(table: WhatIf, index: int) -> bool:
    """Whether a key's values are numbers."""
    return all(isinstance(value, (int, float)) for value in table.keys[index].values)


def grid_of(table: WhatIf) -> tuple[list[KeyValue], list[KeyValue], dict[tuple[KeyValue, ...], WhatIfPoint]]:
    """Values along both axes, rising where they are numbers, and the points by their values."""
    axes = [sorted(key.values, key=float) if is_numeric(table, n) else list(key.values)
            for n, key in enumerate(table.keys)]  # fmt: skip
    return axes[0], axes[1], {tuple(point.values): point for point in table.points}


def system_map(table: WhatIf) -> Plot | None:
    """The map of systems over the keys; None over words of one key alone."""
    numeric = [is_numeric(table, n) for n in range(len(table.keys))]
    if not any(numeric):
        return named_map(table) if len(numeric) == 2 else None
    return region_map(table) if numeric == [True, True] else strip_map(table, numeric.index(True))


# ---------------------------------------------------------------- between neighbours


def middle_of(switch: Switch) -> float:
    """Where a switch is drawn."""
    return 0.5 * (switch.low + switch.high)


def changes(
    switches: Sequence[Switch], first: WhatIfPoint, second: WhatIfPoint, along: int
) -> list[tuple[float, int | None]]:
    """Places between two solved neighbours at which another system begins, and which; halfway where none is known."""
    low, high = float(first.values[along]), float(second.values[along])
    inside = sorted((s for s in switches if low <= middle_of(s) <= high), key=middle_of)
    if not inside and first.system != second.system:
        return [(0.5 * (low + high), second.system)]
    return [(middle_of(switch), switch.second) for switch in inside]


def switches_at(table: WhatIf, along: int, other: KeyValue | None) -> list[Switch]:
    """Those along one key at a value of the other."""
    name, at = table.keys[along].key, 1 - along
    return [s for s in table.switches if s.key == name and (len(s.others) == 1 or s.others[at] == other)]


# ---------------------------------------------------------------- one number: strips


@dataclass(frozen=True)
class Stretch:
    """Where one system wins along a strip."""

    low: float
    high: float
    system: int | None
    status: str


def stretches(table: WhatIf, along: int, other: KeyValue | None) -> list[Stretch]:
    """Of one value of the other key."""
    own = [p for p in table.points if len(p.values) == 1 or p.values[1 - along] == other]
    own.sort(key=lambda point: float(point.values[along]))
    switches, made = switches_at(table, along, other), list[Stretch]()
    for a, b in itertools.pairwise(own):
        low, system = float(a.values[along]), a.system
        for place, after in [*changes(switches, a, b, along), (float(b.values[along]), b.system)]:
            last = made[-1] if made else None
            if last is not None and last.system == system and last.high == low:
                made[-1] = Stretch(last.low, place, system, last.status)
            else:
                made.append(Stretch(low, place, system, a.status))
            low, system = place, after
    return [one for one in made if one.high > one.low]


def strip_map(table: WhatIf, along: int) -> Plot:
    """A strip for each value of the key of words, in the colours of the systems that win there."""
    others: list[KeyValue | None] = [None] if len(table.keys) == 1 else list(table.keys[1 - along].values)
    names = ["" if other is None else varied_value_text(other, table.keys[1 - along].unit) for other in others]
    by_system: dict[int | None, list[tuple[str, Stretch]]] = {}
    for name, other in zip(names, others, strict=True):
        for one in stretches(table, along, other):
            by_system.setdefault(one.system, []).append((name, one))
    data: list[dict[str, Any]] = []
    for system in sorted(by_system, key=lambda one: len(table.systems) if one is None else one):
        mine = by_system[system]
        data.append({
            "type": "bar", "orientation": "h", "y": [name for name, _ in mine],
            "x": [one.high - one.low for _, one in mine], "base": [one.low for _, one in mine],
            **in_legend(table, system), "marker": {"color": colour_of(system), "line": {"width": 0}},
            "text": ["" if system is None else str(system + 1)] * len(mine), "textposition": "inside",
            "insidetextanchor": "middle", "textangle": 0, "constraintext": "none", "width": 0.8,
            "hovertext": [
                f"{one.low:.4g} to {one.high:.4g}: {system_text(table, system, status=one.status)}" for _, one in mine
            ],
            "hovertemplate": "%{hovertext}<extra></extra>",
        })  # fmt: skip
    title = "" if len(table.keys) == 1 else titled(table, 1 - along)
    axes = {
        "xaxis": axis(titled(table, along), range=[min(table.keys[along].values), max(table.keys[along].values)]),
        "yaxis": axis(title, type="category", categoryorder="array", categoryarray=names[::-1]),
    }
    height = 110 + STRIP_PX * len(names)
    return {"data": data, "layout": below(height, data, barmode="overlay", **axes)}


# ---------------------------------------------------------------- two numbers: regions


@dataclass(frozen=True)
class RimPiece:
    """What one system has of a cell's rim, from break to break."""

    system: int | None
    rim: list[Place]


def region_map(table: WhatIf) -> Plot:
    """Regions in the colours of systems: what lies between the solved points is drawn by the switches on the grid."""
    fields: dict[int | None, tuple[list[float | None], list[float | None]]] = {}
    line_x, line_y = list[float | None](), list[float | None]()
    for pieces in cells(table):
        polygons, lines = parted(pieces)
        for system, corners in polygons:
            xs, ys = fields.setdefault(system, ([], []))
            xs += [*(x for x, _ in corners), corners[0][0], None]
            ys += [*(y for _, y in corners), corners[0][1], None]
        for a, b in lines:
            line_x += [a[0], b[0], None]
            line_y += [a[1], b[1], None]
    order = sorted(fields, key=lambda one: len(table.systems) if one is None else one)
    data = [filled(*fields[system], colour_of(system)) | in_legend(table, system) for system in order]
    data.append({
        "type": "scatter", "mode": "lines", "name": "one takes over from another", "x": line_x, "y": line_y,
        "hoverinfo": "skip", "line": {"color": LINE, "width": 1.5}, "connectgaps": False,
    })  # fmt: skip
    data.append({
        "type": "scatter", "mode": "markers", "name": "solved", "x": [p.values[0] for p in table.points],
        "y": [p.values[1] for p in table.points], "marker": {"size": 4, "color": LINE}, "cliponaxis": False,
        "text": [hover(table, p) for p in table.points], "hovertemplate": "%{x}, %{y}<br>%{text}<extra></extra>",
    })  # fmt: skip
    across, along, _ = grid_of(table)
    axes = {
        "xaxis": axis(titled(table, 0), range=[across[0], across[-1]]),
        "yaxis": axis(titled(table, 1), range=[along[0], along[-1]]), "annotations": [*labels(table)],
    }  # fmt: skip
    return {"data": data, "layout": below(440, data, **axes)}


def cells(table: WhatIf) -> Iterator[list[RimPiece]]:
    """The rims of the cells of which all corners are solved, each in pieces of one system."""
    xs, ys, points = grid_of(table)
    on_x = {y: switches_at(table, 0, y) for y in ys}
    on_y = {x: switches_at(table, 1, x) for x in xs}
    for x0, x1 in itertools.pairwise(xs):
        for y0, y1 in itertools.pairwise(ys):
            at = [points.get(corner) for corner in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
            if any(corner is None for corner in at):
                continue
            a, b, c, d = (corner for corner in at if corner is not None)
            yield rim_pieces(
                [(a, [((x, float(y0)), s) for x, s in changes(on_x[y0], a, b, 0)]),
                 (b, [((float(x1), y), s) for y, s in changes(on_y[x1], b, c, 1)]),
                 (c, backwards(d, [((x, float(y1)), s) for x, s in changes(on_x[y1], d, c, 0)])),
                 (d, backwards(a, [((float(x0), y), s) for y, s in changes(on_y[x0], a, d, 1)]))]
            )  # fmt: skip


Breaks = list[tuple[Place, int | None]]  # places at which another system begins, and which


def backwards(first: WhatIfPoint, rising: Breaks) -> Breaks:
    """The same changes met from the other end."""
    before = [first.system, *(system for _, system in rising)]
    return [(place, before[n]) for n, (place, _) in reversed([*enumerate(rising)])]


def rim_pieces(sides: Sequence[tuple[WhatIfPoint, Breaks]]) -> list[RimPiece]:
    """A cell's rim, given by each corner and the changes on the side that begins there, once around."""
    made: list[RimPiece] = []
    system, rim = sides[0][0].system, list[Place]()
    for corner, breaks in sides:
        rim.append((float(corner.values[0]), float(corner.values[1])))
        for place, after in breaks:
            made.append(RimPiece(system, [*rim, place]))
            system, rim = after, [place]
    if not made:
        return [RimPiece(system, rim)]
    return [RimPiece(made[0].system, [*rim, *made[0].rim]), *made[1:]]


def parted(pieces: Sequence[RimPiece]) -> tuple[list[tuple[int | None, list[Place]]], list[tuple[Place, Place]]]:
    """A cell's polygons by system, and the lines between them.

    Where the same two systems meet at two places of the rim, a straight line joins these; where that does not settle
    a cell, as where three systems meet, all lines run to the middle of the places.
    """
    if len(pieces) == 1:
        return [(pieces[0].system, pieces[0].rim)], []
    breaks, partner = [piece.rim[0] for piece in pieces], partners(pieces)
    if partner is None:
        middle = mean_place(breaks)
        return [(p.system, [*p.rim, middle]) for p in pieces], [(place, middle) for place in breaks]
    polygons, left = list[tuple[int | None, list[Place]]](), set(range(len(pieces)))
    while left:
        first = n = min(left)
        corners = list[Place]()
        while n in left:
            left.remove(n)
            corners += pieces[n].rim
            n = partner[(n + 1) % len(pieces)]
        polygons.append((pieces[first].system, corners))
    return polygons, [(breaks[n], breaks[m]) for n, m in enumerate(partner) if n < m]


def partners(pieces: Sequence[RimPiece]) -> list[int] | None:
    """For the place at which each piece begins the one where the same two systems meet; None where lines would not part
    the cell."""
    pairs: dict[frozenset[int | None], list[int]] = {}
    for n, piece in enumerate(pieces):
        pairs.setdefault(frozenset((pieces[n - 1].system, piece.system)), []).append(n)
    ends = [tuple(places) for places in pairs.values()]
    if any(len(places) != 2 for places in ends):
        return None
    if any(a < c < b < d for a, b in ends for c, d in ends):
        return None
    found = {n: m for a, b in ends for n, m in ((a, b), (b, a))}
    return [found[n] for n in range(len(pieces))]


def mean_place(places: Sequence[Place]) -> Place:
    """The middle of some places."""
    n = max(1, len(places))
    return sum(x for x, _ in places) / n, sum(y for _, y in places) / n


def filled(xs: list[float | None], ys: list[float | None], colour: str) -> dict[str, Any]:
    """Polygons of one colour."""
    return {
        "type": "scatter", "mode": "lines", "fill": "toself", "x": xs, "y": ys, "fillcolor": colour,
        "line": {"color": colour, "width": 0.5 if colour != NOTHING else 0}, "hoverinfo": "skip",
    }  # fmt: skip


def labels(table: WhatIf) -> Iterator[dict[str, Any]]:
    """A system's number in each of its patches: at the solved point nearest to the patch's middle."""
    xs, ys, points = grid_of(table)
    left = {(i, j) for i, x in enumerate(xs) for j, y in enumerate(ys) if (x, y) in points}
    while left:
        start = left.pop()
        system, patch, edge = points[xs[start[0]], ys[start[1]]].system, [start], [start]
        while edge:
            i, j = edge.pop()
            for near in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
                if near in left and points[xs[near[0]], ys[near[1]]].system == system:
                    left.remove(near)
                    patch.append(near)
                    edge.append(near)
        if system is not None:
            middle = mean_place([(float(i), float(j)) for i, j in patch])
            i, j = min(patch, key=lambda at: (at[0] - middle[0]) ** 2 + (at[1] - middle[1]) ** 2)
            yield {
                "x": xs[i], "y": ys[j], "text": str(system + 1), "showarrow": False, "bgcolor": "rgba(255,255,255,0.8)",
                "font": {"size": 12, "color": LINE}, "borderpad": 2, **inward(i, j, len(xs), len(ys)),
            }  # fmt: skip


def inward(i: int, j: int, columns: int, rows: int) -> dict[str, str]:
    """Anchors of a label on the rim of the map, so that it stays inside."""
    across = {0: "left", columns - 1: "right"}.get(i, "center")
    along = {0: "bottom", rows - 1: "top"}.get(j, "middle")
    return {"xanchor": across, "yanchor": along}


# ---------------------------------------------------------------- words alone


def named_map(table: WhatIf) -> Plot:
    """Which system wins at each pair of words: a coloured field each with its number."""
    xs, ys, points = grid_of(table)
    used = sorted({point.system for point in table.points if point.system is not None})
    place = {system: n + 1 for n, system in enumerate(used)}
    rows = [[points.get((x, y)) for x in xs] for y in ys]
    many = len(used) + 1
    steps = [NOTHING, *(colour_of(system) for system in used)]
    scale = [[share, colour] for n, colour in enumerate(steps) for share in (n / many, (n + 1) / many)]
    data: list[dict[str, Any]] = [{
        "type": "heatmap", "x": list(xs), "y": list(ys), "zmin": 0, "zmax": many, "colorscale": scale,
        "showscale": False, "xgap": 1, "ygap": 1,
        "z": [[None if p is None else 0.5 + (0 if p.system is None else place[p.system]) for p in row] for row in rows],
        "text": [["" if p is None or p.system is None else str(p.system + 1) for p in row] for row in rows],
        "texttemplate": "%{text}",
        "hovertext": [["" if p is None else hover(table, p) for p in row] for row in rows],
        "hovertemplate": "%{x}, %{y}<br>%{hovertext}<extra></extra>",
    }]  # fmt: skip
    data += [square(colour_of(one)) | in_legend(table, one) for one in used]
    if any(point.system is None for point in table.points):
        data.append(square(GREY) | in_legend(table, None))
    axes = {"xaxis": axis(titled(table, 0)), "yaxis": axis(titled(table, 1))}
    return {"data": data, "layout": below(440, data, **axes)}


# ---------------------------------------------------------------- legends


def in_legend(table: WhatIf, system: int | None) -> dict[str, Any]:
    """A system's name, in lines that a telephone shows whole; of many only those that win most are in the legend.

    The others have their number on the map, and stand with it in the table of systems.
    """
    if system is None:
        return {"name": "nothing fits"}
    wins = Counter(point.system for point in table.points if point.system is not None)
    most = sorted(wins, key=lambda one: (-wins[one], one))[:MOST_NAMED]
    lines = textwrap.wrap(short_system(table, system), LEGEND_LETTERS)
    return {"name": "<br>".join(map(markup_free, lines)), "showlegend": system in most}


def square(colour: str) -> dict[str, Any]:
    """A square in the legend."""
    marker = {"symbol": "square", "size": 12, "color": colour}
    return {"type": "scatter", "mode": "markers", "x": [None], "y": [None], "marker": marker}


def below(height: int, data: Sequence[Mapping[str, Any]], **more: Any) -> dict[str, Any]:
    """A layout with its legend below: `height` without it."""
    named = [trace["name"] for trace in data if "name" in trace and trace.get("showlegend", True)]
    legend_px = 20 * len(named) + 14 * sum(name.count("<br>") for name in named) + 10
    return layout(height=height + legend_px, **more) | {
        "legend": {"orientation": "v", "x": 0, "y": -72.0 / (height - 90), "yanchor": "top", "font": {"size": 11},
                   "traceorder": "normal", "itemclick": False, "itemdoubleclick": False},
        "margin": {"l": 64, "r": 16, "t": 16, "b": 76 + legend_px},
    }  # fmt: skip

"""A figure over two inputs as a map; over an input that takes words, a row or column a word."""

from __future__ import annotations

from typing import Any

from uwopt.api.mapping import FigureMap
from uwopt.quantities import BY_NAME
from uwopt.report.pictures.design_pictures import Picture
from uwopt.report.pictures.plots import Plot, axis, heat, layout, numbers
from uwopt.report.pictures.system_maps import markup_free
from uwopt.report.text import formats
from uwopt.units import symbol


def map_picture(made: FigureMap) -> Picture:
    """The map, with what its gaps and its marks are."""
    known = [value for line in made.values for value in line if value is not None]
    missed = sum(one is False for line in made.met for one in line)
    gaps = sum(one is None for line in made.met for one in line)
    name = titled(made.figure, made.unit)
    caption = f"Scene {formats.one_line(made.scene, 60)}, each point as evaluate has it, everything else as given."
    if missed:
        points = len(made.x.values) * len(made.y.values)
        caption += f" At {missed} of {points} points a requirement is missed: marked x."
    if gaps:
        caption += f" Gaps, {gaps}: {formats.one_line('; '.join(made.refused), 300)}"
    span = f"from {min(known):.4g} to {max(known):.4g}" if known else "not known anywhere"
    return Picture(
        "map", "image", f"{name} over {made.x.key} and {made.y.key}", caption,
        f"{name} runs {span}.", "plotly", map_plot(made),
    )  # fmt: skip


def map_plot(made: FigureMap) -> Plot:
    """Colours for the figure, crosses where a requirement is missed."""
    ends = [[words_of(value) for value in one.values] for one in (made.x, made.y)]
    z = [[None if value is None else float(value) for value in line] for line in made.values]
    # two words or numbers a side are a table more than a surface
    data: list[dict[str, Any]] = [
        {**heat([0], [0], [[0]], markup_free(symbol(made.unit)), scale="Viridis"), "x": ends[0], "y": ends[1],
         "z": [numbers([value if value is not None else float("nan") for value in line]) for line in z],
         "zsmooth": False}
    ]  # fmt: skip
    places = [
        (column, row)
        for row, line in enumerate(made.met)
        for column, one in enumerate(line)
        if one is False
    ]
    if places and all(isinstance(value, (int, float)) for one in (made.x, made.y) for value in one.values):
        data.append({
            "type": "scatter", "mode": "markers", "name": "a requirement is missed",
            "x": [made.x.values[column] for column, _ in places], "y": [made.y.values[row] for _, row in places],
            "marker": {"color": "#ffffff", "symbol": "x", "size": 5, "line": {"color": "#16212b", "width": 1}},
        })  # fmt: skip
    return {
        "data": data,
        "layout": layout(
            height=520, xaxis=axis(titled(made.x.key, made.x.unit)), yaxis=axis(titled(made.y.key, made.y.unit))
        ),
    }


def words_of(value: float | str) -> Any:
    """A value of an axis: a number as it is, a word without markup."""
    return markup_free(value) if isinstance(value, str) else value


def titled(name: str, unit: str) -> str:
    """A key or figure with its unit; in words where it has them."""
    known = BY_NAME.get(name)
    stem = known.words if known else formats.one_line(name, 60)
    return markup_free(stem + (f" [{symbol(unit)}]" if unit else ""))

"""Plots as PNG and SVG, drawn by Matplotlib from the same plain figures that the page shows; no browser, no network.

It draws what `plots` makes: lines, marks, fills to the line before, maps, lines and bands across, axes below each
other. Matplotlib comes with the extra `explore`.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from typing import Any, Literal

import numpy as np

from uwopt.errors import OutputError
from uwopt.report.pictures.design_pictures import Picture

WIDTH_IN, PX_PER_IN, DPI = 8.0, 80.0, 150
LINES = {"solid": "-", "dash": "--", "dot": ":", "dashdot": "-.", "longdash": (0, (9, 3))}
MARKS = {"circle": "o", "diamond-open": "D", "diamond": "D", "square": "s", "cross": "P", "x": "X"}
MAPS = {"Cividis": "cividis", "Viridis": "viridis"}
RULES: Any = {
    "text.parse_math": False, "svg.hashsalt": "uwopt", "svg.fonttype": "none", "font.size": 9.0, "axes.grid": True,
    "grid.color": "#e1e7eb", "axes.axisbelow": True,
}  # fmt: skip
NEEDED = "PNG and SVG need Matplotlib (.venv/bin/pip install '.[explore]' in uwopt's folder), or write .html or .csv"


def static_image(pictures: Sequence[Picture], form: Literal["png", "svg"]) -> bytes:
    """Pictures below each other as one image file; the same bytes each time."""
    if find_spec("matplotlib") is None:
        raise OutputError(f"{NEEDED}.")
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    heights = [float(one.content["layout"]["height"]) / PX_PER_IN + 0.4 for one in pictures]
    with mpl.rc_context(RULES):
        figure = Figure(figsize=(WIDTH_IN, sum(heights)), layout="constrained")
        FigureCanvasAgg(figure)
        made: Any = figure.subfigures(len(pictures), 1, height_ratios=heights, squeeze=False)
        parts = made[:, 0]
        for part, picture in zip(parts, pictures, strict=True):
            draw(part, picture)
        file = io.BytesIO()
        figure.savefig(file, format=form, dpi=DPI, metadata={"Date": None} if form == "svg" else {"Software": None})
    return file.getvalue()


def draw(part: Any, picture: Picture) -> None:
    """One picture, with an axis for each of its axes of y."""
    content = picture.content
    layout: Mapping[str, Any] = content["layout"]
    names = sorted(
        (name for name in layout if name.startswith("yaxis")), key=lambda name: -_domain(layout[name])[0]
    )
    panes = np.atleast_1d(part.subplots(len(names), 1, sharex=True))
    part.suptitle(picture.title, fontsize=11)
    by_axis = dict(zip(names, panes, strict=True))
    before: dict[str, Any] = {}
    for trace in content["data"]:
        name = "yaxis" + str(trace.get("yaxis", "y"))[1:]
        _trace(part, by_axis[name], trace, before.get(name))
        before[name] = trace
    for name, pane in by_axis.items():
        _axis(pane, layout[name], "y")
        _axis(pane, layout.get("xaxis", {}), "x", titled=pane is panes[-1])
        if layout[name].get("scaleanchor"):
            pane.set_aspect("equal")
        if any(trace.get("name") and trace.get("showlegend", True) for trace in _of(content, name)):
            pane.legend(fontsize=8, framealpha=0.8)
    for shape in layout.get("shapes", ()):
        _shape(by_axis["yaxis"], shape)
    for note, pane in zip(layout.get("annotations", ()), panes, strict=False):
        pane.set_title(str(note["text"]), loc="right", fontsize=9)


def _of(content: Mapping[str, Any], name: str) -> list[Mapping[str, Any]]:
    return [trace for trace in content["data"] if "yaxis" + str(trace.get("yaxis", "y"))[1:] == name]


def _domain(axis: Mapping[str, Any]) -> tuple[float, float]:
    low, high = axis.get("domain", (0.0, 1.0))
    return float(low), float(high)


def _numbers(values: Any) -> Any:
    return np.array([np.nan if value is None else value for value in values], float)


def _trace(part: Any, pane: Any, trace: Mapping[str, Any], before: Mapping[str, Any] | None) -> None:
    """One line, mark or map."""
    if trace["type"] == "heatmap":
        x, y = trace["x"], trace["y"]
        z = np.array([_numbers(row) for row in trace["z"]])
        words = [any(isinstance(value, str) for value in way) for way in (x, y)]
        ends = [np.arange(len(way), dtype=float) if named else _numbers(way)
                for way, named in zip((x, y), words, strict=True)]  # fmt: skip
        image = pane.pcolormesh(*ends, np.ma.masked_invalid(z), cmap=MAPS.get(str(trace["colorscale"]), "viridis"))
        pane.grid(False)
        for way, named, set_ticks in ((x, words[0], pane.set_xticks), (y, words[1], pane.set_yticks)):
            if named:
                set_ticks(range(len(way)), [str(value) for value in way])
        part.colorbar(image, ax=pane, label=str(trace["colorbar"]["title"]["text"]))
        return
    x, y = _numbers(trace["x"]), _numbers(trace["y"])
    label = str(trace.get("name", "")) if trace.get("showlegend", True) else "_"
    if "lines" in trace["mode"]:
        line = trace["line"]
        pane.plot(x, y, color=line["color"], linestyle=LINES[line.get("dash", "solid")], label=label)
        if trace.get("fill") == "tonexty" and before is not None:
            pane.fill_between(x, _numbers(before["y"]), y, color=line["color"], alpha=0.15, linewidth=0)
        return
    marker = trace["marker"]
    sign = str(marker.get("symbol", "circle"))
    edge = marker.get("line", marker)["color"]
    face = "none" if sign.endswith("-open") else marker["color"]
    style = {"markeredgecolor": edge, "markerfacecolor": face, "markersize": 0.7 * float(marker["size"])}
    pane.plot(x, y, linestyle="", marker=MARKS[sign], label=label, **style)


def _axis(pane: Any, axis: Mapping[str, Any], which: Literal["x", "y"], *, titled: bool = True) -> None:
    """Title, scale, range and ticks of one axis."""
    if titled:
        getattr(pane, f"set_{which}label")(str(axis.get("title", {}).get("text", "")))
    if axis.get("type") == "log":
        getattr(pane, f"set_{which}scale")("log")
        for ticks in ("major", "minor"):
            getattr(getattr(pane, f"{which}axis"), f"set_{ticks}_formatter")(_plain_numbers(minor=ticks == "minor"))
    if "range" in axis:
        low, high = axis["range"]
        getattr(pane, f"set_{which}lim")(low, high)
    elif axis.get("rangemode") == "tozero":
        getattr(pane, f"set_{which}lim")(**{"bottom" if which == "y" else "left": 0})
    if axis.get("autorange") == "reversed":
        getattr(pane, f"invert_{which}axis")()
    if "tickvals" in axis:
        getattr(pane, f"set_{which}ticks")(axis["tickvals"], axis["ticktext"])
        getattr(pane, f"{which}axis").set_minor_locator(_no_ticks())


def _plain_numbers(*, minor: bool) -> Any:
    """0.02 and 20, not powers of ten; between them 2 and 5 alone."""
    from matplotlib.ticker import FuncFormatter

    def text(value: float, _: int) -> str:
        plain = f"{value:.6g}"
        return plain if not minor or plain.strip("0.")[:1] in ("2", "5") else ""

    return FuncFormatter(text)


def _no_ticks() -> Any:
    from matplotlib.ticker import NullLocator

    return NullLocator()


def _shape(pane: Any, shape: Mapping[str, Any]) -> None:
    """A line or a band across the plot."""
    if shape["type"] == "rect":
        pane.axhspan(shape["y0"], shape["y1"], color="#808080", alpha=0.22, linewidth=0)
        return
    line = shape["line"]
    style = {"color": line["color"], "linewidth": line["width"], "linestyle": LINES[line.get("dash", "solid")]}
    if shape.get("yref") == "paper":
        pane.axvline(shape["x0"], **style)
    else:
        pane.axhline(shape["y0"], **style)
        if "label" in shape:
            pane.annotate(str(shape["label"]["text"]), (0.99, shape["y0"]), xycoords=("axes fraction", "data"),
                          ha="right", va="bottom", fontsize=8)  # fmt: skip

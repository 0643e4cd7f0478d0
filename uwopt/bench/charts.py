"""Rows as Plotly figures: error over time, gap over time, time over size. Logarithmic axes throughout."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from uwopt.bench.suite import BenchRow, Suite
from uwopt.report.pictures.plots import BLUE, DASHES, GREEN, GREY, PURPLE, VERMILLION, axis, layout, numbers

COLOURS = (BLUE, VERMILLION, GREEN, PURPLE, "#e69f00", "#56b4e9", GREY)
SYMBOLS = ("circle", "square", "diamond", "cross", "triangle-up", "x", "star")
LEAST_ERROR = 1e-16  # what is drawn of an error of 0
LEAST_GAP = 1e-9  # the same of a gap: the certificates are no finer
MOST_CHARTS = 16  # of one suite; the tables hold all cases


def charts(suite: Suite, rows: Sequence[BenchRow]) -> list[dict[str, Any]]:
    """Figures of a suite: {id, title, caption, alt, figure}."""
    shown = [row for row in rows if suite.charted(row)]
    if suite.chart == "scaling":
        return scaling_charts(suite, shown)
    cases = list(dict.fromkeys(row.case for row in shown))[:MOST_CHARTS]
    draw = precision_figure if suite.chart == "precision" else progress_figure
    made = []
    for number, case in enumerate(cases):
        of_case = [
            row for row in shown if row.case == case and row.error is not None and row.time_s is not None
        ]
        if of_case:
            what = f"{suite.error_name} over {suite.time_name}"
            made.append(chart(f"{suite.name}-{number}", case, what, draw(suite, of_case)))
    return made


def chart(name: str, title: str, caption: str, figure: dict[str, Any]) -> dict[str, Any]:
    """One picture of the page."""
    alt = f"{title}: {caption}"
    return {"id": name, "kind": "plotly", "title": title, "caption": caption, "alt": alt, "figure": figure}


def style(number: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """Line and marker of the n-th method: colour, dash and symbol differ."""
    colour = COLOURS[number % len(COLOURS)]
    dash = DASHES[(number // len(COLOURS) + 2) % len(DASHES)]
    return {"color": colour, "width": 2, "dash": dash}, {
        "color": colour, "size": 8, "symbol": SYMBOLS[number % len(SYMBOLS)]
    }  # fmt: skip


def precision_figure(suite: Suite, rows: Sequence[BenchRow]) -> dict[str, Any]:
    """Error over time, one line a method, through its sizes; a size beside each point."""
    traces = []
    for number, method in enumerate(dict.fromkeys(row.method for row in rows)):
        line, marker = style(number)
        own = sorted(
            (row for row in rows if row.method == method),
            key=lambda row: (row.size or 0.0, row.time_s or 0.0),
        )
        traces.append({
            "type": "scatter", "mode": "lines+markers" if len(own) > 1 else "markers", "name": method, "line": line,
            "marker": marker, "x": numbers([row.time_s for row in own]),
            "y": numbers([max(row.error or 0.0, LEAST_ERROR) for row in own]),
            "text": ["" if row.size is None else f"{suite.size_name} {row.size:g}" for row in own],
        })  # fmt: skip
    return log_figure(traces, suite.time_name, suite.error_name)


def progress_figure(suite: Suite, rows: Sequence[BenchRow]) -> dict[str, Any]:
    """Gap over elapsed time as steps, one line a method and seed; seeds share a colour."""
    traces = []
    for number, method in enumerate(dict.fromkeys(row.method for row in rows)):
        line, marker = style(number)
        for place, seed in enumerate(dict.fromkeys(row.seed for row in rows if row.method == method)):
            own = [row for row in rows if row.method == method and row.seed == seed]
            own.sort(key=lambda row: row.time_s or 0.0)
            traces.append({
                "type": "scatter", "mode": "lines+markers", "name": method, "legendgroup": method,
                "showlegend": place == 0, "line": {**line, "shape": "hv", "width": 1.5},
                "marker": {**marker, "size": 6},
                "x": numbers([row.time_s for row in own]),
                "y": numbers([max(row.error or 0.0, LEAST_GAP) for row in own]),
                "text": [f"seed {row.seed} {row.status}" for row in own],
            })  # fmt: skip
    return log_figure(traces, suite.time_name, suite.error_name)


def scaling_charts(suite: Suite, rows: Sequence[BenchRow]) -> list[dict[str, Any]]:
    """Time and memory over size, one line a case."""
    made = []
    for name, title, value in (
        ("time", suite.time_name, "time_s"),
        ("memory", "most memory, MiB", "memory_mib"),
    ):
        traces = []
        for number, case in enumerate(dict.fromkeys(row.case for row in rows)):
            line, marker = style(number)
            own = [row for row in rows if row.case == case and getattr(row, value) is not None and row.size]
            own.sort(key=lambda row: row.size or 0.0)
            if own:
                traces.append({
                    "type": "scatter", "mode": "lines+markers", "name": case, "line": line, "marker": marker,
                    "x": numbers([row.size for row in own]), "y": numbers([getattr(row, value) for row in own]),
                    "text": [row.status for row in own],
                })  # fmt: skip
        if traces:
            caption = f"{title} over {suite.size_name}"
            made.append(
                chart(f"{suite.name}-{name}", title, caption, log_figure(traces, suite.size_name, title))
            )
    return made


def log_figure(traces: list[dict[str, Any]], across: str, up: str) -> dict[str, Any]:
    """Traces on two logarithmic axes."""
    axes = [
        axis(
            title, type="log", exponentformat="power", **({"dtick": 1} if spans_decades(traces, key) else {})
        )
        for title, key in ((across, "x"), (up, "y"))
    ]
    return {"data": traces, "layout": layout(xaxis=axes[0], yaxis=axes[1], height=420)}


def spans_decades(traces: list[dict[str, Any]], key: str) -> bool:
    """Whether an axis is long enough for a tick a decade."""
    values = [value for trace in traces for value in trace[key] if value]
    return bool(values) and max(values) >= 100.0 * min(values)

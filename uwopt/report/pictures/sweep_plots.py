"""Plots of a sweep over many missions: which kits win, and what few of them serve."""

from __future__ import annotations

from typing import Any

from uwopt.report.pictures.plots import BLUE, VERMILLION, Plot, axis, layout
from uwopt.report.pictures.system_maps import markup_free
from uwopt.report.text import formats
from uwopt.results.sweep import SweepSummary

MOST_BARS = 14


def sweep_figures(made: SweepSummary) -> dict[str, Plot]:
    """All plots of a sweep by name."""
    figures = {"wins": wins_plot(made)} if made.kits else {}
    if made.portfolio:
        figures["portfolio"] = portfolio_plot(made)
    return figures


def wins_plot(made: SweepSummary) -> Plot:
    """Bars of wins, the most at the top, beside what each kit serves."""
    kits = made.kits[:MOST_BARS][::-1]
    numbers = [f"no. {made.kits.index(kit) + 1}" for kit in kits]
    texts = [markup_free(formats.one_line(kit.parts, 200)) for kit in kits]
    bar: dict[str, Any] = {"type": "bar", "orientation": "h", "y": numbers, "text": texts, "textposition": "none"}
    data = [
        bar
        | {
            "x": [kit.wins for kit in kits],
            "name": "wins",
            "marker": {"color": BLUE},
            "hovertemplate": "%{x} wins: %{text}<extra></extra>",
        }
    ]
    if any(kit.serves is not None for kit in kits):
        hatched = {"color": VERMILLION, "pattern": {"shape": "/"}}
        data.append(
            bar
            | {
                "x": [kit.serves for kit in kits],
                "name": "serves",
                "marker": hatched,
                "hovertemplate": "serves %{x}: %{text}<extra></extra>",
            }
        )
    return {"data": data, "layout": layout(xaxis=axis("missions"), yaxis=axis("kit"), barmode="group")}


def portfolio_plot(made: SweepSummary) -> Plot:
    """Missions served by the number of kits, with the price of each choice."""
    texts = []
    for one in made.portfolio:
        which = ", ".join(f"no. {index + 1}" for index in one.kits)
        texts.append(which if one.price is None else f"{formats.money(one.price, made.currency)}: {which}")
    line = {
        "type": "scatter",
        "mode": "lines+markers",
        "x": [len(one.kits) for one in made.portfolio],
        "y": [one.serves for one in made.portfolio],
        "text": texts,
        "name": "served",
        "line": {"color": BLUE},
        "hovertemplate": "%{x} kits serve %{y}: %{text}<extra></extra>",
    }
    served = axis("missions served", rangemode="tozero")
    return {"data": [line], "layout": layout(xaxis=axis("kits", dtick=1), yaxis=served)}

"""The page of a sweep over many missions, one HTML file that works offline."""

from __future__ import annotations

from uwopt.report.page.plots_page import plots_page
from uwopt.report.pictures.sweep_plots import sweep_figures
from uwopt.report.text.sweep_tables import pace_text, sweep_blocks, sweep_opening
from uwopt.results.sweep import SweepSummary
from uwopt.units import counted

PICTURES = {
    "wins": (
        "Missions of each kit",
        "Missions in which each kit is the best; hatched: missions that it can serve.",
    ),
    "portfolio": (
        "Missions that so many kits serve",
        "The most missions that so many kits serve, and what they cost.",
    ),
}


def sweep_html(made: SweepSummary) -> str:
    """The page."""
    return plots_page(
        made, "sweep", sweep_figures(made), PICTURES, sweep_blocks(made), title="Sweep",
        name=counted(made.missions, "mission"), opening=sweep_opening(made),
        status=(made.status, "good" if made.status == "complete" else "warn"),
        run_time=pace_text(made).removeprefix("Took ").removesuffix("."),
    )  # fmt: skip

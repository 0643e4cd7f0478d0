"""The page of a table over varied keys, one HTML file that works offline."""

from __future__ import annotations

from uwopt.report.page.plots_page import plots_page
from uwopt.report.pictures.whatif_plots import whatif_figures
from uwopt.report.text import formats, words
from uwopt.report.text.looked_at import in_figure, in_page, wording_of
from uwopt.report.text.whatif_tables import opening, whatif_blocks
from uwopt.results.whatif import WhatIf

PICTURES = {
    "optimum": (
        "The optimum",
        "Marks have the colours of the systems. Diamonds: another system takes over. Where a line ends nothing fits.",
    ),
    "map": (
        "Which system wins where",
        "A colour and a number each, as in the table of systems; grey: nothing fits. Where one takes over is solved "
        "to a hundredth of a step on the lines through the points, and drawn straight between them.",
    ),
    "values": ("The optimum", "Of the system that wins there."),
    "spider": (
        "Each quantity alone",
        "All others as the mission has them; the steepest moves the optimum most. Open marks: another system wins. "
        "Where a line ends nothing fits.",
    ),
}
MARKS = {"complete": "good", "stopped": "warn", "interrupted": "warn"}


def whatif_html(table: WhatIf) -> str:
    """The page."""
    said = wording_of(table)
    page = plots_page(
        table, "whatif", in_figure(whatif_figures(table), said), PICTURES, whatif_blocks(table), title="What if",
        name=formats.one_line(table.mission.get("name") or "Mission", 120), opening=opening(table),
        status=(table.status, MARKS.get(table.status, "bad")), run_time=words.run_time_sentence(table.timing_s),
    )  # fmt: skip
    return in_page(page, said)

"""The page of a table over varied keys, one HTML file that works offline."""

from __future__ import annotations

from typing import Any

from uwopt.report.page.html_file import compact_json, packed, rendered, slim
from uwopt.report.pictures.whatif_plots import whatif_figures
from uwopt.report.text import formats, words
from uwopt.report.text.layout import Block
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
    figures = {f"whatif-{name}": slim(figure) for name, figure in whatif_figures(table).items()}
    pictures: list[dict[str, Any]] = []
    for name in figures:
        title, caption = PICTURES[name.removeprefix("whatif-")]
        alt = f"{title}: {caption}"
        pictures.append({"id": name, "kind": "plotly", "title": title, "caption": caption, "alt": alt})
    blocks = [one for one in whatif_blocks(table) if isinstance(one, Block)][1:]
    page = rendered(
        "whatif.html", ("page.js",), {"figures": in_figure(figures, said), "front": None}, title="What if",
        name=formats.one_line(table.mission.get("name") or "Mission", 120), version=table.uwopt_version,
        opening=opening(table), status=(table.status, MARKS.get(table.status, "bad")), pictures=pictures,
        blocks=blocks, run_time=words.run_time_sentence(table.timing_s), raw=packed(compact_json(table.to_dict())),
        raw_name="whatif.json", made_by="uwopt whatif",
    )  # fmt: skip
    return in_page(page, said)

"""The page of a table that has plots: of a mission over varied keys, or of a sweep over many missions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from uwopt.report.page.html_file import compact_json, gzip_text, rendered, slim
from uwopt.report.text.layout import Block, Text
from uwopt.results.sweep import SweepSummary
from uwopt.results.whatif import WhatIf

Captions = Mapping[str, tuple[str, str]]  # title and caption by the plot's name


def plots_page(
    made: WhatIf | SweepSummary, kind: str, plots: Mapping[str, Any], captions: Captions,
    blocks: Iterable[Block | Text], **values: Any,
) -> str:  # fmt: skip
    """One HTML file that works offline; the first block is what `values` have as `opening`."""
    pictures = [
        dict(id=f"{kind}-{name}", kind="plotly", title=title, caption=caption, alt=f"{title}: {caption}")
        for name, (title, caption) in ((name, captions[name]) for name in plots)
    ]
    data = {"figures": {f"{kind}-{name}": slim(plot) for name, plot in plots.items()}, "front": None}
    return rendered(
        "whatif.html", ("page.js",), data, version=made.uwopt_version, pictures=pictures,
        blocks=[one for one in blocks if isinstance(one, Block)][1:], raw=gzip_text(compact_json(made.to_dict())),
        raw_name=f"{kind}.json", made_by=f"uwopt {kind}", **values,
    )  # fmt: skip

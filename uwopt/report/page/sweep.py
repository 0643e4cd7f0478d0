"""The page of a sweep over many missions, one HTML file that works offline."""

from __future__ import annotations

from uwopt.report.page.html_file import compact_json, packed, rendered, slim
from uwopt.report.pictures.sweep_plots import sweep_figures
from uwopt.report.text import words
from uwopt.report.text.layout import Block
from uwopt.report.text.sweep_tables import pace_text, sweep_blocks, sweep_opening
from uwopt.results.sweep import SweepSummary

PICTURES = {
    "wins": (
        "Which kits win",
        "Missions in which each kit is the best; hatched: missions that it can serve.",
    ),
    "portfolio": (
        "Few kits for many missions",
        "The most missions that so many kits serve, and what they cost.",
    ),
}


def sweep_html(made: SweepSummary) -> str:
    """The page."""
    figures = {f"sweep-{name}": slim(figure) for name, figure in sweep_figures(made).items()}
    pictures = []
    for name in figures:
        title, caption = PICTURES[name.removeprefix("sweep-")]
        pictures.append(
            {"id": name, "kind": "plotly", "title": title, "caption": caption, "alt": f"{title}: {caption}"}
        )
    blocks = [one for one in sweep_blocks(made) if isinstance(one, Block)][1:]
    return rendered(
        "whatif.html", ("page.js",), {"figures": figures, "front": None}, title="Sweep",
        name=words.counted(made.missions, "mission"), version=made.uwopt_version, opening=sweep_opening(made),
        status=(made.status, "good" if made.status == "complete" else "warn"), pictures=pictures, blocks=blocks,
        run_time=pace_text(made).removeprefix("Took ").removesuffix("."), raw=packed(compact_json(made.to_dict())),
        raw_name="sweep.json", made_by="uwopt sweep",
    )  # fmt: skip

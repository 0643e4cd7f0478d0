"""How exact a result's numbers are: gap, residual, and the estimated error of its figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from uwopt.report.text import formats
from uwopt.report.text.layout import Block, Grid, Line, Text, block, columns, fact_lines, sentence
from uwopt.results.result import Result

PARTS = {
    "spectrum": "wavelengths",
    "image": "light over the image",
    "veil": "backscatter",
    "sun": "daylight",
    "sharpness": "spatial frequencies",
    "places": "darkest place",
}


def has_errors(result: Result) -> bool:
    """Whether errors of figures were estimated."""
    return bool(result.accuracy.get("figures"))


def exactness_block(result: Result) -> Block:
    """What the figures of this result may err by, for want of finer integrals."""
    accuracy = result.accuracy
    worst = accuracy.get("largest") or {}
    facts = [("largest of a figure", f"{error_text(worst.get('error_rel'))} ({figure_text(worst)})")]
    if result.command == "solve":
        facts += [
            ("objective", error_text(accuracy.get("objective"))),
            ("optimality gap", error_text(accuracy.get("gap_rel"))),
            ("KKT residual", error_text(accuracy.get("kkt_residual"))),
        ]
    if accuracy.get("tolerance") is not None:
        facts.append(("tolerance", tolerance_text(result)))
    lines: list[Line] = [fact_lines(facts), Text(""), parts_table(result)]
    lines.append(
        sentence(f"Relative errors, estimated: {formats.one_line(accuracy.get('method') or '')}.", "dim")
    )
    return block("How exact the numbers are", lines)


def parts_table(result: Result) -> Grid:
    """What each kind of integral contributes, and how finely it was taken."""
    table = columns(("integral", "left"), ("nodes", "right"), ("error", "right"), ("of", "left"))
    for name, made in (result.accuracy.get("by_part") or {}).items():
        factor = result.physics.fineness.get(name)
        table.add_row(
            Text(PARTS.get(name, formats.one_line(name))),
            Text(nodes_text(factor)),
            Text(error_text(made.get("error_rel"))),
            Text(figure_text(made)),
        )
    return table


def tolerance_text(result: Result) -> str:
    """The tolerance and whether it is met; `evaluate` in physics `auto` shares it with effects left out."""
    accuracy, physics = result.accuracy, result.physics
    held = "met" if accuracy.get("meets_tolerance") else "not met"
    if result.command == "evaluate" and physics.name == "auto":
        effects = error_text(physics.tolerance)
        return f"{error_text(accuracy['tolerance'])} for integrals, {held}; {effects} for effects left out"
    return f"{error_text(accuracy['tolerance'])}, {held}"


def nodes_text(factor: float | None) -> str:
    """How many nodes an integral was taken with, beside the default."""
    if factor is None:
        return ""
    return "default" if factor == 1.0 else f"{factor:g} x default"


def error_text(error: float | None) -> str:
    """A relative error in short."""
    if error is None:
        return "not known"
    return "0" if error == 0 else f"{error:.1e}"


def figure_text(made: Mapping[str, Any]) -> str:
    """Which figure an error is of."""
    return formats.one_line(made.get("figure") or "") if made.get("error_rel") else "no figure"

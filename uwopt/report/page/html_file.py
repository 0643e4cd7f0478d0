"""An HTML file that works alone: template, styles, scripts and data in one, nothing from a network.

The template escapes every text; data for the script stand in a block of JSON; the page allows only the
scripts that it was written with, by their hashes, and no connection.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import math
import re
from functools import cache
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from uwopt.report.page.style import DARK, LIGHT, tokens
from uwopt.report.text import formats, words
from uwopt.report.text.layout import Facts, Grid, Joined, Line, Text


def rendered(template: str, scripts: tuple[str, ...], data: dict[str, Any], **values: Any) -> str:
    """A page from a template of the assets; `data` is for its scripts, and has plots under `figures`."""
    code = "".join(script(name) for name in scripts)
    plots = plotly_js() if data["figures"] or data.get("front") else ""
    policy = "; ".join((
        "default-src 'none'", "script-src " + " ".join(source_of(text) for text in (plots, code) if text),
        "style-src 'unsafe-inline'", "img-src data: blob:", "base-uri 'none'", "form-action 'none'",
    ))  # fmt: skip
    return str(
        environment()
        .get_template(template)
        .render(
            policy=policy, plots=packed_plots() if plots else "", code=code, data=json_for_script(data),
            light=tokens(LIGHT), dark=tokens(DARK), **values,
        )
    )  # fmt: skip


@cache
def environment() -> Any:
    """The template engine, which escapes everything that is not marked as markup."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    made = Environment(
        loader=PackageLoader("uwopt.report", "assets"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    made.filters["line_kind"] = line_kind
    made.filters["anchor"] = safe_id
    made.filters["capital"] = words.capital
    made.filters["tied"] = formats.tied
    return made


def line_kind(line: Line) -> str:
    """Which of the kinds of lines one is."""
    return {Text: "text", Joined: "joined", Grid: "grid", Facts: "facts"}[type(line)]


def safe_id(text: object) -> str:
    """Letters, digits and hyphens only."""
    return re.sub(r"[^a-z0-9]+", "-", str(text).casefold()).strip("-") or "part"


@cache
def script(name: str) -> str:
    """A script of the page."""
    return resources.files("uwopt.report").joinpath("assets", name).read_text("utf-8")


@cache
def plotly_js() -> str:
    """The plot library, read from its package without importing that; "" where it is missing."""
    spec = find_spec("plotly")
    if spec is None or spec.origin is None:
        return ""
    return (Path(spec.origin).parent / "package_data" / "plotly.min.js").read_text("utf-8")


@cache
def packed_plots() -> str:
    """The plot library packed, once for all pages that a process writes: 0.15 s."""
    return gzip_text(plotly_js())


def gzip_text(text: str) -> str:
    """Text packed with gzip, in letters."""
    return base64.b64encode(gzip.compress(text.encode(), 4, mtime=0)).decode()


@cache
def source_of(text: str) -> str:
    """A script's hash as the page's policy names it."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def json_for_script(value: Any) -> str:
    """JSON that no text within can end, and that every browser reads."""
    text = compact_json(value)
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return text


def compact_json(value: Any) -> str:
    """JSON without blanks, which is written ten times as fast as with them."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def slim(value: Any) -> Any:
    """Numbers of a figure with six digits, which is more than a screen shows."""
    if isinstance(value, dict):
        return {key: slim(item) for key, item in value.items()}
    if isinstance(value, list):
        return [slim(item) for item in value]
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    return value

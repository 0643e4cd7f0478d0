"""Write the output that README and guide show: a fresh run's page, and some lines of its full text.

    python docs/make_readme_output.py

A test compares them with a fresh run; when results have changed for a reason, run this and read the
difference before committing it.
"""

from __future__ import annotations

import contextlib
import io
import re
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

if TYPE_CHECKING:
    from uwopt.results.result import Result

#: What stands between the marks of this name: the page that `solve` prints, and lines of what `--full` prints.
PAGE, FULL = "output", "full output"
#: Where it stands.
SHOWN_IN = {PAGE: ROOT / "README.md", FULL: ROOT / "docs" / "guide" / "answer.md"}
CUT = "  [...]"

#: What is shown of a section of the full text: None for all of it, else lines that contain one of these.
SHOWN: dict[str, tuple[str, ...] | None] = {
    "Margins": (
        "requirement  ", "motion blur", "overlap", "depth of field", "pixel on", "signal to noise", "  cost  ",
        "depth rating",
    ),
    "Certificate": (
        "no system can", "best found", "gap  ", "combinations loaded", "of them of parts", "  evaluated",
        "discarded, each", "depth rating too", "image circle", "pixel on", "depth of field", "too expensive",
        "too much power", "no light gives", "proven not better", "adds up",
    ),
    "How firm this is": None,
}  # fmt: skip


def printed(blocks: Iterable[Any]) -> str:
    """Blocks as a pipe gets them."""
    from uwopt.report.text.console import print_blocks

    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        print_blocks(blocks)
    return text.getvalue()


def page_of(result: Result) -> str:
    """What `solve` prints."""
    from uwopt.report.text.short import short_text_blocks

    return printed(short_text_blocks(result, has_page=True)).rstrip("\n")


def full_of(result: Result) -> str:
    """What is shown of what `solve --full` prints."""
    from uwopt.report.text.short import full_text_blocks

    return shortened(printed(full_text_blocks(result)))


def sections(text: str) -> list[tuple[str, list[str]]]:
    """Title and lines of each section; the first has no title."""
    blocks = re.split(r"\n\s*\n", text.strip("\n"))
    out: list[tuple[str, list[str]]] = [("", blocks[0].splitlines())]
    for block in blocks[1:]:
        title, *lines = block.splitlines()
        out.append((title, lines))
    return out


def shortened(text: str) -> str:
    """The sections that are shown, with a mark where lines are left out."""
    shown = []
    for title, lines in sections(text):
        if title not in SHOWN:
            continue
        kept = [title] if title else []
        for line in lines:
            wanted = SHOWN[title]
            if wanted is None or any(piece in line for piece in wanted):
                kept.append(line.rstrip())
            elif kept[-1] != CUT:
                kept.append(CUT)
        shown.append("\n".join(kept))
    return "\n\n".join(shown)


def marks(name: str) -> tuple[str, str]:
    """What the output of a name stands between."""
    return f"<!-- {name}: begin -->", f"<!-- {name}: end -->"


def parts_of(name: str) -> tuple[str, str, str]:
    """The page that shows an output: what stands before it, the output, what stands behind it."""
    begin, end = marks(name)
    before, rest = SHOWN_IN[name].read_text(encoding="utf-8").split(begin)
    block, after = rest.split(end)
    return before + begin, block.split("```text\n")[1].split("\n```")[0], end + after


def pasted(name: str) -> str:
    """The output that is shown."""
    return parts_of(name)[1]


def paste(name: str, output: str) -> None:
    """Show another output."""
    before, _, after = parts_of(name)
    SHOWN_IN[name].write_text(f"{before}\n```text\n{output}\n```\n{after}", encoding="utf-8")


def main() -> None:
    """Replace both outputs."""
    from uwopt.api.solving import solve

    mission = ROOT / "problems" / "reef-mosaic.yaml"
    result = solve(mission, alternatives=True, ranges=True)  # as with --out
    paste(PAGE, page_of(result))
    paste(FULL, full_of(result))


if __name__ == "__main__":
    main()

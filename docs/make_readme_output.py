"""Write the output that the README shows: a fresh run, with some lines left out.

    python docs/make_readme_output.py

A test compares the README with a fresh run; when results have changed for a reason, run this and read the
difference before committing it.
"""

from __future__ import annotations

import contextlib
import io
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
README = ROOT / "README.md"
BEGIN, END = "<!-- output: begin -->", "<!-- output: end -->"
CUT = "  [...]"

#: What is shown of a section: None for all of it, else lines that contain one of these.
SHOWN: dict[str, tuple[str, ...] | None] = {
    "": None,
    "Recommendation": None,
    "Settings to type in": None,
    "Margins": (
        "requirement  ", "motion blur", "overlap", "depth of field", "pixel on", "signal to noise", "  cost  ",
        "depth rating",
    ),
    "Cost, power and mass": None,
    "Certificate": (
        "no system can", "best found", "gap  ", "combinations loaded", "of them of parts", "  evaluated",
        "discarded, each", "depth rating too", "image circle", "pixel on", "depth of field", "too expensive",
        "too much power", "no light gives", "proven not better", "adds up",
    ),
    "How firm this is": None,
}  # fmt: skip


def fresh_output() -> str:
    """What `uwopt solve problems/reef-mosaic.yaml` prints."""
    from uwopt.api.solving import solve
    from uwopt.report.text.console import print_blocks
    from uwopt.report.text.tables import result_blocks

    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        print_blocks(result_blocks(solve(ROOT / "problems" / "reef-mosaic.yaml")))
    return text.getvalue()


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


def pasted(readme: str) -> str:
    """The output that the README shows."""
    block = readme.split(BEGIN)[1].split(END)[0]
    return block.split("```text\n")[1].split("\n```")[0]


def main() -> None:
    """Replace the output in the README."""
    text = README.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    block = f"{BEGIN}\n```text\n{shortened(fresh_output())}\n```\n{END}"
    README.write_text(before + block + after, encoding="utf-8")


if __name__ == "__main__":
    main()

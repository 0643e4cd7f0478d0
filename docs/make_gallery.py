"""Hold every rig whose hardware is known against what is recommended for its mission: docs/gallery.md.

    python docs/make_gallery.py [--only NAME ...]

Each mission in problems/ that has a system file beside it is compared as `uwopt compare --recommended` does.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from uwopt.api.comparing import compare  # noqa: E402
from uwopt.report.compare.page import grid  # noqa: E402
from uwopt.report.compare.rows import facts, requirement_rows, sentences  # noqa: E402
from uwopt.report.text.layout import Grid  # noqa: E402

PROBLEMS = ROOT / "problems"
PAGE = ROOT / "docs" / "gallery.md"
HEAD = """\
# Published rigs beside what is recommended

Every mission in `problems/` whose rig is known part by part, evaluated as built and set against what `solve` recommends
for the same requirements. What the sources do not tell of a rig is assumed in its system file, line by line; a rig was
seldom built for just these requirements, so what it misses says as much of the mission as of the rig.
`python docs/make_gallery.py` makes this page.
"""


def rigs() -> list[str]:
    """Names of missions with a system file."""
    return sorted(path.name.removesuffix(".system.yaml") for path in PROBLEMS.glob("*.system.yaml"))


def table(one: Grid) -> Iterator[str]:
    """A grid as Markdown."""
    yield "| " + " | ".join(title for title, _ in one.heads) + " |"
    yield "|" + "---|" * len(one.heads)
    for row in one.rows:
        texts = (f"**{cell.plain}**" if cell.style == "red" else cell.plain for cell in row)
        yield "| " + " | ".join(text.replace("|", "/") for text in texts) + " |"


def section(name: str) -> Iterator[str]:
    """One rig and its recommendation."""
    made = compare(PROBLEMS / f"{name}.yaml", [PROBLEMS / f"{name}.system.yaml"], recommended=True)
    names = [one.name for one in made.systems]
    yield f"## {name}: {made.systems[0].result.mission['name']}"
    yield ""
    yield from table(grid(names, facts(made)))
    yield ""
    yield from sentences(made)
    yield ""
    rows = [*requirement_rows(made)]
    scenes = list(dict.fromkeys(row.scene for row in rows))
    for scene in scenes:
        if len(scenes) > 1:
            yield f"### {scene}"
            yield ""
        yield from table(grid(names, [row for row in rows if row.scene == scene]))
        yield ""


def page(names: Iterable[str]) -> str:
    """The whole page."""
    lines = [HEAD]
    for name in names:
        print(name, file=sys.stderr, flush=True)
        lines += section(name)
    return "\n".join(lines).rstrip() + "\n"


def main() -> None:
    """Writes the page, or prints some sections."""
    parser = argparse.ArgumentParser(description="Write docs/gallery.md.")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="print these missions only")
    only = parser.parse_args().only
    if only:
        print(page(only), end="")
    else:
        PAGE.write_text(page(rigs()), encoding="utf-8")


if __name__ == "__main__":
    main()

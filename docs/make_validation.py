"""Write docs/validation.md and its figures: the model against measurements, other codes and published trends.

    PYTHONPATH=. python docs/make_validation.py

All sections, about six minutes; needs matplotlib, and numba for `multiple`. With names of sections (`tank`,
`sun` ...) only these are computed again, the others stay as they are on the page.
"""

from __future__ import annotations

import importlib
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "validation.md"

SECTIONS = {  # module in docs/validation: heading
    "tank": "Tank experiment of the founding paper",
    "paper_figures": "The paper's figures, made again",
    "backscatter": "Backscatter against Monte Carlo and adaptive quadrature",
    "lamps": "Illuminance of four tilted lamps",
    "ports": "Ports against traced rays",
    "jaffe": "Contrast against baseline: Jaffe's trend",
    "water": "Attenuation against the source tables",
    "sun": "Sunlight in lamps",
    "auto": "What physics `auto` leaves out",
    "multiple": "Light scattered more than once",
}

HEAD = """\
# Validation

Physics `full` (and `paper`, `auto` where said) against what does not come from uwopt: measurements, photons, traced
rays, plain sums, other transcriptions of tables. Each section says what the comparison is independent of, the
largest error found, and what falls short. Every number is computed by `PYTHONPATH=. python docs/make_validation.py`;
none is typed by hand but the measured ones and those quoted as stated elsewhere. Single formulas are tested in
`tests/model/`; physics `paper` against its equations is in [paper.md](paper.md), the tank's set-up in
[validation_full.md](validation_full.md).

| | section | in short |
|---|---|---|
"""


def title(name: str) -> str:
    """Numbered heading of a section."""
    return f"{list(SECTIONS).index(name) + 1}. {SECTIONS[name]}"


def section(name: str) -> str:
    """A section computed afresh, without its heading."""
    if str(ROOT / "docs") not in sys.path:
        sys.path.insert(0, str(ROOT / "docs"))
    filled = importlib.import_module("validation.common").filled
    return str(filled(importlib.import_module(f"validation.{name}").section()))


def sections_of(page: str) -> dict[str, str]:
    """The sections that a page holds, without headings."""
    parts = re.split(r"^## (.*)$", page, flags=re.MULTILINE)
    texts = dict(zip(parts[1::2], parts[2::2], strict=True))
    return {name: texts[title(name)].strip() for name in SECTIONS if title(name) in texts}


def assembled(texts: dict[str, str]) -> str:
    """The whole page."""
    lines = []
    for name, text in texts.items():
        short = " ".join(text.split("\n\n")[0].split()).removeprefix("**In short:** ")
        lines.append(f"| {list(SECTIONS).index(name) + 1} | {SECTIONS[name]} | {short} |")
    body = "\n\n".join(f"## {title(name)}\n\n{text}" for name, text in texts.items())
    return HEAD + "\n".join(lines) + "\n\n" + body + "\n"


def main(names: list[str]) -> None:
    """Computes the named sections, or all, and writes the page."""
    texts = sections_of(PAGE.read_text(encoding="utf-8")) if PAGE.exists() and names else {}
    for name in names or SECTIONS:
        texts[name] = section(name)
    PAGE.write_text(assembled({name: texts[name] for name in SECTIONS if name in texts}), encoding="utf-8")


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    main(sys.argv[1:])

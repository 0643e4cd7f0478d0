"""What the catalogue covers, how old it is and how sure: docs/coverage.md, counted from the catalogue alone.

    python docs/make_coverage.py [--write]
"""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from statistics import median

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from uwopt.catalog.choose import Choice, Selection, select  # noqa: E402
from uwopt.catalog.edition import AS_OF, EDITION  # noqa: E402
from uwopt.catalog.load import built_in_catalog  # noqa: E402
from uwopt.catalog.parts.cell import kept_fields  # noqa: E402
from uwopt.catalog.records import KINDS, Kind, Part, Quantity  # noqa: E402
from uwopt.catalog.stale import age_months  # noqa: E402

PAGE = ROOT / "docs" / "coverage.md"
DEPTHS_M = (0, 100, 300, 1000, 3000, 6000)
SOLD = Choice(generic="never", complete="also")
PLURALS = {
    "camera": "cameras", "lens": "lenses", "port": "ports", "light": "lights", "housing": "housings",
    "complete": "complete cameras",
}  # fmt: skip
READ_AT = ("a maker's, shop's or reviewer's page", "a repository that is named", "a file whose repository is not known")
HEAD = f"""\
# What the catalogue covers, how old it is and how sure

Edition {EDITION}, as of {AS_OF}; `python docs/make_coverage.py --write` counts this page from the catalogue, and a test
holds it to that. [catalogue.md](catalogue.md) tells what the words mean. Parts *searched* are those that a mission
without any wish of its own may use (complete cameras: one that asks for them): sold, made for this purpose, with the
facts that the model cannot do without.
"""


def table(header: Sequence[str], rows: Iterator[Sequence[object]]) -> str:
    """A table in Markdown."""
    lines = ["| " + " | ".join(header) + " |", "|---" * len(header) + "|"]
    return "\n".join([*lines, *("| " + " | ".join(map(str, row)) + " |" for row in rows), ""])


def per_cent(part: int, whole: int) -> str:
    """A share, or nothing where there is none to take it of."""
    return f"{100 * part / whole:.0f} %" if whole else ""


def searched(found: Selection, kind: Kind) -> list[Part]:
    """Products of a kind that a mission without wishes may use."""
    return [found.catalog.parts(kind)[index] for index in found.indices[kind]]


def rows_by_kind(found: Selection) -> Iterator[Sequence[object]]:
    """How many rows there are of a kind, and what keeps the others out."""
    for kind in KINDS:
        made = sum(part.generic for part in found.catalog.parts(kind))
        out = Counter(found.counts[kind]) - Counter(generic=made)
        reasons = ", ".join(f"{rule} {count}" for rule, count in out.most_common())
        yield PLURALS[kind], len(found.catalog.parts(kind)) - made, len(searched(found, kind)), made, reasons


def prices(found: Selection) -> Iterator[Sequence[object]]:
    """How the prices of searched parts are known, and how old they are."""
    for kind in KINDS:
        parts = searched(found, kind)
        how = Counter(_price_status(part) for part in parts)
        said = [part for part in parts if _price_status(part) in ("quoted", "derived")]
        ages = [age_months(part.price_date, AS_OF) for part in said if part.price_date]
        yield (
            PLURALS[kind], len(parts), how["quoted"], how["derived"], how["estimated"], how["by class"],
            len(said) - len(ages), f"{median(ages):.0f}" if ages else "", max(ages, default=""),
        )  # fmt: skip


def _price_status(part: Part) -> str:
    """quoted, derived, estimated from quotes of other parts (a dated row says how), or by class."""
    if part.price is None or (part.price.status == "estimated" and not part.price_date):
        return "by class"
    return part.price.status


def facts(found: Selection) -> Iterator[Sequence[object]]:
    """By number: of how many searched parts a source states it, and how wide the estimates of the others are."""
    for kind in KINDS:
        parts = searched(found, kind)
        for field in kept_fields(type(parts[0])):
            values = [getattr(part, field.name) for part in parts] if field.is_quantity else []
            known = [value for value in values if isinstance(value, Quantity)]
            guessed = [value for value in known if value.estimated]
            if field.name == "price" or not guessed:
                continue
            widths = [value.high / value.low for value in guessed if value.low > 0.0]
            width = f"x {median(widths):.2g}" if widths else ""
            yield PLURALS[kind], f"`{field.name}`", per_cent(len(known) - len(guessed), len(known)), len(guessed), width


def depths(found: Selection) -> Iterator[Sequence[object]]:
    """Products by the depth that they are rated for, and how many of them have a quoted price."""
    kinds: tuple[tuple[str, Kind, Callable[[Part], bool]], ...] = (
        ("ports", "port", lambda part: True),
        ("lamps fed by the vehicle", "light", lambda part: getattr(part, "supply", "") == "external"),
        ("lamps with their own battery", "light", lambda part: getattr(part, "supply", "") == "battery"),
        ("housings", "housing", lambda part: True),
        ("complete cameras", "complete", lambda part: True),
    )
    for name, kind, counts in kinds:
        parts = [part for part in searched(found, kind) if counts(part)]
        rated = [part for part in parts if getattr(part, "depth_rating_m", None) is not None]
        cells = []
        for depth_m in DEPTHS_M:
            deep = [part for part in rated if part.depth_rating_m >= depth_m]  # type: ignore[attr-defined]
            cells.append(f"{len(deep)} ({sum(_price_status(part) in ('quoted', 'derived') for part in deep)})")
        yield name, len(parts), len(parts) - len(rated), *cells


def sources(found: Selection) -> Iterator[Sequence[object]]:
    """Where the facts of searched parts were read; a part may have several."""
    for kind in KINDS:
        parts = searched(found, kind)
        seen = Counter(word for part in parts for word in {_source(url) for url in part.source_url.split(" | ")})
        yield PLURALS[kind], len(parts), *(seen[word] for word in READ_AT)


def _source(url: str) -> str:
    page, repository, unnamed = READ_AT
    if url.startswith("stored GitHub file"):
        return unnamed
    return repository if re.match(r"(https?://)?github\.com/", url) else page


def sections(found: Selection) -> Iterator[str]:
    """The page piece by piece."""
    yield HEAD
    yield "## Rows\n"
    yield table(
        ("kind", "products", "searched", "classes to be made", "left out, by the first rule"), rows_by_kind(found)
    )
    yield "## Prices of what is searched\n"
    yield "*By class*: nobody was read to quote this part or what it is made of. Ages in months.\n"
    yield table(
        ("kind", "searched", "quoted", "derived from quotes", "estimated from quotes of others", "by class",
         "quotes without a date", "median age", "oldest"), prices(found),
    )  # fmt: skip
    yield "## How deep, and priced\n"
    yield "Products rated to at least that depth; in brackets those with a quoted or derived price.\n"
    yield table(("what", "searched", "no rating", *(f"{depth_m} m" for depth_m in DEPTHS_M)), depths(found))
    yield "## Numbers that no source states\n"
    yield "The last column is how far the ends of the class estimate lie apart, high over low, in the middle.\n"
    yield table(("kind", "number", "stated by a source", "estimated for", "ends apart"), facts(found))
    yield "## Where it was read\n"
    yield "A part may have several sources.\n"
    yield table(("kind", "searched", *READ_AT), sources(found))


def page() -> str:
    """The whole page."""
    return "\n".join(sections(select(built_in_catalog(), SOLD)))


def main() -> None:
    """Print the page or write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true")
    if parser.parse_args().write:
        PAGE.write_text(page(), encoding="utf-8")
    else:
        print(page())


if __name__ == "__main__":
    main()

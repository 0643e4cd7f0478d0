"""Which rows of the catalogue are old, unquoted or unsourced: what to ask for first."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from uwopt.catalog.catalogue import Catalog
from uwopt.catalog.edition import AS_OF
from uwopt.catalog.records import KINDS, Kind, Part
from uwopt.catalog.tables import built_in_rows
from uwopt.documents.faults import plain_name

MONTHS = 12  # from here on a price is old


@dataclass(frozen=True, slots=True)
class StaleRow:
    """A part with what is old or missing, and how many of the designs at hand rest on it."""

    id: str
    kind: Kind
    uses: int
    reasons: tuple[str, ...]


def orders_by_part() -> dict[str, int]:
    """How many recommendations for the missions that come with uwopt each part stands in, by id."""
    return {row["id"]: int(row["orders"]) for row in built_in_rows("recommended.csv")}


def stale_rows(
    catalog: Catalog, uses: Mapping[str, int], *, whole: bool = False, months: int = MONTHS, as_of: str = AS_OF
) -> list[StaleRow]:
    """Parts that can be searched and bought and have a fault, the most used first, then the most faulty.

    `uses` counts by id how often a part is recommended; those alone are looked at, unless there are none or the `whole`
    catalogue is wanted.
    """
    whole = whole or not uses
    counted = {plain_name(part_id): number for part_id, number in uses.items()}
    rows = [
        StaleRow(part.id, kind, counted.get(plain_name(part.id), 0), reasons)
        for kind in KINDS
        for part in catalog.parts(kind)
        if (plain_name(part.id) in counted or (whole and not catalog.exclusions_of(part.id)))
        and not part.generic
        and (reasons := faults_of(part, months=months, as_of=as_of))
    ]
    return sorted(rows, key=lambda row: (-row.uses, -len(row.reasons), row.id))


def faults_of(part: Part, *, months: int = MONTHS, as_of: str = AS_OF) -> tuple[str, ...]:
    """What is old or missing of one part, in words; empty when nothing is."""
    found = []
    if not part.source_url:
        found.append("no source")
    if part.price is None or part.price.status == "estimated":
        found.append("no price quoted")
    elif not part.price_date:
        found.append("price without a date")
    elif (age := age_months(part.price_date, as_of)) >= months:
        found.append(f"price {age} months old")
    if part.availability == "unknown":
        found.append("availability unknown")
    return tuple(found)


def age_months(date: str, as_of: str) -> int:
    """Whole months from a date, YYYY or YYYY-MM or YYYY-MM-DD, to a day; what the date leaves open counts as early.

    A year alone is its January, a month alone its first day: a price is at least as old as it says, and taken for
    the oldest that it can be.
    """
    then, now = ([*map(int, text.split("-")), 1, 1][:3] for text in (date, as_of))
    return (now[0] - then[0]) * 12 + now[1] - then[1] - (now[2] < then[2])

"""`uwopt quotes`: answers to a tender become parts and prices of the mission's own, and the mission is solved again."""

from __future__ import annotations

import csv
import re
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from uwopt.api.common import Source, check_day, prepared
from uwopt.api.solving import solve
from uwopt.catalog.answers import read_answers
from uwopt.catalog.changes import log_text
from uwopt.catalog.offers import Offer, number_of, offers_of
from uwopt.catalog.update import planned
from uwopt.deadline import Progress
from uwopt.documents.faults import plain_name
from uwopt.errors import CatalogError
from uwopt.forward.assembly import load_catalog, selected
from uwopt.mission.mission import Mission
from uwopt.solvers.explain.solved_again import QuotedAgain

PATTERNS = {"camera": "cameras", "lens": "lenses", "port": "ports", "light": "lights", "housing": "housings",
            "complete": "complete_cameras"}  # fmt: skip
PLACE = re.compile(r"^rows\.csv(?: row \d+)?(?: \([^)]*\))?: ")  # of a table that no person has seen
LOG_FILE = "quotes.csv"  # a log of changes to the catalogue, which a mission names in catalog.files


def with_quotes(
    mission: Source | Mission, answers: str | Path, *, today: str, keep: Callable[[str], Path] | None = None,
    physics: str | None = None, progress: Progress | None = None,
) -> QuotedAgain:  # fmt: skip
    """A mission solved with what makers answered.

    Parameters
    ----------
    answers : tender.xlsx as it came back, or a CSV of its columns
    today : YYYY-MM-DD, on which the answers are read; what no longer holds does not count
    keep : writes the log of the answers where it stays, and gives its path; else it lasts as long as the call
    """
    check_day(today)
    wanted = prepared(mission, physics, None)
    offers, log = logged(offers_of(read_answers(Path(answers)), today), today)
    before = solve(wanted, quick=True, progress=progress)
    with tempfile.TemporaryDirectory() as scratch:
        after = before
        if log:
            kept = Path(scratch) / LOG_FILE
            if keep is None:
                kept.write_text(log, encoding="utf-8")
            named = naming(wanted, kept if keep is None else keep(log), offers)
            offers = searched(offers, named)
            after = solve(named, progress=progress, quick=True)
    return QuotedAgain(offers=tuple(offers), log=log, before=before, after=after)


def searched(offers: Sequence[Offer], mission: Mission) -> list[Offer]:
    """Offers with why no search of the mission uses them, where it does not."""
    excluded = selected(mission, load_catalog(mission), generic=mission.catalog.generic_at_first).excluded
    why = {plain_name(item.part_id): f"cannot be searched: {item.rule}, {item.reason}" for item in excluded}
    told = []
    for offer in offers:
        fault = why.get(plain_name(offer.part_id), "") if offer.usable else ""
        told.append(replace(offer, faults=(*offer.faults, fault), usable=False) if fault else offer)
    return told


def naming(mission: Mission, log: Path, offers: Sequence[Offer]) -> Mission:
    """The mission with a log among its files of parts; what is offered is searched beside what its patterns name."""
    catalog = mission.to_dict()["catalog"]
    files = [name for name in catalog.get("files") or [] if Path(name) != log]
    named = {}
    for offer in offers:
        key = PATTERNS[offer.kind]
        if offer.usable and catalog.get(key) and offer.part_id not in catalog[key]:
            catalog[key] = named[key] = [*catalog[key], offer.part_id]
    return mission.with_changes(catalog={**catalog, **named, "files": [*files, str(log)]})


def logged(offers: Sequence[Offer], today: str) -> tuple[list[Offer], str]:
    """Offers with what is wrong with them as parts, and the log of those that can be used."""
    told: list[Offer] = []
    text = ""
    best = cheapest(offers)
    with tempfile.TemporaryDirectory() as scratch:
        log, rows = Path(scratch) / LOG_FILE, Path(scratch) / "rows.csv"
        for number, offer in enumerate(offers):
            if not offer.usable:
                told.append(offer)
            elif best[plain_name(offer.part_id)] != number:
                fault = "another offer of the same part is cheaper, or stands before it; that one counts"
                told.append(replace(offer, faults=(*offer.faults, fault), usable=False))
            else:
                fault = added(offer, rows, log, today)
                told.append(replace(offer, faults=(*offer.faults, fault), usable=False) if fault else offer)
        if log.exists():
            text = log.read_text("utf-8")
    return told, text


def cheapest(offers: Sequence[Offer]) -> dict[str, int]:
    """Of offers of one part the place of the cheapest, by its plain id; those without a price last."""
    found: dict[str, int] = {}
    prices = [number_of(offer.cells.get("price", "")) for offer in offers]
    ranks = [float("inf") if price is None else price for price in prices]
    for place, offer in enumerate(offers):
        key = plain_name(offer.part_id)
        if offer.usable and (key not in found or ranks[place] < ranks[found[key]]):
            found[key] = place
    return found


def added(offer: Offer, rows: Path, log: Path, today: str) -> str:
    """Adds an offer to the log; what is wrong with it as a part, empty where nothing is."""
    with rows.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(offer.cells), lineterminator="\n")
        writer.writeheader()
        writer.writerow(dict(offer.cells))
    try:
        plan = planned([rows], log, date=today)
    except CatalogError as fault:
        return "; ".join(PLACE.sub("", text).rstrip(".") for text in fault.faults)
    if plan.changes:
        log.write_text(log_text(plan.log), encoding="utf-8")
    return ""

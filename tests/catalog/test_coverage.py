"""The page of what the catalogue covers is that of the catalogue, and counts as one does by hand."""

from __future__ import annotations

import make_coverage

from uwopt.catalog.tables import built_in_rows

PAGE = make_coverage.PAGE.read_text(encoding="utf-8")


def cells(beginning: str) -> list[str]:
    """The cells of the first line of the page that begins so."""
    line = next(line for line in PAGE.splitlines() if line.startswith(beginning))
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_the_page_is_that_of_the_catalogue_as_it_stands() -> None:
    assert make_coverage.page() == PAGE, "python docs/make_coverage.py --write"


def test_lamps_are_counted_by_depth_as_in_their_table() -> None:
    fed = [
        row for row in built_in_rows("lights.csv")
        if row["supply"] == "external" and row["availability"] in ("current", "unknown")
        and (row["beam_angle_deg"] or row["beam_profile"])
    ]  # fmt: skip
    deep = [row for row in fed if float(row["depth_rating_m"] or 0.0) >= 300.0]
    told = cells("| lamps fed by the vehicle |")
    assert told[1] == str(len(fed))
    assert told[2] == str(sum(not row["depth_rating_m"] for row in fed))
    assert told[3 + make_coverage.DEPTHS_M.index(300)] == f"{len(deep)} ({sum(bool(row['price']) for row in deep)})"


def test_rows_and_prices_are_those_of_the_tables() -> None:
    for kind, file in (("cameras", "cameras.csv"), ("ports", "ports.csv"), ("housings", "housings.csv")):
        assert cells(f"| {kind} |")[1] == str(len(list(built_in_rows(file))))
    housings = [row for row in built_in_rows("housings.csv") if row["availability"] != "discontinued" and row["ports"]]
    sold = [row for row in housings if row["inner_diameter_mm"]]
    prices = PAGE.partition("## Prices")[2]
    line = next(line for line in prices.splitlines() if line.startswith("| housings |"))
    by_status = [sum(row["price_status"] == status for row in sold) for status in ("quoted", "derived", "estimated")]
    assert line.startswith(f"| housings | {len(sold)} | {by_status[0]} | {by_status[1]} | {by_status[2]} |")

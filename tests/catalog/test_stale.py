"""What of the catalogue is old or missing, and in which order to ask for it."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import make_signed
import pytest
from typer.testing import CliRunner

from uwopt.catalog.catalogue import Catalog, Exclusion
from uwopt.catalog.edition import AS_OF, EDITION
from uwopt.catalog.load import read_catalog
from uwopt.catalog.parts.port import Port
from uwopt.catalog.parts.quantity import Quantity
from uwopt.catalog.records import exact
from uwopt.catalog.stale import age_months, faults_of, orders_by_part, stale_rows
from uwopt.cli.app import app

FRESH = Port(
    id="fresh", source_url="https://example.org", availability="current", price=exact(10.0, "quoted"),
    price_date="2026-10-01",
)  # fmt: skip
OLD = replace(FRESH, id="old", price_date="2024-06")
BARE = replace(FRESH, id="bare", source_url="", availability="unknown", price=Quantity(5.0, 1.0, 9.0, "estimated"))


@pytest.mark.parametrize(
    ("date", "months"),
    [("2026-11-22", 0), ("2026-11-21", 0), ("2026-10-23", 0), ("2026-10-22", 1), ("2025-11", 12), ("2025", 22)],
)
def test_a_price_is_as_old_as_whole_months_since_its_date(date: str, months: int) -> None:
    assert age_months(date, "2026-11-22") == months


def test_each_fault_of_a_row_is_told() -> None:
    assert faults_of(FRESH, as_of="2026-11-22") == ()
    assert faults_of(OLD, as_of="2026-11-22") == ("price 29 months old",)
    assert faults_of(replace(OLD, price_date=""), as_of="2026-11-22") == ("price without a date",)
    assert faults_of(BARE) == ("no source", "no price quoted", "availability unknown")


def test_what_recommendations_rest_on_comes_first_and_alone() -> None:
    catalog = Catalog(
        ports=(FRESH, OLD, BARE, replace(BARE, id="made", generic=True), replace(BARE, id="out")),
        exclusions=(Exclusion("out", "port", "vital facts", "unknown"),),
    )
    assert [row.id for row in stale_rows(catalog, {}, as_of="2026-11-22")] == ["bare", "old"]
    ranked = stale_rows(catalog, {"OLD": 3, "bare": 1, "fresh": 9, "made": 9}, as_of="2026-11-22")
    assert [(row.id, row.uses) for row in ranked] == [("old", 3), ("bare", 1)]


def test_the_whole_catalogue_is_listed_with_what_orders_rest_on_before_the_rest() -> None:
    catalog = Catalog(ports=(FRESH, OLD, replace(OLD, id="idle"), replace(BARE, id="bare")))
    found = stale_rows(catalog, {"old": 2, "fresh": 9}, whole=True, as_of="2026-11-22")
    assert [(row.id, row.uses) for row in found] == [("old", 2), ("bare", 0), ("idle", 0)]


def test_the_counts_of_orders_are_those_of_the_page_and_lead_the_list() -> None:
    page = make_signed.PAGE.read_text(encoding="utf-8")
    assert make_signed.USES.read_text(encoding="utf-8") == make_signed.uses_text(page)
    counts = orders_by_part()
    assert counts["bigblue-al2600xwp"] == page.count("x Bigblue AL2600XWP")
    assert sum(counts.values()) > 50
    listed = CliRunner().invoke(app, ["catalog", "stale", "--json"])
    uses = [row["uses"] for row in json.loads(listed.output)]
    assert uses == sorted(uses, reverse=True) and uses[0] > uses[-1] == 0


def test_a_part_that_is_ordered_twice_at_once_counts_as_one_order() -> None:
    page = "# x\n\n2 x Kowa LM8JC10M; 1 x nobody's lamp\n## The orders\n"
    order = "\n### `a`, practice bare\n\n2 x Kowa LM8JC10M; 1 x Bigblue AL2600XWP; 1 x a spare; 1 x x. 2.5e+03 W.\n"
    text = make_signed.uses_text(page + order + order.replace("2 x Kowa", "1 x Kowa").replace("1 x Big", "1 x big"))
    assert [line for line in text.splitlines() if not line.startswith("#")] == [
        "id,orders", "kowa-lm8jc10m,2", "bigblue-al2600xwp,1",
    ]  # fmt: skip


def test_no_price_of_the_catalogue_is_younger_than_the_catalogue() -> None:
    assert re.fullmatch(r"20\d\d\.\d\d", EDITION) and AS_OF.startswith(EDITION.replace(".", "-"))
    catalog = read_catalog()
    dated = [part for kind in ("camera", "lens", "port", "light") for part in catalog.parts(kind) if part.price_date]
    assert [part.id for part in dated if age_months(part.price_date, AS_OF) < 0] == []


def test_the_command_names_the_edition_and_what_to_ask_for() -> None:
    done = CliRunner().invoke(app, ["catalog", "stale", "--months", "1"])
    assert done.exit_code == 0
    assert EDITION in done.stdout and "price without a date" in done.stdout


def test_a_file_that_is_no_result_is_a_fault(tmp_path: Path) -> None:
    (tmp_path / "x.json").write_text("{}", encoding="utf-8")
    done = CliRunner().invoke(app, ["catalog", "stale", str(tmp_path / "x.json")])
    assert done.exit_code == 2

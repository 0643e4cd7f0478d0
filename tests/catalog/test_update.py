"""Updates of the catalogue: what is brought, what is refused, what the log says, and what missions make of it."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from typer.testing import CliRunner

from uwopt.catalog.changes import CellChange, built_in_cells, is_change_table, log_text
from uwopt.catalog.checkfile import file_report
from uwopt.catalog.choose import Choice, select
from uwopt.catalog.load import built_in_catalog, read_catalog
from uwopt.catalog.records import KINDS
from uwopt.catalog.tables import parse_table
from uwopt.catalog.update import Update, planned
from uwopt.cli.app import app
from uwopt.errors import CatalogError

DAY = "2026-11-22"
DOME = "blue-robotics-4-in-dome-aluminium-ring-2026"
LAMP = "blue-robotics-lumen-r2"  # 162.5 USD of 2022-04, to 950 m
NEW_LAMP = (
    "id,kind,purpose,flux_lm,power_w,beam_angle_deg,beam_medium,depth_rating_m,supply,price,currency,price_date,"
    "source_url\nacme-lamp,continuous,vehicle lamp,5000,50,90,water,1000,external,900,USD,2026-11-01,https://acme\n"
)


def brought(folder: Path, text: str, name: str = "lights.csv", **options: str) -> Update:
    """The plan of an update from a file of that text."""
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return planned([file], folder / "log.csv", date=DAY, **options)


def kept(folder: Path, plan: Update) -> Path:
    """The log of a plan, written."""
    path = folder / "log.csv"
    path.write_text(log_text(plan.log), encoding="utf-8")
    return path


def load_cells(log: Path) -> dict[str, str]:
    """The new cells of a log, read as a file."""
    return {row.cells["cell"]: row.cells["new"] for row in parse_table(log.read_text(), log.name).rows}


def refusal(folder: Path, text: str, **options: str) -> str:
    """Why a file is refused."""
    with pytest.raises(CatalogError) as caught:
        brought(folder, text, **options)
    return str(caught.value)


def test_a_quote_changes_its_cells_and_the_log_says_from_what_to_what_and_by_whom(tmp_path: Path) -> None:
    plan = brought(tmp_path, f"id,price,currency,date,note\n{LAMP},210,EUR,2026-11-20,quote 77\n", "quotes.csv")
    cells = {change.cell: change for change in plan.changes}
    assert cells["price"] == CellChange(DAY, "light", LAMP, "price", "162.5", "210", "quote 77")
    assert (cells["price_date"].old, cells["price_date"].new) == ("2022-04", "2026-11-20")
    assert (cells["price_status"].old, cells["price_status"].new) == ("derived", "quoted")
    assert cells["source_url"].new == cells["source_url"].old + " | quote 77"  # of the cells that stay, too
    assert cells["checked"].new == DAY
    assert set(cells) == {"price", "currency", "price_date", "price_status", "source_url", "checked"}


def test_a_quote_takes_the_place_of_an_estimate_and_its_ends(tmp_path: Path) -> None:
    cells_of_range = "id,kind,price,price_low,price_high,currency,price_date,source_url"
    kept(tmp_path, brought(tmp_path, f"{cells_of_range}\n{LAMP},continuous,300,200,400,USD,2026,a\n"))
    quote = f"id,price,currency,date,note\n{LAMP},210,EUR,2026-11-20,quote 77\n"
    cells = {c.cell: (c.old, c.new) for c in brought(tmp_path, quote, "quotes.csv").changes}
    assert (cells["price_low"], cells["price_high"]) == (("200", ""), ("400", ""))


def test_the_log_is_a_file_of_parts_that_leaves_all_other_facts(tmp_path: Path) -> None:
    text = f"id,price,currency,date,note\n{LAMP},210,EUR,2026-11-20,quote 77\n"
    log = kept(tmp_path, brought(tmp_path, text, "q.csv"))
    before, after = built_in_catalog().part(LAMP), read_catalog([log]).part(LAMP)
    assert (after.price.value, after.price.low, after.price.high, after.price.status) == (210, 210, 210, "quoted")
    assert (after.currency, after.price_date) == ("EUR", "2026-11-20")
    assert after.depth_rating_m == before.depth_rating_m == 950  # type: ignore[attr-defined]
    assert read_catalog([log]).ids() == built_in_catalog().ids()  # in its place, so that indices stay


def test_a_filled_gap_frees_a_part_for_the_search(tmp_path: Path) -> None:
    text = "id,beam_angle_deg,beam_medium\ndeepsea-power-light-led-multi-sealite,80,water\n"
    log = kept(tmp_path, brought(tmp_path, text, source="maker's sheet"))
    found = {light.id for light in select(read_catalog([log]), Choice()).lights}
    assert "deepsea-power-light-led-multi-sealite" in found
    assert "deepsea-power-light-led-multi-sealite" not in {light.id for light in select(built_in_catalog()).lights}


def test_a_new_part_is_added_and_later_changed_and_cleared(tmp_path: Path) -> None:
    kept(tmp_path, brought(tmp_path, NEW_LAMP))
    log = kept(tmp_path, brought(tmp_path, "id,depth_rating_m,power_w\nACME_lamp,600,-\n", source="letter"))
    lamp = read_catalog([log]).part("acme-lamp")
    assert lamp.depth_rating_m == 600  # type: ignore[attr-defined]
    assert lamp.power_w.status == "estimated"  # type: ignore[attr-defined]  # cleared: the class stands in
    rows = list(csv.DictReader(line for line in log.read_text().splitlines() if not line.startswith("#")))
    assert [(r["old"], r["new"]) for r in rows if r["cell"] == "depth_rating_m"] == [("", "1000"), ("1000", "600")]
    assert {r["id"] for r in rows} == {"acme-lamp"}  # the catalogue's spelling


def test_a_cleared_price_takes_its_ends_its_date_and_its_status_along(tmp_path: Path) -> None:
    log = kept(tmp_path, brought(tmp_path, f"id,kind,price,source_url\n{LAMP},continuous,-,letter\n"))
    lamp = read_catalog([log]).part(LAMP)
    assert (lamp.price.status, lamp.price_date) == ("estimated", "")
    cells = load_cells(log)
    assert (cells["price"], cells["price_date"], cells["price_status"]) == ("", "", "")


def test_a_note_of_several_lines_is_one_line_of_the_log(tmp_path: Path) -> None:
    note = f"- part: light\n  id: {LAMP}\n  source_url: letter\n  note: |\n    two lamps\n    # 7 and 8\n    -3 deg\n"
    plan = brought(tmp_path, note, "lights.yaml")
    assert load_cells(kept(tmp_path, plan))["note"] == "two lamps # 7 and 8 -3 deg"
    assert brought(tmp_path, note, "lights.yaml").changes == ()


def test_a_number_below_zero_is_no_formula(tmp_path: Path) -> None:
    plan = brought(tmp_path, "id,part,mass_water_g,source_url\nricoh-wg60,complete,-40.5,letter\n", "c.csv")
    assert (plan.changes[0].cell, plan.changes[0].new) == ("mass_water_g", "-40.5")


def test_what_is_there_already_changes_nothing(tmp_path: Path) -> None:
    kept(tmp_path, brought(tmp_path, NEW_LAMP))
    assert brought(tmp_path, NEW_LAMP).changes == ()


@pytest.mark.parametrize(
    ("text", "word"),
    [
        (f"id,kind,price,currency,price_date\n{LAMP},continuous,210,EUR,2026-11\n", "by which source"),
        (f"id,kind,price,currency,price_date,source_url\n{LAMP},continuous,210,XYZ,2026-11,a\n", "currency 'XYZ'"),
        (f"id,kind,price,currency,source_url\n{LAMP},continuous,210,EUR,a\n", "price_date ''"),
        (f"id,kind,depth_rating_m,source_url\n{LAMP},continuous,deep,a\n", f"lights.csv row 2 ({LAMP}): depth_"),
        (f"id,kind,depth_rating_m,source_url\n{LAMP},continuous,9,a\n{LAMP},continuous,8,a\n", "stands already"),
        (f"id,kind,depht_m,source_url\n{LAMP},continuous,9,a\n", "'depht_m' is no column"),
        (f"id,mass_kg,source_url\n{LAMP},9,a\n", "'mass_kg' is no column of a light; did you mean mass_g?"),
        (f"id,mass_g,source_url\n{LAMP},=2*4,a\n", f"lights.csv row 2 ({LAMP}): mass_g = '=2*4' begins like a formula"),
        (f"id,kind,flux_lm,source_url\n{DOME},continuous,9,a\n", "is a port of the catalogue, not a light"),
        ("id,kind,flux_lm,source_url\ngeneric-lamp-flood-1500lm,continuous,9,a\n", "class of parts to be made"),
        ("id,kind,flux_lm,source_url\nacme,continuous,900,a\n", "purpose is empty"),
        ("id,price,currency,date,note\nacme,9,USD,2026,a\n", "'acme' is not in the catalogue"),
        (f"id,kind,note,source_url\n{LAMP},continuous,=A1,a\n", "note = '=A1' begins like a formula"),
        (f"id,kind,flux_lm,source_url\n{LAMP},continuous,900,@SUM(1)\n", "source = '@SUM(1)' begins like a formula"),
    ],
)  # fmt: skip
def test_a_row_that_cannot_stand_is_refused_with_its_reason(tmp_path: Path, text: str, word: str) -> None:
    assert word in refusal(tmp_path, text)


def test_one_bad_row_keeps_all_others_out_and_the_log_as_it_was(tmp_path: Path) -> None:
    log = kept(tmp_path, brought(tmp_path, NEW_LAMP))
    before = log.read_text()
    (tmp_path / "more.csv").write_text(f"id,price,currency,date,note\n{LAMP},210,EUR,2026,a\n{DOME},66,USD,,b\n")
    done = CliRunner().invoke(app, ["catalog", "update", str(tmp_path / "more.csv"), "--out", str(log), "--date", DAY])
    assert done.exit_code == 2
    assert log.read_text() == before


def test_a_dry_run_writes_nothing_and_a_folder_is_taken_whole(tmp_path: Path) -> None:
    folder, log = tmp_path / "new", tmp_path / "log.csv"
    folder.mkdir()
    (folder / "lights.csv").write_text(NEW_LAMP)
    (folder / "quotes.csv").write_text(f"id,price,currency,date,note\n{LAMP},210,EUR,2026-11-20,quote 77\n")
    asked = ["catalog", "update", str(folder), "--out", str(log), "--date", DAY]
    dry = CliRunner().invoke(app, [*asked, "--dry-run"])
    assert dry.exit_code == 0
    assert "acme-lamp" in dry.output
    assert not log.exists()
    assert CliRunner().invoke(app, asked).exit_code == 0
    assert is_change_table(parse_table(log.read_text(), "log.csv"))
    assert read_catalog([log]).part("acme-lamp").price.value == 900
    assert read_catalog([log]).part(LAMP).price.value == 210
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == []


def test_a_log_is_no_row_to_bring_and_its_own_folder_may_be_brought(tmp_path: Path) -> None:
    log = kept(tmp_path, brought(tmp_path, NEW_LAMP))
    assert planned([tmp_path], log, date=DAY).changes == ()
    with pytest.raises(CatalogError, match="is a log of changes already"):
        planned([log], tmp_path / "other.csv", date=DAY)


def test_two_logs_are_read_one_after_the_other(tmp_path: Path) -> None:
    first, second = tmp_path / "a.csv", tmp_path / "b.csv"
    first.write_text(log_text([CellChange(DAY, "light", LAMP, "depth_rating_m", "950", "500", "a")]))
    second.write_text(log_text([CellChange(DAY, "light", LAMP, "flux_lm", "1500", "1400", "b")]))
    lamp = read_catalog([first, second]).part(LAMP)
    assert (lamp.depth_rating_m, lamp.flux_lm.value) == (500, 1400)  # type: ignore[attr-defined]


def test_the_check_of_a_log_tells_what_has_moved_on_beneath_it(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text(log_text([CellChange(DAY, "light", LAMP, "depth_rating_m", "900", "500", "a")]))
    report = file_report(log)
    assert report.ok
    assert report.content == "changes"
    assert report.notes == (f"{LAMP}: depth_rating_m was 900 when it was changed, it is 950 now.",)
    log.write_text(log_text([CellChange(DAY, "light", LAMP, "beauty", "", "much", "a")]))
    assert not file_report(log).ok


def test_every_built_in_row_stands_as_it_is_written() -> None:
    assert len(built_in_cells()) == sum(not part.generic for kind in KINDS
                                        for part in built_in_catalog().parts(kind))  # fmt: skip

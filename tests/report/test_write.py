"""Result files: whole or absent, and safe to open in a spreadsheet."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
import yaml

from uwopt.errors import OutputError
from uwopt.report import write
from uwopt.report.text.formats import known_price
from uwopt.results.front import FrontResult
from uwopt.results.result import Result

Make = Callable[..., Any]


def test_all_files_are_written_into_a_new_folder(tmp_path: Path, make_result: Make) -> None:
    folder = tmp_path / "a" / "b"
    paths = write.write_results(make_result(), folder)
    book = ["bom.xlsx"] if find_spec("openpyxl") else []
    assert sorted(path.name for path in paths) == ["bom.csv", *book, "report.html", "result.json", "system.yaml"]
    assert sorted(path.name for path in folder.iterdir()) == sorted(
        path.name for path in paths
    )  # nothing else stays
    assert Result.from_dict(json.loads((folder / "result.json").read_text("utf-8"))).status == "optimal"


def test_front_is_written_as_json_table_and_page(tmp_path: Path, make_front: Make) -> None:
    paths = write.write_front(make_front(), tmp_path)
    assert sorted(path.name for path in paths) == ["front.csv", "front.json", "report.html"]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(path.name for path in paths)
    assert FrontResult.from_dict(json.loads((tmp_path / "front.json").read_text("utf-8"))) == make_front()


def test_table_of_a_front_has_a_row_a_point_and_no_formula(make_front: Make) -> None:
    front = make_front(points=3)
    first, *rest = front.points
    hardware = replace(first.design.hardware, camera=replace(first.design.hardware.camera, id="=cmd()"))
    front = replace(front, points=[replace(first, design=replace(first.design, hardware=hardware)), *rest])
    rows = list(csv.DictReader(io.StringIO(write.front_csv(front))))
    assert [row["point"] for row in rows] == ["p1", "p2", "p3"]
    assert rows[0]["camera"] == "'=cmd()"
    assert float(rows[1]["objective: power"]) == 37.0
    assert write.front_csv(make_front(points=0)) == "point\n"


def test_formulas_are_defused_and_numbers_stay_numbers(make_result: Make) -> None:
    rows = list(csv.DictReader(io.StringIO(write.bom_csv(make_result().best.bom))))
    assert rows[0]["manufacturer"] == "'=HYPERLINK(1)"
    assert rows[0]["model"] == "'-1"
    assert rows[0]["source"] == "'@shop"
    assert rows[1]["price_basis"] == "'\tclass"
    assert float(rows[0]["unit_price"]) == 1910.0


def test_numbers_of_a_bill_have_no_tails_and_its_prices_the_words_of_the_page(make_result: Make) -> None:
    row = replace(make_result().best.bom[0], count=3, owned=0, unit_price=9.2, price_status="estimated")
    (told,) = csv.DictReader(io.StringIO(write.bom_csv([row])))
    assert told["to_pay"] == "27.6"  # 3 x 9.2 is 27.599999999999998 in binary
    assert "no quote" in told["price_status"] and "no quote" in known_price(row)


@pytest.mark.parametrize("sign", ["=", "+", "-", "@", "\t"])
def test_text_that_begins_like_a_formula_gets_an_apostrophe(sign: str) -> None:
    assert write.defused(sign + "1") == "'" + sign + "1"


def test_number_below_zero_is_no_formula() -> None:
    assert write.defused(-1.5) == -1.5
    assert write.defused(None) == ""


def test_pieces_that_are_owned_are_not_paid(make_result: Make) -> None:
    rows = list(csv.DictReader(io.StringIO(write.bom_csv(make_result().best.bom))))
    assert float(rows[1]["to_pay"]) == 2300.0  # two lamps of 2300 USD, one of them owned


def test_bill_of_an_earlier_run_does_not_stay(tmp_path: Path, make_result: Make) -> None:
    """A bill without a part looked like an order that was lost, where a search was stopped before it found any."""
    write.write_results(make_result(), tmp_path)
    paths = write.write_results(make_result(status="infeasible", recommendation=None), tmp_path)
    kept = ["report.html", "result.json", "system.yaml"]
    assert sorted(path.name for path in paths) == kept == sorted(path.name for path in tmp_path.iterdir())
    assert (tmp_path / "system.yaml").read_text("utf-8").startswith("# Nothing fits")
    write.write_results(make_result(status="stopped", recommendation=None), tmp_path)
    assert (tmp_path / "system.yaml").read_text("utf-8").startswith("# No system was found so far")


def test_system_is_written_with_the_settings_to_type_in(make_result: Make) -> None:
    best = make_result().best
    system = yaml.safe_load(write.system_yaml(make_result()))
    assert system == best.as_system(to_set=True)
    for scene in best.scenes:
        assert system["scenes"][scene.name]["exposure_ms"] == scene.settings_to_set["exposure_ms"]


def test_failure_while_writing_leaves_the_old_files(
    tmp_path: Path, make_result: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "result.json").write_text("old", "utf-8")

    def full_disk(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full_disk)
    with pytest.raises(OutputError, match="No space left"):
        write.write_results(make_result(), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["result.json"]
    assert (tmp_path / "result.json").read_text("utf-8") == "old"


def test_file_in_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "taken"
    file.touch()
    with pytest.raises(OutputError, match="is a file, not a folder"):
        write.check_folder(file)
    with pytest.raises(OutputError):
        write.check_folder(file / "below")
    with pytest.raises(OutputError, match="empty"):
        write.check_folder("")


def test_folder_in_place_of_a_result_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "bom.csv").mkdir()
    with pytest.raises(OutputError, match=r"bom\.csv: is a folder"):
        write.check_folder(tmp_path)


def test_checking_a_folder_makes_nothing(tmp_path: Path) -> None:
    write.check_folder(tmp_path / "later")
    write.check_folder(tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["a" * 300, "below/" + "a" * 300])
def test_a_folder_that_cannot_be_made_is_refused_beforehand(tmp_path: Path, name: str) -> None:
    with pytest.raises(OutputError, match="choose another --out"):
        write.check_folder(tmp_path / name)
    with pytest.raises(OutputError, match="choose another --out"):
        write.checked_out_file(tmp_path / name / "page.html")
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_takes_nothing_is_refused_beforehand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "mkdir", full)
    monkeypatch.setattr(Path, "touch", full)
    for folder in (tmp_path, tmp_path / "new" / "below"):
        with pytest.raises(OutputError, match="No space left"):
            write.check_folder(folder)


def test_new_file_is_never_written_over_an_old_one(tmp_path: Path) -> None:
    file = tmp_path / "reef.yaml"
    write.write_new(file, "name: a\n")
    with pytest.raises(OutputError, match="exists already"):
        write.write_new(file, "name: b\n")
    assert file.read_text("utf-8") == "name: a\n"
    with pytest.raises(OutputError, match="is a folder"):
        write.write_new(tmp_path, "name: b\n")
    with pytest.raises(OutputError, match="folder does not exist"):
        write.write_new(tmp_path / "none" / "reef.yaml", "name: b\n")


def test_json_fits_a_narrow_encoding(make_result: Make) -> None:
    result = make_result(mission={"name": "Récif"})
    text = write.json_text(result, "ascii")
    assert text.isascii()
    assert json.loads(text)["mission"]["name"] == "Récif"

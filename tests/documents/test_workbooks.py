"""Workbooks of others: texts alone, nothing worked out, nothing too large."""

from __future__ import annotations

import datetime as dt
import io
import zipfile
from pathlib import Path

import pytest

openpyxl = pytest.importorskip("openpyxl")

from uwopt.documents import workbooks  # noqa: E402
from uwopt.documents.workbooks import read_workbook  # noqa: E402
from uwopt.errors import CatalogError  # noqa: E402


def saved(folder: Path, **cells: object) -> Path:
    book = openpyxl.Workbook()
    for place, value in cells.items():
        book.active[place] = value
    book.save(folder / "a.xlsx")
    return folder / "a.xlsx"


def test_cells_are_read_as_texts(tmp_path: Path) -> None:
    file = saved(tmp_path, A1="price", B1=2500.0, C1=dt.datetime(2026, 11, 20), D1=True, E1=0.35)
    assert read_workbook(file)["Sheet"] == [["price", "2500", "2026-11-20", "yes", "0.35"]]


@pytest.mark.parametrize("formula", ["=1+1", '=HYPERLINK("http://x")', "=cmd|' /C calc'!A0"])
def test_formulas_are_refused_with_their_place(tmp_path: Path, formula: str) -> None:
    with pytest.raises(CatalogError, match="sheet 'Sheet' cell B2 holds a formula"):
        read_workbook(saved(tmp_path, B2=formula))


def with_piece(file: Path, name: str, data: bytes) -> Path:
    with zipfile.ZipFile(file, "a", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr(name, data)
    return file


@pytest.mark.parametrize("name", ["xl/vbaProject.bin", "xl/externalLinks/externalLink1.xml", "xl/embeddings/o.bin"])
def test_macros_links_and_embedded_files_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(CatalogError, match="macros, links or embedded files"):
        read_workbook(with_piece(saved(tmp_path, A1="x"), name, b"x"))


def test_what_grows_too_large_is_refused_unread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workbooks, "MOST_UNPACKED", 1_000_000)
    with pytest.raises(CatalogError, match="unpacks to more than 1 MB"):
        read_workbook(with_piece(saved(tmp_path, A1="x"), "xl/large.xml", b"0" * 2_000_000))


@pytest.mark.parametrize("content", [b"", b"no workbook", b"PK\x03\x04 cut off"])
def test_what_is_no_workbook_is_told_in_one_sentence(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.xlsx").write_bytes(content)
    with pytest.raises(CatalogError, match="is no workbook"):
        read_workbook(tmp_path / "a.xlsx")


def test_damaged_workbook_gives_no_traceback(tmp_path: Path) -> None:
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w") as packed:
        packed.writestr("xl/workbook.xml", "<workbook")
    (tmp_path / "a.xlsx").write_bytes(held.getvalue())
    with pytest.raises(CatalogError, match="cannot be read as a workbook"):
        read_workbook(tmp_path / "a.xlsx")


def test_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(CatalogError, match="no such file"):
        read_workbook(tmp_path / "none.xlsx")

"""Workbooks that a person sends back: texts of cells and nothing else.

A formula is refused, not worked out; so are macros, links to other files, and what is larger than such a file ever is.
"""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

from uwopt.documents.files import UnfitFileError, content
from uwopt.errors import CatalogError

MOST_BYTES, MOST_UNPACKED = 2_000_000, 40_000_000
MOST_SHEETS, MOST_ROWS, MOST_COLUMNS = 50, 2000, 60
REFUSED = ("vbaproject", "externallink", "activex", "embeddings")  # pieces of a workbook that do or fetch something

Sheet = list[list[str]]


def read_workbook(path: Path, form: str | None = None) -> dict[str, Sheet]:
    """Rows of texts of every sheet, by its name; raises CatalogError with where and what is wrong.

    form : what stands in the first cell of the sheets that are read; a formula in another is no fault
    """
    try:
        raw = content(path, MOST_BYTES)
    except FileNotFoundError:
        raise CatalogError(f"{path}: no such file; name the workbook or CSV that came back.") from None
    except UnfitFileError as fault:
        raise CatalogError(f"{path}: {fault}.") from None
    except OSError as fault:
        raise CatalogError(f"{path}: cannot be read ({fault.strerror or fault}).") from None
    refuse_packed(raw, path)
    return sheets_of(raw, path, form)


def refuse_packed(raw: bytes, path: Path) -> None:
    """Raise for what is no workbook, grows too large when unpacked, or holds more than cells."""
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as packed:
            pieces = packed.infolist()
    except (zipfile.BadZipFile, ValueError, EOFError, OSError):
        raise CatalogError(f"{path}: is no workbook of the form .xlsx; save it as one, or as CSV.") from None
    if sum(piece.file_size for piece in pieces) > MOST_UNPACKED or len(pieces) > 10 * MOST_SHEETS:
        raise CatalogError(f"{path}: unpacks to more than {MOST_UNPACKED / 1e6:.0f} MB; send the filled form alone.")
    active = sorted({word for piece in pieces for word in REFUSED if word in piece.filename.casefold()})
    if active:
        raise CatalogError(f"{path}: holds macros, links or embedded files ({', '.join(active)}); save it without.")


def sheets_of(raw: bytes, path: Path, form: str | None) -> dict[str, Sheet]:
    """Texts of all cells; of sheets of another form than is asked for those of the first row alone."""
    from openpyxl import load_workbook

    try:
        book = load_workbook(io.BytesIO(raw), read_only=True, data_only=False, keep_links=False)
    except Exception as fault:  # whatever a damaged file makes of the library
        raise CatalogError(f"{path}: cannot be read as a workbook ({type(fault).__name__}); save it anew.") from None
    faults: list[str] = []
    made: dict[str, Sheet] = {}
    try:
        if len(book.worksheets) > MOST_SHEETS:
            raise CatalogError(f"{path}: holds more than {MOST_SHEETS} sheets; send the filled form alone.")
        for sheet in book.worksheets:
            told = faults if form is None or sheet["A1"].value == form else []
            rows = sheet.iter_rows(max_row=MOST_ROWS if told is faults else 1, max_col=MOST_COLUMNS)
            made[sheet.title] = [trimmed([cell_text(cell, sheet.title, told) for cell in row]) for row in rows]
    except CatalogError:
        raise
    except Exception as fault:
        raise CatalogError(f"{path}: cannot be read as a workbook ({type(fault).__name__}); save it anew.") from None
    finally:
        book.close()
    if faults:
        more = [f"and {len(faults) - 8} more"] if len(faults) > 8 else []
        raise CatalogError([f"{path}: {fault}" for fault in faults[:8]] + [f"{path}: {text}" for text in more])
    return made


def trimmed(texts: list[str]) -> list[str]:
    """A row without the empty cells at its end."""
    last = max((n for n, text in enumerate(texts, 1) if text), default=0)
    return texts[:last]


def cell_text(cell: Any, sheet: str, faults: list[str]) -> str:
    """A cell as text; a formula becomes a fault."""
    value = getattr(cell, "value", None)
    if value is None:
        return ""
    if getattr(cell, "data_type", "") == "f":
        place = f"sheet {sheet!r} cell {cell.coordinate}"
        faults.append(f"{place} holds a formula; paste it as a value, nothing of a workbook is worked out.")
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float) and value == int(value) and abs(value) < 1e15:
        return str(int(value))
    if hasattr(value, "isoformat"):
        return str(value.isoformat())[:10]
    return str(value).strip()

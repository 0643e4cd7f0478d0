"""Files that a person names: read only where they can end, and are not larger than such a file ever is; CSV written."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from pathlib import Path
from typing import Any

MOST_BYTES = 100_000_000  # of a table or a result; missions are held to less
FORMULA_SIGNS = ("=", "+", "-", "@", "\t", "\r", "\n")  # a spreadsheet takes a cell that begins so for a formula
#: What files begin with that are neither YAML nor a table, which a person may name by mistake.
OTHER_KINDS = {b"pk\x03\x04": "a workbook or an archive", b"<!doctype": "a web page", b"<html": "a web page",
               b"%pdf": "a PDF", b"\x89png": "a picture"}  # fmt: skip


class UnfitFileError(Exception):
    """A file is not read; the message says why, as the end of a sentence that begins with its name."""


def content(path: Path, most_bytes: int = MOST_BYTES) -> bytes:
    """What a file holds; raises UnfitFileError for pipes, devices and what is too large, OSError as reading does."""
    status = path.stat()
    if path.is_dir():
        raise IsADirectoryError(21, "Is a directory", str(path))
    if not path.is_file():
        raise UnfitFileError("is not a regular file; save what it gives to one first")
    if status.st_size > most_bytes:
        raise UnfitFileError(f"holds {status.st_size / 1e6:.0f} MB, more than {most_bytes / 1e6:.0f}")
    return path.read_bytes()


def other_kind(raw: bytes) -> str:
    """What a file is that is neither YAML nor a table; nothing where it may be one."""
    begins = raw.lstrip()[:9].lower()
    return next((kind for start, kind in OTHER_KINDS.items() if begins.startswith(start)), "")


def csv_text(rows: Iterable[Iterable[Any]]) -> str:
    """Rows as CSV, with the same ends of lines on every system."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()

"""Result files: written under a temporary name and moved, so that no half-written file is ever seen.

What is written belongs together: the JSON, the table made from it, and the page made from it.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from uwopt.deadline import NEVER, Deadline
from uwopt.documents.files import csv_text
from uwopt.errors import OutputError
from uwopt.report.text.cells import defused, to_pay
from uwopt.results.design import BillRow
from uwopt.results.result import Result

if TYPE_CHECKING:
    from uwopt.results.front import FrontResult
    from uwopt.results.sweep import SweepSummary
    from uwopt.results.whatif import WhatIf

    AnyResult = Result | FrontResult | WhatIf | SweepSummary

Writes = Callable[[BinaryIO], None]
RESULT_FILE, BOM_FILE, PAGE_FILE = "result.json", "bom.csv", "report.html"
SYSTEM_FILE = "system.yaml"
SOLVED_FILE = "mission-as-solved.yaml"
BOOK_FILE = "bom.xlsx"
FRONT_FILE, FRONT_TABLE = "front.json", "front.csv"
WHATIF_FILE, WHATIF_TABLE, WHATIF_PARQUET = "whatif.json", "whatif.csv", "whatif.parquet"
WRITTEN = (
    RESULT_FILE, SYSTEM_FILE, SOLVED_FILE, BOM_FILE, BOOK_FILE, FRONT_FILE, FRONT_TABLE, PAGE_FILE, WHATIF_FILE,
    WHATIF_TABLE,
)  # fmt: skip
BOM_COLUMNS = (
    "kind", "id", "manufacturer", "model", "count", "owned", "unit_price", "unit_price_low", "unit_price_high",
    "to_pay", "to_pay_low", "to_pay_high", "currency", "price_status", "price_date", "generic", "source", "price_basis",
    "note", "purpose", "availability", "checked", "unit_mass_kg", "power_w",
)  # fmt: skip


def write_results(result: Result, folder: str | Path, *, deadline: Deadline = NEVER) -> list[Path]:
    """Write result.json, system.yaml, bom.csv, bom.xlsx and report.html into a folder, made if need be; their paths.

    Without a system there is no bill, for one without a part would look like an order that was lost, and system.yaml
    is a remark that says why; a bill of an earlier run does not stay. Where good practice gave way a mission that says
    so is written too. The page does without pictures for which the deadline leaves no time.
    """
    target = check_folder(folder)
    files: dict[str, str | bytes] = {RESULT_FILE: json_text(result) + "\n", SYSTEM_FILE: system_yaml(result)}
    if result.best is not None:
        files[BOM_FILE] = bom_csv(result.best.bom)
        if find_spec("openpyxl") is not None:  # without it the table remains
            from uwopt.report.order.bom_book import bom_book

            files[BOOK_FILE] = bom_book(result)
    if result.mission_as_solved is not None:
        files[SOLVED_FILE] = result.mission_as_solved
    written = write_files(made_folder(target), files | {PAGE_FILE: page_text(result, deadline)})
    for name in {BOM_FILE, BOOK_FILE, SOLVED_FILE} - set(files):  # of an earlier run
        (target / name).unlink(missing_ok=True)
    return written


def write_front(front: FrontResult, folder: str | Path, *, deadline: Deadline = NEVER) -> list[Path]:
    """Write front.json, front.csv and report.html into a folder, made if need be; returns their paths.

    The page does without pictures for which the deadline leaves no time.
    """
    target = check_folder(folder)
    texts = {
        FRONT_FILE: json_text(front) + "\n",
        FRONT_TABLE: front_csv(front),
        PAGE_FILE: page_text(front, deadline),
    }
    return write_files(made_folder(target), texts)


def write_whatif(table: WhatIf, folder: str | Path) -> list[Path]:
    """Write whatif.json, report.html and the table as CSV, beside it as Parquet."""
    target = check_folder(folder)
    texts: dict[str, str | bytes] = {
        WHATIF_FILE: json_text(table) + "\n",
        WHATIF_TABLE: rows_csv(table.rows(), [key.key for key in table.keys]),
        PAGE_FILE: page_text(table),
    }
    if table.points:
        buffer = io.BytesIO()
        table.frame().to_parquet(buffer)
        texts[WHATIF_PARQUET] = buffer.getvalue()
    return write_files(made_folder(target), texts)


def write_page(result: AnyResult, file: str | Path, *, deadline: Deadline = NEVER) -> Path:
    """Write the report of a result to a file; one that stands there is replaced.

    The page does without pictures for which the deadline leaves no time.
    """
    return write_text(page_text(result, deadline), check_page(file))


def page_in(out: str, name: str) -> str:
    """Where a page goes: the file that is named, or a file of a name in a folder."""
    named = Path(out)
    is_folder = out.endswith(("/", "\\")) or named.is_dir() or not named.suffix
    return str(named / name) if out.strip() and is_folder else out


def check_page(file: str | Path) -> Path:
    """The file if a page can be written there, and its name does not promise something else; raises OutputError."""
    path = checked_out_file(file)
    if path.suffix.casefold() not in ("", ".html", ".htm"):
        raise OutputError(f"{file}: its name must end in .html, for a page is written; a browser prints it as PDF.")
    return path


def write_text(text: str, file: str | Path) -> Path:
    """Write a text to a file, whole or not at all; one that stands there is replaced."""
    target = checked_out_file(file)
    return write_files(made_folder(target.parent), {target.name: text})[0]


def page_text(result: AnyResult, deadline: Deadline = NEVER) -> str:
    """The page of a result; the template engine is loaded only when a page is made."""
    from uwopt.results.sweep import SweepSummary
    from uwopt.results.whatif import WhatIf

    if isinstance(result, WhatIf):
        from uwopt.report.page.whatif import whatif_html

        return whatif_html(result)
    if isinstance(result, SweepSummary):
        from uwopt.report.page.sweep import sweep_html

        return sweep_html(result)
    from uwopt.report.page.page import report_html

    return report_html(result, deadline)


def made_folder(folder: Path) -> Path:
    """The folder, made if need be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise OutputError(f"{folder}: cannot be made ({reason(fault)}); choose another --out.") from None
    return folder


def checked_out_file(file: str | Path) -> Path:
    """The file if it can be written, now or once its folder is made; raises OutputError."""
    path = Path(file)
    if not str(file).strip():
        raise OutputError("--out is empty; name a file, or a folder.")
    try:
        is_folder = path.is_dir()
    except (OSError, ValueError) as fault:
        raise OutputError(f"{file}: cannot be used ({reason(fault)}); choose another --out.") from None
    if is_folder:
        raise OutputError(f"{file}: is a folder where the report goes; choose another --out.")
    check_folder(path.parent)
    return path


def check_folder(folder: str | Path) -> Path:
    """The folder if results can be written there, now or once it is made; raises OutputError."""
    path = Path(folder)
    if not str(folder).strip():
        raise OutputError("--out is empty; name a folder, or . for this one.")
    try:
        if path.exists() and not path.is_dir():
            raise OutputError(f"{folder}: is a file, not a folder; choose another --out.")
        if path.is_symlink() and not path.exists():
            raise OutputError(f"{folder}: is a link to what does not exist; choose another --out.")
        standing = path.absolute()
        while not standing.exists() and standing != standing.parent:
            standing = standing.parent
        writable = standing.is_dir() and os.access(standing, os.W_OK | os.X_OK)
        if writable:
            try_in(standing, path.absolute().relative_to(standing).parts)
        for name in WRITTEN:
            if (path / name).is_dir():
                raise OutputError(
                    f"{path / name}: is a folder where a result file goes; choose another --out."
                )
    except (OSError, ValueError) as fault:
        raise OutputError(f"{folder}: cannot be used ({reason(fault)}); choose another --out.") from None
    if not writable:
        raise OutputError(f"{folder}: cannot be written to; check its rights or choose another --out.")
    return path


def try_in(standing: Path, below: Sequence[str]) -> None:
    """Make a file in a folder, in folders of such names below it, and take all away again; raises OSError.

    Rights alone do not tell: a disk may be read only or full, and a name too long.
    """
    top = standing / f".uwopt.{os.getpid()}.{threading.get_ident()}.tmp"
    if not below:
        top.touch()
        top.unlink()
        return
    made = [top.joinpath(*below[:depth]) for depth in range(len(below) + 1)]
    try:
        for folder in made:
            folder.mkdir()
    finally:
        for folder in reversed(made):
            with contextlib.suppress(OSError):
                folder.rmdir()


def write_files(folder: Path, contents: Mapping[str, str | bytes | Writes]) -> list[Path]:
    """Write all files beside their final places, then move them; either all are new or none is.

    A content that is too large for memory is a function that writes it.
    """
    made: list[tuple[Path, Path]] = []
    try:
        for name, content in contents.items():
            temporary = folder / f".{name}.{os.getpid()}.{threading.get_ident()}.tmp"
            made.append((temporary, folder / name))
            with temporary.open("wb") as file:
                if callable(content):
                    content(file)
                else:
                    file.write(content if isinstance(content, bytes) else content.encode("utf-8"))
                file.flush()
                os.fsync(file.fileno())
        with alone_in(folder):
            for temporary, final in made:
                temporary.replace(final)
    except OSError as fault:
        raise OutputError(f"{folder}: cannot be written ({reason(fault)}); choose another --out.") from None
    finally:
        for temporary, _ in made:
            temporary.unlink(missing_ok=True)
    return [final for _, final in made]


@contextlib.contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """One run at a time moves its files into a folder, so that they belong together; where folders can be locked.

    At the end it is asked of the disk that the files have their names, so that power may fail.
    """
    try:
        import fcntl
    except ImportError:  # Windows
        yield
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        with contextlib.suppress(OSError):  # some network drives know no locks
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
        with contextlib.suppress(OSError):  # nor this
            os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_new(path: str | Path, text: str) -> Path:
    """Write a file that must not exist yet."""
    target = Path(path)
    try:
        with target.open("x", encoding="utf-8", newline="\n") as file:
            try:
                file.write(text)
                file.flush()
            except OSError:
                target.unlink(missing_ok=True)
                raise
    except FileExistsError:
        what = "is a folder; name a file in it" if target.is_dir() else "exists already; name another file"
        raise OutputError(f"{path}: {what}.") from None
    except FileNotFoundError:
        raise OutputError(f"{path}: its folder does not exist; make it first.") from None
    except (OSError, ValueError) as fault:
        raise OutputError(f"{path}: cannot be written ({reason(fault)}).") from None
    return target


def json_text(result: AnyResult, encoding: str = "utf-8") -> str:
    """The result as JSON; signs that an encoding does not know are written as escapes."""
    text = result.to_json()
    try:
        text.encode(encoding)
    except (UnicodeEncodeError, LookupError):
        return json.dumps(result.to_dict(), indent=1, allow_nan=False, ensure_ascii=True)
    return text


CENTS = 6  # digits behind the point: no tails of sums


def bom_csv(rows: Sequence[BillRow]) -> str:
    """A bill of materials as CSV that a spreadsheet takes for text and numbers only."""
    made: list[Sequence[Any]] = [BOM_COLUMNS]
    for row in rows:
        low, high = row.unit_price_low, row.unit_price_high
        due = {"to_pay": to_pay(row, row.unit_price), "to_pay_low": to_pay(row, low), "to_pay_high": to_pay(row, high)}
        values = {**due, **asdict(row)}
        if row.price_status == "estimated":
            values["price_status"] = "estimated, no quote"
        plain = {key: round(value, CENTS) if isinstance(value, float) else value for key, value in values.items()}
        made.append([defused(plain[column]) for column in BOM_COLUMNS])
    return csv_text(made)


def system_yaml(result: Result) -> str:
    """The system of a result as a file that `uwopt evaluate` takes, to be changed by hand; a remark without one."""
    import yaml

    if result.best is None:
        why = "Nothing fits" if result.status == "infeasible" else "No system was found so far"
        return f"# {why}: there is no system to write down.\n"
    settable = result.best.is_settable
    told = "to type in" if settable and any(scene.settings_to_set for scene in result.best.scenes) else "exact"
    text = yaml.safe_dump(result.best.as_system(to_set=settable), sort_keys=False, allow_unicode=True)
    return f"# `uwopt evaluate MISSION system.yaml` says what this system does; settings are those {told}.\n{text}"


def front_csv(front: FrontResult) -> str:
    """A front's table as CSV, a row a point; columns are those of any point."""
    return rows_csv(front.rows(), ["point"])


def rows_csv(rows: Sequence[Mapping[str, Any]], otherwise: Sequence[str]) -> str:
    """Rows by column as CSV; columns are those of any row, or others where there is none."""
    columns = list(dict.fromkeys(key for row in rows for key in row)) or list(otherwise)
    cells = [columns, *([row.get(column) for column in columns] for row in rows)]
    return csv_text(map(defused, row) for row in cells)


def reason(fault: Exception) -> str:
    """Why the system refused, in its words without the path."""
    return getattr(fault, "strerror", None) or str(fault)

"""The files that plain values name: a water's profile, own parts with their curves, quotes."""

from __future__ import annotations

import csv
import hashlib
import io
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from uwopt.documents.files import UnfitFileError, content
from uwopt.documents.whole_file import resolve_path
from uwopt.sweeps.job import hash_of

DEEPEST = 3  # files named by files that files name
LONGEST = 400  # of a name
Files = dict[str, bytes]  # by absolute path


def files_named(value: Any, folders: Iterable[Path | None]) -> Files:
    """The files that texts in plain values name, looked for in folders, and those that their tables name in turn."""
    found: Files = {}
    places = list(folders)
    for text in texts_of(value):
        for folder in places:
            for name in file_and_its_own(text, folder):
                found[name] = held(name)
    return found


def held_hash(files: Files) -> str:
    """A hash of what files hold, whatever they are called; empty of none."""
    return (
        hash_of(sorted(hashlib.blake2b(one, digest_size=16).hexdigest() for one in files.values()))
        if files
        else ""
    )


def texts_of(value: Any) -> Iterator[str]:
    """All texts in plain values that may be names of files: those with an ending."""
    if isinstance(value, str):
        if "." in value and len(value) <= LONGEST and "\n" not in value:
            yield value
    elif isinstance(value, Mapping):
        for one in value.values():
            yield from texts_of(one)
    elif isinstance(value, (list, tuple)):
        for one in value:
            yield from texts_of(one)


def file_and_its_own(text: str, folder: Path | None, depth: int = DEEPEST) -> tuple[str, ...]:
    """A named file and those that the cells of its table name; empty where there is none."""
    path = resolve_path(text, folder).absolute()
    try:
        if not path.is_file():
            return ()
        raw = held(str(path))
    except (
        OSError,
        ValueError,
        RuntimeError,
        UnfitFileError,
    ):  # what cannot be read is told by whom it serves
        return ()
    found = [str(path)]
    if depth and path.suffix.casefold() == ".csv":
        rows = csv.reader(io.StringIO(raw.decode("utf-8", "replace")))
        cells = {cell for row in safely(rows) for cell in row}
        found += [
            name
            for cell in texts_of(sorted(cells))
            for name in file_and_its_own(cell, path.parent, depth - 1)
        ]
    return tuple(dict.fromkeys(found))


def safely(rows: Any) -> Iterator[list[str]]:
    """Rows as far as they are a table."""
    while True:
        try:
            yield next(rows)
        except (StopIteration, csv.Error):
            return


def held(name: str) -> bytes:
    """What a file holds."""
    return content(Path(name))

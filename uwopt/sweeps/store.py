"""Rows on disk: a Parquet file a batch, written beside its place and moved, so that whatever stands there is whole.

A run that ended in any way leaves the rows of its finished batches; the next finds them by their keys. Many small
files are joined into one now and then; where that is interrupted rows stand twice, and count once.
"""

from __future__ import annotations

import contextlib
import io
import itertools
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np

from uwopt.arrays import Array
from uwopt.errors import OutputError
from uwopt.report.write import check_folder, made_folder, reason, write_files
from uwopt.sweeps.rows import DIED, FLAGS, TEXTS, WHOLES, Row

if TYPE_CHECKING:
    import pyarrow as pa

SERVED = "served"  # folder of what kits serve
ROWS, ENDING, DAMAGED = "rows", ".parquet", ".damaged"
MOST_SMALL = 128  # files, before they are joined
PIECE = 20_000  # rows of a table that are held at a time
MOST_OPEN = 4  # files of which rows are
LOCK = ".lock"


@dataclass
class SweepStore:
    """The rows of a sweep's folder; use as a context, in which no other run writes there."""

    folder: Path
    name: str = ROWS  # of the folder in it
    damaged: list[str] = field(default_factory=list)  # files that cannot be read, set aside
    _files: list[str] = field(default_factory=list)  # in the order in which they were written
    _small: dict[str, pa.Table] = field(default_factory=dict)  # those that are not joined yet
    _keys: set[str] = field(default_factory=set)
    _open: dict[tuple[str, tuple[str, ...] | None], pa.Table] = field(default_factory=dict)  # read last
    _lock: int | None = None
    _next: int = 0

    @property
    def place(self) -> Path:
        """Where the batches lie."""
        return self.folder / self.name

    def __enter__(self) -> SweepStore:
        made_folder(check_folder(self.folder))
        made_folder(check_folder(self.place))
        self._lock = locked(self.place / LOCK)
        try:
            for left in self.place.glob(".*.tmp"):  # of a run that was killed while it wrote
                left.unlink(missing_ok=True)
            for path in sorted(self.place.glob(f"*{ENDING}")):
                self._look_at(path)
        except OSError as fault:
            self.close()
            raise OutputError(
                f"{self.place}: cannot be read ({reason(fault)}); choose another --out."
            ) from None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let other runs write there again."""
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    @property
    def keys(self) -> set[str]:
        """Keys of all rows that need not be worked out again."""
        return self._keys

    def add(self, rows: Sequence[Row]) -> None:
        """Keep rows; raises OutputError where they cannot be written, and then what stood there still stands."""
        if not rows:
            return
        table = arrow_table(rows)
        self._small[self._write(table)] = table
        self._keys |= keys_in(table)
        if len(self._small) >= MOST_SMALL:
            self._join()

    def columns(self) -> list[str]:
        """Names of all columns of any row."""
        import pyarrow.parquet as pq

        names = [pq.read_schema(self.place / name).names for name in self._files]
        return list(dict.fromkeys(name for some in names for name in some)) or ["key"]

    def pieces(self, keys: Iterable[str], columns: Sequence[str] | None = None) -> Iterator[tuple[Array, pa.Table]]:
        """The rows of some keys in their order, some thousand at a time: which of the keys they are, and the rows.

        A key without a row is passed over; of several rows the last counts. However many there are, a piece and its
        files alone are held in memory, and where each key stands: 50 bytes a row.
        """
        import pyarrow as pa

        known, file, row = self._places()
        first, left = 0, iter(keys)
        while some := list(itertools.islice(left, PIECE)):
            wanted = np.array(some, "S")
            at = np.searchsorted(known, wanted)
            there = at < len(known)
            there[there] = known[at[there]] == wanted[there]
            found, at = np.flatnonzero(there), at[there]
            parts, order = [], []
            for number in np.unique(file[at]):
                mine = np.flatnonzero(file[at] == number)
                parts.append(self._read(self._files[number], columns).take(pa.array(row[at[mine]])))
                order.append(mine)
            if parts:
                whole = pa.concat_tables(parts, promote_options="permissive")
                yield first + found, whole.take(pa.array(np.argsort(np.concatenate(order))))
            first += len(some)

    def _places(self) -> tuple[Array, Array, Array]:
        """All keys in rising order, with the file and the row where each stands last."""
        keys, files, rows = [np.empty(0, "S1")], [np.empty(0, int)], [np.empty(0, int)]
        for number, name in enumerate(self._files):
            keys.append(np.array(self._read(name, ["key"]).column("key").to_pylist(), "S"))
            files.append(np.full(len(keys[-1]), number))
            rows.append(np.arange(len(keys[-1])))
        key, file, row = (np.concatenate(some) for some in (keys, files, rows))
        order = np.argsort(key, kind="stable")
        key = key[order]
        last = np.append(key[1:] != key[:-1], True)[: len(key)]
        return key[last], file[order][last], row[order][last]

    def _read(self, name: str, columns: Sequence[str] | None) -> pa.Table:
        """One file, those columns of it that it has; the last few are kept as they were read."""
        import pyarrow.parquet as pq

        key = name, None if columns is None else tuple(columns)
        if key not in self._open:
            held = self._small.get(name)
            known = pq.read_schema(self.place / name).names if held is None else held.column_names
            wanted = known if columns is None else [column for column in columns if column in known] or ["key"]
            if held is None:
                made = pq.read_table(self.place / name, columns=wanted, partitioning=None)
            else:
                made = held.select(wanted)
            while len(self._open) >= MOST_OPEN:
                del self._open[next(iter(self._open))]
            self._open[key] = made
        return self._open[key]

    def _join(self) -> None:
        """One file in the place of the small ones."""
        import pyarrow as pa

        old = list(self._small)
        self._write(pa.concat_tables(self._small.values(), promote_options="permissive"))
        self._small.clear()
        for name in old:
            self._files.remove(name)
            with contextlib.suppress(OSError):  # what stays stands twice and counts once
                (self.place / name).unlink()

    def _write(self, table: pa.Table) -> str:
        """Write a file of its own; returns its name."""
        name = f"{self._next:08d}{ENDING}"
        write_files(self.place, {name: parquet_bytes(table)})
        self._next += 1
        self._files.append(name)
        return name

    def _look_at(self, path: Path) -> None:
        """A file of an earlier run; one that is damaged is set aside, and its missions worked out again."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        with contextlib.suppress(ValueError):
            self._next = max(self._next, int(path.stem) + 1)
        try:
            self._keys |= keys_in(pq.read_table(path, partitioning=None))
        except (pa.ArrowException, OSError, ValueError, KeyError):
            path.replace(path.with_name(path.name + DAMAGED))
            self.damaged.append(path.name)
        else:
            self._files.append(path.name)


def keys_in(table: pa.Table) -> set[str]:
    """Keys of rows that are answers; missions whose worker died are asked again."""
    keys = table.column("key").to_pylist()
    if "message" not in table.column_names:
        return set(keys)
    told = table.column("message").to_pylist()
    return {key for key, message in zip(keys, told, strict=True) if not (message or "").startswith(DIED)}


def locked(path: Path) -> int | None:
    """A lock that holds until it is closed or the process ends; raises OutputError where another run has it."""
    try:
        import fcntl
    except ImportError:  # Windows
        return None
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as fault:
        raise OutputError(f"{path}: cannot be written ({reason(fault)}); choose another --out.") from None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        text = "another sweep is writing there; wait for it, or choose another --out."
        raise OutputError(f"{path.parent.parent}: {text}") from None
    except OSError:  # some network drives know no locks
        pass
    return descriptor


# ---------------------------------------------------------------- tables


def arrow_table(rows: Sequence[Row]) -> pa.Table:
    """Rows as a table; a column of which nothing is known is left out, but for the keys."""
    import pyarrow as pa

    names = dict.fromkeys(
        ["key", *(name for row in rows for name, value in row.items() if value is not None)]
    )
    return pa.table({name: pa.array([row.get(name) for row in rows], kind_of(name)) for name in names})


def kind_of(name: str) -> pa.DataType:
    """The kind of a column by its name: what one batch lacks has the same kind in the next."""
    import pyarrow as pa

    if name in TEXTS:
        return pa.string()
    if name in WHOLES:
        return pa.int64()
    return pa.bool_() if name in FLAGS else pa.float64()


def parquet_bytes(table: pa.Table) -> bytes:
    """A table as a Parquet file."""
    import pyarrow.parquet as pq

    buffer = io.BytesIO()
    pq.write_table(table, buffer, compression="zstd")
    return buffer.getvalue()

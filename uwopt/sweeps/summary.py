"""What the rows of a sweep amount to, and the files that say so."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from uwopt.report.write import PAGE_FILE, json_text, page_text, rows_csv, write_files
from uwopt.results.design import Note
from uwopt.results.sweep import SWEEP_PARQUET, FailedMissions, SweepKit, SweepPortfolio, SweepSummary
from uwopt.sweeps.job import LABEL, SweepJob
from uwopt.sweeps.kits import YES
from uwopt.sweeps.portfolio import portfolios
from uwopt.sweeps.rows import FAILED, FIRST, LAST, OUTPUTS
from uwopt.sweeps.store import SweepStore, parquet_bytes
from uwopt.version import __version__

if TYPE_CHECKING:
    import pyarrow as pa

SWEEP_FILE, SWEEP_TABLE = "sweep.json", "sweep.csv"
MOST_CSV = 200_000  # rows: beyond them the Parquet table alone
KIT = ("camera", "lens", "port", "housing", "complete", "light", "camera_count", "light_count")
MOST_FAILURES = 20  # reasons that are told


def write_sweep(made: SweepSummary, job: SweepJob, store: SweepStore, folder: Path) -> list[Path]:
    """Write the table as Parquet and CSV, the summary and the page."""
    table = table_in_order(job, store)
    files: dict[str, str | bytes] = {SWEEP_PARQUET: parquet_bytes(table)}
    if len(table) <= MOST_CSV:
        files[SWEEP_TABLE] = rows_csv(table.to_pylist(), table.column_names)
    files |= {SWEEP_FILE: json_text(made) + "\n", PAGE_FILE: page_text(made)}
    return write_files(folder, files)


def table_in_order(job: SweepJob, store: SweepStore) -> pa.Table:
    """The rows of a job's missions in the order of the job, with their inputs as columns.

    An input is called as a person names it; with `input.` before where a column of results has that name.
    """
    import pyarrow as pa

    stored = store.table()
    places = {key: place for place, key in enumerate(stored.column("key").to_pylist())}
    tasks = [(n, task) for n, task in enumerate(job.tasks()) if task.key in places]
    rows = stored.take(pa.array([places[task.key] for _, task in tasks], pa.int64()))
    known = set(rows.column_names)
    columns: dict[str, Any] = {"n": pa.array([n for n, _ in tasks], pa.int64())}
    for index, key in enumerate(job.keys):
        if key != LABEL:
            name = f"input.{key}" if key in known | OUTPUTS else key
            columns[name] = input_array([task.values[index] for _, task in tasks])
    rest = sorted(known - {*FIRST, *LAST, "inputs"})
    for name in (*(n for n in FIRST if n != "inputs"), *rest, *LAST):
        if name in known:
            columns[name] = rows.column(name)
    return pa.table(columns)


def input_array(values: Sequence[Any]) -> Any:
    """A column of inputs: of numbers where all are, else of texts."""
    import pyarrow as pa

    if all(value is None or isinstance(value, (int, float)) for value in values):
        return pa.array(values, pa.float64())
    return pa.array([None if value is None else str(value) for value in values], pa.string())


# ---------------------------------------------------------------- summary


def summary_of(job: SweepJob, store: SweepStore, *, interrupted: bool, kept: int) -> SweepSummary:
    """What the rows of a job amount to."""
    rows = job_rows(job, store)
    counts = Counter(str(row["status"]) for row in rows)
    missing = len(job) - len(rows)
    currencies = {row["currency"] for row in rows if row.get("currency")}
    failed = Counter(str(row.get("message")) for row in rows if row["status"] == FAILED)
    return SweepSummary(
        status="interrupted" if interrupted or missing else "complete",
        what=job.ways.command,
        missions=len(job),
        counts=dict(counts.most_common()) | ({"missing": missing} if missing else {}),
        keys=list(job.keys),
        uwopt_version=__version__,
        identity=dict(job.identity),
        kits=kits_of(rows) if job.ways.command == "solve" else [],
        currency=currencies.pop() if len(currencies) == 1 else "",
        failed=[FailedMissions(message, count) for message, count in failed.most_common(MOST_FAILURES)],
        kept=kept,
        passed_over=len(store.keys) - len({row["key"] for row in rows} & store.keys),
        warnings=notes_of(job, store),
        folder=str(store.folder),
    )


def job_rows(job: SweepJob, store: SweepStore) -> list[Mapping[str, Any]]:
    """What is told of each mission of a job that is worked out, in few columns."""
    wanted = ["key", "status", "message", *KIT, "generic", "cost", "currency"]
    stored = store.table()
    rows = stored.select([name for name in wanted if name in stored.column_names]).to_pylist()
    by_key = {row["key"]: row for row in rows}
    return [by_key[task.key] for task in job.tasks() if task.key in by_key]


def kits_of(rows: Sequence[Mapping[str, Any]]) -> list[SweepKit]:
    """The hardware that is best somewhere, the most often first."""
    won: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        if row.get("camera") is not None:
            won.setdefault(tuple(row.get(name) for name in KIT), []).append(row)
    made = []
    for names, own in won.items():
        one_currency = len({row["currency"] for row in own}) == 1
        made.append(
            SweepKit(
                **dict(zip(KIT, names, strict=True)), generic=bool(own[0]["generic"]), wins=len(own),
                price=max(row["cost"] for row in own) if one_currency else None,
            )
        )  # fmt: skip
    return sorted(made, key=lambda kit: (-kit.wins, kit.parts))


def notes_of(job: SweepJob, store: SweepStore) -> list[Note]:
    """What to know of the rows."""
    notes = []
    if store.damaged:
        text = (
            f"{len(store.damaged)} files of an earlier run could not be read; they are set aside as *.damaged"
        )
        notes.append(Note("damaged", "rows", f"{text}, and their missions were worked out again"))
    if len(job) > MOST_CSV:
        notes.append(
            Note("no_csv", "", f"more than {MOST_CSV} rows: sweep.parquet has them, and no CSV is written")
        )
    return notes


# ---------------------------------------------------------------- few kits for many missions


def solved_keys(job: SweepJob, store: SweepStore) -> dict[str, int | None]:
    """Keys of missions in which something fits, with the index of the kit that wins there."""
    rows = [row for row in job_rows(job, store) if row.get("camera") is not None]
    places = {tuple(getattr(kit, name) for name in KIT): index for index, kit in enumerate(kits_of(rows))}
    return {row["key"]: places.get(tuple(row.get(name) for name in KIT)) for row in rows}


def with_portfolio(made: SweepSummary, signs: Sequence[str], tried: int) -> SweepSummary:
    """A summary with what each of the first kits serves, and what few of them serve together."""
    served = np.array([[sign == YES for sign in one] for one in signs], bool).reshape(len(signs), tried)
    kits = [replace(kit, serves=int(served[:, index].sum())) for index, kit in enumerate(made.kits[:tried])]
    known = made.currency != "" and all(kit.price is not None for kit in made.kits)
    prices = [kit.price or 0.0 for kit in kits] if known else [0.0] * tried
    best = [
        SweepPortfolio(chosen, reached, sum(prices[index] for index in chosen) if known else None)
        for chosen, reached in portfolios(served, prices)
    ]
    return replace(
        made,
        kits=[*kits, *made.kits[tried:]],
        tried=tried,
        servable=int(served.any(axis=1).sum()),
        portfolio=best,
        one_each_price=sum(kit.price or 0.0 for kit in made.kits) if known else None,
    )

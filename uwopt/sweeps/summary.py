"""What the rows of a sweep amount to, and the files that say so."""

from __future__ import annotations

import itertools
import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from uwopt.report.write import PAGE_FILE, Writes, json_text, page_text, rows_csv, write_files
from uwopt.results.design import PRACTICE_YIELDS, Note
from uwopt.results.sweep import SWEEP_PARQUET, FailedMissions, SweepKit, SweepPortfolio, SweepSummary
from uwopt.results.version import __version__
from uwopt.sweeps.job import LABEL, SweepJob
from uwopt.sweeps.kits import YES
from uwopt.sweeps.portfolio import portfolios
from uwopt.sweeps.rows import FAILED, FIRST, LAST, OUTPUTS, POINTS, point_rows
from uwopt.sweeps.store import SweepStore, kind_of

if TYPE_CHECKING:
    import pyarrow as pa

SWEEP_FILE, SWEEP_TABLE = "sweep.json", "sweep.csv"
MOST_CSV = 200_000  # rows: beyond them the Parquet table alone
KIT = ("camera", "lens", "port", "housing", "complete", "light", "camera_count", "light_count")
MOST_FAILURES = 20  # reasons that are told


def write_sweep(made: SweepSummary, job: SweepJob, store: SweepStore, folder: Path) -> list[Path]:
    """Write the table as Parquet and CSV, the summary and the page."""
    files: dict[str, str | bytes | Writes] = {SWEEP_PARQUET: lambda file: write_table(file, job, store)}
    if len(job) <= MOST_CSV:
        rows = [row for piece in table_pieces(job, store) for row in piece.to_pylist()]
        files[SWEEP_TABLE] = rows_csv(rows, table_schema(job, store).names)
    files |= {SWEEP_FILE: json_text(made) + "\n", PAGE_FILE: page_text(made)}
    return write_files(folder, files)


def write_table(file: BinaryIO, job: SweepJob, store: SweepStore) -> None:
    """The table as Parquet, piece by piece."""
    import pyarrow.parquet as pq

    with pq.ParquetWriter(file, table_schema(job, store), compression="zstd") as writer:
        for piece in table_pieces(job, store):
            writer.write_table(piece)


def table_pieces(job: SweepJob, store: SweepStore) -> Iterator[pa.Table]:
    """The rows of a job's missions in the order of the job, with their inputs as columns, some thousand at a time."""
    import pyarrow as pa

    schema, inputs = table_schema(job, store), input_names(job, store)
    tasks, passed = job.tasks(), 0
    columns = [name for name in store.columns() if name != "inputs"]
    for found, rows in store.pieces((task.key for task in job.tasks()), columns):
        wanted, upto = set(found.tolist()), int(found[-1]) + 1
        mine = [task for n, task in enumerate(itertools.islice(tasks, upto - passed), passed) if n in wanted]
        passed = upto
        made = rows.append_column("n", pa.array(found, pa.int64()))
        for index, name in inputs.items():
            values = [task.values[index] for task in mine]
            made = made.append_column(name, input_array(values, schema.field(name).type))
        if job.ways.command == "pareto":
            made = pa.Table.from_pylist(point_rows(made.to_pylist()), schema=schema)
        known = set(made.column_names)
        yield pa.table(
            [made.column(one.name) if one.name in known else pa.nulls(len(made), one.type) for one in schema],
            schema=schema,
        )


def input_names(job: SweepJob, store: SweepStore) -> dict[int, str]:
    """Inputs by their place among the job's keys, as a person names them.

    With `input.` before where a column of results has that name.
    """
    known = {*store.columns(), *OUTPUTS}
    return {n: f"input.{key}" if key in known else key for n, key in enumerate(job.keys) if key != LABEL}


def table_schema(job: SweepJob, store: SweepStore) -> pa.Schema:
    """Columns of the table: the mission's number, its inputs, then what is known of it."""
    import pyarrow as pa

    known = set(store.columns()) - {"inputs"}
    if job.ways.command == "pareto":
        known = (known - {POINTS}) | point_columns(job, store)
    given = input_names(job, store)
    texts = set[int]()
    for values in job.points:
        texts |= {n for n in given if not (values[n] is None or isinstance(values[n], (int, float)))}
    inputs = [(name, pa.string() if n in texts else pa.float64()) for n, name in given.items()]
    names = [*(n for n in FIRST if n in known), *sorted(known - {*FIRST, *LAST}), *(n for n in LAST if n in known)]
    return pa.schema([("n", pa.int64()), *inputs, *((name, kind_of(name)) for name in names)])


def point_columns(job: SweepJob, store: SweepStore) -> set[str]:
    """Names of all that is known of points of trade-offs."""
    found: set[str] = set()
    for _, rows in store.pieces((task.key for task in job.tasks()), [POINTS]):
        for told in rows.column(POINTS).to_pylist() if POINTS in rows.column_names else ():
            found |= {name for point in json.loads(told or "[]") for name in point}
    return found


def input_array(values: Sequence[Any], kind: pa.DataType) -> Any:
    """A column of inputs, of numbers or of texts."""
    import pyarrow as pa

    if kind == pa.float64():
        return pa.array(values, kind)
    return pa.array([None if value is None else str(value) for value in values], kind)


# ---------------------------------------------------------------- summary


def summary_of(job: SweepJob, store: SweepStore, *, interrupted: bool, kept: int) -> SweepSummary:
    """What the rows of a job amount to."""
    rows = list(job_rows(job, store))
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
        gave_way=dict(gave_way_of(rows).most_common()),
        warnings=[*notes_of(job, store), *practice_notes(rows, held=job.ways.hold_practice)],
        folder=str(store.folder),
    )


def job_rows(job: SweepJob, store: SweepStore) -> Iterator[dict[str, Any]]:
    """What is told of each mission of a job that is worked out, in few columns."""
    wanted = ["key", "status", "message", *KIT, "generic", "cost", "currency", "gave_way", "practice_held"]
    for _, rows in store.pieces((task.key for task in job.tasks()), wanted):
        yield from rows.to_pylist()


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


def gave_way_of(rows: Sequence[Mapping[str, Any]]) -> Counter[str]:
    """In how many missions each key of good practice has given way."""
    return Counter(one for row in rows if row.get("gave_way") for one in str(row["gave_way"]).split(", "))


def practice_notes(rows: Sequence[Mapping[str, Any]], *, held: bool) -> list[Note]:
    """What of good practice has given way in how many missions, and what is held where less of it may do.

    held : whether all of it is, as was asked
    """
    notes = []
    if counts := gave_way_of(rows):
        text = (
            f"in {sum(bool(row.get('gave_way')) for row in rows)} of {len(rows)} missions nothing meets all of good "
            "practice, and what was relaxed is named (gave_way): "
            + "; ".join(f"{one} in {count}" for one, count in counts.most_common())
        )
        notes.append(Note(PRACTICE_YIELDS, "practice", text))
    told = [str(row["practice_held"]) for row in rows if row.get("practice_held")]
    if told:
        paths = ", ".join(dict.fromkeys(path for one in told for path in one.split(", ")))
        less = (
            "all of good practice is held, as was asked: without --hold-practice some of it is relaxed there"
            if held else "whether something does with less of it could not be known in time"
        )
        text = (
            f"in {len(told)} of {len(rows)} missions nothing fits with all of good practice, or not as often as is "
            f"asked ({paths}); {less}"
        )
        notes.append(Note("practice_held", "practice", text))
    return notes


# ---------------------------------------------------------------- few kits for many missions


@dataclass(frozen=True)
class SolvedMission:
    """A mission in which something fits."""

    kit: int | None  # index of the one that wins there
    gave_way: str  # of good practice


def solved_keys(job: SweepJob, store: SweepStore) -> dict[str, SolvedMission]:
    """Keys of missions in which something fits, with what wins there."""
    rows = [row for row in job_rows(job, store) if row.get("camera") is not None]
    places = {tuple(getattr(kit, name) for name in KIT): index for index, kit in enumerate(kits_of(rows))}
    won = [places.get(tuple(row.get(name) for name in KIT)) for row in rows]
    return {row["key"]: SolvedMission(one, row.get("gave_way") or "") for row, one in zip(rows, won, strict=True)}


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

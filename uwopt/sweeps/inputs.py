"""From what a person names to a job: missions with varied keys, folders of missions, or a table with a key a column."""

from __future__ import annotations

import csv
import io
import uuid
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from uwopt.documents.faults import show
from uwopt.documents.files import UnfitFileError, content
from uwopt.documents.reading import read_document
from uwopt.errors import MissionError
from uwopt.mission.checks import in_one_form
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.system import System, load_system
from uwopt.mission.varying import Asked, VariedMission, plain_value
from uwopt.objectives.axes import Axes
from uwopt.sweeps.files import Files, files_named, held_hash
from uwopt.sweeps.identity import program_identity
from uwopt.sweeps.job import LABEL, Cell, GridPoints, SweepBase, SweepJob, SweepWays

TABLES = (".csv", ".parquet")
MISSIONS = (".yaml", ".yml")
NO_MISSION = ".system"  # before the ending of a file that holds a system
IGNORED = "#"  # before the name of a column that is no key
MOST_FAULTS = 10
Named = str | Path | Mapping[str, Any] | Mission
Points = Sequence[tuple[Cell, ...]]


def job_of(
    named: Sequence[Named], vary: Asked | None = None, *, ways: SweepWays | None = None,
    system: str | Path | Mapping[str, Any] | System | None = None, with_files: bool = False,
) -> SweepJob:  # fmt: skip
    """The job that a person asks for; raises MissionError for what cannot be one.

    Parameters
    ----------
    named : mission files, folders of them, missions from Python; or a table (CSV, Parquet) and missions
    vary : values by key, as of `whatif`, in as many keys as wanted
    system : a system to evaluate in each mission instead of looking for the best
    with_files : also hold what the files that missions name hold, for workers that do not see them
    """
    ways = ways or SweepWays()
    if system is not None:
        ways = replace(ways, command="evaluate", system=load_system(system).to_dict(absolute_paths=True))
    if ways.pareto:
        ways = replace(ways, command="pareto", pareto=checked_objectives(ways, system))
    tables = [one for one in named if isinstance(one, (str, Path)) and Path(one).suffix.casefold() in TABLES]
    if len(tables) > 1:
        raise MissionError(f"sweep: {len(tables)} tables are named; a sweep takes one, so join them first")
    if tables and vary:
        raise MissionError(
            "sweep: a table and --vary are both given; put those values into the table as columns"
        )
    bases = [base for one in named if one not in tables for base in bases_of(one, ways)]
    sound = [VariedMission(b.data, ways.changes(), base_dir=folder_of(b)) for b in bases if not b.fault]
    if not bases:
        raise MissionError(
            "sweep: no mission is named; name mission files, a folder of them, or a table and a mission"
        )
    keys: tuple[str, ...] = ()
    points: Points = [()]
    if tables:
        keys, points = table_points(Path(tables[0]), sound)
    elif vary:
        keys, points = tuple(key.strip() for key in vary), grid_points(sound, vary)
    of_words = {
        word: files for word in words_of(points) if (files := files_named(word, map(folder_of, bases)))
    }
    shipped: Files = {}
    if with_files:
        for files in (*(files_named(b.data, [folder_of(b)]) for b in bases), *of_words.values()):
            shipped |= files
        shipped |= files_named(ways.system, [None])
    return SweepJob(
        name=uuid.uuid4().hex, bases=tuple(bases), keys=keys, points=points, ways=ways, identity=program_identity(),
        value_hashes={word: held_hash(files) for word, files in of_words.items()}, files=shipped,
        system_hash=held_hash(files_named(ways.system, [None])),
    )  # fmt: skip


def checked_objectives(ways: SweepWays, system: Any) -> tuple[str, ...]:
    """The objectives of a trade-off; raises where something else is asked for beside it."""
    beside = {"a system": system, "objective": ways.objective, "confidence": ways.confidence}
    given = [name for name, value in beside.items() if value is not None]
    if given:
        raise MissionError(f"sweep: {given[0]} is given beside pareto; a trade-off has its own objectives and systems")
    return Axes.of(ways.pareto).names


def folder_of(base: SweepBase) -> Path | None:
    """Where the files that a base names are looked for."""
    return Path(base.base_dir) if base.base_dir else None


# ---------------------------------------------------------------- missions


def bases_of(named: Named, ways: SweepWays) -> Iterator[SweepBase]:
    """The missions that a name stands for; of a folder also those that are wrong, with what is."""
    if isinstance(named, (str, Path)) and Path(named).expanduser().is_dir():
        folder = Path(named).expanduser()
        files = sorted(path for path in folder.iterdir() if is_mission(path))
        if not files:
            raise MissionError(f"{named}: holds no mission file (*.yaml); name another folder, or missions")
        for path in files:
            try:
                yield base_of(path, ways)
            except MissionError as fault:
                yield SweepBase(path.name, {}, fault=str(fault))
    else:
        yield base_of(named, ways)


def is_mission(path: Path) -> bool:
    """Whether a file of a folder is taken for a mission: YAML, not hidden, no system file."""
    is_system = path.stem.casefold().endswith(NO_MISSION)
    return path.suffix.casefold() in MISSIONS and not path.name.startswith(".") and not is_system


def base_of(named: Named, ways: SweepWays) -> SweepBase:
    """One mission; raises MissionError where it is none."""
    mission = load_mission(named)
    if ways.changes():
        mission.with_changes(**ways.changes())
    folder = mission.base_dir
    stated = None
    if isinstance(named, Mission):
        data, stated = named.to_dict(), named.stated
    else:
        data = in_one_form(read_document(named, "mission").data)[0]
    where = "" if folder is None else str(folder)
    return SweepBase(mission.name, data, where, held_hash(files_named(data, [folder])), stated)


# ---------------------------------------------------------------- values


def grid_points(missions: Sequence[VariedMission], vary: Asked) -> GridPoints:
    """All combinations of the values of varied keys; every mission must know each key, once."""
    lines = []
    for key, values in vary.items():
        varied = [mission.varied(key, values) for mission in missions]
        lines.append(varied[0].values if varied else ())
    refuse_twice([[mission.named(key) for key in vary] for mission in missions])
    return GridPoints(tuple(lines))


def refuse_twice(named: Sequence[Sequence[Any]]) -> None:
    """Raise where two names mean one key."""
    for keys in named:
        places = [(key.section, key.name, key.scene) for key in keys]
        for number, place in enumerate(places):
            if place in places[:number]:
                first, second = keys[places.index(place)].key, keys[number].key
                raise MissionError(f"sweep: {first} and {second} are the same key; keep one of them")


def table_points(
    path: Path, missions: Sequence[VariedMission]
) -> tuple[tuple[str, ...], list[tuple[Cell, ...]]]:
    """Keys and values of a table, a column a key and a row a mission; an empty cell is as the mission has it."""
    heads, rows = table_cells(path)
    twice = sorted({head for head in heads if heads.count(head) > 1})
    faults = [f"{path}: column {show(head)} stands twice; keep one" for head in twice]
    wanted = [n for n, head in enumerate(heads) if head and not head.startswith(IGNORED)]
    named = []
    for mission in missions:
        keys = []
        for head in (heads[n] for n in wanted if heads[n] != LABEL):
            try:
                keys.append(mission.named(head))
            except MissionError as fault:
                faults += [
                    f"{path}: {text}; or begin the column's name with {IGNORED}" for text in fault.faults
                ]
        named.append(keys)
    if not wanted or not rows:
        faults.append(
            f"{path}: holds no {'rows' if wanted else 'columns'}; the first line names keys of the mission"
        )
    if faults:
        raise MissionError(list(dict.fromkeys(faults))[:MOST_FAULTS])
    refuse_twice(named)
    points = []
    for number, row in enumerate(rows, 2):
        try:
            points.append(tuple(cell_of(row[n] if n < len(row) else None) for n in wanted))
        except MissionError as fault:
            raise MissionError([f"{path} line {number}: {text}" for text in fault.faults]) from None
    return tuple(heads[n] for n in wanted), points


def cell_of(given: Any) -> Cell:
    """A cell as a mission would have it; None where it is empty."""
    is_blank = isinstance(given, str) and not given.strip()
    return (
        None if given is None or is_blank or given != given else plain_value(given)
    )  # NaN differs from itself


def table_cells(path: Path) -> tuple[list[str], list[Sequence[Any]]]:
    """Heads and rows of a table file."""
    try:
        raw = content(path)
    except UnfitFileError as fault:
        raise MissionError(f"{path}: {fault}.") from None
    except (OSError, ValueError) as fault:
        why = getattr(fault, "strerror", None) or str(fault)
        raise MissionError(f"{path}: cannot be read ({why}); check its name and rights.") from None
    return parquet_cells(path, raw) if path.suffix.casefold() == ".parquet" else csv_cells(path, raw)


def csv_cells(path: Path, raw: bytes) -> tuple[list[str], list[Sequence[Any]]]:
    """Those of a CSV file; lines that begin with # are comments."""
    try:
        text = raw.decode("utf-8-sig")
        lines = (line for line in io.StringIO(text, newline="") if not line.startswith(IGNORED))
        rows = [row for row in csv.reader(lines, strict=True) if any(cell.strip() for cell in row)]
    except UnicodeDecodeError as fault:
        raise MissionError(
            f"{path}: is not UTF-8 text (byte {fault.start}); save it with UTF-8 encoding."
        ) from None
    except csv.Error as fault:
        raise MissionError(f"{path}: is no table with commas ({fault}); save it as CSV.") from None
    return ([head.strip() for head in rows[0]] if rows else []), list(rows[1:])


def parquet_cells(path: Path, raw: bytes) -> tuple[list[str], list[Sequence[Any]]]:
    """Those of a Parquet file."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(pa.BufferReader(raw))
        columns = [column.to_pylist() for column in table.columns]
    except (pa.ArrowException, OSError, ValueError) as fault:
        what = str(fault).splitlines()[0][:200]
        raise MissionError(f"{path}: is no Parquet table that can be read ({what}); write it anew.") from None
    return [str(name).strip() for name in table.column_names], list(zip(*columns, strict=True))


def words_of(points: Points) -> set[str]:
    """All texts among the values."""
    values: Iterator[Any] = (
        (value for line in points.lines for value in line)
        if isinstance(points, GridPoints)
        else (value for point in points for value in point)
    )
    return {value for value in values if isinstance(value, str)}

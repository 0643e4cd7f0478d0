"""What a sweep is to do: missions, the keys that are set in them, and how each is solved.

A job is sent to every worker once; its tasks are numbered, and made only when they are sent, so that ten million of
them take no room. A task's key is a hash of all that its answer depends on: equal keys have equal answers.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from uwopt.mission.varying import Value
from uwopt.results.sweep import SweepKit
from uwopt.sweeps.identity import DECIDING

Cell = Value | None  # None: as the mission has it
Command = Literal["solve", "evaluate", "pareto"]
LABEL = "name"  # column of a table that names its missions
KEY_BYTES = 16


@dataclass(frozen=True)
class SweepBase:
    """One mission before its keys are set, as plain values."""

    name: str
    data: Mapping[str, Any]
    base_dir: str = ""  # where the files that it names are looked for
    files_hash: str = ""  # of what these hold
    stated: frozenset[str] | None = None  # what of it is its own words, not practice; None: all that stands there
    fault: str = ""  # why it is no mission


@dataclass(frozen=True)
class SweepWays:
    """How every mission is worked out."""

    command: Command = "solve"
    objective: Any = None  # those of the missions where nothing is said
    physics: str | None = None
    confidence: float | str | None = None
    system: Mapping[str, Any] | None = None  # that is evaluated, with absolute paths
    pareto: tuple[str, ...] = ()  # objectives of the trade-off
    hold_practice: bool = False  # all of it, where nothing fits too

    def changes(self) -> dict[str, Any]:
        """Top-level values that replace those of every mission."""
        named = {"objective": self.objective, "physics": self.physics, "confidence": self.confidence}
        return {key: value for key, value in named.items() if value is not None}


@dataclass(frozen=True)
class GridPoints(Sequence[tuple[Cell, ...]]):
    """All combinations of values of several keys, the last changing fastest; none is held in memory."""

    lines: tuple[tuple[Value, ...], ...]

    def __len__(self) -> int:
        return math.prod(len(line) for line in self.lines)

    def __iter__(self) -> Iterator[tuple[Cell, ...]]:
        return itertools.product(*self.lines)

    def __getitem__(self, place: Any) -> Any:
        if not 0 <= place < len(self):
            raise IndexError(place)
        values: list[Cell] = []
        for line in reversed(self.lines):
            place, index = divmod(place, len(line))
            values.append(line[index])
        return tuple(reversed(values))


@dataclass(frozen=True)
class SweepTask:
    """One mission to be worked out."""

    key: str
    base: int
    values: tuple[Cell, ...]
    input_hash: str
    gave_way: str = ""  # of good practice, where kits are tried: they are held to what the best is


@dataclass(frozen=True)
class SweepBatch:
    """Tasks that are sent together; `kits` are tried in each, where the missions themselves are known already."""

    tasks: tuple[SweepTask, ...]
    kits: tuple[SweepKit, ...] = ()


@dataclass(frozen=True)
class SweepJob:
    """All missions of a sweep and how they are worked out."""

    name: str  # of this run
    bases: tuple[SweepBase, ...]
    keys: tuple[str, ...]  # as a person names them
    points: Sequence[tuple[Cell, ...]]  # values of the keys, the same for each base
    ways: SweepWays
    identity: Mapping[str, str]  # of the program and its catalogue
    value_hashes: Mapping[str, str] = field(default_factory=dict)  # of values that name files
    system_hash: str = ""  # of the files that the system names
    files: Mapping[str, bytes] = field(default_factory=dict)  # that workers elsewhere need, by absolute path

    def __len__(self) -> int:
        return len(self.bases) * len(self.points)

    def tasks(self) -> Iterator[SweepTask]:
        """All tasks in their order: bases one after the other, each over all points."""
        identity = {name: self.identity[name] for name in DECIDING}
        traded = [*([self.ways.pareto] if self.ways.pareto else []), *(["held"] if self.ways.hold_practice else [])]
        ways = hash_of([self.ways.command, self.ways.system, self.system_hash, self.ways.changes(), *traded])
        for index, base in enumerate(self.bases):
            said = [] if base.stated is None else [sorted(base.stated)]
            head = hash_of([ways, base.data, base.files_hash, base.fault, *said])
            for values in self.points:
                told = {key: self._told(value) for key, value in zip(self.keys, values, strict=True)}
                given = hash_of([head, {key: value for key, value in told.items() if value is not None}])
                yield SweepTask(hash_of([given, identity]), index, tuple(values), given)

    def _told(self, value: Cell) -> Any:
        """A value as it goes into a hash: a file by what it holds."""
        held = self.value_hashes.get(value) if isinstance(value, str) else None
        return value if held is None else [value, held]

    @property
    def for_workers(self) -> SweepJob:
        """The same without its points, which come with the batches."""
        return replace(self, points=())


def hash_of(value: Any) -> str:
    """A short hash of plain values."""
    text = json.dumps(value, sort_keys=True, ensure_ascii=True, default=str)
    return hashlib.blake2b(text.encode("ascii"), digest_size=KEY_BYTES).hexdigest()

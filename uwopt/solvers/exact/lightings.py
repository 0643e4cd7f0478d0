"""Light optics at mounts: lights that share beam and spectrum share every signal per lumen."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import distinct
from uwopt.forward.lamps import Mount
from uwopt.forward.problem import Problem


@dataclass(frozen=True)
class Lighting:
    """One light optics at one mount."""

    optics: int
    mount_index: int
    mount: Mount


@dataclass(frozen=True)
class Under:
    """Which lighting each of n rows is under."""

    lightings: Sequence[Lighting]
    index: Array  # (n,) into these

    @staticmethod
    def one(lighting: Lighting, n: int) -> Under:
        """All rows under the same."""
        return Under([lighting], np.zeros(n, int))

    @staticmethod
    def at(problem: Problem, optics: Array, mount: Array) -> Under:
        """Rows of some light optics at some mounts, by their places, (n,) each."""
        return Under(lightings(problem), optics * len(problem.mounts) + mount)

    def take(self, rows: Array) -> Under:
        """These rows only."""
        return replace(self, index=self.index[rows])

    def of(self, row: int) -> Lighting:
        """The lighting of one row."""
        return self.lightings[int(self.index[row])]

    def each(self) -> Iterator[tuple[Lighting, Array]]:
        """Each lighting that some rows are under, with these rows."""
        for k in distinct(self.index)[0]:
            yield self.lightings[int(k)], np.flatnonzero(self.index == k)

    def with_number(self, count: Array) -> Iterator[tuple[Lighting, int, Array]]:
        """Each lighting with each number of its lamps, `count` (n,) of the rows, and the rows of both."""
        for lighting, mine in self.each():
            for number in distinct(count[mine])[0]:
                yield lighting, int(number), mine[count[mine] == number]

    def by_optics(self) -> Iterator[tuple[int, Array]]:
        """Each light optics, and the rows that it lights from whatever mount."""
        optics = np.array([one.optics for one in self.lightings])[self.index]
        for value in distinct(optics)[0]:
            yield int(value), np.flatnonzero(optics == value)


def lightings(problem: Problem) -> list[Lighting]:
    """All pairs of light optics and mount."""
    return [
        Lighting(optics, index, mount)
        for optics in range(len(problem.optics))
        for index, mount in enumerate(problem.mounts)
    ]

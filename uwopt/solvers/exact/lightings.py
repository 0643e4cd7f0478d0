"""Light optics at mounts: lights that share beam and spectrum share every signal per lumen."""

from __future__ import annotations

from dataclasses import dataclass

from uwopt.forward.lamps import Mount
from uwopt.forward.problem import Problem


@dataclass(frozen=True)
class Lighting:
    """One light optics at one mount."""

    optics: int
    mount_index: int
    mount: Mount


def lightings(problem: Problem) -> list[Lighting]:
    """All pairs of light optics and mount."""
    return [
        Lighting(optics, index, mount)
        for optics in range(len(problem.optics))
        for index, mount in enumerate(problem.mounts)
    ]

"""How finely a model takes its integrals, part by part: 1 is the default, 2 halves steps and doubles nodes.

The error of a figure is what changes when a part is taken more finely (`uwopt.evaluation.accuracy`). Where an integral
chooses its order by itself, fineness asks more of that choice.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace

LEAST_NODES = 2


@dataclass(frozen=True)
class Fineness:
    """Factors on the nodes of each kind of integral."""

    spectrum: float = 1.0  # wavelengths, and the tolerance of water's loss tables
    image: float = 1.0  # lamps' light over the image and over the footprint
    veil: float = 1.0  # backscatter along rays and over the image
    sun: float = 1.0  # daylight over image and azimuth
    sharpness: float = 1.0  # information over spatial frequencies
    places: float = 1.0  # grids on which the darkest place is looked for; below 1 also few places stand for the frame

    def __post_init__(self) -> None:
        if not all(0.0 < value < float("inf") for value in self.by_part().values()):
            raise ValueError(f"fineness must be finite and above 0: {self.by_part()}")

    @property
    def few_places(self) -> bool:
        """Whether the light over the frame is asked for roughly."""
        return self.places < 1.0

    @staticmethod
    def names() -> tuple[str, ...]:
        """All parts."""
        return tuple(f.name for f in fields(Fineness))

    def by_part(self) -> dict[str, float]:
        """Factors by name."""
        return {name: getattr(self, name) for name in Fineness.names()}

    def finer(self, parts: Iterable[str]) -> Fineness:
        """The same with these parts taken twice as finely."""
        return replace(self, **{name: getattr(self, name) * 2.0 for name in parts})


DEFAULT = Fineness()


def scaled(nodes: int, fineness: float) -> int:
    """n = max(2, round(nodes * fineness))."""
    return max(LEAST_NODES, round(nodes * fineness))

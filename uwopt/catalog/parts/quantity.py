"""Numbers with their doubt, and tabulated curves: what the fields of parts hold."""

from dataclasses import dataclass
from typing import Literal

Status = Literal["published", "measured", "derived", "estimated", "quoted", "user", "generic"]


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number with its doubt: low <= value <= high; equal when it is published."""

    value: float
    low: float
    high: float
    status: Status = "published"
    source: str = ""

    @property
    def estimated(self) -> bool:
        """True when no source states this number for this part."""
        return self.status == "estimated"


Known = Quantity | None  # None: unknown, and not estimated


def exact(value: float, status: Status = "published", source: str = "") -> Quantity:
    """A number without a range."""
    return Quantity(value, value, value, status, source)


@dataclass(frozen=True, slots=True)
class Curve:
    """A tabulated spectrum or profile: abscissa increasing, one value each."""

    x: tuple[float, ...]
    y: tuple[float, ...]

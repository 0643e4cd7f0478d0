"""Class estimates: what stands in for a number that no source states, with its range and basis.

Each is found by the key `kind-field-class` in class_estimates.csv. Depth ratings and mounts have no class: an
unknown one stays unknown.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache

from uwopt.catalog.records import Quantity
from uwopt.catalog.tables import built_in_rows


@dataclass(frozen=True, slots=True)
class ClassEstimate:
    """One row of the table of class estimates."""

    key: str
    central: float
    low: float
    high: float
    currency: str
    at_nm: float | None
    basis: str

    def quantity(self, factor: float = 1.0) -> Quantity:
        """The estimate times a factor > 0."""
        return Quantity(
            self.central * factor,
            self.low * factor,
            self.high * factor,
            "estimated",
            f"{self.key}: {self.basis}",
        )

    def divided_into(self, number: float) -> Quantity:
        """number / estimate: the ends change places."""
        return Quantity(
            number / self.central,
            number / self.high,
            number / self.low,
            "estimated",
            f"{self.key}: {self.basis}",
        )


@cache
def class_table() -> dict[str, ClassEstimate]:
    """All class estimates by key."""
    return {
        row["key"]: ClassEstimate(
            row["key"],
            float(row["central"]),
            float(row["low"]),
            float(row["high"]),
            row["currency"] or "USD",
            float(row["at_nm"]) if row["at_nm"] else None,
            row["basis"],
        )
        for row in built_in_rows("class_estimates.csv")
    }


def first_class(prefix: str, *classes: str) -> ClassEstimate | None:
    """The first of these classes that the table has for `kind-field`; None if it has none."""
    table = class_table()
    return next(
        (table[key] for key in (f"{prefix}-{slug(name)}" for name in classes if name) if key in table), None
    )


def required_class(prefix: str, *classes: str) -> ClassEstimate:
    """As `first_class`, where the table is known to have one."""
    found = first_class(prefix, *classes)
    if found is None:
        raise KeyError(f"class_estimates.csv has none of {prefix}-({', '.join(classes)})")
    return found


@cache
def slug(name: str) -> str:
    """A name as keys spell it: lower case, everything else than letters and digits a hyphen."""
    return re.sub(r"[^a-z0-9]+", "-", name.casefold()).strip("-")

"""Spacer rings between lens and camera: lengths that are sold, by the lens's mount, and what can be stacked of them."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from itertools import combinations

from uwopt.catalog.compatibility import canonical_mount
from uwopt.catalog.estimates import required_class
from uwopt.catalog.parts.quantity import Quantity
from uwopt.catalog.tables import built_in_rows

LONGEST_MM = 10.0  # of a stack: beyond, a lens made for infinity is the wrong lens


@cache
def rings_mm(mount: str) -> tuple[float, ...]:
    """Lengths of the rings that are sold for a mount, the shortest first."""
    return tuple(sorted(
        float(row["length_mm"]) for row in built_in_rows("spacers.csv") if row["mount"] == mount
    ))  # fmt: skip


@cache
def stacks_mm(mount: str) -> tuple[float, ...]:
    """Lengths that rings of a mount make, each ring taken once at most."""
    rings = rings_mm(mount)
    sums = {sum(some) for n in range(1, len(rings) + 1) for some in combinations(rings, n)}
    return tuple(sorted(length for length in sums if length <= LONGEST_MM))


def stacks_of_mounts_mm(mounts: Iterable[str]) -> tuple[float, ...]:
    """Lengths that can be put behind a lens of these mounts."""
    return tuple(sorted({mm for mount in mounts for mm in stacks_mm(canonical_mount(mount))}))


def rings_in_words(mounts: Iterable[str], length_mm: float) -> str:
    """Which rings make a stack, such as `0.5 + 0.25 mm`: as few as can be; the length alone where none do."""
    for mount in mounts:
        rings = sorted(rings_mm(canonical_mount(mount)), reverse=True)
        for n in range(1, len(rings) + 1):
            for some in combinations(rings, n):
                if abs(sum(some) - length_mm) < 1e-6:
                    return " + ".join(f"{ring:g}" for ring in some) + " mm"
    return f"{length_mm:g} mm"


def spacer_price() -> Quantity:
    """Price in USD of the rings behind one lens."""
    return required_class("spacer-price", "any").quantity()


def spacer_mass_g() -> Quantity:
    """Mass of the rings behind one lens."""
    return required_class("spacer-mass-g", "any").quantity()

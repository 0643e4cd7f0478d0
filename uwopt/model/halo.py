"""What scattering makes of a beam: a share of it, and a halo of what was turned, over the angle and the way.

Tables stand at knots even in u = sqrt(1 - cos theta), 0 to 1, dense where the axis is, and are linear between them;
along the way at knots even in its square root, for light is widened most at first. The front plane, 90 deg, is dark.
What several ways make of one beam may also stand side by side, of which places take theirs by number.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from uwopt.arrays import FloatArray

ROUNDING = 1e-12  # makes a computed maximum a bound


@dataclass(frozen=True, eq=False, slots=True)
class Widening:
    """Of a beam I comes share I + halo; itself the key of what is computed from it."""

    reach_m: float  # way of the last row; held beyond
    share: FloatArray  # (k,), one row for any way, or from no way at all to the reach
    halo_per_sr: FloatArray  # (k, n + 1), I/Phi
    part: Literal["both", "own", "halo"] = "both"  # what of it counts
    numbered: bool = False  # whether rows are of several beams, side by side, which `at` takes the numbers of

    @staticmethod
    def of(share: FloatArray, halo_per_sr: FloatArray, reach_m: float, *, bound: bool = False) -> Widening:
        """From rows of knots, what is below 0 cut; only a bound may have light in the front plane."""
        halo = np.maximum(halo_per_sr, 0.0)
        if not bound:
            halo[:, -1] = 0.0
        halo.setflags(write=False)
        return Widening(reach_m, share, halo)

    @staticmethod
    def of_several(several: Sequence[Widening]) -> Widening:
        """Several of one row each, by number."""
        share = np.concatenate([one.share for one in several])
        return Widening(0.0, share, np.concatenate([one.halo_per_sr for one in several]), numbered=True)

    def alone(self, part: Literal["own", "halo"]) -> Widening:
        """One of the two."""
        return dataclasses.replace(self, part=part)

    def at(self, cos_angle: FloatArray, way_m: Any) -> tuple[Any, Any]:
        """Share and halo [1/sr] at these angles after these ways, or of the beams of these numbers, (...) each."""
        table = self.halo_per_sr
        n, rows = table.shape[1] - 1, len(table)
        if rows > 1 and not self.numbered:
            step = np.sqrt(np.minimum(way_m / self.reach_m, 1.0)) * (rows - 1)
            row = np.minimum(step.astype(np.int32), rows - 2)
            step -= row
            if self.part == "own":
                return self._share_between(row, step), 0.0
        place = np.sqrt(np.clip(1.0 - cos_angle, 0.0, 1.0)) * n
        cell = np.minimum(place.astype(np.int32), n - 1)
        place -= cell
        if rows == 1:
            return self.share[0], _along(table[0], cell, place)
        if self.numbered:
            return self.share[way_m], _along(table.ravel(), way_m * (n + 1) + cell, place)
        share = 0.0 if self.part == "halo" else self._share_between(row, step)
        flat, first = table.ravel(), row * (n + 1) + cell
        nearer, farther = _along(flat, first, place), _along(flat, first + (n + 1), place)
        return share, nearer + step * (farther - nearer)

    def _share_between(self, row: Any, step: Any) -> Any:
        """Between a way and the next."""
        return self.share[row] + step * (self.share[row + 1] - self.share[row])

    @property
    def most_share(self) -> float:
        """Over all ways; 0 of the halo alone."""
        return 0.0 if self.part == "halo" else float(self.share.max())

    @property
    def most_per_sr(self) -> FloatArray:
        """The greatest of the halo over all ways, (n + 1,)."""
        return np.asarray(np.zeros_like(self.halo_per_sr[0]) if self.part == "own" else self.halo_per_sr.max(axis=0))

    def envelope(self, angle_rad: FloatArray) -> FloatArray:
        """The greatest of the halo at each angle or any larger one: linear between knots, it is greatest at one."""
        most = self.most_per_sr
        u = np.sqrt(2.0) * np.sin(0.5 * angle_rad)
        here = np.interp(u, np.linspace(0.0, 1.0, len(most)), most)
        beyond = np.append(np.maximum.accumulate(most[::-1])[::-1], 0.0)
        next_knot = np.minimum(np.floor(u * (len(most) - 1)).astype(int) + 1, len(most))
        return np.asarray(np.maximum.accumulate(np.maximum(here, beyond[next_knot])[::-1])[::-1] * (1 + ROUNDING))


def _along(table: FloatArray, at: Any, beyond: Any) -> Any:
    """Between a knot and the next."""
    low = table[at]
    return low + beyond * (table[at + 1] - low)


def flux(table: FloatArray) -> float:
    """Flux of a table over the front [1]: 2 pi * integral of I 2 u du; Simpson is exact for I linear in a cell."""
    u = np.linspace(0.0, 1.0, len(table))
    middle = (table[1:] + table[:-1]) / 2 * (u[1:] + u[:-1]) / 2
    terms = table[1:] * u[1:] + 4 * middle + table[:-1] * u[:-1]
    return float(4 * np.pi * np.sum(terms) / (6 * (len(table) - 1)))

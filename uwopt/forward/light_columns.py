"""Light in images as columns: of lamps for one lumen second, of the sun a second, in electrons."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns


@dataclass(frozen=True)
class ImageLight(Columns):
    """Electrons per lm s, (n, n_altitudes) image means; (n, n_altitudes, n_pixels) at pixels.

    A veil that is None is left out of the model, or absent.
    """

    signal_e: Array
    forward_e: Array | None = None
    backscatter_e: Array | None = None
    worst_e: Array | None = None  # at the pixels that the SNR is asked of: those that may decide
    worst_veil_e: Array | None = None
    most_veil_e: Array | None = None  # of bounds: no veil is more; the others are then no less than they say
    may_miss: int = 0  # so many of the pixels may be darker than the SNR allows
    colour_e: Array | None = None  # image-forming, of the channels asked for (n, n_altitudes, n_channels), red first
    red_veil_e: Array | None = None  # of the red channel
    background_e: Array | None = None  # (n, 1) where no target stands: all that the water sends back, image mean

    @property
    def veil_e(self) -> Array | None:
        """Electrons that form no image."""
        return added(self.forward_e, self.backscatter_e)

    def with_pixels(self, there: ImageLight) -> ImageLight:
        """These means with the pixels of another."""
        return replace(
            self, worst_e=there.worst_e, worst_veil_e=there.worst_veil_e, may_miss=there.may_miss
        )


@dataclass(frozen=True)
class SunLight(Columns):
    """Electrons per second of open shutter from the sun, at a working f-number of 1; shapes as `ImageLight`."""

    signal_e_s: Array
    forward_e_s: Array
    path_e_s: Array
    worst_e_s: Array | None = None
    worst_veil_e_s: Array | None = None
    colour_e_s: Array | None = None
    red_veil_e_s: Array | None = None

    @property
    def veil_e_s(self) -> Array:
        """What forms no image."""
        return np.asarray(self.forward_e_s + self.path_e_s)


def added(one: Array | None, other: Array | None) -> Array | None:
    """The sum of what is there."""
    if one is None or other is None:
        return other if one is None else one
    return np.asarray(one + other)


def share_of(part: Array, whole: Array) -> Array:
    """Part over whole, (...,); 0 where there is nothing."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(whole > 0.0, part / whole, 0.0)

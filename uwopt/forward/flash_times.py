"""Times of flashes as columns: what gives so much light, how long the shutter is open for it, how much it blurs.

Everything that collects light is told as light times time. Of a flash the light is that of its peak, the time that at
peak brightness which gives as much (`model.flash`); its shutter and its blur then follow a curve, of all other lamps
they are that time itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns
from uwopt.model import flash

WHOLE_FLASH = 1.0 - 1e-9  # of its light: the shutter stays open for all of it


@dataclass(frozen=True)
class FlashTimes(Columns):
    """How n flashes fade; of other lamps, and flashes that stay as bright as they begin, the decay is inf."""

    decay_s: Array
    whole_s: Array  # from the start until it counts as over

    @property
    def fade(self) -> bool:
        """Whether any of them fades."""
        return bool(np.isfinite(self.decay_s).any())

    @property
    def full_s(self) -> Array:
        """Time at peak brightness that gives the light of the whole flash."""
        return np.asarray(flash.light_time_s(self.whole_s, decay_s=self.decay_s))

    def light_s(self, open_s: Array) -> Array:
        """Time at peak brightness that gives the light of a shutter open so long."""
        if not self.fade:
            return open_s
        within = np.where(np.isfinite(self.decay_s), np.minimum(open_s, self.whole_s), open_s)
        return np.asarray(flash.light_time_s(within, decay_s=self.decay_s))

    def open_s(self, light_s: Array) -> Array:
        """Open shutter that collects so much; that of a whole flash where it takes all."""
        if not self.fade:
            return light_s
        opened = np.asarray(flash.open_time_s(light_s, decay_s=self.decay_s))
        whole = np.isfinite(self.decay_s) & (light_s >= self.full_s * WHOLE_FLASH)
        return np.where(whole, self.whole_s, opened)

    def blur_s(self, light_s: Array) -> Array:
        """Steady light that blurs as much as the flash by the time that it has given so much."""
        if not self.fade:
            return light_s
        return np.asarray(flash.fading_blur_time_s(self.open_s(light_s), decay_s=self.decay_s))

    def within_blur_s(self, blur_s: Array) -> Array:
        """The most light that blurs no more than this."""
        if not self.fade:
            return blur_s
        return self.light_s(np.asarray(flash.open_time_of_blur_s(blur_s, decay_s=self.decay_s)))

    def most_share(self, longest_s: Array) -> Array:
        """No more of a flash's light than this comes in a time that bounds its open shutter or its blur."""
        # Nothing blurs longer than it shines: what a shutter lets in that is open so long blurs no longer than that.
        return np.minimum(1.0, self.within_blur_s(longest_s) / self.full_s)

    def blur_elasticity(self, light_s: Array) -> Array:
        """d ln blur / d ln light; never below 1, and rising: ln blur is convex in ln light."""
        if not self.fade:
            return np.ones(len(light_s))
        return np.asarray(flash.blur_elasticity(self.open_s(light_s), decay_s=self.decay_s))

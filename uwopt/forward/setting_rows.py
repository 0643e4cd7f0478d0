"""What the settings of many designs depend on in one scene: the record that evaluation and solvers share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.part_columns import CONTINUOUS, PULSED

if TYPE_CHECKING:
    from uwopt.forward.sharpness import SharpRows

Array = NDArray[Any]
WHOLE_FLASH = 1.0 - 1e-9  # of its duration: the shutter stays open for all of it


@dataclass(frozen=True)
class SceneRows:
    """What the settings of n designs depend on in one scene. Arrays (n,) or (n, n_altitudes), SI.

    `signal_e`: image-forming electrons per lm s of nameplate light at N_w = 1, image mean, by altitude;
    `veil_e`: electrons of the same light that form no image. `worst_e` and `worst_veil_e`: both at the
    pixels that may be the worst, (n, n_altitudes, n_pixels), or None when the requirement holds for the mean.
    `sun_*`: electrons per second of open shutter at N_w = 1, None without sun.
    Times are those that collect light: exposure plus offset, or the pulse.
    """

    signal_e: Array
    worst_e: Array | None
    nominal: int
    read_noise_e: Array
    gain_dn_per_e: Array
    full_scale_dn: Array
    black_level_dn: Array
    max_gain: Array
    well_e: Array
    prnu_frac: Array
    dark_current_e_s: Array
    dark_time_s: Array  # exposure that dark current sees; at first the longest that the design may use
    min_exposure_s: Array
    exposure_offset_s: Array
    readout_s: Array
    flash_duration_s: Array
    time_min_s: Array
    time_max_s: Array
    rate_hz: Array
    kind: Array
    light_lm: Array  # all lamps at full level
    full_power_w: Array  # all lamps burning at full level
    pulse_energy_j: Array  # all flashes at full level, from the supply
    levels: Array  # (n, n_levels), NaN-padded
    dims_freely: Array
    min_level: Array
    max_level: Array  # by peak power
    working_factor: Array  # N_w / N
    n_low: Array
    n_high: Array
    min_snr: float
    mean_level: float | None
    highlight_ratio: float
    optimistic: bool = False  # a bound, for any veil: no veil counts, and no level is asked of the gain
    veil_e: Array | None = None
    worst_veil_e: Array | None = None
    most_veil_e: Array | None = None  # of bounds: the veil is no more than this
    sun_signal_e_s: Array | None = None
    sun_veil_e_s: Array | None = None
    worst_sun_signal_e_s: Array | None = None
    worst_sun_veil_e_s: Array | None = None
    min_contrast: float = 0.0
    min_mtf: float = 0.0  # at half the Nyquist frequency
    sharp: SharpRows | None = None  # only where MTF or information are asked for
    open_max_s: Array | None = None  # longest open shutter under the sun; None: as long as the lamps need
    spare_dark_s: Array | None = None  # of bounds: further exposure whose dark current may fill the wanted level

    @property
    def total_e(self) -> Array:
        """All electrons per lm s, image mean, by altitude."""
        return self.signal_e if self.veil_e is None else self.signal_e + self.veil_e

    def take(self, index: Array) -> SceneRows:
        """These rows only."""
        picked: dict[str, Any] = {
            f.name: getattr(self, f.name)[index]
            for f in fields(self)
            if isinstance(getattr(self, f.name), np.ndarray)
        }
        if self.sharp is not None:
            picked["sharp"] = self.sharp.take(index)
        return replace(self, **picked)

    @staticmethod
    def joined(parts: Sequence[SceneRows]) -> SceneRows:
        """All rows of some lists of one scene; lists with fewer pixels repeat their last."""
        columns: dict[str, Any] = {}
        for f in fields(SceneRows):
            ones = [getattr(part, f.name) for part in parts]
            if not isinstance(ones[0], np.ndarray):
                continue
            deepest = max(one.shape[-1] for one in ones) if ones[0].ndim > 1 else 0
            columns[f.name] = np.concatenate(
                [
                    one
                    if one.ndim == 1
                    else np.pad(one, [(0, 0)] * (one.ndim - 1) + [(0, deepest - one.shape[-1])], mode="edge")
                    for one in ones
                ]
            )
        if parts[0].sharp is not None:
            from uwopt.forward.sharpness import SharpRows

            ends = np.cumsum([0, *(len(part.time_min_s) for part in parts)])
            placed = [(np.arange(ends[k], ends[k + 1]), part.sharp) for k, part in enumerate(parts)]
            columns["sharp"] = SharpRows.joined(
                [(at, one) for at, one in placed if one is not None], int(ends[-1])
            )
        return replace(parts[0], **columns)

    @property
    def sunlit(self) -> bool:
        """Whether light counts that does not come from the lamps."""
        return self.sun_signal_e_s is not None

    def open_s(self, exposure_s: Array) -> Array:
        """Time that collects sunlight in an exposure."""
        return np.asarray(exposure_s + self.exposure_offset_s)

    def exposure_s(self, time_s: Array) -> Array:
        """Exposure to set so that light is collected for a time.

        Lamps that burn: time - t_0. A pulse needs all rows open while it lasts; a flash may be cut short.
        """
        around_pulse = np.maximum(self.min_exposure_s, time_s + self.readout_s)
        whole = (self.kind != CONTINUOUS) & (time_s >= self.flash_duration_s * WHOLE_FLASH)
        cut = time_s - self.exposure_offset_s
        return np.where((self.kind == PULSED) | whole, around_pulse, cut)

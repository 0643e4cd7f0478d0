"""Designs in one scene as the solvers of settings see them: light, limits and what is asked, a row a design."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.bars import Bars
from uwopt.forward.columns import Columns
from uwopt.forward.flash_times import WHOLE_FLASH, FlashTimes
from uwopt.forward.light_columns import share_of
from uwopt.forward.part_columns import FLASH, PULSED
from uwopt.forward.sharpness import SharpRows
from uwopt.model import sensor
from uwopt.model.image_mean import reached_by_most
from uwopt.model.light import duty_frac


@dataclass(frozen=True)
class SceneRows(Columns):
    """What the settings of n designs depend on in one scene. Arrays (n,) or (n, n_altitudes), SI.

    `signal_e`: image-forming electrons per lm s of nameplate light at N_w = 1, image mean, by altitude;
    `veil_e`: electrons of the same light that form no image. `worst_e` and `worst_veil_e`: both at the
    pixels that the SNR is asked of, (n, n_altitudes, n_pixels), or None when it is asked of the mean; `may_miss`
    of them may fall short. Bounds look at those of the farthest altitude alone, (n, 1, n_pixels).
    `sun_*`: electrons per second of open shutter at N_w = 1, None without sun.
    Times are those that collect light: exposure plus offset, or the pulse; of a flash that fades the time at its peak
    brightness that gives as much (`flash`).
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
    flash_duration_s: Array  # until it is over
    time_min_s: Array
    time_max_s: Array  # below 0: no setting does, as `NO_TIME_S` has it
    rate_hz: Array
    kind: Array
    light_lm: Array  # all lamps at full level
    full_power_w: Array  # all lamps burning at full level
    pulse_energy_j: Array  # all flashes at full level, from the supply
    charging_power_w: Array  # all flashes while they recharge, from the supply
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
    may_miss: int = 0
    most_veil_e: Array | None = None  # of bounds: the veil is no more than this
    sun_signal_e_s: Array | None = None
    sun_veil_e_s: Array | None = None
    worst_sun_signal_e_s: Array | None = None
    worst_sun_veil_e_s: Array | None = None
    colour_e: Array | None = None  # of lamps and sun, (n, n_altitudes, n_channels), red first; None: nothing is asked
    red_veil_e: Array | None = None
    sun_colour_e_s: Array | None = None
    sun_red_veil_e_s: Array | None = None
    min_snr_red: float = 0.0
    min_snr_mean: float = 0.0  # of the image's mean, where pixels may have less
    max_white_balance: float = np.inf
    min_contrast: float = 0.0
    min_mtf: float = 0.0  # at half the Nyquist frequency
    resolve_m: float = 0.0  # width of bars on the floor that must arrive
    sharp: SharpRows | None = None  # only where MTF or information are asked for
    open_max_s: Array | None = None  # longest open shutter under the sun; None: as long as the lamps need
    lead_s: Array | None = None  # that lamps burn beside the time that collects light; inf or None: all the time
    idle_w: Array | None = None  # drawn whatever the light: lamps that are off, cameras beside their least scene
    camera_w: Array | None = None  # of all cameras while on, where they are off between images; None: they stay on
    awake_s: Array | None = None  # that an image keeps them on beside its exposure
    min_gain: float = 1.0
    background_e: Array | None = None  # (n, 1), of open water behind the targets; there is no sun with it
    flash_decay_s: Array | None = None  # in which a flash fades to 1/e, inf or None: it does not
    spare_dark_s: Array | None = (
        None  # of bounds: further exposure whose dark current may fill the wanted level
    )

    @property
    def least_dn_per_e(self) -> Array:
        """Digital numbers per electron at the lowest gain."""
        return np.asarray(self.gain_dn_per_e * self.min_gain)

    @property
    def wanted_dn(self) -> Array | None:
        """Digital numbers above black that the wanted mean level asks for; None: no level is asked for."""
        return None if self.mean_level is None else self.above_black_dn(self.mean_level)

    @property
    def headroom_dn(self) -> Array:
        """Digital numbers above black that the brightest mean level may reach."""
        return self.above_black_dn(1.0 / self.highlight_ratio)

    def above_black_dn(self, level: float) -> Array:
        """Digital numbers above black at a mean level."""
        return np.asarray(
            sensor.above_black_dn(level, full_scale_dn=self.full_scale_dn, offset_dn=self.black_level_dn)
        )

    @property
    def total_e(self) -> Array:
        """All electrons per lm s, image mean, by altitude."""
        return self.signal_e if self.veil_e is None else self.signal_e + self.veil_e

    @property
    def bright_e(self) -> Array:
        """The same of all that must not saturate: behind the altitudes, open water where there is any."""
        every = self.total_e
        return every if self.background_e is None else np.concatenate([every, self.background_e], axis=1)

    @property
    def asks_sharpness(self) -> bool:
        """Whether a contrast of fine detail is asked for."""
        return self.min_mtf > 0.0 or self.resolve_m > 0.0

    @property
    def bars(self) -> list[Bars]:
        """The bars whose contrast is asked for, each with the least of it."""
        if self.sharp is None:
            return []
        return self.sharp.asked(min_mtf=self.min_mtf, resolve_m=self.resolve_m)

    @property
    def three(self) -> Array:
        """Where near, nominal and far altitude stand among all."""
        return np.array([0, self.nominal, self.signal_e.shape[1] - 1])

    def contrast_within(self) -> tuple[Array, Array]:
        """Least and greatest contrast of bars that lamps and sun leave in whatever mixture, (n, 3) by altitude.

        The lesser of the image's mean and of what all but `may_miss` pixels reach. A pixel's contrast lies between that
        of the lamps' light and of the sun's, and what most pixels reach grows with each: so both ends are bounds. Rows
        that are bounds themselves know some pixels at best, of other altitudes: there the mean stands, no less.
        """
        mean = self._shares(self.signal_e, self.total_e, self.sun_signal_e_s, self.sun_veil_e_s)
        if not self.veils_pixels:
            return mean
        assert self.worst_e is not None
        veil = 0.0 if self.worst_veil_e is None else self.worst_veil_e
        sun, sun_veil = self.worst_sun_signal_e_s, self.worst_sun_veil_e_s
        if sun is None and self.sun_signal_e_s is not None and self.sun_veil_e_s is not None:
            sun, sun_veil = self.sun_signal_e_s[:, :, None], self.sun_veil_e_s[:, :, None]
        pixels = self._shares(self.worst_e, self.worst_e + veil, sun, sun_veil)
        least, most = (np.minimum(m, reached_by_most(p, self.may_miss)) for m, p in zip(mean, pixels, strict=True))
        return least, most

    def most_contrast(self) -> Array:
        """Most contrast of bars that any mixture of light leaves, (n, 3) by altitude, by all that rows know of it.

        Of bounds those too that know the veil at some pixels, which are of the farthest altitude alone: what all but k
        of many pixels reach is no more than what all but k of some do.
        """
        most = self.contrast_within()[1]
        if not self.optimistic or self.worst_e is None or self.worst_veil_e is None or self.sunlit:
            return most
        there = share_of(self.worst_e, self.worst_e + self.worst_veil_e)
        most[:, -1] = np.minimum(most[:, -1], reached_by_most(there, self.may_miss)[:, -1])
        return most

    @property
    def veils_pixels(self) -> bool:
        """Whether the veil is known at each pixel that the SNR is asked of."""
        veiled = self.worst_veil_e is not None or self.worst_sun_veil_e_s is not None
        return self.worst_e is not None and veiled and not self.optimistic

    def _shares(
        self, signal_e: Array, total_e: Array, sun_signal_e_s: Array | None, sun_veil_e_s: Array | None
    ) -> tuple[Array, Array]:
        """The lesser and the greater of image-forming over all light of lamps and of the sun, at three altitudes."""
        lamps = share_of(signal_e[:, self.three], total_e[:, self.three])
        if sun_signal_e_s is None:
            return lamps, lamps
        shining = sun_signal_e_s[:, self.three]
        every = shining if sun_veil_e_s is None else shining + sun_veil_e_s[:, self.three]
        sun = np.where(every > 0, share_of(shining, every), lamps)
        return np.minimum(lamps, sun), np.maximum(lamps, sun)

    def sharp_enough(self, *, f_number: Array, blur_s: Array, slack: float = 1e-9) -> Array:
        """Whether the bars that are asked for arrive, (n,), with the least contrast that there can be."""
        enough = np.ones(len(f_number), bool)
        least = self.contrast_within()[0]
        settings = dict(f_number=f_number, working_f_number=f_number * self.working_factor, blur_s=blur_s)
        for bars in self.bars:
            assert self.sharp is not None
            left = self.sharp.transfer(bars, **settings) * (least if bars.veiled else 1.0)
            enough &= left.min(axis=1) >= bars.least * (1.0 - slack)
        return enough

    @property
    def sunlit(self) -> bool:
        """Whether light counts that does not come from the lamps."""
        return self.sun_signal_e_s is not None

    @property
    def leads_s(self) -> Array:
        """How long lamps are on beside the time that collects light: 0 of pulses, inf of what does not go off."""
        burning = np.full(len(self.kind), np.inf) if self.lead_s is None else self.lead_s
        return np.where(self.kind == PULSED, 0.0, burning)

    @property
    def timed(self) -> Array:
        """Whether a shorter time saves power: of pulsed LEDs, and lamps that are off between images."""
        return np.isfinite(self.leads_s)

    @property
    def switched(self) -> bool:
        """Whether some lamps that burn are off between images."""
        return self.lead_s is not None and bool(np.isfinite(self.lead_s).any())

    def on_share(self, time_s: Array) -> Array:
        """Share of the time that lights draw power when they collect light for a time."""
        timed, leads_s = self.timed, self.leads_s
        with np.errstate(invalid="ignore"):
            share = np.minimum(1.0, (np.where(timed, leads_s, 0.0) + time_s) * self.rate_hz)
        return np.where(timed, share, 1.0)

    @property
    def idle(self) -> Array | float:
        """What is drawn whatever the light."""
        return 0.0 if self.idle_w is None else self.idle_w

    @property
    def full_draw_w(self) -> Array:
        """Power of all lights at full level, (n,): while they burn, or of flashes at the frame rate."""
        return np.where(self.kind == FLASH, self.pulse_energy_j * self.rate_hz, self.full_power_w)

    def share_within(self, limit_w: Array) -> Array:
        """Share of their full draw that a mean power leaves the lights, (n,); inf where they draw nothing."""
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (limit_w - self.idle) / self.full_draw_w
        return np.where(np.isnan(share), np.inf, share)

    def exposing_w(self, exposure_s: Array) -> Array:
        """Mean power that cameras draw for an exposure beyond the shortest that they have, (n,)."""
        if self.camera_w is None or self.awake_s is None:
            return np.zeros(len(self.kind))

        def on_share(open_s: Array) -> Array:
            return duty_frac(self.awake_s + open_s, frame_rate_hz=self.rate_hz)

        longer_s = np.maximum(exposure_s, self.min_exposure_s)
        return np.asarray(self.camera_w * (on_share(longer_s) - on_share(self.min_exposure_s)))

    @property
    def flash(self) -> FlashTimes:
        """How the flashes among the lights fade."""
        decay_s = np.full(len(self.kind), np.inf) if self.flash_decay_s is None else self.flash_decay_s
        return FlashTimes(decay_s, self.flash_duration_s)

    def is_whole_flash(self, time_s: Array) -> Array:
        """Whether a flash gives all its light in these times."""
        return np.asarray((self.kind == FLASH) & (time_s >= self.flash.full_s * WHOLE_FLASH))

    def blur_s(self, time_s: Array) -> Array:
        """Steady light that blurs as much as the lamps by the time that so much is collected."""
        return self.flash.blur_s(time_s)

    def open_s(self, exposure_s: Array) -> Array:
        """Time that collects sunlight in an exposure."""
        return np.asarray(exposure_s + self.exposure_offset_s)

    def exposure_s(self, time_s: Array) -> Array:
        """Exposure to set so that light is collected for a time.

        Lamps that burn: time - t_0. A pulse needs all rows open while it lasts; a flash may be cut short.
        """
        lit_s = self.flash.open_s(time_s)
        around_pulse = np.maximum(self.min_exposure_s, lit_s + self.readout_s)
        cut = lit_s - self.exposure_offset_s
        return np.where((self.kind == PULSED) | self.is_whole_flash(time_s), around_pulse, cut)

    @property
    def lit_exposures_s(self) -> tuple[Array, Array]:
        """Shortest and longest exposure for the lamps' light."""
        shortest_s = np.maximum(self.exposure_s(self.time_min_s), 0.0)
        return shortest_s, np.maximum(self.exposure_s(np.maximum(self.time_max_s, self.time_min_s)), shortest_s)

    @property
    def longest_exposure_s(self) -> Array:
        """The longest exposure that some settings have."""
        longest_s = self.exposure_s(np.maximum(self.time_max_s, self.time_min_s))
        if self.open_max_s is None:
            return longest_s
        return np.maximum(longest_s, self.open_max_s - self.exposure_offset_s)

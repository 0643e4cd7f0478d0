"""Settings of one scene by dense grids: what the enumeration of small problems tries.

Written anew from the forward model's formulas (noise, level, depth of field, data-sheet limits), without
anything of `solvers`; the ends of every range come from bisection.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.evaluation.design_model import DesignModel
from uwopt.evaluation.figures_by_name import airy_um
from uwopt.forward.figures import SettingRows, depth_of_field_m, skew_px
from uwopt.forward.motion import blur_time_s, required_rate_hz
from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED
from uwopt.model import sensor

Array = NDArray[Any]

HALVINGS, HALVINGS_AT_ONCE = 42, 3  # of e^-40 to e^40, in which the ends of the light's range are looked for
#: Widest opening and stops below it -> the number engraved for it, where that is less than the true one (ISO 517).
MARKED = {(1.8, 1.0): 2.5, (2.0, 1.0): 2.8, (1.8, 2.0): 3.5, (4.0, 1.0): 5.6}


@dataclass(frozen=True)
class Noise:
    """What SNR depends on beside light; of images (..., 1), whose altitudes or pixels follow."""

    read_noise_e: float
    gain_dn_per_e: Array
    dark_e: Array
    prnu_frac: float

    def snr(self, signal_e: Array, veil_e: Array | float) -> Array:
        """By the forward model."""
        return np.asarray(sensor.snr(
            signal_e, veil_e=veil_e, read_noise_e=self.read_noise_e, gain_dn_per_e=self.gain_dn_per_e,
            dark_e=self.dark_e, prnu_frac=self.prnu_frac,
        ))  # fmt: skip

    def of_pixels(self, images: Array) -> Noise:
        """The same of some images, by altitude and pixel."""
        return replace(self, gain_dn_per_e=self.gain_dn_per_e[images][..., None], dark_e=self.dark_e[images][..., None])


@dataclass(frozen=True)
class Exposed:
    """Images (...) at some light: electrons by altitude (..., n), and what the gain makes of them."""

    signal_e: Array
    veil_e: Array
    brightest_e: Array  # (...), dark current included
    level: Array  # of it, of full scale
    gain: Array  # that is wanted, times the least
    noise: Noise


class SceneSearch:
    """One scene of one hardware: candidates of settings by f-number, with their power and SNR.

    Four numbers describe a setting: time t, level u, light X and f-number N, tied by X = light u t / N_w^2.
    Candidates pin three of them to grids that hold every end of what is allowed; the fourth follows.
    """

    def __init__(self, model: DesignModel, index: int, dioptre_per_m: float, power_limit_w: float):
        self.model, self.index, self.dioptre = model, index, dioptre_per_m
        self.scene, self.rows = model.problem.scenes[index], model.rows_at(index, dioptre_per_m)
        self.cam, self.light = model.cameras, model.lights
        needs, speed = self.scene.view.requirements, self.scene.view.vehicle.speed_m_s
        self.needs, self.kind = needs, int(self.light.kind[0])
        self.rate = float(required_rate_hz(needs, speed, self.rows.view.covered_along_m).max())
        self.factor = 1.0
        if not self.scene.paper:
            self.factor = 1.0 / (1.0 - float(self.rows.view.focal_length_m[0]) * dioptre_per_m)
        count = model.hardware.count
        flash = self.kind == FLASH
        whole_s = float(self.light.flash_duration_s[0])
        self.lumen = float(self.light.full_light[0]) * count / (self.given_s(whole_s) if flash else 1.0)
        self.full_w = (
            float(self.light.pulse_energy_j[0] * self.rate if flash else self.light.full_power_w[0]) * count
        )
        self.lead_s, self.standby_w = self._switching()
        self.power_limit_w = power_limit_w - self.standby_w
        self.time = self._time_range()
        self.levels = self._levels()
        self.f_range = self._f_range()

    # ------------------------------------------------------------ what hardware allows

    @property
    def most_gain(self) -> float:
        """Highest gain of the camera, and no more than the mission allows."""
        allowed_db = self.needs.max_gain_db
        return min(float(self.cam.max_gain[0]), np.inf if allowed_db is None else 10.0 ** (allowed_db / 20.0))

    def _switching(self) -> tuple[float, float]:
        """How long a lamp is on beside the time that collects light (inf: all the time), and what it draws when off."""
        off = self.scene.view.vehicle.lamps_between_images == "off" and self.light.switchable[0]
        if self.kind != CONTINUOUS or not off:
            return (0.0 if self.kind == PULSED else np.inf), 0.0
        lead_s = float(self.light.warm_up_s[0] + self.cam.readout_s[0])
        return lead_s, float(self.light.standby_w[0]) * self.model.hardware.count

    def power_w(self, level: Array, time_s: Array) -> Array:
        """Mean power of all lamps, those that are off between images by the time that they burn."""
        on = 1.0 if np.isinf(self.lead_s) else np.minimum(1.0, (self.lead_s + time_s) * self.rate)
        return np.asarray(self.full_w * level * on + self.standby_w + self.exposing_w(time_s))

    def exposing_w(self, time_s: Array) -> Array | float:
        """What cameras that are off between images draw for an exposure beyond the shortest."""
        vehicle, cam = self.scene.view.vehicle, self.cam
        if vehicle.camera_between_images == "on":
            return 0.0
        on, shortest = (
            np.minimum(1.0, (cam.awake_s[0] + open_s) * self.rate)
            for open_s in (self.exposure_s(time_s), cam.min_exposure_s[0])
        )
        return np.asarray(vehicle.camera_count * cam.power_w[0] * (on - shortest))

    def _time_range(self) -> tuple[float, float]:
        """Shortest and longest time that collects light, from the data sheets' limits; low > high: none."""
        cam, light = self.cam, self.light
        offset, readout, least = (
            float(a[0]) for a in (cam.exposure_offset_s, cam.readout_s, cam.min_exposure_s)
        )
        limits = self.model.problem.mission.limits
        most = min(
            float(cam.max_exposure_s[0]),
            limits.max_exposure_ms * 1e-3,
            1 / self.rate if self.rate else np.inf,
        )
        blur = float(blur_time_s(self.scene, self.model.shapes[self.index], self.rows.view)[0])
        if least > most or self.rate > cam.max_rate_hz[0] * (1 + 1e-9):
            return 1.0, 0.0
        if self.kind == CONTINUOUS:
            skew = float(skew_px(self.scene, self.rows).max())
            if self.needs.max_skew_px is not None and skew > self.needs.max_skew_px:
                return 1.0, 0.0
            return least + offset, min(most + offset, blur)
        if self.rate > light.max_rate_hz[0] * (1 + 1e-9):
            return 1.0, 0.0
        if self.kind == PULSED:
            duty = float(light.max_duty[0]) / self.rate if self.rate else np.inf
            return max(float(light.min_pulse_s[0]), 1e-9), min(
                float(light.max_pulse_s[0]), duty, most - readout, blur
            )
        flash = float(light.flash_duration_s[0])
        if readout > 0:
            fits = flash <= most - readout and self.smear_s(flash) <= blur
            return self.given_s(flash), self.given_s(flash) if fits else 0.0
        longest, short = min(most + offset, flash), 0.0
        if self.smear_s(longest) > blur:
            for _ in range(60):
                middle = 0.5 * (short + longest)
                short, longest = (middle, longest) if self.smear_s(middle) <= blur else (short, middle)
        return self.given_s(min(least + offset, flash)), self.given_s(longest)

    # A flash that fades: light is counted as time at its peak brightness, s = tau (1 - exp(-t / tau)).

    def given_s(self, open_s: Any) -> Any:
        """Time at the flash's peak that gives as much light as the first `open_s` of it."""
        tau = float(self.light.flash_decay_s[0])
        return open_s if np.isinf(tau) else tau * (1.0 - np.exp(-open_s / tau))

    def opened_s(self, given_s: Array) -> Array:
        """The reverse."""
        tau = float(self.light.flash_decay_s[0])
        return given_s if np.isinf(tau) else -tau * np.log(1.0 - given_s / tau)

    def smear_s(self, open_s: float) -> float:
        """Steady light of the same variance: 12 tau^2 (1 - x^2 e^-x / (1 - e^-x)^2) with x = t / tau, as its square."""
        tau = float(self.light.flash_decay_s[0])
        if np.isinf(tau) or open_s == 0.0:
            return open_s
        x = open_s / tau
        return float(tau * np.sqrt(12.0 * (1.0 - x**2 * np.exp(-x) / (1.0 - np.exp(-x)) ** 2)))

    def _levels(self) -> tuple[Array, bool]:
        """Levels that the lamp has within peak power (their ends if it dims freely), and whether it does.

        Cameras and extras draw all the time; what is left of the peak is for the lamps.
        """
        mission = self.model.problem.mission
        peak, always = mission.limits.peak_power_w, sum(item.power_w for item in mission.catalog.extras)
        always += mission.vehicle.camera_count * float(self.cam.power_w[0])
        top = 1.0
        recharging_w = self.recharging_w()
        if peak is not None and recharging_w is not None:  # however little of it is used
            return self._levels_up_to(1.0) if always + recharging_w <= peak else (np.empty(0), False)
        if peak is not None:
            top = min(1.0, (peak - always) / self.full_w) if self.full_w > 0 else float(peak >= always)
            if top < 0.0 or (top == 0.0 and peak < always):
                return np.empty(0), False
        return self._levels_up_to(top)

    def recharging_w(self) -> float | None:
        """What flashes draw while they fill up within their recycle time; None of other lamps, and of no such time."""
        most_hz = float(self.light.max_rate_hz[0])
        if self.kind != FLASH or np.isinf(most_hz):
            return None
        return float(self.light.pulse_energy_j[0]) * most_hz * self.model.hardware.count

    def _levels_up_to(self, top: float) -> tuple[Array, bool]:
        light = self.light
        if not light.dims_freely[0]:
            steps = light.levels[0][~np.isnan(light.levels[0])]
            return steps[steps <= top * (1 + 1e-12)], False
        least = float(light.min_level[0])
        return (np.array([least, top]) if least <= top else np.empty(0)), True

    def _f_range(self) -> tuple[float, float]:
        """Smallest f-number that keeps sharp what must be, by bisection of the forward model, and the largest.

        The depth of field that is asked for, or the nominal altitude.
        """
        low, high = float(self.model.lenses.f_number_min[0]), float(self.model.lenses.f_number_max[0])
        if low < high:
            low = MARKED.get((low, self.needs.lens_stop_down), low * 2.0 ** (self.needs.lens_stop_down / 2.0))
        high = min(high, self._airy_f_number())
        if low > high * (1 + 1e-12):
            return 1.0, 0.0
        depth = self.needs.min_dof_m
        first, last = float(self.scene.range_m[0]), float(self.scene.range_m[-1])
        if depth is None:
            depth, first = 0.0, float(self.scene.range_m[self.scene.nominal])
            last = first

        def sharp(f_number: float) -> bool:
            one = np.array([f_number])
            settings = SettingRows(one, one, one, one, one, one, np.array([self.dioptre]))
            near, far = (float(a[0]) for a in depth_of_field_m(self.scene, self.rows, settings))
            return (
                near <= first * (1 + 1e-10)
                and far >= last * (1 - 1e-10)
                and far - near >= depth * (1 - 1e-10)
            )

        if not sharp(high):
            return 1.0, 0.0
        if sharp(low):
            return low, high
        dull, clear = low, high
        for _ in range(50):
            middle = 0.5 * (dull + clear)
            dull, clear = (dull, middle) if sharp(middle) else (middle, clear)
        return clear, high

    def _airy_f_number(self) -> float:
        """The f-number at which the Airy disc, as a design's figures tell it, has the pixels that are allowed."""
        if self.needs.max_airy_px is None:
            return np.inf
        pitch_um = float(self.cam.pixel_pitch_m[0]) * 1e6
        return self.needs.max_airy_px * pitch_um / airy_um(self.model, self.index, self.factor)

    @property
    def possible(self) -> bool:
        """Whether any setting may exist."""
        return (
            self.time[0] <= self.time[1] * (1 + 1e-12)
            and len(self.levels[0]) > 0
            and self.f_range[0] <= self.f_range[1]
        )

    # ------------------------------------------------------------ what images need

    def exposure_s(self, time_s: Array) -> Array:
        """Exposure to set for a time that collects light."""
        cam, flash = self.cam, float(self.light.flash_duration_s[0])
        if self.kind == PULSED:
            return np.maximum(cam.min_exposure_s[0], time_s + cam.readout_s[0])
        if self.kind == CONTINUOUS:
            return time_s - cam.exposure_offset_s[0]
        around = max(float(cam.min_exposure_s[0]), flash + float(cam.readout_s[0]))
        whole = time_s >= self.given_s(flash) * (1 - 1e-9)
        return np.where(whole, around, self.opened_s(np.where(whole, 0.0, time_s)) - cam.exposure_offset_s[0])

    def exposed(self, light_x: Array, time_s: Array) -> Exposed:
        """Images of this light, gain at its best."""
        cam, needs = self.cam, self.needs
        dark = float(cam.dark_current_e_s[0]) * self.exposure_s(time_s)[..., None]
        seen = self.rows.light
        signal = seen.signal_e[0] * light_x[..., None]
        veil = np.zeros_like(signal) if seen.veil_e is None else seen.veil_e[0] * light_x[..., None]
        every = signal + veil
        brightest = every.max(axis=-1)
        if seen.background_e is not None:
            brightest = np.maximum(brightest, seen.background_e[0, 0] * light_x)
        full, black, gain = (
            2.0 ** float(cam.bits[0]) - 1.0,
            float(cam.black_level_dn[0]),
            float(cam.gain_dn_per_e[0]),
        )
        shown = brightest if needs.mean_level is None else every[..., self.scene.nominal]
        goal_dn = full / needs.highlight_ratio if needs.mean_level is None else needs.mean_level * full
        wanted = (goal_dn - black) / (gain * np.maximum(shown + dark[..., 0], 1e-300))
        system = gain * np.clip(wanted, 1.0, self.most_gain)[..., None]
        level = (system[..., 0] * (brightest + dark[..., 0]) + black) / full
        noise = Noise(cam.read_noise_e[0], system, dark, cam.prnu_frac[0])
        return Exposed(signal, veil, brightest + dark[..., 0], level, wanted, noise)

    def nominal_snr(self, light_x: Array, time_s: Array) -> Array:
        """SNR at the nominal altitude."""
        image = self.exposed(light_x, time_s)
        return image.noise.snr(image.signal_e, image.veil_e)[..., self.scene.nominal]

    def too_bright(self, light_x: Array, time_s: Array) -> Array:
        """Whether an image has more light than may be, however low the gain."""
        image, ratio = self.exposed(light_x, time_s), self.needs.highlight_ratio
        bright = (image.gain < 1.0) | (ratio * image.level > 1.0 + 1e-11)
        return bright | (ratio * image.brightest_e > self.cam.saturation_e[0])

    def too_dark(self, light_x: Array, time_s: Array) -> Array:
        """Whether an image has less light than is asked for, however high the gain."""
        image, needs, seen = self.exposed(light_x, time_s), self.needs, self.rows.light
        dim = np.zeros(light_x.shape, bool) if needs.mean_level is None else image.gain > self.most_gain
        if needs.min_snr_red is not None:
            assert seen.colour_e is not None and seen.red_veil_e is not None
            red, over = (c * light_x[..., None] for c in (seen.colour_e[0, :, 0], seen.red_veil_e[0]))
            dim = dim | (image.noise.snr(red, over).min(axis=-1) < needs.min_snr_red)
        if needs.min_snr is None:
            return dim
        least = image.noise.snr(image.signal_e, image.veil_e).min(axis=-1)
        if needs.snr_at == "mean" or seen.worst_e is None:
            return dim | (least < needs.min_snr)
        dim = dim | (least < needs.min_snr) & (needs.snr_at_less_db > 0.0)
        left = ~dim  # its pixels are many: those of images that are too dark by their means need not be asked
        light, there = light_x[left][:, None, None], image.noise.of_pixels(left)
        each = there.snr(seen.worst_e[0] * light, 0.0 if seen.worst_veil_e is None else seen.worst_veil_e[0] * light)
        each.partition(seen.may_miss, axis=-1)
        dim[left] = each[..., seen.may_miss].min(axis=-1) < needs.min_snr / 10.0 ** (needs.snr_at_less_db / 20.0)
        return dim

    def light_of(self, numbers: dict[str, float]) -> float:
        """Light X of a setting."""
        return self.lumen * numbers["level"] * numbers["time_s"] / (numbers["f_number"] * self.factor) ** 2

    def setting_rows(self, numbers: dict[str, float]) -> SettingRows:
        """A candidate as settings of the forward model, the gain by its own figures at unit gain."""
        time_s = np.array([numbers["time_s"]])
        pulse = {CONTINUOUS: np.inf, PULSED: time_s, FLASH: self.light.flash_duration_s}[self.kind]
        unit = SettingRows(
            np.array([numbers["f_number"]]), self.exposure_s(time_s), pulse * np.ones(1), np.ones(1),
            np.array([numbers["level"]]), np.array([self.rate]), np.array([self.dioptre]),
        )  # fmt: skip
        figures = self.model.figures(self.index, unit)
        level, behind = figures.mean_level, figures.background_level
        needs, black = self.needs, self.cam.black_level_dn[0] / (2.0 ** self.cam.bits[0] - 1.0)
        if needs.mean_level is None:
            brightest = level.max(axis=1) if behind is None else np.maximum(level.max(axis=1), behind)
            gain = (1.0 / needs.highlight_ratio - black) / np.maximum(brightest - black, 1e-300)
        else:
            gain = (needs.mean_level - black) / np.maximum(level[:, self.scene.nominal] - black, 1e-300)
        return replace(unit, gain=np.clip(gain, 1.0, self.most_gain))

    def light_range(self, time_s: Array) -> tuple[Array, Array]:
        """Least light that is not too dark and most that is not too bright, by bisection.

        Both at once, and HALVINGS_AT_ONCE of its steps: every middle that they may come to is asked in one image.
        """
        parts = 2**HALVINGS_AT_ONCE
        low, width, each = np.full((2, len(time_s)), -40.0), 80.0, np.arange(len(time_s))
        for _ in range(HALVINGS // HALVINGS_AT_ONCE):
            width /= parts
            inner = low + width * np.arange(1, parts).reshape(-1, *[1] * low.ndim)
            light_x, time = np.exp(inner), np.broadcast_to(time_s, inner[:, 0].shape)
            dim, bright = self.too_dark(light_x[:, 0], time), self.too_bright(light_x[:, 1], time)
            goes_on = np.stack([dim, ~bright], axis=1)  # up, from this middle
            step = np.zeros(low.shape, int)
            for half in (parts >> n for n in range(1, HALVINGS_AT_ONCE + 1)):
                step = step + half * goes_on[step + half - 1, [[0], [1]], each]
            low = low + width * step
        return np.exp(low[0] + width), np.exp(low[1])

    # ------------------------------------------------------------ candidates

    def prepare(self, n_light: int, around: float | None = None, reach: float = 0.0) -> Array:
        """Grids of time, level and light; returns f-numbers at which several ends meet.

        `around`: a light that proved good, to look closer at e^reach to each side of it.
        """
        low, high = self.time
        if around is None:
            self.times = np.unique(np.geomspace(low, high, 9)) if high > low else np.array([low])
            least, most = self.light_range(self.times)
            self.ends = np.minimum(least, np.where(least <= most * (1 + 1e-9), most, np.inf)), most
        least, most = self.ends
        near = (
            np.maximum(least, 1e-5 * most) if around is None else np.full(len(least), around * np.exp(-reach))
        )
        far = most if around is None else np.full(len(most), around * np.exp(reach))
        grid = near[:, None] * (far / near)[:, None] ** np.linspace(0.0, 1.0, n_light)
        grid = np.concatenate([grid, least[:, None], most[:, None]], axis=1)
        inside = (grid >= least[:, None] * (1 - 1e-13)) & (grid <= most[:, None] * (1 + 1e-13))
        self.lights = np.where(
            inside & (grid < 1e15), grid, np.nan
        )  # more than 1e15: no light reaches the image
        levels, free = self.levels
        if self.kind != PULSED and free and np.isfinite(self.power_limit_w) and self.full_w > 0:
            levels = np.unique(
                np.append(
                    levels, np.clip(self.power_limit_w / self._full_at(self.time[1]), levels[0], levels[-1])
                )
            )
        self.pinned = levels
        x = np.stack([least[[0, -1]], most[[0, -1]]], axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            f_number = (
                np.sqrt(self.lumen * levels[:, None, None] * self.times[[0, -1]][:, None] / x) / self.factor
            )
        return f_number[np.isfinite(f_number)]

    def _full_at(self, time_s: float) -> float:
        """Power at full level for a time of light."""
        return float(self.power_w(np.array(1.0), np.array(time_s))) - self.standby_w

    def candidates(self, f_number: Array) -> list[Array]:
        """The feasible candidates at these f-numbers: power, SNR, time, level and f-number, (n,) each."""
        square = ((f_number * self.factor) ** 2 / self.lumen)[:, None]  # level * time per light
        t, u, x = [], [], []

        def add(time_s: Array, level: Array, light_x: Array) -> None:
            for column, values in ((t, time_s), (u, level), (x, light_x)):
                column.append(
                    np.broadcast_to(values, np.broadcast_shapes(time_s.shape, level.shape, light_x.shape))
                )

        every = self.lights.ravel()
        if self.levels[1]:
            times = np.broadcast_to(self.times[:, None], self.lights.shape).ravel()
            add(times, every * square / times, every)
        many = np.concatenate(
            [np.broadcast_to(every, (len(f_number), len(every))), self._at_power_limit(square)], axis=1
        )
        for level in self.pinned[self.pinned > 0]:
            add(many * square / level, np.array(level), many)
            for end in self.ends:
                light_x = self._at_its_own_time(end, square / level)
                add(light_x * square / level, np.array(level), light_x)
            add(self.times, np.array(level), level * self.times / square)
            if self.kind == CONTINUOUS and 0 < self.full_w * self.rate < np.inf > max(self.power_limit_w, self.lead_s):
                longest = self.power_limit_w / (self.full_w * self.rate * level) - self.lead_s
                affordable = np.array([np.clip(longest, *self.time) if longest > 0 else self.time[0]])
                add(affordable, np.array(level), level * affordable / square)
        time_s, level, light_x = (np.concatenate(parts, axis=1).ravel() for parts in (t, u, x))
        f_number = np.repeat(f_number, len(time_s) // len(f_number))
        levels = self.levels[0]
        with np.errstate(invalid="ignore"):
            ok = (
                (time_s >= self.time[0] * (1 - 1e-11))
                & (time_s <= self.time[1] * (1 + 1e-11))
                & (light_x > 0)
            )
            ok &= (level >= levels.min() * (1 - 1e-11)) & (level <= levels.max() * (1 + 1e-11))
        time_s, level, light_x, f_number = time_s[ok], level[ok], light_x[ok], f_number[ok]
        power = self.power_w(level, time_s)
        good = ~self.too_bright(light_x * (1 - 1e-9), time_s)
        good &= power - self.standby_w <= self.power_limit_w * (1 + 1e-9)
        good[good] = ~self.too_dark(light_x[good] * (1 + 1e-9), time_s[good])
        snr = self.nominal_snr(light_x[good], time_s[good])
        return [power[good], snr, *(column[good] for column in (time_s, level, f_number))]

    def _at_its_own_time(self, end: Array, time_per_light: Array) -> Array:
        """An end of the light's range, which dark current shifts with the time that this light takes."""
        light_x = np.full(time_per_light.shape, end[0])
        for _ in range(6):
            light_x = np.interp(light_x * time_per_light, self.times, end)
        return light_x

    def _at_power_limit(self, square: Array) -> Array:
        """Light of pulsed lamps that use all the power there is."""
        if self.kind != PULSED or not np.isfinite(self.power_limit_w) or self.rate == 0:
            return np.empty((len(square), 0))
        return self.power_limit_w / (self.full_w * self.rate) / square

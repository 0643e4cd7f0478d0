"""One design in one scene as the continuous solvers see it, cut into pieces on which it is smooth.

A step of the light is a piece; so is each side of the kink of a pulsed LED's power, min(1, t f). Everything
here takes floats, complex arrays or CasADi symbols as settings.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.errors import SolverError
from uwopt.forward.flash_times import WHOLE_FLASH
from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.model import flash, light, sensor
from uwopt.objectives.objective import Objective, Terms
from uwopt.tolerances import SLACK
from uwopt.units import ratio_to_db

Symbolic = Any  # float, complex array, or CasADi scalar
Range = tuple[float, float]
NUMBERS = ("f_number", "time_s", "level", "gain")  # that are set

DIMMEST = 1e-9  # a lamp that dims to nothing has no logarithm there


@dataclass(frozen=True)
class SmoothSettings:
    """What a person sets in one scene; floats or symbols."""

    f_number: Symbolic
    time_s: Symbolic
    level: Symbolic
    gain: Symbolic
    exposure_s: Symbolic = 0.0  # what dark current is charged for; follows from the time


@dataclass(frozen=True)
class SmoothScene:
    """One design in one scene, as plain floats (CasADi takes no NumPy scalars); see `SceneRows`."""

    signal_e: tuple[float, ...]  # image mean, by altitude
    total_e: tuple[float, ...]  # veils included, and behind the altitudes open water where there is any
    wanted: tuple[tuple[float, float, float], ...]  # of pixels with an SNR to reach: signal, total, SNR
    nominal: int
    read_noise_e: float
    gain_dn_per_e: float
    full_scale_dn: float
    black_level_dn: float
    min_gain: float
    max_gain: float
    well_e: float
    prnu_frac: float
    dark_current_e_s: float
    min_exposure_s: float
    exposure_offset_s: float
    readout_s: float
    flash_full_s: float  # time at peak brightness that gives all its light
    flash_decay_s: float  # inf: it does not fade
    flash_duration_s: float
    time_min_s: float
    time_max_s: float
    rate_hz: float
    kind: int
    light_lm: float
    full_power_w: float
    pulse_energy_j: float
    dims_freely: bool
    levels: tuple[float, ...]  # steps within reach, of a lamp that does not dim freely
    min_level: float
    max_level: float
    working_factor: float
    n_low: float
    n_high: float
    mean_level: float | None
    highlight_ratio: float

    @staticmethod
    def of(rows: SceneRows) -> SmoothScene:
        """The only row of `rows`."""
        if len(rows.signal_e) != 1 or rows.optimistic:
            raise SolverError("continuous solvers take one design at a time, not a bound and not a table")

        def one(column: Array) -> float:
            return float(column[0])

        free = bool(rows.dims_freely[0])
        top = min(one(rows.max_level), 1.0) if free else one(rows.max_level) * (1.0 + SLACK)
        steps = tuple(float(v) for v in rows.levels[0] if np.isfinite(v) and 0.0 < v <= top)
        made: dict[str, Any] = dict(
            signal_e=tuple(float(v) for v in rows.signal_e[0]), total_e=tuple(float(v) for v in rows.bright_e[0]),
            wanted=(*wanted_pixels(rows), *wanted_of_mean(rows), *wanted_of_red(rows)),
            flash_full_s=one(rows.flash.full_s), flash_decay_s=one(rows.flash.decay_s), nominal=rows.nominal,
            kind=int(rows.kind[0]), dims_freely=free, levels=() if free else steps,
            min_level=max(one(rows.min_level), DIMMEST), max_level=top, mean_level=rows.mean_level,
            highlight_ratio=float(rows.highlight_ratio), min_gain=float(rows.min_gain),
        )  # fmt: skip
        made |= {f.name: one(getattr(rows, f.name)) for f in fields(SmoothScene) if f.name not in made}
        return SmoothScene(**made)

    @property
    def draws(self) -> bool:
        """Whether the light's power depends on its settings at all."""
        if self.kind == CONTINUOUS:
            return self.full_power_w > 0.0
        return (self.pulse_energy_j if self.kind == FLASH else self.full_power_w) * self.rate_hz > 0.0

    @property
    def wanted_dn(self) -> float | None:
        """Digital numbers above black that the wanted mean level asks for."""
        return None if self.mean_level is None else self._above_black_dn(self.mean_level)

    @property
    def headroom_dn(self) -> float:
        """Digital numbers above black that the brightest mean level may reach."""
        return self._above_black_dn(1.0 / self.highlight_ratio)

    def _above_black_dn(self, level: float) -> float:
        return float(sensor.above_black_dn(level, full_scale_dn=self.full_scale_dn, offset_dn=self.black_level_dn))

    def exposure_s(self, time_s: float) -> float:
        """Exposure that collects light for a time, as `SceneRows.exposure_s` has it."""
        whole = self.kind == FLASH and time_s >= self.flash_full_s * WHOLE_FLASH
        if self.kind == PULSED or whole:
            return max(self.min_exposure_s, (self.flash_duration_s if whole else time_s) + self.readout_s)
        return float(flash.open_time_s(time_s, decay_s=self.flash_decay_s)) - self.exposure_offset_s

    def dark_e(self, at: SmoothSettings) -> Symbolic:
        """Dark electrons of a pixel."""
        return self.dark_current_e_s * at.exposure_s

    def electrons(self, signal_e: float, at: SmoothSettings) -> Symbolic:
        """Electrons of a pixel with this signal per lm s at N_w = 1."""
        working = at.f_number * self.working_factor
        return signal_e * self.light_lm * at.level * at.time_s / working**2

    def snr(self, signal_e: float, at: SmoothSettings, *, total_e: float | None = None) -> Symbolic:
        """SNR of such a pixel; `total_e` counts its veils too."""
        return sensor.snr(
            self.electrons(signal_e, at),
            veil_e=0.0 if total_e is None else self.electrons(total_e - signal_e, at),
            read_noise_e=self.read_noise_e,
            gain_dn_per_e=self.gain_dn_per_e * at.gain,
            dark_e=self.dark_e(at),
            prnu_frac=self.prnu_frac,
        )

    def nominal_snr(self, at: SmoothSettings) -> Symbolic:
        """SNR of the image mean at the nominal altitude."""
        return self.snr(self.signal_e[self.nominal], at, total_e=self.total_e[self.nominal])

    def digital_dn(self, signal_e: float, at: SmoothSettings, *, offset_dn: float) -> Symbolic:
        """Mean digital number of such a pixel."""
        return sensor.digital_mean_dn(
            self.electrons(signal_e, at),
            gain_dn_per_e=self.gain_dn_per_e * at.gain,
            dark_e=self.dark_e(at),
            offset_dn=offset_dn,
        )

    def light_power_w(self, at: SmoothSettings) -> Symbolic:
        """Mean electrical power of the lights, kink included: floats only for a pulsed LED."""
        if self.kind == CONTINUOUS:
            return light.continuous_power_w(at.level, full_power_w=self.full_power_w, count=1)
        if self.kind == PULSED:
            return light.pulsed_led_power_w(
                at.level, full_power_w=self.full_power_w, count=1, pulse_s=at.time_s, frame_rate_hz=self.rate_hz
            )
        return light.flash_power_w(self.pulse_energy_j * at.level, count=1, frame_rate_hz=self.rate_hz)


def wanted_of_mean(rows: SceneRows) -> tuple[tuple[float, float, float], ...]:
    """Signal and total per lm s of the image's mean at every altitude, and its SNR where pixels may have less."""
    if rows.min_snr_mean <= 0.0:
        return ()
    pairs = zip(rows.signal_e[0], rows.total_e[0], strict=True)
    return tuple((float(signal), float(total), float(rows.min_snr_mean)) for signal, total in pairs)


def wanted_of_red(rows: SceneRows) -> tuple[tuple[float, float, float], ...]:
    """Signal and total per lm s of the red channel at every altitude, and the SNR that is asked of it."""
    if rows.colour_e is None or rows.min_snr_red <= 0.0:
        return ()
    signal = rows.colour_e[0, :, 0]
    veil = np.zeros_like(signal) if rows.red_veil_e is None else rows.red_veil_e[0]
    return tuple((float(s), float(s + v), float(rows.min_snr_red)) for s, v in zip(signal, veil, strict=True))


def wanted_pixels(rows: SceneRows) -> tuple[tuple[float, float, float], ...]:
    """Signal, total per lm s and SNR of the pixels and altitudes that min_snr is asked of; a worse one covers others.

    Of pixels that may miss it those are left out that need most light with the lowest noise: settings that serve
    the others serve enough, though where noise changes their order a little less light might do.
    """
    if rows.min_snr <= 0.0:
        return ()
    if rows.worst_e is None:
        signal, veil = rows.signal_e[0], None if rows.veil_e is None else rows.veil_e[0]
    else:
        signal = asked(rows, rows.worst_e)
        veil = None if rows.worst_veil_e is None else asked(rows, rows.worst_veil_e)
    pairs = sorted((float(s), float(v)) for s, v in zip(signal, np.zeros_like(signal) if veil is None else veil,
                                                        strict=True))  # fmt: skip
    kept: list[tuple[float, float]] = []
    for one, over in pairs:  # a pixel with more signal and less veil than another is never the worst
        if not kept or over > kept[-1][1]:
            kept.append((one, over))
    return tuple((one, one + over, float(rows.min_snr)) for one, over in kept)


def asked(rows: SceneRows, at_pixels: Array) -> Array:
    """A column of the pixels of the only design without those that may miss the SNR, of all altitudes in one row."""
    if rows.worst_e is None or rows.may_miss == 0:
        return np.asarray(at_pixels[0].ravel())
    one, veil = rows.worst_e[0], 0.0 if rows.worst_veil_e is None else rows.worst_veil_e[0]
    light = sensor.light_for_snr(
        rows.min_snr, signal_per_light_e=one, total_per_light_e=one + veil,
        read_noise_e=float(rows.read_noise_e[0]), prnu_frac=float(rows.prnu_frac[0]),
    )  # fmt: skip
    kept = np.argsort(light, axis=1, kind="stable")[:, : one.shape[1] - rows.may_miss]
    return np.take_along_axis(at_pixels[0], kept, axis=1).ravel()


@dataclass(frozen=True)
class Piece:
    """Settings of a scene on which the program is smooth: one step of the light, one side of a kink."""

    level_low: float
    level_high: float
    time_low_s: float
    time_high_s: float
    fills_frame: bool  # the pulse lasts at least as long as the frame: its length draws no more power
    exposure_follows: bool  # the exposure grows with the time; else it is the shortest there is
    exposure_shift_s: float  # exposure minus open time, or the exposure
    flash_decay_s: float  # of a flash that is cut short; inf: the open time is the time that collects light

    def ranges(self, scene: SmoothScene) -> dict[str, Range]:
        """Natural logarithms of each number that is set, least and most."""
        plain = {
            "f_number": (scene.n_low, max(scene.n_high, scene.n_low)),
            "time_s": (self.time_low_s, self.time_high_s),
            "level": (self.level_low, self.level_high),
            "gain": (scene.min_gain, max(scene.max_gain, scene.min_gain)),
        }
        return {name: (float(np.log(low)), float(np.log(high))) for name, (low, high) in plain.items()}

    def settings(self, logs: Mapping[str, Symbolic]) -> SmoothSettings:
        """Settings by the logarithms of their numbers."""
        value = {name: np.exp(logs[name]) for name in NUMBERS}
        return SmoothSettings(**value, exposure_s=self.exposure_s(value["time_s"]))

    def ends(self, ranges: Mapping[str, Range]) -> tuple[SmoothSettings, SmoothSettings]:
        """Dimmest and brightest settings within ranges of logarithms."""
        dim, bright = (
            self.settings({name: ranges[name][1 - end if name == "f_number" else end] for name in NUMBERS})
            for end in (0, 1)
        )
        return dim, bright

    def set_point(self, scene: SmoothScene, at: SmoothSettings) -> SmoothSettings:
        """Settings with the rounding of logarithms taken back at the ends of each range."""
        time_s = float(np.clip(at.time_s, self.time_low_s, self.time_high_s))
        return SmoothSettings(
            f_number=float(np.clip(at.f_number, scene.n_low, max(scene.n_high, scene.n_low))),
            time_s=time_s,
            level=float(np.clip(at.level, self.level_low, self.level_high)),
            gain=float(np.clip(at.gain, scene.min_gain, max(scene.max_gain, scene.min_gain))),
            exposure_s=scene.exposure_s(time_s),
        )

    def exposure_s(self, time_s: Symbolic) -> Symbolic:
        """Exposure that collects light for a time, without the scene's kinks."""
        if not self.exposure_follows:
            return self.exposure_shift_s
        return flash.open_time_s(time_s, decay_s=self.flash_decay_s) + self.exposure_shift_s

    def light_power_w(self, scene: SmoothScene, at: SmoothSettings) -> Symbolic:
        """The scene's light power without the kink of a pulsed LED.

        Below the kink power grows as level times time: the piece's longest pulse at the level that gives the
        same product stands for the pulse, so that min(1, t f) sees plain numbers.
        """
        if scene.kind != PULSED:
            return scene.light_power_w(at)
        share = 1.0 if self.fills_frame else at.time_s / self.time_high_s
        return scene.light_power_w(SmoothSettings(at.f_number, self.time_high_s, at.level * share, at.gain))

    def fixes_power(self, scene: SmoothScene) -> bool:
        """Whether nothing that is left open changes the power."""
        open_time = scene.kind == PULSED and not self.fills_frame and self.time_low_s < self.time_high_s
        return self.level_low == self.level_high and not open_time


def smooth_pieces(scene: SmoothScene) -> list[Piece]:
    """The smooth pieces of one scene that a quick look cannot rule out.

    Steps of the light are fixed one by one; time is cut where power or exposure bend.
    """
    longest = max(scene.time_max_s, scene.time_min_s)
    usable = scene.time_min_s <= scene.time_max_s * (1.0 + SLACK) and np.isfinite(longest)
    if not usable or not scene.light_lm > 0.0 or not scene.n_low <= scene.n_high * (1.0 + SLACK):
        return []
    levels = [(step, step) for step in scene.levels]
    if scene.dims_freely and scene.min_level <= scene.max_level:
        levels = [(scene.min_level, scene.max_level)]
    cuts = sorted(cut for cut in bends_s(scene) if scene.time_min_s < cut < longest)
    ends = [scene.time_min_s, *cuts, longest]
    found = [smooth_piece(scene, level, times) for level in levels for times in itertools.pairwise(ends)]
    return [piece for piece in found if not ruled_out(scene, piece)]


def bends_s(scene: SmoothScene) -> list[float]:
    """Times at which a scene's formulas have a kink.

    A pulsed LED's power bends where the pulse fills the frame, t f = 1 (upwards, so that it takes two
    pieces); with dark current also the exposure does, where a pulse outlasts the shortest exposure, and
    jumps by t_0 where a flash is no longer cut short.
    """
    bends = []
    if scene.kind == PULSED and scene.rate_hz > 0.0:
        bends.append(1.0 / scene.rate_hz)
    if scene.dark_current_e_s > 0.0 and scene.kind != CONTINUOUS:
        bends.append(scene.min_exposure_s - scene.readout_s)
        if scene.kind == FLASH:
            bends.append(scene.flash_full_s * WHOLE_FLASH)
    return bends


def smooth_piece(scene: SmoothScene, level: tuple[float, float], times_s: tuple[float, float]) -> Piece:
    """The piece between two bends; which side it lies on is seen at its middle."""
    middle = 0.5 * (times_s[0] + times_s[1])
    exposure = scene.exposure_s(middle)
    whole = scene.kind == FLASH and middle >= scene.flash_full_s * WHOLE_FLASH
    follows = not whole and not (scene.kind != CONTINUOUS and exposure == scene.min_exposure_s)
    decay_s = scene.flash_decay_s if scene.kind == FLASH else np.inf
    open_s = float(flash.open_time_s(middle, decay_s=decay_s)) if follows else 0.0
    return Piece(
        *level,
        *times_s,
        fills_frame=middle * scene.rate_hz >= 1.0,
        exposure_follows=follows,
        exposure_shift_s=exposure - open_s,
        flash_decay_s=decay_s,
    )


def ruled_out(scene: SmoothScene, piece: Piece) -> bool:
    """Whether even the brightest corner is too dark, or the dimmest too bright: a proof without a solver."""
    longest, shortest = piece.time_high_s, piece.time_low_s
    bright = SmoothSettings(scene.n_low, longest, piece.level_high, scene.max_gain, piece.exposure_s(longest))
    widest = max(scene.n_high, scene.n_low)
    dim = SmoothSettings(widest, shortest, piece.level_low, scene.min_gain, piece.exposure_s(shortest))
    nominal, brightest = scene.total_e[scene.nominal], max(scene.total_e)
    wanted, headroom = scene.wanted_dn, scene.headroom_dn
    if any(scene.snr(signal, bright, total_e=total) < snr * (1.0 - 1e-9) for signal, total, snr in scene.wanted):
        return True
    if headroom <= 0.0 or scene.digital_dn(brightest, dim, offset_dn=0.0) > headroom * (1.0 + 1e-9):
        return True
    filled = scene.highlight_ratio * (scene.electrons(brightest, dim) + scene.dark_e(dim))
    if filled > scene.well_e * (1.0 + 1e-9):
        return True
    if wanted is None:
        return False
    return wanted <= 0.0 or not (
        scene.digital_dn(nominal, dim, offset_dn=0.0) <= wanted * (1.0 + 1e-9)
        and scene.digital_dn(nominal, bright, offset_dn=0.0) >= wanted * (1.0 - 1e-9)
    )


def worst_light_w(scenes: Sequence[SmoothScene], settings: Sequence[SmoothSettings]) -> float:
    """Mean power of the lights in the scene that needs most."""
    return max(float(scene.light_power_w(at)) for scene, at in zip(scenes, settings, strict=True))


def worst_scene_snr(scenes: Sequence[SmoothScene], settings: Sequence[SmoothSettings]) -> float:
    """SNR in the scene that has least."""
    return min(float(scene.nominal_snr(at)) for scene, at in zip(scenes, settings, strict=True))


def common_range(scenes: Sequence[SmoothScene]) -> Range:
    """What all scenes allow of one f-number; empty where its ends do not meet."""
    return max(scene.n_low for scene in scenes), min(scene.n_high for scene in scenes)


@dataclass(frozen=True)
class SmoothDesign:
    """One hardware in all its scenes, with what its settings do not change."""

    scenes: tuple[SmoothScene, ...]
    motorised: bool
    camera_power_w: float
    cost: float
    mass_kg: float
    gsd_mm: float

    @staticmethod
    def of(rows: Sequence[SceneRows], **fixed: Any) -> SmoothDesign:
        """From one row a scene; `fixed` are the other fields."""
        return SmoothDesign(tuple(SmoothScene.of(row) for row in rows), **fixed)

    def drawn_together(self) -> SmoothDesign:
        """With what all scenes allow of an aperture that is common to them."""
        if self.motorised:
            return self
        low, high = common_range(self.scenes)
        return replace(self, scenes=tuple(replace(scene, n_low=low, n_high=high) for scene in self.scenes))

    def value(
        self, objective: Objective, settings: Sequence[SmoothSettings], scenes: Sequence[SmoothScene] | None = None
    ) -> float:
        """The minimised objective of settings by scene, of all or of these alone: the worst power and SNR count."""
        own = self.scenes if scenes is None else scenes
        snr_db = float(ratio_to_db(worst_scene_snr(own, settings)))
        return self._minimised(objective, worst_light_w(own, settings), snr_db)

    def fixed(self, objective: Objective) -> float:
        """What hardware adds to the objective whatever its settings."""
        return self._minimised(objective, 0.0, 0.0)

    def _minimised(self, objective: Objective, light_w: float, snr_db: float) -> float:
        numbers = (self.camera_power_w + light_w, self.cost, self.mass_kg, snr_db, self.gsd_mm)
        return float(objective.cost_to_minimise(Terms(*map(np.array, numbers))))

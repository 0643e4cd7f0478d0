"""One design in one scene as the continuous solvers see it, cut into pieces on which it is smooth.

A step of the light is a piece; so is each side of the kink of a pulsed LED's power, min(1, t f). Everything
here takes floats, complex arrays or CasADi symbols as settings.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.errors import SolverError
from uwopt.hardware import CONTINUOUS, FLASH, PULSED
from uwopt.model import light, sensor
from uwopt.rows import SceneRows

Array = NDArray[Any]
Symbolic = Any  # float, complex array, or CasADi scalar

SLACK = 1e-12  # relative, as in the closed form: a range of one point is not lost to rounding
DIMMEST = 1e-9  # a lamp that dims to nothing has no logarithm there
COPIED = (
    "read_noise_e", "gain_dn_per_e", "full_scale_dn", "black_level_dn", "max_gain", "well_e", "prnu_frac",
    "time_min_s", "time_max_s", "rate_hz", "light_lm", "full_power_w", "pulse_energy_j", "working_factor",
    "n_low", "n_high",
)  # fmt: skip


@dataclass(frozen=True)
class Settings:
    """What a person sets in one scene; floats or symbols."""

    f_number: Symbolic
    time_s: Symbolic
    level: Symbolic
    gain: Symbolic


@dataclass(frozen=True)
class Scene:
    """One design in one scene, as plain floats (CasADi takes no NumPy scalars); see `SceneRows`."""

    signal_e: tuple[float, ...]  # image mean, by altitude
    wanted_signal_e: tuple[float, ...]  # of the pixel that min_snr is asked of
    nominal: int
    read_noise_e: float
    gain_dn_per_e: float
    full_scale_dn: float
    black_level_dn: float
    max_gain: float
    well_e: float
    prnu_frac: float
    dark_e: float
    time_min_s: float
    time_max_s: float
    rate_hz: float
    kind: int
    light_lm: float
    full_power_w: float
    pulse_energy_j: float
    levels: tuple[float, ...]  # empty when the lamp dims freely
    min_level: float
    max_level: float
    working_factor: float
    n_low: float
    n_high: float
    min_snr: float
    mean_level: float | None
    highlight_ratio: float

    @staticmethod
    def of(rows: SceneRows) -> Scene:
        """The only row of `rows`."""
        if len(rows.signal_e) != 1 or rows.optimistic:
            raise SolverError("continuous solvers take one design at a time, not a bound and not a table")

        def one(column: Array) -> float:
            return float(column[0])

        signal = tuple(float(v) for v in rows.signal_e[0])
        free = bool(rows.dims_freely[0])
        top = min(one(rows.max_level), 1.0) if free else one(rows.max_level) * (1.0 + SLACK)
        steps = tuple(float(v) for v in rows.levels[0] if np.isfinite(v) and 0.0 < v <= top)
        return Scene(
            signal_e=signal,
            wanted_signal_e=signal if rows.worst_e is None else tuple(float(v) for v in rows.worst_e[0]),
            nominal=rows.nominal,
            dark_e=one(rows.dark_current_e_s) * one(rows.dark_time_s),
            kind=int(rows.kind[0]),
            levels=() if free else steps,
            min_level=max(one(rows.min_level), DIMMEST) if free else 0.0,
            max_level=top if free or steps else 0.0,
            min_snr=float(rows.min_snr),
            mean_level=rows.mean_level,
            highlight_ratio=float(rows.highlight_ratio),
            **{name: one(getattr(rows, name)) for name in COPIED},
        )

    @property
    def draws(self) -> bool:
        """Whether the light's power depends on its settings at all."""
        if self.kind == CONTINUOUS:
            return self.full_power_w > 0.0
        return (self.pulse_energy_j if self.kind == FLASH else self.full_power_w) * self.rate_hz > 0.0

    def electrons(self, signal_e: float, at: Settings) -> Symbolic:
        """Electrons of a pixel with this signal per lm s at N_w = 1."""
        working = at.f_number * self.working_factor
        return signal_e * self.light_lm * at.level * at.time_s / working**2

    def snr(self, signal_e: float, at: Settings) -> Symbolic:
        """SNR of such a pixel."""
        return sensor.snr(
            self.electrons(signal_e, at),
            read_noise_e=self.read_noise_e,
            gain_dn_per_e=self.gain_dn_per_e * at.gain,
            dark_e=self.dark_e,
            prnu_frac=self.prnu_frac,
        )

    def digital_dn(self, signal_e: float, at: Settings, *, offset_dn: float) -> Symbolic:
        """Mean digital number of such a pixel."""
        return sensor.digital_mean_dn(
            self.electrons(signal_e, at),
            gain_dn_per_e=self.gain_dn_per_e * at.gain,
            dark_e=self.dark_e,
            offset_dn=offset_dn,
        )

    def light_power_w(self, at: Settings) -> Symbolic:
        """Mean electrical power of the lights, kink included: floats only for a pulsed LED."""
        if self.kind == CONTINUOUS:
            return light.continuous_power_w(at.level, full_power_w=self.full_power_w, count=1)
        if self.kind == PULSED:
            return light.pulsed_led_power_w(
                at.level,
                full_power_w=self.full_power_w,
                count=1,
                pulse_s=at.time_s,
                frame_rate_hz=self.rate_hz,
            )
        return light.flash_power_w(
            self.pulse_energy_j * at.level, count=1, frame_rate_hz=self.rate_hz, charging_efficiency=1.0
        )


@dataclass(frozen=True)
class Piece:
    """Settings of a scene on which the program is smooth: one step of the light, one side of a kink."""

    level_low: float
    level_high: float
    time_low_s: float
    time_high_s: float
    fills_frame: bool  # the pulse lasts at least as long as the frame: its length draws no more power

    def light_power_w(self, scene: Scene, at: Settings) -> Symbolic:
        """The scene's light power without the kink of a pulsed LED.

        Below the kink power grows as level times time: the piece's longest pulse at the level that gives the
        same product stands for the pulse, so that min(1, t f) sees plain numbers.
        """
        if scene.kind != PULSED:
            return scene.light_power_w(at)
        share = 1.0 if self.fills_frame else at.time_s / self.time_high_s
        return scene.light_power_w(Settings(at.f_number, self.time_high_s, at.level * share, at.gain))

    def fixes_power(self, scene: Scene) -> bool:
        """Whether nothing that is left open changes the power."""
        open_time = scene.kind == PULSED and not self.fills_frame and self.time_low_s < self.time_high_s
        return self.level_low == self.level_high and not open_time


def pieces_of(scene: Scene) -> list[Piece]:
    """The smooth pieces of one scene that a quick look cannot rule out.

    Steps of the light are fixed one by one; a pulsed LED whose pulse may outlast the frame has a piece on
    each side of t f = 1 (where min(1, t f) bends: not convex, so it takes two).
    """
    longest = max(scene.time_max_s, scene.time_min_s)
    usable = scene.time_min_s <= scene.time_max_s * (1.0 + SLACK) and np.isfinite(longest)
    if not usable or not scene.light_lm > 0.0 or not scene.n_low <= scene.n_high * (1.0 + SLACK):
        return []
    levels = [(step, step) for step in scene.levels]
    if not scene.levels and scene.min_level <= scene.max_level:
        levels = [(scene.min_level, scene.max_level)]
    frame_s = 1.0 / scene.rate_hz if scene.rate_hz > 0.0 else np.inf
    if scene.kind != PULSED or longest <= frame_s:
        times = [(scene.time_min_s, longest, False)]
    elif scene.time_min_s >= frame_s:
        times = [(scene.time_min_s, longest, True)]
    else:
        times = [(scene.time_min_s, frame_s, False), (frame_s, longest, True)]
    all_pieces = [Piece(low, high, *time) for low, high in levels for time in times]
    return [piece for piece in all_pieces if not ruled_out(scene, piece)]


def ruled_out(scene: Scene, piece: Piece) -> bool:
    """Whether even the brightest corner is too dark, or the dimmest too bright: a proof without a solver."""
    bright = Settings(scene.n_low, piece.time_high_s, piece.level_high, scene.max_gain)
    dim = Settings(max(scene.n_high, scene.n_low), piece.time_low_s, piece.level_low, 1.0)
    nominal, brightest = scene.signal_e[scene.nominal], max(scene.signal_e)
    wanted, headroom = wanted_dn(scene), headroom_dn(scene)
    if scene.min_snr > 0.0 and scene.snr(min(scene.wanted_signal_e), bright) < scene.min_snr * (1.0 - 1e-9):
        return True
    if headroom <= 0.0 or scene.digital_dn(brightest, dim, offset_dn=0.0) > headroom * (1.0 + 1e-9):
        return True
    filled = scene.highlight_ratio * (scene.electrons(brightest, dim) + scene.dark_e)
    if filled > scene.well_e * (1.0 + 1e-9):
        return True
    if wanted is None:
        return False
    return wanted <= 0.0 or not (
        scene.digital_dn(nominal, dim, offset_dn=0.0) <= wanted * (1.0 + 1e-9)
        and scene.digital_dn(nominal, bright, offset_dn=0.0) >= wanted * (1.0 - 1e-9)
    )


def wanted_dn(scene: Scene) -> float | None:
    """Digital numbers above black that the wanted mean level asks for."""
    return None if scene.mean_level is None else scene.mean_level * scene.full_scale_dn - scene.black_level_dn


def headroom_dn(scene: Scene) -> float:
    """Digital numbers above black that the brightest mean level may reach."""
    return scene.full_scale_dn / scene.highlight_ratio - scene.black_level_dn

"""Requirements as margins: value, limit, and how much is left, worst over the altitudes.

A margin is in the requirement's own unit, positive when there is room. A design is feasible when
every margin is at least -1e-6 of its limit; of a limit in decibels also -1e-6 of the ratio is enough.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.figures import DesignRows, Figures, SettingRows
from uwopt.forward.motion import least_overlap
from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED, Cameras, Lenses, Lights
from uwopt.forward.scene import SceneOptics
from uwopt.forward.spacers import ring_range_m
from uwopt.forward.views import heights_m
from uwopt.mission.duration import Duration
from uwopt.mission.fixed import Fixed
from uwopt.mission.sections.limits import Limits
from uwopt.model.imaging import FARTHEST
from uwopt.tolerances import BINDING_REL, SATISFIED_REL
from uwopt.units import ratio_to_db

Sense = Literal["<=", ">=", "="]
TINY = 1e-12
NO_END = 1e3  # times as far as a frame's middle: a far edge at the horizon, or above it
OVERLAP_ROUNDING = 1e-12
LEVEL_TOLERANCE_REL = 0.012  # one step of gain: how well a mean level can be met with 0.1 dB
FOCUS_TOLERANCE_REL = 0.01  # no closer does a person set one focus by distances in two waters


@dataclass(frozen=True)
class MarginRows:
    """One requirement over n designs."""

    requirement: str
    value: Array
    limit: Array
    sense: Sense
    unit: str
    at_altitude_m: Array | None = None
    tolerance_rel: float = SATISFIED_REL
    tolerance_abs: float = 0.0  # rounding, where the limit may be 0
    reserve: float = 0.0  # how much of the limit is a reserve, beyond what is asked for

    @property
    def margin(self) -> Array:
        """What is left, in the requirement's unit."""
        with np.errstate(invalid="ignore"):
            if self.sense == "<=":
                return np.asarray(self.limit - self.value)
            if self.sense == ">=":
                return np.asarray(self.value - self.limit)
            return -np.abs(self.value - self.limit)

    @property
    def satisfied(self) -> Array:
        """Whether it holds, to rounding."""
        slack = self.tolerance_rel * np.where(np.isfinite(self.limit), self._size, 0.0) + self.tolerance_abs
        with np.errstate(invalid="ignore"):
            return np.asarray((self.margin >= -slack) & ~np.isnan(self.value))

    @property
    def is_clear(self) -> bool:
        """Whether no design misses it by anything, not even what rounding forgives."""
        with np.errstate(invalid="ignore"):
            return bool((self.margin >= 0.0).all())

    @property
    def shortfall(self) -> Array:
        """How far it is missed, as a share of its size; 0 where it holds."""
        with np.errstate(invalid="ignore"):
            missed = np.nan_to_num(-self.margin / np.maximum(self._size, TINY), nan=np.inf)
        return np.where(self.satisfied, 0.0, np.maximum(missed, TINY))

    @property
    def binding(self) -> Array:
        """Whether nothing is left."""
        return np.asarray(np.abs(self.margin) <= BINDING_REL * np.maximum(self._size, 1e-12))

    @property
    def _size(self) -> Array:
        """What relative tolerances are taken of: the limit; of decibels, which may be 0, at least one e-fold."""
        return np.maximum(np.abs(self.limit), ratio_to_db(np.e) if self.unit == "dB" else 0.0)


def scene_margins(
    scene: SceneOptics, rows: DesignRows, settings: SettingRows, figures: Figures, limits: Limits,
    *, level_tolerance_rel: float = SATISFIED_REL,
) -> Iterator[MarginRows]:  # fmt: skip
    """Every requirement of one scene, for n designs. `level_tolerance_rel`: how well a mean level must be met."""
    needs = scene.view.requirements
    yield from motion_margins(scene, rows, settings, figures)
    yield from depth_of_field_margins(scene, figures)
    yield from image_margins(scene, rows, figures)
    if needs.mean_level is not None:
        yield MarginRows(
            "mean_level", figures.mean_level[:, scene.nominal], at_all(figures, needs.mean_level), "=", "",
            np.full(len(figures.light_x), scene.altitude_m[scene.nominal]), level_tolerance_rel,
        )  # fmt: skip
    yield MarginRows("saturation_fraction", figures.saturation_fraction, at_all(figures, 1.0), "<=", "")
    if needs.lens_stop_down:
        yield stop_down_margin(needs.lens_stop_down, rows, settings, figures)
    if needs.max_gain_db is not None:
        gain_db = np.asarray(ratio_to_db(np.maximum(settings.gain, 1e-300)))
        yield MarginRows("max_gain_db", gain_db, at_all(figures, needs.max_gain_db), "<=", "dB")
    yield from setting_margins(rows, settings, figures, limits)


def stop_down_margin(
    stops: float, rows: DesignRows, settings: SettingRows, figures: Figures
) -> MarginRows:
    """How far the lens is closed from its widest opening, 2 log2(N / N_min); of a lens of one opening no matter.

    The mark that stands for so many stops counts as them, though it is engraved with a rounded number.
    """
    closed = stops + 2.0 * np.log2(settings.f_number / rows.lenses.f_number_from(stops))
    value = np.where(rows.lenses.one_opening, np.inf, closed)
    return MarginRows("lens_stop_down", value, at_all(figures, stops), ">=", "stops")


def at_all(figures: Figures, value: float) -> Array:
    """One limit for all designs."""
    return np.full(len(figures.light_x), value)


def worst(values: Array, altitudes: Array, *, highest: bool) -> tuple[Array, Array]:
    """The worst value over altitudes and where it is."""
    index = values.argmax(axis=1) if highest else values.argmin(axis=1)
    rows = np.arange(len(values))
    return values[rows, index], altitudes[index]


def motion_margins(
    scene: SceneOptics, rows: DesignRows, settings: SettingRows, figures: Figures
) -> Iterator[MarginRows]:
    """Blur, skew, overlap and frame rate."""
    needs, three = scene.view.requirements, heights_m(scene)
    if needs.max_blur_px is not None:
        value, where = worst(figures.blur_px, three, highest=True)
        kept = scene.view.kept("max_blur_px")
        limit = at_all(figures, needs.max_blur_px)
        yield MarginRows("max_blur_px", value, limit, "<=", "px", where, reserve=kept)
    if needs.max_skew_px is not None:
        value, where = worst(figures.skew_px, three, highest=True)
        yield MarginRows("max_skew_px", value, at_all(figures, needs.max_skew_px), "<=", "px", where)
    shared = least_overlap(needs)
    if shared is not None:
        value, where = worst(figures.overlap, three, highest=False)
        yield MarginRows(
            "overlap", value, at_all(figures, shared), ">=", "", where, tolerance_abs=OVERLAP_ROUNDING
        )
    if needs.frame_interval_s is not None:
        with np.errstate(divide="ignore"):
            interval = 1.0 / settings.rate_hz
        yield MarginRows("frame_interval_s", interval, at_all(figures, needs.frame_interval_s), "<=", "s")
    yield MarginRows("frame_rate", settings.rate_hz, rows.cameras.max_rate_hz, "<=", "Hz")


def depth_of_field_margins(scene: SceneOptics, figures: Figures) -> Iterator[MarginRows]:
    """Near end, far end and length of the depth of field; the nominal altitude within it where none is asked for."""
    depth = scene.view.requirements.min_dof_m
    first, last = (0, -1) if depth is not None else (scene.nominal, scene.nominal)
    yield MarginRows("dof_near_m", figures.dof_near_m, at_all(figures, scene.range_m[first]), "<=", "m")
    yield MarginRows("dof_far_m", figures.dof_far_m, at_all(figures, scene.range_m[last]), ">=", "m")
    if depth is None:
        return
    sharp = figures.dof_near_m < figures.dof_far_m  # else centre and corner are nowhere sharp together
    length = np.where(sharp, figures.dof_far_m - np.where(sharp, figures.dof_near_m, 0.0), 0.0)
    kept = scene.view.kept("min_dof_m")
    yield MarginRows("min_dof_m", length, at_all(figures, depth), ">=", "m", reserve=kept)


def common_margins(lenses: Lenses, settings: SettingRows, first: SettingRows) -> Iterator[MarginRows]:
    """What scenes share with the first where no motor turns the lens: none touches it behind a sealed port."""
    if lenses.motorised.all():
        return
    yield MarginRows("common_f_number", settings.f_number, first.f_number, "=", "")
    with np.errstate(divide="ignore"):
        focus_m, first_m = 1.0 / settings.dioptre_per_m, 1.0 / first.dioptre_per_m
    yield MarginRows("common_focus_m", focus_m, first_m, "=", "m", tolerance_rel=FOCUS_TOLERANCE_REL)


def image_margins(scene: SceneOptics, rows: DesignRows, figures: Figures) -> Iterator[MarginRows]:
    """Ground sample, swath and signal to noise; of an oblique view, that the plane ends within it."""
    needs, three = scene.view.requirements, heights_m(scene)
    if scene.slope:
        seen = np.minimum(rows.view.farthest, NO_END)
        yield MarginRows("horizon", seen, at_all(figures, FARTHEST), "<=", "")
    if needs.max_gsd_mm is not None:
        value, where = worst(rows.view.gsd_m * 1e3, three, highest=True)
        yield MarginRows("max_gsd_mm", value, at_all(figures, needs.max_gsd_mm), "<=", "mm", where)
    if needs.min_swath_m is not None:
        value, where = worst(rows.view.covered_across_m, three, highest=False)
        kept = scene.view.kept("min_swath_m")
        yield MarginRows("min_swath_m", value, at_all(figures, needs.min_swath_m), ">=", "m", where, reserve=kept)
    if needs.min_common_swath_m is not None:
        value, where = worst(rows.view.common_across_m, three, highest=False)
        kept, least = scene.view.kept("min_common_swath_m"), at_all(figures, needs.min_common_swath_m)
        yield MarginRows("min_common_swath_m", value, least, ">=", "m", where, reserve=kept)
    if needs.max_depth_error_mm is not None:
        value, where = worst(rows.view.depth_error_m * 1e3, three, highest=True)
        most = at_all(figures, needs.max_depth_error_mm)
        yield MarginRows("max_depth_error_mm", value, most, "<=", "mm", where)
    if needs.min_snr is not None:
        at_pixels = scene.at_worst and figures.snr_pixels is not None
        snr = figures.snr_pixels if at_pixels else figures.snr
        assert snr is not None
        value, where = worst(snr, scene.altitude_m, highest=False)
        limit_db = float(ratio_to_db(scene.least_snr))
        value_db = np.asarray(ratio_to_db(np.maximum(value, 1e-300)))
        kept = scene.view.kept("min_snr_db")
        yield MarginRows("min_snr_db", value_db, at_all(figures, limit_db), ">=", "dB", where, reserve=kept)
        if scene.least_mean_snr:
            value, where = worst(figures.snr, scene.altitude_m, highest=False)
            mean_db, limit = (ratio_to_db(np.maximum(snr, 1e-300)) for snr in (value, scene.least_mean_snr))
            least = at_all(figures, float(limit))
            yield MarginRows("min_snr_mean_db", np.asarray(mean_db), least, ">=", "dB", where, reserve=kept)
    if needs.min_snr_red_db is not None:
        red = np.zeros_like(figures.snr) if figures.snr_red is None else figures.snr_red
        value, where = worst(red, scene.altitude_m, highest=False)
        red_db = np.asarray(ratio_to_db(np.maximum(value, 1e-300)))
        kept, least = scene.view.kept("min_snr_red_db"), at_all(figures, needs.min_snr_red_db)
        yield MarginRows("min_snr_red_db", red_db, least, ">=", "dB", where, reserve=kept)
    if needs.max_white_balance is not None and figures.white_balance is not None:
        value, where = worst(figures.white_balance, scene.altitude_m, highest=True)
        yield MarginRows("max_white_balance", value, at_all(figures, needs.max_white_balance), "<=", "", where)
    if figures.mtf_half_nyquist is not None and needs.min_mtf_half_nyquist is not None:
        value, where = worst(figures.mtf_half_nyquist, three, highest=False)
        least = at_all(figures, needs.min_mtf_half_nyquist)
        yield MarginRows("min_mtf_half_nyquist", value, least, ">=", "", where)
    if figures.smallest_bars_m is not None and needs.resolve_mm is not None:
        value, where = worst(figures.smallest_bars_m * 1e3, three, highest=True)
        yield MarginRows("resolve_mm", value, at_all(figures, needs.resolve_mm), "<=", "mm", where)
    if needs.min_contrast is not None:
        value, where = worst(figures.contrast, scene.altitude_m, highest=False)
        yield MarginRows("min_contrast", value, at_all(figures, needs.min_contrast), ">=", "", where)


def setting_margins(
    rows: DesignRows, settings: SettingRows, figures: Figures, limits: Limits
) -> Iterator[MarginRows]:
    """What lens, camera and light can be set to."""
    cam, lights = rows.cameras, rows.lights
    yield MarginRows("f_number_min", settings.f_number, rows.lenses.f_number_min, ">=", "")
    yield MarginRows("f_number_max", settings.f_number, rows.lenses.f_number_max, "<=", "")
    with np.errstate(divide="ignore"):
        focus_m = 1.0 / settings.dioptre_per_m
    nearest_m, farthest_m = ring_range_m(rows.lenses, rows.spacer_m)
    yield MarginRows("nearest_focus_m", focus_m, nearest_m, ">=", "m")
    if np.any(np.asarray(rows.spacer_m) > 0.0):
        yield MarginRows("farthest_focus_m", focus_m, farthest_m, "<=", "m")
    yield MarginRows("gain_min", settings.gain, at_all(figures, 1.0), ">=", "")
    yield MarginRows("gain_max", settings.gain, cam.max_gain, "<=", "")
    longest_ms = np.minimum(cam.max_exposure_s * 1e3, limits.max_exposure_ms)
    with np.errstate(divide="ignore"):
        longest_ms = np.minimum(longest_ms, 1e3 / settings.rate_hz)
    yield MarginRows("max_exposure_ms", settings.exposure_s * 1e3, longest_ms, "<=", "ms")
    yield MarginRows("min_exposure_ms", settings.exposure_s * 1e3, cam.min_exposure_s * 1e3, ">=", "ms")
    yield MarginRows("light_level_max", settings.level, at_all(figures, 1.0), "<=", "")
    yield MarginRows("light_level", *nearest_level(rows, settings), "=", "")
    triggered = lights.kind != CONTINUOUS
    if triggered.any():
        yield from pulse_margins(rows, settings, triggered)


def fixed_margins(fixed: Fixed, settings: SettingRows) -> Iterator[MarginRows]:
    """Settings that the mission fixes."""
    for name, value, wanted, unit in (
        ("fixed_f_number", settings.f_number, fixed.f_number, ""),
        ("fixed_exposure_ms", settings.exposure_s * 1e3, fixed.exposure_ms, "ms"),
        ("fixed_gain", settings.gain, fixed.gain, ""),
        ("fixed_dim_frac", settings.level, fixed.dim_frac, ""),
    ):
        if wanted is not None:
            yield MarginRows(name, value, np.full(len(value), wanted), "=", unit)


def nearest_level(rows: DesignRows, settings: SettingRows) -> tuple[Array, Array]:
    """The level, and the nearest one that the lamp can be set to."""
    lights = rows.lights
    with np.errstate(invalid="ignore"):
        distance = np.abs(lights.levels - settings.level[:, None])
    distance = np.where(np.isnan(distance), np.inf, distance)
    stepped = np.take_along_axis(lights.levels, distance.argmin(axis=1)[:, None], axis=1)[:, 0]
    free = np.maximum(settings.level, lights.min_level)
    return settings.level, np.where(lights.dims_freely, free, stepped)


def pulse_margins(rows: DesignRows, settings: SettingRows, triggered: Array) -> Iterator[MarginRows]:
    """Pulse length, duty, recycle time, and a rolling shutter that must be open in all rows.

    Nothing but the shutter shortens a flash: its pulse is no setting.
    """
    cam, lights = rows.cameras, rows.lights
    inf = np.full(len(triggered), np.inf)
    led = lights.kind == PULSED
    pulsed = triggered & np.isfinite(settings.pulse_s)
    pulse_s = np.where(pulsed, settings.pulse_s, 0.0)  # of lamps that burn: inf, and inf - inf is no margin
    pulse_ms = pulse_s * 1e3
    yield MarginRows("max_pulse_ms", pulse_ms, np.where(led, lights.max_pulse_s * 1e3, inf), "<=", "ms")
    flash, open_s = lights.kind == FLASH, settings.exposure_s + cam.exposure_offset_s
    shortest_s = np.where(led, lights.min_pulse_s, np.minimum(lights.flash_duration_s, open_s))
    yield MarginRows(
        "min_pulse_ms",
        np.where(led | flash, pulse_ms, inf),
        np.where(led | flash, shortest_s * 1e3, 0.0),
        ">=",
        "ms",
    )
    duty = np.where(led, pulse_s * settings.rate_hz, 0.0)
    yield MarginRows("light_duty", duty, np.where(led, lights.max_duty, 1.0), "<=", "")
    yield MarginRows("light_rate", settings.rate_hz, np.where(triggered, lights.max_rate_hz, inf), "<=", "Hz")
    flash_s = np.where(lights.kind == FLASH, lights.flash_duration_s, pulse_s)
    rolling = triggered & (cam.readout_s > 0)
    needed_ms = np.where(rolling, (cam.readout_s + flash_s) * 1e3, 0.0)
    yield MarginRows("shutter_open_ms", settings.exposure_s * 1e3, needed_ms, ">=", "ms")


def system_margins(
    limits: Limits, *, cost_limit_value: Array, power_w: Array, peak_power_w: Array, mass_kg: Array,
    data_rate_mb_s: Array, depth_m: float, ratings_m: dict[str, float | None], accepted: frozenset[str],
    depth_reserve_m: float = 0.0,
) -> Iterator[MarginRows]:  # fmt: skip
    """Limits of the whole system: money, power, mass, data and depth, of which `depth_reserve_m` is kept in hand."""
    every = np.ones(len(power_w))
    for name, value, limit, unit in (
        ("cost", cost_limit_value, limits.cost, limits.currency),
        ("power_w", power_w, limits.power_w, "W"),
        ("peak_power_w", peak_power_w, limits.peak_power_w, "W"),
        ("mass_kg", mass_kg, limits.mass_kg, "kg"),
        ("data_rate_mb_s", data_rate_mb_s, limits.data_rate_mb_s, "MB/s"),
    ):
        if limit is not None:
            yield MarginRows(name, value, limit * every, "<=", unit)
    for part, rating in ratings_m.items():
        if rating is not None or part not in accepted:
            known = 0.0 if rating is None else rating
            deep = depth_m * every
            yield MarginRows(f"depth_rating_m ({part})", known * every, deep, ">=", "m", reserve=depth_reserve_m)


def rated_time_margins(hours: float | None, rated_h: Mapping[str, float]) -> Iterator[MarginRows]:
    """Whether the depth rating of each part that states how long it holds does so for a mission of so many hours."""
    for part, rated in rated_h.items() if hours is not None else ():
        yield MarginRows(f"rated_time_h ({part})", np.array([rated]), np.array([hours]), ">=", "h")


def trigger_margins(cameras: Cameras, lights: Lights) -> Iterator[MarginRows]:
    """Whether cameras fire their lamps, where some lamp pulses or flashes with a camera that may not."""
    fired = cameras.fires_lamps | (lights.kind == CONTINUOUS)
    if not fired.all():
        yield MarginRows("lamp_trigger", np.where(fired, 1.0, 0.0), np.ones(len(fired)), ">=", "")


def duration_margins(
    duration: Duration, *, mean_power_w: Array, mean_data_rate_mb_s: Array, cards_gb: float = np.inf,
    run_time_h: float = np.inf,
) -> Iterator[MarginRows]:  # fmt: skip
    """What the whole mission may use up, from means over its scenes: energy, storage, and the cameras' own cards.

    run_time_h : that the cameras' own batteries last
    """
    every = np.ones(len(mean_power_w))
    if np.isfinite(duration.energy_wh):
        energy_wh = duration.energy_of(mean_power_w)
        kept_wh = duration.energy_reserve_wh
        yield MarginRows("energy_wh", energy_wh, duration.energy_wh * every, "<=", "Wh", reserve=kept_wh)
    if np.isfinite(duration.storage_gb):
        storage_gb = duration.storage_of(mean_data_rate_mb_s)
        yield MarginRows("storage_gb", storage_gb, duration.storage_gb * every, "<=", "GB")
    if np.isfinite(cards_gb) and duration.duration_h is not None:
        yield MarginRows("card_gb", duration.storage_of(mean_data_rate_mb_s), cards_gb * every, "<=", "GB")
    if np.isfinite(run_time_h) and duration.duration_h is not None:
        yield MarginRows("run_time_h", run_time_h * every, duration.duration_h * every, ">=", "h")

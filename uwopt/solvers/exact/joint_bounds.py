"""Joint bounds of nodes: quality and its price at the same settings, for any light of a lighting.

As `solvers.settings.joint` has them of designs; here no field is integrated, and the lamps are the best of all.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.part_columns import FLASH
from uwopt.objectives.objective import Terms
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.lightings import LampsOfKind
from uwopt.solvers.exact.needs import Needs
from uwopt.solvers.settings.joint import (
    F_NUMBERS,
    LEVELS_DB,
    MOST_NUMBERS,
    electrons_in_levels,
    information_by_level,
    intervals,
    snr_in_levels,
)

if TYPE_CHECKING:
    from uwopt.solvers.exact.bounds import Bounds


def joint_bound_of_imagers(bounds: Bounds, k: int, rows: Array) -> Array:
    """Lower bound of the objective of imagers under one lighting, the worst scene's, (n,); inf: none is reached."""
    step, every = max(1, MOST_NUMBERS // (F_NUMBERS * len(LEVELS_DB))), range(len(bounds.problem.scenes))
    parts = [rows[start : start + step] for start in range(0, len(rows), step)]
    each = [np.max([_in_scene(bounds, k, some, index) for index in every], axis=0) for some in parts]
    return np.concatenate(each) if each else np.empty(0)


def _in_scene(bounds: Bounds, k: int, rows: Array, index: int) -> Array:
    """The bound by what one scene alone needs and shows: no other lowers the power or betters the image."""
    lighting = bounds.tables.lightings[k]
    focused = bounds.imagers.scenes[index].focused.take(rows)
    ends = intervals(focused.n_low, focused.n_high, bounds.objective)
    snr_db, information = _most_quality(bounds, k, rows, index, ends)
    need, square = bounds.needs.of(index, rows), np.square(ends[:, :-1] * focused.working_factor[:, None])
    value = np.full(len(rows), np.inf)
    for lamps in bounds.of_kinds[k]:
        light_time, _, _ = bounds.light_needed(index, lighting, need, lamps.kind, rows)
        least_x = light_time / need.square
        light_x = np.maximum(_least_light(bounds, k, rows, index), least_x[:, None])
        light_time = np.where(light_x > 0.0, light_x, 0.0)[:, None, :] * square[:, :, None]
        wanted = light_time if lamps.kind == FLASH else light_time / need.longest_s[:, None, None]
        power, cost, mass = _price(bounds.imagers, lamps, rows, need, light_time, wanted)
        gsd_mm = bounds.imagers.gsd_mm[rows][:, None, None]
        terms = Terms(power, cost, mass, snr_db[:, None, :], gsd_mm, 1.0, information)
        with np.errstate(invalid="ignore"):
            each = np.asarray(bounds.objective.cost_to_minimise(terms))
        each = np.where(np.isfinite(power) & np.isfinite(snr_db)[:, None, :], each, np.inf)
        value = np.minimum(value, each.reshape(len(rows), -1).min(axis=1))
    return value


def _most_quality(bounds: Bounds, k: int, rows: Array, index: int, ends: Array) -> tuple[Array, Array]:
    """SNR in dB (n, n_levels), -inf where no light reaches the interval, and information (n, n_intervals, n_levels)."""
    lighting = bounds.tables.lightings[k]
    snr_db = snr_in_levels(bounds.snr_ceiling(index, [lighting], rows))
    if not bounds.objective.weight("information"):
        return snr_db, np.zeros((len(rows), ends.shape[1] - 1, 1))
    sharp = bounds.imagers.sharpness(bounds.problem, index, rows, lighting.optics)
    return snr_db, information_by_level(sharp, bounds.imagers.scenes[index].focused.working_factor[rows], ends, snr_db)


def _least_light(bounds: Bounds, k: int, rows: Array, index: int) -> Array:
    """Least X = light * time / N_w^2 that the lower end of each interval of the SNR needs, (n, n_levels)."""
    if bounds.needs.is_sunlit(index):  # the sun may bring all of it
        return np.zeros((len(rows), len(LEVELS_DB)))
    cameras = bounds.problem.cameras.take(bounds.imagers.camera[rows])
    electrons = electrons_in_levels(cameras.read_noise_e, cameras.prnu_frac)
    signal = bounds.tables.bound(index, bounds.tables.lightings[k], bounds.problem.scenes[index].nominal, rows)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(electrons > 0.0, electrons / signal[:, None], 0.0)


def _price(
    imagers: Imagers, lamps: LampsOfKind, rows: Array, need: Needs, light_time: Array, wanted: Array
) -> tuple[Array, Array, Array]:
    """Power, cost and mass at least with so much light from lamps of one kind; inf where none has it."""
    at = lamps.from_capacity(wanted)
    rate_hz, longest_s = (of[:, None, None] for of in (need.rate_hz, need.longest_s))
    with np.errstate(invalid="ignore"):  # light that no lamp gives, at no rate: inf by what is wanted
        used = lamps.used(rate_hz, longest_s, light_time, wanted)
        drawn = np.where(used > 0.0, used * lamps.least["power_per_light"][at], 0.0)
    camera_w, cost, mass = (of[rows][:, None, None] for of in (imagers.camera_power_w, imagers.cost, imagers.mass_kg))
    power = np.where(at < len(lamps.capacity), camera_w + drawn, np.inf)
    return power, cost + lamps.least["cost"][at], mass + lamps.least["mass_kg"][at]

"""Lower bounds of an objective that weighs quality against its price: what both can be at the same settings.

Taken apart, the most of the quality and the least of the power are of different settings, and their sum is far below
what any design reaches. Here the f-number and the signal to noise are cut into intervals. In each the light is no
less than what the lower SNR needs at the wider opening; the image is no sharper than the lower f-number's diffraction
with the higher one's defocus and lens blur, at the higher SNR. The least over the intervals is a bound.
"""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.scene_rows import SceneRows
from uwopt.forward.sharpness import SharpRows
from uwopt.model import sensor, sharpness
from uwopt.model.information import TEXTURE_CONTRAST, information_of_gains
from uwopt.model.sharpness import Sharpness
from uwopt.objectives.objective import Objective
from uwopt.solvers.settings import dark, windows
from uwopt.tolerances import ROUND
from uwopt.units import db_to_ratio, ratio_to_db

F_NUMBERS = 12  # intervals between the widest and the smallest opening
LEVELS_DB = np.concatenate([np.arange(-9.0, 12.0, 3.0), np.arange(12.0, 46.0), [48.0, 52.0, 60.0, 90.0]])
FEW_LEVELS_DB = np.append(LEVELS_DB[:-1:3], LEVELS_DB[-1])
PITCHES_PX = np.array([0.0, 0.3, 0.5, 0.7, 0.85, 1.0, 1.2, 1.4, 1.7, 2.0, 2.5, 3.0, 4.0, 5.0, 6.5, 8.0, 11.0, 16.0])
CYCLES = np.concatenate([np.arange(0.0, 2.0, 0.08), np.arange(2.0, 5.0, 0.3)])  # N_w lambda / p
DISC_PITCH = np.pi / np.sqrt(32.0 * np.log(2.0))  # of a lens that is sharper than a disc: 2 J1(a)/a < e^(-a^2/8)
TABLE_ORDERS, TABLE_ERROR = (20, 10), 1e-3  # finer than the model's, for SNR beyond any image's
QUADRATURE = 1.01  # what the model has more than a rule that does not end where narrow transfers do, at most
SPREADS = 2.0 * np.pi * np.geomspace(10.0, 3000.0, 14)  # of lateral colour: k per cycle per px
ANGLES = 24
RADII = ((0.0, 0.5), (0.5, 0.5**0.5))  # cycles per px: circles inside the Nyquist square, and arcs of its corners
MOST_NUMBERS = 2_000_000  # held at once


@cache
def most_bit_per_px() -> Array:
    """Information by pitch of a Gaussian blur, by diffraction and by SNR: the model's, with room for its error."""
    pitch, cycles = (grid.ravel() for grid in np.meshgrid(PITCHES_PX, CYCLES, indexing="ij"))
    blurred = Sharpness(working_f_number=cycles, wavelength_nm=1e9, pixel_pitch_m=1.0, lens_pitch_px=pitch)
    gains = TEXTURE_CONTRAST * db_to_ratio(LEVELS_DB)
    bits = information_of_gains(gains, sharpness=blurred, orders=TABLE_ORDERS) * (1.0 + TABLE_ERROR)
    return bits.reshape(len(PITCHES_PX), len(CYCLES), len(LEVELS_DB))


@lru_cache(maxsize=512)
def most_bit_spread(magnitude: bytes, step: float) -> Array:
    """The same by lateral colour, pitch and SNR where diffraction counts for nothing, (n_spreads, n_pitches, n_levels).

    Colours are spread in one direction: on a circle of spatial frequencies the transfer depends on the angle from
    the line across it, whatever that direction is. Corners of the Nyquist square count as if they lay on that line.
    """
    table = np.frombuffer(magnitude)
    envelope = np.maximum.accumulate(table[::-1])[::-1]
    (inner, inner_weight), (outer, outer_weight) = (
        ((high + low + (high - low) * x) / 2.0, (high - low) / 2.0 * w)
        for (low, high), (x, w) in zip(RADII, map(np.polynomial.legendre.leggauss, (16, 6)), strict=True)
    )
    radius = np.concatenate([inner, outer])
    share = 1.0 - 4.0 / np.pi * np.arccos(np.minimum(0.5 / radius, 1.0))  # of the circle that lies in the square
    weight = np.concatenate([inner_weight, outer_weight]) * 2.0 * np.pi * radius * 0.5 / np.log(2.0)
    ends = np.square(np.linspace(0.0, 1.0, ANGLES + 1))
    angle_weight = np.clip(share[:, None] - ends[:-1], 0.0, np.diff(ends)) * weight[:, None]
    still = np.log(TEXTURE_CONTRAST * np.maximum(sharpness.sinc_mtf(radius), sharpness.sinc_mtf(radius / 2**0.5) ** 2))
    place = SPREADS[:, None, None] * radius[:, None] * np.sin(np.pi / 2.0 * ends[:-1]) / step
    seen = np.interp(place, np.arange(len(envelope)), envelope)  # held at the end, where it falls further
    blurred = still - np.log(2.0) * np.square(2.0 * radius * PITCHES_PX[:, None])
    squared = np.exp(2.0 * blurred)[None, :, :, None] * np.square(seen)[:, None]
    each = [
        (np.log1p(ratio**2 * squared) * angle_weight).sum(axis=(-2, -1)) for ratio in db_to_ratio(FEW_LEVELS_DB)
    ]
    found = np.stack(each, axis=-1) * QUADRATURE
    return np.stack([[np.interp(LEVELS_DB, FEW_LEVELS_DB, line) for line in block] for block in found])


def intervals(n_low: Array, n_high: Array, objective: Objective) -> Array:
    """Ends of the intervals of the f-number, (n, n_intervals + 1); one where sharpness does not count."""
    count = F_NUMBERS if objective.weight("information") else 1
    return np.geomspace(n_low, np.maximum(n_high, n_low), count + 1, axis=1)


def snr_in_levels(most_db: Array) -> Array:
    """The greatest SNR [dB] of each level where no more than some is reached, (n, n_levels); -inf: no light does."""
    below_db = np.concatenate([[-np.inf], LEVELS_DB[:-1]])
    return np.where(below_db < most_db[:, None], np.minimum(LEVELS_DB, most_db[:, None]), -np.inf)


def electrons_in_levels(read_noise_e: Array, prnu_frac: Array, veil_ratio: Array | float = 0.0) -> Array:
    """Fewest electrons that form the image at the lower end of each level, (n, n_levels)."""
    electrons = np.zeros((len(read_noise_e), len(LEVELS_DB)))
    electrons[:, 1:] = sensor.electrons_for_snr(
        db_to_ratio(LEVELS_DB[:-1]), noise_variance_e2=np.square(read_noise_e)[:, None], prnu_frac=prnu_frac[:, None],
        veil_ratio=np.broadcast_to(veil_ratio, read_noise_e.shape)[:, None],
    )  # fmt: skip
    return electrons


def information_by_level(sharp: SharpRows, working_factor: Array, ends: Array, snr_db: Array) -> Array:
    """Information [bit/m2] at most, (n, n_intervals, n_levels).

    The logarithm of a Gaussian transfer is linear in its squared pitch, and information is convex in both that and
    the SNR in dB: chords of the table lie above it. Diffraction takes the next sharper column.
    """
    closed = ends[:, 1:]
    lens = sharp.lens_pitch_px("rms", f_number=closed.T).T
    pitch2 = np.square(lens) + np.square(DISC_PITCH * sharp.rms_disc_px[:, 1, None] / closed)
    cycle = ends[:, :-1] * (working_factor * sharp.wavelength_nm * 1e-9 / sharp.pixel_pitch_m)[:, None]
    table, squares = most_bit_per_px(), np.square(PITCHES_PX)
    row = np.clip(np.searchsorted(squares, pitch2, side="right") - 1, 0, len(squares) - 2)
    column = np.clip(np.searchsorted(CYCLES, cycle, side="right") - 1, 0, len(CYCLES) - 1)
    share = np.clip((pitch2 - squares[row]) / (squares[row + 1] - squares[row]), 0.0, 1.0)[:, :, None]
    bits = (1.0 - share) * table[row, column] + share * table[row + 1, column]
    for mine, spread in sharp.groups("rms"):
        spread_k = np.searchsorted(SPREADS, np.hypot(*(k[mine] for k in sharp.colour("rms"))), side="right") - 1
        far = mine[spread_k >= 0]
        if spread is not None and len(far):
            of = most_bit_spread(np.ascontiguousarray(spread.magnitude).tobytes(), spread.step)
            place, at = spread_k[spread_k >= 0][:, None], row[far]
            spread_bits = (1.0 - share[far]) * of[place, at] + share[far] * of[place, at + 1]
            bits[far] = np.minimum(bits[far], spread_bits)
    low_db = np.concatenate([[LEVELS_DB[0] - 1.0], LEVELS_DB[:-1]])
    reached = np.clip((np.maximum(snr_db, -999.0) - low_db) / (LEVELS_DB - low_db), 0.0, 1.0)[:, None, :]
    reached[:, :, 0] = 1.0
    below = np.concatenate([bits[:, :, :1], bits[:, :, :-1]], axis=2)
    gain = sharp.texture_gain[:, None, None]  # log(1 + g^2 x) is at most g^2 log(1 + x), and at most that plus log g^2
    plain = below + reached * (bits - below)
    return np.asarray(np.minimum(plain * np.square(gain), plain + np.log2(gain)) / sharp.pixel_area_m2[:, None, None])


# ---------------------------------------------------------------- designs


def is_bounded(rows: list[SceneRows], objective: Objective) -> bool:
    """Whether `joint_bound_of_designs` knows more than bounds of quality and power: lamps alone give the light."""
    quality = objective.weight("information") or objective.weight("snr_db")
    return bool(quality) and not any(r.sunlit for r in rows)


def joint_bound_of_designs(
    rows: list[SceneRows], objective: Objective, light_limit_w: Array, constant: Array | float
) -> Array:
    """Lower bound of the minimised objective of n designs, the worst scene's; inf: none is reached.

    constant : (n,) what no setting changes, the camera's power too
    """
    n = len(rows[0].kind)
    fixed, limit = np.broadcast_to(constant, (n,)), np.broadcast_to(light_limit_w, (n,))
    step, out = max(1, MOST_NUMBERS // (F_NUMBERS * len(LEVELS_DB))), np.empty(n)
    for start in range(0, n, step):
        mine = np.arange(start, min(start + step, n))
        each = [_in_scene(r.take(mine), objective, limit[mine]) for r in rows]
        out[mine] = fixed[mine] + np.max(each, axis=0)
    return out


def _in_scene(rows: SceneRows, objective: Objective, light_limit_w: Array) -> Array:
    """The settings' part of the objective by one scene alone: no other lowers the power or betters the image."""
    free = dark.relaxed(rows)
    low, high = windows.window(free)
    alive = (low <= high * ROUND) & (rows.n_low <= rows.n_high * ROUND) & (rows.n_low > 0) & np.isfinite(low)
    alive &= (rows.time_max_s > 0) & (rows.time_min_s <= rows.time_max_s * ROUND)
    out = np.full(len(low), np.inf)
    if alive.any():
        which = np.flatnonzero(alive)
        out[which] = _of_alive(rows.take(which), objective, light_limit_w[which], low[which], high[which])
    return out


def _of_alive(rows: SceneRows, objective: Objective, light_limit_w: Array, low: Array, high: Array) -> Array:
    ends = intervals(rows.n_low, rows.n_high, objective)
    signal = rows.signal_e[:, rows.nominal]
    with np.errstate(divide="ignore", invalid="ignore"):
        veil = np.zeros(len(low)) if rows.veil_e is None else rows.veil_e[:, rows.nominal]
        most_x = np.where(np.isfinite(high), high, 1e30)
        most = sensor.snr(
            signal * most_x, veil_e=veil * most_x, read_noise_e=rows.read_noise_e, gain_dn_per_e=np.inf,
            prnu_frac=rows.prnu_frac,
        )  # fmt: skip
        snr_db = snr_in_levels(ratio_to_db(np.fmax(most, 1e-300)) + 1e-9)
        electrons = electrons_in_levels(rows.read_noise_e, rows.prnu_frac, np.where(signal > 0, veil / signal, 0.0))
        light_x = np.maximum(np.where(electrons > 0, electrons / signal[:, None], 0.0), low[:, None])
        square = np.square(ends[:, :-1] * rows.working_factor[:, None])
        amount = light_x[:, None, :] * square[:, :, None] / rows.light_lm[:, None, None]  # level * time
    amount = np.where(np.isnan(amount), np.inf, amount)
    power = _least_power(rows, amount)
    reached = np.isfinite(power) & (power <= light_limit_w[:, None, None] * ROUND)
    reached &= (light_x <= high[:, None] * ROUND)[:, None, :]
    value = objective.weight("power") * np.where(reached, power, 0.0)
    if objective.weight("snr_db"):
        value = value - objective.weight("snr_db") * snr_db[:, None, :]
    if objective.weight("information"):
        assert rows.sharp is not None
        most_bits = information_by_level(rows.sharp, rows.working_factor, ends, snr_db)
        value = value - objective.weight("information") * objective.counted("information", most_bits)
    value = np.where(reached & np.isfinite(snr_db)[:, None, :], value, np.inf)
    return np.asarray(value.reshape(len(low), -1).min(axis=1))


def _least_power(rows: SceneRows, amount: Array) -> Array:
    """Least mean power of the lights that gives level * time, (n, n_intervals, n_levels); inf where none does."""

    def each(column: Array) -> Array:
        return np.asarray(column)[:, None, None]

    longest, top = each(rows.time_max_s), np.minimum(rows.max_level, 1.0)
    least = np.where(rows.dims_freely, rows.min_level, np.fmin.reduce(rows.levels, axis=1))
    level = np.maximum(amount / longest, each(least))  # at the longest time
    steps = ~rows.dims_freely
    if steps.any():
        index = np.flatnonzero(steps)
        wanted, found = level[index], np.full(level[index].shape, np.inf)
        for column in rows.levels[index].T:
            step = each(np.where(np.isnan(column), np.inf, column))
            found = np.where(step >= wanted * (1 - 1e-9), np.minimum(found, step), found)
        level[index] = found
    drawn = each(rows.full_draw_w)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        paid = np.minimum(1.0 / longest, each(rows.rate_hz) * (1.0 + each(rows.leads_s) / longest))
        energy = np.maximum(level * each(rows.on_share(rows.time_min_s)), amount * paid)
        power = drawn * np.where(each(rows.timed), energy, level) + each(np.broadcast_to(rows.idle, rows.kind.shape))
    return np.where((level <= each(top) * ROUND) & np.isfinite(power), power, np.inf)

"""Upper bounds of quality over cells without sun, by tangents of concave logarithms at the cell's centre.

In the logarithms of f-number n, time t and level u the light is x = min(cap, u + t - 2 n + constant): concave, and
so are ln SNR in x and ln MTF in (n, t). With tangents in their place an objective that weighs power (convex in
the logarithms) against SNR and information is least at a vertex: a corner of the cell, or where one of its
edges meets the light's cap.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.part_columns import PULSED
from uwopt.model.information import TEXTURE_CONTRAST
from uwopt.objectives.objective import LEAST
from uwopt.solvers.settings import closed_form
from uwopt.solvers.settings.cell_bounds import Box, Reach, SceneCells
from uwopt.solvers.settings.cell_information import Information

DIMMEST = 1e-6  # of full level: below it a level has no logarithm, and counts as none in power
STEP = 1e-4  # of ln light, in the difference that stands for the slope of ln SNR
DB = 20.0 / np.log(10.0)
TANGENTS = 2
TYPICAL = ((0.15, 0.2), (0.28, 0.35), (0.42, 0.45))  # frequencies [cycles per px] that stand for all, and their weights
#: Of (MTF)^2 in frequency^2: a bell's share of squares of the disc of defocus, the lens's pitch and motion [px].
DISC_FALLS, LENS_FALLS, BLUR_FALLS = 1.3 * np.pi**2 / 4.0, 8.0 * np.log(2.0), np.pi**2 / 6.0


def surrogate_bit_per_px(scene: SceneCells, d: Array, box: Box, reach: Reach) -> Array:
    """A stand-in for information: no bound, but it moves like one."""
    blur_s = box.open_lo if scene.sunlit else scene.blurred_s(d, box.t_lo)
    return typical_bit_per_px(scene, d, reach.snr, box.n_lo, box.n_hi, blur_s)


def typical_bit_per_px(
    scene: SceneCells, d: Array, snr: Array, n_low: Array, n_high: Array, blur_s: Array
) -> Array:
    """Information as if a few frequencies stood for all and no factor of the transfer had a null.

    It peaks within a few percent of the f-number at which information does: nulls make defocus worse than a bell of
    the same width, which `DISC_FALLS` allows for.
    """
    sharp = scene.sharp
    assert sharp is not None
    cycle = n_low * scene.rows.working_factor[d] * sharp.wavelength_nm[d] * 1e-9 / sharp.pixel_pitch_m[d]
    disc, blur = sharp.rms_disc_px[d, 1] / n_high, sharp.blur_px_per_s[d, 1] * blur_s
    lens = sharp.lens_pitch_px("rms", f_number=n_high, rows=d)
    falls = DISC_FALLS * disc**2 + LENS_FALLS * lens**2 + BLUR_FALLS * blur**2
    seen2, bits = np.square(TEXTURE_CONTRAST * snr), np.zeros(())
    for frequency, weight in TYPICAL:
        pupil = np.maximum(1.0 - (4.0 / np.pi) * frequency * cycle, LEAST)
        bits = bits + weight * np.log1p(seen2 * np.square(pupil) * np.exp(-np.minimum(falls * frequency**2, 600.0)))
    return np.asarray(bits / np.log(4.0))


def quality_bound(
    scene: SceneCells, information: Information | None, d: Array, box: Box, reach: Reach, weight: dict[str, float],
    *, mixed: bool, by_ratio: bool, near: Array,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Information [bit/m2] at most; the least of power, SNR and information weighed together; where that would be.

    Returns (m,), (m,), (m, 2): ln f-number and ln time. Under the sun, where only the sum of the separate bounds is
    known, the second is -inf and the third nan.
    `near` : (m, 2) ln f-number and ln time near which the best is thought to be, nan: not known. Tangents are taken
    at the point of the cell nearest to it: what is best from there on is best at once.
    Where information counts `by_ratio`, its logarithm lies below each of its tangents, ln I <= ln I_0 + I / I_0 - 1,
    in whose place I is convex as before; I_0 is the most of the cell, then what it has at the vertex that was least.
    """
    area = scene.sharp.pixel_area_m2[d] if scene.sharp is not None else np.ones(len(d))
    if scene.sunlit:
        assert information is not None
        bits = sunlit_bits(scene, information, d, box, reach, near)
        return bits / area, np.full(len(d), -np.inf), np.full((len(d), 2), np.nan)
    shift, x, inside, x_centre, centre = vertices(scene, d, box, reach, mixed=mixed, near=near)
    rows = scene.rows.take(d)
    dark_rows = replace(rows, dark_time_s=np.maximum(rows.exposure_s(box.t_lo), 0.0))
    log_snr, slope = log_snr_and_slope(dark_rows, x_centre)
    at = log_snr[:, None] + slope[:, None] * (x - x_centre[:, None])
    at = np.minimum(at, 700.0)
    bits = np.zeros_like(at)
    if information is not None:
        bits = _information(scene, information, d, box, at, shift, inside, log_snr, centre, near) / area[:, None]
    joint = -weight["snr_db"] * DB * at
    if mixed and weight["power"]:
        joint = joint + weight["power"] * power_tangent(scene, d, box, shift, np.exp(centre))
    every, places = np.arange(len(d)), shift[:, :, :2] + centre[:, None, :2]
    most = np.where(inside, bits, -np.inf).max(axis=1)
    if not by_ratio:
        joint = np.where(inside, joint - weight["information"] * bits, np.inf)
        least = joint.argmin(axis=1)
        return most, joint[every, least], places[every, least]
    best, here = np.full(len(d), -np.inf), most
    for _ in range(TANGENTS):
        at_tangent = joint - weight["information"] * log_tangent(bits, here[:, None])
        at_tangent = np.where(inside, at_tangent, np.inf)
        least = at_tangent.argmin(axis=1)
        best = np.maximum(best, at_tangent[every, least])
        here = bits[every, least]
    return most, best, places[every, least]


def sunlit_bits(
    scene: SceneCells, information: Information, d: Array, box: Box, reach: Reach, near: Array
) -> Array:
    """Information [bit per px] at most, (m,), under the sun.

    In the logarithms of f-number and open shutter the signal is at most min(cap, shutter - 2 n + constant), whatever
    the lamps add: concave as light without sun is.
    """
    rows = scene.rows.take(d)
    light = scene.brightest(d, box, reach)
    low = np.log(np.stack([box.n_lo, box.open_lo], axis=1))
    high = np.log(np.stack([box.n_hi, box.open_hi], axis=1))
    constant = np.log(np.maximum(light.per_y_e, 1e-300)) - 2.0 * np.log(rows.working_factor)
    by = np.broadcast_to([-2.0, 1.0], low.shape)
    cap = np.log(np.maximum(light.signal_e, 1e-300))
    every, x, inside = polygon(low, high, by, constant, cap, None)
    x, centre = np.minimum(x, cap[:, None]), 0.5 * (low + high)
    np.copyto(centre, np.clip(near, low, high), where=np.isfinite(near))
    at = np.minimum(constant + (centre * by).sum(axis=1), cap)
    log_snr, slope = light.log_snr_and_slope(at)
    rising = np.minimum(log_snr[:, None] + slope[:, None] * (x - at[:, None]), 700.0)
    shift = every - centre[:, None, :]
    bits = _information(scene, information, d, box, rising, shift, inside, log_snr, centre, near)
    return np.asarray(np.where(inside, bits, -np.inf).max(axis=1))


def polygon(
    low: Array, high: Array, by: Array, constant: Array, cap: Array, least: Array | None
) -> tuple[Array, Array, Array]:
    """Corners of boxes (m, n_dims), and where their edges meet light `cap` and `least`, (m, n_vertices, n_dims); the
    light there, constant + by . place, not capped; and which are no corner told twice."""
    dims = low.shape[1]
    corners = np.array(list(product((0.0, 1.0), repeat=dims)))
    edges = [
        (i, j)
        for i, j in product(range(len(corners)), repeat=2)
        if i < j and np.abs(corners[i] - corners[j]).sum() == 1
    ]
    at = low[:, None, :] + (high - low)[:, None, :] * corners
    x = constant[:, None] + (at * by[:, None, :]).sum(axis=2)
    first, second = [i for i, _ in edges], [j for _, j in edges]
    over = x[:, second] - x[:, first]
    crossings, inner = [], [np.ones(at.shape[:2], bool)]
    for level in (cap,) if least is None else (cap, least):
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.clip(np.where(over != 0, (level[:, None] - x[:, first]) / over, 0.0), 0.0, 1.0)
        inner.append((share > 0.0) & (share < 1.0))  # the others are corners
        crossings.append(at[:, first] + share[:, :, None] * (at[:, second] - at[:, first]))
    every = np.concatenate([at, *crossings], axis=1)
    light = constant[:, None] + (every * by[:, None, :]).sum(axis=2)
    return every, light, np.concatenate(inner, axis=1)


def log_tangent(value: Array, at: Array) -> Array:
    """The tangent of the logarithm at some value: nowhere below the logarithm."""
    at = np.maximum(at, LEAST)
    return np.asarray(np.log(at) + value / at - 1.0)


def _information(
    scene: SceneCells, information: Information, d: Array, box: Box, log_snr: Array, shift: Array, wanted: Array,
    centre_log_snr: Array, centre: Array, near: Array,
) -> Array:  # fmt: skip
    """Bit per px at vertices; where the best is known to be `near`, the tangent is that at the centre even if smeared.

    The blur of a flash that fades is a curve of its light, ln b convex in ln t: ln MTF, which falls with ln b and is
    concave in it, is concave in ln t too, with the slope of both.
    """
    least = box.open_lo if scene.sunlit else box.t_lo
    f_number, middle, shift_t = np.exp(centre[:, 0]), np.exp(centre[:, 1]), shift[:, :, 1]
    if not scene.sunlit and scene.flash.fade:
        shift_t = shift_t * scene.flash.take(d).blur_elasticity(middle)[:, None]
        least, middle = scene.blurred_s(d, least), scene.blurred_s(d, middle)
    return information.bound(
        d, log_snr, shift[:, :, 0], shift_t, centre_log_snr=centre_log_snr, f_number=(box.n_lo, f_number, box.n_hi),
        factor=scene.rows.working_factor[d], blur_s=(least, middle), wanted=wanted,
        surely=np.asarray(np.isfinite(near).all(axis=1)),
    )  # fmt: skip


def log_snr_and_slope(rows: Any, x: Array) -> tuple[Array, Array]:
    """Ln SNR at the nominal altitude and its slope in ln light."""
    here, below, above = (
        np.log(np.maximum(closed_form.nominal_snr(rows, np.exp(x + step)), 1e-300))
        for step in (0.0, -STEP, STEP)
    )
    return here, (above - below) / (2.0 * STEP)


def level_range(scene: SceneCells, d: Array, box: Box, reach: Reach, *, mixed: bool) -> tuple[Array, Array]:
    """Ln of the least and greatest level that count; without power in the objective the greatest alone."""
    high = np.log(np.maximum(reach.u_hi, 1e-300))
    if not mixed:
        return high, high
    low = np.log(np.maximum(np.maximum(box.u_lo, DIMMEST * scene.u_max[d]), 1e-300))
    return np.minimum(low, high), high


def vertices(
    scene: SceneCells, d: Array, box: Box, reach: Reach, *, mixed: bool, near: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """Shifts from the centre (m, n_vertices, 3) in (n, t, u), light x there, and which are vertices of the part
    of the cell whose light is allowed; light at the centre, the centre: of the cell, or its point nearest to `near`."""
    rows = scene.rows
    u_lo, u_hi = level_range(scene, d, box, reach, mixed=mixed)
    low = np.stack([np.log(box.n_lo), np.log(box.t_lo), u_lo], axis=1)
    high = np.stack([np.log(box.n_hi), np.log(box.t_hi), u_hi], axis=1)
    constant = np.log(rows.light_lm[d]) - 2.0 * np.log(rows.working_factor[d])
    # A pulsed LED whose mean power is capped gives the same energy whatever the time.
    rate = rows.rate_hz[d]
    with np.errstate(divide="ignore", invalid="ignore"):
        capped = (rows.kind[d] == PULSED) & (not mixed) & (box.t_hi * rate <= 1 + 1e-9)
        capped &= box.u_hi * box.t_lo * rate >= scene.share[d] * (1 - 1e-9)
        energy = np.log(scene.share[d] * (1 + 2e-9) / rate) - high[:, 2]
    constant = np.where(capped, constant + energy, constant)
    by = np.stack([np.full(len(d), -2.0), np.where(capped, 0.0, 1.0), np.ones(len(d))], axis=1)
    cap = np.log(np.maximum(reach.x_cap, 1e-300))
    cap = np.where(np.isposinf(reach.x_cap), 1e9, cap)
    least = np.log(np.maximum(reach.x_lo, 1e-300)) - 1e-10
    dims = 3 if mixed else 2  # the third has no width else
    alone = constant + (low * by)[:, dims:].sum(axis=1)
    every, light, inside = polygon(low[:, :dims], high[:, :dims], by[:, :dims], alone, cap, least)
    rest = np.broadcast_to(low[:, None, dims:], (*every.shape[:2], 3 - dims))
    every = np.concatenate([every, rest], axis=2)
    inside &= light >= least[:, None] - 1e-9
    if mixed:
        inside &= light <= cap[:, None] + 1e-9
    light = np.minimum(light, cap[:, None])
    centre = 0.5 * (low + high)
    centre[:, :2] = np.where(np.isfinite(near), np.clip(near, low[:, :2], high[:, :2]), centre[:, :2])
    x_centre = np.minimum(constant + (centre * by).sum(axis=1), cap)
    return every - centre[:, None, :], light, inside, x_centre, centre


def power_tangent(scene: SceneCells, d: Array, box: Box, shift: Array, centre: Array) -> Array:
    """Light power at vertices, from below: convex in the logarithms, so its tangent at the centre (n, t, u)."""
    rows = scene.rows
    rate, drawn = rows.rate_hz[d], rows.full_draw_w[d]
    lead_s, timed = scene.leads_s[d], scene.timed[d]
    short = timed & ((lead_s + box.t_hi) * rate <= 1 + 1e-9)
    duty = np.where(timed & ~short, np.minimum(1.0, (lead_s + box.t_lo) * rate), 1.0)
    on_s = lead_s + centre[:, 1]
    at_centre = drawn * centre[:, 2] * np.where(short, on_s * rate, duty)
    slope = shift[:, :, 2] + np.where(short, centre[:, 1] / on_s, 0.0)[:, None] * shift[:, :, 1]
    floor = DIMMEST * scene.u_max[d]  # levels below it have no vertex
    unseen = drawn * np.where(box.u_lo < floor, floor, 0.0)
    idle = np.broadcast_to(rows.idle, rate.shape if rows.idle_w is None else rows.kind.shape)
    idle = idle if rows.idle_w is None else idle[d]
    if rows.camera_w is not None:
        idle = idle + rows.take(d).exposing_w(scene.exposure_s(d, box.t_lo, box.open_lo))
    return np.asarray(at_centre[:, None] * (1.0 + slope) - unseen[:, None] + idle[:, None])

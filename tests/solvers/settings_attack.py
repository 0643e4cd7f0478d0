"""Settings of hand-made rows attacked by random search, through formulas written out again here.

Nothing here uses the solvers' windows, bounds or tangents: electrons, noise, gain and level are the equations of
the physics page (section 6), MTF and information those of `SharpRows`, which has tests of its own.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from hand_made_rows import scene
from numpy.typing import NDArray

from uwopt.forward.detail import DetailRows
from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.forward.sharpness import SharpRows
from uwopt.model.detail import DetailTable
from uwopt.objectives.objective import Objective

Array = NDArray[Any]


def sharp(
    *, blur: float = 2000.0, place: float = 4.0, rms: float = 6.0, rated: float = 0.8, aberration: float = 0.8,
    power: float = 3.0, scattered: float | None = None,
) -> SharpRows:  # fmt: skip
    """A 3.45 um sensor that moves, with some image curvature; discs at f-number 1.

    `scattered`: b r, of which the detail of a frequency keeps a share that falls as one over it.
    """
    one, none = np.ones(1), np.zeros(1)
    return SharpRows(
        wavelength_nm=530.0 * one, pixel_pitch_m=3.45e-6 * one, rated_pitch_px=rated * one,
        aberration_px=aberration * one, aberration_exponent=power * one,
        corner_disc_px=np.array([[1.0, 0.2, 1.0]]) * place, corner_k_along=none, corner_k_across=none,
        gsd_m=np.array([[0.9e-3, 1e-3, 1.1e-3]]),
        blur_px_per_s=np.array([[1.1, 1.0, 0.9]]) * blur, place_disc_px=np.array([[1.0, 0.2, 1.0]]) * place,
        rms_disc_px=np.array([[1.0, 0.6, 1.0]]) * rms, place_k_along=none, place_k_across=none, rms_k_along=none,
        rms_k_across=none, spread_index=np.zeros(1, int), pixel_area_m2=1e-6 * one, spreads=(),
        detail=None if scattered is None else detail(scattered),
    )  # fmt: skip


def detail(scattered: float) -> DetailRows:
    """Detail in the veil of a hazy water, where a pixel sees 1 mm from 1 m."""
    frequency = np.geomspace(1.0, 1e5, 60)
    table = DetailTable(np.log(frequency), 1.0 / (1.0 + frequency / 100.0))
    return DetailRows(
        scattered=scattered * np.array([[0.9, 1.0, 1.1]]), cycles_per_rad=1e3 * np.ones((1, 3)),
        texture_gain=np.exp(np.array([0.2 * scattered])), table=table,
    )  # fmt: skip


def lit(
    sharpness: SharpRows | None = None, *, sun: tuple[float, float] | None = None, veil: float | None = None,
    open_max_s: float | None = None, min_mtf: float = 0.0, resolve_m: float = 0.0, min_contrast: float = 0.0,
    may_miss: int | None = None, colours: tuple[tuple[float, ...], tuple[float, ...]] | None = None,
    min_snr_red: float = 0.0, min_snr_mean: float = 0.0, max_white_balance: float = np.inf, **changed: Any,
) -> SceneRows:  # fmt: skip
    """Three altitudes under lamps, with sun (signal, veil) where a test wants it.

    `may_miss`: the SNR is asked of twenty pixels, each with lamps, sun and veil of its own, of which so many may
    miss it. `colours`: red, green and blue of the lamps and of the sun; red's veils are half of the mean's, and
    red falls with the altitude more steeply than the others.
    """
    values: dict[str, Any] = dict(signal_e=[120.0, 100.0, 80.0], nominal=1)
    values.update(changed)
    rows = scene(**values)
    shape = np.array([[1.2, 1.0, 0.8]])
    asked = dict(min_mtf=min_mtf, resolve_m=resolve_m, min_contrast=min_contrast)
    more: dict[str, Any] = dict(sharp=sharpness or sharp(), min_snr_mean=min_snr_mean, **asked)
    if veil is not None:
        more["veil_e"] = veil * shape[:, ::-1]
    if sun is not None:
        more.update(sun_signal_e_s=sun[0] * shape, sun_veil_e_s=sun[1] * shape[:, ::-1])
    if open_max_s is not None:
        more["open_max_s"] = np.array([open_max_s])
    rows = replace(rows, **more)
    if colours is not None:
        steep = np.stack([np.square(shape), shape, shape], axis=2)
        lamps, daylight = (steep * np.array(one) for one in colours)
        rows = replace(
            rows, colour_e=lamps, red_veil_e=None if rows.veil_e is None else 0.5 * rows.veil_e,
            min_snr_red=min_snr_red, max_white_balance=max_white_balance,
            sun_colour_e_s=None if sun is None else daylight,
            sun_red_veil_e_s=None if rows.sun_veil_e_s is None else 0.5 * rows.sun_veil_e_s,
        )  # fmt: skip
    return rows if may_miss is None else in_pixels(rows, may_miss)


def in_pixels(rows: SceneRows, may_miss: int) -> SceneRows:
    """The rows with twenty pixels: three are dark, the others far brighter than the mean."""
    lamps, sun, veil = np.random.default_rng(5).uniform([[3.0], [0.9], [0.5]], [[4.0], [1.2], [1.2]], (3, 20))
    lamps[:3] = 0.1

    def spread(column: Array | None, share: Array) -> Array | None:
        return None if column is None else column[:, :, None] * share

    return replace(
        rows, may_miss=may_miss, worst_e=spread(rows.signal_e, lamps), worst_veil_e=spread(rows.veil_e, veil),
        worst_sun_signal_e_s=spread(rows.sun_signal_e_s, sun), worst_sun_veil_e_s=spread(rows.sun_veil_e_s, veil),
    )  # fmt: skip


# ---------------------------------------------------------------- the equations, written out


def figures(
    rows: SceneRows, n: Array, tau: Array, open_s: Array, u: Array, *, info: bool
) -> dict[str, Array]:
    """Power, SNR in dB, contrast, information and feasibility of one design at many settings."""
    r = rows.take(np.zeros(len(n), int))
    kind = int(rows.kind[0])
    n_w = n * r.working_factor
    x = (r.light_lm * u * tau / n_w**2)[:, None]
    signal, veil = r.signal_e * x, (0.0 if r.veil_e is None else r.veil_e) * x
    exposure = open_s - r.exposure_offset_s
    if r.sun_signal_e_s is not None:
        assert r.sun_veil_e_s is not None
        y = (open_s / n_w**2)[:, None]
        signal, veil = signal + r.sun_signal_e_s * y, veil + r.sun_veil_e_s * y
    else:
        exposure = tau + r.readout_s if kind == PULSED else opened_s(r, tau) - r.exposure_offset_s
        exposure = np.maximum(exposure, r.min_exposure_s)
    dark = (r.dark_current_e_s * exposure)[:, None]
    every = signal + veil + dark
    full, black, ratio = r.full_scale_dn, r.black_level_dn, r.highlight_ratio
    ok = (ratio * every <= r.well_e[:, None] * (1 + 1e-8)).all(axis=1)
    k0 = r.gain_dn_per_e
    if r.mean_level is None:
        gain = np.clip((full / ratio - black) / (k0 * every.max(axis=1)), 1.0, r.max_gain)
    else:
        gain = (r.mean_level * full - black) / (k0 * every[:, r.nominal])
        ok &= (gain >= 1 - 1e-8) & (gain <= r.max_gain * (1 + 1e-8))
    k = (k0 * gain)[:, None]
    ok &= (ratio * (k * every + black[:, None]) <= full[:, None] * (1 + 1e-8)).all(axis=1)
    noise = (
        r.read_noise_e[:, None] ** 2
        + 1.0 / 12.0 / k**2
        + every
        + (r.prnu_frac[:, None] * (signal + veil)) ** 2
    )
    snr = signal / np.sqrt(noise)
    ok &= (snr >= r.min_snr_mean * (1 - 1e-8)).all(axis=1)
    ok &= (snr_asked(r, snr, x, k, dark, open_s / n_w**2) >= r.min_snr * (1 - 1e-8)).all(axis=1)
    with np.errstate(invalid="ignore"):
        contrast = signal / (signal + veil)
    if r.min_contrast:
        ok &= (contrast >= r.min_contrast * (1 - 1e-8)).all(axis=1)
    ok &= colours_hold(r, x, k, dark, open_s / n_w**2)
    blur = smear_s(r, tau) if r.sun_signal_e_s is None else open_s
    assert r.sharp is not None
    if r.min_mtf:
        mtf = r.sharp.mtf_half_nyquist(f_number=n, working_f_number=n_w, blur_s=blur)
        ok &= mtf.min(axis=1) >= r.min_mtf * (1 - 1e-8)
    if r.resolve_m:
        arriving = np.minimum(contrast, share_asked(r, x, open_s / n_w**2))
        bars_m = r.sharp.smallest_bars_m(arriving, f_number=n, working_f_number=n_w, blur_s=blur)
        ok &= bars_m.max(axis=1) <= r.resolve_m * (1 + 1e-8)
    duty = np.minimum(1.0, tau * r.rate_hz)
    drawn = {CONTINUOUS: r.full_power_w, PULSED: r.full_power_w * duty, FLASH: r.pulse_energy_j * r.rate_hz}
    bits = np.zeros(len(n))
    if info and ok.any():
        bits[ok] = r.sharp.take(np.nonzero(ok)[0]).information_bit_per_m2(
            snr[ok, r.nominal], f_number=n[ok], working_f_number=n_w[ok], blur_s=blur[ok]
        )
    return dict(
        power=u * drawn[kind], snr_db=20 * np.log10(np.maximum(snr[:, r.nominal], 1e-300)),
        contrast=contrast[:, r.nominal], information=bits, ok=ok,
    )  # fmt: skip


def opened_s(r: SceneRows, tau: Array) -> Array:
    """Open shutter for light that takes a time; of a flash that fades, tau is the time at its peak."""
    return tau if r.flash_decay_s is None else -r.flash_decay_s * np.log(1.0 - tau / r.flash_decay_s)


def smear_s(r: SceneRows, tau: Array) -> Array:
    """Steady light of the same variance, from 12 (1 - x^2 e^-x / (1 - e^-x)^2) decays squared."""
    if r.flash_decay_s is None:
        return tau
    x = opened_s(r, tau) / r.flash_decay_s
    exact = r.flash_decay_s * np.sqrt(12.0 * np.maximum(1.0 - x**2 * np.exp(-x) / np.expm1(-x) ** 2, 0.0))
    return np.where(x < 1e-3, x * r.flash_decay_s, exact)


def snr_asked(r: SceneRows, of_mean: Array, x: Array, k: Array, dark: Array, y: Array) -> Array:
    """The SNR that is asked for by altitude: of the mean, or of the pixels without the darkest few."""
    if r.worst_e is None:
        return of_mean
    one, veil = r.worst_e * x[:, :, None], (0.0 if r.worst_veil_e is None else r.worst_veil_e) * x[:, :, None]
    if r.worst_sun_signal_e_s is not None and r.worst_sun_veil_e_s is not None:
        one = one + r.worst_sun_signal_e_s * y[:, None, None]
        veil = veil + r.worst_sun_veil_e_s * y[:, None, None]
    read, prnu = (column[:, None, None] for column in (r.read_noise_e, r.prnu_frac))
    noise = read**2 + 1.0 / 12.0 / k[:, :, None] ** 2 + one + veil + dark[:, :, None] + (prnu * (one + veil)) ** 2
    return np.asarray(np.sort(one / np.sqrt(noise), axis=2)[:, :, r.may_miss])


def share_asked(r: SceneRows, x: Array, y: Array) -> Array | float:
    """Image-forming over all light at the pixels, without the darkest few, by altitude; 1 where no pixel is known."""
    if r.worst_e is None or r.worst_veil_e is None:
        return 1.0
    one, veil = r.worst_e * x[:, :, None], r.worst_veil_e * x[:, :, None]
    if r.worst_sun_signal_e_s is not None and r.worst_sun_veil_e_s is not None:
        one = one + r.worst_sun_signal_e_s * y[:, None, None]
        veil = veil + r.worst_sun_veil_e_s * y[:, None, None]
    return np.asarray(np.sort(one / (one + veil), axis=2)[:, :, r.may_miss])


def colours_hold(r: SceneRows, x: Array, k: Array, dark: Array, y: Array) -> Array:
    """Whether red has its SNR and no channel more than its multiple of another, at every altitude."""
    if r.colour_e is None:
        return np.ones(len(x), bool)
    colour, veil = r.colour_e * x[:, :, None], (0.0 if r.red_veil_e is None else r.red_veil_e) * x
    if r.sun_colour_e_s is not None and r.sun_red_veil_e_s is not None:
        colour, veil = colour + r.sun_colour_e_s * y[:, None, None], veil + r.sun_red_veil_e_s * y[:, None]
    red, (read, prnu) = colour[:, :, 0], (column[:, None] for column in (r.read_noise_e, r.prnu_frac))
    noise = read**2 + 1.0 / 12.0 / k**2 + red + veil + dark + (prnu * (red + veil)) ** 2
    ok = (red / np.sqrt(noise) >= r.min_snr_red * (1 - 1e-8)).all(axis=1)
    balanced = colour.max(axis=2) <= r.max_white_balance * colour.min(axis=2) * (1 + 1e-8)
    return np.asarray(ok & balanced.all(axis=1))


def sample(
    rows: SceneRows, rng: np.random.Generator, count: int, near: Array | None, width: float
) -> list[Array]:
    """Settings all over their ranges in (ln N, ln tau, ln open, level), or near given ones."""
    kind, t0 = int(rows.kind[0]), float(rows.exposure_offset_s[0])
    limits = [(rows.n_low, rows.n_high), (rows.time_min_s, rows.time_max_s)]
    low, high = (np.log([float(pair[end][0]) for pair in limits]) for end in (0, 1))
    place = low + (high - low) * rng.uniform(size=(count, 2))
    share, extra = rng.uniform(-7, 0, size=count), rng.uniform(size=count)
    if near is not None:
        index = rng.integers(len(near), size=count)
        scale = width * rng.standard_normal((count, 4)) * rng.integers(0, 2, (count, 4))
        place = np.clip(np.log(near[index][:, :2]) + scale[:, :2], low, high)
        share = np.log(np.maximum(near[index][:, 3], 1e-9)) + scale[:, 3]
        extra = near[index][:, 2] + scale[:, 2]
    n, tau = np.exp(place).T
    u = np.minimum(np.exp(share), float(min(1.0, rows.max_level[0])))
    u = np.maximum(u, float(rows.min_level[0]))
    if not rows.dims_freely[0]:
        steps = rows.levels[0]
        u = steps[np.argmin(np.abs(np.log(steps) - np.log(u)[:, None]), axis=1)]
    open_s = tau.copy()
    if rows.sunlit and kind == FLASH:
        open_s = opened_s(rows, tau)
    if rows.sunlit and kind == PULSED:
        least = np.maximum(rows.min_exposure_s[0], tau + rows.readout_s[0]) + t0
        most = least if rows.open_max_s is None else np.maximum(rows.open_max_s[0], least)
        extra = np.clip(extra, 0.0, 1.0)
        open_s = least + extra * (most - least)
    return [n, tau, open_s, u, extra]


def attacked(rows: SceneRows, objective: Objective, rng: np.random.Generator) -> float:
    """Least value found by random search with rounds of smaller steps about the best; inf: nothing feasible."""
    info, best, near = bool(objective.weight("information")), np.inf, None
    for step in range(7):
        count = 3000 if near is None else 800
        n, tau, open_s, u, extra = sample(rows, rng, count, near, 0.5 * 0.3**step)
        seen = figures(rows, n, tau, open_s, u, info=info)
        value = np.where(seen["ok"], weighed(objective, seen), np.inf)
        order = np.argsort(value)[:10]
        order = order[np.isfinite(value[order])]
        if len(order):
            best = min(best, float(value[order[0]]))
            near = np.stack([n, tau, extra, u], axis=1)[order]
    return best


def weighed(objective: Objective, seen: Any) -> Array:
    """The weighted sum of figures, less being better; of the best image with information by its logarithm."""
    total = np.zeros(np.shape(seen["power"]))
    for name, sign in SIGNS.items():
        if objective.weight(name):
            figure = np.asarray(seen[name])
            if name == "information" and objective.quality:
                figure = np.log(np.maximum(figure, 1e-300))
            total = total + objective.weight(name) * sign * figure
    return total


SIGNS = {"power": 1.0, "snr_db": -1.0, "contrast": -1.0, "information": -1.0}

#: Rows under the sun of which something of their colours is asked: what they are, and an objective.
COLOURED: dict[str, tuple[dict[str, Any], str]] = {
    "power of a red image under the sun": (
        dict(sun=(2e5, 6e4), veil=20.0, open_max_s=5e-3, colours=((20.0, 100.0, 60.0), (3e4, 3e4, 4e4)),
             min_snr_red=6.0),
        "power",
    ),
    "power of lamps that balance the sun's colours": (
        dict(sun=(3e5, 2e5), open_max_s=5e-3, colours=((50.0, 100.0, 60.0), (1e4, 3e5, 4e5)), max_white_balance=6.0),
        "power",
    ),
    "power of pulses that balance the sun's colours": (
        dict(sun=(3e5, 2e5), open_max_s=5e-3, colours=((50.0, 100.0, 60.0), (1e4, 3e5, 4e5)), max_white_balance=6.0,
             kind=PULSED, rate_hz=5.0, min_exposure_s=1e-5, time_max_s=4e-3),
        "power",
    ),
    "signal of lamps that the sun's colours balance": (
        dict(sun=(3e5, 2e5), open_max_s=5e-3, colours=((8.0, 100.0, 60.0), (2e5, 3e5, 2.5e5)), max_white_balance=6.0),
        "snr_db",
    ),
}  # fmt: skip

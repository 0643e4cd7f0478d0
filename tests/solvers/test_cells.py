"""Settings searched cell by cell: proofs attacked by random search through formulas written out again here.

Nothing here uses the solver's windows, bounds or tangents: electrons, noise, gain and level are the equations of
the physics page (section 6), MTF and information those of `SharpRows`, which has tests of its own.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hand_made_rows import FLASHES, STEPS, scene
from numpy.typing import NDArray

from uwopt.hardware import CONTINUOUS, FLASH, PULSED
from uwopt.objectives.objective import Objective
from uwopt.rows import SceneRows
from uwopt.sharp import SharpRows
from uwopt.solvers.cell_info import log_box, log_disc, log_pupil
from uwopt.solvers.cells import CellResult, best_by_cells
from uwopt.solvers.goals import best_settings

Array = NDArray[Any]
GAP = 1e-4
CAMERA_W = np.array([3.0])


def sharp(*, blur: float = 2000.0, place: float = 4.0, rms: float = 6.0, rated: float = 0.8) -> SharpRows:
    """A 3.45 um sensor that moves, with some image curvature; discs at f-number 1."""
    one, none = np.ones(1), np.zeros(1)
    return SharpRows(
        wavelength_nm=530.0 * one, pixel_pitch_m=3.45e-6 * one, rated_pitch_px=rated * one,
        blur_px_per_s=np.array([[1.1, 1.0, 0.9]]) * blur, place_disc_px=np.array([[1.0, 0.2, 1.0]]) * place,
        rms_disc_px=np.array([[1.0, 0.6, 1.0]]) * rms, place_k_along=none, place_k_across=none, rms_k_along=none,
        rms_k_across=none, spread_index=np.zeros(1, int), pixel_area_m2=1e-6 * one, spreads=(),
    )  # fmt: skip


def lit(
    sharpness: SharpRows | None = None, *, sun: tuple[float, float] | None = None, veil: float | None = None,
    open_max_s: float | None = None, min_mtf: float = 0.0, min_contrast: float = 0.0, **changed: Any,
) -> SceneRows:  # fmt: skip
    """Three altitudes under lamps, with sun (signal, veil) where a test wants it."""
    values: dict[str, Any] = dict(signal_e=[120.0, 100.0, 80.0], nominal=1)
    values.update(changed)
    rows = scene(**values)
    shape = np.array([[1.2, 1.0, 0.8]])
    more: dict[str, Any] = dict(sharp=sharpness or sharp(), min_mtf=min_mtf, min_contrast=min_contrast)
    if veil is not None:
        more["veil_e"] = veil * shape[:, ::-1]
    if sun is not None:
        more.update(sun_signal_e_s=sun[0] * shape, sun_veil_e_s=sun[1] * shape[:, ::-1])
    if open_max_s is not None:
        more["open_max_s"] = np.array([open_max_s])
    return replace(rows, **more)


def solved(rows: list[SceneRows], wanted: Any, **more: Any) -> CellResult:
    """One design."""
    return best_by_cells(rows, np.array([False]), Objective.of(wanted), CAMERA_W, np.inf, **more)


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
        exposure = tau + r.readout_s if kind == PULSED else tau - r.exposure_offset_s
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
    ok &= (snr >= r.min_snr * (1 - 1e-8)).all(axis=1)
    with np.errstate(invalid="ignore"):
        contrast = signal / (signal + veil)
    if r.min_contrast:
        ok &= (contrast >= r.min_contrast * (1 - 1e-8)).all(axis=1)
    blur = tau if r.sun_signal_e_s is None else open_s
    assert r.sharp is not None
    if r.min_mtf:
        mtf = r.sharp.mtf_half_nyquist(f_number=n, working_f_number=n_w, blur_s=blur)
        ok &= mtf.min(axis=1) >= r.min_mtf * (1 - 1e-8)
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
        value = sum(
            (
                objective.weight(name) * sign * seen[name]
                for name, sign in SIGNS.items()
                if objective.weight(name)
            ),
            np.zeros(count),
        )
        value = np.where(seen["ok"], value, np.inf)
        order = np.argsort(value)[:10]
        order = order[np.isfinite(value[order])]
        if len(order):
            best = min(best, float(value[order[0]]))
            near = np.stack([n, tau, extra, u], axis=1)[order]
    return best


SIGNS = {"power": 1.0, "snr_db": -1.0, "contrast": -1.0, "information": -1.0}


def value_of(found: CellResult, objective: Objective) -> float:
    """The objective at the answer."""
    power = max(float(c.light_power_w[0]) for c in found.chosen)
    terms = dict(
        power=power, snr_db=found.snr_db[0], contrast=found.contrast[0], information=found.information[0]
    )
    return float(sum(objective.weight(n) * s * terms[n] for n, s in SIGNS.items() if objective.weight(n)))


def check(rows: SceneRows, wanted: Any, seed: int, *, gap: float = GAP) -> CellResult:
    """The answer is feasible, as good as it says, within its gap, and random search never beats the bound."""
    objective = Objective.of(wanted)
    found = solved([rows], wanted)
    attack = attacked(rows, objective, np.random.default_rng(seed))
    if not found.feasible[0]:
        assert found.lower_bound[0] == np.inf  # a proof, and it holds
        assert attack == np.inf
        return found
    value, chosen = value_of(found, objective), found.chosen[0]
    open_s = chosen.exposure_s + rows.exposure_offset_s if rows.sunlit else chosen.time_s
    again = figures(
        rows,
        chosen.f_number,
        chosen.time_s,
        np.asarray(open_s),
        chosen.level,
        info="information" in objective.weights,
    )
    assert again["ok"][0]
    for name in objective.weights:
        got = chosen.light_power_w[0] if name == "power" else getattr(found, name)[0]
        assert got == pytest.approx(again[name][0], rel=1e-7)
    assert found.lower_bound[0] <= value + 1e-9 * abs(value)
    assert value - found.lower_bound[0] <= gap * abs(value) * (1 + 1e-6)
    assert attack >= found.lower_bound[0] - 1e-7 * abs(value)
    return found


# ---------------------------------------------------------------- proofs


def random_rows(rng: np.random.Generator, *, kind: int, **more: Any) -> SceneRows:
    """A design drawn at random: light, noise, gain, sharpness."""
    values: dict[str, Any] = dict(
        signal_e=list(np.exp(rng.uniform(2, 7)) * np.array([1.2, 1.0, 0.7])), read_noise_e=rng.uniform(1, 12),
        gain_dn_per_e=np.exp(rng.uniform(-3, 0.5)), max_gain=float(rng.choice([1.0, 4.0, 16.0])),
        well_e=np.exp(rng.uniform(7, 10.5)), time_max_s=np.exp(rng.uniform(-7, -4)), kind=kind,
        min_level=float(rng.choice([0.0, 0.1])), min_snr=np.exp(rng.uniform(0.5, 3)),
        mean_level=float(rng.choice([0.0, 0.25])) or None, dark_current_e_s=float(rng.choice([0.0, 5.0])),
    )  # fmt: skip
    if rng.uniform() < 0.25:
        values.update(STEPS)
    look = sharp(
        blur=np.exp(rng.uniform(5, 8)),
        place=rng.uniform(0, 6),
        rms=rng.uniform(0, 8),
        rated=rng.uniform(0, 1.2),
    )
    values.update(more)
    return lit(look, **values)


@pytest.mark.parametrize("seed", range(14))
@pytest.mark.parametrize("wanted", ["power", "snr_db"])
def test_least_power_and_most_snr_of_a_sharp_image(wanted: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows = random_rows(rng, kind=[CONTINUOUS, PULSED][seed % 2], min_mtf=rng.uniform(0.2, 0.6))
    check(rows, wanted, seed)


@pytest.mark.parametrize("seed", range(14))
def test_most_information(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    # 2e-4: where motion ends inside the Nyquist square, the bound's nodes and the model's differ by up to 1e-4.
    check(random_rows(rng, kind=[CONTINUOUS, PULSED][seed % 2]), "information", seed, gap=2e-4)


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("wanted", ["power", "snr_db"])
def test_sunlight_beside_lamps(wanted: str, seed: int) -> None:
    rng = np.random.default_rng(200 + seed)
    sun = (np.exp(rng.uniform(7, 11)), np.exp(rng.uniform(7, 11)))
    rows = random_rows(
        rng, kind=[CONTINUOUS, PULSED][seed % 2], sun=sun, veil=10.0, open_max_s=5e-3, time_max_s=4e-3,
        mean_level=None, min_level=0.0,
    )  # fmt: skip
    check(rows, wanted, seed, gap=1e-2)  # three or four dimensions: the gap is stated, not closed


# ---------------------------------------------------------------- limits


@pytest.mark.parametrize("kind", [CONTINUOUS, PULSED])
@pytest.mark.parametrize("wanted", ["power", "snr_db", {"power": 1.0, "snr_db": 2.0}])
def test_mtf_that_asks_for_nothing_leaves_the_closed_form(wanted: Any, kind: int) -> None:
    rows, objective = (
        lit(sharp(blur=0.0, place=0.0), kind=kind),
        Objective.of(wanted),
    )  # nothing is beyond a null
    args = (np.array([False]), objective, CAMERA_W, np.inf)
    easy, same = best_settings([rows], *args), best_settings([replace(rows, min_mtf=1e-12)], *args)
    assert same.chosen[0].light_power_w == pytest.approx(easy.chosen[0].light_power_w, rel=1e-9)
    assert same.snr_db == pytest.approx(easy.snr_db, rel=1e-9)
    cells = best_by_cells([replace(rows, min_mtf=1e-12)], *args)  # and so do the cells, to their gap
    value = (
        objective.weight("power") * easy.chosen[0].light_power_w - objective.weight("snr_db") * easy.snr_db
    )
    assert cells.lower_bound[0] <= value[0] + 1e-9 * abs(value[0])
    assert value_of(cells, objective) == pytest.approx(value[0], rel=2e-4)


@pytest.mark.parametrize("kind", [CONTINUOUS, PULSED])
def test_sun_that_hardly_shines_leaves_the_closed_form(kind: int) -> None:
    args = (np.array([False]), Objective.of("power"), CAMERA_W, np.inf)
    dark = best_settings([lit(kind=kind)], *args)
    faint = best_settings([lit(kind=kind, sun=(1e-9, 1e-9), open_max_s=5e-3)], *args)
    assert faint.chosen[0].light_power_w == pytest.approx(dark.chosen[0].light_power_w, rel=1e-4)


@pytest.mark.parametrize("wanted", ["power", "information"])
def test_scene_taken_twice_counts_once(wanted: str) -> None:
    rows = lit(min_mtf=0.3)
    once, twice = solved([rows], wanted), solved([rows, rows], wanted)
    objective = Objective.of(wanted)
    assert value_of(twice, objective) == pytest.approx(value_of(once, objective), rel=2e-4)


def test_power_and_information_weighed_together() -> None:
    for seed, kind in enumerate((CONTINUOUS, PULSED)):
        check(lit(kind=kind), {"power": 1.0, "information": 1e-4}, seed, gap=2e-4)


def test_flash_and_lamp_with_steps() -> None:
    for rows in (lit(**FLASHES), lit(**STEPS)):
        check(rows, "information", 3)


def test_contrast_under_sun_wants_the_lamps_at_full_level() -> None:
    # Lamps are cleaner than the sun: their share of the light is greatest at full level, whatever the aperture.
    # L = 20 klm, C = 100, veil 10; sun 25000 and 40000 e/s: (100 L + 25000) / (110 L + 65000), by hand.
    found = solved([lit(sun=(25000.0, 40000.0), veil=10.0)], "contrast")
    assert found.contrast[0] == pytest.approx((100 * 2e4 + 25000) / (110 * 2e4 + 65000), rel=1e-9)


def test_contrast_that_no_lamp_reaches_is_proven_infeasible() -> None:
    found = solved([lit(sun=(100.0, 40000.0), veil=200.0, min_contrast=0.5)], "power")
    assert not found.feasible[0] and found.lower_bound[0] == np.inf


def test_designs_beyond_the_cutoff_are_dropped() -> None:
    rows = lit(min_mtf=0.3)
    free = solved([rows], "power")
    beaten = solved([rows], "power", cutoff=0.5 * value_of(free, Objective.of("power")))
    assert not beaten.feasible[0] and beaten.dropped[0]
    assert beaten.lower_bound[0] >= 0.5 * free.lower_bound[0]


# ---------------------------------------------------------------- what tangents rest on


@pytest.mark.parametrize(("factor", "null"), [(log_pupil, 1.0), (log_disc, 3.83), (log_box, 1.0)])
def test_factors_of_the_transfer_are_concave_in_logarithms(factor: Any, null: float) -> None:
    at = np.linspace(np.log(1e-3 * null), np.log(0.9 * null), 4001)
    value, slope = factor(np.exp(at))
    assert (np.diff(slope) <= 1e-9).all()
    # Midpoint differences of the values: an independent slope, with its second-order error.
    assert np.allclose(np.diff(value) / np.diff(at), 0.5 * (slope[1:] + slope[:-1]), rtol=2e-3, atol=1e-5)

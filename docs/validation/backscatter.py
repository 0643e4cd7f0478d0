# ruff: noqa: E501 - a line of the page's text is as long as the expressions in it
"""Section 3: the backscatter veil against photons, and the ray integral against adaptive quadrature."""

from __future__ import annotations

import math
import warnings
from functools import cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import quad

from . import common, photons
from .photons import Setting

N_PHOTONS = 3_000_000
N_MULTIPLE = 800_000
MOST_ORDERS = 40
CASES = (
    Setting("dome, lamp 0.5 m aside", "II", 2.0, 0.0, 0.5),
    Setting("dome, tilted 20° outward", "3C", 1.5, 0.2, 0.4, tilt_y=20.0),
    Setting("dome, narrow lobe", "II", 4.0, 0.0, 1.0, half_angle=15.0),
    Setting("dome, clear water, high", "IB", 8.0, 0.0, 2.0, tilt_y=5.0),
    Setting("dome, harbour", "7C", 0.8, 0.0, 0.5, half_angle=50.0),
    Setting("dome, Petzold HAOCE 11", "1C", 2.0, 0.0, 0.7, petzold="HAOCE 11"),
    Setting("flat, lamp 0.3 m aside", "II", 1.5, 0.0, 0.3, dome=None, focal_mm=12.0),
    Setting("flat, long lens", "III", 3.0, -0.3, 0.8, tilt_y=10.0, dome=None, focal_mm=16.0),
)
MULTIPLE = (3, 0, 1, 4)


class Seen(NamedTuple):
    """One case, in electrons of the image's mean."""

    case: Setting
    photons_e: float
    error_e: float
    uwopt_e: float
    signal_e: float

    @property
    def difference(self) -> float:
        """Relative difference of uwopt from the photons."""
        return self.uwopt_e / self.photons_e - 1.0

    @property
    def sigma(self) -> float:
        """Relative standard error of the photons."""
        return self.error_e / self.photons_e


def electrons_per_gain(case: Setting, working_f_number: float) -> float:
    """From `photons.mean_veil` to electrons: p^2 T_lens T_port (pi/4) / N_w^2 Phi t."""
    n_w = float(np.interp(550.0, common.WAVES_NM, common.index_of_water(10.0, 35.0)))
    faces = 1.0
    for one, other in ((n_w, 1.5), (1.5, 1.0)):
        faces *= 1 - ((one - other) / (one + other)) ** 2
    return (3.45e-6) ** 2 * 0.9 * faces * math.pi / 4 / working_f_number**2 * 10_000 * 0.010


@cache
def against_photons(n: int = N_PHOTONS) -> tuple[Seen, ...]:
    """All cases in single scattering."""
    found = []
    for seed, case in enumerate(CASES):
        told = common.figures(case.mission(), case.system())
        scale = electrons_per_gain(case, told["working_f_number"])
        mean, error = photons.mean_veil(case, n, seed)
        found.append(
            Seen(case, scale * mean, scale * error, told["electrons_backscatter"], told["electrons_signal"])
        )
    return tuple(found)


class Orders(NamedTuple):
    """One case with more than one scattering, in electrons of the image's mean."""

    case: Setting
    uwopt_e: float
    all_e: float
    error_e: float
    diffuse_e: float  # single scattering, K on both legs


@cache
def all_orders() -> tuple[Orders, ...]:
    """Some cases with every order of scattering."""
    found = []
    for index in MULTIPLE:
        case, told = CASES[index], common.figures(CASES[index].mission(), CASES[index].system())
        scale = electrons_per_gain(case, told["working_f_number"])
        mean, error = photons.mean_veil(case, N_MULTIPLE, 100 + index, orders=MOST_ORDERS, kind="transport")
        diffuse, _ = photons.mean_veil(case, N_MULTIPLE, 200 + index, kind="diffuse")
        found.append(
            Orders(case, told["electrons_backscatter"], scale * mean, scale * error, scale * diffuse)
        )
    return tuple(found)


# ---------------------------------------------------------------- the ray by adaptive quadrature

THICKNESSES = (1e-6, 0.01, 1.0, 10.0, 100.0, 2000.0)  # c times altitude
BASELINES_M = (0.02, 0.1, 0.5, 2.0, 5.0)
ALTITUDES_M = (0.05, 0.5, 5.0, 50.0)
FIELDS = ((0.0, 0.0), (0.4, -0.5))  # tangents in air: the axis, and a corner away from the lamp
LOBES_DEG = (30.0, 80.0, 110.0, 140.0)  # full width at half power
K_SHARE = 0.6  # K over c
GAP_M, GLASS_M, N_GLASS, N_WATER = 0.02, 0.01, 1.5, 1.34


def phase(cos: Any) -> Any:
    """Henyey-Greenstein, g = 0.9, plus a tenth that is isotropic."""
    return 0.9 * 0.19 / (4 * np.pi) / (1.81 - 1.8 * cos) ** 1.5 + 0.1 / (4 * np.pi)


def log_by_quadrature(
    field: tuple[float, float], altitude_m: float, baseline_m: float, thickness: float, lobe_deg: float
) -> float:
    """ln of the veil of one ray: QUADPACK in r, piece by piece where the integrand is not negligible."""
    u, v = field
    air = math.hypot(u, v)
    theta = math.atan(air)
    glass, water = (math.asin(math.sin(theta) / n) for n in (N_GLASS, N_WATER))
    out_m = GAP_M * math.tan(theta) + GLASS_M * math.tan(glass)
    toward = np.array([u, v]) / max(air, 1e-300)
    start = np.array([*(out_m * toward), 0.0])
    way = np.array([*(math.sin(water) * toward), math.cos(water)])
    length, c = altitude_m / math.cos(water), thickness / altitude_m
    m = math.log(0.5) / math.log(math.cos(math.radians(lobe_deg) / 2))
    lamp = np.array([0.0, baseline_m, 0.0])

    def log_integrand(r: Any) -> Any:
        ray = start + np.multiply.outer(r, way) - lamp
        square = (ray * ray).sum(axis=-1)
        s = np.sqrt(square)
        cos_lobe = np.maximum(ray[..., 2] / s, 1e-300)
        return m * np.log(cos_lobe) - np.log(square) + np.log(phase(-(ray @ way) / s)) - c * (K_SHARE * s + r)

    near = float((lamp - start) @ way)
    scale = float(np.linalg.norm(lamp - start - near * way))
    knots = np.concatenate([
        np.geomspace(1e-12 * length, length, 120), near + scale * np.sinh(np.linspace(-12, 12, 97)), [0.0],
    ])  # fmt: skip
    knots = np.unique(knots[(knots >= 0) & (knots <= length)])
    level = log_integrand(0.5 * (knots[1:] + knots[:-1])) + np.log(np.diff(knots))
    top = float(level.max())
    total = 0.0
    for low, high, high_level in zip(knots[:-1], knots[1:], level, strict=True):
        if high_level > top - 40:
            total += quad(lambda r: math.exp(log_integrand(r) - top), low, high, epsabs=0.0, epsrel=1e-9)[0]
    return math.log(total) + top + math.log((m + 1) / (2 * math.pi)) - 2 * math.log1p(air * air)


def log_by_uwopt(
    field: tuple[float, float], altitude_m: float, baseline_m: float, thickness: float, lobe_deg: float
) -> float:
    """The same from uwopt, loss table included."""
    from uwopt.model import beam
    from uwopt.model.imaging import Lamps, PortShape
    from uwopt.model.path_table import build_path_table
    from uwopt.model.veil.geometry import Scatterer, path_ranges_m
    from uwopt.model.veil.ray import log_backscatter_gain

    shape = PortShape(False, 0.0, GLASS_M, N_GLASS, GAP_M, N_WATER)
    lamps = Lamps((0.0,), (baseline_m,), (0.0,), ((0.0, 0.0, 1.0),), (1.0,))
    c = thickness / altitude_m
    corner = np.array([max(abs(field[0]), 0.1)]), np.array([max(abs(field[1]), 0.1)])
    lamp_m, camera_m = path_ranges_m(
        *corner, shape=shape, range_m=altitude_m, lamps=lamps, least_attenuation_per_m=(K_SHARE * c, c)
    )
    table = build_path_table(
        np.ones(1), wavelength_nm=None, k_lamp_per_m=np.array([K_SHARE * c]), c_camera_per_m=np.array([c]),
        lamp_range_m=lamp_m, camera_range_m=camera_m,
    )  # fmt: skip
    return float(
        log_backscatter_gain(
            np.array([field[0]]), np.array([field[1]]), shape=shape, range_m=altitude_m, lamps=lamps,
            beam=beam.cosine_power_beam(math.radians(lobe_deg)), scatterers=(Scatterer(phase, table),),
        )[0]
    )  # fmt: skip


@cache
def quadrature_errors() -> dict[tuple[float, float, float, float], float]:
    """Largest |difference of ln| over fields, by c d, baseline, altitude and lobe."""
    found = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # QUADPACK grumbles at pieces that are smooth to rounding
        for thickness, baseline, altitude, lobe in product(THICKNESSES, BASELINES_M, ALTITUDES_M, LOBES_DEG):
            at = altitude, baseline, thickness, lobe
            found[thickness, baseline, altitude, lobe] = max(
                abs(log_by_uwopt(f, *at) - log_by_quadrature(f, *at)) for f in FIELDS
            )
    return found


def worst_of(**fixed: float) -> float:
    """Largest error over all that is not fixed."""
    names = ("thickness", "baseline", "altitude", "lobe")
    return max(
        error
        for at, error in quadrature_errors().items()
        if all(value == fixed.get(name, value) for name, value in zip(names, at, strict=True))
    )


# ---------------------------------------------------------------- the section


def figure() -> str:
    """Differences with error bars."""
    figure, axes = common.canvas(height=2.8, width=7.0)
    for y, seen in enumerate(reversed(against_photons())):
        axes.errorbar(100 * seen.difference, y, xerr=200 * seen.sigma, fmt="o", color="C0", ms=4, capsize=3)
    axes.axvline(0.0, color="0.5", lw=0.8)
    names = [f"{s.case.name} ({s.case.water})" for s in reversed(against_photons())]
    axes.set_yticks(range(len(names)), names)
    axes.set(xlabel="uwopt over Monte Carlo − 1 [%], bars: two standard errors")
    return common.save(figure, "backscatter", "Backscatter: uwopt against Monte Carlo of single scattering")


def photon_rows(of: tuple[Seen, ...]) -> list[list[str]]:
    """Cases in words."""
    return [
        [
            s.case.name, s.case.water, f"{s.case.altitude:g} m", f"{s.photons_e:.4g} ± {s.error_e:.1g}", f"{s.uwopt_e:.4g}",
            common.percent(s.difference, 2), f"{s.difference / s.sigma:+.1f}", f"{s.uwopt_e / s.signal_e:.3g}",
        ]
        for s in of
    ]  # fmt: skip


def quadrature_text() -> str:
    """The tables over c d, baseline, altitude and lobe."""
    lobe_rows = [
        [f"{t:g}", *(common.small(worst_of(thickness=t, lobe=lobe)) for lobe in LOBES_DEG)]
        for t in THICKNESSES
    ]
    narrow = LOBES_DEG[:2]
    rows = [
        [f"{t:g}", *(common.small(max(worst_of(thickness=t, baseline=b, lobe=x) for x in narrow)) for b in BASELINES_M)]
        for t in THICKNESSES
    ]  # fmt: skip
    high = [
        [f"{a:g} m", *(common.small(max(worst_of(altitude=a, baseline=b, lobe=x) for x in narrow)) for b in BASELINES_M)]
        for a in ALTITUDES_M
    ]  # fmt: skip
    (t, b, a, lobe), worst = max(quadrature_errors().items(), key=lambda item: item[1])
    baselines = [f"baseline {b:g} m" for b in BASELINES_M]
    seen = max(worst_of(thickness=x) for x in THICKNESSES if x <= 10)
    return f"""\
**The ray integral against QUADPACK.** ln of the veil of one ray by `log_backscatter_gain` (with its loss table)
against adaptive quadrature in r, written here with its own rays: {len(quadrature_errors()) * len(FIELDS)} rays, on the
axis and at a corner, lamp in the port's plane, grey water with K = {K_SHARE} c, Henyey–Greenstein with an even part.
Largest relative error by c d and full width of the lobe, over all baselines and altitudes:

{common.table(["c d", *(f"lobe {x:g}°" for x in LOBES_DEG)], lobe_rows)}

By c d and baseline, lobes up to {narrow[-1]:g}°:

{common.table(["c d", *baselines], rows)}

By altitude and baseline, lobes up to {narrow[-1]:g}°, all c d:

{common.table(["altitude", *baselines], high)}

Largest of all: {common.small(worst)} (c d = {t:g}, baseline {b:g} m, altitude {a:g} m, lobe {lobe:g}°); up to c d = 10 {common.small(seen)}.

**What falls short:** the docstring of `backscatter_gain` says 1e-4 or less. Lobes of 110° and wider miss it from
c d = 10 on, the widest already in thin water, and in very thick water lobes of 80° do: a ray that starts in the lamp's
front plane begins where cos^m has a root that is no polynomial, and thick water leaves only that beginning.
"""


def multiple_text() -> str:
    """What single scattering leaves out."""
    rows = [
        [
            s.case.name, s.case.water, f"{s.all_e:.4g} ± {s.error_e:.1g}", f"{s.uwopt_e:.4g}",
            common.percent(s.uwopt_e / s.all_e - 1, 0), f"{s.diffuse_e:.4g}", common.percent(s.diffuse_e / s.all_e - 1, 0),
        ]
        for s in all_orders()
    ]  # fmt: skip
    off = [s.uwopt_e / s.all_e - 1 for s in all_orders()]
    diffuse = [s.diffuse_e / s.all_e - 1 for s in all_orders()]
    head = [
        "case",
        "water",
        "all orders [e⁻]",
        "uwopt [e⁻]",
        "difference",
        "K on both legs [e⁻]",
        "difference",
    ]
    return f"""\
**What falls short: light scattered more than once.** The same photons followed through up to {MOST_ORDERS} scatterings, c on
every leg, floor black, {N_MULTIPLE} photons a case; what turns by less than {photons.AHEAD_DEG:g}° counts as not scattered (an image mean
hardly feels so small a turn; half of that angle gave the same within the scatter). The tally has a long tail, light that
turns forward right before the port, so that ± is rather a lower estimate. Beside it single scattering with K in place of c on the camera's leg:

{common.table(head, rows)}

Single scattering (`multiple_scattering: false`) is {common.percent(min(off), 0)} to {common.percent(max(off), 0)} off: light that is
scattered forward on its way back still arrives, and c counts it as lost. With K on both legs the veil would be
{common.percent(min(diffuse), 0)} to {common.percent(max(diffuse), 0)} off in these cases. What is counted by default is in section 10.
"""


def section() -> str:
    """The text."""
    seen = against_photons()
    head = [
        "case",
        "water",
        "altitude",
        "Monte Carlo [e⁻]",
        "uwopt [e⁻]",
        "difference",
        "in σ",
        "veil / signal",
    ]
    worst = max(seen, key=lambda s: abs(s.difference))
    chi = sum((s.difference / s.sigma) ** 2 for s in seen)
    off = [s.uwopt_e / s.all_e - 1 for s in all_orders()]
    return f"""\
**In short:** as defined (single scattering) within {100 * abs(worst.difference):.1f} % of photons, {abs(worst.difference) / worst.sigma:.1f} σ; the ray integral within {common.small(max(quadrature_errors().values()))} of adaptive quadrature; but {common.percent(min(off), 0)} to {common.percent(max(off), 0)} against all orders of scattering.

Independent of: uwopt's ray integral, path tables, phase-function tables and spectra. Photons leave the lamp, collide,
and each collision is tallied where it falls in the image (`docs/validation/photons.py`); wavelengths, a, b, K_d, K,
phase functions (own Fournier–Forand; Petzold's points joined by straight lines in log-log) and port rays are worked out
there. Shared: the tables that ship, the working f-number, and the assumption under test in neither: single scattering,
K on the lamp's leg. `electrons_backscatter` of `uwopt evaluate`, mean over the image; {N_PHOTONS} photons a case.

{common.table(head, photon_rows(seen))}

{figure()}

Largest difference {common.percent(worst.difference, 2)} ({worst.case.name}, {worst.difference / worst.sigma:+.1f} σ); the sum of squares in
σ is {chi:.1f} for {len(seen)} cases. ± is one standard error, from {photons.BATCHES} batches.

{quadrature_text()}
{multiple_text()}"""

# ruff: noqa: E501 - a line of the page's text is as long as the expressions in it
"""Section 4: four tilted lamps with a measured beam, against a plain sum over the floor."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from . import common

CELLS = 600  # a side of the footprint; a multiple of 60
FLUX_LM = 10_000.0  # of each lamp
N_WATER_AT = 550.0
Mounts = tuple[tuple[float, float, float, float], ...]  # x, y [m], outward tilts along x and y [deg]
CASES: dict[str, tuple[str, str, float, Mounts]] = {
    "four corners, 15° outward": (
        "II", "flood", 2.0, tuple((x, y, 15.0, 15.0) for x in (-0.4, 0.4) for y in (-0.6, 0.6)),
    ),
    "four in a row, 0–20° outward": (
        "III", "flood", 3.0, ((0.0, -0.9, 0.0, 20.0), (0.0, -0.3, 0.0, 5.0), (0.0, 0.3, 0.0, 5.0), (0.0, 0.9, 0.0, 20.0)),
    ),
    "four corners, 10° inward, spot": (
        "I", "spot", 4.0, tuple((x, y, -10.0, -10.0) for x in (-0.8, 0.8) for y in (-0.8, 0.8)),
    ),
    "four, all unlike, spot": (
        "1C", "spot", 1.5, ((0.3, 0.5, 25.0, 0.0), (-0.5, 0.4, 0.0, 10.0), (0.1, -0.7, -5.0, 20.0), (-0.2, -0.3, 12.0, -8.0)),
    ),
}  # fmt: skip


def system(kind: str, mounts: Mounts) -> dict[str, Any]:
    """A dome of 0.1 m, IMX250, 8 mm, four lamps."""
    return {
        "camera": "seed-imx250m", "lens": {"focal_length_mm": 8, "transmission": 0.9},
        "port": {"geometry": "dome", "outer_radius_mm": 100, "thickness_mm": 10, "refractive_index": 1.5},
        "light": {
            "flux_lm": FLUX_LM, "power_w": 100, "spectrum": "generic-led", "beam": "tabulated",
            "beam_profile": f"dspl-sealite-{kind}", "beam_medium": "air",
        },
        "light_mounts": [{"x_m": x, "y_m": y, "tilt_x_deg": a, "tilt_y_deg": b} for x, y, a, b in mounts],
        "settings": {"f_number": 4.0, "exposure_ms": 1.0, "gain": 1.0, "flux_lm": FLUX_LM * len(mounts)},
    }  # fmt: skip


def mission(water: str, altitude_m: float) -> dict[str, Any]:
    """Physics full over a floor of 0.2."""
    return {
        "name": "lamps", "physics": "full",
        "scene": {"water": water, "water_table": "solonenko-mobley", "seafloor": 0.2, "depth_m": 50},
        "vehicle": {"altitude_m": altitude_m, "speed_m_s": 0.0}, "requirements": {"frame_interval_s": 1.0},
    }  # fmt: skip


@cache
def profile_in_water(kind: str) -> tuple[Any, float]:
    """Intensity by the angle in water, any unit, and its flux: I_w = I_a n^2 cos w / cos a, by quadrature."""
    angle, value = common.column(
        "beam_profiles.csv", "angle_deg", "intensity", profile_id=f"dspl-sealite-{kind}"
    )
    in_air = PchipInterpolator(np.deg2rad(angle), value, extrapolate=False)
    n = float(np.interp(N_WATER_AT, common.WAVES_NM, common.index_of_water(10.0, 35.0)))

    def intensity(water_rad: np.ndarray) -> np.ndarray:
        sine = n * np.sin(water_rad)
        air = np.arcsin(np.minimum(sine, 1.0))
        raised = n * n * np.cos(water_rad) / np.maximum(np.cos(air), 1e-9)
        at_80 = float(in_air(math.radians(80.0))) / math.cos(math.radians(80.0))
        found = np.minimum(
            np.nan_to_num(in_air(air), nan=0.0),
            np.where(air > math.radians(80.0), at_80 * np.cos(air), np.inf),
        )
        return np.where(sine < 1.0, found * raised, 0.0)

    w = np.linspace(0.0, math.asin(1 / n), 400_001)[:-1]  # midpoints: the rim itself is not defined
    w = w + 0.5 * (w[1] - w[0])
    return intensity, float(2 * np.pi * (intensity(w) * np.sin(w)).sum() * (w[1] - w[0]))


def by_uwopt(mission: dict[str, Any], system: dict[str, Any]) -> dict[str, float]:
    """The figures of illuminance that `evaluate` reports, without waiting for its veils."""
    from uwopt.api.common import prepared
    from uwopt.api.evaluating import scene_settings
    from uwopt.evaluation.design_model import DesignModel
    from uwopt.evaluation.figures_by_name import illuminance
    from uwopt.forward.assembly import system_problem
    from uwopt.mission.system import load_system
    from uwopt.model.effects import Effects

    wanted, built = prepared(mission, None, None), load_system(system)
    problem, hardware = system_problem(wanted, built)
    model = DesignModel(problem.with_effects(Effects.none()), hardware)
    given = scene_settings(problem, hardware, built, problem.scenes[0].name)
    return illuminance(model, 0, model.settings(0, given))


def by_sum(water: str, kind: str, altitude_m: float, mounts: Mounts) -> tuple[float, float, float]:
    """Mean and least illuminance of the footprint [lx], and the least on a grid of 60 cells a side.

    Every point of a grid that includes the edges, every lamp, the spectrum in 1 nm steps.
    """
    half_x, half_y = ((altitude_m + 0.1) * px * 3.45e-6 / 16e-3 for px in (2048, 2448))
    steps = np.linspace(-1, 1, CELLS + 1)
    x, y = np.meshgrid(half_x * steps, half_y * steps, indexing="ij")
    a, b, kd = common.jerlov(water)
    k = np.clip(kd, a + 0.0183 * b, a + b)
    seen = common.photopic() * common.led()
    seen = seen / seen.sum()
    reach = np.linspace(altitude_m, altitude_m * 3 + 3, 400)
    left = np.log(np.exp(-np.multiply.outer(reach, k)) @ seen)
    intensity, flux = profile_in_water(kind)
    fine = np.linspace(0.0, np.pi / 2, 40_001)
    curve = intensity(fine) * FLUX_LM / flux
    total = np.zeros_like(x)
    for at_x, at_y, tilt_x, tilt_y in mounts:
        aim = np.array([
            math.copysign(1, at_x or 1.0) * math.tan(math.radians(tilt_x)),
            math.copysign(1, at_y or 1.0) * math.tan(math.radians(tilt_y)), 1.0,
        ])  # fmt: skip
        aim /= np.linalg.norm(aim)
        dx, dy = x - at_x, y - at_y
        r = np.sqrt(dx * dx + dy * dy + altitude_m**2)
        off = np.arccos(np.clip((dx * aim[0] + dy * aim[1] + altitude_m * aim[2]) / r, -1, 1))
        total += np.interp(off, fine, curve) * altitude_m / r**3 * np.exp(np.interp(r, reach, left))
    edge = np.ones(CELLS + 1)
    edge[[0, -1]] = 0.5  # trapezoid rule
    mean = float(edge @ total @ edge) / CELLS**2
    return mean, float(total.min()), float(total[:: CELLS // 60, :: CELLS // 60].min())


def section() -> str:
    """The text."""
    rows, means, leasts, coarse = [], [], [], []
    for name, (water, kind, altitude, mounts) in CASES.items():
        told = by_uwopt(mission(water, altitude), system(kind, mounts))
        mean, least, least_60 = by_sum(water, kind, altitude, mounts)
        means.append(told["floor_illuminance_mean_lx"] / mean - 1)
        leasts.append(told["floor_illuminance_min_lx"] / least - 1)
        coarse.append(told["floor_illuminance_min_lx"] / least_60 - 1)
        rows.append([
            name, f"{water}, {altitude:g} m", f"{mean:.5g}", f"{told['floor_illuminance_mean_lx']:.5g}",
            common.percent(means[-1], 3), f"{least:.4g}", f"{told['floor_illuminance_min_lx']:.4g}",
            common.percent(leasts[-1], 2), f"{told['uniformity']:.4f}",
        ])  # fmt: skip
    head = [
        "lamps",
        "water, altitude",
        "mean, sum [lx]",
        "mean, uwopt [lx]",
        "diff.",
        "least, sum",
        "least, uwopt",
        "diff.",
        "uniformity",
    ]
    return f"""\
**In short:** mean illuminance within {100 * max(map(abs, means)):.3f} %; least illuminance within {100 * max(map(abs, leasts)):.2g} %.

Independent of: uwopt's beam look-up, its bending of a profile from air to water, its quadratures and loss tables. The
DSPL Sealite profile is read from `beam_profiles.csv`, joined by a monotone cubic, bent by
I_w = I_a n_w² cos θ_w / cos θ_a, scaled to {FLUX_LM:.0f} lm a lamp by its own integral, and summed over {CELLS}² cells of the
footprint, spectrum in 1 nm steps. Shared: the tables, the interpolation rule, K, and that beyond 80° in air an
intensity falls at least with the cosine (else the division by cos θ_a blows up the digitiser's noise).

{common.table(head, rows)}

Largest difference of the mean {common.percent(common.farthest(means), 3)}; of the least illuminance {common.percent(common.farthest(leasts), 2)}.
On a grid of 60 cells a side alone the least of the sum would differ by up to {common.percent(common.farthest(coarse), 2)}:
a beam that ends at a window's critical angle leaves narrow dark wedges between lamps, which uwopt follows down from the
lowest points of its grid.

What falls short: the profile's medium is not stated by its source (air assumed).
"""

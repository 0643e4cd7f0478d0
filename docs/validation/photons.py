"""A Monte Carlo of lamp light in water, for section 3: photons from lamps, collisions, a tally in the image.

Own geometry, phase functions and spectra; of uwopt it uses nothing. A photon packet leaves the lamp at an angle
drawn from its lobe, at a wavelength drawn from what the sensor detects of the lamp, and collides after a drawn
distance. From each collision the share that goes straight into the pupil is added to the image's mean.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from . import common

Array = common.Array
BATCHES = 20
AHEAD_DEG = 10.0  # in full transport, what is scattered by less than this counts as not scattered
LEAST_WEIGHT = 1e-3  # packets fainter than this survive by a draw, so that nothing is lost on average


@dataclass(frozen=True)
class Setting:
    """One scene; lengths in m, angles in degrees."""

    name: str
    water: str
    altitude: float
    lamp_x: float
    lamp_y: float
    tilt_y: float = 0.0  # outward
    half_angle: float = 40.0  # at half power, in water
    dome: float | None = 0.07  # outer radius; None: flat
    focal_mm: float = 8.0
    petzold: str | None = None

    def mission(self) -> dict[str, Any]:
        """For uwopt."""
        scene: dict[str, Any] = {
            "water": self.water, "water_table": "solonenko-mobley", "seafloor": 0.2, "depth_m": 50,
            "multiple_scattering": False,
        }  # fmt: skip
        if self.petzold:
            scene["phase_function"] = f"petzold-{self.petzold.casefold().replace(' ', '-')}"
        return {
            "name": self.name, "physics": "full", "scene": scene,
            "vehicle": {"altitude_m": self.altitude, "speed_m_s": 0.0},
            "requirements": {"frame_interval_s": 1.0},
        }  # fmt: skip

    def system(self) -> dict[str, Any]:
        """For uwopt."""
        port: dict[str, Any] = {"thickness_mm": 5, "refractive_index": 1.5, "geometry": "flat", "gap_mm": 20}
        if self.dome:
            port = port | {"geometry": "dome", "outer_radius_mm": 1e3 * self.dome}
            del port["gap_mm"]
        return {
            "camera": {
                "resolution_x_px": 2448, "resolution_y_px": 2048, "pixel_pitch_um": 3.45, "read_noise_e": 2.4,
                "quantum_efficiency": "seed-imx250m", "gain_dn_per_e": 0.35, "bit_depth": 12,
            },
            "lens": {"focal_length_mm": self.focal_mm, "transmission": 0.9},
            "port": port,
            "light": {
                "flux_lm": 10_000, "power_w": 100, "spectrum": "generic-led", "beam": "cosine-power",
                "beam_half_angle_deg": self.half_angle,
            },
            "light_mounts": [{"x_m": self.lamp_x, "y_m": self.lamp_y, "tilt_y_deg": self.tilt_y}],
            "settings": {"f_number": 4.0, "exposure_ms": 10.0, "gain": 1.0, "flux_lm": 10_000},
        }  # fmt: skip


# ---------------------------------------------------------------- the water


class Phase:
    """A phase function on a fine grid of angles: values, and angles drawn from it."""

    def __init__(self, angle: Array, values: Array):
        self.angle, self.log = angle, np.log(values)
        mass = 0.5 * (values[1:] * np.sin(angle[1:]) + values[:-1] * np.sin(angle[:-1])) * np.diff(angle)
        self.total = 2 * np.pi * float(mass.sum())
        self.cumulative = np.r_[0.0, np.cumsum(mass)] / mass.sum()

    def __call__(self, cos: Array) -> Array:
        """Share per steradian."""
        at = np.arccos(np.clip(cos, -1.0, 1.0))
        return np.where(at < self.angle[0], 0.0, np.exp(np.interp(at, self.angle, self.log))) / self.total

    def beyond(self, angle: float) -> tuple[Phase, float]:
        """The part that goes beyond an angle, and its share."""
        keep = self.angle >= angle
        rest = Phase(self.angle[keep], np.exp(self.log[keep]))
        return rest, rest.total / self.total

    def draw(self, rng: np.random.Generator, n: int) -> Array:
        """Cosines of n scattering angles."""
        return np.cos(np.interp(rng.random(n), self.cumulative, self.angle))


FINE = np.r_[np.geomspace(1e-6, 0.1, 3000), np.linspace(0.1, np.pi, 6000)[1:]]


def fournier_forand(ratio: float) -> Phase:
    """Fournier and Jonasz's (1999) form, index and slope on the line of Mobley et al. (2002), for a wanted b_b/b."""

    def delta(sin2: Any, n: float) -> Any:
        return 4.0 * sin2 / (3.0 * (n - 1.0) ** 2)

    def excess(mu: float) -> float:
        n, nu = 1.01 + 0.1542 * (mu - 3), (3 - mu) / 2
        d = delta(0.5, n)
        return float(1 - (1 - d ** (nu + 1) - 0.5 * (1 - d**nu)) / ((1 - d) * d**nu) - ratio)

    mu = brentq(excess, 3.1, 4.9)
    n, nu = 1.01 + 0.1542 * (mu - 3), (3 - mu) / 2
    s2 = np.sin(FINE / 2) ** 2
    d, d180 = delta(s2, n), delta(1.0, n)
    d = np.where(np.abs(d - 1) < 1e-4, 1 + 1e-4, d)
    first = (nu * (1 - d) - (1 - d**nu) + (d * (1 - d**nu) - nu * (1 - d)) / s2) / (
        4 * np.pi * (1 - d) ** 2 * d**nu
    )
    back = (1 - d180**nu) / (16 * np.pi * (d180 - 1) * d180**nu) * (3 * np.cos(FINE) ** 2 - 1)
    return Phase(FINE, first + back)


def petzold(station: str) -> Phase:
    """A measured station: straight lines in log-log between the printed angles, level beyond the last."""
    import jerlov

    found = jerlov.petzold_scattering(station)
    angle = np.deg2rad(np.asarray(found.angles_deg, float))
    vsf = np.log(np.asarray(found.phase_function(), float))
    first = angle[angle > 0][0]
    slope = (vsf[1] - vsf[0]) / np.log(angle[1] / angle[0])
    inside = np.interp(np.log(FINE), np.log(angle), vsf)
    return Phase(FINE, np.exp(np.where(first > FINE, vsf[0] + slope * np.log(FINE / first), inside)))


class Water(NamedTuple):
    """By wavelength [1/m], and where scattered light goes."""

    k: Array
    c: Array
    b_particles: Array
    b_water: Array
    particles: Phase


def water_of(case: Setting, *, kind: str = "single") -> Water:
    """Tables of a case: K_d held between a + b_b and c, molecules apart from particles.

    `single`: K on the lamp's leg, c on the camera's; `diffuse`: K on both; `transport`: for all orders, with
    what is scattered by less than AHEAD_DEG taken as not scattered, in the phase function and in c.
    """
    water = tables_of(case)
    if kind == "diffuse":
        return water._replace(c=water.k)
    if kind == "transport":
        rest, share = water.particles.beyond(np.deg2rad(AHEAD_DEG))
        lost = water.b_particles * (1 - share)
        c = water.c - lost
        return Water(c, c, water.b_particles - lost, water.b_water, rest)
    return water


def tables_of(case: Setting) -> Water:
    """The tables as they are."""
    a, b, kd = common.jerlov(case.water)
    k = np.minimum(np.maximum(kd, a + 0.0183 * b), a + b)
    if case.petzold:  # measured with the water in it
        return Water(k, a + b, b, np.zeros_like(b), petzold(case.petzold))
    b_w = np.minimum(common.pure_water("bw_zhang2009_S35_T20_per_m"), b)
    return Water(k, a + b, b - b_w, b_w, fournier_forand(0.0183))


def molecules(cos: Array) -> Array:
    """Zhang, Hu and He's scattering by water, depolarisation 0.039."""
    f = (1 - 0.039) / (1 + 0.039)
    return 3 / (4 * np.pi * (3 + f)) * (1 + f * cos * cos)


# ---------------------------------------------------------------- the camera


class Seen(NamedTuple):
    """How the camera sees points in the water."""

    share: Array  # of light scattered towards it, as mean of L cos^4 over the image, without phase and loss [1/m^2]
    path_m: Array
    to_x: Array  # unit direction from the point into the port
    to_y: Array
    to_z: Array


def refracted(tangent: Array, n: float) -> Array:
    """Tangent behind a plane face."""
    sine = tangent / np.sqrt(1 + tangent**2) / n
    return sine / np.sqrt(1 - sine**2)


def camera_sees(case: Setting, n_water: float, x: Array, y: Array, z: Array) -> Seen:
    """Projects points into the image; what lies outside it, or in the dome, has no share."""
    rho = np.maximum(np.hypot(x, y), 1e-9)
    if case.dome:
        t = rho / (z + case.dome)
        bent, jacobian = t, (z + case.dome) ** 2
        path = np.hypot(rho, z + case.dome) - case.dome
    else:
        e, g = 0.020, 0.005
        t = rho / (e + g / 1.5 + z / n_water)
        for _ in range(6):
            step = 1e-6
            here, there = (e * u + g * refracted(u, 1.5) + z * refracted(u, n_water) for u in (t, t + step))
            t = np.maximum(t - (here - rho) / ((there - here) / step), 1e-9)
        slope = (e * step + g * (refracted(t + step, 1.5) - refracted(t, 1.5))
                 + z * (refracted(t + step, n_water) - refracted(t, n_water))) / step  # fmt: skip
        bent, jacobian = refracted(t, n_water), rho / t * slope
        path = z * np.sqrt(1 + bent**2)
    half_x, half_y = (px * 3.45e-6 / (2 * case.focal_mm * 1e-3) for px in (2048, 2448))
    inside = (np.abs(x) * t <= half_x * rho) & (np.abs(y) * t <= half_y * rho) & (z > 0) & (path > 0)
    secant = np.sqrt(1 + bent**2)
    share = np.where(inside, secant / ((1 + t * t) ** 2 * jacobian * 4 * half_x * half_y), 0.0)
    sine = bent / secant
    return Seen(share, path, -sine * x / rho, -sine * y / rho, -1 / secant)


# ---------------------------------------------------------------- photons


def turned(direction: Array, cos: Array, rng: np.random.Generator) -> Array:
    """Directions (3, n) after a scattering by the given cosines, azimuth drawn."""
    phi = 2 * np.pi * rng.random(cos.size)
    sine = np.sqrt(np.maximum(1 - cos * cos, 0.0))
    helper = np.where(
        np.abs(direction[2]) < 0.9, np.array([[0.0], [0.0], [1.0]]), np.array([[1.0], [0.0], [0.0]])
    )
    first = np.cross(direction, helper, axis=0)
    first /= np.linalg.norm(first, axis=0)
    second = np.cross(direction, first, axis=0)
    out = cos * direction + sine * (np.cos(phi) * first + np.sin(phi) * second)
    return np.asarray(out / np.linalg.norm(out, axis=0))


def detected() -> Array:
    """Electrons per joule at the port times the lamp's watts per lumen, per nm, over n_w^2."""
    index = common.index_of_water(10.0, 35.0)
    per_joule = common.efficiency("seed-imx250m") * common.WAVES_NM * 1e-9
    per_joule = per_joule / (common.PLANCK_J_S * common.LIGHT_M_S)
    return np.asarray(common.led() * per_joule / index**2 * common.STEPS_NM)


def mean_veil(
    case: Setting, n: int, seed: int, *, orders: int = 1, kind: str = "single"
) -> tuple[float, float]:
    """Mean over the image of the veil's detected radiance times cos^4, per lumen; and its standard error."""
    rng = np.random.default_rng(seed)
    water, weight = water_of(case, kind=kind), detected()
    n_water = float(np.interp(550.0, common.WAVES_NM, common.index_of_water(10.0, 35.0)))
    size = n // BATCHES
    results = [one_batch(case, water, weight, n_water, size, rng, orders) for _ in range(BATCHES)]
    mean = float(np.mean(results))
    return mean, float(np.std(results, ddof=1) / np.sqrt(BATCHES))


def one_batch(
    case: Setting, water: Water, weight: Array, n_water: float, n: int, rng: np.random.Generator, orders: int
) -> float:
    """n photons."""
    nm = np.searchsorted(np.cumsum(weight) / weight.sum(), rng.random(n))
    exponent = np.log(0.5) / np.log(np.cos(np.deg2rad(case.half_angle)))
    outward = 1.0 if case.lamp_y >= 0 else -1.0
    aim = np.array([0.0, outward * np.tan(np.deg2rad(case.tilt_y)), 1.0])
    aim = np.repeat((aim / np.linalg.norm(aim))[:, None], n, axis=1)
    direction = turned(aim, rng.random(n) ** (1 / (exponent + 1)), rng)
    place = np.repeat(np.array([[case.lamp_x], [case.lamp_y], [0.0]]), n, axis=1)
    power = np.full(n, weight.sum())
    total = 0.0
    for order in range(orders):
        mu = water.k[nm]
        to_floor = np.where(
            direction[2] > 1e-6, (case.altitude - place[2]) / np.maximum(direction[2], 1e-6), 30.0
        )
        reach = np.minimum(to_floor, 30.0)
        meets = -np.expm1(-mu * reach)  # the packet is made to collide before the floor
        path = -np.log1p(-rng.random(mu.size) * meets) / mu
        place, power = place + path * direction, power * meets / mu
        seen = camera_sees(case, n_water, *place)
        there = seen.share > 0
        at, cos = nm[there], direction[0] * seen.to_x + direction[1] * seen.to_y + direction[2] * seen.to_z
        cos = cos[there]
        spread = water.b_particles[at] * water.particles(cos) + water.b_water[at] * molecules(cos)
        total += float(
            (power[there] * spread * seen.share[there] * np.exp(-water.c[at] * seen.path_m[there])).sum()
        )
        if order == orders - 1:
            break
        power = power * (water.b_particles + water.b_water)[nm]
        keep = (place[2] > 0) & (rng.random(power.size) < power / (LEAST_WEIGHT * weight.sum()))
        power = np.maximum(power, LEAST_WEIGHT * weight.sum())[keep]
        nm, place, direction = nm[keep], place[:, keep], direction[:, keep]
        by_water = rng.random(nm.size) * (water.b_particles + water.b_water)[nm] < water.b_water[nm]
        evenly = (
            2 * rng.random(nm.size) - 1
        )  # molecules: drawn from the whole sphere, weighed by their function
        cos = np.where(by_water, evenly, water.particles.draw(rng, nm.size))
        power = np.where(by_water, power * 4 * np.pi * molecules(evenly), power)
        direction = turned(direction, cos, rng)
    return total / n

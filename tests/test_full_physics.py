"""Physics `full`, through `uwopt.evaluate`, against a second computation written for this test.

The second computation follows the physics page from the tables that ship: rays, spectra and the integral over
the image by brute force in NumPy, every wavelength at every point. It uses nothing of uwopt but those tables.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq, minimize_scalar

import uwopt

Array = NDArray[np.float64]
DATA = Path(__file__).parents[1] / "uwopt" / "catalog" / "data"
WAVES_NM = np.arange(380.0, 780.25, 0.5)  # finer than uwopt's own grid
STEPS_NM = np.r_[0.25, np.full(WAVES_NM.size - 2, 0.5), 0.25]
PLANCK_J_S, LIGHT_M_S, LUMENS_PER_W = 6.62607015e-34, 299_792_458.0, 683.002
RAYS_NM = 550.0  # rays are traced for green light
SMOOTH = 1e-4  # what a mean over the image is good for where beams have no edge
SHARP = 1e-3  # the same where beams end sharply


# ---------------------------------------------------------------- a case


@dataclass(frozen=True)
class Lamp:
    """Place [m] in the vehicle frame and outward tilts [deg]."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    tilt_x: float = 0.0
    tilt_y: float = 0.0


@dataclass(frozen=True)
class Case:
    """A mission and a system; lengths in m, focal length in mm, angles in degrees."""

    water: str = "II"
    table: str = "solonenko-mobley"
    floor: float | str = 0.2
    altitude: float = 2.0
    temperature: float = 10.0
    salinity: float = 35.0
    dome: bool = True
    radius: float = 0.1
    thickness: float = 0.01
    n_glass: float = 1.5
    gap: float = 0.02
    focal_mm: float = 8.0
    f_number: float = 4.0
    portrait: bool = False
    lamps: tuple[Lamp, ...] = (Lamp(y=0.5),)
    beam: str = "cosine-power"
    half_angle: float = 40.0
    camera: tuple[tuple[str, Any], ...] = ()
    light: tuple[tuple[str, Any], ...] = ()
    settings: tuple[tuple[str, Any], ...] = ()

    @property
    def camera_keys(self) -> dict[str, Any]:
        return {
            "resolution_x_px": 2448, "resolution_y_px": 2048, "pixel_pitch_um": 3.45, "read_noise_e": 2.4,
            "quantum_efficiency": "seed-imx250m", "gain_dn_per_e": 0.35, "bit_depth": 12,
        } | dict(self.camera)  # fmt: skip

    @property
    def flux_lm(self) -> float:
        return 4000.0 * len(self.lamps)

    def mission(self) -> dict[str, Any]:
        return {
            "name": "full", "physics": "full",
            "scene": {
                "water": self.water, "water_table": self.table, "seafloor": self.floor, "depth_m": 50,
                "temperature_c": self.temperature, "salinity_psu": self.salinity,
            },
            "vehicle": {"altitude_m": self.altitude, "speed_m_s": 0.3},
            "requirements": {"overlap": 0.3, "max_blur_px": 1.0},
        }  # fmt: skip

    def system(self) -> dict[str, Any]:
        port: dict[str, Any] = {"thickness_mm": self.thickness * 1e3, "refractive_index": self.n_glass}
        port |= {"geometry": "dome", "outer_radius_mm": self.radius * 1e3} if self.dome else {
            "geometry": "flat", "gap_mm": self.gap * 1e3,
        }  # fmt: skip
        shape = {"beam_profile": "dspl-sealite-flood", "beam": "tabulated", "beam_medium": "air"}
        if self.beam != "tabulated":
            shape = {"beam": self.beam, "beam_half_angle_deg": self.half_angle}  # type: ignore[dict-item]
        return {
            "camera": self.camera_keys,
            "lens": {"focal_length_mm": self.focal_mm, "transmission": 0.85},
            "port": port,
            "light": {"flux_lm": 4000, "power_w": 40, "spectrum": "generic-led", **shape, **dict(self.light)},
            "light_mounts": [
                {"x_m": a.x, "y_m": a.y, "z_m": a.z, "tilt_x_deg": a.tilt_x, "tilt_y_deg": a.tilt_y}
                for a in self.lamps
            ],
            "orientation": "portrait" if self.portrait else "landscape",
            "settings": {
                "f_number": self.f_number, "exposure_ms": 1.0, "gain": 1.0, "flux_lm": self.flux_lm,
                **dict(self.settings),
            },
        }  # fmt: skip


def figures(case: Case) -> dict[str, Any]:
    """What uwopt says."""
    result = uwopt.evaluate(case.mission(), case.system())
    assert result.physics["name"] == "full"
    assert result.design is not None
    return dict(result.design.scenes[0].figures)


# ---------------------------------------------------------------- tables


@cache
def rows_of(file: str) -> tuple[dict[str, str], ...]:
    with (DATA / file).open(encoding="utf-8", newline="") as lines:
        return tuple(csv.DictReader(line for line in lines if not line.startswith("#")))


def column(file: str, name: str, **where: str) -> tuple[Array, Array]:
    """Wavelengths and values of the rows that match."""
    rows = [row for row in rows_of(file) if all(row[key] == value for key, value in where.items())]
    assert rows, (file, where)
    pairs = sorted((float(row["wavelength_nm"]), float(row[name])) for row in rows)
    return np.array([x for x, _ in pairs]), np.array([y for _, y in pairs])


def water_index(case: Case, waves_nm: Array) -> Array:
    """Quan and Fry (1995), with the numbers of their paper."""
    t, s = case.temperature, case.salinity
    salt = (1.779e-4 - 1.05e-6 * t + 1.6e-8 * t**2) * s
    by_wave = (15.868 + 0.01155 * s - 0.00423 * t) / waves_nm - 4382.0 / waves_nm**2 + 1.1455e6 / waves_nm**3
    return 1.31405 + salt - 2.02e-6 * t**2 + by_wave


@cache
def water_loss(water: str, table: str) -> tuple[Array, Array]:
    """c and K [1/m]: a beyond the table continues as pure water, K_d is kept between a + b_b and c."""
    file = "jerlov_iop.csv" if table == "solonenko-mobley" else "jerlov_iop_measured.csv"
    nm, a_table = column(file, "a_per_m", water_type=water)
    a = np.interp(WAVES_NM, nm, a_table)
    pure = np.interp(WAVES_NM, *column("pure_water.csv", "a_per_m"))
    for end in (0, -1):
        at_end = np.interp(nm[end], *column("pure_water.csv", "a_per_m"))
        beyond = WAVES_NM < nm[0] if end == 0 else WAVES_NM > nm[-1]
        a[beyond] = a_table[end] + pure[beyond] - at_end
    b = np.interp(WAVES_NM, *column(file, "b_per_m", water_type=water))
    kd = np.interp(WAVES_NM, *column("jerlov_iop.csv", "kd_per_m", water_type=water))
    return a + b, np.clip(kd, a + 0.0183 * b, a + b)


def floor_reflectance(floor: float | str) -> Array:
    if isinstance(floor, float):
        return np.full(WAVES_NM.size, floor)
    return np.interp(WAVES_NM, *column("bottom_reflectance.csv", "reflectance", type=floor))


def efficiency(case: Case) -> Array:
    curve = case.camera_keys["quantum_efficiency"]
    if isinstance(curve, float):
        return np.full(WAVES_NM.size, curve)
    share = {"mono": 1.0} if case.camera_keys.get("colour") != "colour" else {"red": 0.25, "green": 0.5, "blue": 0.25}
    return sum(
        part * np.interp(WAVES_NM, *column("qe_curves.csv", "qe", curve_id=curve, channel=name))
        for name, part in share.items()
    )  # type: ignore[return-value]


@cache
def led() -> Array:
    """Watts per nm and lumen of the generic white LED."""
    power = sum(
        weight / (sigma * math.sqrt(2 * math.pi)) * np.exp(-0.5 * ((WAVES_NM - mean) / sigma) ** 2)
        for weight, mean, sigma in ((24.49, 450.70, 11.67), (119.86, 565.43, 64.63))
    )
    visible = np.interp(WAVES_NM, *column("photopic_v.csv", "V"), left=0.0, right=0.0)
    return np.asarray(power / (LUMENS_PER_W * (visible * power * STEPS_NM).sum()))


# ---------------------------------------------------------------- beams


@cache
def measured_lobe(n_w: float) -> Callable[[Array], Array]:
    """The measured flood, bent from air into water behind a flat window, scaled to one lumen."""
    rows = [row for row in rows_of("beam_profiles.csv") if row["profile_id"] == "dspl-sealite-flood"]
    air = PchipInterpolator([math.radians(float(r["angle_deg"])) for r in rows], [float(r["intensity"]) for r in rows])
    last = math.radians(min(90.0, float(rows[-1]["angle_deg"])))

    def in_water(theta: Array) -> Array:
        sine = n_w * np.sin(theta)
        theta_a = np.arcsin(np.minimum(sine, 1.0))
        bent = air(theta_a) * n_w**2 * np.cos(theta) / np.maximum(np.cos(theta_a), 1e-9)
        return np.where((sine < 1.0) & (theta_a < min(last, math.radians(89.0))), bent, 0.0)

    edges = np.linspace(0.0, math.asin(1.0 / n_w), 20001)
    middle, width = (edges[1:] + edges[:-1]) / 2, edges[1] - edges[0]
    lumens = (2 * math.pi * in_water(middle) * np.sin(middle)).sum() * width
    return lambda theta: in_water(theta) / lumens


def intensity(case: Case, cos_beam: Array) -> Array:
    """Candela per lumen, without a sharp beam's edge."""
    beta = math.radians(case.half_angle)
    cosine = np.maximum(cos_beam, 1e-12)
    if case.beam == "disc":
        return 1.0 / (math.pi * math.tan(beta) ** 2 * cosine**3)
    if case.beam == "cone":
        return np.full_like(cosine, 1.0 / (2 * math.pi * (1 - math.cos(beta))))
    if case.beam == "cosine-power":
        m = math.log(0.5) / math.log(math.cos(beta))
        return np.where(cos_beam > 0, (m + 1) / (2 * math.pi) * cosine**m, 0.0)
    n_w = float(water_index(case, np.array([RAYS_NM]))[0])
    return measured_lobe(n_w)(np.arccos(np.clip(cosine, 0.0, 1.0)))


# ---------------------------------------------------------------- rays


class Rays:
    """Geometry of one case: from a point of the sensor to the floor and from a lamp to the floor."""

    def __init__(self, case: Case):
        self.case = case
        self.n_w = float(water_index(case, np.array([RAYS_NM]))[0])
        keys = case.camera_keys
        x, y = (keys[name] * keys["pixel_pitch_um"] * 1e-3 / (2 * case.focal_mm) for name in ("resolution_x_px", "resolution_y_px"))
        self.tan_along, self.tan_across = (x, y) if case.portrait else (y, x)

    def floor(self, u: Array, v: Array) -> tuple[Array, Array, Array, Array]:
        """x, y on the floor, path in water, cos of the angle in air, for -1 <= u, v <= 1 over the image."""
        case = self.case
        tan_x, tan_y = u * self.tan_along, v * self.tan_across
        angle = np.arctan(np.hypot(tan_x, tan_y))
        if case.dome:
            reach = case.altitude + case.radius
            return reach * tan_x, reach * tan_y, reach / np.cos(angle) - case.radius, np.cos(angle)
        in_water, in_glass = np.arcsin(np.sin(angle) / self.n_w), np.arcsin(np.sin(angle) / case.n_glass)
        reach = case.gap * np.tan(angle) + case.thickness * np.tan(in_glass) + case.altitude * np.tan(in_water)
        turn = np.arctan2(tan_y, tan_x)
        return reach * np.cos(turn), reach * np.sin(turn), case.altitude / np.cos(in_water), np.cos(angle)

    def lamp(self, x: Array, y: Array, at: Lamp) -> tuple[Array, Array, Array]:
        """Range, cos of the angle from the lamp's axis, cos of the incidence on the floor."""
        outward_x, outward_y = (-1.0 if at.x < 0 else 1.0), (-1.0 if at.y < 0 else 1.0)
        aim = np.array([outward_x * math.tan(math.radians(at.tilt_x)), outward_y * math.tan(math.radians(at.tilt_y)), 1.0])
        aim /= np.linalg.norm(aim)
        ray = np.stack(np.broadcast_arrays(x - at.x, y - at.y, self.case.altitude - at.z), axis=-1)
        length = np.linalg.norm(ray, axis=-1)
        return length, ray @ aim / length, ray[..., 2] / length


def object_distance_m(case: Case) -> float:
    """What the lens must focus on: the dome's virtual image, or the floor seen through a flat window."""
    n_w = float(water_index(case, np.array([RAYS_NM]))[0])
    if not case.dome:
        return case.gap + case.thickness / case.n_glass + case.altitude / n_w
    # two refractions, one face after the other: n2/v - n1/u = (n2 - n1)/R, light to the right
    behind = case.n_glass / ((case.n_glass - n_w) / case.radius - n_w / case.altitude)
    inner = case.radius - case.thickness
    image = 1.0 / ((1.0 - case.n_glass) / inner + case.n_glass / (behind - case.thickness))
    return inner - image


def working_f_number(case: Case) -> float:
    focal_m = case.focal_mm * 1e-3
    return case.f_number * (1.0 + focal_m / (object_distance_m(case) - focal_m))


def spectral_weight(case: Case, time_s: float) -> Array:
    """Electrons of a pixel per lux, by wavelength, before the water's loss and the fall-off."""
    n_w = water_index(case, WAVES_NM)
    green = float(water_index(case, np.array([RAYS_NM]))[0])
    faces = [1.0 - ((a - b) / (a + b)) ** 2 for a, b in ((green, case.n_glass), (case.n_glass, 1.0))]
    radiance = led() * floor_reflectance(case.floor) / math.pi / n_w**2 * faces[0] * faces[1]
    on_sensor = math.pi / 4 * radiance * 0.85 / working_f_number(case) ** 2
    pitch_m = case.camera_keys["pixel_pitch_um"] * 1e-6
    per_watt = pitch_m**2 * time_s * efficiency(case) * WAVES_NM * 1e-9 / (PLANCK_J_S * LIGHT_M_S)
    return np.asarray(on_sensor * per_watt * STEPS_NM)


def electrons_at(case: Case, u: Array, v: Array, *, time_s: float = 1e-3, only: int | None = None) -> Array:
    """Electrons of the pixels at u, v, every wavelength on its own; edges of beams not yet cut."""
    rays = Rays(case)
    x, y, path, cos_air = rays.floor(u, v)
    weight, (c, k) = spectral_weight(case, time_s), water_loss(case.water, case.table)
    total = np.zeros(np.broadcast(u, v).shape)
    for number, at in enumerate(case.lamps):
        if only not in (None, number):
            continue
        length, cos_beam, cos_floor = rays.lamp(x, y, at)
        lux = case.flux_lm / len(case.lamps) * intensity(case, cos_beam) * cos_floor / length**2
        lost = np.exp(-k * length[..., None] - c * path[..., None]) @ weight
        total += lux * lost * cos_air**4
    return total


# ---------------------------------------------------------------- means over the image


def gauss(low: float, high: float, count: int) -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return low + (nodes + 1) * (high - low) / 2, weights * (high - low) / 2


def smooth_mean(case: Case, panels: int = 1, order: int = 32) -> float:
    """Mean over the image by Gauss-Legendre, in panels for lobes with kinks."""
    edges = np.linspace(-1.0, 1.0, panels + 1)
    parts = [gauss(low, high, order) for low, high in pairwise(edges)]
    nodes, weights = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
    values = electrons_at(case, nodes[:, None], nodes[None, :])
    return float(weights @ values @ weights) / 4.0


def lit_pieces(case: Case, lamp: Lamp, v: float) -> list[tuple[float, float]]:
    """Where along u a sharp beam lights the image's line v."""
    rays, edge = Rays(case), math.cos(math.radians(case.half_angle))

    def above(u: Any) -> Any:
        x, y, _, _ = rays.floor(np.asarray(u, float), np.asarray(v, float))
        return rays.lamp(x, y, lamp)[1] - edge

    tried = np.linspace(-1.0, 1.0, 41)
    level = above(tried)
    if 0 < (top := int(level.argmax())) < 40 and level[top] < 0.0:  # a sliver between two points
        best = minimize_scalar(lambda u: -above(u), bounds=(tried[top - 1], tried[top + 1]), method="bounded").x
        tried = np.insert(tried, np.searchsorted(tried, best), best)
        level = above(tried)
    turns = [brentq(above, tried[i], tried[i + 1]) for i in np.nonzero(level[1:] * level[:-1] < 0)[0]]
    return [(low, high) for low, high in pairwise([-1.0, *turns, 1.0]) if above((low + high) / 2) > 0]


def pattern(case: Case, lamp: Lamp, v: float) -> tuple[tuple[bool, bool], ...]:
    """Which pieces of a line are lit, and whether they touch the image's border."""
    return tuple((low == -1.0, high == 1.0) for low, high in lit_pieces(case, lamp, v))


def corners(case: Case, lamp: Lamp) -> list[float]:
    """Where along v the pattern changes: there the length of the pieces has a kink or a root."""
    tried = np.linspace(-1.0, 1.0, 41)
    found = [-1.0]
    for low, high in pairwise(tried):
        before = pattern(case, lamp, low)
        if pattern(case, lamp, high) == before:
            continue
        for _ in range(40):
            middle = (low + high) / 2
            low, high = (middle, high) if pattern(case, lamp, middle) == before else (low, middle)
        found.append(high)
    return [*found, 1.0]


def sharp_mean(case: Case, order: int = 24) -> float:
    """Mean over the image, each line cut where the beam ends.

    v = middle + half sin(pi s / 2) smooths the square roots at the ends of each stretch of lines.
    """
    total = 0.0
    for number, lamp in enumerate(case.lamps):
        us, vs, weights = [], [], []
        for low, high in pairwise(corners(case, lamp)):
            for s, weight_s in zip(*gauss(-1.0, 1.0, order), strict=True):
                v = (low + high) / 2 + (high - low) / 2 * math.sin(math.pi / 2 * s)
                weight_v = weight_s * (high - low) / 2 * math.pi / 2 * math.cos(math.pi / 2 * s)
                for piece in lit_pieces(case, lamp, v):
                    u, weight_u = gauss(*piece, 16)
                    us.append(u)
                    vs.append(np.full_like(u, v))
                    weights.append(weight_u * weight_v)
        if us:
            values = electrons_at(case, np.concatenate(us), np.concatenate(vs), only=number)
            total += float(values @ np.concatenate(weights))
    return total / 4.0

"""Physics `full`, through `uwopt.evaluate`, against a second computation written for this test.

The second computation follows the physics page from the tables that ship: rays, spectra, veils and the integral
over the image by brute force in NumPy, every wavelength at every point. It uses nothing of uwopt but those tables.
Backscatter is integrated with vectors along each ray, r for r, without the substitutions of `uwopt.model.veil`.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from kept_values import HINT, Kept
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.interpolate import CubicSpline, PchipInterpolator, RectBivariateSpline
from scipy.optimize import brentq, minimize_scalar
from scipy.special import eval_legendre

import uwopt
from uwopt.model.image_mean import FRAME_MAY_MISS, frame_places, reached_by_most

Array = NDArray[np.float64]
DATA = Path(__file__).parents[2] / "uwopt" / "catalog" / "data"
REFERENCE = Path(__file__).parents[1] / "reference"
WAVES_NM = np.arange(380.0, 780.25, 0.5)  # finer than uwopt's own grid
STEPS_NM = np.r_[0.25, np.full(WAVES_NM.size - 2, 0.5), 0.25]
PLANCK_J_S, LIGHT_M_S, LUMENS_PER_W = 6.62607015e-34, 299_792_458.0, 683.002
RAYS_NM = 550.0  # rays are traced for green light
#: Slow means, of this very file and the tables that it reads; `python tests/kept_values.py` remakes them.
TABLES = ("beam_profiles", "bottom_reflectance", "jerlov_iop", "photopic_v", "pure_water", "qe_curves")
KEPT = Kept(
    REFERENCE / "full_physics.json", Path(__file__), REFERENCE / "jerlov_iop_measured.csv",
    *(DATA / f"{name}.csv" for name in TABLES),
)  # fmt: skip
SMOOTH = 1e-4  # what a mean over the image is good for where beams have no edge
SHARP = 1e-3  # the same where beams end sharply
BACK_SHARE = 0.0183  # b_b/b of the particles, unless the mission says otherwise


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
    needs: tuple[tuple[str, Any], ...] = ()
    tolerance: float = 0.0
    focus: float | None = None  # altitude in focus; the case's own unless given
    orders: bool = False  # light scattered more than once counts

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
            "practice": "bare", "name": "full", "physics": "full",
            "scene": {
                "water": self.water, "seafloor": self.floor, "depth_m": 50, "multiple_scattering": self.orders,
                **({} if self.water.endswith(".csv") else {"water_table": self.table}),
                "temperature_c": self.temperature, "salinity_psu": self.salinity,
            },
            "vehicle": {"altitude_m": self.altitude, "altitude_tolerance_m": self.tolerance, "speed_m_s": 0.3},
            "requirements": {"overlap": 0.3, "max_blur_px": 1.0, **dict(self.needs)},
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


@cache
def scene(case: Case) -> Any:
    """What uwopt says."""
    result = uwopt.evaluate(case.mission(), case.system())
    assert result.physics["name"] == "full"
    assert result.design is not None
    return result.design.scenes[0]


def figures(case: Case) -> dict[str, Any]:
    return dict(scene(case).figures)


# ---------------------------------------------------------------- tables


@cache
def rows_of(file: str) -> tuple[dict[str, str], ...]:
    folder = REFERENCE if (REFERENCE / file).exists() else DATA
    assert folder / file in KEPT.made_of, file
    with (folder / file).open(encoding="utf-8", newline="") as lines:
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


def jerlov_file(table: str) -> str:
    return "jerlov_iop.csv" if table == "solonenko-mobley" else "jerlov_iop_measured.csv"


@cache
def water_loss(water: str, table: str) -> tuple[Array, Array]:
    """c and K [1/m]: a beyond the table continues as pure water, K_d is kept between a + b_b and c."""
    if water.endswith(".csv"):  # one attenuation for all: both legs lose it
        c = float(Path(water).read_text(encoding="utf-8").splitlines()[-1].split(",")[1])
        return np.full(WAVES_NM.size, c), np.full(WAVES_NM.size, c)
    file = jerlov_file(table)
    nm, a_table = column(file, "a_per_m", water_type=water)
    a = resampled(nm, a_table)
    pure = resampled(*column("pure_water.csv", "a_per_m"))
    for end in (0, -1):
        at_end = np.interp(nm[end], *column("pure_water.csv", "a_per_m"))
        beyond = np.less(WAVES_NM, nm[0]) if end == 0 else np.greater(WAVES_NM, nm[-1])
        a[beyond] = a_table[end] + pure[beyond] - at_end
    b = resampled(*column(file, "b_per_m", water_type=water))
    kd = resampled(*column("jerlov_iop.csv", "kd_per_m", water_type=water))
    return a + b, np.clip(kd, a + BACK_SHARE * b, a + b)


def scattering(case: Case) -> tuple[Array, Array]:
    """b [1/m] of particles and of the water's molecules: those of sea and fresh water by salinity."""
    if case.water.endswith(".csv"):
        return np.zeros(WAVES_NM.size), np.zeros(WAVES_NM.size)
    every = resampled(*column(jerlov_file(case.table), "b_per_m", water_type=case.water))
    fresh, sea = (
        np.exp(np.interp(np.log(WAVES_NM), np.log(nm), np.log(b)))
        for nm, b in (column("pure_water.csv", f"bw_zhang2009_S{s}_T20_per_m") for s in (0, 35))
    )
    molecules = np.minimum(fresh + (sea - fresh) * case.salinity / 35.0, every)
    return every - molecules, molecules


class Legs(NamedTuple):
    """Attenuations by wavelength [1/m]."""

    c: Array  # of what forms the image, floor to camera
    lamp: Array
    near: Array  # floor to camera, of what comes near its straight way
    floor: Array  # floor to camera, of all light
    back: tuple[Array, Array]  # of backscatter, from the lamp and to the camera


@cache
def legs(case: Case) -> Legs:
    """By the page's rules: single scattering, or a + s b with s from shares scattered by more than an angle."""
    c, k = water_loss(case.water, case.table)
    if not case.orders:
        return Legs(c, k, k, k, (k, c))
    b = scattering(case)

    def lost(particles: float, molecules: float) -> Array:
        return np.asarray(c - b[0] * (1.0 - particles) - b[1] * (1.0 - molecules))

    def beyond(degrees: float) -> tuple[float, float]:
        return particles_beyond(math.radians(degrees)), molecules_beyond(math.radians(degrees))

    half = beyond(90.0)
    share = 3.47 - 3.54 * math.radians(case.half_angle)
    back = np.maximum(lost(*(min(share * one, 1.0) for one in half)), 0.5 * lost(0.0, 0.0))  # none loses more than all
    lamp = lost(*beyond(20.2 + 0.86 * case.half_angle))
    a_way = lost(0.0, 0.0) * case.altitude
    floor = c - b[0] * arriving(particles_beyond, a_way) - b[1] * arriving(molecules_beyond, a_way)
    return Legs(c, lamp, lost(*beyond(13.3)), floor, (back, back))


def arriving(beyond: Callable[[float], float], absorbed: Array) -> Array:
    """What is scattered by less than 81.3 deg and bears the longer way: the way and angles by Gauss and fine bins."""
    edges = np.geomspace(1e-6, math.radians(81.3), 800)
    middle, mass = np.sqrt(edges[1:] * edges[:-1]), -np.diff([beyond(edge) for edge in edges])
    total = (1.0 - beyond(edges[0])) * np.ones_like(absorbed)
    for s, weight in zip(*gauss(0.0, 1.0, 20), strict=True):
        lateral = (1.0 - s) * np.tan(middle)
        detour = s + (1.0 - s) / np.cos(middle) - np.hypot(1.0, lateral)
        total = total + weight * np.exp(-np.multiply.outer(absorbed, detour)) @ mass
    return np.asarray(total)


def particles_beyond(psi: float) -> float:
    """Share of Fournier-Forand scattered by more than an angle, in closed form (Fournier and Jonasz 1999)."""
    nu, square = fournier_forand()
    sin2 = math.sin(psi / 2) ** 2
    d, d180 = 4.0 * sin2 / (3.0 * square), 4.0 / (3.0 * square)
    within = ((1 - d ** (nu + 1)) - (1 - d**nu) * sin2) / ((1 - d) * d**nu)
    within += (1 - d180**nu) / (8 * (d180 - 1) * d180**nu) * math.cos(psi) * math.sin(psi) ** 2
    return 1.0 - within


@cache
def molecules_beyond(psi: float) -> float:
    return quad(lambda t: 2 * math.pi * math.sin(t) * float(molecule_phase(np.cos(t))), psi, math.pi)[0]


@cache
def fournier_forand() -> tuple[float, float]:
    """nu and (n - 1)^2 on the line of Mobley et al. (2002) where b_b/b is the wanted."""

    def parts(mu: float) -> tuple[float, float]:
        return (3.0 - mu) / 2.0, (0.01 + 0.1542 * (mu - 3.0)) ** 2

    def share(mu: float) -> float:
        nu, square = parts(mu)
        d = 2.0 / (3.0 * square)
        return 1.0 - (1.0 - d ** (nu + 1.0) - 0.5 * (1.0 - d**nu)) / ((1.0 - d) * d**nu)

    return parts(brentq(lambda mu: share(mu) - BACK_SHARE, 3.1, 4.5))


def particle_phase(cosine: Array) -> Array:
    """Fournier-Forand as Fournier and Jonasz (1999) print it; not for the degrees where d is 1."""
    nu, square = fournier_forand()
    half = (1.0 - cosine) / 2.0  # sin^2(psi/2)
    d, back = 4.0 * half / (3.0 * square), (4.0 / (3.0 * square)) ** nu
    first = nu * (1 - d) - (1 - d**nu) + (d * (1 - d**nu) - nu * (1 - d)) / half
    return np.asarray(
        first / (4 * math.pi * (1 - d) ** 2 * d**nu)
        + (1 - back) / (16 * math.pi * (4.0 / (3.0 * square) - 1) * back) * (3 * cosine**2 - 1)
    )


def met_phase(case: Case, cosine: Array) -> Array:
    """Of particles, as light meets it that has turned before and turns again: half of the way there and back each."""
    if not case.orders:
        return particle_phase(cosine)
    cells = np.linspace(0.0, math.pi, 2001)
    return np.asarray(particle_phase(cosine) + CubicSpline(cells, more_met(case))(np.arccos(np.clip(cosine, -1, 1))))


@cache
def more_met(case: Case) -> Array:
    """What that has over the function itself, at 2001 angles: Legendre orders of p, made even within 60 deg."""
    k, b = legs(case).c, scattering(case)
    t, part = gauss(0.0, case.altitude, 60)
    left = np.exp(-2.0 * np.multiply.outer(k, t)) * part
    way = left @ (2.0 * t) / left.sum(axis=1)
    seen = led() * STEPS_NM * np.exp(-k * way)
    angle, masses = turned_masses()
    log_gain = np.zeros(121)
    for own, mass in zip(b, masses, strict=True):
        chi = np.zeros(121)
        for s, weight in zip(*gauss(0.0, 1.0, 20), strict=True):
            second = np.array([np.roots([1.0, 2.0 * s * math.cos(one), s * s - 1.0]).max() for one in angle])
            aslant = angle - np.arctan2(second * np.sin(angle), s + second * np.cos(angle))
            chi += weight * np.array([eval_legendre(n, np.cos(aslant)) @ mass for n in range(121)])
        log_gain += 2.82 * float((own * way * seen).sum() / seen.sum()) * (chi - chi[0])
    gain, cos = np.exp(log_gain), np.cos(np.linspace(0.0, math.pi, 2001))
    found = (gain[-1] - 1.0) * particle_phase(np.minimum(cos, 0.5))
    for n in range(121):
        series = sum(
            float(eval_legendre(n, mu) * particle_phase(np.minimum(mu, 0.5)) @ weight)
            for mu, weight in (gauss(-1.0, 0.5, 200), gauss(0.5, 1.0, 200))
        )
        found = found + (2 * n + 1) / 2 * series * (gain[n] - gain[-1]) * eval_legendre(n, cos)
    return np.asarray(found)


def molecule_phase(cosine: Array) -> Array:
    """Depolarisation 0.039."""
    f = (1 - 0.039) / (1 + 0.039)
    return np.asarray(3 / (4 * math.pi * (3 + f)) * (1 + f * cosine**2))


def resampled(waves_nm: Array, values: Array, outside: float | None = None) -> Array:
    """A table on the wavelengths of this test; beyond its ends held, or what is given."""
    return np.asarray(np.interp(WAVES_NM, waves_nm, values, left=outside, right=outside))


def floor_reflectance(floor: float | str) -> Array:
    if isinstance(floor, float):
        return np.full(WAVES_NM.size, floor)
    return resampled(*column("bottom_reflectance.csv", "reflectance", type=floor))


def efficiency(case: Case) -> Array:
    curve = case.camera_keys["quantum_efficiency"]
    if isinstance(curve, float):
        return np.full(WAVES_NM.size, curve)
    colours = {"red": 0.25, "green": 0.5, "blue": 0.25}
    share = colours if case.camera_keys.get("colour") == "colour" else {"mono": 1.0}
    curves = [
        part * resampled(*column("qe_curves.csv", "qe", curve_id=curve, channel=n))
        for n, part in share.items()
    ]
    return np.asarray(np.sum(curves, axis=0))


@cache
def led() -> Array:
    """Watts per nm and lumen of the generic white LED."""
    power = sum(
        weight / (sigma * math.sqrt(2 * math.pi)) * np.exp(-0.5 * ((WAVES_NM - mean) / sigma) ** 2)
        for weight, mean, sigma in ((24.49, 450.70, 11.67), (119.86, 565.43, 64.63))
    )
    visible = resampled(*column("photopic_v.csv", "V"), outside=0.0)
    return np.asarray(power / (LUMENS_PER_W * (visible * power * STEPS_NM).sum()))


# ---------------------------------------------------------------- beams


@cache
def measured_lobe(n_w: float) -> Callable[[Array], Array]:
    """The measured flood, bent from air into water behind a flat window, scaled to one lumen."""
    rows = [row for row in rows_of("beam_profiles.csv") if row["profile_id"] == "dspl-sealite-flood"]
    air = PchipInterpolator(
        [math.radians(float(r["angle_deg"])) for r in rows], [float(r["intensity"]) for r in rows]
    )
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


def intensity(case: Case, cos_beam: Array, length: Array | None = None) -> Array:
    """Candela per lumen, without a sharp beam's edge; all orders counted, what arrives over what K leaves of it.

    length : of the way to where the water sends it back; None: on the floor
    """
    beam = lamp_intensity(case, cos_beam)
    if not case.orders:
        return beam
    theta = np.arccos(np.clip(cos_beam, 0.0, 1.0))
    if length is None:
        kept, halo = widened_rows(case, (case.altitude - max(at.z for at in case.lamps),))
        arrived = kept[0] * beam + CubicSpline(THETA, halo[0])(theta)
    else:
        kept, halo = widened_rows(case, WAYS_M)
        along = CubicSpline(WAYS_M, kept)(length)
        arrived = along * beam + RectBivariateSpline(WAYS_M, THETA, halo).ev(length, theta)
    return np.where(cos_beam > 0, arrived, 0.0)


THETA = np.linspace(0.0, math.pi / 2, 1001)
WAYS_M = tuple((np.linspace(0.0, 2.5, 41) ** 2).tolist())


@cache
def widened_rows(case: Case, ways: tuple[float, ...]) -> tuple[Array, Array]:
    """Share of the lamp's own lobe that is left on each way, and the halo by angle: Legendre orders up to 120."""
    node, polynomials = gauss(0.0, 1.0, 200), [eval_legendre(n, np.cos(THETA)) for n in range(121)]
    ring = 2 * math.pi * lamp_intensity(case, node[0]) * node[1]
    lobe = [float(ring @ eval_legendre(n, node[0])) for n in range(121)]
    c, k = legs(case)[:2]
    kept, halo = [], []
    for way in ways:
        seen = led() * STEPS_NM * np.exp(-(c + k) * way)
        b = [float((one * seen).sum() / seen.sum()) for one in scattering(case)]
        absorbed, sent = (c - sum(scattering(case))) * seen, floor_reflectance(case.floor) * seen
        every, floor = float(absorbed.sum() / seen.sum()), float(sent.sum() / seen.sum())
        turned = b[0] * particles_beyond(math.pi / 2) + b[1] * 0.5
        sent_back = len(ways) > 1
        shares = carried(case.half_angle, every * way, sent_back)
        gain = np.exp(sum(own * way * share for own, share in zip(b, shares, strict=True)))
        streams = two_streams(every * way, turned * way, 0.0 if sent_back else floor) if way else 1.0
        gain = gain + gain[0] * (streams - 1.0) * from_all_about()
        series = (2 * np.arange(121) + 1) / (4 * math.pi) * lobe * (gain - gain[-1])
        kept.append(gain[-1])
        halo.append(np.maximum(series @ np.array(polynomials), 0.0))
    return np.array(kept), np.array(halo)


@cache
def from_all_about() -> Array:
    """Legendre series of 3 cos^2 over the front."""
    mu, weight = gauss(0.0, 1.0, 80)
    return np.array([3.0 * (np.square(mu) * eval_legendre(n, mu)) @ weight for n in range(121)])


def two_streams(absorbed: float, back: float, reflectance: float) -> float:
    """Light on a floor in a deep sea of two even streams over what never turned back, which goes straight.

    The streams as a linear system: down A e^-kz + r B e^kz, up r A e^-kz + B e^kz between lamp and floor; above the
    lamp the sea sends r of what goes up down again, the floor sends up its share of what comes down.
    """
    a, b = 2.0 * absorbed, 2.0 * back
    k = math.sqrt((a + b) ** 2 - b**2)
    r, fall = (a + b - k) / b, math.exp(-k)
    system = [[1 - r * r, 0.0], [(r - reflectance) * fall, (1 - reflectance * r) / fall]]
    down, up = np.linalg.solve(system, [1.0, 0.0])
    straight = math.exp(-(a + b))
    return float((down * fall + r * up / fall) / straight)


@cache
def carried(half_angle: float, absorbed: float, sent_back: bool) -> list[Array]:
    """Of particles and of molecules chi_l - 1 + s, l 0 to 120: bins of angle by closed form, the way by Gauss.

    To a floor square to the way by coordinates; to a place at the same distance by the law of cosines.
    """
    found = []
    for beyond, mass in zip((particles_beyond, molecules_beyond), turned_masses()[1], strict=True):
        chi = np.zeros(121)
        for weight, (p, detour) in zip(gauss(0.0, 1.0, 20)[1], turned_polynomials(sent_back), strict=True):
            chi += weight * (p @ (mass * np.exp(-absorbed * detour)))
        chi = 2.0 * chi - chi[0] if sent_back else chi
        found.append(chi - 1.0 + beyond(math.radians(20.2 + 0.86 * half_angle)))
    return found


def longer(s: float, psi: Array, sent_back: bool) -> tuple[Array, Array]:
    """Cosine of the apparent angle, and how much longer the way is, in ways straight there."""
    if not sent_back:
        x, z = (1.0 - s) * np.tan(psi), 1.0
        straight = np.hypot(x, z)
        return z / straight, s + (1.0 - s) / np.cos(psi) - straight
    second = np.array([np.roots([1.0, 2.0 * s * math.cos(one), s * s - 1.0]).max() for one in psi])
    return s + second * np.cos(psi), s + second - 1.0


@cache
def turned_masses() -> tuple[Array, tuple[Array, Array]]:
    """Angles up to 90 deg, and of particles and of molecules what is scattered about each."""
    edges = np.r_[np.geomspace(1e-6, 0.2, 300), np.linspace(0.2, math.pi / 2, 400)[1:]]
    particles, molecules = (-np.diff([1.0, *map(one, edges)]) for one in (particles_beyond, molecules_beyond))
    return np.r_[0.0, np.sqrt(edges[1:] * edges[:-1])], (particles, molecules)


@cache
def turned_polynomials(sent_back: bool) -> list[tuple[Array, Array]]:
    """P_l of the apparent angles at each node of the way, and how much longer the ways are."""
    order, middle = np.arange(121)[:, None], turned_masses()[0]
    turns = [longer(s, middle, sent_back) for s in gauss(0.0, 1.0, 20)[0]]
    return [(eval_legendre(order, cosine), detour) for cosine, detour in turns]


def lamp_intensity(case: Case, cos_beam: Array) -> Array:
    """What leaves the lamp."""
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
        self.pixel = keys["pixel_pitch_um"] * 1e-3 / case.focal_mm
        x, y = keys["resolution_x_px"] * self.pixel / 2, keys["resolution_y_px"] * self.pixel / 2
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
        reach = (
            case.gap * np.tan(angle) + case.thickness * np.tan(in_glass) + case.altitude * np.tan(in_water)
        )
        turn = np.arctan2(tan_y, tan_x)
        return reach * np.cos(turn), reach * np.sin(turn), case.altitude / np.cos(in_water), np.cos(angle)

    def off_axis(self, u: Array, v: Array) -> Array:
        """What lens and window pass, over what they pass on the axis: cos^4, and Fresnel's losses by angle."""
        cos_air = self.floor(u, v)[3]
        if self.case.dome:
            return np.asarray(cos_air**4)
        sine = np.sqrt(1.0 - cos_air**2)
        return np.asarray(cos_air**4 * self.window(sine) / self.window(np.array(0.0)))

    def window(self, sine_air: Array) -> Array:
        """Share of unpolarised light that passes both faces of a flat window, each polarisation on its own."""
        indices = (self.n_w, self.case.n_glass, 1.0)
        passed = {"s": np.ones_like(sine_air), "p": np.ones_like(sine_air)}
        for n_1, n_2 in pairwise(indices):
            cos_1, cos_2 = (np.sqrt(1.0 - (sine_air / n) ** 2) for n in (n_1, n_2))
            passed["s"] *= 1.0 - ((n_1 * cos_1 - n_2 * cos_2) / (n_1 * cos_1 + n_2 * cos_2)) ** 2
            passed["p"] *= 1.0 - ((n_2 * cos_1 - n_1 * cos_2) / (n_2 * cos_1 + n_1 * cos_2)) ** 2
        return np.asarray((passed["s"] + passed["p"]) / 2.0)

    def start(self, u: Array, v: Array) -> Array:
        """Where the ray enters the water: on the dome, or on the outer face of the window."""
        case = self.case
        tan_x, tan_y = np.broadcast_arrays(u * self.tan_along, v * self.tan_across)
        if case.dome:
            toward = np.stack([tan_x, tan_y, np.ones_like(tan_x)], axis=-1)
            toward /= np.linalg.norm(toward, axis=-1, keepdims=True)
            return np.asarray(case.radius * toward - [0.0, 0.0, case.radius])
        angle = np.arctan(np.hypot(tan_x, tan_y))
        reach = case.gap * np.tan(angle) + case.thickness * np.tan(np.arcsin(np.sin(angle) / case.n_glass))
        turn = np.arctan2(tan_y, tan_x)
        return np.stack([reach * np.cos(turn), reach * np.sin(turn), np.zeros_like(reach)], axis=-1)

    def lamp(self, x: Array, y: Array, at: Lamp) -> tuple[Array, Array, Array]:
        """Range, cos of the angle from the lamp's axis, cos of the incidence on the floor."""
        aim = aim_of(at)
        ray = np.stack(np.broadcast_arrays(x - at.x, y - at.y, self.case.altitude - at.z), axis=-1)
        length = np.linalg.norm(ray, axis=-1)
        return length, ray @ aim / length, ray[..., 2] / length


def aim_of(at: Lamp) -> Array:
    """Unit vector of a lamp's axis, leaning away from the port."""
    outward_x, outward_y = (-1.0 if at.x < 0 else 1.0), (-1.0 if at.y < 0 else 1.0)
    aim = np.array(
        [outward_x * math.tan(math.radians(at.tilt_x)), outward_y * math.tan(math.radians(at.tilt_y)), 1.0]
    )
    return np.asarray(aim / np.linalg.norm(aim))


def object_distance_m(case: Case, range_m: float) -> float:
    """Where the lens sees a point on the axis: the dome's virtual image, or the point through a flat window."""
    n_w = float(water_index(case, np.array([RAYS_NM]))[0])
    if not case.dome:
        return case.gap + case.thickness / case.n_glass + range_m / n_w
    # two refractions, one face after the other: n2/v - n1/u = (n2 - n1)/R, light to the right
    behind = case.n_glass / ((case.n_glass - n_w) / case.radius - n_w / range_m)
    inner = case.radius - case.thickness
    image = 1.0 / ((1.0 - case.n_glass) / inner + case.n_glass / (behind - case.thickness))
    return inner - image


def working_f_number(case: Case) -> float:
    focal_m, object_m = case.focal_mm * 1e-3, object_distance_m(case, case.focus or case.altitude)
    return case.f_number * (1.0 + focal_m / (object_m - focal_m))


def spectral_weight(case: Case, time_s: float, sent: Array | None = None) -> Array:
    """Electrons of a pixel per lux, by wavelength, before the water's loss and the fall-off.

    `sent`: radiance in water per irradiance, the floor's M/pi unless given.
    """
    n_w = water_index(case, WAVES_NM)
    green = float(water_index(case, np.array([RAYS_NM]))[0])
    faces = [1.0 - ((a - b) / (a + b)) ** 2 for a, b in ((green, case.n_glass), (case.n_glass, 1.0))]
    per_irradiance = floor_reflectance(case.floor) / math.pi if sent is None else sent
    radiance = led() * per_irradiance / n_w**2 * faces[0] * faces[1]
    on_sensor = math.pi / 4 * radiance * 0.85 / working_f_number(case) ** 2
    pitch_m = case.camera_keys["pixel_pitch_um"] * 1e-6
    per_watt = pitch_m**2 * time_s * efficiency(case) * WAVES_NM * 1e-9 / (PLANCK_J_S * LIGHT_M_S)
    return np.asarray(on_sensor * per_watt * STEPS_NM)


def electrons_at(
    case: Case, u: Array, v: Array, *, time_s: float = 1e-3, only: int | None = None, diffuse: bool = False
) -> Array:
    """Electrons of the pixels at u, v, every wavelength on its own; edges of beams not yet cut.

    `diffuse`: with the forward veil that comes near its straight way, exp(-K r) on the camera's leg too.
    """
    rays = Rays(case)
    x, y, path, _ = rays.floor(u, v)
    weight, (c, k, near, _, _) = spectral_weight(case, time_s), legs(case)
    c = near if diffuse else c
    total = np.zeros(np.broadcast(u, v).shape)
    for number, at in enumerate(case.lamps):
        if only not in (None, number):
            continue
        length, cos_beam, cos_floor = rays.lamp(x, y, at)
        lux = case.flux_lm / len(case.lamps) * intensity(case, cos_beam) * cos_floor / length**2
        lost = np.exp(-k * length[..., None] - c * path[..., None]) @ weight
        total += lux * lost * rays.off_axis(u, v)
    return total


def forward_at(case: Case, u: Array, v: Array) -> Array:
    """Light of the floor that water scatters on its way to the camera: exp(-K r) - exp(-c r)."""
    return electrons_at(case, u, v, diffuse=True) - electrons_at(case, u, v)


def elsewhere_at(case: Case, u: Array, v: Array, rings: int = 40, azimuths: int = 48) -> Array:
    """Light of the floor that water turns into pixels from all about, by the number of its turns.

    By directions from the camera, ring by ring about straight down.
    """
    rays, (_, k, near, every, _) = Rays(case), legs(case)
    theta, weight = gauss(0.0, math.radians(84.0), rings)
    phi = 2 * math.pi * (np.arange(azimuths) + 0.5) / azimuths
    angle, turn = np.broadcast_arrays(theta[:, None], phi)
    solid = (weight[:, None] * np.sin(angle) * 2 * math.pi / azimuths).ravel()
    ways = np.stack([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)], axis=-1).reshape(-1, 3)
    behind = case.radius if case.dome else 0.0
    length = (case.altitude + behind) / ways[:, 2]
    x, y, path = length * ways[:, 0], length * ways[:, 1], length - behind
    left = np.exp(-every * path[:, None]) - np.exp(-near * path[:, None])
    amount = np.zeros(len(solid))
    for at in case.lamps:
        lamp_m, cos_beam, cos_floor = rays.lamp(x, y, at)
        lux = case.flux_lm / len(case.lamps) * intensity(case, cos_beam) * cos_floor / lamp_m**2
        amount += lux * ((left * np.exp(-k * lamp_m[:, None])) @ spectral_weight(case, 1e-3)) * solid
    toward = np.stack(np.broadcast_arrays(*rays.floor(u, v)[:2], case.altitude), axis=-1) - rays.start(u, v)
    cosine = toward / np.linalg.norm(toward, axis=-1, keepdims=True) @ ways.T
    once, twice, often = turns(case)
    parts = {16: 0.85 * once, 2: 0.15 * once, 8: twice, 4: often}
    kernel = sum((n + 1) / (2 * math.pi) * part * np.maximum(cosine, 0.0) ** n for n, part in parts.items())
    return np.asarray(kernel @ amount * rays.off_axis(u, v))


def turns(case: Case) -> tuple[float, float, float]:
    """Shares of what comes from elsewhere that turned once, twice and more: of each colour by its own light."""
    (_, k, near, every, _), d = legs(case), case.altitude
    sent = spectral_weight(case, 1e-3) * np.exp(-k * d) * (np.exp(-every * d) - np.exp(-near * d))
    x = (near - every) * d
    once = float(sent @ (x / np.expm1(x)) / sent.sum())
    twice = float(sent @ (x**2 / 2.0 / np.expm1(x)) / sent.sum())
    return once, twice, 1.0 - once - twice


def floor_veil_at(case: Case, u: Array, v: Array) -> Array:
    """All light of the floor that forms no image."""
    return forward_at(case, u, v) + (elsewhere_at(case, u, v) if case.orders else 0.0)


RAY_NODES = 32  # 48 change the backscatter of these cases by 2e-7 or less


def backscatter_at(case: Case, u: Array, v: Array) -> Array:
    """Electrons that lamps send by way of the water: L_b = integral of beta(psi) I / r_s^2 exp(-K r_s - c r) dr.

    Gauss-Legendre along the lit part of each ray, in front of the lamp's front plane; every other wavelength.
    """
    rays, (k, c) = Rays(case), (loss[::2] for loss in legs(case).back)
    scale = spectral_weight(case, 1e-3, np.ones(WAVES_NM.size))
    halved = np.where(np.arange(0, WAVES_NM.size, 2) % (WAVES_NM.size - 1) == 0, 1.5, 2.0)
    weights = np.stack([scale[::2] * b[::2] * halved for b in scattering(case)], axis=-1)
    start = rays.start(u, v)
    x, y, path, _ = rays.floor(u, v)
    toward = np.stack(np.broadcast_arrays(x, y, case.altitude), axis=-1) - start
    toward /= path[..., None]  # the way through the water: a unit vector, or the rays are wrong
    assert np.linalg.norm(toward, axis=-1) == pytest.approx(1.0, rel=1e-12)
    total = np.zeros(path.shape)
    for at in case.lamps:
        lamp, aim = np.array([at.x, at.y, at.z]), aim_of(at)
        before, slope = (start - lamp) @ aim, toward @ aim  # depth in front of the lamp: before + slope r
        crossing = np.clip(-before / slope, 0.0, path)
        near, far = np.where(slope > 0, crossing, 0.0), np.where(slope > 0, path, crossing)
        for node, node_weight in zip(*gauss(0.0, 1.0, RAY_NODES), strict=True):
            r = near + node * (far - near)
            away = start + r[..., None] * toward - lamp
            length = np.linalg.norm(away, axis=-1)
            cos_beam = away @ aim / length
            turned = -(away * toward).sum(axis=-1) / length  # light goes along `away`, then up the ray
            sent = np.exp(-k * length[..., None] - c * r[..., None]) @ weights
            phased = sent[..., 0] * met_phase(case, turned) + sent[..., 1] * molecule_phase(turned)
            lumens = case.flux_lm / len(case.lamps)
            total += node_weight * (far - near) * lumens * intensity(case, cos_beam, length) / length**2 * phased
    return np.asarray(total * rays.off_axis(u, v))


# ---------------------------------------------------------------- means over the image


def gauss(low: float, high: float, count: int) -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return low + (nodes + 1) * (high - low) / 2, weights * (high - low) / 2


def smooth_mean(
    case: Case, panels: int = 1, order: int = 32, values_at: Callable[..., Array] = electrons_at
) -> float:
    """Mean over the image by Gauss-Legendre, in panels for lobes with kinks."""
    edges = np.linspace(-1.0, 1.0, panels + 1)
    parts = [gauss(low, high, order) for low, high in pairwise(edges)]
    nodes, weights = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
    values = values_at(case, nodes[:, None], nodes[None, :])
    return float(weights @ values @ weights) / 4.0


@KEPT.values
def smooth_electrons(case: Case) -> float:
    """Mean electrons of the signal under lobes without kinks."""
    return smooth_mean(case)


@KEPT.values
def veil_means(case: Case) -> tuple[float, float]:
    """Mean forward veil and mean backscatter; the latter on 12 x 12 points (24 x 24 change it by 1e-7 or less)."""
    forward = smooth_mean(case, values_at=forward_at)
    if case.orders:
        forward += smooth_mean(case, order=8, values_at=elsewhere_at)
    return forward, smooth_mean(case, order=12, values_at=backscatter_at)


def lit_pieces(case: Case, lamp: Lamp, v: float) -> list[tuple[float, float]]:
    """Where along u a sharp beam lights the image's line v."""
    rays, edge = Rays(case), math.cos(math.radians(case.half_angle))

    def above(u: Any) -> Any:
        x, y, _, _ = rays.floor(np.asarray(u, float), np.asarray(v, float))
        return rays.lamp(x, y, lamp)[1] - edge

    tried = np.linspace(-1.0, 1.0, 41)
    level = above(tried)
    if 0 < (top := int(level.argmax())) < 40 and level[top] < 0.0:  # a sliver between two points
        best = minimize_scalar(
            lambda u: -above(u), bounds=(tried[top - 1], tried[top + 1]), method="bounded"
        ).x
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


@KEPT.values
def sharp_electrons(case: Case) -> float:
    """Mean electrons of the signal under beams that end sharply."""
    return sharp_mean(case, electrons_at)


@KEPT.values
def sharp_lux(case: Case) -> float:
    """Mean illuminance of the floor that is seen, under such beams."""
    nodes, weights = gauss(-1.0, 1.0, 32)
    whole = weights @ floor_area(case, nodes[:, None], nodes[None, :]) @ weights / 4.0
    return float(sharp_mean(case, lambda *at, **only: lux_at(*at, **only) * floor_area(*at)) / whole)


def sharp_mean(case: Case, values_at: Callable[..., Array], order: int = 16) -> float:
    """Mean over the image of what lamps give one by one, each line cut where the beam ends.

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
            values = values_at(case, np.concatenate(us), np.concatenate(vs), only=number)
            total += float(values @ np.concatenate(weights))
    return total / 4.0


# ---------------------------------------------------------------- electrons


def pair(baseline: float, tilt: float = 0.0) -> tuple[Lamp, Lamp]:
    """Two lamps across track, leaning outward alike."""
    return Lamp(y=baseline, tilt_y=tilt), Lamp(y=-baseline, tilt_y=tilt)


FLAT = Case(dome=False, focal_mm=12.0, n_glass=1.49, thickness=0.012)
THREE = (
    Lamp(x=0.3, y=0.4, z=-0.2, tilt_x=-10, tilt_y=5), Lamp(x=-0.5, y=-0.1, z=0.1, tilt_x=15), Lamp(y=0.9, tilt_y=-30),
)  # fmt: skip
SMOOTH_CASES = {
    "one lamp, dome": Case(),
    "two lamps, clear water": Case(water="I", lamps=pair(0.5)),
    "flat port, measured water, tilt outward": replace(
        FLAT, altitude=1.5, water="IB", table="measured", lamps=pair(0.6, 10)
    ),
    "wide flat port, tilt inward": replace(
        FLAT, focal_mm=4.0, altitude=1.2, water="1C", table="measured", lamps=pair(0.6, -20)
    ),
    "three lamps anywhere, turbid, portrait": Case(
        water="5C", table="measured", altitude=1.0, lamps=THREE, portrait=True
    ),
    "most turbid": Case(water="9C", altitude=1.5, lamps=pair(0.4)),
    "narrow lobes": Case(half_angle=12.0, lamps=pair(0.5, -8)),
    "wide lobes": Case(half_angle=60.0, lamps=pair(0.8, 20)),
    "warm fresh water": Case(
        temperature=30.0, salinity=0.0, water="III", table="measured", camera=(("quantum_efficiency", 0.6),)
    ),
    "colour, spectrum of sand": Case(
        floor="sand_coralreef_asu", camera=(("quantum_efficiency", "seed-imx250c"), ("colour", "colour"))
    ),
    "all orders, dome": Case(orders=True, lamps=pair(0.5)),
    "all orders, flat port, narrow lobes, turbid": replace(
        FLAT, orders=True, water="5C", table="measured", altitude=1.0, half_angle=15.0, lamps=pair(0.3, -5)
    ),
    "glass of the water's index": Case(n_glass=1.34),  # a dome that is not there: faces pass, air face loses
}


@pytest.mark.parametrize("name", SMOOTH_CASES)
def test_mean_electrons_under_smooth_lobes(name: str) -> None:
    case = SMOOTH_CASES[name]
    assert figures(case)["electrons_signal"] == pytest.approx(smooth_electrons(case), rel=SMOOTH)


@pytest.mark.parametrize("focal_mm", [4.0, 8.0])
def test_mean_electrons_under_a_measured_lobe(focal_mm: float) -> None:
    # every half degree of the measured profile is a small kink; Gauss-Legendre steps over them (4e-4)
    case = Case(beam="tabulated", focal_mm=focal_mm, floor="sand_coralreef_asu", lamps=pair(0.5, -5))
    assert figures(case)["electrons_signal"] == pytest.approx(smooth_mean(case, 20, 6), rel=SHARP)


SHARP_CASES = {
    "disc that covers the image": Case(beam="disc", half_angle=45.0),
    "two small discs": Case(beam="disc", half_angle=20.0, lamps=pair(0.3)),
    "two cones, tilt inward": Case(beam="cone", half_angle=20.0, lamps=pair(0.5, -10)),
    "two cones, flat port": replace(
        FLAT, beam="cone", half_angle=30.0, focal_mm=6.0, lamps=pair(0.5, 5), altitude=1.5
    ),
    "wide tilted discs, turbid": Case(
        beam="disc", half_angle=60.0, lamps=pair(0.8, 20), water="5C", table="measured", focal_mm=4.0
    ),
    "three discs anywhere": Case(beam="disc", half_angle=35.0, lamps=THREE),
}


@pytest.mark.parametrize("name", SHARP_CASES)
def test_mean_electrons_under_beams_that_end_sharply(name: str) -> None:
    case = SHARP_CASES[name]
    assert figures(case)["electrons_signal"] == pytest.approx(sharp_electrons(case), rel=SHARP)


@pytest.mark.parametrize(("half_angle", "reached"), [(10.0, 2e-3), (5.0, 1e-2)])
def test_narrow_spots_are_met_less_well(half_angle: float, reached: float) -> None:
    # the spot's radius is 17 and 9 of the cells into which the image is cut; the error falls with their square
    case = Case(beam="cone", half_angle=half_angle, lamps=(Lamp(y=0.1),))
    assert figures(case)["electrons_signal"] == pytest.approx(sharp_electrons(case), rel=reached)


@pytest.mark.parametrize("name", SMOOTH_CASES)
def test_mean_veils_under_smooth_lobes(name: str) -> None:
    case = SMOOTH_CASES[name]
    got, (forward, back) = figures(case), veil_means(case)
    # clear water: a difference of two nearly equal means, each good to 1e-5
    assert got["electrons_forward"] == pytest.approx(forward, rel=SMOOTH, abs=1e-5 * smooth_electrons(case))
    # here 1 nm of wavelength and the formula of the phase function, there a table of it
    assert got["electrons_backscatter"] == pytest.approx(back, rel=2 * SMOOTH)


@pytest.mark.parametrize("name", SMOOTH_CASES)
def test_snr_contrast_and_veil_ratio_of_the_means(name: str) -> None:
    case = SMOOTH_CASES[name]
    got, signal, veil = figures(case), smooth_electrons(case), sum(veil_means(case))
    assert got["snr"] == pytest.approx(snr_by_hand(signal, veil=veil), rel=SMOOTH)
    assert got["contrast"] == pytest.approx(signal / (signal + veil), rel=SMOOTH)
    assert got["veil_ratio"] == pytest.approx(veil / signal, rel=2 * SMOOTH)


@KEPT.values
def least_snr(case: Case) -> float:
    """Of 41 pixels a side, the darkest."""
    border = np.linspace(-1.0, 1.0, 41)
    at = (case, border[:, None], border[None, :])
    signal, veil = electrons_at(*at), floor_veil_at(*at) + backscatter_at(*at)
    return float((signal / np.sqrt(noise_variance(signal + veil))).min())


@pytest.mark.parametrize("name", SMOOTH_CASES)
def test_darkest_pixel(name: str) -> None:
    case, least = SMOOTH_CASES[name], least_snr(SMOOTH_CASES[name])
    assert figures(case)["snr_db_min"] == pytest.approx(20 * math.log10(least), abs=0.002)


OVER_FRAME_DB = {  # reached: light falls to a corner by up to 20 dB, and shares are counted to 1/377 of the image
    "two lamps, clear water": 0.1, "flat port, measured water, tilt outward": 0.1, "most turbid": 0.2,
}  # fmt: skip


@KEPT.values
def snr_of_twentieth(case: Case) -> float:
    """What 95 % of 65 x 65 pixels reach."""
    cells = (np.arange(65) + 0.5) * 2.0 / 65 - 1.0
    at = (case, cells[:, None], cells[None, :])
    signal, veil = electrons_at(*at), floor_veil_at(*at) + backscatter_at(*at)
    counted = np.sort((signal / np.sqrt(noise_variance(signal + veil))).ravel())
    return float(counted[int(0.05 * counted.size)])


@pytest.mark.parametrize("name", OVER_FRAME_DB)
def test_snr_that_95_percent_of_the_image_reach(name: str) -> None:
    twentieth = 20 * math.log10(snr_of_twentieth(SMOOTH_CASES[name]))
    assert figures(SMOOTH_CASES[name])["snr_db_p05"] == pytest.approx(twentieth, abs=OVER_FRAME_DB[name])


@pytest.mark.parametrize(("half_angle", "lamps"), [(8.0, (Lamp(y=0.3),)), (12.0, pair(0.5))])
def test_places_of_the_frame_are_enough_for_small_spots(half_angle: float, lamps: tuple[Lamp, ...]) -> None:
    # light falls by 3 dB from one place to the next at the image's edge: against cells of 1/129 of its side
    case, cells = Case(half_angle=half_angle, lamps=lamps), (np.arange(129) + 0.5) * 2.0 / 129 - 1.0
    counted = np.sort(electrons_at(case, cells[:, None], cells[None, :]).ravel())
    along, across = frame_places(np.ones(1), np.ones(1))
    reached = reached_by_most(electrons_at(case, across[0], along[0]), FRAME_MAY_MISS)
    assert 20 * math.log10(float(reached)) == pytest.approx(
        20 * math.log10(float(counted[int(0.05 * counted.size)])), abs=0.7
    )


def test_a_pixel_without_light_has_no_snr_in_decibel() -> None:
    got = figures(SHARP_CASES["two small discs"])
    assert got["snr_db_min"] is None
    assert got["floor_illuminance_min_lx"] == got["uniformity"] == 0.0


# ---------------------------------------------------------------- light on the floor


@pytest.mark.parametrize("name", SMOOTH_CASES)
def test_floor_illuminance_over_the_traced_footprint(name: str) -> None:
    case = SMOOTH_CASES[name]
    nodes, weights = gauss(-1.0, 1.0, 32)
    u, v = nodes[:, None], nodes[None, :]
    area = floor_area(case, u, v)
    mean_lx = float(weights @ (lux_at(case, u, v) * area) @ weights / (weights @ area @ weights))
    border = np.linspace(-1.0, 1.0, 41)
    least_lx = float(lux_at(case, border[:, None], border[None, :]).min())
    got = figures(case)
    assert got["floor_illuminance_mean_lx"] == pytest.approx(mean_lx, rel=SMOOTH)
    assert got["floor_illuminance_min_lx"] == pytest.approx(least_lx, rel=SMOOTH)
    assert got["uniformity"] == pytest.approx(least_lx / mean_lx, rel=SMOOTH)


@pytest.mark.parametrize("name", ["two small discs", "two cones, flat port", "wide tilted discs, turbid"])
def test_mean_floor_illuminance_under_beams_that_end_sharply(name: str) -> None:
    case = SHARP_CASES[name]
    assert figures(case)["floor_illuminance_mean_lx"] == pytest.approx(sharp_lux(case), rel=SHARP)


def floor_area(case: Case, u: Array, v: Array) -> Array:
    """Area of floor per unit of u and v, by differences."""
    rays, step = Rays(case), 1e-4
    ahead, behind = rays.floor(u + step, v), rays.floor(u - step, v)
    right, left = rays.floor(u, v + step), rays.floor(u, v - step)
    along = [(a - b) / (2 * step) for a, b in zip(ahead[:2], behind[:2], strict=True)]
    across = [(a - b) / (2 * step) for a, b in zip(right[:2], left[:2], strict=True)]
    return np.asarray(np.abs(along[0] * across[1] - along[1] * across[0]))


def lux_at(case: Case, u: Array, v: Array, only: int | None = None) -> Array:
    """Illuminance of the floor where the pixels u, v look; edges of beams not yet cut."""
    rays, k = Rays(case), legs(case).lamp
    share = resampled(*column("photopic_v.csv", "V"), outside=0.0) * led() * STEPS_NM * LUMENS_PER_W
    x, y, _, _ = rays.floor(u, v)
    total = np.zeros(np.broadcast(u, v).shape)
    for number, at in enumerate(case.lamps):
        if only in (None, number):
            length, cos_beam, cos_floor = rays.lamp(x, y, at)
            lux = case.flux_lm / len(case.lamps) * intensity(case, cos_beam) * cos_floor / length**2
            total += lux * (np.exp(-k * length[..., None]) @ share)
    return total


# ---------------------------------------------------------------- exposure and noise


def test_the_exposure_offset_adds_to_the_exposure() -> None:
    # 13.73 us on 1 ms
    case = replace(Case(), camera=(("exposure_offset_us", 13.73),))
    assert figures(case)["electrons_signal"] == pytest.approx(smooth_electrons(Case()) * 1.01373, rel=SMOOTH)


def test_a_pulse_shorter_than_the_exposure_counts_alone() -> None:
    case = replace(
        Case(),
        camera=(("exposure_offset_us", 13.73),),
        light=(("kind", "pulsed_led"),),
        settings=(("pulse_ms", 0.5),),
    )
    assert figures(case)["electrons_signal"] == pytest.approx(smooth_electrons(Case()) * 0.5, rel=SMOOTH)


@pytest.mark.parametrize(
    ("duration_us", "at_frac", "exposure_ms", "lumen_seconds"),
    [
        (500.0, 1.0, 1.0, 700.0), (2000.0, 1.0, 1.0, 350.0), (500.0, 1.0, 0.25, 350.0),
        # t0.5 = 2 ms: 1 - 0.5^0.5 of the light in 1 ms, of the 99 % that count; t0.1 = 0.5 ms: over after 1 ms
        (2000.0, 0.5, 1.0, 700.0 * (1.0 - 0.5**0.5) / 0.99), (500.0, 0.1, 1.0, 700.0),
        (2000.0, None, 0.6, 700.0 * (1.0 - 0.07**0.3) / 0.99),  # not told: that of its class
    ],
)  # fmt: skip
def test_a_flash_gives_its_lumen_seconds_or_what_comes_while_the_shutter_is_open(
    duration_us: float, at_frac: float | None, exposure_ms: float, lumen_seconds: float
) -> None:
    # 20 J at 35 lm s/J = 700 lm s; the base case collects 4000 lm for 1 ms, 4 lm s
    system = Case().system()
    system["light"] = {
        "kind": "flash", "flash_energy_j": 20, "flash_efficacy_lm_s_per_j": 35, "flash_duration_us": duration_us,
        "spectrum": "generic-led", "beam": "cosine-power", "beam_half_angle_deg": 40,
    } | ({} if at_frac is None else {"flash_duration_at_frac": at_frac})  # fmt: skip
    system["settings"] = {"f_number": 4.0, "exposure_ms": exposure_ms, "gain": 1.0}
    design = uwopt.evaluate(Case().mission(), system).design
    assert design is not None
    got = design.scenes[0].figures["electrons_signal"]
    assert got == pytest.approx(smooth_electrons(Case()) * lumen_seconds / 4.0, rel=SMOOTH)


def noise_variance(light: Any, dark: float = 0.0, prnu: float = 0.0) -> Any:
    """(7) with read noise 2.4 e and the quantisation of 0.35 DN/e; all light counts, veils included."""
    return 2.4**2 + 1 / 12 / 0.35**2 + light + dark + (prnu * light) ** 2


def snr_by_hand(electrons: float, dark: float = 0.0, prnu: float = 0.0, veil: float = 0.0) -> float:
    """Image-forming electrons over the noise."""
    return electrons / math.sqrt(noise_variance(electrons + veil, dark, prnu))


def test_snr_and_level_with_dark_current_offset_quantisation_and_prnu() -> None:
    camera = (("dark_current_e_s", 500.0), ("black_level_dn", 12.0), ("prnu_frac", 0.02))
    bright = Case(water="I", altitude=1.0, lamps=pair(0.3))
    got, electrons, veil = (
        figures(replace(bright, camera=camera)),
        smooth_electrons(bright),
        sum(veil_means(bright)),
    )
    assert electrons > 100.0  # so that every term counts
    assert got["electrons_dark"] == pytest.approx(0.5)  # 500 e/s for 1 ms
    assert got["snr"] == pytest.approx(snr_by_hand(electrons, 0.5, 0.02, veil), rel=SMOOTH)
    assert got["mean_dn"] == pytest.approx(0.35 * (electrons + veil + 0.5) + 12.0, rel=SMOOTH)
    assert got["mean_level"] == pytest.approx(got["mean_dn"] / 4095.0, rel=1e-12)
    assert got["saturation_fraction"] == pytest.approx(1.5 * got["mean_level"], rel=1e-12)


def test_snr_over_a_band_of_altitudes_is_that_of_its_far_end_with_the_focus_held() -> None:
    case = Case(tolerance=0.5, needs=(("min_snr_db", 3.0),))
    far = replace(Case(), altitude=2.5, focus=2.0)
    margin = next(row for row in scene(case).margins if row.requirement == "min_snr_db")
    assert margin.at_altitude_m == 2.5
    # dB: an error of 1e-4 in electrons is 0.001 dB
    expected = 20 * math.log10(snr_by_hand(smooth_electrons(far), veil=sum(veil_means(far))))
    assert margin.value == pytest.approx(expected, abs=0.002)


# ---------------------------------------------------------------- geometry


@pytest.mark.parametrize("name", ["one lamp, dome", "wide flat port, tilt inward"])
def test_footprint_and_pixels_are_those_of_traced_rays(name: str) -> None:
    case = SMOOTH_CASES[name]
    rays, got = Rays(case), figures(case)
    nearer = case.f_number / working_f_number(case)  # a lens moved out by f m sees 1 / (1 + m) of its field
    reach_along, reach_across = (
        rays.floor(np.array(nearer), np.array(0.0))[0],
        rays.floor(np.array(0.0), np.array(nearer))[1],
    )
    assert got["fov_y_m"] == pytest.approx(2 * float(reach_along), rel=1e-9)
    assert got["fov_x_m"] == pytest.approx(2 * float(reach_across), rel=1e-9)
    # pixels by tracing their two edges, all over the image; the smallest of a lens that moves out, or does not
    u, v = np.meshgrid(np.linspace(-1, 1, 101), np.linspace(-1, 1, 101), indexing="ij")
    half = rays.pixel / rays.tan_along / 2
    along_m = rays.floor(u + half, v)[0] - rays.floor(u - half, v)[0]
    assert got["gsd_mm"] == pytest.approx(1e3 * float(along_m.max()), rel=1e-5)
    closer_m = rays.floor(nearer * (u + half), nearer * v)[0] - rays.floor(nearer * (u - half), nearer * v)[0]
    least_m = min(float(along_m.min()), float(closer_m.min()))
    assert got["exposure_max_ms"] == pytest.approx(1e3 * least_m / 0.3, rel=1e-4)


@pytest.mark.parametrize(
    "case", [Case(f_number=2.0, focal_mm=12.0), replace(FLAT, f_number=2.8, altitude=1.5)]
)
def test_points_at_both_ends_of_the_depth_of_field_blur_to_two_pixels(case: Case) -> None:
    focal_m, got = case.focal_mm * 1e-3, figures(case)

    def image_m(range_m: float) -> float:
        return 1.0 / (1.0 / focal_m - 1.0 / object_distance_m(case, range_m))

    for end_m in (got["dof_near_m"], got["dof_far_m"]):
        blur_m = focal_m / case.f_number * abs(image_m(case.altitude) / image_m(end_m) - 1.0)
        assert blur_m == pytest.approx(2 * 3.45e-6, rel=1e-6)


# ---------------------------------------------------------------- limits


def murky(folder: Path, c_per_m: float) -> str:
    file = folder / "murky.csv"
    file.write_text(f"wavelength_nm,attenuation_per_m\n380,{c_per_m}\n780,{c_per_m}\n", encoding="utf-8")
    return str(file)


@pytest.mark.parametrize("c_per_m", [0.0, 1.0, 30.0])
def test_electrons_stay_right_down_to_1e_100(tmp_path: Path, c_per_m: float) -> None:
    case = Case(water=murky(tmp_path, c_per_m))
    water_loss.cache_clear()
    legs.cache_clear()
    got, expected = figures(case), smooth_mean(case, order=64)
    assert got["electrons_signal"] == pytest.approx(expected, rel=SMOOTH)
    assert got["snr_db"] == pytest.approx(20 * math.log10(snr_by_hand(expected)), abs=0.002)


@pytest.mark.parametrize("c_per_m", [500.0, 1e5])
@pytest.mark.parametrize("beam", ["cosine-power", "disc", "tabulated"])
def test_water_like_ink_gives_no_signal_and_no_nonsense(tmp_path: Path, c_per_m: float, beam: str) -> None:
    got = figures(Case(water=murky(tmp_path, c_per_m), beam=beam))
    assert got["electrons_signal"] == got["snr"] == 0.0
    assert got["snr_db"] is None
    assert all(math.isfinite(value) for value in got.values() if isinstance(value, float))


def test_near_the_axis_a_flat_port_sees_what_a_dome_sees_divided_by_the_index() -> None:
    # close to the axis a flat port's picture is n_w times narrower, and a dome's rays start one radius behind
    n_w = float(water_index(Case(), np.array([RAYS_NM]))[0])
    flat = replace(Case(), dome=False, gap=0.0, thickness=1e-4, focal_mm=200.0)
    dome = replace(Case(), radius=0.1, focal_mm=200.0)
    scale = figures(dome)["gsd_mm"] / figures(flat)["gsd_mm"]
    assert scale == pytest.approx(n_w * (2.0 + 0.1) / 2.0, rel=1e-3)  # tan and sin differ by 1e-4 at 1.2 deg


def test_the_means_that_are_kept_are_of_this_file_and_these_tables() -> None:
    assert KEPT.is_current, HINT


def test_a_kept_mean_is_what_is_worked_out() -> None:
    case = SHARP_CASES["two small discs"]
    rounding = 1e-9  # of another machine
    assert sharp_electrons(case) == pytest.approx(sharp_mean(case, electrons_at), rel=rounding)

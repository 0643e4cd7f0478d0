"""What the shipped tables say of water, floor, sensor and lamp, read without uwopt's help."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from second_physics.case import (
    BACK_SHARE,
    DATA,
    KEPT,
    LUMENS_PER_W,
    REFERENCE,
    STEPS_NM,
    WAVES_NM,
    Array,
    Case,
    gauss,
)


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

"""Rays from the pixels to the floor, and what comes back along them: signal, forward veil, backscatter."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from second_physics.case import LIGHT_M_S, PLANCK_J_S, RAYS_NM, STEPS_NM, WAVES_NM, Array, Case, Lamp, gauss
from second_physics.lobes import intensity, met_phase
from second_physics.tables import (
    efficiency,
    floor_reflectance,
    led,
    legs,
    molecule_phase,
    scattering,
    water_index,
)


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

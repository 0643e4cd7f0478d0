"""Where a lamp's light goes, and how light that is scattered on its way widens that."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator, RectBivariateSpline
from scipy.special import eval_legendre

from second_physics.case import RAYS_NM, STEPS_NM, Array, Case, gauss
from second_physics.tables import (
    floor_reflectance,
    led,
    legs,
    molecules_beyond,
    particle_phase,
    particles_beyond,
    rows_of,
    scattering,
    water_index,
)


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

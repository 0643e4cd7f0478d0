"""How far the Monte Carlo can be trusted: known numbers, plain quadrature, a second estimator."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from . import camera, cases, photons, slabs, walk

ALBEDOS, COSINES = (0.5, 0.9, 0.99), (1.0, 0.3)
N_SLAB = 200_000
N_WALKS, N_PHOTONS = 100_000, 2_000_000
SINGLE = (8, 29, 50, 63)  # cases of the table followed in single scattering
TWICE = {"hg 0.8": (2.0, 0.8, 0.4), "isotropic": (2.0, 0.8, 0.4)}  # phase function: c d, albedo, baseline over altitude
TURNS_DEG = (25.0, 35.0, 45.0)  # see `camera`: the answer must not depend on it


class Check(NamedTuple):
    """A number found twice."""

    name: str
    known: float
    found: float
    error: float  # one standard error

    @property
    def sigma(self) -> float:
        """Difference in standard errors."""
        return (self.found - self.known) / self.error


@cache
def half_spaces() -> tuple[Check, ...]:
    """Plane albedo of an isotropic half-space."""
    found = []
    for n, (albedo, mu) in enumerate((w, mu) for w in ALBEDOS for mu in COSINES):
        water = walk.water_of(1.0, albedo, walk.phase_of("isotropic"))
        seen = slabs.fate(water, slabs.ENDLESS, mu, N_SLAB, n)
        found.append(
            Check(f"albedo {albedo:g}, cosine {mu:g}", slabs.plane_albedo(mu, albedo), seen.reflected, seen.error)
        )
    return tuple(found)


@cache
def hulst() -> tuple[slabs.Fate, tuple[Check, Check]]:
    """The slab of van de Hulst."""
    known = slabs.HULST
    water = walk.water_of(1.0, float(known["albedo"]), walk.phase_of(str(known["phase"])))
    seen = slabs.fate(water, float(known["thickness"]), 1.0, 2 * N_SLAB, 99)
    back = Check("reflected", float(known["reflected"]), seen.reflected, seen.error)
    on = Check("transmitted", float(known["transmitted"]), seen.transmitted, seen.error * 1.6)
    return seen, (back, on)


@cache
def single_scattering() -> tuple[Check, ...]:
    """Backscatter of one order, c on both legs, against uwopt's quadrature: image means."""
    from . import model

    found = []
    for case in (case for case in cases.drawn_cases() if case.number in SINGLE):
        seen = camera.seen(*cases.setting(case), 4 * N_WALKS, case.number, orders=1)
        known = model.uwopt_light(case, "mean", model.lost(case))["backscatter"]
        name = f"{case.phase}, c d = {case.thickness:.1f}"
        found.append(Check(name, known, float(seen.mean[2]), float(seen.error[2])))
    return tuple(found)


def plain_case(phase: str, thickness: float, albedo: float, baseline: float) -> cases.Case:
    """A lamp of 40 deg beside a camera, straight down."""
    field = float(2 * np.rad2deg(np.arctan(0.5)))
    return cases.Case(0, "check", phase, thickness, albedo, 1.0, baseline, 0.0, 40.0, field, 0.3)


@cache
def two_estimators() -> tuple[tuple[Check, float], ...]:
    """Walks from the camera (known) and photons from the lamp; how far the largest batch of photons stands out."""
    found = []
    for phase, how in TWICE.items():
        setting = cases.setting(plain_case(phase, *how))
        one, other = camera.seen(*setting, N_WALKS, 1), photons.seen(*setting, N_PHOTONS, 2)
        for k, tally in enumerate(cases.TALLIES):
            error = float(np.hypot(one.error[k], other.error[k]))
            both = Check(f"{phase}, {tally}", float(one.mean[k]), float(other.mean[k]), error)
            found.append((both, float(other.largest[k])))
    return tuple(found)


@cache
def turns() -> tuple[Check, ...]:
    """Backscatter at other angles from which a turn counts as large, against the one in use."""
    water, lamp, view = cases.setting(plain_case("ff 0.0183", 4.0, 0.9, 0.3))
    one, used, other = (camera.seen(water, lamp, view, N_WALKS, 7, turn_deg=turn) for turn in TURNS_DEG)
    found = []
    for turn, seen in ((TURNS_DEG[0], one), (TURNS_DEG[2], other)):
        error = float(np.hypot(seen.error[2], used.error[2]))
        found.append(Check(f"{turn:g}°", float(used.mean[2]), float(seen.mean[2]), error))
    return tuple(found)


def heavy_tail() -> tuple[float, float]:
    """Largest batch over the mean of the forward veil of a sea's phase function: by photons, and by walks."""
    setting = cases.setting(plain_case("ff 0.0183", 1.0, 0.85, 1.0))
    by_photons = photons.seen(*setting, N_PHOTONS // 4, 3).largest[1]
    return float(by_photons), float(camera.seen(*setting, N_WALKS // 4, 3).largest[1])



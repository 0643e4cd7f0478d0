"""Least squares of test shots: light times reflectance, and the water where the shots tell it.

    ln(level - dark) = ln DN(s, a, b) + error

s is a factor on light times reflectance, a one on the water's attenuation, b one on its backscatter. All are fitted as
logarithms. Relative errors of all shots are taken as alike (lamp, distance, flatness of the target), beside half a
number of the reading. What the shots do not tell is held as the mission has it: fitted and left free it would be
nonsense. Intervals are those of the Jacobian with the variance of the residuals and Student's t.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy.optimize import least_squares
from scipy.special import stdtrit

from uwopt.arrays import Array
from uwopt.errors import SolverError
from uwopt.solvers.calibration.light import MURKIEST, ShotLight

Name = Literal["light", "water", "back"]

LEVEL = 0.95  # of intervals
WIDEST = float(np.log(2.0))  # half of an interval's logarithm: what is not known within a factor of two is held
FARTHEST = 20.0  # the same of an interval that says nothing
AT_END = 0.999  # of the range of a logarithm: so near, it has run away
RANGES: dict[Name, float] = {"light": np.log(1e4), "water": np.log(MURKIEST), "back": np.log(30.0)}
LEAST_VEIL = 1e-4  # of the light: less backscatter shows in no level
READ_DN, RELATIVE = 0.5, 0.01  # what a reading errs by: half a number, and a share that is found from the residuals
OUTLIER, NEVER_BELOW = 5.0, 0.03  # times the residuals' usual size, and a share that any shot may be off
MOST_OUTLIERS = 0.25  # of all shots; more of them, and the model is wrong rather than they
SPARE_FOR_OUTLIERS = 4  # shots more than factors: with fewer, which of them is off is not told
TO_SIGMA = 1.4826  # of the median of sizes to a standard deviation


@dataclass(frozen=True)
class Fitted:
    """One factor: its value, its interval where it has one, and why it was held where it was."""

    name: Name
    value: float = 1.0
    low: float | None = None
    high: float | None = None
    held: str = ""  # why; empty: fitted


@dataclass(frozen=True)
class Fit:
    """What came of a fit: the factors, what each shot should read by them, and the shots that were left out of it."""

    factors: dict[Name, Fitted]
    predicted_dn: Array  # of all shots
    residual_frac: Array  # measured over predicted, less 1
    outlier: Array
    rms_frac: float  # of the shots that were taken
    freedom: int  # shots less factors


def fitted(light: ShotLight, net_dn: Array, *, distances_m: Array) -> Fit:
    """The factors that fit the shots best; raises SolverError where there is nothing to fit."""
    n = len(net_dn)
    if n < 2:
        raise SolverError("one shot says nothing of its own error; two that can be used are the least")
    held = held_from_the_start(light, distances_m)
    outlier = outliers(light, net_dn, [name for name in RANGES if name not in held])
    kept = np.flatnonzero(~outlier)
    some, level = light.take(kept), net_dn[kept]
    while True:
        free = [name for name in RANGES if name not in held]
        found = solve(some, level, free)
        half = half_widths(found.jac, found.fun)
        wide = {name: width for name, width in zip(free, half, strict=True) if name != "light"}
        ended = [name for name, x in zip(free, found.x, strict=True) if abs(x) > AT_END * RANGES[name]]
        lost = max(wide, key=lambda name: wide[name], default=None)
        runaway = next((name for name in ended if name != "light"), None)
        if runaway is None and (lost is None or wide[lost] <= WIDEST):
            break
        drop = runaway or lost
        assert drop is not None
        held[drop] = reason(drop, wide[drop], runaway is not None)
    factors = {name: Fitted(name, held=why) for name, why in held.items()}
    for name, x, width in zip(free, found.x, half, strict=True):
        ends = (float(np.exp(x - width)), float(np.exp(x + width))) if width < FARTHEST else (None, None)
        factors[name] = Fitted(name, float(np.exp(x)), *ends)
    predicted = light.net_dn(**{name: one.value for name, one in factors.items()})
    off = net_dn / predicted - 1.0
    rms = float(np.sqrt(np.mean(np.square(off[kept]))))
    return Fit({name: factors[name] for name in RANGES}, predicted, off, outlier, rms, len(kept) - len(free))


def held_from_the_start(light: ShotLight, distances_m: Array) -> dict[Name, str]:
    """What no fit need be tried for."""
    held: dict[Name, str] = {}
    if len(set(np.round(distances_m, 6))) < 2:
        why = f"all shots are from {distances_m[0]:g} m: only another distance tells water from light"
        return {"water": why, "back": why}
    if not light.has_veil or np.max(np.exp(light.back(0.0) - light.signal(0.0))) < LEAST_VEIL:
        held["back"] = f"the model has less than {100 * LEAST_VEIL:g} % of it in every shot"
    return held


def reason(name: Name, half_width: float, runaway: bool) -> str:
    """Why a factor is held."""
    if runaway:
        return f"the fit runs to the end of what is tried, a factor of {np.exp(RANGES[name]):.3g}"
    if not np.isfinite(half_width):
        return "there are too few shots for it"
    return f"the shots tell it within a factor of {np.exp(half_width):.2g} only"


def solve(light: ShotLight, net_dn: Array, free: list[Name], *, robust: bool = False) -> Any:
    """Least squares over the free factors' logarithms; each residual in units of a per cent."""
    weight = RELATIVE * np.hypot(1.0, READ_DN / (RELATIVE * net_dn))

    def factors(x: Array) -> dict[str, float]:
        return {"light": 1.0} | {name: float(np.exp(value)) for name, value in zip(free, x, strict=True)}

    def residuals(x: Array) -> Array:
        return np.asarray(np.log(net_dn / light.net_dn(**factors(x))) / weight)

    def jacobian(x: Array) -> Array:
        rises = light.with_rises(**factors(x))[1]
        return np.stack([-rises[name] / weight for name in free], axis=1)

    start = np.zeros(len(free))
    level = float(np.median(np.log(net_dn / light.net_dn(1.0))))
    start[free.index("light")] = np.clip(level, -0.9 * RANGES["light"], 0.9 * RANGES["light"])
    ends = np.array([RANGES[name] for name in free])
    loss, enough = ("soft_l1", 1e-5) if robust else ("linear", 1e-10)
    return least_squares(
        residuals, start, jac=jacobian, bounds=(-ends, ends), loss=loss, xtol=enough, ftol=enough, gtol=enough
    )


def half_widths(jacobian: Array, residuals: Array) -> Array:
    """Half of each interval's logarithm; inf where the shots leave it open.

        t(0.975, n - p) sqrt(s^2 (J^T J)^-1),   s^2 the residuals' variance
    """
    n, p = jacobian.shape
    if n <= p:
        return np.full(p, np.inf)
    variance = float(np.sum(np.square(residuals))) / (n - p)
    size = np.linalg.norm(jacobian, axis=0)
    if (size == 0.0).any() or np.linalg.cond(jacobian / size) > 1e7:
        return np.full(p, np.inf)
    scaled = np.linalg.inv((jacobian / size).T @ (jacobian / size))
    spread = np.sqrt(variance * np.diag(scaled)) / size
    return np.asarray(stdtrit(n - p, 0.5 * (1.0 + LEVEL)) * spread)


def outliers(light: ShotLight, net_dn: Array, free: list[Name]) -> Array:
    """Shots that a robust fit of all leaves far off; none where they are too many to be errors of single shots."""
    none = np.zeros(len(net_dn), bool)
    if len(net_dn) < len(free) + SPARE_FOR_OUTLIERS:
        return none
    found = solve(light, net_dn, free, robust=True)
    predicted = light.net_dn(**{name: float(np.exp(x)) for name, x in zip(free, found.x, strict=True)})
    off = np.log(net_dn / predicted)
    usual = TO_SIGMA * float(np.median(np.abs(off - np.median(off))))
    far = np.abs(off - np.median(off)) > np.maximum(OUTLIER * usual, NEVER_BELOW + READ_DN / net_dn)
    return far if far.sum() <= MOST_OUTLIERS * len(net_dn) else none

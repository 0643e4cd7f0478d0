"""Whether a point is what a solver says it is: rules checked one by one, and the conditions of an optimum.

The rules are evaluated here in their own terms (electrons, digital numbers, seconds), not as the
logarithms that the solvers see. Derivatives come from complex steps, so that they owe nothing to the
automatic differentiation they are compared with.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.solvers.continuous.pieces import SmoothScene, SmoothSettings
from uwopt.solvers.continuous.program import Smooth, names_of_rules

COMPLEX_STEP = 1e-30  # nothing is subtracted, so it may be as small as it likes
ACTIVE = 1e-6  # a rule this close to its limit, in logarithms, may carry a multiplier


@dataclass(frozen=True)
class Attempt:
    """One run of a solver from one start, before anything of it is believed."""

    x: Array
    iterations: int
    message: str  # what the solver says of it
    multipliers: Array  # by rule, in the order of `rule_names`
    kkt_residual: float


def violations(
    scenes: Sequence[SmoothScene],
    settings: Sequence[SmoothSettings],
    *,
    motorised: bool,
    light_limit_w: float,
) -> dict[str, float]:
    """By how much, relatively, each rule is missed; negative where there is room."""
    found: dict[str, float] = {}
    for index, (scene, at) in enumerate(zip(scenes, settings, strict=True)):
        found.update({f"{name}[{index}]": value for name, value in _of_scene(scene, at).items()})
        power_w = scene.light_power_w(at)
        if np.isfinite(light_limit_w):
            found[f"power_limit[{index}]"] = _over(power_w, light_limit_w)
    if not motorised:
        numbers = [at.f_number for at in settings]
        found["common_f_number"] = max(numbers) / min(numbers) - 1.0
    return {name: float(value) if np.isfinite(value) else np.inf for name, value in found.items()}


def _of_scene(scene: SmoothScene, at: SmoothSettings) -> dict[str, float]:
    found = {
        "f_number_low": _over(scene.n_low, at.f_number),
        "f_number_high": _over(at.f_number, scene.n_high),
        "time_low": _over(scene.time_min_s, at.time_s),
        "time_high": _over(at.time_s, scene.time_max_s),
        "gain_low": _over(scene.min_gain, at.gain),
        "gain_high": _over(at.gain, scene.max_gain),
    }
    if not scene.dims_freely:
        found["level"] = min(abs(at.level / step - 1.0) for step in scene.levels)
    else:
        found["level_low"] = _over(scene.min_level, at.level)
        found["level_high"] = _over(at.level, scene.max_level)
    for pixel, (signal_e, total_e, wanted) in enumerate(scene.wanted):
        reached = scene.snr(signal_e, at, total_e=total_e)
        found[f"min_snr_{pixel}"] = 1.0 - reached / wanted
    for altitude, signal_e in enumerate(scene.total_e):
        digital_dn = scene.digital_dn(signal_e, at, offset_dn=scene.black_level_dn)
        found[f"saturation_{altitude}"] = _over(scene.highlight_ratio * digital_dn, scene.full_scale_dn)
        collected_e = scene.electrons(signal_e, at) + scene.dark_e(at)
        if np.isfinite(scene.well_e):
            found[f"full_well_{altitude}"] = _over(scene.highlight_ratio * collected_e, scene.well_e)
    if scene.mean_level is not None:
        nominal_dn = scene.digital_dn(scene.total_e[scene.nominal], at, offset_dn=scene.black_level_dn)
        found["mean_level"] = abs(nominal_dn / (scene.mean_level * scene.full_scale_dn) - 1.0)
    return found


def _over(value: float, limit: float) -> float:
    return value / limit - 1.0 if limit > 0.0 else (-1.0 if value <= limit else np.inf)


@dataclass(frozen=True)
class Derivatives:
    """Rules and objective at a point with their gradients; bounds of the unknowns are rules as well."""

    objective: float
    gradient: Array  # (n,) of the objective
    values: Array  # (n_rules,): inequalities, lower bounds, upper bounds, then equalities
    jacobian: Array  # (n_rules, n)
    n_equalities: int


def derivatives(program: Smooth, x: Array) -> Derivatives:
    """Values and gradients of a program by complex step, all unknowns in one evaluation."""
    n = len(x)
    steps = np.concatenate([np.zeros((n, 1)), np.eye(n)], axis=1)
    rules = program.rules(list(np.asarray(x)[:, None] + 1j * COMPLEX_STEP * steps))

    def split(value: Any) -> Array:
        return np.broadcast_to(np.asarray(value, complex), (n + 1,))

    objective = split(rules.objective)
    low, high = program.bounds
    inequalities, equalities = (
        np.array([split(v) for v in some.values()]).reshape(-1, n + 1)
        for some in (rules.inequalities, rules.equalities)
    )

    def gradients(rows: Array) -> Array:
        return rows[:, 1:].imag / COMPLEX_STEP

    return Derivatives(
        objective=float(objective[0].real),
        gradient=objective[1:].imag / COMPLEX_STEP,
        values=np.concatenate([inequalities[:, 0].real, low - x, x - high, equalities[:, 0].real]),
        jacobian=np.concatenate([gradients(inequalities), -np.eye(n), np.eye(n), gradients(equalities)]),
        n_equalities=len(equalities),
    )


def rule_names(program: Smooth) -> list[str]:
    """Names of a program's rules in the order of `Derivatives.values`."""
    inequalities, equalities = names_of_rules(program)
    low = [f"{name} at least" for name in program.names]
    return inequalities + low + [f"{name} at most" for name in program.names] + equalities


def kkt_residual(at: Derivatives, multipliers: Array) -> float:
    """How far a point and multipliers are from the conditions of an optimum; 0: exactly there.

    The largest of: the Lagrangian's gradient, multiplier times slack, an inequality's negative multiplier,
    all divided by the largest multiplier if that exceeds 1; and what any rule, epigraph included, is missed
    by. All quantities are logarithms, so no unit enters.
    """
    n_inequalities = len(at.values) - at.n_equalities
    stationarity = at.gradient + at.jacobian.T @ multipliers
    complementarity = (multipliers * at.values)[:n_inequalities]
    wrong_sign = np.minimum(multipliers[:n_inequalities], 0.0)
    missed = np.append(np.maximum(at.values[:n_inequalities], 0.0), at.values[n_inequalities:])
    scale = max(1.0, float(np.abs(multipliers).max(initial=0.0)))
    parts = (stationarity / scale, complementarity / scale, wrong_sign / scale, missed)
    return max(float(np.abs(part).max(initial=0.0)) for part in parts)


def optimality_gap(at: Derivatives, multipliers: Array, x: Array, low: Array, high: Array) -> float:
    """By how much at most the objective at a point exceeds that of any point that meets the rules.

        f(x) - f(y) <= -lambda g(x) - nu h(x) - min over low <= y <= high of (y - x) grad L(x)

    The Lagrangian of a convex program lies above its tangent, and below the objective wherever the rules hold.
    The bounds are taken as they are, without multipliers. Infinite where something is no number.
    """
    n = len(x)
    cut = len(at.values) - at.n_equalities - 2 * n
    kept = np.r_[0:cut, cut + 2 * n : len(at.values)]
    given = np.where(kept < cut, np.maximum(multipliers[kept], 0.0), multipliers[kept])
    slope = at.gradient + at.jacobian[kept].T @ given
    below = np.minimum(slope * (low - x), slope * (high - x)).sum()
    gap = -float(given @ at.values[kept]) - float(below)
    return gap if np.isfinite(gap) else np.inf


def fitted_multipliers(at: Derivatives) -> Array:
    """Multipliers that come closest to the conditions of an optimum, for solvers that return none.

    Least squares over the rules that are at their limit, non-negative for inequalities.
    """
    n_inequalities = len(at.values) - at.n_equalities
    active = np.nonzero(at.values[:n_inequalities] > -ACTIVE)[0]
    equal = np.arange(n_inequalities, len(at.values))
    columns = np.concatenate([at.jacobian[active], at.jacobian[equal], -at.jacobian[equal]]).T
    multipliers = np.zeros(len(at.values))
    if columns.size and np.all(np.isfinite(columns)) and np.all(np.isfinite(at.gradient)):
        from scipy.optimize import nnls  # only solvers without multipliers need it: 0.3 s to import

        share, _ = nnls(columns, -at.gradient)
        multipliers[active] = share[: len(active)]
        multipliers[equal] = share[len(active) : len(active) + len(equal)] - share[len(active) + len(equal) :]
    return multipliers

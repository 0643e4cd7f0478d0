"""Settings that are best for an objective: least power, greatest signal to noise, or a weighing of both."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.model import sensor
from uwopt.objectives.objective import Objective
from uwopt.rows import SceneRows
from uwopt.solvers import settings as closed_form

Array = NDArray[Any]
DARK_ROUNDS = 25
FAINTEST = 1e-6  # of the highest SNR: where a weighing starts when nothing asks for light


def best_settings(
    rows: list[SceneRows], motorised: Array, objective: Objective, camera_power_w: Array, power_limit_w: float
) -> tuple[list[closed_form.Chosen], Array, Array]:
    """Settings that are best for an objective, whether they exist, and the worst scene's SNR in dB.

    Dark current depends on the exposure that is chosen, so the closed form is taken again with the
    exposure of the last round, from the shortest up; dark electrons are few, and two or three rounds
    settle it. Where they are many, the fixed point is feasible but need not be the joint optimum.
    """
    rows = [replace(r, dark_time_s=np.maximum(r.exposure_s(r.time_min_s), 0.0)) for r in rows]
    for _ in range(DARK_ROUNDS):
        chosen, feasible, snr_db = settings_at_dark(rows, motorised, objective, camera_power_w, power_limit_w)
        updated = [closed_form.with_exposure(r, c) for r, c in zip(rows, chosen, strict=True)]
        if all(
            np.allclose(closed_form.dark_e(a), closed_form.dark_e(b), rtol=0, atol=1e-10)
            for a, b in zip(rows, updated, strict=True)
        ):
            break
        rows = updated
    return chosen, feasible, snr_db


def settings_at_dark(
    rows: list[SceneRows], motorised: Array, objective: Objective, camera_power_w: Array, power_limit_w: float
) -> tuple[list[closed_form.Chosen], Array, Array]:
    """Best settings with the dark electrons of the rows.

    Without SNR in the objective least power is best for every term. With SNR alone the highest reachable
    is found first, then the least power that reaches it. A weighted sum is convex along the SNR floor.
    """
    weight = objective.weight("snr_db")
    if not weight:
        chosen, feasible = closed_form.least_power(rows, motorised)
    else:
        top = closed_form.greatest_snr(rows, motorised, power_limit_w - camera_power_w)
        goal = np.nan_to_num(top, nan=0.0) * (1 - 1e-12)
        if objective.single is None and objective.weight("power"):
            goal = weighted_goal(rows, motorised, goal, objective.weight("power"), weight)
        chosen, feasible = closed_form.least_power(rows, motorised, snr_floor=goal)
        feasible &= np.isfinite(top)
    snr = np.min([closed_form.nominal_snr(r, c.light_x) for r, c in zip(rows, chosen, strict=True)], axis=0)
    with np.errstate(invalid="ignore"):
        return chosen, feasible, np.asarray(sensor.to_db(np.where(snr > 0, snr, np.nan)))


def weighted_goal(
    rows: list[SceneRows], motorised: Array, top: Array, power_weight: float, snr_weight: float
) -> Array:
    """SNR floor that minimises power_weight * power - snr_weight * SNR in dB, by golden section.

    Between the requirement and the reachable top; power is convex in the SNR in dB for lamps that dim
    freely. Lamps with steps are tried at the top of each step as well.
    """

    def merit(snr: Array) -> Array:
        chosen, feasible = closed_form.least_power(rows, motorised, snr_floor=snr)
        power = np.max([c.light_power_w for c in chosen], axis=0)
        got = np.min(
            [closed_form.nominal_snr(r, c.light_x) for r, c in zip(rows, chosen, strict=True)], axis=0
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            value = power_weight * power - snr_weight * sensor.to_db(got)
        return np.where(feasible, value, np.inf)

    start, _ = closed_form.least_power(rows, motorised)
    low = np.min([closed_form.nominal_snr(r, c.light_x) for r, c in zip(rows, start, strict=True)], axis=0)
    low = np.where(np.isfinite(low), np.clip(low, top * FAINTEST, top), top)
    best, best_value = top.copy(), merit(top)
    low_value = merit(low)
    best, best_value = np.where(low_value < best_value, low, best), np.minimum(best_value, low_value)
    a, b = np.log(np.maximum(low, 1e-300)), np.log(np.maximum(top, 1e-300))
    ratio = (np.sqrt(5.0) - 1.0) / 2.0
    c, d = b - ratio * (b - a), a + ratio * (b - a)
    value_c, value_d = merit(np.exp(c)), merit(np.exp(d))
    for _ in range(60):
        left = value_c < value_d
        b, a = np.where(left, d, b), np.where(left, a, c)
        new_c, new_d = b - ratio * (b - a), a + ratio * (b - a)
        value_c, value_d = merit(np.exp(new_c)), merit(np.exp(new_d))
        c, d = new_c, new_d
    for point, value in ((c, value_c), (d, value_d)):
        best, best_value = np.where(value < best_value, np.exp(point), best), np.minimum(best_value, value)
    for step in step_tops(rows, motorised, top):
        value = merit(step)
        best, best_value = np.where(value < best_value, step, best), np.minimum(best_value, value)
    return best


def step_tops(rows: list[SceneRows], motorised: Array, top: Array) -> list[Array]:
    """SNR reached at the top of each step of each scene's light: where a staircase of power may be best."""
    tops = []
    for scene in rows:
        for column in range(scene.levels.shape[1]):
            level = scene.levels[:, column]
            if np.isnan(level).all():
                continue
            capped = [
                SceneRows(
                    **{
                        **{n: getattr(r, n) for n in r.__dataclass_fields__},
                        "max_level": np.fmin(r.max_level, level),
                    }
                )
                if r is scene
                else r
                for r in rows
            ]
            snr = closed_form.greatest_snr(capped, motorised, np.full(len(top), np.inf))
            tops.append(np.where(np.isfinite(snr), np.minimum(snr, top) * (1 - 1e-12), top))
    return tops

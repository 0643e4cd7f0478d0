"""The marks on the parts: f-numbers, times, gains, levels and rates that a person can set; of focus: `focus_marks`."""

from __future__ import annotations

import math

import numpy as np

from uwopt.arrays import Array
from uwopt.evaluation.focus_marks import DIGITS
from uwopt.forward.part_columns import Lenses, Lights
from uwopt.model.f_stops import THIRD_STOPS

GAIN_STEP_DB = 0.1
TIME_STEP_S = 1e-6
LEVEL_STEP = 0.01
RATE_DIGITS = 3
EDGE = 1e-9  # relative: a mark that is hit is not passed


def stops(lenses: Lenses, *, between: bool) -> Array:
    """f-numbers of one lens's ring: its ends, the thirds of a stop within; `between` also halfway to the next."""
    lowest, highest = float(lenses.f_number_min[0]), float(lenses.f_number_max[0])
    marks = np.array(THIRD_STOPS)
    if between:
        halfway = [figures_up(n, 3) for n in np.sqrt(marks[1:] * marks[:-1]).tolist()]
        marks = np.concatenate([marks, halfway])
    inside = marks[(marks > lowest * (1 + EDGE)) & (marks < highest * (1 - EDGE))]
    return np.unique(np.array([lowest, *inside, highest]))


def light_levels(lights: Lights) -> Array:
    """Levels of one light: its steps; of one that dims freely every per cent, and its least."""
    if not lights.dims_freely[0]:
        return np.unique(lights.levels[0][np.isfinite(lights.levels[0])])
    least = float(lights.min_level[0])
    per_cents = np.arange(1, round(1.0 / LEVEL_STEP) + 1) * LEVEL_STEP
    return np.unique(np.round([least, *per_cents[per_cents > least]], DIGITS))


def figures_up(value: float, digits: int) -> float:
    """The number that has so many significant digits and is no less, but for rounding."""
    if not 0.0 < value < math.inf:
        return value
    step = 10.0 ** (math.floor(math.log10(value)) + 1 - digits)
    return float(f"{math.ceil(value / step - 1e-6) * step:.{digits}g}")


def rates_hz(rate_hz: float) -> tuple[float, float]:
    """Frame rates to set, no lower than this one: in few figures; in as many as are printed."""
    return figures_up(rate_hz, RATE_DIGITS), figures_up(rate_hz, DIGITS)


def time_steps(steps: Array, *, up: bool = False) -> Array:
    """Numbers of microseconds that can be printed in full, no greater than these, or `up`: no less."""
    size = 10.0 ** np.maximum(np.floor(np.log10(np.maximum(steps, 1.0))) + 1 - DIGITS, 0.0)
    return np.asarray((np.ceil if up else np.floor)(steps / size) * size)


def printed(settings: dict[str, float | None]) -> dict[str, float | None]:
    """Settings without the last bits that conversions of units leave: 0.172 ms, not 0.17200000000000001."""
    return {name: None if value is None else float(f"{value:.9g}") for name, value in settings.items()}

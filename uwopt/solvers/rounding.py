"""Settings as a person can set them: stops, tenths of a decibel, microseconds, steps of light.

The f-number goes up to the next third of a stop, light and time follow in closed form and are rounded
up, so that what was met stays met; the design is evaluated again with the rounded values.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from uwopt.design_model import DesignModel, Hardware, SceneSettings, design_model
from uwopt.evaluation import evaluate_design
from uwopt.hardware import CONTINUOUS, FLASH, PULSED
from uwopt.objectives.objective import Objective
from uwopt.problem import Problem
from uwopt.result import Design
from uwopt.rows import SceneRows
from uwopt.solvers import settings as closed_form

THIRD_STOPS = tuple(float(f"{2 ** (n / 6):.2g}") for n in range(37))
SIXTH_STOPS = tuple(float(f"{2 ** (n / 12):.3g}") for n in range(73))
GAIN_STEP_DB = 0.1
TIME_STEP_S = 1e-6
LEVEL_STEP = 0.01
FOCUS_STEP_M = 0.01
LEVEL_TOLERANCE_REL = 0.012  # one step of gain: how well a mean level can be met with 0.1 dB
TRIES = 12


def rounded_design(
    problem: Problem, hardware: Hardware, rows: Sequence[SceneRows], exact: Sequence[dict[str, float]],
    focus_m: Sequence[float | None], objective: Objective,
) -> tuple[Design, list[SceneSettings]] | None:  # fmt: skip
    """The design with settings to set, evaluated again; None when no rounding keeps every requirement."""
    fallback: tuple[Design, list[SceneSettings]] | None = None
    model = design_model(problem, hardware)
    for attempt in range(TRIES):
        given = [
            rounded_settings(model, i, row, numbers, focus, attempt)
            for i, (row, numbers, focus) in enumerate(zip(rows, exact, focus_m, strict=True))
        ]
        design = evaluate_design(problem, hardware, given, objective, level_tolerance_rel=LEVEL_TOLERANCE_REL)
        if design.feasible:
            return design, given
        fallback = fallback or (design, given)
    return fallback


def rounded_settings(
    model: DesignModel,
    index: int,
    rows: SceneRows,
    exact: dict[str, float],
    focus_m: float | None,
    attempt: int,
) -> SceneSettings:
    """One scene's settings rounded; each attempt leaves a little more light or depth of field."""
    n_low = max(exact["f_number"], float(rows.n_low[0]))
    f_number = next_stop(n_low, float(rows.n_high[0]), attempt)
    low, high = closed_form.window(rows, snr_floor=exact.get("snr_floor", 0.0))
    spare = 1.0 + 0.004 * (attempt % 4)
    chosen = closed_form.settle(rows, np.array([f_number]), low * spare, high)
    level, time_s = float(chosen.level[0]), float(chosen.time_s[0])
    if not math.isfinite(level):
        level, time_s = exact["level"], exact["time_s"]
    kind = int(rows.kind[0])
    if bool(rows.dims_freely[0]) and kind != PULSED:
        level = min(1.0, math.ceil(level / LEVEL_STEP - 1e-9) * LEVEL_STEP)
    exposure, pulse = exposure_and_pulse(
        model, kind, time_s, up=kind != CONTINUOUS or time_s < rows.time_max_s[0] * (1 - 1e-9)
    )
    rate = rounded_rate_hz(model, exact["rate_hz"])
    if exposure * rate > 1.0:
        exposure = math.floor(1.0 / rate / TIME_STEP_S) * TIME_STEP_S
    light_x = float(rows.light_lm[0]) * level * collected_s(rows, kind, exposure, pulse)
    light_x /= (f_number * float(rows.working_factor[0])) ** 2
    gain = float(closed_form.best_gain(rows, np.array([light_x]))[0])
    gain_db = 20.0 * math.log10(max(gain, 1.0)) if math.isfinite(gain) else 0.0
    wanted = rows.mean_level is not None
    steps = gain_db / GAIN_STEP_DB
    down = not wanted or attempt % 2 == 1  # a level that must not saturate is rounded down
    gain_db = GAIN_STEP_DB * (math.floor(steps + 1e-9) if down else round(steps))
    focus = None if focus_m is None else max(round(focus_m / FOCUS_STEP_M) * FOCUS_STEP_M, FOCUS_STEP_M)
    return SceneSettings(
        f_number=f_number, exposure_s=exposure, pulse_s=pulse, gain=10.0 ** (gain_db / 20.0), level=level,
        rate_hz=rate, focus_distance_m=focus,
    )  # fmt: skip


def collected_s(rows: SceneRows, kind: int, exposure_s: float, pulse_s: float | None) -> float:
    """Time that collects light at these settings."""
    window_s = exposure_s + float(rows.exposure_offset_s[0])
    return window_s if kind == CONTINUOUS or pulse_s is None else min(pulse_s, window_s)


def rounded_rate_hz(model: DesignModel, rate_hz: float) -> float:
    """The rate in three figures, upward; no higher than camera and light allow."""
    if rate_hz <= 0.0:
        return 0.0
    step = 10.0 ** (math.floor(math.log10(rate_hz)) - 2)
    up = math.ceil(rate_hz / step - 1e-9) * step
    highest = min(float(model.cameras.max_rate_hz[0]), float(model.lights.max_rate_hz[0]))
    return max(rate_hz, min(up, highest))


def next_stop(f_number: float, largest: float, attempt: int) -> float:
    """The f-number to set: a third of a stop at or above; then sixths; then tenths and hundredths,
    which a ring without clicks can be turned to.

    The lens's own widest opening counts as a mark.
    """
    if attempt < 4:
        series: tuple[float, ...] = THIRD_STOPS
    elif attempt < 8:
        series = SIXTH_STOPS
    else:
        step = 10 if attempt < 10 else 100
        series = (math.ceil(f_number * step - 1e-9) / step,)
    if abs(f_number * 100 - round(f_number * 100)) < 1e-6:  # a number that a lens is engraved with
        return f_number
    above = [stop for stop in series if stop >= f_number * (1 - 1e-9)]
    return min(above[0], largest) if above else f_number


def exposure_and_pulse(
    model: DesignModel, kind: int, time_s: float, *, up: bool
) -> tuple[float, float | None]:
    """Exposure and pulse that collect light for a time, rounded to a microsecond."""
    cam, lights = model.cameras, model.lights
    offset, readout, least = (float(c[0]) for c in (cam.exposure_offset_s, cam.readout_s, cam.min_exposure_s))

    def stepped(value: float) -> float:
        steps = value / TIME_STEP_S
        return (math.ceil(steps - 1e-6) if up else math.floor(steps + 1e-6)) * TIME_STEP_S

    if kind == CONTINUOUS:
        return max(stepped(time_s - offset), least), None
    if kind == PULSED:
        pulse = stepped(time_s)
        return max(math.ceil(least / TIME_STEP_S) * TIME_STEP_S, pulse + readout), pulse
    assert kind == FLASH
    duration = float(lights.flash_duration_s[0])
    if time_s >= duration * (1 - 1e-9):
        return max(least, math.ceil((duration + readout) / TIME_STEP_S - 1e-6) * TIME_STEP_S), duration
    return max(stepped(time_s - offset), least), duration


def exact_settings(model: DesignModel, index: int, numbers: dict[str, Any]) -> SceneSettings:
    """The search's own settings of one scene, unrounded, as the evaluation takes them."""
    kind = int(model.lights.kind[0])
    pulse = {
        CONTINUOUS: None,
        PULSED: float(numbers["time_s"]),
        FLASH: float(model.lights.flash_duration_s[0]),
    }[kind]
    wanted = model.problem.scenes[index].view.requirements.mean_level
    return SceneSettings(
        f_number=float(numbers["f_number"]),
        exposure_s=float(numbers["exposure_s"]),
        pulse_s=pulse,
        gain=None if wanted is not None else float(numbers["gain"]),
        level=float(numbers["level"]),
        rate_hz=float(numbers["rate_hz"]),
        dioptre_per_m=float(numbers["dioptre_per_m"]),
    )

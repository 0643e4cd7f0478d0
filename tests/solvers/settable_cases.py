"""Random missions whose optimum is rounded to what can be set, and the plain system files that this makes.

Every kind of light, sun or none, one scene or two, and every requirement that a setting can miss take turns.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import brute_force as brute
import numpy as np
import pytest
import random_cases as rc
import small_catalogues as small

import uwopt
import uwopt.api.solving
from uwopt.catalog.catalogue import Catalog
from uwopt.evaluation.design_model import DesignModel, design_model
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.figures import SettingRows
from uwopt.forward.focus import place_focus
from uwopt.forward.part_columns import FLASH, PULSED
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.objectives.objective import Objective
from uwopt.report.text import formats, vocabulary
from uwopt.results.design import Design
from uwopt.results.result import Result
from uwopt.solvers.settable.rounding import rounded_design
from uwopt.solvers.settable.steps import light_levels, printed, stops

TYPED = ("f_number", "exposure_ms", "pulse_ms", "gain", "dim_frac", "frame_rate_hz", "focus_distance_m")


@dataclass(frozen=True)
class Start:
    """One hardware of a problem and settings to begin from."""

    case: rc.Case
    problem: Problem
    hardware: Hardware
    exact: list[dict[str, Any]]

    def rounded(self) -> Design:
        """The design with the best settings that can be set, or the nearest miss."""
        return rounded_design(self.problem, self.hardware, self.exact, self.case.objective).design


def case(seed: int) -> rc.Case:
    """A random case; half of them in sunlight, some with requirements on contrast and sharpness."""
    rng = np.random.default_rng([seed, 3])
    parts, plain = small.parts(rng, 2), small.mission(rng)
    if small.chance(rng, 0.5):
        plain["physics"] = "full" if plain["physics"] == "paper" else plain["physics"]
        for scene in plain["scenes"]:
            scene |= {
                "sun_lux": small.pick(rng, [1e2, 1e4, 1e5]),
                "depth_m": small.pick(rng, [3.0, 12.0, 40.0]),
            }
    if plain["physics"] == "full" and small.chance(rng, 0.15):
        plain["requirements"]["min_mtf_half_nyquist"] = small.between(rng, 0.02, 0.3)
    if plain["physics"] == "full" and small.chance(rng, 0.15):
        plain["objective"] = small.pick(rng, ["contrast", "information"])
        plain["requirements"]["min_swath_m"] = 0.1
    if plain["physics"] == "full" and small.chance(rng, 0.5):
        plain["physics"] = "auto"
    return rc.Case(parts, small.loaded(plain), Objective.of(plain["objective"]))


def start(wanted: rc.Case, seed: int) -> Start | None:
    """Some hardware of a case, with settings that need not hold; None where no parts fit together."""
    rng, problem = np.random.default_rng([seed, 4]), wanted.problem()
    buildable = list(brute.buildable(problem))
    if not buildable:
        return None
    hardware = small.pick(rng, buildable)
    model = design_model(problem, hardware)
    focus = place_focus(problem.scenes, model.maps, model.views)
    f_number = max(float(model.lenses.f_number_min[0]), float(np.max(focus.n_depth))) * small.between(
        rng, 1.0, 1.2
    )
    f_number = min(f_number, float(model.lenses.f_number_max[0]))
    exact = []
    for index, dioptre in enumerate(focus.dioptre_per_m):
        made = model.settings(index, SceneSettings(f_number=f_number, dioptre_per_m=float(dioptre[0])))
        numbers = {f.name: float(getattr(made, f.name)[0]) for f in fields(made)}
        exact.append({**numbers, "time_s": numbers["pulse_s"]})
    return Start(wanted, problem, hardware, exact)


def random_settings(model: DesignModel, numbers: dict[str, Any], rng: small.Rng, count: int) -> SettingRows:
    """Stops, levels, microseconds and tenths of a decibel drawn at random, in one scene."""
    cam, flash = model.cameras, int(model.lights.kind[0]) == FLASH
    longest_s = min(float(cam.max_exposure_s[0]), 1.0 / max(numbers["rate_hz"], 1e-3))
    time_s = np.round(1e6 * np.exp(rng.uniform(np.log(2e-6), np.log(longest_s), count))) * 1e-6
    pulse_s = np.full(count, np.inf)
    exposure_s = time_s
    if int(model.lights.kind[0]) == PULSED:
        pulse_s, exposure_s = time_s, time_s + float(cam.readout_s[0])
    if flash:
        pulse_s = np.full(count, float(model.lights.flash_duration_s[0]))
    exposure_s = np.maximum(exposure_s, float(cam.min_exposure_s[0]))
    top_db = 20.0 * float(np.log10(cam.max_gain[0]))
    gain_db = np.floor(rng.uniform(0.0, top_db, count) / 0.1) * 0.1
    ones = np.ones(count)
    return SettingRows(
        rng.choice(stops(model.lenses, between=True), count), exposure_s, pulse_s, 10.0 ** (gain_db / 20.0),
        rng.choice(light_levels(model.lights), count), numbers["rate_hz"] * ones, numbers["dioptre_per_m"] * ones,
    )  # fmt: skip


def parts_of(parts: Parts) -> tuple[Any, ...]:
    """Parts of each kind."""
    return parts.cameras, parts.lenses, parts.ports, parts.lights


def as_typed(design: Design) -> dict[str, Any]:
    """The system file of a person who types in what is printed to be set."""
    hardware = design.hardware
    system: dict[str, Any] = {kind: hardware[kind]["id"] for kind in ("camera", "lens", "port", "light")}
    for key in ("camera_count", "light_count", "orientation", "light_mounts"):
        system[key] = hardware[key]
    system["scenes"] = {}
    for scene in design.scenes:
        given = {key: as_read(key, scene.settings) for key in TYPED}
        system["scenes"][scene.name] = {key: value for key, value in given.items() if value is not None}
    return system


def as_read(key: str, settings: dict[str, float | None]) -> float | None:
    """A setting as a person reads it from the printed table, in the units of a system file."""
    name = "gain_db" if key == "gain" else key
    value = printed(settings)[name]
    if value is None or (name == "frame_rate_hz" and value == 0.0):  # no rate is asked for
        return None
    text = formats.setting_text(name, value)
    has_unit = bool(vocabulary.SETTINGS[name][1]) or name == "dim_frac"
    number, _, unit = text.rpartition(" ") if has_unit else (text, "", "")
    read = float(number.replace(" ", ""))
    read *= {"µs": 1e-3, "%": 1e-2}.get(unit, 1.0)
    return 10.0 ** (read / 20.0) if key == "gain" else read


def evaluated(
    monkeypatch: pytest.MonkeyPatch, mission: Mission, parts: Parts, system: dict[str, Any]
) -> Result:
    """What `uwopt.evaluate` says of a system made of these parts."""
    for place in ("api.evaluating", "forward.assembly"):  # imported first, while the catalogue is the real one
        monkeypatch.setattr(f"uwopt.{place}.load_catalog", lambda mission=None: Catalog(*parts_of(parts)))
    return uwopt.evaluate(mission, system)

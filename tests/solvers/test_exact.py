"""The exact search attacked: random small catalogues solved by enumeration, random settings, planted mistakes.

Expected values come from `brute_force.py`, which takes every combination of hardware and finds its settings
on dense grids of the forward model's formulas; the exact search must agree and never be beaten. Seeds are
fixed, so every failure names the case that reproduces it. UWOPT_THOROUGH=1 runs hundreds of cases.
"""

from __future__ import annotations

import importlib.util
import math
import os
import sys
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from uwopt.catalog.records import Light, exact
from uwopt.evaluation import DesignModel, Hardware, SceneSettings, evaluate_design
from uwopt.mission import Mission
from uwopt.objectives.objective import Objective
from uwopt.optics import place_focus
from uwopt.problem import Parts, Problem
from uwopt.solvers import exact as exact_search
from uwopt.solvers.audit import audit
from uwopt.solvers.exact import Outcome, Search
from uwopt.solvers.fields import FieldTables
from uwopt.solvers.imagers import enumerate_imagers
from uwopt.solvers.recommend import hardware_of
from uwopt.solvers.rounding import exact_settings


def beside_me(name: str) -> ModuleType:
    """A helper module of this folder; tests are imported without packages."""
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


small = beside_me("small_catalogues")
brute = beside_me("brute_force")

THOROUGH = bool(os.environ.get("UWOPT_THOROUGH"))
CASES = range(600) if THOROUGH else range(24)
FEW = range(100) if THOROUGH else range(6)
TOP = 4
BEATEN_REL = 1e-6  # the enumeration may find rounding, nothing more
REACHED_REL = 2e-3  # what its grids of SNR against power may miss


@dataclass(frozen=True)
class Case:
    """One random problem."""

    parts: Parts
    mission: Mission
    objective: Objective

    def problem(self, parts: Parts | None = None) -> Problem:
        """Fresh tables."""
        return Problem(self.mission, parts or self.parts, paper=self.mission.physics == "paper")

    def solve(self, parts: Parts | None = None, **options: Any) -> tuple[Search, Outcome]:
        """The exact search."""
        search = Search(
            self.problem(parts), self.objective, **{"top": TOP, "deadline_s": None, "progress": None, **options}
        )
        return search, search.run()


@cache
def case(seed: int) -> Case:
    """A random case whose limits are, in a part of the cases, just what one of its designs needs."""
    rng = np.random.default_rng(seed)
    parts, plain = small.parts(rng, 3 if THOROUGH else 2), small.mission(rng)
    objective = Objective.of(plain["objective"])
    free = Case(parts, small.loaded(plain), objective)
    limits, wanted = limits_that_bind(rng, free)
    return Case(parts, small.loaded(plain, limits, **wanted), objective)


def limits_that_bind(rng: np.random.Generator, free: Case) -> tuple[dict[str, float], dict[str, float]]:
    """Budgets and coverage at, or a little beyond, those of one random design at its best settings."""
    bench, limits, wanted = brute.Bench(free.problem()), {}, {}
    buildable = list(brute.buildable(bench.problem))
    if not buildable:
        return {}, {}
    hardware = small.pick(rng, buildable)
    model, best = bench.model(hardware), brute.best_of(bench, hardware, free.objective)
    terms, room = brute.fixed_terms(model), small.pick(rng, [1.0, 1.0, 1.0001, 1.05, 1.3])
    for name, key, share in (("cost", "cost_limit_value", 0.3), ("mass_kg", "mass_kg", 0.2)):
        if small.chance(rng, share):
            limits[name] = terms[key] * room
    if small.chance(rng, 0.3) and math.isfinite(best.power_w):
        limits["power_w"] = best.power_w * room
    if small.chance(rng, 0.3):
        limits["peak_power_w"] = small.between(rng, 20, 2000)
    if small.chance(rng, 0.1):
        limits["data_rate_mb_s"] = small.between(rng, 1, 100)
    if small.chance(rng, 0.25):
        wanted["max_gsd_mm"] = max(float(v.gsd_m.max()) for v in model.views) * 1e3 * room
    if small.chance(rng, 0.25):
        wanted["min_swath_m"] = min(float(v.footprint_across_m.min()) for v in model.views) / room
    return limits, wanted


@cache
def bench(seed: int) -> Any:
    """Forward models of a case."""
    return brute.Bench(case(seed).problem())


@cache
def enumerated(seed: int) -> list[Any]:
    """Best settings of every hardware of a case, best first."""
    return brute.enumerate_all(bench(seed), case(seed).objective)


def ranked(seed: int) -> dict[tuple[int, ...], Any]:
    """The best of each camera, lens, port and light that has a feasible design, best first."""
    best: dict[tuple[int, ...], Any] = {}
    for found in enumerated(seed):
        if math.isfinite(found.value):
            best.setdefault(ids(found.hardware), found)
    return best


def ids(hardware: Any) -> tuple[int, ...]:
    """What counts as other hardware."""
    return hardware.camera, hardware.lens, hardware.port, hardware.light


@pytest.fixture(params=["as shipped", "bounds at work"])
def batches(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Batches as shipped are larger than a small catalogue; batches of one make every bound count."""
    if request.param == "bounds at work":
        for name, value in (("FIRST_BATCH", 1), ("LARGEST_BATCH", 2), ("TOO_FEW_TO_BOUND", 0), ("FIRST_CHUNK", 2)):
            monkeypatch.setattr(exact_search, name, value)


# ---------------------------------------------------------------- against enumeration


@pytest.mark.usefixtures("batches")
@pytest.mark.parametrize("seed", CASES)
def test_search_equals_enumeration(seed: int) -> None:
    """Best designs, feasibility and account of every random case."""
    _, outcome = case(seed).solve()
    best_of = ranked(seed)
    assert outcome.complete and outcome.account.adds_up()
    assert outcome.account.total == combinations(case(seed).problem())
    assert len(outcome.best) == min(TOP, len(best_of)), "feasible hardware missed or made up"
    keys = [ids(found) for found in outcome.best]
    assert len(set(keys)) == len(keys)
    room = room_for_dark(case(seed), outcome)
    for found, key, place in zip(outcome.best, keys, best_of.values(), strict=False):
        own = best_of[key]
        for other in (own, place):  # the same hardware, and whatever enumeration puts in this place
            assert found.minimised <= other.value + BEATEN_REL * other.scale + room, f"beaten by {other}"
            assert found.minimised >= other.value - REACHED_REL * other.scale, f"out of reach: {other}"
    if outcome.best:
        first = next(iter(best_of.values()))
        assert outcome.lower_bound <= first.value + BEATEN_REL * first.scale, f"the bound is beaten by {first}"
        assert outcome.lower_bound <= outcome.best[0].minimised
    values = [found.minimised for found in outcome.best]
    assert all(a <= b + 1e-9 * abs(b) for a, b in zip(values, values[1:], strict=False))


def room_for_dark(case_: Case, outcome: Outcome) -> float:
    """What may be left of the optimum where SNR counts and sensors have dark current: 0.005 dB.

    Exposure and dark current are not optimised together then, and the certificate's lower bound says so.
    Everywhere else the gap is closed.
    """
    dark = any(part.dark_current_e_s and part.dark_current_e_s.value > 0 for part in case_.parts.cameras)
    if case_.objective.weight("snr_db") and dark:
        return 0.005 * case_.objective.weight("snr_db")
    assert not outcome.best or outcome.lower_bound == outcome.best[0].minimised
    return 0.0


def combinations(problem: Problem) -> int:
    """All combinations of a problem."""
    low, high = problem.count_range
    sizes = [len(getattr(problem.parts, kind)) for kind in ("cameras", "lenses", "ports", "lights")]
    return math.prod(sizes) * (high - low + 1) * len(problem.mounts) * len(problem.mission.vehicle.orientations)


@pytest.mark.parametrize("seed", CASES)
def test_claims_hold_in_the_forward_model(seed: int) -> None:
    """Each listed design is feasible and worth what the search says, by `evaluate_design` on fresh tables."""
    _, outcome = case(seed).solve()
    objective = case(seed).objective
    for found in outcome.best:
        problem, hardware = case(seed).problem(), hardware_of(found)
        model = DesignModel(problem, hardware)
        settings = [exact_settings(model, i, numbers) for i, numbers in enumerate(found.settings)]
        design = evaluate_design(problem, hardware, settings, objective)
        missed = [(m.requirement, m.value, m.limit) for s in design.scenes for m in s.margins if not m.satisfied]
        assert design.feasible and not missed
        claimed = objective.reported(found.minimised)
        scale = max(abs(claimed), objective.weight("snr_db") * abs(found.snr_db))
        assert design.objective_value == pytest.approx(claimed, abs=1e-6 * scale)


@pytest.mark.parametrize("seed", CASES)
def test_no_random_design_beats_the_optimum(seed: int) -> None:
    """Random settings of random hardware, judged by `evaluate_design`; focus and rate by their rules.

    Margins may be missed by 1e-6, which is worth up to 1e-5 of power: 20 log10 of the SNR is bound, and
    light grows with its square.
    """
    problem, objective = bench(seed).problem, case(seed).objective
    _, outcome = case(seed).solve(top=1)
    best, rng = outcome.lower_bound if outcome.best else math.inf, np.random.default_rng(seed)
    for _ in range(100 if THOROUGH else 15):
        if not enumerated(seed):
            break
        found = small.pick(rng, enumerated(seed))
        model = bench(seed).model(found.hardware)
        if not brute.passes_without_light(model):
            continue
        design = evaluate_design(problem, found.hardware, random_settings(rng, model, found.settings), objective)
        if design.feasible and design.objective_value is not None:
            value = design.objective_value * (-1.0 if objective.direction == "maximise" else 1.0)
            assert value >= best - 2e-5 * max(abs(best), 1.0), f"{found.hardware} beats the optimum"


def random_settings(rng: np.random.Generator, model: DesignModel, near: list[Any]) -> list[SceneSettings]:
    """Settings anywhere, or close to the best ones known; the f-number is common to all scenes."""
    lens, cam, light = model.lenses, model.cameras, model.lights
    focus = place_focus(model.problem.scenes, model.maps, model.views)
    made: list[SceneSettings] = []
    common = small.between(rng, float(lens.f_number_min[0]), float(lens.f_number_max[0]) * 1.0000001)
    for index in range(len(model.views)):
        f_number, time_s, level = common, small.between(rng, 1e-5, 0.1), small.between(rng, 1e-3, 1.0)
        if near and small.chance(rng, 0.8):
            f_number, time_s, level = (near[index][k] * rng.normal(1.0, 0.01) for k in ("f_number", "time_s", "level"))
            f_number = made[0].f_number if made else max(f_number, float(lens.f_number_min[0]))
        if not light.dims_freely[0]:
            steps = light.levels[0][~np.isnan(light.levels[0])]
            level = float(steps[np.abs(steps - level).argmin()])
        readout, offset = float(cam.readout_s[0]), float(cam.exposure_offset_s[0])
        burning = light.kind[0] == brute.CONTINUOUS
        pulse = None if burning else float(min(time_s, light.flash_duration_s[0]))
        exposure = time_s - offset if burning else max(time_s + readout, float(cam.min_exposure_s[0]))
        wanted = model.problem.scenes[index].view.requirements.mean_level
        gain = None if wanted is not None else small.between(rng, 1.0, float(cam.max_gain[0]) * 1.0000001)
        made.append(
            SceneSettings(
                f_number=f_number, exposure_s=max(exposure, 1e-9), pulse_s=pulse, gain=gain, level=min(level, 1.0),
                dioptre_per_m=float(focus.dioptre_per_m[index][0]),
            )  # fmt: skip
        )
    return made


# ---------------------------------------------------------------- what must not matter


@pytest.mark.parametrize("seed", FEW)
def test_order_of_parts_changes_nothing(seed: int) -> None:
    """Shuffled catalogues give the same list, by ids."""
    parts = case(seed).parts
    rng = np.random.default_rng(seed + 1000)
    mixed = Parts(*(shuffled(rng, getattr(parts, k)) for k in ("cameras", "lenses", "ports", "lights")))
    assert named(case(seed).solve()[1], parts) == named(case(seed).solve(mixed)[1], mixed)


def shuffled(rng: np.random.Generator, items: tuple[Any, ...]) -> tuple[Any, ...]:
    """The same items in another order."""
    return tuple(items[int(i)] for i in rng.permutation(len(items)))


def named(outcome: Outcome, parts: Parts) -> list[Any]:
    """A list of designs by their parts' ids, with values rounded to where a tie begins."""
    return [
        (parts.cameras[f.camera].id, parts.lenses[f.lens].id, parts.ports[f.port].id, parts.lights[f.light].id,
         f.count, f"{f.minimised:.8g}", f"{f.power_w:.8g}")
        for f in outcome.best
    ]  # fmt: skip


@pytest.mark.parametrize("seed", FEW)
def test_more_parts_never_make_it_worse(seed: int) -> None:
    """A camera, lens, port and light of another random case can only help."""
    parts, rng = case(seed).parts, np.random.default_rng(seed + 2000)
    before = case(seed).solve(top=1)[1].best
    richer = Parts(
        (*parts.cameras, small.camera(rng, "cam-new")), (*parts.lenses, small.lens(rng, "lens-new")),
        (*parts.ports, small.port(rng, "port-new")), (*parts.lights, small.light(rng, "light-new", small.beam(rng))),
    )  # fmt: skip
    after = case(seed).solve(richer, top=1)[1].best
    if before:
        assert after[0].minimised <= before[0].minimised + 1e-9 * abs(before[0].minimised)


@pytest.mark.parametrize("seed", FEW)
def test_twins_tie_and_the_choice_is_fixed(seed: int) -> None:
    """Every part twice under another id: the same optimum, the twin with the lower id, in any order."""
    parts, rng = case(seed).parts, np.random.default_rng(seed + 3000)
    kinds = ("cameras", "lenses", "ports", "lights")
    twice = [(*own, *(replace(part, id=f"{part.id}-twin") for part in own)) for own in (getattr(parts, k) for k in kinds)]
    alone, doubled = case(seed).solve(top=1)[1], case(seed).solve(Parts(*twice), top=1)[1]
    mixed = Parts(*(shuffled(rng, own) for own in twice))
    assert named(alone, parts) == named(doubled, Parts(*twice))
    assert named(alone, parts) == named(case(seed).solve(mixed, top=1)[1], mixed)


# ---------------------------------------------------------------- bounds and the audit


@pytest.mark.parametrize("seed", range(300) if THOROUGH else range(40))
def test_bound_of_the_signal_is_a_bound(seed: int) -> None:
    """No image gets more light than its bound says: flat and dome, wide and long, narrow beams, turbid water."""
    rng = np.random.default_rng(seed)
    parts, plain = small.parts(rng), small.mission(rng)
    plain |= {"physics": "full", "requirements": {"frame_interval_s": 1.0}, "limits": {}}
    plain["vehicle"] |= {
        "light_baseline_m": small.pick(rng, [0.0, 0.5, 2.0]), "light_tilt_deg": small.pick(rng, [-20.0, 0.0, 20.0, 40.0]),
    }  # fmt: skip
    angles = [6.0, 12.0, 20.0, 40.0, 80.0, 120.0]
    lights = tuple(replace(p, beam_angle_deg=exact(small.pick(rng, angles))) for p in parts.lights)
    lenses = tuple(
        replace(p, mounts=("C", "S"), image_circle_mm=20.0, focal_length_mm=small.pick(rng, [2.5, 4.0, 8.0, 16.0]))
        for p in parts.lenses
    )
    problem = Problem(small.loaded(plain), replace(parts, lights=lights, lenses=lenses), paper=False)
    imagers = enumerate_imagers(problem)
    if len(imagers) == 0:
        pytest.skip("no imager")
    tables, rows = FieldTables(problem, imagers), rng.permutation(len(imagers))[:12]
    for index, scene in enumerate(problem.scenes):
        for lighting in tables.lightings:
            found = tables.exact(index, lighting, rows)
            for altitude in range(len(scene.range_m)):
                bound = tables.bound(index, lighting, altitude, rows)
                assert (found[:, altitude] <= bound * (1 + 1e-6)).all(), (lighting, altitude)


def sabotaged(case_: Case, monkeypatch: pytest.MonkeyPatch, share: float) -> tuple[Search, Outcome]:
    """A search whose signal bounds are a share of what they should be."""
    honest = FieldTables.bound
    monkeypatch.setattr(FieldTables, "bound", lambda self, *a, **k: share * honest(self, *a, **k))
    for name, value in (("FIRST_BATCH", 1), ("LARGEST_BATCH", 1), ("TOO_FEW_TO_BOUND", 0)):
        monkeypatch.setattr(exact_search, name, value)
    return case_.solve(top=1)


def one_camera_two_lights() -> Case:
    """A bright and a dim lamp: the dim one is enough, if barely, and draws far less."""
    rng = np.random.default_rng(7)
    plain = {
        "objective": "power", "physics": "full", "limits": {}, "requirements": {"overlap": 0.3, "max_blur_px": 1.0, "min_snr_db": 25.0},
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3, "orientation": "landscape", "light_count": 1},
        "scenes": [{"water": "II", "seafloor": 0.2, "depth_m": 100.0}],
    }  # fmt: skip
    camera = replace(small.camera(rng, "cam"), mounts=("C",), shutter="global", saturation_e=exact(20_000.0), power_w=exact(2.0))
    lens = replace(small.lens(rng, "lens"), mounts=("C",), image_circle_mm=20.0, focal_length_mm=8.0, f_number_min=exact(1.4))
    port = replace(small.port(rng, "port"), geometry="dome", outer_radius_mm=80.0)
    common: dict[str, Any] = {"price": exact(500.0), "mass_g": exact(500.0), "depth_rating_m": 6000.0, "beam_medium": "water"}
    bright = Light(id="bright", flux_lm=exact(1e6), power_w=exact(2e4), beam_angle_deg=exact(90.0), **common)
    dim = Light(id="dim", flux_lm=exact(2e4), power_w=exact(100.0), beam_angle_deg=exact(60.0), **common)
    parts = Parts((camera,), (replace(lens, min_object_distance_m=None),), (port,), (bright, dim))
    return Case(parts, small.loaded(plain), Objective.of("power"))


def test_audit_finds_what_a_wrong_bound_discards(monkeypatch: pytest.MonkeyPatch) -> None:
    """With bounds far too low the better lamp is thrown away, and the audit says so."""
    case_ = one_camera_two_lights()
    search, outcome = sabotaged(case_, monkeypatch, 0.02)
    assert [case_.parts.lights[f.light].id for f in outcome.best] == ["bright"]
    report = audit(search, case_.objective, count=20, seed=0, best_value=outcome.best[0].minimised)
    assert not report["passed"]
    assert {found["light"] for found in report["better"]} == {"dim"}


def test_audit_of_an_honest_search_passes() -> None:
    """The same catalogue without sabotage: the dim lamp wins and nothing discarded is better."""
    case_ = one_camera_two_lights()
    search, outcome = case_.solve(top=1)
    assert [case_.parts.lights[f.light].id for f in outcome.best] == ["dim"]
    assert audit(search, case_.objective, count=20, seed=0, best_value=outcome.best[0].minimised)["passed"]


@pytest.mark.parametrize("seed", FEW)
def test_audit_passes_on_random_cases(seed: int) -> None:
    """What an honest search discards does not hold anything better, nor anything feasible if it found nothing."""
    search, outcome = case(seed).solve(top=1)
    best = outcome.best[0].minimised if outcome.best else None
    report = audit(search, case(seed).objective, count=12, seed=seed, best_value=best)
    assert report["passed"], report["better"]


def test_audit_fails_when_a_sabotaged_search_calls_all_infeasible(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bounds of nothing: no design is found, and the audit finds some."""
    case_ = one_camera_two_lights()
    search, outcome = sabotaged(case_, monkeypatch, 1e-9)
    assert outcome.best == []
    assert not audit(search, case_.objective, count=20, seed=0, best_value=None)["passed"]

"""The exact search attacked: random small catalogues solved by enumeration, and by random settings.

Expected values come from `brute_force.py`, which takes every combination of hardware and finds its settings
on dense grids of the forward model's formulas; the exact search must agree and never be beaten. Seeds are
fixed, so every failure names the case that reproduces it. UWOPT_THOROUGH=1 runs hundreds of cases.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import brute_force as brute
import numpy as np
import pytest
import random_cases as rc
import small_catalogues as small
from agreement import agree
from random_cases import CASES, FEW, bench, case, enumerated, in_batches, lamp, planted, ranked, solved
from thorough import drawn

from uwopt.catalog.records import exact
from uwopt.deadline import COSTS_S, effort_s
from uwopt.evaluation.design import evaluate_design
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.designs import SceneSettings
from uwopt.forward.focus import place_focus
from uwopt.forward.part_columns import CONTINUOUS
from uwopt.forward.parts import Parts
from uwopt.solvers.exact import evaluation
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.settable.rounding import exact_settings

EVERY_KIND = {
    *(str(one) for one in small.OBJECTIVES),
    *(f"{physics}, {n} scenes" for physics in ("full", "paper") for n in (1, 2)),
    *(f"{iris} iris, {n} scenes" for iris in ("fixed", "manual", "motorised") for n in (1, 2)),
    *(f"{kind} {dimming}" for kind in ("continuous", "pulsed_led", "flash") for dimming in ("dial", "steps")),
    "cost", "mass_kg", "power_w", "peak_power_w", "data_rate_mb_s", "max_gsd_mm", "min_swath_m", "overlap",
    "frame_interval_s", "max_blur_px", "max_skew_px", "min_dof_m", "min_snr_db", "mean_level", "min_contrast",
    "min_uniformity", "lens_stop_down", "max_airy_px", "reserve",
    *(f"rule {rule}" for rule in (
        "mount", "image_circle", "view", "focus", "frame_rate", "max_gsd_mm", "min_swath_m", "min_dof_m", "cost",
        "mass_kg", "power_w", "light", "bound",
    )),
}  # fmt: skip
OVER_FRAME = drawn((24,), CASES)  # by default those that are quick and whose answers it changes


# ---------------------------------------------------------------- against enumeration


@pytest.mark.parametrize(("batches", "seed"), in_batches(CASES), indirect=["batches"])
def test_search_equals_enumeration(seed: int, batches: str) -> None:
    """Best designs, feasibility and account of every random case."""
    outcome = solved(seed) if batches == "as shipped" else case(seed).solve()[1]
    agree(case(seed), outcome, ranked(enumerated(seed)))


@pytest.mark.usefixtures("batches")
@pytest.mark.parametrize("seed", OVER_FRAME)
def test_search_over_the_frame_equals_enumeration(seed: int) -> None:
    """The same with an SNR that 95 % of the image must reach."""
    over_frame = case(seed, over_frame=True)
    agree(over_frame, over_frame.solve()[1], ranked(enumerated(seed, over_frame=True)))


FLASH_STEPS = lamp(
    "flash", kind="flash", flash_energy_j=20.0, flash_efficacy_lm_s_per_j=35.0, flash_duration_us=500.0,
    recycle_s=0.1, charging_efficiency_frac=exact(0.7), dim_levels=(0.3, 1.0),
)  # fmt: skip
BURNING = lamp("burning", flux_lm=2e4, power_w=200.0)
BURNING_STEPS = replace(BURNING, id="steps", dim_levels=(0.05, 0.3, 1.0))
PULSED_STEPS = lamp(
    "led", kind="pulsed_led", flux_lm=4e4, power_w=400.0, min_pulse_us=400.0, max_pulse_us=600.0,
    dim_levels=(0.05, 0.2, 1.0),
)  # fmt: skip
ROLLING = {"shutter": "rolling", "max_frame_rate_hz": exact(30.0), "max_exposure_us": exact(1e6)}
OVER_FRAME_LESS = {"min_snr_db": 22.0, "snr_at": "worst", "snr_at_less_db": 3.0}
SNR_AND_POWER = {"power": 0.2, "snr_db": 1.0}
PLANTED = {
    "nothing asked of the light": planted("power", (BURNING, BURNING_STEPS), {"max_blur_px": 1.0}),
    "mean level and altitudes": planted(
        "power", (BURNING, BURNING_STEPS), {"mean_level": 0.3, "highlight_ratio": 1.0}, altitude_tolerance_m=0.3,
        camera={"max_gain_db": exact(0.0), "black_level_dn": 0.0},
    ),
    "gain that the mission caps": planted(
        "power", (BURNING, BURNING_STEPS), {"mean_level": 0.3, "max_gain_db": 6.0}, camera={"max_gain_db": exact(30.0)},
    ),
    "flash in steps, open for all of it": planted("snr_db", (FLASH_STEPS,), {}, camera=ROLLING),
    "flash far too bright": planted("power", (FLASH_STEPS,), {"min_snr_db": 20.0, "mean_level": 0.1}, camera=ROLLING),
    "pulses in steps with gaps": planted(SNR_AND_POWER, (PULSED_STEPS, BURNING_STEPS), {"max_blur_px": 1.0}),
    "hovering without an interval": planted("power", (PULSED_STEPS, BURNING), {"min_snr_db": 20.0}, speed_m_s=0.0),
    "even in the light of two lamps alone": planted(
        "power", (BURNING,), {"min_snr_db": 10.0, "min_uniformity": 0.5}, light_count=[1, 3], light_baseline_m=2.0,
    ),
    "frame that may have less than its mean": planted("power", (BURNING, PULSED_STEPS), OVER_FRAME_LESS),
    "the same where the mean decides": planted(
        "power", (BURNING, PULSED_STEPS), {**OVER_FRAME_LESS, "snr_at_less_db": 20.0},
    ),
    "the same in two scenes": planted(
        SNR_AND_POWER, (BURNING,), OVER_FRAME_LESS, scenes=({}, {"altitude_m": 1.4, "water": "III"}),
        altitude_tolerance_m=0.2,
    ),
    "one lamp's power alone": planted("gsd_mm", (BURNING, FLASH_STEPS, PULSED_STEPS), {"min_snr_db": 20.0}),
}  # fmt: skip


@cache
def best_of_planted(name: str) -> dict[tuple[int, ...], Any]:
    """`ranked` of what enumeration finds, which knows nothing of batches."""
    case_ = PLANTED[name]
    return ranked(brute.enumerate_all(brute.Bench(case_.problem()), case_.objective))


@pytest.mark.parametrize(("batches", "name"), in_batches(PLANTED), indirect=["batches"])
def test_planted_cases_equal_enumeration(batches: str, name: str) -> None:
    """Cases made to hit one rule of the closed form each; several were wrong once."""
    case_, best = PLANTED[name], best_of_planted(name)
    agree(case_, case_.solve()[1], best)
    assert best, "the case was made to be feasible"


def test_evenness_asked_before_light_loses_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """As where these rules have refused all that came to them: one lamp lights the floor too unevenly, two do not."""
    monkeypatch.setattr(evaluation, "ENOUGH_ASKED", 0)
    monkeypatch.setattr(evaluation, "MOST_REFUSED", 0.0)
    name = "even in the light of two lamps alone"
    case_ = PLANTED[name]
    outcome = case_.solve()[1]
    agree(case_, outcome, best_of_planted(name))
    assert outcome.best[0].count == 2


def test_designs_whose_settings_are_bounded_count_as_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each at every stage of its bound; a search in vain is little else."""
    for work in COSTS_S:
        monkeypatch.setitem(COSTS_S, work, float(work == "designs"))
    bounded, solve = [], evaluation.Evaluation.solve

    def counting(self: Any, pairs: Any, *light: Any, **how: Any) -> Any:
        bounded.append(len(pairs) if how.get("optimistic") else 0)
        return solve(self, pairs, *light, **how)

    monkeypatch.setattr(evaluation.Evaluation, "solve", counting)
    before = effort_s()
    case(OVER_FRAME[0], over_frame=True).solve()
    assert effort_s() - before == pytest.approx(sum(bounded)) and sum(bounded) > 0


@pytest.mark.parametrize("seed", CASES)
def test_claims_hold_in_the_forward_model(seed: int) -> None:
    """Listed designs are feasible and worth what the search says, by `evaluate_design` on fresh tables."""
    outcome, objective = solved(seed), case(seed).objective
    for found in drawn(outcome.best[:1] + outcome.best[1:][-1:], outcome.best):
        problem, hardware = case(seed).problem(), found.hardware
        model = DesignModel(problem, hardware)
        settings = [exact_settings(model, i, numbers) for i, numbers in enumerate(found.settings)]
        design = evaluate_design(problem, hardware, settings, objective)
        missed = [
            (m.requirement, m.value, m.limit) for s in design.scenes for m in s.margins if not m.satisfied
        ]
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
    outcome = solved(seed)
    best, rng = outcome.lower_bound if outcome.best else math.inf, np.random.default_rng(seed)
    for _ in range(drawn(6, 100)):
        if not enumerated(seed):
            break
        found = small.pick(rng, enumerated(seed))
        model = bench(seed).model(found.hardware)
        if not brute.passes_without_light(model):
            continue
        design = evaluate_design(
            problem, found.hardware, random_settings(rng, model, found.settings), objective
        )
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
            f_number, time_s, level = (
                near[index][k] * rng.normal(1.0, 0.01) for k in ("f_number", "time_s", "level")
            )
            f_number = made[0].f_number if made else max(f_number, float(lens.f_number_min[0]))
        if not light.dims_freely[0]:
            steps = light.levels[0][~np.isnan(light.levels[0])]
            level = float(steps[np.abs(steps - level).argmin()])
        readout, offset = float(cam.readout_s[0]), float(cam.exposure_offset_s[0])
        burning = light.kind[0] == CONTINUOUS
        pulse = None if burning else float(min(time_s, light.flash_duration_s[0]))
        exposure = time_s - offset if burning else max(time_s + readout, float(cam.min_exposure_s[0]))
        wanted = model.problem.scenes[index].view.requirements.mean_level
        gain = None if wanted is not None else small.between(rng, 1.0, float(cam.max_gain[0]) * 1.0000001)
        made.append(
            SceneSettings(
                f_number=f_number,
                exposure_s=max(exposure, 1e-9),
                pulse_s=pulse,
                gain=gain,
                level=min(level, 1.0),
                dioptre_per_m=float(focus.dioptre_per_m[index][0]),
            )
        )
    return made


def kinds_of(seed: int) -> set[str]:
    """What a case is about: objective, wishes, parts, and the rules that discard in it."""
    case_, mission = case(seed), case(seed).mission
    asked = mission.requirements.model_dump(exclude_none=True) | mission.limits.model_dump(exclude_none=True)
    lights = {f"{p.kind} {'steps' if p.dim_levels else 'dial'}" for p in case_.parts.lights}
    irises = {f"{p.aperture_control} iris, {len(mission.scenes)} scenes" for p in case_.parts.lenses}
    rules = {f"rule {rule}" for rule, count in solved(seed).account.discarded.items() if count}
    kept = {"reserve"} if mission.reserve.snr_db else set()
    more = kept | {f"{mission.physics}, {len(mission.scenes)} scenes", str(mission.objective)}
    return {key for key in asked if asked[key]} | lights | irises | rules | more


def test_chosen_cases_meet_every_kind_with_designs_that_are_feasible() -> None:
    met = [kinds_of(seed) for seed in rc.CHOSEN]
    feasible = [kinds for seed, kinds in zip(rc.CHOSEN, met, strict=True) if solved(seed).best]
    assert len(feasible) >= 0.6 * len(met)
    assert EVERY_KIND - set().union(*feasible) == set()
    assert "rule data_rate_mb_s" in set().union(*met)  # it leaves nothing in the one case where it discards


# ---------------------------------------------------------------- what must not matter


@pytest.mark.parametrize("seed", FEW)
def test_order_of_parts_changes_nothing(seed: int) -> None:
    """Shuffled catalogues give the same list, by ids."""
    parts = case(seed).parts
    rng = np.random.default_rng(seed + 1000)
    mixed = Parts(*(shuffled(rng, getattr(parts, k)) for k in ("cameras", "lenses", "ports", "lights")))
    assert named(solved(seed), parts) == named(case(seed).solve(mixed)[1], mixed)


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
    before = solved(seed).best
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
    twice = [
        (*own, *(replace(part, id=f"{part.id}-twin") for part in own))
        for own in (getattr(parts, k) for k in kinds)
    ]
    doubled = case(seed).solve(Parts(*twice), top=1)[1]
    mixed = Parts(*(shuffled(rng, own) for own in twice))
    alone = named(solved(seed), parts)[:1]
    assert alone == named(doubled, Parts(*twice))
    assert alone == named(case(seed).solve(mixed, top=1)[1], mixed)

"""What is offered to be typed in holds when it is evaluated, is the best that can be set, or is not offered.

UWOPT_THOROUGH=1 tries more seeds.
"""

from __future__ import annotations

import io
from dataclasses import replace
from itertools import count
from typing import Any, cast

import numpy as np
import pytest
import random_cases as rc
import settable_cases as sc
from thorough import drawn

import uwopt
from uwopt.catalog.catalogue import Catalog
from uwopt.catalog.records import exact
from uwopt.deadline import Deadline
from uwopt.evaluation.design import evaluate_design
from uwopt.evaluation.design_model import DesignModel, design_model
from uwopt.evaluation.focus_marks import focus_distances_m
from uwopt.forward.figures import SettingRows
from uwopt.forward.parts import Parts
from uwopt.objectives.requirements import LEVEL_TOLERANCE_REL
from uwopt.report.text.console import print_blocks
from uwopt.report.text.short import full_text_blocks
from uwopt.results.design import SettableCheck
from uwopt.solvers.recommend import SETTINGS_TO_SET, Sought, best_settable
from uwopt.solvers.settable.rounding import exact_settings, given_of, rounded_design
from uwopt.solvers.settable.scene import Near, few_pixels
from uwopt.solvers.settable.steps import rates_hz, stops, time_steps

# Lamps that burn, pulse, flash; by steps or freely; one scene or two; full, auto, paper; every kind of requirement.
HOLDING = (4, 5, 12, 23, 40, 46, 54, 62, 1466)
FAILING = (41,)
FLASH = rc.lamp(
    "flash", kind="flash", flash_energy_j=20.0, flash_efficacy_lm_s_per_j=35.0, flash_duration_us=1_000.0,
    recycle_s=0.2, charging_efficiency_frac=0.7,
)  # fmt: skip
BURNING = rc.lamp("burning", kind="continuous", flux_lm=20_000.0, power_w=200.0)
STEPPED = rc.lamp(
    "stepped", kind="pulsed_led", flux_lm=20_000.0, power_w=200.0, dim_levels=(0.25, 0.5, 1.0), min_pulse_us=1.0,
    max_pulse_us=2000.0, max_duty_frac=0.5, max_rate_hz=50.0,
)  # fmt: skip


def with_lens(case: rc.Case, **changed: Any) -> rc.Case:
    """A case with another lens."""
    lens = replace(case.parts.lenses[0], **changed)
    return replace(case, parts=Parts(case.parts.cameras, (lens,), case.parts.ports, case.parts.lights))


def best_of(case: rc.Case) -> tuple[Any, Any]:
    """The problem of a case and its optimum."""
    search, outcome = case.solve(top=1)
    return search.problem, outcome.best[0]


@pytest.mark.parametrize("seed", drawn(HOLDING, range(200)))
def test_what_is_printed_to_set_meets_every_requirement_when_evaluated(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = sc.case(seed)
    start = sc.start(case, seed)
    design = None if start is None else start.rounded()
    if seed not in HOLDING and (design is None or not design.feasible):
        pytest.skip("nothing that can be set holds, so nothing is printed")
    assert design is not None
    assert design.feasible
    again = sc.evaluated(monkeypatch, case.mission, case.parts, sc.as_typed(design)).best
    assert again is not None
    assert [m for scene in again.scenes for m in scene.margins if not m.satisfied] == []


@pytest.mark.parametrize("seed", drawn(FAILING, range(200)))
def test_where_nothing_is_offered_no_random_setting_holds(seed: int) -> None:
    start = sc.start(sc.case(seed), seed)
    if start is None or len(start.exact) > 1 or start.rounded().feasible:
        pytest.skip("something is offered, or more than one scene would have to be set")
    model, rng, count = design_model(start.problem, start.hardware), np.random.default_rng([seed, 5]), 5000
    tried = sc.random_settings(model, start.exact[0], rng, count)
    margins = model.margins(0, tried, model.figures(0, tried), level_tolerance_rel=LEVEL_TOLERANCE_REL)
    holds = np.logical_and.reduce([np.broadcast_to(m.satisfied, count) for m in margins])
    assert not holds.any()


# ---------------------------------------------------------------- with all light counted


def test_sunlight_counts_when_a_sunlit_optimum_is_rounded() -> None:
    """Lamps that may be off beside a bright sun: without it the exposure would have to be a thousand times longer."""
    bright = ({"sun_lux": 1e5, "depth_m": 5.0},)
    case = rc.planted(
        "power", (BURNING,), {"min_snr_db": 25.0, "max_blur_px": 1.0, "mean_level": 0.3}, scenes=bright
    )
    problem, best = best_of(case)
    made = rounded_design(problem, best.hardware, best.settings, case.objective).design
    assert made.feasible
    to_set = made.scenes[0].settings
    assert to_set["dim_frac"] == 0.0
    # no watt is saved by the optimum's exposure, so it lies between signal to noise and blur, far from a thousand times
    assert 1.0 < to_set["exposure_ms"] / (best.settings[0]["exposure_s"] * 1e3) < 10.0
    # what half of the blur leaves is taken of the light that costs nothing: 0.42 ms with 11 dB of gain did as well
    assert 0.45 < made.scenes[0].figures["blur_px"] <= 0.5 and to_set["gain_db"] < 1.0


def test_pulsed_lamp_that_the_sun_makes_idle_is_rounded() -> None:
    """No light is asked of the lamp, so no time collects any: its quotient is not a number."""
    bright = ({"sun_lux": 2e4, "depth_m": 10.0},)
    case = rc.planted("power", (replace(STEPPED, dim_levels=None),), {"min_snr_db": 10.0}, scenes=bright)
    problem, best = best_of(case)
    made = rounded_design(problem, best.hardware, best.settings, case.objective).design
    assert made.feasible
    assert made.scenes[0].settings["dim_frac"] == 0.0


@pytest.mark.parametrize("prnu_frac", [0.0, 0.02])
def test_few_pixels_say_of_any_settings_whether_the_snr_holds(prnu_frac: float) -> None:
    """Of a murky image whose SNR 95 % must reach, at settings drawn at random: the same as all pixels say."""
    murky: dict[str, Any] = {"min_snr_db": 8.0, "snr_at": "worst"}
    camera = {"prnu_frac": exact(prnu_frac), "dark_current_e_s": exact(50.0)}
    case = rc.planted("power", (BURNING,), murky, camera=camera)
    problem, best = best_of(case)
    model = design_model(problem, best.hardware)
    few = few_pixels(model, 0)
    every, some = (one.rows[0].light.worst_e for one in (model, few))
    assert every is not None and some is not None and some.shape[2] < every.shape[2]
    tried = sc.random_settings(model, best.settings[0], np.random.default_rng(3), 2000)
    full, less = (
        next(m.satisfied for m in one.margins(0, tried, one.figures(0, tried)) if m.requirement == "min_snr_db")
        for one in (model, few)
    )
    assert (full == less).all() and full.any() and not full.all()


def test_what_misses_at_any_setting_is_told_where_pixels_ask_too() -> None:
    """No setting keeps a blur of nothing, so that the SNR of no pixel is worth looking at: the nearest miss is told."""
    murky: dict[str, Any] = {"min_snr_db": 8.0, "snr_at": "worst"}
    _, best = best_of(rc.planted("power", (BURNING,), murky))
    still = rc.planted("power", (BURNING,), murky | {"max_blur_px": 1e-9})
    made = rounded_design(still.problem(), best.hardware, best.settings, still.objective).design
    assert not made.feasible
    assert {margin.requirement for margin in made.scenes[0].margins if not margin.satisfied} >= {"max_blur_px"}


def test_rounding_ends_with_the_time() -> None:
    case = rc.planted("power", (STEPPED,), {"min_snr_db": 20.0, "max_blur_px": 1.0})
    search, outcome = case.solve(top=1)
    sought, clock = Sought(cast(Any, None), search.problem, search, outcome), count(1)
    late = Deadline(1.5, clock.__next__)  # its clock counts readings: time is over at the second, within the rounding
    _, design = best_settable(sought, late)
    assert design.rounded is None and late.left_out == [SETTINGS_TO_SET]
    assert next(clock) < 6  # and is not asked again by every setting that might be tried


# ---------------------------------------------------------------- the best that can be set


def test_no_setting_of_a_whole_grid_draws_less_power() -> None:
    """Every third of a stop, step of the lamp and microsecond of pulse, one by one."""
    case = rc.planted(
        "power", (STEPPED,), {"min_snr_db": 20.0, "max_blur_px": 1.0}, camera={"max_gain_db": exact(0.0)}
    )
    problem, best = best_of(case)
    model = design_model(problem, best.hardware)
    made = rounded_design(problem, best.hardware, best.settings, case.objective).design
    assert made.feasible
    given = made.scenes[0].settings
    assert given["focus_distance_m"] is not None
    n, level, pulse_us = (
        axis.ravel()
        for axis in np.meshgrid(stops(model.lenses, between=False), (0.25, 0.5, 1.0), np.arange(1, 2001))
    )
    tried = settings(
        model, best.settings[0], n, level, pulse_us * 1e-6, rate_hz=float(given["frame_rate_hz"] or 0)
    )
    figures = model.figures(0, tried)
    margins = model.margins(0, tried, figures)
    holds = np.logical_and.reduce([np.broadcast_to(m.satisfied, n.shape) for m in margins])
    assert holds.any()
    least_w = float(figures.light_power_w[holds].min())
    assert made.totals["light_power_w"] == pytest.approx(least_w, rel=1e-9)  # the same formulas: rounding


def settings(
    model: DesignModel, numbers: dict[str, Any], n: Any, level: Any, pulse_s: Any, *, rate_hz: float
) -> SettingRows:
    """Settings of a pulsed lamp under a global shutter at unit gain."""
    one = np.ones(len(n))
    open_s = np.maximum(pulse_s, float(np.ceil(model.cameras.min_exposure_s[0] * 1e6)) * 1e-6)
    return SettingRows(n, open_s, pulse_s, one, level, rate_hz * one, float(numbers["dioptre_per_m"]) * one)


def test_without_an_objective_rounding_stays_near_the_optimum() -> None:
    """A bright point of a front is not dimmed to the least that its mission asks for."""
    case = rc.planted("snr_db", (BURNING,), {"min_snr_db": 10.0, "max_blur_px": 1.0})
    problem, best = best_of(case)
    made = rounded_design(problem, best.hardware, best.settings, Near()).design
    assert made.feasible
    assert made.scenes[0].figures["snr_db"] == pytest.approx(
        best.snr_db, abs=0.3
    )  # the optimum has 20 dB to spare


def test_rounding_stays_near_in_all_that_a_front_trades() -> None:
    """By power and noise alone f/3.6 became f/2, whose blur leaves 42 % of the information."""
    asked = {"min_snr_db": 20.0, "max_blur_px": 1.0, "max_gsd_mm": 3.0, "min_dof_m": 0.3, "min_swath_m": 0.3}
    case = rc.planted("information", (FLASH,), asked)
    problem, best = best_of(case)
    exact = evaluate_design(problem, best.hardware, given_of(problem, best.hardware, best.settings), case.objective)
    made = rounded_design(problem, best.hardware, best.settings, Near(("snr_db", "information"))).design
    assert made.feasible
    there, here = (design.scenes[0].figures for design in (exact, made))
    assert here["information_bit_per_m2"] == pytest.approx(there["information_bit_per_m2"], rel=0.02)
    assert here["snr_db"] == pytest.approx(there["snr_db"], abs=0.3)


def test_manual_lens_keeps_stop_and_ring_in_both_scenes() -> None:
    """Behind a sealed port neither can be touched, though the dark floor wants a wide stop and the bright one cannot.

    The ring's distance differs with the water's index alone; a person sets either to a centimetre, or within a metre
    to three figures, so that what is told of one is no nearer to the other than half of that.
    """
    two = (
        {"seafloor": 0.03, "temperature_c": 2.0},
        {"seafloor": 0.9, "temperature_c": 25.0, "altitude_m": 1.0},
    )
    wanted = {"min_snr_db": 10.0, "max_blur_px": 20.0, "min_dof_m": 0.1}
    light = replace(BURNING, flux_lm=exact(3e5), dim_levels=(1.0,))
    case = rc.planted("snr_db", (light,), wanted, scenes=two, camera={"min_exposure_us": exact(5000.0)})
    problem, best = best_of(with_lens(case, aperture_control="manual"))
    model = design_model(problem, best.hardware)
    made = rounded_design(problem, best.hardware, best.settings, case.objective)
    assert made.design.feasible
    first, second = (model.settings(i, given) for i, given in enumerate(made.given))
    assert first.f_number == second.f_number > 2.0
    told_m = [float(given.focus_distance_m or 0.0) for given in made.given]
    assert told_m == [round(one, 3 if one < 1.0 else 2) for one in told_m]
    step = max(0.5e-3 if one < 1.0 else 0.5e-2 for one in told_m) / min(told_m)
    assert float(first.dioptre_per_m[0]) == pytest.approx(float(second.dioptre_per_m[0]), rel=1.1 * step)


# ---------------------------------------------------------------- nothing offered


def between_two_microseconds() -> rc.Case:
    """One stop, one level, no gain, and a mean level that falls halfway between 10 and 11 microseconds."""
    wanted = {"mean_level": 0.3, "max_blur_px": 1.0}
    camera = {"max_gain_db": exact(0.0), "min_exposure_us": exact(1.0), "exposure_offset_us": exact(0.0),
              "black_level_dn": 0.0}  # fmt: skip
    light = replace(BURNING, flux_lm=exact(1e7), dim_levels=(1.0,))
    case = with_lens(
        rc.planted("power", (light,), wanted, camera=camera),
        aperture_control="fixed",
        f_number_max=exact(1.4),
    )
    _, best = best_of(case)
    light = replace(light, flux_lm=exact(1e7 * best.settings[0]["exposure_s"] / 10.5e-6))
    return replace(case, parts=replace(case.parts, lights=(light,)))


def test_level_between_two_microseconds_is_not_offered() -> None:
    # the level is proportional to the exposure: 10 us give 4.8 % too little, 11 us 4.8 % too much, and 1.2 % count
    problem, best = best_of(between_two_microseconds())
    assert best.settings[0]["exposure_s"] == pytest.approx(10.5e-6, rel=1e-6)
    made = rounded_design(problem, best.hardware, best.settings, Near()).design
    assert not made.feasible
    assert made.scenes[0].settings["exposure_ms"] in (pytest.approx(0.010), pytest.approx(0.011))


@pytest.fixture(scope="module")
def unsettable() -> uwopt.Result:
    """The result of a mission whose optimum cannot be set."""
    return solved_with(between_two_microseconds())


def solved_with(case: rc.Case) -> uwopt.Result:
    """A case solved as a user's mission is, its parts the whole catalogue."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "uwopt.api.solving.load_catalog", lambda mission=None: Catalog(*sc.parts_of(case.parts))
        )
        return uwopt.solve(case.mission)


def test_result_is_not_headed_optimal_where_nothing_can_be_set(unsettable: uwopt.Result) -> None:
    assert unsettable.certificate is not None
    assert unsettable.certificate.complete
    assert unsettable.status == "feasible"


def test_no_settings_are_offered_where_none_holds(unsettable: uwopt.Result) -> None:
    assert unsettable.best is not None
    assert [scene.settings_to_set for scene in unsettable.best.scenes] == [None]
    assert unsettable.best.rounded == SettableCheck(
        feasible=False, objective_value=None, missed=["mean_level"]
    )
    assert "not_settable" in [warning["code"] for warning in unsettable.warnings]


def test_text_says_that_the_optimum_cannot_be_typed_in(unsettable: uwopt.Result) -> None:
    stream = io.StringIO()
    print_blocks(full_text_blocks(unsettable), stream)
    text = " ".join(stream.getvalue().split())
    assert "Settings to type in" not in text
    assert "no settings that can be typed in were found" in text
    assert "The nearest misses mean image level." in text


def test_next_best_that_can_be_set_is_recommended() -> None:
    # the dimmer lamp falls between 10 and 11 us; the other, 10.5 / 11 as bright, meets the level at 11 us for 1 W more
    case = between_two_microseconds()
    best = case.parts.lights[0]
    assert best.flux_lm is not None and best.power_w is not None
    flux, power = best.flux_lm.value * 10.5 / 11.0, best.power_w.value + 1.0
    other = replace(best, id="settable", flux_lm=exact(flux), power_w=exact(power))
    result = solved_with(replace(case, parts=replace(case.parts, lights=(best, other))))
    assert result.best is not None and result.certificate is not None
    assert (
        result.best.hardware["light"]["id"] == "settable"
        and result.best.scenes[0].settings_to_set is not None
    )
    assert [design.hardware["light"]["id"] for design in result.runners_up] == [best.id]
    assert "better_unsettable" in [warning["code"] for warning in result.warnings]
    assert result.status == "feasible"  # 1 W above what is proven, which the certificate says
    assert result.certificate.gap_abs == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize(("more_w", "taken"), [(1.0, True), (100.0, False)])
def test_hardware_that_can_be_set_is_looked_for_beyond_what_is_listed(more_w: float, taken: bool) -> None:
    """As above behind five lamps more that fall between two microseconds; not where it draws much more power."""
    case = between_two_microseconds()
    best = case.parts.lights[0]
    assert best.flux_lm is not None and best.power_w is not None
    power_w = best.power_w.value
    between = [replace(best, id=f"between {n}", power_w=exact(power_w + 0.1 * n)) for n in range(6)]
    settable = replace(
        best, id="settable", flux_lm=exact(best.flux_lm.value * 10.5 / 11.0), power_w=exact(power_w + more_w)
    )
    result = solved_with(replace(case, parts=replace(case.parts, lights=(*between, settable))))
    assert result.best is not None and result.best.is_settable is taken
    assert result.best.hardware["light"]["id"] == ("settable" if taken else "between 0")
    assert [design.hardware["light"]["id"] for design in result.runners_up][-1] == "between 4"
    assert result.certificate is not None
    assert result.certificate.gap_abs == pytest.approx(1.0 if taken else 0.0, abs=1e-5)


def test_what_is_better_as_set_is_recommended() -> None:
    # A reaches the SNR at half its 200 W in 10.5 us, no less: set in whole microseconds it takes full power. B draws
    # 130 W and gives a fifth more light than half of A, so that 10 us are enough.
    camera = {"min_exposure_us": exact(1.0), "exposure_offset_us": exact(0.0), "black_level_dn": 0.0}
    half = replace(BURNING, id="a", flux_lm=exact(1e7), dim_levels=(0.5,))

    def case_of(objective: str, lights: tuple[Any, ...], wanted: dict[str, float]) -> rc.Case:
        made = rc.planted(objective, lights, {"max_blur_px": 1.0, **wanted}, camera=camera)
        made = with_lens(made, aperture_control="fixed", f_number_max=exact(1.4))
        limits = made.mission.limits.model_copy(update={"max_exposure_ms": 0.0105})
        return replace(made, mission=made.mission.model_copy(update={"limits": limits}))

    _, best = best_of(case_of("snr_db", (half,), {}))
    wanted = {"min_snr_db": best.snr_db - 1e-6}
    a = replace(half, dim_levels=(0.5, 1.0))
    b = replace(half, id="b", flux_lm=exact(0.6e7), power_w=exact(130.0), dim_levels=(1.0,))
    result = solved_with(case_of("power", (a, b), wanted))
    assert result.best is not None and result.best.rounded is not None
    assert result.best.hardware["light"]["id"] == "b"
    assert result.best.rounded.objective_value == pytest.approx(result.best.objective_value)
    assert [design.hardware["light"]["id"] for design in result.runners_up] == ["a"]
    assert result.runners_up[0].objective_value < result.best.objective_value - 29
    (note,) = [w for w in result.warnings if w.code == "better_unsettable"]
    assert "settings that can be set" in note.message


# ---------------------------------------------------------------- marks


def test_stops_are_those_engraved_and_lie_on_the_lens() -> None:
    case = with_lens(rc.planted("power", (BURNING,), {}), f_number_min=exact(1.8), f_number_max=exact(5.9))
    marks = [1.8, 2.0, 2.2, 2.5, 2.8, 3.2, 3.5, 4.0, 4.5, 5.0, 5.6, 5.9]
    assert stops(case.problem().lenses, between=False).tolist() == marks


def test_halfway_stops_lie_between_all_marks() -> None:
    case = with_lens(rc.planted("power", (BURNING,), {}), f_number_min=exact(2.0), f_number_max=exact(2.8))
    found = stops(case.problem().lenses, between=True)
    # sqrt(2.0 * 2.2) = 2.098, sqrt(2.2 * 2.5) = 2.345, sqrt(2.5 * 2.8) = 2.646, in three figures upward
    assert found.tolist() == [2.0, 2.1, 2.2, 2.35, 2.5, 2.65, 2.8]


def test_frame_rate_is_rounded_upward() -> None:
    assert rates_hz(3.2162257797) == (3.22, 3.21623)
    assert rates_hz(2.0) == (2.0, 2.0)


def test_focus_is_offered_in_centimetres_and_within_a_metre_finer() -> None:
    assert focus_distances_m(2.0064) == [2.01, 2.0]
    assert focus_distances_m(0.15049) == [0.15, 0.151]


def test_long_exposures_keep_to_the_digits_that_are_printed() -> None:
    # six figures of 1 234 567 us are 1 234 560 us or 1 234 570 us
    assert time_steps(np.array([172.0, 1_234_567.0])).tolist() == [172.0, 1_234_560.0]
    assert time_steps(np.array([1_234_567.0]), up=True).tolist() == [1_234_570.0]


def test_exact_settings_are_left_as_the_search_found_them() -> None:
    case = rc.planted("power", (STEPPED,), {"min_snr_db": 20.0})
    problem, best = best_of(case)
    given = exact_settings(design_model(problem, best.hardware), 0, best.settings[0])
    assert given.pulse_s == best.settings[0]["time_s"]


def test_an_iris_that_is_fixed_is_printed_as_it_stands() -> None:
    made = rc.planted("power", (BURNING,), {"max_blur_px": 1.0, "min_snr_db": 10.0})
    fixed = replace(made, mission=made.mission.with_changes(fixed={"f_number": 2.3}))  # between two marks of the lens
    problem, best = best_of(fixed)
    to_set = rounded_design(problem, best.hardware, best.settings, fixed.objective).design.scenes[0].settings
    assert to_set["f_number"] == 2.3

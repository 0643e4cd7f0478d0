"""Fronts by pymoo: feasible, nondominated, distinct, near those of an enumeration; fixed seeds, never exact points."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import population_cases as cases
import pytest
import random_cases as rc
from hypothesis import given
from hypothesis import strategies as st
from thorough import drawn

from uwopt.catalog.records import exact
from uwopt.errors import MissionError
from uwopt.objectives.axes import Axes, Frame
from uwopt.objectives.dominance import hypervolume, near, nondominated, unlike_rows
from uwopt.objectives.objective import Objective
from uwopt.objectives.own import OwnObjective
from uwopt.solvers.exact.search import Search
from uwopt.solvers.population.pymoo_front import ALGORITHMS, PymooRun, population_front

PAIR, TRIPLE = ("power", "cost"), ("power", "cost", "snr_db")
SEEDS = drawn((24,), cases.FEASIBLE)  # by default two scenes; what is asked of one, and on paper, stands beside
ONE_SCENE = drawn((17,), (3, 7, 8, 9, 13, 17, 22, 24))
FEW: dict[str, Any] = {"pop_size": 24, "generations": 6}  # where any front will do
BRIEF: dict[str, Any] = FEW | drawn({"generations": 3}, {})
CURVE_REL = 2e-4  # how near the enumeration's grids come to the best settings


@cache
def kept_search(*names: str) -> Search:
    """One search for all runs that ask for nothing of their own: it keeps the light of what was looked at before."""
    return cases.search_of(rc.case(9), names)


def assert_front(search, front, names):
    """Every point feasible in the forward model with the same values, none dominated, no two alike."""
    assert len(front.found) == len(front.values) > 0
    assert nondominated(front.values).all()
    for row in range(len(front.values)):
        alike = near(front.values, front.values[row], 1e-3).all(axis=1)
        assert alike.sum() == 1
    for pick in np.unique(np.linspace(0, len(front.values) - 1, 6).astype(int)):
        design, values = cases.evaluated_values(search, front.found[pick], names)
        missed = [m.requirement for s in design.scenes for m in s.margins if not m.satisfied]
        assert design.feasible, missed
        # rounding of the two ways to the same model; integrals of the sun's field differ most
        assert front.values[pick] == pytest.approx(values, rel=1e-6)


def share_of(values, reference, names):
    """Hypervolume over that of reference points, in the reference's frame."""
    frame = Frame.of(Axes.of(names), reference)
    return hypervolume(values, frame) / hypervolume(reference, frame)


# ---------------------------------------------------------------- against enumeration


@pytest.mark.parametrize("seed", SEEDS)
def test_front_of_three_is_feasible_nondominated_and_distinct(seed):
    search, front = cases.front(seed, TRIPLE)
    assert_front(search, front, TRIPLE)


@pytest.mark.parametrize("seed", SEEDS)
def test_front_of_power_and_cost_reaches_that_of_enumeration(seed):
    reference = cases.enumerated_power_and_cost(seed)
    search, front = cases.front(seed, PAIR)
    assert_front(search, front, PAIR)
    # 1 %: a population need not find every hardware; more than 100 % only by what the grids leave
    assert 0.99 <= share_of(front.values, reference, PAIR) <= 1.0 + 10 * CURVE_REL
    cheapest, least = reference[:, 1].min(), reference[:, 0].min()
    assert front.values[:, 1].min() == pytest.approx(cheapest, rel=1e-9)
    assert front.values[:, 0].min() == pytest.approx(least, rel=CURVE_REL)


@pytest.mark.parametrize("seed", ONE_SCENE)
def test_front_of_three_reaches_that_of_enumeration(seed):
    reference = cases.enumerated_with_snr(seed)
    _, front = cases.front(seed, TRIPLE)
    # points within 0.1 % are left out of a front, 0.05 dB at 50 dB: that costs a front of few dB up to 2 %
    assert share_of(front.values, reference, TRIPLE) >= 0.97


@pytest.mark.parametrize("seed", drawn([20], [1, 6, 18, 20, 21]))
def test_front_is_empty_where_enumeration_finds_nothing(seed):
    assert len(cases.enumerated_power_and_cost(seed)) == 0
    _, front = cases.front(seed, PAIR)
    assert len(front.values) == 0
    assert front.found == []
    assert front.status == "complete"


# ---------------------------------------------------------------- kinds of lamps and axes


@pytest.mark.parametrize(("kind", "names"), [
    *((kind, ("power", "information")) for kind in drawn(["steps"], list(cases.LAMPS))),
    *((kind, ("power", "cost", "information")) for kind in drawn(["pulsed"], list(cases.LAMPS))),
])  # fmt: skip
def test_front_of_information_is_feasible_with_every_kind_of_lamp(kind, names):
    case = rc.planted("power", (cases.LAMPS[kind],), {"min_snr_db": 10.0, "max_blur_px": 2.0})
    search = cases.search_of(case, names)
    assert_front(search, population_front(search, names, **FEW), names)


def test_front_of_information_reaches_that_of_enumeration():
    case = rc.planted("power", (cases.LAMPS["free"],), {"min_snr_db": 10.0, "max_blur_px": 2.0})
    names = ("power", "information")
    reference = cases.enumerated_with_information(case)
    front = population_front(cases.search_of(case, names), names, **cases.SMALL)
    # the enumeration's grids of 13 f-numbers, 9 times and 17 lights are coarser than the front's shares
    assert 0.99 <= share_of(front.values, reference, names) <= 1.1


def test_front_with_sun_and_wanted_sharpness_is_feasible():
    wanted = {"min_snr_db": 15.0, "max_blur_px": 2.0, "min_mtf_half_nyquist": 0.2}
    case = rc.planted("power", (cases.LAMPS["pulsed"], cases.LAMPS["free"]), wanted, altitude_m=1.5)
    scenes = [
        scene.model_copy(update={"sun_lux": 20_000.0, "depth_m": 20.0}) for scene in case.mission.scenes
    ]
    sunny = rc.Case(case.parts, case.mission.model_copy(update={"scenes": scenes}), case.objective)
    names = ("power", "cost", "snr_db")
    search = cases.search_of(sunny, names)
    front = population_front(search, names, **FEW)
    assert_front(search, front, names)


def test_lamp_with_steps_shows_each_step_on_the_front():
    case = rc.planted("power", (cases.LAMPS["steps"],), {"min_snr_db": 5.0, "max_blur_px": 2.0})
    search = cases.search_of(case, ("power", "information"))
    front = population_front(search, ("power", "information"), **cases.SMALL)
    levels = {found.settings[0]["level"] for found in front.found}
    assert levels <= {0.1, 0.25, 0.5, 1.0}
    assert len(levels) > 1


# ---------------------------------------------------------------- runs


def test_same_seed_gives_the_same_front():
    search = cases.search_of(rc.case(9), TRIPLE)
    first, second = (population_front(search, TRIPLE, seed=3, **FEW) for _ in range(2))
    assert np.array_equal(first.values, second.values)
    assert first.found == second.found


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_every_algorithm_gives_a_feasible_front(algorithm):
    search = kept_search(*TRIPLE)
    front = population_front(search, TRIPLE, algorithm=algorithm, **BRIEF)
    assert front.algorithm == algorithm
    assert_front(search, front, TRIPLE)


def test_interruption_keeps_what_was_found(monkeypatch):
    search, calls = cases.search_of(rc.case(9), TRIPLE), []
    evaluate = PymooRun.evaluate

    def interrupted(run, vectors):
        calls.append(len(vectors))
        if len(calls) == 12:
            raise KeyboardInterrupt
        return evaluate(run, vectors)

    monkeypatch.setattr(PymooRun, "evaluate", interrupted)
    front = population_front(search, TRIPLE, **cases.SMALL)
    assert front.status == "interrupted"
    assert_front(search, front, TRIPLE)


def test_run_out_of_time_is_stopped_and_keeps_what_was_found():
    search = cases.search_of(rc.case(9), TRIPLE)
    front = population_front(search, TRIPLE, seconds=1e-6, pop_size=40)
    assert front.status == "stopped"
    assert front.generations == 1
    assert len(front.values) > 0


def test_run_ends_when_the_hypervolume_stagnates():
    front = population_front(kept_search(*PAIR), PAIR, pop_size=8)
    assert front.status == "complete"
    assert front.generations < 200


def test_progress_is_told_and_history_grows():
    told = []
    front = population_front(
        kept_search(*TRIPLE), TRIPLE, progress=lambda share, text: told.append((share, text)), **cases.SMALL
    )
    shares = [share for share, _ in told]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    seconds = [t for t, _ in front.history]
    assert seconds == sorted(seconds)
    # thinning takes away what lies within 0.1 %
    names = Axes.of(TRIPLE)
    frame = Frame.of(names, front.history[-1][1])
    volumes = [hypervolume(values, frame) for _, values in front.history]
    assert volumes == sorted(volumes)
    assert hypervolume(front.values, frame) == pytest.approx(volumes[-1], rel=0.03)


# ---------------------------------------------------------------- objectives of the user's own


def test_own_function_is_an_axis_and_agrees_with_figures():
    search = kept_search("power")

    def megabytes_per_watt(figures):
        return -figures["data_rate_mb_s"] / figures["power_w"]

    front = population_front(search, ("power", OwnObjective.of(megabytes_per_watt)), **FEW)
    assert front.axes[1] == OwnObjective("megabytes_per_watt", megabytes_per_watt)
    best = front.found[int(front.values[:, 1].argmin())]
    figures = cases.evaluated(search, best, Objective.of("power")).scenes[0].figures
    value = -figures["data_rate_mb_s"] / best.power_w
    assert front.values[:, 1].min() == pytest.approx(value, rel=1e-6)  # rounding


def test_own_objective_may_be_maximised():
    sharp_depth = OwnObjective("near", lambda f: f["dof_near_m"], "maximise", "m")
    front = population_front(kept_search("power"), ("power", sharp_depth), **FEW)
    assert (front.values[:, 1] < 0).all()
    assert nondominated(front.values).all()


def test_own_objective_sees_every_named_figure_of_each_design():
    from uwopt.objectives.own import FIGURES, PARTS

    seen = {}

    def look(figures):
        seen.update(figures)
        return figures["power_w"]

    population_front(kept_search("cost"), ("cost", OwnObjective.of(look)), **FEW)
    assert set(seen) == {*FIGURES, *PARTS, *(f"{part}_id" for part in PARTS)}
    assert len({len(column) for column in seen.values()}) == 1
    assert all(np.isfinite(seen[name]).all() for name in set(FIGURES) - {"dof_far_m"})


def raises(figures):
    raise ZeroDivisionError("no such thing")


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda f: f["power"], r"there is no figure 'power'; known: .*power_w"),
        (lambda f: f["power_w"][:-1], r"returned an array of shape"),
        (lambda f: f["power_w"] * np.nan, r"returned NaN for"),
        (lambda f: "dear", r"ValueError"),
        (raises, r"ZeroDivisionError: no such thing"),
    ],
)
def test_fault_of_an_own_function_names_it(function, message):
    own = OwnObjective("wishful", function)
    with pytest.raises(MissionError, match=f"objective wishful: {message}"):
        population_front(kept_search("power"), ("power", own), **FEW)


def test_own_objective_has_a_known_direction():
    with pytest.raises(MissionError, match="minimise, maximise"):
        OwnObjective("one", raises, "up")


# ---------------------------------------------------------------- points that are alike


@given(
    points=st.lists(
        st.tuples(st.floats(1.0, 1.02), st.floats(1.0, 1.02), st.floats(-31.0, -30.0)),
        min_size=1,
        max_size=60,
    )
)
def test_distinct_points_stand_for_all_that_were_left_out(points):
    values = np.array(points)
    kept = unlike_rows(values, np.array([True, True, False]))
    for row in range(len(values)):
        alike = near(values[kept], values[row], 1e-3).all(axis=1)
        assert alike.sum() == 1 if row in kept else alike.any()


def test_catalogue_of_one_design_has_a_front_of_one_curve():
    lamp = rc.lamp("one", kind="continuous", flux_lm=20_000.0, power_w=200.0, dim_levels=(1.0,))
    case = rc.planted("power", (lamp,), {"min_snr_db": 5.0}, camera={"price": exact(1000.0)})
    front = population_front(cases.search_of(case, PAIR), PAIR, **FEW)
    assert len(front.values) == 1

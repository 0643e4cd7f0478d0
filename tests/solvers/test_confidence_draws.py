"""Draws of what is uncertain, against SciPy and by counting."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from one_of_each import one

from uwopt.catalog.parts.quantity import Quantity
from uwopt.mission.doubt import Doubt
from uwopt.objectives.objective import Objective
from uwopt.solvers.confidence.draws import drawn_parts, even_points, probabilities, triangular
from uwopt.solvers.confidence.panels import panel_of
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.confidence.summary import wilson
from uwopt.solvers.confidence.waters import Waters, WaterState, drawn_states, over_band
from uwopt.solvers.confidence.worst_case import EndScenarios, worse_problem


@pytest.mark.parametrize(
    ("low", "mode", "high"), [(1.0, 2.0, 5.0), (0.0, 0.0, 1.0), (-1.0, 3.0, 3.0), (0.8, 1.0, 1.25)]
)
def test_quantiles_are_those_of_the_triangular_distribution(low: float, mode: float, high: float) -> None:
    """SciPy's own, its shape being where the mode lies between the ends."""
    from scipy.stats import triang

    at = np.linspace(0.001, 0.999, 41)
    expected = triang.ppf(at, (mode - low) / (high - low), loc=low, scale=high - low)
    assert triangular(at, low, mode, high) == pytest.approx(expected, abs=1e-12)


def test_a_range_of_no_width_is_its_value() -> None:
    assert triangular(np.array([0.1, 0.9]), 2.0, 2.0, 2.0).tolist() == [2.0, 2.0]


def test_each_state_falls_into_another_part_of_the_probability() -> None:
    """64 states in 64 bins; the same for the same name, others for another."""
    drawn = probabilities(7, "lamp power_w", 64)
    assert sorted((drawn * 64).astype(int).tolist()) == list(range(64))
    assert np.array_equal(drawn, probabilities(7, "lamp power_w", 64))
    other = probabilities(7, "lamp flux_lm", 64)
    assert abs(float(np.corrcoef(drawn, other)[0, 1])) < 0.4
    assert not np.array_equal(drawn, probabilities(8, "lamp power_w", 64))


def test_points_fill_the_cube_evenly() -> None:
    """256 points in 16 parts of four dimensions: 16 each if spread perfectly, 8 to 24 by chance."""
    points = even_points(0, 256)
    assert ((points >= 0.0) & (points < 1.0)).all()
    halves = points > 0.5
    counts = [int((halves == np.array(corner)).all(axis=1).sum()) for corner in product((False, True), repeat=4)]
    assert sum(counts) == 256 and min(counts) >= 13 and max(counts) <= 19
    assert points.mean(axis=0) == pytest.approx(0.5, abs=0.01)


def test_a_part_is_drawn_alike_in_every_design_and_others_apart() -> None:
    """Facts that a source states stay; an estimated one takes its draws, whatever else the part has."""
    camera = replace(one().parts.cameras[0], power_w=Quantity(3.0, 2.0, 6.0, "estimated"))
    dearer = replace(camera, price=Quantity(900.0, 800.0, 1000.0, "estimated"))
    first, second = drawn_parts(camera, 5, 32), drawn_parts(dearer, 5, 32)
    assert [p.power_w.value for p in first] == [p.power_w.value for p in second]
    assert {p.price.value for p in first} == {1000.0}
    assert all(2.0 < p.power_w.value < 6.0 and p.power_w.low == p.power_w.high for p in first)
    other = drawn_parts(replace(camera, id="other"), 5, 32)
    assert [p.power_w.value for p in other] != [p.power_w.value for p in first]


@pytest.mark.parametrize("basis", ["high", "central"])
def test_a_budget_counts_what_may_have_to_be_paid(basis: str) -> None:
    """A camera of 600 to 900 USD: drawn, in a panel, or where parts are worse; and its computer of 1000 to 1300."""
    host = Quantity(1100.0, 1000.0, 1300.0, "estimated")
    doubted = {"price": Quantity(700.0, 600.0, 900.0, "estimated"), "host_price": host}
    case_ = one("cost", camera=doubted, limits={"cost": 9e3, "cost_basis": basis}, catalog={"host": "estimate"})
    problem = case_.problem()
    scenarios = Scenarios.drawn(problem.mission, problem.scenes, Doubt(), seed=0, count=32)
    drawn = case_.problem(replace(problem.parts, cameras=tuple(scenarios.each(problem.parts.cameras[0]))))
    panel = panel_of(problem, scenarios, Objective.of("cost"), 17).problem
    worse = worse_problem(problem, scenarios, 0.75)
    for cameras in (drawn.cameras, panel.cameras, worse.cameras):
        assert cameras.price.max() < 2200.0
        expected = cameras.price if basis == "central" else np.full(len(cameras.price), 2200.0)
        assert cameras.limit_price.tolist() == expected.tolist()


def test_parts_are_drawn_and_made_worse_once() -> None:
    """Whoever asks again for as many draws of one seed, or for parts as much worse, gets the same records, so that
    their columns are tabulated once. Others are not taken for them: of 2 to 5 W, likeliest 2, less than 3.5 W in 0.75
    of the draws and less than 4 W in 0.8889."""
    problem = one(camera={"power_w": Quantity(2.0, 2.0, 5.0, "estimated")}).problem()
    mission, scenes, camera = problem.mission, problem.scenes, problem.parts.cameras[0]
    first = Scenarios.drawn(mission, scenes, Doubt(), seed=0, count=32)
    again, others, fewer = (
        Scenarios.drawn(mission, scenes, Doubt(), seed=seed, count=count, like=first)
        for seed, count in ((0, 32), (1, 32), (0, 16))
    )
    drawn = first.each(camera)
    assert all(a is b for a, b in zip(drawn, again.each(camera), strict=True))
    assert sorted(part.power_w.value for part in others.each(camera)) != sorted(part.power_w.value for part in drawn)
    assert len(fewer.each(camera)) == 16
    worse, once_more, worst = (worse_problem(problem, first, share).parts for share in (0.75, 0.75, 8.0 / 9.0))
    for some, same in zip(vars(worse).values(), vars(once_more).values(), strict=True):
        assert all(a is b for a, b in zip(some, same, strict=True))
    assert [parts.cameras[0].power_w.value for parts in (worse, worst)] == pytest.approx([3.5, 4.0])
    assert worst.lights[0].output_factor.value < worse.lights[0].output_factor.value < 1.0


def test_states_of_the_water_keep_to_what_is_in_doubt() -> None:
    """A quarter in the other table; nothing of K or clarity where they are known; a floor about 1."""
    known = Doubt(clarity=False, lamp_leg=False, other_water_table=0.25, floor=(0.5, 2.0), beyond_band=0.4)
    states = drawn_states(known, 3, 400)
    assert {state.beyond for state in states} == {0.0}  # there is no band
    for seed in range(5):  # as often beyond any limit as a triangle is, P(beyond > t) = (1 - t / 0.4)^2, to a sixteenth
        beyond = np.array([state.beyond for state in drawn_states(known, seed, 400, has_band=True)])
        limits = np.linspace(0.0, 0.4, 81)
        assert np.abs((beyond[:, None] > limits).mean(0) - (1.0 - limits / 0.4) ** 2).max() < 0.07
    assert sum(state.other_table for state in states) == pytest.approx(100, abs=4)
    assert {(state.clarity, state.lamp_leg) for state in states} == {(0.0, 0.0)}
    floors = np.array([state.floor for state in states])
    assert floors.min() > 0.5 and floors.max() < 2.0
    # median of a triangle from 0.5 over 1 to 2: the upper side holds two thirds of it
    assert np.median(floors) == pytest.approx(2.0 - np.sqrt(0.5 * 1.5 * 1.0), abs=0.01)


@pytest.mark.parametrize(("hits", "count"), [(0, 50), (930, 1024), (1024, 1024), (1, 3)])
def test_the_interval_of_a_share_is_that_of_wilson(hits: int, count: int) -> None:
    """SciPy's."""
    from scipy.stats import binomtest

    expected = binomtest(hits, count).proportion_ci(0.95, method="wilson")
    assert wilson(hits / count, count) == pytest.approx((expected.low, expected.high), abs=1e-6)


def test_beyond_its_band_the_swath_is_as_asked_for() -> None:
    """What is kept of it in hand is kept for that: 1.5 m asked, 1.8 m held in the band."""
    case_ = one(wanted={"min_swath_m": 1.5}, vehicle={"altitude_tolerance_m": 0.2})
    mission = case_.mission.with_changes(reserve={"swath": 0.2})
    scene = replace(case_, mission=mission).problem().scenes[0]
    assert scene.view.requirements.min_swath_m == pytest.approx(1.8)
    assert over_band(scene, 0.0).view.requirements.min_swath_m == pytest.approx(1.8)
    assert over_band(scene, 0.25).view.requirements.min_swath_m == pytest.approx(1.5)


def test_particles_of_many_states_are_those_of_the_scene_in_each() -> None:
    """Of a visibility, clear and murky, in both tables: what one scene after another has."""
    scenes = [{"water": None, "visibility_m": 12.0}]
    problem = one(wanted={"min_snr_db": 20.0}, scenes=scenes).problem()
    waters = Waters.of(problem.mission, problem.scenes)
    states = drawn_states(Doubt(), 1, 48)
    assert {np.sign(state.clarity) for state in states} >= {-1.0, 1.0}
    states.append(WaterState(other_table=False, clarity=0.0, lamp_leg=0.0, floor=1.0))
    seen = waters.nodes_of[0].particles_per_m(states)
    apart = [waters.at(state)[0].particles_per_m() for state in states]
    assert np.ptp([column.max() for column in apart]) > 0.0
    np.testing.assert_allclose(seen, apart, rtol=1e-14)


@pytest.mark.parametrize(
    ("scene", "tables", "read"),
    [
        ({"water": "II"}, {False, True}, False),  # both tables have the type, which is no reading
        ({"water": None, "visibility_m": 12.0}, {False, True}, True),
        ({"water": None, "c_per_m": 0.3}, {False, True}, True),
    ],
)
def test_no_light_is_worked_out_in_waters_that_are_all_the_same(
    scene: dict[str, object], tables: set[bool], read: bool
) -> None:
    """What a state is told apart by makes another water; with its ends nothing else does."""
    problem = one(wanted={"min_snr_db": 20.0}, scenes=[scene]).problem()
    drawn = Scenarios.drawn(problem.mission, problem.scenes, Doubt(), seed=0, count=64)
    ends = EndScenarios.of(problem.mission, problem.scenes, Doubt())
    for scenarios in (drawn, ends):
        assert {state.other_table for state in scenarios.states} == tables
        assert any(state.clarity for state in scenarios.states) is read
    clear, murky = (
        drawn.waters.at(WaterState(other_table=False, clarity=end, lamp_leg=0.0, floor=1.0))[0] for end in (-1.0, 1.0)
    )
    assert bool(np.ptp([clear.attenuation_per_m, murky.attenuation_per_m], axis=0).max() > 0.0) is read


def test_known_waters_ask_for_what_a_mission_asks() -> None:
    """A swath that is asked for anew is asked beyond the band too; who stands still leaves no band."""
    case_ = one(wanted={"min_swath_m": 1.5}, vehicle={"altitude_tolerance_m": 0.2})
    problem, mission = case_.problem(), case_.mission
    waters, beyond = Waters.of(mission, problem.scenes), WaterState(False, 0.0, 0.0, 1.0, 0.25)
    central = replace(beyond, beyond=0.0)
    for state in (beyond, central):
        waters.kept(state)
    wider = mission.with_changes(requirements=mission.to_dict()["requirements"] | {"min_swath_m": 1.6})
    scenes = problem.scenes_for(wider)
    assert scenes is not None
    seen = waters.seen_by(wider, scenes)
    for state in (beyond, central):
        ours, anew = seen.kept(state)[0], Waters.of(wider, scenes).at(state)[0]
        assert ours.cache is waters.kept(state)[0].cache and ours.view == anew.view
        assert ours.range_m.tolist() == anew.range_m.tolist() and ours.view.requirements.min_swath_m == 1.6
    still = mission.with_changes(vehicle=mission.to_dict()["vehicle"] | {"speed_m_s": 0.0})
    scenes = problem.scenes_for(still)
    assert scenes is not None
    assert waters.seen_by(still, scenes).kept(beyond)[0].range_m.tolist() == problem.scenes[0].range_m.tolist()

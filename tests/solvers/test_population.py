"""Integer vectors as designs: what genes mean, how little is worked out twice, and that evaluation is the model's."""

from __future__ import annotations

import numpy as np
import population_cases as cases
import pytest
import random_cases as rc
from thorough import drawn

from uwopt.objectives.objective import Objective
from uwopt.solvers.population.coding import Coding, layers
from uwopt.solvers.population.decoding import log_between, log_excess
from uwopt.solvers.population.evaluator import Evaluator
from uwopt.solvers.population.light_store import LightStore

TRIPLE = ("power", "cost", "snr_db")
SEEDS = drawn((8, 14, 22), cases.FEASIBLE)  # one scene and two, flashes, a mean level, physics paper


def coded(seed, names=TRIPLE):
    search = cases.search_of(rc.case(seed), names)
    axes = list(names)
    return search, Coding(search, axes), axes


@pytest.mark.parametrize("seed", SEEDS)
def test_every_vector_is_hardware_that_passes_the_rules_without_light(seed):
    search, coding, _ = coded(seed)
    built = coding.built(coding.random(500, np.random.default_rng(0)))
    assert np.isin(built.imager, np.arange(len(search.imagers))).all()
    low, high = search.problem.count_range
    assert ((built.count >= low) & (built.count <= high)).all()
    lighting = [search.tables.lightings[k] for k in built.lighting]
    optics = search.problem.lights.optics_index[built.light]
    assert [one.optics for one in lighting] == list(optics)
    assert coding.nodes.alive[built.imager, optics].all()


@pytest.mark.parametrize("seed", SEEDS)
def test_vectors_reach_every_imager_with_every_lamp_that_may_do(seed):
    search, coding, _ = coded(seed)
    built = coding.built(coding.random(20_000, np.random.default_rng(0)))
    reached = {(int(i), int(light)) for i, light in zip(built.imager, built.light, strict=True)}
    alive = coding.nodes.alive[:, search.problem.lights.optics_index]
    assert reached == {(int(i), int(light)) for i, light in np.argwhere(alive)}


@pytest.mark.parametrize("seed", SEEDS)
def test_genes_of_hardware_are_read_back_as_that_hardware(seed):
    _, coding, _ = coded(seed)
    rng = np.random.default_rng(1)
    built = coding.built(coding.random(300, rng))
    again = coding.built(coding.genes_of(built, rng))
    for name in ("imager", "light", "count", "lighting"):
        assert np.array_equal(getattr(again, name), getattr(built, name))


@pytest.mark.parametrize("seed", SEEDS)
def test_light_that_bounds_miss_is_missing_indeed(seed):
    search, coding, axes = coded(seed)
    vectors = coding.random(400, np.random.default_rng(2))
    built, lights = coding.built(vectors), search.problem.lights
    capacity = built.count * (lights.full_light * lights.output_factor)[built.light]
    lacking = coding.nodes.lacking(built.imager, built.lighting, lights.kind[built.light], capacity)
    coding.beyond = lambda built: np.zeros(len(built.imager))  # evaluate everything
    _, violation = Evaluator(search, axes, coding).evaluate(vectors)
    assert (violation <= 0.0).any()
    assert (lacking[violation <= 0.0] == 0.0).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_shared_images_have_the_light_of_each_imager(seed):
    search, coding, _ = coded(seed)
    store = LightStore(search, sharp=False)
    built = coding.built(coding.random(60, np.random.default_rng(3)))
    for scene in range(len(search.problem.scenes)):
        seen = store.seen(scene, built.imager, built.lighting, built.count)
        for k in np.unique(built.lighting):
            mine = np.nonzero(built.lighting == k)[0]
            own = search.tables.exact(scene, search.tables.lightings[k], built.imager[mine])
            # the same integral times another collecting area: rounding of sums over nodes
            assert seen.light.signal_e[mine] == pytest.approx(own.signal_e, rel=1e-9)
            if own.veil_e is not None:
                assert seen.light.veil_e[mine] == pytest.approx(own.veil_e, rel=1e-9)


def test_light_of_an_image_is_worked_out_once():
    search, coding, _ = coded(9)
    store = LightStore(search, sharp=False)
    built = coding.built(coding.random(300, np.random.default_rng(4)))
    store.seen(0, built.imager, built.lighting, built.count)
    known = sum(len(light.keys) for light in store.lights)
    assert known <= len(store.images) * len(search.tables.lightings) < len(built.imager)
    store.seen(0, built.imager, built.lighting, built.count)
    assert sum(len(light.keys) for light in store.lights) == known


@pytest.mark.parametrize("seed", SEEDS)
def test_random_feasible_vectors_are_what_an_evaluation_says(seed):
    search, coding, axes = coded(seed)
    evaluator = Evaluator(search, axes, coding)
    vectors = coding.random(400, np.random.default_rng(5))
    values, violation = evaluator.evaluate(vectors)
    some = np.nonzero(violation <= 0.0)[0][:3]
    kept, designs = evaluator.found(vectors[some])
    assert list(kept) == list(range(len(some)))
    for place, found in zip(some, designs, strict=True):
        design = cases.evaluated(search, found, Objective.of("snr_db"))
        assert design.feasible
        # both rest on the same formulas: rounding alone
        assert -values[place, 2] == pytest.approx(design.objective_value, rel=1e-6)
        assert values[place, 0] == pytest.approx(design.totals["power_w"], rel=1e-6)
        assert found.minimised == pytest.approx(values[place].sum(), rel=1e-9)


def test_values_do_not_depend_on_who_else_is_in_the_batch():
    search, coding, axes = coded(14)
    vectors = coding.random(200, np.random.default_rng(6))
    together, _ = Evaluator(search, axes, coding).evaluate(vectors)
    apart = np.concatenate(
        [Evaluator(search, axes, coding).evaluate(part)[0] for part in np.split(vectors, 4)]
    )
    assert np.array_equal(np.isfinite(together), np.isfinite(apart))
    finite = np.isfinite(together)
    assert together[finite] == pytest.approx(apart[finite], rel=1e-9)  # order of sums


def test_lamps_that_burn_pulse_and_flash_are_judged_alike_together_and_apart():
    # a margin of pulses must not speak against a lamp that burns only because another one pulses
    case = rc.planted("power", tuple(cases.LAMPS.values()), {"min_snr_db": 10.0, "max_blur_px": 2.0})
    search = cases.search_of(case, TRIPLE)
    axes = list(TRIPLE)
    coding = Coding(search, axes)
    vectors = coding.random(300, np.random.default_rng(10))
    light = coding.built(vectors).light
    together = Evaluator(search, axes, coding).evaluate(vectors)[1] <= 0.0
    for lamp in np.unique(light):
        mine = light == lamp
        apart = Evaluator(search, axes, coding).evaluate(vectors[mine])[1] <= 0.0
        assert apart.any()
        assert np.array_equal(together[mine], apart)


def test_first_population_begins_with_designs_that_bounds_like():
    _, coding, _ = coded(9)
    first = coding.first(40, np.random.default_rng(7))
    assert first.shape == (40, len(coding.upper))
    assert ((first >= 0) & (first <= coding.upper)).all()
    seeds = coding.seeds(20)
    assert np.array_equal(coding.built(first[: 2 * len(seeds.imager) : 2]).imager, seeds.imager)


def test_layers_take_the_best_first():
    values = np.array([[3.0, 3.0], [1.0, 2.0], [2.0, 1.0], [2.0, 3.0]])
    assert set(layers(values, 2)) == {1, 2}
    assert list(layers(values, 4))[2:] == [3, 0]


def test_between_meets_both_ends_and_grows_evenly_in_logarithms():
    low, high = np.full(3, 2.0), np.full(3, 8.0)
    assert log_between(low, high, np.array([0.0, 0.5, 1.0])) == pytest.approx([2.0, 4.0, 8.0], rel=1e-15)


def test_excess_is_zero_within_a_limit_and_a_logarithm_beyond():
    value, most = np.array([1.0, 2.0, np.e, np.nan]), np.array([2.0, 2.0, 1.0, 1.0])
    assert log_excess(value, most) == pytest.approx([0.0, 0.0, 1.0, 10.0])


@pytest.mark.parametrize("seed", SEEDS)
def test_looking_at_the_signal_first_loses_no_feasible_design(seed):
    search, coding, axes = coded(seed)
    vectors = coding.random(300, np.random.default_rng(8))
    careful = Evaluator(search, axes, coding)
    careful.staged = False
    whole, (values, _) = careful.evaluate(vectors)[0], Evaluator(search, axes, coding).evaluate(vectors)
    assert np.isfinite(whole).any()
    assert np.array_equal(np.isfinite(values), np.isfinite(whole))


def test_designs_of_vectors_leave_out_those_that_are_not_feasible():
    search, coding, axes = coded(9)
    evaluator = Evaluator(search, axes, coding)
    vectors = coding.random(200, np.random.default_rng(9))
    values, violation = evaluator.evaluate(vectors)
    kept, designs = evaluator.found(vectors)
    assert 0 < len(kept) < len(vectors)
    assert list(kept) == list(np.nonzero(violation <= 0.0)[0])
    assert [d.power_w for d in designs] == pytest.approx(list(values[kept, 0]), rel=1e-12)

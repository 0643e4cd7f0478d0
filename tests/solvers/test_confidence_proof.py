"""That nothing else holds and is better: against every hardware of small catalogues, counted in all scenarios."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import cache
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from most_certain import most_certain
from one_of_each import one, with_parts
from random_cases import Case, case
from thorough import drawn

from uwopt.catalog.parts.kinds import FAVOURED
from uwopt.catalog.parts.quantity import Quantity
from uwopt.deadline import NEVER, Deadline, effort_s, unheard
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.solvers.beside import cores
from uwopt.solvers.confidence import local_search as local_search_module
from uwopt.solvers.confidence import proof as proof_module
from uwopt.solvers.confidence import roomy as roomy_module
from uwopt.solvers.confidence import search as search_module
from uwopt.solvers.confidence.counted import Counted, Looked, best_of, names, rank
from uwopt.solvers.confidence.local_search import Glance, polish
from uwopt.solvers.confidence.outcomes import Outcomes, groups_of, outcomes_of_each
from uwopt.solvers.confidence.panels import anchors_of, best_scene, least_covered, panel_of
from uwopt.solvers.confidence.proof import Prover, bounds_of
from uwopt.solvers.confidence.scenarios import Scenarios, SomeScenarios, loss
from uwopt.solvers.confidence.search import Certain, can_be_proven
from uwopt.solvers.confidence.states import Together
from uwopt.solvers.confidence.summary import counted_confidence, proof_told, wilson
from uwopt.solvers.exact.imagers import fitting_pairs
from uwopt.solvers.exact.lightings import Lighting
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.recommend import Sought

SHARE = 0.8
WIDE = {"clarity": True, "lamp_leg": True, "other_water_table": 0.5, "floor": [0.7, 1.4], "lamp_output": [0.8, 1.1]}
RANDOM = drawn((17,), tuple(range(60)))
INTERPOLATED = 0.02  # of a value: light in other water is interpolated, bounds are not


def between(low: float, value: float, high: float) -> Quantity:
    """A number that is estimated."""
    return Quantity(value, low, high, "estimated")


def rivals() -> Case:
    """Two cameras, lenses and lamps in one to two numbers; one camera draws 2.5 to 12 W, most likely 3, one 4 W."""
    unsure = {"power_w": between(2.5, 3.0, 12.0), "read_noise_e": between(1.0, 2.0, 8.0)}
    return with_parts(
        one(scenes=({"visibility_m": 12.0, "water": None},), wanted={"max_blur_px": 1.0, "min_snr_db": 25.0},
            camera=unsure, light={"flux_lm": between(1.5e4, 3e4, 4e4)},
            vehicle={"light_count": [1, 2], "altitude_tolerance_m": 0.1}),
        cameras=[{"power_w": 4.0, "read_noise_e": 2.0}],
        lenses=[{"f_number_min": 1.4, "price": 700.0}],
        lights=[{"flux_lm": 3.4e4, "power_w": 330.0}],
    )  # fmt: skip


def sought_of(case_: Case) -> Sought:
    """The central search of a case, in doubt of everything."""
    case_ = replace(case_, mission=case_.mission.with_changes(doubt=WIDE | {"scenarios": 48}))
    search, outcome = case_.solve(top=5)
    return Sought(None, search.problem, search, outcome)  # type: ignore[arg-type]


@cache
def known() -> tuple[Sought, Certain]:
    """The rivals, and what is recommended of them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search_module, "FRESH", 32)
        sought = sought_of(rivals())
        certain = most_certain(sought, SHARE)
    assert certain is not None
    return sought, certain


def every_hardware(problem: Problem, like: Found) -> list[Found]:
    """All combinations whose camera and lens fit."""
    parts, pairs, (low, high) = problem.parts, fitting_pairs(problem), problem.count_range
    rest = product(range(len(parts.ports)), range(len(parts.lights)), range(low, high + 1), enumerate(problem.mounts))
    return [
        replace(
            like, camera=camera, lens=lens, port=port, light=light, count=count, landscape=orientation == "landscape",
            lighting=Lighting(int(problem.lights.optics_index[light]), *mount),
        )
        for (port, light, count, mount), (camera, lens), orientation in product(
            rest, zip(pairs.camera.tolist(), pairs.lens.tolist(), strict=True), problem.mission.vehicle.orientations
        )
    ]  # fmt: skip


def by_brute_force(sought: Sought, scenarios: Scenarios, share: float) -> Counted | None:
    """The best of all hardware, each counted at every stop in every scenario."""
    every = every_hardware(sought.problem, sought.outcome.best[0])
    made = outcomes_of_each(sought.problem, every, sought.search.objective, scenarios, every_stop=True)
    return best_of([Counted(found, one_, one_.best(share)) for found, one_ in zip(every, made, strict=True)], share)


def test_what_is_proven_best_is_the_best_of_every_hardware() -> None:
    """The central optimum loses: its camera draws more than the other's 4 W in half of the scenarios."""
    sought, certain = known()
    assert certain.proven and certain.enough and certain.proof is not None
    proof = certain.proof
    assert proof.total == 2 * 2 * 1 * 2 * 2 == proof.by_panel + proof.by_bounds + proof.counted
    best = by_brute_force(sought, certain.scenarios, SHARE)
    assert best is not None and certain.best.quantile(0.5) == pytest.approx(best.quantile(0.5), rel=1e-9)
    first = sought.outcome.best[0]
    assert certain.best.found.camera != first.camera
    assert certain.best.quantile(0.5) < 0.995 * certain.tried[0].quantile(0.5)


def looked(sought: Sought, scenarios: Scenarios, tried: list[Counted]) -> Looked:
    """What was counted of a search in scenarios, of which the usual share is asked for."""
    return Looked(sought.problem, sought.goal, SHARE, scenarios, tried)


def test_the_best_is_found_from_the_worst_part_by_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """From the one that holds with the greatest median, though only the best that is seen is counted in each round.

    And from the one that holds least often; the best stays.
    """
    sought, certain = known()
    problem, objective, scenarios = sought.problem, sought.search.objective, certain.scenarios
    every = every_hardware(problem, sought.outcome.best[0])
    made = outcomes_of_each(problem, every, objective, scenarios, every_stop=True)
    all_counted = [Counted(found, one_, one_.best(SHARE)) for found, one_ in zip(every, made, strict=True)]
    best, seldom = (of(all_counted, key=lambda one: rank(one, SHARE)) for of in (min, max))
    dear = max((one_ for one_ in all_counted if one_.held >= SHARE), key=lambda one: one.quantile(0.5))
    assert seldom.held < SHARE and dear.quantile(0.5) > 1.02 * best.quantile(0.5)
    for first, counted_at_once in ((dear, 1), (seldom, 16), (best, 16)):
        monkeypatch.setattr(local_search_module, "A_ROUND", counted_at_once)
        seen = Looked(problem, objective, SHARE, scenarios, [first])
        assert polish(seen, NEVER)
        found, tried = seen.best, seen.tried
        assert found is not None and found.quantile(0.5) <= best.quantile(0.5) * (1.0 + 1e-3)
        assert len({names(problem, one.found) for one in tried}) == len(tried) < len(every)


def test_what_seemed_better_is_tried_together_where_it_fits() -> None:
    """Another lamp with the camera that is best by now, and more of the same; nothing on a camera that does not fit."""
    sought, _ = known()
    problem, base = sought.problem, sought.outcome.best[0]
    optics = problem.lights.optics_index
    lamp = replace(base, light=1 - base.light, lighting=replace(base.lighting, optics=int(optics[1 - base.light])))
    best, more = replace(base, camera=1 - base.camera), replace(base, count=3 - base.count)
    made = local_search_module.with_both(problem, base, best, [best, lamp, more])
    expected = [replace(lamp, camera=best.camera), replace(more, camera=best.camera)]
    assert [names(problem, one_) for one_ in made] == [names(problem, one_) for one_ in expected]
    assert [one_.lighting.optics for one_ in made] == [int(optics[one_.light]) for one_ in made]
    pairs = SimpleNamespace(camera=np.array([base.camera]), lens=np.array([base.lens]))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(local_search_module, "fitting_pairs", lambda problem: pairs)
        assert local_search_module.with_both(problem, base, best, [lamp]) == []


def test_what_is_as_good_as_tied_is_told_apart_by_further_scenarios(monkeypatch: pytest.MonkeyPatch) -> None:
    """Given the wrong way round, two come out by their medians in the scenarios that were not counted before."""
    sought, certain = known()
    holding = sorted((one_ for one_ in certain.tried if one_.held >= SHARE), key=lambda one_: one_.quantile(0.5))
    best, worst = holding[0], holding[-1]
    assert worst.quantile(0.5) > 1.02 * best.quantile(0.5)
    monkeypatch.setattr(search_module, "TIES", 64)
    seen = looked(sought, certain.scenarios, [worst, best])
    told = search_module.without_luck(seen, [worst, best], NEVER)
    assert [one_.found for one_ in told] == [best.found, worst.found]
    assert search_module.without_luck(seen, [best, worst], NEVER) == [best, worst]  # not tied


def test_of_what_further_scenarios_cannot_tell_apart_the_cheapest_is_bought(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same hardware with a lens that costs 100 USD less: it is priced as itself, not as what it was made from."""
    case_ = with_parts(
        one(wanted={"max_blur_px": 1.0, "min_snr_db": 25.0}, lens={"price": 400.0}), lenses=[{"price": 300.0}]
    )
    sought = sought_of(case_)
    problem, objective, dear = sought.problem, sought.search.objective, sought.outcome.best[0]
    dear = replace(dear, lens=0)
    pair = [dear, replace(dear, lens=1)]
    scenarios = search_module.scenarios_of(problem, 0.5, 0, 32)
    counted_ = [
        Counted(found, made, made.best(0.5))
        for found, made in zip(pair, outcomes_of_each(problem, pair, objective, scenarios), strict=True)
    ]
    assert counted_[0].outcomes.price - counted_[1].outcomes.price == pytest.approx(100.0)
    assert best_of(counted_, 0.5) is counted_[1]
    monkeypatch.setattr(search_module, "TIES", 32)
    seen = Looked(problem, objective, 0.5, scenarios, counted_)
    told = search_module.without_luck(seen, counted_, NEVER)
    assert told == counted_[::-1]


def test_what_further_scenarios_refute_comes_last_however_cheap(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of three tied by 256: by how often each holds anew, behind a fourth that is worse but holds."""

    def one_(price: float, held: float, median: float) -> Any:
        return SimpleNamespace(
            held=held, quantile=lambda share: median, outcomes=SimpleNamespace(price=price), settings=None
        )

    sought, certain = known()
    cheap, middle, dear, worse = one_(1.0, 0.9, 5.0), one_(2.0, 0.9, 5.0), one_(3.0, 0.9, 5.0), one_(1.0, 0.9, 6.0)
    ranked = [cheap, middle, dear, worse]
    seen = looked(sought, certain.scenarios, ranked)
    for anew, expected in (
        ({1.0: 0.2, 2.0: 0.5, 3.0: 0.7}, [worse, dear, middle, cheap]),
        ({1.0: 0.2, 2.0: 0.5, 3.0: 0.9}, [dear, worse, middle, cheap]),
        ({1.0: 0.9, 2.0: 0.9, 3.0: 0.9}, [cheap, middle, dear, worse]),
    ):
        monkeypatch.setattr(
            search_module, "counted_anew",
            lambda seen, some, deadline, anew=anew: [
                one_(one.outcomes.price, anew[one.outcomes.price], 5.0) for one in some
            ],
        )  # fmt: skip
        told = search_module.without_luck(seen, ranked, NEVER)
        assert [id(one) for one in told] == [id(one) for one in expected]
        assert seen.held_again == {id(one.outcomes): anew[one.outcomes.price] for one in (cheap, middle, dear)}


@pytest.mark.parametrize(("higher", "compared"), [(6.5, True), (4.8, False)])
def test_a_median_between_two_steps_of_light_is_compared_with_a_sure_one(
    higher: float, compared: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """4.7 W in half of the scenarios, 6.5 W in the other: a few more make it 6.5 W, where another takes 5.1 W."""

    def one_(price: float, low: float, high: float) -> Any:
        return SimpleNamespace(
            held=1.0, quantile=lambda share: low if share <= 0.5 else high, outcomes=SimpleNamespace(price=price),
            settings=None,
        )  # fmt: skip

    sought, certain = known()
    steps, sure = one_(1.0, 4.7, higher), one_(2.0, 5.1, 5.3)
    anew = {1.0: one_(1.0, 6.5, 6.5), 2.0: one_(2.0, 5.1, 5.3)}
    monkeypatch.setattr(
        search_module, "counted_anew", lambda seen, some, deadline: [anew[one.outcomes.price] for one in some]
    )
    told = search_module.without_luck(looked(sought, certain.scenarios, [steps, sure]), [steps, sure], NEVER)
    assert [id(one) for one in told] == [id(one) for one in ([sure, steps] if compared else [steps, sure])]


@pytest.mark.parametrize(("higher", "is_tied"), [(4.8, True), (6.5, False)])
def test_a_median_between_two_steps_of_light_is_not_tied_with_a_sure_one(
    higher: float, is_tied: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """4.7 W in half of the scenarios and 6.5 W in the other is not as good as 4.7 W and 4.8 W."""
    sought, certain = known()

    def one_(name: str, high: float) -> Any:
        return SimpleNamespace(found=name, held=1.0, quantile=lambda share: 4.7 if share <= 0.5 else high)

    monkeypatch.setattr(search_module, "names", lambda problem, found: found)
    best, other = one_("best", 4.8), one_("other", higher)
    choice = replace(certain, best=best, tried=[best, other])
    assert search_module.tied_with_best(sought.problem, choice, "other") == is_tied
    assert not search_module.tied_with_best(sought.problem, choice, "best")


def test_what_there_is_no_time_to_compare_stays_as_it_is_ranked() -> None:
    sought, certain = known()
    pair = [certain.best, certain.best]
    seen = looked(sought, certain.scenarios, pair)
    late = Deadline(0.0, lambda: 1.0)
    assert search_module.without_luck(seen, pair, late) is pair


def test_no_time_is_lost_on_a_panel_that_leaves_nearly_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the best known is far better in the panel, as here; not of few parts, nor without a limit of time."""
    sought, certain = known()
    seen = looked(sought, certain.scenarios, list(certain.tried))
    patient = Deadline.after(1e6)
    proof = Prover(seen, patient, unheard).run()
    assert proof is not None and not proof.left
    monkeypatch.setattr(proof_module, "FEW", 0)
    assert Prover(seen, patient, unheard).run() is None
    assert Prover(seen, NEVER, unheard).run() is not None


def test_a_glance_tells_what_is_better() -> None:
    """Of all hardware beside the one in the middle: what is counted to be better, the best first, and nothing else."""
    sought, certain = known()
    problem, objective, scenarios = sought.problem, sought.search.objective, certain.scenarios
    every = every_hardware(problem, sought.outcome.best[0])
    made = outcomes_of_each(problem, every, objective, scenarios)
    median = [one_.quantile(0.5)[one_.best(SHARE)] for one_ in made]
    order = np.argsort(median)
    middle = int(order[len(order) // 2])
    beside = Counted(every[middle], made[middle], made[middle].best(SHARE))
    glance = Glance.of(looked(sought, scenarios, []), beside)
    glance.look_at(every, NEVER)
    told = [names(problem, found) for found in glance.promising]
    better = [names(problem, every[k]) for k in order if median[k] < 0.99 * median[middle]]
    assert 4 <= len(better) == len(told) and set(told) == set(better)
    assert told[0] in better[:4]  # as many lamps, or two of which one is lit
    worst = [k for k in order if median[k] > 1.01 * median[middle]]
    assert len(worst) >= 4


def test_some_scenarios_are_those_of_all() -> None:
    """Their cameras, lamps and floors, by their places; ports and beams stand at central numbers."""
    sought, certain = known()
    whole, places, parts = certain.scenarios, np.array([3, 7, 40]), sought.problem.parts
    some = SomeScenarios.among(whole, places)
    assert some.count == 3 and [state.floor for state in some.states] == [whole.states[k].floor for k in places]
    assert some.each(parts.cameras[0]) == [whole.each(parts.cameras[0])[k] for k in places]
    lamps = whole.lights(parts.lights[0])
    assert [one_.flux_lm for one_ in some.lights(parts.lights[0])] == [lamps[k].flux_lm for k in places]
    assert all(port is parts.ports[0] for port in some.ports(parts.ports[0]))


def test_a_glance_sees_nearly_what_is_counted() -> None:
    """Its light is of few colours and coarse integrals, its ports and beams are central; the water is that of each."""
    sought, certain = known()
    best, places = certain.best, np.arange(0, certain.scenarios.count, 5)
    some = SomeScenarios.among(certain.scenarios, places)
    stops = None if best.f_number is None else [best.f_number]
    objective = sought.search.objective
    glance = outcomes_of_each(sought.problem, [best.found], objective, some, f_numbers=stops)[0].value[0]
    counted_there = best.outcomes.value[best.stop][places]
    both = np.isfinite(glance) & np.isfinite(counted_there)
    assert both.mean() > 0.8
    assert glance[both] == pytest.approx(counted_there[both], rel=0.02)


def test_a_proof_tells_what_it_takes_for_granted() -> None:
    """Of lamps in water that scatters: what is sent back, and the focus; strict is only what no bound discarded."""
    sought, certain = known()
    assert certain.proof is not None and certain.proof.by_bounds
    told = proof_told(sought.problem, sought.search.objective, certain.proof)
    assert sought.problem.effects.veils and any("sends back" in text for text in told.argued)
    assert any("focus" in text for text in told.argued)
    alone = replace(certain.proof, by_panel=0, by_bounds=0, counted=certain.proof.total)
    assert proof_told(sought.problem, sought.search.objective, alone).argued == []


def test_where_nothing_fits_no_worse_numbers_are_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    sought, certain = known()
    worse: list[float] = []

    def worse_problem(problem: Problem, scenarios: Scenarios, share: float) -> Problem:
        worse.append(share)
        return problem

    nothing = SimpleNamespace(whole=lambda: SimpleNamespace(best=[]), every_imager=None)
    monkeypatch.setattr(roomy_module, "Search", lambda *_, **__: nothing)
    monkeypatch.setattr(roomy_module, "worse_problem", worse_problem)
    never = dict(done=lambda: False, hopeful=lambda: False)
    seen = looked(sought, certain.scenarios, [])
    found = list(search_module.candidates(sought, seen, NEVER, **never))
    assert worse == [roomy_module.WORSE[0], *roomy_module.LESS_WORSE]
    assert [len(some) for some in found] == [min(len(sought.outcome.best), search_module.OF_CENTRAL)]


@pytest.mark.parametrize(
    ("min_snr_db", "worse", "roomy"), drawn([(28.0, 0.75, True)], [(28.0, 0.75, True), (31.0, 0.5, False)])
)
def test_what_goes_on_from_what_has_room_finds_and_counts_what_one_look_does(
    monkeypatch: pytest.MonkeyPatch, min_snr_db: float, worse: float, roomy: bool
) -> None:
    """Nothing is searched or counted twice; with room something fits, or only with less, and never enough holds."""
    case_ = rivals()
    wanted = {"max_blur_px": 1.0, "min_snr_db": min_snr_db}
    sought = sought_of(replace(case_, mission=case_.mission.with_changes(requirements=wanted)))
    runs: list[Any] = []

    class Counting(Search):
        def run(self) -> Any:
            runs.append(self.objective)
            return super().run()

    monkeypatch.setattr(roomy_module, "Search", Counting)

    def look(**how: Any) -> tuple[Looked, int]:
        before = len(runs)
        return search_module.look(sought, 1.01, NEVER, unheard, **how), len(runs) - before

    (whole, searches), (first, of_first) = look(), look(with_room=True)
    further, of_further = look(before=first)
    assert searches == of_first + of_further and (of_further > 0) != roomy
    assert whole.fits == further.fits and whole.fits[worse] and whole.tried
    assert first.fits == ({0.75: False} if not roomy else whole.fits)
    for ours, theirs in zip(further.tried, whole.tried, strict=True):
        assert names(sought.problem, ours.found) == names(sought.problem, theirs.found)
        np.testing.assert_array_equal(ours.outcomes.value, theirs.outcomes.value)


@pytest.mark.parametrize("min_snr_db", drawn([28.0], [28.0, 31.0]))
def test_what_is_searched_while_others_are_counted_is_what_is_searched_after_them(
    monkeypatch: pytest.MonkeyPatch, min_snr_db: float
) -> None:
    """Where nothing holds as often as asked all is needed; where all does, no search after the first is."""
    case_ = rivals()
    wanted = {"max_blur_px": 1.0, "min_snr_db": min_snr_db}
    sought = sought_of(replace(case_, mission=case_.mission.with_changes(requirements=wanted)))
    monkeypatch.setattr(search_module, "can_be_proven", lambda problem, objective: False)
    monkeypatch.setattr(roomy_module, "A_SEARCH", 1)
    for asked in (1.01, 0.01):
        made = []
        for count in (1, 2):
            before_s = effort_s()
            with cores(count):
                seen = search_module.look(sought, asked, NEVER, unheard)
            made.append((seen.fits, [names(sought.problem, one.found) for one in seen.tried], effort_s() - before_s))
        assert made[0][:2] == made[1][:2] and made[1][2] == pytest.approx(made[0][2], rel=0.2)
        assert (len(made[0][0]) > 1) == (asked > 1.0)


def test_what_fresh_scenarios_refute_is_not_certain_enough() -> None:
    """All of the scenarios of a choice flatter it: with 95 % confidence fresh ones tell less than was asked."""
    sought, certain = known()
    first, objective = certain.tried[0], sought.search.objective
    best = certain.best
    flattering = SimpleNamespace(held=1.0, outcomes=best.outcomes, settings=None, quantile=best.quantile)
    stops = [Counted(first.found, first.outcomes, k) for k in range(len(first.outcomes.f_numbers))]
    seen = min(stops, key=lambda one: one.held)
    assert wilson(seen.held, 48)[1] < 1.0
    for asked, enough in ((0.5 * (1.0 + wilson(seen.held, 48)[1]), False), (seen.held, True)):
        told = counted_confidence(sought.problem, objective, seen, asked=asked, share=asked, in_choice=flattering)  # type: ignore[arg-type]
        assert told.enough is enough


def test_no_bound_is_above_what_is_counted() -> None:
    """Of every hardware in every scenario, by groups of like water; and each is of some use."""
    sought, certain = known()
    problem, objective, scenarios = sought.problem, sought.search.objective, certain.scenarios
    every, anchors = every_hardware(problem, sought.outcome.best[0]), anchors_of(problem, scenarios)
    made = outcomes_of_each(problem, every, objective, scenarios, every_stop=True)
    assert sorted(np.concatenate([anchor.scenarios for anchor in anchors])) == list(range(48))
    tight = []
    for places in groups_of(every):
        group = Together.of(problem, [every[k] for k in places], scenarios)
        bounds = bounds_of(group, objective, anchors, NEVER, lambda value: np.ones(len(value), bool))
        for own, k in zip(bounds, places, strict=True):
            value = made[k].value.min(axis=0)
            held = np.isfinite(value)
            assert np.all(own[held] <= value[held] * (1.0 + INTERPOLATED))
            tight += (own[held] / value[held]).tolist()
    assert np.median(tight) > 0.75


@pytest.mark.parametrize("share, name", [(0.4, "other_table"), (0.0, "lamp_leg")])
def test_waters_that_share_a_bound_are_of_one_table_or_of_like_k(share: float, name: str) -> None:
    """Two groups in all, the worst first: each asks for light of its own in every image."""
    problem = one(scenes=({"water": "5C", "water_table": "measured"},)).problem()
    doubt = problem.mission.with_changes(doubt={"lamp_leg": True, "other_water_table": share}).doubt
    scenarios = Scenarios.drawn(problem.mission, problem.scenes, doubt, seed=2, count=24)
    first, last = (anchor.scenarios for anchor in anchors_of(problem, scenarios))
    ours, theirs = ([float(getattr(scenarios.states[k], name)) for k in places] for places in (first, last))
    assert max(ours) < min(theirs) or max(theirs) < min(ours)
    taken = [np.mean([loss(scenarios.scenes[k][0]) for k in places]) for places in (first, last)]
    assert taken[0] > taken[1]


def test_a_panel_is_no_harder_than_as_many_scenarios_as_it_says() -> None:
    """Of every hardware, the objective in the panel against that in all scenarios."""
    sought, certain = known()
    problem, objective, scenarios = sought.problem, sought.search.objective, certain.scenarios
    covered = least_covered(scenarios.count, 0.5)
    assert covered == 25 and least_covered(48, 0.9) == 5 and least_covered(10, 1.0) == 1
    panel = panel_of(problem, scenarios, objective, covered)
    assert panel.covered >= covered
    every = every_hardware(problem, sought.outcome.best[0])
    made = outcomes_of_each(problem, every, objective, scenarios, every_stop=True)
    for found, one_ in zip(every, made, strict=True):
        alone = panel.problem.with_count(found.count)
        ours = [
            each.minimised for each in case_values(alone, objective)
            if (each.camera, each.lens, each.light) == (found.camera, found.lens, found.light)
        ]  # fmt: skip
        value = one_.value.min(axis=0)
        no_better = int((value >= min(ours, default=np.inf) * (1.0 - INTERPOLATED)).sum())
        assert no_better >= covered


def case_values(problem: Problem, objective: Any) -> list[Found]:
    """Every hardware that fits, by a search."""
    return Search(problem, objective, top=1000).run().best


def test_the_best_of_waters_is_no_worse_than_each_in_any_leg() -> None:
    """Attenuation of each leg, what forward scattering adds, scattering and floor."""
    _, certain = known()
    scenes = [scenes[0] for scenes in certain.scenarios.scenes]
    best = best_scene(scenes)
    for one_ in scenes:
        beyond, least = (s.attenuation_per_m - s.lamp_attenuation_per_m for s in (one_, best))
        assert np.all(best.lamp_attenuation_per_m <= one_.lamp_attenuation_per_m) and np.all(least <= beyond + 1e-15)
        assert np.all(best.reflectance >= one_.reflectance)
        assert best.range_m[0] >= one_.range_m[0] and best.range_m[-1] <= one_.range_m[-1]


@pytest.mark.parametrize("lobe_rad", [0.2, 0.7, 1.2])
def test_the_best_of_waters_is_no_worse_where_light_is_scattered_more_than_once(lobe_rad: float) -> None:
    """K of the lamps' way, and veils beside the signal by either leg; K alone is no bound of them, as b differs too."""
    _, certain = known()
    scenes = [scenes[0] for scenes in certain.scenarios.scenes]
    best = best_scene(scenes)
    assert best.counts_orders

    def beside(scene: Any) -> list[Any]:
        c, lamp, back = scene.attenuation_per_m, scene.lamp_leg_per_m(lobe_rad), scene.back_leg_per_m(lobe_rad)
        wide = scene.near_leg_per_m() - scene.veil_leg_per_m(2.0)
        return [c, lamp, c - scene.near_leg_per_m(), wide, c - back, lamp - back]

    for one_ in scenes:
        assert all(np.all(ours <= own + 1e-12) for ours, own in zip(beside(best), beside(one_), strict=True))


def test_detail_in_the_veil_is_each_scenarios_own_and_no_bound_shows_less() -> None:
    """Bars and information in water whose particles scatter more or less than thought."""
    made_case = one(
        "information", scenes=({"visibility_m": 8.0, "water": None},), vehicle={"altitude_tolerance_m": 0.1},
        wanted={"resolve_mm": 20.0, "min_swath_m": 0.1, "min_snr_db": 20.0},
    )  # fmt: skip
    sought = sought_of(made_case)
    problem, objective = sought.problem, sought.search.objective
    central = problem.scenes[0]
    scenarios = Scenarios.drawn(problem.mission, problem.scenes, problem.mission.doubt, seed=1, count=24)
    group = Together.of(problem, [sought.outcome.best[0]], scenarios)
    (rows,) = group.rows(objective, NEVER)
    assert rows.sharp is not None and rows.sharp.detail is not None
    every = [scenarios.scenes[int(k)][0].particles_per_m() for k in group.scenario]
    own = np.array([np.interp(550.0, central.wavelength_nm, one_) for one_ in every])
    found = rows.sharp.detail.scattered[:, 1]
    shown = np.interp(550.0, central.wavelength_nm, central.particles_per_m())
    assert found / own == pytest.approx(found.mean() / own.mean())  # as much more as of green light
    assert found / own == pytest.approx(2.0, rel=0.15)  # 2 m; other colours than green arrive, too
    assert own.min() < 0.95 * shown and own.max() > 1.05 * shown
    easiest = best_scene([scenes[0] for scenes in scenarios.scenes])
    (bounded,) = group._lit(group.problem.in_scenes([easiest]), objective, NEVER)
    assert bounded.sharp is not None and bounded.sharp.detail is not None
    nu = np.full((len(own), 3), 0.2)
    assert np.all(bounded.sharp.detail.gain(nu) >= rows.sharp.detail.gain(nu))
    assert np.all(bounded.sharp.texture_gain >= rows.sharp.texture_gain)


def in_doubt(part: Any, rng: np.random.Generator) -> Any:
    """A part of whose numbers most are estimates."""
    changes = {}
    for field in fields(part):
        value = getattr(part, field.name)
        doubted = isinstance(value, Quantity) and field.name in FAVOURED and field.name != "f_number_min"
        if doubted and rng.random() < 0.6:
            most = min(1.8 * value.value, 1.0) if field.name.endswith(("_frac", "_factor")) else 1.8 * value.value
            low, high = value.value * rng.uniform(0.5, 1.0), rng.uniform(value.value, max(most, value.value))
            changes[field.name] = between(low, value.value, high)
    return replace(part, **changes)


@pytest.mark.parametrize("seed", RANDOM)
def test_of_random_catalogues_too(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search_module, "FRESH", 32)
    case_, rng = case(seed), np.random.default_rng(seed + 999)
    kinds = (case_.parts.cameras, case_.parts.lenses, case_.parts.ports, case_.parts.lights)
    parts = Parts(*(tuple(in_doubt(part, rng) for part in some) for some in kinds))
    sought = sought_of(replace(case_, parts=parts))
    if not sought.outcome.best or not can_be_proven(sought.problem, sought.search.objective):
        pytest.skip("nothing fits, or nothing is proven of it")
    certain = most_certain(sought, SHARE)
    if certain is None or not certain.proven:
        pytest.skip("not proven")
    best = by_brute_force(sought, certain.scenarios, SHARE)
    assert best is not None and (best.held >= SHARE) == certain.enough
    if certain.enough:
        assert certain.best.quantile(0.5) == pytest.approx(best.quantile(0.5), rel=0.005)


@pytest.mark.parametrize(("held", "hopeless"), [(0.57, True), (0.4, False)])
def test_a_panel_of_the_easiest_scenarios_is_not_searched_where_much_fits_into_it(held: float, hopeless: bool) -> None:
    """Nothing holds in nine of ten: what holds in more than half tells that too much is left to count."""
    value = np.where(np.arange(100) < round(100 * held), 5.0, np.inf)[None, :]
    anything: Any = None
    surest = Counted(anything, Outcomes(np.array([2.0]), value, {}), 0)
    prover = Prover(Looked(anything, anything, 0.9, anything, [surest]), NEVER, unheard)
    assert prover._is_hopeless(anything, np.inf) is hopeless

"""Many missions one after another: each has the optimum that a search of its own finds, at a fraction of its work."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from thorough import drawn

from uwopt.api.searching import Searches
from uwopt.deadline import NEVER
from uwopt.errors import SolverError
from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.strictness import Asking, sign_of
from uwopt.mission.varying import VariedMission
from uwopt.objectives.goal import goal_of
from uwopt.solvers.exact.search import Search
from uwopt.solvers.recommend import with_fewest_lamps
from uwopt.solvers.warm import kept as kept_bounds
from uwopt.solvers.warm import searches
from uwopt.solvers.warm.kept import KeptBounds, sizes
from uwopt.solvers.warm.searches import Warm, WarmAnswer, weakest_first

PROBLEMS = Path(__file__).parents[2] / "problems"
#: Few parts of the reef's mission among which winners change with speed, water and budget; lamps to be made too.
FEW: dict[str, Any] = {
    "cameras": ["avt-alvium-1800-c-040m", "avt-alvium-1800-c-234m", "basler-daa1280-54um", "flir-bfly-u3-23s6m"],
    "lenses": ["computar-m1214-mp2", "thorlabs-mvl16m1", "fujinon-hf9ha-1b"],
    "ports": ["blue-robotics-4-in-acrylic-end-cap-2026", "blue-robotics-4-in-dome-plastic-ring-2026"],
    "lights": ["arctic-rays-dragonfish-mini-strobe-65deg*", "generic-flash-200j"],
    "generic": "never",
}


def reef(**changes: Any) -> Mission:
    """The reef with few parts, and no tolerance of altitude: one altitude instead of five."""
    base = load_mission(PROBLEMS / "reef-mosaic.yaml")
    vehicle = base.to_dict()["vehicle"] | {"altitude_tolerance_m": 0.0}
    catalog = base.to_dict()["catalog"] | FEW | changes.pop("catalog", {})
    return base.with_changes(**{"catalog": catalog, "vehicle": vehicle} | changes)


def varied(base: Mission, **values: Any) -> Mission:
    """A mission with other values of its keys."""
    made = VariedMission(base, {})
    keys = {made.varied(key.replace("__", "."), [value, "another"]): value for key, value in values.items()}
    return made.with_values(keys)


def told(answer: WarmAnswer, mission: Mission) -> tuple[Any, ...]:
    """What an answer says: the objective, the parts, whether some are to be made."""
    if answer.found is None or answer.sought is None:
        return None, None, False
    found, of = answer.found, answer.sought.problem.parts
    parts = of.cameras[found.camera], of.lenses[found.lens], of.ports[found.port], of.lights[found.light]
    ids, generic = tuple(part.id for part in parts), any(part.generic for part in parts)
    return goal_of(mission).reported(found.minimised), (*ids, found.count), generic


def alone(mission: Mission) -> tuple[Any, ...]:
    """The same by a search that knows nothing of others."""
    sought = Searches(load_catalog(mission), goal_of(mission), 1).of(mission).sought
    found = with_fewest_lamps(sought).outcome.best[0] if sought.outcome.best else None
    return told(WarmAnswer(sought, found, True, 0.0, False, True, False), mission)


def agree(warm: Warm, mission: Mission, *, ahead: bool = True) -> tuple[Any, ...]:
    """Fail where an answer is another than that of a search of its own, which is returned."""
    (value, *system), (truth, *best) = told(warm.best(mission, ahead=ahead), mission), alone(mission)
    assert value == (None if truth is None else pytest.approx(truth, rel=1e-6))  # a search's claim agrees so nearly
    assert system == best
    return truth, *best


@pytest.fixture
def small_sizes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sizes as shipped are larger than a small catalogue; these make every way of using bounds count."""
    for module, name, value in (
        (searches, "FIRST", 1), (searches, "WORTH_BOUNDING", 0), (searches, "MANY", 0), (kept_bounds, "MOST_BOUNDS", 2),
        (kept_bounds, "LEAST_GUESS", 0.0), (kept_bounds, "MOST_GUESS", 0.0),
    ):  # fmt: skip
        monkeypatch.setattr(module, name, value)


@pytest.mark.usefixtures("small_sizes")
@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("speed_m_s", (0.3, 0.6, 1.05, 1.3, 2.5)), ("min_snr_db", (24, 31, 40)), ("cost", (9000, 7600, 7210, 5000)),
        ("max_blur_px", (1, 0.2, 0.05)), ("overlap", (0.1, 0.8, 0.97)), ("depth_rating_m", (30, 150, 400)),
        ("max_gsd_mm", (1.5, 0.8, 0.5)), ("reserve__snr_db", (0, 2, 9)), ("power_w", (9, 2.7, 2)),
        ("max_exposure_ms", (5, 0.2, 0.05)),
    ],
)  # fmt: skip
def test_each_step_has_the_optimum_of_its_own_search(key, values):
    warm, base = Warm(), reef()
    for value in values:
        agree(warm, varied(base, **{key: value}))


#: Speeds, least SNR and budgets in orders in which bounds that are used where they do not hold hide a winner.
ORDERS = (
    ((0.5, 33.0, 7300), (1.1, 29.0, 7300), (0.8, 24.0, 9000), (1.4, 33.0, 9000), (0.8, 31.0, 9000)),
    ((0.5, 24.0, 8000), (1.4, 33.0, 8000), (1.1, 33.0, 7300), (1.4, 29.0, 7300), (0.8, 33.0, 9000)),
    ((0.3, 27.0, 9000), (0.5, 33.0, 9000), (0.5, 24.0, 9000), (0.8, 24.0, 9000), (0.3, 24.0, 8000)),
)  # fmt: skip


@pytest.mark.usefixtures("small_sizes")
@pytest.mark.parametrize("order", range(drawn(3, 40)))
def test_missions_in_any_order_have_the_optima_of_their_own_searches(order):
    lamps = ["arctic-rays-dragonfish-mini-strobe*", "generic-flash-200j"]
    warm, base, rng = Warm(), reef(catalog={"ports": ["blue-robotics-4*"], "lights": lamps}), random.Random(order)
    drawn_points = [(rng.uniform(0.2, 2.0), rng.uniform(20.0, 35.0), rng.uniform(7e3, 9e3)) for _ in range(8)]
    for speed, snr, cost in ORDERS[order] if order < len(ORDERS) else drawn_points:
        agree(warm, varied(base, speed_m_s=speed, min_snr_db=snr, cost=cost))
    agree(warm, varied(base, speed_m_s=0.8, min_snr_db=24.0, altitude_m=1.8))


@pytest.mark.usefixtures("small_sizes")
def test_parts_to_be_made_are_taken_where_none_on_sale_fits_any_more():
    ports = [FEW["ports"][1], "generic-dome-acrylic-100mm"]
    parts = {"lenses": [*FEW["lenses"], "raspberry-pi-16-mm-tele*"], "ports": ports, "generic": "fallback"}
    # single scattering: the lamps' light then ends between these speeds
    scenes = [scene | {"multiple_scattering": False} for scene in reef().to_dict()["scenes"]]
    warm, base, seen = Warm(), reef(catalog=parts, scenes=scenes), list[Any]()
    for speed in (0.7, 0.8, 1.3):
        mission = varied(base, speed_m_s=speed, water="1C")
        seen.append(agree(warm, mission)[1:])
    assert [generic for _, generic in seen] == [False, True, False]
    assert seen[-1][0] is None


def test_where_no_imager_passes_there_are_no_bounds_though_fine_detail_is_asked_for():
    mission = varied(reef(), max_gsd_mm=1e-3, min_mtf_half_nyquist=0.2)
    problem = build_problem(mission, selected(mission, load_catalog(mission), generic="never"))
    search = Search(problem, goal_of(mission), top=1)
    search.prepare()
    assert len(search.imagers) == 0
    assert kept_bounds.least_of_nodes(search, NEVER).shape[1:] == (0,)


def test_bounds_serve_no_mission_that_asks_for_less():
    warm = Warm()
    assert warm.best(varied(reef(), speed_m_s=30.0)).found is None
    assert warm.best(varied(reef(), speed_m_s=0.5)).found is not None


def test_bounds_made_anew_stand_in_for_those_of_their_nodes_alone():
    """Node 1 fits no more, node 2 is bounded higher, node 3 keeps its bound, node 9 never fitted; by hand."""
    none: Any = None
    known = KeptBounds(none, none, np.array([1, 2, 3]), np.array([1.0, 2.0, 5.0]))
    made = KeptBounds(none, none, np.array([9, 2]), np.array([1.0, 4.0]))
    both = known.with_some(np.array([1, 2]), made)
    assert (both.node.tolist(), both.least.tolist()) == ([2, 3], [4.0, 5.0])
    assert both.within(4.5).tolist() == [2]
    assert both.within(5.0, beyond=4.0).tolist() == [3]
    lower = KeptBounds(none, none, np.array([2]), np.array([0.5]))
    assert known.with_some(np.array([2]), lower).least.tolist() == [1.0, 2.0, 5.0]  # no bound gets lower


@pytest.mark.parametrize("objective", drawn(["cost", "snr_db"], ["cost", "snr_db", "mass", "best_image"]))
def test_other_objectives_are_no_better_either_where_more_is_asked(objective):
    warm, base = Warm(), reef(objective=objective, catalog={"lenses": FEW["lenses"][:1]})
    for speed in (0.4, 1.2):
        agree(warm, varied(base, speed_m_s=speed))


def test_many_missions_look_at_a_fifth_of_the_imagers(monkeypatch):
    """Counted, not timed."""
    looked_at = [0]
    honest = Search.run

    def counted(search: Search) -> Any:
        outcome = honest(search)
        looked_at[0] += len(outcome.imagers)
        return outcome

    monkeypatch.setattr(Search, "run", counted)
    base = load_mission(PROBLEMS / "reef-mosaic.yaml")
    base = base.with_changes(catalog=base.to_dict()["catalog"] | {"cameras": ["basler"], "generic": "never"})
    speeds, ratios = drawn(((0.4, 0.5, 0.6), (28.0, 28.5, 29.0)), ((0.4, 0.5, 0.6, 0.8, 1.0), (24.0, 27.0, 29.0, 30.0)))
    missions = [varied(base, speed_m_s=speed, min_snr_db=snr) for speed in speeds for snr in ratios]
    warm, order = Warm(), weakest_first(missions)
    assert warm.best(missions[order[0]]).found is not None
    by_first = looked_at[0]
    for place in order[1:]:
        assert warm.best(missions[place]).found is not None
    assert looked_at[0] - by_first <= drawn(0.01, 0.05) * (len(missions) - 1) * by_first
    assert looked_at[0] <= 0.2 * len(missions) * by_first


def test_other_light_has_the_imagers_of_the_last(monkeypatch):
    """Water and floor change no view; its temperature does, by the index of refraction, and so do all other keys."""
    listed, honest = list[Any](), searches.enumerate_imagers

    def counted(problem: Any) -> Any:
        listed.append(honest(problem))
        return listed[-1]

    monkeypatch.setattr(searches, "enumerate_imagers", counted)
    warm, base = Warm(), reef()
    for n_listed, mission in (
        (1, base), (1, varied(base, water="II")), (1, varied(base, water="1C", seafloor=0.3)),
        (2, varied(base, temperature_c=30.0)), (3, varied(base, altitude_m=1.9)),
    ):  # fmt: skip
        agree(warm, mission)
        assert len(listed) == n_listed


def test_searches_by_bounds_have_the_tables_of_the_first(monkeypatch):
    """Light that one has worked out serves the next, however few of the imagers it looks at."""
    reaches, honest = list[Any](), Search.run

    def told_reach(search: Search) -> Any:
        outcome = honest(search)
        if search.given is not None and len(search.problem.parts.cameras) > 1:  # else of one system with fewer lamps
            reaches.append(search.tables.problem.contractions[0].reach_m)
        return outcome

    monkeypatch.setattr(Search, "run", told_reach)
    warm, base = Warm(), reef(catalog={"lenses": [*FEW["lenses"], "hikrobot-mvl-hf4028m-6mpe"]})
    for speed in (0.3, 0.6, 0.8):
        warm.best(varied(base, speed_m_s=speed))
    assert len(reaches) >= 3
    assert len(set(reaches)) == 1


# ---------------------------------------------------------------- what is compared


def test_what_asks_for_least_comes_first():
    base = reef()
    missions = [varied(base, speed_m_s=speed, cost=cost) for speed, cost in ((1.0, 7000), (0.5, 8000), (1.0, 9000))]
    assert [weakest_first(missions)[0], sorted(weakest_first(missions))] == [1, [0, 1, 2]]
    asks = [Asking.of(mission) for mission in missions]
    assert asks[1].asks_no_more(asks[0])
    assert not asks[1].asks_no_more(asks[2])  # slower, but for less money
    assert asks[2].asks_no_more(asks[0])


def test_other_water_height_or_objective_is_not_compared():
    base = reef()
    weak = Asking.of(base)
    for other in (varied(base, water="IB"), varied(base, altitude_m=1.9), base.with_changes(objective="cost")):
        assert not weak.asks_no_more(Asking.of(other))
    assert weak.asks_no_more(Asking.of(base.with_changes(name="another")))


def test_scenes_are_compared_each():
    base = reef()
    scene = base.to_dict()["scenes"][0]
    two = base.with_changes(scenes=[scene | {"name": "a"}, scene | {"name": "b", "vehicle": {"speed_m_s": 0.4}}])
    quicker = base.with_changes(scenes=[scene | {"name": "a"}, scene | {"name": "b", "vehicle": {"speed_m_s": 0.6}}])
    assert Asking.of(two).asks_no_more(Asking.of(quicker))
    assert not Asking.of(quicker).asks_no_more(Asking.of(two))


def test_sizes_of_housings_are_not_compared_where_one_stands_for_others():
    """The cheapest housing that fits stands for all; it may be the largest, or rated least."""
    bare, housed = reef(), reef(catalog={"housing": "required"})
    for section, name in (("limits", "size_mm"), ("limits", "diameter_mm"), ("limits", "depth_rating_m")):
        assert sign_of(bare, section, name) != 0
        assert sign_of(housed, section, name) == 0


def hidden(parts: Any) -> Any:
    """`KeptBounds.of` that leaves out the nodes of one camera, as wrong bounds would."""
    made = KeptBounds.of

    def wrong(search: Search, *more: Any) -> KeptBounds:
        kept = made(search, *more)
        camera = np.unravel_index(kept.node // len(search.problem.optics), sizes(search.problem))[0]
        known = np.array([part.id in parts["camera"] for part in search.problem.parts.cameras])
        return replace(kept, node=kept.node[~known[camera]], least=kept.least[~known[camera]])

    return staticmethod(wrong)


@pytest.mark.parametrize("shown_by", ["a few parts", "a search of its own"])
def test_a_wrong_warm_start_is_caught(monkeypatch, shown_by):
    """Bounds hide the best camera at 0.8 m/s: what is proven there is refuted by that camera, there or at 0.81 m/s."""
    missions = [varied(reef(), speed_m_s=speed) for speed in (0.3, 0.8, 0.81)]
    at_best = Warm()
    at_best.best(missions[2])
    winner = at_best.winners[0]
    warm = Warm()
    monkeypatch.setattr(KeptBounds, "of", hidden(winner))
    warm.best(missions[0])
    worse = warm.best(missions[1])
    assert worse.kept and worse.found is not None  # proven, it says
    with pytest.raises(SolverError, match="defect of uwopt"):
        if shown_by == "a few parts":
            warm.among(missions[1], winner)
        else:
            monkeypatch.setattr(warm, "_warm", lambda *more: None)
            warm.best(missions[2])


def test_a_wrong_proof_is_caught_by_what_was_shown_before(monkeypatch):
    """The same camera was seen at 0.81 m/s first; then nothing as good is proven at 0.8."""
    missions = [varied(reef(), speed_m_s=speed) for speed in (0.3, 0.8, 0.81)]
    at_best = Warm()
    at_best.best(missions[2])
    winner, warm = at_best.winners[0], Warm()
    monkeypatch.setattr(KeptBounds, "of", hidden(winner))
    warm.best(missions[0])
    warm.among(missions[2], winner)
    with pytest.raises(SolverError, match="defect of uwopt"):
        warm.best(missions[1])


def test_a_ceiling_that_is_too_low_hides_nothing(monkeypatch):
    """What the last winners are thought to reach in other water is only where to begin."""
    warm, murky = Warm(), varied(reef(), speed_m_s=0.5, water="IB")
    warm.best(varied(reef(), speed_m_s=0.5))
    monkeypatch.setattr(warm, "_reached", lambda stage: 0.5)
    agree(warm, murky)


def test_who_ends_one_search_ends_the_row(monkeypatch):
    honest = Search.run
    monkeypatch.setattr(Search, "run", lambda search: replace(honest(search), interrupted=True, complete=False))
    for search in (Warm().best, lambda mission: Warm().among(mission, {})):
        with pytest.raises(KeyboardInterrupt):
            search(reef())

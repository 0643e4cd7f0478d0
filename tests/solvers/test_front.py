"""The exact front attacked: no design that anybody tries may be beyond its bound, and its points must hold.

Tried designs come from `front_cases.py`: settings over all that data sheets allow, through the forward model alone.
UWOPT_THOROUGH=1 tries more seeds, and information as finely as it is shipped.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import front_cases as fc
import numpy as np
import pytest
import random_cases as rc
import small_catalogues as small
from thorough import drawn

from uwopt.catalog.records import exact
from uwopt.deadline import Deadline
from uwopt.forward.parts import Parts
from uwopt.objectives.axes import Axes, Frame
from uwopt.objectives.dominance import hypervolume, nondominated
from uwopt.objectives.objective import Objective
from uwopt.solvers.front import search as front_module
from uwopt.solvers.front.points import largest_left, quality_of
from uwopt.solvers.front.trade_curves import Trade
from uwopt.solvers.population.pymoo_front import population_front

#: One scene and two, steps, flashes, mean levels, and physics paper; all have designs.
SEEDS = tuple(range(60)) if rc.THOROUGH else (3, 7, 24)
CLOSED = (
    ("power", "cost", "snr_db"), ("power", "snr_db"), ("cost", "snr_db"), ("power", "cost"),
    ("power", "mass", "gsd_mm"), ("cost", "gsd_mm", "snr_db"), ("power", "contrast", "cost"),
)  # fmt: skip
SUNNY = ("sun", "steps in the sun", "sun at a level", "bars in the sun")
#: What takes longest, and what others show beside something else: lamps that are on, flashes, pulses, a lamp that dims.
DEAR = ("dark", "dark at a level", "sun", "sun at a level", "on", "flash", "pulses", "dims", "nothing asked")
SHADED = tuple(name for name in fc.PLANTED if name not in SUNNY)
INFORMATION = ("steps", "flash", "counts and mounts", "still")
CASES = [
    *((seed, CLOSED[0]) for seed in SEEDS),
    *((seed, n) for i, n in enumerate(CLOSED) for seed in (SEEDS if rc.THOROUGH else (SEEDS[i % 3],))),
    *((name, names) for name in SHADED for names in (CLOSED if rc.THOROUGH else CLOSED[:1] * (name not in DEAR))),
    ("steps", CLOSED[1]), ("nothing asked", CLOSED[2]),
    *((name, ("power", "snr_db")) for name in SUNNY if rc.THOROUGH or name not in DEAR),
    (22, ("power", "cost")), ("sun", ("power", "cost", "contrast")),
]  # fmt: skip
CASES = list(dict.fromkeys(CASES))
TRIPLE = CLOSED[0]
LOOKED_AT = drawn(3, 6)  # points of a front, evaluated again
TABLES = 1e-6  # water's loss tables of one design reach less far than those of a search: each is good to so much
POINT_GAP = 1e-3  # of a front's range: what a point may lack in every objective at once


@cache
def front_of_information(key, names):
    """A front of tests that are `coarse`, searched once."""
    return fc.searched(fc.case_of(key), names)


@pytest.fixture
def coarse(monkeypatch):
    """Segments of information as large as a quick test bears; the bound must hold all the same."""
    if not rc.THOROUGH:
        monkeypatch.setattr(front_module, "FRONT_GAP", 2e-2)
        monkeypatch.setattr(front_module, "ROUGH_SEGMENT", 5e-2)


def not_beaten(front, tried, point_gap=POINT_GAP):
    """No tried design is beyond the bound, nor better than a point in all objectives by more than a gap."""
    assert front.complete
    if len(tried) == 0:
        return
    assert len(front.values), f"{len(tried)} designs are feasible, none was found"
    both = hypervolume(np.concatenate([front.values, tried]), front.frame)
    assert both <= front.hypervolume_bound * (1 + TABLES)
    assert front.hypervolume <= front.hypervolume_bound
    span = np.ptp(front.values, axis=0)
    span = np.where(span > 0, span, np.abs(front.values[0]) + 1e-12)
    for point in tried[nondominated(tried)]:
        assert ((front.values - point) / span).min(axis=1).max() <= point_gap, f"{point} beats a point"


def holds(search, front, most=LOOKED_AT):
    """None dominated, none twice; some looked at again by `evaluate_design`."""
    assert nondominated(front.values).all()
    for place in (
        np.unique(np.linspace(0, len(front.values) - 1, most).astype(int)) if len(front.values) else ()
    ):
        values, missed = fc.evaluated_values(search, front, place)
        assert not missed
        # veils are integrated for many images and for one on grids that differ by up to 1e-4
        veiled = [name in ("contrast", "snr_db", "information") for name in front.axes.names]
        assert np.allclose(front.values[place], values, atol=1e-9, rtol=np.where(veiled, 1e-5, 1e-6))


def adds_up(search, front):
    """Every combination is counted once."""
    assert sum(front.account.values()) == fc.combinations(search.problem)
    assert all(count >= 0 for count in front.account.values())


# ---------------------------------------------------------------- against everything that is tried


@pytest.mark.parametrize(("key", "names"), CASES)
def test_no_tried_design_beats_the_front_and_its_points_hold(key, names):
    search, front = fc.front_of(key, names)  # together: under xdist two tests would search twice
    not_beaten(front, fc.tried_of(key, names))
    holds(search, front, drawn(2, 6))
    adds_up(search, front)


@pytest.mark.usefixtures("coarse")
@pytest.mark.parametrize("key", INFORMATION if not rc.THOROUGH else SHADED)
@pytest.mark.parametrize("names", [("power", "information"), ("power", "cost", "information")])
def test_front_of_information_is_not_beaten_and_holds(key, names):
    if names[1] == "cost" and key != "counts and mounts" and not rc.THOROUGH:
        pytest.skip("one light: the same front")
    search, front = front_of_information(key, names)
    not_beaten(front, fc.tried_of(key, names), POINT_GAP if rc.THOROUGH else 5e-2)
    holds(search, front)
    adds_up(search, front)


def test_lamps_alike_but_for_their_price_are_asked_once_and_the_cheapest_stands_for_all():
    """Whichever comes first in the list; a dearer lamp that gives a little more has a curve of its own."""
    given = dict(kind="continuous", flux_lm=20_000.0, power_w=200.0, min_dim_frac=0.0)
    plain, dear, cheap = (rc.lamp(f"at {p:g}", **given, price=exact(p)) for p in (500.0, 900.0, 300.0))
    brighter = rc.lamp("brighter", **{**given, "flux_lm": 20_400.0}, price=exact(600.0))
    names = ("power", "cost", "snr_db")
    few = fc.searched(rc.planted("power", (cheap, brighter), fc.WANTED), names)[1]
    search, front = fc.searched(rc.planted("power", (plain, dear, cheap, brighter), fc.WANTED), names)
    assert front.account["evaluated"] == few.account["evaluated"] == 2
    assert front.hypervolume == pytest.approx(few.hypervolume, rel=1e-9)
    assert np.unique(front.values[:, 1]) == pytest.approx(np.unique(few.values[:, 1]))
    adds_up(search, front)


@pytest.mark.parametrize("key", [3, 24])
def test_a_front_is_asked_until_its_gap_is_closed_and_hardly_further(key):
    _, front = fc.front_of(key, TRIPLE)
    gap = 1.0 - front.hypervolume / front.hypervolume_bound
    assert 0.3 * front_module.FRONT_GAP <= gap <= front_module.FRONT_GAP


def test_segments_are_asked_a_few_at_a_time_and_no_more_once_the_gap_is_closed(monkeypatch):
    monkeypatch.setattr(front_module, "FEWEST_ASKED", 8)
    _, front = fc.searched(rc.case(3), ("power", "cost", "snr_db"))
    gap = 1.0 - front.hypervolume / front.hypervolume_bound
    assert 0.9 * front_module.FRONT_GAP <= gap <= front_module.FRONT_GAP


@pytest.mark.parametrize("share", [0.02, 0.3, 0.9])
def test_segments_that_are_cut_to_a_size_leave_the_share_that_was_asked_for(share):
    """A segment k times as large as may be left is cut in as many pieces as the root of k says, rounded up."""
    spans = np.random.default_rng(5).lognormal(0.0, 3.0, 400)
    largest = largest_left(spans, share)
    left = spans / np.maximum(np.ceil(np.sqrt(spans / largest)), 1.0)
    assert left.sum() <= share * spans.sum()
    assert np.minimum(spans, np.sqrt(spans * largest)).sum() == pytest.approx(share * spans.sum())


def test_front_is_empty_and_complete_where_nothing_is_feasible():
    search, front = fc.front_of("impossible", TRIPLE)
    assert len(fc.tried_of("impossible", TRIPLE)) == 0
    assert (len(front.values), front.complete, front.frame) == (0, True, None)
    assert front.hypervolume == front.hypervolume_bound == 0.0
    adds_up(search, front)


def test_one_lamp_that_cannot_be_set_makes_a_front_of_one_point():
    _, front = fc.front_of("on", ("power", "cost"))
    assert len(front.values) == 1
    assert front.hypervolume == front.hypervolume_bound == pytest.approx(1.0)


def test_each_step_of_a_lamp_is_on_the_front_with_its_best_quality():
    # four steps of 200 W that burn all the time, beside the camera's 2 W; fewer where a step is too dark or bright
    _, front = fc.front_of("steps", ("power", "snr_db"))
    drawn = np.sort(front.values[:, 0]) - 2.0
    assert set(np.round(drawn / 200.0, 9)) <= {0.1, 0.25, 0.5, 1.0}
    assert len(set(np.round(drawn, 6))) == len(drawn)


def test_every_step_that_helps_is_on_the_front_under_the_sun():
    _, front = fc.front_of("steps in the sun", ("power", "snr_db"))
    assert np.sort(front.values[:, 0]) - 2.0 == pytest.approx([20.0, 50.0, 100.0, 200.0])


@pytest.mark.parametrize("key", drawn(["steps in the sun"], ["sun", "steps in the sun"]))
def test_sun_and_information_have_points_that_hold(key, monkeypatch):
    monkeypatch.setattr(front_module, "FRONT_GAP", 0.2)
    monkeypatch.setattr(front_module, "ROUGH_SEGMENT", 0.3)
    names = ("power", "information")
    search, front = fc.searched(fc.case_of(key), names)
    assert len(front.values) > 0
    not_beaten(front, fc.tried_of(key, names), 0.5)
    holds(search, front)
    adds_up(search, front)


# ---------------------------------------------------------------- ends


@pytest.mark.parametrize(
    "key",
    drawn([fc.SEVERAL, "counts and mounts"], [3, fc.SEVERAL, 24, "all", "dark", "sharp", "counts and mounts"]),
)
@pytest.mark.parametrize("name", ["power", "cost", "snr_db"])
def test_ends_are_what_the_exact_search_finds(key, name):
    case, (_, front) = fc.case_of(key), fc.front_of(key, TRIPLE)
    found = replace(case, objective=Objective.of(name)).solve(top=1)[1]
    end = front.values[:, TRIPLE.index(name)].min()
    assert end == pytest.approx(found.best[0].minimised, rel=1e-6)


def test_the_best_quality_is_on_the_front_however_roughly_it_is_asked(monkeypatch):
    monkeypatch.setattr(front_module, "ROUGH_SEGMENT", 1.0)
    monkeypatch.setattr(front_module, "FRONT_GAP", 1.0)
    _, front = fc.searched(fc.case_of(fc.SEVERAL), TRIPLE)
    found = replace(fc.case_of(fc.SEVERAL), objective=Objective.of("snr_db")).solve(top=1)[1]
    assert front.values[:, TRIPLE.index("snr_db")].min() == pytest.approx(found.best[0].minimised, rel=1e-6)


@pytest.mark.parametrize("key", ["bars", "bars over the frame"])
def test_bars_that_arrive_draw_no_more_power_than_anything_that_is_tried(key):
    """The exact search where bars on the floor must arrive, over altitudes; its cells end within 1e-4 of the least."""
    case, names = fc.case_of(key), TRIPLE
    search, outcome = case.solve(top=1)
    least = fc.tried_of(key, names)[:, names.index("power")].min()
    assert outcome.best[0].minimised <= least * (1 + 1e-4)
    design, values = fc.cases.evaluated_values(search, outcome.best[0], ("power",))
    assert values[0] == pytest.approx(outcome.best[0].minimised, rel=1e-6)
    (margin,) = (m for m in design.scenes[0].margins if m.requirement == "resolve_mm")
    assert margin.satisfied and margin.value > 0.97 * margin.limit  # without it the bars are 3.8 mm, and 3.4


@pytest.mark.usefixtures("coarse")
@pytest.mark.parametrize("key", ["steps", "flash", "counts and mounts"])
def test_best_information_is_what_the_exact_search_finds(key):
    case = replace(fc.case_of(key), objective=Objective.of("information"))
    _, front = front_of_information(key, ("power", "information"))
    _, outcome = case.solve(top=1)
    # the front's settings are searched to a gap of 1e-3
    assert front.values[:, 1].min() == pytest.approx(
        outcome.best[0].minimised, rel=1.5e-3 if rc.THOROUGH else 1e-2
    )


# ---------------------------------------------------------------- what must and must not matter


@pytest.mark.parametrize("seed", drawn([fc.SEVERAL, 24], [3, fc.SEVERAL, 24]))
def test_order_of_parts_changes_nothing(seed):
    case, rng = rc.case(seed), np.random.default_rng(seed)
    kinds = ("cameras", "lenses", "ports", "lights")
    mixed = Parts(
        *(
            tuple(getattr(case.parts, k)[int(i)] for i in rng.permutation(len(getattr(case.parts, k))))
            for k in kinds
        )
    )
    _, front = fc.front_of(seed, TRIPLE)
    _, other = fc.searched(case, TRIPLE, mixed)
    assert hypervolume(other.values, front.frame) == pytest.approx(
        front.hypervolume, rel=1e-3
    )  # twice the gap
    assert other.values.min(axis=0) == pytest.approx(front.values.min(axis=0), rel=1e-9)


@pytest.mark.parametrize("seed", drawn([fc.SEVERAL], [3, fc.SEVERAL]))
def test_more_parts_never_shrink_the_front(seed):
    case, rng = rc.case(seed), np.random.default_rng(seed + 2000)
    optics = small.beam(rng)
    richer = Parts(
        (*case.parts.cameras, small.camera(rng, "cam-new")), (*case.parts.lenses, small.lens(rng, "lens-new")),
        (*case.parts.ports, small.port(rng, "port-new")), (*case.parts.lights, small.light(rng, "light-new", optics)),
    )  # fmt: skip
    _, front = fc.front_of(seed, TRIPLE)
    _, other = fc.searched(case, TRIPLE, richer)
    not_beaten(other, front.values)  # in its own frame, of which its gap is a share: new parts may widen it a lot
    assert (
        other.values.min(axis=0) <= front.values.min(axis=0) + 1e-9 * np.abs(front.values.min(axis=0))
    ).all()


@pytest.mark.parametrize(
    "limits", [{"power_w": 30.0}, {"cost": 6000.0}, {"peak_power_w": 100.0}, {"max_exposure_ms": 1.0}]
)
def test_limits_never_improve_the_front_and_are_kept(limits):
    case, (_, front) = fc.case_of("all"), fc.front_of("all", TRIPLE)
    tight = replace(
        case,
        mission=case.mission.model_copy(update={"limits": case.mission.limits.model_copy(update=limits)}),
    )
    search, other = fc.searched(tight, TRIPLE)
    assert hypervolume(
        np.concatenate([front.values, other.values]), front.frame
    ) <= front.hypervolume_bound * (1 + 1e-9)
    if "power_w" in limits:
        assert (other.values[:, 0] <= 30.0 * (1 + 1e-6)).all()
        mild = front.values[front.values[:, 0] <= 30.0]
        assert hypervolume(other.values, front.frame) >= hypervolume(mild, front.frame) - 1e-3
    holds(search, other)
    adds_up(search, other)


def test_a_higher_wanted_snr_never_improves_the_front():
    _, front = fc.front_of("all", TRIPLE)
    strict = rc.planted("power", fc.PLANTED["all"].parts.lights, {**fc.WANTED, "min_snr_db": 32.0})
    _, other = fc.searched(strict, TRIPLE)
    assert (other.values[:, 2] <= -32.0 + 1e-6).all()
    both = np.concatenate([front.values, other.values])
    assert hypervolume(both, front.frame) <= front.hypervolume_bound * (1 + 1e-9)


@pytest.mark.parametrize(("seed", "names"), drawn(
    [(7, TRIPLE), (24, ("power", "cost"))],
    [(seed, n) for seed in (fc.SEVERAL, 24) for n in (TRIPLE, ("power", "cost"))],
))  # fmt: skip
def test_pymoo_never_finds_more_than_the_bound(seed, names):
    search, front = fc.front_of(seed, names)
    peer = population_front(search.search, names, pop_size=24, generations=12, seed=1)
    assert hypervolume(peer.values, front.frame) <= 1.001 * front.hypervolume_bound
    assert hypervolume(peer.values, front.frame) >= 0.9 * front.hypervolume


# ---------------------------------------------------------------- cut short


@pytest.fixture
def small_waves(monkeypatch):
    """Several waves even in a small catalogue."""
    monkeypatch.setattr(front_module, "FIRST_NODES", 2)
    monkeypatch.setattr(front_module, "GROWTH", 1)


def claims_hold_when_cut_short(case, search, front, names, full):
    """The account adds up, points hold, and what was missed is within the bound."""
    adds_up(search, front)
    holds(search, front)
    if front.frame is not None:
        both = hypervolume(np.concatenate([full.values, front.values]), front.frame)
        assert both <= front.hypervolume_bound * (1 + 1e-9)
        assert hypervolume(front.values, front.frame) == pytest.approx(
            front.hypervolume, rel=1e-5
        )  # last digits


@pytest.mark.usefixtures("small_waves")
@pytest.mark.parametrize("key", drawn(["counts and mounts"], ["all", "counts and mounts"]))
@pytest.mark.parametrize("where", ["least_power", "best_quality", "first_bounds"])
@pytest.mark.parametrize("call", drawn([0, 5], [0, 2, 5]))
def test_interrupted_anywhere_its_claims_hold(key, where, call, monkeypatch):
    case, (_, full), calls = fc.case_of(key), fc.front_of(key, TRIPLE), []
    honest = getattr(Trade, where)

    def stopping(self, *given, **more):
        calls.append(1)
        if len(calls) == call + 1:
            raise KeyboardInterrupt
        return honest(self, *given, **more)

    monkeypatch.setattr(Trade, where, stopping)
    search, front = fc.searched(case, TRIPLE)
    assert front.interrupted == (len(calls) > call)
    assert front.complete != front.interrupted
    claims_hold_when_cut_short(case, search, front, TRIPLE, full)


@pytest.mark.usefixtures("small_waves")
@pytest.mark.parametrize("key", drawn(["all"], ["all", "counts and mounts"]))
@pytest.mark.parametrize("call", drawn((0, 2, 5), range(6)))
def test_out_of_time_anywhere_its_claims_hold(key, call):
    case, (_, full), calls = fc.case_of(key), fc.front_of(key, TRIPLE), []

    class Late(Deadline):
        def passed(self):
            calls.append(1)
            return len(calls) > call

    search, front = fc.searched(case, TRIPLE, deadline=Late())
    assert front.complete == (len(calls) <= call)
    assert not front.interrupted
    claims_hold_when_cut_short(case, search, front, TRIPLE, full)


def test_stopped_by_its_progress_it_keeps_what_was_found():
    told = []

    def enough(share, what):
        told.append((share, what))
        raise KeyboardInterrupt

    _, front = fc.searched(rc.case(3), TRIPLE, progress=enough)
    assert len(told) == 1
    assert front.interrupted
    assert len(front.values) > 0


def test_history_grows_to_the_front():
    _, front = fc.front_of(3, TRIPLE)
    seconds = [at for at, _ in front.history]
    volumes = [hypervolume(values, front.frame) for _, values in front.history]
    assert seconds == sorted(seconds)
    assert all(b >= a * (1 - 1e-9) for a, b in pairwise(volumes))
    assert volumes[-1] == pytest.approx(front.hypervolume, rel=1e-3)


# ---------------------------------------------------------------- the quality


def test_two_qualities_of_the_settings_are_one_too_many():
    problem = rc.case(3).problem()
    with pytest.raises(Exception, match=r"snr_db and information both depend.*nsga2"):
        quality_of(problem, Axes.of(("snr_db", "information")))


def test_contrast_depends_on_settings_under_the_sun_alone():
    axes = Axes.of(("power", "contrast"))
    assert quality_of(fc.PLANTED["dims"].problem(), axes) is None
    assert quality_of(fc.PLANTED["sun"].problem(), axes) == "contrast"


def test_frame_is_that_of_the_points():
    _, front = fc.front_of(3, TRIPLE)
    frame = Frame.of(front.axes, front.values)
    assert front.frame.ideal == pytest.approx(frame.ideal)
    assert front.frame.span == pytest.approx(frame.span)

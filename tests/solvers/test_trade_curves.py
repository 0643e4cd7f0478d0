"""Curves of quality against power: no tried setting is beyond what they say, at any stage of asking."""

from __future__ import annotations

from dataclasses import replace

import front_cases as fc
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from thorough import drawn

from uwopt.objectives.axes import Axes
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.lightings import Under
from uwopt.solvers.front import trade_curves
from uwopt.solvers.front.curves import Curves
from uwopt.solvers.front.hopeful import Hopeful
from uwopt.solvers.front.search import FrontSearch
from uwopt.solvers.front.trade_curves import CURVE_GAP, Answers
from uwopt.solvers.settings.cell_information import Information

KEYS = (
    "dims", "steps", "on", "pulses", "pulses on", "flash", "flash rolling", "dark", "level",
    "altitudes", "sharp", "still", "nothing asked", "sun",
)  # fmt: skip
SOME = drawn(("steps", "pulses on", "flash rolling", "level", "altitudes", "sharp", "sun"), KEYS)


def designs_of(key: str, quality: str) -> tuple[FrontSearch, list[Hopeful]]:
    """Designs of a planted case with their light known, one a list."""
    search = FrontSearch(fc.PLANTED[key].problem(), Axes.of(("power", quality)))
    imagers = search.search.prepare()
    lightings = search.search.tables.lightings
    lighting, imager = (part.ravel() for part in np.indices((len(lightings), len(imagers))))
    found = search._bounded_again(Under(lightings, lighting), imager)
    return search, [] if found is None else [found.take(np.array([d])) for d in range(len(found))]


def curves_of(search: FrontSearch, some: Hopeful) -> Curves:
    """Curves known at their least power."""
    curves = Curves.bounded(search.trade, some)
    known = None if curves is None else curves.with_least_power()
    assert known is not None
    return known


def tried_beside(key: str, quality: str, some: Hopeful):
    """Power and quality of tried settings of the same design; its parts are told by their constant terms."""
    case = fc.PLANTED[key]
    alone = replace(case.parts, lights=(case.parts.lights[int(some.light[0])],))
    samples = fc.samples_of(replace(case, parts=alone))
    points = fc.tried_points(samples, ("power", quality))
    return points[:, 0], -points[:, 1]


def assert_covered(curves: Curves, power, quality, gap: float):
    """Each tried setting is under an answer, or in a segment that may still hold it."""
    a = curves.answers
    room = gap * np.maximum(np.abs(quality), 1e-9)
    known = (a.power_w[None, :] <= power[:, None] * (1 + 1e-6)) & (
        a.quality[None, :] >= (quality - room)[:, None]
    )
    at, best = curves.corners()
    still = (at[None, :] <= power[:, None] * (1 + 1e-6)) & (best[None, :] >= (quality - room)[:, None])
    missed = ~(known.any(axis=1) | still.any(axis=1))
    assert not missed.any(), list(zip(power[missed][:3], quality[missed][:3], strict=True))


@pytest.mark.parametrize("key", SOME)
def test_curve_of_snr_covers_what_is_tried_however_far_it_is_asked(key):
    search, designs = designs_of(key, "snr_db")
    assert designs
    for some in designs:
        power, quality = tried_beside(key, "snr_db", some)
        curves = curves_of(search, some)
        assert_covered(curves, power, quality, 1e-6)
        for pieces in (2, 4):
            corner = np.isfinite(curves.corners()[0])
            which = np.nonzero(corner)[0][:12]
            if len(which) == 0:
                break
            curves.ask(which, np.full(len(which), -np.inf), np.full(len(which), pieces))
            assert_covered(curves, power, quality, 1e-6)


def test_least_power_uses_dark_current_for_the_wanted_level():
    search, designs = designs_of("dark at a level", "snr_db")
    for some in designs:
        power, _ = tried_beside("dark at a level", "snr_db", some)
        assert search.trade.least_power(some).power_w[0] <= power.min() * (1 + 1e-6)


@pytest.mark.parametrize("key", ["dims", "steps", "pulses", "flash", "dark", "sharp"])
def test_first_bounds_of_information_cover_what_is_tried(key):
    search, designs = designs_of(key, "information")
    for some in designs:
        power, quality = tried_beside(key, "information", some)
        curves = curves_of(search, some)
        assert_covered(curves, power, quality, 1e-6)
        _, upper = curves.segments()
        curves.answers = search.trade.drawn_in(curves.some, curves.answers, upper)
        assert_covered(curves, power, quality, 1e-6)


def test_designs_in_the_sun_are_bounded_together_as_each_alone_within_each_limit():
    search, designs = designs_of("sun", "snr_db")
    assert len(designs) > 1
    some = Hopeful.joined(designs)
    bounds = search.trade.first_bounds(some, search.trade.least_power_bound(some))
    assert len(np.unique(bounds.bound)) > 2  # -inf at the least power, and what differs
    for d, alone in enumerate(designs):
        begin, *limits = np.nonzero(bounds.design == d)[0]
        assert bounds.limit_w[begin] == pytest.approx(search.trade.least_power_bound(alone)[0], rel=1e-12)
        expected = [search.trade.bound_within(alone, bounds.limit_w[[at]])[0] for at in limits]
        assert bounds.bound[limits] == pytest.approx(expected, rel=1e-12)


def over_found(key: str, bound_of) -> np.ndarray:
    """Bounds of information by what settings reach within the same limits of power."""
    search, designs = designs_of(key, "information")
    over = []
    for some in designs:
        curves = Curves.bounded(search.trade, some)
        assert curves is not None
        _, upper = curves.segments()
        found = search.trade.best_quality(some, np.zeros(len(upper), int), curves.answers.limit_w[upper])
        over.append((bound_of(search.trade, curves, upper) / found.quality)[found.found])
    return np.concatenate(over)


@pytest.mark.parametrize(("key", "near"), [("still", 1.09), ("flash", 1.09), ("dims", 1.3)])
def test_bounds_of_information_lie_near_what_settings_reach(key, near):
    """In a 64th of a range of f-numbers of eleven to one no more light comes with no less defocus than 4 % beside.

    Lamps that burn have the light of their longest time with the blur of their shortest.
    """
    over = over_found(key, lambda trade, c, upper: trade.drawn_in(c.some, c.answers, upper).bound[upper])
    assert over.min() > 1.0 - 1e-3 and over.max() < near


@pytest.mark.parametrize("key", ["dims", "steps", "pulses", "flash", "dark"])
def test_tangents_where_designs_look_best_bound_them_closely(key):
    """Settings that are found reach to within a quarter of each bound; tangents at the middle exceed them 11 times.

    A few percent beside the top a tangent still rises by so much over a range of f-numbers of eleven to one.
    """
    goal = Objective({"information": 1.0})

    def tangents(trade, curves, upper):
        designs = curves.some.take(curves.answers.design[upper])
        return -trade._whole_bound(designs, goal, curves.answers.limit_w[upper])

    assert over_found(key, tangents).max() < 1.25


def test_settings_guessed_between_two_limits_cost_less_and_change_no_answer(monkeypatch):
    """A curve asked at its ends and then between: with guesses, without, and with guesses that are far away."""
    summed, value = [], Information.value
    monkeypatch.setattr(Information, "value", lambda self, d, *a, **k: summed.append(len(d)) or value(self, d, *a, **k))

    def asked(guess):
        search, (some, *_) = designs_of("dims", "information")
        ask = search.trade.best_quality
        monkeypatch.setattr(search.trade, "best_quality", lambda *a, near=None, **k: ask(*a, near=guess(near), **k))
        curves, begun = curves_of(search, some), 0
        for _ in range(4):
            which = np.arange(len(curves.segments()[0]))
            begun = len(summed)
            curves.ask(which, np.full(len(which), -np.inf), np.full(len(which), 3))
        return curves.answers, sum(summed[begun:])

    plain, all_sums = asked(lambda near: None)
    for guess, most in ((lambda near: near, 0.75 * all_sums), (lambda near: near * [3.0, 0.01], np.inf)):
        answers, sums = asked(guess)
        assert sums < most
        assert answers.quality == pytest.approx(plain.quality, rel=CURVE_GAP, nan_ok=True)
        assert (answers.bound >= plain.quality * (1.0 - 1e-9))[answers.found].all()
        assert (answers.bound <= answers.quality * (1.0 + CURVE_GAP))[answers.found].all()


@pytest.mark.parametrize("key", ["dims", "steps", "pulses", "flash"])
def test_of_tries_those_are_kept_that_no_other_of_the_same_design_beats(key, monkeypatch):
    """A glance at all of them leaves fewer to be worked out, and hides none of the best."""
    search, designs = designs_of(key, "information")
    some = Hopeful.joined(designs)
    (kept,) = search.trade.tried(some, np.arange(len(some)))
    monkeypatch.setattr(trade_curves, "_best_by_power", lambda power_w, quality: np.isfinite(power_w))
    (every,) = search.trade.tried(some, np.arange(len(some)))
    assert len(kept.design) < 0.7 * len(every.design)
    as_good = (
        (kept.design == every.design[:, None])
        & (kept.power_w <= every.power_w[:, None] * (1.0 + 1e-6))
        & (kept.quality >= every.quality[:, None] * (1.0 - 1e-9))
    )
    assert as_good.any(axis=1).all()


@pytest.mark.parametrize("key", ["dims", "steps", "pulses", "flash", "level"])
def test_best_quality_within_a_limit_is_bounded_kept_and_grows_with_the_limit(key):
    search, designs = designs_of(key, "snr_db")
    for some in designs:
        power, quality = tried_beside(key, "snr_db", some)
        limits = np.geomspace(power.min() * 1.001, power.max() * 1.1, 12)
        answers = search.trade.best_quality(some, np.zeros(12, int), limits)
        found = answers.quality[answers.found]
        assert (answers.power_w[answers.found] <= limits[answers.found] * (1 + 1e-6)).all()
        assert (np.diff(found) >= -1e-9).all()
        for limit, best in zip(limits, np.where(answers.found, answers.quality, -np.inf), strict=True):
            within = quality[power <= limit]
            assert len(within) == 0 or within.max() <= best + 1e-5


def test_light_of_steps_has_its_power_at_every_limit_of_its_curve():
    search, (some,) = designs_of("steps", "snr_db")
    bounds = search.trade.first_bounds(some)
    drawn = {float(f"{w:.9g}") for w in bounds.limit_w - some.camera_power_w[0]}
    assert drawn <= {20.0, 50.0, 100.0, 200.0}


# ---------------------------------------------------------------- answers


def answers_of(design, limit, bound):
    """Answers that nobody asked for."""
    return Answers.unasked(np.array(design), np.array(limit, float), np.array(bound, float), 1)


def test_joined_answers_are_sorted_by_design_and_limit():
    joined = Answers.joined(
        [answers_of([1, 0], [5.0, 7.0], [1.0, 2.0]), answers_of([0, 1], [3.0, 9.0], [3.0, 4.0])]
    )
    assert joined.design.tolist() == [0, 0, 1, 1]
    assert joined.limit_w.tolist() == [3.0, 7.0, 5.0, 9.0]
    assert joined.bound.tolist() == [3.0, 2.0, 1.0, 4.0]
    assert not joined.found.any()


@given(rows=st.lists(st.tuples(st.integers(0, 3), st.floats(-5.0, 5.0)), min_size=1, max_size=20))
def test_drawn_in_bounds_are_the_least_of_the_higher_limits(rows):
    design = sorted(d for d, _ in rows)
    bound = np.array([b for _, b in rows])
    drawn = answers_of(design, np.arange(len(rows)), bound).drawn_in()
    for i, d in enumerate(design):
        later = [bound[j] for j in range(i, len(rows)) if design[j] == d]
        assert drawn.bound[i] == min(later)

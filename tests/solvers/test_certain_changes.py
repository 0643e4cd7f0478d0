"""What would make hardware certain where no key moved alone does: pairs of keys and raised limits, by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from one_of_each import one
from test_confidence import FAST, NOTHING, between, counted, sought_of
from test_confidence_deciding import COUNT, HIGH, LOW, MODE, quantile, seen

from uwopt.api import raised as limits
from uwopt.api.counting import Counts
from uwopt.api.raised import eased_or_raised, raised
from uwopt.deadline import NEVER, Deadline
from uwopt.mission.doubt import Doubt
from uwopt.solvers.confidence import changes
from uwopt.solvers.confidence.changes import MOST_WIDENED, drawn_in, needed, other_changes, size, told_with
from uwopt.solvers.confidence.counted import Looked
from uwopt.solvers.confidence.eased import Ease, MovedKeys, would_hold
from uwopt.solvers.confidence.search import Certain
from uwopt.solvers.confidence.summary import counted_confidence as told_of
from uwopt.solvers.recommend import Sought

FLOOR = [0.4, 1.6]
LIGHT = {"dim_levels": (1.0,), "flux_lm": 3000.0}
CAMERA = {"power_w": between(LOW, MODE, HIGH), "read_noise_e": between(1.9, 2.0, 2.1)}


@pytest.fixture(scope="module")
def short_of_both() -> tuple[Sought, float, float]:
    """Signal to noise that a dark floor misses and power that the camera may exceed, each in more than one of ten."""
    plain = sought_of(one("snr_db", wanted={"max_blur_px": 1.0, "min_snr_db": 1.0}, light=LIGHT, camera=CAMERA))
    best = plain.outcome.best[0]
    snr_db, power_w = float(np.floor(10.0 * best.snr_db) / 10.0), best.power_w - 3.0 + 5.2  # 3 W drawn at the mode
    wanted = {"max_blur_px": 1.0, "min_snr_db": snr_db}
    return sought_of(one(wanted=wanted, light=LIGHT, camera=CAMERA, limits={"power_w": power_w})), snr_db, power_w


def test_a_pair_of_keys_is_told_where_none_alone_is_enough(short_of_both: tuple[Sought, float, float]) -> None:
    """What is told holds in other scenarios as often as asked; with either key as it was asked it does not."""
    sought, snr_db, power_w = short_of_both
    problem, goal = sought.problem, sought.search.objective
    one_, scenarios = seen(sought, 0.9, floor=FLOOR)
    assert 0.2 < one_.held < 0.8
    assert would_hold(problem, goal, one_, scenarios, 0.9, NEVER) == []
    (told,), in_vain = other_changes(problem, goal, one_, scenarios, 0.9, [], NEVER)
    assert told.hardware == [] and told.held >= 0.9
    needs = {made.name: float(made.needed) for made in told.moves}
    assert set(needs) == {"min_snr_db", "power_w"} and needs["min_snr_db"] < snr_db and needs["power_w"] > power_w
    alone = {one.move.name: one.held for one in in_vain}
    assert alone["power_w"] < 0.9 and alone["min_snr_db"] < 0.9
    assert abs(alone["min_snr_db"] - share_below(5.2)) < 0.05  # the camera's draw is all that is left

    def held(snr: float, power: float) -> float:
        wanted = {"max_blur_px": 1.0, "min_snr_db": snr}
        there = sought_of(one(wanted=wanted, light=LIGHT, camera=CAMERA, limits={"power_w": power}))
        return float(counted(there, Doubt.model_validate(NOTHING | {"floor": FLOOR}), count=4 * COUNT).held.max())

    assert held(needs["min_snr_db"], needs["power_w"]) >= 0.88  # 0.9, less two standard errors of 1 600 draws
    assert held(needs["min_snr_db"], power_w) < 0.85 and held(snr_db, needs["power_w"]) < 0.85


def share_below(power_w: float) -> float:
    """Of the triangle of the camera's power, above its mode."""
    return 1.0 - (HIGH - power_w) ** 2 / ((HIGH - LOW) * (HIGH - MODE))


def test_a_raised_limit_is_told_with_what_holds_then() -> None:
    """The limit of power at which nine of ten cameras fit, by their triangle, in a search with all limits far off."""
    plain = sought_of(one(wanted=FAST))
    asked = plain.outcome.best[0].power_w - 3.0 + 4.2
    sought = sought_of(one(wanted=FAST, camera=CAMERA, limits={"power_w": asked}))
    one_, scenarios = seen(sought, 0.9)
    looked = Looked(sought.problem, sought.search.objective, 0.9, scenarios, [one_])
    (told,), beyond = raised(sought, looked, NEVER)
    assert beyond is None and told.held >= 0.9 and len(told.hardware) == 4
    (made,) = told.moves
    change = quantile(0.9) - 4.2
    assert made.name == "power_w" and 0.95 * change <= float(made.needed) - asked <= 1.2**MOST_WIDENED * 1.15 * change
    assert raised(sought, looked, Deadline(0.0, lambda: 1.0)) == ([], None)


def test_what_no_limit_mends_is_said_to_be_beyond_them() -> None:
    """Light is short, and no more power mends that."""
    best = sought_of(one("snr_db", wanted={"max_blur_px": 1.0, "min_snr_db": 1.0}, light=LIGHT)).outcome.best[0]
    wanted = {"max_blur_px": 1.0, "min_snr_db": float(np.floor(10.0 * best.snr_db) / 10.0)}
    sought = sought_of(one(wanted=wanted, light=LIGHT, limits={"power_w": 500.0}), floor=FLOOR)
    one_, scenarios = seen(sought, 0.9, floor=FLOOR)
    told, beyond = raised(sought, Looked(sought.problem, sought.search.objective, 0.9, scenarios, [one_]), NEVER)
    assert told == [] and beyond == pytest.approx(one_.held, abs=0.02)


def test_no_limit_is_raised_where_less_of_this_hardware_is_enough(
    short_of_both: tuple[Sought, float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the camera alone draws too much a larger limit is told of this hardware; where light is short too, both."""
    asked = sought_of(one(wanted=FAST)).outcome.best[0].power_w - 3.0 + 4.2
    of_power = sought_of(one(wanted=FAST, camera=CAMERA, limits={"power_w": asked}))
    monkeypatch.setattr(limits, "raised", lambda *given: pytest.fail("limits were raised"))
    for sought, floor, alone, together in (
        (of_power, None, ["power_w"], []), (short_of_both[0], FLOOR, [], [{"min_snr_db", "power_w"}]),
    ):  # fmt: skip
        problem, goal = sought.problem, sought.search.objective
        one_, scenarios = seen(sought, 0.9, **({} if floor is None else {"floor": floor}))
        known = told_of(problem, goal, one_, asked=0.9, share=0.9, decided_by=[])
        choice = Certain(0.9, scenarios, one_, one_.found, [one_], complete=True)
        counts = Counts(sought, Looked(problem, goal, 0.9, scenarios, [one_]))
        told = eased_or_raised(sought, known, choice, counts, NEVER)
        assert [made.name for made in told.would_hold] == alone
        assert [{move.name for move in each.moves} for each in told.would_hold_else] == together


def test_what_is_missed_is_known_of_hardware_that_was_counted_beside_others_too() -> None:
    """Of several behind one port no rules are told; a pixel too large is to be among what may be asked less."""
    wanted = {"min_snr_db": 10.0, "max_gsd_mm": 0.5 * (2.52 + 0.08)}
    sought = sought_of(one(wanted=wanted, vehicle={"altitude_tolerance_m": 0.5}), beyond_band=0.25)
    one_, scenarios = seen(sought, 0.9, beyond_band=0.25)
    beside = replace(one_, outcomes=replace(one_.outcomes, lost={}))
    told = would_hold(sought.problem, sought.search.objective, beside, scenarios, 0.9, NEVER)
    assert [made.name for made in told] == ["max_gsd_mm", "altitude_tolerance_m"]


def ease(key: str) -> Ease:
    """A key of which 10 is asked, and 20 far."""
    return Ease(key, "", 10.0, (20.0,), lambda value, there=None: there)


def test_what_was_widened_is_drawn_back_as_near_as_fresh_scenarios_allow(monkeypatch: pytest.MonkeyPatch) -> None:
    """It holds from 12.6 on, where 12 instead of 10 did in the choice: steps of a fifth go to 12.88, halves back."""

    class ByHand(MovedKeys):
        def held(self, found: Any, moves: Any, *, as_set: bool = False) -> float:
            ((_, value),) = moves
            self.deadline.check()
            return 0.95 if value >= 12.6 else 0.8

    monkeypatch.setattr(changes, "unseen", lambda *given: None)
    monkeypatch.setattr(changes, "names", lambda *given: "the same")
    problem, one_ = cast(Any, SimpleNamespace(mission=SimpleNamespace(seed=0))), cast(Any, object())
    for until, needed_ in ((NEVER, 12.6), (Deadline(0.0, lambda: 1.0), 12.9)):
        trial = ByHand(problem, cast(Any, None), cast(Any, None), 0.9, until)
        told = told_with(trial, one_, [(ease("x"), 12.0)], one_)
        assert told is not None and told.held == 0.95 and [one.needed for one in told.moves] == [needed_]


def test_moves_that_are_not_needed_are_dropped_and_the_rest_drawn_in() -> None:
    """It holds where x is 12 and y is 17, by hand; z is of no use."""

    def holds(moves: object) -> bool:
        at = {one.key: value for one, value in moves}  # type: ignore[attr-defined]
        return at.get("x", 10.0) >= 12.0 and at.get("y", 10.0) >= 17.0

    far = [(ease(key), 20.0) for key in "xzy"]
    left = needed(far, holds)
    assert [one.key for one, _ in left] == ["x", "y"]
    near = {one.key: value for one, value in drawn_in(left, holds)}
    assert 12.0 <= near["x"] <= 12.0 + 0.05 * 10.0 + 0.1 and 17.0 <= near["y"] <= 17.0 + 0.05 * 10.0 + 0.1
    assert size(drawn_in(left, holds)) == pytest.approx((near["x"] - 10.0 + near["y"] - 10.0) / 10.0)

"""The best image on its knee against enumeration: every hardware of a small catalogue at settings drawn at random.

What the forward model says of each is weighed by hand: ln Q - P ln(1 + g_P) - C ln(1 + g_C).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import brute_force as brute
import numpy as np
import pytest
from agreement import agree
from one_of_each import one, with_parts
from random_cases import Case, lamp, planted, ranked

from uwopt.evaluation.design_model import DesignModel
from uwopt.objectives.goal import goal_of
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.attack import Spread, missed_share
from uwopt.solvers.exact.joint_bounds import joint_bound_of_imagers
from uwopt.solvers.explain import knee
from uwopt.solvers.recommend import Sought
from uwopt.units import ratio_to_db

GAINS = {"dear": (0.05, 0.05), "cheap": (0.001, 0.002)}  # a watt and 100 USD
DRAWS, ROUNDS = 100, 7


@dataclass(frozen=True)
class Seen:
    """Feasible settings of every hardware: what they are worth and what they take."""

    hardware: np.ndarray[Any, Any]
    information: np.ndarray[Any, Any]
    snr_db: np.ndarray[Any, Any]
    power_w: np.ndarray[Any, Any]
    cost: np.ndarray[Any, Any]


def catalogue(objective: Any) -> Case:
    """Two cameras, two lamps in one or two; finer pixels and brighter lamps are dearer."""
    made = with_parts(
        one(
            "power", light={"power_w": 30.0, "flux_lm": 3000.0}, wanted={"min_snr_db": 10.0, "max_blur_px": 2.0},
            vehicle={"light_count": [1, 2]},
        ),
        cameras=[{"pixel_pitch_um": 3.0, "resolution_x_px": 2600, "resolution_y_px": 2000, "price": 1900.0}],
        lights=[{"power_w": 240.0, "flux_lm": 70000.0, "price": 1100.0}],
    )  # fmt: skip
    mission = made.mission.with_changes(objective=objective)
    return Case(made.parts, mission, goal_of(mission))


def wanted(name: str, of: str = "information") -> dict[str, Any]:
    """An objective of `GAINS`."""
    per_w, per_100_usd = GAINS[name]
    return {"best_image": {"of": of, "per_w": per_w, "per_100_usd": per_100_usd}}


def drawn(model: DesignModel, rng: np.random.Generator, worth: Any) -> list[np.ndarray[Any, Any]]:
    """Information, SNR, power and cost of settings all over their ranges, then ever nearer to the best of them."""
    spread, around, most, found = Spread(model), None, -np.inf, []
    for step in range(ROUNDS):
        points = spread.sample(rng, DRAWS, around=around, width=0.3 * 0.5**step)
        settings = spread.settings(0, points)
        figures = model.figures(0, settings, information=True)
        missed = np.sum([missed_share(m) for m in model.margins(0, settings, figures)], axis=0)
        totals = model.totals(figures)
        assert figures.information_bit_per_m2 is not None
        scene = model.problem.scenes[0]
        rows = np.stack([
            figures.information_bit_per_m2, ratio_to_db(np.maximum(figures.snr[:, scene.nominal], 1e-30)),
            totals["power_w"], np.full(DRAWS, totals["cost"][0]),
        ])  # fmt: skip
        value = np.where(missed == 0.0, worth(*rows), -1e3 - missed)
        if value.max() > most:
            around, most = points[int(np.argmax(value))], float(value.max())
        found.append(rows[:, missed == 0.0])
    return list(np.concatenate(found, axis=1))


@cache
def seen(name: str) -> Seen:
    """All of the catalogue."""
    case, rng = catalogue(wanted(name)), np.random.default_rng(3)
    bench, (per_w, per_100_usd) = brute.Bench(case.problem()), GAINS[name]

    def worth(information: Any, _: Any, power_w: Any, cost: Any) -> Any:
        return np.log(information) - power_w * math.log1p(per_w) - cost / 100.0 * math.log1p(per_100_usd)

    each = [drawn(bench.model(hardware), rng, worth) for hardware in brute.buildable(bench.problem)]
    assert len(each) == 8
    hardware = np.repeat(np.arange(len(each)), [len(one[0]) for one in each])
    return Seen(hardware, *np.concatenate(each, axis=1))


@cache
def best(name: str) -> Any:
    """What the search finds."""
    outcome = catalogue(wanted(name)).solve()[1]
    assert outcome.complete and outcome.account.adds_up()
    return outcome


@pytest.mark.parametrize("name", GAINS)
def test_the_best_image_is_that_of_enumeration(name: str) -> None:
    """Nothing drawn beats the bound, and near the best found something is drawn."""
    per_w, per_100_usd = GAINS[name]
    each, outcome = seen(name), best(name)
    value = np.log(each.information) - each.power_w * math.log1p(per_w) - each.cost / 100.0 * math.log1p(per_100_usd)
    most = float(value.max())
    assert most <= -outcome.lower_bound + 1e-6
    assert -outcome.best[0].minimised >= most - 2e-4  # its gap
    assert -outcome.best[0].minimised <= most + 2e-2  # what draws may miss of the best settings


@pytest.mark.parametrize("name", GAINS)
def test_nothing_buys_more_than_its_price(name: str) -> None:
    """The knee: dP watts and dC USD more leave no more than (1 + g_P)^dP (1 + g_C)^(dC / 100) times the information."""
    per_w, per_100_usd = GAINS[name]
    each, found = seen(name), best(name).best[0]
    mine = math.exp(-found.minimised) * (1 + per_w) ** found.power_w * (1 + per_100_usd) ** (found.cost / 100.0)
    allowed = (1 + per_w) ** (each.power_w - found.power_w) * (1 + per_100_usd) ** ((each.cost - found.cost) / 100.0)
    assert (each.information <= mine * allowed * (1 + 2e-4)).all()


def test_bounds_of_information_and_snr_hold_all_that_is_drawn() -> None:
    """Those of an imager under its lamp, the veil counted in the noise: tight, for the bright lamp fills the pixels."""
    case, each = catalogue(wanted("cheap")), seen("cheap")
    search = case.searcher(top=1)
    imagers = search.prepare()
    bounds = search.bounds.of_nodes(0, np.arange(len(imagers)))
    hardware = np.array([made.camera for made in brute.buildable(case.problem())])
    snr_room = []
    for row, camera in enumerate(imagers.camera):
        mine = np.isin(each.hardware, np.nonzero(hardware == camera)[0])
        assert each.information[mine].max() <= bounds.information[row]
        assert each.snr_db[mine].max() <= bounds.snr_db[row]
        snr_room.append(bounds.snr_db[row] - each.snr_db[mine].max())
    assert min(snr_room) < 1.0


@pytest.mark.parametrize("name", GAINS)
def test_quality_and_price_together_hold_all_that_is_drawn(name: str) -> None:
    """The joint bound of each imager under its lamps, as far below what is drawn as its intervals are wide."""
    case, each = catalogue(wanted(name)), seen(name)
    per_w, per_100_usd = GAINS[name]
    value = each.power_w * math.log1p(per_w) + each.cost / 100.0 * math.log1p(per_100_usd) - np.log(each.information)
    search = case.searcher(top=1)
    imagers = search.prepare()
    every, lightings = np.arange(len(imagers)), range(len(search.tables.lightings))
    joint = [joint_bound_of_imagers(search.bounds, k, every) for k in lightings]
    camera = np.array([made.camera for made in brute.buildable(case.problem())])
    for row, (own, bound) in enumerate(zip(imagers.camera, np.min(joint, axis=0), strict=True)):
        drawn_of = value[np.isin(each.hardware, np.nonzero(camera == own)[0])]
        assert bound <= drawn_of.min(), row
        assert bound >= drawn_of.min() - 1.5, row


def test_dear_power_and_money_choose_the_lesser_system() -> None:
    dear, cheap = (best(name).best[0] for name in GAINS)
    assert dear.power_w < cheap.power_w and dear.cost < cheap.cost


PULSED = lamp(
    "led", kind="pulsed_led", flux_lm=4e4, power_w=400.0, min_pulse_us=400.0, max_pulse_us=600.0,
    dim_levels=(0.05, 0.2, 1.0),
)  # fmt: skip
BURNING = lamp("burning", flux_lm=2e4, power_w=200.0, dim_levels=(0.05, 0.3, 1.0))


def test_the_best_signal_to_noise_equals_enumeration() -> None:
    """Of SNR the sum is linear in decibels, which the enumeration of weighed sums finds."""
    made = planted("power", (PULSED, BURNING), {"max_blur_px": 1.0})
    objective = Objective.best_image("snr_db", per_w=0.02, per_money=1e-4)
    case = replace(made, objective=objective)
    found = ranked(brute.enumerate_all(brute.Bench(case.problem()), objective))
    assert len(found) == 2
    agree(case, case.solve()[1], found)


@pytest.mark.parametrize("name", GAINS)
def test_what_more_buys_is_the_best_within_it(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A watt, and money for the finer camera and the brighter lamp: the best of all that is drawn within them."""
    monkeypatch.setattr(knee, "MORE_USD", 1600.0)
    search, outcome = catalogue(wanted(name)).solve(top=1)
    each, found = seen(name), outcome.best[0]
    told = knee.knee(Sought(None, search.problem, search, outcome))  # type: ignore[arg-type]
    assert told is not None
    per_w, per_100_usd = GAINS[name]
    mine = math.exp(-found.minimised) * (1 + per_w) ** found.power_w * (1 + per_100_usd) ** (found.cost / 100.0)
    assert told.value == pytest.approx(mine, rel=1e-9)
    for item, more_w, more in zip(told.bought, (1.0, 0.0), (0.0, 1600.0), strict=True):
        inside = (each.power_w <= found.power_w + more_w) & (each.cost <= found.cost + more)
        drawn_gain = each.information[inside].max(initial=mine) / mine - 1.0
        assert drawn_gain - 1e-3 <= item.gain <= drawn_gain + 0.25
        assert bool(item.hardware) == (item.gain > 0.0)
    assert max(item.gain for item in told.bought) > 0.0


def test_what_holds_in_the_doubt_counts_its_own_price_against_a_limit() -> None:
    """It has its place in no table of the search by central numbers, and took the price of what stands there."""
    search, outcome = catalogue(wanted(next(iter(GAINS)))).solve(top=1)
    found, sought = outcome.best[0], Sought(None, search.problem, search, outcome)  # type: ignore[arg-type]
    elsewhere = replace(found, imager=(found.imager + 1) % len(search.imagers))
    assert knee.limit_cost_of(sought, elsewhere) == pytest.approx(found.cost)  # every price is known

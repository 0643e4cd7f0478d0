"""The audit attacked: with the best part thrown away it must fail, for every objective, and pass when all is well."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import brute_force as brute
import numpy as np
import pytest
from random_cases import THOROUGH, Case, bench, case, enumerated, lamp, planted
from thorough import drawn

from uwopt.catalog.records import exact
from uwopt.forward.parts import Parts
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact import imagers
from uwopt.solvers.exact import search as exact_search
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.exact.attack import attack
from uwopt.solvers.exact.audit import BESIDE, audit
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.imager_rules import Tally
from uwopt.solvers.exact.imagers import FittingPairs
from uwopt.solvers.exact.node_bounds import NodeBounds
from uwopt.solvers.exact.search import Search

SUM = {"power": 0.2, "snr_db": 1.0}
OBJECTIVES: tuple[Any, ...] = (
    "power", "cost", "mass", "snr_db", "gsd_mm", "contrast", "information", SUM, {"power": 1.0, "cost": 0.01},
)  # fmt: skip
SOME = ["power", "gsd_mm", "contrast", "sum", "information"]  # what is known of the parts, of light, of both
ELSEWHERE = drawn(("snr_db", "contrast"), ("power", "snr_db", "contrast", "information"))
SUN = ({"sun_lux": 5_000.0, "depth_m": 20.0},)
TWO = ({}, {"altitude_m": 1.5, "water": "III"})
WANTED: dict[str, Any] = {"max_blur_px": 1.0, "min_snr_db": 20.0, "min_swath_m": 0.8}
TRIED = 24  # half of them beside the best, and there are seven or eight parts to swap


BURNING = lamp("burning", flux_lm=3e4, power_w=300.0, beam_angle_deg=80.0)
LED = lamp(
    "led", kind="pulsed_led", flux_lm=4e4, power_w=500.0, min_pulse_us=20.0, max_pulse_us=5000.0, beam_angle_deg=60.0
)  # fmt: skip


@cache
def world(objective: str, scenes: str = "one") -> Case:
    """Two cameras, three lenses, two ports and two lamps that all fit: what wins depends on the objective.

    Under the sun, in two scenes and for information two lenses alone, as searches take longer there.
    """
    wanted = {"sum": SUM, "money": {"power": 1.0, "cost": 0.01}}.get(objective, objective)
    alone = scenes != "one" or (objective == "information" and not THOROUGH)
    lamps = (LED,) if alone else (BURNING, LED)
    own = {"one": ({},), "sun": SUN, "two": TWO}[scenes]
    made = planted(wanted, lamps, WANTED, scenes=own)
    cam, lens, port = made.parts.cameras[0], made.parts.lenses[0], made.parts.ports[0]
    numbers = ((6.0, 1.8, 300.0, 60.0), (8.0, 1.4, 500.0, 150.0), (10.0, 2.8, 100.0, 90.0))
    lenses = tuple(
        replace(lens, id=f"lens-{i}", focal_length_mm=f, f_number_min=exact(n), price=exact(cost), mass_g=exact(mass))
        for i, (f, n, cost, mass) in enumerate(numbers[1:] if alone else numbers)
    )  # fmt: skip
    cameras = (cam, replace(cam, id="noisy", read_noise_e=exact(12.0), price=exact(200.0)))
    ports = (
        port,
        replace(port, id="flat", geometry="flat", outer_radius_mm=None, gap_mm=0.0, price=exact(90.0)),
    )
    parts = Parts(cameras[:1], lenses, ports[:1], lamps) if alone else Parts(cameras, lenses, ports, lamps)
    return Case(parts, made.mission, Objective.of(wanted))


def named(objective: Any) -> str:
    """A name for a test's id, and the key of `world`."""
    return objective if isinstance(objective, str) else "sum" if "snr_db" in objective else "money"


@cache
def honest(objective: str, scenes: str = "one") -> tuple[Search, Outcome]:
    """The search as it is."""
    return world(objective, scenes).solve(top=1)


def report_of(case_: Case, search: Search, outcome: Outcome, count: int = TRIED) -> dict[str, Any]:
    """What the audit says."""
    best = outcome.best[0].minimised if outcome.best else None
    return audit(search, case_.objective, count=count, seed=1, best_value=best)


def lensless(monkeypatch: pytest.MonkeyPatch, lens: int) -> None:
    """A search in which one lens fits no camera."""
    sound = imagers.fitting_pairs

    def without(problem: Any, **options: Any) -> FittingPairs:
        pairs = sound(problem, **options)
        kept, n = pairs.lens != lens, len(problem.parts.ports) * len(imagers.landscapes(problem))
        pairs.tally.discarded["image_circle"] += int((~kept).sum()) * n
        return FittingPairs(pairs.camera[kept], pairs.lens[kept], Tally(pairs.tally.discarded))

    for module in (imagers, exact_search):
        monkeypatch.setattr(module, "fitting_pairs", without)


# ---------------------------------------------------------------- it can fail


@pytest.mark.parametrize("objective", drawn(SOME, [named(o) for o in OBJECTIVES]))
def test_it_finds_a_lens_that_was_thrown_away(objective: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without its best lens a search finds something worse, and the audit something better, whatever is best."""
    fails_without_the_best_lens(objective, "one", monkeypatch)


@pytest.mark.parametrize("objective", ELSEWHERE)
def test_it_finds_a_lens_under_the_sun(objective: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same where settings have no closed form and the shutter collects more than the lamps' light."""
    fails_without_the_best_lens(objective, "sun", monkeypatch)


@pytest.mark.parametrize("objective", ELSEWHERE)
def test_it_finds_a_lens_in_two_scenes(objective: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same where the worse of two scenes counts."""
    fails_without_the_best_lens(objective, "two", monkeypatch)


def fails_without_the_best_lens(objective: str, scenes: str, monkeypatch: pytest.MonkeyPatch) -> None:
    case_, (_, sound) = world(objective, scenes), honest(objective, scenes)
    lensless(monkeypatch, sound.best[0].lens)
    search, outcome = case_.solve(top=1)
    assert outcome.best[0].minimised > sound.best[0].minimised + 1e-3 * abs(sound.best[0].minimised)
    report = report_of(case_, search, outcome)
    assert not report["passed"]
    assert {found["lens"] for found in report["better"]} == {case_.parts.lenses[sound.best[0].lens].id}


@pytest.mark.parametrize("objective", drawn(SOME[:-1], [named(o) for o in OBJECTIVES]))
def test_it_passes_an_honest_search(objective: str) -> None:
    """Nothing beside the best, and nothing that a rule discarded, is better."""
    report = report_of(world(objective), *honest(objective))
    assert report["passed"], report["better"]
    assert report["feasible"] > 0, "the attack finds feasible settings at all"


@pytest.mark.parametrize("scenes", ["sun", "two"])
@pytest.mark.parametrize("objective", ELSEWHERE)
def test_it_passes_an_honest_search_elsewhere(objective: str, scenes: str) -> None:
    """Nor under the sun, nor in two scenes."""
    report = report_of(world(objective, scenes), *honest(objective, scenes))
    assert report["passed"], report["better"]
    assert report["feasible"] > 0


def test_it_finds_a_lamp_that_was_thrown_away(monkeypatch: pytest.MonkeyPatch) -> None:
    """A lamp that no table of lights holds stands beside the best."""
    case_, (_, sound) = world("power"), honest("power")
    search = case_.searcher(top=1, only={"light": np.arange(2) != sound.best[0].light})
    report = report_of(case_, search, search.run())
    assert {found["light"] for found in report["better"]} == {case_.parts.lights[sound.best[0].light].id}


def test_it_sees_a_gain_of_one_percent() -> None:
    """An objective that is 1 % worse than what was discarded is a defect, one that is equal is none."""
    case_, (search, outcome) = world("power"), honest("power")
    kept = outcome.best[0].minimised
    for worse, passed in ((1.01, False), (1.0, True)):
        search.ranking.best = [replace(outcome.best[0], count=2, minimised=worse * kept)]
        report = audit(search, case_.objective, count=TRIED, seed=1, best_value=worse * kept)
        assert report["passed"] == passed
    search.ranking.best = outcome.best


@pytest.mark.parametrize(("bound", "passed"), [(1.0, True), (1.005, False)])
def test_a_search_cut_short_is_held_to_its_bound_beside_the_best(bound: float, passed: bool) -> None:
    """Something 1 % better was not reached: no defect, unless the certificate says that there is nothing."""
    case_, (search, outcome) = world("power"), honest("power")
    kept = outcome.best[0].minimised
    search.ranking.best = [replace(outcome.best[0], count=2, minimised=1.01 * kept)]
    report = audit(
        search, case_.objective, count=TRIED, seed=1, best_value=1.01 * kept, lower_bound=bound * kept
    )
    search.ranking.best = outcome.best
    assert report["passed"] == passed


def test_it_fails_when_a_bound_throws_units_away(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bounds of one lens's power ten times too high: it is discarded unseen, by the rule `bound`."""
    case_, (_, sound) = world("power"), honest("power")
    of_nodes = Bounds.of_nodes

    def too_high(self: Bounds, k: int, rows: Any) -> NodeBounds:
        bounds = of_nodes(self, k, rows)
        its = self.imagers.lens[rows] == sound.best[0].lens
        return replace(bounds, value=np.where(its, 10.0 * bounds.value, bounds.value))

    monkeypatch.setattr(Bounds, "of_nodes", too_high)
    for name, value in (("FIRST_BATCH", 1), ("LARGEST_BATCH", 1), ("TOO_FEW_TO_BOUND", 0)):
        monkeypatch.setattr(exact_search, name, value)
    search, outcome = case_.solve(top=1)
    assert not report_of(case_, search, outcome)["passed"]


def test_it_fails_when_all_lenses_are_thrown_away(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing found, nothing beside it: what the rules discarded is feasible."""
    monkeypatch.setattr(imagers, "circles_ok", lambda problem: np.zeros((2, 3), bool))
    case_ = world("power")
    search, outcome = case_.solve(top=1)
    assert not outcome.best
    report = report_of(case_, search, outcome)
    assert not report["passed"] and set(report["by_rule"]) == {"image_circle"}


# ---------------------------------------------------------------- what it draws


@cache
def with_a_narrow_lens() -> dict[str, Any]:
    """The audit of a search that discards a lens for its image circle."""
    made = world("power")
    narrow = replace(made.parts.lenses[0], image_circle_mm=1.0)
    case_ = replace(made, parts=replace(made.parts, lenses=(narrow, *made.parts.lenses[1:])))
    return report_of(case_, *case_.solve(top=1), count=8)


def test_half_is_drawn_beside_the_best() -> None:
    """As many as the rules give are drawn from them, the other half differs from the best."""
    report = with_a_narrow_lens()
    assert report["tried"] == 8 and report["by_rule"][BESIDE] == 4


def test_pairs_that_do_not_fit_are_drawn_too() -> None:
    """A rule that looks at camera and lens alone has its share of the draws."""
    assert with_a_narrow_lens()["by_rule"]["image_circle"] > 0


# ---------------------------------------------------------------- the generic search


@pytest.mark.parametrize("seed", drawn((10, 22), (3, 8, 9, 10, 13, 22)))
def test_the_attack_comes_close_to_the_enumeration(seed: int) -> None:
    """Best settings of a few designs, by grids that know where ends of ranges meet, to a thousandth."""
    problem, objective, rng = bench(seed).problem, case(seed).objective, np.random.default_rng(seed)
    for best in enumerated(seed)[:2]:
        value = attack(problem, best.hardware, objective, rng)
        assert value == pytest.approx(best.value, abs=1e-3 * best.scale)


def test_the_attack_meets_a_level_without_gain() -> None:
    """A camera whose gain is fixed gives the wanted mean level only with the right light."""
    camera = {"max_gain_db": exact(0.0), "black_level_dn": 0.0}
    made = planted("power", (BURNING,), {"mean_level": 0.3, "highlight_ratio": 1.0}, camera=camera)
    best = brute.enumerate_all(brute.Bench(made.problem()), made.objective)[0]
    value = attack(made.problem(), best.hardware, made.objective, np.random.default_rng(0))
    assert value == pytest.approx(best.value, rel=1e-3)


def test_the_attack_takes_nothing_from_a_tolerance() -> None:
    """Feasible is what meets every limit to rounding: its best is not below the closed form's."""
    for objective in ("power", "snr_db"):
        search, outcome = honest(objective)
        found = outcome.best[0]
        hardware = brute.Hardware(
            found.camera,
            found.lens,
            found.port,
            found.landscape,
            found.light,
            found.count,
            found.lighting.mount,
        )
        value = attack(search.problem, hardware, search.objective, np.random.default_rng(0))
        assert found.minimised * (1 - np.sign(found.minimised) * 2e-8) <= value

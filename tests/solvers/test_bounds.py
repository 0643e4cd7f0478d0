"""Bounds against the best that enumeration finds for what they bound: never above it, and not far below.

A catalogue of 32 combinations is enumerated by `brute_force`, which shares no code with the search, for missions
that make another term of the bounds count each. Information, which the enumeration does not know, is held against
the audit's generic search.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import brute_force as brute
import numpy as np
import pytest
from numpy.typing import NDArray
from one_of_each import one, with_parts
from random_cases import Case
from thorough import drawn

from uwopt.solvers.exact import large, tree
from uwopt.solvers.exact.account import Account
from uwopt.solvers.exact.attack import attack
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.imagers import FittingPairs, Imagers, fitting_pairs
from uwopt.solvers.exact.large import PairTree
from uwopt.solvers.exact.light_tables import FieldTables
from uwopt.solvers.exact.lightings import suffix_min
from uwopt.solvers.exact.node_bounds import bit_per_px_bound
from uwopt.solvers.exact.outline import Level, OutlineRows, OutlineTables
from uwopt.solvers.exact.pair_groups import PairGroups
from uwopt.solvers.exact.port_groups import port_tree
from uwopt.solvers.exact.search import Cheapest, Search

Array = NDArray[Any]
FOUND = 1.0 + 1e-6  # what the enumeration's own rounding may take
SUM = {"power": 0.2, "snr_db": 1.0}
FAST = {"max_blur_px": 1.0, "min_snr_db": 26.0}
LEVEL = {**FAST, "mean_level": 0.3, "highlight_ratio": 1.2}
LED = {
    "kind": "pulsed_led",
    "min_pulse_us": 20.0,
    "max_pulse_us": 2000.0,
    "max_duty_frac": 0.5,
    "max_rate_hz": 20.0,
}
FLASH = {
    "kind": "flash", "flux_lm": None, "power_w": None, "flash_energy_j": 30.0, "flash_efficacy_lm_s_per_j": 35.0,
    "flash_duration_us": 800.0, "recycle_s": 0.5, "charging_efficiency_frac": 0.7, "dim_levels": (0.25, 0.5, 1.0),
}  # fmt: skip
STEPS = {"dim_levels": (0.1, 0.5, 1.0)}
BRIGHT, TURBID = {"flux_lm": 1_000_000.0}, ({"water": "3C"},)
TWO = ({}, {"altitude_m": 1.4, "water": "III"})

MISSIONS: dict[str, Callable[[], Case]] = {
    "least power": lambda: one(wanted=FAST, physics="paper"),
    "least power in full physics": lambda: one(wanted=FAST),
    "light mostly veil": lambda: one(
        wanted=FAST, scenes=TURBID, light=BRIGHT, vehicle={"altitude_tolerance_m": 0.2}
    ),
    "a well nearly full of veil": lambda: one(
        wanted=LEVEL, scenes=TURBID, light=BRIGHT, camera={"saturation_e": 20_000.0}
    ),
    "a wanted level": lambda: one(wanted=LEVEL, physics="paper", camera={"max_gain_db": 3.0}),
    "two scenes": lambda: one(
        wanted=FAST, physics="paper", scenes=TWO, vehicle={"altitude_tolerance_m": 0.2}
    ),
    "pulses": lambda: one(wanted=FAST, physics="paper", light=LED),
    "flashes in steps": lambda: one(wanted=FAST, physics="paper", light=FLASH),
    "lamps in steps": lambda: one(
        "cost", wanted=FAST, physics="paper", light=STEPS, limits={"power_w": 60.0}
    ),
    "best signal": lambda: one(
        "snr_db", wanted=FAST, physics="paper", limits={"power_w": 40.0, "cost": 3500.0}
    ),
    "best signal of a full well": lambda: one(
        "snr_db", wanted=FAST, physics="paper", camera={"saturation_e": 2000.0}
    ),
    "best signal under a veil": lambda: one("snr_db", wanted=FAST, scenes=TURBID, light=BRIGHT),
    "power against signal": lambda: one(SUM, wanted=FAST, physics="paper", limits={"mass_kg": 2.0}),
}
DEAREST = "the same in two scenes"
OVER_FRAME: dict[str, Callable[[], Case]] = {
    "an SNR over the frame": lambda: one(wanted={**FAST, "min_snr_db": 20.0, "snr_at": "worst"}),
    "a frame that may have less than its mean": lambda: one(
        wanted={**FAST, "min_snr_db": 24.0, "snr_at": "worst", "snr_at_less_db": 2.0}
    ),
    DEAREST: lambda: one(
        wanted={**FAST, "min_snr_db": 16.0, "snr_at": "worst"}, scenes=TWO, vehicle={"altitude_tolerance_m": 0.2}
    ),
}
MOSTLY_BOUNDED = 0.6
#: What the others have in other company: light that is worked out in full under a veil, signal beside a full well.
IMPLIED = ("least power in full physics", "best signal")
TRIED = drawn([name for name in MISSIONS if name not in IMPLIED], list(MISSIONS))
SEARCHED = drawn(["least power", "two scenes", "lamps in steps", "best signal under a veil"], list(MISSIONS))
FRAMES = drawn([name for name in OVER_FRAME if name != DEAREST], list(OVER_FRAME))
UNDIMMED = ("least power", "two scenes", "pulses")  # where nothing is left out of a bound but quantisation


@cache
def world(name: str) -> Case:
    """Two of each part around the one of each, in one or two lamps; where an image costs most, one lens and port."""
    made = (MISSIONS | OVER_FRAME)[name]()
    glass = {
        "lenses": [{"focal_length_mm": 12.0, "f_number_min": 2.8, "price": 300.0}],
        "ports": [{"outer_radius_mm": 120.0, "price": 100.0}],
    }
    grown = with_parts(
        made, cameras=[{"pixel_pitch_um": 3.0, "read_noise_e": 6.0, "price": 700.0}],
        lights=[{"price": 900.0, "beam_angle_deg": 50.0}], **drawn({} if name == DEAREST else glass, glass),
    )  # fmt: skip
    vehicle = grown.mission.vehicle.model_copy(update={"light_count": (1, 2)})
    views = grown.mission.with_changes(vehicle={**vehicle.model_dump(), "light_count": [1, 2]})
    return Case(grown.parts, views, grown.objective)


@dataclass(frozen=True)
class Known:
    """The best of every combination, by camera, lens, port, light and number."""

    best: dict[tuple[int, ...], brute.Best]

    def least(self, **fixed: Any) -> brute.Best | None:
        """The best of those with these parts; None where nothing is feasible."""
        names = ("camera", "lens", "port", "light", "count")
        mine = [
            found for key, found in self.best.items()
            if all(dict(zip(names, key, strict=True))[n] in np.atleast_1d(v) for n, v in fixed.items())
            and np.isfinite(found.value)
        ]  # fmt: skip
        return min(mine, key=lambda found: found.value, default=None)


@cache
def known(name: str) -> Known:
    """Everything enumerated."""
    case_ = world(name)
    bench = brute.Bench(case_.problem())
    found = {}
    for hw in brute.buildable(bench.problem):
        key = (hw.camera, hw.lens, hw.port, hw.light, hw.count)
        found[key] = brute.best_of(bench, hw, case_.objective)
    return Known(found)


@cache
def searched(name: str) -> tuple[Search, Imagers]:
    """Tables of the search, ready to bound."""
    search = world(name).searcher()
    return search, search.prepare()


def below(bound: float, best: brute.Best) -> bool:
    """Whether a bound is one."""
    return bool(bound <= best.value + (FOUND - 1.0) * best.scale)


def bounds_of(name: str) -> Bounds:
    """Bounds of all imagers."""
    search, _ = searched(name)
    return Bounds(search.objective, search.tables)


# ---------------------------------------------------------------- nodes


@pytest.mark.parametrize("name", TRIED)
def test_a_unit_is_bounded_by_its_best(name: str) -> None:
    """Objective and power of the best lamp and number; and what a rule discards has no feasible one."""
    _, imagers = searched(name)
    bounds, tried = bounds_of(name), 0
    for k, table in enumerate(bounds.light_tables):
        unit = bounds.of_nodes(k, np.arange(len(imagers)))
        for row in range(len(imagers)):
            best = known(name).least(
                camera=imagers.camera[row], lens=imagers.lens[row], port=imagers.port[row], light=table.light
            )
            if best is None:
                continue
            tried += 1
            assert unit.rule[row] < 0, "discarded, and yet feasible"
            assert below(unit.value[row], best)
            assert unit.power[row] <= best.power_w * FOUND
    assert tried > 0, "the mission was made to be feasible"


@pytest.mark.parametrize("name", FRAMES)
def test_the_pixel_that_decides_bounds_a_unit_more_sharply(name: str) -> None:
    """Every unit by its best of all lamps and numbers; and more sharply than the mean does by a tenth of its light."""
    _, imagers = searched(name)
    bounds, rows, tried, gained = bounds_of(name), np.arange(len(imagers)), 0, 0
    for k, table in enumerate(bounds.light_tables):
        rough, unit = bounds.of_nodes(k, rows), bounds.of_pixels(k, rows)
        assert (unit.power >= rough.power).all() and (unit.value >= rough.value).all()
        gained += int((unit.power - 3.0 > 1.1 * (rough.power - 3.0)).sum())
        for row in rows:
            own = dict(camera=imagers.camera[row], lens=imagers.lens[row], port=imagers.port[row])
            best = known(name).least(**own, light=table.light)
            if best is not None:
                tried += 1
                assert unit.rule[row] < 0, "discarded, and yet feasible"
                assert below(unit.value[row], best) and unit.power[row] <= best.power_w * FOUND
    assert tried > 0 and gained > 0


def test_bounds_by_pixels_leave_the_answer_and_the_account_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where power allows little more than the best: what enumeration finds, each combination counted once."""
    name = "an SNR over the frame"
    best = known(name).least()
    assert best is not None
    tight = world(name).mission.with_changes(limits={"power_w": best.power_w * 1.05})
    case_ = Case(world(name).parts, tight, world(name).objective)
    found = {}
    for refined in (False, True):
        monkeypatch.setattr(Bounds, "asks_of_images", lambda self, refined=refined: refined)
        found[refined] = case_.solve(top=1)[1]
        assert found[refined].account.adds_up()
        assert found[refined].best[0].minimised == pytest.approx(best.value, rel=FOUND - 1.0)
    rough, fine = (found[refined].account for refined in (False, True))
    assert fine.discarded["power_w"] > rough.discarded["power_w"] and fine.evaluated <= rough.evaluated


@pytest.mark.parametrize("name", UNDIMMED)
def test_the_bound_of_a_unit_is_tight(name: str) -> None:
    """In physics `paper` light is known exactly: the best unit's power is bounded to a hundredth."""
    _, imagers = searched(name)
    bounds, best = bounds_of(name), known(name).least()
    assert best is not None
    hw = best.hardware
    row = np.nonzero((imagers.camera == hw.camera) & (imagers.lens == hw.lens) & (imagers.port == hw.port))[0]
    k = next(i for i, table in enumerate(bounds.light_tables) if hw.light in table.light)
    light_w = best.power_w - 3.0
    assert bounds.of_nodes(k, row).power[0] - 3.0 >= 0.99 * light_w


# ---------------------------------------------------------------- pairs, groups of ports, cameras


@pytest.mark.parametrize("name", TRIED)
def test_a_group_of_ports_is_bounded_by_its_best(name: str) -> None:
    """From both domes together down to each."""
    search, imagers = searched(name)
    problem = search.problem
    like = FieldTables(problem, imagers)
    camera, lens = (grid.ravel() for grid in np.meshgrid([0, 1], [0, 1]))
    for groups in port_tree(problem):
        level = Level(problem, groups)
        for group in range(len(groups.start)):
            rows = OutlineRows(camera, lens, np.ones(4, bool), np.full(4, group))
            ports = groups.order[groups.start[group] : groups.stop[group]]
            seen = level.imagers(rows)
            passes = np.logical_and.reduce([ok for _, ok in level.rules(rows, seen)])
            tables = OutlineTables(level, rows, seen, like)
            bounds = Bounds(search.objective, tables)
            nodes = [bounds.of_nodes(k, np.arange(4)) for k in range(len(tables.lightings))]
            for row in range(4):
                best = known(name).least(camera=camera[row], lens=lens[row], port=ports)
                if best is not None:
                    assert passes[row], "discarded, and yet feasible"
                    assert below(min(u.value[row] for u in nodes if u.rule[row] < 0), best)


@pytest.mark.parametrize("name", TRIED)
def test_a_group_of_pairs_is_bounded_by_its_best(name: str) -> None:
    """Cameras that see alike with lenses of any focal length, behind both domes together."""
    search, imagers = searched(name)
    problem = search.problem
    like, ports = FieldTables(problem, imagers), port_tree(problem)[0]
    for pairs in PairGroups.levels(problem, fitting_pairs(problem), search.objective):
        level = Level(problem, ports, pairs)
        camera, lens = np.nonzero(pairs.count)
        rows = OutlineRows(camera, lens, np.ones(len(lens), bool), np.zeros(len(lens), int))
        seen = level.imagers(rows)
        passes = np.logical_and.reduce([ok for _, ok in level.rules(rows, seen)])
        bounds = Bounds(search.objective, OutlineTables(level, rows, seen, like))
        nodes = [bounds.of_nodes(k, np.arange(len(lens))) for k in range(len(like.lightings))]
        row, one, other = pairs.parted(camera, lens)
        for at, own, its in zip(row, one, other, strict=True):
            best = known(name).least(camera=own, lens=its)
            if best is not None:
                assert passes[at], "discarded, and yet feasible"
                assert below(min(u.value[at] for u in nodes if u.rule[at] < 0), best)


@pytest.mark.parametrize("name", TRIED)
def test_the_floor_of_a_pair_is_below_its_best(name: str) -> None:
    """What camera and lens cost without light behind the cheapest port."""
    search = searched(name)[0]
    pairs = fitting_pairs(search.problem)
    floors = floors_of(search, pairs)
    for camera, lens, floor in zip(pairs.camera, pairs.lens, floors, strict=True):
        best = known(name).least(camera=camera, lens=lens)
        assert best is None or below(floor, best)


def test_the_floor_of_a_pair_is_its_cost_without_light_behind_the_cheaper_dome() -> None:
    """1000 + 500 + 100 USD for the first camera and lens, by hand: the second dome costs 100."""
    search = world("lamps in steps").searcher()
    floors = floors_of(search, fitting_pairs(search.problem))
    assert floors.tolist() == [1600.0, 1400.0, 1300.0, 1100.0]


@pytest.mark.parametrize("name", TRIED)
def test_a_camera_that_reaches_a_ceiling_is_looked_at(name: str) -> None:
    """With a ceiling at its best no camera is left out."""
    for camera in (0, 1):
        best = known(name).least(camera=camera)
        if best is not None:
            search = world(name).searcher(ceiling=best.value + (FOUND - 1.0) * best.scale)
            assert search._cameras_below_ceiling()[camera]


def floors_of(search: Search, pairs: FittingPairs) -> Array:
    """What pairs cost at least."""
    goal = Cheapest(search.objective, search.among, lambda: np.inf)
    tree = PairTree(search.problem, search.objective, pairs, goal, Account())
    groups = range(len(tree.levels[-1].groups.start))
    behind = [
        OutlineRows(pairs.camera, pairs.lens, np.full(len(pairs.camera), landscape), np.full(len(pairs.camera), group))
        for group in groups for landscape in tree.orientations
    ]  # fmt: skip
    floors = [goal.ideals(tree.floor_terms(tree.levels[-1], rows))[:, 0] for rows in behind]
    return np.asarray(np.min(floors, axis=0))


# ---------------------------------------------------------------- signal and quality


@pytest.mark.parametrize(("flat", "most"), [(False, 1.25), (True, 1.5)])
def test_the_tabled_signal_is_not_far_above_the_exact_one(flat: bool, most: float) -> None:
    """A looser bound would cost time only: behind a dome within a quarter, behind a flat port with a gap a half."""
    search = one(wanted=FAST, flat=flat).searcher()
    search.prepare()
    row, lighting = np.arange(1), search.tables.lightings[0]
    bound = search.tables.bound(0, lighting, 0, row)
    exactly = search.tables.exact(0, lighting, row, veils="none").signal_e[0, 0]
    assert exactly <= bound[0] <= most * exactly


def test_information_is_bounded_by_what_a_generic_search_finds() -> None:
    """Under every lamp, at the ceiling of no light at all, and of each unit."""
    made = with_parts(
        one("information", wanted={**FAST, "min_swath_m": 1.0}), cameras=[{"pixel_pitch_um": 3.0}]
    )
    search, rng = made.searcher(), np.random.default_rng(0)
    imagers = search.prepare()
    rows = np.arange(len(imagers))
    ceiling, unit = search.bounds.information_ceiling(rows), search.bounds.of_nodes(0, rows)
    for hardware in brute.buildable(search.problem):
        row = int(np.nonzero(imagers.camera == hardware.camera)[0][0])
        found = -attack(search.problem, hardware, search.objective, rng)
        assert 0.0 < found <= unit.information[row] <= ceiling[row]
        assert unit.information[row] <= 4.0 * found, "not so loose that it is empty"


def test_bits_of_a_pixel_are_bounded_by_the_pixel_alone() -> None:
    """A lens without rating and no diffraction: the mean of half a binary logarithm over the Nyquist square."""
    nu = (np.arange(400) + 0.5) / 800.0
    mtf = np.sinc(nu)[:, None] * np.sinc(nu)
    for snr_db in (3.0, 20.0, 41.3):
        snr = 10.0 ** (snr_db / 20.0)
        bits = float(np.mean(0.5 * np.log2(1.0 + (0.1 * snr * mtf) ** 2)))
        bound = float(bit_per_px_bound(np.array([snr_db]), np.array([0.0]))[0])
        assert bits <= bound <= 1.15 * bits + 0.02  # the next half decibel up


@pytest.mark.parametrize("min_contrast", [None, 0.5])
def test_contrast_is_bounded_by_the_image_itself(min_contrast: float | None) -> None:
    """The forward veil alone leaves at least what the forward model's image has, and less than all."""
    wanted = FAST if min_contrast is None else {**FAST, "min_contrast": min_contrast}
    search = one("contrast", wanted=wanted).searcher()
    imagers = search.prepare()
    bound, enough = search.bounds._contrast_bound(search.tables.lightings[0], np.arange(len(imagers)))
    light = search.tables.exact(0, search.tables.lightings[0], np.arange(1))
    assert light.forward_e is not None and light.backscatter_e is not None
    signal, forward, back = (float(v[0, 0]) for v in (light.signal_e, light.forward_e, light.backscatter_e))
    assert signal / (signal + forward + back) <= float(np.ravel(bound)[0]) <= 1.0
    assert float(np.ravel(bound)[0]) <= 1.1 * signal / (signal + forward)
    assert enough.all()


def test_the_veil_is_bounded_at_each_altitude_by_that_of_the_image() -> None:
    """In turbid water no less than the bound in any image, at 2 m as at 2.5 m, and not half as much again."""
    search = one(wanted=FAST, scenes=TURBID, vehicle={"altitude_tolerance_m": 0.5}).searcher()
    rows = np.arange(len(search.prepare()))
    light = search.tables.exact(0, search.tables.lightings[0], rows)
    assert light.forward_e is not None
    veil = (light.forward_e / light.signal_e)[:, [-1, search.problem.scenes[0].nominal]]
    bound = search.bounds.needs.least_veil(0, rows)
    assert (bound <= veil).all() and (veil <= 1.5 * bound).all()


def test_a_contrast_that_the_forward_veil_forbids_is_discarded() -> None:
    """Nothing is discarded at the image's own contrast; beyond what the bound leaves everything is."""
    search = one("contrast", wanted=FAST).searcher()
    search.prepare()
    bound = float(np.ravel(search.bounds._contrast_bound(search.tables.lightings[0], np.arange(1))[0])[0])
    for share, found in ((0.999, 1), (1.001, 0)):
        wanted = {**FAST, "min_contrast": share * bound}
        other = one("contrast", wanted=wanted).searcher()
        other.prepare()
        assert int((other.bounds.of_nodes(0, np.arange(1)).rule < 0).sum()) == found


# ---------------------------------------------------------------- small things that bounds are made of


def test_the_least_of_each_number_and_all_after_it() -> None:
    """A light without power has no number and does not count."""
    assert suffix_min(np.array([3.0, 1.0, np.nan, 2.0, 5.0])).tolist() == [1.0, 1.0, 2.0, 2.0, 5.0]


def test_large_and_small_search_agree_on_the_best_of_the_enumeration(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both find it, with every bound at work."""
    from uwopt.solvers.exact import search as exact_search

    for place, names in ((exact_search, ("FIRST_BATCH", "LARGEST_BATCH")), (large, ("FIRST_LEAVES",)),
                         (tree, ("FIRST_ROWS", "FIRST_NODES", "LARGEST_LISTED"))):  # fmt: skip
        for name in names:
            monkeypatch.setattr(place, name, 1)
    monkeypatch.setattr(exact_search, "TOO_FEW_TO_BOUND", 0)
    evaluated = []
    for name in SEARCHED:
        best = known(name).least()
        assert best is not None
        for most in (10**9, 0):
            monkeypatch.setattr(exact_search, "MOST_IMAGERS", most)
            outcome = world(name).solve(top=1)[1]
            assert outcome.best[0].minimised == pytest.approx(best.value, abs=2e-3 * best.scale), name
            assert outcome.account.adds_up()
            evaluated.append(outcome.account.evaluated / outcome.account.total)
    assert np.mean(evaluated) < MOSTLY_BOUNDED, "bounds keep most combinations from being evaluated"

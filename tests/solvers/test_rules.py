"""Every rule that discards, on either side of its limit: what it throws away is infeasible, and no more than that.

One design whose numbers are worked out by hand is put a millionth inside and outside of each limit. A rule
without a case here makes a test fail. What `brute_force` says, which shares no code with the search, must agree.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import brute_force as brute
import numpy as np
import pytest
from one_of_each import (
    CLOSER,
    COVERED_M,
    DISTANCE_M,
    N_WATER,
    RATE_HZ,
    one,
    virtual_image_m,
    with_parts,
)
from random_cases import Case
from scipy.optimize import brentq
from scipy.special import j1

from uwopt.catalog.parts.quantity import Curve
from uwopt.catalog.records import Housing, exact
from uwopt.solvers.exact import large, tree
from uwopt.solvers.exact import search as exact_search
from uwopt.solvers.exact.account import RULES
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.imagers import IMAGER_RULES, enumerate_imagers, fitting_pairs
from uwopt.solvers.exact.node_bounds import NODE_RULES
from uwopt.solvers.exact.outline import Level, OutlineRows
from uwopt.solvers.exact.port_groups import port_tree
from uwopt.solvers.exact.search import Search

NEAR = 1e-6


@dataclass(frozen=True)
class Limit:
    """A limit on one number: the key of `one` and of the field, and the value at which the design just fits."""

    place: str
    name: str
    value: float
    least: bool  # the design fits at this value and above; else and below
    near: float = NEAR
    more: Mapping[str, Any] = field(default_factory=dict)  # beside it

    def case(self, *, fits: bool, objective: Any = "power") -> Case:
        """The design just inside, or just outside."""
        up = 1.0 if self.least == fits else -1.0
        value = self.value * (1.0 + up * self.near)
        given = {**self.more, self.place: {**self.more.get(self.place, {}), self.name: value}}
        return one(objective, **given)


@cache
def f_number_of_depth(depth_m: float) -> float:
    """The least f-number at which the forward model sees a depth sharp, by bisection of its margins."""
    made = one(wanted={**SHARP, "min_dof_m": depth_m}, vehicle=DEEP)
    problem = made.problem()
    model = brute.Bench(problem).model(next(iter(brute.buildable(problem))))
    low, high = 1.0, 64.0

    def missed(f_number: float) -> bool:
        settings = [{"time_s": 1e-3, "level": 1.0, "f_number": f_number}]
        return any(
            text.startswith(("dof", "min_dof")) for text in brute.margins_missed(model, settings, 1e-9)
        )

    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if missed(middle) else (low, middle)
    return high


DEEP, SHARP = {"altitude_tolerance_m": 0.3}, {"circle_of_confusion_px": 0.2}
TILT = 0.625  # tangent of the corner: 5 mm of image over 8 mm


TWO_HOURS = {"vehicle": {"duration_h": 2.0}}
PAIR = {"vehicle": {"camera_count": 2, "camera_baseline_m": 0.5}}
RATED = {"catalog": {"lens_rating": "limit"}}
SHORT = {"limits": {"max_exposure_ms": 0.5}, "wanted": {"max_blur_px": 9.0}}


#: A body of 50 mm across its corners in a tube of 100 mm, 77 mm and the body's length behind the pupil.
HOUSED = {
    "camera": {"body_width_mm": 30.0, "body_height_mm": 40.0, "body_length_mm": 20.0, "plug_mm": 45.0},
    "lens": {"length_mm": 50.0, "diameter_mm": 30.0, "pupil_mm": 20.0},
    "port": {"housing": Housing(
        "tube", inner_diameter_mm=100.0, inner_length_mm=112.0, outer_diameter_mm=exact(110.0),
        outer_length_mm=exact(200.0), mass_g=exact(2500.0), ports=("dome",),
    )},
    "catalog": {"housing": "required"},
}  # fmt: skip
IN_WATER_KG = 0.8 + 2.5 - 1025.0 * np.pi * (0.11**2 * 0.2 / 4.0 + 0.08**3 * 2.0 / 3.0)
OF_SEVERAL = "better_housing"  # takes two housings: tests/solvers/test_housings.py
ALONE = tuple(rule for rule in IMAGER_RULES if rule != OF_SEVERAL)


@cache
def imager_limits() -> dict[str, Limit]:
    """What each rule of imagers looks at."""
    return {
        "image_circle": Limit("lens", "image_circle_mm", 10.0 / 1.02, least=True),
        "lens_rating": Limit("lens", "rated_pixel_pitch_um", 4.0 * 1.02, least=False, more=RATED),
        "view": Limit("port", "clear_diameter_mm", 2 * TILT * 50.0, least=True, more={"flat": True}),
        # seen at tangents of 0.375 along the motion, the far edge lies at 1 / (1 - 0.375 tan pitch) of the axis
        "horizon": Limit("vehicle", "pitch_deg", float(np.rad2deg(np.arctan(0.8 / 0.375))), least=False),
        "focus": Limit("lens", "min_object_distance_m", virtual_image_m(N_WATER), least=False),
        "max_gsd_mm": Limit("wanted", "max_gsd_mm", 0.5e-3 * DISTANCE_M * 1e3, least=True),
        "min_swath_m": Limit("wanted", "min_swath_m", COVERED_M, least=False),
        # 0.5 m less of two cameras half a metre apart; half a pixel of disparity: 0.5 px (p / f) Z^2 / B
        "min_common_swath_m": Limit("wanted", "min_common_swath_m", COVERED_M - 0.5, least=False, more=PAIR),
        "max_depth_error_mm": Limit("wanted", "max_depth_error_mm", 0.5 * 0.5 * DISTANCE_M**2 / 0.5, least=True,
                                    more=PAIR),
        "frame_rate": Limit("camera", "max_frame_rate_hz", RATE_HZ, least=True),
        "data_rate_mb_s": Limit("limits", "data_rate_mb_s", 4.5 * RATE_HZ, least=True),
        "lens_stop_down": Limit("lens", "f_number_max", 2.0 * 2.0**0.75, least=True,
                                more={"wanted": {"lens_stop_down": 1.5}}),
        "min_dof_m": Limit("lens", "f_number_max", f_number_of_depth(0.6), least=True, near=1e-5,
                           more={"wanted": {**SHARP, "min_dof_m": 0.6}, "vehicle": DEEP}),
        "max_blur_px": Limit("camera", "min_exposure_us", 500.0, least=False, more=SHORT),
        "housing": Limit("camera", "body_length_mm", 112.0 - 30.0 - 45.0 - 2.0, least=False, more=HOUSED),
        "size_mm": Limit("limits", "size_mm", 200.0 + 80.0, least=True, more=HOUSED),
        # the dome of 80 mm is wider than the tube of 110 mm
        "diameter_mm": Limit("limits", "diameter_mm", 2 * 80.0, least=True, more=HOUSED),
        "mass_water_kg": Limit("limits", "mass_water_kg", IN_WATER_KG, least=True, more=HOUSED),
        "cost": Limit("limits", "cost", 1800.0, least=True),
        "mass_kg": Limit("limits", "mass_kg", 0.8, least=True),
        "power_w": Limit("limits", "power_w", 3.0, least=True),
        "storage_gb": Limit("limits", "storage_gb", 4.5 * RATE_HZ * 2 * 3.6, least=True, more=TWO_HOURS),  # MB/s
        "card_gb": Limit("camera", "storage_gb", 4.5 * RATE_HZ * 2 * 3.6, least=True, more=TWO_HOURS),
        "energy_wh": Limit("limits", "energy_wh", 3.0 * 2, least=True, more=TWO_HOURS),
    }  # fmt: skip


PIECE = {"complete": "whole"}  # of that complete camera
#: Rules without a number: parts that go together, and parts that do not. Ports are asked last, of outlines too.
TOGETHER = {
    "mount": {True: one(), False: one(lens={"mounts": ("S",)})},
    "complete": {True: one(camera=PIECE, lens=PIECE, port=PIECE), False: one(camera=PIECE, lens=PIECE)},
}
NAMES = tuple(rule for rule in ALONE if rule != "mount")


def sides(rule: str, *, fits: bool) -> Case:
    """The design on one side of a rule's limit."""
    return TOGETHER[rule][fits] if rule in TOGETHER else imager_limits()[rule].case(fits=fits)


# ---------------------------------------------------------------- imagers


def test_every_rule_of_imagers_has_a_case() -> None:
    """A new rule needs a limit above, or parts that do not go together."""
    assert set(IMAGER_RULES) == {*TOGETHER, OF_SEVERAL, *imager_limits()}


@pytest.mark.parametrize("rule", ALONE)
def test_a_rule_discards_what_is_a_millionth_outside(rule: str) -> None:
    """That imager, and under this rule's name."""
    imagers = enumerate_imagers(sides(rule, fits=False).problem())
    assert len(imagers) == 0
    assert {name: count for name, count in imagers.tally.discarded.items() if count} == {rule: 1}


@pytest.mark.parametrize("rule", ALONE)
def test_a_rule_keeps_what_is_a_millionth_inside(rule: str) -> None:
    """Nothing is discarded."""
    imagers = enumerate_imagers(sides(rule, fits=True).problem())
    assert len(imagers) == 1 and not any(imagers.tally.discarded.values())


@pytest.mark.parametrize("fits", [False, True])
def test_the_rim_of_a_spherical_cap_must_be_clear_of_the_corner(fits: bool) -> None:
    """70 mm inside, seen from its middle at a tangent of 0.625: the rim is as far aside as 70 mm sin(atan(0.625))."""
    width_mm = 140.0 * np.sin(np.arctan(TILT)) * (1.0 + (NEAR if fits else -NEAR))
    found = enumerate_imagers(one(port={"clear_diameter_mm": exact(width_mm)}).problem())
    assert (len(found), found.tally.discarded["view"]) == ((1, 0) if fits else (0, 1))


@pytest.mark.parametrize("rule", [rule for rule in ALONE if rule != "lens_rating"])
def test_what_a_rule_of_imagers_discards_has_no_feasible_settings(rule: str) -> None:
    """Enumeration finds none; that a lens is softer than its sensor is a wish that it does not know."""
    case_ = sides(rule, fits=False)
    bench = brute.Bench(case_.problem())
    for hardware in brute.buildable(bench.problem):
        assert not np.isfinite(brute.best_of(bench, hardware, case_.objective).value)


@pytest.mark.parametrize("piece", ["camera", "lens", "port"])
@pytest.mark.parametrize("whole", [False, True])
def test_a_piece_of_a_complete_camera_goes_with_its_own_alone(piece: str, whole: bool) -> None:
    """Neither among common parts, nor a common part, or another camera's, in its place."""
    others = {kind: PIECE for kind in ("camera", "lens", "port") if whole and kind != piece}
    for of in ("", "other") if whole else ("whole",):
        imagers = enumerate_imagers(one(**others, **{piece: {"complete": of}}).problem())
        assert len(imagers) == 0
        assert {name: count for name, count in imagers.tally.discarded.items() if count} == {"complete": 1}


def test_discarded_imagers_are_counted_with_all_their_lamps_and_numbers() -> None:
    """Two lamps in one to three: six combinations behind the lens that does not fit."""
    case_ = with_parts(one(lens={"mounts": ("S",)}, vehicle={"light_count": [1, 3]}), lights=[{}])
    account = case_.solve()[1].account
    assert account.total == 6 and account.discarded["mount"] == 6


# ---------------------------------------------------------------- outlines


#: Before outlines, or of imagers.
ASKED_ELSEWHERE = ("image_circle", "lens_rating", "view", "size_mm", "diameter_mm", "mass_water_kg")
OUTLINED = tuple(rule for rule in NAMES if rule not in ASKED_ELSEWHERE)


def outline(case_: Case) -> dict[str, bool]:
    """What each rule of an outline says of the one design."""
    problem = case_.problem()
    level, pairs, none = Level(problem, port_tree(problem)[-1]), fitting_pairs(problem), np.zeros(1, int)
    rows = OutlineRows(pairs.camera, pairs.lens, np.ones(1, bool), none)
    return {name: bool(passes[0]) for name, passes in level.rules(rows, level.imagers(rows))}


def test_every_rule_of_outlines_has_a_case() -> None:
    """What is not asked there is asked of pairs before, or of imagers after."""
    assert set(outline(one())) == set(OUTLINED)


@pytest.mark.parametrize("rule", OUTLINED)
def test_an_outline_discards_what_is_outside(rule: str) -> None:
    """Behind a single port its numbers are the imager's own, so the rule is as sharp."""
    assert next(name for name, passes in outline(sides(rule, fits=False)).items() if not passes) == rule


@pytest.mark.parametrize("rule", OUTLINED)
def test_an_outline_keeps_what_is_inside(rule: str) -> None:
    """Nothing is discarded that an imager's rule keeps."""
    assert all(outline(sides(rule, fits=True)).values())


# ---------------------------------------------------------------- lights of nodes


@cache
def needed(physics: str) -> tuple[float, float]:
    """Flux that the one lamp must have, and power that the design draws then, by enumeration."""
    case_ = one(physics=physics, wanted=FAST)
    bench = brute.Bench(case_.problem())
    best = brute.best_of(bench, next(iter(brute.buildable(bench.problem))), case_.objective)
    return best.settings[0]["level"] * 30_000.0, best.power_w


FAST = {"max_blur_px": 1.0, "min_snr_db": 26.0}
LOOSE = 0.99  # in physics `paper` bounds are exact but for quantisation: a part in a thousand here


def unit_limit(rule: str, *, fits: bool) -> Case:
    """The one lamp on either side of a rule of nodes; outside of light and power by what bounds leave out."""
    flux_lm, power_w = needed("paper")
    share = 1.0001 if fits else LOOSE
    sharp = 1.001 if fits else LOOSE  # the middle of green light in that water is 550.04 nm
    exactly = 1.0 + (NEAR if fits else -NEAR)
    given: dict[str, Any] = {
        "light": {"light": {"flux_lm": flux_lm * share, "power_w": flux_lm * share / 100.0}},
        "cost": {"limits": {"cost": 2300.0 * exactly}},
        "mass_kg": {"limits": {"mass_kg": 1.3 * exactly}},
        "power_w": {"limits": {"power_w": power_w * share}},
        "energy_wh": {"limits": {"energy_wh": power_w * 2.0 * share}, **TWO_HOURS},
        "max_white_balance": {"camera": COLOURED, "wanted": {**FAST, "max_white_balance": 4.0 * share}},
        "min_mtf_half_nyquist": SHARP_AT_16 | {"wanted": {**FAST, "min_mtf_half_nyquist": contrast(0.25) / sharp}},
        "resolve_mm": SHARP_AT_16 | {"wanted": {**FAST, "resolve_mm": narrowest_mm() * sharp}},
    }[rule]
    return one(**{"physics": "paper", "wanted": FAST, **given})


#: Green light alone through a lens of one opening that blurs nothing: the pixel, diffraction and defocus are left.
SHARP_AT_16 = {
    "physics": "full", "camera": {"qe_curves": {"mono": Curve((540.0, 550.0, 560.0), (0.0, 0.5, 0.0))}},
    "lens": {"f_number_min": 16.0, "f_number_max": 16.0, "rated_pixel_pitch_um": 0.01},
    "light": {"flux_lm": 1e8, "power_w": 1e6},
}  # fmt: skip


def contrast(cycles_per_px: float, disc_px: float = 0.0) -> float:
    """What a pixel, a pupil (Goodman, section 6.3) and a disc leave of bars: N_w = 16 / (1 - f D), 4 um."""
    at = cycles_per_px * 0.55 * 16.0 / CLOSER / 4.0
    pupil = 2.0 / np.pi * (np.arccos(at) - at * np.sqrt(1.0 - at**2))
    out = np.pi * disc_px * cycles_per_px
    return float(np.sinc(cycles_per_px) * pupil * (2.0 * j1(out) / out if out else 1.0))


def narrowest_mm() -> float:
    """Bars of which a tenth of the contrast arrives in the corner, on pixels of 1.04 mm: half a cycle each.

    The lens stands for the middle, 1 / V. At 80 % of the way to the corner, a tangent of 0.5, the floor is farther and
    the dome shows it at (1 / V - (1 / r - 1 / r') / n) / cos; the disc is f^2 / (1 - f D) / (p N) times the difference.
    """
    aside = np.hypot(1.0, 0.5)
    middle = 1.0 / virtual_image_m(N_WATER)
    corner = (middle - (1.0 - 1.0 / aside) / DISTANCE_M / N_WATER) * aside
    disc_px = 8e-3**2 * (corner - middle) / CLOSER / (4e-6 * 16.0)
    cycles = brentq(lambda nu: contrast(nu, disc_px) - 0.1, 0.1, 0.42)
    return 1.04 / (2.0 * cycles)


#: Red has a quarter of green's electrons, whatever the light and the water.
COLOURED = {
    "colour": "colour", "qe_curves": {
        name: Curve((380.0, 780.0), (share, share)) for name, share in (("red", 0.2), ("green", 0.8), ("blue", 0.4))
    },
}  # fmt: skip


def unit_rules(case_: Case) -> list[str]:
    """Rules that discard the one unit."""
    search = case_.searcher()
    search.prepare()
    bounds = Bounds(search.objective, search.tables)
    return [NODE_RULES[int(rule)] for rule in bounds.of_nodes(0, np.arange(1)).rule if rule >= 0]


IN_TABLES = tuple(rule for rule in NODE_RULES if rule != "bound")
@pytest.mark.parametrize("rule", IN_TABLES)
def test_a_unit_falls_when_its_light_is_outside(rule: str) -> None:
    """A hundredth less light or power than the enumeration needs is enough, a millionth of the others."""
    assert unit_rules(unit_limit(rule, fits=False)) == [rule]


@pytest.mark.parametrize("rule", IN_TABLES)
def test_a_unit_stays_when_its_light_is_inside(rule: str) -> None:
    """What the enumeration finds feasible is not discarded."""
    assert unit_rules(unit_limit(rule, fits=True)) == []


LED = {
    "kind": "pulsed_led", "min_pulse_us": 1.0, "max_pulse_us": 2000.0, "max_duty_frac": exact(1.0),
    "max_rate_hz": exact(50.0),
}  # fmt: skip


def test_a_lamp_that_cannot_keep_up_with_the_images_falls() -> None:
    """0.284 pulses a second are asked."""
    for share, found in ((1.0 - NEAR, ["light"]), (1.0 + NEAR, [])):
        light = {**LED, "max_rate_hz": exact(RATE_HZ * share)}
        assert unit_rules(one(light=light, wanted=FAST)) == found


SLOW_HZ, QUICK_HZ = RATE_HZ * (1.0 - NEAR), RATE_HZ * (1.0 + NEAR)


@pytest.mark.parametrize(
    ("rate_hz", "other_share", "other_hz", "found"),
    [(SLOW_HZ, 1e-3, QUICK_HZ, ["light"]), (QUICK_HZ, 1e-3, SLOW_HZ, []), (QUICK_HZ, 2.0, SLOW_HZ, [])],
)
def test_a_unit_falls_when_no_lamp_is_both_bright_and_quick_enough(
    rate_hz: float, other_share: float, other_hz: float, found: list[str]
) -> None:
    """One lamp is bright enough; another of its beam has a share of its light."""
    flux_lm = other_share * 30_000.0
    case_ = with_parts(
        one(light={**LED, "max_rate_hz": exact(rate_hz)}, wanted=FAST),
        lights=[{"max_rate_hz": other_hz, "flux_lm": flux_lm, "power_w": flux_lm / 100.0}],
    )
    assert unit_rules(case_) == found


# ---------------------------------------------------------------- the whole search


def as_if_large(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search of pairs for the one design."""
    monkeypatch.setattr(exact_search, "MOST_IMAGERS", 0)


def test_rules_of_all_searches_are_known_here() -> None:
    """The certificate lists no other rule."""
    assert set(RULES) == {*IMAGER_RULES, *NODE_RULES}


@pytest.mark.parametrize("way", ["small", "large"])
@pytest.mark.parametrize("rule", ALONE)
def test_a_search_counts_what_a_rule_of_imagers_discards(
    rule: str, way: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One combination, discarded by that rule, and nothing found."""
    if way == "large":
        as_if_large(monkeypatch)
    outcome = sides(rule, fits=False).solve()[1]
    assert not outcome.best and outcome.complete
    assert {name: count for name, count in outcome.account.discarded.items() if count} == {rule: 1}


@pytest.mark.parametrize("way", ["small", "large"])
@pytest.mark.parametrize("rule", IN_TABLES)
def test_a_search_counts_what_a_rule_of_units_discards(
    rule: str, way: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same for the light's rules."""
    monkeypatch.setattr(exact_search, "TOO_FEW_TO_BOUND", 0)
    if way == "large":
        as_if_large(monkeypatch)
    outcome = unit_limit(rule, fits=False).solve()[1]
    assert not outcome.best and outcome.complete
    assert {name: count for name, count in outcome.account.discarded.items() if count} == {rule: 1}


@pytest.mark.parametrize("rule", ["cost", "mass_kg"])
def test_a_search_that_does_not_bound_drops_designs_over_budget(rule: str) -> None:
    """Few nodes are evaluated without bounds; their lights are held against the limits all the same."""
    outcome = unit_limit(rule, fits=False).solve()[1]
    assert not outcome.best
    assert outcome.account.discarded[rule] == 1 and outcome.account.evaluated == 0


@pytest.mark.parametrize("way", ["small", "large"])
def test_a_search_counts_what_cannot_win(way: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two cameras, one drawing 1000 W, the other is never evaluated."""
    if way == "large":
        as_if_large(monkeypatch)
    for module, names in (
        (exact_search, ("FIRST_BATCH",)),
        (tree, ("FIRST_ROWS", "FIRST_NODES")),
        (large, ("FIRST_LEAVES",)),
    ):
        for name in names:
            monkeypatch.setattr(module, name, 1)
    case_ = with_parts(one(wanted=FAST), cameras=[{"power_w": 1000.0}])
    outcome = case_.solve(top=1)[1]
    assert {name: count for name, count in outcome.account.discarded.items() if count} == {"bound": 1}
    assert outcome.account.evaluated == 1 and outcome.account.total == 2


def test_cameras_beyond_a_ceiling_are_counted_as_bounded() -> None:
    """Only what draws less than 900 W is wanted."""
    case_ = with_parts(one(wanted=FAST), cameras=[{"power_w": 1000.0}])
    search: Search = case_.searcher(ceiling=900.0)
    outcome = search.run()
    assert outcome.account.discarded["bound"] == 1 and outcome.account.adds_up()
    assert [found.camera for found in outcome.best] == [0]

"""Doubt by hand: which end of an estimate harms, what the regret is, and which quotes matter."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml
from one_of_each import one, with_parts

from uwopt.catalog.parts.housing import Housing
from uwopt.catalog.parts.part import OF_A_DESIGN
from uwopt.catalog.parts.quantity import Quantity, exact
from uwopt.deadline import NEVER
from uwopt.forward.assembly import load_catalog
from uwopt.mission.mission import load_mission
from uwopt.objectives.objective import Objective
from uwopt.solvers.explain.assumptions import assumptions, field_unit
from uwopt.solvers.explain.lamp_places import missed_when_leaning
from uwopt.solvers.explain.robustness import at_worst, doubtful, mixed_problem, robustness
from uwopt.solvers.one_hardware import among, at_end, best_of_each, problem_of
from uwopt.solvers.recommend import Sought, evaluated, seek

ROOT = Path(__file__).parents[2]
FAST = {"max_blur_px": 1.0, "min_snr_db": 26.0}


def between(low: float, value: float, high: float) -> Quantity:
    """A number that is estimated."""
    return Quantity(value, low, high, "estimated")


PRICES = {"price": between(900.0, 1000.0, 1500.0)}
RIVAL = {"price": between(950.0, 1100.0, 1200.0)}


@cache
def sought(objective: str = "cost") -> Sought:
    """Two cameras that differ by their price alone, which nobody has quoted."""
    case_ = with_parts(one(objective, wanted=FAST, camera=PRICES), cameras=[RIVAL])
    search, outcome = case_.solve(top=2)
    return Sought(None, search.problem, search, outcome)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "bad", "good"),
    [("price", 3.0, 1.0), ("mass_g", 3.0, 1.0), ("power_w", 3.0, 1.0), ("read_noise_e", 3.0, 1.0),
     ("saturation_e", 1.0, 3.0), ("max_gain_db", 1.0, 3.0), ("max_frame_rate_hz", 1.0, 3.0)],
)  # fmt: skip
def test_the_bad_end_of_a_camera_harms(name: str, bad: float, good: float) -> None:
    """What one wants less of is bad when high."""
    camera: Any = replace(one().parts.cameras[0], **{name: between(1.0, 2.0, 3.0)})
    assert getattr(at_end(camera, "bad"), name).value == bad
    assert getattr(at_end(camera, "good"), name).value == good


def test_the_bad_end_of_a_lamp_is_its_dim_one() -> None:
    """Less flux for more power."""
    lamp: Any = replace(
        one().parts.lights[0], flux_lm=between(1e4, 2e4, 3e4), power_w=between(100.0, 200.0, 300.0)
    )
    bad = at_end(lamp, "bad")
    assert (bad.flux_lm.value, bad.power_w.value) == (1e4, 300.0)


def test_one_number_alone_can_be_put_at_an_end() -> None:
    """The others stay."""
    camera: Any = replace(one().parts.cameras[0], price=between(1.0, 2.0, 3.0), mass_g=between(1.0, 2.0, 3.0))
    bad = at_end(camera, "bad", only="mass_g")
    assert (bad.price.value, bad.mass_g.value) == (2.0, 3.0)


def test_only_what_no_source_states_is_doubtful() -> None:
    """A range that is published is none."""
    camera: Any = replace(
        one().parts.cameras[0], price=between(1.0, 2.0, 3.0), mass_g=Quantity(2.0, 1.0, 3.0, "published")
    )
    assert [name for name, _ in doubtful(camera)] == ["price"]


def test_rivals_stand_at_their_good_end_and_the_winner_at_its_bad_one() -> None:
    """1500 against 950."""
    found = sought().outcome.best[0]
    bad = {kind: at_end(part, "bad") for kind, part in sought().problem.parts.of(found).items()}
    mixed = mixed_problem(sought().problem, bad)
    assert [camera.price.value for camera in mixed.parts.cameras] == [1500.0, 950.0]


def test_the_regret_is_what_a_rival_saves_at_worst() -> None:
    """The winner at 1500, its rival at 950: 550 USD."""
    doubt = robustness(sought())
    assert doubt is not None
    assert doubt["max_regret"] == pytest.approx(550.0)
    assert doubt["value_at_bad_end"] == pytest.approx(1500.0 + 500.0 + 300.0 + 500.0)
    assert doubt["rival"]["camera"] == "camera-0" and doubt["feasible_at_bad_end"]


def test_the_quotes_that_matter_are_those_that_change_the_choice() -> None:
    """The winner at 1500 loses against 1100; the rival at 950 wins against 1000."""
    doubt = robustness(sought())
    assert doubt is not None
    assert {(quote["part"], quote["field"]) for quote in doubt["quotes_that_matter"]} == {
        ("camera", "price"), ("camera-0", "price"),
    }  # fmt: skip


def test_variants_of_a_lamp_are_each_worth_what_they_are_alone() -> None:
    """Of one optics, so in one light: at 500 and at 800 USD beside 1000 + 500 + 300."""
    problem, found = sought().problem, sought().outcome.best[0]
    lists: dict[str, list[Any]] = {kind: [part] for kind, part in problem.parts.of(found).items()}
    lists["light"].append(replace(lists["light"][0], price=exact(800.0)))
    places = [dict.fromkeys(OF_A_DESIGN, 0) | {"light": light} for light in (1, 0, 1)]
    values = best_of_each(problem_of(problem, found, lists=lists), sought().search.objective, places)
    assert values == pytest.approx([2600.0, 2300.0, 2600.0])


def test_a_rival_that_stands_twice_among_the_mixed_is_one_of_the_catalogue() -> None:
    """Each camera listed three times: the last is the second of the catalogue, which the mixed problem has sixth."""
    base = sought()
    thrice = replace(base.problem.parts, cameras=tuple(part for part in base.problem.parts.cameras for _ in range(3)))
    mixed: Any = SimpleNamespace(parts=thrice)
    assert among(base.problem, replace(base.outcome.best[0], camera=5), mixed).camera == 1


def test_a_rival_keeps_its_housing_among_the_catalogue() -> None:
    base = sought()
    port = base.problem.parts.ports[0]
    built = tuple(replace(port, housing=Housing(name, inner_diameter_mm=100.0)) for name in ("small", "large"))
    with_both: Any = SimpleNamespace(parts=replace(base.problem.parts, ports=built))
    turned: Any = SimpleNamespace(parts=replace(base.problem.parts, ports=built[::-1]))
    rival = replace(base.outcome.best[0], port=0)  # in the large one there
    assert among(with_both, rival, turned).port == 1



def test_a_price_does_not_matter_where_none_is_asked_for() -> None:
    """Least power knows no money."""
    doubt = robustness(sought("power"))
    assert doubt is not None and doubt["quotes_that_matter"] == []


def test_assumptions_name_the_estimate_with_its_range() -> None:
    """As a result shows it."""
    found = assumptions(sought().problem, sought().outcome.best[0])
    price = next(item for item in found if item["path"] == "camera.price")
    assert (price["low"], price["value"], price["high"], price["unit"]) == (900.0, 1000.0, 1500.0, "USD")


RADIUS = between(60.0, 80.0, 100.0)


def doubt_of_a_dome(wanted: dict[str, Any], lens: dict[str, Any]) -> tuple[Sought, dict[str, Any]]:
    """A dome of 60 to 100 mm beside a dearer one of 80 mm, at 400 instead of 300 USD."""
    case_ = with_parts(
        one("cost", wanted=wanted, lens=lens, port={"outer_radius_mm": RADIUS}),
        ports=[{"outer_radius_mm": exact(80.0), "price": 400.0}],
    )
    search, outcome = case_.solve(top=2)
    sought_ = Sought(None, search.problem, search, outcome)  # type: ignore[arg-type]
    doubt = robustness(sought_)
    assert doubt is not None
    return sought_, doubt


@pytest.mark.parametrize(
    ("wanted", "lens", "end"),
    [
        # 1 / q' = 1 / (n (2 m + R)) + (1/1.5 - 1/n) / R + (1 - 1/1.5) / (R - 10 mm) with n near 1.34: the lens looks
        # at 0.24 m behind 80 mm, at 0.175 m behind 60 mm, and focuses from 0.2 m on
        ({}, {"min_object_distance_m": 0.2}, "low"),
        # (2 m + R) 4 um / 8 mm: 1.04 mm behind 80 mm, 1.05 mm behind 100 mm
        ({"max_gsd_mm": 1.045}, {}, "high"),
    ],
)
def test_a_dome_whose_radius_is_estimated_fails_at_whichever_end_harms(
    wanted: dict[str, Any], lens: dict[str, Any], end: str
) -> None:
    """A small dome brings the virtual image too near, a large one the camera too far."""
    sought_, doubt = doubt_of_a_dome(wanted, lens)
    assert sought_.problem.parts.ports[sought_.outcome.best[0].port].id == "dome"  # the cheaper, as estimated
    assert not doubt["feasible_at_bad_end"]
    assert ("dome", "outer_radius_mm") in {(q["part"], q["field"]) for q in doubt["quotes_that_matter"]}
    ends = {"low": 60.0, "high": 100.0}
    worst, _ = at_worst(sought_.problem, sought_.outcome.best[0], sought_.search.objective, NEVER)
    assert worst["port"].outer_radius_mm.value == ends[end]  # type: ignore[attr-defined]


def test_a_rival_dome_may_have_any_radius_of_its_range() -> None:
    """Once as estimated, once at either end; a dome whose radius is known stands there once."""
    case_ = with_parts(one("cost"), ports=[{"outer_radius_mm": RADIUS, "price": 400.0}])
    search, outcome = case_.solve(top=2)
    bad = search.problem.parts.of(outcome.best[0])  # the one of 300 USD, whose radius is known
    mixed = mixed_problem(search.problem, bad)
    radii = [port.outer_radius_mm.value for port in mixed.parts.ports if port.outer_radius_mm]
    assert sorted(radii) == [60.0, 80.0, 80.0, 100.0]


def test_lamps_may_lean_until_the_reserve_is_used_up() -> None:
    # Held is the same SNR: 26 dB with 4 dB of reserve, or 30 dB with none. Least power is at what is held, so that
    # any lean misses it; 4 dB are 1.6 times the light or more, and few degrees of wide lamps lose no such share.
    # The mean level, which is held to 2 %, goes with the light: a gain sets it anew.
    plain = yaml.safe_load((ROOT / "problems" / "reef-mosaic.yaml").read_text(encoding="utf-8"))
    plain["catalog"] = {
        "cameras": ["avt-alvium-1800-c-234m"], "lenses": ["thorlabs-mvl16m1"],
        "ports": ["blue-robotics-4-in-dome-aluminium-ring-2026"],
        "lights": ["arctic-rays-dragonfish-mini-strobe-65deg"],
    }  # fmt: skip
    goal = Objective.of("power")
    missed = {}
    for reserve_db in (0.0, 4.0):
        requirements = plain["requirements"] | {"min_snr_db": 30.0 - reserve_db, "mean_level": 0.3}
        mission = load_mission(plain | {"requirements": requirements, "reserve": {"snr_db": reserve_db}})
        sought = seek(mission, load_catalog(mission), goal, generic="never", top=1)
        found = sought.outcome.best[0]
        design = evaluated(sought.problem, found, goal)
        missed[reserve_db] = [
            missed_when_leaning(problem_of(sought.problem, found), found, design, by) for by in (-4.0, 4.0)
        ]
    assert any("min_snr_db" in names for names in missed[0.0])
    assert not any({"min_snr_db", "mean_level"} & {*names} for names in missed[4.0])


def test_every_doubtful_number_of_a_lens_has_its_unit() -> None:
    """The pixel that a lens serves stood without one: what to ask the maker for was "2.80"."""
    lens = load_catalog().lenses[0]
    told = {name: field_unit(name, lens) for name in ("aberration_pitch_um", "pupil_mm", "transmission_frac", "price")}
    assert told == {"aberration_pitch_um": "µm", "pupil_mm": "mm", "transmission_frac": "", "price": lens.currency}

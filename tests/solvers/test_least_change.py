"""What the text of an infeasible mission says would be enough is enough, and little less is not."""

from __future__ import annotations

import copy
import json
import math
from functools import partial
from itertools import product
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from uwopt.api.practice_left import changed
from uwopt.api.solving import solve
from uwopt.catalog.catalogue import Catalog
from uwopt.deadline import NEVER, Deadline
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.weakened import is_filled_in
from uwopt.objectives.objective import Objective
from uwopt.report.text.helps import depth_lines
from uwopt.report.text.nothing_fits import change_texts
from uwopt.results.basis import WhyNothing
from uwopt.results.result import Result
from uwopt.solvers.exact.certificate import certificate
from uwopt.solvers.infeasible import least_change, least_limit, singles
from uwopt.solvers.infeasible import why_nothing as infeasible
from uwopt.solvers.infeasible.joint_changes import CommonShare, few_that_give, least_set
from uwopt.solvers.infeasible.least_change import Change, Narrowing, fitting, in_rounds, rounded_away
from uwopt.solvers.infeasible.moves import Mover
from uwopt.solvers.infeasible.relaxer import Relaxer
from uwopt.solvers.infeasible.singles import Singles
from uwopt.solvers.infeasible.trials import Trials
from uwopt.solvers.infeasible.why_nothing import together_soon, why_nothing
from uwopt.solvers.recommend import Sought, seek

POWER = Objective.of("power")
FILES = {
    "cameras": "id,colour,resolution_x_px,resolution_y_px,pixel_pitch_um,shutter,mounts,max_frame_rate_hz,bit_depth,"
    "read_noise_e,saturation_e,dark_current_e_s,max_gain_db,black_level_dn,min_exposure_us,max_exposure_us,"
    "exposure_offset_us,prnu_frac,qe,qe_nm,power_w,mass_g,price,currency,price_low,price_high,price_status\n"
    "zz-cam,mono,1936,1216,5.86,global,C,40,12,7,30000,0,36,0,10,1000000,0,0,0.7,530,3,100,500,USD,,,\n"
    "zz-other,mono,1936,1216,5.86,global,C,40,12,7,30000,0,36,0,10,1000000,0,0,0.7,530,2,100,450,USD,400,2000,estimated\n",
    "lenses": "id,focal_length_mm,f_number_min,f_number_max,aperture_control,image_circle_mm,mounts,"
    "transmission_frac,min_object_distance_m,mass_g,price,currency\n"
    "zz-lens,12,1.4,16,manual,16,C,0.9,0.1,100,300,USD\n"
    "zz-wide,8,4,16,manual,16,C,0.9,0.1,100,300,USD\n"
    "zz-corner,5,1.2,16,manual,16,C,0.9,0.1,100,300,USD\n",
    "ports": "id,geometry,refractive_index,thickness_mm,gap_mm,clear_diameter_mm,depth_rating_m,mass_g,price,currency\n"
    "zz-port,flat,1.49,10,0,200,300,500,200,USD\n"
    "zz-deep,flat,1.49,20,0,200,500,2500,900,USD\n",
    "lights": "id,kind,flux_lm,power_w,output_factor,beam,beam_angle_deg,beam_medium,dim_levels,spectrum,"
    "depth_rating_m,mass_g,price,currency\n"
    "zz-led,continuous,20000,200,1,cosine-power,90,water,continuous,generic-led,6000,500,700,USD\n",
}


def written(folder: Path) -> Path:
    """A folder with one camera, two lenses, two ports and one lamp."""
    for name, text in FILES.items():
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
    return folder


def mission(
    parts: Path, lenses: tuple[str, ...] = ("zz-lens",), depth_m: float = 30.0, **asked: Any
) -> Mission:
    """A survey from 2 m with these requirements."""
    files = [str(parts / f"{name}.csv") for name in FILES]
    return load_mission(
        {
            "practice": "bare", "name": "a little too much",
            "scene": {"water": "II", "seafloor": "coral", "depth_m": depth_m},
            "vehicle": {
                "altitude_m": 2.0, "speed_m_s": 0.5, "orientation": "landscape", "light_baseline_m": 0.8,
                "light_count": 1,
            },
            "requirements": {"overlap": 0.6, "min_snr_db": 25.0, **asked},
            "catalog": {
                "files": files, "cameras": ["zz-cam"], "lenses": list(lenses), "ports": ["zz-port", "zz-deep"],
                "lights": ["zz-led"], "generic": "never",
            },
            "physics": "paper",
        }
    )  # fmt: skip


def explained(wanted: Mission, catalog: Catalog) -> WhyNothing:
    """Why nothing fits."""
    found = seek(wanted, catalog, POWER, generic="never", top=1)
    assert not found.outcome.best
    proof = certificate(found.selection, found.problem, found.outcome, POWER)
    return why_nothing(Trials(wanted, catalog, POWER, "never"), proof)


def told(wanted: Mission, catalog: Catalog) -> dict[str, float]:
    """Requirements with the limit that is said to be possible."""
    return {item.name: item.needed for item in explained(wanted, catalog).relaxations}


KNOWN: dict[str, WhyNothing] = {}


def known(wanted: Mission, catalog: Catalog) -> WhyNothing:
    """`explained`, once a mission: for those of which several tests read, none with a program that is changed."""
    key = json.dumps(wanted.to_dict(), sort_keys=True)
    if key not in KNOWN:
        KNOWN[key] = explained(wanted, catalog)
    return KNOWN[key]


def told_once(wanted: Mission, catalog: Catalog) -> dict[str, float]:
    """`told`, likewise."""
    return {item.name: item.needed for item in known(wanted, catalog).relaxations}


def fits(wanted: Mission, catalog: Catalog) -> bool:
    """Whether any system does."""
    return bool(seek(wanted, catalog, POWER, generic="never", top=1).outcome.best)


def test_least_blur_is_that_of_the_lamp_at_full_level(parts, catalog):
    # Light is level * time, and blur is proportional to time: the lamp at full level needs the blur of a mission
    # that is met, times its level there.
    asked = dict(max_blur_px=0.1, min_snr_db=30.0)
    met = seek(mission(parts, **{**asked, "max_blur_px": 5.0}), catalog, POWER, generic="never", top=1)
    level = met.outcome.best[0].settings[0]["level"]
    possible = told_once(mission(parts, **asked), catalog)["max_blur_px"]
    assert possible == pytest.approx(5.0 * level, rel=0.03)
    assert possible >= 5.0 * level * (1 - 1e-9)


@pytest.mark.parametrize(
    ("name", "asked"), [("max_blur_px", 0.1), ("min_dof_m", 3.9), ("overlap", 0.995), ("min_swath_m", 9.0)]
)
def test_limit_said_to_be_possible_is_enough_and_a_little_less_is_not(parts, catalog, name, asked):
    base = {"max_blur_px": 1.0} if name != "max_blur_px" else {"min_snr_db": 30.0}
    possible = told_once(mission(parts, **{**base, name: asked}), catalog)[name]
    assert fits(mission(parts, **{**base, name: possible}), catalog)
    assert not fits(mission(parts, **{**base, name: possible + 0.03 * (asked - possible)}), catalog)


@pytest.mark.parametrize(("key", "name", "asked"), [("min_snr_db", "min_snr", 90.0), ("max_gsd_mm", "max_gsd_mm", 0.1)])
def test_best_figure_said_to_be_possible_can_be_typed_and_is_enough(parts, catalog, key, name, asked):
    # what is reached has many digits; as many as are shown must do, or what is typed misses by a hair
    possible = told_once(mission(parts, **{key: asked}), catalog)[name]
    assert possible == float(f"{possible:.3g}")
    assert fits(mission(parts, **{key: possible}), catalog)


def test_the_least_snr_is_that_of_the_pixel_that_is_asked_for(parts, catalog):
    """The lens with the better mean has darker corners: it is not the one that comes nearest."""

    def survey(lenses: tuple[str, ...], snr_db: float, **asked: Any) -> Mission:
        wanted = mission(parts, lenses, min_snr_db=snr_db, max_blur_px=0.5, **asked)
        return wanted.with_changes(physics="full")

    both, darkest = ("zz-lens", "zz-corner"), {"snr_at": "worst_px"}
    possible = told(survey(both, 40.0, **darkest), catalog)["min_snr"]
    assert fits(survey(both, possible, **darkest), catalog)
    assert not fits(survey(both, possible + 0.03 * (40.0 - possible), **darkest), catalog)
    assert not fits(survey(("zz-corner",), possible, **darkest), catalog)
    best_of_mean = told(survey(both, 40.0), catalog)["min_snr"]
    assert not fits(survey(("zz-lens",), best_of_mean), catalog)


def test_least_change_of_swath_takes_the_wider_lens_though_the_other_needs_less_power(parts, catalog):
    both = ("zz-lens", "zz-wide")
    narrow = told_once(mission(parts, min_swath_m=9.0), catalog)["min_swath_m"]
    wide = told(mission(parts, both, min_swath_m=9.0), catalog)["min_swath_m"]
    assert wide == pytest.approx(narrow * 12.0 / 8.0, rel=0.02)
    assert wide == float(f"{wide:.3g}")


def test_a_limit_can_be_typed_where_time_ends_at_other_hardware(parts, catalog, monkeypatch):
    """The wider lens is found a little closer than the narrow one reaches; there is no time to draw it in."""
    asked, both = 9.0, ("zz-lens", "zz-wide")
    wanted = mission(parts, both, min_swath_m=asked)
    narrow = seek(mission(parts, min_swath_m=1.0), catalog, POWER, generic="never", top=1)
    monkeypatch.setattr(least_change, "with_its_hardware", lambda asked, change, relaxed, deadline: change)
    one = Narrowing(
        asked, Change(1.4234, narrow), lambda value: mission(parts, both, min_swath_m=value),
        lambda wanted, turn: seek(wanted, catalog, POWER, generic="never", top=1),
    )  # fmt: skip
    in_rounds([one], NEVER)
    made = one.change
    assert not fits(wanted, catalog) and made.limit == float(f"{made.limit:.3g}")


def test_least_change_of_depth_is_that_of_the_part_rated_deepest(parts, catalog):
    assert told(mission(parts, depth_m=800.0), catalog)["depth_rating_m"] == 500.0


KEPT = {"snr_db": 3.0, "blur": 0.2, "swath": 0.1, "dof": 0.1, "depth": 1.25}


@pytest.mark.parametrize(
    ("key", "name", "asked", "taken_off"),
    [
        ("min_snr_db", "min_snr", 90.0, lambda reached: reached - 3.0),
        ("min_swath_m", "min_swath_m", 9.0, lambda reached: reached / 1.1),
    ],
    ids=["min_snr", "min_swath_m"],
)
def test_what_is_possible_is_told_without_the_reserve(parts, catalog, key, name, asked, taken_off):
    plain = mission(parts, **{key: asked})
    reached = told_once(plain, catalog)[name]
    possible = told(plain.with_changes(reserve=KEPT), catalog)[name]
    assert possible == pytest.approx(taken_off(reached), rel=0.01)  # limits are rounded to three digits


@pytest.mark.parametrize(("name", "asked"), [("max_blur_px", 0.1), ("min_dof_m", 3.9)])
def test_limit_said_to_be_possible_with_a_reserve_is_enough(parts, catalog, name, asked):
    base = {"max_blur_px": 1.0} if name != "max_blur_px" else {"min_snr_db": 27.0}

    def kept(**wanted):
        return mission(parts, **{**base, **wanted}).with_changes(reserve=KEPT)

    possible = told(kept(**{name: asked}), catalog)[name]
    assert fits(kept(**{name: possible}), catalog)
    assert not fits(kept(**{name: possible + 0.03 * (asked - possible)}), catalog)


def test_depth_that_is_possible_is_the_rating_less_its_reserve(parts, catalog):
    deep = mission(parts, depth_m=800.0).with_changes(reserve=KEPT)
    assert told(deep, catalog)["depth_rating_m"] == pytest.approx(500.0 / 1.25)


def test_where_the_reserve_of_depth_alone_is_in_the_way_that_is_known_first(parts, catalog, monkeypatch):
    # 450 m are asked for, 500 m are sold: at 1.25 times nothing fits. No time is left to look any deeper.
    monkeypatch.setattr(least_limit, "deepest", lambda found, *_, **__: found)
    deep = mission(parts, depth_m=450.0).with_changes(reserve=KEPT)
    assert told(deep, catalog)["depth_rating_m"] == pytest.approx(500.0 / 1.25)


def test_a_refusal_is_weakened_as_its_key_would_be(parts, catalog):
    # 1 m is refused; twice that is held, and 12 mm over 11.3 mm of sensor see 1.42 m of floor from 2 m
    wide = {"reserve": {"swath": 1.0}}
    refused = told(mission(parts, refuse=["swath"]).with_changes(**wide), catalog)
    given = told(mission(parts, min_swath_m=1.0).with_changes(**wide), catalog)
    assert refused["min_swath_m"] == given["min_swath_m"]
    assert refused["min_swath_m"] == pytest.approx(2.0 * 1936 * 5.86e-3 / (12.0 * 1.33) / 2.0, rel=0.01)


def test_without_its_snr_a_mission_looks_for_the_brightest_first(parts, catalog, monkeypatch):
    # By least power thousands of images too dark for the other requirements come first.
    goals, honest = {}, Relaxer.seek

    def noted(self, wanted, goal, freed, **more):
        goals.setdefault(tuple(freed), goal.weight("snr_db"))
        return honest(self, wanted, goal, freed, **more)

    monkeypatch.setattr(Relaxer, "seek", noted)
    told(mission(parts, min_swath_m=9.0, min_snr_db=60.0), catalog)
    assert goals[("min_snr",)] and not goals[("min_swath_m",)]


def test_changes_told_together_are_enough_and_all_of_them_are_needed(parts, catalog):
    # the one lens sees 1.42 m of floor from 2 m, and no light makes 60 dB of its camera's well
    asked = dict(min_swath_m=9.0, min_snr_db=60.0)
    wanted = mission(parts, **asked)
    why = explained(wanted, catalog)
    assert not why.relaxations and why.nearest_miss is not None
    possible = {one.name: one.needed for one in why.together}
    assert set(possible) == {"min_swath_m", "min_snr"}
    both = dict(min_swath_m=possible["min_swath_m"], min_snr_db=possible["min_snr"])
    assert fits(mission(parts, **both), catalog)
    for name in both:
        assert not fits(mission(parts, **{**both, name: asked[name]}), catalog)
    assert possible["min_swath_m"] == pytest.approx(1936 * 5.86e-3 / (12.0 * 1.33) * 2.0, rel=0.01)
    alone = told(mission(parts, **{**asked, "min_swath_m": possible["min_swath_m"]}), catalog)
    assert possible["min_snr"] == pytest.approx(alone["min_snr"], rel=0.01)  # no more can be had of that lens


def test_smaller_changes_are_told_that_help_together(parts, catalog):
    """Less blur and less SNR share what the lamp lacks: each gives less than it would have to alone."""
    asked = dict(max_blur_px=0.1, min_snr_db=30.0)
    why = known(mission(parts, **asked), catalog)
    alone = {one.name: one.miss_rel for one in why.relaxations}
    assert {"max_blur_px", "min_snr"} <= alone.keys()
    together = {one.name: one for one in why.together}
    assert set(together) == {"max_blur_px", "min_snr"}
    assert max(one.miss_rel for one in together.values()) < min(alone.values())
    both = dict(max_blur_px=together["max_blur_px"].needed, min_snr_db=together["min_snr"].needed)
    assert fits(mission(parts, **both), catalog)
    for name in both:
        assert not fits(mission(parts, **{**both, name: asked[name]}), catalog)


def test_dropped_at_once_no_requirement_is_lost_that_helps(parts, catalog, monkeypatch):
    base = mission(parts, max_blur_px=1.0, max_gain_db=30.0, max_airy_px=9.0)
    wanted = base.with_changes(limits={"peak_power_w": 5.0})
    at_once = set(told(wanted, catalog))
    monkeypatch.setattr(singles, "FEW", 99)
    assert at_once == set(told(wanted, catalog)) >= {"peak_power_w"}


def test_what_may_help_is_asked_of_first_and_once(parts, catalog, monkeypatch):
    """Neither helps alone: the one lens sees 1.42 m, and no light makes 60 dB of its camera's well."""
    wanted = mission(parts, min_swath_m=9.0, min_snr_db=60.0)
    asked, honest = [], Relaxer.seek

    def noted(self, mission, goal, freed, **more):
        asked.append(set(freed))
        return honest(self, mission, goal, freed, **more)

    monkeypatch.setattr(Relaxer, "seek", noted)
    one = Singles(Trials(wanted, catalog, POWER, "never"), hopes={"min_snr": 0.1, "min_swath_m": 0.5, "overlap": 0.0})
    one.drop_hopeful()
    assert asked == [{"min_swath_m"}, {"min_snr"}]
    one.drop_light()
    one.drop_rest()
    assert asked[2:] == [{"overlap"}, {"depth_rating_m"}]


def test_what_does_not_help_alone_is_told_with_what_still_stands_in_the_way(parts, catalog):
    """The one lens sees 1.42 m, and no light makes 60 dB of its camera's well."""
    wanted = mission(parts, min_swath_m=9.0, min_snr_db=60.0)
    found = seek(wanted, catalog, POWER, generic="never", top=1)
    proof = certificate(found.selection, found.problem, found.outcome, POWER)
    why = why_nothing(Trials(wanted, catalog, POWER, "never", like=found), proof)
    still = {one.name: one.still for one in why.no_help}
    assert still["min_swath_m"] == ["settings"] and still["min_snr"] == ["min_swath_m"]
    assert still["overlap"] == still["water"] == ["min_swath_m"]
    assert not set(still) & {one.name for one in why.relaxations} and why.not_known == []


def test_what_a_design_misses_alone_is_known_to_help(parts, catalog):
    """Dropped with one that hinders nothing, the peak of power is all that what fits then misses."""
    base = mission(parts, max_blur_px=1.0, max_airy_px=9.0)
    wanted = base.with_changes(limits={"peak_power_w": 5.0})
    one = Singles(Trials(wanted, catalog, POWER, "never"))
    names = ["max_airy_px", "peak_power_w"]
    found = one.trials.seek_without(names)
    one._take_the_only_miss(found, names)
    assert [helps.name for helps in one.helpful] == ["peak_power_w"]
    one._take_the_only_miss(found, names)
    assert len(one.helpful) == 1  # once


def test_a_budget_that_is_missed_by_far_weakens_no_limit_to_less_than_nothing(parts, catalog, monkeypatch):
    """Parts cost 1700 USD, 5.8 times what is asked; five times less of a swath would be a negative one."""
    shares: list[float] = []
    monkeypatch.setattr(CommonShare, "_search", lambda self, share, *_: shares.append(share))
    wanted = mission(parts, min_swath_m=0.5).with_changes(limits={"cost": 250.0})
    why = explained(wanted, catalog)
    assert [one.name for one in why.relaxations] == ["cost"] and why.relaxations[0].miss_rel > 5.0
    assert shares and max(shares) < 1.0


def test_limits_speed_and_height_told_together_are_enough(parts, catalog):
    asked = dict(max_blur_px=0.1, min_snr_db=30.0)
    wanted = mission(parts, **asked)
    found = seek(wanted, catalog, POWER, generic="never", top=1)
    both = CommonShare(Trials(wanted, catalog, POWER, "never", like=found), NEVER)
    both.moved = both.vehicle
    known = both._halved(0.0, 0.9, None)
    assert known is not None
    possible = {one.name: one.needed for one in both._drawn_back(*known).changes}
    assert {"speed_m_s", "altitude_m"} & possible.keys()
    limits = {"max_blur_px": possible.get("max_blur_px", 0.1), "min_snr_db": possible.get("min_snr", 30.0)}
    moved = mission(parts, **limits).to_dict()["vehicle"] | {
        name: value for name, value in possible.items() if name in both.vehicle
    }
    assert fits(mission(parts, **limits).with_changes(vehicle=moved), catalog)
    assert not fits(mission(parts, **limits), catalog)


def test_a_height_gives_with_its_tolerance(parts, catalog):
    """A quarter of 2 m is no height with a tolerance of 0.9 m; drawn back alone, that is no mission either."""
    wanted = mission(parts, max_blur_px=0.1, min_snr_db=30.0)
    wanted = wanted.with_changes(vehicle=wanted.to_dict()["vehicle"] | {"altitude_tolerance_m": 0.9})
    both = CommonShare(Trials(wanted, catalog, POWER, "never"), NEVER, by_factor=True)
    both.moved = both.vehicle
    low = both.mission(both.weaker_by(0.75))
    assert (low.vehicle.altitude_m, low.vehicle.altitude_tolerance_m) == (0.5, 0.225)
    found = seek(low, catalog, POWER, generic="never", top=1)
    assert fitting(found, partial(both.mission, both.weaker_by(0.75))) is not None
    assert fitting(found, partial(both.mission, {**both.weaker_by(0.75), "altitude_tolerance_m": 0.9})) is None
    changes = both._drawn_back(0.75, found).changes
    assert fits(both.mission(both.asked | {one.name: one.needed for one in changes}), catalog)


@pytest.mark.parametrize(("asked", "is_told"), [(0.1, True), (0.02, False)])
def test_an_image_of_no_use_is_no_way_out(parts, catalog, asked, is_told):
    """The lamp at full level blurs 0.97 px: thirty times what is asked is the most told where less noise helps."""
    assert ("max_blur_px" in told_once(mission(parts, max_blur_px=asked, min_snr_db=30.0), catalog)) == is_told


def test_what_is_out_of_reach_by_far_is_told_where_nothing_else_is(parts, catalog, monkeypatch):
    monkeypatch.setattr(infeasible, "changes_together", lambda *_: ([], None))  # as where time is over
    possible = told(mission(parts, max_blur_px=0.001, min_snr_db=30.0), catalog)["max_blur_px"]
    assert fits(mission(parts, max_blur_px=possible, min_snr_db=30.0), catalog)


def test_one_change_is_told_as_one_that_helps_alone_however_far_it_is(parts, catalog):
    """12 mm and 5.86 um see 1 mm and more from 2.1 m: with that and all else something fits."""
    wanted = mission(parts, max_gsd_mm=0.01)
    why = explained(wanted, catalog)
    assert [one.name for one in why.relaxations] == ["max_gsd_mm"] and why.together == []
    assert why.relaxations[0].needed == pytest.approx(5.86 / 12.0 * 1.33 * 2.1, rel=0.5)
    assert fits(mission(parts, max_gsd_mm=why.relaxations[0].needed), catalog)


@pytest.mark.parametrize(
    ("value", "asked", "rounded"),
    [(2.7134, 1.0, 2.72), (2.71, 1.0, 2.71), (0.061239, 0.5, 0.0612), (1234.5, 0.0, 1240.0), (-3.217, 1.0, -3.22),
     (4.44e-16, 20.0, 0.0)],
)  # fmt: skip
def test_limit_to_type_is_rounded_away_from_what_was_asked(value, asked, rounded):
    assert rounded_away(value, asked) == rounded


@pytest.mark.parametrize(
    ("limit", "fits_at_central"),
    # parts 1700 USD, all quoted; two connections 2 x 90 (to 270), control 150 (450), spares 100 (250), test 200 (400):
    # 2330 USD at central prices, 3340 at high ones
    [(3000.0, True), (2400.0, True), (2300.0, False)],
)
def test_a_limit_of_cost_that_only_high_prices_break_is_told(parts, catalog, limit, fits_at_central):
    base = mission(parts)
    wanted = base.with_changes(limits={"cost": limit}, catalog=base.to_dict()["catalog"] | {"rest": "estimate"})
    (cost,) = (r for r in explained(wanted, catalog).relaxations if r.name == "cost")
    assert cost.fits_at_central_prices == fits_at_central
    assert cost.needed == pytest.approx(3340.0)
    assert fits(wanted.with_changes(limits={"cost": limit, "cost_basis": "central"}), catalog) == fits_at_central


def test_a_budget_is_given_up_among_a_few_imagers_before_central_prices_are_asked_about(parts, catalog, monkeypatch):
    asked: list[set[str]] = []
    monkeypatch.setattr(Relaxer, "among_few", lambda self, mission, goal, freed, *_, **more: asked.append(set(freed)))
    base = mission(parts)
    wanted = base.with_changes(limits={"cost": 2300.0}, catalog=base.to_dict()["catalog"] | {"rest": "estimate"})
    monkeypatch.setattr(Singles, "_is_known", lambda self, *_: False)  # among all, which begins with a few too
    one = Singles(Trials(wanted, catalog, POWER, "never"))
    one._ask_suspect("cost", 0.5)
    assert asked == [{"cost"}] and not one.dear  # central prices are asked about only where none at all would do
    assert one._may_keep_central("cost") and not one._is_known_at_central_prices("cost")
    assert one.dear == {"cost"} and not one._may_keep_central("cost")  # asked once


def test_what_was_looked_at_in_vain_but_not_to_the_end_is_told_apart(parts, catalog, monkeypatch):
    cut = SimpleNamespace(best=[], complete=False, interrupted=False, account=SimpleNamespace(evaluated=7))
    monkeypatch.setattr(Relaxer, "seek", lambda self, *_, **more: SimpleNamespace(outcome=cut))
    one = Singles(Trials(mission(parts), catalog, POWER, "never"))
    assert not one._is_known("overlap", NEVER)
    assert one.in_part == {"overlap": 7} and not one.useless


def test_the_least_limit_of_cost_is_proven_for_high_prices(parts, catalog):
    # the other camera draws 1 W less and costs 50 USD less at central prices, but up to 2000 USD: 4840 USD in all
    base = mission(parts)
    choice = base.to_dict()["catalog"] | {"rest": "estimate", "cameras": ["zz-cam", "zz-other"]}
    wanted = base.with_changes(limits={"cost": 3000.0}, catalog=choice)
    why = explained(wanted, catalog)
    assert {r.name: r.needed for r in why.relaxations}["cost"] == pytest.approx(3340.0, rel=0.01)  # steps of 3 digits


HIGH_USD = {"zz-cam": 500, "zz-other": 2000, "zz-lens": 300, "zz-wide": 300, "zz-port": 200, "zz-deep": 900}


def test_the_least_budget_is_that_of_the_parts_whose_high_prices_are_least(parts, catalog):
    """Tried part by part: the camera that costs least at central prices, 450 USD, counts with 2000 against a budget."""
    base = mission(parts, min_swath_m=1.5)
    choice = base.to_dict()["catalog"] | {"cameras": ["zz-cam", "zz-other"], "lenses": ["zz-lens", "zz-wide"]}
    budget = {}
    for names in product(choice["cameras"], choice["lenses"], ["zz-port", "zz-deep"]):
        camera, lens, port = names
        alone = choice | {"cameras": [camera], "lenses": [lens], "ports": [port]}
        if fits(base.with_changes(catalog=alone), catalog):
            budget[names] = 700 + sum(HIGH_USD[name] for name in names)  # one lamp of 700 USD
    assert set(budget) == set(product(["zz-cam", "zz-other"], ["zz-wide"], ["zz-port", "zz-deep"]))  # 12 mm: 1.42 m
    least = min(budget.values())

    def within(cost: float) -> Mission:
        return base.with_changes(catalog=choice, limits={"cost": cost})

    assert told(within(1000.0), catalog)["cost"] == pytest.approx(least, rel=0.005)  # three digits
    assert fits(within(least), catalog) and not fits(within(least - 1.0), catalog)


def test_a_reserve_of_depth_that_alone_keeps_all_ports_out_is_named_with_the_one_that_would_do(parts):
    """The deepest port is rated for 500 m: 450 m times 1.25 are 562.5 m, and 500 / 450 = 1.111 would do."""

    def within(depth: float) -> Result:
        wanted = mission(parts, depth_m=450.0, refuse=["depth"]).with_changes(reserve={"depth": depth})
        return solve(wanted, confidence="central", quick=True)

    said = " ".join(str(line) for line in depth_lines(within(1.25)))
    assert "No port that the mission allows otherwise reaches the 562.5 m" in said
    assert "450.0 m asked for, times 1.25 kept in reserve" in said and "reserve.depth 1.111 would do" in said
    assert within(1.111).recommendation is not None and within(1.112).recommendation is None


def test_a_depth_that_has_to_give_is_told_as_a_mission_can_say_it(parts):
    """Less of `limits.depth_rating_m` than the deepest scene is refused; a scene that is less deep is none."""
    wanted = mission(parts, depth_m=800.0).with_changes(reserve={"depth": 1.25})
    said = solve(wanted, confidence="central", quick=True)
    assert said.infeasible is not None
    (one,) = (each for each in said.infeasible.relaxations if each.name == "depth_rating_m")
    assert change_texts(said, one) == ("depth of the deepest scene (depth_m)", "800.0 m", "400.0 m")
    made = changed(wanted, one)
    assert (made.scenes[0].depth_m, made.limits.depth_rating_m) == (400.0, None)
    assert solve(made, confidence="central", quick=True).recommendation is not None


def test_changes_together_are_told_where_looking_for_single_ones_takes_all_the_time(parts, catalog, monkeypatch):
    """The clock stands still until the last single requirement is dropped, which takes all that it may."""
    now = [0.0]

    def last(self: Singles) -> None:
        now[0] = max(now[0], self.trials.deadline.end_s)

    monkeypatch.setattr(Singles, "drop_rest", last)
    wanted = mission(parts, min_swath_m=9.0, min_snr_db=60.0)  # as above: neither helps alone
    found = seek(wanted, catalog, POWER, generic="never", top=1)
    proof = certificate(found.selection, found.problem, found.outcome, POWER)
    why = why_nothing(Trials(wanted, catalog, POWER, "never", Deadline(100.0, lambda: now[0])), proof)
    assert not why.relaxations
    assert {one.name for one in why.together} == {"min_swath_m", "min_snr"}


@pytest.mark.parametrize(
    ("asked", "requirements", "keys"),
    [({"min_swath_m": 9.0}, ["min_swath_m"], []), ({"max_gsd_mm": 0.5}, ["max_gsd_mm"], ["altitude_m"])],
)
def test_it_goes_on_where_nothing_is_known_to_help_when_time_ends(parts, catalog, asked, requirements, keys):
    """The time is over before it begins, by a clock that stands still."""
    wanted = mission(parts, **asked)
    found = seek(wanted, catalog, POWER, generic="never", top=1)
    proof = certificate(found.selection, found.problem, found.outcome, POWER)
    over = Deadline(0.0, lambda: 1.0)
    assert not why_nothing(Trials(wanted, catalog, POWER, "never", over), proof).relaxations
    why = why_nothing(Trials(wanted, catalog, POWER, "never", over, more_s=100.0), proof)
    assert ([one.name for one in why.relaxations], [one.name for one in why.moves]) == (requirements, keys)
    assert not {one.name for one in why.moves} & set(why.not_known)


@pytest.mark.parametrize(
    ("asked", "given"),
    [({"min_swath_m": 9.0, "min_snr_db": 60.0}, {"min_swath_m", "min_snr"}), ({"min_swath_m": 9.0}, {"min_swath_m"})],
)
def test_requirements_that_give_together_are_found_among_a_few_imagers(parts, catalog, monkeypatch, asked, given):
    """What is left asked for fits, each that gives is needed, and what is told of them is enough; one alone helps."""
    monkeypatch.setattr(Trials, "few_without", lambda self, names, turn, number=None: self.seek_without(names))
    wanted = mission(parts, max_airy_px=9.0, max_blur_px=2.0, **asked)
    trials = Trials(wanted, catalog, POWER, "never", like=seek(wanted, catalog, POWER, generic="never", top=1))
    known = few_that_give(trials)
    assert known is not None and set(known[0]) == given
    assert fits(trials.without(known[0]), catalog)
    assert not any(fits(trials.without(given - {name}), catalog) for name in given)
    limits = {one.name: one.needed for one in least_set(trials, known)[0]}
    assert fits(trials.with_limits(wanted, limits), catalog)
    one = Singles(trials)
    one.give_together()
    assert [helps.name for helps in one.helpful] == (["min_swath_m"] if len(given) == 1 else [])


@pytest.mark.parametrize(
    ("asked", "given"),
    [({"min_swath_m": 9.0, "min_snr_db": 60.0}, {"min_swath_m", "min_snr"}), ({"min_swath_m": 9.0}, {"min_swath_m"})],
)
def test_changes_found_together_among_a_few_imagers_are_enough_and_one_alone_helps(
    parts, catalog, monkeypatch, asked, given
):
    """The lens sees 1.42 of 9 m, which is less than a share of 0.75 leaves; nothing is told that need not give."""
    shares: list[float] = []

    def of_all(self: CommonShare, wanted: Mission, turn: Deadline) -> Sought | None:
        if self.moved:
            return None
        shares.append(round(1.0 - wanted.requirements.min_swath_m / 9.0, 2))
        return self.trials.relaxer.seek(wanted, POWER, set(self.limits), deadline=turn, enough=True)

    monkeypatch.setattr(CommonShare, "_among_few", of_all)
    wanted = mission(parts, max_airy_px=9.0, max_blur_px=2.0, **asked)
    trials = Trials(wanted, catalog, POWER, "never", like=seek(wanted, catalog, POWER, generic="never", top=1))
    singles, mover = Singles(trials), Mover(trials)
    fit = together_soon(trials, singles, mover)
    assert set(shares) == {0.75, 0.85}
    assert [helps.name for helps in singles.helpful] == ([] if len(given) > 1 else ["min_swath_m"])
    assert (fit is None) == (len(given) == 1) and not mover.helpful
    if fit is not None:
        possible = {one.name: one.needed for one in fit.changes}
        assert set(possible) == given and fits(trials.with_limits(wanted, possible), catalog)
        assert not any(fits(trials.with_limits(wanted, {name: possible[name]}), catalog) for name in given)


def test_what_a_design_reaches_is_told_where_no_time_is_left_to_draw_it_in(parts, catalog):
    """The lens sees 1.42 m; a share of 0.9 asks for 0.9 m."""
    wanted = mission(parts, min_swath_m=9.0, max_airy_px=9.0)
    trials = Trials(wanted, catalog, POWER, "never", Deadline(0.0, lambda: 1.0))
    both = CommonShare(trials, trials.deadline, few=True, by_factor=True)
    found = seek(both.mission(both.weaker_by(0.9)), catalog, POWER, generic="never", top=1)
    possible = {one.name: one.needed for one in both._drawn_back(0.9, found).changes}
    assert possible["min_swath_m"] == pytest.approx(1936 * 5.86e-3 / (12.0 * 1.33) * 2.0, rel=0.01)


def test_a_limit_from_above_gives_by_as_large_a_factor_as_one_from_below(parts, catalog):
    wanted = mission(parts, max_blur_px=2.0, min_swath_m=1.0)
    both = CommonShare(Trials(wanted, catalog, POWER, "never"), NEVER, by_factor=True)
    weaker = both.weaker_by(0.75)
    assert (weaker["max_blur_px"], weaker["min_swath_m"]) == (8.0, 0.25)


def test_a_speed_that_is_found_to_do_is_drawn_back(parts, catalog):
    wanted = mission(parts, max_blur_px=0.1, min_snr_db=30.0)
    slow = wanted.with_changes(vehicle=wanted.to_dict()["vehicle"] | {"speed_m_s": 0.01})
    found = seek(slow, catalog, POWER, generic="never", top=1)
    mover = Mover(Trials(wanted, catalog, POWER, "never"))
    mover.take_for_far("speed_m_s", 0.01, found)
    (move,) = mover.helpful
    in_rounds([move.drawn], NEVER)
    assert 0.01 < move.told().needed < 0.5


def test_what_a_person_wrote_is_known_from_what_good_practice_fills_in():
    plain = {"scene": {"water": "II", "seafloor": 0.2, "depth_m": 30}, "vehicle": {"altitude_m": 1.0, "speed_m_s": 0.1}}
    wanted = load_mission({**plain, "requirements": {"overlap": 0.3, "min_uniformity": 0.9}, "limits": {"cost": 9e3}})
    keys = ("overlap", "min_uniformity", "min_mtf_half_nyquist", "lens_stop_down", "max_airy_px")
    assert [is_filled_in(wanted, key) for key in keys] == [False, False, True, True, True]
    assert [is_filled_in(wanted, key) for key in ("cost", "depth_rating_m")] == [False, True]


def test_what_may_help_is_asked_of_a_few_imagers_where_all_would_take_too_long(parts, catalog, monkeypatch):
    monkeypatch.setattr(singles, "IMAGER_S", math.inf)
    monkeypatch.setattr(Trials, "turn", lambda self: self.deadline)
    wanted = mission(parts, min_swath_m=9.0)  # the one lens sees 1.42 m
    one = Singles(Trials(wanted, catalog, POWER, "never", Deadline(1000.0, lambda: 0.0)), hopes={"min_swath_m": 0.5})
    few = one.trials.relaxer.seek
    monkeypatch.setattr(
        Relaxer, "among_few",
        lambda self, mission, goal, freed, *_, **more: few(mission, goal, freed, enough=True, few_first=False),
    )  # fmt: skip
    one.drop_hopeful()
    assert [helps.name for helps in one.helpful] == ["min_swath_m"]
    one.drop_rest()
    assert "min_swath_m" not in one.left and "overlap" in one.left


GLIDER: dict[str, Any] = {
    "practice": "bare", "name": "glider", "objective": "power", "confidence": "central",
    "scene": {"water": "II", "seafloor": "sand", "depth_m": 60},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3, "light_baseline_m": 0.4, "light_count": 1,
                "duration_h": 200, "battery_wh": 900, "supply": "battery"},
    "requirements": {"frame_interval_s": 10, "max_blur_px": 1.5, "min_snr_db": 20},
    "limits": {"power_w": 4, "mass_kg": 8},
    "catalog": {"cameras": ["basler-aca1920-40um", "allied*g-23*"], "lenses": ["kowa-lm12jc5m2", "kowa-lm8*"],
                "ports": ["blue-robotics-4-in-dome-plastic-ring-2026"], "lights": ["arctic-rays-dragonfish*"],
                "generic": "never", "host": "estimate", "rest": "estimate"},
}  # fmt: skip


def test_energy_that_lacks_behind_a_mass_that_is_too_great_gives_together_with_it() -> None:
    """A glider of 8 kg whose battery alone weighs 12.6 kg was told that "at least two have to give", and not which.

    A larger battery is heavier by as much as mass may give, so that hours have to.
    """
    told = solve(GLIDER, top=1).infeasible
    assert told is not None and not told.relaxations and not told.moves
    possible = {one.name: one.needed for one in told.together}
    assert {"duration_h", "power_w", "mass_kg"} <= {*possible} and "battery_wh" not in possible
    assert None not in possible.values()
    need_w = possible["power_w"] - 0.01  # told to three digits, rounded away from what was asked
    assert need_w * possible["duration_h"] <= 900.0  # what the battery holds
    changed = copy.deepcopy(GLIDER)
    for name, value in possible.items():
        places = [changed[section] for section in ("limits", "vehicle", "requirements")]
        next(own for own in places if name in own)[name] = value
    best = solve(changed, top=1, quick=True).best
    assert best is not None and best.totals.energy_wh is not None and best.totals.energy_wh <= 900.0

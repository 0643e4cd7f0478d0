"""Risks by hand: each is told when it is there, with its figure, and the most serious stands first."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from uwopt.api.evaluating import evaluate
from uwopt.api.risks.told import risks_of
from uwopt.results.basis import Assumption, Risk
from uwopt.results.certainty import Confidence
from uwopt.results.design import AS_CENTRAL, PRACTICE_MISSED, BillRow, Design, Margin, Note, SceneResult
from uwopt.results.result import Result

PROBLEMS = Path(__file__).parents[2] / "problems"
CALM = {
    "uniformity": 0.8,
    "snr_db_min": 27.0,
    "defocus_corner_px": 1.9,
    "skew_px": 0.0,
    "lateral_colour_px": None,
}
WATERS = [
    {"objective_value": 3.0},
    {"objective_value": None},
    {"objective_value": None},
    {"objective_value": None},
]


@pytest.fixture(scope="module")
def base() -> Result:
    """A real result, from which a calm one is made."""
    return evaluate(PROBLEMS / "paper-tank.yaml", PROBLEMS / "paper-tank.system.yaml")


def margin(name: str, value: float, limit: float, sense: str, unit: str, **more: Any) -> Margin:
    """A margin that is met unless told otherwise."""
    left = limit - value if sense == "<=" else value - limit
    return Margin(name, value, limit, sense, left, unit, None, left >= 0, False, **more)


@pytest.fixture
def calm(base: Result) -> Result:
    """A result without any risk: everything in hand, all prices quoted, all parts sold."""
    assert base.design is not None
    kept = [margin("min_snr_db", 33.0, 30.0, ">=", "dB"), margin("depth_rating_m (p)", 300.0, 100.0, ">=", "m"),
            margin("f_number_min", 2.8, 1.4, ">=", "")]  # fmt: skip
    scene = SceneResult("reef", {"f_number": 2.8, "gain_db": 6.0}, None, dict(CALM), kept)
    parts = {kind: replace(part, generic=False) for kind, part in base.design.hardware.parts.items()}
    cost = replace(base.design.totals.cost, value=900.0, low=900.0, high=900.0, estimated=0.0)
    design = replace(
        base.design, hardware=replace(base.design.hardware, **parts), scenes=[scene], bom=[], feasible=True,
        warnings=[], totals=replace(base.design.totals, cost=cost),
    )  # fmt: skip
    return replace(base, status="feasible", design=design, warnings=[], robustness=None)


def with_figures(result: Result, **figures: Any) -> Result:
    """The same with other figures."""
    scene = design_of(result).scenes[0]
    return with_scene(result, replace(scene, figures={**scene.figures, **figures}))


def with_margin(result: Result, added: Margin) -> Result:
    """The same with one margin more."""
    scene = design_of(result).scenes[0]
    return with_scene(result, replace(scene, margins=[*scene.margins, added]))


def with_scene(result: Result, *scenes: SceneResult) -> Result:
    """The same with other scenes."""
    return replace(result, design=replace(design_of(result), scenes=list(scenes)))


def with_cost(result: Result, limit: float | None, **cost: Any) -> Result:
    """The same at another price, with a limit on it."""
    totals = design_of(result).totals
    mission = {**result.mission, "limits": {"cost": limit}}
    design = replace(design_of(result), totals=replace(totals, cost=replace(totals.cost, **cost)))
    return replace(result, design=design, mission=mission)


def design_of(result: Result) -> Design:
    """Its design."""
    assert result.design is not None
    return result.design


def only(result: Result) -> Risk:
    """The one risk there is."""
    (risk,) = risks_of(result)
    return risk


def test_where_all_is_in_hand_there_is_no_risk(calm: Result) -> None:
    assert risks_of(calm) == []
    assert risks_of(replace(calm, design=None)) == []


def test_lamps_that_never_light_are_told(calm: Result) -> None:
    scene = design_of(calm).scenes[0]
    off = replace(scene, settings={**scene.settings, "dim_frac": 0.0})
    risk = only(with_scene(calm, off))
    assert (risk.what, risk.figure) == ("lamps are bought that stay off", "1 lamp")
    lit = replace(scene, settings={**scene.settings, "dim_frac": 0.5})
    assert risks_of(with_scene(calm, off, lit)) == []  # at night they are needed


@pytest.mark.parametrize(("end", "sense", "figure", "off"), [
    ("dof_near_m", "<=", "sharp from 0.150 m, the nearest floor at 0.150 m: margin 0 m", "focus set any farther"),
    ("dof_far_m", ">=", "sharp to 0.150 m, the farthest floor at 0.150 m: margin 0 m", "focus set any nearer"),
])  # fmt: skip
def test_an_end_of_the_depth_of_field_says_what_uses_it_up(
    calm: Result, end: str, sense: str, figure: str, off: str
) -> None:
    risk = only(with_margin(calm, margin(end, 0.15, 0.15, sense, "m")))
    assert risk.figure == figure and off in risk.because


def test_what_rounding_leaves_is_told_as_nothing(calm: Result) -> None:
    hair = replace(margin("dof_near_m", 0.65 + 2e-16, 0.65, "<=", "m"), satisfied=True)
    risk = only(with_margin(calm, hair))
    assert risk.figure == "sharp from 0.650 m, the nearest floor at 0.650 m: margin 0 m"


def test_what_only_good_practice_misses_is_not_told_as_asked_for(calm: Result) -> None:
    """A swath of 1.25 m, where 1.2 m were asked and 1.32 m with the reserve, was "not as asked for"."""
    noted = replace(calm, warnings=[Note(PRACTICE_MISSED, "practice", "what is missed is good practice")])
    risk = only(with_margin(noted, margin("max_blur_px", 2.0, 1.0, "<=", "px")))
    assert (risk.what, risk.because) == (
        "motion blur is not as good practice asks", "what the mission itself says is met",
    )  # fmt: skip


def test_missed_requirement_has_value_and_limit(calm: Result) -> None:
    risk = only(with_margin(calm, margin("max_blur_px", 2.0, 1.0, "<=", "px")))
    assert (risk.what, risk.figure) == ("motion blur is not as asked for", "2.00 px against 1.00 px")


@pytest.mark.parametrize(("end", "sense", "figure"), [
    ("dof_near_m", "<=", "sharp only from 1.42 m, not from 1.00 m"),
    ("dof_far_m", ">=", "sharp only to 1.42 m, not to 1.60 m"),
])  # fmt: skip
def test_an_end_of_the_depth_of_field_that_is_missed_says_what_is_sharp(
    calm: Result, end: str, sense: str, figure: str
) -> None:
    risk = only(with_margin(calm, margin(end, 1.42, 1.0 if sense == "<=" else 1.6, sense, "m")))
    assert (risk.what, risk.figure) == ("depth of field is not as asked for", figure)


@pytest.mark.parametrize(("physics", "dof_at", "figure"), [
    ("auto", "corner", "sharp to the corners only from 1.42 m, not from 1.00 m"),
    ("auto", "axis", "sharp only from 1.42 m, not from 1.00 m"),
    ("paper", "corner", "sharp only from 1.42 m, not from 1.00 m"),  # which knows no corners
])  # fmt: skip
def test_what_must_be_sharp_to_the_corners_is_told_to_be(calm: Result, physics: str, dof_at: str, figure: str) -> None:
    """A lens was "sharp only from 1.21 m" whose middle was sharp from far nearer."""
    asked = {**calm.mission, "requirements": {**calm.mission["requirements"], "dof_at": dof_at}}
    wanted = replace(calm, mission=asked, physics=replace(calm.physics, name=physics))
    assert only(with_margin(wanted, margin("dof_near_m", 1.42, 1.0, "<=", "m"))).figure == figure
    tight = only(with_margin(wanted, margin("dof_near_m", 0.15, 0.15, "<=", "m")))
    assert tight.because.endswith(f"is not sharp{figure.removeprefix('sharp').partition(' only')[0]}")


def test_images_that_are_noise_are_told_where_no_signal_to_noise_is_asked(calm: Result) -> None:
    scene = design_of(calm).scenes[0]
    unasked = with_scene(calm, replace(scene, margins=[m for m in scene.margins if m.requirement != "min_snr_db"]))
    risk = only(with_figures(unasked, snr_db=-6.9))
    assert risk.what == "the images show nothing but noise" and risk.figure == "signal to noise -6.90 dB"
    assert "requirements.min_snr_db: 20 asks" in risk.because
    assert only(with_figures(unasked, snr_db=12.0)).what == "the images are noisy"
    assert risks_of(with_figures(unasked, snr_db=25.0)) == []
    assert risks_of(with_figures(with_margin(unasked, margin("min_snr_db", 12.0, 10.0, ">=", "dB")), snr_db=12.0)) == []


def test_a_requirement_that_is_just_missed_does_not_look_met(calm: Result) -> None:
    risk = only(with_margin(calm, margin("min_snr_db", 24.997, 25.0, ">=", "dB")))
    assert risk.figure == "24.997 dB against 25.000 dB"


@pytest.mark.parametrize(("reached_db", "reserve_db", "told"), [
    (30.1, 0.0, True),  # 0.1 dB are 1.2 % of the ratio
    (30.3, 0.0, False),  # 0.3 dB are 3.5 %
    (33.0, 3.0, False),  # nothing left of the limit, 3 dB in hand of what is asked for
])  # fmt: skip
def test_nothing_in_hand_is_told_of_what_is_asked_for(
    calm: Result, reached_db: float, reserve_db: float, told: bool
) -> None:
    added = margin("min_snr_db", reached_db, 30.0 + reserve_db, ">=", "dB", reserve=reserve_db)
    found = risks_of(with_margin(calm, added))
    assert [risk.what for risk in found] == (["it may not do what is asked"] if told else [])
    if told:
        assert (
            "signal to noise" in found[0].because
            and found[0].figure == "signal to noise 30.1 dB against 30.0 dB"
        )


def test_estimates_at_their_bad_ends_are_counted_without_prices(calm: Result) -> None:
    highs = {"camera.price": 2.0, "camera.qe_scale": 2.0, "lens.transmission_frac": 0.5}
    assumed = [Assumption(path, "p", 1.0, 0.5, high, "", "estimated", "") for path, high in highs.items()]
    result = replace(calm, assumptions=assumed, robustness={"feasible_at_bad_end": False})
    assert only(result).figure == "1 estimated number"


def test_other_waters_in_which_it_fails_are_counted(calm: Result) -> None:
    assert only(replace(calm, robustness={"waters": WATERS})).figure == "in 3 of 4 other waters"
    assert risks_of(replace(calm, robustness={"waters": WATERS[:1]})) == []
    for water, because in (("II", "tables of one type"), (None, "water as clear may")):
        mission = calm.mission | {"scenes": [{"name": "here", "water": water}]}
        assert because in only(replace(calm, mission=mission, robustness={"waters": WATERS})).because


def test_lamps_are_steady_to_three_degrees(calm: Result) -> None:
    def tilt(held: float) -> Result:
        ways = {"held_outward_deg": 16.0, "held_inward_deg": held, "readjusted_outward_deg": 16.0,
                "readjusted_inward_deg": 2.5, "first_to_break": ["min_snr_db"]}  # fmt: skip
        return replace(calm, robustness={"tilt": ways})

    risk = only(tilt(0.3))
    assert risk.figure == "0.3° as set" and "signal to noise" in risk.because and "2.5°" in risk.because
    assert risks_of(tilt(3.0)) == []


@pytest.mark.parametrize(("figures", "figure"), [
    ({"uniformity": 0.0061, "snr_db_min": -4.2}, "0.61 % of the mean light, signal to noise there -4.20 dB"),
    ({"defocus_corner_px": 24.4}, "24.4 px"), ({"skew_px": 2.5}, "2.50 px"), ({"lateral_colour_px": 2.9}, "2.90 px"),
    ({"white_balance": 4.6, "white_balance_red": 4.6}, "white balance x 4.6"),
])  # fmt: skip
def test_faults_of_the_image_that_nobody_asked_about_are_told(
    calm: Result, figures: dict[str, float], figure: str
) -> None:
    assert only(with_figures(calm, **figures)).figure == figure


def test_smeared_subjects_are_told_where_no_limit_of_blur_is_asked(calm: Result) -> None:
    swimming = replace(calm, mission={**calm.mission, "scenes": [{"name": "reef", "subject_speed_m_s": 0.5}]})
    asked = margin("max_blur_px", 5.0, 6.0, "<=", "px")
    assert only(with_figures(swimming, blur_px=5.0)).figure == "5.00 px"
    assert risks_of(with_figures(swimming, blur_px=1.9)) == []
    assert risks_of(with_margin(with_figures(swimming, blur_px=5.0), asked)) == []
    assert risks_of(with_figures(calm, blur_px=5.0)) == []


def test_light_that_is_gathered_long_asks_for_a_camera_that_stands_still(calm: Result) -> None:
    def still(blur_px: float = 0.0, sun_lux: float = 0.0, **settings: float) -> Result:
        scene = design_of(with_figures(calm, blur_px=blur_px, gsd_mm=0.26)).scenes[0]
        lit = {**calm.mission, "scenes": [{"name": scene.name, "sun_lux": sun_lux}]}
        return with_scene(replace(calm, mission=lit), replace(scene, settings={**scene.settings, **settings}))

    risk = only(still(exposure_ms=1000.0))
    assert risk.what == "camera and scene must stand still"
    assert risk.because.startswith("1 000 ms of light smear by a pixel at a drift of 0.260 mm/s, and")
    assert only(still(exposure_ms=1000.0, pulse_ms=2.0, sun_lux=1e4)) == risk
    assert risks_of(still(exposure_ms=1000.0, pulse_ms=2.0)) == []  # a flash in the dark freezes what moves
    assert risks_of(still(exposure_ms=25.0)) == []
    assert risks_of(still(exposure_ms=1000.0, blur_px=0.5)) == []  # it moves, and that is counted


def test_scene_is_named_where_there_are_several(calm: Result) -> None:
    first = design_of(calm).scenes[0]
    other = replace(first, name="wall", figures={**CALM, "defocus_corner_px": 5.0})
    assert only(with_scene(calm, first, other)).because.endswith("in wall")


def test_housings_that_float_are_told_with_their_ballast(calm: Result) -> None:
    def weighing(in_water_kg: float | None) -> Result:
        totals = replace(design_of(calm).totals, mass_water_kg=in_water_kg)
        return replace(calm, design=replace(design_of(calm), totals=totals))

    told = only(weighing(-6.0))
    assert told.what == "the cameras float and need ballast" and told.figure == "6.00 kg of ballast in water"
    assert [risks_of(weighing(kg)) for kg in (-0.4, 0.0, 3.0, None)] == [[]] * 4


@pytest.mark.parametrize(("lift_kg", "limit_kg", "first"), [
    (11.9, 2.0, "the cameras float"),  # two housings of acrylic for a diver who asked for 2 kg at most
    (1.9, 2.0, "the lens is used"), (9.0, None, "the lens is used"), (11.0, None, "the cameras float"),
])  # fmt: skip
def test_much_lift_is_a_greater_risk_than_a_lens_wide_open(
    calm: Result, lift_kg: float, limit_kg: float | None, first: str
) -> None:
    totals = replace(design_of(calm).totals, mass_water_kg=-lift_kg)
    limits = {**calm.mission["limits"], "mass_water_kg": limit_kg}
    light = replace(calm, design=replace(design_of(calm), totals=totals), mission={**calm.mission, "limits": limits})
    risks = risks_of(with_margin(light, replace(margin("f_number_min", 2.8, 2.8, ">=", ""), binding=True)))
    assert len(risks) == 2 and risks[0].what.startswith(first)
    kind, part = next(iter(design_of(light).hardware.parts.items()))
    hardware = replace(design_of(light).hardware, **{kind: replace(part, generic=True)})
    made = risks_of(replace(light, design=replace(design_of(light), hardware=hardware)))
    assert made[0].what.startswith("the cameras float") == (lift_kg > (limit_kg or 1e9))  # before a part to be made


@pytest.mark.parametrize(("water_c", "is_told"), [(28.0, True), (24.0, False)])
def test_air_in_a_housing_that_may_be_warmer_than_cameras_stand_is_told(
    calm: Result, water_c: float, is_told: bool
) -> None:
    """12 to 26 K over the water: 54 °C in the tropics, and 50 °C at 24 °C, which most makers allow."""
    totals = replace(design_of(calm).totals, housing_heat_w=9.0, housing_warmer_k=[12.0, 26.0])
    scenes = [{**calm.mission["scenes"][0], "temperature_c": at} for at in (5.0, water_c)]
    there = replace(
        calm, design=replace(design_of(calm), totals=totals), mission={**calm.mission, "scenes": scenes}
    )
    told = [(risk.what, risk.figure) for risk in risks_of(there)]
    assert told == ([("the camera may become too warm", "40 to 54 °C in water of 28 °C")] if is_told else [])


@pytest.mark.parametrize(
    ("used_wh", "what", "figure"),
    [
        (149.5, "the battery is nearly used up", "149.5 Wh of 150.0 Wh"),
        (121.0, "the battery is nearly used up", "121 Wh of 150 Wh"),
        (160.0, "the battery does not last", "160 Wh of 150 Wh"),
        (120.0, "", ""), (None, "", ""), (120.0 * (1.0 + 5e-10), "", ""),  # the search keeps a reserve to rounding
    ],
)  # fmt: skip
def test_a_battery_of_which_less_than_a_fifth_is_left_is_told(
    calm: Result, used_wh: float | None, what: str, figure: str
) -> None:
    totals = replace(design_of(calm).totals, energy_wh=used_wh)
    mission = {**calm.mission, "vehicle": {"battery_wh": 150.0}}
    there = replace(calm, design=replace(design_of(calm), totals=totals), mission=mission)
    assert [(risk.what, risk.figure) for risk in risks_of(there)] == ([(what, figure)] if what else [])
    assert risks_of(replace(there, mission={**calm.mission, "vehicle": {}})) == []


def test_rating_with_less_than_a_tenth_over_the_deepest_scene_is_told(calm: Result) -> None:
    at_100m = replace(calm, mission={**calm.mission, "scenes": [{**calm.mission["scenes"][0], "depth_m": 100.0}]})
    tight = only(with_margin(at_100m, margin("depth_rating_m (q)", 109.0, 100.0, ">=", "m")))
    assert tight.because.startswith("q ") and tight.figure == "109 m against 100 m"
    assert risks_of(with_margin(at_100m, margin("depth_rating_m (q)", 111.0, 111.0, ">=", "m"))) == []  # as asked for


def test_ratings_that_leave_little_are_one_risk_and_a_slight_one_where_they_are_asked_for(calm: Result) -> None:
    """A dome and a lamp rated to 6000 m, as was asked for 5500 m, were two of the three greatest risks."""
    deep = {**calm.mission, "scenes": [{**calm.mission["scenes"][0], "depth_m": 5500.0}]}
    rated = [margin(f"depth_rating_m ({part})", 6000.0, 6000.0, ">=", "m") for part in "qr"]
    widest = replace(margin("f_number_min", 2.8, 2.8, ">=", ""), binding=True)
    scene = replace(design_of(calm).scenes[0], margins=[*rated, widest, margin("min_snr_db", 33.0, 30.0, ">=", "dB")])
    bare = replace(with_scene(calm, scene), mission=deep)
    assert [risk.what for risk in risks_of(bare)] == ["parts may not stand the pressure", "the lens is used wide open"]
    asked = replace(bare, mission={**deep, "limits": {"depth_rating_m": 6000.0}})
    assert [risk.what for risk in risks_of(asked)] == ["the lens is used wide open", "parts may not stand the pressure"]
    told = risks_of(asked)[1]
    assert told.because == (
        "q and r are rated for little more than the depth of the mission, as limits.depth_rating_m allows"
    )
    assert told.figure == "6 000 m against 5 500 m"


def test_lens_at_its_widest_is_told(calm: Result) -> None:
    widest = replace(margin("f_number_min", 2.8, 2.8, ">=", ""), binding=True)
    assert only(with_margin(calm, widest)).figure == "f/2.8"


def test_price_above_the_limit_at_its_high_end(calm: Result) -> None:
    risk = only(with_cost(calm, 1000.0, value=900.0, low=500.0, high=1100.0, estimated=450.0))
    assert risk.figure == "up to 1 100 against 1 000 USD" and risk.because == "50 % of the price is estimated"
    assert only(with_cost(calm, 1200.0, low=500.0, high=1100.0, estimated=450.0)).figure == "500 to 1 100 USD"
    assert risks_of(with_cost(calm, 1200.0, low=800.0, high=1100.0, estimated=90.0)) == []
    nearly = only(with_cost(calm, 1000.0, value=900.0, low=500.0, high=1100.0, estimated=899.0))
    assert nearly.because == "nearly all of the price is estimated"  # a part of it is quoted


def test_a_price_just_above_its_limit_is_told_as_such(calm: Result) -> None:
    risk = only(with_cost(calm, 8000.0, value=7000.0, low=2000.0, high=8040.0, estimated=450.0))
    assert risk.figure == "up to 8 040 against 8 000 USD"


def test_price_weighs_by_how_wide_its_range_is(calm: Result) -> None:
    # 10 % wide it is less than a lens wide open, from half to one and a half it is more
    lens = replace(margin("f_number_min", 2.8, 2.8, ">=", ""), binding=True)
    for low, high, first in ((950.0, 1050.0, "the lens"), (500.0, 1500.0, "the price")):
        priced = with_cost(with_margin(calm, lens), None, value=1000.0, low=low, high=high, estimated=900.0)
        assert risks_of(priced)[0].what.startswith(first)


def test_parts_to_be_made_are_counted(calm: Result) -> None:
    hardware = design_of(calm).hardware
    made = replace(hardware, port=replace(hardware.port, generic=True))
    risk = only(replace(calm, design=replace(design_of(calm), hardware=made)))
    assert risk.figure == "1 of 4 parts" and risk.because.startswith("port must be")


def test_notes_are_told_once_unless_a_rule_tells_them(calm: Result) -> None:
    notes = [Note("lamp_in_view", "light", "a lamp is seen"), Note("uneven_light", "light", "uneven")]
    result = replace(calm, warnings=notes, design=replace(design_of(calm), warnings=notes))
    assert only(result).what == "a lamp is seen"


def test_most_serious_stands_first(calm: Result) -> None:
    # fails now, fails at bad ends, fails in other water, costs too much, wide open: in this order
    result = with_margin(calm, replace(margin("f_number_min", 2.8, 2.8, ">=", ""), binding=True))
    result = with_cost(result, 1000.0, high=1100.0, estimated=450.0)
    result = replace(result, robustness={"feasible_at_bad_end": False, "waters": WATERS})
    result = with_margin(result, margin("max_blur_px", 2.0, 1.0, "<=", "px"))
    starts = ["motion blur", "it may not do", "it fails in water", "it may cost", "the lens"]
    found = [risk.what for risk in risks_of(result)]
    assert len(found) == len(starts)
    assert all(what.startswith(start) for what, start in zip(found, starts, strict=True)), found


def test_results_carry_their_risks(base: Result) -> None:
    assert base.risks == risks_of(base) != []
    assert Result.from_dict(base.to_dict()).risks == base.risks


def test_parts_that_may_be_sold_no_longer_are_told(calm: Result) -> None:
    row = BillRow(
        kind="lens", id="q-lens", manufacturer="Q", model="L", count=1, owned=0, unit_price=1.0, unit_price_low=1.0,
        unit_price_high=1.0, currency="USD", price_status="list", price_date="", generic=False, source="",
        price_basis="", availability="unknown",
    )  # fmt: skip
    solved = replace(calm, command="solve", recommendation=replace(calm.design, bom=[row]), design=None)
    assert only(solved).because == "no source says so of q-lens"
    assert risks_of(replace(solved, recommendation=replace(calm.design, bom=[replace(row, owned=1)]))) == []


def test_scenarios_that_were_not_counted_are_the_first_risk(calm: Result) -> None:
    left_out = Note(AS_CENTRAL, "confidence", "this is the best with every estimate at its likeliest value: no time")
    late = with_figures(replace(calm, warnings=[left_out]), uniformity=0.05)
    assert [risk.what for risk in risks_of(late)] == [left_out.message, "part of the image is dark"]
    enough = Confidence(0.9, True, 0.96, 0.95, 0.97, 1024, 0.96, 256, 1.0, 1.1, 2.5, [])
    assert risks_of(replace(late, confidence=enough))[-1].what == left_out.message  # it is certain, however chosen
    rare = replace(late, confidence=replace(enough, enough=False))
    assert [risk.what for risk in risks_of(rare)][:2] == ["it may not do what is asked", left_out.message]


@pytest.mark.parametrize(("kept", "weightier"), [(0.007, True), (0.099, False)])
def test_corners_without_detail_weigh_by_what_they_lose_and_say_why(calm: Result, kept: float, weightier: bool) -> None:
    soft = with_figures(calm, mtf_half_nyquist_corner=kept, defocus_corner_px=2.5, lateral_colour_px=2.79)
    risk = only(soft)  # focus and colour are told as its causes
    assert risk.what == "fine detail is lost in the corners"
    assert risk.because == "they are out of focus by 2.50 px and the flat port spreads colours over 2.79 px"
    assert risk.figure == f"two-pixel bars keep {100 * kept:.2g} % of their contrast"
    note = Note("measure_the_camera", "housing", "measure the camera")
    first = risks_of(replace(soft, warnings=[note]))[0]
    assert (first == risk) == weightier


def test_corners_that_show_detail_are_no_risk(calm: Result) -> None:
    assert risks_of(with_figures(calm, mtf_half_nyquist_corner=0.11)) == []
    told = [risk.what for risk in risks_of(with_figures(calm, mtf_half_nyquist_corner=0.11, defocus_corner_px=2.5))]
    assert told == ["corners of the image are out of focus"]
    dim = only(with_figures(calm, mtf_half_nyquist_corner=0.05, defocus_corner_px=0.5))
    assert dim.because == "lens, diffraction and motion blur them"
    none = only(with_figures(calm, mtf_half_nyquist_corner=0.0))
    assert none.figure == "two-pixel bars keep none of their contrast"

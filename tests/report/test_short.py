"""The one page that comes first: what a buyer needs, in a buyer's words, the same in text and HTML."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from uwopt.api.risks.told import with_risks
from uwopt.mission.weakened import is_far
from uwopt.report.order.other_parts import other_systems
from uwopt.report.page.page import opening, report_html, status_words
from uwopt.report.text.console import print_blocks
from uwopt.report.text.helps import notes_beside
from uwopt.report.text.nothing_fits import helpful_lines, in_more_time, infeasible_block, miss_text
from uwopt.report.text.short import full_text_blocks, short_text_blocks
from uwopt.report.text.verdict import front_sentence, verdict
from uwopt.results.basis import Risk, WhyNothing
from uwopt.results.design import Note, SettableCheck
from uwopt.results.result import PartsLeft, Result

Make = Callable[..., Any]
#: What belongs to the proof or to the search, and nobody who buys can read.
NOT_FOR_BUYERS = (
    "regret", "unbounded", "binding", "binds", "lamp leg", "K =", "K_d", "a + b_b", "dioptric", "rows open",
    "quotes that matter", "proven best", "certificate", "lower bound", "gap", "combination", "enumerat", "incumbent",
    "objective", "minimis", "maximis", "optimum", "feasible", "node", "hypervolume", "None", "nan",
)  # fmt: skip
KEY = re.compile(r"\b[a-z]+_[a-z_]+\b")  # of a file, such as min_snr_db
WATERS = [
    {"case": {"water_table": "measured", "lamp_attenuation": "the least"}, "objective_value": 41.0},
    {"case": {"water_table": "measured", "lamp_attenuation": "the most"}, "objective_value": None, "changes": True},
    {"case": {"water_table": "other", "lamp_attenuation": "as the model has it"}, "objective_value": None},
]  # fmt: skip
TILT = {
    "held_outward_deg": 0.0, "held_inward_deg": 0.3, "readjusted_outward_deg": 2.5, "readjusted_inward_deg": 16.0,
    "first_to_break": ["mean_level", "min_snr_db"], "tried_up_to_deg": 16.0,
}  # fmt: skip


def text_of(result: Result, full: bool = False) -> str:
    """What is printed, on one line."""
    stream = io.StringIO()
    print_blocks((full_text_blocks if full else short_text_blocks)(result), stream)
    return " ".join(stream.getvalue().split())


@pytest.fixture
def doubtful(make_result: Make) -> Result:
    """A result that has everything to doubt."""
    made = make_result()
    places = {"gain_rel": 0.1, "baseline_m": 1.0, "tilt_deg": 3.0}
    doubt = {"feasible_at_bad_end": False, "max_regret": None, "waters": WATERS, "tilt": TILT}
    doubt = made.robustness | doubt | {"outside_certificate": places}
    return with_risks(replace(made, robustness=doubt))


def test_settings_that_were_not_rounded_are_no_settings_to_type_in(doubtful: Result) -> None:
    assert doubtful.best is not None and "not settings to type in" not in text_of(doubtful)
    exact = replace(doubtful, recommendation=replace(doubtful.best, rounded=None))
    assert "These are exact values, not settings to type in: for these no time was left" in text_of(exact)
    assert "not settings to type in" not in text_of(replace(exact, command="evaluate"))  # as the user has set them


def test_page_has_its_five_sections_in_their_order(doubtful: Result) -> None:
    text = text_of(doubtful)
    heads = ["Buy", "What it costs", "The three greatest risks", "Measure or quote first", "Set", "--full"]
    assert sorted(heads, key=text.index) == heads


def test_first_line_tells_how_far_the_answer_may_be_believed(doubtful: Result) -> None:
    verdict, _, rest = text_of(doubtful).partition(" Goal: ")
    assert verdict == "Reef [red]survey[/red]: best of the catalogue under these assumptions, proven"
    assert rest.startswith("least power, 40.50 W at these settings (40.00 W before rounding).")


def test_a_search_that_was_stopped_tells_what_there_is_to_choose_from(make_result: Make) -> None:
    """`catalog.lenses: [zeiss]` leaves six: "a mission with fewer parts to choose from" was no help."""
    parts = PartsLeft(cameras=121, lenses=6, ports=5, lights=1, housings=12)
    made = make_result(status="stopped", recommendation=None, runners_up=[])
    assert made.certificate is not None
    made = replace(made, certificate=replace(made.certificate, best_value=None, parts_left=parts))
    left = "The mission leaves 121 cameras, 6 lenses, 5 ports, 12 housings, 1 light to choose from, and nothing"
    for lenses, helps in ((["zeiss"], "or widen catalog.lenses, which leaves 6."), ([], "or leave fewer parts.")):
        text = text_of(replace(made, mission={"name": "x", "catalog": {"lenses": lenses, "cameras": ["flir"]}}))
        assert left in text and f"(--seconds 60, or none: then it ends with its proof), {helps}" in text
    of_old = replace(made, certificate=replace(made.certificate, parts_left=None))
    assert "then it ends with its proof), or a mission with fewer combinations." in text_of(of_old)


@pytest.mark.parametrize(
    ("vehicle", "advice"),
    [
        ({"light_baseline_m": [0.3, 1.2], "light_tilt_deg": [-30.0, 30.0]}, ": narrow vehicle.light_baseline_m or "
         "vehicle.light_tilt_deg."),
        ({"light_baseline_m": [0.6, 0.6], "light_tilt_deg": [-30.0, 30.0]}, ": narrow vehicle.light_tilt_deg."),
        ({"light_baseline_m": 0.6}, "."),
    ],
)  # fmt: skip
def test_a_search_that_was_stopped_tells_in_how_many_places_lamps_are_tried(
    make_result: Make, vehicle: dict[str, Any], advice: str
) -> None:
    """A quay wall with a free baseline and tilt: 475 places, no system in 420 s, and no word of why."""
    parts = PartsLeft(cameras=121, lenses=6, ports=5, lights=5, places=475)  # 19 baselines, 25 tilts
    made = make_result(status="stopped", recommendation=None, runners_up=[])
    assert made.certificate is not None
    made = replace(made, certificate=replace(made.certificate, best_value=None, parts_left=parts))
    there = replace(made, mission={"name": "x", "vehicle": vehicle})
    assert f"leave fewer parts; every lamp is tried in 475 places and tilts{advice}" in text_of(there)
    few = replace(made.certificate, parts_left=replace(parts, places=2))
    assert "places and tilts" not in text_of(replace(there, certificate=few))


def test_a_front_that_was_stopped_tells_what_there_is_to_choose_from(make_front: Make) -> None:
    proof = {"scope": "the words of a proof are nobody's data: 9 lenses, 9 lights"}
    told = in_more_time(make_front(points=0, status="stopped", certificate=proof))
    assert told == "Give it more time (--seconds 60), or a mission with fewer combinations"  # it took 7 s
    proof |= {"parts_left": {"cameras": 1, "lenses": 2, "ports": 3, "lights": 4, "complete_cameras": 1}}
    told = in_more_time(make_front(points=0, status="stopped", certificate=proof))
    assert "leaves 1 camera, 2 lenses, 3 ports, 1 complete camera, 4 lights to choose from" in told
    told = in_more_time(make_front(points=0, status="interrupted", certificate=proof))  # nobody gave a time
    assert ". Let it run to its end, or" in told and "--seconds" not in told


@pytest.mark.parametrize(
    ("status", "said"), [("complete", "are left"), ("stopped", "are found so far"), ("interrupted", "are found so far")]
)
def test_a_front_whose_search_was_stopped_does_not_call_its_hardware_what_is_left(
    make_front: Make, status: str, said: str
) -> None:
    assert front_sentence(make_front(status=status)).startswith(f"3 choices of hardware {said}, in 8 settings")


def set_at(design: Any, power_w: float) -> Any:
    """A design that can be set, and then draws so much."""
    scenes = [replace(one, settings_to_set=one.settings, figures_as_set=one.figures) for one in design.scenes]
    totals = replace(design.totals, power_w=power_w)
    return replace(design, scenes=scenes, rounded=SettableCheck(True, power_w, [], power_w, totals))


def test_a_front_is_told_at_settings_that_can_be_set(make_front: Make) -> None:
    """The first sentence sold 2.97 Mbit/m² of a system that has 2.74 as a person can set it."""
    front = make_front("power", "cost", points=2)
    (first, second) = front.points
    told = front.as_told(replace(second, design=set_at(second.design, 41.5)))
    assert (told.values["power"], told.values["cost"]) == (41.5, second.values["cost"])
    assert front.as_told(first).values == first.values  # of which no settings are known
    said = front_sentence(replace(front, points=[replace(first, design=set_at(first.design, 44.4)), second]))
    assert "44.4 W" in said and "40.0 W" not in said


def test_sharpness_without_end_is_told(make_result: Make, make_design: Any, make_scene: Any) -> None:
    """A net pen's camera was sharp from 0.9 m on, and the page said nothing of its depth of field."""
    far = make_scene("pen")
    far.figures.update(dof_m=None, dof_near_m=0.9, dof_far_m=None, dof_far_is_infinite=True)
    assert "sharp from 0.900 m to infinity" in text_of(make_result(recommendation=make_design(scenes=[far])))


def test_images_are_told_with_the_distance_at_which_they_are_taken(make_result: Make) -> None:
    """A pixel of 0.86 mm at 2 m is one of 0.97 mm at the far end of the band, which no limit is held against here."""
    flown = {"name": "x", "vehicle": {"altitude_m": 2.0, "altitude_tolerance_m": 0.25}}
    assert "Images at the nominal altitude, 2 m: " in text_of(make_result(mission=flown))
    assert "Images: " in text_of(make_result(mission={"name": "x"}))
    scenes = [{"name": "bait", "vehicle": {"altitude_m": 1.2}}, {"name": "visitors", "vehicle": {"altitude_m": 2.5}}]
    swimming = make_result(mission=flown | {"scenes": scenes})
    assert "Images at the nominal altitudes, 1.2 m to 2.5 m: " in " ".join(text_of(swimming).split())


def test_parts_are_bought_at_what_is_left_to_pay_as_a_range(doubtful: Result) -> None:
    # of two lamps at 1 700 to 3 400 USD one is owned
    text = text_of(doubtful)
    assert "2 x light Acme Lamp 1 700 to 3 400 USD" in text
    assert (
        "price 3 600 to 5 400 USD, sum of the likeliest prices about 4 200; 55 % of it not quoted" in text
    )  # 2300 / 4210
    assert "Ask for a quote: 1 x Acme Lamp, 1 700 to 3 400 USD." in text


def test_limit_that_the_high_end_exceeds_is_told(make_result: Make) -> None:
    high = "Its high end is above your limit of 5 000 USD."
    for limit, told in ((5000.0, high), (6000.0, ""), (4000.0, "It is above")):
        text = text_of(make_result(mission={"name": "x", "limits": {"cost": limit, "currency": "USD"}}))
        assert told in text
        assert ("above your limit" in text) == bool(told)


def test_settings_are_those_to_set_without_the_exact_ones(doubtful: Result) -> None:
    text = text_of(doubtful)
    assert "exposure 12.345 ms gain 6.1 dB" in text and "43.5678" not in text


def test_three_risks_are_shown_with_figure_and_reason(make_result: Make) -> None:
    risks = [Risk(f"risk {n}", f"reason {n}", f"{n} W" if n != 2 else "") for n in (1, 2, 3, 4)]
    text = text_of(make_result(risks=risks))
    assert "1. Risk 1 (1 W): reason 1. 2. Risk 2: reason 2. 3. Risk 3 (3 W): reason 3." in text
    assert "isk 4" not in text


def test_numbers_to_ask_for_have_names_that_a_maker_knows(make_result: Make) -> None:
    asked = {"part": "cam", "kind": "camera", "field": "qe_scale", "value": 0.95, "low": 0.8, "high": 1.1, "unit": ""}
    text = text_of(make_result(robustness={"quotes_that_matter": [asked]}))
    assert "quantum efficiency (as a factor) of cam ~0.950 (0.800 to 1.10)" in text
    asked = {"part": "strobe", "kind": "light", "field": "flash_duration_at_frac", "value": 0.07, "low": 0.01,
             "high": 0.5, "unit": ""}  # fmt: skip
    told = text_of(make_result(robustness={"quotes_that_matter": [asked]}))
    assert "light left when the stated flash duration ends (share of the peak) of strobe ~0.0700" in told


def test_what_decides_is_asked_first_then_the_water(doubtful: Result) -> None:
    asked = text_of(doubtful).partition("Measure or quote first")[2]
    assert (
        asked.index("price of acme-lamp")
        < asked.index("1 of 3 other descriptions")
        < asked.index("light leaves")
    )


@pytest.mark.parametrize("kind", ["doubtful", "plain", "violated", "infeasible", "stopped", "not settable"])
def test_page_has_no_words_of_the_search(
    doubtful: Result, make_result: Make, make_design: Make, make_scene: Make, make_margin: Make, kind: str
) -> None:
    missed = make_scene("reef", margins=[make_margin("max_blur_px", 2.0, 1.0, "<=", "px", satisfied=False)])
    why = {
        "requirements": [{"name": "min_snr", "n_excluded": 12_000, "n_is_bound": True}],
        "relaxations": [{"name": "cost", "limit": 500.0, "needed": 620.0, "miss_rel": 0.24}],
        "nearest_miss": make_design(scenes=[missed]),
    }
    unset = replace(
        make_design(), rounded={"feasible": False, "objective_value": 41.0, "missed": ["max_blur_px"]}
    )
    nothing = {"recommendation": None, "runners_up": [], "generic_alternative": None}
    result = {
        "doubtful": doubtful,
        "plain": make_result(warnings=[]),
        "violated": make_result(command="evaluate", status="violated", design=make_design(scenes=[missed]), **nothing),
        "infeasible": make_result(status="infeasible", infeasible=why, **nothing),
        "stopped": make_result(status="stopped"),
        "not settable": make_result(status="feasible", recommendation=unset),
    }[kind]  # fmt: skip
    text = text_of(with_risks(result))
    assert [word for word in NOT_FOR_BUYERS if re.search(rf"\b{re.escape(word)}", text)] == []
    assert KEY.findall(text) == []


def test_all_words_of_the_search_are_gone_from_doubts_too(doubtful: Result) -> None:
    text = text_of(doubtful, full=True).casefold()
    for word in (
        "regret",
        "unbounded",
        "lamp leg",
        "k_d",
        "a + b_b",
        "quotes that matter",
        "proven best",
        "binding",
    ):
        assert word not in text
    assert "any that fits: with its estimates at their bad ends this system misses a requirement" in text
    assert "other table, lamp light lost as modelled: this system misses a requirement" in text


def test_all_that_a_given_system_misses_is_told_at_once_where_it_is_worst(
    make_result: Make, make_design: Make, make_scene: Make, make_margin: Make
) -> None:
    asked = {"max_blur_px": "px", "max_skew_px": "px", "max_gsd_mm": "mm", "max_airy_px": "px"}
    missed = [make_margin(name, 2.0, 1.0, "<=", unit, satisfied=False) for name, unit in asked.items()]
    worse = make_margin("max_blur_px", 3.0, 1.0, "<=", "px", satisfied=False)
    design = make_design(scenes=[make_scene("reef", margins=missed), make_scene("sand", margins=[worse])])
    result = with_risks(make_result(command="evaluate", status="violated", recommendation=None, design=design))
    text = text_of(result)
    (told,) = re.findall("Missed .* The system", text)
    for row in ("motion blur 3.000 px", "rolling-shutter skew 2.000", "pixel on the floor 2.000 mm", "Airy disc 2.000"):
        assert told.count(row) == 1
    assert "motion blur 2.000" not in told
    assert result.risks[0].what == "motion blur is not as asked for" and "as asked for" not in text  # told once
    assert "Buy" not in text


def test_nothing_fits_tells_what_would_help(make_result: Make, make_design: Make) -> None:
    why = {"requirements": [], "relaxations": [{"name": "cost", "limit": 500.0, "needed": 620.0, "miss_rel": 0.24}],
           "nearest_miss": make_design()}  # fmt: skip
    text = text_of(make_result(status="infeasible", recommendation=None, runners_up=[], infeasible=why))
    assert "What would help" in text and "cost 500.0 USD 620.0 USD" in text
    assert "What comes nearest" in text and "2 x light Acme Lamp" in text and "out of reach" not in text
    doubtful = {"name": "Reef", "limits": {"currency": "USD"}, "confidence": 0.9}
    brink = "to hold as often in the doubt as the mission asks (confidence) takes more than them"
    in_doubt = make_result(
        status="infeasible", recommendation=None, runners_up=[], infeasible=why, mission=doubtful
    )  # fmt: skip
    assert brink in text_of(in_doubt) and brink not in text
    noise = {**why, "relaxations": [{"name": "min_snr", "limit": 20.0, "needed": 0.97, "miss_rel": 0.95}]}
    text = text_of(make_result(status="infeasible", recommendation=None, runners_up=[], infeasible=noise))
    assert "What comes nearest, and is out of reach" in text


def test_html_begins_with_the_sections_of_the_text(doubtful: Result) -> None:
    page = " ".join(
        re.sub(r"<[^>]+>", " ", report_html(doubtful).partition('<section id="short"')[2]).split()
    )
    for words in ("Buy", "1 700 to 3 400 USD", "What it costs", "sum of the likeliest prices about 4 200",
                  "The three greatest risks", "Measure or quote first", "light leaves the lamp"):  # fmt: skip
        assert page.index(words) < page.index("Certificate")


# ---------------------------------------------------------------- colour and what moves

COLOUR = Note(
    "colour_left_open", "requirements.colour",
    "Camera is mono: no colour was asked for; requirements.colour: colour asks for it",
)  # fmt: skip


def test_sensor_that_nobody_asked_for_is_told_on_the_page_and_is_no_risk(make_result: Make) -> None:
    made = with_risks(make_result(warnings=[COLOUR]))
    assert "Camera is mono: no colour was asked for; requirements.colour: colour asks for it." in text_of(made)
    assert "mono" not in " ".join(risk.what for risk in made.risks)


@pytest.mark.parametrize(("speed", "binding", "told"), [(0.5, True, True), (0.5, False, False), (0.0, True, False)])
def test_subject_that_decides_the_exposure_is_told(
    make_result: Make, make_design: Make, make_scene: Make, make_margin: Make, speed: float, binding: bool, told: bool
) -> None:
    blur = make_margin("max_blur_px", 1.0, 1.0, "<=", "px", binding=binding)
    best = make_design(scenes=[make_scene("reef", margins=[blur])])
    mission = {"name": "x", "limits": {"currency": "USD"}, "scenes": [{"name": "reef", "subject_speed_m_s": speed}]}
    text = text_of(make_result(mission=mission, recommendation=best))
    assert ("What moves there by itself at 0.500 m/s decides the exposure." in text) == told


def test_a_limit_that_only_high_prices_break_is_told_as_such(make_result: Make) -> None:
    nothing = {"recommendation": None, "runners_up": [], "generic_alternative": None, "status": "infeasible"}
    for fits in (True, False):
        cost = {"name": "cost", "limit": 500.0, "needed": 620.0, "miss_rel": 0.24, "fits_at_central_prices": fits}
        why = {"requirements": [], "relaxations": [cost], "nearest_miss": None}
        assert ("At the likeliest prices it would fit" in text_of(make_result(infeasible=why, **nothing))) == fits


def test_what_was_not_tried_is_not_told_to_be_in_vain(make_result: Make) -> None:
    nothing = {"recommendation": None, "runners_up": [], "generic_alternative": None, "status": "infeasible"}
    why = {"requirements": [], "relaxations": [], "nearest_miss": None}
    cut = why | {"not_known": ["cost"]}
    assert "at least two have to give" in text_of(make_result(infeasible=why, **nothing))
    assert "at least two have to give" not in text_of(make_result(infeasible=cut, **nothing))


def test_changes_that_help_together_alone_are_told_on_the_page(make_result: Make) -> None:
    nothing = {"recommendation": None, "runners_up": [], "generic_alternative": None, "status": "infeasible"}
    changes = [
        {"name": "min_snr", "limit": 60.0, "needed": 42.9, "miss_rel": 0.29},
        {"name": "min_swath_m", "limit": 9.0, "needed": 1.42, "miss_rel": 0.84},
    ]
    why = {"requirements": [], "relaxations": [], "nearest_miss": None, "together": changes}
    text = text_of(make_result(infeasible=why, **nothing))
    assert "these together would let a system through; less of some may do:" in text
    assert "42.9" in text and "1.42" in text


def test_smaller_changes_together_stand_below_those_that_help_alone(make_result: Make) -> None:
    nothing = {"recommendation": None, "runners_up": [], "generic_alternative": None, "status": "infeasible"}
    snr, blur = ({"name": name, "limit": 1.0, "needed": 2.0, "miss_rel": 1.0} for name in ("min_snr", "max_blur_px"))
    alone = {"requirements": [], "relaxations": [snr], "nearest_miss": None}
    for together in ([], [snr, blur]):
        made = make_result(infeasible=alone | {"together": together}, **nothing)
        shown = "".join(str(line) for line in helpful_lines(made))
        assert ("Or these together" in shown) == bool(together)


def test_what_helps_in_the_water_as_it_is_is_told_beside_clearer_water(make_result: Make) -> None:
    """Nobody can order water: that it would help alone is no answer."""
    nothing = {"recommendation": None, "runners_up": [], "generic_alternative": None, "status": "infeasible"}
    snr = {"name": "min_snr", "limit": 30.0, "needed": 9.0, "miss_rel": 0.7}
    why = {"requirements": [], "relaxations": [], "nearest_miss": None, "together": [snr]}
    for key, asked, needed, in_water in (("water", "9C", "I", True), ("visibility_m", 1.0, 9.0, True),
                                         ("altitude_m", 3.0, 1.0, False)):  # fmt: skip
        move = {"name": key, "asked": asked, "needed": needed, "unit": "", "nearest": False}
        made = make_result(infeasible=why | {"moves": [move]}, **nothing)
        shown = "".join(str(line) for line in helpful_lines(made))
        assert ("In the water as it is" in shown) == in_water
        assert ("signal to noise" in verdict(made)[1]) == in_water


def test_where_no_change_helps_the_rules_that_exclude_most_are_told(make_result: Make) -> None:
    counts = {"camera: purpose": 900, "mount": 5, "max_gsd_mm": 70, "min_swath_m": 80, "image_circle": 60}
    rules = [{"name": name, "n_excluded": n, "n_is_bound": False} for name, n in counts.items()]
    nothing = {"recommendation": None, "runners_up": [], "generic_alternative": None, "status": "infeasible"}
    why = {"requirements": rules, "relaxations": [], "nearest_miss": None}
    for own, altitude_m, told in (
        (None, 3.0, "(min_swath_m 1, by refuse: swath)"), (None, 0.6, "(min_swath_m 0.4, by refuse: swath)"),
        (2.0, 0.6, "(min_swath_m)"),
    ):  # fmt: skip
        asked = {"min_swath_m": own, "max_gsd_mm": 1.0}
        vehicle = {"altitude_m": altitude_m, "altitude_tolerance_m": 0.2}
        mission = {"name": "x", "requirements": asked, "vehicle": vehicle}
        text = " ".join(text_of(make_result(mission=mission, infeasible=why, **nothing)).split())
        first = f"Most combinations are excluded by: swath too narrow {told}"
        assert f"{first}; pixel on the floor too large (max_gsd_mm); image circle" in text
    scenes = [{"vehicle": {"altitude_m": 0.5}}, {"vehicle": None}]
    mission = {"name": "x", "requirements": {"max_gsd_mm": 1.0}, "vehicle": {"altitude_m": 3.0}, "scenes": scenes}
    assert "(min_swath_m 0.5 or 1, by refuse: swath)" in " ".join(
        text_of(make_result(mission=mission, infeasible=why, **nothing)).split()
    )


@pytest.mark.parametrize("own", [None, 2.0])
def test_who_is_refused_by_good_practice_is_not_told_to_have_asked(own: float | None, make_result: Make) -> None:
    """A mission that says nothing of an Airy disc was told to "meet all that the mission itself says but Airy"."""
    airy = {"name": "max_airy_px", "limit": 2.0, "needed": 2.68, "miss_rel": 0.34}
    why = {"requirements": [], "relaxations": [airy], "nearest_miss": None}
    nothing = {"recommendation": None, "runners_up": [], "generic_alternative": None, "status": "infeasible"}
    note = {"code": "practice_in_vain", "path": "practice", "message": "x"}
    mission = {"name": "x", "requirements": {"max_gsd_mm": 1.0, "max_airy_px": own}}
    made = make_result(mission=mission, infeasible=why, warnings=[note], **nothing)
    whose, by = ("is asked", ", by refuse: airy") if own is None else ("the mission itself says", "")
    assert miss_text(made).startswith(f"meets all that {whose} but Airy disc (max_airy_px{by}): 2.68")


def test_what_the_estimates_cannot_tell_apart_is_called_equal(make_result: Make, make_design: Make) -> None:
    others = [make_design(41.0, lens="q-lens"), make_design(42.0, lens="r-lens")]
    text = text_of(make_result(runners_up=others, robustness={"equal": [{"runner_up": 1}]}))
    said = "Equal within the estimates: this system, and the same with lens r-lens. Choose by quote and delivery."
    assert said in text and "q-lens" not in text


@pytest.mark.parametrize("code", ["better_unsettable", "other"])
def test_what_cannot_be_set_is_offered_in_no_place(make_result: Make, make_design: Make, code: str) -> None:
    """39 W by exact numbers was passed over for 40 W that can be set; 41 W can still be bought instead."""
    others = [make_design(39.0, lens="q-lens"), make_design(41.0, lens="r-lens")]
    note = Note(code, "hardware", "better parts have no settings")
    equal = {"equal": [{"runner_up": 0}, {"runner_up": 1}]}
    result = make_result(runners_up=others, robustness=equal, warnings=[note], alternatives=[])
    offered = code != "better_unsettable"
    assert ("q-lens" in text_of(result)) == offered and "r-lens" in text_of(result)
    told = [one.hardware["lens"] for one in other_systems(result)]
    assert ("q-lens" in told) == offered and "r-lens" in told


def test_cameras_with_the_same_sensor_are_told_in_one_line(make_result: Make) -> None:
    found = [
        {"part": f"maker-{n}", "name": f"Maker {n}", "interface": interface, "value": 40.0 + n}
        for n, interface in enumerate(("GigE", "", "USB3", "USB3"))
    ]
    text = text_of(make_result(robustness={"siblings": found}))
    said = ("The camera's sensor is also in Maker 0 (GigE, the system then 40.00 W), Maker 1 (the system then 41.00 W) "
            "and Maker 2 (USB3, the system then 42.00 W) and in 1 more: each meets the mission "
            "in its place.")  # fmt: skip
    assert said in text
    assert "The camera's sensor is also in Maker 0 (GigE, the system then 40.00 W): meets" in text_of(
        make_result(robustness={"siblings": found[:1]})
    )
    assert "sensor is also" not in text_of(make_result(robustness={"siblings": []}))
    # of systems for 4 210 USD and their like nobody knows five digits, nor is 10 USD a reason
    priced = [one | {"value": value} for one, value in zip(found, (4220.0, 4523.4, 3870.0), strict=False)]
    plain = make_result(robustness={"siblings": priced})
    cheapest = text_of(replace(plain, objective=replace(plain.objective, name="cost", unit="USD")))
    assert "Maker 0 (GigE), Maker 1 (310 USD more) and Maker 2 (USB3, 340 USD less): each meets" in cheapest


def test_of_equal_systems_the_cheapest_are_told_with_what_they_save(make_result: Make, make_design: Make) -> None:
    best, dear, cheap, like = (
        replace(made, totals=replace(made.totals, cost=replace(made.totals.cost, value=cost)))
        for cost, made in ((cost, make_design(lens=f"{cost:g}-lens")) for cost in (5000.0, 5600.0, 4600.0, 5040.0))
    )
    equal = {"equal": [{"runner_up": place} for place in range(3)]}
    text = " ".join(text_of(make_result(recommendation=best, runners_up=[dear, cheap, like], robustness=equal)).split())
    assert "the same with lens 4600-lens, 400 USD less; lens 5040-lens; 1 more." in text


def test_same_hardware_set_otherwise_is_no_choice(make_result: Make, make_design: Make) -> None:
    same, other = make_design(41.0), make_design(42.0, lens="r-lens")
    both = {"equal": [{"runner_up": 0}, {"runner_up": 1}]}
    text = text_of(make_result(runners_up=[same, other], robustness=both))
    assert "the same with lens r-lens. Choose" in text and "other settings" not in text
    assert "Equal within" not in text_of(make_result(runners_up=[same], robustness={"equal": [{"runner_up": 0}]}))


def test_signal_to_noise_is_told_as_the_mean_that_it_is(make_result: Make) -> None:
    assert "mean signal to noise 30.0 dB" in text_of(make_result())


@pytest.mark.parametrize(("needed", "far"), [(29_000.0, False), (30_000.0, True), (300.5, False), (299.0, True)])
def test_ten_times_what_is_asked_is_called_out_of_reach(make_result: Make, needed: float, far: bool) -> None:
    cost = {"name": "cost", "limit": 3000.0, "needed": needed, "miss_rel": 1.0, "nearest": True}
    speed = {"name": "speed_m_s", "asked": 3000.0, "needed": needed, "unit": "m_s", "nearest": True}
    for why in ({"relaxations": [cost]}, {"relaxations": [], "moves": [speed]}):
        made = make_result(
            status="infeasible", recommendation=None, runners_up=[],
            infeasible={"requirements": [], "nearest_miss": None} | why,
        )  # fmt: skip
        text = text_of(made)
        assert ("Out of reach" in text) == far and ("Each of these changes" in text) != far


def test_decibels_are_not_out_of_reach_by_their_ratio(make_result: Make) -> None:
    snr = {"name": "min_snr", "limit": 70.0, "needed": 6.5, "miss_rel": 0.9}
    why = {"requirements": [], "nearest_miss": None, "relaxations": [snr]}
    text = text_of(make_result(status="infeasible", recommendation=None, runners_up=[], infeasible=why))
    assert "Each of these changes" in text and "6.500 dB less may do" in text


def test_what_does_not_help_is_told_with_what_stands_in_the_way(make_result: Make) -> None:
    gives = [("min_snr", ["min_swath_m"]), ("power_w", ["light", "max_white_balance"]), ("cost", ["min_swath_m"])]
    useless = [{"name": name, "still": still} for name, still in gives]
    why = {"requirements": [], "nearest_miss": None, "relaxations": [], "no_help": useless}
    why["not_known"] = ["overlap", "water"]
    made = make_result(status="infeasible", recommendation=None, runners_up=[], infeasible=why)
    told = " ".join(str(line) for line in infeasible_block(made).lines)
    assert "moved far: signal to noise (min_snr_db) and cost (even so swath too narrow)" in told
    assert "; power (power_w) (even so no light gives the wanted signal, or colours too far apart)." in told
    assert "relax overlap along track (overlap) or type of water (water)." in told
    begun = why | {"in_part": {"overlap": 66507}}
    made = make_result(status="infeasible", recommendation=None, runners_up=[], infeasible=begun)
    told = " ".join(str(line) for line in infeasible_block(made).lines)
    assert "water (water) (without overlap along track 66 507 systems were looked at in vain, not yet all)." in told
    assert "Which single change" not in told  # as that says no more


def test_moves_and_contradictions_are_told(make_result: Make) -> None:
    moves = [{"name": "speed_m_s", "asked": 1.5, "needed": 0.62, "unit": "m_s", "nearest": True},
             {"name": "water", "asked": "III", "needed": "IB", "unit": "", "nearest": False}]  # fmt: skip
    why = {"requirements": [], "relaxations": [], "nearest_miss": None, "moves": moves,
           "contradiction": ["min_snr", "min_swath_m"]}  # fmt: skip
    text = text_of(make_result(status="infeasible", recommendation=None, runners_up=[], infeasible=why))
    assert "speed (speed_m_s) 1.500 m/s 0.6200 m/s no less will do type of water (water) III IB less may do" in text
    assert "whether less than what is told of type of water (water) is enough. uwopt explain with" in text
    assert "These contradict each other" in text and "swath (min_swath_m)" in text
    unmet = why | {"contradiction": [], "unmet": ["min_snr", "cost"]}
    text = text_of(make_result(status="infeasible", recommendation=None, runners_up=[], infeasible=unmet))
    assert "all of them have to give: signal to noise (min_snr_db) and cost" in text


@pytest.mark.parametrize(("most_db", "darkest_db", "told"), [
    (9.4, -2.0, "Images are very noisy: signal to noise 9 dB over 95 % of the frame, -2 dB in its darkest place; "),
    (20.0, -2.0, "Images are very noisy: signal to noise 20 dB over 95 % of the frame, -2 dB in its darkest place; "),
    (9.4, None, "Images are very noisy: signal to noise 9 dB over 95 % of the frame; "),
    (20.0, 12.0, ""), (None, None, ""),
])  # fmt: skip
def test_very_noisy_images_are_told_before_that_all_that_is_asked_is_held(
    make_result: Make, most_db: float | None, darkest_db: float | None, told: str
) -> None:
    result = make_result()
    result.best.scenes[0].figures.update(snr_db_p05=most_db, snr_db_min=darkest_db)
    assert opening(result)[0].startswith(told + ("best of" if told else "Best of"))
    assert f": {told[:1].lower()}{told[1:]}best of" in text_of(result)
    assert status_words(result)[1] == ("warn" if told else "good")


def test_what_is_not_known_yet_is_said_once(make_result: Make) -> None:
    given = "the time that was given is over; not worked out: "
    open_yet = "whether it could be met without min_snr; whether another altitude_m would do"
    why = WhyNothing([], [], None, [], not_known=["min_snr", "altitude_m"])
    nothing = {"recommendation": None, "runners_up": [], "generic_alternative": None, "status": "infeasible"}
    for more, left in (("", None), ("; whether fewer changes together would do", "fewer changes together")):
        late = make_result(warnings=[Note("time", "", given + open_yet + more)])
        late = replace(late, infeasible=why, **nothing)
        for text in (text_of(late), *(str(one.message) for one in notes_beside(late))):
            assert "could be met without" not in text and "another altitude" not in text
        assert "Not known yet: whether it is enough to relax signal to noise" in text_of(late)
        assert ("Left out" in text_of(late)) is (left is not None) and (left or "") in text_of(late)


def test_a_signal_in_as_much_noise_is_out_of_reach() -> None:
    assert is_far("min_snr", 20.0, 0.97) and not is_far("min_snr", 30.0, 8.8) and not is_far("min_snr", 3.0, None)


def test_what_was_left_out_for_want_of_time_stands_on_the_page(make_result: Make) -> None:
    told = "the time that was given is over; not worked out: second opinions"
    late = make_result(warnings=[Note("time", "", told), Note("interrupted", "", "interrupted: the system is proven")])
    text = text_of(late)
    assert "Left out The time that was given is over; not worked out: second opinions. Interrupted: the system" in text
    assert "Left out" not in text_of(make_result())
    nothing = {"recommendation": None, "runners_up": [], "generic_alternative": None}
    assert "Left out" in text_of(replace(late, status="infeasible", **nothing))
    assert "Left out" not in text_of(replace(late, status="stopped", **nothing))  # the verdict says so


def test_a_battery_that_is_most_of_the_price_is_named(make_result: Make) -> None:
    """A lander missed its budget by a battery of up to 8 700 EUR, and nobody spoke of it."""
    design = make_result().recommendation
    lamp = design.bom[-1]
    battery = replace(
        lamp, id="rest-battery", kind="extra", manufacturer="", model="battery in its housing, 2000 Wh", count=1,
        owned=0, generic=False, unit_price=4000.0, unit_price_low=2000.0, unit_price_high=8700.0,
    )  # fmt: skip
    cost = replace(design.totals.cost, value=8000.0, low=4000.0, high=13800.0)
    totals = replace(design.totals, cost=cost, energy_wh=430.0)
    own = replace(design, bom=[*design.bom, battery], totals=totals, rounded=None)
    told = "battery in its housing, 2000 Wh, of which the mission uses up 430 Wh"
    text = text_of(make_result(recommendation=own))
    assert f"most of it {told}" in text and "50 % of the price; vehicle.battery_wh sets it" in text
    dear = replace(own, totals=replace(totals, cost=replace(cost, value=10_100.0)))
    assert told not in text_of(make_result(recommendation=dear))


@pytest.mark.parametrize(("command", "told"), [("solve", "on purpose"), ("evaluate", "sharp farther away")])
def test_a_focus_nearer_than_what_is_sharp_is_on_purpose_only_where_it_was_chosen(
    doubtful: Result, command: str, told: str
) -> None:
    # a GoPro focused on the floor at 1 m behind a flat port is sharp to its corners from 1.21 m: nobody's purpose
    assert doubtful.best is not None
    scene = doubtful.best.as_set.scenes[0]
    near = replace(
        scene, settings={**scene.settings, "focus_distance_m": 1.0}, settings_to_set=None,
        figures={**scene.figures, "dof_near_m": 1.21},
    )  # fmt: skip
    text = text_of(replace(doubtful, command=command, recommendation=replace(doubtful.best, scenes=[near])))
    assert "nearer than what is sharp" in text and told in text
    assert ("on purpose" in text) is (command == "solve")

"""How certain a recommendation is, in words: against sentences written by hand."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from uwopt.api.risks.of_limits import uncertain
from uwopt.report.text.certainty import asked_text, certainty_block, decides_text, held_text, surer_block
from uwopt.report.text.console import print_blocks
from uwopt.report.text.doubts import robustness_block
from uwopt.report.text.layout import Block
from uwopt.report.text.short import full_text_blocks, short_text_blocks
from uwopt.results.basis import ObjectiveValue
from uwopt.results.certainty import Decides, WorthKnowing
from uwopt.results.design import Note
from uwopt.results.result import Result

COUNTED = {
    "asked": 0.9, "enough": True, "held": 0.95, "held_low": 0.94, "held_high": 0.96, "scenarios": 1024,
    "held_in_choice": 0.97, "scenarios_in_choice": 256, "p50_in_choice": 61.0, "objective_p50": 62.0,
    "objective_p90": 90.0, "f_number": 4.0, "lost_to": [], "drawn": ["reflectance of the floor"],
    "central_objective": 30.0, "central_held": 0.8, "central_p50": None,
}  # fmt: skip


def text_of(some: Block) -> str:
    """A block as it is printed, in one line."""
    stream = io.StringIO()
    print_blocks([some], stream)
    return " ".join(stream.getvalue().split())


@pytest.mark.parametrize(("name", "told"), [
    ("altitude beyond its band", "Measure how far the vehicle leaves its band of altitudes"),
    ("clarity of the water", "Measure clarity of the water"),
])  # fmt: skip
def test_what_is_to_be_measured_is_told_so_that_a_person_can(name: str, told: str) -> None:
    assert asked_text(WorthKnowing(name, "", 71.0)) == told


def test_the_worth_of_a_best_image_is_not_told_as_its_information(make_result: Callable[..., Result]) -> None:
    """92 kbit/m2, of which watts and money are taken off, stood beside the 522 kbit/m2 that the image has."""
    goal = ObjectiveValue("best_image", "maximise", 78.4e3, "bit/m2")
    of_others = COUNTED | {"central_hardware": ["acme-cam-9", "acme-lens-9"], "central_objective": 92.4e3}
    (block,) = certainty_block(replace(make_result(confidence=of_others), objective=goal))
    assert "best is 92.40 kbit/m², its power and price taken off, with acme-cam-9 and acme-lens-9;" in text_of(block)


def test_what_is_best_by_central_numbers_stands_beside_what_is_recommended(make_result: Callable[..., Result]) -> None:
    """Both in the scenarios of the choice; of its parts those that differ, or all; the same parts are told once."""
    best = make_result().best
    assert best is not None
    ours = best.hardware.ids
    for hardware, named in (
        (["acme-cam-9", *ours[1:]], "with acme-cam-9 instead;"),
        (["acme-cam-9", "acme-lens-9"], "with acme-cam-9 and acme-lens-9;"),
    ):
        result = make_result(confidence=COUNTED | {"central_hardware": hardware})
        (block,) = certainty_block(result)
        text = text_of(block)
        assert f"best is 30.00 W {named} that holds in 80 % of the 256 scenarios of the choice, what" in text
        assert "what is recommended in 97 %" in text and "61.00 W" not in text  # half of them do not hold without it
        assert "reflectance" not in text  # all that is drawn stands with what else was assumed
        assert "scenarios draw reflectance of the floor" in text_of(robustness_block(result))
    (block,) = certainty_block(make_result(confidence=COUNTED | {"central_hardware": ours}))
    alone = "30.00 W with the same parts, where iris, focus and lamps are set for these alone"
    assert alone in text_of(block) and "of the choice" not in text_of(block)


def printed(result: Result) -> str:
    """The first page in one line."""
    stream = io.StringIO()
    print_blocks(short_text_blocks(result), stream)
    return " ".join(stream.getvalue().split())


def test_what_is_made_best_is_told_in_words(make_result: Callable[..., Result]) -> None:
    """It read "snr db median 23.91 dB"."""
    goal = {"name": "snr_db", "direction": "maximise", "value": 40.0, "unit": "dB"}
    (block,) = certainty_block(make_result(confidence=COUNTED, objective=goal))
    assert "signal to noise median 62.00 dB" in text_of(block) and "snr db" not in text_of(block)


def test_the_median_of_the_scenarios_stands_beside_what_central_estimates_give(
    make_result: Callable[..., Result],
) -> None:
    """Else 40 W as set and 62 W in most scenarios contradict each other; what is set before it is seen, is not anew."""
    text = printed(make_result(confidence=COUNTED))
    both = "Goal: least power, 40.50 W at these settings with every estimate at its likeliest value"
    assert f"{both}, 62.00 W in the median scenario." in text
    assert "most of them need more light than the 40.0 W with every estimate at its likeliest value" in text
    near = printed(make_result(confidence=COUNTED | {"objective_p50": 41.0}))
    assert "set for each scenario else" not in near and "need more light" not in near
    seldom = printed(make_result(confidence=COUNTED | {"objective_p50": None}))
    assert "Goal: least power, 40.50 W at these settings (40.00 W before rounding)." in seldom


def test_the_first_page_begins_with_whether_it_works_and_what_fails_first(make_result: Callable[..., Result]) -> None:
    """It began with an interval of a share, and told the least margin where scenarios had told what fails."""
    lost = [{"requirement": "max_blur_px", "share": 0.01}, {"requirement": "min_dof_m", "share": 0.04}]
    text = printed(make_result(status="feasible", confidence=COUNTED | {"lost_to": lost}))
    head, _, rest = text.partition(" Buy ")
    assert "does what is asked in 95 % of 1 024 scenarios (90 % wanted) A scenario is water, parts and vehicle" in head
    assert "Fails first: depth of field, in 4 % of the scenarios." in head and "margin" not in head
    heads = ["What it costs", "Risks", "Measure or quote first", " Set ", "How certain"]
    assert sorted(heads, key=rest.index) == heads
    assert "in 95 % of 1 024 scenarios of what is uncertain (94 % to 96 %); 90 % asked" in rest


def test_what_a_person_interrupted_is_told_beside_the_verdict(make_result: Callable[..., Result]) -> None:
    """It read "proven" alone, where 90 % was asked for and nothing was counted."""
    note = [Note("interrupted", "", "interrupted: the system is proven")]
    mission = make_result().mission
    asked = make_result(warnings=note, mission=mission | {"confidence": 0.9})
    assert "proven; interrupted before it was counted how often that holds Goal:" in printed(asked)
    assert "proven; interrupted, so not all of its risks are told Goal:" in printed(make_result(warnings=note))


def test_a_share_of_few_scenarios_is_told_alike_everywhere(make_result: Callable[..., Result]) -> None:
    """The headline said 0.1 %, the first risk 0 %."""
    few = make_result(confidence=COUNTED | {"held": 0.0009, "enough": False})
    ((_, risk),) = uncertain(few, few.best)
    assert "in 0.1 % of the scenarios" in risk.because and "holds in 0.1 % of" in held_text(few.confidence)


def test_a_price_is_stated_once(make_result: Callable[..., Result]) -> None:
    """Its median in the scenarios, with the digits that its range leaves it, and no other middle of it beside that."""
    goal = {"name": "cost", "unit": "USD", "value": 4210.0, "direction": "minimise"}
    counted = COUNTED | {"price_p50": 4419.0, "objective_p50": 4421.0, "central_objective": 4210.0}
    best = make_result().best
    assert best is not None
    counted |= {"central_hardware": best.hardware.ids, "objective_p90": 4900.0}
    text = printed(make_result(objective=goal, confidence=counted))
    assert "price 3 600 to 5 400 USD, median about 4 400;" in text and "Goal: least cost, 3 600 to 5 400 USD." in text
    for other in ("4 421", "4 419", "4 210", "4 200", "4 900"):
        assert other not in text
    unknown = printed(make_result(confidence=COUNTED))
    assert "sum of the likeliest prices about 4 200" in unknown


@pytest.mark.parametrize("blocks", [short_text_blocks, full_text_blocks])
def test_what_is_not_certain_enough_is_said_first_on_the_page_and_in_full(
    make_result: Callable[..., Result], blocks: Callable[..., Any]
) -> None:
    """All there is once began with `feasible: every requirement is met`, and left out how often that holds."""
    unsure = make_result(status="feasible", confidence=COUNTED | {"held": 0.49, "enough": False})
    stream = io.StringIO()
    print_blocks(blocks(unsure), stream)
    text = " ".join(stream.getvalue().split())
    assert "not certain enough: does what is asked in 49 %" in text[:120]
    assert "very requirement is met" not in text[:400]
    for title in ("How certain", "Risks", "Measure or quote first"):
        assert title in text


def test_what_no_single_change_mends_is_told_with_the_pair_that_does(make_result: Callable[..., Result]) -> None:
    """Each change with its units; a raised limit in the mission's currency, with the lamps that it pays for."""
    def moved(name: str, asked: float, needed: float, unit: str) -> dict[str, Any]:
        return {"name": name, "asked": asked, "needed": needed, "unit": unit, "nearest": False}

    snr_db, swath_m = ("min_snr_db", 25.0), moved("min_swath_m", 1.5, 1.44, "m")
    together = {"moves": [moved(*snr_db, 22.5, "db"), swath_m], "hardware": [], "held": 0.92}
    raised = {"moves": [moved("cost", 8000.0, 30500.0, "USD")], "hardware": ["a", "4 x b"], "held": 0.9}
    in_vain = [
        {"move": moved("speed_m_s", 1.0, 0.25, "m_s"), "held": 0.41}, {"move": moved(*snr_db, 5.0, "db"), "held": 0.81},
    ]  # fmt: skip
    known = {"enough": False, "held": 0.4, "held_in_choice": 0.41, "in_vain": in_vain}
    result = make_result(confidence=COUNTED | known | {"would_hold_else": [together, raised]})
    (block,) = surer_block(result)
    said = [str(getattr(line, "plain", "")) for line in block.lines]
    assert said == [
        "No single change is enough for this hardware: signal to noise (min_snr_db) 25.00 dB -> 5.000 dB holds in 81 "
        "%; another speed (speed_m_s) is no help.",
        "With signal to noise (min_snr_db) 25.00 dB -> 22.50 dB and swath (min_swath_m) 1.500 m -> 1.440 m together, "
        "this hardware holds in 92 % (each as little as is enough while the others stay).",
        "With cost 8 000 USD -> 30 500 USD, a + 4 x b holds in 90 % (less may do).",
        "That is told of the hardware named: solve of a mission so changed chooses anew, and may take other.",
    ]
    (block,) = surer_block(replace(result, mission_as_solved="name: x"))
    assert "change these in mission-as-solved.yaml" in str(getattr(block.lines[-1], "plain", ""))


def test_medians_that_scenarios_cannot_tell_apart_are_called_a_tie(make_result: Callable[..., Result]) -> None:
    # 61 W in the scenarios of the choice: 60 W of other parts is within 2 %, 59 W is not
    ours = make_result().best.hardware.ids
    other = ["acme-cam-9", *ours[1:]]
    for median_w, tie in ((60.0, True), (59.0, False)):
        curve = [{"confidence": 0.95, "objective_p50": median_w, "hardware": other},
                 {"confidence": 0.99, "objective_p50": 70.0, "hardware": ours}]  # fmt: skip
        (block,) = certainty_block(make_result(confidence=COUNTED | {"central_hardware": ours, "curve": curve}))
        assert ("recommended has 61.00 W: medians within 2 % are a tie" in text_of(block)) == tie
    better = [{**curve[0], "confidence": 0.9, "objective_p50": 31.0}, curve[1]]  # and as often as is asked
    (block,) = certainty_block(make_result(confidence=COUNTED | {"central_hardware": ours, "curve": better}))
    assert "recommended has 61.00 W: further ones decided against what does better in 90 % of these" in text_of(block)
    refuted = [{**better[0], "held_again": 0.8975}, curve[1]]  # in further scenarios, not in 90 %
    (block,) = certainty_block(make_result(confidence=COUNTED | {"central_hardware": ours, "curve": refuted}))
    assert "where it holds in 89 %. Where a little less is enough, ask for less (--confidence 0.89)" in text_of(block)
    less = [{**curve[0], "confidence": 0.8, "objective_p50": 61.0}, curve[1]]  # holds less often than is asked
    (block,) = certainty_block(make_result(confidence=COUNTED | {"central_hardware": ours, "curve": less}))
    assert "a tie" not in text_of(block) and "decided" not in text_of(block)


@pytest.mark.parametrize(("field", "told"), [
    ("camera.saturation_e", "full-well capacity"), ("light.standby_w", "standby power"),
    ("camera.wake_up_s", "time to wake up"),
])  # fmt: skip
def test_numbers_of_parts_are_told_as_makers_call_them(field: str, told: str) -> None:
    said = decides_text(Decides(field, "acme-1", 0.0, 0.42))
    assert said == f"It depends on {told} of acme-1: holds in 0 % where it is low, in 42 % where it is high."

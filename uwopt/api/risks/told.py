"""What may go wrong with a recommended or given system, the most serious first, from what its result knows.

Every rule looks at the result alone and gives risks with a weight: 100 for what fails now, about 80 for what fails
when estimates turn out badly, about 50 for what is worse than the figures say, below 30 for what is good to know.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from uwopt.api.risks import of_housings, of_images, of_light, of_limits, of_order
from uwopt.api.risks.worst import Weighed
from uwopt.evaluation.breathing import BREATHING
from uwopt.results.basis import Risk
from uwopt.results.design import AS_CENTRAL, PRACTICE_MISSED, Design, Note
from uwopt.results.result import Result

#: Weights of notes by code; of those that are not named, the last. 0: another rule tells it, or it is no risk.
NOTES = {
    "not_settable": 95.0, AS_CENTRAL: 93.0, "practice_yields": 92.0,
    "no_image": 90.0, "dark_image": 77.0, "lamp_in_view": 68.0, "measure_the_camera": 62.0,
    BREATHING: 0.0, PRACTICE_MISSED: 0.0, "better_unsettable": 24.0, "snr_instead": 0.0,
    "colour_left_open": 0.0, "uneven_light": 0.0, "pattern": 0.0, "tolerance": 0.0, "interrupted": 0.0, "time": 0.0,
}  # fmt: skip
OTHER_NOTE = 15.0


def with_risks(result: Result) -> Result:
    """The result with its risks filled in."""
    return replace(result, risks=risks_of(result))


def risks_of(result: Result) -> list[Risk]:
    """What may go wrong, most serious first; nothing where there is no system."""
    if result.best is None:
        return []
    found = [item for rule in RULES for item in rule(result, result.best.as_set)]
    return [risk for _, risk in sorted(found, key=lambda item: -item[0])]


def noted(result: Result, design: Design) -> Weighed:
    """What the run and the parts have noted."""
    messages: dict[str, Note] = {
        note.message or note.code: note for note in [*result.warnings, *design.warnings]
    }
    for message, note in messages.items():
        weight = NOTES.get(note.code, OTHER_NOTE)
        if note.code == AS_CENTRAL and result.confidence is not None and result.confidence.enough:
            weight = OTHER_NOTE  # it holds as often as was asked, however it was chosen
        if weight:
            yield weight, Risk(message, "", "")


RULES: Sequence[Callable[[Result, Design], Weighed]] = (
    of_limits.missed, of_limits.uncertain, of_limits.at_bad_ends, of_limits.nothing_in_hand, of_housings.shallow,
    of_housings.drained, of_housings.overheated, of_housings.floats, of_light.in_other_water, of_light.lamps_off,
    of_light.noisy, of_light.uneven, of_images.lost_in_corners, of_images.seen_in_the_image,
    of_images.smeared_subjects, of_images.must_stand_still, of_images.weak_colours, of_images.wide_open,
    of_images.high_gain, of_order.held_back, of_order.dearer_than_it_must, of_order.unsure_price, of_order.to_be_made,
    of_order.maybe_withdrawn, of_order.idle_lamps, of_order.better_elsewhere, noted,
)  # fmt: skip

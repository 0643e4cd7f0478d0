"""Margins in words: what is missed or next to missed, with the digits that tell a value from its limit."""

from __future__ import annotations

from uwopt.quantities import REQUIREMENTS
from uwopt.results.design import Design, Margin
from uwopt.results.result import Result
from uwopt.tolerances import SATISFIED_REL
from uwopt.units import format_difference, format_quantity, listed, texts_apart

#: Ends of the ranges that settings may have, what a setting with room left can mend, and what another rule tells.
OF_SETTINGS = (
    "f_number_min", "f_number_max", "gain_min", "gain_max", "max_exposure_ms", "min_exposure_ms", "light_level_max",
    "light_level", "max_pulse_ms", "min_pulse_ms", "light_duty", "light_rate", "shutter_open_ms", "common_f_number",
    "common_focus_m", "nearest_focus_m", "frame_rate", "frame_interval_s", "overlap", "saturation_fraction",
    "cost", "lens_stop_down", "max_gain_db", "fixed_f_number", "fixed_exposure_ms", "fixed_gain", "fixed_dim_frac",
    "depth_rating_m",
)  # fmt: skip
NOTHING_IN_HAND = 0.02  # of a limit
#: Ends of the depth of field, and what uses up the little margin there.
OFF_FOCUS = {
    "dof_near_m": "a floor that is any nearer, or a focus set any farther, is not sharp",
    "dof_far_m": "a floor that is any farther, or a focus set any nearer, is not sharp",
}
TO_CORNERS = " to the corners"


def tight(design: Design) -> list[Margin]:
    """Requirements on the images and the vehicle with next to no margin, the tightest first."""
    found = [(left, m) for m in design.margins if m.key not in OF_SETTINGS
             and m.satisfied and (left := m.share_left) is not None and left < NOTHING_IN_HAND]  # fmt: skip
    return [margin for _, margin in sorted(found, key=lambda item: item[0])]


def in_hand_names(design: Design) -> str:
    """The same in words."""
    return listed(dict.fromkeys(asked_name(margin) for margin in tight(design)))


def sharp_where(result: Result) -> str:
    """` to the corners` where the depth of field must hold there; empty where it holds on the axis."""
    asked = (result.mission.get("requirements") or {}).get("dof_at")
    return TO_CORNERS if asked == "corner" and result.physics.name != "paper" else ""


def missed_figure(margin: Margin, where: str) -> str:
    """Value and limit of what is missed; of an end of the depth of field what is sharp, where, and what should be."""
    if margin.key not in OFF_FOCUS or margin.value is None:
        return against_limit(margin)
    value, limit = value_and_limit(margin)
    side = "from" if margin.sense == "<=" else "to"
    return f"sharp{where} only {side} {value}, not {side} {limit}"


def tight_figure(margin: Margin, where: str) -> str:
    """What is tightest, with value and limit; an end of the depth of field as what is still sharp there."""
    if margin.key not in OFF_FOCUS:
        return f"{asked_name(margin)} {against_limit(margin)}"
    assert margin.margin is not None and margin.limit is not None
    rounding = abs(margin.margin) <= SATISFIED_REL * abs(margin.limit)
    (value, limit), left = value_and_limit(margin), format_difference(0.0 if rounding else margin.margin, margin.unit)
    side, wanted = ("from", "nearest") if margin.sense == "<=" else ("to", "farthest")
    return f"sharp{where} {side} {value}, the {wanted} floor at {limit}: margin {left}"


def asked_name(margin: Margin) -> str:
    """A requirement in words."""
    return in_words(margin.key)


def against_limit(margin: Margin) -> str:
    """`29.0 dB against 30.0 dB`."""
    value, limit = value_and_limit(margin)
    return f"{margin.word if margin.value is None and margin.word else value} against {limit}"


def value_and_limit(margin: Margin) -> tuple[str, ...]:
    """Value and limit, with as many digits as tell them apart."""
    return texts_apart(margin.value, margin.limit, text=lambda x, digits: format_quantity(x, margin.unit, digits))


def in_words(requirement: str) -> str:
    """A key in words, without the part that it is about."""
    key = requirement.partition(" (")[0]
    return "depth of field" if key in OFF_FOCUS else REQUIREMENTS.get(key, key).partition(",")[0]

"""What makes a design fail first: the requirement with the least margin, as a share of what is asked for.

Judged by what the result says of its margins. What is only a matter of a setting with room left (overlap and rate,
gain, highlights, light level) is passed over, and so are budgets: they break no image. What is left of a depth rating
is counted from the deepest scene: a rating that a mission asks for has its own margin, and parts have round ones.
"""

from __future__ import annotations

from uwopt.report.text import formats, words
from uwopt.results.design import Design, Margin
from uwopt.units import format_difference

DEPTH = "depth_rating_m"
BREAKING = (
    "max_blur_px", "max_skew_px", "dof_near_m", "dof_far_m", "min_dof_m", "max_gsd_mm", "min_swath_m",
    "min_common_swath_m", "max_depth_error_mm", "min_snr_db", "min_snr_mean_db", "min_snr_red_db",
    "max_white_balance", "min_contrast", "min_uniformity",
    "min_mtf_half_nyquist", "resolve_mm", "max_airy_px", "lamp_clear_m", DEPTH,
)  # fmt: skip
ALIKE = 1e-6  # of what is asked: so near, two requirements fail together
MOST_NAMED = 3


def share_in_hand(margin: Margin, deepest_m: float = 0.0) -> float | None:
    """What is left of a requirement as a share of what is asked for, reserve included; of decibels as a ratio.

    deepest_m : depth of the deepest scene, of which a depth rating leaves so much; 0: of the rating that is asked for
    """
    if margin.key not in BREAKING or margin.share_left is None:
        return None
    if margin.key == DEPTH and deepest_m > 0.0 and margin.value is not None:
        return margin.value / deepest_m - 1.0
    return margin.share_left


def fails_first(design: Design, deepest_m: float = 0.0) -> str:
    """`signal to noise, margin 0 dB beyond the 3 dB reserve`; "" where none could, or some do."""
    if not design.feasible:
        return ""
    found = [
        (share, number, scene.name, margin)
        for scene in design.scenes
        for number, margin in enumerate(scene.margins)
        if (share := share_in_hand(margin, deepest_m)) is not None
    ]
    if not found:
        return ""
    least = min(share for share, *_ in found)
    named: dict[str, str] = {}
    for share, _, scene, margin in found:
        if share <= least + ALIKE:
            name = words.requirement_name(margin.requirement)
            place = words.in_scene(scene, design.scenes)
            named.setdefault(name, f"{name}{place}, {left_text(margin, design, deepest_m)}")
    return "; ".join(list(named.values())[:MOST_NAMED])


def left_text(margin: Margin, design: Design, deepest_m: float) -> str:
    """`margin 0 dB beyond the 3 dB reserve`; of a depth rating without one what it leaves over the deepest scene."""
    if margin.requirement.startswith(DEPTH) and deepest_m > 0.0 and margin.value is not None and not margin.reserve:
        return f"{format_difference(margin.value - deepest_m, margin.unit)} over the deepest scene"
    kept = f" beyond the {formats.kept_text(margin)} reserve" if margin.reserve else ""
    return f"margin {formats.margin_text(margin, design.totals.cost)}{kept}"

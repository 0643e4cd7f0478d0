"""Which rules imagers may pass once a requirement is dropped or a key moved, and which then stand in the way."""

from __future__ import annotations

from uwopt.solvers.exact.account import RULES
from uwopt.solvers.exact.node_bounds import NODE_RULES
from uwopt.solvers.recommend import Sought

OTHER_WATER = "other water"  # of which no rule of an imager knows
NO_REASONS = frozenset({"better_housing", "bound", "mount", "image_circle", "complete"})  # whatever is asked
LATE_RULES = frozenset({*NODE_RULES, "cost", "mass_kg", "power_w", "energy_wh"}) - NO_REASONS  # that know of lamps
HOURS, OF_HOURS = "duration_h", ("run time", "rated time")  # rules of parts that a shorter mission may have again
SETTINGS = "settings"  # that none of a design's does: a reason, though no rule of a search
MOST_REASONS = 2  # told

#: Rules of imagers that may pass what they fail once a requirement is dropped or weakened. Of requirements that are
#: not named here anything may change, parts and their prices included.
MAY_PASS: dict[str, frozenset[str]] = {
    **dict.fromkeys(
        (
            "min_snr", "max_white_balance", "max_skew_px", "max_airy_px", "max_gain_db", "mean_level", "min_contrast",
            "min_uniformity", "min_mtf_half_nyquist", "peak_power_w", "cost", "power_w", "mass_kg", "energy_wh",
        ),
        frozenset[str](),
    ),
    "max_gsd_mm": frozenset({"max_gsd_mm"}),
    "min_swath_m": frozenset({"min_swath_m"}),
    "min_common_swath_m": frozenset({"min_common_swath_m"}),
    "max_depth_error_mm": frozenset({"max_depth_error_mm"}),
    "data_rate_mb_s": frozenset({"data_rate_mb_s"}),
    "resolve_mm": frozenset({"max_gsd_mm"}),
    "min_dof_m": frozenset({"focus", "min_dof_m", "lens_stop_down"}),
    "max_blur_px": frozenset({"max_blur_px"}),
    "lens_stop_down": frozenset({"lens_stop_down", "min_dof_m"}),
    "overlap": frozenset(
        {"frame_rate", "data_rate_mb_s", "storage_gb", "card_gb", "max_blur_px", "min_swath_m"}
    ),
}  # fmt: skip
#: The same of keys that are no requirements, where what they ask is less.
MOVES_PASS: dict[str, frozenset[str]] = {
    "speed_m_s": frozenset({"max_blur_px", "frame_rate", "data_rate_mb_s", "storage_gb", "card_gb"}),
    "frame_interval_s": frozenset({"frame_rate", "data_rate_mb_s", "storage_gb", "card_gb"}),
    HOURS: frozenset({"storage_gb", "card_gb"}),
}
FREES = MAY_PASS | MOVES_PASS
#: Those that count of imagers alone: who fits without them and not with them breaks their rule.
OF_IMAGERS = frozenset({"max_gsd_mm", "min_swath_m", "min_common_swath_m", "max_depth_error_mm", "data_rate_mb_s"})
#: Those that no imager's rule or column knows.
OF_LIGHT = frozenset({
    "min_snr", "max_white_balance", "max_skew_px", "max_airy_px", "max_gain_db", "mean_level", "min_contrast",
    "min_uniformity", "min_mtf_half_nyquist", "peak_power_w",
})  # fmt: skip


def in_the_way(found: Sought, freed: str = "") -> tuple[str, ...]:
    """The rules by which the designs of a search fall that found none, but for that which is `freed`.

    Those that know of lamps if any, else `SETTINGS` of what was solved in vain, else the last of an imager's.
    """
    account = found.outcome.account
    lost = account.discarded
    rules = [rule for rule in RULES if lost.get(rule, 0) > 0 and rule not in NO_REASONS and rule != freed]
    late = [rule for rule in rules if rule in LATE_RULES] or ([SETTINGS] if account.evaluated else rules[-1:])
    return tuple(sorted(late, key=lambda rule: -lost.get(rule, 0))[:MOST_REASONS])

"""Planted defects of reserves, of lenses stopped down, and of what is refused."""

from __future__ import annotations

from planted.defect import Defect

RESERVES = "tests/mission/test_reserves.py"
LIMITS = "tests/objectives/test_margin_limits.py"
RULES = "tests/solvers/test_rules.py"
EXACT = "tests/solvers/test_exact.py"
MISSION = "uwopt/mission/reserves.py"

LEANING = "tests/solvers/test_leaning.py::"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="what is recommended is compared by what gave way",
        file="uwopt/api/comparing.py",
        old="        if gave_way:  # what",
        new="        if not gave_way:  # what",
        test="tests/api/test_yielding.py::test_what_is_recommended_is_compared_by_what_is_held_of_it",
    ),
    Defect(
        name="a system that misses more is told that it misses good practice alone",
        file="uwopt/api/evaluating.py",
        old="if is_met else []",
        new="if missed else []",
        test="tests/api/test_yielding.py::test_a_system_is_told_whether_good_practice_is_all_that_it_misses",
    ),
    Defect(
        name="settings to set forget lamps that lean inward",
        file="uwopt/evaluation/leaning.py",
        old='(("outward", 1.0), ("inward", -1.0))',
        new='(("outward", 1.0),)',
        test=LEANING + "test_settings_to_set_hold_with_lamps_that_lean[inward]",
    ),
    Defect(
        name="lamps that lean are heeded but not held",
        file="uwopt/solvers/settable/rounding.py",
        old="[*heeded, *leaner], deadline)",
        new="leaner, deadline)",
        test=LEANING + "test_settings_to_set_hold_with_lamps_that_lean[mean]",
    ),
    Defect(
        name="the best is taken though its lamps may not lean",
        file="uwopt/solvers/recommend.py",
        old="math.inf if value is None or leans(design) else",
        new="math.inf if value is None else",
        test=LEANING + "test_hardware_whose_lamps_may_lean_is_taken_before_better_that_may_not",
    ),
    Defect(
        name="no settings are offered where no lamps may lean",
        file="uwopt/solvers/settable/rounding.py",
        old="again, first)\n    return first",
        new="again, first)\n    return made",
        test=LEANING + "test_where_no_lamps_may_lean_the_best_is_told_with_a_warning",
    ),
    Defect(
        name="a reserve of blur allows more of it",
        file=MISSION,
        old="1.0 - reserve.blur",
        new="1.0 + reserve.blur",
        test=f"{RESERVES}::test_a_reserve_tightens_what_is_held[max_blur_px-0.8]",
    ),
    Defect(
        name="no reserve of a ratio of signal to noise",
        file=MISSION,
        old='"min_snr_given": reserve.snr_ratio',
        new='"min_snr_given": 1.0',
        test=f"{RESERVES}::test_a_reserve_in_decibels_multiplies_a_ratio",
    ),
    Defect(
        name="a narrow swath is refused without a survey",
        file=MISSION,
        old="vehicle.speed_m_s > 0.0 and wanted.overlap is not None",
        new="vehicle.speed_m_s > 0.0",
        test=f"{RESERVES}::test_a_narrow_swath_is_refused_in_a_survey_alone",
    ),
    Defect(
        name="who works near is refused a swath of a metre",
        file=MISSION,
        old="return min(value, nearest_m) if word == ",
        new="return value if word == ",
        test=f"{RESERVES}::test_who_works_near_is_refused_no_swath_that_is_wider_than_far",
    ),
    Defect(
        name="a refusal beats the key that is given",
        file=MISSION,
        old="if word in wanted.refuse and getattr(wanted, key) is None and (",
        new="if word in wanted.refuse and (",
        test=f"{RESERVES}::test_a_refusal_stands_for_a_requirement_that_is_not_given[skew-max_skew_px-2]",
    ),
    Defect(
        name="the depth's reserve is forgotten",
        file="uwopt/mission/mission.py",
        old="return self.asked_depth_m * self.depth_factor",
        new="return self.asked_depth_m",
        test=f"{RESERVES}::test_depth_rating_is_asked_for_with_its_reserve[given0-50.0]",
    ),
    Defect(
        name="a rating that is given gets a reserve of its own again",
        file="uwopt/mission/reserves.py",
        old="if rating_m is not None:",
        new="if False:",
        test=f"{RESERVES}::test_depth_rating_is_asked_for_with_its_reserve[given1-100.0]",
    ),
    Defect(
        name="a margin does not say its reserve",
        file="uwopt/objectives/requirements.py",
        old='yield MarginRows("max_blur_px", value, limit, "<=", "px", where, reserve=kept)',
        new='yield MarginRows("max_blur_px", value, limit, "<=", "px", where)',
        test="tests/evaluation/test_reserves.py::test_a_margin_says_what_is_asked_and_what_is_kept",
    ),
    Defect(
        name="half as many stops close a lens",
        file="uwopt/model/f_stops.py",
        old="f_number_min * 2.0 ** (stops / 2.0)",
        new="f_number_min * 2.0 ** (stops / 4.0)",
        test=f"{RULES}::test_a_rule_discards_what_is_a_millionth_outside[lens_stop_down]",
    ),
    Defect(
        name="a lens is closed to a number that no ring has",
        file="uwopt/model/f_stops.py",
        old="return min(exact, THIRD_STOPS[index + steps])",
        new="return exact",
        test="tests/solvers/test_reserves.py::test_the_mark_a_stop_down_is_enough",
    ),
    Defect(
        name="the margin of a stop counts from what is engraved",
        file="uwopt/objectives/requirements.py",
        old="stops + 2.0 * np.log2(settings.f_number / rows.lenses.f_number_from(stops))",
        new="2.0 * np.log2(settings.f_number / rows.lenses.f_number_min)",
        test="tests/evaluation/test_reserves.py::test_a_lens_as_far_closed_as_asked_is_no_risk",
    ),
    Defect(
        name="a lens of one opening must be closed",
        file="uwopt/forward/part_columns.py",
        old="np.where(self.one_opening, self.f_number_min, ",
        new="np.where(False, self.f_number_min, ",
        test="tests/solvers/test_reserves.py::test_a_lens_of_one_opening_is_searched_as_it_is",
    ),
    Defect(
        name="the search lets lamps stand in the view",
        file="uwopt/solvers/exact/design_rows.py",
        old="if lamps_refused(self.problem, scene_index):\n",
        new="if not fine.all():\n",
        test="tests/solvers/test_reserves.py::test_a_lamp_in_the_view_is_refused[vehicle1-refuse1-False]",
    ),
    Defect(
        name="a lamp may stand as near to the view as it likes",
        file="uwopt/forward/lamp_views.py",
        old="clear_m >= least_m * (1 - 1e-9)",
        new="clear_m >= -LAMP_FRONT_M",
        test="tests/solvers/test_reserves.py::test_a_lamp_in_the_view_is_refused[vehicle1-refuse1-False]",
    ),
    Defect(
        name="a lens closed as far as asked is a risk",
        file="uwopt/api/risks/margins.py",
        old='"cost", "lens_stop_down",',
        new='"cost",',
        test="tests/evaluation/test_reserves.py::test_a_lens_as_far_closed_as_asked_is_no_risk",
    ),
    Defect(
        name="leaning lamps may not use the reserve up",
        file="uwopt/evaluation/leaning.py",
        old='if margin.sense == "<=" else -margin.reserve',
        new='if margin.sense == "<=" else 0.0',
        test="tests/evaluation/test_reserves.py::test_lamps_that_lean_are_warned_of_as_far_as_the_reserve",
    ),
    Defect(
        name="lamps lean outward alone",
        file="uwopt/evaluation/leaning.py",
        old='("inward", -1.0)):',
        new='("inward", 1.0)):',
        test="tests/evaluation/test_reserves.py::test_a_lean_inward_and_one_outward_are_both_tried",
    ),
    Defect(
        name="a rating that is asked for is used up by its own depth",
        file="uwopt/report/text/in_hand.py",
        old="    if margin.key == DEPTH and deepest_m > 0.0",
        new="    if False and deepest_m > 0.0",
        test="tests/report/test_in_hand.py::test_a_depth_rating_counts_from_the_deepest_scene",
    ),
    Defect(
        name="a rating that is asked for is a great risk",
        file="uwopt/api/risks/of_housings.py",
        old="yield (29.0 if asked else 62.0)",
        new="yield (62.0 if asked else 62.0)",
        test="tests/api/test_risks.py::"
        "test_ratings_that_leave_little_are_one_risk_and_a_slight_one_where_they_are_asked_for",
    ),
    Defect(
        name="a possible limit is told with its reserve",
        file=MISSION,
        old="return held - reserve.snr_db if key",
        new="return held if key",
        test="tests/solvers/test_least_change.py::test_what_is_possible_is_told_without_the_reserve[min_snr]",
    ),
    Defect(
        name="a refusal cannot be dropped",
        file="uwopt/mission/weakened.py",
        old="if word not in words_of(key)]",
        new="if word]",
        test="tests/solvers/test_least_change.py::test_a_refusal_is_weakened_as_its_key_would_be",
    ),
    Defect(
        name="the search lets the Airy disc grow",
        file="uwopt/forward/setting_rows.py",
        old="n_high = np.minimum(n_high, working / focused.working_factor)",
        new="n_high = np.minimum(n_high, 2.0 * working / focused.working_factor)",
        test="tests/solvers/test_reserves.py::test_the_airy_disc_ends_the_f_numbers",
    ),
    Defect(
        name="the Airy disc is held against the f-number at infinity",
        file="uwopt/forward/setting_rows.py",
        old="working / focused.working_factor)",
        new="working)",
        test="tests/solvers/test_reserves.py::test_the_airy_disc_ends_the_f_numbers",
    ),
    Defect(
        name="a reserve is no room for lamps that lean",
        file="uwopt/evaluation/leaning.py",
        old="return [as_asked(margin) for margin in held",
        new="return [margin for margin in held",
        test="tests/solvers/test_robustness.py::test_lamps_may_lean_until_the_reserve_is_used_up",
    ),
    Defect(
        name="an unknown key without a value is passed over, as a decimal comma makes one",
        file="uwopt/mission/practice.py",
        old="if value is not None or key not in keys}",
        new="if value is not None}",
        test="tests/mission/test_mission.py"
        "::test_an_unknown_key_without_a_value_is_told_whatever_practice_fills_in[recommended-vehicle.5]",
    ),
    Defect(
        name="one reserve that is given takes the others away",
        file="uwopt/mission/practice.py",
        old="{**RECOMMENDED_RESERVE, **given}",
        new="dict(reserve)",
        test="tests/mission/test_practice.py::test_what_a_mission_says_stays",
    ),
    Defect(
        name="lamps are blamed for what is missed however they stand",
        file="uwopt/api/evaluating.py",
        old="settings, [margin.requirement for margin in design.missed]),",
        new="settings),",
        test="tests/evaluation/test_reserves.py::test_lamps_are_not_blamed_for_what_is_missed_however_they_stand",
    ),
    Defect(
        name="a gain just beyond its cap looks like it",
        file="uwopt/api/common.py",
        old='return f"gain {gain} dB',
        new='return f"gain {gain_db:.3g} dB',
        test="tests/api/test_gain_cap.py::test_a_gain_just_beyond_its_cap_does_not_look_like_it",
    ),
)

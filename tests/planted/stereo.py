"""Planted defects of stereo pairs: what both cameras see and measure, and what a search discards by it."""

from __future__ import annotations

from planted.defect import Defect

MODEL, MISSION = "tests/model/test_stereo.py", "tests/evaluation/test_stereo.py"
RULES, WORST = "tests/solvers/test_rules.py::", "tests/objectives/test_worst_altitude.py"
LIMITS = "tests/objectives/test_margin_limits.py"
STEREO, OUTLINE = "uwopt/model/stereo.py", "uwopt/solvers/exact/outline.py"

DEFECTS = (
    Defect(
        name="a converged pair is turned outward",
        file=STEREO,
        old="aside, away = y_m * cos - range_m * sin, y_m * sin + range_m * cos",
        new="aside, away = y_m * cos + range_m * sin, range_m * cos - y_m * sin",
        test=f"{MODEL}::test_error_of_a_distance_is_the_slope_of_traced_rays",
    ),
    Defect(
        name="the error of one camera of a pair counts for both",
        file=STEREO,
        old="0.5 * (np.square(step) + np.square(other_step))",
        new="np.square(step)",
        test=f"{MODEL}::test_error_of_a_distance_is_the_slope_of_traced_rays",
    ),
    Defect(
        name="each camera of a pair errs by the whole disparity",
        file=STEREO,
        old="np.sqrt(0.5 * (np.square(step)",
        new="np.sqrt((np.square(step)",
        test=f"{MODEL}::test_a_pair_that_is_not_turned_errs_by_the_textbook",
    ),
    Defect(
        name="a pair sees as far as its outer edges",
        file=STEREO,
        old="half = np.minimum(far - 0.5 * pair.baseline_m, 0.5 * pair.baseline_m - near)",
        new="half = np.maximum(far - 0.5 * pair.baseline_m, 0.5 * pair.baseline_m - near)",
        test=f"{MODEL}::test_common_width_is_where_both_traced_images_reach",
    ),
    Defect(
        name="water does not bend the rays of a pair",
        file=STEREO,
        old="return start, end - start, start_rise, end_rise - start_rise",
        new="return start, tan_air, start_rise, 1.0",
        test=f"{MODEL}::test_behind_a_flat_port_the_focal_length_is_longer_by_the_index",
    ),
    Defect(
        name="the whole convergence turns each camera",
        file="uwopt/forward/views.py",
        old="0.5 * float(np.deg2rad(vehicle.camera_convergence_deg))",
        new="float(np.deg2rad(vehicle.camera_convergence_deg))",
        test=f"{LIMITS}::test_requirement_is_missed_just_outside_its_limit[min_common_swath_m 3]",
    ),
    Defect(
        name="the best altitude counts: min_common_swath_m",
        file="uwopt/objectives/requirements.py",
        old="worst(rows.view.common_across_m, three, highest=False)",
        new="worst(rows.view.common_across_m, three, highest=True)",
        test=f"{WORST}::test_margin_is_that_of_the_worst_altitude[min_common_swath_m]",
    ),
    Defect(
        name="the best altitude counts: max_depth_error_mm",
        file="uwopt/objectives/requirements.py",
        old="worst(rows.view.depth_error_m * 1e3, three, highest=True)",
        new="worst(rows.view.depth_error_m * 1e3, three, highest=False)",
        test=f"{WORST}::test_margin_is_that_of_the_worst_altitude[max_depth_error_mm]",
    ),
    Defect(
        name="a search forgets what both cameras see",
        file="uwopt/solvers/exact/imager_rules.py",
        old='at_least("min_common_swath_m", "common_across_m")',
        new='at_least("min_common_swath_m", "covered_across_m")',
        test=f"{RULES}test_a_rule_discards_what_is_a_millionth_outside[min_common_swath_m]",
    ),
    Defect(
        name="outlines forget the baseline of a pair",
        file=OUTLINE,
        old="common_m = covered_m[:, :1] - pair.baseline_m",
        new="common_m = covered_m[:, :1]",
        test=f"{RULES}test_an_outline_discards_what_is_outside[min_common_swath_m]",
    ),
    Defect(
        name="outlines ask a pair for more than its imagers give",
        file=OUTLINE,
        old="error_m[mine] = disparity_m / focal * square / baseline_m",
        new="error_m[mine] = 1.001 * disparity_m / focal * square / baseline_m",
        test=f"{RULES}test_an_outline_keeps_what_is_inside[max_depth_error_mm]",
    ),
    Defect(
        name="lines of a pair are as far apart as one camera sees",
        file="uwopt/evaluation/figures_by_name.py",
        old='"line_spacing_m": float(narrowest_m(view)[0])',
        new='"line_spacing_m": float(view.covered_across_m[0, 1])',
        test=f"{MISSION}::test_lines_and_area_of_a_pair_count_what_both_cameras_see",
    ),
    Defect(
        name="an area of a pair asks for one camera's swath",
        file="uwopt/mission/reserves.py",
        old='key = "min_swath_m" if vehicle.camera_baseline_m is None else "min_common_swath_m"',
        new='key = "min_swath_m"',
        test=f"{MISSION}::test_an_area_asks_for_a_strip_that_both_cameras_see",
    ),
    Defect(
        name="both cameras of a pair have the lamps of the middle",
        file="uwopt/evaluation/pair_light.py",
        old="y_m = lamp.y_m - aside_m",
        new="y_m = lamp.y_m",
        test=f"{MISSION}::test_light_of_each_camera_is_that_of_lamps_shifted_against_it",
    ),
    Defect(
        name="pixels of cameras that are turned are as large as of those that are not",
        file="uwopt/forward/views.py",
        old="pair.turn_rad and not (scene.slope or scene.paper)",
        new="False",
        test="tests/model/test_stereo.py::test_a_turned_pair_is_held_to_its_largest_pixels",
    ),
)

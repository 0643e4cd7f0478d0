"""Planted defects of what colours and moving subjects ask for."""

from __future__ import annotations

from planted.defect import Defect

COLOUR = "tests/solvers/test_colour.py"
CELLS = "tests/solvers/test_cells.py"
BOXES = "tests/solvers/test_cell_bounds.py"
LIMITS = "tests/objectives/test_margin_limits.py"
CONTINUOUS = "tests/solvers/test_continuous.py::test_least_power_agrees_with_the_closed_form"
BOUNDED = f"{BOXES}::test_no_point_is_better_than_the_bound_of_a_cell_that_holds_it"
MOTION = "tests/forward/test_motion.py"
SHORT = "tests/report/test_short.py"
RISKS = "tests/api/test_risks.py"
UNITS = "tests/solvers/test_rules.py::test_a_unit_falls_when_its_light_is_outside"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="colours are bounded as if the longest paths were the shortest",
        file="uwopt/solvers/exact/light_tables.py",
        old="lamp_m=(lamp_m, reach[0]), camera_m=(camera_m, reach[1])",
        new="lamp_m=(reach[0], reach[0]), camera_m=(reach[1], reach[1])",
        test=f"{COLOUR}::test_no_image_is_better_balanced_than_its_bound",
    ),
    Defect(
        name="a cell of paths has the ratio of its near corner",
        file="uwopt/solvers/exact/balance.py",
        old="far, near = strong[1:, 1:], weak[:-1, :-1]",
        new="far, near = strong[:-1, :-1], weak[1:, 1:]",
        test=f"{COLOUR}::test_a_ratio_of_channels_is_least_at_a_corner_of_its_cell",
    ),
    Defect(
        name="colours seen ahead may be a little off balance",
        file="uwopt/solvers/exact/balance.py",
        old="off[doubtful] = seen > most * MET",
        new="off[doubtful] = seen > most * 1.001",
        test=f"{COLOUR}::test_colours_seen_ahead_discard_what_an_evaluation_would",
    ),
    Defect(
        name="colours are seen ahead from the nearest altitude",
        file="uwopt/forward/remembered.py",
        old="**self.common(float(self.scene.range_m[-1])),",
        new="**self.common(float(self.scene.range_m[0])),",
        test=f"{COLOUR}::test_colours_seen_ahead_are_those_of_the_farthest_altitude",
    ),
    Defect(
        name="colours are bounded where nothing asks for light",
        file="uwopt/solvers/exact/balance.py",
        old="if tables.problem.scenes[index].view.requirements.min_snr:  # without",
        new="if True:  # without",
        test=f"{COLOUR}::test_without_light_no_colour_is_too_strong",
    ),
    Defect(
        name="colours that the water takes apart are left to the integrals",
        file="uwopt/solvers/exact/bounds.py",
        old="balance.by_water(self.tables, k, rows))",
        new="np.zeros(n, bool))",
        test=f"{UNITS}[max_white_balance]",
    ),
    Defect(
        name="a subject swims with the vehicle",
        file="uwopt/forward/motion.py",
        old="speed_m_s=vehicle.speed_m_s + subject_m_s(scene),",
        new="speed_m_s=max(vehicle.speed_m_s, subject_m_s(scene)),",
        test=f"{MOTION}::test_it_may_swim_against_the_vehicle",
    ),
    Defect(
        name="a subject never swims across",
        file="uwopt/forward/motion.py",
        old="return dict(speed_m_s=subject_m_s(scene), rotation",
        new="return dict(speed_m_s=0.0, rotation",
        test=f"{MOTION}::test_it_may_swim_across_while_the_vehicle_rolls",
    ),
    Defect(
        name="a subject brings the next image sooner",
        file="uwopt/forward/figures.py",
        old="    speed = scene.view.vehicle.speed_m_s\n    if speed == 0.0:",
        new="    speed = scene.view.vehicle.speed_m_s + subject_m_s(scene)\n    if speed == 0.0:",
        test=f"{MOTION}::test_overlap_and_frame_rate_are_the_vehicles_alone",
    ),
    Defect(
        name="a subject is told to decide where blur has room",
        file="uwopt/report/text/opening.py",
        old='m.requirement == "max_blur_px" and m.binding for m',
        new='m.requirement == "max_blur_px" for m',
        test=f"{SHORT}::test_subject_that_decides_the_exposure_is_told",
    ),
    Defect(
        name="smear is told though a limit of blur is asked",
        file="uwopt/api/risks/of_images.py",
        old='if not swim or any(margin.requirement == "max_blur_px" for margin in design.margins):',
        new="if not swim:",
        test=f"{RISKS}::test_smeared_subjects_are_told_where_no_limit_of_blur_is_asked",
    ),
    Defect(
        name="nobody tells what sensor was chosen",
        file="uwopt/report/text/opening.py",
        old="for note in result.warnings if note.code in TOLD_FIRST]",
        new="for note in result.warnings if note.code not in TOLD_FIRST]",
        test=f"{SHORT}::test_sensor_that_nobody_asked_for_is_told_on_the_page_and_is_no_risk",
    ),
    Defect(
        name="the chosen sensor is told where it was asked for",
        file="uwopt/solvers/recommend.py",
        old='if any(wish(view.requirements, "colour") != "any" for view in problem.mission.views):',
        new="if not problem.mission.views:",
        test=f"{COLOUR}::test_the_sensor_is_told_where_the_mission_leaves_it_open",
    ),
    Defect(
        name="red asks for no light",
        file="uwopt/solvers/settings/windows.py",
        old='("red", rows.min_snr_red)]',
        new='("red", 0.0)]',
        test=(
            f"{COLOUR}::test_search_asking_of_colours_equals_enumeration[as shipped-24]",
            f"{CONTINUOUS}[red that needs more than the mean-casadi]",
        ),
    ),
    Defect(
        name="red is asked for at the first altitude alone",
        file="uwopt/solvers/settings/windows.py",
        old="        signal = rows.colour_e[:, altitude, 0]\n",
        new="        signal = rows.colour_e[:, 0, 0]\n",
        test=f"{COLOUR}::test_red_asks_for_light_as_the_only_altitude_says",
    ),
    Defect(
        name="red has no veil in the search",
        file="uwopt/forward/setting_rows.py",
        old="        red_veil_e=shining.red_veil_e,\n",
        new="        red_veil_e=None,\n",
        test=f"{COLOUR}::test_red_behind_a_thick_veil_equals_enumeration",
    ),
    Defect(
        name="red has the veil of the mean",
        file="uwopt/forward/lamp_light.py",
        old='red = field(channel="red").light(view, veils="all", known=ImageLight(colour[:, :, 0]))',
        new='red = field(channel=None).light(view, veils="all", known=ImageLight(light.signal_e))',
        test=f"{COLOUR}::test_margins_of_colours_are_those_of_flat_curves[sun0]",
    ),
    Defect(
        name="a mono sensor is not balanced",
        file="uwopt/model/sensor.py",
        old="np.where(most > 0.0, np.inf, 1.0))[()]",
        new="np.inf)[()]",
        test=f"{COLOUR}::test_a_mono_sensor_has_no_red_and_nothing_to_balance",
    ),
    Defect(
        name="colours out of balance are searched",
        file="uwopt/forward/setting_rows.py",
        old="        may &= ratio <= needs.max_white_balance * BALANCE_ROUND\n",
        new="        may &= ratio > 0.0\n",
        test=f"{COLOUR}::test_search_refuses_what_an_evaluation_would_miss",
    ),
    Defect(
        name="the balance of the nearest altitude counts in the search",
        file="uwopt/forward/setting_rows.py",
        old="ratio = sensor.white_balance(light.colour_e).max(axis=1)",
        new="ratio = sensor.white_balance(light.colour_e).min(axis=1)",
        test=f"{COLOUR}::test_the_worst_altitude_counts_for_colours",
    ),
    Defect(
        name="the balance of the nearest altitude counts",
        file="uwopt/objectives/requirements.py",
        old="value, where = worst(figures.white_balance, scene.altitude_m, highest=True)",
        new="value, where = worst(figures.white_balance, scene.altitude_m, highest=False)",
        test=f"{COLOUR}::test_the_worst_altitude_counts_for_colours",
    ),
    Defect(
        name="red of the brightest altitude counts",
        file="uwopt/objectives/requirements.py",
        old="value, where = worst(red, scene.altitude_m, highest=False)",
        new="value, where = worst(red, scene.altitude_m, highest=True)",
        test=f"{COLOUR}::test_the_worst_altitude_counts_for_colours",
    ),
    Defect(
        name="the sun's balance is taken at its most where it harms",
        file="uwopt/solvers/settings/cell_windows.py",
        old="np.where(gains > 0, misses * y_lo / gains, np.inf), 0.0)",
        new="np.where(gains > 0, misses * y_hi / gains, np.inf), 0.0)",
        test=f"{BOUNDED}[power of pulses that balance the sun's colours]",
    ),
    Defect(
        name="the sun's help for red is taken at its least",
        file="uwopt/solvers/settings/cell_windows.py",
        old="at_least.worst_total_e, at_most.colour_e, at_least.red_total_e,",
        new="at_least.worst_total_e, at_least.colour_e, at_most.red_total_e,",
        test=f"{BOUNDED}[power of a red image under the sun]",
    ),
    Defect(
        name="the sun brings no red",
        file="uwopt/forward/figures.py",
        old="            colour = added(colour, sunlit(sun.colour_e_s))\n",
        new="            colour = added(colour, None)\n",
        test=f"{COLOUR}::test_margins_of_colours_are_those_of_flat_curves[sun1]",
    ),
    Defect(
        name="other solvers give red no light",
        file="uwopt/solvers/continuous/pieces.py",
        old=", *wanted_of_red(rows)),",
        new="),",
        test=f"{CONTINUOUS}[red that needs more than the mean-casadi]",
    ),
    Defect(
        name="red may do without its veils",
        file="uwopt/forward/effects.py",
        old="return problem.scenes[seen.scene_index].channels if sees_colours(curves) else ()",
        new="return ()",
        test=f"{COLOUR}::test_veils_are_kept_where_red_needs_them",
    ),
    Defect(
        name="red keeps no reserve",
        file="uwopt/mission/reserves.py",
        old='IN_DB = ("min_snr_db", "min_snr_red_db")',
        new='IN_DB = ("min_snr_db",)',
        test=f"{LIMITS}::test_requirement_is_missed_just_outside_its_limit[min_snr_red_db 2]",
    ),
    Defect(
        name="red is asked of any sensor",
        file="uwopt/forward/assembly.py",
        old='    if key == "colour" and requirements.min_snr_red_db is not None:',
        new='    if key == "shutter" and requirements.min_snr_red_db is not None:',
        test=f"{COLOUR}::test_the_sensor_is_told_where_the_mission_leaves_it_open",
    ),
    Defect(
        name="red is bounded by a part of its light",
        file="uwopt/solvers/exact/light_tables.py",
        old="contraction.response(spectrum, q, channel) * loss",
        new="contraction.response(spectrum, q, channel) * loss * (0.3 if channel else 1.0)",
        test=f"{COLOUR}::test_no_image_has_more_red_than_its_bound",
    ),
    Defect(
        name="designs that are none have some balance",
        file="uwopt/solvers/settings/cell_windows.py",
        old="return pairs.reshape(n, int(np.prod(pairs.shape[1:])))",
        new="return pairs.reshape(n, -1)",
        test=f"{COLOUR}::test_no_designs_have_no_balance",
    ),
)

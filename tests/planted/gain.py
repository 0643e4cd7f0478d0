"""Planted defects of the cap of gain."""

from __future__ import annotations

from planted.defect import Defect

CAP = "tests/api/test_gain_cap.py"
YIELDING = "tests/api/test_yielding.py"

DEFECTS = (
    Defect(
        name="what fits above the cap of gain alone is taken for nothing",
        file="uwopt/api/searching.py",
        old="any_of_all = look(capless,",
        new="any_of_all = look(mission,",
        test=f"{CAP}::test_parts_to_be_made_are_searched_once_where_nothing_fits[True]",
    ),
    Defect(
        name="a search that is left in vain is taken for a proof",
        file="uwopt/api/searching.py",
        old="            sought = look(mission, generic=first, **known_from(sought))\n",
        new="",
        test=f"{CAP}::test_what_is_left_in_vain_is_answered_all_the_same[True-10.0]",
    ),
    Defect(
        name="a cap of gain is no bound of the settings",
        file="uwopt/forward/problem.py",
        old="high = most if allowed_db is None else",
        new="high = most if True else",
        test="tests/solvers/test_exact.py::test_planted_cases_equal_enumeration[as shipped-gain that the mission caps]",
    ),
    Defect(
        name="a cap of gain never yields",
        file="uwopt/api/searching.py",
        old="and sought.outcome.complete and capless is not mission:",
        new="and False:",
        test=f"{CAP}::test_a_cap_below_which_nothing_fits_is_lifted_with_a_warning",
    ),
    Defect(
        name="a given gain beyond the cap is not told",
        file="uwopt/api/evaluating.py",
        old="            *gain_notes(as_written, design),\n",
        new="",
        test=f"{CAP}::test_a_given_gain_beyond_the_cap_is_told_and_not_refused[10.0-1]",
    ),
    Defect(
        name="a word stands for no number",
        file="uwopt/mission/keys.py",
        old='return recommended if plain == "recommended" else to_number(value)',
        new="return to_number(value)",
        test=f"{CAP}::test_good_practice_may_be_asked_for_by_its_word",
    ),
    Defect(
        name="a recommended cap of gain replaces a lower one that is asked for",
        file="uwopt/mission/reserves.py",
        old="math.inf if asked.max_gain_db is None else asked.max_gain_db",
        new="math.inf",
        test=f"{CAP}::test_a_number_of_the_requirements_is_hard",
    ),
    Defect(
        name="a margin of gain is of its ratio",
        file="uwopt/objectives/requirements.py",
        old="np.asarray(ratio_to_db(np.maximum(settings.gain, 1e-300)))",
        new="np.asarray(settings.gain)",
        test="tests/objectives/test_margin_limits.py::test_requirement_is_missed_just_outside_its_limit[max_gain_db]",
    ),
    Defect(
        name="good practice gives way though a mission says otherwise",
        file="uwopt/mission/yielding.py",
        old="if is_wanted(mission.practice) and _is_kept(mission, one))",
        new="if is_wanted(mission.practice))",
        test=f"{YIELDING}::test_what_a_mission_says_itself_does_not_give_way",
    ),
    Defect(
        name="all of good practice gives way where one key is enough",
        file="uwopt/api/yielding.py",
        old="few, enough = 0, len(known)  # so many of the first do not do, and so many do",
        new="return known",
        test=f"{YIELDING}::test_a_reserve_that_nothing_keeps_gives_way_and_is_told_first",
    ),
    Defect(
        name="the frame is asked nothing as soon as it may have less",
        file="uwopt/mission/yielding.py",
        old="    *(_frame_less(less_db) for less_db in FRAME_LESS_DB),\n",
        new="",
        test=f"{YIELDING}::test_the_frame_has_as_little_less_than_its_mean_as_will_do",
    ),
    Defect(
        name="what fits by a hair is enough",
        file="uwopt/api/yielding.py",
        old="ROOM_DB = 1.0",
        new="ROOM_DB = 0.0",
        test=f"{YIELDING}::test_what_fits_by_a_hair_is_not_enough_where_more_room_can_be_had",
    ),
    Defect(
        name="more room is kept than can be asked",
        file="uwopt/api/yielding.py",
        old="    except MissionError:\n        return None",
        new="    except MissionError:\n        raise",
        test=f"{YIELDING}::test_no_more_room_is_kept_than_can_be_asked",
    ),
    Defect(
        name="a scene that asks of its mean lets no frame give way",
        file="uwopt/mission/checks.py",
        old='if one.get("snr_at_less_db") and is_mean:',
        new='if overridden(common, one).get("snr_at_less_db") and is_mean:',
        test=f"{YIELDING}::test_the_frame_gives_way_though_one_scene_asks_of_its_mean",
    ),
    Defect(
        name="the frame has less than would do",
        file="uwopt/api/yielding.py",
        old="if overruled or (not patience.passed() and fits(rest)):",
        new="if not overruled and not patience.passed() and fits(rest):",
        test=f"{YIELDING}::test_the_frame_has_as_little_less_than_its_mean_as_will_do",
    ),
    Defect(
        name="all that may give way does, so that something is certain",
        file="uwopt/api/yielding.py",
        old="    return _in_order(given_way, _fewest(base, further, holds, patience))",
        new="    return _in_order(given_way, further)",
        test=f"{YIELDING}::test_practice_gives_way_so_that_what_is_recommended_holds_as_often_as_asked",
    ),
    Defect(
        name="practice gives way for hardly anything",
        file="uwopt/api/choosing.py",
        old="or other.counted.held >= halfway(one.counted)",
        new="or other.counted.held > one.counted.held",
        test=f"{YIELDING}::test_practice_does_not_give_way_for_less_than_half_of_what_is_short",
    ),
    Defect(
        name="light in more columns changes with the water as in fewer",
        file="uwopt/solvers/confidence/together.py",
        old="colours = (self.scenarios.nodes, columns), colours_of(camera)",
        new="colours = self.scenarios.nodes, colours_of(camera)",
        test="tests/solvers/test_confidence_deciding.py::test_how_light_changes_is_known_by_what_is_asked_of_it",
    ),
    Defect(
        name="the image's mean may have as little as its frame",
        file="uwopt/solvers/settings/windows.py",
        old='(("mean", rows.min_snr_mean), ("red"',
        new='(("mean", 0.0), ("red"',
        test="tests/solvers/test_over_frame.py::test_the_mean_has_its_snr_where_pixels_may_have_less",
    ),
    Defect(
        name="the mean's signal to noise is no requirement beside its frame's",
        file="uwopt/objectives/requirements.py",
        old="        if scene.least_mean_snr:\n",
        new="        if scene.least_mean_snr < 0.0:\n",
        test="tests/objectives/test_margin_limits.py::test_requirement_is_missed_just_outside_its_limit[min_snr_mean_db]",
    ),
    Defect(
        name="pixels that may have less are asked for all of it",
        file="uwopt/forward/scene.py",
        old="else needs.min_snr_there) or 0.0",
        new="else needs.min_snr) or 0.0",
        test="tests/solvers/test_exact.py::test_planted_cases_equal_enumeration",
    ),
    Defect(
        name="a mean beside its frame is bounded too high",
        file="uwopt/solvers/exact/bounds.py",
        old="sensor.electrons_for_snr(scene.least_mean_snr, **noise))",
        new="1.5 * sensor.electrons_for_snr(scene.least_mean_snr, **noise))",
        test="tests/solvers/test_bounds.py::test_the_pixel_that_decides_bounds_a_unit_more_sharply",
    ),
    Defect(
        name="points of cells do without the mean's signal to noise",
        file="uwopt/solvers/settings/cell_windows.py",
        old=" & (mean >= rows.min_snr_mean * (1 - MEETS))\n",
        new="\n",
        test="tests/solvers/test_cells.py::test_a_point_holds_where_the_mean_has_its_snr_beside_the_pixels",
    ),
    Defect(
        name="other solvers let the mean have as little as its frame",
        file="uwopt/solvers/continuous/pieces.py",
        old="*wanted_of_mean(rows), ",
        new="",
        test="tests/solvers/test_continuous.py::test_least_power_agrees_with_the_closed_form"
        "[mean that needs more than the darkest pixel-casadi]",
    ),
    Defect(
        name="good practice that gave way is not told of a front",
        file="uwopt/api/trading.py",
        old="warnings=[*yield_notes(given_way), *result",
        new="warnings=[*result",
        test=f"{YIELDING}::test_a_front_of_what_gives_way_says_so",
    ),
    Defect(
        name="good practice that gave way is not told",
        file="uwopt/api/solving.py",
        old="            *yield_notes(chosen.given_way, winner, to_hold=chosen.to_hold),\n",
        new="",
        test=f"{YIELDING}::test_a_reserve_that_nothing_keeps_gives_way_and_is_told_first",
    ),
)

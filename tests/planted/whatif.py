"""Planted defects of tables over varied keys: where systems change, which keys ask for more."""

from __future__ import annotations

from planted.defect import Defect

STRICTNESS = "uwopt/mission/strictness.py"
TESTS = "tests/api/test_whatif.py"
MAPS, DRAWN = "uwopt/report/pictures/system_maps.py", "tests/report/test_system_maps.py"

YIELDING = "tests/api/test_yielding.py"

DEFECTS = (
    Defect(
        name="a system ends halfway to a point that is no mission",
        file="uwopt/api/varied.py",
        old="        return made + self.at_rims()\n",
        new="        return made\n",
        test="tests/api/test_whatif.py::test_a_value_that_contradicts_the_mission_is_a_row_with_its_reason",
    ),
    Defect(
        name="where a mission ends is not looked for without a search",
        file="uwopt/api/varied.py",
        old="near, far = (middle, far) if grid.is_mission(middle) else (near, middle)",
        new="near, far = near, middle",
        test="tests/api/test_whatif.py::test_a_mission_ends_where_it_begins_to_contradict_itself_without_a_search",
    ),
    Defect(
        name="an optimum is drawn where nothing fits",
        file="uwopt/report/pictures/whatif_plots.py",
        old="if fits and not over_two:",
        new="if not over_two:",
        test="tests/api/test_whatif.py::test_where_nothing_fits_no_optimum_is_drawn_and_practice_is_told_as_it_is",
    ),
    Defect(
        name="a table holds all of good practice where the mission as it stands has no system",
        file="uwopt/api/whatif.py",
        old="if self.fits_nothing and self.asked_at < MOST_ASKED:",
        new="if False:",
        test=f"{YIELDING}::"
        "test_where_the_mission_as_it_stands_has_no_system_a_table_lets_give_way_what_a_point_needs",
    ),
    Defect(
        name="a table with certainty holds all of good practice where the mission as it stands has no system",
        file="uwopt/api/certain_points.py",
        old="return found.given_way, False, found.proves_nothing_fits",
        new="return found.given_way, False, False",
        test=f"{YIELDING}::test_a_table_with_certainty_lets_give_way_what_a_point_needs_as_one_without",
    ),
    Defect(
        name="nothing fits at points that nobody has looked at",
        file="uwopt/report/text/whatif_tables.py",
        old='point.status != "stopped" or point.system is not None for point in table.points)',
        new="True for point in table.points)",
        test="tests/api/test_whatif.py::test_a_table_that_time_cut_short_says_first_what_is_known",
    ),
    Defect(
        name="a front that was stopped is told as if it were whole",
        file="uwopt/report/text/verdict.py",
        old="if result.points and result.status in CUT:",
        new="if False:",
        test="tests/report/test_front_tables.py::"
        "test_a_front_that_was_stopped_says_before_its_systems_that_better_may_exist",
    ),
    Defect(
        name="a front that was stopped without a system may have better ones",
        file="uwopt/report/text/verdict.py",
        old='if cut else vocabulary.STATUS_SENTENCES[result.status]',
        new='if not cut else vocabulary.STATUS_SENTENCES[result.status]',
        test="tests/report/test_front_tables.py::test_a_front_that_was_stopped_without_a_system_says_so_first",
    ),
    Defect(
        name="a mission that nothing meets is said to keep good practice",
        file="uwopt/api/whatif.py",
        old="if work.fits_nothing else",
        new="if False else",
        test="tests/api/test_whatif.py::test_where_nothing_fits_no_optimum_is_drawn_and_practice_is_told_as_it_is",
    ),
    Defect(
        name="a table holds all of good practice though the mission as it stands lets it give way",
        file="uwopt/api/varied.py",
        old="with_given_way(made, self.given_way)",
        new="with_given_way(made, ())",
        test=f"{YIELDING}::test_a_table_lets_give_way_at_every_point_what_the_mission_as_it_stands_needs",
    ),
    Defect(
        name="points that kept all of good practice stay in a table of which some gives way",
        file="uwopt/api/varied.py",
        old="        for known in (self.missions, self.points, self.systems.found, self.systems.parts):\n",
        new="        for known in (self.missions, self.systems.found, self.systems.parts):\n",
        test=f"{YIELDING}::test_a_table_lets_give_way_at_every_point_what_the_mission_as_it_stands_needs",
    ),
    Defect(
        name="a key that is varied gives way",
        file="uwopt/mission/yielding.py",
        old="here = [one for one in given_way if one in known]",
        new="here = [*given_way]",
        test=f"{YIELDING}::test_what_is_varied_gives_way_at_no_point_and_full_practice_is_told_where_nothing_fits",
    ),
    Defect(
        name="a value that contradicts the mission leaves no row",
        file="uwopt/api/whatif.py",
        old='for at in grid.refused} | grid.points',
        new='for at in ()} | grid.points',
        test=f"{TESTS}::test_a_value_that_contradicts_the_mission_is_a_row_with_its_reason",
    ),
    Defect(
        name="every table asks what of good practice gives way",
        file="uwopt/api/whatif.py",
        old='== "infeasible" and not self.given_way:',
        new='in ("infeasible", "optimal") and not self.given_way:',
        test=f"{YIELDING}::test_a_table_asks_nothing_of_practice_where_something_fits_everywhere",
    ),
    Defect(
        name="a spider is of the mission with all of good practice",
        file="uwopt/api/whatif.py",
        old="with_given_way(mission, self.given_way or ())\n",
        new="with_given_way(mission, ())\n",
        test=f"{YIELDING}::test_a_spider_is_of_the_mission_that_solve_answers",
    ),
    Defect(
        name="a front drops the mission's confidence and says nothing",
        file="uwopt/api/trading.py",
        old='*central_notes(wanted, "uwopt solve holds it"), ',
        new="",
        test="tests/api/test_trading.py::test_requirements_that_leave_one_point_are_told",
    ),
    Defect(
        name="a table drops the mission's confidence and says nothing",
        file="uwopt/api/whatif.py",
        old="unheld = [] if certain else central_notes(base.base, HOLDS)",
        new="unheld = []",
        test=f"{TESTS}::test_a_confidence_of_the_mission_that_is_not_held_is_told_in_one_line",
    ),
    Defect(
        name="a map's boundaries run halfway between its points",
        file=MAPS,
        old="return [(middle_of(switch), switch.second) for switch in inside]",
        new="return [(0.5 * (low + high), switch.second) for switch in inside]",
        test=f"{DRAWN}::test_a_straight_boundary_parts_a_cell_where_it_runs",
    ),
    Defect(
        name="all boundaries of a cell meet in its middle",
        file=MAPS,
        old="    if any(len(places) != 2 for places in ends):\n",
        new="    if ends:\n",
        test=f"{DRAWN}::test_a_system_between_two_has_a_band_of_its_own",
    ),
    Defect(
        name="a side met from its other end keeps its order of systems",
        file=MAPS,
        old="return [(place, before[n]) for n",
        new="return [(place, rising[n][1]) for n",
        test=f"{DRAWN}::test_a_corner_alone_is_cut_off_by_its_own_switches[False]",
    ),
    Defect(
        name="marks of the optimum have a colour of their own",
        file="uwopt/report/pictures/whatif_plots.py",
        old="[colour_of(p.system) for p in own]",
        new="[COLOURS[number] for p in own]",
        test=f"{DRAWN}::test_a_system_has_one_colour_in_all_plots_of_a_table",
    ),
    Defect(
        name="what does not hold as often as asked wins all the same",
        file="uwopt/api/certain_points.py",
        old="        if not counted.enough:",
        new="        if False:",
        test="tests/api/test_whatif.py::test_with_certainty_each_point_knows_what_was_recommended_at_the_last",
    ),
    Defect(
        name="an interrupted point is told as known",
        file="uwopt/api/certain_points.py",
        old="        if sought.outcome.interrupted or found.widest.outcome.interrupted:",
        new="        if False:",
        test="tests/api/test_whatif.py::test_with_certainty_an_interruption_keeps_what_is_known",
    ),
    Defect(
        name="a table with certainty looks for the pieces of a complete camera in vain",
        file="uwopt/api/certain_points.py",
        old="    parts = design.hardware.parts\n",
        new="    parts = design.hardware.named\n",
        test="tests/api/test_whatif.py::test_with_certainty_a_system_is_named_as_by_likeliest_values",
    ),
    Defect(
        name="in a table with certainty a port is the same in any housing",
        file="uwopt/api/certain_points.py",
        old=' | {"port": enclosure_id(design)}',
        new="",
        test="tests/api/test_whatif.py::test_with_certainty_a_system_is_named_as_by_likeliest_values",
    ),
    Defect(
        name="who carries no lamp carries one that is none",
        file="uwopt/forward/problem.py",
        old="return 0 if self.unlit(design.light) else int(design.count)",
        new="return int(design.count)",
        test="tests/api/test_without_lamps.py::test_a_table_names_no_lamp_where_none_is_carried",
    ),
    Defect(
        name="what holds elsewhere is not looked at here",
        file="uwopt/api/certain_points.py",
        old="        self.last = made.counts\n",
        new="",
        test="tests/api/test_whatif.py::test_with_certainty_each_point_knows_what_was_recommended_at_the_last",
    ),
    Defect(
        name="waters that are known ask for what the mission before asked",
        file="uwopt/solvers/confidence/waters.py",
        old="    seen = seen_anew(known, scene.view)\n",
        new="    seen = seen_anew(known, known.view)\n",
        test="tests/solvers/test_confidence_draws.py::test_known_waters_ask_for_what_a_mission_asks",
    ),
    Defect(
        name="waters beyond the band are kept where there is none",
        file="uwopt/solvers/confidence/waters.py",
        old="if seen is None or (state.beyond and may_leave_band(known) != may_leave_band(seen)):",
        new="if seen is None:",
        test="tests/solvers/test_confidence_draws.py::test_known_waters_ask_for_what_a_mission_asks",
    ),
    Defect(
        name="more speed is always stricter",
        file=STRICTNESS,
        old="return 0  # faster covers more",
        new="pass",
        test=f"{TESTS}::test_speed_is_not_stricter_where_area_is_asked_for",
    ),
    Defect(
        name="a least budget is the first to be solved",
        file=STRICTNESS,
        old="return 1 if name in STRICTER_UP else -1 if name in STRICTER_DOWN else 0",
        new="return 1 if name in STRICTER_UP | STRICTER_DOWN else 0",
        test="tests/solvers/test_warm.py::test_what_asks_for_least_comes_first",
    ),
    Defect(
        name="switches are no sharper than the points",
        file="uwopt/api/varied.py",
        old="low, high = self._bisected(k, a, b, sharp)",
        new="low, high = a, b",
        test=f"{TESTS}::test_systems_change_where_the_table_says",
    ),
    Defect(
        name="a spider's line varies nothing",
        file="uwopt/mission/varying.py",
        old="place[varied.name] = rounded(float(place[varied.name]) * factor)",
        new="place[varied.name] = rounded(float(place[varied.name]) * 1.0)",
        test=f"{TESTS}::test_spider_moves_one_quantity_at_a_time",
    ),
    Defect(
        name="an interruption loses the table",
        file="uwopt/api/whatif.py",
        old="if not (grid.points or lines):",
        new="if not lines:",
        test=f"{TESTS}::test_interruption_keeps_what_is_solved",
    ),
    Defect(
        name="beside a point that is not known nothing fits",
        file="uwopt/api/varied.py",
        old='point.system is not None or point.status == "infeasible")',
        new="True)",
        test="tests/api/test_whatif.py"
        "::test_beside_a_point_that_time_left_unknown_nothing_is_told_to_take_over_or_end",
    ),
)

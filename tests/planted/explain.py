"""Planted defects of why nothing fits: keys that are moved, and requirements that contradict each other."""

from __future__ import annotations

from planted.defect import Defect

MOVES = "uwopt/solvers/infeasible/moves.py"
TESTS = "tests/solvers/test_moves.py"

PRICES, PRICED = "uwopt/solvers/explain/prices.py", "tests/solvers/test_prices.py"

EVERY = "tests/solvers/test_every_price.py"

ROUNDS = "tests/solvers/test_in_rounds.py"

SIBLINGS, OF_SIBLINGS = "uwopt/solvers/explain/same_sensor.py", "tests/solvers/test_siblings.py"

DRAWN = "tests/solvers/test_drawn_in.py"
SOON = "tests/solvers/test_soon_known.py"
YIELDING = "tests/api/test_yielding.py"
PATIENCE = "tests/api/test_patience.py"
BY_EITHER = f"{EVERY}::test_signal_to_noise_of_mean_and_frame_has_its_price_by_either"

DEFECTS = (
    Defect(
        name="a shorter mission has no part again that a long one may not",
        file="uwopt/solvers/infeasible/relaxer.py",
        old="any(one.rule in OF_HOURS for one in self.selection.excluded)",
        new="False",
        test="tests/solvers/test_hardware_at_hand.py::test_a_shorter_mission_may_have_parts_that_a_long_one_may_not",
    ),
    Defect(
        name="a budget is asked of central prices for ever",
        file="uwopt/solvers/infeasible/singles.py",
        old=' == "high" and name not in self.dear',
        new=' == "high"',
        test="tests/solvers/test_least_change.py"
        "::test_a_budget_is_given_up_among_a_few_imagers_before_central_prices_are_asked_about",
    ),
    Defect(
        name="what was looked at in part reads as never looked at",
        file="uwopt/solvers/infeasible/singles.py",
        old="        elif found.outcome.account.evaluated:\n",
        new="        elif False:\n",
        test="tests/solvers/test_least_change.py"
        "::test_what_was_looked_at_in_vain_but_not_to_the_end_is_told_apart",
    ),
    Defect(
        name="that clearer water would help is answer enough",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="not mover.helps_in_this_water",
        new="not mover.helpful",
        test=f"{TESTS}::test_changes_in_the_water_as_it_is_are_looked_for_soon_beside_clearer_water",
    ),
    Defect(
        name="what was found soon is lost where time ends",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="late = None if relaxations else soon",
        new="late = None",
        test=f"{TESTS}::test_changes_in_the_water_as_it_is_are_looked_for_soon_beside_clearer_water",
    ),
    Defect(
        name="in the dark limits alone are asked to give first",
        file="uwopt/solvers/infeasible/joint_changes.py",
        old='if self.few and "light" in self.trials.short_of else',
        new="if False else",
        test=f"{TESTS}::test_where_light_lacks_speed_and_height_give_from_the_first",
    ),
    Defect(
        name="a key is searched again where nothing fits",
        file="uwopt/solvers/infeasible/moves.py",
        old="                self.in_vain.add((one.key.name, value))",
        new="                pass",
        test=f"{TESTS}::test_a_value_at_which_nothing_fits_is_not_searched_again",
    ),
    Defect(
        name="nobody is told to come on a brighter day",
        file="uwopt/solvers/infeasible/move_keys.py",
        old='    if mission.physics != "paper" and len(suns) == 1 and',
        new="    if False and len(suns) == 1 and",
        test=f"{TESTS}::test_a_brighter_day_is_told_as_bright_as_it_must_be",
    ),
    Defect(
        name="a battery that is too small is no key to move",
        file="uwopt/solvers/infeasible/move_keys.py",
        old="    if is_limited and limits.energy_wh is None",
        new="    if False and limits.energy_wh is None",
        test=f"{TESTS}::test_what_holds_and_takes_energy_moves_as_far_as_it_must",
    ),
    Defect(
        name="a battery of which only the endurance is told is moved",
        file="uwopt/solvers/infeasible/move_keys.py",
        old="is_limited = math.isfinite(of_all.energy_wh) and of_all",
        new="is_limited = of_all.battery_wh is not None and of_all",
        test=f"{TESTS}::test_a_battery_that_only_times_endurance_is_no_key_to_move",
    ),
    Defect(
        name="explain says that practice would give way though nothing fits even so",
        file="uwopt/api/yielding.py",
        old="    if weakest.outcome.best:\n        text",
        new="    if True:\n        text",
        test=f"{YIELDING}::test_explain_says_that_solve_has_a_system_with_less_of_good_practice",
    ),
    Defect(
        name="explain says that nothing fits where solve has a system",
        file="uwopt/api/explaining.py",
        old="        notes = [*notes, less_practice_note(weakest)]\n",
        new="",
        test=f"{YIELDING}::test_explain_says_that_solve_has_a_system_with_less_of_good_practice",
    ),
    Defect(
        name="what would help is told of a mission that keeps all of good practice",
        file="uwopt/api/solving.py",
        old="replace(nothing, in_vain=given_way.in_vain, is_in_vain=given_way.is_in_vain)",
        new="nothing",
        test=f"{YIELDING}::test_what_would_help_is_what_solve_answers",
    ),
    Defect(
        name="what misses good practice is said to meet all that is asked",
        file="uwopt/report/text/nothing_fits.py",
        old="    if any(note.code == PRACTICE_IN_VAIN for note in result.warnings):\n",
        new="    if False:\n",
        test=f"{YIELDING}::test_what_would_help_is_what_solve_answers",
    ),
    Defect(
        name="explain tells what would help with all of good practice kept",
        file="uwopt/api/explaining.py",
        old="if weakest.outcome.complete and not weakest.outcome.best:",
        new="if weakest.outcome.complete and not (weakest.outcome.best or would_yield):",
        test=f"{YIELDING}::test_explain_says_what_would_help_as_solve_does",
    ),
    Defect(
        name="a search that took longer is explained longer",
        file="uwopt/api/explaining.py",
        old="(processor_s() - watch.since_s), LEAST_EXPLAIN_S)",
        new="(processor_s() - watch.since_s), LEAST_EXPLAIN_S, 0.4 * (processor_s() - watch.since_s))",
        test=f"{PATIENCE}::test_a_quicker_search_never_leaves_less_for_what_would_help",
    ),
    Defect(
        name="explain asks of less practice for a shorter time than solve, and explains another mission",
        file="uwopt/api/explaining.py",
        old="used.problem, patience_of(watch.deadline))",
        new="used.problem, patience_of(watch.deadline).at_most(2.0))",
        test=f"{YIELDING}::test_explain_asks_of_less_practice_as_long_as_solve_does",
    ),
    Defect(
        name="that practice would give way is not told where an explanation begins",
        file="uwopt/report/text/explanation.py",
        old="for one in (said, *told)])",
        new="for one in (said,)])",
        test=f"{YIELDING}::test_explain_says_that_solve_has_a_system_with_less_of_good_practice",
    ),
    Defect(
        name="the mean's signal to noise binds and has no price",
        file=PRICES,
        old=" | ({SNR} if MEAN_SNR in names else set())",
        new="",
        test=f"{BY_EITHER}[1.0-False]",
    ),
    Defect(
        name="what the frame may lack binds and has no price",
        file=PRICES,
        old="({SNR_LESS} if SNR in names else set())",
        new="set()",
        test=f"{BY_EITHER}[0.3-True]",
    ),
    Defect(
        name="what the frame may lack is told to cost nothing nowhere",
        file=PRICES,
        old="return asked - spare_db[SNR] if SNR in spare_db else None",
        new="return None",
        test=f"{BY_EITHER}[1.0-False]",
    ),
    Defect(
        name="who is told nothing by the end of the time is told nothing",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="        trials.go_on()\n        mover",
        new="        mover",
        test="tests/solvers/test_least_change.py"
        "::test_it_goes_on_where_nothing_is_known_to_help_when_time_ends[asked0-requirements0-keys0]",
    ),
    Defect(
        name="a battery gives by being smaller",
        file="uwopt/solvers/infeasible/joint_changes.py",
        old="if name in self.limits else name == BATTERY",
        new="if name in self.limits else False",
        test="tests/solvers/test_moves.py"
        "::test_what_holds_and_takes_energy_gives_together_with_all_else_where_energy_lacks",
    ),
    Defect(
        name="no key is moved where it goes on",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="        trials.go_on()\n        mover.try_all(one_is_enough=True)\n",
        new="        trials.go_on()\n",
        test=f"{DRAWN}::test_what_is_found_late_is_drawn_in_before_others_are_asked_again",
    ),
    Defect(
        name="what is found late is told as far as it was tried, as others are asked again before",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="        draw_in(singles, mover, FIRST_DRAWN_SHARE)\n",
        new="",
        test=f"{DRAWN}::test_what_is_found_late_is_drawn_in_before_others_are_asked_again",
    ),
    Defect(
        name="a change that its design needs all of is halved all the same",
        file="uwopt/solvers/infeasible/least_change.py",
        old="        elif share == LITTLE:\n",
        new="        elif False:\n",
        test=f"{DRAWN}::test_hardware_that_needs_all_of_a_change_is_asked_once_for_less",
    ),
    Defect(
        name="a limit is told that a few other imagers need less of",
        file="uwopt/solvers/infeasible/least_limit.py",
        old="            if best is not None and not self.by_few:\n",
        new="            if False:\n",
        test=f"{DRAWN}::test_the_best_of_a_few_imagers_takes_the_place_of_a_design_that_needs_more",
    ),
    Defect(
        name="the best figure is asked for once, however little time there was",
        file="uwopt/solvers/infeasible/least_limit.py",
        old="self.figure_s, best = LONGER * turn.left_s, ",
        new="self.figure_s, best = math.inf, ",
        test=f"{DRAWN}::test_the_best_figure_is_asked_for_again_with_more_time",
    ),
    Defect(
        name="a limit half-way is tried of all imagers at once",
        file="uwopt/solvers/infeasible/least_limit.py",
        old=", enough=True, likely=True)",
        new=", enough=True)",
        test=f"{DRAWN}::test_a_few_imagers_are_tried_first_though_all_are_soon_known",
    ),
    Defect(
        name="what likely stands in the way is dropped for all imagers at once",
        file="uwopt/solvers/infeasible/singles.py",
        old="            if name in MAY_PASS:\n",
        new="            if name in MAY_PASS and not trials.relaxer.is_soon_known():\n",
        test=f"{DRAWN}::test_a_few_imagers_are_tried_first_though_all_are_soon_known",
    ),
    Defect(
        name="what likely stands in the way waits for all that does not",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="    singles.ask_suspects()\n",
        new="",
        test=f"{SOON}::test_what_the_last_rules_speak_of_is_asked_first_and_drawn_in",
    ),
    Defect(
        name="what stands in the way once the first has given is not asked",
        file="uwopt/solvers/infeasible/singles.py",
        old="            then = asked_by(self.useless.get(name, ()), trials.limits)\n",
        new="            then = asked_by((), trials.limits)\n",
        test=f"{SOON}::test_requirements_that_nothing_meets_by_themselves_are_told_to_have_to_give",
    ),
    Defect(
        name="a requirement that parts do meet by itself is told to have to give",
        file="uwopt/solvers/infeasible/singles.py",
        old="            self._take_the_only_miss(found, others)\n            return\n        left",
        new="            self._take_the_only_miss(found, others)\n        left",
        test=f"{SOON}::test_requirements_that_nothing_meets_by_themselves_are_told_to_have_to_give",
    ),
    Defect(
        name="what helps is told far from what is asked, as all else is asked before",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="            if change.gap >= 1.0 and not trials.over:\n",
        new="            if False:\n",
        test="tests/solvers/test_hardware_at_hand.py"
        "::test_what_helps_is_drawn_in_by_its_hardware_before_all_else_is_asked",
    ),
    Defect(
        name="where one design is enough, light is made for all of a batch",
        file="uwopt/solvers/exact/evaluation.py",
        old="        if self.enough and len(turn):\n",
        new="        if False:\n",
        test="tests/solvers/test_open_nodes.py"
        "::test_where_one_that_fits_is_enough_the_lighting_of_the_first_comes_first[True-groups1]",
    ),
    Defect(
        name="a budget is said to be met by no parts by themselves where depth is in the way",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="    if found.names and any(one.name == DEEP for one in relaxations):",
        new="    if False:",
        test="tests/solvers/test_moves.py"
        "::test_a_depth_that_stands_in_the_way_too_is_named_beside_what_contradicts_it",
    ),
    Defect(
        name="no smaller battery is tried where money lacks",
        file="uwopt/solvers/infeasible/move_keys.py",
        old="if for_want_of_energy or not is_dear else SMALLER",
        new="if True else SMALLER",
        test="tests/solvers/test_moves.py::test_a_battery_is_smaller_by_what_the_budget_lacks",
    ),
    Defect(
        name="a battery is said to be of no help though cost is in the way",
        file="uwopt/solvers/infeasible/freed_rules.py",
        old='        if are_idle("cost", "mass_kg"):',
        new="        if True:",
        test="tests/solvers/test_moves.py::test_a_battery_is_smaller_by_what_the_budget_lacks",
    ),
    Defect(
        name="dear cameras are taken for what the last designs fall by",
        file="uwopt/solvers/infeasible/freed_rules.py",
        old="lost[rule] - each * tally.get(rule, 0) for",
        new="lost[rule] for",
        test=f"{SOON}::test_what_imagers_lose_by_themselves_is_not_their_last_fall",
    ),
    Defect(
        name="water that no mission can say is known not to help",
        file="uwopt/solvers/infeasible/move_keys.py",
        old="far = [min(value * times, most) if most > value else max(value / times, most) for times",
        new="far = [value * times if most > value else value / times for times",
        test=f"{TESTS}::test_water_is_tried_as_clear_as_a_mission_can_say",
    ),
    Defect(
        name="an earlier budget is settled whatever a later one discarded",
        file="uwopt/solvers/infeasible/freed_rules.py",
        old="if are_idle(*BUDGETS[place:]))",
        new="if are_idle(BUDGETS[place]))",
        test="tests/solvers/test_any_lighting.py::test_only_what_discarded_nothing_is_settled",
    ),
    Defect(
        name="of rules of imagers the first is taken for the likeliest in the way",
        file="uwopt/solvers/infeasible/freed_rules.py",
        old="else lost[::-1])]",
        new="else lost)]",
        test=f"{SOON}::test_likeliest_in_the_way_is_what_the_last_designs_fall_by[lost1-0-suspects1]",
    ),
    Defect(
        name="a camera with the same sensor is told though it misses the mission",
        file=SIBLINGS,
        old="in enumerate(values) if math.isfinite(value))",
        new="in enumerate(values))",
        test=f"{OF_SIBLINGS}::test_a_sibling_that_misses_the_mission_is_not_told",
    ),
    Defect(
        name="a colour camera is the sibling of a monochrome one",
        file=SIBLINGS,
        old="(other.chip, other.colour, other.shutter) != (own.chip, own.colour, own.shutter)",
        new="(other.chip, other.shutter) != (own.chip, own.shutter)",
        test=f"{OF_SIBLINGS}::test_what_takes_other_images_is_no_sibling",
    ),
    Defect(
        name="every sibling is told with what the first takes",
        file=SIBLINGS,
        old='places = [dict.fromkeys(OF_A_DESIGN, 0) | {"camera": place}',
        new='places = [dict.fromkeys(OF_A_DESIGN, 0) | {"camera": 0 * place}',
        test=f"{OF_SIBLINGS}::test_the_same_chip_in_another_case_is_told_with_what_it_costs",
    ),
    Defect(
        name="what gives together is looked for by the brightest design alone",
        file="uwopt/solvers/infeasible/joint_changes.py",
        old="if not MAY_PASS[name]], lit, [*names]):",
        new="if not MAY_PASS[name]], [*names]):",
        test="tests/solvers/test_soon_known.py"
        "::test_what_gives_together_is_found_where_the_brightest_takes_too_long",
    ),
    Defect(
        name="the share that was searched with is told where a design reaches more",
        file="uwopt/solvers/infeasible/joint_changes.py",
        old="        for values in (reached, fewer):\n",
        new="        for values in (fewer,):\n",
        test="tests/solvers/test_least_change.py"
        "::test_what_a_design_reaches_is_told_where_no_time_is_left_to_draw_it_in",
    ),
    Defect(
        name="a single change found with others is told as several",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="    if fit is None or len(fit.changes) != 1:\n",
        new="    if fit is None or fit.changes:\n",
        test="tests/solvers/test_least_change.py"
        "::test_changes_found_together_among_a_few_imagers_are_enough_and_one_alone_helps",
    ),
    Defect(
        name="what a design keeps as it is asked is told as a change",
        file="uwopt/solvers/infeasible/joint_changes.py",
        old="        changed = [name for name, value in asked.items() if kept[name] != value]\n",
        new="        changed = [*asked][:0]\n",
        test="tests/solvers/test_least_change.py"
        "::test_changes_found_together_among_a_few_imagers_are_enough_and_one_alone_helps",
    ),
    Defect(
        name="limits from above give less than those from below",
        file="uwopt/solvers/infeasible/joint_changes.py",
        old="            up = share / (1.0 - share) if self.by_factor else share\n",
        new="            up = share\n",
        test="tests/solvers/test_least_change.py"
        "::test_a_limit_from_above_gives_by_as_large_a_factor_as_one_from_below",
    ),
    Defect(
        name="two requirements are said to have to give where one may do",
        file="uwopt/report/text/nothing_fits.py",
        old="    if why is not None and why.not_known:\n",
        new="    if False:\n",
        test="tests/report/test_short.py::test_what_was_not_tried_is_not_told_to_be_in_vain",
    ),
    Defect(
        name="what does not help is told without a reason where no imager is left",
        file="uwopt/solvers/infeasible/relaxer.py",
        old="        return in_the_way(found, name) or none\n",
        new="        return in_the_way(found, name)\n",
        test="tests/solvers/test_least_change.py"
        "::test_what_does_not_help_alone_is_told_with_what_still_stands_in_the_way",
    ),
    Defect(
        name="a hundred times what is asked is told as a change to make",
        file="uwopt/mission/weakened.py",
        old="    return times >= FAR_TIMES or ",
        new="    return ",
        test="tests/report/test_short.py::test_ten_times_what_is_asked_is_called_out_of_reach",
    ),
    Defect(
        name="that nothing is known of single changes is told twice",
        file="uwopt/report/text/nothing_fits.py",
        old="(relaxations_of(result) or stopped or open_yet)",
        new="(relaxations_of(result) or stopped)",
        test="tests/report/test_short.py::test_what_does_not_help_is_told_with_what_stands_in_the_way",
    ),
    Defect(
        name="the nearest change has all the time until it is the least",
        file="uwopt/solvers/infeasible/least_change.py",
        old="            one.step(phase.at_most(max(fair_s, LEAST_TURN_S)))",
        new="            while not (one.is_done or phase.passed()):\n                one.step(phase)",
        test=f"{ROUNDS}::test_with_little_time_each_is_nearer",
    ),
    Defect(
        name="the smallest change comes first, which is of use as it is",
        file="uwopt/solvers/infeasible/least_change.py",
        old="(one.gap, -one.size)",
        new="(one.gap, one.size)",
        test=f"{ROUNDS}::test_the_largest_change_comes_first",
    ),
    Defect(
        name="a search that took too long is made again as near",
        file="uwopt/solvers/infeasible/least_change.py",
        old="step if self.share > CLOSER and far_enough else None, 0.5",
        new="None, 0.5",
        test=f"{ROUNDS}::test_where_searches_take_too_long_the_change_is_drawn_in_as_far_as_they_do_not",
    ),
    Defect(
        name="single changes that do not help leave no time for changes together",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="trials.deadline.but_for(KEPT_SHARE) if none_helps else ",
        new="",
        test="tests/solvers/test_least_change.py"
        "::test_changes_together_are_told_where_looking_for_single_ones_takes_all_the_time",
    ),
    Defect(
        name="evenness is asked of the fewest lamps alone before there is light",
        file="uwopt/solvers/exact/evaluation.py",
        old="for item in np.unique(table.count, return_index=True)[1]:",
        new="for item in np.unique(table.count, return_index=True)[1][:1]:",
        test="tests/solvers/test_exact.py::test_evenness_asked_before_light_loses_nothing",
    ),
    Defect(
        name="what a figure reaches is told as free though the key counts for more",
        file=PRICES,
        old="    if is_free(reach):",
        new="    if True:",
        test=f"{EVERY}::test_up_to_where_it_is_said_to_cost_nothing_it_costs_nothing",
    ),
    Defect(
        name="without a requirement the best is told that is best with it",
        file="uwopt/solvers/explain/prices.py",
        old="found.best[0].minimised if found.best else best",
        new="best",
        test=f"{EVERY}::test_what_is_told_to_do_without_a_requirement_is_the_optimum_without_it",
    ),
    Defect(
        name="only what binds has a price where all are asked for",
        file=PRICES,
        old="if every and key not in binding]",
        new="if False]",
        test=f"{EVERY}::test_every_requirement_has_a_price",
    ),
    Defect(
        name="a price is that of the mission solved before it",
        file=PRICES,
        old="        if other == mission:",
        new="        if other.scenes == mission.scenes:",
        test=f"{PRICED}::test_speed_costs_what_the_lamps_draw_more",
    ),
    Defect(
        name="the best SNR of the mean is told as the least change of the darkest pixel's",
        file="uwopt/solvers/infeasible/least_limit.py",
        old='return self.name != "min_snr" or all(',
        new='return True or all(',
        test="tests/solvers/test_least_change.py::test_the_least_snr_is_that_of_the_pixel_that_is_asked_for",
    ),
    Defect(
        name="a refusal of depth beats the reserve that is given",
        file="uwopt/mission/reserves.py",
        old="    if given is not None:\n        return given\n    return REFUSED_DEPTH if",
        new="    return max(given or 1.0, REFUSED_DEPTH) if",
        test="tests/mission/test_reserves.py::test_depth_rating_is_asked_for_with_its_reserve",
    ),
    Defect(
        name="the reserve of depth that would do is told of the rating",
        file="uwopt/report/text/helps.py",
        old="math.floor(1e3 * needed_m * factor / asked_m)",
        new="math.floor(1e3 * needed_m * factor / needed_m)",
        test="tests/solvers/test_least_change.py"
        "::test_a_reserve_of_depth_that_alone_keeps_all_ports_out_is_named_with_the_one_that_would_do",
    ),
    Defect(
        name="a figure that was reached is told with digits that nobody types",
        file="uwopt/solvers/infeasible/trials.py",
        old="rounded_away(asked_when_held(self.mission.reserve, key, value), self.limits[name])",
        new="asked_when_held(self.mission.reserve, key, value)",
        test="tests/solvers/test_least_change.py::test_best_figure_said_to_be_possible_can_be_typed_and_is_enough",
    ),
    Defect(
        name="a word that no mission takes is told as a contradiction",
        file="uwopt/api/whatif.py",
        old="if alone in fault and not (key.is_numeric and",
        new="if alone in fault and (key.is_numeric and",
        test="tests/api/test_whatif.py::test_a_word_that_no_mission_takes_is_told_as_such",
    ),
    Defect(
        name="a decibel is one of power",
        file=PRICES,
        old="return sum(found) * math.log(10.0) / 20.0 if found else None",
        new="return sum(found) * math.log(10.0) / 10.0 if found else None",
        test=f"{PRICED}::test_slope_of_snr_is_the_multiplier",
    ),
    Defect(
        name="a step is not asked of the system",
        file=PRICES,
        old="mission = base.with_values({key: value})",
        new="mission = base.base",
        test=f"{PRICED}::test_speed_costs_what_the_lamps_draw_more",
    ),
    Defect(
        name="a budget grows where its price is told",
        file=PRICES,
        old="-step if is_from_above(name) else step",
        new='-step if key.startswith("max_") else step',
        test=f"{PRICED}::test_a_limit_from_above_gets_less_and_one_from_below_more",
    ),
    Defect(
        name="what takes over is the system that is left",
        file="uwopt/api/pricing.py",
        old="until, then = (found.low, found.second) if step > 0",
        new="until, then = (found.low, found.first) if step > 0",
        test=f"{PRICED}::test_prices_over_a_range_are_those_of_searches_of_their_own",
    ),
    Defect(
        name="changes are told together that are no smaller",
        file="uwopt/solvers/infeasible/joint_changes.py",
        old="low, high, found = (low, share, others) if others.outcome.best",
        new="low, high, found = (low, share, others) if True",
        test="tests/solvers/test_least_change.py::test_smaller_changes_are_told_that_help_together",
    ),
    Defect(
        name="a move is as far as it was tried",
        file=MOVES,
        old="rounded(drawn.change.limit), unit,",
        new="rounded(float(self.value)), unit,",
        test=f"{TESTS}::test_speed_and_height_move_as_far_as_they_must",
    ),
    Defect(
        name="the clearest water is told where the next would do",
        file=MOVES,
        old="            self.fits = middle",
        new="            self.not_known = self.fits",
        test=f"{TESTS}::test_the_nearest_clearer_water_is_told",
    ),
    Defect(
        name="a speed is told that lets nothing through",
        file=MOVES,
        old="if found is None or not found.outcome.best:\n            return False\n",
        new="if found is None or not found.outcome.complete:\n            return False\n",
        test=f"{TESTS}::test_what_does_not_help_is_not_told",
    ),
    Defect(
        name="a contradiction keeps what it does not need",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="            left_out += some",
        new="            kept += some",
        test=f"{TESTS}::test_a_contradiction_is_irreducible",
    ),
    Defect(
        name="a contradiction is told though it was not known",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="    if not left_out and not sure:\n        return Contradiction()\n",
        new="",
        test=f"{TESTS}::test_a_contradiction_is_not_told_where_a_search_is_cut_short",
    ),
    Defect(
        name="what was not known to be needed is told as irreducible",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="sure and known is True",
        new="sure",
        test=f"{TESTS}::test_what_is_known_of_a_contradiction_is_told_where_a_search_is_cut_short",
    ),
    Defect(
        name="what is dropped at once is taken for useless though something fits",
        file="uwopt/solvers/infeasible/singles.py",
        old="        if found is None:\n            return {}\n        if not found.outcome.best:\n",
        new="        if found is None or found.outcome.best:\n",
        test="tests/solvers/test_least_change.py::test_dropped_at_once_no_requirement_is_lost_that_helps",
    ),
    Defect(
        name="a slope is told of twice the way",
        file=PRICES,
        old="(high - low) / (2.0 * small)",
        new="(high - low) / small",
        test=f"{PRICED}::test_slopes_are_those_of_the_steps_where_the_objective_is_a_straight_line",
    ),
    Defect(
        name="prices of another system are told over a range",
        file="uwopt/api/pricing.py",
        old="    if best is not None and abs(points[0].objective - best) > AS_GOOD * abs(best):\n        return None",
        new="    if False:\n        return None",
        test=f"{PRICED}::test_what_is_not_the_central_optimum_keeps_the_prices_of_its_own",
    ),
    Defect(
        name="budgets are told as high as the brightest hardware spends",
        file="uwopt/solvers/infeasible/joint_changes.py",
        old="self._drawn_back(share, self._in_budget(share, found))",
        new="self._drawn_back(share, found)",
        test="tests/solvers/test_moves.py"
        "::test_the_brightest_hardware_spends_no_more_than_is_asked_where_less_fits",
    ),
    Defect(
        name="an image of no use is told as a way out",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old=" if one.is_of_use]",
        new="]",
        test="tests/solvers/test_least_change.py::test_an_image_of_no_use_is_no_way_out[0.02-False]",
    ),
    Defect(
        name="a limit from below is weakened to less than nothing",
        file="uwopt/solvers/infeasible/joint_changes.py",
        old="min(alone, NO_MORE)",
        new="alone",
        test="tests/solvers/test_least_change.py::test_a_budget_that_is_missed_by_far_weakens_no_limit_to_less_than_nothing",
    ),
    Defect(
        name="what gives alone among a few imagers is not taken for what helps",
        file="uwopt/solvers/infeasible/singles.py",
        old="len(self.together[0]) != 1",
        new="True",
        test="tests/solvers/test_least_change.py"
        "::test_requirements_that_give_together_are_found_among_a_few_imagers[asked1-given1]",
    ),
    Defect(
        name="requirements are told to give together of which fewer do",
        file="uwopt/solvers/infeasible/joint_changes.py",
        old="        if others is not None and others.outcome.best:\n            found = others\n",
        new="        if False:\n            found = others\n",
        test="tests/solvers/test_least_change.py"
        "::test_requirements_that_give_together_are_found_among_a_few_imagers[asked1-given1]",
    ),
    Defect(
        name="what may help is not asked of a few imagers where all would take too long",
        file="uwopt/solvers/infeasible/singles.py",
        old="        if self.hopes.get(name):\n            self._try_among",
        new="        if False:\n            self._try_among",
        test="tests/solvers/test_least_change.py"
        "::test_what_may_help_is_asked_of_a_few_imagers_where_all_would_take_too_long",
    ),
    Defect(
        name="good practice is taken for what a person wrote",
        file="uwopt/mission/weakened.py",
        old="values <= {None, FILLED_IN.get(key)}",
        new="values <= {None}",
        test="tests/solvers/test_least_change.py::test_what_a_person_wrote_is_known_from_what_good_practice_fills_in",
    ),
    Defect(
        name="nothing is told where what helps is out of reach by far",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="        relaxations, together = every, []\n",
        new="        relaxations, together = [], []\n",
        test="tests/solvers/test_least_change.py::test_what_is_out_of_reach_by_far_is_told_where_nothing_else_is",
    ),
    Defect(
        name="what is known not to help is forgotten",
        file="uwopt/solvers/infeasible/singles.py",
        old="for one in self.helpful} | self.useless",
        new="for one in self.helpful}",
        test="tests/solvers/test_least_change.py::test_what_may_help_is_asked_of_first_and_once",
    ),
    Defect(
        name="parts that the mission does not name are told as what is left out",
        file="uwopt/solvers/infeasible/none_left.py",
        old="named = [one for one in wanted if one.part_id in asked]",
        new="named = wanted",
        test="tests/solvers/test_nearest_fit.py::test_a_hull_that_lacks_a_size_is_named_with_what_it_lacks",
    ),
    Defect(
        name="the shallowest rating is told for the deepest",
        file="uwopt/solvers/infeasible/none_left.py",
        old="deepest = max(rated",
        new="deepest = min(rated",
        test="tests/solvers/test_none_left.py"
        "::test_each_rule_tells_how_many_parts_it_takes_out_and_the_deepest_rating_is_named",
    ),
    Defect(
        name="parts without a rating are told to be rated for less",
        file="uwopt/report/text/nothing_fits.py",
        old="rows = [(count - short.unrated, less)",
        new="rows = [(count, less)",
        test="tests/solvers/test_none_left.py"
        "::test_each_rule_tells_how_many_parts_it_takes_out_and_the_deepest_rating_is_named",
    ),
    Defect(
        name="a part that would go deep enough is not named with the fact that it lacks",
        file="uwopt/solvers/infeasible/none_left.py",
        old=">= mission.required_depth_m]",
        new="> 1e9]",
        test="tests/solvers/test_none_left.py"
        "::test_a_part_that_is_rated_deep_enough_is_named_with_the_fact_that_it_lacks",
    ),
    Defect(
        name="what a design alone misses is not taken for what helps",
        file="uwopt/solvers/infeasible/singles.py",
        old="        if len(missed) != 1 or",
        new="        if True or",
        test="tests/solvers/test_least_change.py::test_what_a_design_misses_alone_is_known_to_help",
    ),
    Defect(
        name="a limit that other hardware meets is told with digits that nobody types",
        file="uwopt/solvers/infeasible/least_change.py",
        old="Change(rounded_away(step, self.asked), closer)",
        new="Change(step, closer)",
        test="tests/solvers/test_least_change.py::test_a_limit_can_be_typed_where_time_ends_at_other_hardware",
    ),
    Defect(
        name="no slower vehicle comes to fewer images a second",
        file="uwopt/solvers/infeasible/freed_rules.py",
        old='"speed_m_s": OF_RATE | {"max_blur_px"}',
        new='"speed_m_s": STORED | {"max_blur_px"}',
        test="tests/solvers/test_relaxed.py::test_imagers_that_a_moved_key_frees_are_those_of_a_mission_that_has_it_so",
    ),
    Defect(
        name="imagers see at another height what they see at this one",
        file=MOVES,
        old='return OTHER_WATER if key.section == "scene" else key.name',
        new='return OTHER_WATER if key.name != "speed_m_s" else key.name',
        test=f"{TESTS}::test_speed_and_height_move_as_far_as_they_must",
    ),
    Defect(
        name="speed and height that give together are told as asked",
        file="uwopt/solvers/infeasible/joint_changes.py",
        old="if key in self.moved and value != self.moved[key]",
        new="if key in self.moved and value is None",
        test="tests/solvers/test_least_change.py::test_limits_speed_and_height_told_together_are_enough",
    ),
    Defect(
        name="all but one requirement are never dropped at once, so that none is known to have to give",
        file="uwopt/solvers/infeasible/relaxed_imagers.py",
        old="return known is not None and max(",
        new="return known is None and max(",
        test="tests/solvers/test_soon_known.py"
        "::test_requirements_that_nothing_meets_by_themselves_are_told_to_have_to_give",
    ),
    Defect(
        name="the same few imagers are looked at twice",
        file="uwopt/solvers/infeasible/singles.py",
        old="self.in_vain.get(name, 0) >= number",
        new="self.in_vain.get(name, 0) > number",
        test="tests/solvers/test_soon_known.py"
        "::test_a_few_imagers_that_were_all_looked_at_in_vain_are_not_looked_at_again",
    ),
    Defect(
        name="imagers are listed on when time is over",
        file="uwopt/solvers/exact/imagers.py",
        old="        deadline.check()\n",
        new="",
        test="tests/solvers/test_soon_known.py"
        "::test_a_search_ends_where_its_time_does_not_suffice_to_list_its_imagers",
    ),
    Defect(
        name="a type of water that takes too long is asked again and again",
        file=MOVES,
        old="        else:\n            self.too_long = middle\n",
        new="",
        test=f"{TESTS}::test_a_type_of_water_that_takes_too_long_is_asked_once_and_clearer_ones_instead",
    ),
    Defect(
        name="all imagers are asked first though each takes designs to be tried",
        file="uwopt/solvers/infeasible/relaxed_imagers.py",
        old="if self.like is None or self.like.outcome.account.evaluated:",
        new="if self.like is None:",
        test="tests/solvers/test_soon_known.py"
        "::test_all_imagers_are_asked_first_only_where_bounds_settle_what_is_asked",
    ),
    Defect(
        name="that only the reserve of depth is in the way takes a search through all ratings",
        file="uwopt/solvers/infeasible/singles.py",
        old="if trials.mission.depth_factor > 1.0:",
        new="if False:",
        test="tests/solvers/test_least_change.py"
        "::test_where_the_reserve_of_depth_alone_is_in_the_way_that_is_known_first",
    ),
    Defect(
        name="nobody is told in how many places lamps are tried",
        file="uwopt/report/text/nothing_fits.py",
        old="if left.places <= HANDFUL:",
        new="if left.places <= 1000 * HANDFUL:",
        test="tests/report/test_short.py::test_a_search_that_was_stopped_tells_in_how_many_places_lamps_are_tried",
    ),
    Defect(
        name="hardware of a front that was stopped is all that is left",
        file="uwopt/report/text/verdict.py",
        old='left = "left" if front.status == "complete" else "found so far"',
        new='left = "left"',
        test="tests/report/test_short.py"
        "::test_a_front_whose_search_was_stopped_does_not_call_its_hardware_what_is_left[stopped-are found so far]",
    ),
    Defect(
        name="a budget that a smaller battery keeps is left open",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="for one in mover.helpful if one.name == BATTERY]",
        new="for one in mover.helpful if not one]",
        test="tests/solvers/test_moves.py"
        "::test_a_budget_that_a_smaller_battery_keeps_is_told_too_without_a_search",
    ),
)

"""Planted defects of the settings to type in."""

from __future__ import annotations

from planted.defect import Defect

SCENE, RING = "uwopt/solvers/settable/scene.py", "uwopt/solvers/settable/steps.py"
TESTS = "tests/solvers/test_rounding.py::"

SHOWN = "tests/results/test_as_set.py::"
BESIDE = "tests/api/test_patience.py::test_what_stands_beside_an_answer_takes_no_patience_from_its_doubts"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="hardware that can be set is not looked for beyond what is listed", file="uwopt/solvers/recommend.py",
        old="if better is None and not first.is_settable:", new="if False:",
        test=f"{TESTS}test_hardware_that_can_be_set_is_looked_for_beyond_what_is_listed[1.0-True]",
    ),
    Defect(
        name="whatever can be set is taken, however much worse", file="uwopt/solvers/recommend.py",
        old="FARTHER, FARTHER_REL = 20, 0.25", new="FARTHER, FARTHER_REL = 20, 25.0",
        test=f"{TESTS}test_hardware_that_can_be_set_is_looked_for_beyond_what_is_listed[100.0-False]",
    ),
    Defect(
        name="sure hardware that can be set is not looked for beyond what is listed",
        file="uwopt/solvers/recommend.py",
        old="    yield from farther(sought, deadline)\n", new="",
        test="tests/solvers/test_confidence.py::test_what_is_known_and_can_be_set_stands_in_for_what_cannot[500.0-1]",
    ),
    Defect(
        name="settings stand at an edge where the objective does not care", file=SCENE,
        old="self.away, noise, *finer, *crowded, power, *enough, value,",
        new="self.away, power, value,",
        test="tests/solvers/test_middle_settings.py::test_no_other_exposure_has_more_in_hand",
    ),
    Defect(
        name="what the darkest of the frame have in hand is not noted", file=SCENE,
        old="        rooms[at] = left\n", new="        if isinstance(at, slice):\n            rooms[at] = left\n",
        test="tests/solvers/test_middle_settings.py::test_what_the_darkest_of_the_frame_have_in_hand_counts",
    ),
    Defect(
        name="what lamps leave in hand that lean the other way is forgotten", file=SCENE,
        old="np.minimum(left[:, column], np.minimum(share, PLENTY) + enough)", new="np.minimum(share, PLENTY) + enough",
        test="tests/solvers/test_middle_settings.py::test_of_several_models_the_one_that_leaves_least_counts",
    ),
    Defect(
        name="watts are burned for what is in hand beyond enough", file=SCENE,
        old="*crowded, power, *enough,", new="power, *crowded, *enough,",
        test="tests/solvers/test_middle_settings.py::test_with_enough_in_hand_the_least_power_decides",
    ),
    Defect(
        name="a reserve that the limit keeps is asked for twice", file=SCENE,
        old="margin.margin + margin.reserve, asked)", new="margin.margin, margin.limit)",
        test="tests/solvers/test_middle_settings.py::test_enough_is_what_good_practice_keeps_in_reserve"
        "[light with a reserve]",
    ),
    Defect(
        name="figures shown are the exact optimum's", file="uwopt/results/design.py",
        old="figures=one.figures_as_set or one.figures,", new="figures=one.figures,",
        test=f"{SHOWN}test_as_set_is_what_evaluate_says_of_the_settings_typed_in",
    ),
    Defect(
        name="margins shown are the exact optimum's", file="uwopt/results/design.py",
        old="margins=one.margins_as_set or one.margins,", new="margins=one.margins,",
        test=f"{SHOWN}test_as_set_is_what_evaluate_says_of_the_settings_typed_in",
    ),
    Defect(
        name="an old file's settings are shown with the optimum's figures as if set", file="uwopt/results/design.py",
        old="check.totals is None or first.figures_as_set is None:", new="False:",
        test=f"{SHOWN}test_file_of_before_is_read_and_shows_the_optimum",
    ),
    Defect(
        name="the mark of the focus is disowned", file="uwopt/evaluation/outside.py",
        old="if stands_at_mark(model, own):", new="if False:",
        test=f"{SHOWN}test_evaluate_does_not_disown_what_solve_wrote",
    ),
    Defect(
        name="a step of the gain is disowned", file="uwopt/api/evaluating.py",
        old="if not on_a_step(scene.settings", new="if on_a_step(scene.settings",
        test=f"{SHOWN}test_evaluate_does_not_disown_what_solve_wrote",
    ),
    Defect(
        name="sharpness that is not asked for is told without the window's colours",
        file="uwopt/evaluation/influences.py",
        old="scenes, information=True)", new="scenes, information=False)",
        test=f"{SHOWN}test_as_set_is_what_evaluate_says_of_the_settings_typed_in",
    ),
    Defect(
        name="a result whose optimum cannot be set is headed optimal", file="uwopt/api/recommending.py",
        old="exact = winner.is_settable and not wide and", new="exact = not wide and",
        test=f"{TESTS}test_result_is_not_headed_optimal_where_nothing_can_be_set",
    ),
    Defect(
        name="the best is recommended though it cannot be set", file="uwopt/solvers/recommend.py",
        old="if other.minimised >= value - much or", new="if other.minimised >= first.objective_value - much or",
        test=f"{TESTS}test_next_best_that_can_be_set_is_recommended",
    ),
    Defect(
        name="what settings to set cost is nothing", file="uwopt/solvers/recommend.py",
        old="found[1:], value_as_set(first, objective), deadline)",
        new="found[1:], found[0].minimised if first.is_settable else math.inf, deadline)",
        test=f"{TESTS}test_what_is_better_as_set_is_recommended",
    ),
    Defect(
        name="settings that miss a requirement are offered", file="uwopt/solvers/recommend.py",
        old="if not again.feasible:", new="if again.scenes == []:",
        test=f"{TESTS}test_no_settings_are_offered_where_none_holds",
    ),
    Defect(
        name="each scene has its own stop behind a sealed port", file="uwopt/solvers/settable/rounding.py",
        old="if model.lenses.motorised[0]:", new="if True:",
        test=f"{TESTS}test_manual_lens_keeps_stop_and_ring_in_both_scenes",
    ),
    Defect(
        name="stops that no lens has", file=RING,
        old=" & (marks < highest * (1 - EDGE))", new="",
        test=f"{TESTS}test_stops_are_those_engraved_and_lie_on_the_lens",
    ),
    Defect(
        name="frame rates are rounded down", file=RING,
        old="math.ceil(value / step - 1e-6)", new="math.floor(value / step)",
        test=f"{TESTS}test_frame_rate_is_rounded_upward",
    ),
    Defect(
        name="times are looked for in two rounds", file=SCENE,
        old="ROUNDS = 12", new="ROUNDS = 2",
        test=f"{TESTS}test_no_setting_of_a_whole_grid_draws_less_power",
    ),
    Defect(
        name="points of a front are dimmed to the least", file=SCENE,
        old="db_to_ratio(there - here)", new="db_to_ratio(there)",
        test=f"{TESTS}test_without_an_objective_rounding_stays_near_the_optimum",
    ),
    Defect(
        name="what physics auto leaves out is not heeded when rounding", file="uwopt/solvers/settable/rounding.py",
        old='or problem.mission.physics != "auto":', new="or True:",
        test=f"{TESTS}test_what_is_printed_to_set_meets_every_requirement_when_evaluated[1466]",
    ),
    Defect(
        name="the sun does not count when settings are rounded", file=SCENE,
        old="self.rows = self.model.rows[index]",
        new="self.rows = self.model.rows[index] = replace(self.model.rows[index], sun=None)",
        test=f"{TESTS}test_sunlight_counts_when_a_sunlit_optimum_is_rounded",
    ),
    Defect(
        name="rounding looks at the pixel that asks for most", file=SCENE,
        old="with_those_between(lamp, *asked)", new="with_those_between(replace(lamp, may_miss=0), *asked)",
        test=f"{TESTS}test_few_pixels_say_of_any_settings_whether_the_snr_holds",
    ),
    Defect(
        name="rounding takes its time", file=SCENE,
        old="            self.deadline.check()\n", new="",
        test=f"{TESTS}test_rounding_ends_with_the_time",
    ),
    Defect(
        name="what stands beside an answer takes its doubts' patience", file="uwopt/api/doubting.py",
        old="partial(clock.stand_still, work)",
        new="work",
        test=f"{BESIDE}[others_in_time]",
    ),
    Defect(
        name="ranges of prices take the patience of doubts", file="uwopt/api/doubting.py",
        old="costs = clock.stand_still(partial(ranged, replace(made, prices=costs), sought, deadline))",
        new="costs = ranged(replace(made, prices=costs), sought, deadline)",
        test=f"{BESIDE}[ranged]",
    ),
    Defect(
        name="doubts take as long as they like", file="uwopt/api/doubting.py",
        old="doubts_of(sought, chosen.design, patience, choice)",
        new="doubts_of(sought, chosen.design, deadline, choice)",
        test="tests/api/test_patience.py::test_doubts_beyond_patience_are_left_out_and_told[0.0-True]",
    ),
    Defect(
        name="doubts have six seconds after minutes, too",
        file="uwopt/api/doubting.py",
        old="DOUBTS_SHARE * (processor_s() - watch.since_s)",
        new="0.0",
        test="tests/api/test_patience.py::test_doubts_have_a_quarter_of_what_a_long_answer_took",
    ),
    Defect(
        name="less time is told to be given than was taken",
        file="uwopt/deadline.py",
        old="if one > 1.5 * taken_s + more_s",
        new="if one > more_s",
        test="tests/api/test_patience.py::test_time_that_would_do_is_more_than_all_took",
    ),
    Defect(
        name="what a front trades is not kept where its points are rounded",
        file="uwopt/solvers/settable/scene.py",
        old="for name in self.figures:",
        new='for name in ("snr_db",):',
        test="tests/solvers/test_rounding.py::test_rounding_stays_near_in_all_that_a_front_trades",
    ),
    Defect(
        name="what settings to type in cost is told by exact values",
        file="uwopt/report/text/front_tables.py",
        old="value = as_set[objective.name]",
        new="value = exact",
        test="tests/report/test_front_tables.py::test_what_settings_to_type_in_cost_is_told_of_each_named_point",
    ),
)  # fmt: skip

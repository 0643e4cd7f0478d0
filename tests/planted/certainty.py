"""Planted defects of confidence: draws, light in other water, shares, choices, and what they are told as."""

from __future__ import annotations

from planted.defect import Defect

ROOM = "uwopt/solvers/confidence"
DRAWS = "tests/solvers/test_confidence_draws.py"
TESTS = "tests/solvers/test_confidence.py"
API = "tests/api/test_confidence.py"
PROOF = "tests/solvers/test_confidence_proof.py"

DEFECTS = (
    Defect(
        name="the upper side of a triangle is drawn as the lower",
        file=f"{ROOM}/draws.py",
        old="np.sqrt((1.0 - probability) * width * (high - mode))",
        new="np.sqrt((1.0 - probability) * width * (mode - low))",
        test=f"{DRAWS}::test_quantiles_are_those_of_the_triangular_distribution[1.0-2.0-5.0]",
    ),
    Defect(
        name="all facts of a part are drawn together",
        file=f"{ROOM}/draws.py",
        old="    return (shuffled(seed, name, count) + rng.random(count)) / count",
        new='    return (shuffled(seed, "", count) + rng.random(count)) / count',
        test=f"{DRAWS}::test_each_state_falls_into_another_part_of_the_probability",
    ),
    Defect(
        name="digits are not mirrored",
        file=f"{ROOM}/draws.py",
        old="        scale /= base\n",
        new="",
        test=f"{DRAWS}::test_points_fill_the_cube_evenly",
    ),
    Defect(
        name="a share of the interval is as narrow as without doubt of its own",
        file=f"{ROOM}/summary.py",
        old="z2n / (4.0 * count))",
        new="z2n / (4.0 * count**2))",
        test=f"{DRAWS}::test_the_interval_of_a_share_is_that_of_wilson[0-50]",
    ),
    Defect(
        name="the floor brightens what the water sends back",
        file=f"{ROOM}/response.py",
        old="factor = factor * (1.0 + (bright - 1.0) * self.from_floor[index][name])",
        new="factor = factor / (1.0 + (bright - 1.0) * self.from_floor[index][name])",
        test=f"{TESTS}::test_light_in_other_water_is_that_of_the_model",
    ),
    Defect(
        name="clear water is taken for murky",
        file=f"{ROOM}/waters.py",
        old='ends = self.columns(other, "low" if clarity < 0 else "high", leg)',
        new='ends = self.columns(other, "high" if clarity < 0 else "low", leg)',
        test=f"{TESTS}::test_a_murkier_water_takes_more_power_and_a_brighter_floor_less",
    ),
    Defect(
        name="K on the lamps' way is known",
        file=f"{ROOM}/waters.py",
        old='lamp_lost=LOST["least" if state.lamp_leg < 0 else "most"] ** abs(state.lamp_leg),',
        new="lamp_lost=1.0,",
        test=f"{TESTS}::test_a_murkier_water_takes_more_power_and_a_brighter_floor_less",
    ),
    Defect(
        name="the median is the best of all",
        file=f"{ROOM}/outcomes.py",
        old="return np.asarray(ordered[:, max(int(np.ceil(share * ordered.shape[1])) - 1, 0)])",
        new="return np.asarray(ordered[:, 0])",
        test=f"{TESTS}::test_median_and_ninth_tenth_are_those_of_the_one_number_in_doubt",
    ),
    Defect(
        name="a budget holds nothing in scenarios",
        file=f"{ROOM}/outcomes.py",
        old='"cost": self.limit_cost > limit(limits.cost) * ROUND,',
        new='"cost": np.zeros(len(self.imager), bool),',
        test=f"{TESTS}::test_what_is_missed_is_told_and_adds_up",
    ),
    Defect(
        name="what does not focus holds",
        file=f"{ROOM}/outcomes.py",
        old="filled = np.full((len(own), count), np.inf)",
        new="filled = np.zeros((len(own), count))",
        test=f"{TESTS}::test_it_holds_as_often_as_the_lens_focuses_so_near",
    ),
    Defect(
        name="hardware is ranked by its median alone",
        file=f"{ROOM}/counted.py",
        old="    return (not holds, one.quantile(0.5) if holds else -one.held,",
        new="    return (False, one.quantile(0.5),",
        test=f"{TESTS}::test_a_sure_camera_is_bought_where_the_other_holds_too_seldom",
    ),
    Defect(
        name="no hardware with room is looked for",
        file=f"{ROOM}/search.py",
        old="    for worse in (*WORSE, *LESS_WORSE):\n",
        new="    for worse in ():\n",
        test=f"{TESTS}::test_a_sure_camera_is_bought_where_the_other_holds_too_seldom",
    ),
    Defect(
        name="what luck alone saves counts",
        file=f"{ROOM}/worth.py",
        old="        ours, theirs = rows[chosen::2], rows[1 - chosen :: 2]",
        new="        ours, theirs = rows, rows",
        test=f"{TESTS}::test_a_number_is_worth_what_choosing_by_it_saves",
    ),
    Defect(
        name="a choice is solved again when time is over",
        file="uwopt/api/certainty.py",
        old="found = certain.central if one is certain.best else at_its_stop(",
        new="found = at_its_stop(",
        test=f"{TESTS}::test_what_was_chosen_is_kept_when_time_is_over",
    ),
    Defect(
        name="pieces of one name are one",
        file=f"{ROOM}/scenarios.py",
        old="key = (type(part), part.id)",
        new="key = part.id",
        test=f"{TESTS}::test_pieces_of_one_name_are_each_drawn_as_what_they_are",
    ),
    Defect(
        name="the iris of a given system is opened",
        file="uwopt/api/certainty.py",
        old="stops, given = None if f_number is None else [f_number], ",
        new="stops, given = None, ",
        test=f"{API}::test_a_given_system_is_counted_with_its_iris_where_it_stands",
    ),
    Defect(
        name="settings to set have an iris of their own",
        file="uwopt/solvers/settable/rounding.py",
        old="    marks = stops(model.lenses, between=between) if fixed is None else np.array([fixed])",
        new="    marks = stops(model.lenses, between=between)",
        test=f"{API}::test_what_is_recommended_holds_and_can_be_set",
    ),
    Defect(
        name="nine and ninety per cent are one",
        file="uwopt/mission/doubt.py",
        old="    if LEAST_CONFIDENCE <= share <= MOST_CONFIDENCE:",
        new="    if LEAST_CONFIDENCE <= share <= 100.0:",
        test=f"{API}::test_what_is_no_confidence_is_told_in_one_message[90-for 90 % write 0.9]",
    ),
    Defect(
        name="numbers of a panel are at the quantile of the wrong side",
        file=f"{ROOM}/panels.py",
        old="ends = {name: np.quantile(values, share, method=",
        new="ends = {name: np.quantile(values, 1.0 - share, method=",
        test=f"{PROOF}::test_what_is_proven_best_is_the_best_of_every_hardware",
    ),
    Defect(
        name="the water of a panel is the murkiest",
        file=f"{ROOM}/panels.py",
        old="return np.asarray(np.min(columns, axis=0))",
        new="return np.asarray(np.max(columns, axis=0))",
        test=f"{PROOF}::test_no_bound_is_above_what_is_counted",
    ),
    Defect(
        name="a panel's backscatter leaves no more than states by one leg alone",
        file=f"{ROOM}/panels.py",
        old="return np.maximum(self.attenuation_per_m - camera,",
        new="return np.minimum(self.attenuation_per_m - camera,",
        test=f"{PROOF}::test_the_best_of_waters_is_no_worse_where_light_is_scattered_more_than_once",
    ),
    Defect(
        name="a panel forgets what forward scattering sends to the camera",
        file=f"{ROOM}/panels.py",
        old="attenuation_per_m=lamp + beyond,",
        new="attenuation_per_m=least([one.attenuation_per_m for one in scenes]),",
        test=f"{PROOF}::test_the_best_of_waters_is_no_worse_than_each_in_any_leg",
    ),
    Defect(
        name="half of the scenarios less one are taken for too many",
        file=f"{ROOM}/panels.py",
        old="return count - int(np.ceil(share * count - 1e-9)) + 1",
        new="return count - int(np.ceil(share * count - 1e-9))",
        test=f"{PROOF}::test_a_panel_is_no_harder_than_as_many_scenarios_as_it_says",
    ),
    Defect(
        name="a lens stands where it is meant to",
        file="uwopt/solvers/exact/imagers.py",
        old="dioptre / problem.focus_share[camera]",
        new="dioptre",
        test=f"{TESTS}::test_it_holds_as_often_as_its_iris_forgives_the_focus",
    ),
    Defect(
        name="beyond its band it is as bright as at its ends",
        file=f"{ROOM}/together.py",
        old="changes[name] = np.where(seen, beyond_it, column)",
        new="changes[name] = column",
        test=f"{TESTS}::test_light_in_other_water_is_that_of_the_model",
    ),
    Defect(
        name="a panel leaves the band of altitudes as its first scenario does",
        file=f"{ROOM}/panels.py",
        old="first = min(scenes, key=lambda one: float(np.ptp(one.range_m)))",
        new="first = max(scenes, key=lambda one: float(np.ptp(one.range_m)))",
        test=f"{PROOF}::test_the_best_of_waters_is_no_worse_than_each_in_any_leg",
    ),
    Defect(
        name="settings that are fixed are those of each scenario",
        file=f"{ROOM}/fixed.py",
        old="made = Chosen(best.f_number, level, time_s, gain, x, power, peak)",
        new="made, x, gain = best, best.light_x, best.gain",
        test=f"{TESTS}::test_fixed_settings_take_what_the_worst_of_those_that_count_takes",
    ),
    Defect(
        name="fixed settings are fixed anew in scenarios to come",
        file=f"{ROOM}/search.py",
        old="f_numbers=stop, given=given), 0)",
        new="f_numbers=stop), 0)",
        test=f"{TESTS}::test_settings_that_were_fixed_are_those_of_scenarios_to_come",
    ),
    Defect(
        name="a budget counts a price as it is drawn",
        file="uwopt/catalog/parts/doubts.py",
        old="    if name in PRICES:",
        new="    if not name:",
        test=f"{DRAWS}::test_a_budget_counts_what_may_have_to_be_paid[high]",
    ),
    Defect(
        name="a system that is not certain enough is one to buy",
        file="uwopt/cli/status.py",
        old="    if known is not None and not known.enough and",
        new="    if known is not None and not known.held and",
        test=f"{API}::test_what_is_not_certain_enough_is_told_by_the_exit_status",
    ),
)

"""Defects in what feeds and fires lamps, and in the rest of a system."""

from planted.defect import Defect

REST = "tests/evaluation/test_rest.py::"
LAMPS = "tests/catalog/test_supply.py::"
CHOICE = "uwopt/catalog/choose.py"

DEFECTS = (
    Defect(
        name="hand torches light images",
        file="uwopt/catalog/readers/reading.py",
        old='    "dive torch": "a diver',
        new='    "dive-torch": "a diver',
        test="tests/catalog/test_purpose.py::test_hand_torches_are_counted_by_their_purpose_and_video_lights_stay",
    ),
    Defect(
        name="a torch that its owner names is left out for what it is sold for",
        file=CHOICE,
        old='if exclusion.rule in ("availability", "purpose") and wanted:',
        new='if exclusion.rule == "availability" and wanted:',
        test="tests/catalog/test_purpose.py::test_a_torch_is_used_by_whom_names_or_owns_it",
    ),
    Defect(
        name="the bill hides what a lamp was made for",
        file="uwopt/evaluation/bill.py",
        old="words = [made_for, part.note]",
        new="words = [part.note]",
        test="tests/evaluation/test_design_model.py::test_what_limits_a_port_stands_in_the_bill",
    ),
    Defect(
        name="torches pass as lamps that the vehicle feeds",
        file=CHOICE,
        old='if self.lamp_supply not in ("any", part.supply) and not wanted:',
        new='if self.lamp_supply not in ("any", part.supply, "external") and not wanted:',
        test=f"{LAMPS}test_lamps_are_chosen_by_what_feeds_them",
    ),
    Defect(
        name="a torch that is named is refused all the same",
        file=CHOICE,
        old='if self.lamp_supply not in ("any", part.supply) and not wanted:',
        new='if self.lamp_supply not in ("any", part.supply):',
        test=f"{LAMPS}test_a_torch_that_is_named_or_owned_may_be_used",
    ),
    Defect(
        name="a battery need last half the mission",
        file=CHOICE,
        old="None if self.duration_h is None else 60.0 * self.duration_h",
        new="None if self.duration_h is None else 30.0 * self.duration_h",
        test=f"{LAMPS}test_a_battery_must_last_as_long_as_the_mission",
    ),
    Defect(
        name="a flash that nothing fires is searched",
        file=CHOICE,
        old='if part.kind != "continuous" and part.trigger == "none":',
        new='if part.kind == "pulsed_led" and part.trigger == "none":',
        test=f"{LAMPS}test_each_lamp_that_is_left_out_is_counted_by_its_own_rule",
    ),
    Defect(
        name="torches are switched off between images",
        file="uwopt/catalog/readers/read_light.py",
        old='if supply == "battery" and not row.text("switchable")',
        new='if supply == "unknown" and not row.text("switchable")',
        test=f"{LAMPS}test_a_torch_is_not_switched_between_images_unless_it_says_so",
    ),
    Defect(
        name="a lamp without a beam is searched with that of its class",
        file="uwopt/catalog/readers/read_light.py",
        old='lacks.append("no beam angle or profile stated")',
        new="pass",
        test=(
            f"{LAMPS}test_each_lamp_that_is_left_out_is_counted_by_its_own_rule",
            f"{LAMPS}test_no_built_in_lamp_without_a_beam_is_searched",
        ),
    ),
    Defect(
        name="a strobe takes the power of its best case",
        file="uwopt/catalog/data/class_estimates.csv",
        old="LED strobe: flux while on over electrical power while on,42,19,94,",
        new="LED strobe: flux while on over electrical power while on,94,19,94,",
        test=f"{LAMPS}test_no_estimate_is_at_the_end_that_favours_a_design",
    ),
    Defect(
        name="the mission's supply of lamps reaches no choice",
        file="uwopt/forward/assembly.py",
        old="lamp_supply=mission.vehicle.lamp_supply,",
        new='lamp_supply="any",',
        test=f"{LAMPS}test_a_mission_hands_supply_and_duration_to_the_choice_of_parts",
    ),
    Defect(
        name="evaluation tells no lamp of another supply",
        file="uwopt/evaluation/outside.py",
        old="lamp_supply=vehicle.lamp_supply,",
        new='lamp_supply="any",',
        test=f"{LAMPS}test_a_mission_hands_supply_and_duration_to_the_choice_of_parts",
    ),
    Defect(
        name="good practice takes torches",
        file="uwopt/mission/practice.py",
        old='{"lamp_supply": "external"}',
        new='{"lamp_supply": "any"}',
        test=f"{LAMPS}test_good_practice_takes_lamps_that_the_vehicle_feeds",
    ),
    Defect(
        name="cameras of an unknown interface pass for any",
        file=CHOICE,
        old="if self.wish.interfaces and part.interface not in self.wish.interfaces:",
        new='if self.wish.interfaces and part.interface not in (*self.wish.interfaces, ""):',
        test="tests/catalog/test_interfaces.py::test_cameras_are_chosen_by_the_interfaces_that_the_host_has",
    ),
    Defect(
        name="connectors of lamps cost nothing",
        file="uwopt/forward/problem.py",
        old="lamp = self.wired * self.rest_price(",
        new="lamp = 0.0 * self.wired * self.rest_price(",
        test=f"{REST}test_the_rest_counts_in_cost_and_bill",
    ),
    Defect(
        name="each camera has a pressure test of its own",
        file="uwopt/forward/problem.py",
        old="share = 1.0 / self.mission.vehicle.camera_count",
        new="share = 1.0",
        test=f"{REST}test_two_cameras_share_what_is_bought_once",
    ),
    Defect(
        name="a cost limit takes the rest at its middle",
        file="uwopt/forward/problem.py",
        old='"limit_price": limit_end(self.end, high_basis)}',
        new='"limit_price": self.end}',
        test=f"{REST}test_a_cost_limit_holds_for_the_rest_at_the_end_that_it_asks_for",
    ),
    Defect(
        name="the rest stands in no bill",
        file="uwopt/evaluation/bill.py",
        old="for item in problem.rest if numbers[item.per]]",
        new="for item in problem.rest if not numbers[item.per]]",
        test=f"{REST}test_the_rest_counts_in_cost_and_bill",
    ),
    Defect(
        name="deep systems are tested as shallow ones",
        file="uwopt/catalog/rest.py",
        old="depth_m is not None and depth_m <= limit_m), DEEPEST)",
        new="depth_m is not None and depth_m <= 7.0 * limit_m), DEEPEST)",
        test=f"{REST}test_the_pressure_test_is_that_of_the_depth",
    ),
    Defect(
        name="cables among the extras count twice",
        file="uwopt/mission/practice.py",
        old='["host", "rest", *(',
        new='["host", *(',
        test=f"{REST}test_good_practice_counts_the_rest_unless_extras_hold_it",
    ),
    Defect(
        name="torches have cables",
        file="uwopt/catalog/parts/light.py",
        old='return not (self.supply == "battery" and self.kind == "continuous")',
        new="return True",
        test=f"{REST}test_torches_have_neither_cables_nor_electronics[torch]",
    ),
    Defect(
        name="flashes with batteries are fired by nothing",
        file="uwopt/catalog/parts/light.py",
        old='return not (self.supply == "battery" and self.kind == "continuous")',
        new='return self.supply != "battery"',
        test=f"{REST}test_torches_have_neither_cables_nor_electronics[fired]",
    ),
    Defect(
        name="a battery that is used up is no risk",
        file="uwopt/mission/reserves.py",
        old="BATTERY_IN_HAND = 0.2",
        new="BATTERY_IN_HAND = 0.0",
        test="tests/api/test_risks.py::test_a_battery_of_which_less_than_a_fifth_is_left_is_told"
        "[121.0-the battery is nearly used up-121 Wh of 150 Wh]",
    ),
    Defect(
        name="a search may use a battery up",
        file="uwopt/mission/duration.py",
        old="(1.0 - mission.reserve.energy) * vehicle.battery_wh",
        new="vehicle.battery_wh",
        test="tests/evaluation/test_rest.py::test_of_a_battery_its_reserve_is_kept[450.0-400.0-50.0]",
    ),
    Defect(
        name="a battery is kept in hand where nothing fits so",
        file="uwopt/mission/yielding.py",
        old='    if one.key == "energy" and not Duration.of(mission).energy_reserve_wh:',
        new='    if one.key == "energy":',
        test="tests/api/test_yielding.py::test_a_fifth_of_a_battery_stays_unused_unless_nothing_fits_so"
        "[0.81-gone1]",
    ),
    Defect(
        name="a larger battery is told without what is kept of it",
        file="uwopt/solvers/infeasible/move_keys.py",
        old="(battery_wh := of_all.battery_wh) is not None",
        new="(battery_wh := of_all.energy_wh) is not None",
        test="tests/solvers/test_moves.py::test_a_battery_of_which_a_share_is_kept_is_told_with_it",
    ),
    Defect(
        name="settings may use a battery up",
        file="uwopt/solvers/settable/scene.py",
        old='"energy_wh": BATTERY_IN_HAND',
        new='"energy_wh": 0.0',
        test="tests/solvers/test_middle_settings.py::test_enough_is_what_good_practice_keeps_in_reserve"
        "[battery nearly out]",
    ),
    Defect(
        name="torches on batteries of their own use up that of the system",
        file="uwopt/forward/problem.py",
        old='"battery" in (vehicle.lamp_supply, vehicle.supply)',
        new="False",
        test="tests/evaluation/test_duration.py"
        "::test_lamps_on_batteries_of_their_own_draw_nothing_from_that_of_the_system[pulsed_led-torches are asked for]",
    ),
    Defect(
        name="a larger battery is asked of a budget that has no room for it",
        file="uwopt/solvers/confidence/eased.py",
        old="wanted |= OF_LARGER",
        new="pass",
        test="tests/solvers/test_confidence_deciding.py"
        "::test_a_larger_battery_may_cost_more_where_it_is_bought[own]",
    ),
)

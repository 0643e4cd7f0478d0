"""Planted defects of the bill: cables, computers beside cameras, batteries, disks, what is still sold."""

from __future__ import annotations

from planted.defect import Defect

REST, HOST = "tests/evaluation/test_rest.py", "tests/evaluation/test_host.py"
SUMS = "tests/evaluation/test_bill_sums.py::test_rows_of_a_bill_add_up_to_cost_mass_and_power"
INTERFACES = "tests/catalog/test_interfaces.py"

DEFECTS = (
    Defect(
        name="a cable of unknown reach reaches",
        file="uwopt/catalog/interfaces.py",
        old="reaches_m().get(interface, 0.0)",
        new='reaches_m().get(interface, float("inf"))',
        test=f"{INTERFACES}::test_an_unknown_interface_reaches_only_a_computer_beside_it",
    ),
    Defect(
        name="one computer takes the images of cameras that do not reach it",
        file="uwopt/forward/problem.py",
        old="return 1.0 if self.beside_camera(camera) else 1.0 / self",
        new="return 1.0 / self",
        test=f"{HOST}::test_where_the_cable_does_not_reach_each_camera_has_its_computer[USB3-20.0-2-2000.0-20.0]",
    ),
    Defect(
        name="the bill has one computer for cameras that do not reach it",
        file="uwopt/evaluation/bill.py",
        old="count=problem.mission.vehicle.camera_count if beside else 1",
        new="count=1",
        test=f"{HOST}::test_where_the_cable_does_not_reach_each_camera_has_its_computer[USB3-20.0-2-2000.0-20.0]",
    ),
    Defect(
        name="flat cables go from housing to housing",
        file="uwopt/catalog/interfaces.py",
        old="(camera_count == 1 or leaves_housing(interface))",
        new="True",
        test=f"{HOST}::test_where_the_cable_does_not_reach_each_camera_has_its_computer[CSI-2-None-2-1840.0-15.0]",
    ),
    Defect(
        name="other systems are held against what is set for the scenarios",
        file="uwopt/report/text/words.py",
        old="        return known.central_objective\n",
        new="        return None if result.best is None else result.best.objective_value\n",
        test="tests/report/order/test_bom_book.py::"
        "test_other_systems_are_held_against_the_best_by_the_same_numbers",
    ),
    Defect(
        name="lamps that never light are no risk",
        file="uwopt/api/risks.py",
        old='scene.settings.get("dim_frac") == 0.0 for scene',
        new='scene.settings.get("dim_frac") is None for scene',
        test="tests/api/test_risks.py::test_lamps_that_never_light_are_told",
    ),
    Defect(
        name="computers start in no time",
        file="uwopt/forward/switching.py",
        old='camera_with_wake_up(camera, "host") if camera.takes_a_host else camera',
        new="camera",
        test=f"{HOST}::test_a_camera_waits_for_its_computer_to_start_unless_it_says_how_long_it_takes",
    ),
    Defect(
        name="cameras that reach nobody are searched",
        file="uwopt/forward/assembly.py",
        old='return mission.vehicle.cable_m if mission.catalog.host == "none" else None',
        new="return None",
        test=f"{INTERFACES}::test_without_a_computer_beside_them_cameras_must_reach_over_the_cable",
    ),
    Defect(
        name="a metre of cable costs as much as all of it",
        file="uwopt/catalog/rest.py",
        old='f"cable-m-{depth}", cable_m))',
        new='f"cable-m-{depth}"))',
        test=f"{REST}::test_the_data_cable_is_paid_by_its_length",
    ),
    Defect(
        name="network cable has no end",
        file="uwopt/catalog/rest.py",
        old="if not does_reach(LINK, cable_m):",
        new="if False:",
        test=f"{REST}::test_modems_stand_where_no_network_cable_reaches",
    ),
    Defect(
        name="the battery that is bought weighs nothing",
        file="uwopt/forward/problem.py",
        old="for item in items)) + 1e-3 * rest_g,",
        new="for item in items)),",
        test=f"{REST}::test_a_battery_of_the_system_costs_weighs_and_limits",
    ),
    Defect(
        name="disks hold the images that are asked for, not those that are taken",
        file="uwopt/evaluation/design_model.py",
        old="set_ = self.rates_hz or (0.0,) * len(asked)",
        new="set_ = (0.0,) * len(asked)",
        test=f"{REST}::test_disks_hold_the_images_of_the_rate_that_is_set",
    ),
    Defect(
        name="disks are for nothing in the search",
        file="uwopt/solvers/exact/imager_rules.py",
        old='cost = cost + disks_gb * problem.disk_prices["price"]',
        new="cost = cost + 0.0",
        test=f"{REST}::test_the_search_counts_the_disks_that_the_bill_has",
    ),
    Defect(
        name="a flange weighs nothing",
        file="uwopt/forward/part_columns.py",
        old='known["mass_kg"] + 1e-3 * flange_g',
        new='known["mass_kg"] + 0.0 * flange_g',
        test="tests/forward/test_enclosures.py::test_a_flange_weighs_in_air_and_in_water",
    ),
    Defect(
        name="a flange displaces no water",
        file="uwopt/forward/part_columns.py",
        old="displaced_kg + 1e-3 * flange_displaced_g",
        new="displaced_kg + 0.0 * flange_displaced_g",
        test="tests/forward/test_enclosures.py::test_a_flange_weighs_in_air_and_in_water",
    ),
    Defect(
        name="the row of a flange has no mass",
        file="uwopt/evaluation/bill.py",
        old="flange.price, flange.mass_g)",
        new="flange.price)",
        test=SUMS,
    ),
    Defect(
        name="rings weigh nothing in the search",
        file="uwopt/solvers/exact/imager_rules.py",
        old='lenses.mass_kg + ring["mass_kg"]',
        new="lenses.mass_kg",
        test="tests/solvers/test_spacers.py::test_rings_make_designs_that_cost_and_weigh_more_than_their_parts[34]",
    ),
    Defect(
        name="the computer's power stands in the row of the camera too",
        file="uwopt/evaluation/design_model.py",
        old="cameras_w = n * float(figures.camera_power_w[0]) - computer_w",
        new="cameras_w = n * float(figures.camera_power_w[0])",
        test=SUMS,
    ),
    Defect(
        name="rows draw the power of the first scene",
        file="uwopt/evaluation/design.py",
        old="drawn[int(np.argmax(powers))]",
        new="drawn[0]",
        test=SUMS,
    ),
    Defect(
        name="a battery hangs in the cameras' housings",
        file="uwopt/forward/problem.py",
        old="            self.lights = replace(self.lights, **{name: getattr(self.lights, name) + lamp})",
        new="            self.lights = replace(self.lights, **{name: getattr(self.lights, name) + lamp})\n"
        "        self.cameras = replace(self.cameras, mass_kg=self.cameras.mass_kg + self.extras[1])",
        test="tests/forward/test_enclosures.py::test_a_battery_in_its_own_housing_is_no_mass_in_water_of_the_cameras",
    ),
    Defect(
        name="a battery is bought for who has one",
        file="uwopt/forward/problem.py",
        old='vehicle.battery_wh if vehicle.supply == "battery" else None',
        new="vehicle.battery_wh",
        test=f"{REST}::test_a_battery_of_the_system_costs_weighs_and_limits",
    ),
    Defect(
        name="a battery gives more than it holds",
        file="uwopt/mission/duration.py",
        old="energy = min(energy, vehicle.battery_wh)",
        new="energy = max(energy, vehicle.battery_wh)",
        test=f"{REST}::test_of_battery_and_limit_the_smaller_holds[900.0-500.0]",
    ),
    Defect(
        name="the computer's disk is bought again",
        file="uwopt/forward/problem.py",
        old="np.maximum(filled - DISK_GB, 0.0)",
        new="filled",
        test=f"{REST}::test_disks_beyond_those_of_the_computer_are_bought",
    ),
    Defect(
        name="what may be sold no longer stays in",
        file="uwopt/catalog/choose.py",
        old='if self.wish.availability == "known" and part',
        new='if self.wish.availability == "never" and part',
        test=f"{INTERFACES}::test_parts_of_which_nobody_says_that_they_are_sold_can_be_left_out",
    ),
    Defect(
        name="the page keeps notes of parts to itself",
        file="uwopt/report/page/sections.py",
        old="for text in (row.note, STILL_SOLD",
        new='for text in ("", STILL_SOLD',
        test="tests/report/test_page.py::test_the_bill_of_a_page_tells_purpose_note_and_dates",
    ),
    Defect(
        name="nobody asks whether a part is still sold",
        file="uwopt/api/risks.py",
        old='row.availability == "unknown" and row.to_buy',
        new="False",
        test="tests/api/test_risks.py::test_parts_that_may_be_sold_no_longer_are_told",
    ),
    Defect(
        name="a runner-up that is never as good is equal",
        file="uwopt/solvers/explain/ties.py",
        old="and best <= winner.minimised)",
        new="or best <= winner.minimised)",
        test="tests/solvers/test_equals.py::test_a_choice_is_a_toss_where_each_may_be_the_other[winner2-rival2-False]",
    ),
    Defect(
        name="nobody tells that some runners-up were not compared",
        file="uwopt/solvers/explain/ties.py",
        old="        deadline.left_out.append(UNREACHED)\n",
        new="        pass\n",
        test="tests/solvers/test_equals.py::test_what_time_does_not_reach_is_told_and_what_it_reached_is_kept",
    ),
    Defect(
        name="ranges are those of all parts' good ends",
        file="uwopt/solvers/explain/ties.py",
        old='other, differing, "bad", objective',
        new='other, differing, "good", objective',
        test="tests/solvers/test_equals.py::test_the_ends_are_those_of_the_parts_that_differ",
    ),
    Defect(
        name="the first runner-up stands for all that are equal",
        file="uwopt/report/text/words.py",
        old="[result.runners_up[place] for place in places if",
        new="[result.runners_up[0] for place in places if",
        test="tests/report/test_short.py::test_what_the_estimates_cannot_tell_apart_is_called_equal",
    ),
)

"""Planted defects of complete cameras: their pieces, what they run on, and what is bought with them."""

from __future__ import annotations

from planted.defect import Defect

SEARCHED = "tests/solvers/test_completes.py::"
READ = "tests/catalog/test_completes.py::"
RULES = "tests/solvers/test_rules.py::"
TOLD = "tests/evaluation/test_completes.py::"
SAME = SEARCHED + "test_search_among_complete_cameras_equals_enumeration"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="a camera on its own battery drains the vehicle's",
        file="uwopt/catalog/parts/complete.py",
        old="camera = replace(camera, power_w=none, standby_w=none)",
        new="camera = replace(camera, standby_w=none)",
        test=TOLD + "test_what_runs_on_its_own_battery_draws_nothing_from_the_vehicle",
    ),
    Defect(
        name="a camera's own battery lasts for ever",
        file="uwopt/objectives/requirements.py",
        old="run_time_h * every, duration.duration_h * every",
        new="1e9 * run_time_h * every, duration.duration_h * every",
        test=SEARCHED + "test_design_says_what_its_card_and_its_trigger_miss",
    ),
    Defect(
        name="any lens goes on a complete camera, any other on its lens",
        file="uwopt/solvers/exact/imagers.py",
        old="tied = of_camera[:, None] == of_lens[None, :]",
        new="tied = np.ones((len(of_camera), len(of_lens)), bool)",
        test=SEARCHED + "test_pieces_with_other_parts_are_all_discarded_and_counted",
    ),
    Defect(
        name="a complete camera looks through another port",
        file="uwopt/solvers/exact/imagers.py",
        old="of_camera[behind.camera] != of_port[behind.ports[0]]",
        new="np.zeros(len(behind.camera), bool)",
        test=(SAME, SEARCHED + "test_pieces_with_other_parts_are_all_discarded_and_counted"),
    ),
    Defect(
        name="a group of ports is that of its first complete camera",
        file="uwopt/solvers/exact/port_groups.py",
        old="np.maximum.reduceat(tie, start),",
        new="np.minimum.reduceat(tie, start),",
        test=SEARCHED + "test_no_group_of_ports_loses_the_complete_camera_of_one_of_them",
    ),
    Defect(
        name="a complete camera's port stands among the others",
        file="uwopt/solvers/exact/port_groups.py",
        old="kind = 2 * (problem.ties[2] > 0) + ports.is_dome",
        new="kind = ports.is_dome.astype(int)",
        test=SEARCHED + "test_no_group_of_ports_loses_the_complete_camera_of_one_of_them",
    ),
    Defect(
        name="every camera fires every lamp",
        file="uwopt/forward/setting_rows.py",
        old="allowed &= cam.fires_lamps | (lamp.kind == CONTINUOUS)",
        new="allowed &= cam.fires_lamps | True",
        test=SEARCHED + "test_a_camera_that_fires_no_lamp_gets_one_that_burns",
    ),
    Defect(
        name="a lamp that nothing fires is no fault of a design",
        file="uwopt/objectives/requirements.py",
        old="fired = cameras.fires_lamps | (lights.kind == CONTINUOUS)",
        new="fired = cameras.fires_lamps | True",
        test=SEARCHED + "test_design_says_what_its_card_and_its_trigger_miss",
    ),
    Defect(
        name="a card holds any number of images in the search",
        file="uwopt/solvers/exact/imager_rules.py",
        old="<= duration.mean_rate_into(cameras.storage_gb) * slack",
        new="<= np.inf * cameras.price",
        test=SEARCHED + "test_images_of_the_whole_mission_fit_on_the_card",
    ),
    Defect(
        name="a card that just holds all images is too small",
        file="uwopt/solvers/exact/imager_rules.py",
        old="duration.mean_rate_into(cameras.storage_gb) * slack",
        new="duration.mean_rate_into(cameras.storage_gb) * 0.9999",
        test=RULES + "test_a_rule_keeps_what_is_a_millionth_inside[card_gb]",
    ),
    Defect(
        name="outlines let cards be a hundredth too small",
        file="uwopt/solvers/exact/outline.py",
        old="focus_rules(problem, rows.camera, rows.lens, focused, COARSE_ROUND)",
        new="focus_rules(problem, rows.camera, rows.lens, focused, 1.01)",
        test=RULES + "test_an_outline_discards_what_is_outside[card_gb]",
    ),
    Defect(
        name="outlines put a complete camera behind any port",
        file="uwopt/solvers/exact/outline.py",
        old="(self.groups.tie_low[at] <= tie) & (tie <= self.groups.tie_high[at])",
        new="every.copy()",
        test=RULES + "test_an_outline_discards_what_is_outside[complete]",
    ),
    Defect(
        name="a complete camera goes with another's pieces",
        file="uwopt/solvers/exact/imagers.py",
        old="tied = of_camera[:, None] == of_lens[None, :]",
        new="tied = (of_camera[:, None] > 0) == (of_lens[None, :] > 0)",
        test=RULES + "test_a_piece_of_a_complete_camera_goes_with_its_own_alone[True-lens]",
    ),
    Defect(
        name="a card is eight times its size",
        file="uwopt/evaluation/design_model.py",
        old="cards_gb=float(self.problem",
        new="cards_gb=8.0 * float(self.problem",
        test=SEARCHED + "test_design_says_what_its_card_and_its_trigger_miss",
    ),
    Defect(
        name="a timer is as fast as the camera",
        file="uwopt/forward/part_rows.py",
        old="np.minimum(rate, timer_hz)",
        new="rate",
        test=SEARCHED + "test_the_timer_limits_the_rate",
    ),
    Defect(
        name="a field of view under water is one in air",
        file="uwopt/catalog/readers/read_complete.py",
        old="half = math.asin(SEA_INDEX * math.sin(half))",
        new="half = 1.0 * half",
        test=READ + "test_focal_length_follows_from_the_field_of_view",
    ),
    Defect(
        name="a fisheye is searched as if it were rectilinear",
        file="uwopt/catalog/readers/read_complete.py",
        old='if row.text("projection") == "fisheye":',
        new='if row.text("projection") == "":',
        test=READ + "test_row_without_a_vital_fact_says_which",
    ),
    Defect(
        name="the price of a complete camera is paid for its lens too",
        file="uwopt/catalog/parts/complete.py",
        old='self._named(self.own_lens, "lens"), mounts=(MOUNT,), price=None,',
        new='self._named(self.own_lens, "lens"), mounts=(MOUNT,), price=self.price,',
        test=READ + "test_pieces_go_together_alone_and_cost_once",
    ),
    Defect(
        name="an unknown trigger fires lamps",
        file="uwopt/catalog/parts/complete.py",
        old='fires_lamps=self.lamp_trigger == "yes"',
        new='fires_lamps=self.lamp_trigger != "no"',
        test=READ + "test_only_a_signal_that_is_stated_fires_lamps",
    ),
    Defect(
        name="assembled cameras are searched where complete ones alone are wanted",
        file="uwopt/catalog/choose.py",
        old='if self.wish.complete == "only" and kind in ("camera", "lens", "port", "housing"):',
        new='if self.wish.complete == "only" and kind in ("lens", "port", "housing"):',
        test=READ + "test_mission_says_whether_they_are_searched",
    ),
    Defect(
        name="complete cameras go to any depth",
        file="uwopt/catalog/choose.py",
        old="isinstance(part, Port | Light | Housing | Complete)",
        new="isinstance(part, Port | Light | Housing)",
        test=READ + "test_battery_depth_and_patterns_leave_some_out",
    ),
    Defect(
        name="the battery of a complete camera lasts for ever",
        file="uwopt/catalog/choose.py",
        old='            return self._runs_out(part, "")\n',
        new="            return None\n",
        test=READ + "test_battery_depth_and_patterns_leave_some_out",
    ),
    Defect(
        name="the bill lists the pieces of a complete camera",
        file="uwopt/evaluation/bill.py",
        old="    if port.complete:\n        return [",
        new='    if port.complete == "none":\n        return [',
        test=TOLD + "test_bill_holds_one_camera_complete",
    ),
    Defect(
        name="a cable is paid for a camera that runs on its own",
        file="uwopt/forward/problem.py",
        old='camera = tethered * self.rest_price("camera", end)',
        new='camera = 1.0 * self.rest_price("camera", end)',
        test=TOLD + "test_rest_and_computer_are_not_bought_for_what_runs_on_its_own",
    ),
    Defect(
        name="the account forgets complete cameras",
        file="uwopt/solvers/exact/certificate.py",
        old='whole = sizes.get("complete", 0)',
        new='whole = 0 * sizes.get("complete", 0)',
        test=TOLD + "test_account_of_complete_cameras_adds_up",
    ),
    Defect(
        name="pieces of different complete cameras fit each other",
        file="uwopt/catalog/compatibility.py",
        old="    if len({part.complete for part in pieces}) == 1:",
        new="    if len({part.complete for part in pieces}) <= 2:",
        test=TOLD + "test_pieces_with_other_parts_do_not_fit",
    ),
)

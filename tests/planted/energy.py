"""Defects in what a mission uses up over its duration: energy, storage, lamps and cameras that are switched off."""

from planted.defect import Defect

DURATION = "tests/evaluation/test_duration.py::"
SEARCH = "tests/solvers/test_energy.py::"
SWITCHED = "tests/evaluation/test_switching_off.py::"
SWITCHED_SEARCH = "tests/solvers/test_switching.py::"
HOST = "tests/evaluation/test_host.py::"
BY_HAND = f"{DURATION}test_energy_storage_and_endurance_are_those_by_hand"
EXPOSED = f"{SWITCHED_SEARCH}test_lamps_and_cameras_share_the_least_power_by_hand"
OVER_SCENES = f"{SEARCH}test_cells_and_closed_form_agree_on_energy_over_two_scenes"

LEAST = f"{SWITCHED_SEARCH}test_no_level_and_time_draw_less_than_the_least_of_lamps_and_cameras"

DEFECTS = (
    Defect(
        name="cameras of flashes are bounded by their longest exposure",
        file="uwopt/solvers/settings/switched.py",
        old="rows.exposing_w(rows.exposure_s(shortest_s))",
        new="rows.exposing_w(rows.exposure_s(rows.time_max_s))",
        test=f"{LEAST}[2]",
    ),
    Defect(
        name="a dial is bounded without the level where its slope is 0",
        file="uwopt/solvers/settings/switched.py",
        old="[lowest, top, *(np.sqrt(one) for one in slopes), *(need",
        new="[lowest, top, *(need",
        test=f"{LEAST}[0]",
    ),
    Defect(
        name="points are tried in cells that can better nothing",
        file="uwopt/solvers/settings/cell_points.py",
        old="left = np.flatnonzero(self.best[pool.design] > pool.bound)",
        new="left = np.arange(len(pool.design))",
        test="tests/solvers/test_cells.py::test_points_are_tried_where_one_may_better_what_is_known",
    ),
    Defect(
        name="a block of cells is the first again",
        file="uwopt/solvers/settings/cell_bounds.py",
        old="return column[rows] if np.ndim(column) else column",
        new="return column[: rows.stop - rows.start] if np.ndim(column) else column",
        test="tests/solvers/test_cells.py::test_pixels_looked_at_block_by_block_are_the_same",
    ),
    Defect(
        name="scenes count alike whatever their share of time",
        file="uwopt/mission/duration.py",
        old="return sum(share * value for share, value in",
        new="return sum(value / len(self.shares) for share, value in",
        test=BY_HAND,
    ),
    Defect(
        name="storage of an hour counts a minute",
        file="uwopt/units.py",
        old="S_PER_H = 3600.0",
        new="S_PER_H = 60.0",
        test=BY_HAND,
    ),
    Defect(
        name="energy over scenes is no margin",
        file="uwopt/evaluation/design.py",
        old="if len(found) > 1:",
        new="if len(found) > 2:",
        test=f"{DURATION}test_limits_over_scenes_hold_just_inside_and_are_missed_just_outside",
    ),
    Defect(
        name="storage is held against each scene's rate",
        file="uwopt/solvers/exact/imager_rules.py",
        old='yield "storage_gb", duration.mean(rates) <=',
        new='yield "storage_gb", np.max(rates, axis=0) <=',
        test=f"{SEARCH}test_storage_discards_by_the_mean_over_scenes",
    ),
    Defect(
        name="energy of one scene does not limit its power",
        file="uwopt/mission/duration.py",
        old="return self.mean_power_limit_w if len(self.shares) == 1 else math.inf",
        new="return math.inf",
        test=f"{SEARCH}test_claims_hold_with_an_energy_limit",
    ),
    Defect(
        name="the SNR over scenes stays below what the energy allows",
        file="uwopt/solvers/settings/mean_limit.py",
        old="HALVINGS = 60",
        new="HALVINGS = 3",
        test=OVER_SCENES,
    ),
    Defect(
        name="cells forget the energy over scenes",
        file="uwopt/solvers/settings/cell_points.py",
        old="fits &= self.mean_limit.met_by(",
        new="fits |= self.mean_limit.met_by(",
        test=OVER_SCENES,
    ),
    Defect(
        name="bound of the mean power takes the worst scene",
        file="uwopt/solvers/exact/bounds.py",
        old="imagers.camera_power_w[rows] + power, imagers.camera_power_w[rows] + mean_power,",
        new="imagers.camera_power_w[rows] + power, imagers.camera_power_w[rows] + power,",
        test=f"{SEARCH}test_bounds_of_the_mean_power_are_no_higher_than_what_designs_draw",
    ),
    Defect(
        name="sidelap does not narrow a line",
        file="uwopt/mission/reserves.py",
        old="(S_PER_H * vehicle.speed_m_s * (1.0 - wanted.sidelap))",
        new="(S_PER_H * vehicle.speed_m_s)",
        test="tests/mission/test_coverage.py::test_area_in_an_hour_asks_for_a_swath",
    ),
    Defect(
        name="flashes recharge all through the pause",
        file="uwopt/model/light.py",
        old="np.maximum(charging_power_w, energy_j * frame_rate_hz)",
        new="energy_j * frame_rate_hz + 0.0 * charging_power_w",
        test=f"{SWITCHED}test_flashes_draw_most_while_they_recharge",
    ),
    Defect(
        name="one flash's charger stands for all",
        file="uwopt/forward/figures.py",
        old="charging_power_w=lights.charging_power_w * count,",
        new="charging_power_w=lights.charging_power_w,",
        test=f"{SWITCHED}test_flashes_draw_most_while_they_recharge",
    ),
    Defect(
        name="lamps that are off between images need no warm-up",
        file="uwopt/forward/switching.py",
        old="lights.warm_up_s + cameras.readout_s, np.inf)",
        new="cameras.readout_s, np.inf)",
        test=f"{SWITCHED}test_a_lander_draws_milliwatts_with_lamps_and_camera_off_between_images",
    ),
    Defect(
        name="lamps that must not be switched go off",
        file="uwopt/forward/switching.py",
        old="off & lights.switchable & (lights.kind == CONTINUOUS)",
        new="off & (lights.kind == CONTINUOUS)",
        test=f"{SWITCHED}test_lamps_that_stay_on_burn_all_the_time",
    ),
    Defect(
        name="one lamp's standby stands for all",
        file="uwopt/forward/switching.py",
        old="lights.standby_w * count, 0.0)",
        new="lights.standby_w, 0.0)",
        test=f"{SWITCHED}test_a_lander_draws_milliwatts_with_lamps_and_camera_off_between_images",
    ),
    Defect(
        name="cameras wake up in no time",
        file="uwopt/forward/part_rows.py",
        old='"awake_s": known["wake_up_s"] + 1.0 / rate,',
        new='"awake_s": 1.0 / rate,',
        test=f"{SWITCHED}test_a_lander_draws_milliwatts_with_lamps_and_camera_off_between_images",
    ),
    Defect(
        name="cameras that are off between images draw what the shortest exposure takes",
        file="uwopt/forward/figures.py",
        old="cam, settings.rate_hz, settings.exposure_s)",
        new="cam, settings.rate_hz)",
        test=f"{SWITCHED}test_a_lander_draws_milliwatts_with_lamps_and_camera_off_between_images",
    ),
    Defect(
        name="the lamps alone choose how long cameras expose",
        file="uwopt/solvers/settings/best.py",
        old="return replace(found, chosen=chosen, feasible=feasible, lower_bound=bound)",
        new="return replace(found, chosen=chosen, feasible=feasible)",
        test=EXPOSED,
    ),
    Defect(
        name="cells charge cameras for the longest exposure in them",
        file="uwopt/solvers/settings/cell_bounds.py",
        old="rows.exposing_w(self.exposure_s(d, box.t_lo, box.open_lo))",
        new="rows.exposing_w(self.exposure_s(d, box.t_hi, box.open_hi))",
        test=EXPOSED,
    ),
    Defect(
        name="the highest SNR leaves no power for the exposure",
        file="uwopt/solvers/settings/best.py",
        old="most_w = camera_power_w + np.max([r.exposing_w(r.longest_exposure_s) for r in rows], axis=0)",
        new="most_w = camera_power_w",
        test=f"{SWITCHED_SEARCH}test_power_is_left_for_the_exposure_of_the_highest_snr",
    ),
    Defect(
        name="power of lamps that are off between images is bounded as if they burnt on",
        file="uwopt/solvers/exact/lightings.py",
        old="return np.minimum(1.0, rate_hz * (self.lead_s + time_s))",
        new="return np.ones_like(rate_hz)",
        test=f"{SWITCHED_SEARCH}test_bounds_are_no_higher_than_what_switched_lamps_draw",
    ),
    Defect(
        name="most light within a power forgets the warm-up of a step",
        file="uwopt/solvers/settings/closed_form.py",
        old="left = (share / rows.rate_hz)[:, None] - levels * lead_s[:, None]",
        new="left = (share / rows.rate_hz)[:, None] - 0.0 * levels * lead_s[:, None]",
        test=f"{SWITCHED_SEARCH}test_most_light_within_a_power_by_hand",
    ),
    Defect(
        name="cells let lamps that are off between images burn on",
        file="uwopt/solvers/settings/cell_bounds.py",
        old="timed, duty = self.timed[d], rows.on_share(box.t_lo)",
        new="timed, duty = self.timed[d], np.ones(len(d))",
        test=f"{SWITCHED_SEARCH}test_cells_and_closed_form_agree_on_switched_lamps",
    ),
    Defect(
        name="each camera has a computer of its own",
        file="uwopt/forward/problem.py",
        old="return self.mission.vehicle.camera_count if self.beside_camera(camera) else 1",
        new="return self.mission.vehicle.camera_count",
        test=f"{HOST}test_two_cameras_share_one_computer",
    ),
    Defect(
        name="the computer stands in no bill",
        file="uwopt/evaluation/bill.py",
        old="    if problem.counts_host and camera.takes_a_host:\n",
        new="    if not problem.counts_host and camera.takes_a_host:\n",
        test=f"{HOST}test_the_computer_of_an_interface_counts_in_power_and_cost",
    ),
    Defect(
        name="the computer costs what it does in another currency",
        file="uwopt/forward/part_rows.py",
        old='return np.array(amounts, float) * money(1.0, "USD")',
        new="return np.array(amounts, float)",
        test=f"{HOST}test_the_computer_of_an_interface_counts_in_power_and_cost",
    ),
)

"""Defects in what a mission uses up over its duration: energy, storage, lamps and cameras that are switched off."""

from planted.defect import Defect

DURATION = "tests/evaluation/test_duration.py::"
SEARCH = "tests/solvers/test_energy.py::"
BY_HAND = f"{DURATION}test_energy_storage_and_endurance_are_those_by_hand"
OVER_SCENES = f"{SEARCH}test_cells_and_closed_form_agree_on_energy_over_two_scenes"

DEFECTS = (
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
        old="if len(scenes) > 1:",
        new="if len(scenes) > 2:",
        test=f"{DURATION}test_limits_over_scenes_hold_just_inside_and_are_missed_just_outside",
    ),
    Defect(
        name="storage is held against each scene's rate",
        file="uwopt/solvers/exact/imagers.py",
        old='yield "storage_gb", problem.duration.mean(rates) <=',
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
        file="uwopt/solvers/settings/cells.py",
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
)

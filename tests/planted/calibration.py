"""Planted defects of test shots: how they are read, fitted, left out and written."""

from __future__ import annotations

from planted.defect import Defect

FITS, CALLS, READS = "tests/solvers/test_calibration.py", "tests/cli/test_calibrate.py", "tests/mission/test_shots.py"
FIT, LIGHT, API = "uwopt/solvers/calibration/fit.py", "uwopt/solvers/calibration/light.py", "uwopt/api/calibrating.py"

DEFECTS = (
    Defect(
        name="shots of which the model tells no whole number are fitted",
        file=API,
        old="LEAST_TOLD_DN = 1.0",
        new="LEAST_TOLD_DN = 1e-9",
        test=f"{FITS}::test_a_shot_of_which_the_model_tells_less_than_a_number_is_left_out",
    ),
    Defect(
        name="intervals of test shots are one standard error",
        file=FIT,
        old="return np.asarray(stdtrit(n - p, 0.5 * (1.0 + LEVEL)) * spread)",
        new="return np.asarray(spread)",
        test=f"{FITS}::test_intervals_hold_the_truth_as_often_as_they_say",
    ),
    Defect(
        name="murkier water takes nothing more of the lamps' light",
        file=LIGHT,
        old="lamp_attenuation_per_m=scene.lamp_attenuation_per_m * factor,",
        new="lamp_attenuation_per_m=scene.lamp_attenuation_per_m,",
        test=f"{FITS}::test_shots_worked_out_by_hand_give_light_and_water_back",
    ),
    Defect(
        name="the dark level stays in the level",
        file=API,
        old="return (shot.level - shot.dark) * (",
        new="return shot.level * (",
        test=f"{FITS}::test_shots_worked_out_by_hand_give_light_and_water_back",
    ),
    Defect(
        name="water that shots do not tell is fitted all the same",
        file=FIT,
        old="WIDEST = float(np.log(2.0))",
        new="WIDEST = float(np.log(1e9))",
        test=f"{FITS}::test_noisy_shots_from_near_distances_hold_the_water",
    ),
    Defect(
        name="shots that do not fit are taken",
        file=FIT,
        old="return far if far.sum() <=",
        new="return none if far.sum() <=",
        test=f"{FITS}::test_a_shot_that_does_not_fit_is_told_and_not_taken",
    ),
    Defect(
        name="a full well is no end of a test shot",
        file=LIGHT,
        old="min(2.0 ** float(cameras.bits[0]) - 1.0, float(cameras.saturation_e[0]) * per_e[n])",
        new="2.0 ** float(cameras.bits[0]) - 1.0",
        test=f"{FITS}::test_a_full_well_saturates_below_the_last_number",
    ),
    Defect(
        name="the new mission keeps its old floor",
        file=API,
        old="float(f\"{scene['seafloor'] * factor:.4g}\")",
        new="float(f\"{scene['seafloor']:.4g}\")",
        test=f"{FITS}::test_what_was_fitted_is_what_the_new_mission_shows",
    ),
    Defect(
        name="the new water is the old one",
        file=API,
        old="factor * np.interp(GRID_NM, optics.wavelength_nm, column)",
        new="np.interp(GRID_NM, optics.wavelength_nm, column)",
        test=f"{FITS}::test_what_was_fitted_is_what_the_new_mission_shows",
    ),
    Defect(
        name="a brighter lamp is set to the light that it had",
        file=API,
        old='own["flux_lm"] *= leaves',
        new='own["flux_lm"] *= 1.0',
        test=f"{CALLS}::test_command_tells_fits_and_writes_what_loads",
    ),
    Defect(
        name="a card's shots are put down to the floor",
        file=API,
        old='"lamp" if card is not None else "floor"',
        new='"floor"',
        test=f"{CALLS}::test_a_card_tells_the_lamp_and_the_search_takes_it",
    ),
    Defect(
        name="decibels of a shot's gain are a ratio",
        file="uwopt/mission/shots.py",
        old='float(db_to_ratio(number)) if unit == "_db" else number * one.units[unit]',
        new='number if unit == "_db" else number * one.units[unit]',
        test=f"{READS}::test_units_of_the_header_come_to_si",
    ),
)

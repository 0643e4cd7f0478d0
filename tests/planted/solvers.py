"""Planted defects of the search: bounds, rules that discard, settings, fronts."""

from __future__ import annotations

from planted.defect import Defect

DARK = "tests/solvers/test_dark.py::"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="a pulse is taken as short as can be though dark current helps the wanted level",
        file="uwopt/solvers/dark.py",
        old="return np.asarray(top & (sides.for_level <= sides.for_snr))",
        new="return np.asarray(top)",
        test=f"{DARK}test_pulse_as_long_as_allowed_lets_dark_current_fill_the_wanted_level",
    ),
    Defect(
        name="settings are kept though their dark electrons are not those that they were chosen for",
        file="uwopt/solvers/goals.py",
        old="best = replace(best, feasible=best.feasible & settled)",
        new="best = replace(best, feasible=best.feasible)",
        test=f"{DARK}test_lamp_burns_until_dark_electrons_leave_no_room_in_the_well",
    ),
    Defect(
        name="designs that the longest exposure rules out are not looked at again",
        file="uwopt/solvers/goals.py",
        old="lost = ~best.feasible & (ever | (rows[0].mean_level is not None))",
        new="lost = np.zeros(len(ever), bool)",
        test=f"{DARK}test_step_that_dark_current_rules_out_at_its_longest_time_is_still_used_at_a_shorter_one",
    ),
    Defect(
        name="bounds forget that dark current may fill the wanted level",
        file="uwopt/solvers/dark.py",
        old="spare_dark_s=longest - shortest)",
        new="spare_dark_s=0.0 * longest)",
        test=f"{DARK}test_bounds_for_any_veil_are_no_higher_than_the_power_with_the_least_veil",
    ),
)

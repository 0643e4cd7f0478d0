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
    Defect(
        name="the least change of a limit is that of the first hardware that was found",
        file="uwopt/solvers/least_change.py",
        old="        if not closer.outcome.best:",
        new="        if True:",
        test="tests/solvers/test_least_change.py::"
        "test_least_change_of_swath_takes_the_wider_lens_though_the_other_needs_less_power",
    ),
    Defect(
        name="a limit is said to be possible that the cheapest design happens to reach",
        file="uwopt/solvers/least_change.py",
        old="        change = with_its_hardware(asked, change, relaxed)\n",
        new="        return change\n",
        test="tests/solvers/test_least_change.py::test_least_blur_is_that_of_the_lamp_at_full_level",
    ),
    Defect(
        name="a possible limit is rounded towards what was asked",
        file="uwopt/solvers/least_change.py",
        old="if value > asked else math.floor",
        new="if value < asked else math.floor",
        test="tests/solvers/test_least_change.py::test_limit_to_type_is_rounded_away_from_what_was_asked",
    ),
    Defect(
        name="of parts not rated deep enough the first is named",
        file="uwopt/solvers/infeasible.py",
        old="        found = deeper\n",
        new="        break\n",
        test="tests/solvers/test_least_change.py::test_least_change_of_depth_is_that_of_the_part_rated_deepest",
    ),
)

"""Planted defects of bounds of quality and its price at the same settings."""

from __future__ import annotations

from planted.defect import Defect

FILE = "uwopt/solvers/settings/joint.py"
TESTS = "tests/solvers/test_joint.py"
KNEE = "tests/solvers/test_best_image.py"

DEFECTS = (
    Defect(
        name="light of a joint bound is four times what an opening needs",
        file=FILE,
        old="np.square(ends[:, :-1] * rows.working_factor[:, None])",
        new="4.0 * np.square(ends[:, :-1] * rows.working_factor[:, None])",
        test=f"{TESTS}::test_no_settings_beat_the_bound_and_it_is_near[steps]",
    ),
    Defect(
        name="a disc of defocus blurs more than it does in a joint bound",
        file=FILE,
        old="np.sqrt(32.0 * np.log(2.0))",
        new="np.sqrt(12.0 * np.log(2.0))",
        test=f"{TESTS}::test_the_table_holds_every_transfer_of_the_model",
    ),
    Defect(
        name="colours spread three times as far in a joint bound",
        file=FILE,
        old="place = SPREADS[:, None, None]",
        new="place = 3.0 * SPREADS[:, None, None]",
        test=f"{TESTS}::test_the_table_holds_every_transfer_of_the_model",
    ),
    Defect(
        name="no limit of power in a joint bound",
        file=FILE,
        old="(power <= light_limit_w[:, None, None] * ROUND)",
        new="(power <= np.inf)",
        test=f"{TESTS}::test_a_limit_of_power_is_kept",
    ),
    Defect(
        name="the light of an interval is that of its greater SNR",
        file="uwopt/solvers/exact/joint_bounds.py",
        old="np.where(electrons > 0.0, electrons / signal[:, None], 0.0)",
        new="np.where(electrons > 0.0, 4.0 * electrons / signal[:, None], 0.0)",
        test=f"{KNEE}::test_quality_and_price_together_hold_all_that_is_drawn[dear]",
    ),
    Defect(
        name="under the sun designs wait until no other bound is less",
        file="uwopt/solvers/exact/evaluation.py",
        old="while sunlit and self._waiting",
        new="while False and self._waiting",
        test="tests/solvers/test_beatable.py::"
        "test_what_waits_under_the_sun_is_solved_before_the_next_are_bounded",
    ),
)

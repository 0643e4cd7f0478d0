"""Planted defects of what is shown: amounts of money, and photographs that are simulated."""

from __future__ import annotations

from planted.defect import Defect

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="the high end of a price is rounded down",
        file="uwopt/units.py",
        old="{_in_digits(round_up(high, exponent), exponent)}",
        new="{_in_digits(round(high, -exponent), exponent)}",
        test=(
            "tests/test_units.py::test_no_end_of_a_price_is_understated",
            "tests/test_units.py::test_a_price_has_no_digits_that_nobody_knows[2930.0-10494.0-2 900 to 11 000 USD]",
        ),
    ),
    Defect(
        name="a line of the terminal ends within a number",
        file="uwopt/report/text/layout.py",
        old="formats.tied(self.plain, SOLID)",
        new="formats.tied(self.plain)",
        test="tests/report/test_console.py::test_no_line_of_the_terminal_ends_within_an_amount_of_money",
    ),
    Defect(
        name="detail that falls is blurred as the finest that rises",
        file="uwopt/report/pictures/photograph.py",
        old="np.minimum(turns, rows - turns)",
        new="np.minimum(turns, rows // 2)",
        test="tests/report/test_picture.py::test_bars_keep_the_modulation_that_the_transfer_function_says",
    ),
    Defect(
        name="a simulated photograph is as wide as at infinity",
        file="uwopt/report/pictures/photograph.py",
        old="field_of_view_m(view, design.model.hardware.landscape)[0] * 1e3 / width",
        new="float(view.gsd_m[0, 1]) * 1e3 * block_px",
        test="tests/evaluation/test_breathing.py::test_the_simulated_photograph_is_as_wide_as_the_image_surely_covers",
    ),
)

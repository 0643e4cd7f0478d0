"""Planted defects of the fields of parts: their declarations, and what is made of them."""

from __future__ import annotations

from planted.defect import Defect

TESTS = "tests/catalog/test_parts.py"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        "an open end of a range is held",
        "uwopt/catalog/parts/cell.py",
        "value > self.low if self.open_low else value >= self.low",
        "value >= self.low",
        f"{TESTS}::test_a_range_holds_its_ends_unless_they_are_open",
    ),
    Defect(
        "numbers far too small pass as a part's",
        "uwopt/catalog/parts/cell.py",
        "value == 0.0 or least <= abs(value) <= most",
        "value == 0.0 or abs(value) <= most",
        (
            f"{TESTS}::test_a_number_that_no_part_has_is_told_on_either_side",
            f"{TESTS}::test_an_inline_number_that_no_part_has_is_refused",
        ),
    ),
    Defect(
        "an inline record loses its own estimate",
        "uwopt/catalog/readers/reading.py",
        "user_number(value) or inline.estimate",
        "user_number(value)",
        f"{TESTS}::test_an_inline_record_takes_no_estimate_but_its_own",
    ),
    Defect(
        "any interface goes before the camera's own",
        "uwopt/catalog/readers/read_camera.py",
        'row.text("interface"), "any"',
        '"any", row.text("interface")',
        f"{TESTS}::test_a_camera_takes_the_power_of_its_interface_before_that_of_any",
    ),
    Defect(
        "saturation from decibels of 20",
        "uwopt/catalog/readers/read_camera.py",
        "10.0 ** (snr_max_db / 10.0)",
        "10.0 ** (snr_max_db / 20.0)",
        f"{TESTS}::test_saturation_follows_from_the_best_signal_to_noise_ratio",
    ),
    Defect(
        "microseconds stand as milliseconds",
        "uwopt/forward/part_rows.py",
        "convert(1.0, unit, si) or 1.0",
        "1e3 * (convert(1.0, unit, si) or 1.0)",
        f"{TESTS}::test_names_of_columns_carry_the_unit_of_their_numbers",
    ),
)

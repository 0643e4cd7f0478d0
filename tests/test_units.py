"""Conversions at the door, and numbers for people."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uwopt import units
from uwopt.documents.key_types import keys_of
from uwopt.mission.mission import mission_sections


@pytest.mark.parametrize(
    ("convert", "value", "expected"),
    [
        (units.db_to_ratio, 30.0, 31.6227766),  # 10^1.5, by table
        (units.db_to_ratio, np.array([20.0, 6.0]), [10.0, 1.9952623]),
        (units.ratio_to_db, 2.0, 6.0205999),  # 20 log10 2, by table
        (units.ratio_to_db, np.array([0.0, 1.0, 100.0]), [-math.inf, 0.0, 40.0]),
    ],
)
def test_decibels_are_of_amplitudes(convert, value, expected):
    assert convert(value) == pytest.approx(expected, rel=1e-8)  # digits of the tabulated values


@given(st.floats(-200, 200))
def test_decibels_and_ratios_are_inverse(level_db):
    assert units.ratio_to_db(units.db_to_ratio(level_db)) == pytest.approx(level_db, abs=1e-10)


def test_a_ratio_of_zero_is_minus_infinite_decibels():
    assert units.ratio_to_db(0.0) == -math.inf


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("altitude_mm", ("altitude", "mm")),
        ("speed_m_s", ("speed", "m_s")),
        ("altitude", ("altitude", "")),
        ("min_snr_db", ("min_snr", "db")),
        ("pitch_rate_deg_s", ("pitch_rate", "deg_s")),
        ("m", ("m", "")),
    ],
)
def test_a_name_splits_into_stem_and_unit(name, parts):
    assert units.split_unit(name) == parts


def test_keys_of_a_mission_split_into_the_unit_that_they_end_in():
    """`c_per_m` is no length: it was told in metres."""
    for name in (name for model in mission_sections().values() for name in keys_of(model)):
        ends = [suffix for suffix in units.UNIT_SUFFIXES if name.endswith(suffix) and suffix != "_frac"]
        assert units.split_unit(name)[1] == max(ends, key=len, default="_")[1:], name


def test_convert_knows_what_measures_one_thing():
    assert units.convert(2000, "mm", "m") == pytest.approx(2.0)
    assert units.convert(1, "kn", "m_s") == pytest.approx(0.514444, rel=1e-6)  # 1852 m / 3600 s
    assert units.convert(1, "ft", "m") == pytest.approx(0.3048)
    assert units.convert(1, "m", "s") is None


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.86, "ms", "0.860 ms"),
        (2.0, "_m", "2.00 m"),
        (20000.0, "lm", "20 000 lm"),
        (7543.21, "USD", "7 543 USD"),
        (3.45, "um", "3.45 µm"),
        (0.5, "m_s", "0.500 m/s"),
        (62.5, "deg", "62.5°"),
        (9.996, "mm", "10.0 mm"),
        (999.7, "mm", "1 000 mm"),
        (0.00123, "", "0.00123"),
        (1.23e-7, "w", "1.23e-07 W"),
        (0.0, "w", "0 W"),
        (None, "m", "–"),
        (math.inf, "m", "infinite m"),
        (1 / 3600, "hz", "once every 60 min"),
        (0.000277778, "Hz", "once every 60 min"),  # as set, with six digits: 3599.997 s
        (0.05, "hz", "once every 20 s"),
        (1 / 86400, "hz", "once every 24 h"),
        (1 / 500000, "hz", "once every 5.79 days"),
        (0.1, "hz", "0.100 Hz"),
        (0.0, "hz", "0 Hz"),
        (math.inf, "hz", "infinite Hz"),
    ],
)
def test_quantities_have_three_significant_digits_and_their_unit(value, unit, text):
    assert units.format_quantity(value, unit) == text


def test_a_difference_of_rates_is_no_interval():
    assert units.format_difference(0.05, "hz") == "0.0500 Hz"


@given(st.floats(allow_nan=False, allow_infinity=False, min_value=-1e12, max_value=1e12))
def test_a_formatted_number_is_within_half_a_digit(value):
    read = float(units.format_number(value).replace(" ", ""))
    assert read == pytest.approx(value, rel=0.0051)  # half of the third digit of 1.00


def test_every_suffix_is_lower_case_and_unique():
    assert len(set(units.UNIT_SUFFIXES)) == len(units.UNIT_SUFFIXES)
    assert all(re.fullmatch(r"(_[a-z0-9]+)+", suffix) for suffix in units.UNIT_SUFFIXES)


def _db(value, digits):
    return units.format_quantity(value, "dB", digits)


@pytest.mark.parametrize(
    ("values", "texts"),
    [
        ((24.997, 25.0), ("24.997 dB", "25.000 dB")),  # with three digits both were 25.0 dB
        ((24.99, 25.0), ("24.99 dB", "25.00 dB")),
        ((29.0, 30.0), ("29.0 dB", "30.0 dB")),
        ((25.0, 25.0), ("25.0 dB", "25.0 dB")),
        ((25.0 * (1 - 5e-7), 25.0), ("25.0 dB", "25.0 dB")),  # counts as met, so it looks met
        ((25.0 * (1 - 2e-6), 25.0), ("24.99995 dB", "25.00000 dB")),
        ((None, 25.0), ("–", "25.0 dB")),
        ((math.inf, 25.0), ("infinite dB", "25.0 dB")),
    ],
)
def test_numbers_side_by_side_have_the_digits_that_tell_them_apart(values, texts):
    assert units.texts_apart(*values, text=_db) == texts


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [
        (5498.0, 19459.0, "5 000 to 20 000 USD"),  # two digits of the high end: thousands, outward
        (2930.0, 10494.0, "2 900 to 11 000 USD"),  # a budget of 10 000 is not enough
        (4990.0, 18000.0, "4 900 to 18 000 USD"),  # by thousands the low end would lose a fifth of itself
        (1499.0, 36000.0, "1 400 to 36 000 USD"),
        (783.0, 1411.0, "700 to 1 500 USD"),
        (700.1 + 82.9, 1400.0 + 1e-10, "700 to 1 400 USD"),  # sums of floats are no reason to round up
        (9990.0, 10010.0, "9 990 to 10 010 USD"),  # nearly all of it quoted: a range of 20 is known to tens
        (0.0, 50.0, "0 to 50 USD"),
        (0.2, 0.3, "0.20 to 0.30 USD"),
        (1234.0, 1234.0, "1 234 USD"),  # quoted: in full
    ],
)
def test_a_price_has_no_digits_that_nobody_knows(low, high, text):
    assert units.format_price(low, high, "USD") == text


@given(st.floats(0.1, 1e6), st.floats(1.0, 1e4))
def test_no_end_of_a_price_moves_by_more_than_an_eighth(low, ratio):
    shown = [float(end.replace(" ", "")) for end in units.format_price(low, low * ratio).split(" to ")]
    assert shown[0] == pytest.approx(low, rel=0.125, abs=0.011)  # a cent
    assert shown[-1] == pytest.approx(low * ratio, rel=0.125, abs=0.011)


@given(st.floats(100.0, 1e6), st.floats(1.02, 1e4))
def test_no_end_of_a_price_is_understated(low, ratio):
    shown = [float(end.replace(" ", "")) for end in units.format_price(low, low * ratio).split(" to ")]
    assert shown[0] <= low * (1 + 1e-6) and shown[-1] >= low * ratio * (1 - 1e-6)


def test_the_middle_of_a_price_has_the_digits_of_its_range():
    assert units.format_within(9836.0, 5498.0, 19459.0, "USD") == "10 000 USD"


def test_an_area_in_an_hour_is_not_told_in_hours():
    suffix = next(suffix for suffix in units.UNIT_SUFFIXES if "area_m2_h".endswith(suffix))
    assert units.format_quantity(3240.0, suffix, 4) == "3 240 m²/h"


@pytest.mark.parametrize(
    ("name", "unit"),
    [  # as a data sheet prints them
        ("aberration_pitch_um", "µm"), ("dark_current_e_s", "e⁻/s"), ("flash_efficacy_lm_s_per_j", "lm s/J"),
        ("colour_temperature_k", "K"), ("gain_dn_per_e", "DN/e⁻"), ("transmission_frac", ""), ("qe_scale", ""),
        ("f_number_min", ""),
    ],
)  # fmt: skip
def test_the_unit_in_a_name_is_told_as_it_is_printed(name, unit):
    assert units.unit_told(name) == unit

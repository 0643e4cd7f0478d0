"""Numbers and sentences for people."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from uwopt.report.text import formats, tables, vocabulary, words
from uwopt.report.text.buying import bought_name
from uwopt.results.design import BillRow, Cost, Design, LampPlace, Note, UsedPart


def test_what_is_to_be_made_is_named_alike_in_the_bill_and_in_sentences() -> None:
    part = UsedPart("generic-dome", "generic acrylic hemisphere", True)
    row = BillRow(
        "port", "generic-dome", "generic", "acrylic hemisphere", 1, 0, None, None, None, "USD", "to be made", "", True,
        "", "",
    )  # fmt: skip
    assert words.part_name(part) == bought_name(row) == "acrylic hemisphere (to be made)"


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("exposure_ms", 12.345, "12.345 ms"),
        ("exposure_ms", 0.043, "43 µs"),
        ("f_number", 2.8, "2.8"),
        ("frame_rate_hz", 20.0, "20 Hz"),
        ("frame_rate_hz", 0.000277778, "0.000277778 Hz, once every 60 min"),  # a number to type in, and what it means
        ("flux_lm", 30000.0, "30 000 lm"),
        ("dim_frac", 1.0, "100 %"),
        ("gain_db", 0.0, "0 dB"),
        ("pulse_ms", None, "–"),
    ],
)
def test_settings_keep_the_digits_that_are_set(name: str, value: float | None, text: str) -> None:
    assert formats.setting_text(name, value) == text


def test_what_is_left_of_a_rate_is_no_interval() -> None:
    assert formats.change(0.05, "Hz", 1.0) == "+0.0500 Hz"


@pytest.mark.parametrize(
    ("amount", "text"),
    [(4210.4, "4 210 USD"), (0.0, "0 USD"), (97.5, "97.5 USD"), (9.5, "9.50 USD"), (None, "unknown USD")],
)
def test_money_is_in_whole_units(amount: float | None, text: str) -> None:
    assert formats.money(amount, "USD") == ("unknown" if amount is None else text)


@pytest.mark.parametrize(("note", "text"), [
    (Note("practice_yields", "reserve.swath, requirements.snr_at_less_db", "nothing meets all of good practice"),
     "Good practice: nothing meets all of good practice"),
    (Note("measure_the_camera", "hardware.housing", "measure camera and lens"), "Housing: measure camera and lens"),
    (Note("lamp_in_view", "vehicle.light_baseline_m", "lamp 1 is seen"), "Distance from port to lamps: lamp 1 is seen"),
    (Note("lens", "lens", "lens rated for larger pixels"), "Lens rated for larger pixels"),
    (Note("time", "", "not worked out: whether another visibility_m would do; whether it could be met without min_snr"),
     "Not worked out: whether another visibility would do; whether it could be met without signal to noise"),
    (Note("colour_left_open", "requirements.colour", "requirements.max_blur_px: 2 asks for it"),
     "Colour: requirements.max_blur_px: 2 asks for it"),  # a key to write
])  # fmt: skip
def test_a_warning_is_about_what_people_speak_of_not_a_key(note: Note, text: str) -> None:
    assert tables.warning_text(note) == text


def test_difference_that_is_rounding_only_is_zero() -> None:
    assert formats.change(1e-13, "W", 40.0) == "0 W"
    assert formats.change(0.25, "W", 40.0) == "+0.250 W"


def with_cost(design: Design, value: float, currency: str, bom: list[BillRow]) -> Design:
    """A design at this cost, nothing of it estimated."""
    cost = Cost(value, value, value, currency, 0.0, 0.0, 0.0)
    return replace(design, totals=replace(design.totals, cost=cost), bom=bom)


def test_cost_without_estimates_says_so(make_design: Callable[..., Design]) -> None:
    design = with_cost(make_design(), 100.0, "EUR", [])
    assert words.cost_sentence(design) == "cost 100 EUR, nothing of it estimated"


def test_unknown_prices_are_not_passed_over(make_design: Callable[..., Design]) -> None:
    row = make_design().bom[0]
    bom = [replace(row, count=3, owned=1, unit_price=None), replace(row, count=1, owned=0, unit_price=5.0)]
    assert words.n_unpriced(bom) == 2
    design = with_cost(make_design(), 5.0, "USD", bom)
    assert "without 2 parts of unknown price" in words.cost_sentence(design)


@pytest.mark.parametrize(
    ("value", "text"),
    [(2_507_416.0, "2.51 Mbit/m²"), (9_400.0, "9.40 kbit/m²"), (12.0, "12.0 bit/m²"), (None, "–")],
)
def test_information_is_read_with_a_prefix(value: float | None, text: str) -> None:
    assert formats.quantity(value, "bit/m2") == text
    assert formats.quantity(2e6, "lm") == "2 000 000 lm"


@pytest.mark.parametrize(("lengths", "texts"), [
    ((0.000774,), ("0.774 mm",)), ((-0.0131,), ("-13.1 mm",)), ((0.0999,), ("99.9 mm",)), ((0.1,), ("0.100 m",)),
    ((0.0,), ("0 m",)), ((None,), ("–",)), ((math.inf,), ("infinite m",)),
    ((0.0131, 0.01), ("13.1 mm", "10.0 mm")), ((0.0131, None, 2.0), ("0.0131 m", "–", "2.00 m")),
])  # fmt: skip
def test_short_lengths_are_read_in_mm_all_that_stand_together_in_one_unit(
    lengths: tuple[float | None, ...], texts: tuple[str, ...]
) -> None:
    assert formats.quantities_apart(*lengths, unit="_m") == texts
    if len(lengths) == 1:
        assert formats.quantity(lengths[0], "m") == texts[0]


def test_small_shares_are_not_printed_as_powers_of_ten() -> None:
    assert formats.share(9.7e-9) == "below 0.001 %"
    assert formats.share(0.1) == "10.0 %"


def test_rules_of_the_search_and_of_the_choice_have_words() -> None:
    from uwopt.catalog.choose import RULES as CHOICE_RULES
    from uwopt.solvers.exact.account import RULES as SEARCH_RULES

    assert not {*CHOICE_RULES, *SEARCH_RULES} - set(vocabulary.RULES)


def test_kind_of_part_stays_before_its_rule() -> None:
    assert words.rule_name("port: generic") == "port: parts to be made, real ones are left"
    assert words.rule_name("housing: port") == "port does not go on the housing"


def test_margin_that_is_rounding_only_is_zero(make_margin: Callable[..., Any]) -> None:
    assert formats.margin_text(make_margin("overlap", 0.6 + 1e-16, 0.6, ">=", "")) == "0"


def test_a_slow_rate_stands_in_hz_against_its_limit(make_margin: Callable[..., Any]) -> None:
    margin = make_margin("frame_rate", 1.0 / 120.0, 494.0, "<=", "Hz")  # once every 120 s would take the table's width
    assert formats.margin_ends(margin) == ("0.008333 Hz", "494.0 Hz")
    assert formats.margin_ends(make_margin("frame_rate", None, 494.0, "<=", "Hz"))[0] == "–"


def test_a_price_of_which_a_cheap_part_is_quoted_is_not_told_as_wholly_unquoted() -> None:
    hardly = Cost(16000.0, 9000.0, 37000.0, "USD", 15958.0, 8958.0, 36958.0)  # a dome of 42 USD is quoted
    assert words.quoted_share(hardly) == "hardly any of it quoted"
    assert words.quoted_share(Cost(9.0, 8.0, 10.0, "USD", 9.0, 8.0, 10.0)) == "none of it quoted"


def test_a_cost_in_a_margin_has_the_digits_that_its_range_leaves(make_margin: Callable[..., Any]) -> None:
    cost = Cost(13233.0, 8470.0, 27244.0, "USD", 13233.0, 8470.0, 27244.0)
    margin = make_margin("cost", 27244.0, 30000.0, "<=", "USD")
    assert formats.margin_ends(margin, cost) == ("28 000 USD", "30 000 USD")  # as 8 400 to 28 000 is told
    assert formats.margin_text(margin, cost) == "2 000 USD"  # 30 000 less 28 000, as both are told
    tight = make_margin("cost", 27244.0, 27500.0, "<=", "USD")
    assert formats.margin_ends(tight, cost)[0] == "27 300 USD"  # 28 000 would look missed
    likeliest = make_margin("cost", 13233.0, 30000.0, "<=", "USD")
    assert formats.margin_ends(likeliest, cost)[0] == "13 000 USD"  # the middle of a range is no end of it
    missed = make_margin("cost", 27244.0, 27000.0, "<=", "USD")
    assert formats.margin_ends(missed, cost) == ("27 200 USD", "27 000 USD")  # else it would look met
    assert formats.margin_text(missed, cost) == "-200 USD"
    near = make_margin("cost", 27244.0, 27240.0, "<=", "USD")
    assert formats.margin_ends(near, cost)[0] == "27 244 USD"  # 27 000 is below the limit that it misses
    assert formats.margin_text(near, cost) == "-4.00 USD"


def test_a_proven_cost_has_the_digits_that_its_range_leaves() -> None:
    cost = Cost(13233.0, 8470.0, 27244.0, "USD", 13233.0, 8470.0, 27244.0)
    best = SimpleNamespace(totals=SimpleNamespace(cost=cost))
    result: Any = SimpleNamespace(objective=SimpleNamespace(name="cost", unit="USD"), best=best)
    assert words.bound_text(result, 13233.0, 0.0) == "13 000 USD"
    assert words.bound_text(result, 13233.0, 3.0) == "13 233.0 USD"  # with a gap, which it would hide


def test_lights_are_placed_in_words() -> None:
    mounts = [LampPlace(0.0, y_m, 0.0, 0.0, 0.0) for y_m in (0.8, -0.8)]
    assert words.mounts_text(mounts) == "at +0.8 m, -0.8 m across track, aimed straight down"


def test_lamps_that_share_a_place_are_counted_there() -> None:
    mounts = [LampPlace(0.0, y_m, 0.0, 0.0, 0.0) for y_m in (1.2, -1.2, 1.2, -1.2)]
    assert words.mounts_text(mounts) == "2 at +1.2 m, 2 at -1.2 m across track, aimed straight down"


@pytest.mark.parametrize(("tilt_deg", "said"), [(12.5, "tilted 12.5 deg outward"), (-45.0, "tilted 45 deg inward")])
def test_a_tilt_says_its_way(tilt_deg: float, said: str) -> None:
    mounts = [LampPlace(0.0, y_m, 0.0, 0.0, tilt_deg) for y_m in (0.2, -0.2)]
    assert words.mounts_text(mounts) == f"at +0.2 m, -0.2 m across track, {said}"


def test_plain_signs_replace_what_ascii_lacks() -> None:
    assert formats.in_encoding("3 µm – 5°", "ascii") == "3 um - 5 deg"
    assert formats.in_encoding("3 µm", "utf-8") == "3 µm"


def test_run_time_lists_steps_but_not_their_parts() -> None:
    text = words.run_time_sentence({"search": 0.3, "search_bounds": 0.1, "evaluation": 0.1, "total": 0.4})
    assert text == "0.400 s (search 0.30 s, evaluation 0.10 s)"


def test_stages_that_add_up_to_more_than_the_whole_say_why() -> None:
    text = words.run_time_sentence({"ranges": 5.0, "robustness": 6.0, "total": 8.0})
    assert text == "8.00 s (ranges 5.0 s, robustness 6.0 s; some of these ran side by side, so they add up to more)"


def test_lamps_in_rows_are_told_by_their_sides_and_steps() -> None:
    places = [(-0.1, 0.5), (-0.05, -0.5), (0.0, 0.5), (0.05, -0.5), (0.1, 0.5)]
    rows = [words.LampPlace(x, y, 0.0, 0.0, 10.0) for x, y in places]
    told = "3 at +0.5 m, 2 at -0.5 m across track, each side in a row, 0.1 m apart along track, tilted 10 deg outward"
    assert words.mounts_text(rows) == told
    moved = [*rows[:-1], words.LampPlace(0.2, 0.5, 0.0, 0.0, 10.0)]
    assert words.mounts_text(moved).startswith("at x -0.1 m, y 0.5 m")


@pytest.mark.parametrize(("warmer_k", "told"), [
    ([3.0, 7.42], ", its air 3.0 to 7.4 °C warmer than the water"),
    ([0.5, 1.2], ", its air 0.50 to 1.2 °C warmer than the water"),
    ([0.012, 0.029], ""),  # of a camera that is off for all but 18 s in two hours
    (None, ""),
])  # fmt: skip
def test_warmth_of_a_housing_is_told_where_it_is_a_degree(warmer_k: Any, told: str) -> None:
    assert words.warmth_clause(SimpleNamespace(housing_warmer_k=warmer_k)) == told  # type: ignore[arg-type]

"""MakerAnswers of makers, cell by cell: units, words, days, what is missing, what contradicts."""

from __future__ import annotations

import pytest

from uwopt.catalog.offers import MakerAnswers, Offer, offers_of

TODAY = "2026-11-23"
LAMP = "arctic-rays-dragonfish-mini-strobe-65deg"  # 30 000 lm and 350 g on its sheet; its power is not known
MAKER = {"manufacturer": "Arctic Rays", "model": "Dragonfish", "named_part": "yes"}
QUOTE = {"price": "2500", "currency": "usd", "price_date": "2026-11-20"}
OWN = {"manufacturer": "Acme", "model": "Bolt 40", "named_part": "no", "kind": "pulsed_led", "flux_lm": "45000"}


def offer(texts: dict[str, str], part: str = "light", candidate: str = LAMP) -> Offer:
    (found,) = offers_of([MakerAnswers("answers, maker 1", part, candidate, texts)], TODAY)
    return found


@pytest.mark.parametrize(
    ("key", "text", "cell"),
    [
        ("flux_lm", "27.4 klm", "27400"), ("mass_g", "0.35 kg", "350"), ("max_pulse_us", "4 ms", "4000"),
        ("max_pulse_us", "4000", "4000"), ("depth_rating_m", "300 m", "300"), ("min_pulse_us", "50 µs", "50"),
    ],
)  # fmt: skip
def test_numbers_with_units_are_read_in_the_column_s(key: str, text: str, cell: str) -> None:
    found = offer(MAKER | {key: text})
    assert float(found.cells[key]) == pytest.approx(float(cell))
    assert found.faults == ()


@pytest.mark.parametrize(
    ("key", "text", "fault"),
    [
        ("flux_lm", "4.500,00", "'4.500,00' is no number; write it without commas, such as 4500.00"),
        ("flux_lm", "45 m", "'45 m' is in another unit; it is asked in lm"),
        ("flux_lm", "-5", "must be a number above 0"), ("flux_lm", "bright", "'bright' is no number"),
        ("kind", "laser", "is not one of continuous, pulsed_led, flash"), ("max_pulse_us", "4e15", "check its unit"),
        ("price_date", "soon", "is no day"), ("colour", "red", "no fact of a light"),
        ("note", '=HYPERLINK("x")', "begins like a formula"), ("note", "x" * 301, "longer than 300"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_told_and_left_out(key: str, text: str, fault: str) -> None:
    found = offer(MAKER | {key: text})
    assert fault in " ".join(found.faults)
    assert key not in found.cells


def test_named_part_keeps_its_name_and_takes_what_is_new() -> None:
    found = offer(MAKER | QUOTE | {"power_w": "520", "valid_until": "2027-01-31", "lead_time_weeks": "8"})
    assert (found.part_id, found.named, found.usable) == (LAMP, True, True)
    assert {"price": "2500", "currency": "USD", "power_w": "520"}.items() <= found.cells.items()
    assert "model" not in found.cells
    assert (found.valid_until, found.lead_time_weeks) == ("2027-01-31", "8")


def test_answers_that_the_data_sheet_says_otherwise_are_told() -> None:
    assert offer(MAKER | {"flux_lm": "30300"}).contradicts == ()  # 1 %
    (told,) = offer(MAKER | {"flux_lm": "25000"}).contradicts
    assert told == "flux_lm is 25000 in the answer, 30000 in the data sheet"


def test_what_is_asked_and_not_answered_is_missing() -> None:
    assert offer(MAKER | {"flux_lm": "30000", "power_w": "", "mass_g": " "}).missing == ("power_w", "mass_g")


@pytest.mark.parametrize(
    ("without", "changes", "fault"),
    [
        ("currency", {}, "price: has no currency, so it does not count"),
        ("price_date", {}, "price: has no day, so it does not count"),
        ("", {"valid_until": "2026-11-01"}, "price: held until 2026-11-01, so it does not count"),
    ],
)
def test_a_price_counts_with_currency_day_and_while_it_holds(without: str, changes: dict[str, str], fault: str) -> None:
    texts = {key: text for key, text in (MAKER | QUOTE | changes).items() if key != without}
    found = offer(texts)
    assert found.faults == (fault,)
    assert "price" not in found.cells


def test_a_part_of_its_own_takes_words_but_no_numbers_from_the_named_one() -> None:
    found = offer(OWN | QUOTE)
    assert (found.part_id, found.named) == ("acme-bolt-40", False)
    assert {"trigger": "electrical", "supply": "external", "availability": "current"}.items() <= found.cells.items()
    assert not {"max_rate_hz", "mass_g", "depth_rating_m", "note"} & found.cells.keys()


def test_a_class_to_be_made_becomes_the_maker_s_part_even_where_he_says_it_is_the_named_one() -> None:
    found = offer(OWN | {"named_part": "yes"}, candidate="generic-pulsed-flood-30000lm")
    assert (found.part_id, found.named) == ("acme-bolt-40", False)
    assert found.cells["purpose"] == "vehicle lamp"  # a class has none


def test_a_part_without_a_name_cannot_be_used() -> None:
    assert not offer({"flux_lm": "45000", "kind": "pulsed_led"}).usable


def test_columns_that_nobody_filled_in_are_no_offers() -> None:
    assert offers_of([MakerAnswers("a", "light", LAMP, {"flux_lm": "", "price": " "})], TODAY) == []


def test_unknown_kind_is_told() -> None:
    assert "no kind of part" in offer(MAKER, part="rocket").faults[0]

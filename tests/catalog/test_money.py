"""Currencies and costs."""

import pytest

from uwopt.catalog.money import default_rates, to_currency
from uwopt.catalog.tables import built_in_rows
from uwopt.errors import CatalogError


def test_conversion_goes_through_dollars():
    # 100 EUR at 1.2 USD and 0.006 USD per JPY: 120 USD = 20 000 JPY
    rates = {"EUR": 1.2, "JPY": 0.006}
    assert to_currency(100.0, "EUR", "JPY", rates) == pytest.approx(20000.0)
    assert to_currency(20000.0, "jpy", "eur", rates) == pytest.approx(100.0)


def test_same_currency_needs_no_rate():
    assert to_currency(5.0, "XYZ", "xyz") == 5.0


def test_unknown_currency_names_the_known_and_the_way_out():
    with pytest.raises(CatalogError, match=r"'XYZ'.*EUR.*limits\.rates"):
        to_currency(5.0, "XYZ", "USD")


def test_default_rates_are_dated():
    assert all(row["date"] and row["source"] for row in built_in_rows("exchange_rates.csv"))
    assert all(usd_per_unit > 0 for usd_per_unit in default_rates().values())

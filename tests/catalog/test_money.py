"""Currencies and costs."""

import pytest

from uwopt.catalog.money import cost_of, default_rates, price_in, to_currency
from uwopt.catalog.parts.lens import Lens
from uwopt.catalog.parts.quantity import Quantity
from uwopt.errors import CatalogError

LENS = Lens(id="lens", price=Quantity(200.0, 150.0, 300.0), currency="EUR")


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
    assert all(rate.date and rate.usd_per_unit > 0 for rate in default_rates().values())


def test_price_keeps_its_range_in_another_currency():
    price = price_in(LENS, "USD", {"EUR": 1.1})
    assert (price.low, price.value, price.high) == pytest.approx((165.0, 220.0, 330.0))


def test_owned_pieces_are_not_paid():
    cost = cost_of(LENS, 3, owned=2, currency="EUR")
    assert cost is not None and cost.value == 200.0
    assert cost_of(LENS, 2, owned=2).value == 0.0
    assert cost_of(Lens(id="free"), 1) is None

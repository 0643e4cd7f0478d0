"""Prices in one currency, and what owned parts save.

Default exchange rates are dated data; a mission may bring its own. A result names the rates it used.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from uwopt.catalog.tables import built_in_rows
from uwopt.errors import CatalogError


@dataclass(frozen=True, slots=True)
class Rate:
    """What one unit of a currency was worth in US dollars, and when."""

    currency: str
    usd_per_unit: float
    date: str
    source: str


@cache
def default_rates() -> dict[str, Rate]:
    """The dated rates that ship with uwopt, by currency."""
    return {
        row["currency"]: Rate(row["currency"], float(row["usd_per_unit"]), row["date"], row["source"])
        for row in built_in_rows("exchange_rates.csv")
    }


def known_rates(rates: Mapping[str, float] | None = None) -> dict[str, float]:
    """USD per unit by currency: the defaults, overridden by the user's own."""
    own = {currency.upper(): value for currency, value in (rates or {}).items()}
    return {"USD": 1.0} | {name: rate.usd_per_unit for name, rate in default_rates().items()} | own


def to_currency(
    amount: float, from_currency: str, into_currency: str, rates: Mapping[str, float] | None = None
) -> float:
    """An amount of money in another currency; `rates` are USD per unit and override the defaults."""
    if from_currency.upper() == into_currency.upper():
        return amount
    usd_per_unit = known_rates(rates)
    values = []
    for currency in (from_currency, into_currency):
        value = usd_per_unit.get(currency.upper())
        if value is None or not value > 0:
            raise CatalogError(
                f"no exchange rate for {currency!r}; known are {', '.join(sorted(usd_per_unit))}. "
                "Add it to limits.rates as USD per unit."
            )
        values.append(value)
    return amount * values[0] / values[1]

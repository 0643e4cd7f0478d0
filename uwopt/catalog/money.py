"""Prices in one currency, and what owned parts save.

Default exchange rates are dated data; a mission may bring its own. A result names the rates it used.
"""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from functools import cache

from uwopt.catalog.tables import built_in_rows
from uwopt.errors import CatalogError

#: Money that states use, as ISO 4217 (list one, 2026) writes it.
ISO_4217 = (
    "AED AFN ALL AMD ANG AOA ARS AUD AWG AZN BAM BBD BDT BGN BHD BIF BMD BND BOB BRL BSD BTN BWP BYN BZD CAD "
    "CDF CHF CLP CNY COP CRC CUP CVE CZK DJF DKK DOP DZD EGP ERN ETB EUR FJD FKP GBP GEL GHS GIP GMD GNF GTQ "
    "GYD HKD HNL HTG HUF IDR ILS INR IQD IRR ISK JMD JOD JPY KES KGS KHR KMF KPW KRW KWD KYD KZT LAK LBP LKR "
    "LRD LSL LYD MAD MDL MGA MKD MMK MNT MOP MRU MUR MVR MWK MXN MYR MZN NAD NGN NIO NOK NPR NZD OMR PAB PEN "
    "PGK PHP PKR PLN PYG QAR RON RSD RUB RWF SAR SBD SCR SDG SEK SGD SHP SLE SOS SRD SSP STN SVC SYP SZL THB "
    "TJS TMT TND TOP TRY TTD TWD TZS UAH UGX USD UYU UZS VES VND VUV WST XAF XCD XCG XOF XPF YER ZAR ZMW ZWG"
)
CURRENCIES = frozenset(ISO_4217.split())


def currency_fault(text: str) -> str:
    """What is wrong with a currency that a file names; "" where nothing is. One without a rate may be given one."""
    code = text.upper()
    if len(code) != 3 or not code.isascii() or not code.isalpha():
        return f"currency = {text!r} is not three letters, such as USD"
    if code in CURRENCIES:
        return ""
    same = [known for known in sorted(CURRENCIES) if sorted(known) == sorted(code)]
    near = same or get_close_matches(code, default_rates(), n=1)
    mend = f"write {near[0]} if that is meant" if near else "write one of ISO 4217, such as USD"
    return f"currency = {text!r} is none; {mend}"


@cache
def default_rates() -> dict[str, float]:
    """The dated rates that ship with uwopt, USD per unit by currency."""
    return {row["currency"]: float(row["usd_per_unit"]) for row in built_in_rows("exchange_rates.csv")}


def known_rates(rates: Mapping[str, float] | None = None) -> dict[str, float]:
    """USD per unit by currency: the defaults, overridden by the user's own."""
    own = {currency.upper(): value for currency, value in (rates or {}).items()}
    return {"USD": 1.0} | default_rates() | own


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

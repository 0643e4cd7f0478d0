"""Numbers with their units, amounts of money, and text from files made fit to print."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from functools import partial

from uwopt.report.text.vocabulary import SETTINGS
from uwopt.results.design import BillRow, Cost, Margin
from uwopt.units import (
    SLOW_HZ,
    format_difference,
    format_interval,
    format_money,
    format_number,
    format_price,
    format_quantity,
    round_at_most,
    round_up,
    round_within,
    split_unit,
    symbol,
    texts_apart,
    without_zeros,
)

#: What stands for signs that a terminal without Unicode cannot show.
PLAIN_SIGNS = str.maketrans(
    {
        "–": "-", "—": "-", "−": "-", "µ": "u", "μ": "u", "°": " deg", "²": "2", "³": "3", "⁻": "-", "·": "*",
        "×": "x", "≤": "<=", "≥": ">=", "≈": "~", "±": "+/-", "…": "...", "‘": "'", "’": "'", "“": '"', "”": '"',
        "\u00a0": " ", "\u202f": " ",
    }
)  # fmt: skip
NO_BREAK = "\u00a0"
WITHIN_NUMBER = re.compile(r"(?<=\d) (?=\d{3}\b|[A-Z]{3}\b)")
#: Information per area of floor, as objectives and figures name it, and the prefixes that it is read with.
BITS = ("bit/m2", "bit/m²", "bit_per_m2", "_bit_per_m2")
PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"))
SHORT_M = 0.1  # lengths below it are read in mm


def in_encoding(text: str, encoding: str) -> str:
    """The text with only signs that an encoding knows: `µm` is `um` in ASCII, a foreign letter its base."""
    try:
        text.encode(encoding)
    except (UnicodeEncodeError, LookupError):
        plain = unicodedata.normalize("NFKD", text.translate(PLAIN_SIGNS))
        return (
            "".join(c for c in plain if not unicodedata.combining(c))
            .encode("ascii", "replace")
            .decode("ascii")
        )
    return text


def printable(text: str) -> str:
    """Text from files without control signs, which could steer a terminal; line ends stay."""
    if text.isprintable():
        return text
    return "".join(c if c in "\n\t" or not unicodedata.category(c).startswith("C") else "?" for c in text)


def one_line(text: object, longest: int = 400) -> str:
    """Text from files on one line, shortened."""
    line = " ".join(printable(str(text)).split())
    return line if len(line) <= longest else line[: longest - 3] + "..."


def tied(text: str, blank: str = NO_BREAK) -> str:
    """Text in which no line ends within a number, at the blank between thousands, or before its currency."""
    return WITHIN_NUMBER.sub(blank, text)


def quantity(value: float | None, unit: str = "", digits: int = 3) -> str:
    """A number with its unit, or a dash; bits and lengths get the prefix that keeps the number short."""
    return in_step(prefixed(unit, value or 0.0), value, digits)


def span(values: Iterable[float | None], unit: str, digits: int = 3) -> str:
    """One number, or from the least to the most; "" where none is known."""
    known = [value for value in values if value is not None]
    if not known:
        return ""
    low, high = (quantity(end, unit, digits) for end in (min(known), max(known)))
    return low if low == high else f"{low} to {high}"


def in_step(step: tuple[float, str], value: float | None, digits: int) -> str:
    """A number in a unit of `prefixed`, or a dash."""
    per, unit = step
    return format_quantity(None if value is None else value / per, unit, digits)


def quantities_apart(*values: float | None, unit: str, digits: int = 3) -> tuple[str, ...]:
    """Quantities that stand side by side, in one unit and with as many digits as tell them apart."""
    step = prefixed(unit, max((abs(value) for value in values if value is not None), default=0.0))
    return texts_apart(*values, text=partial(in_step, step), digits=digits)


def prefixed(unit: str, largest: float) -> tuple[float, str]:
    """What to divide by and the unit then: 2.5e6 bit/m2 are read as 2.5 Mbit/m², 0.013 m as 13 mm; others stay."""
    if symbol(unit) == "m" and 0.0 < abs(largest) < SHORT_M:
        return 1e-3, "mm"
    if unit not in BITS:
        return 1.0, unit
    per, prefix = next((step for step in PREFIXES if abs(largest) >= step[0]), (1.0, ""))
    return per, f"{prefix}bit/m²"


def change(value: float, unit: str, scale: float) -> str:
    """A difference with its sign; what is only rounding of numbers as large as `scale` is 0."""
    if abs(value) <= 1e-9 * abs(scale):
        return format_difference(0.0, unit)
    return ("+" if value > 0 else "") + format_difference(value, unit)


def margin_ends(margin: Margin, cost: Cost | None = None) -> tuple[str, str]:
    """What is reached of a requirement, a number with its unit or the word in its place; and its limit."""
    if margin.is_of_fit:
        return "yes" if margin.satisfied else "no", "yes"
    if (told := told_cost(margin, cost)) is not None:
        return money(told, margin.unit), money(margin.limit, margin.unit)
    if symbol(margin.unit) == "Hz":  # in Hz both, however slow: no interval stands against a rate
        value, limit = texts_apart(margin.value, margin.limit, text=_rate, digits=4)
    else:
        value, limit = quantities_apart(margin.value, margin.limit, unit=margin.unit, digits=4)
    return one_line(margin.word) if margin.value is None and margin.word else value, limit


def _rate(value_hz: float | None, digits: int) -> str:
    return quantity(None) if value_hz is None else format_difference(value_hz, "Hz", digits)


def told_cost(margin: Margin, cost: Cost | None) -> float | None:
    """A cost with no more digits than its range leaves it, unless it takes them to tell it from its limit.

    A high end within its limit is rounded up, as in the price.

    None of other requirements, and where all digits are needed.
    """
    if cost is None or margin.requirement != "cost" or margin.value is None or margin.limit is None:
        return None
    spent, most = margin.value, margin.limit
    if spent >= cost.high and spent <= most:  # as the price's high end is told: never less than it is
        known = [round_at_most(cost.low, spent)]
        known += [round_up(spent, digits) for digits in (3, 2, 1) if spent > 10.0 ** (digits + 1)]
    else:
        known = [round_within(spent, cost.low, cost.high)]
        known += [round(spent, -digits) for digits in (3, 2, 1) if spent > 10.0 ** (digits + 1)]
    return next((told for told in known if told != most and (told < most) == (spent < most)), None)


def margin_text(margin: Margin, cost: Cost | None = None) -> str:
    """What is left of a requirement, in its unit; of a cost what is left of the numbers that are told."""
    if margin.margin is None or margin.is_of_fit:
        return quantity(None)
    told = told_cost(margin, cost)
    if told is not None and margin.limit is not None:
        return money(margin.limit - told, margin.unit)
    scale = max(abs(margin.limit or 0.0), abs(margin.value or 0.0))
    small = abs(margin.margin) <= (1e-6 if margin.satisfied else 1e-12) * scale  # 1e-6: what counts as met
    return format_difference(0.0 if small else margin.margin, margin.unit)


def reserve_text(margin: Margin) -> str:
    """What a limit is made of: `3 dB reserve on 30.00 dB asked`."""
    joint = "of" if margin.sense == "<=" else "on"
    return f"{kept_text(margin)} reserve {joint} {quantity(margin.asked, margin.unit, 4)} asked"


def kept_text(margin: Margin) -> str:
    """How much of a limit is reserve."""
    return f"{digits_of(round(margin.reserve, 9))} {symbol(margin.unit)}".strip()


def setting_text(name: str, value: float | None) -> str:
    """A setting as it is typed in: every digit that was rounded to, no more; a dash where there is none."""
    unit = SETTINGS[name][1] if name in SETTINGS else split_unit(name)[1]
    if value is None:
        return quantity(None)
    if name == "dim_frac":
        return f"{digits_of(100.0 * value)} %"
    if unit == "ms" and 0 < abs(value) < 0.1:
        return f"{digits_of(value * 1e3)} {symbol('us')}"
    typed = f"{digits_of(value)} {symbol(unit)}".strip()
    return f"{typed}, {format_interval(1.0 / value)}" if unit == "Hz" and 0 < value < SLOW_HZ else typed


def digits_of(value: float) -> str:
    """A number with up to six significant digits, without zeros at its end."""
    return without_zeros(format_number(value, 6))


def share(value: float) -> str:
    """A share as per cent; what is all but nothing is told as such."""
    if 0 < abs(value) < 1e-5:
        return "below 0.001 %"
    return f"{format_number(100.0 * value)} %"


def signed_share(value: float) -> str:
    """A relative difference as per cent with its sign."""
    return ("+" if value >= 1e-5 else "") + share(value)


def money(value: float | None, currency: str = "") -> str:
    """An amount of money in whole units, below a hundred to three digits."""
    return format_money(value, one_line(currency, 8))


def price_text(low: float, high: float, currency: str) -> str:
    """`5 000 to 19 000 USD` where nobody quotes it; one amount, in full, where somebody does."""
    return format_price(low, high, one_line(currency, 8))


def cost_text(cost: Cost) -> str:
    """What a system costs, as a range where prices are estimated."""
    return price_text(cost.low, cost.high, cost.currency)


def known_price(row: BillRow) -> str:
    """How a price is known: `list, 2026-05-01`, or that there is no quote."""
    if row.unit_price is None:
        return "unknown"
    if row.estimated:
        return "no quote" if row.price_status == "estimated" else f"{one_line(row.price_status, 20)}, no quote"
    return one_line(", ".join(word for word in (row.price_status, row.price_date) if word), 60)


def price_ends(row: BillRow) -> tuple[float, float] | None:
    """Both ends of the price of one piece; None where nobody knows it."""
    if row.unit_price is None:
        return None
    low, high = row.unit_price_low, row.unit_price_high
    return (row.unit_price,) * 2 if low is None or high is None else (low, high)


def due_text(row: BillRow) -> str:
    """What the pieces that are not owned cost together."""
    if not row.to_buy:
        return "owned"
    ends = price_ends(row)
    return "price unknown" if ends is None else price_text(ends[0] * row.to_buy, ends[1] * row.to_buy, row.currency)

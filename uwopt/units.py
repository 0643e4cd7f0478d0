"""Units: the suffixes a name may carry, conversions at the door, and numbers for people.

Inside the model everything is in m, s, W, rad and electrons; files use the field's units. Each
conversion happens once, where a file becomes numbers.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, TypeGuard

from uwopt.tolerances import SATISFIED_REL

#: Every unit that a public name may end in, longest first where one is the tail of another.
UNIT_SUFFIXES: tuple[str, ...] = (
    "_w_m2_sr_nm", "_w_m2_nm", "_w_m2", "_cyc_per_px", "_bit_per_m2", "_lp_per_mm", "_lm_s_per_j",
    "_dn_per_e", "_deg_s", "_e_s", "_m_s", "_mb_s", "_per_m", "_per_s",
    "_m2_h", "_m", "_mm", "_um", "_nm", "_m2", "_s", "_ms", "_us", "_hz", "_rad", "_deg", "_w", "_j", "_k",
    "_c", "_psu", "_ntu", "_lm", "_lx", "_lux", "_kg", "_g", "_e", "_dn", "_px", "_db", "_in", "_frac",
    "_pct", "_h", "_wh", "_gb",
)  # fmt: skip

#: How a unit is printed, by its suffix without the underscore.
SYMBOLS: Mapping[str, str] = MappingProxyType(
    {
        "um": "µm", "us": "µs", "hz": "Hz", "deg": "°", "w": "W", "j": "J", "k": "K", "c": "°C", "psu": "PSU",
        "ntu": "NTU", "lux": "lx", "e": "e⁻", "dn": "DN", "db": "dB", "in": "in", "pct": "%", "frac": "", "m2": "m²",
        "m_s": "m/s", "mb_s": "MB/s", "deg_s": "°/s", "e_s": "e⁻/s", "per_m": "1/m", "per_s": "1/s",
        "w_m2": "W/m²", "w_m2_nm": "W/(m² nm)", "w_m2_sr_nm": "W/(m² sr nm)", "cyc_per_px": "cycles/px",
        "wh": "Wh", "gb": "GB", "m2_h": "m²/h",
        "bit_per_m2": "bit/m²", "lp_per_mm": "lp/mm", "lm_s_per_j": "lm s/J", "dn_per_e": "DN/e⁻",
    }
)  # fmt: skip

_DEGREES = math.pi / 180.0
_MINUTE_S = 60.0
SLOW_HZ = 0.1  # a rate below this is told by its interval
MOST_DIGITS = 9  # of numbers that fewer do not tell apart
_FOOT_M = 0.3048  # international foot, exact
S_PER_H = 3600.0
INTERVALS = (("days", 24 * S_PER_H), ("h", S_PER_H), ("min", _MINUTE_S), ("s", 1.0))  # longest first
_KNOT_M_S = 1852.0 / S_PER_H  # international nautical mile per hour, exact

#: Units that people write, by dimension: factor to the dimension's SI unit. Wider than UNIT_SUFFIXES
#: on purpose: a hint must understand `altitude_ft` to say what `altitude_m` would be.
DIMENSIONS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "km": 1e3,
                   "ft": _FOOT_M, "inch": _FOOT_M / 12.0, "in": _FOOT_M / 12.0},
        "time": {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": _MINUTE_S, "h": S_PER_H},
        "angle": {"deg": _DEGREES, "rad": 1.0, "mrad": 1e-3},
        "angular rate": {"deg_s": _DEGREES, "rad_s": 1.0, "deg_per_s": _DEGREES},
        "speed": {"m_s": 1.0, "m_per_s": 1.0, "mps": 1.0, "ms": 1.0, "cm_s": 1e-2, "mm_s": 1e-3,
                  "km_h": 1 / 3.6, "kmh": 1 / 3.6, "kn": _KNOT_M_S, "kt": _KNOT_M_S, "knots": _KNOT_M_S},
        "power": {"w": 1.0, "mw": 1e-3, "kw": 1e3},
        "energy": {"j": 1.0, "mj": 1e-3, "kj": 1e3, "wh": S_PER_H, "kwh": 3.6e6},
        "storage": {"gb": 1.0, "mb": 1e-3, "tb": 1e3},
        "mass": {"kg": 1.0, "g": 1e-3, "lb": 0.45359237},
        "flux": {"lm": 1.0, "klm": 1e3},
        "illuminance": {"lux": 1.0, "lx": 1.0, "klux": 1e3},
        "rate": {"hz": 1.0, "khz": 1e3, "fps": 1.0},
        "data rate": {"mb_s": 1.0, "kb_s": 1e-3, "gb_s": 1e3, "mbps": 0.125, "mbit_s": 0.125},
        "pixels": {"px": 1.0, "pix": 1.0, "pixels": 1.0, "pixel": 1.0},
        "level": {"db": 1.0},
        "salinity": {"psu": 1.0, "ppt": 1.0},
        "turbidity": {"ntu": 1.0, "fnu": 1.0, "ftu": 1.0},
        "area rate": {"m2_h": 1.0, "km2_h": 1e6, "ha_h": 1e4},
        "attenuation": {"per_m": 1.0, "per_cm": 100.0, "per_km": 1e-3},
        "temperature": {"c": 1.0, "degc": 1.0, "celsius": 1.0},
    }
)  # fmt: skip
_WRITTEN = sorted({unit for units in DIMENSIONS.values() for unit in units}, key=len, reverse=True)  # the longest first


def db_to_ratio(level_db: Any) -> Any:
    """Amplitude ratio of levels in decibels: 10^(dB/20), as EMVA 1288 counts SNR and gain."""
    return 10.0 ** (level_db / 20.0)


def ratio_to_db(ratio: Any) -> Any:
    """Levels of amplitude ratios in decibels, 20 log10; a ratio of 0 is minus infinity, without a warning."""
    import numpy as np  # here, because a mission loads without it

    with np.errstate(divide="ignore"):
        return 20.0 * np.log10(ratio)


def split_unit(name: str) -> tuple[str, str]:
    """Stem and unit of a name: `altitude_mm` is (`altitude`, `mm`); the unit is "" where there is none.

    Knows the units people write, not only those of UNIT_SUFFIXES.
    """
    for unit in _WRITTEN:
        if name.endswith("_" + unit) and len(name) > len(unit) + 1:
            return name[: -len(unit) - 1], unit
    return name, ""


def unit_told(name: str) -> str:
    """How the unit in a public name is printed: of `aberration_pitch_um` µm, of `read_noise_e` e⁻; "" of none.

    Knows UNIT_SUFFIXES alone, of which the longest that fits is the unit: `e_s` of `dark_current_e_s`, not `s`.
    """
    return symbol(unit_suffix(name))


def unit_suffix(name: str) -> str:
    """The longest of UNIT_SUFFIXES with which a public name ends; "" of none."""
    return max((suffix for suffix in UNIT_SUFFIXES if name.endswith(suffix)), key=len, default="")


def is_number(value: Any) -> TypeGuard[float]:
    """Whether a value can be counted with; a flag is none."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def convert(value: float, from_unit: str, into_unit: str) -> float | None:
    """A number in another unit of the same dimension; None when the two do not measure one thing."""
    for units in DIMENSIONS.values():
        if from_unit in units and into_unit in units:
            return value * units[from_unit] / units[into_unit]
    return None


def symbol(unit: str) -> str:
    """How a unit is printed: `m_s` is m/s, `um` is µm; an unknown one is printed as it is."""
    unit = unit.lstrip("_")
    return SYMBOLS.get(unit, unit)


def format_number(value: float, digits: int = 3) -> str:
    """A number with so many significant digits, but never rounded above its units: 20 000, 7 543, 0.00123."""
    if math.isnan(value):
        return "not a number"
    if math.isinf(value):
        return "infinite" if value > 0 else "-infinite"
    if value == 0:
        return "0"
    magnitude = math.floor(math.log10(abs(value)))
    decimals = max(0, digits - 1 - magnitude)
    rounded = round(value, decimals)
    if rounded != 0 and math.floor(math.log10(abs(rounded))) > magnitude:  # 9.996 became 10.00
        decimals = max(0, decimals - 1)
    if abs(value) >= 1e15 or magnitude < -5:
        return f"{value:.{digits - 1}e}"
    return f"{rounded:,.{decimals}f}".replace(",", " ")


def format_quantity(value: float | None, unit: str = "", digits: int = 3) -> str:
    """A number with its unit for reports; a dash where there is none.

    `unit` is a suffix of UNIT_SUFFIXES (with or without the underscore) or a currency. A rate below SLOW_HZ is told by
    its interval.
    """
    if value is None:
        return "–"
    if symbol(unit) == "Hz" and 0 < value < SLOW_HZ:
        return format_interval(1.0 / value, digits)
    return format_difference(value, unit, digits)


def format_difference(value: float, unit: str = "", digits: int = 3) -> str:
    """How far apart two quantities are, in their unit; of rates in Hz however small, for it is no interval."""
    sign = symbol(unit)
    gap = "" if sign in ("", "°", "%") else " "
    return f"{format_number(value, digits)}{gap}{sign}"


def format_interval(interval_s: float, digits: int = 3) -> str:
    """How often something slow happens: `once every 60 min`, in the largest unit of which it takes two or more."""
    unit, per = next((name, length) for name, length in INTERVALS if interval_s >= 2 * length or length == 1.0)
    return f"once every {without_zeros(format_number(interval_s / per, digits))} {unit}"


def without_zeros(number: str) -> str:
    """A formatted number without zeros at the end of its decimals."""
    return number.rstrip("0").rstrip(".") if "." in number and "e" not in number else number


def texts_apart(
    *values: float | None, text: Callable[[float | None, int], str], digits: int = 3
) -> tuple[str, ...]:
    """Numbers that stand side by side, by `text` of a number and its digits: as many digits as tell them apart.

    25.003 dB against 25.000 dB, not 25.0 dB against 25.0 dB. Numbers that agree as nearly as requirements are met
    (`tolerances.SATISFIED_REL`) are equal, and look it.
    """
    known = sorted({value for value in values if value is not None and math.isfinite(value)})
    differ = [b - a > SATISFIED_REL * max(abs(a), abs(b)) for a, b in itertools.pairwise(known)]
    for more in range(digits, MOST_DIGITS + 1):
        seen = {value: text(value, more) for value in known}
        if not any(apart and a == b for apart, (a, b) in zip(differ, itertools.pairwise(seen.values()), strict=True)):
            return tuple(seen.get(value) or text(value, more) for value in values)  # pyrefly: ignore[bad-argument-type]
    return tuple(text(value, MOST_DIGITS) for value in values)


# ---------------------------------------------------------------- money

ROUNDING_REL = 1e-6  # of the last digit told: no more is to round an amount up or down
CENTS = -2  # power of ten of the last digit that is ever told


def count_text(number: float | int) -> str:
    """A whole number with blanks at the thousands; beyond 10^15 rounded."""
    return f"{int(number):,}".replace(",", " ") if abs(number) < 1e15 else f"{float(number):.3e}"


def counted(number: int, noun: str) -> str:
    """`1 light`, `2 lights`."""
    return f"{count_text(number)} {noun}" + ("" if number == 1 else "s")


def listed(names: Iterable[str], word: str = "and") -> str:
    """`a`, `a and b`, `a, b and c`; or with another word."""
    given = list(names)
    return f" {word} ".join([", ".join(given[:-1]), given[-1]] if len(given) > 1 else given)


def format_money(value: float | None, currency: str = "") -> str:
    """An amount of money in whole units, below a hundred to three digits."""
    if value is None:
        return "unknown"
    number = format_number(round(value) if abs(value) >= 100 else round(value, 2), 3)
    return f"{number} {currency}".strip()


def format_price(low: float, high: float, currency: str = "") -> str:
    """A price without digits that nobody knows: `5 000 to 20 000 USD`; one amount, in full, where it is known.

    Its ends are rounded outward: what counts against a budget is never more than what is told.
    """
    if format_money(low) == format_money(high):
        return format_money(high, currency)
    exponent = _exponent_within(low, low, high)
    if exponent is None:
        return f"{format_money(low)} to {format_money(high)} {currency}".strip()
    if low - _down(low, exponent) > low / 8:
        exponent = max(exponent - 1, CENTS)
    return f"{_in_digits(_down(low, exponent), exponent)} to {format_at_most(low, high, currency)}"


def format_at_most(low: float, high: float, currency: str = "") -> str:
    """The high end of a price with the digits that its range leaves it, rounded up."""
    exponent = _exponent_within(high, low, high)
    if exponent is None:
        return format_money(high, currency)
    return f"{_in_digits(round_up(high, exponent), exponent)} {currency}".strip()


def round_at_most(low: float, high: float) -> float:
    """The high end that `format_at_most` tells; itself where there is no range."""
    exponent = _exponent_within(high, low, high)
    return high if exponent is None else round_up(high, exponent)


def round_up(value: float, exponent: int) -> float:
    """Rounded up at a power of ten, but for what sums of floats leave."""
    return -_down(-value, exponent)


def _down(value: float, exponent: int) -> float:
    """Rounded down at a power of ten, but for what sums of floats leave."""
    return math.floor(value / 10.0**exponent + ROUNDING_REL) * 10.0**exponent


def _in_digits(value: float, exponent: int) -> str:
    return f"{value:,.{max(0, -exponent)}f}".replace(",", " ")


def format_within(value: float, low: float, high: float, currency: str = "") -> str:
    """An amount between the ends of a range, with the digits that the range leaves it.

    That is two digits of the high end, more where the range is narrow, and never so few that the amount moves by more
    than an eighth.
    """
    exponent = _exponent_within(value, low, high)
    if exponent is None:
        return format_money(value, currency)
    return f"{_in_digits(round(value, -exponent), exponent)} {currency}".strip()


def round_within(value: float, low: float, high: float) -> float:
    """The amount that `format_within` tells; itself where there is no range."""
    exponent = _exponent_within(value, low, high)
    return value if exponent is None else round(value, -exponent)


def _exponent_within(value: float, low: float, high: float) -> int | None:
    """Power of ten of the last digit that a range leaves an amount; None where there is no range about it."""
    if not (0 <= low <= value <= high and 0 < high - low < math.inf):
        return None
    exponent = min(_magnitude(high) - 1, _magnitude(high - low), *([_magnitude(value / 4)] if value > 0 else []))
    return max(exponent, CENTS)


def _magnitude(value: float) -> int:
    return math.floor(math.log10(value))


def percent(share: float) -> str:
    """`97 %`; never all or nothing where some were lost or won: `99.9 %`."""
    share = round(share, 9)  # the interval of all is 1 but for rounding
    digits = 0 if 0.01 <= share <= 0.99 or share in (0.0, 1.0) else 1
    shown = min(max(100.0 * share, 0.1), 99.9) if 0.0 < share < 1.0 else 100.0 * share
    return f"{shown:.{digits}f} %"

"""What requirements cost, as sentences: a step more of each, and how far the system stays the best."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from uwopt.quantities import AT_LIKELIEST
from uwopt.report.text import formats, words
from uwopt.report.text.layout import Block, Line, block, sentence
from uwopt.results.basis import LessMoney, Price
from uwopt.results.design import Design
from uwopt.results.result import Result
from uwopt.units import counted, format_quantity, percent, without_zeros

NOTHING_CHANGES = 1e-6  # of the objective: less is rounding
NOTHING = "nothing"
MOST_TOLD = 4  # on the first page
FASTER = {"speed_m_s": "faster", "frame_interval_s": "shorter between images"}  # what asking for more of it is called


def price_blocks(result: Result) -> Iterator[Block]:
    """The block, if there are any."""
    if result.prices:
        yield block("What requirements cost", list(price_lines(result, result.prices)))


def short_price_sentence(result: Result) -> str:
    """`1 dB more signal to noise: +0.22 W; 0.05 m/s faster: +0.09 W.`; nothing where no step changes anything."""
    told = [one for one in result.prices if one.until is not None or change_words(result, one) != NOTHING]
    if not told:
        return ""
    said = "; ".join(short_price(result, price) for price in told[:MOST_TOLD])
    by = f"{AT_LIKELIEST.capitalize()}: " if result.confidence is not None else ""
    return f"{by}{said}."


FOUND_LATER = " It was found once the choice was made, and betters it: take it instead."


def less_money_block(result: Result) -> Iterator[Block]:
    """`With 1 light: 3 300 USD less (46 %) for 0.07 % more power, 2.785 W; limits.cost: 3896 asks for it.`"""
    if result.less_money is not None and result.best is not None:
        yield block("For less money", [sentence(less_money_text(result, result.less_money, result.best))])


def less_money_text(result: Result, cheap: LessMoney, best: Design) -> str:
    """The same as a sentence."""
    ours, lamps = best.hardware.named, cheap.light_count
    other = [
        f"{kind} {formats.one_line(part, 60)}" for kind, part in cheap.hardware.items()
        if kind not in ours or ours[kind].id != part
    ]  # fmt: skip
    other += [counted(lamps, "light")] if lamps != best.hardware.light_count else []
    less = cheap.price_of_best - cheap.price
    saved = f"{formats.money(float(f'{less:.2g}'), cheap.currency)} less ({100.0 * less / cheap.price_of_best:.0f} %)"
    more, value = cheap.value / cheap.value_of_best - 1.0, words.objective_text(result, cheap.value)
    how = f"{100.0 * abs(more):.2g} % {'more' if more >= 0.0 else 'less'}"
    said = f"With {words.listed(other)}: {saved} for {how} "
    said += f"{words.requirement_name(result.objective.name)}, {value} "
    if cheap.cost_limit is not None:
        said += f"by exact settings; limits.cost: {math.ceil(cheap.cost_limit)} asks for it, or better."
    else:
        said += f"by medians; it holds in {percent(cheap.held or 0.0)} of the scenarios of the choice."
        said += FOUND_LATER if more < 0.0 else ""
    even = best.as_set.least("uniformity")
    if not cheap.is_less_even(even):
        return said
    shares = f"{percent(cheap.uniformity or 0.0)} of the mean in the darkest place, not {percent(even or 0.0)}"
    return f"{said} Its light is less even: {shares}."


def short_price(result: Result, price: Price) -> str:
    """`0.05 m/s faster: +0.09 W; beyond 0.7 m/s another system`."""
    unit = price_unit(result, price)
    number, _, rest = formats.quantity(abs(price.step), unit).partition(" ")
    step = f"{without_zeros(number)} {rest}".strip()
    how = FASTER.get(price.name) or f"{'more' if price.step > 0 else 'less'} {words.requirement_name(price.name)}"
    said = f"{step} {how}: {change_words(result, price)}"
    if price.until is not None:
        said += f", beyond {formats.quantity(price.until, unit)} {'another system' if price.then else 'nothing fits'}"
    return said


def price_lines(result: Result, prices: Sequence[Price]) -> Iterator[Line]:
    """A sentence each."""
    for price in prices:
        yield sentence("- " + requirement_price_text(result, price))


def requirement_price_text(result: Result, price: Price) -> str:
    """`1 dB more signal to noise: +0.22 W; beyond 31.2 dB another camera, ...`."""
    name = "speed" if price.name == "speed_m_s" else words.requirement_name(price.name)
    unit = price_unit(result, price)
    word = "more" if price.step > 0 else "less"
    said = f"{format_quantity(abs(price.step), unit)} {word} {name} ({formats.one_line(price.name)}, "
    said += f"now {format_quantity(price.asked, unit)}): {change_words(result, price)}"
    if price.slope_casadi is not None and price.slope is not None:
        ours, theirs = (words.objective_text(result, value, 3) for value in (price.slope, price.slope_casadi))
        said += f"; at the limit {ours} per dB by difference, {theirs} by CasADi's multiplier"
    if price.free_until is not None:
        free = f"up to {format_quantity(price.free_until, unit)}"
        said += f", {free}" if said.endswith(f": {NOTHING}") else f"; {free} {NOTHING}"
    if price.without is not None:
        said += f"; {without_words(result, price)}"
    if price.until is not None:
        then = f"another system: {formats.one_line(price.then, 300)}" if price.then else "nothing fits"
        said += f"; beyond {format_quantity(price.until, unit)} {then}"
    return said


def without_words(result: Result, price: Price) -> str:
    """What would be best where it is not asked for."""
    assert price.without is not None
    now = result.objective.value
    if now is None or abs(price.without - now) <= NOTHING_CHANGES * abs(now):
        return "nothing would be better without it"
    return f"without it {words.objective_text(result, price.without, 3)} in all"


def price_unit(result: Result, price: Price) -> str:
    """The unit of a price's key."""
    return str((result.mission.get("limits") or {}).get("currency") or "") if price.name == "cost" else price.unit


def change_words(result: Result, price: Price) -> str:
    """By how much the objective changes."""
    if price.change is None:
        return "this system no longer fits" if price.until is None else "nothing fits"
    if abs(price.change) <= NOTHING_CHANGES * abs(result.objective.value or 1.0):
        return NOTHING
    sign = "+" if price.change > 0 else "-"
    return f"{sign}{words.objective_text(result, abs(price.change), 3)}"

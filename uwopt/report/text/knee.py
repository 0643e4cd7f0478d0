"""The best image for its price in words: what it has, and what one more watt or 100 USD more would buy."""

from __future__ import annotations

from collections.abc import Iterator

from uwopt.mission.best_image import NAME
from uwopt.report.text import formats, words
from uwopt.report.text.layout import Block, block, fact_lines
from uwopt.results.basis import Bought, Knee
from uwopt.results.result import Result
from uwopt.units import ratio_to_db

QUALITIES = {"information": "information", "snr": "signal to noise"}
LEAST_TOLD = 5e-5  # of a gain: below it nothing is bought


def goal_text(result: Result) -> str:
    """`best image for its price: information 2.51 Mbit/m². One more watt buys ...`; empty for other goals."""
    if result.objective.name != NAME:
        return ""
    knee = result.knee
    if knee is None:
        return "best image for its price."
    more = ", ".join(bought_text(knee, item) for item in knee.bought)
    text = f"best image for its price: {quality_text(knee)}. {words.capital(more)}"
    return text + f"; whatever buys more than {asked_text(knee)} is taken already."


def quality_text(knee: Knee) -> str:
    """`information 2.51 Mbit/m²`, or the signal to noise in decibels."""
    if knee.quality == "snr":
        return f"{QUALITIES['snr']} {formats.quantity(float(ratio_to_db(knee.value)), 'dB')}"
    return f"{QUALITIES[knee.quality]} {formats.quantity(knee.value, knee.unit)}"


def asked_text(knee: Knee) -> str:
    """`1 % for a watt or 1 % for 100 USD`."""
    return f"{gain_text(knee, knee.per_w)} for a watt or {gain_text(knee, knee.per_100_usd)} for 100 USD"


def gain_text(knee: Knee, gain: float) -> str:
    """`1.2 %` of information, or `0.1 dB` of signal to noise."""
    if knee.quality == "snr":
        return f"{float(ratio_to_db(1.0 + gain)):.2g} dB"
    return f"{100.0 * gain:.2g} %"


def bought_text(knee: Knee, item: Bought) -> str:
    """`one more watt buys 0.3 % more information`."""
    step = "one more watt" if item.name == "power_w" else f"{formats.money(item.more, item.unit)} more"
    beyond = " beyond your limit" if item.beyond_limit else ""
    if item.gain < LEAST_TOLD:
        return f"{step}{beyond} buys nothing"
    return f"{step}{beyond} buys {gain_text(knee, item.gain)} more {QUALITIES[knee.quality]}"


def knee_blocks(result: Result) -> Iterator[Block]:
    """The same as facts, with the system that more would buy."""
    knee = result.knee
    if knee is None:
        return
    facts = [("best system", quality_text(knee)), ("asked", f"at least {asked_text(knee)}")]
    for item in knee.bought:
        parts = " + ".join(item.hardware.values())
        facts.append(("", words.as_sentence(bought_text(knee, item) + (f", with {parts}" if parts else ""))))
    yield block("What more would buy", [fact_lines(facts)])

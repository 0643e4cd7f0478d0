"""Risks of money and choice: price, parts that nobody sells, systems that may be the better buy."""

from __future__ import annotations

from uwopt.api.risks.worst import Weighed
from uwopt.results.basis import Risk
from uwopt.results.design import Design
from uwopt.results.result import Result
from uwopt.units import counted, format_at_most, format_money, format_price, format_quantity, listed

UNNOTICED = 0.01  # of a goal: its estimated numbers leave far more open
MUCH_ESTIMATED = 0.3  # of the price


def unsure_price(result: Result, design: Design) -> Weighed:
    """A price above the limit at its high end, or one that nobody has quoted."""
    cost = design.totals.cost
    limit = (result.mission.get("limits") or {}).get("cost")
    share = cost.estimated / cost.value if cost.value else 0.0
    told = "nearly all" if 0.995 <= share < 1.0 else f"{100 * share:.0f} %"  # which would round to all of it
    because = f"{told} of the price is estimated"
    if limit is not None and cost.value <= limit < cost.high:
        end = format_at_most(max(cost.low, limit), cost.high)  # with the digits that tell it from the limit
        figure = f"up to {end} against {format_money(limit, cost.currency)}"
        yield 58.0, Risk("it may cost more than allowed", because, figure)
    elif share > MUCH_ESTIMATED:
        figure = format_price(cost.low, cost.high, cost.currency)
        width = (cost.high - cost.low) / cost.value
        yield 20.0 + 30.0 * min(1.0, width), Risk("the price is not known", because, figure)
    unknown = sum(row.to_buy for row in design.bom if row.unit_price is None)
    if unknown and result.command == "solve":
        because = "nobody tells their price, so the sum leaves them out"
        yield 57.0, Risk("parts without a price", because, counted(unknown, "part"))


def dearer_than_it_must(result: Result, design: Design) -> Weighed:
    """A system that costs much less and is as good, as far as anybody will notice."""
    cheap = result.less_money
    if cheap is None or (more := cheap.value / cheap.value_of_best - 1.0) > UNNOTICED:
        return
    if cheap.is_less_even(design.least("uniformity")):
        return
    prices = (float(f"{amount:.2g}") for amount in (cheap.price_of_best, cheap.price))
    ours, theirs = (format_money(amount, cheap.currency) for amount in prices)
    which = "better" if more < -UNNOTICED else "as good within what anybody notices"
    because = f"another system is {which}: `For less money` names it"
    yield 90.0, Risk("it costs more than it must", because, f"{ours} against {theirs}")


def held_back(result: Result, design: Design) -> Weighed:
    """A limit of power or cost below which the best image has not come to its knee."""
    if result.knee is None:
        return
    for item in result.knee.bought:
        asked = result.knee.per_w if item.name == "power_w" else result.knee.per_100_usd
        if item.beyond_limit and item.gain > asked:
            what = "power" if item.name == "power_w" else "cost"
            because = f"{format_quantity(item.more, item.unit)} above it would better the images by more than it takes"
            yield 32.0, Risk(f"your limit of {what} holds the image back", because, f"{100.0 * item.gain:.2g} %")


def to_be_made(result: Result, design: Design) -> Weighed:
    """Parts that no shop sells."""
    kinds = [kind for kind, part in design.hardware.parts.items() if part.generic]
    if kinds:
        because = f"{listed(kinds)} must be found or made; figures and prices are those of their class"
        share = f"{len(kinds)} of {len(design.hardware.parts)} parts"
        yield 65.0, Risk("parts that no shop sells under a name", because, share)


def maybe_withdrawn(result: Result, design: Design) -> Weighed:
    """Parts of which nobody says whether they are still sold."""
    unsure = [row for row in design.bom if row.availability == "unknown" and row.to_buy]
    if unsure and result.command == "solve":
        because = f"no source says so of {listed([row.id for row in unsure])}"
        yield 18.0, Risk("parts that may be sold no longer", because, counted(len(unsure), "part"))


def idle_lamps(result: Result, design: Design) -> Weighed:
    """Lamps that are bought and never lit."""
    lamps = design.hardware.light_count
    if lamps and all(scene.settings.get("dim_frac") == 0.0 for scene in design.scenes):
        because = "daylight alone does what is asked; vehicle.light_count: 0 leaves them out"
        yield 34.0, Risk("lamps are bought that stay off", because, counted(lamps, "lamp"))


def better_elsewhere(result: Result, design: Design) -> Weighed:
    """What may be the better system after all."""
    doubt = result.robustness or {}
    if result.status == "stopped" and result.certificate is not None:
        gap = format_quantity(result.certificate.gap_abs, result.objective.unit)
        yield (
            40.0,
            Risk("a better system may exist", "the search was stopped before it was done", f"by up to {gap}"),
        )
    if quotes := doubt.get("quotes_that_matter"):
        because = "one estimated number, known better, would change the answer"
        yield 28.0, Risk("another system may be the better buy", because, counted(len(quotes), "such number"))
    elif (doubt.get("max_regret") or 0.0) > 0.0:
        because = "estimated numbers decide between them"
        figure = f"by up to {format_quantity(doubt['max_regret'], result.objective.unit)}"
        yield 20.0, Risk("another system may be the better buy", because, figure)

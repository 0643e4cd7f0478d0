"""What came of answers to a tender, in words: offers, what is missing or contradicts, what changed and why."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from uwopt.catalog.offers import Offer
from uwopt.report.text import formats, words
from uwopt.report.text.certainty import held_text
from uwopt.report.text.layout import Block, Grid, Line, Text, block, columns, sentence
from uwopt.results.design import Design
from uwopt.results.result import Result
from uwopt.solvers.explain.solved_again import QuotedAgain, SolvedAgain
from uwopt.units import percent


def answer_blocks(made: QuotedAgain) -> list[Block]:
    """Offers; what is wrong, missing or contradicts; what changed."""
    blocks = [block(f"Offers ({len(made.offers)})", [offers_grid(made)])]
    for title, lines in (
        ("Not taken, or not as written", [*fault_lines(made)]),
        ("Contradicts the data sheet: ask again", [*contradiction_lines(made)]),
        ("Not answered", [*missing_lines(made)]),
    ):
        if lines:
            blocks.append(block(title, lines))
    changed: list[Line] = [sentence(text) for text in change_sentences(made)]
    return [*blocks, block("What changed", changed)]


def offers_grid(made: QuotedAgain) -> Grid:
    """A row an offer."""
    table = columns(("part", "left"), ("offered", "left"), ("price of one", "right"), ("held until", "left"),
                    ("lead time", "right"), ("counts", "left"))  # fmt: skip
    for offer in made.offers:
        name = formats.one_line(f"{offer.cells.get('manufacturer', '')} {offer.cells.get('model', '')}", 60)
        price = offer.cells.get("price", "")
        paid = formats.one_line(f"{price} {offer.cells.get('currency', '')}", 30) if price else "not told"
        weeks = f"{formats.one_line(offer.lead_time_weeks, 10)} weeks" if offer.lead_time_weeks else "not told"
        what = formats.one_line(offer.part_id if offer.named else name or offer.part_id or "no name", 60)
        cells = (offer.kind, what, paid, offer.valid_until or "not told", weeks, "yes" if offer.usable else "no")
        table.add_row(*(Text(cell, "red" if cell == "no" else "") for cell in cells))
    return table


def place(offer: Offer) -> str:
    """Where an offer stands."""
    return formats.one_line(offer.where, 100)


def fault_lines(made: QuotedAgain) -> Iterator[Line]:
    """What is wrong with answers."""
    for offer in made.offers:
        for fault in offer.faults:
            yield sentence(f"- {place(offer)}: {fault}.", "yellow")


def contradiction_lines(made: QuotedAgain) -> Iterator[Line]:
    """Answers that the data sheet says otherwise; they count all the same."""
    for offer in made.offers:
        for text in offer.contradicts:
            yield sentence(f"- {place(offer)}: {text}; the answer counts.", "yellow")


def missing_lines(made: QuotedAgain) -> Iterator[Line]:
    """What was asked and is not answered."""
    for offer in made.offers:
        if offer.missing:
            names = words.listed([formats.one_line(name, 40) for name in offer.missing])
            yield sentence(f"- {place(offer)}: {names}.")


# ---------------------------------------------------------------- what changed


def change_sentences(made: QuotedAgain) -> Iterator[str]:
    """What is recommended now, what was before, and why it is another."""
    if not made.log:
        yield "Nothing: no answer told anything that is new and can be used."
        return
    yield from again_sentences(made, lambda was, now: because(made, was, now))
    yield from certainty_sentences(made)


def certainty_sentences(made: SolvedAgain) -> Iterator[str]:
    """How often what is recommended now holds, where that was counted."""
    now, was = made.after.confidence, made.before.confidence
    if now is not None:
        before = f"; what was recommended before in {percent(was.held)}" if was is not None else ""
        yield f"{'It' if now.enough else 'Not certain enough: it'} {held_text(now)}{before}."


def again_sentences(made: SolvedAgain, why: Callable[[str, str], str]) -> Iterator[str]:
    """The same of whatever was learned; `why`: what stands behind a part that is another, by its id before and now."""
    before, after = made.before.best, made.after.best
    if after is None or before is None:
        yield f"Before: {verdict(made.before)}. Now: {verdict(made.after)}."
        return
    replaced = [*made.replaced()]
    values = formats.quantities_apart(before.objective_value, after.objective_value, unit=made.after.objective.unit)
    goal = made.after.objective.name.replace("_", " ")
    if not replaced:
        yield "The recommendation stands."
    for kind, was, now in replaced:
        yield f"{words.capital(kind)} {now} instead of {was}{why(was, now)}."
    told = f"{values[1]}, before {values[0]}" if values[0] != values[1] else f"{values[1]} as before"
    yield f"{words.capital(goal)}: {told}."
    yield (
        f"Price: {formats.cost_text(after.totals.cost)}, {words.quoted_share(after.totals.cost)}; before "
        f"{formats.cost_text(before.totals.cost)}, {words.quoted_share(before.totals.cost)}."
    )
    if replaced:
        yield former(made, goal)
    yield f"Next best: {next_best(made.after, after)}."


def verdict(result: Result) -> str:
    """How a search ended."""
    return words.status_sentence(result)


def because(made: QuotedAgain, was: str, now: str) -> str:
    """Why a part has another in its place, by what was answered of either."""
    offered, former_offer = made.offer_of(now), made.offer_of(was)
    if offered is not None:
        before = made.before.best
        class_before = before is not None and any(p.id == was and p.generic for p in before.hardware.parts.values())
        first = "; what is sold goes before what is to be made" if class_before else ""
        return f", as it is offered{told_of(offered)}{first}"
    if former_offer is not None:
        return f", for what is known now of the former{told_of(former_offer)}"
    return ", which suits the others that changed"


def told_of(offer: Offer) -> str:
    """What an answer said, in short."""
    cells = offer.cells
    facts = [f"{name} {formats.one_line(cells[name], 30)}" for name in sorted(cells) if name not in NO_FACTS]
    price = f"{offer.cells['price']} {offer.cells['currency']}" if offer.cells.get("price") else ""
    said = [text for text in (price, *facts[:6]) if text]
    return f" ({formats.one_line(', '.join(said), 300)})" if said else ""


NO_FACTS = ("part", "id", "manufacturer", "model", "price", "currency", "price_date", "source_url", "availability",
            "purpose", "kind", "geometry")  # fmt: skip


def former(made: SolvedAgain, goal: str) -> str:
    """What became of the system that was recommended."""
    now = made.former_now()
    if now is None:
        return "The former recommendation is no longer among the best systems found, or misses a requirement now."
    value = formats.quantity(now.objective_value, made.after.objective.unit, 4)
    return f"The former recommendation now reaches {value} of {goal}."


def next_best(result: Result, best: Design) -> str:
    """The first runner-up by what it has instead."""
    if not result.runners_up:
        return "none was found"
    other = result.runners_up[0]
    return f"{words.differing_parts(other, best)}, {words.value_text(result, other, other.objective_value)}"

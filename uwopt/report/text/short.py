"""The one page that a buyer reads first: buy, set, what it costs, the greatest risks, what to measure or quote first.

What belongs to it is decided here, for text and HTML alike; proof, margins and what a search works with stand behind
`--full` and in the folds of the HTML page.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from uwopt.report.text import formats, words
from uwopt.report.text.buying import bought_name, buy_block, cost_block, dear_battery, not_in_it, set_block
from uwopt.report.text.certainty import (
    ask_first,
    certainty_block,
    surer_block,
)
from uwopt.report.text.doubts import quoted_number
from uwopt.report.text.helps import contradiction_lines, not_known_lines, notes_beside
from uwopt.report.text.knee import goal_text
from uwopt.report.text.layout import Block, Line, Text, block, fact_lines, sentence
from uwopt.report.text.nothing_fits import (
    excluding_most,
    fit_sentence,
    helpful_lines,
    in_more_time,
    miss_sentence,
    nearest_title,
    no_change_helps,
    none_left_lines,
)
from uwopt.report.text.opening import missed_block, title_line, verdict_lines
from uwopt.report.text.prices import less_money_block, short_price_sentence
from uwopt.report.text.tables import (
    nearest_miss,
    proof_blocks,
    system_blocks,
)
from uwopt.results.basis import MISSED, MISSED_OF_PRACTICE, Risk
from uwopt.results.design import (
    PRACTICE_IN_VAIN,
    PRACTICE_UNTRIED,
    BillRow,
    Design,
)
from uwopt.results.result import Result
from uwopt.solvers.infeasible.none_left import stays_empty

MOST_RISKS = 3
MOST_TOLD = 1000  # letters of what may go wrong: what gave way is told whole
MOST_QUESTIONS = 4
CUT_SHORT = ("time", "interrupted")  # notes on what was left out
NUMBERS = ("", "The greatest risk", "The two greatest risks", "The three greatest risks")
DEAR = 0.1  # a part's share of the doubt in the price from which a quote is worth asking for
ASKED_BY_PRACTICE = (
    "Good practice asks for part of this: light and sharpness over the whole image, reserves, and nothing that an "
    "expert would refuse. `practice: bare` asks only for what the mission says."
)
HINT = "--full adds the proof, every requirement, other choices and all that is assumed"
PAGE_HINT = "--out DIR writes a page with pictures"
def short_text_blocks(result: Result, *, has_page: bool = False) -> Iterator[Block | Text]:
    """The page as text: name and verdict, its sections, and where the rest is, such as on a page that was written."""
    yield from first_text_blocks(result)
    yield from rest_of_blocks(result)
    yield hint(has_page)


def hint(has_page: bool) -> Text:
    """Where the rest is."""
    return sentence(f"{HINT}." if has_page else f"{HINT}; {PAGE_HINT}.", "dim")


def full_text_blocks(result: Result) -> Iterator[Block | Text]:
    """All there is: how far it may be believed and what may go wrong as on the page, the rest in full."""
    yield Block("", (title_line(result), *verdict_lines(result)))
    yield from system_blocks(result)
    if (design := result.best) is not None:
        if said := not_in_it(result, design):
            yield block("Not in the price", [sentence(words.as_sentence(said))])
        yield from certainty_block(result)
        yield from less_money_block(result)
        yield from risk_blocks(result)
        yield from question_blocks(result, design)
    yield from proof_blocks(result)


def first_text_blocks(result: Result) -> Iterator[Block]:
    """What the page begins with: all that is known once a recommendation is proven."""
    yield Block("", (title_line(result), *verdict_lines(result)))
    yield from first_blocks(result)


def rest_text_blocks(result: Result, *, has_page: bool = False) -> Iterator[Block | Text]:
    """What follows where the beginning has been read while the doubts were worked out."""
    yield Text("")
    if result.knee is not None:  # was not known yet
        yield Block("", (sentence(f"Goal: {goal_text(result)}"),))
    yield from rest_of_blocks(result)
    yield hint(has_page)


def short_blocks(result: Result) -> Iterator[Block]:
    """The sections of the page, which text and HTML share."""
    yield from first_blocks(result)
    yield from rest_of_blocks(result)


def first_blocks(result: Result) -> Iterator[Block]:
    """What to buy and to pay; no doubt changes it."""
    design = result.best
    if design is None:
        return
    yield from missed_block(result, design)
    yield buy_block(design, "The system" if result.command == "evaluate" else "Buy")
    yield cost_block(result, design.as_set)


def rest_of_blocks(result: Result) -> Iterator[Block]:
    """Risks and what to ask first, which the doubts decide, then details; or what would help where nothing fits."""
    design = result.best
    if design is None:
        yield from nothing_blocks(result)
        yield from cut_short_block(result)
        return
    yield from risk_blocks(result)
    yield from question_blocks(result, design)
    yield set_block(result, design)
    yield from certainty_block(result)
    yield from less_money_block(result)
    if alike := words.sibling_sentence(result):
        yield block("Would do as well", [sentence(words.as_sentence(alike))])
    if said := short_price_sentence(result):
        yield block("What asking for more costs", [sentence(said)])
    yield from cut_short_block(result)


def cut_short_block(result: Result) -> Iterator[Block]:
    """What is not told for want of time, or because a person wanted no more: nobody should take it for no doubt."""
    if result.best is None and result.status == "stopped":
        return  # the verdict says so
    if told := [words.as_sentence(words.note_text(note)) for note in notes_beside(result) if note.code in CUT_SHORT]:
        yield block("Left out", [*map(sentence, told)])


# ---------------------------------------------------------------- risks, and what to ask


def risk_blocks(result: Result) -> Iterator[Block]:
    """What would hold more often, where that is known, and the greatest risks."""
    yield from surer_block(result)
    others = shown_risks(result)
    if others or others == result.risks:
        yield risk_block(others)


def shown_risks(result: Result) -> list[Risk]:
    """Risks beside what is missed, which stands above them."""
    return [risk for risk in result.risks if risk.because not in (MISSED, MISSED_OF_PRACTICE)]


def risk_block(risks: Sequence[Risk]) -> Block:
    """The most serious risks, each with its reason and figure."""
    shown = [risk_text(risk) for risk in risks[:MOST_RISKS]]
    title = NUMBERS[len(shown)] or "Risks"
    return block(title, numbered(shown) if shown else [sentence("None that this result knows of.")])


def risk_text(risk: Risk) -> str:
    """`It may cost more than allowed (up to 900 USD): the price is estimated.`"""
    figure = f" ({formats.one_line(risk.figure)})" if risk.figure else ""
    reason = f": {formats.one_line(risk.because)}" if risk.because else ""
    return words.as_sentence(formats.one_line(risk.what, MOST_TOLD) + figure + reason)


def question_blocks(result: Result, design: Design) -> Iterator[Block]:
    """What to measure or have quoted before the order; none where nothing is to be asked."""
    if asked := [*questions(result, design)][:MOST_QUESTIONS]:
        yield block("Measure or quote first", numbered(asked))


def questions(result: Result, design: Design) -> Iterator[str]:
    """What is worth knowing before the order, in the order in which it can change the answer."""
    doubt = result.robustness or {}
    yield from ask_first(result)
    if equal := words.equal_sentence(result):
        yield equal
    decisive = [quoted_number(item) for item in doubt.get("quotes_that_matter") or []][:MOST_QUESTIONS]
    if decisive and result.confidence is None:
        yield f"Ask for what decides between this and another system: {words.listed(decisive)}."
    waters = doubt.get("waters") or []
    failed = [water for water in waters if water.get("objective_value") is None]
    if failed:
        yield (
            "Measure the water where you will work (beam attenuation, or at least how far a black disc is seen "
            f"horizontally): this system does what is asked in {len(waters) - len(failed)} of {len(waters)} other "
            "descriptions of it."
        )
    if result.command == "solve":
        yield from quotes(design)
    if estimated := estimated_facts(result):
        yield f"Ask the makers for what is only estimated: {words.listed(estimated)}."


def quotes(design: Design) -> Iterator[str]:
    """Parts that nobody has quoted, those with the widest range first."""
    total = sum(map(width, design.bom))
    for row in sorted(design.bom, key=width, reverse=True):
        unknown = row.to_buy > 0 and row.unit_price is None
        if unknown or (total > 0.0 and width(row) >= DEAR * total):
            yield f"Ask for a quote: {row.to_buy} x {bought_name(row)}, {formats.due_text(row)}."


def width(row: BillRow) -> float:
    """How far apart the ends of a price are, of all pieces to buy."""
    low, high = row.unit_price_low, row.unit_price_high
    return 0.0 if low is None or high is None else (high - low) * row.to_buy


#: Estimated facts that decide how much light is measured, in words; the others matter less.
LIGHT_FACTS = {
    "light.output_factor": "how much light leaves the lamp",
    "camera.qe_scale": "quantum efficiency of the camera, as a factor",
    "camera.read_noise_e": "its read noise", "lens.transmission_frac": "transmission of the lens",
}  # fmt: skip


def estimated_facts(result: Result) -> list[str]:
    """Estimated numbers of the light's way, where they can break a requirement."""
    if (result.robustness or {}).get("feasible_at_bad_end") is not False:
        return []
    known = {item.path: item for item in result.assumptions if item.low != item.high}
    facts = []
    for path, name in LIGHT_FACTS.items():
        if (item := known.get(path)) is not None and item.low is not None and item.high is not None:
            low, high = formats.quantity(item.low), formats.quantity(item.high, item.unit)
            facts.append(f"{name} ({low} to {high})")
    return facts


def numbered(texts: Sequence[str]) -> list[Line]:
    """Sentences with their numbers, in two columns so that long ones hang."""
    return [fact_lines((f"{number}.", words.as_sentence(text)) for number, text in enumerate(texts, start=1))]


# ---------------------------------------------------------------- nothing


def nothing_blocks(result: Result) -> Iterator[Block]:
    """What would let a system through, and the system that comes nearest."""
    lines = helpful_lines(result)
    if not lines and result.status == "stopped":
        lines = [sentence(f"{in_more_time(result)}.")]
    elif not lines and result.infeasible:
        most = excluding_most(result)
        lines = [sentence(f"{no_change_helps(result)}."), *([most] if most else []), *none_left_lines(result)]
    lines += [] if (fit := fit_sentence(result)) is None else [fit]
    lines += [*contradiction_lines(result), *not_known_lines(result)]
    of_practice = (PRACTICE_IN_VAIN, PRACTICE_UNTRIED)
    in_vain = [words.as_sentence(note.message) for note in result.warnings if note.code in of_practice]
    empty = result.infeasible is not None and stays_empty(result.infeasible.none_left)
    is_asked = result.status == "infeasible" and result.mission.get("practice") == "recommended" and not empty
    if is_asked and not in_vain:
        lines.append(sentence(ASKED_BY_PRACTICE))
    lines = [*map(sentence, in_vain), *lines]
    if lines:
        yield block("What would help", lines)
    miss = nearest_miss(result)
    if miss is not None:
        note = miss_sentence(result)
        system = buy_block(miss, nearest_title(result))
        dear = [sentence(f"Most of its price: {said}.")] if (said := dear_battery(miss)) else []
        yield Block(system.title, (*([note] if note else []), *system.lines, *dear))

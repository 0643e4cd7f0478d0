"""How certain it is that a system does what is asked, in words: where it holds, what that costs, what to ask first."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from uwopt.mission.best_image import NAME as BEST_IMAGE
from uwopt.quantities import AT_LIKELIEST, LOST_TO, TERMS
from uwopt.report.text import formats, words
from uwopt.report.text.doubts import drawn_text, number_name
from uwopt.report.text.helps import move_text
from uwopt.report.text.layout import Block, Line, block, columns, fact_lines, sentence
from uwopt.report.text.layout import Text as Cell
from uwopt.results.certainty import CertaintyProof, Confidence, Decides, WorthKnowing
from uwopt.results.result import Result
from uwopt.tolerances import TIED_MEDIANS_REL
from uwopt.units import count_text, format_within, percent

#: What is uncertain, where its name in a result says little to who has to measure it.
UNCERTAIN = {
    "altitude beyond its band": "how far the vehicle leaves its band of altitudes",
    "K of the lamps' way": "how much lamp light the water takes on its way to the floor",
    "distance at which the lens stands": "how well the distance is met to which the lens is focused",
}
TAKEN_OFF = ", its power and price taken off"
SAME_PARTS = "the same parts"
MORE_LIGHT = 1.1  # times as much power, from which lamps that shine brighter are named as the cause
EVERY_END = "at every end of what is uncertain"


def held_text(known: Confidence) -> str:
    """`holds in 97 % of 1 024 scenarios (96 % to 98 %); 90 % asked`."""
    if known.asked == "ends":
        return f"holds {share_of_ends(known)}"
    between = f"{percent(known.held_low)} to {percent(known.held_high)}"
    return (
        f"holds in {percent(known.held)} of {count_text(known.scenarios)} scenarios of what is uncertain "
        f"({between}); {percent(float(known.asked))} asked{unrefuted(known)}"
    )


def share_of_ends(known: Confidence) -> str:
    """At which ends it holds."""
    return EVERY_END if known.held >= 1.0 else f"in {percent(known.held)} of the ends of what is uncertain"


def unrefuted(known: Confidence) -> str:
    """That a share below what was asked may be as much."""
    return ", which so many do not refute" if known.enough and known.held < float(known.asked) else ""


def status_text(known: Confidence, status: str) -> str:
    """`does what is asked in 97 % of 1 024 scenarios (90 % wanted)`: the first that is said of an answer.

    status : of the result
    """
    if known.asked == "ends":
        said = f"does what is asked {share_of_ends(known)}"
    else:
        said = (
            f"does what is asked in {percent(known.held)} of {count_text(known.scenarios)} scenarios "
            f"({percent(float(known.asked))} wanted{unrefuted(known)})"
        )
    if not known.enough:
        return f"not certain enough: {said}"
    return f"proven best; {said}" if status == "optimal" else said


def fails_in(known: Confidence) -> str:
    """`depth of field, in 2 % of the scenarios`; empty where all hold, or are ends."""
    if known.asked == "ends" or not known.lost_to:
        return ""
    worst = max(known.lost_to, key=lambda one: one.share)
    return f"{lost_text(worst.requirement)}, in {percent(worst.share)} of the scenarios"


def certainty_block(result: Result) -> Iterator[Block]:
    """Where it holds, what it costs, and what would be worth knowing before buying."""
    known = result.confidence
    if known is None:
        return
    lines: list[Line] = [fact_lines(list(facts(result, known)))]
    if len({tuple(point.hardware) for point in known.curve}) > 1:
        lines.append(curve_table(result, known))
        if ties := tied_text(result, known):
            lines.append(sentence(ties, "dim"))
    yield block("How certain", lines)


def keeps_reserves(result: Result) -> bool:
    """Whether a limit is moved by a reserve, so that what misses it may still do what was asked."""
    design = result.recommendation
    return design is not None and any(margin.reserve for margin in design.margins)


def facts(result: Result, known: Confidence) -> Iterator[tuple[str, str]]:
    """Name and text of each fact."""
    name = goal_name(result)
    yield "holds", words.capital(held_text(known)).removeprefix("Holds ")
    if known.objective_p50 is not None and result.objective.name != "cost":  # the price stands where it is told
        yield name, median_text(result, known)
    for one in known.fixed:
        text = f"light level {100.0 * one.light_level:.3g} %, {one.light_time_ms:.3g} ms of light"
        text += f", gain {one.gain_db:.3g} dB"
        yield f"set before, {formats.one_line(one.scene)}" if len(known.fixed) > 1 else "set before", text
    if known.lost_to:
        told = [f"{lost_text(one.requirement)} ({percent(one.share)})" for one in known.lost_to]
        kept = "; reserves are held in each scenario, too" if keeps_reserves(result) else ""
        yield "else missed first", words.listed(told) + kept
    if known.surest is not None:
        parts = words.listed([formats.one_line(part, 60) for part in known.surest.hardware])
        missed = words.listed([lost_text(name) for name in known.surest.misses])
        yield "surest", (
            f"{parts}, which holds in {percent(known.surest.held)}, but misses what is asked {AT_LIKELIEST}"
            f"{f' ({missed})' if missed else ''}, so that there are no settings to tell"
        )
    if known.central_objective is not None and known.central_held is not None:
        yield "at likeliest values", central_text(result, known)
    if known.proof is not None:
        yield "proven", proof_text(result, known.proof)
    short = [] if known.complete else ["not all hardware with room was looked for"]
    short += [] if known.fresh else ["the scenarios are those that the choice was made on, so the share flatters it"]
    if short:
        yield "for want of time", "; ".join(short)
    if known.f_number is not None:
        yield "set at sea", (
            f"exposure, gain and light level, once the water is seen; the iris stays at f/{known.f_number:.3g}"
        )
    if result.command == "evaluate":  # else with all that was assumed
        yield "drawn", drawn_text(known)


def goal_name(result: Result) -> str:
    """What is made best, in words: `signal to noise`."""
    name = result.objective.name
    return TERMS[name].words if name in TERMS else formats.one_line(name.replace("_", " "))


def median_text(result: Result, known: Confidence) -> str:
    """`median 280 W, 320 W or better in nine of ten, set anew in each`, where that is done."""
    text = f"median {words.objective_text(result, known.objective_p50)}"
    if known.objective_p90 is not None:
        text += f", {words.objective_text(result, known.objective_p90)} or better in nine of ten"
    if result.objective.name == BEST_IMAGE:
        return text + TAKEN_OFF
    text += "" if known.fixed else ", with exposure, gain and light level set for each scenario"
    best, median = result.best, known.objective_p50
    central_w = None if best is None else best.power_as_set_w
    if result.objective.name == "power" and central_w and median is not None and median > MORE_LIGHT * central_w:
        text += f": most of them need more light than the {formats.quantity(central_w, 'W')} {AT_LIKELIEST}"
    return text


def told_value(result: Result, value: float | None) -> str:
    """An objective of hardware in scenarios; a price with no more digits than its range leaves it."""
    if result.objective.name != "cost" or value is None or result.best is None:
        return words.objective_text(result, value)
    cost = result.best.totals.cost
    return format_within(value, min(cost.low, value), max(cost.high, value), result.objective.unit)


def central_text(result: Result, known: Confidence) -> str:
    """What is best at likeliest values, and what it does where the choice was made, beside what is recommended."""
    value, parts = told_value(result, known.central_objective), with_parts(result, known.central_hardware)
    value += f"{TAKEN_OFF}," if result.objective.name == BEST_IMAGE else ""
    if parts == SAME_PARTS:
        if result.objective.name == "cost":
            return "best with the same parts"
        return f"best is {value} with {parts}, where iris, focus and lamps are set for these alone"
    medians = [told_value(result, one) for one in (known.central_p50, known.p50_in_choice) if one is not None]
    beside = f", with medians of {' and '.join(medians)}" if len(medians) > 1 else ""
    return (
        f"best is {value} with {parts}; that holds in {percent(known.central_held or 0.0)} of the "
        f"{count_text(known.scenarios_in_choice)} scenarios of the choice, what is recommended in "
        f"{percent(known.held_in_choice)}{beside}"
    )


def with_parts(result: Result, ids: Sequence[str]) -> str:
    """Hardware by what it has that the recommendation has not: `acme-cam-2 and acme-lens-3 instead`."""
    design = result.best
    ours = set(design.hardware.ids) if design is not None else set()
    others = [formats.one_line(part, 60) for part in ids if part not in ours]
    if not others:
        return SAME_PARTS
    return words.listed(others) + (" instead" if len(others) < len(ids) else "")


def proof_text(result: Result, proof: CertaintyProof) -> str:
    """What is proven of all other hardware, and where it went."""
    what = "no hardware holds so often"
    if proof.best_possible is not None:
        best = words.objective_text(result, proof.best_possible)
        what = f"no hardware that holds so often does better than {best} in half of the scenarios"
    gone = [f"{count_text(proof.by_panel)} fail or are no better where nothing is worse than in most of them"]
    gone += [f"{count_text(proof.by_bounds)} by bounds in groups of them"] if proof.by_bounds else []
    gone += [f"{count_text(proof.counted)} counted in all of them"]
    gone += [f"{count_text(proof.left)} not looked at further"] if proof.left else []
    text = f"{what}; of {count_text(proof.combinations)} combinations " + ", ".join(gone)
    if proof.argued:
        text += f". Argued and held against counts, but not strictly proven, is {words.listed(proof.argued)}"
    return text


def lost_text(requirement: str) -> str:
    """What is missed, in words."""
    return LOST_TO.get(requirement, words.requirement_name(requirement))


def curve_table(result: Result, known: Confidence) -> Line:
    """What confidence costs: one row a hardware, at the most that it holds in."""
    name = goal_name(result)
    table = columns(("held in", "right"), (f"{name}, median", "right"), ("with", "left"))
    for point, after in zip(known.curve, [*known.curve[1:], None], strict=True):
        if after is not None and after.hardware == point.hardware:
            continue
        median, parts = told_value(result, point.objective_p50), with_parts(result, point.hardware)
        table.add_row(*map(Cell, (percent(point.confidence), median, parts)))
    return table


def tied_text(result: Result, known: Confidence) -> str:
    """Why another system of the curve is not recommended that seems as good, or better and as sure as is asked."""
    design, ours = result.best, known.p50_in_choice
    if design is None or ours is None or known.asked == "ends":
        return ""
    asked = float(known.asked)
    theirs = {
        point.confidence: point
        for point in known.curve
        if point.confidence >= asked and set(point.hardware) - set(design.hardware.ids)
    }
    scenarios = count_text(known.scenarios_in_choice)
    said = f"In these {scenarios} scenarios what is recommended has {told_value(result, ours)}"
    if any(abs(one.objective_p50 - ours) <= TIED_MEDIANS_REL * abs(ours) for one in theirs.values()):
        near = percent(TIED_MEDIANS_REL)
        return f"{said}: medians within {near} are a tie, which further scenarios and then the price decided."
    if asked in theirs:  # the best of all that hold so often
        again = theirs[asked].held_again
        at_least = None if again is None else math.floor(100.0 * again) / 100.0
        held, less = ("fewer", "") if at_least is None else (percent(at_least), f" {at_least:g}")
        why = f"further ones decided against what does better in {percent(asked)} of these, where it holds in {held}"
        return f"{said}: {why}. Where a little less is enough, ask for less (--confidence{less})."
    return ""


def ask_first(result: Result) -> Iterator[str]:
    """What would be worth knowing before buying, in the unit of the objective."""
    known = result.confidence
    for one in known.ask_first if known is not None else ():
        yield f"{asked_text(one)}: worth {words.objective_text(result, one.worth, 2)} on average."


def asked_text(one: WorthKnowing) -> str:
    """`Ask for light.power_w of acme-1`, `Measure the clarity of the water`."""
    if one.part:
        field = formats.one_line(number_name(one.what.partition(".")[2]))
        return f"Ask for {field} of {formats.one_line(one.part, 60)}"
    if one.what.startswith("which"):
        return f"Measure the water (scene.c_per_m), to find out {formats.one_line(one.what)}"
    return f"Measure {uncertain(one.what)}"


def uncertain(what: str) -> str:
    """What is uncertain of water, floor and vehicle, in words."""
    return UNCERTAIN.get(what, formats.one_line(what))


#: What a change is told of is one piece of hardware; that of a mission so changed may be another.
CHOSEN_ANEW = "That is told of the hardware named: solve of a mission so changed chooses anew, and may take other."


#: The mission itself relaxes good practice anew, and mostly less of it.
CHANGE_AS_SOLVED = (
    "It is told with good practice relaxed as here: change these in mission-as-solved.yaml (--out), for the mission "
    "itself would ask for more again."
)


def surer_block(result: Result) -> Iterator[Block]:
    """On what it depends whether a system that is not certain enough holds, and with what asked less it would."""
    known = result.confidence
    if known is None or known.enough:
        return
    lines: list[Line] = [sentence(decides_text(one)) for one in known.decided_by]
    if known.would_hold:
        told = words.listed([move_text(move) for move in known.would_hold], "or")
        one_of = "with any one of these asked instead" if len(known.would_hold) > 1 else "with this asked instead"
        share = percent(float(known.asked))
        lines.append(sentence(f"With iris and focus set anew, this hardware holds in {share} {one_of}: {told}."))
    lines += map(sentence, [*in_vain_texts(known), *else_texts(known)])
    if known.would_hold or known.would_hold_else:
        lines.append(sentence(CHOSEN_ANEW))
        if result.mission_as_solved is not None:
            lines.append(sentence(CHANGE_AS_SOLVED))
    if lines:
        yield block("What would make it certain", lines)


def in_vain_texts(known: Confidence) -> Iterator[str]:
    """That no single change is enough, with what each comes to, nor as much more of each limit as was tried."""
    if known.in_vain and not known.would_hold:
        best = sorted(known.in_vain, key=lambda one: -one.held)
        helps = [one for one in best if one.held > known.held_in_choice]
        told = [f"{move_text(replace(one.move, nearest=True))} holds in {percent(one.held)}" for one in helps]
        vain = words.listed([words.key_name(one.move.name) for one in best if one not in helps])
        told += [f"another {vain} is no help"] if vain else []
        yield f"No single change is enough for this hardware: {'; '.join(told)}."
    if known.beyond_limits is not None:
        yield (
            "More money, power and the like are not enough: with four times each limit of the mission nothing that was "
            f"counted holds in more than {percent(known.beyond_limits)}."
        )


def else_texts(known: Confidence) -> Iterator[str]:
    """What else would hold: other hardware with a key moved, or this with several."""
    for one in known.would_hold_else:
        moves = words.listed([move_text(replace(move, nearest=True)) for move in one.moves])
        together, less = "", "less may do"
        if len(one.moves) > 1:
            together, less = " together", "each as little as is enough while the others stay"
        what = " + ".join(formats.one_line(part, 60) for part in one.hardware) or "this hardware"
        yield f"With {moves}{together}, {what} holds in {percent(one.held)} ({less})."


def decides_text(one: Decides) -> str:
    """`It depends on the clarity of the water: holds in 12 % where that is low, in 97 % where it is high.`"""
    if one.what.startswith("which"):
        both = f"in {percent(one.held_low)} by the one taken here, in {percent(one.held_high)} by the other"
        return f"It depends on {formats.one_line(one.what)}: holds {both}. Measure the water (scene.c_per_m)."
    what = uncertain(one.what)
    if one.part:
        what = f"{formats.one_line(number_name(one.what.partition('.')[2]))} of {formats.one_line(one.part, 60)}"
    both = f"in {percent(one.held_low)} where it is low, in {percent(one.held_high)} where it is high"
    return f"It depends on {what}: holds {both}."

"""The one page that a buyer reads first: buy, set, what it costs, the greatest risks, what to measure or quote first.

What belongs to it is decided here, for text and HTML alike; proof, margins and what a search works with stand behind
`--full` and in the folds of the HTML page.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from uwopt.mission.doubt import CENTRAL
from uwopt.mission.weakened import LEAST_SNR_DB
from uwopt.mission.yielding import SEEN_SNR_DB
from uwopt.quantities import AT_LIKELIEST, BY_NAME
from uwopt.report.text import formats, words
from uwopt.report.text.certainty import (
    ask_first,
    certainty_block,
    fails_in,
    goal_name,
    status_text,
    surer_block,
)
from uwopt.report.text.doubts import quoted_number
from uwopt.report.text.helps import contradiction_lines, not_known_lines, notes_beside
from uwopt.report.text.in_hand import fails_first
from uwopt.report.text.knee import goal_text
from uwopt.report.text.layout import Block, Joined, Line, Text, block, columns, fact_lines, sentence
from uwopt.report.text.not_counted import not_counted
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
from uwopt.report.text.prices import less_money_block, short_price_sentence
from uwopt.report.text.tables import (
    hardware_block,
    missed_lines,
    nearest_miss,
    proof_blocks,
    rounding_lines,
    scenes_to_set,
    settings_table,
    status_style,
    system_blocks,
)
from uwopt.results.basis import MISSED, MISSED_OF_PRACTICE, Risk
from uwopt.results.design import (
    COLOUR_LEFT_OPEN,
    PRACTICE_IN_VAIN,
    PRACTICE_MISSED,
    PRACTICE_UNTRIED,
    PRACTICE_YIELDS,
    SNR_INSTEAD,
    BillRow,
    Cost,
    Design,
    Margin,
)
from uwopt.results.result import Result
from uwopt.solvers.infeasible.none_left import stays_empty
from uwopt.units import counted, format_within

MOST_RISKS = 3
MOST_TOLD = 1000  # letters of what may go wrong: what gave way is told whole
MOST_QUESTIONS = 4
TOLD_FIRST = (SNR_INSTEAD, COLOUR_LEFT_OPEN)  # notes on what was chosen where the mission leaves it open
CUT_SHORT = ("time", "interrupted")  # notes on what was left out
NUMBERS = ("", "The greatest risk", "The two greatest risks", "The three greatest risks")
SHARED_FOCUS = "nearer than what is sharp, on purpose: middle and corners of a curved image share it"
GIVEN_FOCUS = "nearer than what is sharp: the corners of a curved image are sharp farther away than its middle"
BATTERY, MUCH = "rest-battery", 0.4  # its line of the bill, and of the price from which it is named
FIGURES = ("gsd_mm", "swath_m", "snr_db", "dof_m", "frame_rate_hz")
DEAR = 0.1  # a part's share of the doubt in the price from which a quote is worth asking for
GAVE_WAY = (
    "Not all of good practice is kept: the risks say what was relaxed, and --out writes a mission that says so "
    "(mission-as-solved.yaml)."
)
BARE = (
    "Only what the mission says is held: `practice: recommended` in it asks for light and sharpness over the whole "
    "image and for reserves as well."
)
ASKED_BY_PRACTICE = (
    "Good practice asks for part of this: light and sharpness over the whole image, reserves, and nothing that an "
    "expert would refuse. `practice: bare` asks only for what the mission says."
)
A_SCENARIO = "A scenario is water, parts and vehicle as they may turn out to be within what is known of them."
HINT = "--full adds the proof, every requirement, other choices and all that is assumed"
PAGE_HINT = "--out DIR writes a page with pictures"
INTERRUPTED = "interrupted, so not all of its risks are told"
NOT_COUNTED = "interrupted before it was counted how often that holds"


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


# ---------------------------------------------------------------- verdict


def title_line(result: Result) -> Joined:
    """The mission's name, and how far the answer may be believed."""
    name = formats.one_line(result.mission.get("name") or "mission", 80)
    return Joined((Text(name, "bold"), Text(": "), Text(how_far(result), status_style(result))))


def how_far(result: Result) -> str:
    """How far the answer may be believed: in how many scenarios it holds, where that was counted.

    That images are very noisy stands before it: to hold what is asked is no praise then.
    """
    known = result.confidence
    said = words.status_sentence(result) if known is None else status_text(known, result.status)
    return "; ".join(text for text in (noise_clause(result), said, cut_clause(result)) if text)


def cut_clause(result: Result) -> str:
    """What is not known of a system because a person interrupted; else empty."""
    if result.best is None or not any(note.code == "interrupted" for note in result.warnings):
        return ""
    is_counted = result.confidence is not None or result.mission.get("confidence") in (None, CENTRAL)
    return INTERRUPTED if is_counted else NOT_COUNTED


def noise_clause(result: Result) -> str:
    """`images are very noisy: signal to noise 9 dB over 95 % of the frame, -2 dB in its darkest place`, or nothing.

    They are where on 5 % of the frame or more a thing is hardly told from noise, or noise outdoes the signal somewhere.
    """
    if result.best is None:
        return ""
    figures = [scene.figures for scene in result.best.as_set.scenes]
    most, darkest = (
        min((float(db) for one in figures if (db := one.get(name)) is not None), default=math.inf)
        for name in ("snr_db_p05", "snr_db_min")
    )
    if most >= SEEN_SNR_DB and darkest >= LEAST_SNR_DB:
        return ""
    ends = ((most, "over 95 % of the frame"), (darkest, "in its darkest place"))
    told = (f"{round(db)} dB {where}" for db, where in ends if math.isfinite(db))
    return f"images are very noisy: signal to noise {', '.join(told)}"


def verdict_lines(result: Result) -> list[Line]:
    """What the answer is best in, what images it takes, and what fails first."""
    if result.best is None:
        return []
    known = result.confidence
    said = [A_SCENARIO] if known is not None and known.asked != "ends" else []
    said += [*practice_sentences(result), f"Goal: {goal_told(result, result.best)}"]
    said.append(image_sentence(result, result.best.as_set))
    if first := first_to_fail(result, result.best):
        said.append(words.as_sentence(f"fails first: {first}"))
    said += [*subject_sentences(result, result.best)]
    said += [words.as_sentence(note.message) for note in result.warnings if note.code in TOLD_FIRST]
    if result.command == "solve" and result.mission.get("practice") == "bare":
        said.append(BARE)
    return [sentence(text) for text in said]


def first_to_fail(result: Result, design: Design) -> str:
    """What fails in most of the scenarios in which it fails; where none were counted, what has the least margin."""
    told = "" if result.confidence is None or not design.feasible else fails_in(result.confidence)
    return told or fails_first(design.as_set, result.deepest_m)


def practice_sentences(result: Result) -> list[str]:
    """That some of good practice gave way, or is all that is missed: nobody should read on without knowing."""
    if any(note.code == PRACTICE_YIELDS for note in result.warnings):
        return [GAVE_WAY]
    return [words.as_sentence(note.message) for note in result.warnings if note.code == PRACTICE_MISSED]


def subject_sentences(result: Result, design: Design) -> Iterator[str]:
    """Where a subject that moves leaves the exposure no longer than it is: `What moves at 0.5 m/s decides ...`"""
    given = {one.get("name"): one for one in result.mission.get("scenes") or []}
    for scene in design.scenes:
        speed = given.get(scene.name, {}).get("subject_speed_m_s")
        if not speed or not any(m.requirement == "max_blur_px" and m.binding for m in scene.margins):
            continue
        place = words.in_scene(scene.name, design.scenes)
        yield f"What moves there by itself at {formats.quantity(speed, 'm/s')} decides the exposure{place}."


def goal_told(result: Result, design: Design) -> str:
    """`least power, 3.06 W at these settings.`, those to type in, and beside it the median of the scenarios."""
    if of_image := goal_text(result):
        return of_image
    goal, rounded = result.objective, design.rounded
    name = goal_name(result)
    as_set = rounded is not None and design.is_settable and rounded.objective_value is not None
    value = rounded.objective_value if rounded is not None and as_set else design.objective_value
    most = "most" if goal.direction == "maximise" else "least"
    text = words.value_text(result, design, value)
    if goal.name == "cost":
        return f"{most} {name}, {text}."
    exact = words.value_text(result, design, design.objective_value)
    beside = f" ({exact} before rounding)" if as_set and exact != text else ""
    told = f"{text} at these settings" if as_set else text
    known = result.confidence
    if known is None or known.objective_p50 is None:
        return f"{most} {name}, {told}{beside}."
    median = words.objective_text(result, known.objective_p50)
    return f"{most} {name}, {told} {AT_LIKELIEST}, {median} in the median scenario."


def image_sentence(result: Result, design: Design) -> str:
    """What the images are at the nominal distance, from the least to the most where there are several scenes."""
    shown = []
    for name in FIGURES:
        values = (scene.figures.get(name, scene.settings.get(name)) for scene in design.scenes)
        if text := formats.span((float(v) for v in values if isinstance(v, (int, float))), BY_NAME[name].unit):
            told = f"{'mean ' if name == 'snr_db' else ''}{BY_NAME[name].words}"  # others are of the whole image
            shown.append(f"{told} {text}")
        elif name == "dof_m" and (near := sharp_from(design)):
            shown.append(f"sharp from {near} to infinity")
    return f"Images{nominal_place(result)}: {', '.join(shown)}." if shown else ""


def sharp_from(design: Design) -> str:
    """Where sharpness begins that ends nowhere, farthest from the port of several scenes; empty where it ends."""
    figures = [scene.figures for scene in design.scenes]
    if not figures or not all(one.get("dof_far_is_infinite") for one in figures):
        return ""
    near = [one.get("dof_near_m") for one in figures]
    return formats.span((float(v) for v in near if isinstance(v, (int, float))), "m").rpartition(" to ")[2]


def nominal_place(result: Result) -> str:
    """` at the nominal altitude, 2 m`, of scenes that differ ` at the nominal altitudes, 1 m to 2 m`; empty of none."""
    told = (one.get("altitude_m") for one in words.vehicles_of(result.mission))
    nominal_m = sorted({float(one) for one in told if isinstance(one, (int, float))})
    if not nominal_m:
        return ""
    if len(nominal_m) == 1:
        return f" at the nominal altitude, {nominal_m[0]:g} m"
    return f" at the nominal altitudes, {nominal_m[0]:g} m to {nominal_m[-1]:g} m"


def missed_block(result: Result, design: Design) -> Iterator[Block]:
    """Every requirement that a given system misses, each where it is worst."""
    worst = dict[str, Margin]()
    for margin in design.as_set.missed:
        known = worst.get(margin.requirement)
        if known is None or shortfall(margin) > shortfall(known):
            worst[margin.requirement] = margin
    if worst and result.command == "evaluate":
        yield block("Missed", missed_lines([*worst.values()], design.as_set))


def shortfall(margin: Margin) -> float:
    """How far a margin is from none; infinite where it has no number."""
    return math.inf if margin.margin is None else abs(margin.margin)


# ---------------------------------------------------------------- buy and set


def buy_block(design: Design, title: str) -> Block:
    """Parts with number and what is to pay for them, as a range."""
    heads = (("", "right"), ("part", "left"), ("name", "left"), ("to pay", "right"), ("price", "left"))
    table = columns(*heads)
    for row in design.bom:
        kind = formats.one_line(row.kind, 12)
        texts = (f"{row.count} x", kind, bought_name(row), formats.due_text(row), formats.known_price(row))
        table.add_row(*map(Text, texts))
    if not design.bom:
        table = hardware_block(design, "").lines[0]
    return block(title, [table])


def bought_name(row: BillRow) -> str:
    """Maker and model; of a class of parts its name and that it is to be made."""
    return words.made_name(f"{row.manufacturer} {row.model}".strip() or row.id, generic=row.generic)


def focused_before_the_sharp(design: Design) -> bool:
    """Whether the lens is focused nearer than the nearest that is sharp all over the image, as behind a dome."""
    return any(
        (focus := scene.settings.get("focus_distance_m")) is not None
        and focus < (scene.figures.get("dof_near_m") or 0.0)
        for scene in design.as_set.scenes
    )


def set_block(result: Result, design: Design) -> Block:
    """Settings to type in, and how camera and lights stand."""
    hardware = design.hardware
    stands = [
        ("camera", words.camera_stand(hardware)),
        ("lights", words.mounts_text(hardware.light_mounts)),
    ]
    if focused_before_the_sharp(design):
        stands.insert(0, ("focus", GIVEN_FOCUS if result.command == "evaluate" else SHARED_FOCUS))
    lines: list[Line] = [settings_table(scenes_to_set(design), exact=False), fact_lines(stands)]
    if design.rounded is None or not design.is_settable:
        lines += rounding_lines(result, design)
    return block("Set", lines)


# ---------------------------------------------------------------- what it costs


def cost_block(result: Result, design: Design) -> Block:
    """Money as a range, and against the limit; power and mass."""
    cost, totals = design.totals.cost, design.totals
    text = formats.cost_text(cost)
    if formats.money(cost.low) != formats.money(cost.high):
        text += f", {middle_price(result, cost)}"
    if cost.value:
        text += f"; {words.quoted_share(cost)}"
    unpriced = words.n_unpriced(design.bom)
    if unpriced and not cost.value:
        text = "not known"
    elif unpriced:
        text += f"; without {counted(unpriced, 'part')} of unknown price"
    facts = [("price", text)]
    limit = (result.mission.get("limits") or {}).get("cost")
    if isinstance(limit, (int, float)) and cost.high > limit:
        end = "Its high end" if cost.value <= limit else "It"
        facts.append(("", f"{end} is above your limit of {formats.money(float(limit), cost.currency)}."))
    if said := dear_battery(design):
        facts.append(("most of it", said))
    if said := not_in_it(result, design):
        facts.append(("not in it", said))
    facts.append(("power", power_text(design)))
    if totals.mass_kg:
        facts.append(("mass", formats.quantity(totals.mass_kg, "kg") + words.housing_clause(totals)))
    if used_up := words.used_up_clause(totals).removeprefix(", "):
        facts.append(("used up", used_up))
    return block("What it costs", [fact_lines(facts)])


def middle_price(result: Result, cost: Cost) -> str:
    """The middle of a price that is a range: where scenarios drew it their median, else the sum of what is likeliest.

    Prices lean to the high side, so that the median of a sum is more than the sum of what is likeliest of each.
    """
    known = result.confidence
    if known is not None and known.price_p50 is not None and cost.low <= known.price_p50 <= cost.high:
        return f"median about {format_within(known.price_p50, cost.low, cost.high)}"
    return f"sum of the likeliest prices about {format_within(cost.value, cost.low, cost.high)}"


def dear_battery(design: Design) -> str:
    """The battery that a mission asks for by its size, where it takes much of the price; else nothing.

    It is no part that a search could choose another of: only the mission can ask for less.
    """
    row, cost = next((row for row in design.bom if row.id == BATTERY), None), design.totals.cost
    if row is None or not row.unit_price or not cost.value or row.unit_price * row.to_buy < MUCH * cost.value:
        return ""
    share = 100.0 * row.unit_price * row.to_buy / cost.value
    used_wh = design.totals.energy_wh
    of_it = "" if used_wh is None else f", of which the mission uses up {formats.quantity(used_wh, 'Wh')}"
    return f"{bought_name(row)}{of_it}: {formats.due_text(row)}, {share:.0f} % of the price; vehicle.battery_wh sets it"


def not_in_it(result: Result, design: Design) -> str:
    """What must be bought and is not in the price."""
    return ", ".join(item.what for item in not_counted(result, design) if item.bought)


def power_text(design: Design) -> str:
    """`3.05 W on average, the lamps 638 W while they burn`, at the settings to type in where there are any."""
    text = f"{formats.quantity(design.power_as_set_w, 'W')} on average"
    if burning := words.burning_text(design):
        text += f", the {burning}"
    return text


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

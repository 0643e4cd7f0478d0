"""Why nothing fits and what would help, as text: requirements that give way, rules that exclude most."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from uwopt.deadline import longer_s
from uwopt.mission.doubt import CENTRAL
from uwopt.mission.keys import WATER_KEYS
from uwopt.mission.reserves import REFUSED, refused_at
from uwopt.mission.weakened import DEEP, is_far, is_of_scenes
from uwopt.mission.yielding import yields_named
from uwopt.quantities import AT_LIKELIEST
from uwopt.report.text import formats, vocabulary, words
from uwopt.report.text.helps import (
    contradiction_lines,
    depth_lines,
    move_is_far,
    move_texts,
    moves_of,
    no_help_lines,
    not_known_lines,
)
from uwopt.report.text.layout import Block, Grid, Line, Text, block, columns, sentence
from uwopt.results.basis import Excluded, Moved, Relaxed, TooShallow
from uwopt.results.design import PRACTICE_IN_VAIN
from uwopt.results.result import Result
from uwopt.units import count_text, split_unit

if TYPE_CHECKING:
    from uwopt.results.front import FrontResult
    from uwopt.results.whatif import WhatIf

HANDFUL = 20  # parts of a kind
MOST_RULES = 3  # told on the first page where no change alone helps
AT_CENTRAL_PRICES = (
    "At the likeliest prices it would fit: the limit of cost is broken only where estimated prices turn out high "
    "(limits.cost_basis: high, the default). Ask for quotes, or hold the likeliest against it (cost_basis: central)."
)
HELPFUL = "Each of these changes alone would let a system through:"
SMALLER = "Or these together, each a smaller share of what is asked than any of those:"
TOGETHER = "All of these together would let a system through; less of some may do:"
IN_THIS_WATER = "In the water as it is, all of these together would; less of some may do:"
AT_THE_BRINK = (
    f"These are the least changes {AT_LIKELIEST}: to hold as often in the doubt as the mission asks (confidence) takes "
    "more than them."
)
FAR = "Out of reach, though alone it would let a system through:"
LESS, NO_LESS = "less may do", "no less will do"
DEEPEST_SCENE = "depth of the deepest scene (depth_m)"
DEPTH = "depth rating"  # rule of parts that are not rated as deep as is needed
LEFT_OUT = {"generic": "to be made, which catalog.generic leaves out"}  # where that is said otherwise than of a search


def infeasible_block(result: Result | FrontResult) -> Block:
    """The least that single requirements would have to give, and what excludes how much."""
    stopped = result.status == "stopped"
    lines = helpful_lines(result)
    open_yet = result.infeasible is not None and bool(result.infeasible.not_known)
    if not (relaxations_of(result) or stopped or open_yet) and isinstance(result, Result):  # else told, or below
        lines.append(sentence(f"{no_change_helps(result)}."))
    lines += none_left_lines(result)
    lines += [] if (fit := fit_sentence(result)) is None else [fit]
    lines += [*contradiction_lines(result), *no_help_lines(result), *not_known_lines(result)]
    table = columns(("combinations", "right"), ("excluded because", "left"))
    bounded = False
    for item in result.infeasible.requirements if result.infeasible is not None else []:
        if ": " in item.name:  # a part that the mission does not allow; the certificate counts those
            continue
        bounded |= item.n_is_bound
        count = count_text(item.n_excluded) + ("*" if item.n_is_bound else " ")
        table.add_row(Text(count), Text(f"{words.rule_name(item.name)} ({formats.one_line(item.name)})"))
    if table.row_count:
        lines += [Text(""), table]
    if bounded:
        lines.append(sentence("* proven by a bound, before the settings were looked at", "dim"))
    if stopped and not lines:
        return block("What would help", [sentence(f"{in_more_time(result)}.")])
    return block("What stood in the way so far" if stopped else "Why nothing fits", lines)


def helpful_lines(result: Result | FrontResult) -> list[Line]:
    """The changes that would help, and a limit of cost that only high prices break; nothing where none is known."""
    alone, far = changes_alone(result)
    lines: list[Line] = [sentence(HELPFUL), change_table(result, alone)] if alone else []
    if any(isinstance(item, Relaxed) and item.fits_at_central_prices for item in alone):
        lines.append(sentence(AT_CENTRAL_PRICES))
    if together := together_of(result):
        said = TOGETHER if not alone else IN_THIS_WATER if are_of_water(alone) else SMALLER
        lines += [sentence(said), relaxation_table(result, together)]
    if far:
        lines += [sentence(FAR), change_table(result, far)]
    if lines and isinstance(result, Result) and result.mission.get("confidence") not in (None, CENTRAL):
        lines.append(sentence(AT_THE_BRINK))
    return [*lines, *practice_lines(result), *depth_lines(result)]


def practice_lines(result: Result | FrontResult) -> list[Line]:
    """What of good practice is relaxed too with each change, where relaxing all that may be was in vain."""
    if not any(note.code == PRACTICE_IN_VAIN for note in result.warnings):
        return []
    made, unknown = [], list[str]()
    for item in [*relaxations_of(result), *moves_of(result)]:
        name, asked, possible = change_texts(result, item)
        if item.gives_up is None:
            unknown.append(name)
        else:
            told = "; ".join(one.words for one in yields_named(", ".join(item.gives_up)))
            fits = f"With {name} of {possible} instead of {asked} something fits"
            kept = f"; good practice is then relaxed, too: {told}" if told else ", with all of good practice"
            made.append(sentence(f"{fits}{kept}."))
    if unknown:
        left = words.listed(unknown)
        made.append(sentence(f"What of good practice must be relaxed then was not looked for with: {left}."))
    return made


def in_more_time(result: Result | FrontResult) -> str:
    """What a search that was stopped has left to look at, and what would help it on.

    A list of `catalog` that leaves a handful of a kind is named: more of them may hold one that is soon found to fit.
    """
    said, left = more_time(result), result.parts_left
    if left is None:
        return f"{said}, or a mission with fewer combinations"
    told = f"The mission leaves {left.in_words()} to choose from, and nothing was found so far that fits"
    asked = result.mission.get("catalog") or {}
    numbers = left.by_kind().items()
    few = [f"catalog.{kind}, which leaves {n}" for kind, n in numbers if asked.get(kind) and n <= HANDFUL]
    helps = f"or widen {words.listed(few)}" if few else "or leave fewer parts"
    if left.places <= HANDFUL:
        return f"{told}. {said}, {helps}"
    ranges = [f"vehicle.{key}" for key in LAMP_RANGES if is_range((result.mission.get("vehicle") or {}).get(key))]
    narrow = f": narrow {words.listed(ranges, 'or')}" if ranges else ""
    return f"{told}. {said}, {helps}; every lamp is tried in {left.places} places and tilts{narrow}"


LAMP_RANGES = ("light_baseline_m", "light_tilt_deg")


def is_range(value: float | Sequence[float] | None) -> bool:
    """Whether a key of a mission is a range, least and most, that leaves a choice."""
    return isinstance(value, Sequence) and len({*value}) == 2


def more_time(result: Result | FrontResult | WhatIf) -> str:
    """What a command that was stopped may be given: a time, or as long as its proof takes, where one was set."""
    if result.status == "interrupted" or any(note.code == "interrupted" for note in result.warnings):
        return "Let it run to its end"
    told = f"Give it more time (--seconds {longer_s(result.timing_s.get('total', 0.0))}"
    return f"{told}, or none: then it ends with its proof)" if isinstance(result, Result) else f"{told})"


def no_change_helps(result: Result | FrontResult) -> str:
    """What is known where no single change is known to help."""
    why = result.infeasible
    if why is not None and why.not_known:
        return "Which single change would be enough is not known yet"
    if why is not None and (why.none_left or why.nearest_fit is not None):
        return "No requirement alone stands in the way"
    if moves_of(result):
        return "No requirement alone is enough to leave out"
    return "No requirement alone is enough to leave out; at least two have to give"


def excluding_most(result: Result) -> Text | None:
    """The rules that exclude most of what the mission allows, and which of them good practice asks for."""
    rules = [r for r in result.infeasible.requirements if ": " not in r.name] if result.infeasible is not None else []
    most = sorted(rules, key=lambda rule: -rule.n_excluded)[:MOST_RULES]
    if not most:
        return None
    by_refusal, near = refusals_of(result.mission), nearest_of_each(result.mission)

    def told(rule: Excluded) -> str:
        key = formats.one_line(rule.name)
        word = by_refusal.get(key)
        held = " or ".join(f"{value:g}" for value in sorted({refused_at(word, one) for one in near})) if word else ""
        by = f" {held}, by refuse: {word}" if word else ""
        return f"{words.rule_name(rule.name)} ({key}{by})"

    return sentence(f"Most combinations are excluded by: {'; '.join(map(told, most))}.")


def refusals_of(mission: Mapping[str, Any]) -> dict[str, str]:
    """The word of `refuse` by each key that it stands for, where the mission does not give that key itself."""
    given = {key for key, value in (mission.get("requirements") or {}).items() if value is not None}
    given |= {"min_swath_m", "min_common_swath_m"} if "min_area_m2_h" in given else set()  # an area asks for a swath
    return {key: word for word, (key, _) in REFUSED.items() if key not in given}


def nearest_of_each(mission: Mapping[str, Any]) -> list[float]:
    """The least distance in each scene of a mission's plain values [m]; infinite where it tells none."""
    every = words.vehicles_of(mission)
    return [one.get("altitude_m", math.inf) - (one.get("altitude_tolerance_m") or 0.0) for one in every]


def none_left_lines(result: Result | FrontResult) -> list[Line]:
    """Kinds of parts of which none is left, and why those that the mission names are not."""
    made: list[Line] = []
    for one in [] if result.infeasible is None else result.infeasible.none_left:
        table = columns(("parts", "right"), ("left out because", "left"))
        for rule, count in sorted(one.by_rule.items(), key=lambda item: (item[0] != DEPTH, -item[1])):
            short = one.too_shallow if rule == DEPTH else None
            rows = [(count, words.rule_name(rule))] if short is None else shallow_rows(short, count)
            for number, why in rows:
                table.add_row(Text(count_text(number)), Text(LEFT_OUT.get(rule, why)))
        every = count_text(sum(one.by_rule.values()))
        made += [sentence(f"No {one.kind} is left to choose of the {every} in the catalogue:"), table]
        if one.reasons:
            by_id = one.reasons.items()
            told = "; ".join(f"{formats.one_line(name, 60)}: {formats.one_line(why, 120)}" for name, why in by_id)
            made.append(sentence(f"{'Named' if names_kind(result, one.kind) else 'Rated deep enough'}, but {told}."))
        of_kind = f"catalog.{key_of(one.kind)}: "
        made += [sentence(f"{note.message}.") for note in result.warnings if note.message.startswith(of_kind)]
    return made


def shallow_rows(short: TooShallow, count: int) -> list[tuple[int, str]]:
    """How many parts are rated for less than is needed, and how many have no rating; `depth_lines` has the deepest."""
    less = f"rated for less than {formats.quantity(short.needed_m, 'm', 4)}"
    rows = [(count - short.unrated, less), (short.unrated, "without a known depth rating")]
    return [row for row in rows if row[0]]


def names_kind(result: Result | FrontResult, kind: str) -> bool:
    """Whether a mission names parts of a kind."""
    return bool((result.mission.get("catalog") or {}).get(key_of(kind)))


def key_of(kind: str) -> str:
    """The key of a mission's `catalog` that names parts of a kind."""
    return "lenses" if kind == "lens" else f"{kind}s"


def fit_sentence(result: Result | FrontResult) -> Text | None:
    """Which size stops the fit, and what comes nearest, where nothing goes into any housing."""
    fit = None if result.infeasible is None else result.infeasible.nearest_fit
    if fit is None:
        return None
    parts = {kind: formats.one_line(name, 60) for kind, name in fit.hardware.items()}
    if not parts:
        return sentence("None of the housings is made for any of the ports.")
    said, nearest = "No port goes on any housing", f"{parts['port']} on {parts['housing']}"
    if "camera" in parts:
        said = "No camera with its lens that meets the rest so far fits into any housing"
        nearest = f"{parts['camera']} with {parts['lens']} behind {parts['port']} in {parts['housing']}"
    lacking = words.listed([
        f"{formats.quantity(one.needed_mm - one.room_mm, 'mm')} of "
        f"{vocabulary.SIZES.get(one.name, formats.one_line(one.name))} "
        f"({formats.quantity(one.needed_mm, 'mm', 4)} needed, {formats.quantity(one.room_mm, 'mm', 4)} there)"
        for one in fit.lacking
    ])  # fmt: skip
    return sentence(f"{said}. What comes nearest, {nearest}, lacks {lacking}.")


def nearest_title(result: Result | FrontResult) -> str:
    """What the nearest miss is called: no system is near that misses what is asked for by far."""
    first = next(iter(relaxations_of(result)), None)
    far = first is not None and is_far(first.name, first.limit, first.needed)
    return "What comes nearest, and is out of reach" if far else "What comes nearest"


def miss_sentence(result: Result | FrontResult, what: str = "it") -> Text | None:
    """What the nearest miss does not meet; `what`: its name, where its parts do not stand beside."""
    text = miss_text(result)
    return sentence(f"{words.capital(what)} {text}.") if text else None


def miss_text(result: Result | FrontResult) -> str:
    """`meets all that is asked but signal to noise (min_snr_db): 28 dB instead of 30 dB`; "" if not known.

    Where good practice is relaxed as far as it may be, it says so: else it would be taken for met. What it may not
    relax, as a refusal, is no word of the mission's own.
    """
    helpful = relaxations_of(result)
    if not helpful:
        return ""
    name, asked, possible = relaxation_texts(result, helpful[0])
    missed = f"{name}: {possible} instead of {asked}"
    if any(note.code == PRACTICE_IN_VAIN for note in result.warnings):
        says = "is asked" if helpful[0].name in refusals_of(result.mission) else "the mission itself says"
        return f"meets all that {says} but {missed}, with good practice relaxed as far as uwopt may"
    return f"meets all that is asked but {missed}"


def changes_alone(result: Result | FrontResult) -> tuple[list[Relaxed | Moved], list[Relaxed | Moved]]:
    """Changes of which each helps alone: those that a person can make, and those that are out of reach."""
    limits, moves = relaxations_of(result), moves_of(result)
    far: list[Relaxed | Moved] = [item for item in limits if is_far(item.name, item.limit, item.needed)]
    far += [move for move in moves if move_is_far(move)]
    near: list[Relaxed | Moved] = [item for item in limits if item not in far]
    return [*near, *(move for move in moves if move not in far)], far


def what_helps(result: Result | FrontResult) -> tuple[str, list[Relaxed | Moved]]:
    """How changes help, each alone or else together, and these changes."""
    alone, far = changes_alone(result)
    together = together_of(result)
    if together and are_of_water(alone):
        return TOGETHER, [*together]
    return (HELPFUL, alone) if alone else (FAR, far)


def are_of_water(changes: Sequence[Relaxed | Moved]) -> bool:
    """Whether none of these can be made, as clearer water can only be waited for."""
    return all(one.name in WATER_KEYS for one in changes)


def relaxations_of(result: Result | FrontResult) -> list[Relaxed]:
    """Relaxations that help."""
    return result.infeasible.relaxations if result.infeasible is not None else []


def together_of(result: Result | FrontResult) -> list[Relaxed]:
    """Changes that help together."""
    return result.infeasible.together if result.infeasible is not None else []


def change_table(result: Result | FrontResult, items: list[Relaxed | Moved]) -> Grid:
    """What stands and what would do, and whether a smaller change is known not to."""
    table = columns(("change", "left"), ("asked", "right"), ("possible", "right"), ("", "left"))
    for item in items:
        least = "" if item.needed is None else NO_LESS if item.nearest else LESS
        table.add_row(*map(Text, (*change_texts(result, item), least)))
    return table


def relaxation_table(result: Result | FrontResult, items: list[Relaxed]) -> Grid:
    """What is asked and what could be had."""
    table = columns(("requirement", "left"), ("asked", "right"), ("possible", "right"))
    for item in items:
        table.add_row(*map(Text, relaxation_texts(result, item)))
    return table


def change_texts(result: Result | FrontResult, item: Relaxed | Moved) -> tuple[str, str, str]:
    """Requirement or key, what is asked, what would do."""
    return move_texts(item) if isinstance(item, Moved) else relaxation_texts(result, item)


def relaxation_texts(result: Result | FrontResult, item: Relaxed) -> tuple[str, str, str]:
    """Requirement, what is asked, what could be had."""
    currency = str((result.mission.get("limits") or {}).get("currency") or "")
    unit = {"cost": currency, "min_snr": "dB"}.get(item.name, split_unit(item.name)[1])
    asked, possible = formats.quantities_apart(item.limit, item.needed, unit=unit, digits=4)
    name, word = words.key_name(item.name), refusals_of(result.mission).get(item.name)
    if item.name == DEEP and is_of_scenes(result.mission):  # less of the limit than that is refused
        name = DEEPEST_SCENE
    return (
        name if word is None else f"{name.removesuffix(')')}, by refuse: {word})",
        asked,
        "left out" if item.needed is None else possible,
    )

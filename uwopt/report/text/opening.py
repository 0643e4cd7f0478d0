"""What stands first: whether it works, how well, and what it misses."""

from __future__ import annotations

import math
from collections.abc import Iterator

from uwopt.mission.doubt import CENTRAL
from uwopt.mission.weakened import LEAST_SNR_DB
from uwopt.mission.yielding import SEEN_SNR_DB
from uwopt.quantities import AT_LIKELIEST, BY_NAME
from uwopt.report.text import formats, words
from uwopt.report.text.certainty import (
    fails_in,
    goal_name,
    status_text,
)
from uwopt.report.text.in_hand import fails_first
from uwopt.report.text.knee import goal_text
from uwopt.report.text.layout import Block, Joined, Line, Text, block, sentence
from uwopt.report.text.tables import (
    missed_lines,
    status_style,
)
from uwopt.results.design import (
    COLOUR_LEFT_OPEN,
    PRACTICE_MISSED,
    PRACTICE_YIELDS,
    SNR_INSTEAD,
    Design,
    Margin,
)
from uwopt.results.result import Result

TOLD_FIRST = (SNR_INSTEAD, COLOUR_LEFT_OPEN)  # notes on what was chosen where the mission leaves it open
FIGURES = ("gsd_mm", "swath_m", "snr_db", "dof_m", "frame_rate_hz")
GAVE_WAY = (
    "Not all of good practice is kept: the risks say what was relaxed, and --out writes a mission that says so "
    "(mission-as-solved.yaml)."
)
BARE = (
    "Only what the mission says is held: `practice: recommended` in it asks for light and sharpness over the whole "
    "image and for reserves as well."
)
A_SCENARIO = "A scenario is water, parts and vehicle as they may turn out to be within what is known of them."
INTERRUPTED = "interrupted, so not all of its risks are told"
NOT_COUNTED = "interrupted before it was counted how often that holds"


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

"""Names and short sentences for people; the tables and pages of a report share them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from uwopt.quantities import AT_LIKELIEST, REQUIREMENTS
from uwopt.report.text.formats import cost_text, money, one_line, quantity
from uwopt.report.text.vocabulary import (
    AS_WRITTEN,
    KEYS,
    PARTS_OF_THE_SEARCH,
    PIECES,
    RULES,
    STATUS_SENTENCES,
    SUBJECTS,
)
from uwopt.results.design import BillRow, Cost, Design, LampPlace, Note, Totals, UsedHardware, UsedPart
from uwopt.results.result import Certificate, Result
from uwopt.tolerances import SATISFIED_REL
from uwopt.units import (
    count_text,
    counted,
    format_number,
    format_price,
    format_within,
    listed,
    split_unit,
)

if TYPE_CHECKING:
    from uwopt.results.front import FrontObjective, FrontPoint

KEY = re.compile(r"\b[a-z]+(?:_[a-z0-9]+)+\b")  # of a mission

# ---------------------------------------------------------------- names


def requirement_name(requirement: str, kinds: Mapping[str, str] | None = None) -> str:
    """A requirement in words; of `depth_rating_m (lamp-1)` the kind of part is told where `kinds` knows the id."""
    stem, _, rest = requirement.partition(" (")
    words = REQUIREMENTS.get(stem, stem.replace("_", " "))
    kind = (kinds or {}).get(rest.rstrip(")"))
    if kind:
        return f"{words} of the {kind}"
    return one_line(words + (f" ({rest}" if rest else ""))


def key_name(name: str) -> str:
    """`tolerance of the altitude (altitude_tolerance_m)`: a requirement or key in words, and as a mission writes it."""
    said = (KEYS.get(name) or requirement_name(name)).partition(", ")[0]  # what sets it apart the key beside it says
    written = one_line(AS_WRITTEN.get(name, name), 40)
    return said if said == written else f"{said} ({written})"


def vehicles_of(mission: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The plain values of the vehicle in each scene of a mission."""
    common = dict(mission.get("vehicle") or {})
    own = [scene.get("vehicle") or {} for scene in mission.get("scenes") or ()]
    return [common | {key: value for key, value in one.items() if value is not None} for one in own] or [common]


def note_subject(path: str) -> str:
    """What a note is about, in words: `requirements.max_blur_px` is motion blur; several keys are good practice's."""
    key = "practice" if ", " in path else path.rpartition(".")[2]
    known = SUBJECTS.get(key) or REQUIREMENTS.get(key) or KEYS.get(key)
    return known or one_line(split_unit(key)[0].replace("_", " "))


def note_text(note: Note) -> str:
    """What a note says; what was left out for want of time by the words of its keys."""
    message = note.message or note.code
    return message if note.code != "time" else KEY.sub(lambda key: note_subject(key[0]), message)


def rule_name(rule: str) -> str:
    """A rule of the search in words; `light: availability` keeps the kind in front."""
    if rule in RULES:
        return RULES[rule]
    kind, _, name = rule.rpartition(": ")
    return (f"{one_line(kind)}: " if kind else "") + RULES.get(name, one_line(name.replace("_", " ")))


def part_name(part: UsedPart) -> str:
    """Maker and model of a part; of one that no shop sells what it is, and that it is to be made."""
    return made_name(part.name or part.id or "inline", generic=part.generic)


def made_name(name: str, *, generic: bool) -> str:
    """A part's name, with the mark of those that no shop sells under it in place of a maker."""
    return one_line(name.removeprefix("generic "), LONGEST) + TO_BE_MADE if generic else one_line(name, LONGEST)


def part_id(part: UsedPart) -> str:
    """Id of a part, with the mark of those that no shop sells as such."""
    return one_line(part.id or "inline", 60) + (TO_BE_MADE if part.generic else "")


LONGEST = 90  # letters of what a maker calls a part
TO_BE_MADE = " (to be made)"
SAME_HARDWARE = "the same hardware, other settings"
TOGETHER = 1.01  # times as long as all took, from which stages must have run side by side
WARM_K = 1.0  # less of warmth in a housing matters to no camera
WORTH_TELLING = 0.01  # of a price: less is no reason to choose


def differing_parts(design: Design, best: Design) -> str:
    """What a design has that the best one has not: `lens kowa-lm6hc, 3 lights`."""
    mine, other = design.hardware, best.hardware
    theirs = {part.id for part in other.named.values()}
    words = [f"{kind} {part_id(part)}" for kind, part in mine.named.items() if part.id not in theirs]
    if mine.light_count != other.light_count:
        words.append(counted(mine.light_count, "light"))
    if mine.orientation != other.orientation:
        words.append(mine.orientation)
    if mine.light_mounts != other.light_mounts and mine.light_count == other.light_count:
        words.append(f"lights {mounts_text(mine.light_mounts)}")
    return ", ".join(words) or SAME_HARDWARE


def central_best(result: Result) -> float | None:
    """The best objective at likeliest values, which those of all other systems are by.

    What was chosen over scenarios has its iris where those want it, and may be worse at these than another.
    """
    known = result.confidence
    if known is not None and known.central_objective is not None:
        return known.central_objective
    return None if result.best is None else result.best.objective_value


def by_likeliest_values(result: Result) -> bool:
    """Whether other systems are held against another number than that of what is recommended."""
    return result.best is not None and central_best(result) != result.best.objective_value


def was_passed_over(result: Result, value: float | None) -> bool:
    """Whether a system with this objective is better than what is recommended by exact numbers alone: it has no
    settings to type in, or loses much by them, so nobody should buy it instead.
    """
    ours = None if result.best is None else result.best.objective_value
    if ours is None or value is None or by_likeliest_values(result):
        return False
    better = ours - value if result.objective.direction == "minimise" else value - ours
    return better > SATISFIED_REL * abs(ours) and any(note.code == "better_unsettable" for note in result.warnings)


def equal_sentence(result: Result, most: int = 2) -> str:
    """Which systems the estimates cannot tell from the recommendation, the cheapest `most`; empty: there is none."""
    places = [item.get("runner_up") for item in (result.robustness or {}).get("equal") or []]
    others = [result.runners_up[place] for place in places if isinstance(place, int) and place < len(result.runners_up)]
    if result.best is None:
        return ""
    told = [
        what + dearer_by(design, result.best)
        for design in sorted(others, key=lambda one: one.totals.cost.value)
        if not was_passed_over(result, design.objective_value)
        and (what := differing_parts(design, result.best)) != SAME_HARDWARE
    ]
    if not told:  # the same parts set otherwise leave nothing to choose
        return ""
    instead = "; ".join(told[:most])
    more = f"; {len(told) - most} more" if len(told) > most else ""
    return f"Equal within the estimates: this system, and the same with {instead}{more}. Choose by quote and delivery"


def sibling_sentence(result: Result, most: int = 3) -> str:
    """Which other cameras with the same sensor would do as well, the best `most`; empty: there is none."""
    found, best = (result.robustness or {}).get("siblings") or [], result.best
    if best is None or not found:
        return ""
    cost = best.totals.cost

    def told(item: Mapping[str, Any]) -> str:
        value, beside = item.get("value"), ""
        if value is not None and result.objective.name == "cost":
            beside = dearer(value, cost.value, cost.currency).removeprefix(", ")
        elif value is not None:
            beside = f"the system then {objective_text(result, value)}"
        return f"{one_line(item['name'], 60)} ({', '.join(filter(None, [item.get('interface'), beside]))})"

    more = f" and in {len(found) - most} more" if len(found) > most else ""
    counted_by = "" if result.confidence is None else f" {AT_LIKELIEST}"
    meets = "meets" if len(found) == 1 else "each meets"
    names = listed([told(item) for item in found[:most]])
    return f"The camera's sensor is also in {names}{more}: {meets} the mission in its place{counted_by}"


def dearer_by(design: Design, best: Design) -> str:
    """How much more or less a design costs at likeliest prices than the best: `, 400 USD less`; empty: the same.

    With two digits: of prices that are ranges no more is known.
    """
    cost, ours = design.totals.cost, best.totals.cost
    return dearer(cost.value, ours.value, cost.currency) if cost.currency == ours.currency else ""


def dearer(price: float, ours: float, currency: str) -> str:
    """By how much one likeliest price is above or below another; empty where that is next to nothing."""
    more = price - ours
    if abs(more) < WORTH_TELLING * ours:
        return ""
    return f", {money(float(f'{abs(more):.2g}'), currency)} {'more' if more > 0 else 'less'}"


def camera_stand(hardware: UsedHardware) -> str:
    """Which side of the image lies along the motion, and how the cameras of a stereo pair stand."""
    height = {"landscape": "height", "portrait": "width"}.get(hardware.orientation, "height")
    turned = f"{hardware.orientation}: the image's {height} along the motion"
    if hardware.camera_baseline_m is None:
        return turned
    half = 0.5 * hardware.camera_convergence_deg
    inward = f"each turned {half:g}° inward" if half else "side by side, not turned"
    return f"{turned}; ports {hardware.camera_baseline_m:g} m apart across track, {inward}"


def mounts_text(mounts: Sequence[LampPlace]) -> str:
    """Where the lights stand and how far they lean, and which way."""
    if not mounts:
        return ""
    step_m = row_step_m(mounts)
    fore = any(m.x_m or m.z_m or m.tilt_x_deg for m in mounts)
    if fore and step_m is None:
        return "at " + "; ".join(
            f"x {m.x_m:g} m, y {m.y_m:g} m, z {m.z_m:g} m, tilt {m.tilt_x_deg:g}/{m.tilt_y_deg:g} deg"
            for m in mounts
        )
    number = Counter(f"{m.y_m:+g} m" for m in mounts)
    uneven = max(number.values()) > 1  # several lamps at a place
    places = ", ".join(f"{n} at {place}" if uneven else place for place, n in number.items())
    tilt = mounts[0].tilt_y_deg
    if step_m is not None:
        places = ", ".join(f"{n} at {place}" for place, n in number.items())
    row = "" if step_m is None else f", each side in a row, {step_m:g} m apart along track"
    return f"{'' if uneven or row else 'at '}{places} across track{row}" + (
        f", tilted {abs(tilt):g} deg {'outward' if tilt > 0 else 'inward'}" if tilt else ", aimed straight down"
    )


def row_step_m(mounts: Sequence[LampPlace]) -> float | None:
    """How far lamps stand apart that are in a row on each side, alike but for their place in it; None of others."""
    if any(m.z_m or m.tilt_x_deg or m.tilt_y_deg != mounts[0].tilt_y_deg for m in mounts):
        return None
    rows = [sorted(m.x_m for m in mounts if m.y_m == y) for y in {m.y_m for m in mounts}]
    steps = {round(b - a, 6) for row in rows for a, b in pairwise(row)}
    centred = all(abs(row[0] + row[-1]) < 1e-6 for row in rows)
    return steps.pop() if len(steps) == 1 and centred and 0.0 not in steps else None


def missed_names(design: Design) -> list[str]:
    """The requirements that a design does not meet, each once."""
    return list(dict.fromkeys(requirement_name(margin.requirement) for margin in design.missed))


def in_scene(name: str, scenes: Sequence[object]) -> str:
    """Which scene, where there are several."""
    return f" in {one_line(name, 40)}" if len(scenes) > 1 else ""


# ---------------------------------------------------------------- sentences


def capital(text: str) -> str:
    """With a capital letter."""
    return text[:1].upper() + text[1:]


def as_sentence(text: str) -> str:
    """With a capital letter and a full stop."""
    return capital(text) + ("" if text.endswith(".") else ".")


def cost_sentence(design: Design) -> str:
    """`cost 3 600 to 5 300 USD, of which 1 700 to 3 400 estimated`."""
    cost = design.totals.cost
    text = f"cost {cost_text(cost)}"
    if unpriced := n_unpriced(design.bom):
        text += f", without {counted(unpriced, 'part')} of unknown price"
    if not cost.estimated:
        return f"{text}, nothing of it estimated"
    return f"{text}, of which {format_price(cost.estimated_low, cost.estimated_high)} estimated"


def quoted_share(cost: Cost) -> str:
    """How much of a price nobody has quoted: `55 % of it not quoted`."""
    if not cost.estimated or not cost.value:
        return "nothing of it estimated"
    not_quoted = 100.0 * cost.estimated / cost.value
    if not_quoted > 99.5:
        return "none of it quoted" if cost.estimated == cost.value else "hardly any of it quoted"
    return f"{format_number(not_quoted, 2)} % of it not quoted"


def burning_text(design: Design) -> str:
    """`lamps 638 W while they burn`; empty where that is no more than the whole system draws on average."""
    peak = design.totals.light_peak_power_w
    if not peak or peak <= (design.power_as_set_w or 0.0):
        return ""
    return f"lamps {quantity(peak, 'W')} while they {'recharge' if flashes(design) else 'burn'}"


def flashes(design: Design) -> bool:
    """Whether the lamps are flashes, that draw while they recharge."""
    return any(scene.settings.get("flash_energy_j") is not None for scene in design.scenes)


def power_sentence(totals: Totals) -> str:
    """`power 3.05 W (lights 1.15 W on average, 638 W at peak), mass 1.08 kg`."""
    return (
        f"power {quantity(totals.power_w, 'W')}"
        f" (lights {quantity(totals.light_power_w, 'W')} on average,"
        f" {quantity(totals.light_peak_power_w, 'W')} at peak),"
        f" mass {quantity(totals.mass_kg, 'kg')}"
        f"{housing_clause(totals)}"
        f"{used_up_clause(totals)}"
    )


def housing_clause(totals: Totals) -> str:
    """` (cameras in their housings -0.2 kg in water, each 248 x 114 mm, ...)`; nothing without a housing."""
    if totals.mass_water_kg is None or totals.size_mm is None:
        return ""
    length, diameter = (format_number(measure, 3) for measure in totals.size_mm)
    in_water = quantity(totals.mass_water_kg, "kg")
    return f" (cameras in their housings {in_water} in water, each {length} × {diameter} mm{warmth_clause(totals)})"


def warmth_clause(totals: Totals) -> str:
    """`, its air 3 to 8 °C warmer than the water`; nothing where that is not known, or less than a degree."""
    if totals.housing_warmer_k is None or totals.housing_warmer_k[-1] < WARM_K:
        return ""
    low, high = (format_number(kelvin, 2) for kelvin in totals.housing_warmer_k)
    return f", its air {low} to {high} °C warmer than the water"


def used_up_clause(totals: Totals) -> str:
    """`, energy 412 Wh, storage 86 GB, battery lasts 9.7 h` of what the mission lets know; else nothing."""
    said = (
        ("energy", totals.energy_wh, "Wh"), ("storage", totals.storage_gb, "GB"),
        ("battery lasts", totals.endurance_h, "h"), ("the cameras' own batteries last", totals.run_time_h, "h"),
    )  # fmt: skip
    return "".join(f", {name} {quantity(value, unit)}" for name, value, unit in said if value is not None)


def n_unpriced(bom: Sequence[BillRow]) -> int:
    """Pieces that must be bought at a price that nobody knows."""
    return sum(row.to_buy for row in bom if row.unit_price is None)


def objective_text(result: Result, value: float | None, digits: int = 4) -> str:
    """A value of the objective with its unit."""
    return quantity(value, result.objective.unit, digits)


def bound_text(result: Result, value: float | None, gap: float | None) -> str:
    """A value of the objective in the proof; a cost that is proven to the last digit as its range leaves it."""
    if result.objective.name == "cost" and value is not None and result.best is not None and not gap:
        cost = result.best.totals.cost
        return format_within(value, cost.low, cost.high, cost.currency)
    return objective_text(result, value, 6)


def value_text(result: Result, design: Design, value: float | None) -> str:
    """The objective of a design; of a cost its range, for nobody knows it better."""
    if result.objective.name == "cost" and value is not None:
        return cost_text(design.totals.cost)
    return objective_text(result, value)


def axis_text(objective: FrontObjective, point: FrontPoint, digits: int = 4) -> str:
    """The same of a point of a front, in one objective."""
    if objective.name == "cost":
        return cost_text(point.design.totals.cost)
    return quantity(point.values[objective.name], objective.unit, digits)


def status_sentence(result: Result) -> str:
    """What came out, in one sentence."""
    if result.best is not None and result.command == "evaluate" and (missed := len(result.best.missed)):
        return f"{counted(missed, 'requirement')} {'is' if missed == 1 else 'are'} missed"
    if result.status == "feasible" and result.best is not None and not result.best.is_settable:
        return "the exact design meets every requirement, but no settings that can be typed in were found that do"
    if result.status == "feasible" and any(note.code == "better_unsettable" for note in result.warnings):
        return "the best that can be set; by exact numbers that cannot, other parts are better"
    if result.status == "stopped" and result.best is None:
        interrupted = any(warning.code == "interrupted" for warning in result.warnings)
        return f"{'interrupted' if interrupted else 'stopped by a limit'} before a system was found"
    return STATUS_SENTENCES.get(result.status, result.status)


def account_sentence(certificate: Certificate) -> str:
    """Whether every combination is accounted for."""
    gone = sum(item.count for item in certificate.discarded)
    verdict = "adds up" if certificate.adds_up() else "DOES NOT ADD UP, please report it"
    return (
        f"{count_text(certificate.evaluated)} evaluated + {count_text(gone)} discarded"
        f" {'=' if certificate.adds_up() else 'against'} {count_text(certificate.loaded)} loaded: {verdict}"
    )


def run_time_sentence(timing_s: Mapping[str, float]) -> str:
    """`0.43 s (search 0.30 s, report 0.13 s)`, and why these add up to more where some ran side by side."""
    steps = {name: value for name, value in timing_s.items() if name not in ("total", *PARTS_OF_THE_SEARCH)}
    total = timing_s.get("total", sum(steps.values()))
    listed = ", ".join(
        f"{one_line(name.replace('_', ' '))} {quantity(value, 's', 2)}" for name, value in steps.items()
    )
    if sum(steps.values()) > TOGETHER * total:
        listed += "; some of these ran side by side, so they add up to more"
    return quantity(total, "s", 3) + (f" ({listed})" if listed and len(steps) > 1 else "")


def as_bought(ids: Sequence[str]) -> list[str]:
    """Ids of parts with those of a complete camera's pieces as one: `x camera, x lens, x port` is `x`."""
    wholes = {name.removesuffix(" port") for name in ids if name.endswith(" port")}
    told: list[str] = []
    for name in ids:
        stem = next((whole for whole in wholes for piece in PIECES if name == f"{whole} {piece}"), name)
        told += [] if stem in told else [stem]
    return told

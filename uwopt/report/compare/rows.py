"""Rows of a comparison: what is asked, and what each system reaches."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from uwopt.quantities import QUANTITIES
from uwopt.report.text import formats, words
from uwopt.report.text.tables import has_no_limit
from uwopt.results.comparison import Comparison, SideBySide
from uwopt.results.design import PRACTICE_MISSED, Design, Margin
from uwopt.units import counted

#: Limits of the parts themselves, told only where one is missed.
OF_PARTS = (
    "frame_rate", "f_number_min", "f_number_max", "gain_min", "gain_max", "max_exposure_ms", "min_exposure_ms",
    "light_level_max", "light_level", "max_pulse_ms", "min_pulse_ms", "light_duty", "light_rate", "shutter_open_ms",
    "nearest_focus_m", "farthest_focus_m", "port_clears_view_mm", "lamp_trigger", "card_gb", "run_time_h",
    "common_f_number", "common_focus_m",
)  # fmt: skip
FIGURES = (
    "swath_m", "common_swath_m", "depth_error_mm", "gsd_mm", "area_m2_h", "snr_db", "contrast", "dof_m", "blur_px",
    "mean_level", "f_number", "exposure_ms", "flux_lm", "frame_rate_hz", "data_rate_mb_s", "power_w", "light_power_w",
    "information_bit_per_m2",
)  # fmt: skip
SAME_GOAL = 1e-6  # of it, by which values of the goal may differ that are the same
MOST_TOLD = 1000  # letters of what gave way
KNOWN = {one.name: one for one in QUANTITIES}


@dataclass(frozen=True)
class Reached:
    """What one system reaches: a number where there is one, its text, and whether it is met (None: no requirement)."""

    value: float | None
    text: str
    met: bool | None = None


@dataclass(frozen=True)
class ComparedRow:
    """One line of a comparison."""

    scene: str
    key: str
    name: str
    asked: str
    unit: str
    cells: tuple[Reached, ...]


def facts(comparison: Comparison) -> Iterator[ComparedRow]:
    """What each system is, costs, draws and weighs."""
    designs = [one.design for one in comparison.systems]
    goal = comparison.systems[0].result.objective
    values = tuple(Reached(d.objective_value, formats.quantity(d.objective_value, goal.unit, 4)) for d in designs)
    yield ComparedRow("", "objective", f"goal: {goal.name.replace('_', ' ')}", goal.direction, goal.unit, values)
    missed = [{margin.requirement for margin in d.missed} for d in designs]
    verdicts = tuple(Reached(float(len(m)), f"{len(m)} missed" if m else "all met", not m) for m in missed)
    yield ComparedRow("", "requirements", "requirements", "all met", "", verdicts)
    prices = tuple(Reached(d.totals.cost.value, design_price_text(d)) for d in designs)
    yield ComparedRow("", "price", "price", "", designs[0].totals.cost.currency, prices)
    known = [d.totals.mass_kg or None for d in designs]
    masses = tuple(Reached(mass, "unknown" if mass is None else formats.quantity(mass, "kg")) for mass in known)
    yield ComparedRow("", "mass_kg", "mass of what is known", "", "kg", masses)
    for kind in ("camera", "lens", "port", "housing", "light"):
        if all(kind not in design.hardware.parts for design in designs):
            continue
        yield ComparedRow("", kind, kind, "", "", tuple(Reached(None, part_text(d, kind)) for d in designs))


def design_price_text(design: Design) -> str:
    """A price, and whether parts of it are not known."""
    unknown = words.n_unpriced(design.bom)
    if unknown and unknown == sum(row.to_buy for row in design.bom):
        return "unknown"
    return formats.cost_text(design.totals.cost) + (f" without {counted(unknown, 'part')}" if unknown else "")


def part_text(design: Design, kind: str) -> str:
    """A part with its number."""
    hardware = design.hardware
    number = hardware.light_count if kind == "light" else hardware.camera_count
    if not number or kind not in hardware.parts:
        return "none"
    return f"{number} x {words.part_name(hardware.parts[kind])}"


def requirement_rows(comparison: Comparison) -> Iterator[ComparedRow]:
    """Every requirement of every scene that some system has, worst over the altitudes."""
    designs = [one.design for one in comparison.systems]
    for index, first in enumerate(designs[0].scenes):
        scenes = [design.scenes[index] for design in designs]
        held = [margins_of(scene.margins) for scene in scenes]
        names = list(dict.fromkeys(name for margins in held for name in margins))
        for name in names:
            own = [margins.get(name) for margins in held]
            known = [margin for margin in own if margin is not None]
            if name in OF_PARTS and all(margin.satisfied for margin in known):
                continue
            sample = known[0]
            limits = {limit_text(margin) for margin in known}
            asked = limits.pop() if len(limits) == 1 else "by part"
            cells = tuple(cell_of(margin, sample) for margin in own)
            yield ComparedRow(first.name, name, words.requirement_name(name), asked, sample.unit, cells)


def margins_of(margins: Sequence[Margin]) -> dict[str, Margin]:
    """Margins by name; of depth ratings that of the part with the least in hand."""
    found: dict[str, Margin] = {}
    for margin in margins:
        if margin.limit is None:
            continue
        known = found.get(margin.key)
        if known is None or in_hand(margin) < in_hand(known):
            found[margin.key] = margin
    return found


def in_hand(margin: Margin) -> tuple[bool, float]:
    """Orders margins of one requirement: those that are missed first, then by what is left."""
    return margin.satisfied, 0.0 if margin.margin is None else margin.margin


def limit_text(margin: Margin) -> str:
    """What is asked, with its sense."""
    if margin.is_of_fit:
        return "yes"
    sense = {"<=": "at most ", ">=": "at least ", "=": ""}[margin.sense]
    return sense + formats.quantity(margin.limit, margin.unit, 4)


def cell_of(margin: Margin | None, sample: Margin) -> Reached:
    """What a system reaches of a requirement; `sample`: of one that has it."""
    if margin is None:
        return Reached(None, "yes" if sample.is_of_fit else "unknown")
    endless = margin.value is None and not margin.word and has_no_limit(margin)
    return Reached(margin.value, "infinite" if endless else formats.margin_ends(margin)[0], margin.satisfied)


def compared_figures(comparison: Comparison) -> Iterator[ComparedRow]:
    """Figures at the nominal altitude that are worth a look beside the requirements."""
    designs = [one.design for one in comparison.systems]
    for index, first in enumerate(designs[0].scenes):
        for key in FIGURES:
            scenes = [design.scenes[index] for design in designs]
            values = [scene.figures.get(key, scene.settings.get(key)) for scene in scenes]
            if not any(isinstance(value, (int, float)) for value in values):
                continue
            known, one = [None if value is None else float(value) for value in values], KNOWN[key]
            endless = [key == "dof_m" and scene.figures.get("dof_far_is_infinite") is True for scene in scenes]
            cells = tuple(
                Reached(value, "infinite" if is_endless else formats.quantity(value, one.unit))
                for value, is_endless in zip(known, endless, strict=True)
            )
            yield ComparedRow(first.name, key, one.words, "", one.unit, cells)


# ---------------------------------------------------------------- why


def sentences(comparison: Comparison) -> Iterator[str]:
    """What each system misses; and set against the recommended one what it does better, and why it is not chosen."""
    best = next((one for one in comparison.systems if one.recommended), None)
    if comparison.gave_way:
        yield f"All are held to what is recommended, and no more: {formats.one_line(comparison.gave_way, MOST_TOLD)}."
    for one in comparison.systems:
        if one is best:
            continue
        name = formats.one_line(one.name, 80)
        missed = words.missed_names(one.design)
        verdict = f"misses {words.listed(missed)}" if missed else "meets everything"
        yield f"{words.capital(name)} {verdict}."
        yield from (words.as_sentence(note.message) for note in one.result.warnings if note.code == PRACTICE_MISSED)
        if best is not None:
            yield from against(one, best, bool(missed))
    if comparison.nothing_fits:
        yield "Nothing is recommended: no system of the catalogue meets every requirement; solve tells what would help."
    if comparison.cut_short:
        yield "Nothing is recommended: the time was over before a system was found."
    elif best is not None and best.result.status == "stopped":
        yield "What is recommended is the best that was found in time; others may be better."


def against(one: SideBySide, best: SideBySide, missed: bool) -> Iterator[str]:
    """A system set against the recommended one: better by the goal and why it may be, and better beside it."""
    goal, ours, theirs = best.result.objective, one.design.objective_value, best.design.objective_value
    sign = 1.0 if goal.direction == "minimise" else -1.0
    if ours is not None and theirs is not None and sign * (ours - theirs) < -SAME_GOAL * abs(theirs):
        values = formats.quantities_apart(ours, theirs, unit=goal.unit)
        reasons = [*(["it does not do what is asked"] if missed else []), *outside_reasons(one)]
        why = "; ".join(reasons) or "the search of the catalogue does not hold it"
        yield f"By the goal it is better, {values[0]} against {values[1]}: {why}."
    elif ours is not None and theirs is not None:
        values = formats.quantities_apart(ours, theirs, unit=goal.unit)
        is_as_good = abs(ours - theirs) <= SAME_GOAL * abs(theirs)
        word, values_told = "as good" if is_as_good else "better", f"{values[1]} against {values[0]}"
        yield f"By the goal the recommended one is {word}: {values_told}."
    gains = [*better_figures(one.design, best.design, goal.name)]
    if gains:
        yield f"It has more to show in {words.listed(gains)}, which the goal does not reward beyond what is asked."


def outside_reasons(one: SideBySide) -> list[str]:
    """Why a system is none of those that were searched."""
    own = [*one.result.warnings, *one.design.warnings]
    return list(dict.fromkeys(formats.one_line(note.message, 200) for note in own if note.code == "outside_search"))


def better_figures(one: Design, best: Design, goal: str) -> Iterator[str]:
    """Figures in which a system is better by 5 % or more in every scene, with both numbers; not that of the goal."""
    for key in ("swath_m", "gsd_mm", "area_m2_h", "snr_db", "dof_m", "blur_px", "data_rate_mb_s", "contrast"):
        known = KNOWN[key]
        told = [(a.figures.get(key), b.figures.get(key)) for a, b in zip(one.scenes, best.scenes, strict=True)]
        pairs = [(float(a), float(b)) for a, b in told if a is not None and b is not None]
        if known.term == goal or len(pairs) < len(told):
            continue
        shares = [(a - b) / max(abs(b), 1e-12) for a, b in pairs]
        if all((share if known.better == "more" else -share) >= 0.05 for share in shares):
            ours, theirs = formats.quantities_apart(*pairs[0], unit=known.unit)
            yield f"{known.words} ({ours}, not {theirs})"

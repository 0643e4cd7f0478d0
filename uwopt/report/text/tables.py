"""A result as aligned text for people: the recommendation first, then why it may be trusted.

Everything shown comes from the result; no verdict is added here. Texts from files are shown as they
are, never read as markup.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from uwopt.quantities import AT_LIKELIEST
from uwopt.report.text import formats, vocabulary, words
from uwopt.report.text.doubts import (
    assumption_blocks,
    certificate_block,
    robustness_block,
    second_opinion_block,
)
from uwopt.report.text.exactness import exactness_block, has_errors
from uwopt.report.text.frame import frame_facts
from uwopt.report.text.helps import notes_beside
from uwopt.report.text.knee import knee_blocks
from uwopt.report.text.layout import Block, Grid, Line, Text, block, columns, fact_lines, sentence
from uwopt.report.text.nothing_fits import infeasible_block, miss_sentence
from uwopt.report.text.prices import price_blocks
from uwopt.results.design import BillRow, Cost, Design, Margin, Note, SceneResult
from uwopt.results.result import Result

if TYPE_CHECKING:
    from uwopt.results.front import FrontResult

ONE_COLUMN_A_SCENE = 3  # more scenes are shown one a row


def system_blocks(result: Result) -> Iterator[Block]:
    """What is recommended or given, in full; or why there is none, and what comes nearest."""
    if result.best is not None:
        yield from design_blocks(result, result.best)
    if result.infeasible:
        yield infeasible_block(result)
        miss = nearest_miss(result)
        if miss is not None:
            yield hardware_block(miss, "Nearest miss", note=miss_sentence(result))
            yield from margin_blocks(miss)


def proof_blocks(result: Result) -> Iterator[Block | Text]:
    """What stands behind it: other choices, the proof, what requirements cost, how firm it is, what it assumes."""
    yield from runner_up_blocks(result)
    yield from argument_blocks(result)
    if has_errors(result):
        yield exactness_block(result)
    yield from assumption_blocks(result)
    yield from warning_blocks(result)
    if result.timing_s:
        yield sentence(f"Took {words.run_time_sentence(result.timing_s)}.", style="dim")


def argument_blocks(result: Result) -> Iterator[Block]:
    """The proof, what more of power, money and requirements would do, how firm it is, and what others say."""
    if result.certificate is not None:
        yield certificate_block(result, result.certificate)
    yield from knee_blocks(result)
    yield from price_blocks(result)
    if result.robustness:
        yield robustness_block(result)
    if result.solvers or result.audit:
        yield second_opinion_block(result)


def nearest_miss(result: Result | FrontResult) -> Design | None:
    """The design that came nearest to feasible."""
    return result.infeasible.nearest_miss if result.infeasible is not None else None


def status_style(result: Result) -> str:
    """How the status of a result is printed."""
    good = "bold green"
    if result.confidence is not None and not result.confidence.enough:
        return "bold red"
    return {"optimal": good, "feasible": good, "stopped": "bold yellow"}.get(result.status, "bold red")


# ---------------------------------------------------------------- one design


def design_blocks(result: Result, design: Design) -> Iterator[Block]:
    """Hardware, settings, margins, cost and bill of materials of one design."""
    yield hardware_block(design, "Recommendation" if result.command == "solve" else "System")
    yield settings_block(result, design)
    yield from margin_blocks(design)
    if facts := frame_facts(design.as_set.scenes):
        yield block("The image as a whole", [fact_lines(facts)])
    yield totals_block(design.as_set)
    if design.bom:
        yield bom_block(design)


def hardware_block(design: Design, title: str, note: Text | None = None) -> Block:
    """Which parts, how many, and how they stand."""
    hardware = design.hardware
    table = columns(("part", "left"), ("", "right"), ("name", "left"), ("id", "left"), header=False)
    for kind, part in hardware.named.items():
        count = hardware.light_count if kind == "light" else hardware.camera_count
        own_id = formats.one_line(part.id or "inline", 60)
        table.add_row(Text(kind), Text(f"{count} x"), Text(words.part_name(part)), Text(own_id))
    facts = [
        ("orientation", words.camera_stand(hardware)),
        ("lights", words.mounts_text(hardware.light_mounts)),
    ]
    return block(title, [*([note] if note else []), table, fact_lines(facts)])


def settings_block(result: Result | FrontResult, design: Design) -> Block:
    """What to set: rounded values where there are any, the exact ones beside them."""
    scenes = scenes_to_set(design)
    rounded = any(scene.settings_to_set for scene in scenes)
    lines: list[Line] = [settings_table(scenes), *rounding_lines(result, design)]
    return block("Settings to type in" if rounded else "Settings", lines)


def scenes_to_set(design: Design) -> list[SceneResult]:
    """The scenes without settings to set that miss a requirement, which are nothing to offer."""
    if design.is_settable:
        return design.scenes
    return [replace(scene, settings_to_set=None) for scene in design.scenes]


def settings_table(scenes: Sequence[SceneResult], *, exact: bool = True) -> Grid:
    """The settings of all scenes in the form that fits their number; of one scene the exact optimum too if wanted."""
    few = len(scenes) <= ONE_COLUMN_A_SCENE
    return settings_by_column(scenes, exact=exact) if few else settings_by_row(scenes)


def shown_settings(scenes: Sequence[SceneResult]) -> list[str]:
    """Names of the settings that any scene has, in the order of setting them; how long a flash lasts is none."""
    present = {
        name for s in scenes for name, value in s.settings.items() if value is not None and name != "gain"
    }
    if "flash_energy_j" in present:
        present.discard("pulse_ms")
    return [name for name in vocabulary.SETTINGS if name in present]


def settings_by_column(scenes: Sequence[SceneResult], *, exact: bool) -> Grid:
    """One row a setting; one column a scene, and the exact value of a single scene."""
    exact_too = exact and len(scenes) == 1 and scenes[0].settings_to_set is not None
    heads = [("setting", "left")] + [
        (formats.one_line(scene.name, 24) if len(scenes) > 1 else "set", "right") for scene in scenes
    ]
    table = columns(
        *heads, *([("exact optimum", "right")] if exact_too else []), header=len(scenes) > 1 or exact_too
    )
    for name in shown_settings(scenes):
        cells = [formats.setting_text(name, (s.settings_to_set or s.settings).get(name)) for s in scenes]
        if exact_too:
            cells.append(formats.setting_text(name, scenes[0].settings.get(name)))
        table.add_row(Text(vocabulary.SETTINGS[name][0]), *map(Text, cells))
    return table


def settings_by_row(scenes: Sequence[SceneResult]) -> Grid:
    """One row a scene."""
    names = shown_settings(scenes)
    table = columns(("scene", "left"), *((vocabulary.SETTINGS[name][0].split(",")[0], "right") for name in names))
    for scene in scenes:
        chosen = scene.settings_to_set or scene.settings
        table.add_row(
            Text(formats.one_line(scene.name, 24)), *(Text(formats.setting_text(n, chosen.get(n))) for n in names)
        )
    return table


def rounding_lines(result: Result | FrontResult, design: Design) -> list[Line]:
    """What rounding to settable values costs, and whether it still fits."""
    rounded = design.rounded
    if rounded is None and isinstance(result, Result) and result.command == "solve":
        text = "These are exact values, not settings to type in: for these no time was left; --seconds gives more."
        return [sentence(text, "red")]
    if not rounded:
        return []
    if not design.is_settable:
        missed = ", ".join(words.requirement_name(name) for name in rounded.missed)
        return [
            sentence(
                "These are exact values, not settings to type in: no stop of the lens with steps of time, gain "
                "and light was found that meets every requirement. The nearest misses "
                f"{missed or 'some requirements'}.",
                "red",
            )
        ]
    value, exact = rounded.objective_value, design.objective_value
    if value is None or exact is None or not isinstance(result, Result):
        return [sentence("Rounded as shown and checked again: every requirement still holds.")]
    held = "Rounded as shown and checked again: every requirement still holds"
    moved = formats.change(value - exact, result.objective.unit, exact)
    told = words.value_text(result, design, value)
    if moved == formats.change(0.0, result.objective.unit, exact):
        return [sentence(f"{held}; the objective stays {told}.")]
    return [sentence(f"{held}; the objective becomes {told} ({moved}).")]


def margin_blocks(design: Design) -> Iterator[Block]:
    """Every margin, scene by scene, at the settings to set; what is the same in all scenes once, for the system."""
    scenes, exact = design.as_set.scenes, exact_margins(design)
    if len(scenes) == 1:
        yield block("Margins", margin_lines(scenes[0].margins, design, exact[0]))
        return
    common = common_margins(scenes)
    for scene, own_exact in zip(scenes, exact, strict=True):
        own = [margin for margin in scene.margins if margin not in common]
        yield block(f"Margins in scene {formats.one_line(scene.name, 60)}", margin_lines(own, design, own_exact))
    if common:
        yield block("Margins in every scene", margin_lines(common, design, exact[0]))


def exact_margins(design: Design) -> list[dict[str, Margin]]:
    """By scene the margins of the exact optimum, where those shown are of the settings to set; else none."""
    if design.as_set is design:
        return [{} for _ in design.scenes]
    return [{margin.requirement: margin for margin in scene.margins} for scene in design.scenes]


def common_margins(scenes: Sequence[SceneResult]) -> list[Margin]:
    """Margins that are the same in all scenes."""
    first, *rest = scenes
    return [margin for margin in first.margins if all(margin in other.margins for other in rest)]


def margin_lines(margins: Sequence[Margin], design: Design, exact: Mapping[str, Margin]) -> list[Line]:
    """The table, and how much of its limits is kept in reserve."""
    return [margin_table(margins, design, exact), *reserve_lines(margins, design)]


def missed_lines(margins: Sequence[Margin], design: Design) -> list[Line]:
    """What is missed, reached and asked, and how much of that is kept in reserve."""
    table = columns(("requirement", "left"), ("value", "right"), ("asked", "right"))
    for margin in margins:
        table.add_row(*map(Text, margin_texts(margin, kinds_by_id(design), design.totals.cost)[:3]))
    return [table, *reserve_lines(margins, design)]


def reserve_lines(margins: Sequence[Margin], design: Design) -> list[Line]:
    """How much of their limits is kept in reserve; none where nothing is."""
    kinds = kinds_by_id(design)
    kept = [
        f"{words.requirement_name(m.requirement, kinds)} {formats.reserve_text(m)}" for m in margins if m.reserve
    ]
    return [sentence(f"In these limits: {'; '.join(kept)}.")] if kept else []


def margin_table(margins: Sequence[Margin], design: Design, exact: Mapping[str, Margin]) -> Grid:
    """One row a requirement that applies: value, limit, what is left, where it is worst, and the exact optimum's."""
    kinds, cost = kinds_by_id(design), design.totals.cost
    table = columns(
        ("requirement", "left"), ("value", "right"), ("limit", "right"), ("margin", "right"),
        ("worst at", "right"), *([("exact", "right")] if exact else []), ("", "left"),
    )  # fmt: skip
    for margin in margins:
        if has_no_limit(margin):
            continue
        optimum = exact.get(margin.requirement)
        mark = MARKS[margin_state(margin, optimum)]
        beside = [exact_text(margin, optimum, cost)] if exact else []
        table.add_row(*map(Text, (*margin_texts(margin, kinds, cost), *beside)), mark)
    return table


def exact_text(margin: Margin, exact: Margin | None, cost: Cost | None) -> str:
    """What the exact optimum reaches of a requirement; "" where that is what is reached as set."""
    if exact is None or exact.value == margin.value:
        return ""
    return formats.margin_ends(exact, cost)[0]


#: What stands behind a margin.
MARKS = {"met": Text(""), "binding": Text("at its limit", "yellow"), "missed": Text("MISSED", "bold red")}


def has_no_limit(margin: Margin) -> bool:
    """Whether there is infinite room: this lamp or camera has no such limit."""
    return margin.satisfied and margin.margin is None


def margin_state(margin: Margin, exact: Margin | None = None) -> str:
    """met | binding | missed; what binds the exact optimum is at its limit but for what rounding leaves of it."""
    if not margin.satisfied:
        return "missed"
    return "binding" if margin.binding or (exact is not None and exact.binding) else "met"


def margin_texts(margin: Margin, kinds: Mapping[str, str], cost: Cost | None) -> tuple[str, str, str, str, str]:
    """Requirement, value, limit, what is left, and the altitude where it is worst."""
    sign = "" if margin.is_of_fit else {"<=": "at most ", ">=": "at least "}.get(margin.sense, "exactly ")
    value, limit = formats.margin_ends(margin, cost)
    return (
        words.requirement_name(margin.requirement, kinds),
        value,
        "no limit" if margin.limit is None else sign + limit,
        formats.margin_text(margin, cost),
        "" if margin.at_altitude_m is None else formats.quantity(margin.at_altitude_m, "m"),
    )


def kinds_by_id(design: Design) -> dict[str, str]:
    """Which kind of part an id names."""
    return {part.id: kind for kind, part in design.hardware.parts.items()}


def totals_block(design: Design) -> Block:
    """Cost, power and mass in two lines."""
    lines: list[Line] = [sentence(words.cost_sentence(design)), sentence(words.power_sentence(design.totals))]
    return block("Cost, power and mass", lines)


def bom_block(design: Design) -> Block:
    """What to order; below each id its price and how that is known, so that the line never breaks an id."""
    table = columns(("", "right"), ("part", "left"), ("id, and what it costs below it", "left"))
    for row in design.bom:
        line = bom_line(row)
        each = f"{line.each} each" if row.to_buy != 1 else ""
        costs = [each, f"{line.due} to pay" if row.to_buy else "", line.known]
        if row.unit_price is None:
            costs = ["price unknown", f"{row.owned} owned" if row.owned else ""]
        table.add_row(Text(line.number), Text(line.kind), Text(line.id))
        table.add_row(Text(""), Text(""), Text(", ".join(word for word in costs if word), "dim"))
    noted = [row for row in design.bom if row.note]
    notes = [sentence(f"{formats.one_line(row.id, ID_LENGTH)}: {formats.one_line(row.note, 600)}") for row in noted]
    if unsure := [formats.one_line(row.id, ID_LENGTH) for row in design.bom if row.availability == "unknown"]:
        notes.append(sentence(f"Ask whether it is still sold, nobody says so: {', '.join(unsure)}."))
    legend = [sentence(ESTIMATED_LEGEND, "dim")] if any(row.estimated for row in design.bom) else []
    return block("Bill of materials", [table, *legend, *notes])


ID_LENGTH = 200  # of an id that is copied: longer than any
ESTIMATED_LEGEND = "no quote: the range is that of parts of its class"


@dataclass(frozen=True)
class BomLine:
    """One row of a bill of materials in words."""

    number: str
    kind: str
    id: str
    each: str
    due: str
    known: str  # status of the price, its date, how many are owned
    estimated: bool


def bom_line(row: BillRow) -> BomLine:
    """What to order, its price and how that is known."""
    ends = formats.price_ends(row)
    known = [formats.known_price(row), f"{row.owned} owned" if row.owned else ""]
    return BomLine(
        str(row.count),
        formats.one_line(row.kind, 12),
        formats.one_line(row.id, ID_LENGTH),
        "unknown" if ends is None else formats.price_text(*ends, row.currency),
        formats.due_text(row),
        formats.one_line(", ".join(word for word in known if word), 60),
        row.estimated,
    )


# ---------------------------------------------------------------- other designs


def runner_up_blocks(result: Result) -> Iterator[Block]:
    """Other hardware, what it would cost in the objective, and what parts to be made could gain."""
    best = result.best
    if best is None:
        return
    if result.runners_up:
        lines: list[Line] = [runner_up_table(result, best, result.runners_up)]
        if words.by_likeliest_values(result):
            lines.append(sentence(LIKELIEST_LEGEND, "dim"))
        yield block("Runners-up, by what differs from the recommendation", lines)
    if result.generic_alternative is not None:
        table = runner_up_table(result, best, [result.generic_alternative])
        note = sentence(
            "To be made: a class of parts that no shop sells under a name; figures and prices are of the class.",
            "dim",
        )
        yield block("With parts to be made", [table, note])


LIKELIEST_LEGEND = (
    f"{AT_LIKELIEST.capitalize()}, as differences from the best so; what is recommended was chosen by what holds in "
    "the scenarios, with its iris where they want it."
)


def runner_up_table(result: Result, best: Design, designs: Sequence[Design]) -> Grid:
    """One row a design."""
    objective = formats.one_line(result.objective.name.replace("_", " "), 24)
    heads = [("", "right"), ("has instead", "left"), (objective, "right"), ("difference", "right")]
    shown = [name for name in ("cost", "power") if name != objective]
    table = columns(*heads, *((name, "right") for name in shown))
    for number, design in enumerate(designs, start=2):
        figures = {
            "cost": formats.cost_text(design.totals.cost),
            "power": formats.quantity(design.totals.power_w, "W"),
        }
        table.add_row(
            Text(str(number)),
            Text(words.differing_parts(design, best)),
            Text(words.value_text(result, design, design.objective_value)),
            Text(difference_text(result, design)),
            *(Text(figures[name]) for name in shown),
        )
    return table


def difference_text(result: Result, design: Design) -> str:
    """How much the objective differs from that of the best design by the same numbers."""
    best = words.central_best(result)
    if design.objective_value is None or best is None:
        return formats.quantity(None)
    difference = design.objective_value - best
    text = formats.change(difference, result.objective.unit, best)
    if best and abs(difference) > 1e-9 * abs(best):
        text += f" ({formats.signed_share(difference / abs(best))})"
    return text


def warning_blocks(result: Result | FrontResult) -> Iterator[Block]:
    """What the user should know of the input and the hardware."""
    best = result.best if isinstance(result, Result) else None
    own = best.warnings if best is not None else []
    texts = dict.fromkeys(warning_text(item) for item in [*notes_beside(result), *own])
    if texts:
        yield block("Warnings", [sentence("- " + text) for text in texts])


def warning_text(warning: Note) -> str:
    """One warning with what it is about."""
    subject, message = words.note_subject(warning.path), words.note_text(warning)
    about = not subject or message.casefold().startswith(subject.casefold())
    return words.capital(message) if about else f"{words.capital(subject)}: {message}"

"""What a page shows of one design and of the whole result, as plain values that the template lays out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import urlsplit

from uwopt.quantities import BY_NAME
from uwopt.report.text import formats, vocabulary, words
from uwopt.report.text.doubts import plain_fact
from uwopt.report.text.frame import frame_facts
from uwopt.report.text.layout import Block
from uwopt.report.text.tables import (
    ESTIMATED_LEGEND,
    bom_line,
    exact_margins,
    exact_text,
    hardware_block,
    has_no_limit,
    kinds_by_id,
    margin_state,
    margin_texts,
    settings_block,
)
from uwopt.results.basis import OtherMaker
from uwopt.results.design import BillRow, Cost, Design, Margin
from uwopt.results.front import FrontResult
from uwopt.results.result import Result
from uwopt.units import counted, format_number, is_number, unit_suffix

#: Key figures.
FIGURES = ("snr_db", "gsd_mm", "dof_m", "frame_rate_hz", "swath_m")
AT_NOMINAL = ("snr_db", "gsd_mm", "swath_m")  # of them, what another altitude changes
DIGITS = 3
FULL_BAR, LEFT_END = 1.0, -0.3333  # room to a limit that fills the bar; as far as a miss is drawn


@dataclass(frozen=True)
class Card:
    """One key figure."""

    title: str
    value: str
    note: str = ""


@dataclass(frozen=True)
class BomRow:
    """One row of the bill of materials."""

    number: str
    kind: str
    name: str
    id: str
    each: str
    due: str
    status: str
    mark: str  # good | warn | bad: how well the price is known
    basis: str
    sources: list[tuple[str, str]]  # what is shown, and the page it leads to, "" where it is none
    purpose: str  # what it was made for
    note: str  # limits of its use, and whether it is still sold
    checked: str  # when it was held against the source


@dataclass(frozen=True)
class Bar:
    """One margin: its texts, and the room to the limit as a share of it."""

    name: str
    value: str
    limit: str
    left: str
    at: str
    state: str  # met | binding | missed
    room: float | None
    room_text: str
    exact: str = ""  # what the exact optimum reaches, where that is not what is reached as set

    @property
    def start(self) -> float:
        """Where the bar begins, per cent of the track."""
        return track(min(0.0, self.room or 0.0))

    @property
    def width(self) -> float:
        """How long it is, per cent of the track."""
        return track(max(0.0, self.room or 0.0)) - self.start


@dataclass(frozen=True)
class SceneBars:
    """Margins of one scene."""

    name: str
    bars: list[Bar]
    binding: str
    frame: list[tuple[str, str]]  # the image as a whole, in words
    beside_exact: bool = False  # whether the exact optimum's values stand beside them


@dataclass(frozen=True)
class DesignPart:
    """All that a page shows of one design."""

    name: str
    id: str
    definition: str
    cards: list[Card]
    hardware: Block
    settings: Block
    bom: list[BomRow]
    legend: str
    total: str
    scenes: list[SceneBars]
    figures: list[tuple[str, list[str]]]
    scene_names: list[str]
    goals: Sequence[str] = ()  # of a front's pick, its objectives as its cards have them
    pictures: list[Any] = field(default_factory=list)


def design_part(
    result: Result | FrontResult, design: Design, name: str, *, part_id: str = "", definition: str = "",
    goals: Sequence[str] = (),
) -> DesignPart:  # fmt: skip
    """One design, laid out for the page."""
    rows = [bom_row(row) for row in design.bom]
    doubtful = any(row.mark == "warn" for row in rows)
    return DesignPart(
        name=name, id=part_id, definition=definition, cards=cards(design.as_set),
        hardware=hardware_block(design, "Hardware"), settings=settings_block(result, design), bom=rows,
        legend=ESTIMATED_LEGEND if doubtful else "",
        total=words.as_sentence(words.cost_sentence(design)),
        scenes=list(scene_bars(design)), figures=figures_in_words(design.as_set),
        scene_names=[formats.one_line(scene.name, 60) for scene in design.scenes], goals=goals,
    )  # fmt: skip


# ---------------------------------------------------------------- figures


def cards(design: Design) -> list[Card]:
    """The key figures of a design; of several scenes, from the least to the most."""
    totals, cost = design.totals, design.totals.cost
    notes = [words.quoted_share(cost)]
    if unpriced := words.n_unpriced(design.bom):
        notes.append(f"without {counted(unpriced, 'part')} of unknown price")
    shown = [
        Card("Cost", formats.cost_text(cost), ", ".join(notes)),
        Card("Power", formats.quantity(design.power_as_set_w, "W"), words.burning_text(design)),
    ]
    for name in FIGURES:
        values = [scene_value(scene.figures, scene.settings, name) for scene in design.scenes]
        text = formats.span(values, BY_NAME[name].unit, DIGITS)
        if name == "dof_m" and any(scene.figures.get("dof_far_is_infinite") for scene in design.scenes):
            text = "infinite" if all(value is None for value in values) else f"{text} and more"
        if text:
            notes = ["mean over the frame"] if name == "snr_db" else []
            notes += ["at the nominal altitude"] if name in AT_NOMINAL else []
            notes += ["over all scenes"] if " to " in text else []
            shown.append(Card(BY_NAME[name].words.capitalize(), text, ", ".join(notes)))
    if totals.mass_kg is not None:
        shown.append(Card("Mass", formats.quantity(totals.mass_kg, "kg")))
    for name, value, unit in (
        ("Energy", totals.energy_wh, "Wh"), ("Storage", totals.storage_gb, "GB"),
        ("Battery lasts", totals.endurance_h, "h"), ("Cameras' own batteries last", totals.run_time_h, "h"),
    ):  # fmt: skip
        if value is not None:
            shown.append(
                Card(name, formats.quantity(value, unit), "over the whole mission" if unit != "h" else "")
            )
    return shown


def scene_value(figures: Mapping[str, Any], settings: Mapping[str, Any], name: str) -> float | None:
    """A figure of a scene, or a setting where no figure has that name."""
    value = figures.get(name, settings.get(name))
    return float(value) if is_number(value) else None


def figures_in_words(design: Design) -> list[tuple[str, list[str]]]:
    """Every figure in words, one column a scene; what no scene has is left out."""
    names = dict.fromkeys(name for scene in design.scenes for name in scene.figures)
    rows = []
    for name in names:
        values = [scene.figures.get(name) for scene in design.scenes]
        if all(value is None for value in values):
            continue
        rows.append((formats.one_line(name, 60), [figure_text(value, unit_suffix(name)) for value in values]))
    return rows


def figure_text(value: Any, unit: str) -> str:
    """One figure in words."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (int, float)):
        return formats.quantity(float(value), unit, 4)
    return formats.quantity(None) if value is None else formats.one_line(value, 80)


# ---------------------------------------------------------------- margins


def scene_bars(design: Design) -> Iterator[SceneBars]:
    """Margins scene by scene, as set: first what is missed, then what binds, then by the room left."""
    kinds, cost = kinds_by_id(design), design.totals.cost
    order = {"missed": 0, "binding": 1, "met": 2}
    for scene, exact in zip(design.as_set.scenes, exact_margins(design), strict=True):
        bars = [bar(m, kinds, cost, exact.get(m.requirement)) for m in scene.margins if not has_no_limit(m)]
        bars.sort(key=lambda b: (order[b.state], 9e9 if b.room is None else b.room))
        names = list(dict.fromkeys(b.name for b in bars if b.state == "binding"))
        missed = list(dict.fromkeys(b.name for b in bars if b.state == "missed"))
        said = [
            f"{head}: {'; '.join(own)}." for head, own in (("Missed", missed), ("At its limit", names)) if own
        ]
        yield SceneBars(formats.one_line(scene.name, 60), bars, " ".join(said), frame_facts([scene]), bool(exact))


def bar(margin: Margin, kinds: Mapping[str, str], cost: Cost | None = None, exact: Margin | None = None) -> Bar:
    """One margin as a bar; without a limit other than 0, or met exactly by rule, there is no bar."""
    name, value, limit, left, at = margin_texts(margin, kinds, cost)
    limit += f" ({formats.reserve_text(margin)})" if margin.reserve else ""
    room = relative_room(margin)
    text = "" if room is None else formats.share(0.0 if abs(room) < 1e-6 and margin.satisfied else room)
    if room is not None and room > 99.5:
        text = f"{format_number(1 + room, 2)} times"
    state, beside = margin_state(margin, exact), exact_text(margin, exact, cost)
    return Bar(name, value, limit, left, at, state, room, text, beside)


def relative_room(margin: Margin) -> float | None:
    """What is left as a share of the limit; below 0 where it is missed."""
    if margin.margin is None or not margin.limit or margin.sense not in ("<=", ">="):
        return None
    return margin.margin / abs(margin.limit)


def track(room: float) -> float:
    """Place of a share of room on a bar's track, per cent."""
    inside = min(max(room, LEFT_END), FULL_BAR)
    return round(100.0 * (inside - LEFT_END) / (FULL_BAR - LEFT_END), 2)


# ---------------------------------------------------------------- bill of materials


def bom_row(row: BillRow) -> BomRow:
    """One part to buy, with its source as a link where it is a page."""
    line = bom_line(row)
    name = formats.one_line(f"{row.manufacturer} {row.model}".strip() or line.id, 80)
    mark = "bad" if row.unit_price is None else "warn" if line.estimated else "good"
    texts = [text.strip() for text in formats.one_line(row.source, 2000).split(" | ") if text.strip()]
    sources = [(link_text(link) if (link := web_link(text)) else text, link) for text in texts]
    return BomRow(
        line.number, line.kind, name, "" if line.id == name else line.id, line.each, line.due, line.known, mark,
        formats.one_line(row.price_basis, 300), sources, formats.one_line(row.purpose, 60),
        formats.one_line("; ".join(filter(None, (row.note.rstrip("."), STILL_SOLD.get(row.availability)))), 600),
        formats.one_line(row.checked, 10),
    )  # fmt: skip


STILL_SOLD = {"unknown": "whether it is still sold is not known", "discontinued": "no longer sold"}


def link_text(link: str) -> str:
    """The site, and the end of the way there."""
    parts = urlsplit(link)
    site, way = (parts.hostname or "").removeprefix("www."), parts.path.strip("/").split("/")
    end = way[-1] if len(way[-1]) <= 36 else "…" + way[-1][-35:]
    return site + ("/…" if len(way) > 1 else "") + (f"/{end}" if end else "")


def web_link(source: str) -> str:
    """The address that a source leads to; "" where it is none of the web.

    `www.x.com/page` and `x.com/page` get https; anything but http and https is no link.
    """
    text = source.strip()
    if not text or any(c.isspace() or c in "<>\"'`\\" for c in text):
        return ""
    if "://" not in text:
        host = text.partition("/")[0]
        named = text.startswith("www.") or ("/" in text and "." in host.strip("."))
        if not named or ":" in host or "@" in host:
            return ""
        text = f"https://{text}"
    try:
        parts = urlsplit(text)
    except ValueError:
        return ""
    return text if parts.scheme in ("http", "https") and parts.hostname and not parts.username else ""


# ---------------------------------------------------------------- what was not chosen


@dataclass(frozen=True)
class Alternative:
    """One maker's best system, or several makers that one reason keeps out, and why it was not chosen."""

    makers: str
    kind: str
    parts: list[str]
    values: list[str]
    outcome: str
    mark: str
    text: str


OUTCOMES = {"worse": "warn", "dominated": "warn", "infeasible": "bad", "not allowed": ""}
KEPT_OUT = "not allowed"


def alternatives(result: Result | FrontResult) -> tuple[list[str], list[tuple[str, list[Alternative]]]]:
    """Heads of the objectives; then well-known makers: those with a chance first, those kept out last."""
    items = result.alternatives
    names = list(dict.fromkeys(name for item in items for name in item.values))
    groups: dict[tuple[str, ...], list[OtherMaker]] = {}
    for number, item in enumerate(items):
        alone = str(number) if item.hardware else ""
        key = (alone, item.outcome, item.kind, reason_text(item))
        groups.setdefault(key, []).append(item)
    many_first = sorted(groups.values(), key=lambda own: -len(own))
    rows = [alternative(result, own, names) for own in many_first]
    rows.sort(key=lambda row: (not row.parts, row.kind.removesuffix("s")))
    tried = [row for row in rows if row.outcome != KEPT_OUT]
    kept_out = [row for row in rows if row.outcome == KEPT_OUT]
    parts = (("The best of other makers", tried), ("Makers that were not in the choice", kept_out))
    return [formats.one_line(name.replace("_", " "), 24) for name in names], [p for p in parts if p[1]]


def alternative(
    result: Result | FrontResult, items: Sequence[OtherMaker], names: Sequence[str]
) -> Alternative:
    """One row: a maker with its system, or all makers of one reason."""
    units = (
        {o.name: o.unit for o in result.objectives}
        if isinstance(result, FrontResult)
        else {result.objective.name: result.objective.unit}
    )
    item = items[0]
    outcome, kind = formats.one_line(item.outcome, 30), formats.one_line(item.kind, 20)
    return Alternative(
        ", ".join(formats.one_line(item.maker, 60) for item in items), kind + "s" * (len(items) > 1),
        [formats.one_line(part, 80) for part in (item.hardware or {}).values()],
        [formats.quantity(item.values.get(name), units.get(name, ""), 4) for name in names],
        outcome, OUTCOMES.get(outcome, "warn"), reason_text(item),
    )  # fmt: skip


def reason_text(item: OtherMaker) -> str:
    """Why one maker's system was not chosen; where nothing fits, what stands in its way last."""
    if item.text:
        return formats.one_line(item.text, 500)
    return f"no combination fits; the last obstacle: {words.rule_name(item.rule)}" if item.rule else ""


# ---------------------------------------------------------------- run


@dataclass(frozen=True)
class Stage:
    """A stage of the run and its share of the time."""

    name: str
    seconds: str
    share_pct: float


def stages(timing_s: Mapping[str, float]) -> list[Stage]:
    """Time by stage, in the order in which they ran."""
    steps = {k: v for k, v in timing_s.items() if k not in ("total", *vocabulary.PARTS_OF_THE_SEARCH)}
    longest = max(steps.values(), default=0.0) or 1.0
    return [
        Stage(
            formats.one_line(name.replace("_", " "), 40),
            formats.quantity(value, "s", 2),
            round(100 * value / longest, 1),
        )
        for name, value in steps.items()
    ]


def flat_facts(values: Mapping[str, Any], prefix: str = "") -> list[tuple[str, str]]:
    """Names and values of a dictionary of figures, inner ones with their path."""
    facts: list[tuple[str, str]] = []
    for name, value in values.items():
        title = f"{prefix}{formats.one_line(str(name).replace('_', ' '), 60)}"
        if isinstance(value, Mapping):
            facts += flat_facts(value, f"{title}: ")
        elif isinstance(value, list):
            shown = [plain_fact(str(name), item) for item in value if not isinstance(item, (list, dict))]
            facts.append((title, ", ".join(text for text in shown if text)))
        else:
            facts.append((title, plain_fact(str(name), value)))
    return [(name, text) for name, text in facts if text]

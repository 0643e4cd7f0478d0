"""A front as the page's script needs it: columns of numbers for plots and filters, texts for the eye.

All texts are made here, by the same words as everywhere; the script only places them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from uwopt.quantities import BY_NAME
from uwopt.report.page.sections import DIGITS, Card, bar, cards, scene_value
from uwopt.report.page.style import SCALE_DARK, SCALE_LIGHT
from uwopt.report.text import formats, vocabulary, words
from uwopt.report.text.front_tables import pick_names
from uwopt.report.text.tables import has_no_limit, kinds_by_id, scenes_to_set, shown_settings
from uwopt.report.text.verdict import axis_name, best_and_worst
from uwopt.results.design import Design, SceneResult, UsedHardware
from uwopt.results.front import FrontPoint, FrontResult
from uwopt.units import count_text, counted, symbol

#: Figures beside the objectives, unless an objective shows the same.
BESIDE = ("cost", "power_w", "gsd_mm", "snr_db", "dof_m", "frame_rate_hz", "f_number")
SHORT_ID = 14  # signs of an id that are always shown in the table


@dataclass(frozen=True)
class PointColumn:
    """Numbers of all points, already in the unit that is shown."""

    key: str
    title: str
    unit: str
    per: float  # what the result's numbers were divided by
    values: list[float | None]

    def at(self, index: int) -> tuple[str, str, float | None]:
        """Key, unit and number of one point."""
        return self.key, self.unit, self.values[index]


class Texts:
    """Texts by number, each kept once: what all points share must not fill the file."""

    def __init__(self) -> None:
        self.all: list[str] = []
        self._numbers: dict[str, int] = {}

    def number(self, text: str) -> int:
        """The number of a text."""
        if text not in self._numbers:
            self._numbers[text] = len(self.all)
            self.all.append(text)
        return self._numbers[text]

    def row(self, *texts: str) -> list[int]:
        """Numbers of several texts."""
        return [self.number(text) for text in texts]


def front_data(front: FrontResult) -> dict[str, Any]:
    """Objectives, columns, points, picks and peers, ready for JSON."""
    texts = Texts()
    columns = front_columns(front)
    names, short = pick_names(front), short_ids(front)
    return {
        "objectives": [
            {"name": o.name, "title": axis_name(o), "unit": symbol(column.unit),
             "maximise": o.direction == "maximise", "log": is_logarithmic(front, o.name)}
            for o, column in zip(front.objectives, columns, strict=False)
        ],
        "columns": [
            {"key": column.key, "title": column.title, "unit": symbol(column.unit)} for column in columns
        ],
        "scales": {"light": SCALE_LIGHT, "dark": SCALE_DARK},
        "points": [
            point_data(point, names.get(point.id, ""), [c.at(index) for c in columns], short, texts)
            for index, point in enumerate(front.points)
        ],
        "picks": [
            {
                "name": formats.one_line(pick.name, 40),
                "point": pick.point,
                "definition": formats.one_line(pick.definition),
            }
            for pick in front.picks
        ],
        "peers": [
            {"method": formats.one_line(peer.method, 30), "values": values,
             "shown": texts.row(*(formats.quantity(v, c.unit, 4) for v, c in zip(values, columns, strict=False))),
             "hardware": texts.number(formats.one_line(" + ".join(peer.hardware), 200))}
            for peer, values in zip(front.peers, peer_values(front, columns), strict=True)
        ],
        "texts": texts.all,
    }  # fmt: skip


def is_logarithmic(front: FrontResult, name: str) -> bool:
    """Whether an axis is scaled by logarithm: as the reference says, where all values are above 0."""
    asked = (front.reference.get("log") or {}).get(name, name in ("power", "cost"))
    every = [point.values[name] for point in front.points] + [
        peer.values.get(name) or 0.0 for peer in front.peers
    ]
    return bool(asked) and all(value > 0 for value in every)


def front_columns(front: FrontResult) -> list[PointColumn]:
    """Numbers of every point: the objectives, then figures that are known and not the same for all."""
    columns = [
        column(o.name, axis_name(o), o.unit, [point.values[o.name] for point in front.points])
        for o in front.objectives
    ]
    taken = {o.name for o in front.objectives}
    for one in (BY_NAME[name] for name in BESIDE):
        values = [beside(point.design, one.name) for point in front.points]
        if one.term not in taken and any(value is not None for value in values):
            unit = currency(front) if one.name == "cost" else one.unit
            columns.append(column(one.name, one.words, unit, values))
    return columns


def column(key: str, title: str, unit: str, values: Sequence[float | None]) -> PointColumn:
    """Numbers in the unit that their largest is read in."""
    per, unit = formats.prefixed(unit, max((abs(v) for v in values if v is not None), default=0.0))
    return PointColumn(key, title, unit, per, [None if value is None else value / per for value in values])


def peer_values(front: FrontResult, columns: Sequence[PointColumn]) -> list[list[float | None]]:
    """The objectives of other methods' points, in the units of the columns."""
    known = [[peer.values.get(o.name) for o in front.objectives] for peer in front.peers]
    return [
        [None if value is None else value / c.per for value, c in zip(row, columns, strict=False)]
        for row in known
    ]


def short_ids(front: FrontResult) -> dict[str, str]:
    """Ids of parts that fit a column: cut at a hyphen as soon as no other part of the front begins so."""
    every = sorted(
        {words.part_id(part) for point in front.points for part in point.design.hardware.parts.values()}
    )
    return {name: short_id(name, [other for other in every if other != name]) for name in every}


def short_id(name: str, others: Sequence[str]) -> str:
    """The first words of an id, enough to tell it from the others."""
    stem = name.partition(" (")[0]
    ends = [place for place, sign in enumerate(stem) if sign in "-_" and place >= SHORT_ID]
    fitting = (stem[:end] for end in ends if not any(other.startswith(stem[:end]) for other in others))
    cut = next(fitting, stem)
    return f"{cut}…" if len(cut) < len(name) - 3 else name


def beside(design: Design, name: str) -> float | None:
    """A total or a figure of the first scene, at the exact settings that a point's objectives belong to."""
    if name == "cost":
        return design.totals.cost.value
    if name == "power_w":
        return design.totals.power_w
    return scene_value(design.scenes[0].figures, design.scenes[0].settings, name)


def goal_texts(front: FrontResult, point: FrontPoint) -> list[str]:
    """The objectives of a pick as its cards have them: at the settings to type in, of a cost its range."""
    told = front.as_told(point)
    texts = [words.axis_text(one, told, DIGITS) for one in front.objectives]
    return texts if point.design.is_settable else [f"{text} ({EXACT})" for text in texts]


EXACT = "exact"  # of a point without settings to type in


def currency(front: FrontResult) -> str:
    """The currency of the mission's limits."""
    return formats.one_line((front.mission.get("limits") or {}).get("currency") or "", 8)


def point_data(
    point: FrontPoint, pick: str, numbers: Sequence[tuple[str, str, float | None]], short: Mapping[str, str],
    texts: Texts,
) -> dict[str, Any]:  # fmt: skip
    """One point: numbers and texts of its columns, parts, and all that its card shows."""
    design, hardware = point.design, point.design.hardware
    kinds, cost = kinds_by_id(design), design.totals.cost
    parts, many = hardware.parts.values(), hardware.camera_count
    return {
        "id": formats.one_line(point.id, 20), "pick": pick, "curve": formats.one_line(point.curve, 20),
        "method": formats.one_line(point.method, 20), "values": [value for *_, value in numbers],
        "shown": texts.row(*(shown_text(design, key, unit, value) for key, unit, value in numbers)),
        "parts": texts.row(*(words.part_id(part) for part in parts)),
        "short": texts.row(*(short[words.part_id(part)] for part in parts)),
        "names": texts.row(*(words.part_name(part) for part in parts)),
        "counts": [hardware.light_count if kind == "light" else many for kind in hardware.parts],
        "stand": texts.number(stand_text(hardware)),
        "cards": [texts.row(*card_texts(card)) for card in cards(design.as_set)],
        "scenes": [
            {
                "name": texts.number(formats.one_line(scene.name, 60) if len(design.scenes) > 1 else ""),
                "title": texts.number(settings_title(scene)),
                "settings": [texts.row(name, value) for name, value in setting_pairs(scene)],
                "margins": [
                    [*texts.row(b.name, b.value, b.limit, b.left, b.state), b.start, b.width]
                    for b in (bar(margin, kinds, cost) for margin in scene.margins if not has_no_limit(margin))
                ],
            }
            for scene in scenes_to_set(design.as_set)
        ],
    }  # fmt: skip


def shown_text(design: Design, key: str, unit: str, value: float | None) -> str:
    """A number of a point in words; its cost as a range where prices are estimated."""
    return formats.cost_text(design.totals.cost) if key == "cost" else formats.quantity(value, unit, 4)


def card_texts(card: Card) -> tuple[str, str, str]:
    """Title, value and note."""
    return card.title, card.value, card.note


def settings_title(scene: SceneResult) -> str:
    """What the settings are: rounded to what a person can set, or exact."""
    return "Settings to type in" if scene.settings_to_set else "Settings"


def setting_pairs(scene: SceneResult) -> list[tuple[str, str]]:
    """The settings to type in, in words."""
    chosen = scene.settings_to_set or scene.settings
    return [
        (vocabulary.SETTINGS[name][0], formats.setting_text(name, chosen.get(name)))
        for name in shown_settings([scene])
    ]


def stand_text(hardware: UsedHardware) -> str:
    """How camera and lights stand."""
    mounts = words.mounts_text(hardware.light_mounts)
    return f"{formats.one_line(hardware.orientation, 20)}" + (f", lights {mounts}" if mounts else "")


def front_cards(front: FrontResult) -> list[Card]:
    """How many systems there are, and the range of each objective, the better end first."""
    curves = len({point.curve for point in front.points})
    made = [
        Card(
            "Systems",
            count_text(len(front.points)),
            f"of {counted(curves, 'choice')} of hardware",
        )
    ]
    for objective in front.objectives:
        best, worst = (words.axis_text(objective, point, 3) for point in best_and_worst(front, objective))
        made.append(Card(words.capital(axis_name(objective)), best, "" if best == worst else f"to {worst}"))
    return made


def history_figure(front: FrontResult) -> dict[str, Any] | None:
    """Hypervolume over time of the methods that kept it, and the exact front's; None where none did."""
    kept = [method for method in front.methods if len(method.history) > 1]
    if not kept:
        return None
    lines: list[dict[str, Any]] = [
        {"type": "scatter", "mode": "lines+markers", "name": formats.one_line(method.name, 30), "marker": {"size": 5},
         "x": [row[0] for row in method.history], "y": [row[1] for row in method.history]}
        for method in kept
    ]  # fmt: skip
    end_s = max(line["x"][-1] for line in lines)
    lines += [
        {"type": "scatter", "mode": "lines", "name": "exact, at its end", "x": [0.0, end_s],
         "y": [method.hypervolume] * 2, "line": {"dash": "dash", "color": "#8a9aa6"}}
        for method in front.methods
        if method.name == "exact"
    ]  # fmt: skip
    axes = {"xaxis": {"title": {"text": "time [s]"}}, "yaxis": {"title": {"text": "hypervolume"}}}
    return {"data": lines, "layout": {**axes, "height": 300, "legend": {"orientation": "h", "y": 1.15}}}

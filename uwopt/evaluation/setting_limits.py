"""How far each setting of a design may be off before a requirement breaks, everything else as it is set.

Found by the rules of `evaluate`: outward from the setting in steps of a sixth of a doubling, many at once, up to the
first that fails; then by bisection between the last that holds and the first that fails. Between two steps that hold
nothing is looked for.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.figures import SettingRows
from uwopt.forward.part_columns import CONTINUOUS, FLASH
from uwopt.model.bisection import bisected
from uwopt.model.port import lens_dioptre_per_m, water_distance_m
from uwopt.objectives.requirements import LEVEL_TOLERANCE_REL

STEPS, LADDER = 6, 36  # steps to a doubling; how many are looked at on each side, up to 64 times
FOCUS_LADDER = 18  # of the focus distance, up to 8 times
HALVINGS = 24  # of a step: to 1e-8 of the setting
LEVEL = "mean_level"  # brightness alone, which gain can mend
NO_RULE = ("light_level",)  # steps of a lamp's dial: light that is off for other reasons lies between them
BOTH_TIMES = "exposure_and_pulse_ms"  # changed together, as where the camera's signal fires the lamp
COLUMNS: dict[str, tuple[str, ...]] = {
    "f_number": ("f_number",), "exposure_ms": ("exposure_s",), "pulse_ms": ("pulse_s",),
    BOTH_TIMES: ("exposure_s", "pulse_s"), "gain_db": ("gain",), "dim_frac": ("level",), "frame_rate_hz": ("rate_hz",),
}  # fmt: skip


@dataclass(frozen=True)
class SettingEnd:
    """Where a setting meets the first requirement that breaks: as a share of the setting, and which; None: nowhere."""

    factor: float | None
    requirement: str


@dataclass(frozen=True)
class SettingLimit:
    """How far one setting may be off on both sides.

    `low`, `high` : the first requirement that breaks; `low_dark`, `high_bright` : the first but for the brightness of
    the image, which gain can mend.
    """

    setting: str
    low: SettingEnd
    high: SettingEnd
    low_dark: SettingEnd
    high_bright: SettingEnd


def setting_limits(model: DesignModel, index: int, settings: SettingRows) -> list[SettingLimit]:
    """Limits of every setting of one scene; those of a focus in distance, of a gain as a ratio."""
    kind = int(model.lights.kind[0])
    names = [name for name in COLUMNS if applies(name, kind, unlit=model.unlit)]
    tried = NearSettings(model, index, settings)
    asked = [(name, sign, aside) for name in names for sign in (-1, 1) for aside in (False, True)]
    ends = dict(zip(asked, tried.ends(asked), strict=True))
    found = [setting_limit(name, ends) for name in names]
    focus = {("focus_distance_m", sign, aside): tried.focus_end(sign, aside) for _, sign, aside in asked[:4]}
    return [setting_limit("focus_distance_m", focus), *found]


def applies(name: str, kind: int, *, unlit: bool) -> bool:
    """Whether a setting is one of this lamp."""
    if name in ("pulse_ms", BOTH_TIMES):
        return kind not in (CONTINUOUS, FLASH) and not unlit
    return name != "dim_frac" or not unlit


def setting_limit(name: str, ends: dict[tuple[str, int, bool], SettingEnd]) -> SettingLimit:
    """Both sides of one setting, with and without the brightness."""
    low, high = (ends[name, sign, False] for sign in (-1, 1))
    return SettingLimit(name, low, high, ends[name, -1, True], ends[name, 1, True])


class NearSettings:
    """Settings near those of a design, held against what the design meets as it is set."""

    def __init__(self, model: DesignModel, index: int, settings: SettingRows):
        self.model, self.index, self.settings = model, index, settings
        own = self.verdicts(settings)
        self.met = [name for name, held in own.items() if held.all() and name not in NO_RULE]

    def verdicts(self, rows: SettingRows) -> dict[str, Array]:
        """Which requirements hold, by their names: (n,) each."""
        figures = self.model.figures(self.index, rows)
        margins = self.model.margins(self.index, rows, figures, level_tolerance_rel=LEVEL_TOLERANCE_REL)
        return {m.requirement: np.broadcast_to(m.satisfied, (len(rows.f_number),)) for m in margins}

    def failing(self, rows: SettingRows, *, aside: Sequence[bool] | bool) -> list[str]:
        """The requirement that each row breaks of those that the design meets; empty where none."""
        held = self.verdicts(rows)
        left = np.broadcast_to(np.asarray(aside, bool), (len(rows.f_number),))
        broken = np.full(len(rows.f_number), "", object)
        for name in reversed(self.met):
            fails = ~held[name] & ~(left & (name == LEVEL))
            broken = np.where(fails, name, broken)
        return [str(name) for name in broken]

    def moved(self, names: Sequence[str], factors: Array) -> SettingRows:
        """The settings with one of them multiplied in each row."""
        many = self.settings.take(np.zeros(len(names), int))
        changed = {column: getattr(many, column).copy() for of_one in COLUMNS.values() for column in of_one}
        for row, (name, factor) in enumerate(zip(names, factors, strict=True)):
            for column in COLUMNS[name]:
                changed[column][row] *= factor
        return replace(many, **changed)

    def ends(self, asked: Sequence[tuple[str, int, bool]]) -> list[SettingEnd]:
        """Where each setting, on the side asked for, breaks the first requirement."""
        steps = np.arange(1, LADDER + 1) / STEPS
        names = [name for name, _, _ in asked for _ in steps]
        powers = np.concatenate([sign * steps for _, sign, _ in asked])
        aside = [left for _, _, left in asked for _ in steps]
        broken = np.array(self.failing(self.moved(names, 2.0**powers), aside=aside), object)
        first = [next((n for n, name in enumerate(row) if name), None) for row in broken.reshape(len(asked), -1)]
        open_ = [n for n, place in enumerate(first) if place is not None]
        signs = np.array([asked[n][1] for n in open_], float)
        bad = np.array([steps[first[n]] for n in open_])
        good, names = bad - 1.0 / STEPS, [asked[n][0] for n in open_]
        aside, why = [asked[n][2] for n in open_], [""] * len(open_)

        def fails(powers: Array) -> list[str]:
            return self.failing(self.moved(names, 2.0 ** (signs * powers)), aside=aside)

        if open_:
            good, bad = bisected(lambda powers: [not name for name in fails(powers)], good, bad, steps=HALVINGS)
            why = fails(bad)
        ends = [SettingEnd(None, "")] * len(asked)
        for n, sign, power, name in zip(open_, signs, good, why, strict=True):
            ends[n] = SettingEnd(float(2.0 ** (sign * power)), name)
        return ends

    def focus_end(self, sign: int, aside: bool) -> SettingEnd:
        """The same of the focus distance in water, one at a time: a focus is common to all that are tried."""
        focus_map = self.model.maps[self.index]
        own_m = float(water_distance_m(float(self.settings.dioptre_per_m[0]), focus_map=focus_map))
        if not math.isfinite(own_m):
            return SettingEnd(None, "")

        def broken(power: float) -> str:
            dioptre = float(lens_dioptre_per_m(own_m * 2.0 ** (sign * power), focus_map=focus_map))
            return self.failing(replace(self.settings, dioptre_per_m=np.array([dioptre])), aside=aside)[0]

        places = (step / STEPS for step in range(1, FOCUS_LADDER + 1))
        bad = next((place for place in places if broken(place)), None)
        if bad is None:
            return SettingEnd(None, "")
        good, bad = map(float, bisected(
            lambda power: not broken(power), bad - 1.0 / STEPS, bad, steps=HALVINGS // 2,  # finer than anyone focuses
        ))  # fmt: skip
        return SettingEnd(2.0 ** (sign * good), broken(bad))

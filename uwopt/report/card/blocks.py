"""What stands on the settings card, as blocks that text and page share.

How far a setting may be off and what to do in worse water are asked of the model anew, from the inputs of the result.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal

import numpy as np

from uwopt.deadline import Deadline
from uwopt.evaluation.design_model import DesignModel
from uwopt.evaluation.figures_by_name import on_scale_m
from uwopt.evaluation.recompute import Replay, ReplayError, given_settings, replayed
from uwopt.evaluation.setting_limits import BOTH_TIMES, LEVEL, SettingEnd, SettingLimit, setting_limits
from uwopt.forward.part_columns import CONTINUOUS, FLASH
from uwopt.forward.switching import are_switched
from uwopt.model.port import lens_dioptre_per_m
from uwopt.report.card.water import water_block
from uwopt.report.text import formats, vocabulary, words
from uwopt.report.text.layout import Block, Facts, Grid, Line, Text, block, columns, fact_lines, sentence
from uwopt.report.text.opening import how_far
from uwopt.results.design import Design, SceneResult
from uwopt.results.result import Result
from uwopt.units import ratio_to_db

WATER_S = 5.0  # for worse waters
AS_SET = "as set"  # nothing to spare
WHOLE_RANGE = "all of that"  # between both ends
SCALE_READ_FRAC = 0.05  # of a distance: as well as a lens's scale is read and set (assumed)
#: Settings whose own ends are told by which end it is.
SETTINGS_OWN = ("f-number", "exposure", "pulse", "gain as a ratio", "light level")
DECIBELS = Decimal("0.1")  # as finely as a gain is set
NARROW = 5e-4  # share of a setting: what is nearer to it than this, nobody sets
OPEN_LONG = 3.0  # times as long as the light: what else burns counts
NAMES = {name: text for name, (text, _) in vocabulary.SETTINGS.items()} | {BOTH_TIMES: "exposure and pulse together"}
SHOWN = ("f_number", "focus_distance_m", "exposure_ms", "pulse_ms", BOTH_TIMES, "gain_db", "dim_frac", "frame_rate_hz")


@dataclass(frozen=True)
class SettingsCard:
    """One page: who it is for, and its blocks."""

    name: str
    hardware: str
    verdict: str
    blocks: tuple[Block, ...]


def settings_card(result: Result) -> SettingsCard | None:
    """The card of a result; None where it has no design."""
    design = result.best
    if design is None:
        return None
    name = formats.one_line(result.mission.get("name") or "Mission", 100)
    parts = " + ".join(words.part_name(part) for part in design.hardware.named.values())
    verdict = words.as_sentence(how_far(result))
    return SettingsCard(name, parts, verdict, tuple(card_blocks(result, design)))


def card_blocks(result: Result, design: Design) -> Iterator[Block]:
    """Settings with their limits, trigger, worse water, and the day's work."""
    made, fault = recomputed(result, design)
    for index, scene in enumerate(design.scenes):
        title = f"Set: {formats.one_line(scene.name, 60)}" if len(design.scenes) > 1 else "Set"
        limits = limits_of(made, index, scene) if made is not None else {}
        lines: list[Line] = [settings_grid(made, index, scene, limits)]
        if made is not None:
            lines += [sentence(text) for text in focus_sentences(as_set(scene), limits.get("focus_distance_m"))]
            lines += [sentence(text) for text in trigger_sentences(made.model, scene, limits, index)]
            lines += [sentence(text) for text in waking_sentences(made.model, index)]
        yield block(title, lines)
    if len(design.scenes) > 1:
        common = "One f-number and one focus serve all scenes: for them the narrowest of these counts."
        yield block("", [sentence(common)])
    yield block("How it stands", [stands(design)])
    if made is not None:
        given = [given_settings(made.model, i, as_set(scene)) for i, scene in enumerate(design.scenes)]
        yield water_block(made.model, given, design, Deadline.after(WATER_S))
    else:
        yield block("Limits of settings and worse water", [sentence(fault, "yellow")])
    yield block("The day's work", [work_grid(result, design.as_set)])


def recomputed(result: Result, design: Design) -> tuple[Replay | None, str]:
    """The design's model, or why there is none."""
    try:
        return replayed(result, design), ""
    except ReplayError as fault:
        return None, f"Not told: {fault}"


def as_set(scene: SceneResult) -> dict[str, float | None]:
    """The settings that a person types in; the exact ones where there are none."""
    return scene.settings_to_set or scene.settings


def limits_of(made: Replay, index: int, scene: SceneResult) -> dict[str, SettingLimit]:
    """How far each setting of a scene may be off."""
    rows = made.model.settings(index, given_settings(made.model, index, as_set(scene)))
    return {limit.setting: limit for limit in setting_limits(made.model, index, rows)}


# ---------------------------------------------------------------- settings


def settings_grid(made: Replay | None, index: int, scene: SceneResult, limits: dict[str, SettingLimit]) -> Grid:
    """What to set, how far it may be off, and what breaks there."""
    heads = [
        ("setting", "left"), ("set to", "right"), ("not below", "right"), ("for", "left"),
        ("not above", "right"), ("for", "left"),
    ]  # fmt: skip
    has_level = any(end.requirement == LEVEL for limit in limits.values() for end in (limit.low, limit.high))
    table = columns(*heads, *([("brightness holds within", "left")] if has_level else []))
    settings = as_set(scene)
    for name in SHOWN:
        value = settings.get("exposure_ms" if name == BOTH_TIMES else name)
        if value is None or (name == BOTH_TIMES and name not in limits):
            continue
        told = "" if name == BOTH_TIMES else short_text(name, value)
        if name == "pulse_ms" and made is not None and int(made.model.lights.kind[0]) == FLASH:
            told = f"{formats.quantity(value, 'ms', 3)}, its own"  # nobody sets how long a flash is
        cells = [NAMES[name], told, *limit_texts(name, value, limits.get(name))]
        table.add_row(*(Text(cell) for cell in cells[: len(table.heads)]))
        if name == "focus_distance_m" and settings.get("focus_scale_m") is not None:
            scale = formats.setting_text("focus_scale_m", settings["focus_scale_m"])
            ends = scale_ends(made, index, value, limits.get(name)) if made is not None else ("", "")
            row = (NAMES["focus_scale_m"], scale, ends[0], "", ends[1], "", "")
            table.add_row(*map(Text, row[: len(table.heads)]))
    return table


def scale_ends(made: Replay, index: int, focus_m: float, limit: SettingLimit | None) -> tuple[str, str]:
    """What the lens's own scale shows at both ends of the focus."""
    if limit is None:
        return "", ""
    told, rows = [], made.settings[index]
    for end, rounding in ((limit.low_dark, ROUND_CEILING), (limit.high_bright, ROUND_FLOOR)):
        text = end_text("focus_distance_m", focus_m, end, rounding)
        if end.factor is not None and text != AS_SET:
            dioptre = lens_dioptre_per_m(focus_m * end.factor, focus_map=made.model.maps[index])
            scale_m = on_scale_m(made.model, replace(rows, dioptre_per_m=np.array([float(dioptre)])))
            text = "the far end" if scale_m is None else formats.setting_text("focus_scale_m", scale_m)
        told.append(text)
    return told[0], told[1]


def limit_texts(name: str, value: float, limit: SettingLimit | None) -> tuple[str, ...]:
    """Lowest and highest value with what breaks there, and within which the brightness stays as asked."""
    if limit is None:
        return ("", "", "", "", "")
    low, high = (
        end_text(name, value, end, rounding)
        for end, rounding in ((limit.low_dark, ROUND_CEILING), (limit.high_bright, ROUND_FLOOR))
    )
    why_low, why_high = (breaks(end) for end in (limit.low_dark, limit.high_bright))
    from_ = end_text(name, value, limit.low, ROUND_CEILING) if limit.low.requirement == LEVEL else ""
    up_to = end_text(name, value, limit.high, ROUND_FLOOR) if limit.high.requirement == LEVEL else ""
    within = f"{from_} to {up_to}" if from_ and up_to else f"from {from_}" if from_ else up_to and f"up to {up_to}"
    return low, why_low, high, why_high, within or WHOLE_RANGE


def breaks(end: SettingEnd) -> str:
    """The requirement that breaks, in its first words; of an end of a setting's own which end that is."""
    first, _, own = words.requirement_name(end.requirement).partition(",") if end.requirement else ("", "", "")
    return own.strip() if own and first in SETTINGS_OWN else first


def focus_sentences(settings: dict[str, float | None], limit: SettingLimit | None) -> Iterator[str]:
    """How to reach a focus that is finer than a lens's scale can be read, and what widens it."""
    focus_m = settings.get("focus_distance_m")
    if limit is None or not focus_m or limit.low_dark.factor is None or limit.high_bright.factor is None:
        return
    nearer_m, farther_m = focus_m * (1.0 - limit.low_dark.factor), focus_m * (limit.high_bright.factor - 1.0)
    if nearer_m + farther_m > 2.0 * SCALE_READ_FRAC * focus_m:
        return
    ends = [formats.quantity(1e3 * max(one, 0.0), "mm", 2) for one in (nearer_m, farther_m)]
    yield (
        f"Focus: {ends[0]} nearer or {ends[1]} farther than {formats.setting_text('focus_distance_m', focus_m)} is all "
        f"there is, finer than the scale of a lens is set ({100 * SCALE_READ_FRAC:g} %, assumed). Focus in live view "
        "on a chart at that distance from the port under water, lock the ring, and look again once it is warm or cold "
        "as it will be. An iris closed by one stop more widens this by about 1.4 times and takes twice the light."
    )


def end_text(name: str, value: float, end: SettingEnd, rounding: str) -> str:
    """An end of a setting's range in its unit, rounded to the safe side; or that nothing is to spare, or no end."""
    if end.factor is None:
        return "any"
    if abs(end.factor - 1.0) < NARROW:
        return AS_SET
    setting = "exposure_ms" if name == BOTH_TIMES else name
    moved = value + float(ratio_to_db(end.factor)) if name == "gain_db" else value * end.factor
    digits = Decimal(f"{moved:.6f}" if name == "gain_db" else f"{moved:.6g}")
    step = DECIBELS if name == "gain_db" else Decimal(1).scaleb(digits.adjusted() - 2)
    return short_text(setting, float(digits.quantize(step, rounding=rounding)) + 0.0)  # no -0


def short_text(name: str, value: float) -> str:
    """A setting as it is typed in; of a slow rate the time between images alone, where that is told."""
    return formats.setting_text(name, value).rpartition(", once ")[2]


def waking_sentences(model: DesignModel, index: int) -> Iterator[str]:
    """How long a camera that is off between images is on for each, as its power is counted."""
    if model.problem.scenes[index].view.vehicle.camera_between_images == "off":
        on = formats.quantity(float(model.cameras.awake_s[0]), "s", 2)
        yield f"The camera is off between images: for each it is on for {on}, waking up and transfer, and the exposure."


def trigger_sentences(
    model: DesignModel, scene: SceneResult, limits: dict[str, SettingLimit], index: int
) -> Iterator[str]:  # fmt: skip
    """When the lamps fire, and how late they may be."""
    settings, kind = as_set(scene), int(model.lights.kind[0])
    if model.unlit:
        return
    exposure_ms = settings.get("exposure_ms") or 0.0
    if kind == CONTINUOUS:
        if are_switched(model.problem.scenes[index].view.vehicle, model.lights)[0]:
            warm = formats.quantity(float(model.lights.warm_up_s[0]), "s", 2)
            yield f"Trigger: the lamps are off between images; on {warm} before the exposure, off when it is over."
        else:
            yield "The lamps burn all the time: nothing is triggered."
        return
    readout_ms = 1e3 * float(model.cameras.readout_s[0])
    light_ms = settings.get("pulse_ms") or 1e3 * float(model.lights.flash_duration_s[0])
    slack_ms = max(0.0, exposure_ms - readout_ms - light_ms)
    begin = "with the exposure"
    if readout_ms:
        told = formats.setting_text("pulse_ms", delay_ms(readout_ms, max(slack_ms, NARROW * light_ms)))
        begin = f"{told} after the exposure begins, when all rows are open"
    what = "flash" if kind == FLASH else "pulse"
    said = f"Trigger: the {what} begins {begin}"
    if slack_ms > NARROW * light_ms:
        yield f"{said}, or up to {formats.quantity(slack_ms, 'ms', 2)} later without any loss."
    else:
        limit = limits.get("pulse_ms")
        factor = None if limit is None else limit.low_dark.factor
        spare_ms = 0.0 if factor is None else (1.0 - factor) * light_ms
        late = "none is to spare"
        if limit is not None and spare_ms > NARROW * light_ms:
            first = words.requirement_name(limit.low_dark.requirement).partition(",")[0]
            late = f"{formats.quantity(spare_ms, 'ms', 2)} late, {first} breaks"
        yield f"{said}; all of the exposure is lit, so delay costs light: {late}."
    if exposure_ms > OPEN_LONG * light_ms:
        told = formats.quantity(exposure_ms, "ms", 3)
        yield f"The shutter is open for {told} all the same: other lights of the vehicle must be off, none are counted."
    if kind == FLASH and model.lights.flash.fade:
        yield fading_text(model, min(exposure_ms - readout_ms, light_ms), sunlit=bool(model.rows[0].sun))
    yield "Ask the lamp's maker for its own delay, and allow for it in the strobe delay of the camera."


def delay_ms(least_ms: float, spare_ms: float) -> float:
    """A delay as it is set, no shorter than the least: of three digits where that is no more than to spare, else of
    whole microseconds."""
    least = Decimal(f"{least_ms:.9g}")
    fine = Decimal("0.001")
    coarse = max(Decimal(1).scaleb(least.adjusted() - 2), fine)
    few = least.quantize(coarse, rounding=ROUND_CEILING)
    return float(few if few - least <= Decimal(spare_ms) else least.quantize(fine, rounding=ROUND_CEILING))


def fading_text(model: DesignModel, open_ms: float, *, sunlit: bool) -> str:
    """How much of a flash that fades falls within the open shutter, and how long steady light would blur as much."""
    flash = model.lights.flash
    light_s = flash.light_s(np.array([1e-3 * open_ms]))
    share = formats.share(float((light_s / flash.full_s)[0]))
    said = f"The flash fades: {share} of its light falls within the exposure, and no more is counted"
    steady = formats.quantity(1e3 * float(flash.blur_s(light_s)[0]), "ms", 2)
    return f"{said}." if sunlit else f"{said}; it blurs as {steady} of steady light would."


# ---------------------------------------------------------------- how it stands, and what it does


def stands(design: Design) -> Facts:
    """How camera and lamps stand."""
    hardware = design.hardware
    return fact_lines(
        [
            ("camera", words.camera_stand(hardware)),
            ("lights", words.mounts_text(hardware.light_mounts)),
            ("spacer", f"{hardware.spacer_mm:g} mm ring behind the lens" if hardware.spacer_mm else ""),
        ]
    )


def work_grid(result: Result, design: Design) -> Grid:
    """Lines, area, data and energy of each scene."""
    table = columns(("", "left"), *((formats.one_line(s.name, 30), "right") for s in design.scenes),
                    header=len(design.scenes) > 1)  # fmt: skip
    for name, texts in work_rows(result, design):
        if any(texts):
            table.add_row(Text(name), *(Text(text or "–") for text in texts))
    return table


def work_rows(result: Result, design: Design) -> Iterator[tuple[str, list[str]]]:
    """Names and values of what the system does in an hour."""

    def row(figure: str, unit: str, scale: float = 1.0) -> list[str]:
        values = [scene.figures.get(figure) for scene in design.scenes]
        return ["" if value is None else formats.quantity(scale * float(value), unit) for value in values]

    has_lines = any(scene.get("target") != "mid_water" for scene in result.mission.get("scenes") or [{}])
    has_lines &= any(scene.figures.get("area_m2_h") for scene in design.scenes)  # none without a speed
    if has_lines:
        places = [result.mission, *(result.mission.get("scenes") or [])]
        banded = any((place.get("vehicle") or {}).get("altitude_tolerance_m") for place in places)
        yield "distance between lines" + (", at any altitude" if banded else ""), row("line_spacing_m", "m")
    yield "swath", row("swath_m", "m")
    if any("common_swath_m" in scene.figures for scene in design.scenes):
        yield "swath of both cameras", row("common_swath_m", "m")
        yield "error of a distance by stereo", row("depth_error_mm", "mm")
    yield "pixel on the floor", row("gsd_mm", "mm")
    if has_lines:
        yield "area in an hour", row("area_m2_h", "m2/h")
    yield "data in an hour", row("data_rate_mb_s", "GB", 3.6)
    yield "energy in an hour", row("power_w", "Wh")
    hours = design.totals.endurance_h if design.totals.endurance_h is not None else design.totals.run_time_h
    lasts = [formats.quantity(hours, "h") if hours is not None else ""] * len(design.scenes)
    yield "a battery lasts", lasts
    if hours is None:
        drawn_w = [scene.figures.get("power_w") for scene in design.scenes]
        yield "hours from 100 Wh", [formats.quantity(100.0 / float(one_w), "h") if one_w else "" for one_w in drawn_w]

"""What to change when the water is worse than planned, as a block of the settings card."""

from __future__ import annotations

from collections.abc import Sequence

from uwopt.deadline import Deadline
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.designs import SceneSettings
from uwopt.report.text import formats, vocabulary, words
from uwopt.report.text.layout import Block, Text, block, columns, sentence
from uwopt.results.design import Design
from uwopt.solvers.explain.worse_water import InWorseWater, in_worse_water

CHANGED = ("f_number", "focus_distance_m", "exposure_ms", "pulse_ms", "gain_db", "dim_frac", "frame_rate_hz")
#: Readings of how clear water is, as they are spoken of.
READINGS = {
    "c_per_m": ("beam attenuation", "per metre"), "visibility_m": ("visibility", "m"),
    "secchi_m": ("Secchi depth", "m"), "turbidity_ntu": ("turbidity", "NTU"),
}  # fmt: skip
SAME_REL = 0.005  # a setting that moves by less stays as it is


def water_block(model: DesignModel, given: list[SceneSettings], planned: Design, deadline: Deadline) -> Block:
    """A row a worse water: what breaks if nothing is changed, and what to change."""
    found = in_worse_water(model.problem, model.hardware, given, deadline)
    if not found:
        said = "Not told: Jerlov types and readings are made worse; this water is the last type, or a file."
        return block("If the water is worse than planned", [sentence(said)])
    table = columns(("water", "left"), ("if nothing is changed", "left"), ("what to change", "left"))
    mission = model.problem.mission
    flies = all(
        scene.target == "floor" and view.vehicle.speed_m_s > 0.0
        for scene, view in zip(mission.scenes, mission.views, strict=True)
    )
    for item in found:
        cells = (water_text(item.water), missed_text(item.as_planned), change_text(item, planned, flies=flies))
        table.add_row(*map(Text, cells))
    return block("If the water is worse than planned", [table])


def water_text(water: str) -> str:
    """`visibility 2 m` of `visibility_m 2`; a type of water as it is."""
    key, _, value = water.partition(" ")
    if key not in READINGS:
        return formats.one_line(water, 40)
    name, unit = READINGS[key]
    return f"{name} {formats.one_line(value, 20)} {unit}"


def missed_text(design: Design) -> str:
    """Requirements that break, with what is reached and asked."""
    missed = {m.requirement: m for m in design.missed}
    said = []
    for margin in missed.values():
        value, limit = formats.margin_ends(margin)
        said.append(f"{words.requirement_name(margin.requirement)} {value}, not {limit}")
    return "; ".join(said) or "all holds"


def change_text(item: InWorseWater, planned: Design, *, flies: bool = True) -> str:
    """The settings that differ, and the altitude where it must be lower.

    flies : whether it moves over a floor; a camera that faces a wall or stands on a frame goes nearer
    """
    if item.as_planned.feasible:
        return "nothing"
    if item.design is None:
        why = f": {words.rule_name(item.obstacle)}" if item.obstacle else ""
        lowest = f"{100 * item.altitude_frac:.0f} % of the altitude"
        nearer = "flying lower" if flies else "going nearer"
        return f"no settings do, nor does {nearer}, down to {lowest}{why}; wait, or take other hardware"
    go = "fly at" if flies else "go to"
    parts = [f"{go} {100 * item.altitude_frac:.0f} % of the altitude"] if item.altitude_frac < 1.0 else []
    for ours, theirs in zip(planned.scenes, item.design.scenes, strict=True):
        changes = changed_settings(ours.settings_to_set or ours.settings, theirs.settings)
        place = f"{formats.one_line(ours.name, 30)}: " if len(planned.scenes) > 1 else ""
        if changes:
            parts.append(place + ", ".join(changes))
    power = formats.quantity(item.design.totals.power_w, "W")
    return "; ".join(parts) + f" ({power})" if parts else "nothing"


def changed_settings(before: dict[str, float | None], after: dict[str, float | None]) -> Sequence[str]:
    """Settings that move by more than can be read off a dial."""
    told = []
    for name in CHANGED:
        old, new = before.get(name), after.get(name)
        if new is None or (old is not None and abs(new - old) <= SAME_REL * max(abs(old), abs(new))):
            continue
        label = {"focus_distance_m": "focus in water", "pulse_ms": "pulse"}.get(name, vocabulary.SETTINGS[name][0])
        shown = round(new, 1) + 0.0 if name == "gain_db" else float(f"{new:.3g}")
        told.append(f"{label} {formats.setting_text(name, shown)}")
    return told

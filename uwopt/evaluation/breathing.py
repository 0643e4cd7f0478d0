"""What a lens that is focused near makes of the field of view: figures take the focal length at infinity.

A lens that moves as a whole stands f (1 + m) before the sensor and sees 1 / (1 + m) of its field, m being its
magnification; one that focuses inside may keep it. Makers seldom tell which, so that it is told and not computed.
Physics page, section 3.
"""

from __future__ import annotations

from uwopt.results.design import Design, Note, SceneResult
from uwopt.units import format_quantity

LEAST = 0.02  # of the field, from which it is told
BREATHING, NARROWED, NO_IMAGE = "breathing", "narrowed", "no_image"


def breathing_notes(design: Design) -> list[Note]:
    """A warning where focusing so near narrows the field of view, or leaves no image."""
    notes = []
    for scene in design.scenes:
        n, working = scene.figures["f_number"], scene.figures["working_f_number"]
        if n and working is None:
            text = f"{scene.name}: the focus lies within the focal length of the lens; there is no image"
            notes.append(Note(NO_IMAGE, "lens", text))
        if n and working and working / n > 1.0 + LEAST:
            notes.append(narrowed(scene, working / n - 1.0))
    return notes


def narrowed(scene: SceneResult, magnification: float) -> Note:
    """The swath that is left of the one told, and whether it would do."""
    told_m = float(scene.figures["swath_m"])
    left_m = told_m / (1.0 + magnification)
    held = [m.limit for m in scene.margins if m.requirement.startswith("min_swath_m") and m.limit is not None]
    wanted_m = max(held, default=0.0)
    text = (
        f"{scene.name}: focused so near, a lens that moves as a whole extends by {100 * magnification:.1f} % and sees "
        f"that much less: a swath of {format_quantity(left_m, 'm')}, not {format_quantity(told_m, 'm')}"
    )
    if left_m >= wanted_m:
        return Note(BREATHING, "lens", f"{text}; one that focuses inside may keep it: measure it")
    wanted = f"where {format_quantity(wanted_m, 'm')} are held; ask the maker how it focuses"
    return Note(NARROWED, "lens", f"{text}, {wanted}")

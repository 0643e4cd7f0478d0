"""What is told of a lens that is focused near: how much of its field the figures leave out, or that none is left.

What each figure counts is said in `uwopt.forward.breathing`.
"""

from __future__ import annotations

from uwopt.results.design import Design, Note, SceneResult
from uwopt.units import format_quantity

LEAST = 0.02  # of the field, from which it is told
BREATHING, NO_IMAGE = "breathing", "no_image"


def breathing_notes(design: Design) -> list[Note]:
    """A note where focusing so near narrows the field of view, or leaves no image."""
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
    """How much wider a lens may see that keeps its field."""
    swath_m = float(scene.figures["swath_m"])
    return Note(
        BREATHING, "lens",
        f"{scene.name}: focused so near, a lens that moves as a whole extends by {100 * magnification:.1f} % and sees "
        f"that much less: swath ({format_quantity(swath_m, 'm')}), overlap and blur are counted for it, ground sample "
        "for one that focuses inside and keeps its field; makers seldom tell which it is",
    )  # fmt: skip

"""The image as a whole, in words: what its mean, most of it and its darkest pixel have, and how soft its corners are.

Said of every design whether asked for or not: a mean alone hides a lit spot in the dark.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from uwopt.report.text import formats, words
from uwopt.results.design import SceneResult

SPOT_BELOW = 0.3  # least over mean light on the floor
AT_CORNER = "at 80 % of the way from the middle"  # `views.CORNER_FIELD`, of the half diagonal
SOFT_ABOVE_PX = 2.0  # blur of the corners by focus and port
OF_SNR = (("mean", "snr_db"), ("95 % of the frame", "snr_db_p05"), ("darkest pixel", "snr_db_min"))


def frame_facts(scenes: Sequence[SceneResult]) -> list[tuple[str, str]]:
    """What is to be said of the images of some scenes, as names and values; nothing in physics without a field."""
    found = []
    for scene in scenes:
        place = words.in_scene(scene.name, scenes)
        found += [(name + place, text) for name, text in facts_of(scene.figures)]
    return found


def facts_of(figures: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Signal to noise, evenness of the light and sharpness of the corners of one image."""
    if figures.get("mtf_half_nyquist") is None:  # physics `paper` knows no field
        return []
    even, soft = figures.get("uniformity"), figures.get("defocus_corner_px")
    facts = oblique_facts(figures)
    facts.append(("signal to noise", ", ".join(f"{name} {snr_text(figures.get(key))}" for name, key in OF_SNR)))
    if even is not None:
        spot = ": a spot, the rest is dark" if even < SPOT_BELOW else ""
        facts.append(("evenness of the light", f"the darkest floor has {formats.share(even)} of the mean{spot}"))
    if soft is not None:
        blurred = ": soft corners" if soft > SOFT_ABOVE_PX else ""
        facts.append(("blur of the corners", f"{formats.quantity(soft, 'px')} {AT_CORNER}{blurred}"))
    return facts


def oblique_facts(figures: Mapping[str, Any]) -> list[tuple[str, str]]:
    """How far an oblique view goes, how large its pixels are and how wide it is; nothing of a view square on."""
    if figures.get("range_far_m") is None:
        return []
    rows = (("away", "range", "m"), ("a pixel", "gsd", "mm"), ("wide", "swath", "m"))
    return [
        (
            f"{place} of the view",
            ", ".join(f"{formats.quantity(figures[f'{key}_{end}_{unit}'], unit)} {what}" for what, key, unit in rows),
        )
        for place, end in (("near edge", "near"), ("middle", "centre"), ("far edge", "far"))
    ]


def snr_text(value: float | None) -> str:
    """Decibels; a pixel without any light has none."""
    return "no light" if value is None else formats.quantity(value, "dB")

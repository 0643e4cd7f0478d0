"""Risks of water and lamps: other water, lamps off their aim, images that are noisy or uneven."""

from __future__ import annotations

from uwopt.api.risks.margins import in_words
from uwopt.api.risks.worst import Weighed, in_which_scene, worst
from uwopt.mission.practice import ACCEPTABLE_SNR_DB
from uwopt.mission.weakened import LEAST_SNR_DB
from uwopt.results.basis import Risk
from uwopt.results.design import Design
from uwopt.results.result import Result
from uwopt.units import format_quantity, listed

OF_NOISE = ("min_snr", "min_snr_db", "min_snr_mean_db", "min_snr_red_db", "resolve_mm")
EVEN, VERY_UNEVEN = 0.3, 0.1  # darkest place against the mean
STEADY_DEG = 3.0  # as well as a lamp's direction is kept on a vehicle


def in_other_water(result: Result, design: Design) -> Weighed:
    """Descriptions of the same water in which a requirement is missed."""
    waters = (result.robustness or {}).get("waters") or []
    failed = sum(1 for water in waters if water.get("objective_value") is None)
    if failed:
        because = "measured tables of one type of water differ, and so does what is lost on the lamps' way"
        if not any(scene.get("water") for scene in result.mission.get("scenes") or []):
            because = "water as clear may scatter and absorb in other shares, and then more is lost on the lamps' way"
        yield 60.0 + 15.0 * failed / len(waters), Risk(
            "it fails in water a little different", because, f"in {failed} of {len(waters)} other waters"
        )  # fmt: skip


def lamps_off(result: Result, design: Design) -> Weighed:
    """How little the lamps may lean from where they are aimed."""
    tilt = (result.robustness or {}).get("tilt") or {}
    held, helped = least_of(tilt, "held"), least_of(tilt, "readjusted")
    if held is None or held >= STEADY_DEG:
        return
    names = listed(dict.fromkeys(map(in_words, tilt.get("first_to_break", []))))
    because = f"when one leans further, {names or 'a requirement'} cannot be kept"
    if helped is not None and helped > held:
        because += f"; with light, exposure and gain set anew up to {helped:.1f}° can be borne"
    weight = 70.0 if helped is None or helped < STEADY_DEG else 45.0
    yield weight, Risk("a lamp slightly off its aim spoils the images", because, f"{held:.1f}° as set")


def noisy(result: Result, design: Design) -> Weighed:
    """Images that drown in noise, as the mission asks for no signal to noise: light is then saved on."""
    if any(margin.key in OF_NOISE for margin in design.margins):
        return
    scene, snr_db = worst(design, "snr_db", least=True)
    if scene is None or snr_db >= ACCEPTABLE_SNR_DB:
        return
    what = "the images show nothing but noise" if snr_db < LEAST_SNR_DB else "the images are noisy"
    because = "no signal to noise is asked for, so light is saved on" + in_which_scene(design, scene)
    because += f"; requirements.min_snr_db: {ACCEPTABLE_SNR_DB:g} asks for images that can be used"
    figure = f"signal to noise {format_quantity(snr_db, 'dB')}"
    yield (96.0 if snr_db < LEAST_SNR_DB else 60.0), Risk(what, because, figure)


def uneven(result: Result, design: Design) -> Weighed:
    """Light that leaves part of the image dark."""
    scene, value = worst(design, "uniformity", least=True)
    if scene is None or value >= EVEN:
        return
    because = f"the darkest place of the floor{in_which_scene(design, scene)} gets so much less light than the mean"
    figure = f"{100 * value:.2g} % of the mean light"
    if (snr_db := scene.figures.get("snr_db_min")) is not None:
        figure += f", signal to noise there {format_quantity(snr_db, 'dB')}"
    yield (78.0 if value < VERY_UNEVEN else 50.0), Risk("part of the image is dark", because, figure)


def least_of(tilt: dict[str, float | None], name: str) -> float | None:
    """The smaller of both ways that a lamp can lean."""
    known = [v for way in ("outward", "inward") if (v := tilt.get(f"{name}_{way}_deg")) is not None]
    return min(known, default=None)

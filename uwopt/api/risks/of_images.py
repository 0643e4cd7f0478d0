"""Risks of what the optics do beside what was asked: blur, skew, colours, corners."""

from __future__ import annotations

import math

from uwopt.api.risks.worst import Weighed, in_which_scene, worst
from uwopt.mission.reserves import RECOMMENDED_RESERVE, REFUSED
from uwopt.model.sharpness import RESOLVED_CONTRAST
from uwopt.results.basis import Risk
from uwopt.results.design import Design, SceneResult
from uwopt.results.result import Result
from uwopt.units import format_quantity, listed

TELLING_PX = 1.0  # a blur this wide is a cause of detail that is lost
SEEN_PX = 2.0  # a blur, skew or coloured edge wider than this is seen
STILL_MM_S = 10.0  # a hand, a line or a hovering vehicle drifts faster; a frame on the floor does not
MOST_GAIN_DB = RECOMMENDED_RESERVE["max_gain_db"]
#: Figure, risk, reason: what is seen when it is wider than two pixels.
SEEN = (
    ("defocus_corner_px", "corners of the image are out of focus", "depth of field holds on the axis alone"),
    ("skew_px", "moving scenes are skewed", "the rolling shutter reads row after row while the vehicle moves"),
    ("lateral_colour_px", "edges blur or get coloured rims", "the flat port bends colours by different amounts"),
)  # fmt: skip


def seen_in_the_image(result: Result, design: Design) -> Weighed:
    """Faults of the image that no requirement holds, but for what `lost_in_corners` tells."""
    told = [name for name, _ in BLURS] if any(True for _ in lost_in_corners(result, design)) else []
    for name, what, because in SEEN:
        scene, value = worst(design, name)
        if scene is not None and value > SEEN_PX and name not in told:
            weight = 40.0 + min(35.0, value)
            yield weight, Risk(what, because + in_which_scene(design, scene), f"{format_quantity(value, 'px')}")


#: What takes the detail of the corners, by how far it spreads a point.
BLURS = (("defocus_corner_px", "they are out of focus by"), ("lateral_colour_px", "the flat port spreads colours over"))


def lost_in_corners(result: Result, design: Design) -> Weighed:
    """Corners in which bars of two pixels (half of Nyquist's frequency) keep too little contrast to be resolved.

    The less they keep, the larger the part of every image that shows no detail, as where it is dark.
    """
    scene, kept = worst(design, "mtf_half_nyquist_corner", least=True)
    if scene is None or kept >= RESOLVED_CONTRAST:
        return
    known = [(told, scene.figures.get(name) or 0.0) for name, told in BLURS]
    causes = listed([f"{told} {format_quantity(value, 'px')}" for told, value in known if value >= TELLING_PX])
    because = (causes or "lens, diffraction and motion blur them") + in_which_scene(design, scene)
    share = f"{100.0 * kept:.2g} %" if kept > 0.0 else "none"
    figure = f"two-pixel bars keep {share} of their contrast"
    yield 78.0 - 20.0 * kept / RESOLVED_CONTRAST, Risk("fine detail is lost in the corners", because, figure)


def smeared_subjects(result: Result, design: Design) -> Weighed:
    """Subjects that move while the mission asks for no limit of motion blur."""
    swim = any(given.get("subject_speed_m_s") for given in result.mission.get("scenes") or [])
    if not swim or any(margin.requirement == "max_blur_px" for margin in design.margins):
        return
    scene, value = worst(design, "blur_px")
    if scene is not None and value > SEEN_PX:
        because = f"no limit of motion blur is asked for{in_which_scene(design, scene)}"
        yield 44.0, Risk("what moves is smeared", because, format_quantity(value, "px"))


def must_stand_still(result: Result, design: Design) -> Weighed:
    """Light that is gathered so long that a slow drift smears it, where the mission says that nothing moves."""
    still = [scene for scene in design.scenes if scene.figures.get("blur_px") == 0.0 and scene.figures.get("gsd_mm")]
    lit = [(gathering_s(result, scene), scene) for scene in still]
    if not lit:
        return
    lit_s, scene = max(lit, key=lambda item: item[0] / item[1].figures["gsd_mm"])
    drift_mm_s = scene.figures["gsd_mm"] / lit_s if lit_s else math.inf
    if drift_mm_s < STILL_MM_S:
        because = (
            f"{format_quantity(1e3 * lit_s, 'ms')} of light smear by a pixel at a drift of "
            f"{format_quantity(drift_mm_s, 'mm/s')}{in_which_scene(design, scene)}, and the mission says that "
            "nothing moves; speed_m_s or limits.max_exposure_ms asks for less"
        )
        yield 58.0, Risk("camera and scene must stand still", because, "")


def gathering_s(result: Result, scene: SceneResult) -> float:
    """How long an image gathers light: the pulse in the dark, the exposure under the sun or where lamps burn."""
    sunlit = any(one.get("sun_lux") for one in result.mission.get("scenes") or [] if one.get("name") == scene.name)
    exposure_ms, pulse_ms = (scene.settings.get(key) or 0.0 for key in ("exposure_ms", "pulse_ms"))
    return 1e-3 * (min(exposure_ms, pulse_ms) if pulse_ms and not sunlit else exposure_ms)


def weak_colours(result: Result, design: Design) -> Weighed:
    """Channels that must be amplified much."""
    scene, value = worst(design, "white_balance")
    if scene is None or value <= REFUSED["white_balance"][1]:
        return
    lifted = {"green": 1.0} | {name: scene.figures.get(f"white_balance_{name}") or 0.0 for name in ("red", "blue")}
    colour = max(lifted, key=lambda name: lifted[name])
    because = f"so little {colour} arrives that white balance lifts it, and its noise"
    yield 42.0, Risk(f"{colour} is mostly noise", because, f"white balance x {value:.2g}")


def wide_open(result: Result, design: Design) -> Weighed:
    """A lens at its widest."""
    if any(m.requirement == "f_number_min" and m.binding for m in design.margins):
        stop = min(s.settings.get("f_number") or 0.0 for s in design.scenes)
        because = (
            "every lens is least sharp there, above all in the corners; stopping down asks for more light"
        )
        yield 35.0, Risk("the lens is used wide open", because, f"f/{stop:.3g}")


def high_gain(result: Result, design: Design) -> Weighed:
    """Gain in place of light."""
    gain_db = max((s.settings.get("gain_db") or 0.0) for s in design.scenes)
    if gain_db > MOST_GAIN_DB:
        because = "little of the pixel's capacity is used, so highlights are lost early"
        yield 26.0, Risk("gain stands in for light", because, format_quantity(gain_db, "dB"))

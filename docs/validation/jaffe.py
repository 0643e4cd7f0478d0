# ruff: noqa: E501 - a line of the page's text is as long as the expressions in it
"""Section 6: Jaffe's trend, contrast against the distance between lamp and camera."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import Any

from . import common

BASELINES_M = (0.15, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
SCENES = (("II", 4.0), ("3C", 2.0))


def figures(water: str, altitude_m: float, baseline_m: float) -> dict[str, Any]:
    """One lamp beside the camera, aimed straight down."""
    mission = {
        "name": "jaffe", "physics": "full",
        "scene": {"water": water, "water_table": "solonenko-mobley", "seafloor": 0.2, "depth_m": 100},
        "vehicle": {"altitude_m": altitude_m, "speed_m_s": 0.0}, "requirements": {"frame_interval_s": 1.0},
    }  # fmt: skip
    system = {
        "camera": "seed-imx250m", "lens": {"focal_length_mm": 12, "transmission": 0.9},
        "port": {"geometry": "dome", "outer_radius_mm": 70, "thickness_mm": 5, "refractive_index": 1.5},
        "light": {
            "flux_lm": 10_000, "power_w": 100, "spectrum": "generic-led", "beam": "cosine-power", "beam_half_angle_deg": 40,
        },
        "light_mounts": [{"y_m": baseline_m}],
        "settings": {"f_number": 4.0, "exposure_ms": 5.0, "gain": 1.0, "flux_lm": 10_000},
    }  # fmt: skip
    return common.figures(mission, system)


@cache
def curves() -> dict[str, list[dict[str, Any]]]:
    """All figures by water."""
    return {water: [figures(water, d, b) for b in BASELINES_M] for water, d in SCENES}


def figure() -> str:
    """Contrast, and veil over signal."""
    drawn, (left, right) = common.canvas(2)
    for color, (water, altitude) in zip(("C0", "C2"), SCENES, strict=True):
        seen = curves()[water]
        left.plot(
            BASELINES_M,
            [s["contrast"] for s in seen],
            "o-",
            color=color,
            label=f"type {water}, {altitude:g} m",
        )
        back = [s["electrons_backscatter"] / s["electrons_signal"] for s in seen]
        right.plot(BASELINES_M, back, "o-", color=color, label=f"backscatter, {water}")
        forward = [s["electrons_forward"] / s["electrons_signal"] for s in seen]
        right.plot(BASELINES_M, forward, "x--", color=color, label=f"forward, {water}")
    left.set(xlabel="lamp to camera [m]", ylabel="contrast: image-forming / all light", ylim=(0, 1))
    right.set(xlabel="lamp to camera [m]", ylabel="veil over image-forming light", yscale="log")
    left.legend(fontsize=7)
    right.legend(fontsize=7)
    return common.save(drawn, "jaffe", "Contrast against the distance between lamp and camera")


def rising(values: list[float]) -> bool:
    """Whether each is above the one before."""
    return all(b > a for a, b in pairwise(values))


def section() -> str:
    """The text."""
    rows, words = [], []
    for water, altitude in SCENES:
        seen = curves()[water]
        contrast = [s["contrast"] for s in seen]
        back = [s["electrons_backscatter"] / s["electrons_signal"] for s in seen]
        rows.append([f"contrast, {water}, {altitude:g} m", *(f"{c:.3f}" for c in contrast)])
        rows.append([f"backscatter / signal, {water}", *(f"{b:.3g}" for b in back)])
        best = max(range(len(contrast)), key=contrast.__getitem__)
        words.append(
            f"type {water}: contrast {contrast[0]:.3f} to {contrast[best]:.3f}, "
            f"{'rising monotonely' if rising(contrast[: best + 1]) else 'NOT monotone'} up to {BASELINES_M[best]:g} m"
            + (f", then {contrast[-1]:.3f} at {BASELINES_M[-1]:g} m" if best + 1 < len(contrast) else "")
            + f"; backscatter over signal falls {back[0] / back[-1]:.0f}-fold, "
            f"{'monotonely' if rising(back[::-1]) else 'NOT monotonely'}"
        )
    return f"""\
**In short:** {"; ".join(words)}.

Independent of: the model, as a trend. Jaffe (1990) found by simulation, and divers know, that moving the lamp away from
the camera raises the contrast, the more the more turbid the water and the longer the range; his curves are not digitised
here, so that only direction and monotony are compared. One lamp of 80° full width beside a dome, aimed straight down,
12 mm lens; `contrast` is image-forming light over all light, mean over the image.

{figure()}

{common.table(["lamp to camera [m]", *(f"{b:g}" for b in BASELINES_M)], rows)}

What falls short: the forward veil hardly depends on the lamp's place and bounds the contrast from above (where backscatter
is gone, a lamp still farther away only changes which colours and parts of the image count); the veil itself
is single scattering (section 3 says how much that leaves out).
"""

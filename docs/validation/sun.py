# ruff: noqa: E501 - a line of the page's text is as long as the expressions in it
"""Section 8: sunlight at 30 m in type II water, in lamps at 2 m."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from . import common

DEPTH_M, ALTITUDE_M, WATER = 30.0, 2.0, "II"
STATED_KLM = 130.0
LAMPS_LM = 100_000.0
NOONS_LX = (100_000.0, 110_000.0, 130_000.0)
BEAMS: dict[str, tuple[str, float]] = {
    "disc, 45° half": ("disc", 45.0), "cosine-power, 40° half": ("cosine-power", 40.0),
    "cosine-power, 60° half": ("cosine-power", 60.0), "cone, 60° half": ("cone", 60.0),
}  # fmt: skip


def case(sun_lux: float, beam: str, half_angle: float, *, many: bool) -> tuple[dict[str, Any], dict[str, Any]]:
    """Continuous lamps over the port beside a dome; a long lens, so that the image is the axis.

    many : light of all orders of scattering counts, not of one, as by hand
    """
    mission = {
        "name": "noon", "physics": "full",
        "scene": {
            "water": WATER, "water_table": "solonenko-mobley", "seafloor": 0.2, "depth_m": DEPTH_M, "sun_lux": sun_lux,
            "multiple_scattering": many,
        },
        "vehicle": {"altitude_m": ALTITUDE_M, "speed_m_s": 0.0}, "requirements": {"frame_interval_s": 1.0},
    }  # fmt: skip
    system = {
        "camera": "seed-imx250m", "lens": {"focal_length_mm": 200, "transmission": 0.9},
        "port": {"geometry": "dome", "outer_radius_mm": 70, "thickness_mm": 5, "refractive_index": 1.5},
        "light": {
            "flux_lm": LAMPS_LM, "power_w": 1000, "spectrum": "generic-led", "beam": beam, "beam_half_angle_deg": half_angle,
        },
        "light_mounts": [{"y_m": 0.15}],
        "settings": {"f_number": 8.0, "exposure_ms": 1.0, "gain": 1.0, "flux_lm": LAMPS_LM},
    }  # fmt: skip
    return mission, system


def daylight() -> common.Array:
    """D65 of one lux [W/m^2/nm]."""
    nm, power = common.column("light_spectra.csv", "wavelength_nm", "relative_power", name="CIE D65")
    shape = np.interp(common.WAVES_NM, nm, power)
    return np.asarray(shape / (common.LUMENS_PER_W * (common.photopic() * shape * common.STEPS_NM).sum()))


def axis_per_lm(beam: str, half_angle: float) -> float:
    """Illuminance on the floor below a lamp 0.15 m aside, per lumen, without the water's loss [1/m^2]."""
    b, aside = math.radians(half_angle), math.atan(0.15 / ALTITUDE_M)
    if beam == "disc":
        intensity = 1 / (math.pi * math.tan(b) ** 2 * math.cos(aside) ** 3)
    elif beam == "cone":
        intensity = 1 / (2 * math.pi * (1 - math.cos(b)))
    else:
        m = math.log(0.5) / math.log(math.cos(b))
        intensity = (m + 1) / (2 * math.pi) * math.cos(aside) ** m
    return intensity * math.cos(aside) ** 3 / ALTITUDE_M**2


def by_hand() -> tuple[dict[str, float], float, float]:
    """Lamp lumens that equal 100 klx at the surface in electrons, by beam; floor lux; the same in lux for the disc."""
    a, b, kd = common.jerlov(WATER)
    k, kd = np.clip(kd, a + 0.0183 * b, a + b), np.minimum(kd, a + b)
    sun = daylight() * 0.95 * np.exp(-kd * DEPTH_M)
    lamp = common.led() * np.exp(-k * math.hypot(ALTITUDE_M, 0.15))
    seen = common.efficiency("seed-imx250m") * common.WAVES_NM / common.index_of_water(10.0, 35.0) ** 2
    seen = seen * np.exp(-(a + b) * ALTITUDE_M) * common.STEPS_NM
    lux = common.LUMENS_PER_W * common.photopic() * common.STEPS_NM
    electrons = 1e5 * float((sun * seen).sum() / (lamp * seen).sum())
    in_lux = 1e5 * float((sun * lux).sum() / (lamp * lux).sum())
    floor_lux = 1e5 * float((sun * lux).sum())
    return (
        {name: electrons / axis_per_lm(*beam) for name, beam in BEAMS.items()},
        floor_lux,
        in_lux / axis_per_lm("disc", 45.0),
    )


def by_uwopt(beam: str, half_angle: float, sun_lux: float = 100_000.0, *, many: bool = False) -> float:
    """The same lumens from `evaluate`: image-forming electrons with and without sun."""
    lamps = common.figures(*case(0.0, beam, half_angle, many=many))["electrons_signal"]
    both = common.figures(*case(sun_lux, beam, half_angle, many=many))["electrons_signal"]
    return float(LAMPS_LM * (both - lamps) / lamps)


def section() -> str:
    """The text."""
    hand, floor_lux, in_lux = by_hand()
    told = {name: by_uwopt(*beam) for name, beam in BEAMS.items()}
    off = {name: told[name] / hand[name] - 1 for name in BEAMS}
    widened = by_uwopt("disc", 45.0, many=True)
    rows = [
        [name, f"{hand[name] / 1e3:.1f}", f"{told[name] / 1e3:.1f}", common.percent(off[name], 2),
         *(f"{told[name] * lux / 1e8:.0f}" for lux in NOONS_LX)]
        for name in BEAMS
    ]  # fmt: skip
    span = [told[name] * lux / 1e8 for name in BEAMS for lux in NOONS_LX]
    verdict = "lies within" if min(span) <= STATED_KLM <= max(span) else "lies outside"
    head = [
        "beam",
        "100 klx, by hand [klm]",
        "uwopt [klm]",
        "difference",
        *(f"{x / 1e3:.0f} klx [klm]" for x in NOONS_LX),
    ]
    return f"""\
**In short:** 100 klx at the surface are {told["disc, 45° half"] / 1e3:.0f} klm of lamps (disc of 45°), within {100 * max(map(abs, off.values())):.2f} % of the calculation by hand; stated: about {STATED_KLM:.0f}.

Independent of: uwopt's daylight, its loss tables and its image integrals; shared are the tables (D65, K_d, a, b, quantum
efficiency) and the formula E = D65 · 0.95 · exp(-K_d depth). Floor {DEPTH_M:.0f} m deep, camera {ALTITUDE_M:.0f} m above it, sun at 60°, lamps
that burn through the exposure: the lumens whose image-forming electrons (IMX250, image of a 200 mm lens; by hand: its axis)
equal the sun's. Both count light scattered once alone (`multiple_scattering: false`): with all orders, which bring lamp light back
and move it into the disc's dim middle, {widened / 1e3:.0f} klm of it do.

{common.table(head, rows)}

Largest difference {common.percent(common.farthest(off.values()), 2)}. 100 klx at the surface are {floor_lux:.0f} lx on that floor; equal in lux
instead of electrons they would be {in_lux / 1e3:.0f} klm of the disc beam. The physics page says "about {STATED_KLM:.0f} klm" without beam or
surface illuminance; {STATED_KLM:.0f} {verdict} {min(span):.0f} to {max(span):.0f} klm, what noon and beam can mean here.

What falls short: waves, clouds and the sun's elevation enter by one factor; K_d is the same at all depths; Jerlov's types
are classes, and at {DEPTH_M:.0f} m a K_d that is 0.01 1/m off changes the light by {100 * -math.expm1(-0.01 * DEPTH_M):.0f} %.
"""

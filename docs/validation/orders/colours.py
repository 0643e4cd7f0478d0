"""What one widened lobe for all colours misses, in waters whose scattering and absorption change with the colour."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from uwopt.forward.lamps import relative_spectrum
from uwopt.forward.scene import SceneOptics, scene_optics
from uwopt.mission.mission import load_mission
from uwopt.model import beam as beams
from uwopt.model.multiple import TESTED_THICKNESS
from uwopt.model.spectrum import trapezoid_weights_nm

WATERS = {"solonenko-mobley": ("I", "II", "III", "1C", "3C", "5C", "7C", "9C"), "measured": ("IB", "II", "3C", "5C")}
LOBE_DEG, ANGLES_DEG, STEP = 15.0, (0.0, 30.0, 45.0), 12  # of the grid of wavelengths
THICKNESSES = (1.0, 2.0, TESTED_THICKNESS)  # c d at the colour that is told best


def scene_of(water: str, table: str) -> SceneOptics:
    """A Jerlov water over a grey floor."""
    asked = {
        "name": "colours", "practice": "bare", "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3}, "requirements": {},
        "scene": {"water": water, "water_table": table, "seafloor": 0.2, "depth_m": 50},
    }  # fmt: skip
    return scene_optics(load_mission(asked).scene_view(0), paper=False, base_dir=Path())


@cache
def off_by_angle() -> tuple[float, ...]:
    """Largest relative difference of all light on a floor from that by a lobe of each colour, at each of the angles."""
    lobe, worst = beams.cosine_power_beam(np.deg2rad(2 * LOBE_DEG)), np.zeros(len(ANGLES_DEG))
    for scene in (scene_of(water, table) for table, waters in WATERS.items() for water in waters):
        for thickness in THICKNESSES:
            worst = np.maximum(worst, np.abs(off_in(scene, lobe, thickness / float(scene.attenuation_per_m.min()))))
    return tuple(map(float, worst))


def off_in(scene: SceneOptics, lobe: beams.Beam, way_m: float) -> np.ndarray:
    """The same in one water over one way."""
    cos, colours = np.cos(np.deg2rad(ANGLES_DEG)), np.arange(0, len(scene.wavelength_nm), STEP)
    sent = np.zeros_like(scene.wavelength_nm)
    sent[colours] = relative_spectrum(("generic-led", None), scene.wavelength_nm)[colours]
    lost = scene.attenuation_per_m + scene.lamp_leg_per_m(beams.half_power_angle_rad(lobe))
    told = sent * trapezoid_weights_nm(scene.wavelength_nm)
    seen = told * np.exp(-(lost - lost[told > 0].min()) * way_m)
    each = np.zeros(len(cos))
    for k in np.flatnonzero(seen > 1e-4 * seen.max()):
        alone = np.where(np.arange(len(sent)) == k, sent, 0.0)
        each += seen[k] * beams.intensity_per_sr(cos, scene.widened_lobe(lobe, alone, way_m=way_m), way_m)
    one = beams.intensity_per_sr(cos, scene.widened_lobe(lobe, sent, way_m=way_m), way_m)
    return np.asarray(one * seen.sum() / each - 1.0)

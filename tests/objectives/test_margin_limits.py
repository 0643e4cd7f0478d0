"""Every requirement holds just inside its limit and is missed just outside; a margin without a case fails.

Values of geometry, time and totals are worked out here by hand, for physics `paper` behind a flat port: the
effective focal length is 1.33 f. Figures that rest on spectra are read from the design and combined by hand.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import atan, degrees, hypot, log2, log10, pi, radians, sin, sqrt, tan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import uwopt
from uwopt.api.common import prepared
from uwopt.api.evaluating import scene_settings
from uwopt.evaluation.design_model import design_model
from uwopt.forward.assembly import system_problem
from uwopt.forward.designs import SceneSettings
from uwopt.mission.mission import load_mission
from uwopt.mission.system import load_system
from uwopt.objectives.requirements import MarginRows

PACKAGE = Path(uwopt.__file__).parent
JUST = 1e-5  # of a limit; 1e-6 is allowed for rounding

MISSION: dict[str, Any] = {
    "practice": "bare", "name": "limits", "physics": "paper",
    "scene": {"water": "II", "seafloor": 0.2, "depth_m": 300.0},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, "light_baseline_m": 0.5, "light_count": [2, 2]},
    "catalog": {"extras": [{"name": "housing", "cost": 50.0, "mass_kg": 3.0, "power_w": 6.0}]},
    "requirements": {"circle_of_confusion_px": 2.0}, "fixed": {}, "limits": {}, "reserve": {},
}  # fmt: skip
SYSTEM: dict[str, Any] = {
    "camera": {"resolution_x_px": 2000, "resolution_y_px": 1000, "pixel_pitch_um": 5.0, "read_noise_e": 5.0,
               "quantum_efficiency": 0.5, "bit_depth": 12, "gain_dn_per_e": 0.5, "saturation_e": 20_000,
               "max_frame_rate_hz": 10.0, "price": 1000.0, "mass_g": 500.0, "power_w": 4.0},
    "lens": {"focal_length_mm": 10.0, "f_number_min": 1.4, "f_number_max": 16.0, "price": 300.0, "mass_g": 100.0},
    "port": {"id": "port", "geometry": "flat", "gap_mm": 5.0, "thickness_mm": 10.0, "price": 200.0, "mass_g": 300.0},
    "light": {"id": "lamp", "flux_lm": 10_000, "power_w": 100.0, "beam": "cosine-power", "beam_half_angle_deg": 40.0,
              "price": 400.0, "mass_g": 700.0},
    "housing": None,
    "camera_count": 1,
    "spacer_mm": None,
    "light_count": 2,
    "settings": {"f_number": 4.0, "exposure_ms": 1.0, "gain": 1.0, "frame_rate_hz": 2.0},
}  # fmt: skip
PAIR = {"vehicle.camera_count": 2, "camera_count": 2, "vehicle.camera_baseline_m": 0.4}
PULSED = {"light.kind": "pulsed_led", "settings.pulse_ms": 0.5}
FLASH = {
    **{"light.kind": "flash", "light.flux_lm": None, "light.power_w": None},
    **{"light.flash_energy_j": 10.0, "light.flash_duration_us": 1000.0},
}
FULL = {"physics": "full"}
#: A body of 50 mm across its corners, 30 mm from the entrance pupil to it, 80 mm from there to the end of the plug.
BODIES = {
    "camera.body_width_mm": 30.0, "camera.body_height_mm": 40.0, "camera.body_length_mm": 35.0, "camera.plug_mm": 45.0,
    "lens.diameter_mm": 30.0, "lens.length_mm": 50.0, "lens.pupil_mm": 20.0,
}  # fmt: skip
ROOM = {
    "inner_diameter_mm": 80.0, "inner_length_mm": 160.0, "outer_diameter_mm": 100.0, "outer_length_mm": 200.0,
    "mass_g": 1000.0,
}  # fmt: skip
IN_WATER_KG = 0.5 + 0.1 + 0.3 + 1.0 - 1025.0 * pi / 4.0 * 0.1**2 * 0.2
#: Flat curves: of the mean, (R + 2 G + B) / 4 = 0.55, red has 0.2.
CHANNELS = str(Path(__file__).parents[1] / "reference" / "flat_channels.csv")
COLOUR = {"camera.colour": "colour", "camera.quantum_efficiency": CHANNELS}

FOCAL_M, PIXEL_M = 1.33 * 10e-3, 5e-6
GSD_M = 2.0 * PIXEL_M / FOCAL_M
BLUR_PX = 0.5 * 1e-3 / GSD_M
SKEW_PX = 0.5 * 0.1 / GSD_M  # all rows of a 10 Hz camera are read in 0.1 s
OVERLAP = 1.0 - 0.5 / (2.0 * 1000 * GSD_M)
CORNER_MM = hypot(1000, 500) * 5e-6 / 10e-3 * 5.0  # of the view in air, 5 mm behind the window


def depth_of_field_m(focus_m: float) -> tuple[float, float]:
    """Near and far end by the thin lens at F4 and a circle of two pixels."""
    half = 4.0 * 2.0 * PIXEL_M * (1.0 - FOCAL_M / focus_m) / FOCAL_M**2
    return 1.0 / (1.0 / focus_m + half), 1.0 / (1.0 / focus_m - half)


NEAR_M, FAR_M = depth_of_field_m(2.0)
FAR_OF_NEARER_FOCUS_M = depth_of_field_m(1.5)[1]


def changed(base: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """A nested mapping with other values at dotted keys; None removes a key. Keys of other mappings are passed."""
    out = {key: dict(value) if isinstance(value, dict) else value for key, value in base.items()}
    for path, value in changes.items():
        section, _, key = path.partition(".")
        if section not in out:
            continue
        if not key:
            out[section] = value
        elif value is None:
            out[section].pop(key)
        else:
            out[section][key] = value
    return out


class Design:
    """One design, its margins by name, and figures as `evaluate` would report them."""

    def __init__(self, changes: dict[str, Any], *, given: dict[str, Any] | None = None):
        mission = prepared(load_mission(changed(MISSION, changes)), None, None)
        system = load_system(changed(SYSTEM, changes))
        problem, hardware = system_problem(mission, system)
        self.model = design_model(problem, hardware)
        wanted: SceneSettings = replace(scene_settings(problem, hardware, system, "scene 1"), **(given or {}))
        self.settings = self.model.settings(0, wanted)
        self.figures = self.model.figures(0, self.settings, information=not problem.paper)

    def margins(self) -> dict[str, MarginRows]:
        return {m.requirement: m for m in self.model.margins(0, self.settings, self.figures)}


@cache
def reached(figure: str, *changes: tuple[str, Any]) -> float:
    """A figure of the design at its one altitude."""
    return float(np.ravel(getattr(Design(dict(changes)).figures, figure))[0])


def snr_db(share: float = 1.0, **changes: Any) -> float:
    """From a share of the electrons: K is 0.5 DN of 12 bit, 8 of the paper's 16."""
    electrons = share * reached("electrons_signal", *changes.items())
    return 20.0 * log10(electrons / sqrt(5.0**2 + 1.0 / (12.0 * 8.0**2) + electrons))


def full_snr_db() -> float:
    """The image's mean, as 12 bit and veil leave it."""
    signal, *veil = (reached(f"electrons_{name}", *FULL.items()) for name in ("signal", "forward", "backscatter"))
    return 20.0 * log10(signal / sqrt(5.0**2 + 1.0 / (12.0 * 0.5**2) + signal + sum(veil)))


def contrast() -> float:
    signal, forward, back = (
        reached(f"electrons_{name}", *FULL.items()) for name in ("signal", "forward", "backscatter")
    )
    return signal / (signal + forward + back)


def figure(name: str, changes: dict[str, Any]) -> float:
    result = uwopt.evaluate(changed(MISSION, changes), changed(SYSTEM, changes))
    assert result.design is not None
    return float(result.design.scenes[0].figures[name])


def uniformity() -> float:
    return figure("uniformity", FULL)


def airy_px() -> float:
    return figure("airy_diameter_um", {}) / 5.0


def beside_the_view(clear_m: float) -> list[dict[str, float]]:
    """Two lamps 0.5 m below the port, this far from the plane of the rays to the side of the image.

    Behind the flat port a ray at the edge, tangent 0.5 in air, goes 5 mm of gap, 10 mm of glass and water.
    """
    problem = Design(dict(FULL)).model.problem
    indices = (problem.scenes[0].n_water, float(problem.ports.refractive_index[0]))
    sine = 0.5 / hypot(0.5, 1.0)
    water, glass = (sine / index / sqrt(1.0 - (sine / index) ** 2) for index in indices)
    edge_m = 0.005 * 0.5 + 0.010 * glass + 0.5 * water
    side_m = edge_m + clear_m * hypot(1.0, water)
    return [{"y_m": side_m, "z_m": 0.5}, {"y_m": -side_m, "z_m": 0.5}]


Changes = dict[str, Any]


def high(key: str, value: float, **more: Any) -> Callable[[float], Changes]:
    """A highest value that the design's own passes by a share."""
    return lambda over: {**more, key: value / (1.0 + over)}


def low(key: str, value: float, **more: Any) -> Callable[[float], Changes]:
    """A least value that the design's own misses by a share."""
    return lambda over: {**more, key: value * (1.0 + over)}


#: Requirement, and what puts the design beyond its limit by a share (inside, where that is below 0).
CASES: list[tuple[str, Callable[[float], Changes]]] = [
    ("max_blur_px", high("requirements.max_blur_px", BLUR_PX)),
    ("max_skew_px", high("requirements.max_skew_px", SKEW_PX, **{"camera.shutter": "rolling"})),
    ("overlap", low("requirements.overlap", OVERLAP)),
    ("frame_interval_s", high("requirements.frame_interval_s", 1.0 / 2.0)),
    ("frame_rate", high("camera.max_frame_rate_hz", 2.0)),
    ("frame_rate", high("camera.bandwidth_mb_s", 2.0 * 2000 * 1000 * 12 / 8 / 1e6)),
    ("dof_near_m", lambda over: {
        "requirements.min_dof_m": 0.1, "vehicle.altitude_tolerance_m": 2.0 - NEAR_M / (1.0 + over)}),
    ("dof_far_m", lambda over: {
        "requirements.min_dof_m": 0.1, "settings.focus_distance_m": 1.5,
        "vehicle.altitude_tolerance_m": FAR_OF_NEARER_FOCUS_M * (1.0 + over) - 2.0}),
    ("dof_near_m", lambda over: {"vehicle.altitude_m": NEAR_M / (1.0 + over), "settings.focus_distance_m": 2.0}),
    ("dof_far_m", lambda over: {"vehicle.altitude_m": FAR_M * (1.0 + over), "settings.focus_distance_m": 2.0}),
    ("min_dof_m", low("requirements.min_dof_m", FAR_M - NEAR_M)),
    ("max_gsd_mm", high("requirements.max_gsd_mm", GSD_M * 1e3)),
    ("min_swath_m", low("requirements.min_swath_m", 2000 * GSD_M)),
    ("min_common_swath_m", low("requirements.min_common_swath_m", 2000 * GSD_M - 0.4, **PAIR)),
    ("min_common_swath_m", low(
        "requirements.min_common_swath_m", (2000 * GSD_M - 0.4) / 1.1, **PAIR, **{"reserve.swath": 0.1})),
    ("min_common_swath_m", lambda over: {  # the inner edges of views of 500 in 1330 to a side, turned by 2 deg, decide
        **PAIR, "vehicle.camera_convergence_deg": 4.0, "requirements.min_common_swath_m": 2.0 * (
            2.0 * tan(radians(2.0) + atan(1000 * PIXEL_M / FOCAL_M)) - 0.2) * (1.0 + over)}),
    ("max_depth_error_mm", high("requirements.max_depth_error_mm", 0.3 * GSD_M * 1e3 * 2.0 / 0.4, **PAIR, **{
        "requirements.disparity_error_px": 0.3})),
    ("min_snr_db", lambda over: {"requirements.min_snr_db": snr_db() * (1.0 + over)}),
    ("min_snr_red_db", lambda over: {
        **COLOUR, "requirements.min_snr_red_db": snr_db(0.2 / 0.55, **COLOUR) * (1.0 + over)}),
    ("min_snr_red_db", lambda over: {
        **COLOUR, "requirements.min_snr_red_db": snr_db(0.2 / 0.55, **COLOUR) * (1.0 + over) - 3.0,
        "reserve.snr_db": 3.0}),
    ("max_white_balance", high("requirements.max_white_balance", 0.8 / 0.2, **COLOUR)),
    ("min_mtf_half_nyquist", lambda over: {
        **FULL, "requirements.min_mtf_half_nyquist":
            reached("mtf_half_nyquist", *FULL.items(), ("requirements.min_mtf_half_nyquist", 0.1)) * (1.0 + over)}),
    ("resolve_mm", lambda over: {
        **FULL, "requirements.resolve_mm":
            1e3 * reached("smallest_bars_m", *FULL.items(), ("requirements.resolve_mm", 50.0)) / (1.0 + over)}),
    ("min_contrast", lambda over: {**FULL, "requirements.min_contrast": contrast() * (1.0 + over)}),
    ("min_uniformity", lambda over: {**FULL, "requirements.min_uniformity": uniformity() * (1.0 + over)}),
    ("mean_level", lambda over: {"requirements.mean_level": reached("mean_level") * (1.0 + max(over, 0.0))}),
    ("mean_level", lambda over: {"requirements.mean_level": reached("mean_level") * (1.0 - max(over, 0.0))}),
    ("saturation_fraction", lambda over: {"requirements.highlight_ratio": (1.0 + over) / reached("mean_level")}),
    ("saturation_fraction", lambda over: {
        "camera.saturation_e": 2.0 * reached("electrons_signal"), "requirements.highlight_ratio": 2.0 * (1.0 + over)}),
    ("max_blur_px", high("requirements.max_blur_px", BLUR_PX / 0.8, **{"reserve.blur": 0.2})),
    ("min_swath_m", low("requirements.min_swath_m", 2000 * GSD_M / 1.1, **{"reserve.swath": 0.1})),
    ("min_dof_m", low("requirements.min_dof_m", (FAR_M - NEAR_M) / 1.1, **{"reserve.dof": 0.1})),
    ("min_snr_db", lambda over: {
        "requirements.min_snr_db": snr_db() * (1.0 + over) - 3.0, "reserve.snr_db": 3.0}),
    ("min_snr_db", lambda over: {
        "requirements.min_snr": 10.0 ** ((snr_db() * (1.0 + over) - 3.0) / 20.0), "reserve.snr_db": 3.0}),
    ("min_snr_mean_db", lambda over: {
        **FULL, "requirements.snr_at": "worst", "requirements.snr_at_less_db": 30.0,
        "requirements.min_snr_db": full_snr_db() * (1.0 + over) - 3.0, "reserve.snr_db": 3.0}),
    ("max_skew_px", lambda over: {
        "requirements.refuse": ["skew"], "camera.shutter": "rolling", "vehicle.speed_m_s": 0.5 * 2.0 / SKEW_PX * (
            1.0 + over)}),
    ("min_swath_m", lambda over: {
        "requirements.refuse": ["swath"], "requirements.overlap": 0.0,
        "vehicle.altitude_m": 1.0 / (2000 * PIXEL_M / FOCAL_M) / (1.0 + over)}),
    ("lens_stop_down", low("requirements.lens_stop_down", 2.0 * log2(4.0 / 1.4))),
    ("max_airy_px", lambda over: {"requirements.max_airy_px": airy_px() / (1.0 + over)}),
    ("max_airy_px", lambda over: {
        "requirements.refuse": ["airy"], "settings.f_number": 4.0 * 2.0 / airy_px() * (1.0 + over)}),
    ("housing_diameter_mm", lambda over: {
        **BODIES, "housing": {**ROOM, "inner_diameter_mm": (50.0 + 2 * 2.0) / (1.0 + over)}}),
    ("housing_length_mm", lambda over: {
        **BODIES, "housing": {**ROOM, "inner_length_mm": (50.0 + 35.0 + 45.0 + 2.0) / (1.0 + over)}}),
    ("housing_diameter_mm", lambda over: {
        **BODIES, "housing": {"shape": "sphere", "inner_diameter_mm": 2 * (hypot(110.0, 25.0) + 2.0) / (1.0 + over)}}),
    ("dome_radius_mm", lambda over: {
        **BODIES, "housing": ROOM, "port.geometry": "dome", "port.gap_mm": None,
        "port.outer_radius_mm": 10.0 + (hypot(20.0, 15.0) + 2.0) / (1.0 + over)}),
    ("tube_mouth_mm", lambda over: {  # the corner's ray, of 5 and 2.5 in 10, 100 mm behind the window
        **FULL, **BODIES, "port.gap_mm": 100.0, "housing": {
            **ROOM, "inner_length_mm": 1e3, "inner_diameter_mm": 2 * 100.0 * hypot(5.0, 2.5) / 10.0 / (1.0 + over)}}),
    ("port_clears_view_mm", lambda over: {  # of a cap of 60 mm inside, half of whose opening the corner sees
        **FULL, "port.geometry": "dome", "port.gap_mm": None, "port.outer_radius_mm": 70.0,
        "port.thickness_mm": 10.0, "port.clear_diameter_mm": 120.0 * sin(atan(hypot(5.0, 2.5) / 10.0 / (1.0 + over)))}),
    ("size_mm", lambda over: {
        **BODIES, "housing": ROOM, "catalog.housing": "required", "limits.size_mm": 200.0 / (1.0 + over)}),
    ("diameter_mm", lambda over: {
        **BODIES, "housing": ROOM, "catalog.housing": "required", "limits.diameter_mm": 100.0 / (1.0 + over)}),
    ("mass_water_kg", lambda over: {
        **BODIES, "housing": ROOM, "catalog.housing": "required",
        "limits.mass_water_kg": IN_WATER_KG / (1.0 + over)}),
    ("f_number_min", low("lens.f_number_min", 4.0)),
    ("f_number_max", high("lens.f_number_max", 4.0)),
    ("nearest_focus_m", low("lens.min_object_distance_m", 2.0)),
    ("farthest_focus_m", lambda over: {
        "spacer_mm": 10.0**2 / (2000.0 / (1.0 + over) - 10.0)}),  # of the lens alone, whatever the window does
    ("gain_min", lambda over: {"given": {"gain": 1.0 / (1.0 + over)}}),
    ("gain_max", lambda over: {"camera.max_gain_db": 20.0 * log10(2.0 / (1.0 + over)), "settings.gain": 2.0}),
    ("max_gain_db", lambda over: {
        "requirements.max_gain_db": 20.0 * log10(2.0) / (1.0 + over), "settings.gain": 2.0}),
    ("max_exposure_ms", high("camera.max_exposure_us", 1000.0)),
    ("max_exposure_ms", high("limits.max_exposure_ms", 1.0)),
    ("max_exposure_ms", lambda over: {"settings.exposure_ms": 1e3 / 2.0 * (1.0 + over)}),
    ("min_exposure_ms", low("camera.min_exposure_us", 1000.0)),
    ("light_level_max", lambda over: {"given": {"level": 1.0 + over}}),
    ("light_level", low("light.dim_min_frac", 0.5, **{"settings.dim_frac": 0.5})),
    ("light_level", lambda over: {
        "light.dim_levels": [0.25, 0.5, 1.0], "settings.dim_frac": 0.5 * (1.0 + max(over, 0.0))}),
    ("fixed_f_number", lambda over: {"fixed.f_number": 4.0, "settings.f_number": 4.0 * (1.0 + max(over, 0.0))}),
    ("fixed_exposure_ms", lambda over: {"fixed.exposure_ms": 1.0, "settings.exposure_ms": 1.0 + max(over, 0.0)}),
    ("fixed_gain", lambda over: {"fixed.gain": 2.0, "settings.gain": 2.0 * (1.0 - max(over, 0.0))}),
    ("fixed_dim_frac", lambda over: {"fixed.dim_frac": 0.5, "settings.dim_frac": 0.5 * (1.0 - max(over, 0.0))}),
    ("max_pulse_ms", high("light.max_pulse_us", 500.0, **PULSED)),
    ("min_pulse_ms", low("light.min_pulse_us", 500.0, **PULSED)),
    ("min_pulse_ms", lambda over: {
        **FLASH, "light.flash_duration_us": 500.0 * (1.0 + over), "settings.pulse_ms": 0.5}),
    ("light_duty", high("light.max_duty_frac", 0.5e-3 * 2.0, **PULSED)),
    ("light_rate", high("light.max_rate_hz", 2.0, **PULSED)),
    ("light_rate", low("light.recycle_s", 1.0 / 2.0, **FLASH)),
    ("shutter_open_ms", lambda over: {
        **PULSED, "camera.shutter": "rolling", "settings.exposure_ms": (100.0 + 0.5) / (1.0 + over)}),
    ("shutter_open_ms", lambda over: {
        **FLASH, "camera.shutter": "rolling", "settings.exposure_ms": (100.0 + 1.0) / (1.0 + over)}),
    ("cost", high("limits.cost", 1000.0 + 300.0 + 200.0 + 2 * 400.0 + 50.0)),
    ("power_w", high("limits.power_w", 4.0 + 2 * 100.0 + 6.0)),
    ("power_w", high("limits.power_w", 4.0 + 2 * 100.0 * 0.5e-3 * 2.0 + 6.0, **PULSED)),
    ("peak_power_w", high("limits.peak_power_w", 4.0 + 2 * 100.0 + 6.0, **PULSED)),
    ("mass_kg", high("limits.mass_kg", 0.5 + 0.1 + 0.3 + 2 * 0.7 + 3.0)),
    ("data_rate_mb_s", high("limits.data_rate_mb_s", 2.0 * 2000 * 1000 * 12 / 8 / 1e6)),
    ("energy_wh", high("limits.energy_wh", (4.0 + 2 * 100.0 + 6.0) * 48.0, **{"vehicle.duration_h": 48.0})),
    ("storage_gb", high(
        "limits.storage_gb", 2.0 * 2000 * 1000 * 12 / 8 * 48.0 * 3600 / 1e9, **{"vehicle.duration_h": 48.0})),
    ("depth_rating_m (port)", lambda over: {"port.depth_rating_m": 300.0 / (1.0 + over)}),
    ("rated_time_h (port)", low("vehicle.duration_h", 336.0, **{"port.rated_time_h": 336.0})),
    ("depth_rating_m (lamp)", lambda over: {"light.depth_rating_m": 300.0 / (1.0 + over)}),
    ("depth_rating_m (port)", lambda over: {
        "port.depth_rating_m": 375.0 / (1.0 + over), "reserve.depth": 1.25}),
    ("depth_rating_m (lamp)", lambda over: {
        "light.depth_rating_m": 330.0 / (1.0 + over), "requirements.refuse": ["depth"]}),
    ("lamp_clear_m", lambda over: {
        **FULL, "requirements.refuse": ["lamp"], "vehicle.light_mounts": beside_the_view(0.02 / (1.0 + over))}),
    ("lamps_apart_m", lambda over: {
        **FULL, "vehicle.lamp_size_m": 0.2 * (1.0 + over), "vehicle.light_baseline_m": 0.1}),
    ("lamp_beside_port_m", lambda over: {
        **FULL, "vehicle.lamp_size_m": 0.2 * (1.0 + over), "vehicle.light_baseline_m": 0.1}),
    ("horizon", lambda over: {
        **FULL, "port.geometry": "dome", "port.outer_radius_mm": 50.0, "port.gap_mm": None,
        "vehicle.pitch_deg": degrees(atan((1.0 - 0.2 / (1.0 + over)) / 0.25))}),  # the far edge at a tangent of 0.25
    ("port_clears_view_mm", high("port.clear_diameter_mm", 2.0 * CORNER_MM, **FULL)),
]  # fmt: skip
NAMES = [name for name, _ in CASES]
#: `gain_min`, `light_duty`, and `light_rate 2` for the second case of a name.
IDS = [
    name if name not in NAMES[:at] else f"{name} {NAMES[: at + 1].count(name)}"
    for at, name in enumerate(NAMES)
]
EACH = pytest.mark.parametrize(("name", "beyond"), CASES, ids=IDS)


#: Held against each other in tests/api/test_one_set_of_rules.py.
OF_SEVERAL_SCENES = {"common_f_number", "common_focus_m"}
#: Of what no inline camera states; in tests/solvers/test_completes.py.
OF_COMPLETE_CAMERAS = {"card_gb", "run_time_h", "lamp_trigger"}


def margin_of(name: str, changes: Changes) -> MarginRows:
    given = changes.pop("given", None)
    return Design(changes, given=given).margins()[name]


@EACH
def test_requirement_holds_just_inside_its_limit(name: str, beyond: Callable[[float], Changes]) -> None:
    assert margin_of(name, beyond(-JUST)).satisfied.all()


@EACH
def test_requirement_is_missed_just_outside_its_limit(name: str, beyond: Callable[[float], Changes]) -> None:
    margin = margin_of(name, beyond(JUST))
    assert not margin.satisfied.any()
    size = max(abs(float(margin.limit[0])), 1e-12)
    assert float(margin.margin[0]) == pytest.approx(
        -JUST * size, rel=1e-2
    )  # (1 + x) and 1 / (1 - x) differ by x


def loop_names(node: ast.AST) -> dict[str, set[str]]:
    """Of `for name, ... in (("cost", ...), ...)`: the variable and the texts it takes."""
    if not (
        isinstance(node, ast.For) and isinstance(node.target, ast.Tuple) and isinstance(node.iter, ast.Tuple)
    ):
        return {}
    firsts = [row.elts[0] for row in node.iter.elts if isinstance(row, ast.Tuple)]
    texts = {str(one.value) for one in firsts if isinstance(one, ast.Constant)}
    return {ast.unparse(node.target.elts[0]): texts}


def names_in(node: ast.AST, loops: dict[str, set[str]]) -> set[str]:
    """First arguments of all `MarginRows(...)`; where it is a loop's variable, what that takes."""
    found: set[str] = set()
    loops = {**loops, **loop_names(node)}
    if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("MarginRows") and node.args:
        first = node.args[0]
        if isinstance(first, ast.JoinedStr):
            first = first.values[0]  # of "name (part)": the name
        if isinstance(first, ast.Constant):
            found.add(str(first.value).rstrip(" ("))
        else:
            found |= loops.get(ast.unparse(first), {f"? {ast.unparse(first)}"})
    return found.union(*(names_in(child, loops) for child in ast.iter_child_nodes(node)))


def test_every_margin_of_the_program_has_a_case() -> None:
    texts = [file.read_text(encoding="utf-8") for file in PACKAGE.rglob("*.py")]
    trees = [ast.parse(text) for text in texts if "MarginRows(" in text]
    written = set[str]().union(*(names_in(tree, {}) for tree in trees))
    assert written == {name.partition(" (")[0] for name in NAMES} | OF_SEVERAL_SCENES | OF_COMPLETE_CAMERAS

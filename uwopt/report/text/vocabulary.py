"""Names of parts, settings and rules, as people read them (of requirements: `quantities`), of all tables and pages."""

from __future__ import annotations

from collections.abc import Mapping

STATUS_SENTENCES: Mapping[str, str] = {
    "optimal": "best of the catalogue under these assumptions, proven",
    "feasible": "every requirement is met",
    "violated": "requirements are missed",
    "infeasible": "no system of the catalogue meets every requirement",
    "stopped": "stopped by a limit before the proof was complete, so better may exist",
}

#: Settings in the order in which they are set, with their unit.
SETTINGS: Mapping[str, tuple[str, str]] = {
    "f_number": ("f-number", ""),
    "focus_distance_m": ("focus, in water from the port", "m"),
    "spacer_mm": ("spacer ring behind the lens", "mm"),
    "focus_scale_m": ("focus on the lens's own scale", "m"),
    "exposure_ms": ("exposure", "ms"),
    "pulse_ms": ("light pulse", "ms"),
    "gain_db": ("gain", "dB"),
    "frame_rate_hz": ("frame rate", "Hz"),
    "flux_lm": ("light of all lamps", "lm"),
    "dim_frac": ("light level", ""),
    "flash_energy_j": ("energy of a flash", "J"),
}

#: Keys of a mission that may be moved.
KEYS: Mapping[str, str] = {
    "altitude_m": "altitude", "altitude_tolerance_m": "tolerance of the altitude", "speed_m_s": "speed",
    "frame_interval_s": "time between images", "duration_h": "duration", "battery_wh": "battery",
    "camera_between_images": "cameras between images", "lamps_between_images": "lamps between images",
    "light_baseline_m": "distance from port to lamps", "light_tilt_deg": "lean of the lamps outward",
    "light_count": "number of lamps",
    "sun_lux": "sunlight at the surface", "visibility_m": "visibility", "secchi_m": "Secchi depth",
    "c_per_m": "beam attenuation", "turbidity_ntu": "turbidity", "water": "type of water",
}  # fmt: skip

AS_WRITTEN: Mapping[str, str] = {"min_snr": "min_snr_db"}  # keys that a mission writes otherwise than rules name them

#: What a note is about, where that has no other name here.
SUBJECTS: Mapping[str, str] = {
    "hardware": "parts", "generic": "parts to be made", "catalog": "catalogue", "tilt_deg": "lean of the lamps",
    "light_baseline_m": "distance from port to lamps", "camera_baseline_m": "distance between cameras",
    "beam_half_angle_deg": "beam of the lamp", "practice": "good practice", "dof_at": "where depth of field holds",
    "snr_at": "where signal to noise holds",
}  # fmt: skip

SIZES: Mapping[str, str] = {  # that stop a fit
    "housing_diameter_mm": "inner diameter of the housing",
    "housing_length_mm": "inner length of the housing",
    "dome_radius_mm": "inner radius of the dome",
    "tube_mouth_mm": "diameter of the housing's mouth",
    "port_width_mm": "diameter of the housing's end",
}

RULES: Mapping[str, str] = {
    "availability": "no longer sold, or never was",
    "purpose": "made and sold for something else",
    "vital facts": "a fact that the model needs is unknown",
    "pattern": "not among the parts the mission names",
    "exclude": "excluded by the mission",
    "port mount": "fits only its maker's housing",
    "verified": "a field that must be sourced is not",
    "colour": "sensor of the other colour type",
    "shutter": "shutter of the other type",
    "interface": "camera's interface is not one that the host has, or unknown",
    "lamp supply": "lamp has its own battery, or its supply is unknown",
    "run time": "its own battery does not last",
    "trigger": "nothing fires the lamp with the camera",
    "rated time": "depth rating holds for shorter dives alone",
    "depth rating": "depth rating too shallow or unknown",
    "setting": "cannot be set as the mission fixes it",
    "generic": "parts to be made, real ones are left",
    "complete": "piece of a complete camera, with other parts",
    "form": "complete cameras or assembled ones, of which the others are asked for",
    "mount": "lens mount does not fit the camera",
    "image_circle": "image circle smaller than the sensor",
    "lens_rating": "lens not sharp enough for the sensor's pixels",
    "view": "port cuts into the view",
    "horizon": "far edge of the frame too near to the horizon, or beyond",
    "focus": "lens cannot focus on the floor through the port",
    "max_gsd_mm": "pixel on the floor too large",
    "min_swath_m": "swath too narrow",
    "min_common_swath_m": "strip that both cameras see too narrow",
    "max_depth_error_mm": "distance by stereo too uncertain",
    "frame_rate": "camera too slow",
    "data_rate_mb_s": "data rate too high",
    "storage_gb": "more images than the storage holds",
    "card_gb": "more images than the camera's own card holds",
    "lens_stop_down": "lens cannot be closed as far as asked",
    "min_dof_m": "depth of field too short at every f-number",
    "max_blur_px": "blurred at the shortest exposure",
    "min_snr": "too little light for the wanted signal",
    "light": "no light gives the wanted signal",
    "settings": "no setting meets the rest",
    "max_white_balance": "colours too far apart",
    "min_mtf_half_nyquist": "not sharp enough at any f-number",
    "resolve_mm": "details too fine at every f-number",
    "cost": "too expensive",
    "mass_kg": "too heavy",
    "mass_water_kg": "too heavy in water",
    "size_mm": "housing too large",
    "diameter_mm": "housing too wide",
    "housing": "camera with lens does not fit into the housing",
    "housing: port": "port does not go on the housing",
    "better_housing": "fits as well into a housing that costs and weighs no more",
    "power_w": "too much power",
    "energy_wh": "too much energy over the mission",
    "bound": "proven not better than the systems shown",
    "not_reached": "not reached in the time allowed",
}

PIECES = ("camera", "lens", "port")  # of a complete camera: the ends of their ids

PARTS_OF_THE_SEARCH = ("search_imagers", "search_bounds", "search_evaluation")

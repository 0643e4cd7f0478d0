"""What motion asks of shutter and rate: blur, skew, frames a second."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward.scene import SceneOptics
from uwopt.forward.views import Views, altitudes_m
from uwopt.mission.sections import Requirements
from uwopt.model import operation
from uwopt.model.imaging import PortShape

Array = NDArray[Any]


def blur_time_s(scene: SceneOptics, shape: PortShape, view: Views) -> Array:
    """Longest light-collecting time within the allowed blur, worst over altitudes and both axes."""
    limit_px = scene.view.requirements.max_blur_px
    count = len(view.tan_along)
    if limit_px is None:
        return np.full(count, np.inf)
    lever = altitudes_m(scene) + shape.outer_radius_m * (not scene.paper)
    return np.asarray(
        np.minimum(
            operation.blur_exposure_s(
                limit_px, ground_sample_m=view.pixel_along_m, **motion_along(scene, lever)
            ),
            operation.blur_exposure_s(
                limit_px, ground_sample_m=view.pixel_across_m, **motion_across(scene, lever)
            ),
        ).min(axis=1)
    )


def shutter_skew_px(scene: SceneOptics, shape: PortShape, view: Views, readout_s: Array) -> Array:
    """Skew of a rolling shutter along the motion, worst over altitudes."""
    lever = altitudes_m(scene) + shape.outer_radius_m * (not scene.paper)
    return np.asarray(
        operation.skew_px(
            readout_s[:, None], ground_sample_m=view.pixel_along_m, **motion_along(scene, lever)
        ).max(axis=1)
    )


def motion_along(scene: SceneOptics, lever_m: Array) -> dict[str, Any]:
    """What moves the floor through the image along the motion: speed and pitch."""
    vehicle = scene.view.vehicle
    return dict(
        speed_m_s=vehicle.speed_m_s, rotation_rate_rad_s=np.deg2rad(vehicle.pitch_rate_deg_s), lever_m=lever_m
    )


def motion_across(scene: SceneOptics, lever_m: Array) -> dict[str, Any]:
    """What moves the floor through the image across the motion: roll."""
    vehicle = scene.view.vehicle
    return dict(speed_m_s=0.0, rotation_rate_rad_s=np.deg2rad(vehicle.roll_rate_deg_s), lever_m=lever_m)


def least_overlap(requirements: Requirements) -> float | None:
    """Overlap that images must have: what is asked for; 0, images that just touch, where nothing fixes their rate."""
    if requirements.overlap is None and requirements.frame_interval_s is None:
        return 0.0
    return requirements.overlap


def required_rate_hz(requirements: Requirements, speed_m_s: float, footprint_along_m: Array) -> Array:
    """Frame rate that overlap or frame interval ask for; frames that just touch when neither is given."""
    shared = least_overlap(requirements)
    rate = np.zeros_like(footprint_along_m)
    if shared is not None:
        rate = operation.frame_rate_hz(speed_m_s, footprint_along_m=footprint_along_m, overlap=shared)
    if requirements.frame_interval_s is not None:
        rate = np.maximum(rate, 1.0 / requirements.frame_interval_s)
    return np.asarray(rate)

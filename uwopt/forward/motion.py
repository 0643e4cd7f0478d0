"""What motion asks of shutter and rate: blur, skew, frames a second."""

from __future__ import annotations

from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.scene import SceneOptics
from uwopt.forward.views import Views, altitudes_m
from uwopt.mission.sections.requirements import Requirements
from uwopt.model import operation
from uwopt.model.imaging import PortShape


def blur_time_s(scene: SceneOptics, shape: PortShape, view: Views) -> Array:
    """Longest light-collecting time within the allowed blur, worst over altitudes and both axes."""
    limit_px = scene.view.requirements.max_blur_px
    count = len(view.tan_along)
    if limit_px is None:
        return np.full(count, np.inf)
    lever = altitudes_m(scene) + shape.over(1).outer_radius_m * (not scene.paper)
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
    """Skew of a rolling shutter, worst over altitudes."""
    lever = altitudes_m(scene) + shape.outer_radius_m * (not scene.paper)
    return skew_by_altitude_px(scene, view, readout_s, lever).max(axis=1)


def skew_by_altitude_px(scene: SceneOptics, view: Views, readout_s: Array, lever_m: Array) -> Array:
    """Skew of a rolling shutter at near, nominal and far altitude, (n, 3).

    Along the motion; of a subject, which moves in any direction, the worse of both axes.
    """
    read = readout_s[:, None]
    along = operation.skew_px(read, ground_sample_m=view.pixel_along_m, **motion_along(scene, lever_m))
    subject = operation.skew_px(read, ground_sample_m=view.pixel_across_m, speed_m_s=subject_m_s(scene))
    return np.asarray(np.maximum(along, subject))


def subject_m_s(scene: SceneOptics) -> float:
    """Largest speed of a subject over the floor, in any direction."""
    return scene.view.scene.subject_speed_m_s


def motion_along(scene: SceneOptics, lever_m: Array) -> dict[str, Any]:
    """What moves a subject through the image along the motion: the vehicle's speed, its own against it, and pitch.

    Along a tilted plane a turning axis sweeps 1 / cos(pitch) as far as across its own direction.
    """
    vehicle, secant = scene.view.vehicle, np.hypot(1.0, scene.slope)
    return dict(
        speed_m_s=vehicle.speed_m_s + subject_m_s(scene),
        rotation_rate_rad_s=np.deg2rad(vehicle.pitch_rate_deg_s), lever_m=lever_m * secant,
    )  # fmt: skip


def motion_across(scene: SceneOptics, lever_m: Array) -> dict[str, Any]:
    """What moves a subject through the image across the motion: its own speed, and roll."""
    rate_rad_s = np.deg2rad(scene.view.vehicle.roll_rate_deg_s)
    return dict(speed_m_s=subject_m_s(scene), rotation_rate_rad_s=rate_rad_s, lever_m=lever_m)


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

"""Lamps and cameras that are switched off between images: how long an image keeps them on, and what they draw then.

A lamp that may be switched burns from its warm-up to the end of the exposure, all rows of a rolling shutter included;
a camera is on from waking up to the end of the transfer. In between both draw their standby power. What a mission
lets burn on has an endless lead: it is on all the time, whatever the rate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.estimates import required_class
from uwopt.catalog.parts.camera import Camera
from uwopt.catalog.parts.light import Light
from uwopt.forward.once import once_each
from uwopt.forward.part_columns import CONTINUOUS, Cameras, Lights
from uwopt.mission.sections.vehicle import Vehicle
from uwopt.model.light import duty_frac


@once_each
def light_with_estimates(light: Light) -> Light:
    """A lamp with warm-up and standby, those of its class where it does not say."""
    if light.kind != "continuous" or light.switchable == "no":
        return light
    warm_up, standby = (required_class(f"light-{name}", "switched-led") for name in ("warm-up-s", "standby-w"))
    return replace(
        light,
        warm_up_s=light.warm_up_s or warm_up.quantity(),
        standby_w=light.standby_w or standby.quantity(),
    )


@once_each
def camera_with_estimates(camera: Camera) -> Camera:
    """A camera with the time that it takes to wake up and standby, those of its class where it does not say."""
    standby = required_class("camera-standby-w", "switched").quantity()
    return replace(camera_with_wake_up(camera), standby_w=camera.standby_w or standby)


def camera_with_wake_up(camera: Camera, name: str = "switched") -> Camera:
    """A camera with the time from switching on to an image, that of a class where it does not say."""
    return replace(camera, wake_up_s=camera.wake_up_s or required_class("camera-wake-up-s", name).quantity())


@once_each
def camera_with_starting_host(camera: Camera) -> Camera:
    """A camera that waits until the computer that takes its images has started, unless it says how long it takes."""
    return camera_with_wake_up(camera, "host") if camera.takes_a_host else camera


@once_each
def camera_with_host(camera: Camera) -> Camera:
    """A camera with power and price of the computer that takes its images, those of its interface unless it says."""
    names = ("host-power-w", "host-price")
    power, price = (required_class(f"camera-{name}", f"host-{camera.interface}", "host-any") for name in names)
    return replace(
        camera,
        host_power_w=camera.host_power_w or power.quantity(),
        host_price=camera.host_price or price.quantity(),
    )


def are_switched(vehicle: Vehicle, lights: Lights) -> Array:
    """Which lamps are off between images."""
    off = vehicle.lamps_between_images == "off"
    return np.asarray(off & lights.switchable & (lights.kind == CONTINUOUS))


def lead_s(vehicle: Vehicle, lights: Lights, cameras: Cameras) -> Array:
    """How long a lamp that burns is on beside the time that collects light; inf: all the time."""
    return np.where(are_switched(vehicle, lights), lights.warm_up_s + cameras.readout_s, np.inf)


def standby_w(vehicle: Vehicle, lights: Lights, count: Array) -> Array:
    """What all lamps draw beside what they burn."""
    return np.where(are_switched(vehicle, lights), lights.standby_w * count, 0.0)


def camera_power_w(
    vehicle: Vehicle, cameras: Cameras, rate_hz: Array | float, exposure_s: Array | None = None
) -> Array:
    """Mean power of one camera at a frame rate, with an exposure; None: the shortest, no less with any."""
    if vehicle.camera_between_images == "on":
        return np.asarray(cameras.power_w + 0.0 * rate_hz)
    exposure_s = cameras.min_exposure_s if exposure_s is None else exposure_s
    on = duty_frac(cameras.awake_s + exposure_s, frame_rate_hz=rate_hz)
    return np.asarray(cameras.power_w * on + cameras.standby_w)


def any_off(vehicles: Sequence[Vehicle], key: str) -> bool:
    """Whether some scene switches lamps or cameras off."""
    return any(getattr(vehicle, key) == "off" for vehicle in vehicles)

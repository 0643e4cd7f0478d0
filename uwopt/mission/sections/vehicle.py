"""How the camera is carried: the section `vehicle` of a mission."""

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, model_validator

from uwopt.documents.key_types import (
    CHOICE,
    NUMBER,
    Count,
    Positive,
    Section,
    at_least,
    number_or_range,
    whole_range,
)
from uwopt.mission import keys as words

MAX_LIGHTS = 64
BASELINE_STEP_M, TILT_STEP_DEG = 0.05, 2.5  # the declared grid of mounts

Orientation = Literal["landscape", "portrait"]
BetweenImages = Annotated[Literal["on", "off"], BeforeValidator(words.to_on_off), CHOICE]


class LightMount(Section):
    """Place and aim of one light in the vehicle frame: x forward, y starboard, z down, origin at the port."""

    x_m: Annotated[float, Field(ge=-100, le=100), NUMBER] = Field(
        default=0.0, description="place forward of the port in metres"
    )
    y_m: Annotated[float, Field(ge=-100, le=100), NUMBER] = Field(
        default=0.0, description="place to starboard in metres"
    )
    z_m: Annotated[float, Field(ge=-100, le=100), NUMBER] = Field(
        default=0.0, description="place below the port in metres"
    )
    tilt_x_deg: Annotated[float, Field(gt=-90, lt=90), NUMBER] = Field(
        default=0.0, description="aim's tilt along x in degrees, outward positive, 0 is straight down"
    )
    tilt_y_deg: Annotated[float, Field(gt=-90, lt=90), NUMBER] = Field(
        default=0.0, description="aim's tilt along y in degrees, outward positive, 0 is straight down"
    )


class Vehicle(Section):
    """How the camera is carried, and which hardware it may carry."""

    other_names: ClassVar[tuple[str, ...]] = tuple(words.OTHER_NAMES)

    altitude_m: Annotated[float, Field(gt=0, le=1000), at_least(1e-3), NUMBER] = Field(
        description="distance from the port to the floor (altitude_m), wall, ceiling or target (distance_m) in metres"
    )
    altitude_tolerance_m: Annotated[float, Field(ge=0, le=1000), NUMBER] = Field(
        default=0.0,
        description="half-width of the altitudes (altitude_tolerance_m) or distances (distance_tolerance_m) over which "
        "every requirement holds, in metres",
    )
    pitch_deg: Annotated[float, Field(ge=0, le=words.MOST_PITCH_DEG), BeforeValidator(words.to_pitch)] = Field(
        default=0.0,
        description="angle by which the camera looks ahead of the normal of floor, wall or ceiling in degrees, 0 for "
        "square on it; the lamps turn with it",
    )
    speed_m_s: Annotated[float, Field(ge=0, le=50), NUMBER] = Field(
        description="speed over the floor in metres per second, 0 when it hovers"
    )
    pitch_rate_deg_s: Annotated[float, Field(ge=0, le=360), NUMBER] = Field(
        default=0.0, description="largest pitch rate in degrees per second"
    )
    roll_rate_deg_s: Annotated[float, Field(ge=0, le=360), NUMBER] = Field(
        default=0.0, description="largest roll rate in degrees per second"
    )
    orientation: Annotated[Literal["any", "landscape", "portrait"], CHOICE] = Field(
        default="any",
        description="side of the image along the motion: landscape its height, portrait its width, or any",
    )
    camera_count: Count = Field(default=1, description="number of cameras, each with lens and port")
    camera_baseline_m: Annotated[float, Field(gt=0, le=20), at_least(1e-3), NUMBER] | None = Field(
        default=None,
        description="of a stereo pair (camera_count 2), the distance across track between the middles of the ports in "
        "metres; lamps stand about the middle between them",
    )
    camera_convergence_deg: Annotated[float, Field(ge=0, le=90), NUMBER] = Field(
        default=0.0,
        description="angle between the axes of a stereo pair in degrees, each camera turned inward by half of it",
    )
    light_count: Annotated[tuple[int, int], whole_range(0, MAX_LIGHTS)] = Field(
        default=(1, 8),
        description=f"number of lights, or [least, most], whole numbers from 0 to {MAX_LIGHTS}; 0 where the sun "
        "serves",
    )
    light_baseline_m: Annotated[float | tuple[float, float], number_or_range(0, 20)] = Field(
        default=0.5, description="distance across track from port to lights in metres, or [least, most]"
    )
    light_tilt_deg: Annotated[float | tuple[float, float], number_or_range(-89, 89)] = Field(
        default=0.0, description="outward tilt of the lights in degrees, or [least, most]"
    )
    light_mounts: Annotated[tuple[LightMount, ...], Field(max_length=MAX_LIGHTS)] | None = Field(
        default=None,
        description="places and aims of the lights, taken in this order; instead of baseline and tilt",
    )
    lamp_size_m: Annotated[float, Field(gt=0, le=2), NUMBER] | None = Field(
        default=None,
        description="diameter of a lamp's body in metres, recommended 0.1: with it lamps may not stand in one another, "
        "in the port's body or, where refuse holds lamp, with their bodies in the view; more than two lamps stand in a "
        "row on each side, along the motion",
    )

    duration_h: Positive | None = Field(
        default=None,
        description="hours that the mission takes, under water at one go; energy and storage are counted over it",
    )
    battery_wh: Positive | None = Field(
        default=None, description="energy of the battery in watt-hours, for the figure endurance"
    )
    supply: Annotated[Literal["vehicle", "battery"], CHOICE] = Field(
        default="vehicle",
        description="what feeds cameras and lamps: vehicle (it is there), or battery (one of battery_wh, part of the "
        "system, counted in cost and mass (catalog.rest: estimate) and to last duration_h where that is given)",
    )
    cable_m: Positive | None = Field(
        default=None,
        description="length of the data cable from each camera to the common computer in metres; a camera whose "
        "interface does not reach so far has a computer of its own beside it (catalog.host: estimate), or is left out "
        "(none); without it the computer stands beside the cameras, of which several have one each where their "
        "interface gets from no housing to another (CSI-2)",
    )
    lamp_supply: Annotated[Literal["any", "external", "battery"], CHOICE] = Field(
        default="any",
        description="lamps that may be used: external (fed by the vehicle, recommended), battery (with their own, as "
        "divers' torches, which then draw nothing from the system's) or any; a lamp that catalog.lights names by its "
        "id, or that is owned, may have either",
    )
    lamps_between_images: BetweenImages = Field(
        default="on",
        description="whether lamps that burn stay on between images: on or off; off is recommended below an image in "
        "some seconds",
    )
    camera_between_images: BetweenImages = Field(
        default="on",
        description="whether cameras stay on between images: on or off; off is recommended below an image a minute",
    )

    @model_validator(mode="before")
    @classmethod
    def _as_many_lights_as_mounts(cls, data: Any) -> Any:
        if isinstance(data, Mapping) and data.get("light_count") is None:
            mounts = data.get("light_mounts")
            if isinstance(mounts, (list, tuple)) and 0 < len(mounts) <= MAX_LIGHTS:
                return {**data, "light_count": [len(mounts)] * 2}
        return data

    @property
    def orientations(self) -> tuple[Orientation, ...]:
        """The orientations that may be tried."""
        return ("landscape", "portrait") if self.orientation == "any" else (self.orientation,)

    @property
    def nearest_m(self) -> float:
        """The least distance from the port to what is looked at, over the band of altitudes."""
        return self.altitude_m - self.altitude_tolerance_m

    @property
    def light_counts(self) -> range:
        """The numbers of lights that may be tried."""
        return range(self.light_count[0], self.light_count[1] + 1)

    @property
    def light_baseline_range_m(self) -> tuple[float, float]:
        """Lowest and highest baseline."""
        return _pair(self.light_baseline_m)

    @property
    def light_tilt_range_deg(self) -> tuple[float, float]:
        """Lowest and highest tilt."""
        return _pair(self.light_tilt_deg)

    @property
    def light_baseline_grid_m(self) -> tuple[float, ...]:
        """Baselines that count as hardware: every 0.05 m from the lower end, both ends included."""
        return grid(*self.light_baseline_range_m, BASELINE_STEP_M)

    @property
    def light_tilt_grid_deg(self) -> tuple[float, ...]:
        """Tilts that count as hardware: every 2.5 degrees from the lower end, both ends included."""
        return grid(*self.light_tilt_range_deg, TILT_STEP_DEG)


def grid(low: float, high: float, step: float) -> tuple[float, ...]:
    """Points every `step` from `low`, and `high`."""
    n_steps = math.floor((high - low) / step + 1e-9)
    points = [round(low + i * step, 9) for i in range(n_steps + 1)]
    return tuple(points) if high - points[-1] < 1e-9 else (*points, high)


def _pair(value: float | tuple[float, float]) -> tuple[float, float]:
    return value if isinstance(value, tuple) else (value, value)

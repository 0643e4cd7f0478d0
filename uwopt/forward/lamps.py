"""Lamps: their beams in water, spectra, places and aims."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.curves import spectra
from uwopt.catalog.parts.kinds import FAVOURED
from uwopt.catalog.records import Curve, Light
from uwopt.forward.part_columns import End
from uwopt.forward.part_rows import number
from uwopt.forward.scene import SceneOptics
from uwopt.mission.mission import Mission
from uwopt.mission.sections.vehicle import LightMount
from uwopt.model import beam as beams
from uwopt.model.imaging import Lamps
from uwopt.model.spectrum import resample_power, trapezoid_weights_nm

LAMP_FRONT_M = 0.02  # radius of a lamp's front, unless known: nearer than that its light is not a point's
MOST_SIDE_BY_SIDE = 2  # lamps with bodies that have room at one baseline, one to either side
WIDEST_DISC_RAD = float(np.deg2rad(85.0))


@dataclass(frozen=True)
class LightOptics:
    """What one lamp's light is like: beam in each scene's water and relative spectrum. Lights that share it share
    signals."""

    beams: tuple[beams.Beam, ...]
    spectrum_id: str
    spectrum: Curve | None


def light_optics(
    light: Light, *, n_water: Sequence[float], end: str = "central", paper: bool = False
) -> LightOptics:
    """Beam and spectrum of a light; angles stated in air, or in no medium, are refracted into each scene's water.

    Physics `paper` knows one beam, the even disc: it takes the place of any other of the same angle.
    """
    made = {index: light_beam(light, n_water=index, end=end) for index in n_water}
    if paper:
        made = {
            index: beam
            if beam.kind == "disc"
            else beams.disc_beam(min(beams.half_power_angle_rad(beam), WIDEST_DISC_RAD))
            for index, beam in made.items()
        }
    return LightOptics(tuple(made[index] for index in n_water), light.spectrum_id, light.spectrum)


def light_beam(light: Light, *, n_water: float, end: str = "central") -> beams.Beam:
    """The beam of a light in water, from its data sheet's angle or its measured profile."""
    in_water = light.beam_medium == "water"
    if light.beam == "tabulated" and light.beam_profile is not None:
        angles = np.deg2rad(light.beam_profile.x)
        values = np.asarray(light.beam_profile.y, float)
        return beams.tabulated_beam(
            angles, values, medium="water" if in_water else "air", n_w=n_water, total_flux_lm=None
        )  # the shape; what a profile in candela holds of the flux is in the output factor
    half = np.deg2rad(number(light.beam_angle_deg, 90.0, end, FAVOURED["beam_angle_deg"])) / 2.0  # pyrefly: ignore[bad-argument-type]
    if not in_water:
        half = float(beams.half_angle_in_water_rad(half, n_w=n_water))
    if light.beam == "disc":
        return beams.disc_beam(half)
    if light.beam == "cone":
        return beams.cone_beam(half)
    return beams.cosine_power_beam(2.0 * half)


@lru_cache(maxsize=1024)
def lamp_set(count: int, *, baseline_m: float, tilt_rad: float) -> Lamps:
    """n lamps across track, alternately at plus and minus the baseline, leaning outward (PHYSICS section 1)."""
    right = (count + 1) // 2
    sides = [(1.0, right / count)] + ([(-1.0, (count - right) / count)] if count > 1 else [])
    places = [(side * baseline_m, share) for side, share in sides]
    aims = [
        beams.lamp_aim(0.0, tilt_rad, lamp_x_m=0.0, lamp_y_m=side * max(baseline_m, 1e-12))
        for side, _ in sides
    ]
    return Lamps(
        x_m=tuple(0.0 for _ in places),
        y_m=tuple(y for y, _ in places),
        z_m=tuple(0.0 for _ in places),
        aim=tuple((float(a[0]), float(a[1]), float(a[2])) for a in aims),
        share=tuple(share for _, share in places),
    )


def mounted_lamps(mounts: Sequence[Any]) -> Lamps:
    """Lamps where the mission or system puts them."""
    aims = [
        beams.lamp_aim(np.deg2rad(m.tilt_x_deg), np.deg2rad(m.tilt_y_deg), lamp_x_m=m.x_m, lamp_y_m=m.y_m)
        for m in mounts
    ]
    return Lamps(
        x_m=tuple(float(m.x_m) for m in mounts),
        y_m=tuple(float(m.y_m) for m in mounts),
        z_m=tuple(float(m.z_m) for m in mounts),
        aim=tuple((float(a[0]), float(a[1]), float(a[2])) for a in aims),
        share=tuple(1.0 / len(mounts) for _ in mounts),
    )


@lru_cache(maxsize=1024)
def one_side(lamps: Lamps) -> Lamps:
    """The lamps that stand for all in the mean over a symmetric image: mirror images add nothing new."""
    if len(lamps.x_m) == 2 and mirrored(lamps):
        return Lamps(lamps.x_m[:1], lamps.y_m[:1], lamps.z_m[:1], lamps.aim[:1], (1.0,))
    return lamps


def mirrored(lamps: Lamps) -> bool:
    """Whether two lamps are each other's mirror image across the track, in place and in aim."""
    (one_x, other_x), (one_y, other_y), (one_z, other_z) = lamps.x_m, lamps.y_m, lamps.z_m
    one, other = lamps.aim
    places = one_x == other_x == 0.0 and one_y == -other_y and one_z == other_z
    return places and bool(np.allclose(one, (other[0], -other[1], other[2]), rtol=0, atol=1e-12))


def relative_spectrum(key: tuple[str, Curve | None], wavelength_nm: Array) -> Array:
    """A light's relative spectrum on the grid: the user's own curve, or a named one. Not to be written to."""
    return _relative_spectrum(*key, np.asarray(wavelength_nm, float).tobytes())


@lru_cache(maxsize=1024)  # waters of one grid, some hundred in the doubt, share it: 1 kB each
def _relative_spectrum(name: str, curve: Curve | None, wavelength_nm: bytes) -> Array:
    if curve is not None:
        table_nm, values = np.array(curve.x), np.array(curve.y)
    else:
        known = spectra.light_spectrum(name)
        table_nm, values = known.wavelength_nm, known.value
    made = resample_power(np.frombuffer(wavelength_nm), table_nm=table_nm, table_values=values)
    made.setflags(write=False)
    return made


def luminous_weight(scene: SceneOptics, item: LightOptics) -> Array:
    """A light's luminous flux by wavelength, any scale: V S times the steps of the grid."""
    spectrum = relative_spectrum((item.spectrum_id, item.spectrum), scene.wavelength_nm)
    return np.asarray(scene.photopic * spectrum * trapezoid_weights_nm(scene.wavelength_nm))


def on_axis_gain(beam: beams.Beam, ranges: Array) -> Array:
    """Illuminance per lumen on the axis of a lamp that stands at the camera (physics `paper`) [1/m^2]."""
    return np.asarray(beams.intensity_per_sr(np.ones_like(ranges), beam) / np.square(ranges))


@dataclass(frozen=True)
class Mount:
    """A place for the lights: explicit lamps, or a baseline and tilt for any number of them."""

    baseline_m: float = 0.0
    tilt_deg: float = 0.0
    explicit: tuple[Any, ...] = ()

    def lamps(self, count: int) -> Lamps:
        """Where `count` lamps stand."""
        if self.explicit:
            return mounted_lamps(self.explicit)
        return lamp_set(count, baseline_m=self.baseline_m, tilt_rad=float(np.deg2rad(self.tilt_deg)))

    def is_lopsided(self, count: int) -> bool:
        """Whether one side of the camera has a lamp more than the other."""
        return not self.explicit and self.baseline_m > 0.0 and count % 2 == 1

    def way_m(self, range_m: float) -> float:
        """From the foremost lamp to a plane so far before the port, along its axis [m]; never less than a front."""
        return max(range_m - max([one.z_m for one in self.explicit], default=0.0), LAMP_FRONT_M)


@dataclass(frozen=True)
class LampGroup:
    """Lamps that shine together: their light optics, where they stand and how many they are."""

    optics: int
    mount: Mount
    count: int = 2

    @property
    def lamps(self) -> Lamps:
        """Each of them, with its share of the light."""
        return self.mount.lamps(self.count)


def light_counts(mission: Mission) -> tuple[int, int]:
    """Fewest and most lamps; explicit mounts say how many there are. Where none will do, one part stands for none."""
    if mission.vehicle.light_mounts:
        count = mission.vehicle.light_counts[-1]
        return count, count
    low, high = mission.vehicle.light_count
    return max(low, 1), max(high, 1)


def mission_mounts(mission: Mission) -> list[Mount]:
    """The declared grid of mounts: explicit lamps, or baseline x tilt."""
    vehicle = mission.vehicle
    if vehicle.light_mounts:
        return [Mount(explicit=tuple(vehicle.light_mounts[: vehicle.light_counts[-1]]))]
    grid = [(b, t) for b in vehicle.light_baseline_grid_m for t in vehicle.light_tilt_grid_deg]
    rows = [
        mount_at(mission, baseline_m, tilt_deg, count)
        for count in range(max(MOST_SIDE_BY_SIDE + 1, vehicle.light_count[0]), vehicle.light_count[1] + 1)
        for baseline_m, tilt_deg in grid
    ]
    return [Mount(b, t) for b, t in grid] + [mount for mount in rows if mount.explicit]


def mount_at(mission: Mission, baseline_m: float, tilt_deg: float, count: int) -> Mount:
    """Where so many lamps stand at a baseline: lamps with bodies in a row on each side, others in two points."""
    size_m = mission.vehicle.lamp_size_m
    if size_m is None or count <= MOST_SIDE_BY_SIDE or mission.physics == "paper":
        return Mount(baseline_m, tilt_deg)
    return Mount(explicit=tuple(in_rows(count, baseline_m=baseline_m, tilt_deg=tilt_deg, spacing_m=size_m)))


def in_rows(count: int, *, baseline_m: float, tilt_deg: float, spacing_m: float) -> list[LightMount]:
    """n lamps alternately to either side, those of a side beside one another along the motion about the port's middle.

        x_i = (i - (k - 1) / 2) spacing  of the k lamps of a side
    """
    places = []
    for n in range(count):
        of_side = (count + 1) // 2 if n % 2 == 0 else count // 2
        x_m = (n // 2 - 0.5 * (of_side - 1)) * spacing_m
        places.append(LightMount(x_m=x_m, y_m=baseline_m * (-1.0) ** n, tilt_y_deg=tilt_deg))
    return places


def distinct_optics(
    lights: Sequence[Light], n_water: Sequence[float], end: End, *, paper: bool
) -> tuple[list[LightOptics], list[int]]:
    """Distinct beams with spectra, and each light's index into them."""
    found: dict[tuple[Any, ...], int] = {}
    stated: dict[tuple[Any, ...], int] = {}  # many lights, and states of one, say the same of their optics
    optics: list[LightOptics] = []
    index = []
    for part in lights:
        angle_deg = number(part.beam_angle_deg, 90.0, end, FAVOURED["beam_angle_deg"])
        says = (part.beam, part.beam_medium, angle_deg, id(part.beam_profile), part.spectrum_id, id(part.spectrum))
        if says not in stated:
            item = light_optics(part, n_water=n_water, end=end, paper=paper)
            key = (item.beams, item.spectrum_id, item.spectrum)
            if key not in found:
                found[key] = len(optics)
                optics.append(item)
            stated[says] = found[key]
        index.append(stated[says])
    return optics, index

"""What the sun adds to the pixels of many imagers: its light on the floor, and its veils.

Daylight comes evenly from above, so that what a pixel gets depends on its distance from the image's
centre alone: the spectrum is contracted at a few such distances, and images are means over them. Sunlight
from the side is averaged over azimuth, because a vehicle turns.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from uwopt.catalog.curves import spectra
from uwopt.forward.lamp_light import SunLight
from uwopt.forward.lamps import Mount
from uwopt.forward.problem import Problem
from uwopt.forward.scene import Pixels
from uwopt.forward.spectra import TINY, efficiency_curve, sees_colours
from uwopt.forward.views import Views
from uwopt.model import port, seafloor, sunlight
from uwopt.model.fineness import scaled
from uwopt.model.image_mean import along_symmetric, frame_places, gauss, pixel_grid
from uwopt.model.imaging import field_loss, floor_point, radiance_weight
from uwopt.model.spectrum import resample

if TYPE_CHECKING:
    from uwopt.forward.problem import Problem

Array = NDArray[Any]
RADIAL_DEGREE = 20  # of the polynomials over the distance from the centre: 1e-8 of what they replace
IMAGE_ORDER = 12  # Gauss-Legendre nodes over half an image's side
DIMMEST_LOG = -700.0


class SunField:
    """Daylight seen by imagers that share scene, port and efficiency curve."""

    def __init__(self, problem: Problem, scene_index: int, *, port_index: int, efficiency: int,
                 channel: str | None = None):  # fmt: skip
        self.problem, self.scene_index = problem, scene_index
        self.scene = problem.scenes[scene_index]
        self.fineness = self.scene.fineness.sun
        self.shape = problem.shape(port_index, scene_index)
        self.efficiency = efficiency_curve(
            problem.efficiencies[efficiency], self.scene.wavelength_nm, channel=channel
        )

    def light(self, view: Views, *, pixels: Pixels | None = None, half_grid: bool = False) -> SunLight:
        """Daylight of these imagers; with `pixels` also at every point that lamps are seen at."""
        nodes, weights = gauss(scaled(IMAGE_ORDER, self.fineness))
        half, share = 0.5 * (nodes + 1.0), weights
        along = view.tan_along[:, None, None] * half[:, None]
        across = view.tan_across[:, None, None] * half
        parts = [
            (part.reshape(len(part), -1, 3) * np.outer(share, share).ravel()[:, None]).sum(axis=1)
            for part in self.at_points(view, *np.broadcast_arrays(along, across))
        ]
        signal, forward, path = np.moveaxis(np.stack(parts, axis=1), -1, 0)
        if pixels is None:
            return SunLight(signal, forward, path)
        if pixels == "frame":
            grid = frame_places(view.tan_along, view.tan_across)
        else:
            points = self.problem.pixels_a_side(self.scene_index)
            grid = pixel_grid(view.tan_along, view.tan_across, half=half_grid, n_points=points)
        there = np.stack(self.at_points(view, *grid), axis=1)
        return SunLight(signal, forward, path, there[..., 0], there[..., 1] + there[..., 2])

    def at_points(self, view: Views, along: Array, across: Array) -> list[Array]:
        """Floor, forward veil and path (last axis) at field points (n, ...), one array an altitude [e/s]."""
        radius = np.hypot(along, across)
        widest = float(radius.max(initial=1e-6)) * (1 + 1e-9)
        loss = field_loss(along, across, shape=self.shape)
        scale = (loss.T * view.collecting_m2).T
        out = []
        for range_m in self.scene.range_m:
            logs = chebyshev.chebval(2.0 * radius / widest - 1.0, self.radial(float(range_m), widest))
            floor, every, path = np.exp(np.maximum(logs, DIMMEST_LOG))
            forward = np.maximum(every - floor, 0.0)
            out.append(np.stack([floor, forward, path], axis=-1) * scale[..., None])
        return out

    def radial(self, range_m: float, widest: float) -> Array:
        """Polynomials in the distance from the centre: logarithms of floor, floor with veil, and path [e/s/m^2]."""
        scene, degree = self.scene, scaled(RADIAL_DEGREE, self.fineness)
        knots = chebyshev.chebpts1(degree + 1)
        tangent = 0.5 * (knots + 1.0) * widest
        _, _, path_m = floor_point(tangent, np.zeros_like(tangent), shape=self.shape, range_m=range_m)
        in_water = tangent if self.shape.is_dome else port.water_tangent(tangent, n=self.shape.n_water)
        cos_field = 1.0 / np.sqrt(1.0 + np.square(in_water))
        floor = self.electrons(seafloor.lambertian_radiance(self.at_floor(), reflectance=scene.reflectance))
        image = log_sum(floor, scene.attenuation_per_m * path_m[:, None])
        every = log_sum(floor, scene.lamp_attenuation_per_m * path_m[:, None])
        path = np.log(np.maximum(self.path_electrons(path_m, cos_field), TINY))
        fits = [chebyshev.chebfit(knots, log, degree) for log in (image, np.maximum(every, image), path)]
        return np.stack(fits, axis=1)

    def path_electrons(self, path_m: Array, cos_field: Array) -> Array:
        """Electrons a second and m^2 of the light that the water between sends to the camera."""
        scene = self.scene
        if not scene.scattering or scene.scattering[0].table is None:
            return np.zeros(len(path_m))
        first, molecules = scene.scattering[0], scene.scattering[1:]
        # The ray's vertical extent is the altitude, behind a dome's round face a little more: kept under water.
        depth_m = np.maximum(scene.view.scene.depth_m, path_m * cos_field)
        radiance = sunlight.path_radiance_w_m2_sr_nm(
            self.surface(), kd_per_m=self.kd(), attenuation_per_m=scene.attenuation_per_m,
            scattering_per_m=first.scattering_per_m, table=scene.scattering[0].table,
            molecular_scattering_per_m=molecules[0].scattering_per_m if molecules else 0.0, depth_m=depth_m,
            path_m=path_m, cos_field=cos_field, elevation_rad=self.elevation_rad(), n_water=scene.n_water,
            n_azimuth=scaled(sunlight.N_AZIMUTH, self.fineness),
        )  # fmt: skip
        return np.asarray(self.electrons(radiance).sum(axis=-1))

    def electrons(self, radiance: Array) -> Array:
        """Weights by wavelength of a radiance in water."""
        scene = self.scene
        return radiance_weight(
            radiance, wavelength_nm=scene.wavelength_nm, quantum_efficiency=self.efficiency,
            n_water=scene.radiance_index,
        )  # fmt: skip

    def kd(self) -> Array:
        """K_d of daylight."""
        found = self.scene.diffuse_attenuation_per_m
        return self.scene.attenuation_per_m if found is None else found

    def elevation_rad(self) -> float:
        """Elevation of the sun."""
        return float(np.deg2rad(self.scene.view.scene.sun_elevation_deg))

    def surface(self) -> Array:
        """Spectral irradiance just above the water."""
        scene, daylight = self.scene, spectra.light_spectrum("D65")
        relative = resample(
            scene.wavelength_nm, table_nm=daylight.wavelength_nm, table_values=daylight.value, outside="zero"
        )
        return np.asarray(
            sunlight.surface_irradiance_w_m2_nm(
                scene.view.scene.sun_lux, relative_spectrum=relative, wavelength_nm=scene.wavelength_nm,
                photopic=scene.photopic,
            )
        )  # fmt: skip

    def at_floor(self) -> Array:
        """Spectral irradiance on the floor."""
        return sunlight.downwelling_irradiance_w_m2_nm(
            self.surface(), kd_per_m=self.kd(), depth_m=self.scene.view.scene.depth_m,
            elevation_rad=self.elevation_rad(), n_water=self.scene.n_water,
        )  # fmt: skip


def log_sum(weight: Array, optical: Array) -> Array:
    """Logarithm of the sum over wavelengths of weight * exp(-optical), whatever its size."""
    least = optical.min(axis=-1, keepdims=True)
    total = (weight * np.exp(-(optical - least))).sum(axis=-1)
    return np.asarray(np.log(np.maximum(total, TINY)) - least[..., 0])


def with_colours(
    light: SunLight, problem: Problem, scene_index: int, view: Views, port_index: int, efficiency: int
) -> SunLight:
    """Daylight with that of the channels that something is asked of; none of a mono sensor."""
    names, none = problem.scenes[scene_index].channels, np.zeros_like(light.signal_e_s)
    if not sees_colours(problem.efficiencies[efficiency]):
        return replace(light, colour_e_s=np.repeat(none[:, :, None], len(names), axis=2), red_veil_e_s=none)
    seen = [
        SunField(problem, scene_index, port_index=port_index, efficiency=efficiency, channel=name).light(view)
        for name in names
    ]
    colour = np.stack([one.signal_e_s for one in seen], axis=2)
    return replace(light, colour_e_s=colour, red_veil_e_s=seen[0].veil_e_s)


def sun_light(
    problem: Problem, scene_index: int, view: Views, camera: Array, *, port_index: Array, mount: Mount | None = None,
    count: int = 2, channel: str | None = None, pixels: Pixels | None = None,
) -> SunLight | None:  # fmt: skip
    """Electrons per second of open shutter from the sun; None without sun.

    With `pixels` also where the lamps at `mount` are seen.
    """
    if not problem.scenes[scene_index].sunlit or not problem.effects.sunlight:
        return None

    half = pixels == "darkest" and mount is not None and along_symmetric(mount.lamps(count))
    efficiency = problem.cameras.qe_index[camera]
    columns: dict[str, Any] = {}
    for window in np.unique(port_index):
        for curve in np.unique(efficiency):
            mine = np.nonzero((port_index == window) & (efficiency == curve))[0]
            if len(mine) == 0:
                continue
            field = SunField(
                problem, scene_index, port_index=int(window), efficiency=int(curve), channel=channel
            )
            light = field.light(view.take(mine), pixels=pixels, half_grid=half)
            if channel is None and problem.scenes[scene_index].channels:
                light = with_colours(light, problem, scene_index, view.take(mine), int(window), int(curve))
            for name in light.__dataclass_fields__:
                part = getattr(light, name)
                if part is None:
                    continue
                column = columns.setdefault(name, np.empty((len(camera), *part.shape[1:])))
                column[mine] = part
    return SunLight(**columns)

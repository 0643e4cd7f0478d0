"""What the sun adds to the pixels of many imagers: its light on the floor, and its veils.

Daylight comes evenly from above, so that what a pixel gets depends on its distance from the image's
centre alone: the spectrum is contracted at a few such distances, and images are means over them. Sunlight
from the side is averaged over azimuth, because a vehicle turns.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial import chebyshev

from uwopt.arrays import Array
from uwopt.catalog.curves import spectra
from uwopt.forward.lamp_light import likely_dark_places
from uwopt.forward.lamps import Mount
from uwopt.forward.light_columns import SunLight
from uwopt.forward.problem import Problem
from uwopt.forward.scene import Pixels
from uwopt.forward.spectra import TINY, efficiency_curve, sees_colours
from uwopt.forward.views import Views
from uwopt.model import port, seafloor, sunlight
from uwopt.model.fineness import scaled
from uwopt.model.image_mean import along_symmetric, frame_places, gauss, pixel_grid
from uwopt.model.imaging import descent, field_loss, floor_point, radiance_weight, ray_spread
from uwopt.model.light import spectral_flux_w_nm
from uwopt.model.spectrum import resample

if TYPE_CHECKING:
    from uwopt.forward.problem import Problem

RADIAL_DEGREE = 20  # of the polynomials over the distance from the centre: 1e-8 of what they replace
OBLIQUE_DEGREE = 40  # of those over the angle from the floor's normal, which may near the horizon
STEPS_AN_OCTAVE = 4  # of the distances up to which polynomials reach
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
        self.curves, self.channel = problem.efficiencies[efficiency], channel
        self.multiple = problem.contractions[scene_index].multiple  # light scattered more than once counts

    @cached_property
    def efficiency(self) -> Array:
        """Electrons a photon, by wavelength."""
        return efficiency_curve(self.curves, self.scene.wavelength_nm, channel=self.channel)

    def light(
        self, view: Views, *, pixels: Pixels | None = None, half_grid: bool = False, few: bool = False
    ) -> SunLight:
        """Daylight of these imagers; with `pixels` also at every point that lamps are seen at, or the likely ones."""
        nodes, weights = gauss(scaled(IMAGE_ORDER, self.fineness))
        half, share = 0.5 * (nodes + 1.0), weights
        ahead, of_ahead = gauss(scaled(2 * IMAGE_ORDER, self.fineness)) if self.shape.slope else (half, share)
        along = view.tan_along[:, None, None] * ahead[:, None]
        across = view.tan_across[:, None, None] * half
        parts = [
            (part.reshape(len(part), -1, 3) * np.outer(of_ahead, share).ravel()[:, None]).sum(axis=1)
            for part in self.at_points(view, *np.broadcast_arrays(along, across))
        ]
        signal, forward, path = np.moveaxis(np.stack(parts, axis=1), -1, 0)
        if pixels is None:
            return SunLight(signal, forward, path)
        if few:
            grid = likely_dark_places(view, pixels)
        elif pixels == "frame":
            grid = frame_places(view.tan_along, view.tan_across, few=self.scene.fineness.few_places)
        else:
            points = self.problem.pixels_a_side(self.scene_index)
            grid = pixel_grid(view.tan_along, view.tan_across, half=half_grid, n_points=points)
        there = np.stack(self.at_points(view, *grid), axis=1)
        return SunLight(signal, forward, path, there[..., 0], there[..., 1] + there[..., 2])

    def most_signal(self, view: Views) -> Array:
        """No image's mean has more of the floor's daylight [e/s], (n, n_altitudes): that at its centre, above which the
        path is shortest; of an oblique view the mean itself."""
        if self.shape.slope:
            return self.light(view).signal_e_s
        widest = rounded_up(float(np.hypot(view.tan_along, view.tan_across).max(initial=1e-6)))
        floor_log = chebyshev.chebval(-np.ones(1), self.radial_fit(widest))[:, 0, 0]
        return np.asarray(view.collecting_m2[:, None] * np.exp(np.maximum(floor_log, DIMMEST_LOG)))

    def at_points(self, view: Views, along: Array, across: Array) -> list[Array]:
        """Floor, forward veil and path (last axis) at field points (n, ...), one array an altitude [e/s]."""
        loss = field_loss(along, across, shape=self.shape)
        scale = (loss.T * view.collecting_m2).T
        logs_at = self.oblique_logs if self.shape.slope else self.radial_logs
        out = []
        for logs in logs_at(along, across):
            floor, every, path = np.exp(np.maximum(logs, DIMMEST_LOG))
            forward = np.maximum(every - floor, 0.0)
            out.append(np.stack([floor, forward, path], axis=-1) * scale[..., None])
        return out

    def radial_logs(self, along: Array, across: Array) -> Array:
        """Logarithms of floor, floor with veil, and path [e/s/m^2] by altitude, from the distance to the centre."""
        radius = np.hypot(along, across)
        widest = rounded_up(float(radius.max(initial=1e-6)))
        return np.asarray(chebyshev.chebval(2.0 * radius / widest - 1.0, self.radial_fit(widest)))

    def radial_fit(self, widest: float) -> Array:
        """Polynomials of these logarithms up to a distance, made once a scene: (degree + 1, n_altitudes, 3)."""
        water = tuple(sorted(self.curves.items())), self.channel, self.fineness
        key = ("sun fit", self.multiple, self.shape, *water, tuple(self.scene.range_m), widest)

        def made() -> Array:
            knots = chebyshev.chebpts1(scaled(RADIAL_DEGREE, self.fineness) + 1)
            tangent, range_m = 0.5 * (knots + 1.0) * widest, self.scene.range_m[:, None]
            path_m = floor_point(tangent, np.zeros_like(tangent), shape=self.shape, range_m=range_m)[2]
            in_water = tangent if self.shape.is_dome else port.water_tangent(tangent, n=self.shape.n_water)
            return np.asarray(self.fitted(knots, path_m, 1.0 / np.sqrt(1.0 + np.square(in_water))))

        return self.scene.once(key, made)

    def oblique_logs(self, along: Array, across: Array) -> list[Array]:
        """The same of an oblique view, by the ray's angle from the floor's normal.

        path = H / cos(angle), less R behind a dome. H is one height there; behind a flat port, whose rays start off
        the axis, it varies by the window's thickness and gap: linear between its ends.
        """
        shape = self.shape
        square = np.square(along) + np.square(across)
        _, per_m = ray_spread(square, shape)
        secant = np.sqrt(1.0 + square * np.square(per_m)) * np.hypot(1.0, shape.slope)
        secant = secant / descent(along, per_m, shape.slope)
        behind_m = shape.outer_radius_m if shape.is_dome else 0.0
        low, high = float(secant.min(initial=1e6)), float(secant.max(initial=1.0)) * (1 + 1e-9)
        knots = chebyshev.chebpts1(scaled(OBLIQUE_DEGREE, self.fineness) + 1)
        at_knots = low + 0.5 * (knots + 1.0) * (high - low)
        place = 2.0 * (secant - low) / max(high - low, 1e-12) - 1.0
        made = []
        for range_m in self.scene.range_m:
            path_m = floor_point(along, across, shape=shape, range_m=float(range_m))[2]
            height_m = (path_m + behind_m) / secant
            ends_m = np.array([height_m.min(initial=np.inf), height_m.max(initial=0.0)])
            fit = self.fitted(knots, ends_m[:, None] * at_knots - behind_m, 1.0 / at_knots)
            first, last = np.asarray(chebyshev.chebval(place, fit))
            share = (height_m - ends_m[0]) / max(ends_m[1] - ends_m[0], 1e-12)
            made.append(first + share * (last - first))
        return made

    def fitted(self, knots: Array, path_m: Array, cos_field: Array) -> Array:
        """Polynomials through rays at Chebyshev knots: logarithms of floor, floor with veil, and path [e/s/m^2].

        `path_m` (n, n_knots); returns (degree + 1, n, 3).
        """
        scene, degree = self.scene, len(knots) - 1
        floor = self.electrons(seafloor.lambertian_radiance(self.at_floor(), reflectance=scene.reflectance))
        image = log_sum(floor, scene.attenuation_per_m * path_m[..., None])
        all_light = scene.sun_leg_per_m() if self.multiple else scene.lamp_attenuation_per_m
        every = log_sum(floor, all_light * path_m[..., None])
        path = np.log(np.maximum(self.path_electrons(path_m, cos_field), TINY))
        logs = np.stack([image, np.maximum(every, image), path], axis=1)  # (n, 3, n_knots)
        fits = chebyshev.chebfit(knots, logs.reshape(-1, len(knots)).T, degree)
        return np.asarray(fits.reshape(degree + 1, -1, 3))

    def path_electrons(self, path_m: Array, cos_field: Array) -> Array:
        """Electrons a second and m^2 of the light that the water between sends to the camera."""
        scene = self.scene
        if not scene.scattering or scene.scattering[0].table is None:
            return np.zeros(path_m.shape)
        first, molecules = scene.scattering[0], scene.scattering[1:]
        # The ray's vertical extent is the altitude, behind a dome's round face a little more: kept under water.
        depth_m = np.maximum(scene.view.scene.depth_m, path_m * cos_field)
        rays: dict[str, Any] = dict(
            kd_per_m=self.kd(), depth_m=depth_m, path_m=path_m, cos_field=cos_field,
            elevation_rad=self.elevation_rad(), n_water=scene.n_water,
        )  # fmt: skip
        n_azimuth = scaled(sunlight.N_AZIMUTH, self.fineness)
        if self.multiple:
            turned = scene.sun_turned_per_m_sr(cos_field, elevation_rad=self.elevation_rad(), n_azimuth=n_azimuth)
            radiance = sunlight.diffuse_path_radiance_w_m2_sr_nm(
                self.surface(), absorption_per_m=scene.absorption_per_m(), turned_per_m_sr=turned,
                backward_per_m=scene.backward_per_m(), **rays,
            )  # fmt: skip
        else:
            radiance = sunlight.path_radiance_w_m2_sr_nm(
                self.surface(), attenuation_per_m=scene.attenuation_per_m, scattering_per_m=first.scattering_per_m,
                table=scene.scattering[0].table,
                molecular_scattering_per_m=molecules[0].scattering_per_m if molecules else 0.0,
                n_azimuth=n_azimuth, **rays,
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
        """Spectral irradiance just above the water, from its illuminance: as a lamp's flux from its lumens."""
        scene, daylight = self.scene, spectra.light_spectrum("D65")
        relative = resample(
            scene.wavelength_nm, table_nm=daylight.wavelength_nm, table_values=daylight.value, outside="zero"
        )
        return np.asarray(spectral_flux_w_nm(
            scene.view.scene.sun_lux, relative_spectrum=relative, wavelength_nm=scene.wavelength_nm,
            photopic=scene.photopic,
        ))  # fmt: skip

    def at_floor(self) -> Array:
        """Spectral irradiance on the floor."""
        return sunlight.downwelling_irradiance_w_m2_nm(
            self.surface(), kd_per_m=self.kd(), depth_m=self.scene.view.scene.depth_m,
            elevation_rad=self.elevation_rad(), n_water=self.scene.n_water,
        )  # fmt: skip


def rounded_up(tangent: float) -> float:
    """The next step of a ladder above a tangent, so that images of nearly one size share what is fitted."""
    return float(2.0 ** (np.floor(STEPS_AN_OCTAVE * np.log2(tangent) + 1.0) / STEPS_AN_OCTAVE))


def log_sum(weight: Array, optical: Array) -> Array:
    """Logarithm of the sum over wavelengths of weight * exp(-optical), whatever its size."""
    least = optical.min(axis=-1, keepdims=True)
    total = (weight * np.exp(-(optical - least))).sum(axis=-1)
    return np.asarray(np.log(np.maximum(total, TINY)) - least[..., 0])


def with_colours(
    light: SunLight, problem: Problem, scene_index: int, view: Views, port_index: int, efficiency: int,
    field_type: type[SunField] = SunField,
) -> SunLight:  # fmt: skip
    """Daylight with that of the channels that something is asked of; none of a mono sensor."""
    names, none = problem.scenes[scene_index].channels, np.zeros_like(light.signal_e_s)
    if not sees_colours(problem.efficiencies[efficiency]):
        return replace(light, colour_e_s=np.repeat(none[:, :, None], len(names), axis=2), red_veil_e_s=none)
    seen = [
        field_type(problem, scene_index, port_index=port_index, efficiency=efficiency, channel=name).light(view)
        for name in names
    ]
    colour = np.stack([one.signal_e_s for one in seen], axis=2)
    return replace(light, colour_e_s=colour, red_veil_e_s=seen[0].veil_e_s)


def sun_light(
    problem: Problem, scene_index: int, view: Views, camera: Array, *, port_index: Array, mount: Mount | None = None,
    count: int = 2, channel: str | None = None, pixels: Pixels | None = None, few: bool = False,
    field_type: type[SunField] = SunField,
) -> SunLight | None:  # fmt: skip
    """Electrons per second of open shutter from the sun; None without sun.

    With `pixels` also where the lamps at `mount` are seen; of `few`, at those that are likely to be darkest.
    `field_type` may remember what it has worked out.
    """
    if not problem.scenes[scene_index].sunlit or not problem.effects.sunlight:
        return None

    lamps = None if mount is None or pixels != "darkest" else mount.lamps(count)
    efficiency = problem.cameras.qe_index[camera]
    parts = []
    windows = problem.like_port[port_index]
    for window in np.unique(windows):
        for curve in np.unique(efficiency):
            mine = np.nonzero((windows == window) & (efficiency == curve))[0]
            if len(mine) == 0:
                continue
            field = field_type(
                problem, scene_index, port_index=int(window), efficiency=int(curve), channel=channel
            )
            half = lamps is not None and along_symmetric(lamps, field.shape)
            light = field.light(view.take(mine), pixels=pixels, half_grid=half, few=few)
            if channel is None and problem.scenes[scene_index].channels:
                light = with_colours(
                    light, problem, scene_index, view.take(mine), int(window), int(curve), field_type
                )
            parts.append((mine, light))
    return parts[0][1] if len(parts) == 1 else SunLight.in_places(parts, len(camera))

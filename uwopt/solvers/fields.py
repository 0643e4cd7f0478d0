"""Signal of imagers under light optics: a cheap upper bound for all, the exact field mean for survivors.

A *lighting* is a pair (light optics, mount): lights that share beam and spectrum share every signal
per lumen. The bound needs no integral per imager: the mean over an image of a non-negative light is
at most the light that falls on the image's floor rectangle over its area, and that grows with the
rectangle, so a table of rectangles, rounded up, bounds every image.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.model import beam as beams
from uwopt.model.imaging import flat_slope_m, lamp_light
from uwopt.model.port import flat_floor_derivative
from uwopt.model.water import log_mean_transmission
from uwopt.optics import Views, on_axis_gain, one_side
from uwopt.problem import Mount, Problem
from uwopt.solvers.imagers import Imagers

Array = NDArray[Any]
EDGES = 97  # rectangle edges a side in the bound's table
QUADRATURE_MARGIN = 1.003  # over the midpoint rule's error on cells 5 % wide


@dataclass(frozen=True)
class Lighting:
    """One light optics at one mount."""

    optics: int
    mount_index: int
    mount: Mount


def lightings(problem: Problem) -> list[Lighting]:
    """All pairs of light optics and mount."""
    return [
        Lighting(optics, index, mount)
        for optics in range(len(problem.optics))
        for index, mount in enumerate(problem.mounts)
    ]


class FieldTables:
    """Bounds and exact values of the electrons per lm s of every imager under every lighting."""

    def __init__(self, problem: Problem, imagers: Imagers):
        self.problem, self.imagers = problem, imagers
        self.lightings = lightings(problem)
        for index, scene in enumerate(imagers.scenes):
            widest = 0.5 * np.hypot(scene.view.footprint_along_m[:, 2], scene.view.footprint_across_m[:, 2])
            problem.set_reach(index, 1.5 * float(widest.max(initial=0.0)))
        self._response = [self._responses(i) for i in range(len(problem.scenes))]

    def _responses(self, scene_index: int) -> Array:
        """Electrons per m^2 and unit light, (n_optics, n_efficiency)."""
        contraction = self.problem.contractions[scene_index]
        table = [
            [contraction.response(s, q) for q in range(len(contraction.efficiencies))]
            for s in range(len(contraction.spectrum_names))
        ]
        return np.array(table)[contraction.spectrum_of]

    def collecting(self, scene_index: int, lighting: Lighting, rows: Array) -> Array:
        """Electrons per (lm s) for unit field gain."""
        view = self.imagers.scenes[scene_index].view
        efficiency = self.problem.cameras.qe_index[self.imagers.camera[rows]]
        return np.asarray(view.collecting_m2[rows] * self._response[scene_index][lighting.optics, efficiency])

    # ------------------------------------------------------------ bound

    def bound(self, scene_index: int, lighting: Lighting, altitude: int) -> Array:
        """Upper bound on the electrons per lm s of every imager at one altitude, (n_imagers,)."""
        problem, imagers = self.problem, self.imagers
        rows = np.arange(len(imagers))
        gain = (
            self._paper_gain(scene_index, lighting, altitude)
            if problem.paper
            else self._full_gain_bound(scene_index, lighting, altitude)
        )
        return self.collecting(scene_index, lighting, rows) * gain

    def _paper_gain(self, scene_index: int, lighting: Lighting, altitude: int) -> Array:
        """Physics `paper` knows no field, so its bound is exact."""
        problem = self.problem
        contraction = problem.contractions[scene_index]
        spectrum = int(contraction.spectrum_of[lighting.optics])
        losses = np.array(
            [contraction.straight_loss(spectrum, q)[altitude] for q in range(len(contraction.efficiencies))]
        )
        axis = on_axis_gain(problem.optics[lighting.optics].beam, problem.scenes[scene_index].range_m)[altitude]
        return np.asarray(axis * losses[problem.cameras.qe_index[self.imagers.camera]])

    def _full_gain_bound(self, scene_index: int, lighting: Lighting, altitude: int) -> Array:
        problem, imagers = self.problem, self.imagers
        range_m = float(problem.scenes[scene_index].range_m[altitude])
        rectangle = Rectangles.of(problem, imagers, scene_index, altitude)
        light = self._light_on(scene_index, lighting, range_m, rectangle)
        loss = self._least_loss(scene_index, lighting, range_m)[problem.cameras.qe_index[imagers.camera]]
        return np.asarray(light / (4.0 * rectangle.image_area) * rectangle.crowding * loss)

    def _least_loss(self, scene_index: int, lighting: Lighting, range_m: float) -> Array:
        """Water's loss over the shortest possible paths, by efficiency curve."""
        problem = self.problem
        spectrum = int(problem.contractions[scene_index].spectrum_of[lighting.optics])
        height = min(range_m - z for z in lighting.mount.lamps(2).z_m)
        tables = [problem.table(scene_index, spectrum, q) for q in range(len(problem.efficiencies))]
        return np.array(
            [float(np.exp(log_mean_transmission(t, np.array([height]), np.array([range_m])))[0]) for t in tables]
        )

    def _light_on(self, scene_index: int, lighting: Lighting, range_m: float, rectangle: Rectangles) -> Array:
        """Upper bound of the integral over each image's floor rectangle of light per lumen."""
        beam = self.problem.optics[lighting.optics].beam
        lamps = one_side(lighting.mount.lamps(2))
        peak = beams.peak_intensity_per_sr(beam) / min(range_m - z for z in lamps.z_m) ** 2
        area = 4.0 * rectangle.half_along_m * rectangle.half_across_m
        simple = np.minimum(peak * area, 1.0)  # no more than all the light reaches the floor
        if beams.has_sharp_edge(beam):
            return np.asarray(simple)
        along = edges_to(float(rectangle.half_along_m.max(initial=1e-6)))
        across = edges_to(float(rectangle.half_across_m.max(initial=1e-6)))
        scene = self.problem.scenes[scene_index]
        least_k = float(scene.lamp_attenuation_per_m.min())
        least_c = float(scene.attenuation_per_m.min())
        x = 0.5 * (along[1:] + along[:-1])[:, None]
        y = 0.5 * (across[1:] + across[:-1])[None, :]
        cells = np.zeros((len(along) - 1, len(across) - 1))
        for sign_x, sign_y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            for index, share in enumerate(lamps.share):
                vacuum, reach, _ = lamp_light(
                    sign_x * x, sign_y * y, lamps=lamps, index=index, beam=beam, range_m=range_m
                )
                height = range_m - lamps.z_m[index]
                cells += share * vacuum * np.exp(-least_k * (reach - height))
        radius = np.square(x) + np.square(y)
        depth = range_m + rectangle.deepest_m
        cells *= np.exp(-least_c * (np.sqrt(depth**2 + radius) - depth) * rectangle.path_share)
        cells /= np.square(1.0 + radius / depth**2)
        cells *= np.diff(along)[:, None] * np.diff(across)[None, :]
        total = np.zeros((len(along), len(across)))
        total[1:, 1:] = cells.cumsum(axis=0).cumsum(axis=1)
        i = np.minimum(np.searchsorted(along, rectangle.half_along_m), len(along) - 1)
        j = np.minimum(np.searchsorted(across, rectangle.half_across_m), len(across) - 1)
        return np.asarray(np.minimum(total[i, j] * QUADRATURE_MARGIN, simple))

    # ------------------------------------------------------------ exact

    def exact(self, scene_index: int, lighting: Lighting, rows: Array, *, count: int = 2, darkest: bool = False) -> Array:
        """Electrons per lm s of these imagers at every altitude, (n, n_altitudes)."""
        problem, imagers = self.problem, self.imagers
        view = imagers.scenes[scene_index].view
        out = np.empty((len(rows), len(problem.scenes[scene_index].range_m)))
        port = np.zeros(len(rows), int) if problem.paper else imagers.port[rows]
        for value in np.unique(port):
            mine = np.nonzero(port == value)[0]
            out[mine] = problem.signal_e(
                scene_index, view.take(rows[mine]), imagers.camera[rows[mine]], port_index=int(value),
                optics=lighting.optics, mount=lighting.mount, count=count, darkest=darkest,
            )  # fmt: skip
        return out


@dataclass(frozen=True)
class Rectangles:
    """The floor rectangle that holds each image, and how densely the image samples it.

    `image_area`: half-width product in units of the floor under uniform sampling; `crowding` bounds
    the image's density of samples over the uniform one (1 behind a dome, more behind a flat port).
    """

    half_along_m: Array
    half_across_m: Array
    image_area: Array
    crowding: Array
    deepest_m: float  # how far behind the port's face rays may start; sets the mildest cos^4
    path_share: float  # the least share of the extra path that any ray really has

    @staticmethod
    def of(problem: Problem, imagers: Imagers, scene_index: int, altitude: int) -> Rectangles:
        """Rectangles of all imagers at one altitude."""
        scene, view = problem.scenes[scene_index], imagers.scenes[scene_index].view
        near, far = float(scene.range_m[0]), float(scene.range_m[-1])
        weight = 0.0 if far == near else (float(scene.range_m[altitude]) - near) / (far - near)
        along = 0.5 * ((1 - weight) * view.footprint_along_m[:, 0] + weight * view.footprint_along_m[:, 2])
        across = 0.5 * ((1 - weight) * view.footprint_across_m[:, 0] + weight * view.footprint_across_m[:, 2])
        crowding = crowding_of(problem, imagers, scene_index, view, float(scene.range_m[altitude]), along, across)
        ports = problem.ports
        deepest = float((ports.outer_radius_m + ports.gap_m + ports.thickness_m).max(initial=0.0))
        # A flat port with a gap, or glass thinner than water, may bend rays so far that no share is sure.
        odd = ~ports.is_dome & ((ports.gap_m > 0) | (ports.refractive_index < scene.n_water))
        share = 0.0 if odd.any() else float(scene.range_m[altitude]) / (float(scene.range_m[altitude]) + deepest)
        return Rectangles(along, across, along * across, crowding, deepest, share)


def crowding_of(
    problem: Problem, imagers: Imagers, scene_index: int, view: Views, range_m: float, along: Array, across: Array
) -> Array:
    """Upper bound of (samples per floor area) over (uniform): the corner's, where a flat port crowds most."""
    out = np.ones(len(imagers))
    for port in np.unique(imagers.port):
        if problem.ports.is_dome[port]:
            continue
        rows = imagers.port == port
        shape = problem.shape(int(port), scene_index)
        corner = np.hypot(view.tan_along[rows], view.tan_across[rows])
        slope = flat_slope_m(corner, shape=shape, range_m=range_m)
        steep = flat_floor_derivative(
            corner,
            gap_m=shape.gap_m,
            thickness_m=shape.thickness_m,
            n_glass=shape.n_glass,
            n_water=shape.n_water,
            range_m=range_m,
        )
        out[rows] = along[rows] * across[rows] / (view.tan_along[rows] * view.tan_across[rows] * slope * steep)
    return out


def edges_to(largest_m: float) -> Array:
    """Rectangle edges from 0 to the largest, 5 % apart beyond the first."""
    return np.concatenate([[0.0], largest_m * (1 + 1e-12) * np.geomspace(1.05 ** -(EDGES - 2), 1.0, EDGES - 1)])

"""The light of one hardware choice: integrals over image and floor, worked out once and kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.designs import Hardware
from uwopt.forward.figures import full_light_lm
from uwopt.forward.floor_light import footprint_light
from uwopt.forward.lamp_light import image_light, kind_of_field
from uwopt.forward.lamp_views import lamp_clearance_m
from uwopt.forward.lamps import LampGroup
from uwopt.forward.light_columns import ImageLight, SunLight
from uwopt.forward.part_columns import Cameras, Lenses, Lights, Ports
from uwopt.forward.problem import Problem
from uwopt.forward.remembered import LoneField
from uwopt.forward.scene import Pixels
from uwopt.forward.sun_light import sun_light
from uwopt.forward.views import table_reach_m, views
from uwopt.model.image_mean import cells
from uwopt.model.imaging import floor_point, lamp_light

DARK_CELLS = 80  # a side of the image, where its unlit share is counted


class DesignLight:
    """What light one hardware choice has in every scene; settings come and go, the integrals stay."""

    def __init__(self, problem: Problem, hardware: Hardware):
        self.hardware = hardware
        one = np.array([0])
        self.cameras: Cameras = problem.cameras.take(one + hardware.camera)
        self.lenses: Lenses = problem.lenses.take(one + hardware.lens)
        self.lights: Lights = problem.lights.take(one + hardware.light)
        self.port: Ports = problem.ports.take(one + hardware.port)
        self.optics, self.efficiency = int(self.lights.optics_index[0]), int(self.cameras.qe_index[0])
        self.lit = LampGroup(self.optics, hardware.mount, hardware.count)
        self.shapes = [problem.shape(hardware.port, i) for i in range(len(problem.scenes))]
        self.views = [
            views(scene, self.cameras, self.lenses, shape, landscape=hardware.landscape)
            for scene, shape in zip(problem.scenes, self.shapes, strict=True)
        ]
        self.problem = problem.reaching([table_reach_m(view) for view in self.views])
        self._known: dict[Any, Any] = {}  # what no setting changes, worked out once

    def _once(self, key: Any, make: Callable[[], Any]) -> Any:
        """What `make` gives, kept: settings come and go, the light's integrals stay."""
        if key not in self._known:
            self._known[key] = make()
        return self._known[key]

    def _lit(self, key: Any, make: Callable[[], Any]) -> Any:
        """The same of light, which missions that ask for more or less in the same scenes share."""
        known = self.problem.known_light.setdefault(self.hardware, {})
        if key not in known:
            known[key] = make()
        return known[key]

    def lumens(self, level: float) -> float:
        """Light of all lamps at a level [lm]: their output factor included."""
        full_lm = float(full_light_lm(self.lights, np.array([self.hardware.count]))[0])
        return full_lm * level * float(self.lights.output_factor[0])

    def light_at_centre(self, index: int) -> ImageLight:
        """Electrons per lm s of nameplate light in the middle of the image; the veils together as one.

        At the nominal altitude, which stands for all.
        """
        light: ImageLight = self._lit(("centre", index), lambda: self._light_at_centre(index))
        return light

    def _light_at_centre(self, index: int) -> ImageLight:
        problem = self.problem
        field = kind_of_field(problem, self.optics)(
            problem, index, port_index=self.hardware.port, lit=self.lit, efficiency=self.efficiency
        )
        middle, ranges_m, at = np.zeros((1, 1)), problem.scenes[index].range_m, problem.scenes[index].nominal
        signal, veil = field.at_pixels(
            self.views[index], middle, middle, veils=True, ranges_m=ranges_m[at : at + 1]
        )
        shape = (1, len(ranges_m))
        light = ImageLight(
            np.broadcast_to(signal[:, :, 0], shape), None if veil is None else np.broadcast_to(veil[:, :, 0], shape)
        )
        return light.scaled(self.lights.output_factor)

    def floor_light(self, index: int) -> tuple[float, float]:
        """Mean and least floor illuminance per lumen over the footprint at the nominal altitude [1/m^2]."""
        both: tuple[float, float] = self._lit(("floor", index), lambda: footprint_light(
            self.problem, index, self.views[index], port_index=self.hardware.port, lit=self.lit,
            altitude=self.problem.scenes[index].nominal,
        ))  # fmt: skip
        return both

    def dark_share(self, index: int) -> float:
        """Share of the image that no lamp lights, at the nominal altitude."""
        return float(self._lit(("dark", index), lambda: self._dark_share(index)))

    def lamp_clearance_m(self, index: int) -> float:
        """Least distance of a lamp's middle from any ray of the image, at the lowest altitude."""
        return float(self._once(("clearance", index), lambda: lamp_clearance_m(
            self.problem, index, self.views[index], port=np.array([self.hardware.port]), lit=self.lit
        )[0]))  # fmt: skip

    def _dark_share(self, index: int) -> float:
        scene, view = self.problem.scenes[index], self.views[index]
        beam = self.problem.beam(index, self.optics)
        lamps, range_m = self.lit.lamps, float(scene.range_m[scene.nominal])
        middles, _ = cells(DARK_CELLS)
        along, across = np.meshgrid(view.tan_along[0] * middles, view.tan_across[0] * middles)
        x_m, y_m, _ = floor_point(along, across, shape=self.shapes[index], range_m=range_m)
        lit = np.zeros(x_m.shape, bool)
        for n in range(len(lamps.share)):
            light, _, _ = lamp_light(
                x_m, y_m, lamps=lamps, index=n, beam=beam, range_m=range_m, slope=scene.slope
            )
            lit |= light > 0.0
        return float(1.0 - lit.mean())

    def sun_light(self, index: int, *, pixels: Pixels | None = None, channel: str | None = None) -> SunLight | None:
        """Electrons per second from the sun."""
        key = ("sun", index, pixels, channel)
        sun: SunLight | None = self._lit(key, lambda: self._sun_light(index, pixels, channel))
        return sun

    def _sun_light(self, index: int, pixels: Pixels | None, channel: str | None) -> SunLight | None:
        hw = self.hardware
        return sun_light(
            self.problem,
            index,
            self.views[index],
            np.array([hw.camera]),
            port_index=np.array([hw.port]),
            mount=hw.mount,
            count=hw.count,
            channel=channel,
            pixels=pixels,
        )

    def signal_e(self, index: int) -> Array:
        """Electrons per lm s of light that forms the image, behind the lamps' windows."""
        hw = self.hardware
        return image_light(
            self.problem, index, self.views[index], np.array([hw.camera]), port_index=hw.port, lit=self.lit,
            veils="none",
        ).signal_e  # fmt: skip

    def image_light(
        self, index: int, *, pixels: Pixels | None = None, channel: str | None = None, altitude: int | None = None
    ) -> ImageLight:
        """Electrons per lm s of nameplate light; of pixels at one altitude, which stands for all, or at all."""
        key = ("light", index, pixels, channel, altitude)
        light: ImageLight = self._lit(key, lambda: self._image_light(index, pixels, channel, altitude))
        return light

    def _image_light(
        self, index: int, pixels: Pixels | None, channel: str | None, altitude: int | None
    ) -> ImageLight:
        hw, split = self.hardware, pixels is not None and not self.problem.paper
        light = image_light(
            self.problem, index, self.views[index], np.array([hw.camera]), port_index=hw.port,
            lit=self.lit, pixels=pixels, channel=channel, means=not split, field_type=LoneField, altitude=altitude,
        ).scaled(self.lights.output_factor)  # fmt: skip
        if not split:
            return light
        means = self.image_light(index, channel=channel)  # the costly integrals, often known already
        return means.with_pixels(light)

"""Many designs at once: hardware as index columns and settings as arrays in, figures out.

The forward model for searches that evaluate populations. What depends on hardware alone is integrated
once a batch, in groups that share port, light and efficiency curve; no loop runs over designs.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.forward import effects as influence
from uwopt.forward.breathing import AT_FOCUS, at_focus
from uwopt.forward.columns import rows_alike
from uwopt.forward.designs import Designs
from uwopt.forward.figures import DesignRows, Figures, SettingRows, figures_of, levers_m
from uwopt.forward.lamp_light import ImageLight, SunLight, Veils, image_light
from uwopt.forward.lamps import LampGroup
from uwopt.forward.pixels import fewest_pixels
from uwopt.forward.problem import Problem
from uwopt.forward.scene import Pixels, SceneOptics
from uwopt.forward.sharpness import SharpRows, Unfocused, motion_px_per_s, unfocused_of
from uwopt.forward.sun_light import sun_light
from uwopt.forward.views import Views, focus_map, table_reach_m, views
from uwopt.model.effects import Effects
from uwopt.model.port import FocusMap

FEW = 4  # designs that are judged first: what they need, the batch needs
MOST_CHANNELS = 3  # of colour columns, where pixels are more
VEILS = {"forward_veil", "backscatter"}


class Batch:
    """n designs in all scenes of a problem, their hardware tabulated."""

    def __init__(self, problem: Problem, designs: Designs):
        self.problem, self.designs = problem, designs
        self.views = [self._views(scene, index) for index, scene in enumerate(problem.scenes)]
        self.problem = problem.reaching([table_reach_m(view) for view in self.views])
        self._signals: dict[int, ImageLight] = {}
        self._unfocused: dict[int, Unfocused] = {}
        self._covered: dict[int, tuple[Array, Views]] = {}  # by scene, at the last focuses

    def signal(self, index: int) -> ImageLight:
        """Image-forming light of all designs in one scene, worked out once: bounds and figures both rest on it."""
        if index not in self._signals:
            self._signals[index] = self._light(index, veils="none")
        return self._signals[index]

    def _light(
        self, index: int, *, veils: Veils, pixels: Pixels | None = None, known: ImageLight | None = None
    ) -> ImageLight:
        """Electrons per lm s behind the lamps' windows, group by group."""
        d, view = self.designs, self.views[index]
        parts = []
        for rows, port, optics in self.groups(by_curve=False):
            for count in np.unique(d.count[rows]) if pixels else [2]:
                mine = rows[d.count[rows] == count] if pixels else rows
                light = image_light(
                    self.problem, index, view.take(mine), d.camera[mine], port_index=port,
                    lit=LampGroup(optics, d.mount, int(count)), pixels=pixels, veils=veils,
                    known=None if known is None else known.take(mine),
                )  # fmt: skip
                parts.append((mine, light))
        return ImageLight.in_places(parts, len(d))

    def _views(self, scene: SceneOptics, index: int) -> Views:
        """Geometry row by row, port by port and orientation by orientation."""
        d, problem = self.designs, self.problem
        columns: dict[str, Array] = {}
        for port in np.unique(d.port):
            for landscape in (False, True):
                mine = np.nonzero((d.port == port) & (d.landscape == landscape))[0]
                if len(mine) == 0:
                    continue
                part = views(
                    scene, problem.cameras.take(d.camera[mine]), problem.lenses.take(d.lens[mine]),
                    problem.shape(int(port), index), landscape=landscape,
                )  # fmt: skip
                for f in fields(part):
                    value = getattr(part, f.name)
                    column = columns.setdefault(f.name, np.empty((len(d), *value.shape[1:])))
                    column[mine] = value
        return Views(**columns)

    def view_at(self, index: int, dioptre_per_m: Array) -> Views:
        """What the images of one scene cover at these focuses, worked out once for the same ones."""
        known, made = self._covered.get(index, (None, None))
        if made is None or known is None or not np.array_equal(known, dioptre_per_m):
            made = self._view_at(index, dioptre_per_m)
            self._covered[index] = dioptre_per_m, made
        return made

    def _view_at(self, index: int, dioptre_per_m: Array) -> Views:
        view, d, scene = self.views[index], self.designs, self.problem.scenes[index]
        pitch = self.problem.cameras.pixel_pitch_m[d.camera]
        columns = {name: np.array(getattr(view, name)) for name in AT_FOCUS}
        for mine, shape in self.problem.shapes(d.port, index):
            part = at_focus(scene, shape, view.take(mine), pitch[mine], dioptre_per_m[mine])
            for name, column in columns.items():
                column[mine] = getattr(part, name)
        return replace(view, **columns).with_arrays(by_altitude)

    def groups(self, *, by_curve: bool, some: Array | None = None) -> Iterator[tuple[Array, int, int]]:
        """Rows (or some of them) that share port and light optics (and efficiency curve), with both."""
        d, problem = self.designs, self.problem
        rows = np.arange(len(d)) if some is None else some
        keys = [d.port[rows], problem.lights.optics_index[d.light[rows]]]
        if by_curve:
            keys.append(problem.cameras.qe_index[d.camera[rows]])
        first, back = rows_alike(*keys)
        for n, one in enumerate(first):
            yield rows[back == n], int(keys[0][one]), int(keys[1][one])

    def influences(
        self, tolerance: float, settings: list[SettingRows] | None = None, *, information: bool = False
    ) -> list[influence.Influence]:
        """Each effect's bound over all these designs, and whether it is kept at this tolerance."""
        every = np.arange(len(self.designs))
        few = every[:: max(1, len(every) // FEW)]
        found = influence.judge(self.problem, self._judged(few, settings), information=information)
        beyond = {name for name, (bound, _) in found.items() if bound > tolerance}
        if len(few) < len(every) and not beyond >= VEILS:  # what a few designs need is kept for all
            found = influence.judge(self.problem, self._judged(every, settings), information=information)
        return influence.choose(found, tolerance)

    def _judged(self, some: Array, settings: list[SettingRows] | None) -> list[influence.ImagerGroup]:
        """Some of the designs in every scene, in groups that share their integrals."""
        d = self.designs
        return [
            influence.ImagerGroup(
                scene_index=index, view=view.take(rows), camera=d.camera[rows], port=port,
                light=d.light[rows], optics=optics, mount=d.mount, count=d.count[rows],
                settings=None if settings is None else settings[index].take(rows),
                signal_e=self.signal(index).signal_e[rows],
            )
            for index, view in enumerate(self.views)
            for rows, port, optics in self.groups(by_curve=True, some=some)
        ]  # fmt: skip

    def rows(self, index: int, *, pixels: Pixels | None = None) -> DesignRows:
        """Hardware of all designs in one scene, light integrals included, with the problem's effects."""
        d, problem, view = self.designs, self.problem, self.views[index]
        scene = problem.scenes[index]
        asked = pixels or scene.pixels
        light = self._light(
            index,
            veils="all",
            pixels=None if scene.paper else asked,
            known=None if scene.paper else self.signal(index),
        )
        lights = problem.lights.take(d.light)
        sun = sun_light(problem, index, view, d.camera, port_index=d.port, mount=d.mount, pixels=asked)
        light, sun = at_fewest_pixels(light, sun)
        return DesignRows(
            cameras=problem.cameras.take(d.camera),
            lenses=problem.lenses.take(d.lens),
            lights=lights,
            count=d.count.astype(float),
            view=view.with_arrays(by_altitude),
            focus_map=focus_maps(problem, index, d.port),
            lever_m=by_altitude(levers_m(scene, problem.ports.outer_radius_m[d.port])),
            light=light.scaled(lights.output_factor).with_arrays(by_altitude),
            sun=None if sun is None else sun.with_arrays(by_altitude),
        )

    def sharp_rows(self, index: int, dioptre_per_m: Array) -> SharpRows:
        """What the sharpness of all designs depends on at this focus; what no focus changes is worked out once."""
        if index not in self._unfocused:
            d, problem = self.designs, self.problem
            hardware = unfocused_of(
                problem, index, self.views[index], camera=d.camera, lens=d.lens, port=d.port,
                optics=problem.lights.optics_index[d.light],
            )  # fmt: skip
            if problem.scenes[index].view.requirements.min_mtf_half_nyquist is not None:
                hardware = hardware.with_colour_left()
            self._unfocused[index] = hardware
        moving = motion_px_per_s(
            self.problem.scenes[index], self.view_at(index, dioptre_per_m),
            self.problem.ports.outer_radius_m[self.designs.port],
        )  # fmt: skip
        return replace(self._unfocused[index].focused(dioptre_per_m), blur_px_per_s=moving)

    def figures(
        self, index: int, rows: DesignRows, settings: SettingRows, *, information: bool = False
    ) -> Figures:
        """All figures that requirements need in one scene."""
        scene = self.problem.scenes[index]
        rows = replace(rows, view=self.view_at(index, settings.dioptre_per_m))
        if not scene.paper and (information or scene.view.requirements.asks_sharpness):
            rows = replace(rows, sharp=self.sharp_rows(index, settings.dioptre_per_m))
        return figures_of(scene, rows, settings, information=information)

    def with_effects(self, effects: Effects) -> Batch:
        """The same designs in a model that keeps these effects."""
        lean = Batch(self.problem.with_effects(effects), self.designs)
        lean._signals = self._signals  # with the window's loss by angle, which is then no less true
        return lean


def focus_maps(problem: Problem, scene_index: int, port: Array) -> FocusMap:
    """Focus maps of designs' ports in one scene, as columns."""
    ports, back = np.unique(port, return_inverse=True)
    maps = [focus_map(problem.scenes[scene_index], problem.shape(int(one), scene_index)) for one in ports]
    return FocusMap(*(np.array([getattr(one, f.name) for one in maps])[back] for f in fields(FocusMap)))


def by_altitude(column: Array) -> Array:
    """The same numbers, designs of one altitude next to each other: what is done for all goes along them.

    Of pixels (n, n_altitudes, n_pixels) those of one design stay together, for there they are compared.
    """
    return column if column.ndim == 3 and column.shape[2] > MOST_CHANNELS else np.asfortranarray(column)


def at_fewest_pixels(light: ImageLight, sun: SunLight | None) -> tuple[ImageLight, SunLight | None]:
    """The same light at those pixels alone that may decide: figures of many settings look at no others."""
    worst = light.worst_e
    if worst is None or worst.shape[2] <= light.may_miss + 1:
        return light, sun
    veil = light.worst_veil_e
    sources = [(worst, np.zeros_like(worst) if veil is None else veil)]
    shining = None if sun is None else sun.worst_e_s
    if sun is not None and shining is not None:
        over = sun.worst_veil_e_s
        sources += [(shining, np.zeros_like(shining) if over is None else over)]
    (worst_e, worst_veil_e), *others = fewest_pixels(sources, light.may_miss)
    light = replace(light, worst_e=worst_e, worst_veil_e=None if veil is None else worst_veil_e)
    for at_sun, over_sun in others:
        assert sun is not None
        kept = None if sun.worst_veil_e_s is None else over_sun
        sun = replace(sun, worst_e_s=at_sun, worst_veil_e_s=kept)
    return light, sun

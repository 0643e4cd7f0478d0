"""Designs as rows of settings: what a search knows of the light and the limits of imagers under lights.

Bounds look at the pixels that are likely to decide, with their veils last or under the sun; what is solved, at all that
count.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import Deadline
from uwopt.forward.columns import distinct, rows_alike
from uwopt.forward.floor_light import even_enough
from uwopt.forward.lamp_light import Veils
from uwopt.forward.lamp_views import keeps_clear, lamps_refused
from uwopt.forward.light_columns import ImageLight, SunLight
from uwopt.forward.problem import Problem
from uwopt.forward.remembered import RememberedSunField
from uwopt.forward.scene_rows import SceneRows
from uwopt.forward.setting_rows import (
    MISPLACED_S,
    PIXEL_COLUMNS,
    of_farthest_pixels,
    of_fewest_pixels,
    setting_rows,
)
from uwopt.forward.sharpness import SharpRows
from uwopt.forward.sun_light import sun_light
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.lightings import Under
from uwopt.solvers.settings.sharp_time import while_sharp

Narrowed = Callable[[ImageLight], ImageLight]


class NodeRows:
    """The rows of designs of some imagers."""

    def __init__(
        self, problem: Problem, objective: Objective, bounds: Bounds, deadline: Deadline,
        narrowed: Narrowed | None = None,
    ):  # fmt: skip
        """Of the imagers of some bounds; `narrowed`: the pixels of an image that are kept for all rows of it."""
        self.problem, self.objective, self.deadline, self.narrowed = problem, objective, deadline, narrowed
        self.imagers, self.tables, self.bounds = bounds.imagers, bounds.tables, bounds

    def rows(
        self, imager: Array, lights: list[ImageLight], light: Array, count: Array, under: Under, *,
        optimistic: bool = False, stage: Veils = "none", light_alone: bool = False,
    ) -> list[SceneRows]:  # fmt: skip
        """The settings' view of these designs, by scene; `light_alone`: without rules and sharpness."""
        result = []
        for index, seen in enumerate(lights):
            pixels, sunlit = self.problem.scenes[index].pixels, self.bounds.needs.is_sunlit(index)
            likely = optimistic and (sunlit or stage == "likely")  # pixels with their veils, few of them
            if pixels is not None and optimistic and not likely:
                seen = self._with_likely_pixel(index, imager, count, under, seen)
            elif pixels is not None:
                seen = self.with_pixels(index, imager, count, under, seen, veils="likely" if likely else "all")
            rows = setting_rows(
                self.problem, index, camera=self.imagers.camera[imager], light=light, count=count,
                focused=self.imagers.scenes[index].focused.take(imager), image_light=seen,
                sun=self.sun(index, imager, count, under, few=likely),
                sharp=None if light_alone else self.sharp(index, imager, under),
            )  # fmt: skip
            if pixels is not None and sunlit and (likely or self.narrowed is None):
                few = of_farthest_pixels if likely else of_fewest_pixels
                rows = self._with_few_pixels(
                    partial(few, unlit=self.problem.are_unlit(light)), index, rows, imager, count, under
                )
            if not light_alone and not optimistic and self.has_rules(index):
                kept = self.keep_rules_in(index, imager, light, count, under)
                rows = replace(rows, time_max_s=np.where(kept, rows.time_max_s, MISPLACED_S))
            rows = replace(rows, optimistic=optimistic)
            result.append(while_sharp(rows) if optimistic and not light_alone else rows)
        return result

    def _with_few_pixels(
        self, few: Callable[[SceneRows], SceneRows], scene_index: int, rows: SceneRows, imager: Array, count: Array,
        under: Under,
    ) -> SceneRows:  # fmt: skip
        """The rows with fewer pixels, picked once of each image under a number of lamps: what collects scales all."""
        first, back = rows_alike(self.tables.images[1][imager], count, under.index)
        made, collecting = few(rows.take(first)), self.imagers.scenes[scene_index].view.collecting_m2[imager]
        scale = (collecting / collecting[first][back])[:, None, None]
        columns = {name: getattr(made, name) for name in PIXEL_COLUMNS}
        changes: dict[str, Any] = {name: c[back] * scale for name, c in columns.items() if c is not None}
        return replace(rows, **changes)

    def sharp(self, scene_index: int, imager: Array, under: Under) -> SharpRows | None:
        """What MTF and information depend on, where either is asked for."""
        needs = self.problem.scenes[scene_index].view.requirements
        if not needs.asks_sharpness and not self.objective.weight("information"):
            return None
        parts = []
        for optics, mine in under.by_optics():
            unique, back = distinct(imager[mine])
            parts.append((mine, self.imagers.sharpness(self.problem, scene_index, unique, optics).take(back)))
        return parts[0][1] if len(parts) == 1 else SharpRows.in_places(parts, len(imager))

    def sun(
        self, scene_index: int, imager: Array, count: Array, under: Under, *, few: bool = False
    ) -> SunLight | None:
        """The sun's light in these images; the pixels looked at depend on the lamps and their number."""
        parts, pixels = [], self.problem.scenes[scene_index].pixels
        alike = [(under.of(0), 1, np.arange(len(count)))] if not pixels and len(count) else under.with_number(count)
        for lighting, number, mine in alike:
            unique, back = distinct(imager[mine])
            sun = sun_light(
                self.problem,
                scene_index,
                self.imagers.scenes[scene_index].view.take(unique),
                self.imagers.camera[unique],
                port_index=self.imagers.port[unique],
                mount=lighting.mount,
                count=number,
                pixels=pixels,
                few=few,
                field_type=RememberedSunField,
            )
            if sun is None:
                return None
            same = len(unique) == len(back) and bool((back == np.arange(len(back))).all())
            parts.append((mine, sun if same else sun.take(back)))
        return parts[0][1] if len(parts) == 1 else SunLight.in_places(parts, len(count))

    def has_rules(self, scene_index: int) -> bool:
        """Whether one scene asks for even light, or for lamps out of the view."""
        needs = self.problem.scenes[scene_index].view.requirements
        return needs.min_uniformity is not None or lamps_refused(self.problem, scene_index)

    def asks_of_image(self, scene_index: int) -> bool:
        """Whether one scene asks for what takes integrals over the image beside its mean."""
        return self.problem.scenes[scene_index].at_worst or self.has_rules(scene_index)

    def keep_rules(
        self, imager: Array, light: Array, count: Array, under: Under, *, whole: bool
    ) -> Array:
        """Whether designs keep in all scenes the rules that no setting can mend: even light, no lamp in the view.

        whole : the whole floor is looked at; else few places of it, which refuse none that keeps the rules
        """
        kept = np.ones(len(imager), bool)
        for index in range(len(self.problem.scenes)):
            if self.has_rules(index):
                self.deadline.check()
                kept &= self.keep_rules_in(index, imager, light, count, under, whole=whole)
        return kept

    def keep_rules_in(
        self, scene_index: int, imager: Array, light: Array, count: Array, under: Under, *, whole: bool = True
    ) -> Array:
        """The same in one scene; no lamp is none in the view, and its light is even."""
        kept = np.array([self.problem.unlit(one) for one in range(len(self.problem.parts.lights))])[light]
        lit = np.nonzero(~kept)[0]
        kept[lit] = self.lamps_keep_rules(scene_index, imager[lit], count[lit], under.take(lit), whole=whole)
        return kept

    def lamps_keep_rules(
        self, scene_index: int, imager: Array, count: Array, under: Under, *, whole: bool = True
    ) -> Array:
        """The same of lamps that burn."""
        wanted = self.problem.scenes[scene_index].view.requirements.min_uniformity
        kept = np.empty(len(imager), bool)
        for lighting, number, mine in under.with_number(count):
            view = self.imagers.scenes[scene_index].view.take(imager[mine])
            port = self.imagers.port[imager[mine]]
            fine, lit = np.ones(len(mine), bool), lighting.of(number)
            if lamps_refused(self.problem, scene_index):
                fine = keeps_clear(self.problem, scene_index, view, port=port, lit=lit)
            if wanted is not None and fine.any():
                fine[fine] = even_enough(
                    self.problem, scene_index, view.take(fine), port=port[fine], lit=lit, wanted=wanted,
                    deadline=self.deadline, whole=whole,
                )  # fmt: skip
            kept[mine] = fine
        return kept

    def _with_likely_pixel(
        self, scene_index: int, imager: Array, count: Array, under: Under, seen: ImageLight
    ) -> ImageLight:
        """With no less than the light at the pixel that decides, at the farthest altitude: for bounds."""
        pixels = self.problem.scenes[scene_index].pixels
        assert pixels is not None
        most_e = np.empty(len(imager))
        for lighting, number, mine in under.with_number(count):
            unique, back = distinct(imager[mine])
            most_e[mine] = self.tables.likely_pixel(scene_index, lighting, unique, count=number, pixels=pixels)[back]
        return seen.with_pixels(ImageLight(seen.signal_e, worst_e=most_e[:, None, None]))

    def with_pixels(
        self, scene_index: int, imager: Array, count: Array, under: Under, seen: ImageLight, *, veils: Veils
    ) -> ImageLight:  # fmt: skip
        """With the light at the pixels that the SNR is asked of: their share of each lamp depends on the number."""
        narrowed = None if self.bounds.needs.is_sunlit(scene_index) else self.narrowed  # sun and lamps decide together
        first, back = rows_alike(imager if narrowed is None else self.tables.images[1][imager], count, under.index)
        parts = []
        for lighting, number, mine in under.take(first).with_number(count[first]):
            at = self.tables.exact(
                scene_index,
                lighting,
                imager[first[mine]],
                count=number,
                pixels=self.problem.scenes[scene_index].pixels,
                means=False,
                veils=veils,
                deadline=self.deadline,
            )
            parts.append((mine, at))
        there = ImageLight.in_places(parts, len(first))
        if narrowed is None:
            return seen.with_pixels(there.take(back))
        collecting = self.imagers.scenes[scene_index].view.collecting_m2[imager]
        return seen.with_pixels(narrowed(there).take(back).scaled(collecting / collecting[first][back]))

"""Populations evaluated in batches through the forward model: objectives, constraint violations, designs.

What counts as feasible is what the margins of an evaluation say; a design's figures are those that
`evaluate` reports of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.figures import DesignRows, Figures, SettingRows, figures_of, levers_m
from uwopt.forward.part_columns import FLASH
from uwopt.forward.problem import Problem
from uwopt.forward.scene_rows import SceneRows
from uwopt.forward.setting_rows import setting_rows
from uwopt.forward.views import focus_map, narrowest_m
from uwopt.model.port import FocusMap
from uwopt.objectives.objective import MAXIMISED, Terms
from uwopt.objectives.own import OwnObjective
from uwopt.objectives.requirements import (
    MarginRows,
    duration_margins,
    scene_margins,
    system_margins,
    trigger_margins,
)
from uwopt.quantities import TERMS
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.population.coding import CodedHardware, Coding
from uwopt.solvers.population.decoding import Decoded, shortfall
from uwopt.solvers.population.light_store import LightStore, SeenLight
from uwopt.solvers.settings.closed_form import Chosen
from uwopt.units import S_PER_H, ratio_to_db

LEAST_MISS, MOST_MISS = 1e-4, 10.0  # what one requirement that is missed adds to a violation
TERM_FIGURES = {term: one.name for term, one in TERMS.items()}


@dataclass(frozen=True)
class Solved:
    """The designs of vectors that have settings: places of the vectors, settings, and the feasible among them."""

    place: Array  # of designs with rows among all vectors
    built: CodedHardware
    decoded: Decoded
    good: Array  # among `place`: feasible
    figures: Mapping[str, Array]  # of the good ones
    violation: Array  # of all vectors; 0: feasible


class Evaluator:
    """Objectives and violations of vectors."""

    def __init__(self, search: Search, axes: Sequence[str | OwnObjective], coding: Coding):
        self.search, self.problem, self.axes, self.coding = search, search.problem, list(axes), coding
        self.own = any(not isinstance(axis, str) for axis in axes)
        mtf = any(s.view.requirements.asks_sharpness for s in self.problem.scenes)
        wanted = "information" in axes or self.own or bool(search.objective.weight("information"))
        self.information = wanted and not self.problem.paper
        self.store = LightStore(search, sharp=self.information or (mtf and not self.problem.paper))
        sunlit = any(s.sunlit for s in self.problem.scenes)  # light that no veil is charged to
        self.staged = self.problem.effects.veils and not sunlit
        self.count = 0

    def evaluate(self, vectors: Array) -> tuple[Array, Array]:
        """Values (n, n_axes), less is better, inf where infeasible; and violations (n,), 0 where feasible."""
        solved = self.solved(vectors)
        self.count += len(vectors)
        values = np.full((len(vectors), len(self.axes)), np.inf)
        if len(solved.good):
            values[solved.place[solved.good]] = self._values(solved.figures)
        return values, solved.violation

    def found(self, vectors: Array) -> tuple[Array, list[Found]]:
        """The designs of vectors with all their settings, and which vectors they are of: those that are feasible.

        What was feasible among others may miss a requirement by rounding now; it is no design then.
        """
        solved = self.solved(vectors)
        imagers, figures, good = self.search.imagers, solved.figures, solved.good
        if len(good) == 0:
            return good, []
        built = solved.built.take(good)
        nan = np.full(len(good), np.nan)
        terms = Terms(**{name: figures.get(key, nan) for name, key in TERM_FIGURES.items()})
        value = self.search.objective.cost_to_minimise(terms)
        decoded, result = solved.decoded, []
        for i, (row, imager) in enumerate(zip(good.tolist(), built.imager.tolist(), strict=True)):
            result.append(Found.of(
                imagers, imager, [chosen.of_row(row) for chosen in decoded.chosen], light=int(built.light[i]),
                count=int(built.count[i]), lighting=self.search.tables.lightings[int(built.lighting[i])],
                minimised=float(value[i]), power_w=float(figures["power_w"][i]), cost=float(figures["cost"][i]),
                mass_kg=float(figures["mass_kg"][i]), snr_db=float(figures["snr_db"][i]),
            ))  # fmt: skip
        return solved.place[good], result

    # ------------------------------------------------------------ steps

    def solved(self, vectors: Array) -> Solved:
        """Hardware, settings and figures of vectors."""
        built = self.coding.built(vectors)
        violation = self.coding.beyond(built)
        place = np.nonzero(violation <= 0.0)[0]
        built = built.take(place)
        if self.staged and len(place):
            lacking = lacking_without_veils(self.search, self.store, built)
            violation[place] = lacking
            open_ = np.nonzero(lacking <= 0.0)[0]
            place, built = place[open_], built.take(open_)
        none = np.empty(0, int)
        if len(place) == 0:
            return Solved(place, built, Decoded([], violation[place]), none, {}, violation)
        scenes = range(len(self.problem.scenes))
        seen = [self.store.seen(s, built.imager, built.lighting, built.count) for s in scenes]
        rows = [scene_rows(self.search, s, built, seen[s]) for s in scenes]
        light_limit_w = self.problem.scene_power_limit_w - self.search.imagers.camera_power_w[built.imager]
        motorised = self.search.motorised[built.imager]
        decoded = self.coding.decoded(vectors[place], rows, motorised, light_limit_w)
        violation[place] = decoded.missing
        fits = np.nonzero(decoded.missing <= 0.0)[0]
        if len(fits) == 0:
            return Solved(place, built, decoded, none, {}, violation)
        some = built.take(fits)
        made = [self._figures(s, some, seen[s].take(fits), decoded.chosen[s].take(fits)) for s in scenes]
        missed = np.sum([missed_of(self._margins(s, some, *made[s]), len(fits)) for s in scenes], axis=0)
        missed += missed_of(self._over_scenes([figures for _, _, figures in made]), len(fits))
        violation[place[fits]] = missed
        holds = np.nonzero(missed <= 0.0)[0]
        figures = {name: c[holds] for name, c in self._named(made, some).items()}
        return Solved(place, built, decoded, fits[holds], figures, violation)

    # ------------------------------------------------------------ figures

    def _design_rows(self, s: int, built: CodedHardware, seen: SeenLight) -> DesignRows:
        """The forward model's view of designs in one scene."""
        problem, imagers, scene = self.problem, self.search.imagers, self.problem.scenes[s]
        port, lights = imagers.port[built.imager], problem.lights.take(built.light)
        return DesignRows(
            cameras=problem.cameras.take(imagers.camera[built.imager]),
            lenses=problem.lenses.take(imagers.lens[built.imager]), lights=lights, count=built.count.astype(float),
            view=imagers.scenes[s].view.take(built.imager), focus_map=focus_maps(problem, s, port),
            lever_m=levers_m(scene, problem.ports.outer_radius_m[port]),
            light=seen.light.scaled(lights.output_factor), sun=seen.sun, sharp=seen.sharp,
            spacer_m=imagers.scenes[s].focused.spacer_m[built.imager],
        )  # fmt: skip

    def _figures(
        self, s: int, built: CodedHardware, seen: SeenLight, chosen: Chosen
    ) -> tuple[DesignRows, SettingRows, Figures]:
        """What the forward model says of designs at their decoded settings in one scene."""
        rows, focused = self._design_rows(s, built, seen), self.search.imagers.scenes[s].focused
        pulse = chosen.time_s  # of lamps that burn nobody looks at it; inf would be no number among pulses
        assert chosen.exposure_s is not None
        settings = SettingRows(
            f_number=chosen.f_number, exposure_s=chosen.exposure_s,
            pulse_s=np.where(rows.lights.kind == FLASH, rows.lights.flash_duration_s, pulse), gain=chosen.gain,
            level=chosen.level, rate_hz=focused.rate_hz[built.imager],
            dioptre_per_m=focused.dioptre_per_m[built.imager],
        )  # fmt: skip
        scene = self.problem.scenes[s]
        return rows, settings, figures_of(scene, rows, settings, information=self.information)

    def _power_w(self, figures: Figures) -> Array:
        """Mean power of everything in one scene."""
        return self.problem.carried_power_w(figures.camera_power_w) + figures.light_power_w

    def _over_scenes(self, figures: Sequence[Figures]) -> list[MarginRows]:
        """Limits of energy and storage over all scenes together."""
        duration, count = self.problem.duration, self.problem.mission.vehicle.camera_count
        return list(
            duration_margins(
                duration,
                mean_power_w=duration.mean([self._power_w(f) for f in figures]),
                mean_data_rate_mb_s=duration.mean([count * f.data_rate_mb_s for f in figures]),
            )
        )

    def _margins(
        self, s: int, built: CodedHardware, rows: DesignRows, settings: SettingRows, figures: Figures
    ) -> list[MarginRows]:
        """Every requirement that settings touch; cost, mass, depth and view were checked with the hardware."""
        problem, limits = self.problem, self.problem.mission.limits
        nothing = np.zeros(len(built.imager))
        camera_peak = problem.camera_power_w(rows.cameras)
        return [
            *scene_margins(problem.scenes[s], rows, settings, figures, limits),
            *trigger_margins(rows.cameras, rows.lights),
            *system_margins(
                limits, cost_limit_value=nothing, power_w=self._power_w(figures),
                peak_power_w=camera_peak + figures.light_peak_power_w, mass_kg=nothing,
                data_rate_mb_s=figures.data_rate_mb_s * problem.mission.vehicle.camera_count, depth_m=0.0,
                ratings_m={}, accepted=frozenset(),
            ),
        ]  # fmt: skip

    def _values(self, figures: Mapping[str, Array]) -> Array:
        """Objectives of feasible designs, less is better."""
        columns = []
        for axis in self.axes:
            if isinstance(axis, str):
                column = figures[TERM_FIGURES[axis]]
                columns.append(-column if axis in MAXIMISED else column)
            else:
                columns.append(axis.minimised(figures))
        return np.stack(columns, axis=1)

    def _named(
        self, made: list[tuple[DesignRows, SettingRows, Figures]], built: CodedHardware
    ) -> dict[str, Array]:
        """Figures by name, each of the scene where it is worst; parts too, where own objectives may ask."""
        problem, imagers, own = self.problem, self.search.imagers, built.with_lamps(self.search)

        def worst(of: Callable[..., Any], *, most: bool, times: Sequence[float] | None = None) -> Array:
            factor = times or [1.0] * len(made)
            columns: list[Array] = [
                of(problem.scenes[s].nominal, *scene) * factor[s] for s, scene in enumerate(made)
            ]
            return np.asarray((np.max if most else np.min)(columns, axis=0))

        light_w = worst(lambda k, r, t, f: f.light_power_w, most=True)
        found: dict[str, Array] = {
            "power_w": worst(lambda k, r, t, f: self._power_w(f), most=True),
            "light_power_w": light_w,
            "cost": own.cost,
            "mass_kg": own.mass_kg,
            "gsd_mm": imagers.gsd_mm[built.imager],
            "snr_db": worst(lambda k, r, t, f: decibels(f.snr[:, k]), most=False),
            "contrast": worst(lambda k, r, t, f: f.contrast[:, k], most=False),
        }
        if self.information:
            found["information_bit_per_m2"] = worst(lambda k, r, t, f: f.information_bit_per_m2, most=False)
        if self.own:
            found |= self._more(worst, built)
        return found

    def _more(self, worst: Callable[..., Array], built: CodedHardware) -> dict[str, Array]:
        """What only own objectives ask for."""
        problem, imagers = self.problem, self.search.imagers
        level = worst(lambda k, r, t, f: t.level, most=True)
        views = [scene.view for scene in problem.scenes]
        kept = [1.0 - view.requirements.sidelap for view in views]
        per_hour = [k * view.vehicle.speed_m_s * S_PER_H for k, view in zip(kept, views, strict=True)]

        def swath(k: int, r: Any, t: Any, f: Any) -> Array:
            return np.asarray(r.view.covered_across_m[:, 1])

        def common(k: int, r: Any, t: Any, f: Any) -> Array:
            return np.asarray(r.view.common_across_m[:, 1])

        def strip(k: int, r: Any, t: Any, f: Any) -> Array:
            return narrowest_m(r.view)

        found = {
            "f_number": worst(lambda k, r, t, f: t.f_number, most=True),
            "exposure_ms": worst(lambda k, r, t, f: t.exposure_s * 1e3, most=True),
            "gain": worst(lambda k, r, t, f: t.gain, most=True),
            "level": level,
            "flux_lm": level * built.count * problem.lights.full_light[built.light],
            "light_count": built.count.astype(float),
            "frame_rate_hz": worst(lambda k, r, t, f: t.rate_hz, most=True),
            "swath_m": worst(swath, most=False),
            "common_swath_m": worst(common, most=False),
            "depth_error_mm": worst(lambda k, r, t, f: r.view.depth_error_m[:, 1] * 1e3, most=True),
            "line_spacing_m": worst(strip, most=False, times=kept),
            "area_m2_h": worst(strip, most=False, times=per_hour),
            "blur_px": worst(lambda k, r, t, f: f.blur_px.max(axis=1), most=True),
            "dof_near_m": worst(lambda k, r, t, f: f.dof_near_m, most=True),
            "dof_far_m": worst(lambda k, r, t, f: f.dof_far_m, most=False),
            "mean_level": worst(lambda k, r, t, f: f.mean_level[:, k], most=True),
            "saturation_fraction": worst(lambda k, r, t, f: f.saturation_fraction, most=True),
            "data_rate_mb_s": worst(lambda k, r, t, f: f.data_rate_mb_s, most=True)
            * problem.mission.vehicle.camera_count,
        }
        for kind, every in problem.parts.by_kind.items():
            column = built.light if kind == "light" else getattr(imagers, kind)[built.imager]
            found[kind] = column
            found[f"{kind}_id"] = np.array([part.id for part in every])[column]
        return found


def focus_maps(problem: Problem, scene_index: int, port: Array) -> FocusMap:
    """Focus maps of designs' ports in one scene, as columns."""
    ports, back = np.unique(port, return_inverse=True)
    maps = [focus_map(problem.scenes[scene_index], problem.shape(int(one), scene_index)) for one in ports]
    return FocusMap(*(np.array([getattr(one, f.name) for one in maps])[back] for f in fields(FocusMap)))


def missed_of(margins: Sequence[MarginRows], count: int) -> Array:
    """By how much margins of so many designs are missed; 0 where every requirement holds."""
    total = np.zeros(count)
    for margin in margins:
        lost = ~margin.satisfied
        if lost.any():
            size = np.maximum(np.abs(np.where(np.isfinite(margin.limit), margin.limit, 1.0)), 1e-12)
            by = np.nan_to_num(-margin.margin / size, nan=1.0, posinf=MOST_MISS)
            total += np.where(lost, np.clip(by, LEAST_MISS, MOST_MISS), 0.0)
    return total


def lacking_without_veils(search: Search, store: LightStore, built: CodedHardware) -> Array:
    """By how much designs miss what they need even with no veil and the least dark current."""
    rows = []
    for s in range(len(search.problem.scenes)):
        light = store.signal(s, built.imager, built.lighting)
        one = replace(scene_rows(search, s, built, SeenLight(light, None, None)), optimistic=True)
        rows.append(replace(one, dark_time_s=np.maximum(one.exposure_s(one.time_min_s), 0.0)))
    return shortfall(rows, search.motorised[built.imager])


def scene_rows(search: Search, s: int, built: CodedHardware, seen: SeenLight) -> SceneRows:
    """The settings' view of designs in one scene."""
    imagers = search.imagers
    rows = setting_rows(
        search.problem, s, camera=imagers.camera[built.imager], light=built.light, count=built.count,
        focused=imagers.scenes[s].focused.take(built.imager), image_light=seen.light, sun=seen.sun,
        sharp=seen.sharp,
    )  # fmt: skip
    if seen.even is not None:
        rows = replace(rows, time_max_s=np.where(seen.even, rows.time_max_s, -1.0))
    return rows


def decibels(snr: Array) -> Array:
    """A ratio in dB; no light at all is very little."""
    return np.asarray(ratio_to_db(np.maximum(snr, 1e-300)))

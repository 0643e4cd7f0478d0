"""Lower bounds on the objective of every (imager, lighting), before any field is integrated.

A bound takes the most signal that the lighting can give, the cheapest, lightest and most economical of
the lights that are able enough, and no quantisation: each term at its least, so the sum is a bound.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from uwopt.arrays import Array
from uwopt.deadline import NEVER, Deadline, spend
from uwopt.forward.detail import most_scattering_per_m, shows_detail, texture_gain
from uwopt.forward.part_columns import FLASH, PULSED
from uwopt.forward.problem import Problem
from uwopt.forward.views import CORNER_FIELD, RMS_FIELD
from uwopt.model import sensor
from uwopt.model.aberration import field_blur
from uwopt.objectives.objective import Objective, Terms
from uwopt.solvers.exact import balance
from uwopt.solvers.exact.any_lighting import AnyLighting
from uwopt.solvers.exact.imager_rules import limit
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.light_tables import FieldTables
from uwopt.solvers.exact.lightings import LampChoices, LampsOfKind, Lighting, quickest
from uwopt.solvers.exact.needs import ImagerNeeds, Needs, light_for_signal, light_times, most_held_e
from uwopt.solvers.exact.never_sharp import NeverSharp
from uwopt.solvers.exact.node_bounds import NODE_RULES, NodeBounds, bit_per_px_bound, first_missed
from uwopt.tolerances import ROUND
from uwopt.units import ratio_to_db


class Bounds:
    """Bounds of some imagers under all lightings, with the tables of their light: what a search chooses from."""

    def __init__(
        self, objective: Objective, tables: FieldTables, *, lights: Array | None = None, like: Bounds | None = None
    ):
        """Of the imagers of these tables; `lights` marks those that are searched, `like` lends its tables of them."""
        self.problem, self.objective, self.tables, self.imagers = tables.problem, objective, tables, tables.imagers
        self.searched = np.ones(len(self.problem.parts.lights), bool) if lights is None else lights
        self.limits = self.problem.mission.limits
        self.needs = ImagerNeeds(tables)
        self.light_tables: list[LampChoices]  # by lighting
        self.of_kinds: list[list[LampsOfKind]]
        if like is None:
            self.light_tables = [LampChoices.of(self.problem, one, self.searched) for one in tables.lightings]
            self.of_kinds = [[*LampsOfKind.each(self.problem, table)] for table in self.light_tables]
        else:
            self.light_tables, self.of_kinds = like.light_tables, like.of_kinds
        self._any_lighting = AnyLighting(self)
        self._never_sharp = NeverSharp(self.problem, self.imagers)

    @staticmethod
    def of(
        problem: Problem, objective: Objective, imagers: Imagers, *, lights: Array | None = None,
        widest_m: Sequence[float] | None = None,
    ) -> Bounds:  # fmt: skip
        """Of all imagers of a small catalogue, with tables of their own; `widest_m` as of `FieldTables`."""
        return Bounds(objective, FieldTables(problem, imagers, widest_m=widest_m), lights=lights)

    def others(self, imagers: Imagers) -> Bounds:
        """Of other imagers of the same catalogue; the tables of lights are the same."""
        return self.over(FieldTables(self.tables.problem, imagers, like=self.tables))

    def over(self, tables: FieldTables) -> Bounds:
        """By other tables in the same lights."""
        return Bounds(self.objective, tables, lights=self.searched, like=self)

    @cached_property
    def motorised(self) -> Array:
        """Whether each imager's lens is."""
        return self.problem.lenses.motorised[self.imagers.lens] if len(self.imagers) else np.empty(0, bool)

    @property
    def sizes(self) -> Array:
        """How many lamps in how many numbers each lighting has, (n_lightings,)."""
        return np.array([len(table.light) for table in self.light_tables], int)

    def of_nodes(self, k: int, rows: Array, pixel_e: Mapping[int, Array] | None = None) -> NodeBounds:
        """Bounds of these imagers under one lighting, worst scene; see `by_light`."""
        bounds = self.by_light(k, rows, pixel_e)
        left = np.flatnonzero(bounds.rule < 0)
        if len(left) == 0:
            return bounds
        for rule, never in self._never_sharp.under(self.tables.lightings[k].optics, rows[left]):
            lost = np.zeros(len(rows), bool)
            lost[left] = never
            bounds = bounds.but_for(rule, lost)
        return bounds

    def by_light(self, k: int, rows: Array, pixel_e: Mapping[int, Array] | None = None) -> NodeBounds:
        """The same by light, colours and prices alone, which are known of groups of imagers too.

        `pixel_e`: by scene the most electrons per lm s of the pixel that must reach the SNR, where that is known.
        """
        n = len(rows)
        bounds = NodeBounds.missing(n, "light")
        if n == 0:
            return bounds
        for lamps in self.of_kinds[k]:
            bounds = bounds.better_of(self._of_kind(self.tables.lightings[k], lamps, rows, pixel_e or {}))
        return bounds.but_for("max_white_balance", balance.by_water(self.tables, k, rows))

    def asks_of_images(self) -> bool:
        """Whether `of_pixels` may know more than `of_nodes`: pixels or colours count that lamps alone light."""
        return any(
            (scene.pixels is not None or scene.view.requirements.max_white_balance is not None)
            and not self.needs.is_sunlit(index)
            for index, scene in enumerate(self.problem.scenes)
        )

    def can_refine(self) -> bool:
        """Whether `refined` may know more than `of_nodes`."""
        return self.asks_of_images() or self.weighs_quality()

    def weighs_quality(self) -> bool:
        """Whether `joint_bound_of_imagers` may know more than `of_nodes`: quality counts beside its price."""
        weighed = self.objective.weight("snr_db") and self.objective.single is None
        return bool(weighed or self.objective.weight("information")) and not self.problem.paper

    def refined(self, k: int, rows: Array) -> NodeBounds:
        """Bounds of these imagers under one lighting by all that may know more than `of_nodes`."""
        bounds = self.of_pixels(k, rows) if self.asks_of_images() else self.of_nodes(k, rows)
        if not self.weighs_quality():
            return bounds
        from uwopt.solvers.exact.joint_bounds import joint_bound_of_imagers

        alive = np.flatnonzero(bounds.rule < 0)
        joint, rule = joint_bound_of_imagers(self, k, rows[alive]), bounds.rule.copy()
        rule[alive[np.isinf(joint)]] = NODE_RULES.index("light")
        value = bounds.value.copy()
        value[alive] = np.maximum(value[alive], joint)
        return replace(bounds, value=value, rule=rule)

    def of_pixels(self, k: int, rows: Array) -> NodeBounds:
        """Bounds of these imagers under one lighting by the pixel that decides whether the SNR holds, and by colours.

        That pixel has at most the light that `likely_pixel` finds, whatever the number of lamps, and no less is needed
        of it at the farthest altitude than at any. No bound is lower than that of the mean alone.
        """
        off = balance.by_image(self.tables, k, rows)
        bounds = NodeBounds.missing(len(rows), "max_white_balance")
        return bounds if off.all() else bounds.put(np.flatnonzero(~off), self._of_pixels(k, rows[~off]))

    def _of_pixels(self, k: int, rows: Array) -> NodeBounds:
        """The same of imagers whose colours are balanced, or may be."""
        lighting, (low, high) = self.tables.lightings[k], self.problem.count_range
        pixel_e = {}
        for index, scene in enumerate(self.problem.scenes):
            if scene.pixels is not None and not self.needs.is_sunlit(index):
                by_count = [
                    self.tables.likely_pixel(index, lighting, rows, count=count, pixels=scene.pixels)
                    for count in range(max(low, 1), max(high, 1) + 1)
                ]
                pixel_e[index] = np.max(by_count, axis=0)
        return self.of_nodes(k, rows, pixel_e)

    def _of_kind(
        self, lighting: Lighting, lamps: LampsOfKind, rows: Array, pixel_e: Mapping[int, Array]
    ) -> NodeBounds:
        """Bounds from the lights of one kind: what capable lights cost, weigh and draw at least."""
        imagers, limits, n = self.imagers, self.limits, len(rows)
        spend("bounds", n)
        power, mean_power, capacity_needed, rate_hz = (np.zeros(n) for _ in range(4))
        snr_db, information, most_drawn = (np.full(n, np.inf) for _ in range(3))
        power_left = limit(limits.power_w) * ROUND - imagers.camera_power_w[rows]
        for index in range(len(imagers.scenes)):
            need = self.needs.of(index, rows)
            light_time, wanted, most = self.light_needed(index, lighting, need, lamps.kind, rows, pixel_e.get(index))
            light_time, wanted = self._within_pulse(lamps.lamps.light, lamps.kind, need, light_time, wanted)
            capacity_needed, rate_hz = np.maximum(capacity_needed, wanted), np.maximum(rate_hz, need.rate_hz)
            with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
                used = lamps.used(need.rate_hz, need.longest_s, light_time, wanted)
                most_drawn = np.minimum(most_drawn, np.where(used > 0, power_left / used * ROUND, np.inf))
            scene_power = self._least_drawn(lamps, need, used, wanted, rows)
            power = np.maximum(power, scene_power)
            mean_power += self.problem.duration.shares[index] * np.where(np.isfinite(wanted), scene_power, 0.0)
            if self.objective.weight("snr_db") or self.objective.weight("information"):
                electrons = lamps.capacity[-1] * most + need.sun_e[:, -1]
                reached = self._snr_bound(index, electrons, rows, self.needs.most_contrast(index, [lighting], rows))
                snr_db = np.minimum(snr_db, reached)
                if self.objective.weight("information"):
                    information = np.minimum(information, self._information_bound(index, reached, rows))
        place = lamps.from_capacity(capacity_needed)
        reachable = lamps.keep_up(place, rate_hz)
        cost, limit_cost, mass = (
            np.where(reachable, lamps.least[name][place], np.inf) for name in ("cost", "limit_cost", "mass_kg")
        )
        if limits.power_w is not None:
            cost = lamps.least_within("cost", "power_per_light", place, most_drawn)
        contrast, clear = self._contrast_bound(lighting, rows)
        bounds = NodeBounds(
            np.zeros(n), imagers.camera_power_w[rows] + power, imagers.camera_power_w[rows] + mean_power,
            imagers.cost[rows] + cost, imagers.mass_kg[rows] + mass, snr_db, np.zeros(n, int), information, contrast,
        )  # fmt: skip
        return self._judged(bounds, reachable & clear, imagers.limit_cost[rows] + limit_cost, rows)

    def _least_drawn(self, lamps: LampsOfKind, need: Needs, used: Array, wanted: Array, rows: Array) -> Array:
        """Least mean power [W] of lamps that give the wanted capacity within the budget; inf where none does."""
        place = lamps.from_capacity(wanted)
        if self.limits.cost is None:
            per_light = lamps.least["power_per_light"][place]
        else:
            left = limit(self.limits.cost) * ROUND - self.imagers.limit_cost[rows]
            per_light = lamps.least_within("power_per_light", "limit_cost", place, left)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            drawn = np.where(used > 0, used * per_light, 0.0)
            if lamps.kind != PULSED:
                on = need.rate_hz if lamps.kind == FLASH else lamps.on_share(need.rate_hz, 0.0)
                drawn = np.maximum(drawn, np.where(used > 0, lamps.dimmest * on, 0.0))
        return np.where(np.isfinite(wanted), drawn, np.inf)

    def _contrast_bound(self, lighting: Lighting, rows: Array) -> tuple[Array, Array]:
        """Most contrast that the forward veil alone leaves, worst scene, and whether it is enough in all.

        1 where the sun shines too: its light may have less veil.
        """
        wanted = [scene.view.requirements.min_contrast or 0.0 for scene in self.problem.scenes]
        best, enough = np.ones(len(rows)), np.ones(len(rows), bool)
        if not self.problem.effects.forward_veil or not (self.objective.weight("contrast") or any(wanted)):
            return best, enough
        for index, least in enumerate(wanted):
            best = np.minimum(best, self.needs.most_contrast(index, [lighting], rows))
            if least:
                enough &= self.needs.most_contrast(index, [lighting], rows, altitude=-1) >= least
        return best, enough

    def light_needed(
        self, scene_index: int, lighting: Lighting, need: Needs, kind: int, rows: Array,
        pixel_e: Array | None = None,
    ) -> tuple[Array, Array, Array]:
        """Least light * time that the requirements need, the lamp capacity it takes, and the most
        electrons a unit of capacity can give at the nominal altitude."""
        signal = self._signal_bound(scene_index, lighting, rows)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            light_x = light_for_signal(need, signal)
            if pixel_e is not None:
                light_x = np.maximum(light_x, np.where(need.by_pixel_e > 0, need.by_pixel_e / pixel_e, 0.0))
            if need.by_red_e is not None:
                far = len(self.problem.scenes[scene_index].range_m) - 1
                red = self.tables.bound(scene_index, lighting, far, rows, channel="red")
                light_x = np.maximum(light_x, need.by_red_e / red)
            light_time, wanted = light_times(need, light_x, kind)
        return light_time, wanted, signal[:, -1] * (1.0 if kind == FLASH else need.longest_s) / need.square

    def _within_pulse(
        self, lights: Array, kind: int, need: Needs, light_time: Array, wanted: Array
    ) -> tuple[Array, Array]:
        """Light * time and capacity that are needed when a pulse is no longer than the longest of these lights',
        and the shutter lets in no more of a flash than of the shortest."""
        lamp = self.problem.lights.take(lights)
        with np.errstate(divide="ignore", invalid="ignore"):
            if kind == FLASH:
                share = np.max([one.most_share(need.longest_s) for one in quickest(lamp.flash)], axis=0)
                light_time = np.where(light_time > 0, light_time / share, light_time)
                return light_time, np.where(need.longest_s > 0, light_time, np.inf)
            if kind == PULSED:
                longest = np.minimum(lamp.max_pulse_s.max(), lamp.max_duty.max() / need.rate_hz)
                longest = np.minimum(need.longest_s, longest)
                return light_time, np.where(longest > 0, light_time / longest, np.inf)
        return light_time, wanted

    def capacity_needed(self, need: Needs, signal_e: Array, kind: int, lights: Array) -> Array:
        """The capacity of lamps of one kind without which there is too little light, (n,).

        signal_e : electrons per lm s at most, (n, 2); lights : of which none is abler in time
        """
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            light_time, wanted = light_times(need, light_for_signal(need, signal_e), kind)
        return self._within_pulse(lights, kind, need, light_time, wanted)[1]

    def leaves_dark(self, rows: Array, deadline: Deadline = NEVER) -> Array:
        """Which of these imagers `of_nodes` discards by the rule of light under every lighting, as far as is soon
        known, (n,). Raises OutOfTimeError."""
        return self._any_lighting.leaves_dark(rows, deadline)

    def _judged(self, bounds: NodeBounds, reachable: Array, limit_cost: Array, rows: Array) -> NodeBounds:
        """Objective of the bounds, infinite where a limit cannot be met, with the rule that says so."""
        limits = self.limits
        rule = first_missed([
            ("light", reachable),
            ("cost", limit_cost <= limit(limits.cost) * ROUND),
            ("mass_kg", bounds.mass <= limit(limits.mass_kg) * ROUND),
            ("power_w", bounds.power <= limit(limits.power_w) * ROUND),
            ("energy_wh", bounds.mean_power_w <= self.problem.duration.mean_power_limit_w * ROUND),
        ])  # fmt: skip
        terms = bounds.terms(slice(None), self.imagers.gsd_mm[rows])
        with np.errstate(invalid="ignore"):
            value = self.objective.cost_to_minimise(terms)
        over = (rule < 0) & ~np.isfinite(value)  # no light keeps within both budgets
        rule = np.where(over, NODE_RULES.index("power_w"), rule)
        value = np.where(rule >= 0, np.inf, value)
        return replace(bounds, value=value, rule=rule)

    def _signal_bound(self, scene_index: int, lighting: Lighting, rows: Array) -> Array:
        """Upper bounds of electrons per lm s at the farthest and the nominal altitude, (n, 2)."""
        scene = self.problem.scenes[scene_index]
        far = self.tables.bound(scene_index, lighting, len(scene.range_m) - 1, rows)
        if scene.nominal == len(scene.range_m) - 1:
            return np.stack([far, far], axis=1)
        return np.stack([far, self.tables.bound(scene_index, lighting, scene.nominal, rows)], axis=1)

    def without_light(self, rows: Array) -> Terms:
        """What these imagers are at best, whatever lights them."""
        of = self.imagers
        power, cost, mass, gsd_mm = (each[rows] for each in (of.camera_power_w, of.cost, of.mass_kg, of.gsd_mm))
        return Terms.at_best(power, cost, mass, gsd_mm, self.information_ceiling(rows))

    def information_ceiling(self, rows: Array) -> Array:
        """Information [bit/m2] that no light lets these imagers exceed: at the most electrons the sensor takes."""
        best = np.full(len(rows), np.inf)
        if self.objective.weight("information"):
            for index in range(len(self.imagers.scenes)):
                reached = self.snr_ceiling(index, self.tables.lightings, rows)
                best = np.minimum(best, self._information_bound(index, reached, rows))
        return best

    def snr_ceiling(self, scene_index: int, lightings: Sequence[Lighting], rows: Array) -> Array:
        """SNR in dB that no light of these lightings exceeds: at the most electrons the sensor takes."""
        clearest = self.needs.most_contrast(scene_index, lightings, rows)
        return self._snr_bound(scene_index, np.full(len(rows), np.inf), rows, clearest)

    def _information_bound(self, scene_index: int, snr_db: Array, rows: Array) -> Array:
        """Information [bit/m2] of a sharp pixel behind the rated lens, closed far, at an SNR: nothing else blurs.

        Light scattered nearly forward adds as much as in the colour that is scattered most and for the largest pixels.
        """
        cameras = self.problem.cameras.take(self.imagers.camera[rows])
        rated = self.problem.lenses.rated_pitch_m[self.imagers.lens[rows]] / cameras.pixel_pitch_m
        rated = rated * field_blur(float(RMS_FIELD) / CORNER_FIELD)
        seen, scene = self.imagers.scenes[scene_index], self.problem.scenes[scene_index]
        pixels = cameras.resolution_x_px * cameras.resolution_y_px
        if shows_detail(self.problem.contractions[scene_index], forward_veil=self.problem.effects.forward_veil):
            snr_db = snr_db + ratio_to_db(texture_gain(
                scene, area_m2=seen.most_area_m2[rows, 1], pixels=pixels, scattering_per_m=most_scattering_per_m(scene)
            ))  # fmt: skip
        return bit_per_px_bound(snr_db, rated) * pixels / seen.view.area_m2[rows, 1]

    def _snr_bound(self, scene_index: int, electrons_e: Array, rows: Array, contrast: Array) -> Array:
        """Upper bound of the SNR in dB from the electrons that light and sensor allow at most.

        Of what a pixel holds no more than the contrast's share forms the image, and the rest adds its noise.
        """
        cameras = self.problem.cameras.take(self.imagers.camera[rows])
        most = np.minimum(electrons_e, contrast * most_held_e(cameras, self.problem.scenes[scene_index]))
        with np.errstate(invalid="ignore"):
            snr = sensor.snr(
                most, veil_e=most * (1.0 / contrast - 1.0), read_noise_e=cameras.read_noise_e, gain_dn_per_e=np.inf,
                prnu_frac=cameras.prnu_frac,
            )  # fmt: skip
        return np.asarray(ratio_to_db(np.fmax(snr, 1e-300)))  # a mean level below black has no number

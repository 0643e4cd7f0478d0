"""The exact search: best design of a catalogue with a proof that nothing better is in it.

Designs are imagers under a lighting (light optics at a mount) with a number of lamps of one light.
Every (imager, lighting) is a unit with a lower bound on the objective; units are taken best first,
their signal is computed exactly, their lights and counts are solved in closed form, and the search
stops when no bound beats the best. Each combination is counted once, by the first rule that discards
it, so that the account adds up.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.hardware import CONTINUOUS, FLASH, PULSED
from uwopt.model import sensor
from uwopt.objectives.objective import Objective, Terms
from uwopt.problem import Problem
from uwopt.rows import SceneRows
from uwopt.solvers import settings as closed_form
from uwopt.solvers.fields import FieldTables, Lighting
from uwopt.solvers.imagers import IMAGER_RULES, Imagers, enumerate_imagers, limit

Array = NDArray[Any]
TIE = 1e-9
ROUND = 1.0 + 1e-9
FIRST_BATCH, LARGEST_BATCH = 32, 2048
FIRST_CHUNK, LARGEST_CHUNK = 4096, 65536
SAMPLES_A_TIME, MOST_SAMPLES = 64, 1024
MOST_ROWS_AT_ONCE = 60_000
DARK_ROUNDS = 5
TOO_FEW_TO_BOUND = 8  # units: evaluating them is cheaper
UNIT_RULES = ("light", "cost", "mass_kg", "power_w", "bound")
RULES = (*IMAGER_RULES, *(rule for rule in UNIT_RULES if rule not in IMAGER_RULES))


@dataclass(frozen=True)
class Found:
    """One feasible design with its settings of least power, by indices into the problem's tables."""

    imager: int
    camera: int
    lens: int
    port: int
    landscape: bool
    light: int
    count: int
    lighting: Lighting
    minimised: float
    power_w: float
    cost: float
    mass_kg: float
    snr_db: float
    settings: list[dict[str, float]]  # by scene
    pulse_s: float

    def tie_key(self, ids: tuple[str, ...]) -> tuple[Any, ...]:
        """What breaks ties: power, cost, mass, lamps, pulse, ids."""
        return (self.power_w, self.cost, self.mass_kg, self.count, self.pulse_s, ids)


@dataclass
class Account:
    """Where every combination went: evaluated, or discarded by the first rule that does."""

    total: int = 0
    evaluated: int = 0
    discarded: dict[str, int] = field(default_factory=lambda: dict.fromkeys(RULES, 0))

    def adds_up(self) -> bool:
        """Whether every combination is accounted for once."""
        return self.total == self.evaluated + sum(self.discarded.values())


@dataclass
class Outcome:
    """What a search found and how far its proof reaches."""

    best: list[Found]
    account: Account
    lower_bound: float
    complete: bool
    imagers: Imagers
    tables: FieldTables
    timing_s: dict[str, float]
    interrupted: bool = False


@dataclass(frozen=True)
class LightTable:
    """All (light, count) of one lighting, as columns."""

    light: Array
    count: Array
    cost: Array
    limit_cost: Array
    mass_kg: Array
    effective: Array  # count * full light * output factor: lm, or lm s a pulse
    power_per_light: Array  # electrical per unit of effective light
    kind: Array


def search(
    problem: Problem,
    objective: Objective,
    *,
    top: int = 5,
    deadline_s: float | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Outcome:
    """The best designs and the certificate's numbers; see the module's docstring."""
    return Search(problem, objective, top=top, deadline_s=deadline_s, progress=progress).run()


class Search:
    """State of one search."""

    def __init__(
        self, problem: Problem, objective: Objective, *, top: int, deadline_s: float | None,
        progress: Callable[[float, str], None] | None, ceiling: float = np.inf,
    ):  # fmt: skip
        self.ceiling = ceiling  # designs that are no better than this are not wanted
        self.problem, self.objective, self.top = problem, objective, max(1, top)
        self.deadline = None if deadline_s is None else time.perf_counter() + deadline_s
        self.progress = progress or (lambda share, what: None)
        self.best: list[Found] = []
        self.account = Account()
        self.limits = problem.mission.limits
        self._needs_of: tuple[Array, dict[int, Needs]] | None = None
        self.bounds_s = 0.0
        self.interrupted = False
        self._samples: dict[str, list[tuple[int, int]]] = {}  # rule -> (imager, lighting)

    # ------------------------------------------------------------ run

    def run(self) -> Outcome:
        """Enumerate, bound, evaluate best first."""
        start = time.perf_counter()
        self.progress(0.0, "imagers")
        imagers = self.prepare()
        self._start_account(imagers)
        after_imagers = time.perf_counter()
        lower, complete = self._by_floor()
        self.progress(1.0, "done")
        timing = {
            "imagers": after_imagers - start,
            "bounds": self.bounds_s,
            "evaluation": time.perf_counter() - after_imagers - self.bounds_s,
        }
        return Outcome(
            self.best, self.account, lower, complete, imagers, self.tables, timing, self.interrupted
        )

    def prepare(self) -> Imagers:
        """Enumerate imagers and tabulate lights: all that evaluation needs."""
        imagers = self.imagers = enumerate_imagers(self.problem, cameras=self._hopeful_cameras())
        self.tables = FieldTables(self.problem, imagers)
        self.light_tables = [self._light_table(lighting) for lighting in self.tables.lightings]
        self.motorised = self.problem.lenses.motorised[imagers.lens] if len(imagers) else np.empty(0, bool)
        return imagers

    def _hopeful_cameras(self) -> Array:
        """Cameras that are not beyond the ceiling by themselves."""
        rows, count = self.problem.cameras, self.problem.mission.vehicle.camera_count
        extra_cost, extra_mass, extra_power = self.problem.extras
        floor = self.objective.cost_to_minimise(
            Terms(
                count * rows.power_w + extra_power, count * rows.price + extra_cost, count * rows.mass_kg + extra_mass,
                np.full(len(rows.price), self._snr_ceiling()), np.zeros(len(rows.price)),
            )
        )  # fmt: skip
        return np.asarray(floor <= self.ceiling)

    def _start_account(self, imagers: Imagers) -> None:
        """Every combination of the parts in the search, and what the imagers' rules discard."""
        problem = self.problem
        low, high = problem.count_range
        illuminators = len(problem.parts.lights) * (high - low + 1) * len(problem.mounts)
        for rule, count in imagers.discarded.items():
            self.account.discarded[rule] += count * illuminators
        self.account.total = (len(imagers) + sum(imagers.discarded.values())) * illuminators

    def _light_table(self, lighting: Lighting) -> LightTable:
        """The lights of one lighting in every number."""
        problem = self.problem
        mine = np.nonzero(problem.lights.optics_index == lighting.optics)[0]
        low, high = problem.count_range
        light = np.repeat(mine, high - low + 1)
        count = np.tile(np.arange(low, high + 1), len(mine))
        rows = problem.lights.take(light)
        to_buy = problem.lamps_to_buy(light, count)
        effective = count * rows.full_light * rows.output_factor
        with np.errstate(divide="ignore", invalid="ignore"):
            drawn = np.where(rows.kind == FLASH, rows.pulse_energy_j, rows.full_power_w)
            per_light = drawn / (rows.full_light * rows.output_factor)
        return LightTable(
            light,
            count,
            to_buy * rows.price,
            to_buy * rows.limit_price,
            rows.mass_kg * count,
            effective,
            per_light,
            rows.kind,
        )

    # ------------------------------------------------------------ bounds

    def _unit_bounds(self, k: int, rows: Array) -> UnitBounds:
        """Bounds of these imagers under one lighting, worst scene."""
        lighting, table = self.tables.lightings[k], self.light_tables[k]
        n = len(rows)
        bounds = UnitBounds.empty(n)
        if n == 0 or len(table.light) == 0:
            bounds.rule[:] = UNIT_RULES.index("light")
            return bounds
        for kind in np.unique(table.kind):
            own = table.kind == kind
            bounds = bounds.better_of(self._kind_bounds(lighting, table, own, int(kind), rows))
        return bounds

    def _kind_bounds(
        self, lighting: Lighting, table: LightTable, own: Array, kind: int, rows: Array
    ) -> UnitBounds:
        """Bounds from the lights of one kind: what capable lights cost, weigh and draw at least."""
        imagers = self.imagers
        n = len(rows)
        power, capacity_needed = np.zeros(n), np.zeros(n)
        snr_db = np.full(n, np.inf)
        order = np.argsort(table.effective[own])
        capacity = table.effective[own][order]
        least_drawn = suffix_min(table.power_per_light[own][order])
        for index in range(len(imagers.scenes)):
            need = self._needs(index, rows)
            light_time, wanted, most = self._light_needed(index, lighting, need, kind, rows)
            capacity_needed = np.maximum(capacity_needed, wanted)
            at = np.searchsorted(capacity, wanted * (1 - 1e-12))
            drawn = np.where(at < len(capacity), least_drawn[np.minimum(at, len(capacity) - 1)], np.inf)
            with np.errstate(invalid="ignore"):
                used = wanted if kind == CONTINUOUS else light_time * need.rate_hz
                scene_power = np.where(used > 0, used * drawn, 0.0)
            power = np.maximum(power, np.where(np.isfinite(wanted), scene_power, np.inf))
            if self.objective.weight("snr_db"):
                snr_db = np.minimum(snr_db, self._snr_bound(index, capacity[-1] * most, rows))
        at = np.searchsorted(capacity, capacity_needed * (1 - 1e-12))
        reachable = at < len(capacity)
        pick = np.minimum(at, len(capacity) - 1)

        def least(values: Array) -> Array:
            return np.where(reachable, suffix_min(values[own][order])[pick], np.inf)

        bounds = UnitBounds(
            np.zeros(n), imagers.camera_power_w[rows] + power, imagers.cost[rows] + least(table.cost),
            imagers.mass_kg[rows] + least(table.mass_kg), snr_db, np.zeros(n, int),
        )  # fmt: skip
        return self._judged(bounds, reachable, imagers.limit_cost[rows] + least(table.limit_cost), rows)

    def _light_needed(
        self, scene_index: int, lighting: Lighting, need: Needs, kind: int, rows: Array
    ) -> tuple[Array, Array, Array]:
        """Least light * time that the requirements need, the lamp capacity it takes, and the most
        electrons a unit of capacity can give at the nominal altitude."""
        signal = self._signal_bound(scene_index, lighting, rows)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            light_x = np.where(need.by_snr_e > 0, need.by_snr_e / signal.min(axis=1), 0.0)
            light_x = np.maximum(light_x, np.where(need.by_gain_e > 0, need.by_gain_e / signal[:, -1], 0.0))
            light_time = np.where(light_x > 0, light_x * need.square, 0.0)
            wanted = light_time if kind == FLASH else light_time / need.longest_s
        wanted = np.where(need.longest_s > 0, wanted, np.inf)
        return light_time, wanted, signal[:, -1] * (1.0 if kind == FLASH else need.longest_s) / need.square

    def _needs(self, scene_index: int, rows: Array) -> Needs:
        """What these imagers need in one scene, the same under every lighting."""
        if self._needs_of is None or self._needs_of[0] is not rows:
            self._needs_of = (rows, {})
        known = self._needs_of[1]
        if scene_index not in known:
            focused = self.imagers.scenes[scene_index].focused.take(rows)
            by_snr, by_gain = self._electrons_needed(scene_index, rows)
            known[scene_index] = Needs(
                by_snr, by_gain, np.square(focused.n_low * focused.working_factor),
                self._longest_time_s(focused, rows), focused.rate_hz,
            )  # fmt: skip
        return known[scene_index]

    def _judged(self, bounds: UnitBounds, reachable: Array, limit_cost: Array, rows: Array) -> UnitBounds:
        """Objective of the bounds, infinite where a limit cannot be met, with the rule that says so."""
        limits, rule = self.limits, np.full(len(reachable), -1)
        checks = (
            ("light", reachable),
            ("cost", limit_cost <= limit(limits.cost) * ROUND),
            ("mass_kg", bounds.mass <= limit(limits.mass_kg) * ROUND),
            ("power_w", bounds.power <= limit(limits.power_w) * ROUND),
        )
        for name, passes in checks:
            rule = np.where((rule < 0) & ~passes, UNIT_RULES.index(name), rule)
        terms = Terms(bounds.power, bounds.cost, bounds.mass, bounds.snr_db, self.imagers.gsd_mm[rows])
        with np.errstate(invalid="ignore"):
            value = self.objective.cost_to_minimise(terms)
        value = np.where(rule >= 0, np.inf, value)
        return UnitBounds(value, bounds.power, bounds.cost, bounds.mass, bounds.snr_db, rule)

    def _signal_bound(self, scene_index: int, lighting: Lighting, rows: Array) -> Array:
        """Upper bounds of electrons per lm s at the farthest and the nominal altitude, (n, 2)."""
        scene = self.problem.scenes[scene_index]
        far = self.tables.bound(scene_index, lighting, len(scene.range_m) - 1, rows)
        if scene.nominal == len(scene.range_m) - 1:
            return np.stack([far, far], axis=1)
        return np.stack([far, self.tables.bound(scene_index, lighting, scene.nominal, rows)], axis=1)

    def _electrons_needed(self, scene_index: int, rows: Array) -> tuple[Array, Array]:
        """Fewest electrons for the SNR, wanted at every altitude, and for the mean level at the highest
        gain, wanted at the nominal one; quantisation and dark current are left out."""
        cameras = self.problem.cameras.take(self.imagers.camera[rows])
        needs = self.problem.scenes[scene_index].view.requirements
        need = np.zeros(len(rows))
        if needs.min_snr:
            need = sensor.electrons_for_snr(
                needs.min_snr, noise_variance_e2=np.square(cameras.read_noise_e), prnu_frac=cameras.prnu_frac
            )
        if needs.mean_level is None:
            return np.asarray(need), np.zeros(len(rows))
        wanted_dn = needs.mean_level * (2.0**cameras.bits - 1.0) - cameras.black_level_dn
        by_gain = wanted_dn / (cameras.gain_dn_per_e * cameras.max_gain)
        longest = np.minimum(self.limits.max_exposure_ms * 1e-3, cameras.max_exposure_s)
        return np.asarray(need), np.asarray(by_gain - cameras.dark_current_e_s * longest)

    def _longest_time_s(self, focused: Any, rows: Array) -> Array:
        """An upper bound of the light-collecting time of any light."""
        cameras = self.problem.cameras.take(self.imagers.camera[rows])
        with np.errstate(divide="ignore"):
            exposure = np.minimum(
                np.minimum(cameras.max_exposure_s, self.limits.max_exposure_ms * 1e-3), 1.0 / focused.rate_hz
            )
        return np.asarray(np.minimum(exposure + cameras.exposure_offset_s, focused.blur_time_s))

    def _snr_bound(self, scene_index: int, electrons_e: Array, rows: Array) -> Array:
        """Upper bound of the SNR in dB from the electrons that light and sensor allow at most."""
        cameras = self.problem.cameras.take(self.imagers.camera[rows])
        needs = self.problem.scenes[scene_index].view.requirements
        full_scale = 2.0**cameras.bits - 1.0
        top = cameras.saturation_e / needs.highlight_ratio
        level = (
            full_scale / needs.highlight_ratio if needs.mean_level is None else needs.mean_level * full_scale
        )
        most = np.minimum(
            electrons_e, np.minimum(top, (level - cameras.black_level_dn) / cameras.gain_dn_per_e)
        )
        with np.errstate(invalid="ignore"):
            snr = sensor.snr(
                most, read_noise_e=cameras.read_noise_e, gain_dn_per_e=np.inf, prnu_frac=cameras.prnu_frac
            )
        return np.asarray(sensor.to_db(np.maximum(snr, 1e-300)))

    # ------------------------------------------------------------ best first

    def _by_floor(self) -> tuple[float, bool]:
        """Take imagers in order of what they cost without any light, until none can beat the best."""
        imagers = self.imagers
        ceiling = np.full(len(imagers), self._snr_ceiling())
        floor = self.objective.cost_to_minimise(
            Terms(imagers.camera_power_w, imagers.cost, imagers.mass_kg, ceiling, imagers.gsd_mm)
        )
        order = np.argsort(floor, kind="stable")
        every = int(sum(len(t.light) for t in self.light_tables))
        position, chunk = 0, FIRST_CHUNK
        while position < len(order):
            rows = order[position : position + chunk]
            useful = rows[floor[rows] <= self._threshold()]
            self.account.discarded["bound"] += every * (len(rows) - len(useful))
            if len(useful):
                finished = self._best_first(useful)
                if finished is not None:
                    return self._cut_short(finished, every, floor, order[position + len(rows) :])
            position += len(rows)
            chunk = min(2 * chunk, LARGEST_CHUNK)
            self.progress(0.1 + 0.9 * position / len(order), "search")
        return (self.best[0].minimised if self.best else self.ceiling), True

    def _cut_short(self, lowest: float, every: int, floor: Array, rest: Array) -> tuple[float, bool]:
        """Account for what was not reached when time ran out, and the bound that is left."""
        reached = self.account.discarded.get("not_reached", 0)
        self.account.discarded["not_reached"] = reached + every * len(rest)
        lowest = min(lowest, float(floor[rest].min(initial=np.inf)))
        return min(lowest, self.best[0].minimised if self.best else np.inf), False

    def _best_first(self, rows: Array) -> float | None:
        """Take the units of these imagers in order of their bound until none can beat the best.

        Returns the lowest bound not looked at when time ran out, else None.
        """
        start = time.perf_counter()
        few = len(rows) * len(self.tables.lightings) <= TOO_FEW_TO_BOUND
        bounds = [
            UnitBounds.none(len(rows)) if few else self._unit_bounds(k, rows)
            for k in range(len(self.tables.lightings))
        ]
        self.bounds_s += time.perf_counter() - start
        n = len(rows)
        value = np.concatenate([b.value for b in bounds])
        power = np.concatenate([b.power for b in bounds])
        rule = np.concatenate([b.rule for b in bounds])
        size = np.repeat([len(t.light) for t in self.light_tables], n)
        for index, name in enumerate(UNIT_RULES):
            failed = rule == index
            self.account.discarded[name] += int(size[failed].sum())
            self._sample(name, np.nonzero(failed)[0], rows)
        alive = np.nonzero(np.isfinite(value) & (rule < 0))[0]
        order = alive[np.lexsort((power[alive], value[alive]))]
        position, batch = 0, FIRST_BATCH
        while position < len(order):
            threshold = self._threshold()
            ahead = order[position : position + batch]
            ahead = ahead[value[ahead] <= threshold]
            if len(ahead) == 0:
                break
            if self.interrupted or (self.deadline is not None and time.perf_counter() > self.deadline):
                rest = order[position:]
                self.account.discarded["not_reached"] = int(size[rest].sum())
                return float(value[rest].min())
            tied = np.isfinite(threshold) & (value[ahead] >= threshold - 2 * TIE * abs(threshold))
            useful = ahead[~(tied & (power[ahead] > self._power_threshold()))]
            self.account.discarded["bound"] += int(size[ahead].sum() - size[useful].sum())
            try:
                self._evaluate_units(useful // n, rows[useful % n])
            except KeyboardInterrupt:  # keep what was found; the units at hand count as not reached
                self.interrupted = True
                continue
            position += len(ahead)
            batch = min(2 * batch, LARGEST_BATCH)
        self.account.discarded["bound"] += int(size[order[position:]].sum())
        self._sample("bound", order[position:], rows)
        return None

    def _sample(self, rule: str, units: Array, rows: Array) -> None:
        """Remember some of the units that a rule discards, evenly spread, for an audit."""
        kept = self._samples.setdefault(rule, [])
        if len(units) and len(kept) < MOST_SAMPLES:
            step = max(1, len(units) // SAMPLES_A_TIME)
            n = len(rows)
            kept += [(int(rows[u % n]), int(u // n)) for u in units[::step][: 2 * SAMPLES_A_TIME]]

    def discarded_samples(
        self, count: int, rng: np.random.Generator
    ) -> dict[str, list[tuple[int, int, int, bool, int | None]]]:
        """Combinations that each rule discarded, as (camera, lens, port, landscape, light or None for any)."""
        imagers = self.imagers
        pools: dict[str, list[tuple[int, int, int, bool, int | None]]] = {
            rule: [(c, le, p, o, None) for c, le, p, o in samples]
            for rule, samples in imagers.samples.items()
        }
        for rule, units in self._samples.items():
            pool = pools.setdefault(rule, [])
            for imager, k in units[: max(count, 1)]:
                lights = self.light_tables[k].light
                light = int(lights[int(rng.integers(len(lights)))])
                pool.append((int(imagers.camera[imager]), int(imagers.lens[imager]), int(imagers.port[imager]),
                             bool(imagers.landscape[imager]), light))  # fmt: skip
        return pools

    def _threshold(self) -> float:
        """The objective that a unit must not exceed to matter: that of the last runner-up, ties included."""
        if len(self.best) < self.top:
            return self.ceiling
        worst = self.best[-1].minimised
        return min(worst + TIE * abs(worst), self.ceiling)

    def _power_threshold(self) -> float:
        """Among ties, the power that a unit must not exceed to matter."""
        if len(self.best) < self.top:
            return np.inf
        worst = self.best[-1].minimised
        return max(f.power_w for f in self.best if abs(f.minimised - worst) <= 2 * TIE * abs(worst)) * ROUND

    def _evaluate_units(self, lighting_index: Array, imager: Array) -> None:
        """Exact signal of these units, then all their lights and counts."""
        for k in np.unique(lighting_index):
            rows = imager[lighting_index == k]
            lighting, table = self.tables.lightings[k], self.light_tables[k]
            signals = [self.tables.exact(s, lighting, rows) for s in range(len(self.problem.scenes))]
            step = max(1, MOST_ROWS_AT_ONCE // len(table.light))
            for start in range(0, len(rows), step):
                part = slice(start, start + step)
                self._evaluate_pairs(rows[part], [s[part] for s in signals], lighting, table)

    def _evaluate_pairs(
        self, imager: Array, signals: list[Array], lighting: Lighting, table: LightTable
    ) -> None:
        """Every (imager, light, count): drop what misses a limit or cannot win, solve the rest."""
        n_light = len(table.light)
        unit = np.repeat(np.arange(len(imager)), n_light)
        item = np.tile(np.arange(n_light), len(imager))
        imagers, limits = self.imagers, self.limits
        cost = imagers.cost[imager[unit]] + table.cost[item]
        mass = imagers.mass_kg[imager[unit]] + table.mass_kg[item]
        rule = np.full(len(unit), -1)
        limit_cost = imagers.limit_cost[imager[unit]] + table.limit_cost[item]
        rule = np.where(limit_cost > limit(limits.cost) * ROUND, UNIT_RULES.index("cost"), rule)
        rule = np.where(
            (rule < 0) & (mass > limit(limits.mass_kg) * ROUND), UNIT_RULES.index("mass_kg"), rule
        )
        floor = self.objective.cost_to_minimise(
            Terms(
                imagers.camera_power_w[imager[unit]], cost, mass, np.full(len(unit), self._snr_ceiling()),
                imagers.gsd_mm[imager[unit]],
            )
        )  # fmt: skip
        rule = np.where((rule < 0) & (floor > self._threshold()), UNIT_RULES.index("bound"), rule)
        for index, name in enumerate(UNIT_RULES):
            self.account.discarded[name] += int((rule == index).sum())
        keep = np.nonzero(rule < 0)[0]
        self.account.evaluated += len(keep)
        if len(keep):
            self._solve_pairs(
                imager[unit[keep]], unit[keep], item[keep], signals, lighting, table, cost[keep], mass[keep]
            )

    def _snr_ceiling(self) -> float:
        """An SNR that no design exceeds, for quick bounds: that of a million electrons a pixel squared."""
        return 200.0 if self.objective.weight("snr_db") else 0.0

    def _solve_pairs(
        self, imager: Array, unit: Array, item: Array, signals: list[Array], lighting: Lighting, table: LightTable,
        cost: Array, mass: Array,
    ) -> None:  # fmt: skip
        """Closed-form settings of these designs, and their place among the best."""
        light, count = table.light[item], table.count[item]
        solved = self.solve(imager, [s[unit] for s in signals], light, count, lighting, cost, mass)
        self._keep_best(imager, light, count, lighting, *solved)

    def solve(
        self, imager: Array, signals: list[Array], light: Array, count: Array, lighting: Lighting, cost: Array,
        mass: Array,
    ) -> tuple[Array, Terms, list[closed_form.Chosen], list[Array]]:  # fmt: skip
        """Objective (inf where infeasible), its terms, settings and exposures of these designs."""
        rows = self.rows(imager, signals, light, count, lighting)
        motorised = self.motorised[imager]
        camera_power = self.imagers.camera_power_w[imager]
        chosen, feasible, snr_db = best_settings(
            rows, motorised, self.objective, camera_power, limit(self.limits.power_w)
        )
        light_power = np.max([c.light_power_w for c in chosen], axis=0)
        power = camera_power + light_power
        feasible &= power <= limit(self.limits.power_w) * ROUND
        terms = Terms(power, cost, mass, snr_db, self.imagers.gsd_mm[imager])
        with np.errstate(invalid="ignore"):
            value = self.objective.cost_to_minimise(terms)
        value = np.where(feasible & np.isfinite(value), value, np.inf)
        return value, terms, chosen, [r.exposure_s(c.time_s) for r, c in zip(rows, chosen, strict=True)]

    def rows(
        self, imager: Array, signals: list[Array], light: Array, count: Array, lighting: Lighting
    ) -> list[SceneRows]:
        """The settings' view of these designs, by scene."""
        result = []
        for index, signal in enumerate(signals):
            scene = self.problem.scenes[index]
            worst = None
            if (
                scene.view.requirements.snr_at == "worst"
                and scene.view.requirements.min_snr
                and not self.problem.paper
            ):
                worst = self._darkest(index, imager, count, lighting)
            result.append(
                self.problem.scene_rows(
                    index,
                    camera=self.imagers.camera[imager],
                    light=light,
                    count=count,
                    focused=self.imagers.scenes[index].focused.take(imager),
                    signal_e=signal,
                    worst_e=worst,
                )
            )
        return result

    def _darkest(self, scene_index: int, imager: Array, count: Array, lighting: Lighting) -> Array:
        """Electrons per lm s at the darkest pixel; the share of lamps on each side depends on their number."""
        unique, back = np.unique(np.stack([imager, count]), axis=1, return_inverse=True)
        out = np.empty((unique.shape[1], len(self.problem.scenes[scene_index].range_m)))
        for number in np.unique(unique[1]):
            mine = unique[1] == number
            out[mine] = self.tables.exact(
                scene_index, lighting, unique[0, mine], count=int(number), darkest=True
            )
        return np.asarray(out[back.reshape(-1)])

    def _keep_best(
        self, imager: Array, light: Array, count: Array, lighting: Lighting, value: Array, terms: Terms,
        chosen: list[Any], exposure: list[Array],
    ) -> None:  # fmt: skip
        """Merge designs into the list of the best with other hardware."""
        hopeful = np.nonzero(np.isfinite(value) & (value <= self._threshold()))[0]
        if len(hopeful) == 0:
            return
        pulse = np.max([c.time_s[hopeful] for c in chosen], axis=0)
        tie_class = np.round(value[hopeful] / (TIE * max(float(np.abs(value[hopeful]).min()), 1e-12)))
        keys = (
            pulse,
            count[hopeful],
            terms.mass[hopeful],
            terms.cost[hopeful],
            terms.power[hopeful],
            tie_class,
        )
        order = hopeful[np.lexsort(keys)]
        im = self.imagers
        rows = imager[order]
        hardware = np.stack([im.camera[rows], im.lens[rows], im.port[rows], light[order]])
        _, first = np.unique(hardware, axis=1, return_index=True)  # each hardware's best comes first
        for i in order[np.sort(first)]:
            if value[i] > self._threshold():
                break
            self._insert(self._found(int(i), imager, light, count, lighting, value, terms, chosen, exposure))

    def _found(
        self, i: int, imager: Array, light: Array, count: Array, lighting: Lighting, value: Array, terms: Terms,
        chosen: list[Any], exposure: list[Array],
    ) -> Found:  # fmt: skip
        im, index = self.imagers, int(imager[i])
        scenes = []
        for scene_index, settings in enumerate(chosen):
            numbers = {name: float(getattr(settings, name)[i]) for name in settings.__dataclass_fields__}
            focused = im.scenes[scene_index].focused
            numbers["exposure_s"] = float(exposure[scene_index][i])
            numbers["dioptre_per_m"] = float(focused.dioptre_per_m[index])
            numbers["rate_hz"] = float(focused.rate_hz[index])
            scenes.append(numbers)
        return Found(
            imager=index, camera=int(im.camera[index]), lens=int(im.lens[index]), port=int(im.port[index]),
            landscape=bool(im.landscape[index]), light=int(light[i]), count=int(count[i]), lighting=lighting,
            minimised=float(value[i]), power_w=float(terms.power[i]), cost=float(terms.cost[i]),
            mass_kg=float(terms.mass[i]), snr_db=float(terms.snr_db[i]), settings=scenes,
            pulse_s=max(s["time_s"] for s in scenes),
        )  # fmt: skip

    def _insert(self, design: Found) -> None:
        """Put a design in its place; of equal hardware only the better stays."""
        parts = self.problem.parts

        def ids(f: Found) -> tuple[str, ...]:
            return (
                parts.cameras[f.camera].id,
                parts.lenses[f.lens].id,
                parts.ports[f.port].id,
                parts.lights[f.light].id,
            )

        def better(a: Found, b: Found) -> bool:
            if abs(a.minimised - b.minimised) > TIE * max(abs(a.minimised), abs(b.minimised)):
                return a.minimised < b.minimised
            return a.tie_key(ids(a)) < b.tie_key(ids(b))

        same = [f for f in self.best if ids(f) == ids(design)]
        if same and not better(design, same[0]):
            return
        rest = [f for f in self.best if ids(f) != ids(design)]
        place = next((n for n, f in enumerate(rest) if better(design, f)), len(rest))
        rest.insert(place, design)
        self.best = rest[: self.top]


@dataclass(frozen=True)
class Needs:
    """What imagers need in one scene before any light is chosen."""

    by_snr_e: Array  # electrons, at every altitude
    by_gain_e: Array  # electrons, at the nominal altitude
    square: Array  # of the smallest working f-number
    longest_s: Array
    rate_hz: Array


@dataclass
class UnitBounds:
    """Bounds of every imager under one lighting; `rule` names why a unit cannot be feasible, -1: it may be."""

    value: Array
    power: Array
    cost: Array
    mass: Array
    snr_db: Array
    rule: Array

    @staticmethod
    def none(n: int) -> UnitBounds:
        """No bound at all: everything may be best."""
        low = np.full(n, -1e300)
        return UnitBounds(low, low, low, low, np.full(n, np.inf), np.full(n, -1))

    @staticmethod
    def empty(n: int) -> UnitBounds:
        """No light yet: nothing can be reached."""
        inf = np.full(n, np.inf)
        return UnitBounds(inf, inf.copy(), inf.copy(), inf.copy(), np.full(n, -np.inf), np.zeros(n, int))

    def better_of(self, other: UnitBounds) -> UnitBounds:
        """The lower bound of two groups of lights; a unit fails only if both fail, by the later rule."""
        both = (self.rule >= 0) & (other.rule >= 0)
        rule = np.where(both, np.maximum(self.rule, other.rule), -1)
        return UnitBounds(
            np.minimum(self.value, other.value),
            np.minimum(self.power, other.power),
            np.minimum(self.cost, other.cost),
            np.minimum(self.mass, other.mass),
            np.maximum(self.snr_db, other.snr_db),
            rule,
        )


def suffix_min(values: Array) -> Array:
    """Least of each value and all after it."""
    return np.minimum.accumulate(values[::-1])[::-1]


def best_settings(
    rows: list[SceneRows], motorised: Array, objective: Objective, camera_power_w: Array, power_limit_w: float
) -> tuple[list[closed_form.Chosen], Array, Array]:
    """Settings that are best for an objective, whether they exist, and the worst scene's SNR in dB.

    Dark current depends on the exposure that is chosen, so the closed form is taken again with the
    exposure of the last round; dark electrons are few, and two or three rounds settle it.
    """
    for _ in range(DARK_ROUNDS):
        chosen, feasible, snr_db = settings_at_dark(rows, motorised, objective, camera_power_w, power_limit_w)
        updated = [closed_form.with_exposure(r, c) for r, c in zip(rows, chosen, strict=True)]
        if all(np.allclose(closed_form.dark_e(a), closed_form.dark_e(b), rtol=0, atol=1e-9)
               for a, b in zip(rows, updated, strict=True)):  # fmt: skip
            break
        rows = updated
    return chosen, feasible, snr_db


def settings_at_dark(
    rows: list[SceneRows], motorised: Array, objective: Objective, camera_power_w: Array, power_limit_w: float
) -> tuple[list[closed_form.Chosen], Array, Array]:
    """Best settings with the dark electrons of the rows.

    Without SNR in the objective least power is best for every term. With SNR alone the highest reachable
    is found first, then the least power that reaches it. A weighted sum is convex along the SNR floor.
    """
    weight = objective.weight("snr_db")
    if not weight:
        chosen, feasible = closed_form.least_power(rows, motorised)
    else:
        top = closed_form.greatest_snr(rows, motorised, power_limit_w - camera_power_w)
        goal = np.nan_to_num(top, nan=0.0) * (1 - 1e-12)
        if objective.single is None and objective.weight("power"):
            goal = weighted_goal(rows, motorised, goal, objective.weight("power"), weight)
        chosen, feasible = closed_form.least_power(rows, motorised, snr_floor=goal)
        feasible &= np.isfinite(top)
    snr = np.min([closed_form.nominal_snr(r, c.light_x) for r, c in zip(rows, chosen, strict=True)], axis=0)
    with np.errstate(invalid="ignore"):
        return chosen, feasible, np.asarray(sensor.to_db(np.where(snr > 0, snr, np.nan)))


def weighted_goal(
    rows: list[SceneRows], motorised: Array, top: Array, power_weight: float, snr_weight: float
) -> Array:
    """SNR floor that minimises power_weight * power - snr_weight * SNR in dB, by golden section.

    Between the requirement and the reachable top; power is convex in the SNR in dB for lamps that dim
    freely. Lamps with steps are tried at the top of each step as well.
    """
    low = np.zeros_like(top)

    def merit(snr: Array) -> Array:
        chosen, feasible = closed_form.least_power(rows, motorised, snr_floor=snr)
        power = np.max([c.light_power_w for c in chosen], axis=0)
        got = np.min(
            [closed_form.nominal_snr(r, c.light_x) for r, c in zip(rows, chosen, strict=True)], axis=0
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            value = power_weight * power - snr_weight * sensor.to_db(got)
        return np.where(feasible, value, np.inf)

    start, _ = closed_form.least_power(rows, motorised)
    low = np.min([closed_form.nominal_snr(r, c.light_x) for r, c in zip(rows, start, strict=True)], axis=0)
    low = np.where(np.isfinite(low) & (low > 0), np.minimum(low, top), top)
    best, best_value = top.copy(), merit(top)
    low_value = merit(low)
    best, best_value = np.where(low_value < best_value, low, best), np.minimum(best_value, low_value)
    a, b = np.log(np.maximum(low, 1e-300)), np.log(np.maximum(top, 1e-300))
    ratio = (np.sqrt(5.0) - 1.0) / 2.0
    c, d = b - ratio * (b - a), a + ratio * (b - a)
    value_c, value_d = merit(np.exp(c)), merit(np.exp(d))
    for _ in range(60):
        left = value_c < value_d
        b, a = np.where(left, d, b), np.where(left, a, c)
        new_c, new_d = b - ratio * (b - a), a + ratio * (b - a)
        value_c, value_d = merit(np.exp(new_c)), merit(np.exp(new_d))
        c, d = new_c, new_d
    for point, value in ((c, value_c), (d, value_d)):
        best, best_value = np.where(value < best_value, np.exp(point), best), np.minimum(best_value, value)
    for step in step_tops(rows, motorised, top):
        value = merit(step)
        best, best_value = np.where(value < best_value, step, best), np.minimum(best_value, value)
    return best


def step_tops(rows: list[SceneRows], motorised: Array, top: Array) -> list[Array]:
    """SNR reached at the top of each step of each scene's light: where a staircase of power may be best."""
    tops = []
    for scene in rows:
        for column in range(scene.levels.shape[1]):
            level = scene.levels[:, column]
            if np.isnan(level).all():
                continue
            capped = [
                SceneRows(
                    **{
                        **{n: getattr(r, n) for n in r.__dataclass_fields__},
                        "max_level": np.fmin(r.max_level, level),
                    }
                )
                if r is scene
                else r
                for r in rows
            ]
            snr = closed_form.greatest_snr(capped, motorised, np.full(len(top), np.inf))
            tops.append(np.where(np.isfinite(snr), np.minimum(snr, top) * (1 - 1e-12), top))
    return tops


__all__ = [
    "CONTINUOUS",
    "PULSED",
    "RULES",
    "Account",
    "Found",
    "Outcome",
    "Search",
    "best_settings",
    "search",
]

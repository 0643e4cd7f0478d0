"""Every light of a node on its own: a bound for each (imager, light, count) once the signal is known.

The bound of a node takes the best of its lights in each respect. Here each light must be bright enough within
its own pulse, keep up with the frame rate, and fit all budgets at once.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.forward import switching
from uwopt.forward.part_columns import FLASH, PULSED, Lights
from uwopt.objectives.objective import Terms
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.imager_rules import limit
from uwopt.solvers.exact.node_bounds import NodeBounds, first_missed
from uwopt.tolerances import ROUND

Array = NDArray[Any]
MEETS = 1.0 + 1e-9  # a rate or a capacity met to rounding


def pair_rules(
    bounds: Bounds, k: int, rows: Array, node: NodeBounds, threshold: float
) -> tuple[Array, Array]:
    """For every imager (n) and light of one lighting (m) the rule that discards it, an index into `NODE_RULES`; -1
    where none does; and the least objective of the lights that none discards, inf without any (n). `node` holds the
    bounds of these imagers under the lighting."""
    table, imagers, limits = bounds.light_tables[k], bounds.imagers, bounds.limits
    lamp = bounds.problem.lights.take(table.light)
    shape = (len(rows), len(table.light))
    able, power, mean_power = np.ones(shape, bool), np.zeros(shape), np.zeros(shape)
    duration = bounds.problem.duration
    switched = [switching.are_switched(scene.view.vehicle, lamp) for scene in bounds.problem.scenes]
    pulsed, flash = table.kind == PULSED, table.kind == FLASH
    for scene_index in range(len(imagers.scenes)):
        need = bounds.needs(scene_index, rows)
        light_time, _, _ = bounds.light_needed(scene_index, bounds.tables.lightings[k], need, FLASH, rows)
        rate, longest = need.rate_hz[:, None], need.longest_s[:, None]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            pulse = np.minimum(longest, np.minimum(lamp.max_pulse_s, lamp.max_duty / rate))
            share = share_let_in(flash, lamp, longest)  # of a flash that the shutter lets in
            time = np.where(pulsed, pulse, np.where(flash, share, longest))
            wanted = np.where(light_time[:, None] > 0, light_time[:, None] / time, 0.0)
            given = np.where(pulsed, wanted, table.effective * level_set(wanted / table.effective, lamp))
            lead_s = np.where(switched[scene_index], lamp.warm_up_s, np.inf)
            most = np.where(given > 0, light_time[:, None] / given, 0.0)  # time that the light takes at least
            on = np.where(switched[scene_index], np.minimum(1.0, rate * (lead_s + most)), 1.0)
            drawn = given * np.where(flash, rate, np.where(pulsed, pulse * rate, on))
            drawn = np.where(wanted > 0, drawn * table.power_per_light, 0.0)
        able &= (wanted <= table.effective * MEETS) & (longest > 0)
        able &= rate <= table.max_rate_hz * MEETS
        power = np.maximum(power, np.where(able, drawn, np.inf))
        mean_power = mean_power + duration.shares[scene_index] * np.where(able, drawn, 0.0)
    power = power + imagers.camera_power_w[rows, None]
    mean_power = mean_power + imagers.camera_power_w[rows, None]
    mass = imagers.mass_kg[rows, None] + table.mass_kg
    limit_cost = imagers.limit_cost[rows, None] + table.limit_cost
    terms = Terms(
        power, imagers.cost[rows, None] + table.cost, mass, node.snr_db[:, None], imagers.gsd_mm[rows, None], 1.0,
        np.broadcast_to(node.information, len(rows))[:, None],
    )  # fmt: skip
    with np.errstate(invalid="ignore"):
        value = bounds.objective.cost_to_minimise(terms)
    rule = first_missed([
        ("light", able),
        ("cost", limit_cost <= limit(limits.cost) * ROUND),
        ("mass_kg", mass <= limit(limits.mass_kg) * ROUND),
        ("power_w", power <= limit(limits.power_w) * ROUND),
        ("energy_wh", mean_power <= duration.mean_power_limit_w * ROUND),
        ("bound", value <= threshold),
    ])  # fmt: skip
    least = np.where(rule < 0, value, np.inf).min(axis=1, initial=np.inf)
    return rule, np.maximum(least, np.where(node.rule < 0, node.value, np.inf))


def share_let_in(flash: Array, lamp: Lights, longest_s: Array) -> Array:
    """The most of each flash that comes in the longest time (n, 1) of its shutter or blur, (n, m); 1 of other lamps."""
    share = np.ones(np.broadcast_shapes(longest_s.shape, flash.shape))
    if flash.any():
        share[:, flash] = lamp.flash.take(flash).most_share(longest_s)
    return share


def level_set(wanted: Array, lamp: Lights) -> Array:
    """The least level (n, m) of each lamp that is not below the one wanted, a share of full; full when there is none.

    Pulsed lamps may shorten the pulse instead, so that this is a bound for the others alone.
    """
    least = np.clip(wanted * (2.0 - MEETS), 0.0, 1.0)  # steps may lie below what a dial would end at
    stepped = np.ones(np.broadcast_shapes(wanted.shape, lamp.dims_freely.shape))
    for step in sorted(range(lamp.levels.shape[1]), reverse=True):
        level = lamp.levels[:, step]
        stepped = np.where(level >= least, np.minimum(stepped, level), stepped)
    return np.where(lamp.dims_freely, np.maximum(least, lamp.min_level), stepped)

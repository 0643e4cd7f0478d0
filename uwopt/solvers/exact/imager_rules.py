"""Rules that imagers must pass before any light is known, in turn, and a tally of what each discards."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import reduce
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.enclosures import (
    beaten,
    fits_inside,
    housing_diameter_mm,
    housing_size_mm,
    mass_in_water_kg,
)
from uwopt.forward.focus import Focused
from uwopt.forward.problem import Problem
from uwopt.forward.views import Views
from uwopt.model.imaging import FARTHEST
from uwopt.tolerances import ROUND

SAMPLES, MOST_SAMPLES = 24, 1024  # discarded imagers remembered per rule: about so many at a time, and most

Sample = tuple[int, int, int, bool, int | None]  # camera, lens, port, landscape, lighting or None for any


@dataclass(frozen=True)
class Behind:
    """Cameras with lenses behind ports that share their optics, in one orientation: what is seen through one of the
    ports is seen through all."""

    camera: Array
    lens: Array
    ports: Array
    landscape: bool

    def take(self, pairs: Array) -> Behind:
        """These pairs only."""
        return Behind(self.camera[pairs], self.lens[pairs], self.ports, self.landscape)


@dataclass(frozen=True)
class Tally:
    """How many imagers each rule discards first, and which some of them are."""

    discarded: dict[str, int] = field(default_factory=dict)
    samples: dict[str, list[Sample]] = field(default_factory=dict)

    def passing(self, rules: Iterable[tuple[str, Array]], behind: Behind) -> Array:
        """The places of pairs that pass rules that all ports share; the others counted under the first they miss."""
        passed, n_port = np.ones(len(behind.camera), bool), len(behind.ports)
        for rule, passes in rules:
            lost = np.flatnonzero(passed & ~passes)
            if len(lost) == 0:
                continue
            self.count(rule, len(lost) * n_port, behind, lambda at, lost=lost: (lost[at // n_port], at % n_port))
            passed &= passes
        return np.flatnonzero(passed)

    def count(self, rule: str, number: int, behind: Behind, place: Callable[[int], tuple[int, int]]) -> None:
        """So many imagers that a rule discards, and which some of them are, by places of pair and port."""
        self.discarded[rule] = self.discarded.get(rule, 0) + number

        def one(at: int) -> Sample:
            pair, port = place(at)
            camera, lens = int(behind.camera[pair]), int(behind.lens[pair])
            return camera, lens, int(behind.ports[port]), behind.landscape, None

        self.remember(rule, number, one)

    def remember(self, rule: str, count: int, one: Callable[[int], Sample], about: int = SAMPLES) -> None:
        """Some of so many that a rule discards, evenly spread, for an audit; of very many in all every second."""
        kept = self.samples.setdefault(rule, [])
        kept += [one(at) for at in range(0, count, max(1, count // about))]
        if len(kept) > MOST_SAMPLES:
            del kept[1::2]


def beaten_housings(problem: Problem, ports: Array, alive: Array) -> Array:
    """Imagers that do as well in another housing, which costs and weighs no more; (n, n_ports).

    What is left out can be built into the other housing with the same image and light, at no greater cost or mass,
    and stays within every limit that it keeps: no objective that grows with cost and mass is lost.
    """
    rows = problem.ports.take(ports)
    worth = [rows.price, rows.limit_price, rows.mass_kg]
    if problem.mission.limits.mass_water_kg is not None:
        worth.append(rows.mass_kg - rows.displaced_kg)
    housings = [problem.parts.ports[p].housing for p in ports]
    return beaten(alive, worth, ["" if one is None else one.id for one in housings])


def view_rules(
    problem: Problem, port: int, seen: list[Views], spacers_m: Array, of: Array
) -> Iterator[tuple[str, Array]]:
    """The rules that a view and its focus are enough for, in turn, with the imagers that pass them, (n,).

    of : which of the views each imager has, (n,)
    """
    yield "view", all_of(view_clears(problem, port, view) for view in seen)[of]
    yield "horizon", below_horizon(seen)[of]
    yield "focus", np.isfinite(spacers_m)
    for rule, passes in sight_rules(problem, seen):
        yield rule, passes[of]


def below_horizon(seen: Sequence[Views], slack: float = ROUND) -> Array:
    """Whether views meet the floor, (n,)."""
    return all_of(view.farthest <= FARTHEST * slack for view in seen)


def sight_rules(problem: Problem, seen: Sequence[Views], slack: float = ROUND) -> Iterator[tuple[str, Array]]:
    """What the mission asks of what is seen, in turn, with the imagers that pass, (n,).

    slack : factor by which bounds of groups may miss a limit
    """
    every = [(scene.view.requirements, view) for scene, view in zip(problem.scenes, seen, strict=True)]

    def at_most(most: str, column: str) -> Array:
        return all_of(
            of_rows(np.maximum, getattr(view, column)) * 1e3 <= limit(getattr(needs, most)) * slack
            for needs, view in every
        )

    def at_least(least: str, column: str) -> Array:
        return all_of(
            of_rows(np.minimum, getattr(view, column)) * slack >= (getattr(needs, least) or 0.0)
            for needs, view in every
        )

    yield "max_gsd_mm", at_most("max_gsd_mm", "gsd_m")
    yield "min_swath_m", at_least("min_swath_m", "covered_across_m")
    yield "min_common_swath_m", at_least("min_common_swath_m", "common_across_m")
    yield "max_depth_error_mm", at_most("max_depth_error_mm", "depth_error_m")


def focus_rules(
    problem: Problem, camera: Array, lens: Array, focused: Sequence[Focused], slack: float = ROUND
) -> Iterator[tuple[str, Array]]:
    """Each further rule that ports of the same optics share, in turn, with the imagers that pass it, (n,)."""
    cameras, limits, count = problem.cameras.take(camera), problem.mission.limits, problem.mission.vehicle.camera_count
    duration = problem.duration
    each = [extra.rate_hz * cameras.frame_mb for extra in focused]
    rates = [one * count for one in each]
    yield "frame_rate", all_of(extra.rate_hz <= cameras.max_rate_hz * slack for extra in focused)
    yield "data_rate_mb_s", all_of(rate <= limit(limits.data_rate_mb_s) * slack for rate in rates)
    yield "storage_gb", duration.mean(rates) <= duration.mean_data_limit_mb_s * slack
    yield "card_gb", duration.mean(each) <= duration.mean_rate_into(cameras.storage_gb) * slack
    yield "lens_stop_down", stops_down(problem, problem.lenses)[lens]
    yield "min_dof_m", common_f_number(focused, slack)
    yield (
        "max_blur_px",
        all_of(
            (extra.blur_time_s > 0) & (cameras.min_exposure_s <= limits.max_exposure_ms * 1e-3)
            for extra in focused
        ),
    )


def own_rules(
    problem: Problem, cameras: Any, lenses: Any, spacers_m: Array, ports: Array, rates: list[Array], tan_corner: Array
) -> Iterator[tuple[str, Array]]:
    """Each rule after those, with the imagers that pass it: (n, n_ports) where the housing matters, else (n,).

    spacers_m : of rings behind the lenses, (n,)
    rates : of the images by scene, (n,) [Hz]
    tan_corner : of the widest view, (n,)
    """
    limits, count = problem.mission.limits, problem.mission.vehicle.camera_count
    housings = problem.ports.take(ports)
    yield "housing", fits_inside(cameras, lenses, spacers_m, housings, tan_corner)
    every_pair = np.ones((len(cameras.price), 1), bool)
    yield "size_mm", every_pair & (housing_size_mm(housings) <= limit(limits.size_mm) * ROUND)
    yield "diameter_mm", every_pair & (housing_diameter_mm(housings) <= limit(limits.diameter_mm) * ROUND)
    most = limits.mass_water_kg
    if most is None:
        yield "mass_water_kg", every_pair
    else:
        rings_kg = (spacers_m > 0.0) * problem.spacers["mass_kg"]
        in_water = mass_in_water_kg(count, cameras, lenses, rings_kg, housings)
        yield "mass_water_kg", in_water <= most + (ROUND - 1.0) * abs(most)
    asked = ports if limits.cost is not None or limits.mass_kg is not None else ports[:1]  # one stands for all
    disks_gb = problem.disks_gb(cameras, rates)
    _, cost, mass = totals(problem, cameras, lenses, spacers_m, asked[:, None], disks_gb)
    cost, mass = cost.T, mass.T
    yield "cost", cost <= limit(limits.cost) * ROUND
    yield "mass_kg", mass <= limit(limits.mass_kg) * ROUND
    powers = problem.camera_powers_w(cameras, rates)
    yield "power_w", np.max(powers, axis=0) <= limit(limits.power_w) * ROUND
    yield "energy_wh", problem.duration.mean(powers) <= problem.duration.mean_power_limit_w * ROUND


def of_rows(least_or_most: np.ufunc, rows: Array) -> Array:
    """Least or most of each row, (n,): column by column, of few columns far quicker than row by row."""
    return np.asarray(reduce(least_or_most, rows.T))


def limit(value: float | None) -> float:
    """A limit that may be absent."""
    return np.inf if value is None else value


def all_of(masks: Iterator[Array]) -> Array:
    """Where every mask holds."""
    result = next(masks)
    for mask in masks:
        result = result & mask
    return np.asarray(result)


def view_clears(problem: Problem, port: int, view: Views) -> Array:
    """Whether the corner ray passes the port: its clear aperture, and the rim of a spherical cap, where known."""
    if problem.paper:
        return np.ones(len(view.tan_along), bool)
    corner = np.hypot(view.tan_along, view.tan_across)
    ports = problem.ports
    clears = corner * ports.rim_gap_m[port] <= ports.clear_radius_m[port]
    return np.asarray(clears & np.isfinite(corner)) if ports.is_dome[port] else np.asarray(clears)


def stops_down(problem: Problem, lenses: Any) -> Array:
    """Whether the lens can be closed as far as the mission asks."""
    most = max(scene.view.requirements.lens_stop_down for scene in problem.scenes)
    return np.asarray(lenses.f_number_from(most) <= lenses.f_number_max * ROUND)


def common_f_number(focused: Sequence[Focused], slack: float) -> Array:
    """Whether an f-number of the lens keeps sharp what must be, the same in all scenes unless motorised."""
    low = np.max([extra.n_low for extra in focused], axis=0)
    return np.asarray(np.isfinite(low) & (low <= focused[0].n_high * slack))


def totals(
    problem: Problem, cameras: Any, lenses: Any, spacers_m: Array, port: int | Array, disks_gb: Array
) -> tuple[Array, Array, Array]:
    """Cost, cost that counts against the budget, and mass of everything but the lights.

    port : of each row, or one for all; (n_ports, 1): all rows behind each, (n_ports, n)
    """
    count = problem.mission.vehicle.camera_count
    extra_cost, extra_mass, _ = problem.extras
    ports = problem.ports
    ring = {name: (spacers_m > 0.0) * each for name, each in problem.spacers.items()}
    cost = count * (cameras.price + lenses.price + ring["price"] + ports.price[port]) + extra_cost
    cost = cost + disks_gb * problem.disk_prices["price"]
    limit_cost = (
        count * (cameras.limit_price + lenses.limit_price + ring["limit_price"] + ports.limit_price[port]) + extra_cost
    ) + disks_gb * problem.disk_prices["limit_price"]
    mass = count * (cameras.mass_kg + lenses.mass_kg + ring["mass_kg"] + ports.mass_kg[port]) + extra_mass
    return cost, limit_cost, mass

"""Throughput of the forward model: designs of the catalogue with random settings, figures a second.

Tables first (what depends on hardware and scene alone), timed apart; then the figures of all requirements for
every design, in chunks that fit the processor's cache, on one thread and on two.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields
from statistics import median
from typing import Any

import numpy as np

from uwopt.forward.assembly import load_catalog
from uwopt.forward.figures import DesignRows, SettingRows, figures_of, levers_m
from uwopt.forward.scene import SceneOptics
from uwopt.forward.views import focus_map
from uwopt.mission.mission import load_mission
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.search import Search
from uwopt.solvers.recommend import seek

CHUNK = 4096
N_CHUNKS = 48
N_IMAGERS = 400  # drawn for the field integrals
N_LAMPS = 2
Work = tuple[SceneOptics, DesignRows, SettingRows]


@dataclass(frozen=True)
class Throughput:
    """Medians of one physics."""

    physics: str
    n_designs: int
    integrals_per_s: float  # hardware under one light optics, every altitude
    designs_per_s: dict[int, float]  # by number of threads


def measure(mission_file: str, physics: str, *, repeats: int, threads: Sequence[int] = (1, 2)) -> Throughput:
    """Build tables, draw designs, and time the forward model."""
    mission = load_mission(mission_file).with_changes(physics=physics)
    search = seek(mission, load_catalog(mission), Objective.of("power"), generic="never", top=1).search
    rng = np.random.default_rng(0)
    imagers = np.unique(rng.integers(len(search.imagers), size=N_IMAGERS))
    signals, integrals_per_s = field_integrals(search, imagers)
    work = [chunk(search, imagers, signals, rng) for _ in range(N_CHUNKS)]
    for item in work:
        assert np.isfinite(figures_of(*item).snr).all()
    rates = {n: len(work) * CHUNK / median_duration_s(work, n, repeats) for n in threads}
    return Throughput(physics, len(work) * CHUNK, integrals_per_s, rates)


def field_integrals(search: Search, imagers: Any) -> tuple[list[Any], float]:
    """Electrons per lm s of every imager drawn under every light optics, and how many a second."""
    search.tables.exact(0, search.tables.lightings[0], imagers[:1])  # loss tables are built once
    start = time.perf_counter()
    signals = [search.tables.exact(0, lighting, imagers) for lighting in search.tables.lightings]
    return signals, len(signals) * len(imagers) / (time.perf_counter() - start)


def chunk(search: Search, imagers: Any, signals: list[Any], rng: np.random.Generator) -> Work:
    """Hardware drawn from the tables, settings drawn over their usual ranges."""
    problem, scene = search.problem, search.problem.scenes[0]
    k = int(rng.integers(len(signals)))
    lights = np.flatnonzero(problem.lights.optics_index == search.tables.lightings[k].optics)
    drawn = rng.integers(len(imagers), size=CHUNK)
    i, j = imagers[drawn], rng.choice(lights, size=CHUNK)
    hardware = search.imagers
    maps = [focus_map(scene, problem.shape(port, 0)) for port in range(len(problem.parts.ports))]
    focus = type(maps[0])(
        *(np.array([getattr(m, f.name) for m in maps])[hardware.port[i]] for f in fields(maps[0]))
    )
    focused = hardware.scenes[0].focused.take(i)
    rows = DesignRows(
        cameras=problem.cameras.take(hardware.camera[i]),
        lenses=problem.lenses.take(hardware.lens[i]),
        lights=problem.lights.take(j),
        count=np.full(CHUNK, float(N_LAMPS)),
        view=hardware.scenes[0].view.take(i),
        focus_map=focus,
        lever_m=levers_m(scene, problem.ports.outer_radius_m[hardware.port[i]]),
        light=signals[k].take(drawn).scaled(problem.lights.output_factor[j]),
    )
    settings = SettingRows(
        f_number=np.exp(rng.uniform(np.log(1.4), np.log(16), CHUNK)),
        exposure_s=np.exp(rng.uniform(np.log(1e-4), np.log(1e-2), CHUNK)),
        pulse_s=np.exp(rng.uniform(np.log(1e-4), np.log(5e-3), CHUNK)),
        gain=np.exp(rng.uniform(0.0, 3.0, CHUNK)),
        level=rng.uniform(0.1, 1.0, CHUNK),
        rate_hz=focused.rate_hz,
        dioptre_per_m=focused.dioptre_per_m,
    )
    return scene, rows.by_altitude(), settings


def median_duration_s(work: Sequence[Work], n_threads: int, repeats: int) -> float:
    """Median time to work through all chunks."""
    if n_threads == 1:
        return median(timed_s(lambda: [figures_of(*item) for item in work]) for _ in range(repeats))
    with ThreadPoolExecutor(n_threads) as pool:
        return median(
            timed_s(lambda: list(pool.map(lambda item: figures_of(*item), work))) for _ in range(repeats)
        )


def timed_s(task: Callable[[], Any]) -> float:
    """Duration of one call."""
    start = time.perf_counter()
    task()
    return time.perf_counter() - start

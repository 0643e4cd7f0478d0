"""Physics `full` and `auto` over batches of designs: hardware integrals and figures together, and apart.

One run, one process; what matters are the ratios. Hardware is drawn from the catalogue, settings at random.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np

from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.forward.batch import Batch
from uwopt.forward.designs import Designs
from uwopt.forward.effects import effects_kept
from uwopt.forward.figures import SettingRows
from uwopt.mission.mission import load_mission

N_DESIGNS = 500
SETTINGS_A_DESIGN = 32
CLEAR = {
    "scene": {"water": "I", "seafloor": 0.3, "depth_m": 100.0},
    "vehicle": {"altitude_m": 0.4, "speed_m_s": 0.1, "light_baseline_m": 0.5},
    "requirements": {"overlap": 0.5, "max_blur_px": 1.0, "min_dof_m": 0.05, "min_snr_db": 25.0},
}  # no veil is kept: clear water at short range

SCENES: list[tuple[str, Any, float]] = [
    ("clear water, 0.4 m", CLEAR, 0.01),
    ("reef-mosaic", "problems/reef-mosaic.yaml", 0.005),
    ("usgs-squid5", "problems/usgs-squid5.yaml", 0.005),
]


@dataclass(frozen=True)
class Comparison:
    """One scene: seconds a batch in both physics, and the forward model's rate with tables built."""

    scene: str
    kept: tuple[str, ...]
    full_s: float
    auto_s: float
    designs_per_s: float  # full, tables built, all requirement figures


def compare(name: str, mission: Any, *, tolerance: float, repeats: int) -> Comparison:
    """Time both physics over the same designs."""
    loaded = load_mission(mission).with_changes(physics="full", tolerance=tolerance)
    catalog = load_catalog(loaded)
    problem = build_problem(loaded, selected(loaded, catalog, generic="never"))
    designs, settings = drawn(problem, np.random.default_rng(0))

    def full() -> None:
        batch = Batch(problem, designs)
        batch.figures(0, batch.rows(0), settings)

    def auto() -> None:
        batch = Batch(problem, designs)
        lean = batch.with_effects(effects_kept(batch.influences(tolerance, [settings])))
        lean.figures(0, lean.rows(0), settings)

    full(), auto()  # path tables are built once a scene, whichever physics
    times = [(timed_s(full), timed_s(auto)) for _ in range(repeats)]
    kept = tuple(i.name for i in Batch(problem, designs).influences(tolerance, [settings]) if i.kept)
    return Comparison(
        name, kept, median(t[0] for t in times), median(t[1] for t in times),
        rate(Batch(problem, designs), settings, repeats),
    )  # fmt: skip


def rate(batch: Batch, settings: SettingRows, repeats: int) -> float:
    """Designs a second of the figures of all requirements, hardware tabulated, in chunks."""
    rows = batch.rows(0).by_altitude()
    count = len(batch.designs)

    def many() -> None:
        for _ in range(SETTINGS_A_DESIGN):
            batch.figures(0, rows, settings)

    many()
    return count * SETTINGS_A_DESIGN / median(timed_s(many) for _ in range(repeats))


def drawn(problem: Any, rng: np.random.Generator) -> tuple[Designs, SettingRows]:
    """Random hardware of the problem's parts with two lamps, and random settings."""
    n = N_DESIGNS

    def pick(count: int) -> Any:
        return rng.integers(count, size=n)

    parts = problem.parts
    designs = Designs(
        camera=pick(len(parts.cameras)), lens=pick(len(parts.lenses)), port=pick(len(parts.ports)),
        landscape=rng.random(n) < 0.5, light=pick(len(parts.lights)), count=np.full(n, 2), mount=problem.mounts[0],
    )  # fmt: skip

    def log(low: float, high: float) -> Any:
        return np.exp(rng.uniform(np.log(low), np.log(high), n))

    exposure = log(1e-4, 1e-2)
    return designs, SettingRows(
        f_number=log(1.4, 16), exposure_s=exposure, pulse_s=exposure, gain=log(1, 20), level=rng.uniform(0.1, 1.0, n),
        rate_hz=np.full(n, 2.0), dioptre_per_m=np.full(n, 1.0),
    )  # fmt: skip


def timed_s(task: Callable[[], Any]) -> float:
    """Duration of one call."""
    start = time.perf_counter()
    task()
    return time.perf_counter() - start


def main() -> None:
    """Print the comparison of three scenes."""
    for name, mission, tolerance in SCENES:
        c = compare(name, mission, tolerance=tolerance, repeats=5)
        print(
            f"{c.scene}: full {c.full_s:.3f} s, auto {c.auto_s:.3f} s ({c.full_s / c.auto_s:.2f} x faster), kept "
            f"{', '.join(c.kept) or 'nothing'}; full with tables built {c.designs_per_s / 1e3:.0f} thousand designs/s"
        )


if __name__ == "__main__":
    main()

"""Bounds of cells of settings, one by one, against points of `settings_attack`, whose formulas are its own."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hand_made_rows import STEPS
from numpy.typing import NDArray
from settings_attack import COLOURED, SIGNS, figures, lit, sample, sharp

from uwopt.forward.part_columns import PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.forward.sharpness import SharpRows
from uwopt.objectives.objective import Objective
from uwopt.solvers.settings.cell_tangent import DIMMEST
from uwopt.solvers.settings.cells import CellSearch, best_by_cells
from uwopt.solvers.settings.question import Question

Array = NDArray[Any]
GAP = 1e-4
LED = {"kind": PULSED, "rate_hz": 5.0, "min_exposure_s": 1e-5, "time_max_s": 4e-3}


def soft(**changed: float) -> SharpRows:
    """A lens whose aberrations outweigh what else blurs: 3.6 px wide open, at F1.4, and half a pixel at F5.6."""
    return sharp(**{"aberration": 6.0, "rated": 0.1, "place": 0.5, "rms": 0.5, "blur": 500.0, **changed})


BY_CELLS: dict[str, tuple[dict[str, Any], Any]] = {
    "information under lamps": ({}, "information"),
    "information with a veil and dark current": (dict(veil=60.0, dark_current_e_s=50.0), "information"),
    "information of a bright image": (dict(signal_e=[1200.0, 1000.0, 800.0], well_e=6000.0), "information"),
    "information against power": (dict(veil=30.0), {"information": 1e-5, "power": 0.01}),
    "power of a sharp image": (dict(min_mtf=0.25), "power"),
    "signal of a sharp image": (dict(min_mtf=0.25), "snr_db"),
    "signal of a sharp image, soft wide open": (dict(sharpness=soft(), min_mtf=0.4), "snr_db"),
    "signal of bars behind a veil": (dict(sharpness=soft(), resolve_m=2.2e-3, veil=40.0), "snr_db"),
    "signal of bars that show in the veil": (
        dict(sharpness=soft(scattered=2.0), resolve_m=2.2e-3, veil=90.0, min_snr=3.0), "snr_db",
    ),
    "information of what shows in the veil": (dict(sharpness=sharp(scattered=2.0), veil=60.0), "information"),
    "power of bars under the sun": (
        dict(sharpness=soft(), resolve_m=2.2e-3, veil=20.0, sun=(3e3, 6e3), open_max_s=5e-3, min_snr=12.0), "power",
    ),
    "signal of bars behind veils over the frame": (
        dict(sharpness=soft(), resolve_m=2.2e-3, veil=4.0, may_miss=2, min_snr=3.0, dark_current_e_s=50.0), "snr_db",
    ),
    "signal of bars that a few pixels may miss": (
        dict(sharpness=soft(), resolve_m=2.2e-3, veil=40.0, may_miss=3, min_snr=3.0), "snr_db",
    ),
    "power of bars over the frame under the sun": (
        dict(sharpness=soft(), resolve_m=2.2e-3, veil=4.0, sun=(3e3, 4e3), open_max_s=5e-3, may_miss=2, min_snr=2.0),
        "power",
    ),
    "information, soft wide open": (
        dict(sharpness=soft(), signal_e=[1.2e4, 1e4, 8e3], well_e=6000.0), "information",
    ),
    "information of a fast lens, soft wide open": (
        dict(sharpness=sharp(aberration=6.0, rated=0.1, place=0.5, rms=0.5, blur=500.0, power=2.0),
             signal_e=[1.2e4, 1e4, 8e3], well_e=6000.0), "information",
    ),
    "signal under the sun": (dict(sun=(3e5, 2e5), open_max_s=5e-3), "snr_db"),
    "contrast under the sun": (dict(sun=(3e5, 2e5), veil=20.0, open_max_s=5e-3), "contrast"),
    "power under the sun": (dict(sun=(3e3, 2e3), open_max_s=5e-3, min_snr=12.0), "power"),
    "power in steps under the sun": (dict(sun=(3e3, 2e3), open_max_s=5e-3, min_snr=12.0, **STEPS), "power"),
    "pulses under the sun": (dict(sun=(3e3, 2e3), open_max_s=5e-3, min_snr=12.0, **LED), "power"),
    "information of pulses under the sun": (dict(sun=(3e4, 2e4), open_max_s=5e-3, **LED), "information"),
    "information against power under the sun": (
        dict(sun=(3e5, 4e5), open_max_s=5e-3, signal_e=[12.0, 10.0, 8.0], well_e=2e4),
        {"information": 1e-5, "power": 0.01},
    ),
    "power over the frame under the sun": (
        dict(sun=(3e3, 2e3), open_max_s=5e-3, min_snr=12.0, may_miss=3), "power",
    ),
    "power of a mean beside its frame under the sun": (
        dict(sun=(3e3, 2e3), open_max_s=5e-3, min_snr=4.0, min_snr_mean=12.0, may_miss=3), "power",
    ),
    "power of a mean beside its frame, sharp in dark current": (
        dict(may_miss=3, min_snr=4.0, min_snr_mean=9.0, veil=30.0, dark_current_e_s=50.0, min_mtf=0.1), "power",
    ),
    "signal over the frame with dark current": (
        dict(may_miss=3, min_snr=10.0, veil=30.0, dark_current_e_s=50.0, min_mtf=0.1), "snr_db",
    ),
    **COLOURED,
    "signal against power": (dict(sun=(1e4, 1e4), open_max_s=5e-3), {"snr_db": 1.0, "power": 0.1}),
}  # fmt: skip


HALVINGS = 9


def cell_search(rows: SceneRows, wanted: Any) -> CellSearch:
    """The search over cells of one design, not yet run."""
    asked = Question.of([rows], np.array([False]), Objective.of(wanted), np.zeros(1), np.inf)
    return CellSearch(asked, own_f_number=False)


def within(search: CellSearch, pool: Any, points: list[Array]) -> Array:
    """Which points (n_points, n_cells) lie in which cells, to rounding."""
    n, tau, open_s, u, _ = (np.log(np.maximum(p, 1e-300))[:, None] for p in points)
    inside, slack = np.ones((len(n), len(pool.design)), bool), 1e-9
    dims = (search.n_dim[0], search.t_dim[0], search.open_dim[0], search.u_dim[0])
    for value, dim in zip((n, tau, open_s, u), dims, strict=True):
        if dim < 0:
            continue
        low = pool.lo[:, dim].copy()
        if dim == search.u_dim[0]:  # the lowest cells reach down to the lamp's own least level
            low[low <= np.log(DIMMEST * search.scenes[0].u_max[0]) + 1e-9] = -np.inf
        inside &= (value >= low - slack) & (value <= pool.hi[:, dim] + slack)
    return inside


@pytest.mark.parametrize("name", BY_CELLS)
def test_no_point_is_better_than_the_bound_of_a_cell_that_holds_it(name: str) -> None:
    """Cells of nine halvings against points all over: every feasible one lies in a cell, none below its bound."""
    given, wanted = BY_CELLS[name]
    rows, rng, objective = lit(**given), np.random.default_rng(0), Objective.of(wanted)
    points = sample(rows, rng, 3000, None, 0.0)
    seen = figures(rows, *points[:4], info=bool(objective.weight("information")))
    keep = np.nonzero(seen["ok"])[0]
    assert len(keep) > 20, "points enough"
    value = sum(objective.weight(n) * s * seen[n][keep] for n, s in SIGNS.items() if objective.weight(n))
    search = cell_search(rows, wanted)
    if not search.power_decides:
        value = value + search.offset[0]
    places = [p[keep] for p in points]
    pool, _ = search._bounded(search._roots())
    for _ in range(HALVINGS):
        inside = within(search, pool, places)
        assert inside.any(axis=1).all(), "a feasible point lies in no cell"
        bound = np.where(inside, pool.bound, -np.inf).max(axis=1)
        assert (value >= bound - 1e-7 * np.abs(bound) - 1e-12).all()
        pool, _ = search._bounded(search._halved(pool))


CELLS_ENOUGH = {  # halved until a gap of 1e-4 closes, a quarter more than it takes: looser bounds take many more
    "information under lamps": 5, "information with a veil and dark current": 6,
    "information of a bright image": 11, "signal under the sun": 112, "pulses under the sun": 500,
    "signal against power": 1370, "hardly sharp by steps of light": 25, "information against power under the sun": 151,
}  # fmt: skip
#: Sharpness alone tells f-numbers apart under a faint sun: cells halved in time only see it after 8700 of them.
HARDLY_SHARP: tuple[dict[str, Any], str] = (
    dict(sharpness=sharp(blur=7316.83, place=5.65095, aberration=2.3535), min_mtf=0.390503317, min_snr=3.70629033,
         kind=PULSED, dims_freely=False, levels=[1.0, np.nan], light_lm=14411.757, full_power_w=600.0,
         time_min_s=1e-4, sun=(1e-3, 1e-3)),
    "power",
)  # fmt: skip


@pytest.mark.parametrize("name", CELLS_ENOUGH)
def test_bounds_of_cells_close_the_gap_soon(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A bound that is loosened costs time alone; the cells that are halved tell."""
    given, wanted = BY_CELLS.get(name, HARDLY_SHARP)
    halved, sound = [], CellSearch._halved

    def counted(self: CellSearch, pool: Any) -> Any:
        halved.append(len(pool.design))
        return sound(self, pool)

    monkeypatch.setattr(CellSearch, "_halved", counted)
    best_by_cells(Question.of([lit(**given)], np.array([False]), Objective.of(wanted), np.array([3.0]), np.inf))
    assert sum(halved) <= CELLS_ENOUGH[name]


@pytest.mark.parametrize("name", ["power under the sun", "pulses under the sun", "hardly sharp by steps of light"])
def test_whether_anything_fits_takes_no_measure_of_halves(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where any settings will do, cells are halved along their widest side: what tells most is dearer than halves."""
    given, wanted = BY_CELLS.get(name, HARDLY_SHARP)
    asked = Question.of([lit(**given)], np.array([False]), Objective.of(wanted), np.array([3.0]), np.inf)
    never = Question.of(
        [lit(**{**given, "min_snr": 900.0})], np.array([False]), Objective.of(wanted), np.array([3.0]), np.inf
    )
    monkeypatch.setattr(CellSearch, "_gains", None)
    assert best_by_cells(replace(asked, gap_rel=np.inf)).feasible[0]
    assert np.isinf(best_by_cells(replace(never, gap_rel=np.inf)).bound(never)[0])


def test_bounds_measure_halves_only_of_what_takes_many(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a bound, too, until something fits: what does not is known by a few halves along the widest sides."""
    rows = lit(**{**BY_CELLS["power of bars under the sun"][0], "min_snr": 35.0})
    asked = Question.of([rows], np.array([False]), Objective.of("power"), np.array([3.0]), np.inf)
    measured, sound = [], CellSearch._gains

    def counted(self: CellSearch, pool: Any, dims: list[int]) -> Any:
        measured.append(len(pool.design))
        return sound(self, pool, dims)

    monkeypatch.setattr(CellSearch, "_gains", counted)
    assert np.isinf(best_by_cells(asked).bound(asked)[0]) and measured
    measured.clear()
    bound = replace(asked, rows=[replace(rows, optimistic=True)])
    assert np.isinf(best_by_cells(bound).bound(bound)[0]) and not measured


def test_the_shutter_beside_a_pulse_is_halved_last() -> None:
    """Where halves are not measured: it tells least, and cells that are halved in it alone are many in vain."""
    given, wanted = BY_CELLS["pulses under the sun"]
    rows = lit(**{**given, "open_max_s": 0.05})
    asked = Question.of([rows], np.array([False]), Objective.of(wanted), np.array([3.0]), np.inf, gap_rel=np.inf)
    search = CellSearch(asked, own_f_number=False)
    roots = search._roots()
    width, halves = (roots.hi - roots.lo)[0], search._halved(roots)
    assert width.argmax() == search.open_dim[0]
    left = (halves.hi - halves.lo)[0]
    assert left[search.open_dim[0]] == width[search.open_dim[0]]
    assert left[search.t_dim[0]] == pytest.approx(0.5 * width[search.t_dim[0]])

"""A result made by hand, so that reports are tested without a search."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from uwopt.results.design import Cost, Design, Margin, SceneResult
from uwopt.results.front import FrontMethod, FrontObjective, FrontPoint, FrontResult, Pick
from uwopt.results.result import Certificate, Result

SETTINGS = {
    "f_number": 2.8284, "exposure_ms": 0.0435678, "pulse_ms": None, "gain": 2.0, "gain_db": 6.0206, "flux_lm": 12345.6,
    "dim_frac": 0.617, "flash_energy_j": None, "frame_rate_hz": 1.2345, "focus_distance_m": 2.0123,
}  # fmt: skip
TO_SET = SETTINGS | {
    "f_number": 2.8,
    "exposure_ms": 12.345,
    "gain_db": 6.1,
    "dim_frac": 0.62,
    "frame_rate_hz": 1.24,
}


def margin(name: str, value: float | None, limit: float | None, sense: str, unit: str, **more: Any) -> Margin:
    """A margin with its verdict given."""
    left = None if value is None or limit is None else (limit - value if sense == "<=" else value - limit)
    values = {"at_altitude_m": None, "satisfied": True, "binding": False} | more
    return Margin(name, value, limit, sense, left, unit, **values)


def scene(name: str, **more: Any) -> SceneResult:
    """A scene with one margin of each sort."""
    margins = [
        margin("max_blur_px", 0.5, 1.0, "<=", "px", at_altitude_m=1.75),
        margin("overlap", 0.6, 0.6, ">=", "", binding=True),
        margin("depth_rating_m (acme-lamp)", 300.0, 100.0, ">=", "m"),
        margin("max_pulse_ms", 2.0, None, "<=", "ms"),
    ]
    return SceneResult(name, dict(SETTINGS), dict(TO_SET), {"snr_db": 30.0}, more.get("margins", margins))


def hardware(**parts: str) -> dict[str, Any]:
    """Four parts of a design, some by another id."""
    ids = {"camera": "acme-cam", "lens": "acme-lens", "port": "acme-dome", "light": "acme-lamp"} | parts
    return {
        **{kind: {"id": name, "name": f"Acme {kind} [bold]1[/bold]", "generic": False} for kind, name in ids.items()},
        "camera_count": 1, "light_count": 2, "orientation": "portrait",
        "light_mounts": [
            {"x_m": 0.0, "y_m": y_m, "z_m": 0.0, "tilt_x_deg": 0.0, "tilt_y_deg": 5.0} for y_m in (0.8, -0.8)
        ],
    }  # fmt: skip


BOM: list[dict[str, Any]] = [
    {"kind": "camera", "id": "acme-cam", "manufacturer": "=HYPERLINK(1)", "model": "-1", "count": 1, "owned": 0,
     "unit_price": 1910.0, "unit_price_low": 1910.0, "unit_price_high": 1910.0, "currency": "USD",
     "price_status": "quoted", "price_date": "2026-08-14", "generic": False, "source": "@shop", "price_basis": ""},
    {"kind": "light", "id": "acme-lamp", "manufacturer": "Acme", "model": "Lamp", "count": 2, "owned": 1,
     "unit_price": 2300.0, "unit_price_low": 1700.0, "unit_price_high": 3400.0, "currency": "USD",
     "price_status": "estimated", "price_date": "", "generic": False, "source": "", "price_basis": "\tclass"},
]  # fmt: skip
COST = {
    "value": 4210.0, "low": 3610.0, "high": 5310.0, "currency": "USD",
    "estimated": 2300.0, "estimated_low": 1700.0, "estimated_high": 3400.0,
}  # fmt: skip


def design(value: float = 40.0, scenes: list[SceneResult] | None = None, **parts: str) -> Design:
    """One design."""
    return Design(
        hardware=hardware(**parts), objective_value=value, feasible=True,
        totals={"cost": COST, "power_w": value, "light_power_w": 35.0, "light_peak_power_w": 50.0, "mass_kg": 7.5},
        scenes=scenes or [scene("reef")], bom=[dict(row) for row in BOM],
        rounded={"feasible": True, "objective_value": value + 0.5, "missed": []},
        warnings=[{"code": "rated", "path": "hardware", "message": "the lens is rated for larger pixels"}],
    )  # fmt: skip


def solved(**changes: Any) -> Result:
    """A whole result of `solve`."""
    best = design()
    certificate = Certificate(
        lower_bound=40.0, best_value=40.0, gap_abs=0.0, gap_rel=0.0, complete=True, scope="3 cameras",
        loaded=1_000_000, selected=900, evaluated=100,
        discarded=[{"rule": "light: depth rating", "count": 999_100}, {"rule": "bound", "count": 800}],
    )  # fmt: skip
    values: dict[str, Any] = {
        "command": "solve", "status": "optimal", "uwopt_version": "0.1.0", "recommendation": best,
        "mission": {"name": "Reef [red]survey[/red]", "limits": {"currency": "USD"}},
        "physics": {
            "name": "full", "asked": "full", "tolerance": 0.005, "fineness": {"veil": 1.0}, "water_table": "measured",
            "effects": [{"name": "sun", "bound": 0.001, "kept": False, "time_saved_s": 0.0}], "not_modelled": ["fish"],
        },
        "objective": {"name": "power", "direction": "minimise", "value": 40.0, "unit": "W"},
        "runners_up": [design(44.0, lens="acme-lens-2")],
        "generic_alternative": design(30.0, light="generic-lamp"), "certificate": certificate,
        "assumptions": [
            {"path": "light.output_factor", "part": "acme-lamp", "value": 0.7, "low": 0.5, "high": 1.0, "unit": "",
             "status": "estimated", "source": "class"},
            {"path": "reef: water_table", "part": "", "value": "measured", "low": None, "high": None, "unit": "",
             "status": "assumed", "source": "a"},
        ],
        "robustness": {
            "max_regret": 2.5,
            "rival": {"camera": "acme-cam-2", "lens": "l", "port": "p", "light": "x", "light_count": 1},
            "feasible_at_bad_end": True,
            "quotes_that_matter": [
                {"part": "acme-lamp", "kind": "light", "field": "price", "value": 2300.0, "low": 1700.0, "high": 3400.0,
                 "unit": "USD", "then_better": "acme-cam + acme-lens + acme-dome + other-lamp"},
            ],
        },
        "solvers": [{"method": "casadi", "hardware": ["acme-cam", "acme-lens", "acme-dome", "acme-lamp"],
                     "objective_value": 40.0, "difference_rel": 1e-9, "agrees": True, "status": "solved"}],
        "warnings": [{"code": "pattern", "path": "catalog", "message": "catalog.lenses: pattern 'x' matches no part"}],
        "timing_s": {"search": 0.3, "search_bounds": 0.1, "report": 0.12, "total": 0.43},
    }  # fmt: skip
    return Result(**values | changes)


OBJECTIVES = {"power": ("minimise", "W"), "cost": ("minimise", "USD"), "information": ("maximise", "bit/m²")}


def cost_at(value: float) -> Cost:
    """A cost whose estimated part spans as much as that of `COST`."""
    return Cost(**COST | {"value": value, "low": value - 600.0, "high": value + 1100.0})


def front(*names: str, points: int = 8, **changes: Any) -> FrontResult:
    """A front of two or three objectives: power falls along it, cost and information rise."""
    wanted = names or tuple(OBJECTIVES)
    made = []
    for index in range(points):
        values = {
            "power": 40.0 - 3.0 * index,
            "cost": 4000.0 + 500.0 * index,
            "information": 1e6 + 1e5 * index**2,
        }
        one = design(values["power"], lens=f"acme-lens-{index // 3}")
        one = replace(one, totals=replace(one.totals, cost=cost_at(values["cost"])))
        one.scenes[0].figures.update(snr_db=30.0 + index, gsd_mm=1.0 - 0.01 * index)
        made.append(
            FrontPoint(f"p{index + 1}", {n: values[n] for n in wanted}, f"c{index // 3}", "exact", one)
        )
    picks = [Pick("cheapest", "p1", "the least cost"), Pick("least power", f"p{points}", "the least power")]
    base = solved()
    values = {
        "status": "complete" if points else "infeasible", "mission": base.mission, "physics": base.physics,
        "objectives": [FrontObjective(name, *OBJECTIVES[name]) for name in wanted], "uwopt_version": "0.1.0",
        "points": made, "picks": picks if points else [],
        "methods": [
            FrontMethod("exact", "complete", 2.0, points, 0.8, None, None, 1000, None),
            FrontMethod("nsga2", "complete", 5.0, points, 0.796, 0.995, 0.01, 9000, 1, [[1.0, 0.5], [5.0, 0.796]]),
        ],
        "peers": [
            {"method": "nsga2", "values": {n: 1.05 * v for n, v in p.values.items()}, "hardware": ["a", "b", "c", "d"]}
            for p in made
        ],
        "reference": {"log": {"power": True, "cost": True, "information": False}},
        "certificate": {"scope": "3 cameras", "loaded": 100, "selected": 90, "evaluated": 40,
                        "discarded": [{"rule": "bound", "count": 60}]},
        "assumptions": base.assumptions, "timing_s": {"search": 2.0, "nsga2": 5.0, "total": 7.0},
        "versions": {"numpy": "2.4"}, "mission_file": {"name": "reef.yaml", "text": "name: Reef # <b>\n"},
    }  # fmt: skip
    return FrontResult(**values | changes)


@pytest.fixture
def make_front() -> Any:
    """The maker of fronts."""
    return front


@pytest.fixture
def make_result() -> Any:
    """The maker of results, and of their parts."""
    return solved


@pytest.fixture
def make_design() -> Any:
    """The maker of designs."""
    return design


@pytest.fixture
def make_scene() -> Any:
    """The maker of scenes."""
    return scene


@pytest.fixture
def make_margin() -> Any:
    """The maker of margins."""
    return margin

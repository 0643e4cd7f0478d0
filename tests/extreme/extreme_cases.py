"""Systems and missions of extreme numbers, and what no result may hold: NaN, infinity or a wrong sign."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import small_catalogues as small

from uwopt.catalog.parts.light import Light
from uwopt.catalog.records import exact
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.mission.mission import load_mission
from uwopt.objectives.objective import Objective
from uwopt.results.result import Result
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.exact.search import Search

MAY_BE_NEGATIVE = ("snr_db", "snr_db_min", "snr_db_p05", "snr_db_centre", "snr_red_below_green_db", "overlap",
                   "gain_db", "virtual_image_distance_m")  # fmt: skip
CAMERA = {
    "resolution_x_px": 2448, "resolution_y_px": 2048, "pixel_pitch_um": 3.45, "read_noise_e": 2.4,
    "saturation_e": 10_000, "quantum_efficiency": 0.6, "gain_dn_per_e": 0.35, "bit_depth": 12,
}  # fmt: skip
DOME = {"geometry": "dome", "outer_radius_mm": 100, "thickness_mm": 10, "refractive_index": 1.5}
FLAT = {"geometry": "flat", "gap_mm": 5, "thickness_mm": 10, "refractive_index": 1.5}


def mission(physics: str = "full", **sections: Any) -> dict[str, Any]:
    """A mission; `scene`, `vehicle`, `requirements`, `limits` on top of the usual."""
    return {
        "practice": "bare", "name": "extreme", "physics": physics,
        "scene": {"water": "II", "seafloor": 0.2, "depth_m": 2000, **sections.get("scene", {})},
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, **sections.get("vehicle", {})},
        "requirements": {"overlap": 0.3, "max_blur_px": 1.0, **sections.get("requirements", {})},
        "limits": sections.get("limits", {}),
    }  # fmt: skip


def system(**parts: Any) -> dict[str, Any]:
    """A system; `camera`, `lens`, `light`, `settings` on top of the usual, `port` instead of it."""
    return {
        "camera": {**CAMERA, **parts.get("camera", {})},
        "lens": {"focal_length_mm": 8, "f_number_min": 0.95, "f_number_max": 64, "transmission": 0.9,
                 **parts.get("lens", {})},
        "port": parts.get("port", DOME),
        "light": {"flux_lm": 10_000, "power_w": 100, "beam": "cosine-power", "beam_half_angle_deg": 40,
                  **parts.get("light", {})},
        "light_count": 1, "orientation": "portrait",
        "settings": {"f_number": 4.0, "exposure_ms": 1.0, **parts.get("settings", {})},
    }  # fmt: skip


def flat_water(folder: Path, *, a_per_m: float, b_per_m: float, kd_per_m: float | None = None) -> str:
    """A grey water."""
    kd = "" if kd_per_m is None else f",{kd_per_m}"
    rows = [f"{nm},{a_per_m},{b_per_m}{kd}" for nm in (380, 780)]
    head = "wavelength_nm,a_per_m,b_per_m" + ("" if kd_per_m is None else ",kd_per_m")
    return table(folder / "water.csv", [head, *rows])


def table(file: Path, rows: list[str]) -> str:
    """A CSV."""
    file.write_text("\n".join([*rows, ""]), encoding="utf-8")
    return str(file)


def assert_sound(result: Result) -> dict[str, Any]:
    """No NaN, no infinity, no wrong sign anywhere; a feasible design has no missed margin. Its figures."""
    assert not_finite(result.to_dict()) == []
    design = result.best
    assert design is not None
    for scene in design.scenes:
        wrong = {k: v for k, v in scene.figures.items()
                 if isinstance(v, float) and v < 0 and k not in MAY_BE_NEGATIVE}  # fmt: skip
        assert wrong == {}
        assert not any(isinstance(v, float) and v < 0 for k, v in scene.settings.items() if k != "gain_db")
    assert design.feasible == all(m.satisfied for scene in design.scenes for m in scene.margins)
    return design.scenes[0].figures


def missed(result: Result) -> set[str]:
    """Names of the margins that are missed."""
    assert result.best is not None
    return {m.requirement for scene in result.best.scenes for m in scene.margins if not m.satisfied}


def not_finite(value: Any, path: str = "") -> list[str]:
    """Where nested plain values hold NaN or infinity."""
    if isinstance(value, dict):
        return [bad for key, item in value.items() for bad in not_finite(item, f"{path}.{key}")]
    if isinstance(value, (list, tuple)):
        return [bad for index, item in enumerate(value) for bad in not_finite(item, f"{path}[{index}]")]
    return [path] if isinstance(value, float) and not math.isfinite(value) else []


# ---------------------------------------------------------------- catalogues


def one_of_each(**changes: Any) -> Parts:
    """A catalogue of one camera, lens, dome and light; `camera`, `lens`, `port`, `light` change them."""
    rng = np.random.default_rng(7)
    camera = replace(
        small.camera(rng, "camera"), mounts=("C",), shutter="global", saturation_e=exact(20_000.0), power_w=exact(2.0),
        dark_current_e_s=None, gain_dn_per_e=None, max_gain_db=exact(24.0), prnu_frac=None, black_level_dn=0.0,
        max_frame_rate_hz=exact(60.0), min_exposure_us=exact(1.0), max_exposure_us=exact(6e7),
    )  # fmt: skip
    lens = replace(
        small.lens(rng, "lens"), mounts=("C",), image_circle_mm=20.0, focal_length_mm=8.0, f_number_min=exact(0.95),
        f_number_max=exact(64.0), min_object_distance_m=None, aperture_control="manual",
    )  # fmt: skip
    dome = {"geometry": "dome", "outer_radius_mm": 80.0, "clear_diameter_mm": None, "thickness_mm": exact(10.0)}
    port = replace(small.port(rng, "port"), **dome)
    light = Light(
        id="light", price=exact(500.0), mass_g=exact(500.0), depth_rating_m=6000.0, beam_medium="water",
        beam_angle_deg=exact(80.0), flux_lm=exact(1e4), power_w=exact(100.0),
    )  # fmt: skip
    made = {"camera": camera, "lens": lens, "port": port, "light": light}
    return Parts(*((replace(part, **changes.get(kind, {})),) for kind, part in made.items()))  # type: ignore[arg-type]


def copies(parts: Parts, count: int, *, step_rel: float = 0.0) -> Parts:
    """Each part several times, prices and masses apart by a relative step."""

    def many(part: Any) -> tuple[Any, ...]:
        return tuple(
            replace(
                part, id=f"{part.id}-{i}", price=exact(part.price.value * (1 + i * step_rel)),
                mass_g=exact(part.mass_g.value * (1 + i * step_rel)),
            )
            for i in range(count)
        )  # fmt: skip

    return Parts(*(many(column[0]) for column in (parts.cameras, parts.lenses, parts.ports, parts.lights)))


def searched(parts: Parts, plain: dict[str, Any], objective: Any = "power", *, top: int = 4) -> Outcome:
    """The exact search over a catalogue. Less light than a float can hold is no light, as in `uwopt.solve`."""
    wanted = load_mission({"objective": objective, **plain})
    with np.errstate(under="ignore"):
        problem = Problem(wanted, parts, paper=wanted.physics == "paper")
        search = Search(problem, Objective.of(objective), top=top, progress=None)
        return search.run()

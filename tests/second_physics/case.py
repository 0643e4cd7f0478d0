"""A mission and a system of the second computation, and what uwopt says of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from kept_values import Kept
from numpy.typing import NDArray

import uwopt

Array = NDArray[np.float64]
DATA = Path(__file__).parents[2] / "uwopt" / "catalog" / "data"
REFERENCE = Path(__file__).parents[1] / "reference"
WAVES_NM = np.arange(380.0, 780.25, 0.5)  # finer than uwopt's own grid
STEPS_NM = np.r_[0.25, np.full(WAVES_NM.size - 2, 0.5), 0.25]
PLANCK_J_S, LIGHT_M_S, LUMENS_PER_W = 6.62607015e-34, 299_792_458.0, 683.002
BACK_SHARE = 0.0183  # b_b/b of the particles, unless the mission says otherwise
RAYS_NM = 550.0  # rays are traced for green light
HERE = Path(__file__).parent
#: Slow means, of these very files and the tables that they read; `python tests/kept_values.py` remakes them.
COMPUTED_BY = ("case", "tables", "lobes", "rays", "image")
TABLES = ("beam_profiles", "bottom_reflectance", "jerlov_iop", "photopic_v", "pure_water", "qe_curves")
KEPT = Kept(
    REFERENCE / "full_physics.json", *(HERE / f"{name}.py" for name in COMPUTED_BY),
    REFERENCE / "jerlov_iop_measured.csv", *(DATA / f"{name}.csv" for name in TABLES),
)  # fmt: skip


@dataclass(frozen=True)
class Lamp:
    """Place [m] in the vehicle frame and outward tilts [deg]."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    tilt_x: float = 0.0
    tilt_y: float = 0.0


@dataclass(frozen=True)
class Case:
    """A mission and a system; lengths in m, focal length in mm, angles in degrees."""

    water: str = "II"
    table: str = "solonenko-mobley"
    floor: float | str = 0.2
    altitude: float = 2.0
    temperature: float = 10.0
    salinity: float = 35.0
    dome: bool = True
    radius: float = 0.1
    thickness: float = 0.01
    n_glass: float = 1.5
    gap: float = 0.02
    focal_mm: float = 8.0
    f_number: float = 4.0
    portrait: bool = False
    lamps: tuple[Lamp, ...] = (Lamp(y=0.5),)
    beam: str = "cosine-power"
    half_angle: float = 40.0
    camera: tuple[tuple[str, Any], ...] = ()
    light: tuple[tuple[str, Any], ...] = ()
    settings: tuple[tuple[str, Any], ...] = ()
    needs: tuple[tuple[str, Any], ...] = ()
    tolerance: float = 0.0
    focus: float | None = None  # altitude in focus; the case's own unless given
    orders: bool = False  # light scattered more than once counts

    @property
    def camera_keys(self) -> dict[str, Any]:
        return {
            "resolution_x_px": 2448, "resolution_y_px": 2048, "pixel_pitch_um": 3.45, "read_noise_e": 2.4,
            "quantum_efficiency": "seed-imx250m", "gain_dn_per_e": 0.35, "bit_depth": 12,
        } | dict(self.camera)  # fmt: skip

    @property
    def flux_lm(self) -> float:
        return 4000.0 * len(self.lamps)

    def mission(self) -> dict[str, Any]:
        return {
            "practice": "bare", "name": "full", "physics": "full",
            "scene": {
                "water": self.water, "seafloor": self.floor, "depth_m": 50, "multiple_scattering": self.orders,
                **({} if self.water.endswith(".csv") else {"water_table": self.table}),
                "temperature_c": self.temperature, "salinity_psu": self.salinity,
            },
            "vehicle": {"altitude_m": self.altitude, "altitude_tolerance_m": self.tolerance, "speed_m_s": 0.3},
            "requirements": {"overlap": 0.3, "max_blur_px": 1.0, **dict(self.needs)},
        }  # fmt: skip

    def system(self) -> dict[str, Any]:
        port: dict[str, Any] = {"thickness_mm": self.thickness * 1e3, "refractive_index": self.n_glass}
        port |= {"geometry": "dome", "outer_radius_mm": self.radius * 1e3} if self.dome else {
            "geometry": "flat", "gap_mm": self.gap * 1e3,
        }  # fmt: skip
        shape = {"beam_profile": "dspl-sealite-flood", "beam": "tabulated", "beam_medium": "air"}
        if self.beam != "tabulated":
            shape = {"beam": self.beam, "beam_half_angle_deg": self.half_angle}  # type: ignore[dict-item]
        return {
            "camera": self.camera_keys,
            "lens": {"focal_length_mm": self.focal_mm, "transmission": 0.85},
            "port": port,
            "light": {"flux_lm": 4000, "power_w": 40, "spectrum": "generic-led", **shape, **dict(self.light)},
            "light_mounts": [
                {"x_m": a.x, "y_m": a.y, "z_m": a.z, "tilt_x_deg": a.tilt_x, "tilt_y_deg": a.tilt_y}
                for a in self.lamps
            ],
            "orientation": "portrait" if self.portrait else "landscape",
            "settings": {
                "f_number": self.f_number, "exposure_ms": 1.0, "gain": 1.0, "flux_lm": self.flux_lm,
                **dict(self.settings),
            },
        }  # fmt: skip


@cache
def scene(case: Case) -> Any:
    """What uwopt says."""
    result = uwopt.evaluate(case.mission(), case.system())
    assert result.physics["name"] == "full"
    assert result.design is not None
    return result.design.scenes[0]


def figures(case: Case) -> dict[str, Any]:
    return dict(scene(case).figures)


def gauss(low: float, high: float, count: int) -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return low + (nodes + 1) * (high - low) / 2, weights * (high - low) / 2

"""Which hardware is looked at beside the best that holds in the doubt: by hand, of two lenses and two tubes."""

from __future__ import annotations

import math
from typing import Any

from uwopt.catalog.records import Camera, Curve, Housing, Lens, Light, Port, exact
from uwopt.forward.enclosures import enclosed
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.mission.mission import load_mission
from uwopt.solvers.confidence.local_search import neighbours
from uwopt.solvers.exact.lightings import Lighting
from uwopt.solvers.exact.ranking import Found

MISSION: dict[str, Any] = {
    "practice": "bare", "physics": "paper", "scene": {"water": "II", "seafloor": 0.2, "depth_m": 100.0},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, "orientation": "landscape"}, "requirements": {"overlap": 0.3},
    "catalog": {"housing": "required"},
}  # fmt: skip
BODY = {"body_width_mm": 29.0, "body_height_mm": 29.0, "body_length_mm": 40.0, "plug_mm": 30.0}
CAMERA = Camera(
    "camera", resolution_x_px=2000, resolution_y_px=1000, pixel_pitch_um=5.0, mounts=("C",), read_noise_e=exact(5.0),
    saturation_e=exact(1e4), qe_curves={"mono": Curve((380.0, 780.0), (0.5, 0.5))}, max_frame_rate_hz=exact(30.0),
    bandwidth_mb_s=exact(400.0), bit_depth=12, power_w=exact(3.0), price=exact(900.0), mass_g=exact(90.0), inline=True,
    **{name: exact(value) for name, value in BODY.items()},
)  # fmt: skip
PORT = Port(
    "dome", geometry="dome", outer_radius_mm=50.0, thickness_mm=exact(5.0), price=exact(200.0), mass_g=exact(300.0),
    depth_rating_m=1000.0,
)  # fmt: skip


def lens(name: str, length_mm: float) -> Lens:
    """A lens of this length, its pupil 10 mm behind its front."""
    return Lens(
        name, focal_length_mm=10.0, mounts=("C",), f_number_min=1.4, f_number_max=exact(16.0), inline=True,
        image_circle_mm=16.0, length_mm=exact(length_mm), diameter_mm=exact(30.0), pupil_mm=exact(10.0),
        min_object_distance_m=exact(0.05), price=exact(300.0), mass_g=exact(80.0),
    )  # fmt: skip


def tube(name: str, length_mm: float, price: float) -> Housing:
    """A tube that takes the dome."""
    return Housing(
        name, inner_diameter_mm=100.0, inner_length_mm=length_mm, outer_diameter_mm=exact(110.0),
        outer_length_mm=exact(length_mm + 50.0), price=exact(price), mass_g=exact(2e3 * price / 700.0),
        depth_rating_m=300.0, ports=("dome",),
    )  # fmt: skip


def test_another_lens_may_take_a_longer_tube() -> None:
    # L - 10 + 40 + 30 + 2 mm: a lens of 30 mm needs 92 mm of tube and fits into 100, one of 60 mm needs 122 of 250
    lamp = Light("lamp", flux_lm=exact(1e4), power_w=exact(100.0), beam_angle_deg=exact(80.0), depth_rating_m=500.0)
    ports = enclosed([PORT], [tube("short", 100.0, 700.0), tube("long", 250.0, 900.0)])
    parts = Parts((CAMERA,), (lens("compact", 30.0), lens("slender", 60.0)), ports, (lamp,))
    problem = Problem(load_mission(MISSION), parts, paper=True)
    found = Found(
        imager=0, camera=0, lens=0, port=0, landscape=True, light=0, count=1, minimised=math.nan, power_w=math.nan,
        lighting=Lighting(0, 0, problem.mounts[0]), cost=math.nan, mass_kg=math.nan, snr_db=math.nan, settings=[],
        pulse_s=0.0,
    )  # fmt: skip
    near = {(one.lens, one.port) for one in neighbours(problem, found)}
    assert (1, 1) in near  # the slender lens in the long tube
    assert (1, 0) not in near  # into the short one it does not go

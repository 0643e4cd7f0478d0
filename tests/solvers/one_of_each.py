"""One camera, lens, port and lamp with round numbers, so that what they give is worked out by hand.

2000 x 1500 pixels of 4 um (8 by 6 mm, diagonal 10 mm) behind 8 mm and a dome of 80 mm, landscape, 2 m above the
floor, so 2.08 m from the dome's centre: tangents 0.5 and 0.375, footprint 2.08 m across and 1.56 m along, pixels of
1.04 mm. Focused through the dome the lens is sure to see 1 - f D = 1 / (1 + m) of that. At 0.3 m/s and 30 % overlap
0.3 / (1.56 * 0.7 (1 - f D)) = 0.284 images/s of 4.5 MB. Without lamp 1800 USD, 0.8 kg,
3 W; the lamp takes 500 USD and 0.5 kg.
"""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

from random_cases import Case
from small_catalogues import MONO

from uwopt.catalog.parts.camera import Camera
from uwopt.catalog.parts.lens import Lens
from uwopt.catalog.parts.light import Light
from uwopt.catalog.parts.port import Port
from uwopt.catalog.records import exact
from uwopt.forward.parts import Parts
from uwopt.forward.scene import scene_optics
from uwopt.mission.mission import load_mission
from uwopt.objectives.objective import Objective

DISTANCE_M, RADIUS_M, GLASS_M, N_GLASS = 2.08, 0.08, 0.01, 1.5

CAMERA = Camera(
    id="camera", price=exact(1000.0), mass_g=exact(200.0), mounts=("C",), colour="mono", resolution_x_px=2000,
    resolution_y_px=1500, pixel_pitch_um=4.0, shutter="global", max_frame_rate_hz=exact(100.0), bit_depth=12,
    read_noise_e=exact(2.0), saturation_e=exact(20_000.0), gain_dn_per_e=None, gain_bits=12,
    max_gain_db=exact(24.0), black_level_dn=0.0, min_exposure_us=exact(10.0), max_exposure_us=exact(1e6),
    exposure_offset_us=exact(0.0), prnu_frac=exact(0.0), power_w=exact(3.0), qe_curves={"mono": MONO},
)  # fmt: skip
LENS = Lens(
    id="lens", price=exact(500.0), mass_g=exact(100.0), focal_length_mm=8.0, f_number_min=exact(2.0),
    f_number_max=exact(16.0), aperture_control="manual", image_circle_mm=11.0, mounts=("C",),
    transmission_frac=exact(0.9), min_object_distance_m=exact(0.1), rated_pixel_pitch_um=3.45,
)  # fmt: skip
DOME = Port(
    id="dome", price=exact(300.0), mass_g=exact(500.0), depth_rating_m=6000.0, refractive_index=exact(1.5),
    thickness_mm=exact(10.0), geometry="dome", outer_radius_mm=80.0,
)  # fmt: skip
FLAT = replace(DOME, id="flat", geometry="flat", outer_radius_mm=None, gap_mm=50.0, clear_diameter_mm=70.0)
LAMP = Light(
    id="lamp", kind="continuous", price=exact(500.0), mass_g=exact(500.0), depth_rating_m=6000.0,
    spectrum_id="generic-led", output_factor=exact(1.0), flux_lm=exact(30_000.0), power_w=exact(300.0),
    beam="cosine-power", beam_angle_deg=exact(80.0), beam_medium="water",
)  # fmt: skip


def virtual_image_m(n_water: float) -> float:
    """Where the dome shows a floor at 2 m, from its centre (physics page, section 4)."""
    power = 1.0 / (n_water * DISTANCE_M) + (1.0 / N_GLASS - 1.0 / n_water) / RADIUS_M
    return 1.0 / (power + (1.0 - 1.0 / N_GLASS) / (RADIUS_M - GLASS_M))


PLAIN_SCENE = {"water": "II", "seafloor": 0.2, "depth_m": 100.0}
PLAIN_MISSION = {"practice": "bare", "scene": PLAIN_SCENE, "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3}}
N_WATER = scene_optics(load_mission(PLAIN_MISSION).views[0], paper=False).n_water
CLOSER = 1.0 - 8e-3 / virtual_image_m(N_WATER)  # of its field a lens focused there is sure to see
COVERED_M = DISTANCE_M * CLOSER
RATE_HZ = 0.3 / (1.56 * CLOSER * 0.7)


def changed(part: Any, changes: dict[str, Any]) -> Any:
    """A part with other numbers, exact where its field is a quantity."""
    quantities = {f.name for f in fields(part) if "Quantity" in str(f.type)}
    given = {
        name: exact(value) if name in quantities and isinstance(value, float) else value
        for name, value in changes.items()
    }
    return replace(part, **given)


def one(
    objective: Any = "power", *, camera: Any = (), lens: Any = (), port: Any = (), light: Any = (), flat: bool = False,
    wanted: Any = (), limits: Any = (), catalog: Any = (), vehicle: Any = (), scenes: Any = ({},),
    physics: str = "full",
) -> Case:  # fmt: skip
    """The one design with what a test changes."""
    plain = {
        "practice": "bare",
        "objective": objective, "physics": physics, "limits": dict(limits), "catalog": dict(catalog),
        "requirements": {"overlap": 0.3, "min_snr_db": 20.0, **dict(wanted)},
        "vehicle": {
            "altitude_m": 2.0, "speed_m_s": 0.3, "orientation": "landscape", "light_count": 1, **dict(vehicle)
        },
        "scenes": [
            {"name": f"scene {i}", **PLAIN_SCENE, **given}
            for i, given in enumerate(scenes)
        ],
    }  # fmt: skip
    parts = Parts(
        (changed(CAMERA, dict(camera)),), (changed(LENS, dict(lens)),),
        (changed(FLAT if flat else DOME, dict(port)),), (changed(LAMP, dict(light)),),
    )  # fmt: skip
    return Case(parts, load_mission(plain), Objective.of(objective))


def with_parts(case_: Case, **more: Any) -> Case:
    """With further parts beside the one: `cameras`, `lenses`, `ports`, `lights`, each a list of changes."""
    firsts = {kind: getattr(case_.parts, kind) for kind in ("cameras", "lenses", "ports", "lights")}
    for kind, changes in more.items():
        first = firsts[kind][0]
        firsts[kind] += tuple(
            replace(changed(first, dict(given)), id=f"{first.id}-{i}") for i, given in enumerate(changes)
        )
    return replace(case_, parts=Parts(**firsts))

"""A camera that looks ahead: footprint, pixels, blur, depth of field, sun and horizon of its pitch, by hand."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from dome_system import BEHIND_DOME

from uwopt.api.evaluating import evaluate
from uwopt.errors import MissionError
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.assembly import system_problem
from uwopt.forward.scene import scene_optics
from uwopt.forward.scene_checks import check_physical
from uwopt.forward.sun_light import SunField
from uwopt.forward.views import image_places, tilted_places
from uwopt.mission.mission import load_mission
from uwopt.mission.system import load_system
from uwopt.report.text.frame import frame_facts
from uwopt.report.text.looked_at import wording
from uwopt.results.design import SceneResult

PITCH = math.radians(40.0)
HEIGHT_M, RADIUS_M, TOLERANCE_M = 2.0, 0.05, 0.2
ALONG, ACROSS = 800 * 5e-3 / 2 / 8, 1000 * 5e-3 / 2 / 8  # tangents of the half angles
PIXEL = 5e-3 / 8
MISSION: dict[str, Any] = {
    "practice": "bare", "physics": "full",
    "scene": {"water": "II", "seafloor": 0.2, "depth_m": 10},
    "vehicle": {
        "altitude_m": HEIGHT_M, "altitude_tolerance_m": TOLERANCE_M, "pitch_deg": 40.0, "speed_m_s": 0.1,
        "orientation": "landscape",
    },
    "requirements": {"overlap": 0.5, "max_blur_px": 1.0, "max_gsd_mm": 10.0},
}  # fmt: skip
SYSTEM: dict[str, Any] = {**BEHIND_DOME, "light_count": 2}
N_WATER, N_DOME = scene_optics(load_mission(MISSION).views[0], paper=False).n_water, 1.5


def closer(focal_m: float = 8e-3, pitch_rad: float = PITCH) -> float:
    """1 - f D = 1 / (1 + m): the share of its field that a lens keeps when it is focused through the dome."""
    faces = (1.0 / N_DOME - 1.0 / N_WATER) / RADIUS_M + (1.0 - 1.0 / N_DOME) / 0.045
    return 1.0 - focal_m * (faces + 1.0 / (N_WATER * (HEIGHT_M / math.cos(pitch_rad) + RADIUS_M)))


def seen(
    vehicle: dict[str, Any] | None = None, scene: dict[str, Any] | None = None, system: dict[str, Any] | None = None,
    **asked: Any,
) -> SceneResult:  # fmt: skip
    """The scene as the system takes it."""
    made = {
        **MISSION, "vehicle": {**MISSION["vehicle"], **(vehicle or {})}, "scene": {**MISSION["scene"], **(scene or {})},
        "requirements": {**MISSION["requirements"], **asked},
    }  # fmt: skip
    design = evaluate(made, system or SYSTEM).design
    assert design is not None
    return design.scenes[0]


@cache
def as_asked() -> SceneResult:
    """The scene with nothing changed."""
    return seen()


def margin(found: SceneResult, name: str) -> Any:
    """One of the margins."""
    return next(one for one in found.margins if one.requirement == name)


def on_floor(u: float, v: float, height_m: float = HEIGHT_M) -> np.ndarray:
    """Where the pinhole in the dome's centre sees a field point on the level floor, by plane trigonometry."""
    down = math.cos(PITCH) - u * math.sin(PITCH)
    high = height_m + RADIUS_M * math.cos(PITCH)  # the centre lies behind the vertex
    return np.array([math.sin(PITCH) + u * math.cos(PITCH), v]) * high / down


def in_image(place: np.ndarray, height_m: float = HEIGHT_M) -> np.ndarray:
    """The field point of a place on the floor: the inverse."""
    high = height_m + RADIUS_M * math.cos(PITCH)
    ahead = place[0] * math.sin(PITCH) + high * math.cos(PITCH)
    return np.array([place[0] * math.cos(PITCH) - high * math.sin(PITCH), place[1]]) / ahead


def test_footprint_is_the_trapezoid_of_height_and_angles() -> None:
    figures = as_asked().figures
    along, across = ALONG * closer(), ACROSS * closer()
    depth = on_floor(along, 0)[0] - on_floor(-along, 0)[0]
    near, far = (2 * on_floor(s * along, across)[1] for s in (-1, 1))
    assert figures["fov_y_m"] == pytest.approx(depth, rel=1e-12)
    assert figures["swath_m"] == figures["swath_near_m"] == pytest.approx(near, rel=1e-12)
    assert figures["swath_far_m"] == pytest.approx(far, rel=1e-12)
    # half of each image is seen again after depth / 2 at 0.1 m/s
    assert figures["frame_rate_min_hz"] == pytest.approx(0.1 / (0.5 * depth), rel=1e-12)
    assert figures["range_centre_m"] == pytest.approx(HEIGHT_M / math.cos(PITCH), rel=1e-12)


def test_the_largest_pixel_lies_in_the_far_corner() -> None:
    found, half = as_asked(), 1e-6
    for height_m, value in ((HEIGHT_M, found.figures["gsd_mm"]), (HEIGHT_M + 0.2, margin(found, "max_gsd_mm").value)):
        step = on_floor(ALONG + half, ACROSS, height_m) - on_floor(ALONG - half, ACROSS, height_m)
        assert value == pytest.approx(np.hypot(*step) / (2 * half) * PIXEL * 1e3, rel=1e-6)
    assert margin(found, "max_gsd_mm").at_altitude_m == pytest.approx(HEIGHT_M + 0.2)  # told as a height


@pytest.mark.parametrize(("end", "u"), [("near", -ALONG), ("centre", 0.0), ("far", ALONG)])
def test_pixel_and_way_of_each_end_are_those_of_its_ray(end: str, u: float) -> None:
    figures, half = as_asked().figures, 1e-6
    along = np.hypot(*(on_floor(u + half, 0.0) - on_floor(u - half, 0.0)))
    assert figures[f"gsd_{end}_mm"] == pytest.approx(along / (2 * half) * PIXEL * 1e3, rel=1e-6)  # across it is less
    high = HEIGHT_M + RADIUS_M * math.cos(PITCH)
    assert figures[f"range_{end}_m"] == pytest.approx(math.hypot(high, on_floor(u, 0.0)[0]) - RADIUS_M, rel=1e-12)


def test_the_near_corner_blurs_most() -> None:
    found, way = as_asked(), np.array([0.1 * 5e-3, 0.0])
    for height_m, value in ((HEIGHT_M, found.figures["blur_px"]), (HEIGHT_M - 0.2, margin(found, "max_blur_px").value)):
        moved = [
            np.hypot(*(in_image(on_floor(u, v, height_m) + way, height_m) - np.array([u, v]))) / (PIXEL * closer())
            for u in closer() * np.linspace(-ALONG, ALONG, 9) for v in closer() * np.linspace(-ACROSS, ACROSS, 9)
        ]  # fmt: skip
        assert value == pytest.approx(max(moved), rel=1e-3)  # of a step as long as the blur


@pytest.mark.parametrize("pitch_deg", [0.0, 40.0, 60.0])
def test_a_camera_that_nods_blurs_by_its_own_turn_whatever_the_pitch(pitch_deg: float) -> None:
    """A turn by w moves the image's middle by w over a pixel's angle; through a long lens hardly more elsewhere."""
    long = {**SYSTEM, "lens": {**SYSTEM["lens"], "focal_length_mm": 80}}
    nodding, still = (
        seen({"pitch_deg": pitch_deg, "pitch_rate_deg_s": rate}, system=long).figures["blur_px"] for rate in (3.0, 0.0)
    )
    turned_px = math.radians(3.0) * 5e-3 / (PIXEL / 10 * closer(0.08, math.radians(pitch_deg)))
    assert turned_px <= (nodding - still) * (1 + 1e-9) <= 1.1 * turned_px


def test_what_is_near_and_what_is_far_in_the_frame_must_both_be_sharp() -> None:
    """Corners lie at other ranges than the axis: their images are those of a square plane so far away."""
    mission = load_mission({**MISSION, "requirements": {**MISSION["requirements"], "dof_at": "corner"}})
    problem, hardware = assembled_system(mission)
    model = DesignModel(problem, hardware)
    scene, shape, view = problem.scenes[0], model.shapes[0], model.views[0]
    u, v, slope = 0.8 * ALONG, 0.8 * ACROSS, math.tan(PITCH)
    places = tilted_places(scene, shape, view.tan_along, view.tan_across, 0.8)
    square = image_places(scene, shape, np.array([math.hypot(u, v)]))
    for at, sign in ((slice(0, 2), -1.0), (slice(2, 4), 1.0)):
        for range_m in (1.5, 3.0):
            there = (range_m + slope * RADIUS_M * sign * u) / (1.0 - slope * sign * u)
            expected = square[..., 0] + square[..., 1] / (there + square[..., 2])
            own = places[:, at]
            assert own[..., 0] + own[..., 1] / (range_m + own[..., 2]) == pytest.approx(expected, rel=1e-12)
    corner, axis = (seen(dof_at=where, min_dof_m=0.1) for where in ("corner", "axis"))
    assert corner.figures["dof_near_m"] > 1.1 * axis.figures["dof_near_m"]


def assembled_system(mission: Any) -> tuple[Any, Any]:
    """The problem of the one system and its hardware."""
    return system_problem(mission, load_system(SYSTEM))


def test_a_frame_that_reaches_too_near_to_the_horizon_is_refused() -> None:
    ahead = margin(as_asked(), "horizon")
    assert ahead.satisfied and ahead.value == pytest.approx(1 / (1 - math.tan(PITCH) * ALONG), rel=1e-12)
    # 1 / (1 - tan(pitch) tan(half)) = 5 at tan(pitch) = 0.8 / 0.25
    steepest = math.degrees(math.atan(0.8 / ALONG))
    beyond = margin(seen({"pitch_deg": steepest + 0.1}), "horizon")
    assert beyond.limit == 5.0 and beyond.value == pytest.approx(5.0, rel=0.05) and not beyond.satisfied
    assert margin(seen({"pitch_deg": 80.0}), "horizon").value == 1e3  # the upper edge sees no floor at all


def test_daylight_from_an_oblique_floor_loses_what_its_way_takes() -> None:
    """Floor and path of single pixels, each worked out anew; the field goes by polynomials in the ray's angle."""
    mission = load_mission({**MISSION, "scene": {**MISSION["scene"], "sun_lux": 50_000.0}})
    problem, hardware = assembled_system(mission)
    model = DesignModel(problem, hardware)
    scene = problem.scenes[0]
    field = SunField(problem, 0, port_index=hardware.port, efficiency=0)
    places = ((0.0, 0.0), (ALONG, ACROSS), (-ALONG, 0.1))
    u, v = (np.array([[place[k] for place in places]]) for k in (0, 1))
    found = field.at_points(model.views[0], u, v)[scene.nominal][0]
    for (a, b), (floor, forward, path_e) in zip(places, found, strict=True):
        hit = on_floor(a, b)
        high = HEIGHT_M + RADIUS_M * math.cos(PITCH)
        away = math.sqrt(high**2 + hit @ hit)
        path = away - RADIUS_M
        collected = float(model.views[0].collecting_m2[0]) / (1 + a * a + b * b) ** 2
        weight = field.electrons(field.at_floor() * scene.reflectance / math.pi)
        expected = (weight * np.exp(-scene.attenuation_per_m * path)).sum() * collected
        veiled = (weight * np.exp(-scene.sun_leg_per_m() * path)).sum() * collected
        assert floor == pytest.approx(expected, rel=1e-6)
        assert forward == pytest.approx(veiled - expected, rel=1e-5)
        seen_path = field.path_electrons(np.array([path]), np.array([high / away]))[0] * collected
        assert path_e == pytest.approx(seen_path, rel=1e-4)


@pytest.mark.parametrize(("changed", "told"), [
    ({"physics": "paper"}, "vehicle.pitch_deg = 40: physics paper looks square at its floor"),
    (
        {"scene": {**MISSION["scene"], "target": "mid_water"}, "requirements": {"frame_interval_s": 1.0}},
        "vehicle.pitch_deg = 40 is of floor, wall or ceiling, and target: mid_water has none",
    ),
    ({"vehicle": {**MISSION["vehicle"], "pitch_deg": 85}}, "vehicle.pitch_deg = 85 is"),
    (
        {"vehicle": {**MISSION["vehicle"], "light_mounts": [{"x_m": -2.0, "z_m": 1.2}], "light_count": 1}},
        "vehicle.light_mounts[0].z_m = 1.2 m puts the lamp on or below the floor",
    ),
])  # fmt: skip
def test_what_cannot_be_is_told_in_one_message(changed: dict[str, Any], told: str) -> None:
    with pytest.raises(MissionError) as caught:
        check_physical(load_mission({**MISSION, **changed}))
    assert told in str(caught.value) and "\n" not in str(caught.value)


def test_a_report_tells_of_near_and_far_and_where_lamps_aim() -> None:
    facts = dict(frame_facts([as_asked()]))
    assert facts["middle of the view"].startswith("2.61 m away")
    assert set(facts) >= {"near edge of the view", "far edge of the view"}
    assert "near edge of the view" not in dict(frame_facts([seen({"pitch_deg": 0.0})]))
    ahead, level = ({"vehicle": {"pitch_deg": pitch}, "scenes": [{}]} for pitch in (40.0, 0.0))
    assert wording(ahead)("0.5 m, aimed straight down") == "0.5 m, aimed where the camera looks"
    assert wording(level)("aimed straight down") == "aimed straight down"

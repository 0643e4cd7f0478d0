"""The rig is drawn to scale, and told to those who cannot see it."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

import uwopt
from uwopt.evaluation.recompute import replay
from uwopt.report.pictures import drawing, oblique_drawing
from uwopt.report.pictures.curves import Lamp, RigMeasures, rig_measures
from uwopt.report.pictures.design_pictures import drawings

PROBLEMS = Path(__file__).parents[2] / "problems"
SVG = "{http://www.w3.org/2000/svg}"
RIG = RigMeasures(
    altitude_m=2.0, altitude_tolerance_m=0.25, half_along_m=0.4, half_across_m=0.7, is_dome=True, outer_radius_m=0.06,
    lamps=(Lamp(0.0, 0.8, 0.0, (0.0, math.sin(0.1), math.cos(0.1))), Lamp(0.0, -0.8, 0.0, (0.0, 0.0, 1.0))),
    beam_half_angle_rad=math.radians(30.0), beam_ends_sharply=False, image_width_is_along=False, speed_m_s=0.5,
    advance_m=0.3, overlap=0.625, camera_count=1,
)  # fmt: skip


def shapes(text: str, kind: str, style: str) -> list[dict[str, str]]:
    root = ElementTree.fromstring(text)
    assert root.tag == f"{SVG}svg"
    assert root.get("role") == "img"
    assert root.find(f"{SVG}title") is not None
    assert root.find(f"{SVG}desc") is not None
    return [dict(node.attrib) for node in root.iter(f"{SVG}{kind}") if node.get("class") == style]


def points(shape: dict[str, str]) -> np.ndarray:
    return np.array([[float(v) for v in pair.split(",")] for pair in shape["points"].split()])


def test_seen_from_above_everything_has_one_scale():
    text = drawing.view_from_above(RIG, title="a", description="b")
    (view,), (after,), (shared,) = (shapes(text, "polygon", name) for name in ("view", "next", "shared"))
    size = np.ptp(points(view), axis=0)
    scale = size[0] / 1.4
    assert size[1] == pytest.approx(0.8 * scale, abs=0.2)
    assert points(view)[0][1] - points(after)[0][1] == pytest.approx(0.3 * scale, abs=0.2)  # forward is up
    assert np.ptp(points(shared), axis=0)[1] == pytest.approx(0.625 * 0.8 * scale, abs=0.2)
    lamps = sorted(float(c["cx"]) for c in shapes(text, "circle", "solid") if c["r"] == "5")
    assert lamps[1] - lamps[0] == pytest.approx(1.6 * scale, abs=0.2)


def test_seen_from_behind_beams_open_by_their_angle():
    text = drawing.view_from_behind(RIG, title="a", description="b")
    view = points(shapes(text, "polygon", "view")[0])
    scale = (view[2][0] - view[1][0]) / 1.4
    level = points(shapes(text, "polygon", "beam")[1])  # straight down, 30 deg: 2 m * tan 30 deg to each side
    assert level[2][0] - level[1][0] == pytest.approx(2 * 2.0 * math.tan(math.radians(30)) * scale, abs=0.3)
    leaning = points(shapes(text, "polygon", "beam")[0])
    assert leaning[2][0] - leaning[0][0] == pytest.approx(
        2.0 * math.tan(math.radians(30) + 0.1) * scale, abs=0.3
    )


def test_ring_of_a_level_beam_is_a_circle():
    ring = drawing.beam_ring(RIG, RIG.lamps[1])
    radius = [math.hypot(x, y + 0.8) for x, y in ring]
    assert radius == pytest.approx([2.0 * math.tan(math.radians(30))] * len(ring))


def test_drawings_escape_what_they_are_told():
    text = drawing.view_from_above(RIG, title='<script>"&', description="</svg><b>")
    assert "<script" not in text
    assert "<b>" not in text
    shapes(text, "polygon", "view")


@pytest.mark.parametrize(("rig", "view"), [
    (RIG, drawing.view_from_behind), ("pitched", oblique_drawing.view_from_side),
])  # fmt: skip
def test_a_camera_that_looks_up_stands_below_what_it_sees_and_its_words_upright(rig: Any, view: Any) -> None:
    rig = replace(PITCHED if rig == "pitched" else rig, looks_up=True)
    found = dict[str, list[tuple[float, float]]]()  # where things stand on the page, down, and which way they turn
    walk(ElementTree.fromstring(view(rig, title="a", description="b")), (1.0, 0.0), found)
    floor_y = max(y for y, _ in found["ink"][:1])
    assert all(y > floor_y + 100.0 for y, _ in found["view"][:1])  # the port, of which the view begins
    assert all(way == 1.0 for _, way in found["label"]) and all(way == -1.0 for _, way in found["view"])
    assert [drawn.caption.count("The camera looks up.") for drawn in drawings(rig, on_axis=False)] == [1, 0]


def walk(node: Any, flip: tuple[float, float], found: dict[str, list[tuple[float, float]]]) -> None:
    """Take in where what a drawing shows begins on the page, through all that mirrors it."""
    if mirror := re.match(r"matrix\(1 0 0 -1 0 ([\d.]+)\)", node.get("transform", "")):
        flip = -flip[0], flip[0] * float(mirror[1]) + flip[1]
    y = node.get("y") or node.get("y1") or (node.get("points") or "").split(" ")[0].partition(",")[2]
    if y and (style := node.get("class")):
        found.setdefault(style, []).append((flip[0] * float(y) + flip[1], flip[0]))
    for child in node:
        walk(child, flip, found)


def test_a_ceiling_is_seen_from_below(replayed: Any) -> None:
    mission = yaml.safe_load((PROBLEMS / "awi-ofobs.yaml").read_text("utf-8"))
    overhead = mission | {"scene": mission["scene"] | {"target": "ceiling"}}
    design, _ = replayed(overhead, PROBLEMS / "awi-ofobs.system.yaml")
    assert rig_measures(design).looks_up


@pytest.mark.parametrize("change", [
    {"speed_m_s": 0.0, "advance_m": None, "overlap": None}, {"advance_m": 5.0, "overlap": -5.25}, {"is_dome": False},
    {"beam_half_angle_rad": 1.57}, {"altitude_tolerance_m": 0.0, "image_width_is_along": True},
    {"lamps": (Lamp(0.5, 0.0, -0.4, (0.6, 0.0, 0.8)),)},
])  # fmt: skip
def test_drawings_stand_for_odd_rigs(change):
    rig = RigMeasures(**{**vars(RIG), **change})
    for view in (drawing.view_from_behind, drawing.view_from_above):
        text = view(rig, title="a", description="b")
        shapes(text, "polygon", "view")
        assert "nan" not in text
        assert not re.search(r'"-?\d{6,}', text)


def test_measures_of_a_replayed_rig_can_be_drawn(replayed):
    design, _ = replayed(PROBLEMS / "awi-ofobs.yaml", PROBLEMS / "awi-ofobs.system.yaml")
    assert not rig_measures(design).looks_up
    text = drawing.view_from_behind(rig_measures(design), title="a", description="b")
    assert "altitude" in text


#: 40 deg ahead at 2 m, 15 deg to each side: edges 2 tan 25 deg and 2 tan 55 deg ahead.
NEAR_M, FAR_M = 2.0 * math.tan(math.radians(25)), 2.0 * math.tan(math.radians(55))
PITCHED = RigMeasures(**{
    **vars(RIG), "pitch_rad": math.radians(40), "edges_m": ((NEAR_M, 0.5), (FAR_M, 0.9)), "is_dome": False,
    "outer_radius_m": 0.0, "lamps": (Lamp(0.0, 0.5, 0.0, (0.0, 0.0, 1.0)),),
})  # fmt: skip


def test_seen_from_the_side_view_and_beam_are_turned_by_the_pitch():
    text = oblique_drawing.view_from_side(PITCHED, title="a", description="b")
    (view,), (beam,) = (points(shapes(text, "polygon", name)[0]) for name in ("view",)), shapes(text, "polygon", "beam")
    scale = (view[2][0] - view[1][0]) / (FAR_M - NEAR_M)
    assert view[1][1] - view[0][1] == pytest.approx(2.0 * scale, abs=0.2)  # the altitude
    assert view[1][0] - view[0][0] == pytest.approx(NEAR_M * scale, abs=0.2)
    lit = points(beam)  # 30 deg to each side of 40 deg
    assert lit[1][0] - lit[0][0] == pytest.approx(2.0 * math.tan(math.radians(10)) * scale, abs=0.3)
    assert lit[2][0] - lit[0][0] == pytest.approx(2.0 * math.tan(math.radians(70)) * scale, abs=0.3)
    assert "looks 40° ahead" in text and "rotate(-40.0" in text


def test_seen_from_above_the_view_is_a_trapezoid():
    text = oblique_drawing.trapezoid_from_above(PITCHED, title="a", description="b")
    view, after = (points(shapes(text, "polygon", name)[0]) for name in ("view", "next"))
    scale = (view[1][0] - view[0][0]) / 1.0
    assert view[2][0] - view[3][0] == pytest.approx(1.8 * scale, abs=0.2)
    assert view[0][1] - view[3][1] == pytest.approx((FAR_M - NEAR_M) * scale, abs=0.2)
    assert view[0][1] - after[0][1] == pytest.approx(0.3 * scale, abs=0.2)


def test_edges_of_a_pitched_view_by_hand():
    # 1000 x 800 pixels of 5 um behind 10 mm and a flat port of no thickness: 14.04 deg in air, 10.4 deg in water
    mission: dict[str, Any] = {
        "practice": "bare", "scene": {"water": "II", "seafloor": 0.2, "depth_m": 10, "temperature_c": 10},
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.1, "pitch_deg": 40.0}, "requirements": {"overlap": 0.3},
    }  # fmt: skip
    system = {
        "camera": {"resolution_x_px": 1000, "resolution_y_px": 1000, "pixel_pitch_um": 5.0, "qe": 0.5,
                   "read_noise_e": 5.0, "saturation_e": 10_000, "max_frame_rate_hz": 30},
        "lens": {"focal_length_mm": 10.0}, "port": {"geometry": "flat", "thickness_mm": 0.01},
        "light": {"flux_lm": 5000, "power_w": 50, "beam_angle_deg": 80}, "light_baseline_m": 0.5,
        "settings": {"f_number": 4.0, "exposure_ms": 1.0, "gain": 1.0},
    }  # fmt: skip
    result = uwopt.evaluate(mission, system)
    rig = rig_measures(replay(result.mission, result.best, physics=result.physics, system=result.system))
    half = math.asin(math.sin(math.atan(0.25)) / 1.341)
    (near, _), (far, _) = rig.edges_m
    assert rig.altitude_m == pytest.approx(2.0)
    assert near == pytest.approx(2.0 * math.tan(math.radians(40) - half), rel=0.02)  # corner rays bend a little more
    assert far == pytest.approx(2.0 * math.tan(math.radians(40) + half), rel=0.02)


@pytest.mark.parametrize(("advance_m", "told"), [(0.3, True), (None, False), (50.0, False)])
@pytest.mark.parametrize("rig", [RIG, PITCHED])
def test_the_next_image_is_told_of_where_it_is_drawn(rig: RigMeasures, advance_m: float | None, told: bool) -> None:
    moved = RigMeasures(**{**vars(rig), "advance_m": advance_m})
    above = next(one for one in drawings(moved, on_axis=False) if one.id == "rig-above")
    assert ("next image" in above.caption) == told == bool(shapes(above.content, "polygon", "next"))

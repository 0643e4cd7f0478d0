"""A rig that looks ahead, drawn to scale as SVG text: pitched as it stands from the side, its trapezoid from above.

Lamps turn with the camera: places and aims are those of `RigMeasures`, before the port along its axis.
"""

from __future__ import annotations

from math import atan2, cos, degrees, sin, tan

from uwopt.report.pictures.curves import RigMeasures
from uwopt.report.pictures.drawing import (
    EDGE_PX,
    STEEPEST_RAD,
    WIDTH_PX,
    PageFrame,
    as_it_looks,
    camera_symbol,
    clip,
    level_dimension,
    line,
    metres,
    motion_arrow,
    page_frame,
    polygon,
    scale_bar,
    svg,
    text,
    tilted_box,
    upright_dimension,
)

Place = tuple[float, float]


def turned(rig: RigMeasures, ahead_m: float, out_m: float) -> Place:
    """Forward and down [m] of a place ahead of the port's axis, and out along it."""
    c, s = cos(rig.pitch_rad), sin(rig.pitch_rad)
    return ahead_m * c + out_m * s, out_m * c - ahead_m * s


def view_from_side(rig: RigMeasures, *, title: str, description: str) -> str:
    """Port, lamps and view in the plane of the motion, down to the floor; forward is to the right."""
    floor_m, (near_m, _), (far_m, _) = rig.altitude_m, *rig.edges_m
    lamps = [(*turned(rig, lamp.x_m, lamp.z_m), atan2(*turned(rig, lamp.aim[0], lamp.aim[2]))) for lamp in rig.lamps]
    left = min([-0.15 * floor_m, near_m, *(x for x, *_ in lamps)]) - 0.05 * floor_m
    top = min([-0.2 * floor_m, *(y - 0.05 * floor_m for _, y, _ in lamps)])
    frame = page_frame(left, far_m * 1.04, top, floor_m)
    floor_y = frame.y(floor_m)
    parts = [clip("side", 0.0, 0.0, WIDTH_PX, floor_y)]
    for x, y, leaning in lamps:
        edges = (max(-STEEPEST_RAD, min(STEEPEST_RAD, leaning + side * rig.beam_half_angle_rad)) for side in (-1, 1))
        hits = [(frame.x(x + (floor_m - y) * tan(angle)), floor_y) for angle in edges]
        parts.append(polygon([(frame.x(x), frame.y(y)), *hits], "beam", "side"))
    start = turned(rig, 0.0, -rig.outer_radius_m if rig.is_dome else 0.0)  # rays start at the dome's centre
    parts.append(polygon([at(frame, start), (frame.x(near_m), floor_y), (frame.x(far_m), floor_y)], "view"))
    parts.append(line(EDGE_PX, floor_y, WIDTH_PX - EDGE_PX, floor_y, "ink"))
    parts += [tilted_box(frame.x(x), frame.y(y), -leaning) for x, y, leaning in lamps]
    parts.append(pitched_camera(frame, rig))
    parts.append(upright_dimension(EDGE_PX + 20, frame.y(0), floor_y, f"altitude {metres(floor_m)}", frame.x(0)))
    parts.append(level_dimension(frame.x(near_m), frame.x(far_m), floor_y + 20, f"{metres(far_m - near_m)} of floor"))
    parts.append(text(frame.x(0) + 14, frame.y(0) - 16, f"looks {degrees(rig.pitch_rad):.3g}° ahead"))
    parts.append(scale_bar(frame))
    return svg(title, description, as_it_looks(rig, parts))


def trapezoid_from_above(rig: RigMeasures, *, title: str, description: str) -> str:
    """The footprint of a view that looks ahead, and the next one; the port is the dot, forward is up."""
    (near_m, near_half), (far_m, far_half) = rig.edges_m
    wide, deep, advance = 1.1 * far_half, far_m - near_m, rig.shown_advance_m
    frame = page_frame(-wide, wide, -(far_m + (advance or 0.0)) - 0.05 * deep, max(0.0, -near_m) + 0.05 * deep)

    def outline(moved_m: float) -> list[Place]:
        corners = ((-near_half, near_m), (near_half, near_m), (far_half, far_m), (-far_half, far_m))
        return [(frame.x(y), frame.y(-(x + moved_m))) for y, x in corners]

    parts = [polygon(outline(0.0), "view")]
    parts += [] if advance is None else [polygon(outline(advance), "next")]
    parts.append(f'<circle class="solid" cx="{frame.x(0):.1f}" cy="{frame.y(0):.1f}" r="4"/>')
    bottom = frame.y(max(0.0, -near_m) + 0.05 * deep)
    parts.append(level_dimension(frame.x(-near_half), frame.x(near_half), bottom + 16, f"{metres(2 * near_half)} near"))
    parts.append(text(frame.x(0), frame.y(-far_m) + 18, f"{metres(2 * far_half)} at the far edge", "middle"))
    right, ends = frame.x(wide) + 14, (frame.y(-far_m), frame.y(-near_m))
    parts.append(upright_dimension(right, *ends, f"{metres(deep)} along", frame.x(far_half)))
    parts += [motion_arrow(rig), scale_bar(frame)]
    return svg(title, description, parts)


def at(frame: PageFrame, place: Place) -> Place:
    """A place on the page."""
    return frame.x(place[0]), frame.y(place[1])


def pitched_camera(frame: PageFrame, rig: RigMeasures) -> str:
    """Housing and port, turned by the pitch about the port's vertex."""
    place = f"{frame.x(0.0):.1f} {frame.y(0.0):.1f}"
    return f'<g transform="rotate({-degrees(rig.pitch_rad):.1f} {place})">{camera_symbol(frame, rig, 0.0, 26.0)}</g>'


__all__ = ["trapezoid_from_above", "view_from_side"]

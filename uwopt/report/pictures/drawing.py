"""The rig drawn to scale as SVG text: seen from behind and from above.

Colours come from the page by CSS variables (--ink, --accent, --muted, --paper), so that a drawing suits dark,
light and print. All text is escaped. Lengths on the page are pixels of the view box.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from html import escape
from math import atan2, cos, hypot, inf, pi, sin, tan

from uwopt.report.pictures.curves import Lamp, RigMeasures

WIDTH_PX, HEIGHT_PX = 720.0, 480.0
EDGE_PX = 12.0
SIDE_PX, TOP_PX, BOTTOM_PX = 60.0, 46.0, 74.0  # room for labels around the drawing
CAPITAL_PX = 9.0  # of a label's letters
LABEL = re.compile(r'<text class="label" x="[^"]*" y="(?P<y>[^"]*)".*?</text>')
STEEPEST_RAD = 1.48  # 85 deg: rays nearer to level end at the picture's edge anyway
LEAST_SYMBOL_PX = 7.0
RING_POINTS = 72
ARROWS = (0.06, 0.18, 0.82, 0.94)  # of daylight: where they stand, as shares of the page's width
STYLE = (
    ".rig text{font:13px system-ui,sans-serif;fill:var(--ink,currentColor)}"
    ".rig .ink{stroke:var(--ink,currentColor);fill:none;stroke-width:1.5}"
    ".rig .solid{stroke:var(--ink,currentColor);fill:var(--paper,var(--panel,Canvas));stroke-width:1.5}"
    ".rig .view{stroke:var(--accent,#0072b2);fill:var(--accent,#0072b2);fill-opacity:.16;stroke-width:1.5}"
    ".rig .next{stroke:var(--accent,#0072b2);fill:none;stroke-width:1.5;stroke-dasharray:6 4}"
    ".rig .shared{stroke:none;fill:var(--accent,#0072b2);fill-opacity:.22}"
    ".rig .beam{stroke:var(--lamp,#d58a00);fill:var(--lamp,#d58a00);fill-opacity:.13;stroke-width:1.2}"
    ".rig .thin{stroke:var(--muted,#767676);fill:none;stroke-width:1}"
    ".rig .dashed{stroke:var(--muted,#767676);fill:none;stroke-width:1;stroke-dasharray:4 4}"
    ".rig .label{paint-order:stroke;stroke:var(--paper,var(--panel,Canvas));stroke-width:4px;stroke-linejoin:round}"
)


@dataclass(frozen=True)
class PageFrame:
    """Places a piece of the world (metres, right and down) on the page."""

    left_m: float
    top_m: float
    scale_px_per_m: float
    offset_x_px: float
    offset_y_px: float

    def x(self, right_m: float) -> float:
        """Page coordinate of a place to the right."""
        return self.offset_x_px + (right_m - self.left_m) * self.scale_px_per_m

    def y(self, down_m: float) -> float:
        """Page coordinate of a place downward."""
        return self.offset_y_px + (down_m - self.top_m) * self.scale_px_per_m


def page_frame(left_m: float, right_m: float, top_m: float, bottom_m: float) -> PageFrame:
    """The largest even scale that shows a rectangle, in the middle of the page."""
    room_x, room_y = WIDTH_PX - 2 * SIDE_PX, HEIGHT_PX - TOP_PX - BOTTOM_PX
    scale = min(room_x / (right_m - left_m), room_y / (bottom_m - top_m))
    return PageFrame(
        left_m,
        top_m,
        scale,
        SIDE_PX + 0.5 * (room_x - scale * (right_m - left_m)),
        TOP_PX + 0.5 * (room_y - scale * (bottom_m - top_m)),
    )


# ---------------------------------------------------------------- views


def view_from_behind(rig: RigMeasures, *, title: str, description: str) -> str:
    """Port, lamps, beams and the camera's view across the track, down to the floor; the motion goes into the page."""
    floor_m, tolerance_m = rig.altitude_m, rig.altitude_tolerance_m
    lamps_y = [lamp.y_m for lamp in rig.lamps]
    seen_m = max((rig.half_across_m, *(abs(end) for camera in rig.pair_m for end in camera)))
    half_m = max(seen_m * 1.12, max(map(abs, lamps_y), default=0.0) * 1.12)
    top_m = min([-0.12 * floor_m, *(lamp.z_m for lamp in rig.lamps)]) - 0.02 * floor_m
    frame = page_frame(-half_m, half_m, top_m, floor_m + tolerance_m + 0.02 * floor_m)
    floor_y, right_x = frame.y(floor_m), frame.x(half_m)
    parts = [clip("behind", 0.0, 0.0, WIDTH_PX, floor_y)]
    parts += [beam_across(frame, rig, lamp) for lamp in rig.lamps]
    edge = rig.half_across_m
    start_m = rig.outer_radius_m if rig.is_dome else 0.0  # rays start at the dome's centre, above its vertex
    cameras = rig.pair_m or ((0.0, -edge, edge),)
    for at_m, *ends_m in cameras:
        parts.append(
            polygon([(frame.x(at_m), frame.y(-start_m)), *((frame.x(end), floor_y) for end in ends_m)], "view")
        )
    parts += [line(EDGE_PX, floor_y, WIDTH_PX - EDGE_PX, floor_y, "ink")]
    if tolerance_m > 0:
        for level in (floor_m - tolerance_m, floor_m + tolerance_m):
            parts.append(line(EDGE_PX, frame.y(level), WIDTH_PX - EDGE_PX, frame.y(level), "dashed"))
    mast_m = -0.06 * floor_m
    ends = [min([0.0, *lamps_y]), max([0.0, *lamps_y])]
    parts.append(line(frame.x(ends[0]), frame.y(mast_m), frame.x(ends[1]), frame.y(mast_m), "ink"))
    parts += [lamp_across(frame, lamp, mast_m) for lamp in rig.lamps]
    parts += daylight(frame, rig)
    parts += [camera_across(frame, rig, mast_m, at_m) for at_m, *_ in cameras]
    spread = f" ± {metres(tolerance_m)}" if tolerance_m > 0 else ""
    parts.append(
        upright_dimension(right_x + 14, frame.y(0), floor_y, f"altitude {metres(floor_m)}{spread}", right_x)
    )
    half_seen_m = max(0.0, min(end for _, _, end in cameras))  # by both cameras of a pair
    below, told = max(floor_y, frame.y(floor_m + tolerance_m)) + 20, "by both" if rig.pair_m else "across"
    parts.append(
        level_dimension(frame.x(-half_seen_m), frame.x(half_seen_m), below, f"{metres(2 * half_seen_m)} {told}")
    )
    for side, name in ((ends[0], "left"), (ends[1], "right")):
        if abs(side) * frame.scale_px_per_m > 24.0 and (name == "right" or abs(side + ends[1]) > 1e-6):
            level = frame.y(min(mast_m, *(lamp.z_m for lamp in rig.lamps))) - 14
            parts.append(
                level_dimension(frame.x(min(0.0, side)), frame.x(max(0.0, side)), level, metres(abs(side)))
            )
    parts.append(scale_bar(frame))
    return svg(title, description, as_it_looks(rig, parts))


def view_from_above(rig: RigMeasures, *, title: str, description: str) -> str:
    """Footprint, the next one, the lamps' light on the floor and the lamps themselves; forward is up."""
    along, across = rig.half_along_m, rig.half_across_m
    advance = rig.shown_advance_m
    reach_x = max([across, *(abs(lamp.y_m) for lamp in rig.lamps)]) * 1.15
    ahead = along + (advance or 0.0)
    ahead = max([ahead, *(lamp.x_m for lamp in rig.lamps)]) * 1.06
    behind = max([along, *(-lamp.x_m for lamp in rig.lamps)]) * 1.06
    frame = page_frame(-reach_x, reach_x, -ahead, behind)
    parts = [clip("above", frame.x(-reach_x), frame.y(-ahead), frame.x(reach_x), frame.y(behind))]
    for lamp in rig.lamps:
        ring = [(frame.x(y), frame.y(-x)) for x, y in beam_ring(rig, lamp)]
        parts.append(polygon(ring, "beam", "above"))
    parts.append(box(frame, -across, along, across, -along, "view"))
    if advance is not None:
        if advance < 2 * along:
            parts.append(box(frame, -across, along, across, advance - along, "shared"))
        parts.append(box(frame, -across, along + advance, across, advance - along, "next"))
    for lamp in rig.lamps:
        x, y = frame.x(lamp.y_m), frame.y(-lamp.x_m)
        parts.append(f'<circle class="solid" cx="{x:.1f}" cy="{y:.1f}" r="5"/>')
        parts.append(line(x - 3, y - 3, x + 3, y + 3, "ink") + line(x - 3, y + 3, x + 3, y - 3, "ink"))
    parts.append(f'<circle class="solid" cx="{frame.x(0):.1f}" cy="{frame.y(0):.1f}" r="3"/>')
    parts.append(
        level_dimension(
            frame.x(-across), frame.x(across), frame.y(behind) + 20, f"{metres(2 * across)} across"
        )
    )
    left = frame.x(-reach_x) - 8
    parts.append(
        upright_dimension(
            left, frame.y(along), frame.y(-along), f"{metres(2 * along)} along", frame.x(-across), flip=True
        )
    )
    right = frame.x(reach_x) + 14
    if advance is not None:
        parts.append(
            upright_dimension(
                right, frame.y(-advance), frame.y(0), f"{metres(advance)} to the next", frame.x(0)
            )
        )
        if rig.overlap is not None and rig.overlap > 0:
            middle = frame.y(-0.5 * advance)
            parts.append(text(frame.x(0), middle + 4, f"overlap {100 * rig.overlap:.0f} %", "middle"))
    parts.append(motion_arrow(rig))
    width = "along" if rig.image_width_is_along else "across"
    parts.append(text(WIDTH_PX - 12, HEIGHT_PX - 14, f"image width lies {width} the track", "end"))
    parts.append(scale_bar(frame))
    return svg(title, description, parts)


# ---------------------------------------------------------------- light


def beam_across(frame: PageFrame, rig: RigMeasures, lamp: Lamp) -> str:
    """One lamp's beam in the plane across the track, from the lamp to the floor."""
    leaning = atan2(lamp.aim[1], lamp.aim[2])
    height_m = rig.altitude_m - lamp.z_m
    hits = [
        lamp.y_m
        + height_m * tan(max(-STEEPEST_RAD, min(STEEPEST_RAD, leaning + side * rig.beam_half_angle_rad)))
        for side in (-1.0, 1.0)
    ]
    at = (frame.x(lamp.y_m), frame.y(lamp.z_m))
    return polygon([at, *((frame.x(y), frame.y(rig.altitude_m)) for y in hits)], "beam", "behind")


def beam_ring(rig: RigMeasures, lamp: Lamp) -> list[tuple[float, float]]:
    """Where the edge of a beam meets the floor, (forward, starboard) in metres; rays that never do end far away."""
    aim_x, aim_y, aim_z = lamp.aim
    flat = hypot(aim_x, aim_z)
    one = (aim_z / flat, 0.0, -aim_x / flat)
    other = (
        aim_y * one[2] - aim_z * one[1],
        aim_z * one[0] - aim_x * one[2],
        aim_x * one[1] - aim_y * one[0],
    )
    height_m, angle = rig.altitude_m - lamp.z_m, min(rig.beam_half_angle_rad, STEEPEST_RAD)
    ring = []
    for n in range(RING_POINTS):
        turn = 2 * pi * n / RING_POINTS
        ray = [
            cos(angle) * a + sin(angle) * (cos(turn) * u + sin(turn) * v)
            for a, u, v in zip(lamp.aim, one, other, strict=True)
        ]
        reach = height_m / max(ray[2], cos(STEEPEST_RAD))
        ring.append((lamp.x_m + reach * ray[0], lamp.y_m + reach * ray[1]))
    return ring


def daylight(frame: PageFrame, rig: RigMeasures) -> list[str]:
    """Arrows down to the floor where the sun is the only light; nothing beside lamps."""
    if rig.sun_elevation_deg is None:
        return []
    top, bottom = TOP_PX - 22.0, frame.y(0.55 * rig.altitude_m)
    parts = [text(EDGE_PX, top - 6, f"sun at {rig.sun_elevation_deg:g}°, from all sides alike")]
    for share in ARROWS:
        x = share * WIDTH_PX
        head = polygon([(x, bottom + 8), (x - 5, bottom - 3), (x + 5, bottom - 3)], "beam")
        parts += [line(x, top, x, bottom, "beam"), head]
    return parts


# ---------------------------------------------------------------- symbols


def lamp_across(frame: PageFrame, lamp: Lamp, mast_m: float) -> str:
    """A lamp as a small box that leans as it aims, with its stay."""
    x, y = frame.x(lamp.y_m), frame.y(lamp.z_m)
    return line(x, frame.y(mast_m), x, y - 6, "ink") + tilted_box(x, y, -atan2(lamp.aim[1], lamp.aim[2]))


def tilted_box(x: float, y: float, turn_rad: float) -> str:
    """A lamp as a small box that leans as it aims."""
    turn = f'transform="rotate({turn_rad * 180.0 / pi:.1f} {x:.1f} {y:.1f})"'
    return f'<rect class="solid" x="{x - 6:.1f}" y="{y - 12:.1f}" width="12" height="12" {turn}/>'


def camera_across(frame: PageFrame, rig: RigMeasures, mast_m: float, at_m: float) -> str:
    """Housing and port, so far to starboard, up to the mast."""
    return camera_symbol(frame, rig, at_m, 14.0 if rig.is_dome else 15.0, frame.y(mast_m) - 4)


def camera_symbol(frame: PageFrame, rig: RigMeasures, at_m: float, length_px: float, top_px: float = inf) -> str:
    """Housing, so long or up to a height, and port; a dome is drawn to scale where it is large enough to be seen."""
    x, y = frame.x(at_m), frame.y(0.0)
    radius = max(rig.outer_radius_m * frame.scale_px_per_m, LEAST_SYMBOL_PX)
    base = y - (radius if rig.is_dome else 3.0)
    top = min(top_px, base - length_px)
    arc = f"M{x - radius:.1f} {base:.1f}A{radius:.1f} {radius:.1f} 0 0 0 {x + radius:.1f} {base:.1f}Z"
    window = f'<rect class="solid" x="{x - 9:.1f}" y="{base:.1f}" width="18" height="3"/>'
    body = f'<rect class="solid" x="{x - 7:.1f}" y="{top:.1f}" width="14" height="{base - top:.1f}"/>'
    return body + (f'<path class="solid" d="{arc}"/>' if rig.is_dome else window)


def motion_arrow(rig: RigMeasures) -> str:
    """An arrow forward with the speed; nothing for a rig that stands still."""
    if rig.speed_m_s <= 0.0:
        return text(12, 24, "no motion")
    x, bottom, top = 24.0, 92.0, 40.0
    head = polygon([(x, top - 8), (x - 6, top + 4), (x + 6, top + 4)], "solid")
    return line(x, bottom, x, top, "ink") + head + text(12, 24, f"motion {rig.speed_m_s:g} m/s")


def scale_bar(frame: PageFrame) -> str:
    """A bar of a round length, about an eighth of the page."""
    wanted_m = WIDTH_PX / 8.0 / frame.scale_px_per_m
    length_m = max(
        (
            digit * 10.0**power
            for power in range(-4, 5)
            for digit in (1.0, 2.0, 5.0)
            if digit * 10.0**power <= wanted_m
        ),
        default=wanted_m,
    )
    x, y = 12.0, HEIGHT_PX - 18.0
    end = x + length_m * frame.scale_px_per_m
    ticks = line(x, y - 4, x, y + 4, "ink") + line(end, y - 4, end, y + 4, "ink")
    return line(x, y, end, y, "ink") + ticks + text(end + 8, y + 4, metres(length_m))


# ---------------------------------------------------------------- shapes


def metres(length_m: float) -> str:
    """A length with its unit, in three figures."""
    if abs(length_m) < 0.1:
        return f"{length_m * 1e3:.3g} mm"
    digits = 2 if abs(length_m) < 10 else 1
    return f"{length_m:.{digits}f} m"


def line(x1: float, y1: float, x2: float, y2: float, style: str) -> str:
    """A straight line."""
    return f'<line class="{style}" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'


def polygon(points: list[tuple[float, float]], style: str, clipped_by: str = "") -> str:
    """A closed shape."""
    places = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    clipping = f' clip-path="url(#rig-{clipped_by})"' if clipped_by else ""
    return f'<polygon class="{style}" points="{places}"{clipping}/>'


def box(frame: PageFrame, left_m: float, front_m: float, right_m: float, back_m: float, style: str) -> str:
    """A rectangle on the floor, forward up."""
    corners = [(left_m, front_m), (right_m, front_m), (right_m, back_m), (left_m, back_m)]
    return polygon([(frame.x(y), frame.y(-x)) for y, x in corners], style)


def clip(name: str, left: float, top: float, right: float, bottom: float) -> str:
    """A rectangle beyond which beams are not drawn."""
    shape = f'<rect x="{left:.1f}" y="{top:.1f}" width="{right - left:.1f}" height="{bottom - top:.1f}"/>'
    return f'<clipPath id="rig-{name}">{shape}</clipPath>'


def text(x: float, y: float, words: str, anchor: str = "start", turn: bool = False) -> str:
    """A label."""
    turned = f' transform="rotate(-90 {x:.1f} {y:.1f})"' if turn else ""
    return (
        f'<text class="label" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{turned}>{escape(words)}</text>'
    )


def level_dimension(left: float, right: float, y: float, words: str) -> str:
    """A length across the page with its label below."""
    ticks = line(left, y - 5, left, y + 5, "thin") + line(right, y - 5, right, y + 5, "thin")
    above = y < HEIGHT_PX / 2
    return (
        line(left, y, right, y, "thin")
        + ticks
        + text(0.5 * (left + right), y - 7 if above else y + 17, words, "middle")
    )


def upright_dimension(
    x: float, top: float, bottom: float, words: str, from_x: float, *, flip: bool = False
) -> str:
    """A length down the page with its label beside it, and thin lines to what it measures."""
    ticks = line(from_x, top, x + 5, top, "dashed") + line(from_x, bottom, x + 5, bottom, "dashed")
    label = text(x - 7 if flip else x + 17, 0.5 * (top + bottom), words, "middle", turn=True)
    return ticks + line(x, top, x, bottom, "thin") + label


def as_it_looks(rig: RigMeasures, parts: list[str]) -> list[str]:
    """Parts of a view along the floor as they are; upside down, with upright words, of a camera that looks up."""
    if not rig.looks_up:
        return parts
    return [upside_down(LABEL.sub(upright_again, "".join(parts)), HEIGHT_PX / 2.0)]


def upright_again(label: re.Match[str]) -> str:
    """A label that is turned over with its drawing and can be read: one along the page about its letters' middle."""
    return upside_down(label[0], float(label["y"]) - (0.0 if "transform" in label[0] else 0.5 * CAPITAL_PX))


def upside_down(drawn: str, middle_px: float) -> str:
    """What is drawn, mirrored at a level of the page."""
    return f'<g transform="matrix(1 0 0 -1 0 {2.0 * middle_px:.1f})">{drawn}</g>'


def svg(title: str, description: str, parts: list[str]) -> str:
    """The whole drawing with its title and description for screen readers."""
    box_px = f"0 0 {WIDTH_PX:.0f} {HEIGHT_PX:.0f}"
    head = f'<svg class="rig" xmlns="http://www.w3.org/2000/svg" viewBox="{box_px}" role="img">'
    words = f"<title>{escape(title)}</title><desc>{escape(description)}</desc>"
    return f"{head}{words}<style>{STYLE}</style>{''.join(parts)}</svg>"

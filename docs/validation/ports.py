# ruff: noqa: E501 - a line of the page's text is as long as the expressions in it
"""Section 5: ports against rays traced by vectors through each surface."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.optimize import brentq

from . import common

Vector = common.Array
CAMERA = "seed-imx250m"
PITCH_M, WIDTH, HEIGHT = 3.45e-6, 2448, 2048


def refract(way: Vector, normal: Vector, n_from: float, n_to: float) -> Vector:
    """Snell's law in vectors; the normal looks against the ray."""
    ratio, cos = n_from / n_to, -float(normal @ way)
    under = 1 - ratio**2 * (1 - cos**2)
    return np.asarray(ratio * way + (ratio * cos - math.sqrt(under)) * normal)


def sphere_hit(start: Vector, way: Vector, radius: float) -> Vector:
    """Where a ray from inside leaves a sphere about the origin, or one from outside first meets it."""
    b, c = float(start @ way), float(start @ start) - radius**2
    root = math.sqrt(b * b - c)
    return np.asarray(start + (-b + root if c < 0 else -b - root) * way)


# ---------------------------------------------------------------- flat


def flat_floor(
    tan_x: float, tan_y: float, *, gap: float, glass: float, range_m: float, n_g: float, n_w: float
) -> Vector:
    """Floor point of a field point: from the pupil through both faces of a plate."""
    way = np.array([tan_x, tan_y, 1.0]) / math.sqrt(1 + tan_x**2 + tan_y**2)
    place, up = np.zeros(3), np.array([0.0, 0.0, -1.0])
    for depth, n_from, n_to in ((gap, 1.0, n_g), (glass, n_g, n_w), (range_m, n_w, n_w)):
        place = place + way * depth / way[2]
        way = refract(way, up, n_from, n_to)
    return place


def flat_case(
    range_m: float, focal_mm: float, gap_mm: float, glass_mm: float
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Mission and system."""
    mission = {
        "name": "port", "physics": "full",
        "scene": {"water": "II", "water_table": "solonenko-mobley", "seafloor": 0.2, "depth_m": 50, "multiple_scattering": False},
        "vehicle": {"altitude_m": range_m, "speed_m_s": 0.0}, "requirements": {"frame_interval_s": 1.0},
    }  # fmt: skip
    system = {
        "camera": CAMERA, "lens": {"focal_length_mm": focal_mm, "transmission": 0.9},
        "port": {"geometry": "flat", "thickness_mm": glass_mm, "refractive_index": 1.5, "gap_mm": gap_mm},
        "light": {
            "flux_lm": 10_000, "power_w": 100, "spectrum": "generic-led", "beam": "cosine-power", "beam_half_angle_deg": 60,
        },
        "light_mounts": [{"y_m": 0.3}], "settings": {"f_number": 4.0, "exposure_ms": 1.0, "gain": 1.0, "flux_lm": 10_000},
    }  # fmt: skip
    return mission, system


def colour_spread_px(range_m: float, focal_mm: float, gap_mm: float, glass_mm: float) -> float:
    """Rms radius [px] of the floor point at 80 % of the image's half diagonal over the electrons that arrive: each colour's ray is sought."""
    index = common.index_of_water(10.0, 35.0)
    a, b, kd = common.jerlov("II")
    k = np.clip(kd, a + 0.0183 * b, a + b)
    weight = common.led() * common.efficiency(CAMERA) * common.WAVES_NM / index**2
    weight = weight * np.exp(-(k + a + b) * range_m) * common.STEPS_NM
    corner = 0.8 * math.hypot(WIDTH, HEIGHT) * PITCH_M / (2e-3 * focal_mm)
    ray = dict(gap=1e-3 * gap_mm, glass=1e-3 * glass_mm, range_m=range_m, n_g=1.5)
    n_green = float(np.interp(550.0, common.WAVES_NM, index))
    target = flat_floor(corner, 0.0, n_w=n_green, **ray)[0]
    few = np.arange(0, common.WAVES_NM.size, 8)
    tangents = [
        brentq(
            lambda t, n=float(index[i]): flat_floor(t, 0.0, n_w=n, **ray)[0] - target,
            0.5 * corner,
            1.5 * corner,
            xtol=1e-13,
        )
        for i in few
    ]
    radius = np.interp(common.WAVES_NM, common.WAVES_NM[few], tangents) * 1e-3 * focal_mm / PITCH_M
    mean = (weight * radius).sum() / weight.sum()
    return float(math.sqrt((weight * (radius - mean) ** 2).sum() / weight.sum()))


def flat_rows() -> tuple[list[list[str]], float, float]:
    """Footprint and lateral colour; largest relative differences of both."""
    rows, worst_foot, worst_colour = [], 0.0, 0.0
    for case in (
        (2.0, 8.0, 20.0, 10.0),
        (0.5, 8.0, 60.0, 20.0),
        (3.0, 16.0, 20.0, 10.0),
        (0.3, 5.0, 15.0, 8.0),
    ):
        range_m, focal, gap, glass = case
        told = common.figures(*flat_case(*case))
        n_w = float(np.interp(550.0, common.WAVES_NM, common.index_of_water(10.0, 35.0)))
        ray = dict(gap=1e-3 * gap, glass=1e-3 * glass, range_m=range_m, n_g=1.5, n_w=n_w)
        seen_m = flat_floor(1e-6, 0.0, **ray)[0] / 1e-6  # how far off the floor looks near the axis
        image_m = 1.0 / (1e3 / focal - 1.0 / seen_m)  # where a thin lens images that: a whole lens stands so far off
        half = WIDTH * PITCH_M / (2.0 * image_m), HEIGHT * PITCH_M / (2.0 * image_m)
        width, height = 2 * flat_floor(half[0], 0.0, **ray)[0], 2 * flat_floor(0.0, half[1], **ray)[1]
        foot = max(abs(told["fov_x_m"] / width - 1), abs(told["fov_y_m"] / height - 1))
        spread = colour_spread_px(*case)
        colour = told["lateral_colour_px"] / spread - 1
        worst_foot, worst_colour = max(worst_foot, foot), max(worst_colour, abs(colour))
        rows.append([
            f"{range_m:g} m, {focal:g} mm, gap {gap:g}, glass {glass:g} mm", f"{width:.5f} × {height:.5f}",
            f"{told['fov_x_m']:.5f} × {told['fov_y_m']:.5f}", common.small(foot), f"{spread:.4f}",
            f"{told['lateral_colour_px']:.4f}", common.percent(colour, 2),
        ])  # fmt: skip
    return rows, worst_foot, worst_colour


# ---------------------------------------------------------------- dome


def dome_image_m(
    theta: float,
    range_m: float,
    radius: float,
    glass: float,
    n_g: float,
    n_w: float,
    *,
    tangential: bool = True,
) -> float:
    """Distance from the pupil, along the axis, at which a dome shows the floor point at a field angle.

    Two rays from the floor point, a hair's breadth to both sides of the one through the centre, are traced
    through both faces and produced backwards.
    """
    length = (range_m + radius) / math.cos(theta)
    chief = np.array([math.sin(theta), 0.0, math.cos(theta)])
    aside = np.array([math.cos(theta), 0.0, -math.sin(theta)]) if tangential else np.array([0.0, 1.0, 0.0])
    point = length * chief
    hair = 1e-4
    way = -chief + hair * aside
    way /= np.linalg.norm(way)
    place = sphere_hit(point, way, radius)
    way = refract(way, place / np.linalg.norm(place), n_w, n_g)
    place = sphere_hit(place, way, radius - glass)
    way = refract(way, place / np.linalg.norm(place), n_g, 1.0)
    off, slope = float(place @ aside), float(way @ aside) / float(way @ chief)
    return (float(place @ chief) - off / slope) * math.cos(theta)  # where it crosses the chief ray


DOMES = ((2.0, 0.1, 0.01, 1.5), (0.5, 0.05, 0.004, 1.49), (5.0, 0.2, 0.02, 1.52), (1.0, 0.05, 0.003, 1.77))


def dome_rows() -> tuple[list[list[str]], float]:
    """Virtual image on the axis, and the curved image of a flat floor off it."""
    from uwopt.model import port

    rows, worst = [], 0.0
    n_w = 1.34
    for range_m, radius, glass, n_g in DOMES:
        given = dict(outer_radius_m=radius, thickness_m=glass, n_glass=n_g, n_water=n_w)
        cells = [f"{range_m:g} m, R {1e3 * radius:g}, glass {1e3 * glass:g} mm, n {n_g:g}"]
        for degrees in (0.0, 20.0, 35.0):
            theta = math.radians(degrees)
            traced = dome_image_m(theta, range_m, radius, glass, n_g, n_w)
            if degrees:
                told = 1 / port.field_dioptre_per_m(
                    range_m, cos_field=math.cos(theta), focus_map=port.dome_focus_map(**given)
                )
            else:
                told = port.dome_virtual_image_distance_m(range_m, **given) + radius
            worst = max(worst, abs(told / traced - 1))
            cells += [f"{1e3 * traced:.3f}", f"{1e3 * told:.3f}"]
        rows.append(cells)
    return rows, worst


def dome_blur_px() -> float:
    """Blur at 35 degrees of the physics page's example: 8 mm F2.8, R 50 mm, focus on the axis at 2 m."""
    images = [dome_image_m(math.radians(t), 2.0, 0.05, 0.005, 1.5, 1.34) for t in (0.0, 35.0)]
    return (8e-3) ** 2 / 2.8 * abs(1 / images[1] - 1 / images[0]) / PITCH_M


# ---------------------------------------------------------------- Fresnel


def window_by_angles(theta: float, n_g: float, n_w: float, *, bounces: bool) -> float:
    """Transmittance of a window for unpolarised light, by the sine and tangent forms; light between the faces, if wanted."""
    glass, water = (math.asin(math.sin(theta) / n) for n in (n_g, n_w))
    total = 0.0
    for polarised in ("s", "p"):
        lost = []
        for a, b in ((theta, glass), (glass, water)):
            form = math.sin if polarised == "s" else math.tan
            lost.append((form(a - b) / form(a + b)) ** 2)
        through = (1 - lost[0]) * (1 - lost[1])
        total += 0.5 * through / (1 - lost[0] * lost[1] * bounces)
    return total


def fresnel_text() -> tuple[str, float, float]:
    """By angle; largest difference, and what the light between the faces adds at most."""
    from uwopt.model import port

    rows, worst, between = [], 0.0, 0.0
    for degrees in (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0):
        theta = math.radians(max(degrees, 0.01))  # the forms are 0/0 on the axis
        hand = window_by_angles(theta, 1.49, 1.34, bounces=False)
        told = float(port.flat_port_transmittance(math.tan(theta), n_water=1.34, n_glass=1.49))
        more = window_by_angles(theta, 1.49, 1.34, bounces=True) / hand - 1
        worst, between = max(worst, abs(told / hand - 1)), max(between, more)
        rows.append(
            [
                f"{degrees:g}°",
                f"{hand:.6f}",
                f"{told:.6f}",
                common.small(told / hand - 1),
                common.percent(more, 3),
            ]
        )
    return (
        common.table(["angle in air", "by angles", "uwopt", "difference", "light between the faces"], rows),
        worst,
        between,
    )


def section() -> str:
    """The text."""
    flat, foot, colour = flat_rows()
    domes, dome_worst = dome_rows()
    fresnel, fresnel_worst, between = fresnel_text()
    return f"""\
**In short:** footprint {common.small(foot)}, lateral colour {100 * colour:.2f} %, dome images {common.small(dome_worst)}, Fresnel {common.small(fresnel_worst)}.

Independent of: uwopt's tangent forms, focus maps and Moebius algebra. Rays are traced by vectors through each surface
(`docs/validation/ports.py`); the Fresnel side uses the sine and tangent forms.

**Flat port**: footprint of `evaluate` [m], through a lens that moves as a whole to its focus, and lateral colour [px rms] of the corner's floor point: for each wavelength
the ray that meets that point is sought by root finding; electrons as they arrive over range there and back.

{common.table(["range, lens, port", "traced [m]", "uwopt [m]", "largest diff.", "traced [px]", "uwopt [px]", "diff."], flat)}

Largest difference of the footprint {common.small(foot)}, of the lateral colour {100 * colour:.2f} % (uwopt takes the spread for a far
floor times the share a near one leaves, and weighs colours by the light on the axis).

**Dome**: distance of the floor's image from the pupil, along the axis [mm], for field angles of 0°, 20° and 35°; two
neighbouring rays, traced and produced backwards (pupil at the centre, n_w 1.34).

{common.table(["dome", "0° traced", "uwopt", "20° traced", "uwopt", "35° traced", "uwopt"], domes)}

Largest difference {common.small(dome_worst)}. The physics page's example (8 mm F2.8, R 50 mm, 35°) gives {dome_blur_px():.1f} px of blur by
the traced rays with a glass of 5 mm; the page says 8.5.

**Fresnel by angle**: window of acrylic (1.49) in sea water (1.34), unpolarised, both faces.

{fresnel}

Largest difference {common.small(fresnel_worst)}. Left out by uwopt: light that goes to and fro between the faces, at most
{common.percent(between, 2)} at these angles.

What falls short: pupils that are not at the dome's centre, domes and windows bent by pressure, lens distortion.
"""

"""Write docs/paper.md: physics `paper` against the founding paper's equations, worked out by hand.

    python docs/make_paper_table.py

The hand side uses plain arithmetic and mpmath on the numbers of problems/paper-tool-window*.yaml and on the
tables in uwopt/catalog/data. It shares no code with uwopt's model; only the column "uwopt" asks uwopt.
"""

from __future__ import annotations

import csv
import math
import sys
from bisect import bisect_right
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import mpmath as mp
import yaml

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT / "uwopt" / "catalog" / "data"
MISSION = ROOT / "problems" / "paper-tool-window.yaml"
SYSTEM = ROOT / "problems" / "paper-tool-window.system.yaml"
PAGE = ROOT / "docs" / "paper.md"

PLANCK_J_S, LIGHT_M_S, LUMENS_PER_W = 6.62607015e-34, 299_792_458.0, 683.002
N_WATER = 1.33
SPECTRUM_NM = (380.0, 780.0)
LED = ((24.49, 450.70, 11.67), (119.86, 565.43, 64.63))  # weight, mean, sigma [nm] of the tool's white LED
SHOWN = {  # what the tool's window shows, in the units of the table
    "fov_x_m": "2.11", "fov_y_m": "1.77", "exposure_max_ms": "0.86", "frame_rate_min_hz": "0.63",
    "virtual_image_distance_m": "0.2116", "dof_near_m": "1.3", "dof_far_m": "5.0",
}  # fmt: skip

Curve = Callable[[float], float]


class Row(NamedTuple):
    """One line of the table."""

    equation: str
    words: str
    name: str
    unit: str
    by_hand: float
    uwopt: float

    @property
    def difference(self) -> float:
        """Relative difference of uwopt from the hand value."""
        return self.uwopt / self.by_hand - 1.0


# ---------------------------------------------------------------- tables


def rows_of(file: str) -> Iterator[dict[str, str]]:
    """Rows of a table that ships."""
    with (DATA / file).open(encoding="utf-8", newline="") as lines:
        yield from csv.DictReader(line for line in lines if not line.startswith("#"))


def straight_lines(points: list[tuple[float, float]], *, hold: bool) -> Curve:
    """Linear between points; beyond them the end value, or zero."""
    points = sorted(points)
    xs, ys = [x for x, _ in points], [y for _, y in points]

    def value(at: Any) -> Any:
        at = float(at)
        if at <= xs[0] or at >= xs[-1]:
            inside = xs[0] <= at <= xs[-1]
            return (ys[0] if at <= xs[0] else ys[-1]) if hold or inside else 0.0
        i = bisect_right(xs, at)
        return ys[i - 1] + (ys[i] - ys[i - 1]) * (at - xs[i - 1]) / (xs[i] - xs[i - 1])

    return value


def led(wavelength_nm: Any) -> Any:
    """Relative power per nm of the tool's white LED, as the paper gives it."""
    return sum(
        weight / (sigma * mp.sqrt(2 * mp.pi)) * mp.exp(-((wavelength_nm - mean) ** 2) / (2 * sigma**2))
        for weight, mean, sigma in LED
    )


class Spectra(NamedTuple):
    """The tables that the window needs, and where their straight pieces meet."""

    photopic: Curve
    attenuation_per_m: Curve
    efficiency: Curve
    knots_nm: list[float]


def spectra(water: str) -> Spectra:
    """V, c = a + b of a Jerlov type, and the tool's efficiency of the IMX250."""
    v = [(float(r["wavelength_nm"]), float(r["V"])) for r in rows_of("photopic_v.csv")]
    c = [
        (float(r["wavelength_nm"]), float(r["a_per_m"]) + float(r["b_per_m"]))
        for r in rows_of("jerlov_iop.csv") if r["water_type"] == water
    ]  # fmt: skip
    qe = [
        (float(r["wavelength_nm"]), float(r["qe"]))
        for r in rows_of("qe_curves.csv") if r["curve_id"] == "seed-imx250m" and r["channel"] == "mono"
    ]  # fmt: skip
    low, high = SPECTRUM_NM
    inner = {x for points in (c, qe) for x, _ in points if low < x < high}
    return Spectra(
        straight_lines(v, hold=False), straight_lines(c, hold=True), straight_lines(qe, hold=True),
        sorted({low, high} | inner),
    )  # fmt: skip


def integral(integrand: Curve, knots_nm: list[float]) -> float:
    """Over the spectrum, piece by piece, where the integrand is smooth (V: 1 nm pieces, nearly so)."""
    pieces = sorted(set(knots_nm) | {float(x) for x in range(int(SPECTRUM_NM[0]), int(SPECTRUM_NM[1]) + 1)})
    total = 0.0
    for low, high in pairwise(pieces):
        middle, half = (low + high) / 2, (high - low) / 2
        # Gauss-Legendre with three nodes: exact to degree five on pieces of 1 nm or less
        offset = half * math.sqrt(0.6)
        ends = integrand(middle - offset) + integrand(middle + offset)
        total += half / 9 * (5 * float(ends) + 8 * float(integrand(middle)))
    return total


# ---------------------------------------------------------------- the window by hand


class Window(NamedTuple):
    """The numbers of the window, SI."""

    range_m: float
    speed_m_s: float
    overlap: float
    blur_px: float
    focal_m: float
    f_number: float
    transmission: float
    exposure_s: float
    radius_m: float
    thickness_m: float
    n_glass: float
    flux_lm: float
    half_angle_rad: float
    reflectance: float
    water: str
    width_px: int
    height_px: int
    pitch_m: float
    dark_noise_e: float
    gain_dn_per_e: float


def read_window() -> Window:
    """Mission, system and the tool's sensor file."""
    mission, system = yaml.safe_load(MISSION.read_text()), yaml.safe_load(SYSTEM.read_text())
    camera = next(row for row in rows_of("cameras.csv") if row["id"] == system["camera"])
    floor = {row["name"]: float(row["reflectance"]) for row in rows_of("seafloor_flat.csv")}
    vehicle, needs, settings = mission["vehicle"], mission["requirements"], system["settings"]
    lens, port, light = system["lens"], system["port"], system["light"]
    return Window(
        vehicle["altitude_m"], vehicle["speed_m_s"], needs["overlap"], needs["max_blur_px"],
        lens["focal_length_mm"] * 1e-3, settings["f_number"], lens["transmission"], settings["exposure_ms"] * 1e-3,
        port["outer_radius_mm"] * 1e-3, port["thickness_mm"] * 1e-3, port["refractive_index"],
        settings["flux_lm"], math.radians(light["beam_half_angle_deg"]), floor[mission["scene"]["seafloor"]],
        mission["scene"]["water"], int(camera["resolution_x_px"]), int(camera["resolution_y_px"]),
        float(camera["pixel_pitch_um"]) * 1e-6, float(camera["read_noise_e"]), float(camera["gain_dn_per_e"]),
    )  # fmt: skip


def virtual_image_m(range_m: Any, at: Window) -> Any:
    """Virtual image of a point in the water, from the dome's outer vertex: both faces, one after the other.

    n2/v - n1/u = (n2 - n1)/R with light going to the right: the object at u = -d, both centres at +.
    """
    power_outer = (at.n_glass - N_WATER) / mp.mpf(at.radius_m)
    behind_outer = at.n_glass / (power_outer - N_WATER / range_m)  # from the outer vertex
    power_inner = (1 - at.n_glass) / mp.mpf(at.radius_m - at.thickness_m)
    behind_inner = 1 / (power_inner + at.n_glass / (behind_outer - at.thickness_m))  # from the inner vertex
    return -(behind_inner + at.thickness_m)


def depth_of_field_m(at: Window) -> tuple[float, float]:
    """(9), thin lens focused on the virtual image, both ends taken back to the water by a root search."""
    circle_m = math.hypot(at.width_px, at.height_px) * at.pitch_m / 1500
    hyperfocal_m = at.focal_m**2 / (at.f_number * circle_m) + at.focal_m
    s = float(virtual_image_m(at.range_m, at))
    near_s = s * (hyperfocal_m - at.focal_m) / (hyperfocal_m + s - 2 * at.focal_m)
    far_s = s * (hyperfocal_m - at.focal_m) / (hyperfocal_m - s)

    def in_water(object_m: float) -> float:
        return float(mp.findroot(lambda d: virtual_image_m(d, at) - object_m, (0.5, 20.0), solver="anderson"))

    return in_water(near_s), in_water(far_s)


def light_by_hand(at: Window) -> tuple[float, float]:
    """Illuminance of the floor [lx], and electrons of one pixel: (1), (2), (4), (5) in one integral."""
    tables = spectra(at.water)
    visible = integral(lambda x: tables.photopic(x) * led(x), tables.knots_nm)
    spot_m2 = math.pi * (at.range_m * math.tan(at.half_angle_rad)) ** 2

    def reaches_floor(x: float) -> Any:  # (1) [W m^-2 nm^-1]
        watts_per_nm = at.flux_lm * led(x) / (LUMENS_PER_W * visible)
        return watts_per_nm / spot_m2 * mp.exp(-tables.attenuation_per_m(x) * at.range_m)

    def reaches_lens(x: float) -> Any:  # (2), then (1) on the way back [W m^-2 sr^-1 nm^-1]
        return reaches_floor(x) * at.reflectance / mp.pi * mp.exp(-tables.attenuation_per_m(x) * at.range_m)

    def electrons_per_s_nm(x: float) -> Any:  # (4) and (5)
        on_pixel_w_nm = mp.pi / 4 * reaches_lens(x) * at.transmission / at.f_number**2 * at.pitch_m**2
        return on_pixel_w_nm * tables.efficiency(x) * x * 1e-9 / (PLANCK_J_S * LIGHT_M_S)

    lux = LUMENS_PER_W * integral(lambda x: tables.photopic(x) * reaches_floor(x), tables.knots_nm)
    return lux, at.exposure_s * integral(electrons_per_s_nm, tables.knots_nm)


def table() -> list[Row]:
    """All lines."""
    at = read_window()
    dome, flat = figures(), figures(port={"geometry": "flat", "thickness_mm": 10, "refractive_index": 1.5})
    lux, electrons = light_by_hand(at)
    near_m, far_m = depth_of_field_m(at)
    image_m = float(virtual_image_m(at.range_m, at))
    variance = at.dark_noise_e**2 + 1 / (12 * at.gain_dn_per_e**2) + electrons
    width_m = at.range_m * at.width_px * at.pitch_m / at.focal_m
    height_m = at.range_m * at.height_px * at.pitch_m / at.focal_m
    pixel_m = at.range_m * at.pitch_m / at.focal_m
    by_hand = [
        ("(1)", "illuminance of the floor", "floor_illuminance_mean_lx", "lx", lux),
        ("(1), (2), (4), (5)", "electrons in a pixel", "electrons_signal", "e⁻", electrons),
        ("(6)", "mean digital number, 16 bit", "mean_dn", "DN", at.gain_dn_per_e * electrons),
        ("(7)", "signal-to-noise ratio", "snr", "", electrons / math.sqrt(variance)),
        ("(8)", "least frame rate", "frame_rate_min_hz", "Hz", at.speed_m_s / (width_m * (1 - at.overlap))),
        ("(9)", "virtual image from the vertex", "virtual_image_distance_m", "m", image_m),
        ("(9)", "near end of the depth of field", "dof_near_m", "m", near_m),
        ("(9)", "far end of the depth of field", "dof_far_m", "m", far_m),
        ("(10)", "longest exposure by blur", "exposure_max_ms", "ms", 1e3 * at.blur_px * pixel_m / at.speed_m_s),
        ("(11)", "footprint, image width", "fov_x_m", "m", width_m),
        ("(11)", "footprint, image height", "fov_y_m", "m", height_m),
        ("(11)", "pixel on the floor", "gsd_mm", "mm", 1e3 * pixel_m),
    ]  # fmt: skip
    rows = [Row(eq, words, name, unit, value, float(dome[name])) for eq, words, name, unit, value in by_hand]
    longer = ("(3), (11)", "footprint, image width, flat port", "fov_x_m, flat", "m", width_m / N_WATER)
    return [*rows, Row(*longer, float(flat["fov_x_m"]))]


def figures(**parts: Any) -> dict[str, Any]:
    """What uwopt says of the window, with other parts if wanted."""
    import uwopt

    result = uwopt.evaluate(yaml.safe_load(MISSION.read_text()), yaml.safe_load(SYSTEM.read_text()) | parts)
    assert result.design is not None
    return dict(result.design.scenes[0].figures)


# ---------------------------------------------------------------- the page

HEAD = """\
# Physics `paper` against the paper's equations

The window of the founding paper's tool as it opens (`problems/paper-tool-window.yaml` and its system file):
IMX250, 8 mm at F4 behind a dome, 2 m above the floor, 20 000 lm, water I. Each line was worked out by hand
from the paper's equation and compared with what `uwopt evaluate` says in physics `paper`; the last column is
what the tool's window shows. The window's digits are few, and its depth of field has a slip (metres added to
millimetres: 5.00 m instead of 4.97 m).

"""

FOOT = """
The hand values are plain arithmetic, and for the spectral ones an integral over the exact straight lines
between the tables' entries. uwopt samples the spectrum on its own grid, hence the differences in (1) to (7).

Two things are left to know about the tool. It leaves out the 1/π of equation (2), so its electrons are π
times these. And it was run on twenty random configurations, repeated in `tests/evaluation/test_paper_tool.py`:
footprint, longest exposure, frame rate and virtual image agree to rounding; depth of field too, once the slip above is
taken out (else within 1 %, and 2.4 % at one far end of 36 m); electrons, signal-to-noise ratio and image level
within 0.6 % of the tool's divided by π.

This page is written by `docs/make_paper_table.py`; a test keeps it up to date.
"""


def shown_difference(value: float) -> str:
    """A relative difference in per cent; rounding is not worth digits."""
    if abs(value) < 1e-7:
        return "none"
    return f"{100 * value:+.3f} %" if abs(value) > 5e-6 else "below 0.001 %"


def page() -> str:
    """The whole of docs/paper.md."""
    lines = ["| equation | figure | by hand | uwopt | difference | the window |", "|---|---|---|---|---|---|"]
    for row in table():
        unit = f" {row.unit}" if row.unit else ""
        shown = f"{SHOWN[row.name]}{unit}" if row.name in SHOWN else "-"
        cells = (row.equation, row.words, f"{row.by_hand:.5g}{unit}", f"{row.uwopt:.5g}{unit}")
        lines.append(f"| {' | '.join(cells)} | {shown_difference(row.difference)} | {shown} |")
    return HEAD + "\n".join(lines) + "\n" + FOOT


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    PAGE.write_text(page(), encoding="utf-8")

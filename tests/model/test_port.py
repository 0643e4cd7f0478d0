"""The port: refraction, losses and focus, against traced rays, data sheets and amplitude formulas."""

import json
import math
from pathlib import Path
from typing import Any

import casadi
import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uwopt.errors import CatalogError
from uwopt.model import port

REFERENCE = Path(__file__).parents[1] / "reference"
TOOL_RUNS = json.loads((REFERENCE / "paper_tool_runs.json").read_text())["cases"]
TOOL_N_WATER = 1.33

FLAT = {"gap_m": 0.02, "thickness_m": 0.012, "n_glass": 1.49, "n_water": 1.34}
DOME = {"outer_radius_m": 0.1, "thickness_m": 0.01, "n_glass": 1.5, "n_water": 1.33}
# SCHOTT data sheet of N-BK7, the Sellmeier coefficients there and its catalogue indices.
N_BK7 = (0.0, 1.03961212, 0.00600069867, 0.231792344, 0.0200179144, 1.01046945, 103.560653)
# Malitson 1965 for fused silica.
FUSED_SILICA = (0.0, 0.6961663, 0.0684043, 0.4079426, 0.1162414, 0.8974794, 9.896161)

ranges = st.floats(0.05, 50.0)
radii = st.floats(0.02, 0.3)
wall_fractions = st.floats(0.01, 0.4)
glasses = st.floats(1.4, 1.8)
waters = st.floats(1.32, 1.36)


def refracted(direction: np.ndarray, normal: np.ndarray, ratio: float) -> np.ndarray:
    """Snell's law for vectors; `normal` points against the ray, `ratio` is n_from / n_to."""
    cosine = -float(normal @ direction)
    under_root = 1.0 - ratio**2 * (1.0 - cosine**2)
    return ratio * direction + (ratio * cosine - math.sqrt(under_root)) * normal


def traced_flat_floor_m(angle_air: float, range_m: float) -> float:
    """A ray in (off axis, along axis) from the pupil through glass and water, by vectors."""
    normal = np.array([0.0, -1.0])
    direction = np.array([math.sin(angle_air), math.cos(angle_air)])
    x_m, n_now = 0.0, 1.0
    for n_next, depth_m in (
        (1.0, FLAT["gap_m"]),
        (FLAT["n_glass"], FLAT["thickness_m"]),
        (FLAT["n_water"], range_m),
    ):
        direction = refracted(direction, normal, n_now / n_next)
        n_now = n_next
        x_m += depth_m * direction[0] / direction[1]
    return x_m


def traced_dome_image_m(range_m: float) -> float:
    """From the dome's centre to where a ray of the floor's axis point seems to come from, inside."""
    tilt = 1e-4 * DOME["outer_radius_m"] / range_m  # meets the dome 1e-4 R off the axis
    origin = np.array([0.0, -(range_m + DOME["outer_radius_m"])])
    direction = np.array([math.sin(tilt), math.cos(tilt)])
    inner_m = DOME["outer_radius_m"] - DOME["thickness_m"]
    n_now = DOME["n_water"]
    for radius_m, n_next in ((DOME["outer_radius_m"], DOME["n_glass"]), (inner_m, 1.0)):
        along = -float(origin @ direction)
        origin = origin + direction * (along - math.sqrt(along**2 - float(origin @ origin) + radius_m**2))
        direction = refracted(direction, origin / radius_m, n_now / n_next)
        n_now = n_next
    return -float(origin[1] - origin[0] * direction[1] / direction[0])


# ---------------------------------------------------------------- refractive index


@pytest.mark.parametrize(
    ("wavelength_nm", "index"), [(587.5618, 1.51680), (486.1327, 1.52238), (656.2725, 1.51432)]
)
def test_sellmeier_2_gives_the_catalogue_indices_of_bk7(wavelength_nm: float, index: float) -> None:
    got = port.refractive_index_dispersion(wavelength_nm, formula="sellmeier_2", coefficients=N_BK7)
    assert got == pytest.approx(index, abs=6e-6)  # SCHOTT prints five decimals


def test_sellmeier_1_gives_the_sodium_index_of_fused_silica() -> None:
    got = port.refractive_index_dispersion(
        np.array([589.3]), formula="sellmeier_1", coefficients=FUSED_SILICA
    )
    assert got[0] == pytest.approx(1.45840, abs=1e-5)  # tabulated n_D of fused silica, five decimals


def test_polynomial_3_is_a_sum_of_powers() -> None:
    # at L = 2 um: 2 + 0.5 * 2^2 + 4 * 2^-2 = 5
    powers = (2.0, 0.5, 2.0, 4.0, -2.0)
    got = port.refractive_index_dispersion(2000.0, formula="polynomial_3", coefficients=powers)
    assert got == pytest.approx(math.sqrt(5.0), rel=1e-14)


@pytest.mark.parametrize(("formula", "coefficients"), [("cauchy", (1.0,)), ("sellmeier_1", (0.0, 1.0))])
def test_a_wrong_formula_is_a_catalogue_fault(formula: str, coefficients: tuple[float, ...]) -> None:
    with pytest.raises(CatalogError, match=formula):
        port.refractive_index_dispersion(500.0, formula=formula, coefficients=coefficients)


# ---------------------------------------------------------------- losses


def amplitude_transmittances(cosine: float, n1: float, n2: float) -> tuple[float, float]:
    """1 - |r|^2 for s and p light from the amplitude coefficients, complex beyond total reflection."""
    behind = mpmath.sqrt(1 - (mpmath.mpf(n1) / n2) ** 2 * (1 - mpmath.mpf(cosine) ** 2))
    s = (n1 * cosine - n2 * behind) / (n1 * cosine + n2 * behind)
    p = (n2 * cosine - n1 * behind) / (n2 * cosine + n1 * behind)
    return float(1 - abs(s) ** 2), float(1 - abs(p) ** 2)


def unpolarised(cosine: Any, *, n_from: Any, n_to: Any) -> Any:
    """Share of unpolarised light that passes one face."""
    s, p, _ = port.fresnel_by_polarisation(cosine, n_from=n_from, n_to=n_to)
    return 0.5 * (s + p)


@given(cosine=st.floats(0.01, 1.0), n1=st.floats(1.0, 1.8), n2=st.floats(1.0, 1.8))
def test_fresnel_agrees_with_the_amplitude_coefficients(cosine: float, n1: float, n2: float) -> None:
    expected = sum(amplitude_transmittances(cosine, n1, n2)) / 2
    got = unpolarised(cosine, n_from=n1, n_to=n2)
    # rounding of 1 - sin^2 near the critical angle enters by its square root, 1e-8 at worst
    assert got == pytest.approx(expected, abs=3e-7)


def test_crown_glass_reflects_four_percent_head_on() -> None:
    assert unpolarised(1.0, n_from=1.0, n_to=1.5) == pytest.approx(0.96, rel=1e-14)  # 1 - 0.2^2


def test_at_the_brewster_angle_only_s_light_is_reflected() -> None:
    # n = 1.5: R_s = ((n^2 - 1)/(n^2 + 1))^2 = 0.147929, R_p = 0
    cos_brewster = 1.0 / math.sqrt(1.0 + 1.5**2)
    got = unpolarised(cos_brewster, n_from=1.0, n_to=1.5)
    assert got == pytest.approx(1.0 - 0.1479290 / 2.0, abs=1e-7)


def test_nothing_passes_at_grazing_incidence_or_total_reflection() -> None:
    cosines = np.array([0.0, 0.0, 0.5])  # 60 degrees in glass is beyond the critical 41.8
    n_from, n_to = np.array([1.0, 1.5, 1.5]), np.array([1.5, 1.0, 1.0])
    got = unpolarised(cosines, n_from=n_from, n_to=n_to)
    np.testing.assert_array_equal(got, 0.0)


def test_acrylic_port_head_on_by_hand() -> None:
    # (1 - (0.15/2.83)^2) (1 - (0.49/2.49)^2) = 0.997191 * 0.961275 = 0.958575
    assert port.normal_port_transmittance(n_water=1.34, n_glass=1.49) == pytest.approx(0.958575, abs=1e-6)


@given(angle=st.floats(0.0, 1.4))
def test_oblique_flat_port_agrees_with_amplitudes_face_by_face(angle: float) -> None:
    n_glass, n_water = 1.49, 1.34
    cos_glass = math.cos(math.asin(math.sin(angle) / n_glass))
    air = amplitude_transmittances(math.cos(angle), 1.0, n_glass)
    water = amplitude_transmittances(cos_glass, n_glass, n_water)
    expected = 0.5 * (air[0] * water[0] + air[1] * water[1])
    got = port.flat_port_transmittance(math.tan(angle), n_water=n_water, n_glass=n_glass)
    assert got == pytest.approx(expected, rel=1e-9)


# ---------------------------------------------------------------- rays


@pytest.mark.parametrize("angle_deg", [0.0, 1.0, 20.0, 45.0, 70.0])
def test_flat_floor_distance_is_that_of_a_traced_ray(angle_deg: float) -> None:
    angle = math.radians(angle_deg)
    got = port.flat_floor_distance_m(math.tan(angle), range_m=2.0, **FLAT)
    assert got == pytest.approx(traced_flat_floor_m(angle, 2.0), rel=1e-12, abs=1e-15)


@given(tangent=st.floats(-5.0, 5.0))
def test_slope_of_the_floor_distance_is_its_derivative(tangent: float) -> None:
    def by_angle(t: Any) -> Any:
        angle = mpmath.atan(t)
        glass = mpmath.tan(mpmath.asin(mpmath.sin(angle) / FLAT["n_glass"]))
        water = mpmath.tan(mpmath.asin(mpmath.sin(angle) / FLAT["n_water"]))
        return FLAT["gap_m"] * t + FLAT["thickness_m"] * glass + 3 * water

    expected = float(mpmath.diff(by_angle, tangent))
    assert port.flat_floor_derivative(tangent, range_m=3.0, **FLAT) == pytest.approx(expected, rel=1e-9)


@given(tangent=st.floats(-10.0, 10.0))
def test_without_refraction_rays_go_straight(tangent: float) -> None:
    air = {"gap_m": 0.1, "thickness_m": 0.2, "n_glass": 1.0, "n_water": 1.0}
    got = port.flat_floor_distance_m(tangent, range_m=0.7, **air)
    assert got == pytest.approx(tangent, rel=1e-12, abs=1e-300)


def test_behind_a_dome_the_angle_stays() -> None:
    assert port.dome_floor_distance_m(0.5, outer_radius_m=0.1, range_m=1.9) == pytest.approx(1.0)


# ---------------------------------------------------------------- focus


@pytest.mark.parametrize("range_m", [0.1, 0.5, 2.0, 20.0])
def test_dome_image_is_where_paraxial_rays_meet(range_m: float) -> None:
    got = 1.0 / port.lens_dioptre_per_m(range_m, focus_map=port.dome_focus_map(**DOME))
    assert got == pytest.approx(traced_dome_image_m(range_m), rel=1e-6)  # aberration goes with (1e-4)^2


@pytest.mark.parametrize("range_m", [0.1, 0.5, 2.0, 20.0])
def test_flat_port_image_is_where_paraxial_rays_meet(range_m: float) -> None:
    angle = 1e-4
    seen_m = traced_flat_floor_m(angle, range_m) / math.tan(angle)
    got = 1.0 / port.lens_dioptre_per_m(range_m, focus_map=port.flat_focus_map(**FLAT))
    assert got == pytest.approx(seen_m, rel=1e-7)  # aberration goes with the angle squared


@pytest.mark.parametrize("angle_deg", [0.0, 15.0, 35.0, 50.0])
def test_curved_image_of_a_dome_is_the_traced_image_along_the_oblique_ray(angle_deg: float) -> None:
    # every ray through the centre is an axis of the dome: the floor lies (d + R)/cos away along it
    cosine = math.cos(math.radians(angle_deg))
    along_ray_m = (2.0 + DOME["outer_radius_m"]) / cosine - DOME["outer_radius_m"]
    expected = 1.0 / (cosine * traced_dome_image_m(along_ray_m))
    got = port.field_dioptre_per_m(2.0, cos_field=cosine, focus_map=port.dome_focus_map(**DOME))
    assert got == pytest.approx(expected, rel=1e-6)


def test_virtual_image_of_the_paper_tools_window() -> None:
    # the tool's window shows 21.16 cm for R = 100 mm, t = 10 mm, n = 1.5 at 2 m
    assert port.dome_virtual_image_distance_m(2.0, **DOME) == pytest.approx(0.2116, abs=5e-5)


@pytest.mark.parametrize("case", [run for run in TOOL_RUNS if run["housing"] == "domed"])
def test_virtual_image_of_the_paper_tools_runs(case: dict[str, Any]) -> None:
    got = port.dome_virtual_image_distance_m(
        case["altitude_m"],
        outer_radius_m=case["dome_radius_m"],
        thickness_m=case["dome_thickness_m"],
        n_glass=case["port_index"],
        n_water=TOOL_N_WATER,
    )
    assert got == pytest.approx(case["expect"]["virtual_image_distance_m"], rel=1e-6)


def test_thin_dome_images_infinity_three_radii_before_its_vertex() -> None:
    # 1/q' = (1 - 1/n_w)/R; n_w = 4/3: q' = 4 R, whatever the glass
    got = port.dome_virtual_image_distance_m(
        math.inf, outer_radius_m=0.05, thickness_m=0.0, n_glass=1.6, n_water=4.0 / 3.0
    )
    assert got == pytest.approx(0.15, rel=1e-12)


@given(range_m=ranges, radius_m=radii, wall=wall_fractions, n_glass=glasses, n_water=waters)
def test_paper_map_counts_the_same_image_from_the_vertex(
    range_m: float, radius_m: float, wall: float, n_glass: float, n_water: float
) -> None:
    dome = {
        "outer_radius_m": radius_m,
        "thickness_m": wall * radius_m,
        "n_glass": n_glass,
        "n_water": n_water,
    }
    from_vertex_m = port.dome_virtual_image_distance_m(range_m, **dome)
    if from_vertex_m < 1e-3:  # a thick dome's image of its own vertex lies inside the glass
        return
    got = port.lens_dioptre_per_m(range_m, focus_map=port.paper_dome_focus_map(**dome))
    assert 1.0 / got == pytest.approx(from_vertex_m, rel=1e-9)


MAPS = {
    "identity": port.identity_focus_map(),
    "flat": port.flat_focus_map(**FLAT),
    "dome": port.dome_focus_map(**DOME),
    "paper dome": port.paper_dome_focus_map(**DOME),
}


@pytest.mark.parametrize("name", MAPS)
@given(range_m=ranges)
def test_dioptre_and_distance_are_inverse(name: str, range_m: float) -> None:
    dioptre = port.lens_dioptre_per_m(range_m, focus_map=MAPS[name])
    assert port.water_distance_m(dioptre, focus_map=MAPS[name]) == pytest.approx(range_m, rel=1e-9)


@pytest.mark.parametrize("name", MAPS)
@given(dioptre=st.floats(-1e3, 1e3))
def test_distance_in_water_is_never_negative_nor_undefined(name: str, dioptre: float) -> None:
    distance_m = port.water_distance_m(dioptre, focus_map=MAPS[name])
    assert distance_m >= 0.0
    if dioptre <= MAPS[name].infinity_per_m:
        assert distance_m == math.inf
    elif dioptre > MAPS[name].infinity_per_m + 1e-9:
        assert math.isfinite(distance_m)


@pytest.mark.parametrize("name", MAPS)
def test_infinity_goes_there_and_back(name: str) -> None:
    dioptre = port.lens_dioptre_per_m(math.inf, focus_map=MAPS[name])
    assert port.water_distance_m(dioptre, focus_map=MAPS[name]) == math.inf


def test_one_map_serves_many_ports() -> None:
    radii_m = np.array([0.05, 0.1])
    many = port.dome_focus_map(outer_radius_m=radii_m, thickness_m=0.01, n_glass=1.5, n_water=1.33)
    got = port.lens_dioptre_per_m(2.0, focus_map=many)
    assert got[1] == port.lens_dioptre_per_m(2.0, focus_map=MAPS["dome"])
    assert got.shape == (2,)


@given(range_m=ranges)
def test_a_port_of_water_in_water_changes_nothing(range_m: float) -> None:
    # n = 1 everywhere: a dome is absent, its map counts from the centre
    absent = port.dome_focus_map(outer_radius_m=0.1, thickness_m=0.01, n_glass=1.0, n_water=1.0)
    assert 1.0 / port.lens_dioptre_per_m(range_m, focus_map=absent) == pytest.approx(range_m + 0.1)


@pytest.mark.parametrize("name", MAPS)
def test_focus_maps_accept_symbols(name: str, symbol: Any) -> None:
    focus_map = MAPS[name]
    both = casadi.Function(
        "both",
        [symbol],
        [
            port.water_distance_m(symbol, focus_map=focus_map),
            port.lens_dioptre_per_m(symbol, focus_map=focus_map),
            port.field_dioptre_per_m(symbol, cos_field=0.8, focus_map=focus_map),
        ],
    )
    got = [float(value) for value in both(5.0)]
    assert got[0] == pytest.approx(float(port.water_distance_m(5.0, focus_map=focus_map)), rel=1e-14)
    assert got[1] == pytest.approx(port.lens_dioptre_per_m(5.0, focus_map=focus_map), rel=1e-14)
    assert got[2] == pytest.approx(
        port.field_dioptre_per_m(5.0, cos_field=0.8, focus_map=focus_map), rel=1e-14
    )


def test_rays_accept_symbols(symbol: Any) -> None:
    rays = casadi.Function(
        "rays",
        [symbol],
        [
            port.flat_floor_distance_m(symbol, range_m=2.0, **FLAT),
            port.flat_floor_derivative(symbol, range_m=2.0, **FLAT),
            port.normal_port_transmittance(n_water=1.34, n_glass=1.0 + symbol),
        ],
    )
    got = [float(value) for value in rays(0.5)]
    assert got[0] == pytest.approx(traced_flat_floor_m(math.atan(0.5), 2.0), rel=1e-12)
    assert got[1] == pytest.approx(port.flat_floor_derivative(0.5, range_m=2.0, **FLAT), rel=1e-14)
    assert got[2] == pytest.approx(port.normal_port_transmittance(n_water=1.34, n_glass=1.5), rel=1e-14)

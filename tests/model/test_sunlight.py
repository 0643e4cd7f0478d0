"""Sunlight in water against hand values, vectors and adaptive quadrature."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from uwopt.errors import RangeError
from uwopt.model import phase_formulas, scattering, sunlight

N_WATER = 1.34
HIGH_RAD = math.radians(60.0)
G = 0.85
TABLE = scattering.phase_table_of(
    lambda angle: phase_formulas.henyey_greenstein_per_sr(np.cos(angle), asymmetry=G)
)
SURFACE = np.array([1.2, 0.7])
WATER = {
    "kd_per_m": np.array([0.06, 0.3]),
    "attenuation_per_m": np.array([0.25, 0.6]),
    "scattering_per_m": np.array([0.2, 0.15]),
    "table": TABLE,
    "n_water": N_WATER,
}

elevations = st.floats(math.radians(5.0), math.pi / 2)
depths = st.floats(0.0, 200.0)


def sun_in_water(elevation_rad):
    """Unit vector along which sunlight travels: x away from the sun, z down."""
    sine = math.cos(elevation_rad) / N_WATER
    return np.array([sine, 0.0, math.sqrt(1 - sine**2)])


def veil(**changes):
    case = {**WATER, "depth_m": 30.0, "path_m": 2.0, "elevation_rad": HIGH_RAD, **changes}
    return sunlight.path_radiance_w_m2_sr_nm(SURFACE, **case)


def veil_by_quadrature(column, *, depth_m, path_m, cos_field, azimuth_rad, elevation_rad):
    """The integral of single scattering, point by point, with vectors."""
    sun = sun_in_water(elevation_rad)
    sin_field = math.sqrt(1 - cos_field**2)
    ray = np.array([sin_field * math.cos(azimuth_rad), sin_field * math.sin(azimuth_rad), cos_field])
    cos_angle = float(sun @ -ray)  # light travels on from the point towards the camera
    beta = WATER["scattering_per_m"][column] * float(
        phase_formulas.henyey_greenstein_per_sr(cos_angle, asymmetry=G)
    )
    high_sun = sun_in_water(HIGH_RAD)[2]
    share = float(sunlight.surface_factor(elevation_rad, n_water=N_WATER))
    attenuation = WATER["attenuation_per_m"][column]

    def integrand(r):
        z = depth_m - (path_m - r) * cos_field
        e_d = SURFACE[column] * share * math.exp(-WATER["kd_per_m"][column] * high_sun / sun[2] * z)
        return beta * e_d / sun[2] * math.exp(-attenuation * r)

    return quad(integrand, 0, path_m, epsabs=0, epsrel=1e-11)[0]


# ---------------------------------------------------------------- through the surface


def test_sun_at_sixty_degrees_comes_down_at_twenty_two_in_water():
    # zenith angle 30 deg: sin = 0.5/1.34 = 0.373134, cos = sqrt(1 - 0.139229) = 0.927777
    assert sunlight.refracted_cos_zenith(HIGH_RAD, n_water=1.34) == pytest.approx(0.927777, abs=1e-6)


def test_sun_on_the_horizon_comes_down_at_the_critical_angle():
    # sin = 1/n: cos = sqrt(1 - 1/1.34^2) = 0.665645
    assert sunlight.refracted_cos_zenith(1e-9, n_water=1.34) == pytest.approx(0.665645, abs=1e-6)


def test_factors_of_the_surface_are_those_of_the_physics_page_at_sixty_degrees():
    assert sunlight.surface_factor(HIGH_RAD, n_water=N_WATER) == pytest.approx(0.95)
    assert sunlight.path_factor(HIGH_RAD, n_water=N_WATER) == pytest.approx(1.0)


def test_sun_at_the_zenith_enters_as_fresnels_normal_incidence():
    # T(90) = 4 n/(n + 1)^2 = 0.978887; T(60 deg) by hand: cos 30 = 0.866025, n cos_w = 1.243221, n cos_a = 1.160474
    # r_s = -0.377196/2.109246 = -0.178830, r_p = 0.232697/2.088251 = 0.111432; T = 1 - (0.031980 + 0.012417)/2
    # = 0.977801
    expected = 0.95 * 0.978887 / 0.977801
    assert sunlight.surface_factor(math.pi / 2, n_water=1.34) == pytest.approx(expected, rel=3e-6)


def test_at_brewsters_angle_only_half_of_the_light_is_reflected_at_all():
    # tan(zenith) = n: r_p = 0, r_s = (1 - n^2)/(1 + n^2)
    brewster = sunlight.surface_factor(math.pi / 2 - math.atan(N_WATER), n_water=N_WATER)
    normal = sunlight.surface_factor(math.pi / 2, n_water=N_WATER)
    t_brewster = 1 - ((1 - N_WATER**2) / (1 + N_WATER**2)) ** 2 / 2
    assert brewster / normal == pytest.approx(t_brewster * (N_WATER + 1) ** 2 / (4 * N_WATER))


@given(low=elevations, high=elevations)
def test_higher_sun_sends_more_light_down_a_shorter_way(low, high):
    low, high = sorted((low, high))
    factor = sunlight.surface_factor(np.array([low, high]), n_water=N_WATER)
    way = sunlight.path_factor(np.array([low, high]), n_water=N_WATER)
    assert factor[0] <= factor[1] * (1 + 1e-12)
    assert way[0] >= way[1] * (1 - 1e-12)


def test_low_sun_gives_no_light_in_the_limit():
    assert sunlight.surface_factor(1e-7, n_water=N_WATER) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("elevation_deg", [0.0, -10.0])
def test_sun_below_the_horizon_is_refused(elevation_deg):
    elevation = math.radians(elevation_deg)
    for function in (sunlight.surface_factor, sunlight.refracted_cos_zenith, sunlight.path_factor):
        with pytest.raises(RangeError, match="set sun_lux to 0"):
            function(elevation, n_water=N_WATER)


def test_sun_beyond_the_zenith_is_refused():
    with pytest.raises(RangeError, match="at most 90 deg"):
        sunlight.surface_factor(math.radians(91.0), n_water=N_WATER)


# ---------------------------------------------------------------- down to the floor


def test_irradiance_at_depth_is_that_of_the_physics_page():
    # 0.95 exp(-0.06 * 30) = 0.95 * 0.165299 = 0.157034; 0.95 exp(-9) = 1.17239e-4
    got = sunlight.downwelling_irradiance_w_m2_nm(
        SURFACE, kd_per_m=WATER["kd_per_m"], depth_m=30.0, elevation_rad=HIGH_RAD, n_water=N_WATER
    )
    assert got == pytest.approx([1.2 * 0.157034, 0.7 * 1.17239e-4], rel=1e-5)


def test_irradiance_broadcasts_over_depth():
    depth = np.array([[0.0, 1.0, 10.0]])
    case = {"kd_per_m": WATER["kd_per_m"], "elevation_rad": 0.7, "n_water": N_WATER}
    got = sunlight.downwelling_irradiance_w_m2_nm(SURFACE, depth_m=depth, **case)
    assert got.shape == (1, 3, 2)
    single = sunlight.downwelling_irradiance_w_m2_nm(SURFACE, depth_m=10.0, **case)
    np.testing.assert_allclose(got[0, 2], single)


@given(first=depths, second=depths, elevation=elevations)
def test_each_metre_of_water_takes_the_same_share(first, second, elevation):
    case = {"kd_per_m": [0.05], "elevation_rad": elevation, "n_water": N_WATER}
    e = sunlight.downwelling_irradiance_w_m2_nm([1.0], depth_m=[0.0, first, second, first + second], **case)[
        :, 0
    ]
    assert e[0] * e[3] == pytest.approx(e[1] * e[2], rel=1e-9)


def test_depth_above_the_surface_is_refused():
    with pytest.raises(RangeError, match="above the surface"):
        sunlight.downwelling_irradiance_w_m2_nm(
            SURFACE, kd_per_m=[0.1, 0.1], depth_m=-1.0, elevation_rad=1.0, n_water=N_WATER
        )


def test_deep_water_is_dark_and_not_a_fault():
    got = sunlight.downwelling_irradiance_w_m2_nm(
        SURFACE, kd_per_m=[0.5, 2.0], depth_m=6000.0, elevation_rad=1.0, n_water=N_WATER
    )
    assert np.all(got == 0)


# ---------------------------------------------------------------- into the camera


def test_camera_looking_down_under_a_high_sun_sees_light_turned_round():
    assert sunlight.scattering_cosine(
        1.0, azimuth_rad=0.3, elevation_rad=math.pi / 2, n_water=N_WATER
    ) == pytest.approx(-1.0)


@given(elevation=elevations, field=st.floats(0, math.pi), azimuth=st.floats(0, 2 * math.pi))
def test_scattering_angle_is_that_between_vectors(elevation, field, azimuth):
    ray = np.array(
        [math.sin(field) * math.cos(azimuth), math.sin(field) * math.sin(azimuth), math.cos(field)]
    )
    got = sunlight.scattering_cosine(
        math.cos(field), azimuth_rad=azimuth, elevation_rad=elevation, n_water=N_WATER
    )
    assert got == pytest.approx(-float(ray @ sun_in_water(elevation)), abs=1e-7)


@given(
    depth=st.floats(3.0, 60.0),
    path=st.floats(0.01, 3.0),
    cos_field=st.floats(0.4, 1.0),
    azimuth=st.floats(0.0, 2 * math.pi),
    elevation=elevations,
)
@settings(max_examples=50)
def test_veil_is_the_integral_along_the_ray(depth, path, cos_field, azimuth, elevation):
    case = {
        "depth_m": depth, "path_m": path, "cos_field": cos_field, "azimuth_rad": azimuth,
        "elevation_rad": elevation,
    }  # fmt: skip
    expected = [veil_by_quadrature(column, **case) for column in (0, 1)]
    np.testing.assert_allclose(veil(**case), expected, rtol=1e-6)  # of the phase table


def test_veil_over_all_azimuths_is_the_mean_of_each():
    case = {"cos_field": 0.6, "elevation_rad": math.radians(35.0)}
    each = [
        quad(lambda phi, k=column: float(veil(azimuth_rad=phi, **case)[k]), 0, 2 * math.pi, epsrel=1e-8)[0]
        for column in (0, 1)
    ]
    np.testing.assert_allclose(veil(**case), np.array(each) / (2 * math.pi), rtol=1e-6)


def test_azimuth_is_idle_when_the_camera_looks_straight_down():
    np.testing.assert_allclose(veil(azimuth_rad=1.2), veil(), rtol=1e-12)


def test_short_path_veils_in_proportion_to_its_length():
    np.testing.assert_allclose(
        veil(path_m=1e-6, depth_m=30.0), veil(path_m=1e-3, depth_m=30.0) / 1000, rtol=1e-3
    )


def test_long_path_has_the_veil_of_endless_water():
    # L = beta E_d(port)/(mu_w (c + K cos a)); port at the surface here
    path = 500.0
    got = veil(depth_m=path, path_m=path)
    mu = sun_in_water(HIGH_RAD)[2]
    phase = phase_formulas.henyey_greenstein_per_sr(-mu, asymmetry=G)
    k = WATER["attenuation_per_m"] + WATER["kd_per_m"]
    np.testing.assert_allclose(got, WATER["scattering_per_m"] * phase * SURFACE * 0.95 / mu / k, rtol=1e-6)


def test_two_thousand_attenuation_lengths_are_harmless():
    got = veil(attenuation_per_m=np.array([1000.0, 0.6]), depth_m=2.0, path_m=2.0)
    assert np.all(np.isfinite(got) & (got > 0))
    deep = veil(attenuation_per_m=np.array([1000.0, 1000.0]), depth_m=5000.0, path_m=2.0)
    assert np.all(np.isfinite(deep) & (deep >= 0))


def test_ray_upwards_along_which_gain_and_loss_cancel_is_regular():
    # looking up: k = c - K |cos a|; c = K cos a exactly, and a hair beside it
    equal, beside, beyond = (
        veil(
            kd_per_m=np.array([0.5, 0.5]),
            attenuation_per_m=0.25 * np.array([1.0, 1.0]) + change,
            cos_field=-0.5,
            depth_m=3.0,
        )
        for change in (0.0, 1e-12, -1e-12)
    )
    np.testing.assert_allclose(equal, beside, rtol=1e-10)
    np.testing.assert_allclose(equal, beyond, rtol=1e-10)


def test_molecular_scattering_adds_its_own_veil():
    water_only = veil(
        scattering_per_m=np.zeros(2), molecular_scattering_per_m=np.array([0.003, 0.001]), azimuth_rad=0.0
    )
    both = veil(molecular_scattering_per_m=np.array([0.003, 0.001]), azimuth_rad=0.0)
    np.testing.assert_allclose(both - veil(azimuth_rad=0.0), water_only, rtol=1e-9)
    # against particles: p_w(-mu)/p(-mu)
    mu = sun_in_water(HIGH_RAD)[2]
    ratio = phase_formulas.molecular_per_sr(-mu) / phase_formulas.henyey_greenstein_per_sr(-mu, asymmetry=G)
    expected = veil(azimuth_rad=0.0) * ratio * [0.003 / 0.2, 0.001 / 0.15]
    np.testing.assert_allclose(water_only, expected, rtol=1e-6)


def test_veil_broadcasts_over_pixels_and_altitudes():
    got = veil(path_m=np.array([[1.0], [2.0]]), cos_field=np.array([1.0, 0.9, 0.8]), depth_m=30.0)
    assert got.shape == (2, 3, 2)
    np.testing.assert_allclose(got[1, 2], veil(path_m=2.0, cos_field=0.8))


def test_camera_above_the_surface_is_refused():
    with pytest.raises(RangeError, match="above the surface"):
        veil(depth_m=1.0, path_m=2.0)


def test_daylight_of_all_orders_is_the_integral_of_what_is_sent_back():
    # B = 0.897 b p + 1.10 (K/a - 1) b_b / (2 pi), 30 m deep, 2 m at 0.8: adaptive quadrature along the ray
    water = {"kd_per_m": 0.09, "absorption_per_m": 0.06, "turned_per_m_sr": 0.0007, "backward_per_m": 0.004}
    many = {name: np.full(2, value) for name, value in water.items()}
    seen = dict(depth_m=30.0, path_m=2.0, cos_field=0.8, elevation_rad=HIGH_RAD, n_water=N_WATER)
    found = sunlight.diffuse_path_radiance_w_m2_sr_nm(SURFACE, **many, **seen)
    source = (0.897 * 0.0007 + 1.10 * 0.5 * 0.004 / (2 * math.pi)) / sun_in_water(HIGH_RAD)[2]

    def integrand(r):
        return source * 0.95 * SURFACE[0] * math.exp(-0.09 * (30.0 - (2.0 - r) * 0.8)) * math.exp(-0.06 * r)

    assert found[0] == pytest.approx(quad(integrand, 0, 2.0, epsrel=1e-11)[0], rel=1e-9)
    assert found[1] / found[0] == pytest.approx(SURFACE[1] / SURFACE[0])


def test_daylight_of_all_orders_takes_k_d_for_no_less_than_a():
    def seen(kd):
        return sunlight.diffuse_path_radiance_w_m2_sr_nm(
            SURFACE, kd_per_m=np.full(2, kd), absorption_per_m=np.full(2, 0.06), backward_per_m=np.full(2, 0.004),
            turned_per_m_sr=np.full(2, 0.0006),
            depth_m=0.0, path_m=0.0 + 1e-6, cos_field=0.0, elevation_rad=HIGH_RAD, n_water=N_WATER,
        )  # fmt: skip

    assert seen(0.03) == pytest.approx(seen(0.06)) and np.all(seen(0.12) > 2 * seen(0.06))

"""The model's functions at extreme numbers, against the documented equations in arbitrary precision.

References are written in mpmath with 60 digits from the physics page; nothing of uwopt is in them.
"""

from __future__ import annotations

import math
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from reference.physics import photo_electrons

from uwopt.model import (
    beam,
    defocus,
    lens,
    light,
    operation,
    path_table,
    port,
    seafloor,
    sensor,
    spectrum,
    water,
)
from uwopt.model import sharpness as sharp

mp.mp.dps = 60
ROUNDING = 1e-13  # a few operations in double precision
N_W, N_G = 1.34, 1.5
WAVES_NM = np.array([450.0, 500.0, 550.0, 600.0, 650.0])


def close(got: Any, wanted: Any, rel: float = ROUNDING) -> None:
    """A finite number equal to the reference; 0 only where no float could hold the reference."""
    got = float(got)
    assert math.isfinite(got)
    if abs(wanted) < mp.mpf("1e-300"):
        assert abs(got) < 1e-299
    else:
        assert abs(mp.mpf(got) - wanted) <= rel * abs(wanted), (got, mp.nstr(wanted, 17))


# ---------------------------------------------------------------- water: c r from 0 to 2000


@pytest.mark.parametrize("optical", [0.0, 1.0, 100.0, 2000.0])
def test_tables_of_long_paths_meet_their_tolerance(optical: float) -> None:
    """The polynomial that stands for it, on ranges from a tenth to all of the path."""
    c = optical / 4.0 * np.array([1.0, 1.02, 0.9, 1.4, 2.0])
    weight = np.array([1.0, 0.2, 3.0, 5.0, 0.5])
    common: dict[str, Any] = {"wavelength_nm": WAVES_NM, "k_lamp_per_m": c, "c_camera_per_m": c}
    with np.errstate(under="ignore"):
        made = path_table.build_path_table(
            weight, lamp_range_m=(0.2, 2.0), camera_range_m=(0.2, 2.0), **common
        )
        got = path_table.log_mean_transmission(made, np.array([0.2, 0.9, 2.0]), np.array([1.0, 0.3, 2.0]))
    for value, lamp_m, camera_m in zip(got, (0.2, 0.9, 2.0), (1.0, 0.3, 2.0), strict=True):
        share = [mp.mpf(w) * s for w, s in zip(weight, (25, 50, 50, 50, 25), strict=True)]
        left = [
            s * mp.exp(-mp.mpf(a) * (mp.mpf(lamp_m) + mp.mpf(camera_m)))
            for s, a in zip(share, c, strict=True)
        ]
        wanted = mp.log(mp.fsum(left) / mp.fsum(share))
        assert abs(value - wanted) <= max(2 * made.max_error_log, 1e-12 * optical, 1e-12)


@pytest.mark.parametrize(("a", "b", "k"), [(0.3, 0.0, 0.3), (0.0, 0.3, 0.3 * 0.0183), (0.0, 0.0, 0.0)])
def test_pure_absorption_and_pure_scattering_bound_the_lamps_attenuation(
    a: float, b: float, k: float
) -> None:
    """K_d of 0 is clipped to a + b_b: pure absorption loses all of it, pure scattering only what turns back."""
    got = water.illumination_attenuation_per_m(a, b_per_m=b, kd_per_m=0.0, backscatter_ratio=0.0183)
    assert got == pytest.approx(k, rel=1e-15)


# ---------------------------------------------------------------- light and sensor


@pytest.mark.parametrize("flux_lm", [1.0, 1e7])
@pytest.mark.parametrize("exposure_s", [1e-6, 60.0])
@pytest.mark.parametrize("f_number", [0.95, 64.0])
@pytest.mark.parametrize("altitude_m", [0.01, 100.0])
def test_electrons_of_extreme_settings(
    flux_lm: float, exposure_s: float, f_number: float, altitude_m: float
) -> None:
    """Equations (2), (4), (5) in a row: 26 decades of electrons."""
    power, photopic = np.array([0.5, 1.0, 2.0, 1.0, 0.1]), np.array([0.04, 0.3, 0.99, 0.63, 0.1])
    flux = light.spectral_flux_w_nm(
        flux_lm, relative_spectrum=power, wavelength_nm=WAVES_NM, photopic=photopic
    )
    floor = seafloor.lambertian_radiance(flux / altitude_m**2, reflectance=0.2)
    image = lens.image_irradiance(floor, transmission=0.9, working_f_number=f_number)
    got = photo_electrons(
        image, wavelength_nm=WAVES_NM, quantum_efficiency=0.6, pixel_pitch_m=3.45e-6, exposure_s=exposure_s
    )
    steps = [mp.mpf(x) for x in (25, 50, 50, 50, 25)]
    lumens = mp.mpf("683.002") * mp.fsum(
        mp.mpf(v) * s * w for v, s, w in zip(photopic, power, steps, strict=True)
    )
    photons = mp.fsum(
        mp.mpf(p) * w * mp.mpf(nm) * mp.mpf("1e-9") for p, w, nm in zip(power, steps, WAVES_NM, strict=True)
    )
    wanted = mp.mpf(flux_lm) / lumens * photons / mp.mpf(altitude_m) ** 2 * mp.mpf(0.2) / mp.pi
    wanted *= (
        mp.pi
        / 4
        * mp.mpf(0.9)
        / mp.mpf(f_number) ** 2
        * mp.mpf(0.6)
        * mp.mpf(3.45e-6) ** 2
        * mp.mpf(exposure_s)
    )
    wanted /= mp.mpf("6.62607015e-34") * 299792458
    close(got, wanted)


@pytest.mark.parametrize("read_noise_e", [0.0, 2.4, 1e3])
@pytest.mark.parametrize("signal_e", [0.0, 1e-30, 1.0, 1e7])
@pytest.mark.parametrize("veil_e", [0.0, 1e7])
def test_snr_of_dark_and_bright_pixels(read_noise_e: float, signal_e: float, veil_e: float) -> None:
    """Equation (7), read noise 0 and wells of 1e7 included."""
    got = sensor.snr(
        signal_e, veil_e=veil_e, read_noise_e=read_noise_e, gain_dn_per_e=0.35, dark_e=0.0, prnu_frac=0.01
    )
    every = mp.mpf(signal_e) + mp.mpf(veil_e)
    variance = mp.mpf(read_noise_e) ** 2 + 1 / (12 * mp.mpf(0.35) ** 2) + every + (mp.mpf(0.01) * every) ** 2
    close(got, mp.mpf(signal_e) / mp.sqrt(variance))


@pytest.mark.parametrize("wanted", [0.1, 1.0, 100.0, 1e4])
@pytest.mark.parametrize("sigma2", [0.0, 5.76, 1e8])
@pytest.mark.parametrize("kappa", [0.0, 1e-12, 1e6])
def test_electrons_for_any_wanted_snr(wanted: float, sigma2: float, kappa: float) -> None:
    """mu = [S^2 (1 + k) + sqrt(S^4 (1 + k)^2 + 4 S^2 sigma^2)] / 2, section 6; and it has that SNR."""
    got = sensor.electrons_for_snr(wanted, noise_variance_e2=sigma2, veil_ratio=kappa)
    s2, one = mp.mpf(wanted) ** 2, 1 + mp.mpf(kappa)
    mu = (s2 * one + mp.sqrt(s2**2 * one**2 + 4 * s2 * mp.mpf(sigma2))) / 2
    close(got, mu)
    reached = mp.mpf(float(got)) / mp.sqrt(mp.mpf(sigma2) + one * mp.mpf(float(got)))
    assert abs(reached / wanted - 1) < 1e-12


@pytest.mark.parametrize("wanted", [0.1, 1.0, 90.0, 1e4])
@pytest.mark.parametrize("per_light", [1e-12, 1.0, 1e9])
@pytest.mark.parametrize("read_noise_e", [0.0, 2.4])
def test_light_for_any_wanted_snr(wanted: float, per_light: float, read_noise_e: float) -> None:
    """The root of (C X)^2 = S^2 (sigma^2 + A X + (PRNU A X)^2); infinite where PRNU alone spoils it."""
    got = float(
        sensor.light_for_snr(
            wanted, signal_per_light_e=per_light, total_per_light_e=1.5 * per_light, read_noise_e=read_noise_e,
            prnu_frac=0.005,
        )
    )  # fmt: skip
    c, s2 = mp.mpf(per_light), mp.mpf(wanted) ** 2
    a = mp.mpf(1.5 * per_light)
    square = c**2 - s2 * (mp.mpf(0.005) * a) ** 2
    if square <= 0:
        assert got == math.inf  # documented
        return
    floor, slope = s2 * mp.mpf(read_noise_e) ** 2, s2 * a
    close(
        got, (slope + mp.sqrt(slope**2 + 4 * square * floor)) / (2 * square), rel=1e-11
    )  # 1 - 0.46 in `square`


# ---------------------------------------------------------------- motion


@pytest.mark.parametrize("speed_m_s", [0.0, 1e-9, 20.0])
@pytest.mark.parametrize("overlap", [0.0, 0.99])
def test_motion_at_rest_and_in_haste(speed_m_s: float, overlap: float) -> None:
    """Equations (8) and (10); at rest there is no limit, said as infinity, without a division by zero."""
    gsd_m, footprint_m = 1e-3, 0.8
    rate = operation.frame_rate_hz(speed_m_s, footprint_along_m=footprint_m, overlap=overlap)
    close(rate, mp.mpf(speed_m_s) / (mp.mpf(footprint_m) * (1 - mp.mpf(overlap))))
    exposure = operation.blur_exposure_s(1.0, ground_sample_m=gsd_m, speed_m_s=speed_m_s)
    if speed_m_s == 0.0:
        assert exposure == math.inf
    else:
        close(exposure, mp.mpf(gsd_m) / mp.mpf(speed_m_s))
    for t in (1e-6, 60.0):
        close(
            operation.blur_px(t, ground_sample_m=gsd_m, speed_m_s=speed_m_s),
            mp.mpf(t) * mp.mpf(speed_m_s) / mp.mpf(gsd_m),
        )


# ---------------------------------------------------------------- focus


@pytest.mark.parametrize("f_number", [0.95, 64.0])
@pytest.mark.parametrize("of_hyperfocal", [0.01, 0.5, 0.999, 1.001, 10.0, 1e6])
@pytest.mark.parametrize("dome", [True, False])
def test_depth_of_field_inside_at_and_beyond_hyperfocal(
    f_number: float, of_hyperfocal: float, dome: bool
) -> None:
    """near = s (H - f)/(H + s - 2 f), far = s (H - f)/(H - s) or infinite, taken through the port to water."""
    f, coc, e, t_g, radius = 8e-3, 6.9e-6, 0.005, 0.01, 0.1
    h = mp.mpf(f) ** 2 / (mp.mpf(f_number) * mp.mpf(coc)) + mp.mpf(f)
    s = max(mp.mpf(of_hyperfocal) * h, mp.mpf("0.02"))
    s_near = s * (h - f) / (h + s - 2 * mp.mpf(f))
    s_far = s * (h - f) / (h - s) if s < h else mp.inf
    if dome:
        at = port.dome_focus_map(outer_radius_m=radius, thickness_m=t_g, n_glass=N_G, n_water=N_W)
        power = (1 / mp.mpf(N_G) - 1 / mp.mpf(N_W)) / mp.mpf(radius)
        power += (1 - 1 / mp.mpf(N_G)) / (mp.mpf(radius) - mp.mpf(t_g))

        def in_water(distance: Any) -> Any:
            excess = 1 / distance - power
            return mp.inf if excess <= 0 else max(1 / (N_W * excess) - mp.mpf(radius), mp.mpf(0))
    else:
        at = port.flat_focus_map(gap_m=e, thickness_m=t_g, n_glass=N_G, n_water=N_W)

        def in_water(distance: Any) -> Any:
            return mp.inf if distance == mp.inf else max(N_W * (distance - e - mp.mpf(t_g) / N_G), mp.mpf(0))

    near, far = lens.near_far_water_m(
        f_number, focal_length_m=f, circle_of_confusion_m=coc, focus_dioptre_per_m=float(1 / s), focus_map=at
    )
    for got, wanted in ((near, in_water(s_near)), (far, in_water(s_far))):
        if wanted == mp.inf:
            assert got == math.inf
        else:
            assert abs(float(got) - wanted) <= 2e-11 * (
                1 + wanted**2
            )  # rounding of 1/s, magnified by q^2 / n_w
    assert 0.0 <= near <= far


@pytest.mark.parametrize("f_number", [0.95, 64.0])
@pytest.mark.parametrize("step", [-1, 0, 1])
def test_depth_of_field_at_hyperfocal_itself(f_number: float, step: int) -> None:
    """Focused at H, to the last digit: from H / 2 to infinity, or so far that only rounding ends it."""
    f, coc = 8e-3, 6.9e-6
    h = mp.mpf(f) ** 2 / (mp.mpf(f_number) * mp.mpf(coc)) + mp.mpf(f)
    dioptre = float(1 / h) * (1 + step * 2.0**-52)
    at = port.flat_focus_map(gap_m=0.0, thickness_m=0.0, n_glass=N_G, n_water=N_W)
    near, far = lens.near_far_water_m(
        f_number, focal_length_m=f, circle_of_confusion_m=coc, focus_dioptre_per_m=dioptre, focus_map=at
    )
    close(near, mp.mpf(N_W) * h / 2, rel=1e-14)
    assert far == math.inf or far > 1e12


@pytest.mark.parametrize("within", [1e-12, 0.5, 1.0, 1.0 + 1e-12, 3.0])
def test_no_f_number_focuses_within_the_focal_length(within: float) -> None:
    """N = (f^2 / c) half / (1 - f D), infinite from f D = 1 on: never negative, never a division by zero."""
    f, coc, half = 8e-3, 6.9e-6, 0.05
    got = lens.f_number_to_cover(
        within / f + half, far_dioptre_per_m=within / f - half, focal_length_m=f, circle_of_confusion_m=coc
    )
    reach = 1 - mp.mpf(f) * (mp.mpf(within / f + half) + mp.mpf(within / f - half)) / 2
    if reach <= 1e-15:
        assert got == math.inf
    else:
        close(
            got, mp.mpf(f) ** 2 / mp.mpf(coc) * mp.mpf(half) / reach, rel=1e-11
        )  # half: difference of dioptres


# ---------------------------------------------------------------- ports


@pytest.mark.parametrize("inner_m", [1e-9, 1e-6, 1e-3, 0.0999])
@pytest.mark.parametrize("range_m", [0.01, 1.0, 100.0, math.inf])
def test_virtual_image_of_a_dome_nearly_as_thick_as_its_radius(inner_m: float, range_m: float) -> None:
    """1/q' = 1/(n_w (d + R)) + (1/n_g - 1/n_w)/R + (1 - 1/n_g)/(R - t_g)."""
    radius = 0.1
    thickness = radius - inner_m
    got = port.dome_virtual_image_distance_m(
        range_m, outer_radius_m=radius, thickness_m=thickness, n_glass=N_G, n_water=N_W
    )
    r, n_g, n_w = mp.mpf(radius), mp.mpf(N_G), mp.mpf(N_W)
    far = mp.mpf(0) if math.isinf(range_m) else 1 / (n_w * (mp.mpf(range_m) + r))
    inverse = far + (1 / n_g - 1 / n_w) / r + (1 - 1 / n_g) / (r - mp.mpf(thickness))
    assert abs(float(got) - (1 / inverse - r)) < 1e-14  # metres; q' - R, both of 0.1 m or less


@pytest.mark.parametrize("tan_air", [0.0, 1e-9, 1.0, 1e3, 1e8])
def test_rays_through_a_flat_port_up_to_grazing(tan_air: float) -> None:
    """x = e tan a + t_g tan g + d tan w by Snell; its derivative; and what both faces let through."""
    geometry: dict[str, Any] = {
        "gap_m": 0.005, "thickness_m": 0.01, "n_glass": N_G, "n_water": N_W, "range_m": 2.0,
    }  # fmt: skip
    angle = mp.atan(mp.mpf(tan_air))

    def distance(a: Any) -> Any:
        glass, wet = mp.asin(mp.sin(a) / mp.mpf(N_G)), mp.asin(mp.sin(a) / mp.mpf(N_W))
        return mp.mpf(0.005) * mp.tan(a) + mp.mpf(0.01) * mp.tan(glass) + 2 * mp.tan(wet)

    close(port.flat_floor_distance_m(tan_air, **geometry), distance(angle))

    def slope(n: Any) -> Any:  # d tan w / d tan a = cos^2 a / cos^2 w * cos a / (n cos w)
        w = mp.asin(mp.sin(angle) / n)
        return mp.cos(angle) ** 3 / (n * mp.cos(w) ** 3)

    derivative = mp.mpf(0.005) + mp.mpf(0.01) * slope(mp.mpf(N_G)) + 2 * slope(mp.mpf(N_W))
    close(port.flat_floor_derivative(tan_air, **geometry), derivative)

    def passed(n1: Any, n2: Any, one: Any, two: Any) -> tuple[Any, Any]:
        c1, c2 = mp.cos(one), mp.cos(two)
        top = 4 * n1 * n2 * c1 * c2
        return top / (n1 * c1 + n2 * c2) ** 2, top / (n1 * c2 + n2 * c1) ** 2

    n_g, n_w = mp.mpf(N_G), mp.mpf(N_W)
    glass, wet = mp.asin(mp.sin(angle) / n_g), mp.asin(mp.sin(angle) / n_w)
    air_s, air_p = passed(mp.mpf(1), n_g, angle, glass)
    water_s, water_p = passed(n_g, n_w, glass, wet)
    close(
        port.flat_port_transmittance(tan_air, n_water=N_W, n_glass=N_G),
        (air_s * water_s + air_p * water_p) / 2,
        rel=1e-12,
    )


def test_flat_field_images_at_grazing() -> None:
    """1/z of both images: 1/(dx/d tan a) and tan a / x, positive up to grazing."""
    for tan_air in (1e-6, 1.0, 1e3, 1e7):
        got = defocus.flat_field_dioptres_per_m(
            2.0, tan_air=tan_air, gap_m=0.0, thickness_m=1e-6, n_glass=N_G, n_water=N_W
        )
        a = mp.atan(mp.mpf(tan_air))
        glass, wet = mp.asin(mp.sin(a) / mp.mpf(N_G)), mp.asin(mp.sin(a) / mp.mpf(N_W))
        x = mp.mpf(1e-6) * mp.tan(glass) + 2 * mp.tan(wet)
        slope = mp.mpf(1e-6) * mp.cos(a) ** 3 / (mp.mpf(N_G) * mp.cos(glass) ** 3)
        slope += 2 * mp.cos(a) ** 3 / (mp.mpf(N_W) * mp.cos(wet) ** 3)
        close(got[0], 1 / slope, rel=1e-12)
        close(got[1], mp.mpf(tan_air) / x, rel=1e-12)


# ---------------------------------------------------------------- beams, lines, sharpness


@pytest.mark.parametrize("full_deg", [0.001, 1.0, 90.0, 179.9])
def test_lobes_from_needles_to_hemispheres(full_deg: float) -> None:
    """m = ln 1/2 / ln cos(FWHM / 2), and half the axial intensity at that angle."""
    full = math.radians(full_deg)
    made = beam.cosine_power_beam(full)
    assert made.exponent is not None
    close(made.exponent, mp.log(mp.mpf(1) / 2) / mp.log(mp.cos(mp.mpf(full) / 2)), rel=1e-12)
    close(beam.half_power_angle_rad(made), mp.mpf(full) / 2, rel=1e-6 if full_deg < 0.01 else 1e-10)
    axis, half = beam.intensity_per_sr([1.0, math.cos(full / 2)], made)
    assert half / axis == pytest.approx(0.5, rel=2e-6)  # a needle's cosine has few digits left


@pytest.mark.parametrize("line_nm", [450.0, 551.2, 600.5, 779.99])
@pytest.mark.parametrize("half_width_nm", [1e-3, 0.1, 0.7])
def test_a_line_keeps_its_light_wherever_it_falls_on_the_grid(line_nm: float, half_width_nm: float) -> None:
    """A triangle of that half width holds its area, and its centre of gravity for what is linear there."""
    high = min(line_nm + half_width_nm, 780.0)
    table_nm = np.unique([380.0, line_nm - half_width_nm, line_nm, high, 781.0])
    values = np.where(table_nm == line_nm, 1.0, 0.0)
    grid = spectrum.wavelength_grid_nm(1.0)
    got = spectrum.resample_power(grid, table_nm=table_nm, table_values=values)
    area = (mp.mpf(high) - mp.mpf(line_nm - half_width_nm)) / 2
    first = (mp.mpf(line_nm) - mp.mpf(line_nm - half_width_nm)) / 2 * (
        mp.mpf(line_nm - half_width_nm) + 2 * mp.mpf(line_nm)
    ) / 3 + (mp.mpf(high) - mp.mpf(line_nm)) / 2 * (2 * mp.mpf(line_nm) + mp.mpf(high)) / 3
    close(spectrum.integrate_nm(got, grid), area, rel=1e-9)
    close(spectrum.integrate_nm(got * grid, grid), first, rel=1e-9)
    assert np.all(got >= 0.0)


@pytest.mark.parametrize("cycle_px", [0.0, 1e-3, 1.0, 2.0, 64.0, 1e300])
def test_diffraction_from_none_to_all(cycle_px: float) -> None:
    """(2/pi)(acos s - s sqrt(1 - s^2)), 0 beyond the cut-off."""
    got = float(sharp.diffraction_mtf(0.25, cycle_px=cycle_px))
    s = min(mp.mpf(0.25) * mp.mpf(cycle_px), mp.mpf(1))
    assert abs(got - 2 / mp.pi * (mp.acos(s) - s * mp.sqrt(1 - s**2))) < 1e-14


def test_an_image_that_is_not_there_resolves_nothing() -> None:
    """An infinite working f-number has MTF 0 at every frequency but 0."""
    nothing = sharp.Sharpness(
        working_f_number=np.array([np.inf]),
        wavelength_nm=np.array([550.0]),
        pixel_pitch_m=np.array([3.45e-6]),
    )
    assert sharp.mtf50_cyc_per_px(nothing)[0] == 0.0
    assert (
        sharp.resolution_10_m(nothing, ground_sample_m=1e-3)[0] == math.inf
    )

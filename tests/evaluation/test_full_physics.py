"""Physics `full`, through `uwopt.evaluate`, against a second computation written for these tests: `second_physics`."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kept_values import HINT
from second_physics.case import KEPT, RAYS_NM, Case, Lamp, figures, gauss, scene
from second_physics.image import (
    floor_area,
    least_snr,
    lux_at,
    noise_variance,
    sharp_electrons,
    sharp_lux,
    sharp_mean,
    smooth_electrons,
    smooth_mean,
    snr_of_twentieth,
    veil_means,
)
from second_physics.rays import Rays, electrons_at, object_distance_m, working_f_number
from second_physics.tables import legs, water_index, water_loss

import uwopt
from uwopt.model.image_mean import FRAME_MAY_MISS, frame_places, reached_by_most

SMOOTH = 1e-4  # what a mean over the image is good for where beams have no edge
SHARP = 1e-3  # the same where beams end sharply

# ---------------------------------------------------------------- electrons


def pair(baseline: float, tilt: float = 0.0) -> tuple[Lamp, Lamp]:
    """Two lamps across track, leaning outward alike."""
    return Lamp(y=baseline, tilt_y=tilt), Lamp(y=-baseline, tilt_y=tilt)


FLAT = Case(dome=False, focal_mm=12.0, n_glass=1.49, thickness=0.012)
THREE = (
    Lamp(x=0.3, y=0.4, z=-0.2, tilt_x=-10, tilt_y=5), Lamp(x=-0.5, y=-0.1, z=0.1, tilt_x=15), Lamp(y=0.9, tilt_y=-30),
)  # fmt: skip
SMOOTH_CASES = {
    "one lamp, dome": Case(),
    "two lamps, clear water": Case(water="I", lamps=pair(0.5)),
    "flat port, measured water, tilt outward": replace(
        FLAT, altitude=1.5, water="IB", table="measured", lamps=pair(0.6, 10)
    ),
    "wide flat port, tilt inward": replace(
        FLAT, focal_mm=4.0, altitude=1.2, water="1C", table="measured", lamps=pair(0.6, -20)
    ),
    "three lamps anywhere, turbid, portrait": Case(
        water="5C", table="measured", altitude=1.0, lamps=THREE, portrait=True
    ),
    "most turbid": Case(water="9C", altitude=1.5, lamps=pair(0.4)),
    "narrow lobes": Case(half_angle=12.0, lamps=pair(0.5, -8)),
    "wide lobes": Case(half_angle=60.0, lamps=pair(0.8, 20)),
    "warm fresh water": Case(
        temperature=30.0, salinity=0.0, water="III", table="measured", camera=(("quantum_efficiency", 0.6),)
    ),
    "colour, spectrum of sand": Case(
        floor="sand_coralreef_asu", camera=(("quantum_efficiency", "seed-imx250c"), ("colour", "colour"))
    ),
    "all orders, dome": Case(orders=True, lamps=pair(0.5)),
    "all orders, flat port, narrow lobes, turbid": replace(
        FLAT, orders=True, water="5C", table="measured", altitude=1.0, half_angle=15.0, lamps=pair(0.3, -5)
    ),
    "glass of the water's index": Case(n_glass=1.34),  # a dome that is not there: faces pass, air face loses
}


@pytest.mark.parametrize("name", SMOOTH_CASES)
def test_mean_electrons_under_smooth_lobes(name: str) -> None:
    case = SMOOTH_CASES[name]
    assert figures(case)["electrons_signal"] == pytest.approx(smooth_electrons(case), rel=SMOOTH)


@pytest.mark.parametrize("focal_mm", [4.0, 8.0])
def test_mean_electrons_under_a_measured_lobe(focal_mm: float) -> None:
    # every half degree of the measured profile is a small kink; Gauss-Legendre steps over them (4e-4)
    case = Case(beam="tabulated", focal_mm=focal_mm, floor="sand_coralreef_asu", lamps=pair(0.5, -5))
    assert figures(case)["electrons_signal"] == pytest.approx(smooth_mean(case, 20, 6), rel=SHARP)


SHARP_CASES = {
    "disc that covers the image": Case(beam="disc", half_angle=45.0),
    "two small discs": Case(beam="disc", half_angle=20.0, lamps=pair(0.3)),
    "two cones, tilt inward": Case(beam="cone", half_angle=20.0, lamps=pair(0.5, -10)),
    "two cones, flat port": replace(
        FLAT, beam="cone", half_angle=30.0, focal_mm=6.0, lamps=pair(0.5, 5), altitude=1.5
    ),
    "wide tilted discs, turbid": Case(
        beam="disc", half_angle=60.0, lamps=pair(0.8, 20), water="5C", table="measured", focal_mm=4.0
    ),
    "three discs anywhere": Case(beam="disc", half_angle=35.0, lamps=THREE),
}


@pytest.mark.parametrize("name", SHARP_CASES)
def test_mean_electrons_under_beams_that_end_sharply(name: str) -> None:
    case = SHARP_CASES[name]
    assert figures(case)["electrons_signal"] == pytest.approx(sharp_electrons(case), rel=SHARP)


@pytest.mark.parametrize(("half_angle", "reached"), [(10.0, 2e-3), (5.0, 1e-2)])
def test_narrow_spots_are_met_less_well(half_angle: float, reached: float) -> None:
    # the spot's radius is 17 and 9 of the cells into which the image is cut; the error falls with their square
    case = Case(beam="cone", half_angle=half_angle, lamps=(Lamp(y=0.1),))
    assert figures(case)["electrons_signal"] == pytest.approx(sharp_electrons(case), rel=reached)


@pytest.mark.parametrize("name", SMOOTH_CASES)
def test_mean_veils_under_smooth_lobes(name: str) -> None:
    case = SMOOTH_CASES[name]
    got, (forward, back) = figures(case), veil_means(case)
    # clear water: a difference of two nearly equal means, each good to 1e-5
    assert got["electrons_forward"] == pytest.approx(forward, rel=SMOOTH, abs=1e-5 * smooth_electrons(case))
    # here 1 nm of wavelength and the formula of the phase function, there a table of it
    assert got["electrons_backscatter"] == pytest.approx(back, rel=2 * SMOOTH)


@pytest.mark.parametrize("name", SMOOTH_CASES)
def test_snr_contrast_and_veil_ratio_of_the_means(name: str) -> None:
    case = SMOOTH_CASES[name]
    got, signal, veil = figures(case), smooth_electrons(case), sum(veil_means(case))
    assert got["snr"] == pytest.approx(snr_by_hand(signal, veil=veil), rel=SMOOTH)
    assert got["contrast"] == pytest.approx(signal / (signal + veil), rel=SMOOTH)
    assert got["veil_ratio"] == pytest.approx(veil / signal, rel=2 * SMOOTH)


@pytest.mark.parametrize("name", SMOOTH_CASES)
def test_darkest_pixel(name: str) -> None:
    case, least = SMOOTH_CASES[name], least_snr(SMOOTH_CASES[name])
    assert figures(case)["snr_db_min"] == pytest.approx(20 * math.log10(least), abs=0.002)


OVER_FRAME_DB = {  # reached: light falls to a corner by up to 20 dB, and shares are counted to 1/377 of the image
    "two lamps, clear water": 0.1, "flat port, measured water, tilt outward": 0.1, "most turbid": 0.2,
}  # fmt: skip


@pytest.mark.parametrize("name", OVER_FRAME_DB)
def test_snr_that_95_percent_of_the_image_reach(name: str) -> None:
    twentieth = 20 * math.log10(snr_of_twentieth(SMOOTH_CASES[name]))
    assert figures(SMOOTH_CASES[name])["snr_db_p05"] == pytest.approx(twentieth, abs=OVER_FRAME_DB[name])


@pytest.mark.parametrize(("half_angle", "lamps"), [(8.0, (Lamp(y=0.3),)), (12.0, pair(0.5))])
def test_places_of_the_frame_are_enough_for_small_spots(half_angle: float, lamps: tuple[Lamp, ...]) -> None:
    # light falls by 3 dB from one place to the next at the image's edge: against cells of 1/129 of its side
    case, cells = Case(half_angle=half_angle, lamps=lamps), (np.arange(129) + 0.5) * 2.0 / 129 - 1.0
    counted = np.sort(electrons_at(case, cells[:, None], cells[None, :]).ravel())
    along, across = frame_places(np.ones(1), np.ones(1))
    reached = reached_by_most(electrons_at(case, across[0], along[0]), FRAME_MAY_MISS)
    assert 20 * math.log10(float(reached)) == pytest.approx(
        20 * math.log10(float(counted[int(0.05 * counted.size)])), abs=0.7
    )


def test_a_pixel_without_light_has_no_snr_in_decibel() -> None:
    got = figures(SHARP_CASES["two small discs"])
    assert got["snr_db_min"] is None
    assert got["floor_illuminance_min_lx"] == got["uniformity"] == 0.0


# ---------------------------------------------------------------- light on the floor


@pytest.mark.parametrize("name", SMOOTH_CASES)
def test_floor_illuminance_over_the_traced_footprint(name: str) -> None:
    case = SMOOTH_CASES[name]
    nodes, weights = gauss(-1.0, 1.0, 32)
    u, v = nodes[:, None], nodes[None, :]
    area = floor_area(case, u, v)
    mean_lx = float(weights @ (lux_at(case, u, v) * area) @ weights / (weights @ area @ weights))
    border = np.linspace(-1.0, 1.0, 41)
    least_lx = float(lux_at(case, border[:, None], border[None, :]).min())
    got = figures(case)
    assert got["floor_illuminance_mean_lx"] == pytest.approx(mean_lx, rel=SMOOTH)
    assert got["floor_illuminance_min_lx"] == pytest.approx(least_lx, rel=SMOOTH)
    assert got["uniformity"] == pytest.approx(least_lx / mean_lx, rel=SMOOTH)


@pytest.mark.parametrize("name", ["two small discs", "two cones, flat port", "wide tilted discs, turbid"])
def test_mean_floor_illuminance_under_beams_that_end_sharply(name: str) -> None:
    case = SHARP_CASES[name]
    assert figures(case)["floor_illuminance_mean_lx"] == pytest.approx(sharp_lux(case), rel=SHARP)


# ---------------------------------------------------------------- exposure and noise


def test_the_exposure_offset_adds_to_the_exposure() -> None:
    # 13.73 us on 1 ms
    case = replace(Case(), camera=(("exposure_offset_us", 13.73),))
    assert figures(case)["electrons_signal"] == pytest.approx(smooth_electrons(Case()) * 1.01373, rel=SMOOTH)


def test_a_pulse_shorter_than_the_exposure_counts_alone() -> None:
    case = replace(
        Case(),
        camera=(("exposure_offset_us", 13.73),),
        light=(("kind", "pulsed_led"),),
        settings=(("pulse_ms", 0.5),),
    )
    assert figures(case)["electrons_signal"] == pytest.approx(smooth_electrons(Case()) * 0.5, rel=SMOOTH)


@pytest.mark.parametrize(
    ("duration_us", "at_frac", "exposure_ms", "lumen_seconds"),
    [
        (500.0, 1.0, 1.0, 700.0), (2000.0, 1.0, 1.0, 350.0), (500.0, 1.0, 0.25, 350.0),
        # t0.5 = 2 ms: 1 - 0.5^0.5 of the light in 1 ms, of the 99 % that count; t0.1 = 0.5 ms: over after 1 ms
        (2000.0, 0.5, 1.0, 700.0 * (1.0 - 0.5**0.5) / 0.99), (500.0, 0.1, 1.0, 700.0),
        (2000.0, None, 0.6, 700.0 * (1.0 - 0.07**0.3) / 0.99),  # not told: that of its class
    ],
)  # fmt: skip
def test_a_flash_gives_its_lumen_seconds_or_what_comes_while_the_shutter_is_open(
    duration_us: float, at_frac: float | None, exposure_ms: float, lumen_seconds: float
) -> None:
    # 20 J at 35 lm s/J = 700 lm s; the base case collects 4000 lm for 1 ms, 4 lm s
    system = Case().system()
    system["light"] = {
        "kind": "flash", "flash_energy_j": 20, "flash_efficacy_lm_s_per_j": 35, "flash_duration_us": duration_us,
        "spectrum": "generic-led", "beam": "cosine-power", "beam_half_angle_deg": 40,
    } | ({} if at_frac is None else {"flash_duration_at_frac": at_frac})  # fmt: skip
    system["settings"] = {"f_number": 4.0, "exposure_ms": exposure_ms, "gain": 1.0}
    design = uwopt.evaluate(Case().mission(), system).design
    assert design is not None
    got = design.scenes[0].figures["electrons_signal"]
    assert got == pytest.approx(smooth_electrons(Case()) * lumen_seconds / 4.0, rel=SMOOTH)


def snr_by_hand(electrons: float, dark: float = 0.0, prnu: float = 0.0, veil: float = 0.0) -> float:
    """Image-forming electrons over the noise."""
    return electrons / math.sqrt(noise_variance(electrons + veil, dark, prnu))


def test_snr_and_level_with_dark_current_offset_quantisation_and_prnu() -> None:
    camera = (("dark_current_e_s", 500.0), ("black_level_dn", 12.0), ("prnu_frac", 0.02))
    bright = Case(water="I", altitude=1.0, lamps=pair(0.3))
    got, electrons, veil = (
        figures(replace(bright, camera=camera)),
        smooth_electrons(bright),
        sum(veil_means(bright)),
    )
    assert electrons > 100.0  # so that every term counts
    assert got["electrons_dark"] == pytest.approx(0.5)  # 500 e/s for 1 ms
    assert got["snr"] == pytest.approx(snr_by_hand(electrons, 0.5, 0.02, veil), rel=SMOOTH)
    assert got["mean_dn"] == pytest.approx(0.35 * (electrons + veil + 0.5) + 12.0, rel=SMOOTH)
    assert got["mean_level"] == pytest.approx(got["mean_dn"] / 4095.0, rel=1e-12)
    assert got["saturation_fraction"] == pytest.approx(1.5 * got["mean_level"], rel=1e-12)


def test_snr_over_a_band_of_altitudes_is_that_of_its_far_end_with_the_focus_held() -> None:
    case = Case(tolerance=0.5, needs=(("min_snr_db", 3.0),))
    far = replace(Case(), altitude=2.5, focus=2.0)
    margin = next(row for row in scene(case).margins if row.requirement == "min_snr_db")
    assert margin.at_altitude_m == 2.5
    # dB: an error of 1e-4 in electrons is 0.001 dB
    expected = 20 * math.log10(snr_by_hand(smooth_electrons(far), veil=sum(veil_means(far))))
    assert margin.value == pytest.approx(expected, abs=0.002)


# ---------------------------------------------------------------- geometry


@pytest.mark.parametrize("name", ["one lamp, dome", "wide flat port, tilt inward"])
def test_footprint_and_pixels_are_those_of_traced_rays(name: str) -> None:
    case = SMOOTH_CASES[name]
    rays, got = Rays(case), figures(case)
    nearer = case.f_number / working_f_number(case)  # a lens moved out by f m sees 1 / (1 + m) of its field
    reach_along, reach_across = (
        rays.floor(np.array(nearer), np.array(0.0))[0],
        rays.floor(np.array(0.0), np.array(nearer))[1],
    )
    assert got["fov_y_m"] == pytest.approx(2 * float(reach_along), rel=1e-9)
    assert got["fov_x_m"] == pytest.approx(2 * float(reach_across), rel=1e-9)
    # pixels by tracing their two edges, all over the image; the smallest of a lens that moves out, or does not
    u, v = np.meshgrid(np.linspace(-1, 1, 101), np.linspace(-1, 1, 101), indexing="ij")
    half = rays.pixel / rays.tan_along / 2
    along_m = rays.floor(u + half, v)[0] - rays.floor(u - half, v)[0]
    assert got["gsd_mm"] == pytest.approx(1e3 * float(along_m.max()), rel=1e-5)
    closer_m = rays.floor(nearer * (u + half), nearer * v)[0] - rays.floor(nearer * (u - half), nearer * v)[0]
    least_m = min(float(along_m.min()), float(closer_m.min()))
    assert got["exposure_max_ms"] == pytest.approx(1e3 * least_m / 0.3, rel=1e-4)


@pytest.mark.parametrize(
    "case", [Case(f_number=2.0, focal_mm=12.0), replace(FLAT, f_number=2.8, altitude=1.5)]
)
def test_points_at_both_ends_of_the_depth_of_field_blur_to_two_pixels(case: Case) -> None:
    focal_m, got = case.focal_mm * 1e-3, figures(case)

    def image_m(range_m: float) -> float:
        return 1.0 / (1.0 / focal_m - 1.0 / object_distance_m(case, range_m))

    for end_m in (got["dof_near_m"], got["dof_far_m"]):
        blur_m = focal_m / case.f_number * abs(image_m(case.altitude) / image_m(end_m) - 1.0)
        assert blur_m == pytest.approx(2 * 3.45e-6, rel=1e-6)


# ---------------------------------------------------------------- limits


def murky(folder: Path, c_per_m: float) -> str:
    file = folder / "murky.csv"
    file.write_text(f"wavelength_nm,attenuation_per_m\n380,{c_per_m}\n780,{c_per_m}\n", encoding="utf-8")
    return str(file)


@pytest.mark.parametrize("c_per_m", [0.0, 1.0, 30.0])
def test_electrons_stay_right_down_to_1e_100(tmp_path: Path, c_per_m: float) -> None:
    case = Case(water=murky(tmp_path, c_per_m))
    water_loss.cache_clear()
    legs.cache_clear()
    got, expected = figures(case), smooth_mean(case, order=64)
    assert got["electrons_signal"] == pytest.approx(expected, rel=SMOOTH)
    assert got["snr_db"] == pytest.approx(20 * math.log10(snr_by_hand(expected)), abs=0.002)


@pytest.mark.parametrize("c_per_m", [500.0, 1e5])
@pytest.mark.parametrize("beam", ["cosine-power", "disc", "tabulated"])
def test_water_like_ink_gives_no_signal_and_no_nonsense(tmp_path: Path, c_per_m: float, beam: str) -> None:
    got = figures(Case(water=murky(tmp_path, c_per_m), beam=beam))
    assert got["electrons_signal"] == got["snr"] == 0.0
    assert got["snr_db"] is None
    assert all(math.isfinite(value) for value in got.values() if isinstance(value, float))


def test_near_the_axis_a_flat_port_sees_what_a_dome_sees_divided_by_the_index() -> None:
    # close to the axis a flat port's picture is n_w times narrower, and a dome's rays start one radius behind
    n_w = float(water_index(Case(), np.array([RAYS_NM]))[0])
    flat = replace(Case(), dome=False, gap=0.0, thickness=1e-4, focal_mm=200.0)
    dome = replace(Case(), radius=0.1, focal_mm=200.0)
    scale = figures(dome)["gsd_mm"] / figures(flat)["gsd_mm"]
    assert scale == pytest.approx(n_w * (2.0 + 0.1) / 2.0, rel=1e-3)  # tan and sin differ by 1e-4 at 1.2 deg


def test_the_means_that_are_kept_are_of_these_files_and_these_tables() -> None:
    assert KEPT.is_current, HINT


def test_a_kept_mean_is_what_is_worked_out() -> None:
    case = SHARP_CASES["two small discs"]
    rounding = 1e-9  # of another machine
    assert sharp_electrons(case) == pytest.approx(sharp_mean(case, electrons_at), rel=rounding)

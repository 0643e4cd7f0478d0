"""One design: settings that are left out, light that leaves the window, and what counts of several scenes.

Geometry is worked out by hand for physics `paper` behind a flat port: the effective focal length is 1.33 f.
"""

from __future__ import annotations

import math
from typing import Any

import pytest

import uwopt
from uwopt.catalog.parts.port import Port
from uwopt.catalog.records import Camera, Light
from uwopt.evaluation.bill import remark
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.assembly import system_problem
from uwopt.forward.focus import place_focus
from uwopt.mission.mission import load_mission
from uwopt.mission.system import load_system
from uwopt.results.design import Design
from uwopt.results.result import Result

GSD_PER_M = 5e-6 / (1.33 * 10e-3)  # pixel on the floor over the altitude
ALONG_PER_M = 1000 * GSD_PER_M

SYSTEM: dict[str, Any] = {
    "camera": {"resolution_x_px": 2000, "resolution_y_px": 1000, "pixel_pitch_um": 5.0, "read_noise_e": 5.0,
               "quantum_efficiency": 0.5, "bit_depth": 12, "gain_dn_per_e": 0.05, "saturation_e": 20_000,
               "max_frame_rate_hz": 10.0, "max_gain_db": 60, "price": 1000.0, "mass_g": 500.0, "power_w": 4.0},
    "lens": {"focal_length_mm": 10.0, "f_number_min": 1.4, "f_number_max": 16.0, "price": 300.0, "mass_g": 100.0},
    "port": {"geometry": "flat", "gap_mm": 5.0, "thickness_mm": 10.0, "price": 200.0, "mass_g": 300.0},
    "light": {"flux_lm": 10_000, "power_w": 100.0, "beam": "cosine-power", "beam_half_angle_deg": 40.0,
              "price": 400.0, "mass_g": 700.0},
    "light_count": 2,
}  # fmt: skip
PULSED = {**SYSTEM["light"], "kind": "pulsed_led", "max_pulse_us": 800.0}
FLASH = {
    "kind": "flash", "flash_energy_j": 10.0, "flash_duration_us": 3000.0, "beam": "cosine-power",
    "beam_half_angle_deg": 40.0,
}  # fmt: skip
SPEED = {
    "altitude_m": 2.0,
    "altitude_tolerance_m": 0.5,
    "speed_m_s": 0.5,
    "light_baseline_m": 0.5,
    "light_count": 2,
}
SCENE = {"water": "II", "seafloor": 0.2, "depth_m": 300.0}


def evaluated(
    *, physics: str = "paper", vehicle: Any = None, requirements: Any = None, limits: Any = None, scenes: Any = None,
    objective: str = "power", **system: Any,
) -> Result:  # fmt: skip
    mission = {
        "practice": "bare", "scenes": scenes or [{"name": "one", **SCENE}], "vehicle": {**SPEED, **(vehicle or {})},
        "requirements": requirements or {}, "limits": limits or {}, "objective": objective,
    }  # fmt: skip
    return uwopt.evaluate(mission, {**SYSTEM, **system}, physics=physics)


def design_of(**asked: Any) -> Design:
    design = evaluated(**asked).design
    assert design is not None
    return design


def setting(name: str, **asked: Any) -> float:
    return float(design_of(**asked).scenes[0].settings[name] or math.nan)


# ---------------------------------------------------------------- settings that are left out


def test_lens_is_open_and_light_full_unless_set() -> None:
    settings = design_of().scenes[0].settings
    assert (settings["f_number"], settings["dim_frac"], settings["gain"]) == (1.4, 1.0, 1.0)


def test_focus_lies_at_the_nominal_altitude_unless_set() -> None:
    assert setting("focus_distance_m") == pytest.approx(2.0, rel=1e-12)


def test_frame_rate_keeps_the_overlap_at_the_nearest_altitude() -> None:
    wanted = 0.5 / (1.5 * ALONG_PER_M * (1.0 - 0.4))
    assert setting("frame_rate_hz", requirements={"overlap": 0.4}) == pytest.approx(wanted, rel=1e-12)


def test_frame_rate_keeps_the_interval_where_that_asks_for_more() -> None:
    needs = {"overlap": 0.4, "frame_interval_s": 0.125}
    assert setting("frame_rate_hz", requirements=needs) == pytest.approx(8.0, rel=1e-12)


def test_exposure_is_the_longest_without_blur_at_the_nearest_altitude() -> None:
    wanted_ms = 1e3 * 2.0 * 1.5 * GSD_PER_M / 0.5
    assert setting("exposure_ms", requirements={"max_blur_px": 2.0}) == pytest.approx(wanted_ms, rel=1e-12)


def test_offset_of_the_sensor_shortens_the_exposure(n_water: float) -> None:
    # Blur lasts as long as light is collected: exposure + offset; behind a dome a pixel is (d + R) p / (f (1 + m))
    wanted_ms = 1e3 * 2.0 * (1.5 + RADIUS_M) * PIXEL_M / (FOCAL_M * behind_dome(n_water)) / 0.5 - 0.2
    found = setting(
        "exposure_ms", physics="full", requirements={"max_blur_px": 2.0},
        camera={**SYSTEM["camera"], "exposure_offset_us": 200.0},
        port={"geometry": "dome", "outer_radius_mm": 100.0, "thickness_mm": 10.0, "refractive_index": 1.5},
    )  # fmt: skip
    assert found == pytest.approx(wanted_ms, rel=1e-12)


@pytest.mark.parametrize(
    ("more", "wanted_ms"),
    [
        (dict(settings={"frame_rate_hz": 4.0}), 250.0),
        (dict(settings={"frame_rate_hz": 4.0}, limits={"max_exposure_ms": 30.0}), 30.0),
        (dict(settings={"frame_rate_hz": 4.0}, camera={**SYSTEM["camera"], "max_exposure_us": 7000.0}), 7.0),
    ],
    ids=["frame rate", "mission", "camera"],
)
def test_exposure_ends_with_the_first_of_its_limits(more: dict[str, Any], wanted_ms: float) -> None:
    assert setting("exposure_ms", **more) == pytest.approx(wanted_ms, rel=1e-12)


def test_pulse_is_as_long_as_exposure_and_lamp_allow() -> None:
    short, long = {"frame_rate_hz": 2.0, "exposure_ms": 0.3}, {"frame_rate_hz": 2.0, "exposure_ms": 3.0}
    assert setting("pulse_ms", light=PULSED, settings=short) == pytest.approx(0.3, rel=1e-12)
    assert setting("pulse_ms", light=PULSED, settings=long) == pytest.approx(0.8, rel=1e-12)


def test_rolling_shutter_stays_open_for_its_readout_and_the_flash() -> None:
    rolling = {**SYSTEM["camera"], "shutter": "rolling"}  # 10 Hz: 100 ms
    found = setting(
        "exposure_ms",
        light=FLASH,
        camera=rolling,
        requirements={"max_blur_px": 0.1},
        settings={"frame_rate_hz": 1.0},
    )
    assert found == pytest.approx(100.0 + 3.0, rel=1e-12)


@pytest.mark.parametrize("physics", ["paper", "full"])
def test_gain_gives_the_wanted_mean_level_at_the_nominal_altitude(physics: str) -> None:
    design = design_of(
        physics=physics, requirements={"mean_level": 0.2}, settings={"exposure_ms": 1.0, "frame_rate_hz": 1.0},
        camera={**SYSTEM["camera"], "black_level_dn": 60.0},
    )  # fmt: skip
    assert design.scenes[0].settings["gain"] > 1.01
    assert design.scenes[0].figures["mean_level"] == pytest.approx(0.2, rel=1e-9)


# ---------------------------------------------------------------- light


SET = {"settings": {"f_number": 4.0, "exposure_ms": 1.0, "frame_rate_hz": 1.0}}


def electrons(**more: Any) -> float:
    return float(design_of(physics="full", **{**SET, **more}).scenes[0].figures["electrons_signal"])


def test_light_that_stays_behind_the_window_reaches_no_pixel() -> None:
    dim = {**SYSTEM["light"], "output_factor": 0.25}
    assert electrons(light=dim) == pytest.approx(0.25 * electrons(), rel=1e-9)


def test_lens_focused_near_is_darker_by_the_square_of_its_extension() -> None:
    # N_w = N (1 + m), m = f / (s - f); a flat port without glass or gap: s = 2 m / 1.34
    port = {"geometry": "flat", "gap_mm": 0.0, "thickness_mm": 1e-3, "refractive_index": 1.5}
    far, near = (
        design_of(
            physics="full", port=port, lens={**SYSTEM["lens"], "focal_length_mm": 50.0},
            settings={**SET["settings"], "focus_distance_m": focus_m},
        ).scenes[0].figures
        for focus_m in (2.0, 0.5)
    )  # fmt: skip
    n_water = far["effective_focal_length_mm"] / 50.0
    extension = [1.0 + 0.05 / (focus_m / n_water - 0.05) for focus_m in (2.0, 0.5)]
    assert near["working_f_number"] == pytest.approx(4.0 * extension[1], rel=1e-5)  # a glass of 1 um
    ratio = near["electrons_signal"] / far["electrons_signal"]
    assert ratio == pytest.approx((extension[0] / extension[1]) ** 2, rel=1e-5)


def test_dark_current_counts_over_the_exposure() -> None:
    dark = {**SYSTEM["camera"], "dark_current_e_s": 7000.0}
    figures = design_of(physics="full", camera=dark, **SET).scenes[0].figures
    assert figures["electrons_dark"] == pytest.approx(7.0, rel=1e-12)


def test_flash_that_outlasts_the_exposure_is_cut() -> None:
    # 3 ms of even light, of which 1 ms is collected, against all of it; and of light that fades to a tenth in 3 ms
    cut = {**SET["settings"], "exposure_ms": 1.0}
    whole = {**SET["settings"], "exposure_ms": 3.0}
    for at_frac, share in ((1.0, 1.0 / 3.0), (0.1, (1.0 - 0.1 ** (1.0 / 3.0)) / 0.9)):
        flash = {**FLASH, "flash_duration_at_frac": at_frac}
        assert electrons(light=flash, settings=cut) == pytest.approx(
            electrons(light=flash, settings=whole) * share, rel=1e-9
        )


# ---------------------------------------------------------------- several scenes


NEAR_M, FAR_M = 1.0, 3.0
TWO = [
    {"name": "near", **SCENE, "vehicle": {"altitude_m": NEAR_M, "altitude_tolerance_m": 0.0}},
    {"name": "far", **SCENE, "vehicle": {"altitude_m": FAR_M, "altitude_tolerance_m": 0.0}},
]
BOTH = {"settings": {"f_number": 4.0, "exposure_ms": 1.0, "frame_rate_hz": 1.0, "gain": 1.0}}


def test_worst_scene_counts_in_what_is_to_be_high() -> None:
    design = design_of(scenes=TWO, objective="snr_db", **BOTH)
    near, far = (scene.figures["snr_db"] for scene in design.scenes)
    assert far < near - 3.0
    assert design.objective_value == far


def test_worst_scene_counts_in_what_is_to_be_low() -> None:
    design = design_of(scenes=TWO, objective="gsd_mm", **BOTH)
    assert design.objective_value == pytest.approx(1e3 * FAR_M * GSD_PER_M, rel=1e-12)


def test_power_is_that_of_the_scene_with_the_most() -> None:
    # Nine tenths of the light near the floor, three far from it
    system = {**SYSTEM, **BOTH, "scenes": {"near": {"dim_frac": 0.9}, "far": {"dim_frac": 0.3}}}
    design = uwopt.evaluate({"practice": "bare", "scenes": TWO, "vehicle": SPEED}, system, physics="paper").design
    assert design is not None
    assert design.totals["power_w"] == pytest.approx(4.0 + 2 * 100.0 * 0.9)
    assert design.totals["light_power_w"] == pytest.approx(2 * 100.0 * 0.9)
    assert design.objective_value == pytest.approx(4.0 + 2 * 100.0 * 0.9)


@pytest.mark.parametrize("limit_gsd_mm", [1e3 * 2.0 * GSD_PER_M, 1e3 * 4.0 * GSD_PER_M])
def test_one_scene_that_misses_is_enough(limit_gsd_mm: float) -> None:
    enough = {"circle_of_confusion_px": 100.0, "frame_interval_s": 1.0}  # sharp in both, and often enough
    wanted = {"max_gsd_mm": limit_gsd_mm, **enough}
    result = evaluated(scenes=TWO, requirements=wanted, **BOTH)
    missed = limit_gsd_mm < 1e3 * FAR_M * GSD_PER_M
    assert result.status == ("violated" if missed else "feasible")
    assert result.design is not None and result.design.feasible is not missed


# ---------------------------------------------------------------- totals


def test_totals_of_two_cameras_by_hand() -> None:
    design = design_of(vehicle={"camera_count": 2}, camera_count=2, **SET)
    cost = 2 * (1000.0 + 300.0 + 200.0) + 2 * 400.0
    assert (design.totals["cost"]["value"], design.scenes[0].figures["cost"]) == (cost, cost)
    assert design.totals["mass_kg"] == pytest.approx(2 * (0.5 + 0.1 + 0.3) + 2 * 0.7)
    assert design.totals["power_w"] == pytest.approx(2 * 4.0 + 2 * 100.0)
    # 2000 x 1000 px of 12 bit at 1 Hz are 3 MB/s
    assert design.scenes[0].figures["data_rate_mb_s"] == pytest.approx(2 * 3.0)


def test_bill_adds_up_to_the_cost() -> None:
    design = design_of(**SET)
    assert sum(row["count"] * row["unit_price"] for row in design.bom) == design.totals["cost"]["value"]
    assert {row["kind"]: row["count"] for row in design.bom} == {
        "camera": 1,
        "lens": 1,
        "port": 1,
        "light": 2,
    }


# ---------------------------------------------------------------- geometry and motion


DOME = {"geometry": "dome", "outer_radius_mm": 100.0, "thickness_mm": 10.0, "refractive_index": 1.5}
PIXEL_M, FOCAL_M, RADIUS_M, WALL_M = 5e-6, 10e-3, 0.100, 0.010


def figures_of(**asked: Any) -> dict[str, Any]:
    return design_of(**{"physics": "full", **SET, **asked}).scenes[0].figures


@pytest.fixture(scope="module")
def n_water() -> float:
    """Index of this water at the design wavelength: a flat port makes the focal length so much longer."""
    return float(figures_of()["effective_focal_length_mm"]) / 10.0


def dome_power_per_m(n_water: float) -> float:
    """Of both faces, for what lies at infinity."""
    outer = (1.0 / 1.5 - 1.0 / n_water) / RADIUS_M
    return outer + (1.0 - 1.0 / 1.5) / (RADIUS_M - WALL_M)


def behind_dome(n_water: float) -> float:
    """1 + m = 1 / (1 - f D) of the lens when it is focused through the dome on 2 m of water."""
    return 1.0 / (1.0 - FOCAL_M * (dome_power_per_m(n_water) + 1.0 / n_water / (2.0 + RADIUS_M)))


def test_corner_of_a_dome_image_is_soft_by_its_obliquity(n_water: float) -> None:
    # The image of infinity lies at P / cos of the field angle; the lens is focused on the axis, at 2 m of water
    power = dome_power_per_m(n_water)
    secant = math.sqrt(1.0 + 0.8**2 * (1000**2 + 500**2) * (PIXEL_M / FOCAL_M) ** 2)  # 80 % of the half diagonal
    focus_per_m = power + 1.0 / n_water / (2.0 + RADIUS_M)
    disc_m = FOCAL_M**2 / (4.0 * (1.0 - FOCAL_M * focus_per_m)) * power * (secant - 1.0)
    assert figures_of(port=DOME)["defocus_corner_px"] == pytest.approx(disc_m / PIXEL_M, rel=1e-9)


def test_corner_of_a_flat_ports_image_is_soft_by_its_longer_axis(n_water: float) -> None:
    # Without gap and glass a ray of tangent u in air lands at x = d u / sqrt(q), q = n^2 + (n^2 - 1) u^2: its
    # neighbours along the radius cross at dx/du = d n^2 / q^1.5, those across it farther off, at x / u.
    port = {"geometry": "flat", "gap_mm": 0.0, "thickness_mm": 1e-3, "refractive_index": 1.5}
    q = n_water**2 + (n_water**2 - 1.0) * 0.8**2 * (1000**2 + 500**2) * (PIXEL_M / FOCAL_M) ** 2
    focus_per_m, tangential_per_m = n_water / 2.0, q**1.5 / (2.0 * n_water**2)
    disc_m = FOCAL_M**2 / (4.0 * (1.0 - FOCAL_M * focus_per_m)) * (tangential_per_m - focus_per_m)
    assert figures_of(port=port)["defocus_corner_px"] == pytest.approx(
        disc_m / PIXEL_M, rel=1e-4
    )  # the glass


def test_dome_pixel_counts_range_from_the_centre() -> None:
    assert figures_of(port=DOME)["gsd_mm"] == pytest.approx(
        1e3 * (2.0 + RADIUS_M) * PIXEL_M / FOCAL_M, rel=1e-12
    )


def test_sharp_depth_at_the_corner_of_a_dome_begins_later(n_water: float) -> None:
    power = dome_power_per_m(n_water)
    secant = math.sqrt(1.0 + 0.8**2 * (1000**2 + 500**2) * (PIXEL_M / FOCAL_M) ** 2)  # 80 % of the half diagonal
    focus_per_m = power + 1.0 / n_water / (2.0 + RADIUS_M)
    half_per_m = 4.0 * 2.0 * PIXEL_M * (1.0 - FOCAL_M * focus_per_m) / FOCAL_M**2
    near_m = 1.0 / n_water / (focus_per_m + half_per_m - power * secant) - RADIUS_M
    needs = {"min_dof_m": 0.1, "dof_at": "corner", "circle_of_confusion_px": 2.0}
    assert figures_of(port=DOME, requirements=needs)["dof_near_m"] == pytest.approx(near_m, rel=1e-9)


@pytest.mark.parametrize("dof_at", ["axis", "corner"])
def test_focus_lies_between_centre_and_corner_where_both_must_be_sharp(n_water: float, dof_at: str) -> None:
    # No depth of field is asked for: the centre alone is in focus; with the corner, at 80 % of the half diagonal,
    # the lens is set half way between their images, and N = f^2 (D_corner - D) / (c (1 - f D)) keeps both to c = 2 px
    power = dome_power_per_m(n_water)
    secant = math.sqrt(1.0 + 0.8**2 * (1000**2 + 500**2) * (PIXEL_M / FOCAL_M) ** 2)
    bent = power * (secant - 1.0) if dof_at == "corner" else 0.0
    focus_per_m = power + 1.0 / n_water / (2.0 + RADIUS_M) + 0.5 * bent
    scene: dict[str, Any] = {"name": "one", **SCENE}
    mission = load_mission({
        "practice": "bare", "scenes": [scene], "vehicle": SPEED, "requirements": {"dof_at": dof_at}, "physics": "full"
    })
    model = DesignModel(*system_problem(mission, load_system({**SYSTEM, "port": DOME})))
    focus = place_focus(model.problem.scenes, model.maps, model.views)
    assert focus.dioptre_per_m[0][0] == pytest.approx(focus_per_m, rel=1e-9)
    f_number = FOCAL_M**2 * 0.5 * bent / (2.0 * PIXEL_M * (1.0 - FOCAL_M * focus_per_m))
    assert focus.n_depth[0][0] == pytest.approx(f_number, rel=1e-9)


def test_rolling_blurs_across_the_track(n_water: float) -> None:
    # w t (d + R) over a pixel of (d + R) p / (f (1 + m))
    turning = {"speed_m_s": 0.0, "roll_rate_deg_s": 5.0}
    wanted = math.radians(5.0) * 1e-3 * FOCAL_M * behind_dome(n_water) / PIXEL_M
    still = {"frame_interval_s": 2.0}
    assert figures_of(port=DOME, vehicle=turning, requirements=still)["blur_px"] == pytest.approx(
        wanted, rel=1e-12
    )


def test_rows_read_one_after_another_skew_under_lamps_that_burn_only(n_water: float) -> None:
    rolling = {**SYSTEM["camera"], "shutter": "rolling"}
    burning = figures_of(port=DOME, camera=rolling)["skew_px"]
    pixel_m = (2.0 + RADIUS_M) * PIXEL_M / (FOCAL_M * behind_dome(n_water))
    assert burning == pytest.approx(0.5 * 0.1 / pixel_m, rel=1e-12)
    assert figures_of(port=DOME, camera=rolling, light=FLASH)["skew_px"] == 0.0


@pytest.mark.parametrize(("sun_lux", "blurring_s"), [(0.0, 0.2e-3), (50_000.0, 1e-3)])
def test_sun_blurs_over_the_whole_shutter_and_a_pulse_over_itself(
    n_water: float, sun_lux: float, blurring_s: float
) -> None:
    shallow = [{"name": "one", **SCENE, "depth_m": 5.0, "sun_lux": sun_lux}]
    pulse = {"settings": {**SET["settings"], "pulse_ms": 0.2}}
    figures = figures_of(port=DOME, light=PULSED, scenes=shallow, **pulse)
    wanted = 0.5 * blurring_s / ((2.0 + RADIUS_M) * PIXEL_M / (FOCAL_M * behind_dome(n_water)))
    assert figures["blur_px"] == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize(("orientation", "swath_px"), [("landscape", 2000), ("portrait", 1000)])
def test_view_keeps_its_width_and_the_swath_lies_across_the_track(orientation: str, swath_px: int) -> None:
    figures = design_of(orientation=orientation, **SET).scenes[0].figures
    assert figures["fov_x_m"] == pytest.approx(2000 * 2.0 * GSD_PER_M, rel=1e-12)
    assert figures["fov_y_m"] == pytest.approx(1000 * 2.0 * GSD_PER_M, rel=1e-12)
    assert figures["swath_m"] == pytest.approx(swath_px * 2.0 * GSD_PER_M, rel=1e-12)


def test_lux_on_the_floor_are_those_that_leave_the_lamp() -> None:
    dim = {**SYSTEM["light"], "output_factor": 0.25}
    assert figures_of(light=dim)["floor_illuminance_mean_lx"] == pytest.approx(
        0.25 * figures_of()["floor_illuminance_mean_lx"], rel=1e-9
    )


# ---------------------------------------------------------------- money


def test_prices_of_the_bill_are_in_the_missions_currency() -> None:
    lamp = {**SYSTEM["light"], "price": 400.0, "currency": "EUR"}
    design = design_of(light=lamp, limits={"rates": {"EUR": 1.25}}, **SET)
    (row,) = (row for row in design.bom if row["kind"] == "light")
    ends = [row[f"unit_price{end}"] for end in ("_low", "", "_high")]
    assert ends == pytest.approx([500.0] * 3)
    assert design.totals["cost"]["value"] == pytest.approx(1500.0 + 2 * 500.0)


def test_owned_lamps_are_not_paid_and_estimates_are_told_apart() -> None:
    lamp = "deepsea-power-light-led-sealite-lsl-flood"
    mission = {
        "practice": "bare", "scenes": [{"name": "one", **SCENE}], "vehicle": SPEED,
        "catalog": {"owned": [{"id": lamp, "quantity": 1}]},
    }  # fmt: skip
    design = uwopt.evaluate(mission, {**SYSTEM, **SET, "light": lamp}, physics="paper").design
    assert design is not None
    row = {row["kind"]: row for row in design.bom}["light"]
    assert (row["count"], row["owned"], row["price_status"]) == (2, 1, "estimated")
    assert row["unit_price_low"] < row["unit_price"] < row["unit_price_high"]
    cost = design.totals["cost"]
    assert cost["value"] == pytest.approx(1500.0 + row["unit_price"])
    assert (cost["low"], cost["high"]) == pytest.approx(
        (1500.0 + row["unit_price_low"], 1500.0 + row["unit_price_high"])
    )
    assert cost["estimated"] == pytest.approx(row["unit_price"])
    assert design.scenes[0].figures["cost"] == pytest.approx(cost["value"])


def test_what_limits_a_port_stands_in_the_bill() -> None:
    """What it was made for and what it needs behind it, before the catalogue's note."""
    plain = Port(id="plain", note="For use under two weeks.")
    photo = Port(id="photo", purpose="photo port", mount="nauticam-n120", note="Glass.")
    assert remark(plain) == "For use under two weeks."
    assert remark(Light(id="l", purpose="video light", note="Set by hand.")) == "made as a video light; Set by hand."
    assert remark(Camera(id="c", purpose="board camera")) == "made as a board camera"
    assert remark(Light(id="l")) == ""
    assert remark(photo) == (
        "made as a photo port; needs a photo housing with the mount nauticam-n120; "
        "the adapter is not in the bill; Glass."
    )

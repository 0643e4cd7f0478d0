"""What physics asks of a mission beyond its form, and what it warns of: each fault with key, value and way out."""

from __future__ import annotations

import copy
import math
import re
from pathlib import Path
from typing import Any

import pytest

import uwopt
from uwopt.errors import CatalogError, MissionError
from uwopt.forward.scene_checks import check_physical
from uwopt.mission.mission import load_mission

MISSION: dict[str, Any] = {
    "practice": "bare", "name": "checks", "physics": "full",
    "scene": {"name": "reef", "water": "II", "seafloor": "sand", "depth_m": 30},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3},
    "requirements": {"overlap": 0.3},
}  # fmt: skip
SYSTEM: dict[str, Any] = {
    "camera": {
        "resolution_x_px": 2448, "resolution_y_px": 2048, "pixel_pitch_um": 3.45, "read_noise_e": 2.4,
        "quantum_efficiency": 0.6, "gain_dn_per_e": 0.35, "bit_depth": 12,
    },
    "lens": {"focal_length_mm": 8.0, "transmission": 0.9},
    "port": {"geometry": "dome", "outer_radius_mm": 100, "thickness_mm": 10, "refractive_index": 1.5},
    "light": {
        "flux_lm": 4000, "power_w": 40, "spectrum": "generic-led", "beam": "cosine-power", "beam_half_angle_deg": 40,
    },
    "light_mounts": [{"x_m": 0.0, "y_m": 0.5, "z_m": 0.0}],
    "settings": {"f_number": 4.0, "exposure_ms": 1.0, "gain": 1.0, "flux_lm": 4000},
}  # fmt: skip


def mission(**changed: Any) -> dict[str, Any]:
    """MISSION with keys of its sections changed: scene=..., vehicle=..., objective=..."""
    made = copy.deepcopy(MISSION)
    for key, value in changed.items():
        if isinstance(value, dict) and key in made:
            made[key] |= value
        else:
            made[key] = value
    return made


def system(**changed: Any) -> dict[str, Any]:
    made = copy.deepcopy(SYSTEM)
    for key, value in changed.items():
        made[key] = made[key] | value if isinstance(value, dict) else value
    return made


def fault_of(**changed: Any) -> str:
    with pytest.raises(MissionError) as caught:
        check_physical(load_mission(mission(**changed)))
    return str(caught.value)


def figures(**changed: Any) -> dict[str, Any]:
    result = uwopt.evaluate(mission(**changed), SYSTEM)
    assert result.design is not None
    return dict(result.design.scenes[0].figures)


# ---------------------------------------------------------------- faults

#: what is changed in the mission, and what the message holds: key, value, way out
FAULTS: dict[str, tuple[dict[str, Any], list[str]]] = {
    "a lamp below the floor": (
        {"vehicle": {"light_mounts": [{"y_m": 0.5}, {"y_m": -0.5, "z_m": 2.5}]}},
        ["vehicle.light_mounts[1].z_m = 2.5 m", "2 m below the port", "lower z_m or raise the altitude"],
    ),
    "a lamp on the floor at the lowest altitude": (
        {"vehicle": {"altitude_tolerance_m": 0.5, "light_mounts": [{"y_m": 0.5, "z_m": 1.5}]}},
        ["vehicle.light_mounts[0].z_m = 1.5 m", "1.5 m below the port at the lowest"],
    ),
    "a lamp over the port": (
        {"vehicle": {"light_mounts": [{"x_m": 0.01, "y_m": 0.0}]}},
        ["vehicle.light_mounts[0] is 0.01 m from the port", "0.02 m radius", "move it aside (x_m or y_m)"],
    ),
    "a baseline within the lamp's radius": (
        {"vehicle": {"light_baseline_m": [0.0, 1.0]}},
        ["vehicle.light_baseline_m = 0 m", "begin at 0.02 m", "physics: paper"],
    ),
    "a sun on the horizon": (
        {"scene": {"sun_lux": 1e5, "sun_elevation_deg": 0}},
        ["sun_elevation_deg = 0", "sun_lux = 100000 lx", "set sun_lux: 0, or raise the sun"],
    ),
    "a camera above the water": (
        {"scene": {"sun_lux": 1e5, "depth_m": 2.2}, "vehicle": {"altitude_tolerance_m": 0.5}},
        ["depth_m = 2.2 m", "greatest altitude, 2.5 m", "set sun_lux: 0"],
    ),
    "information without a bound on the image": (
        {"objective": "information", "vehicle": {"speed_m_s": 0.0}, "requirements": {"frame_interval_s": 2}},
        ["objective: information", "requirements.min_swath_m", "in scene 'reef'"],
    ),
    "information in physics paper": (
        {"objective": "information", "physics": "paper"},
        ["objective: information", "physics paper", "use auto or full"],
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_names_key_value_and_way_out(name: str) -> None:
    changed, pieces = FAULTS[name]
    text = fault_of(**changed)
    assert [piece for piece in pieces if piece not in text] == []


def test_all_faults_are_told_at_once() -> None:
    text = fault_of(
        vehicle={"light_mounts": [{"y_m": 0.0}, {"y_m": 0.5, "z_m": 3.0}]},
        scene={"sun_lux": 1e5, "sun_elevation_deg": 0, "depth_m": 1.0},
    )
    keys = ("light_mounts[0]", "light_mounts[1]", "sun_elevation_deg", "depth_m = 1 m")
    assert [text.count(key) for key in keys] == [1, 1, 1, 1]


@pytest.mark.parametrize(
    "changed", [{}, {"vehicle": {"light_baseline_m": 0.02}}, {"scene": {"depth_m": 1.0}}]
)
def test_what_is_possible_is_not_refused(changed: dict[str, Any]) -> None:
    # a lamp that just clears the port; a floor above the surface means nothing where no sun shines
    check_physical(load_mission(mission(**changed)))


@pytest.mark.parametrize(
    "name", ["a lamp over the port", "a baseline within the lamp's radius", "a sun on the horizon"]
)
def test_physics_paper_does_not_ask_for_what_it_does_not_use(name: str) -> None:
    changed, _ = FAULTS[name]
    check_physical(load_mission(mission(**changed, physics="paper")))


@pytest.mark.parametrize("call", ["evaluate", "solve"])
def test_a_sun_below_the_horizon_is_refused_before_any_work(call: str) -> None:
    given = mission(scene={"sun_lux": 1e5, "sun_elevation_deg": 0})
    with pytest.raises(MissionError, match=r"sun_elevation_deg = 0 is not above the horizon"):
        uwopt.evaluate(given, SYSTEM) if call == "evaluate" else uwopt.solve(given)


# ---------------------------------------------------------------- files


def test_a_phase_function_that_loses_half_of_the_light_is_refused_with_the_reason(tmp_path: Path) -> None:
    # isotropic, 1/(8 pi) instead of 1/(4 pi): the integral over the sphere is 0.5
    rows = "\n".join(f"{angle},{1 / (8 * math.pi):.9f}" for angle in range(0, 181, 10))
    (tmp_path / "half.csv").write_text(f"angle_deg,phase_per_sr\n{rows}\n", encoding="utf-8")
    with pytest.raises(CatalogError) as caught:
        uwopt.evaluate(mission(scene={"phase_function": str(tmp_path / "half.csv")}), SYSTEM)
    text = str(caught.value)
    assert "half.csv" in text
    assert "integral of the phase function over the sphere is 0.5;" in text
    assert "divide by the scattering coefficient b" in text


def test_a_phase_function_of_its_own_is_used(tmp_path: Path) -> None:
    # isotropic scattering sends half of the light backward, Fournier-Forand 1.83 %
    rows = "\n".join(f"{angle},{1 / (4 * math.pi):.9f}" for angle in range(0, 181, 10))
    (tmp_path / "even.csv").write_text(f"angle_deg,phase_per_sr\n{rows}\n", encoding="utf-8")
    even = figures(scene={"phase_function": str(tmp_path / "even.csv")})
    assert even["electrons_backscatter"] > 5 * figures()["electrons_backscatter"]


def test_a_water_of_negative_attenuation_is_refused(tmp_path: Path) -> None:
    text = "wavelength_nm,attenuation_per_m\n380,0.2\n550,-0.1\n780,0.9\n"
    (tmp_path / "glowing.csv").write_text(text, encoding="utf-8")
    with pytest.raises(CatalogError) as caught:
        uwopt.evaluate(mission(scene={"water": str(tmp_path / "glowing.csv")}), SYSTEM)
    assert re.search(r"glowing\.csv.*attenuation_per_m.*-0\.1", str(caught.value))


# ---------------------------------------------------------------- warnings


def dark_warnings(**changed: Any) -> list[str]:
    result = uwopt.evaluate(MISSION, system(**changed))
    return [item["message"] for item in result.warnings if item["code"] == "dark_image"]


def test_a_narrow_cone_leaves_an_image_dark_and_the_share_is_that_of_its_circle() -> None:
    # 2 m below the lamp a cone of 15 deg lights a circle of radius 2 tan 15 deg = 0.536 m, all within the footprint
    # of (2 + 0.1) m * 8.4456 mm / 8 mm by (2 + 0.1) m * 7.0656 mm / 8 mm = 2.217 m by 1.855 m: 0.902 of 4.112 m2 are
    # lit, 78.1 % are dark. Behind a dome floor and image are alike. Cells of 1/80 of a side: 0.5 % at most
    cone = {"beam": "cone", "beam_half_angle_deg": 15}
    (text,) = dark_warnings(light=cone, light_mounts=[{"x_m": 0.0, "y_m": 0.3, "z_m": 0.0}])
    found = re.search(r"no light reaches (\d+) % of the image", text)
    assert found is not None
    assert int(found[1]) == pytest.approx(78.1, abs=1.0)


def test_the_border_of_a_half_lit_image_counts_like_its_middle() -> None:
    # A lobe lights nothing behind its front plane. That of a lamp at y = 1 m which leans outward by 60 deg meets the
    # floor, 2 m below, at y = 1 - 2 / tan 60 deg = -0.155 m; of the footprint, 1.108 m to either side,
    # (1.108 - 0.155) / 2.217 = 43.0 % are dark
    lobe = {"beam": "cosine-power", "beam_half_angle_deg": 40}
    mounts = [{"x_m": 0.0, "y_m": 1.0, "z_m": 0.0, "tilt_y_deg": 60}]
    (text,) = dark_warnings(light=lobe, light_mounts=mounts)
    found = re.search(r"no light reaches (\d+) % of the image", text)
    assert found is not None
    assert int(found[1]) == pytest.approx(43.0, abs=1.2)


def test_an_image_that_is_lit_all_over_is_not_warned_about() -> None:
    assert dark_warnings() == []
    assert dark_warnings(light={"beam": "cone", "beam_half_angle_deg": 60}) == []


# ---------------------------------------------------------------- sunlight


def test_sunlight_adds_electrons_in_proportion_to_its_lux() -> None:
    none, one, three = (figures(scene={"sun_lux": lux}) for lux in (0, 20_000, 60_000))
    assert none["electrons_sun"] in (None, 0.0)
    assert one["electrons_sun"] > 1.0
    assert three["electrons_sun"] == pytest.approx(3 * one["electrons_sun"], rel=1e-9)
    # every electron counts in the level: 0.35 DN each
    added_dn = [lit["mean_dn"] - none["mean_dn"] for lit in (one, three)]
    assert added_dn == pytest.approx([0.35 * lit["electrons_sun"] for lit in (one, three)], rel=1e-9)


def test_sunlight_fades_with_the_depth_of_the_floor() -> None:
    shallow, deep, abyss = (
        figures(scene={"sun_lux": 1e5, "depth_m": depth_m})["electrons_sun"] for depth_m in (10, 30, 1000)
    )
    assert shallow > 3 * deep > 0.0
    assert abyss is None  # exp(-0.06 * 850) of 1e5 lx is 7e-18 lx: no sun is left to model


@pytest.mark.parametrize(("depth_m", "seen"), [(30, True), (300, True), (3000, False)])
def test_a_sun_that_no_camera_could_see_is_no_sun(depth_m: float, seen: bool) -> None:
    # Type II: K_d is 0.06 1/m or more. 1e5 lx exp(-0.06 * 300) = 1.5e-3 lx; at 3000 m exp(-180) is nothing,
    # and the shutter, here far longer than the pulse, must not count in the blur.
    lit = mission(scene={"sun_lux": 1e5, "depth_m": depth_m}, requirements={"max_blur_px": 1.0})
    pulsed = system(light={"kind": "pulsed_led"}, settings={"exposure_ms": 50.0, "pulse_ms": 0.5})
    figures = uwopt.evaluate(lit, pulsed).design.scenes[0].figures
    assert (figures["electrons_sun"] is not None) == seen
    # 0.3 m/s over pixels of (2 + 0.1) * 3.45e-6 / 8e-3 m, less what the lens moves out, for 50 or 0.5 ms
    pixel_m = 2.1 * 3.45e-6 / 8e-3 * figures["f_number"] / figures["working_f_number"]
    assert figures["blur_px"] == pytest.approx(0.3 * (50e-3 if seen else 0.5e-3) / pixel_m, rel=1e-6)

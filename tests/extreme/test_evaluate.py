"""`uwopt.evaluate` at extreme numbers: no NaN, infinity or wrong sign; the impossible is said.

On the axis physics `paper` has a closed form; it is evaluated in arbitrary precision from the physics page for
every extreme case. The other physics are held to what limits and symmetries demand.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import extreme_cases as cases
import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from thorough import THOROUGH

import uwopt
from uwopt.errors import MissionError

mp.mp.dps = 40
EXAMPLES = 100 if THOROUGH else 6
PHYSICS = ("full", "auto", "paper") if THOROUGH else ("full", "paper")
IN_FULL = PHYSICS if THOROUGH else ("full",)  # what geometry alone decides: it is the same in both
LEAST_NOISE_E = 1e-12  # less, but for none at all, is taken for a wrong unit
GREEN = ["wavelength_nm,relative_power", "380,0", "549.99,0", "550,1", "550.01,0", "780,0"]


def evaluated(physics: str = "full", *, parts: dict[str, Any] | None = None, **mission: Any) -> uwopt.Result:
    return uwopt.evaluate(cases.mission(physics, **mission), cases.system(**(parts or {})))


# ---------------------------------------------------------------- a closed form


CLOSED = [
    dict(), dict(c=1e-9), dict(c=500.0), dict(c=170.0), dict(altitude_m=0.01), dict(altitude_m=100.0, c=0.01),
    dict(flux_lm=1.0), dict(flux_lm=1e7), dict(exposure_ms=1e-3), dict(exposure_ms=6e4), dict(f_number=0.95),
    dict(f_number=64.0), dict(read_noise_e=0.0), dict(read_noise_e=0.0, c=150.0), dict(half_angle_deg=0.1),
    dict(half_angle_deg=84.0), dict(flux_lm=1e7, exposure_ms=6e4, f_number=0.95, altitude_m=0.01),
    dict(flux_lm=1.0, exposure_ms=1e-3, f_number=64.0, altitude_m=100.0, c=3.0),
]  # fmt: skip


@pytest.mark.parametrize("case", CLOSED, ids=str)
def test_one_wavelength_in_physics_paper_equals_the_closed_form(
    case: dict[str, float], tmp_path: Path
) -> None:
    """E = Phi/(pi d^2 tan^2 b) e^-2cd, (2), (4), (5), (7): a line at 550 nm needs no integral."""
    at = {
        "c": 0.2, "altitude_m": 2.0, "flux_lm": 1e4, "exposure_ms": 1.0, "f_number": 4.0, "read_noise_e": 2.4,
        "half_angle_deg": 40.0,
    } | case  # fmt: skip
    line = cases.table(tmp_path / "green.csv", GREEN)
    result = evaluated(
        "paper", scene={"water": cases.flat_water(tmp_path, a_per_m=at["c"], b_per_m=0.0)},
        vehicle={"altitude_m": at["altitude_m"], "speed_m_s": 0.0},
        parts={
            "camera": {"read_noise_e": at["read_noise_e"]},
            "light": {
                "spectrum": line, "flux_lm": at["flux_lm"], "beam": "disc", "beam_half_angle_deg": at["half_angle_deg"],
            },
            "settings": {"f_number": at["f_number"], "exposure_ms": at["exposure_ms"]},
        },
    )  # fmt: skip
    figures = cases.assert_sound(result)
    d, visible = mp.mpf(at["altitude_m"]), mp.mpf("0.9949501")  # V(550 nm), CIE 1924
    lux = mp.mpf(at["flux_lm"]) / (mp.pi * d**2 * mp.tan(mp.radians(mp.mpf(at["half_angle_deg"]))) ** 2)
    image = lux / (mp.mpf("683.002") * visible) * mp.exp(-2 * mp.mpf(at["c"]) * d)
    image *= mp.mpf("0.2") / mp.pi * mp.pi / 4 * mp.mpf("0.9") / mp.mpf(at["f_number"]) ** 2
    photon_j = mp.mpf("6.62607015e-34") * 299792458 / mp.mpf("550e-9")
    electrons = image * mp.mpf("0.6") * mp.mpf("3.45e-6") ** 2 * mp.mpf(at["exposure_ms"]) / 1000 / photon_j
    variance = mp.mpf(at["read_noise_e"]) ** 2 + 1 / (12 * (mp.mpf("0.35") * 2**4) ** 2) + electrons
    # Physics `paper` counts DN of 16 bit: K = 0.35 * 2^(16 - 12). 1e-6: the shipped V has seven digits
    for got, wanted in (
        (figures["electrons_signal"], electrons),
        (figures["snr"], electrons / mp.sqrt(variance)),
    ):
        if wanted > mp.mpf("1e-300"):
            assert abs(mp.mpf(got) / wanted - 1) < 1e-6, (got, mp.nstr(wanted, 12))
        else:
            assert got == 0.0 and figures["snr_db"] is None


# ---------------------------------------------------------------- every extreme, end to end


WATERS = [(0.0, 0.0, None), (0.3, 0.0, 0.0), (0.0, 0.3, 0.0), (1e-9, 1e-9, None), (0.0, 100.0, 0.0),
          (500.0, 500.0, 500.0), (1000.0, 0.0, None)]  # fmt: skip


@pytest.mark.parametrize("physics", PHYSICS)
@pytest.mark.parametrize("water", WATERS, ids=str)
def test_waters_from_vacuum_to_ink(
    physics: str, water: tuple[float, float, float | None], tmp_path: Path
) -> None:
    """c r up to 4000; pure absorption and pure scattering."""
    a, b, kd = water
    result = evaluated(
        physics, scene={"water": cases.flat_water(tmp_path, a_per_m=a, b_per_m=b, kd_per_m=kd)},
        requirements={"min_snr": 0.5, "min_contrast": 0.01, "snr_at": "worst_px"},
    )  # fmt: skip
    figures = cases.assert_sound(result)
    if physics == "full" and b == 0.0:
        assert figures["electrons_backscatter"] == 0.0  # nothing scatters
    if a + b >= 100:
        assert "min_snr_db" in cases.missed(result)
        assert figures["snr"] < 1e-80
        (lost,) = (m for m in result.best.scenes[0].margins if m.requirement == "min_snr_db")
        assert (lost.value, lost.margin, lost.word, lost.satisfied) == (None, None, "no signal", False)


@pytest.mark.parametrize("physics", IN_FULL)
@pytest.mark.parametrize("altitude_m", [0.01, 0.1, 100.0])
@pytest.mark.parametrize("port", [cases.DOME, cases.FLAT], ids=["dome", "flat"])
def test_altitudes(physics: str, altitude_m: float, port: dict[str, Any]) -> None:
    figures = cases.assert_sound(
        evaluated(
            physics,
            vehicle={"altitude_m": altitude_m},
            requirements={"min_dof_m": 1e-3},
            parts={"port": port},
        )
    )
    assert figures["focus_distance_m"] == pytest.approx(altitude_m, rel=1e-9)  # through dioptres and back


@pytest.mark.parametrize("speed_m_s", [0.0, 20.0])
@pytest.mark.parametrize("overlap", [0.0, 0.99])
def test_speeds_and_overlaps(speed_m_s: float, overlap: float) -> None:
    result = evaluated(vehicle={"speed_m_s": speed_m_s}, requirements={"overlap": overlap})
    figures = cases.assert_sound(result)
    image_m = 8e-3 * figures["working_f_number"] / figures["f_number"]  # f (1 + m), so far the lens moves out
    assert figures["blur_px"] == pytest.approx(
        speed_m_s * 1e-3 / (2.1 * 3.45e-6 / image_m), rel=1e-12
    )  # t v f/((d+R) p)
    rate = speed_m_s / (2448 * 3.45e-6 / image_m * 2.1 * (1 - overlap))
    assert figures["frame_rate_min_hz"] == pytest.approx(rate, rel=1e-12)
    assert ("max_blur_px" in cases.missed(result)) == (speed_m_s > 0)
    assert (figures["exposure_max_ms"] is None) == (speed_m_s == 0)
    assert figures.get("exposure_max_is_infinite", False) == (speed_m_s == 0)


@pytest.mark.parametrize("physics", IN_FULL)
@pytest.mark.parametrize("f_number", [0.95, 64.0])
@pytest.mark.parametrize("focus_m", [0.01, 0.5, 2.0, 8.0, 1e4])
def test_focus_inside_at_and_beyond_hyperfocal(physics: str, f_number: float, focus_m: float) -> None:
    result = evaluated(
        physics, requirements={"min_dof_m": 0.1},
        parts={"settings": {"f_number": f_number, "focus_distance_m": focus_m}, "port": cases.FLAT},
    )  # fmt: skip
    figures = cases.assert_sound(result)
    assert figures["dof_far_is_infinite"] == (figures["dof_far_m"] is None)
    assert figures.get("dof_is_infinite", False) == (figures["dof_m"] is None)
    if f_number == 0.95 and focus_m == 0.01:
        assert "dof_far_m" in cases.missed(result)


@pytest.mark.parametrize(
    ("focal_mm", "port", "altitude_m"),
    [(25.0, cases.FLAT, 0.01), (100.0, cases.FLAT, 0.05), (500.0, cases.DOME, 2.0),
     (8.0, {**cases.DOME, "outer_radius_mm": 10.0001}, 2.0)],
    ids=str,
)  # fmt: skip
@pytest.mark.parametrize("dof_at", ["axis", "corner"])
def test_what_lies_within_the_focal_length_has_no_image(
    focal_mm: float, port: dict[str, Any], altitude_m: float, dof_at: str
) -> None:
    """Not a negative f-number, and not an SNR of 200 dB: no light, no depth, and a margin that says why."""
    result = evaluated(
        vehicle={"altitude_m": altitude_m}, parts={"lens": {"focal_length_mm": focal_mm}, "port": port},
        requirements={"min_dof_m": 1e-3, "dof_at": dof_at, "min_mtf_half_nyquist": 0.1, "mean_level": 0.3},
    )  # fmt: skip
    figures = cases.assert_sound(result)
    assert figures["working_f_number"] is None and figures["airy_diameter_um"] is None
    assert figures["working_f_number_is_infinite"] and figures["airy_diameter_is_infinite"]
    assert (figures["snr"], figures["mtf50_cyc_per_px"], figures["dof_m"]) == (0.0, 0.0, 0.0)
    assert {"nearest_focus_m", "min_dof_m", "min_mtf_half_nyquist"} <= cases.missed(result)
    assert "no_image" in {w["code"] for w in result.warnings}


@pytest.mark.parametrize("physics", IN_FULL)
@pytest.mark.parametrize("inner_mm", [0.1, 1.0])
def test_domes_nearly_as_thick_as_their_radius(physics: str, inner_mm: float) -> None:
    """A glass ball with a small hole brings the floor too near for an 8 mm lens; 0 mm is refused."""
    port = {**cases.DOME, "outer_radius_mm": 10.0 + inner_mm}
    result = evaluated(physics, parts={"port": port})
    cases.assert_sound(result)
    assert "nearest_focus_m" in cases.missed(result)
    with pytest.raises(MissionError, match="thickness_mm = 10 is not below outer_radius_mm"):
        evaluated(physics, parts={"port": {**cases.DOME, "outer_radius_mm": 10}})


@pytest.mark.parametrize("focal_mm", [0.5, 3.0])
def test_a_flat_port_at_grazing_view(focal_mm: float) -> None:
    """Corners at 85 degrees in air: colours that are totally reflected there have no spread to tell."""
    figures = cases.assert_sound(evaluated(parts={"lens": {"focal_length_mm": focal_mm}, "port": cases.FLAT}))
    widest_m = 2 * 2.0 * 1.34 / np.sqrt(1.34**2 - 1)  # d tan(asin(1/n)) on both sides, and the gap's part
    assert figures["fov_x_m"] < widest_m + 2 * (0.005 + 0.01) * 2448 * 3.45e-3 / 2 / focal_mm
    assert (figures["lateral_colour_px"] is None) == (focal_mm == 0.5)


@pytest.mark.parametrize("physics", PHYSICS)
@pytest.mark.parametrize(
    "camera",
    [{"read_noise_e": 0}, {"saturation_e": 100}, {"saturation_e": 1e7}, {"gain_dn_per_e": 1e-6}, {"gain_dn_per_e": 1e6},
     {"dark_current_e_s": 1e6}, {"prnu_frac": 0.5}, {"resolution_x_px": 1, "resolution_y_px": 1}],
    ids=str,
)  # fmt: skip
def test_sensors(physics: str, camera: dict[str, Any]) -> None:
    cases.assert_sound(evaluated(physics, parts={"camera": camera}, requirements={"min_snr": 1e4}))


@pytest.mark.parametrize("flux_lm", [1.0, 1e7])
@pytest.mark.parametrize("exposure_ms", [1e-3, 6e4])
@pytest.mark.parametrize("min_snr", [0.1, 1e4])
def test_light_and_time(flux_lm: float, exposure_ms: float, min_snr: float) -> None:
    result = evaluated(
        vehicle={"speed_m_s": 0.0}, requirements={"min_snr": min_snr}, limits={"max_exposure_ms": 6e4},
        parts={"light": {"flux_lm": flux_lm}, "settings": {"exposure_ms": exposure_ms}},
    )  # fmt: skip
    figures = cases.assert_sound(result)
    assert ("min_snr_db" in cases.missed(result)) == (figures["snr"] < min_snr * (1 - 1e-9))
    if flux_lm * exposure_ms > 1e8:  # 1e9 electrons in a well of 1e4
        assert "saturation_fraction" in cases.missed(result)


@pytest.mark.parametrize("line_nm", [450.0, 551.2, 620.37])
def test_a_light_of_one_wavelength(line_nm: float, tmp_path: Path) -> None:
    """A laser line between the grid's points gives the same light as a line on a neighbouring one."""
    rows = ["380,0", f"{line_nm - 0.05},0", f"{line_nm},1", f"{line_nm + 0.05},0", "780,0"]
    near = [
        f"{w},{v}"
        for w, v in ((380, 0), (line_nm // 1 - 0.5, 0), (line_nm // 1, 1), (line_nm // 1 + 0.5, 0), (780, 0))
    ]
    found = []
    for name, lines in (("line", rows), ("near", near)):
        file = cases.table(tmp_path / f"{name}.csv", ["wavelength_nm,relative_power", *lines])
        figures = cases.assert_sound(evaluated(parts={"light": {"spectrum": file}, "port": cases.FLAT}))
        assert figures["lateral_colour_px"] < 0.03  # two points of the grid at most
        found.append(figures["electrons_signal"])
    assert found[0] == pytest.approx(found[1], rel=0.03)  # V changes by up to 2.5 % per nm


@pytest.mark.parametrize("physics", PHYSICS)
def test_a_black_floor_has_no_signal(physics: str) -> None:
    result = evaluated(physics, scene={"seafloor": 0.0}, requirements={"min_snr": 0.1, "min_contrast": 0.1})
    assert cases.assert_sound(result)["snr"] == 0.0
    assert "min_snr_db" in cases.missed(result)


def test_a_lamp_that_the_water_swallows_leaves_a_dark_floor(tmp_path: Path) -> None:
    """A red line where only blue passes: the lamp's own colours count, not the clearest ones."""
    rows = ["wavelength_nm,a_per_m,b_per_m", "380,0.01,0.01", "600,0.01,0.01", "640,900,900", "780,900,900"]
    red = ["wavelength_nm,relative_power", "380,0", "679,0", "680,1", "681,0", "780,0"]
    result = evaluated(
        scene={"water": cases.table(tmp_path / "water.csv", rows)}, requirements={"min_snr": 0.1},
        parts={"light": {"spectrum": cases.table(tmp_path / "red.csv", red)}},
    )  # fmt: skip
    figures = cases.assert_sound(result)
    assert figures["floor_illuminance_mean_lx"] == figures["snr"] == 0.0


# ---------------------------------------------------------------- invariances


@settings(max_examples=EXAMPLES, deadline=None, derandomize=not THOROUGH)
@given(
    flux=st.floats(1.0, 1e6), factor=st.floats(1.0, 10.0), noise=st.just(0.0) | st.floats(LEAST_NOISE_E, 100.0),
    attenuation=st.floats(0.0, 5.0), physics=st.sampled_from(["full", "paper"]),
)  # fmt: skip
def test_more_light_never_lowers_snr(
    flux: float,
    factor: float,
    noise: float,
    attenuation: float,
    physics: str,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    folder = tmp_path_factory.mktemp("water")
    water = cases.flat_water(folder, a_per_m=attenuation / 2, b_per_m=attenuation / 2)
    dim, bright = (
        cases.assert_sound(
            evaluated(
                physics,
                scene={"water": water},
                parts={"light": {"flux_lm": lm}, "camera": {"read_noise_e": noise}},
            )
        )["snr"]
        for lm in (flux, flux * factor)
    )
    assert bright >= dim * (1 - 1e-12)


def test_a_noise_that_no_camera_has_is_refused() -> None:
    for noise in (LEAST_NOISE_E / 2, 2.2e-309):
        with pytest.raises(MissionError, match=r"camera.read_noise_e = .* is below 1e-12, as none is made"):
            evaluated("paper", parts={"camera": {"read_noise_e": noise}})


@settings(max_examples=EXAMPLES, deadline=None, derandomize=not THOROUGH)
@given(rate=st.floats(1e-3, 1e3))
def test_another_exchange_rate_scales_cost_only(rate: float) -> None:
    """One EUR is `rate` USD: cost in EUR is cost in USD over that; nothing else is changed."""
    parts = {"camera": {"price": 1000.0}, "light": {"price": 300.0}}
    usd = cases.assert_sound(evaluated("paper", parts=parts))
    eur = cases.assert_sound(
        evaluated("paper", parts=parts, limits={"currency": "EUR", "rates": {"EUR": rate}})
    )
    assert usd["cost"] == 1300.0
    assert eur["cost"] == pytest.approx(1300.0 / rate, rel=1e-12)
    assert {k: v for k, v in usd.items() if k not in ("cost", "currency")} == {
        k: v for k, v in eur.items() if k not in ("cost", "currency")
    }

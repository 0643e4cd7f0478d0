"""Test shots with known truth: worked out by hand, with the noise of a sensor drawn by NumPy, and fitted back.

Physics `paper` is a closed form: lamps on the axis, an even disc, water that takes exp(-2 c d). So these shots share
nothing with the model that is fitted to them but its equations. Shots with backscatter are the forward model's own.
"""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from thorough import drawn

import uwopt
from uwopt.api.calibrating import calibrate
from uwopt.mission.mission import load_mission
from uwopt.mission.system import load_system
from uwopt.solvers.calibration.fit import LEVEL, Fit, fitted
from uwopt.solvers.calibration.light import shot_light
from uwopt.solvers.calibration.summary import Calibrated

PLANCK_C = 6.62607015e-34 * 299792458.0
FLOOR, C_TOLD, C_TRUE, LIGHT_TRUE = 0.2, 0.25, 0.40, 0.8
GAIN_DN, READ_E, PATCH = 4.0, 3.0, 32 * 32
REFERENCE = Path(__file__).parents[1] / "reference" / "photopic_v_5nm.csv"
PHOTOPIC = np.array([
    [float(cell) for cell in line.split(",")[:2]] for line in REFERENCE.read_text("utf-8").splitlines()
    if line[:1].isdigit()
])  # fmt: skip
SYSTEM: dict[str, Any] = {
    "camera": {
        "resolution_x_px": 2000, "resolution_y_px": 1500, "pixel_pitch_um": 4.0, "read_noise_e": READ_E,
        "quantum_efficiency": 0.6, "gain_dn_per_e": GAIN_DN, "bit_depth": 16, "gain_bits": 16, "saturation_e": 16_000,
    },
    "lens": {"focal_length_mm": 8.0, "transmission": 0.9},
    "port": {"geometry": "flat", "thickness_mm": 10, "gap_mm": 5, "refractive_index": 1.5},
    "light": {"flux_lm": 8000, "power_w": 80, "spectrum": "generic-led", "beam": "disc", "beam_half_angle_deg": 40},
    "settings": {"f_number": 2.8},
}  # fmt: skip


def mission(folder: Path, **scene: Any) -> dict[str, Any]:
    """Over a grey floor in grey water of C_TOLD."""
    (folder / "water.csv").write_text(f"wavelength_nm,attenuation_per_m\n380,{C_TOLD}\n780,{C_TOLD}\n", "utf-8")
    return {
        "practice": "bare", "name": "pool", "physics": "paper",
        "scene": {"name": "pool", "water": str(folder / "water.csv"), "seafloor": FLOOR, "depth_m": 3} | scene,
        "vehicle": {"altitude_m": 1.0, "speed_m_s": 0.0}, "requirements": {"frame_interval_s": 1.0},
    }  # fmt: skip


@cache
def electrons_per_lms() -> float:
    """Of one pixel at 1 m in water that takes nothing, for a second, F1 and a lumen, by (1), (2), (4), (5) with pi."""
    nm = np.arange(380.0, 780.5, 0.5)
    v = np.interp(nm, PHOTOPIC[:, 0], PHOTOPIC[:, 1])
    peaks = ((24.49, 450.70, 11.67), (119.86, 565.43, 64.63))
    led = sum(a * np.exp(-0.5 * ((nm - m) / s) ** 2) / (s * math.sqrt(2 * math.pi)) for a, m, s in peaks)
    watts = led / (683.002 * np.trapezoid(v * led, nm))
    floor = watts / (math.pi * math.tan(math.radians(40.0)) ** 2)
    image = floor * FLOOR / math.pi * 0.9 * math.pi / 4.0
    return float(np.trapezoid(image * 0.6 * nm * 1e-9 / PLANCK_C, nm) * (4e-6) ** 2)


def hand_dn(distance_m: Any, exposure_s: Any, gain: Any, *, light: float = LIGHT_TRUE, c: float = C_TRUE) -> Any:
    """Numbers above the dark level by hand."""
    electrons = electrons_per_lms() * 8000 * exposure_s / 2.8**2 / distance_m**2 * np.exp(-2.0 * c * distance_m)
    return GAIN_DN * gain * light * electrons


DISTANCES = np.repeat([0.5, 1.0, 1.5, 2.0], 4)
EXPOSURES = np.tile([1e-3, 2e-3, 2.5e-3, 5e-3], 4) * DISTANCES**2
GAINS = np.tile([1.0, 1.0, 2.0, 1.0], 4)


def read_by_a_sensor(net_dn: Any, gains: Any, rng: np.random.Generator, *, jitter: float) -> tuple[Any, Any]:
    """Level and dark level as EMVA 1288 has them: Poisson electrons, read noise and rounding, mean of a patch; the lamp
    differs from shot to shot."""
    level, dark = [], []
    for mean_dn, gain in zip(net_dn, gains, strict=True):
        per_e = GAIN_DN * gain
        lit = rng.poisson(mean_dn / per_e * math.exp(rng.normal(0.0, jitter)), PATCH)
        for seen, into in ((lit, level), (np.zeros(PATCH), dark)):
            into.append(float(np.mean(np.round(100.0 + per_e * (seen + rng.normal(0.0, READ_E, PATCH))))))
    return np.array(level), np.array(dark)


def csv_of(path: Path, level: Any, dark: Any, more: str = "") -> Path:
    rows = [
        f"s{n},{1e3 * t!r},{g!r},{d!r},{a!r},{b!r}"
        for n, (t, g, d, a, b) in enumerate(
            zip(*(map(float, one) for one in (EXPOSURES, GAINS, DISTANCES, level, dark)), strict=True)
        )
    ]
    head = "shot,exposure_ms,gain,distance_m,level_dn,dark_dn"
    path.write_text("\n".join([head, *rows, more]) + "\n", encoding="utf-8")
    return path


def fit_of(folder: Path, seed: int, jitter: float = 0.01) -> Calibrated:
    drawn = read_by_a_sensor(hand_dn(DISTANCES, EXPOSURES, GAINS), GAINS, np.random.default_rng(seed), jitter=jitter)
    return calibrate(mission(folder), SYSTEM, csv_of(folder / "shots.csv", *drawn), again=False)


def test_shots_worked_out_by_hand_give_light_and_water_back(tmp_path: Path) -> None:
    net = hand_dn(DISTANCES, EXPOSURES, GAINS)
    made = calibrate(mission(tmp_path), SYSTEM, csv_of(tmp_path / "s.csv", net + 100.0, 0 * net + 100.0), again=False)
    factors = made.fit.factors
    assert factors["light"].value == pytest.approx(LIGHT_TRUE, rel=2e-3)  # V by 5 nm, spectra by 0.5 nm
    assert factors["water"].value == pytest.approx(C_TRUE / C_TOLD, rel=1e-3)
    assert factors["back"].held and made.fit.rms_frac < 2e-3 and made.fit.freedom == 14


def test_what_was_fitted_is_what_the_new_mission_shows(tmp_path: Path) -> None:
    """Its floor and water, evaluated, give each level that the fit told."""
    made = fit_of(tmp_path, 3)
    for name, text in made.files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    new = load_mission(tmp_path / "calibrated.yaml")
    assert new.scenes[0].seafloor == pytest.approx(FLOOR * made.fit.factors["light"].value, rel=1e-3)
    settings = {"f_number": 2.8, "exposure_ms": 1e3 * float(EXPOSURES[5]), "gain": 1.0}
    seen = uwopt.evaluate(new.with_changes(physics="paper"), SYSTEM | {"settings": settings})
    assert seen.design is not None
    told = seen.design.scenes[0].figures["mean_dn"]
    assert told == pytest.approx(float(made.fit.predicted_dn[5]), rel=2e-3)


def test_intervals_hold_the_truth_as_often_as_they_say(tmp_path: Path) -> None:
    """Many times 16 shots whose lamp differs by 2 %: 95 % of intervals, give or take three standard errors of that."""
    made, rng = fit_of(tmp_path, 1), np.random.default_rng(8)
    light = light_of(made)
    held = {"light": 0, "water": 0}
    truth = {"light": LIGHT_TRUE, "water": C_TRUE / C_TOLD}
    times = drawn(60, 2000)
    for _ in range(times):
        net = hand_dn(DISTANCES, EXPOSURES, GAINS) * np.exp(rng.normal(0.0, 0.02, len(DISTANCES)))
        found: Fit = fitted(light, net, distances_m=DISTANCES)
        for name in held:
            one = found.factors[name]  # type: ignore[index]
            assert one.low is not None and one.high is not None
            held[name] += one.low <= truth[name] <= one.high
    assert LEVEL == 0.95
    for name, count in held.items():
        assert abs(count / times - 0.95) <= 3.0 * math.sqrt(0.95 * 0.05 / times), (name, count)


def light_of(made: Calibrated) -> Any:
    from uwopt.api.calibrating import distances

    standing = distances(made.mission, made.system, 0, made.shots, None)
    return shot_light(standing, made.shots, in_middle=False)


def test_a_shot_that_does_not_fit_is_told_and_not_taken(tmp_path: Path) -> None:
    net = hand_dn(DISTANCES, EXPOSURES, GAINS) * np.exp(np.random.default_rng(2).normal(0.0, 0.01, 16))
    net[6] *= 0.7  # a diver's shadow
    made = calibrate(mission(tmp_path), SYSTEM, csv_of(tmp_path / "s.csv", net + 64, 0 * net + 64), again=False)
    assert [shot.name for shot, out in zip(made.shots, made.fit.outlier, strict=True) if out] == ["s6"]
    assert made.fit.factors["water"].value == pytest.approx(C_TRUE / C_TOLD, rel=0.03)


def test_of_few_shots_none_is_called_wrong(tmp_path: Path) -> None:
    """Five shots and two factors: a shadow on one of them is told by the scatter and a wide interval alone."""
    made = fit_of(tmp_path, 1)
    some = np.array([0, 5, 8, 12, 15])
    net = hand_dn(DISTANCES, EXPOSURES, GAINS)[some] * np.array([1.0, 1.0, 0.7, 1.0, 1.0])
    found = fitted(light_of(made).take(some), net, distances_m=DISTANCES[some])
    assert not found.outlier.any() and found.rms_frac > 0.05


def test_saturated_and_dark_shots_are_left_out_by_name(tmp_path: Path) -> None:
    net = hand_dn(DISTANCES, EXPOSURES, GAINS)
    level, dark = net + 64.0, 0 * net + 64.0
    level[3], level[9] = 65_000.0, 63.0
    made = calibrate(mission(tmp_path), SYSTEM, csv_of(tmp_path / "s.csv", level, dark), again=False)
    assert made.left_out == {"s3": "saturated", "s9": "no brighter than its dark level"}
    assert len(made.shots) == 14 and made.fit.factors["water"].value == pytest.approx(1.6, rel=1e-3)


def test_a_shot_of_which_the_model_tells_less_than_a_number_is_left_out(tmp_path: Path) -> None:
    """Half a number by hand, and two of stray light; another of two numbers counts."""
    net = hand_dn(DISTANCES, EXPOSURES, GAINS)
    told_dn_s = float(hand_dn(2.0, 1.0, 1.0, light=1.0, c=C_TOLD))
    more = "\n".join(f"{name},{1e3 * dn / told_dn_s!r},1,2,66,64" for name, dn in (("faint", 0.5), ("seen", 2.0)))
    shots = csv_of(tmp_path / "s.csv", net + 64.0, 0 * net + 64.0, more)
    assert list(calibrate(mission(tmp_path), SYSTEM, shots, again=False).left_out) == ["faint"]


def test_a_full_well_saturates_below_the_last_number(tmp_path: Path) -> None:
    """16 000 electrons at 4 DN are 64 000 at gain 1, at gain 2 the numbers end first."""
    net = hand_dn(DISTANCES, EXPOSURES, GAINS)
    net[3] = 0.96 * 16_000 * GAIN_DN
    made = calibrate(mission(tmp_path), SYSTEM, csv_of(tmp_path / "s.csv", net + 64, 0 * net + 64), again=False)
    assert made.left_out == {"s3": "saturated"}


def test_shots_from_one_distance_hold_the_water(tmp_path: Path) -> None:
    net = hand_dn(1.0, EXPOSURES, GAINS)
    text = "exposure_s,gain,distance_cm,level_pct,dark_pct\n" + "".join(
        f"{t!r},{g!r},100,{100 * (n + 64) / 65535!r},{6400 / 65535!r}\n"
        for t, g, n in zip(map(float, EXPOSURES), map(float, GAINS), map(float, net), strict=True)
    )
    (tmp_path / "s.csv").write_text(text, "utf-8")
    made = calibrate(mission(tmp_path), SYSTEM, tmp_path / "s.csv", again=False)
    assert "only another distance tells water from light" in made.fit.factors["water"].held
    assert "calibrated-water.csv" not in made.files
    # the light takes what the water was told too clear: exp(-2 (0.40 - 0.25) 1 m)
    assert made.fit.factors["light"].value == pytest.approx(LIGHT_TRUE * math.exp(-0.3), rel=2e-3)


def test_noisy_shots_from_near_distances_hold_the_water(tmp_path: Path) -> None:
    """1.00 and 1.02 m with 3 % of scatter tell the water within a factor of ten at best."""
    made = fit_of(tmp_path, 4)
    near = np.where(DISTANCES > 1.2, 1.02, 1.0)
    net = 0.2 * hand_dn(near, EXPOSURES, GAINS) * np.exp(np.random.default_rng(5).normal(0.0, 0.03, 16))
    rows = "".join(
        f"{1e3 * t!r},{g!r},{d!r},{n!r},0\n"
        for t, g, d, n in zip(*(map(float, one) for one in (EXPOSURES, GAINS, near, net)), strict=True)
    )
    (tmp_path / "n.csv").write_text("exposure_ms,gain,distance_m,level_dn,dark_dn\n" + rows, "utf-8")
    made = calibrate(mission(tmp_path), SYSTEM, tmp_path / "n.csv", again=False)
    assert made.fit.factors["water"].held and made.fit.factors["water"].value == 1.0
    assert made.fit.factors["light"].low is not None


# ---------------------------------------------------------------- the forward model's own shots


TURBID = {"water": "5C", "seafloor": "sand"}


@cache
def turbid_system() -> Any:
    lamp = SYSTEM["light"] | {"beam": "cosine-power", "beam_half_angle_deg": 35}
    camera = SYSTEM["camera"] | {"resolution_x_px": 32, "resolution_y_px": 32}
    return load_system(SYSTEM | {"camera": camera, "light": lamp, "light_mounts": [{"y_m": 0.15}]})


def test_backscatter_is_told_where_it_shows(tmp_path: Path) -> None:
    """Levels of the forward model in water that sends back twice as much, 1 % of scatter drawn on them."""
    # single scattering: else a ratio changes K on every leg, not backscatter alone
    told = mission(tmp_path, **TURBID, multiple_scattering=False) | {"physics": "full"}
    distances_m, truth = [0.3, 0.7, 1.4, 2.3], load_mission(told)
    rng, rows = np.random.default_rng(6), []
    for distance_m in distances_m:
        there = truth.with_changes(
            vehicle={"altitude_m": distance_m, "speed_m_s": 0.0},
            scenes=[{**truth.to_dict()["scenes"][0], "backscatter_ratio": 2 * 0.0183}],
        )
        settings = {"f_number": 2.8, "exposure_ms": 2.0 * distance_m, "gain": 1.0}
        seen = uwopt.evaluate(there, {**turbid_system().to_dict(), "settings": settings})
        assert seen.design is not None
        for lamp in np.exp(rng.normal(0.0, 0.01, 2)):
            level = seen.design.scenes[0].figures["mean_dn"] * float(lamp)
            rows.append(f"{2.0 * distance_m!r},1,{distance_m!r},{level!r},0")
    head = "exposure_ms,gain,distance_m,level_dn,dark_dn\n"
    (tmp_path / "s.csv").write_text(head + "\n".join(rows) + "\n", "utf-8")
    made = calibrate(told, turbid_system(), tmp_path / "s.csv", again=False)
    back = made.fit.factors["back"]
    assert not back.held and back.low is not None and back.high is not None
    assert back.low <= 2.0 <= back.high and back.low > 1.0
    assert "calibrated-floor.csv" in made.files  # sand has a spectrum

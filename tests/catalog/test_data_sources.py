"""The built-in data say what their sources say.

Expected values are copied by hand from the pages and tables named beside them, not taken from our code.
"""

from __future__ import annotations

import csv
import math
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import uwopt.catalog
from uwopt.catalog.curves import spectra

DATA_DIR = Path(uwopt.catalog.__file__).parent / "data"
SEED_CURVE_POINTS = 1080 - 14  # the tool's points less those beyond 912 nm, see the file's head


def rows_of(file: str) -> list[dict[str, str]]:
    with (DATA_DIR / file).open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def row_of(file: str, **wanted: str) -> dict[str, str]:
    found = [row for row in rows_of(file) if all(row[name] == text for name, text in wanted.items())]
    assert len(found) == 1, (file, wanted)
    return found[0]


# Cells copied by hand from the pages or tables named in the comment.
CELLS = [
    ("cameras.csv", "flir-bfs-u3-51s5m", "read_noise_e", 2.44),  # FLIR EMVA page of this camera
    ("cameras.csv", "flir-bfs-u3-51s5m", "saturation_e", 10970),  # the same; 10^4.040 = 10965 from its SNR
    ("cameras.csv", "flir-bfs-u3-50s5c", "read_noise_e", 3.0),  # 17.63 DN16 / 5.882 DN16 per e-
    ("cameras.csv", "avt-alvium-1800-c-508m", "max_frame_rate_hz", 95),  # Alvium user guide
    ("cameras.csv", "basler-aca4024-29um", "qe", 0.83),  # Basler EMVA overview, 545 nm
    ("cameras.csv", "flir-bfs-u3-120s4m", "max_gain_db", 27),  # FLIR specification page: 0-27 dB
    ("cameras.csv", "seed-imx250m", "read_noise_e", 13.7),  # the tool's own dark_noise
    ("cameras.csv", "seed-imx250m", "gain_dn_per_e", 5.556),  # the tool's own gain
    ("cameras.csv", "seed-imx250c", "resolution_x_px", 2488),  # the tool's slip for 2448
    ("cameras.csv", "seed-icx285alm", "max_exposure_us", 77.3e6),  # the tool's 7.73e+07
    ("lenses.csv", "kowa-lm8jc10m", "focal_length_mm", 8.5),  # maker's product page; data sheet table: 8
    ("lenses.csv", "kowa-lm8jc10m", "rated_lp_per_mm", 200),  # "2.5 um pixel; 200 lp/mm"
    ("lenses.csv", "kowa-lm8jc10m", "rated_pixel_pitch_um", 2.5),
    ("lenses.csv", "fujinon-cf8za-1s", "distortion_pct", -4.81),
    ("lenses.csv", "hikrobot-mvl-kf2528m-12mpe", "price_low", 210),  # quoted as 210-280 USD
    ("lights.csv", "blue-robotics-lumen-r2", "price", 162.5),  # 650 USD for four
    ("lights.csv", "blue-robotics-lumen-r2", "depth_rating_m", 950),
    ("lights.csv", "arctic-rays-dragonfish-mini-strobe", "mean_power_w", 16),
    ("lights.csv", "nikon-nikonos-sb-104", "guide_number_m", 32),
    ("ports.csv", "blue-robotics-4-in-series-end-cap-first-generation", "clear_diameter_mm", 89),
    ("ports.csv", "blue-robotics-4-in-dome-aluminium-ring-2026", "outer_radius_mm", 44 + 5.8),  # data sheet WTE Rev C.5
    ("ports.csv", "teledyne-benthos-2040-17v-sphere-17-in", "depth_rating_m", 6706),  # 22 000 ft
    ("ports.csv", "nautilus-vitrovex-mdom-vessel-half", "refractive_index", 1.4711),
    ("housings.csv", "blue-robotics-4-in-aluminium-tube-300", "wall_mm", (112 - 103) / 2),  # the same data sheet
    ("housings.csv", "blue-robotics-4-in-aluminium-tube-300", "mass_g", 1066 + 2 * 107 + 223),  # tube, flanges, cap
    ("housings.csv", "blue-robotics-4-in-acrylic-tube-200", "price", 170 + 2 * 50 + 42),  # tube, flanges, cap
    ("housings.csv", "blue-robotics-4-in-acrylic-tube-300", "price", 330 + 42),  # tube with flanges, cap
    ("housings.csv", "blue-robotics-3-in-acrylic-tube-150", "price", 115 + 2 * 34 + 32),
    ("housings.csv", "blue-robotics-3-in-acrylic-tube-150", "depth_rating_m", 275),  # the maker's configurator
    ("housings.csv", "blue-robotics-3-in-acrylic-tube-240", "price", 180 + 2 * 40 + 32),
    ("housings.csv", "blue-robotics-3-in-aluminium-tube-150", "price", 242 + 2 * 40 + 32),
    ("housings.csv", "blue-robotics-3-in-aluminium-tube-240", "price", 264 + 2 * 40 + 32),
    ("lights.csv", "subc-aquorea-mk3", "power_w", 5 * 24),  # "LED 5A @ 20-30V", "120W"
    ("lenses.csv", "raspberry-pi-16-mm-telephoto-hq-camera", "price", 54),  # a shop, as a user copied it
]


@pytest.mark.parametrize(("file", "part_id", "column", "value"), CELLS)
def test_cell_equals_its_source(file: str, part_id: str, column: str, value: float):
    assert float(row_of(file, id=part_id)[column]) == value


def test_corrections_keep_the_old_value():
    assert "13.7" in row_of("cameras.csv", id="flir-bfs-u3-51s5m")["correction"]
    assert "208000" in row_of("cameras.csv", id="avt-alvium-1800-c-040m")["correction"]
    assert "8 is nominal" in row_of("lenses.csv", id="kowa-lm8jc10m")["correction"]
    assert "16 W" in row_of("lights.csv", id="arctic-rays-dragonfish-mini-strobe")["correction"]


def test_jerlov_cells_equal_the_published_tables():
    # Jerlov 1968: 92 % per metre at 400 nm in type II is -ln 0.92 = 0.0834; type III as listed there.
    assert float(row_of("jerlov_iop.csv", water_type="II", wavelength_nm="400")["kd_per_m"]) == pytest.approx(
        -math.log(0.92), rel=1e-3
    )  # printed to whole percent and four digits
    third = {550: 0.145, 575: 0.192, 600: 0.288, 700: 0.616}
    for wavelength_nm, kd_per_m in third.items():
        row = row_of("jerlov_iop.csv", water_type="III", wavelength_nm=str(wavelength_nm))
        assert float(row["kd_per_m"]) == kd_per_m


def test_the_two_water_tables_disagree_as_their_sources_do():
    # Beam attenuation of type III at 525 nm: 0.37 1/m in one table, 1.11 1/m in the other (two digits).
    found = [
        float(np.interp(525.0, profile.wavelength_nm, profile.attenuation_per_m))
        for profile in (
            spectra.water_profile("III", "solonenko-mobley"),
            spectra.water_profile("III", "measured"),
        )
    ]
    assert sorted(found) == pytest.approx([0.37, 1.11], abs=0.005)


def test_measured_waters_of_the_library_are_those_of_the_data_set():
    # The data set's spreadsheet, kept here as it was read: the library must hold the same numbers.
    path = Path(__file__).parents[1] / "reference" / "jerlov_iop_measured.csv"
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    for water in sorted({row["water_type"] for row in rows}):
        mine = [row for row in rows if row["water_type"] == water]
        profile = spectra.water_profile(water, "measured")
        assert profile.a_per_m is not None and profile.b_per_m is not None
        assert profile.wavelength_nm.tolist() == [float(row["wavelength_nm"]) for row in mine]
        assert profile.a_per_m.tolist() == [float(row["a_per_m"]) for row in mine]
        assert profile.b_per_m.tolist() == [float(row["b_per_m"]) for row in mine]


def test_photopic_curve_peaks_at_555_and_sums_to_the_standard():
    rows = rows_of("photopic_v.csv")
    assert float(row_of("photopic_v.csv", wavelength_nm="555")["V"]) == 1.0
    # CIE 018: the sum over 360-830 nm at 1 nm is 106.857 (six digits)
    assert sum(float(row["V"]) for row in rows) == pytest.approx(106.857, abs=5e-4)


@pytest.mark.parametrize(("material", "wavelength_um", "index"), [
    ("n_bk7", 0.5875618, 1.5168),  # SCHOTT catalogue, n_d
    ("fused_silica", 0.5875618, 1.45846),  # Malitson 1965, n_d
])  # fmt: skip
def test_sellmeier_coefficients_give_the_catalogue_index(material: str, wavelength_um: float, index: float):
    rows = [row for row in rows_of("refractive_index_coefficients.csv") if row["material"] == material]
    c = [float(row["coefficient"]) for row in sorted(rows, key=lambda row: int(row["index"]))]
    power = 2 if rows[0]["formula"] == "sellmeier_1" else 1
    square = wavelength_um**2
    n2 = 1 + c[0] + sum(c[i] * square / (square - c[i + 1] ** power) for i in range(1, len(c), 2))
    assert math.sqrt(n2) == pytest.approx(index, abs=1e-5)  # last printed digit


@pytest.mark.parametrize("light", ["flood", "spot"])
def test_beam_profile_integrates_to_its_output_factor(light: str):
    # Phi = 2 pi * integral of I(theta) sin(theta); 7030 and 4684 lm by the source's own integration of the
    # full profile, of which ours keeps every fifth degree beyond 50 deg: 2 %.
    row = row_of("lights.csv", id=f"deepsea-power-light-led-sealite-lsl-{light}")
    profile = [r for r in rows_of("beam_profiles.csv") if r["profile_id"] == f"dspl-sealite-{light}"]
    angle_rad = np.radians([float(r["angle_deg"]) for r in profile])
    intensity_cd = float(row["peak_candela"]) * np.array([float(r["intensity"]) for r in profile])
    flux_lm = 2 * math.pi * np.trapezoid(intensity_cd * np.sin(angle_rad), angle_rad)
    assert flux_lm == pytest.approx(float(row["output_factor"]) * float(row["flux_lm"]), rel=0.02)


def test_a_plotted_beam_falls_to_half_at_half_its_angle():
    # Read off the manual's plot: 50 % at 33 deg, 25 % at 41 deg.
    profile = [row for row in rows_of("beam_profiles.csv") if row["profile_id"] == "subc-aquorea-mk3"]
    angle_deg = [float(row["angle_deg"]) for row in profile]
    at = np.interp([33.0, 41.0], angle_deg, [float(row["intensity"]) for row in profile])
    assert at == pytest.approx([0.5, 0.25], abs=0.02)
    assert float(row_of("lights.csv", id="subc-aquorea-mk3")["beam_angle_deg"]) == pytest.approx(2 * 33, abs=2)


def test_qe_curves_hold_the_tools_points_and_its_peaks():
    rows = rows_of("qe_curves.csv")
    assert sum(row["curve_id"].startswith("seed-") for row in rows) == SEED_CURVE_POINTS
    # Peaks of the tool's sensor files, read off them to three digits.
    peaks = {
        "seed-icx285alm": ("mono", 0.534, 496),
        "seed-imx249m": ("mono", 0.816, 502),
        "seed-imx250m": ("mono", 0.730, 527),
        "seed-imx252m": ("mono", 0.739, 525),
        "seed-imx250c": ("green", 0.681, 535),
        "seed-imx264c": ("green", 0.671, 538),
        "seed-imx178m": ("mono", 0.811, 485),
    }
    for curve_id, (channel, peak, at_nm) in peaks.items():
        points = [
            (float(row["qe"]), float(row["wavelength_nm"]))
            for row in rows
            if row["curve_id"] == curve_id and row["channel"] == channel
        ]
        assert max(points) == (pytest.approx(peak, abs=6e-4), pytest.approx(at_nm, abs=0.6)), curve_id


def test_curves_increase_in_wavelength_and_stay_physical():
    groups: dict[tuple[str, str], list[dict[str, str]]] = {}
    for row in rows_of("qe_curves.csv"):
        groups.setdefault((row["curve_id"], row["channel"]), []).append(row)
    for name, rows in groups.items():
        wavelengths_nm = [float(row["wavelength_nm"]) for row in rows]
        assert all(a < b for a, b in pairwise(wavelengths_nm)), name
        assert all(0 <= float(row["qe"]) <= 1 for row in rows), name


def test_filled_curve_closes_the_gap_of_the_red_channel():
    red = [r for r in rows_of("qe_curves.csv") if r["curve_id"] == "imx264c-filled" and r["channel"] == "red"]
    visible_nm = [float(row["wavelength_nm"]) for row in red if 400 <= float(row["wavelength_nm"]) <= 700]
    assert max(np.diff(visible_nm)) < 20  # the digitised curve has none between 600 and 659 nm


def test_every_estimate_has_a_range_a_unit_and_a_basis():
    rows = rows_of("class_estimates.csv")
    assert len({row["key"] for row in rows}) == len(rows)
    for row in rows:
        assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)+", row["key"]), row["key"]
        assert row["key"].startswith(f"{row['applies_to']}-{row['field'].replace('_', '-')}-"), row["key"]
        assert float(row["low"]) <= float(row["central"]) <= float(row["high"]), row["key"]
        assert row["basis"] and row["unit"] and row["class_rule"] and row["source_url"], row["key"]
        money = {"price", "price_scale", "flux_lm_per_price", "host_price", "price_work", "price_per_kg"}
        priced = row["field"] in money
        assert bool(row["currency"]) == priced, row["key"]
        assert row["at_nm"] or row["field"] != "qe", row["key"]


def test_depth_ratings_are_never_estimated():
    assert not any(row["field"] == "depth_rating_m" for row in rows_of("class_estimates.csv"))


# Relations as stated by their sources (central, low, high).
ESTIMATES = [
    ("light-efficacy-lm-per-w-led", 100, 34, 140),
    ("light-efficacy-lm-per-w-pulsed-led", 42, 19, 94),
    ("light-output-factor-nameplate", 0.70, 0.47, 1.0),
    ("light-flux-lm-per-price-to-150m", 13.8, 12.2, 15.7),
    ("light-colour-temperature-k-led", 5700, 5000, 6200),
    ("lens-transmission-frac-any", 0.90, 0.80, 0.94),
    ("camera-price-scale-any", 438, 311, 613),  # 438 x 0.71 and x 1.4
    ("camera-max-gain-db-any", 37.5, 27, 48),
    ("camera-read-noise-e-family-cmv-5-5", 13, 10.4, 15.6),  # 13 e-, x 0.8 and x 1.2
    ("camera-saturation-e-family-cmv-5-5", 13500, 12555, 14445),  # 13.5 ke-, x 0.93 and x 1.07
    ("camera-dark-current-e-s-family-cmv-5-5", 125, 25, 619),  # 125 x 2^(-15/6.5) and x 2^(15/6.5)
    ("camera-read-noise-e-family-python-4-8", 9.6, 7, 13.3),  # (7 x 13.3)^(1/2) = 9.65
    ("port-thickness-over-outer-radius-deep-glass-sphere", 0.076, 0.058, 0.078),
    ("port-price-small-window", 64, 59, 69),
]


@pytest.mark.parametrize(("key", "central", "low", "high"), ESTIMATES)
def test_estimate_equals_the_stated_relation(key: str, central: float, low: float, high: float):
    row = row_of("class_estimates.csv", key=key)
    assert [float(row[name]) for name in ("central", "low", "high")] == [central, low, high]


def test_class_median_of_a_chip_equals_a_count_by_hand():
    # IMX250 read noise: 2.44, 2.38, 2.45 (FLIR), 2.1 (Allied Vision), 2.15 (Lucid); the middle one is 2.38.
    row = row_of("class_estimates.csv", key="camera-read-noise-e-chip-imx250")
    assert [float(row[name]) for name in ("central", "low", "high")] == [2.38, 2.1, 2.45]

"""The built-in data files as files: form, spelling, ranges, and no row lost.

Numbers of rows are those of the gathered source tables.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from pathlib import Path

import pytest

import uwopt.catalog
from uwopt.catalog.edition import AS_OF

DATA_DIR = Path(uwopt.catalog.__file__).parent / "data"
PART_FILES = ("cameras.csv", "lenses.csv", "lights.csv", "ports.csv", "housings.csv")
ALL_FILES = sorted(path.name for path in DATA_DIR.glob("*.csv"))

# Rows of the gathered tables; cameras: 103 products and the 7 sensor files of the paper's tool, then those of the
# second gathering (40 cameras, 8 lenses, 70 ports of which one, Nauticam's item 18811, was there already).
ROWS = {
    "cameras.csv": 103 + 7 + 40,
    "lenses.csv": 242 + 8 + 1,
    "lights.csv": 43 + 3 + 27 + 1,  # options of a strobe; those of the second gathering; a lamp by its manual
    "ports.csv": 38 + 69,
    "housings.csv": 10 + 6 + 2,  # the 3 in and 5 in series of the third gathering; two more lengths
    "jerlov_iop.csv": 170,
    "pure_water.csv": 91,
    "photopic_v.csv": 471,
    "light_spectra.csv": 2996,
    "bottom_reflectance.csv": 2271,
    "refractive_index_coefficients.csv": 63,
    "port_internal_transmittance.csv": 116,
    "beam_profiles.csv": 2 * 109 + 19,  # flood and spot, one below the other; every 2.5 deg to 45 deg
    "seafloor_flat.csv": 5,
}

# Allowed range of every number column of the parts files, both ends included.
RANGES = {
    "resolution_x_px": (500, 20000),
    "resolution_y_px": (400, 20000),
    "pixel_pitch_um": (1.0, 10.0),
    "max_frame_rate_hz": (1, 1000),
    "bit_depth": (8, 16),
    "read_noise_e": (0.5, 20),
    "saturation_e": (5000, 60000),
    "snr_max_db": (35, 50),
    "dynamic_range_db": (60, 80),
    "dark_current_e_s": (0, 100),
    "gain_dn_per_e": (0.1, 10),
    "gain_bits": (8, 16),
    "max_gain_db": (20, 60),
    "black_level_dn": (0, 1000),
    "min_exposure_us": (1, 100),
    "max_exposure_us": (1e6, 1e8),
    "exposure_offset_us": (0, 100),
    "qe": (0.3, 0.96),
    "qe_nm": (450, 600),
    "power_w": (0.5, 400),
    "mean_power_w": (1, 100),
    "mass_g": (10, 20000),
    "mass_water_g": (10, 1000),
    "focal_length_mm": (1, 100),
    "f_number_min": (1.0, 5.0),
    "f_number_max": (2.0, 32.0),
    "image_circle_mm": (4, 45),
    "transmission_frac": (0.5, 1.0),
    "rated_megapixel": (1, 50),
    "rated_pixel_pitch_um": (1.5, 7),
    "rated_lp_per_mm": (50, 300),
    "min_object_distance_m": (0.05, 1.0),
    "distortion_pct": (-100, 10),
    "length_mm": (10, 200),
    "diameter_mm": (20, 100),
    "flux_lm": (100, 50000),
    "output_factor": (0.3, 1.0),
    "beam_angle_deg": (1, 180),
    "peak_candela": (1000, 50000),
    "dim_step_count": (2, 20),
    "min_pulse_us": (10, 10000),
    "max_pulse_us": (100, 100000),
    "max_duty_frac": (0, 1),
    "max_rate_hz": (0.1, 1000),
    "flash_energy_j": (5, 500),
    "flash_duration_us": (100, 10000),
    "recycle_s": (0.1, 20),
    "guide_number_m": (5, 50),
    "colour_temperature_k": (2500, 10000),
    "cri": (50, 100),
    "depth_rating_m": (4, 15000),
    "rated_time_h": (24, 8760),
    "supply_v_min": (5, 250),
    "supply_v_max": (5, 250),
    "run_time_min": (10, 1000),
    "refractive_index": (1.4, 1.8),
    "outer_radius_mm": (20, 400),
    "outer_radius_low_mm": (20, 400),
    "outer_radius_high_mm": (20, 400),
    "thickness_mm": (1, 100),
    "clear_diameter_mm": (20, 500),
    "nominal_diameter_mm": (20, 600),
    "inner_diameter_mm": (20, 500),
    "inner_length_mm": (50, 1000),
    "wall_mm": (2, 30),
    "outer_diameter_mm": (40, 600),
    "outer_length_mm": (100, 1200),
    "penetrators": (1, 40),
    "price": (10, 40000),
    "price_low": (10, 40000),
    "price_high": (10, 40000),
}
UNIT_ENDINGS = (
    "_px", "_um", "_nm", "_hz", "_e", "_db", "_e_s", "_dn", "_per_e", "_us", "_s", "_w", "_g", "_in", "_mm",
    "_m", "_frac", "_pct", "_lm", "_deg", "_candela", "_k", "_j", "_v_min", "_v_max", "_bits", "_per_mm", "_min",
    "_h",
)  # fmt: skip
PLAIN_NUMBERS = {
    "bit_depth", "qe", "f_number_min", "f_number_max", "rated_megapixel", "output_factor", "dim_step_count",
    "cri", "refractive_index", "price", "price_low", "price_high", "penetrators",
}  # fmt: skip
CHOICES = {
    "availability": {"current", "discontinued", "not_a_product", "unknown"},
    "colour": {"mono", "colour", ""},
    "shutter": {"global", "rolling", ""},
    "interface": {
        "USB3", "GigE", "2.5GigE", "5GigE", "10GigE", "CSI-2", "Camera Link", "Ethernet RTSP", "coax", "",
    },
    "perf_quality": {"A", "B", "C", "D", "E", ""},
    "aperture_control": {"manual", "motorised", "fixed", "unknown"},
    "is_zoom": {"yes", "no"},
    "kind": {"continuous", "pulsed_led", "flash"},
    "beam": {"cosine-power", "tabulated", ""},
    "beam_medium": {"air", "water", "not stated", ""},
    "supply": {"external", "battery", "unknown"},
    "trigger": {"electrical", "optical", "none", "unknown", ""},
    "geometry": {"flat", "dome", ""},
    "purpose": {
        "camera port", "photo port", "sealed float", "laboratory window", "display dome", "lamp window",
        "part of a camera", "detector vessel", "one-off", "vehicle lamp", "video light", "photo strobe",
        "dive torch", "industrial camera", "board camera", "astronomy camera", "complete camera", "values of a tool",
    },
    "material": {"acrylic", "polycarbonate", "glass", "sapphire", "fused silica", "aluminium", ""},
    "shape": {"tube", "sphere"},
    "currency": {"USD", "EUR", "GBP", "CHF", "JPY", "AUD", ""},
    "price_status": {"quoted", "derived", "estimated", ""},
}  # fmt: skip


def rows_of(file: str) -> list[dict[str, str]]:
    with (DATA_DIR / file).open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def part_rows() -> list[tuple[str, dict[str, str]]]:
    return [(file, row) for file in PART_FILES for row in rows_of(file)]


@pytest.mark.parametrize("file", ALL_FILES)
def test_file_has_comments_then_one_header_and_full_rows(file: str):
    lines = (DATA_DIR / file).read_text(encoding="utf-8").splitlines()
    n_comments = next(n for n, line in enumerate(lines) if not line.startswith("#"))
    assert n_comments >= 1, "a file says on top what it holds"
    assert not any(line.startswith("#") for line in lines[n_comments:])
    header, *rows = list(csv.reader(lines[n_comments:]))
    assert all(header) and len(set(header)) == len(header)
    assert rows and all(len(row) == len(header) for row in rows)
    assert all(cell == cell.strip() for row in rows for cell in row)


@pytest.mark.parametrize("file", ALL_FILES)
def test_file_names_no_path_of_a_machine(file: str):
    text = (DATA_DIR / file).read_text(encoding="utf-8")
    assert not re.search(r"(?<![\w.:/-])/(work|tmp|home|root|usr|var)/|\bpypi\b", text, re.IGNORECASE)


@pytest.mark.parametrize(("file", "n_rows"), ROWS.items())
def test_no_row_of_the_source_is_lost(file: str, n_rows: int):
    assert len(rows_of(file)) == n_rows


def test_part_ids_are_unique_over_all_kinds_and_well_formed():
    ids = [row["id"] for _, row in part_rows()]
    assert [name for name, count in Counter(ids).items() if count > 1] == []
    assert [name for name in ids if not re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)+", name)] == []


def test_seven_rows_carry_the_papers_sensors():
    seeds = {row["id"] for row in rows_of("cameras.csv") if row["availability"] == "not_a_product"}
    names = ("icx285alm", "imx178m", "imx249m", "imx250m", "imx250c", "imx252m", "imx264c")
    assert seeds == {f"seed-{name}" for name in names}


def test_every_number_is_bare_and_in_range():
    faults = []
    for file, row in part_rows():
        for name, (low, high) in RANGES.items():
            text = row.get(name, "")
            if text and not low <= float(text) <= high:
                faults.append((file, row["id"], name, text))
    assert faults == []


@pytest.mark.parametrize("file", PART_FILES)
def test_number_columns_carry_their_unit_in_the_header(file: str):
    rows = rows_of(file)
    numeric = set(rows[0]) & set(RANGES)
    assert {name for name in numeric if not name.endswith(UNIT_ENDINGS)} <= PLAIN_NUMBERS
    text_columns = set(rows[0]) - set(RANGES)
    numbers = re.compile(r"-?\d+(\.\d+)?")
    for name in text_columns - {"optical_format_in", "price_date", "dim_levels", "model"}:
        assert not any(numbers.fullmatch(row[name]) for row in rows), name


def test_words_have_one_spelling():
    faults = [
        (file, row["id"], name, row[name])
        for file, row in part_rows()
        for name, allowed in CHOICES.items()
        if name in row and row[name] not in allowed
    ]
    assert faults == []
    mounts = {mount for _, row in part_rows() for mount in row.get("mounts", "").split("|")}
    assert mounts == {"C", "CS", "S", ""}
    makers = Counter(row["manufacturer"].casefold() for _, row in part_rows())
    assert len(makers) == len({row["manufacturer"] for _, row in part_rows()})


def test_every_row_keeps_its_source_maker_and_model():
    faults = [
        row["id"]
        for _, row in part_rows()
        if not (row["source_url"] and row["manufacturer"] and row["model"] and row["availability"])
    ]
    assert faults == []


def test_every_price_has_a_currency_and_a_status():
    for _, row in part_rows():
        priced = bool(row["price"])
        assert bool(row["currency"]) == bool(row["price_status"]) == priced, row["id"]
        if row["price_low"]:
            assert float(row["price_low"]) <= float(row["price"]) <= float(row["price_high"]), row["id"]
        assert re.fullmatch(r"(20\d\d(-\d\d){0,2})?", row["price_date"]), row["id"]


def test_every_currency_has_a_rate_and_no_price_is_dated_after_the_catalogue():
    rates = {row["currency"] for row in rows_of("exchange_rates.csv")} | {"USD"}
    for _, row in part_rows():
        assert not row["currency"] or row["currency"] in rates, row["id"]
        assert row["price_date"] <= AS_OF, row["id"]


def test_walls_are_half_of_what_the_diameters_of_a_tube_differ_by_or_less():
    for row in rows_of("housings.csv"):
        if row["wall_mm"] and row["outer_diameter_mm"]:
            room = float(row["outer_diameter_mm"]) - float(row["inner_diameter_mm"])
            assert 2.0 * float(row["wall_mm"]) <= room, row["id"]


def test_a_quote_of_2024_or_later_means_that_the_part_is_sold():
    for _, row in part_rows():
        if row["availability"] == "unknown":
            assert not (row["price"] and row["price_date"][:4] >= "2024"), row["id"]


def test_hobby_figures_never_pair_noise_and_well():
    # ZWO quotes noise at high gain and well at lowest gain: not one operating point.
    graded = [row for row in rows_of("cameras.csv") if row["perf_quality"] == "D"]
    assert len(graded) == 7
    assert all(not row["read_noise_e"] and not row["saturation_e"] and row["correction"] for row in graded)


def test_ports_that_are_no_product_say_why():
    assert all(
        len(row["note"]) > 20 for row in rows_of("ports.csv") if row["availability"] == "not_a_product"
    )


def test_only_what_a_camera_can_stand_behind_is_a_product():
    serves = {"camera port", "photo port", "laboratory window", "display dome"}
    for row in rows_of("ports.csv"):
        assert (row["purpose"] in serves) == (row["availability"] != "not_a_product"), row["id"]


def test_every_port_of_a_photo_housing_names_a_known_mount():
    mounts = {row["mount"]: row for row in rows_of("port_mounts.csv")}
    assert all(row["on"] in {"photo housing", "chamber", "tube series"} for row in mounts.values())
    assert {row["free"] for row in mounts.values() if row["on"] != "tube series"} == {"no"}
    used = {row["mount"] for row in rows_of("ports.csv")}
    assert used - {""} == set(mounts)
    for row in rows_of("ports.csv"):
        on = mounts[row["mount"]]["on"] if row["mount"] else ""
        assert (row["purpose"] == "photo port") == (on == "photo housing"), row["id"]


def test_no_item_of_a_maker_stands_twice():
    models = Counter(
        (file, row["manufacturer"], re.sub(r"[^a-z0-9]", "", row["model"].casefold()))
        for file, row in part_rows()
        if not row["id"].startswith("seed-")
    )
    assert [model for model, count in models.items() if count > 1] == []
    items = Counter(match for row in rows_of("ports.csv") for match in re.findall(r"^(\d{5}) ", row["model"]))
    assert [item for item, count in items.items() if count > 1] == []


def test_glasses_profiles_and_curves_that_rows_name_exist():
    glasses = {row["material"] for row in rows_of("refractive_index_coefficients.csv")}
    assert {row["glass"] for row in rows_of("ports.csv")} - {""} <= glasses
    profiles = {row["profile_id"] for row in rows_of("beam_profiles.csv")}
    assert {row["beam_profile"] for row in rows_of("lights.csv")} - {""} == profiles
    curves = {row["curve_id"] for row in rows_of("qe_curves.csv")}
    assert {row["qe_curve"] for row in rows_of("cameras.csv")} - {""} <= curves
    families = rows_of("qe_families.csv")
    assert {row["mono_curve"] for row in families} | {row["colour_curve"] for row in families} <= curves
    assert {row["chip"] or "any" for row in rows_of("cameras.csv")} <= {row["chip"] for row in families}

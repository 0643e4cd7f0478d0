"""What is declared of a part's field, and what files, inline records, checks and columns make of it."""

import csv
import io
from dataclasses import replace
from typing import Annotated, ClassVar

import numpy as np
import pytest
from pydantic import ValidationError
from pydantic.dataclasses import dataclass

from uwopt.catalog.checkfile import template
from uwopt.catalog.columns import COLUMNS, CellError, column_of, parse_cell
from uwopt.catalog.inline import part_from_inline
from uwopt.catalog.load import read_catalog
from uwopt.catalog.parts.camera import Camera
from uwopt.catalog.parts.cell import FROM_ZERO, POSITIVE, Cell, Inline, Range, beyond, fields_of, kept_fields
from uwopt.catalog.parts.kinds import EITHER, FAVOURED, ORDERED_PAIRS
from uwopt.catalog.parts.light import Light
from uwopt.catalog.parts.part import Part
from uwopt.catalog.parts.quantity import Quantity
from uwopt.catalog.readers.reading import inline_fields, row_fields
from uwopt.catalog.records import exact
from uwopt.catalog.tables import DATA_DIR
from uwopt.catalog.userparts import PartRow
from uwopt.errors import CatalogError
from uwopt.forward.part_rows import columns_of, in_si


@dataclass(frozen=True, slots=True)
class Probe(Part):
    """A kind with one field of each sort, as a new one would declare them."""

    read_noise_e: Annotated[Quantity | None, Cell("noise", FROM_ZERO, unknown=7.0)] = None
    standby_power_w: Annotated[float | None, Cell("power", POSITIVE, at_most="peak_w")] = None
    count: Annotated[int, Cell("pieces", Range(1.0, 9.0), inline="never")] = 1
    size_mm: Annotated[
        Quantity | None, Cell(inline=Inline(estimate=Quantity(2.0, 1.0, 3.0, "estimated")))
    ] = None
    hint: ClassVar[Annotated[str, Cell("stated in files only")]]


def probe_row(**cells):
    return PartRow("camera", "probes.csv row 2", {"id": "probe", **cells})


def declared(name, record=Probe):
    return next(field for field in fields_of(record) if field.name == name)


def class_row(key):
    with (DATA_DIR / "class_estimates.csv").open(encoding="utf-8") as lines:
        rows = csv.DictReader(line for line in lines if not line.startswith("#"))
        return next(row for row in rows if row["key"] == key)


def own_camera(folder, **cells):
    row = {
        "id": "own-cam", "resolution_x_px": "1000", "resolution_y_px": "800", "pixel_pitch_um": "5",
        "colour": "mono", "shutter": "global", "mounts": "C", **cells,
    }  # fmt: skip
    text = io.StringIO()
    writer = csv.DictWriter(text, row)
    writer.writeheader()
    writer.writerow(row)
    (folder / "cameras.csv").write_text(text.getvalue())
    return read_catalog([folder / "cameras.csv"]).part("own-cam")


# ---------------------------------------------------------------- a field and what follows from it


def test_a_field_that_only_files_state_is_not_kept():
    assert "hint" in [field.name for field in fields_of(Probe)]
    assert "hint" not in [field.name for field in kept_fields(Probe)]


def test_the_type_of_a_field_tells_the_form_of_its_column():
    forms = {
        name: column_of(declared(name)).form for name in ("read_noise_e", "count", "hint", "availability")
    }
    assert forms == {"read_noise_e": "number", "count": "number", "hint": "text", "availability": "choice"}
    assert column_of(declared("count")).whole


def test_a_row_gives_a_number_with_its_origin():
    made = row_fields(Probe, probe_row(read_noise_e=3.0, count=4.0), "user", ("any",))
    assert (made["read_noise_e"], made["count"]) == (exact(3.0, "user"), 4)
    assert "standby_power_w" not in made


def test_a_silent_row_takes_the_first_class_that_has_an_estimate():
    made = row_fields(Probe, probe_row(), "user", ("chip-none", "family-og05c", "any"))
    row = class_row("camera-read-noise-e-family-og05c")
    expected = tuple(float(row[name]) for name in ("central", "low", "high"))
    assert (made["read_noise_e"].value, made["read_noise_e"].low, made["read_noise_e"].high) == expected
    assert made["read_noise_e"].status == "estimated"


def test_an_inline_record_takes_no_estimate_but_its_own():
    made = inline_fields(Probe, "camera", {"currency": "eur"})
    assert (made["read_noise_e"], made["size_mm"].value, made["currency"]) == (None, 2.0, "EUR")
    assert (made["id"], made["inline"]) == ("inline-camera", True)


def test_what_an_inline_record_never_states_is_left_to_the_record():
    assert "count" not in inline_fields(Probe, "camera", {"currency": "USD", "count": 5})


def test_what_is_unknown_stands_in_the_columns_as_declared():
    known = columns_of(
        Probe, [Probe("a"), Probe("b", read_noise_e=exact(2.0), size_mm=exact(5.0))], "central"
    )
    assert known["read_noise_e"].tolist() == [7.0, 2.0]
    np.testing.assert_allclose(known["size_m"], [0.0, 5e-3])  # mm to m


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("min_pulse_us", ("min_pulse_s", 1e-6)),
        ("mass_g", ("mass_kg", 1e-3)),
        ("gap_mm", ("gap_m", 1e-3)),
        ("recycle_s", ("recycle_s", 1.0)),
        ("output_factor", ("output_factor", 1.0)),
    ],
)
def test_names_of_columns_carry_the_unit_of_their_numbers(name, expected):
    assert in_si(name) == expected


def test_a_record_takes_a_bare_number_for_one_without_doubt():
    assert Light("a", max_duty_frac=0.5).max_duty_frac == exact(0.5)


def test_a_record_refuses_what_is_of_another_type():
    with pytest.raises(ValidationError, match="shutter"):
        replace(Camera("a"), shutter="slow")


# ---------------------------------------------------------------- ranges


@pytest.mark.parametrize(
    ("within", "held", "not_held", "words"),
    [
        (Range(0.0, 1.0), (0.0, 1.0), (-1e-9, 1.0 + 1e-9), "at least 0 and at most 1"),
        (Range(0.0, 1.0, open_low=True), (1e-12, 1.0), (0.0, 2.0), "above 0 and at most 1"),
        (Range(0.0, 90.0, True, True), (1e-12, 89.9), (0.0, 90.0), "above 0 and below 90"),
        (Range(), (-1e30, 1e30), (), ""),
    ],
)
def test_a_range_holds_its_ends_unless_they_are_open(within, held, not_held, words):
    assert all(within.holds(value) for value in held)
    assert not any(within.holds(value) for value in not_held)
    assert within.words() == words


def test_a_number_that_no_part_has_is_told_on_either_side():
    assert [beyond(v, (0.05, 100.0)) for v in (0.04, 0.05, 0.0, 100.0)] == ["is below 0.05", "", "", ""]
    assert beyond(101.0, (0.05, 100.0)) == "is above 100"


def test_zero_may_stand_for_next_to_nothing_inline_but_not_in_a_file():
    light = {"flux_lm": 1000, "power_w": 0, "beam_half_angle_deg": 40, "min_pulse_us": 0}
    assert part_from_inline("light", light).power_w == exact(0.0, "user", "system file")
    with pytest.raises(CellError, match="above 0"):
        parse_cell(COLUMNS["light"]["power_w"], "0")
    with pytest.raises(CatalogError, match="flux_lm"):
        part_from_inline("light", {**light, "flux_lm": 0})


def test_an_inline_number_that_no_part_has_is_refused():
    with pytest.raises(CatalogError, match=r"focal_length_mm is below 0.05, as none is made"):
        part_from_inline("lens", {"focal_length_mm": 0.008})


# ---------------------------------------------------------------- tables that hold for all kinds


def test_each_estimate_that_enters_a_figure_favours_the_right_end():
    # By the physics: what costs, weighs, draws, adds noise or holds up harms; what transmits, stores or extends helps.
    less = {
        "price", "mass_g", "power_w", "read_noise_e", "dark_current_e_s", "prnu_frac", "min_exposure_us",
        "min_object_distance_m", "recycle_s", "min_pulse_us", "f_number_min", "thickness_mm", "flash_duration_us",
        "beam_angle_deg", "warm_up_s", "wake_up_s", "standby_w", "host_power_w",
        "host_price", "aberration_pitch_um", "body_width_mm", "body_height_mm", "body_length_mm", "plug_mm",
        "length_mm", "diameter_mm", "min_interval_s", "flash_duration_at_frac",
    }  # fmt: skip
    more = {
        "saturation_e", "qe_scale", "max_frame_rate_hz", "bandwidth_mb_s", "max_gain_db", "max_exposure_us",
        "exposure_offset_us", "transmission_frac", "f_number_max", "flux_lm", "output_factor", "max_pulse_us",
        "max_duty_frac", "max_rate_hz", "flash_energy_j", "flash_efficacy_lm_s_per_j", "charging_efficiency_frac",
        "refractive_index", "clear_diameter_mm", "thread_travel_mm", "max_magnification",
    }  # fmt: skip
    assert {"outer_radius_mm"} == EITHER  # a large dome is easier to focus through, a small one nearer to the floor
    assert {name for name, sign in FAVOURED.items() if sign == -1} == less
    assert {name for name, sign in FAVOURED.items() if sign == +1} == more


def test_ends_of_a_range_are_compared_in_files():
    assert set(ORDERED_PAIRS) == {
        ("f_number_min", "f_number_max"), ("min_exposure_us", "max_exposure_us"), ("min_pulse_us", "max_pulse_us"),
        ("price_low", "price"), ("price", "price_high"), ("mass_low_g", "mass_g"), ("mass_g", "mass_high_g"),
        ("supply_v_min", "supply_v_max"), ("thickness_mm", "outer_radius_mm"),
        ("outer_radius_low_mm", "outer_radius_high_mm"),
    }  # fmt: skip


@pytest.mark.parametrize("kind", list(COLUMNS))
def test_a_template_names_each_column_once_with_what_may_stand_there(kind):
    lines = template(kind).splitlines()
    header = next(line for line in lines if not line.startswith("#")).split(",")
    assert sorted(header) == sorted(set(COLUMNS[kind]) - {"part", "correction"})
    assert all(any(line.startswith(f"# {name}: ") for line in lines) for name in header)


# ---------------------------------------------------------------- cameras: figures by class


def test_a_camera_takes_the_power_of_its_interface_before_that_of_any(tmp_path):
    power = own_camera(tmp_path, interface="USB3").power_w
    assert power.value == float(class_row("camera-power-w-usb3")["central"])
    assert power.value != float(class_row("camera-power-w-any")["central"])


def test_a_camera_takes_the_noise_of_its_chip_before_that_of_any(tmp_path):
    noise = own_camera(tmp_path, chip="IMX174", interface="USB3").read_noise_e
    assert noise.value == float(class_row("camera-read-noise-e-chip-imx174")["central"])


def test_saturation_follows_from_the_best_signal_to_noise_ratio(tmp_path):
    # shot noise: SNR^2 = electrons, 40 dB = 10^(40 / 10) = 10 000 electrons (EMVA 1288)
    assert own_camera(tmp_path, snr_max_db="40").saturation_e.value == pytest.approx(10_000)
    assert own_camera(tmp_path, snr_max_db="40", saturation_e="9000").saturation_e.value == 9000


def test_a_camera_without_a_rate_sends_what_its_interface_carries(tmp_path):
    # 100 * 10^6 byte/s over 1000 * 800 pixels of 10 bit = 10^6 byte: 100 images a second
    camera = own_camera(tmp_path, bandwidth_mb_s="100", bit_depth="10")
    assert camera.max_frame_rate_hz.value == pytest.approx(100.0)
    assert own_camera(tmp_path, bandwidth_mb_s="100", max_frame_rate_hz="20").max_frame_rate_hz.value == 20.0


def test_columns_stand_at_the_end_that_favours_or_harms_a_design():
    # less power favours, more saturation favours
    camera = Camera("a", power_w=Quantity(3.0, 2.0, 5.0), saturation_e=Quantity(1e4, 8e3, 1.2e4))
    ends = {end: columns_of(Camera, [camera], end) for end in ("central", "good", "bad")}
    assert [ends[end]["power_w"][0] for end in ends] == [3.0, 2.0, 5.0]
    assert [ends[end]["saturation_e"][0] for end in ends] == [1e4, 1.2e4, 8e3]

"""Columns of hardware: units, what the sensor's numbers mean, ends of estimates, light that a file measures."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from uwopt.catalog.load import read_catalog
from uwopt.catalog.parts.camera import Camera
from uwopt.catalog.parts.lens import Lens
from uwopt.catalog.parts.light import Light
from uwopt.catalog.parts.part import Part
from uwopt.catalog.parts.port import Port
from uwopt.catalog.parts.quantity import Curve, Quantity
from uwopt.forward.part_columns import End
from uwopt.forward.part_rows import camera_rows, lens_rows, light_rows, port_rows

SPREAD = Quantity(3.0, 2.0, 5.0, "estimated")
BETTER_LOW, BETTER_HIGH = (2.0, 5.0), (5.0, 2.0)  # good end, bad end


def in_dollars(amount: float, _currency: str) -> float:
    return amount


def rows_of(part: Part, *, end: End = "central", **more: Any) -> Any:
    """Columns of one part."""
    if isinstance(part, Camera):
        return camera_rows([part], money=in_dollars, end=end, **more)[0]
    if isinstance(part, Lens):
        return lens_rows([part], money=in_dollars, end=end, **more)
    if isinstance(part, Port):
        return port_rows([part], money=in_dollars, glass_index=lambda _: 1.5, end=end, **more)
    assert isinstance(part, Light)
    return light_rows([part], money=in_dollars, optics_index=[0], end=end, **more)


CAMERA = dict(id="camera", resolution_x_px=1000, resolution_y_px=800, pixel_pitch_um=5.0, bit_depth=12)


def camera(**more: Any) -> Camera:
    return Camera(**{**CAMERA, **more})


# ---------------------------------------------------------------- ends of estimates


@pytest.mark.parametrize(
    ("make", "field", "column", "ends", "unit"),
    [
        (camera, "price", "price", BETTER_LOW, 1.0),
        (camera, "mass_g", "mass_kg", BETTER_LOW, 1e-3),
        (camera, "power_w", "power_w", BETTER_LOW, 1.0),
        (camera, "read_noise_e", "read_noise_e", BETTER_LOW, 1.0),
        (camera, "dark_current_e_s", "dark_current_e_s", BETTER_LOW, 1.0),
        (camera, "min_exposure_us", "min_exposure_s", BETTER_LOW, 1e-6),
        (camera, "max_exposure_us", "max_exposure_s", BETTER_HIGH, 1e-6),
        (camera, "saturation_e", "saturation_e", BETTER_HIGH, 1.0),
        (camera, "max_frame_rate_hz", "max_rate_hz", BETTER_HIGH, 1.0),
        (Lens, "f_number_min", "f_number_min", BETTER_LOW, 1.0),
        (Lens, "f_number_max", "f_number_max", BETTER_HIGH, 1.0),
        (Lens, "min_object_distance_m", "min_object_distance_m", BETTER_LOW, 1.0),
        (Port, "price", "price", BETTER_LOW, 1.0),
        (Light, "power_w", "full_power_w", BETTER_LOW, 1.0),
        (Light, "flux_lm", "full_light", BETTER_HIGH, 1.0),
        (Light, "max_pulse_us", "max_pulse_s", BETTER_HIGH, 1e-6),
        (Light, "min_pulse_us", "min_pulse_s", BETTER_LOW, 1e-6),
        (Light, "max_duty_frac", "max_duty", BETTER_HIGH, 1.0),
    ],
)
def test_good_end_of_an_estimate_favours_the_design_and_the_bad_one_does_not(
    make: Any, field: str, column: str, ends: tuple[float, float], unit: float
) -> None:
    part = make(**({} if make is camera else {"id": "part"}), **{field: SPREAD})
    found = [float(getattr(rows_of(part, end=end), column)[0]) for end in ("good", "central", "bad")]
    assert found == pytest.approx([ends[0] * unit, 3.0 * unit, ends[1] * unit], rel=1e-12)


def test_budget_counts_the_high_end_of_a_price_where_that_is_its_basis() -> None:
    central, high = rows_of(camera(price=SPREAD)), rows_of(camera(price=SPREAD), high_basis=True)
    assert (central.price[0], central.limit_price[0]) == (3.0, 3.0)
    assert (high.price[0], high.limit_price[0]) == (3.0, 5.0)


# ---------------------------------------------------------------- sensors


def test_gain_of_another_bit_depth_is_scaled() -> None:
    # 0.5 DN of 12 bit an electron: a quarter at 10 bit, 16 times at the 16 bit of physics `paper`
    part = camera(bit_depth=10, gain_dn_per_e=0.5, gain_bits=12)
    assert rows_of(part).gain_dn_per_e[0] == 0.125
    assert rows_of(part, paper=True).gain_dn_per_e[0] == 8.0


def test_unknown_gain_puts_full_scale_at_saturation() -> None:
    rows = rows_of(camera(saturation_e=Quantity(10_000.0, 1.0, 1.0), black_level_dn=95.0))
    assert rows.gain_dn_per_e[0] == pytest.approx((4095 - 95) / 10_000, rel=1e-12)


def test_rate_is_what_camera_and_interface_both_reach() -> None:
    # 1000 x 800 px of 12 bit are 1.2 MB: 6 MB/s carry 5 Hz
    slow = camera(max_frame_rate_hz=Quantity(20.0, 20.0, 20.0), bandwidth_mb_s=Quantity(6.0, 6.0, 6.0))
    assert rows_of(slow).max_rate_hz[0] == pytest.approx(5.0, rel=1e-12)


def test_rolling_shutter_reads_out_over_a_frame_and_a_global_one_at_once() -> None:
    rate = Quantity(20.0, 20.0, 20.0)
    assert rows_of(camera(shutter="rolling", max_frame_rate_hz=rate)).readout_s[0] == 0.05
    assert rows_of(camera(shutter="global", max_frame_rate_hz=rate)).readout_s[0] == 0.0


def test_paper_leaves_out_what_the_paper_leaves_out() -> None:
    part = camera(dark_current_e_s=SPREAD, prnu_frac=SPREAD, exposure_offset_us=SPREAD, black_level_dn=50.0)
    paper, full = rows_of(part, paper=True), rows_of(part)
    for name, value in (
        ("dark_current_e_s", 3.0), ("prnu_frac", 3.0), ("exposure_offset_s", 3e-6), ("black_level_dn", 50.0)
    ):  # fmt: skip
        assert (getattr(paper, name)[0], getattr(full, name)[0]) == (0.0, pytest.approx(value)), name


# ---------------------------------------------------------------- ports and lights


def test_clear_radius_is_half_of_the_clear_diameter() -> None:
    assert rows_of(Port(id="port", clear_diameter_mm=80.0)).clear_radius_m[0] == pytest.approx(0.040)
    assert np.isinf(rows_of(Port(id="port")).clear_radius_m[0])


def test_flash_gives_the_light_of_its_tube_and_takes_what_charging_loses() -> None:
    def sure(value: float) -> Quantity:
        return Quantity(value, value, value)

    flash = Light(
        id="flash", kind="flash", flash_energy_j=sure(20.0), flash_efficacy_lm_s_per_j=sure(30.0),
        charging_efficiency_frac=sure(0.8), recycle_s=sure(0.5), flash_duration_us=sure(1000.0),
    )  # fmt: skip
    rows = rows_of(flash)
    assert rows.full_light[0] == pytest.approx(20.0 * 30.0)
    assert rows.pulse_energy_j[0] == pytest.approx(20.0 / 0.8)
    assert rows.stored_energy_j[0] == 20.0
    assert rows.max_rate_hz[0] == pytest.approx(2.0)
    assert rows.full_power_w[0] == 0.0


def test_lamp_measured_in_candela_gives_the_lumens_of_its_profile() -> None:
    # I = 100 cos(t) cd over the hemisphere: pi * 100 lm, of 1000 lm nameplate
    angle = np.linspace(0.0, 90.0, 181)
    profile = Curve(tuple(angle), tuple(100.0 * np.cos(np.deg2rad(angle))))
    lamp = Light(
        id="lamp", flux_lm=Quantity(1000.0, 1000.0, 1000.0), beam="tabulated", beam_profile=profile,
        beam_profile_is_candela=True, output_factor=Quantity(0.9, 0.9, 0.9),
    )  # fmt: skip
    # 3e-5: chords of half a degree lie below the cosine
    assert rows_of(lamp).output_factor[0] == pytest.approx(np.pi * 100.0 / 1000.0, rel=3e-5)


@pytest.mark.parametrize(("lamp", "lumens"), [("flood", 7030.0), ("spot", 4684.0)])
def test_catalogue_lamps_give_the_lumens_that_were_measured(lamp: str, lumens: float) -> None:
    # The maker's photometric file, integrated by the source of the row; the nameplate says 10 000 lm
    part = read_catalog().part(f"deepsea-power-light-led-sealite-lsl-{lamp}", "light")
    rows = rows_of(part)
    assert float(rows.full_light[0] * rows.output_factor[0]) == pytest.approx(lumens, rel=1e-9)

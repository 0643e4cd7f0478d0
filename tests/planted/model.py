"""Planted defects of the physics: light, water, floor, port, lens, sensor."""

from __future__ import annotations

from planted.defect import Defect

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="electrons grow with the pitch, not its square",
        file="uwopt/model/sensor.py",
        old="return rate_per_m2_s * pixel_pitch_m**2 * exposure_s",
        new="return rate_per_m2_s * pixel_pitch_m * exposure_s",
        test="tests/model/test_sensor.py::test_one_photon_per_pixel_and_second_is_one_electron",
    ),
)

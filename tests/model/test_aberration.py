"""What lenses blur beside diffraction, from wide open down and from the axis out."""

from __future__ import annotations

import numpy as np
import pytest

from uwopt.model import aberration, sharpness

WIDE_OPEN, OF_RATING, OF_ABERRATIONS = 2.0, 3.0, 4.0  # f-number, twice in any one unit
F1 = aberration.aberration_at_f1(OF_ABERRATIONS, f_number_min=WIDE_OPEN)


@pytest.mark.parametrize(
    ("f_number", "pitch_um"),
    [
        (2.0, 5.0),  # sqrt(3^2 + 4^2)
        (4.0, np.sqrt(11.0)),  # two stops: 16 / 2^3 = 2, sqrt(9 + 2)
        (8.0, np.sqrt(9.25)),  # four stops: 16 / 4^3 = 0.25
    ],
)
def test_the_blur_of_aberrations_falls_with_the_cube_of_the_f_number_in_its_square(
    f_number: float, pitch_um: float
) -> None:
    got = aberration.lens_pitch(OF_RATING, aberration_f1_px=F1, f_number=f_number)
    assert got == pytest.approx(pitch_um, rel=1e-12)


@pytest.mark.parametrize(("f_number_min", "left"), [(0.95, 4.0), (1.4, 4.0), (1.8, 2.0), (2.8, 2.0)])
def test_two_stops_leave_a_fourth_of_the_square_of_a_fast_lens_and_an_eighth_of_others(
    f_number_min: float, left: float
) -> None:
    # 4^2 wide open: 16 / 2^2 = 4 of a lens that opens to F1.4 or more, 16 / 2^3 = 2 of others
    exponent = aberration.aberration_exponent(f_number_min)
    at_f1 = aberration.aberration_at_f1(OF_ABERRATIONS, f_number_min=f_number_min)
    got = aberration.lens_pitch(0.0, aberration_f1_px=at_f1, f_number=2.0 * f_number_min, exponent=exponent)
    assert got**2 == pytest.approx(left, rel=1e-12)


def test_a_perfect_lens_without_a_rating_blurs_nothing() -> None:
    assert aberration.lens_pitch(0.0, aberration_f1_px=0.0, f_number=1.4) == 0.0


def test_the_corner_is_blurred_more_and_the_square_grows_with_that_of_the_field() -> None:
    # 1.8 at 80 % of the half diagonal; halfway there sqrt(1 + (3.24 - 1) / 4) = sqrt(1.56)
    assert aberration.field_blur(0.0) == 1.0
    assert aberration.field_blur(1.0) == pytest.approx(1.8)
    assert aberration.field_blur(0.5) == pytest.approx(np.sqrt(1.56))
    corner = aberration.lens_pitch(OF_RATING, aberration_f1_px=F1, f_number=2.0, field_blur=1.8)
    assert corner == pytest.approx(9.0)  # 1.8 x 5


def test_the_logarithm_of_the_transfer_rises_and_is_concave_in_that_of_the_f_number() -> None:
    """What bounds over cells of f-numbers rest on."""
    log_n = np.linspace(np.log(1.0), np.log(32.0), 400)
    pitch = aberration.lens_pitch(0.5, aberration_f1_px=1.3, f_number=np.exp(log_n), field_blur=1.4)
    log = np.log(sharpness.lens_mtf(0.25, lens_pitch_px=pitch))
    assert (np.diff(log) > 0).all() and (np.diff(log, 2) < 0).all()

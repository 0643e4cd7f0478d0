"""The simulated picture does what the model's figures say, each step held against its own closed form."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import uwopt
from uwopt.model import sharpness
from uwopt.model.sharpness import Sharpness
from uwopt.report.pictures import chart
from uwopt.report.pictures.maps import channel_fields
from uwopt.report.pictures.photograph import (
    FINE,
    Sensing,
    blur,
    detail_view,
    exposed_dn,
    sensing_of,
    sharpness_at,
    spread_over,
    srgb,
    whole_view,
)

PROBLEMS = Path(__file__).parents[2] / "problems"
SHARP = Sharpness(
    working_f_number=4.0, wavelength_nm=530.0, pixel_pitch_m=4e-6, motion_blur_px=1.5, defocus_px=0.8,
    lens_pitch_px=0.9,
)  # fmt: skip
SENSING = Sensing(6.0, 4.0, 0.01, 0.2, 32.0, 4095.0, 20_000.0)
PLAIN = np.zeros((1, 1))


@pytest.fixture(scope="module")
def strobe(replayed):
    return replayed(PROBLEMS / "nui-acfr.yaml", PROBLEMS / "nui-acfr.system.yaml")


@pytest.fixture(scope="module")
def colour(replayed, colour_system):
    return replayed(PROBLEMS / "nui-acfr.yaml", colour_system)


# ---------------------------------------------------------------- blur


def modulation(samples: np.ndarray, axis: int, cycles: int) -> float:
    """Amplitude over mean of the first harmonic of bars with that many cycles along an axis."""
    line = samples.mean(axis=1 - axis)
    spectrum = np.fft.rfft(line)
    return float(2.0 * np.abs(spectrum[cycles]) / np.abs(spectrum[0]))


@pytest.mark.parametrize("upward", [True, False])
@pytest.mark.parametrize("cycles", [6, 12, 20])
def test_bars_keep_the_modulation_that_the_transfer_function_says(upward, cycles):
    # a sine of `cycles` over 60 px, sampled 5 times a pixel, comes out as MTF says: exact but for rounding
    n = 60 * FINE
    wave = 1.0 + 0.6 * np.sin(2 * np.pi * cycles * (np.arange(n) + 0.5) / n)
    nu = cycles / 60
    for axis in (0, 1):
        image = np.repeat(np.expand_dims(wave, 1 - axis), n, axis=1 - axis)[..., None]
        seen = blur(image, SHARP, upward=upward, pixels_a_sample=1 / FINE)[..., 0]
        along = axis == (0 if upward else 1)
        transfer = sharpness.mtf_axes(nu, sharpness=SHARP)[0 if along else 1]
        assert modulation(seen, axis, cycles) == pytest.approx(0.6 * transfer, rel=1e-9)


def test_a_veil_that_shows_detail_lifts_what_varies_and_not_the_mean():
    n = 60 * FINE
    wave = 1.0 + 0.6 * np.sin(2 * np.pi * 6 * (np.arange(n) + 0.5) / n)
    image = np.repeat(wave[None, :], n, axis=0)[..., None]
    plain, lifted = (
        blur(image, SHARP, upward=True, pixels_a_sample=1 / FINE, detail=detail)[..., 0]
        for detail in (None, lambda nu: 1.0 + 0.03 / np.maximum(nu, 1e-3))
    )
    assert modulation(lifted, 1, 6) == pytest.approx(1.3 * modulation(plain, 1, 6))  # 0.1 cycles per pixel
    assert lifted.mean() == pytest.approx(plain.mean())


def test_a_square_wave_target_keeps_its_first_harmonic():
    # 4/pi of the sine's: bars 3 px wide, so that their edges fall between samples
    n = 60 * FINE
    bars = np.where(chart.is_bright((np.arange(n) + 0.5) / FINE, 3.0), 1.6, 0.4)
    image = np.repeat(bars[None, :, None], n, axis=0)
    seen = blur(image, SHARP, upward=True, pixels_a_sample=1 / FINE)[FINE // 2 :: FINE, FINE // 2 :: FINE, 0]
    wanted = 0.6 * 4 / np.pi * sharpness.mtf_axes(1 / 6, sharpness=SHARP)[1]
    assert modulation(seen, 1, 10) == pytest.approx(wanted, rel=0.01)


def test_motion_alone_spreads_an_edge_over_its_blur():
    still = replace(SHARP, motion_blur_px=0.0)
    n = 64 * FINE
    edge = np.where(np.arange(n) < n // 2, 1.0, 2.0)

    def rise_px(at: Sharpness, axis: int, upward: bool) -> float:
        image = np.repeat(np.expand_dims(edge, 1 - axis), n, axis=1 - axis)[..., None]
        line = blur(image, at, upward=upward, pixels_a_sample=1 / FINE)[..., 0].mean(axis=1 - axis)
        middle = line[n // 4 : 3 * n // 4]
        slope = np.diff(middle)
        place = np.arange(len(slope)) / FINE
        centre = (slope * place).sum() / slope.sum()
        return float((slope * (place - centre) ** 2).sum() / slope.sum())

    # variances of what is convolved add up: a box of b px has b^2 / 12 (the chain ends at its first nulls: 10 %)
    moved = replace(still, motion_blur_px=4.0)
    for upward, axis in ((True, 0), (False, 1)):
        gained = rise_px(moved, axis, upward) - rise_px(still, axis, upward)
        assert gained == pytest.approx(4.0**2 / 12, rel=0.1)
        assert rise_px(moved, 1 - axis, upward) == pytest.approx(rise_px(still, 1 - axis, upward), rel=1e-9)


def test_sharpness_of_the_middle_is_that_of_the_figures(strobe, colour):
    for design, figures in (strobe, colour):
        at = sharpness_at(design, 0, "centre")
        assert float(np.min(sharpness.mtf_half_nyquist(at))) == pytest.approx(figures["mtf_half_nyquist"])
    # the flat port spreads colours in the corner, along the diagonal
    corner = sharpness_at(colour[0], 0, "corner")
    assert corner.lateral_k_along != 0
    assert corner.spread is not None


# ---------------------------------------------------------------- noise


def test_noise_of_a_flat_patch_gives_the_snr_of_the_middle(strobe):
    design, figures = strobe
    field = channel_fields(design, PLAIN, PLAIN)["mono"]
    sensing = sensing_of(design, 0)
    n = 400_000
    light = np.full(n, float(field.signal_e[0, 0] + field.veil_e[0, 0]))
    numbers = exposed_dn(light, sensing, rng=np.random.default_rng(1))
    signal = sensing.gain_dn_per_e * float(field.signal_e[0, 0])
    # the standard error of a standard deviation is 1 / sqrt(2 n) = 0.11 %: 0.01 dB
    assert 20 * np.log10(signal / numbers.std()) == pytest.approx(figures["snr_db_centre"], abs=0.05)
    expected = sensing.gain_dn_per_e * (light[0] + sensing.dark_e) + sensing.black_dn
    assert numbers.mean() == pytest.approx(expected, abs=5 * numbers.std() / np.sqrt(n))


def test_noise_of_a_block_falls_with_its_side():
    light, rng = np.full(200_000, 3000.0), np.random.default_rng(2)
    one = exposed_dn(light, SENSING, rng=rng)
    block = exposed_dn(light, SENSING, rng=rng, block_px=4.0)
    quantised = one.var() - 1 / 12  # rounding adds its twelfth; means of blocks are not rounded
    assert block.std() == pytest.approx(np.sqrt(quantised) / 4, rel=0.01)
    variance_e2 = 3000.0 + 4.0 + 6.0**2 + (0.01 * 3000.0) ** 2
    assert block.std() == pytest.approx(0.2 * np.sqrt(variance_e2) / 4, rel=0.01)


def test_numbers_are_whole_and_end_at_full_scale():
    numbers = exposed_dn(np.geomspace(1.0, 1e9, 1000), SENSING, rng=np.random.default_rng(3))
    assert np.array_equal(numbers, np.round(numbers))
    assert numbers.min() >= 0
    assert numbers.max() <= 4095
    # the full well holds 20 000 e: 0.2 * 20 000 + 32 = 4032 DN and read noise
    assert numbers[-200:].mean() == pytest.approx(4032, abs=1)


# ---------------------------------------------------------------- views


def test_the_picture_shows_the_mean_level_of_the_figures(strobe):
    design, figures = strobe
    view = whole_view(design)
    middle = detail_view(design)
    assert view.snr_db == pytest.approx(figures["snr_db_centre"])
    assert middle.veil_share < 0.5
    # the floor around the board, decoded: its mean lies between the corner's and the middle's level
    linear = (view.picture[:, :8].astype(float) / 255 + 0.055) / 1.055
    share = float((linear**2.4).mean()) / view.brightened
    assert 0.5 * view.level < share < view.level


def test_colours_are_cast_as_the_channels_count(colour):
    design, figures = colour
    view = detail_view(design)
    red, green, _ = view.picture.reshape(-1, 3).mean(axis=0)
    assert figures["white_balance_red"] > 1
    assert red < green
    assert np.ptp(view.chart[:20, :20].astype(int), axis=2).max() == 0  # the bare floor is grey


def test_a_given_width_shows_the_same_chart(strobe, colour):
    one, other = (detail_view(design, width_mm=200.0) for design, _ in (strobe, colour))
    assert one.chart.shape == other.chart.shape == (360, 480, 3)
    assert one.unit_mm == other.unit_mm
    difference = one.chart.astype(int) - other.chart
    assert np.abs(difference).mean() < 8  # but for the size of the pixels


def test_pictures_repeat(strobe):
    assert np.array_equal(whole_view(strobe[0]).picture, whole_view(strobe[0]).picture)


def test_portrait_motion_runs_along_the_width(strobe, colour):
    assert strobe[0].model.hardware.landscape
    assert whole_view(strobe[0]).vertical_motion
    assert not whole_view(colour[0]).vertical_motion


def test_no_light_gives_a_dark_picture_and_no_warning(replayed):
    result = uwopt.evaluate(PROBLEMS / "paper-tank.yaml", PROBLEMS / "paper-tank.system.yaml")
    dark = {**result.system, "settings": {**result.system["settings"], "flux_lm": 0}}
    design, _ = replayed(result.mission, dark)
    for view in (whole_view(design), detail_view(design)):
        assert view.snr_db is None
        assert view.brightened == 1.0 or view.level > 0


def test_fields_are_linear_between_their_points():
    u, v = np.meshgrid(np.linspace(-1, 1, 5), np.linspace(-1, 1, 7))
    spread = spread_over(2 + u - 3 * v, 40, 20)
    u, v = np.meshgrid((np.arange(40) + 0.5) / 20 - 1, (np.arange(20) + 0.5) / 10 - 1)
    assert spread == pytest.approx(2 + u - 3 * v)


def test_srgb_is_the_standards():
    # IEC 61966-2-1: linear 0.18 is 118 of 255 (0.4614), 1 is 255, and the foot is a line of slope 12.92
    assert list(srgb(np.array([0.0, 0.002, 0.18, 1.0, 7.0]))) == [0, 7, 118, 255, 255]


def test_lateral_colour_of_the_corner_is_that_of_the_figures(replayed, colour_system):
    mission = uwopt.evaluate(PROBLEMS / "nui-acfr.yaml", colour_system, physics="full").mission
    design, figures = replayed(mission, colour_system)
    # the figure is exact in the angle, the transfer function's first order: 0.2 % at 40 degrees in air
    corner = detail_view(design, place="corner")
    assert corner.lateral_colour_px == pytest.approx(figures["lateral_colour_px"], rel=0.01)
    assert corner.defocus_px == pytest.approx(figures["defocus_corner_px"], abs=0.01)
    assert detail_view(design).lateral_colour_px == 0.0

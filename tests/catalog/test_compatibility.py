"""Mounts, image circles and the words that explain a misfit."""

from dataclasses import replace

import numpy as np
import pytest

from uwopt.catalog.compatibility import (
    data_rate_mb_s,
    explain_pair,
    image_circle_ok,
    mount_compatible,
    sensor_diagonal_mm,
)
from uwopt.catalog.parts.camera import Camera
from uwopt.catalog.parts.lens import Lens
from uwopt.catalog.parts.light import Light
from uwopt.catalog.parts.port import Port
from uwopt.catalog.records import exact

CAMERA = Camera(
    id="cam",
    resolution_x_px=2448,
    resolution_y_px=2048,
    pixel_pitch_um=3.45,
    mounts=("C",),
    interface="GigE",
    bit_depth=8,
    bandwidth_mb_s=exact(115.0),
)
LENS = Lens(id="lens", focal_length_mm=8.0, image_circle_mm=11.0, mounts=("C",))


@pytest.mark.parametrize(
    ("camera", "lens", "fits"),
    [
        (("C",), ("C",), True),
        (("CS",), ("C",), True),  # flange 12.526 mm + 5 mm ring = 17.526 mm
        (("C",), ("CS",), False),  # the lens would have to sit 5 mm inside
        (("S",), ("M12",), True),  # two names of M12 x 0.5
        (("S",), ("C",), False),
        (("C", "CS", "S"), ("S",), True),
        (("C",), (), False),
        ((), ("C",), False),
        (("F",), ("F",), True),
    ],
)
def test_mounts_fit_as_their_flange_distances_allow(camera, lens, fits):
    assert mount_compatible([camera], [lens])[0, 0] == fits


def test_mounts_of_many_parts_give_a_matrix():
    matrix = mount_compatible([("C",), ("CS",), ("S",)], [("C",), ("S",)])
    assert matrix.tolist() == [[True, False], [True, False], [False, True]]


def test_no_lenses_give_an_empty_matrix():
    assert mount_compatible([("C",)], []).shape == (1, 0)


def test_diagonal_of_the_imx250_is_eleven_millimetres():
    # 2464 x 2056 pixels of 3.45 um: sqrt(8.5008**2 + 7.0932**2) = 11.0716 mm by hand; the maker says 11.1 mm
    assert sensor_diagonal_mm(2464, 2056, 3.45) == pytest.approx(11.0716, abs=2e-4)


def test_image_circle_allows_two_per_cent_and_no_unknown_one():
    assert image_circle_ok(11.07, [11.0, 9.0, np.nan, 10.84]).tolist() == [True, False, False, False]


def test_data_rate_counts_packed_bits():
    # 1000 x 1000 px x 12 bit x 10 Hz = 120 Mbit/s = 15 MB/s
    assert data_rate_mb_s(1000, 1000, 12, 10.0) == pytest.approx(15.0)


def test_fitting_parts_have_no_finding():
    assert explain_pair(CAMERA, LENS) == []


def test_small_image_circle_is_told_with_both_numbers():
    (finding,) = explain_pair(CAMERA, Lens(id="small", image_circle_mm=9.0, mounts=("C",)))
    assert finding.rule == "image circle"
    assert "9 mm" in finding.message and "11.01 mm" in finding.message


def test_wrong_mount_names_what_the_camera_takes():
    (finding,) = explain_pair(CAMERA, Lens(id="short", image_circle_mm=11.0, mounts=("CS",)))
    assert finding.rule == "mount"
    assert "CS" in finding.message


def test_coarse_lens_is_a_warning_only():
    # 100 lp/mm: half a line pair is 5 um
    (finding,) = explain_pair(
        CAMERA, Lens(id="soft", image_circle_mm=11.0, mounts=("C",), rated_lp_per_mm=100.0)
    )
    assert (finding.rule, finding.severity) == ("lens rating", "warning")
    assert "rated for pixels of 5 um" in finding.message


@pytest.mark.parametrize(
    ("shutter", "rate", "told"),
    [("rolling", None, True), ("global", None, False), ("rolling", exact(30.0), False)],
)
def test_a_rolling_shutter_of_unknown_speed_is_told_not_to_be_counted(shutter, rate, told):
    # an action camera written out as rolling without a rate showed "rolling-shutter skew 0 px" as met
    camera = replace(CAMERA, shutter=shutter, max_frame_rate_hz=rate, bandwidth_mb_s=None)
    findings = explain_pair(camera, LENS)
    assert [f.severity for f in findings if f.rule == "rolling shutter"] == ["warning"] * told
    assert all("its skew is counted as 0" in finding.message for finding in findings)


def test_interface_too_slow_names_the_rates():
    # 2448 x 2048 byte x 25 Hz = 125.3 MB/s over 115 MB/s
    (finding,) = explain_pair(CAMERA, LENS, frame_rate_hz=25.0)
    assert finding.rule == "interface"
    assert "125.3 MB/s" in finding.message


def test_shallow_and_unrated_parts_fail_the_depth():
    port = Port(id="port", depth_rating_m=100.0)
    findings = explain_pair(CAMERA, LENS, port, Light(id="lamp"), required_depth_m=300.0)
    assert [finding.rule for finding in findings] == ["depth rating", "depth rating"]
    assert "100 m" in findings[0].message and "unknown" in findings[1].message


def test_inline_parts_are_not_checked_for_what_they_leave_out():
    lens = Lens(id="inline", inline=True, focal_length_mm=8.0)
    port, light = Port(id="p", inline=True), Light(id="l", inline=True)
    assert explain_pair(CAMERA, lens, port, light, required_depth_m=6000.0) == []


@pytest.mark.parametrize(("depth_m", "rules"), [(300.0, []), (300.1, ["depth rating"])])
def test_part_fails_just_below_its_rated_depth(depth_m, rules):
    lamp = Light(id="lamp", depth_rating_m=300.0)
    found = explain_pair(CAMERA, LENS, None, lamp, required_depth_m=depth_m)
    assert [finding.rule for finding in found] == rules


@pytest.mark.parametrize(("pitch_um", "rules"), [(3.45, []), (3.5, []), (3.6, ["lens rating"])])
def test_lens_is_soft_for_pixels_smaller_than_its_rating(pitch_um, rules):
    # pixels of 3.45 um, two per cent allowed: 3.519 um
    lens = Lens(id="l", image_circle_mm=11.0, mounts=("C",), rated_pixel_pitch_um=pitch_um)
    assert [finding.rule for finding in explain_pair(CAMERA, lens)] == rules


@pytest.mark.parametrize(("rate_hz", "rules"), [(22.9, []), (23.1, ["interface"])])
def test_interface_carries_what_it_states(rate_hz, rules):
    # 115 MB/s over 2448 x 2048 byte an image: 22.94 Hz
    assert [finding.rule for finding in explain_pair(CAMERA, LENS, frame_rate_hz=rate_hz)] == rules

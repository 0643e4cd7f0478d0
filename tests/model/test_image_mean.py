"""Means over images: many images and ranges at once."""

from __future__ import annotations

import numpy as np
import pytest

from uwopt.model import beam as beams
from uwopt.model.halo import Widening
from uwopt.model.image_mean import field_means
from uwopt.model.imaging import Lamps, PortShape
from uwopt.model.path_table import build_path_table

DOME = PortShape(True, 0.1, 0.005, 1.49, 0.0, 1.34)
ONE_LAMP = Lamps((0.0,), (0.0,), (0.0,), ((0.0, 0.0, 1.0),), (1.0,))
CLEAR = build_path_table(
    np.ones(3), wavelength_nm=None, k_lamp_per_m=np.zeros(3), c_camera_per_m=np.zeros(3), lamp_range_m=(0.5, 9.0),
    camera_range_m=(0.5, 9.0),
)  # fmt: skip


@pytest.mark.parametrize("beam", [beams.cosine_power_beam(np.deg2rad(60.0)), beams.cone_beam(np.deg2rad(30.0))])
def test_small_images_under_a_lamp_fall_with_the_square_of_the_distance(beam: beams.Beam) -> None:
    """In clear water the middle of an image gets I / d^2 of a lamp straight above it."""
    ranges_m = np.array([1.0, 2.0, 4.0])
    halves = np.array([1e-4, 2e-4])  # tangents: light is even over so little
    lobes = [beam] * len(ranges_m)
    mean = field_means(halves, halves, ranges_m=ranges_m, shape=DOME, lamps=ONE_LAMP, lobes=lobes, table=CLEAR)
    on_axis = float(beams.intensity_per_sr(1.0, beam))
    assert mean == pytest.approx(np.broadcast_to(on_axis / ranges_m**2, (2, 3)), rel=1e-6)


def test_each_range_has_the_lobe_that_its_way_makes() -> None:
    """What is left of I after each way, and an even halo of its own: (s I + h) / d^2 straight below."""
    own, ranges_m, halves = beams.cosine_power_beam(np.deg2rad(60.0)), np.array([1.0, 2.0, 4.0]), np.array([1e-4, 2e-4])
    left, halo_per_sr = np.array([0.9, 0.5, 0.2]), np.array([0.01, 0.05, 0.03])
    lobes = [
        beams.widened_by(own, Widening.of(np.array([share]), np.full((1, 101), halo), 0.0))
        for share, halo in zip(left, halo_per_sr, strict=True)
    ]
    mean = field_means(halves, halves, ranges_m=ranges_m, shape=DOME, lamps=ONE_LAMP, lobes=lobes, table=CLEAR)
    below = (left * float(beams.intensity_per_sr(1.0, own)) + halo_per_sr) / ranges_m**2
    assert mean == pytest.approx(np.broadcast_to(below, (2, 3)), rel=1e-6)

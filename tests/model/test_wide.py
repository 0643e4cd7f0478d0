"""The forward veil from elsewhere on the floor, against plain sums over the floor and a case done by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from uwopt.model import beam as beams
from uwopt.model.imaging import Lamps, PortShape, lamp_light
from uwopt.model.path_table import build_path_table
from uwopt.model.veil.wide import floor_spots, mean_wide_gain, wide_gain

POINT = PortShape(is_dome=True, outer_radius_m=0.0, thickness_m=0.0, n_glass=1.5, gap_m=0.0, n_water=1.34)
LAMP = {"near": 0.5, "all": 0.2}
K_LAMP = 0.3
BEAMS = {
    "lobe": beams.cosine_power_beam(np.deg2rad(50)), "narrow lobe": beams.cosine_power_beam(np.deg2rad(16)),
    "disc": beams.disc_beam(np.deg2rad(40)),
}  # fmt: skip


def table() -> Any:
    return build_path_table(
        np.ones(1), wavelength_nm=None, k_lamp_per_m=np.array([K_LAMP]), c_camera_per_m=np.array([LAMP["near"]]),
        k_camera_per_m=np.array([LAMP["all"]]), lamp_range_m=(0.5, 24.0), camera_range_m=(0.5, 24.0),
    )  # fmt: skip


def lamps(tilt: float) -> Lamps:
    return Lamps((0.1,), (0.7,), (-0.2,), ((0.0, float(np.sin(tilt)), float(np.cos(tilt))),), (1.0,))


def by_cells(u: float, v: float, *, lamp: Lamps, beam: Any, shape: PortShape, range_m: float) -> float:
    """The same by equal cells of the plane, 2 cm wide."""
    edge = np.arange(-9.0, 9.0, 0.02) + 0.01
    x, y = np.meshgrid(edge, edge, indexing="ij")
    z = range_m + shape.slope * x
    lit, lamp_m, _ = lamp_light(x, y, lamps=lamp, index=0, beam=beam, range_m=range_m, slope=shape.slope)
    far = np.sqrt(x * x + y * y + (z + shape.outer_radius_m) ** 2)
    cosine = (u * x + v * y + z + shape.outer_radius_m) / far / np.sqrt(1 + u * u + v * v)
    facing = (z + shape.outer_radius_m - shape.slope * x) / far / np.hypot(1, shape.slope)
    r = far - shape.outer_radius_m
    left = np.exp(-LAMP["all"] * r) - np.exp(-LAMP["near"] * r)
    kernel = 9 / (2 * np.pi) * np.maximum(cosine, 0.0) ** 8
    area = 0.02**2 * np.hypot(1, shape.slope)
    total = float((kernel * lit * np.exp(-K_LAMP * lamp_m) * left * facing / far**2).sum())
    return total * area / (1 + u * u + v * v) ** 2


@pytest.mark.parametrize("name", BEAMS)
@pytest.mark.parametrize(("tilt", "slope", "radius"), [(0.0, 0.0, 0.0), (-0.4, 0.3, 0.1)])
def test_spots_of_equal_flux_sum_to_the_floor(name: str, tilt: float, slope: float, radius: float) -> None:
    shape = POINT._replace(slope=slope, outer_radius_m=radius)
    setting: dict[str, Any] = dict(beam=BEAMS[name], shape=shape, range_m=2.0)
    spots = floor_spots(lamps=lamps(tilt), **setting)
    for at in ((0.0, 0.0), (0.5, -0.6)):
        expected = by_cells(*at, lamp=lamps(tilt), **setting)
        found = wide_gain(*map(np.asarray, at), spots=spots, shape=shape, table=table())
        assert found == pytest.approx(expected, rel=5e-4 if name == "disc" else 5e-5)  # cells cross the disc's edge


def test_the_kernel_sends_all_light_somewhere() -> None:
    # a camera that looks all ways gets from a spot straight below what the spot sends: integral of k is 1
    spots = floor_spots(lamps=lamps(0.0), beam=BEAMS["lobe"], shape=POINT, range_m=2.0)
    one = spots._replace(
        direction=np.array([[0.0], [0.0], [1.0]]), share=np.ones(1), lamp_m=np.ones(1), camera_m=np.ones(1)
    )
    angle = (np.arange(2000) + 0.5) * np.pi / 4000
    tangent = np.tan(angle)
    gain = wide_gain(tangent, 0.0 * tangent, spots=one, shape=POINT, table=table()) / np.cos(angle) ** 4
    total = (gain * 2 * np.pi * np.sin(angle)).sum() * np.pi / 4000
    assert total == pytest.approx(np.exp(-K_LAMP) * (np.exp(-LAMP["all"]) - np.exp(-LAMP["near"])), rel=1e-5)


def test_means_over_images_are_those_of_their_pixels() -> None:
    setting: dict[str, Any] = dict(shape=POINT, table=table())
    spots = floor_spots(lamps=lamps(0.2), beam=BEAMS["lobe"], shape=POINT, range_m=2.0)
    cells = (np.arange(60) + 0.5) / 30 - 1
    pixels = wide_gain(0.8 * cells[:, None], 0.5 * cells[None, :], spots=spots, **setting)
    assert mean_wide_gain(np.array([0.8]), np.array([0.5]), spots=spots, **setting)[0] == pytest.approx(
        pixels.mean(), rel=5e-4
    )

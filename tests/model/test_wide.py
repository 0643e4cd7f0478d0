"""The forward veil from elsewhere on the floor, against plain sums over the floor and a case done by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from uwopt.model import beam as beams
from uwopt.model.imaging import Lamps, PortShape, lamp_light
from uwopt.model.path_table import build_path_table
from uwopt.model.veil.wide import floor_spots, kernel_shares, least_within, mean_wide_gain, wide_gain

POINT = PortShape(is_dome=True, outer_radius_m=0.0, thickness_m=0.0, n_glass=1.5, gap_m=0.0, n_water=1.34)
LAMP = {"near": 0.5, "all": 0.2}
K_LAMP, TURNS = 0.3, 0.6
SHARES = kernel_shares(TURNS)
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
    once, twice = TURNS / np.expm1(TURNS), 0.5 * TURNS**2 / np.expm1(TURNS)
    parts = {16: 0.85 * once, 2: 0.15 * once, 8: twice, 4: 1.0 - once - twice}
    kernel = sum(part * (n + 1) / (2 * np.pi) * np.maximum(cosine, 0.0) ** n for n, part in parts.items())
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
        found = wide_gain(*map(np.asarray, at), spots=spots, shape=shape, table=table(), shares=SHARES)
        assert found == pytest.approx(expected, rel=5e-4 if name == "disc" else 5e-5)  # cells cross the disc's edge


def test_the_kernel_sends_all_light_somewhere() -> None:
    # a camera that looks all ways gets from a spot straight below what the spot sends: integral of k is 1
    spots = floor_spots(lamps=lamps(0.0), beam=BEAMS["lobe"], shape=POINT, range_m=2.0)
    one = spots._replace(
        direction=np.array([[0.0], [0.0], [1.0]]), share=np.ones(1), lamp_m=np.ones(1), camera_m=np.ones(1)
    )
    angle = (np.arange(2000) + 0.5) * np.pi / 4000
    tangent = np.tan(angle)
    gain = wide_gain(tangent, 0.0 * tangent, spots=one, shape=POINT, table=table(), shares=SHARES) / np.cos(angle) ** 4
    total = (gain * 2 * np.pi * np.sin(angle)).sum() * np.pi / 4000
    assert total == pytest.approx(np.exp(-K_LAMP) * (np.exp(-LAMP["all"]) - np.exp(-LAMP["near"])), rel=1e-5)


def test_means_over_images_are_those_of_their_pixels() -> None:
    setting: dict[str, Any] = dict(shape=POINT, table=table(), shares=SHARES)
    spots = floor_spots(lamps=lamps(0.2), beam=BEAMS["lobe"], shape=POINT, range_m=2.0)
    cells = (np.arange(60) + 0.5) / 30 - 1
    pixels = wide_gain(0.8 * cells[:, None], 0.5 * cells[None, :], spots=spots, **setting)
    assert mean_wide_gain(np.array([0.8]), np.array([0.5]), spots=spots, **setting)[0] == pytest.approx(
        pixels.mean(), rel=5e-4
    )


def test_light_turns_once_where_little_turns_and_ever_more_often() -> None:
    """By Poisson's numbers of at least one turn: x = 2 by hand, q_1 = 2 / (e^2 - 1) = 0.31304 and q_2 = q_1."""
    assert kernel_shares(0.0) == pytest.approx([0.15, 0.0, 0.0, 0.85], abs=1e-8)
    assert kernel_shares(2.0) == pytest.approx([0.15 * 0.31304, 1.0 - 2 * 0.31304, 0.31304, 0.85 * 0.31304], abs=1e-5)
    assert kernel_shares([[1e3], [800.0]]) == pytest.approx(np.array([[[0.0, 1.0, 0.0, 0.0]]] * 2))


@pytest.mark.parametrize("power", [2, 4, 8, 16])
@pytest.mark.parametrize(("along", "across"), [(0.05, 0.07), (0.3, 0.4), (0.62, 0.31), (1.3, 0.9), (2.2, 2.2)])
def test_an_images_own_floor_sends_least_to_its_corner_or_near_it(power: int, along: float, across: float) -> None:
    """By 400 x 400 cells of the image, least over 9 x 9 places of its quarter."""
    cells = (np.arange(400) + 0.5) / 200 - 1
    u, v = (side.ravel() for side in np.meshgrid(along * cells, across * cells))
    weight = 1.0 / (1.0 + u * u + v * v) ** 2 * along * across / 4e4  # cos u d Omega = cos^4 u du dv
    least = np.inf
    for s in np.linspace(0, along, 9):
        for t in np.linspace(0, across, 9):
            secant = np.sqrt(1 + s * s + t * t)
            cosine = (s * u + t * v + 1) / secant / np.sqrt(1 + u * u + v * v)
            least = min(least, secant * float((power + 1) / (2 * np.pi) * (np.maximum(cosine, 0) ** power) @ weight))
    found = float(least_within(along, across)[[2, 4, 8, 16].index(power)])
    assert 0.94 * least <= found <= 1.01 * least


def test_places_that_a_window_shows_aside_and_very_small_or_large_images_are_bounded_by_less() -> None:
    assert np.all(least_within(0.4, 0.3, aside=[0.0, 0.1, 0.3])[1:] < least_within(0.4, 0.3))
    assert not least_within(np.array([0.4, 0.02, 0.4]), np.array([0.3, 0.3, 2.6]), aside=np.array([0.31, 0, 0])).any()

"""Ports as columns: what many images see behind a port each is what each sees behind its own."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from random_cases import case

from uwopt.forward.scene import SceneOptics
from uwopt.forward.views import footprints, port_shape, port_shapes, views
from uwopt.model import beam as beams
from uwopt.model.image_mean import field_means
from uwopt.model.imaging import Lamps
from uwopt.model.path_table import build_path_table

RNG = np.random.default_rng(5)
COUNT = 9
ALONG, ACROSS = RNG.uniform(0.1, 0.5, (2, COUNT))
RANGES_M = np.array([1.8, 2.0, 2.3])
PORTS = SimpleNamespace(
    is_dome=np.arange(COUNT) % 2 == 0, outer_radius_m=RNG.uniform(0.03, 0.1, COUNT) * (np.arange(COUNT) % 2 == 0),
    thickness_m=RNG.uniform(0.004, 0.02, COUNT), refractive_index=RNG.uniform(1.45, 1.6, COUNT),
    gap_m=RNG.uniform(0.0, 0.03, COUNT),
)  # fmt: skip
TABLE = build_path_table(
    np.ones(3), wavelength_nm=None, k_lamp_per_m=np.array([0.1, 0.2, 0.4]), c_camera_per_m=np.array([0.2, 0.3, 0.5]),
    lamp_range_m=(0.5, 9.0), camera_range_m=(0.5, 9.0),
)  # fmt: skip
LAMPS = Lamps((0.0,), (0.4,), (0.0,), ((0.0, -0.1, np.sqrt(0.99)),), (1.0,))


@cache
def scene(*, oblique: bool) -> SceneOptics:
    """A scene that is looked at squarely or from the side."""
    made = case(9, oblique=True).problem().scenes[0]
    return made if oblique else replace(made, pitch_rad=0.0)


@pytest.mark.parametrize("oblique", [False, True])
def test_footprints_behind_many_ports_are_those_behind_each(oblique: bool) -> None:
    where, ones = scene(oblique=oblique), np.ones(COUNT)
    assert bool(where.slope) == oblique and not where.paper
    rows = np.arange(COUNT)
    for mine, shape in port_shapes(PORTS, rows, where):
        assert len(mine) > 1
        seen = footprints(where, shape, ALONG[mine], ACROSS[mine], 5e-6 * ones[mine], 8e-3 * ones[mine], RANGES_M)
        for place, row in enumerate(mine):
            one = slice(row, row + 1)
            alone = footprints(
                where, port_shape(PORTS, row, where), ALONG[one], ACROSS[one], 5e-6 * ones[one], 8e-3 * ones[one],
                RANGES_M,
            )  # fmt: skip
            for name, column in seen.items():
                assert column[place] == pytest.approx(alone[name][0], rel=1e-13), name


@pytest.mark.parametrize("oblique", [False, True])
@pytest.mark.parametrize("beam", [beams.cosine_power_beam(np.deg2rad(60.0)), beams.cone_beam(np.deg2rad(30.0))])
def test_means_behind_many_ports_are_those_behind_each(beam: beams.Beam, oblique: bool) -> None:
    where, lit = scene(oblique=oblique), dict(ranges_m=RANGES_M, lobes=[beam] * len(RANGES_M), lamps=LAMPS, table=TABLE)
    for mine, shape in port_shapes(PORTS, np.arange(COUNT), where):
        mean = field_means(ALONG[mine], ACROSS[mine], shape=shape, **lit)
        for place, row in enumerate(mine):
            one = slice(row, row + 1)
            alone = field_means(ALONG[one], ACROSS[one], shape=port_shape(PORTS, row, where), **lit)
            assert mean[place] == pytest.approx(alone[0], rel=1e-12)


@pytest.mark.parametrize("oblique", [False, True])
def test_what_many_pairs_see_is_what_each_sees(oblique: bool) -> None:
    """Of a sensor, one of half its pixels twice as wide with the same field, and both again."""
    problem = case(9, oblique=True).problem()
    where, cameras, lenses = scene(oblique=oblique), problem.cameras, problem.lenses
    sensor, lens = cameras.take(np.zeros(4, int)), lenses.take(np.zeros(4, int))
    coarse = np.array([1.0, 0.5, 1.0, 0.5])
    sensor = replace(
        sensor, resolution_x_px=sensor.resolution_x_px * coarse, resolution_y_px=sensor.resolution_y_px * coarse,
        pixel_pitch_m=sensor.pixel_pitch_m / coarse,
    )  # fmt: skip
    for row in np.flatnonzero(np.diff(PORTS.is_dome)):
        shape = port_shape(PORTS, int(row), where)
        seen = views(where, sensor, lens, shape, landscape=True)
        assert seen.tan_along[0] == seen.tan_along[1] and seen.gsd_m[0, 1] != seen.gsd_m[1, 1]
        for k in range(4):
            one = np.array([k])
            alone = views(where, sensor.take(one), lens.take(one), shape, landscape=True)
            for column in fields(seen):
                many, single = getattr(seen, column.name), getattr(alone, column.name)
                assert many.shape[1:] == single.shape[1:] and (many[k] == single[0]).all(), column.name

"""The least forward veil of an image, against the veil of images that lamps of many kinds light from many places."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from one_of_each import one, with_parts

from uwopt.forward.lamp_light import image_light
from uwopt.model.veil.wide import least_within
from uwopt.solvers.exact.least_veil import LeastVeil
from uwopt.solvers.exact.search import Search

Array = NDArray[Any]
LOBES_DEG = (12.0, 50.0, 110.0)
MOUNTS = (  # where lamps stand and aim: level, outward, across from far aside, towards a corner, grazing the floor
    {"x_m": 0.0, "y_m": 0.1, "z_m": 0.0}, {"x_m": 0.2, "y_m": 0.5, "z_m": 0.0, "tilt_y_deg": 12.0},
    {"x_m": 0.0, "y_m": 1.5, "z_m": 0.0, "tilt_y_deg": -40.0},
    {"x_m": 0.0, "y_m": 0.4, "z_m": -0.1, "tilt_x_deg": 20.0, "tilt_y_deg": 30.0},
    {"x_m": 0.0, "y_m": 4.0, "z_m": 0.0, "tilt_y_deg": -80.0},
)  # fmt: skip
LENSES = ({"focal_length_mm": 3.5}, {"focal_length_mm": 25.0})


@cache
def searched(flat: bool, mount: int, water: str, altitude_m: float, pixels: bool = False) -> Search:
    """Three lenses, fields of 22 to 107 deg in air, and three lobes, at one mount."""
    wanted = {"min_snr_db": 3.0, "snr_at": "worst"} if pixels else {"min_snr_db": 3.0}
    vehicle = {"altitude_m": altitude_m, "light_mounts": [MOUNTS[mount]], "altitude_tolerance_m": 0.2 * altitude_m}
    made = one(flat=flat, wanted=wanted, scenes=({"water": water},), vehicle=vehicle, lens={"image_circle_mm": 12.0})
    lamps = [{"beam_angle_deg": lobe} for lobe in LOBES_DEG]
    return with_parts(made, lenses=LENSES, lights=lamps).searcher()


def found(search: Search) -> tuple[Array, Array]:
    """Veil over signal of every image under every lighting (n_lightings, n, 2), farthest and nominal, and its bound."""
    imagers, problem = search.prepare(), search.tables.problem
    rows, nominal = np.arange(len(imagers)), problem.scenes[0].nominal
    veils, bounds = [], []
    for lighting in search.tables.lightings:
        light = image_light(
            problem, 0, imagers.scenes[0].view, imagers.camera, port_index=0, lit=lighting.of(1),
            veils="forward",
        )  # fmt: skip
        assert light.forward_e is not None
        with np.errstate(divide="ignore", invalid="ignore"):  # no light at all where a lamp looks away
            ratio = np.where(light.signal_e > 0.0, light.forward_e / light.signal_e, np.inf)
        veils.append(ratio[:, [-1, nominal]])
        bounds.append(np.stack(
            [search.bounds.needs.veils.least(0, [lighting], rows, at) for at in (-1, nominal)], axis=1
        ))  # fmt: skip
    return np.array(veils), np.array(bounds)


@pytest.mark.parametrize(("water", "altitude_m"), [("7C", 0.4), ("7C", 2.0), ("3C", 2.0)])
@pytest.mark.parametrize("mount", range(len(MOUNTS)))
@pytest.mark.parametrize("flat", [False, True])
def test_no_image_has_less_veil_than_its_bound(flat: bool, mount: int, water: str, altitude_m: float) -> None:
    """And where lamps light an image evenly it has not much more, or the bound would be empty."""
    veil, bound = found(searched(flat, mount, water, altitude_m))
    assert bound.shape[1] >= (2 if flat else 3) and np.isfinite(veil).any()
    assert (bound <= veil).all()
    assert mount > 0 or (veil <= 2.5 * bound).all()


def test_what_comes_from_elsewhere_counts_in_the_bound_of_means_alone() -> None:
    """A pixel that must reach an SNR may have less: there the bound is that of the straight way.

    Of means it is what the image's own floor sends, no more: lamps send as much from beside the image, and more, so
    that designs alone would not find a bound that is too high by half.
    """
    mean, pixels = (searched(False, 0, "7C", 2.0, pixels=there) for there in (False, True))
    (_, whole), (_, near) = found(mean), found(pixels)
    assert (whole > 1.05 * near).all()
    contraction = pixels.problem.contractions[0]
    far_m = pixels.problem.nearest_m(0, -1)  # of the lamps, too, at the camera's height
    least, wide = pixels.tables.problem.contractions[0].least_veil(0, 0, -1, far_m, far_m)
    assert near[0, :, 0] == pytest.approx(least) and wide.sum() > 0.0 and contraction.multiple
    # 8 by 6 mm behind 8 mm and a dome: tangents 0.5 and 0.375, in water too
    expected = float(least_within(0.375, 0.5)[0] @ wide)  # a step of 2 % a side, no more, is lost to it
    assert 0.94 * expected <= (whole - near)[0, 0, 0] <= expected


@pytest.mark.parametrize("water", ["7C", "3C", "II"])
def test_no_pair_of_ways_has_less_veil_than_their_bound(water: str) -> None:
    """Sums over the spectrum at 4000 pairs of ways, drawn and at the ends; and those least are not far above it."""
    search = searched(False, 0, water, 2.0)
    search.prepare()
    light, scene = search.tables.problem.contractions[0], search.problem.scenes[0]
    range_m, lowest_m = float(scene.range_m[-1]), 1.5
    near, wide = light.least_veil(0, 0, -1, range_m, lowest_m)
    drawn = np.random.default_rng(5)
    lamp_m, camera_m = (
        np.concatenate([drawn.uniform(low, high, 3996), [low, low, high, high]])
        for low, high in ((lowest_m, light.reach_m[0]), (range_m, light.reach_m[1]))
    )
    camera_m[-3:] = light.reach_m[1], range_m, light.reach_m[1]
    lamp_loss, weight = np.multiply.outer(lamp_m, light.lamp_leg_per_m(0)), light.weight(0, 0)
    image, close, all_of_it = (
        np.exp(-lamp_loss - np.multiply.outer(camera_m, leg)) @ weight
        for leg in (scene.attenuation_per_m, light.near_leg_per_m(), light.veil_leg_per_m(range_m))
    )
    for bound, least in ((near, (close / image - 1.0).min()), (wide.sum(), ((all_of_it - close) / image).min())):
        assert 0.75 * least <= bound <= least


@pytest.mark.parametrize("flat", [False, True])
def test_rows_for_groups_are_bounded_by_all_images_between_their_ends(flat: bool) -> None:
    """Lenses of 8 to 11 mm: each on its own has no less than the row that stands for all of them."""
    search = searched(flat, 0, "7C", 2.0)
    imagers = search.prepare()
    own = LeastVeil(search.problem, imagers)
    view = imagers.scenes[0].view
    none, between = np.zeros(len(imagers)), [1.0, 1.05, 1.2, 1.3, 1.375]

    def grown(by: float) -> Any:
        return replace(view, tan_along=by * view.tan_along, tan_across=by * view.tan_across)

    bound = own._sent(0, view, grown(between[-1]), none)
    each = np.array([own._sent(0, grown(by), grown(by), none) for by in between])
    assert (bound <= each.min(axis=0)).all() and (bound >= 0.6 * each.min(axis=0)).all()

"""Lobes widened by scattering on their way: small angles in closed form, energy, limits and bounds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.polynomial.chebyshev import chebvander
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.special import j0

from uwopt.model import beam as beams
from uwopt.model import phase_formulas, scattering
from uwopt.model.image_mean import field_mean
from uwopt.model.imaging import Lamps, PortShape
from uwopt.model.path_table import build_path_table
from uwopt.model.scattering import PhaseTable
from uwopt.model.veil.geometry import Scatterer
from uwopt.model.veil.mean import mean_backscatter
from uwopt.model.veil.ray import backscatter_gain
from uwopt.model.widened import (
    Turned,
    arriving_share,
    bounding,
    carried_share,
    chebyshev_rows,
    ways_m,
    widened,
)

Array = NDArray[Any]
NARROW = beams.cosine_power_beam(np.deg2rad(16.0))
LOBES = {
    "narrow": NARROW, "wide": beams.cosine_power_beam(np.deg2rad(120.0)), "needle": beams.cosine_power_beam(0.01),
    "spot": beams.cosine_power_beam(np.deg2rad(6.0)),
    "disc": beams.disc_beam(np.deg2rad(20.0)), "cone": beams.cone_beam(np.deg2rad(35.0)),
    "profile": beams.tabulated_beam(np.deg2rad([0, 10, 20, 50, 70]), [3, 4, 2, 1, 0], medium="water", n_w=1.34),
    "profile that ends lit": beams.tabulated_beam(np.deg2rad([0, 20, 40]), [3, 2, 1], medium="water", n_w=1.34),
}  # fmt: skip


def henyey_greenstein(g: float) -> PhaseTable:
    return scattering.phase_table_of(lambda psi: phase_formulas.henyey_greenstein_per_sr(np.cos(psi), asymmetry=g))


def petals(width_rad: float) -> PhaseTable:
    """A phase function that falls like a Gaussian, forward alone."""
    return scattering.phase_table_of(
        lambda psi: np.exp(-0.5 * np.square(psi / width_rad)) / (2 * np.pi * width_rad**2) + 1e-12
    )


def flux(beam: beams.Beam, power: int = 0) -> float:
    """Integral of I theta^power over the front, by midpoints in angle."""
    angle = (np.arange(200_000) + 0.5) * np.pi / 400_000
    values = beams.intensity_per_sr(np.cos(angle), beam) * angle**power * np.sin(angle)
    return float(2 * np.pi * values.sum() * np.pi / 400_000)


@pytest.mark.parametrize("name", LOBES)
def test_water_that_scatters_nothing_leaves_a_lobe_as_it_is(name: str) -> None:
    cos = np.cos(np.linspace(0.0, 2.0, 500))
    same = widened(LOBES[name], [Turned(0.0, 0.1, henyey_greenstein(0.9)), Turned(0.0, 0.1, None)])
    assert beams.intensity_per_sr(cos, same) == pytest.approx(beams.intensity_per_sr(cos, LOBES[name]), rel=1e-12)


def test_a_narrow_lobe_is_that_of_small_angle_scattering() -> None:
    # Wells: the Hankel transforms of lobe and phase function, both Gaussian here, on axis and at 8 and 16 deg;
    # 2 %: cos^m for exp(-m theta^2 / 2), angles for their sines
    way, width = 2.0, np.deg2rad(4.0)
    made = widened(NARROW, [Turned(way, 0.0, petals(width))])
    assert NARROW.exponent is not None

    def arriving(q: float) -> float:
        chi = quad(lambda s: np.exp(-0.5 * (q * width * (1 - s)) ** 2), 0, 1)[0]
        return float(np.exp(-0.5 * q * q / NARROW.exponent + way * (chi - 1.0)))

    def there(angle: float) -> float:
        return float(quad(lambda q: q * arriving(q) * j0(q * angle) / (2 * np.pi), 0, 120, limit=400)[0])

    for angle in np.deg2rad([0.0, 8.0, 16.0]):
        assert beams.intensity_per_sr(np.cos(angle), made) == pytest.approx(there(angle), rel=0.02)


@pytest.mark.parametrize("way", [0.3, 2.0, 6.0])
def test_the_mean_square_angle_grows_by_a_third_of_what_is_turned(way: float) -> None:
    # small-angle diffusion: <theta^2> + b r <psi^2> / 3, with <psi^2> = 2 w^2
    width = np.deg2rad(2.0)
    made = widened(NARROW, [Turned(way, 0.0, petals(width))])
    before, after = (flux(one, 2) / flux(one) for one in (NARROW, made))
    assert after - before == pytest.approx(way * 2 * width**2 / 3, rel=0.03)


@pytest.mark.parametrize("name", ["narrow", "needle", "disc", "cone", "profile that ends lit"])
@pytest.mark.parametrize("way", [0.2, 3.0])
def test_no_light_is_lost_but_what_is_absorbed_and_turned_back(name: str, way: float) -> None:
    # over exp(-K r), K = a + 0.2 b, arrives exp(-(a + b_b) r): a factor exp(b r (0.2 - b_b/b)); share beyond 90 deg of
    # Henyey-Greenstein in closed form; 1.5 %: what goes behind the front plane counts as lost, and ripples are cut
    g = 0.9
    back = (1 - g * g) / (2 * g) * (1 / np.sqrt(1 + g * g) - 1 / (1 + g))
    made = widened(LOBES[name], [Turned(way, 0.2, henyey_greenstein(g))])
    known = np.exp(way * (0.2 - back))
    assert flux(made) == pytest.approx(known, rel=0.015)
    assert flux(made) * (1 - 1e-5) <= beams.flux_per_lm(made) <= known * (1 + 1e-3)


def test_molecules_and_particles_add_up() -> None:
    sea = henyey_greenstein(0.95)
    both = widened(NARROW, [Turned(1.0, 0.1, sea), Turned(0.5, 0.4, None)])
    assert carried_share(None)[0, 0] == pytest.approx(0.5, rel=1e-3)  # symmetric: half goes forward
    known = np.exp(1.0 * (carried_share(sea)[0, 0] - 1.0 + 0.1) + 0.5 * (0.5 - 1.0 + 0.4))
    assert beams.flux_per_lm(both) == pytest.approx(known, rel=0.01)


@pytest.mark.parametrize("count", [2, 3, 4, 9, 64, 65])
def test_chebyshevs_polynomials_are_those_of_numpy(count: int) -> None:
    x = np.append(np.cos(np.linspace(0.0, np.pi, 50)), [-0.5, 0.3])
    np.testing.assert_allclose(chebyshev_rows(x, count).T, chebvander(x, count - 1), rtol=0, atol=1e-13)


@pytest.mark.parametrize("g", [0.8, 0.95])
@pytest.mark.parametrize("degrees", [30.0, 76.9])
def test_what_arrives_is_the_integral_over_turns(g: float, degrees: float) -> None:
    # dense Gauss-Legendre in both, crowded at the forward peak, with the function in closed form
    within, absorbed = np.deg2rad(degrees), np.array([0.0, 0.3, 3.0, 36.0])
    node, weight = (leggauss(300)[0] + 1.0) / 2.0, leggauss(300)[1] / 2.0
    turn, s = within * node[:, None] ** 3, node
    part = weight[:, None] * 3.0 * within * node[:, None] ** 2 * weight
    detour = s + (1.0 - s) / np.cos(turn) - 1.0 / np.cos(np.arctan((1.0 - s) * np.tan(turn)))
    part *= 2.0 * np.pi * np.sin(turn) * phase_formulas.henyey_greenstein_per_sr(np.cos(turn), asymmetry=g)
    known = [np.sum(part * np.exp(-thick * detour)) for thick in absorbed]
    assert arriving_share(henyey_greenstein(g), absorbed, within_rad=within) == pytest.approx(known, rel=1e-3)


@pytest.mark.parametrize("name", LOBES)
@pytest.mark.parametrize(("way", "g"), [(0.3, 0.95), (2.0, 0.9), (9.0, 0.8)])
def test_bounds_of_a_widened_lobe_lie_nowhere_below_it(name: str, way: float, g: float) -> None:
    made = widened(LOBES[name], [Turned(way, 0.1, henyey_greenstein(g))])
    angle = np.sort(np.random.default_rng(4).uniform(0.0, 0.5 * np.pi, 50_000))
    seen = beams.intensity_per_sr(np.cos(angle), made)
    at, envelope = beams.falling_envelope(made)
    assert np.all(np.diff(envelope) <= 0.0)
    assert np.all(seen <= envelope[np.searchsorted(at, angle, side="right") - 1] * (1 + 1e-9))
    assert seen.max() <= beams.peak_intensity_per_sr(made)
    assert envelope[0] <= beams.peak_intensity_per_sr(made) * (1 + 1e-9)  # and no more than is needed


def each_and_bound(
    name: str, waters: Sequence[tuple[float, float]], weights: Sequence[float], reach_m: float, *, most: bool
) -> tuple[list[beams.Beam], beams.Beam]:
    """A lobe as waters of these b and a widen it [1/m], and a bound of all; of what is sent back that from below."""
    sea, ways, lobe, sent_back = henyey_greenstein(0.9), ways_m(reach_m), LOBES[name], not most
    each = [
        widened(lobe, [Turned(b * ways, 0.1, sea)], reach_m, absorbed=a * ways, sent_back=sent_back) for b, a in waters
    ]
    scattered, absorbed = (np.concatenate([one[k] * ways for one in waters]) for k in (0, 1))
    bound = bounding(
        lobe, [Turned(scattered, 0.1, sea)], reach_m, absorbed=absorbed, sent_back=sent_back, weights=weights, most=most
    )
    return each, bound


@pytest.mark.parametrize("name", ["wide", "disc"])
@pytest.mark.parametrize("most", [True, False])
def test_a_bound_of_several_waters_lobes_is_the_extreme_of_all_at_once(name: str, most: bool) -> None:
    """share = least of w s, or of a sharp edge the most where that is asked; halo the extreme of w h + (w s - share) I,
    I the extreme within a knot's spacing: of whole tables."""
    reach_m, weights, pick = 2.0, (1.0, 0.9, 0.95, 0.7), np.max if most else np.min
    waters = [(0.1, 0.3), (0.6, 0.1), (1.5, 0.02), (0.3, 0.2)]
    each, made_of_all = each_and_bound(name, waters, weights, reach_m, most=most)
    own = [one.widening for one in each if one.widening is not None]
    shares = np.array([w * one.share for w, one in zip(weights, own, strict=True)])
    halos = np.array([w * one.halo_per_sr for w, one in zip(weights, own, strict=True)])
    share = pick(shares, axis=0) if name == "disc" else shares.min(axis=0)
    if name != "disc":
        knots = halos.shape[2] - 1
        u = np.clip((np.arange(knots + 1)[:, None] + np.arange(-8, 9) / 8.0) / knots, 0.0, 1.0)
        about = pick(beams.intensity_per_sr(1.0 - np.square(u), LOBES[name]), axis=1)
        halos = halos + (shares - share)[:, :, None] * about
    made = made_of_all.widening
    assert made is not None
    np.testing.assert_allclose(made.share, share, rtol=1e-13)
    dark = slice(None) if most else slice(-1)  # but for the front plane of what is no upper bound
    np.testing.assert_allclose(
        made.halo_per_sr[:, dark], np.maximum(pick(halos, axis=0), 0.0)[:, dark], rtol=1e-12, atol=1e-12 * halos.max()
    )


@pytest.mark.parametrize("name", ["narrow", "wide", "disc", "profile"])
@pytest.mark.parametrize("most", [True, False])
def test_a_bound_of_several_waters_lobes_is_one_at_every_angle(name: str, most: bool) -> None:
    reach_m, weights = 2.0, (1.0, 0.9, 0.95)
    each, made = each_and_bound(name, [(0.1, 0.0), (0.6, 0.1), (1.5, 0.02)], weights, reach_m, most=most)
    rng = np.random.default_rng(6)
    cos, way_m = np.cos(rng.uniform(0.0, 0.5 * np.pi, 20_000)), rng.uniform(0.0, 3.0, 20_000)
    seen = np.array([w * beams.intensity_per_sr(cos, one, way_m) for w, one in zip(weights, each, strict=True)])
    bound, sign = beams.intensity_per_sr(cos, made, way_m), 1.0 if most else -1.0
    assert np.all(sign * (bound - seen) >= -1e-12 * seen.max())
    extreme = seen.max(axis=0) if most else seen.min(axis=0)
    if name != "disc":  # and near what it bounds
        assert np.median(np.abs(bound / np.maximum(extreme, 1e-9) - 1.0)) < 0.02


DOME = PortShape(is_dome=True, outer_radius_m=0.1, thickness_m=0.0, n_glass=1.5, gap_m=0.0, n_water=1.34)
ONE_LAMP = Lamps((0.0,), (0.4,), (0.0,), ((0.0, -np.sin(0.2), np.cos(0.2)),), (1.0,))
LOSS = build_path_table(
    np.ones(1), wavelength_nm=None, k_lamp_per_m=np.array([0.3]), c_camera_per_m=np.array([0.5]),
    lamp_range_m=(1e-3, 50.0), camera_range_m=(0.0, 50.0),
)  # fmt: skip


@pytest.mark.parametrize("name", ["narrow", "disc", "cone", "profile that ends lit"])
def test_means_of_a_widened_lobe_are_those_of_many_points(name: str) -> None:
    # sharp edges: 1e6 midpoints without regard to them, good to 3e-4 here
    made = widened(LOBES[name], [Turned(1.5, 0.15, henyey_greenstein(0.9))])
    lit: dict[str, Any] = dict(shape=DOME, range_m=2.0, lamps=ONE_LAMP, beam=made)
    half = np.array([0.7])
    mean = field_mean(half, half, table=LOSS, **lit)[0]
    known = points_mean(made, half[0])
    assert mean == pytest.approx(known, rel=5e-4)


def points_mean(beam: beams.Beam, half: float) -> float:
    """Mean of cos^4 I cos / r^2 exp(-K r - c r_c) over the image, point by point."""
    node = ((np.arange(1000) + 0.5) / 500 - 1.0) * half
    u, v = np.meshgrid(node, node, indexing="ij")
    reach, secant2 = 2.1, 1 + u * u + v * v
    x, y = reach * u, reach * v
    lamp_m = np.sqrt(x * x + (y - 0.4) ** 2 + 4.0)
    cos_beam = ((y - 0.4) * -np.sin(0.2) + 2.0 * np.cos(0.2)) / lamp_m
    loss = np.exp(-0.3 * lamp_m - 0.5 * (reach * np.sqrt(secant2) - 0.1))
    return float(np.mean(beams.intensity_per_sr(cos_beam, beam) * 2.0 / lamp_m**3 * loss / secant2**2))


@pytest.mark.parametrize("name", ["narrow", "spot", "disc", "cone", "wide", "profile"])
def test_backscatter_of_a_widened_lobe_is_that_of_its_parts(name: str) -> None:
    # its own share and the halo apart, each by rules fit for it; and the mean of 20 x 20 pixels, of a spot 48 x 48
    made = widened(LOBES[name], [Turned(1.5, 0.15, henyey_greenstein(0.9))])
    assert made.widening is not None
    own, halo = (beams.widened_by(made, made.widening.alone(part)) for part in ("own", "halo"))
    scatterers = (Scatterer(lambda cos: scattering.look_up(cos, henyey_greenstein(0.9)), LOSS),)
    lit: dict[str, Any] = dict(shape=DOME, range_m=2.0, lamps=ONE_LAMP, scatterers=scatterers)
    node, weight = np.polynomial.legendre.leggauss(48 if name == "spot" else 20)
    u, v = np.meshgrid(0.7 * node, 0.7 * node)
    parts = sum(backscatter_gain(u, v, beam=one, order=96, **lit) for one in (own, halo))
    got = backscatter_gain(u, v, beam=made, **lit)
    assert got == pytest.approx(parts, rel=1e-3)
    half = np.array([0.7])
    mean = mean_backscatter(half, half, beam=made, **lit)[0]
    assert mean == pytest.approx(float(weight @ parts @ weight) / 4, rel=0.02 if name in ("disc", "cone") else 1e-3)

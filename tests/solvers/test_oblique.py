"""Oblique views: the search against enumeration with the pitch drawn, and each of its bounds against what it bounds."""

from __future__ import annotations

import numpy as np
import pytest
from agreement import agree
from random_cases import CASES, case, enumerated, ranked
from test_large import outlines_hold
from thorough import drawn

from uwopt.model.imaging import FARTHEST, PortShape, floor_point, ray_spread
from uwopt.solvers.exact import large, port_groups, tree
from uwopt.solvers.exact import search as exact_search
from uwopt.solvers.exact.imagers import enumerate_imagers
from uwopt.solvers.exact.light_tables import FieldTables
from uwopt.solvers.exact.oblique import crowding, path_and_field, reach_of

SOME = drawn((14,), CASES)


@pytest.mark.usefixtures("batches")
@pytest.mark.parametrize("seed", SOME)
def test_search_of_oblique_views_equals_enumeration(seed: int) -> None:
    made = case(seed, oblique=True)
    agree(made, made.solve()[1], ranked(enumerated(seed, oblique=True)))


@pytest.mark.parametrize("seed", SOME)
def test_search_of_a_large_catalogue_of_oblique_views_equals_that_of_a_small_one(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = case(seed, oblique=True)
    small = made.solve()[1]
    monkeypatch.setattr(exact_search, "MOST_IMAGERS", 0)
    monkeypatch.setattr(port_groups, "BRANCHES", 2)
    for module, name, value in (
        (tree, "FIRST_ROWS", 1), (tree, "LARGEST_ROWS", 4), (large, "FIRST_LEAVES", 1), (large, "LARGEST_LEAVES", 2),
    ):  # fmt: skip
        monkeypatch.setattr(module, name, value)
    found = made.solve()[1]
    assert found.account.adds_up() and found.complete
    assert [one.minimised for one in found.best] == pytest.approx([one.minimised for one in small.best], rel=1e-9)


@pytest.mark.parametrize("seed", drawn((9, 14, 20, 117), tuple(range(300))))
def test_outlines_of_oblique_views_bound_their_imagers(seed: int) -> None:
    outlines_hold(case(seed, oblique=True).problem())


@pytest.mark.parametrize("seed", drawn((4, 9, 14, 102, 117), tuple(range(300))))
def test_no_oblique_image_gets_more_light_than_its_bounds(seed: int) -> None:
    problem = case(seed, oblique=True).problem()
    imagers = enumerate_imagers(problem)
    if len(imagers) == 0:
        pytest.skip("no imager")
    tables = FieldTables(problem, imagers)
    rows = np.arange(len(imagers))
    for lighting in tables.lightings:
        for index, scene in enumerate(problem.scenes):
            exact = tables.exact(index, lighting, rows, veils="none").signal_e
            for altitude in {scene.nominal, len(scene.range_m) - 1}:
                assert (tables.bound(index, lighting, altitude, rows) >= exact[:, altitude] * (1 - 1e-9)).all()


@pytest.mark.parametrize("is_dome", [True, False])
def test_traced_rays_stay_within_what_is_said_of_oblique_images(is_dome: bool) -> None:
    # Samples per area are 1 / (4 U V J), J the Jacobian of traced floor points by central differences.
    rng, tried, way = np.random.default_rng(3), 0, np.linspace(-1.0, 1.0, 21)
    while tried < 60:
        radius, thickness, gap = 10.0 ** rng.uniform((-2.5, -3.3, -4.0), (-0.3, -1.5, -1.0), (3, 3)).T
        glass, n_water = rng.uniform(1.4, 1.78, 3), rng.uniform(1.33, 1.36)
        (wide_u, wide_v), range_m = rng.uniform(0.02, 2.0, 2), 10.0 ** rng.uniform(-1.2, 1.0)
        slope = np.tan(rng.uniform(0.01, 1.3))
        if tried % 2:  # one port alone, whose bounds are the tightest
            radius, thickness, glass, gap = (np.repeat(c[:1], 3) for c in (radius, thickness, glass, gap))
        columns = (radius, thickness, glass, gap)
        own, least, most = (
            PortShape(is_dome, *(float(end) for end in ends), n_water, slope=slope)
            for ends in (
                [c[0] for c in columns], [radius.min(), thickness.min(), glass.max(), gap.min()],
                [radius.max(), thickness.max(), glass.min(), gap.max()],
            )
        )  # fmt: skip
        if 1.0 - slope * wide_u * ray_spread(wide_u**2, own)[1] < 1.0 / FARTHEST:
            continue

        def place(u: np.ndarray, v: np.ndarray, shape: PortShape = own, d: float = range_m) -> np.ndarray:
            x_m, y_m, path_m = floor_point(u, v, shape=shape, range_m=d)
            return np.array([x_m * np.hypot(1.0, shape.slope), y_m, path_m])

        u, v = np.meshgrid(wide_u * way, wide_v * way, indexing="ij")
        along, across, path_m = place(u, v)
        if path_m.min() <= 0.0:  # the plane cuts the port
            continue
        tried += 1
        by_u, by_v = (place(u + a, v + b)[:2] - place(u - a, v - b)[:2] for a, b in ((1e-6, 0.0), (0.0, 1e-6)))
        samples = (2e-6) ** 2 / (4.0 * wide_u * wide_v * np.abs(by_u[0] * by_v[1] - by_u[1] * by_v[0]))
        deepest = radius if is_dome else (gap + thickness) * np.sqrt(n_water**2 + (n_water**2 - 1.0) * 8.0)
        plane = {"slope": slope, "range_m": range_m, "deepest_m": float(deepest.max())}
        reach = reach_of(np.array([wide_u]), np.array([wide_v]), least=least, most=most, range_m=range_m)
        assert (samples <= reach.samples_per_m2 * crowding(along, **plane) * (1 + 1e-6)).all()
        ahead, slack = along >= 0.0, 1 + 1e-9
        assert along.max() <= reach.ahead_m * slack and -along.min() <= reach.behind_m * slack
        assert np.abs(across[ahead]).max() <= reach.across_ahead_m * slack
        assert np.abs(across[~ahead]).max() <= reach.across_behind_m * slack
        least_path_m, field2 = path_and_field((along, along), np.abs(across), **plane)
        assert (least_path_m <= path_m * slack).all() and (field2 <= (u**2 + v**2) * slack + 1e-12).all()

"""Oblique views: the search against enumeration with the pitch drawn, and each of its bounds against what it bounds."""

from __future__ import annotations

import numpy as np
import pytest
from agreement import agree
from random_cases import CASES, case, enumerated, ranked
from test_large import outlines_hold
from thorough import drawn

from uwopt.solvers.exact import large, outline
from uwopt.solvers.exact import search as exact_search
from uwopt.solvers.exact.imagers import enumerate_imagers
from uwopt.solvers.exact.light_tables import FieldTables
from uwopt.solvers.exact.signals import SignalTables

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
    monkeypatch.setattr(outline, "BRANCHES", 2)
    for name, value in (("FIRST_PAIRS", 1), ("LARGEST_PAIRS", 4), ("FIRST_LEAVES", 1), ("LARGEST_LEAVES", 2)):
        monkeypatch.setattr(large, name, value)
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
    integrated = SignalTables(tables.problem, imagers, like=tables)
    rows = np.arange(len(imagers))
    for lighting in tables.lightings:
        for index, scene in enumerate(problem.scenes):
            exact = tables.exact(index, lighting, rows, veils="none").signal_e
            for altitude in {scene.nominal, len(scene.range_m) - 1}:
                for bounds in (tables, integrated):
                    assert (bounds.bound(index, lighting, altitude, rows) >= exact[:, altitude] * (1 - 1e-9)).all()

"""The search with lenses on spacer rings, held against enumeration with the rule of rings written anew."""

from __future__ import annotations

import numpy as np
import pytest
from agreement import agree
from random_cases import case, enumerated, in_batches, ranked
from thorough import drawn

from uwopt.solvers.exact.imagers import enumerate_imagers
from uwopt.solvers.exact.outline import Level, OutlineRows
from uwopt.solvers.exact.port_groups import port_tree

CASES = drawn((34, 52), tuple(range(100)))  # a best design of each stands on a ring


@pytest.mark.parametrize(("batches", "seed"), in_batches(CASES), indirect=["batches"])
def test_search_among_rings_equals_enumeration(batches: str, seed: int) -> None:
    agree(case(seed, spaced=True), case(seed, spaced=True).solve()[1], ranked(enumerated(seed, spaced=True)))


@pytest.mark.parametrize("seed", CASES)
def test_rings_make_designs_that_cost_and_weigh_more_than_their_parts(seed: int) -> None:
    """Else the comparison above would say nothing of them; and no group of ports refuses what stands on a ring."""
    problem = case(seed, spaced=True).problem()
    imagers = enumerate_imagers(problem)
    ringed = imagers.scenes[0].focused.spacer_m > 0.0
    assert ringed.any()
    cameras, lenses, ports = problem.cameras, problem.lenses, problem.ports
    parts = cameras.price[imagers.camera] + lenses.price[imagers.lens] + ports.price[imagers.port]
    each = (imagers.cost - problem.extras[0]) / problem.mission.vehicle.camera_count - parts
    assert each == pytest.approx(np.where(ringed, 30.0, 0.0))  # USD, the class estimate's middle
    weighs = cameras.mass_kg[imagers.camera] + lenses.mass_kg[imagers.lens] + ports.mass_kg[imagers.port]
    more_kg = (imagers.mass_kg - problem.extras[1]) / problem.mission.vehicle.camera_count - weighs
    assert more_kg == pytest.approx(np.where(ringed, 0.003, 0.0))  # of the rings' class
    groups = port_tree(problem)[0]
    place = np.argsort(groups.order)[imagers.port]
    rows = OutlineRows(
        imagers.camera, imagers.lens, imagers.landscape, np.searchsorted(groups.start, place, side="right") - 1
    )
    level = Level(problem, groups)
    assert all(passes.all() for _, passes in level.rules(rows, level.imagers(rows)))

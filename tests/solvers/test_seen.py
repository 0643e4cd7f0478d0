"""What many cameras with lenses see behind a port is what each pair sees, though like pairs are worked out once."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from uwopt.api.common import prepared
from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.forward.spacers import needed_spacer_m
from uwopt.solvers.exact.imager_rules import Behind
from uwopt.solvers.exact.imagers import fitting_pairs, no_tally, sharp_behind
from uwopt.solvers.exact.seen import pairs_alike, seen_behind, seen_in_focus

PROBLEMS = Path(__file__).parents[2] / "problems"


@pytest.mark.parametrize("physics", ["full", "paper"])
def test_each_pair_of_the_catalogue_sees_what_it_sees_alone(physics: str) -> None:
    mission = prepared(PROBLEMS / "reef-mosaic.yaml", physics, None)
    problem = build_problem(mission, selected(mission, load_catalog(mission), generic="allow"))
    pairs = fitting_pairs(problem)
    assert len(np.unique(pairs_alike(problem, pairs.camera, pairs.lens)[2])) < 0.5 * len(pairs.camera)
    flat = int(np.flatnonzero(~problem.ports.is_dome)[0])
    seen, dioptre, rings_m = seen_behind(problem, pairs.camera, pairs.lens, flat, False)
    for row in np.random.default_rng(0).choice(len(pairs.camera), 60, replace=False):
        camera, lens = pairs.camera[[row]], pairs.lens[[row]]
        alone, one_dioptre = seen_in_focus(problem, camera, lens, [problem.shape(flat, 0)], False)
        assert dioptre[row] == pytest.approx(one_dioptre[0], rel=1e-13)
        ring_m = needed_spacer_m(problem.lenses, one_dioptre, rows=lens)
        assert rings_m[row] == pytest.approx(ring_m[0], rel=1e-13, nan_ok=True)
        for many, one in zip(seen, alone, strict=True):
            for column in fields(many):
                mine, own = getattr(many, column.name)[row], getattr(one, column.name)[0]
                assert mine == pytest.approx(own, rel=1e-13), column.name


def test_what_is_seen_by_pairs_that_pass_is_what_these_see_alone() -> None:
    """Rules are asked of kinds of pairs: what passes is whose image is small enough, with its own view and ring."""
    mission = prepared(PROBLEMS / "reef-mosaic.yaml", "full", None)
    problem = build_problem(mission, selected(mission, load_catalog(mission), generic="allow"))
    pairs = fitting_pairs(problem)
    flat = int(np.flatnonzero(~problem.ports.is_dome)[0])
    sharp = sharp_behind(problem, Behind(pairs.camera, pairs.lens, np.array([flat]), False), no_tally())
    assert 0 < len(sharp.camera) < 0.9 * len(pairs.camera)
    every, _, _ = seen_behind(problem, pairs.camera, pairs.lens, flat, False)
    fine = every[0].gsd_m.max(axis=1) <= 1.0e-3
    kept = set(zip(pairs.camera[fine].tolist(), pairs.lens[fine].tolist(), strict=True))
    assert kept >= set(zip(sharp.camera.tolist(), sharp.lens.tolist(), strict=True))
    seen, _, rings_m = seen_behind(problem, sharp.camera, sharp.lens, flat, False)
    np.testing.assert_array_equal(sharp.spacers_m, rings_m)
    for column in fields(seen[0]):
        mine, own = getattr(sharp.scenes[0].view, column.name), getattr(seen[0], column.name)
        np.testing.assert_allclose(mine, own, rtol=1e-13, err_msg=column.name)

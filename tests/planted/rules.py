"""Planted defects of the rules that `solve` and `evaluate` share."""

from __future__ import annotations

from planted.defect import Defect

SCENE_ORDER = "tests/solvers/test_scene_order.py"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="beams of all scenes bent in the first scene's water",
        file="uwopt/problem.py",
        old="parts.lights, [scene.n_water for scene in self.scenes], end",
        new="parts.lights, [self.scenes[0].n_water for _ in self.scenes], end",
        test=f"{SCENE_ORDER}::test_a_beam_stated_in_air_is_refracted_into_each_scenes_own_water",
    ),
    Defect(
        name="beam of the first scene's water taken in all",
        file="uwopt/problem.py",
        old="return self.optics[optics].beams[scene_index]",
        new="return self.optics[optics].beams[0]",
        test=f"{SCENE_ORDER}::test_the_order_of_scenes_changes_no_optimum[33]",
    ),
)

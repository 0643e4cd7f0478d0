"""Cameras that fly over bands of their own: what many see and focus on is what each does over its band alone."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from one_of_each import one, with_parts

from uwopt.forward.remembered import RememberedSunField
from uwopt.forward.sharpness import spread_of
from uwopt.forward.sun_light import sun_light
from uwopt.solvers.confidence.waters import over_band, over_band_of
from uwopt.solvers.exact.imagers import focused_behind, stands
from uwopt.solvers.exact.seen import seen_behind

BEYOND = np.array([0.3, 0.05, 0.3, 0.8, 0.05, 40.0])  # of the tolerance; the last would be below the floor
CAMERA = np.array([5, 0, 1, 2, 2, 3, 4])
SHARP_AT = {
    "anywhere": {}, "centre": {"min_dof_m": 0.3}, "corner": {"min_dof_m": 0.3, "dof_at": "corner"},
}  # fmt: skip
VEHICLES = {
    "level": {}, "leaning": {"pitch_deg": 20.0},
    "pair": {"camera_count": 2, "camera_baseline_m": 0.2, "camera_convergence_deg": 2.0},
}  # fmt: skip


def same(many: Any, row: int, single: Any) -> None:
    """One row of a record of columns is that of a record of one row."""
    for column in fields(many):
        assert getattr(many, column.name)[row] == pytest.approx(getattr(single, column.name)[0], rel=1e-13), column.name


@pytest.mark.parametrize("flat", [False, True])
@pytest.mark.parametrize("sharp", SHARP_AT)
@pytest.mark.parametrize("vehicle", VEHICLES)
def test_each_camera_sees_what_it_sees_over_its_band_alone(vehicle: str, sharp: str, flat: bool) -> None:
    """All but two of the cameras are alike, and twice one stands behind two lenses."""
    moved = {"altitude_tolerance_m": 0.4, "pitch_rate_deg_s": 2.0, **VEHICLES[vehicle]}
    case = one(wanted={"max_blur_px": 1.0, **SHARP_AT[sharp]}, vehicle=moved, flat=flat, scenes=({}, {"depth_m": 90.0}))
    others = [{}, {}, {"pixel_pitch_um": 3.0}, {}, {"resolution_x_px": 1500}]
    case = with_parts(case, cameras=others, lenses=[{"focal_length_mm": 6.0}])
    problem = case.problem()
    assert len(problem.cameras.price) == len(BEYOND) and over_band(problem.scenes[0], BEYOND).range_m[0].min() > 0.0
    lens = np.array([0, 0, 0, 0, 1, 1, 0])

    def made(beyond: Any, camera: Any, lens: Any) -> tuple[Any, ...]:
        wide = over_band_of(problem, beyond)
        seen, dioptre, rings_m = seen_behind(wide, camera, lens, 0, True)
        focused = focused_behind(wide, camera, lens, 0, seen, stands(wide, camera, lens, dioptre), rings_m)
        return seen, focused

    together = made(BEYOND, CAMERA, lens)
    swaths = together[0][0].footprint_across_m
    assert len(np.unique(swaths[:, 2])) > len(np.unique(swaths[:, 1])) > 1  # they do see different things
    for row, camera in enumerate(CAMERA):
        for many, single in zip(together, made(float(BEYOND[camera]), CAMERA[[row]], lens[[row]]), strict=True):
            for of_many, of_one in zip(many, single, strict=True):
                same(of_many, row, of_one)


def test_a_band_of_its_own_is_that_band() -> None:
    scene = one(vehicle={"altitude_tolerance_m": 0.4}).problem().scenes[0]
    every = over_band(scene, BEYOND).range_m
    for place, beyond in enumerate(BEYOND):
        assert every[:, place] == pytest.approx(over_band(scene, float(beyond)).range_m, rel=1e-15)
    assert over_band(scene, np.zeros(3)) is scene


def test_tables_of_a_wider_band_are_kept_and_are_those_of_that_band() -> None:
    """Asked for other things a scene has the same memory; another band has what a scene that was never asked has."""
    under_sun = {"sun_lux": 80_000.0, "depth_m": 6.0}
    made = one(vehicle={"altitude_tolerance_m": 0.4}, flat=True, scenes=(under_sun,)).problem()
    view, first = seen_behind(made, np.zeros(1, int), np.zeros(1, int), 0, True)[0][0], np.zeros(1, int)

    def colours(problem: Any) -> Any:
        wider = over_band_of(problem, 0.3)
        return spread_of(wider.scenes[0], wider.contractions[0], 0, 0)

    def signal(problem: Any, beyond: float) -> Any:
        seen = sun_light(
            over_band_of(problem, beyond).reaching([10.0]), 0, view, first, port_index=first, mount=problem.mounts[0],
            count=1, field_type=RememberedSunField,
        )  # fmt: skip
        assert seen is not None
        return seen.signal_e_s

    asked = made.mission.with_changes(requirements={**made.mission.to_dict()["requirements"], "max_blur_px": 2.0})
    assert colours(made.asking(asked)) is colours(made)
    fresh = made.in_scenes([replace(scene, cache={}) for scene in made.scenes])
    near = signal(made, 0.3)
    assert signal(made, 0.8) == pytest.approx(signal(fresh, 0.8), rel=1e-12)
    assert signal(made, 0.8)[0, -1] < 0.99 * near[0, -1]

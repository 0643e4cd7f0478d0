"""Distances in water to which a person sets a focus, and whether a lens stands at one of them."""

from __future__ import annotations

import math

import numpy as np

from uwopt.evaluation.design_model import DesignModel
from uwopt.model.port import lens_dioptre_per_m, water_distance_m
from uwopt.results.design import FARTHEST_M

FOCUS_STEP_M = 0.01
DIGITS = 6  # that a setting is printed with: what is typed is what was checked
SAME_REL = 1e-5  # of the focus: as nearly as the digits that are typed in tell


def focus_distances_m(distance_m: float) -> list[float]:
    """Focus distances to set, the nearest first: in centimetres, within a metre in three figures."""
    step = FOCUS_STEP_M * min(1.0, 10.0 ** math.floor(math.log10(distance_m)))
    below = math.floor(distance_m / step)
    near = sorted((max(below + n, 1) for n in range(2)), key=lambda n: abs(n * step - distance_m))
    return [float(f"{n * step:.{DIGITS}g}") for n in dict.fromkeys(near)]


def focus_marks_m(model: DesignModel, dioptre_per_m: float) -> list[float]:
    """What a lens at this focus is set to, as a distance in the first scene's water, the nearest first."""
    distance_m = float(water_distance_m(dioptre_per_m, focus_map=model.maps[0]))
    return focus_distances_m(distance_m) if 0 < distance_m < FARTHEST_M else [FARTHEST_M]


def stands_at_mark(model: DesignModel, dioptre_per_m: float) -> bool:
    """Whether a lens is focused as a person would set it who means the focus of the search."""
    marks_m = focus_marks_m(model, model.searched_dioptre_per_m(0))
    rings = [float(lens_dioptre_per_m(mark_m, focus_map=model.maps[0])) for mark_m in marks_m]
    return any(bool(np.isclose(dioptre_per_m, ring, rtol=SAME_REL, atol=0.0)) for ring in rings)

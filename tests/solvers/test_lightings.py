"""Rows under many lightings at once: each has the light that it has alone."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from one_of_each import one, with_parts

from uwopt.forward.columns import placed
from uwopt.forward.lamp_light import Veils
from uwopt.solvers.exact.lightings import Under

TURBID = {"water": "5C", "water_table": "measured"}
PLACED = {"altitude_m": 1.5, "altitude_tolerance_m": 0.2, "light_baseline_m": [0.4, 0.8], "light_count": [1, 2]}


def test_beams_wide_and_narrow_in_the_same_rows_keep_each_its_light_and_its_bounds() -> None:
    """A coarse integral tells nothing of the narrow one's veil, whose bounds are then none and no end."""
    made = with_parts(
        one(light={"beam_angle_deg": 110.0}, scenes=(TURBID,), vehicle=PLACED), lights=[{"beam_angle_deg": 20.0}],
        lenses=[{"focal_length_mm": 12.0}],
    )  # fmt: skip
    search = made.searcher()
    imagers, lightings = search.prepare(), search.tables.lightings
    lighting, imager = (part.ravel() for part in np.indices((len(lightings), len(imagers))))
    shuffled = np.random.default_rng(0).permutation(len(lighting))
    under, imager = Under(lightings, lighting[shuffled]), imager[shuffled]
    assert len(set(under.index.tolist())) > 2
    known, told, whole = None, set[bool](), search.tables.in_scene(0, under, imager)
    for veils in get_args(Veils)[:3]:
        known = search.tables.in_scene(0, under, imager, veils=veils, known=known)
        for row, k in enumerate(under.index):
            alone = search.tables.exact(0, lightings[k], imager[row : row + 1], veils=veils)
            assert alone.signal_e[0] == pytest.approx(known.signal_e[row], rel=1e-12)
            if veils == "coarse":
                assert known.most_veil_e is not None and known.backscatter_e is not None and whole.veil_e is not None
                assert np.all(known.veil_e[row] <= whole.veil_e[row] * (1 + 1e-9))
                assert np.all(whole.veil_e[row] <= known.most_veil_e[row] * (1 + 1e-9))
                told.add(bool(np.isfinite(known.most_veil_e[row]).all()))
    assert told == {True, False}


def test_a_column_that_some_rows_alone_have_is_a_defect() -> None:
    here, there = np.arange(2), np.arange(2, 3)
    for one_has, other_has in ((np.ones(2), None), (None, np.ones(1))):
        with pytest.raises(TypeError, match="others have not"):
            placed([(here, one_has), (there, other_has)], 3)
    assert placed([(here, None), (there, None)], 3) is None

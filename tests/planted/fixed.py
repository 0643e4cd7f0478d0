"""Planted defects of settings that a mission fixes."""

from __future__ import annotations

from planted.defect import Defect

TESTS = "tests/solvers/test_fixed.py"
NOTHING_BETTER = f"{TESTS}::test_nothing_that_is_tried_is_better_than_what_is_found"

DEFECTS = (
    Defect(
        name="a fixed exposure may be shorter",
        file="uwopt/forward/fixed_settings.py",
        old="min_exposure_s=np.maximum(cameras.min_exposure_s, fixed_s),",
        new="min_exposure_s=cameras.min_exposure_s,",
        test=f"{TESTS}::test_what_is_fixed_altogether_is_what_evaluate_says[fixed1-False]",
    ),
    Defect(
        name="saturation at a fixed gain is that at unit gain",
        file="uwopt/solvers/settings/windows.py",
        old="scale = (headroom_dn / rows.least_dn_per_e)[:, None] - dark",
        new="scale = (headroom_dn / rows.gain_dn_per_e)[:, None] - dark",
        test=f"{NOTHING_BETTER}[{{'f_number': 2.5, 'gain': 70.0}}-snr_db]",
    ),
    Defect(
        name="a lamp without the fixed level stays",
        file="uwopt/forward/fixed_settings.py",
        old="        return nearest, nearest\n",
        new="        return 0.0, 1.0\n",
        test=f"{TESTS}::test_parts_that_cannot_be_set_so_are_left_out",
    ),
    Defect(
        name="a fixed f-number binds no system",
        file="uwopt/objectives/requirements.py",
        old='("fixed_f_number", settings.f_number, fixed.f_number, ""),',
        new='("fixed_f_number", settings.f_number, None, ""),',
        test=f"{TESTS}::test_a_system_that_is_set_otherwise_misses_it",
    ),
)

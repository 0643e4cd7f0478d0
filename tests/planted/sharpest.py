"""Planted defects of what is known of fine detail where more of it is asked for than anything shows."""

from __future__ import annotations

from planted.defect import Defect

SHARPEST, RELAXER = "uwopt/solvers/infeasible/sharpest.py", "uwopt/solvers/infeasible/relaxer.py"
TESTS = "tests/solvers/test_sharpest.py"
OF_PARTS = f"{TESTS}::test_no_camera_with_a_lens_leaves_more_than_its_pixels_its_pupil_and_its_glass"
OF_IMAGERS = f"{TESTS}::test_what_an_imager_reaches_at_any_f_number_is_within_its_bound"
TOLD = f"{TESTS}::test_detail_that_no_parts_show_is_told_to_have_to_give_without_a_search_for_all_else"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="more contrast at half Nyquist is asked for than pixels leave",
        file="uwopt/mission/sections/requirements.py",
        old="if value > PIXEL_MTF:",
        new="if value > 1.0:",
        test="tests/mission/test_mission.py::test_a_bad_mission_is_told_in_words",
    ),
    Defect(
        name="the pupil that diffracts least is not that of the widest opening",
        file=SHARPEST,
        old="cycle_px=first * float(scene",
        new="cycle_px=last * 2.0 * float(scene",
        test=OF_PARTS,
    ),
    Defect(
        name="pixels blur nothing where the most of parts is bounded",
        file=SHARPEST,
        old="most * sinc_mtf(HALF_NYQUIST_CYC_PER_PX)",
        new="most",
        test=OF_PARTS,
    ),
    Defect(
        name="an imager is bounded by the f-number at which it diffracts most",
        file=SHARPEST,
        old="bars.best_between(every, first, last,",
        new="bars.best_between(every, 4.0 * last, last,",
        test=OF_IMAGERS,
    ),
    Defect(
        name="what may be sharpest is listed last",
        file=SHARPEST,
        old="likely[np.argsort(-self._of(likely)",
        new="likely[np.argsort(self._of(likely)",
        test=OF_IMAGERS,
    ),
    Defect(
        name="what is not sharp enough is searched",
        file=SHARPEST,
        old="return rows[(self._of(rows) >= wanted).all(axis=1)]",
        new="return np.arange(len(self.imagers))",
        test=OF_IMAGERS,
    ),
    Defect(
        name="what no parts show is searched for with less of all else",
        file=RELAXER,
        old="or not self.is_never_sharp:",
        new="or True:",
        test=TOLD,
    ),
    Defect(
        name="fine detail has to give though some parts show it",
        file=RELAXER,
        old="return bool((most < wanted).any())",
        new="return True",
        test=f"{TESTS}::test_where_some_parts_would_be_sharp_enough_other_requirements_are_asked",
    ),
    Defect(
        name="bounds do not tell how near to what is asked nothing fits",
        file="uwopt/solvers/infeasible/least_change.py",
        old="self.asked if self.beyond is None else self.beyond",
        new="self.asked",
        test="tests/solvers/test_drawn_in.py::test_what_bounds_tell_of_a_change_is_not_searched_for",
    ),
)

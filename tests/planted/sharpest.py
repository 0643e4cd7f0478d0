"""Planted defects of what is known, without a search, of how near to what is asked something may fit."""

from __future__ import annotations

from planted.defect import Defect

SHARPEST, RELAXER = "uwopt/solvers/infeasible/sharpest.py", "uwopt/solvers/infeasible/relaxer.py"
TESTS, DRAWN_IN = "tests/solvers/test_sharpest.py", "tests/solvers/test_drawn_in.py"
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
    Defect(
        name="pairs within the budget are not looked at",
        file="uwopt/solvers/infeasible/relaxed_imagers.py",
        old="+ beside <= most * ROUND]",
        new="+ beside <= 0.8 * most]",
        test=f"{DRAWN_IN}::test_pairs_that_a_limit_of_cost_allows_by_no_port_are_not_looked_at_and_no_others",
    ),
    Defect(
        name="pairs beyond the budget are looked at",
        file="uwopt/solvers/infeasible/relaxed_imagers.py",
        old="        rows = {place: self._affordable(problem.mission, own, place) for place, own in rows.items()}\n",
        new="",
        test=f"{DRAWN_IN}::test_pairs_that_a_limit_of_cost_allows_by_no_port_are_not_looked_at_and_no_others",
    ),
    Defect(
        name="the dearest are tried where the least cost is asked for",
        file="uwopt/solvers/infeasible/relaxed_imagers.py",
        old="np.argsort(self._pair_prices[every[place]],",
        new="np.argsort(-self._pair_prices[every[place]],",
        test=f"{DRAWN_IN}::test_the_cheapest_behind_the_cheapest_ports_are_among_a_few",
    ),
    Defect(
        name="a signal in noise is not drawn in by other hardware",
        file="uwopt/solvers/infeasible/least_limit.py",
        old="if best is not None and not self.by_few and is_far(",
        new="if best is not None and self.by_few and is_far(",
        test=f"{DRAWN_IN}::test_a_signal_in_as_much_noise_is_drawn_in_by_the_best_of_a_few",
    ),
    Defect(
        name="what lets noise through comes nearest",
        file="uwopt/solvers/infeasible/why_nothing.py",
        old="(one.is_far, one.miss_rel)",
        new="one.miss_rel",
        test=f"{DRAWN_IN}::test_what_lets_only_noise_through_is_not_what_comes_nearest",
    ),
    Defect(
        name="a system that is out of reach is said to come near",
        file="uwopt/report/text/nothing_fits.py",
        old='if far else "What comes nearest"',
        new='if not first else "What comes nearest"',
        test="tests/report/test_short.py::test_nothing_fits_tells_what_would_help",
    ),
)

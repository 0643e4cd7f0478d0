"""Planted defects of the certificate: account, lower bounds, audit."""

from __future__ import annotations

from planted.defect import Defect

PIXELS = "tests/solvers/test_few_pixels.py::"
AUDIT = "tests/solvers/test_audit.py::"
CERTIFICATE = "tests/solvers/test_certificate.py::"
RULES = "tests/solvers/test_rules.py::"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="a unit is bounded by the number of lamps that lights the deciding pixel least",
        file="uwopt/solvers/exact/bounds.py",
        old="pixel_e[index] = np.max(by_count, axis=0)",
        new="pixel_e[index] = 0.5 * np.min(by_count, axis=0)",
        test="tests/solvers/test_bounds.py::test_the_pixel_that_decides_bounds_a_unit_more_sharply",
    ),
    Defect(
        name="the deciding pixel does not count in a bound",
        file="uwopt/solvers/exact/bounds.py",
        old="            if pixel_e is not None:\n",
        new="            if False:\n",
        test="tests/solvers/test_bounds.py::test_the_pixel_that_decides_bounds_a_unit_more_sharply",
    ),
    Defect(
        name="nodes that better bounds discard are not counted",
        file="uwopt/solvers/exact/search.py",
        old="value[failed] = np.inf\n                self.account.discarded[name] += int(size[failed].sum())\n",
        new="value[failed] = np.inf\n",
        test="tests/solvers/test_bounds.py::test_bounds_by_pixels_leave_the_answer_and_the_account_as_they_are",
    ),
    Defect(
        name="pixels are left out by what they ask for at the shortest exposure alone",
        file="uwopt/solvers/settings/few_pixels.py",
        old="for time in (shortest, longest))",
        new="for time in (shortest, shortest))",
        test=f"{PIXELS}test_few_pixels_ask_for_what_all_but_k_of_all_do",
    ),
    Defect(
        name="pixels that miss the SNR in any case may miss it twice",
        file="uwopt/solvers/settings/few_pixels.py",
        old="order[:, :, first:last], may_miss - first",
        new="order[:, :, first:last], may_miss",
        test=f"{PIXELS}test_few_pixels_ask_for_what_all_but_k_of_all_do",
    ),
    Defect(
        name="the lower bound is the best value itself",
        file="uwopt/solvers/exact/certificate.py",
        old="lower = outcome.lower_bound if math.isfinite(outcome.lower_bound) else None",
        new="lower = best",
        test=f"{CERTIFICATE}test_a_gap_that_is_open_is_told",
    ),
    Defect(
        name="a search cut short claims the best it found",
        file="uwopt/solvers/exact/search.py",
        old="return min(lowest, best, self.open_gap_bound), False",
        new="return best, False",
        test=f"{CERTIFICATE}test_a_search_cut_short_has_a_bound_below_what_it_found[small]",
    ),
    Defect(
        name="a large search cut short claims the best it found",
        file="uwopt/solvers/exact/large.py",
        old="return min(lowest, best, search.open_gap_bound), False",
        new="return best, False",
        test=f"{CERTIFICATE}test_a_search_cut_short_has_a_bound_below_what_it_found[large]",
    ),
    Defect(
        name="a search out of time has no bound",
        file="uwopt/solvers/exact/search.py",
        old="return float(value[rest].min())",
        new="return np.inf",
        test=f"{CERTIFICATE}test_a_search_out_of_time_has_the_bound_of_the_next_unit",
    ),
    Defect(
        name="a gap of settings that is open is called closed",
        file="uwopt/solvers/exact/search.py",
        old="min(self.open_gap_bound, float(best.lower_bound.min(initial=np.inf)))",
        new="self.open_gap_bound",
        test=f"{CERTIFICATE}test_a_gap_of_settings_is_left_in_the_bound",
    ),
    Defect(
        name="combinations of parts that are out count twice",
        file="uwopt/solvers/exact/certificate.py",
        old="left[kind] -= count",
        new="left[kind] -= 0 * count",
        test=f"{CERTIFICATE}test_every_combination_is_counted_once_by_hand",
    ),
    Defect(
        name="a certificate may count more than there is",
        file="uwopt/results/result.py",
        old="return self.loaded == self.evaluated + sum(",
        new="return self.loaded <= self.evaluated + sum(",
        test=f"{CERTIFICATE}test_an_account_that_counts_twice_does_not_add_up",
    ),
    Defect(
        name="a search may count more than there is",
        file="uwopt/solvers/exact/account.py",
        old="return self.total == self.evaluated + sum(",
        new="return self.total <= self.evaluated + sum(",
        test=f"{CERTIFICATE}test_the_search_holds_its_account_against_all_combinations[6-discarded1-False]",
    ),
    Defect(
        name="what is over budget also counts as evaluated",
        file="uwopt/solvers/exact/search.py",
        old="self.account.evaluated += len(keep)",
        new="self.account.evaluated += len(node)",
        test=f"{RULES}test_a_search_that_does_not_bound_drops_designs_over_budget[cost]",
    ),
    Defect(
        name="what is searched also counts as bounded",
        file="uwopt/solvers/exact/search.py",
        old='self.account.discarded["bound"] += every * (len(rows) - len(useful))',
        new='self.account.discarded["bound"] += every * len(rows)',
        test=f"{RULES}test_a_search_counts_what_cannot_win[small]",
    ),
    Defect(
        name="the audit calls only a gain of 5 % a defect",
        file="uwopt/tolerances.py",
        old="BEATS_REL = 1e-6",
        new="BEATS_REL = 0.05",
        test=f"{AUDIT}test_it_sees_a_gain_of_one_percent",
    ),
    Defect(
        name="the audit looks away",
        file="uwopt/solvers/exact/audit.py",
        old='"passed": not better,',
        new='"passed": True,',
        test=f"{AUDIT}test_it_finds_a_lens_that_was_thrown_away[power]",
    ),
    Defect(
        name="the audit knows no contrast",
        file="uwopt/solvers/exact/attack.py",
        old="            contrast, information,\n",
        new="            0.0 * contrast, information,\n",
        test=f"{AUDIT}test_it_finds_a_lens_that_was_thrown_away[contrast]",
    ),
    Defect(
        name="the audit knows no information",
        file="uwopt/solvers/exact/attack.py",
        old="            contrast, information,\n",
        new="            contrast, 0.0 * information,\n",
        test=f"{AUDIT}test_it_finds_a_lens_that_was_thrown_away[information]",
    ),
    Defect(
        name="the audit finds nothing feasible",
        file="uwopt/solvers/exact/attack.py",
        old="EXACT_REL, LEAST_SIZE = 1e-9, 1e-3",
        new="EXACT_REL, LEAST_SIZE = -1.0, 1e-3",
        test=f"{AUDIT}test_it_passes_an_honest_search[power]",
    ),
    Defect(
        name="the audit takes gains from tolerances",
        file="uwopt/solvers/exact/attack.py",
        old="EXACT_REL, LEAST_SIZE = 1e-9, 1e-3",
        new="EXACT_REL, LEAST_SIZE = 1e-3, 1e-3",
        test=f"{AUDIT}test_the_attack_takes_nothing_from_a_tolerance",
    ),
    Defect(
        name="the audit counts the better scene",
        file="uwopt/solvers/exact/attack.py",
        old="np.min(by_scene, axis=0)",
        new="np.max(by_scene, axis=0)",
        test=f"{AUDIT}test_it_passes_an_honest_search_elsewhere[contrast-two]",
    ),
    Defect(
        name="the audit draws nothing beside the best",
        file="uwopt/solvers/exact/audit.py",
        old="beside = [] if not best else",
        new="beside = [] if best else",
        test=f"{AUDIT}test_it_finds_a_lamp_that_was_thrown_away",
    ),
    Defect(
        name="the audit draws no pairs that do not fit",
        file="uwopt/solvers/exact/imagers.py",
        old="samples[rule] = sampled_pairs(problem, lost)",
        new="samples[rule] = []",
        test=f"{AUDIT}test_pairs_that_do_not_fit_are_drawn_too",
    ),
    Defect(
        name="the audit cannot meet a level without gain",
        file="uwopt/solvers/exact/attack.py",
        old="LEVEL_STEPS = 4",
        new="LEVEL_STEPS = 0",
        test=f"{AUDIT}test_the_attack_meets_a_level_without_gain",
    ),
    Defect(
        name="the audit holds a search cut short to more than its bound",
        file="uwopt/solvers/exact/audit.py",
        old="a.value < (open_from if a.rule == BESIDE else most)",
        new="a.value < most",
        test=f"{AUDIT}test_a_search_cut_short_is_held_to_its_bound_beside_the_best[1.0-True]",
    ),
    Defect(
        name="the audit excuses whatever a search cut short says of its bound",
        file="uwopt/solvers/exact/audit.py",
        old="a.value < (open_from if a.rule == BESIDE else most)",
        new="a.value < most and a.rule != BESIDE",
        test=f"{AUDIT}test_a_search_cut_short_is_held_to_its_bound_beside_the_best[1.005-False]",
    ),
)

"""Planted defects of manners: time limits, files, terminals."""

from __future__ import annotations

from planted.defect import Defect

DEADLINE = "tests/test_deadline.py"
SEARCH_DEADLINE = "tests/solvers/test_search_deadline.py"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="progress in a log comes once and never again",
        file="uwopt/report/console.py",
        old="            self._wait(LINE_EVERY_S, self._line)\n\n",
        new="\n",
        test="tests/report/test_console.py::test_a_log_gets_a_line_each_time_the_timer_rings",
    ),
    Defect(
        name="a batch that time cuts short stays counted",
        file="uwopt/solvers/exact.py",
        old="                self.account.evaluated, self.account.discarded = before\n                rest =",
        new="                rest =",
        test=f"{SEARCH_DEADLINE}::test_wherever_time_ends_bound_and_account_hold",
    ),
    Defect(
        name="a search looks at the clock between batches only",
        file="uwopt/solvers/exact.py",
        old="        self.deadline.check()\n        imager, cost",
        new="        imager, cost",
        test=f"{SEARCH_DEADLINE}::test_time_that_ends_within_a_batch_ends_it",
    ),
    Defect(
        name="explanations know no time limit",
        file="uwopt/solvers/infeasible.py",
        old="        if deadline.passed():",
        new="        if False:",
        test=f"{DEADLINE}::test_time_that_ends_with_the_search_leaves_infeasibility_unexplained",
    ),
    Defect(
        name="what there was no time for is not told",
        file="uwopt/deadline.py",
        old="            self.left_out.append(what)\n",
        new="",
        test=f"{DEADLINE}::test_what_has_no_time_is_left_out_and_told",
    ),
    Defect(
        name="each solver of a front has all the time",
        file="uwopt/api_pareto.py",
        old="self.deadline.left_s / n_waiting if self.limited",
        new="self.deadline.left_s if self.limited",
        test=f"{DEADLINE}::test_solvers_of_a_front_share_the_time",
    ),
)

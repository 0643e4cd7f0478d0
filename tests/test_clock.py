"""No test rests on the clock: a loaded machine is no failure."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

TESTS = Path(__file__).parent
LIMITS = ("seconds", "max_seconds", "deadline_s")
SHORT = 1e-3  # of no time at all every machine makes the same
#: Files in which searches may be stopped by the clock, and why no verdict depends on it.
MAY_STOP = {
    "fuzz/test_files.py": "sound results and refusals are all that is asked, also of a search that was stopped",
    "bench/test_run.py": "what is told is how time is shared among suites that do nothing",
    "test_deadline.py": "limits themselves are tested, by a clock made for it",
}


def sets_up_hypothesis(call: ast.Call) -> bool:
    """Whether it is settings of Hypothesis that a call makes."""
    return ast.unparse(call.func).rpartition(".")[2] in ("settings", "register_profile")


def limits_in(source: str) -> Iterator[tuple[int, str]]:
    """Line and text of every call that sets a time limit, or a deadline of Hypothesis.

    What names none of them is not read as Python: a keyword stands in full where it is given.
    """
    if not any(name in source for name in (*LIMITS, "deadline")):
        return
    for call in (node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call)):
        for given in call.keywords:
            value = given.value.value if isinstance(given.value, ast.Constant) else None
            number = isinstance(value, int | float) and not isinstance(value, bool)
            timed = given.arg in LIMITS and number and value > SHORT
            hasty = given.arg == "deadline" and value is not None and sets_up_hypothesis(call)
            if timed or hasty:
                yield call.lineno, ast.unparse(call)


@pytest.mark.parametrize(
    ("source", "number"),
    [
        ("uwopt.pareto(MISSION, seconds=2.0)", 1), ("population_front(search, seconds=30, seed=1)", 1),
        ("@settings(max_examples=3, deadline=200)\ndef test(): ...", 1), ("hypothesis.settings(deadline=50)", 1),
        ("Budget(quick=True, seconds=math.inf)", 0), ("solve(m, seconds=None)", 0), ("pareto(m, seconds=1e-9)", 0),
        ("settings(deadline=None)", 0), ("Search(problem, deadline=Deadline.after(0.0))", 0),
    ],
)  # fmt: skip
def test_limits_are_found_in_a_tests_source(source: str, number: int) -> None:
    assert len(list(limits_in(source))) == number


def test_no_search_that_must_end_is_given_a_time() -> None:
    found = [
        f"{path.relative_to(TESTS).as_posix()}:{line}: {text}"
        for path in sorted(TESTS.rglob("*.py"))
        if path.relative_to(TESTS).as_posix() not in MAY_STOP
        for line, text in limits_in(path.read_text(encoding="utf-8"))
    ]
    assert found == []


def test_exceptions_are_files_that_set_limits() -> None:
    for name in MAY_STOP:
        assert list(limits_in((TESTS / name).read_text(encoding="utf-8"))), f"{name} needs no exception"


def test_hypothesis_waits_as_long_as_it_takes() -> None:
    assert settings.default is not None and settings.default.deadline is None

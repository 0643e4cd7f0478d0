"""Planted defects fit the program as it is; that tests catch them shows `python tests/planted/run.py`."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Sequence
from functools import cache
from itertools import groupby
from operator import attrgetter
from pathlib import Path

import pytest
from planted.defect import Defect, all_defects
from planted.run import fault_of

ROOT = Path(__file__).parents[1]

DEFECTS = all_defects()
FILE = attrgetter("file")
LEAST = 60


@cache
def test_names(file: Path) -> frozenset[str]:
    """Names of the test functions of a file, those of classes as `Class::test`."""
    found = set()
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef):
            found.add(node.name)
        if isinstance(node, ast.ClassDef):
            found |= {f"{node.name}::{one.name}" for one in node.body if isinstance(one, ast.FunctionDef)}
    return frozenset(name for name in found if name.rpartition("::")[2].startswith("test_"))


test_names.__test__ = False  # type: ignore[attr-defined]


def fault_in_patch(defect: Defect, sound: str) -> str:
    """What is wrong with a patch as it stands, empty if nothing is."""
    try:
        changed = defect.applied(sound)
        if defect.file.endswith(".py"):
            compile(changed, defect.file, "exec", ast.PyCF_ONLY_AST)
    except (SyntaxError, ValueError) as fault:
        return f"{defect.name}: {fault}"
    return ""


def faults_in_patches(some: Sequence[Defect], sound: str) -> list[str]:
    """What is wrong with patches of one file: all that fit beside each other at once, alone where that is no Python."""
    together, free = sound, []
    for defect in some:
        if together.count(defect.old) == sound.count(defect.old) == 1 and defect.old != defect.new:
            together = together.replace(defect.old, defect.new)
            free.append(defect)
    try:
        if not some[0].file.endswith(".py"):
            raise SyntaxError
        compile(together, some[0].file, "exec", ast.PyCF_ONLY_AST)
    except SyntaxError:
        free = []
    return [fault_in_patch(defect, sound) for defect in some if defect not in free]


def test_defects_fit_their_files_and_leave_python():
    faults = []
    for file, some in groupby(sorted(DEFECTS, key=FILE), key=FILE):
        faults += faults_in_patches(list(some), (ROOT / file).read_text(encoding="utf-8"))
    assert [fault for fault in faults if fault] == []


def test_defects_name_tests_that_exist():
    assert [defect.name for defect in DEFECTS if not defect.tests] == []
    named = {node: defect.name for defect in DEFECTS for node in defect.tests}
    missing = []
    for node, name in named.items():
        file, _, test = node.partition("::")
        known = test_names(ROOT / file) if (ROOT / file).is_file() else frozenset()
        missing += [f"{name}: {node}"] * (test.partition("[")[0] not in known)
    assert missing == []


def test_defects_name_cases_that_exist(request: pytest.FixtureRequest):
    """Of files that are read in this run: where it takes only some of their tests, nothing is known of the others."""
    if any("::" in word for word in request.config.args) or request.config.option.keyword:
        pytest.skip("some tests alone are asked for")
    known = {item.nodeid for item in request.session.items}
    files = {node.partition("::")[0] for node in known}
    named = [(defect.name, node) for defect in DEFECTS for node in defect.tests if node.endswith("]")]
    assert [one for one in named if one[1].partition("::")[0] in files and one[1] not in known] == []


def test_a_patch_that_leaves_no_python_is_told():
    broken = Defect("broken", "x.py", "a = 1", "a = (", "t")
    assert fault_in_patch(broken, "a = 1").startswith("broken: ")
    assert "stands 0 times" in fault_in_patch(broken, "b = 1")
    sound, same = Defect("sound", "x.py", "c", "d", "t"), Defect("same", "x.py", "c = 1", "c = 1", "t")
    assert "was never closed" in faults_in_patches([sound, broken], "a = 1\nc = 2")[1]
    assert "the same" in "".join(faults_in_patches([same], "c = 1"))


def test_each_defect_has_a_name_of_its_own():
    assert [name for name, count in Counter(defect.name for defect in DEFECTS).items() if count > 1] == []


def test_no_defect_is_planted_twice():
    patches = Counter((defect.file, defect.old, defect.new) for defect in DEFECTS)
    assert [patch for patch, count in patches.items() if count > 1] == []


def test_there_are_enough_defects():
    assert len(DEFECTS) >= LEAST


def test_patch_that_does_not_fit_is_an_error():
    with pytest.raises(ValueError, match="stands 2 times"):
        Defect("twice", "x.py", "a", "b", "t").applied("a a")
    with pytest.raises(ValueError, match="the same"):
        Defect("same", "x.py", "a", "a", "t").applied("a")


@pytest.mark.parametrize(
    ("code", "told"), [(1, ""), (0, "lives"), (2, "was not run"), (4, "was not run"), (None, "did not end")]
)
def test_only_a_failed_test_catches_a_defect(code: int | None, told: str):
    fault = fault_of("tests/test_x.py::test_y", code, "")
    assert told in fault
    assert bool(fault) is (code != 1)

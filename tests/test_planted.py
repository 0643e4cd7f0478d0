"""Planted defects fit the program as it is; that tests catch them shows `python tests/planted/run.py`."""

from __future__ import annotations

import ast
import importlib.util
import sys
from collections import Counter
from functools import cache
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parent

if "planted" not in sys.modules:  # tests are imported without packages
    spec = importlib.util.spec_from_file_location("planted", HERE / "planted" / "__init__.py")
    assert spec is not None and spec.loader is not None
    sys.modules["planted"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules["planted"])

from planted.defect import Defect, all_defects  # noqa: E402
from planted.run import fault_of  # noqa: E402

DEFECTS = all_defects()
EACH = pytest.mark.parametrize("defect", DEFECTS, ids=[defect.name for defect in DEFECTS])
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


@EACH
def test_defect_fits_its_file_and_still_compiles(defect: Defect):
    sound = (ROOT / defect.file).read_text(encoding="utf-8")
    changed = defect.applied(sound)
    if defect.file.endswith(".py"):
        compile(changed, defect.file, "exec")


@EACH
def test_defect_names_tests_that_exist(defect: Defect):
    assert defect.tests
    for node in defect.tests:
        file, _, name = node.partition("::")
        assert (ROOT / file).is_file(), node
        assert name.partition("[")[0] in test_names(ROOT / file), node


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

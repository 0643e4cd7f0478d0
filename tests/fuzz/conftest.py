"""Fuzzing: NumPy's floating-point errors raised, warnings as errors, the same examples in every run.

`UWOPT_FUZZ=20 .venv/bin/pytest tests/fuzz` draws 50 times as many examples, new ones in each run.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

TESTS = Path(__file__).parents[1]
HELPERS = (
    ("small_catalogues", "solvers"),
    ("extreme_cases", "extreme"),
    ("files", "fuzz"),
    ("judge", "fuzz"),
)

for stem, folder in HELPERS:
    name = f"fuzz_{stem}" if folder == "fuzz" else stem
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, TESTS / folder / f"{stem}.py")
        assert spec is not None and spec.loader is not None
        sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])


@pytest.fixture(autouse=True)
def raised() -> Iterator[None]:
    """Division by zero, overflow, invalid operations and underflow raise."""
    with np.errstate(all="raise"):
        yield

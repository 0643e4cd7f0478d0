"""Every test here runs with NumPy's floating-point errors raised; warnings are errors everywhere."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

HELPERS = (
    ("small_catalogues", "solvers"),
    ("hand_made_rows", "solvers"),
    ("extreme_cases", "extreme"),
    ("exact_settings", "extreme"),
)

for name, folder in HELPERS:
    if name not in sys.modules:
        file = Path(__file__).parents[1] / folder / f"{name}.py"
        spec = importlib.util.spec_from_file_location(name, file)
        assert spec is not None and spec.loader is not None
        sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])


@pytest.fixture(autouse=True)
def raised() -> Iterator[None]:
    """Division by zero, overflow, invalid operations and underflow raise."""
    with np.errstate(all="raise"):
        yield

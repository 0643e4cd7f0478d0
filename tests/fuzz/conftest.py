"""Fuzzing: NumPy's floating-point errors raised, warnings as errors, the same examples in every run.

`UWOPT_FUZZ=20 .venv/bin/pytest tests/fuzz` draws 50 times as many examples, new ones in each run.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest


@pytest.fixture(autouse=True)
def raised() -> Iterator[None]:
    """Division by zero, overflow, invalid operations and underflow raise."""
    with np.errstate(all="raise"):
        yield

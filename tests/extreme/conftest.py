"""Every test here runs with NumPy's floating-point errors raised; warnings are errors everywhere."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest


@pytest.fixture(autouse=True)
def raised() -> Iterator[None]:
    """Division by zero, overflow, invalid operations and underflow raise."""
    with np.errstate(all="raise"):
        yield

"""What tests of the model share: symbols of CasADi, which its formulas take as they take numbers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import casadi
import pytest


@pytest.fixture(params=["SX", "MX"])
def symbol(request: pytest.FixtureRequest) -> Iterator[Any]:
    """A CasADi symbol, with NumPy functions made aware of CasADi for the time of one test."""
    mode = casadi.GlobalOptions.getNumpyMode()
    casadi.GlobalOptions.setNumpyMode(1)
    yield getattr(casadi, request.param).sym("x")
    casadi.GlobalOptions.setNumpyMode(mode)

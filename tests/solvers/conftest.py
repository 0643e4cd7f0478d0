"""The sizes of batches that searches are tried with."""

from __future__ import annotations

import pytest
from random_cases import BATCHES

from uwopt.solvers.exact import large, port_groups
from uwopt.solvers.exact import search as exact_search


@pytest.fixture(params=BATCHES)
def batches(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Batches as shipped are larger than a small catalogue; batches of one make every bound count.

    A large catalogue is searched from pairs of camera and lens on; here with few at a time.
    """
    if request.param == "as if large":
        monkeypatch.setattr(exact_search, "MOST_IMAGERS", 0)
        for name, value in (("FIRST_ROWS", 1), ("FIRST_LEAVES", 1), ("LARGEST_ROWS", 4), ("BRANCHES", 2)):
            monkeypatch.setattr(port_groups if name == "BRANCHES" else large, name, value)
    if request.param != "as shipped":
        for name, value in (
            ("FIRST_BATCH", 1),
            ("LARGEST_BATCH", 2),
            ("TOO_FEW_TO_BOUND", 0),
            ("FIRST_CHUNK", 2),
        ):
            monkeypatch.setattr(exact_search, name, value)
    return str(request.param)

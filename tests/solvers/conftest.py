"""The sizes of batches that searches are tried with, and a few parts of which a little too much is asked."""

from __future__ import annotations

from pathlib import Path

import pytest
from random_cases import BATCHES

from uwopt.catalog.catalogue import Catalog
from uwopt.forward.assembly import load_catalog
from uwopt.solvers.exact import large, port_groups, tree
from uwopt.solvers.exact import search as exact_search


@pytest.fixture(params=BATCHES)
def batches(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Batches as shipped are larger than a small catalogue; batches of one make every bound count.

    A large catalogue is searched from pairs of camera and lens on; here with few at a time.
    """
    if request.param == "as if large":
        monkeypatch.setattr(exact_search, "MOST_IMAGERS", 0)
        for module, name, value in (
            (tree, "FIRST_ROWS", 1), (tree, "LARGEST_ROWS", 4), (large, "FIRST_LEAVES", 1),
            (port_groups, "BRANCHES", 2),
        ):  # fmt: skip
            monkeypatch.setattr(module, name, value)
    if request.param != "as shipped":
        for name, value in (
            ("FIRST_BATCH", 1),
            ("LARGEST_BATCH", 2),
            ("FIRST_BOUNDED", 1),
            ("TOO_FEW_TO_BOUND", 0),
        ):
            monkeypatch.setattr(exact_search, name, value)
        monkeypatch.setattr(tree, "FIRST_NODES", 2)
    return str(request.param)


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with them."""
    from test_least_change import written

    return written(tmp_path_factory.mktemp("parts"))


@pytest.fixture(scope="module")
def catalog(parts: Path) -> Catalog:
    """The catalogue with these parts, read once."""
    from test_least_change import mission

    return load_catalog(mission(parts))

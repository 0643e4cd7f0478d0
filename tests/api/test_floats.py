"""What a caller sets for floats does not reach the program, and stays as it was."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import uwopt


class ReachedError(Exception):
    """The work has begun."""


@pytest.mark.parametrize(
    ("place", "call"),
    [
        ("uwopt.api.solving.prepared", lambda: uwopt.solve({})),
        ("uwopt.api.trading.prepared", lambda: uwopt.pareto({})),
        ("uwopt.api.common.load_mission", lambda: uwopt.evaluate({}, {})),
    ],
    ids=["solve", "pareto", "evaluate"],
)
def test_rules_for_floats_are_numpys_own_whatever_the_caller_sets(
    place: str, call: Callable[[], Any], monkeypatch: pytest.MonkeyPatch
):
    seen = []

    def reached(*args: Any, **kwargs: Any) -> None:
        seen.append(np.geterr())
        raise ReachedError

    monkeypatch.setattr(place, reached)
    with np.errstate(all="raise"):
        with pytest.raises(ReachedError):
            call()
        assert set(np.geterr().values()) == {"raise"}
    assert seen == [{"divide": "warn", "over": "warn", "under": "ignore", "invalid": "warn"}]

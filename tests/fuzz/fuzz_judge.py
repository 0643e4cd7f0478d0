"""What every outcome must be: a sound result, or one clean error that says where and what."""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from uwopt.errors import FaultsError, UwoptError

STATUSES = {"solve": {"optimal", "feasible", "stopped", "infeasible"}, "evaluate": {"feasible", "violated"}}
LONGEST = 1500  # characters of one fault
CODE = ("Traceback", "object at 0x", "pydantic", "dataclass", "numpy", "np.float")


def outcome(call: Callable[[], Any]) -> Any:
    """What a call returns, or the clean error it raises; anything else fails."""
    with warnings.catch_warnings(), np.errstate(all="raise"):
        warnings.simplefilter("error")
        try:
            return call()
        except UwoptError as error:
            assert_clean(error)
            return error


def assert_clean(error: UwoptError, name: str = "") -> None:
    """One message of whole sentences, with the file's name where there is a file; no chain of causes to read."""
    faults = error.faults if isinstance(error, FaultsError) else [str(error)]
    assert faults and str(error).strip()
    for fault in faults:
        assert fault.strip() and len(fault) <= LONGEST, fault
        assert ":" in fault or "=" in fault, fault  # where: what
        assert not any(word in fault for word in CODE), fault
        assert name in fault, fault
        assert all(c.isprintable() for c in fault), repr(fault)
    assert len(set(faults)) == len(faults), faults
    assert error.__cause__ is None and (error.__context__ is None or error.__suppress_context__)


def assert_sound(result: Any) -> None:
    """No NaN anywhere, JSON without infinities, a known status, margins and account that agree with it."""
    assert list(not_a_number(result)) == []
    json.dumps(result.to_dict(), allow_nan=False)
    assert result.status in STATUSES[result.command], result.status
    for design in [result.best, *result.runners_up, result.generic_alternative]:
        if design is not None:
            assert_consistent(design)
    if result.command == "evaluate":
        assert (result.status == "feasible") == result.design.feasible
        return
    assert result.certificate.adds_up()
    if result.recommendation is not None:
        assert result.recommendation.feasible, missed(result.recommendation)
        assert result.status in ("optimal", "feasible", "stopped")
        assert result.objective["value"] is not None
    else:
        assert result.status in ("infeasible", "stopped")


def assert_consistent(design: Any) -> None:
    """Feasible is that no margin is missed; a margin is met from -1e-6 of its limit on."""
    margins = [m for scene in design.scenes for m in scene.margins]
    assert design.feasible == all(m.satisfied for m in margins), missed(design)
    for m in margins:
        if m.margin is not None and m.limit is not None and not m.requirement.startswith("fits:"):
            assert m.satisfied == (m.margin >= -1e-6 * max(abs(m.limit), 0.0)) or m.margin == 0.0, m


def missed(design: Any) -> list[Any]:
    """Margins that are missed."""
    return [m for scene in design.scenes for m in scene.margins if not m.satisfied]


def not_a_number(value: Any, path: str = "") -> Iterator[str]:
    """Where records, arrays and plain values hold NaN."""
    if is_dataclass(value) and not isinstance(value, type):
        for field in fields(value):
            yield from not_a_number(getattr(value, field.name), f"{path}.{field.name}")
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from not_a_number(item, f"{path}.{key}")
    elif isinstance(value, (list, tuple)):
        for index, item in enumerate(value):
            yield from not_a_number(item, f"{path}[{index}]")
    elif isinstance(value, (float, np.floating)) and math.isnan(value):
        yield path

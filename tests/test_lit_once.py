"""Light that tests ask for again is what was integrated, and other light is integrated anew."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pytest
from lit_once import INTEGRALS, once
from thorough import THOROUGH

from uwopt.forward import lamp_light


@dataclass(frozen=True)
class Held:
    """What an integral is asked of."""

    curve: Any
    phase: Any


def integral_of(held: Held, *, order: int | None = None) -> Any:
    """Something that depends on all of it."""
    ASKED.append(order)
    return held.curve * held.phase(2.0) + (order or 0)


def grown(power: int, value: float) -> float:
    """A formula with a name."""
    return float(value**power)


ASKED: list[int | None] = []


def held(value: float = 1.0, power: int = 3) -> Held:
    """Made anew by each test that asks."""
    return Held(np.array([value, 2.0]), partial(grown, power))


def test_the_same_is_integrated_once_and_may_be_changed_by_who_asks() -> None:
    ASKED.clear()
    known = once(integral_of)
    first = known(held())
    first += 1.0
    assert list(known(held())) == [8.0, 16.0] and ASKED == [None]


@pytest.mark.parametrize(
    ("other", "more", "found"),
    [(held(1.5), {}, 12.0), (held(power=2), {}, 4.0), (held(), {"order": 1}, 9.0), (held(1.0 + 2e-16), {}, 8.0)],
    ids=["a number", "a formula", "how", "the last digit"],
)
def test_what_differs_anywhere_is_integrated_anew(other: Held, more: dict[str, int], found: float) -> None:
    ASKED.clear()
    known = once(integral_of)
    known(held())
    assert known(other, **more)[0] == pytest.approx(found, rel=1e-15) and len(ASKED) == 2


def test_a_formula_without_a_name_is_never_taken_for_another() -> None:
    ASKED.clear()
    known = once(integral_of)
    for power in (1, 2):
        assert known(Held(np.ones(1), lambda value, power=power: value**power))[0] == 2.0**power
    assert len(ASKED) == 2


@pytest.mark.skipif(THOROUGH, reason="everything is integrated whenever it is asked for")
def test_integrals_of_lamps_are_remembered() -> None:
    assert {name for name in INTEGRALS if hasattr(getattr(lamp_light, name), "__wrapped__")} == set(INTEGRALS)

"""Lamps' light that tests ask for again and again, integrated once a process.

Random and planted cases are searched, enumerated and attacked by many tests, each of which makes its tables anew: a
third of all integrals had been taken before. They are functions of their arguments alone, and are remembered by all
that these hold; before a release (UWOPT_THOROUGH=1) each is taken whenever it is asked for.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from copy import deepcopy
from functools import wraps
from hashlib import blake2b
from typing import Any

#: Integrals of the model as `forward.lamp_light` imports them.
INTEGRALS = (
    "backscatter_gain", "field_means", "floor_spots", "local_gain", "local_gains", "mean_backscatter",
    "mean_wide_gain", "wide_gain",
)  # fmt: skip
MOST = 20_000  # that are kept


def once(integral: Callable[..., Any]) -> Callable[..., Any]:
    """The integral, taken once for all arguments that hold the same; what it gives may be changed by who asks."""
    known: dict[bytes, Any] = {}

    @wraps(integral)
    def remembered(*given: Any, **more: Any) -> Any:
        try:
            held = pickle.dumps((given, more), 5)
        except (pickle.PicklingError, AttributeError, TypeError):  # a formula that has no name
            return integral(*given, **more)
        key = blake2b(held, digest_size=16).digest()
        if key not in known:
            if len(known) == MOST:
                known.clear()
            known[key] = integral(*given, **more)
        return deepcopy(known[key])

    return remembered

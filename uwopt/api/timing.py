"""Time by stage."""

from __future__ import annotations

import time
from typing import Any


def timed(timing: dict[str, float], name: str) -> Any:
    """A context that adds its duration to a table of times."""

    class Clock:
        def __enter__(self) -> None:
            self.start = time.perf_counter()

        def __exit__(self, *details: object) -> None:
            timing[name] = timing.get(name, 0.0) + time.perf_counter() - self.start

    return Clock()

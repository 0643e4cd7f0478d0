"""Time by stage."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

#: What a person reads while a stage lasts that does not tell how far it is.
STAGES = {
    "practice": "what of good practice has to give way",
    "certainty": "in how many scenarios hardware holds",
    "eased": "what asked less would make certain enough",
    "knee": "what more power and money would buy",
    "robustness": "how firm the answer is", "second_opinion": "second opinions",
    "prices": "what requirements cost", "ranges": "where other systems take over",
    "alternatives": "what other makers offer", "accuracy": "errors of figures",
}  # fmt: skip


def timed(
    timing: dict[str, float], name: str, progress: Callable[[float, str], None] | None = None
) -> Any:
    """A context that adds its duration to a table of times, and tells which stage it is."""

    class Clock:
        def __enter__(self) -> None:
            if progress is not None:
                progress(0.0, STAGES[name])
            self.start = time.perf_counter()

        def __exit__(self, *details: object) -> None:
            timing[name] = timing.get(name, 0.0) + time.perf_counter() - self.start

    return Clock()

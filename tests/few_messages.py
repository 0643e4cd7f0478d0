"""What a worker tells the process that hands out tests: half of its messages change nothing there.

A test of a millisecond costs as much again in six messages: it begins, is set up, called, torn down, has ended, and the
next may be handed out. That it begins, and that what stands before and after it passed, is not told.
"""

from __future__ import annotations

from typing import Any

import pytest


def is_told(event: str, data: dict[str, Any] | None = None) -> bool:
    """Whether an event of a worker is told; `data` of a report, as it is sent."""
    if event == "testreport" and data is not None:
        return bool(data["when"] == "call" or data["outcome"] != "passed")
    return event != "logstart"


def tell_less(config: pytest.Config) -> None:
    """Leave out the rest in a worker, unless names, durations or a file of results are asked for, which need it."""
    asked = config.option
    if asked.verbose > 0 or asked.durations is not None or asked.xmlpath is not None:
        return
    for plugin in config.pluginmanager.get_plugins():
        if type(plugin).__name__ == "WorkerInteractor":
            keep(plugin)


def keep(worker: Any) -> None:
    """Let one worker send what is told alone."""
    send = worker.sendevent

    def sent(name: str, **given: Any) -> None:
        if is_told(name, given.get("data")):
            send(name, **given)

    worker.sendevent = sent

"""What fails, is skipped or was called reaches the process that hands out tests."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from few_messages import is_told, keep

SILENT = [("setup", "passed"), ("teardown", "passed")]


@pytest.mark.parametrize("when", ["setup", "call", "teardown"])
@pytest.mark.parametrize("outcome", ["passed", "failed", "skipped"])
def test_all_but_a_passed_set_up_and_tear_down_is_told(when: str, outcome: str) -> None:
    assert is_told("testreport", {"when": when, "outcome": outcome}) is ((when, outcome) not in SILENT)


def test_a_worker_sends_what_is_told_as_it_was_given() -> None:
    sent: list[Any] = []
    worker = SimpleNamespace(sendevent=lambda name, **given: sent.append((name, given)))
    keep(worker)
    failed, collected = {"when": "setup", "outcome": "failed"}, {"outcome": "passed"}
    worker.sendevent("logstart", nodeid="a")
    worker.sendevent("testreport", data=failed)
    worker.sendevent("collectreport", data=collected)
    worker.sendevent("runtest_protocol_complete", item_index=3)
    told = [("testreport", {"data": failed}), ("collectreport", {"data": collected})]
    assert sent == [*told, ("runtest_protocol_complete", {"item_index": 3})]

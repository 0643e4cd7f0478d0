"""The model of larger clusters has the limits that can be told without it."""

from __future__ import annotations

from dataclasses import replace

import pytest
from sweep_model import Rates, projected

FREE = Rates(mission_s=0.1, spread_s=0.0, batch_s=0.0, assign_s=0.0, send_s=0.0, row_s=0.0, write_s=0.0)


def test_without_costs_workers_share_the_work_evenly():
    made = projected(FREE, workers=10, missions=10_000)
    assert made.seconds == pytest.approx(100.0, rel=0.03)  # the last batches end within one another
    assert made.workers_busy == pytest.approx(1.0, rel=0.03)


def test_a_slow_scheduler_is_what_it_waits_for():
    made = projected(replace(FREE, assign_s=5.0), workers=10, missions=10_000)
    assert made.seconds == pytest.approx(2 * 5.0 * made.batches, rel=0.03)  # each way
    assert made.scheduler_busy == pytest.approx(1.0, rel=0.03)


def test_who_asks_takes_all_that_waits_into_one_file():
    slow = projected(replace(FREE, write_s=10.0), workers=10, missions=10_000)
    assert slow.seconds < 10.0 * slow.batches / 2
    rows = projected(replace(FREE, row_s=0.1), workers=10, missions=10_000)
    assert rows.seconds == pytest.approx(0.1 * 10_000, rel=0.05)

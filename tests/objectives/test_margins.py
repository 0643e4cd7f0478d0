"""Margins of designs that differ in kind."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED
from uwopt.objectives.requirements import pulse_margins


def test_burning_lamps_beside_pulsed_ones_miss_no_pulse_requirement():
    kind = np.array([CONTINUOUS, PULSED, FLASH])
    lights = SimpleNamespace(
        kind=kind, max_pulse_s=np.array([np.inf, 2e-3, np.inf]), min_pulse_s=np.array([0.0, 1e-5, 0.0]),
        max_duty=np.ones(3), max_rate_hz=np.array([np.inf, 30.0, 2.0]),
        flash_duration_s=np.array([np.inf, np.inf, 1e-3]),
    )  # fmt: skip
    cameras = SimpleNamespace(readout_s=np.array([0.01, 0.0, 0.0]), exposure_offset_s=np.zeros(3))
    rows = SimpleNamespace(cameras=cameras, lights=lights)
    settings = SimpleNamespace(
        pulse_s=np.array([np.inf, 1e-3, 1e-3]), rate_hz=np.array([0.0, 5.0, 1.0]), exposure_s=np.full(3, 2e-3)
    )
    for margin in pulse_margins(rows, settings, kind != CONTINUOUS):
        assert margin.satisfied.all(), margin.requirement
        assert not np.isnan(margin.margin).any(), margin.requirement
    settings.pulse_s = np.array([np.inf, 3e-3, 1e-3])  # longer than the LED may
    first = next(iter(pulse_margins(rows, settings, kind != CONTINUOUS)))
    assert first.satisfied.tolist() == [True, False, True]

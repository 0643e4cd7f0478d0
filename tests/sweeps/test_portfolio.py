"""Few kits for many missions: the choice is the one that trying all choices finds."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import uwopt
from uwopt.results.sweep import SweepKit
from uwopt.sweeps.kits import served_by
from uwopt.sweeps.portfolio import portfolios

MISSION = Path(__file__).parents[2] / "problems" / "mbari-lass-2013.yaml"


@pytest.mark.parametrize("seed", range(6))
def test_choices_are_those_that_trying_all_finds(seed: int):
    draw = np.random.default_rng(seed)
    served = draw.random((60, 7)) < draw.uniform(0.1, 0.5)
    prices = [float(price) for price in draw.integers(1, 6, 7) * 1000]
    found = list(portfolios(served, prices))
    for kits, reached in found:
        every = [list(some) for n in range(1, len(kits) + 1) for some in itertools.combinations(range(7), n)]
        most = max(int(served[:, some].any(axis=1).sum()) for some in every)
        cheapest = min(
            sum(prices[k] for k in some) for some in every if served[:, some].any(axis=1).sum() == most
        )
        assert reached == served[:, kits].any(axis=1).sum() == most
        assert sum(prices[k] for k in kits) == cheapest
    assert found[-1][1] == served.any(axis=1).sum()
    assert [reached for _, reached in found] == sorted({reached for _, reached in found})


def test_no_choice_serves_where_nothing_fits():
    assert list(portfolios(np.zeros((3, 2), bool), [1.0, 2.0])) == []


def test_a_kit_serves_where_a_search_over_its_parts_finds_settings():
    mission = uwopt.load_mission(MISSION)
    best = uwopt.solve(mission, quick=True, top=1).recommendation
    assert best is not None
    used = best.hardware
    kit = SweepKit(
        *used.ids[:3], housing=None, complete=None, light=used.light.id, camera_count=used.camera_count,
        light_count=used.light_count, generic=False, wins=1,
    )  # fmt: skip
    fewer = replace(kit, light_count=used.light_count - 1)
    cameras = replace(kit, camera_count=used.camera_count + 1)
    gone = replace(kit, light="no-such-light")
    assert served_by(mission, [gone, kit, cameras]) == "010"
    for count, sign in ((used.light_count, "1"), (used.light_count - 1, served_by(mission, [fewer]))):
        alone = mission.with_changes(vehicle=mission.to_dict()["vehicle"] | {"light_count": [count, count]})
        own = {"cameras": [kit.camera], "lenses": [kit.lens], "ports": [kit.port], "lights": [kit.light]}
        narrowed = alone.with_changes(catalog=mission.to_dict()["catalog"] | own)
        assert (uwopt.solve(narrowed, quick=True, explain=False).recommendation is not None) == (sign == "1")
    too_much = mission.with_changes(limits=mission.to_dict()["limits"] | {"power_w": 1e-3})
    assert served_by(too_much, [kit]) == "0"

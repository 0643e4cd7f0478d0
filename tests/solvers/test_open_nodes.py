"""The order in which nodes of a search are taken where any design that fits will do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

from uwopt.api.common import prepared
from uwopt.forward.assembly import load_catalog
from uwopt.mission.mission import load_mission
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.open_nodes import by_turns
from uwopt.solvers.recommend import seek

JOBS = Path(__file__).resolve().parents[2] / "problems" / "jobs"


def test_turns_take_the_first_of_each_order_before_the_second_of_any() -> None:
    order = by_turns(np.array([0, 1, 2, 3, 4]), np.array([4, 0, 1, 2, 3]), np.array([2, 4, 3, 1, 0]))
    assert set(order[:3]) == {0, 4, 2}
    assert sorted(order) == [0, 1, 2, 3, 4]


def test_what_fits_in_murky_water_is_among_the_first_that_are_tried() -> None:
    # 2 m from a wall in coastal water corners are dark and veiled: 1700 designs that need less power, all before
    # the first narrow enough to fit were once tried, each with its light
    text = (JOBS / "harbour-wall.yaml").read_text(encoding="utf-8")
    text = text.replace("visibility_m: 3.0", "water: III").replace("distance_m: 0.8", "distance_m: 2.0")
    wanted = prepared(load_mission(yaml.safe_load(text)), None, None, "central").without_gain_cap
    found = seek(wanted, load_catalog(wanted), Objective.of("power"), generic="allow", top=1, enough=True).outcome
    assert found.best
    assert found.account.evaluated < 100

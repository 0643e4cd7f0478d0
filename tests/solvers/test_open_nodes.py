"""The order in which nodes of a search are taken where any design that fits will do."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from uwopt.api.common import prepared
from uwopt.forward.assembly import load_catalog
from uwopt.mission.mission import load_mission
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.evaluation import Evaluation
from uwopt.solvers.recommend import seek

JOBS = Path(__file__).resolve().parents[2] / "problems" / "jobs"


def test_what_fits_in_murky_water_is_among_the_first_that_are_tried() -> None:
    # 2 m from a wall in coastal water corners are dark and veiled: 1700 designs that need less power were once tried
    # before the first narrow enough to fit, each with its light
    text = (JOBS / "harbour-wall.yaml").read_text(encoding="utf-8")
    text = text.replace("visibility_m: 3.0", "water: III").replace("distance_m: 0.8", "distance_m: 2.0")
    wanted = prepared(load_mission(yaml.safe_load(text)), None, None, "central").without_gain_cap
    found = seek(wanted, load_catalog(wanted), Objective.of("power"), generic="allow", top=1, enough=True).outcome
    assert found.best
    assert found.account.evaluated < 100


@pytest.mark.parametrize(("enough", "groups"), [
    (False, [[0, 1, 2, 3, 4, 5, 6, 7]]),
    (True, [[0, 4], [1, 2, 5], [3, 6, 7]]),  # under lighting 7; under 2 and 5; under 1, 4 and 3
])  # fmt: skip
def test_where_one_that_fits_is_enough_the_lighting_of_the_first_comes_first(enough: bool, groups: list) -> None:
    """Light of all nodes of a batch is dear, and the search ends with the first of them that fits."""
    under = SimpleNamespace(index=np.array([7, 2, 5, 1, 7, 2, 4, 3]))
    tables = [SimpleNamespace(light=[0])] * 8
    one = SimpleNamespace(
        bounds=SimpleNamespace(light_tables=tables, sizes=np.ones(8, int)), enough=enough,
        problem=SimpleNamespace(are_unlit=lambda light: False),
    )  # fmt: skip
    assert [some.tolist() for some in Evaluation.together(one, under)] == groups

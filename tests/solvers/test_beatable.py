"""Under the sun something to beat is found soon: until then no bound discards any design, and each bound is dear."""

from __future__ import annotations

from typing import Any

import pytest

from tests.solvers.reef_of_few import reef_of_few_parts
from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.mission.mission import load_mission
from uwopt.objectives.goal import goal_of
from uwopt.solvers.exact.search import Search


class ToldError(Exception):
    """Raised when all is known that is asked here."""


def test_what_waits_under_the_sun_is_solved_before_the_next_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it waited until no other bound was less, thousands were bounded with nothing to beat, and none was told."""
    base = reef_of_few_parts().to_dict()
    sunny = {**base["scenes"][0], "sun_lux": 60000.0, "depth_m": 3.0}
    mission = load_mission(base | {"scenes": [sunny], "objective": "best_image"})
    problem = build_problem(mission, selected(mission, load_catalog(mission), generic="never"))
    search, made = Search(problem, goal_of(mission), top=1), list[str]()
    solve = search.solve

    def noted(pairs: Any, lights: Any, *, optimistic: bool = False, stage: Any = "all", **more: Any) -> Any:
        made.append(stage)
        if made.count("none") > 1 or not optimistic:
            raise ToldError
        return solve(pairs, lights, optimistic=optimistic, stage=stage, **more)

    monkeypatch.setattr(search, "solve", noted)
    with pytest.raises(ToldError):
        search.run()
    assert made == ["none", "forward", "coarse", "all"]

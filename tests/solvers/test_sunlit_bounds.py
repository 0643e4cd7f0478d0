"""Bounds under the sun: what few pixels ask of the lamps, beside what all of the image do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.solvers.reef_of_few import reef_of_few_parts
from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.mission.mission import load_mission
from uwopt.objectives.goal import goal_of
from uwopt.solvers.exact.lightings import Under
from uwopt.solvers.exact.search import Search
from uwopt.solvers.settings import windows
from uwopt.solvers.settings.windows import Sun


def test_bounds_under_the_sun_know_the_veil_at_pixels() -> None:
    """At dusk in murky water: no more light than all pixels ask for, at most a tenth less.

    It is thrice as much as without the veil: so nothing discarded a system until its whole image was integrated.
    """
    base = reef_of_few_parts().to_dict()
    dusk = {**base["scenes"][0], "sun_lux": 3000.0, "depth_m": 8.0, "water": "5C"}
    mission = load_mission(base | {"scenes": [dusk], "requirements": base["requirements"] | {"snr_at": "worst"}})
    problem = build_problem(mission, selected(mission, load_catalog(mission), generic="never"))
    search = Search(problem, goal_of(mission), top=1)
    imager = np.arange(len(search.prepare()))[:40]
    under = Under.one(search.tables.lightings[0], len(imager))
    two = np.full(len(imager), 2)
    lamp = np.full(len(imager), search.bounds.light_tables[0].light[0])
    asked = {}
    for stage, optimistic in (("none", True), ("all", False)):
        lights = search.tables.in_scenes(under, imager, veils=stage)
        rows = search.rows(imager, lights, lamp, two, under, optimistic=optimistic)[0]
        sun = Sun.at(rows, np.full(len(imager), 1e-4))
        rows = replace(rows, min_snr=10.0)
        asked[stage] = windows.light_asked_for(rows, sun=sun)
        unveiled = windows.light_asked_for(replace(rows, worst_veil_e=None), sun=sun)
    assert (asked["all"] > 3.0 * unveiled).all()
    share = asked["none"] / asked["all"]
    assert (share <= 1.0 + 1e-9).all() and (share > 0.9).all()

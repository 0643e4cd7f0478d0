"""All lightings at once discard what each of them does, and nothing else; what that proves of other requirements."""

from __future__ import annotations

import numpy as np
import pytest
from reef_of_few import reef_of_few_parts

from uwopt.catalog.choose import ToBeMade
from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.weakened import without
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact import search as searching
from uwopt.solvers.exact.account import Account
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.infeasible.freed_rules import untouched
from uwopt.solvers.infeasible.moves import Mover
from uwopt.solvers.infeasible.singles import Singles
from uwopt.solvers.infeasible.trials import Trials
from uwopt.solvers.recommend import Sought, seek

POWER = Objective.of("power")
DARK_DB = 45.0  # what no lamp of theirs gives


def reef(min_snr_db: float, pitch_deg: float = 0.0) -> Mission:
    """The reef of few parts, with lamps at any of many places."""
    base = reef_of_few_parts().to_dict()
    vehicle = base["vehicle"] | {"light_baseline_m": [0.6, 1.2], "pitch_deg": pitch_deg}
    asked = base["requirements"] | {"min_snr_db": min_snr_db}
    return load_mission(base | {"vehicle": vehicle, "requirements": asked})


def searched(wanted: Mission) -> Sought:
    """All its parts, searched for the least power."""
    return seek(wanted, load_catalog(wanted), POWER, generic="never", top=1)


def bounds_of(wanted: Mission, generic: ToBeMade = "never") -> Bounds:
    """Bounds of all its imagers."""
    problem = build_problem(wanted, selected(wanted, load_catalog(wanted), generic=generic))
    search = searching.Search(problem, POWER, top=1)
    search.prepare()
    return search.bounds


@pytest.mark.parametrize("pitch_deg", [0.0, 15.0], ids=["level", "pitched"])
def test_only_what_is_dark_under_each_lighting_is_left_dark(pitch_deg):
    """And of that most, though the brightest place and the ablest lamp are taken apart."""
    known, every = 0, 0
    for asked_db in np.arange(30.0, 45.0, 4.0):
        bounds = bounds_of(reef(float(asked_db), pitch_deg))
        rows = np.arange(len(bounds.imagers))
        rules = [bounds.of_nodes(k, rows).rule for k in range(len(bounds.tables.lightings))]
        dark, found = np.all(np.array(rules) == 0, axis=0), bounds.leaves_dark(rows)
        assert not (found & ~dark).any()
        known, every = known + int(found.sum()), every + int(dark.sum())
    assert 0.9 * every <= known < 40


def test_flashes_that_take_longer_to_load_than_images_are_apart_light_nothing():
    """However bright: no lighting has to be looked at by itself."""
    base = reef(20.0).to_dict()
    catalog = base["catalog"] | {"generic": "allow", "lights": ["generic-flash-200j"]}
    bounds = bounds_of(load_mission(base | {"catalog": catalog}), "allow")
    flash = next(light for light in bounds.problem.parts.lights if light.kind == "flash")
    assert flash.recycle_s and flash.recycle_s.value * bounds.imagers.scenes[0].focused.rate_hz.min() > 1.0
    assert bounds.leaves_dark(np.arange(len(bounds.imagers))).all()


def test_the_whole_catalogue_is_searched_imager_by_imager():
    """In both orientations, with parts to be made: the tree above imagers is for larger ones, and dear for this."""
    wanted = load_mission({
        "scene": {"visibility_m": 6.0, "depth_m": 25.0, "seafloor": 0.2},
        "vehicle": {"altitude_m": 1.5, "speed_m_s": 0.4},
        "requirements": {"min_snr_db": 18.0},
    })  # fmt: skip
    problem = build_problem(wanted, selected(wanted, load_catalog(wanted), generic="allow"))
    pairs = searching.fitting_pairs(problem)
    assert len(pairs.camera) * len(problem.port_groups) > 300_000
    assert not searching.are_too_many(problem, pairs)


@pytest.mark.parametrize("most_imagers", [searching.MOST_IMAGERS, 0], ids=["one by one", "by pairs"])
@pytest.mark.parametrize("asked_db", [36.0, DARK_DB])
def test_every_combination_is_counted_as_it_is_one_lighting_after_another(most_imagers, asked_db, monkeypatch):
    monkeypatch.setattr(searching, "MOST_IMAGERS", most_imagers)
    at_once = searched(reef(asked_db)).outcome
    monkeypatch.setattr(Bounds, "leaves_dark", lambda self, rows, *_: np.zeros(len(rows), bool))
    each = searched(reef(asked_db)).outcome
    assert at_once.account == each.account and at_once.account.adds_up()
    assert [one.minimised for one in at_once.best] == [one.minimised for one in each.best]


def test_what_no_bound_asks_about_is_known_not_to_help_before_any_search():
    """And so it is: nothing fits without any one of them."""
    wanted = reef(DARK_DB)
    like = searched(wanted)
    trials = Trials(wanted, load_catalog(wanted), POWER, "never", like=like)
    settled = Singles(trials).useless
    assert {"power_w", "cost"} <= settled.keys() and not {"min_snr", "max_blur_px", "max_gsd_mm"} & settled.keys()
    assert set(settled.values()) == {("light",)}
    for name in settled:
        free = without(wanted, name)
        assert free is not None and not searched(free).outcome.best


def test_a_search_of_another_mission_settles_nothing():
    wanted = reef(DARK_DB)
    trials = Trials(wanted, load_catalog(wanted), POWER, "never", like=searched(reef(60.0)))
    assert not Singles(trials).useless and not Mover(trials).useless


@pytest.mark.parametrize(("evaluated", "discarded", "settled", "open_yet"), [
    (0, {"light": 5, "max_gsd_mm": 3}, {"power_w", "battery_wh", "min_swath_m", "max_airy_px"}, {"max_gsd_mm"}),
    (0, {"light": 5, "power_w": 1}, {"max_airy_px", "max_white_balance"}, {"power_w", "cost", "battery_wh"}),
    (0, {"light": 5, "cost": 1}, {"power_w", "mass_kg", "lamps_between_images"}, {"cost"}),
    (0, {"light": 5, "energy_wh": 1}, {"max_airy_px"}, {"cost", "power_w", "energy_wh", "battery_wh"}),
    (0, {"light": 5, "max_white_balance": 1}, {"max_airy_px", "cost"}, {"max_white_balance"}),
    (1, {"light": 5}, set(), {"max_airy_px", "power_w"}),
    (0, {"light": 5, "bound": 1}, set(), {"max_airy_px", "power_w"}),
    (0, {"light": 5, "min_mtf_half_nyquist": 1}, {"max_white_balance", "cost"}, {"min_mtf_half_nyquist"}),
])  # fmt: skip
def test_only_what_discarded_nothing_is_settled(evaluated, discarded, settled, open_yet):
    known = set(untouched(Account(10, evaluated, discarded)))
    assert settled <= known and not known & {*open_yet, "min_snr", "mean_level", "min_contrast", "max_blur_px"}

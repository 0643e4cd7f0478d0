"""Reserves, stopped-down lenses and refusals in the search: what is recommended keeps them, and exactly them."""

from __future__ import annotations

import numpy as np
import pytest
from one_of_each import one
from random_cases import Case

from uwopt.mission.mission import load_mission
from uwopt.solvers.recommend import scene_rows_of


def rows_of(case: Case):
    """The settings' view of the one design."""
    search, outcome = case.solve()
    return scene_rows_of(search, outcome.best[0])[0]


def f_number(case: Case) -> float:
    return case.solve()[1].best[0].settings[0]["f_number"]


def test_the_search_stops_the_lens_down():
    # f/2 wide open; two stops are f/4; by power the search would stay at the widest
    assert f_number(one()) == pytest.approx(2.0)
    assert f_number(one(wanted={"lens_stop_down": 2.0})) == pytest.approx(4.0)


def test_the_mark_a_stop_down_is_enough():
    # a stop below f/2 is f/2.83, for which rings are engraved 2.8
    assert f_number(one(wanted={"lens_stop_down": 1.0})) == pytest.approx(2.8)


def test_a_lens_of_one_opening_is_searched_as_it_is():
    single = {"f_number_min": 4.0, "f_number_max": 4.0}
    assert f_number(one(lens=single, wanted={"lens_stop_down": 1.0})) == pytest.approx(4.0)


def test_the_airy_disc_ends_the_f_numbers():
    """2.44 lambda N_w = 1 px of 4 um, N_w = N (1 + m) with the focus on the dome's image, 50 mm or so away."""
    limited = one(wanted={"max_airy_px": 1.0})
    search, outcome = limited.solve()
    rows = scene_rows_of(search, outcome.best[0])[0]
    scene = search.problem.scenes[0]
    weight = search.problem.contractions[0].weight(0, 0)  # electrons by colour that the lamp and the sensor give
    lamp_leg = search.problem.lamp_leg_per_m(0, 0)
    loss = np.exp(-2.0 * (scene.attenuation_per_m + lamp_leg))  # 2 m down, 2 m up
    wave_m = float((weight * loss * scene.wavelength_nm).sum() / (weight * loss).sum()) * 1e-9
    dioptre = outcome.best[0].settings[0]["dioptre_per_m"]
    factor = 1.0 / (1.0 - 8e-3 * dioptre)  # thin lens: 1 + m
    assert factor > 1.01  # else infinity would do
    assert float(rows.n_high[0]) == pytest.approx(4e-6 / (2.44 * wave_m * factor), rel=1e-6)


def test_no_light_is_found_where_the_airy_disc_and_the_stop_exclude_each_other():
    assert one(wanted={"max_airy_px": 1.0, "lens_stop_down": 3.0}).solve()[1].best == []


@pytest.mark.parametrize("objective", ["power", "snr_db"])
def test_a_reserve_is_the_requirement_that_much_stricter(objective):
    """30 dB and 3 dB in hand is what 33 dB are, and so on: the same design, the same value."""
    tight = dict(wanted={"min_snr_db": 23.0, "max_blur_px": 0.8, "min_swath_m": 1.1})
    plain = one(objective, **tight)
    loose = one(objective, wanted={"min_snr_db": 20.0, "max_blur_px": 1.0, "min_swath_m": 1.0})
    kept = Case(
        loose.parts,
        load_mission({**loose.mission.to_dict(), "reserve": {"snr_db": 3, "blur": 0.2, "swath": 0.1}}),
        loose.objective,
    )
    values = [case.solve()[1].best[0].minimised for case in (plain, kept, loose)]
    assert values[0] == pytest.approx(values[1], rel=1e-9)
    assert values[0] > values[2] * (1 + 1e-6) or objective == "snr_db"


SEEN = {"light_mounts": [{"y_m": 0.45, "z_m": 1.0}], "light_count": 1}  # 1 m down the view is 0.54 m wide a side
CLEAR = {"light_mounts": [{"y_m": 0.58, "z_m": 1.0}], "light_count": 1}


@pytest.mark.parametrize(
    ("vehicle", "refuse", "fits"), [(SEEN, [], True), (SEEN, ["lamp"], False), (CLEAR, ["lamp"], True)]
)
def test_a_lamp_in_the_view_is_refused(vehicle, refuse, fits):
    """Behind the dome the ray at the edge has the tangent 0.5 from its centre 80 mm above: 1.08 m / 2 at 1 m."""
    case = one(vehicle=vehicle, wanted={"refuse": refuse, "min_snr_db": 5.0})
    assert bool(case.solve()[1].best) == fits


def test_physics_paper_has_its_lamps_on_the_axis_and_refuses_none():
    case = one(vehicle=SEEN, wanted={"refuse": ["lamp"], "min_snr_db": 5.0}, physics="paper")
    assert case.solve()[1].best

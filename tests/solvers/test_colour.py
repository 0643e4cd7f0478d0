"""Colours: what is asked of red and of the balance of channels, searched and evaluated, and what is told of them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import brute_force as brute
import numpy as np
import pytest
from agreement import agree
from random_cases import CASES, Case, case, enumerated, in_batches, lamp, planted, ranked
from settings_attack import lit
from thorough import drawn

from uwopt.catalog.parts.quantity import Curve
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.effects import InScene, bounds_of
from uwopt.model.sensor import white_balance
from uwopt.objectives.requirements import MarginRows
from uwopt.solvers.exact.balance import least_ratio
from uwopt.solvers.exact.node_bounds import NODE_RULES
from uwopt.solvers.recommend import colour_notes
from uwopt.solvers.settings.cell_windows import window_over
from uwopt.solvers.settings.windows import light_for_snr

BURNING = lamp("burning", flux_lm=2e4, power_w=200.0)
#: Flat curves: whatever the light's colour, red has a quarter of green's electrons, blue half; the mean is 0.55.
FLAT = {name: Curve((380.0, 780.0), (share, share)) for name, share in (("red", 0.2), ("green", 0.8), ("blue", 0.4))}
MONO = {"mono": Curve((380.0, 780.0), (0.6, 0.6))}
COLOURED = drawn((24, 44, 49), CASES)  # by default quick ones of both physics in which red decides


@pytest.mark.parametrize(("batches", "seed"), in_batches(COLOURED), indirect=["batches"])
def test_search_asking_of_colours_equals_enumeration(batches: str, seed: int) -> None:
    """Best designs, feasibility and account of cases with a red SNR, a white balance and subjects that move."""
    coloured = case(seed, coloured=True)
    agree(coloured, coloured.solve()[1], ranked(enumerated(seed, coloured=True)))


def coloured_images(seed: int) -> Iterator[tuple[Any, Any, Any, int, Any]]:
    """A search, its imagers, and each lighting with their images from the farthest altitude and their light."""
    search = case(seed, coloured=True).searcher()
    imagers = search.prepare()
    far = len(search.problem.scenes[0].range_m) - 1
    for lighting in search.tables.lightings:
        light = search.tables.exact(0, lighting, np.arange(len(imagers)), veils="none")
        assert light.colour_e is not None
        yield search, imagers, lighting, far, light


@pytest.mark.parametrize("seed", [17, 44])
def test_no_image_has_more_red_than_its_bound(seed: int) -> None:
    """Bounds of images under every lighting, taken before the integrals, against the integrals."""
    nearness = []
    for search, imagers, lighting, far, light in coloured_images(seed):
        bound = search.tables.bound(0, lighting, far, np.arange(len(imagers)), channel="red")
        red = light.colour_e[:, far, 0]
        assert (red <= bound * (1 + 1e-9)).all()
        nearness += [*(red[bound > 0] / bound[bound > 0])]
    assert max(nearness) > 0.4


@pytest.mark.parametrize("seed", [9, 41, 44])
def test_no_image_is_better_balanced_than_its_bound(seed: int) -> None:
    """Bounds that know the water's paths alone, against integrals over every image."""
    nearness = []
    for search, imagers, lighting, far, light in coloured_images(seed):
        curves = search.problem.cameras.qe_index[imagers.camera]
        bound = np.array([search.tables.least_balance(0, lighting, int(curve)) for curve in curves])
        balance = np.where(light.signal_e[:, far] > 0.0, white_balance(light.colour_e[:, far]), np.inf)
        assert (bound <= balance).all()
        nearness += [*(bound / balance)]
    assert max(nearness) > 0.9


@pytest.mark.parametrize("seed", [6, 41])
def test_colours_seen_ahead_are_those_of_the_farthest_altitude(seed: int) -> None:
    """What discards a node before its light is known, against the light."""
    search = case(seed, coloured=True).searcher()
    rows = np.arange(len(search.prepare()))
    for lighting in search.tables.lightings:
        light = search.tables.exact(0, lighting, rows, veils="none")
        assert light.colour_e is not None
        seen = search.tables.balance(0, lighting, rows)
        assert seen == pytest.approx(white_balance(light.colour_e[:, -1]), rel=1e-9)


@pytest.mark.parametrize(("share", "rules"), [(1.0 - 1e-6, {"max_white_balance"}), (1.0 + 1e-6, set())])
def test_colours_seen_ahead_discard_what_an_evaluation_would(share: float, rules: set[str]) -> None:
    # red is lost on the way; the limit is a millionth on either side of what the one design's evaluation says
    def made(most: float) -> Case:
        asked = {"max_white_balance": most, "max_blur_px": 1.0}
        return coloured_case(asked, {**FLAT, "red": Curve((380.0, 599.0, 601.0, 780.0), (0.0, 0.0, 0.8, 0.8))})

    balance = float(margins_of(made(9.0))[0]["max_white_balance"].value[0])
    search = made(balance * share).searcher()
    rows = np.arange(len(search.prepare()))
    told = {NODE_RULES[int(rule)] for rule in search.bounds.of_pixels(0, rows).rule if rule >= 0}
    assert (search.bounds.of_nodes(0, rows).rule < 0).all() and told == rules


def test_a_ratio_of_channels_is_least_at_a_corner_of_its_cell() -> None:
    # exp(-r) over exp(-2 r) is exp(r): at least 1 from r = 0 on, and no more than exp(0.1) less in a cell of 0.1
    path = np.linspace(0.0, 1.0, 11)[:, None]
    strong, weak = np.exp(-path) * np.ones(11), np.exp(-2.0 * path) * np.ones(11)
    assert math.exp(-0.1) - 1e-12 <= least_ratio(strong, weak) <= 1.0
    assert least_ratio(strong, 0.0 * weak) == math.inf and least_ratio(0.0 * strong, 0.0 * weak) == 1.0


def test_without_light_no_colour_is_too_strong() -> None:
    # a lamp whose beam leaves the image dark, where nothing is asked of its light
    made = coloured_case({"max_white_balance": 1.5, "min_snr_db": None, "mean_level": None})
    search = made.searcher()
    rows = np.arange(len(search.prepare()))
    assert (search.bounds.of_nodes(0, rows).rule < 0).all()


def test_no_designs_have_no_balance() -> None:
    none = lit(colours=((50.0, 100.0, 60.0), (1e4, 3e5, 4e5)), sun=(3e5, 2e5), max_white_balance=6.0).take(np.arange(0))
    y = np.empty(0)
    assert [len(side) for side in window_over(none, y, y, y, y)] == [0, 0]


def test_red_behind_a_thick_veil_equals_enumeration() -> None:
    made = coloured_case({"min_snr_red_db": 3.0, "max_blur_px": 2.0}, water="3C")
    found = brute.enumerate_all(brute.Bench(made.problem()), made.objective)
    agree(made, made.solve()[1], ranked(found))
    light = DesignModel(made.problem(), found[0].hardware).rows[0].light
    assert ranked(found) and light.red_veil_e[0, 0] > 0.3 * light.colour_e[0, 0, 0]


def test_red_asks_for_light_as_the_only_altitude_says() -> None:
    # C = 4 e per lm s in red, read noise 2 e, no other noise but quantisation of 1e-4 DN: SNR 10 at mu electrons with
    # mu^2 = 100 (4 + mu), mu = 50 + sqrt(2500 + 400) = 103.85
    rows = lit(colours=((4.0, 100.0, 60.0), (0.0, 0.0, 0.0)), min_snr_red=10.0, min_snr=0.0, read_noise_e=2.0,
               gain_dn_per_e=1e3, full_scale_dn=1e9, well_e=1e9)  # fmt: skip
    needed = light_for_snr(rows, 1, 10.0, of="red")
    assert needed[0] == pytest.approx((50.0 + math.sqrt(2900.0)) / 4.0, rel=1e-5)


# ---------------------------------------------------------------- what is evaluated


def coloured_case(asked: dict[str, Any], curves: dict[str, Curve] = FLAT, **scene: Any) -> Case:
    """One camera with these curves over a floor."""
    camera = {"qe_curves": curves, "colour": "colour" if len(curves) > 1 else "mono"}
    return planted("power", (BURNING,), {"max_blur_px": 1.0, **asked}, camera=camera, scenes=(scene,))


def margins_of(made: Case) -> tuple[dict[str, MarginRows], Any]:
    """Margins of the only hardware at F4, and its figures."""
    problem = made.problem()
    model = DesignModel(problem, Hardware(0, 0, 0, True, 0, 1, problem.mounts[0]))
    settings = model.settings(0, SceneSettings(f_number=4.0))
    figures = model.figures(0, settings)
    margins = {m.requirement: m for m in model.margins(0, settings, figures)}
    return margins, (figures, model.cameras, settings)


@pytest.mark.parametrize("sun", [{}, {"sun_lux": 2e4, "depth_m": 10.0}])
def test_margins_of_colours_are_those_of_flat_curves(sun: dict[str, float]) -> None:
    margins, (figures, camera, settings) = margins_of(
        coloured_case({"min_snr_red_db": 10.0, "max_white_balance": 3.0}, **sun)
    )
    share = 0.2 / 0.55  # of the mean's electrons, veils too
    red, veil = (
        share * float(column[0, 0])
        for column in (figures.electrons_signal, figures.electrons_forward + figures.electrons_backscatter)
    )
    gain = float(camera.gain_dn_per_e[0] * settings.gain[0])
    light = red + veil
    noise = float(camera.read_noise_e[0]) ** 2 + 1.0 / 12.0 / gain**2 + light + float(figures.electrons_dark[0])
    noise += (float(camera.prnu_frac[0]) * light) ** 2
    assert margins["min_snr_red_db"].value[0] == pytest.approx(20.0 * math.log10(red / math.sqrt(noise)), rel=1e-6)
    assert margins["max_white_balance"].value[0] == pytest.approx(4.0, rel=1e-9)
    assert not margins["max_white_balance"].satisfied[0]


def test_a_mono_sensor_has_no_red_and_nothing_to_balance() -> None:
    margins, _ = margins_of(coloured_case({"min_snr_red_db": 10.0, "max_white_balance": 3.0}, MONO))
    assert not margins["min_snr_red_db"].satisfied[0] and margins["max_white_balance"].satisfied[0]


@pytest.mark.parametrize(
    ("asked", "curves", "found"),
    [
        ({"max_white_balance": 4.01}, FLAT, True), ({"max_white_balance": 3.99}, FLAT, False),
        ({"max_white_balance": 1.0}, MONO, True), ({"max_white_balance": 3.99, "min_snr_db": None}, FLAT, False),
        ({"refuse": ["white_balance"]}, FLAT, True),
        ({"min_snr_red_db": -20.0}, FLAT, True), ({"min_snr_red_db": -20.0}, MONO, False),
    ],
)  # fmt: skip
def test_search_refuses_what_an_evaluation_would_miss(asked: dict[str, Any], curves: Any, found: bool) -> None:
    assert bool(coloured_case(asked, curves).solve()[1].best) == found


def test_the_worst_altitude_counts_for_colours() -> None:
    # red is lost on the way: the far altitude has least of it, and is least balanced
    curves = {**FLAT, "red": Curve((380.0, 599.0, 601.0, 780.0), (0.0, 0.0, 0.8, 0.8))}

    def made(altitude_m: float, tolerance_m: float, most: float = 9.0, red_db: float = 0.0) -> Case:
        asked = {"min_snr_red_db": red_db, "max_white_balance": most, "max_blur_px": 1.0}
        over = dict(altitude_m=altitude_m, altitude_tolerance_m=tolerance_m)
        return planted("power", (BURNING,), asked, camera={"qe_curves": curves}, **over)

    far, near, band = (margins_of(made(*over))[0] for over in ((2.5, 0.0), (1.5, 0.0), (2.0, 0.5)))
    for name in ("min_snr_red_db", "max_white_balance"):
        assert band[name].at_altitude_m is not None and band[name].at_altitude_m[0] == 2.5
    ends = [float(one["max_white_balance"].value[0]) for one in (near, far)]
    assert band["max_white_balance"].value[0] == pytest.approx(ends[1], rel=1e-6)
    assert ends[1] > 1.2 * ends[0]
    assert made(2.0, 0.5, 1.01 * ends[1]).solve()[1].best and not made(2.0, 0.5, 0.99 * ends[1]).solve()[1].best


def test_veils_are_kept_where_red_needs_them() -> None:
    """Of red, lost on the long way, backscatter is a greater share than of the mean."""
    red = {**FLAT, "red": Curve((380.0, 649.0, 651.0, 780.0), (0.0, 0.0, 0.8, 0.8))}
    shares = []
    for asked in ({}, {"min_snr_red_db": 0.0}):
        problem = coloured_case(asked, red).problem()
        model = DesignModel(problem, Hardware(0, 0, 0, True, 0, 1, problem.mounts[0]))
        seen = InScene(0, model.views[0], model.hardware)
        shares.append(bounds_of(model.problem, seen, information=False)["backscatter"][0])
    assert shares[1] > 1.2 * shares[0]


# ---------------------------------------------------------------- what is told


@pytest.mark.parametrize(
    ("asked", "sensor", "words"),
    [
        ({}, "mono", "Camera is mono: no colour was asked for; requirements.colour: colour asks for it"),
        ({}, "colour", "requirements.colour: mono asks for the other"),
        ({"colour": "colour"}, "colour", ""),
        ({"min_snr_red_db": 3.0}, "colour", ""),
    ],
)
def test_the_sensor_is_told_where_the_mission_leaves_it_open(asked: dict[str, Any], sensor: str, words: str) -> None:
    made = planted("power", (BURNING,), asked, camera={"colour": sensor})
    problem = made.problem()
    notes = colour_notes(problem, Hardware(0, 0, 0, True, 0, 1, problem.mounts[0]))
    assert [note.message.endswith(words) for note in notes] == [True] * bool(words)



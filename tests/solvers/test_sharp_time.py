"""How long bars still arrive, against times and f-numbers tried one by one; and what bounds of designs make of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hand_made_rows import FADING
from settings_attack import lit, sharp

from tests.solvers.reef_of_few import reef_of_few_parts
from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.forward.bars import StillBars
from uwopt.forward.sharpness import SharpRows
from uwopt.mission.mission import load_mission
from uwopt.objectives.goal import goal_of
from uwopt.solvers.exact.lightings import Under
from uwopt.solvers.exact.search import Search
from uwopt.solvers.settings.sharp_time import longest_sharp_s, while_sharp

COUNT, STEP = 200, 1.02
TIMES_S = np.geomspace(2e-5, 2e-2, 1 + round(np.log(1e3) / np.log(STEP)))


def test_no_bars_arrive_that_move_longer_than_the_longest_time() -> None:
    """Of lenses soft wide open, in light of which 15 to 100 % forms the image; at one f-number it is exact."""
    rng = np.random.default_rng(7)
    every = SharpRows.joined([
        sharp(blur=rng.uniform(500.0, 3000.0), place=rng.uniform(0.0, 3.0), aberration=rng.uniform(0.0, 3.0))
        for _ in range(COUNT)
    ])  # fmt: skip
    low, factor = rng.uniform(1.4, 8.0, COUNT), rng.uniform(1.0, 1.1, COUNT)
    contrast = rng.uniform(0.15, 1.0, (COUNT, 3))
    high = low * np.where(np.arange(COUNT) % 2, 1.0, rng.uniform(1.0, 4.0, COUNT))
    bars, rows = every.asked(min_mtf=0.2, resolve_m=1.5e-3), np.arange(COUNT)
    still = [StillBars.of(one, every) for one in bars]
    longest = longest_sharp_s(still, rows, low, high, working_factor=factor, contrast=contrast, safe=False)
    each, times_s = np.tile(rows, len(TIMES_S)), np.repeat(TIMES_S, COUNT)  # all times at once: calls cost, not numbers
    tried = every.take(each)
    looked = tried.asked(min_mtf=0.2, resolve_m=1.5e-3)
    latest = np.zeros(COUNT)
    for share in np.linspace(0.0, 1.0, 12):
        n = (low * (high / low) ** share)[each]
        at = dict(f_number=n, working_f_number=n * factor[each], blur_s=times_s)
        mtf, veiled = (tried.transfer(one, **at) for one in looked)
        arrive = (mtf.min(axis=1) >= 0.2) & ((veiled * contrast[each]).min(axis=1) >= looked[1].least)
        latest = np.maximum(latest, np.where(arrive, times_s, 0.0).reshape(-1, COUNT).max(axis=0))
    assert (latest <= longest * (1.0 + 1e-6))[latest > 0.0].all()
    alone = (high == low) & (longest > 2.0 * TIMES_S[0])
    assert alone.sum() > 20 and (latest >= longest / STEP**1.01)[alone].all()
    assert 20 < (longest < 0.0).sum() < COUNT - 20


def test_a_veil_shortens_the_time_in_which_bars_arrive() -> None:
    """Half the contrast: what motion may take follows from sin(a)/a by hand; never with less than is asked for."""
    times_s = []
    for veil in (0.0, 100.0, 1e5):  # beside a signal of 100 at the middle altitude
        rows = lit(sharp(blur=1e3, place=0.0, rated=0.1, aberration=0.0), veil=veil, resolve_m=2e-3)
        rows = replace(rows, time_max_s=np.array([1.0]), n_low=np.array([2.8]), n_high=np.array([2.8]))
        times_s.append(float(while_sharp(rows).time_max_s[0]))
        bars, moving, signal = rows.bars[0], rows.sharp, np.array([120.0, 100.0, 80.0])
        share = signal / (signal + veil * np.array([0.8, 1.0, 1.2]))
        if times_s[-1] > 0.0:
            assert moving is not None
            angle = np.pi * bars.frequency_cyc_per_px[0] * moving.blur_px_per_s[0] * times_s[-1]
            at = dict(f_number=rows.n_low, working_f_number=rows.n_low * rows.working_factor)
            unmoved = moving.transfer(bars, **at, blur_s=np.zeros(1))[0]
            left = unmoved * np.sin(angle) / angle * share
            assert np.isclose(left.min(), bars.least, rtol=1e-4)
    assert times_s[0] > 1.2 * times_s[1] > 0.0 and times_s[2] < 0.0


def test_without_bars_or_with_the_sun_times_stay() -> None:
    for rows in (lit(), lit(resolve_m=2e-3, sun=(10.0, 1.0))):
        assert while_sharp(rows).time_max_s == rows.time_max_s


def test_a_flash_that_fades_may_give_the_light_that_blurs_no_longer() -> None:
    rows = replace(lit(sharp(blur=4e4, place=0.0), resolve_m=2e-3, **FADING), time_max_s=np.array([1.0]))
    light_s, steady_s = while_sharp(rows).time_max_s, while_sharp(replace(rows, flash_decay_s=None)).time_max_s
    assert (light_s > 0.0).all() and (light_s < 0.99 * rows.flash.full_s).all()
    assert np.isclose(rows.blur_s(light_s), steady_s, rtol=1e-9).all() and not np.isclose(light_s, steady_s).any()


def test_bounds_in_a_veil_know_how_soon_bars_are_lost() -> None:
    """With the veil at pixels no time is shorter than that with all of it, and it is much shorter than without."""
    base = reef_of_few_parts().to_dict()
    murky = {**base["scenes"][0], "water": "1C"}
    asked = base["requirements"] | {"snr_at": "worst", "resolve_mm": 3.0, "max_blur_px": 40.0, "overlap": 0.0}
    fast = base["vehicle"] | {"speed_m_s": 2.0}
    mission = load_mission(base | {"scenes": [murky], "requirements": asked, "vehicle": fast})
    problem = build_problem(mission, selected(mission, load_catalog(mission), generic="never"))
    search = Search(problem, goal_of(mission), top=1)
    imager = np.arange(len(search.prepare()))[:40]
    under = Under.one(search.tables.lightings[0], len(imager))
    two, lamp = np.full(len(imager), 2), np.full(len(imager), search.bounds.light_tables[0].light[0])
    longest = {}
    for stage in ("none", "likely"):
        lights = search.tables.in_scenes(under, imager, veils="coarse" if stage == "likely" else stage)
        longest[stage] = search.rows(imager, lights, lamp, two, under, optimistic=True, stage=stage)[0].time_max_s
    lights = search.tables.in_scenes(under, imager)
    full = search.rows(imager, lights, lamp, two, under)[0]
    true_s = while_sharp(full).time_max_s
    seen = true_s > 0.0
    assert seen.any() and (longest["likely"] >= true_s - 1e-12).all()
    assert (longest["likely"] < 0.9 * longest["none"])[seen].any()

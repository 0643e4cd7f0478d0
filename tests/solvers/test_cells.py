"""Settings searched cell by cell: proofs attacked by random search (`settings_attack`)."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hand_made_rows import FADING, FLASHES, STEPS
from numpy.typing import NDArray
from settings_attack import COLOURED, attacked, figures, lit, opened_s, sharp, weighed
from thorough import drawn

from uwopt.deadline import Deadline, OutOfTimeError
from uwopt.forward.part_columns import CONTINUOUS, PULSED
from uwopt.forward.scene_rows import SceneRows
from uwopt.model.sharpness import jinc_and_slope, pupil_and_slope, sinc_and_slope
from uwopt.objectives.objective import Objective
from uwopt.solvers.settings import cell_bounds, cell_pool
from uwopt.solvers.settings.best import best_settings
from uwopt.solvers.settings.cell_bounds import Box, SceneCells
from uwopt.solvers.settings.cell_pool import Pool
from uwopt.solvers.settings.cell_windows import figures_at
from uwopt.solvers.settings.cells import CellSearch, best_by_cells
from uwopt.solvers.settings.question import Best, Question

Array = NDArray[Any]
GAP = 1e-4
CAMERA_W = np.array([3.0])
SEEDS = (0, 1, 4, 9, 12)  # even ones burn, odd ones pulse


def goal(wanted: Any) -> Objective:
    """An objective by name or weights, or itself."""
    return wanted if isinstance(wanted, Objective) else Objective.of(wanted)


def solved(rows: list[SceneRows], wanted: Any, **more: Any) -> Best:
    """One design."""
    return best_by_cells(Question.of(rows, np.array([False]), goal(wanted), CAMERA_W, np.inf, **more))


def value_of(found: Best, objective: Objective) -> float:
    """The objective at the answer."""
    power = max(float(c.light_power_w[0]) for c in found.chosen)
    terms = dict(
        power=power, snr_db=found.snr_db[0], contrast=found.contrast[0], information=found.information[0]
    )
    return float(weighed(objective, terms))


def check(rows: SceneRows, wanted: Any, seed: int, *, gap: float = GAP) -> Best:
    """The answer is feasible, as good as it says, within its gap, and random search never beats the bound."""
    objective = goal(wanted)
    found = solved([rows], wanted)
    attack = attacked(rows, objective, np.random.default_rng(seed))
    if not found.feasible[0]:
        assert found.lower_bound[0] == np.inf  # a proof, and it holds
        assert attack == np.inf
        return found
    value, chosen = value_of(found, objective), found.chosen[0]
    open_s = chosen.exposure_s + rows.exposure_offset_s if rows.sunlit else chosen.time_s
    again = figures(
        rows,
        chosen.f_number,
        chosen.time_s,
        np.asarray(open_s),
        chosen.level,
        info="information" in objective.weights,
    )
    assert again["ok"][0]
    for name in objective.weights:
        got = chosen.light_power_w[0] if name == "power" else getattr(found, name)[0]
        assert got == pytest.approx(again[name][0], rel=1e-7)
    assert found.lower_bound[0] <= value + 1e-9 * abs(value)
    assert value - found.lower_bound[0] <= gap * (1.0 if objective.quality else abs(value)) * (1 + 1e-6)
    assert attack >= found.lower_bound[0] - 1e-7 * abs(value)
    return found


# ---------------------------------------------------------------- proofs


@pytest.mark.parametrize("light", [{}, {"sun": (3e3, 2e3), "open_max_s": 5e-3}], ids=["lamps", "sun"])
def test_an_answer_keeps_the_snr_of_the_mean_beside_that_of_its_pixels(light: dict[str, Any]) -> None:
    wanted = dict(may_miss=3, min_mtf=0.05, min_snr=2.0, **light)
    least = [check(lit(min_snr_mean=of_mean, **wanted), "power", 0) for of_mean in (0.0, 12.0)]
    assert least[1].chosen[0].light_power_w[0] > 1.2 * least[0].chosen[0].light_power_w[0]


@pytest.mark.parametrize(("of_mean", "holds"), [(0.0, True), (8.1, True), (8.2, False)])
def test_a_point_holds_where_the_mean_has_its_snr_beside_the_pixels(of_mean: float, holds: bool) -> None:
    """80 electrons at the farthest altitude in a read noise of 4: 80 / sqrt(96) = 8.16."""
    rows = replace(lit(may_miss=3, read_noise_e=4.0, gain_dn_per_e=1e3, full_scale_dn=1e9, min_snr=1.0), **{
        "min_snr_mean": of_mean, "well_e": np.array([1e6])})  # fmt: skip
    assert bool(figures_at(rows, np.ones(1), np.ones(1), None)[2][0]) == holds


def random_rows(rng: np.random.Generator, *, kind: int, **more: Any) -> SceneRows:
    """A design drawn at random: light, noise, gain, sharpness."""
    values: dict[str, Any] = dict(
        signal_e=list(np.exp(rng.uniform(2, 7)) * np.array([1.2, 1.0, 0.7])), read_noise_e=rng.uniform(1, 12),
        gain_dn_per_e=np.exp(rng.uniform(-3, 0.5)), max_gain=float(rng.choice([1.0, 4.0, 16.0])),
        well_e=np.exp(rng.uniform(7, 10.5)), time_max_s=np.exp(rng.uniform(-7, -4)), kind=kind,
        min_level=float(rng.choice([0.0, 0.1])), min_snr=np.exp(rng.uniform(0.5, 3)),
        mean_level=float(rng.choice([0.0, 0.25])) or None, dark_current_e_s=float(rng.choice([0.0, 5.0])),
    )  # fmt: skip
    if rng.uniform() < 0.25:
        values.update(STEPS)
    look = sharp(
        blur=np.exp(rng.uniform(5, 8)),
        place=rng.uniform(0, 6),
        rms=rng.uniform(0, 8),
        rated=rng.uniform(0, 1.2),
    )
    values.update(more)
    return lit(look, **values)


@pytest.mark.parametrize("seed", drawn(SEEDS, range(14)))
@pytest.mark.parametrize("wanted", ["power", "snr_db"])
def test_least_power_and_most_snr_of_a_sharp_image(wanted: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows = random_rows(rng, kind=[CONTINUOUS, PULSED][seed % 2], min_mtf=rng.uniform(0.2, 0.6))
    check(rows, wanted, seed)


@pytest.mark.parametrize("seed", drawn(SEEDS[:3], range(14)))
def test_most_information(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    # 2e-4: where motion ends inside the Nyquist square, the bound's nodes and the model's differ by up to 1e-4.
    check(random_rows(rng, kind=[CONTINUOUS, PULSED][seed % 2]), "information", seed, gap=2e-4)


@pytest.mark.parametrize("seed", drawn(SEEDS[:2], range(10)))
@pytest.mark.parametrize("wanted", ["power", "snr_db"])
def test_sunlight_beside_lamps(wanted: str, seed: int) -> None:
    rng = np.random.default_rng(200 + seed)
    sun = (np.exp(rng.uniform(7, 11)), np.exp(rng.uniform(7, 11)))
    rows = random_rows(
        rng, kind=[CONTINUOUS, PULSED][seed % 2], sun=sun, veil=10.0, open_max_s=5e-3, time_max_s=4e-3,
        mean_level=None, min_level=0.0,
    )  # fmt: skip
    check(rows, wanted, seed, gap=1e-2)  # three or four dimensions: the gap is stated, not closed


# ---------------------------------------------------------------- limits


@pytest.mark.parametrize("kind", [CONTINUOUS, PULSED])
@pytest.mark.parametrize("wanted", ["power", "snr_db", {"power": 1.0, "snr_db": 2.0}])
def test_mtf_that_asks_for_nothing_leaves_the_closed_form(wanted: Any, kind: int) -> None:
    rows, objective = (
        lit(sharp(blur=0.0, place=0.0), kind=kind),
        Objective.of(wanted),
    )  # nothing is beyond a null
    args = (np.array([False]), objective, CAMERA_W, np.inf)
    easy, same = (best_settings(Question.of([each], *args)) for each in (rows, replace(rows, min_mtf=1e-12)))
    assert same.chosen[0].light_power_w == pytest.approx(easy.chosen[0].light_power_w, rel=1e-9)
    assert same.snr_db == pytest.approx(easy.snr_db, rel=1e-9)
    cells = best_by_cells(Question.of([replace(rows, min_mtf=1e-12)], *args))  # and so do the cells, to their gap
    value = (
        objective.weight("power") * easy.chosen[0].light_power_w - objective.weight("snr_db") * easy.snr_db
    )
    assert cells.lower_bound[0] <= value[0] + 1e-9 * abs(value[0])
    assert value_of(cells, objective) == pytest.approx(value[0], rel=2e-4)


@pytest.mark.parametrize("kind", [CONTINUOUS, PULSED])
def test_sun_that_hardly_shines_leaves_the_closed_form(kind: int) -> None:
    args = (np.array([False]), Objective.of("power"), CAMERA_W, np.inf)
    dark = best_settings(Question.of([lit(kind=kind)], *args))
    faint = best_settings(Question.of([lit(kind=kind, sun=(1e-9, 1e-9), open_max_s=5e-3)], *args))
    assert faint.chosen[0].light_power_w == pytest.approx(dark.chosen[0].light_power_w, rel=1e-4)


@pytest.mark.parametrize("wanted", ["power", "information"])
def test_scene_taken_twice_counts_once(wanted: str) -> None:
    rows = lit(min_mtf=0.3)
    once, twice = solved([rows], wanted), solved([rows, rows], wanted)
    objective = Objective.of(wanted)
    assert value_of(twice, objective) == pytest.approx(value_of(once, objective), rel=2e-4)


def test_power_and_information_weighed_together() -> None:
    for seed, kind in enumerate((CONTINUOUS, PULSED)):
        check(lit(kind=kind), {"power": 1.0, "information": 1e-4}, seed, gap=2e-4)


@pytest.mark.parametrize("seed", drawn(SEEDS[1:2], range(14)))
@pytest.mark.parametrize("per_w", drawn([0.01], [0.0, 0.01, 0.1]))
def test_best_image_for_the_price_of_its_power(per_w: float, seed: int) -> None:
    # 2e-4 as for information alone, here of the logarithm.
    wanted = Objective.best_image("information", per_w=per_w, per_money=0.0)
    check(random_rows(np.random.default_rng(300 + seed), kind=[CONTINUOUS, PULSED][seed % 2]), wanted, seed, gap=2e-4)


def test_best_image_where_light_is_dear() -> None:
    wanted = Objective.best_image("information", per_w=0.03, per_money=0.0)
    found = check(lit(), wanted, 5, gap=2e-4)
    assert found.chosen[0].level[0] < 1.0  # so that power and information are weighed, not at an end


def test_flash_and_lamp_with_steps() -> None:
    for rows in (lit(**FLASHES), lit(**STEPS)):
        check(rows, "information", 3)


@pytest.mark.parametrize(("wanted", "more"), [
    ("power", dict(min_mtf=0.45)),
    ("snr_db", dict(min_mtf=0.5, light_lm=2e4)),
    ("information", dict(dims_freely=False, levels=[0.1])),
    ("snr_db", dict(sun=(3e5, 1e5), veil=10.0, open_max_s=5e-3)),
])  # fmt: skip
def test_a_flash_that_fades_is_cut_where_its_light_pays(wanted: str, more: dict[str, Any]) -> None:
    rows = lit(sharp(blur=1500.0), **{**FADING, "light_lm": 2e5, **more})
    found = check(rows, wanted, 7, gap=1e-2 if rows.sunlit else 2e-4)
    needed_s = opened_s(rows, np.minimum(found.chosen[0].time_s, 0.98999e-3))
    assert found.chosen[0].exposure_s[0] >= needed_s[0] * (1 - 1e-9)


def test_contrast_under_sun_wants_the_lamps_at_full_level() -> None:
    # Lamps are cleaner than the sun: their share of the light is greatest at full level, whatever the aperture.
    # L = 20 klm, C = 100, veil 10; sun 25000 and 40000 e/s: (100 L + 25000) / (110 L + 65000), by hand.
    found = solved([lit(sun=(25000.0, 40000.0), veil=10.0)], "contrast")
    assert found.contrast[0] == pytest.approx((100 * 2e4 + 25000) / (110 * 2e4 + 65000), rel=1e-9)


def test_contrast_that_no_lamp_reaches_is_proven_infeasible() -> None:
    found = solved([lit(sun=(100.0, 40000.0), veil=200.0, min_contrast=0.5)], "power")
    assert not found.feasible[0] and found.lower_bound[0] == np.inf


def test_of_both_sides_of_a_place_the_first_that_fits_stands_for_both(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first of two places fits on its second side alone, the other on both."""
    seen: list[list[bool]] = []
    fits = np.array([False, True, True, True])
    monkeypatch.setattr(CellSearch, "_box", lambda *_: None)
    monkeypatch.setattr(CellSearch, "_points_in", lambda *_: SimpleNamespace(fits=fits))
    monkeypatch.setattr(CellSearch, "_keep", lambda _self, _design, points: seen.append(points[0].fits.tolist()))
    cells = CellSearch.__new__(CellSearch)
    cells.range = np.zeros((2, 2)), np.ones((2, 2))
    cells._try_places(np.arange(2), np.full((2, 2), 0.5))
    assert seen == [[False, True, True, False]]


def test_designs_beyond_the_cutoff_are_dropped() -> None:
    rows = lit(min_mtf=0.3)
    free = solved([rows], "power")
    beaten = solved([rows], "power", cutoff=0.5 * value_of(free, Objective.of("power")))
    assert not beaten.feasible[0]
    assert np.inf > beaten.lower_bound[0] >= 0.5 * free.lower_bound[0]


# ---------------------------------------------------------------- what tangents rest on


@pytest.mark.parametrize(
    ("factor", "null"),
    [(pupil_and_slope, 1.0), (jinc_and_slope, 1.2197), (sinc_and_slope, 1.0)],
    ids=["pupil", "disc", "box"],
)
def test_factors_of_the_transfer_are_concave_in_logarithms(factor: Any, null: float) -> None:
    at = np.linspace(np.log(1e-3 * null), np.log(0.9 * null), 4001)
    left, slope = factor(np.exp(at))
    value = np.log(left)
    assert (np.diff(slope) <= 1e-9).all()
    # Midpoint differences of the values: an independent slope, with its second-order error.
    assert np.allclose(np.diff(value) / np.diff(at), 0.5 * (slope[1:] + slope[:-1]), rtol=2e-3, atol=1e-5)


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        (dict(sun=(3e3, 2e3), open_max_s=5e-3, min_snr=12.0), "power"),
        (dict(veil=30.0, dark_current_e_s=50.0, min_mtf=0.1), {"snr_db": 1.0, "power": 0.05}),
    ],
)
def test_an_snr_that_most_pixels_reach(given: dict[str, Any], wanted: Any) -> None:
    """Three of twenty pixels are dark and may miss it; the others are brighter than the mean."""
    found, strict = (check(lit(may_miss=k, **given), wanted, 0) for k in (3, 0))
    assert found.feasible[0]
    assert found.lower_bound[0] < strict.lower_bound[0]


@pytest.mark.parametrize(
    "name", ["power of a red image under the sun", "power of lamps that balance the sun's colours"]
)
def test_colours_under_the_sun_hold_and_are_not_beaten(name: str) -> None:
    given, wanted = COLOURED[name]
    found = check(lit(**given), wanted, 0)
    asked = ("colours", "min_snr_red", "max_white_balance")
    free = solved([lit(**{key: value for key, value in given.items() if key not in asked})], wanted)
    assert found.feasible[0] and found.lower_bound[0] > free.lower_bound[0] + 1e-3 * abs(free.lower_bound[0])


@pytest.mark.parametrize("search", [best_by_cells, best_settings])
def test_cells_are_halved_no_longer_than_there_is_time(search: Any) -> None:
    """A diver's mission under the sun once waited 220 s in them for what would help."""
    rows = lit(veil=100.0, sun=(3e5, 2e5), well_e=9000.0)
    args = [rows], np.array([False]), Objective.of({"snr_db": 1.0, "power": 0.1}), CAMERA_W, np.inf
    assert search(Question.of(*args)).feasible[0]
    with pytest.raises(OutOfTimeError):
        search(Question.of(*args, deadline=Deadline.after(0.0)))


def test_what_cannot_fit_under_the_sun_is_not_asked_what_it_would_show(monkeypatch: pytest.MonkeyPatch) -> None:
    """That nothing fits over eelgrass beside strobes was not proven so in 490 s; it takes 50 s of the processor."""
    noon = dict[str, Any](
        sun=(3e4, 2e4), veil=10.0, open_max_s=5e-3, time_max_s=4e-3, kind=PULSED, well_e=20_000.0, min_mtf=0.3
    )
    shows = Objective.best_image("information", per_w=0.01, per_money=1e-4)
    beyond, fits = (
        Question.of([lit(min_snr=snr, **noon)], np.array([False]), shows, CAMERA_W, np.inf, gap_rel=0.1)
        for snr in (20.65, 10.0)
    )
    asked = list[int]()
    sound = cell_pool.surrogate_bit_per_px
    monkeypatch.setattr(cell_pool, "surrogate_bit_per_px", lambda *a, **k: asked.append(1) or sound(*a, **k))
    assert best_by_cells(beyond).lower_bound[0] == np.inf and asked
    asked.clear()
    assert best_settings(beyond).lower_bound[0] == np.inf and not asked
    assert best_settings(fits).feasible[0] and asked


def test_a_design_takes_no_more_cells_than_it_may(monkeypatch: pytest.MonkeyPatch) -> None:
    """One of 820 scenarios at the edge of what settings can do took 47 of 56 s; what it leaves is a bound still."""
    rows, wanted, halved, taken = lit(veil=100.0, sun=(3e5, 2e5), well_e=9000.0), {"snr_db": 1.0, "power": 0.1}, [], 0
    best = value_of(solved([rows], wanted), goal(wanted))
    sound = CellSearch._halved
    monkeypatch.setattr(CellSearch, "_halved", lambda self, pool: halved.append(len(pool.design)) or sound(self, pool))
    for most in (64, 512):
        cut = solved([rows], wanted, gap_rel=1e-12, most_cells=most)
        assert cut.lower_bound[0] <= best + GAP and not np.isinf(cut.lower_bound[0])
        assert most <= 2 * sum(halved) <= 4 * most and 2 * sum(halved) > taken
        taken = 2 * sum(halved)
        halved.clear()


def test_pixels_looked_at_block_by_block_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    points, most = SceneCells.points, 0

    def compared(self: SceneCells, *given: Any) -> Any:
        nonlocal most
        parts, whole, most = points(self, *given), self._points(*given), max(most, len(given[0]))
        for one, other in [*zip(vars(parts).values(), vars(whole).values(), strict=True)][1:]:
            assert np.array_equal(one, other, equal_nan=True)
        assert np.array_equal(parts.chosen.level, whole.chosen.level, equal_nan=True)
        return parts

    monkeypatch.setattr(cell_bounds, "PIXELS_AT_ONCE", 97 * 60 + 59)  # 97 cells of sixty pixels
    monkeypatch.setattr(SceneCells, "points", compared)
    rows = lit(sun=(3e3, 2e3), open_max_s=5e-3, min_snr=12.0, may_miss=3)
    assert solved([rows], {"snr_db": 1.0, "power": 0.05}).feasible[0] and most > 1000


def test_points_are_tried_where_one_may_better_what_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[int] = []
    monkeypatch.setattr(CellSearch, "_points_in", lambda _self, pool, *_: tried.extend(pool.design.tolist()))
    monkeypatch.setattr(CellSearch, "_keep", lambda *_: None)
    cells = CellSearch.__new__(CellSearch)
    cells.best, cells.share, cells.n_dim = np.array([1.0, 1.0, np.inf]), (1.0,), [0]
    side = np.zeros((3, 2))
    pool, box = Pool(np.arange(3), side, side + 1.0, np.array([1.0, 0.5, 0.5])), Box(*[np.ones(3)] * 8)
    cells._try_points(pool, [(box, None)], [(0.0, 0.5)])  # type: ignore[list-item]
    assert tried == [1, 2]

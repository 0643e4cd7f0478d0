"""Information that no settings exceed, by pieces of the f-numbers: against figures of single images, scene by scene."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import front_cases as fc
import numpy as np
import pytest
from test_cell_information import drawn, rows
from test_trade_curves import designs_of

from uwopt.forward.sharpness import SharpRows
from uwopt.solvers.front import ceilings
from uwopt.solvers.front.hopeful import Hopeful
from uwopt.solvers.settings import closed_form, windows

GAINS = np.array([0.1, 1.0, 4.0, 15.0])
#: Relative errors of integrals, without colour or with little and with much of it, by the factor on their nodes:
#: `information.RULE_ERROR` and what is told there of wide colour, each ten times; and half of what ceilings allow.
ALLOWED = {1.0: (1e-4, 1e-3), ceilings.ROUGHLY: (ceilings.RULE_SLACK / 2.0, ceilings.WIDE_SLACK / 2.0)}


@pytest.mark.parametrize("colour_px", [0.0, 0.5, 1.5, 9.0])
@pytest.mark.parametrize("widest_px", [0.7, 2.0, np.inf])
@pytest.mark.parametrize(("fineness", "smeared"), [(1.0, 0.1), (ceilings.ROUGHLY, 0.1), (ceilings.ROUGHLY, 3.0)])
def test_wide_colour_counted_as_less_hides_no_information(
    colour_px: float, widest_px: float, fineness: float, smeared: float
) -> None:
    """The model's own figure at each contrast is below the table, and equals it where no colour is cut."""
    some, given, figures = told_by_model(colour_px, smeared)
    most = some.most_bit_per_px(GAINS, **given, widest_px=widest_px, fineness=fineness)
    allowed = ALLOWED[fineness][colour_px > ceilings.NARROW_PX]
    assert (figures <= most * (1.0 + allowed)).all()
    if colour_px <= widest_px:
        assert most == pytest.approx(figures, rel=max(3e-4, allowed) if fineness < 1.0 else 3e-4)


@cache
def told_by_model(colour_px: float, smeared: float) -> tuple[SharpRows, dict[str, Any], Any]:
    """Designs, settings, and what the model says that a pixel of each tells at each contrast, (150, n_gains)."""
    some = rows(colour_px).take(np.arange(150))
    f_number, time_s, _ = (column[:150] for column in drawn(np.random.default_rng(3)))
    given = dict(f_number=f_number, working_f_number=1.1 * f_number, blur_s=smeared * time_s)
    each = [some.information_bit_per_m2(gain / 0.1 / some.texture_gain, **given) for gain in GAINS]
    return some, given, np.stack(each, axis=1) * some.pixel_area_m2[:, None]


def test_chords_lie_above_what_they_stand_for_and_near_it() -> None:
    """One frequency with transfer m tells (1/2) log2(1 + g^2 m^2)."""
    level = np.linspace(0.0, ceilings.LEVELS[-1], 4000)
    for transfer in (1.0, 0.6, 0.2, 0.01):
        for every, near in ((1, 0.002), (4, 0.09)):
            levels = ceilings.LEVELS[::every]
            table = 0.5 * np.log2(1.0 + np.expm1(levels) * transfer**2)[None]
            truth = 0.5 * np.log2(1.0 + np.expm1(level) * transfer**2)
            inside = level <= levels[-1]
            chord = ceilings._on_chords(table, levels, np.zeros(len(level), int), level)
            assert (chord >= truth * (1.0 - 1e-12)).all()
            assert (chord - truth)[inside & (level > 0.5)].max() < near * 1.5
            assert np.isinf(chord[~inside]).all()


def noisy_and(some: Hopeful, **other: object) -> Hopeful:
    """The same designs at two places: in one the camera is noisier, in the other sharpness differs."""
    (here,) = some.rows
    here = replace(here, min_snr=0.0 * here.min_snr)
    assert here.sharp is not None
    noisy = replace(here, read_noise_e=here.read_noise_e * 100.0)
    return replace(some, rows=[noisy, replace(here, sharp=replace(here.sharp, **other))])


@pytest.mark.parametrize("motorised", [False, True])
@pytest.mark.parametrize("other", ["out of focus", "from afar"])
def test_each_scene_has_its_own_light_and_a_motorised_lens_its_own_f_number(motorised: bool, other: str) -> None:
    """Settings tried scene by scene: noise asks for a wide aperture, defocus for a small one; and where a pixel sees
    much floor, information is low for another reason than the SNR of the noisy scene."""
    search, designs = designs_of("dims", "information")
    for one in designs:
        sharp = one.rows[0].sharp
        assert sharp is not None
        changed = (
            {"rms_disc_px": 0.0 * sharp.rms_disc_px + 40.0}
            if other == "out of focus"
            else {"pixel_area_m2": 20.0 * sharp.pixel_area_m2}
        )
        both = replace(noisy_and(one, **changed), motorised=np.array([motorised]))
        limit_w = both.full_power_w[:, None]
        most = ceilings.most_information(both, limit_w, np.array([[-np.inf]]), search.trade.most_snr_db)[0, 0]
        closed = search.trade.bounds_within(both, limit_w)[0, 0]
        f_number = np.geomspace(both.rows[0].n_low[0], both.rows[0].n_high[0], 300)
        tried = np.array([image_of(scene, f_number) for scene in both.rows])
        best = tried.max(axis=1).min() if motorised else tried.min(axis=0).max()
        assert best <= most * (1.0 + 1e-9)
        assert best <= closed * (1.0 + 1e-9)
        assert most < 1.1 * best


def image_of(scene: fc.Any, f_number: np.ndarray) -> np.ndarray:
    """Information of full light for the longest time that blurs as little as the shortest: no settings are better."""
    n = len(f_number)
    many = scene.take(np.zeros(n, int))
    low, high = windows.window(many)
    time_s = many.time_max_s
    light_x = np.minimum(many.light_lm * time_s / np.square(f_number * many.working_factor), high)
    snr = closed_form.nominal_snr(many, light_x)
    bits = many.sharp.information_bit_per_m2(
        snr, f_number=f_number, working_f_number=f_number * many.working_factor, blur_s=many.blur_s(many.time_min_s)
    )
    return np.where(light_x >= low, bits, -np.inf)


def test_tables_of_colour_are_found_again_when_lists_without_any_are_joined_twice() -> None:
    coloured = rows(1.5).take(np.arange(2))
    table = coloured.spreads[0]
    many = replace(coloured, spreads=(table, replace(table), replace(table)), spread_index=np.array([2, 2]))
    plain = replace(rows(0.0).take(np.arange(2)), spreads=(), spread_index=np.array([2, 2]))
    only = replace(coloured, spread_index=np.array([0, 0]))
    once = SharpRows.joined([only, plain])
    twice = SharpRows.joined([once, many])
    assert twice.spread_index.max() < len(twice.spreads)

"""Times of flashes as columns: fading ones beside steady ones and other lamps."""

from __future__ import annotations

import numpy as np
import pytest

from uwopt.forward.flash_times import FlashTimes
from uwopt.model import flash

TAU_S = 1e-3
MIXED = FlashTimes(np.array([TAU_S, np.inf, np.inf]), np.array([TAU_S * np.log(100.0), 2e-3, np.inf]))
FADING = MIXED.take(np.zeros(50, int))


def test_fading_and_steady_flashes_and_other_lamps_stand_side_by_side() -> None:
    assert MIXED.full_s == pytest.approx([0.99e-3, 2e-3, np.inf])
    at_1_ms = MIXED.light_s(np.full(3, 1e-3))
    assert at_1_ms == pytest.approx([TAU_S * (1.0 - np.exp(-1.0)), 1e-3, 1e-3])
    assert MIXED.open_s(at_1_ms) == pytest.approx(1e-3)
    assert MIXED.blur_s(at_1_ms)[1:] == pytest.approx(1e-3)
    # all of it, whatever the last digit
    assert MIXED.open_s(np.array([0.99e-3 * (1.0 - 1e-12), 0.0, 0.0]))[0] == MIXED.whole_s[0]
    assert MIXED.light_s(np.full(3, 1.0))[0] == pytest.approx(0.99e-3)


def test_the_light_within_a_blur_is_all_that_blurs_no_more() -> None:
    blur_s = np.geomspace(1e-6, 3.0e-3, 50)  # a whole one blurs as 3.07 ms of steady light
    within = FADING.within_blur_s(blur_s)
    assert FADING.blur_s(within) == pytest.approx(blur_s, rel=1e-9)
    assert FADING.within_blur_s(np.full(50, 4e-3)) == pytest.approx(0.99e-3)
    assert FADING.within_blur_s(np.full(50, np.inf)) == pytest.approx(0.99e-3)


def test_no_more_of_a_flash_comes_than_its_bound_says() -> None:
    longest_s = np.geomspace(1e-5, 5e-3, 50)
    bound, whole = FADING.most_share(longest_s), 0.99e-3
    # by the shutter: 1 - exp(-t / tau) of it; by the blur: what is out when the flash has blurred so long
    by_shutter = np.minimum(TAU_S * (1.0 - np.exp(-longest_s / TAU_S)) / whole, 1.0)
    tried = np.linspace(0.0, TAU_S * np.log(100.0), 20_001)[1:]
    smeared = flash.fading_blur_time_s(tried, decay_s=TAU_S)
    last = np.searchsorted(smeared, longest_s, side="right") - 1
    by_blur = np.where(last >= 0, TAU_S * (1.0 - np.exp(-tried[np.maximum(last, 0)] / TAU_S)) / whole, 0.0)
    assert (bound >= by_shutter - 1e-12).all() and (bound >= by_blur - 1e-12).all()
    assert bound == pytest.approx(np.maximum(by_blur, by_shutter), abs=1e-3)  # and is no larger than it must be

"""Where settings are likely to be best, by a stand-in whose top is known."""

from __future__ import annotations

import numpy as np
import pytest

from uwopt.solvers.settings.cell_start import likely_settings

LOW, HIGH = np.log([1.4, 1e-4]), np.log([16.0, 1e-2])  # f-number, time


def places_of(top, fits=lambda place: np.ones(len(place), bool)):
    """Of one design whose stand-in is a bowl about a place; of another, number 1, nothing is asked."""

    def bowl(design, place):
        assert (design == 0).all()
        which = np.nonzero(fits(place))[0]
        return which, np.square(place[which] - np.log(top)).sum(axis=1)

    return np.exp(likely_settings(2, np.array([0]), LOW[None], HIGH[None], [0], bowl))


@pytest.mark.parametrize("f_number", [1.4, 2.0, 3.3, 5.7, 11.0, 16.0])
@pytest.mark.parametrize("time_s", [1e-2, 0.86e-2, 0.67e-2, 0.45e-2])
def test_top_is_met_to_a_few_percent(f_number, time_s):
    (found, asked_nothing) = places_of([f_number, time_s])
    assert found[0] == pytest.approx(f_number, rel=0.05)  # half the closest steps, and half of what lies between
    assert found[1] == pytest.approx(time_s, rel=0.02)  # the steps that are tried
    assert np.isnan(asked_nothing).all()


def test_only_what_fits_is_likely():
    found, _ = places_of([2.0, 1e-2], fits=lambda place: place[:, 0] > np.log(4.0))
    assert 4.0 < found[0] < 4.7
    found, _ = places_of([2.0, 1e-2], fits=lambda place: np.zeros(len(place), bool))
    assert np.isnan(found).all()

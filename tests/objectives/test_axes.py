"""Axes by name, and the box that fronts are compared in; expected values by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uwopt.errors import MissionError
from uwopt.objectives.axes import Axes, Frame, scale
from uwopt.objectives.objective import Terms

NUMBERS = st.floats(-1e6, 1e6)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["power"], r"one objective has no front.*uwopt solve"),
        ([], r"0 objectives have no front.*name two or three"),
        (["power", "cost", "mass", "gsd_mm"], r"4 objectives have no front"),
        (["power", "snr"], r"'snr' is no figure.*did you mean snr_db\?"),
        (["power", "beauty of it"], r"'beauty of it' is no figure.*there are power, cost"),
        (["cost", "power", "cost"], r"cost stands twice"),
        (["cost", " Cost "], r"cost stands twice"),
    ],
)
def test_bad_axes_are_told_with_a_way_out(names, message):
    with pytest.raises(MissionError, match=message):
        Axes.of(names)


def test_all_faults_are_told_at_once():
    with pytest.raises(MissionError, match=r"(?s)pwoer.*costs|costs.*pwoer"):
        Axes.of(["pwoer", "costs"])


def test_names_are_read_as_people_write_them():
    assert Axes.of([" Power", "SNR-dB"]).names == ("power", "snr_db")


def test_what_is_maximised_is_negated_and_columns_keep_their_order():
    terms = Terms(
        np.array([1.0, 2.0]), np.array([3.0, 4.0]), np.zeros(2), np.array([30.0, 20.0]), np.ones(2), 0.5
    )
    axes = Axes.of(["snr_db", "cost", "contrast"])
    assert axes.minimised(terms).tolist() == [[-30.0, 3.0, -0.5], [-20.0, 4.0, -0.5]]
    assert axes.index("cost") == 1
    assert axes.index("power") is None


def test_only_positive_power_cost_and_mass_are_compared_by_ratio():
    axes = Axes.of(["power", "cost", "gsd_mm"])
    assert axes.logarithmic(np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])).tolist() == [True, True, False]
    assert axes.logarithmic(np.array([[1.0, 0.0, 3.0], [4.0, 5.0, 6.0]])).tolist() == [True, False, False]


def test_frame_by_hand():
    # power 1 to 100 W by ratio: 10 W lies in the middle; snr 30 to 10 dB linear: 25 dB lies at a quarter
    frame = Frame.of(Axes.of(["power", "snr_db"]), np.array([[1.0, -10.0], [100.0, -30.0]]))
    assert frame.unit(np.array([[10.0, -25.0]]))[0] == pytest.approx([0.5, 0.25])
    assert frame.reference.tolist() == [1.1, 1.1]
    assert frame.values(np.array([[0.5, 0.25]]))[0] == pytest.approx([10.0, -25.0])


@pytest.mark.parametrize("row", [[5.0, -30.0], [1.0, 0.0], [1e-3, 7.0]])
def test_axis_without_range_has_a_finite_frame(row):
    frame = Frame.of(Axes.of(["cost", "snr_db"]), np.array([row, row]))
    assert (frame.span > 0).all()
    assert frame.unit(np.array([row]))[0] == pytest.approx([0.0, 0.0])


def test_frame_holds_zeros_and_negatives_as_they_are():
    frame = Frame.of(Axes.of(["power", "cost"]), np.array([[0.0, 10.0], [4.0, 1000.0]]))
    assert frame.log.tolist() == [False, True]
    assert frame.unit(np.array([[1.0, 100.0]]))[0] == pytest.approx([0.25, 0.5])


def test_what_is_nothing_on_a_logarithmic_axis_is_far_below_all_and_finite():
    frame = Frame.of(Axes.of(["power", "cost"]), np.array([[1.0, 10.0], [4.0, 1000.0]]))
    unit = frame.unit(np.array([[0.0, 10.0]]))
    assert np.isfinite(unit).all()
    assert unit[0, 0] < -100.0


@given(
    values=st.lists(st.tuples(st.floats(1e-3, 1e6), NUMBERS), min_size=1, max_size=20),
    place=st.tuples(st.floats(-0.5, 2.0), st.floats(-0.5, 2.0)),
)
def test_places_and_values_are_inverse(values, place):
    frame = Frame.of(Axes.of(["power", "snr_db"]), np.array(values))
    back = frame.unit(frame.values(np.array([place])))[0]
    # the ideal is subtracted again: as many digits are lost as it is larger than the span
    lost = np.abs(frame.ideal) / frame.span
    assert np.abs(back - place).max() <= 1e-12 * (1.0 + lost.max())


@given(values=st.lists(st.tuples(st.floats(1e-3, 1e6), NUMBERS), min_size=2, max_size=20))
def test_the_front_lies_between_its_corners(values):
    unit = Frame.of(Axes.of(["power", "snr_db"]), np.array(values)).unit(np.array(values))
    assert (unit >= 0.0).all()
    assert (unit <= 1.0 + 1e-9).all()


@given(factor=st.floats(1e-3, 1e3))
def test_other_currencies_give_the_same_places(factor):
    axes, values = Axes.of(["cost", "snr_db"]), np.array([[100.0, -3.0], [250.0, -20.0], [999.0, -31.0]])
    other = values * [factor, 1.0]
    assert Frame.of(axes, other).unit(other) == pytest.approx(Frame.of(axes, values).unit(values), abs=1e-9)


def test_scale_takes_logarithms_where_asked():
    scaled = scale(np.array([[np.e, -2.0]]), np.array([True, False]))
    assert scaled[0] == pytest.approx([1.0, -2.0])

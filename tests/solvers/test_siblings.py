"""Cameras with the sensor of the recommended one: which are told, and that they meet the mission."""

from __future__ import annotations

from typing import Any

import pytest
from one_of_each import one, with_parts

from uwopt.catalog.records import exact
from uwopt.deadline import Deadline, OutOfTimeError
from uwopt.solvers.explain import same_sensor as module
from uwopt.solvers.explain.same_sensor import siblings
from uwopt.solvers.recommend import Sought

FAST = {"max_blur_px": 1.0, "min_snr_db": 26.0}
OWN: dict[str, Any] = {"chip": "IMX000", "interface": "USB3"}


def sought_among(others: list[dict[str, Any]], **wanted: Any) -> Sought:
    """A search among a camera of 1000 USD and 3 W with a named sensor and these, each changed from it."""
    dearer = [{"price": exact(1100.0 + n), **OWN, **other} for n, other in enumerate(others)]
    case_ = with_parts(one("cost", wanted=FAST | wanted, camera=OWN), cameras=dearer)
    search, outcome = case_.solve(top=1)
    return Sought(None, search.problem, search, outcome)  # type: ignore[arg-type]


def told(others: list[dict[str, Any]], **wanted: Any) -> list[dict[str, Any]]:
    """What is said of them."""
    return siblings(sought_among(others, **wanted))


def test_the_same_chip_in_another_case_is_told_with_what_it_costs() -> None:
    found = told([{"price": exact(1300.0), "interface": "GigE"}, {"price": exact(1200.0)}])
    assert [(item["part"], item["interface"]) for item in found] == [("camera-1", "USB3"), ("camera-0", "GigE")]
    # Without lamp 1800 USD and with it 500 more, of which the camera is 1000 (one_of_each).
    assert [item["value"] for item in found] == pytest.approx([2500.0, 2600.0])


@pytest.mark.parametrize(
    "other", [{"chip": "IMX001"}, {"chip": ""}, {"colour": "colour"}, {"shutter": "rolling"}, {"pixel_pitch_um": 4.5},
              {"resolution_x_px": 1900}, {"purpose": "complete camera"}],
)  # fmt: skip
def test_what_takes_other_images_is_no_sibling(other: dict[str, Any]) -> None:
    assert [item["part"] for item in told([other, {}])] == ["camera-1"]


def test_cameras_without_a_named_chip_have_no_siblings() -> None:
    case_ = with_parts(one("cost", wanted=FAST), cameras=[{"price": exact(1100.0)}])
    search, outcome = case_.solve(top=1)
    assert siblings(Sought(None, search.problem, search, outcome)) == []  # type: ignore[arg-type]


def test_a_few_columns_less_of_the_same_chip_are_a_sibling() -> None:
    assert [item["part"] for item in told([{"resolution_x_px": 1984}])] == ["camera-0"]


def test_a_sibling_that_misses_the_mission_is_not_told() -> None:
    noisy = {"read_noise_e": exact(500.0), "saturation_e": exact(600.0)}
    slow = {"max_frame_rate_hz": exact(0.1)}  # of 0.284 images a second
    assert [item["part"] for item in told([noisy, slow, {}])] == ["camera-2"]


def test_what_time_does_not_reach_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def too_late(*given: Any) -> list[float]:
        raise OutOfTimeError

    sought = sought_among([{}])
    monkeypatch.setattr(module, "best_of_each", too_late)
    deadline = Deadline()
    assert siblings(sought, deadline) == []
    assert deadline.left_out == [module.UNREACHED]

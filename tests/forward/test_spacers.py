"""Spacer rings: which one a focus needs, what a system with one costs, and what it is set to."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import uwopt
from uwopt.catalog.records import Lens, exact
from uwopt.catalog.spacers import rings_in_words, stacks_mm
from uwopt.errors import CatalogError, MissionError
from uwopt.forward.enclosures import bodies_of
from uwopt.forward.part_columns import Lenses
from uwopt.forward.part_rows import lens_rows
from uwopt.forward.spacers import lens_with_spacers, needed_spacer_m, without_spacers
from uwopt.results.result import Result

# 10 mm, nearest 0.26 m: own x_0 = 0.1 / 250 m = 0.4 mm
LENS = Lens("lens", focal_length_mm=10.0, min_object_distance_m=exact(0.26), mounts=("C",), spacers_mm=(0.25, 1.0))
SYSTEM: dict[str, Any] = {
    "camera": {"resolution_x_px": 1000, "resolution_y_px": 800, "pixel_pitch_um": 5.0, "qe": 0.5, "read_noise_e": 5.0,
               "saturation_e": 10_000, "price": 1000, "power_w": 3, "max_frame_rate_hz": 30, "mass_g": 50},
    "lens": {"focal_length_mm": 10, "min_object_distance_m": 0.26, "spacers_mm": [0.25, 1], "price": 200, "mass_g": 50},
    "port": {"geometry": "flat", "thickness_mm": 0.01, "price": 100, "mass_g": 100},
    "light": {"flux_lm": 5000, "power_w": 50, "beam_angle_deg": 80, "price": 300, "mass_g": 100},
    "light_baseline_m": 0.5,
}  # fmt: skip


def columns(*lenses: Lens) -> Lenses:
    """Lenses in SI."""
    return lens_rows(lenses, money=lambda amount, _: amount)


def evaluated(altitude_m: float, spacers: str = "allow", **system: Any) -> Result:
    """A system at an altitude before a flat port of no thickness."""
    return uwopt.evaluate({
        "practice": "bare", "scene": {"water": "II", "seafloor": 0.2, "depth_m": 10, "temperature_c": 10},
        "vehicle": {"altitude_m": altitude_m, "speed_m_s": 0.1, "camera_count": 2},
        "requirements": {"overlap": 0.3}, "catalog": {"spacers": spacers},
    }, {**SYSTEM, "camera_count": 2, **system})  # fmt: skip


@pytest.mark.parametrize(
    ("distance_m", "ring_m"),
    [(1.0, 0.0), (0.26, 0.0), (0.2599, 0.25e-3), (0.17, 0.25e-3), (0.16, np.nan), (0.1, 1e-3), (0.08, np.nan)],
)
def test_least_ring_on_which_a_lens_focuses(distance_m: float, ring_m: float):
    # On 0.25 mm from 0.010 + 1e-4 / 0.65e-3 = 0.1638 m to 0.410 m, on 1 mm from 0.0814 m to 0.110 m: a gap between
    assert needed_spacer_m(columns(LENS), np.array([1 / distance_m]))[0] == pytest.approx(ring_m, nan_ok=True)


def test_of_the_rings_that_are_sold_each_stands_once_in_a_stack():
    # 0.25, 0.5, 1, 5 and 10 mm: seven sums of the three thin ones, and those with 5 mm, and 10 mm alone
    thin = [0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75]
    assert stacks_mm("C") == (*thin, 5.0, *(5.0 + each for each in thin), 10.0)
    assert rings_in_words(["C"], 1.75) == "1 + 0.5 + 0.25 mm" and rings_in_words([], 0.3) == "0.3 mm"


def test_mounts_tell_what_may_stand_behind_a_lens():
    plain = Lens("lens", focal_length_mm=10.0, mounts=("C",))
    assert lens_with_spacers(plain).spacers_mm == stacks_mm("C")
    board = lens_with_spacers(Lens("lens", focal_length_mm=10.0, mounts=("M12",)))
    assert board.spacers_mm == () and board.thread_travel_mm.value == 1.5
    photo = lens_with_spacers(Lens("lens", focal_length_mm=10.0, mounts=("EF",)))
    assert (photo.spacers_mm, photo.thread_travel_mm, photo.max_magnification) == ((), None, None)
    assert lens_with_spacers(LENS).spacers_mm == (0.25, 1.0) and without_spacers(LENS).spacers_mm == ()


def test_a_system_takes_the_ring_that_its_focus_needs_and_tells_what_to_set():
    # q = 0.25 m, seawater 1.341: s = 0.1864 m, x = 1e-4 / 0.1764 = 0.567 mm, 0.25 mm of it the ring's, 0.317 mm
    # the lens's own: 0.010 + 1e-4 / 0.317e-3 = 0.3255 m on its scale
    result = evaluated(0.25)
    design = result.design
    assert design is not None and design.hardware.spacer_mm == pytest.approx(0.25)
    settings = design.scenes[0].settings
    assert settings["spacer_mm"] == pytest.approx(0.25) and settings["focus_scale_m"] == pytest.approx(0.3255, rel=4e-3)
    (row,) = [row for row in design.bom if row.id == "spacer-ring"]
    assert (row.count, row.unit_price) == (2, 30.0) and "0.25 mm" in row.model
    bare = evaluated(0.25, spacers="none").design
    assert bare is not None and not bare.feasible
    assert design.totals.cost.value - bare.totals.cost.value == pytest.approx(60.0)
    assert design.totals.mass_kg - bare.totals.mass_kg == pytest.approx(2 * 0.003)  # 0.5 to 17 g, middle 3 g


@pytest.mark.parametrize(
    ("altitude_m", "missed"), [(0.25, set()), (0.6, {"farthest_focus_m"}), (0.2, {"nearest_focus_m"})]
)
def test_a_ring_that_is_written_is_held_against_the_focus(altitude_m: float, missed: set[str]):
    # in air 0.19, 0.45 and 0.15 m; on 0.25 mm the lens focuses from 0.164 to 0.410 m
    design = evaluated(altitude_m, spacer_mm=0.25).design
    assert design is not None
    margins = [m for m in design.scenes[0].margins if m.requirement.endswith("focus_m")]
    assert {m.requirement for m in margins if not m.satisfied} == missed and len(margins) == 2


def test_rings_that_cannot_be_are_refused():
    with pytest.raises(MissionError, match="spacer_mm"):
        evaluated(0.25, spacer_mm=-1)
    with pytest.raises((MissionError, CatalogError), match="spacers_mm"):
        evaluated(0.25, lens={**SYSTEM["lens"], "spacers_mm": [0]})


def test_a_ring_makes_lens_and_camera_longer():
    # 40 mm from pupil to plug without, 41.5 mm on 1.5 mm
    cameras = SimpleNamespace(body_width_m=0.03, body_height_m=0.03, body_length_m=0.02, plug_m=0.0)
    lenses = SimpleNamespace(diameter_m=0.03, length_m=0.03, pupil_m=0.01)
    behind = [bodies_of(cameras, lenses, ring).behind_pupil_m for ring in (0.0, 1.5e-3)]  # type: ignore[arg-type]
    assert behind == pytest.approx([0.040, 0.0415])

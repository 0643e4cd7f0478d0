"""Where the one focus of all scenes lies, and the f-number that then keeps them sharp."""

from __future__ import annotations

from math import hypot
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import uwopt
from uwopt.forward.focus import middle_focus, sharp_ends_m

pytestmark = pytest.mark.usefixtures("undoubted")

PARTS = Path(__file__).parents[1] / "rule_parts"
KINDS = {"cameras": "zz-global", "lenses": "zz-12mm", "ports": "zz-window", "lights": "zz-led"}
FOCAL_M = 1.33 * 12e-3  # physics `paper` behind a flat port
COC_M = hypot(1936, 1216) * 5.86e-6 / 1500


def f_number_of(*altitudes_m: float, lens: str = "zz-12mm", **scene: Any) -> list[float]:
    """What `solve` sets in scenes at these altitudes; hardly any light is asked for."""
    scenes = [
        {"name": f"at {a} m", "water": "II", "seafloor": 0.3, "depth_m": 30, "altitude_m": a, **scene}
        for a in altitudes_m
    ]
    best = uwopt.solve({
        "practice": "bare", "name": "focus", "objective": "power", "physics": "paper", "scenes": scenes,
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, "orientation": "landscape", "light_count": 1},
        "requirements": {"overlap": 0.2, "min_snr_db": 0},
        "catalog": {"files": [str(PARTS / f"{kind}.csv") for kind in KINDS], "generic": "never",
                    **{kind: [name] for kind, name in {**KINDS, "lenses": lens}.items()}},
    }).recommendation  # fmt: skip
    assert best is not None
    return [float(scene.settings["f_number"]) for scene in best.scenes]


def test_scenes_at_two_altitudes_are_both_sharp_with_the_f_number_of_the_thin_lens() -> None:
    # Focus in the dioptric middle of 1 m and 3 m: N = f^2 / c * (1/1 - 1/3) / 2 / (1 - f (1/1 + 1/3) / 2) = 9.6
    expected = FOCAL_M**2 / COC_M * (1 / 3) / (1 - FOCAL_M * 2 / 3)
    assert f_number_of(1.0, 3.0) == pytest.approx([expected] * 2, rel=1e-9)


def test_one_altitude_without_depth_of_field_takes_the_widest_opening() -> None:
    assert f_number_of(1.0) == [1.4]


def test_a_motorised_lens_stops_down_in_each_scene_for_itself() -> None:
    """The focus is common, in the middle of 1 m, 3 m and (by half) 1.5 m, which lies there already."""
    first, middle, last = f_number_of(1.0, 1.5, 3.0, lens="zz-12mm-motor")
    assert first == pytest.approx(last, rel=1e-9) and first > 9.0
    assert middle == 1.4


@pytest.mark.parametrize(("min_dof_m", "ends_m"), [(None, (2.0, 2.0)), (0.5, (1.0, 3.0)), (4.0, (1.0, 5.0))])
def test_all_of_the_altitudes_and_the_wanted_depth_are_sharp(min_dof_m: float | None, ends_m: Any) -> None:
    wishes = SimpleNamespace(requirements=SimpleNamespace(min_dof_m=min_dof_m))
    scene: Any = SimpleNamespace(range_m=np.array([1.0, 2.0, 3.0]), nominal=1, view=wishes)
    assert sharp_ends_m(scene) == ends_m


@pytest.mark.parametrize("seed", range(5))
def test_the_common_focus_needs_the_least_f_number(seed: int) -> None:
    """Against trying every focus between the ends: the largest of what the scenes ask for is least there."""
    rng = np.random.default_rng(seed)
    far = rng.uniform(0.1, 2.0, (3, 1))
    near, coc = far + rng.uniform(0.0, 1.0, (3, 1)), rng.uniform(5e-6, 4e-5, (3, 1))

    def needed(focus: Any) -> Any:
        return (np.maximum(near - focus, focus - far) / coc / (1.0 - FOCAL_M * focus)).max(axis=0)

    found = middle_focus(list(zip(near, far, strict=True)), list(coc))
    tried = np.linspace(far.min(), near.max(), 20_001)
    assert needed(found) <= needed(tried).min() * (1 + 1e-12)

"""What a lens that is focused near makes of the field of view, told beside figures for its focal length at infinity."""

from __future__ import annotations

from typing import Any

import pytest

import uwopt
from uwopt.evaluation.breathing import breathing_notes

MISSION: dict[str, Any] = {
    "practice": "bare", "scene": {"water": "II", "seafloor": "sand", "depth_m": 20},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, "light_count": [1, 2]},
    "requirements": {"overlap": 0.6, "max_blur_px": 1.0, "min_snr_db": 20.0},
    "catalog": {"cameras": ["flir"], "lenses": ["computar*"], "ports": ["*dome*"], "generic": "never"},
}  # fmt: skip


@pytest.mark.parametrize(("share", "code"), [(0.0, "breathing"), (0.99, "narrowed")])
def test_solve_says_what_is_left_of_the_swath_behind_a_dome(share: float, code: str) -> None:
    plain = uwopt.solve(MISSION, quick=True).best
    assert plain is not None
    asked = MISSION["requirements"] | ({"min_swath_m": share * plain.scenes[0].figures["swath_m"]} if share else {})
    result = uwopt.solve(MISSION | {"requirements": asked}, quick=True)
    assert result.best is not None
    (note,) = [one for one in result.warnings if one.code in ("breathing", "narrowed")]
    figures = result.best.scenes[0].figures
    # thin lens: focused on a virtual image at s it stands f s / (s - f) before the sensor, f (1 + m)
    left_m = figures["swath_m"] / (figures["working_f_number"] / figures["f_number"])
    assert note.code == code and f"{left_m:.3g} m, not" in note.message
    assert breathing_notes(result.best) == [note]

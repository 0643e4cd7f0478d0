"""Reserves, lenses stopped down and leaning lamps in an evaluation: margins, defaults and warnings."""

from __future__ import annotations

from typing import Any

import pytest

import uwopt
from uwopt.results.design import Margin
from uwopt.results.result import Result

MISSION: dict[str, Any] = {
    "practice": "bare", "scene": {"water": "II", "seafloor": 0.3, "depth_m": 40},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.2, "light_baseline_m": 0.6, "light_count": 2},
    "requirements": {"overlap": 0.5, "max_blur_px": 2.0, "min_swath_m": 1.0, "min_snr_db": 10},
    "physics": "full",
}
SYSTEM: dict[str, Any] = {
    "camera": {"resolution_x_px": 1600, "resolution_y_px": 1200, "pixel_pitch_um": 4.5, "read_noise_e": 6,
               "saturation_e": 20000, "bit_depth": 12, "quantum_efficiency": 0.6, "max_frame_rate_hz": 20},
    "lens": {"id": "glass", "focal_length_mm": 8, "f_number_min": 1.8, "f_number_max": 16, "transmission": 0.9},
    "port": {"id": "window", "geometry": "flat", "thickness_mm": 10, "gap_mm": 5, "depth_rating_m": 100},
    "light": {"id": "lamp", "flux_lm": 12000, "power_w": 120, "beam": "cosine-power", "beam_angle_deg": 40,
              "depth_rating_m": 100},
    "light_count": 2, "light_baseline_m": 0.6, "settings": {"f_number": 4.0, "exposure_ms": 2.0},
}  # fmt: skip


def evaluated(*, reserve: Any = None, lens: Any = (), settings: Any = (), **wanted: Any) -> Result:
    """The system in the mission with what a test changes."""
    mission = {**MISSION, "requirements": {**MISSION["requirements"], **wanted}, "reserve": reserve}
    system = {
        **SYSTEM, "lens": {**SYSTEM["lens"], **dict(lens)}, "settings": {**SYSTEM["settings"], **dict(settings)}
    }  # fmt: skip
    return uwopt.evaluate(mission, system)


def margins(result: Result) -> dict[str, Margin]:
    assert result.design is not None
    return {m.requirement: m for m in result.design.scenes[0].margins}


def codes(result: Result) -> list[str]:
    return [note.code for note in result.warnings]


def test_a_margin_says_what_is_asked_and_what_is_kept():
    found = margins(evaluated(reserve="recommended", min_dof_m=0.2))
    # by hand: 2 px less 20 %, 1 m and 10 %, 10 dB and 3 dB, 40 m and a quarter
    expected = {
        "max_blur_px": (1.6, 0.4, 2.0), "min_swath_m": (1.1, 0.1, 1.0), "min_snr_db": (13.0, 3.0, 10.0),
        "min_dof_m": (0.22, 0.02, 0.2), "depth_rating_m (window)": (50.0, 10.0, 40.0),
        "depth_rating_m (lamp)": (50.0, 10.0, 40.0),
    }  # fmt: skip
    for name, (limit, reserve, asked) in expected.items():
        assert (found[name].limit, found[name].reserve, found[name].asked) == pytest.approx(
            (limit, reserve, asked)
        ), name
    assert all(m.reserve == 0.0 for name, m in found.items() if name not in expected)


def test_a_reserve_may_make_a_design_miss_what_it_meets_without():
    asked = margins(evaluated())["min_snr_db"].value
    assert asked is not None
    close = {"min_snr_db": asked - 1.0}
    assert margins(evaluated(**close))["min_snr_db"].satisfied
    assert not margins(evaluated(**close, reserve={"snr_db": 3}))["min_snr_db"].satisfied


def test_a_reserve_changes_no_figure():
    plain, kept = (evaluated(reserve=reserve).design for reserve in (None, {"snr_db": 3, "swath": 0.1}))
    assert plain is not None and kept is not None
    assert plain.scenes[0].figures == kept.scenes[0].figures


@pytest.mark.parametrize(("stops", "f_number"), [(1.0, 2.5), (2.0, 3.5), (0.5, 1.8 * 2**0.25), (0.0, 1.8)])
def test_an_f_number_that_is_not_given_is_the_widest_wanted(stops, f_number):
    # f/1.8 stands for 1.78; a stop down are 2.52 and two 3.56, engraved 2.5 and 3.5
    result = evaluated(settings={"f_number": None}, lens_stop_down=stops)
    assert result.design is not None
    assert result.design.scenes[0].settings["f_number"] == pytest.approx(f_number)
    assert margins(result)["f_number_min"].satisfied


def test_a_lens_of_one_opening_is_taken_as_it_is():
    one = {"f_number_min": 4.0, "f_number_max": 4.0}
    result = evaluated(lens=one, lens_stop_down=1)
    stopped = margins(result)["lens_stop_down"]
    assert stopped.satisfied and stopped.value is None
    assert "one_opening" in codes(result)
    assert "one_opening" not in codes(evaluated(lens=one)) + codes(evaluated(lens_stop_down=1))


def test_lamps_that_lean_are_warned_of_as_far_as_the_reserve():
    start = margins(evaluated())["min_snr_db"].value
    assert start is not None
    tight = {"min_snr_db": start - 0.01}  # narrow lamps: some degrees change the SNR by more
    assert "tilt_reserve" not in codes(evaluated(**tight))
    assert "tilt_reserve" in codes(evaluated(**tight, reserve={"tilt_deg": 5}))
    # What is kept in hand may be used up by lamps that lean: 10 dB are three times the light in the mean.
    roomy = {"min_snr_db": start - 10.01}
    assert "tilt_reserve" not in codes(evaluated(**roomy, reserve={"tilt_deg": 5, "snr_db": 10}))


def test_a_lean_inward_and_one_outward_are_both_tried():
    start = margins(evaluated())["min_snr_db"].value
    assert start is not None
    texts = [
        note.message
        for note in evaluated(min_snr_db=start - 0.01, reserve={"tilt_deg": 5}).warnings
        if note.code == "tilt_reserve"
    ]
    # Lamps aimed straight down at 0.6 m to the side light the image better inward: outward alone is lost.
    assert len(texts) == 1 and "outward" in texts[0]
    assert "signal to noise (min_snr_db) would be missed; ask for a larger reserve (reserve.snr_db), or fix" in texts[0]
    even = margins(evaluated(min_uniformity=0.0))["min_uniformity"].value
    assert even is not None
    told = [
        note.message
        for note in evaluated(min_uniformity=even - 1e-4, min_snr_db=0, reserve={"tilt_deg": 5}).warnings
        if note.code == "tilt_reserve"
    ]
    assert told and all("evenness of the light (min_uniformity) would be missed; fix the" in one for one in told)


def test_lamps_are_not_blamed_for_what_is_missed_however_they_stand():
    start = margins(evaluated())["min_snr_db"].value
    assert start is not None
    missed = {"min_swath_m": 50.0, "max_airy_px": 0.01, "reserve": {"tilt_deg": 5}}
    assert not margins(evaluated(**missed))["min_swath_m"].satisfied
    assert "tilt_reserve" not in codes(evaluated(**missed, min_snr_db=0))
    texts = [n.message for n in evaluated(**missed, min_snr_db=start - 0.01).warnings if n.code == "tilt_reserve"]
    assert texts and "as they are, signal to noise (min_snr_db) would be missed" in texts[0]


def test_a_lens_as_far_closed_as_asked_is_no_risk():
    # two stops and no more: the setting stands at its limit by choice, and nothing wears it out
    result = evaluated(settings={"f_number": 3.5}, lens_stop_down=2.0)
    stopped = margins(result)["lens_stop_down"]
    assert stopped.margin == pytest.approx(0.0, abs=1e-9)
    assert not any("closed" in risk.because for risk in result.risks)

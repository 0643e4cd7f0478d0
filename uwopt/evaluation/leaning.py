"""Lamps that lean other than they should: what a design then loses of what is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.lamps import Mount
from uwopt.forward.problem import Problem
from uwopt.objectives.requirements import MarginRows
from uwopt.results.design import Note

STEEPEST_DEG = 80.0
OF_GAIN = ("mean_level",)  # a gain sets it anew, without another image


def leaning(mount: Mount, by_deg: float) -> Mount:
    """The mount with every lamp leaning further outward across the track by an angle."""
    if mount.explicit:
        return Mount(
            explicit=tuple(
                m.model_copy(
                    update={"tilt_y_deg": max(-STEEPEST_DEG, min(STEEPEST_DEG, m.tilt_y_deg + by_deg))}
                )
                for m in mount.explicit
            )
        )
    return replace(mount, tilt_deg=max(-STEEPEST_DEG, min(STEEPEST_DEG, mount.tilt_deg + by_deg)))


def settings_of(shown: dict[str, float | None]) -> SceneSettings:
    """Settings of a result as the model takes them."""

    def seconds(name: str) -> float | None:
        value = shown.get(name)
        return None if value is None else value * 1e-3

    return SceneSettings(
        f_number=shown["f_number"], exposure_s=seconds("exposure_ms"), pulse_s=seconds("pulse_ms"),
        gain=shown["gain"], level=shown["dim_frac"], rate_hz=shown["frame_rate_hz"],
        focus_distance_m=shown["focus_distance_m"],
    )  # fmt: skip


def lost_when_leaning(
    problem: Problem, hardware: Hardware, given: Sequence[SceneSettings], by_deg: float
) -> list[str]:
    """Requirements as asked for, their reserve used up, that these settings miss when every lamp leans outward."""
    leant = replace(hardware, mount=leaning(hardware.mount, by_deg))
    model = DesignModel(problem.with_mount(leant.mount), leant)
    lost = []
    for index, wanted in enumerate(given):
        settings = model.settings(index, wanted)
        margins = model.margins(index, settings, model.figures(index, settings))
        lost += [m.requirement for m in margins if m.requirement not in OF_GAIN and not holds_as_asked(m)]
    return list(dict.fromkeys(lost))


def holds_as_asked(margin: MarginRows) -> bool:
    """Whether what is asked for holds when the reserve on top may be used up."""
    kept = margin.reserve if margin.sense == "<=" else -margin.reserve
    return bool(replace(margin, limit=np.asarray(margin.limit + kept)).satisfied[0])


def tilt_notes(problem: Problem, hardware: Hardware, given: Sequence[SceneSettings]) -> list[Note]:
    """Warnings where lamps that lean as far as the mission's reserve lose what is asked for.

    A check of one design with its settings: a search does not know it, nor does a certificate.
    """
    tilt_deg = problem.mission.reserve.tilt_deg
    if problem.paper or not tilt_deg or problem.unlit(hardware.light):
        return []
    notes = []
    for way, sign in (("outward", 1.0), ("inward", -1.0)):
        lost = lost_when_leaning(problem, hardware, given, sign * tilt_deg)
        if lost:
            text = (
                f"with every lamp {tilt_deg:g} degrees further {way} and the settings as they are, "
                f"{', '.join(lost)} would be missed; keep more in hand (reserve.snr_db), or fix the lamps' aim"
            )
            notes.append(Note("tilt_reserve", "reserve.tilt_deg", text))
    return notes

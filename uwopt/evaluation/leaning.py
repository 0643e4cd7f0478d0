"""Lamps that lean other than they should: what a design then loses of what is asked for."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.figures import Figures, SettingRows
from uwopt.forward.lamps import Mount
from uwopt.forward.problem import Problem
from uwopt.objectives.requirements import MarginRows
from uwopt.results.design import Note

STEEPEST_DEG = 80.0
TILT_RESERVE = "tilt_reserve"  # code of the warning that lamps that lean lose what is asked for
OF_GAIN = ("mean_level",)  # a gain sets it anew, without another image
OF_LIGHT = "min_snr"  # how requirements begin that more light mends
#: What lamps lose that lean, in words with the mission's key.
LOST = {
    "min_snr_db": "signal to noise (min_snr_db)", "min_snr_mean_db": "signal to noise of the image's mean",
    "min_snr_red_db": "signal to noise of red (min_snr_red_db)", "min_contrast": "contrast (min_contrast)",
    "min_uniformity": "evenness of the light (min_uniformity)", "saturation_fraction": "highlights below saturation",
    "mean_level": "mean image level (mean_level)",
}  # fmt: skip


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


class LeaningModel(DesignModel):
    """A design whose lamps lean other than they should: its margins are those asked for, their reserves used up."""

    def margins(
        self, index: int, settings: SettingRows, figures: Figures, *, level_tolerance_rel: float = 1e-6
    ) -> list[MarginRows]:
        """Requirements as asked for; but the mean level, which a gain sets anew."""
        held = super().margins(index, settings, figures, level_tolerance_rel=level_tolerance_rel)
        return [as_asked(margin) for margin in held if margin.requirement not in OF_GAIN]


def as_asked(margin: MarginRows) -> MarginRows:
    """A margin whose limit is what is asked for, without the reserve on top."""
    kept = margin.reserve if margin.sense == "<=" else -margin.reserve
    return replace(margin, limit=np.asarray(margin.limit + kept), reserve=0.0)


def leaning_models(problem: Problem, hardware: Hardware) -> dict[str, LeaningModel]:
    """A design with every lamp as far outward, and inward, as the mission's reserve; made once a problem.

    None where no reserve is kept or no lamp is lit.
    """
    tilt_deg = problem.mission.reserve.tilt_deg
    if problem.paper or not tilt_deg or problem.unlit(hardware.light):
        return {}
    key = ("leaning", hardware)
    if key not in problem.known_models:
        made = {}
        for way, sign in (("outward", 1.0), ("inward", -1.0)):
            leant = replace(hardware, mount=leaning(hardware.mount, sign * tilt_deg))
            made[way] = LeaningModel(problem.with_mount(leant.mount), leant)
        problem.known_models[key] = made
    models: dict[str, LeaningModel] = problem.known_models[key]
    return models


def lost_when_leaning(model: LeaningModel, given: Sequence[SceneSettings]) -> list[str]:
    """Requirements as asked for that these settings miss."""
    lost = []
    for index, wanted in enumerate(given):
        settings = model.settings(index, wanted)
        margins = model.margins(index, settings, model.figures(index, settings))
        lost += [margin.requirement for margin in margins if not margin.satisfied[0]]
    return list(dict.fromkeys(lost))


def tilt_notes(
    problem: Problem, hardware: Hardware, given: Sequence[SceneSettings], missed: Collection[str] = ()
) -> list[Note]:
    """Warnings where lamps that lean as far as the mission's reserve lose what is asked for, at these settings.

    missed : what is missed without any leaning: no lamp's aim is to blame for it
    """
    tilt_deg, notes = problem.mission.reserve.tilt_deg, []
    for way, model in leaning_models(problem, hardware).items():
        lost = [name for name in lost_when_leaning(model, given) if name not in missed]
        if lost:
            by_light = all(name.startswith(OF_LIGHT) for name in lost)
            text = (
                f"with every lamp {tilt_deg:g} degrees further {way} and the settings as they are, "
                f"{', '.join(LOST.get(name, name) for name in lost)} would be missed; "
                f"{'ask for a larger reserve (reserve.snr_db), or ' if by_light else ''}fix the lamps' aim"
            )
            notes.append(Note(TILT_RESERVE, "reserve.tilt_deg", text))
    return notes

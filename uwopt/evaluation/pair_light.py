"""What each camera of a stereo pair gets of the lamps: a search takes the camera for standing midway between both.

Lamps stand about the middle between the ports, so that one camera has a lamp nearer by half the baseline, and more
light scattered back from it. The design is looked at again as each camera sees it, with its own settings kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace

import numpy as np

from uwopt.evaluation.bill import lamp_places
from uwopt.evaluation.design_model import DesignModel, design_model
from uwopt.forward.designs import Hardware
from uwopt.forward.figures import SettingRows
from uwopt.forward.lamps import LAMP_FRONT_M, Mount
from uwopt.forward.views import pair_of
from uwopt.mission.sections.vehicle import LightMount
from uwopt.objectives.requirements import MarginRows
from uwopt.results.design import Note
from uwopt.units import ratio_to_db

WORTH_TELLING_DB = 0.2
WORTH_MISSING = 0.01  # of a limit
OF_LIGHT = {  # requirements, in words
    "min_snr_db": "signal to noise", "min_snr_mean_db": "signal to noise of the mean",
    "min_snr_red_db": "signal to noise of red", "min_contrast": "contrast",
    "min_uniformity": "evenness of the light", "saturation_fraction": "room for highlights",
    "lamp_clear_m": "room between lamps and view",
}  # fmt: skip


def seen_from(hardware: Hardware, aside_m: float) -> Hardware:
    """The same lamps from a camera so far aside of the middle, to starboard."""
    places = []
    for lamp in lamp_places(hardware):
        y_m = lamp.y_m - aside_m
        turned = (lamp.y_m < 0.0) != (y_m < 0.0)  # outward is away from the camera: the same aim on its other side
        tilt_deg = -lamp.tilt_y_deg if turned else lamp.tilt_y_deg
        places.append(LightMount(**{**asdict(lamp), "y_m": y_m, "tilt_y_deg": tilt_deg}))
    return replace(hardware, mount=Mount(explicit=tuple(places)))


def pair_notes(model: DesignModel, settings: Sequence[SettingRows]) -> list[Note]:
    """What a pair is told of its light: how much less the darker camera gets, and what either of them misses."""
    pair = pair_of(model.problem.scenes[0])
    if pair is None or model.problem.paper or model.unlit:
        return []
    cameras = [seen_from(model.hardware, side * 0.5 * pair.baseline_m) for side in (-1.0, 1.0)]
    nearest_m = min(np.hypot(m.x_m, m.y_m) for camera in cameras for m in camera.mount.explicit)
    if nearest_m < LAMP_FRONT_M:
        text = f"a lamp stands {1e3 * nearest_m:.0f} mm from the middle of a camera's port; move it aside"
        return [Note("lamp_at_port", "vehicle.light_baseline_m", text)]
    models = [design_model(model.problem.with_mount(camera.mount), camera) for camera in cameras]
    notes = []
    for index, scene in enumerate(model.problem.scenes):
        midway, *both = (snr_db(one, index, settings[index]) for one in (model, *models))
        known = missed(model, index, settings[index])
        lost = sorted(set().union(*(missed(one, index, settings[index]) for one in models)) - known)
        if abs(min(both) - midway) < WORTH_TELLING_DB and not lost:
            continue
        text = (
            f"{scene.name}: light is reckoned as if one camera stood midway between the two, {midway:.1f} dB; as they "
            f"stand the lamps give {both[0]:.1f} and {both[1]:.1f} dB"
        )
        if lost:
            missing = ", ".join(OF_LIGHT[name] for name in lost)
            text += f"; either of them then misses {missing}: keep a reserve, or move the lamps"
        notes.append(Note("pair_light", "vehicle.camera_baseline_m", text))
    return notes


def snr_db(model: DesignModel, index: int, settings: SettingRows) -> float:
    """Mean signal-to-noise ratio at the nominal altitude."""
    figures, at = model.figures(index, settings), model.problem.scenes[index].nominal
    return float(ratio_to_db(max(float(figures.snr[0, at]), 1e-300)))


def missed(model: DesignModel, index: int, settings: SettingRows) -> set[str]:
    """Requirements of light that a design misses in one scene by more than rounding, whatever reserve was held."""
    found: list[MarginRows] = model.margins(index, settings, model.figures(index, settings))
    return {
        one.requirement for one in found if one.requirement in OF_LIGHT
        and float((one.margin + one.reserve + WORTH_MISSING * np.abs(one.limit))[0]) < 0.0
    }  # fmt: skip

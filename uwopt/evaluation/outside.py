"""What of a system is none of what `solve` searches for the same mission.

`evaluate` tells it, so that nobody holds such a system against a certificate. What the mission's vehicle states
(number of cameras and lights, orientation, places of the lights) binds: a system that departs from it is missed.
What the mission leaves open, and what `solve` decides by rule, does not bind: a note names it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from uwopt.catalog.catalogue import Catalog
from uwopt.catalog.choose import Choice
from uwopt.evaluation.design_model import DesignModel, design_model
from uwopt.evaluation.focus_marks import stands_at_mark
from uwopt.forward.assembly import bare_cable_m, selection_of
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.figures import SettingRows
from uwopt.forward.lamps import mission_mounts
from uwopt.forward.part_columns import PULSED
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.mission.system import System
from uwopt.model.imaging import Lamps
from uwopt.objectives.objective import Objective
from uwopt.results.design import Note

PLACE_DIGITS = 6  # of metres and of directions: lamps nearer to each other stand in one place
MORE_LIGHT_REL = 1e-6  # a smaller working f-number counts from here on
TOLD_OTHERWISE = ("colour", "shutter", "depth rating", "rated time")  # of selection: margins of every evaluation
PLACE_KEYS = ("light_baseline_m", "light_tilt_deg", "light_mounts")


@dataclass(frozen=True)
class Departure:
    """One way in which a system leaves what `solve` searches; `binds`: the mission states it, so it is missed."""

    rule: str
    path: str
    message: str
    binds: bool = False

    @property
    def note(self) -> Note:
        """As a warning of a result."""
        return Note("outside_search", self.path, self.message)


def departures(
    mission: Mission, catalog: Catalog, system: System, problem: Problem, hardware: Hardware,
    given: Sequence[SceneSettings], objective: Objective,
) -> list[Departure]:  # fmt: skip
    """All of them, hardware first."""
    model = design_model(problem, hardware)
    settings = [model.settings(index, wanted) for index, wanted in enumerate(given)]
    return [
        *other_parts(mission, catalog, system),
        *other_numbers(mission, system),
        *(() if model.unlit else other_places(mission, hardware)),
        *other_focus(model, settings, objective),
        *pulses_beyond_the_exposure(model, settings),
    ]


def other_parts(mission: Mission, catalog: Catalog, system: System) -> Iterator[Departure]:
    """Parts that the mission does not let `solve` use, or that no catalogue holds."""
    own = [kind for kind in system.kinds if not isinstance(getattr(system, kind), str)]
    if own:
        text = f"{', '.join(own)}: written out in the system, so not among the parts that solve searches"
        yield Departure("parts", own[0], text)
    names = [name for name in Choice.__dataclass_fields__ if name != "generic"]
    wanted = {name: getattr(mission.catalog, name) for name in names}
    choice = Choice(**wanted, generic=mission.catalog.generic_at_last)
    vehicle = mission.vehicle
    selection = selection_of(
        catalog, choice, required_depth_m=mission.required_depth_m, lamp_supply=vehicle.lamp_supply,
        duration_h=vehicle.duration_h, cable_m=bare_cable_m(mission),
    )  # fmt: skip
    left_out = {(e.kind, e.part_id): e for e in selection.excluded if e.rule not in TOLD_OTHERWISE}
    for kind in system.kinds:
        named = getattr(system, kind)
        if not isinstance(named, str):
            continue
        part = catalog.part(named, kind)  # pyrefly: ignore[bad-argument-type]
        found = left_out.get((kind, part.id))  # pyrefly: ignore[bad-argument-type]
        if found is not None:
            yield Departure("parts", kind, f"{part.id}: solve leaves this {kind} out ({found.reason})")
    if system.complete is not None:
        whole = catalog.part(system.complete, "complete")
        found = left_out.get(("complete", whole.id))
        if found is not None:
            yield Departure("parts", "complete", f"{whole.id}: solve leaves this complete camera out ({found.reason})")


def other_numbers(mission: Mission, system: System) -> Iterator[Departure]:
    """Another number of cameras or lights, or another orientation, than the vehicle carries."""
    vehicle = mission.vehicle
    stated = vehicle.model_fields_set
    if system.camera_count != vehicle.camera_count:
        text = f"{system.camera_count} camera(s), where solve takes {vehicle.camera_count}"
        yield Departure("camera count", "camera_count", text, "camera_count" in stated)
    low, high = vehicle.light_counts[0], vehicle.light_counts[-1]
    if not low <= system.light_count <= high:
        text = f"{system.light_count} light(s), where solve takes {low} to {high}"
        yield Departure("light count", "light_count", text, "light_count" in stated)
    if system.orientation not in vehicle.orientations:
        text = f"{system.orientation}, where the mission asks for {vehicle.orientation}"
        yield Departure("orientation", "orientation", text, True)


def other_places(mission: Mission, hardware: Hardware) -> Iterator[Departure]:
    """Lights that stand or aim where none does that `solve` searches."""
    vehicle = mission.vehicle
    mine, count = places(hardware.mount.lamps(hardware.count)), hardware.count
    mounts = [mount for mount in mission_mounts(mission) if len(mount.explicit) in (0, count)]
    if any(places(mount.lamps(count)) == mine for mount in mounts):
        return
    binds = bool(vehicle.model_fields_set.intersection(PLACE_KEYS))
    between = not hardware.mount.explicit and not vehicle.light_mounts and within_ranges(mission, hardware)
    if between:
        text = "the lights stand between the places that solve tries, every 0.05 m and 2.5 degrees"
    elif vehicle.light_mounts and not binds_places(mission, hardware):
        text = (
            f"{count} light(s) in the first of the mission's places, where solve takes all of its light_count"
        )
        binds = False
    else:
        text = "the lights stand or aim otherwise than the mission's vehicle carries them"
    yield Departure("light places", "light_mounts", text, binds and not between)


def binds_places(mission: Mission, hardware: Hardware) -> bool:
    """Whether the lamps stand elsewhere than in the first of the mission's own places."""
    own = tuple(mission.vehicle.light_mounts or ())[: hardware.count]
    return tuple(hardware.mount.explicit) != own


def within_ranges(mission: Mission, hardware: Hardware) -> bool:
    """Whether baseline and tilt lie within the mission's ranges."""
    vehicle, mount = mission.vehicle, hardware.mount
    pairs = (
        (mount.baseline_m, vehicle.light_baseline_range_m), (mount.tilt_deg, vehicle.light_tilt_range_deg)
    )  # fmt: skip
    return all(low <= value <= high for value, (low, high) in pairs)


def places(lamps: Lamps) -> dict[tuple[float, ...], float]:
    """The share of the light by place and aim, however the lamps are listed."""
    found: dict[tuple[float, ...], float] = {}
    for x, y, z, aim, share in zip(lamps.x_m, lamps.y_m, lamps.z_m, lamps.aim, lamps.share, strict=True):
        place = tuple(round(value, PLACE_DIGITS) + 0.0 for value in (x, y, z, *aim))
        found[place] = found.get(place, 0.0) + share
    return {place: round(share, PLACE_DIGITS) for place, share in found.items()}  # thirds add up first


def other_focus(
    model: DesignModel, settings: Sequence[SettingRows], objective: Objective
) -> Iterator[Departure]:
    """A focus that lets in more light, or is sharper, than where `solve` puts it: at what must be sharp.

    The mark to which `solve` has that focus set is no other.
    """
    for index, (scene, rows) in enumerate(zip(model.problem.scenes, settings, strict=True)):
        own, searched = float(rows.dioptre_per_m[0]), model.searched_dioptre_per_m(index)
        focal = float(model.views[index].focal_length_m[0])
        brighter = focal * (searched - own) > MORE_LIGHT_REL * (1.0 - focal * searched)
        sharpness = scene.view.requirements.asks_sharpness or objective.weight("information") > 0
        moved = not np.isclose(own, searched, rtol=MORE_LIGHT_REL, atol=0.0)
        if stands_at_mark(model, own):  # as solve itself would have it set
            continue
        if (brighter and not scene.paper) or (sharpness and moved):
            text = (
                f"{scene.name}: the focus lies elsewhere than solve puts it, in the middle of what must be sharp; "
                "its certificate holds for that focus"
            )
            yield Departure("focus", "settings.focus_distance_m", text)


def pulses_beyond_the_exposure(model: DesignModel, settings: Sequence[SettingRows]) -> Iterator[Departure]:
    """LEDs that shine on when the exposure has ended, where `solve` keeps the pulse within it."""
    if int(model.lights.kind[0]) != PULSED:
        return
    for scene, rows in zip(model.problem.scenes, settings, strict=True):
        if float(rows.pulse_s[0]) > float(rows.exposure_s[0]) * (1.0 + MORE_LIGHT_REL):
            text = f"{scene.name}: the light pulse is longer than the exposure, where solve keeps it within"
            yield Departure("pulse", "settings.pulse_ms", text)

"""What physics asks of a mission beyond its form: lamps beside the port and above the floor, a sun above the water.

Physics `paper` puts lamps on the axis and knows no sun, so that most of this does not concern it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from uwopt.errors import CatalogError, MissionError
from uwopt.forward.lamps import LAMP_FRONT_M
from uwopt.forward.scene import clarity_of, jerlov_table_of
from uwopt.mission.best_image import BestImageGoal, why_no_information
from uwopt.mission.keys import TARGET_WORDS
from uwopt.mission.mission import Mission, SceneView
from uwopt.model.phase_formulas import FOURNIER_FORAND_RATIOS


def check_physical(mission: Mission) -> None:
    """Raise one error with every fault."""
    faults = [*objective_faults(mission)]
    for view in mission.views:
        faults += light_faults(view)
        if mission.physics == "paper" and view.vehicle.pitch_deg:
            faults.append(
                f"vehicle.pitch_deg = {view.vehicle.pitch_deg:g}: physics paper looks square at its floor; set it to "
                "0, or use physics: auto"
            )
        if mission.physics != "paper":
            faults += [*lamp_front_faults(view), *sun_faults(view), *scattering_faults(view)]
        faults += clarity_faults(view, paper=mission.physics == "paper")
    if faults:
        raise MissionError([f"{mission.source_name}: {text}" for text in dict.fromkeys(faults)])


def objective_faults(mission: Mission) -> Iterator[str]:
    """Objectives that need another physics, or a bound without which the longest lens always wins."""
    wanted: Any = mission.objective
    if isinstance(wanted, BestImageGoal):
        wanted = wanted.best_image.of
    names = [wanted] if isinstance(wanted, str) else list(wanted)
    if "information" in names:
        yield from (f"objective: {reason}" for reason in why_no_information(mission))


def light_faults(view: SceneView) -> Iterator[str]:
    """Lamps on or beyond what is looked at."""
    lowest = view.vehicle.nearest_m
    pitch_rad = math.radians(view.vehicle.pitch_deg)
    thing, way = TARGET_WORDS[view.scene.target]
    far = "below the port at the lowest" if thing == "floor" else "before the port at the nearest"
    for n, mount in enumerate(view.vehicle.light_mounts or ()):
        if mount.z_m * math.cos(pitch_rad) - mount.x_m * math.sin(pitch_rad) >= lowest:
            yield (
                f"vehicle.light_mounts[{n}].z_m = {mount.z_m:g} m puts the lamp on or "
                f"{'below' if thing == 'floor' else 'behind'} the {thing}, which is {lowest:g} m {far}; lower z_m or "
                f"raise the {way}"
            )


def lamp_front_faults(view: SceneView) -> Iterator[str]:
    """Lamps whose front would lie over the port: a point's backscatter diverges there."""
    vehicle = view.vehicle
    for n, mount in enumerate(vehicle.light_mounts or ()):
        aside = (mount.x_m**2 + mount.y_m**2 + mount.z_m**2) ** 0.5
        if aside < LAMP_FRONT_M:
            yield (
                f"vehicle.light_mounts[{n}] is {aside:g} m from the port, within the {LAMP_FRONT_M:g} m radius of a "
                "lamp's front; move it aside (x_m or y_m)"
            )
        for other, there in enumerate((vehicle.light_mounts or ())[:n]):
            apart_m = math.dist((mount.x_m, mount.y_m, mount.z_m), (there.x_m, there.y_m, there.z_m))
            if vehicle.lamp_size_m is not None and apart_m < vehicle.lamp_size_m * (1 - 1e-9):
                yield (
                    f"vehicle.light_mounts[{n}] is {apart_m:g} m from light_mounts[{other}], less than lamp_size_m = "
                    f"{vehicle.lamp_size_m:g} m: one lamp would stand in the other; move them apart"
                )
    least = vehicle.light_baseline_range_m[0]
    if vehicle.light_mounts is None and least < LAMP_FRONT_M:
        yield (
            f"vehicle.light_baseline_m = {least:g} m is within the {LAMP_FRONT_M:g} m radius of a lamp's front, where "
            f"backscatter has no limit; begin at {LAMP_FRONT_M:g} m, or use physics: paper"
        )


def scattering_faults(view: SceneView) -> Iterator[str]:
    """A share of scattering backward that the phase function's formula does not cover."""
    scene, (low, high) = view.scene, FOURNIER_FORAND_RATIOS
    name = scene.phase_function.casefold().replace("_", "-")
    if name == "fournier-forand" and not low <= scene.backscatter_ratio <= high:
        yield (
            f"scene {scene.name!r}: backscatter_ratio = {scene.backscatter_ratio:g} is outside {low:g} to {high:g}, "
            "which phase function fournier-forand takes; correct it, or set phase_function: henyey-greenstein"
        )


def clarity_faults(view: SceneView, *, paper: bool) -> Iterator[str]:
    """A reading that no water of the wanted type has."""
    try:
        clarity_of(view.scene, jerlov_table_of(view.scene, paper=paper))
    except CatalogError as fault:
        yield f"scene {view.scene.name!r}: {fault}"


def sun_faults(view: SceneView) -> Iterator[str]:
    """A sun that does not shine, or a camera above the water."""
    scene = view.scene
    if scene.sun_lux <= 0:
        return
    if scene.sun_elevation_deg <= 0:
        yield (
            f"scene {scene.name!r}: sun_elevation_deg = {scene.sun_elevation_deg:g} is not above the horizon, so "
            f"sun_lux = {scene.sun_lux:g} lx cannot be sunlight; set sun_lux: 0, or raise the sun"
        )
    highest = view.vehicle.altitude_m + view.vehicle.altitude_tolerance_m
    if scene.depth_m < highest:
        yield (
            f"scene {scene.name!r}: with sunlight, depth_m = {scene.depth_m:g} m is the depth of the floor and must be "
            f"at least the greatest altitude, {highest:g} m; correct one of them, or set sun_lux: 0"
        )

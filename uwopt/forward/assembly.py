"""From a mission to its tables: the catalogue loaded, parts selected, a problem built; also for one given system."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from uwopt.catalog.catalogue import Catalog
from uwopt.catalog.choose import PATTERN_KEYS, Choice, Selection, ToBeMade, matches, select
from uwopt.catalog.load import read_catalog as _load_catalog
from uwopt.catalog.parts.light import NO_LAMP
from uwopt.catalog.records import Port
from uwopt.errors import CatalogError, MissionError
from uwopt.forward.designs import Hardware
from uwopt.forward.enclosures import enclosed
from uwopt.forward.fixed_settings import cannot_be_set
from uwopt.forward.focus import default_dioptres_per_m
from uwopt.forward.lamps import Mount, mount_at
from uwopt.forward.once import Once
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.forward.spacers import ring_behind_m
from uwopt.forward.views import focus_map, views
from uwopt.mission.fixed import Fixed
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.sections.requirements import Requirements
from uwopt.model.port import lens_dioptre_per_m

if TYPE_CHECKING:
    from uwopt.mission.system import System


def select_problem_mission(mission: Mission) -> dict[str, str]:
    """What single parts must be, from the requirements of all scenes: colour and shutter."""
    wanted = {}
    for key in ("colour", "shutter"):
        asked = sorted({wish(view.requirements, key) for view in mission.views} - {"any"})
        if len(asked) > 1:
            raise MissionError(
                f"requirements.{key}: scenes ask for {' and '.join(asked)}, but one camera serves them all; "
                "ask for one of them, or for any"
            )
        wanted[key] = asked[0] if asked else "any"
    return wanted


def wish(requirements: Requirements, key: str) -> str:
    """What one scene asks of a camera's colour or shutter; a red channel belongs to a colour sensor."""
    if key == "colour" and requirements.min_snr_red_db is not None:
        return "colour"
    return str(getattr(requirements, key))


#: Of missions that are tried one after another, most of which choose alike from one catalogue.
SELECTIONS: Once[Selection] = Once(64)


def selection_of(catalog: Catalog, choice: Choice, *, fixed: Fixed | None = None, **asked: Any) -> Selection:
    """What `select` makes of a catalogue, once for all that choose alike.

    fixed : settings that every part must be able to take
    """

    def made() -> Selection:
        if fixed is None:
            return select(catalog, choice, **asked)
        return select(catalog, choice, unsettable=lambda part: cannot_be_set(part, fixed), **asked)

    return SELECTIONS.of((catalog,), repr((choice, fixed, asked)), made)


def selected(
    mission: Mission, catalog: Catalog, *, generic: ToBeMade, depth_m: float | None = None
) -> Selection:
    """The parts that the mission allows; `depth_m` replaces the depth they must be rated for."""
    names = Choice.__dataclass_fields__
    wanted = {name: getattr(mission.catalog, name) for name in names if name != "generic"}
    wanted["lights"] = light_patterns(mission)
    choice = Choice(**wanted, generic=generic)
    made = selection_of(
        catalog,
        choice,
        required_depth_m=mission.required_depth_m if depth_m is None else depth_m,
        lamp_supply=mission.vehicle.lamp_supply,
        duration_h=mission.vehicle.duration_h,
        camera_count=mission.vehicle.camera_count,
        cable_m=bare_cable_m(mission),
        fixed=mission.fixed,
        **select_problem_mission(mission),
    )
    idle = [text for text in made.warnings if names_nothing(mission, catalog, text)]
    if idle:
        raise MissionError([f"{mission.source_name}: {text}" for text in idle])
    return made


def bare_cable_m(mission: Mission) -> float | None:
    """How far cameras must reach by themselves: over the cable, where no computer beside them may help."""
    return mission.vehicle.cable_m if mission.catalog.host == "none" else None


def light_patterns(mission: Mission) -> Sequence[str]:
    """Patterns of the lights that may be used; where the mission may do without, no lamp is one of them."""
    fewest, most = mission.vehicle.light_count
    if most == 0:
        return (NO_LAMP.id,)
    patterns = mission.catalog.lights
    return (*patterns, NO_LAMP.id) if patterns and fewest == 0 else patterns


def names_nothing(mission: Mission, catalog: Catalog, warning: str) -> bool:
    """Whether a warning is of a kind of part of which no pattern matches anything: nothing could be found."""
    for kind, key in PATTERN_KEYS.items():
        patterns = getattr(mission.catalog, key)
        if warning.startswith(f"catalog.{key}:") and patterns:
            return not any(matches(p, part) for p in patterns for part in catalog.parts(kind))
    return False


def build_problem(mission: Mission, selection: Selection, **changes: Any) -> Problem:
    """Tables over the selected parts."""
    parts = Parts(selection.cameras, selection.lenses, ports_of(mission, selection), selection.lights)
    for complete in selection.completes:
        camera, lens, port = complete.pieces
        parts = replace(
            parts, cameras=(*parts.cameras, camera), lenses=(*parts.lenses, lens), ports=(*parts.ports, port)
        )
    return Problem(
        mission, parts, paper=mission.physics == "paper", owned_lights=owned_ids(selection), **changes
    )


def ports_of(mission: Mission, selection: Selection) -> tuple[Port, ...]:
    """The ports to search, each in every housing that takes it where the mission asks for housings."""
    if mission.catalog.housing == "none":
        return selection.ports
    return enclosed(selection.ports, selection.housings)


def owned_ids(selection: Selection) -> dict[str, int]:
    """How many of each part are owned, by the catalogue's spelling of its id."""
    return {selection.catalog.part(name).id: count for name, count in selection.owned.items()}


def load_catalog(mission: str | Path | Mapping[str, Any] | Mission | None = None) -> Catalog:
    """The built-in catalogue, with the own parts and quotes that a mission names."""
    if mission is None:
        return _load_catalog()
    mission = load_mission(mission)
    files = [str(mission.resolve_path(name)) for name in mission.catalog.files]
    prices = None if mission.catalog.prices is None else str(mission.resolve_path(mission.catalog.prices))
    catalog = _load_catalog(files, prices, mission.base_dir)
    if mission.vehicle.light_count[0] > 0:
        return catalog
    return replace(catalog, lights=(*catalog.lights, NO_LAMP))


def system_problem(mission: Mission, system: System) -> tuple[Problem, Hardware]:
    """Tables of one system: its parts from the catalogue or inline."""
    from uwopt.catalog.inline import part_from_inline

    selection = selection_of(
        load_catalog(mission), Choice(owned=mission.catalog.owned), camera_count=mission.vehicle.camera_count
    )

    def part(kind: str) -> Any:
        named = getattr(system, kind)
        if kind == "light" and (system.light_count == 0 or named == NO_LAMP.id):
            return NO_LAMP
        if isinstance(named, str):
            return selection.catalog.part(named, kind)  # pyrefly: ignore[bad-argument-type]
        try:
            return part_from_inline(kind, named, system.base_dir)  # pyrefly: ignore[bad-argument-type]
        except CatalogError as error:
            raise CatalogError([f"{system.source_name}: {kind}: {text}" for text in error.faults]) from None

    if system.complete is not None:
        selection.catalog.part(system.complete, "complete")
    port = part("port")
    if system.housing is not None:
        port = replace(port, housing=part("housing"))
    parts = Parts((part("camera"),), (part("lens"),), (port,), (part("light"),))
    count = max(system.light_count, 1)
    if system.light_mounts:
        mount = Mount(explicit=tuple(system.light_mounts))
    else:
        vehicle = mission.vehicle
        baseline = (
            system.light_baseline_m
            if system.light_baseline_m is not None
            else vehicle.light_baseline_grid_m[0]
        )
        tilt = system.light_tilt_deg if system.light_tilt_deg is not None else vehicle.light_tilt_grid_deg[0]
        explicit = tuple(vehicle.light_mounts or ()) if system.light_baseline_m is None else ()
        mount = Mount(explicit=explicit) if len(explicit) == system.light_count else mount_at(
            mission, baseline, tilt, count
        )
    problem = Problem(
        mission, parts, paper=mission.physics == "paper", owned_lights=owned_ids(selection),
        counts=(count, count), mounts=[mount],
    )  # fmt: skip
    refuse_unknown(system, problem)
    landscape = system.orientation == "landscape"
    return problem, Hardware(0, 0, 0, landscape, 0, count, mount, spacer_of(problem, system, landscape))


def spacer_of(problem: Problem, system: System, landscape: bool) -> float:
    """The ring behind a system's lens: as it is written, else the least for the focus that is set."""
    if system.spacer_mm is not None:
        return system.spacer_mm * 1e-3
    shapes = [problem.shape(0, index) for index in range(len(problem.scenes))]
    maps = [focus_map(scene, shape) for scene, shape in zip(problem.scenes, shapes, strict=True)]
    seen = [
        views(scene, problem.cameras, problem.lenses, shape, landscape=landscape)
        for scene, shape in zip(problem.scenes, shapes, strict=True)
    ]
    dioptres = default_dioptres_per_m(problem.scenes, maps, seen)
    for index, scene in enumerate(problem.scenes):
        wanted = system.settings_for(scene.name).focus_distance_m
        if wanted is not None:
            dioptres[index] = np.array([float(lens_dioptre_per_m(wanted, focus_map=maps[index]))])
    return float(ring_behind_m(problem.lenses, dioptres)[0])


def refuse_unknown(system: System, problem: Problem) -> None:
    """Raise where a part of the catalogue lacks a number that nothing can stand in for."""
    vital = {
        "camera": ("pixel pitch", problem.cameras.pixel_pitch_m[0]),
        "lens": ("focal length", problem.lenses.focal_length_m[0]),
        "port": ("radius", problem.ports.outer_radius_m[0] if problem.ports.is_dome[0] else 1.0),
        "light": ("light output", problem.lights.full_light[0]),
    }
    for kind, (what, value) in vital.items():
        if not value > 0.0:
            raise MissionError(
                f"{system.source_name}: {kind} = {getattr(system, kind)}: its {what} is not known, so nothing can be "
                f"computed with it; write the {kind} as a section with its numbers, or name another"
            )

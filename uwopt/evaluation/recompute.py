"""A design of a result file, made ready to be asked again: model and settings from the inputs it holds.

Pictures and curves of a report are not stored, they are recomputed by the model that made the figures.
The mission comes from the result (files that it names are looked for where the mission file stood), the
parts from the catalogue of today or from the system that was evaluated, the settings from the design.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from uwopt.catalog.records import OF_A_DESIGN, Housing, Part, Port
from uwopt.documents.faults import plain_name
from uwopt.errors import RangeError, UwoptError
from uwopt.evaluation.design_model import DesignModel
from uwopt.evaluation.figures_by_name import field_of_view_m, illuminance
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.figures import Figures, SettingRows
from uwopt.forward.lamps import Mount, mission_mounts
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.sections.vehicle import LightMount
from uwopt.model.effects import Effects
from uwopt.model.fineness import Fineness
from uwopt.model.port import lens_dioptre_per_m
from uwopt.results.basis import UsedPhysics
from uwopt.results.design import Design, LampPlace
from uwopt.results.front import FrontResult
from uwopt.results.result import Result
from uwopt.tolerances import SATISFIED_REL

SAME_REL = 1e-5  # of the figures that tell whether the inputs are still those of the result


class ReplayError(UwoptError):
    """A design cannot be recomputed from its result file, because something it needs is gone or has changed."""


@dataclass(frozen=True)
class Replay:
    """A design's model with its settings, by scene."""

    model: DesignModel
    settings: tuple[SettingRows, ...]

    def figures(self, scene: int = 0, *, information: bool = True) -> Figures:
        """Figures of one scene, as the evaluation of the design computes them."""
        paper = self.model.problem.paper
        return self.model.figures(scene, self.settings[scene], information=information and not paper)


def replayed(result: Result | FrontResult, design: Design, scene: int = 0) -> Replay:
    """The model and settings of one design of a result, to be looked at in a scene.

    Raises RangeError where there is no such scene, ReplayError as `replay` does.
    """
    if not 0 <= scene < len(design.scenes):
        raise RangeError(f"there is no scene {scene}; the mission has {len(design.scenes)}, counted from 0")
    system = result.system if isinstance(result, Result) and result.command == "evaluate" else None
    return replay(result.mission, design, physics=result.physics, mission_file=result.mission_file, system=system)


def replay(
    mission: Mapping[str, Any],
    design: Design,
    *,
    physics: UsedPhysics,
    mission_file: Mapping[str, str] | None = None,
    system: Mapping[str, Any] | None = None,
) -> Replay:
    """The model and settings of one design of a result.

    Parameters
    ----------
    mission : as the result holds it, defaults filled in
    design : recommendation, runner-up, point of a front, or what was evaluated
    physics : the result's; of an evaluation in physics `auto` it says which effects were left out
    mission_file : the result's; its folder is where CSV files of the mission are looked for
    system : the result's, of an evaluation; None for a design that was searched

    Raises
    ------
    ReplayError : a file has moved, a part has left the catalogue, or the figures come out otherwise
    """
    try:
        folder = (mission_file or {}).get("folder") or None
        wanted = as_searched(load_mission(mission, base_dir=None if folder is None else Path(folder)), design)
        if system is None:
            problem, hardware = searched_problem(wanted, design)
        else:
            problem, hardware = evaluated_problem(wanted, system, physics)
        fineness = Fineness(**physics.fineness)
        if fineness != problem.fineness:
            problem = problem.with_fineness(fineness)
        model = DesignModel(problem, hardware)
        made = Replay(
            model,
            tuple(
                model.settings(index, given_settings(model, index, scene.settings))
                for index, scene in enumerate(design.scenes)
            ),
        )
    except UwoptError as fault:
        raise ReplayError(f"the design cannot be recomputed: {fault}") from fault
    except OSError as fault:
        name = fault.filename or "a file"
        raise ReplayError(
            f"the design cannot be recomputed: {name} cannot be read; put the files that the mission names back"
        ) from fault
    refuse_changed(made, design)
    return made


def as_searched(mission: Mission, design: Design) -> Mission:
    """The mission that a design was found in: without the cap of gain where the design is beyond it, for it yielded."""
    cap_db = mission.reserve.max_gain_db
    gain_db = max((scene.settings.get("gain_db") or 0.0 for scene in design.scenes), default=0.0)
    beyond = cap_db is not None and gain_db > cap_db * (1.0 + SATISFIED_REL)
    return mission.without_gain_cap if beyond else mission


def searched_problem(mission: Mission, design: Design) -> tuple[Problem, Hardware]:
    """Tables over the parts that were searched, and the design's place in them; every effect is kept.

    A part that the mission does not allow (a nearest miss may have one) is looked for in the whole catalogue.
    """
    from uwopt.forward.assembly import build_problem, load_catalog, owned_ids, selected

    chosen = design.hardware
    wanted = {**{kind: chosen.parts[kind].id for kind in OF_A_DESIGN}, "port": enclosure_id(design)}
    to_be_made, choice = any(part.generic for part in chosen.parts.values()), mission.catalog
    catalog = load_catalog(mission)
    generic = choice.generic_at_last if to_be_made else choice.generic_at_first
    selection = selected(mission, catalog, generic=generic)
    problem = build_problem(mission, selection)
    places = [place_of(wanted[kind], every) for kind, every in problem.parts.by_kind.items()]
    if None in places:
        camera, lens, port, light = (catalog.part(chosen.parts[kind].id, kind) for kind in OF_A_DESIGN)
        if chosen.housing is not None and chosen.complete is None:
            port = replace(port, housing=catalog.part(chosen.housing.id, "housing"))  # pyrefly: ignore[unexpected-keyword]
        parts = Parts((camera,), (lens,), (port,), (light,))  # pyrefly: ignore[bad-argument-type]
        paper = mission.physics == "paper"
        problem = Problem(mission, parts, paper=paper, owned_lights=owned_ids(selection))
        places = [0, 0, 0, 0]
    landscape, count = chosen.orientation == "landscape", max(chosen.light_count, 1)
    declared = mission_mounts(mission)
    mount = mount_of(chosen.light_mounts, declared) if chosen.light_mounts else declared[0]
    at = [place or 0 for place in places]
    spacer_m = chosen.spacer_mm * 1e-3
    return problem.with_mount(mount), Hardware(at[0], at[1], at[2], landscape, at[3], count, mount, spacer_m)


def place_of(part_id: str, parts: Sequence[Part]) -> int | None:
    """Index of a part among those that the mission allows."""
    wanted = plain_name(part_id)

    def name(part: Part) -> str:
        return part.enclosure_id if isinstance(part, Port) else part.id

    return next((index for index, part in enumerate(parts) if plain_name(name(part)) == wanted), None)


def enclosure_id(design: Design) -> str:
    """The id of a design's port with that of its housing."""
    port, housing = design.hardware.port, design.hardware.housing
    if design.hardware.complete is not None:
        return port.id
    return Port(port.id, housing=None if housing is None else Housing(housing.id)).enclosure_id


def mount_of(mounts: list[LampPlace], declared: list[Mount]) -> Mount:
    """The lights' places: those of the declared grid where they are on it, else one by one."""
    places = [LightMount(**asdict(m)) for m in mounts]
    for one in declared:
        if one.explicit and [m.model_dump() for m in one.explicit] == [m.model_dump() for m in places]:
            return one
    first = places[0]
    plain = Mount(abs(first.y_m), first.tilt_y_deg)
    level = all(m.x_m == m.z_m == m.tilt_x_deg == 0.0 and m.tilt_y_deg == plain.tilt_deg for m in places)
    sides = [plain.baseline_m * (1.0 if n % 2 == 0 else -1.0) for n in range(len(places))]
    if level and [m.y_m for m in places] == sides:
        return plain
    return Mount(explicit=tuple(places))


def evaluated_problem(
    mission: Mission, system: Mapping[str, Any], physics: UsedPhysics
) -> tuple[Problem, Hardware]:
    """Tables of the system that was evaluated, without the effects that physics `auto` left out."""
    from uwopt.forward.assembly import system_problem
    from uwopt.mission.system import load_system

    problem, hardware = system_problem(mission, load_system(system))
    if mission.physics == "auto":
        left_out = [effect.name for effect in physics.effects if not effect.kept]
        problem = problem.with_effects(Effects().without(left_out))
    return problem, hardware


def given_settings(model: DesignModel, index: int, settings: Mapping[str, float | None]) -> SceneSettings:
    """A design's settings in SI; a focus distance that is absent is infinite."""

    def si(key: str, scale: float = 1.0) -> float | None:
        value = settings.get(key)
        return None if value is None else float(value) * scale

    focus = si("focus_distance_m")
    distance_m = np.inf if focus is None else focus
    return SceneSettings(
        f_number=si("f_number"),
        exposure_s=si("exposure_ms", 1e-3),
        pulse_s=si("pulse_ms", 1e-3),
        gain=si("gain"),
        level=si("dim_frac"),
        rate_hz=si("frame_rate_hz"),
        dioptre_per_m=float(lens_dioptre_per_m(distance_m, focus_map=model.maps[index])),
    )


def telling_figures(made: Replay, index: int) -> dict[str, float]:
    """A few of the plain figures: all inputs are in them, and they take a tenth of the time of all."""
    model, settings = made.model, made.settings[index]
    view, at = model.view_at(index, float(settings.dioptre_per_m[0])), model.problem.scenes[index].nominal
    figures = made.figures(index, information=False)
    wide_m, high_m = field_of_view_m(view, model.hardware.landscape)
    return {
        "fov_x_m": wide_m, "fov_y_m": high_m, "gsd_mm": 1e3 * float(view.gsd_m[0, 1]),
        "electrons_signal": float(figures.electrons_signal[0, at]), "snr": float(figures.snr[0, at]),
        "dof_near_m": float(figures.dof_near_m[0]),
        "floor_illuminance_mean_lx": illuminance(model, index, settings)["floor_illuminance_mean_lx"],
    }  # fmt: skip


def refuse_changed(made: Replay, design: Design) -> None:
    """Raise where the model of today gives other figures than the result holds."""
    for index, scene in enumerate(design.scenes):
        for name, now in telling_figures(made, index).items():
            then = scene.figures.get(name)
            if then is not None and abs(now - float(then)) > SAME_REL * abs(float(then)):
                raise ReplayError(
                    f"the design cannot be recomputed: {name} of scene {scene.name!r} is {float(then):.6g} in the "
                    f"result, {now:.6g} today; the catalogue, a file of the mission or the model has "
                    "changed since, so solve or evaluate again"
                )

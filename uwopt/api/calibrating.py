"""`uwopt calibrate`: test shots fitted by the forward model, a mission with what they tell, and what that changes."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from uwopt.api.common import Source, check_day, prepared
from uwopt.api.evaluating import scene_settings
from uwopt.api.solving import solve
from uwopt.catalog.changes import log_text
from uwopt.catalog.update import planned
from uwopt.deadline import Progress
from uwopt.documents.files import csv_text
from uwopt.errors import MissionError, SolverError, UwoptError
from uwopt.forward.assembly import load_catalog, system_problem
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.part_columns import FLASH
from uwopt.forward.problem import Problem
from uwopt.forward.scene import SceneOptics
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.shots import Shot, read_shots
from uwopt.mission.system import System, load_system
from uwopt.solvers.calibration.fit import fitted
from uwopt.solvers.calibration.light import shot_light
from uwopt.solvers.calibration.summary import Calibrated

SATURATED = 0.95  # of where the camera ends: a mean so high has clipped pixels
LEAST_NET_DN = 0.5  # above the dark level: half a number
LEAST_TOLD_DN = 1.0  # by the model: less light than the camera can tell
MISSION_FILE = "calibrated.yaml"
GRID_NM = np.arange(380.0, 781.0)
Keep = Callable[[Mapping[str, str]], object]  # writes files where they stay


def calibrate(
    mission: Source | Mission, system: Source | System, shots: str | Path, *, card: float | None = None,
    at: str | None = None, scene: str = "", today: str = "", keep: Keep | None = None, name: str = MISSION_FILE,
    again: bool = True, physics: str | None = None, seconds: float | None = None, progress: Progress | None = None,
) -> Calibrated:  # fmt: skip
    """Fit test shots of a system, and solve the mission before and with what they tell.

    Parameters
    ----------
    shots : CSV as `uwopt.mission.shots` reads it
    card : reflectance of a grey card that was shot; None: the mission's own floor
    at : `image`, levels are means over all of it, or `middle`, over a patch; a card is read in the middle by default
    scene : whose water it was, where the mission has several
    today : YYYY-MM-DD, of the log in which a lamp of the catalogue is changed; today unless given
    keep : writes the new mission and the files beside it where they stay; else they last as long as the call
    again : solve the mission before and after
    seconds : for each of both
    """
    check_day(today := today or date.today().isoformat())
    wanted = prepared(mission, physics, None)
    built = load_system(system, load_catalog(wanted))
    if card is not None and not 0.0 < card <= 1.0:
        raise MissionError(f"card = {card:g} is not a reflectance above 0 and up to 1; 0.18 is the usual grey card")
    place = scene_place(wanted, scene)
    read = read_shots(shots)
    standing = distances(wanted, built, place, read, card)
    taken, left_out = usable(read, standing[0][0])
    refuse_few(Path(shots).name, len(taken), left_out)
    kept = [standing[n] for n, shot in enumerate(read) if shot.name not in left_out]
    light = shot_light(kept, taken, in_middle=(at or ("middle" if card is not None else "image")) == "middle")
    levels = np.array([net_dn(shot, float(kept[0][0].cameras.bits[0])) for shot in taken])
    left_out |= {
        shot.name: "saturated" if net >= SATURATED * most else "by the model no light gets there"
        for shot, net, most, told in zip(taken, levels, light.full_dn, light.net_dn(1.0), strict=True)
        if net >= SATURATED * most or told < LEAST_TOLD_DN
    }
    rows = np.array([n for n, shot in enumerate(taken) if shot.name not in left_out], int)
    taken, light, levels = [taken[n] for n in rows], light.take(rows), levels[rows]
    refuse_few(Path(shots).name, len(taken), left_out)
    try:
        fit = fitted(light, levels, distances_m=np.array([shot.distance_m for shot in taken]))
    except SolverError as fault:
        raise MissionError(f"{Path(shots).name}: {fault}") from None
    optics = standing[0][0].scenes[0]
    made = Calibrated(
        wanted, built, tuple(taken), left_out, fit, tuple(float(net) for net in levels), wanted.scenes[place].name,
        "lamp" if card is not None else "floor", at_530(optics), float(np.median(optics.reflectance)),
    )  # fmt: skip
    made = written(made, place, optics, standing[0][0], Path(name).stem, today)
    return solved(made, keep, name, again=again, seconds=seconds, progress=progress)


def refuse_few(name: str, count: int, left_out: Mapping[str, str]) -> None:
    """Raise MissionError where less than two shots are left."""
    if count < 2:
        why = "; ".join(f"{shot}: {text}" for shot, text in left_out.items())
        raise MissionError(
            f"{name}: {count} shot can be used, two are the least{f' ({why})' if why else ''}; take more, at two "
            "distances or three"
        )


def scene_place(mission: Mission, name: str) -> int:
    """Which scene the shots are from."""
    names = [scene.name for scene in mission.scenes]
    if not name and len(names) == 1:
        return 0
    if name not in names:
        told = f"--scene {name!r} is none of" if name else "the mission has several scenes; name with --scene one of"
        raise MissionError(f"{mission.source_name}: {told} {', '.join(names)}")
    return names.index(name)


Standing = tuple[Problem, Hardware, SceneSettings]


def distances(
    mission: Mission, system: System, place: int, shots: Sequence[Shot], card: float | None
) -> list[Standing]:
    """Of each shot the problem of its system as it looks from its distance; one problem a distance."""
    data = mission.to_dict(absolute_paths=True)
    view, scene = mission.views[place], dict(data["scenes"][place])
    scene |= {"vehicle": None, "requirements": None, "time_share": None}
    scene |= {} if card is None else {"seafloor": card}
    made: dict[float, Standing] = {}
    for shot in shots:
        if shot.distance_m in made:
            continue
        vehicle = data["vehicle"] | view.vehicle.model_dump(mode="json", exclude_unset=True)
        vehicle |= {"altitude_m": shot.distance_m, "altitude_tolerance_m": 0.0, "camera_baseline_m": None}
        vehicle |= {"camera_convergence_deg": 0.0, "camera_count": system.camera_count}
        plain = {
            "name": data["name"], "practice": "bare", "physics": "paper" if mission.physics == "paper" else "full",
            "scenes": [scene], "vehicle": vehicle, "requirements": {"frame_interval_s": 60.0},
            "catalog": {"files": data["catalog"]["files"], "generic": "allow"},
        }  # fmt: skip
        try:
            there = prepared(load_mission(plain), None, None)
            problem, hardware = system_problem(there, system)
            given = scene_settings(problem, hardware, system, scene["name"])
        except UwoptError as fault:
            raise MissionError(f"from {shot.distance_m:g} m (shot {shot.name}): {fault}") from None
        made[shot.distance_m] = problem, hardware, replace(given, focus_distance_m=None, rate_hz=None)
    return [made[shot.distance_m] for shot in shots]


def net_dn(shot: Shot, bits: float) -> float:
    """A level above the dark level, in numbers of the camera."""
    return (shot.level - shot.dark) * (1.0 if shot.unit == "dn" else 2.0**bits - 1.0)


def usable(shots: Sequence[Shot], problem: Problem) -> tuple[list[Shot], dict[str, str]]:
    """Shots whose levels say something, and the others by name with the reason."""
    bits = float(problem.cameras.bits[0])
    full = 2.0**bits - 1.0
    left_out = {}
    for shot in shots:
        level_dn = shot.level * (1.0 if shot.unit == "dn" else full)
        if level_dn > full * (1.0 + 1e-9):
            raise MissionError(
                f"shot {shot.name}: level {shot.level:g} is more than the camera's {bits:g} bits can say "
                f"({full:g}); give numbers of its own bits, or level_pct"
            )
        if level_dn >= SATURATED * full:
            left_out[shot.name] = "saturated"
        elif net_dn(shot, bits) < LEAST_NET_DN:
            left_out[shot.name] = "no brighter than its dark level"
    return [shot for shot in shots if shot.name not in left_out], left_out


# ---------------------------------------------------------------- what is written


def at_530(scene: SceneOptics) -> float:
    """Beam attenuation at 530 nm [1/m]."""
    return float(np.interp(530.0, scene.wavelength_nm, scene.attenuation_per_m))


def written(
    made: Calibrated, place: int, optics: SceneOptics, problem: Problem, stem: str, today: str
) -> Calibrated:
    """The mission's new text and the files beside it, by name; and what could not be put into them."""
    factors, notes = made.fit.factors, list[str]()
    data = made.mission.to_dict(absolute_paths=True)
    scene, files = data["scenes"][place], dict[str, str]()
    if not factors["water"].held:
        files[f"{stem}-water.csv"] = water_csv(optics, factors["water"].value)
        scene |= {"water": f"{stem}-water.csv", "water_table": None}
        scene |= dict.fromkeys(("c_per_m", "visibility_m", "secchi_m", "turbidity_ntu"))
    if not factors["back"].held:
        ratio = float(scene["backscatter_ratio"]) * factors["back"].value
        own = str(scene["phase_function"]).casefold().replace("_", "-") in ("fournier-forand", "henyey-greenstein")
        if own and 0.005 <= ratio <= 0.1:
            scene["backscatter_ratio"] = float(f"{ratio:.4g}")
        else:
            notes.append(f"backscatter is not written: {ratio:.3g} of all scattering is no ratio that "
                         f"{scene['phase_function']} takes")  # fmt: skip
    put_to, factor = made.put_to, factors["light"].value
    if put_to == "floor" and float(np.max(optics.reflectance)) * factor > 1.0:
        notes.append("the floor would give back more light than it gets, so that it is put down to the lamp")
        put_to = "lamp"
    if put_to == "floor":
        if isinstance(scene["seafloor"], float):
            scene["seafloor"] = float(f"{scene['seafloor'] * factor:.4g}")
        else:
            files[f"{stem}-floor.csv"] = floor_csv(optics, factor)
            scene["seafloor"] = f"{stem}-floor.csv"
    else:
        notes += lamp_written(made, problem, factor, stem, today, data, files)
    head = "".join(f"# {line}\n" for line in story(made, put_to))
    files[f"{stem}.yaml"] = head + str(yaml.safe_dump(data, sort_keys=False, allow_unicode=True))
    searched = put_to == "floor" or len(files) > 1 + (f"{stem}.system.yaml" in files) or not factors["back"].held
    return replace(made, files=files, notes=tuple(notes), put_to=put_to, searched=searched)


def story(made: Calibrated, put_to: str) -> list[str]:
    """Where a calibrated mission comes from."""
    name = " ".join(made.mission.name.split())  # no line of it may leave the comment
    told = [f"{name}, with what {len(made.shots)} test shots tell."]
    for one in made.fit.factors.values():
        what = f"held as it was ({one.held})" if one.held else f"times {one.value:.4g}"
        light = f"light times reflectance, put to the {put_to}"
        told.append(f"{ {'light': light, 'water': 'attenuation', 'back': 'backscatter'}[one.name]}: {what}")
    return told


def water_csv(optics: SceneOptics, factor: float) -> str:
    """The water with all of its attenuation times a factor."""
    c, kd = optics.attenuation_per_m, optics.diffuse_attenuation_per_m
    columns = {"attenuation_per_m": c}
    if optics.scattering:
        b = np.sum([one.scattering_per_m for one in optics.scattering], axis=0)
        columns |= {"a_per_m": np.maximum(c - b, 0.0), "b_per_m": b}
    if kd is not None:
        columns["kd_per_m"] = kd
    rows = [GRID_NM, *(factor * np.interp(GRID_NM, optics.wavelength_nm, column) for column in columns.values())]
    return table(("wavelength_nm", *columns), rows)


def floor_csv(optics: SceneOptics, factor: float) -> str:
    """The floor's reflectance times a factor."""
    return table(
        ("wavelength_nm", "reflectance"),
        [GRID_NM, factor * np.interp(GRID_NM, optics.wavelength_nm, optics.reflectance)],
    )


def table(names: Sequence[str], columns: Sequence[Any]) -> str:
    """Columns as CSV."""
    rows = zip(*columns, strict=True)
    told = ([value if isinstance(value, str) else f"{value:.6g}" for value in row] for row in rows)
    return csv_text([names, *told])


def lamp_written(
    made: Calibrated, problem: Problem, factor: float, stem: str, today: str, data: dict[str, Any],
    files: dict[str, str],
) -> list[str]:  # fmt: skip
    """The lamp that gives so many times the light: as a change of the catalogue, or in a system file of its own."""
    lamp, lights = problem.parts.lights[0], problem.lights
    leaves = float(lights.output_factor[0]) * factor
    cells = {"output_factor": f"{min(leaves, 1.0):.4g}"}
    if leaves > 1.0:
        if int(lights.kind[0]) == FLASH:
            return [f"the lamp's light is not written: a flash cannot give {leaves:.3g} of what it has"]
        cells["flux_lm"] = f"{float(lights.full_light[0]) * leaves:.5g}"
    given = made.system.part("light")
    if isinstance(given, dict):
        data_of_system = made.system.to_dict(absolute_paths=True)
        data_of_system["light"] = {**given, **{key: float(text) for key, text in cells.items()}}
        if "flux_lm" in cells:  # what is set of it is the same share
            for own in (data_of_system["settings"], *data_of_system["scenes"].values()):
                if own.get("flux_lm") is not None:
                    own["flux_lm"] *= leaves
        files[f"{stem}.system.yaml"] = str(yaml.safe_dump(data_of_system, sort_keys=False, allow_unicode=True))
        return [f"the lamp stands in the system alone, so that {stem}.system.yaml holds it; lamps that are searched "
                "stay as they are"]  # fmt: skip
    with tempfile.TemporaryDirectory() as scratch:
        rows, log = Path(scratch) / "rows.csv", Path(scratch) / "log.csv"
        rows.write_text(table(("id", *cells), [[lamp.id], *([float(text)] for text in cells.values())]), "utf-8")
        plan = planned([rows], log, date=today, source="test shots")
    files[f"{stem}-lamps.csv"] = log_text(plan.log)
    data["catalog"]["files"] = [*data["catalog"]["files"], f"{stem}-lamps.csv"]
    return []


def solved(
    made: Calibrated, keep: Keep | None, name: str, *, again: bool, seconds: float | None, progress: Progress | None
) -> Calibrated:
    """The mission solved before and after; its new files are tried aside before they are written where they stay."""
    with tempfile.TemporaryDirectory() as scratch:
        for file, text in made.files.items():
            (Path(scratch) / file).write_text(text, encoding="utf-8")
        after = prepared(Path(scratch) / f"{Path(name).stem}.yaml", None, None)
        if keep is not None:
            keep(made.files)
        if not (again and made.searched):
            return made
        before, then = (
            solve(mission, quick=True, seconds=seconds, progress=progress) for mission in (made.mission, after)
        )
        return replace(made, before=before, after=then)

"""`uwopt.compare`: systems side by side in one mission, each evaluated by the same rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from uwopt.api.common import Source, prepared
from uwopt.api.evaluating import evaluate
from uwopt.deadline import Progress
from uwopt.errors import MissionError
from uwopt.forward.assembly import load_catalog
from uwopt.mission.mission import Mission
from uwopt.mission.system import System, load_system
from uwopt.results.comparison import Comparison, SideBySide
from uwopt.results.design import PRACTICE_YIELDS

MOST_SYSTEMS = 12  # columns that a page can show
RECOMMENDED = "recommended"


def compare(
    mission: Source | Mission, systems: Source | System | Sequence[Source | System], *, recommended: bool = False,
    physics: str | None = None, seconds: float | None = None, progress: Progress | None = None,
) -> Comparison:  # fmt: skip
    """Systems side by side in a mission, requirement by requirement.

    Where `solve` lets some of good practice give way, all systems are held against what is left of it.

    Parameters
    ----------
    mission : file name, mapping or Mission
    systems : file names or mappings, each as `evaluate` takes them, or one
    recommended : also what `solve` recommends
    physics : another than the mission's
    seconds : for the search of what `solve` recommends; what it has found by then stands beside the systems
    """
    if isinstance(systems, (str, Path, Mapping, System)):
        systems = [systems]
    if not systems:
        raise MissionError("compare: no system is named; give one system file or more behind the mission.")
    if len(systems) > MOST_SYSTEMS:
        raise MissionError(f"compare: {len(systems)} systems are too many for a page; give {MOST_SYSTEMS} at most.")
    wanted = prepared(mission, physics, None)
    catalog = load_catalog(wanted)
    loaded = [load_system(system, catalog) for system in systems]
    names = apart(with_folders([shown_name(system) for system in loaded], loaded))
    best, gave_way = None, ""
    if recommended:
        from uwopt.api.solving import solve

        best = solve(wanted, quick=True, seconds=seconds, progress=progress)
        gave_way = next((note.message for note in best.warnings if note.code == PRACTICE_YIELDS), "")
        if gave_way:  # what is recommended and what is given are held to the same
            wanted = wanted.with_changes(**{section: best.mission[section] for section in ("requirements", "reserve")})
    found = [SideBySide(name, evaluate(wanted, system)) for name, system in zip(names, loaded, strict=True)]
    if best is None:
        return Comparison(tuple(found))
    if best.best is None:
        return Comparison(tuple(found), nothing_fits=best.status == "infeasible", cut_short=best.status == "stopped")
    return Comparison((*found, SideBySide(RECOMMENDED, best)), gave_way=gave_way)


def shown_name(system: System) -> str:
    """A system's own name, or that of its file."""
    given = system.name != System.model_fields["name"].default
    return system.name if given else Path(system.source_name).name.removesuffix(".yaml").removesuffix(".system")


def with_folders(names: Sequence[str], systems: Sequence[System]) -> list[str]:
    """Names that occur again with the folder of their file before them, as `solve --out` writes each by one name."""
    folders = [Path(system.source_name).parent.name for system in systems]
    return [
        f"{folder}/{name}" if folder and names.count(name) > 1 else name
        for name, folder in zip(names, folders, strict=True)
    ]


def apart(names: Sequence[str]) -> list[str]:
    """Names with a number behind those that occur again."""
    made: list[str] = []
    for name in names:
        number, told = 2, name
        while told in made:
            told, number = f"{name} ({number})", number + 1
        made.append(told)
    return made

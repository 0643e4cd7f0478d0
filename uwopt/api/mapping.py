"""`uwopt plot map`: any figure of a given system over any two inputs of its mission or of itself."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from uwopt.api.common import Source
from uwopt.api.evaluating import evaluate
from uwopt.deadline import Progress
from uwopt.documents.faults import nearest
from uwopt.errors import MissionError, RangeError, UwoptError
from uwopt.forward.assembly import load_catalog
from uwopt.mission.mission import Mission
from uwopt.mission.system import System, load_system
from uwopt.mission.varying import Value, Varied, VariedMission, checked_values
from uwopt.mission.varying_system import is_system_key, with_system_value
from uwopt.units import split_unit

DEFAULT_FIGURE = "snr_db"
MOST_POINTS = 10_000


class UnknownFigureError(RangeError):
    """A figure that no scene has: wrong at every point."""


@dataclass(frozen=True)
class MapInput:
    """One input and the values that it takes, each once, as a mission or system file would have them."""

    key: str
    values: tuple[Value, ...]
    of_mission: Varied | None  # None: a key of the system

    @property
    def unit(self) -> str:
        """Of its values; "" where they have none."""
        return split_unit(self.key)[1]


@dataclass(frozen=True)
class FigureMap:
    """A figure over two inputs: `values[row][column]`, rows by the second; None where it cannot be told, and why."""

    figure: str
    x: MapInput
    y: MapInput
    values: list[list[float | None]]
    met: list[list[bool | None]]  # whether every requirement is; None where nothing was evaluated
    refused: tuple[str, ...]  # what was said of points that could not be evaluated, each once
    scene: str

    @property
    def unit(self) -> str:
        """Of the figure."""
        return split_unit(self.figure)[1]

    def rows(self) -> list[dict[str, Any]]:
        """One row a point."""
        return [
            {self.x.key: x, self.y.key: y, self.figure: self.values[row][column], "met": self.met[row][column]}
            for row, y in enumerate(self.y.values)
            for column, x in enumerate(self.x.values)
        ]


def figure_map(
    mission: Source | Mission, system: Source | System, inputs: Mapping[str, Sequence[Any] | str], *,
    figure: str = DEFAULT_FIGURE, scene: int = 0, physics: str | None = None, progress: Progress | None = None,
) -> FigureMap:  # fmt: skip
    """A figure of a system over two inputs, each point as `evaluate` has it.

    Parameters
    ----------
    inputs : two keys with their values, a range `from:to:how many` or a list; keys of the mission as `whatif` names
        them (`speed_m_s`, `water`), or of the system (`f_number`, `light_tilt_deg`, `lens.focal_length_mm`, `camera`)
    figure : name of a number among the figures of a scene, such as snr_db, dof_m or electrons_signal
    scene : which, counted from 0
    """
    if len(inputs) != 2:
        raise MissionError(
            f"map: {len(inputs)} inputs are given, a map is drawn over two; write such as speed_m_s=0.2:2:12 and "
            "altitude_m=1:4:12"
        )
    base = VariedMission(mission, {} if physics is None else {"physics": physics})
    built = load_system(system, load_catalog(base.base)).to_dict(absolute_paths=True)
    x, y = (map_input(base, key.strip(), values) for key, values in inputs.items())
    if x.key == y.key:
        raise MissionError(f"map: {x.key} is given twice; name two inputs")
    if not 0 <= scene < len(base.base.scenes):
        raise RangeError(f"there is no scene {scene}; the mission has {len(base.base.scenes)}, counted from 0")
    if (points := len(x.values) * len(y.values)) > MOST_POINTS:
        raise MissionError(f"map: {points} points are too many; {MOST_POINTS} are evaluated at most")
    values: list[list[float | None]] = [[None] * len(x.values) for _ in y.values]
    met: list[list[bool | None]] = [[None] * len(x.values) for _ in y.values]
    refused: list[str] = []
    grid = itertools.product(enumerate(y.values), enumerate(x.values))
    try:
        for done, ((row, y_value), (column, x_value)) in enumerate(grid, 1):
            try:
                found = at_point(base, built, {x: x_value, y: y_value}, figure, scene)
                values[row][column], met[row][column] = found
            except UnknownFigureError:
                raise
            except UwoptError as fault:
                refused.append(str(fault))
            if progress is not None:
                progress(done / points, f"map, {done} of {points} points")
    except KeyboardInterrupt:  # what is there is drawn
        refused.append(f"stopped before all of the {points} points were evaluated")
    if all(one is None for line in met for one in line):
        raise MissionError(f"map: no point can be evaluated: {refused[0]}")
    return FigureMap(figure, x, y, values, met, tuple(dict.fromkeys(refused)), base.base.scenes[scene].name)


def map_input(base: VariedMission, key: str, values: Sequence[Any] | str) -> MapInput:
    """A key of the system, else of the mission, with checked values."""
    if is_system_key(key):
        return MapInput(key, checked_values(f"map {key}", values), None)
    varied = base.varied(key, values)
    return MapInput(key, varied.values, varied)


def at_point(
    base: VariedMission, system: Mapping[str, Any], at: Mapping[MapInput, Value], figure: str, scene: int
) -> tuple[float | None, bool]:
    """The figure at one point, and whether every requirement is met there."""
    wanted = base.with_values({key.of_mission: value for key, value in at.items() if key.of_mission is not None})
    varied = dict(system)
    for key, value in at.items():
        if key.of_mission is None:
            varied = with_system_value(varied, key.key, value)
    design = evaluate(wanted, varied).design
    assert design is not None  # or evaluate would have raised
    figures = design.scenes[scene].figures
    numbers = [name for name, value in figures.items() if not isinstance(value, (bool, str))]
    if figure not in numbers:
        near = nearest(figure, numbers)
        mend = f"did you mean {near}?" if near else f"there are {', '.join(numbers)}"
        raise UnknownFigureError(f"map: there is no figure {figure!r}; {mend}")
    return figures[figure], design.feasible

"""Tables of a result as pandas frames, by name; units stand in the columns' names or beside the number."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from uwopt.errors import RangeError

if TYPE_CHECKING:
    import pandas as pd
    from _typeshed import DataclassInstance

    from uwopt.results.design import Design

Rows = list[dict[str, Any]]


def frame_of(tables: Mapping[str, Callable[[], Rows] | Sequence[DataclassInstance]], name: str) -> pd.DataFrame:
    """The table of this name: its rows, or one a record; a RangeError names those that there are."""
    import pandas as pd

    if name not in tables:
        raise RangeError(f"there is no table {name!r}; there are {', '.join(tables)}")
    made = tables[name]
    return pd.DataFrame(made() if callable(made) else [asdict(one) for one in made])


def margin_rows(design: Design | None) -> Rows:
    """One row a requirement and scene, at the settings to set where there are any."""
    scenes = [] if design is None else design.as_set.scenes
    return [{"scene": scene.name, **asdict(margin)} for scene in scenes for margin in scene.margins]


def bill_rows(design: Design | None) -> Rows:
    """One row a line of the bill of materials."""
    return [] if design is None else [asdict(row) for row in design.bom]


def settings_rows(design: Design | None) -> Rows:
    """One row a setting and scene: exact, and as a person sets it."""
    return [
        {
            "scene": scene.name,
            "setting": name,
            "exact": value,
            "to_set": (scene.settings_to_set or {}).get(name),
        }
        for scene in ([] if design is None else design.scenes)
        for name, value in scene.settings.items()
    ]


def figure_rows(design: Design | None) -> Rows:
    """One row a figure, one column a scene, at the settings to set where there are any."""
    scenes = [] if design is None else design.as_set.scenes
    names = list(dict.fromkeys(name for scene in scenes for name in scene.figures))
    return [{"figure": name, **{scene.name: scene.figures.get(name) for scene in scenes}} for name in names]


def design_rows(designs: list[Design]) -> Rows:
    """One row a design: parts, objective, cost, power and mass."""
    return [
        {
            **design.hardware.ids_by_kind,
            **{key: design.hardware[key] for key in ("camera_count", "light_count", "orientation")},
            "objective": design.objective_value,
            **{f"cost_{key}": value for key, value in asdict(design.totals.cost).items()},
            **{key: value for key, value in asdict(design.totals).items() if key != "cost"},
        }
        for design in designs
    ]

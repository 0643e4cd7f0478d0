"""`uwopt plot`: the plots of a report, one at a time, as a page, an image or a table.

A plot is pictures below each other; what is drawn comes from the model at the design, as in a report.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uwopt.api.common import Source
from uwopt.api.mapping import DEFAULT_FIGURE, FigureMap, figure_map
from uwopt.deadline import Progress
from uwopt.errors import MissionError, OutputError, RangeError
from uwopt.mission.mission import Mission
from uwopt.mission.system import System
from uwopt.report.pictures.design_pictures import Picture
from uwopt.report.text import formats
from uwopt.results.result import Result
from uwopt.results.version import __version__

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from uwopt.evaluation.recompute import Replay

MAP = "map"
SUFFIXES = (".html", ".png", ".svg", ".csv")


@dataclass(frozen=True)
class DesignPlot:
    """A plot with the mission that it is of."""

    name: str
    pictures: tuple[Picture, ...]
    mission: str
    mapped: FigureMap | None = None

    def figure(self, index: int = 0) -> go.Figure:
        """One of its pictures as a plotly figure."""
        import plotly.graph_objects as go

        picture = self.pictures[index]
        return go.Figure(picture.content).update_layout(title=picture.title, template="plotly_white", margin_t=64)

    def rows(self) -> list[dict[str, Any]]:
        """One row a point of every curve and map, with what the axes are."""
        if self.mapped is not None:
            return self.mapped.rows()
        return [row for picture in self.pictures for row in picture_rows(picture)]

    def write(self, file: str | Path) -> Path:
        """Write it, in the form that the file's name ends in: .html, .png, .svg or .csv."""
        from uwopt.report.write import checked_out_file, made_folder, write_files

        target = checked_out_file(checked_suffix(file))
        made = self.content(target.suffix.casefold())
        return write_files(made_folder(target.parent), {target.name: made})[0]

    def content(self, suffix: str) -> str | bytes:
        """What a file with this ending holds."""
        if suffix == ".csv":
            from uwopt.report.write import rows_csv

            return rows_csv(self.rows(), ["plot"])
        if suffix == ".html":
            return self.html()
        from uwopt.report.pictures.static import static_image

        return static_image(self.pictures, "png" if suffix == ".png" else "svg")

    def html(self) -> str:
        """A page that works alone."""
        from uwopt.report.page.html_file import rendered, slim

        figures = {one.id: slim(one.content) for one in self.pictures}
        return rendered(
            "plot.html", ("page.js",), {"figures": figures, "front": None}, title="Plot",
            name=formats.one_line(self.mission, 120), version=__version__, pictures=self.pictures,
        )  # fmt: skip


def plot(
    name: str, mission: Source | Mission, system: Source | System | None = None, *,
    scene: int = 0, physics: str | None = None, inputs: Mapping[str, Sequence[Any] | str] | None = None,
    figure: str = DEFAULT_FIGURE, progress: Progress | None = None,
) -> DesignPlot:  # fmt: skip
    """A plot of a system in a mission; without a system, of what `solve` recommends.

    Parameters
    ----------
    name : dof, framerate, exposure, spectrum, attenuation, sensor, light or map
    scene : which, counted from 0
    inputs, figure : of a map; see `uwopt.api.mapping.figure_map`
    """
    if name not in plot_names():
        raise RangeError(f"there is no plot {name!r}; there are {', '.join(plot_names())}")
    if name != MAP and inputs:
        raise MissionError(f"plot {name}: takes no inputs; plot map draws a figure over two")
    result = designed(mission, system, physics, progress)
    told = str(result.mission.get("name") or "mission")
    if name != MAP:
        return DesignPlot(name, tuple(result_pictures(result, name, scene)), told)
    from uwopt.explore.figure_map import map_picture

    made = figure_map(
        mission, system_of(result) if system is None else system, inputs or {}, figure=figure, scene=scene,
        physics=physics, progress=progress,
    )  # fmt: skip
    return DesignPlot(name, (map_picture(made),), told, made)


def plot_names() -> tuple[str, ...]:
    """All plots."""
    return (*makers(), MAP)


def makers() -> dict[str, Callable[[Replay, int], list[Picture]]]:
    """What draws each plot of a design."""
    from uwopt.report.notebook import plot_makers
    from uwopt.report.pictures import passing

    known = plot_makers()

    def one(name: str) -> Callable[[Replay, int], list[Picture]]:
        return lambda made, scene: [picture for picture in known[name](made, scene) if picture.id == name]

    return {
        "dof": known["dof-aperture"], "framerate": one("rate"), "exposure": one("exposure"),
        "spectrum": known["spectrum"],
        "attenuation": lambda made, scene: [passing.attenuation_picture(passing.water_curves(made, scene))],
        "sensor": lambda made, scene: [passing.sensor_picture(passing.sensor_curves(made, scene))],
        "light": known["illuminance"],
    }  # fmt: skip


def result_pictures(result: Result, name: str, scene: int) -> list[Picture]:
    """The pictures of one plot of a result's design."""
    pictures = drawn_by(result, scene, makers()[name])
    if not pictures:
        raise RangeError(
            f"physics {result.physics.name} knows no field, so there is no plot {name!r}; take physics full or auto"
        )
    return pictures


def drawn_by(result: Result, scene: int, draw: Callable[[Replay, int], list[Picture]]) -> list[Picture]:
    """What draws a design, applied to that of a result."""
    from uwopt.evaluation.recompute import replayed

    design = result.best
    assert design is not None  # `designed` has seen to it
    return draw(replayed(result, design, scene), scene)


def designed(
    mission: Source | Mission, system: Source | System | None, physics: str | None, progress: Progress | None
) -> Result:
    """The result of evaluating the system, or of solving where none is given."""
    if system is not None:
        from uwopt.api.evaluating import evaluate

        return evaluate(mission, system, physics=physics)
    from uwopt.api.solving import solve

    result = solve(mission, physics=physics, quick=True, progress=progress)
    if result.recommendation is None:
        raise MissionError("plot: nothing fits this mission, so there is no system to draw; name one behind it.")
    return result


def system_of(result: Result) -> dict[str, Any]:
    """What was recommended, as a system."""
    assert result.best is not None  # `designed` has seen to it
    return result.best.as_system()


def picture_rows(picture: Picture) -> list[dict[str, Any]]:
    """One row a point of a picture's curves or maps."""
    layout = picture.content["layout"]
    made = []
    for trace in picture.content["data"]:
        across = axis_title(layout, "xaxis")
        up = axis_title(layout, "yaxis" + str(trace.get("yaxis", "y"))[1:])
        head = {"plot": picture.id, "curve": trace.get("name", picture.title), "x_is": across, "y_is": up}
        if trace["type"] == "heatmap":
            unit = trace["colorbar"]["title"]["text"]
            made += [
                {**head, "x": x, "y": y, "value": value, "value_is": unit}
                for y, line in zip(trace["y"], trace["z"], strict=True)
                for x, value in zip(trace["x"], line, strict=True)
            ]
        else:
            made += [{**head, "x": x, "y": y} for x, y in zip(trace["x"], trace["y"], strict=True)]
    return made


def axis_title(layout: Mapping[str, Any], name: str) -> str:
    """What an axis is of."""
    return str(layout.get(name, {}).get("title", {}).get("text", ""))


def checked_suffix(file: str | Path) -> Path:
    """The file, if its name says in which form it is wanted."""
    path = Path(file)
    if path.suffix.casefold() not in SUFFIXES:
        forms = ", ".join(SUFFIXES)
        raise OutputError(f"{file}: its name must end in one of {forms}; the plot is written in that form.")
    return path

"""What a result shows of itself in Python and in a notebook.

Results lie on the ground and know no report; when one is asked for, the room above is imported, as the package's
own face does it.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import plotly.graph_objects as go

NOTEBOOK = "uwopt.report.notebook"


class Reported:
    """What is found can be written as a page."""

    def report(self, path: Any) -> Path:
        """Write the report, one HTML file that works offline; returns its path."""
        written: Path = import_module("uwopt.report.write").write_page(self, path)
        return written


class Shown(Reported):
    """Beside its records and its page a result has a short text, a table for notebooks, and plots."""

    def __repr__(self) -> str:
        return str(import_module(NOTEBOOK).short_text(self))

    def _repr_html_(self) -> str:
        return str(import_module(NOTEBOOK).html(self))

    def figure(self, name: str, *, scene: int = 0, point: str | None = None) -> go.Figure:
        """A plot of the report as a plotly figure; `figure_names` says which there are.

        Parameters
        ----------
        name : spectrum, dof-aperture, dof-focus, rate, exposure, illuminance, snr; of a front also front
        scene : index of the scene, from 0
        point : of a front, the id of a point or the name of a pick; the first point unless given

        Raises
        ------
        RangeError : there is no such plot, scene or point
        UwoptError : the design cannot be recomputed, because a file or part has gone or changed
        """
        figure: go.Figure = import_module(NOTEBOOK).figure(self, name, scene=scene, point=point)
        return figure

    @property
    def figure_names(self) -> tuple[str, ...]:
        """Names that `figure` takes."""
        names: tuple[str, ...] = import_module(NOTEBOOK).figure_names(self)
        return names

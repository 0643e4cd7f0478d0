"""The command `uwopt plot`: one plot of a system in a mission, as a file."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from uwopt.cli.options import MissionArgument, PhysicsOption, QuietOption
from uwopt.cli.output import tell_written
from uwopt.cli.status import DONE, command, print_notice
from uwopt.cli.whatif import by_key
from uwopt.errors import RangeError


class PlotName(StrEnum):
    """The plots that there are."""

    dof = "dof"
    framerate = "framerate"
    exposure = "exposure"
    spectrum = "spectrum"
    attenuation = "attenuation"
    sensor = "sensor"
    light = "light"
    map = "map"


@command
def plot_command(
    name: Annotated[PlotName, typer.Argument(metavar="PLOT", help=", ".join(PlotName) + ".")],
    mission: MissionArgument,
    system: Annotated[
        str | None, typer.Argument(metavar="[SYSTEM]", help="System file (YAML); what solve recommends unless given.")
    ] = None,
    out: Annotated[
        str, typer.Option("--out", "-o", metavar="FILE", help="File to write: .html, .png, .svg or .csv.")
    ] = "",
    x: Annotated[
        str | None, typer.Option("--x", metavar="KEY=VALUES", help="Of a map: first input, such as speed_m_s=0.2:2:12.")
    ] = None,
    y: Annotated[
        str | None, typer.Option("--y", metavar="KEY=VALUES", help="Of a map: second input, such as f_number=2,2.8,4.")
    ] = None,
    figure: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of a map: the figure, such as snr_db (the default) or dof_m.")
    ] = None,
    scene: Annotated[int, typer.Option(metavar="N", min=1, help="Which scene of the mission.")] = 1,
    physics: PhysicsOption = None,
    quiet: QuietOption = False,
) -> int:
    """Draw one plot of a system in a mission: sharpness, operation, spectra, light, or any figure over two inputs."""
    from uwopt.report.text.console import ProgressBar
    from uwopt.report.write import checked_out_file

    if not out:
        raise RangeError(f"plot {name}: names no file to write; add such as -o {name}.html, or .png, .svg, .csv")
    from uwopt.explore.plotting import checked_suffix, plot

    checked_out_file(checked_suffix(out))
    inputs = by_key([word for word in (x, y) if word is not None], "--x, --y")
    with ProgressBar(quiet=quiet, of_all=system is not None) as bar:
        more = {} if figure is None else {"figure": figure}
        made = plot(
            name.value, mission, system, scene=scene - 1, physics=physics and physics.value, inputs=inputs,
            progress=bar.report, **more,
        )  # fmt: skip
        written = made.write(out)
    for fault in made.mapped.refused if made.mapped is not None and not quiet else ():
        print_notice(f"left out: {fault}", DONE)
    tell_written([written], quiet=quiet)
    return DONE

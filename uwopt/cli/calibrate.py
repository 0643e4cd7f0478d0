"""The command `uwopt calibrate`: test shots tell light, floor and water, and a mission is written with them."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from uwopt.cli.options import MissionArgument, PhysicsOption, QuietOption, checked_seconds, seconds_as
from uwopt.cli.output import print_made
from uwopt.cli.status import DONE, command
from uwopt.errors import OutputError


class Where(StrEnum):
    """Where in the images levels were read."""

    image = "image"
    middle = "middle"


@command
def calibrate_command(
    mission: MissionArgument,
    system: Annotated[str, typer.Argument(metavar="SYSTEM", help="System file (YAML) of what took the shots.")],
    shots: Annotated[
        str,
        typer.Argument(
            metavar="SHOTS.csv",
            help="One row a shot: exposure_ms, gain_db, distance_m, level_dn, dark_dn; f_number, light_pct, pulse_ms "
            "and shot as you like. Units stand in the names.",
        ),
    ],
    card: Annotated[
        float | None,
        typer.Option("--card", metavar="R", help="A grey card of this reflectance was shot, not the mission's floor."),
    ] = None,
    at: Annotated[
        Where | None,
        typer.Option("--at", help="Levels are means over the image (of a floor, by default) or a patch in its middle."),
    ] = None,
    scene: Annotated[str, typer.Option("--scene", metavar="NAME", help="Whose water it was, of several scenes.")] = "",
    out: Annotated[
        str | None, typer.Option("--out", metavar="FILE", help="Write a mission with what was fitted, and its files.")
    ] = None,
    fit_only: Annotated[bool, typer.Option("--fit-only", help="Do not solve the mission before and after.")] = False,
    date: Annotated[str, typer.Option(help="Day of the shots, YYYY-MM-DD; today unless given.")] = "",
    physics: PhysicsOption = None,
    seconds: Annotated[float | None, seconds_as("Time for each search, before and after; gaps are told.")] = None,
    quiet: QuietOption = False,
) -> int:
    """Fit test shots of a system: light, floor and water as they are, and what that changes."""
    from uwopt.report.order.calibrated import calibration_blocks
    from uwopt.report.text.console import ProgressBar
    from uwopt.report.write import checked_out_file, made_folder, write_files

    limit_s = checked_seconds(seconds)
    target = None if out is None else checked_out_file(out)
    if target is not None and target.absolute() in (Path(mission).absolute(), Path(system).absolute()):
        raise OutputError(f"{out}: is what is calibrated, with your comments in it; name another file for --out.")
    written: list[Path] = []
    with ProgressBar(quiet=quiet) as bar:
        from uwopt.api.calibrating import MISSION_FILE, calibrate

        def keep(files: Mapping[str, str]) -> None:
            assert target is not None
            written.extend(write_files(made_folder(target.parent), files))

        made = calibrate(
            mission, system, shots, card=card, at=None if at is None else at.value, scene=scene,
            today=date, keep=None if target is None else keep,
            name=MISSION_FILE if target is None else target.name, again=not fit_only,
            physics=physics and physics.value, seconds=limit_s, progress=bar.report,
        )  # fmt: skip
    print_made(calibration_blocks(made), written, mission=made.mission.to_dict(), quiet=quiet)
    return DONE

"""What came of test shots, with the mission before and after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from uwopt.mission.mission import Mission
from uwopt.mission.shots import Shot
from uwopt.mission.system import System
from uwopt.results.result import Result
from uwopt.solvers.calibration.fit import Fit


@dataclass(frozen=True)
class Calibrated:
    """What came of test shots.

    shots : that were taken; left_out : the others by name, and why
    put_to : what light times reflectance was put down to, floor or lamp
    notes : what could not be written, or should be known of it
    searched : whether anything that a search looks at is another
    """

    mission: Mission
    system: System
    shots: tuple[Shot, ...]
    left_out: Mapping[str, str]
    fit: Fit
    net_dn: Sequence[float]
    scene: str
    put_to: str
    before_per_m: float
    reflectance: float
    files: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    searched: bool = True
    before: Result | None = None
    after: Result | None = None

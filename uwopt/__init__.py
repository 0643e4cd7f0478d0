"""uwopt: from an underwater imaging mission to a camera system that can be bought, with a proof.

`solve` finds the best system of a catalogue, `pareto` the trade-off between objectives, `evaluate` says what a
given system would do, `compare` puts systems side by side, `whatif` tells how the optimum changes with the mission,
`sweep` works out many missions, `calibrate` fits test shots.
Heavy imports wait until they are needed.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from uwopt.results.version import __version__

if TYPE_CHECKING:
    from uwopt.api.calibrating import calibrate as calibrate
    from uwopt.api.comparing import compare as compare
    from uwopt.api.evaluating import evaluate as evaluate
    from uwopt.api.solving import solve as solve
    from uwopt.api.trading import pareto as pareto
    from uwopt.api.whatif import whatif as whatif
    from uwopt.explore.plotting import plot as plot
    from uwopt.forward.assembly import load_catalog as load_catalog
    from uwopt.mission.mission import Mission as Mission
    from uwopt.mission.mission import load_mission as load_mission
    from uwopt.mission.system import System as System
    from uwopt.mission.system import load_system as load_system
    from uwopt.objectives.own import OwnObjective as OwnObjective
    from uwopt.results.front import FrontResult as FrontResult
    from uwopt.results.result import Result as Result
    from uwopt.results.sweep import SweepSummary as SweepSummary
    from uwopt.results.whatif import WhatIf as WhatIf
    from uwopt.sweeps.run import sweep as sweep

_WHERE = {
    "solve": "uwopt.api.solving",
    "evaluate": "uwopt.api.evaluating",
    "load_catalog": "uwopt.forward.assembly",
    "Mission": "uwopt.mission.mission",
    "load_mission": "uwopt.mission.mission",
    "System": "uwopt.mission.system",
    "load_system": "uwopt.mission.system",
    "Result": "uwopt.results.result",
    "pareto": "uwopt.api.trading",
    "FrontResult": "uwopt.results.front",
    "compare": "uwopt.api.comparing",
    "calibrate": "uwopt.api.calibrating",
    "plot": "uwopt.explore.plotting",
    "whatif": "uwopt.api.whatif",
    "WhatIf": "uwopt.results.whatif",
    "sweep": "uwopt.sweeps.run",
    "SweepSummary": "uwopt.results.sweep",
    "OwnObjective": "uwopt.objectives.own",
}
__all__ = ["__version__", *_WHERE]


def __getattr__(name: str) -> Any:
    if name in _WHERE:
        return getattr(import_module(_WHERE[name]), name)
    raise AttributeError(f"module 'uwopt' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)

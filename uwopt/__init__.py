"""uwopt: from an underwater imaging mission to a camera system that can be bought, with a proof.

`solve` finds the best system of a catalogue, `pareto` the trade-off between objectives, `evaluate` says what a
given system would do.
Heavy imports wait until they are needed.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from uwopt.api import evaluate as evaluate
    from uwopt.api import load_catalog as load_catalog
    from uwopt.api import solve as solve
    from uwopt.api_pareto import pareto as pareto
    from uwopt.front_result import FrontResult as FrontResult
    from uwopt.mission import Mission as Mission
    from uwopt.mission import load_mission as load_mission
    from uwopt.objectives.own import OwnObjective as OwnObjective
    from uwopt.result import Result as Result
    from uwopt.system import System as System
    from uwopt.system import load_system as load_system

__version__ = "0.1.0"

_WHERE = {
    "solve": "uwopt.api",
    "evaluate": "uwopt.api",
    "load_catalog": "uwopt.api",
    "Mission": "uwopt.mission",
    "load_mission": "uwopt.mission",
    "System": "uwopt.system",
    "load_system": "uwopt.system",
    "Result": "uwopt.result",
    "pareto": "uwopt.api_pareto",
    "FrontResult": "uwopt.front_result",
    "OwnObjective": "uwopt.objectives.own",
}
__all__ = ["__version__", *_WHERE]


def __getattr__(name: str) -> Any:
    if name in _WHERE:
        return getattr(import_module(_WHERE[name]), name)
    raise AttributeError(f"module 'uwopt' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)

"""Systems side by side in one mission: what `compare` returns."""

from __future__ import annotations

from dataclasses import dataclass

from uwopt.results.design import Design
from uwopt.results.result import Result


@dataclass(frozen=True)
class SideBySide:
    """One system of a comparison; `result` of the recommended one is that of the search, where something fits."""

    name: str
    result: Result

    @property
    def design(self) -> Design:
        """The system's parts, settings, figures and margins; of the recommended one as it would be set."""
        assert self.result.best is not None
        return self.result.best.as_set

    @property
    def recommended(self) -> bool:
        """Whether it is what the search recommends."""
        return self.result.command == "solve"


@dataclass(frozen=True)
class Comparison:
    """Systems in one mission; `nothing_fits` where a recommendation was asked for and there is none.

    `cut_short`: the search ended before it had found one. `gave_way`: what of good practice is held of none of them,
    for nothing keeps all of it.
    """

    systems: tuple[SideBySide, ...]
    nothing_fits: bool = False
    cut_short: bool = False
    gave_way: str = ""

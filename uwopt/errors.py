"""The tree of errors that a caller may meet.

UwoptError
  MissionError    a mission or system file is wrong: every fault, in one message
  CatalogError    a part, price or spectrum file is wrong, or a part is unknown
  RangeError      a number lies outside what a formula or table covers
  SolverError     a solver could not do its work (infeasible is a result, not an error)
  SchedulerError  a cluster cannot be reached, or its workers are another program
  OutputError     a result cannot be written where it was asked for
  ResultError     a result file cannot be read: none, cut off, of another version, or changed by hand
"""

from __future__ import annotations

from collections.abc import Sequence


class UwoptError(Exception):
    """Anything uwopt reports to a user; the message says where, what, what is allowed, and a way out."""


class FaultsError(UwoptError):
    """Several faults of one input, collected and raised once."""

    def __init__(self, faults: Sequence[str] | str):
        self.faults = [faults] if isinstance(faults, str) else list(faults)
        super().__init__("\n".join(self.faults))


class MissionError(FaultsError):
    """A mission or system file is wrong."""


class CatalogError(FaultsError):
    """A part, price or spectrum file is wrong, or a part is unknown."""


class RangeError(UwoptError):
    """A number lies outside what a formula or table covers."""


class SolverError(UwoptError):
    """A solver could not do its work."""


class SchedulerError(UwoptError):
    """A cluster cannot be used."""


class OutputError(UwoptError):
    """A result cannot be written where it was asked for."""


class ResultError(FaultsError):
    """A result file cannot be read."""

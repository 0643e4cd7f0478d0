"""Where every combination went, and what a search found."""

from __future__ import annotations

from dataclasses import dataclass, field

from uwopt.solvers.exact.imagers import IMAGER_RULES, Imagers
from uwopt.solvers.exact.light_tables import FieldTables
from uwopt.solvers.exact.node_bounds import NODE_RULES
from uwopt.solvers.exact.ranking import Found

RULES = (*IMAGER_RULES, *(rule for rule in NODE_RULES if rule not in IMAGER_RULES))
NOT_REACHED = "not_reached"


@dataclass
class Account:
    """Where every combination went: evaluated, or discarded by the first rule that does."""

    total: int = 0
    evaluated: int = 0
    discarded: dict[str, int] = field(default_factory=lambda: dict.fromkeys(RULES, 0))

    def charge(self, rule: str, count: int) -> None:
        """So many more that a rule discards; fewer where the count is below 0."""
        self.discarded[rule] = self.discarded.get(rule, 0) + int(count)

    def snapshot(self) -> Account:
        """The account as it is now, to be restored when what follows is cut short."""
        return Account(self.total, self.evaluated, dict(self.discarded))

    def restore(self, snapshot: Account) -> None:
        """As it was: what was counted since counts no more."""
        self.total, self.evaluated, self.discarded = snapshot.total, snapshot.evaluated, dict(snapshot.discarded)

    def leave_the_rest(self) -> None:
        """Count all that is not accounted for as not reached."""
        self.discarded.pop(NOT_REACHED, None)
        self.charge(NOT_REACHED, self.waiting)

    @property
    def waiting(self) -> int:
        """How many are not accounted for yet."""
        return self.total - self.evaluated - sum(self.discarded.values())

    def adds_up(self) -> bool:
        """Whether every combination is accounted for once."""
        return self.total == self.evaluated + sum(self.discarded.values())


@dataclass
class Outcome:
    """What a search found and how far its proof reaches."""

    best: list[Found]
    account: Account
    lower_bound: float
    complete: bool
    imagers: Imagers
    tables: FieldTables
    timing_s: dict[str, float]
    interrupted: bool = False

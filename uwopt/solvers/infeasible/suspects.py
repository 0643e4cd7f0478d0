"""Requirements that likely stand in the way: those by whose rules the last designs of a search fall."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace

from uwopt.solvers.exact.account import RULES, Account, Outcome
from uwopt.solvers.infeasible.freed_rules import LATE_RULES, SETTINGS

MOST, MOST_SUSPECTS = 2, 3  # of one search, and of all: what more rules speak of is asked in its turn
ASKED_BY = {"light": "min_snr", SETTINGS: "min_snr"}  # what a rule of another name holds


def of_lamps(outcome: Outcome) -> Account:
    """The account of a search but for what its imagers lost by themselves: a camera beyond the budget is no last fall.

    Of a large catalogue, of which no list of imagers is left, and where none was left to lamps, all of it.
    """
    account, tally = outcome.account, outcome.imagers.tally.discarded
    imagers = len(outcome.imagers) + sum(tally.values())
    if account.total == 0 or not tally or account.total % imagers:
        return account
    each, lost = account.total // imagers, account.discarded
    own = {rule: lost[rule] - each * tally.get(rule, 0) for rule in LATE_RULES if rule in lost}
    return replace(account, discarded={**lost, **own}) if any(own.values()) else account


def suspects_of(account: Account, names: Collection[str]) -> list[str]:
    """Of these requirements those that are likeliest in the way, the likeliest first.

    What passes all else falls last: by rules that know of lamps, the one that discards most first; else what no rule
    discards has no settings, mostly for want of light; else by the last rules of imagers.
    """
    lost = [rule for rule in RULES if account.discarded.get(rule, 0) > 0]
    late = sorted((rule for rule in lost if rule in LATE_RULES), key=lambda rule: -account.discarded[rule])
    first = [*late, *([SETTINGS] if account.evaluated else []), *([] if late or account.evaluated else lost[::-1])]
    return asked_by(first, names)[:MOST]


def asked_by(rules: Iterable[str], names: Collection[str]) -> list[str]:
    """The requirements that these rules hold, of those with such names."""
    return [name for name in dict.fromkeys(ASKED_BY.get(rule, rule) for rule in rules) if name in names]

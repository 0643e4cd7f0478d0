"""Requirements that contradict each other: an irreducible set, by leaving out several at once, then one after another.

Nothing fits where the set alone is asked (beside what no mission can leave out: parts that go together, focus,
physics), and something fits once any one of it is left out. A requirement whose loss alone lets something through is in
every such set.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

Fits = Callable[[Collection[str]], bool | None]  # without these requirements; None: not known


@dataclass(frozen=True)
class Contradiction:
    """Requirements with which alone nothing fits; without a name where that is not known of any but all."""

    names: tuple[str, ...] = ()
    is_least: bool = False  # whether something fits once any one of them is left out


def contradiction(
    names: Sequence[str], in_every_set: Collection[str], fits: Fits, at_once: Collection[str] = ()
) -> Contradiction:
    """A set of requirements that contradict each other, irreducible where every question finds its answer.

    Parameters
    ----------
    names : of all requirements, those first that are best left out first
    in_every_set : those whose loss alone lets something through
    fits : whether something fits without some
    at_once : those of which it takes as little to leave out all as to leave out one
    """
    needed = [name for name in names if name in in_every_set]
    left_out, kept, sure = list[str](), list[str](), True
    others = [name for name in names if name not in in_every_set]
    waiting = [[name] for name in others if name not in at_once][::-1]
    waiting.append([name for name in others if name in at_once])  # first
    while waiting:
        some = waiting.pop()
        known = fits([*left_out, *some]) if some else None
        if known is False:  # the others contradict each other without these
            left_out += some
        elif len(some) > 1:
            middle = len(some) // 2
            waiting += [some[middle:], some[:middle]]
        elif some:
            kept, sure = [*kept, *some], sure and known is True
    told = tuple(name for name in names if name in needed or name in kept)
    if not left_out and not sure:
        return Contradiction()
    return Contradiction(told, sure)

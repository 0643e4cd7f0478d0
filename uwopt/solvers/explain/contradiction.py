"""Requirements that contradict each other: an irreducible set, by leaving out one after another.

Nothing fits where the set alone is asked (beside what no mission can leave out: parts that go together, focus,
physics), and something fits once any one of it is left out. A requirement whose loss alone lets something through is in
every such set.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

Fits = Callable[[Collection[str]], bool | None]  # without these requirements; None: not known


def contradiction(names: Sequence[str], in_every_set: Collection[str], fits: Fits) -> list[str] | None:
    """An irreducible set of requirements that contradict each other; None where that is not known.

    Parameters
    ----------
    names : of all requirements, those first that are best left out first
    in_every_set : those whose loss alone lets something through
    fits : whether something fits without some
    """
    needed = [name for name in names if name in in_every_set]
    others = [name for name in names if name not in in_every_set]
    left_out: list[str] = []
    known = fits(others) if others and needed else None
    if known is False:  # they contradict each other by themselves
        return needed
    for name in others:
        known = fits([*left_out, name])
        if known is None:
            return None
        if known:
            needed.append(name)
        else:
            left_out.append(name)
    return needed

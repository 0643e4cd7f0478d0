"""Which kinds of part are to be made, against every way in which parts of some kinds may let something fit."""

from __future__ import annotations

from collections.abc import Collection
from itertools import chain, combinations

from uwopt.solvers.recommend import fewest_made

KINDS = ("housing", "port", "light")
SETS = [frozenset(some) for some in chain.from_iterable(combinations(KINDS, size) for size in range(4))]
#: From the order that is signed most readily to the one that is last: a lamp is made only where nothing else helps.
LIKED = [
    {"housing"}, {"port"}, {"housing", "port"}, {"light"}, {"light", "housing"}, {"light", "port"}, set(KINDS),
]  # fmt: skip


def test_the_kinds_are_the_most_liked_of_all_that_fit() -> None:
    checked = 0
    for bits in range(2 ** len(SETS)):
        enough = [one for place, one in enumerate(SETS) if bits >> place & 1 and one]

        def fits(kinds: Collection[str], enough: list[frozenset[str]] = enough) -> bool:
            return any(one <= set(kinds) for one in enough)

        if enough:
            expected = next(kinds for kinds in LIKED if fits(kinds))
            assert set(fewest_made(fits)) == expected
            checked += 1
    assert checked == 254

"""Which kinds of part are to be made where nothing that is sold does: as few as serve as well as all of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import get_args

from uwopt.catalog.records import Kind
from uwopt.mission.keys import MadeKind

#: The worst first: a lamp has to be developed, a dome is ground to order, a tube is turned in any workshop.
TO_BE_MADE: tuple[Kind, ...] = get_args(MadeKind)


def fewest_made(serves: Callable[[tuple[Kind, ...]], bool]) -> tuple[Kind, ...]:
    """The kinds of part to be made, all of which serve: each is left out in turn if the others serve still.

    serves : whether parts to be made of these kinds and no others do; False where that is not known
    """
    made = TO_BE_MADE
    for kind in TO_BE_MADE:
        fewer = tuple(other for other in made if other != kind)
        if fewer and serves(fewer):  # of no kind at all nothing fits
            made = fewer
    return made

"""Which kinds of part are to be made where nothing that is sold does: as few as let something fit."""

from __future__ import annotations

from collections.abc import Callable

from uwopt.catalog.records import Kind

#: Kinds of which there are classes of parts to be made, the worst first: a lamp has to be developed, a dome is ground
#: and polished to order, a tube is turned in any workshop.
TO_BE_MADE: tuple[Kind, ...] = ("light", "port", "housing")


def fewest_made(fits: Callable[[tuple[Kind, ...]], bool]) -> tuple[Kind, ...]:
    """The kinds of part to be made, all of which let something fit: each is left out in turn if something fits still.

    fits : whether anything fits with parts to be made of these kinds and no others; False where that is not known
    """
    made = TO_BE_MADE
    for kind in TO_BE_MADE:
        fewer = tuple(other for other in made if other != kind)
        if fewer and fits(fewer):  # of no kind at all nothing does
            made = fewer
    return made

"""Parts by kind and id: of a design, of several, and a selection of no others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from uwopt.catalog.choose import Selection
from uwopt.catalog.records import OF_A_DESIGN, Kind
from uwopt.forward.problem import Problem
from uwopt.solvers.exact.ranking import Found

PartIds = Mapping[Kind, frozenset[str]]


def ids_of(problem: Problem, found: Found) -> PartIds:
    """Ids of a design's parts by kind as the catalogue has them, complete cameras whole."""
    own = problem.parts.of(found)
    ids: dict[Kind, frozenset[str]] = {kind: frozenset({own[kind].id}) for kind in OF_A_DESIGN}
    if whole := own["port"].complete:
        return {"complete": frozenset({whole}), "light": ids["light"]}
    return ids | {"housing": frozenset() if own["port"].housing is None else frozenset({own["port"].housing.id})}


def joined_ids(several: list[PartIds]) -> PartIds:
    """All ids of several designs by kind."""
    kinds = {kind for ids in several for kind in ids}
    return {kind: frozenset[str]().union(*(ids.get(kind, frozenset()) for ids in several)) for kind in kinds}


def only(selection: Selection, ids: PartIds) -> Selection:
    """A selection with no other parts than these."""
    indices = {
        kind: tuple(i for i in chosen if selection.catalog.parts(kind)[i].id in ids.get(kind, ()))
        for kind, chosen in selection.indices.items()
    }
    return replace(selection, indices=indices)

"""The catalogue in memory: all parts of one load, and why some of them cannot be searched."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from uwopt.catalog.records import KINDS, Camera, Complete, Housing, Kind, Lens, Light, Part, Port
from uwopt.documents.faults import plain_name
from uwopt.errors import CatalogError


@dataclass(frozen=True, slots=True)
class Exclusion:
    """One part that a rule discards, and the reason in words."""

    part_id: str
    kind: Kind
    rule: str
    reason: str


@dataclass(frozen=True)
class Catalog:
    """All parts, searchable or not; `exclusions` tells which are not, and why."""

    cameras: tuple[Camera, ...] = ()
    lenses: tuple[Lens, ...] = ()
    ports: tuple[Port, ...] = ()
    lights: tuple[Light, ...] = ()
    exclusions: tuple[Exclusion, ...] = ()
    files: tuple[str, ...] = field(default=())  # users' files that took part
    housings: tuple[Housing, ...] = ()
    completes: tuple[Complete, ...] = ()

    def parts(self, kind: Kind) -> tuple[Part, ...]:
        """All parts of one kind, in the order in which indices count."""
        by_kind: Mapping[Kind, tuple[Part, ...]] = {
            "camera": self.cameras,
            "lens": self.lenses,
            "port": self.ports,
            "light": self.lights,
            "housing": self.housings,
            "complete": self.completes,
        }
        return by_kind[kind]

    def part(self, part_id: str, kind: Kind | None = None) -> Part:
        """The part of that id (case ignored, `-` equals `_`), of that kind if one is asked for."""
        found = self._by_key.get(plain_name(part_id))
        if found is None:
            raise CatalogError(unknown_part(part_id, self.ids(kind)))
        found_kind, part = found
        if kind is not None and found_kind != kind:
            raise CatalogError(f"{part.id} is a {found_kind}, not a {kind}.")
        return part

    def ids(self, kind: Kind | None = None) -> list[str]:
        """Ids of all parts, or of one kind."""
        return [part.id for k in KINDS if kind in (None, k) for part in self.parts(k)]

    def exclusions_of(self, part_id: str) -> tuple[Exclusion, ...]:
        """Why a part cannot be searched; empty when it can."""
        return tuple(self._excluded.get(plain_name(part_id), ()))

    @cached_property
    def _excluded(self) -> dict[str, list[Exclusion]]:
        by_key: dict[str, list[Exclusion]] = {}
        for exclusion in self.exclusions:
            by_key.setdefault(plain_name(exclusion.part_id), []).append(exclusion)
        return by_key

    @cached_property
    def _by_key(self) -> dict[str, tuple[Kind, Part]]:
        pieces: tuple[Kind, ...] = ("camera", "lens", "port")
        of_completes = {
            plain_name(part.id): (kind, part)
            for complete in self.completes
            for kind, part in zip(pieces, complete.pieces, strict=True)
        }
        return of_completes | {plain_name(part.id): (kind, part) for kind in KINDS for part in self.parts(kind)}


MOST_NEAR = 3  # names that are told


def near_names(name: str, known: Iterable[str]) -> list[str]:
    """Known names that resemble or contain a name, best first."""
    by_key = {plain_name(other): other for other in known if other}
    key = plain_name(name)
    close = difflib.get_close_matches(key, by_key, n=MOST_NEAR, cutoff=0.6)
    containing = [other for other in by_key if key and key in other]
    return [by_key[other] for other in dict.fromkeys((*close, *containing))][:MOST_NEAR]


def unknown_part(part_id: str, known: Iterable[str]) -> str:
    """The message for an id that no part has."""
    near = near_names(part_id, known)
    hint = f"did you mean {', '.join(near)}?" if near else "`uwopt catalog list` prints all ids."
    return f"part {part_id!r} is not in the catalogue; {hint}"

"""Which parts a mission lets into the search, and which rule keeps each other part out.

The rules stand in one order, and a part is counted at the first rule that discards it, so the counts
add up to the parts loaded.
"""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Literal, TypeAlias, TypeVar

from uwopt.catalog.catalogue import Catalog, Exclusion, near_names, unknown_part
from uwopt.catalog.estimates import required_class
from uwopt.catalog.interfaces import does_reach
from uwopt.catalog.records import (
    KINDS,
    Camera,
    Complete,
    Housing,
    Kind,
    Lens,
    Light,
    Part,
    Port,
    Quantity,
    exact,
)
from uwopt.documents.faults import plain_name
from uwopt.errors import CatalogError

RULES = (
    "form",
    "availability",
    "purpose",
    "vital facts",
    "pattern",
    "exclude",
    "port mount",
    "verified",
    "colour",
    "shutter",
    "interface",
    "lamp supply",
    "run time",
    "trigger",
    "rated time",
    "depth rating",
    "setting",
    "generic",
)

PATTERN_KEYS: dict[Kind, str] = {
    "camera": "cameras", "lens": "lenses", "port": "ports", "light": "lights", "housing": "housings",
    "complete": "complete_cameras",
}  # fmt: skip
SOURCED = ("published", "measured", "derived", "quoted", "user")
GLOB_SIGNS = "*?["
SUPPLIES = {"external": "takes its power from outside", "battery": "has its own battery", "unknown": "supply unknown"}


#: Parts to be made that may be used: of all kinds, of none, of these, or of those of which nothing sold is left.
ToBeMade: TypeAlias = Literal["fallback", "allow", "never"] | tuple[Kind, ...]

PartT = TypeVar("PartT", bound=Part)


@dataclass(frozen=True)
class Choice:
    """The `catalog` section of a mission; any object or mapping with these names also does."""

    cameras: Sequence[str] = ()
    lenses: Sequence[str] = ()
    ports: Sequence[str] = ()
    lights: Sequence[str] = ()
    housings: Sequence[str] = ()
    exclude: Sequence[str] = ()
    owned: Sequence[Any] = ()  # {id, quantity}
    generic: ToBeMade = "fallback"
    verified: Sequence[str] = ()
    accept_unrated: Sequence[str] = ()
    port_mounts: Sequence[str] = ()
    interfaces: Sequence[str] = ()
    availability: Literal["any", "known"] = "any"
    complete: Literal["none", "also", "only"] = "none"
    complete_cameras: Sequence[str] = ()


@dataclass(frozen=True)
class Selection:
    """What may be searched: indices into the catalogue's tuples, and the account of the rest."""

    catalog: Catalog
    indices: dict[Kind, tuple[int, ...]]
    excluded: tuple[Exclusion, ...]
    counts: dict[Kind, dict[str, int]]  # rule -> parts discarded, in rule order
    warnings: tuple[str, ...]
    owned: dict[str, int]  # id -> pieces that cost nothing
    generic: ToBeMade = "fallback"  # which parts to be made were let in

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """The cameras to search; owned ones cost nothing."""
        return tuple(self.catalog.cameras[i] for i in self.indices["camera"])

    @property
    def lenses(self) -> tuple[Lens, ...]:
        """The lenses to search."""
        return tuple(self.catalog.lenses[i] for i in self.indices["lens"])

    @property
    def ports(self) -> tuple[Port, ...]:
        """The ports to search."""
        return tuple(self.catalog.ports[i] for i in self.indices["port"])

    @property
    def lights(self) -> tuple[Light, ...]:
        """The lights to search; owned ones keep their price, `owned` says how many are free."""
        return tuple(self.catalog.lights[i] for i in self.indices["light"])

    @property
    def housings(self) -> tuple[Housing, ...]:
        """The housings to search; owned ones cost nothing."""
        return tuple(self.catalog.housings[i] for i in self.indices["housing"])

    @property
    def completes(self) -> tuple[Complete, ...]:
        """The complete cameras to search; owned ones cost nothing."""
        return tuple(self.catalog.completes[i] for i in self.indices["complete"])


def select(
    catalog: Catalog,
    choice: Any = None,
    *,
    required_depth_m: float | None = None,
    colour: str = "any",
    shutter: str = "any",
    lamp_supply: str = "any",
    duration_h: float | None = None,
    camera_count: int = 1,
    cable_m: float | None = None,
    unsettable: Callable[[Part], str] = lambda part: "",
) -> Selection:
    """Apply a mission's choice to a catalogue.

    An owned camera, lens, port, housing or complete camera costs nothing if there are `camera_count` of it; owned
    lights keep their price in the record, because only the first `owned[id]` of them are free (`money.cost_of`).
    `unsettable` says why a part cannot be set as is wanted; "" where it can.
    """
    wish = _as_choice(choice)
    owned = _owned_quantities(wish.owned)
    _require_known((*owned, *wish.accept_unrated), catalog)
    excluded: list[Exclusion] = []
    indices: dict[Kind, tuple[int, ...]] = {}
    owned_keys = frozenset(plain_name(name) for name in owned)
    standing = _by_part(catalog.exclusions)
    filters = _Filters(
        wish, owned_keys, required_depth_m, colour, shutter, lamp_supply, duration_h, cable_m, standing, unsettable
    )  # fmt: skip
    for kind in KINDS:
        kept = []
        for index, part in enumerate(catalog.parts(kind)):
            verdict = filters.first_verdict(kind, part)
            if verdict is None:
                kept.append(index)
            else:
                excluded.append(Exclusion(part.id, kind, *verdict))
        kept, fallen = _without_needless_generic(kind, catalog.parts(kind), kept, wish.generic)
        excluded += fallen
        indices[kind] = tuple(kept)
    counts = {kind: _counts(kind, excluded) for kind in KINDS}
    priced = _with_owned_prices(catalog, owned, camera_count)
    warnings = tuple(_pattern_warnings(catalog, wish))
    return Selection(priced, indices, tuple(excluded), counts, warnings, owned, wish.generic)


def matches(pattern: str, part: Part) -> bool:
    """Whether a pattern names a part: a glob or a plain piece of its id or manufacturer."""
    wanted = plain_name(pattern)
    names = (plain_name(part.id), plain_name(part.manufacturer))
    if any(sign in wanted for sign in GLOB_SIGNS):
        return any(fnmatch.fnmatchcase(name, wanted) for name in names)
    return bool(wanted) and any(wanted in name for name in names)


def is_sourced(part: Part, field_name: str) -> bool:
    """Whether a field's value rests on a source rather than on a class or on nothing."""
    status_name = {"bit_depth": "bit_depth_status", "image_circle_mm": "image_circle_status"}.get(field_name)
    value = getattr(part, field_name)
    if value is None or value == "" or value == ():
        return False
    if status_name is not None:
        return getattr(part, status_name) in SOURCED
    return value.status in SOURCED if isinstance(value, Quantity) else True


@dataclass(frozen=True)
class _Filters:
    """The rules for single parts, ready to be asked part by part."""

    wish: Choice
    owned_keys: frozenset[str]
    required_depth_m: float | None
    colour: str
    shutter: str
    lamp_supply: str
    duration_h: float | None
    cable_m: float | None  # that the interface of a camera must reach
    standing: Mapping[str, Sequence[Exclusion]]  # by part id, in rule order
    unsettable: Callable[[Part], str]

    def first_verdict(self, kind: Kind, part: Part) -> tuple[str, str] | None:
        """Rule and reason of the first rule that discards a part; None when it may be searched."""
        if self.wish.complete == "none" and kind == "complete":
            return "form", "complete cameras are not asked for"
        if self.wish.complete == "only" and kind in ("camera", "lens", "port", "housing"):
            return "form", "only complete cameras are searched"
        patterns = getattr(self.wish, PATTERN_KEYS[kind])
        named = any(plain_name(pattern) == plain_name(part.id) for pattern in patterns)
        wanted = named or plain_name(part.id) in self.owned_keys
        if self.wish.availability == "known" and part.availability == "unknown" and not (wanted or part.generic):
            return "availability", "nobody says whether it is still sold"
        for exclusion in self.standing.get(part.id, ()):
            if exclusion.rule in ("availability", "purpose") and wanted:
                continue
            if exclusion.rule == "port mount":
                continue  # has its turn below
            return exclusion.rule, exclusion.reason
        if patterns and not any(matches(pattern, part) for pattern in patterns):
            return "pattern", f"not among {', '.join(patterns)}"
        for pattern in self.wish.exclude:
            if matches(pattern, part):
                return "exclude", f"excluded by {pattern!r}"
        return (
            (None if wanted else self._needs_housing(part))
            or self._unverified(part)
            or self._wrong_sensor(part)
            or self._wrong_supply(part, wanted)
            or self._rated_too_short(part)
            or self._too_shallow(part)
            or (("setting", why) if (why := self.unsettable(part)) else None)
        )

    def _needs_housing(self, part: Part) -> tuple[str, str] | None:
        """A port of a closed mount is no part of its own, unless the mission has what it is fastened to."""
        if not isinstance(part, Port) or plain_name(part.mount) in map(plain_name, self.wish.port_mounts):
            return None
        reasons = (found.reason for found in self.standing.get(part.id, ()) if found.rule == "port mount")
        return next((("port mount", reason) for reason in reasons), None)

    def _unverified(self, part: Part) -> tuple[str, str] | None:
        own = [part.own_camera, part.own_lens, part.own_port] if isinstance(part, Complete) else []
        for field_name in self.wish.verified:
            holder = next((one for one in (part, *own) if hasattr(one, field_name)), None)
            if holder is not None and not is_sourced(holder, field_name):
                return "verified", f"{field_name} has no source"
        return None

    def _wrong_sensor(self, part: Part) -> tuple[str, str] | None:
        on_its_own = isinstance(part, Complete) and part.storage_gb is not None
        part = part.own_camera if isinstance(part, Complete) else part
        if not isinstance(part, Camera):
            return None
        if self.colour not in ("any", part.colour):
            return "colour", f"{part.colour} sensor, {self.colour} is wanted"
        if self.shutter not in ("any", part.shutter):
            return "shutter", f"{part.shutter} shutter, {self.shutter} is wanted"
        if on_its_own:
            return None  # no computer takes its images
        if self.wish.interfaces and part.interface not in self.wish.interfaces:
            wanted = " or ".join(self.wish.interfaces)
            return "interface", f"interface {part.interface or 'unknown'}, {wanted} is wanted"
        if not does_reach(part.interface, self.cable_m):
            name = part.interface or "unknown"
            return "interface", f"interface {name} does not reach over {self.cable_m:g} m of cable"
        return None

    def _wrong_supply(self, part: Part, wanted: bool) -> tuple[str, str] | None:
        """What feeds and fires a lamp; one that is named by its id, or owned, may have either supply."""
        if isinstance(part, Complete):
            return self._runs_out(part, "")
        if not isinstance(part, Light):
            return None
        if self.lamp_supply not in ("any", part.supply) and not wanted:
            return "lamp supply", f"{SUPPLIES[part.supply]}, {self.lamp_supply} is wanted"
        if runs_out := self._runs_out(part, " at full", named=wanted):
            return runs_out
        if part.kind != "continuous" and part.trigger == "none":
            return "trigger", "nothing fires it with the camera"
        return None

    def _runs_out(self, part: Light | Complete, how: str, *, named: bool = False) -> tuple[str, str] | None:
        """Whether a battery of its own lasts as long as the mission.

        One of a lamp of which nobody says how long lasts as those that tell it do; who names the lamp knows better.
        """
        lasts_min, told = part.run_time_min, "lasts"
        burns = isinstance(part, Light) and (part.kind, part.supply) == ("continuous", "battery")
        if lasts_min is None and burns and not named:
            lasts_min, told = required_class("light-run-time-min", "own-battery").central, "is taken to last"
        needed_min = None if self.duration_h is None else 60.0 * self.duration_h
        if needed_min is None or lasts_min is None or lasts_min >= needed_min:
            return None
        return "run time", f"its battery {told} {lasts_min:g} min{how}, {needed_min:g} min are needed"

    def _rated_too_short(self, part: Part) -> tuple[str, str] | None:
        """Whether its depth rating is for shorter dives than the mission."""
        rated_h = part.rated_time_h if isinstance(part, Port | Housing) else None
        if self.duration_h is None or rated_h is None or rated_h >= self.duration_h:
            return None
        return "rated time", f"its depth rating holds for {rated_h:g} h, {self.duration_h:g} h are needed"

    def _too_shallow(self, part: Part) -> tuple[str, str] | None:
        if self.required_depth_m is None or not isinstance(part, Port | Light | Housing | Complete):
            return None
        if part.depth_rating_m is None:
            accepted = {plain_name(name) for name in self.wish.accept_unrated}
            if plain_name(part.id) in accepted:
                return None
            return "depth rating", f"depth rating unknown, {self.required_depth_m:g} m needed"
        if part.depth_rating_m < self.required_depth_m:
            return "depth rating", f"rated to {part.depth_rating_m:g} m, {self.required_depth_m:g} m needed"
        return None


def _by_part(exclusions: Iterable[Exclusion]) -> dict[str, list[Exclusion]]:
    grouped: dict[str, list[Exclusion]] = {}
    for exclusion in sorted(exclusions, key=lambda e: RULES.index(e.rule)):
        grouped.setdefault(exclusion.part_id, []).append(exclusion)
    return grouped


def _as_choice(choice: Any) -> Choice:
    if isinstance(choice, Choice):
        return choice
    names = [f.name for f in fields(Choice)]
    if isinstance(choice, Mapping):
        values = {name: choice.get(name) for name in names}
    else:
        values = {name: getattr(choice, name, None) for name in names}
    return Choice(**{name: value for name, value in values.items() if value is not None})


def _owned_quantities(owned: Iterable[Any]) -> dict[str, int]:
    quantities: dict[str, int] = {}
    quantity: Any
    for item in owned:
        if isinstance(item, str):
            part_id, quantity = item, 1
        elif isinstance(item, Mapping):
            part_id, quantity = item["id"], item.get("quantity")
        else:
            part_id, quantity = item.id, getattr(item, "quantity", None)
        quantities[part_id] = quantities.get(part_id, 0) + (1 if quantity is None else int(quantity))
    return {part_id: quantity for part_id, quantity in quantities.items() if quantity > 0}


def _require_known(part_ids: Iterable[str], catalog: Catalog) -> None:
    known = {plain_name(part_id) for part_id in catalog.ids()}
    faults = [unknown_part(name, catalog.ids()) for name in part_ids if plain_name(name) not in known]
    if faults:
        raise CatalogError(faults)


def _without_needless_generic(
    kind: Kind, parts: Sequence[Part], kept: list[int], rule: ToBeMade
) -> tuple[list[int], list[Exclusion]]:
    """Drop generic parts of kinds in which the mission wants none, or has real ones left (`fallback`)."""
    real = [index for index in kept if not parts[index].generic]
    wanted = kind in rule if isinstance(rule, tuple) else rule == "allow"
    if wanted or (rule == "fallback" and not real):
        return kept, []
    reason = f"{len(real)} real parts are left" if rule == "fallback" else "generic parts are not wanted"
    fallen = [Exclusion(parts[i].id, kind, "generic", reason) for i in kept if parts[i].generic]
    return real, fallen


def _counts(kind: Kind, excluded: Iterable[Exclusion]) -> dict[str, int]:
    rules = [exclusion.rule for exclusion in excluded if exclusion.kind == kind]
    return {rule: rules.count(rule) for rule in RULES if rule in rules}


def _with_owned_prices(catalog: Catalog, owned: Mapping[str, int], camera_count: int) -> Catalog:
    """Cameras, lenses, ports, housings, complete cameras at what is left to pay for each of `camera_count` of them."""
    counts = {catalog.part(name).id: quantity for name, quantity in owned.items()}

    def paid(part: PartT) -> PartT:
        have = min(counts.get(part.id, 0), camera_count)
        if have == 0 or part.price is None:
            return part
        if have == camera_count:
            return replace(part, price=exact(0.0, "user", "owned"))
        share = (camera_count - have) / camera_count
        value, low, high = (end * share for end in (part.price.value, part.price.low, part.price.high))
        source = f"{part.price.source}; {have} of {camera_count} owned"
        return replace(part, price=replace(part.price, value=value, low=low, high=high, source=source))

    if not counts:
        return catalog
    return replace(
        catalog,
        cameras=tuple(paid(part) for part in catalog.cameras),
        lenses=tuple(paid(part) for part in catalog.lenses),
        ports=tuple(paid(part) for part in catalog.ports),
        housings=tuple(paid(part) for part in catalog.housings),
        completes=tuple(paid(part) for part in catalog.completes),
    )


def _pattern_warnings(catalog: Catalog, wish: Choice) -> Iterable[str]:
    """Patterns that match no part, with near names."""
    for kind in KINDS:
        for pattern in getattr(wish, PATTERN_KEYS[kind]):
            yield from _warn_if_idle(pattern, catalog.parts(kind), f"catalog.{PATTERN_KEYS[kind]}", f" --kind {kind}")
    everything = [part for kind in KINDS for part in catalog.parts(kind)]
    for pattern in wish.exclude:
        yield from _warn_if_idle(pattern, everything, "catalog.exclude")
    mounts = {plain_name(port.mount): port.mount for port in catalog.ports if port.mount}
    for name in wish.port_mounts:
        if plain_name(name) not in mounts:
            near = near_names(name, mounts.values())
            hint = f"; near ones: {', '.join(near)}" if near else ""
            yield f"catalog.port_mounts: no port has the mount {name!r}{hint}"


def _warn_if_idle(pattern: str, parts: Sequence[Part], key: str, narrowed: str = "") -> Iterable[str]:
    if any(matches(pattern, part) for part in parts):
        return
    near = near_names(pattern, (name for part in parts for name in (part.manufacturer, part.id)))
    hint = f"; near ones: {', '.join(near)}" if near else f"; uwopt catalog list{narrowed} prints all ids"
    yield f"{key}: pattern {pattern!r} matches no part{hint}"

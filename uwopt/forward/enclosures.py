"""Ports built into housings, and which cameras with their lenses fit inside: enclosures take the place of ports.

Ports that differ by their housing alone share their optics, so that views and light are worked out once for all.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.arrays import Array
from uwopt.catalog.choose import matches
from uwopt.catalog.compatibility import canonical_mount
from uwopt.catalog.estimates import ClassEstimate, required_class
from uwopt.catalog.mounts import is_free
from uwopt.catalog.parts.housing import ANY_PORT
from uwopt.catalog.readers.read_lens import circle_class
from uwopt.catalog.records import Camera, Housing, Lens, Port, Quantity
from uwopt.forward.columns import groups_alike
from uwopt.forward.once import once_each
from uwopt.forward.part_columns import Cameras, Lenses, Ports
from uwopt.forward.part_rows import quantity_ends
from uwopt.model.enclosure import Bodies, dome_needed_m, mouth_needed_m, sphere_needed_m, tube_needed_m
from uwopt.model.path_table import product
from uwopt.tolerances import ROUND

Mask = NDArray[np.bool_]
BODY = ("body_width_mm", "body_height_mm", "body_length_mm", "plug_mm")


def enclosed(ports: Sequence[Port], housings: Sequence[Housing]) -> tuple[Port, ...]:
    """Every port in every housing that takes it, port by port; a port of a closed mount has its own and stays bare."""
    made: list[Port] = []
    for port in ports:
        made += [both for one in housings if (both := built(port, one))] if is_free(port.mount) else [port]
    return tuple(made)


@once_each
def built(port: Port, housing: Housing) -> Port | None:
    """A port in a housing; None where it does not fit on it."""
    return replace(port, housing=housing) if takes(housing, port) else None


def takes(housing: Housing, port: Port) -> bool:
    """Whether a port fits on a housing: it is named there, or its end is made for any port no wider than itself."""
    return missing_width_mm(housing, port) <= 0.0


def missing_width_mm(housing: Housing, port: Port) -> float:
    """How much wider a port is than the end of a housing, not above 0 where it fits; inf where it goes on none."""
    named = [pattern for pattern in housing.ports if pattern != ANY_PORT]
    if any(matches(pattern, port) for pattern in named):
        return 0.0
    if ANY_PORT not in housing.ports:
        return math.inf
    widest = housing.outer_diameter_mm
    return 0.0 if widest is None or port.width_mm is None else port.width_mm - widest.value


@once_each
def camera_with_size(camera: Camera) -> Camera:
    """A camera with the size of its body, that of its interface's class where it does not say."""
    if camera.inline or camera.complete:
        return camera

    def of_class(name: str) -> Quantity:
        key = f"camera-{name.replace('_', '-')}"
        return required_class(key, f"body-{camera.interface}", "body-any").quantity()

    sizes: dict[str, Any] = {name: getattr(camera, name) or of_class(name) for name in BODY}
    return replace(camera, **sizes)


@once_each
def lens_with_size(lens: Lens) -> Lens:
    """A lens with length, width and the place of its entrance pupil, those of its class where it does not say."""
    if lens.complete or (lens.inline and lens.length_mm is None):
        return lens
    length = lens.length_mm or _of_class("lens-length-mm", lens).quantity()
    share = required_class("lens-pupil-over-length", "body-any")
    return replace(
        lens,
        length_mm=length,
        diameter_mm=lens.diameter_mm or _of_class("lens-diameter-mm", lens).quantity(),
        pupil_mm=lens.pupil_mm or share.quantity(length.value),
    )


def _of_class(prefix: str, lens: Lens) -> ClassEstimate:
    board = {canonical_mount(mount) for mount in lens.mounts} == {"S"}
    return required_class(prefix, "body-s-mount" if board else f"body-{circle_class(lens.image_circle_mm)}", "body-any")


def bodies_of(cameras: Cameras, lenses: Lenses, spacers_m: Array | float, *, at_most: bool = False) -> Bodies:
    """What rows of cameras and lenses take up, with rings of these lengths between them; by high ends where asked."""
    if at_most:
        (width, height, deep, plug), (wide, long) = cameras.most_body_m.T, lenses.most_body_m.T
        nearest, farthest = lenses.pupil_ends_m.T
        return Bodies(width, height, deep, plug, wide, long + spacers_m, farthest, nearest)
    return Bodies(
        cameras.body_width_m, cameras.body_height_m, cameras.body_length_m, cameras.plug_m, lenses.diameter_m,
        lenses.length_m + spacers_m, lenses.pupil_m,
    )  # fmt: skip


def bodies_in(cameras: Cameras, lenses: Lenses, spacers_m: Array | float, port: Ports) -> Bodies:
    """What one enclosure must have room for: in a housing to be made, the high ends of what is estimated.

    It is cut to measure before anybody holds camera, plug and lens in hand; a housing off the shelf can be tried. Nor
    is it known where the entrance pupil lies: a tube is long enough for its low end, a dome wide enough for its high.
    """
    return bodies_of(cameras, lenses, spacers_m, at_most=bool(port.to_be_made[0]))


def room_needed_m(bodies: Bodies, port: Ports, tan_corner: Array | float = 0.0) -> dict[str, tuple[Array, Array]]:
    """What camera and lens need in one enclosure and what it has, (n_pairs,) each, by the name of the requirement."""
    room = room_m(port)
    return {name: (needed, room[name]) for name, needed in needed_m(bodies, port, tan_corner).items()}


def needed_m(bodies: Bodies, port: Ports, tan_corner: Array | float = 0.0) -> dict[str, Array]:
    """What camera and lens need behind a port in one housing, (n_pairs,), by the name of the requirement."""
    if port.is_sphere[0]:
        return {"housing_diameter_mm": sphere_needed_m(bodies)}
    width, length = tube_needed_m(bodies, is_dome=port.is_dome, gap_m=port.rim_gap_m)
    needed = {"housing_diameter_mm": width, "housing_length_mm": length}
    if port.rim_gap_m[0] > 0.0:
        needed["tube_mouth_mm"] = np.broadcast_to(mouth_needed_m(tan_corner, gap_m=port.rim_gap_m), width.shape)
    return needed | ({"dome_radius_mm": dome_needed_m(bodies)} if port.is_dome[0] else {})


def room_m(ports: Ports) -> dict[str, Array]:
    """What housings with their ports have of it, (n_ports,)."""
    return {
        "housing_diameter_mm": ports.room_diameter_m, "housing_length_mm": ports.room_length_m,
        "tube_mouth_mm": ports.room_diameter_m,
        "dome_radius_mm": ports.outer_radius_m - ports.thickness_m,
    }  # fmt: skip


def tight_at_worst(camera: Camera, lens: Lens, spacer_m: float, port: Ports) -> dict[str, tuple[float, float]]:
    """Needed and had [m], by requirement, of what is not enough where estimated sizes are at their high ends."""
    sizes = sizes_at_worst(camera, lens, spacer_m, port)
    return {name: (needed, had) for name, (needed, had) in sizes.items() if not needed <= had * ROUND}


def sizes_at_worst(camera: Camera, lens: Lens, spacer_m: float, port: Ports) -> dict[str, tuple[float, float]]:
    """Needed and had [m], by requirement, where estimated sizes are at their high ends."""

    def high(part: Camera | Lens, name: str) -> Array:
        value: Quantity | None = getattr(part, name)
        return np.array([0.0 if value is None else value.high * 1e-3])

    length = high(lens, "length_mm")
    nearest, farthest = 1e-3 * np.array(quantity_ends(lens.pupil_mm))[:, None]
    width, height, deep, plug = (high(camera, name) for name in BODY)
    worst = Bodies(width, height, deep, plug, high(lens, "diameter_mm"), length + spacer_m, farthest, nearest)
    return {name: (float(n[0]), float(r[0])) for name, (n, r) in room_needed_m(worst, port).items()}


def fits_inside(
    cameras: Cameras, lenses: Lenses, spacers_m: Array | float, ports: Ports, tan_corner: Array | float = 0.0
) -> Mask:
    """Whether each pair of camera and lens fits into each enclosure, (n_pairs, n_ports); all into bare ports.

    tan_corner : (n_pairs,), of the widest view behind these ports, which a tube's mouth must not cut
    """
    fits = np.ones((len(cameras.price), len(ports.price)), bool)
    for _, alike, needed, room in sizes_m(cameras, lenses, spacers_m, ports, tan_corner):
        fits[:, alike] &= needed[:, None] <= room * ROUND
    return fits


def sizes_m(
    cameras: Cameras, lenses: Lenses, spacers_m: Array | float, ports: Ports, tan_corner: Array | float = 0.0
) -> Iterator[tuple[str, list[int], Array, Array]]:
    """Sizes that count in enclosures: name, places of those where as much is needed, that, (n_pairs,), and their room.

    Bare ports have no size that counts.
    """
    kinds: dict[tuple[float, ...], list[int]] = {}  # what is needed differs by shape and port, not by housing
    for p in np.flatnonzero(ports.roomy).tolist():
        kind = (ports.is_sphere[p], ports.is_dome[p], ports.rim_gap_m[p], ports.to_be_made[p])
        kinds.setdefault(kind, []).append(p)
    for alike in kinds.values():
        bodies = bodies_in(cameras, lenses, spacers_m, ports.take(np.array(alike[:1])))
        room = room_m(ports.take(np.array(alike)))
        for name, needed in needed_m(bodies, ports.take(np.array(alike[:1])), tan_corner).items():
            yield name, alike, needed, room[name]


def housing_size_mm(ports: Ports) -> Array:
    """The largest outer measure of housings with their ports."""
    return np.asarray(np.maximum(ports.outer_length_m, ports.outer_diameter_m) * 1e3)


def housing_diameter_mm(ports: Ports) -> Array:
    """The outer diameter of housings with their ports: what a borehole or a hatch has to let through."""
    return np.asarray(ports.outer_diameter_m * 1e3)


def mass_in_water_kg(
    camera_count: int, cameras: Cameras, lenses: Lenses, rings_kg: Array | float, ports: Ports
) -> Array:
    """Mass in water of all cameras in their housings, with rings behind lenses, lamps not counted, (n, n_ports)."""
    inside = (cameras.mass_kg + lenses.mass_kg + rings_kg)[:, None]
    return np.asarray(camera_count * (inside + ports.mass_kg - ports.displaced_kg))


def beaten(fits: Array, worth: Sequence[NDArray[np.float64]], names: Sequence[str]) -> Mask:
    """Whether another housing, that fits as well, is no worse in anything: (n_pairs, n_ports).

    fits : (n_pairs, n_ports), of one port's optics
    worth : columns of which less is better, (n_ports,)
    names : of the housings; those of one name are variants of one another and do not compete
    """
    n = len(names)
    no_worse, better = np.ones((n, n), bool), np.zeros((n, n), bool)
    for column in worth:
        no_worse &= column[:, None] <= column[None, :]
        better |= column[:, None] < column[None, :]
    first = np.arange(n)[:, None] < np.arange(n)[None, :]
    rival = np.array(names, object)[:, None] != np.array(names, object)[None, :]
    beats = no_worse & (better | first) & rival
    bits = np.packbits(fits, axis=1)
    words = np.pad(bits, ((0, 0), (0, -bits.shape[1] % 8))).view(np.uint64)
    first_of, back = groups_alike(*words.T)  # most pairs fit into the same housings as many others
    alike = fits[first_of]
    return np.asarray((alike & (product(alike.astype(np.float32), beats.astype(np.float32)) > 0.5))[back])

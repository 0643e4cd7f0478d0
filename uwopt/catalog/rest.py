"""The rest of a system: what every order needs beside camera, lens, port, lamps, housing and computer.

All of it is estimated by class, in USD: connectors and cables by depth for each camera and lamp, the data cable by its
length, and once for the system the electronics that trigger its lamps and cameras, a battery where the mission says
that it is its own, disks for what the design's images fill, spares and the pressure test.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from uwopt.catalog.estimates import ClassEstimate, required_class
from uwopt.catalog.interfaces import LINK, does_reach
from uwopt.catalog.parts.quantity import Quantity
from uwopt.units import format_number

Per = Literal["system", "camera", "lamp", "lighting"]  # lighting: once, where lamps burn
DEPTH_CLASSES = ((150.0, "to-150m"), (1000.0, "to-1000m"))
DEEPEST = "to-6000m"
DISK_GB = 250.0  # that the price of a computer holds, and that disks are bought by
DISK_FULL = 1e-6  # of a disk: what fills one but for rounding needs no other


@dataclass(frozen=True, slots=True)
class RestItem:
    """One line of the rest: how often it is bought, the price of one in USD, and its mass."""

    id: str
    name: str
    per: Per
    price: Quantity
    mass_g: Quantity | None = None


@dataclass(frozen=True, slots=True)
class RestNeeds:
    """What of a mission decides about the rest; None: not asked for."""

    depth_m: float
    lit: bool = True
    camera_count: int = 1
    cable_m: float | None = None
    battery_wh: float | None = None  # of a battery that the system brings along


def depth_class(depth_m: float | None) -> str:
    """The class of estimates for a depth; the deepest where it is not known."""
    return next((name for limit_m, name in DEPTH_CLASSES if depth_m is not None and depth_m <= limit_m), DEEPEST)


def whole_disks_gb(room_gb: Any) -> Any:
    """The disks that are bought for so much room, in whole ones of `DISK_GB`: nobody sells less [GB], elementwise."""
    return DISK_GB * np.maximum(np.ceil(np.asarray(room_gb) / DISK_GB - DISK_FULL), 0.0)


def disk_item(disks_gb: float, computers: int) -> RestItem:
    """Disks of one computer, of so many, for what a design's images fill there beyond its own disk."""
    of = "the computer" if computers == 1 else "each computer"
    name = f"disks of {format_number(disks_gb)} GB beyond the {DISK_GB:g} GB of {of}"
    return RestItem("rest-storage", name, "system", disk_price_per_gb().quantity(disks_gb))


def disk_price_per_gb() -> ClassEstimate:
    """Price in USD of one gigabyte of disk."""
    return required_class("rest-price", "storage-gb")


def rest_items(needs: RestNeeds) -> tuple[RestItem, ...]:
    """What a system needs beside its parts; without lamps nothing triggers them."""
    depth = depth_class(needs.depth_m)

    def item(name: str, words: str, per: Per, of: str, number: float = 1.0) -> RestItem:
        return RestItem(f"rest-{name}", words, per, required_class("rest-price", of).quantity(number))

    made = [item("camera-connection", "connectors and cable of a camera", "camera", f"connection-{depth}")]
    if (cable_m := needs.cable_m) is not None:
        name = f"data cable of a camera, {cable_m:g} m"
        made.append(item("data-cable", name, "camera", f"cable-m-{depth}", cable_m))
        if not does_reach(LINK, cable_m):
            made.append(item("link", f"modems for {cable_m:g} m of cable", "camera", "link"))
    if needs.lit:
        made += [
            item("lamp-connection", "connectors and cable of a lamp", "lamp", f"connection-{depth}"),
            item("lamp-control", "electronics that trigger and dim the lamps", "lighting", "lamp-control"),
        ]
    if needs.camera_count > 1:
        name = "electronics that fire the cameras together"
        made.append(item("synchronisation", name, "system", "synchronisation"))
    if (energy_wh := needs.battery_wh) is not None:
        name = f"battery in its housing, {energy_wh:g} Wh"
        price = required_class("rest-price", f"battery-wh-{depth}").quantity(energy_wh)
        mass_g = required_class("rest-mass-g", "battery-wh").quantity(energy_wh)
        made.append(RestItem("rest-battery", name, "system", price, mass_g))
    return (
        *made,
        item("spares", "spare O-rings, connectors and fuses, desiccant", "system", "spares"),
        item("pressure-test", "pressure test of the assembly", "system", f"pressure-test-{depth}"),
    )

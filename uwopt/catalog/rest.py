"""The rest of a system: what every order needs beside camera, lens, port, lamps, housing and computer.

All of it is estimated by class, in USD: connectors and cables by depth for each camera and lamp, and once for the
system the electronics that trigger and dim its lamps, spares and the pressure test. No battery: the vehicle's feeds it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from uwopt.catalog.estimates import required_class
from uwopt.catalog.parts.quantity import Quantity

Per = Literal["system", "camera", "lamp"]
DEPTH_CLASSES = ((150.0, "to-150m"), (1000.0, "to-1000m"))
DEEPEST = "to-6000m"


@dataclass(frozen=True, slots=True)
class RestItem:
    """One line of the rest: how often it is bought, and the price of one in USD."""

    id: str
    name: str
    per: Per
    price: Quantity


def rest_items(depth_m: float, *, lit: bool) -> tuple[RestItem, ...]:
    """What a system for a depth needs beside its parts; without lamps nothing triggers them."""
    depth = next((name for limit_m, name in DEPTH_CLASSES if depth_m <= limit_m), DEEPEST)

    def item(name: str, words: str, per: Per, of: str) -> RestItem:
        return RestItem(f"rest-{name}", words, per, required_class("rest-price", of).quantity())

    lamp_items = (
        item("lamp-connection", "connectors and cable of a lamp", "lamp", f"connection-{depth}"),
        item("lamp-control", "electronics that trigger and dim the lamps", "system", "lamp-control"),
    )
    return (
        item("camera-connection", "connectors and cable of a camera", "camera", f"connection-{depth}"),
        *(lamp_items if lit else ()),
        item("spares", "spare O-rings, connectors and fuses", "system", "spares"),
        item("pressure-test", "pressure test of the assembly", "system", f"pressure-test-{depth}"),
    )

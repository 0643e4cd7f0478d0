"""The parts that take part in a mission, as records, with the estimates that it asks for."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

from uwopt.catalog.records import OF_A_DESIGN, Camera, Lens, Light, Port
from uwopt.forward import switching
from uwopt.forward.enclosures import camera_with_size, lens_with_size
from uwopt.forward.spacers import lens_with_spacers, without_spacers
from uwopt.mission.mission import Mission


@dataclass(frozen=True)
class Parts:
    """The parts that take part, as records."""

    cameras: tuple[Camera, ...]
    lenses: tuple[Lens, ...]
    ports: tuple[Port, ...]
    lights: tuple[Light, ...]

    @staticmethod
    def of_each(some: Callable[[str], Iterable[Any]]) -> Parts:
        """Those of each kind."""
        return Parts(*(tuple(some(kind)) for kind in OF_A_DESIGN))

    @property
    def by_kind(self) -> dict[str, tuple[Any, ...]]:
        """All of each kind."""
        return {"camera": self.cameras, "lens": self.lenses, "port": self.ports, "light": self.lights}

    def of(self, design: Any) -> dict[str, Any]:
        """The four parts of a design by kind; whatever has their places by kind is one."""
        return {kind: every[getattr(design, kind)] for kind, every in self.by_kind.items()}


def estimated(mission: Mission, parts: Parts) -> Parts:
    """The parts with the estimates that only some missions ask for: what they draw while off, their
    computer, how large they are, and what rings lenses bear."""
    vehicles = [view.vehicle for view in mission.views]
    if switching.any_off(vehicles, "lamps_between_images"):
        parts = replace(parts, lights=tuple(switching.light_with_estimates(p) for p in parts.lights))
    if switching.any_off(vehicles, "camera_between_images"):
        if mission.catalog.host == "estimate":
            parts = replace(parts, cameras=tuple(switching.camera_with_starting_host(p) for p in parts.cameras))
        parts = replace(parts, cameras=tuple(switching.camera_with_estimates(p) for p in parts.cameras))
    if mission.catalog.host == "estimate":
        parts = replace(parts, cameras=tuple(switching.camera_with_host(p) for p in parts.cameras))
    spaced = lens_with_spacers if mission.catalog.spacers == "allow" else without_spacers
    parts = replace(parts, lenses=tuple(spaced(p) for p in parts.lenses))
    if mission.catalog.housing == "required" or any(port.housing and not port.complete for port in parts.ports):
        parts = replace(
            parts,
            cameras=tuple(camera_with_size(p) for p in parts.cameras),
            lenses=tuple(lens_with_size(p) for p in parts.lenses),
        )
    return parts

"""A design as indices into a problem's tables, and its settings."""

from __future__ import annotations

from dataclasses import dataclass, replace

from uwopt.forward.lamps import Mount


@dataclass(frozen=True)
class Hardware:
    """A design's hardware as indices into a problem's tables."""

    camera: int
    lens: int
    port: int
    landscape: bool
    light: int
    count: int
    mount: Mount
    spacer_m: float | None = None  # ring behind the lens; None: the one that the searched focus needs

    @property
    def alone(self) -> Hardware:
        """The same as indices into the tables of its own parts alone."""
        return replace(self, camera=0, lens=0, port=0, light=0)


@dataclass(frozen=True)
class SceneSettings:
    """Settings of one design in one scene; SI. None takes the documented default."""

    f_number: float | None = None
    exposure_s: float | None = None
    pulse_s: float | None = None
    gain: float | None = None
    level: float | None = None
    rate_hz: float | None = None
    dioptre_per_m: float | None = None
    focus_distance_m: float | None = None

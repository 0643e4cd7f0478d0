"""Effects that a scene may or may not need, and which of them a model keeps.

Physics `paper` knows none of them, `full` all; `auto` leaves out what cannot matter in the scene at hand
(the bounds are worked out in `uwopt.forward.effects`, which knows scenes and parts).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace


@dataclass(frozen=True)
class Effects:
    """Which effects a model keeps."""

    forward_veil: bool = True  # lamp light that is scattered a little on its way from floor to camera
    backscatter: bool = True  # lamp light that the water between returns
    multiple_scattering: bool = True  # light that is scattered more than once, on all its ways
    sunlight: bool = True  # what the sun adds to the image, and its veil
    window_angle: bool = True  # a flat window's loss grows off its axis
    image_curvature: bool = True  # a dome bends the image of a flat floor
    lateral_colour: bool = True  # a flat window spreads colours

    @staticmethod
    def none() -> Effects:
        """The paper's model."""
        return Effects(**{f.name: False for f in fields(Effects)})

    @staticmethod
    def names() -> tuple[str, ...]:
        """All effects, in the light's order."""
        return tuple(f.name for f in fields(Effects))

    def without(self, names: Iterable[str]) -> Effects:
        """The same but for these."""
        return replace(self, **dict.fromkeys(names, False))

    @property
    def veils(self) -> bool:
        """Whether any light of the lamps forms no image."""
        return self.forward_veil or self.backscatter


FULL = Effects()
PAPER = Effects.none()

"""Figures of a replayed design, by the names that reports use."""

from __future__ import annotations

from typing import Any

from uwopt.evaluation.figures_by_name import plain_figures
from uwopt.evaluation.recompute import Replay
from uwopt.evaluation.resolved import Measured, resolved


def plain_figures_of(made: Replay, scene: int = 0) -> dict[str, Any]:
    """Of one scene."""
    every = [made.figures(index) for index in range(len(made.settings))]
    (sharp,) = resolved([Measured(made.model, [*made.settings], every)])
    return plain_figures(made.model, scene, made.settings[scene], every[scene], sharp[scene])

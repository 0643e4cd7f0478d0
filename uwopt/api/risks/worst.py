"""What rules on risks share: the scene that is worst in a figure."""

from __future__ import annotations

from collections.abc import Iterator

from uwopt.results.basis import Risk
from uwopt.results.design import Design, SceneResult

Weighed = Iterator[tuple[float, Risk]]


def worst(design: Design, figure: str, *, least: bool = False) -> tuple[SceneResult | None, float]:
    """The scene that has the most of a figure, or the least, and how much."""
    known = [
        (float(s.figures[figure]), s)
        for s in design.scenes
        if isinstance(s.figures.get(figure), (int, float))
    ]
    if not known:
        return None, 0.0
    value, scene = (min if least else max)(known, key=lambda item: item[0])
    return scene, value


def in_which_scene(design: Design, scene: SceneResult) -> str:
    """Which scene, where there are several."""
    return f" in {scene.name}" if len(design.scenes) > 1 else ""

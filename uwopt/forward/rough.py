"""Scenes with fewer colours and coarser integrals, for what is asked roughly: how light changes from water to water."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np

from uwopt.forward.scene import SceneOptics
from uwopt.model.fineness import Fineness

ROUGH_STEP = 4  # colours of a scene of which one is kept in its rough likeness
ROUGH = Fineness(spectrum=0.5, image=0.5, veil=0.75, sun=0.5, places=0.25)


def rough(known: SceneOptics) -> SceneOptics:
    """The same scene with fewer colours and coarser integrals: for how light changes with the water, not for how much.

    Both are off by as much in like waters: of light's changes 2e-4 is lost, and 1e-3 of those at the frame's places.
    """
    count = len(known.wavelength_nm)
    kept = np.unique(np.append(np.arange(0, count, ROUGH_STEP), count - 1))

    def thinned(column: Any) -> Any:
        return column[kept] if isinstance(column, np.ndarray) and column.shape == (count,) else column

    columns: dict[str, Any] = {f.name: thinned(getattr(known, f.name)) for f in fields(known)}
    scattering = tuple(replace(one, scattering_per_m=one.scattering_per_m[kept]) for one in known.scattering)
    return replace(known, **(columns | {"scattering": scattering, "cache": {}, "fineness": ROUGH}))

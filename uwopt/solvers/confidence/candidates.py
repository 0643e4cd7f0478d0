"""Hardware that is likely to hold: the best where parts and water are as bad as few scenarios make them.

A search with every estimate at its central value finds what stands at the edge. One with every number worse than most
of its draws, in water murkier than most, finds what has room, best first; how often each holds is then counted.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from uwopt.catalog.parts.doubts import doubtful, taken_as
from uwopt.catalog.records import Port
from uwopt.forward.part_columns import FAVOURED
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.solvers.confidence.draws import triangular
from uwopt.solvers.confidence.scenarios import Scenarios, brighter


def worse_part(part: Any, share: float, *, drawn: bool = True) -> Any:
    """A part each of whose uncertain numbers is worse than in so large a share of its draws."""
    if not drawn:
        return part
    changes: dict[str, Any] = {}
    for name, known in doubtful(part):
        if sign := FAVOURED.get(name, 0):
            probability = np.array(1.0 - share if sign > 0 else share)
            value = float(triangular(probability, known.low, known.value, known.high))
            changes[name] = taken_as(name, known, value)
    if isinstance(part, Port) and part.housing is not None:
        changes["housing"] = worse_part(part.housing, share)
    return replace(part, **changes) if changes else part


def worse_problem(base: Problem, scenarios: Scenarios, share: float) -> Problem:
    """The same parts, all worse than in a share of the scenarios, in water that is murkier than in as many.

    What must be sharp is so wherever lenses stand in as many.
    """
    parts, doubt = base.parts, scenarios.doubt
    drawn = doubt.parts
    low, high = doubt.lamp_output
    output = float(triangular(np.array(1.0 - share), low, 1.0, high))
    made = Parts(
        tuple(worse_part(p, share, drawn=drawn) for p in parts.cameras),
        tuple(worse_part(p, share, drawn=drawn) for p in parts.lenses),
        tuple(worse_part(p, share, drawn=drawn) for p in parts.ports),
        tuple(brighter(worse_part(p, share, drawn=drawn), output) for p in parts.lights),
    )
    worse = Problem(
        base.mission, made, paper=base.paper, owned_lights=base.owned_lights, counts=base.count_range,
        mounts=base.mounts, scenes=scenarios.scenes_at(share), effects=base.effects, have_estimates=True,
    )  # fmt: skip
    foci = np.array([1.0, *np.quantile(scenarios.focus, [0.5 * (1.0 - share), 0.5 * (1.0 + share)])])
    shares = np.repeat(foci[:, None], len(parts.cameras), axis=1)
    return worse if np.ptp(foci) == 0.0 else worse.focused_at(shares)

"""Hardware that is likely to hold: the best where parts and water are as bad as few scenarios make them.

A search with every estimate at its central value finds what stands at the edge. One with every number worse than most
of its draws, in water murkier than most, finds what has room, best first; how often each holds is then counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from uwopt.catalog.parts.doubts import taken_as, with_numbers
from uwopt.catalog.records import Quantity
from uwopt.forward.part_columns import FAVOURED
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.solvers.confidence.draws import triangular
from uwopt.solvers.confidence.scenarios import Scenarios, brighter


def worse_part(part: Any, share: float) -> Any:
    """A part each of whose uncertain numbers is worse than in so large a share of its draws."""

    def value_at(name: str, known: Quantity) -> Quantity | None:
        sign = FAVOURED.get(name, 0)
        probability = np.array(1.0 - share if sign > 0 else share)
        value = float(triangular(probability, known.low, known.value, known.high))
        return taken_as(name, known, value) if sign else None

    return with_numbers(part, value_at)


def worse_problem(base: Problem, scenarios: Scenarios, share: float) -> Problem:
    """The same parts, all worse than in a share of the scenarios, in water that is murkier than in as many.

    What must be sharp is so wherever lenses stand in as many.
    """
    parts, doubt = base.parts, scenarios.doubt
    low, high = doubt.lamp_output
    output = float(triangular(np.array(1.0 - share), low, 1.0, high))

    def worse(some: Sequence[Any]) -> tuple[Any, ...]:
        return tuple(worse_part(part, share) for part in some) if doubt.parts else tuple(some)

    made = Parts(
        worse(parts.cameras), worse(parts.lenses), worse(parts.ports),
        tuple(brighter(light, output) for light in worse(parts.lights)),
    )  # fmt: skip
    problem = base.over(made, scenes=scenarios.scenes_at(share), have_estimates=True)
    foci = np.array([1.0, *np.quantile(scenarios.focus, [0.5 * (1.0 - share), 0.5 * (1.0 + share)])])
    shares = np.repeat(foci[:, None], len(parts.cameras), axis=1)
    return problem if np.ptp(foci) == 0.0 else problem.focused_at(shares)

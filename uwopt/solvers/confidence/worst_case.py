"""Worse numbers: all of them at their bad ends, in each water that the doubts leave open; or each worse than in most
of its draws, in water murkier than most, where a search finds hardware with room, best first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, ClassVar

import numpy as np

from uwopt.catalog.parts.doubts import taken_as, with_numbers
from uwopt.catalog.parts.kinds import FAVOURED
from uwopt.catalog.records import Light, Part, Quantity
from uwopt.forward.once import MOST_RECORDS, Once
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.forward.scene import SceneOptics
from uwopt.mission.doubt import Doubt
from uwopt.mission.mission import Mission
from uwopt.solvers.confidence.draws import triangular
from uwopt.solvers.confidence.scenarios import Scenarios, brighter
from uwopt.solvers.confidence.waters import Waters, WaterState
from uwopt.solvers.one_hardware import at_end, with_either_end

ENDS = (-1.0, 1.0)
PORT_VARIANTS = 3  # of a dome whose radius is in doubt: as it is, and both ends


@dataclass(frozen=True)
class EndScenarios(Scenarios):
    """Every combination of the ends of water, floor and focus with those of a dome's radius; parts at their bad ends.

    The vehicle leaves its band as far as it may.
    """

    best_end: ClassVar[tuple[str, int]] = ("bad", 0)

    @staticmethod
    def of(mission: Mission, scenes: Sequence[SceneOptics], doubt: Doubt) -> EndScenarios:
        """All of them, each once."""
        waters = Waters.of(mission, scenes)
        left_open = waters.left_open_by(doubt)
        tables = (False, True) if left_open.other_water_table > 0.0 else (False,)
        clarity = ENDS if left_open.clarity else (0.0,)
        legs = ENDS if doubt.lamp_leg and any(scene.scattering for scene in scenes) else (0.0,)
        floors = tuple(dict.fromkeys(doubt.floor))
        foci = tuple(dict.fromkeys(doubt.focus))
        rows = list(product(product(tables, clarity, legs, floors), range(PORT_VARIANTS), foci))
        states = [WaterState(*water, doubt.beyond_band) for water, _, _ in rows]
        port, focus = np.array([variant for _, variant, _ in rows]), np.array([share for _, _, share in rows])
        return EndScenarios(doubt, 0, len(rows), states, waters, port, focus)

    def ports(self, part: Part) -> list[Any]:
        """A port at its bad end, with each end of its radius."""
        if not self.doubt.parts:
            return [part] * PORT_VARIANTS
        variants = with_either_end(at_end(part, "bad"))
        return (variants * PORT_VARIANTS)[:PORT_VARIANTS]

    def each(self, part: Part) -> list[Any]:
        """A camera or a lens at its bad end."""
        return [self.favoured(part)] * self.count

    def lights(self, part: Light) -> list[Light]:
        """A light at its bad end, and as faint as lamps are."""
        return [self.favoured_light(part)] * self.count

    @property
    def is_drawn(self) -> bool:
        """As of scenarios; here all have the same ends."""
        return False


# ---------------------------------------------------------------- worse than in most


#: Parts that are worse, by the part and how much: searches with room are made of the same parts again and again.
WORSE_PARTS: Once[Any] = Once(MOST_RECORDS)


def worse_part(part: Any, share: float) -> Any:
    """A part each of whose uncertain numbers is worse than in so large a share of its draws; once for each."""

    def value_at(name: str, known: Quantity) -> Quantity | None:
        sign = FAVOURED.get(name, 0)
        probability = np.array(1.0 - share if sign > 0 else share)
        value = float(triangular(probability, known.low, known.value, known.high))
        return taken_as(name, known, value) if sign else None

    return WORSE_PARTS.of([part], share, lambda: with_numbers(part, value_at))


def worse_light(light: Light, share: float, doubt: Doubt) -> Light:
    """A light likewise, where its numbers are in doubt, whose output is worse than in as many draws as well."""
    low, high = doubt.lamp_output
    worse = worse_part(light, share) if doubt.parts else light
    output = float(triangular(np.array(1.0 - share), low, 1.0, high))
    return WORSE_PARTS.of([worse], ("output", output), lambda: brighter(worse, output))


def worse_problem(base: Problem, scenarios: Scenarios, share: float) -> Problem:
    """The same parts, all worse than in a share of the scenarios, in water that is murkier than in as many.

    What must be sharp is so wherever lenses stand in as many.
    """
    parts, doubt = base.parts, scenarios.doubt

    def worse(some: Sequence[Any]) -> tuple[Any, ...]:
        return tuple(worse_part(part, share) for part in some) if doubt.parts else tuple(some)

    made = Parts(
        worse(parts.cameras), worse(parts.lenses), worse(parts.ports),
        tuple(worse_light(light, share, doubt) for light in parts.lights),
    )  # fmt: skip
    problem = base.over(made, scenes=scenarios.scenes_at(share), have_estimates=True)
    foci = np.array([1.0, *np.quantile(scenarios.focus, [0.5 * (1.0 - share), 0.5 * (1.0 + share)])])
    shares = np.repeat(foci[:, None], len(parts.cameras), axis=1)
    return problem if np.ptp(foci) == 0.0 else problem.focused_at(shares)

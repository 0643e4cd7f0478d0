"""Scenarios: everything that is uncertain, drawn once for all hardware.

A scenario has a state of its own of water, floor, camera, lens and light. Ports and beams, whose optics are dear to
work out, have few states, each of which serves as many scenarios.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.parts.doubts import doubtful, each_with, taken_as
from uwopt.catalog.records import Light, Part, Quantity, exact
from uwopt.forward.problem import Problem
from uwopt.forward.scene import SceneOptics
from uwopt.mission.doubt import Doubt
from uwopt.mission.mission import Mission
from uwopt.solvers.confidence.draws import drawn_numbers, drawn_parts, probabilities, shuffled, triangular
from uwopt.solvers.confidence.waters import Waters, WaterState, drawn_states, may_leave_band
from uwopt.solvers.one_hardware import at_end

PORTS, BEAMS = 8, 8  # states of the optics of a port and of a beam, whose integrals over the image are dear
BEAM_FACTS = frozenset({"beam_angle_deg"})
#: Of the logarithm of a field's tangent: images whose light changes alike with the water. Of fields that differ seven
#: times as much, that of the whole image changes alike within 1 %, that of its darkest pixels within 3 %.
SAME_FIELD = 0.2
AS_KNOWN = WaterState(other_table=False, clarity=0.0, lamp_leg=0.0, floor=1.0)
ROUGH = 2  # of what tells images apart, the first: the waters, and the colours that a sensor sees


@dataclass(frozen=True)
class Scenarios:
    """So many scenarios of one mission, each with a state of water and altitude, of port and of focus, (count,)."""

    doubt: Doubt
    seed: int
    count: int
    states: list[WaterState]
    waters: Waters
    port: Array
    focus: Array  # of the distance meant at which lenses stand
    best_end: ClassVar[tuple[str, int]] = ("good", 1)  # that any has of what parts may be, and of the output of lamps
    known: dict[Any, Any] = field(default_factory=dict, repr=False, compare=False)  # parts drawn
    responses: dict[Any, Any] = field(default_factory=dict, repr=False, compare=False)  # of light, by image

    @staticmethod
    def drawn(
        mission: Mission, scenes: Sequence[SceneOptics], doubt: Doubt, *, seed: int, count: int,
        like: Scenarios | None = None,
    ) -> Scenarios:  # fmt: skip
        """Draw them; `like`: others of the same mission, scenes and doubt, whose waters are known.

        So are the parts that were drawn for as many of the same seed.
        """
        port = shuffled(seed, "port", count) * PORTS // count
        focus = triangular(probabilities(seed, "focus", count), doubt.focus[0], 1.0, doubt.focus[1])
        waters = Waters.of(mission, scenes) if like is None else like.waters
        states = drawn_states(waters.left_open_by(doubt), seed, count, has_band=any(map(may_leave_band, scenes)))
        responses = {} if like is None else like.responses
        known = like.known if like is not None and (like.seed, like.count) == (seed, count) else {}
        return Scenarios(doubt, seed, count, states, waters, port, focus, known=known, responses=responses)

    def seen_by(self, mission: Mission, scenes: Sequence[SceneOptics]) -> Scenarios:
        """The same draws for a mission that asks for other things in these scenes; light in the waters is kept."""
        return replace(self, waters=self.waters.seen_by(mission, scenes), responses={})

    @property
    def all_states(self) -> list[WaterState]:
        """The states between whose ends light is worked out."""
        return self.states

    @property
    def rough(self) -> bool:
        """Whether light changes with the water as in any image of as many colours."""
        return False

    def lit_in(self, problem: Problem) -> Problem:
        """A problem with the water as it is known, in which light is worked out."""
        return problem

    @property
    def colours(self) -> set[tuple[str, ...]]:
        """Of the sensors for which it is known how light changes with the water."""
        return {key[1] for key in self.responses}

    @cached_property
    def nodes(self) -> tuple[Any, ...]:
        """Between which waters the states lie: tables, and whether clarity and K are drawn."""
        states = self.states
        tables = frozenset(state.other_table for state in states)
        return tables, any(state.clarity for state in states), any(state.lamp_leg for state in states)

    @property
    def is_drawn(self) -> bool:
        """Whether numbers of parts differ between scenarios."""
        return True

    @cached_property
    def scenes(self) -> list[list[SceneOptics]]:
        """The scenes of the mission in each scenario."""
        return [self.waters.at(state) for state in self.states]

    @cached_property
    def loss(self) -> Array:
        """What the water of each takes of the light, all scenes together, (count,)."""
        return np.array([sum(map(loss, scenes)) for scenes in self.scenes])

    def scenes_at(self, share: float) -> list[SceneOptics]:
        """The scenes in water that takes more of the light than in so large a share of the scenarios."""
        place = min(int(share * self.count), self.count - 1)
        return self.waters.kept(self.states[int(np.argsort(self.loss, kind="stable")[place])])

    def favoured(self, part: Any) -> Any:
        """A part that is in no scenario more favourable."""
        return at_end(part, self.best_end[0]) if self.doubt.parts else part

    def favoured_light(self, part: Light) -> Light:
        """A light that is in no scenario brighter, nor draws less."""
        return brighter(self.favoured(part), self.doubt.lamp_output[self.best_end[1]])

    def ports(self, part: Part) -> list[Any]:
        """A port in each of its states."""
        return drawn_parts(part, self.seed, PORTS) if self.doubt.parts else [part] * PORTS

    def each(self, part: Part) -> list[Any]:
        """A camera or a lens in each scenario."""
        if not self.doubt.parts:
            return [part] * self.count
        return self.drawn_once(part, lambda: drawn_parts(part, self.seed, self.count))

    def drawn_once(self, part: Any, drawn: Callable[[], list[Any]]) -> list[Any]:
        """What is drawn of a part, kept."""
        key = id(part)  # of a record that is kept: pieces of a complete camera share its name
        if key not in self.known:
            self.known[key] = part, drawn()
        return list(self.known[key][1])

    def lights(self, part: Light) -> list[Light]:
        """A light in each scenario; its beam in one of few states."""
        return self.drawn_once(part, lambda: self.drawn_lights(part))

    def drawn_lights(self, part: Light) -> list[Light]:
        """The same, drawn anew."""
        columns = drawn_numbers(part, self.seed, self.count) if self.doubt.parts else {}
        for name, known in doubtful(part) if self.doubt.parts else ():
            if name in BEAM_FACTS:
                angle = triangular(self.beam_probability(part, name), known.low, known.value, known.high)
                columns[name] = [taken_as(name, known, value) for value in angle.tolist()]
        low, high = self.doubt.lamp_output
        output = triangular(probabilities(self.seed, f"{part.id} output", self.count), low, 1.0, high).tolist()
        drawn = columns.get("output_factor") or [part.output_factor] * self.count
        columns["output_factor"] = [times(known, factor) for known, factor in zip(drawn, output, strict=True)]
        return each_with(part, columns, self.count)

    def beam_probability(self, part: Part, name: str) -> Array:
        """The probability at which a fact of a beam is drawn in each scenario: one of few."""
        state = shuffled(self.seed, f"{part.id} beam", self.count) * BEAMS // self.count
        return np.asarray(probabilities(self.seed, f"{part.id} {name}", BEAMS)[state])


@dataclass(frozen=True)
class SomeScenarios(Scenarios):
    """Some of the scenarios, to look at much hardware.

    What is dear is rough: light changes with the water as in an image that is known, optics of ports and beams stand at
    their likeliest values.

    `whole` : all of them
    `places` : which these are
    """

    whole: Scenarios | None = None
    places: Array = field(default_factory=lambda: np.empty(0, int))

    @staticmethod
    def among(whole: Scenarios, places: Array) -> SomeScenarios:
        """Those at these places."""
        known = {key[:ROUGH]: response for key, response in whole.responses.items()}
        return SomeScenarios(
            whole.doubt, whole.seed, len(places), [whole.states[int(k)] for k in places], whole.waters,
            whole.port[places], whole.focus[places], responses=known, whole=whole, places=places,
        )  # fmt: skip

    @property
    def all(self) -> Scenarios:
        """The scenarios that these are of."""
        assert self.whole is not None
        return self.whole

    @property
    def all_states(self) -> list[WaterState]:
        """As of all."""
        return self.all.states

    @property
    def rough(self) -> bool:
        """It does: this is to look at much hardware."""
        return True

    def lit_in(self, problem: Problem) -> Problem:
        """Roughly."""
        return problem.in_scenes(self.waters.kept(AS_KNOWN, roughly=True))

    @cached_property
    def nodes(self) -> tuple[Any, ...]:
        """As of all."""
        return self.all.nodes

    @cached_property
    def scenes(self) -> list[list[SceneOptics]]:
        """As in all."""
        return [self.all.scenes[int(k)] for k in self.places]

    def each(self, part: Part) -> list[Any]:
        """A camera or a lens in each of these."""
        if not self.doubt.parts:
            return [part] * self.count
        return self.drawn_once(part, lambda: drawn_parts(part, self.seed, self.all.count, self.places))

    def lights(self, part: Light) -> list[Light]:
        """A light in each of these."""
        every, beam = self.all.lights(part), {name: getattr(part, name) for name in BEAM_FACTS}
        return [replace(every[int(k)], **beam) for k in self.places]

    def ports(self, part: Part) -> list[Any]:
        """A port, always the same."""
        return [part] * PORTS


def brighter(light: Light, factor: float) -> Light:
    """A lamp that gives so many times the light that it is taken for."""
    return replace(light, output_factor=times(light.output_factor, factor))


def times(output: Quantity | None, factor: float) -> Quantity:
    """A lamp's output, as a factor on its lumens, where it gives so many times as much."""
    return exact((1.0 if output is None else output.value) * factor, "estimated", "drawn")


def loss(scene: SceneOptics) -> float:
    """What a water takes on the way from lamp to floor and back, where the eye sees best, and the floor withholds."""
    weight = scene.photopic / max(float(scene.photopic.sum()), 1e-300)
    path = (scene.attenuation_per_m + scene.lamp_attenuation_per_m) * float(scene.range_m[-1])
    return float((weight * (path - np.log(np.maximum(scene.reflectance, 1e-9)))).sum())

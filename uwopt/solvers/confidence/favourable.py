"""What no hardware can beat in too many scenarios: parts and water as good as most scenarios allow.

Of each part, and of the water, a version is made that is at least as good as all but a few of its states. Whatever
hardware does with these versions it does not better in any scenario in which none of its pieces is better than its
version; and those are all scenarios but the few of its camera, its lens, its port, its light and its water together. As
long as these are no more than half, the median over the scenarios is bounded.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.catalog.parts.doubts import doubtful
from uwopt.catalog.parts.kinds import EITHER
from uwopt.catalog.records import Light, Part, Port, exact
from uwopt.forward.part_columns import FAVOURED
from uwopt.forward.problem import Parts, Problem
from uwopt.forward.scene import SceneOptics, Scattering
from uwopt.solvers.confidence.draws import probabilities, triangular
from uwopt.solvers.confidence.scenarios import BEAM_FACTS, Scenarios, brighter

Array = NDArray[Any]
BETTER = {"camera": 0.13, "lens": 0.11, "light": 0.16, "port": 0.0, "water": 0.0625}  # shares of states; below a half
RADII = 3  # of a dome whose radius is in doubt: its ends, and between them


def favourable_problem(base: Problem, scenarios: Scenarios) -> Problem:
    """The problem whose every design is as good as in all but a few scenarios."""
    parts = base.parts
    made = Parts(
        tuple(favourable(p, scenarios, BETTER["camera"]) for p in parts.cameras),
        tuple(favourable(p, scenarios, BETTER["lens"]) for p in parts.lenses),
        tuple(one for p in parts.ports for one in favourable_ports(p, scenarios)),
        tuple(favourable_light(p, scenarios) for p in parts.lights),
    )
    return Problem(
        base.mission, made, paper=base.paper, owned_lights=base.owned_lights, counts=base.count_range,
        mounts=base.mounts, scenes=clearest(scenarios), effects=base.effects,
    )  # fmt: skip


def goodness(seed: int, part: Part, name: str, states: int) -> Array:
    """How good the draws of one number are, from 0 to 1, (states,)."""
    drawn = probabilities(seed, f"{part.id} {name}", states)
    return drawn if FAVOURED.get(name, 0) > 0 else 1.0 - drawn


def level_of(columns: Sequence[Array], share: float) -> float:
    """The least level that all columns stay below in all but a share of the states."""
    if not columns:
        return 1.0
    best = np.sort(np.max(columns, axis=0))
    return float(best[len(best) - 1 - int(np.floor(share * len(best)))])


def favourable(part: Any, scenarios: Scenarios, share: float, *, known: Sequence[Array] = ()) -> Any:
    """A part with every uncertain number as good as it is in all but a share of its states."""
    facts = [(n, q) for n, q in doubtful(part) if FAVOURED.get(n, 0)] if scenarios.doubt.parts else []
    seed, count = scenarios.seed, scenarios.count
    level = level_of([goodness(seed, part, n, count) for n, _ in facts if n not in BEAM_FACTS] + list(known), share)
    changes: dict[str, Any] = {}
    for name, q in facts:
        at = 1.0 if name in BEAM_FACTS else level
        probability = np.array(at if FAVOURED[name] > 0 else 1.0 - at)
        changes[name] = exact(float(triangular(probability, q.low, q.value, q.high)), q.status, q.source)
    return replace(part, **changes) if changes else part


def favourable_light(part: Light, scenarios: Scenarios) -> Light:
    """A light likewise, its output among its uncertain numbers."""
    output = probabilities(scenarios.seed, f"{part.id} output", scenarios.count)
    better = favourable(part, scenarios, BETTER["light"], known=[output])
    facts = [n for n, _ in doubtful(part) if FAVOURED.get(n, 0) and n not in BEAM_FACTS] if scenarios.doubt.parts else []
    columns = [goodness(scenarios.seed, part, n, scenarios.count) for n in facts]
    low, high = scenarios.doubt.lamp_output
    factor = triangular(np.array(level_of([*columns, output], BETTER["light"])), low, 1.0, high)
    return brighter(better, float(factor))


def favourable_ports(part: Port, scenarios: Scenarios) -> list[Port]:
    """A port at its best; one whose radius is in doubt at several, for more of it is not better of itself."""
    if not scenarios.doubt.parts:
        return [part]
    changes: dict[str, Any] = {}
    for name, q in doubtful(part):
        if FAVOURED.get(name, 0):
            changes[name] = exact(q.high if FAVOURED[name] > 0 else q.low, q.status, q.source)
    if part.housing is not None:
        hull = {n: q for n, q in doubtful(part.housing) if FAVOURED.get(n, 0)}
        changes["housing"] = replace(
            part.housing,
            **{n: exact(q.high if FAVOURED[n] > 0 else q.low, q.status, q.source) for n, q in hull.items()},
        )
    better = replace(part, **changes)
    radii = [(n, q) for n, q in doubtful(part) if n in EITHER]
    if not radii:
        return [better]
    return [
        replace(better, **{n: exact(float(value), q.status, q.source)})
        for n, q in radii
        for value in np.linspace(q.low, q.high, RADII)
    ]


def clearest(scenarios: Scenarios) -> list[SceneOptics]:
    """Scenes that take less from the light, and send less of it back, than those of all but a share of the states."""
    kept = list(range(len(scenarios.scenes)))
    for _ in range(int(np.floor(BETTER["water"] * len(kept)))):
        loss = [float(np.mean(scenarios.scenes[k][0].lamp_attenuation_per_m)) for k in kept]
        kept.pop(int(np.argmin(loss)))
    return [envelope([scenarios.scenes[k][index] for k in kept]) for index in range(len(scenarios.scenes[0]))]


def envelope(scenes: Sequence[SceneOptics]) -> SceneOptics:
    """One scene with the least of every attenuation and of scattering, and the brightest floor."""
    first = scenes[0]

    def least(name: str) -> Any:
        columns = [getattr(scene, name) for scene in scenes]
        return None if columns[0] is None else np.min(columns, axis=0)

    scattering = tuple(
        Scattering(one.name, np.min([s.scattering[k].scattering_per_m for s in scenes], axis=0), one.table)
        for k, one in enumerate(first.scattering)
    )
    return replace(
        first, attenuation_per_m=least("attenuation_per_m"), lamp_attenuation_per_m=least("lamp_attenuation_per_m"),
        diffuse_attenuation_per_m=least("diffuse_attenuation_per_m"), scattering=scattering,
        reflectance=np.max([scene.reflectance for scene in scenes], axis=0), cache={},
    )  # fmt: skip

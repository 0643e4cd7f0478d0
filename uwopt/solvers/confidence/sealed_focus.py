"""Where a lens is focused before its port is sealed: one distance in water, whatever the scenario turns out to be.

It stands where what must be sharp needs the least f-number, whichever way the lens is off and however far the vehicle
leaves its band, as far as both go in most scenarios. What the parts turn out to be is not known when it is set.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.focus import depth_f_number, is_at_nominal
from uwopt.forward.problem import Problem
from uwopt.forward.scene import SceneOptics
from uwopt.forward.views import Views, focus_map
from uwopt.model.port import FocusMap, water_distance_m
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.confidence.waters import over_band_of
from uwopt.solvers.exact.imagers import stands
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.seen import seen_behind

MOST = 0.9  # of the scenarios, within whose ends it is sharp
ROUNDS, PLACES = 3, 9  # of a search for the best focus: each takes another quarter of the range
WIDER = 0.02  # of the dioptre: how far beyond what is in doubt the best focus is looked for


def meant_foci_m(base: Problem, found: Sequence[Found], scenarios: Scenarios) -> Array:
    """Distance in the first scene's water at which each lens is meant to be focused, (n,); as given, where that is."""
    if base.meant_m is not None:
        own = base.meant_m
        camera, lens = (np.array([getattr(one, kind) for one in found]) for kind in ("camera", "lens"))
        return np.asarray(own(camera, lens), float) if callable(own) else np.full(len(found), own)
    problem, made = in_most(base, scenarios), np.zeros(len(found))
    for landscape, port in {(one.landscape, one.port) for one in found}:
        mine = np.array([k for k, one in enumerate(found) if (one.landscape, one.port) == (landscape, port)])
        camera, lens = (np.array([getattr(found[k], kind) for k in mine]) for kind in ("camera", "lens"))
        made[mine] = behind(problem, camera, lens, port, landscape)
    return made


def in_most(base: Problem, scenarios: Scenarios) -> Problem:
    """The parts at their likeliest values, over the band that most scenarios keep, lenses at the ends of most foci."""
    share = MOST if scenarios.is_drawn else 1.0
    beyond = np.quantile([state.beyond for state in scenarios.states], share)
    foci = np.unique(np.quantile(scenarios.focus, [0.5 * (1.0 - share), 0.5 * (1.0 + share)]))
    wider = over_band_of(base, float(beyond))
    return wider.focused_at(np.repeat(foci[:, None], len(base.parts.cameras), axis=1))


def behind(problem: Problem, camera: Array, lens: Array, port: int, landscape: bool) -> Array:
    """The same of pairs behind one port."""
    seen, dioptre, _ = seen_behind(problem, camera, lens, port, landscape)
    scenes = problem.scenes
    maps = [focus_map(scene, problem.shape(port, index)) for index, scene in enumerate(scenes)]
    shares = problem.focus_shares
    if shares is not None and len(shares) > 1 and not is_at_nominal(scenes):
        wanted = Wanted(scenes, maps, seen, lambda meant: stands(problem, camera, lens, meant))
        dioptre = least_asking(wanted, dioptre, WIDER + float(np.abs(1.0 / shares - 1.0).max()))
    return np.asarray(water_distance_m(dioptre, focus_map=maps[0]))


@dataclass(frozen=True)
class Wanted:
    """What must be sharp of some pairs, by scene, wherever their lenses may stand."""

    scenes: Sequence[SceneOptics]
    maps: Sequence[FocusMap]
    seen: Sequence[Views]
    stands: Callable[[Array], Array]  # from the dioptre that is meant to those at which the lens may stand, (k, n)

    def f_number(self, meant_per_m: Array) -> Array:
        """The least f-number that keeps all of it sharp, (n,)."""
        every = zip(self.scenes, self.maps, self.seen, strict=True)
        own = self.stands(meant_per_m)
        return np.max([depth_f_number(*scene, at) for scene in every for at in own], axis=0)


def least_asking(wanted: Wanted, dioptre_per_m: Array, width: float) -> Array:
    """The dioptre near one, (n,), within a share of it, that asks for the least f-number."""
    best, least = dioptre_per_m, wanted.f_number(dioptre_per_m)
    for _ in range(ROUNDS):
        centre = best
        for step in np.linspace(-width, width, PLACES):
            tried = centre * (1.0 + step)
            asked = wanted.f_number(tried)
            best, least = np.where(asked < least, tried, best), np.minimum(asked, least)
        width *= 2.0 / (PLACES - 1)
    return best

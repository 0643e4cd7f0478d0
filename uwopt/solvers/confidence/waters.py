"""The states of water and floor that scenarios draw from.

A water is uncertain in which published table of its Jerlov type holds, in what its reading (a visibility, a Secchi
depth) leaves open, and in K on the way from lamp to floor, by the share of scattered light that is lost there. A state
lies between known spectra: each of its coefficients is their geometric mean, weighted by how far it is from the central
one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.curves.clarity import ClarityEnd
from uwopt.forward.problem import Problem
from uwopt.forward.rough import rough
from uwopt.forward.scene import (
    LOST,
    LampLeg,
    Scattering,
    SceneOptics,
    geometric,
    scene_optics,
    seen_anew,
    without_reserve,
)
from uwopt.mission.doubt import Doubt
from uwopt.mission.mission import Mission, SceneView
from uwopt.solvers.confidence.draws import even_points, probabilities, shuffled, triangular
from uwopt.solvers.explain.other_waters import other_table, own_table

OPTICAL = 3  # columns before those of scattering: c, K of the lamps' way, K_d
TOWARD: dict[ClarityEnd, int] = {"low": -1, "central": 0, "high": 1}  # sign of the clarity
ENDS: tuple[LampLeg, LampLeg, LampLeg] = ("least", "diffuse", "most")
BANDS = 16  # states of the band of altitudes, over each of which all that is geometric is worked out: a limit that is
# crossed beyond the band is lost in one scenario of sixteen too many or too few, at most


@dataclass(frozen=True)
class WaterState:
    """One state: which table, and how far between the ends of clarity and of K, from -1 to 1."""

    other_table: bool
    clarity: float
    lamp_leg: float
    floor: float  # factor on its reflectance
    beyond: float = 0.0  # how far the vehicle leaves its band of altitudes, as a share of the tolerance


def drawn_states(doubt: Doubt, seed: int, count: int, *, has_band: bool = False) -> list[WaterState]:
    """Evenly spread states; those of all scenes of a mission are drawn together. `has_band`: of altitudes, not one."""
    at = even_points(seed, count).T

    def between(probability: Array, asked: bool) -> Array:
        return triangular(probability, -1.0, 0.0, 1.0) if asked else np.zeros(count)

    band = triangular(probabilities(seed, "altitude", BANDS), 0.0, 0.0, doubt.beyond_band if has_band else 0.0)
    columns = (
        at[0] < doubt.other_water_table, between(at[1], doubt.clarity), between(at[2], doubt.lamp_leg),
        triangular(at[3], doubt.floor[0], 1.0, doubt.floor[1]), band[shuffled(seed, "band", count) * BANDS // count],
    )  # fmt: skip
    return [WaterState(*row) for row in zip(*(column.tolist() for column in columns), strict=True)]


@dataclass(frozen=True)
class Waters:
    """A mission's scenes in any state, and at the nodes between which states lie."""

    nodes_of: list[KnownWaters]
    known: dict[tuple[WaterState, bool], list[SceneOptics]] = field(default_factory=dict, repr=False, compare=False)

    @staticmethod
    def of(mission: Mission, scenes: Sequence[SceneOptics]) -> Waters:
        """Of all scenes of a mission."""
        return Waters([KnownWaters(mission, mission.scene_view(index), scene) for index, scene in enumerate(scenes)])

    def left_open_by(self, doubt: Doubt) -> Doubt:
        """A doubt without what no scene leaves open: clarity where no reading tells it, a table where there is but one.

        Else light would be worked out in waters that are all the same.
        """
        known = [nodes for nodes in self.nodes_of if not nodes.scene.paper]
        return doubt.model_copy(update={
            "clarity": doubt.clarity and any(nodes.scene.clarity is not None for nodes in known),
            "other_water_table": doubt.other_water_table if any(other_table(nodes.scene) for nodes in known) else 0.0,
        })  # fmt: skip

    def seen_by(self, mission: Mission, scenes: Sequence[SceneOptics]) -> Waters:
        """The same waters for a mission that asks for other things in these scenes; light that is known is kept."""
        made = Waters.of(mission, scenes)
        for own, other in zip(made.nodes_of, self.nodes_of, strict=True):
            own.known, own.known_columns = other.known, other.known_columns
        for key, known in self.known.items():
            again = [seen_again(one, key[0], scene) for one, scene in zip(known, scenes, strict=True)]
            there = [one for one in again if one is not None]
            if len(there) == len(again):
                made.known[key] = there
        return made

    def at(self, state: WaterState) -> list[SceneOptics]:
        """The scenes in one state."""
        return [nodes.at(state) for nodes in self.nodes_of]

    def kept(self, state: WaterState, *, roughly: bool = False) -> list[SceneOptics]:
        """The same, with the tables that are made of them, for all hardware; `roughly`: see `forward.rough`."""
        key = state, roughly
        if key not in self.known:
            made = self.at(state)
            self.known[key] = [rough(one) for one in made] if roughly else made
        return self.known[key]


class KnownWaters:
    """The waters between which one scene's states lie, each tabulated once, on the scene's own wavelengths."""

    def __init__(self, mission: Mission, view: SceneView, scene: SceneOptics):
        self.mission, self.view, self.scene = mission, view, scene
        self.known: dict[tuple[bool, ClarityEnd, LampLeg], SceneOptics] = {}
        self.known_columns: dict[tuple[bool, ClarityEnd, LampLeg], list[Array]] = {}

    def at(self, state: WaterState) -> SceneOptics:
        """The scene in one state."""
        scene = over_band(self.scene, state.beyond)
        reflectance = np.minimum(scene.reflectance * state.floor, 1.0)
        if scene.paper:
            return replace(scene, reflectance=reflectance, cache={})
        other = state.other_table and other_table(self.scene) is not None
        low, central, high = (self.between(other, leg, state.clarity) for leg in ENDS)
        end = low[1] if state.lamp_leg < 0 else high[1]
        lamp = geometric(central[1], end, abs(state.lamp_leg))
        attenuation, _, daylight, *b = central
        scattering = tuple(
            Scattering(one.name, own, one.table) for one, own in zip(scene.scattering, b, strict=True)
        )
        return replace(
            scene, attenuation_per_m=attenuation, lamp_attenuation_per_m=np.minimum(lamp, attenuation),
            diffuse_attenuation_per_m=None if scene.diffuse_attenuation_per_m is None else daylight,
            lamp_lost=LOST["least" if state.lamp_leg < 0 else "most"] ** abs(state.lamp_leg),
            scattering=scattering, reflectance=reflectance, cache={},
        )  # fmt: skip

    def between(self, other: bool, leg: LampLeg, clarity: float) -> list[Array]:
        """c, K of the lamps' way, K_d and the scattering of each kind, between the ends of a reading."""
        if not clarity:
            return self.columns(other, "central", leg)
        return self.toward(other, leg, "low" if clarity < 0 else "high", abs(clarity))

    def toward(self, other: bool, leg: LampLeg, end: ClarityEnd, share: Array | float) -> list[Array]:
        """The same at so much of the way from the central water to one end of a reading."""
        central = self.columns(other, "central", leg)
        if self.scene.clarity is None:
            return central
        return [geometric(one, last, share) for one, last in zip(central, self.columns(other, end, leg), strict=True)]

    def particles_per_m(self, states: Sequence[WaterState]) -> Array:
        """What particles scatter in each of these states, (n, n_wavelengths); as of the scene in it."""
        scene = self.scene
        made = np.zeros((len(states), len(scene.wavelength_nm)))
        if scene.paper:
            return made + scene.particles_per_m()
        kinds = [OPTICAL + k for k, one in enumerate(scene.scattering) if one.table is not None]
        clarity = np.array([state.clarity for state in states])
        other = np.array([state.other_table for state in states], bool) & (other_table(self.scene) is not None)
        for table, end in product((False, True), TOWARD) if kinds else ():
            mine = np.flatnonzero((other == table) & (np.sign(clarity) == TOWARD[end]))
            if len(mine):
                columns = self.toward(table, "diffuse", end, np.abs(clarity[mine])[:, None])
                made[mine] = sum(columns[k] for k in kinds)
        return made

    def columns(self, other: bool, end: ClarityEnd, leg: LampLeg) -> list[Array]:
        """The same of one known water, on the scene's own wavelengths."""
        key = (other, end, leg)
        if key not in self.known_columns:
            made, grid = self.node(other, end, leg), self.scene.wavelength_nm
            daylight = made.diffuse_attenuation_per_m
            columns = [made.attenuation_per_m, made.lamp_attenuation_per_m]
            columns += [made.attenuation_per_m if daylight is None else daylight]
            columns += [one.scattering_per_m for one in made.scattering]
            self.known_columns[key] = [np.interp(grid, made.wavelength_nm, column) for column in columns]
        return self.known_columns[key]

    def node(self, other: bool, end: ClarityEnd, leg: LampLeg) -> SceneOptics:
        """One known water."""
        key = (other, end, leg)
        if key not in self.known:
            self.known[key] = scene_optics(
                self.view, paper=False, base_dir=self.mission.base_dir, lamp_leg=leg, water_end=end,
                water_table=other_table(self.scene) if other else own_table(self.scene), fineness=self.scene.fineness,
            )  # fmt: skip
        return self.known[key]


def over_band(scene: SceneOptics, beyond: Array | float) -> SceneOptics:
    """A scene whose altitudes go beyond their band by a share of the tolerance; never to the floor itself.

    The swath is there as asked for: what is kept of it in hand is kept for such altitudes. `beyond`: one share, or of
    rows that fly at heights of their own (n,), whose ranges are (n_altitudes, n). Tables of one share are worked out
    once, whatever is asked for in the scene.
    """
    if not np.any(beyond) or not may_leave_band(scene):
        return scene
    cache = scene.cache.setdefault(("beyond its band", float(beyond)), {}) if np.ndim(beyond) == 0 else {}
    nominal = float(scene.range_m[scene.nominal])
    most = 0.5 * (1.0 + nominal / (nominal - float(scene.range_m[0])))
    wider = np.multiply.outer(scene.range_m - nominal, np.minimum(1.0 + np.asarray(beyond), most))
    return replace(as_asked(scene), range_m=nominal + wider, cache=cache)


def seen_again(known: SceneOptics, state: WaterState, scene: SceneOptics) -> SceneOptics | None:
    """One state of a scene, asked for what is asked in a scene; None where that is about other water or heights."""
    seen = seen_anew(known, scene.view)
    if seen is None or (state.beyond and may_leave_band(known) != may_leave_band(seen)):
        return None
    return as_asked(seen) if state.beyond and may_leave_band(seen) else seen


def as_asked(scene: SceneOptics) -> SceneOptics:
    """A scene with nothing kept in hand of the swath: that is for altitudes beyond the band."""
    return without_reserve(scene, "min_swath_m", "min_common_swath_m")


def over_band_of(problem: Problem, beyond: Array | float) -> Problem:
    """A problem whose vehicle leaves its band of altitudes so far in every scene; of each camera (n,), or of all."""
    return problem.over_bands([over_band(scene, beyond) for scene in problem.scenes]) if np.any(beyond) else problem


def may_leave_band(scene: SceneOptics) -> bool:
    """Whether there is a band of altitudes that is kept by steering; else it says where targets are, or none is."""
    moves = scene.view.vehicle.speed_m_s > 0.0
    return len(scene.range_m) > 1 and moves and scene.view.scene.target != "mid_water"

"""A panel: one problem that is no harder than most scenarios, searched once for all hardware.

Hardware is better than the best known one only if its objective is less in half of the scenarios. In the scenarios in
which the water is no clearer than a panel's, and no number of its parts more favourable than there, its objective is no
less than in the panel. Where those are too many to leave half of all, the panel's value bounds its median. Likewise,
what fails in a panel as favourable as the worst tenth of the scenarios does not hold in nine of ten.

Of a set of scenarios the panel's water has the least attenuation and scattering of all, at each wavelength, and the
brightest floor. Parts are at the favourable ends of what is uncertain, both ends where that depends on the design;
what a camera draws, costs or weighs is at a quantile of its own, as adverse as the count of its scenarios allows. A
light that is brighter than in a scenario must not be too bright: exposures may be as short as is wanted there, the iris
as far closed or flashes as faint, and colours as unlike.

Lenses stand where they ask for the least f-number, in bounds where they do in each scenario, and the vehicle keeps
within the narrowest band. That no focus serves better is argued, not proven: one farther off takes in a little more
light, and of several scenes with a motorised lens another may serve.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, fields, replace
from itertools import product
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.parts.doubts import doubtful, taken_as
from uwopt.catalog.parts.kinds import FAVOURED
from uwopt.catalog.records import Camera, Lens, Light, exact
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.forward.scene import Made, SceneOptics
from uwopt.forward.waters_beside import WatersBeside
from uwopt.model.beam import Beam, half_power_angle_rad
from uwopt.model.scattering import PhaseTable
from uwopt.objectives.objective import Objective
from uwopt.solvers.confidence.draws import drawn_facts
from uwopt.solvers.confidence.scenarios import Scenarios, loss
from uwopt.solvers.one_hardware import with_either_end

STEEP = {
    "power": ("power_w", "host_power_w", "wake_up_s", "standby_w", "output_factor", "flux_lm"),
    "cost": ("price", "host_price"), "mass": ("mass_g",),
}  # fmt: skip
OF_WATER, OF_LIGHT = 0.8, 0.61  # of the scenarios, where numbers of lights and cameras take the rest
BANDS = 2  # of K and of what the water takes, among scenarios that share one water in bounds
QUANTILES = np.linspace(0.5, 1.0, 26)
SHORTER = 1e-3  # exposures than the shortest that may be set
CLOSED = 4.0  # f-numbers beyond the ring's last


@dataclass(frozen=True)
class Panel:
    """A problem that is no harder than `covered` of the scenarios at least, whatever the hardware."""

    problem: Problem
    covered: int


def least_covered(count: int, share: float) -> int:
    """Of so many scenarios, how many must be lost so that fewer than a share of them is left."""
    return count - int(np.ceil(share * count - 1e-9)) + 1


def panel_of(base: Problem, scenarios: Scenarios, objective: Objective, covered: int) -> Panel:
    """The panel that is no harder than so many of the scenarios."""
    names = steep_of(objective) if scenarios.doubt.parts and scenarios.is_drawn else ()
    names = names if covered > scenarios.count // 3 else ()  # of few, the water takes all
    count, parts = scenarios.count, base.parts
    known = [{name for part in some for name, _ in doubtful(part)} for some in (parts.lights, parts.cameras)]
    of_lights, of_cameras = (not one.isdisjoint(names) for one in known)
    water = most_adverse(scenarios, max(covered, int(OF_WATER * count) if of_lights or of_cameras else 0))
    lights, seen_by, iris = [], [], may_close(base)
    for light in parts.lights:
        most = max(covered, int(OF_LIGHT * count) if of_cameras else 0)
        made, mask = adverse(light, scenarios, names, water[None, :], most)
        lights.append(eased_light(scenarios.favoured_light(made), iris=iris))
        seen_by.append(water & mask)
    beside = np.unique(np.array(seen_by), axis=0)
    cameras, least = [], count
    for camera in parts.cameras:
        made, mask = adverse(camera, scenarios, names, beside, covered)
        cameras.append(eased_camera(scenarios.favoured(made)))
        least = min(least, int((beside & mask).sum(axis=1).min()))
    made_parts = Parts(
        tuple(cameras),
        tuple(eased_lens(scenarios.favoured(part), iris=iris) for part in parts.lenses),
        tuple(one for part in parts.ports for one in with_either_end(scenarios.favoured(part))),
        tuple(lights),
    )
    scenes = [scenarios.scenes[int(k)] for k in np.flatnonzero(water)]
    problem = base.over(made_parts, mission=base.mission.with_changes(fixed={}), scenes=best_scenes(scenes))
    return Panel(problem, least)


def steep_of(objective: Objective) -> tuple[str, ...]:
    """Numbers of a camera or a light on which the objective depends most."""
    return tuple(name for figure, names in STEEP.items() if objective.weight(figure) for name in names)


def adverse(
    part: Any, scenarios: Scenarios, names: Sequence[str], beside: Array, covered: int
) -> tuple[Any, Array]:  # fmt: skip
    """A part whose numbers of these names are known to be as adverse as may be; and the scenarios that are no better.

    They stand at the least favourable quantile, the same of each, that leaves so many scenarios of each set beside.
    """
    facts = drawn_facts(part, scenarios.seed, scenarios.count) if names else {}
    mine = {name: FAVOURED[name] * values for name, values in facts.items() if name in names}
    if not mine:
        return part, np.ones(scenarios.count, bool)
    for share in QUANTILES:
        ends = {name: np.quantile(values, share, method="higher") for name, values in mine.items()}
        mask = np.logical_and.reduce([values <= ends[name] for name, values in mine.items()])
        if (beside & mask).sum(axis=1).min() >= covered:
            break
    known = dict(doubtful(part))
    numbers = {name: taken_as(name, known[name], float(FAVOURED[name] * end)) for name, end in ends.items()}
    return replace(part, **numbers), np.asarray(mask)


def eased_camera(camera: Camera) -> Camera:
    """A camera that is never too slow to close."""
    shortest = camera.min_exposure_us
    if shortest is None:
        return camera
    return replace(camera, min_exposure_us=exact(shortest.value * SHORTER, shortest.status, shortest.source))


def may_close(problem: Problem) -> bool:
    """Whether an iris that is closed too far costs nothing but light: no sharpness is asked for."""
    return not any(scene.view.requirements.asks_sharpness for scene in problem.scenes)


def eased_lens(lens: Lens, *, iris: bool) -> Lens:
    """A lens that can be closed as far as is wanted, where that takes too bright a flash back."""
    most = lens.f_number_max
    return lens if most is None or not iris else replace(lens, f_number_max=exact(most.value * CLOSED, most.status))


def eased_light(light: Light, *, iris: bool) -> Light:
    """A lamp that is never too bright: its pulses as short as is wanted, a flash as faint unless the iris may close."""
    if light.kind == "flash":
        return light if iris else replace(light, dim_levels=None, dim_min_frac=0.0)
    shortest = light.min_pulse_us
    if shortest is None:
        return light
    return replace(light, min_pulse_us=exact(shortest.value * SHORTER, shortest.status, shortest.source))


def best_scenes(states: Sequence[Sequence[SceneOptics]]) -> list[SceneOptics]:
    """Of each scene of a mission one that is no harder than in any of these states; no rule on colours holds there."""
    return [best_scene(scenes) for scenes in zip(*states, strict=True)]


@dataclass(frozen=True)
class EasiestScene(SceneOptics):
    """Water that is no harder than in any of some states, light that is scattered more than once included; without sun.

    K of the lamps' way is the least of all. Veils count by what they are beside the signal, which by the way to the
    camera grows as exp((c - K_near) d): K_near leaves the least c - K_near of all, and nothing comes from elsewhere on
    the floor. What the water sends back goes by
    exp((c - K_back) d + (K_lamp - K_back) l): K_back leaves no more of either than any state.
    """

    states: tuple[SceneOptics, ...] = ()

    def of_all(self, what: Hashable, make: Callable[[], Made]) -> Made:
        """What is of all states, worked out when first asked for."""
        return self.once(("of all states", what), make)

    @property
    def beside(self) -> WatersBeside:
        """All states side by side."""
        return self.of_all("waters beside", lambda: WatersBeside.of(self.states))

    def lamp_leg_per_m(self, half_power_angle_rad: float) -> Array:
        """The least of all states."""
        what = "lamp leg", half_power_angle_rad
        return self.of_all(what, lambda: least(self.lamp_legs_per_m(half_power_angle_rad)))

    def lamp_legs_per_m(self, half_power_angle_rad: float) -> Array:
        """Of each state, (n_states, n_wavelengths)."""
        return self.of_all(
            ("lamp legs", half_power_angle_rad),
            lambda: np.stack([one.lamp_leg_per_m(half_power_angle_rad) for one in self.states]),
        )

    def widened_lobe(self, lobe: Beam, relative_spectrum: Array, *, way_m: float, back: bool = False) -> Beam:
        """At every angle the most of all states on the floor, and the least of what the water sends back.

        A lobe stands beside its own K. On a level floor, to which no way is shorter, what K of a state takes beyond the
        least of all in every colour is taken from its lobe.
        """
        half_power, weights = half_power_angle_rad(lobe), np.ones(len(self.states))
        legs = self.lamp_legs_per_m(half_power)
        if not back and not self.slope:
            weights = np.exp(-(legs - self.lamp_leg_per_m(half_power)).min(axis=1) * way_m)
        return self.beside.bounding_lobe(
            lobe, relative_spectrum, legs, way_m=way_m, back=back, weights=weights.tolist()
        )

    def sent_back(self, relative_spectrum: Array, range_m: float) -> tuple[PhaseTable | None, ...]:
        """At every angle the least of all states."""
        return self.beside.least_sent_back(relative_spectrum, range_m)

    def near_leg_per_m(self) -> Array:
        """What leaves the least veil beside the image."""
        return self.of_all("near leg", lambda: self.attenuation_per_m - least(
            [one.attenuation_per_m - one.near_leg_per_m() for one in self.states]
        ))  # fmt: skip

    def veil_leg_per_m(self, way_m: float) -> Array:
        """No veil from elsewhere."""
        return self.near_leg_per_m()

    def particles_per_m(self) -> Array:
        """What shows most detail in the veil that there is: the most of all states and colours."""
        return np.full_like(self.wavelength_nm, max(float(one.particles_per_m().max()) for one in self.states))

    def back_leg_per_m(self, half_power_angle_rad: float) -> Array:
        """What leaves the least backscatter beside the image, by either leg."""

        def made() -> Array:
            back = [one.back_leg_per_m(half_power_angle_rad) for one in self.states]
            camera = least([one.attenuation_per_m - k for one, k in zip(self.states, back, strict=True)])
            lamp = least(self.lamp_legs_per_m(half_power_angle_rad) - np.stack(back))
            return np.maximum(self.attenuation_per_m - camera, self.lamp_leg_per_m(half_power_angle_rad) - lamp)

        return self.of_all(("back leg", half_power_angle_rad), made)


def least(columns: Sequence[Array] | Array) -> Array:
    """The least of some spectra, wavelength by wavelength."""
    return np.asarray(np.min(columns, axis=0))


def best_scene(scenes: Sequence[SceneOptics]) -> SceneOptics:
    """The same of one scene.

    Attenuation is the least of each leg by K and by what c has beyond K, which is what forward scattering sends to the
    camera beside the image: signal is no less than in any of them, and no veil is more, in relation to it.
    """
    first = min(scenes, key=lambda one: float(np.ptp(one.range_m)))  # what holds beyond a band holds within
    lamp = least([one.lamp_attenuation_per_m for one in scenes])
    beyond = least([one.attenuation_per_m - one.lamp_attenuation_per_m for one in scenes])
    scattering = tuple(
        replace(kind, scattering_per_m=least([one.scattering[k].scattering_per_m for one in scenes]))
        for k, kind in enumerate(first.scattering)
    )
    needs = first.view.requirements.model_copy(update={"max_white_balance": None})
    of_first: dict[str, Any] = {one.name: getattr(first, one.name) for one in fields(SceneOptics)}
    easiest: dict[str, Any] = dict(
        attenuation_per_m=lamp + beyond, lamp_attenuation_per_m=lamp, scattering=scattering,
        reflectance=np.max([one.reflectance for one in scenes], axis=0),
        view=replace(first.view, requirements=needs), cache={}, states=tuple(scenes),
    )  # fmt: skip
    return EasiestScene(**of_first | easiest)


def most_adverse(scenarios: Scenarios, count: int) -> Array:
    """So many scenarios, as a mask, of which the best water takes much of the light.

    Looked for among those of one table or any, within bands of K, which differ least from each other.
    """
    taken = scenarios.loss
    leg = np.array([state.lamp_leg for state in scenarios.states])
    table = np.array([state.other_table for state in scenarios.states])
    rank = np.argsort(np.argsort(leg, kind="stable")) / scenarios.count
    best, most = np.argsort(taken, kind="stable")[-count:], -np.inf
    for within in (table | True, table, ~table):
        for low, high in product((0.0, 0.1, 0.25, 0.5, 0.75), (0.25, 0.5, 0.75, 0.9, 1.0)):
            mine = np.flatnonzero(within & (rank >= low) & (rank < high))
            if len(mine) < count:
                continue
            mine = mine[np.argsort(taken[mine], kind="stable")[-count:]]
            if (value := sum(map(loss, best_scenes([scenarios.scenes[int(k)] for k in mine])))) > most:
                best, most = mine, value
    return np.isin(np.arange(scenarios.count), best)


@dataclass(frozen=True)
class Anchor:
    """Scenarios of like water, one water that is no harder than any of them, and how much less light they see at most.

    `share` : by scene, of the light in that water, (n_scenarios, n_altitudes)
    """

    scenarios: Array  # their places
    scenes: list[SceneOptics]
    share: list[Array]


def anchors_of(base: Problem, scenarios: Scenarios) -> list[Anchor]:
    """All scenarios in groups of like water, the worst first: one table, one band of K, one of what the water takes.

    Each group asks for light of its own in every image: where no reading is in doubt, two tables are groups enough.
    """
    states, taken = scenarios.states, scenarios.loss
    groups = [np.arange(scenarios.count)]
    if not base.paper:
        table = np.array([state.other_table for state in states])
        groups = [np.flatnonzero(table == one) for one in np.unique(table)]
        has_reading = any(state.clarity for state in states)
        if has_reading or len(groups) == 1:
            groups = split(groups, np.array([state.lamp_leg for state in states]), BANDS)
        if has_reading:
            groups = split(groups, taken, BANDS)
    groups.sort(key=lambda mine: -float(taken[mine].mean()))
    return [anchored(base, scenarios, np.sort(mine)) for mine in groups]


def split(groups: list[Array], number: Array, most: int) -> list[Array]:
    """Each group in so many by a number, of as many each; what is equal stays together."""
    made = []
    for mine in groups:
        values = number[mine]
        edges = np.unique(np.quantile(values, np.linspace(0.0, 1.0, most + 1)[1:-1], method="higher"))
        place = np.searchsorted(edges, values, side="right" if len(np.unique(values)) <= most else "left")
        made += [mine[place == one] for one in np.unique(place)]
    return made


def anchored(base: Problem, scenarios: Scenarios, mine: Array) -> Anchor:
    """The anchor of some scenarios."""
    scenes = best_scenes([scenarios.scenes[int(k)] for k in mine])
    share = []
    for index, best in enumerate(scenes):
        camera_m = np.array([base.nearest_m(index, altitude) for altitude in range(len(best.range_m))])
        lamp_m = base.lowest_m(index) + best.altitude_m - best.altitude_m[0]
        own = [scenarios.scenes[int(k)][index] for k in mine]
        share.append(np.array([most_light(one, best, camera_m, lamp_m) for one in own]))
    return Anchor(mine, scenes, share)


def most_light(scene: SceneOptics, best: SceneOptics, camera_m: Array, lamp_m: Array) -> Array:
    """How much of the light that a clearer water lets through arrives at most, by altitude.

        max over lambda of R / R_best exp(-(c - c_best) d - (K - K_best) l)

    d, l : no way to the camera and none from a lamp is shorter; where light scattered more than once counts, K depends
    on the lobe and is left out: it is no less than K_best
    """
    fall = np.outer(camera_m, scene.attenuation_per_m - best.attenuation_per_m)
    if not scene.counts_orders:
        fall = fall + np.outer(lamp_m, scene.lamp_attenuation_per_m - best.lamp_attenuation_per_m)
    share = np.exp(-fall) * scene.reflectance / np.maximum(best.reflectance, 1e-12)
    return np.asarray(np.minimum(share.max(axis=1), 1.0))

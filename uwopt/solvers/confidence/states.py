"""Hardware in all scenarios at once: all states of its parts as one small catalogue.

What is dear is shared: parts are drawn once each, what cameras see through a port is worked out once whatever lights
stand beside, light is integrated once an image, and settings are solved row by row.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.records import Camera, Part
from uwopt.deadline import NEVER, Deadline, OutOfTimeError
from uwopt.forward.part_columns import FLASH
from uwopt.forward.parts import Parts
from uwopt.forward.problem import MeantFocus, Problem
from uwopt.forward.scene import DESIGN_WAVELENGTH_NM, SceneOptics
from uwopt.forward.scene_rows import SceneRows
from uwopt.forward.setting_rows import of_fewest_pixels
from uwopt.forward.sharpness import SharpRows
from uwopt.forward.spectra import TINY
from uwopt.objectives.objective import Objective
from uwopt.solvers.confidence.panels import CLOSED, SHORTER, Anchor, may_close
from uwopt.solvers.confidence.response import (
    WaterResponse,
    in_light,
    of_deciding_pixels,
    through_band,
    waters_of,
)
from uwopt.solvers.confidence.scenarios import SAME_FIELD, Scenarios
from uwopt.solvers.confidence.sealed_focus import meant_foci_m
from uwopt.solvers.confidence.waters import may_leave_band, over_band_of
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.design_rows import Narrowed, NodeRows
from uwopt.solvers.exact.imager_rules import Behind, Tally
from uwopt.solvers.exact.imagers import (
    Imagers,
    PortBlock,
    housed,
    imagers_in,
    joined,
    no_tally,
    sharp_behind,
)
from uwopt.solvers.exact.lightings import Under
from uwopt.solvers.exact.ranking import Found


@dataclass(frozen=True)
class States:
    """The states of the parts of one kind, part after part, and where those of each hardware's part begin."""

    parts: list[Any]
    begin: Array

    @staticmethod
    def of(parts: Sequence[Part], drawn: Callable[[Any], list[Any]]) -> States:
        """Each part's once, whatever hardware it stands in."""
        every: list[Any] = []
        at: dict[int, int] = {}
        for part in parts:
            if id(part) not in at:
                at[id(part)] = len(every)
                every += drawn(part)
        return States(every, np.array([at[id(part)] for part in parts]))


@dataclass(frozen=True)
class Together:
    """Hardware in scenarios, as imagers that pass the rules without light.

    `hardware`, `scenario`, `light`, `count`, `mount` : of each imager, (n,): the place of the light among those of all
        scenarios, the number of lamps and the place of their mount
    `lost` : by hardware, rules that no setting can mend, with how many scenarios each is the first to discard; empty
        where several views share a port
    `meant_m` : by hardware, where its lens is meant to be focused in the first scene's water; nan: where it is best
    """

    problem: Problem
    scenarios: Scenarios
    found: Sequence[Found]
    imagers: Imagers
    hardware: Array
    scenario: Array
    light: Array
    count: Array
    mount: Array
    lost: list[dict[str, int]]
    meant_m: Array

    @staticmethod
    def of(base: Problem, found: Sequence[Found], scenarios: Scenarios, *, in_focus: bool = False) -> Together:
        """All states of the parts of hardware.

        in_focus : as if each lens stood where it is best in each scenario, which no focus betters that is set before
        """
        own = [base.parts.of(one) for one in found]
        cameras, lenses = (States.of([one[kind] for one in own], scenarios.each) for kind in ("camera", "lens"))
        ports = States.of([one["port"] for one in own], scenarios.ports)
        lights = States.of([one["light"] for one in own], scenarios.lights)
        mounts = list(dict.fromkeys(one.lighting.mount for one in found))
        counts = np.array([one.count for one in found])
        problem = base.over(
            Parts(tuple(cameras.parts), tuple(lenses.parts), tuple(ports.parts), tuple(lights.parts)),
            counts=(int(counts.min()), int(counts.max())), mounts=mounts, have_estimates=True,
        )  # fmt: skip
        meant_m = np.full(len(found), np.nan) if in_focus else meant_foci_m(base, found, scenarios)
        if not in_focus:
            problem = problem.focused_at(np.tile(scenarios.focus, len(cameras.parts) // scenarios.count))
        landscape = np.array([one.landscape for one in found], int)
        views, first, view_of = np.unique(
            np.stack([landscape, ports.begin, cameras.begin, lenses.begin], axis=1), axis=0,
            return_index=True, return_inverse=True,
        )  # fmt: skip
        view_of = view_of.ravel()
        beyond = np.tile([state.beyond for state in scenarios.states], len(cameras.parts) // scenarios.count)
        blocks: list[PortBlock] = []
        lost: list[dict[str, int]] = [{} for _ in views]
        for orientation, port in np.unique(views[:, :2], axis=0):
            mine = np.flatnonzero((views[:, 0] == orientation) & (views[:, 1] == port))
            aimed = problem if in_focus else problem.focused_on(by_pair(views[mine], meant_m[first[mine]], scenarios))
            tally, seen = no_tally(), over_band_of(aimed, beyond)
            made: dict[int, PortBlock] = {}
            for states in different(scenarios, problem, int(port)):
                which = np.concatenate(list(states.values()))
                camera, lens = (np.add.outer(views[mine, k], which).ravel() for k in (2, 3))
                behind = Behind(camera, lens, np.array([next(iter(states))]), bool(orientation))
                made |= behind_states(seen, behind, states, tally, scenarios.count)
            blocks += [made[state] for state in sorted(made)]
            if len(mine) == 1:
                lost[mine[0]] = dict(Counter({rule: n for rule, n in tally.discarded.items() if n}).most_common())
        imagers = joined(problem, blocks, Tally())
        rows, hardware = each_with_its_view(whose(imagers, views, scenarios.count), view_of)
        imagers = imagers.take(rows)
        scenario = imagers.camera % scenarios.count
        mount = np.array([mounts.index(one.lighting.mount) for one in found])
        return Together(
            problem, scenarios, found, imagers, hardware, scenario, lights.begin[hardware] + scenario,
            counts[hardware], mount[hardware], [lost[view] for view in view_of], meant_m,
        )  # fmt: skip

    def rows(self, objective: Objective, deadline: Deadline) -> list[SceneRows]:
        """The settings' view of all imagers, by scene of the mission.

        The light of each is worked out in the water as it is known, and scaled as one of its image changes with the
        water.
        """
        as_known = self.scenarios.lit_in(self.problem)
        known = self._beyond(self._lit(as_known, objective, deadline), objective)
        states = [self.scenarios.states[k] for k in self.scenario]
        responses = self._responses(objective, deadline)
        made = []
        for index, rows in enumerate(known):
            seen = []
            for response, hardware in responses:
                mine = np.flatnonzero(np.isin(self.hardware, hardware))
                seen.append((mine, response.seen_in(index, rows.take(mine), [states[k] for k in mine])))
            whole = seen[0][1] if len(seen) == 1 else SceneRows.in_places(seen, len(self.scenario))
            made.append(of_fewest_pixels(self._shown(index, whole), unlit=self.problem.are_unlit(self.light)))
        return made

    def _shown(self, index: int, rows: SceneRows) -> SceneRows:
        """Rows with the detail that each scenario's particles show in the veil.

        By what they scatter of green light over what is scattered in the water as it is known; no more than they
        scatter of any colour, which bounds take.
        """
        if rows.sharp is None or rows.sharp.detail is None:
            return rows
        scene, which = self.problem.scenes[index], np.unique(self.scenario)
        waters, states = self.scenarios.waters.nodes_of[index], self.scenarios.states
        every = waters.particles_per_m([states[int(k)] for k in which])
        green, known = (
            np.array([np.interp(DESIGN_WAVELENGTH_NM, scene.wavelength_nm, one) for one in some])
            for some in (every, [scene.particles_per_m()])
        )
        place = np.searchsorted(which, self.scenario)
        seen = np.maximum(rows.sharp.detail.scattered[:, 1] / scene.range_m[scene.nominal], TINY)
        most = every.max(axis=1)[place] / seen
        ratio = np.minimum(green[place] / np.maximum(known, TINY), most)
        return replace(rows, sharp=replace(rows.sharp, detail=rows.sharp.detail.hazier(ratio)))

    def only(self, rows: Array) -> Together:
        """These imagers alone."""
        return replace(
            self, imagers=self.imagers.take(rows), hardware=self.hardware[rows], scenario=self.scenario[rows],
            light=self.light[rows], count=self.count[rows], mount=self.mount[rows],
        )  # fmt: skip

    def bounded_rows(self, objective: Objective, anchor: Anchor, deadline: Deadline) -> list[SceneRows]:
        """Rows with no less light than in each scenario, by a water that is no harder; none is too bright there."""
        rows_in = self._lit(self.problem.in_scenes(anchor.scenes), objective, deadline)
        place = np.searchsorted(anchor.scenarios, self.scenario)
        iris = may_close(self.problem)
        return [eased(dimmed(rows, anchor.share[k][place]), iris=iris) for k, rows in enumerate(rows_in)]

    def _lit(
        self, problem: Problem, objective: Objective, deadline: Deadline,
        narrowed: Narrowed | None = of_deciding_pixels, *, light_alone: bool = False,
    ) -> list[SceneRows]:  # fmt: skip
        """Rows in the light of some water, by scene, each under its own light."""
        made, every = node_rows(problem, self.imagers, objective, deadline, narrowed), np.arange(len(self.scenario))
        lights = made.tables.in_scenes(self.under, every)
        return made.rows(every, lights, self.light, self.count, self.under, light_alone=light_alone)

    @property
    def under(self) -> Under:
        """The lighting of each imager."""
        return Under.at(self.problem, self.problem.lights.optics_index[self.light], self.mount)

    def _beyond(self, known: list[SceneRows], objective: Objective) -> list[SceneRows]:
        """Rows as the altitudes of each scenario have them, by the light over the band as it is asked."""
        beyond = np.array([state.beyond for state in self.scenarios.states])[self.scenario]
        if not beyond.any():
            return known
        scenes = self.problem.scenes
        made = [
            over_wider_band(rows, beyond) if may_leave_band(scene) else rows
            for rows, scene in zip(known, scenes, strict=True)
        ]
        if all(rows.sharp is None for rows in known):
            return made
        sharp: list[list[tuple[Array, Any]]] = [[] for _ in known]
        for band in np.unique(beyond):
            over = node_rows(over_band_of(self.problem, float(band)), self.imagers, objective, NEVER)
            mine = np.flatnonzero(beyond == band)
            for index, places in enumerate(sharp):
                places.append((mine, over.sharp(index, mine, self.under.take(mine))))
        return [
            replace(rows, sharp=None if rows.sharp is None else SharpRows.in_places(places, len(beyond)))
            for rows, places in zip(made, sharp, strict=True)
        ]

    def _responses(self, objective: Objective, deadline: Deadline) -> list[tuple[WaterResponse, list[int]]]:
        """How the light of images changes with the water, each with its hardware.

        The first state of parts stands for all. Those not known yet are worked out together.
        """
        known = self.scenarios.responses
        hardware, first = np.unique(self.hardware, return_index=True)
        of: dict[Any, list[int]] = {}
        row_of: dict[Any, int] = {}
        for h, row in zip(hardware.tolist(), first.tolist(), strict=True):
            key = self._image_key(row)
            of.setdefault(key, []).append(h)
            row_of.setdefault(key, row)
        missing = [key for key in of if key not in known]
        alone = self.only(np.array([row_of[key] for key in missing], int))
        waters, states, began_s = self.scenarios.waters, self.scenarios.all_states, deadline.left_s
        rest = count(1)

        def reference(scenes: list[SceneOptics]) -> list[SceneRows]:
            deadline.check()
            made = alone._lit(self.problem.in_scenes(scenes), objective, deadline, None, light_alone=True)
            is_first = next(rest) == 1 and len(missing) > 1 and math.isfinite(began_s)
            if is_first and (began_s - deadline.left_s) * waters_of(states) > began_s:
                raise OutOfTimeError  # soon: there may be time for some of them
            return made

        if missing:
            made = WaterResponse.of_each(waters, states, reference, len(missing))
            known.update(zip(missing, made, strict=True))
        return [(known[key], own) for key, own in of.items()]

    def _image_key(self, row: int) -> tuple[Any, ...]:
        """What tells images apart whose light changes differently with the water.

        Lamps on one side or on both: how many stand there changes how much light there is, not how far it goes.
        """
        problem, found = self.problem, self.found[self.hardware[row]]
        camera, port = problem.parts.cameras[self.imagers.camera[row]], problem.parts.ports[self.imagers.port[row]]
        columns = tuple((scene.channels, scene.pixels) for scene in problem.scenes)  # of light, that are asked for
        colours = (self.scenarios.nodes, columns), colours_of(camera)
        if self.scenarios.rough:
            return colours
        ends = (*colours, port.geometry, found.lighting.mount, min(found.count, 2), found.lighting.optics)
        fields_seen = [
            round(float(np.log(tangent[row])) / SAME_FIELD)
            for seen in self.imagers.scenes
            for tangent in (seen.view.tan_along, seen.view.tan_across)
        ]
        return (*ends, tuple(camera.qe_curves.values()), *fields_seen)


def colours_of(camera: Camera) -> tuple[str, ...]:
    """The colours that a camera tells apart."""
    return tuple(sorted(camera.qe_curves))


def imagers_among(problem: Problem, found: Sequence[Found], landscape: bool) -> Imagers:
    """The imagers of this hardware, by places in the problem's lists, in one orientation."""
    asked = []
    for port in sorted({one.port for one in found}):
        camera, lens = np.array(sorted({(one.camera, one.lens) for one in found if one.port == port})).T
        asked.append(Behind(camera, lens, np.array([port]), landscape))
    return imagers_in(problem, asked)


def by_pair(views: Array, meant_m: Array, scenarios: Scenarios) -> MeantFocus:
    """Where lenses are meant to be focused, from places among the states of cameras and lenses behind one port."""
    count = scenarios.count
    camera, lens = views[:, 2] // count, views[:, 3] // count
    table = np.full((int(camera.max()) + 1, int(lens.max()) + 1), np.nan)
    table[camera, lens] = meant_m
    return lambda cameras, lenses: table[cameras // count, lenses // count]


def different(scenarios: Scenarios, problem: Problem, begin: int) -> Iterator[dict[int, Array]]:
    """The states of a port that share their optics: by place, with their scenarios."""
    parts = problem.parts.ports
    states = [parts[begin + state] for state in range(int(scenarios.port.max()) + 1)]
    first = {id(part): begin + state for state, part in reversed(list(enumerate(states)))}
    of = np.array([first[id(part)] for part in states])[scenarios.port]
    like = problem.like_port[of]
    for optics in np.unique(like):
        yield {int(state): np.flatnonzero(of == state) for state in np.unique(of[like == optics])}


def behind_states(
    problem: Problem, behind: Behind, states: dict[int, Array], tally: Tally, count: int
) -> Iterator[tuple[int, PortBlock]]:
    """Cameras with lenses, each in one of so many scenarios, behind that state of a port which stands there.

    behind : one of the states, as all are for what is seen and what goes together
    """
    sharp = sharp_behind(problem, behind, tally)
    for state, which in states.items():
        own = sharp if len(states) == 1 else sharp.take(np.isin(sharp.camera % count, which))
        at_state = replace(behind, ports=np.array([state]))
        if len(own.camera) and (block := housed(problem, own, at_state, tally)) is not None:
            yield state, block


def over_wider_band(rows: SceneRows, beyond: Array) -> SceneRows:
    """Rows whose light is that at altitudes beyond the band, each by its own share of the tolerance, (n,).

    Logarithms of the light over the altitudes of the band go on as the polynomial through all of them.
    """
    count = rows.signal_e.shape[1]
    if count == 1:
        return rows
    weight = through_band(count, (1.0 + beyond)[:, None] * np.linspace(-1.0, 1.0, count))  # (n, altitude, node)

    def wider(column: Array) -> Array:
        seen = (column > 0.0).all(axis=1, keepdims=True)
        beyond_it = np.exp(np.einsum("nak,nk...->na...", weight, np.log(np.where(seen, column, 1.0))))
        return np.where(seen, beyond_it, column) if column.shape[1] == count else column

    return in_light(rows, wider)


def whose(imagers: Imagers, views: Array, count: int) -> Array:
    """Which view each imager is of, by its orientation and the states of port, camera and lens, (n_views, 4)."""
    starts = np.unique(views[:, 1])
    port = starts[np.searchsorted(starts, imagers.port, side="right") - 1] if len(imagers) else imagers.port
    own = (imagers.landscape, port, imagers.camera // count, imagers.lens // count)
    theirs = (views[:, 0], views[:, 1], views[:, 2] // count, views[:, 3] // count)
    seen, wanted = np.zeros(len(imagers), int), np.zeros(len(views), int)
    for ours, their in zip(own, theirs, strict=True):
        size = int(their.max()) + 1
        seen, wanted = seen * size + ours, wanted * size + their
    order = np.argsort(wanted)
    return np.asarray(order[np.searchsorted(wanted[order], seen)])


def each_with_its_view(view: Array, view_of: Array) -> tuple[Array, Array]:
    """The rows of each hardware's view, one hardware after another, and whose each is."""
    order = np.argsort(view, kind="stable")
    begin, end = (np.searchsorted(view[order], view_of, side=side) for side in ("left", "right"))
    rows = [order[low:high] for low, high in zip(begin, end, strict=True)]
    return np.concatenate(rows), np.repeat(np.arange(len(view_of)), end - begin)


def dimmed(rows: SceneRows, share: Array) -> SceneRows:
    """Rows with so much of their light and their veils, (n, n_altitudes)."""
    return in_light(rows, lambda column: column * share.reshape(*share.shape, *([1] * (column.ndim - 2))))


def eased(rows: SceneRows, *, iris: bool) -> SceneRows:
    """Rows in which no light is too bright: times as short as is wanted, the iris as far closed or flashes as faint."""
    flash = rows.kind == FLASH
    made = replace(
        rows, time_min_s=np.where(flash, rows.time_min_s, SHORTER * rows.time_min_s),
        min_exposure_s=SHORTER * rows.min_exposure_s,
    )  # fmt: skip
    if iris:
        return replace(made, n_high=CLOSED * rows.n_high)
    return replace(made, dims_freely=rows.dims_freely | flash, min_level=np.where(flash, 0.0, rows.min_level))


def node_rows(
    problem: Problem, imagers: Imagers, objective: Objective, deadline: Deadline, narrowed: Narrowed | None = None
) -> NodeRows:
    """What makes rows of these imagers under any lighting; `narrowed`: of each image, the pixels that count."""
    none = np.zeros(len(problem.parts.lights), bool)  # bounds of lights are not asked for
    return NodeRows(problem, objective, Bounds.of(problem, objective, imagers, lights=none), deadline, narrowed)

"""Hardware of one light in all scenarios at once: all states of its parts as one small catalogue.

Hardware that differs in camera, lens or port alone, with as many lamps of one light at one mount, shares most of what
is dear: parts are drawn once each, light is integrated once an image, and settings are solved row by row.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwopt.catalog.records import Light, Part
from uwopt.deadline import Deadline
from uwopt.forward.part_columns import FLASH
from uwopt.forward.problem import Problem
from uwopt.forward.scene import SceneOptics
from uwopt.forward.setting_rows import SceneRows
from uwopt.forward.sharpness import SharpRows
from uwopt.objectives.objective import Objective
from uwopt.solvers.confidence.panels import CLOSED, SHORTER, Anchor, may_close
from uwopt.solvers.confidence.response import LIT, VEILED, WaterResponse, of_deciding_pixels
from uwopt.solvers.confidence.scenarios import Scenarios
from uwopt.solvers.confidence.waters import over_band
from uwopt.solvers.exact.imagers import IMAGER_RULES, Imagers, imagers_behind, joined
from uwopt.solvers.exact.light_tables import Lighting, lightings
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.explain.one_hardware import parts_of, problem_of

Array = NDArray[Any]
SAME_FIELD = 0.02  # of the logarithm of a field's tangent


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

    `hardware`, `scenario` : of each imager, (n,)
    `lost` : by hardware, rules that no setting can mend, with how many scenarios each is the first to discard; empty
        where ports are shared
    """

    problem: Problem
    scenarios: Scenarios
    found: Sequence[Found]
    imagers: Imagers
    hardware: Array
    scenario: Array
    lost: list[dict[str, int]]

    @staticmethod
    def of(base: Problem, found: Sequence[Found], scenarios: Scenarios) -> Together:
        """All states of the parts of hardware that has one light, so many lamps, one mount and orientation."""
        own = [dict(parts_of(base, one)) for one in found]
        cameras, lenses = (States.of([one[kind] for one in own], scenarios.each) for kind in ("camera", "lens"))
        ports = States.of([one["port"] for one in own], scenarios.ports)
        light = own[0]["light"]
        assert isinstance(light, Light)
        lists = {"camera": cameras.parts, "lens": lenses.parts, "port": ports.parts, "light": scenarios.lights(light)}
        problem = problem_of(base, found[0], lists=lists)
        problem = problem.focused_at(np.tile(scenarios.focus, len(cameras.parts) // scenarios.count))
        lost: list[dict[str, int]] = [{} for _ in found]
        blocks, begin = [], (cameras.begin, lenses.begin, ports.begin)
        for port in np.unique(ports.begin):
            mine = np.flatnonzero(ports.begin == port)
            discarded = dict.fromkeys(IMAGER_RULES, 0)
            for state, band, which in different(scenarios, ports.parts, int(port)):
                camera, lens = (np.add.outer(one[mine], which).ravel() for one in begin[:2])
                seen, behind = over_band_of(problem, band), np.array([state])
                blocks += list(imagers_behind(seen, camera, lens, behind, found[0].landscape, discarded, {}))
            if len(mine) == 1:
                lost[mine[0]] = dict(Counter({rule: n for rule, n in discarded.items() if n}).most_common())
        imagers = joined(problem, blocks, {}, {})
        hardware = whose(imagers, begin, scenarios.count)
        return Together(problem, scenarios, found, imagers, hardware, imagers.camera % scenarios.count, lost)

    def rows(self, objective: Objective, deadline: Deadline) -> list[SceneRows]:
        """The settings' view of all imagers, by scene of the mission.

        The light of each is worked out in the water as it is known, and scaled as one of its image changes with the
        water.
        """
        known = self._beyond(self._lit(self.problem, objective, deadline), objective)
        states = [self.scenarios.states[k] for k in self.scenario]
        responses = self._responses(objective, deadline)
        made = []
        for index, rows in enumerate(known):
            seen = []
            for hardware, response in responses.items():
                mine = np.flatnonzero(self.hardware == hardware)
                seen.append((mine, response.seen_in(index, rows.take(mine), [states[k] for k in mine])))
            made.append(seen[0][1] if len(seen) == 1 else SceneRows.in_places(seen, len(self.scenario)))
        return made

    def only(self, rows: Array) -> Together:
        """These imagers alone."""
        return replace(
            self, imagers=some_of(self.imagers, rows), hardware=self.hardware[rows], scenario=self.scenario[rows]
        )

    def bounded_rows(self, objective: Objective, anchor: Anchor, deadline: Deadline) -> list[SceneRows]:
        """Rows with no less light than in each scenario, by a water that is no harder; none is too bright there."""
        rows_in = self._lit(self.problem.in_scenes(anchor.scenes), objective, deadline)
        place = np.searchsorted(anchor.scenarios, self.scenario)
        iris = may_close(self.problem)
        return [eased(dimmed(rows, anchor.share[k][place]), iris=iris) for k, rows in enumerate(rows_in)]

    def _lit(self, problem: Problem, objective: Objective, deadline: Deadline) -> list[SceneRows]:
        """Rows in the light of some water, by scene, each under its own light."""
        search = Search(problem, objective, top=1, imagers=self.imagers, deadline=deadline)
        search.prepare()
        optics, image = problem.lights.optics_index[self.scenario], search.tables.images[1]
        parts = []
        for lighting in search.tables.lightings:
            mine = np.flatnonzero(optics == lighting.optics)
            if len(mine):
                rows = rows_under(search, mine, self.scenario[mine], lighting, self.found[0].count)
                parts.append((mine, [of_deciding_pixels(one, image[mine]) for one in rows]))
        every = range(len(problem.scenes))
        return [SceneRows.in_places([(mine, rows[k]) for mine, rows in parts], len(self.scenario)) for k in every]

    def _beyond(self, known: list[SceneRows], objective: Objective) -> list[SceneRows]:
        """Rows as the altitudes of each scenario have them, by the light over the band as it is asked."""
        beyond = np.array([state.beyond for state in self.scenarios.states])[self.scenario]
        if not beyond.any():
            return known
        made = [over_wider_band(rows, beyond) for rows in known]
        if all(rows.sharp is None for rows in known):
            return made
        sharp: list[list[tuple[Array, Any]]] = [[] for _ in known]
        optics = self.problem.lights.optics_index[self.scenario]
        for band, lighting in product(np.unique(beyond), lightings(self.problem)):
            mine = np.flatnonzero((beyond == band) & (optics == lighting.optics))
            if len(mine):
                search = Search(over_band_of(self.problem, float(band)), objective, top=1, imagers=self.imagers)
                search.prepare()
                for index, places in enumerate(sharp):
                    places.append((mine, search.design_rows.sharp(index, mine, lighting)))
        return [
            replace(rows, sharp=None if rows.sharp is None else SharpRows.in_places(places, len(beyond)))
            for rows, places in zip(made, sharp, strict=True)
        ]

    def _responses(self, objective: Objective, deadline: Deadline) -> dict[int, WaterResponse]:
        """How the light of each hardware's image changes with the water; those not known yet are worked out together.

        The first state of its parts stands for all.
        """
        known = self.scenarios.known
        hardware, first = np.unique(self.hardware, return_index=True)
        keys = {int(h): self._image_key(int(row)) for h, row in zip(hardware, first, strict=True)}
        missing = {keys[int(h)]: int(row) for h, row in reversed([*zip(hardware, first, strict=True)])}
        missing = {key: row for key, row in missing.items() if key not in known}
        light = int(self.scenario[0])
        optics = self.problem.lights.optics_index[light]
        lighting = next(one for one in lightings(self.problem) if one.optics == optics)
        alone = some_of(self.imagers, np.array(list(missing.values()), int))

        def reference(scenes: list[SceneOptics]) -> list[SceneRows]:
            deadline.check()
            other = Search(self.problem.in_scenes(scenes), objective, top=1, imagers=alone, deadline=deadline)
            other.prepare()
            every = np.arange(len(alone))
            return rows_under(other, every, np.full(len(alone), light), lighting, self.found[0].count, with_rules=False)

        if missing:
            made = WaterResponse.of_each(self.scenarios.waters, self.scenarios.states, reference, len(alone))
            known.update(zip(missing, made, strict=True))
        return {h: known[key] for h, key in keys.items()}

    def _image_key(self, row: int) -> tuple[Any, ...]:
        """What tells images apart whose light changes differently with the water: fields more than 2 % apart."""
        problem, found = self.problem, self.found[0]
        fields_seen = [
            round(float(np.log(tangent[row])) / SAME_FIELD)
            for seen in self.imagers.scenes
            for tangent in (seen.view.tan_along, seen.view.tan_across)
        ]
        camera, port = problem.parts.cameras[self.imagers.camera[row]], problem.parts.ports[self.imagers.port[row]]
        ends = (port.geometry, found.lighting.mount, found.count, found.lighting.optics)
        return (*ends, tuple(sorted(camera.qe_curves)), tuple(camera.qe_curves.values()), *fields_seen)


def imagers_among(problem: Problem, found: Sequence[Found], landscape: bool) -> Imagers:
    """The imagers of this hardware, by places in the problem's lists, in one orientation."""
    discarded, blocks = dict.fromkeys(IMAGER_RULES, 0), []
    for port in sorted({one.port for one in found}):
        camera, lens = np.array(sorted({(one.camera, one.lens) for one in found if one.port == port})).T
        blocks += list(imagers_behind(problem, camera, lens, np.array([port]), landscape, discarded, {}))
    return joined(problem, blocks, discarded, {})


def different(scenarios: Scenarios, parts: Sequence[Any], begin: int) -> list[tuple[int, float, Array]]:
    """The states of a port that differ, by their places, and of the band of altitudes, each with its scenarios."""
    states = [parts[begin + state] for state in range(int(scenarios.port.max()) + 1)]
    first = {id(part): begin + state for state, part in reversed(list(enumerate(states)))}
    of = np.array([first[id(part)] for part in states])[scenarios.port]
    beyond = np.array([state.beyond for state in scenarios.states])
    found = []
    for state, band in product(np.unique(of), np.unique(beyond)):
        which = np.flatnonzero((of == state) & (beyond == band))
        if len(which):
            found.append((int(state), float(band), which))
    return found


def over_band_of(problem: Problem, beyond: float) -> Problem:
    """A problem whose vehicle leaves its band of altitudes so far in every scene."""
    return problem.over_bands([over_band(scene, beyond) for scene in problem.scenes]) if beyond else problem


def over_wider_band(rows: SceneRows, beyond: Array) -> SceneRows:
    """Rows whose light is that at altitudes beyond the band, each by its own share of the tolerance, (n,).

    Logarithms of the light over the altitudes of the band go on as the polynomial through all of them.
    """
    nodes = np.linspace(-1.0, 1.0, rows.signal_e.shape[1])
    if len(nodes) == 1:
        return rows
    at = (1.0 + beyond)[:, None] * nodes
    shares = [np.prod([(at - b) / (a - b) for b in nodes if b != a], axis=0) for a in nodes]
    weight = np.stack(shares, axis=2)  # (n, altitude, node)
    changes = {}
    for name in (*LIT, *VEILED):
        column = getattr(rows, name)
        if column is not None and column.shape[1] == len(nodes):
            seen = (column > 0.0).all(axis=1, keepdims=True)
            beyond_it = np.exp(np.einsum("nak,nk...->na...", weight, np.log(np.where(seen, column, 1.0))))
            changes[name] = np.where(seen, beyond_it, column)
    return replace(rows, **changes)


def whose(imagers: Imagers, begin: tuple[Array, Array, Array], count: int) -> Array:
    """Which hardware each imager is of, by the states of camera, lens and port."""
    camera, lens, port = begin
    starts = np.unique(port)
    own = starts[np.searchsorted(starts, imagers.port, side="right") - 1] if len(imagers) else imagers.port
    columns = [(imagers.camera // count, camera // count), (imagers.lens // count, lens // count), (own, port)]
    seen, wanted = np.zeros(len(imagers), int), np.zeros(len(camera), int)
    for ours, theirs in columns:
        size = int(theirs.max()) + 1
        seen, wanted = seen * size + ours, wanted * size + theirs
    order = np.argsort(wanted)
    return np.asarray(order[np.searchsorted(wanted[order], seen)])


def some_of(imagers: Imagers, rows: Array) -> Imagers:
    """These imagers alone."""
    columns = {f.name: getattr(imagers, f.name) for f in fields(imagers)}
    made: dict[str, Any] = {name: column[rows] for name, column in columns.items() if isinstance(column, np.ndarray)}
    return replace(imagers, **made, scenes=[scene.take(rows) for scene in imagers.scenes])


def dimmed(rows: SceneRows, share: Array) -> SceneRows:
    """Rows with so much of their light and their veils, (n, n_altitudes)."""
    changes = {}
    for name in (*LIT, *VEILED):
        column = getattr(rows, name)
        if column is not None:
            changes[name] = column * share.reshape(*share.shape, *([1] * (column.ndim - 2)))
    return replace(rows, **changes)


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


def rows_under(
    search: Search, rows: Array, light: Array, lighting: Lighting, count: int, *, with_rules: bool = True
) -> list[SceneRows]:
    """The settings' view of these imagers, each under its own light of one optics."""
    lights = [search.tables.exact(s, lighting, rows) for s in range(len(search.problem.scenes))]
    return search.rows(rows, lights, light, np.full(len(rows), count), lighting, with_rules=with_rules)

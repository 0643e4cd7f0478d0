"""The third thing uwopt does: the trade-off between two or three objectives."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from uwopt.api import solving as api
from uwopt.api.common import (
    Source,
    base_result,
    central_notes,
    check_count,
    prepared,
    selection_warnings,
    time_warnings,
)
from uwopt.api.floats import own_float_rules
from uwopt.api.front_asked import (
    EXACT,
    PEER,
    checked_objectives,
    checked_solvers,
    why_no_exact,
)
from uwopt.api.front_found import (
    FrontSearched,
    check_point_claim,
    front_proof,
    front_search_status,
    is_empty,
    methods_of,
    points_evaluated,
    reference,
)
from uwopt.api.practice_known import PracticeKnown
from uwopt.api.recommending import proven_in_full
from uwopt.api.search_notes import gain_warnings
from uwopt.api.watch import Watch
from uwopt.api.yielding import gives_way_if_any, yield_notes
from uwopt.arrays import Array
from uwopt.catalog.catalogue import Catalog
from uwopt.catalog.choose import ToBeMade
from uwopt.deadline import Deadline, Progress
from uwopt.evaluation.influences import influences_of
from uwopt.forward.assembly import build_problem, load_catalog, selected
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.mission.yielding import Yield, with_yields, yields_of
from uwopt.objectives.axes import DEFAULT, Axes, Frame
from uwopt.objectives.dominance import hypervolume, nondominated
from uwopt.objectives.objective import Objective
from uwopt.objectives.own import OwnFunction, OwnObjective
from uwopt.results.basis import Assumption, UsedEffect
from uwopt.results.design import Design, Note
from uwopt.results.front import FrontObjective, FrontPoint, FrontResult, Peer, values_of
from uwopt.results.result import Result
from uwopt.solvers.beside import side_by_side
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.explain.assumptions import assumptions
from uwopt.solvers.front.designs import few, found_of, objectives_of, picks_of
from uwopt.solvers.front.search import FrontSearch
from uwopt.solvers.recommend import with_rounded
from uwopt.solvers.settable.rounding import given_of
from uwopt.solvers.settable.scene import Near
from uwopt.solvers.settings.cell_pool import QUALITIES
from uwopt.units import listed

EXACT_S = 120.0  # for the exact front, unless the call says otherwise
PEER_S, PEER_ALONE_S = 2.0, 30.0  # for a population solver: a look beside the exact front, or the search itself
AT_A_TIME = 50  # points evaluated together, between two looks at the progress
FIGURES_SHARE, FIGURES_S = 0.3, 8.0  # of a time that is set, and at most [s]: for the figures of a front's points


@own_float_rules
def pareto(
    mission: Source | Mission,
    *,
    objectives: Sequence[str | OwnObjective | OwnFunction] = DEFAULT,
    solver: str | Sequence[str] = (EXACT, PEER),
    physics: str | None = None,
    seconds: float | None = None,
    seed: int | None = None,
    alternatives: bool = False,
    hold_practice: bool = False,
    progress: Progress | None = None,
) -> FrontResult:
    """The designs of which none is better than another in every objective.

    Parameters
    ----------
    mission : file name, mapping or Mission
    objectives : two or three of power, cost, mass, snr_db, gsd_mm, contrast, information; or functions of your
        own (see `objectives.own.OwnObjective`), which population solvers alone can search
    solver : exact, and names of pymoo's algorithms such as nsga2 or nsga3, one or several
    seconds : for all of it, shared by the solvers; unless told the exact search stops after 120 s, population
        solvers after 2 s each, or 30 s where there is no exact front
    seed : of the population solvers; the mission's unless given
    alternatives : also say why systems of other makers are not on the front
    hold_practice : as of `solve`; else what good practice has filled in gives way where nothing meets all of it
    """
    watch = Watch.begun(seconds, progress)
    deadline = watch.deadline
    wanted = prepared(mission, physics, None)
    asked_for = checked_objectives(objectives)
    names = [item for item in asked_for if isinstance(item, str)]
    is_plain = len(names) == len(asked_for)
    solvers = checked_solvers(solver, is_plain=is_plain)
    axes = Axes(tuple(names)) if is_plain else None
    if seed is not None:
        check_count("seed", seed, 0)
    for name in names:  # requirements that one objective alone needs, such as information a footprint
        if name in ("information", "contrast"):
            prepared(wanted, None, name)
    with watch.timed("catalogue"):
        catalog = load_catalog(wanted)

    given_way, known = tuple[Yield, ...](), PracticeKnown()
    if EXACT in solvers and not hold_practice and yields_of(wanted):
        with watch.stage("practice"):  # that nothing fits is sooner proven than that a front has no point
            given_way = gives_way_if_any(wanted, catalog, deadline, known)
    held = with_yields(wanted, given_way)

    def searched(asked: Mission) -> tuple[ParetoCall, FrontSearched]:
        run = ParetoCall(asked, catalog, asked_for, axes, solvers, asked.seed if seed is None else seed, watch)
        sought = run.sought(asked.catalog.generic_at_first, known.like)
        if asked.catalog.generic == "fallback" and is_empty(sought):
            sought = run.sought(asked.catalog.generic_at_last, sought.problem)
        return run, sought

    capless = held.without_gain_cap
    run, sought = searched(capless if known.fits(capless) is False else held)  # it yields: nothing fits with it either
    if run.mission is not capless and is_empty(sought):
        run, sought = searched(capless)
    result = run.result(sought)
    if alternatives and result.points and axes is not None and not sought.cut and result.status != "interrupted":
        from uwopt.solvers.explain.other_makers import beside_front

        with watch.stage("alternatives"):
            told = beside_front(sought.selection, sought.search, axes, result, deadline)
        result = replace(result, alternatives=told)
    notes = [*central_notes(wanted, "uwopt solve holds it"), *time_warnings(deadline)]
    notes[:0] = gain_warnings(held, sought.problem, [point.design for point in result.points])
    result = replace(result, mission=held.to_dict(), timing_s=watch.total())
    return replace(result, warnings=[*yield_notes(given_way), *result.warnings, *notes])


ALL_BUT_DONE = 0.99  # of the work, where only the check by another method is left


@dataclass(frozen=True)
class Stages:
    """What one work adds to what was searched, and how long its stages took [s]."""

    found: dict[str, Any]
    spent_s: dict[str, float]


def here_alone(progress: Progress) -> Progress:
    """The same, silent in a copy of this process."""
    here = os.getpid()
    return lambda share, what: progress(share, what) if os.getpid() == here else None


class ParetoCall:
    """One call of `pareto`."""

    def __init__(
        self, mission: Mission, catalog: Catalog, objectives: list[str | OwnObjective], axes: Axes | None,
        solvers: list[str], seed: int, watch: Watch,
    ):  # fmt: skip
        self.mission, self.catalog, self.objectives = mission, catalog, objectives
        self.axes, self.solvers = axes, solvers
        self.deadline, self.seed, self.left_out = watch.deadline, seed, ""
        self.alone = False  # of a catalogue too large for solvers that choose among all of its imagers
        self.figures_s = min(FIGURES_SHARE * self.deadline.left_s, FIGURES_S)
        self.watch, self.progress = watch, here_alone(watch.progress)

    @property
    def builtin(self) -> Objective:
        """The built-in axes with weight 1; power where there is none."""
        names = [item for item in self.objectives if isinstance(item, str)]
        return Objective(dict.fromkeys(names or ["power"], 1.0))

    def sought(self, generic: ToBeMade, like: Problem | None = None) -> FrontSearched:
        """Select, tabulate, search with every solver.

        like : of another search, whose light is not worked out again where it is in the same scenes
        """
        with self.watch.timed("tables"):
            selection = selected(self.mission, self.catalog, generic=generic)
            scenes = None if like is None else like.scenes_for(self.mission)
            problem = build_problem(self.mission, selection, scenes=scenes)
        front, search = None, None
        self.left_out = why_no_exact(problem, self.axes)
        solvers = list(self.solvers)
        if self.left_out and len(solvers) > 1 and EXACT in solvers:
            solvers.remove(EXACT)
        else:
            self.left_out = ""
        if EXACT in solvers and self.axes is not None:
            with self.watch.timed(EXACT):
                made = FrontSearch(
                    problem, self.axes, deadline=self.turn(len(solvers), EXACT_S),
                    progress=lambda share, what: self.progress(0.5 * share, what),
                )  # fmt: skip
                front = made.run()
            search, self.alone = made.search, made.search.every_imager is None
        if search is None:
            search = Search(problem, self.builtin, top=1)
            with self.watch.timed("tables"):
                search.prepare()
        halted = self.alone or (front is not None and (front.interrupted or not len(front.values)))
        waiting = [] if halted else [name for name in solvers if name != EXACT]
        sought = FrontSearched(selection, problem, search, front, [])
        works = [partial(self.by_peers, search, waiting, alone=front is None)] if waiting else []
        if waiting and front is not None:  # neither needs the other; figures are shared out further
            works.insert(0, partial(self.shown_points, sought, waiting))
        try:
            found = side_by_side(works, lists=[self.deadline.left_out])
        except KeyboardInterrupt:  # what is proven is kept
            if front is None:
                raise
            return replace(sought, cut=waiting[0])
        for one in found:
            sought = replace(sought, **one.found)
            for name, spent_s in one.spent_s.items():
                self.watch.timing_s[name] = self.watch.timing_s.get(name, 0.0) + spent_s
        return sought

    def by_peers(self, search: Search, waiting: Sequence[str], *, alone: bool) -> Stages:
        """What population solvers find, one after another, and which of them was interrupted."""
        peers, watch, cut = list[Any](), self.watch.apart(), ""
        for place, name in enumerate(waiting):
            turn = self.turn(len(waiting) - place, PEER_ALONE_S if alone else PEER_S)
            with watch.timed(name):
                try:
                    peers += self.deadline.within(name, lambda: [self.peer(search, name, turn)], [])  # noqa: B023
                except KeyboardInterrupt:  # what others found is kept
                    if alone and not peers:
                        raise
                    cut = name
            if cut or (peers and peers[-1].status == "interrupted"):
                cut = name  # who interrupts does not want the next solver
                break
        return Stages({"peers": peers, "cut": cut}, watch.timing_s)

    def shown_points(self, sought: FrontSearched, waiting: Sequence[str]) -> Stages:
        """The points of an exact front that are shown; those that wait search beside, and longer where time is set."""
        watch = self.watch.apart()
        with watch.timed("evaluation"):
            points = self.points(sought, *self.shown(sought))
        self.progress(ALL_BUT_DONE, f"{listed(waiting)} searches too, as a check")
        return Stages({"points": points}, watch.timing_s)

    def turn(self, n_waiting: int, usual_s: float) -> Deadline:
        """One solver's time: an even share of what is left for those that wait, or the usual time.

        Some of a time that was set is kept for the figures of the points that are shown.
        """
        searching_s = self.deadline.left_s - self.figures_s
        return self.deadline.at_most(max(searching_s, 0.0) / n_waiting if self.limited else usual_s)

    @property
    def limited(self) -> bool:
        """Whether the call set a time."""
        return math.isfinite(self.deadline.end_s)

    def peer(self, search: Search, name: str, turn: Deadline) -> Any:
        """A front by a population solver."""
        from uwopt.solvers.population.pymoo_front import population_front

        return population_front(
            search, self.objectives, algorithm=name, seed=self.seed,
            seconds=turn.left_s,
            progress=lambda share, what: self.progress(0.5 + 0.4 * share, f"{name}: {what}"),
        )  # fmt: skip

    # ------------------------------------------------------------ result

    def result(self, sought: FrontSearched) -> FrontResult:
        """Everything found, as a result."""
        base = base_result("pareto", self.mission, self.builtin, sought.problem)
        front = sought.front
        status = front_search_status(sought, limited=self.limited)
        made = FrontResult(
            status=status, mission=base.mission, physics=base.physics, objectives=self.axes_of_result(),
            uwopt_version=base.uwopt_version, seed=self.seed, versions=base.versions, mission_file=base.mission_file,
            warnings=selection_warnings(sought.selection),
        )  # fmt: skip
        if front is not None:
            made = replace(made, certificate=front_proof(sought, front))
        values, founds, method = self.shown(sought)
        if len(values) == 0:
            return self.without_points(made)
        frame = self.frame(sought)
        points = sought.points
        if points is None:
            with self.watch.timed("evaluation"):
                points = self.points(sought, values, founds, method)
        picks = picks_of(points, made.objectives, frame)
        places = {point.id: founds[n] for n, point in enumerate(points)}
        named = {pick.point: places[pick.point] for pick in picks}
        with self.watch.timed("evaluation"):
            picked = [partial(self.rounded, sought, p, named[p.id]) for p in points if p.id in named]
            rounded = {point.id: point for point in side_by_side(picked)}
            points = [rounded.get(p.id, p) for p in points]
        first = places[picks[-1].point]
        return replace(
            made, points=points, picks=picks, methods=methods_of(sought, frame), peers=self.peers_of_result(sought),
            reference=reference(made.objectives, frame), assumptions=self.assumed(sought, list(named.values())),
            physics=replace(base.physics, effects=self.effects(sought, first)),
            warnings=[*made.warnings, *self.warned(sought)],
        )  # fmt: skip

    def axes_of_result(self) -> list[FrontObjective]:
        """The objectives as a result names them."""
        currency = self.mission.limits.currency
        out = []
        for item in self.objectives:
            if isinstance(item, str):
                out += objectives_of(Axes((item,)), currency)
            else:
                out.append(FrontObjective(item.name, item.direction, item.unit, own=True))
        return out

    def frame(self, sought: FrontSearched) -> Frame:
        """The box that fronts are compared in: the exact front's where there is one."""
        if sought.front is not None and sought.front.frame is not None:
            return sought.front.frame
        values = np.concatenate([peer.values for peer in sought.peers])
        front = values[nondominated(values)]
        known = self.axes or Axes(tuple(item if isinstance(item, str) else "own" for item in self.objectives))
        return Frame.of(known, front)

    def shown(self, sought: FrontSearched) -> tuple[Array, list[Found], list[str]]:
        """Values, designs and solver of the points to show, along the first objective."""
        front = sought.front
        if front is not None and front.frame is not None:
            places = few(front.values, front.frame)
            return (
                front.values[places],
                [found_of(sought.search, front, int(i)) for i in places],
                [EXACT] * len(places),
            )
        rows = [(peer, n) for peer in sought.peers for n in range(len(peer.values))]
        if not rows:
            return np.empty((0, len(self.objectives))), [], []
        values = np.array([peer.values[n] for peer, n in rows])
        kept = np.nonzero(nondominated(values))[0]
        places = kept[few(values[kept], self.frame(sought))]
        picked = [rows[int(i)] for i in places]
        return values[places], [peer.found[n] for peer, n in picked], [peer.algorithm for peer, _ in picked]

    def points(
        self, sought: FrontSearched, values: Array, founds: list[Found], methods: list[str]
    ) -> list[FrontPoint]:
        """Designs evaluated again through the forward model; what it does not bear out is a defect."""
        objectives = self.axes_of_result()
        signs = np.array([o.sign for o in objectives])
        curves: dict[Any, str] = {}
        points = []
        for n, (found, design) in enumerate(zip(founds, self.evaluated(sought.problem, founds), strict=True)):
            hardware = found.hardware
            claimed = {o.name: float(v) for o, v in zip(objectives, values[n] * signs, strict=True)}
            reported = {**claimed, **values_of(design, objectives)}
            check_point_claim(claimed, reported, design)
            curve = curves.setdefault(hardware, f"c{len(curves) + 1}")
            points.append(FrontPoint(f"p{n + 1}", reported, curve, methods[n], design))
        return points

    def evaluated(self, problem: Problem, founds: Sequence[Found]) -> list[Design]:
        """Figures and margins of designs, some at a time on every core."""
        batches = [founds[start : start + AT_A_TIME] for start in range(0, len(founds), AT_A_TIME)]

        def told(number: int) -> None:
            self.progress(0.9 + 0.1 * number / len(batches), "figures of the front")

        works = [partial(points_evaluated, problem, batch) for batch in batches]
        return [design for batch in side_by_side(works, begins=told) for design in batch]

    def rounded(self, sought: FrontSearched, point: FrontPoint, found: Found) -> FrontPoint:
        """A point with the settings that a person can set, near its own in all that is traded and that they change."""
        near = Near(tuple(name for name in QUALITIES if name in (*Near.figures, *self.objectives)))
        return replace(point, design=with_rounded(sought.problem, found, point.design, near))

    def peers_of_result(self, sought: FrontSearched) -> list[Peer]:
        """Points of the population solvers beside an exact front."""
        if sought.front is None:
            return []
        parts, out = sought.problem.parts, []
        signs = np.array([o.sign for o in self.axes_of_result()])
        names = [o.name for o in self.axes_of_result()]
        for peer in sought.peers:
            for n in few(peer.values, self.frame(sought)) if len(peer.values) else []:
                values = dict(zip(names, (peer.values[n] * signs).tolist(), strict=True))
                out.append(Peer(peer.algorithm, values, [part.id for part in parts.of(peer.found[int(n)]).values()]))
        return out

    def assumed(self, sought: FrontSearched, founds: list[Found]) -> list[Assumption]:
        """Estimates that the named points rest on, each once."""
        items: dict[tuple[str, str, str], Assumption] = {}
        for found in founds:
            for item in assumptions(sought.problem, found):
                items.setdefault((item.path, item.part, str(item.value)), item)
        return list(items.values())

    def effects(self, sought: FrontSearched, found: Found) -> list[UsedEffect]:
        """How much each effect matters to one design."""
        hardware = found.hardware
        given = given_of(sought.problem, hardware, found.settings)
        influences = influences_of(sought.problem, hardware, given)
        return [item.used() for item in proven_in_full(influences)]

    def warned(self, sought: FrontSearched) -> list[Note]:
        """What should be known of how the front came about."""
        out = (
            [("no_exact", f"searched by population solvers alone: {self.left_out}")] if self.left_out else []
        )
        front = sought.front
        if self.alone and len(self.solvers) > 1:
            out.append(("exact_alone", "so large a catalogue is searched by the exact solver alone"))
        if front is not None and not front.complete:
            what = "interrupted" if front.interrupted else "stopped"
            out.append((what, "the exact front was not finished; its certificate says what it may miss"))
        elif front is not None and front.hypervolume_bound > front.hypervolume * 1.001:
            share = 100.0 * (1.0 - front.hypervolume / front.hypervolume_bound)
            out.append(("gap", f"bounds on settings leave {share:.2g} % of the hypervolume open"))
        if sought.cut:
            rest = (
                "the exact front was finished before"
                if front is not None
                else "the front holds what it had found"
            )
            out.append(("interrupted", f"{sought.cut} was interrupted; {rest}"))
        if front is not None and len(front.values) == 1:
            out.append(("one_point", "one design is best in every objective: there is nothing to trade"))
        for peer in sought.peers:
            volume = hypervolume(peer.values, self.frame(sought)) if front is not None else 0.0
            if front is not None and front.complete and volume > 1.001 * front.hypervolume_bound:
                out.append(
                    ("defect", f"{peer.algorithm} found more than the exact front allows; please report it")
                )
        return [Note(code, "objectives", text) for code, text in out]

    def without_points(self, made: FrontResult) -> FrontResult:
        """A result without a point: why nothing fits, as `solve` tells it."""
        if made.status != "infeasible":
            return made
        told = self.deadline.within("why nothing fits", self.explained, None)
        if told is None:
            return made
        proof = None if told.certificate is None else told.to_dict()["certificate"]
        cut = [warning for warning in told.warnings if warning.code == "time"]
        return replace(
            made,
            infeasible=told.infeasible,
            certificate=proof or made.certificate,
            warnings=[*made.warnings, *cut],
        )

    def explained(self) -> Result:
        """What `solve` tells of a mission that nothing meets."""
        self.deadline.check()
        seconds = self.deadline.left_s if self.limited else None
        return api.solve(self.mission, objective="power", seconds=seconds)

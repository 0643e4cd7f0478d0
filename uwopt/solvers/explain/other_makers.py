"""Why not another maker: the best system with a camera or light of every maker that is not recommended.

Each maker gets its own exact search over the same tables, its parts alone in the place of all of that kind. What
it finds is worse than the recommendation, or dominated by a point of the front; or nothing it sells fits.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from uwopt.catalog.choose import Selection
from uwopt.catalog.records import Part
from uwopt.deadline import NEVER, Deadline
from uwopt.forward.problem import Problem
from uwopt.objectives.axes import Axes
from uwopt.objectives.objective import Objective
from uwopt.quantities import AT_LIKELIEST, TERMS
from uwopt.results.basis import OtherMaker
from uwopt.results.design import Design
from uwopt.results.front import FrontObjective, FrontPoint, FrontResult, values_of
from uwopt.solvers.exact.account import RULES
from uwopt.solvers.exact.search import Search
from uwopt.solvers.recommend import evaluated
from uwopt.tolerances import TIE

OF_MAKERS = ("camera", "light")
MOST_MAKERS = 12  # of a kind
LONGEST_S = 5.0  # of work, or where time is given of that: what is not reached by then is left out


def beside_best(
    selection: Selection, search: Search, goal: Objective, best: Design, deadline: Deadline = NEVER,
    central: float | None = None,
) -> list[OtherMaker]:
    """Other makers' best systems beside a recommendation.

    central : the best objective at likeliest values, where what is recommended was chosen over scenarios instead
    """

    def judged(item: OtherMaker, design: Design) -> OtherMaker:
        value = design.objective_value
        least = (best.objective_value if central is None else central) or 0.0
        apart = central is not None and central != best.objective_value
        values = {} if value is None else {goal.name: value}
        if value is None:
            text = ""
        elif abs(value - least) <= TIE * abs(least):
            text = "as good; ties are broken by power, cost, mass and number of lamps"
            text = f"as good {AT_LIKELIEST}, not over the scenarios" if apart else text
        else:
            share = 100.0 * (value / least - 1.0) if least else 0.0
            text = f"its best system has {abs(share):.3g} % {'more' if share > 0 else 'less'} {spoken(goal.name)}"
            text += f" than the best {AT_LIKELIEST}" if apart else ""
        return replace(item, values=values, outcome="worse", text=text)

    shown = {kind: {best.hardware.parts[kind].id} for kind in OF_MAKERS}
    return entries_by_maker(selection, search, goal, shown, judged, deadline)


def beside_front(
    selection: Selection, search: Search, axes: Axes, front: FrontResult, deadline: Deadline
) -> list[OtherMaker]:
    """Other makers' systems of best first objective beside a front, and which of its points dominates each."""

    def judged(item: OtherMaker, design: Design) -> OtherMaker:
        values = values_of(design, front.objectives)
        by = dominating(values, front.points, front.objectives)
        if by is None:
            return replace(
                item, values=values, outcome="worse", text="close to the front, between its points"
            )
        gains = better_by(values, by, front.objectives)
        text = f"{by.id} is at least as good in everything" + (f": {gains}" if gains else "")
        return replace(item, values=values, outcome="dominated", by=by.id, text=text)

    shown = {kind: {p.design.hardware.parts[kind].id for p in front.points} for kind in OF_MAKERS}
    goal = Objective({axes.names[0]: 1.0})
    return entries_by_maker(selection, search, goal, shown, judged, deadline)


def entries_by_maker(
    selection: Selection, first: Search, goal: Objective, shown: dict[str, set[str]],
    judged: Callable[[OtherMaker, Design], OtherMaker], deadline: Deadline,
) -> list[OtherMaker]:  # fmt: skip
    """One entry a maker whose parts are not shown; `first`: the search of all, which may have listed imagers."""
    problem, every = first.problem, first.every_imager
    patience, out = deadline.of_work(LONGEST_S), []
    for kind, maker, mask in other_makers(selection, problem, shown):
        item = OtherMaker(kind, maker)
        if mask is None:
            out.append(replace(item, outcome="not allowed", text=why_left_out(selection, kind, maker)))
            continue
        if patience.passed():
            break
        known = every
        if every is not None and kind == "camera":
            known = every.take(np.flatnonzero(mask[every.camera]))
        if not known:  # not listed, or none is left: then the rules count what each discards
            known = None
        search = Search(problem, goal, top=1, deadline=patience, only={kind: mask}, imagers=known)
        outcome = search.whole()
        if not outcome.best:
            if outcome.complete:
                out.append(replace(item, rule=furthest_rule(outcome.account.discarded)))
            continue
        found = outcome.best[0]
        design = evaluated(problem, found, goal)
        out.append(judged(replace(item, hardware=design.hardware.ids_by_kind), design))
    return out


def other_makers(
    selection: Selection, problem: Problem, shown: dict[str, set[str]]
) -> Iterator[tuple[str, str, np.ndarray[Any, Any] | None]]:
    """Makers of cameras and lights none of whose parts is shown, with a mask of those that may be searched."""
    for kind in OF_MAKERS:
        searched: Sequence[Part] = getattr(problem.parts, f"{kind}s")
        known: Sequence[Part] = selection.catalog.parts(kind)
        taken = {part.manufacturer for part in known if part.id in shown[kind]}
        makers = [part.manufacturer for part in known if part.manufacturer and not part.generic]
        others = [maker for maker, _ in Counter(makers).most_common() if maker not in taken]
        may = [maker for maker in others if any(part.manufacturer == maker for part in searched)]
        for maker in (may + [maker for maker in others if maker not in may])[:MOST_MAKERS]:
            mask = np.array([part.manufacturer == maker for part in searched])
            yield kind, maker, mask if mask.any() else None


def why_left_out(selection: Selection, kind: str, maker: str) -> str:
    """The reason that most of a maker's parts are left out before the search."""
    own = {part.id for part in selection.catalog.parts(kind) if part.manufacturer == maker}  # pyrefly: ignore[bad-argument-type]
    reasons = Counter(item.reason for item in selection.excluded if item.part_id in own)
    return reasons.most_common(1)[0][0] if reasons else ""


def furthest_rule(discarded: dict[str, int]) -> str | None:
    """Of the rules that discarded something the one that a design meets last."""
    met = [rule for rule in RULES if discarded.get(rule) and rule != "bound"]
    return met[-1] if met else None


def dominating(
    values: dict[str, float], points: Sequence[FrontPoint], objectives: Sequence[FrontObjective]
) -> FrontPoint | None:
    """The point that is at least as good in everything and gains most; None where there is none."""
    best, most = None, -1.0
    for point in points:
        gains = [gain(values[o.name], point.values[o.name], o) for o in objectives]
        if min(gains) >= -1e-6 and sum(gains) > most:
            best, most = point, sum(gains)
    return best


def gain(value: float, other: float, objective: FrontObjective) -> float:
    """How much better another value is, relative."""
    step = (other - value) / max(abs(value), 1e-300)
    return step if objective.direction == "maximise" else -step


def better_by(values: dict[str, float], point: FrontPoint, objectives: Sequence[FrontObjective]) -> str:
    """What a point has more and less of, in words."""
    said = []
    for o in objectives:
        step = 100.0 * (point.values[o.name] / values[o.name] - 1.0) if values[o.name] else 0.0
        if abs(step) >= 0.05:
            said.append(f"{abs(step):.3g} % {'more' if step > 0 else 'less'} {spoken(o.name)}")
    return ", ".join(said)


def spoken(name: str) -> str:
    """An objective's name in a sentence."""
    return "SNR in dB" if name == "snr_db" else TERMS[name].words if name in TERMS else name

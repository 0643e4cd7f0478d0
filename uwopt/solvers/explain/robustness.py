"""Whether the recommendation would change if what is estimated were known.

Assumptions are the numbers of the winner's parts that no source states. The regret puts the winner's
parts at the bad end of their ranges and all rivals' at the good end, and searches once more. A quote
matters when that one number, at its bad end, would let another design win. Of a number that favours one
design at its high end and another at its low one (the radius of a dome: a large one is easier to focus
through, a small one brings the camera nearer) both ends are tried: the winner has the worse one, a rival
any of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from uwopt.catalog.curves.clarity import Clarity
from uwopt.catalog.parts.doubts import doubtful, taken_as
from uwopt.catalog.parts.kinds import EITHER
from uwopt.catalog.records import Part, Port, Quantity, exact
from uwopt.deadline import NEVER, Deadline
from uwopt.evaluation.bill import beside_parts
from uwopt.evaluation.design_model import design_model
from uwopt.forward.part_columns import FAVOURED
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.results.basis import Assumption
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.exact.search import Search
from uwopt.solvers.one_hardware import KINDS, best_of, best_of_each, parts_of, pieces_of, problem_of
from uwopt.solvers.recommend import Sought, hardware_of
from uwopt.solvers.settings.best import scenes_need_cells

UNITS_BY_SUFFIX = {
    "_e": "e-", "_e_s": "e-/s", "_db": "dB", "_us": "µs", "_hz": "Hz", "_w": "W", "_g": "g", "_lm": "lm",
    "_j": "J", "_s": "s", "_deg": "deg", "_mm": "mm", "_m": "m", "_frac": "", "_mb_s": "MB/s", "_lm_s_per_j": "lm s/J",
}  # fmt: skip
SLOW_S = 2.5  # for a rival, where settings have no closed form
TURN = 0.5  # of the time left: what the search for a rival may take of it


def unit_of(name: str, part: Part) -> str:
    """Unit of a part's field, from its name."""
    if name in ("price", "host_price"):
        return part.currency if name == "price" else "USD"
    suffixes = sorted(UNITS_BY_SUFFIX, key=len, reverse=True)
    return next((UNITS_BY_SUFFIX[s] for s in suffixes if name.endswith(s)), "")


def assumptions(problem: Problem, found: Found) -> list[Assumption]:
    """Every number of the design that is estimated, and what the model assumes."""
    items = [
        Assumption(
            f"{kind}.{name}", part.id, value.value, value.low, value.high, unit_of(name, part), value.status,
            value.source,
        )
        for kind, part in pieces_of(problem, found)
        for name, value in doubtful(part)
    ]  # fmt: skip
    hardware = hardware_of(found)
    model = design_model(problem, hardware)
    for item, _ in beside_parts(problem, hardware, model.spacer_m, model.disks_gb):
        items += [
            Assumption(
                f"{item.id}.{name}", item.id, known.value, known.low, known.high, unit, known.status, known.source
            )
            for name, known, unit in (("price", item.price, "USD"), ("mass_g", item.mass_g, "g"))
            if known is not None
        ]
    return items + model_assumptions(problem, found)


def model_assumptions(problem: Problem, found: Found) -> list[Assumption]:
    """What the physics takes for granted here."""

    def item(path: str, value: Any, source: str) -> Assumption:
        return Assumption(path, "", value, None, None, unit="", status="assumed", source=source)

    items = [from_reading(s.name, s.clarity) for s in problem.scenes if s.clarity]
    items += [item(f"{s.name}: water_table", s.water_table, "; ".join(s.notes)) for s in problem.scenes]
    light = problem.parts.lights[found.light]
    if light.beam_medium == "not stated" and not problem.paper:
        items.append(
            item(
                "light.beam_medium",
                "air",
                "the source does not say whether the beam angle holds in air or water",
            )
        )
    if light.dim_status == "estimated":
        items.append(
            item("light.dim_levels", list(light.dim_levels or ()), "how the lamp dims is not published")
        )
    if problem.cameras.prnu_frac[found.camera] == 0 and not problem.paper:
        items.append(item("camera.prnu_frac", 0.0, "not published; taken as none"))
    return items


def from_reading(scene: str, known: Clarity) -> Assumption:
    """The attenuation that a visibility, a Secchi depth or a turbidity was taken for."""
    return Assumption(
        f"{scene}: {known.relation.key}", "", known.c_per_m(), known.c_per_m("low"), known.c_per_m("high"),
        unit="1/m", status="derived", source=f"c at 530 nm; {known.explained}",
    )  # fmt: skip


# ---------------------------------------------------------------- regret


def at_end(part: Any, end: str, only: str | None = None) -> Any:
    """A part with its doubtful numbers (or one of them) put at one end of their ranges.

    `good` and `bad` move what has such ends; `low` and `high` what may favour a design at either.
    """
    changes: dict[str, Any] = {}
    for name, value in doubtful(part):
        if only is not None and name != only:
            continue
        if end in ("low", "high"):
            if name in EITHER:
                changes[name] = exact(value.low if end == "low" else value.high, value.status, value.source)
            continue
        sign = FAVOURED.get(name, 0)
        if sign:
            best = value.high if sign > 0 else value.low
            worst = value.low if sign > 0 else value.high
            changes[name] = taken_as(name, value, best if end == "good" else worst)
    if only is None and getattr(part, "housing", None) is not None:
        changes["housing"] = at_end(part.housing, end)
    return replace(part, **changes) if changes else part


def with_either_end(part: Any) -> list[Any]:
    """A part as it is, and at both ends of what may favour a design at either."""
    if any(name in EITHER for name, _ in doubtful(part)):
        return [part, at_end(part, "low"), at_end(part, "high")]
    return [part]


def at_worst(
    problem: Problem, found: Found, objective: Objective, deadline: Deadline
) -> tuple[dict[str, Part], float]:
    """A design's parts at the bad ends, and its best objective with them; inf where infeasible then."""
    bad = {kind: at_end(part, "bad") for kind, part in parts_of(problem, found)}
    worst, worst_value = bad, -math.inf
    for port in with_either_end(bad["port"]):
        lists = {kind: [part] for kind, part in (bad | {"port": port}).items()}
        value = best_of(problem_of(problem, found, lists=lists), objective, deadline)
        if value > worst_value:
            worst, worst_value = bad | {"port": port}, value
    return worst, worst_value


def housing_at_end(port: Port, end: str, only: str | None = None) -> Port:
    """A port whose housing's doubtful numbers (or one of them) are put at one end of their ranges."""
    return replace(port, housing=at_end(port.housing, end, only))


Variant = tuple[str, str, str]  # kind, field ("" for all), end


def values_with(
    sought: Sought, found: Found, objective: Objective, variants: Sequence[Variant | None],
    deadline: Deadline = NEVER,
) -> list[float]:  # fmt: skip
    """Best objective of one hardware with one number, or all, of one part changed; inf where infeasible.

    None stands for the hardware as it is. All variants are parts of one small catalogue, so that one
    pass evaluates them.
    """
    base = sought.problem
    lists: dict[str, list[Any]] = {kind: [part] for kind, part in parts_of(base, found)}
    places = []
    for variant in variants:
        place = dict.fromkeys(KINDS, 0)
        if variant is not None:
            kind, name, end = variant
            slot = "port" if kind == "housing" else kind
            made = housing_at_end if kind == "housing" else at_end
            place[slot] = len(lists[slot])
            lists[slot].append(made(lists[slot][0], end, only=name or None))
        places.append(place)
    return best_of_each(problem_of(base, found, lists=lists), objective, places, deadline)


def robustness(
    sought: Sought, objective: Objective, *, top: int = 3, deadline: Deadline = NEVER
) -> dict[str, Any] | None:
    """Regret, rival, and the quotes that could change the answer.

    The search for a rival ends after half of the time left, or after a while where settings have no closed form
    (`complete` says so); then single quotes are not tried.
    """
    if not sought.outcome.best:
        return None
    winner = sought.outcome.best[0]
    problem = sought.problem
    bad, bad_value = at_worst(problem, winner, objective, deadline)
    mixed = mixed_problem(problem, bad)
    slow = scenes_need_cells(problem.scenes, objective)
    patience = deadline.at_most(SLOW_S if slow else TURN * deadline.left_s)
    outcome = Search(mixed, objective, top=2, deadline=patience, ceiling=bad_value).whole()  # no better: no rival
    deadline.check()  # a rival of half a search is none
    rival = next((f for f in outcome.best if not same_parts(mixed, f, problem, winner)), None)
    best = min([f.minimised for f in outcome.best] + [bad_value])
    regret = max(0.0, bad_value - best) if math.isfinite(bad_value) else None
    return {
        "max_regret": None if regret is None else objective.amount(regret, bad_value),
        "regret_rel": None if regret is None else objective.share(regret, winner.minimised),
        "value_at_bad_end": objective.reported(bad_value) if math.isfinite(bad_value) else None,
        "feasible_at_bad_end": math.isfinite(bad_value),
        "complete": outcome.complete and not slow,
        "rival": None
        if rival is None or rival.minimised >= bad_value
        else rival_dict(mixed, rival, objective),
        "quotes_that_matter": []
        if slow
        else deadline.within(
            "which quotes matter",
            lambda: quotes_that_matter(
                sought, objective, outcome_rivals(sought, outcome.best, mixed), top=top, deadline=deadline
            ),
            list[dict[str, Any]](),
        ),
    }


def own_id(part: Part) -> str:
    """The id of a part; of a port with that of its housing."""
    return part.enclosure_id if isinstance(part, Port) else part.id


def mixed_problem(problem: Problem, bad: dict[str, Part]) -> Problem:
    """The winner's parts at their bad end among all others at their good end."""

    def mixed(kind: str, parts: Sequence[Any]) -> tuple[Any, ...]:
        return tuple(
            variant
            for part in parts
            for variant in (
                [bad[kind]] if own_id(part) == own_id(bad[kind]) else with_either_end(at_end(part, "good"))
            )
        )

    parts = problem.parts
    return Problem(
        problem.mission,
        Parts(
            mixed("camera", parts.cameras), mixed("lens", parts.lenses), mixed("port", parts.ports),
            mixed("light", parts.lights),
        ),
        paper=problem.paper, owned_lights=problem.owned_lights, counts=problem.count_range, mounts=problem.mounts,
        scenes=problem.scenes,
    )  # fmt: skip


def same_parts(one: Problem, a: Found, other: Problem, b: Found) -> bool:
    """Whether two designs are made of the same parts."""
    return [own_id(p) for _, p in parts_of(one, a)] == [own_id(p) for _, p in parts_of(other, b)]


def rival_dict(problem: Problem, rival: Found, objective: Objective) -> dict[str, Any]:
    """A rival by its ids, with what it would reach."""
    return {
        **{kind: part.id for kind, part in pieces_of(problem, rival)},
        "light_count": rival.count,
        "objective_value": objective.reported(rival.minimised),
    }


def outcome_rivals(sought: Sought, good: Sequence[Found], mixed: Problem) -> list[Found]:
    """Designs that could take the winner's place: its runner-up, and the rival of the regret search."""
    winner = sought.outcome.best[0]
    rivals = list(sought.outcome.best[1:2])
    for other in good:
        found = among(sought.problem, other, mixed)
        if not any(same_parts(sought.problem, found, sought.problem, known) for known in (winner, *rivals)):
            rivals.append(found)
    return rivals[:2]


def among(problem: Problem, found: Found, mixed: Problem) -> Found:
    """A design of the mixed problem, which may hold a part twice, by the places of its parts in another.

    Raises ValueError where a part is not there.
    """
    own_parts = problem.parts
    lists = dict(zip(KINDS, (own_parts.cameras, own_parts.lenses, own_parts.ports, own_parts.lights), strict=True))
    places: dict[str, Any] = {
        kind: [own_id(own) for own in lists[kind]].index(own_id(part))
        for kind, part in parts_of(mixed, found)
    }
    return replace(found, **places)


def matters(name: str, problem: Problem, objective: Objective) -> bool:
    """Whether a field can enter the objective or a limit at all."""
    limits = problem.mission.limits
    if name == "price":
        return bool(objective.weight("cost")) or limits.cost is not None
    if name == "mass_g":
        return bool(objective.weight("mass")) or limits.mass_kg is not None
    return bool(FAVOURED.get(name)) or name in EITHER


def quotes_that_matter(
    sought: Sought, objective: Objective, rivals: Sequence[Found], *, top: int, deadline: Deadline = NEVER
) -> list[dict[str, Any]]:
    """Single numbers whose bad end for the winner, or good end for a rival, would change the answer."""
    problem = sought.problem
    winner = sought.outcome.best[0]
    matter: list[dict[str, Any]] = []
    for rival in rivals:
        asked = [
            (kind, part, name, doubt, end)
            for design, end in ((winner, "bad"), (rival, "good"))
            for kind, part in pieces_of(problem, design)
            for name, doubt in doubtful(part)
            if matters(name, problem, objective)
            for end in (("low", "high") if name in EITHER else (end,))
        ]
        ours = with_changes(sought, winner, objective, asked, deadline)
        theirs = with_changes(sought, rival, objective, asked, deadline)
        for (kind, part, name, doubt, _), mine, other in zip(asked, ours, theirs, strict=True):
            known = any(q["part"] == part.id and q["field"] == name for q in matter)
            if not known and other < mine and other < mine - 1e-9 * abs(other):
                matter.append(
                    {
                        "part": part.id, "kind": kind, "field": name, "value": doubt.value, "low": doubt.low,
                        "high": doubt.high, "unit": unit_of(name, part),
                        "then_better": " + ".join(p.id for _, p in pieces_of(problem, rival)),
                    }
                )  # fmt: skip
    return matter[: 4 * top]


def with_changes(
    sought: Sought, design: Found, objective: Objective, asked: Sequence[tuple[str, Part, str, Quantity, str]],
    deadline: Deadline = NEVER,
) -> list[float]:  # fmt: skip
    """A design's objective under each change in turn; changes of parts it does not have leave it as it is."""
    own = {kind: part.id for kind, part in pieces_of(sought.problem, design)}
    variants: list[Variant | None] = [
        (kind, name, end) if own.get(kind) == part.id else None for kind, part, name, _, end in asked
    ]
    return values_with(sought, design, objective, variants, deadline)

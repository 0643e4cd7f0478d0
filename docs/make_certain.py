"""How certain recommendations are, and what they cost in time: docs/certain.md.

    python docs/make_certain.py [--write] [--only NAME ...] [--confidence C] [--tries N] [--seconds S] [--jobs N]

Every mission in problems/ and problems/jobs/ is solved at likeliest values and at a confidence. What is recommended is
counted again by `evaluate` in 10 000 scenarios that the choice has not seen. Then it is attacked: other hardware is
drawn at random, half of it from all that there is and half with one or two parts unlike the recommended, and looked at
in scenarios of its own, at first with light that changes with the water as the recommended's does; what seems to hold
there and to be better is counted in them, and what still does by what `evaluate --confidence` counts with.
"""

from __future__ import annotations

import argparse
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import uwopt  # noqa: E402
from uwopt.api.certainty import confidence_of  # noqa: E402
from uwopt.api.common import prepared  # noqa: E402
from uwopt.catalog.choose import ToBeMade  # noqa: E402
from uwopt.catalog.parts.part import KINDS  # noqa: E402
from uwopt.deadline import Deadline  # noqa: E402
from uwopt.forward.assembly import build_problem, load_catalog, selected  # noqa: E402
from uwopt.forward.designs import SceneSettings  # noqa: E402
from uwopt.forward.problem import Problem  # noqa: E402
from uwopt.mission.mission import Mission  # noqa: E402
from uwopt.objectives.goal import goal_of  # noqa: E402
from uwopt.objectives.objective import Objective  # noqa: E402
from uwopt.results.certainty import Confidence  # noqa: E402
from uwopt.results.design import PRACTICE_YIELDS  # noqa: E402
from uwopt.results.result import Result  # noqa: E402
from uwopt.solvers.confidence.counted import Counted, names  # noqa: E402
from uwopt.solvers.confidence.outcomes import outcomes_of_each  # noqa: E402
from uwopt.solvers.confidence.scenarios import SomeScenarios  # noqa: E402
from uwopt.solvers.confidence.search import scenarios_of  # noqa: E402
from uwopt.solvers.confidence.states import colours_of  # noqa: E402
from uwopt.solvers.exact.imagers import Imagers, enumerate_imagers  # noqa: E402
from uwopt.solvers.exact.lightings import Lighting  # noqa: E402
from uwopt.solvers.exact.ranking import Found  # noqa: E402
from uwopt.solvers.one_hardware import ids_of_pieces, pieces_by_kind  # noqa: E402
from uwopt.units import format_quantity  # noqa: E402

PROBLEMS = ROOT / "problems"
PAGE = ROOT / "docs" / "certain.md"
SEED = 20_261_124  # of the scenarios that judge, and of the hardware that is drawn
SCREEN = 64  # scenarios in which hardware that is drawn is looked at
ROUGHLY = 0.2  # share of them that hardware may lack of the confidence, and of the median, at a first look
NEARLY = 0.08  # likewise where it is counted in them, and is still counted in more
BETTER_REL = 1e-3  # of the median: what is less than that is the error of counting
A_BATCH = 48
MOST_COUNTED = 12  # of what holds and is better in the screen, the best by its median
FREE = SceneSettings(f_number=None, exposure_s=None, pulse_s=None, gain=None, level=None, rate_hz=None)


@dataclass
class Row:
    """One mission."""

    name: str
    status: str = ""
    central_s: float = 0.0
    certain_s: float = 0.0
    claimed: Confidence | None = None
    again: Confidence | None = None  # in 10 000 scenarios
    unit: str = ""
    tried: int = 0
    hold: int = 0
    better: list[tuple[float, float, str]] | None = None  # median over ours, share in which it holds, parts
    note: str = ""
    gave_way: bool = False  # of good practice, some


def looked_at(name: str, asked: float, tries: int, seconds: float) -> Row:
    """Solve one mission both ways, and attack what is recommended."""
    path, row = PROBLEMS / f"{name}.yaml", Row(name)
    begin = time.process_time()
    uwopt.solve(path, confidence="central")
    row.central_s = time.process_time() - begin
    begin = time.process_time()
    result = uwopt.solve(path, confidence=asked)
    row.certain_s, row.status = time.process_time() - begin, result.status
    if result.recommendation is None or result.confidence is None:
        return row
    row.claimed = result.confidence
    row.gave_way = any(note.code == PRACTICE_YIELDS for note in result.warnings)
    mission = prepared(result.mission, None, None, asked)  # with what has given way
    if any(note.code == "gain_cap" for note in result.warnings):
        mission = mission.without_gain_cap
    mission = mission.with_changes(seed=SEED)
    row.again = uwopt.evaluate(mission.to_dict(), at_its_stop(result), confidence=asked).confidence
    row.unit = goal_of(mission).unit(mission.limits.currency)
    attacked(row, mission, result, asked, tries, Deadline.after(seconds, time.process_time))
    return row


def at_its_stop(result: Result) -> dict[str, Any]:
    """The recommended system as it is set and `evaluate` takes it, its iris where scenarios want it."""
    assert result.recommendation is not None and result.confidence is not None
    system = result.recommendation.as_system(to_set=True)
    if (stop := result.confidence.f_number) is not None:
        for given in system["scenes"].values():
            given["f_number"] = stop
    return system


def attacked(row: Row, mission: Mission, result: Result, asked: float, tries: int, deadline: Deadline) -> None:
    """Count hardware that is drawn at random, and again what holds and seems better."""
    assert result.recommendation is not None
    goal, first = goal_of(mission), mission.catalog.generic_at_first
    parts = result.recommendation.hardware.named
    made = tuple(kind for kind in KINDS if kind in parts and parts[kind].generic)
    generic: ToBeMade = made if made and first != "allow" else first  # no more kinds to be made than the proof takes in
    problem = build_problem(mission, selected(mission, load_catalog(mission), generic=generic))
    imagers, rng = enumerate_imagers(problem), np.random.default_rng(SEED)
    own = chosen(problem, imagers, result)
    some = {names(problem, one): one for one in drawn(problem, imagers, own, tries, rng)}
    some.pop(names(problem, own), None)
    scenarios = scenarios_of(problem, asked, SEED + 1, SCREEN)
    ours, rivals = counted(problem, [own], goal, scenarios, asked)[0], []
    glance = SomeScenarios.among(scenarios, np.arange(SCREEN))
    every = list(some.values())
    for first in range(0, len(every), A_BATCH):
        if first and deadline.passed():
            row.note = " (cut short)"
            break
        batch = every[first : first + A_BATCH]
        plain = [one for one in batch if colours_of(problem.parts.cameras[one.camera]) in scenarios.colours]
        seen = counted(problem, plain, goal, glance, asked) if plain else []
        hopeful = [one.found for one in seen if seems_better(one, ours, asked, ROUGHLY)]
        hopeful += [one for one in batch if one not in plain]
        made = counted(problem, hopeful, goal, scenarios, asked) if hopeful else []
        row.tried += len(batch)
        row.hold += sum(one.held >= asked for one in seen)
        rivals += [one for one in made if seems_better(one, ours, asked, NEARLY)]
    row.better = []
    base = judged(problem, own, goal, asked)
    for one in sorted(rivals, key=lambda one: one.quantile(0.5))[:MOST_COUNTED]:
        known = judged(problem, one.found, goal, asked)
        if known.held >= asked and is_better(goal, known, base):
            ratio = (known.objective_p50 or 0.0) / (base.objective_p50 or np.inf)
            row.better.append((ratio, known.held, ", ".join(ids_of_pieces(problem, one.found))))


def seems_better(one: Counted, ours: Counted, asked: float, slack: float) -> bool:
    """Whether it may hold, and be better or hold where ours does not, by few scenarios."""
    if one.held < asked - slack:
        return False
    least = ours.quantile(0.5)
    return ours.held < asked - slack or not np.isfinite(least) or one.quantile(0.5) < least + slack * abs(least)


def is_better(goal: Objective, one: Confidence, ours: Confidence) -> bool:
    """Whether hardware that holds has a better median than ours, or ours does not hold."""
    if one.objective_p50 is None or not ours.enough or ours.objective_p50 is None:
        return one.objective_p50 is not None
    known, least = goal.minimised(one.objective_p50), goal.minimised(ours.objective_p50)
    return bool(known < least - BETTER_REL * abs(least))


def judged(problem: Problem, found: Found, goal: Objective, asked: float) -> Confidence:
    """As `evaluate --confidence` counts a system, at whatever stop holds often enough with the least median."""
    return confidence_of(problem, found.hardware, goal, asked, FREE, None)


def counted(problem: Problem, found: list[Found], goal: Objective, scenarios: Any, asked: float) -> list[Counted]:
    """Each in these scenarios, at the stop of its ring that is best."""
    made = outcomes_of_each(problem, found, goal, scenarios)
    return [Counted(one, own, own.best(asked)) for one, own in zip(found, made, strict=True)]


def drawn(problem: Problem, imagers: Imagers, own: Found, count: int, rng: np.random.Generator) -> list[Found]:
    """Hardware at random whose views do what is asked at likeliest values: from all, and with some parts like ours."""
    made, (low, high) = [], problem.count_range
    same = np.stack([imagers.camera == own.camera, imagers.lens == own.lens, imagers.port == own.port])
    near = np.flatnonzero(same.sum(axis=0) >= 2)
    for number in range(count):
        alike = number % 2 == 1 and len(near) > 0
        row = int(rng.choice(near) if alike else rng.integers(len(imagers)))
        light, lamps = int(rng.integers(len(problem.parts.lights))), int(rng.integers(low, high + 1))
        if alike and rng.random() < 0.5:
            light, lamps = own.light, own.count
        mount = problem.mounts[int(rng.integers(len(problem.mounts)))]
        made.append(found_of(problem, imagers, row, light, lamps, own.lighting.mount if alike else mount))
    return made


def found_of(problem: Problem, imagers: Imagers, row: int, light: int, count: int, mount: Any) -> Found:
    """Hardware as a search names it, without settings."""
    return Found(
        imager=row, camera=int(imagers.camera[row]), lens=int(imagers.lens[row]), port=int(imagers.port[row]),
        landscape=bool(imagers.landscape[row]), light=light, count=max(count, 1),  # no lamp is one of them
        lighting=Lighting(int(problem.lights.optics_index[light]), 0, mount), minimised=np.nan, power_w=np.nan,
        cost=np.nan, mass_kg=np.nan, snr_db=np.nan, settings=[], pulse_s=0.0,
    )  # fmt: skip


def chosen(problem: Problem, imagers: Imagers, result: Result) -> Found:
    """The recommended hardware.

    It may be no imager of the list: one of them, in a housing that costs and weighs more and holds it more often.
    """
    assert result.recommendation is not None
    wanted, parts = result.recommendation.hardware, problem.parts
    ids = {kind: part.id for kind, part in wanted.named.items()}
    camera, lens, light = (
        next(k for k, part in enumerate(some) if part.id == ids[kind])
        for kind, some in (("camera", parts.cameras), ("lens", parts.lenses), ("light", parts.lights))
    )
    landscape = wanted.orientation == "landscape"
    for port, mount in product(range(len(parts.ports)), problem.mounts):
        some = found_of(problem, imagers, 0, light, wanted.light_count, mount)
        found = replace(some, camera=camera, lens=lens, port=port, landscape=landscape)
        own = {kind: part.id for kind, part in pieces_by_kind(problem, found).items()}
        if all(own.get(kind) == name for kind, name in ids.items() if kind in own):
            return found
    raise LookupError(f"{ids} is not among the parts")


HEAD = """\
# How certain, and at what price in time

Every mission in `problems/` and `problems/jobs/` at a confidence of {asked:g}: `python docs/make_certain.py --write
--seconds {seconds:g} --jobs {jobs}`, of which an attack may last {seconds:g} s of the processor.
Times are seconds of the processor for a whole `solve`, doubts included, at likeliest values and at that confidence.
*Claimed* is the share of fresh scenarios in which the recommended system holds, as its result tells it, with the
interval of 95 %; *counted* is that share by `evaluate` in 10 000 others. The attack draws {tries} other pieces of
hardware; *hold* are those that do at a first look in {screen} scenarios, *better* those that hold as often as asked,
with a better median objective than the recommended by more than {much:g} %, or with any where it does not hold.
A star: good practice is relaxed there, and what is drawn is held to as little of it as what is recommended.
Where nothing is proven, what 1 024 scenarios cannot tell apart (1 % of the median) is chosen by price.

| mission | status | central, s | certain, s | ratio | claimed | counted | median | drawn | hold | better |
|---|---|---|---|---|---|---|---|---|---|---|
"""


def page(rows: list[Row], asked: float, tries: int, seconds: float, jobs: int) -> str:
    """The page."""
    text = HEAD.format(asked=asked, tries=tries, seconds=seconds, jobs=jobs, much=100 * BETTER_REL, screen=SCREEN)
    text += "".join(line(row) + "\n" for row in rows)
    solved = [row for row in rows if row.claimed is not None]
    enough = sum(row.claimed.enough for row in solved if row.claimed is not None)
    text += (
        f"\n{len(solved)} of {len(rows)} missions have a recommendation, {enough} one that holds as often as asked; "
        f"{sum(not row.better and row.better is not None for row in solved)} stood the attack. "
        f"The longest took {max(row.certain_s for row in rows):.1f} s, the largest ratio is "
        f"{max(row.certain_s / row.central_s for row in rows):.1f}.\n"
    )
    told = [f"- `{row.name}`: {100 * (ratio - 1):+.1f} % of the median, holds in {100 * held:.1f} %: {parts}"
            for row in solved for ratio, held, parts in row.better or []]  # fmt: skip
    return text + ("\nWhat was better:\n\n" + "\n".join(told) + "\n" if told else "")


def line(row: Row) -> str:
    """One mission's row of the table."""
    times = f"{row.central_s:.1f} | {row.certain_s:.1f} | {row.certain_s / row.central_s:.1f}"
    known, again = row.claimed, row.again
    if known is None or again is None:
        return f"| `{row.name}` | {row.status} | {times} | | | | | | |"
    claimed = f"{100 * known.held:.1f} % ({100 * known.held_low:.0f} to {100 * known.held_high:.0f})"
    median = "" if known.objective_p50 is None else format_quantity(known.objective_p50, row.unit, 4)
    better = f"**{len(row.better)}**" if row.better else "0"
    star = "*" if row.gave_way else ""
    return (
        f"| `{row.name}`{star} | {row.status} | {times} | {claimed} | {100 * again.held:.1f} % | {median} | "
        f"{row.tried}{row.note} | {row.hold} | {better} |"
    )


def mission_names() -> list[str]:
    """Every mission in problems/ and problems/jobs/, as its path there without the ending."""
    files = [*sorted(PROBLEMS.glob("*.yaml")), *sorted(PROBLEMS.glob("jobs/*.yaml"))]
    return [p.relative_to(PROBLEMS).with_suffix("").as_posix() for p in files if ".system" not in p.name]


def main() -> None:
    """Solve, count, attack; print or write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--only", nargs="*", choices=mission_names())
    parser.add_argument("--confidence", type=float, default=0.9)
    parser.add_argument("--tries", type=int, default=96, help="of hardware drawn; a full run takes 2000")
    parser.add_argument("--seconds", type=float, default=60.0, help="that an attack may last")
    parser.add_argument("--jobs", type=int, default=1, help="times are true of one")
    given = parser.parse_args()
    asked = given.only or mission_names()
    same = [given.confidence] * len(asked), [given.tries] * len(asked), [given.seconds] * len(asked)
    with ProcessPoolExecutor(given.jobs, max_tasks_per_child=1) as pool:
        rows = list(pool.map(looked_at, asked, *same))
    text = page(rows, given.confidence, given.tries, given.seconds, given.jobs)
    if given.write:
        PAGE.write_text(text, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()

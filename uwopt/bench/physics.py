"""Physics `paper`, `auto` and `full`, and how finely `full` is integrated: differences of figures against time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from uwopt.bench.suite import BenchRow, BenchTable, Budget, Suite, error_text, timed
from uwopt.evaluation.accuracy import FINEST, relative_change
from uwopt.evaluation.design import evaluate_design
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.effects import effects_kept
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.mission.mission import Mission
from uwopt.model.fineness import DEFAULT, Fineness
from uwopt.objectives.goal import goal_of
from uwopt.results.design import Design
from uwopt.solvers.settable.rounding import given_of
from uwopt.units import is_number

NAME = "physics"
COARSE, FINE = Fineness(*[0.5] * len(Fineness.names())), Fineness(*[2.0] * len(Fineness.names()))
REFERENCE = Fineness(*[FINEST] * len(Fineness.names()))
METHODS = ("paper", "auto", "full, half the nodes", "full", "full, twice the nodes")
OF_FIGURE = "figure"  # status of a row that is about one figure; the others tell the largest
DECIDING = (
    "fov_x_m", "fov_y_m", "gsd_mm", "blur_px", "overlap", "dof_m", "snr_db", "snr_db_min", "mean_level",
    "saturation_fraction", "contrast", "uniformity", "mtf_half_nyquist", "power_w", "cost", "mass_kg",
)  # fmt: skip


@dataclass(frozen=True)
class Subject:
    """One system in one mission, with its settings."""

    name: str
    mission: Mission
    parts: Parts
    hardware: Hardware
    given: tuple[SceneSettings, ...]

    def problem(self, physics: str, fineness: Fineness = DEFAULT) -> Problem:
        """Tables for this system alone."""
        count = self.hardware.count
        return Problem(
            self.mission, self.parts, paper=physics == "paper", counts=(count, count), mounts=[self.hardware.mount],
            fineness=fineness,
        )  # fmt: skip

    def evaluated(self, problem: Problem) -> Design:
        """Figures of the system."""
        return evaluate_design(problem, self.hardware, list(self.given), goal_of(self.mission))


def subjects(missions: Sequence[str]) -> Iterator[Subject]:
    """The best system of each mission, found by the exact search in physics `full`."""
    from uwopt.bench.contest import mission_of
    from uwopt.forward.assembly import load_catalog
    from uwopt.solvers.recommend import seek

    sources: Sequence[str | None] = missions or (None,)
    for source in sources:
        mission = mission_of(source, "full")
        sought = seek(mission, load_catalog(mission), goal_of(mission), generic="never")
        if not sought.outcome.best:
            continue
        found = sought.outcome.best[0]
        given = tuple(given_of(sought.problem, found.hardware, found.settings))
        own = sought.problem.parts.of(found)
        parts = Parts.of_each(lambda kind, own=own: [own[kind]])
        name = mission.name if source is None else Path(source).stem
        yield Subject(
            name,
            mission,
            parts,
            found.hardware.alone,
            given,
        )


def measure(budget: Budget) -> Iterator[BenchRow]:
    """Each system in every physics; a row for every figure, and one for the largest that decides."""
    missions = budget.missions[:1] if budget.quick else budget.missions
    for number, subject in enumerate(subjects(missions)):
        if number and budget.left_s <= 0:
            return
        budget.tell(number / max(len(missions), 1), subject.name)
        reference = subject.evaluated(subject.problem("full", REFERENCE))
        for method in METHODS:
            design, seconds = timed(worker(subject, method), repeats=1 if budget.quick else 3)
            differences = differences_of(design, reference)
            largest = max((differences[name] for name in DECIDING if name in differences), default=0.0)
            yield BenchRow(NAME, subject.name, method, time_s=seconds, error=largest, seed=budget.seed)
            for figure, error in differences.items():
                yield BenchRow(
                    NAME, subject.name, method, time_s=seconds, error=error, status=OF_FIGURE, note=figure
                )


def worker(subject: Subject, method: str) -> Any:
    """What evaluates the system by one method, tables included."""
    physics = method.split(",")[0]
    fineness = {"full, half the nodes": COARSE, "full, twice the nodes": FINE}.get(method, DEFAULT)
    if physics != "auto":
        return lambda: subject.evaluated(subject.problem(physics, fineness))

    def by_auto() -> Design:
        from uwopt.evaluation.influences import influences_of

        problem = subject.problem("full")
        kept = effects_kept(influences_of(problem, subject.hardware, list(subject.given)))
        return subject.evaluated(problem.with_effects(kept))

    return by_auto


def differences_of(design: Design, reference: Design) -> dict[str, float]:
    """Largest relative difference of each figure over the scenes; what a method leaves out is not told."""
    found: dict[str, float] = {}
    for one, other in zip(design.scenes, reference.scenes, strict=True):
        for name, value in one.figures.items():
            if is_number(value) and is_number(other.figures.get(name)):
                found[name] = max(found.get(name, 0.0), relative_change(name, value, other.figures[name]))
    return found


def tables(rows: Sequence[BenchRow]) -> list[BenchTable]:
    """Largest difference of each figure by method, and times."""
    head = ("figure", *METHODS)
    of_figures = [row for row in rows if row.status == OF_FIGURE]
    worst = {
        (row.note, row.method): max(
            r.error or 0.0 for r in of_figures if (r.note, r.method) == (row.note, row.method)
        )
        for row in of_figures
    }
    names = list(dict.fromkeys(row.note for row in of_figures))
    shown = [name for name in names if any(worst.get((name, method), 0.0) > 0.0 for method in METHODS)]
    cells = [[name, *(error_text(worst.get((name, method))) for method in METHODS)] for name in shown]
    whole = [row for row in rows if row.status != OF_FIGURE]
    seconds = [
        f"{1e3 * median([row.time_s or 0.0 for row in whole if row.method == method] or [0.0]):.0f} ms"
        for method in METHODS
    ]
    largest = [
        error_text(max((row.error or 0.0 for row in whole if row.method == method), default=0.0))
        for method in METHODS
    ]
    return [
        BenchTable(
            "Time, and largest difference of a figure that decides", head,
            [["time of one system", *seconds], ["largest difference", *largest]],
            f"Deciding: {', '.join(DECIDING)}. Decibels count as the ratio they stand for.",
        ),
        BenchTable("Largest difference by figure, over all systems", head, cells, "Empty: left out by the method."),
    ]  # fmt: skip


SUITE = Suite(
    name=NAME,
    title="Physics and fineness",
    text=(
        "The best system of each mission, with its settings, in physics paper, auto and full, and in full with half "
        "and twice the nodes of every integral. Differences are relative, against full with four times the nodes. "
        "Time is that of one system with all its tables, from the parts as records. To be read off: what each physics "
        "leaves out, and that the default nodes are within 1e-4 of finer ones."
    ),
    chart="precision",
    measure=measure,
    quick_s=6.0,
    full_s=60.0,
    size_name="nodes",
    time_name="time of one system, s",
    error_name="largest relative difference of a deciding figure",
    tables=tables,
    charted=lambda row: row.status != OF_FIGURE,
)

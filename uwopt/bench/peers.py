"""Gap over time of single-objective solvers against the certificate of the exact search: the suite `solvers`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from statistics import median
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.bench.contest import (
    LONGEST_S,
    Contest,
    LoopGround,
    Referee,
    Snapshot,
    VectorGround,
    at_most,
    mission_of,
    sources_of,
)
from uwopt.bench.suite import BenchRow, BenchTable, Budget, Suite
from uwopt.deadline import NEVER, Deadline
from uwopt.errors import UwoptError
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.solvers.continuous.opinions import why_not_smooth
from uwopt.solvers.continuous.pieces import SmoothDesign, SmoothSettings
from uwopt.solvers.continuous.solve_settings import FEASIBLE, solve_settings
from uwopt.solvers.exact.imagers import Imagers
from uwopt.solvers.exact.ranking import Ranking
from uwopt.solvers.exact.search import Search

TARGET = 1e-3  # relative gap that counts as arrived
CASES_A_TABLE = 5  # missions beside each other
TIMES_TEXT = (
    "Median of the seeds; “not in”: the longest that a run had. “-”: the method cannot be asked; “not "
    "run”: no time was left for it. A peer that arrives "
    "does not know it: only the exact search ends with a proof."
)
EXACT = "exact"
OF_NLOPT = ("slsqp", "mma", "ccsaq", "lbfgs", "cobyla", "isres", "ags", "direct_l", "mlsl")
PROVEN = "optimal"
CANDIDATES = 8  # hardware open to Bonmin's choice at a time
RANDOM_AT_ONCE = 100  # vectors
INFEASIBLE = 1e12  # above every value: infeasible vectors are compared by their violation
LONGEST_RUN_S, SHORTEST_RUN_S = 8.0, 0.4
SPARE = 1.5  # runs of many may take longer than their even share, since some end early


class NotApplicableError(Exception):
    """A method cannot be asked about this mission; the text says why."""


# ---------------------------------------------------------------- the exact search


class Watched(Ranking):
    """A ranking that claims what is best before a referee."""

    def __init__(self, search: WatchedSearch, plain: Ranking):
        super().__init__(plain.problem, plain.imagers, top=plain.top, ceiling=plain.ceiling)
        self.search = search

    def add(self, *args: Any, **more: Any) -> None:
        """As a ranking does."""
        super().add(*args, **more)
        if self.best:
            self.search.referee.evaluations = self.search.account.evaluated
            self.search.referee.claim(
                self.best[0].minimised, self.best[0].hardware, self.best[0].settings
            )


class WatchedSearch(Search):
    """The exact search, whose best designs are written down as they come."""

    def __init__(self, problem: Problem, objective: Objective, referee: Referee):
        super().__init__(problem, objective, top=1, progress=None)
        self.referee = referee

    def prepare(self, deadline: Deadline = NEVER) -> Imagers:
        """As a search does."""
        imagers = super().prepare(deadline)
        self.ranking = Watched(self, self.ranking)
        return imagers


def exact(referee: Referee) -> str:
    """The exact search to the end of its proof."""
    search = WatchedSearch(referee.problem, referee.contest.objective, referee)
    outcome = search.whole()
    referee.evaluations = outcome.account.evaluated
    return PROVEN if outcome.complete else "stopped"


# ---------------------------------------------------------------- hardware one by one, settings by a solver


def by_settings(name: str) -> Callable[[Referee, int], None]:
    """A continuous solver within a loop over hardware."""

    def run(referee: Referee, seed: int) -> None:
        from uwopt.bench.nlopt_peers import OTHERS

        method: Any = OTHERS.get(name, name)
        smooth_or_raise(referee)
        ground = LoopGround(referee)
        for built, rows in ground.batches(np.random.default_rng(seed)):
            floor = ground.floor(built)
            for i in range(len(built.imager)):
                if referee.over():
                    return
                if floor[i] < referee.best:
                    solve_one(ground, method, built, i, [r.take(np.array([i])) for r in rows])

    return run


def solve_one(ground: LoopGround, method: Any, built: Any, i: int, rows: list[Any]) -> None:
    """The settings of one hardware, claimed if the solver says that they are feasible."""
    referee = ground.referee
    found = solve_settings(
        SmoothDesign.of(rows, **ground.fixed(built, i)), objective=ground.objective,
        power_limit_w=ground.power_limit_w, method=method, max_seconds=max(referee.left_s, 1e-3),
    )  # fmt: skip
    referee.evaluations += found.iterations
    if found.objective_value is None or found.status not in ("optimal", "feasible"):
        return
    settings = [numbers(row, at) for row, at in zip(rows, found.settings, strict=True)]
    ground.claim(found.objective_value, built, i, settings)


def numbers(row: Any, at: SmoothSettings) -> dict[str, float]:
    """One scene's settings as the evaluation takes them."""
    exposure_s = float(row.exposure_s(np.array([at.time_s]))[0])
    return {
        "f_number": at.f_number, "time_s": at.time_s, "level": at.level, "gain": at.gain, "exposure_s": exposure_s,
    }  # fmt: skip


def bonmin(referee: Referee, seed: int) -> None:
    """Bonmin over a few hardware at a time, in the same order as the continuous solvers."""
    smooth_or_raise(referee)
    from uwopt.solvers.continuous.casadi_ipopt import solve_mixed
    from uwopt.solvers.continuous.mixed import MixedProgram

    ground = LoopGround(referee)
    for built, rows in ground.batches(np.random.default_rng(seed)):
        for start in range(0, len(built.imager), CANDIDATES):
            if referee.over():
                return
            some = range(start, min(start + CANDIDATES, len(built.imager)))
            taken = {i: [r.take(np.array([i])) for r in rows] for i in some}
            candidates = [SmoothDesign.of(taken[i], **ground.fixed(built, i)) for i in some]
            program = MixedProgram(candidates, ground.objective, ground.power_limit_w)
            if not program.options:
                continue
            answer = solve_mixed(program, max_seconds=max(referee.left_s, 1e-2))
            picked = program.picked(answer.x)
            if picked.max_violation <= FEASIBLE:
                place = start + picked.candidate
                settings = [numbers(row, at) for row, at in zip(taken[place], picked.settings, strict=True)]
                ground.claim(picked.value, built, place, settings)


def smooth_or_raise(referee: Referee) -> None:
    """Whether the settings of this mission are a smooth program at all."""
    why_not = why_not_smooth(referee.problem, referee.contest.objective)
    if why_not:
        raise NotApplicableError(why_not)


# ---------------------------------------------------------------- vectors of hardware and settings


def genetic(referee: Referee, seed: int) -> None:
    """pymoo's genetic algorithm."""
    from uwopt.bench import pymoo_single

    ground = VectorGround(referee)
    if not ground.coding.empty:
        first = ground.coding.random(pymoo_single.POP_SIZE, np.random.default_rng(seed))
        pymoo_single.genetic(ground.evaluate, ground.coding.upper, first, seed=seed, over=referee.over)


def differential(referee: Referee, seed: int) -> None:
    """SciPy's differential evolution with integrality, a whole generation at once."""
    from scipy.optimize import Bounds, differential_evolution

    ground = VectorGround(referee)
    if ground.coding.empty:
        return
    upper = ground.coding.upper
    free = np.nonzero(upper > 0)[0]  # a gene of one value is no variable

    def penalised(x: Array) -> Array:
        vectors = np.zeros((x.shape[1], len(upper)), int)
        vectors[:, free] = np.rint(x.T)
        values, violation = ground.evaluate(vectors)
        return np.asarray(np.where(violation > 0.0, INFEASIBLE * (1.0 + violation), values))

    differential_evolution(
        penalised, Bounds(np.zeros(len(free)), upper[free]), integrality=np.ones(len(free), bool), rng=seed,
        polish=False, vectorized=True, updating="deferred", maxiter=1_000_000, tol=0.0,
        callback=lambda intermediate_result: referee.over(),
    )  # fmt: skip


def random_search(referee: Referee, seed: int) -> None:
    """Vectors at random."""
    ground = VectorGround(referee)
    rng = np.random.default_rng(seed)
    while not ground.coding.empty and not referee.over():
        ground.evaluate(ground.coding.random(RANDOM_AT_ONCE, rng))


#: Every peer by name.
PEERS: dict[str, Callable[[Referee, int], None]] = {
    "casadi-ipopt": by_settings("casadi"),
    "bonmin": bonmin,
    **{f"nlopt-{name.replace('_', '-')}": by_settings(name) for name in OF_NLOPT},
    "pymoo-ga": genetic,
    "scipy-de": differential,
    "random": random_search,
}


def load_libraries() -> None:
    """Import what the peers need before any clock starts."""
    for name in ("uwopt.solvers.continuous.casadi_ipopt", "uwopt.bench.nlopt_peers", "uwopt.bench.pymoo_single"):
        import_module(name)
    import_module("scipy.optimize")


# ---------------------------------------------------------------- runs as rows


def run_exact(contest: Contest) -> list[BenchRow]:
    """The exact search as rows: its best designs as they came, and the end of its proof."""
    referee = Referee(contest, np.inf, contest.problem())
    status = exact(referee)
    took_s = referee.time_s
    return run_rows(
        contest, EXACT, None, referee.seen, Snapshot(took_s, referee.evaluations, referee.gap), status
    )


def run_peer(contest: Contest, method: str, seed: int, seconds: float) -> list[BenchRow]:
    """One peer as rows."""
    referee = Referee(contest, seconds, contest.problem())
    try:
        PEERS[method](referee, seed)
    except NotApplicableError as why:
        nothing = Snapshot(0.0, 0, None)
        return run_rows(contest, method, seed, [], nothing, "not applicable", str(why))
    except UwoptError as fault:
        end = Snapshot(referee.time_s, referee.evaluations, referee.gap)
        return run_rows(contest, method, seed, referee.seen, end, "failed", str(fault).splitlines()[0])
    took_s, gap = referee.time_s, referee.gap
    status = "reached" if gap is not None and gap <= TARGET else "stopped"
    note = f"within {seconds:.3g} s"
    if referee.refused:
        note += f"; {referee.refused} claims that the forward model does not confirm"
    return run_rows(
        contest, method, seed, referee.seen, Snapshot(took_s, referee.evaluations, gap), status, note
    )


def run_rows(
    contest: Contest,
    method: str,
    seed: int | None,
    seen: Sequence[Snapshot],
    last: Snapshot,
    status: str,
    note: str = "",
) -> list[BenchRow]:
    """What was seen of a run, and its end."""
    made = [
        BenchRow(
            "solvers", contest.name, method, float(s.evaluations), seed, s.time_s, s.gap_rel, status="running"
        )
        for s in seen
    ]
    made.append(
        BenchRow(
            "solvers",
            contest.name,
            method,
            float(last.evaluations),
            seed,
            last.time_s,
            last.gap_rel,
            status=status,
            note=note,
        )
    )
    return made


def measure(budget: Budget, methods: Sequence[str] | None = None) -> Iterator[BenchRow]:
    """Every mission: certificate, exact search, then every peer with every seed, as long as there is time."""
    load_libraries()
    names = list(PEERS) if methods is None else list(methods)
    seeds = [budget.seed] if budget.quick else [budget.seed + k for k in range(3)]
    sources = sources_of(budget)
    left, total = len(sources) * len(seeds) * len(names), len(sources) * len(seeds) * len(names)
    for case, source in sources:
        contest = Contest.of(case, mission_of(source), longest_s=at_most(LONGEST_S, budget))
        if contest.best is None or not contest.complete:
            yield BenchRow("solvers", case, EXACT, status="infeasible" if contest.complete else "stopped")
            left -= len(seeds) * len(names)
            continue
        fair_s = 0.0  # a peer has at least the time that the exact search took for its proof
        for _ in seeds:
            rows = run_exact(contest)
            fair_s = max([fair_s, *(row.time_s or 0.0 for row in rows)])
            yield from rows
        for seed in seeds:
            for method in names:
                share_s = (1.0 if budget.quick else SPARE) * max(budget.left_s, 0.0) / left
                left -= 1
                if budget.left_s <= 0.0:
                    return
                budget.tell(1.0 - (left + 1) / total, f"{case}: {method}")
                seconds = min(LONGEST_RUN_S, max(SHORTEST_RUN_S, share_s, fair_s))
                yield from run_peer(contest, method, seed, min(seconds, max(budget.left_s, 0.05)))


# ---------------------------------------------------------------- tables


def arrivals(rows: Sequence[BenchRow], case: str, method: str) -> tuple[list[float], float, str]:
    """Seconds to the target by seed (inf: not within its time), the longest time any had, and why not at all."""
    runs: list[list[BenchRow]] = [[]]
    for row in rows:
        if row.case == case and row.method == method:
            runs[-1].append(row)
            if row.status != "running":
                runs.append([])
    times, longest, status = [], 0.0, ""
    for run in runs:
        if run:
            near = [
                r.time_s for r in run if r.error is not None and r.error <= TARGET and r.time_s is not None
            ]
            times.append(min(near, default=np.inf))
            longest, status = max(longest, run[-1].time_s or 0.0), run[-1].status
    return times, longest, status


def proof_s(rows: Sequence[BenchRow], case: str) -> float:
    """Median seconds until the exact search has its proof."""
    ends = [
        r.time_s
        for r in rows
        if (r.case, r.method, r.status) == (case, EXACT, PROVEN) and r.time_s is not None
    ]
    return median(ends) if ends else np.inf


def cell(times: Sequence[float], longest: float, status: str) -> str:
    """Seconds, or that there were not enough."""
    if status in ("not applicable", "infeasible"):
        return "-" if status == "not applicable" else status
    if not times:
        return "not run"
    middle = median(times)
    return f"{middle:.2f}" if np.isfinite(middle) else f"not in {longest:.1f}"


def time_tables(rows: Sequence[BenchRow]) -> list[BenchTable]:
    """Seconds to the target by method and mission, a few missions a table."""
    cases = list(dict.fromkeys(row.case for row in rows))
    methods = [name for name in PEERS if any(row.method == name for row in rows)]
    made = []
    for start in range(0, len(cases), CASES_A_TABLE):
        some = cases[start : start + CASES_A_TABLE]
        body = [
            ["exact, found", *(cell(*arrivals(rows, case, EXACT)) for case in some)],
            ["exact, proven", *(cell([proof_s(rows, case)], 0.0, "") for case in some)],
            *([name, *(cell(*arrivals(rows, case, name)) for case in some)] for name in methods),
        ]
        last = start + CASES_A_TABLE >= len(cases)
        made.append(
            BenchTable(f"Seconds to a gap of {TARGET:g}", ["method", *some], body, TIMES_TEXT if last else "")
        )
    return made


def ahead_table(rows: Sequence[BenchRow]) -> BenchTable:
    """Whether the exact search has its proof before the fastest peer has arrived."""
    body = []
    for case in dict.fromkeys(row.case for row in rows):
        peers = {name: median(t) for name in PEERS if (t := arrivals(rows, case, name)[0])}
        proven = proof_s(rows, case)
        if not peers or not np.isfinite(proven):
            continue
        first = min(peers, key=lambda name: peers[name])
        found = arrivals(rows, case, EXACT)[0]
        best_s = median(found) if found else np.inf
        if not np.isfinite(peers[first]):
            verdict, told = "exact: no peer arrived", "-"
        else:
            told = f"{first}, {peers[first]:.2f}"
            if proven <= peers[first]:
                verdict = f"exact, {peers[first] / proven:.1f} times, proof included"
            elif best_s <= peers[first]:
                verdict = "exact has the design first, its proof takes longer"
            else:
                verdict = f"{first}, which does not know it"
        body.append([case, f"{best_s:.2f}", f"{proven:.2f}", told, verdict])
    return BenchTable(
        f"Who is first at a gap of {TARGET:g}",
        ["mission", "exact, found, s", "exact, proven, s", "fastest peer, s", "ahead"],
        body,
        "The exact search counts up to the end of its proof, a peer up to a design not known to be best. So "
        "a peer can be first where many systems tie, of which any will do for it while the exact search goes on to "
        "break the tie; where few systems are open at all, so that drawing is as quick as bounding; and where the "
        "objective is a price, which light does not change, so that a proof has to look at whatever is cheaper.",
    )


SUITE = Suite(
    name="solvers",
    title="Single-objective solvers against the exact search",
    text=(
        "The gap is that of the best feasible system so far, checked by the forward model, to the certificate's lower "
        "bound. All runs take place on this machine, one after the other, with libraries imported and the mission's "
        "parts loaded before the clock starts; everything after that counts, for the exact search up to the end of "
        "its proof. All begin with the table of imagers: cameras, lenses and ports that give the wanted images as "
        "long as there is light. Solvers of continuous settings (casadi-ipopt, NLopt's) and Bonmin get hardware from "
        "a loop: 200 000 draws at a time, in order of what they cost the objective without any light, equals as the "
        "seed drew them, without what limits forbid or cannot beat the best; light is worked out for 256 together, "
        "and what gets too little is left out at once; Bonmin chooses among 8 at a time. Populations and random "
        "search work on integer vectors without lamps that surely are too weak, by the exact search's bounds; they "
        "are decoded into settings that requirements allow, mostly in closed form. Populations begin at random, as "
        "their documentation has it: a start at the best bounds would hand them the answer. "
        "pymoo's GA has its defaults with the operators that its page on discrete variables gives; SciPy's "
        "differential evolution its defaults with integrality, whole generations at once, infeasible vectors "
        "compared by violation; NLopt's algorithms are run as its page says what each takes; Bonmin with B-BB, "
        "which its manual advises where functions may not be convex. "
        "A run ends with its time, or within 1e-6 of the certificate."
    ),
    chart="progress",
    measure=measure,
    quick_s=18.0,
    full_s=900.0,
    size_name="evaluations",
    time_name="elapsed time, s",
    error_name="relative gap to the certificate",
    tables=lambda rows: (ahead_table(rows), *time_tables(rows)),
)

"""Time limits, on clocks that the tests turn by hand, and work as a clock."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from typer.testing import CliRunner

from uwopt.api import doubting, pricing
from uwopt.api import solving as api
from uwopt.api import trading as api_pareto
from uwopt.api.common import prepared
from uwopt.api.evaluating import evaluate
from uwopt.api.watch import STAGES, Watch
from uwopt.cli.app import app
from uwopt.cli.options import command_deadline, time_to_answer
from uwopt.cli.status import result_status
from uwopt.deadline import COSTS_S, Deadline, OutOfTimeError, UntilFound, effort_s, spend
from uwopt.errors import MissionError
from uwopt.results.result import Result
from uwopt.solvers.exact.search import Search
from uwopt.solvers.explain import robustness
from uwopt.solvers.infeasible.relaxer import Relaxer
from uwopt.solvers.infeasible.trials import Trials

ROOT = Path(__file__).parents[1]
TANK = ROOT / "problems" / "paper-tank.yaml"
TOOL = ROOT / "problems" / "paper-tool-window.yaml"
FEW_PARTS = {"cameras": ["flir"], "lenses": ["kowa"]}


def test_a_time_that_is_no_number_is_told() -> None:
    with pytest.raises(MissionError, match="'5 s' is no number"):
        Deadline.asked(cast(Any, "5 s"))


class Clock:
    """Shows what it is told, and so much more at each reading."""

    def __init__(self, step_s: float = 0.0):
        self.now_s, self.step_s, self.readings = 0.0, step_s, 0

    def __call__(self) -> float:
        self.readings += 1
        self.now_s += self.step_s
        return self.now_s


@pytest.fixture
def limited(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], Clock]:
    """Let deadlines of a call run on a clock of the test, which moves by a step at each reading."""

    def prepare(step_s: float = 0.0) -> Clock:
        clock, honest = Clock(step_s), Deadline.after
        monkeypatch.setattr(Deadline, "after", lambda seconds: honest(seconds, clock))
        return clock

    return prepare


@pytest.fixture
def ends_with_search(monkeypatch: pytest.MonkeyPatch, limited: Callable[[float], Clock]) -> Clock:
    """The time is over as soon as the first search is done."""
    clock, honest = limited(0.0), Search.run

    def run(self: Search) -> Any:
        outcome = honest(self)
        clock.now_s = math.inf
        return outcome

    monkeypatch.setattr(Search, "run", run)
    return clock


def mission(**changes: Any) -> Any:
    return prepared(TANK, "paper", None).with_changes(**changes)


def time_warning(result: Any) -> str:
    [text] = [item["message"] for item in result.warnings if item["code"] == "time"]
    return str(text)


# ---------------------------------------------------------------- the object


def test_it_passes_when_the_clock_reaches_its_end() -> None:
    clock = Clock()
    deadline = Deadline.after(10.0, clock)
    clock.now_s = 9.0
    assert not deadline.passed() and deadline.left_s == 1.0
    clock.now_s = 10.0
    assert deadline.passed() and deadline.left_s == 0.0
    with pytest.raises(OutOfTimeError):
        deadline.check()


def test_without_a_number_it_never_passes() -> None:
    clock = Clock()
    deadline = Deadline.after(None, clock)
    clock.now_s = 1e30
    assert not deadline.passed() and deadline.left_s == math.inf


@pytest.mark.parametrize(("seconds", "left_s"), [(3.0, 3.0), (30.0, 10.0)])
def test_of_two_limits_the_sooner_holds(seconds: float, left_s: float) -> None:
    assert Deadline.after(10.0, Clock()).at_most(seconds).left_s == left_s


def test_what_has_no_time_is_left_out_and_told() -> None:
    clock = Clock()
    deadline = Deadline.after(1.0, clock)
    assert deadline.within("first", lambda: 1, 0) == 1
    clock.now_s = 2.0
    assert deadline.within("second", lambda: 1, 0) == 0
    assert deadline.left_out == ["second"]


def test_what_runs_out_of_time_midway_is_left_out_and_told() -> None:
    clock = Clock()
    deadline = Deadline.after(1.0, clock)

    def slow() -> int:
        clock.now_s = 5.0
        deadline.check()
        return 1

    assert deadline.within("slow", slow, 0) == 0
    assert deadline.left_out == ["slow"]


# ---------------------------------------------------------------- a command


@pytest.mark.parametrize(("loading_s", "writes", "left_s"), [
    (1.0, False, 8.7), (1.0, True, 7.0), (8.0, True, 1.5), (11.0, True, 0.0),
])  # fmt: skip
def test_the_time_of_a_command_is_also_what_it_takes_to_load_and_to_write(
    limited: Callable[[float], Clock], loading_s: float, writes: bool, left_s: float
) -> None:
    clock, limit = limited(0.0), command_deadline(10.0)
    clock.now_s = loading_s
    assert time_to_answer(limit, writes=writes) == pytest.approx(left_s)
    assert time_to_answer(Deadline(), writes=writes) is None


# ---------------------------------------------------------------- solve


def test_what_else_is_listed_ends_with_the_time_and_that_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(1.0)
    limit = Deadline.after(2.5, clock)
    found = SimpleNamespace(outcome=SimpleNamespace(best=["best", "second", "third", "fourth"]))
    monkeypatch.setattr(doubting, "design_of", lambda sought, one, *, with_rounding: one)
    assert doubting.others_in_time(cast(Any, found), limit) == ["second", "third"]
    assert limit.left_out == ["more of the next best systems"]


def test_time_that_ends_with_the_search_leaves_the_proof_and_nothing_more(ends_with_search: Clock) -> None:
    wanted = mission(catalog={**FEW_PARTS, "generic": "never"})
    result = api.solve(wanted, seconds=1.0, accuracy=True, alternatives=True, audit=5)
    assert result.status == "optimal" and result_status(result) == 0
    assert (result.robustness, result.solvers, result.audit["tried"]) == (None, [], 0)
    told = time_warning(result)
    for what in ("how firm the answer is", "second opinions", "errors of figures", "the audit's 5 attempts"):
        assert what in told


def test_time_that_ends_with_the_search_leaves_infeasibility_unexplained(ends_with_search: Clock) -> None:
    wanted = mission(catalog={**FEW_PARTS, "generic": "never"}, limits={"power_w": 0.001})
    result = api.solve(wanted, seconds=1.0)
    assert result.status == "infeasible" and result_status(result) == 3
    assert result.infeasible["relaxations"] == []
    assert "whether it could be met without power_w" in time_warning(result)


def test_what_requirements_cost_has_the_time_that_the_search_leaves(
    ends_with_search: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    given: list[float | None] = []
    monkeypatch.setattr(pricing, "every_price", lambda *told: (given.append(told[2].left_s) or [], True))
    assert CliRunner().invoke(app, ["explain", str(TANK), "--seconds", "5", "--quiet"]).exit_code == 0
    assert given == [0.0]


def test_enough_time_leaves_nothing_out(limited: Callable[[float], Clock]) -> None:
    limited(0.0)
    result = api.solve(mission(catalog={**FEW_PARTS, "generic": "never"}), seconds=1.0)
    assert result.robustness and result.solvers
    assert not [item for item in result.warnings if item["code"] == "time"]


@pytest.mark.parametrize("step_s", [0.0, 1.0])
def test_evaluation_leaves_out_what_time_does_not_reach(step_s: float, limited: Callable[[float], Clock]) -> None:
    limited(step_s)
    system = TANK.with_suffix(".system.yaml")
    result = evaluate(TANK, system, physics="paper", accuracy=True, confidence=0.5, seconds=0.5)
    assert result.design is not None and result.objective["value"] > 0.0
    assert (result.confidence is None) == (step_s > 0.0)
    told = [item for item in result.warnings if item["code"] == "time"]
    assert bool(told) == (step_s > 0.0)
    if told:
        assert "errors of figures" in time_warning(result) and STAGES["certainty"] in time_warning(result)


@pytest.mark.parametrize("readings", [1, 2, 3, 5, 8, 20, 40])
def test_wherever_time_ends_the_result_is_sound(readings: int, limited: Callable[[float], Clock]) -> None:
    limited(1.0)
    wanted = mission(catalog=FEW_PARTS)
    result = api.solve(wanted, seconds=readings + 0.5)
    assert result.certificate.adds_up()
    assert result.status in ("stopped", "optimal")
    if result.recommendation is not None:
        assert result.recommendation.feasible
        assert result.certificate.lower_bound <= result.objective["value"] * (1 + 1e-9)


def test_an_interrupted_explanation_keeps_what_helps(monkeypatch: pytest.MonkeyPatch) -> None:
    honest = Relaxer.seek

    def seek(*args: Any, depth_m: float | None = None, **more: Any) -> Any:
        if depth_m == 0.0:  # the last requirement that is dropped
            raise KeyboardInterrupt
        return honest(*args, depth_m=depth_m, **more)

    monkeypatch.setattr(Relaxer, "seek", seek)
    result = api.solve(mission(catalog={**FEW_PARTS, "generic": "never"}, limits={"power_w": 0.001}))
    assert result.status == "infeasible" and result_status(result) == 130
    assert [item["name"] for item in result.infeasible["relaxations"]] == ["power_w"]


def test_one_requirement_takes_a_quarter_of_the_time_to_explain() -> None:
    work = Trials(mission(), None, None, "never", Deadline.after(40.0, Clock()))  # type: ignore[arg-type]
    assert work.turn().left_s == 10.0


def test_doubts_that_are_known_when_time_ends_are_told(
    monkeypatch: pytest.MonkeyPatch, limited: Callable[[float], Clock]
) -> None:
    clock, honest = limited(0.0), robustness.robustness

    def and_then_time_ends(*args: Any, **more: Any) -> Any:
        found = honest(*args, **more)
        clock.now_s = math.inf
        return found

    monkeypatch.setattr(robustness, "robustness", and_then_time_ends)
    result = api.solve(mission(catalog=FEW_PARTS), seconds=60.0)
    assert result.robustness["max_regret"] is not None and result.robustness["waters"] == []
    assert "other waters" in time_warning(result) and "how firm" not in time_warning(result)


def test_a_search_for_any_design_ends_with_the_first() -> None:
    found: list[int] = []
    until = UntilFound.of(Deadline(40.0, Clock()), lambda: bool(found))
    assert until.left_s == 40.0 and not until.passed()
    found.append(1)
    assert until.passed()


def test_quick_leaves_doubts_out_and_nothing_else() -> None:
    told: list[str] = []
    wanted = mission(catalog=FEW_PARTS)
    result = api.solve(wanted, quick=True, so_far=told.append)
    full = api.solve(wanted)
    assert result.robustness is None and result.solvers == [] and full.robustness is not None
    assert result.recommendation == full.recommendation and result.warnings == full.warnings
    [line] = [what for what in told if what.startswith("proven best: ")]
    assert all(part in line for part in full.recommendation.hardware.ids)


def test_recommendation_is_told_before_its_doubts() -> None:
    told: list[Any] = []
    wanted = mission(catalog=FEW_PARTS)
    result = api.solve(wanted, progress=lambda share, what: told.append(what), first=told.append)
    [first] = [item for item in told if isinstance(item, Result)]
    assert told.index(first) < told.index(STAGES["robustness"])
    assert first.recommendation == result.recommendation and first.certificate == result.certificate
    assert first.robustness is None and result.robustness is not None


# ---------------------------------------------------------------- pareto


def test_solvers_of_a_front_share_the_time(limited: Callable[[float], Clock]) -> None:
    # of 60 s 8 are kept for the figures of the points, of 10 s three in ten
    for given_s, turn_s in ((60.0, 52.0 / 3), (10.0, 7.0 / 3)):
        run = api_pareto.ParetoCall(mission(), None, (), None, [], 0, Watch(Deadline.after(given_s, Clock())))  # type: ignore[arg-type]
        assert run.turn(3, usual_s=10.0).left_s == pytest.approx(turn_s)


def test_solvers_of_a_front_have_the_usual_time_without_a_limit() -> None:
    run = api_pareto.ParetoCall(mission(), None, (), None, [], 0, Watch(Deadline.after(None, Clock())))  # type: ignore[arg-type]
    assert run.turn(3, usual_s=10.0).left_s == 10.0


def test_explanation_of_an_empty_front_has_the_time_that_is_left(ends_with_search: Clock) -> None:
    wanted = mission(catalog={**FEW_PARTS, "generic": "never"}, limits={"power_w": 0.001})
    front = api_pareto.pareto(wanted, objectives=["power", "cost"], solver="exact", seconds=1.0)
    assert front.status == "infeasible"
    assert "whether it could be met without power_w" in time_warning(front)


# ---------------------------------------------------------------- work as a clock


def spent_on_a_solve() -> float:
    """What one cold solve counts."""
    before = effort_s()
    api.solve(TOOL, quick=True)
    return effort_s() - before


def test_the_same_work_counts_the_same_whatever_the_machine_does_beside() -> None:
    first = spent_on_a_solve()
    assert first > 0.0
    assert spent_on_a_solve() == pytest.approx(first, rel=1e-9)


def test_threads_count_their_own_work() -> None:
    other: list[float] = []

    def work() -> None:
        spend("bounds", 1000)
        other.append(effort_s())

    before = effort_s()
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert other == [pytest.approx(1000 * COSTS_S["bounds"])]
    assert effort_s() == before

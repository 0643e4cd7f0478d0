"""Works done side by side make what they make one after another, whoever does them and whatever becomes of a copy."""

from __future__ import annotations

import contextlib
import os
import select
import signal
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

import uwopt
from uwopt.deadline import COSTS_S, Deadline, effort_s, processor_s, spend
from uwopt.errors import SolverError
from uwopt.solvers import beside
from uwopt.solvers.beside import ahead, cores, shares, side_by_side, tell

WAIT_S = 100.0  # for what never comes if works are not done side by side
copied = pytest.mark.skipif(not beside.COPIES, reason="this system makes no copies of a process")


@pytest.fixture(autouse=True)
def every_machine_has_two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(beside, "usable_cores", lambda: 2)


def in_two_processes(work: Callable[[], Any]) -> list[Any]:
    """What a work makes here and in a copy: each waits until the other has begun."""
    (from_one, by_one), (from_two, by_two) = os.pipe(), os.pipe()

    def met(own: int, other: int) -> Any:
        os.write(own, b"!")
        if not select.select([other], [], [], WAIT_S)[0]:
            raise TimeoutError
        return work()

    try:
        with cores():
            return side_by_side([lambda: met(by_one, from_two), lambda: met(by_two, from_one)])
    finally:
        for one in (from_one, by_one, from_two, by_two):
            os.close(one)


@copied
def test_two_works_run_at_once_in_two_processes() -> None:
    ids = in_two_processes(os.getpid)
    assert len(set(ids)) == 2 and os.getpid() in ids
    (copy,) = {*ids} - {os.getpid()}
    with pytest.raises(ChildProcessError):
        os.waitpid(copy, os.WNOHANG)  # it is not left


@copied
def test_what_is_waited_for_in_the_end_is_told() -> None:
    """The copy's work ends only once it is."""
    (is_told, tell), (has_begun, begin), numbers = os.pipe(), os.pipe(), list[int]()

    def long() -> bool:
        os.write(begin, b"!")
        return bool(select.select([is_told], [], [], WAIT_S)[0])

    def begins(number: int) -> None:
        numbers.append(number)
        if number == 1:
            os.write(tell, b"!")

    with cores(2):
        made = side_by_side([lambda: bool(select.select([has_begun], [], [], WAIT_S)[0]), long], begins=begins)
    assert made == [True, True] and numbers == [0, 1]
    for one in (is_told, tell, has_begun, begin):
        os.close(one)


@copied
def test_the_first_work_is_done_here() -> None:
    """What it made is known even where a person wants no more before the copies are done."""
    assert all(in_two_processes(os.getpid)[0] == os.getpid() for _ in range(3))


def until(deadline: Deadline) -> int:
    """How much a work does of what it may: designs in thousands."""
    done = 0
    while not deadline.passed():
        spend("designs", 1000)
        done += 1
    return done


@pytest.mark.parametrize("count", [1, 2])
def test_a_limit_of_work_ends_a_work_at_the_same_place_on_every_machine(count: int) -> None:
    """Each of two has 10 thousand designs, whichever goes before it; so has what is done ahead of as much else."""
    with cores(count):
        deadline = Deadline.after(10.5 * 1000 * COSTS_S["designs"], effort_s)
        work = partial(until, deadline)
        assert side_by_side([work, work]) == [11, 11]
        deadline = Deadline.after(10.5 * 1000 * COSTS_S["designs"], effort_s)
        with ahead(partial(until, deadline)) as asked:
            spend("designs", 5000)
            before_s = effort_s()
            assert asked() == 11
    assert effort_s() - before_s == pytest.approx(11 * 1000 * COSTS_S["designs"])


@pytest.mark.parametrize("count", [1, 2, 3])
def test_what_is_made_counted_and_appended_is_that_of_works_in_order(count: int) -> None:
    told: list[str] = []

    def work(number: int) -> int:
        spend("views", number)
        told.append(f"work {number}")
        return number * number

    before_s = effort_s()
    with cores(count):
        made = side_by_side([lambda number=number: work(number) for number in range(5)], lists=[told])  # type: ignore[misc]
    assert made == [0, 1, 4, 9, 16]
    assert told == [f"work {number}" for number in range(5)]
    assert effort_s() - before_s == pytest.approx(0.0045 * 10)


@pytest.mark.parametrize("count", [1, 2])
def test_there_may_be_more_works_than_a_byte_counts(count: int) -> None:
    with cores(count):
        assert side_by_side([lambda number=number: number for number in range(600)]) == list(range(600))  # type: ignore[misc]


@pytest.mark.parametrize(("count", "sizes"), [(0, [0]), (1, [1]), (19, [19]), (20, [10, 10]), (99, [49, 50])])
def test_shares_hold_everything_once_on_every_machine(count: int, sizes: list[int]) -> None:
    for n_cores in (1, 4):
        with cores(n_cores):
            parts = [list(range(count))[part] for part in shares(count, 10)]
        assert [len(part) for part in parts] == sizes
        assert [number for part in parts for number in part] == list(range(count))


def test_nobody_is_copied_unless_the_caller_says_so() -> None:
    assert set(side_by_side([os.getpid] * 4)) == {os.getpid()}


def test_copies_make_no_copies() -> None:
    with cores(2):
        inner = side_by_side([lambda: (os.getpid(), set(side_by_side([os.getpid] * 4)))] * 2)
    assert all(pids == {pid} or pid == os.getpid() for pid, pids in inner)


@pytest.mark.parametrize("count", [1, 2])
def test_the_first_fault_is_raised(count: int) -> None:
    def fail(text: str) -> None:
        raise SolverError(text)

    with cores(count), pytest.raises(SolverError, match="second"):
        side_by_side([int, lambda: fail("second"), lambda: fail("third")])


@copied
def test_the_work_of_a_copy_that_is_ended_is_done_here() -> None:
    here = os.getpid()

    def work() -> int:
        if os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)
        return os.getpid()

    with cores(2):
        assert side_by_side([work] * 4) == [here] * 4


@copied
def test_what_cannot_be_sent_is_made_here() -> None:
    with cores(2):
        made = side_by_side([lambda: lambda: 1, lambda: lambda: 2])
    assert [one() for one in made] == [1, 2]


@copied
def test_an_interrupted_process_leaves_no_copy() -> None:
    here, (told, tells) = os.getpid(), os.pipe()

    def work() -> None:
        if os.getpid() == here:
            select.select([told], [], [], WAIT_S)
            raise KeyboardInterrupt
        os.write(tells, str(os.getpid()).encode())
        select.select([], [], [], WAIT_S)

    with cores(2), pytest.raises(KeyboardInterrupt):
        side_by_side([work] * 2)
    copy = int(os.read(told, 20))
    for one in (told, tells):
        os.close(one)
    with pytest.raises(ChildProcessError):
        os.waitpid(copy, os.WNOHANG)


@pytest.mark.parametrize("count", [1, 2])
def test_what_works_tell_is_heard_whoever_does_them(count: int) -> None:
    heard: list[str] = []

    def work(number: int) -> int:
        for turn in range(3):
            tell(f"{number}: {turn}")
        return number

    with cores(count):
        made = side_by_side([partial(work, number) for number in range(4)], hears=heard.append)
    assert made == [0, 1, 2, 3]
    own = [[one for one in heard if one.startswith(f"{number}:")] for number in range(4)]
    assert own == [[f"{number}: {turn}" for turn in range(3)] for number in range(4)]
    tell("after them")
    assert len(heard) == 12


@copied
def test_what_a_copy_has_told_before_an_interruption_is_heard() -> None:
    here, (told, tells), heard = os.getpid(), os.pipe(), list[str]()

    def work() -> None:
        if os.getpid() == here:
            select.select([told], [], [], WAIT_S)
            raise KeyboardInterrupt
        tell("known")
        os.write(tells, b"!")
        select.select([], [], [], WAIT_S)

    with cores(2), pytest.raises(KeyboardInterrupt):
        side_by_side([work] * 2, hears=heard.append)
    assert heard == ["known"]
    for one in (told, tells):
        os.close(one)


@copied
def test_a_copys_processor_clock_goes_on_where_it_was() -> None:
    before_s = processor_s()
    assert min(in_two_processes(processor_s)) >= before_s > 0.0


PARTS: dict[str, Any] = {
    "scene": {"water": "II", "seafloor": 0.2, "depth_m": 30}, "practice": "bare",
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3, "light_count": [1, 4]},
    "requirements": {"overlap": 0.3, "max_blur_px": 1.0, "min_snr_db": 10},
    "catalog": {
        "cameras": ["flir-bfs-u3-120s4m"], "lenses": ["kowa-lm8"], "ports": ["blue-robotics-4*"], "lights": ["bigblue"],
        "generic": "never",
    },
}  # fmt: skip


PLAIN: dict[str, Any] = {"physics": "paper"}


@pytest.mark.parametrize(
    ("confidence", "given"),
    [("central", PLAIN), (0.9, PLAIN | {"doubt": {"scenarios": 32}})],
    ids=["central", "certain"],
)
def test_a_result_does_not_tell_how_many_cores_worked_on_it(confidence: str | float, given: dict[str, Any]) -> None:
    """By plain physics, as one process works through searches and scenarios, whatever they cost."""

    def told(count: int) -> dict[str, Any]:
        with cores(count):
            result = uwopt.solve(PARTS | given, confidence=confidence, top=2, ranges=True, alternatives=True)
        return {name: value for name, value in vars(result).items() if name not in ("timing_s", "solvers")}

    one = told(1)
    assert one["robustness"] and one["alternatives"] and one["prices"]
    assert one == told(2)


@pytest.mark.parametrize("count", [1, 2])
def test_what_is_done_ahead_counts_and_appends_where_it_is_asked_for(count: int) -> None:
    """Whoever does it: here once it is asked for, or a copy meanwhile."""
    told: list[str] = []

    def work() -> str:
        spend("views", 2)
        told.append("ahead")
        return "made"

    before_s = effort_s()
    with cores(count), ahead(work, lists=[told]) as asked:
        told.append("before")
        assert effort_s() == before_s
        assert asked() == "made"
    assert told == ["before", "ahead"]
    assert effort_s() - before_s == pytest.approx(0.0045 * 2)


@copied
def test_what_is_done_ahead_is_done_by_a_copy_while_this_process_works() -> None:
    begun, begins = os.pipe()
    with cores(2), ahead(lambda: (os.write(begins, b"!"), os.getpid())) as asked:
        assert select.select([begun], [], [], WAIT_S)[0]  # before anybody asks
        assert asked()[1] != os.getpid()
    os.close(begun)
    os.close(begins)


@copied
@pytest.mark.parametrize("fault", [KeyboardInterrupt, None])
def test_what_was_not_asked_for_is_ended(fault: type[BaseException] | None, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[int] = []  # this process may have other children, as a browser of other tests
    fork = os.fork
    monkeypatch.setattr(os, "fork", lambda: made.append(fork()) or made[-1])
    with contextlib.suppress(KeyboardInterrupt), cores(2), ahead(lambda: select.select([], [], [], WAIT_S)):
        if fault is not None:
            raise fault
    (copy,) = made
    with pytest.raises(ChildProcessError):
        os.waitpid(copy, os.WNOHANG)


@copied
def test_what_a_copy_that_is_ended_did_ahead_is_done_here() -> None:
    here = os.getpid()

    def work() -> int:
        if os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)
        return os.getpid()

    with cores(2), ahead(work) as asked:
        assert asked() == here


@pytest.mark.parametrize("count", [1, 2])
def test_a_fault_of_what_is_done_ahead_is_raised_where_it_is_asked_for(count: int) -> None:
    def fail() -> None:
        raise SolverError("ahead")

    with cores(count), ahead(fail) as asked, pytest.raises(SolverError, match="ahead"):
        asked()

"""Progress: a bar for a person, lines for a log, nothing for who wants none."""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Callable

import pytest

from uwopt.report.text.console import ProgressBar, print_blocks
from uwopt.report.text.layout import Joined, Text, fact_lines, sentence


class Timer:
    """A timer that rings when a test says so."""

    made: list[Timer]
    daemon = False

    def __init__(self, seconds: float, then: Callable[[], None]):
        self.then, self.started, self.cancelled = then, False, False
        Timer.made.append(self)

    def start(self) -> None:
        self.started = True

    def cancel(self) -> None:
        self.cancelled = True


Log = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def no_timer() -> None:
    """Timers of this test only."""
    Timer.made = []


def test_a_log_gets_a_line_each_time_the_timer_rings(capsys: Log) -> None:
    with ProgressBar(timer=Timer) as bar:  # type: ignore[arg-type]
        assert bar.report is not None
        bar.report(0.25, "search")
        Timer.made[-1].then()
        bar.report(0.5, "search")
        Timer.made[-1].then()
    assert len(Timer.made) == 3  # the first, and one after each line
    text = capsys.readouterr().err
    first, second = text.splitlines()
    assert first.startswith("uwopt: search, 25 % of this step, ") and second.startswith("uwopt: search, 50 % of this")
    assert "\r" not in text and "\x1b" not in text


@pytest.mark.parametrize(("of_all", "share"), [(True, 0.9), (False, None)])
def test_no_bar_falls_back(monkeypatch: pytest.MonkeyPatch, of_all: bool, share: float | None) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr(sys, "stderr", Terminal())
    with ProgressBar(of_all=of_all, timer=Timer) as bar:  # type: ignore[arg-type]
        assert bar.report is not None
        bar.report(0.9, "settings of systems")
        Timer.made[-1].then()
        bar.report(0.1, "search")
        (task,) = bar._bar.tasks
        assert task.description.startswith("search") and task.total == (share and 1.0)  # none: it only moves
        assert share is None or task.completed == share


def test_a_log_tells_the_stage_where_nobody_knows_its_share(capsys: Log) -> None:
    with ProgressBar(timer=Timer) as bar:  # type: ignore[arg-type]
        assert bar.report is not None
        bar.report(1.0, "search")
        Timer.made[-1].then()
        bar.report(0.0, "how firm the answer is")
        Timer.made[-1].then()
    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith("uwopt: search, ") and "%" not in first  # many searches follow one that is over
    assert second.startswith("uwopt: how firm the answer is, ")


def test_a_line_stays_in_the_log(capsys: Log) -> None:
    with ProgressBar(timer=Timer) as bar:  # type: ignore[arg-type]
        bar.line("proven best: a + b")
    assert re.fullmatch(r"uwopt: proven best: a \+ b \(\d+ s\)\n", capsys.readouterr().err)


def test_what_is_soon_done_writes_nothing_into_a_log(capsys: Log) -> None:
    with ProgressBar(timer=Timer) as bar:  # type: ignore[arg-type]
        assert bar.report is not None
        bar.report(0.25, "search")
    assert capsys.readouterr().err == "" and Timer.made[-1].cancelled


def test_a_timer_that_rings_after_the_end_writes_nothing(capsys: Log) -> None:
    with ProgressBar(timer=Timer):  # type: ignore[arg-type]
        pass
    Timer.made[-1].then()
    assert capsys.readouterr().err == "" and len(Timer.made) == 1


def test_quiet_writes_nothing(capsys: Log) -> None:
    with ProgressBar(quiet=True, timer=Timer) as bar:  # type: ignore[arg-type]
        assert bar.report is None
    assert Timer.made == []


def test_a_log_that_nobody_reads_any_more_stops_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    log = io.StringIO()
    monkeypatch.setattr(sys, "stderr", log)
    with ProgressBar(timer=Timer):  # type: ignore[arg-type]
        log.close()
        Timer.made[-1].then()


def test_a_log_gets_a_line_a_stage_but_no_two_within_a_second(capsys: Log) -> None:
    now_s = [0.0]
    with ProgressBar(timer=Timer, clock=lambda: now_s[0]) as bar:  # type: ignore[arg-type]
        assert bar.report is not None
        for at_s, stage in ((0.5, "one"), (1.2, "two"), (1.4, "two"), (1.9, "three"), (2.4, "four"), (9.0, "four")):
            now_s[0] = at_s
            bar.report(0.0, stage)
    assert capsys.readouterr().err.splitlines() == ["uwopt: two, 1 s", "uwopt: four, 2 s"]


@pytest.mark.parametrize("style", ["", "bold"])
def test_no_line_of_the_terminal_ends_within_an_amount_of_money(style: str) -> None:
    for before in range(60, 88):
        said, out = f"{'n' * before} of 4 000 to 18 000 USD each.", io.StringIO()
        joined = Joined((Text(said[: before + 9], style), Text(said[before + 9 :])))
        print_blocks([sentence(said, style), joined, fact_lines([("price", said)])], out)
        lines = out.getvalue().splitlines()
        assert max(map(len, lines)) <= 100
        assert not [line for line in lines if re.match(r" *(\d\d\d|[A-Z]{3})\b", line)]
        assert " ".join(out.getvalue().split()) == " ".join(f"{said} {said} price {said}".split())

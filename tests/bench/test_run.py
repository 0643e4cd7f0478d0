"""Suites put together: what is kept, what a fault or an interrupt leaves, what the files hold."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from uwopt.bench import run as runner
from uwopt.bench.charts import charts
from uwopt.bench.page import bench_html, suite_csv, write_bench
from uwopt.bench.suite import COLUMNS, BenchRow, BenchTable, Budget, Suite, least_size, timed
from uwopt.cli.app import app
from uwopt.errors import MissionError, SolverError


def suite(
    name: str, *, after: int = 99, fault: BaseException | None = None, chart: Any = "precision"
) -> Suite:
    """A suite of six rows that may break after some of them."""

    def measure(budget: Budget) -> Iterator[BenchRow]:
        for index in range(6):
            if index == after and fault is not None:
                raise fault
            error = None if index == 5 else 10.0**-index
            yield BenchRow(
                name, "case <b>" if index % 2 else "=1+1", f"rule {index % 3}", size=2.0**index, seed=budget.seed,
                time_s=1e-3 * 2**index, error=error, memory_mib=10.0 + index,
            )  # fmt: skip

    def tables(rows: Any) -> list[BenchTable]:
        return [BenchTable("All <of> them", ("rule", "rows"), [["any", str(len(rows))]])]

    return Suite(name, f"Suite {name}", "What it <i>measures</i>.", chart, measure, 1.0, 1.0, tables=tables)


@pytest.fixture
def with_suites(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Let these suites be all there are."""

    def put(*suites: Suite) -> None:
        monkeypatch.setattr(runner, "chosen_suites", lambda names: list(suites))

    return put


def test_every_suite_is_there_and_named_as_it_says():
    found = runner.chosen_suites(())
    assert [one.name for one in found] == list(runner.MODULES)
    for one in found:
        assert one.quick_s > 0 and one.full_s > 0 and one.text.endswith(".")
    assert [one.name for one in runner.chosen_suites(["scaling", "spectral"])] == ["spectral", "scaling"]


def test_an_unknown_suite_is_refused_with_the_nearest():
    with pytest.raises(MissionError, match="did you mean scaling"):
        runner.chosen_suites(["scalin"])


def test_rows_of_all_suites_are_kept(with_suites: Any):
    with_suites(suite("one"), suite("two"))
    seen = []
    made = runner.run(seed=7, keep=lambda bench: seen.append(len(bench.rows)))
    assert seen == [6, 12] and not made.interrupted and not made.faults
    assert {row.seed for row in made.rows} == {7}
    assert made.machine["cores"] >= 1 and made.machine["versions"]["numpy"]


def test_an_interrupt_keeps_what_there_is_and_ends_the_run(with_suites: Any):
    with_suites(suite("one", after=2, fault=KeyboardInterrupt()), suite("two"))
    made = runner.run()
    assert made.interrupted and len(made.rows) == 2 and [one.name for one in made.suites] == ["one"]


def test_a_suite_that_fails_is_told_and_the_next_goes_on(with_suites: Any):
    with_suites(suite("one", after=2, fault=SolverError("no good")), suite("two"))
    made = runner.run()
    assert made.faults == {"one": "no good"} and len(made.rows) == 8


def test_a_quick_run_gives_late_suites_less(with_suites: Any, monkeypatch: pytest.MonkeyPatch):
    given: list[float] = []

    def measure(budget: Budget) -> Iterator[BenchRow]:
        given.append(budget.seconds)
        yield BenchRow("slow", "a", "b")

    slow = Suite("slow", "S", "T.", "precision", measure, 30.0, 30.0)
    with_suites(slow, slow, slow)
    monkeypatch.setattr(runner, "QUICK_S", 0.0)
    runner.run(quick=True)
    assert given == [0.0, 0.0, 0.0]
    runner.run()
    assert given[3:] == [30.0, 30.0, 30.0]
    runner.run(seconds=9.0)
    assert given[6:] == pytest.approx([3.0, 4.5, 9.0], abs=0.5)  # what is left goes to those that follow


def test_files_hold_all_rows_and_are_safe(with_suites: Any, tmp_path: Path):
    with_suites(suite("one"), suite("two", chart="progress"), suite("three", chart="scaling"))
    made = runner.run()
    written = write_bench(made, tmp_path / "new")
    assert {path.name for path in written} == {"one.csv", "two.csv", "three.csv", "bench.json", "bench.html"}
    with (tmp_path / "new" / "one.csv").open() as file:
        rows = list(csv.reader(file))
    assert tuple(rows[0]) == COLUMNS and len(rows) == 7
    assert rows[1][COLUMNS.index("case")] == "'=1+1"  # no formula in a spreadsheet
    data = json.loads((tmp_path / "new" / "bench.json").read_text())
    assert data["schema"] == runner.SCHEMA and len(data["rows"]) == 18
    page = bench_html(made)
    assert "<i>" not in page and "&lt;i&gt;measures" in page and "case <b>" not in page
    assert suite_csv(made, made.suites[1]).count("\n") == 7


@pytest.mark.parametrize("kind", ["precision", "progress", "scaling"])
def test_charts_show_every_point_that_has_time_and_error(kind: str):
    one = suite("one", chart=kind)
    rows = list(one.measure(Budget(True, 1.0)))
    drawn = charts(one, rows)
    points = sum(len(trace["x"]) for picture in drawn for trace in picture["figure"]["data"])
    assert points == (12 if kind == "scaling" else 5)  # time and memory of six; of five there is an error


def test_the_command_prints_tables_and_writes(with_suites: Any, tmp_path: Path):
    with_suites(suite("one"))
    done = CliRunner().invoke(app, ["bench", "--quick", "--out", str(tmp_path / "out")])
    assert done.exit_code == 0 and "Suite one" in done.stdout and (tmp_path / "out" / "bench.html").exists()


@pytest.mark.parametrize(("fault", "status"), [(KeyboardInterrupt(), 130), (SolverError("no good"), 1)])
def test_the_status_tells_how_it_ended(with_suites: Any, tmp_path: Path, fault: BaseException, status: int):
    with_suites(suite("one", after=3, fault=fault))
    done = CliRunner().invoke(app, ["bench", "--out", str(tmp_path)])
    assert done.exit_code == status
    assert len(json.loads((tmp_path / "bench.json").read_text())["rows"]) == 3


def test_missions_may_be_files_or_a_folder_and_must_load(tmp_path: Path):
    root = Path(__file__).parents[2] / "problems"
    found = runner.mission_files([str(root)])
    assert str(root / "reef-mosaic.yaml") in found and not any("system" in name for name in found)
    assert runner.mission_files([str(root / "reef-mosaic.yaml")]) == [str(root / "reef-mosaic.yaml")]
    with pytest.raises(MissionError, match="no mission"):
        runner.mission_files([str(tmp_path)])
    with pytest.raises(MissionError, match=r"nowhere\.yaml"):
        runner.mission_files([str(tmp_path / "nowhere.yaml")])


def test_the_least_size_is_that_from_which_on_all_is_well():
    def row(size: float, error: float | None) -> BenchRow:
        return BenchRow("s", "c", "m", size=size, error=error)

    lucky = [row(6, 1e-3), row(4, 1e-6), row(12, 1e-6), row(8, 1e-5)]  # 4 is well by chance
    assert least_size(lucky, 1e-4) == "8"
    assert least_size([row(9, None), row(17, 1.0)], 1e-4) == "more than 17"
    assert least_size([], 1e-4) == ""


def test_a_clock_takes_runs_long_enough():
    calls = []
    result, seconds = timed(lambda: calls.append(1) or len(calls), at_least_s=0.001, repeats=2)
    assert result == 1 and 0 < seconds < 0.001

"""The command line: what it prints where, and the status it exits with."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import uwopt
from uwopt.api import choosing, doubting
from uwopt.api import solving as api
from uwopt.api.evaluating import evaluate
from uwopt.catalog.edition import AS_OF, EDITION
from uwopt.cli import NO_RESULT
from uwopt.cli.app import app
from uwopt.cli.explore import ended_by_signals
from uwopt.cli.options import PRINT_S
from uwopt.errors import SolverError
from uwopt.report.text.console import print_blocks
from uwopt.report.text.short import short_text_blocks
from uwopt.report.write import page_in
from uwopt.results.basis import WhyNothing
from uwopt.results.result import Certificate, Result
from uwopt.solvers.exact.search import Search

ROOT = Path(__file__).parents[2]
MISSION = ROOT / "problems" / "paper-tank.yaml"
SYSTEM = ROOT / "problems" / "paper-tank.system.yaml"
COMMANDS = [
    [], ["solve"], ["evaluate"], ["catalog"], ["catalog", "list"], ["catalog", "show"], ["catalog", "check"],
    ["catalog", "template"], ["init"], ["schema"], ["report"], ["pareto"], ["whatif"], ["plot"], ["explain"], ["bench"],
    ["sweep"],
]  # fmt: skip
Status = Callable[..., None]


def run(*arguments: object) -> Any:
    return CliRunner().invoke(app, [str(word) for word in arguments])


def program(*arguments: object, **more: Any) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **more.pop("env", {})}
    return subprocess.run(
        [sys.executable, "-m", "uwopt", *map(str, arguments)],
        env=environment, text=True, encoding="utf-8", timeout=120, check=False,
        **({"capture_output": True} | more),
    )  # fmt: skip


def assert_refused(done: Any, *words: str) -> None:
    """Status 2, nothing on standard output, one message without a traceback."""
    assert done.exit_code == 2, done.output
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    for word in words:
        assert word in done.stderr


@pytest.fixture(scope="module")
def evaluated() -> Result:
    """A real result of `evaluate`."""
    return evaluate(MISSION, SYSTEM)


@pytest.fixture
def solving(monkeypatch: pytest.MonkeyPatch, evaluated: Result) -> Callable[..., list[dict[str, Any]]]:
    """Let `api.solve` give a result at once; returns the arguments of its calls."""

    def prepare(**changes: Any) -> list[dict[str, Any]]:
        calls: list[dict[str, Any]] = []
        proof = Certificate(1.0, 1.0, 0.0, 0.0, True, "all", 10, 10, 10, [])
        values = {"command": "solve", "status": "optimal", "design": None, "recommendation": evaluated.design,
                  "certificate": proof, "warnings": []} | changes  # fmt: skip

        def solve(mission: str, **options: Any) -> Result:
            calls.append({"mission": mission, **options})
            return replace(evaluated, **values)

        monkeypatch.setattr(api, "solve", solve)
        return calls

    return prepare


# ---------------------------------------------------------------- help and version


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_every_command_has_help(words: list[str]) -> None:
    done = run(*words, "--help")
    assert done.exit_code == 0
    assert "Usage:" in done.stdout
    assert done.stdout.isascii()  # a plain terminal can show it


def test_version_is_printed() -> None:
    assert run("--version").stdout == f"uwopt {uwopt.__version__}, catalogue {EDITION} of {AS_OF}\n"


def test_help_imports_nothing_heavy() -> None:
    heavy = (
        "numpy",
        "pandas",
        "scipy",
        "pydantic",
        "rich",
        "yaml",
        "casadi",
        "nlopt",
        "pymoo",
        "uwopt.mission.mission",
    )
    code = (
        "import sys\nfrom uwopt.cli.app import app\n"
        "try:\n    app(['--help'])\nexcept SystemExit:\n    pass\n"
        f"print('HEAVY', [name for name in {heavy!r} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert "HEAVY []" in done.stdout


@pytest.mark.parametrize(("given", "taken"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "4"}, "4")])
def test_products_of_matrices_share_no_threads_unless_asked_to(given: dict[str, str], taken: str) -> None:
    rest = {key: value for key, value in os.environ.items() if key != "OPENBLAS_NUM_THREADS"}
    code = (
        "import os, sys\nfrom uwopt.cli.app import main\nassert 'numpy' not in sys.modules\n"
        "sys.argv = ['uwopt', '--version']\n"
        "try:\n    main()\nfinally:\n    print('THREADS', os.environ['OPENBLAS_NUM_THREADS'])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True, env=rest | given
    )
    assert f"THREADS {taken}\n" in done.stdout


def test_module_runs_as_the_command_does() -> None:
    done = program("--version")
    assert (done.returncode, done.stdout) == (0, f"uwopt {uwopt.__version__}, catalogue {EDITION} of {AS_OF}\n")


# ---------------------------------------------------------------- evaluate


def test_evaluate_prints_a_page_for_people_and_all_of_it_when_asked() -> None:
    page, full = run("evaluate", MISSION, SYSTEM), run("evaluate", MISSION, SYSTEM, "--full")
    assert (page.exit_code, full.exit_code) == (0, 0)
    assert "What it costs" in page.stdout and "Margins" not in page.stdout and "--full" in page.stdout
    assert "Margins" in full.stdout and "Bill of materials" in full.stdout
    assert "\x1b" not in page.stdout + full.stdout
    assert page.stderr == full.stderr == ""


def test_solve_prints_a_page_and_all_of_it_when_asked(solving: Status) -> None:
    solving()
    assert "Certificate" not in run("solve", MISSION).stdout
    assert "Certificate" in run("solve", MISSION, "--full").stdout


def test_json_is_all_there_is_on_standard_output() -> None:
    done = run("evaluate", MISSION, SYSTEM, "--json")
    data = json.loads(done.stdout)
    assert data["schema"] == "uwopt.result/1"
    assert data["command"] == "evaluate"


def test_physics_can_be_chosen() -> None:
    data = json.loads(run("evaluate", MISSION, SYSTEM, "--json", "--physics", "paper").stdout)
    assert data["mission"]["physics"] == "paper"


def test_who_has_a_page_is_not_told_how_to_write_one(solving: Status, tmp_path: Path) -> None:
    solving()
    with_page = run("solve", MISSION, "--out", tmp_path / "out")
    assert "--full adds" in with_page.stdout and "--out DIR writes" not in with_page.stdout
    assert "--out DIR writes" in run("solve", MISSION).stdout


def test_result_files_are_written(tmp_path: Path) -> None:
    done = run("evaluate", MISSION, SYSTEM, "--out", tmp_path / "new")
    assert done.exit_code == 0
    assert json.loads((tmp_path / "new" / "result.json").read_text("utf-8"))["command"] == "evaluate"
    rows = list(csv.DictReader((tmp_path / "new" / "bom.csv").read_text("utf-8").splitlines()))
    assert [row["kind"] for row in rows][:4] == ["camera", "lens", "port", "light"]
    assert "result.json" in done.stderr


@pytest.mark.parametrize(("status", "options", "code"), [
    ("feasible", ["--check"], 0), ("violated", ["--check"], 3), ("violated", [], 0),
])  # fmt: skip
def test_check_turns_a_missed_requirement_into_status_3(
    monkeypatch: pytest.MonkeyPatch, evaluated: Result, status: str, options: list[str], code: int
) -> None:
    monkeypatch.setattr("uwopt.api.evaluating.evaluate", lambda *a, **k: replace(evaluated, status=status))
    assert run("evaluate", MISSION, SYSTEM, *options).exit_code == code


# ---------------------------------------------------------------- solve


@pytest.mark.parametrize(("changes", "code"), [
    ({}, 0),
    ({"status": "infeasible", "recommendation": None}, 3),
    ({"status": "stopped"}, 4),
    ({"status": "stopped", "warnings": [{"code": "interrupted", "path": "", "message": "interrupted"}]}, 130),
    ({"audit": {"tried": 5, "passed": True, "better": []}}, 0),
    ({"audit": {"tried": 5, "passed": False, "better": [{"camera": "x"}]}}, 1),
])  # fmt: skip
def test_status_of_the_result_is_the_exit_status(solving: Status, changes: dict[str, Any], code: int) -> None:
    solving(**changes)
    done = run("solve", MISSION)
    assert done.exit_code == code
    assert "paper" in done.stdout.casefold() or "tank" in done.stdout.casefold()


def test_options_reach_the_search(solving: Callable[..., list[dict[str, Any]]]) -> None:
    calls = solving()
    done = run(
        "solve", MISSION, "--solver", "nlopt", "--objective", "power=1, cost=0.01", "--physics", "full", "--top", 3,
        "--audit", 7, "--seconds", 2.5, "--accuracy", "--tolerance", "0.001", "--quiet",
    )  # fmt: skip
    assert done.exit_code == 0
    assert 0.0 < calls[0].pop("seconds") <= 2.5 - PRINT_S  # what the command takes beside it is of its time
    assert calls == [
        {"mission": str(MISSION), "solver": "nlopt", "objective": {"power": 1.0, "cost": 0.01}, "physics": "full",
         "confidence": None, "top": 3, "audit": 7, "alternatives": False, "ranges": False,
         "accuracy": True, "tolerance": 0.001, "progress": None, "quick": False, "first": calls[0]["first"],
             "so_far": calls[0]["so_far"], "hold_practice": False},
    ]  # fmt: skip


def test_page_begins_before_the_doubts_and_is_the_same_page(
    monkeypatch: pytest.MonkeyPatch, evaluated: Result
) -> None:
    made = replace(evaluated, command="solve", status="optimal", design=None, recommendation=evaluated.design)

    def solve(mission: str, **options: Any) -> Result:
        if options["first"] is not None:
            options["first"](made)
            print("doubts")
        return made

    monkeypatch.setattr(api, "solve", solve)
    begun, whole, as_json = (
        run("solve", MISSION, *more) for more in ((), ("--full",), ("--json",))
    )
    before, rest = begun.stdout.split("doubts\n")
    assert "Buy" in before and "What it costs" in before and "risk" not in before.casefold()
    assert "risk" in rest and "Buy" not in rest and rest.startswith("\n")
    page = io.StringIO()
    print_blocks(short_text_blocks(made), page)
    assert before + rest == page.getvalue()
    assert "doubts" not in whole.stdout and json.loads(as_json.stdout)["status"] == "optimal"


def test_what_a_page_has_no_time_for_is_told_where_it_is_written(solving: Status, tmp_path: Path) -> None:
    solving()
    done = run("solve", MISSION, "--seconds", "1e-6", "--out", tmp_path)
    assert "no time was left for drawings, " in done.stderr and "`uwopt report` makes them" in done.stderr
    assert "no time" not in run("solve", MISSION).stderr


def test_mission_decides_what_is_not_asked_for(solving: Callable[..., list[dict[str, Any]]]) -> None:
    calls = solving()
    run("solve", MISSION)
    assert calls[0]["objective"] is None and calls[0]["physics"] is None and calls[0]["seconds"] is None


def test_explain_says_what_holds_a_confidence_that_it_does_not(solving: Callable[..., list[dict[str, Any]]]) -> None:
    calls, wreck = solving(), ROOT / "problems" / "jobs" / "wreck.yaml"
    refused = run("explain", wreck, "--confidence", "0.9")
    assert refused.exit_code == 2 and not calls
    told = " ".join(run("explain", wreck).stdout.split())
    assert "a confidence of 0.9, which the mission asks for, is not held here" in told
    for said in (" ".join(refused.stderr.split()), told):
        assert "`uwopt whatif MISSION --vary KEY=VALUES --confidence 0.9` tells what more" in said
    assert "not held here" not in run("explain", MISSION).stdout


def test_interruption_before_a_result_is_status_130(monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(*a: Any, **k: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(api, "solve", stop)
    done = run("solve", MISSION)
    assert done.exit_code == 130
    assert "interrupted" in done.stderr and done.stdout == ""


@pytest.mark.parametrize(
    ("where", "stage"),
    [
        (doubting, "told_together"), (doubting, "second_opinions"), (api, "estimator_of_search"),
        (choosing, "best_settable"), (doubting, "others_in_time"),
    ],
)  # fmt: skip
def test_interruption_after_the_proof_keeps_what_is_proven(
    where: Any, stage: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    work, calls = getattr(where, stage), []

    def once_interrupted(*args: Any, **kwargs: Any) -> Any:
        calls.append(args)
        if len(calls) == 1:
            raise KeyboardInterrupt
        return work(*args, **kwargs)

    monkeypatch.setattr(where, stage, once_interrupted)
    done = run("solve", MISSION, "--physics", "paper", "--accuracy", "--json")
    assert done.exit_code == 130
    result = json.loads(done.stdout)
    assert result["status"] == "optimal" and result["certificate"]["complete"]


def test_interruption_of_what_follows_the_proof_keeps_the_next_best(monkeypatch: pytest.MonkeyPatch) -> None:
    """They were found with the best, and are worked out beside second opinions, which a person ends here."""

    def stop(*a: Any, **k: Any) -> None:
        raise KeyboardInterrupt

    whole = api.solve(MISSION, physics="paper", quick=True)
    monkeypatch.setattr(doubting, "second_opinions", stop)
    cut = api.solve(MISSION, physics="paper")
    assert [note.code for note in cut.warnings].count("interrupted") == 1
    assert [one.hardware.ids for one in cut.runners_up] == [one.hardware.ids for one in whole.runners_up] != []


@pytest.mark.parametrize("stage", ["how firm the answer is", "second opinions", "what other makers offer"])
def test_progress_tells_each_stage_after_the_search_and_may_end_it(stage: str) -> None:
    def progress(share: float, what: str) -> None:
        if what == stage:
            raise KeyboardInterrupt

    result = api.solve(MISSION, physics="paper", alternatives=True, progress=progress)
    assert result.status == "optimal" and result.recommendation is not None
    assert [note.code for note in result.warnings].count("interrupted") == 1


def test_interruption_of_how_firm_it_is_keeps_second_opinions_and_prices(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are worked out first; all of them were lost with what was not."""

    def stop() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(doubting, "doubts_of", lambda *_: {"robustness": stop, "waters": stop})
    result = api.solve(MISSION, physics="paper")
    assert result.prices and any(one.agrees for one in result.solvers) and result.robustness is None
    assert [note.code for note in result.warnings].count("interrupted") == 1
    (told,) = [note.message for note in result.warnings if note.code == "interrupted"]
    assert told.endswith("worked out: second opinions, what requirements cost; not, or not all: how firm the answer is")


def test_interruption_before_a_system_is_status_130(monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(*a: Any, **k: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Search, "_best_first", stop)
    done = run("solve", MISSION, "--quiet")
    assert done.exit_code == 130
    assert "interrupted before a system was found" in done.stdout and "limit" not in done.stdout


@pytest.mark.parametrize(
    "fault", [SolverError("the claim does not hold"), ZeroDivisionError("division by zero"), MemoryError()]
)
def test_defects_are_told_without_a_traceback(monkeypatch: pytest.MonkeyPatch, fault: Exception) -> None:
    def fail(*a: Any, **k: Any) -> None:
        raise fault

    monkeypatch.setattr(api, "solve", fail)
    monkeypatch.delenv("UWOPT_DEBUG", raising=False)
    done = run("solve", MISSION)
    assert done.exit_code == 1
    assert "Traceback" not in done.output and len(done.stderr.splitlines()) <= 3
    monkeypatch.setenv("UWOPT_DEBUG", "1")
    assert "Traceback" in run("solve", MISSION).stderr


def test_result_that_cannot_be_written_is_still_printed(
    monkeypatch: pytest.MonkeyPatch, solving: Status, tmp_path: Path
) -> None:
    solving()
    at_once = api.solve

    def taken(*a: Any, **k: Any) -> Result:
        (tmp_path / "out").touch()  # somebody makes a file there while we solve
        return at_once(*a, **k)

    monkeypatch.setattr(api, "solve", taken)
    done = run("solve", MISSION, "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert "What it costs" in done.stdout
    assert "is a file, not a folder" in done.stderr


def test_who_writes_an_order_reads_how_makers_are_asked(tmp_path: Path, undoubted: None) -> None:
    out = tmp_path / "out"
    done = run("solve", ROOT / "problems" / "paper-tool-window.yaml", "--physics", "paper", "--quick", "--out", out)
    assert done.exit_code == 0, done.stderr
    asked = f"uwopt tender {out}/result.json --out {out}/tender"
    assert asked.split() == done.stderr.split()[-len(asked.split()):]  # fmt: skip


# ---------------------------------------------------------------- report


@pytest.fixture
def result_file(evaluated: Result, tmp_path: Path) -> Path:
    """A result to make a report of."""
    file = tmp_path / "result.json"
    file.write_text(evaluated.to_json(), encoding="utf-8")
    return file


@pytest.fixture
def infeasible_file(result_file: Path, evaluated: Result) -> Path:
    """A result without a design: its page is written at once, for it has no pictures."""
    result = replace(
        evaluated, command="solve", status="infeasible", design=None, infeasible=WhyNothing([], [], None)
    )
    result_file.write_text(result.to_json(), encoding="utf-8")
    return result_file


@pytest.mark.parametrize(("out", "written"), [
    ([], "report.html"), (["--out", "page.html"], "page.html"), (["--out", "new"], "new/report.html"),
    (["--out", "a/b/page.htm"], "a/b/page.htm"), (["--out", "there"], "there/report.html"),
])  # fmt: skip
def test_report_goes_beside_the_result_or_where_it_is_asked_for(
    infeasible_file: Path, monkeypatch: pytest.MonkeyPatch, out: list[str], written: str
) -> None:
    folder = infeasible_file.parent
    monkeypatch.chdir(folder)
    (folder / "there").mkdir()
    done = run("report", infeasible_file.name, *out)
    assert done.exit_code == 0, done.stderr
    assert done.stdout == "" and "written: " in done.stderr
    assert (folder / written).read_text("utf-8").startswith("<!doctype html>")
    assert run("report", infeasible_file.name, *out, "--quiet").stderr == ""  # again, and silently


def test_report_of_a_report_is_the_same(result_file: Path, evaluated: Result) -> None:
    out = result_file.parent / "out"
    from uwopt.report.write import write_results

    write_results(evaluated, out)
    before = (out / "report.html").read_bytes()
    assert run("report", out / "result.json").exit_code == 0
    assert (out / "report.html").read_bytes() == before


def test_report_of_an_infeasible_result_is_done(infeasible_file: Path) -> None:
    assert run("report", infeasible_file).exit_code == 0
    assert "Why nothing fits" in (infeasible_file.parent / "report.html").read_text("utf-8")


def test_report_refuses_what_is_no_result(tmp_path: Path, result_file: Path) -> None:
    (tmp_path / "cut.json").write_text(result_file.read_text("utf-8")[:900], encoding="utf-8")
    (tmp_path / "file").touch()
    assert_refused(run("report"), "RESULT.json")
    assert_refused(run("report", tmp_path / "none.json"), "no such file")
    assert_refused(run("report", tmp_path), "is a folder", "result.json")
    (mission := tmp_path / "mission.yaml").write_text("name: mine\n", "utf-8")
    assert_refused(run("report", result_file, "--out", mission), "must end in .html")
    assert mission.read_text("utf-8") == "name: mine\n"
    assert_refused(run("report", tmp_path / "cut.json"), "cut off")
    assert_refused(run("report", MISSION), "is not JSON")
    assert_refused(run("report", result_file, "--out", result_file), "must end in .html")
    assert_refused(run("report", result_file, "--out", tmp_path / "new.pdf"), "must end in .html", "as PDF")
    assert_refused(run("card", result_file, "--out", tmp_path / "card.pdf"), "must end in .html", "as PDF")
    assert page_in(str(tmp_path), "card.html") == str(tmp_path / "card.html")  # of both, as of `--out DIR` elsewhere
    assert_refused(run("report", result_file, "--out", tmp_path / "file" / "x.html"))
    assert_refused(run("report", result_file, "--out", ""), "empty")
    assert not (tmp_path / "report.html").exists()


# ---------------------------------------------------------------- bad input


@pytest.mark.parametrize(("options", "words"), [
    (["--objective", "powr"], ["--objective", "powr", "did you mean power?"]),
    (["--objective", "power=much"], ["power=much"]),
    (["--objective", "power=1,power=2"], ["stands twice"]),
    (["--objective", "power=0"], ["no weight is above 0"]),
    (["--objective", "power=-1"], ["power=-1"]),
    (["--seconds", "0"], ["--seconds", "above 0"]),
    (["--seconds", "nan"], ["--seconds"]),
    (["--tolerance", "0"], ["tolerance", "above 0"]),
    (["--tolerance", "nan"], ["tolerance"]),
    (["--tolerance", "0.6"], ["at most 0.5"]),
    (["--top", "0"], ["--top"]),
    (["--audit", "-1"], ["--audit"]),
    (["--solver", "magic"], ["--solver", "magic"]),
    (["--physics", "none"], ["--physics"]),
    (["--colour"], ["--colour"]),
])  # fmt: skip
def test_wrong_options_are_refused(options: list[str], words: list[str]) -> None:
    assert_refused(run("solve", MISSION, *options), *words)


def test_missing_and_wrong_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "broken.yaml").write_text("name: [", "utf-8")
    (tmp_path / "other.yaml").write_text("shopping: list\n", "utf-8")
    (tmp_path / "bom.xlsx").write_bytes(b"PK\x03\x04\x14\x00\xff")
    (tmp_path / "report.html").write_text("<!DOCTYPE html>\n<html><a: b: c>", "utf-8")
    assert_refused(run("solve", tmp_path / "bom.xlsx"), "is a workbook or an archive, no mission; name a YAML file")
    assert_refused(run("evaluate", MISSION, tmp_path / "report.html"), "is a web page, no system")
    assert_refused(run("solve", tmp_path / "none.yaml"), "no such file")
    assert_refused(run("solve", tmp_path), "is a folder")
    assert_refused(run("solve", tmp_path / "broken.yaml"), "broken.yaml")
    assert_refused(run("solve", tmp_path / "other.yaml"), "shopping")
    assert_refused(run("evaluate", MISSION, tmp_path / "none.yaml"), "no such file")
    assert_refused(run("solve"), "MISSION")
    assert_refused(run("paint", MISSION), "paint")


@pytest.mark.parametrize(("kind", "name", "lacks"), [
    ("camera", "zimo-subsea-camera", "pixel pitch"), ("port", "deepsea-power-light-apex-seacam-dome-port", "radius"),
    ("light", "ikelite-ds160", "light output"),
])  # fmt: skip
def test_part_that_lacks_a_vital_number_is_refused(kind: str, name: str, lacks: str, tmp_path: Path) -> None:
    text = "\n".join(
        f"{key}: {name if key == kind else value}"
        for key, value in {
            "camera": "avt-alvium-1800-c-234m", "lens": "moritex-ml-u1217sr-18c",
            "port": "blue-robotics-4-in-acrylic-end-cap-2026", "light": "arctic-rays-dragonfish-mini-strobe",
        }.items()
    )  # fmt: skip
    file = tmp_path / "system.yaml"
    file.write_text(text + "\n", encoding="utf-8")
    assert_refused(run("evaluate", MISSION, file), name, lacks, "not known")


def test_unknown_part_is_refused_with_near_ones(tmp_path: Path) -> None:
    text = SYSTEM.read_text("utf-8").replace("camera: seed-imx250m", "camera: seed-imx250n")
    (tmp_path / "system.yaml").write_text(text, "utf-8")
    assert_refused(run("evaluate", MISSION, tmp_path / "system.yaml"), "seed-imx250n", "seed-imx250m")
    assert_refused(run("catalog", "show", "seed-imx250n"), "seed-imx250m")


def test_unknown_parts_and_keys_of_a_system_are_told_at_once(tmp_path: Path) -> None:
    text = SYSTEM.read_text("utf-8").replace("seed-imx250m", "seed-imx250n").replace("exposure_ms", "exposure")
    (tmp_path / "system.yaml").write_text(text, "utf-8")
    for command in ("evaluate", "compare"):
        done = run(command, MISSION, tmp_path / "system.yaml")
        assert_refused(done, "camera = 'seed-imx250n' is not in the catalogue; did you mean seed-imx250m", "_ms")
        assert re.findall(r"system.yaml line \d+: (\w+)", done.stderr)[0] == "camera"


def test_unusable_out_is_refused_before_the_work(
    solving: Callable[..., list[dict[str, Any]]], tmp_path: Path
) -> None:
    calls = solving()
    (tmp_path / "file").touch()
    assert_refused(run("solve", MISSION, "--out", tmp_path / "file"), "is a file, not a folder")
    assert_refused(run("solve", MISSION, "--out", tmp_path / "file" / "below"))
    assert calls == []
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_bad_mission_leaves_no_folder_behind(tmp_path: Path) -> None:
    assert_refused(run("solve", tmp_path / "none.yaml", "--out", tmp_path / "out"))
    assert list(tmp_path.iterdir()) == []


# ---------------------------------------------------------------- catalogue


def test_list_shows_parts_of_a_pattern() -> None:
    text = run("catalog", "list", "kowa").stdout
    assert "kowa-lm8jc10m" in text and "Lenses" in text and "Cameras" not in text


def test_list_can_be_narrowed_to_a_kind_and_read_by_programs() -> None:
    lines = json.loads(run("catalog", "list", "--kind", "port", "--json").stdout)
    assert {line["kind"] for line in lines} == {"port"}


def test_excluded_parts_come_with_reasons() -> None:
    text = run("catalog", "list", "--excluded").stdout
    assert "left out: availability" in text and "left out: vital facts" in text


def test_pattern_that_fits_nothing_is_refused_with_near_names() -> None:
    assert_refused(run("catalog", "list", "kowaa"), "kowaa", "Kowa")


def test_show_tells_values_and_sources() -> None:
    text = run("catalog", "show", "KOWA_LM8JC10M").stdout
    assert "focal_length_mm" in text and "estimated" in text and "https://" in text


@pytest.mark.parametrize("kind", ["camera", "lens", "port", "light", "prices", "water"])
def test_templates_pass_their_own_check(tmp_path: Path, kind: str) -> None:
    file = tmp_path / f"{kind}.csv"
    file.write_text(run("catalog", "template", kind).stdout, "utf-8")
    done = run("catalog", "check", file)
    assert done.exit_code == 0, done.output
    assert "in order" in " ".join(done.stdout.split())


def test_own_parts_can_be_listed(tmp_path: Path) -> None:
    file = tmp_path / "lens.csv"
    file.write_text(run("catalog", "template", "lens").stdout, "utf-8")
    assert "acme-lens-8" in run("catalog", "list", "acme", "--file", file).stdout


def test_check_names_the_row_of_a_fault(tmp_path: Path) -> None:
    file = tmp_path / "lens.csv"
    file.write_text(run("catalog", "template", "lens").stdout.replace(",16,", ",wide,"), "utf-8")
    done = run("catalog", "check", file)
    assert done.exit_code == 2
    shown = " ".join(done.stdout.split())
    assert "1 fault" in shown and "wide" in shown and "row" in shown


def test_check_of_a_missing_file_and_unknown_template_are_refused(tmp_path: Path) -> None:
    assert_refused(run("catalog", "check", tmp_path / "none.csv"), "no such file")
    assert_refused(run("catalog", "template", "torpedo"), "torpedo", "camera")
    assert_refused(run("catalog", "list", "--kind", "torpedo"), "torpedo")


# ---------------------------------------------------------------- init and schema


def test_init_writes_a_mission_that_loads_and_never_writes_over_it(tmp_path: Path) -> None:
    from uwopt.mission.mission import load_mission

    file = tmp_path / "reef.yaml"
    assert run("init", file).exit_code == 0
    assert load_mission(file).name
    file.write_text("mine", "utf-8")
    assert_refused(run("init", file), "exists already")
    assert file.read_text("utf-8") == "mine"
    assert_refused(run("init", tmp_path), "is a folder")
    assert_refused(run("init", tmp_path / "none" / "reef.yaml"), "folder does not exist")


def test_init_prints_without_a_file(tmp_path: Path) -> None:
    from uwopt.mission.system import load_system

    assert "vehicle:" in run("init").stdout
    (tmp_path / "rig.yaml").write_text(run("init", "--system").stdout, "utf-8")
    assert load_system(tmp_path / "rig.yaml").name


@pytest.mark.parametrize("what", ["mission", "system"])
def test_schema_is_json(what: str) -> None:
    assert json.loads(run("schema", what).stdout)["title"] == f"uwopt {what}"
    assert_refused(run("schema", "torpedo"), "torpedo")


# ---------------------------------------------------------------- as a program


def test_ascii_terminal_gets_ascii() -> None:
    done = program("evaluate", MISSION, SYSTEM, env={"PYTHONIOENCODING": "ascii", "LC_ALL": "C"})
    assert done.returncode == 0 and done.stdout.isascii()
    data = CliRunner(charset="ascii").invoke(app, ["evaluate", str(MISSION), str(SYSTEM), "--json"])
    assert json.loads(data.stdout)["status"]


def test_reader_that_leaves_early_is_no_fault() -> None:
    read, write = os.pipe()
    os.close(read)
    done = program("catalog", "list", capture_output=False, stdout=write, stderr=subprocess.PIPE)
    os.close(write)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_full_disk_behind_standard_output_is_told() -> None:
    with Path("/dev/full").open("w") as full:
        done = program("catalog", "list", capture_output=False, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1 and "standard output" in done.stderr


@pytest.mark.skipif(os.name == "nt", reason="signals differ")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["Ctrl-C", "timeout"])
def test_ctrl_c_ends_with_status_130(number: signal.Signals) -> None:
    """So does what `timeout`, a queue or a service sends: what is found by then is told."""
    waiting = (
        "import signal, sys, time\nfrom uwopt.api import solving as api\nfrom uwopt.cli import app as cli\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # a shell's background has it ignored
        "def solve(*a, **k):\n    print('ready', file=sys.stderr, flush=True)\n    time.sleep(60)\n"
        "api.solve = solve\nsys.argv = ['uwopt', 'solve', 'x.yaml']\ncli.main()\n"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", waiting], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert child.stderr is not None and "ready" in child.stderr.readline()
    time.sleep(0.05)
    child.send_signal(number)
    try:
        stdout, stderr = child.communicate(timeout=30)
    finally:
        child.kill()
    assert (child.returncode, stdout) == (130, "")
    assert "interrupted" in stderr and "Traceback" not in stderr


@pytest.mark.parametrize("at", ["typer", "uwopt.cli.output"])
def test_ctrl_c_while_the_program_is_loaded_shows_no_traceback(at: str) -> None:
    ended = (
        "import sys\nclass Ended:\n    def find_spec(self, name, *more):\n"
        f"        if name == {at!r}:\n            raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Ended())\nsys.argv = ['uwopt', 'init']\n"
        "import runpy; runpy.run_module('uwopt', run_name='__main__')\n"
    )
    done = subprocess.run([sys.executable, "-c", ended], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", f"{NO_RESULT}\n")


@pytest.mark.skipif(os.name == "nt", reason="signals differ")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_a_page_in_a_script_s_background_ends_by_signals(number: signal.Signals) -> None:
    before = signal.signal(number, signal.SIG_IGN)  # as a shell leaves it to what it starts with &
    try:
        with pytest.raises(KeyboardInterrupt), ended_by_signals():
            os.kill(os.getpid(), number)
            time.sleep(5.0)
        assert signal.getsignal(number) == signal.SIG_IGN
    finally:
        signal.signal(number, before)


def test_solve_finds_a_system_end_to_end(tmp_path: Path) -> None:
    mission = ROOT / "problems" / "paper-tool-window.yaml"  # the README's commands solve one with full physics
    done = program("solve", mission, "--physics", "paper", "--quick", "--json", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    result = Result.from_dict(json.loads(done.stdout))
    assert result.status == "optimal" and result.certificate is not None and result.certificate.adds_up()
    assert json.loads((tmp_path / "result.json").read_text("utf-8"))["status"] == "optimal"

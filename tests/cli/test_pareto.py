"""The command `uwopt pareto`: files, text and exit status."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import uwopt
from uwopt.cli.app import app

PROBLEMS = Path(__file__).parents[2] / "problems"
MISSION = PROBLEMS / "mbari-lass-2013.yaml"  # few combinations
pytestmark = pytest.mark.usefixtures("unhurried")


@pytest.fixture(scope="module")
def few(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The mission with one camera."""
    plain = uwopt.load_mission(MISSION).to_dict(absolute_paths=True)
    plain["catalog"]["cameras"] = ["basler-aca2040-55uc"]
    path = tmp_path_factory.mktemp("few") / "mission.yaml"
    path.write_text(json.dumps(plain), encoding="utf-8")  # JSON is YAML
    return path


def run(*arguments: object) -> Any:
    return CliRunner().invoke(app, ["pareto", *(str(word) for word in arguments)])


def test_writes_page_table_and_json(few: Path, tmp_path: Path) -> None:
    words = ("--objectives", "power,cost", "--solver", "exact,nsga2", "--physics", "paper")
    done = run(few, *words, "--out", tmp_path / "front")
    assert done.exit_code == 0, done.output
    assert {p.name for p in (tmp_path / "front").iterdir()} == {"report.html", "front.csv", "front.json"}
    data = json.loads((tmp_path / "front" / "front.json").read_text(encoding="utf-8"))
    with (tmp_path / "front" / "front.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["point"] for row in rows] == [point["id"] for point in data["points"]]
    exact, peer = data["methods"]
    assert (exact["name"], peer["name"]) == ("exact", "nsga2")
    assert 0.9 < peer["hypervolume_ratio"] <= 1.001  # more would be a defect of the exact front
    assert data["alternatives"]
    assert "Named points" in done.stdout
    assert "cheapest" in done.stdout


def test_a_time_that_is_over_before_the_search_begins_stops_it(few: Path) -> None:
    """It was refused as "seconds = 0.0", which nobody had written."""
    done = run(few, "--solver", "exact", "--seconds", "1e-6", "--quiet")
    assert done.exit_code == 4, done.output
    assert "Stopped by a limit before a system was found." in done.stdout


def test_json_alone(few: Path) -> None:
    done = run(few, "--objectives", "power,cost", "--solver", "exact", "--physics", "paper", "--json")
    assert done.exit_code == 0
    data = json.loads(done.stdout)
    assert data["schema"] == "uwopt.front/1"
    assert [o["name"] for o in data["objectives"]] == ["power", "cost"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--objectives", "power"], ["one objective has no front", "uwopt solve"]),
        (["--objectives", "power,cost,mass,snr_db"], ["4 objectives", "two or three"]),
        (["--objectives", "power,costs"], ["'costs'", "did you mean cost?"]),
        (["--objectives", "power,power"], ["power stands twice"]),
        (["--solver", "nsga"], ["solver 'nsga'", "did you mean"]),
        (["--seconds", "0"], ["--seconds = 0"]),
        (["--out", ""], ["--out is empty"]),
    ],
)
def test_bad_input_is_one_clear_message(options, words):
    done = run(MISSION, *options)
    assert done.exit_code == 2
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    for word in words:
        assert word in done.stderr


def test_a_mission_that_nothing_meets_says_why(tmp_path):
    wanted = uwopt.load_mission(MISSION).to_dict(absolute_paths=True)
    wanted["requirements"]["min_snr_db"] = 95.0  # more than any full well holds
    hard = tmp_path / "hard.yaml"
    hard.write_text(json.dumps(wanted), encoding="utf-8")  # JSON is YAML
    done = run(
        hard, "--objectives", "power,cost", "--solver", "exact", "--physics", "paper", "--out", tmp_path / "out"
    )
    assert done.exit_code == 3, done.output
    assert "infeasible" in done.stdout
    assert (tmp_path / "out" / "report.html").exists()


def interrupted(*args: Any, **kwargs: Any) -> Any:
    raise KeyboardInterrupt


@pytest.mark.parametrize("place", ["PymooRun._algorithm", "population_front"])  # while it breeds, and before
def test_interruption_after_the_exact_front_keeps_it_with_status_130(few, place, monkeypatch):
    monkeypatch.setattr(f"uwopt.solvers.population.pymoo_front.{place}", interrupted)
    done = run(
        few, "--objectives", "power,cost", "--solver", "exact,nsga2,nsga3", "--physics", "paper", "--json"
    )
    assert done.exit_code == 130
    data = json.loads(done.stdout)
    assert data["status"] == "complete"  # the exact front
    assert data["certificate"]["complete"]
    assert data["points"]
    assert "nsga3" not in {method["name"] for method in data["methods"]}
    assert [w["message"] for w in data["warnings"] if w["code"] == "interrupted"] == [
        "nsga2 was interrupted; the exact front was finished before"
    ]

"""What README and guide promise: their commands and snippets run, and their output is that of a run."""

from __future__ import annotations

import math
import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

import make_readme_output as page_maker
import pytest
import yaml
from thorough import THOROUGH, drawn
from typer.testing import CliRunner

from uwopt.api import doubting
from uwopt.api.common import NOT_MODELLED
from uwopt.bench import run as bench_run
from uwopt.cli import status as cli_status
from uwopt.cli.app import app
from uwopt.mission.mission import load_mission
from uwopt.results.reading import read_result
from uwopt.solvers.continuous import nlopt_algorithms
from uwopt.solvers.explain import specification
from uwopt.solvers.front import search as front_search

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
GUIDE = ROOT / "docs" / "guide"
#: The pages whose commands are run, in the order in which they are read.
CHAPTERS = ("answer", "order", "mission", "choices", "doubt", "python", "physics")
PAGES = ("README.md", *(f"docs/guide/{name}.md" for name in CHAPTERS), "docs/explore.md")
AS_PROCESS = "uwopt solve problems/reef-mosaic.yaml --out reef"
SOME_SUITES = ("quadrature", "physics")
BENCH_S = 1.0  # for all suites together; they end when it is spent, whatever they have measured
FEW_TRIED = {"50": "6"}  # by an audit
AGAIN = re.compile(r"^uwopt solve (problems/reef-mosaic.yaml --(audit|solver|tolerance)|my-survey.yaml)")
INIT = "uwopt init my-survey.yaml"
SOME_LENSES = "  lenses: [kowa-lm6, kowa-lm8, thorlabs]\n"
SOME_LIGHTS = "  ports: [blue-robotics-4-in-dome]\n  lights: [arctic-rays-dragonfish-mini, blue-robotics-lumen]\n"
DEEP = (
    "  cameras: [avt-alvium-1800-c-235m]\n  lenses: [tamron-m112fm12, fujinon-cf12za-1s]\n"
    "  ports: [generic-dome-bk7-100mm]\n  lights: [generic-flash-50j]\n"
)
FEW_SCENARIOS = "doubt: {scenarios: 64}\n"
#: Files that choose from few parts once a command has run: what each says, and what it says then.
NARROWED = {
    AS_PROCESS: {
        "problems/reef-mosaic.yaml": [
            (
                '  cameras: ["flir", "allied*", "basler"]\n',
                "  cameras: [avt-alvium-1800-c-234m]\n" + SOME_LENSES + SOME_LIGHTS,
            ),
        ],
        "problems/mbari-lass-2013.yaml": [
            ("  generic: allow\n", "  generic: allow\n  cameras: [basler-aca2040-55uc]\n"),
        ],
        "problems/jobs/deep-auv.yaml": [
            ("objective: power\n", "catalog:\n" + DEEP + FEW_SCENARIOS + "objective: power\n")
        ],
    },
    INIT: {
        "my-survey.yaml": [
            (
                '  cameras: ["*"]\n',
                "  cameras: [basler-a2a2464-77umpro]\n  ports: [generic-dome-acrylic]\n  lights: [generic-flash-50j]\n"
                + SOME_LENSES,
            ),
            ("physics: auto\n", "physics: paper\n" + FEW_SCENARIOS),
        ],
    },
}  # fmt: skip
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def blocks(language: str) -> list[str]:
    """The code blocks of all pages in a language."""
    pages = "\n".join((ROOT / page).read_text(encoding="utf-8") for page in PAGES)
    return re.findall(rf"```{language}\n(.*?)```", pages, re.DOTALL)


def commands() -> list[str]:
    """All lines of shell blocks, each once."""
    return list(dict.fromkeys(line for block in blocks("sh") for line in block.splitlines() if line.strip()))


@pytest.fixture(scope="module")
def outputs(done: dict[str, Done], folder: Path) -> tuple[str, str]:
    """The page and the lines of the full text that are shown, and those of the run."""
    shown = [page_maker.pasted(name) for name in (page_maker.PAGE, page_maker.FULL)]
    fresh = [
        done[AS_PROCESS].out.rstrip("\n"),
        page_maker.full_of(read_result(folder / "reef" / "result.json")),
    ]
    return "\n".join(shown), "\n".join(fresh)


def words(line: str) -> str:
    """A line without its numbers and spacing."""
    return " ".join(NUMBER.sub("#", line).replace("# #", "#").split())


def values(line: str) -> list[float]:
    """The numbers in a line; thousands are set apart by a space."""
    return [float(text) for text in NUMBER.findall(re.sub(r"(?<=\d) (?=\d{3}\b)", "", line))]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with problems/, where commands may leave files."""
    path = tmp_path_factory.mktemp("readme")
    shutil.copytree(ROOT / "problems", path / "problems")
    return path


def test_the_two_commands_are_the_ones_that_ci_runs():
    setups = [line for line in commands() if line.startswith("python3 -m venv ")]
    assert setups == re.findall(r"^python3 -m venv .*$", README, re.MULTILINE)  # what .ci/run picks
    assert len(setups) == 2
    assert setups[0].endswith(".venv/bin/uwopt solve problems/reef-mosaic.yaml")
    assert setups[1].endswith(".venv/bin/pytest -n 2")
    ci = ROOT / ".ci" / "run"
    assert "grep '^python3 -m venv ' README.md" in ci.read_text(encoding="utf-8")
    assert os.access(ci, os.X_OK)


@dataclass(frozen=True)
class Done:
    """What a command left."""

    status: int
    out: str
    err: str


def as_process(program: str, arguments: list[str], folder: Path) -> Done:
    """Run a command as a person does: a program of its own, to whom every warning is an error."""
    head = [sys.executable, "-m", "uwopt"] if program == "uwopt" else [sys.executable]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "error"}
    done = subprocess.run(
        [*head, *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )
    return Done(done.returncode, done.stdout, done.stderr)


def within_tests(arguments: list[str]) -> Done:
    """Run a command of uwopt in this process, where libraries are loaded already."""
    done = CliRunner().invoke(app, arguments)
    return Done(done.exit_code, done.stdout, done.stderr)


@pytest.fixture(scope="module")
def done(folder: Path, unhurried: None) -> dict[str, Done]:
    """All commands of the pages, run in the order in which they stand.

    One is a process of its own, all of them are before a release; a benchmark takes the time that it is given. By
    default the mission that `init` writes and the deep one choose from few parts, so does the reef's once it was solved
    as it is, a front may miss a hundredth of its volume, an audit and NLopt try a few, and what `init` writes has
    plain physics, for its scenarios.
    """
    lines = [line for line in commands() if line.startswith(("uwopt ", "python "))]
    if find_spec("openpyxl") is None:  # an environment of before: what makes workbooks cannot run there
        lines = [line for line in lines if not line.startswith(("uwopt tender ", "uwopt quotes "))]
    found: dict[str, Done] = {}
    narrowed = drawn(NARROWED, {})
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(bench_run, "QUICK_S", BENCH_S)
        if not THOROUGH:  # each suite has tests of its own
            patch.setattr(bench_run, "MODULES", {name: bench_run.MODULES[name] for name in SOME_SUITES})
        for name, few in (("HALVINGS", 1), ("STEPS", 3), ("SHARES", 2)):
            patch.setattr(specification, name, drawn(few, getattr(specification, name)))
        patch.setattr(front_search, "FRONT_GAP", drawn(1e-2, front_search.FRONT_GAP))
        near = nlopt_algorithms.NEAR
        patch.setattr(nlopt_algorithms, "NEAR", drawn(replace(near, most=near.most // 10), near))
        for line in lines:
            text, _, target = line.partition(" > ")
            program, *arguments = shlex.split(text)
            if not THOROUGH and AGAIN.search(
                line
            ):  # the same answer by other means: its doubts are known by then
                patch.setattr(doubting, "doubts_of", lambda *given: {})
                arguments = [FEW_TRIED.get(word, word) for word in arguments]
            apart = THOROUGH or program != "uwopt" or line == AS_PROCESS
            found[line] = as_process(program, arguments, folder) if apart else within_tests(arguments)
            for name, changes in narrowed.get(line, {}).items():
                text = (folder / name).read_text(encoding="utf-8")
                for choice, some in changes:
                    assert choice in text
                    text = text.replace(choice, some)
                (folder / name).write_text(text, encoding="utf-8")
            if target:
                (folder / target.strip()).write_text(found[line].out, encoding="utf-8")
    return found


def test_commands_run_in_the_order_in_which_they_stand(done: dict[str, Done]):
    assert len(done) >= 10 and AS_PROCESS in done
    for line, left in done.items():
        assert left.status == 0, f"{line}\n{left.out}{left.err}"
        assert left.out or left.err, line


@pytest.mark.parametrize("index", range(len(blocks("python"))))
def test_python_snippet_runs(
    folder: Path, monkeypatch: pytest.MonkeyPatch, undoubted: None, capsys, index: int
):
    monkeypatch.chdir(folder)
    exec(compile(blocks("python")[index], f"snippet {index + 1}", "exec"), {})
    assert capsys.readouterr().out.strip()


def test_output_shown_has_the_lines_of_a_fresh_run(outputs: tuple[str, str]):
    shown, fresh = outputs
    assert [words(line) for line in shown.splitlines()] == [words(line) for line in fresh.splitlines()], (
        "the output shown is out of date: python docs/make_readme_output.py"
    )


def test_output_shown_has_the_numbers_of_a_fresh_run(outputs: tuple[str, str]):
    # 1e-3: the last printed digit may differ between machines. Lines that begin with a number count what the
    # search looked at; how it divides its work is no claim of the page, see the next test.
    shown, fresh = outputs
    for old, new in zip(shown.splitlines(), fresh.splitlines(), strict=True):
        if old.strip()[:1].isdigit():
            continue
        for a, b in zip(values(old), values(new), strict=True):
            assert math.isclose(a, b, rel_tol=1e-3, abs_tol=1e-3), (
                f"{old!r} is now {new!r}: python docs/make_readme_output.py"
            )


def test_account_shown_adds_up_to_all_combinations_of_a_fresh_run(outputs: tuple[str, str]):
    def account(text: str) -> list[float]:
        return values(next(line for line in text.splitlines() if line.endswith("adds up")))

    evaluated, discarded, loaded = account(outputs[0])
    assert evaluated + discarded == loaded == account(outputs[1])[2]


def test_output_shown_names_the_parts_and_the_objective_of_a_fresh_run(outputs: tuple[str, str]):
    shown, fresh = outputs
    parts = re.compile(r"^  \d+ x  (?:camera|lens|port|light) +(.+?)  ", re.MULTILINE)
    assert len(parts.findall(shown)) == 4
    assert parts.findall(shown) == parts.findall(fresh)
    assert shown.splitlines()[1] == fresh.splitlines()[1]
    assert shown.splitlines()[1].startswith("Goal: least power, ")


def test_mission_shown_is_the_one_that_is_solved():
    text = re.findall(r"```yaml\n(.*?)```", README, re.DOTALL)[0]
    shown = load_mission(yaml.safe_load(text)).to_dict()
    assert shown == load_mission(ROOT / "problems" / "reef-mosaic.yaml").to_dict()


def test_what_is_not_modelled_is_told_in_full():
    section = (GUIDE / "physics.md").read_text(encoding="utf-8").split("Not modelled yet")[1].split("\n\n")[1]
    assert section.splitlines() == [f"- {name}" for name in NOT_MODELLED]


def test_exit_statuses_are_those_of_the_program():
    told = [
        int(number)
        for number in re.findall(
            r"^\| (\d+) \|", (GUIDE / "answer.md").read_text(encoding="utf-8"), re.MULTILINE
        )
    ]
    names = ("DONE", "DEFECT", "BAD_INPUT", "NOT_FEASIBLE", "LIMIT_REACHED", "INTERRUPTED")
    assert told == [getattr(cli_status, name) for name in names]


def test_every_page_of_the_guide_is_read():
    assert {page for page in PAGES if "guide" in page} == {
        f"docs/guide/{path.name}" for path in GUIDE.glob("*.md")
    }


@pytest.mark.parametrize("page", [*PAGES, "CHANGELOG.md", "docs/README.md", "problems/README.md"])
def test_links_lead_to_files_that_exist(page: str):
    text = (ROOT / page).read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)\)", text):
        if "://" not in target:
            assert (ROOT / page).parent.joinpath(target).exists(), target

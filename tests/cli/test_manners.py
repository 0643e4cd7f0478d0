"""Files and streams that mean harm, or only bad luck: one clear message; nothing hangs or is left half-done."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from uwopt.catalog.checkfile import file_report
from uwopt.cli.app import app
from uwopt.documents.files import MOST_BYTES
from uwopt.errors import OutputError, ResultError
from uwopt.report.write import check_folder, write_files
from uwopt.results.reading import read_result

ROOT = Path(__file__).parents[2]
MISSION = ROOT / "problems" / "paper-tank.yaml"
SYSTEM = ROOT / "problems" / "paper-tank.system.yaml"
FULL = Path("/dev/full")


def run(*arguments: object) -> Any:
    return CliRunner().invoke(app, [str(word) for word in arguments])


def pipe(folder: Path) -> Path:
    os.mkfifo(folder / "parts.csv")
    return folder / "parts.csv"


def endless(folder: Path) -> Path:
    (folder / "parts.csv").symlink_to("/dev/zero")
    return folder / "parts.csv"


def huge(folder: Path) -> Path:
    with (folder / "parts.csv").open("wb") as file:
        file.truncate(MOST_BYTES + 1)  # sparse: takes no room
    return folder / "parts.csv"


def folder(folder: Path) -> Path:
    (folder / "parts.csv").mkdir()
    return folder / "parts.csv"


def circle(folder: Path) -> Path:
    (folder / "parts.csv").symlink_to("parts.csv")
    return folder / "parts.csv"


def mission_with(folder: Path, section: str, text: str) -> Path:
    """The tank's mission with one section written anew."""
    lines = MISSION.read_text(encoding="utf-8").splitlines()
    start = lines.index(f"{section}:")
    end = next(n for n in range(start + 1, len(lines)) if not lines[n].startswith(" "))
    (folder / "mission.yaml").write_text("\n".join([*lines[:start], text, *lines[end:]]), encoding="utf-8")
    return folder / "mission.yaml"


# ---------------------------------------------------------------- files that never end


def as_system(bad: Path) -> Any:
    return run("evaluate", MISSION, bad)


def as_own_parts(bad: Path) -> Any:
    return run("evaluate", mission_with(bad.parent, "catalog", "catalog: {files: [parts.csv]}"), SYSTEM)


def as_prices(bad: Path) -> Any:
    return run("evaluate", mission_with(bad.parent, "catalog", "catalog: {prices: parts.csv}"), SYSTEM)


def as_water(bad: Path) -> Any:
    scene = "scene: {water: parts.csv, seafloor: 0.9, depth_m: 1}"
    return run("evaluate", mission_with(bad.parent, "scene", scene), SYSTEM)


def as_result(bad: Path) -> Any:
    return run("report", bad)


def as_checked(bad: Path) -> Any:
    return run("catalog", "check", bad)


@pytest.mark.parametrize("bad", [pipe, endless, huge, folder, circle])
@pytest.mark.parametrize("door", [as_system, as_own_parts, as_prices, as_water, as_result, as_checked])
def test_what_is_no_plain_file_is_refused_unread(
    door: Callable[[Path], Any], bad: Callable[[Path], Path], tmp_path: Path
) -> None:
    done = door(bad(tmp_path))
    assert done.exit_code == 2, done.output
    assert "parts.csv" in done.stderr and "Traceback" not in done.stderr and "defect" not in done.stderr
    assert done.stdout == ""


# ---------------------------------------------------------------- YAML of parts


def test_aliases_that_multiply_are_no_cells(tmp_path: Path) -> None:
    lines = ["id: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 20)]
    (tmp_path / "parts.yaml").write_text("- part: camera\n" + "".join(f"  {line}\n" for line in lines))
    assert not file_report(tmp_path / "parts.yaml").ok


def test_aliases_that_repeat_a_long_text_are_refused(tmp_path: Path) -> None:
    rows = ["- part: &long " + "x" * 1_000_000, *["- part: *long"] * 200]
    (tmp_path / "parts.yaml").write_text("\n".join(rows))
    assert "aliases stand for more than" in "\n".join(file_report(tmp_path / "parts.yaml").faults)


@pytest.mark.parametrize(
    "text", ["[" * 5000, "- part: " + "{a: " * 3000, "- &a {part: camera, id: [*a, *a]}"]
)
def test_deep_parts_and_parts_that_hold_themselves_are_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "parts.yaml").write_text(text)
    assert not file_report(tmp_path / "parts.yaml").ok


# ---------------------------------------------------------------- streams and outputs


def program(*words: str, **streams: Any) -> int:
    environment = {"PYTHONPATH": str(ROOT)}  # neither HOME nor TERM nor a locale
    command = [sys.executable, "-m", "uwopt", *words]
    return subprocess.run(command, env=environment, timeout=120, check=False, **streams).returncode


@pytest.mark.skipif(not FULL.exists(), reason="no device that is always full")
@pytest.mark.parametrize("words", [("--help",), ("--version",), ("solve", "--help")])
def test_help_that_cannot_be_written_is_told(words: tuple[str, ...], tmp_path: Path) -> None:
    with FULL.open("w") as full, (tmp_path / "told").open("w") as told:
        assert program(*words, stdout=full, stderr=told) == 2
    assert (tmp_path / "told").read_text() == "standard output cannot be written (No space left on device).\n"


@pytest.mark.skipif(not FULL.exists(), reason="no device that is always full")
def test_status_stays_when_the_message_cannot_be_written() -> None:
    with FULL.open("w") as full:
        assert program("evaluate", "nothing.yaml", str(SYSTEM), stderr=full) == 2


def test_a_link_to_nothing_is_no_folder_for_results(tmp_path: Path) -> None:
    (tmp_path / "out").symlink_to(tmp_path / "gone")
    with pytest.raises(OutputError, match="is a link to what does not exist"):
        check_folder(tmp_path / "out")


def test_files_of_runs_side_by_side_belong_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    honest, begun, over = Path.replace, threading.Event(), threading.Event()

    def replace(self: Path, target: Path) -> Path:
        done = honest(self, target)
        if threading.current_thread().name == "first" and not begun.is_set():
            begun.set()  # the other run may come between now, unless it has to wait
            over.wait(0.3)
        return done

    def write(text: str) -> None:
        write_files(tmp_path, dict.fromkeys(("result.json", "bom.csv", "report.html"), text))

    monkeypatch.setattr(Path, "replace", replace)
    first = threading.Thread(name="first", target=write, args=("one",))
    second = threading.Thread(target=lambda: (write("two"), over.set()))
    first.start()
    assert begun.wait(30.0)
    second.start()
    for thread in (first, second):
        thread.join()
    assert len({path.read_text() for path in tmp_path.iterdir()}) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bom.csv", "report.html", "result.json"]


def test_a_number_of_the_command_line_is_refused_in_our_words():
    for option, value, said in (("--seconds", "2min", "be a number without a unit"), ("--top", "0", "be at least 1")):
        left = run("solve", "m.yaml", option, value)
        assert left.exit_code == 2 and said in left.output and "nput should" not in left.output


def test_a_card_asks_for_a_result_alone(tmp_path):
    (tmp_path / "system.yaml").write_text("camera: a\n", "utf-8")
    left = run("card", tmp_path / "system.yaml")
    assert "so it is no result; name a result.json." in " ".join(left.output.split())
    with pytest.raises(ResultError, match=r"name a result\.json or front\.json"):
        read_result(tmp_path / "system.yaml")


@pytest.mark.parametrize(
    "arguments",
    [("plot", "dofx", "m.yaml"), ("solve", "m.yaml", "--physics", "fulll"), ("catalog", "list", "--kind", "lense")],
)
def test_a_word_that_is_no_choice_is_told_without_the_name_of_an_exception(arguments):
    left = run(*arguments)
    assert left.exit_code == 2
    assert "is not one of" in left.output and "Value error" not in left.output

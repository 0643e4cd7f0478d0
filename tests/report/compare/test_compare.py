"""Systems side by side: rows of what is asked, and sentences that say why."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml
from priced_system import PRICED
from typer.testing import CliRunner

from uwopt.api.comparing import apart, compare, shown_name, with_folders
from uwopt.cli.app import app
from uwopt.errors import MissionError
from uwopt.mission.system import load_system
from uwopt.report.compare.page import comparison_blocks, comparison_csv, comparison_html
from uwopt.report.compare.rows import cell_of, facts, margins_of, requirement_rows, sentences
from uwopt.report.text.layout import Grid
from uwopt.report.text.tables import margin_texts
from uwopt.results.comparison import Comparison, SideBySide
from uwopt.results.design import Margin, Note, UsedPart

Make = Callable[..., Any]
MISSION: dict[str, Any] = {
    "name": "=1+1", "physics": "paper", "practice": "bare", "scene": {"water": "II", "seafloor": "sand", "depth_m": 20},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5}, "requirements": {"overlap": 0.6, "max_blur_px": 1.0},
}  # fmt: skip
SETTINGS = {"f_number": 4.0, "exposure_ms": 3.0, "pulse_ms": 1.0, "gain": 4.0, "frame_rate_hz": 2.0}
SHELF = PRICED | {"name": "@shelf <b>", "settings": SETTINGS}
SLOW = PRICED | {"name": "slow", "settings": SETTINGS | {"pulse_ms": 2.0}}  # blurs 1.33 px, by hand


@pytest.fixture(scope="module")
def pair() -> Comparison:
    return compare(MISSION, [SHELF, SLOW])


def test_each_requirement_is_told_of_every_system(pair: Comparison) -> None:
    (blur,) = (row for row in requirement_rows(pair) if row.key == "max_blur_px")
    assert blur.asked == "at most 1.000 px"
    assert [cell.met for cell in blur.cells] == [True, False]
    assert [cell.value for cell in blur.cells] == pytest.approx([0.665, 1.33], rel=1e-3)


def test_what_is_infinite_or_unknown_is_told_by_its_name(pair: Comparison) -> None:
    bare = replace(pair.systems[0].design, totals=replace(pair.systems[0].design.totals, mass_kg=0.0))
    first = replace(pair.systems[0], result=replace(pair.systems[0].result, recommendation=bare))
    alone = replace(pair, systems=[first])
    (mass,) = (row for row in facts(alone) if row.key == "mass_kg")
    assert mass.cells[0].text == "unknown"
    far = Margin("max_far_m", None, 2.0, ">=", None, "m", None, True, False)
    near = Margin("min_dof_m", None, 2.0, ">=", None, "m", None, False, False)
    assert [cell_of(one, far).text for one in (None, far, near)] == ["unknown", "infinite", "–"]


def test_what_does_not_fit_is_told_without_numbers(pair: Comparison) -> None:
    more = compare(MISSION | {"vehicle": MISSION["vehicle"] | {"light_count": 3}}, [SHELF])
    (row,) = (row for row in requirement_rows(more) if row.key == "fits: light count")
    assert (row.asked, row.cells[0].text, row.cells[0].met) == ("yes", "no", False)
    (margin,) = (m for m in more.systems[0].design.missed if m.key == row.key)
    assert cell_of(None, margin).text == "yes"  # of a system that has no such margin
    assert margin_texts(margin, {}, None) == ("fits: light count", "no", "yes", "–", "")


def test_one_system_is_taken_for_a_list_of_it(pair: Comparison, tmp_path: Path) -> None:
    file = tmp_path / "shelf.yaml"
    file.write_text(yaml.safe_dump(SHELF), encoding="utf-8")
    assert len(compare(MISSION, str(file)).systems) == len(compare(MISSION, SHELF).systems) == 1


def test_limits_of_parts_that_all_keep_are_not_told(pair: Comparison) -> None:
    assert not {"gain_max", "f_number_min", "light_level"} & {row.key for row in requirement_rows(pair)}


def test_of_several_parts_the_one_with_the_least_in_hand_is_told() -> None:
    def rating(part: str, left: float) -> Margin:
        return Margin(f"depth_rating_m ({part})", 100.0 + left, 100.0, ">=", left, "m", None, left >= 0, False)

    assert margins_of([rating("a", 50.0), rating("b", -1.0), rating("c", 0.0)])["depth_rating_m"].margin == -1.0


def test_words_say_what_is_missed(pair: Comparison) -> None:
    assert [*sentences(pair)] == ["@shelf <b> meets everything.", "Slow misses motion blur."]


def side_by_side(make_result: Make, rig: float, *, missed: bool = False, notes: tuple[Note, ...] = ()) -> Comparison:
    """A rig with a value of the goal beside a recommendation of 40 W with an SNR of 30 dB."""
    best = make_result()
    scenes = [replace(scene, figures={"snr_db": 33.0}) for scene in best.best.scenes]
    if missed:
        scenes = [replace(s, margins=[replace(s.margins[0], satisfied=False), *s.margins[1:]]) for s in scenes]
    own = replace(best.best, objective_value=rig, scenes=scenes, warnings=[*notes])
    given = replace(best, command="evaluate", recommendation=None, design=own, warnings=[])
    return Comparison((SideBySide("rig", given), SideBySide("recommended", best)))


def test_housings_are_told_where_any_system_has_one(make_result: Make) -> None:
    made = side_by_side(make_result, 50.0)
    assert "housing" not in [row.key for row in facts(made)]
    rig, best = made.systems
    housing = UsedPart("acme-tube", "Acme Tube", generic=False)
    own = replace(rig.result, design=replace(rig.design, hardware=replace(rig.design.hardware, housing=housing)))
    (told,) = (row for row in facts(Comparison((SideBySide("rig", own), best))) if row.key == "housing")
    assert [cell.text for cell in told.cells] == ["1 x Acme Tube", "none"]


def test_rig_that_is_worse_by_the_goal_may_show_more(make_result: Make) -> None:
    told = " ".join(sentences(side_by_side(make_result, 50.0)))
    assert "the recommended one is better: 40.0 W against 50.0 W" in told
    assert "the recommended one is as good: 40.0 W" in " ".join(sentences(side_by_side(make_result, 40.0)))
    assert "more to show in signal to noise (33.0 dB, not 30.0 dB)" in told


def test_rig_that_is_better_by_the_goal_is_told_why(make_result: Make) -> None:
    note = Note("outside_search", "lens", "its lens is written out in the system")
    told = " ".join(sentences(side_by_side(make_result, 30.0, notes=(note,))))
    assert "better, 30.0 W against 40.0 W: its lens is written out in the system." in told
    told = " ".join(sentences(side_by_side(make_result, 30.0, missed=True)))
    assert "40.0 W: it does not do what is asked." in told


def test_page_escapes_and_table_defuses(pair: Comparison) -> None:
    page = comparison_html(pair)
    assert "@shelf <b>" not in page
    assert "@shelf &lt;b&gt;" in page
    rows = list(csv.reader(io.StringIO(comparison_csv(pair))))
    assert rows[0][6:] == ["'@shelf <b>", "@shelf <b>: met".replace("@", "'@"), "slow", "slow: met"]
    (blur,) = (row for row in rows if row[2] == "max_blur_px")
    assert [blur[7], blur[9]] == ["yes", "no"]


def test_what_is_missed_is_said_in_words_too(pair: Comparison) -> None:
    cells = [cell for block in comparison_blocks(pair) for line in block.lines if isinstance(line, Grid)
             for row in line.rows for cell in row if cell.style == "red"]  # fmt: skip
    assert [cell.plain for cell in cells] == ["1 missed", "1.330 px (missed)"]


def test_compare_is_a_function_of_the_package() -> None:
    import uwopt

    assert uwopt.compare is compare


def test_files_of_one_name_are_told_by_their_folders(tmp_path: Path) -> None:
    files = [tmp_path / folder / "system.yaml" for folder in ("reef", "wreck")]
    for file in files:
        file.parent.mkdir()
        file.write_text(yaml.safe_dump(PRICED), encoding="utf-8")
    loaded = [load_system(file) for file in files]
    assert with_folders([shown_name(one) for one in loaded], loaded) == ["reef/system", "wreck/system"]
    assert with_folders(["rig", "system"], loaded) == ["rig", "system"]


def test_names_that_occur_twice_are_told_apart() -> None:
    assert apart(["a", "b", "a", "a"]) == ["a", "b", "a (2)", "a (3)"]


@pytest.mark.parametrize("number", [0, 13])
def test_none_and_too_many_are_refused(number: int) -> None:
    with pytest.raises(MissionError, match="compare: "):
        compare(MISSION, [SHELF] * number)


def test_command_writes_page_and_table(tmp_path: Path) -> None:
    files = {"mission.yaml": MISSION, "a.yaml": SHELF, "b.yaml": SLOW}
    for name, data in files.items():
        (tmp_path / name).write_text(yaml.safe_dump(data), "utf-8")
    named = [str(tmp_path / name) for name in files]
    done = CliRunner().invoke(app, ["compare", *named, "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert "Slow misses motion blur." in done.output
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["compare.csv", "compare.html"]


def test_recommended_stands_behind_what_is_given(monkeypatch: pytest.MonkeyPatch, make_result: Make) -> None:
    answers = iter([make_result(), make_result(recommendation=None, status="infeasible")])
    monkeypatch.setattr("uwopt.api.solving.solve", lambda *_, **__: next(answers))
    found = compare(MISSION, [SHELF], recommended=True)
    assert [one.name for one in found.systems] == ["@shelf <b>", "recommended"]
    assert compare(MISSION, [SHELF], recommended=True).nothing_fits


@pytest.mark.parametrize("found", [True, False])
def test_a_search_that_time_ends_is_told(found: bool, monkeypatch: pytest.MonkeyPatch, make_result: Make) -> None:
    answer = make_result(status="stopped", **({} if found else {"recommendation": None}))
    given: list[float] = []
    monkeypatch.setattr("uwopt.api.solving.solve", lambda *_, seconds, **__: given.append(seconds) or answer)
    made = compare(MISSION, [SHELF], recommended=True, seconds=1e-9)
    assert given == [1e-9]
    assert (made.cut_short, made.nothing_fits) == (not found, False)
    assert ("best that was found in time" if found else "time was over") in " ".join(sentences(made))


def test_gallery_tells_of_every_rig_whose_hardware_is_known() -> None:
    import make_gallery

    page = make_gallery.PAGE.read_text("utf-8")
    assert make_gallery.rigs() == [line[3:].partition(":")[0] for line in page.splitlines() if line.startswith("## ")]
    assert page.count("| goal: ") == len(make_gallery.rigs())

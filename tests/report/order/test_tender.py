"""The buyer's loop: a tender from a result, answers as makers fill them in, the mission solved again, the order."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml
from typer.testing import CliRunner

openpyxl = pytest.importorskip("openpyxl")

from uwopt.api.quoting import LOG_FILE, logged, naming, searched, with_quotes  # noqa: E402
from uwopt.api.solving import solve  # noqa: E402
from uwopt.catalog.answers import read_answers  # noqa: E402
from uwopt.catalog.offers import MakerAnswers, offers_of  # noqa: E402
from uwopt.cli.app import app  # noqa: E402
from uwopt.deadline import Deadline  # noqa: E402
from uwopt.errors import CatalogError, MissionError, ResultError  # noqa: E402
from uwopt.mission.mission import Mission, load_mission  # noqa: E402
from uwopt.objectives.goal import goal_of  # noqa: E402
from uwopt.report.order import tender_lines  # noqa: E402
from uwopt.report.order.answers import answer_blocks, certainty_sentences, change_sentences  # noqa: E402
from uwopt.report.order.bom_book import bom_book  # noqa: E402
from uwopt.report.order.tender_book import FIRST_ANSWER, enough_text, kept_back, letter, tender_book  # noqa: E402
from uwopt.report.order.tender_lines import end_text, falls_short, lines_of, needed_beside  # noqa: E402
from uwopt.report.text.layout import Text  # noqa: E402
from uwopt.results.design import Margin  # noqa: E402
from uwopt.results.result import Result  # noqa: E402
from uwopt.solvers.explain.solved_again import SolvedAgain  # noqa: E402
from uwopt.solvers.explain.specification import PropertyLimit  # noqa: E402

Make = Callable[..., Any]
ROOT = Path(__file__).parents[3]
TODAY = "2026-11-23"
CAMERA, LAMP = "avt-alvium-1800-c-234m", "arctic-rays-dragonfish-mini-strobe-65deg"
FEW = {
    "cameras": [CAMERA], "lenses": ["thorlabs-mvl16m1"], "ports": ["blue-robotics-4-in-dome-plastic-ring-2026"],
    "lights": ["arctic-rays-dragonfish-mini-strobe-65deg"], "generic": "never",
}  # fmt: skip


def small(catalog: dict[str, Any]) -> dict[str, Any]:
    """reef-mosaic with few parts."""
    mission = yaml.safe_load((ROOT / "problems" / "reef-mosaic.yaml").read_text("utf-8"))
    return mission | {"catalog": catalog, "limits": mission["limits"] | {"cost": 20_000}}


KNOWN: dict[str, Result] = {}


@pytest.fixture(scope="module")
def result() -> Result:
    return solved_once(load_mission(small(FEW)))


def solved_once(mission: Mission, **_: Any) -> Result:
    """A mission's result, solved once for all tests."""
    key = json.dumps(mission.to_dict())
    if key not in KNOWN:
        KNOWN[key] = solve(mission, quick=True)
    return KNOWN[key]


@pytest.fixture(autouse=True)
def each_mission_is_solved_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("uwopt.api.quoting.solve", solved_once)


COUNTED = {
    "asked": 0.9, "enough": False, "held": 0.74, "held_low": 0.71, "held_high": 0.77, "scenarios": 1024,
    "held_in_choice": 0.75, "scenarios_in_choice": 256, "p50_in_choice": 61.0, "objective_p50": 62.0,
    "objective_p90": None, "f_number": 4.0, "lost_to": [], "drawn": [], "central_objective": 40.0,
    "central_held": 0.7, "central_p50": None,
}  # fmt: skip


def limit(name: str, feasible: float, best: float | None) -> PropertyLimit:
    return PropertyLimit("light", name, 30_000.0, True, feasible, best, feasible * 1.5)


OWN: list[str] = []  # what the buyer keeps of that tender


@pytest.fixture(scope="module")
def book(result: Result) -> bytes:
    """A tender of limits that are given: finding them takes a second a part."""
    loose = PropertyLimit("light", "min_pulse_us", 100.0, False, 5000.0, None, 4000.0)
    found = {"light": [limit("flux_lm", 12_499.4, 29_645.5), loose]}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tender_lines, "specification", lambda *given: found.get(given[3], []))
        lines = lines_of(result, "r")
    assert "(of a pulsed one while it is on): at least 18 800 lm" in letter(result, lines)
    assert "shortest pulse" not in letter(result, lines)  # 4 ms, where the named lamp has 0.1
    OWN.append(kept_back(lines))
    for said in ("window, flat or dome: dome, as in", "radius of a dome: ", "sensor, mono or colour: mono, as in"):
        assert said in letter(result, lines)
    return tender_book(result, lines)


def filled(book: bytes, folder: Path, *columns: tuple[str, int, dict[str, object]]) -> Path:
    """The workbook as makers send it back: sheet, maker, answers by key."""
    opened = openpyxl.load_workbook(io.BytesIO(book))
    for sheet, maker, answers in columns:
        rows = {cell.value: cell.row for cell in opened[sheet]["A"]}
        for key, value in answers.items():
            row = rows.get(key) or opened[sheet].max_row + 1  # makers add lines of their own
            opened[sheet].cell(row, 1).value = key
            opened[sheet].cell(row, FIRST_ANSWER + maker - 1).value = value
    opened.save(folder / "answers.xlsx")
    return folder / "answers.xlsx"


QUOTED = {"manufacturer": "Arctic Rays", "model": "Dragonfish", "named_part": "yes", "price": 2500, "currency": "USD",
          "price_date": "2026-11-20", "valid_until": "2027-01-31", "lead_time_weeks": 8, "power_w": 520,
          "mass_g": "3 s", "max_duty_frac": 0.02}  # fmt: skip
BETTER = {"manufacturer": "Acme", "model": "Bolt", "named_part": "no", "price": 2000, "currency": "USD",
          "price_date": "2026-11-21", "kind": "pulsed_led", "flux_lm": 60_000, "power_w": 400, "depth_rating_m": 300,
          "max_pulse_us": 5000, "min_pulse_us": 20, "max_rate_hz": 5, "beam_angle_deg": 65,
          "max_duty_frac": 0.1}  # fmt: skip


def test_sheets_ask_what_is_needed_and_what_is_not_known(book: bytes) -> None:
    opened = openpyxl.load_workbook(io.BytesIO(book))
    assert opened.sheetnames == ["Read me", "camera", "lens", "port", "light"]
    rows = {row[0].value: [cell.value for cell in row] for row in opened["light"].iter_rows()}
    assert rows["flux_lm"][3:5] == ["at least 12 500 lm", "at least 18 800 lm"]
    assert rows["flux_lm"][5:7] == ["30000", "published"]
    assert rows["power_w"][6] == "estimated"
    assert rows["depth_rating_m"][3] == "at least 100 m"
    assert {"named_part", "beam_angle_deg", "trigger"} <= rows.keys()
    assert any("yes,no" in str(rule.formula1) for rule in opened["light"].data_validations.dataValidation)


def test_what_would_win_against_a_part_is_not_told_its_maker(book: bytes) -> None:
    opened = openpyxl.load_workbook(io.BytesIO(book))
    told = " ".join(str(cell) for sheet in opened for row in sheet.iter_rows(values_only=True) for cell in row)
    assert not any(word in told for word in ("prefer", "best buy", "would do as well", "29 700"))
    assert "would do as well" in OWN[-1] and "at least 29 700 lm" in OWN[-1] and OWN[-1].startswith("Not for makers")


def test_makers_are_told_what_fits_and_how_deep_it_must_go(result: Result) -> None:
    asked = result.mission | {
        "limits": result.mission["limits"] | {"depth_rating_m": None},
        "reserve": result.mission["reserve"] | {"depth": 1.25},
        "requirements": result.mission["requirements"] | {"colour": "mono"},
    }
    (scene,) = result.recommendation.as_set.scenes
    taken_up = [Margin(f"housing_{way}_mm", needed, 300.0, "<=", 300.0 - needed, "mm", None, True, False)
                for way, needed in (("diameter", 54.9), ("length", 177.2))]  # fmt: skip
    deep = with_margins(replace(result, mission=asked), [*scene.margins, *taken_up])
    needed = {(kind, key): needed_beside(deep, kind, key) for kind, key in (
        ("port", "depth_rating_m"), ("housing", "inner_diameter_mm"), ("housing", "inner_length_mm"),
        ("camera", "mounts"), ("lens", "mounts"), ("camera", "colour"), ("camera", "shutter"), ("lens", "mass_g"),
    )}  # fmt: skip
    assert [*needed.values()] == [
        "at least 37.5 m", "at least 55.0 mm", "at least 178 mm", "C", "C", "mono", "", "",
    ]  # fmt: skip


def with_margins(result: Result, margins: list[Margin]) -> Result:
    """A result of one scene whose system has these margins as set."""
    best = result.recommendation
    assert best is not None
    scene = replace(best.scenes[0], margins=margins, margins_as_set=margins)
    return replace(result, recommendation=replace(best, scenes=[scene]))


def test_who_is_better_by_likeliest_values_alone_is_no_limit(
    monkeypatch: pytest.MonkeyPatch, result: Result
) -> None:
    """A pair chosen for how often it holds was to stay the best against a cheaper one: "at most 1 440 px" of 1 440."""
    best = result.best
    assert best is not None and best.objective_value is not None
    others = [
        SimpleNamespace(hardware={"camera": name}, objective_value=times * best.objective_value, worse_frac=0.3)
        for name, times in (("cheaper-but-seldom", 0.8), ("dearer", 1.3))
    ]
    monkeypatch.setattr(tender_lines, "other_systems", lambda *_: others)
    goal = goal_of(load_mission(small(FEW)))
    assert tender_lines.nearest_rival(result, "camera", goal) == (pytest.approx(1.3 * best.objective_value), "dearer")


def test_a_tender_without_time_asks_without_limits_and_says_so(result: Result) -> None:
    none = Deadline.after(0.0)
    hurried = lines_of(result, "x", none)
    kinds = ["camera", "lens", "port", "light"]
    bought = [FEW[named][0] for named in ("cameras", "lenses", "ports", "lights")]
    assert [(line.kind, line.part_id) for line in hurried] == list(zip(kinds, bought, strict=True))
    found = [{"part": "twin", "name": "Twin", "interface": "GigE", "value": 1.0}]
    twins = lines_of(replace(result, robustness={"siblings": found}), "x", Deadline.after(0.0))
    assert [line.alternatives[:1] == ("twin",) for line in twins] == [True, False, False, False]
    assert none.left_out and {f"the limits of the {kind}" for kind in kinds}.issuperset(none.left_out)


def test_a_tender_of_what_misses_a_requirement_says_so_first(result: Result, make_result: Make) -> None:
    (scene,) = result.recommendation.as_set.scenes
    blurred = Margin("max_blur_px", 2.3, 1.0, "<=", -1.3, "px", None, False, False)
    missing = with_margins(result, [*scene.margins, blurred])
    told = "This system misses what is asked: motion blur (2.300 px against 1.000 px)."
    assert letter(missing, []).startswith(f"[{told} Take this line out")
    first = openpyxl.load_workbook(io.BytesIO(tender_book(missing, [])))["Read me"]
    assert str(first["A2"].value).startswith(told)
    assert falls_short(result) == falls_short(make_result(confidence=COUNTED | {"held": 0.97, "enough": True})) == ""
    unsure = falls_short(make_result(confidence=COUNTED))
    assert unsure.startswith("This system is not certain enough: it holds in 74 %")


def test_limits_are_rounded_to_the_safe_side() -> None:
    from uwopt.catalog.columns import COLUMNS

    column = COLUMNS["light"]["flux_lm"]
    assert end_text(12_411.0, limit("flux_lm", 1.0, None), column) == "at least 12 500 lm"
    less = PropertyLimit("light", "power_w", 10.0, False, None, None, 1.0)
    assert end_text(7.899, less, COLUMNS["light"]["power_w"]) == "at most 7.89 W"


def test_two_ends_of_a_number_stand_in_one_cell(result: Result) -> None:
    ends = [PropertyLimit("light", "beam_angle_deg", 65.0, more, value, None, 65.0 + (value - 65.0) / 2)
            for more, value in ((True, 51.26), (False, 80.77))]  # fmt: skip
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tender_lines, "specification", lambda *_: ends)
        light = next(line for line in lines_of(result, "r") if line.kind == "light")
    fact = next(fact for fact in light.facts if fact.key == "beam_angle_deg")
    assert (fact.needed, fact.stays_best) == ("at least 51.3° and at most 80.7°", "")


def test_the_whole_loop_ends_in_an_order(book: bytes, tmp_path: Path) -> None:
    file = filled(book, tmp_path, ("light", 1, QUOTED), ("light", 2, BETTER))
    made = with_quotes(small(FEW), file, today=TODAY)
    assert [(offer.part_id, offer.usable) for offer in made.offers] == [(LAMP, True), ("acme-bolt", True)]
    assert made.offers[0].faults == ("mass_g: '3 s' is in another unit; it is asked in g",)
    assert "trigger_jitter_us" in made.offers[0].missing
    assert made.after.best.hardware.light.id == "acme-bolt"
    assert {row.id: row.unit_price for row in made.after.best.bom}["acme-bolt"] == 2000.0
    assert made.after.best.objective_value < made.before.best.objective_value
    told = " ".join(change_sentences(made))
    assert f"Light acme-bolt instead of {LAMP}, as it is offered (2000 USD, " in told
    assert "The former recommendation now reaches" in told
    assert "what is to be made" not in told


def test_what_is_now_known_of_a_part_alone_narrows_its_price(book: bytes, tmp_path: Path) -> None:
    made = with_quotes(small(FEW), filled(book, tmp_path, ("light", 1, QUOTED)), today=TODAY)
    told = " ".join(change_sentences(made))
    assert told.startswith("The recommendation stands. Power: ")
    before, after = made.before.best.totals.cost, made.after.best.totals.cost
    assert after.high - after.low < 0.5 * (before.high - before.low)


def test_an_answer_that_lacks_a_vital_fact_is_told_and_not_searched(tmp_path: Path) -> None:
    texts = {key: str(value) for key, value in BETTER.items() if key != "depth_rating_m"}
    offers, log = logged(offers_of([MakerAnswers("a maker", "light", LAMP, texts)], TODAY), TODAY)
    (tmp_path / LOG_FILE).write_text(log, "utf-8")
    (told,) = searched(offers, naming(load_mission(small(FEW)), tmp_path / LOG_FILE, offers))
    assert not told.usable
    assert told.faults[0].startswith("cannot be searched: depth rating, ")


def test_what_is_offered_is_searched_beside_what_the_mission_names(tmp_path: Path) -> None:
    texts = {key: str(value) for key, value in BETTER.items()}
    offers = offers_of([MakerAnswers("a maker", "light", LAMP, texts)], TODAY)
    assert naming(load_mission(small(FEW)), tmp_path / LOG_FILE, offers).catalog.lights == (LAMP, "acme-bolt")


def test_of_two_offers_of_one_part_the_cheaper_counts() -> None:
    texts = {"named_part": "yes", "currency": "USD", "price_date": "2026-11-20"}
    sheets = [MakerAnswers("a maker", "light", LAMP, texts | {"price": price}) for price in ("900", "700", "800")]
    told, log = logged(offers_of(sheets, TODAY), TODAY)
    assert [offer.usable for offer in told] == [False, True, False]
    assert [row["new"] for row in csv.DictReader(log.splitlines()[3:]) if row["cell"] == "price"] == ["700"]


def test_whoever_decides_again_reads_how_certain_it_is(make_result: Make) -> None:
    now, was = make_result(confidence=COUNTED), make_result(confidence=COUNTED | {"held": 0.57})
    (told,) = certainty_sentences(SolvedAgain(before=was, after=now))
    assert told.startswith("Not certain enough: it holds in 74 % of 1 024 scenarios") and "before in 57 %" in told
    surer = make_result(confidence=COUNTED | {"held": 0.97, "enough": True})
    assert next(certainty_sentences(SolvedAgain(before=was, after=surer))).startswith("It holds in 97 %")
    assert [*certainty_sentences(SolvedAgain(before=was, after=make_result()))] == []


def test_what_is_wrong_with_a_part_as_a_whole_is_told_without_our_own_table() -> None:
    texts = {key: str(value) for key, value in BETTER.items()} | {"min_pulse_us": "6000"}  # above its longest
    (told,), log = logged(offers_of([MakerAnswers("a maker", "light", LAMP, texts)], TODAY), TODAY)
    assert (told.usable, log) == (False, "")
    assert told.faults == ("min_pulse_us = 6000 is above max_pulse_us = 5000; swap or correct them",)


def test_answers_as_csv_are_read_alike(tmp_path: Path) -> None:
    lines = [f"light,{LAMP},price,900,", f"light,{LAMP},currency,USD,", f"camera,{CAMERA},price,,5"]
    (tmp_path / "a.csv").write_text("\n".join(["part,candidate,key,maker 1,maker 2", *lines]), "utf-8")
    found = {one.where: dict(one.texts) for one in read_answers(tmp_path / "a.csv")}
    assert found["a.csv, light, maker 1"] == {"price": "900", "currency": "USD"}
    assert found["a.csv, camera, maker 2"] == {"price": "5"}
    assert found["a.csv, camera, maker 1"] == {"price": ""}


def test_a_workbook_of_another_form_is_told(tmp_path: Path) -> None:
    openpyxl.Workbook().save(tmp_path / "a.xlsx")
    with pytest.raises(CatalogError, match="holds no sheet of the form"):
        read_answers(tmp_path / "a.xlsx")


@pytest.mark.parametrize(("header", "told"), [
    ("kind,id,manufacturer,model,to_pay", "is the bill, not the tender"),
    ("id,price,currency,date", "is a price list, which a mission names in catalog.prices"),
    ("part,id,manufacturer,model", "is a table of parts, which a mission names in catalog.files"),
    ('{"a": 1', "holds no answers to a tender"),
])  # fmt: skip
def test_a_table_that_holds_no_answers_is_told_for_what_it_is_before_its_rows(
    header: str, told: str, tmp_path: Path
) -> None:
    (tmp_path / "a.csv").write_text(f"{header}\n1,2,3,4,5,6,7,8\n", "utf-8")
    with pytest.raises(CatalogError, match=re.escape(told)) as refused:
        read_answers(tmp_path / "a.csv")
    assert len(refused.value.faults) == 1


def test_a_bill_in_place_of_a_tender_is_told_before_its_formulas(result: Result, tmp_path: Path) -> None:
    (tmp_path / "bom.xlsx").write_bytes(bom_book(result))
    with pytest.raises(CatalogError, match=re.escape("is the bill, not the tender; name tender.xlsx")):
        read_answers(tmp_path / "bom.xlsx")
    with pytest.raises(CatalogError, match=re.escape("is a folder; name the tender.xlsx in it")):
        read_answers(tmp_path)


def test_a_day_that_is_none_is_refused(tmp_path: Path) -> None:
    """`--date 3.4.2026` was compared with days as text."""
    with pytest.raises(MissionError, match=re.escape("'3.4.2026' is no day; write YYYY-MM-DD")):
        with_quotes(small(FEW), tmp_path / "tender.xlsx", today="3.4.2026")


def test_nothing_answered_changes_nothing(book: bytes, tmp_path: Path) -> None:
    made = with_quotes(small(FEW), filled(book, tmp_path), today=TODAY)
    assert made.before is made.after
    text = [line.plain for block in answer_blocks(made) for line in block.lines if isinstance(line, Text)]
    assert text == ["Nothing: no answer told anything that is new and can be used."]


def test_command_keeps_answers_and_order(
    book: bytes, result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[Mission] = []
    monkeypatch.setattr("uwopt.report.write.page_text", lambda *_: "")  # pictures take seconds
    monkeypatch.setattr("uwopt.api.quoting.solve", lambda mission, **_: seen.append(mission) or result)
    file = filled(book, tmp_path, ("light", 1, QUOTED))
    (tmp_path / "reef.yaml").write_text(yaml.safe_dump(small(FEW)), "utf-8")
    named = [str(tmp_path / "reef.yaml"), str(file), "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(app, ["quotes", *named, "--date", TODAY])
    assert done.exit_code == 0, done.output
    assert "The recommendation stands." in done.output
    assert (tmp_path / "out" / LOG_FILE).read_text("utf-8").count(LAMP) >= 4
    assert seen[1].catalog.files == (str(tmp_path / "out" / LOG_FILE),)
    assert (tmp_path / "out" / "bom.xlsx").exists()
    assert f"written: {tmp_path / 'out' / LOG_FILE}, " in done.output


def test_a_result_without_a_system_asks_for_nothing(make_result: Make) -> None:
    with pytest.raises(ResultError, match="nothing to ask for"):
        lines_of(make_result(recommendation=None, status="infeasible"), "r.json")


@pytest.mark.parametrize(("medium", "told"), [
    ("water", "- full beam angle, measured in water: at least 77.0 deg"), ("", "- full beam angle: at least 77.0 deg"),
])  # fmt: skip
def test_a_maker_is_told_where_a_beam_is_measured(medium: str, told: str) -> None:
    facts = (
        tender_lines.AskedFact("beam_angle_deg", "full beam angle", "deg", "at least 46.2 deg", "", "at least 77.0 deg",
                               "90", "published"),
        tender_lines.AskedFact("beam_medium", "where it is measured", "", "", "", "", medium, "published"),
    )  # fmt: skip
    line = tender_lines.TenderLine("light", "acme", "Acme flash", True, 2, (), "", facts)
    assert enough_text(line) == f"Light:\n{told}"

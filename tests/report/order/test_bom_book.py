"""The bill as a workbook: recalculated by an independent program, and safe to open."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

openpyxl = pytest.importorskip("openpyxl")

from uwopt.documents.files import FORMULA_SIGNS  # noqa: E402
from uwopt.quantities import AT_LIKELIEST  # noqa: E402
from uwopt.report import write  # noqa: E402
from uwopt.report.order.bom_book import bom_book  # noqa: E402
from uwopt.report.order.other_parts import other_systems  # noqa: E402
from uwopt.report.text.not_counted import not_counted, supply_voltages  # noqa: E402
from uwopt.results.design import BillRow, UsedPart  # noqa: E402
from uwopt.results.result import Result  # noqa: E402

Make = Callable[..., Any]
SYSTEMS, FIRST_LINE = "C3", 7


def opened(result: Result) -> Any:
    return openpyxl.load_workbook(io.BytesIO(bom_book(result)))


def labelled(sheet: Any, label: str, column: str) -> str:
    """Address of a cell in the row whose first columns hold a label."""
    rows = (cell.row for name in "AB" for cell in sheet[name] if cell.value == label)
    return f"{column}{next(rows)}"


def recalculated(result: Result, folder: Path, **typed: object) -> tuple[Any, dict[str, Any]]:
    """The order as typed into, and every value that the `formulas` library (not ours) computes of it."""
    formulas = pytest.importorskip("formulas")
    book = opened(result)
    for cell, value in typed.items():
        book["Order"][cell].value = value
    book.save(folder / "bom.xlsx")
    solved = formulas.ExcelModel().loads(str(folder / "bom.xlsx")).finish().calculate()
    prefix = "'[bom.xlsx]ORDER'!"
    values = {k.removeprefix(prefix): v.value[0, 0] for k, v in solved.items() if k.startswith(prefix) and ":" not in k}
    return book["Order"], values


@pytest.mark.filterwarnings("ignore")
def test_totals_are_the_result_s_and_no_cell_is_an_error(tmp_path: Path, make_result: Make) -> None:
    result = make_result()
    sheet, values = recalculated(result, tmp_path)
    cost = result.best.totals.cost
    row = [float(values[labelled(sheet, "sum of these lines", column)]) for column in "PQR"]
    assert row == pytest.approx([cost.value, cost.low, cost.high])
    assert float(values[labelled(sheet, "pieces without a price", "P")]) == 0.0
    assert not [value for value in values.values() if str(value).startswith("#")]


@pytest.mark.filterwarnings("ignore")
def test_totals_follow_systems_quotes_tax_and_what_is_filled_in(tmp_path: Path, make_result: Make) -> None:
    # by hand: three systems are 3 cameras, one quoted at 2000, and 3 x 2 - 1 = 5 lamps of 2300: 6000 + 11 500 = 17 500;
    # 2 spares of 100 and 10 % tax: 1.1 x 17 700 = 19 470
    sheet = opened(make_result())["Order"]
    spares, tax = labelled(sheet, "spares", "H"), labelled(sheet, "tax and customs", "I")
    typed = {SYSTEMS: 3, f"L{FIRST_LINE}": 2000, spares: 2, spares.replace("H", "I"): 100, tax: 0.1}
    sheet, values = recalculated(make_result(), tmp_path, **typed)
    assert float(values[labelled(sheet, "sum of these lines", "P")]) == pytest.approx(17_500.0)
    assert float(values[labelled(sheet, "total with what you filled in", "P")]) == pytest.approx(19_470.0)


@pytest.mark.parametrize("sign", ["=", "+", "-", "@", "\t", "\r", "\x07="])
def test_no_text_of_a_file_becomes_a_formula(make_result: Make, sign: str) -> None:
    evil = f'{sign}HYPERLINK("http://bad.example")'
    result = make_result()
    rows = [replace(row, manufacturer=evil, model=evil, note=evil + "\x07", source=evil) for row in result.best.bom]
    result = replace(result, recommendation=replace(result.best, bom=rows), mission={**result.mission, "name": evil})
    cells = [cell for sheet in opened(result) for row in sheet.iter_rows() for cell in row if cell.value is not None]
    assert not [cell.value for cell in cells if cell.data_type == "f" and "HYPERLINK" in cell.value]
    told = [cell.value for cell in cells if "HYPERLINK" in str(cell.value)]
    assert len(told) >= 8
    assert not [text for text in told if text.startswith(FORMULA_SIGNS)]


def test_every_line_says_why_and_what_else_would_do(make_result: Make) -> None:
    result = make_result()
    other = replace(result.runners_up[0], objective_value=result.best.objective_value * 1.05)
    hardware = replace(result.best.hardware, camera=replace(other.hardware.camera, id="other-cam"))
    result = replace(result, runners_up=[replace(other, hardware=hardware)])
    sheet = opened(result)["Order"]
    assert sheet[f"W{FIRST_LINE}"].value.endswith("the nearest system with another one is 5.0 % worse in power")
    assert sheet[f"X{FIRST_LINE}"].value == "other-cam (5.0 % worse in power)"
    assert sheet[f"S{FIRST_LINE}"].value == "not known, ask"


def test_other_systems_are_held_against_the_best_by_the_same_numbers(make_result: Make) -> None:
    # 44 W at likeliest values, whose best is 40 W: a tenth worse, though what is recommended has 50 W where it is set
    known = {
        "asked": 0.9, "enough": True, "held": 0.95, "held_low": 0.94, "held_high": 0.96, "scenarios": 1024,
        "held_in_choice": 0.97, "scenarios_in_choice": 256, "p50_in_choice": 61.0, "objective_p50": 62.0,
        "objective_p90": 90.0, "f_number": 4.0, "lost_to": [], "drawn": [], "central_objective": 40.0,
        "central_held": 0.8, "central_p50": None,
    }  # fmt: skip
    made = make_result(confidence=known)
    chosen = replace(made, recommendation=replace(made.best, objective_value=50.0))
    assert [round(one.worse_frac, 6) for one in other_systems(chosen) if one.place == "runner-up 2"] == [0.1]
    told, plain = (str(opened(one)["Second sources"]["A3"].value).lower() for one in (chosen, make_result()))
    assert AT_LIKELIEST in told and AT_LIKELIEST not in plain


def test_what_is_worse_by_nothing_is_told_as_good(make_result: Make) -> None:
    made = make_result()
    equal = replace(made.runners_up[0], objective_value=made.best.objective_value * (1.0 + 1e-6))
    sheet = opened(replace(made, runners_up=[equal]))["Second sources"]
    (cell,) = (row[3] for row in sheet.iter_rows() if row[0].value == "runner-up 2")
    assert cell.value == 0.0 and cell.number_format.endswith('"as good"')


def test_the_recommended_system_is_no_second_source_of_itself(make_result: Make) -> None:
    """What is chosen for how often it holds is among the runners-up at likeliest values, with other settings."""
    made = make_result()
    again = replace(made.best, objective_value=made.best.objective_value * 1.01)
    told = [one.place for one in other_systems(replace(made, runners_up=[again, *made.runners_up]))]
    assert "runner-up 2" not in told and "runner-up 3" in told


def test_a_camera_is_fed_over_its_cable_where_its_interface_feeds(make_result: Make) -> None:
    # maker's page: 5 VDC of a USB3 camera; power over Ethernet is taken at 36 to 57 V
    row = make_result().best.bom[0]
    told = {name: supply_voltages([replace(row, id=name)]) for name in
            ("basler-aca2500-60uc", "flir-bfs-pge-50s5c", "avt-alvium-1800-c-507c")}  # fmt: skip
    assert told["basler-aca2500-60uc"].endswith("5 V over its USB3 cable")
    assert told["flir-bfs-pge-50s5c"].endswith("36 to 57 V over its GigE cable")
    assert told["avt-alvium-1800-c-507c"].startswith("supply voltage not known: ask")


def test_a_computer_in_the_camera_s_housing_has_its_place(make_result: Make) -> None:
    result = make_result()
    housing = {"id": "acme-tube", "name": "Acme tube", "generic": False}
    board = replace(
        result.best.bom[0], kind="extra", id="host-computer", model="computer",
        note="in the camera's housing, for CSI-2 reaches 0.3 m",
    )  # fmt: skip
    control = replace(board, id="rest-lamp-control", model="electronics", note="")
    hardware = replace(result.best.hardware, housing=UsedPart(**housing))
    held = replace(result.best, hardware=hardware, bom=[*result.best.bom, board, control])
    told = {one.what: one.known for one in not_counted(replace(result, recommendation=held), held)}
    assert told["a place for electronics"].startswith("electronics: neither size")
    assert "a place for computer and electronics" not in told


def test_an_order_that_is_not_certain_enough_says_so_above_its_lines(make_result: Make) -> None:
    # where it was counted how often it holds, that every requirement is met at likeliest values is no verdict
    counted = {
        "asked": 0.9, "enough": False, "held": 0.49, "held_low": 0.46, "held_high": 0.52, "scenarios": 1024,
        "held_in_choice": 0.5, "scenarios_in_choice": 256, "p50_in_choice": 61.0, "objective_p50": 62.0,
        "objective_p90": 90.0, "f_number": 4.0, "lost_to": [], "drawn": [], "central_objective": 30.0,
        "central_held": 0.4, "central_p50": None, "central_hardware": ["acme-cam"],
    }  # fmt: skip
    unsure = make_result(status="feasible", confidence=counted)
    assert opened(unsure)["Order"]["A2"].value.startswith("Not certain enough: does what is asked in 49 % of 1 024")
    assert opened(make_result())["Order"]["A2"].value.startswith("Best of the catalogue")


@pytest.mark.parametrize(("hours", "depth_m", "told"), [(2000.0, 40.0, True), (300.0, 40.0, False),
                                                      (2000.0, 900.0, False), (None, 40.0, False)])  # fmt: skip
def test_weeks_in_water_that_light_reaches_ask_for_what_keeps_growth_off(
    make_result: Make, hours: float | None, depth_m: float, told: bool
) -> None:
    made = make_result()
    result = replace(made, mission={**made.mission, "vehicle": {"duration_h": hours}, "scenes": [{"depth_m": depth_m}]})
    known = {one.what: one.known for one in not_counted(result, made.best)}.get("what keeps growth off", "")
    assert known.startswith("83.3 days under water: what grows") == told == bool(known)


@pytest.mark.parametrize(
    ("hours", "salinity_psu", "name", "told"),
    [
        (2000.0, 35.0, "tube of aluminium", True), (200.0, 35.0, "tube of aluminium", False),
        (2000.0, 0.0, "tube of aluminium", False), (2000.0, 35.0, "tube of titanium", False),
    ],
)  # fmt: skip
def test_weeks_in_salt_water_ask_for_what_protects_aluminium(
    make_result: Make, hours: float, salinity_psu: float, name: str, told: bool
) -> None:
    made = make_result()
    scenes = [{"depth_m": 900.0, "salinity_psu": salinity_psu}]
    result = replace(made, mission={**made.mission, "vehicle": {"duration_h": hours}, "scenes": scenes})
    housing = replace(made.best.hardware.camera, id="a-tube", name=name)
    best = replace(made.best, hardware=replace(made.best.hardware, housing=housing))
    known = {one.what: one.known for one in not_counted(result, best)}.get("what keeps corrosion off", "")
    assert known.startswith("83.3 days in salt water") == told == bool(known)


def test_second_sources_are_close_enough_by_a_cell(make_result: Make) -> None:
    sheet = opened(make_result())["Second sources"]
    assert sheet["B2"].value == 0.1
    assert sheet["E5"].value == '=IF(D5="","",IF(D5<=$B$2,"yes","no"))'


def test_what_the_bill_holds_is_not_among_what_it_lacks(make_result: Make) -> None:
    result = make_result()
    extra: dict[str, Any] = {"kind": "extra", "id": "host-computer", "price_basis": "", "manufacturer": ""}
    row: BillRow = replace(result.best.bom[0], **extra)
    held = replace(result, recommendation=replace(result.best, bom=[*result.best.bom, row]))
    lacking = [[cell.value for cell in opened(one)["Order"]["B"]] for one in (result, held)]
    assert ["computer with storage" in names for names in lacking] == [True, False]


def test_voltages_are_those_of_the_maker_s_sheet_and_all_others_are_to_be_asked(make_result: Make) -> None:
    # the maker's sheet of the lamp: 9 to 35 VDC
    rows = [
        replace(row, id="arctic-rays-dragonfish-mini-strobe") if row.kind == "light" else row
        for row in make_result().best.bom
    ]
    computer = replace(rows[0], kind="extra", id="host-computer")
    told = supply_voltages([*rows, computer])
    assert told == (
        "arctic-rays-dragonfish-mini-strobe: 9 to 35 V; supply voltage not known: ask, for acme-cam, host-computer"
    )
    result = make_result()
    known = replace(result, recommendation=replace(result.best, bom=rows))
    assert "supply voltages" in [cell.value for cell in opened(known)["Order"]["B"]]


def test_a_computer_needs_a_place_that_nobody_counted(make_result: Make) -> None:
    result = make_result()
    computer = replace(result.best.bom[0], kind="extra", id="host-computer", model="computer that takes the images")
    held = replace(result, recommendation=replace(result.best, bom=[*result.best.bom, computer]))
    told = [{one.what: one.known for one in not_counted(each, each.best)} for each in (result, held)]
    place = "a place for computer and electronics"
    assert place not in told[0]
    assert told[1][place].startswith("computer that takes the images: neither size nor mass is counted")


def test_no_batteries_are_bought_where_the_vehicle_feeds_the_system(make_result: Make) -> None:
    result = make_result()
    fed = {one.what: one for one in not_counted(result, result.best)}
    assert "batteries" not in fed
    assert not fed["power from the vehicle"].bought
    torches = replace(result, mission={**result.mission, "vehicle": {"lamp_supply": "battery"}})
    lit = {one.what: one for one in not_counted(torches, result.best)}
    assert lit["batteries"].bought
    assert "power from the vehicle" not in lit
    named = replace(result.best.hardware, light=replace(result.best.hardware.light, id="sofirn-sd05"))
    owned = {one.what: one.known for one in not_counted(result, replace(result.best, hardware=named))}
    assert owned["batteries"].endswith("the lamps have their own, the vehicle feeds the rest")  # whoever asked for them


def test_housings_that_float_need_ballast(make_result: Make) -> None:
    """10.315 l of lead in water weigh 10.315 (11.34 - 1.025) = 106.4 kg, 117 kg in air."""
    result = make_result()
    told = [
        {one.what: one.known for one in not_counted(result, replace(
            result.best, totals=replace(result.best.totals, mass_water_kg=mass_kg)))}.get("ballast")
        for mass_kg in (None, 0.8, -0.09, -106.4)
    ]  # fmt: skip
    assert told[:3] == [None] * 3
    assert told[3] == (
        "cameras in their housings float with 106 kg; 117 kg of lead hold them; lamps and cables are not counted"
    )


def test_book_without_a_design_holds_no_old_lines(make_result: Make) -> None:
    book = opened(make_result(status="infeasible", recommendation=None))
    assert book["Order"].max_row == FIRST_LINE - 1


def test_book_lies_beside_the_table(tmp_path: Path, make_result: Make) -> None:
    write.write_results(make_result(), tmp_path)
    assert openpyxl.load_workbook(tmp_path / "bom.xlsx")["Order"][f"E{FIRST_LINE}"].value == "acme-cam"

"""The buyer's loop from a mission to an order: solve, tender, answers as a maker fills them in, solve again, the bill.

One answer is in a wrong unit, one is missing, one is better than was hoped. The default run takes reef-mosaic among few
parts; a thorough one the missions as they stand.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import pytest
from thorough import THOROUGH, drawn

openpyxl = pytest.importorskip("openpyxl")

from uwopt.api.quoting import with_quotes  # noqa: E402
from uwopt.api.solving import solve  # noqa: E402
from uwopt.mission.mission import Mission, load_mission  # noqa: E402
from uwopt.report.order import tender_lines  # noqa: E402
from uwopt.report.order.answers import answer_blocks, change_sentences  # noqa: E402
from uwopt.report.order.bom_book import bom_book  # noqa: E402
from uwopt.report.order.tender_book import FIRST_ANSWER, letter, tender_book  # noqa: E402
from uwopt.report.order.tender_lines import cells_of, lines_of  # noqa: E402
from uwopt.results.result import Result  # noqa: E402

PROBLEMS = Path(__file__).parents[3] / "problems"
MISSIONS = drawn(("reef-mosaic",), ("reef-mosaic", "nui-acfr", "jobs/deep-auv"))
TODAY = "2026-11-23"
#: Facts that a maker of a lamp states, as they stand in the table of the one that is named.
FACTS = (
    "kind", "flux_lm", "beam_angle_deg", "beam_medium", "depth_rating_m", "spectrum", "supply", "trigger",
    "min_pulse_us", "max_pulse_us", "max_rate_hz", "max_duty_frac", "flash_energy_j", "flash_duration_us", "recycle_s",
    "dim_min_frac", "output_factor", "flash_efficacy_lm_s_per_j", "charging_efficiency_frac", "power_w",
)  # fmt: skip
BETTER = 0.8  # of the power for the same light


def mission_of(name: str) -> Mission:
    mission = load_mission(PROBLEMS / f"{name}.yaml")
    if THOROUGH:
        return mission
    few = {"cameras": ["avt-alvium-1800-c-234m"], "lenses": ["thorlabs-mvl16m1"], "ports": ["blue-robotics-4-in-dome*"]}
    catalog = mission.to_dict()["catalog"] | few | {"lights": ["arctic-rays-*"], "generic": "never"}
    return mission.with_changes(catalog=catalog, confidence="central")


def filled(result: Result, book: bytes, folder: Path) -> tuple[Path, str]:
    """The lamp's sheet with two makers' columns, and the id of what the second offers.

    The first quotes the named lamp, but its mass in seconds and without the jitter of its trigger; the second has a
    lamp of its own that does the same for less power.
    """
    lamp = result.best.hardware.light
    known = {key: value for key, value in cells_of(lamp.id).items() if key in FACTS}
    if known["kind"] == "flash":
        key = "flash_efficacy_lm_s_per_j"
        better = {key: float(known.get(key) or assumed(result, lamp.id, key)) / BETTER}
    else:
        better = {"power_w": float(known.get("power_w") or assumed(result, lamp.id, "power_w")) * BETTER}
    quote = {"currency": "USD", "price_date": "2026-11-20", "valid_until": "2027-03-31", "lead_time_weeks": 8}
    first = {"manufacturer": "Maker", "model": "as named", "named_part": "yes", "price": 2500, "mass_g": "3 s", **quote}
    second = {"manufacturer": "Acme", "model": "Bolt", "named_part": "no", "price": 900, "mass_g": 500,
              "availability": "current", **known, **better, **quote}  # fmt: skip
    opened = openpyxl.load_workbook(io.BytesIO(book))
    sheet = opened["light"]
    for maker, answers in enumerate((first, second)):
        rows = {cell.value: cell.row for cell in sheet["A"]}
        for key, value in answers.items():
            row = rows.get(key) or sheet.max_row + 1
            sheet.cell(row, 1).value = key
            sheet.cell(row, FIRST_ANSWER + maker).value = value
    opened.save(folder / "answers.xlsx")
    return folder / "answers.xlsx", "acme-bolt"


def assumed(result: Result, part_id: str, key: str) -> float:
    """What is assumed of a number of a lamp."""
    return next(float(a.value) for a in result.assumptions if a.part == part_id and a.path.endswith(f".{key}"))


def recalculated(result: Result, folder: Path) -> tuple[Any, dict[str, Any]]:
    """The order, and every value that the `formulas` library computes of it."""
    formulas = pytest.importorskip("formulas")
    (folder / "bom.xlsx").write_bytes(bom_book(result))
    solved = formulas.ExcelModel().loads(str(folder / "bom.xlsx")).finish().calculate()
    prefix = "'[bom.xlsx]ORDER'!"
    found = {k.removeprefix(prefix): v.value[0, 0] for k, v in solved.items() if k.startswith(prefix) and ":" not in k}
    return openpyxl.load_workbook(folder / "bom.xlsx")["Order"], found


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", MISSIONS)
def test_a_mission_becomes_an_order(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mission = mission_of(name)
    result = solve(mission, quick=True)
    monkeypatch.setattr("uwopt.api.quoting.solve", lambda wanted, **how: result if wanted == mission else solve(
        wanted, **how))  # fmt: skip
    if not THOROUGH:  # limits of parts have tests of their own
        monkeypatch.setattr(tender_lines, "specification", lambda *_: [])
    lines = lines_of(result, name)
    file, offered = filled(result, tender_book(result, lines), tmp_path)
    assert "A part that meets all points below its name is suitable" in letter(result, lines)

    made = with_quotes(mission, file, today=TODAY)
    first, second = made.offers
    generic = result.best.hardware.light.generic
    assert second.usable, second.faults
    assert any("mass_g: '3 s' is in another unit; it is asked in g" in text for text in first.faults) or generic
    assert "trigger_jitter_us" in second.missing or "trigger_jitter_us" in first.missing
    assert made.after.best is not None and answer_blocks(made)
    assert made.after.best.hardware.light.id == offered
    told = " ".join(change_sentences(made))
    assert f"Light {offered} instead of {result.best.hardware.light.id}, as it is offered (900 USD, " in told

    sheet, values = recalculated(made.after, tmp_path)
    cost = made.after.best.totals.cost
    rows = {cell.value: cell.row for column in "AB" for cell in sheet[column] if cell.value}
    sums = [float(values[f"{column}{rows['sum of these lines']}"]) for column in "PQR"]
    assert sums == pytest.approx([cost.value, cost.low, cost.high])
    assert not [value for value in values.values() if str(value).startswith("#")]
    lamp = next(row for row in made.after.best.bom if row.kind == "light")
    assert (lamp.unit_price, lamp.id) == (900.0, offered)

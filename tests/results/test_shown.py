"""Results in Python and in notebooks: text, HTML, frames, plots, report; and the example notebook."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import uwopt
from uwopt.errors import RangeError
from uwopt.results.front import FrontObjective, FrontPoint, FrontResult, Pick
from uwopt.results.result import Result

ROOT = Path(__file__).parents[2]
MISSION = ROOT / "problems" / "nui-acfr.yaml"
SYSTEM = ROOT / "problems" / "nui-acfr.system.yaml"


@pytest.fixture(scope="module")
def seen() -> Result:
    return uwopt.evaluate(MISSION, SYSTEM)


@pytest.fixture(scope="module")
def front() -> FrontResult:
    parts = {
        "camera": "basler-a2a4096-30ucpro",
        "lens": "hikrobot-mvl-kf0814m-12mpe",
        "light": "generic-flash-50j",
    }
    seen = uwopt.evaluate(ROOT / "problems" / "whoi-towcam.yaml", {**parts, "port": "generic-dome-bk7-50mm"})
    assert seen.design is not None
    points = [
        FrontPoint(
            f"p{n}", {"power": 1.0 * n, "cost": 10.0 / n, "snr_db": 20.0 + n}, "c1", "exact", seen.design
        )
        for n in (1, 2, 3)
    ]
    axes = [
        FrontObjective(name, "minimise", unit)
        for name, unit in (("power", "W"), ("cost", "USD"), ("snr_db", "dB"))
    ]
    return FrontResult(
        "complete", seen.mission, seen.physics, axes, "0", points=points, picks=[Pick("knee", "p2", "the bend")]
    )  # fmt: skip


def test_text_is_one_short_line_with_verdict_objective_and_parts(seen: Result):
    text = repr(seen)
    assert "\n" not in text
    assert seen.design is not None
    for word in ("evaluate", seen.status, "power", "W", seen.design.hardware["camera"]["id"]):
        assert word in text


def test_html_holds_verdict_bill_and_all_margins_and_escapes(seen: Result):
    evil = replace(seen, mission={**seen.mission, "name": "<script>x</script>"})
    assert "<script>" not in evil._repr_html_()
    page = seen._repr_html_()
    assert "Bill of materials" in page
    assert page.count("<tr>") > len(seen.frame("bill")) + 10


def test_margins_frame_holds_every_margin_with_unit(seen: Result):
    frame = seen.frame()
    assert seen.design is not None
    wanted = [m for scene in seen.design.scenes for m in scene.margins]
    assert list(frame["requirement"]) == [m.requirement for m in wanted]
    assert list(frame["unit"]) == [m.unit for m in wanted]


@pytest.mark.parametrize(
    "name", ["bill", "settings", "figures", "designs", "certificate", "assumptions", "warnings"]
)
def test_every_table_is_a_frame(seen: Result, name: str):
    frame = seen.frame(name)
    assert (len(frame) > 0) == (name not in ("certificate", "assumptions"))


def test_figures_frame_holds_the_numbers_of_the_scene(seen: Result):
    assert seen.design is not None
    scene = seen.design.scenes[0]
    frame = seen.frame("figures").set_index("figure")
    assert frame.loc["gsd_mm", scene.name] == scene.figures["gsd_mm"]


def test_unknown_table_figure_and_scene_are_told(seen: Result):
    with pytest.raises(RangeError, match="margins, bill"):
        seen.frame("margin")
    with pytest.raises(RangeError, match="spectrum, dof-aperture"):
        seen.figure("spectra")
    with pytest.raises(RangeError, match="the mission has 1"):
        seen.figure("rate", scene=3)


def test_every_plot_of_the_report_is_a_figure(seen: Result):
    assert set(seen.figure_names) == {
        "spectrum", "dof-aperture", "dof-focus", "rate", "exposure", "illuminance", "snr"
    }  # fmt: skip
    # The mission's speed and altitude lie within the plot of the frame rate, and its axis says so.
    rate = seen.figure("rate")
    assert len(rate.data) >= 5
    assert "speed" in rate.layout.xaxis.title.text.casefold()


def test_front_is_a_figure_of_its_objectives(front: FrontResult):
    figure = front.figure("front")
    assert list(figure.data[0].x) == [1.0, 2.0, 3.0]
    assert list(figure.data[0].y) == [10.0, 5.0, 10.0 / 3.0]
    assert "W" in figure.layout.xaxis.title.text


def test_plots_of_a_front_are_of_the_point_asked_for(front: FrontResult):
    assert front.figure("rate", point="knee").data
    with pytest.raises(RangeError, match="p1, p2, p3, knee"):
        front.figure("rate", point="p9")


def test_front_shows_its_picks(front: FrontResult):
    assert "3 points" in repr(front)
    assert "knee" in front._repr_html_()
    assert list(front.frame("picks")["point"]) == ["p2"]


def test_report_is_written(seen: Result, tmp_path: Path):
    assert seen.report(tmp_path / "page.html").read_text("utf-8").startswith("<!")


def test_result_without_design_shows_its_verdict(seen: Result):
    none = replace(seen, command="solve", status="infeasible", design=None)
    assert "infeasible" in repr(none)
    assert none.figure_names == ()
    assert none.frame("bill").empty


def test_example_notebook_runs_and_shows_results(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(ROOT)
    cells = json.loads((ROOT / "docs" / "example.ipynb").read_text("utf-8"))["cells"]
    names: dict[str, Any] = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
    assert names["result"].status == "optimal"
    assert len(names["margins"]) > 10
    assert not names["tried"].design.feasible
    assert len(names["missed"]) > 0
    assert names["figure"].data

"""`uwopt plot`: what is drawn is the model's, what is written is whole, and nothing in a name becomes markup."""

from __future__ import annotations

import csv
import io
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import uwopt
from uwopt.catalog.curves.spectra import water_profile
from uwopt.cli.app import app
from uwopt.errors import MissionError, OutputError, RangeError
from uwopt.explore.plotting import DesignPlot, plot, plot_names

PROBLEMS = Path(__file__).parents[2] / "problems"
MISSION, SYSTEM = PROBLEMS / "paper-tool-window.yaml", PROBLEMS / "paper-tool-window.system.yaml"
NAMES = ("dof", "framerate", "exposure", "spectrum", "attenuation", "sensor")


@pytest.fixture(scope="module")
def plots() -> dict[str, DesignPlot]:
    """The plots of the founding paper's window that its physics knows."""
    named = uwopt.load_mission(MISSION).with_changes(name="<b>$x^2$ & =1+1")
    return {name: plot(name, named, SYSTEM) for name in NAMES}


def curve(made: DesignPlot, name: str, picture: int = 0) -> dict[str, Any]:
    return next(one for one in made.pictures[picture].content["data"] if one["name"] == name)


def test_all_plots_are_tried(plots: dict[str, DesignPlot]) -> None:
    assert set(plot_names()) == {*plots, "light", "map"}


def test_depth_of_field_at_f4_is_that_of_the_papers_window(plots: dict[str, DesignPlot]) -> None:
    # docs/paper.md, equation (9) by hand: 1.2531 m and 4.9736 m; read between points of the curve
    for name, by_hand in (("near limit", 1.2531), ("far limit", 4.9736)):
        line = curve(plots["dof"], name)
        assert np.interp(4.0, line["x"], line["y"]) == pytest.approx(by_hand, rel=3e-3)


def test_rate_and_exposure_at_the_missions_speed_are_those_of_the_papers_window(plots: dict[str, DesignPlot]) -> None:
    # docs/paper.md, equations (8) and (10) by hand
    assert curve(plots["framerate"], "this mission")["y"] == [pytest.approx(0.63149, rel=1e-4)]
    assert curve(plots["exposure"], "this mission's limit")["y"] == [pytest.approx(0.8625, rel=1e-4)]


def test_attenuation_is_that_of_the_table(plots: dict[str, DesignPlot]) -> None:
    table = water_profile("I", "solonenko-mobley")
    line = curve(plots["attenuation"], "c, floor to camera")
    inside = [(x, y) for x, y in zip(line["x"], line["y"], strict=True) if 420 <= x <= 640]
    assert len(inside) > 20
    for at_nm, value in inside:
        by_table = np.interp(at_nm, table.wavelength_nm, table.attenuation_per_m)
        assert value == pytest.approx(by_table, rel=1e-4)  # five digits are drawn


def test_sensor_plot_holds_the_lens_of_the_system_file(plots: dict[str, DesignPlot]) -> None:
    assert curve(plots["sensor"], "lens lets pass")["y"] == [0.9, 0.9]  # transmission: 0.9
    assert 0.4 < max(curve(plots["sensor"], "sensor, mono")["y"]) < 1.0


@pytest.mark.parametrize("name", NAMES)
def test_every_point_of_a_plot_stands_in_its_table(name: str, plots: dict[str, DesignPlot]) -> None:
    rows = list(csv.DictReader(io.StringIO(str(plots[name].content(".csv")))))
    drawn = [one for picture in plots[name].pictures for one in picture.content["data"]]
    assert len(rows) == sum(len(one["x"]) for one in drawn)
    assert float(rows[-1]["y"]) == drawn[-1]["y"][-1]


def test_images_are_images_of_every_pane(plots: dict[str, DesignPlot]) -> None:
    image = Image.open(io.BytesIO(plots["dof"].content(".png")))  # type: ignore[arg-type]
    assert image.width >= 1000
    assert image.height > 1.2 * image.width / 2  # two pictures below each other
    drawn = np.asarray(image.convert("L"))
    assert (drawn < 200).mean() > 0.005


def test_svg_is_the_same_each_time_and_holds_its_words(plots: dict[str, DesignPlot]) -> None:
    first, again = (plots["sensor"].content(".svg") for _ in range(2))
    assert first == again
    root = ET.fromstring(first)
    text = "".join(root.itertext())
    assert "Sensor, lens and port" in text
    assert "wavelength in vacuum [nm]" in text


def test_names_are_no_markup(plots: dict[str, DesignPlot]) -> None:
    page = plots["dof"].html()
    assert "<b>$x^2$" not in page
    assert "&lt;b&gt;$x^2$ &amp; =1+1" in page


def test_page_asks_no_network(plots: dict[str, DesignPlot]) -> None:
    page = plots["dof"].html()
    assert "default-src &#39;none&#39;" in page
    assert 'src="http' not in page


# ---------------------------------------------------------------- maps


@pytest.fixture(scope="module")
def mapped() -> DesignPlot:
    """Depth of field over altitude and aperture; at F1 the lens is asked for more than it opens."""
    return plot("map", MISSION, SYSTEM, inputs={"altitude_m": "1:3:2", "f_number": [4.0, 0.2]}, figure="dof_m")


def test_map_holds_what_evaluate_says(mapped: DesignPlot) -> None:
    mission = uwopt.load_mission(MISSION)
    base = uwopt.load_system(SYSTEM).to_dict()
    for row in mapped.rows():
        if row["f_number"] == 4.0:
            there = mission.with_changes(vehicle={**mission.to_dict()["vehicle"], "altitude_m": row["altitude_m"]})
            design = uwopt.evaluate(there, base).design
            assert design is not None
            assert row["dof_m"] == design.scenes[0].figures["dof_m"]
            assert row["met"] == design.feasible


def test_points_that_cannot_be_are_gaps_with_their_reason(mapped: DesignPlot) -> None:
    gaps = [row for row in mapped.rows() if row["f_number"] == 0.2]
    assert [row["dof_m"] for row in gaps] == [None, None]
    assert mapped.mapped is not None
    assert len(mapped.mapped.refused) == 1
    assert "f_number" in mapped.mapped.refused[0]
    assert "Gaps, 2" in mapped.pictures[0].caption


SMALL = {
    "practice": "bare", "physics": "paper", "scene": {"water": "I", "seafloor": "sand", "depth_m": 20},
    "vehicle": {"altitude_m": 1.5, "speed_m_s": 0.3, "light_count": [1, 2]},
    "requirements": {"overlap": 0.3, "max_blur_px": 1.0, "min_snr_db": 15},
    "catalog": {"cameras": ["avt-alvium-1800-c-234m"], "lenses": ["thorlabs-mvl16m1", "computar-m1214-mp2"],
                "ports": ["blue-robotics-4-in"], "lights": ["arctic-rays-dragonfish-mini-strobe-65deg"]},
}  # fmt: skip


def test_without_a_system_what_is_recommended_is_drawn() -> None:
    made = plot("map", SMALL, inputs={"speed_m_s": [0.2, 0.3], "altitude_m": [1.5, 1.6]}, figure="power_w")
    best = uwopt.solve(SMALL, quick=True).best
    assert best is not None
    own = next(row for row in made.rows() if (row["speed_m_s"], row["altitude_m"]) == (0.3, 1.5))
    assert own["power_w"] == pytest.approx(best.objective_value, rel=1e-6)  # settings go through milliseconds and back
    assert own["met"]
    again = uwopt.evaluate(SMALL, best.as_system()).best
    assert again is not None
    for name, value in best.scenes[0].settings.items():  # gain and level too, which power does not tell
        assert again.scenes[0].settings[name] == (value if value is None else pytest.approx(value, rel=1e-6)), name


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"inputs": {"speed_m_s": "1:2:2"}}, "over two"),
        ({"inputs": {"speed_m_s": "1:2:2", "f_numbr": "2,4"}}, "no key that can be varied"),
        ({"inputs": {"speed_m_s": "1:2:2", "f_number": "2,4"}, "figure": "snr_dB_"}, "did you mean snr_db"),
        ({"inputs": {"camera.pixel_pitch_um": "2,3", "f_number": "2,4"}}, "of the catalogue"),
        ({"inputs": {"speed_m_s": "1:2:200", "f_number": "1:2:200"}}, "too many"),
        ({"inputs": {"speed_m_s": "1:2:2", "f_number": "2,4"}, "scene": 3}, "no scene 3"),
    ],
)
def test_bad_maps_are_told(given: dict[str, Any], told: str) -> None:
    with pytest.raises((MissionError, RangeError), match=told):
        plot("map", MISSION, SYSTEM, **given)


def test_paper_has_no_field_to_draw() -> None:
    with pytest.raises(RangeError, match="physics paper knows no field"):
        plot("light", MISSION, SYSTEM)


def test_light_is_drawn_over_floor_and_image() -> None:
    made = plot("light", MISSION, SYSTEM, physics="full")
    assert [one.id for one in made.pictures] == ["illuminance", "snr"]
    assert made.content(".svg")


def test_file_says_its_form(plots: dict[str, DesignPlot], tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"must end in one of \.html, \.png, \.svg, \.csv"):
        plots["dof"].write(tmp_path / "dof.pdf")
    assert list(tmp_path.iterdir()) == []


def test_command_writes_the_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "new" / "rate.csv"
    with pytest.raises(SystemExit) as left:
        app(["plot", "framerate", str(MISSION), str(SYSTEM), "-o", str(file)])
    assert left.value.code == 0
    assert file.read_text().startswith("plot,curve,x_is,y_is,x,y")
    assert "written:" in capsys.readouterr().err

"""Complete cameras in the catalogue: read from one row, known by their pieces, searched where a mission asks."""

from __future__ import annotations

import math

import pytest

from uwopt.catalog.changes import CellChange, log_text
from uwopt.catalog.choose import Choice, select
from uwopt.catalog.listing import list_parts, show_part
from uwopt.catalog.load import build_rows, read_catalog
from uwopt.catalog.userparts import PartRow
from uwopt.errors import CatalogError, MissionError
from uwopt.mission.mission import load_mission

SEARCHED = [one for one in read_catalog().completes if not read_catalog().exclusions_of(one.id)]
CELLS = {
    "id": "own", "family": "subsea camera", "colour": "mono", "shutter": "global", "resolution_x_px": 2000.0,
    "resolution_y_px": 1500.0, "pixel_pitch_um": 4.0, "f_number_min": 2.0, "geometry": "flat", "focal_length_mm": 8.0,
    "depth_rating_m": 500.0, "interface": "GigE", "projection": "rectilinear",
}  # fmt: skip


def read(**cells):
    """The record of a row, and why it is not searched."""
    kept = {name: cell for name, cell in (CELLS | cells).items() if cell is not None}
    _, built = build_rows([PartRow("complete", "own.csv row 2", kept)], "user")[0]
    return built.part, built.lacks


@pytest.mark.parametrize(
    ("medium", "geometry", "air_deg"),
    [("air", "flat", 60.0), ("water", "dome", 60.0), ("water", "flat", 2 * math.degrees(math.asin(1.34 * 0.5)))],
)
def test_focal_length_follows_from_the_field_of_view(medium, geometry, air_deg):
    # 2000 pixels of 4 um are 8 mm across: f = 4 mm / tan(half the angle in air); behind a flat port sin a = n sin w
    radius = {"outer_radius_mm": 50.0, "thickness_mm": 5.0} if geometry == "dome" else {}
    made, lacks = read(
        focal_length_mm=None, view_deg=60.0, view_side="horizontal", view_medium=medium, geometry=geometry, **radius
    )
    assert not lacks
    assert made.own_lens.focal_length_mm == pytest.approx(4.0 / math.tan(math.radians(0.5 * air_deg)), rel=1e-12)


def test_field_wider_than_a_flat_port_lets_in_is_a_fault():
    with pytest.raises(CatalogError, match="wider than any view through a flat port"):
        read(focal_length_mm=None, view_deg=100.0, view_side="horizontal", view_medium="water")


@pytest.mark.parametrize(
    ("missing", "said"),
    [
        ({"resolution_x_px": None}, "resolution unknown"),
        ({"pixel_pitch_um": None}, "pixel pitch unknown"),
        ({"focal_length_mm": None}, "neither focal length nor a field of view that tells it"),
        ({"f_number_min": None}, "widest opening unknown"),
        ({"shutter": None}, "shutter not stated"),
        ({"geometry": None}, "flat or dome not stated"),
        ({"projection": "fisheye"}, "a fisheye: the model's views are rectilinear"),
    ],
)
def test_row_without_a_vital_fact_says_which(missing, said):
    assert read(**missing)[1] == (said,)
    assert read()[1] == ()


def test_pieces_go_together_alone_and_cost_once():
    made, _ = read(price=9000.0, currency="USD", mass_g=2500.0, mass_water_g=1000.0)
    camera, lens, port = made.pieces
    assert {part.complete for part in made.pieces} == {"own"}
    assert [part.id for part in made.pieces] == ["own camera", "own lens", "own port"]
    assert (camera.price, lens.price, port.price.value) == (None, None, 9000.0)
    assert (port.mass_g.value, port.housing.displaced_g.value) == (2500.0, 1500.0)
    assert port.depth_rating_m == port.housing.depth_rating_m == 500.0


def test_what_is_carried_by_hand_has_card_timer_and_battery_of_its_family():
    compact, _ = read(family="compact", supply="battery")
    camera = compact.pieces[0]
    assert (compact.storage_gb, compact.run_time_min, compact.min_interval_s.value) == (128.0, 120.0, 2.0)
    assert (camera.host_price.value, camera.host_power_w.value, camera.tethered) == (0.0, 0.0, False)
    subsea = read()[0].pieces[0]
    assert (subsea.storage_gb, subsea.min_interval_s, subsea.host_price, subsea.tethered) == (None, None, None, True)


@pytest.mark.parametrize(("said", "fires"), [("yes", True), ("no", False), ("unknown", False)])
def test_only_a_signal_that_is_stated_fires_lamps(said, fires):
    assert read(lamp_trigger=said)[0].pieces[0].fires_lamps is fires


@pytest.mark.parametrize(
    ("word", "completes", "cameras"), [("none", 0, True), ("also", len(SEARCHED), True), ("only", len(SEARCHED), False)]
)
def test_mission_says_whether_they_are_searched(word, completes, cameras):
    made = select(read_catalog(), Choice(complete=word))
    assert (len(made.completes), bool(made.cameras)) == (completes, cameras)
    assert bool(made.lights)


def test_true_is_also_and_false_is_none():
    def asked(value):
        scene = {"depth_m": 10, "water": "II", "seafloor": 0.2}
        vehicle = {"altitude_m": 1, "speed_m_s": 0.3}
        plain = {"practice": "bare", "vehicle": vehicle, "scenes": [scene], "catalog": {"complete": value}}
        return load_mission(plain).catalog.complete

    assert [asked(word) for word in (True, False, "only")] == ["also", "none", "only"]
    with pytest.raises(MissionError, match="complete"):
        asked("some")


def test_battery_depth_and_patterns_leave_some_out():
    def left(**asked):
        wish = {"complete": "also", "complete_cameras": asked.pop("names", ())}
        return {one.id for one in select(read_catalog(), Choice(**wish), **asked).completes}

    assert left(required_depth_m=50.0) == {one.id for one in SEARCHED if one.depth_rating_m >= 50.0} != left()
    assert left(duration_h=1.9) and not left(duration_h=2.1)  # 120 min, of their family
    assert left(names=["nauticam"]) == {one.id for one in SEARCHED if "nauticam" in one.id}
    assert left(shutter="global") == {one.id for one in SEARCHED if one.own_camera.shutter == "global"} != left()


def test_at_least_ten_are_listed_and_what_is_missing_is_told():
    lines = [line for excluded in (False, True) for line in list_parts(read_catalog(), "complete", excluded=excluded)]
    assert len(lines) >= 10
    assert all("vital facts" in " ".join(line.reasons) for line in lines if not line.searchable)


def test_show_tells_the_facts_of_the_pieces_too():
    lines, _ = show_part(read_catalog(), "olympus-tg6-nauticam")
    by_name = {line.name: line.value for line in lines}
    assert {"focal_length_mm", "pixel_pitch_um", "geometry", "family"} <= set(by_name)
    assert by_name["id"] == "olympus-tg6-nauticam"


def test_quotes_and_changes_reach_the_pieces(tmp_path):
    quotes, log = tmp_path / "quotes.csv", tmp_path / "log.csv"
    quotes.write_text("id,price,currency\nsony-rx0,500,USD\n")
    log.write_text(log_text([CellChange("2026-11-22", "complete", "sony-rx0", "depth_rating_m", "10", "12", "a")]))
    port = read_catalog([log], quotes).part("sony-rx0 port", "port")
    assert (port.price.value, port.depth_rating_m) == (500.0, 12.0)

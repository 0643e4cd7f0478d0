"""Missions: what loads, what each fault says, and what solvers see."""

import copy
import itertools
import math
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from any_text import ANY_TEXT
from hypothesis import given, settings
from hypothesis import strategies as st
from thorough import drawn

from uwopt.errors import MissionError
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.sections.requirements import PIXEL_MTF
from uwopt.mission.sections.vehicle import grid
from uwopt.mission.templates import mission_json_schema, mission_template
from uwopt.model.sharpness import HALF_NYQUIST_CYC_PER_PX, sinc_mtf

EXAMPLE = Path(__file__).parents[1] / "reference" / "example_mission.yaml"
SMALL = {
    "practice": "bare", "scene": {"water": "II", "seafloor": "sand", "depth_m": 30},
    "vehicle": {"altitude_m": 2, "speed_m_s": 0.5},
}


def changed(path, value):
    """SMALL with one key set; `scene.depth_m`, `limits.cost`, ..."""
    data = copy.deepcopy(SMALL)
    *sections, key = path.split(".")
    node = data
    for section in sections:
        node = node.setdefault(section, {})
    node[key] = value
    return data


def without(path):
    data = copy.deepcopy(SMALL)
    *sections, key = path.split(".")
    node = data
    for section in sections:
        node = node[section]
    del node[key]
    return data


def message_of(source):
    with pytest.raises(MissionError) as caught:
        load_mission(source)
    text = str(caught.value)
    assert "pydantic" not in text
    assert "http" not in text
    assert "Traceback" not in text
    return text


def test_the_example_loads_as_it_stands():
    mission = load_mission(EXAMPLE)
    assert mission.scenes[0].water == "II"
    assert mission.vehicle.light_count == (1, 4)
    assert (mission.asked_depth_m, mission.required_depth_m) == (100, 100)  # a rating is taken as it stands
    assert mission.requirements.min_snr == pytest.approx(31.6227766)  # 10^(30/20), by table
    assert mission.base_dir == EXAMPLE.parent


def test_defaults_are_those_of_the_format():
    mission = load_mission(SMALL)
    full = mission.to_dict()
    assert (full["objective"], full["physics"], full["tolerance"], full["seed"]) == (
        "power",
        "auto",
        0.005,
        0,
    )
    scene = full["scenes"][0]
    defaults = {"temperature_c": 10, "salinity_psu": 35, "backscatter_ratio": 0.0183, "sun_lux": 0}
    assert {key: scene[key] for key in defaults} == defaults
    assert (scene["name"], scene["sun_elevation_deg"], scene["water_table"]) == ("scene 1", 60, None)
    vehicle = full["vehicle"]
    assert (vehicle["light_count"], vehicle["light_baseline_m"], vehicle["light_tilt_deg"]) == (
        [1, 8],
        0.5,
        0,
    )
    assert (vehicle["orientation"], vehicle["camera_count"], vehicle["altitude_tolerance_m"]) == ("any", 1, 0)
    wanted = full["requirements"]
    assert (wanted["dof_at"], wanted["snr_at"], wanted["highlight_ratio"]) == ("axis", "mean", 1.5)
    assert (wanted["circle_of_confusion_px"], wanted["shutter"], wanted["colour"]) == (2, "any", "any")
    limits = full["limits"]
    assert (limits["currency"], limits["cost_basis"], limits["max_exposure_ms"]) == ("USD", "high", 1000)
    assert full["catalog"]["generic"] == "fallback"
    assert mission.required_depth_m == 30


BAD = [
    (
        changed("vehicle.altitude_m", -2),
        "vehicle.altitude_m = -2 is not above 0; give the distance from the port",
    ),
    (changed("vehicle.altitude_m", 0), "altitude_m = 0 is not above 0"),
    (changed("vehicle.altitude_m", 2000), "is above 1000"),
    (changed("vehicle.altitude_m", "2 m"), "= '2 m' is not a number; the unit belongs in the key"),
    (changed("vehicle.altitude_m", "2,5"), "write a decimal point: 2.5"),
    (changed("limits.cost", "10,000"), "write 10000, or 10.000 if the comma is a decimal one"),
    (changed("limits.cost", "1,000,000"), "= '1,000,000' is not a number; write 1000000."),
    (changed("limits.000", None), "limits.000 is no key; numbers are written without commas, such as 10000 or 0.5"),
    (
        changed("requirements.overlap", "60%"),
        "overlap = '60%' is not a number; a share is written without sign: 0.6.",
    ),
    (changed("vehicle.altitude_m", True), "= true is not a number"),
    (changed("vehicle.altitude_m", [2]), "= [2] is not a number"),
    (changed("vehicle.altitude_m", math.nan), "is not a number (NaN)"),
    (changed("vehicle.altitude_m", math.inf), "is not finite"),
    (changed("vehicle.altitude_m", 10**400), "is not finite"),
    (changed("vehicle.altitude_m", None), "vehicle.altitude_m is missing; give the distance from the port"),
    (changed("vehicle.altitude_tolerance_m", 2), "altitude_tolerance_m = 2 is not below altitude_m = 2"),
    (changed("vehicle.speed_m_s", 60), "speed_m_s = 60 is above 50"),
    (
        changed("vehicle.speed_m_s", 0),
        "speed_m_s = 0 leaves the frame rate open; add requirements.frame_interval_s",
    ),
    (changed("vehicle.orientation", "potrait"), "did you mean 'portrait'?"),
    (changed("vehicle.orientation", False), "= false is not one of any, landscape, portrait"),
    (changed("vehicle.light_count", [4, 1]), "is not ordered; write [1, 4]"),
    (changed("vehicle.light_count", 65), "is outside 0 to 64"),
    (changed("vehicle.light_count", 0), "nothing would be seen; give the sun's lux, or begin at 1"),
    (changed("vehicle.light_count", 1.5), "is not a whole number"),
    (changed("vehicle.light_count", [1, 2, 3]), "write [lowest, highest]"),
    (changed("vehicle.camera_count", 0), "camera_count = 0 is below 1"),
    (changed("vehicle.light_baseline_m", [1, -1]), "is not ordered"),
    (changed("vehicle.light_baseline_m", -1), "is outside 0 to 20"),
    (changed("vehicle.light_tilt_deg", 120), "is outside -89 to 89"),
    (changed("vehicle.light_mounts", []), "is empty; list at least one place"),
    (
        changed("vehicle.light_mounts", [{"x": 1}]),
        "light_mounts[0].x is unknown; the key is x_m, with its unit",
    ),
    (changed("vehicle.altitude_mm", 2000), "the key is altitude_m: write altitude_m: 2."),
    (changed("vehicle.altitude_mm", 2e8), "write altitude_m: 200000."),
    (changed("vehicle.altitude", 2), "the key is altitude_m, with its unit: write altitude_m: 2"),
    (changed("vehicle.speed_kn", 1), "the key is speed_m_s: write speed_m_s: 0.514444"),
    (changed("vehicle.altitud_m", 2), "did you mean altitude_m?"),
    (changed("vehicle.max_blur_px", 1), "max_blur_px belongs under requirements"),
    (changed("altitude_m", 1), "altitude_m belongs under vehicle"),
    (changed("practice", "expert"), "give the practice that stands in for keys left out"),
    (changed("vehicle.lights", 2), "vehicle.lights is unknown; the key is light_count: write light_count: 2"),
    (changed("vehicle.cameras", ["basler"]), "vehicle.cameras belongs under catalog; move it there"),
    (changed("limits.physics", "full"), "physics belongs at the top level"),
    (changed("limits.max_gsd", 1), "the key is max_gsd_mm under requirements"),
    (changed("qwertz", 1), "qwertz is unknown; known here are catalog, confidence, doubt, fixed, limits"),
    (changed("requirement", {}), "did you mean requirements?"),
    (changed("requirements.min_mtf_half_nyquist", 0.901), "its pixels alone leave 0.900 at half the Nyquist frequency"),
    (changed("requirements.overlap", 60), "it is a share 0..1; did you mean 0.6 for 60?"),
    (changed("requirements.overlap", 100), "it is a share 0..1; did you mean 0.6 for 60 %?"),
    (changed("requirements.overlap", 1), "overlap = 1 is not below 1"),
    (changed("requirements.overlap", -0.1), "is below 0"),
    (changed("requirements.mean_level", 30), "did you mean 0.3 for 30?"),
    (changed("requirements.min_contrast", "60 %"), "a share is written without sign: 0.6"),
    (changed("requirements.highlight_ratio", 0.5), "highlight_ratio = 0.5 is below 1"),
    (changed("requirements", {"min_snr": 3, "min_snr_db": 3}), "min_snr and min_snr_db are both given"),
    (changed("requirements", {"min_snr_db": 20, "snr_at_less_db": 6}), "snr_at_less_db is less at pixels than in"),
    (changed("scene.snr_at_less_db", 6), "snr_at_less_db is less at pixels than in"),
    (changed("requirements.min_snr", 0), "requirements.min_snr = 0 is not above 0"),
    (changed("requirements", 3), "requirements = 3 is not a mapping"),
    (changed("scene.water", "XI"), "is not one of I, IA, IB, II, III, 1C, 3C, 5C, 7C, 9C"),
    (changed("scene.water", 3), "scene.water = 3 is a number, not a Jerlov type; write III or 3C"),
    (changed("scene.water_table", "mesured"), "did you mean 'measured'?"),
    (changed("scene.seafloor", "corall"), "did you mean 'coral'?"),
    (changed("scene.seafloor", 20), "is not a reflectance 0..1"),
    (changed("scene.seafloor", True), "scene.seafloor = true"),
    (changed("scene.depth_m", -30), "scene.depth_m = -30 is below 0"),
    (changed("scene.depth_m", 20_000), "is above 11000"),
    (changed("scene.sun_elevation_deg", 100), "sun_elevation_deg = 100 is above 90"),
    (changed("scene.light_count", 3), "cannot differ from scene to scene: the hardware is common to all"),
    (changed("scene.vehicle", {"orientation": "any"}), "the hardware is common to all"),
    (changed("scene.altitude_m", -3), "scene.altitude_m = -3 is not above 0"),
    (changed("scene.max_bluur_px", 3), "did you mean max_blur_px?"),
    (changed("scene.cost", 3), "cost belongs under limits"),
    (changed("scene.time_share", 0.5), "makes all shares sum to 0.5"),
    (changed("scene", 3), "scene = 3 is not a mapping"),
    (changed("scenes", [SMALL["scene"]]), "scene and scenes are both given; keep one of them"),
    (without("scene"), "scene is missing"),
    (without("scene.depth_m"), "scene.depth_m is missing; give the depth of the scene in metres"),
    (without("vehicle"), "vehicle is missing"),
    ({**without("scene"), "scenes": []}, "scenes = [] is too short"),
    ({**without("scene"), "scenes": 3}, "scenes = 3 is not a list"),
    (changed("limits.cost", "8000 USD"), "the unit belongs in the key"),
    (changed("limits.cost", -1), "limits.cost = -1 is below 0"),
    (changed("limits.currency", "dollar"), "write three letters such as USD"),
    (
        changed("limits.currency", "XYZ"),
        "has no exchange rate; known are AUD, CAD, CHF, EUR, GBP, JPY, NOK, USD",
    ),
    (changed("limits.rates", {"EUR": -1}), "limits.rates.EUR = -1 is not above 0"),
    (changed("limits.rates", 1.1), "limits.rates = 1.1 is not a mapping"),
    (
        changed("limits.depth_rating_m", 20),
        "depth_rating_m = 20 is less than the 28 m at which the camera works",
    ),
    (changed("limits.cost_basis", "low"), "is not one of central, high"),
    (changed("objective", "powr"), "did you mean 'power'?"),
    (changed("objective", 3), "is not one of power, cost"),
    (changed("objective", "sharpest"), "contrast, information, best_image"),
    (changed("objective", {"power": -1}), "has a negative weight for power"),
    (changed("objective", {"power": 0}), "has no weight above 0"),
    (changed("objective", {}), "has no weight above 0"),
    (changed("objective", {"powr": 1}), "did you mean 'power'?"),
    (changed("objective", {"power": math.nan}), "is not a number (NaN)"),
    (changed("physics", "ful"), "did you mean 'full'?"),
    (changed("tolerance", 0), "tolerance = 0 is not above 0"),
    (changed("seed", -1), "seed = -1 is below 0"),
    (changed("seed", 0.5), "is not a whole number"),
    (changed("name", {"a": 1}), "name = {...} is not text"),
    (changed("catalog.verified", ["prise"]), "did you mean price?"),
    (changed("catalog.generic", "always"), "is not one of fallback, allow, never"),
    (changed("catalog.owned", [{"quantity": 1}]), "catalog.owned[0].id is missing"),
    (changed("catalog.owned", [{"id": "x", "quantity": -1}]), "quantity = -1 is below 0"),
    (
        changed("catalog.extras", [{"name": "box", "cost": "x"}]),
        "catalog.extras[0].cost = 'x' is not a number",
    ),
    (changed("catalog.camera", ["x"]), "did you mean cameras?"),
    (changed("objective", {"cost": "x"}), "objective = {...} has a weight for cost that is not a number"),
]


@pytest.mark.parametrize(("source", "piece"), BAD, ids=[piece for _, piece in BAD])
def test_a_bad_mission_is_told_in_words(source, piece):
    assert piece in message_of(source)


@pytest.mark.parametrize("path", ["vehicle.5", "requirements.bogus", "reserve.bogus", "catalog.bogus"])
@pytest.mark.parametrize("practice", ["recommended", "bare"])
def test_an_unknown_key_without_a_value_is_told_whatever_practice_fills_in(path, practice):
    """Such as `{speed_m_s: 0,5}` makes of 5, with a speed of 0; a known one is left out."""
    assert f"{path} is " in message_of(changed(path, None) | {"practice": practice})
    known = changed("vehicle.lamp_supply", None) | {"practice": practice}
    left_out = load_mission(changed("vehicle.duration_h", None) | {"practice": practice})
    assert load_mission(known).vehicle.lamp_supply == left_out.vehicle.lamp_supply


def test_what_pixels_leave_by_themselves_is_the_transfer_of_a_pixel():
    assert pytest.approx(float(sinc_mtf(HALF_NYQUIST_CYC_PER_PX)), rel=1e-15) == PIXEL_MTF


def test_all_faults_are_told_at_once_with_file_and_line(tmp_path):
    path = tmp_path / "reef.yaml"
    path.write_text(
        "scene:\n  water: 3\n  seafloor: sand\n  depth_m: 30\n"
        "vehicle:\n  altitude_m: -2\n  speed_m_s: 0.5\n  speed_m_s: 1\n"
        "requirements: {min_snr: 1, min_snr_db: 1}\nlimit: {}\n"
    )
    lines = message_of(path).splitlines()
    starts = [line.removeprefix(str(path) + " ") for line in lines]
    assert [start.split(":")[0] for start in starts] == ["line 2", "line 6", "line 8", "line 9", "line 10"]
    assert "line 6: vehicle.altitude_m = -2 is not above 0; give the distance from the port" in starts[1]


def test_text_that_yaml_1_1_leaves_as_text_counts_as_a_number():
    assert load_mission(changed("tolerance", "1e-3")).tolerance == 0.001
    assert yaml.safe_load("1e-3") == "1e-3"  # the trap that this is about


@pytest.mark.parametrize(
    ("given_as", "water"), [("ii", "II"), ("1c", "1C"), ("Jerlov IB", "IB"), ("harbour.csv", "harbour.csv")]
)
def test_water_is_spelt_one_way(given_as, water):
    assert load_mission(changed("scene.water", given_as)).scenes[0].water == water


@pytest.mark.parametrize(
    ("given_as", "seafloor"),
    [
        ("Sand", "sand"),
        (0.2, 0.2),
        ("0.2", 0.2),
        ("benthic_average", "benthic-average"),
        ("mud.csv", "mud.csv"),
    ],
)
def test_seafloor_is_a_name_a_share_or_a_file(given_as, seafloor):
    assert load_mission(changed("scene.seafloor", given_as)).scenes[0].seafloor == seafloor


def two_scenes(**second):
    return {
        "practice": "bare", "scenes": [SMALL["scene"], {**SMALL["scene"], "water": "III", **second}],
        "vehicle": SMALL["vehicle"],
        "requirements": {"min_snr_db": 20, "max_blur_px": 1},
    }


@pytest.mark.parametrize(
    "override",
    [
        {"altitude_m": 3, "max_blur_px": 2},
        {"vehicle": {"altitude_m": 3}, "requirements": {"max_blur_px": 2}},
        {"altitude_m": 3, "requirements": {"max_blur_px": 2}},
    ],
)
def test_a_scene_overrides_directly_or_by_section(override):
    mission = load_mission(two_scenes(**override))
    first, second = mission.views
    assert (first.vehicle.altitude_m, first.requirements.max_blur_px) == (2, 1)
    assert (second.vehicle.altitude_m, second.requirements.max_blur_px) == (3, 2)
    assert second.vehicle.speed_m_s == 0.5
    assert second.scene.name == "scene 2"


def test_a_scene_may_ask_for_snr_the_other_way_or_not_at_all():
    assert load_mission(two_scenes(min_snr=7)).scene_view(1).requirements.min_snr == 7
    assert load_mission(two_scenes(min_snr_db=None)).scene_view(1).requirements.min_snr is None
    assert load_mission(two_scenes(snr_at=None)).scene_view(1).requirements.snr_at == "mean"


@pytest.mark.parametrize(
    ("second", "piece"),
    [
        ({"name": "scene 1"}, "scenes[1].name = 'scene 1' is the name of scenes[0] too"),
        ({"altitude_tolerance_m": 5}, "scenes[1].altitude_tolerance_m = 5 is not below altitude_m = 2"),
        ({"speed_m_s": 0}, "scenes[1].speed_m_s = 0 leaves the frame rate open"),
        ({"altitude_m": 3, "vehicle": {"altitude_m": 4}}, "is given twice in this scene"),
        ({"time_share": 1.2}, "scenes[1].time_share = 1.2 is above 1"),
        ({"depth_m": 300, "depth": 3}, "scenes[1].depth is unknown; the key is depth_m"),
    ],
)
def test_faults_between_scenes_are_told(second, piece):
    assert piece in message_of(two_scenes(**second))


def test_time_is_shared_among_scenes():
    assert load_mission(two_scenes()).time_shares == (0.5, 0.5)
    assert load_mission(two_scenes(time_share=0.8)).time_shares == pytest.approx((0.2, 0.8))


def test_the_circle_of_confusion_is_two_pixels_but_in_physics_paper():
    mission = load_mission(SMALL)
    assert mission.scene_view(0).requirements.circle_of_confusion_px == 2
    assert mission.with_changes(physics="paper").scene_view(0).requirements.circle_of_confusion_px is None
    own = load_mission(changed("requirements.circle_of_confusion_px", 3)).with_changes(physics="paper")
    assert own.scene_view(0).requirements.circle_of_confusion_px == 3


def test_changes_of_a_mission_are_checked():
    with pytest.raises(MissionError, match="did you mean 'paper'"):
        load_mission(SMALL).with_changes(physics="papr")


def test_mounts_fix_the_number_of_lights():
    mounts = [{"y_m": 0.5}, {"y_m": -0.5, "tilt_y_deg": 10}]
    vehicle = load_mission(changed("vehicle.light_mounts", mounts)).vehicle
    assert vehicle.light_count == (2, 2)
    assert vehicle.light_mounts[1].tilt_y_deg == 10
    assert vehicle.light_mounts[0].x_m == 0
    both = {**SMALL["vehicle"], "light_mounts": mounts, "light_count": 3}
    assert "reaches 3 but light_mounts has 2 place(s)" in message_of({**SMALL, "vehicle": both})


def test_ranges_of_mounts_become_the_declared_grid():
    vehicle = {**SMALL["vehicle"], "light_baseline_m": [0.3, 0.52], "light_tilt_deg": [-5, 5]}
    made = load_mission({**SMALL, "vehicle": vehicle}).vehicle
    assert made.light_baseline_range_m == (0.3, 0.52)
    assert made.light_baseline_grid_m == pytest.approx((0.3, 0.35, 0.4, 0.45, 0.5, 0.52))
    assert made.light_tilt_grid_deg == (-5, -2.5, 0, 2.5, 5)
    assert load_mission(SMALL).vehicle.light_baseline_grid_m == (0.5,)


@given(st.floats(0, 10), st.floats(0, 10))
def test_a_grid_rises_from_end_to_end_in_steps_of_at_most_one_step(a, b):
    low, high = sorted((a, b))
    points = grid(low, high, 0.05)
    assert points[0] == pytest.approx(low, abs=1e-9)  # points are rounded to 1e-9
    assert points[-1] == pytest.approx(high, abs=1e-9)
    gaps = [y - x for x, y in itertools.pairwise(points)]
    assert all(0 < gap < 0.05 + 2e-9 for gap in gaps)


def test_orientations_and_objectives_are_unfolded():
    mission = load_mission({**changed("objective", {"power": 1, "cost": "1e-2"})})
    assert mission.vehicle.orientations == ("landscape", "portrait")
    assert mission.objective == {"power": 1.0, "cost": 0.01}
    assert load_mission(changed("vehicle.orientation", "Portrait")).vehicle.orientations == ("portrait",)


def test_a_currency_of_its_own_rate_is_accepted():
    limits = load_mission(changed("limits", {"currency": "nzd", "rates": {"nzd": 0.57}})).limits
    assert (limits.currency, limits.rates) == ("NZD", {"NZD": 0.57})
    assert load_mission(changed("limits.currency", "EUR")).limits.currency == "EUR"


def test_paths_start_at_the_mission_file(tmp_path):
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(changed("scene.water", "data/harbour.csv")))
    mission = load_mission(tmp_path / "m.yaml")
    assert mission.resolve_path("a/b.csv") == tmp_path / "a" / "b.csv"
    assert mission.resolve_path("/x/b.csv") == Path("/x/b.csv")
    assert mission.to_dict()["scenes"][0]["water"] == "data/harbour.csv"
    assert mission.to_dict(absolute_paths=True)["scenes"][0]["water"] == str(tmp_path / "data/harbour.csv")
    assert mission.with_changes(seed=3).base_dir == tmp_path


def test_missions_do_not_change():
    mission = load_mission(SMALL)
    with pytest.raises(Exception, match="frozen"):
        mission.seed = 3
    assert load_mission(mission) is mission


def test_the_template_covers_every_key_and_loads():
    text = mission_template()
    load_mission(yaml.safe_load(text))
    assert max(map(len, text.splitlines())) < 120
    data = load_mission(SMALL).to_dict()
    keys = {
        *data,
        *data["scenes"][0],
        *data["vehicle"],
        *data["requirements"],
        *data["reserve"],
        *data["limits"],
        *data["catalog"],
    }
    lacking = {key for key in keys if f"{key}" not in text}
    assert lacking == set()


def test_the_template_with_its_commented_keys_loads_too():
    lines = [
        line.replace("# ", "", 1) if line.startswith("  # ") else line
        for line in mission_template().splitlines()
    ]
    wanted = [line for line in lines if "light_baseline" not in line and "light_count" not in line]
    mission = load_mission(yaml.safe_load("\n".join(wanted)))
    assert mission.limits.rates == {"EUR": 1.15}
    assert mission.catalog.owned[0].quantity == 1


def test_the_json_schema_documents_every_key():
    schema = mission_json_schema()
    assert "scene" in schema["properties"]
    assert "max_blur_px" in schema["$defs"]["Scene"]["properties"]
    assert "light_count" not in schema["$defs"]["Scene"]["properties"]
    for name, definition in schema["$defs"].items():
        for key, value in definition["properties"].items():
            assert "description" in value or "$ref" in value, (name, key)


def test_loading_needs_no_numpy():
    code = (
        "import sys; from uwopt.mission.mission import load_mission; from uwopt.mission.system import load_system;"
        f"load_mission({str(EXAMPLE)!r}); load_system({str(EXAMPLE.with_name('example_system.yaml'))!r});"
        "print([m for m in ('numpy', 'pandas', 'scipy') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


positive = st.floats(1e-3, 100)
share = st.floats(0, 0.99)
requirements = st.fixed_dictionaries(
    {"overlap": share},
    optional={
        "max_blur_px": positive,
        "min_dof_m": positive,
        "min_snr_db": st.floats(-40, 100),
        "max_gsd_mm": positive,
        "mean_level": st.floats(0.01, 0.9),
        "shutter": st.sampled_from(["any", "global", "rolling"]),
        "min_contrast": share,
        "circle_of_confusion_px": positive,
    },
)
scene = st.fixed_dictionaries(
    {
        "water": st.sampled_from(["I", "IB", "1C", "9C", "own.csv"]),
        "seafloor": st.one_of(share, st.sampled_from(["sand", "hard", "floor.csv"])),
        "depth_m": st.floats(0, 6000),
    },
    optional={
        "speed_m_s": st.floats(0, 5),
        "min_snr": positive,
        "requirements": st.fixed_dictionaries({}, optional={"overlap": share, "snr_at": st.just("worst_px")}),
        "sun_lux": st.floats(0, 1e5),
    },
)
vehicle = st.fixed_dictionaries(
    {"altitude_m": st.floats(0.5, 100), "speed_m_s": st.floats(0, 5)},
    optional={
        "altitude_tolerance_m": st.floats(0, 0.4),
        "light_count": st.one_of(
            st.integers(1, 64), st.tuples(st.integers(1, 8), st.integers(8, 64)).map(list)
        ),
        "light_baseline_m": st.one_of(st.floats(0, 5), st.tuples(st.floats(0, 2), st.floats(2, 5)).map(list)),
        "light_tilt_deg": st.floats(-80, 80),
    },
)
missions = st.fixed_dictionaries(
    {"scenes": st.lists(scene, min_size=1, max_size=3), "vehicle": vehicle, "requirements": requirements},
    optional={
        "objective": st.one_of(
            st.just("cost"), st.fixed_dictionaries({"power": positive, "snr_db": positive})
        ),
        "physics": st.sampled_from(["auto", "full", "paper"]),
        "limits": st.fixed_dictionaries(
            {}, optional={"cost": positive, "currency": st.sampled_from(["EUR", "usd"])}
        ),
    },
)


@settings(max_examples=drawn(40, 400))
@given(missions)
def test_a_mission_survives_the_way_through_a_dict(data):
    mission = load_mission(data)
    full = mission.to_dict()
    again = load_mission(full)
    assert again.to_dict() == full
    assert again.views == mission.views
    assert load_mission(yaml.safe_load(yaml.safe_dump(full))).to_dict() == full


values = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.floats(),
        st.text(ANY_TEXT, max_size=8),
        st.sampled_from(["II", "sand", "1e-3"]),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3), st.dictionaries(st.text(ANY_TEXT, max_size=6), inner, max_size=3)
    ),
    max_leaves=6,
)
sections = ["", "scene", "scenes", "vehicle", "requirements", "limits", "catalog"]


@st.deferred  # a schema is dear, and only the worker that draws keys needs it
def keys():
    schema = mission_json_schema()
    models = (*schema["$defs"].values(), schema)
    return st.sampled_from(sorted({key for model in models for key in model["properties"]}))


@settings(max_examples=drawn(100, 1000))
@given(st.lists(st.tuples(st.sampled_from(sections), keys, values), max_size=5), values)
def test_any_structure_is_a_mission_or_a_mission_error(changes, whole):
    data = copy.deepcopy(SMALL)
    for section, key, value in changes:
        node = data.setdefault(section, {}) if section else data
        if isinstance(node, dict):
            node[key] = value
    for source in (data, whole):
        if isinstance(source, str) and source in (".", ".."):
            continue
        try:
            assert isinstance(load_mission(source), Mission)
        except MissionError as fault:
            assert str(fault)

"""Systems: inline and catalogue parts, settings, and what each fault says."""

import copy
import math
from pathlib import Path

import pytest
import yaml
from any_text import ANY_TEXT
from hypothesis import given, settings
from hypothesis import strategies as st
from thorough import drawn

from uwopt.catalog.inline import part_from_inline
from uwopt.errors import CatalogError, MissionError
from uwopt.mission.mission import load_mission
from uwopt.mission.system import System, load_system
from uwopt.mission.templates import system_json_schema, system_template

EXAMPLE = Path(__file__).parents[1] / "reference" / "example_system.yaml"
CAMERA = {
    "resolution_x_px": 2448, "resolution_y_px": 2048, "pixel_pitch_um": 3.45, "read_noise_e": 2.4,
    "quantum_efficiency": 0.6,
}  # fmt: skip
SMALL = {"camera": "some-camera", "lens": "some-lens", "port": "some-port", "light": "some-light"}
LIGHT = {"flux_lm": 1500, "beam_half_angle_deg": 40}


def message_of(source):
    with pytest.raises(MissionError) as caught:
        load_system(source)
    text = str(caught.value)
    assert "pydantic" not in text
    assert "<" not in text
    return text


def test_the_example_loads_as_it_stands():
    system = load_system(EXAMPLE)
    assert system.camera == "seed-imx250m"
    assert system.orientation == "portrait"
    assert system.settings.flux_lm == 20000
    assert system.settings.focus_distance_m is None
    lens = part_from_inline("lens", system.part("lens"))
    assert (lens.focal_length_mm, lens.transmission_frac.value, lens.inline) == (8, 0.9, True)
    port = part_from_inline("port", system.part("port"))
    assert (port.geometry, port.outer_radius_mm.value, port.thickness_mm.value) == ("dome", 100, 10)
    light = part_from_inline("light", system.part("light"))
    assert (light.flux_lm.value, light.output_factor.value, light.flux_lm.status) == (20000, 1.0, "user")
    # half-angle 45 degrees in water is a full angle of 90 degrees there
    assert (light.beam, light.beam_angle_deg.value, light.beam_medium) == ("disc", 90, "water")


def test_a_system_survives_the_way_through_a_dict():
    for source in (EXAMPLE, SMALL, yaml.safe_load(system_template())):
        full = load_system(source).to_dict()
        assert load_system(full).to_dict() == full


BAD = [
    (
        {**SMALL, "camera": None},
        "camera is missing; give the camera: an id of the catalogue, or an inline record",
    ),
    ({**SMALL, "camera": 3}, "camera = 3 is neither an id nor an inline record"),
    ({**SMALL, "camera": {**CAMERA, "quantum_efficiency": 60}}, "is not an efficiency above 0 and up to 1"),
    ({**SMALL, "camera": {**CAMERA, "qe": 0.5}}, "holds both qe and quantum_efficiency"),
    ({**SMALL, "camera": {**CAMERA, "read_noise_e": None}}, "camera.read_noise_e is missing"),
    (
        {**SMALL, "camera": {**CAMERA, "pixel_pitch_mm": 3}},
        "the key is pixel_pitch_um: write pixel_pitch_um: 3000",
    ),
    ({**SMALL, "lens": {"focal_length_m": 0.008}}, "the key is focal_length_mm: write focal_length_mm: 8"),
    ({**SMALL, "lens": {"focal_length_mm": 8, "transmission": 90}}, "lens.transmission = 90 is above 1"),
    ({**SMALL, "lens": {"focal_length_mm": 8, "f_number_min": 8, "f_number_max": 4}}, "swap them"),
    ({**SMALL, "port": {"geometry": "dom"}}, "did you mean 'dome'?"),
    (
        {**SMALL, "port": {"geometry": "dome"}},
        "port.outer_radius_mm is missing; a dome needs its outer radius",
    ),
    (
        {**SMALL, "port": {"geometry": "dome", "outer_radius_mm": 50, "thickness_mm": 60}},
        "thickness_mm = 60 is not below outer_radius_mm = 50",
    ),
    ({**SMALL, "light": {"flux_lm": 1500}}, "light.beam_half_angle_deg is missing"),
    ({**SMALL, "light": {"beam_half_angle_deg": 40}}, "light.flux_lm is missing"),
    ({**SMALL, "light": {**LIGHT, "kind": "flash"}}, "light.flash_energy_j is missing"),
    ({**SMALL, "light": {**LIGHT, "beam_angle_deg": 80}}, "and beam_angle_deg are both given"),
    ({**SMALL, "light": {**LIGHT, "beam_half_angle_deg": 95}}, "is not below 90"),
    ({**SMALL, "orientation": "any"}, "orientation = 'any' is not one of landscape, portrait"),
    ({**SMALL, "light_count": -1}, "light_count = -1 is below 0"),
    ({**SMALL, "light_count": 2, "light_mounts": [{}]}, "light_count = 2 but light_mounts has 1 place(s)"),
    ({**SMALL, "f_number": 4}, "f_number belongs under settings"),
    ({**SMALL, "setings": {}}, "did you mean settings?"),
    ({**SMALL, "settings": {"exposure_us": 300}}, "the key is exposure_ms: write exposure_ms: 0.3"),
    ({**SMALL, "settings": {"exposure_ms": "3 ms"}}, "the unit belongs in the key"),
    ({**SMALL, "settings": {"gain": 0.5}}, "settings.gain = 0.5 is below 1"),
    # 20 lg 1.995 = 6.0
    ({**SMALL, "settings": {"gain_db": 6}}, "settings.gain_db is unknown; the key is gain, a ratio: write gain: 1.995"),
    ({**SMALL, "settings": {"f_number": math.nan}}, "is not a number (NaN)"),
    ({**SMALL, "settings": {"flux_lm": 1, "dim_frac": 0.5}}, "dim_frac and flux_lm both set the light level"),
    ({**SMALL, "scenes": {"reef": {"gain": 0}}}, "scenes.reef.gain = 0 is below 1"),
    ({**SMALL, "scenes": {"reef": 3}}, "scenes.reef = 3 is not a mapping"),
]


@pytest.mark.parametrize(("source", "piece"), BAD, ids=[piece for _, piece in BAD])
def test_a_bad_system_is_told_in_words(source, piece):
    assert piece in message_of(source)


def test_faults_name_file_and_line_of_what_was_written(tmp_path):
    path = tmp_path / "rig.yaml"
    path.write_text("camera: a\nlens: {focal_length_mm: 8,\n  transmission: 90}\nport: b\nlight: c\n")
    assert message_of(path).startswith(f"{path} line 3: lens.transmission = 90 is above 1")


def test_settings_of_a_scene_stand_on_those_of_all():
    data = {
        **SMALL,
        "settings": {"f_number": 4, "flux_lm": 100},
        "scenes": {"deep": {"dim_frac": 0.5, "gain": 2}},
    }
    system = load_system(data)
    deep, other = system.settings_for("deep"), system.settings_for("reef")
    assert (deep.f_number, deep.flux_lm, deep.dim_frac, deep.gain) == (4, None, 0.5, 2)
    assert (other.f_number, other.flux_lm, other.dim_frac, other.gain) == (4, 100, None, None)


def test_settings_for_a_scene_that_is_not_there_are_told():
    scene = {"name": "reef", "water": "II", "seafloor": "sand", "depth_m": 3}
    mission = load_mission({"practice": "bare", "scene": scene, "vehicle": {"altitude_m": 2, "speed_m_s": 1}})
    load_system({**SMALL, "scenes": {"reef": {}}}).check_scenes(mission)
    with pytest.raises(MissionError, match="did you mean 'reef'"):
        load_system({**SMALL, "scenes": {"ref": {}}}).check_scenes(mission)


def test_mounts_fix_the_number_of_lights():
    assert load_system({**SMALL, "light_mounts": [{"y_m": 1}, {"y_m": -1}]}).light_count == 2


def test_an_inline_camera_has_the_documented_defaults():
    camera = part_from_inline("camera", {**CAMERA, "gain_dn_per_e": 5.556, "gain_bits": 16})
    assert camera.id == "inline-camera"
    assert (camera.bit_depth, camera.shutter, camera.colour, camera.gain_bits) == (12, "global", "mono", 16)
    assert camera.qe_curves["mono"].y == (0.6, 0.6)
    assert camera.saturation_e is None
    assert camera.mounts == ()
    colour = part_from_inline("camera", {**CAMERA, "colour": "color"})
    assert set(colour.qe_curves) == {"red", "green", "blue"}


def test_an_inline_camera_reads_its_efficiency_from_a_table_or_a_file(tmp_path):
    built_in = part_from_inline("camera", {**CAMERA, "quantum_efficiency": "imx250M"})
    assert built_in.qe_curve_id == "seed-imx250m"
    assert max(built_in.qe_curves["mono"].y) > 0.5
    (tmp_path / "qe.csv").write_text("wavelength_nm,qe\n380,0.3\n550,0.7\n780,0.2\n")
    own = part_from_inline("camera", {**CAMERA, "quantum_efficiency": "qe.csv"}, tmp_path)
    assert own.qe_curves["mono"].y == (0.3, 0.7, 0.2)
    with pytest.raises(CatalogError, match="is no curve"):
        part_from_inline("camera", {**CAMERA, "quantum_efficiency": "imx9999"})


def test_an_inline_light_reads_spectrum_and_profile_from_files(tmp_path):
    (tmp_path / "s.csv").write_text("wavelength_nm,relative_power\n380,0\n550,1\n780,0\n")
    (tmp_path / "b.csv").write_text("angle_deg,intensity\n0,1\n30,0.5\n60,0\n")
    mapping = {"flux_lm": 1000, "spectrum": "s.csv", "beam_profile": "b.csv"}
    light = part_from_inline("light", mapping, tmp_path)
    assert light.spectrum.x == (380, 550, 780)
    assert (light.beam, light.beam_profile.y) == ("tabulated", (1, 0.5, 0))


def test_a_flash_is_told_by_its_energy():
    flash = part_from_inline("light", {"flash_energy_j": 100, "beam_angle_deg": 100, "beam_medium": "water"})
    assert (flash.kind, flash.spectrum_id, flash.beam_medium) == ("flash", "xenon-flash", "water")


def test_an_inline_lens_of_small_opening_closes_no_further_than_that():
    lens = part_from_inline("lens", {"focal_length_mm": 8, "f_number_min": 22})
    assert lens.f_number_min.value <= lens.f_number_max.value


def test_a_bad_inline_record_from_python_is_a_catalog_error():
    with pytest.raises(CatalogError, match="inline lens: focal_length_mm"):
        part_from_inline("lens", {})
    with pytest.raises(CatalogError, match="outer_radius_mm is missing"):
        part_from_inline("port", {"geometry": "dome"})


def test_the_templates_part_records_can_be_built():
    system = load_system(yaml.safe_load(system_template()))
    for kind in ("camera", "lens", "port", "light"):
        assert part_from_inline(kind, system.part(kind)).inline


def test_the_json_schema_documents_every_key():
    for name, definition in system_json_schema()["$defs"].items():
        for key, value in definition["properties"].items():
            assert "description" in value, (name, key)


values = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(ANY_TEXT, max_size=8), st.just("dome")),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3), st.dictionaries(st.text(ANY_TEXT, max_size=6), inner, max_size=3)
    ),
    max_leaves=6,
)


@st.deferred  # a schema is dear, and only the worker that draws keys needs it
def keys():
    schema = system_json_schema()
    models = (*schema["$defs"].values(), schema)
    return st.sampled_from(sorted({key for model in models for key in model["properties"]}))


FULL = {**yaml.safe_load(system_template()), "scenes": {"a": {}}}


@settings(max_examples=drawn(100, 300), deadline=None)
@given(st.lists(st.tuples(st.sampled_from(["", *FULL]), keys, values), max_size=5))
def test_any_structure_is_a_system_or_a_mission_error(changes):
    data = copy.deepcopy(FULL)
    for section, key, value in changes:
        node = data.get(section) if section else data
        if isinstance(node, dict):
            node[key] = value
    try:
        assert isinstance(load_system(data), System)
    except MissionError as fault:
        assert str(fault)

"""YAML with lines, its traps, and sources that cannot be read."""

import contextlib
import os
import time

import pytest
from any_text import ANY_TEXT
from hypothesis import given, settings
from hypothesis import strategies as st
from thorough import drawn

import uwopt
from uwopt.documents.faults import nearest, path_text, show
from uwopt.documents.reading import MAX_BYTES, read_document
from uwopt.documents.yaml_lines import MAX_NODES, compose, resolve_scalar
from uwopt.errors import MissionError


def read(tmp_path, text, name="reef.yaml"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_document(path)


def message_of(source):
    with pytest.raises(MissionError) as caught:
        read_document(source)
    return str(caught.value)


def test_every_key_remembers_its_line(tmp_path):
    document = read(tmp_path, "a: 1\nb:\n  c: 2\n  d:\n    - 5\n    - e: 6\n")
    assert document.where(("b", "c")).endswith("reef.yaml line 3")
    assert document.where(("b", "d", 1, "e")).endswith("line 6")
    assert document.where(("b", "nothing")).endswith("line 2")  # the nearest thing around it
    assert document.base_dir == tmp_path


# YAML 1.2 core schema, section 10.3.2: what plain scalars mean there.
@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("no", "no"),
        ("on", "on"),
        ("1e3", 1000.0),
        ("1e-3", 0.001),
        ("1:30", "1:30"),
        ("010", 10),
        ("1_000", "1_000"),
        ("true", True),
        ("~", None),
        ("", None),
        ("-.inf", float("-inf")),
        (".5", 0.5),
        ("2026-11-20", "2026-11-20"),
        ("0x1F", 31),
        ("9" * 5000, "9" * 5000),  # Python refuses to convert so many digits
    ],
)
def test_plain_scalars_follow_yaml_1_2(text, value):
    assert resolve_scalar(text) == value
    assert type(resolve_scalar(text)) is type(value)


def test_quoted_text_stays_text(tmp_path):
    assert read(tmp_path, "a: '3'\nb: \"no\"\n").data == {"a": "3", "b": "no"}


def test_anchors_and_merge_keys_work(tmp_path):
    document = read(tmp_path, "base: &b {x: 1, y: 2}\nother: {<<: *b, y: 3}\nagain: *b\n")
    assert document.data["other"] == {"x": 1, "y": 3}
    assert document.data["again"] == {"x": 1, "y": 2}


@pytest.mark.parametrize(
    ("text", "piece"),
    [
        ("a: 1\nb: 2\na: 3\n", "line 3: a stands twice (also in line 1); remove one."),
        ("v:\n  a: 1\n  a: 1\n", "line 3: v.a stands twice"),
        ("a: 1\n---\nb: 2\n", "a second document starts here"),
        ("a: *nothing\n", "alias *nothing refers to nothing before it"),
        ("? [1, 2]\n: 3\n", "a key is not plain text"),
        ("a: !!python/object:os.system x\n", "is not allowed; write the plain value"),
    ],
)
def test_faults_of_form_are_collected_with_their_line(tmp_path, text, piece):
    assert piece in "\n".join(read(tmp_path, text).faults)


@pytest.mark.parametrize(
    ("text", "piece"),
    [
        ("", "is empty; `uwopt init` writes a mission"),
        ("  \n\n", "is empty"),
        ("# only a comment\n", "is empty but for comments"),
        ("{uwopt_version: 1, recommendation: {}}", "is a result of uwopt, no mission; name the mission file."),
        ("- 1\n- 2\n", "is not a mapping of keys to values"),
        ("just text\n", "is not a mapping of keys to values"),
        ("a: [1, 2\nb: 3\n", "line 2 column 2: is not valid YAML"),
        ("a: 1\n\tb: 2\n", "indent with spaces, not tabs"),
        ("a: b: c\n", "line 1 column 5: is not valid YAML: mapping values are not allowed here"),
        ("a: 'open\n", "is not valid YAML"),
        ("a: \x07\n", "control characters"),
        (b"name: caf\xe9\n", "line 1: is not UTF-8 text (byte 9)"),
        ("a: 1\n".encode("utf-16"), "is not UTF-8 text"),
    ],
)
def test_a_file_that_is_no_mapping_is_refused_in_words(tmp_path, text, piece):
    with pytest.raises(MissionError, match=r"reef\.yaml") as caught:
        read(tmp_path, text)
    assert piece in str(caught.value)


def test_a_bill_in_place_of_a_mission_is_told_as_a_table(tmp_path):
    (tmp_path / "bom.csv").write_text("kind,id\ncamera,a: b: c\n", "utf-8")
    with pytest.raises(MissionError, match=r"bom.csv: is a table, no mission; name a YAML file"):
        read_document(tmp_path / "bom.csv", "mission")


def test_a_mission_in_place_of_a_system_is_told_in_one_sentence(tmp_path):
    (tmp_path / "reef.yaml").write_text("vehicle: {}\nrequirements: {}\n", "utf-8")
    with pytest.raises(MissionError, match="is a mission, no system; `uwopt init --system`") as caught:
        read_document(tmp_path / "reef.yaml", "system")
    assert len(caught.value.faults) == 1


def test_a_system_in_place_of_a_mission_is_told_in_one_sentence(tmp_path):
    (tmp_path / "reef.yaml").write_text("camera: a\nlens: b\nlight_count: 2\n", "utf-8")
    with pytest.raises(MissionError, match="is a system, no mission; name the mission file") as caught:
        uwopt.load_mission(tmp_path / "reef.yaml")
    assert len(caught.value.faults) == 1


def test_a_byte_order_mark_is_dropped(tmp_path):
    assert read(tmp_path, b"\xef\xbb\xbfa: 1\n").data == {"a": 1}


def test_a_missing_file_names_the_one_that_is_there(tmp_path):
    (tmp_path / "reef.yaml").write_text("a: 1\n")
    assert "no such file; did you mean reef.yaml?" in message_of(tmp_path / "reeef.yml")
    assert "`uwopt init`" in message_of(tmp_path / "x" / "y.yaml")
    assert "did you mean" not in message_of(tmp_path / "kelp.yaml")  # alike but in how it ends


def test_a_folder_is_refused(tmp_path):
    assert "is a folder; name the mission file in it" in message_of(str(tmp_path))


def test_a_pipe_is_refused_without_waiting_for_it(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert "is not a regular file" in message_of(tmp_path / "pipe")


def test_a_huge_file_is_refused_unread(tmp_path):
    path = tmp_path / "huge.yaml"
    with path.open("wb") as file:
        file.truncate(MAX_BYTES + 1)
    assert "MB, more than 10" in message_of(path)


@pytest.mark.parametrize(
    ("source", "piece"),
    [
        (3, "is neither a file name nor a mapping"),
        (None, "is neither a file name nor a mapping"),
        ([], "is neither a file name nor a mapping"),
        (b"name", "is neither a file name nor a mapping"),
        ("name: x\nscene:\n", "is YAML text, not the name of a file"),
        ("a" * 5000, "cannot be read"),
        ("nul\0byte", "nul\\x00byte: no such file"),
        ("~nobody_of_that_name/reef.yaml", "cannot be read"),
    ],
)
def test_other_sources_are_refused_in_words(source, piece):
    assert piece in message_of(source)


def test_a_bomb_of_aliases_is_refused_at_once(tmp_path):
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 20)]
    started = time.perf_counter()
    with pytest.raises(MissionError, match=f"more than {MAX_NODES} values"):
        read(tmp_path, "\n".join(lines))
    assert time.perf_counter() - started < 20  # it would take ages, not seconds; wide for a busy machine


@pytest.mark.parametrize("text", ["[" * 100_000, "a: " + "{b: " * 5000, "- " * 2000])
def test_deep_nesting_is_refused(tmp_path, text):
    with pytest.raises(MissionError, match=r"nested more than|not valid YAML"):
        read(tmp_path, text)


def test_a_mapping_that_holds_itself_is_refused():
    loop = {}
    loop["loop"] = loop
    assert "nested more than" in message_of(loop)


def test_a_mapping_of_python_is_copied_to_plain_values(tmp_path):
    import numpy as np

    data = {"a": np.float64(2.5), "b": np.array([1, 2]), "c": tmp_path, 4: (1, 2)}
    assert read_document(data).data == {"a": 2.5, "b": [1, 2], "c": str(tmp_path), "4": [1, 2]}


@settings(max_examples=drawn(100, 1000))
@given(st.text(ANY_TEXT, max_size=80))
def test_any_text_gives_values_or_a_fault(text):
    with contextlib.suppress(MissionError):
        compose(text, "fuzz.yaml")


@settings(max_examples=drawn(100, 1000))
@given(st.text(alphabet="ab:-[]{}&*<!?|>#'\" \n\t1.,", max_size=60))
def test_any_yaml_like_text_gives_values_or_a_fault(text):
    with contextlib.suppress(MissionError):
        compose(text, "fuzz.yaml")


def test_paths_and_values_read_as_a_person_writes_them():
    assert path_text(("scenes", 1, "vehicle", "speed_m_s")) == "scenes[1].vehicle.speed_m_s"
    assert path_text(("a", "odd\nkey")) == "a.'odd\\nkey'"
    assert show("x" * 100).endswith("...")
    assert (show(None), show(True), show([1, "a"])) == ("null", "true", "[1, 'a']")


def test_nearest_words():
    assert nearest("altitud_m", ["altitude_m", "speed_m_s"]) == "altitude_m"
    assert nearest("pitch", ["pitch_rate_deg_s", "roll_rate_deg_s"]) == "pitch_rate_deg_s"
    assert nearest("cost_usd", ["cost_basis", "cost"]) == "cost"
    assert nearest("cost_basi", ["cost_basis", "cost"]) == "cost_basis"
    assert nearest("zzz", ["altitude_m"]) is None

"""The page without a browser: what controls say and do, files and addresses, who may ask, work in the background."""

from __future__ import annotations

import base64
import json
import math
import signal
import threading
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from thorough import drawn
from turned_controls import FULL, other, turned

import uwopt
from uwopt.cli.app import app
from uwopt.errors import MissionError, OutputError, UwoptError
from uwopt.explore import jobs, serve, showing, state
from uwopt.explore.controls import BY_ID, CONTROLS, Control
from uwopt.explore.dash_door import PreventUpdate
from uwopt.explore.outcome import SHOWN, KeptResults, shown_figures, shown_margins
from uwopt.explore.server import IDS, Explorer, with_upload

PROBLEMS = Path(__file__).parents[2] / "problems"
#: The window of the founding paper's tool as it opens (docs/paper.md), in the digits that the page shows.
WINDOW = {
    "fov_x_m": "2.111 m", "fov_y_m": "1.766 m", "exposure_max_ms": "0.8625 ms", "dof_near_m": "1.253 m",
    "dof_far_m": "4.974 m", "virtual_image_distance_m": "0.2116 m", "frame_rate_min_hz": "0.6315 Hz", "snr": "9.162",
}  # fmt: skip
WATER = "wavelength_nm,attenuation_per_m\n400,0.3\n500,0.2\n600,0.4\n700,0.8\n"


@pytest.fixture(scope="module")
def outcomes() -> Iterator[KeptResults]:
    """Results as a server keeps them."""
    made = KeptResults()
    yield made
    made.close()


@pytest.fixture(scope="module")
def explorer() -> Iterator[Explorer]:
    """A page's server that listens at no address."""
    made = Explorer(state.OPENING, serve.HERE, serve.OWN_NAMES)
    yield made
    made.close()


# ---------------------------------------------------------------- controls and figures


def test_page_opens_as_the_papers_window(outcomes: KeptResults) -> None:
    seen = shown_figures(outcomes.result(state.OPENING, 0))
    assert {name: seen[name] for name in WINDOW} == WINDOW


def test_angles_are_those_of_the_footprint(outcomes: KeptResults) -> None:
    seen = shown_figures(outcomes.result(state.OPENING, 0))
    # by hand: 2 atan(2.1114 / 4) = 55.65 degrees, 2 atan(1.7664 / 4) = 47.65 degrees
    assert (seen["fov_x_deg"], seen["fov_y_deg"]) == ("55.65°", "47.65°")


def test_opening_is_the_published_problem(outcomes: KeptResults) -> None:
    files = [PROBLEMS / f"paper-tool-window{end}.yaml" for end in ("", ".system")]
    published = uwopt.evaluate(*files).design
    own = outcomes.result(state.OPENING, 0).design
    assert published is not None and own is not None
    assert own.scenes[0].figures == published.scenes[0].figures


def test_figures_are_those_of_evaluate_to_all_digits_shown(outcomes: KeptResults) -> None:
    opened = serve.opening_state(*(str(PROBLEMS / f"mbari-lass-2013{end}.yaml") for end in ("", ".system")))
    by_page = shown_figures(outcomes.result(opened, 0))
    design = uwopt.evaluate(*(PROBLEMS / f"mbari-lass-2013{end}.yaml" for end in ("", ".system"))).design
    assert design is not None
    figures = design.scenes[0].figures
    for name in SHOWN:
        value = figures.get(name)
        if isinstance(value, float) and name != "cost":
            number = by_page[name].rstrip("°").split(" ")[0].replace(" ", "")
            if value < 1000 and not by_page[name].startswith("once"):
                assert float(number) == pytest.approx(value, rel=6e-4, abs=0), name
                assert value == 0 or len(number.replace(".", "").lstrip("0")) >= 4


PLAIN = turned(FULL, **{"m-physics": "paper"})  # a quarter of the time; most controls move something there


@pytest.fixture(scope="module")
def untouched(outcomes: KeptResults) -> list[str]:
    return [everything(outcomes, of) for of in (PLAIN, FULL)]


def everything(outcomes: KeptResults, of: state.State) -> str:
    """All that the page says of a state, as text."""
    found = showing.results(outcomes, of)
    return str([showing.figure_table(of, found), showing.margin_table(of, found), showing.fault_list(of, found)])


@pytest.mark.parametrize("control", CONTROLS, ids=lambda one: one.id)
def test_every_control_moves_something(control: Control, outcomes: KeptResults, untouched: list[str]) -> None:
    said = other(control, state.text_of(FULL, control))
    both = [state.with_texts(of, {control.id: said}) for of in (PLAIN, FULL)]
    assert both[1] != FULL
    assert all(state.text_of(moved, control) == said for moved in both)
    assert any(everything(outcomes, moved) != before for moved, before in zip(both, untouched, strict=True))


def test_every_control_says_what_its_file_says() -> None:
    assert all(len(one.meaning) > 10 for one in CONTROLS)
    assert len(BY_ID) == len(CONTROLS)


def test_controls_that_say_what_they_said_change_nothing() -> None:
    opened = serve.opening_state(*(str(PROBLEMS / f"whoi-abe{end}.yaml") for end in ("", ".system")))
    again = state.with_texts(opened, {one.id: state.text_of(opened, one) for one in CONTROLS})
    assert again == opened


def test_synonyms_of_a_file_stand_in_their_controls() -> None:
    opened = serve.opening_state(*(str(PROBLEMS / f"paper-tool-window{end}.yaml") for end in ("", ".system")))
    assert state.text_of(opened, BY_ID["s-lens-transmission_frac"]) == "0.9"  # transmission
    assert state.text_of(opened, BY_ID["s-light-flux_lm"]) == "20000"  # luminous_flux_lm


@pytest.mark.parametrize(
    ("name", "text"),
    [("m-vehicle-altitude_m", "-3"), ("m-vehicle-altitude_m", "two"), ("s-settings-f_number", "1e9"),
     ("m-requirements-overlap", "7"), ("s-lens-focal_length_mm", "nan"), ("m-vehicle-speed_m_s", "")],
)  # fmt: skip
def test_values_outside_are_explained_at_their_control(name: str, text: str, outcomes: KeptResults) -> None:
    wrong = state.with_texts(state.OPENING, {name: text})
    found = showing.results(outcomes, wrong)
    marks = showing.marked(wrong, found)
    assert [one[0] for one in marks] == [name]
    assert name.rpartition("-")[2] in marks[0][1]
    assert "These values do not work" in str(showing.fault_list(wrong, found))


def test_margins_tell_what_is_missed(outcomes: KeptResults) -> None:
    missed = [one for one in shown_margins(outcomes.result(state.OPENING, 0)) if not one[4]]
    assert [one[0] for one in missed] == ["signal to noise"]  # 19.24 dB, below the 20 dB that the problem asks for


def test_a_copy_stands_beside_and_only_it_is_turned(outcomes: KeptResults) -> None:
    two = state.with_copy(state.OPENING)
    assert two["shown"] == 1
    moved = turned(two, **{"s-lens-focal_length_mm": "16"})
    assert moved["systems"][0] == two["systems"][0]
    assert shown_figures(outcomes.result(moved, 0))["fov_x_m"] == WINDOW["fov_x_m"]
    assert shown_figures(outcomes.result(moved, 1))["fov_x_m"] != WINDOW["fov_x_m"]
    assert state.without_shown(moved) == state.OPENING
    five = moved
    while len(five["systems"]) < state.MOST_SYSTEMS:
        five = state.with_copy(five)
    with pytest.raises(MissionError, match="at most"):
        state.with_copy(five)


TWO_SCENES = {
    **state.OPENING["mission"],
    "scenes": [
        {"name": "reef", "water": "I", "seafloor": "coral", "depth_m": 20},
        {"name": "bay", "water": "III", "seafloor": "sand", "depth_m": 10, "vehicle": {"altitude_m": 1.0}},
    ],
}


def test_controls_act_on_the_scene_that_is_shown(outcomes: KeptResults) -> None:
    of = {**state.with_mission(state.OPENING, TWO_SCENES), "scene": 1}
    assert state.text_of(of, BY_ID["m-vehicle-altitude_m"]) == "1"
    moved = turned(of, **{"m-vehicle-altitude_m": "1.5", "m-scene-water": "II"})
    assert moved["mission"]["vehicle"]["altitude_m"] == 2.0
    assert moved["mission"]["scenes"][0] == TWO_SCENES["scenes"][0]
    assert moved["mission"]["scenes"][1] == {**TWO_SCENES["scenes"][1], "water": "II", "vehicle": {"altitude_m": 1.5}}
    seen = [shown_figures(outcomes.result(moved, 0), scene) for scene in (0, 1)]
    assert seen[0]["fov_x_m"] == WINDOW["fov_x_m"]
    assert seen[1]["fov_x_m"] == "1.584 m"  # 2.1114 m x 1.5 / 2: physics paper has the pinhole at the vertex
    assert seen[1]["fov_x_deg"] == seen[0]["fov_x_deg"]


# ---------------------------------------------------------------- addresses and files


def test_address_brings_the_state_back() -> None:
    two = turned(state.with_copy(state.OPENING), **{"s-lens-focal_length_mm": "16"})
    again = state.unpacked(state.address_of(two))
    assert again["mission"]["scenes"][0].pop("name") == "scene 1"  # as every mission has it
    assert again == two


@pytest.mark.parametrize(
    "text",
    ["", "x", "eJw=", state.address_of(state.OPENING)[:-9],
     base64.urlsafe_b64encode(zlib.compress(json.dumps({"mission": {}, "systems": [], "shown": 3}).encode())).decode()],
    ids=["empty", "letter", "cut", "shorter", "nothing"],
)  # fmt: skip
def test_broken_addresses_are_refused(text: str) -> None:
    with pytest.raises(MissionError):
        state.unpacked(text)


def test_an_address_that_would_fill_the_memory_is_refused() -> None:
    plain = zlib.decompress(base64.urlsafe_b64decode(state.address_of(state.OPENING)))

    def padded(count: int) -> str:
        return base64.urlsafe_b64encode(zlib.compress(b" " * count + plain)).decode()

    assert state.unpacked(padded(1))["shown"] == 0
    with pytest.raises(MissionError):
        state.unpacked(padded(state.MOST_FILE_BYTES))


def test_own_water_is_read_and_no_path_is_told(outcomes: KeptResults, tmp_path: Path) -> None:
    held = state.with_file(state.OPENING, "bay.csv", WATER)
    made = turned(held, **{"m-scene-water": "bay.csv", "m-scene-water_table": ""})
    (tmp_path / "bay.csv").write_text(WATER)
    mission = {**made["mission"], "scenes": [{**made["mission"]["scenes"][0], "water": str(tmp_path / "bay.csv")}]}
    beside = uwopt.evaluate(mission, made["systems"][0]).design
    assert beside is not None
    result = outcomes.result(made, 0)
    assert result.design is not None
    assert result.design.scenes[0].figures == beside.scenes[0].figures
    wrong = state.with_file(made, "bay.csv", "wavelength_nm,attenuation_per_m\n400,x\n")
    with pytest.raises(UwoptError) as told:
        outcomes.result(wrong, 0)
    assert "bay.csv" in str(told.value)
    assert str(outcomes.folder) not in str(told.value)


@pytest.mark.parametrize(
    ("section", "key", "name"),
    [("scene", "water", "/etc/secret.csv"), ("scene", "water", "../x.csv"), ("catalog", "files", ["/etc/passwd"]),
     ("catalog", "prices", "/etc/passwd"), ("light", "spectrum", "/etc/secret.csv")],
)  # fmt: skip
def test_files_of_the_server_cannot_be_named(section: str, key: str, name: Any, outcomes: KeptResults) -> None:
    made = json.loads(json.dumps(state.OPENING))
    place = {"scene": made["mission"]["scenes"][0], "light": made["systems"][0]["light"]}.get(section)
    if place is None:
        place = made["mission"].setdefault(section, {})
    place[key] = name
    with pytest.raises(MissionError, match="this file is not loaded"):
        outcomes.result(made, 0)


@pytest.mark.parametrize(
    ("name", "text", "why"),
    [("../../x.csv", WATER, "cannot be loaded"), ("x.exe", WATER, "cannot be loaded"),
     (".csv", WATER, "cannot be loaded"), ("x.csv", "a" * 1_000_001, "larger than 1 MB"),
     ("x.csv", "id,quantum_efficiency\na,/etc/my file.csv\n", "in a folder"),
     ("x.yaml", "spectrum: ~/secret.csv", "in a folder")],
)  # fmt: skip
def test_files_that_are_unfit_are_refused_with_the_reason(name: str, text: str, why: str) -> None:
    with pytest.raises(MissionError, match=why):
        state.with_file(state.OPENING, name, text)


def sent(text: bytes) -> str:
    return "data:text/plain;base64," + base64.b64encode(text).decode()


def test_uploads_are_taken_or_refused_with_the_reason() -> None:
    mission = (PROBLEMS / "whoi-abe.yaml").read_bytes()
    made, told = with_upload(state.OPENING, "mission", sent(mission), "abe.yaml")
    assert made["mission"]["name"].startswith("WHOI ABE")
    assert "abe.yaml is loaded" in told
    for content, why in (
        (sent(b"\xff\xfe\x00"), "UTF-8"), ("", "empty"), (sent(b"a" * 1_100_000), "larger"), (sent(b"[1, 2"), "line"),
        (sent(b"- 1\n- 2\n"), "not a mapping"),
    ):  # fmt: skip
        with pytest.raises(MissionError, match=why):
            with_upload(state.OPENING, "mission", content, "x.yaml")


OWN_CAMERA = (
    "id,manufacturer,model,availability,chip,colour,resolution_x_px,resolution_y_px,pixel_pitch_um,shutter,mounts,"
    "bit_depth,read_noise_e,saturation_e\nmy-camera,Me,One,current,IMX250,mono,2448,2048,3.45,global,C,12,2.4,10500\n"
)


def test_own_camera_stands_among_the_parts(explorer: Explorer) -> None:
    made, _ = with_upload(state.OPENING, "own", sent(OWN_CAMERA.encode()), "cameras.csv")
    assert made["mission"]["catalog"]["files"] == ["cameras.csv"]
    assert explorer.own_parts(made) == {"camera": ["my-camera"], "lens": [], "port": [], "light": []}
    chosen = turned(made, **{"s-camera": "my-camera"})
    seen = shown_figures(explorer.outcomes.result(chosen, 0))
    assert seen["fov_x_m"] == WINDOW["fov_x_m"]  # as many pixels of the same pitch
    assert seen["snr"] != WINDOW["snr"]
    assert explorer.own_parts(state.OPENING) == {}


def test_faults_of_an_own_file_are_told(explorer: Explorer) -> None:
    wrong = OWN_CAMERA.replace("chip", "chp").encode()
    made, _ = with_upload(state.OPENING, "own", sent(wrong), "cameras.csv")
    told = str(showing.fault_list(made, showing.results(explorer.outcomes, made)))
    assert "cameras.csv: column 'chp' is unknown; did you mean 'chip'?" in told
    assert str(explorer.outcomes.folder) not in told


# ---------------------------------------------------------------- who may ask


def test_only_this_machine_is_answered(explorer: Explorer) -> None:
    client = explorer.app.server.test_client()
    own = client.get("/", headers={"Host": "127.0.0.1:8050"})
    assert own.status_code == 200
    assert "script-src 'self' 'sha256-" in own.headers["Content-Security-Policy"]
    assert "unsafe-eval" not in own.headers["Content-Security-Policy"]
    assert client.get("/", headers={"Host": "evil.example:8050"}).status_code == 403
    address = {"Host": "127.0.0.1:8050", "Origin": "http://evil.example"}
    assert client.post("/_dash-update-component", json={}, headers=address).status_code == 403


def test_page_tells_no_path_of_the_server_and_debugs_nothing(explorer: Explorer) -> None:
    client = explorer.app.server.test_client()
    told = "".join(
        client.get(path, headers={"Host": "localhost"}).get_data(as_text=True)
        for path in ("/", "/_dash-layout", "/_dash-dependencies", "/nothing-here")
    )
    for path in (str(PROBLEMS.parent), str(Path(uwopt.__file__).parent), str(explorer.outcomes.folder)):
        assert path not in told
    assert not explorer.app.server.debug
    assert "Traceback" not in told


def test_requests_that_are_too_large_are_refused(explorer: Explorer) -> None:
    client = explorer.app.server.test_client()
    done = client.post("/_dash-update-component", data=b"x" * 20_000_001, headers={"Host": "localhost"},
                       content_type="application/json")  # fmt: skip
    assert done.status_code == 413


def test_ten_tabs_at_once_stay_right(explorer: Explorer) -> None:
    def of(tab: int) -> list[str]:
        texts = {name: state.text_of(state.OPENING, BY_ID[name]) for name in IDS}
        return [*(texts | {"m-vehicle-altitude_m": str(1 + 0.25 * tab)}).values()]

    seen: dict[int, Any] = {}
    tabs = [
        threading.Thread(target=lambda n=n: seen.update({n: explorer.changed(*of(n), None, 0, state.OPENING)}))
        for n in range(10)
    ]
    for tab in tabs:
        tab.start()
    for tab in tabs:
        tab.join()
    for tab in range(10):
        alone = turned(state.OPENING, **{"m-vehicle-altitude_m": str(1 + 0.25 * tab)})
        result = uwopt.evaluate(alone["mission"], alone["systems"][0])
        told = str(seen[tab][1])
        assert all(f"'{text}'" in told for text in shown_figures(result).values())
    assert explorer.opening == state.OPENING


@pytest.mark.parametrize(("host", "own"), [("127.0.0.1", True), ("localhost", True), ("::1", True), ("0.0.0.0", False),
                                           ("192.168.1.7", False), ("example.org", False)])  # fmt: skip
def test_what_others_reach_is_known(host: str, own: bool) -> None:
    assert serve.is_loopback(host) is own


@pytest.mark.parametrize(("host", "warned"), [("127.0.0.1", False), ("0.0.0.0", True)])
def test_command_says_where_it_listens(
    host: str, warned: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def ended(self: serve.Served) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(serve.Served, "serve_forever", ended)
    with pytest.raises(SystemExit) as left:
        app(["explore", "--port", "0", "--host", host])
    told = capsys.readouterr().err
    assert left.value.code == 0
    assert f"uwopt explore: http://{host}:" in told
    assert ("there is no password" in told) is warned


def test_port_in_use_is_told() -> None:
    with serve.served(state.OPENING, port=0) as page, pytest.raises(OutputError, match="in use"):  # noqa: SIM117
        with serve.served(state.OPENING, port=page.server.server_port):
            pass


# ---------------------------------------------------------------- work in the background


def test_what_is_pinned_is_the_only_choice() -> None:
    made = jobs.pinned(state.OPENING, ["camera", "orientation", "light_count", "places"])
    assert made["catalog"] == {"cameras": ["seed-imx250m"]}
    assert made["vehicle"]["orientation"] == "portrait"
    assert made["vehicle"]["light_count"] == 1
    uwopt.load_mission(made)
    assert "catalog" not in state.OPENING["mission"]
    with pytest.raises(MissionError, match="pin the lens: own numbers"):
        jobs.pinned(state.OPENING, ["camera", "lens"])


def test_settings_are_pinned_as_they_are_set(explorer: Explorer) -> None:
    design = explorer.outcomes.result(state.OPENING, 0).best
    made = jobs.pinned(state.OPENING, ["f_number", "exposure_ms", "gain", "dim_frac", "places"], design)
    assert made["fixed"] == {"f_number": 4.0, "exposure_ms": 0.86, "gain": 1.0, "dim_frac": 1.0}
    assert made["vehicle"]["light_mounts"] == [dict.fromkeys(state.PLACE_OF_LAMP, 0.0) | {"y_m": 0.5}]
    uwopt.load_mission(made)
    two = state.with_mission(state.OPENING, TWO_SCENES)
    two["systems"][0] = {**two["systems"][0], "scenes": {"bay": {"gain": 2.0}}}
    with pytest.raises(MissionError, match="pin the gain: scenes have 1 and 2"):
        jobs.pinned(two, ["gain"], explorer.outcomes.result(two, 0).best)


def test_lamps_that_were_moved_stand_there_once(outcomes: KeptResults) -> None:
    places = [dict.fromkeys(state.PLACE_OF_LAMP, 0.0) | {"y_m": 0.8, "tilt_y_deg": 10.0}]
    moved = state.with_lamps(state.OPENING, {"places": places, "move": "first"})
    assert state.shown_system(moved)["light_mounts"] == places
    design = outcomes.result(moved, 0).best
    assert design is not None and design.hardware.light_mounts[0].y_m == 0.8
    more = turned(moved, **{"s-light_count": "2"})  # stands across track again, and the old move is not made anew
    assert "light_mounts" not in state.shown_system(more)
    assert state.with_lamps(more, {"places": places, "move": "first"}) == more
    with pytest.raises(MissionError, match="place and tilt"):
        state.with_lamps(state.OPENING, {"places": ["x"], "move": "second"})


def test_what_was_found_is_handed_over_once(explorer: Explorer) -> None:
    best = {**state.OPENING["systems"][0], "orientation": "landscape"}
    job = jobs.Job("optimise", None, None, done=("done", ["found"], best, "<html>"))
    job.listen = lambda: None  # type: ignore[method-assign]
    explorer.jobs.known["known"] = job
    *values, made, kick, _told, _bar, is_over, _cancel, no_report, _lines, _map = explorer.polled(
        1, "known", state.OPENING, 4
    )
    assert made["systems"][0] == state.OPENING["systems"][0]
    assert made["systems"][1] == {**best, "name": "recommended"}
    assert dict(zip(IDS, values, strict=True))["s-orientation"] == "landscape"
    assert (kick, is_over, no_report) == (5, True, False)
    with pytest.raises(PreventUpdate):
        explorer.polled(2, "known", made, 5)
    assert explorer.made_report(1, "known")["content"] == "<html>"
    del explorer.jobs.known["known"]


SMALL: dict[str, Any] = {
    "practice": "bare", "physics": "paper", "scene": {"water": "I", "seafloor": "sand", "depth_m": 20},
    "vehicle": {"altitude_m": 1.5, "speed_m_s": 0.3, "light_count": 1},
    "requirements": {"overlap": 0.3, "max_blur_px": 1.0, "min_snr_db": 15},
    "catalog": {"cameras": ["avt-alvium-1800-c-234m"], "lenses": ["computar-m1214-mp2"],
                "ports": ["blue-robotics-4-in"], "lights": ["arctic-rays-dragonfish-mini-strobe-65deg"]},
}  # fmt: skip


class Line:
    """What a job says, without a process."""

    def __init__(self) -> None:
        self.said: list[Any] = []

    def send(self, word: Any) -> None:
        self.said.append(word)


def test_what_if_that_is_no_key_is_told() -> None:
    line = Line()
    jobs.run("whatif", state.OPENING["mission"], state.OPENING["systems"][0], "speed", line)
    assert line.said[-1][0] == "fault"
    assert "no key with values" in line.said[-1][1]


def test_map_is_drawn_and_what_is_no_input_is_told() -> None:
    line, system = Line(), state.OPENING["systems"][0]
    jobs.run("map", state.OPENING["mission"], system, "snr_db\naltitude_m=1,2\nf_number=2,4", line)
    word, picture, made, report = line.said[-1]
    assert (word, made) == ("done", None)
    assert report.startswith("<!doctype html>")
    told = uwopt.evaluate(state.OPENING["mission"], system).best
    assert told is not None
    assert picture.content["data"][0]["z"][1][1] == pytest.approx(told.scenes[0].figures["snr_db"], rel=1e-4)
    jobs.run("map", state.OPENING["mission"], system, "snr_db\naltitude_m\nf_number=2,4", line)
    assert "no input with values" in line.said[-1][1]


def test_a_map_that_is_stopped_keeps_its_points(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "GOOD_BYE_S", math.inf)  # however slow the machine
    many = jobs.Jobs()
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # as of what a script starts in the background
    try:
        name = many.start("map", state.OPENING["mission"], state.OPENING["systems"][0],
                          "snr_db\naltitude_m=1:4:100\nf_number=2:8:100")  # fmt: skip
        job = many.get(name)
        while job is not None and not job.share and job.done is None:
            job.line.poll(0.1)
            job = many.get(name)
        assert job is not None
        job.stop()
        while job.done is None:
            job.line.poll(0.1)
            many.get(name)
        assert job.done[0] == "done"
        assert "stopped before all of the 10000 points" in job.done[1].caption
    finally:
        signal.signal(signal.SIGINT, before)
        many.close()


@pytest.mark.parametrize(
    ("kind", "said"),
    [("whatif", "2 points over speed_m_s"),
     *drawn([], [("doubt", "scenarios of what is uncertain"), ("trade", "systems")])],
)
def test_work_ends_in_words_and_a_report(kind: str, said: str) -> None:
    line = Line()
    jobs.run(kind, SMALL, state.OPENING["systems"][0], "speed_m_s=0.2:0.3:2", line)
    word, told, system, report = line.said[-1]
    assert (word, system) == ("done", None)
    assert said in " ".join(told)
    assert report.startswith("<!doctype html>")


def test_a_stopped_job_ends_and_no_more_than_two_run() -> None:
    many = jobs.Jobs()
    try:
        names = [many.start("optimise", state.OPENING["mission"], {}, "") for _ in range(2)]
        with pytest.raises(MissionError, match="run already"):
            many.start("optimise", state.OPENING["mission"], {}, "")
        for name in names:
            job = many.get(name)
            assert job is not None
            job.stop()
            job.process.join()
            again = many.get(name)
            assert again is not None and again.done is not None
            assert "stopped" in again.done[1]
    finally:
        many.close()
    assert many.get("guessed") is None

"""The page of `uwopt explore` in a real browser: what people see, turn, load and save, by mouse and by keyboard."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from browser import PATIENCE_MS, only_with_browser, started_browser
from priced_system import PRICED
from thorough import drawn

import uwopt
from uwopt.explore import serve, state
from uwopt.explore.controls import BY_ID, OWN
from uwopt.explore.outcome import SHOWN, shown_figures, shown_rig

pytestmark = only_with_browser
PROBLEMS = Path(__file__).parents[2] / "problems"
OPENING = state.address_of(state.OPENING)
NO_CURVES = '"value":"dof"', '"value":"rig"'  # of the plot that is chosen at first
#: A mission of which the search is short: two cameras, two lenses, one port, one lamp.
SMALL: dict[str, Any] = {
    "practice": "bare", "physics": "paper",
    "scene": {"water": "I", "seafloor": "sand", "depth_m": 20},
    "vehicle": {"altitude_m": 1.5, "speed_m_s": 0.3, "orientation": "portrait", "light_count": 1},
    "requirements": {"overlap": 0.3, "max_blur_px": 1.0, "min_snr_db": 15},
    "catalog": {"cameras": ["avt-alvium-1800-c-234m", "avt-alvium-1800-c-040m"],
                "lenses": ["thorlabs-mvl16m1", "computar-m1214-mp2"], "ports": ["blue-robotics-4-in"],
                "lights": ["arctic-rays-dragonfish-mini-strobe-65deg"]},
}  # fmt: skip


@pytest.fixture(scope="module")
def url() -> Iterator[str]:
    """The address of a page that begins as the founding paper's window."""
    with serve.served(state.OPENING, port=0) as page:
        thread = threading.Thread(target=page.serve_forever, daemon=True)
        thread.start()
        yield page.url
        page.server.shutdown()
        thread.join()


@pytest.fixture(scope="module")
def context(url: str) -> Iterator[tuple[Any, list[str]]]:
    """A browser for all tests, and what goes wrong in its tabs."""
    faults: list[str] = []
    own = (url, "data:", "blob:")

    def watch(page: Any) -> None:
        page.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda fault: faults.append(fault.stack or str(fault)))
        page.on("request", lambda call: None if call.url.startswith(own) else faults.append(call.url))

    with started_browser() as browser:
        made = browser.new_context(viewport={"width": 1300, "height": 900})
        made.set_default_timeout(PATIENCE_MS)
        made.on("page", watch)
        yield made, faults


@pytest.fixture(scope="module")
def tab(context: tuple[Any, list[str]], url: str) -> Any:
    """One tab for all tests that look at no curves: those are never drawn in it, which takes most of the time."""
    page = context[0].new_page()

    def without_curves(call: Any) -> None:
        answer = call.fetch()
        call.fulfill(response=answer, body=answer.text().replace(*NO_CURVES))

    page.route("**/_dash-layout", without_curves)
    page.goto(url)
    return page


@pytest.fixture(scope="module")
def drawn_tab(context: tuple[Any, list[str]], url: str) -> Any:
    """A second tab, in which curves are drawn."""
    page = context[0].new_page()
    page.goto(url)
    return page


@pytest.fixture
def page(tab: Any, context: tuple[Any, list[str]]) -> Iterator[Any]:
    """The page as it opens; at its end no error may stand in the console, and nothing came from elsewhere."""
    yield opened(tab, OPENING)
    assert context[1] == []


def opened(page: Any, address: str) -> Any:
    """The page with the state of an address, of one system that sees 2.111 m."""
    page.evaluate("address => { location.hash = address; }", f"#s={address}")
    page.locator("[data-figure='1-fov_x_m']").wait_for(state="detached")
    says(page, "fov_x_m", "2.111 m")
    return page


def says(page: Any, name: str, text: str, system: int = 0) -> None:
    """Wait until a figure says this."""
    from playwright.sync_api import expect

    expect(page.locator(f"[data-figure='{system}-{name}']")).to_have_text(text, timeout=PATIENCE_MS)


def says_all(page: Any, mission: Any, system: Any, column: int = 0) -> None:
    """Wait until every figure is that of `evaluate`, to all digits shown."""
    for name, text in shown_figures(uwopt.evaluate(mission, system)).items():
        says(page, name, text, column)


def held(page: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """The mission and the system that the page saves."""
    made = []
    for name in ("mission", "system"):
        with page.expect_download() as download:
            page.click(f"#do-get-{name}")
        made.append(yaml.safe_load(Path(download.value.path()).read_text(encoding="utf-8")))
    return made[0], made[1]


def choose(page: Any, name: str, value: str) -> None:
    page.locator(f"#s-c-{name}").select_option(value)


def test_a_window_opens_and_follows_every_kind_of_control(page: Any) -> None:
    for name, text in {
        "fov_y_m": "1.766 m", "exposure_max_ms": "0.8625 ms", "dof_near_m": "1.253 m", "dof_far_m": "4.974 m",
        "virtual_image_distance_m": "0.2116 m",
    }.items():  # fmt: skip
        says(page, name, text)
    page.fill("#c-m-vehicle-altitude_m", "3")  # a number
    says(page, "fov_x_m", "3.167 m")
    assert page.input_value("#r-m-vehicle-altitude_m") == "3"
    page.focus("#r-s-lens-focal_length_mm")  # a slider, by keyboard
    page.keyboard.press("ArrowRight")
    says(page, "fov_x_m", "3.124 m")
    choose(page, "s-port-geometry", "flat")  # a choice
    says(page, "virtual_image_distance_m", "–")
    choose(page, "s-camera", OWN)  # a part
    page.locator("#c-s-camera-pixel_pitch_um").wait_for(state="visible")
    page.fill("#c-s-camera-pixel_pitch_um", "5")
    choose(page, "s-lens", "computar-m1214-mp2")
    page.locator("#c-s-lens-focal_length_mm").wait_for(state="hidden")
    says(page, "effective_focal_length_mm", "15.96 mm")  # 1.33 x 12 mm
    says_all(page, *held(page))


def test_values_outside_are_explained_and_the_last_figures_stay(page: Any) -> None:
    page.fill("#c-m-vehicle-altitude_m", "-3")
    page.locator("#f-m-vehicle-altitude_m").wait_for(state="visible")
    assert "-3 is not above 0" in page.inner_text("#f-m-vehicle-altitude_m")
    assert page.get_attribute("#c-m-vehicle-altitude_m", "aria-invalid") == "true"
    assert "-3 is not above 0" in page.inner_text("#faults")
    says(page, "fov_x_m", "2.111 m")
    page.fill("#c-m-vehicle-altitude_m", "2")
    page.locator("#f-m-vehicle-altitude_m").wait_for(state="hidden")
    assert page.inner_text("#faults") == ""


def test_systems_stand_side_by_side_and_the_address_brings_them_back(page: Any, drawn_tab: Any, url: str) -> None:
    page.click("#do-add")
    says(page, "fov_x_m", "2.111 m", system=1)
    page.fill("#c-s-lens-focal_length_mm", "16")
    says(page, "fov_x_m", "1.056 m", system=1)
    says(page, "fov_x_m", "2.111 m")
    choose(page, "shown", "0")
    page.wait_for_selector("#c-s-lens-focal_length_mm[value='8']")
    assert "#s=" in page.url
    drawn_tab.evaluate("address => { location.hash = address; }", page.url.partition("#")[2])
    says(drawn_tab, "fov_x_m", "1.056 m", system=1)  # a second tab shares nothing but what its address says
    drawn_tab.locator(".js-plotly-plot .scatterlayer").nth(3).wait_for(state="attached")  # two plots a system
    drawn_tab.fill("#c-m-vehicle-altitude_m", "3")
    says(drawn_tab, "fov_x_m", "3.167 m")
    drawn_tab.evaluate("location.hash = '#s=broken'")
    drawn_tab.locator("#told li", has_text="holds no state").wait_for()
    says(page, "fov_x_m", "2.111 m")
    page.click("#do-remove")
    says(page, "fov_x_m", "1.056 m")


def test_files_are_loaded_refused_and_kept(page: Any) -> None:
    for name, end in (("mission", ""), ("system", ".system")):
        page.set_input_files(f"#put-{name} input", PROBLEMS / f"whoi-abe{end}.yaml")
        page.locator("#told", has_text=f"whoi-abe{end}.yaml is loaded").wait_for()
    says_all(page, PROBLEMS / "whoi-abe.yaml", PROBLEMS / "whoi-abe.system.yaml")
    sent = {"name": "x.csv", "mimeType": "text/csv", "buffer": b"a,/etc/y.csv\n"}
    page.set_input_files("#put-own input", files=[sent])
    page.locator("#told li", has_text="in a folder").wait_for()
    water = b"wavelength_nm,attenuation_per_m\n400,0.3\n700,0.8\n"
    page.set_input_files("#put-own input", files=[sent | {"name": "bay.csv", "buffer": water}])
    page.locator("#own-files", has_text="bay.csv").wait_for()
    assert page.locator("#s-c-m-scene-water option[value='bay.csv']").count() == 1


def test_what_is_pinned_stays_and_the_rest_is_searched(page: Any) -> None:
    page.locator("summary", has_text="as files").click()
    page.fill("#mission-text", yaml.safe_dump(SMALL))
    page.fill("#system-text", yaml.safe_dump(state.OPENING["systems"][0] | {"lens": "computar-m1214-mp2"}))
    page.click("#do-apply")
    page.locator("#told", has_text="Taken.").wait_for()
    for pin in ("lens", "f_number"):
        page.click(f"#pin-{pin}")
        assert page.get_attribute(f"#pin-{pin}", "aria-pressed") == "true"
    page.click("#do-job-optimise")
    page.locator("#job-text", has_text="Done").wait_for(timeout=4 * PATIENCE_MS)
    assert "proven" in page.inner_text("#job-found")
    mission, system = held(page)
    assert system["lens"] == "computar-m1214-mp2"
    only = SMALL["catalog"] | {"lenses": ["computar-m1214-mp2"]}
    proven = uwopt.solve(SMALL | {"catalog": only, "fixed": {"f_number": 4}}, quick=True).best
    assert proven is not None
    assert [one["f_number"] for one in system["scenes"].values()] == [4]
    assert [system[kind] for kind in ("camera", "lens", "port", "light")] == [
        proven.hardware.parts[kind].id for kind in ("camera", "lens", "port", "light")
    ]
    says_all(page, mission, system, column=1)
    with page.expect_download() as download:
        page.click("#do-get-made")
    assert "Certificate" in Path(download.value.path()).read_text(encoding="utf-8")
    for pin in ("lens", "f_number"):
        page.click(f"#pin-{pin}")


def test_keyboard_alone_reaches_and_turns_the_controls(page: Any) -> None:
    page.evaluate("document.activeElement.blur(); document.querySelector('.skip').focus()")
    for _ in range(14):  # past the system bar to the lamps
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.id") == "c-s-light-flux_lm":
            break
    assert page.evaluate("document.activeElement.id") == "c-s-light-flux_lm"
    before = page.inner_text("[data-figure='0-power_w']")
    page.keyboard.press("Tab")  # its slider
    page.keyboard.press("ArrowLeft")
    page.locator("#c-s-light-flux_lm:not([value='20000'])").wait_for()
    assert float(page.input_value("#c-s-light-flux_lm")) < 20_000
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("Control+A")
    page.keyboard.type("30000")
    page.locator("#margin-table", has_text="light level").wait_for()
    assert before


TWO_LAMPS = state.with_texts(state.OPENING, {"s-light_count": "2", "m-physics": "full"})


def test_lamps_are_moved_by_hand_by_keys_and_by_numbers(page: Any) -> None:
    opened_at = page.evaluate("address => { location.hash = address; }", f"#s={state.address_of(TWO_LAMPS)}")
    assert opened_at is None
    at = page.locator("[data-lamp='0'][data-view='behind'] circle")
    page.locator("#lamp-1-y_m").wait_for()
    assert page.input_value("#lamp-0-y_m") == "0.5"
    at.scroll_into_view_if_needed()
    box = at.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y - 12, steps=4)
    page.mouse.up()
    assert float(page.input_value("#lamp-0-y_m")) > 0.6
    assert float(page.input_value("#lamp-0-z_m")) < -0.05
    page.focus("[data-lamp='1'][data-view='above']")
    for key in ("ArrowUp", "ArrowUp", "Shift+ArrowLeft", "PageUp"):
        page.keyboard.press(key)
    assert [page.input_value(f"#lamp-1-{key}") for key in ("x_m", "y_m", "tilt_y_deg")] == ["0.1", "-0.51", "2.5"]
    page.fill("#lamp-1-tilt_y_deg", "20")
    lit = page.locator("#margin-table", has_text="light level")
    lit.wait_for()
    places = [{key: float(page.input_value(f"#lamp-{n}-{key}")) for key in state.PLACE_OF_LAMP} for n in (0, 1)]
    system = state.OPENING["systems"][0] | {"light_count": 2, "light_mounts": places}
    says_all(page, TWO_LAMPS["mission"], system)
    assert held(page)[1]["light_mounts"] == places


@pytest.mark.parametrize("width", drawn([400], [400, 860, 1300]))
def test_page_fits_narrow_windows_and_breaks_no_rule_of_access(
    drawn_tab: Any, context: tuple[Any, list[str]], width: int
) -> None:
    from axe_playwright_python.sync_playwright import Axe

    page = opened(drawn_tab, OPENING)
    page.set_viewport_size({"width": width, "height": 800})
    page.locator(".js-plotly-plot .scatterlayer").first.wait_for(state="attached")
    page.evaluate("document.querySelectorAll('details').forEach(one => { one.open = true; })")
    fits = f"document.documentElement.scrollWidth <= {width}"
    assert any(page.evaluate(fits) or page.wait_for_timeout(50) for _ in range(PATIENCE_MS // 50))  # once plots follow
    found = [one for one in Axe().run(page).response["violations"] if one["impact"] in ("serious", "critical")]
    page.set_viewport_size({"width": 1300, "height": 900})
    assert [(one["id"], one["nodes"][0]["html"]) for one in found] == []
    assert context[1] == []


def test_every_figure_has_its_cell(page: Any) -> None:
    assert page.locator("[data-figure^='0-']").count() == len(SHOWN)
    assert page.locator("[id^='w-']").count() == len(BY_ID)


def test_a_ceiling_is_drawn_above_the_lamps(page: Any) -> None:
    page.evaluate("address => { location.hash = address; }", f"#s={state.address_of(TWO_LAMPS)}")
    page.locator("#lamp-1-y_m").wait_for()
    place = {"x_m": 0.0, "y_m": 0.5, "z_m": 0.2, "tilt_x_deg": 0.0, "tilt_y_deg": 0.0}
    rig = {"places": [place], "altitude_m": 2.0, "along_m": 1.0, "across_m": 1.5}
    seen = {}
    for looks_up in (False, True):
        page.evaluate("rig => window.uwoptLamps.follow(rig)", {**rig, "looks_up": looks_up})
        page.locator(f"#lamp-numbers th:has-text('{'Up' if looks_up else 'Down'} [m]')").wait_for()
        floor = page.locator("#lamp-drawings .floor").bounding_box()["y"]
        lamp = page.locator("[data-lamp='0'][data-view='behind'] circle").bounding_box()
        seen[looks_up] = floor > lamp["y"]
    assert seen == {False: True, True: False}


def test_a_rig_below_a_ceiling_is_told_as_one() -> None:
    mission = {
        "practice": "bare", "scene": {"c_per_m": 0.2, "seafloor": 0.5, "depth_m": 20, "target": "ceiling"},
        "vehicle": {"distance_m": 2.0, "speed_m_s": 0.2, "light_count": 2}, "requirements": {"overlap": 0.5},
    }  # fmt: skip
    up = uwopt.evaluate(mission, PRICED | {"light_count": 2})
    assert shown_rig(up)["looks_up"]
    floor = {**mission, "scene": {**mission["scene"], "target": "floor"}}
    assert not shown_rig(uwopt.evaluate(floor, PRICED | {"light_count": 2}))["looks_up"]

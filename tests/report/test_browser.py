"""The report in a real browser: Debian's Chromium, driven by Playwright, with the network off.

Without a browser these tests are skipped; UWOPT_REQUIRE_BROWSER=1 makes a missing one a failure.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from browser import PATIENCE_MS, only_with_browser, started_browser

from uwopt.api.evaluating import evaluate
from uwopt.bench.machine import machine
from uwopt.bench.page import bench_html
from uwopt.bench.run import Bench
from uwopt.bench.suite import BenchRow, BenchTable, Chart, Suite
from uwopt.report.card.page import card_html, card_of
from uwopt.report.page.page import report_html

ROOT = Path(__file__).parents[2]
WINDOW = {"width": 1300, "height": 900}
OWN = ("file:", "data:", "blob:", "about:")
Make = Callable[..., Any]


pytestmark = only_with_browser


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """One browser for all tests."""
    with started_browser() as started:
        yield started


@pytest.fixture(scope="module")
def tab(browser: Any) -> tuple[Any, list[str]]:
    """One tab off the network for all pages, which keeps the plot library compiled, and what goes wrong in it."""
    faults: list[str] = []
    context = browser.new_context(viewport=WINDOW)
    context.set_offline(True)
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    page.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda fault: faults.append(str(fault)))
    page.on("request", lambda call: None if call.url.startswith(OWN) else faults.append(call.url))
    return page, faults


@pytest.fixture
def show(tab: tuple[Any, list[str]], file: Path) -> Iterator[Callable[..., Any]]:
    """Load a result's page, or one given, after a script that changes the browser.

    At the end no error may stand in the console, and nothing was asked for.
    """
    page, faults = tab
    tools, added = page.context.new_cdp_session(page), []

    def loaded(result: Any, viewport: Any = WINDOW, color_scheme: str = "light", before: str = "") -> Any:
        file.write_text(result if isinstance(result, str) else report_html(result), encoding="utf-8")
        page.set_viewport_size(viewport)
        page.emulate_media(media="screen", color_scheme=color_scheme)
        if before:
            tools.send("Page.enable")
            added.append(tools.send("Page.addScriptToEvaluateOnNewDocument", {"source": before}))
        page.goto(file.as_uri())
        return page

    yield loaded
    for script in added:
        tools.send("Page.removeScriptToEvaluateOnNewDocument", script)
    tools.detach()
    page.mouse.move(0, 0)
    page.goto("about:blank")  # nothing goes on within another test
    assert faults == []


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One address for all pages: under another one the browser would compile the plot library again."""
    return tmp_path_factory.mktemp("page") / "report.html"


@pytest.fixture(scope="module")
def tank() -> Any:
    """A real result, so that the model can draw its pictures."""
    return evaluate(ROOT / "problems" / "paper-tank.yaml", ROOT / "problems" / "paper-tank.system.yaml")


def test_settings_card_prints_on_one_sheet(show: Callable[..., Any], tank: Any) -> None:
    page = show(card_html(tank, card_of(tank, "tank")))
    assert page.locator("h2").all_inner_texts()[:2] == ["Set", "How it stands"]
    assert page.locator("table.grid tbody tr").count() >= 6
    sheets = page.pdf(prefer_css_page_size=True).count(b"/Type /Page\n")
    assert sheets == 1


def test_settings_card_shows_every_cell_on_a_telephone(show: Callable[..., Any], tank: Any) -> None:
    page = show(card_html(tank, card_of(tank, "tank")))
    page.set_viewport_size({"width": 400, "height": 800})
    right = page.evaluate(
        "Math.max(...[...document.querySelectorAll('main td, main th')].map(one => one.getBoundingClientRect().right))"
    )
    assert 0 < right <= 400
    wraps = ".map(one => getComputedStyle(one).overflowWrap)"
    cells = "[...document.querySelectorAll('section:not(.work) td.left')]"
    assert set(page.evaluate(cells + wraps)) == {"break-word"}  # heads were broken within words


def wait_drawn(page: Any, place: str, number: int) -> None:
    """Wait until so many plots of a place are drawn, and see that each holds marks."""
    drawn = page.locator(f"{place} .plot[data-drawn=true]")
    drawn.nth(number - 1).wait_for(state="attached")
    for index in range(number):
        marks = drawn.nth(index).locator(".trace path, .trace .point, .heatmaplayer image, canvas")
        assert marks.count() > 0


def wait_rows(page: Any, *ids: str) -> None:
    """Wait until the table shows these points, in this order."""
    from playwright.sync_api import expect

    expect(page.locator("#points tbody tr:visible .choose")).to_have_text(list(ids), timeout=PATIENCE_MS)


# ---------------------------------------------------------------- every kind


def test_real_result_is_drawn_whole(show: Callable[..., Any], tank: Any) -> None:
    page = show(tank)
    figures = page.locator(".plot[data-figure]").count()
    assert figures >= 4
    wait_drawn(page, "#pictures", figures)
    assert page.locator("#pictures img").count() >= 2
    assert page.locator("#pictures .drawing svg").count() >= 1
    for image in page.locator("#pictures img").all():
        image.scroll_into_view_if_needed()
        assert image.evaluate("async (i) => { await i.decode(); return i.naturalWidth; }") > 50
    assert page.locator(".is-warn", has_text="Pictures are missing").count() == 0


def test_settings_and_hardware_stand_side_by_side_in_cards(show: Callable[..., Any], make_result: Make) -> None:
    page = show(make_result())
    page.set_viewport_size({"width": 1200, "height": 900})
    page.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    tops, names, values = page.evaluate("""() => [
      [...document.querySelectorAll('#buy .pair > .setting-card')].map((one) => one.getBoundingClientRect().top),
      [...document.querySelectorAll('#buy .pair .facts dt')].map((one) => one.getBoundingClientRect().width),
      [...document.querySelectorAll('#buy .pair .facts dd')].map((one) => one.getBoundingClientRect().width)]""")
    assert len(tops) == 2 and tops[0] == tops[1]
    assert names and max(names) < 100 < min(values)  # px: the words of how it stands have most of the card


def test_recommendation_and_nearest_miss_open(
    show: Callable[..., Any], make_result: Make, make_design: Make
) -> None:
    page = show(make_result())
    assert page.get_by_role("heading", name="Buy", exact=True).is_visible()
    assert "1 700 to 3 400 USD" in page.locator("#short").inner_text().replace("\u00a0", " ")
    why = {"requirements": [], "relaxations": [], "nearest_miss": make_design()}
    page = show(make_result(status="infeasible", recommendation=None, runners_up=[], infeasible=why))
    assert page.get_by_role("heading", name="Why nothing fits").is_visible()


@pytest.mark.parametrize(("names", "points", "plots"), [
    (("power", "cost", "information"), 8, 3), (("power", "cost"), 8, 1), (("power", "information"), 1, 1),
])  # fmt: skip
def test_front_of_any_size_is_drawn(
    show: Callable[..., Any], make_front: Make, names: tuple[str, ...], points: int, plots: int
) -> None:
    page = show(make_front(*names, points=points))
    wait_drawn(page, "#pairs", plots)
    assert page.locator("#pairs .plot").count() == plots
    wait_rows(page, *(f"p{n}" for n in range(1, points + 1)))


def test_empty_front_still_says_why(show: Callable[..., Any], make_front: Make) -> None:
    page = show(make_front(points=0))
    assert "No system of the catalogue" in page.locator(".verdict").first.inner_text()


# ---------------------------------------------------------------- the trade-off


def test_table_sorts_both_ways(show: Callable[..., Any], make_front: Make) -> None:
    page = show(make_front())
    head = page.locator("#points th", has=page.get_by_role("button", name="power"))
    rising = [f"p{n}" for n in range(1, 9)]  # power falls along the front
    for direction, ids in (("ascending", rising[::-1]), ("descending", rising)):
        head.get_by_role("button").click()
        assert head.get_attribute("aria-sort") == direction
        wait_rows(page, *ids)
    assert page.locator("#points th[aria-sort]").count() == 1


def test_filters_of_text_part_and_range_meet(show: Callable[..., Any], make_front: Make) -> None:
    page = show(make_front())
    page.locator("#filter-text").fill("acme-lens-1")
    wait_rows(page, "p4", "p5", "p6")
    page.locator("#ranges summary").click()
    page.get_by_label("power at most").fill("30")
    wait_rows(page, "p5", "p6")
    assert "2 of 8 systems" in page.locator("#filter-count").inner_text()
    wait_drawn(page, "#pairs", 3)
    dimmed = """(e) => [...e.querySelectorAll(".scatterlayer .point")]
        .filter((point) => Number(point.style.opacity || 1) < 0.1).length"""
    assert page.locator("#pairs .plot").first.evaluate(dimmed) == 6  # the plots dim what the table hides
    page.get_by_role("button", name="Show all").click()
    wait_rows(page, *(f"p{n}" for n in range(1, 9)))
    page.get_by_label("Lens").select_option("acme-lens-2")
    wait_rows(page, "p7", "p8")


def test_every_point_is_seen_and_other_methods_lie_hollow_beneath(
    show: Callable[..., Any], make_front: Make
) -> None:
    page = show(make_front())
    wait_drawn(page, "#pairs", 3)
    traces = """(e) => e.data.map((t, n) => ({name: t.name, symbol: t.marker?.symbol, line: t.marker?.line?.width,
        opacity: [...e.querySelectorAll(".scatterlayer .trace")][n].querySelectorAll(".point").length === 0 ? [] :
          [...e.querySelectorAll(".scatterlayer .trace")[n].querySelectorAll(".point")].map((p) =>
            Number(p.style.opacity || 1))}))"""
    for plot in page.locator("#pairs .plot").all():
        drawn = plot.evaluate(traces)
        names = [trace["name"] for trace in drawn]
        assert names == ["same hardware", "other methods", "front", "picks", "chosen"]  # from below to above
        by_name = dict(zip(names, drawn, strict=True))
        assert by_name["front"]["opacity"] == [1] * 8 and not by_name["front"]["line"]
        assert by_name["other methods"]["symbol"].endswith("-open")


def test_names_of_picks_stand_apart_within_the_plot(show: Callable[..., Any], make_front: Make) -> None:
    from dataclasses import replace

    front = make_front(points=60)  # neighbours are a few pixels apart
    pick = front.picks[0]
    close = [replace(pick, name=name, point=f"p{n}") for name, n in
             (("cheapest", 1), ("knee", 2), ("least power", 60), ("best image", 60), ("other", 59))]  # fmt: skip
    page = show(replace(front, picks=close))
    wait_drawn(page, "#pairs", 3)
    boxes = """(e) => {
        const box = (n) => { const b = n.getBoundingClientRect(); return [b.left, b.top, b.right, b.bottom]; };
        return {frame: box(e.querySelector(".bglayer .bg, .plotbg, .cartesianlayer .bg") || e),
                names: [...e.querySelectorAll(".annotation-text-g")].map((n) => [n.textContent, ...box(n)])}; }"""
    for plot in page.locator("#pairs .plot").all():
        seen = plot.evaluate(boxes)
        names = seen["names"]
        assert sorted(name[0] for name in names) == ["cheapest", "knee", "least power, best image", "other"]
        left, top, right, bottom = seen["frame"]
        for _, x0, y0, x1, y1 in names:
            assert x0 >= left and y0 >= top and x1 <= right and y1 <= bottom
        for number, (_, x0, y0, x1, y1) in enumerate(names):
            for _, u0, v0, u1, v1 in names[number + 1 :]:
                assert x1 <= u0 or u1 <= x0 or y1 <= v0 or v1 <= y0


def test_laptop_shows_pairs_card_and_table_without_scrolling_sideways(
    show: Callable[..., Any], make_front: Make
) -> None:
    page = show(make_front(), viewport={"width": 1280, "height": 800})
    wait_drawn(page, "#pairs", 3)
    places = page.locator("#pairs > *").evaluate_all(
        "(all) => all.map((e) => { const b = e.getBoundingClientRect(); return [b.left, b.top]; })"
    )
    (x1, y1), (x2, y2), (x3, y3), (x4, y4) = places  # two by two, the card last
    assert x1 == x3 < x2 == x4 and y1 == y2 < y3 == y4
    assert page.locator("#pairs #chosen").is_visible()
    box = page.locator("#points").locator("..")
    assert box.evaluate("(e) => e.scrollWidth <= e.clientWidth")
    assert page.locator("#points th", has_text="found by").is_hidden()
    page.get_by_label("more columns in the table").check()
    assert page.locator("#points th", has_text="found by").is_visible()
    page.get_by_role("tab", name="Parallel coordinates").click()
    assert page.locator("#chosen").is_visible()  # it moves beside the other views


def test_click_on_a_point_shows_its_system(show: Callable[..., Any], make_front: Make) -> None:
    page = show(make_front("power", "cost", points=6))
    wait_drawn(page, "#pairs", 1)
    plot = page.locator("#pairs .plot").first
    plot.scroll_into_view_if_needed()
    place = plot.evaluate(
        """(e) => {
          const trace = e.data.findIndex((t) => t.name === "front"), {xaxis, yaxis} = e._fullLayout;
          const box = e.getBoundingClientRect(), at = 2;
          return [box.left + xaxis._offset + xaxis.d2p(e._fullData[trace].x[at]),
                  box.top + yaxis._offset + yaxis.d2p(e._fullData[trace].y[at])];
        }"""
    )
    page.mouse.move(*place)
    page.locator(".hoverlayer .hovertext").wait_for(state="attached")
    assert "acme-cam" in page.locator(".hoverlayer .hovertext").inner_html()
    page.mouse.click(*place)
    page.locator("#chosen h3", has_text="Point p3").wait_for()
    card = page.locator("#chosen").inner_text()
    for words in (
        "acme-lens-0",
        "Settings to type in",
        "12.345 ms",
        "overlap along track",
        "at least 0.6000",
        "34.00 W",
    ):
        assert words in card
    assert page.locator("#points tr.is-chosen .choose").inner_text() == "p3"
    assert page.locator("#points tr.is-chosen .choose").get_attribute("aria-pressed") == "true"


def test_row_of_the_table_shows_in_the_plots(show: Callable[..., Any], make_front: Make) -> None:
    page = show(make_front())
    wait_drawn(page, "#pairs", 3)
    page.locator("#points tr[data-index='4'] .choose").click()
    page.locator("#chosen h3", has_text="Point p5").wait_for()
    page.locator(".lane.is-chosen[data-index='4']").wait_for(state="attached")
    chosen = "(e) => { const {x, y} = e.data.find((t) => t.name === 'chosen'); return [...x, ...y]; }"
    assert page.locator("#pairs .plot").first.evaluate(chosen) == [6000.0, 28.0]  # cost and power of p5


def test_brush_in_parallel_coordinates_filters_the_table(show: Callable[..., Any], make_front: Make) -> None:
    page = show(make_front())
    page.get_by_role("tab", name="Parallel coordinates").click()
    axis = page.locator("#lanes .hit").nth(1)  # cost, less is up
    axis.scroll_into_view_if_needed()
    box = axis.bounding_box()
    middle = box["x"] + box["width"] / 2
    page.mouse.move(middle, box["y"] + 2)
    page.mouse.down()
    page.mouse.move(middle, box["y"] + 0.45 * box["height"], steps=4)
    page.mouse.up()
    wait_rows(page, "p1", "p2", "p3")  # up to 4000 * (7500 / 4000)**0.45 = 5307 USD on the axis of logarithms
    assert page.get_by_label("cost at most").input_value() != ""
    page.mouse.click(middle, box["y"] + 5)
    wait_rows(page, *(f"p{n}" for n in range(1, 9)))


def test_view_in_three_dimensions_is_drawn_or_says_why_not(
    show: Callable[..., Any], make_front: Make
) -> None:
    page = show(make_front())
    page.get_by_role("tab", name="Three dimensions").click()
    shown = page.locator("#space canvas, #space .plot-note")
    shown.first.wait_for()
    if page.locator("#space canvas").count():
        page.locator("#space[data-drawn=true]").wait_for()
        page.locator("#points tr[data-index='2'] .choose").click()
        page.locator("#chosen h3", has_text="Point p3").wait_for()


def test_page_without_webgl_says_so(show: Callable[..., Any], make_front: Make) -> None:
    blind = """const old = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
          return /webgl/.test(kind) ? null : old.call(this, kind, ...more);  // as browsers without WebGL answer
        };"""
    page = show(make_front(), before=blind)
    wait_drawn(page, "#pairs", 3)
    page.get_by_role("tab", name="Three dimensions").click()
    page.get_by_text("This browser has no WebGL").wait_for()


# ---------------------------------------------------------------- for everyone


def test_keyboard_reaches_tabs_heads_and_points(show: Callable[..., Any], make_front: Make) -> None:
    page = show(make_front())
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    page.keyboard.press("Enter")
    assert page.evaluate("document.activeElement.id") == "main"
    first = page.get_by_role("tab", name="cheapest")
    first.focus()
    page.keyboard.press("ArrowRight")
    second = page.get_by_role("tab", name="least power")
    assert second.get_attribute("aria-selected") == "true" and first.get_attribute("aria-selected") == "false"
    assert second.evaluate("(e) => e === document.activeElement")
    assert second.evaluate("(e) => getComputedStyle(e).outlineStyle") != "none"  # focus is seen
    panel = page.locator(f"#{second.get_attribute('aria-controls')}")
    assert panel.is_visible() and panel.get_attribute("role") == "tabpanel"
    page.keyboard.press("Home")
    assert first.get_attribute("aria-selected") == "true"
    page.locator("#points th button").nth(2).focus()
    page.keyboard.press("Enter")
    page.locator("#points th[aria-sort=ascending]", has_text="power").wait_for()
    page.locator("#points tr[data-index='1'] .choose").focus()
    page.keyboard.press("Space")
    page.locator("#chosen h3", has_text="Point p2").wait_for()


def test_dark_theme_follows_the_system_and_the_button(show: Callable[..., Any], make_front: Make) -> None:
    page = show(make_front(), color_scheme="dark")
    ground = "getComputedStyle(document.body).backgroundColor"
    dark = page.evaluate(ground)
    wait_drawn(page, "#pairs", 3)
    ink = "(e) => getComputedStyle(e.querySelector('.xtick text')).fill"
    light_text = page.locator("#pairs .plot").first.evaluate(ink)
    button = page.locator("#theme")
    assert button.get_attribute("aria-pressed") == "true"
    button.click()
    assert button.get_attribute("aria-pressed") == "false"
    assert page.evaluate(ground) != dark
    assert page.locator("#pairs .plot").first.evaluate(ink) != light_text


def test_print_is_light_whole_and_without_controls(show: Callable[..., Any], make_front: Make) -> None:
    page = show(make_front(), color_scheme="dark")
    wait_drawn(page, "#pairs", 3)
    paper = page.pdf()
    assert paper.startswith(b"%PDF") and paper.count(b"/Type /Page\n") + paper.count(b"/Type /Page ") >= 3
    page.emulate_media(media="print", color_scheme="dark")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    for name in ("#theme", ".filters", "#chosen", "[role=tablist] >> nth=0", ".contents"):
        assert page.locator(name).is_hidden()
    assert page.locator(".panel h3", has_text="Least power").is_visible()  # every pick is on paper


def test_long_fronts_are_thinned_on_paper_but_keep_their_picks(
    show: Callable[..., Any], make_front: Make
) -> None:
    page = show(make_front("power", "cost", points=104))
    page.emulate_media(media="print")
    rows = page.locator("#points tbody tr:visible .choose").all_inner_texts()
    assert len(rows) == 36 and {"p1", "p4", "p104"} <= set(rows)  # one of three, and the pick at the end
    assert page.get_by_text("front.csv has all 104").is_visible()


@pytest.mark.parametrize("width", [390, 820, 1280])
def test_page_never_scrolls_sideways(show: Callable[..., Any], make_front: Make, width: int) -> None:
    page = show(make_front(), viewport={"width": width, "height": 800})
    wait_drawn(page, "#pairs", 1)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.evaluate(  # words for who listens, at the end of a table that scrolls in its own frame
        "document.querySelector('main').insertAdjacentHTML('beforeend', '<div class=scroll>"
        "<table style=\"width: 2000px\"><tr><td>a<td style=\"text-align: right\"><span class=sr>note</span>"
        "</table></div>')"
    )
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_tables_are_whole_at_the_width_of_a_laptop(
    show: Callable[..., Any], make_result: Make, make_margin: Make
) -> None:
    result = make_result()
    address = f"https://example.com/{'a' * 120}"
    kept = make_margin("max_skew_px", 0.3, 1.6, "<=", "px", reserve=0.4, at_altitude_m=1.75)
    best = result.recommendation
    (scene,) = best.scenes
    check = replace(best.rounded, totals=best.totals)
    far = replace(scene, margins=[*scene.margins, kept], margins_as_set=[*scene.margins, replace(kept, value=0.31)],
                  figures_as_set=scene.figures)  # fmt: skip
    made = replace(
        result, recommendation=replace(best, scenes=[far], rounded=check),
        assumptions=[replace(one, source=f"{one.source} {address}") for one in result.assumptions],
    )  # fmt: skip
    page = show(made, viewport={"width": 1200, "height": 800})
    page.evaluate("document.querySelectorAll('details').forEach(one => { one.open = true; })")
    cut = page.evaluate(
        "[...document.querySelectorAll('main .scroll')].filter(one => one.scrollWidth > one.clientWidth)"
        ".map(one => one.innerText.slice(0, 80)).filter(told => /why|Requirement/.test(told))"
    )
    assert cut == []


def test_settings_of_both_scenes_of_a_time_lapse_are_seen_at_once(show: Callable[..., Any], make_result: Make) -> None:
    """Twice "0.000556 Hz, once every 30 min" hid the light of a second scene, with nothing to tell that it is there."""
    best = make_result().recommendation
    (scene,) = best.scenes
    slow = {**scene.settings, "frame_rate_hz": 1.0 / 1800.0}
    two = [replace(scene, name=name, settings=slow, settings_to_set=slow) for name in ("ambient", "hot flow")]
    dear = replace(best, scenes=two, totals=replace(best.totals, cost=replace(best.totals.cost, low=25e3, high=13e4)))
    page = show(replace(make_result(), recommendation=dear), viewport={"width": 1200, "height": 800})
    cut = page.evaluate(
        "[...document.querySelectorAll('.short-part .scroll, .top .card')]"
        ".filter(one => one.scrollWidth > one.clientWidth).map(one => one.innerText.slice(0, 40))"
    )
    assert cut == []


def test_a_long_name_and_the_bars_of_maps_stay_on_a_telephone(show: Callable[..., Any], tank: Any) -> None:
    named = replace(tank, mission={**tank.mission, "name": f"Urchins, <b>{'Strongylocentrotus' * 2}</b>"})
    page = show(named, viewport={"width": 390, "height": 800})
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.locator("#fig-d0-illuminance, #fig-d0-snr").first.scroll_into_view_if_needed()
    page.locator(".plot[data-drawn=true] .colorbar").first.wait_for(state="attached")
    boxes = """() => { const plot = document.querySelector('.colorbar').closest('.plot');
        const box = (name) => plot.querySelector(name).getBoundingClientRect();
        return ['.xtitle', '.cbbg', '.heatmaplayer image'].map(box); }"""
    title, bar, field = page.evaluate(boxes)
    assert bar["bottom"] <= field["top"] + 1 and bar["width"] > bar["height"]  # beside it, it hid the title's end
    assert title["left"] > 0 and title["right"] <= 390


def test_what_to_buy_is_whole_on_a_telephone(show: Callable[..., Any], tank: Any) -> None:
    page = show(tank, viewport={"width": 390, "height": 800})
    over = page.evaluate(
        "[...document.querySelectorAll('.short-part table.grid')].map(one => one.getBoundingClientRect().right"
        " - one.closest('.short-part').getBoundingClientRect().right)"
    )
    assert over and max(over) <= 0


def test_result_can_be_taken_from_the_page(show: Callable[..., Any], make_front: Make) -> None:
    front = make_front()
    page = show(front)
    with page.expect_download() as waiting:
        page.locator("#raw").click()
    assert waiting.value.suggested_filename == "front.json"
    assert '"schema":"uwopt.front/1"' in Path(waiting.value.path()).read_text("utf-8")


def test_texts_of_files_run_no_script(show: Callable[..., Any], make_front: Make) -> None:
    from dataclasses import replace

    poison = "</script><script>window.caught = 1</script><img src=x onerror='window.caught = 1'>"
    front = make_front()
    for index, point in enumerate(front.points):
        parts = {
            kind: replace(part, id=f"{poison}{point.id}", name=poison)
            for kind, part in point.design.hardware.parts.items()
        }
        design = replace(point.design, hardware=replace(point.design.hardware, **parts))
        front.points[index] = replace(point, design=design)
    page = show(
        replace(front, mission={"name": poison}, mission_file={"name": poison, "text": poison}, picks=[
            replace(pick, name=poison, definition=poison) for pick in front.picks
        ])
    )  # fmt: skip
    wait_drawn(page, "#pairs", 3)
    page.locator("#points tr[data-index='1'] .choose").click()
    page.locator("#chosen h3", has_text="Point p2").wait_for()
    assert page.evaluate("window.caught") is None
    assert poison[:20] in page.locator("h1").inner_text()


def test_paper_has_the_plots_that_nobody_scrolled_to(show: Callable[..., Any], tank: Any) -> None:
    busy = "window.requestIdleCallback = () => 0"  # a page that has no idle moment before it is printed
    page = show(tank, viewport={"width": 1300, "height": 300}, before=busy)
    page.locator("html[data-plots=ready]").wait_for()  # with the page, not with the first plot that is seen
    wanted = page.locator("[data-figure]").count()
    assert wanted > 3 and page.locator("[data-figure][data-drawn=true]").count() < wanted
    page.pdf()
    assert page.locator("[data-figure][data-drawn=true] .main-svg >> nth=0").count() == 1
    assert page.locator("[data-figure]:not([data-drawn=true])").count() == 0


def test_proof_is_folded_until_its_link_or_paper_asks_for_it(
    show: Callable[..., Any], make_result: Make
) -> None:
    from playwright.sync_api import expect

    page = show(make_result())
    proof = page.get_by_role("heading", name="Certificate")
    expect(proof).to_be_hidden()
    page.locator(".contents a[href='#trust']").click()
    expect(proof).to_be_visible()
    page.locator("#trust summary").first.click()
    expect(proof).to_be_hidden()
    page.emulate_media(media="print")
    expect(proof).to_be_visible(timeout=PATIENCE_MS)


def test_what_is_opened_for_paper_is_closed_again(show: Callable[..., Any], make_front: Make) -> None:
    from playwright.sync_api import expect

    page = show(make_front())
    folded = page.locator(".tabs > .panel[hidden]")
    some = folded.count()
    assert some
    page.emulate_media(media="print")
    expect(folded).to_have_count(0, timeout=PATIENCE_MS)
    page.emulate_media(media="screen")
    expect(folded).to_have_count(some, timeout=PATIENCE_MS)


def test_page_of_a_benchmark_draws_its_charts(show: Callable[..., Any]) -> None:
    def table(rows: Any) -> list[BenchTable]:
        return [BenchTable("All <of> them", ("rule", "rows"), [["any", str(len(rows))]])]

    kinds: tuple[Chart, ...] = ("precision", "progress", "scaling")
    suites = [
        Suite(
            kind,
            f"Suite {kind}",
            "What it <i>measures</i>.",
            kind,
            lambda budget: iter(()),
            1.0,
            1.0,
            tables=table,
        )
        for kind in kinds
    ]
    rows = [
        BenchRow(kind, "case <b>" if n % 2 else "=1+1", f"rule {n % 3}", size=2.0**n, time_s=1e-3 * 2**n,
                 error=None if n == 5 else 10.0**-n, memory_mib=10.0 + n)
        for kind in kinds for n in range(6)
    ]  # fmt: skip
    page = show(bench_html(Bench(True, 0, (), machine(), suites, rows, dict.fromkeys(kinds, 1.0))))
    page.wait_for_function(
        "() => [...document.querySelectorAll('[data-figure]')].every(p => p.dataset.drawn === 'true')"
    )
    assert page.locator(".plot").count() == 6

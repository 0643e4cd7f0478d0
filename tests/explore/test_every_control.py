"""Every control of the page in a real browser: it moves what is seen, and figures stay those of `evaluate`.

Before a release; `test_state.py` turns each without a browser in every run.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from browser import PATIENCE_MS, only_with_browser, started_browser
from thorough import THOROUGH
from turned_controls import FULL, other

import uwopt
from uwopt.errors import UwoptError
from uwopt.explore import serve, state
from uwopt.explore.controls import BY_ID, CONTROLS, Control
from uwopt.explore.outcome import shown_figures

pytestmark = [only_with_browser, pytest.mark.skipif(not THOROUGH, reason="a second or two a control")]
SEEN = "#figure-table, #margin-table, #faults"


@pytest.fixture(scope="module")
def page() -> Iterator[Any]:
    """A tab of the page, in which no error is printed."""
    faults: list[str] = []
    with serve.served(FULL, port=0) as made, started_browser() as browser:
        threading.Thread(target=made.serve_forever, daemon=True).start()
        tab = browser.new_page(viewport={"width": 1300, "height": 900})
        tab.set_default_timeout(PATIENCE_MS)
        tab.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)
        tab.on("pageerror", lambda fault: faults.append(str(fault)))
        tab.goto(made.url)
        yield tab
        made.server.shutdown()
    assert faults == []


def seen(page: Any) -> str:
    """All figures, margins and faults, as text."""
    return "\n".join(page.locator(SEEN).all_inner_texts())


def settled(page: Any, before: str) -> str:
    """What is seen once it is another than before, and stays."""
    page.wait_for_function(
        "([where, before]) => [...document.querySelectorAll(where)].map(x => x.innerText).join('\\n') !== before",
        arg=[SEEN, before],
    )
    said = seen(page)
    while (page.wait_for_timeout(400), seen(page))[1] != said:
        said = seen(page)
    return said


def turn(page: Any, control: Control, text: str) -> None:
    """Say another value, as a person does."""
    if control.choices or control.is_part:
        page.locator(f"#s-c-{control.id}").select_option(text)
    else:
        page.fill(f"#c-{control.id}", text)


def opened(page: Any) -> str:
    """The page as it opens; what is seen there."""
    page.evaluate("hash => { location.hash = hash; }", "")
    page.evaluate("hash => { location.hash = hash; }", f"#s={state.address_of(FULL)}")
    page.evaluate("document.querySelectorAll('details').forEach(one => { one.open = true; })")
    page.locator(f"#c-{CONTROLS[2].id}").wait_for(state="visible")
    page.wait_for_timeout(1500)
    return seen(page)


@pytest.mark.parametrize("control", CONTROLS, ids=lambda one: one.id)
def test_every_control_moves_something_that_is_seen(page: Any, control: Control) -> None:
    """And where nothing is at fault, every figure is that of `evaluate` of what the page saves, to all digits shown."""
    before = opened(page)
    turn(page, control, other(control, state.text_of(FULL, control)))
    after = settled(page, before)
    assert after != before
    files = []
    for name in ("mission", "system"):
        with page.expect_download() as download:
            page.click(f"#do-get-{name}")
        files.append(yaml.safe_load(Path(download.value.path()).read_text(encoding="utf-8")))
    try:
        result = uwopt.evaluate(*files)
    except UwoptError:
        assert page.inner_text("#faults")
        return
    for name, text in shown_figures(result).items():
        assert page.locator(f"[data-figure='0-{name}']").inner_text() == text, name


def test_all_controls_are_turned() -> None:
    assert len(BY_ID) == len(CONTROLS) > 50

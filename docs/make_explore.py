"""Takes the screenshots of docs/explore.md in a real browser: python docs/make_explore.py (needs Chromium)."""

from __future__ import annotations

import shutil
import threading
from pathlib import Path
from typing import Any

from uwopt.explore import serve

FIGURES = Path(__file__).parent / "figures"
WIDE, NARROW = {"width": 1300, "height": 980}, {"width": 400, "height": 860}


def drawn(page: Any, plots: int) -> None:
    """Wait until so many plots stand there."""
    page.locator(".js-plotly-plot .scatterlayer").nth(plots - 1).wait_for(state="attached")
    page.wait_for_timeout(500)  # fonts and widths settle


def take(page: Any, url: str) -> None:
    """All screenshots."""
    page.goto(url)
    page.locator("[data-figure='0-fov_x_m']").wait_for()
    drawn(page, 2)
    page.screenshot(path=FIGURES / "explore-window.png")
    page.click("#do-add")
    page.locator("[data-figure='1-fov_x_m']").wait_for()
    page.fill("#c-s-lens-focal_length_mm", "12")
    page.locator("[data-figure='1-fov_x_m']", has_text="1.408 m").wait_for()
    drawn(page, 4)
    page.locator("#plots").scroll_into_view_if_needed()
    page.locator(".panel").nth(1).screenshot(path=FIGURES / "explore-two.png")
    page.fill("#c-m-vehicle-altitude_m", "-3")
    page.locator("#f-m-vehicle-altitude_m").wait_for(state="visible")
    page.set_viewport_size(NARROW)
    page.locator("#w-m-vehicle-altitude_m").scroll_into_view_if_needed()
    page.screenshot(path=FIGURES / "explore-narrow.png")


def main() -> None:
    """Serve the page, and look at it."""
    from playwright.sync_api import sync_playwright

    with serve.served(serve.opening_state(), port=0) as page:
        threading.Thread(target=page.serve_forever, daemon=True).start()
        with sync_playwright() as player:
            browser = player.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
            take(browser.new_page(viewport=WIDE), page.url)
            browser.close()
        page.server.shutdown()


if __name__ == "__main__":
    main()

"""Takes the README's picture of the report in a real browser: python docs/make_report.py (needs Chromium)."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "figures" / "report.png"
VIEW = {"width": 1200, "height": 1250}


def main() -> None:
    """Solve the mission that the README begins with, and look at its report."""
    from playwright.sync_api import sync_playwright

    from uwopt import solve

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as player:
        report = Path(folder) / "report.html"
        solve(ROOT / "problems" / "reef-mosaic.yaml", alternatives=True).report(report)
        browser = player.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport=VIEW)
        page.goto(report.as_uri())
        page.locator("#short").wait_for()
        page.screenshot(path=PICTURE)
        browser.close()


if __name__ == "__main__":
    main()

"""Debian's Chromium, driven by Playwright, for tests of what people see.

Without a browser these tests are skipped; UWOPT_REQUIRE_BROWSER=1 makes a missing one a failure.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Any

import pytest

REQUIRED = os.environ.get("UWOPT_REQUIRE_BROWSER") == "1"
BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
ARGUMENTS = [
    "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--no-first-run", "--enable-unsafe-swiftshader",
]  # fmt: skip
PATIENCE_MS = 30_000  # for slow machines; what is waited for is there far sooner


def why_not() -> str:
    """Why no browser can be used; "" where one can."""
    if BROWSER is None:
        return "needs chromium (or google-chrome) on the path"
    return "" if find_spec("playwright") else "needs playwright"


only_with_browser = pytest.mark.skipif(bool(why_not()) and not REQUIRED, reason=why_not() or "a browser is there")


@contextmanager
def started_browser() -> Iterator[Any]:
    """A browser, closed at the end."""
    assert not why_not(), why_not()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as player:
        started = player.chromium.launch(executable_path=BROWSER, args=ARGUMENTS)
        yield started
        started.close()

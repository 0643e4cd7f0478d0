"""Linter and type checker find nothing: they run beside the other tests."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TYPES = ["pyrefly", "check", "--threads", "1", "--python-interpreter-path", sys.executable]


@pytest.mark.parametrize("words", [TYPES, ["ruff", "check", "."]], ids=["types", "lint"])
def test_nothing_is_found(words: list[str]) -> None:
    done = subprocess.run(
        [sys.executable, "-m", *words], cwd=ROOT, capture_output=True, text=True, encoding="utf-8", check=False
    )
    assert done.returncode == 0, f"{' '.join(words)}\n{done.stdout}{done.stderr}"

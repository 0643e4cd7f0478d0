"""Makes the helper modules of this folder importable by name; pytest imports tests without packages."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

HELPERS = (
    "small_catalogues",
    "scene_search",
    "brute_force",
    "random_cases",
    "one_of_each",
    "settable_cases",
    "hand_made_rows",
    "settings_attack",
    "population_cases",
    "front_cases",
)  # each needs only those before it

for name in HELPERS:
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
        assert spec is not None and spec.loader is not None
        sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])

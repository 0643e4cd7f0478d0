"""How much is drawn at random: little in every run, much before a release.

`UWOPT_THOROUGH=1 pytest -n 2` tries hundreds of random cases where the default run takes those few that show most.
"""

from __future__ import annotations

import os
from typing import TypeVar

T = TypeVar("T")
THOROUGH = bool(os.environ.get("UWOPT_THOROUGH"))


def drawn(default: T, thorough: T) -> T:
    """What the default run takes, or what the thorough run takes."""
    return thorough if THOROUGH else default

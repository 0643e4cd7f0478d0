"""Values of slow reference computations, kept as data, and worked out again wherever they might be others.

`python tests/kept_values.py` (two minutes) remakes tests/reference/full_physics.json: it runs the tests that ask for
the values, with none known. A kept value is taken only while the files that compute it and every table that they read
are those that it was made from; otherwise, and before a release (UWOPT_THOROUGH=1), each is worked out when asked for.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from thorough import THOROUGH

REMADE = "UWOPT_REMAKE_KEPT"  # set: nothing is known, and what is worked out is written
HINT = "the values are of other files or other tables: python tests/kept_values.py"


def mark_of(*made_of: Path) -> str:
    """A digest of the files that compute, and of the tables that they read."""
    digest = hashlib.sha256()
    for file in made_of:
        digest.update(file.read_bytes().replace(b"\r\n", b"\n"))
    return digest.hexdigest()[:16]


class Kept:
    """The kept values of some files that compute, and of the tables that they read."""

    def __init__(self, file: Path, *made_of: Path) -> None:
        self.file, self.made_of, self.mark = file, made_of, mark_of(*made_of)
        held = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
        self.is_current = held.get("of") == self.mark
        taken = self.is_current and not THOROUGH and REMADE not in os.environ
        self.known: dict[str, Any] = held["values"] if taken else {}

    def values(self, computes: Callable[[Any], Any]) -> Callable[[Any], Any]:
        """The function of one case, asked for what is kept first; whatever it works out is worked out once."""

        @cache
        def known_or_computed(case: Any) -> Any:
            key = f"{computes.__name__} {case!r}"
            if key not in self.known:
                found = computes(case)
                self.known[key] = list(found) if isinstance(found, tuple) else found
                if REMADE in os.environ:
                    self.write()
            return self.known[key]

        return known_or_computed

    def write(self) -> None:
        """All values, each with what it is of."""
        held = {"of": self.mark, "values": dict(sorted(self.known.items()))}
        self.file.write_text(json.dumps(held, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    tests = Path(__file__).parent / "evaluation" / "test_full_physics.py"
    command = [sys.executable, "-m", "pytest", "-q", "-k", "not that_are_kept", str(tests)]
    sys.exit(subprocess.run(command, env={**os.environ, REMADE: "1"}, check=False).returncode)

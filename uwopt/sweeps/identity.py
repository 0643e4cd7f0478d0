"""Which program and which catalogue: what decides answers beside a mission's own inputs, as hashes.

Workers on other machines must have the same; rows that another program or catalogue wrote are not taken for answers.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterable, Mapping
from functools import cache
from importlib import metadata
from pathlib import Path

import uwopt
from uwopt.catalog.tables import DATA_DIR
from uwopt.results.version import __version__

LIBRARIES = ("numpy", "scipy", "jerlov")  # that numbers of a search depend on
DECIDING = ("uwopt", "program", "catalogue")  # a row of another is worked out anew
BESIDE = ("report", "bench", "cli", "explore")  # rooms that no answer comes from


@cache
def program_identity() -> dict[str, str]:
    """Version, hashes of the program's text and of the catalogue's tables, and versions of what numbers depend on."""
    package = Path(uwopt.__file__).parent

    def room_of(path: Path) -> str:
        return path.relative_to(package).parts[0]

    return {
        "uwopt": __version__,
        "program": files_hash(
            package, (path for path in sorted(package.rglob("*.py")) if room_of(path) not in BESIDE)
        ),
        "catalogue": files_hash(DATA_DIR, sorted(path for path in DATA_DIR.rglob("*") if path.is_file())),
        "python": ".".join(map(str, sys.version_info[:2])),
        **{name: metadata.version(name) for name in LIBRARIES},
    }


def files_hash(root: Path, files: Iterable[Path]) -> str:
    """A hash of files by their names below a folder and what they hold; ends of lines do not count."""
    made = hashlib.blake2b(digest_size=8)
    for path in files:
        held = path.read_bytes().replace(b"\r\n", b"\n")
        made.update(f"{path.relative_to(root).as_posix()}\0{len(held)}\0".encode())
        made.update(held)
    return made.hexdigest()


def differences(here: Mapping[str, str], there: Mapping[str, str]) -> list[str]:
    """What is not the same in two places, in words."""
    names = {"program": "the program's text", "catalogue": "the catalogue's tables"}
    return [
        f"{names.get(key, key)} {there.get(key, 'none')} instead of {value}"
        for key, value in here.items()
        if there.get(key) != value
    ]

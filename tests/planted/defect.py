"""What a planted defect is, and the list of all of them."""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Defect:
    """A text of the program replaced by a wrong one, and the test that finds it.

    `old` stands exactly once in `file` (a path below the project); `test` is one pytest node id, or several of
    which each must fail.
    """

    name: str
    file: str
    old: str
    new: str
    test: str | tuple[str, ...]

    @property
    def tests(self) -> tuple[str, ...]:
        """The node ids as a tuple."""
        return (self.test,) if isinstance(self.test, str) else self.test

    def applied(self, text: str) -> str:
        """The file's text with the defect; an error when the patch does not fit."""
        if (found := text.count(self.old)) != 1:
            raise ValueError(
                f"{self.name}: its old text stands {found} times in {self.file}, it must stand once"
            )
        if self.old == self.new:
            raise ValueError(f"{self.name}: old and new text are the same")
        return text.replace(self.old, self.new)


def all_defects() -> tuple[Defect, ...]:
    """The defects of every area, in the order of the files' names."""
    areas = (
        importlib.import_module(f"{__package__}.{found.name}")
        for found in sorted(pkgutil.iter_modules([str(Path(__file__).parent)]), key=lambda found: found.name)
        if found.name not in ("defect", "run")
    )
    return tuple(defect for area in areas for defect in area.DEFECTS)

"""What missions and systems share as whole files: where they came from, and the paths that they name."""

from pathlib import Path
from typing import TypeVar

from pydantic import PrivateAttr

from uwopt.documents.key_types import Section
from uwopt.documents.reading import Document

AnyFile = TypeVar("AnyFile", bound="WholeFile")


class WholeFile(Section):
    """All keys of a file, and where it came from, which none of them tells."""

    _base_dir: Path | None = PrivateAttr(default=None)
    _source_name: str = PrivateAttr(default="")
    _source_text: str | None = PrivateAttr(default=None)

    @property
    def base_dir(self) -> Path | None:
        """Folder of the file; None when it came from Python."""
        return self._base_dir

    @property
    def source_name(self) -> str:
        """Name of the file, for messages; the kind of file when it came from Python."""
        return self._source_name

    def resolve_path(self, text: str | Path) -> Path:
        """A path that the file names; relative ones start at the file."""
        return resolve_path(text, self._base_dir)


def with_origin(made: AnyFile, document: Document, base_dir: Path | None = None) -> AnyFile:
    """What was made of a document, with where that came from; a mapping's files are looked for in `base_dir`."""
    made._base_dir, made._source_name = document.base_dir or base_dir, document.name
    made._source_text = document.text
    return made


def resolve_path(text: str | Path, base_dir: Path | None) -> Path:
    """A path as files mean it: relative to the folder of the file that names it."""
    path = Path(text)
    path = path.expanduser() if str(text).startswith("~") else path
    return path if path.is_absolute() or base_dir is None else base_dir / path

"""Open the page on this machine: what it begins with, and the address that it listens at."""

from __future__ import annotations

import ipaddress
from collections.abc import Iterator
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from uwopt.documents.reading import read_document
from uwopt.errors import MissionError, OutputError
from uwopt.explore import state as states
from uwopt.mission.mission import load_mission
from uwopt.mission.system import load_system

HERE, PORT = "127.0.0.1", 8050
OWN_NAMES = frozenset({HERE, "localhost", "::1"})


@dataclass(frozen=True)
class Served:
    """A page that answers once `serve_forever` is called."""

    url: str
    server: Any
    is_open_to_others: bool

    def serve_forever(self) -> None:
        """Answer until interrupted."""
        self.server.serve_forever()


def opening_state(mission: str | None = None, system: str | None = None) -> states.State:
    """What the page begins with: the founding paper's window, or files, each checked first."""
    made = deepcopy(states.OPENING)
    for name, what in ((mission, "mission"), (system, "system")):
        if name is None:
            continue
        (load_mission if what == "mission" else load_system)(name)
        document = read_document(name, what)
        data, files = with_own_files(document.data, document.base_dir or Path())
        made = states.with_mission(made, data) if what == "mission" else states.with_system(made, data)
        for file, text in files.items():
            made = states.with_file(made, file, text)
    return made


def with_own_files(data: dict[str, Any], folder: Path) -> tuple[dict[str, Any], dict[str, str]]:
    """A mission or system that names its files alone, without folders, and what they hold."""
    from uwopt.explore.outcome import replaced

    names = states.named_files(data)
    files: dict[str, str] = {}
    for name in sorted(names):
        path = Path(name).expanduser()
        path = path if path.is_absolute() else folder / path
        if path.name in files:
            raise MissionError(f"{name}: two files have this name; give one of them another for this page.")
        try:
            files[path.name] = path.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as fault:
            raise MissionError(f"{name}: cannot be read ({getattr(fault, 'strerror', None) or fault}).") from None
    made: dict[str, Any] = replaced(data, lambda text: Path(text).name if text in names else text)
    return made, files


@contextmanager
def served(opening: states.State, *, host: str = HERE, port: int = PORT) -> Iterator[Served]:
    """The page at an address; port 0 takes a free one. Nothing is told of requests, and nothing is debugged."""
    import logging

    from werkzeug.serving import make_server

    from uwopt.explore.server import Explorer

    others = not is_loopback(host)
    explorer = Explorer(opening, host, None if others else OWN_NAMES | {host})
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    try:
        server = make_server(host, port, explorer.app.server, threaded=True)
    except (OSError, SystemExit) as fault:
        explorer.close()
        raise OutputError(
            f"{host}:{port}: cannot be listened at; it is in use, or no address of this machine. Choose another --port."
        ) from fault
    shown = f"[{host}]" if ":" in host else host
    try:
        yield Served(f"http://{shown}:{server.server_port}/", server, others)
    finally:
        server.server_close()
        explorer.close()


def is_loopback(host: str) -> bool:
    """Whether nobody but this machine reaches an address."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"

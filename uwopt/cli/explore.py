"""The command `uwopt explore`: a page with every control, served on this machine."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Annotated

import typer

from uwopt.cli.options import QuietOption
from uwopt.cli.status import BAD_INPUT, DONE, command, print_notice


@command
def explore_command(
    mission: Annotated[
        str | None, typer.Argument(metavar="[MISSION]", help="Mission file (YAML); the paper's window unless given.")
    ] = None,
    system: Annotated[str | None, typer.Argument(metavar="[SYSTEM]", help="System file (YAML).")] = None,
    port: Annotated[
        int, typer.Option(metavar="N", min=0, max=65535, help="Port to listen at; 0 takes a free one.")
    ] = 8050,
    host: Annotated[
        str, typer.Option(metavar="ADDRESS", help="Interface to listen at; one that others reach lets them in.")
    ] = "127.0.0.1",
    browser: Annotated[bool, typer.Option("--open", help="Open it in the browser.")] = False,
    quiet: QuietOption = False,
) -> int:
    """Serve a page that explores the design space: every control and figure, and the certified search."""
    if find_spec("dash") is None:
        return print_notice("uwopt explore needs Dash: .venv/bin/pip install '.[explore]' in uwopt's folder", BAD_INPUT)
    from uwopt.explore.serve import opening_state, served

    with served(opening_state(mission, system), host=host, port=port) as page:
        if page.is_open_to_others:
            print_notice(
                f"warning: {host} is no address of this machine alone. Whoever reaches it can use this page, load "
                "files into it and keep this machine busy; there is no password.", DONE,
            )  # fmt: skip
        if not quiet:
            print_notice(f"uwopt explore: {page.url}  (Ctrl-C ends it)", DONE)
        if browser:
            import webbrowser

            webbrowser.open(page.url)
        try:
            with ended_by_signals():
                page.serve_forever()
        except KeyboardInterrupt:
            return DONE
    return DONE


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """SIGINT and SIGTERM end what runs as Ctrl-C does, also where a script's background has the former ignored."""
    before = {one: signal.signal(one, signal.default_int_handler) for one in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)

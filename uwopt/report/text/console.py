"""Text on its way to a terminal, a pipe or a file: width, colour, encoding, and the progress bar."""

from __future__ import annotations

import contextlib
import io
import json
import os
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict
from types import TracebackType
from typing import TYPE_CHECKING, Any, TextIO

from uwopt.errors import OutputError
from uwopt.report.text import formats
from uwopt.report.text.layout import SOLID

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.progress import Progress

PIPE_WIDTH = 100
NARROWEST = 60
PATIENCE_S = 1.0  # what takes less shows no bar
LINE_EVERY_S = 10.0  # in a pipe or a log, where there is no bar
Timer = Callable[[float, Callable[[], None]], threading.Timer]


def print_blocks(
    blocks: Iterable[RenderableType], stream: TextIO | None = None, *, said: Callable[[str], str] = str
) -> None:
    """Print rich text, in other words by `said`: in colour and as wide as the terminal, else plain and 100 wide."""
    from rich.console import Console

    out = stream or sys.stdout
    terminal = is_terminal(out)
    rendered = io.StringIO()
    console = Console(
        file=rendered,
        width=max(NARROWEST, shutil.get_terminal_size().columns) if terminal else PIPE_WIDTH,
        color_system="auto" if terminal else None,
        force_terminal=terminal,
        markup=False,
        highlight=False,
        emoji=False,
        legacy_windows=False,
    )
    for block in blocks:
        console.print(block)
    text = rendered.getvalue().replace(SOLID, " ")
    lines = [line.rstrip() for line in said(text).split("\n")]
    print_text("\n".join(lines).rstrip("\n"), out)


def print_text(text: str, stream: TextIO | None = None) -> None:
    """Print text with only the signs that the stream can show; raises OutputError when it takes no more."""
    out = stream or sys.stdout
    if out is None:  # closed before we started
        raise OutputError("standard output is closed; give --out, or redirect it to a file.")
    try:
        out.write(formats.in_encoding(text, out.encoding or "utf-8") + "\n")
        out.flush()
    except OSError as fault:
        discard_rest(out)
        if isinstance(fault, BrokenPipeError):
            raise
        raise OutputError(f"standard output cannot be written ({fault.strerror or fault}).") from None


def print_json(value: Any) -> None:
    """Print dataclasses and plain values as JSON."""
    print_text(json.dumps(value, indent=1, default=asdict))


def discard_rest(stream: TextIO) -> None:
    """Let what is still in the stream's buffer go nowhere, or Python fails on it again at its end."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def is_terminal(stream: TextIO | None) -> bool:
    """Whether a person sees this stream as it is written."""
    try:
        return stream is not None and stream.isatty()
    except ValueError:  # closed
        return False


class ProgressBar:
    """A bar on the error stream for what takes longer than a second; in a pipe a line a stage, at most one a second,
    and one every ten seconds.

    Use as a context; `report` is the callback that a search calls with its share done and what it does.

    of_all : whether a share is one of all there is to do, and never falls back; else it is of the step that is named,
        which the bar does not show: nobody knows how many steps follow
    """

    def __init__(
        self, *, quiet: bool = False, of_all: bool = False, timer: Timer = threading.Timer,
        clock: Callable[[], float] = time.monotonic,
    ):  # fmt: skip
        self._of_all = of_all
        self._wanted = not quiet and sys.stderr is not None
        self._piped = self._wanted and not is_terminal(sys.stderr)
        self._new_timer = timer
        self._share, self._what = 0.0, ""
        self._lock = threading.Lock()
        self._bar: Progress | None = None
        self._clock, self._start_s = clock, clock()
        self._told, self._told_s = "", self._start_s  # the last line in a pipe, and when
        self._timer: threading.Timer | None = None

    @property
    def report(self) -> Callable[[float, str], None] | None:
        """The callback, None when no bar is wanted."""
        return self._report if self._wanted else None

    def __enter__(self) -> ProgressBar:
        if self._wanted and is_terminal(sys.stderr):
            self._wait(PATIENCE_S, self._show)
        elif self._wanted:
            self._wait(LINE_EVERY_S, self._line)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._lock:
            self._wanted = False
            if self._timer is not None:
                self._timer.cancel()
            if self._bar is not None:
                self._bar.stop()
                self._bar = None

    @contextlib.contextmanager
    def aside(self) -> Iterator[None]:
        """No bar on the terminal for as long as something is printed there."""
        with self._lock:
            if self._bar is not None:
                self._bar.stop()
            yield
            if self._bar is not None:
                self._bar.start()

    def line(self, text: str) -> None:
        """A line on the error stream that stays there, where a bar is wanted."""
        if self._wanted:
            with self.aside(), contextlib.suppress(OSError, ValueError):  # nobody reads it
                spent_s = self._clock() - self._start_s
                print(f"uwopt: {text} ({spent_s:.0f} s)", file=sys.stderr, flush=True)

    def _wait(self, seconds: float, then: Callable[[], None]) -> None:
        self._timer = self._new_timer(seconds, then)
        self._timer.daemon = True
        self._timer.start()

    def _line(self) -> None:
        with self._lock:
            if not self._wanted:
                return
            self._tell()
            self._wait(LINE_EVERY_S, self._line)

    def _tell(self) -> None:
        """A line for a pipe."""
        self._told, self._told_s = self._what, self._clock()
        spent_s = self._told_s - self._start_s
        with contextlib.suppress(OSError, ValueError):  # nobody reads it
            print(f"uwopt: {self._said()}, {spent_s:.0f} s", file=sys.stderr, flush=True)

    def _said(self) -> str:
        """What is done, and how much of it where that is known: at its end a step has more to do than was counted."""
        share = f"{100 * self._share:.0f} %"
        known = self._share and share != "100 %"
        done = f", {share}{'' if self._of_all else ' of this step'}" if known else ""
        return f"{self._what or 'working'}{done}"

    def _show(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        with self._lock:
            if not self._wanted:
                return
            self._bar = Progress(
                TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn(),
                console=Console(stderr=True, legacy_windows=False), transient=True,
            )  # fmt: skip
            self._bar.add_task("", total=1.0 if self._of_all else None)
            self._draw(self._bar)
            self._bar.start()

    def _draw(self, bar: Progress) -> None:
        bar.update(bar.task_ids[0], completed=self._share, description=self._what if self._of_all else self._said())

    def _report(self, share: float, what: str) -> None:
        with self._lock:
            self._share, self._what = min(max(share, self._share if self._of_all else 0.0), 1.0), what
            if self._bar is not None:
                self._draw(self._bar)
            elif self._piped and what != self._told and self._clock() - self._told_s >= PATIENCE_S:
                self._tell()

"""Work side by side: in copies of this process, so that every core of the machine is of use.

The works are handed out one by one to whoever is free, this process or a copy; what a copy makes is sent back. Copies
are made only inside `with cores(n)`, as the command line does: of a process with other threads, as a notebook or a
server has them, a copy may wait for ever for what one of these held. Where copies are not made, or the system makes
none well (only Linux does: on macOS a copy's libraries may fail), the works are done one after another.

Works must not need each other, nor tell a progress bar of theirs, but what they `tell` is heard here as they go on, so
that it is known even where a person wants no more. What they count (`deadline.effort_s`) and append to `lists` counts
here too, and each begins with the effort of when it might have begun, not with that of those that went
before on a single core: so that nobody can tell from the answer where it was worked out.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextvars import ContextVar
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Never

from uwopt.deadline import add_effort, effort_s, go_on_from, processor_s

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

MOST_CORES = 4  # each copy may need a few hundred MB
SHARES = 2  # of a work that is shared out, on every machine, so that its answer is the same; more would be dearer
NUMBER = 4  # bytes of a work's number; as many as a pipe holds may wait, which is some ten thousand
COPIES = "linux" in sys.platform  # whether the system makes copies of a process that work
Hears = Callable[[Any], object]


def no_one_hears(thing: Any) -> None:
    """What works tell, where nobody wants to know."""


_CORES: ContextVar[int] = ContextVar("cores", default=1)
_HEARS: ContextVar[Hears] = ContextVar("hears", default=no_one_hears)


@contextlib.contextmanager
def cores(count: int | None = None) -> Iterator[None]:
    """Where works are done on so many cores; None: on as many as this process may use, up to four."""
    wanted = min(usable_cores() if count is None else count, MOST_CORES)
    token = _CORES.set(wanted if COPIES else 1)
    try:
        yield
    finally:
        _CORES.reset(token)


def usable_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if COPIES else os.cpu_count() or 1


def tell(thing: Any) -> None:
    """Let who waits for the works know something of this one, wherever it is done."""
    _HEARS.get()(thing)


def side_by_side(
    works: Sequence[Callable[[], Any]], *, lists: Sequence[list[Any]] = (), begins: Callable[[int], object] = int,
    hears: Hears = no_one_hears,
) -> list[Any]:  # fmt: skip
    """What each of these makes, in their order; those that last longest are best named first.

    This process does the first itself, so that it is known of that how far it came when a person wants no more.
    What a work raises is raised here, that of the first such work. `lists`: what the works append to, in order.
    `begins`: called with the number of each work that this process does, and of that which it waits for in the end.
    `hears`: called with what works `tell`: of those in copies as often as one here does, while they are waited for, and
    when a person interrupts. What a copy did that the system has ended is told again.
    """
    if not works:
        return []
    queue = _Queue(range(1, len(works)))
    copies = [_Copy(works, queue, lists) for _ in range(min(_CORES.get(), len(works)) - 1)]
    made: dict[int, _Done] = {}

    def heard(thing: Any) -> None:
        hears(thing)
        for copy in copies:
            copy.hear(hears)

    token = _HEARS.set(heard)
    try:
        begins(0)
        made = {0: _Done.of(works[0], lists), **queue.done(works, lists, begins)}
        for awaited in sorted(set(range(len(works))) - made.keys())[-1:]:  # begun last by whoever else is at work
            begins(awaited)
        for copy in copies:
            made |= copy.answer(heard)
    finally:
        queue.close()
        for copy in copies:
            copy.hear(hears)
            copy.end()
        _HEARS.reset(token)
    for place, work in enumerate(works):
        if place not in made:  # of a copy that the system has ended
            made[place] = _Done.of(work, lists)
    for one in (made[place] for place in range(len(works))):
        one.take_over(lists)
    return [made[place].value for place in range(len(works))]


def shares(count: int, least: int) -> list[slice]:
    """Places of so many things in one or two shares for `side_by_side`, of `least` or more where there are two."""
    parts = min(max(count // least, 1), SHARES)
    ends = [count * place // parts for place in range(parts + 1)]
    return [slice(start, end) for start, end in pairwise(ends)]


@contextlib.contextmanager
def ahead(work: Callable[[], Any], *, lists: Sequence[list[Any]] = ()) -> Iterator[Callable[[], Any]]:
    """A work that may be wanted: gives what makes it, or what a copy has made of it meanwhile, if there is a core.

    What is not asked for is ended and not counted. `lists`: what it appends to.
    """
    begun_s = effort_s()

    def asked_of(copy: _Copy | None) -> Any:
        made = {} if copy is None else copy.answer(no_one_hears)
        done = made[0] if made else _Done.of(work, lists, begun_s)
        done.take_over(lists)
        return done.value

    if _CORES.get() < 2:
        yield partial(asked_of, None)
        return
    queue = _Queue(range(1))
    copy = _Copy([work], queue, lists)

    try:
        yield partial(asked_of, copy)
    finally:
        queue.close()
        copy.end()


class _Done:
    """What a work made or raised, what it appended to some lists, and the effort that it counted."""

    def __init__(self, value: Any, fault: Exception | None, added: list[list[Any]], spent_s: float):
        self.value, self.fault, self.added, self.spent_s = value, fault, added, spent_s

    @classmethod
    def of(cls, work: Callable[[], Any], lists: Sequence[list[Any]], begun_s: float | None = None) -> _Done:
        """Do a work; what it appends is taken off the lists again, for `take_over` to append in order.

        begun_s : effort at which a copy would have begun; None: now
        """
        sizes, now_s = [len(one) for one in lists], effort_s()
        before_s = now_s if begun_s is None else begun_s
        add_effort(before_s - now_s)
        value, fault = None, None
        try:
            value = work()
        except Exception as raised:
            fault = raised
        spent_s = effort_s() - before_s
        add_effort(now_s - before_s - spent_s)
        added = [one[size:] for one, size in zip(lists, sizes, strict=True)]
        for one, size in zip(lists, sizes, strict=True):
            del one[size:]
        return cls(value, fault, added, spent_s)

    def take_over(self, lists: Sequence[list[Any]]) -> None:
        """Count and append it here, and raise what was raised."""
        add_effort(self.spent_s)
        for one, new in zip(lists, self.added, strict=True):
            one.extend(new)
        if self.fault is not None:
            raise self.fault


class _Queue:
    """The numbers of works that nobody has begun: a pipe from which this process and its copies take one at a time."""

    def __init__(self, numbers: range):
        self._source, sink = os.pipe()
        os.write(sink, b"".join(number.to_bytes(NUMBER, "big") for number in numbers))
        os.close(sink)

    def done(
        self, works: Sequence[Callable[[], Any]], lists: Sequence[list[Any]], begins: Callable[[int], object] = int
    ) -> dict[int, _Done]:
        """Do works until none is left."""
        made = {}
        while taken := os.read(self._source, NUMBER):
            number = int.from_bytes(taken, "big")
            begins(number)
            made[number] = _Done.of(works[number], lists)
        return made

    def close(self) -> None:
        """Let go of the pipe."""
        os.close(self._source)


class _Copy:
    """A copy of this process that does works from the queue, and sends what they tell and what they made."""

    def __init__(self, works: Sequence[Callable[[], Any]], queue: _Queue, lists: Sequence[list[Any]]):
        from multiprocessing.connection import Pipe

        self._source, sink = Pipe(duplex=False)
        self._reads = True  # from the beginning of what it sends next
        self._made: dict[int, _Done] | None = None
        begun_s = processor_s()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of other threads: the progress bar's, which waits
            self._process = os.fork()
        if not self._process:
            self._work(works, queue, lists, sink, begun_s)
        sink.close()

    def _work(
        self, works: Sequence[Callable[[], Any]], queue: _Queue, lists: Sequence[list[Any]],
        sink: Connection[Any, Any], begun_s: float,
    ) -> Never:  # fmt: skip  # pyrefly: ignore[bad-return]
        """What the copy does: it returns nowhere, runs no handler of its end and writes to no stream."""
        status = 1
        try:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # whom a person interrupts ends its copies
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
            self._source.close()
            _CORES.set(1)
            _HEARS.set(lambda thing: sink.send((True, thing)))
            go_on_from(begun_s)
            sink.send((False, queue.done(works, lists)))
            status = 0
        finally:
            os._exit(status)

    def hear(self, hears: Hears, *, wait: bool = False) -> None:
        """Take what it has told by now; wait: until all that it does is made, or it has ended."""
        while self._reads and self._made is None and (wait or self._source.poll()):
            self._reads = False
            try:
                is_told, thing = self._source.recv()
            except (EOFError, OSError, pickle.UnpicklingError):
                return
            self._reads = True
            if is_told:
                hears(thing)
            else:
                self._made = thing

    def answer(self, hears: Hears) -> dict[int, _Done]:
        """What it made, once it has; nothing where it could not send it."""
        self.hear(hears, wait=True)
        return self._made or {}

    def end(self) -> None:
        """End it, done or not."""
        self._source.close()
        with contextlib.suppress(ProcessLookupError):
            os.kill(self._process, signal.SIGKILL)
        os.waitpid(self._process, 0)

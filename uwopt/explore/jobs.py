"""Work in the background: a search, a trade-off, what-ifs or doubts of what a tab shows, each in a process of its own.

A process can be told to stop at any time and keeps what it has found, as Ctrl-C has it on the command line.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import secrets
import signal
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from uwopt.errors import MissionError, UwoptError
from uwopt.explore.state import State, shown_system

if TYPE_CHECKING:
    from uwopt.results.design import Design

MOST_AT_ONCE = 2
KEPT_S = 3600.0  # a job that nobody asks after
GOOD_BYE_S = 20.0  # that a stopped search has for handing over what it found
PINS = {
    "camera": "the camera", "lens": "the lens", "port": "the port", "light": "the lamps",
    "orientation": "the orientation", "light_count": "the number of lamps", "places": "the places of the lamps",
    "f_number": "the f-number", "exposure_ms": "the exposure", "gain": "the gain", "dim_frac": "the light level",
}  # fmt: skip
PLACE_KEYS = ("light_mounts", "light_baseline_m", "light_tilt_deg")
OF_SETTINGS = ("f_number", "exposure_ms", "gain", "dim_frac")
DIGITS = {"exposure_ms": ".3f"}  # cameras are set in microseconds
#: What a part is called in the catalog section of a mission.
PATTERNS = {"camera": "cameras", "lens": "lenses", "port": "ports", "light": "lights"}


def pinned(state: State, pins: Sequence[str], design: Design | None = None) -> dict[str, Any]:
    """The mission in which what is pinned of the shown system is the only choice; raises where that cannot be said.

    design : of the system, as `evaluate` has it, where settings or places of lamps are pinned
    """
    system = shown_system(state)
    mission = dict(state["mission"])
    catalog, vehicle = dict(mission.get("catalog") or {}), dict(mission.get("vehicle") or {})
    faults = []
    for kind in (kind for kind in PATTERNS if kind in pins):
        if isinstance(system.get(kind), str):
            catalog[PATTERNS[kind]] = [system[kind]]
        else:
            faults.append(
                f"pin the {kind}: own numbers are no part of the catalogue; choose one by its name, or load it as a "
                "file of own parts"
            )
    fixed = dict(mission.get("fixed") or {})
    for name in (name for name in OF_SETTINGS if name in pins):
        values = values_set(design, name)
        if len(values) == 1:
            fixed[name] = float(values[0])
        else:
            why = f"scenes have {' and '.join(values)}; make it alike in all, then pin it" if values else "none is set"
            faults.append(f"pin {PINS[name]}: {why}")
    if faults:
        raise MissionError(faults)
    if "orientation" in pins:
        vehicle["orientation"] = system.get("orientation", "landscape")
    if "light_count" in pins:
        vehicle["light_count"] = system.get("light_count", 1)
    if "places" in pins:
        stated = {key: system[key] for key in PLACE_KEYS if system.get(key) is not None}
        if not stated and design is not None:
            stated = {"light_mounts": [asdict(place) for place in design.hardware.light_mounts]}
        vehicle = {key: value for key, value in vehicle.items() if key not in PLACE_KEYS} | stated
    sections = {"catalog": catalog, "fixed": fixed}
    return {**mission, **{name: one for name, one in sections.items() if one}, "vehicle": vehicle}


def values_set(design: Design | None, name: str) -> list[str]:
    """A setting of all scenes, each value once, as it is typed."""
    given = [] if design is None else [scene.settings.get(name) for scene in design.scenes]
    return sorted({format(value, DIGITS.get(name, ".6g")) for value in given if value is not None})


# ---------------------------------------------------------------- what runs


def optimise(mission: Any, system: Any, vary: str, progress: Callable[[float, str], None]) -> dict[str, Any]:
    """The certified search; what it recommends, as a system."""
    import uwopt

    result = uwopt.solve(mission, progress=progress)
    best = result.recommendation
    return {"result": result, "system": None if best is None else best.as_system()}


def trade(mission: Any, system: Any, vary: str, progress: Callable[[float, str], None]) -> dict[str, Any]:
    """The front."""
    import uwopt

    return {"result": uwopt.pareto(mission, objectives=["power", "cost"], progress=progress)}


def vary_keys(mission: Any, system: Any, vary: str, progress: Callable[[float, str], None]) -> dict[str, Any]:
    """The optimum over values of a key."""
    import uwopt

    key, sign, values = vary.partition("=")
    if not sign:
        raise MissionError(
            f"what if: {vary[:60]!r} is no key with values; write such as speed_m_s=0.2:2:5 or water=I,II"
        )
    return {"result": uwopt.whatif(mission, {key: values}, progress=progress)}


def doubted(mission: Any, system: Any, vary: str, progress: Callable[[float, str], None]) -> dict[str, Any]:
    """In how many scenarios the shown system holds."""
    import uwopt

    return {"result": uwopt.evaluate(mission, system, confidence=0.9)}


def mapped(mission: Any, system: Any, vary: str, progress: Callable[[float, str], None]) -> dict[str, Any]:
    """A figure over two inputs: its name, and each input with its values, a line each."""
    from uwopt.explore.plotting import plot

    figure, *lines = (line.strip() for line in vary.split("\n"))
    inputs = {}
    for line in lines:
        key, sign, values = line.partition("=")
        if not sign:
            raise MissionError(
                f"map: {line[:60]!r} is no input with values; write such as speed_m_s=0.2:2:8 or f_number=2,4,8"
            )
        inputs[key.strip()] = values
    made = plot("map", mission, system, inputs=inputs, figure=figure, progress=progress)
    return {"picture": made.pictures[0], "report": made.html()}


PINNED_JOBS = ("optimise", "trade", "whatif")
STOPPED = ("fault", "stopped before there was a result", None, "")
Work = Callable[[Any, Any, str, Callable[[float, str], None]], dict[str, Any]]
JOBS: Mapping[str, tuple[str, Work]] = {
    "optimise": ("Optimise the rest", optimise), "trade": ("Trade off power and cost", trade),
    "whatif": ("What if", vary_keys), "doubt": ("How certain is this system", doubted),
    "map": ("Draw the map", mapped),
}  # fmt: skip


def run(kind: str, mission: Any, system: Any, vary: str, line: Any) -> None:
    """The process: progress and one last word go through the line."""
    last = 0.0

    def progress(share: float, what: str) -> None:
        nonlocal last
        if time.monotonic() - last > 0.1:
            last = time.monotonic()
            line.send(("progress", share, what))

    signal.signal(signal.SIGINT, signal.default_int_handler)  # a script's background has it ignored
    line.send(("progress", 0.0, "begun"))
    try:
        made = JOBS[kind][1](mission, system, vary, progress)
        if "picture" in made:
            line.send(("done", made["picture"], None, made["report"]))
        else:
            line.send(("done", summary(made["result"]), made.get("system"), report(made["result"])))
    except UwoptError as fault:
        line.send(("fault", str(fault), None, ""))
    except KeyboardInterrupt:
        line.send(STOPPED)


def summary(result: Any) -> list[str]:
    """What a page says of a result first."""
    from uwopt.results.whatif import WhatIf

    if isinstance(result, WhatIf):
        from uwopt.report.text.whatif_tables import opening

        return list(opening(result))
    from uwopt.report.text.verdict import verdict

    lines = list(verdict(result))
    counted = getattr(result, "confidence", None)
    if counted is not None:
        from uwopt.report.text.certainty import status_text

        lines.append(status_text(counted, result.status))
    return lines


def report(result: Any) -> str:
    """Its page."""
    from uwopt.report.write import page_text

    return page_text(result)


# ---------------------------------------------------------------- from outside


@dataclass
class Job:
    """A process and what it has said so far."""

    kind: str
    process: Any
    line: Any
    share: float = 0.0
    what: str = "starting"
    done: tuple[str, Any, Any, str] | None = None  # how it ended, what is said or drawn of it, a system, a page
    is_handed_over: bool = False  # its tab has what it found
    is_up: bool = False  # the process has begun to listen to signals
    stopped_at: float | None = None
    seen: float = field(default_factory=time.monotonic)

    def listen(self) -> None:
        """Take in what the process has said."""
        self.seen = time.monotonic()
        with contextlib.suppress(EOFError, OSError):
            while self.done is None and self.line.poll():
                word = self.line.recv()
                self.is_up = True
                if word[0] == "progress":
                    self.share, self.what = word[1], word[2]
                else:
                    self.done = word
        if self.done is None and not self.process.is_alive():
            self.done = ("fault", "the work ended without a result", None, "")
        if self.done is None and self.stopped_at is not None and time.monotonic() - self.stopped_at > GOOD_BYE_S:
            self.process.kill()

    def stop(self) -> None:
        """Ask it to hand over what it has found; one that has not begun is ended."""
        if self.done is not None or self.stopped_at is not None or not self.process.is_alive():
            return
        self.stopped_at, self.what = time.monotonic(), "stopping"
        if self.is_up:
            os.kill(self.process.pid, signal.SIGINT)
        else:
            self.process.kill()
            self.done = STOPPED


@dataclass
class Jobs:
    """All jobs by a name that only their tab knows."""

    known: dict[str, Job] = field(default_factory=dict)
    lock: threading.Lock = field(default_factory=threading.Lock)

    def start(self, kind: str, mission: Any, system: Any, vary: str) -> str:
        """Begin; raises where too many run."""
        with self.lock:
            self._forget()
            if sum(job.process.is_alive() for job in self.known.values()) >= MOST_AT_ONCE:
                raise MissionError(f"{MOST_AT_ONCE} pieces of work run already; wait for one, or cancel it.")
            here = multiprocessing.get_context("spawn")
            ours, theirs = here.Pipe(duplex=False)
            process = here.Process(target=run, args=(kind, mission, system, vary, theirs), daemon=True)
            process.start()
            theirs.close()
            name = secrets.token_urlsafe(16)
            self.known[name] = Job(kind, process, ours)
            return name

    def get(self, name: str | None) -> Job | None:
        """A job with what it has said by now."""
        with self.lock:
            job = self.known.get(name or "")
            if job is not None:
                job.listen()
            return job

    def close(self) -> None:
        """End what still runs."""
        for job in self.known.values():
            if job.process.is_alive():
                job.process.kill()

    def _forget(self) -> None:
        old = [name for name, job in self.known.items() if time.monotonic() - job.seen > KEPT_S]
        for name in old:
            job = self.known.pop(name)
            if job.process.is_alive():
                job.process.kill()

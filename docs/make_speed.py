"""Measure how fast uwopt is and print tables; with --write also into docs/speed.md.

    python docs/make_speed.py [--write] [--quick] [--note TEXT] [--before REVISION]

Of whole commands the clock's seconds are told, beside those of an earlier revision. All other numbers are medians of
processor time, which a busy machine lengthens less than the clock's; stages are shares of it by the clock. Where two
things are compared, the ratio is of the same run. No test depends on them.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "docs")]

from speed_commands import measured  # noqa: E402

import uwopt  # noqa: E402
from uwopt.bench.machine import processor  # noqa: E402
from uwopt.catalog.choose import ToBeMade  # noqa: E402
from uwopt.deadline import Deadline  # noqa: E402
from uwopt.errors import MissionError  # noqa: E402
from uwopt.evaluation.design_model import DesignModel  # noqa: E402
from uwopt.evaluation.influences import influences_of  # noqa: E402
from uwopt.forward.assembly import build_problem, load_catalog, selected  # noqa: E402
from uwopt.forward.designs import Hardware, SceneSettings  # noqa: E402
from uwopt.forward.effects import effects_kept  # noqa: E402
from uwopt.forward.figures import DesignRows, SettingRows, figures_of  # noqa: E402
from uwopt.forward.problem import Problem  # noqa: E402
from uwopt.mission.mission import Mission, load_mission  # noqa: E402
from uwopt.model.effects import Effects  # noqa: E402
from uwopt.objectives.axes import Axes  # noqa: E402
from uwopt.solvers.front.search import Front, FrontSearch  # noqa: E402
from uwopt.solvers.population.evaluator import focus_maps  # noqa: E402

PROBLEMS = ROOT / "problems"
REEF = PROBLEMS / "reef-mosaic.yaml"
MISSIONS = sorted(p for p in PROBLEMS.glob("*.yaml") if not p.stem.endswith(".system"))
LIBRARIES = ("numpy", "scipy", "casadi", "nlopt", "pydantic", "jerlov")
Row = Sequence[str]
N_DESIGNS = 100
MANY = 8000  # settings of these whose figures are asked for at once
SETTINGS_A_DESIGN = 4
CLEAR = {
    "scene": {"water": "I", "seafloor": 0.3, "depth_m": 100.0},
    "vehicle": {"altitude_m": 0.4, "speed_m_s": 0.1, "light_baseline_m": 0.5},
    "requirements": {"overlap": 0.5, "max_blur_px": 1.0, "min_dof_m": 0.05, "min_snr_db": 25.0},
}  # no veil is kept: clear water at short range
SCENES: list[tuple[str, Any, float]] = [
    ("clear water, 0.4 m", CLEAR, 0.01),
    ("reef-mosaic", REEF, 0.005),
    ("usgs-squid5", PROBLEMS / "usgs-squid5.yaml", 0.005),
]
FRONTS = (("power", "cost", "information"), ("power", "cost", "snr_db"))
LONGEST_FRONT_S = 120.0


def open_reef(folder: Path) -> Path:
    """The reef mission with no choice of makers: every part of the catalogue may be taken."""
    text = REEF.read_text(encoding="utf-8").replace(
        'cameras: ["flir", "allied*", "basler"]', "generic: never"
    )
    path = folder / "reef-mosaic, any maker.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def search_table(repeats: int) -> list[str]:
    """Search over the built-in catalogue in process, by mission and physics."""
    rows, slower = [], []
    with tempfile.TemporaryDirectory() as folder:
        for path in [*MISSIONS, open_reef(Path(folder))]:
            seconds = {}
            for physics in ("paper", "full"):
                runs = [solved(path, physics) for _ in range(repeats)]
                rows.append(search_row(path.stem, physics, runs))
                seconds[physics] = median(timing["search"] for _, timing in runs)
            slower.append(seconds["full"] / seconds["paper"])
    return [
        "## Search, in process",
        "",
        "*search*: tables, bounds and proof over the parts that the mission allows (parts that are sold, unless it",
        "allows parts to be made). *to be made*: the further search with them, where it is only a fallback.",
        "*whole call*: also evaluation, robustness and a second opinion. *loaded* counts all combinations of the",
        f"catalogue that the certificate accounts for. Medians of {repeats}.",
        "",
        *table(
            ["mission", "physics", "search s", "to be made s", "whole call s", "loaded", "loaded / search s"],
            rows,
        ),
        "",
        f"Physics full against paper, same run: search {median(slower):.1f} times as long (median of missions).",
    ]


def solved(path: Path, physics: str) -> tuple[Any, dict[str, float]]:
    """A result, and the processor time of its stages: by the clock's shares of the whole."""
    start = time.process_time()
    result = uwopt.solve(path, physics=physics)
    share = (time.process_time() - start) / result.timing_s["total"]
    return result, {stage: share * seconds for stage, seconds in result.timing_s.items()}


def search_row(name: str, physics: str, runs: Sequence[tuple[Any, dict[str, float]]]) -> Row:
    """One mission in one physics; medians over the runs."""

    def middle(key: str) -> float | None:
        values = [timing[key] for _, timing in runs if key in timing]
        return median(values) if values else None

    search_s, generic_s = middle("search") or 0.0, middle("search_generic")
    loaded = runs[0][0].certificate.loaded
    return [
        name, physics, f"{search_s:.2f}", "-" if generic_s is None else f"{generic_s:.2f}",
        f"{middle('total'):.2f}", f"{loaded:.2e}", f"{loaded / search_s:.1e}",
    ]  # fmt: skip


def physics_table(repeats: int) -> list[str]:
    """Physics `full` and `auto` of the same designs."""
    rows: list[Row] = []
    for name, mission, tolerance in SCENES:
        c = compare(mission, tolerance=tolerance, repeats=repeats)
        rows.append(
            [
                name, f"{tolerance:g}", ", ".join(c.kept) or "nothing", f"{c.full_s:.2f}", f"{c.auto_s:.2f}",
                f"{c.full_s / c.auto_s:.2f}", f"{c.designs_per_s / 1e6:.2f}", f"{c.paper_per_s / 1e6:.2f}",
            ]
        )  # fmt: skip
    return [
        "## Physics `full` and `auto`",
        "",
        f"{N_DESIGNS} designs drawn from the catalogue, 2 lamps, one after another: hardware integrals and figures",
        "together; both physics in turn in one run. Last columns: figures of all requirements once hardware is",
        f"tabulated, of {MANY} designs at once, settings at random. Where full / auto is below 1, judging what a",
        "design does not need takes longer than its whole physics: `auto` then saves no time, and tells what matters.",
        "",
        *table(
            ["scene", "tolerance", "kept by auto", "full s", "auto s", "full / auto", "10⁶ designs/s, full", "paper"],
            rows,
        ),
    ]


@dataclass(frozen=True)
class Comparison:
    """One scene: seconds of all designs in both physics, and the forward model's rate with tables built."""

    kept: tuple[str, ...]
    full_s: float
    auto_s: float
    designs_per_s: float  # full, tables built, all requirement figures
    paper_per_s: float  # the same in paper


def compare(mission: Any, *, tolerance: float, repeats: int) -> Comparison:
    """Time both physics over the same designs."""
    loaded = load_mission(mission).with_changes(physics="full", tolerance=tolerance)
    selection = selected(loaded, load_catalog(loaded), generic="never")
    problem, plain = (build_problem(one, selection) for one in (loaded, loaded.with_changes(physics="paper")))
    designs, settings = drawn(problem, np.random.default_rng(0))
    each = [settings.take(np.array([place])) for place in range(N_DESIGNS)]
    given = [[SceneSettings(*(float(column[0]) for column in vars(one).values()))] for one in each]

    def full() -> None:
        whole = problem.with_effects(problem.effects)  # of which no light is known
        for hardware, one in zip(designs, each, strict=True):
            DesignModel(whole, hardware).figures(0, one)

    def auto() -> None:
        for hardware, one, set_so in zip(designs, each, given, strict=True):
            kept = effects_kept(influences_of(problem, hardware, set_so))
            DesignModel(problem.with_effects(kept), hardware).figures(0, one)

    tasks = (full, auto, *(tabulated(one, designs, settings) for one in (problem, plain)))
    for task in tasks:  # path tables are built once a scene, whichever physics
        task()
    times = [[timed_s(task) for task in tasks] for _ in range(repeats)]
    full_s, auto_s, *tabulated_s = (median(each) for each in zip(*times, strict=True))
    judged = (influences_of(problem, hardware, one) for hardware, one in zip(designs, given, strict=True))
    kept = {influence.name for found in judged for influence in found if influence.kept}
    names = tuple(name for name in Effects.names() if name in kept)
    return Comparison(names, full_s, auto_s, *(MANY * SETTINGS_A_DESIGN / each for each in tabulated_s))


def tabulated(problem: Problem, designs: Sequence[Hardware], settings: SettingRows) -> Callable[[], None]:
    """Figures of all requirements in one scene, of designs whose hardware is tabulated."""
    again, focus = np.arange(MANY) % N_DESIGNS, float(settings.dioptre_per_m[0])
    models = [DesignModel(problem, hardware) for hardware in designs]
    each = [model.rows_at(0, focus) for model in models]
    camera, lens, port, light = (
        np.array([getattr(one, kind) for one in designs])[again] for kind in ("camera", "lens", "port", "light")
    )

    def columns(parts: Sequence[Any]) -> Any:
        """Of all designs, those of one altitude next to each other."""
        return type(parts[0]).joined(parts).take(again).with_arrays(np.asfortranarray)

    asks = not problem.paper and problem.scenes[0].view.requirements.asks_sharpness
    many, asked = DesignRows(
        cameras=problem.cameras.take(camera), lenses=problem.lenses.take(lens), lights=problem.lights.take(light),
        count=np.full(MANY, 2.0), view=columns([one.view for one in each]), focus_map=focus_maps(problem, 0, port),
        lever_m=np.concatenate([one.lever_m for one in each])[again], light=columns([one.light for one in each]),
        sun=None if each[0].sun is None else columns([one.sun for one in each]),
        sharp=columns([model.sharp_rows(0, focus) for model in models]) if asks else None,
    ), settings.take(again)  # fmt: skip

    def figures() -> None:
        for _ in range(SETTINGS_A_DESIGN):
            figures_of(problem.scenes[0], many, asked)

    return figures


def drawn(problem: Problem, rng: np.random.Generator) -> tuple[list[Hardware], SettingRows]:
    """Random hardware of the problem's parts with two lamps, and random settings."""
    parts, n = problem.parts, N_DESIGNS

    def pick(count: int) -> list[int]:
        return [int(place) for place in rng.integers(count, size=n)]

    def log(low: float, high: float) -> Any:
        return np.exp(rng.uniform(np.log(low), np.log(high), n))

    places = zip(
        pick(len(parts.cameras)), pick(len(parts.lenses)), pick(len(parts.ports)), rng.random(n) < 0.5,
        pick(len(parts.lights)), strict=True,
    )  # fmt: skip
    designs = [Hardware(*place, count=2, mount=problem.mounts[0]) for place in places]
    exposure = log(1e-4, 1e-2)
    return designs, SettingRows(
        f_number=log(1.4, 16), exposure_s=exposure, pulse_s=exposure, gain=log(1, 20), level=rng.uniform(0.1, 1.0, n),
        rate_hz=np.full(n, 2.0), dioptre_per_m=np.full(n, 1.0),
    )  # fmt: skip


def timed_s(task: Callable[[], Any]) -> float:
    """Processor time of one call."""
    start = time.process_time()
    task()
    return time.process_time() - start


def front_table() -> list[str]:
    """Time, size and gap of the exact front of every mission."""
    rows: list[Row] = []
    for path in MISSIONS:
        mission = load_mission(path)
        for names in FRONTS:
            try:
                found, kind = front_of(mission, names, "never"), "sold"
                if found.complete and not len(found.values):
                    found, kind = front_of(mission, names, "allow"), "to be made too"
            except MissionError as fault:
                why = str(fault).partition(": objective: ")[2].partition(";")[0]
                rows.append([path.stem, names[-1], *["-"] * 6, why])
                continue
            hardware = {
                tuple(
                    int(column[a.design[i]])
                    for column in (some.imager, some.light, some.count, some.lighting)
                )
                for some, a, i in found.designs
            }
            bound = found.hypervolume_bound
            rows.append(
                [
                    path.stem, names[-1], kind, f"{found.seconds:.1f}", str(len(found.values)), str(len(hardware)),
                    str(found.account["evaluated"]), f"{1 - found.hypervolume / bound:.1e}" if bound else "-",
                    "complete" if found.complete else "stopped",
                ]
            )  # fmt: skip
    return [
        "## Exact fronts",
        "",
        "Search in process, tables included; *gap*: the share of the hypervolume that bounds leave open; *evaluated*:",
        f"combinations whose settings were solved; stopped after {LONGEST_FRONT_S:g} s.",
        "",
        *table(
            ["mission", "power, cost and", "parts", "s", "points", "hardware", "evaluated", "gap", "status"],
            rows,
        ),
    ]


def front_of(mission: Mission, names: Sequence[str], generic: ToBeMade) -> Front:
    """The exact front over the parts that are sold, or those to be made too."""
    problem = build_problem(mission, selected(mission, load_catalog(mission), generic=generic))
    return FrontSearch(problem, Axes.of(names), deadline=Deadline.after(LONGEST_FRONT_S)).run()


def audit_table(count: int) -> list[str]:
    """How long an audit takes."""
    start = time.process_time()
    result = uwopt.solve(REEF, audit=count)
    share = (time.process_time() - start) / result.timing_s["total"]
    seconds, report = share * result.timing_s["audit"], result.audit or {}
    verdict = "passed" if report.get("passed") else "FAILED"
    return [
        "## Audit",
        "",
        f"`uwopt solve problems/reef-mosaic.yaml --audit {count}`: {report.get('tried')} discarded combinations tried,",
        f"{seconds:.1f} s in one run ({1e3 * seconds / count:.0f} ms each), {verdict}.",
    ]


def table(head: Row, rows: Sequence[Row]) -> list[str]:
    """A Markdown table."""
    return [f"| {' | '.join(line)} |" for line in (head, ["---"] * len(head), *rows)]


def heading(note: str, repeats: int) -> list[str]:
    """Where and when this was measured."""
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in LIBRARIES)
    load = " ".join(f"{value:.1f}" for value in os.getloadavg()) if hasattr(os, "getloadavg") else "unknown"
    return [
        "# Measured",
        "",
        "Written by `python docs/make_speed.py --write`.",
        "",
        f"- {datetime.now(UTC):%Y-%m-%d %H:%M} UTC, uwopt {uwopt.__version__}",
        f"- {platform.system()} {platform.machine()}, {processor()}, {os.cpu_count()} cores",
        f"- load average before the run: {load}",
        f"- Python {platform.python_version()}, {versions}",
        f"- medians of {repeats} runs unless said otherwise",
        *([f"- {note}"] if note else []),
    ]


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description="Measure uwopt.")
    parser.add_argument("--write", action="store_true", help="write docs/speed.md")
    parser.add_argument("--quick", action="store_true", help="one run each and a short audit")
    parser.add_argument("--before", help="a revision whose commands run beside today's")
    parser.add_argument("--note", default="", help="a line on the circumstances")
    asked = parser.parse_args()
    repeats = 1 if asked.quick else 5
    sections = [heading(asked.note, repeats)]
    print("\n".join(sections[0]), flush=True)
    for measure in (
        lambda: measured(asked.before, min(repeats, 3)),
        lambda: physics_table(repeats),
        lambda: search_table(min(repeats, 3)),
        lambda: audit_table(40 if asked.quick else 1000),
        front_table,
    ):
        sections.append(measure())
        print("\n" + "\n".join(sections[-1]), flush=True)
    if asked.write:
        text = "\n\n".join("\n".join(section) for section in sections) + "\n"
        (ROOT / "docs" / "speed.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()

"""Ask of missions that nothing meets why, and try what is told: docs/explained.md.

    python docs/make_explained.py [--write] [--only NAME ...] [--sample N] [--seed S] [--within S] [--again] [--jobs N]

Every mission in problems/ and problems/jobs/ is made impossible by each of its requirements in turn: the requirement
grows stricter by the steps of a ladder until nothing fits. Of each the program is asked why, as `uwopt explain` asks,
and whatever change it tells is tried by a search of its own: something fits with it, and nothing does where the change
is smaller by a few hundredths of itself.

All of them take hours on a core. `--sample` draws some, a requirement of each mission before the second of any, always
in the same order for a seed; `--within` begins no other one after so many seconds of the processor. Rows are kept in
docs/explained_rows.jsonl with the commit that they were made by, so that runs add up; `--again` asks anew of those
that were made by other commits, with the limits that are known to be impossible. The page is of all that are kept.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass, field
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from random import Random
from statistics import median

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command line does

from make_certain import mission_names  # noqa: E402

import uwopt  # noqa: E402
from uwopt.api.common import prepared  # noqa: E402
from uwopt.deadline import Deadline  # noqa: E402
from uwopt.errors import UwoptError  # noqa: E402
from uwopt.forward.assembly import load_catalog  # noqa: E402
from uwopt.mission.mission import Mission, load_mission  # noqa: E402
from uwopt.mission.varying import Value, Varied, VariedMission, rounded  # noqa: E402
from uwopt.mission.weakened import (  # noqa: E402
    RELAXABLE,
    asked_value,
    is_from_above,
    with_central_prices,
    with_limit,
    without,
)
from uwopt.mission.yielding import with_yields, yields_of  # noqa: E402
from uwopt.objectives.objective import Objective  # noqa: E402
from uwopt.results.basis import Relaxed  # noqa: E402
from uwopt.results.result import Result  # noqa: E402
from uwopt.solvers.recommend import seek  # noqa: E402

PROBLEMS = ROOT / "problems"
PAGE = ROOT / "docs" / "explained.md"
ROWS = ROOT / "docs" / "explained_rows.jsonl"
STEPS = (2.0, 10.0, 100.0)  # times as strict
STEPS_DB = (10.0, 25.0, 60.0)
SHORT = 0.05  # of a told change: that much less must not do; the search for the least knows it to 0.02
#: Shares with the most that can be asked.
SHARES = {"overlap": 1.0, "min_uniformity": 1.0, "min_contrast": 1.0, "min_mtf_half_nyquist": 0.9}
NO_LADDER = ("mean_level", "lens_stop_down")  # stricter in no one direction; a count of stops
WITHIN_S = 10.0
ANY = Objective.of("power")  # any design will do
TRY_S = 12.0  # of the processor, for one question whether something fits: beyond, it is not known
FITS = "always fits"
SEED = 16  # of the order in which they are asked

HEAD = """\
# Why nothing fits, asked of missions made impossible

Every mission in `problems/` and `problems/jobs/` is made impossible by each of its requirements in turn, by a step of
2, 10 or 100 times (10, 25 or 60 dB) until nothing fits. `python docs/make_explained.py --write` makes this page of the
rows in `explained_rows.jsonl`, to which `--sample N` adds, drawn a requirement of each mission in turn.

*answered* counts what the mission asks for: whether it alone, left out, would let something through is known. *keys* is
the same of height, water, speed and time. A told change is tried by a search of its own: *does* is how many of those
tried let something fit; *least* is how many of those that are told as the least do not do when they are 5 % smaller, or
by one in the third digit, with which limits are told, where that is more.
Seconds are of the processor, in a process that has started, with no time given: the program's own patience ends it
after 8.8 s (9.7 s in the rows so far), or 6 s after the search that finds nothing, and it says what is open; where
nothing is known to help by then it goes on, up to four times as long in all. *told* counts single changes, and *+ n*
changes that help together.

The rows of `0d76faf6`, `b6ea20ef` and `e32569cb` (whose patience was 10 s) were made on a machine that takes 1.6 to
1.8 times as long as that of the others (`mbari-lass-2013` by min_swath_m 1.7 and 2.8 s, `ooi-camhd` 1.6 and 2.8,
`paper-tank` 1.6 and 2.9), so that the same patience answers less; there a mission of good practice is impossible if
it is with that relaxed, too. `min_mtf_half_nyquist` 0.93 of earlier rows is refused today: pixels leave 0.900.

What falls short: where images are dear (stereo pairs, plankton, the harbour) half of the requirements are answered at
best, changes are told without proof that less does not do, and the search alone may be beyond 10 s: plankton that is
asked for light too even takes 47 s. reef-mosaic by max_gsd_mm 0.5 is told 0.727 mm in 60 s, where 0.66 does and 0.63
does not.

"""

Asked = tuple[str, str]  # mission and requirement


@dataclass
class Row:
    """One impossible mission and what was told of it."""

    mission: str
    name: str  # of the requirement
    limit: float
    status: str
    seconds: float = 0.0
    asked: int = 0  # requirements that could be dropped
    open_asked: list[str] = field(default_factory=list)
    open_keys: list[str] = field(default_factory=list)
    other: list[str] = field(default_factory=list)  # that was left open
    told: list[str] = field(default_factory=list)
    tried: int = 0
    does: int = 0
    least_tried: int = 0
    least: int = 0
    wrong: list[str] = field(default_factory=list)
    together: int = 0
    contradiction: list[str] = field(default_factory=list)
    spent_s: float = 0.0  # of the processor, for all of the row
    commit: str = ""  # of the code that answered


Ask = Callable[[tuple[Asked, float | None]], Row]


# ---------------------------------------------------------------- impossible missions


def strict(name: str, asked: float) -> Iterator[float]:
    """Stricter limits, step by step."""
    key = RELAXABLE[name].key
    for times, more_db in zip(STEPS, STEPS_DB, strict=True):
        if key.endswith("_db") and not is_from_above(name):
            yield rounded(asked + more_db)
        elif is_from_above(name):
            yield rounded(asked / times)
        elif asked < 1.0 and key in SHARES:
            yield rounded(SHARES[key] - (SHARES[key] - asked) / times)
        else:
            yield rounded(asked * times)


def requirements_of(mission: Mission) -> dict[str, float]:
    """What a mission asks for, with its limits."""
    found = {name: asked_value(mission, name) for name in RELAXABLE}
    return {name: limit for name, limit in found.items() if limit}


def fits(mission: Mission) -> bool | None:
    """Whether something fits, as `solve` lets it: of all parts, with practice relaxed as far as may be; else None."""
    try:
        wanted = prepared(mission, None, None, "central").without_gain_cap
        wanted = with_yields(wanted, yields_of(wanted))
        deadline = Deadline.after(TRY_S, time.process_time)
        generic = wanted.catalog.generic_at_last
        found = seek(wanted, load_catalog(wanted), ANY, generic=generic, top=1, deadline=deadline, enough=True)
    except UwoptError:
        return None
    return True if found.outcome.best else False if found.outcome.complete else None


def made_impossible(mission: Mission, name: str, known: float | None = None) -> tuple[Mission, float] | None:
    """The mission with one requirement so strict that nothing fits; None where the ladder is too short.

    known : a limit at which nothing fitted before
    """
    section, key, _ = RELAXABLE[name]
    asked = asked_value(mission, name)
    assert asked is not None
    base = VariedMission(mission, {})
    for value in (*(() if known is None else (known,)), *strict(name, asked)):
        try:
            harder = base.with_values({Varied(key, section, key, (value,)): value})
        except UwoptError:
            continue
        if value == known or fits(harder) is False:
            return harder, value
    return None


# ---------------------------------------------------------------- one of them, explained and tried


def explained(name: str, requirement: str, known: float | None, commit: str, tried: bool) -> Row:
    """One mission made impossible by one requirement."""
    mission = load_mission(PROBLEMS / f"{name}.yaml")
    harder = made_impossible(mission, requirement, known)
    if harder is None:
        return Row(name, requirement, requirements_of(mission)[requirement], FITS, commit=commit)
    row = asked_why(name, requirement, *harder, commit, tried)
    if known is not None and row.status not in ("infeasible", "stopped"):  # the code has changed its mind
        return explained(name, requirement, None, commit, tried)
    return row


def asked_why(name: str, requirement: str, impossible: Mission, limit: float, commit: str, tried: bool) -> Row:
    """Ask why nothing fits, and try what is told."""
    since_s = time.process_time()
    result = uwopt.solve(impossible, confidence="central", quick=True, ranges=True)
    seconds = time.process_time() - since_s
    row = Row(name, requirement, limit, result.status, seconds, len(requirements_of(impossible)), commit=commit)
    for text in texts_left_out(result):
        if text.startswith("whether it could be met without "):
            row.open_asked.append(text.rpartition(" ")[2])
        elif text.startswith("whether another "):
            row.open_keys.append(text.split()[2])
        else:
            row.other.append(text)
    if result.infeasible is not None:
        row.together, row.contradiction = len(result.infeasible.together), list(result.infeasible.contradiction)
        try_changes(row, impossible, result, tried=tried)
        if tried and result.infeasible.together:
            together = ", ".join(f"{one.name} {one.needed}" for one in result.infeasible.together)
            check(row, changed(impossible, result.infeasible.together), None, f"{together} together")
    return row


def texts_left_out(result: Result) -> list[str]:
    """What there was no time for."""
    found = [note.message.partition(": ")[2] for note in result.warnings if note.code == "time"]
    return [text for one in found for text in one.split("; ") if text]


def try_changes(row: Row, mission: Mission, result: Result, *, tried: bool) -> None:
    """Every told change, and one a little smaller."""
    assert result.infeasible is not None
    base = VariedMission(mission, {})
    for one in result.infeasible.relaxations:
        row.told.append(f"{one.name} {one.limit:.4g} → " + ("none" if one.needed is None else f"{one.needed:.4g}"))
        if not tried or one.needed is None or one.limit is None:
            continue
        if one.fits_at_central_prices:
            check(row, with_central_prices(mission), None, row.told[-1])
            continue
        least = not any(text.endswith(f"change of {one.name} would do") for text in row.other)
        shorter = smaller(one.limit, one.needed) if least else None
        check(
            row, with_limit(mission, one.name, one.limit, one.needed),
            None if shorter is None else with_limit(mission, one.name, one.limit, shorter), row.told[-1],
        )  # fmt: skip
    for move in result.infeasible.moves:
        row.told.append(f"{move.name} {move.asked} → {move.needed}")
        if not tried:
            continue
        varied = next(one for one in (Varied(move.name, s, move.name, ()) for s in ("scene", "vehicle", "requirements"))
                      if move.name in VariedMission._names()[one.section])  # fmt: skip
        closer: Value | None = None
        if move.nearest and not isinstance(move.needed, str) and not isinstance(move.asked, str):
            closer = smaller(move.asked, move.needed)
        check(
            row, base.with_values({varied: move.needed}),
            None if closer is None else base.with_values({varied: closer}), row.told[-1],
        )  # fmt: skip


def smaller(asked: float, needed: float) -> float | None:
    """A change a little smaller than one that is told with three digits; None where that would be none."""
    change = abs(asked - needed)
    step = max(SHORT * change, 10.0 ** (math.floor(math.log10(abs(needed))) - 2)) if needed else SHORT * change
    return None if step >= change else rounded(needed + math.copysign(step, asked - needed))


def changed(mission: Mission, together: list[Relaxed]) -> Mission:
    """The mission with all changes that are told together."""
    for one in together:
        if one.name not in RELAXABLE:
            moved = Varied(one.name, "vehicle", one.name, ())
            mission = VariedMission(mission, {}).with_values({moved: one.needed or 0.0})
            continue
        if one.needed is None:
            mission = without(mission, one.name) or mission
        elif one.limit is not None:
            mission = with_limit(mission, one.name, one.limit, one.needed)
    return mission


def check(row: Row, mission: Mission, shorter: Mission | None, what: str) -> None:
    """Something fits in the one mission, and nothing in the other."""
    does = fits(mission)
    if does is not None:
        row.tried, row.does = row.tried + 1, row.does + does
        if not does:
            row.wrong.append(f"{what} does not do")
    more = None if shorter is None else fits(shorter)
    if more is not None:
        row.least_tried, row.least = row.least_tried + 1, row.least + (not more)
        if more:
            row.wrong.append(f"less than {what} does")


# ---------------------------------------------------------------- the page


def table(rows: list[Row]) -> Iterator[str]:
    """All impossible missions."""
    yield "| mission | impossible by | s | answered | keys open | told | does | least |"
    yield "|---" * 8 + "|"
    for row in rows:
        if row.status != "infeasible":
            yield f"| `{row.mission}` | {row.name} {row.limit:g} | | {row.status} | | | | |"
            continue
        seconds = f"{row.seconds:.1f}" if row.seconds <= WITHIN_S else f"**{row.seconds:.1f}**"
        known = f"{row.asked - len(row.open_asked)} of {row.asked}"
        told = f"{len(row.told)}" + (f" + {row.together}" if row.together else "")
        yield (
            f"| `{row.mission}` | {row.name} {row.limit:g} | {seconds} | {known} | {', '.join(row.open_keys)} | {told} "
            f"| {row.does} of {row.tried} | {row.least} of {row.least_tried} |"
        )


def summary(rows: list[Row]) -> str:
    """What all of them say."""
    shown = [row for row in rows if row.status == "infeasible"]
    if not shown:
        return "None of them is impossible.\n"
    seconds = sorted(row.seconds for row in shown)
    in_time = sum(one <= WITHIN_S for one in seconds)
    return (
        f"{len(shown)} impossible missions. {in_time} answered within {WITHIN_S:g} s, median {median(seconds):.1f} s, "
        f"longest {seconds[-1]:.1f} s. "
        f"Every requirement answered in {sum(not row.open_asked for row in shown)}, every key in "
        f"{sum(not row.open_keys for row in shown)}. Of {sum(row.tried for row in shown)} told changes that were tried "
        f"{sum(row.does for row in shown)} do; of {sum(row.least_tried for row in shown)} told as the least "
        f"{sum(row.least for row in shown)} are. {sum(not row.told for row in shown)} were told no single change, "
        f"{sum(not row.told and not row.together for row in shown)} of these no changes together either.\n"
    )


def page(rows: list[Row], every: int) -> str:
    """The whole page; `every`: how many rows there could be."""
    wrong = [f"- `{row.mission}` by {row.name} {row.limit:g}: {one}" for row in rows for one in row.wrong]
    after = ["", "## What does not hold", "", *wrong] if wrong else []
    commits = ", ".join(f"`{one}`" for one in dict.fromkeys(row.commit for row in rows if row.commit))
    made_by = f" by the code of {commits}" if commits else ""
    said = f"Asked of {len(rows)} of {every}{made_by}: "
    return "\n".join([HEAD + said + summary(rows), *table(rows), *after, ""])


# ---------------------------------------------------------------- which, and by what code


def commit_of_code() -> str:
    """The commit of the program that answers, with a + where files of it have changed since."""

    def git(*words: str) -> str:
        done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=False)
        return done.stdout.strip()

    return git("log", "-1", "--format=%h", "--", "uwopt") + ("+" if git("status", "--porcelain", "--", "uwopt") else "")


def in_turn(asked: list[Asked], seed: int) -> list[Asked]:
    """A requirement of each mission, drawn, before the second of any."""
    Random(seed).shuffle(asked)
    turns, many = dict[Asked, int](), dict[str, int]()
    for one in asked:
        turns[one] = many[one[0]] = many.get(one[0], 0) + 1
    return sorted(asked, key=lambda one: turns[one])


def kept_rows(file: Path) -> dict[Asked, Row]:
    """Rows of earlier runs; of those of the same requirement the last."""
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    return {(row.mission, row.name): row for row in (Row(**json.loads(line)) for line in lines)}


def keep_rows(file: Path, rows: Iterable[Row]) -> None:
    """All rows, in the order of their names."""
    in_order = sorted(rows, key=lambda row: (row.mission, row.name))
    lines = (json.dumps(asdict(row), ensure_ascii=False) for row in in_order)
    file.write_text("".join(line + "\n" for line in lines), encoding="utf-8")


def made(asked: list[tuple[Asked, float | None]], jobs: int, within_s: float, ask: Ask) -> Iterator[Row]:
    """Rows as they come, until the time is over or a person wants no more."""
    spent_s = 0.0
    with get_context("spawn").Pool(jobs, maxtasksperchild=8) as pool:
        try:
            while asked and spent_s < within_s:
                some, asked = asked[:jobs], asked[jobs:]
                for row in pool.imap_unordered(ask, some):
                    spent_s += row.spent_s
                    yield row
        except KeyboardInterrupt:
            pool.terminate()


def explained_one(asked: tuple[Asked, float | None], *, commit: str, tried: bool) -> Row:
    """One mission and requirement of a list."""
    since_s = time.process_time()
    row = explained(*asked[0], asked[1], commit, tried)
    row.spent_s = time.process_time() - since_s
    return row


def main() -> None:
    """Make impossible, ask, try, print or write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--only", nargs="*", choices=mission_names(), help="missions, as problems/NAME.yaml")
    parser.add_argument("--key", nargs="*", choices=RELAXABLE, help="requirements")
    parser.add_argument("--sample", type=int, help="only so many, drawn; 0: the page of what is kept")
    parser.add_argument("--seed", type=int, default=SEED, help="of the order in which they are drawn")
    parser.add_argument("--within", type=float, default=math.inf, help="seconds of the processor")
    parser.add_argument("--again", action="store_true", help="ask anew where another commit answered")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--rows", type=Path, default=ROWS, help="the file of rows")
    parser.add_argument("--untried", action="store_true", help="tell without trying what is told")
    given = parser.parse_args()
    every = [
        (name, requirement)
        for name in mission_names()
        for requirement in requirements_of(load_mission(PROBLEMS / f"{name}.yaml"))
        if requirement not in NO_LADDER
    ]
    asked = [
        one for one in in_turn([*every], given.seed)
        if (not given.only or one[0] in given.only) and (not given.key or one[1] in given.key)
    ][: given.sample]  # fmt: skip
    commit, kept = commit_of_code(), kept_rows(given.rows)
    old = {one for one, row in kept.items() if given.again and row.status != FITS and row.commit != commit}
    new = [one for one in asked if one not in kept or one in old]
    new.sort(key=lambda one: one in kept and kept[one].tried > 0)  # first those of which nothing has been tried
    known = {one: row.limit for one, row in kept.items() if row.status == "infeasible"}
    ask = partial(explained_one, commit=commit, tried=not given.untried)
    for row in made([(one, known.get(one)) for one in new], given.jobs, given.within, ask):
        kept[row.mission, row.name] = row
        told = f"{row.mission} {row.name}: {row.status} {row.seconds:.1f} s {row.told} + {row.together} {row.wrong}"
        print(told, file=sys.stderr, flush=True)
        keep_rows(given.rows, kept.values())
    text = page([row for one, row in kept.items() if one in every], len(every))
    if given.write:
        PAGE.write_text(text, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()

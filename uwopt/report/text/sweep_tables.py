"""What many missions amount to as text for people: how they ended, which kits win, what few kits serve."""

from __future__ import annotations

from collections.abc import Iterator

from uwopt.quantities import AT_LIKELIEST
from uwopt.report.text import formats, words
from uwopt.report.text.layout import Block, Text, block, columns, note_blocks, sentence
from uwopt.results.sweep import SweepKit, SweepSummary
from uwopt.units import count_text, counted

MOST_ROWS = 14  # of kits; the file holds all
STATUS = {
    "optimal": "proven best of the catalogue", "feasible": "best of what was counted",
    "complete": "the whole front", "infeasible": "nothing fits",
    "violated": "a requirement is missed", "stopped": "cut short", "failed": "could not be worked out",
    "missing": "not worked out yet: the same command goes on",
}  # fmt: skip

ENDED = {"interrupted": "Interrupted", "stopped": "Stopped by --seconds"}


def sweep_blocks(made: SweepSummary) -> Iterator[Block | Text]:
    """The summary block by block, each ending with an empty line."""
    yield block("Sweep", [sentence(text) for text in sweep_opening(made)])
    yield counts_block(made)
    if made.kits:
        yield kits_block(made)
    if made.portfolio:
        yield portfolio_block(made)
    if made.failed:
        yield failed_block(made)
    yield from note_blocks(made.warnings)
    yield sentence(pace_text(made), "dim")


def sweep_opening(made: SweepSummary) -> list[str]:
    """What was asked for, and what came of it."""
    over = f" over {words.listed([formats.one_line(key, 60) for key in made.keys])}" if made.keys else ""
    told = [f"{counted(made.missions, 'mission')}{over}{done_text(made)}."]
    if made.what == "evaluate":
        fits = made.counts.get("feasible", 0)
        told.append(f"The system meets every requirement of {fits} of them.")
    elif made.what == "pareto":
        told.append(f"The trade-off of {made.counts.get('complete', 0)} of them is whole; each of its points is a row.")
    elif made.kits:
        won = sum(kit.wins for kit in made.kits)
        told.append(
            f"Something fits in {won} of them; {counted(len(made.kits), 'kit')} of hardware "
            f"{'wins' if len(made.kits) == 1 else 'win'} somewhere, the first in {made.kits[0].wins}."
        )
    if (why := ENDED.get(made.status)) is not None:
        told.append(f"{why}: what is done is kept, and the same command goes on with the rest.")
    return told


def done_text(made: SweepSummary) -> str:
    """What of it an earlier run had done."""
    if not made.kept:
        return ""
    return f", {made.kept} of them worked out by an earlier run"


def counts_block(made: SweepSummary) -> Block:
    """Missions by how they ended."""
    grid = columns(("missions", "right"), ("status", "left"), ("", "left"))
    for status, count in made.counts.items():
        grid.add_row(Text(count_text(count)), Text(status), Text(STATUS.get(status, "")))
    return block("How they ended", [grid])


def kits_block(made: SweepSummary) -> Block:
    """The kits that win, the most often first."""
    served = any(kit.serves is not None for kit in made.kits)
    heads = [("no.", "right"), ("wins", "right")]
    grid = columns(*heads, *([("serves", "right")] if served else []), ("price", "right"), ("kit", "left"))
    for number, kit in enumerate(made.kits[:MOST_ROWS], 1):
        serves = [Text("" if kit.serves is None else count_text(kit.serves))] if served else []
        grid.add_row(
            Text(str(number)),
            Text(count_text(kit.wins)),
            *serves,
            Text(sweep_price_text(made, kit.price)),
            Text(kit_text(kit)),
        )
    left = len(made.kits) - MOST_ROWS
    more = [sentence(f"{counted(left, 'kit')} more in sweep.json", "dim")] if left > 0 else []
    return block("Kits that win", [grid, *more])


def kit_text(kit: SweepKit) -> str:
    """A kit in one line."""
    return formats.one_line(kit.parts, 300) + (" (with a part to be made)" if kit.generic else "")


def sweep_price_text(made: SweepSummary, price: float | None) -> str:
    """A price where all are in one currency."""
    return formats.quantity(None) if price is None else formats.money(price, made.currency)


def portfolio_block(made: SweepSummary) -> Block:
    """The most that one kit serves, that two do, and so on."""
    grid = columns(("kits", "right"), ("serve", "right"), ("price", "right"), ("which", "left"))
    for one in made.portfolio:
        which = ", ".join(f"no. {index + 1}" for index in one.kits)
        grid.add_row(
            Text(str(len(one.kits))),
            Text(f"{one.serves} of {made.servable}"),
            Text(sweep_price_text(made, one.price)),
            Text(which),
        )
    winners = sum(kit.wins > 0 for kit in made.kits)
    told = [
        f"Of the {counted(made.tried, 'kit')} tried in every mission: the most missions that so many kits serve, "
        "and of such choices the cheapest; both exact. A kit serves a mission where some settings of it meet every "
        f"requirement, {AT_LIKELIEST}."
    ]
    if made.one_each_price is not None:
        told.append(
            f"One of each of all {counted(winners, 'kit')} that win: "
            f"{sweep_price_text(made, made.one_each_price)}."
        )
    return block("Few kits for many missions", [grid, *(sentence(text) for text in told)])


def failed_block(made: SweepSummary) -> Block:
    """Why missions could not be worked out."""
    grid = columns(("missions", "right"), ("why", "left"))
    for one in made.failed:
        grid.add_row(Text(count_text(one.count)), Text(formats.one_line(one.message, 300)))
    return block("Could not be worked out", [grid])


def pace_text(made: SweepSummary) -> str:
    """How fast it went."""
    new, spent_s = (
        sum(made.counts.values()) - made.counts.get("missing", 0) - made.kept,
        made.timing_s.get("missions", 0.0),
    )
    rate = f", {new / spent_s:.3g} a second" if new > 0 and spent_s > 0 else ""
    memory = f", {made.memory_mb:.0f} MiB at most each" if made.memory_mb else ""
    return f"Took {words.run_time_sentence(made.timing_s)}{rate}: {counted(made.workers, 'worker')}{memory}."

"""Take each recommendation through the checklist of an experienced engineer: docs/signed.md.

    python docs/make_signed.py [--write] [--only NAME ...] [--seconds S] [--jobs N]

Every mission in problems/ is solved as it stands and again with `practice: recommended`, every job in problems/jobs as
it stands; each recommendation is judged by its own result, line by line, and by nothing else. Takes ten minutes.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import uwopt  # noqa: E402
from uwopt.api.risks.of_housings import WARMEST_C  # noqa: E402
from uwopt.catalog.load import read_catalog  # noqa: E402
from uwopt.catalog.records import KINDS  # noqa: E402
from uwopt.mission.mission import load_mission  # noqa: E402
from uwopt.mission.practice import LEAST_UNIFORMITY  # noqa: E402
from uwopt.results.basis import Relaxed  # noqa: E402
from uwopt.results.design import Design  # noqa: E402
from uwopt.results.result import Result  # noqa: E402
from uwopt.units import format_price  # noqa: E402

PROBLEMS = ROOT / "problems"
PAGE = ROOT / "docs" / "signed.md"
USES = ROOT / "uwopt" / "catalog" / "data" / "recommended.csv"
USES_HEAD = """\
# How many recommendations for the missions of problems/ each part stands in: what to ask for first when it is old.
# Counted from docs/signed.md by docs/make_signed.py --write; classes of parts to be made are no parts to ask for."""
ENOUGH_S = 300.0

HEAD = """\
# Would you sign it?

Every mission in `problems/`, its recommendation held against what an experienced engineer looks at before signing the
order. `python docs/make_signed.py --write` makes this page from the results alone.

"""
LEGEND = """\
## The checklist

What a result does not tell does not pass.

| line | what is looked at | passes |
|---|---|---|
| light | darkest place of the lit floor over its mean | at least 0.3; sunlight alone passes |
| snr | signal to noise that 95 % of the frame reach, against what is asked | at least as much |
| corner | blur disc of the defocus at the corner | at most 2 px |
| stop | f-number over the lens's widest | one stop or more, or a lens of one opening |
| colour | white balance of the weakest channel | at most x 4; black and white passes |
| depth | least depth rating over the deepest scene | 1.1 or more |
| reserve | requirements on the images met without margin, where it was not counted how often they hold | none |
| certain | scenarios of what is uncertain in which settings meet every requirement | 90 % or more |
| bad ends | what is asked, with estimated numbers at their bad ends | still met |
| water | other descriptions of the same water | all served |
| housing | a housing that takes port, camera and lens | one is in the order |
| heat | air in the housing, at the most, in the warmest scene | at most 50 °C |
| lamps | what feeds and fires the lamps | supply from outside and a trigger were asked for |
| sold | parts that are sold under a name | all |
| price | high end of the price, against the limit | within it, or no limit |
| quoted | share of the price that somebody has quoted | half or more |
"""
NOT_LOOKED_AT = """\
## What no line looks at

A result does not know these yet, so that each order needs them checked by hand: whether cables and their bends fit into
the housing; whether maker's flanges and ports really take each other; delay and jitter of the trigger, which no maker
states; batteries; delivery. Bodies of cameras and lenses, cables, connectors and the computer are class estimates.
`uwopt` lists what else it does not model in every result.
"""


@dataclass(frozen=True)
class Line:
    """One line of the checklist for one design."""

    name: str
    passes: bool
    figure: str


Check = Callable[[Result, Design], Line]


def figures(design: Design, name: str) -> list[float]:
    """A figure of all scenes that have it."""
    return [float(s.figures[name]) for s in design.scenes if isinstance(s.figures.get(name), (int, float))]


def light(result: Result, design: Design) -> Line:
    """Evenness of the lamps' light."""
    if design.hardware.light_count == 0:
        return Line("light", True, "sun")
    least = min(figures(design, "uniformity"), default=0.0)
    return Line("light", least >= LEAST_UNIFORMITY * (1 - 1e-6), f"{least:.2f}")


def snr(result: Result, design: Design) -> Line:
    """Signal to noise over the frame against what is asked of it."""
    requirements = result.mission["requirements"]
    asked = requirements.get("min_snr_db")
    known = figures(design, "snr_db_p05") or figures(design, "snr_db_min")
    if not known:
        return Line("snr", False, "not told")  # physics paper knows the image's mean alone
    reached = min(known)
    if asked is None:
        return Line("snr", True, f"{reached:.0f} dB, not asked")
    return Line("snr", reached >= asked - 1e-6, f"{reached:.0f} of {asked:g} dB")


def corner(result: Result, design: Design) -> Line:
    """Defocus at the corner."""
    most = max(figures(design, "defocus_corner_px"), default=math.nan)
    return Line("corner", most <= 2.0, "not told" if math.isnan(most) else f"{most:.1f} px")


def stop(result: Result, design: Design) -> Line:
    """How far the lens is closed."""
    one = [m for s in design.scenes for m in s.margins if m.requirement in ("lens_stop_down", "f_number_min")]
    closed = [m.value for m in one if m.requirement == "lens_stop_down" and m.value is not None]
    if closed:
        return Line("stop", min(closed) >= 1.0 - 1e-6, f"{min(closed):.1f} stops")
    wide = [m for m in one if m.requirement == "f_number_min" and m.value is not None and m.limit]
    if wide:
        stops = min(2.0 * math.log2((m.value or 1.0) / (m.limit or 1.0)) for m in wide)
        return Line("stop", stops >= 1.0 - 1e-6, f"{stops:.1f} stops")
    return Line("stop", True, "one opening")


def colour(result: Result, design: Design) -> Line:
    """Amplification of the weakest channel."""
    gains = [*figures(design, "white_balance_red"), *figures(design, "white_balance_blue")]
    if not gains:
        return Line("colour", True, "mono")
    return Line("colour", max(gains) <= 4.0, f"x {max(gains):.1f}")


def depth(result: Result, design: Design) -> Line:
    """Depth rating over depth."""
    found = [m for s in design.scenes for m in s.margins if m.requirement.startswith("depth_rating_m")]
    asked = max(float(scene["depth_m"]) for scene in result.mission["scenes"])
    ratings = [m.value for m in found if m.value is not None]
    if not ratings or asked <= 0:
        return Line("depth", not found, "unknown" if found else "not asked")
    return Line("depth", min(ratings) / asked >= 1.1 - 1e-9, f"x {min(ratings) / asked:.2f}")


def reserve(result: Result, design: Design) -> Line:
    """Risks that say that there is no margin."""
    tight = [risk for risk in result.risks if "there is no margin" in risk.because]
    return Line("reserve", not tight, "none left" if tight else "kept")


def certain(result: Result, design: Design) -> Line:
    """How often it holds in the doubt."""
    known = result.confidence
    if known is None:
        return Line("certain", False, "not counted")
    return Line("certain", known.enough, f"{100.0 * known.held:.0f} %")


def bad_ends(result: Result, design: Design) -> Line:
    """Estimated numbers at their bad ends."""
    held = (result.robustness or {}).get("feasible_at_bad_end")
    return Line("bad ends", held is True, {True: "holds", False: "missed", None: "not told"}[held])


def water(result: Result, design: Design) -> Line:
    """Other waters."""
    waters = (result.robustness or {}).get("waters") or []
    served = sum(1 for one in waters if one.get("objective_value") is not None)
    return Line("water", 0 < served == len(waters), f"{served} of {len(waters)}")


def housing(result: Result, design: Design) -> Line:
    """What the camera stands in."""
    part = design.hardware.parts.get("housing")
    return Line("housing", part is not None, "none" if part is None else "to be made" if part.generic else "sold")


def heat(result: Result, design: Design) -> Line:
    """How warm the air around the camera may become."""
    warmer_k = design.totals.housing_warmer_k
    if warmer_k is None:
        return Line("heat", False, "not told")
    most_c = max(float(scene["temperature_c"]) for scene in result.mission["scenes"]) + warmer_k[1]
    return Line("heat", most_c <= WARMEST_C, f"{most_c:.0f} °C")


def lamps(result: Result, design: Design) -> Line:
    """Supply and trigger of the lamps."""
    if design.hardware.light_count == 0:
        return Line("lamps", True, "sun")
    asked = (result.mission.get("vehicle") or {}).get("lamp_supply") == "external"
    return Line("lamps", asked, "external" if asked else "not asked")


def sold(result: Result, design: Design) -> Line:
    """Parts under a name."""
    made = [kind for kind, part in design.hardware.parts.items() if part.generic]
    return Line("sold", not made, "all" if not made else ", ".join(made) + " to be made")


def price(result: Result, design: Design) -> Line:
    """High end of the price."""
    cost, limit = design.totals.cost, (result.mission.get("limits") or {}).get("cost")
    span = format_price(cost.low, cost.high)
    return Line("price", limit is None or cost.high <= limit, span + (f" of {limit:g}" if limit else ""))


def quoted(result: Result, design: Design) -> Line:
    """Share of the price with a quote."""
    cost = design.totals.cost
    share = 1.0 - cost.estimated / cost.value if cost.value else 0.0
    return Line("quoted", share >= 0.5, f"{100 * share:.0f} %")


CHECKS: tuple[Check, ...] = (
    light, snr, corner, stop, colour, depth, reserve, certain, bad_ends, water, housing, heat, lamps, sold,
    price, quoted,
)  # fmt: skip


@dataclass(frozen=True)
class Judged:
    """A mission's answer, and the checklist where there is a system."""

    name: str
    practice: str
    result: Result
    seconds: float
    lines: tuple[Line, ...]

    @property
    def passed(self) -> int:
        """Lines that pass."""
        return sum(line.passes for line in self.lines)


def judged(name: str, practice: str, seconds: float) -> Judged:
    """One mission, solved and judged, and told."""
    mission = load_mission(PROBLEMS / f"{name}.yaml")
    if practice != mission.practice:
        mission = mission.with_changes(practice=practice)
    begun = time.perf_counter()
    result = uwopt.solve(mission, seconds=seconds)
    best = result.recommendation
    lines = tuple(check(result, best) for check in CHECKS) if best is not None else ()
    spent = time.perf_counter() - begun
    passed = f"{sum(line.passes for line in lines)}/{len(lines)}"
    print(name, practice, result.status, passed, f"{spent:.1f} s", flush=True, file=sys.stderr)
    return Judged(name, practice, result, spent, lines)


def mark(line: Line) -> str:
    """A cell of the table: failures stand out."""
    return line.figure if line.passes else f"**{line.figure}**"


def table(found: list[Judged]) -> Iterator[str]:
    """All missions by all lines."""
    yield "| mission | practice | passes | " + " | ".join(check.__name__.replace("_", " ") for check in CHECKS) + " |"
    yield "|---" * (3 + len(CHECKS)) + "|"
    for one in found:
        if one.lines:
            cells = " | ".join(mark(line) for line in one.lines)
            yield f"| `{one.name}` | {one.practice} | {one.passed} of {len(one.lines)} | {cells} |"
        else:
            yield f"| `{one.name}` | {one.practice} | {one.result.status} |" + " |" * len(CHECKS)


def orders(found: list[Judged]) -> Iterator[str]:
    """What would be bought, and what fails."""
    for one in found:
        yield f"\n### `{one.name}`, practice {one.practice}\n"
        best = one.result.recommendation
        if best is None:
            need = (one.result.infeasible.relaxations if one.result.infeasible is not None else [])[:4]
            yield f"{one.result.status.capitalize()}: nothing in the catalogue does it." if not need else (
                "Nothing in the catalogue does it. Alone, each of these would help: "
                + "; ".join(relaxed_text(item) for item in need) + "."
            )  # fmt: skip
            continue
        parts = [f"{row.count} x {row.manufacturer} {row.model}".replace("  ", " ").strip() for row in best.bom]
        yield "; ".join(parts) + f". {one.result.objective.value:.4g} {one.result.objective.unit}."
        failed = [f"{line.name} ({line.figure})" for line in one.lines if not line.passes]
        yield "\nFails: " + (", ".join(failed) or "nothing of the list") + "."
        for risk in one.result.risks[:3]:
            yield f"- {risk.what}" + (f" ({risk.figure})" if risk.figure else "")


def relaxed_text(item: Relaxed) -> str:
    """A requirement and what it would have to become."""
    asked, needed = (f"{value:.4g}" if value is not None else "none" for value in (item.limit, item.needed))
    return f"{item.name} {asked} → {needed}"


def page(found: list[Judged]) -> str:
    """The whole page."""
    signed = [one for one in found if one.lines and one.passed == len(one.lines)]
    said = f"{len(signed)} of {sum(1 for one in found if one.lines)} recommendations pass every line."
    return "\n".join(
        [HEAD + said + " What fails stands in bold.\n", *table(found), "", LEGEND, NOT_LOOKED_AT, "## The orders",
         *orders(found), ""]
    )  # fmt: skip


def uses_text(text: str) -> str:
    """How many of the page's orders each part of the catalogue stands in, as CSV, the most used first."""
    catalog = read_catalog()
    names = {f"{part.manufacturer} {part.model}".strip(): part.id for kind in KINDS for part in catalog.parts(kind)}
    uses = Counter(
        part_id
        for order in re.findall(r"^\d+ x .*$", text.partition("## The orders")[2], re.MULTILINE)
        for part_id in {names.get(name) for name in re.findall(r"\d+ x (.*?)(?=; \d+ x |\. [\d.e+-]+ \S+\.$)", order)}
        if part_id and not catalog.part(part_id).generic
    )
    lines = [f"{part_id},{count}" for part_id, count in sorted(uses.items(), key=lambda item: (-item[1], item[0]))]
    return "\n".join([USES_HEAD, "id,orders", *lines, ""])


def main() -> None:
    """Solve, judge, print or write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--seconds", type=float, default=ENOUGH_S)
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    files = [*sorted(PROBLEMS.glob("*.yaml")), *sorted(PROBLEMS.glob("jobs/*.yaml"))]
    names = [p.relative_to(PROBLEMS).with_suffix("").as_posix() for p in files if ".system" not in p.name]
    asked = [
        (name, practice)
        for name in given.only or names
        for practice in dict.fromkeys((load_mission(PROBLEMS / f"{name}.yaml").practice, "recommended"))
        if load_mission(PROBLEMS / f"{name}.yaml").physics != "paper" or practice == "bare"
    ]
    with ProcessPoolExecutor(given.jobs) as pool:
        found = list(pool.map(judged, *zip(*asked, strict=True), [given.seconds] * len(asked)))
    text = page(found)
    if not given.write:
        print(text)
        return
    PAGE.write_text(text, encoding="utf-8")
    USES.write_text(uses_text(text), encoding="utf-8")


if __name__ == "__main__":
    main()

"""What can be bought, before and after parts knew what they are for: docs/parts.md.

    python docs/make_parts.py [--write] [--tree FOLDER --facts FILE] [--seconds S] [--jobs N]

Every mission in problems/ is solved as it stands and with `practice: recommended`, and its order is counted. `--tree`
counts another checkout of this repository instead; its facts, kept in docs/parts_before.json, are the column "before".
Takes about five minutes.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PAGE, BEFORE = ROOT / "docs" / "parts.md", ROOT / "docs" / "parts_before.json"
KINDS = ("camera", "lens", "port", "light", "housing")
PRACTICES = ("as published", "recommended")
HEAD = """\
# What can be bought

What the catalogue lets into the search, and what the recommendations for the missions in `problems/` consist of: before
ports were built into housings and parts knew what they are for (commit {before}), and after (commit {after}).
`python docs/make_parts.py --write` makes this page; `docs/parts_before.json` holds what was counted before.

A part "to be made" is a class of parts that no shop sells under a name. A price is quoted where a source states it for
this very part. "Stopped" is a mission without an answer in the time that each was given, {before_s:g} s before and
{after_s:g} s after, on a shared machine. As published a mission asks for nothing beside what it says, so that no
housing is in its order.
"""


def kind_counts() -> dict[str, dict[str, int]]:
    """Parts by kind: listed under a name, of them searched, and classes to be made."""
    from uwopt.catalog.load import read_catalog

    catalog = read_catalog()
    left_out = {item.part_id for item in catalog.exclusions}
    counts = {}
    for kind in KINDS:
        parts = getattr(catalog, "lenses" if kind == "lens" else f"{kind}s", ())
        sold = [part for part in parts if not part.generic]
        searched = sum(part.id not in left_out for part in sold)
        counts[kind] = {"listed": len(sold), "searched": searched, "to be made": len(parts) - len(sold)}
    return counts


def order_of(file: Path, practice: str, seconds: float) -> dict[str, Any]:
    """The order for one mission: status, what of its price is quoted, what must be made."""
    import uwopt
    from uwopt.errors import MissionError
    from uwopt.mission.mission import load_mission

    print(file.stem, practice, flush=True, file=sys.stderr)
    mission = load_mission(file)
    try:
        mission = mission if practice == PRACTICES[0] else mission.with_changes(practice=practice)
    except MissionError:
        return {"status": "not known then"}
    if practice != PRACTICES[0] and mission.physics == "paper":
        return {"status": "not asked"}
    result = uwopt.solve(mission, seconds=seconds, top=1)
    best = result.recommendation
    if best is None:
        return {"status": result.status}
    cost = best.totals.cost
    made = [row.kind for row in best.bom if row.generic]
    lines = [row.kind for row in best.bom]
    quoted = 1.0 - cost.estimated / cost.value if cost.value else 0.0
    return {"status": result.status, "quoted": round(quoted, 4), "to be made": made, "lines": lines}


def facts(tree: Path, seconds: float, jobs: int) -> dict[str, Any]:
    """All that is counted of one checkout."""
    sys.path.insert(0, str(tree))
    files = [path for path in sorted((tree / "problems").glob("*.yaml")) if ".system" not in path.name]
    asked = [(file, practice) for practice in PRACTICES for file in files]
    with ProcessPoolExecutor(jobs) as pool:
        orders = list(pool.map(order_of, *zip(*asked, strict=True), [seconds] * len(asked)))
    head = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=tree, capture_output=True, text=True, check=True)
    by_practice: dict[str, dict[str, Any]] = {practice: {} for practice in PRACTICES}
    for (file, practice), order in zip(asked, orders, strict=True):
        by_practice[practice][file.stem] = order
    return {"commit": head.stdout.strip(), "seconds": seconds, "parts": kind_counts(), "orders": by_practice}


def part_table(before: dict[str, Any], after: dict[str, Any]) -> Iterator[str]:
    """Parts by kind."""
    yield "| parts under a name | listed before | searched before | listed | searched | classes to be made |"
    yield "|---|---|---|---|---|---|"
    for kind in KINDS:
        old, new = (known["parts"].get(kind, {}) for known in (before, after))
        cells = [old.get("listed", 0), old.get("searched", 0), new["listed"], new["searched"], new["to be made"]]
        yield f"| {kind} | " + " | ".join(map(str, cells)) + " |"


def order_text(order: dict[str, Any]) -> str:
    """One order in a cell."""
    if "lines" not in order:
        return str(order.get("status", ""))
    made = ", ".join(order["to be made"])
    return f"{100 * order['quoted']:.0f} % quoted; " + (f"{made} to be made" if made else "all on sale")


def order_tables(before: dict[str, Any], after: dict[str, Any]) -> Iterator[str]:
    """What each mission's order consists of."""
    for practice in PRACTICES:
        old, new = (known["orders"].get(practice, {}) for known in (before, after))
        yield f"\n## Orders, {practice}\n"
        yield "| | before | after |\n|---|---|---|"
        for name, said in SUMMARY.items():
            yield f"| {name} | {said(old)} | {said(new)} |"
        yield "\n| mission | before | after |\n|---|---|---|"
        for name in new:
            yield f"| `{name}` | {order_text(old.get(name, {}))} | {order_text(new[name])} |"


def bought(orders: dict[str, Any]) -> list[dict[str, Any]]:
    """Orders that there are."""
    return [order for order in orders.values() if "lines" in order]


def mean_quoted(orders: dict[str, Any]) -> str:
    """Share of the price that is quoted, mean of the orders."""
    known = [order["quoted"] for order in bought(orders)]
    return f"{100 * sum(known) / len(known):.0f} %" if known else "–"


def on_sale(orders: dict[str, Any]) -> str:
    """Orders without a part to be made."""
    return str(sum(not order["to be made"] for order in bought(orders)))


SUMMARY = {
    "missions with an answer": lambda orders: str(len(bought(orders))),
    "share of the price that is quoted, mean": mean_quoted,
    "all on sale": on_sale,
    "with a part to be made": lambda orders: str(sum(bool(order["to be made"]) for order in bought(orders))),
    "with a housing in the order": lambda orders: str(sum("housing" in order["lines"] for order in bought(orders))),
}


def page(before: dict[str, Any], after: dict[str, Any]) -> str:
    """The whole page."""
    head = HEAD.format(
        before=before["commit"], after=after["commit"], before_s=before["seconds"], after_s=after["seconds"]
    )
    return "\n".join([head, *part_table(before, after), *order_tables(before, after), ""])


def main() -> None:
    """Count, print or write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--tree", type=Path, default=ROOT)
    parser.add_argument("--facts", type=Path, help="write what was counted here, and no page")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    known = facts(given.tree.resolve(), given.seconds, given.jobs)
    if given.facts:
        given.facts.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
        return
    text = page(json.loads(BEFORE.read_text(encoding="utf-8")), known)
    PAGE.write_text(text, encoding="utf-8") if given.write else print(text)


if __name__ == "__main__":
    main()

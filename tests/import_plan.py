"""The plan of the house, counted from the code's own imports: rooms, floors, arrows, circles.

`python tests/import_plan.py` prints it; tests/test_structure.py holds it. A room is a file or a folder directly
below uwopt, a chamber a folder one level deeper. A room's floor is one above the highest that it imports.
Imports within functions count, those for type checkers only do not; the package's face, which hands names on
when they are asked for, is no room.
"""

from __future__ import annotations

import ast
import gc
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "uwopt"
MODULES = sorted(PACKAGE.rglob("*.py"))

#: The one sentence of the door: each room imports only from those before it.
SENTENCE = [
    "errors",
    "tolerances",
    "units",
    "arrays",
    "quantities",
    "deadline",
    "documents",
    "results",
    "model",
    "catalog",
    "mission",
    "forward",
    "objectives",
    "evaluation",
    "solvers",
    "api",
    "report",
    "sweeps",
    "bench",
    "explore",
    "cli",
    "__main__",
]


def name_of(path: Path) -> str:
    """Module name below uwopt: `model.port`, `errors`, `model` for a package itself."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def tree_of(path: Path) -> ast.Module:
    """A file as parsed; it stays, so that none need look through it for what is dead."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    gc.freeze()
    return tree


@cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    """All nodes of a file, walked through once."""
    return tuple(ast.walk(tree_of(path)))


def is_for_checkers(node: ast.AST) -> bool:
    """Whether a node is read by type checkers alone."""
    return isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"


def running_nodes(node: ast.AST) -> Iterator[ast.AST]:
    """All nodes but those for type checkers only."""
    for child in ast.iter_child_nodes(node):
        if not is_for_checkers(child):
            yield child
            yield from running_nodes(child)


@cache
def imports_of(path: Path) -> frozenset[str]:
    """Full names of what a file imports, at its top or within functions."""
    found = set()
    for node in running_nodes(tree_of(path)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name_of(path)}: relative import"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return frozenset(found)


def module_arrows() -> dict[str, set[str]]:
    """Each module with the modules of uwopt that it imports; the package's face is left out."""
    names = {name_of(path) for path in MODULES} - {""}
    arrows: dict[str, set[str]] = {}
    for path in MODULES:
        if name_of(path):
            parts = [full.split(".")[1:] for full in imports_of(path) if full.startswith("uwopt.")]
            reached = {
                next((".".join(p[:n]) for n in range(len(p), 0, -1) if ".".join(p[:n]) in names), "")
                for p in parts
            }
            arrows[name_of(path)] = reached - {"", name_of(path)}
    return arrows


def gathered(arrows: Mapping[str, Iterable[str]], depth: int) -> dict[str, set[str]]:
    """Arrows between the first `depth` names of each module; a file that lies higher stands for itself."""

    def room(module: str) -> str:
        return ".".join(module.split(".")[:depth])

    rooms: dict[str, set[str]] = {room(module): set() for module in arrows}
    for module, others in arrows.items():
        rooms[room(module)] |= {room(other) for other in others} - {room(module)}
    return rooms


def circles(arrows: Mapping[str, Iterable[str]]) -> list[list[str]]:
    """Groups that import each other in a loop (Tarjan's strongly connected components)."""
    index: dict[str, int] = {}
    lowest: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(node: str) -> None:
        index[node] = lowest[node] = len(index)
        stack.append(node)
        for other in arrows[node]:
            if other not in index:
                visit(other)
            if other in stack:
                lowest[node] = min(lowest[node], lowest[other])
        if lowest[node] == index[node]:
            group = stack[stack.index(node) :]
            del stack[stack.index(node) :]
            if len(group) > 1:
                found.append(sorted(group))

    for node in arrows:
        if node not in index:
            visit(node)
    return found


def floors(arrows: Mapping[str, Iterable[str]]) -> dict[str, int]:
    """The floor of each room, from 1; raises ValueError where rooms import each other in a circle."""
    if found := circles(arrows):
        raise ValueError(f"no floors: {' and '.join(found[0])} import each other")

    @cache
    def floor(room: str) -> int:
        return 1 + max((floor(other) for other in arrows[room]), default=0)

    return {room: floor(room) for room in arrows}


def breaches() -> list[tuple[str, str]]:
    """(module, module) of every import that the sentence of the door does not allow."""
    place = {room: n for n, room in enumerate(SENTENCE)}
    return [
        (module, other)
        for module, others in module_arrows().items()
        for other in sorted(others)
        if place[other.split(".")[0]] > place[module.split(".")[0]]
    ]


def lines_of(room: str) -> int:
    """Lines of a room's Python files."""
    paths = [path for path in MODULES if name_of(path).split(".")[0] == room]
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in paths)


def main() -> None:
    """Print the plan from the top floor down."""
    rooms = gathered(module_arrows(), 1)
    plan = floors(rooms)
    for number in range(max(plan.values()), 0, -1):
        print(
            f"{number:2}  "
            + ", ".join(f"{room} {lines_of(room)}" for room in sorted(plan) if plan[room] == number)
        )
    total = sum(len(path.read_text(encoding="utf-8").splitlines()) for path in MODULES)
    print(
        f"{len(rooms)} rooms, {max(plan.values())} floors, {sum(map(len, rooms.values()))} arrows, "
        f"{len(circles(module_arrows()))} circles, {len(MODULES)} files, {total} lines"
    )


if __name__ == "__main__":
    main()

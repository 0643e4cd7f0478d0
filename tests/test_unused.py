"""What the package defines, the package uses; what only tests call stands in the tests."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import import_plan as plan

MODULES = {"uwopt." + plan.name_of(path): path for path in plan.MODULES if path.name != "__init__.py"}

SUITES = ("fronts", "peers", "physics", "quadrature", "scaling", "spectral")
#: Used by name, which the code's own syntax does not show.
BY_NAME = {
    "uwopt.report.notebook": {"figure", "html", "short_text"},  # of results, which lie below the report
    "uwopt.objectives.own": {"FIGURES", "PARTS"},  # what an objective of a user's own may ask for
} | {f"uwopt.bench.{name}": {"SUITE"} for name in SUITES}


def defined(path: Path) -> Iterator[str]:
    """Functions, classes and constants at a module's top; a command of the command line is used by being one."""
    for node in plan.tree_of(path).body:
        if isinstance(node, ast.FunctionDef) and any(isinstance(d, ast.Call) for d in node.decorator_list):
            continue
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            yield node.name
        for target in getattr(node, "targets", [getattr(node, "target", None)]):
            names = (part for part in ast.walk(target or ast.Pass()) if isinstance(part, ast.Name))
            yield from (part.id for part in names if isinstance(part.ctx, ast.Store))


def own_variables(top: ast.stmt, nodes: list[ast.AST]) -> set[str]:
    """Names that a function or class makes itself: its own, arguments, and what it assigns."""
    if not isinstance(top, (ast.FunctionDef, ast.ClassDef)):
        return set()
    made = {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    return made | {node.arg for node in nodes if isinstance(node, ast.arg)} | {top.name}


def used_in(module: str, path: Path) -> set[tuple[str, str]]:
    """Module and name of what one module imports and reads, asks another for, or reads of its own elsewhere."""
    walked = [(top, list(ast.walk(top))) for top in plan.tree_of(path).body]
    bound = {
        name.asname or name.name: (node.module, name.name)
        for _, nodes in walked
        for node in nodes
        if isinstance(node, ast.ImportFrom) and node.module
        for name in node.names
    }
    found = set()
    for top, nodes in walked:
        hidden = own_variables(top, nodes)
        for node in nodes:
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id not in hidden:
                found.add(bound.get(node.id, (module, node.id)))
            elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                found.add((".".join(bound.get(node.value.id, ("", ""))), node.attr))
    return found


def test_what_only_tests_call_stands_in_tests() -> None:
    used = set().union(*(used_in(module, path) for module, path in MODULES.items()))
    unused: dict[str, set[str]] = {}
    for module, path in MODULES.items():
        for name in defined(path):
            if not name.startswith("__") and (module, name) not in used:
                unused.setdefault(module, set()).add(name)
    assert unused == BY_NAME

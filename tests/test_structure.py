"""Rules of structure: who may import whom, what the model may do, how numbers are named.

The plan of the house is counted by tests/import_plan.py. Where the tree does not keep a rule yet, the exception
stands in a table here with its reason, and the test compares both ways: a new breach fails, and so does an
exception that is no longer needed.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import import_plan as plan
import pytest

from uwopt.api.watch import STAGES
from uwopt.units import UNIT_SUFFIXES

ROOT, PACKAGE, MODULES = plan.ROOT, plan.PACKAGE, plan.MODULES
name_of, tree_of, nodes_of, imports_of = plan.name_of, plan.tree_of, plan.nodes_of, plan.imports_of
MODEL = sorted((PACKAGE / "model").rglob("*.py"))
DATA = "uwopt/catalog/data/"

# ---------------------------------------------------------------- words


def test_each_stage_that_tells_its_progress_has_words():
    """`watch.stage(name)` and `watch.within(name, …)` look the name up, where a person waits."""
    calls = [node for path in MODULES for node in nodes_of(path) if isinstance(node, ast.Call)]
    named = [
        call.args[0].value for call in calls
        if isinstance(call.func, ast.Attribute) and call.func.attr in ("stage", "within")
        and isinstance(call.args[0], ast.Constant) and " " not in call.args[0].value
    ]  # fmt: skip
    assert len(named) > 8 and set(named) <= set(STAGES)


# ---------------------------------------------------------------- imports


def test_each_room_imports_only_from_those_before_it_in_the_sentence():
    assert plan.breaches() == []


def test_every_room_stands_in_the_sentence():
    assert {name_of(path).split(".")[0] for path in MODULES} - {""} == set(plan.SENTENCE)


def test_no_modules_import_each_other_in_a_circle():
    assert plan.circles(plan.module_arrows()) == []


@pytest.mark.parametrize("depth", [1, 2])
def test_no_rooms_import_each_other_in_a_circle(depth):
    assert plan.circles(plan.gathered(plan.module_arrows(), depth)) == []


def test_house_has_thirteen_floors_at_most():
    assert max(plan.floors(plan.gathered(plan.module_arrows(), 1)).values()) <= 13


def test_eight_modules_at_most_stand_at_the_root():
    assert len([path for path in MODULES if path.parent == PACKAGE]) <= 8


def test_the_page_of_the_model_names_all_of_its_stages():
    told = ast.get_docstring(tree_of(PACKAGE / "model" / "__init__.py")) or ""
    assert {path.stem for path in MODEL if path.stem != "__init__"} - set(re.findall(r"\w+", told)) == set()


#: What a room that must stay pure may import beside itself.
PURE_ROOMS = {
    "model": {"errors", "arrays"},
    "results": {"errors", "documents", "units"},
    "documents": {"errors", "units"},
}


@pytest.mark.parametrize("room", PURE_ROOMS)
def test_pure_rooms_know_nothing_of_the_house(room):
    known = plan.gathered(plan.module_arrows(), 1)[room]
    assert known <= PURE_ROOMS[room]


def test_a_circle_and_a_breach_are_seen():
    assert plan.circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == [["a", "b", "c"]]
    assert plan.floors({"a": set(), "b": {"a"}, "c": {"a", "b"}}) == {"a": 1, "b": 2, "c": 3}


def test_class_names_occur_once():
    classes = [node.name for path in MODULES for node in tree_of(path).body if isinstance(node, ast.ClassDef)]
    assert sorted({name for name in classes if classes.count(name) > 1}) == []


def test_names_of_functions_that_others_import_occur_once():
    """Who reads a name at its use finds one function of that name; each module may have helpers of its own."""
    names = {"uwopt." + name_of(path): tree_of(path) for path in MODULES}
    own = {module: {n.name for n in tree.body if isinstance(n, ast.FunctionDef)} for module, tree in names.items()}
    offered = set()
    for tree in names.values():
        taken = [(n.module, name) for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) for name in n.names]
        rooms = {name.asname or name.name: f"{module}.{name.name}" for module, name in taken}
        offered |= {(module, name.name) for module, name in taken if name.name in own.get(module or "", ())}
        offered |= {
            (rooms[n.value.id], n.attr) for n in ast.walk(tree)
            if isinstance(n, ast.Attribute) and isinstance(n.value, ast.Name)
            and n.attr in own.get(rooms.get(n.value.id, ""), ())
        }  # fmt: skip
    found = [name for _, name in offered]
    assert sorted({name for name in found if found.count(name) > 1}) == []


#: A second module for one of them, and why.
SECOND_MODULES = {
    "pymoo": (
        "bench.pymoo_single",
        "one objective: a solver to compare with, no part of a front",
    ),
    "nlopt": ("bench.nlopt_peers", "algorithms to compare with, which no answer needs"),
}


@pytest.mark.parametrize("library", ["casadi", "nlopt", "pymoo", "dask", "dash"])
def test_library_is_imported_in_one_module(library):
    users = [name_of(p) for p in MODULES if any(n.split(".")[0] == library for n in imports_of(p))]
    second, _ = SECOND_MODULES.get(library, ("", ""))
    users = [user for user in users if user != second]
    assert len(users) <= 1
    assert all(user.startswith("explore." if library == "dash" else "solvers.") for user in users)


def test_dask_is_imported_by_its_workers_alone():
    users = [name_of(p) for p in MODULES if any(n.split(".")[0] in ("dask", "distributed") for n in imports_of(p))]
    assert users == ["sweeps.cluster"]


@pytest.mark.parametrize("name", ["solve", "evaluate", "pareto", "sweep"])
def test_no_module_bears_the_name_of_a_public_function(name):
    assert not [p for p in MODULES if p.stem == name and p.parent == PACKAGE]


#: What one command in some needs, and loads when it comes to it.
SELDOM = (
    "scipy", "pandas", "casadi", "nlopt", "pymoo", "moocore", "plotly", "jerlov", "jinja2", "mpmath", "PIL", "rich",
    "openpyxl", "dash", "matplotlib", "pyarrow", "distributed", "uwopt.report", "uwopt.bench", "uwopt.explore",
    "uwopt.sweeps",
)  # fmt: skip
#: What `solve` makes and prints has none of these, but for the scenarios of a mission that asks for confidence.
OF_OTHER_ANSWERS = (
    "uwopt.results.front", "uwopt.results.whatif", "uwopt.results.sweep", "uwopt.solvers.front",
    "uwopt.solvers.population", "uwopt.solvers.confidence",
)  # fmt: skip
NOT_LOADED_BY = {
    "uwopt": (*SELDOM, "numpy", "yaml", "pydantic"),
    "uwopt.cli.app": (*SELDOM, "numpy", "yaml", "pydantic"),
    "uwopt.mission.mission": (*SELDOM, "numpy"),
    "uwopt.api.evaluating": (*SELDOM, "uwopt.solvers"),
    "uwopt.api.solving": (*SELDOM, *OF_OTHER_ANSWERS, "uwopt.mission.system", "uwopt.catalog.inline"),
    "uwopt.report.write": OF_OTHER_ANSWERS,
    "uwopt.report.text.short": OF_OTHER_ANSWERS,
    "uwopt.report.text.tables": OF_OTHER_ANSWERS,
}


@pytest.mark.parametrize("module", NOT_LOADED_BY)
def test_import_loads_nothing_heavy(module):
    script = f"import sys, {module}\nprint([m for m in {NOT_LOADED_BY[module]!r} if m in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


CHECKED_RECORDS = {"Section", "WholeFile", "BaseModel", "Part", "Record", "FiledRecord", "InlinePart"}


def holds_checked_records(path: Path) -> bool:
    """Whether a module declares records that pydantic makes when it is loaded."""
    made = [node for node in nodes_of(path) if isinstance(node, ast.ClassDef)]
    return any(ast.unparse(base) in CHECKED_RECORDS for node in made for base in node.bases)


def test_the_types_of_checked_records_are_no_texts():
    # pydantic and dataclasses make types of texts again, one by one, each time that the program starts
    holding = [path for path in MODULES if holds_checked_records(path)]
    assert holding
    texts = "from __future__ import annotations"
    assert [name_of(path) for path in holding if texts in path.read_text("utf-8")] == []


# ---------------------------------------------------------------- what code may do


def dotted(node: ast.expr) -> str:
    """The text of what is called; names with dots are put together here, which takes a tenth of the time."""
    if isinstance(node, ast.Attribute):
        return f"{dotted(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ast.unparse(node)


@cache
def calls_of(path: Path) -> set[str]:
    """Names of what a file calls, such as `print`, `sys.exit` or `read_text`."""
    found = set()
    for node in nodes_of(path):
        if isinstance(node, ast.Call):
            text = dotted(node.func)
            found |= {text, text.rsplit(".", 1)[-1]}
    return found


@pytest.mark.parametrize("path", MODEL, ids=name_of)
def test_model_opens_no_file_and_prints_nothing(path):
    touching = {
        "open",
        "print",
        "input",
        "read_text",
        "write_text",
        "loadtxt",
        "genfromtxt",
        "read_csv",
        "save",
    }
    assert calls_of(path) & touching == set()
    outside = {"os", "sys", "io", "pathlib", "csv", "json", "logging", "importlib", "subprocess", "warnings"}
    assert {name.split(".")[0] for name in imports_of(path)} & outside == set()


@pytest.mark.parametrize("path", MODEL, ids=name_of)
def test_model_keeps_no_state(path):
    assert not [node for node in nodes_of(path) if isinstance(node, ast.Global)]


def test_only_the_command_line_prints_and_exits():
    talking = {"print", "sys.exit", "exit", "quit", "typer.echo"}
    found = {name_of(p) for p in MODULES if calls_of(p) & talking}
    assert found <= {"report.text.console"} | {name_of(path) for path in (PACKAGE / "cli").glob("*.py")} | {
        "__main__"
    }


# ---------------------------------------------------------------- docstrings of the model


def public_functions(path: Path) -> list[ast.FunctionDef]:
    """Functions at a module's top whose name has no underscore in front."""
    body = tree_of(path).body
    return [n for n in body if isinstance(n, ast.FunctionDef) and not n.name.startswith("_")]


#: What tells a quantity: an equation, a unit in brackets or in words, or an argument named with its unit.
TELLS = re.compile(
    r"=|\[[^\]]+\]|\b(?:per|share|ratio|index|fraction|metres|seconds|degrees|radians|watts|lumens|lux|pixels|"
    r"decibels|electrons)\b"
)


@pytest.mark.parametrize("path", MODEL, ids=name_of)
def test_each_function_of_the_model_says_what_it_computes(path):
    for function in public_functions(path):
        text = ast.get_docstring(function)
        assert text, function.name
        if ast.unparse(function.returns or ast.Constant(None)) == "bool":
            continue
        unit_in_name = function.name.endswith((*UNIT_SUFFIXES, "_per_sr"))
        arguments = [a.arg for a in (*function.args.args, *function.args.kwonlyargs)]
        assert unit_in_name or TELLS.search(text) or any(a.endswith(UNIT_SUFFIXES) for a in arguments), (
            f"{name_of(path)}.{function.name}: neither equation nor unit"
        )


@pytest.mark.parametrize("path", MODEL, ids=name_of)
def test_each_file_of_the_model_has_a_docstring(path):
    assert ast.get_docstring(tree_of(path))


def test_longer_functions_of_the_model_list_their_arguments():
    # From 25 lines of code on, a line of meaning is not enough: Parameters, Returns or a unit in brackets.
    for path in MODEL:
        for function in public_functions(path):
            text = ast.get_docstring(function) or ""
            code_lines = (function.end_lineno or 0) - function.lineno - len(text.splitlines())
            if code_lines > 25:
                assert re.search(r"Parameters|Returns|\[[^\]]+\]|=", text), f"{name_of(path)}.{function.name}"


# ---------------------------------------------------------------- units in names

#: Words that name a dimension; a number whose name holds one carries its unit at the end.
DIMENSIONAL = re.compile(
    r"(?:^|_)(?:altitude|depth|range|distance|length|width|height|radius|diameter|thickness|gap|baseline|lever|"
    r"footprint|swath|gsd|pitch|wavelength|time|exposure|pulse|duration|interval|readout|recycle|speed|rate|angle|tilt|"
    r"elevation|power|energy|mass|flux|illuminance|irradiance|radiance|attenuation|absorption|scattering|dioptre|"
    r"temperature|salinity|bandwidth|noise|current|reach)(?:_|$)"
)
NUMBERS = re.compile(r"\b(?:float|Number|Array|FloatArray|NDArray|Quantity|ndarray)\b")
#: Ratios of angles, and units that the model uses but the list in units.py lacks.
PURE = re.compile(r"^(?:cos|sin|tan)_|_(?:rel|frac)$|_(?:per_sr|e2)$")
#: class.field: why it has no unit.
WITHOUT_UNIT: dict[str, str] = {
    "Terms.power": "terms of an objective, each in the unit that Objective.unit names",
    "Terms.mass": "as above",
    "NodeBounds.power": "bounds on the terms of an objective, in their units",
    "NodeBounds.mass": "as above",
    "LampChoices.power_per_light": "W per unit of light, which is lm s or share by kind",
    "Program.power_weight": "weight of a term",
    "Certificate.gap_abs": "in the unit of the objective",
    "Focus.n_depth": "an f-number",
    "SceneView.time_share": "a share",
    "Complete.run_time_min": "as of lights",
    "Light.run_time_min": "minutes: the unit is its last word, which elsewhere means the least",
}
#: module.function(argument): why it has no unit.
ARGUMENTS_WITHOUT_UNIT: dict[str, str] = {
    "model.lens.image_irradiance(radiance)": "spectral or not: the result has its unit, without the steradian",
    "model.imaging.radiance_weight(radiance_in_water)": "per lumen, or per second: the result has its unit",
}


def dataclass_fields(path: Path) -> Iterator[tuple[str, str]]:
    """(class, field) of every public number in a dataclass."""
    for node in nodes_of(path):
        if not isinstance(node, ast.ClassDef):
            continue
        is_record = any("dataclass" in ast.unparse(d) for d in node.decorator_list)
        if not is_record and not any(ast.unparse(base) == "NamedTuple" for base in node.bases):
            continue
        for item in node.body:
            if isinstance(item, ast.AnnAssign) and NUMBERS.search(ast.unparse(item.annotation)):
                name = ast.unparse(item.target)
                if not name.startswith("_"):
                    yield node.name, name


def test_dimensional_fields_carry_their_unit():
    bare = {
        f"{record}.{name}"
        for path in MODULES
        for record, name in dataclass_fields(path)
        if DIMENSIONAL.search(name) and not name.endswith(UNIT_SUFFIXES) and not PURE.search(name)
    }
    assert bare == set(WITHOUT_UNIT)


def test_arguments_of_the_model_carry_their_unit():
    bare = {
        f"{name_of(path)}.{function.name}({argument.arg})"
        for path in MODEL
        for function in public_functions(path)
        for argument in (*function.args.args, *function.args.kwonlyargs)
        if DIMENSIONAL.search(argument.arg)
        and argument.annotation is not None
        and re.search(r"float|Array|Numeric|Symbolic", ast.unparse(argument.annotation))
        and not argument.arg.endswith(UNIT_SUFFIXES)
        and not PURE.search(argument.arg)
    }
    assert bare == set(ARGUMENTS_WITHOUT_UNIT)


# ---------------------------------------------------------------- what a file may mention


def files_of_the_project() -> list[Path]:
    """Files under version control; without git, all that are no caches."""
    try:
        done = subprocess.run(
            ["git", "ls-files", "-co", "--exclude-standard"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        )
        names = done.stdout.splitlines()
    except (OSError, subprocess.CalledProcessError):
        hidden = re.compile(r"(^|/)(\.(?!ci|gitignore)|__pycache__|build/|.*\.egg-info)")
        paths = (p.relative_to(ROOT).as_posix() for p in ROOT.rglob("*") if p.is_file())
        names = [name for name in paths if not hidden.search(name)]
    return [ROOT / name for name in names if (ROOT / name).is_file()]


def mentions(pattern: re.Pattern[str]) -> list[str]:
    """file:line of every match, the tables' sources apart (they name pages on the web)."""
    found = []
    for path in files_of_the_project():
        name = path.relative_to(ROOT).as_posix()
        if path.suffix == ".png":
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if pattern.search(line) and not (name.startswith(DATA) and "http" in line):
                found.append(f"{name}:{number}")
    return found


def test_no_file_names_a_path_of_a_machine():
    # in pieces, so that this file does not name one
    roots = "|".join(
        ["ho" + "me", "ro" + "ot", "wo" + "rk", "tm" + "p", "Us" + "ers", "op" + "t", "mn" + "t"]
    )
    assert mentions(re.compile(rf"(?<![\w.\-/:}}>*)])/(?:{roots})/\w|\b[A-Z]:\\\\?Us" + "ers")) == []


def test_no_file_names_a_package_registry():
    names = [
        "py" + "pi.",
        "python" + "hosted",
        "index" + "-url",
        "find" + "-links",
        "conda." + "anaconda",
        "npm" + "js.",
    ]
    assert mentions(re.compile("|".join(map(re.escape, names)))) == []


def test_lists_of_exceptions_give_reasons():
    for table in (WITHOUT_UNIT, ARGUMENTS_WITHOUT_UNIT):
        assert all(len(reason) >= 7 for reason in table.values())

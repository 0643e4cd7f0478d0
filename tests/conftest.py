"""What tests of several rooms share: a design that was evaluated and recomputed, and a system with a colour camera."""

from __future__ import annotations

import gc
import math
import os
import sys
from collections.abc import Callable, Iterator
from functools import cache
from typing import TYPE_CHECKING, Any

import pytest
from few_messages import tell_less
from hypothesis import HealthCheck, settings
from thorough import THOROUGH, drawn

import uwopt

if TYPE_CHECKING:
    from uwopt.evaluation.recompute import Replay

# No test may hang on the clock or on luck: a loaded machine is no failure, and a red run can be had again.
settings.register_profile(
    "uwopt",
    deadline=None,
    derandomize=not THOROUGH,
    max_examples=drawn(30, 300),
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("uwopt")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command does: those of two workers wait for each other
LONGEST = ("test_readme.py", "test_types.py")


PLAIN = "--assert=plain"
SELDOM = (20_000, 20, 20)  # objects made before the youngest are looked at, and how often the older ones are


def pytest_configure(config: pytest.Config) -> None:
    """What is done once a process costs most: compiling what is imported, and rewriting the asserts of the whole suite.

    Bytecode is written, whatever the environment says, so that the next process reads it: a fifth of the files of all
    libraries is ever imported, so that compiling them all beforehand takes twice as long. Workers take asserts as
    they stand.
    """
    gc.disable()  # until what is collected is known
    sys.dont_write_bytecode = False
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    tell_less(config)
    given = config.invocation_params
    spread = getattr(config.option, "numprocesses", None)
    if spread and not any(argument.startswith("--assert") for argument in given.args):
        config.invocation_params = pytest.Config.InvocationParams(
            args=(*given.args, PLAIN), plugins=given.plugins, dir=given.dir
        )


@pytest.hookimpl(trylast=True)
def pytest_collection_finish() -> None:
    """Look for dead circles among what tests make alone: modules, tests and the package stay to the end, and so does
    what is dead already, which takes half a second to find.

    A tenth of the whole run went into walking through them again and again.
    """
    gc.freeze()
    gc.set_threshold(*SELDOM)
    gc.enable()
    make_commands_once()


def make_commands_once() -> None:
    """Let runners of typer, where tests have any, take the commands that one has made: each made them all, 0.1 s."""
    runner: Any = sys.modules.get("typer.testing")
    if runner is not None:
        runner._get_command = cache(runner._get_command)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Say how to see the values of an assert that failed in a worker."""
    if terminalreporter.stats.get("failed") and PLAIN in config.invocation_params.args:
        terminalreporter.write_line("The values in an assert that failed: run its test alone, without -n.")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What takes longest first: the README's tests share one fixture, and what stands first is stolen by nobody."""
    items.sort(key=lambda item: LONGEST.index(item.path.name) if item.path.name in LONGEST else len(LONGEST))


COLOUR: dict[str, Any] = {
    "camera": {"resolution_x_px": 1600, "resolution_y_px": 1200, "pixel_pitch_um": 4.5, "read_noise_e": 6,
               "saturation_e": 20000, "bit_depth": 12, "colour": "colour", "quantum_efficiency": "imx264c-filled"},
    "lens": {"focal_length_mm": 8, "f_number_min": 1.8, "f_number_max": 16, "transmission": 0.9},
    "port": {"geometry": "flat", "glass": "n_bk7", "thickness_mm": 10, "gap_mm": 5},
    "light": {"kind": "continuous", "flux_lm": 12000, "power_w": 120, "beam": "cosine-power", "beam_angle_deg": 80},
    "light_count": 2, "light_baseline_m": 0.6, "orientation": "portrait",
    "settings": {"f_number": 2.8, "exposure_ms": 2.0},
}  # fmt: skip


@pytest.fixture(scope="session")
def colour_system() -> dict[str, Any]:
    """A colour camera behind a flat port, its width along the motion."""
    return COLOUR


@pytest.fixture(scope="session")
def replayed() -> Callable[[Any, Any], tuple[Replay, dict[str, Any]]]:
    """Evaluates a system in a mission: the design recomputed from the result, and its figures."""
    # the whole model, for which the process that hands out tests has no use
    from uwopt.evaluation.recompute import replay

    def of(mission: Any, system: Any) -> tuple[Replay, dict[str, Any]]:
        result = uwopt.evaluate(mission, system)
        design = result.design
        assert design is not None
        made = replay(result.mission, design, physics=result.physics, system=result.system)
        return made, design.scenes[0].figures

    return of


@pytest.fixture
def undoubted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tell nothing beside the proof: the rest is most of a solve's time, and most tests look at the optimum alone."""
    from uwopt.api import solving

    monkeypatch.setattr(solving, "doubted", lambda made, *given: made)


@pytest.fixture(scope="session", autouse=True)
def fewer_to_come() -> Iterator[None]:
    """Let what was chosen hold in a few further scenarios; a user is told of four times as many."""
    from uwopt.solvers.confidence import search

    with pytest.MonkeyPatch.context() as patch:
        for name in ("FRESH", "TIES"):
            patch.setattr(search, name, drawn(256, getattr(search, name)))
        yield


@pytest.fixture(scope="module")
def unhurried() -> Iterator[None]:
    """Let the clock stop no search: the exact front takes its time, population solvers breed a few generations.

    Of a front some points are evaluated by default, not all that a user is shown: each is a design with every figure.
    """
    from uwopt.api import trading as api_pareto
    from uwopt.solvers.front import designs
    from uwopt.solvers.population import pymoo_front

    honest, short = pymoo_front.population_front, {"seconds": None, "pop_size": 40, "generations": 10}
    with pytest.MonkeyPatch.context() as patch:
        for name in ("EXACT_S", "PEER_S", "PEER_ALONE_S"):
            patch.setattr(api_pareto, name, math.inf)
        patch.setattr(designs, "MOST_POINTS", drawn(16, designs.MOST_POINTS))
        patch.setattr(
            pymoo_front, "population_front", lambda *given, **more: honest(*given, **(more | short))
        )
        yield

"""Random problems by seed, their forward models and their enumeration, each made once."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import Any

import brute_force as brute
import numpy as np
import small_catalogues as small
from thorough import THOROUGH, drawn

from uwopt.catalog.parts.light import Light
from uwopt.catalog.records import exact
from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.parts import Parts
from uwopt.forward.problem import Problem
from uwopt.forward.views import Views
from uwopt.mission.mission import Mission
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.exact.search import Search

TOP = 4
READINGS = 8  # names the generator of what is read of the water, which must not change the cases' other draws
COLOURS = 9  # the same of what is asked of colours
COMPLETES = 11  # the same of complete cameras
HOUSINGS = 10  # the same of housings and the sizes of bodies
RINGS = 11  # the same of rings behind lenses
PAIRS = 13  # the same of how two cameras stand
PITCHES = 12  # the same of the angles by which cameras look ahead
#: Of the first hundred random cases some that are enumerated quickly and, together, meet every kind of part, wish and
#: rule, most of them with designs that are feasible; a test lists the kinds. In 9 alone designs under several lightings
#: come to be evaluated in another order than that of the lightings.
CHOSEN = (
    11, 14, 17, 20, 21, 22, 32, 33, 35, 39, 44, 45, 48, 49, 54, 57, 60, 62, 72, 73, 75, 79, 80, 81, 87, 91, 9,
)  # fmt: skip
RICH = (10, 22, 33, 35, 57)  # of them some with several designs to choose from
EASED_DB = 15.0  # corners are so much darker than the mean that few designs would be left
CASES = drawn(CHOSEN, tuple(range(600)))
FEW = drawn(RICH, tuple(range(100)))


#: Sizes of batches that searches are tried with; what each does, its fixture says.
BATCHES = ("as shipped", "bounds at work", "as if large")


def in_batches(cases: Iterable[Any]) -> list[tuple[str, Any]]:
    """Each case in batches as shipped and in one of the others, by turns; in all of them before a release."""
    return [
        (batches, case_)
        for place, case_ in enumerate(cases)
        for batches in drawn((BATCHES[0], BATCHES[1 + place % 2]), BATCHES)
    ]


@dataclass(frozen=True)
class Case:
    """One random problem."""

    parts: Parts
    mission: Mission
    objective: Objective

    def problem(self, parts: Parts | None = None) -> Problem:
        """Fresh tables."""
        return Problem(self.mission, parts or self.parts, paper=self.mission.physics == "paper")

    def searcher(self, parts: Parts | None = None, **options: Any) -> Search:
        """The exact search, ready to run."""
        wanted = {"top": TOP, "progress": None, **options}
        return Search(self.problem(parts), self.objective, **wanted)

    def solve(self, parts: Parts | None = None, **options: Any) -> tuple[Search, Outcome]:
        """The exact search and what it finds."""
        search = self.searcher(parts, **options)
        return search, search.run()


@cache
def case(
    seed: int, *, over_frame: bool = False, coloured: bool = False, in_mid_water: bool = False, housed: bool = False,
    spaced: bool = False, oblique: bool = False, whole: bool = False, paired: bool = False,
) -> Case:  # fmt: skip
    """A random case whose limits are, in a part of the cases, just what one of its designs needs.

    `over_frame` asks its SNR, eased, of 95 % of the image, wherever it was asked; `coloured` asks something of colours;
    `in_mid_water` puts dark targets into open water; `housed` builds each port into three housings; `spaced` lets
    lenses that focus on nothing near stand on rings; `oblique` looks ahead;
    `whole` adds complete cameras; `paired` asks what a stereo pair sees and measures, just as well as a design does.
    """
    rng = np.random.default_rng(seed)
    parts, plain = small.parts(rng, 3 if THOROUGH else 2), small.with_in_hand(small.mission(rng), seed)
    if over_frame and "min_snr_db" in plain["requirements"]:
        plain["requirements"] |= {"snr_at": "worst", "min_snr_db": plain["requirements"]["min_snr_db"] - EASED_DB}
    plain = small.with_readings(np.random.default_rng([seed, READINGS]), plain)
    if coloured:
        own = np.random.default_rng([seed, COLOURS])
        parts, plain = small.with_colours(own, parts), small.asking_of_colours(own, plain)
    if in_mid_water:
        plain = small.in_mid_water(plain)
    if oblique:
        plain = small.obliquely(np.random.default_rng([seed, PITCHES]), plain)
    if paired:
        plain = small.in_pairs(np.random.default_rng([seed, PAIRS]), plain)
    if housed:
        parts = small.housed(np.random.default_rng([seed, HOUSINGS]), parts)
    if spaced:
        parts, plain = small.spaced(np.random.default_rng([seed, RINGS]), parts), small.with_rings(plain)
    if whole:
        parts = small.with_completes(np.random.default_rng([seed, COMPLETES]), parts)
    objective = Objective.of(plain["objective"])
    free = Case(parts, small.loaded(plain), objective)
    limits, wanted = limits_that_bind(rng, free)
    if paired:
        wanted |= pair_that_binds(np.random.default_rng([seed, PAIRS, 1]), free)
    return Case(parts, small.loaded(plain, limits, **wanted), objective)


def limits_that_bind(rng: np.random.Generator, free: Case) -> tuple[dict[str, float], dict[str, float]]:
    """Budgets and coverage at, or a little beyond, those of one random design at its best settings."""
    bench, limits, wanted = brute.Bench(free.problem()), {}, {}
    buildable = list(brute.buildable(bench.problem))
    if not buildable:
        return {}, {}
    hardware = small.pick(rng, buildable)
    model, best = bench.model(hardware), brute.best_of(bench, hardware, free.objective)
    terms, room = brute.fixed_terms(model), small.pick(rng, [1.0, 1.0, 1.0001, 1.05, 1.3])
    for name, key, share in (("cost", "cost_limit_value", 0.3), ("mass_kg", "mass_kg", 0.2)):
        if small.chance(rng, share):
            limits[name] = terms[key] * room
    if small.chance(rng, 0.3) and math.isfinite(best.power_w):
        limits["power_w"] = best.power_w * room
    if small.chance(rng, 0.3):
        limits["peak_power_w"] = small.between(rng, 20, 2000)
    if small.chance(rng, 0.1):
        limits["data_rate_mb_s"] = small.between(rng, 1, 100)
    if small.chance(rng, 0.25):
        wanted["max_gsd_mm"] = max(float(v.gsd_m.max()) for v in model.views) * 1e3 * room
    if small.chance(rng, 0.25):
        wanted["min_swath_m"] = min(float(v.covered_across_m.min()) for v in seen_in_focus(model)) / room
    return limits, wanted


def seen_in_focus(model: DesignModel) -> list[Views]:
    """What the images of every scene cover where a search puts the focus."""
    return [model.view_at(index, model.searched_dioptre_per_m(index)) for index in range(len(model.views))]


def pair_that_binds(rng: np.random.Generator, free: Case) -> dict[str, float]:
    """What the pair of one random design that sees something with both cameras sees and measures, or a little less."""
    bench = brute.Bench(free.problem())
    models = [bench.model(hardware) for hardware in brute.buildable(bench.problem)]
    seen = [(min(float(v.common_across_m.min()) for v in seen_in_focus(m)), m) for m in models]
    some = [(width_m, model) for width_m, model in seen if width_m > 0.0]
    if not some:
        return {}
    width_m, model = small.pick(rng, some)
    worst_m = max(float(v.depth_error_m.max()) for v in model.views)
    room = small.pick(rng, [1.0, 1.0001, 1.05])
    return {"min_common_swath_m": width_m / room, "max_depth_error_mm": worst_m * 1e3 * room}


@cache
def solved(seed: int) -> Outcome:
    """What the exact search, as shipped, finds in a case."""
    return case(seed).solve()[1]


@cache
def bench(seed: int, **asked: bool) -> Any:
    """Forward models of a case."""
    return brute.Bench(case(seed, **asked).problem())


@cache
def enumerated(seed: int, **asked: bool) -> list[Any]:
    """Best settings of every hardware of a case, best first."""
    return brute.enumerate_all(bench(seed, **asked), case(seed, **asked).objective)


def ranked(found: list[Any]) -> dict[tuple[int, ...], Any]:
    """The best of each camera, lens, port and light that has a feasible design, best first."""
    best: dict[tuple[int, ...], Any] = {}
    for one in found:
        if math.isfinite(one.value):
            best.setdefault(ids(one.hardware), one)
    return best


def ids(hardware: Any) -> tuple[int, ...]:
    """What counts as other hardware."""
    return hardware.camera, hardware.lens, hardware.port, hardware.light


def planted(
    objective: Any,
    lights: tuple[Light, ...],
    requirements: dict[str, Any],
    *,
    camera: dict[str, Any] | None = None,
    scenes: tuple[dict[str, Any], ...] = ({},),
    **vehicle: Any,
) -> Case:
    """One camera behind a dome, a lens and the lamps given: cases made to hit one rule each."""
    rng = np.random.default_rng(7)
    plain = {
        "practice": "bare",
        "objective": objective, "physics": "full", "limits": {}, "requirements": {"overlap": 0.3, **requirements},
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3, "orientation": "landscape", "light_count": 1, **vehicle},
        "scenes": [
            {"name": f"scene {i}", "water": "II", "seafloor": 0.2, "depth_m": 100.0, **given}
            for i, given in enumerate(scenes)
        ],
    }  # fmt: skip
    body = {
        "mounts": ("C",), "shutter": "global", "saturation_e": exact(20_000.0), "power_w": exact(2.0),
        "dark_current_e_s": None, **(camera or {}),
    }  # fmt: skip
    glass = {
        "mounts": ("C",), "image_circle_mm": 20.0, "focal_length_mm": 8.0, "f_number_min": exact(1.4),
        "f_number_max": exact(16.0), "min_object_distance_m": None,
    }  # fmt: skip
    parts = Parts(
        (replace(small.camera(rng, "cam"), **body),), (replace(small.lens(rng, "lens"), **glass),),
        (replace(small.port(rng, "port"), geometry="dome", outer_radius_mm=80.0, clear_diameter_mm=None),), lights,
    )  # fmt: skip
    return Case(parts, small.loaded(plain), Objective.of(objective))


def lamp(name: str, **given: Any) -> Light:
    """A lamp with numbers as given, all exact."""
    quantities = {f.name for f in fields(Light) if "Quantity" in str(f.type)}
    known = {
        key: exact(value) if key in quantities and isinstance(value, float) else value
        for key, value in given.items()
    }
    common: dict[str, Any] = {
        "price": exact(500.0), "mass_g": exact(500.0), "depth_rating_m": 6000.0, "beam_medium": "water",
        "beam_angle_deg": exact(80.0),
    }  # fmt: skip
    return Light(id=name, **{**common, **known})

"""Second opinions: the settings of found hardware solved again by a continuous solver."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from uwopt.deadline import Deadline
from uwopt.forward.problem import MeantFocus, Problem
from uwopt.objectives.objective import Objective
from uwopt.results.basis import Opinion
from uwopt.solvers.continuous.pieces import SmoothDesign
from uwopt.solvers.continuous.solve_settings import FEASIBLE, solve_settings
from uwopt.solvers.exact.imager_rules import limit
from uwopt.solvers.exact.node_designs import WithLamps
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.one_hardware import as_set
from uwopt.solvers.recommend import Sought, scene_rows_of
from uwopt.solvers.settings.best import scenes_need_cells
from uwopt.solvers.settings.closed_form import Chosen
from uwopt.tolerances import ROUND

AGREES_REL = 1e-4
APERTURE_RESIDUAL = 1e-6
MOST_CANDIDATES = 12  # open to Bonmin's choice
BONMIN_S = 10.0  # of processor time


def smooth(sought: Sought) -> bool:
    """Whether the continuous solvers' program holds what the mission asks."""
    return not why_not_smooth(sought.problem, sought.goal)


def why_not_smooth(problem: Problem, objective: Objective) -> str:
    """What of a mission is no part of the continuous solvers' program; empty where nothing is."""
    if scenes_need_cells(problem.scenes, objective) or objective.weight("contrast"):
        return "sun, sharpness, contrast and information are no part of its smooth program"
    if problem.duration.over_scenes:
        return "a limit of energy over several scenes is no part of its program"
    vehicles = [scene.view.vehicle for scene in problem.scenes]
    if any("off" in (v.lamps_between_images, v.camera_between_images) for v in vehicles):
        return "lamps and cameras that are off between images are no part of its program"
    if min(objective.weight("power"), objective.weight("snr_db")) < 0.0:
        return "its program takes no negative weight of power or snr_db"
    return ""


def aperture_opinions(sought: Sought, found: Found) -> list[Opinion]:
    """CasADi's word on the aperture of a winner chosen for its information, one a scene.

    None where power counts too: the best aperture for information alone takes more light than is worth its power.
    """
    objective = sought.goal
    if not objective.weight("information") or objective.weight("power"):
        return []
    from uwopt.solvers.continuous.aperture import confirmed

    rows = scene_rows_of(sought.search, found)
    names = Chosen.__dataclass_fields__
    made = []
    for row, numbers in zip(rows, found.settings, strict=True):
        chosen = Chosen(**{n: np.array([numbers[n]]) for n in names if n in numbers})
        word = confirmed(row, chosen)
        if word is not None:
            off, told = word["gain_rel"], objective.single or objective.quality
            made.append(Opinion(
                "casadi", part_ids(sought, found), "optimal" if word["kkt_residual"] < APERTURE_RESIDUAL else "failed",
                objective.reported(found.minimised) * (1.0 + off) if told else None, abs(off), abs(off) <= AGREES_REL,
                max_violation=0.0, kkt_residual=word["kkt_residual"],
                message=f"f-number {word['f_number']:.4g} for information, time and gain as chosen; the search "
                f"has {word['searched_f_number']:.4g}",
            ))  # fmt: skip
    return made


def alone(
    sought: Sought, found: Found, f_number: float | None, meant_m: MeantFocus | float | None
) -> Sought | None:
    """A search of one hardware whose iris and focus stand where scenarios want them; None where nothing fits so.

    What is recommended for those has its place in no table of the search by likeliest values: it was found beside them,
    with an iris that does not give way. `f_number`, `meant_m` : as of `as_set`
    """
    problem, imagers = as_set(sought.problem, found, f_number, meant_m)
    if not len(imagers):
        return None
    made = Sought.of(sought.selection, problem, sought.goal, whole=True, imagers=imagers)
    return made if made.outcome.best else None


def opinion(sought: Sought, found: Found, method: str, deadline: Deadline) -> Opinion:
    """What a continuous solver finds for one hardware, beside the search's value."""
    objective = sought.goal
    answer = solve_settings(
        smooth_design(sought, found),
        objective=objective,
        power_limit_w=sought.problem.scene_power_limit_w,
        method=method,  # pyrefly: ignore[bad-argument-type]
        max_seconds=deadline.left_s,
    )
    value = answer.objective_value
    difference = None
    if value is not None:
        difference = objective.share(abs(value - found.minimised), found.minimised)
    return Opinion(
        method, part_ids(sought, found), answer.status, None if value is None else objective.reported(value),
        difference, difference is not None and difference <= AGREES_REL, answer.max_violation, answer.kkt_residual,
        answer.multipliers, answer.iterations, answer.run_time_s, answer.message,
    )  # fmt: skip


# ---------------------------------------------------------------- hardware and settings together


def mixed_opinion(sought: Sought, *, max_seconds: float) -> Opinion:
    """What Bonmin chooses of the best systems, their numbers of lamps and steps of light, settings included."""
    objective = sought.goal
    best = sought.outcome.best[0]
    why_not = why_not_smooth(sought.problem, objective)
    if why_not:
        return Opinion("bonmin", message=f"Bonmin was not run: {why_not}")
    from uwopt.solvers.continuous.casadi_ipopt import solve_mixed
    from uwopt.solvers.continuous.mixed import MixedProgram

    began = time.perf_counter()
    open_to_choice = shortlist(sought)
    power_limit_w = sought.problem.scene_power_limit_w
    candidates = [smooth_design(sought, found) for found in open_to_choice]
    program = MixedProgram(candidates, objective, power_limit_w)
    answer = solve_mixed(program, max_seconds=max_seconds)
    picked = program.picked(answer.x)
    feasible = picked.max_violation <= FEASIBLE
    off = objective.share(abs(picked.value - best.minimised), best.minimised)
    agrees = feasible and off <= AGREES_REL
    scope = (
        f"{len(program.open_to_choice)} systems open to choice with {len(program.options)} pieces of settings "
        f"(the {len(sought.outcome.best)} best of the search, with other numbers of lamps)"
    )
    caution = "a check of the choice among these, not of the catalogue; no proof where rules are not convex"
    return Opinion(
        "bonmin", part_ids(sought, open_to_choice[picked.candidate]),
        "failed" if not feasible else "optimal" if agrees and answer.ended else "feasible",
        objective.reported(picked.value) if feasible else None, off if feasible else None, agrees,
        picked.max_violation, iterations=answer.nodes, run_time_s=time.perf_counter() - began,
        message=f"{answer.message}; {scope}: {caution}",
    )  # fmt: skip


def part_ids(sought: Sought, found: Found) -> list[str]:
    """Camera, lens, port and light by id."""
    return [part.id for part in sought.problem.parts.of(found).values()]


def shortlist(sought: Sought) -> list[Found]:
    """The best of a search, then the same with other numbers of lamps that cost and mass allow."""
    problem, made = sought.problem, list(sought.outcome.best)
    low, high = problem.count_range
    limits, counts = problem.mission.limits, np.arange(low, high + 1)
    for found in sought.outcome.best:
        imager, light = (np.full(len(counts), place) for place in (found.imager, found.light))
        own = WithLamps.of(problem, sought.search.imagers, imager, light, counts)
        fits = (own.limit_cost <= limit(limits.cost) * ROUND) & (own.mass_kg <= limit(limits.mass_kg) * ROUND)
        for at in np.flatnonzero(fits & (counts != found.count)):
            cost, mass_kg = float(own.cost[at]), float(own.mass_kg[at])
            made.append(replace(found, count=int(counts[at]), cost=cost, mass_kg=mass_kg))
    return made[:MOST_CANDIDATES]


def smooth_design(sought: Sought, found: Found) -> SmoothDesign:
    """One system as the solvers of settings take it."""
    imagers = sought.search.imagers
    return SmoothDesign.of(
        scene_rows_of(sought.search, found), motorised=bool(sought.problem.lenses.motorised[found.lens]),
        camera_power_w=float(imagers.camera_power_w[found.imager]), cost=found.cost, mass_kg=found.mass_kg,
        gsd_mm=float(imagers.gsd_mm[found.imager]),
    )  # fmt: skip

"""One system in one mission: figures, margins, totals and bill of materials.

Everything a result says of a design is computed here, from the same tables and formulas that the
search uses; a search's claim is read back through this door.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from uwopt.evaluation.bill import bill_of_materials, cost_range, used_hardware
from uwopt.evaluation.design_model import DesignModel, design_model
from uwopt.evaluation.figures_by_name import (
    light_notes,
    plain_figures,
    plain_settings,
    stop_notes,
    uneven_notes,
)
from uwopt.evaluation.housing_heat import heated
from uwopt.evaluation.pair_light import pair_notes
from uwopt.evaluation.resolved import Measured, Resolved, resolved
from uwopt.evaluation.tested import tested_notes
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.enclosures import tight_at_worst
from uwopt.forward.figures import Figures
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective, Terms
from uwopt.objectives.requirements import LEVEL_TOLERANCE_REL, MarginRows, common_margins
from uwopt.results.design import Design, Margin, Note, SceneResult, Totals
from uwopt.units import ratio_to_db

UNBOUND = (  # met or not, never scarce
    "light_level", "mean_level", "common_f_number", "common_focus_m", "fixed_f_number", "fixed_exposure_ms",
    "fixed_gain", "fixed_dim_frac",
)  # fmt: skip
NO_SIGNAL_DB = -200.0  # of an SNR: less than one electron in ten thousand million pixels


def evaluate_design(
    problem: Problem, hardware: Hardware, given: list[SceneSettings], objective: Objective,
    *, level_tolerance_rel: float = 1e-6,
) -> Design:  # fmt: skip
    """Everything a result says of one design with these settings."""
    (design,) = evaluate_designs(problem, [(hardware, given)], objective, level_tolerance_rel=level_tolerance_rel)
    return design


def evaluate_designs(
    problem: Problem, many: Sequence[tuple[Hardware, list[SceneSettings]]], objective: Objective,
    *, level_tolerance_rel: float = 1e-6,
) -> list[Design]:  # fmt: skip
    """The same of many designs: what settings of one hardware resolve is worked out together."""
    found = [measured(problem, hardware, given) for hardware, given in many]
    return [
        design_record(problem, one, sharp, objective, level_tolerance_rel=level_tolerance_rel)
        for one, sharp in zip(found, resolved(found), strict=True)
    ]


def measured(problem: Problem, hardware: Hardware, given: list[SceneSettings]) -> Measured:
    """A design with the figures of each scene as columns."""
    model = design_model(problem, hardware)
    each = [model.settings(index, wanted) for index, wanted in enumerate(given)]
    model = model.at_rates([float(settings.rate_hz[0]) for settings in each])
    figures = [
        model.figures(index, settings, information=not problem.scenes[index].paper)
        for index, settings in enumerate(each)
    ]
    return Measured(model, each, figures)


def meets_all(problem: Problem, hardware: Hardware, given: list[SceneSettings]) -> bool:
    """Whether a design with these settings, as they can be set, meets every requirement; no more is worked out."""
    found = margins_of(problem, measured(problem, hardware, given), LEVEL_TOLERANCE_REL)
    return all(bool(one.satisfied[0]) for margins in found for one in margins)


def margins_of(problem: Problem, design: Measured, level_tolerance_rel: float) -> list[list[MarginRows]]:
    """Every requirement by scene, what scenes have in common and together included."""
    model, first = design.model, design.settings[0]
    found = [
        model.margins(index, settings, figures, level_tolerance_rel=level_tolerance_rel)
        for index, (settings, figures) in enumerate(zip(design.settings, design.figures, strict=True))
    ]
    if len(found) > 1:
        together = model.duration_margins(design.figures)
        common = [[], *(common_margins(model.lenses, settings, first) for settings in design.settings[1:])]
        found = [[*own, *shared, *together] for own, shared in zip(found, common, strict=True)]
    return found


def design_record(
    problem: Problem, design: Measured, sharp: Sequence[Resolved | None], objective: Objective,
    *, level_tolerance_rel: float,
) -> Design:  # fmt: skip
    """Everything a result says of a design, in plain values."""
    model, each, figures, hardware = design.model, design.settings, design.figures, design.model.hardware
    margins = margins_of(problem, design, level_tolerance_rel)
    scenes = [
        SceneResult(
            name=scene.name,
            settings=plain_settings(model, each[index], figures[index]),
            settings_to_set=None,
            figures=plain_figures(model, index, each[index], figures[index], sharp[index]),
            margins=[plain_margin(m) for m in margins[index]],
        )
        for index, scene in enumerate(problem.scenes)
    ]
    by_scene = [model.totals(one) for one in figures]
    powers = [float(one["power_w"][0]) for one in by_scene]
    cost, mass = (float(by_scene[-1][name][0]) for name in ("cost", "mass_kg"))
    minimised = float(objective.cost_to_minimise(worst_terms(design, max(powers), cost, mass))[0])
    most = int(np.argmax(powers))
    most_w = model.drawn_w(most, each[most], figures[most])
    bill = bill_of_materials(problem, hardware, model.spacer_m, most_w, model.disks_gb)
    return Design(
        hardware=used_hardware(problem, hardware, model.spacer_m),
        objective_value=objective.told(minimised),
        feasible=all(m.satisfied for s in scenes for m in s.margins),
        totals=Totals(
            cost=cost_range(problem, bill),
            power_w=max(powers),
            light_power_w=max(float(one.light_power_w[0]) for one in figures),
            light_peak_power_w=max(float(one.light_peak_power_w[0]) for one in figures),
            mass_kg=mass,
            **housed_totals(model),
            **heated(problem, hardware, most_w),
            run_time_h=model.run_time_h,
            **used_up(model, figures),
        ),
        scenes=scenes,
        bom=bill,
        warnings=[
            *light_notes(model), *pair_notes(model, each), *tested_notes(model), *housing_notes(model),
            *uneven_notes(scenes), *stop_notes(model),
        ],
    )  # fmt: skip


def worst_terms(design: Measured, power_w: float, cost: float, mass_kg: float) -> Terms:
    """What objectives are made of, of the worst scene at its nominal altitude, beside what all scenes share."""
    pairs = [(one, scene.nominal) for one, scene in zip(design.figures, design.model.problem.scenes, strict=True)]
    bits = [one.information_bit_per_m2 for one in design.figures]
    worst = (
        power_w, cost, mass_kg,
        min(float(ratio_to_db(max(float(one.snr[0, at]), 0.0))) for one, at in pairs),
        max(float(view.gsd_m[0, 1]) * 1e3 for view in design.model.views),
        min(float(one.contrast[0, at]) for one, at in pairs),
        min(math.nan if one is None else float(one[0]) for one in bits),
    )  # fmt: skip
    return Terms(*(np.array([value]) for value in worst))


def housing_notes(model: DesignModel) -> list[Note]:
    """What is to be measured before the housing is bought: sizes that are estimates, and may not fit."""
    problem, hardware = model.problem, model.hardware
    port = model.port
    if not port.roomy[0]:
        return []
    camera, lens = problem.parts.cameras[hardware.camera], problem.parts.lenses[hardware.lens]
    tight = tight_at_worst(camera, lens, model.spacer_m, port)
    if not tight:
        return []
    told = " and ".join(
        f"{name.removesuffix('_mm').replace('_', ' ')} may have to be {1e3 * needed:.0f} mm, and is {1e3 * room:.0f} mm"
        for name, (needed, room) in tight.items()
    )
    text = f"measure camera, plug and lens before you buy the housing: by the high ends of estimates its {told}"
    return [Note("measure_the_camera", "hardware.housing", text)]


def housed_totals(model: DesignModel) -> dict[str, Any]:
    """Mass in water and outer size, as totals name them; nothing without a housing."""
    port = model.port
    if not port.housed[0]:
        return {}
    size_mm = [float(measure[0]) * 1e3 for measure in (port.outer_length_m, port.outer_diameter_m)]
    return {"mass_water_kg": float(model.mass_in_water_kg()[0]), "size_mm": size_mm}


def used_up(model: DesignModel, by_scene: Sequence[Figures]) -> dict[str, Any]:
    """What the whole mission uses up, as totals name it; None where no duration or battery is known."""
    duration = model.problem.duration
    mean_power_w = float(duration.mean([model.totals(f)["power_w"][0] for f in by_scene]))
    mean_data_mb_s = float(duration.mean([model.data_rate_mb_s(f)[0] for f in by_scene]))
    hours = duration.endurance_h(mean_power_w)
    return {
        "energy_wh": duration.energy_of(mean_power_w),
        "storage_gb": duration.storage_of(mean_data_mb_s),
        "endurance_h": hours if hours is None or math.isfinite(hours) else None,
    }


def plain_margin(row: MarginRows) -> Margin:
    """One margin of one design."""
    value, limit, margin = float(row.value[0]), float(row.limit[0]), float(row.margin[0])
    lost = row.unit == "dB" and value < NO_SIGNAL_DB
    if lost:
        value = margin = -math.inf
    finite = math.isfinite
    where = None if row.at_altitude_m is None else float(row.at_altitude_m[0])
    return Margin(
        requirement=row.requirement,
        value=value if finite(value) else None,
        limit=limit if finite(limit) else None,
        sense=row.sense,
        margin=margin if finite(margin) else None,
        unit=row.unit,
        at_altitude_m=where,
        satisfied=bool(row.satisfied[0]),
        binding=bool(row.binding[0]) and finite(limit) and finite(value) and row.requirement not in UNBOUND,
        word="no signal" if lost else "",
        reserve=row.reserve,
    )

"""What a recommendation takes for granted: numbers of its parts that no source states, and what the physics assumes."""

from __future__ import annotations

from typing import Any

from uwopt.catalog.curves.clarity import Clarity
from uwopt.catalog.parts.doubts import doubtful
from uwopt.catalog.records import Part
from uwopt.evaluation.bill import beside_parts
from uwopt.evaluation.design_model import design_model
from uwopt.forward.problem import Problem
from uwopt.results.basis import Assumption
from uwopt.solvers.exact.ranking import Found
from uwopt.solvers.one_hardware import pieces_by_kind
from uwopt.units import unit_told


def field_unit(name: str, part: Part) -> str:
    """Unit of a part's field, from its name."""
    if name in ("price", "host_price"):
        return part.currency if name == "price" else "USD"
    return unit_told(name)


def assumptions(problem: Problem, found: Found) -> list[Assumption]:
    """Every number of the design that is estimated, and what the model assumes."""
    items = [
        Assumption(
            f"{kind}.{name}", part.id, value.value, value.low, value.high, field_unit(name, part), value.status,
            value.source,
        )
        for kind, part in pieces_by_kind(problem, found).items()
        for name, value in doubtful(part)
    ]  # fmt: skip
    hardware = found.hardware
    model = design_model(problem, hardware)
    for item, _ in beside_parts(problem, hardware, model.spacer_m, model.disks_gb):
        items += [
            Assumption(
                f"{item.id}.{name}", item.id, known.value, known.low, known.high, unit, known.status, known.source
            )
            for name, known, unit in (("price", item.price, "USD"), ("mass_g", item.mass_g, "g"))
            if known is not None
        ]
    return items + model_assumptions(problem, found)


def model_assumptions(problem: Problem, found: Found) -> list[Assumption]:
    """What the physics takes for granted here."""

    def item(path: str, value: Any, source: str) -> Assumption:
        return Assumption(path, "", value, None, None, unit="", status="assumed", source=source)

    items = [from_reading(s.name, s.clarity) for s in problem.scenes if s.clarity]
    items += [item(f"{s.name}: water_table", s.water_table, "; ".join(s.notes)) for s in problem.scenes]
    light = problem.parts.lights[found.light]
    if light.beam_medium == "not stated" and not problem.paper:
        items.append(
            item(
                "light.beam_medium",
                "air",
                "the source does not say whether the beam angle holds in air or water",
            )
        )
    if light.dim_status == "estimated":
        items.append(
            item("light.dim_levels", list(light.dim_levels or ()), "how the lamp dims is not published")
        )
    if problem.cameras.prnu_frac[found.camera] == 0 and not problem.paper:
        items.append(item("camera.prnu_frac", 0.0, "not published; taken as none"))
    return items


def from_reading(scene: str, known: Clarity) -> Assumption:
    """The attenuation that a visibility, a Secchi depth or a turbidity was taken for."""
    return Assumption(
        f"{scene}: {known.relation.key}", "", known.c_per_m(), known.c_per_m("low"), known.c_per_m("high"),
        unit="1/m", status="derived", source=f"c at 530 nm; {known.explained}",
    )  # fmt: skip

"""Risks of depth, battery, warmth and ballast."""

from __future__ import annotations

from uwopt.api.risks.worst import Weighed
from uwopt.mission.reserves import BATTERY_IN_HAND
from uwopt.results.basis import Risk
from uwopt.results.design import Design
from uwopt.results.result import Result
from uwopt.tolerances import SATISFIED_REL
from uwopt.units import format_quantity, listed, texts_apart

DEPTH_IN_HAND = 0.1
WARMEST_C = 50.0  # around an industrial camera, by most makers' sheets (assumed; no column of the catalogue has it)
CARRIED_KG = 10.0  # of lead, beyond which nobody adds it without a thought: a diver's belt holds some 5 to 10 kg
BUOYANT_KG = 0.5  # that a mount and its screws weigh in water; beyond it ballast is needed (assumed)


def shallow(result: Result, design: Design) -> Weighed:
    """Depth ratings that are used up by the deepest scene; good to know where the mission itself asks for that rating.

    Instruments that are rated for a depth work there: see `depth_factor` of the mission.
    """
    deepest_m, few = result.deepest_m, dict[str, float]()
    for margin in design.margins:
        if not margin.satisfied or margin.key != "depth_rating_m" or margin.value is None:
            continue
        if deepest_m > 0.0 and margin.value < deepest_m * (1.0 + DEPTH_IN_HAND):
            few[margin.requirement.partition(" (")[2].rstrip(")") or "a part"] = margin.value
    if few:
        asked = (result.mission.get("limits") or {}).get("depth_rating_m") is not None
        what = "a part may not stand the pressure" if len(few) == 1 else "parts may not stand the pressure"
        those = f"{listed([*few])} {'is' if len(few) == 1 else 'are'}"
        because = f"{those} rated for little more than the depth of the mission"
        because += ", as limits.depth_rating_m allows" if asked else ""
        figure = " against ".join(format_quantity(depth_m, "m") for depth_m in (min(few.values()), deepest_m))
        yield (29.0 if asked else 62.0), Risk(what, because, figure)


def drained(result: Result, design: Design) -> Weighed:
    """A battery that the mission uses up, or nearly so; told as missed where a limit on energy says so."""
    battery_wh = (result.mission.get("vehicle") or {}).get("battery_wh")
    used_wh = design.totals.energy_wh
    told = any(margin.key == "energy_wh" for margin in design.missed)
    if battery_wh is None or used_wh is None or told:
        return
    if used_wh <= (1.0 - BATTERY_IN_HAND) * battery_wh * (1.0 + SATISFIED_REL):  # the reserve is just kept
        return
    what = "the battery is nearly used up" if used_wh <= battery_wh else "the battery does not last"
    because = f"cells that are old or cold give less than their plate says: keep {100 * BATTERY_IN_HAND:.0f} % in hand"
    of, all_of = texts_apart(used_wh, battery_wh, text=lambda value, digits: format_quantity(value, "wh", digits))
    yield 58.0, Risk(what, because, f"{of} of {all_of}")


def overheated(result: Result, design: Design) -> Weighed:
    """Air in a housing that may be warmer than cameras are made for."""
    warmer_k, heat_w = design.totals.housing_warmer_k, design.totals.housing_heat_w
    if warmer_k is None or heat_w is None:
        return
    water_c = max(float(scene["temperature_c"]) for scene in result.mission["scenes"])
    if water_c + warmer_k[1] <= WARMEST_C:
        return
    low, high = (f"{water_c + kelvin:.0f}" for kelvin in warmer_k)
    because = (
        f"{format_quantity(heat_w, 'w')} warm the air in its housing; most makers allow {WARMEST_C:.0f} °C around a "
        "camera: lead its heat into a metal end cap, take a housing of metal, or ask"
    )
    figure = f"{low} to {high} °C in water of {water_c:g} °C"
    yield 57.0, Risk("the camera may become too warm", because, figure)


def floats(result: Result, design: Design) -> Weighed:
    """Housings that displace more than they weigh."""
    weight_kg = design.totals.mass_water_kg
    if weight_kg is not None and weight_kg < -BUOYANT_KG:
        because = "the housings displace more water than they weigh, lamps not counted; ballast is no part of the order"
        figure = f"{format_quantity(-weight_kg, 'kg')} of ballast in water"
        most_kg = (result.mission.get("limits") or {}).get("mass_water_kg")
        is_much = -weight_kg > (CARRIED_KG if most_kg is None else most_kg)  # a limit of weight holds no lift
        great = 56.0 if most_kg is None else 66.0  # who limits weight in water counts on it
        yield (great if is_much else 33.0), Risk("the cameras float and need ballast", because, figure)

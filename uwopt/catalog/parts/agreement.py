"""Keys of an inline record that do not agree with each other; needs no NumPy, as loading a file does not."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from uwopt.catalog.parts.camera import Camera
from uwopt.catalog.parts.cell import fields_of
from uwopt.catalog.parts.housing import Housing
from uwopt.catalog.parts.lens import Lens
from uwopt.catalog.parts.light import Light
from uwopt.catalog.parts.part import Part

Fault = tuple[str, str]  # key, and the rest of the sentence


def unordered(record: type[Part], values: Mapping[str, Any]) -> list[Fault]:
    """Keys that are above the one they may at most equal."""
    found = []
    for field in fields_of(record):
        low, high = values.get(field.name), values.get(field.cell.at_most)
        if low is not None and high is not None and low > high:
            found.append((field.name, f"= {low:g} is above {field.cell.at_most} = {high:g}; swap them"))
    return found


def port_faults(values: Mapping[str, Any]) -> list[Fault]:
    """Keys of an inline port that do not agree."""
    radius_mm, thickness_mm = values.get("outer_radius_mm"), values.get("thickness_mm")
    is_dome = values.get("geometry") == "dome"
    faults = []
    if is_dome and radius_mm is None:
        faults.append(("outer_radius_mm", "is missing; a dome needs its outer radius in millimetres"))
    if is_dome and radius_mm is not None and thickness_mm is not None and thickness_mm >= radius_mm:
        faults.append(
            ("thickness_mm", f"= {thickness_mm:g} is not below outer_radius_mm = {radius_mm:g}; lower it")
        )
    if values.get("refractive_index") is not None and values.get("glass") is not None:
        faults.append(("glass", "and refractive_index are both given; keep one of them"))
    return faults


def light_faults(values: Mapping[str, Any]) -> list[Fault]:
    """Keys of an inline light that do not agree."""
    faults = unordered(Light, values)
    given = {name for name, value in values.items() if value is not None}
    is_flash = values.get("kind") == "flash" or (values.get("kind") is None and "flash_energy_j" in given)
    if is_flash and "flash_energy_j" not in given:
        faults.append(("flash_energy_j", "is missing; give the energy of one flash in joules"))
    if not is_flash and "flux_lm" not in given:
        faults.append(("flux_lm", "is missing; give the flux of one lamp at full in lumens"))
    if {"beam_half_angle_deg", "beam_angle_deg"} <= given:
        faults.append(("beam_half_angle_deg", "and beam_angle_deg are both given; keep one of them"))
    if "beam_medium" in given and "beam_half_angle_deg" in given:
        faults.append(("beam_medium", "belongs to beam_angle_deg; beam_half_angle_deg is always in water"))
    if not given & {"beam_half_angle_deg", "beam_angle_deg", "beam_profile"}:
        text = "is missing; give the half-angle in water in degrees, or beam_angle_deg, or beam_profile"
        faults.append(("beam_half_angle_deg", text))
    if values.get("beam") == "tabulated" and "beam_profile" not in given:
        faults.append(
            ("beam_profile", "is missing; a tabulated beam needs a CSV with angle_deg and intensity")
        )
    return faults


def housing_faults(values: Mapping[str, Any]) -> list[Fault]:
    """Keys of an inline housing that do not agree."""
    faults = unordered(Housing, values)
    if values.get("shape") != "sphere" and values.get("inner_length_mm") is None:
        faults.append(("inner_length_mm", "is missing; a tube needs its length between the end caps in millimetres"))
    return faults


#: What does not agree, by kind.
FAULTS: dict[str, Callable[[Mapping[str, Any]], list[Fault]]] = {
    "camera": partial(unordered, Camera),
    "lens": partial(unordered, Lens),
    "port": port_faults,
    "light": light_faults,
    "housing": housing_faults,
}

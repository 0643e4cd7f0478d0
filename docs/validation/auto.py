# ruff: noqa: E501 - a line of the page's text is as long as the expressions in it
"""Section 9: what physics `auto` leaves out of each mission in problems/, and what that changes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from . import common

PROBLEMS = common.ROOT / "problems"
SETTINGS = ("f_number", "exposure_ms", "pulse_ms", "gain", "dim_frac", "frame_rate_hz", "focus_distance_m")
RATIOS = {  # held against each other absolutely
    "mean_level", "overlap", "saturation_fraction", "saturation", "min_contrast", "contrast", "min_uniformity", "uniformity",
    "min_mtf_half_nyquist", "duty", "duty_frac",
}  # fmt: skip
LONGEST_SEARCH_S = 90.0
DECIBEL = 0.05  # what counts as much as the tolerance of 0.005


@dataclass
class Case:
    """One mission with one system in both physics."""

    name: str
    source: str
    effects: list[dict[str, Any]] = field(default_factory=list)
    tolerance: float = 0.005
    most: float = 0.0  # change of a figure over its allowance, times the tolerance
    where: str = "-"
    fault: str = ""

    @property
    def met(self) -> bool:
        """Whether the contract holds."""
        return not self.fault and self.most <= self.tolerance


def as_system(design: Any) -> dict[str, Any]:
    """A recommended design as a system file."""
    hardware = design.hardware
    system: dict[str, Any] = {kind: hardware[kind]["id"] for kind in ("camera", "lens", "port", "light")}
    system |= {key: hardware[key] for key in ("camera_count", "light_count", "orientation", "light_mounts")}
    system["scenes"] = {
        s.name: {key: s.settings[key] for key in SETTINGS if s.settings[key] is not None}
        for s in design.scenes
    }
    return system


def change(requirement: str, auto: float | None, full: float | None) -> float:
    """How much a figure differs, on the scale of the tolerance."""
    if auto is None or full is None:
        return 0.0 if auto is full else math.inf
    if not (math.isfinite(auto) and math.isfinite(full)):
        return 0.0 if auto == full else math.inf
    if "snr_db" in requirement:
        return abs(auto - full) / DECIBEL * 0.005
    if requirement in RATIOS:
        return abs(auto - full)
    if auto == full:
        return 0.0
    return abs(auto - full) / abs(full) if full else math.inf


def compared(case: Case, mission: Path, system: Any) -> Case:
    """Both physics of one system, margin by margin."""
    import uwopt

    auto, full = (uwopt.evaluate(mission, system, physics=p) for p in ("auto", "full"))
    case.effects, case.tolerance = auto.physics["effects"], auto.physics["tolerance"]
    pairs = [("objective", auto.objective["value"], full.objective["value"])]
    assert auto.design is not None and full.design is not None
    for one, other in zip(auto.design.scenes, full.design.scenes, strict=True):
        pairs += [(a.requirement, a.value, b.value) for a, b in zip(one.margins, other.margins, strict=True)]
    for requirement, one_value, other_value in pairs:
        off = change(requirement, one_value, other_value)
        if off > case.most:
            case.most, case.where = off, requirement
    return case


@cache
def cases() -> tuple[Case, ...]:
    """All missions: with their system file, else with the system that `solve` recommends."""
    import uwopt

    found = []
    for mission in sorted(p for p in PROBLEMS.glob("*.yaml") if not p.stem.endswith(".system")):
        own = mission.with_name(f"{mission.stem}.system.yaml")
        case = Case(mission.stem, "file" if own.exists() else "solved")
        try:
            system: Any = own
            if not own.exists():
                best = uwopt.solve(mission, physics="auto", seconds=LONGEST_SEARCH_S).recommendation
                if best is None:
                    case.fault = "nothing fits"
                    found.append(case)
                    continue
                system = as_system(best)
            found.append(compared(case, mission, system))
        except Exception as fault:  # a defect belongs on the page, beside what works
            case.fault = f"{type(fault).__name__}: {str(fault)[:160]}"
            found.append(case)
    return tuple(found)


def bound(effect: dict[str, Any]) -> str:
    """An effect's bound, in bold when it is kept."""
    value = (
        "asked" if effect["bound"] is None else ("0" if effect["bound"] == 0 else f"{effect['bound']:.1e}")
    )
    return f"**{value}**" if effect["kept"] else value


def section() -> str:
    """The text."""
    names = [e["name"] for e in next(c for c in cases() if c.effects).effects]
    rows = [
        [c.name, c.source, *(bound(e) for e in c.effects), f"{c.most:.1e}", c.where, "yes" if c.met else "NO"]
        for c in cases()
        if not c.fault
    ]
    faults = [f"`{c.name}`: {c.fault}" for c in cases() if c.fault]
    fine = [c for c in cases() if not c.fault]
    broken = [c.name for c in fine if not c.met]
    worst = max(fine, key=lambda c: c.most)
    head = ["mission", "system", *(n.replace("_", " ") for n in names), "auto to full", "in", "met"]
    left_out = sum(not e["kept"] for c in fine for e in c.effects)
    return f"""\
**In short:** contract {"met" if not broken else "BROKEN"} by {len(fine) - len(broken)} of {len(fine)} missions that could be judged, largest change {worst.most:.1e} of {fine[0].tolerance:g} allowed{f"; {len(faults)} not judged" if faults else ""}.

Independent of: nothing, this holds two settings of the same program against each other; the contract is PHYSICS section 9.
Each mission in `problems/` with its system file, else with the system that `uwopt solve` recommends in `auto`; bound of
each effect, in bold where it is kept; the largest change of any requirement's figure or the objective (ratios absolutely,
{DECIBEL} dB counting as 0.005, all else relatively), allowed: {fine[0].tolerance:g}.

{common.table(head, rows)}

{left_out} of {sum(len(c.effects) for c in fine)} effects are left out; the largest change is {worst.most:.1e} ({worst.name}, {worst.where}). The
contract is {"met by all" if not broken else f"BROKEN by {', '.join(broken)}"}. "asked": a requirement of its own, kept without a bound;
0: no requirement of the mission feels it.
{("What falls short: " + "; ".join(faults) + ".") if faults else f"Falls short: nothing found; these are {len(cases())} missions, not all."}
"""

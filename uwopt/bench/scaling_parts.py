"""Catalogues of any size, made from the real parts: all four kinds grow by one factor, and no part dominates another.

A made part is a real one with its numbers perturbed. Its price is a strictly rising function of everything
that more (or less) of is better in every mission, so a part that is as good as another in all of these is
dearer: nothing can be thrown away by comparing parts of one kind with each other. Lights and cameras keep the
beam, spectrum and efficiency curve of the part they are made from, as a maker's models do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, TypeVar

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.load import built_in_catalog
from uwopt.catalog.records import Camera, Lens, Light, Part, Port, Quantity, exact
from uwopt.forward.parts import Parts

P = TypeVar("P", bound=Part)
SEED = 20
SOURCE = "made for the scaling benchmark"
STATES = 8  # numbers of lamps (4) times orientations (2) times mounts (1) that every design of parts comes in
DEPTH_M = 10.0  # parts without a depth rating for it are left out


@dataclass(frozen=True)
class Trait:
    """A number of a part: `worth` is the power of it that the price follows, `spread` how far it is varied.

    Worth 0: neither more nor less is better everywhere.
    """

    worth: float
    spread: float


TRAITS: dict[str, dict[str, Trait]] = {
    "camera": {
        "power_w": Trait(-0.7, 0.2), "read_noise_e": Trait(-0.3, 0.2), "saturation_e": Trait(0.4, 0.2),
        "qe_scale": Trait(0.8, 0.1), "max_frame_rate_hz": Trait(0.1, 0.1), "mass_g": Trait(-0.1, 0.2),
        "max_gain_db": Trait(0.1, 0.0), "min_exposure_us": Trait(-0.05, 0.0), "bandwidth_mb_s": Trait(0.1, 0.0),
    },
    "lens": {
        "focal_length_mm": Trait(0.0, 0.1), "f_number_min": Trait(-0.8, 0.08), "transmission_frac": Trait(1.0, 0.05),
        "min_object_distance_m": Trait(-0.1, 0.2), "mass_g": Trait(-0.2, 0.2), "image_circle_mm": Trait(0.5, 0.0),
    },
    "port": {
        "outer_radius_mm": Trait(0.0, 0.1), "thickness_mm": Trait(-0.5, 0.15), "mass_g": Trait(-0.4, 0.2),
        "depth_rating_m": Trait(0.1, 0.0),
    },
    "pulsed_led": {  # the first family of lights is the first light of every catalogue
        "flux_lm": Trait(0.7, 0.2), "power_w": Trait(-0.4, 0.2), "mass_g": Trait(-0.1, 0.2),
        "max_duty_frac": Trait(0.1, 0.0), "depth_rating_m": Trait(0.1, 0.0),
    },
    "continuous": {
        "flux_lm": Trait(0.7, 0.2), "power_w": Trait(-0.4, 0.2), "mass_g": Trait(-0.1, 0.2),
        "depth_rating_m": Trait(0.1, 0.0),
    },
    "flash": {
        "flash_energy_j": Trait(0.6, 0.2), "recycle_s": Trait(-0.3, 0.2), "mass_g": Trait(-0.1, 0.2),
        "charging_efficiency_frac": Trait(0.4, 0.15), "depth_rating_m": Trait(0.1, 0.0),
    },
}  # fmt: skip


def family(part: Part) -> str:
    """Whose traits a part has: of a light those of its kind, which lights of another kind do not share."""
    if isinstance(part, Light):
        return part.kind
    return "camera" if isinstance(part, Camera) else "lens" if isinstance(part, Lens) else "port"


def central(number: Quantity | float | None) -> float:
    """The central value; NaN when there is none."""
    if number is None:
        return float("nan")
    return number.value if isinstance(number, Quantity) else float(number)


def merit(part: Part) -> float:
    """How good a part is by all that has a worth, as the logarithm of what it should cost."""
    worths = ((name, trait.worth) for name, trait in TRAITS[family(part)].items() if trait.worth)
    return float(sum(worth * np.log(central(getattr(part, name))) for name, worth in worths))


@cache
def base_parts() -> tuple[tuple[Part, ...], ...]:
    """Cameras, lenses, ports and lights that can be searched, each kind in a fixed shuffled order."""
    catalog = built_in_catalog()
    unfit = {item.part_id for item in catalog.exclusions}
    kinds: tuple[Sequence[Part], ...] = (catalog.cameras, catalog.lenses, catalog.ports, catalog.lights)
    shuffled = []
    for number, kind in enumerate(kinds):
        fit = [p for p in kind if p.id not in unfit and deep_enough(p)]
        order = np.random.default_rng([SEED, number]).permutation(len(fit))
        shuffled.append(tuple(one_of_each_first([fit[int(i)] for i in order])))
    return tuple(shuffled)


def one_of_each_first(parts: list[P]) -> list[P]:
    """The same parts with one of every family in front, so that small catalogues have all kinds of lights."""
    first = {family(part): part for part in reversed(parts)}
    led = [first[name] for name in TRAITS if name in first]
    return led + [part for part in parts if part not in led]


def deep_enough(part: Part) -> bool:
    """Whether a part is rated for the depth, if it must be."""
    return not isinstance(part, Port | Light) or (part.depth_rating_m or 0.0) >= DEPTH_M


def counts_for(size: float) -> tuple[int, int, int, int]:
    """How many cameras, lenses, ports and lights make about so many combinations, all grown by one factor."""
    base = [len(kind) for kind in base_parts()]
    factor = (size / (STATES * float(np.prod(base)))) ** 0.25
    camera, lens, port, light = (max(1, round(n * factor)) for n in base)
    return camera, lens, port, light


def made_parts(size: float) -> Parts:
    """Parts that make about so many combinations. Smaller catalogues are the beginnings of larger ones."""
    cameras, lenses, ports, lights = (
        made_kind(base, count, number)
        for number, (base, count) in enumerate(zip(base_parts(), counts_for(size), strict=True))
    )
    return Parts(
        tuple(p for p in cameras if isinstance(p, Camera)), tuple(p for p in lenses if isinstance(p, Lens)),
        tuple(p for p in ports if isinstance(p, Port)), tuple(p for p in lights if isinstance(p, Light)),
    )  # fmt: skip


def made_kind(base: Sequence[P], count: int, number: int) -> list[P]:
    """So many parts of one kind: every base part in turn, each time with other numbers."""
    widest = max(len(traits) for traits in TRAITS.values())
    draws = np.random.default_rng([SEED, number, 1]).uniform(-1.0, 1.0, (count, widest))  # row by row
    typical = typical_prices(base)
    return [made_part(base[i % len(base)], f"{i // len(base)}", draws[i], typical) for i in range(count)]


def typical_prices(base: Sequence[Part]) -> dict[str, tuple[float, float]]:
    """Median logarithm of price and median merit by family."""
    found = {}
    for name in {family(p) for p in base}:
        own = [p for p in base if family(p) == name]
        price = float(np.median([np.log(central(p.price)) for p in own]))
        found[name] = (price, float(np.median([merit(p) for p in own])))
    return found


def made_part(part: P, suffix: str, draws: Array, typical: Mapping[str, tuple[float, float]]) -> P:
    """A part with every number varied within its spread, at the price that its merit asks for."""
    changes: dict[str, Any] = {"id": f"{part.id}--{suffix}", "generic": False}
    for (name, trait), draw in zip(TRAITS[family(part)].items(), draws, strict=False):
        old = getattr(part, name)
        if old is None or not trait.spread:
            continue
        value = central(old) * float(np.exp(trait.spread * draw))
        changes[name] = exact(value, "derived", SOURCE) if isinstance(old, Quantity) else value
        if name == "f_number_min" and isinstance(part, Lens):  # the range moves as a whole
            shift = value / central(old)
            changes["f_number_max"] = exact(central(part.f_number_max) * shift, "derived", SOURCE)
    made = replace(part, **changes)
    price, typical_merit = typical[family(part)]
    cost = float(np.exp(price + merit(made) - typical_merit))
    return replace(made, price=exact(cost, "derived", SOURCE), currency="USD")


__all__ = ["TRAITS", "base_parts", "counts_for", "family", "made_parts", "merit"]

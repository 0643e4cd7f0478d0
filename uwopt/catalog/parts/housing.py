"""Housings behind ports, dry inside: what is stated of one, and what the model reads."""

import math
from typing import Annotated, Literal

from pydantic.dataclasses import dataclass

from uwopt.catalog.parts.cell import NEEDED, POSITIVE, Cell, Inline, Range
from uwopt.catalog.parts.part import RATED_TIME, Part, PartKind, shown_depth
from uwopt.catalog.parts.quantity import Known

ANY_PORT = "any"  # in `ports`: an end cap is made for the port
SIZE_MM = (0.1, 1e6)


@dataclass(frozen=True, slots=True)
class Housing(Part):
    """A tube with two ends, one of which takes a port, or a sphere that is its own port."""

    shape: Annotated[Literal["tube", "sphere"], Cell("shape of the housing: tube or sphere")] = "tube"
    material: Annotated[str, Cell("material, such as aluminium, titanium or acrylic")] = ""
    inner_diameter_mm: Annotated[
        float | None,
        Cell(
            "inner diameter in millimetres",
            POSITIVE,
            span=SIZE_MM,
            unknown=math.inf,
            needed=True,
            tells=True,
            inline=NEEDED,
        ),
    ] = None
    inner_length_mm: Annotated[
        float | None,
        Cell("length of a tube between its end caps in millimetres", POSITIVE, span=SIZE_MM, unknown=math.inf),
    ] = None
    wall_mm: Annotated[Known, Cell("thickness of the wall in millimetres", POSITIVE, span=SIZE_MM)] = None
    outer_diameter_mm: Annotated[
        Known,
        Cell("outer diameter in millimetres", POSITIVE, span=SIZE_MM, inline=Inline(unless="inner diameter and walls")),
    ] = None
    outer_length_mm: Annotated[
        Known,
        Cell("length over all in millimetres, without the port", POSITIVE, span=SIZE_MM),
    ] = None
    depth_rating_m: Annotated[float | None, Cell("depth rating in metres", POSITIVE)] = None
    rated_time_h: Annotated[float | None, RATED_TIME] = None
    penetrators: Annotated[int | None, Cell("holes for cables in its end cap", Range(0.0, 1e3))] = None
    displaced_g: Annotated[Known, Cell(in_files=False)] = None  # of water, where the mass in water is stated
    ports: Annotated[
        tuple[str, ...],
        Cell("patterns of the ports that fit; any: an end cap is made for each that is no wider"),
    ] = ()


def _summary(housing: Housing) -> tuple[str, ...]:
    inner = f"{housing.inner_diameter_mm:g} mm inside" if housing.inner_diameter_mm is not None else ""
    length = f"{housing.inner_length_mm:g} mm long" if housing.inner_length_mm is not None else ""
    return (housing.shape, housing.material, inner, length, shown_depth(housing.depth_rating_m, housing.rated_time_h))


KIND = PartKind(
    "housing",
    Housing,
    files={"housings.csv": "published", "generic_housings.csv": "generic"},
    example={
        "id": "acme-tube-100-200",
        "manufacturer": "Acme",
        "model": "tube 100 x 200",
        "availability": "current",
        "shape": "tube",
        "material": "aluminium",
        "inner_diameter_mm": "100",
        "inner_length_mm": "200",
        "outer_diameter_mm": "114",
        "outer_length_mm": "240",
        "depth_rating_m": "500",
        "penetrators": "4",
        "ports": "acme-dome-75",
        "mass_g": "2200",
        "price": "600",
        "currency": "USD",
    },
    summary=_summary,
    inline_doc="A housing in a system file.",
)

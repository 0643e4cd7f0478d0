"""Windows between water and lens: what is stated of one, and what the model reads."""

import math
from typing import Annotated, ClassVar, Literal

from pydantic.dataclasses import dataclass

from uwopt.catalog.parts.cell import FROM_ZERO, NEEDED, POSITIVE, SMALLEST, UNSEEN, Cell, Inline, Range
from uwopt.catalog.parts.housing import Housing
from uwopt.catalog.parts.part import RATED_TIME, Part, PartKind, marked_number, shown_depth
from uwopt.catalog.parts.quantity import Known, Quantity

Purpose = Literal[
    "camera port",
    "photo port",
    "sealed float",
    "laboratory window",
    "display dome",
    "lamp window",
    "part of a camera",
    "detector vessel",
    "one-off",
]

GUESSED = ("estimated", "generic")  # statuses of what no source states of this very part
REFRACTIVE_INDEX = Quantity(1.5, 1.46, 1.52, "estimated", "default of an inline port")
THICKNESS_MM = Quantity(10.0, 5.0, 15.0, "estimated", "default of an inline port")


@dataclass(frozen=True, slots=True)
class Port(Part):
    """A window between water and lens: flat, or a concentric dome."""

    geometry: Annotated[
        Literal["flat", "dome"],
        Cell("shape of the window: flat or dome", needed=True, tells=True, inline=NEEDED),
    ] = "flat"
    purpose: Annotated[
        Purpose, Cell("what it is made and sold for", inline="never")
    ] = "camera port"
    mount: Annotated[
        str, Cell("what it is fastened to, such as nauticam-n120; empty: a free flange", inline="never")
    ] = ""
    material: Annotated[str, Cell("material, such as acrylic")] = ""
    refractive_index: Annotated[
        Known,
        Cell(
            "refractive index of the window",
            Range(1.0, 3.0, open_low=True),
            favours="high",
            unknown=1.5,
            inline=Inline(unless="1.5 unless glass or this is given"),
        ),
    ] = None  # constant: no dispersion formula
    glass: Annotated[str, Cell("id of a dispersion formula, such as n_bk7")] = ""
    outer_radius_mm: Annotated[
        Known,
        Cell(
            "outer radius of a dome in millimetres",
            POSITIVE,
            span=(0.1, 1e6),
            favours="either",
            inline=Inline(names=("radius_mm",)),
        ),
    ] = None
    outer_radius_low_mm: ClassVar[Annotated[float, Cell("", POSITIVE, at_most="outer_radius_high_mm")]]
    outer_radius_high_mm: ClassVar[Annotated[float, Cell("", POSITIVE)]]
    thickness_mm: Annotated[
        Known,
        Cell(
            "thickness in millimetres",
            POSITIVE,
            span=(1e-3, 1e6),
            favours="low",
            at_most="outer_radius_mm",
            inline=Inline(unless="10 unless given", estimate=THICKNESS_MM),
        ),
    ] = None
    clear_diameter_mm: Annotated[
        Known,
        Cell("clear diameter in millimetres", POSITIVE, span=(0.01, 1e6), favours="high", unknown=math.inf),
    ] = None
    nominal_diameter_mm: ClassVar[Annotated[float, Cell("trade size", POSITIVE)]]
    gap_mm: Annotated[
        float,
        Cell(
            "distance from the lens's entrance pupil to a flat port in millimetres",
            FROM_ZERO,
            span=(SMALLEST, 1e6),
        ),
    ] = 0.0  # to its inner face
    depth_rating_m: Annotated[float | None, Cell("depth rating in metres", POSITIVE)] = (
        None  # never estimated
    )
    rated_time_h: Annotated[float | None, RATED_TIME] = None
    housing: Annotated[Housing | None, UNSEEN] = None  # that it is built into, where housings are searched

    @property
    def enclosure_id(self) -> str:
        """The id of the port with that of its housing: a port in another housing is another choice."""
        return self.id if self.housing is None or self.complete else f"{self.id} in {self.housing.id}"

    @property
    def width_mm(self) -> float | None:
        """How wide the opening is that it closes; None where nothing tells."""
        if self.clear_diameter_mm is not None:
            return self.clear_diameter_mm.value
        return 2.0 * self.outer_radius_mm.value if self.geometry == "dome" and self.outer_radius_mm else None

    @property
    def outer_width_mm(self) -> float | None:
        """How wide it is itself: a dome over its glass, a window as the opening that it closes."""
        if self.geometry == "dome" and self.outer_radius_mm is not None:
            over_rim_mm = 2.0 * math.sqrt(self.outer_radius_mm.value**2 - self.rim_inset_mm**2)
            return max(over_rim_mm, self.width_mm or 0.0)
        return self.width_mm

    @property
    def rim_inset_mm(self) -> float:
        """How far the centre of a dome's sphere lies behind its rim: 0 of a hemisphere.

        A dome is a spherical cap where its opening is a fact, and narrower than its sphere inside.
        """
        opening, radius = self.clear_diameter_mm, self.outer_radius_mm
        if self.geometry != "dome" or self.complete or radius is None or opening is None or opening.status in GUESSED:
            return 0.0
        inner_mm = radius.value - (0.0 if self.thickness_mm is None else self.thickness_mm.value)
        return math.sqrt(max(inner_mm**2 - (0.5 * opening.value) ** 2, 0.0))


def _summary(port: Port) -> tuple[str, ...]:
    size = marked_number("radius ", port.outer_radius_mm, " mm")
    return (port.geometry, port.material, size, shown_depth(port.depth_rating_m, port.rated_time_h))


KIND = PartKind(
    "port",
    Port,
    files={"ports.csv": "published", "generic_ports.csv": "generic"},
    example={
        "id": "acme-dome-75",
        "manufacturer": "Acme",
        "model": "dome",
        "availability": "current",
        "geometry": "dome",
        "material": "acrylic",
        "glass": "pmma",
        "outer_radius_mm": "75",
        "thickness_mm": "8",
        "depth_rating_m": "300",
        "mass_g": "600",
        "price": "350",
        "currency": "USD",
    },
    summary=_summary,
    inline_doc="A port in a system file.",
)

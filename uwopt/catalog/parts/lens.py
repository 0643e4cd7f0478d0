"""Lenses: what is stated of one, and what the model reads."""

import math
from typing import Annotated, ClassVar, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from uwopt.catalog.parts.cell import FROM_ZERO, NEEDED, POSITIVE, POSITIVE_SHARE, UNSEEN, Cell, Inline, Range
from uwopt.catalog.parts.part import FORMAT, MOUNTS, Part, PartKind, marked_number
from uwopt.catalog.parts.quantity import Known, Quantity, Status
from uwopt.documents.key_types import NUMBER

F_NUMBERS = (1.4, 16.0)  # widest and smallest opening of an inline lens that does not say
Lengths = tuple[Annotated[float, Field(gt=0, le=100), NUMBER], ...]
F_NUMBER = Range(0.4, 128.0, open_low=True)
TRANSMISSION = Quantity(0.9, 0.8, 1.0, "estimated", "default of an inline lens")


@dataclass(frozen=True, slots=True)
class Lens(Part):
    """A lens of fixed focal length (a zoom counts at its shortest)."""

    focal_length_mm: Annotated[
        float,
        Cell(
            "focal length in air in millimetres",
            Range(0.0, 1e4, open_low=True),
            span=(0.05, 1e4),
            needed=True,
            tells=True,
            inline=NEEDED,
        ),
    ] = 0.0
    f_number_min: Annotated[
        Known,
        Cell(
            "f-number of the widest opening",
            F_NUMBER,
            favours="low",
            unknown=1.0,
            at_most="f_number_max",
            inline=Inline(default=F_NUMBERS[0], names=("f_min",)),
        ),
    ] = None
    f_number_max: Annotated[
        Known,
        Cell(
            "f-number of the smallest opening",
            F_NUMBER,
            favours="high",
            unknown=16.0,
            inline=Inline(unless=f"{F_NUMBERS[1]:g} unless given", names=("f_max",)),
        ),
    ] = None
    aperture_control: Annotated[
        Literal["manual", "motorised", "fixed", "unknown"],
        Cell("how the aperture is set: manual, motorised, fixed or unknown"),
    ] = "unknown"
    image_circle_mm: Annotated[
        float | None,
        Cell(
            "diameter of the image circle in millimetres",
            POSITIVE,
            span=(0.01, 1e5),
            status="image_circle_status",
        ),
    ] = None  # published, or derived from the optical format
    image_circle_status: Annotated[Status, UNSEEN] = "published"
    optical_format_in: Annotated[str, FORMAT] = ""
    mounts: Annotated[tuple[str, ...], MOUNTS] = ()
    transmission_frac: Annotated[
        Known,
        Cell(
            "transmission (share 0..1 of the light)",
            POSITIVE_SHARE,
            span=(1e-9, 1.0),
            favours="high",
            unknown=1.0,
            inline=Inline(unless="0.9 unless given", estimate=TRANSMISSION, names=("transmission",)),
        ),
    ] = None
    rated_megapixel: ClassVar[Annotated[float, Cell("", POSITIVE)]]
    rated_pixel_pitch_um: Annotated[float | None, Cell("rated pixel pitch in micrometres", POSITIVE)] = None
    rated_lp_per_mm: Annotated[
        float | None, Cell("rated resolution in line pairs per millimetre", POSITIVE)
    ] = None
    aberration_pitch_um: Annotated[
        Known,
        Cell(
            "pixel pitch in micrometres at whose Nyquist frequency aberrations alone halve the contrast, "
            "wide open on the axis; 0 none",
            FROM_ZERO,
            favours="low",
            inline=Inline(unless="by its rating unless given"),
        ),
    ] = None
    min_object_distance_m: Annotated[
        Known, Cell("nearest focus in air in metres", FROM_ZERO, favours="low")
    ] = None
    distortion_pct: Annotated[float | None, Cell("distortion in per cent")] = None
    length_mm: Annotated[Known, Cell("length in millimetres", POSITIVE, favours="low")] = None
    diameter_mm: Annotated[Known, Cell("diameter in millimetres", POSITIVE, favours="low")] = None
    pupil_mm: Annotated[
        Known, Cell("distance of the entrance pupil behind the lens's front in millimetres", FROM_ZERO)
    ] = None
    spacers_mm: Annotated[
        tuple[float, ...] | None,
        Cell(
            "lengths of spacer rings that may stand behind it in millimetres, such as 0.5|1|5; none forbids them",
            form="text",
            inline=Inline(doc="lengths in millimetres of the spacer rings that may stand behind it", type=Lengths),
        ),
    ] = None  # None: what is sold for its mount
    thread_travel_mm: Annotated[
        Known,
        Cell(
            "how far it may be screwed out of its thread beyond its nearest focus in millimetres",
            FROM_ZERO,
            favours="high",
        ),
    ] = None
    max_magnification: Annotated[
        Known,
        Cell(
            "largest magnification that it bears on a spacer ring or screwed out",
            POSITIVE,
            favours="high",
            unknown=math.inf,
        ),
    ] = None
    filter_thread: ClassVar[Annotated[str, Cell()]]
    is_zoom: ClassVar[Annotated[bool, Cell()]]


def _summary(lens: Lens) -> tuple[str, ...]:
    circle = "" if lens.image_circle_mm is None else f"circle {lens.image_circle_mm:g} mm"
    return (f"{lens.focal_length_mm:g} mm", marked_number("F", lens.f_number_min, ""), circle, "/".join(lens.mounts))


KIND = PartKind(
    "lens",
    Lens,
    files={"lenses.csv": "published"},
    example={
        "id": "acme-lens-8",
        "manufacturer": "Acme",
        "model": "8 mm",
        "availability": "current",
        "focal_length_mm": "8",
        "f_number_min": "1.8",
        "f_number_max": "16",
        "aperture_control": "manual",
        "optical_format_in": "2/3",
        "mounts": "C",
        "rated_pixel_pitch_um": "3.45",
        "min_object_distance_m": "0.1",
        "mass_g": "80",
        "price": "300",
        "currency": "USD",
    },
    summary=_summary,
    inline_doc="A lens in a system file.",
)

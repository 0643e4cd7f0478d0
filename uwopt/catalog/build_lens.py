"""A row of lenses.csv becomes a `Lens`: image circle from the format, the rest by class."""

from __future__ import annotations

from functools import cache
from typing import Literal

from uwopt.catalog.build import Built, Origin, identity, known, known_or
from uwopt.catalog.compatibility import canonical_mount
from uwopt.catalog.estimates import ClassEstimate, required_class
from uwopt.catalog.records import Lens, Quantity, Status
from uwopt.catalog.tables import built_in_rows
from uwopt.catalog.userparts import PartRow

SMALL_CIRCLE_MM, MEDIUM_CIRCLE_MM = 11.5, 18.0  # borders of the classes in class_estimates.csv
SHORT_FOCAL_MM, MIDDLE_FOCAL_MM = 20.0, 30.0

_CONTROLS: dict[str, Literal["manual", "motorised", "fixed"]] = {
    "manual": "manual",
    "motorised": "motorised",
    "fixed": "fixed",
}


def build_lens(row: PartRow, origin: Origin) -> Built:
    """The lens of a row, with what the model needs filled in."""
    circle_mm, circle_status = _image_circle(row, origin)
    focal_mm = row.number("focal_length_mm") or 0.0
    mass = required_class("lens-mass-g", _circle_class(circle_mm), "any")
    lens = Lens(
        **identity(row, origin, _price_class(row, circle_mm), "USD", mass.quantity()),
        focal_length_mm=focal_mm,
        f_number_min=known_or(row, "f_number_min", origin, required_class("lens-f-number-min", "any")),
        f_number_max=_f_number_max(row, origin),
        aperture_control=_CONTROLS.get(row.text("aperture_control"), "unknown"),
        image_circle_mm=circle_mm,
        image_circle_status=circle_status,
        optical_format_in=row.text("optical_format_in"),
        mounts=row.items("mounts"),
        transmission_frac=known_or(
            row, "transmission_frac", origin, required_class("lens-transmission-frac", "any")
        ),
        rated_pixel_pitch_um=row.number("rated_pixel_pitch_um"),
        rated_lp_per_mm=row.number("rated_lp_per_mm"),
        min_object_distance_m=known_or(row, "min_object_distance_m", origin, _nearest_focus_class(focal_mm)),
        distortion_pct=row.number("distortion_pct"),
        length_mm=row.number("length_mm"),
        diameter_mm=row.number("diameter_mm"),
    )
    lacks = []
    if not lens.mounts:
        lacks.append("no mount stated")
    if circle_mm is None:
        told = (
            f"format {lens.optical_format_in!r} is not known"
            if lens.optical_format_in
            else "no format stated"
        )
        lacks.append(f"image circle unknown: no diameter and {told}")
    return Built(lens, tuple(lacks))


@cache
def optical_format_diagonals_mm() -> dict[str, float]:
    """Diagonal that each optical format stands for, by its name."""
    return {row["format_in"]: float(row["diagonal_mm"]) for row in built_in_rows("optical_formats.csv")}


def _image_circle(row: PartRow, origin: Origin) -> tuple[float | None, Status]:
    stated_mm = row.number("image_circle_mm")
    if stated_mm is not None:
        return stated_mm, origin
    name = row.text("optical_format_in").replace('"', "").replace("in", "").strip()
    return optical_format_diagonals_mm().get(name), "derived"


def _f_number_max(row: PartRow, origin: Origin) -> Quantity | None:
    """A fixed iris has one f-number; otherwise the stated smallest opening, else the class."""
    if row.text("aperture_control") == "fixed" and row.number("f_number_max") is None:
        fixed = known(row, "f_number_min", origin)
        if fixed is not None:
            return fixed
    return known_or(row, "f_number_max", origin, required_class("lens-f-number-max", "any"))


def _circle_class(circle_mm: float | None) -> str:
    if circle_mm is None:
        return ""
    if circle_mm <= SMALL_CIRCLE_MM:
        return "small-circle"
    return "medium-circle" if circle_mm <= MEDIUM_CIRCLE_MM else "large-circle"


def _nearest_focus_class(focal_mm: float) -> ClassEstimate:
    name = (
        "to-20mm"
        if focal_mm <= SHORT_FOCAL_MM
        else "to-30mm"
        if focal_mm <= MIDDLE_FOCAL_MM
        else "above-30mm"
    )
    return required_class("lens-min-object-distance-m", name)


HOBBY_MAKERS = ("arducam", "raspberry pi")  # whose C-mount lenses sell in the hobby class


def _price_class(row: PartRow, circle_mm: float | None) -> ClassEstimate:
    """By mount, image circle and rated megapixels."""
    if row.items("mounts") and {canonical_mount(mount) for mount in row.items("mounts")} == {"S"}:
        return required_class("lens-price", "rule-s-mount")
    if row.text("manufacturer").casefold() in HOBBY_MAKERS:
        return required_class("lens-price", "hobby")
    megapixel = row.number("rated_megapixel")
    circle = _circle_class(circle_mm)
    if circle == "large-circle":
        name = "rule-large-circle"
    elif circle == "medium-circle":
        name = "rule-medium-circle-above-15mp" if (megapixel or 0.0) > 15.0 else "rule-medium-circle"
    elif circle == "small-circle" and megapixel is not None:
        name = (
            "rule-up-to-3mp"
            if megapixel <= 3.0
            else "rule-up-to-6mp"
            if megapixel <= 6.0
            else "rule-above-6mp"
        )
    else:
        name = "any"
    return required_class("lens-price", name)

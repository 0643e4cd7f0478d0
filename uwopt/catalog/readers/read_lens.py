"""What is stated of a lens becomes a `Lens`: image circle from the format, the rest by class."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from uwopt.catalog.compatibility import canonical_mount, rated_pitch_um
from uwopt.catalog.estimates import ClassEstimate, required_class
from uwopt.catalog.parts.lens import F_NUMBERS, Lens
from uwopt.catalog.parts.quantity import Status
from uwopt.catalog.readers.reading import (
    Built,
    Origin,
    Reader,
    identity,
    inline_fields,
    known,
    row_fields,
    user_number,
)
from uwopt.catalog.tables import built_in_rows
from uwopt.catalog.userparts import PartRow, parse_spacers

SMALL_CIRCLE_MM, MEDIUM_CIRCLE_MM = 11.5, 18.0  # borders of the classes in class_estimates.csv
SHORT_FOCAL_MM, MIDDLE_FOCAL_MM = 20.0, 30.0


def from_row(row: PartRow, origin: Origin) -> Built:
    """The lens of a row, with what the model needs filled in."""
    circle_mm, circle_status = _image_circle(row, origin)
    classes = (circle_class(circle_mm), focal_class(row.number("focal_length_mm") or 0.0), "any")
    made = row_fields(Lens, row, origin, classes)
    made |= identity(row, origin, _price_class(row, circle_mm), "USD", made["mass_g"])
    made |= {"image_circle_mm": circle_mm, "image_circle_status": circle_status}
    if row.text("aperture_control") == "fixed" and row.number("f_number_max") is None:
        made["f_number_max"] = known(row, "f_number_min", origin) or made["f_number_max"]  # it has but one
    if spacers := row.text("spacers_mm"):
        made["spacers_mm"] = parse_spacers(spacers)
    lens = _with_aberrations(Lens(**made), stated=row.number("aberration_pitch_um") is not None)
    return Built(lens, tuple(_lacking(lens)))


def _lacking(lens: Lens) -> list[str]:
    lacks = []
    if not lens.mounts:
        lacks.append("no mount stated")
    if lens.image_circle_mm is None:
        name = lens.optical_format_in
        told = f"format {name!r} is not known" if name else "no format stated"
        lacks.append(f"image circle unknown: no diameter and {told}")
    return lacks


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


def circle_class(circle_mm: float | None) -> str:
    """The class of a lens by its image circle; empty where it is not known."""
    if circle_mm is None:
        return ""
    if circle_mm <= SMALL_CIRCLE_MM:
        return "small-circle"
    return "medium-circle" if circle_mm <= MEDIUM_CIRCLE_MM else "large-circle"


def focal_class(focal_mm: float) -> str:
    if focal_mm <= SHORT_FOCAL_MM:
        return "to-20mm"
    return "to-30mm" if focal_mm <= MIDDLE_FOCAL_MM else "above-30mm"


HOBBY_MAKERS = ("arducam", "raspberry pi")  # whose C-mount lenses sell in the hobby class


PHOTOGRAPHIC_MOUNTS = frozenset(("F", "EF", "MFT"))


def _aberration_class(lens: Lens) -> str:
    """By mount and maker; what nothing is known of counts as made for machine vision."""
    mounts = {canonical_mount(mount) for mount in lens.mounts}
    if mounts == {"S"} or lens.manufacturer.casefold() in HOBBY_MAKERS:
        return "board"
    return "photographic" if mounts and mounts <= PHOTOGRAPHIC_MOUNTS else "machine-vision"


def _with_aberrations(lens: Lens, *, stated: bool) -> Lens:
    """The lens with what aberrations blur wide open: as stated, else by its rating, else that of any lens."""
    rated_um = rated_pitch_um(lens)
    if stated:
        return lens
    if rated_um is None:
        return replace(lens, aberration_pitch_um=required_class("lens-aberration-pitch-um", "any").quantity())
    ratio = required_class("lens-aberration-per-rated", _aberration_class(lens))
    return replace(lens, aberration_pitch_um=ratio.quantity(rated_um))


def _price_class(row: PartRow, circle_mm: float | None) -> ClassEstimate:
    """By mount, image circle and rated megapixels."""
    if row.items("mounts") and {canonical_mount(mount) for mount in row.items("mounts")} == {"S"}:
        return required_class("lens-price", "rule-s-mount")
    if row.text("manufacturer").casefold() in HOBBY_MAKERS:
        return required_class("lens-price", "hobby")
    megapixel = row.number("rated_megapixel")
    circle = circle_class(circle_mm)
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


def from_inline(values: Mapping[str, Any], base_dir: Path | None) -> Lens:
    """The record of an inline lens."""
    made = inline_fields(Lens, "lens", values)
    smallest = values["f_number_max"] or max(F_NUMBERS[1], values["f_number_min"])
    lens = Lens(**made | {"f_number_max": user_number(smallest)})
    return _with_aberrations(lens, stated=lens.aberration_pitch_um is not None)


READER = Reader(from_row, from_inline)

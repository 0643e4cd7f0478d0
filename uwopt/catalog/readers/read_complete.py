"""What is stated of a complete camera becomes a `Complete`: its camera, lens and port read by their own readers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

from uwopt.catalog.compatibility import sensor_diagonal_mm
from uwopt.catalog.estimates import first_class, required_class
from uwopt.catalog.parts.complete import MOUNT, Complete
from uwopt.catalog.parts.part import Kind
from uwopt.catalog.parts.quantity import Quantity, exact
from uwopt.catalog.readers import read_camera, read_lens, read_port
from uwopt.catalog.readers.reading import Built, Origin, Reader, identity, known, row_fields
from uwopt.catalog.userparts import PartRow
from uwopt.errors import CatalogError

PIECES: tuple[tuple[Kind, Reader], ...] = (
    ("camera", read_camera.READER), ("lens", read_lens.READER), ("port", read_port.READER),
)  # fmt: skip
SEA_INDEX = 1.34  # in which makers state a field of view under water


def from_row(row: PartRow, origin: Origin) -> Built:
    """The complete camera of a row, with what the model needs filled in."""
    row = _with_focal_length(row)
    camera, lens, port = (
        reader.from_row(_of_piece(row, kind), origin)
        for kind, reader in PIECES
    )
    price = required_class("complete-price", row.text("family"), "any")
    mass = required_class("complete-mass-g", row.text("family"), "any").quantity()
    made = row_fields(Complete, row, origin, ())
    made |= identity(row, origin, price, "USD", mass)
    for name in ("outer_diameter_mm", "outer_length_mm"):
        key = f"complete-{name.replace('_', '-')}"
        made[name] = known(row, name, origin) or required_class(key, row.text("family"), "any").quantity()
    made |= _on_its_own(row, made) | {"displaced_g": _displaced(row, made["mass_g"])}
    body: Any = camera.part
    if made.get("storage_gb") is not None:  # no computer takes its images
        body = replace(body, host_power_w=exact(0.0), host_price=exact(0.0))
    made |= {"own_camera": body, "own_lens": lens.part, "own_port": port.part}
    vital = [*_lacking(row), *camera.lacks, *port.lacks]
    return Built(Complete(**made), tuple(reason for reason in vital if reason not in NO_LACK))


NO_LACK = ("no mount stated", "interface not stated", "thickness and diameter unknown")  # nothing else goes with it


def _displaced(row: PartRow, mass: Quantity) -> Quantity:
    """Mass of the water that it displaces: by its mass in water, else by its family's share of its mass."""
    in_water_g = row.number("mass_water_g")
    if in_water_g is not None:
        return exact(max(mass.value - in_water_g, 0.0), "derived", "mass less mass in water")
    return required_class("complete-displaced-over-mass", row.text("family"), "any").quantity(mass.value)


def _on_its_own(row: PartRow, made: Mapping[str, Any]) -> dict[str, Any]:
    """Card, timer and battery of what is sold to be carried by hand: of its family where the row does not say."""
    family = row.text("family")

    def of_family(name: str) -> Quantity | None:
        found = first_class(f"complete-{name.replace('_', '-')}", family)
        return None if found is None else found.quantity()

    room, lasts = of_family("storage_gb"), of_family("run_time_min")
    own: dict[str, Any] = {"min_interval_s": known(row, "min_interval_s", "published") or of_family("min_interval_s")}
    if made.get("storage_gb") is None and room is not None:
        own["storage_gb"] = room.value
    if made.get("run_time_min") is None and made.get("supply") == "battery" and lasts is not None:
        own["run_time_min"] = lasts.value
    return own


def _lacking(row: PartRow) -> list[str]:
    """Facts of the whole without which nothing can be computed."""
    lacks = []
    if row.number("resolution_x_px") is None or row.number("resolution_y_px") is None:
        lacks.append("resolution unknown")
    if row.number("pixel_pitch_um") is None:
        lacks.append("pixel pitch unknown")
    if row.number("focal_length_mm") is None:
        lacks.append("neither focal length nor a field of view that tells it")
    if row.number("f_number_min") is None:
        lacks.append("widest opening unknown")
    if row.text("projection") == "fisheye":
        lacks.append("a fisheye: the model's views are rectilinear")
    return lacks


def _of_piece(row: PartRow, kind: Kind) -> PartRow:
    """The row as that of one of its pieces, with what a piece alone would need."""
    cells = {name: cell for name, cell in row.cells.items() if name not in ("price", "mass_g")}
    cells["mounts"] = (MOUNT,)
    if kind == "lens":
        cells["image_circle_mm"] = _diagonal_mm(row)
        cells["focal_length_mm"] = row.number("focal_length_mm") or 0.0
    if kind == "port" and row.text("geometry") == "flat" and row.number("thickness_mm") is None:
        cells["thickness_mm"] = required_class("complete-window-mm", "any").central
    if kind == "camera":
        cells |= {name: row.number(name) or 0.0 for name in ("resolution_x_px", "resolution_y_px", "pixel_pitch_um")}
    return replace(row, kind=kind, cells=cells)


def _diagonal_mm(row: PartRow) -> float | None:
    sides = [row.number(name) for name in ("resolution_x_px", "resolution_y_px", "pixel_pitch_um")]
    if None in sides:
        return None
    return float(sensor_diagonal_mm(*(side or 0.0 for side in sides)))


def _with_focal_length(row: PartRow) -> PartRow:
    """The row with the focal length in air that its field of view tells, where it states none."""
    angle_deg, pitch_um, side = row.number("view_deg"), row.number("pixel_pitch_um"), row.text("view_side")
    pixels = {"horizontal": (1.0, 0.0), "vertical": (0.0, 1.0), "diagonal": (1.0, 1.0)}.get(side)
    wide, high = row.number("resolution_x_px"), row.number("resolution_y_px")
    stated = row.number("focal_length_mm") is not None
    if stated or None in (angle_deg, pitch_um, pixels, wide, high) or not row.text("view_medium"):
        return row
    half = math.radians(0.5 * (angle_deg or 0.0))
    if row.text("view_medium") == "water" and row.text("geometry") == "flat":  # a dome changes no angle
        if SEA_INDEX * math.sin(half) >= 1.0:
            raise CatalogError(f"{row.where}: view_deg = {angle_deg:g} is wider than any view through a flat port.")
        half = math.asin(SEA_INDEX * math.sin(half))
    across, up = pixels or (0.0, 0.0)
    half_mm = 0.5e-3 * (pitch_um or 0.0) * math.hypot(across * (wide or 0.0), up * (high or 0.0))
    return replace(row, cells={**row.cells, "focal_length_mm": half_mm / math.tan(half)})


def from_inline(values: Mapping[str, Any], base_dir: Path | None) -> NoReturn:
    """A system file writes an own one as its camera, its lens and its port."""
    raise CatalogError("a complete camera has no inline record; write its camera, lens and port")


READER = Reader(from_row, from_inline)

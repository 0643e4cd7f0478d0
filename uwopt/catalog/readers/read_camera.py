"""What is stated of a camera becomes a `Camera`: sensor figures by chip, then pixel family, then any."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from uwopt.catalog.curves.usercurves import read_channels
from uwopt.catalog.estimates import ClassEstimate, first_class, required_class
from uwopt.catalog.parts.camera import Camera
from uwopt.catalog.parts.quantity import Curve, Quantity, exact
from uwopt.catalog.readers.reading import (
    Built,
    Origin,
    Reader,
    identity,
    inline_fields,
    is_csv,
    row_fields,
    user_number,
)
from uwopt.catalog.readers.tabled import efficiencies
from uwopt.catalog.tables import built_in_rows
from uwopt.catalog.userparts import PartRow
from uwopt.documents.faults import nearest, plain_name
from uwopt.documents.whole_file import resolve_path
from uwopt.errors import CatalogError

CHANNELS = {"mono": ("mono",), "colour": ("red", "green", "blue")}
REFERENCE_CHANNEL = {"mono": "mono", "colour": "green"}  # the channel that makers state
OF_FAMILY = "E"  # grade of figures that are the maker's for a pixel family, not for the model
FLAT_NM = (200.0, 1200.0)  # span of an efficiency that is one number
BITS_PER_BYTE = 8
PIXELS_PER_MP = 1e6

# ---------------------------------------------------------------- rows of tables


def from_row(row: PartRow, origin: Origin) -> Built:
    """The camera of a row, with what the model needs filled in."""
    family = _family(row.text("chip"))
    classes = _classes(row, family)
    made = row_fields(Camera, row, origin, classes)
    price = _price_class(row.text("chip"), _pixels(row))
    made |= identity(row, origin, price, "USD", made["mass_g"]) | _bits(row, origin)
    made |= _efficiency_of_row(row, origin, family, classes)
    if (derived := _saturation_by_snr(row)) is not None:
        made["saturation_e"] = derived
    if row.text("perf_quality") == OF_FAMILY:
        made |= _by_family(made, row, classes)
    if "max_frame_rate_hz" not in made:
        made["max_frame_rate_hz"] = _rate_by_interface(
            made.get("bandwidth_mb_s"), _pixels(row), made["bit_depth"]
        )
    lacks = _lacking(row)
    if origin == "published" and made.get("bandwidth_mb_s") is None:
        lacks.append("interface not stated")
    return Built(Camera(**made), tuple(lacks))


def _classes(row: PartRow, family: Mapping[str, str]) -> tuple[str, ...]:
    chip = row.text("chip")
    return f"chip-{chip}" if chip else "", f"family-{family['pixel_family']}", row.text("interface"), "any"


def _pixels(row: PartRow) -> float:
    return (row.number("resolution_x_px") or 0.0) * (row.number("resolution_y_px") or 0.0)


def _bits(row: PartRow, origin: Origin) -> dict[str, Any]:
    stated = row.number("bit_depth")
    bits = required_class("camera-bit-depth", "any").central if stated is None else stated
    return {"bit_depth": int(bits), "bit_depth_status": "estimated" if stated is None else origin}


def _lacking(row: PartRow) -> list[str]:
    lacks = []
    if row.number("pixel_pitch_um") is None:
        lacks.append("pixel pitch unknown")
    if not row.text("colour"):
        lacks.append("mono or colour not stated")
    if not row.text("shutter"):
        lacks.append("shutter not stated")
    if not row.items("mounts"):
        lacks.append("no mount stated")
    return lacks


def _saturation_by_snr(row: PartRow) -> Quantity | None:
    """What is not stated, from the best ratio of signal to shot noise (EMVA 1288)."""
    snr_max_db = row.number("snr_max_db")
    if row.number("saturation_e") is not None or snr_max_db is None:
        return None
    return exact(10.0 ** (snr_max_db / 10.0), "derived", f"10^(snr_max_db / 10), snr_max_db = {snr_max_db:g}")


def _by_family(made: Mapping[str, Any], row: PartRow, classes: tuple[str, ...]) -> dict[str, Quantity]:
    """Sensor figures that the maker states of a family only: estimates, between the ends of the family's class."""
    mono_or_colour = row.text("colour") or "mono"
    by_class = {
        "read_noise_e": first_class("camera-read-noise-e", *classes),
        "saturation_e": first_class("camera-saturation-e", *classes),
        "qe_scale": first_class("camera-qe", *(f"{name}-{mono_or_colour}" for name in classes if name)),
    }
    stated = {"read_noise_e": "read_noise_e", "saturation_e": "saturation_e", "qe_scale": "qe"}
    return {
        name: _spread(made[name], row.number(stated[name]), estimate)
        for name, estimate in by_class.items()
        if estimate is not None and row.number(stated[name]) is not None
    }


def _spread(quantity: Quantity, stated: float | None, estimate: ClassEstimate) -> Quantity:
    """A number that is stated of a family, with the shares by which the ends of a class lie off it; it stays within."""
    share = quantity.value / (stated or quantity.value)
    source = f"the maker's figure of the pixel family, not of this model; range of {estimate.key}: {estimate.basis}"
    low, high = min(quantity.value, share * estimate.low), max(quantity.value, share * estimate.high)
    return Quantity(quantity.value, low, high, "estimated", source)


def _rate_by_interface(bandwidth: Quantity | None, pixels: float, bits: int) -> Quantity | None:
    """What the interface carries, as frames: an upper bound, the sensor may be slower."""
    if bandwidth is None or pixels <= 0.0:
        return None
    frames_per_mb = 1e6 / (pixels * bits / BITS_PER_BYTE)
    source = f"{bandwidth.value:g} MB/s over {pixels:g} pixels of {bits} bit; {bandwidth.source}"
    return Quantity(
        bandwidth.value * frames_per_mb,
        bandwidth.low * frames_per_mb,
        bandwidth.high * frames_per_mb,
        "estimated",
        source,
    )


def _price_class(chip: str, pixels: float) -> ClassEstimate | Quantity:
    """Price by chip, else the fit of price against megapixels."""
    by_chip = first_class("camera-price", f"chip-{chip}") if chip else None
    if by_chip is not None:
        return by_chip
    exponent = required_class("camera-price-exponent", "any").central
    return required_class("camera-price-scale", "any").quantity(max(pixels / PIXELS_PER_MP, 0.1) ** exponent)


def _efficiency_of_row(
    row: PartRow, origin: Origin, family: Mapping[str, str], classes: tuple[str, ...]
) -> dict[str, Any]:
    colour = row.text("colour") or "mono"
    curve_id, curves = _curves(row, family, colour)
    scale = _qe_scale(row, origin, curves[REFERENCE_CHANNEL[colour]], colour, classes)
    return {"qe_curves": curves, "qe_curve_id": curve_id, "qe_scale": scale}


def _qe_scale(row: PartRow, origin: Origin, curve: Curve, colour: str, classes: tuple[str, ...]) -> Quantity:
    """Factor that brings the curve's shape through the camera's own point, or through its class's."""
    qe, qe_nm = row.number("qe"), row.number("qe_nm")
    if row.text("qe_curve"):
        return exact(1.0, origin, "own curve")
    if qe is not None:
        at = max(curve.y) if qe_nm is None else float(np.interp(qe_nm, curve.x, curve.y))
        where = "its peak" if qe_nm is None else f"{qe_nm:g} nm"
        return exact(qe / at, "derived", f"published {qe:g} at {where} over {at:.4g} of the curve")
    by_class = required_class("camera-qe", *(f"{name}-{colour}" for name in classes if name))
    return by_class.quantity(1.0 / float(np.interp(by_class.at_nm or 530.0, curve.x, curve.y)))


@cache
def _families() -> dict[str, dict[str, str]]:
    return {row["chip"]: row for row in built_in_rows("qe_families.csv")}


def _family(chip: str) -> dict[str, str]:
    families = _families()
    bare = chip.split()[-1].upper() if chip else "any"
    return families.get(bare, families["any"])


def _curves(row: PartRow, family: Mapping[str, str], colour: str) -> tuple[str, dict[str, Curve]]:
    """Id and curves by channel: the row's own, a user's file, or those of the chip's family."""
    own = row.text("qe_curve")
    curve_id = own or family[f"{colour}_curve"]
    if is_csv(own):
        curves = read_channels((row.base_dir or Path()) / own, "qe")
    elif curve_id in efficiencies():
        curves = efficiencies()[curve_id]
    else:
        ids = ", ".join(efficiencies())
        raise CatalogError(f"{row.where}: qe_curve = {own!r} is no CSV and none of {ids}.")
    missing = [channel for channel in CHANNELS[colour] if channel not in curves]
    if missing:
        raise CatalogError(f"{row.where}: qe_curve {curve_id!r} lacks the channel {', '.join(missing)}.")
    return curve_id, curves


# ---------------------------------------------------------------- inline records


def from_inline(values: Mapping[str, Any], base_dir: Path | None) -> Camera:
    """The record of an inline camera."""
    made = inline_fields(Camera, "camera", values)
    if made.get("gain_dn_per_e") is not None:
        made.setdefault("gain_bits", made["bit_depth"])
    curve_id, curves = _efficiency(values["quantum_efficiency"], made["colour"], base_dir)
    return Camera(**made, qe_curves=curves, qe_curve_id=curve_id, qe_scale=user_number(1.0))


def _efficiency(value: float | str, colour: str, base_dir: Path | None) -> tuple[str, dict[str, Curve]]:
    channels = CHANNELS[colour]
    if isinstance(value, float):
        return "", dict.fromkeys(channels, Curve(FLAT_NM, (value, value)))
    if is_csv(value):
        found = read_channels(resolve_path(value, base_dir), "qe")
    else:
        value, found = _built_in_efficiency(value)
    if set(channels) <= set(found):
        return value, {channel: found[channel] for channel in channels}
    if "mono" in found:
        return value, dict.fromkeys(channels, found["mono"])
    have, need = ", ".join(sorted(found)), ", ".join(channels)
    raise CatalogError(
        f"quantum_efficiency {value!r} has the channels {have}; a {colour} camera needs {need}."
    )


def _built_in_efficiency(name: str) -> tuple[str, dict[str, Curve]]:
    by_name = {plain_name(curve_id): curve_id for curve_id in efficiencies()}
    curve_id = by_name.get(plain_name(name)) or by_name.get(plain_name("seed-" + name))
    if curve_id is None:
        near = nearest(name, sorted(efficiencies()))
        hint = f"did you mean {near!r}?" if near else f"known are {', '.join(sorted(efficiencies()))}."
        raise CatalogError(f"quantum_efficiency {name!r} is no curve; {hint}")
    return curve_id, efficiencies()[curve_id]


READER = Reader(from_row, from_inline)

"""A row of cameras.csv becomes a `Camera`: sensor figures by chip, then pixel family, then any."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Literal

import numpy as np

from uwopt.catalog.build import Built, Origin, identity, known, known_or
from uwopt.catalog.estimates import ClassEstimate, first_class, required_class
from uwopt.catalog.records import Camera, Curve, Quantity, exact
from uwopt.catalog.tables import built_in_rows
from uwopt.catalog.usercurves import read_channels
from uwopt.catalog.userparts import PartRow
from uwopt.errors import CatalogError

REFERENCE_CHANNEL = {"mono": "mono", "colour": "green"}  # the channel that makers state
BITS_PER_BYTE = 8
PIXELS_PER_MP = 1e6


def build_camera(row: PartRow, origin: Origin) -> Built:
    """The camera of a row, with what the model needs filled in."""
    colour: Literal["mono", "colour"] = "colour" if row.text("colour") == "colour" else "mono"
    chip, interface = row.text("chip"), row.text("interface")
    family = _family(chip)
    classes = (f"chip-{chip}" if chip else "", f"family-{family['pixel_family']}", "any")
    pixels = (row.number("resolution_x_px") or 0.0) * (row.number("resolution_y_px") or 0.0)
    bit_depth = row.number("bit_depth")
    bits = int(bit_depth if bit_depth is not None else required_class("camera-bit-depth", "any").central)
    bandwidth = known_or(row, "bandwidth_mb_s", origin, first_class("camera-bandwidth-mb-s", interface))
    curve_id, curves = _curves(row, family, colour)
    gain_bits = row.number("gain_bits")
    power = required_class("camera-power-w", interface, "any")
    mass = required_class("camera-mass-g", interface, "any")
    camera = Camera(
        **identity(row, origin, _price_class(chip, pixels), "USD", mass.quantity()),
        chip=chip,
        colour=colour,
        resolution_x_px=int(row.number("resolution_x_px") or 0),
        resolution_y_px=int(row.number("resolution_y_px") or 0),
        pixel_pitch_um=row.number("pixel_pitch_um") or 0.0,
        shutter="rolling" if row.text("shutter") == "rolling" else "global",
        mounts=row.items("mounts"),
        interface=interface,
        bandwidth_mb_s=bandwidth,
        max_frame_rate_hz=known(row, "max_frame_rate_hz", origin)
        or _rate_by_interface(bandwidth, pixels, bits),
        bit_depth=bits,
        bit_depth_status="estimated" if bit_depth is None else origin,
        read_noise_e=known_or(row, "read_noise_e", origin, first_class("camera-read-noise-e", *classes)),
        saturation_e=_saturation(row, origin, classes),
        dark_current_e_s=known_or(
            row, "dark_current_e_s", origin, first_class("camera-dark-current-e-s", "any")
        ),
        gain_dn_per_e=row.number("gain_dn_per_e"),
        gain_bits=None if gain_bits is None else int(gain_bits),
        max_gain_db=known_or(row, "max_gain_db", origin, first_class("camera-max-gain-db", "any")),
        black_level_dn=row.number("black_level_dn") or 0.0,
        min_exposure_us=known_or(
            row, "min_exposure_us", origin, first_class("camera-min-exposure-us", "any")
        ),
        max_exposure_us=known_or(
            row, "max_exposure_us", origin, first_class("camera-max-exposure-us", "any")
        ),
        exposure_offset_us=known(row, "exposure_offset_us", origin),
        prnu_frac=known(row, "prnu_frac", origin),
        power_w=known_or(row, "power_w", origin, power),
        qe_curves=curves,
        qe_curve_id=curve_id,
        qe_scale=_qe_scale(row, origin, curves[REFERENCE_CHANNEL[colour]], colour, classes),
    )
    return Built(camera, tuple(_lacking(row)))


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


def _saturation(row: PartRow, origin: Origin, classes: tuple[str, ...]) -> Quantity | None:
    """Stated, else from the best ratio of signal to shot noise (EMVA 1288), else by class."""
    stated = known(row, "saturation_e", origin)
    if stated is not None:
        return stated
    snr_max_db = row.number("snr_max_db")
    if snr_max_db is not None:
        return exact(
            10.0 ** (snr_max_db / 10.0), "derived", f"10^(snr_max_db / 10), snr_max_db = {snr_max_db:g}"
        )
    return known_or(row, "saturation_e", origin, first_class("camera-saturation-e", *classes))


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


@cache
def _built_in_curves() -> dict[str, dict[str, Curve]]:
    points: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for row in built_in_rows("qe_curves.csv"):
        channels = points.setdefault(row["curve_id"], {})
        channels.setdefault(row["channel"], []).append((float(row["wavelength_nm"]), float(row["qe"])))
    return {
        curve_id: {
            channel: Curve(tuple(x for x, _ in values), tuple(y for _, y in values))
            for channel, values in channels.items()
        }
        for curve_id, channels in points.items()
    }


def _curves(row: PartRow, family: dict[str, str], colour: str) -> tuple[str, dict[str, Curve]]:
    """Id and curves by channel: the row's own, a user's file, or those of the chip's family."""
    own = row.text("qe_curve")
    curve_id = own or family["colour_curve" if colour == "colour" else "mono_curve"]
    if own.casefold().endswith(".csv"):
        curves = read_channels((row.base_dir or Path()) / own, "qe")
    elif curve_id in _built_in_curves():
        curves = _built_in_curves()[curve_id]
    else:
        ids = ", ".join(_built_in_curves())
        raise CatalogError(f"{row.where}: qe_curve = {own!r} is no CSV and none of {ids}.")
    needed = ("red", "green", "blue") if colour == "colour" else ("mono",)
    missing = [channel for channel in needed if channel not in curves]
    if missing:
        raise CatalogError(f"{row.where}: qe_curve {curve_id!r} lacks the channel {', '.join(missing)}.")
    return curve_id, curves

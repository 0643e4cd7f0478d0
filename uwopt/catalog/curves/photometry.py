"""Reads a luminaire's intensity from the text of an IES file (LM-63), type C; opens no file itself.

A lamp's beam axis is the file's nadir (vertical angle 0). The horizontal planes are averaged: a beam here
is round. Every fault is collected with its line number and raised once.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from uwopt.arrays import FloatArray
from uwopt.errors import CatalogError

TYPE_C = 1
# First and last horizontal plane that the standard allows for type C, and the symmetry they stand for.
HORIZONTAL_SPANS = {(0.0, 0.0), (0.0, 90.0), (0.0, 180.0), (0.0, 360.0), (90.0, 270.0)}
HEADER_NAMES = (
    "number of lamps",
    "lumens per lamp",
    "candela multiplier",
    "number of vertical angles",
    "number of horizontal angles",
    "photometric type",
    "units type",
    "width",
    "length",
    "height",
    "ballast factor",
    "ballast-lamp factor",
    "input watts",
)
SCALE_NAMES = ("candela multiplier", "ballast factor", "ballast-lamp factor")


class Photometry(NamedTuple):
    """A round beam: angle from the axis [deg], mean intensity [cd], and the lamps' rated flux [lm]."""

    angle_deg: FloatArray
    candela: FloatArray
    lamp_lumens: float | None  # None: absolute photometry, no flux is rated (-1 in the file)


class _Number(NamedTuple):
    value: float
    line: int


def parse_ies(text: str) -> Photometry:
    """Angle, mean intensity over the horizontal planes, and rated flux of all lamps.

    Candela are those of the file times its multiplier and its two ballast factors. The unit flag (feet or
    metres) concerns the luminous opening only. CatalogError names line and remedy of every fault.
    """
    lines = text.lstrip("\ufeff").splitlines()
    numbers = _numbers(lines)
    header = _header(numbers)
    n_vertical, n_horizontal = (int(header[name].value) for name in HEADER_NAMES[3:5])
    data = numbers[len(HEADER_NAMES) :]
    n_expected = n_vertical + n_horizontal + n_vertical * n_horizontal
    if len(data) != n_expected:
        raise CatalogError(
            f"line {numbers[-1].line}: {len(data)} numbers follow the header, but {n_vertical} vertical "
            f"and {n_horizontal} horizontal angles ask for {n_expected}; "
            "the file is cut short, or its counts are wrong"
        )
    vertical, horizontal = data[:n_vertical], data[n_vertical : n_vertical + n_horizontal]
    table = data[n_vertical + n_horizontal :]
    faults = _angle_faults(vertical, "vertical") + _angle_faults(horizontal, "horizontal")
    faults += _span_faults(vertical, horizontal)
    faults += [f"line {n.line}: intensity {n.value:g} cd is negative" for n in table if n.value < 0]
    if faults:
        raise CatalogError(faults)
    scale = float(np.prod([header[name].value for name in SCALE_NAMES]))
    planes = np.array([n.value for n in table]).reshape(n_horizontal, n_vertical) * scale
    lumens = header["lumens per lamp"].value
    return Photometry(
        angle_deg=np.array([n.value for n in vertical]),
        candela=_plane_weights(np.array([n.value for n in horizontal])) @ planes,
        lamp_lumens=None if lumens < 0 else lumens * header["number of lamps"].value,
    )


def _numbers(lines: list[str]) -> list[_Number]:
    """All numbers after the TILT line, with their line numbers."""
    tilt = next((i for i, line in enumerate(lines) if line.strip().upper().startswith("TILT=")), None)
    if tilt is None:
        raise CatalogError("no line begins with TILT=; this is not an IES LM-63 file")
    if lines[tilt].strip().upper() != "TILT=NONE":
        raise CatalogError(
            f"line {tilt + 1}: {lines[tilt].strip()} is not supported; only TILT=NONE (a lamp that does not "
            "care how it hangs) is read"
        )
    numbers, faults = [], []
    for index, line in enumerate(lines[tilt + 1 :], start=tilt + 2):
        for word in line.replace(",", " ").split():
            try:
                value = float(word)
            except ValueError:
                value = float("nan")
            if np.isfinite(value):
                numbers.append(_Number(value, index))
            else:
                faults.append(f"line {index}: '{word}' is not a number")
    if faults:
        raise CatalogError(faults)
    if len(numbers) < len(HEADER_NAMES):
        raise CatalogError(
            f"line {len(lines)}: {len(numbers)} numbers after TILT=NONE; "
            f"the header alone has {len(HEADER_NAMES)}"
        )
    return numbers


def _header(numbers: list[_Number]) -> dict[str, _Number]:
    header = dict(zip(HEADER_NAMES, numbers, strict=False))
    faults: list[str] = []
    counts = [(name, header[name]) for name in (HEADER_NAMES[0], *HEADER_NAMES[3:5])]
    faults += [
        f"line {n.line}: {name} is {n.value:g}; it must be a whole number, 1 or more"
        for name, n in counts
        if n.value < 1 or n.value != int(n.value)
    ]
    if header["photometric type"].value != TYPE_C:
        found = header["photometric type"]
        faults.append(f"line {found.line}: photometric type {found.value:g}; only type C (1) is read")
    if header["units type"].value not in (1, 2):
        found = header["units type"]
        faults.append(f"line {found.line}: units type {found.value:g} must be 1 (feet) or 2 (metres)")
    faults += [
        f"line {header[name].line}: {name} is {header[name].value:g}; it must be above 0"
        for name in SCALE_NAMES
        if not header[name].value > 0
    ]
    if faults:
        raise CatalogError(faults)
    return header


def _angle_faults(angles: list[_Number], which: str) -> list[str]:
    return [
        f"line {after.line}: {which} angle {after.value:g} deg does not follow {before.value:g} deg; "
        "angles must increase"
        for before, after in itertools.pairwise(angles)
        if after.value <= before.value
    ]


def _span_faults(vertical: list[_Number], horizontal: list[_Number]) -> list[str]:
    faults = []
    first, last = vertical[0], vertical[-1]
    if first.value != 0:
        faults.append(
            f"line {first.line}: vertical angles begin at {first.value:g} deg; the beam's axis must be at 0, "
            "turn the luminaire"
        )
    if len(vertical) < 2 or last.value > 180:
        faults.append(f"line {last.line}: vertical angles must be two or more and end at 180 deg or before")
    if (horizontal[0].value, horizontal[-1].value) not in HORIZONTAL_SPANS:
        faults.append(
            f"line {horizontal[0].line}: horizontal angles {horizontal[0].value:g}-"
            f"{horizontal[-1].value:g} deg; "
            "allowed: 0 alone, 0-90, 0-180, 0-360, 90-270"
        )
    return faults


def _plane_weights(horizontal_deg: FloatArray) -> FloatArray:
    """Share of each plane in the mean over the circle: every allowed span is a symmetric part of it."""
    if horizontal_deg.size == 1:
        return np.ones(1)
    weights = np.zeros(horizontal_deg.size)
    half_step = np.diff(horizontal_deg) / 2
    weights[:-1] += half_step
    weights[1:] += half_step
    return np.asarray(weights / weights.sum())

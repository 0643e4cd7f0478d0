"""A test chart lying on a piece of sea floor, made by rule: the same for every system, at any scale.

Values are reflectances relative to the plain floor's mean, so that 1 is what the figures of a result are
about. The board measures 140 x 105 units; a unit is a length on the floor. On it: a Siemens star of 18
cycles, a square turned by 5 degrees, bars of both directions, six colours, grey steps, a window to the
floor, and a ruler of ten units a field. The floor's grain is noise from a fixed seed, sum of octaves of equal
contrast, fixed to the floor's millimetres.
"""

from __future__ import annotations

import numpy as np

from uwopt.arrays import Array

BOARD_WIDTH, BOARD_HEIGHT = 140.0, 105.0  # units
DARK, BRIGHT = 0.4, 1.6  # of star, square, bars and ruler: modulation 0.6
BAR_WIDTHS = (0.75, 1.0, 1.5, 2.0, 3.0, 5.0)  # units
GREY_STEPS = (0.1, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0)
COLOURS = (
    (1.6, 0.4, 0.4), (0.4, 1.6, 0.4), (0.4, 0.4, 1.6), (0.4, 1.3, 1.3), (1.3, 0.4, 1.3), (1.3, 1.3, 0.4),
)  # fmt: skip
STAR_CYCLES, STAR_RADIUS = 18, 24.0
SQUARE_TILT_RAD = float(np.deg2rad(5.0))
OCTAVE_CONTRAST = 0.05  # rms of each octave of the floor's grain
COARSEST_MM = 512.0
VALUE_NOISE_RMS = 26.0 / 35.0 / 3.0**0.5  # uniform -1..1 on the lattice, times the mean square of the steps
SEED = 20_200_913


def nice_unit_mm(length_mm: float) -> float:
    """The largest of 1, 1.5, 2, 3, 5, 7 times a power of ten that is no longer than a length."""
    power = int(np.floor(np.log10(length_mm) + 1e-9))
    steps = [float(f"{step}e{power}") for step in (1, 1.5, 2, 3, 5, 7)]
    return max(step for step in steps if step <= length_mm * (1 + 1e-9))


def scene_reflectance(x_mm: Array, y_mm: Array, *, unit_mm: float) -> Array:
    """Chart and floor at points of a grid.

    x_mm : (n,) to the right, y_mm : (m,) downward, origin in the board's middle, evenly spaced.
    Returns (m, n, 3), red, green and blue relative to the plain floor.
    """
    grain = floor_grain(x_mm, y_mm)
    out = np.repeat(grain[..., None], 3, axis=2)
    columns = np.abs(x_mm) <= 0.5 * BOARD_WIDTH * unit_mm
    rows = np.abs(y_mm) <= 0.5 * BOARD_HEIGHT * unit_mm
    if columns.any() and rows.any():
        place = np.ix_(rows, columns)
        out[place] = board(x_mm[columns] / unit_mm, y_mm[rows] / unit_mm, floor=grain[place])
    return out


def board(x: Array, y: Array, *, floor: Array) -> Array:
    """The board alone, at points in units from its middle; `floor` shows through its window."""
    out = np.ones((len(y), len(x), 3))

    def box(left: float, top: float, right: float, bottom: float) -> tuple[slice, slice]:
        columns = slice(*np.searchsorted(x, (left, right)))
        return slice(*np.searchsorted(y, (top, bottom))), columns

    def two_tone(at: tuple[slice, slice], bright: Array) -> None:
        out[at] = np.where(bright, BRIGHT, DARK)[..., None]

    for at in (box(-70, -52.5, -69, 52.5), box(69, -52.5, 70, 52.5), box(-70, -52.5, 70, -51.5)):
        out[at] = DARK
    at = box(-66, -48, -18, 0)
    u, v = x[at[1]][None, :] + 42.0, y[at[0]][:, None] + 24.0
    inside = np.hypot(u, v) <= STAR_RADIUS
    star = np.where(np.sin(STAR_CYCLES * np.arctan2(v, u)) >= 0.0, BRIGHT, DARK)
    out[at] = np.where(inside, star, 1.0)[..., None]
    at = box(-14, -48, 34, 0)
    u, v = x[at[1]][None, :] - 10.0, y[at[0]][:, None] + 24.0
    c, s = np.cos(SQUARE_TILT_RAD), np.sin(SQUARE_TILT_RAD)
    two_tone(at, np.maximum(np.abs(c * u + s * v), np.abs(c * v - s * u)) > 15.0)
    for index, colour in enumerate(COLOURS):
        left, top = 38.0 + 10.0 * (index % 3), -46.0 + 10.0 * (index // 3)
        out[box(left, top, left + 9.0, top + 9.0)] = colour
    for index, width in enumerate(BAR_WIDTHS):
        left = -66.0 + 13.0 * index
        at = box(left, 4.0, left + 12.0, 15.0)
        two_tone(at, np.broadcast_to(is_bright(x[at[1]] - left, width)[None, :], out[at].shape[:2]))
        at = box(left, 17.0, left + 12.0, 28.0)
        two_tone(at, np.broadcast_to(is_bright(y[at[0]] - 17.0, width)[:, None], out[at].shape[:2]))
    at = box(16.0, -20.0, 66.0, 28.0)
    lower = box(38.0, -22.0, 66.0, 28.0)
    out[lower] = floor[lower][..., None]
    at = box(16.0, 4.0, 38.0, 28.0)
    out[at] = floor[at][..., None]
    for index, grey in enumerate(GREY_STEPS):
        out[box(-66.0 + 19.0 * index, 31.0, -48.0 + 19.0 * index, 42.0)] = grey
    at = box(-70.0, 45.5, 70.0, 50.5)
    two_tone(at, np.broadcast_to(is_bright(x[at[1]] + 70.0, 10.0)[None, :], out[at].shape[:2]))
    return out


def is_bright(length: Array, width: float) -> Array:
    """Whether a point lies on a bright bar, bars of both kinds equally wide, the first one dark."""
    return np.asarray(np.floor(length / width) % 2 == 1)


# ---------------------------------------------------------------- floor


def floor_grain(x_mm: Array, y_mm: Array) -> Array:
    """Relative reflectance of the bare floor, (m, n): mean 1, octaves down to four samples."""
    sample_mm = float(abs(x_mm[1] - x_mm[0]))
    spacing, level = COARSEST_MM, 0
    downs, acrosses = [np.ones((len(y_mm), 1))], [np.ones((1, len(x_mm)))]
    while spacing >= 4.0 * sample_mm:
        down, across = noise_factors(x_mm / spacing, y_mm / spacing, level)
        downs.append(OCTAVE_CONTRAST / VALUE_NOISE_RMS * down)
        acrosses.append(across)
        spacing, level = 0.5 * spacing, level + 1
    total = np.hstack(downs) @ np.vstack(acrosses)  # all octaves in one product: a quarter of the time
    return np.asarray(np.maximum(total, 0.1))


def noise_factors(x: Array, y: Array, level: int) -> tuple[Array, Array]:
    """Two matrices whose product is the noise: shares of the lattice's rows (m, k), rows joined along x (k, n)."""
    columns, rows = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    lattice = hashed(
        np.arange(columns.min(), columns.max() + 2)[None, :], np.arange(rows.min(), rows.max() + 2)[:, None], level
    )  # fmt: skip
    fx, fy = smooth(x - columns), smooth(y - rows)
    across = lattice[:, columns - columns.min()] * (1.0 - fx) + lattice[:, columns - columns.min() + 1] * fx
    down = np.zeros((len(y), len(lattice)))
    each, at = np.arange(len(y)), rows - rows.min()
    down[each, at], down[each, at + 1] = 1.0 - fy, fy
    return down, across


def smooth(share: Array) -> Array:
    """3 s^2 - 2 s^3."""
    return np.asarray(share * share * (3.0 - 2.0 * share))


def hashed(column: Array, row: Array, level: int) -> Array:
    """A number between -1 and 1 for each lattice point, from its coordinates alone (a mixing of 64 bits)."""
    with np.errstate(over="ignore"):
        key = (column.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)) ^ (
            row.astype(np.uint64) * np.uint64(0xC2B2AE3D27D4EB4F)
        )
        key = key + np.uint64(SEED + 7919 * level)
        for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
            key = (key ^ (key >> np.uint64(shift))) * np.uint64(factor)
        key = key ^ (key >> np.uint64(31))
    return key.astype(np.float64) / 2.0**63 - 1.0

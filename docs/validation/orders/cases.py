"""The table of all-orders light: cases drawn once from wide ranges, and the file that keeps what was found.

Lengths in m, angles in degrees. The lamp stands `baseline` to starboard of the camera, in its plane, and is tilted
outward (negative: inward) so that the middle of its lobe falls into or near the image. Half of the cases, in turn, may
serve to fit a model (`fit`), the others judge it (`held out`).
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

TABLE = Path(__file__).parents[1] / "multiple_scattering.csv"
SEED = 18
N_THIN, N_THICK = 64, 20  # cases of c d up to 4, and of 4 to 8
PHASES = (
    "ff 0.0183", "ff 0.005", "hg 0.9", "ff 0.03", "petzold HAOCE 11", "ff 0.01", "petzold AUTEC 8", "hg 0.8",
    "ff 0.02", "petzold NUC 2200", "hg 0.95",
)  # fmt: skip
PLACES = {"mean": None, "centre": (0.0, 0.0), "near corner": (1.0, 1.0), "far corner": (1.0, -1.0)}
TALLIES = ("signal", "veil", "backscatter")
WITHIN = ("within_0.1_deg", "within_0.5_deg", "within_2_deg")
WALKS = {"mean": 200_000, "centre": 60_000, "near corner": 60_000, "far corner": 60_000}
THIN = 4.0  # c d up to which rows are judged
DOUBT = 0.03  # standard error over the value from which such a row is computed afresh,
MORE = (64,)  # by so many times as many walks

HEAD = """\
# Lamp light of all orders of scattering in homogeneous water over a Lambertian floor; one lamp, a pinhole in water.
# Radiance times cos^4 per lumen [1/(m^2 sr)]: mean over the image (square, even in tangents), centre, corners.
# signal: not scattered after the floor; veil: scattered after the floor; backscatter: never touched the floor.
# _error: one standard error of 32 batches; _largest: largest batch over the mean; within: share of the veil by angle.
# walks: how many; where the usual leave one in doubt by over {doubt:g}, up to c d = {thin:g}, {more} times as many.
# Computed by docs/make_multiple_scattering.py, seed {seed}; cases drawn by docs/validation/orders/cases.py.
"""


class OverFloor:
    """What follows for any case from its water, its altitude and its field."""

    c_per_m: float
    altitude_m: float
    field_deg: float

    @property
    def thickness(self) -> float:
        """c d."""
        return self.c_per_m * self.altitude_m

    @property
    def tangent(self) -> float:
        """Half width of the image."""
        return float(np.tan(np.deg2rad(self.field_deg / 2)))


@dataclass(frozen=True)
class Case(OverFloor):
    """One lamp over one floor in one water."""

    number: int
    use: str  # `fit` or `held out`
    phase: str
    c_per_m: float  # pyrefly: ignore[bad-override]
    albedo: float
    altitude_m: float  # pyrefly: ignore[bad-override]
    baseline_m: float
    tilt_deg: float
    lobe_half_deg: float  # at half power
    field_deg: float  # full angle across a side of the image  # pyrefly: ignore[bad-override]
    reflectance: float

    @property
    def exponent(self) -> float:
        """Of the lobe cos^m."""
        return float(np.log(0.5) / np.log(np.cos(np.deg2rad(self.lobe_half_deg))))


@dataclass(frozen=True)
class Light:
    """One row: what arrives at one place of the image."""

    case: Case
    place: str
    walks: int
    value: dict[str, float]  # by tally
    error: dict[str, float]
    largest: dict[str, float]
    within: dict[str, float]  # share of the veil that arrives so near


def drawn_cases() -> list[Case]:
    """The cases: c d even in its logarithm, all else drawn evenly within its range."""
    rng = np.random.default_rng(SEED)
    edges = np.r_[np.geomspace(0.2, 4.0, N_THIN + 1)[:-1], np.geomspace(4.0, 8.0, N_THICK + 1)]
    found = []
    for n, (low, high) in enumerate(pairwise(edges)):
        thickness = low * (high / low) ** rng.random()
        altitude = 0.5 * 12.0 ** rng.random()
        half = np.deg2rad(30 + 60 * rng.random()) / 2
        least, most = 0.1, min(3.0, 1.2 * altitude)
        baseline = least * (most / least) ** rng.random()
        lobe = 10 + 60 * rng.random()
        aimed = altitude * np.tan(half) * (-0.3 + 1.1 * rng.random())  # where the lobe's middle meets the floor
        tilt = np.rad2deg(np.arctan((aimed - baseline) / altitude))
        albedo = 0.3 + 0.65 * rng.random()
        floor = 0.02 + 0.48 * rng.random()
        values = (thickness / altitude, albedo, altitude, baseline, tilt, lobe, np.rad2deg(2 * half), floor)
        use = ("fit", "held out")[n % 2]
        found.append(Case(n, use, PHASES[n % len(PHASES)], *(float(f"{value:.4g}") for value in values)))
    return found


def setting(case: Case) -> tuple[Any, Any, Any]:
    """A case as the walks take it: water, lamp, view."""
    from . import camera, lamps, walk

    tilt = np.deg2rad(case.tilt_deg)
    lamp = lamps.Lamp(0.0, case.baseline_m, 0.0, float(np.sin(tilt)), float(np.cos(tilt)), case.exponent)
    view = camera.View(case.tangent, case.tangent, case.altitude_m, case.reflectance)
    return walk.water_of(case.c_per_m, case.albedo, walk.phase_of(case.phase)), lamp, view


def computed(case: Case, place: str, walks: int | None = None) -> Light:
    """One row computed afresh; by more walks, none of them among the first, where these leave it in doubt."""
    row = walked(case, place, walks or WALKS[place])
    for again, times in enumerate(MORE if walks is None else (), start=1):
        if in_doubt(row):
            row = walked(case, place, times * WALKS[place], again)
    return row


def in_doubt(row: Light) -> bool:
    """Whether a row that is judged is known too poorly for that."""
    return row.case.thickness <= THIN and any(row.error[tally] > DOUBT * row.value[tally] for tally in TALLIES)


def walked(case: Case, place: str, walks: int, *again: int) -> Light:
    """One row by so many walks; `again` draws others."""
    from . import camera

    seed = (SEED, case.number, list(PLACES).index(place), *again)
    seen = camera.seen(*setting(case), walks, seed, place=PLACES[place])
    value, error, largest = (dict(zip(TALLIES, map(float, part[:3]), strict=True)) for part in seen)
    shares = [float(near / seen.mean[1]) for near in seen.mean[3:]]
    return Light(case, place, walks, value, error, largest, dict(zip(WITHIN, shares, strict=True)))


def columns() -> list[str]:
    """Of the file."""
    by_tally = [f"{name}{kind}" for name in TALLIES for kind in ("", "_error", "_largest")]
    return [field.name for field in fields(Case)] + ["place", "walks", *by_tally, *WITHIN]


def as_row(light: Light) -> list[str]:
    """A line of the file."""
    numbers = [part[name] for name in TALLIES for part in (light.value, light.error, light.largest)]
    numbers += light.within.values()
    known = [*map(str, asdict(light.case).values()), light.place, str(light.walks)]
    return known + [f"{number:.5g}" for number in numbers]


def write(rows: Iterator[Light], path: Path = TABLE) -> None:
    """Writes the table row by row."""
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(HEAD.format(seed=SEED, thin=THIN, doubt=DOUBT, more=" or ".join(map(str, MORE))))
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns())
        for light in rows:
            writer.writerow(as_row(light))
            file.flush()


def values_of(record: type[Any], row: dict[str, str]) -> dict[str, Any]:
    """What a line of a table holds of a record: its numbers and words, by field."""
    kinds = {"int": int, "str": str, "float": float}
    of_field = {field.name: kinds.get(str(field.type)) for field in fields(record)}
    return {name: kind(row[name]) for name, kind in of_field.items() if kind is not None}


def read(path: Path = TABLE) -> list[Light]:
    """The table as it was written."""
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    found = []
    for row in rows:
        value, error, largest = (
            {name: float(row[name + kind]) for name in TALLIES} for kind in ("", "_error", "_largest")
        )
        within = {name: float(row[name]) for name in WITHIN}
        case, walks = Case(**values_of(Case, row)), int(row["walks"])
        found.append(Light(case, row["place"], walks, value, error, largest, within))
    return found

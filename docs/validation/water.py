# ruff: noqa: E501 - a line of the page's text is as long as the expressions in it
"""Section 7: attenuation against the source tables."""

from __future__ import annotations

import csv
import importlib.resources
from typing import Any

import numpy as np

from . import common

TYPES = ("I", "IA", "IB", "II", "III", "1C", "3C", "5C", "7C", "9C")
MEASURED = ("IB", "II", "III", "1C", "3C", "5C")


def library(file: str) -> list[dict[str, str]]:
    """Rows of a table of the library jerlov, read as text."""
    text = (importlib.resources.files("jerlov") / "data" / file).read_text(encoding="utf-8")
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))


def scene(water: str, table: str) -> Any:
    """uwopt's scene: spectra on its grid."""
    from uwopt.api.common import prepared
    from uwopt.forward.scene import scene_optics

    mission = prepared(
        {
            "name": "water", "physics": "full",
            "scene": {"water": water, "water_table": table, "seafloor": 0.2, "depth_m": 50},
            "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.0}, "requirements": {"frame_interval_s": 1.0},
        }, None, None,
    )  # fmt: skip
    return scene_optics(mission.views[0], paper=False)


def column_of(water: str, quantity: str) -> dict[float, float]:
    """One quantity of one type [1/m] by wavelength, where the library holds it."""
    return {
        float(r["wavelength_nm"]): float(r["value_per_m"])
        for r in library("solonenko2015_iop.csv")
        if r["water_type"] == water and r["quantity"] == quantity and r["value_per_m"]
    }


def modelled_rows() -> tuple[list[list[str]], float]:
    """c and K_d of uwopt's scenes at the table's wavelengths against the library's transcription."""
    rows, worst = [], 0.0
    for water in TYPES:
        made = scene(water, "solonenko-mobley")
        grid = made.wavelength_nm
        a, b, kd = (column_of(water, name) for name in ("a", "b", "Kd0"))
        c = {nm: a[nm] + b[nm] for nm in a if nm in b and grid[0] <= nm <= grid[-1]}
        held = {nm: min(kd[nm], c[nm]) for nm in kd if nm in c}
        cells = [water, f"{len(c)}, {len(held)}"]
        for told, theirs in ((made.attenuation_per_m, c), (made.diffuse_attenuation_per_m, held)):
            off = {nm: float(np.interp(nm, grid, told)) / value - 1 for nm, value in theirs.items()}
            nm = max(off, key=lambda key: abs(off[key]))
            worst = max(worst, abs(off[nm]))
            cells.append(f"{common.percent(off[nm], 2)} at {nm:.0f} nm" if abs(off[nm]) > 1e-9 else "none")
        rows.append(cells)
    return rows, worst


def measured_rows() -> tuple[list[list[str]], float]:
    """c of the measured table, 412 to 715 nm, and how far the other table is from it."""
    rows, worst = [], 0.0
    for water in MEASURED:
        made, other = scene(water, "measured"), scene(water, "solonenko-mobley")
        inside = (made.wavelength_nm >= 412) & (made.wavelength_nm <= 700)
        theirs = np.interp(made.wavelength_nm, *measured_table(water))
        off = float(np.abs(made.attenuation_per_m / theirs - 1)[inside].max())
        at = int(np.searchsorted(made.wavelength_nm, 525))
        others = np.interp(made.wavelength_nm, other.wavelength_nm, other.attenuation_per_m)
        ratio = others / made.attenuation_per_m
        worst = max(worst, off)
        rows.append([
            water, common.small(off), f"{made.attenuation_per_m[at]:.3f}", f"{others[at]:.3f}",
            f"{ratio[inside].min():.2f} to {ratio[inside].max():.2f}",
        ])  # fmt: skip
    return rows, worst


def measured_table(water: str) -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths and a + b of Williamson and Hollins, from the project's own copy of the data set."""
    path = common.ROOT / "tests" / "reference" / "jerlov_iop_measured.csv"
    with path.open(encoding="utf-8", newline="") as lines:
        found = [
            r for r in csv.DictReader(x for x in lines if not x.startswith("#")) if r["water_type"] == water
        ]
    nm = np.array([float(r["wavelength_nm"]) for r in found])
    return nm, np.array([float(r["a_per_m"]) + float(r["b_per_m"]) for r in found])


def clip_text() -> str:
    """Where K had to be held within a + b_b and c."""
    shares = []
    for water in TYPES:
        a, b, kd = common.jerlov(water)
        visible = (common.WAVES_NM >= 400) & (common.WAVES_NM <= 700)
        low, high = (kd < a + 0.0183 * b)[visible].mean(), (kd > a + b)[visible].mean()
        shares.append(f"{water} {100 * low:.0f}/{100 * high:.0f}")
    return ", ".join(shares)


def section() -> str:
    """The text."""
    modelled, worst = modelled_rows()
    measured, measured_worst = measured_rows()
    return f"""\
**In short:** c and K_d within {100 * worst:.2f} % of the library's transcription, the measured table within {common.small(measured_worst)}; the two tables differ by factors.

Independent of: the tables in `uwopt/catalog/data` and what becomes of them on uwopt's grid. The library jerlov has its own
transcription of Solonenko and Mobley (2015); the measured set is held against the copy of the published data set in
`tests/reference`. (uwopt takes the measured set from that library itself, so only the way from there is tested.)

Largest difference of c = a + b and K_d at the table's wavelengths, 380 nm and up (K_d at most c, as uwopt has it):

{common.table(["type", "points of c, K_d", "c", "K_d"], modelled)}

Largest: {100 * worst:.2f} %. The rows that the paper misprints (3C from 675 nm, 5C from 600 nm) are empty in the library and
so not compared; how they were filled is told in `jerlov_iop.csv`.

Measured table, 412–700 nm, and what the choice of table means:

{common.table(["type", "largest diff. of c", "c(525 nm) measured", "c(525 nm) modelled", "modelled / measured"], measured)}

Largest difference from the data set: {common.small(measured_worst)}. What falls short: the two tables disagree by up to the factors in
the last column, far more than any error on this page, and K_d is a table of its own that does not fit either: in per cent
of 400–700 nm it had to be lifted to a + b_b / held down to c: {clip_text()}.
"""

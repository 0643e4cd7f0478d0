"""What the sections share: plain tables, spectra read without uwopt's help, systems to evaluate, figures."""

from __future__ import annotations

import csv
import textwrap
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "uwopt" / "catalog" / "data"
FIGURES = ROOT / "docs" / "figures"

PLANCK_J_S, LIGHT_M_S, LUMENS_PER_W = 6.62607015e-34, 299_792_458.0, 683.002
WAVES_NM = np.arange(380.0, 780.5, 1.0)
STEPS_NM = np.r_[0.5, np.ones(WAVES_NM.size - 2), 0.5]
LED = ((24.49, 450.70, 11.67), (119.86, 565.43, 64.63))  # weight, mean, sigma [nm]: the tool's white LED


# ---------------------------------------------------------------- text


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def filled(text: str) -> str:
    """Paragraphs of a text with lines of even length; tables, pictures and headings as they are."""
    blocks = text.strip().split("\n\n")
    return "\n\n".join(
        block if block.startswith(("|", "!", "#"))
        else textwrap.fill(" ".join(block.split()), 118, break_long_words=False, break_on_hyphens=False)
        for block in blocks
    )  # fmt: skip


def farthest(values: Iterable[float]) -> float:
    """The value that lies farthest from 0."""
    return max(values, key=abs)


def percent(share: float, digits: int = 1) -> str:
    """A signed share in per cent."""
    shown = f"{100 * share:+.{digits}f}"
    return f"{shown.replace('-0.' + '0' * digits, '0.' + '0' * digits)} %" if digits else f"{shown} %"


def small(value: float) -> str:
    """The size of an error: two digits, in powers of ten when small; rounding alone is not told apart."""
    if abs(value) < 1e-9:
        return "rounding"
    return f"{value:.1e}" if abs(value) < 1e-3 else f"{value:.2g}"


# ---------------------------------------------------------------- tables that ship, read plainly


@cache
def rows_of(file: str) -> tuple[dict[str, str], ...]:
    """Rows of a table in uwopt/catalog/data."""
    with (DATA / file).open(encoding="utf-8", newline="") as lines:
        return tuple(csv.DictReader(line for line in lines if not line.startswith("#")))


def column(file: str, x: str, y: str, **where: str) -> tuple[Array, Array]:
    """Two columns of the rows that match, sorted by the first."""
    pairs = sorted(
        (float(r[x]), float(r[y])) for r in rows_of(file) if all(r[k] == v for k, v in where.items())
    )
    return np.array([a for a, _ in pairs]), np.array([b for _, b in pairs])


def photopic() -> Array:
    """V on WAVES_NM."""
    return np.interp(WAVES_NM, *column("photopic_v.csv", "wavelength_nm", "V"), left=0.0, right=0.0)


def led() -> Array:
    """Spectral flux of one lumen of the white LED [W/nm]."""
    shape = sum(w / s * np.exp(-0.5 * ((WAVES_NM - m) / s) ** 2) for w, m, s in LED)
    return np.asarray(shape / (LUMENS_PER_W * (photopic() * shape * STEPS_NM).sum()))


def efficiency(curve: str) -> Array:
    """Quantum efficiency of a mono sensor."""
    xy = column("qe_curves.csv", "wavelength_nm", "qe", curve_id=curve, channel="mono")
    return np.interp(WAVES_NM, *xy)


def pure_water(name: str) -> Array:
    """A column of the table of pure water."""
    return np.interp(WAVES_NM, *column("pure_water.csv", "wavelength_nm", name))


def jerlov(water: str, *, continued: bool = True) -> tuple[Array, Array, Array]:
    """a, b, K_d of Solonenko and Mobley's table [1/m]; a beyond 700 nm rises with pure water's, or is held."""
    nm, a_table = column("jerlov_iop.csv", "wavelength_nm", "a_per_m", water_type=water)
    a = np.interp(WAVES_NM, nm, a_table)
    if continued:
        a_w = pure_water("a_per_m")
        a = a + np.where(WAVES_NM > 700, a_w - np.interp(700.0, WAVES_NM, a_w), 0.0)
    b, kd = (
        np.interp(WAVES_NM, *column("jerlov_iop.csv", "wavelength_nm", name, water_type=water))
        for name in ("b_per_m", "kd_per_m")
    )
    return a, b, kd


def index_of_water(temperature_c: float, salinity_psu: float) -> Array:
    """Quan and Fry (1995), their formula with their coefficients."""
    T, S, nm = temperature_c, salinity_psu, WAVES_NM
    return np.asarray(
        1.31405 + (1.779e-4 - 1.05e-6 * T + 1.6e-8 * T * T) * S - 2.02e-6 * T * T
        + (15.868 + 0.01155 * S - 0.00423 * T) / nm - 4382.0 / nm**2 + 1.1455e6 / nm**3
    )  # fmt: skip


# ---------------------------------------------------------------- what uwopt says


def figures(mission: dict[str, Any], system: dict[str, Any]) -> dict[str, Any]:
    """Figures of the first scene from `uwopt.evaluate`."""
    import uwopt

    design = uwopt.evaluate(mission, system).design
    assert design is not None
    return dict(design.scenes[0].figures)


def levels(
    mission: dict[str, Any], system: dict[str, Any], exposures_s: Sequence[float], without: Iterable[str] = ()
) -> list[float]:
    """Mean level of the image at some exposures, from the model behind `evaluate`; some effects left out.

    The same as `figures(...)["mean_level"]`, without the figures that take longer.
    """
    from dataclasses import replace

    from uwopt.api.common import prepared
    from uwopt.api.evaluating import scene_settings
    from uwopt.evaluation.design_model import DesignModel
    from uwopt.forward.assembly import system_problem
    from uwopt.mission.system import load_system

    wanted, built = prepared(mission, None, None), load_system(system)
    problem, hardware = system_problem(wanted, built)
    model = DesignModel(problem.with_effects(problem.effects.without(without)), hardware)
    scene = problem.scenes[0]
    given = scene_settings(problem, hardware, built, scene.name)
    found = []
    for exposure_s in exposures_s:
        settings = model.settings(0, replace(given, exposure_s=exposure_s))
        found.append(float(model.figures(0, settings).mean_level[0, scene.nominal]))
    return found


# ---------------------------------------------------------------- figures


def canvas(n_columns: int = 1, *, height: float = 3.4, width: float | None = None) -> tuple[Any, Any]:
    """A figure and its axes; drawn without a display."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    mpl.rcParams.update(
        {
            "svg.hashsalt": "uwopt",
            "svg.fonttype": "none",
            "font.size": 9,
            "axes.grid": True,
            "grid.alpha": 0.3,
        }
    )
    return plt.subplots(1, n_columns, figsize=(width or 4.6 * n_columns, height), layout="constrained")


def save(figure: Any, name: str, caption: str) -> str:
    """Writes docs/figures/NAME.svg, the same bytes for the same curves; returns the link to it."""
    import matplotlib.pyplot as plt

    FIGURES.mkdir(exist_ok=True)
    figure.savefig(FIGURES / f"{name}.svg", metadata={"Date": None}, dpi=110)
    plt.close(figure)
    return f"![{caption}](figures/{name}.svg)"

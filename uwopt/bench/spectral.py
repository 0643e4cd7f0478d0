"""Work and precision of the integral over wavelength: rules and numbers of nodes against arbitrary precision."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.bench import spectral_exact
from uwopt.bench.spectral_exact import FIRST_NM, LAST_NM, QUICK_DEGREE, Entries, Tables
from uwopt.bench.suite import BenchRow, BenchTable, Budget, Suite, error_text, least_size, timed
from uwopt.forward.scene import GRID_STEP_NM

NAME = "spectral"
TRAPEZOID, SIMPSON, GAUSS, AS_USED = "trapezoid", "Simpson", "Gauss-Legendre", "as used"
RULES = (TRAPEZOID, SIMPSON, GAUSS)
NODES = (9, 17, 41, 81, 161, 401, 801, 1601)
QUICK_NODES = NODES[1:-1]
N_DESIGNS = 1000  # contracted together, fewer where they
MOST_EXPONENTIALS = 200_000  # would take more at once than a cache holds; the time is that of one
TARGET = 1e-4  # what the project asks of every reported figure


@dataclass(frozen=True)
class Setting:
    """Everything but the paths: names of the catalogue's tables, or a user's own."""

    name: str
    water: str
    water_table: str
    seafloor: float | str
    lamp: str | Entries
    efficiency: str | Entries


@dataclass(frozen=True)
class Case:
    """One integral."""

    setting: Setting
    lamp_m: float
    camera_m: float

    @property
    def name(self) -> str:
        """For tables and charts."""
        return f"{self.setting.name}, {self.camera_m:g} m"


def lines_nm(*centres_nm: float, half_width_nm: float = 0.1) -> Entries:
    """Triangular lines of equal power in the dark."""
    x = [x for centre in centres_nm for x in (centre - half_width_nm, centre, centre + half_width_nm)]
    return tuple(x), (0.0, 1.0, 0.0) * len(centres_nm)


MONO, COLOUR = "seed-imx250m", "seed-imx250c"
LED_CLEAR = Setting("generic LED, water IB", "IB", "measured", 0.2, "generic-led", MONO)
LED_TURBID = Setting("generic LED, water 3C", "3C", "measured", "macroalgae_green", "generic-led", MONO)
PLANCK = Setting(
    "black body 2856 K, water II, colour", "II", "measured", "sand_coralreef_asu", "planck-2856", COLOUR
)
TUBE = Setting(
    "fluorescent tube FL11, water II", "II", "solonenko-mobley", "coral_mean_asu", "CIE FL11", MONO
)
LED_COLOUR = Setting(
    "LED of three colours, water 1C", "1C", "measured", "benthic-average", "CIE LED-RGB1", COLOUR
)
LASERS = Setting(
    "three laser lines, water II", "II", "measured", "sand_wasi", lines_nm(450.3, 532.14, 638.77), MONO
)
BAND_PASS: Entries = ((499.95, 500.45, 600.15, 600.65), (0.0, 0.6, 0.6, 0.0))
FILTER = Setting("generic LED, steep filter, water II", "II", "measured", 0.2, "generic-led", BAND_PASS)
STEP: Entries = ((500.37, 500.39, 600.31, 600.33), (0.0, 0.6, 0.6, 0.0))
SHUT = Setting("generic LED, filter with steps, water II", "II", "measured", 0.2, "generic-led", STEP)
QUICK_CASES = (
    Case(LED_CLEAR, 1.1, 1.0), Case(TUBE, 20.4, 20.0), Case(LASERS, 5.2, 5.0),
)  # fmt: skip
FULL_CASES = tuple(
    Case(setting, lamp_m, camera_m)
    for lamp_m, camera_m in (
        (5.2, 5.0),
        (1.1, 1.0),
        (20.4, 20.0),
    )  # should time run out, each setting has a path
    for setting in (LED_CLEAR, LED_TURBID, PLANCK, TUBE, LED_COLOUR, LASERS, FILTER, SHUT)
)


# ---------------------------------------------------------------- the integrand


@lru_cache(maxsize=64)
def scene_of(setting: Setting, altitude_m: float = 1.0) -> Any:
    """The product's scene on its own grid, physics full."""
    from uwopt.api.common import prepared
    from uwopt.forward.scene import scene_optics

    mission = prepared(
        {
            "name": NAME, "physics": "full",
            "scene": {
                "water": setting.water, "water_table": setting.water_table, "seafloor": setting.seafloor,
                "depth_m": 50,
            },
            "vehicle": {"altitude_m": altitude_m, "speed_m_s": 0.0},
            "requirements": {"frame_interval_s": 1.0},
        }, None, None,
    )  # fmt: skip
    return scene_optics(mission.views[0], paper=False)


@cache
def tables_of(setting: Setting) -> Tables:
    """The tables behind a setting, as they are published."""
    from uwopt.catalog.curves import spectra

    profile = spectra.water_profile(setting.water, table=setting.water_table)  # pyrefly: ignore[bad-argument-type]
    if profile.a_per_m is None or profile.b_per_m is None or profile.kd_per_m is None:
        raise ValueError(f"water {setting.water}: a, b and K_d are needed")
    floor, photopic, pure = (
        spectra.seafloor_reflectance(setting.seafloor),
        spectra.photopic(),
        spectra.pure_water(),
    )
    scene = scene_of(setting).view.scene
    return Tables(
        lamp=lamp_of(setting.lamp),
        photopic=entries(photopic.wavelength_nm, photopic.value),
        reflectance=entries(floor.wavelength_nm, floor.value),
        efficiency=efficiency_of(setting.efficiency),
        absorption=entries(profile.wavelength_nm, profile.a_per_m),
        scattering=entries(profile.wavelength_nm, profile.b_per_m),
        diffuse=entries(profile.kd_wavelength_nm, profile.kd_per_m),
        pure_water=entries(pure.wavelength_nm, pure.a_per_m),
        backscatter_ratio=scene.backscatter_ratio,
        index=tuple(spectra.quan_fry_coefficients().tolist()),
        temperature_c=scene.temperature_c,
        salinity_psu=scene.salinity_psu,
    )


def entries(x: Any, y: Any) -> Entries:
    """Two columns."""
    return tuple(np.asarray(x, float).tolist()), tuple(np.asarray(y, float).tolist())


def lamp_of(lamp: str | Entries) -> Entries | float | None:
    """A lamp as `Tables` holds it: a formula where the model has one."""
    from uwopt.catalog.curves import spectra

    if not isinstance(lamp, str):
        return lamp
    if lamp == "generic-led":
        return None
    if lamp.startswith("planck-"):
        return float(lamp.removeprefix("planck-"))
    known = spectra.light_spectrum(lamp)
    return entries(known.wavelength_nm, known.value)


@cache
def efficiency_of(efficiency: str | Entries) -> tuple[tuple[float, Entries], ...]:
    """Channels of a curve of the catalogue and their shares of a pixel; a user's table is one channel."""
    from uwopt.catalog.tables import built_in_rows

    if not isinstance(efficiency, str):
        return ((1.0, efficiency),)
    points: dict[str, list[tuple[float, float]]] = {}
    for row in built_in_rows("qe_curves.csv"):
        if row["curve_id"] == efficiency:
            points.setdefault(row["channel"], []).append((float(row["wavelength_nm"]), float(row["qe"])))
    shares = {"mono": 1.0} if "mono" in points else {"red": 0.25, "green": 0.5, "blue": 0.25}
    return tuple((share, entries(*zip(*points[name], strict=True))) for name, share in shares.items())


@dataclass(frozen=True)
class Sampled:
    """The integrand at nodes: the weight holds the rule and the lamp's lumens, the water is apart."""

    weight: Array
    lamp_attenuation_per_m: Array
    attenuation_per_m: Array

    def electrons(self, lamp_m: Array, camera_m: Array) -> Array:
        """Electrons per lm s/m^2 and m^2 of pixel, for many designs at once."""
        loss = np.multiply.outer(lamp_m, self.lamp_attenuation_per_m)
        loss += np.multiply.outer(camera_m, self.attenuation_per_m)
        return np.asarray(np.exp(-loss) @ self.weight)


def sampled(tables: Tables, wavelength_nm: Array, rule_nm: Array) -> Sampled:
    """The model's own functions at any nodes, with the weights of a rule [nm]."""
    from uwopt.model import lens, seafloor, sensor, water
    from uwopt.model.spectrum import MAX_LUMINOUS_EFFICACY_LM_W, resample

    def held(columns: Entries) -> Array:
        return resample(wavelength_nm, table_nm=columns[0], table_values=columns[1], outside="hold")

    lamp = lamp_power(tables.lamp, wavelength_nm)
    photopic = resample(
        wavelength_nm, table_nm=tables.photopic[0], table_values=tables.photopic[1], outside="zero"
    )
    lumens = MAX_LUMINOUS_EFFICACY_LM_W * (lamp * photopic) @ rule_nm
    flux_w_nm = lamp / lumens if lumens > 0.0 else np.full_like(lamp, np.nan)  # all nodes between the lines
    radiance = seafloor.lambertian_radiance(flux_w_nm, reflectance=held(tables.reflectance))
    index = water.refractive_index_quan_fry(
        wavelength_nm, temperature_c=tables.temperature_c, salinity_psu=tables.salinity_psu, coefficients=tables.index
    )  # fmt: skip
    irradiance = lens.image_irradiance(radiance / np.square(index), transmission=1.0, working_f_number=1.0)
    density = sensor.electron_rate_per_m2_s_nm(
        irradiance,
        wavelength_nm=wavelength_nm,
        quantum_efficiency=sum(share * held(curve) for share, curve in tables.efficiency),
    )
    a = water.extend_absorption_per_m(
        wavelength_nm,
        table_nm=tables.absorption[0],
        table_a_per_m=tables.absorption[1],
        pure_water_nm=tables.pure_water[0],
        pure_water_a_per_m=tables.pure_water[1],
    )
    b = held(tables.scattering)
    k = water.illumination_attenuation_per_m(
        a, b_per_m=b, kd_per_m=held(tables.diffuse), backscatter_ratio=tables.backscatter_ratio
    )
    return Sampled(np.asarray(density * rule_nm), k, water.beam_attenuation_per_m(a, b))


def lamp_power(lamp: Entries | float | None, wavelength_nm: Array) -> Array:
    """A lamp's relative power per nm at any wavelengths."""
    from uwopt.model.spectrum import planck_spectrum, resample, two_gaussian_led

    if lamp is None:
        return two_gaussian_led(wavelength_nm)
    if isinstance(lamp, tuple):
        return resample(wavelength_nm, table_nm=lamp[0], table_values=lamp[1], outside="zero")
    return planck_spectrum(wavelength_nm, temperature_k=lamp)


# ---------------------------------------------------------------- rules


def rule(name: str, n: int) -> tuple[Array, Array]:
    """Nodes and weights [nm] over the whole spectrum."""
    span = float(LAST_NM - FIRST_NM)
    if name == GAUSS:
        nodes, weights = legendre(n)
        return FIRST_NM + 0.5 * span * (nodes + 1.0), 0.5 * span * weights
    wavelength_nm = np.linspace(FIRST_NM, LAST_NM, n)
    step_nm = span / (n - 1)
    weights = np.ones(n)
    if name == SIMPSON:
        weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
        return wavelength_nm, weights * (step_nm / 3.0)
    weights[[0, -1]] = 0.5
    return wavelength_nm, weights * step_nm


@cache
def legendre(n: int) -> tuple[Array, Array]:
    """Gauss-Legendre on [-1, 1]."""
    return np.polynomial.legendre.leggauss(n)


def by_rule(case: Case, name: str, n: int) -> Callable[[Array, Array], Array]:
    """Electrons of designs by one rule; everything but the paths is done beforehand."""
    return sampled(tables_of(case.setting), *rule(name, n)).electrons


def as_used(case: Case) -> tuple[Callable[[Array, Array], Array], int]:
    """Electrons of designs as a search computes them, and the nodes of the grid: `Contraction` and its table."""
    from uwopt.catalog.records import Curve
    from uwopt.forward.lamps import LightOptics
    from uwopt.forward.spectra import Contraction
    from uwopt.model.beam import disc_beam
    from uwopt.model.path_table import log_mean_transmission

    setting = case.setting
    scene = scene_of(setting, 0.9 * case.camera_m)
    own = None if isinstance(setting.lamp, str) else Curve(*setting.lamp)
    named = setting.lamp if isinstance(setting.lamp, str) else "own"
    channels = efficiency_of(setting.efficiency)
    names = ("mono",) if len(channels) == 1 else ("red", "green", "blue")
    curves = {name: Curve(*curve) for name, (_, curve) in zip(names, channels, strict=True)}
    contraction = Contraction(scene, [LightOptics((disc_beam(0.7),), named, own)], [curves])
    contraction = contraction.reaching(1.3 * case.lamp_m, 1.3 * case.camera_m)
    table, response = contraction.table(0, 0, nearest_m=float(scene.range_m[0])), contraction.response(0, 0)
    return (
        lambda lamp_m, camera_m: response * np.exp(log_mean_transmission(table, lamp_m, camera_m)),
        len(scene.wavelength_nm),
    )


# ---------------------------------------------------------------- the suite


@lru_cache(maxsize=16)
def integrand(setting: Setting, degree: int) -> spectral_exact.Integrand:
    """The reference of a setting; its weights are shared by all paths."""
    return spectral_exact.Integrand(tables_of(setting), degree)


def reference_electrons(case: Case, degree: int = spectral_exact.DEGREE) -> Any:
    """Electrons per lm s/m^2 and m^2 of pixel, by arbitrary precision."""
    return integrand(case.setting, degree).electrons(case.lamp_m, case.camera_m)


def measured_row(
    case: Case, method: str, electrons: Callable[[Array, Array], Array], n: int, exact: Any, *, quick: bool
) -> BenchRow:
    """Error at the case's paths, and time of one of many designs about them."""
    n_designs = N_DESIGNS if method == AS_USED else min(N_DESIGNS, MOST_EXPONENTIALS // n)
    spread = np.linspace(0.92, 1.25, n_designs)
    _, took_s = timed(
        lambda: electrons(case.lamp_m * spread, case.camera_m * spread),
        at_least_s=0.004 if quick else 0.005,
        repeats=2,
    )
    value = electrons(np.array([case.lamp_m]), np.array([case.camera_m]))[0]
    known = bool(np.isfinite(value))
    return BenchRow(
        NAME, case.name, method, float(n), time_s=took_s / n_designs,
        error=float(abs(value / exact - 1)) if known else None, status="" if known else "no node sees the lamp",
    )  # fmt: skip


def measure(budget: Budget) -> Iterator[BenchRow]:
    """All rules on all cases, as far as the time goes."""
    cases = QUICK_CASES if budget.quick else FULL_CASES
    for i, case in enumerate(cases):
        if budget.left_s <= 0.0:
            return
        budget.tell(i / len(cases), case.name)
        exact = reference_electrons(case, QUICK_DEGREE)
        function, n_grid = as_used(case)
        yield measured_row(case, AS_USED, function, n_grid, exact, quick=budget.quick)
        for name in RULES:
            for n in QUICK_NODES if budget.quick else NODES:
                yield measured_row(case, name, by_rule(case, name, n), n, exact, quick=budget.quick)
    budget.tell(1.0, "done")


def tables(rows: Sequence[BenchRow]) -> Sequence[BenchTable]:
    """By case: the default's error and time, and the least nodes of each rule that reach 1e-4."""
    made = []
    for case in dict.fromkeys(row.case for row in rows):
        of_case = [row for row in rows if row.case == case]
        used = [row for row in of_case if row.method == AS_USED]
        cells = [case, *([error_text(used[0].error), error_text(used[0].time_s)] if used else ["", ""])]
        made.append(
            [*cells, *(least_size([r for r in of_case if r.method == name], TARGET) for name in RULES)]
        )
    return [
        BenchTable(
            "The default, and the least nodes for 1e-4",
            ["case", "error as used", "time as used, s", *RULES],
            made,
            f"As used: a grid of {GRID_STEP_NM:g} nm, contracted once, its loss in water a polynomial of both paths. "
            "For the rules: the least number of nodes from which on the error stays within 1e-4; more than: none of "
            "those tried.",
        )
    ]


SUITE = Suite(
    name=NAME,
    title="Integral over wavelength",
    text=(
        "Electrons per lumen second: lamp spectrum, floor, water, port, lens and sensor integrated over 380-780 nm, "
        "the lamp's normalisation to lumens included. The integrand is a continuous function: tables joined linearly "
        "between their own entries, formulas where the model has formulas. Trapezoid and Simpson on even nodes and "
        "one Gauss-Legendre rule over the whole spectrum are compared with the integral from knot to knot in mpmath "
        f"with 30 digits, written separately. 'As used' is what a search evaluates: the grid of {GRID_STEP_NM:g} nm, "
        "contracted once, with the loss in water as a polynomial of both paths. Time is that of one design of up to "
        "1000 contracted together; what is done once for all designs is not in it. To be read off: the nodes that "
        "1e-4 takes, and that the polynomial costs less than any sum over nodes that is as good."
    ),
    chart="precision",
    measure=measure,
    quick_s=6.0,
    full_s=60.0,
    size_name="nodes",
    time_name="time per design, s",
    tables=tables,
)

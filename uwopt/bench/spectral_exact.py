"""Electrons by arbitrary precision: the reference of the suite `spectral`.

The integrand of physics page, sections 1 to 6, written again in mpmath from the tables as they are published,

    S(l)/(683.002 int V S) * M/pi * 1/n_w^2 * pi/4 * eta l/(h c) * exp(-K r_lamp - c r_camera)

as a continuous function of wavelength: tables joined linearly between their own entries, formulas where
the model has formulas. It is integrated from knot to knot by mpmath's Gauss-Legendre rule in arithmetic of
34 digits; no array and no function of the model is used.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

DIGITS = 34
FIRST_NM, LAST_NM = 380, 780
WIDEST_NM = 2  # of one interval: narrow against the generic LED's blue line
DEGREE = 3  # of mpmath's rule: 3 * 2^(degree - 1) = 12 nodes an interval
QUICK_DEGREE = 2  # half of them: differs by less than 1e-12
EFFICACY_LM_W = "683.002"  # as in section 1
PLANCK_J_S, LIGHT_M_S, BOLTZMANN_J_PER_K = "6.62607015e-34", "299792458", "1.380649e-23"
LED_BANDS = (("24.49", "450.70", "11.67"), ("119.86", "565.43", "64.63"))  # section 1

Number = Any  # mpmath's mpf
Entries = tuple[tuple[float, ...], tuple[float, ...]]  # wavelengths [nm] and values


@dataclass(frozen=True)
class Tables:
    """Everything that the integrand is made of. Tables are held beyond their ends but for the lamp's and V."""

    lamp: Entries | float | None  # a table, the temperature of a black body [K], or the generic LED
    photopic: Entries
    reflectance: Entries
    efficiency: tuple[tuple[float, Entries], ...]  # channels and their shares
    absorption: Entries  # [1/m]
    scattering: Entries
    diffuse: Entries  # K_d
    pure_water: Entries  # absorption of water itself, which continues a(l) beyond its table
    backscatter_ratio: float
    index: tuple[float, ...]  # n0 ... n9 of Quan and Fry
    temperature_c: float
    salinity_psu: float


class Line:
    """A table joined linearly."""

    def __init__(self, entries: Entries, *, zero_outside: bool = False):
        import mpmath

        self.places = list(entries[0])
        self.knots = [mpmath.mpf(x) for x in entries[0]]
        self.values = [mpmath.mpf(y) for y in entries[1]]
        steps = zip(self.knots, self.knots[1:], self.values, self.values[1:], strict=False)
        self.slopes = [(y1 - y0) / (x1 - x0) for x0, x1, y0, y1 in steps]
        zero = mpmath.mpf(0)
        self.ends = (zero, zero) if zero_outside else (self.values[0], self.values[-1])

    def __call__(self, x: Number) -> Number:
        place = float(x)
        if place < self.places[0]:
            return self.ends[0]
        if place > self.places[-1]:
            return self.ends[1]
        i = min(bisect_right(self.places, place), len(self.slopes)) - 1
        return self.values[i] + self.slopes[i] * (x - self.knots[i])


class Integrand:
    """The integrand of one case; weights at the nodes are kept, so that more paths cost only their losses."""

    def __init__(self, tables: Tables, degree: int = DEGREE):
        import mpmath

        with mpmath.workdps(DIGITS):
            self.zero = mpmath.mpf(0)
            self.ratio = mpmath.mpf(tables.backscatter_ratio)
            self.index_terms = index_terms(tables)
            energy_j_nm = (
                mpmath.mpf(PLANCK_J_S) * mpmath.mpf(LIGHT_M_S) * 10**9
            )  # of a photon, times its wavelength
            self.lamp, lamp_knots = lamp_function(tables.lamp)
            self.photopic = Line(tables.photopic, zero_outside=True)
            self.reflectance = Line(tables.reflectance)
            self.efficiency = [(mpmath.mpf(share), Line(entries)) for share, entries in tables.efficiency]
            self.a_table, self.b, self.kd, self.pure = (
                Line(entries)
                for entries in (tables.absorption, tables.scattering, tables.diffuse, tables.pure_water)
            )
            lines = [self.photopic, self.reflectance, *(line for _, line in self.efficiency)]
            lines += [self.a_table, self.b, self.kd, self.pure]
            self.knots = self.with_kinks_of_losses(knots_of([lamp_knots, *(line.knots for line in lines)]))
            self.nodes = [
                node
                for pair in zip(self.knots, self.knots[1:], strict=False)
                for node in nodes(*pair, degree)
            ]
            lit = [(x, w * self.lamp(x)) for x, w in self.nodes]
            lumens = mpmath.mpf(EFFICACY_LM_W) * mpmath.fsum(power * self.photopic(x) for x, power in lit)
            scale = 1 / (4 * energy_j_nm * lumens)
            self.terms = [(scale * power * self.seen(x), *self.losses(x)) for x, power in lit if power]

    def with_kinks_of_losses(self, knots: list[Number]) -> list[Number]:
        """Knots and the places between them where K is clipped, or absorption would fall below 0."""
        found, signs = [], [self.signs(x) for x in knots]
        for low, high, at_low, at_high in zip(knots, knots[1:], signs, signs[1:], strict=False):
            for first, last in zip(at_low, at_high, strict=True):
                if first * last < 0:
                    found.append(low + (high - low) * first / (first - last))
        return knots_of([knots, found])

    def signs(self, x: Number) -> tuple[Number, Number, Number]:
        """What is piecewise linear and changes sign at a kink of the losses."""
        a, b, kd = self.absorption(x), self.b(x), self.kd(x)
        return a, kd - max(a, self.zero) - self.ratio * b, kd - max(a, self.zero) - b

    def absorption(self, x: Number) -> Number:
        """a(l) before it is held at 0: beyond the table's ends the rise of pure water is added."""
        a, ends = self.a_table(x), self.a_table.knots
        if ends[0] <= x <= ends[-1]:
            return a
        return a + self.pure(x) - self.pure(ends[0] if x < ends[0] else ends[-1])

    def losses(self, x: Number) -> tuple[Number, Number]:
        """K of the lamp's leg and c of the camera's [1/m]."""
        a, b = max(self.absorption(x), self.zero), self.b(x)
        return min(max(self.kd(x), a + self.ratio * b), a + b), a + b

    def seen(self, x: Number) -> Number:
        """M eta l / n^2: what floor, water and sensor make of the lamp's light."""
        efficiency = sum(share * line(x) for share, line in self.efficiency)
        n = horner(self.index_terms, 1 / x)
        return self.reflectance(x) * efficiency * x / (n * n)

    def electrons(self, lamp_m: float, camera_m: float) -> Number:
        """Electrons per lm s/m^2 on the floor in vacuum and m^2 of pixel, for these paths in water."""
        import mpmath

        with mpmath.workdps(DIGITS):
            r_lamp, r_camera = mpmath.mpf(lamp_m), mpmath.mpf(camera_m)
            return mpmath.fsum(w * mpmath.exp(-k * r_lamp - c * r_camera) for w, k, c in self.terms)


def index_terms(tables: Tables) -> list[Number]:
    """n_w of Quan and Fry as a polynomial of 1/l."""
    import mpmath

    n = [mpmath.mpf(value) for value in tables.index]
    t, s = mpmath.mpf(tables.temperature_c), mpmath.mpf(tables.salinity_psu)
    return [n[0] + (n[1] + n[2] * t + n[3] * t**2) * s + n[4] * t**2, n[5] + n[6] * s + n[7] * t, n[8], n[9]]


def horner(terms: Sequence[Number], x: Number) -> Number:
    """A polynomial, lowest term first."""
    total = terms[-1]
    for term in reversed(terms[:-1]):
        total = total * x + term
    return total


def lamp_function(lamp: Entries | float | None) -> tuple[Callable[[Number], Number], list[Number]]:
    """A lamp's relative power per nm, and its knots."""
    import mpmath

    if lamp is None:
        bands = [tuple(mpmath.mpf(text) for text in band) for band in LED_BANDS]
        return lambda x: sum(a / s * mpmath.exp(-(((x - m) / s) ** 2) / 2) for a, m, s in bands), []
    if isinstance(lamp, tuple):
        line = Line(lamp, zero_outside=True)
        return line, line.knots
    kelvin_nm = mpmath.mpf(PLANCK_J_S) * mpmath.mpf(LIGHT_M_S) / mpmath.mpf(BOLTZMANN_J_PER_K) * 10**9
    exponent_nm = kelvin_nm / mpmath.mpf(lamp)
    return lambda x: (500 / x) ** 5 / mpmath.expm1(exponent_nm / x), []


def knots_of(lists: Sequence[Sequence[Number]]) -> list[Number]:
    """All knots within the spectrum, rising, with more between them where they are far apart."""
    import mpmath

    even = [mpmath.mpf(x) for x in range(FIRST_NM, LAST_NM + 1, WIDEST_NM)]
    inside = {x for part in lists for x in part if FIRST_NM < x < LAST_NM}
    return sorted(inside | set(even))


@cache
def unit_nodes(degree: int) -> tuple[tuple[Number, Number], ...]:
    """mpmath's Gauss-Legendre nodes on [-1, 1] and weights."""
    import mpmath
    from mpmath.calculus.quadrature import GaussLegendre

    with mpmath.workdps(DIGITS):
        return tuple(GaussLegendre(mpmath.mp).calc_nodes(degree, mpmath.mp.prec + 20))


def nodes(low: Number, high: Number, degree: int) -> list[tuple[Number, Number]]:
    """Nodes and weights on one interval."""
    half, middle = (high - low) / 2, (high + low) / 2
    return [(middle + half * x, half * w) for x, w in unit_nodes(degree)]

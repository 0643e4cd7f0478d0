"""Water as people know it: a visibility, a Secchi depth, a turbidity or an attenuation made into a whole spectrum.

Each reading says, by its published relation, what one number of the water is at 530 nm: the beam attenuation
c = a + b, c + K_d, or the scattering of particles. The spectrum is that of real waters: the Jerlov types in the order
of their c are a row from clear to murky, and the water sought is the mixture of the two neighbours that gives that
number. Beyond the murkiest type its particles grow; so they grow or shrink in a type that the mission names for its
colour. Absorption, scattering and K_d are linear in both, so that the share follows in closed form.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from types import MappingProxyType
from typing import Literal

import numpy as np

from uwopt.arrays import FloatArray
from uwopt.catalog.curves.spectra import WaterProfile, pure_water, water_profile, water_types
from uwopt.catalog.tables import built_in_rows
from uwopt.errors import CatalogError
from uwopt.model.spectrum import resample
from uwopt.model.water import extend_absorption_per_m

JerlovTable = Literal["solonenko-mobley", "measured"]
ClarityEnd = Literal["low", "central", "high"]  # of the attenuation: clearest, most likely, murkiest

AT_NM = 530.0
GRID_NM = np.arange(350.0, 801.0)  # holds every wavelength of both tables from 350 nm on
MOST_PARTICLES = 10.0  # times those of a Jerlov type: no longer its water
OF_TYPE = "water as of Jerlov "
ENDS: tuple[ClarityEnd, ...] = ("central", "low", "high")


@dataclass(frozen=True, slots=True)
class Relation:
    """What a reading says of a water at 530 nm, and how well."""

    key: str
    unit: str
    of: str  # c, c_kd or b_p
    inverse: bool
    factors: Mapping[ClarityEnd, float]
    text: str
    source: str
    spread: str
    advice: str  # what is measured best

    def target_per_m(self, value: float, end: ClarityEnd = "central") -> float:
        """The number at 530 nm that a reading stands for [1/m]."""
        return self.factors[end] / value if self.inverse else self.factors[end] * value


@dataclass(frozen=True, slots=True, eq=False)
class Clarity:
    """A reading, and the waters it may mean."""

    relation: Relation
    value: float
    profiles: Mapping[ClarityEnd, WaterProfile]

    def c_per_m(self, end: ClarityEnd = "central") -> float:
        """Beam attenuation at 530 nm [1/m]."""
        return float(np.interp(AT_NM, GRID_NM, self.profiles[end].attenuation_per_m))

    @property
    def explained(self) -> str:
        """Relation, what the water is made of, spread and advice, in one line."""
        of = self.relation
        return f"{of.text} ({of.source}): {self.profiles['central'].name}; {of.spread}; {of.advice}"


@cache
def relations() -> Mapping[str, Relation]:
    """All relations by the key of a scene."""
    return MappingProxyType({row["key"]: _relation(row) for row in built_in_rows("water_clarity.csv")})


def _relation(row: Mapping[str, str]) -> Relation:
    factors: dict[ClarityEnd, float] = {
        "low": float(row["factor_low"]), "central": float(row["factor"]), "high": float(row["factor_high"]),
    }  # fmt: skip
    return Relation(
        row["key"], row["unit"], row["of"], row["power"] == "-1", MappingProxyType(factors),
        row["relation"], row["source"], row["spread"], row["advice"],
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Water:
    """Absorption, scattering and K_d of a water on `GRID_NM` [1/m]."""

    name: str
    a_per_m: FloatArray
    b_per_m: FloatArray
    kd_per_m: FloatArray
    table: JerlovTable
    notes: tuple[str, ...] = ()

    def at_per_m(self, of: str) -> float:
        """c, c + K_d or the scattering of particles at 530 nm."""
        sums = {
            "c": self.a_per_m + self.b_per_m,
            "c_kd": self.a_per_m + self.b_per_m + self.kd_per_m,
            "b_p": self.b_per_m - _pure().b_per_m,
        }
        return float(np.interp(AT_NM, GRID_NM, sums[of]))

    def towards(self, other: _Water, share: float) -> _Water:
        """`share` of the other water by volume, the rest of this one."""
        one, two = (name.removeprefix(OF_TYPE) for name in (self.name, other.name))
        return replace(
            self,
            name=f"{100 * (1 - share):.0f} % {OF_TYPE}{one} and {100 * share:.0f} % as of {two}",
            a_per_m=self.a_per_m + share * (other.a_per_m - self.a_per_m),
            b_per_m=self.b_per_m + share * (other.b_per_m - self.b_per_m),
            kd_per_m=self.kd_per_m + share * (other.kd_per_m - self.kd_per_m),
            notes=tuple(dict.fromkeys((*self.notes, *other.notes))),
        )

    def with_particles(self, share: float) -> _Water:
        """`share` times what stands above pure water; where a table lies below it, nothing changes."""
        pure, more = _pure(), share - 1.0
        return replace(
            self,
            name=f"{self.name}, all that is not water times {share:.3g}",
            a_per_m=self.a_per_m + more * np.maximum(self.a_per_m - pure.a_per_m, 0.0),
            b_per_m=self.b_per_m + more * np.maximum(self.b_per_m - pure.b_per_m, 0.0),
            kd_per_m=self.kd_per_m + more * np.maximum(self.kd_per_m - pure.kd_per_m, 0.0),
        )

    @property
    def profile(self) -> WaterProfile:
        """The water as the model takes it."""
        c = self.a_per_m + self.b_per_m
        return WaterProfile(
            self.name, self.table, GRID_NM, c, self.a_per_m, self.b_per_m, GRID_NM, self.kd_per_m, self.notes
        )


@cache
def clarity(key: str, value: float, table: JerlovTable | None = None, water: str | None = None) -> Clarity:
    """The waters that a reading may mean: mixtures of Jerlov types, or one `water` with more or fewer particles.

    `table` is that of the types: `measured` (and for those that it lacks the other) unless given.
    """
    relation, profiles = relations()[key], {}
    row = _row(table) if water is None else (_on_grid(water_profile(water, table)),)
    for end in ENDS:
        wanted = relation.target_per_m(value, end)
        try:
            made = _within(row, relation.of, wanted, nearest=end != "central")
        except CatalogError as beyond:
            raise CatalogError(f"{key} = {value:g} {relation.unit} {beyond}") from None
        profiles[end] = made.profile
    return Clarity(relation, value, MappingProxyType(profiles))


def _row(table: JerlovTable | None) -> tuple[_Water, ...]:
    """All types, clearest first; each by `table`, or measured where that is known."""
    wanted: JerlovTable | None = None if table == "measured" else table
    made = [_on_grid(water_profile(name, wanted)) for name in water_types("solonenko-mobley")]
    return tuple(
        replace(one, table=table or "measured") for one in sorted(made, key=lambda one: one.at_per_m("c"))
    )


def _on_grid(profile: WaterProfile) -> _Water:
    """A Jerlov type at every whole wavelength, continued beyond its table as the model does."""
    assert profile.table != "custom" and profile.a_per_m is not None and profile.b_per_m is not None
    assert profile.kd_per_m is not None and profile.kd_wavelength_nm is not None
    pure = pure_water()
    a = extend_absorption_per_m(
        GRID_NM, table_nm=profile.wavelength_nm, table_a_per_m=profile.a_per_m, pure_water_nm=pure.wavelength_nm,
        pure_water_a_per_m=pure.a_per_m,
    )  # fmt: skip
    b = _held(profile.wavelength_nm, profile.b_per_m)
    kd = _held(profile.kd_wavelength_nm, profile.kd_per_m)
    return _Water(OF_TYPE + profile.name, a, b, kd, profile.table, profile.notes)


@cache
def _pure() -> _Water:
    """Sea water without anything in it; K_d = a + b / 2 (Smith and Baker 1981)."""
    pure = pure_water()
    a, b = _held(pure.wavelength_nm, pure.a_per_m), _held(pure.wavelength_nm, pure.b_sea_per_m)
    return _Water("pure sea water", a, b, a + 0.5 * b, "measured")


def _held(table_nm: FloatArray, values: FloatArray) -> FloatArray:
    """A table on the grid, its ends held."""
    return np.asarray(resample(GRID_NM, table_nm=table_nm, table_values=values, outside="hold"))


def _within(row: Sequence[_Water], of: str, target_per_m: float, *, nearest: bool) -> _Water:
    """The water of a row of types that has the wanted number at 530 nm; if `nearest` does, the nearest to that."""
    values = [one.at_per_m(of) for one in row]
    if len(row) == 1 or target_per_m >= values[-1]:
        return _grown(row[-1], of, target_per_m, nearest=nearest)
    if target_per_m < values[0]:
        if nearest:
            return row[0]
        least = row[0].at_per_m("c")
        raise CatalogError(f"is clearer than any sea: Jerlov I has c = {least:.2g} 1/m at {AT_NM:g} nm.")
    upper = int(np.searchsorted(values, target_per_m, side="right"))
    share = (target_per_m - values[upper - 1]) / (values[upper] - values[upper - 1])
    return row[upper - 1] if share == 0.0 else row[upper - 1].towards(row[upper], share)


def _grown(base: _Water, of: str, target_per_m: float, *, nearest: bool) -> _Water:
    """One type with more or fewer particles."""
    here = base.at_per_m(of)
    rise = base.with_particles(2.0).at_per_m(of) - here
    share = 1.0 + (target_per_m - here) / rise if rise > 0.0 else math.inf
    if nearest:
        share = min(max(share, 0.0), MOST_PARTICLES)
    if share < 0.0:
        raise CatalogError(
            f"is clearer than {base.name} without any particles; name a clearer type, or none."
        )
    if share > MOST_PARTICLES:
        more = f"takes more than {MOST_PARTICLES:g} times the particles of {base.name}"
        raise CatalogError(f"{more}; name a murkier type, or none.")
    return base if share == 1.0 else base.with_particles(share)

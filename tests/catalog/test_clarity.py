"""Readings of clarity made into waters: relations by hand, mixtures against the tables, K_d against another survey."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uwopt.catalog.curves.clarity import AT_NM, Clarity, clarity, relations
from uwopt.catalog.curves.spectra import WaterProfile, photopic, pure_water, water_profile, water_types
from uwopt.errors import CatalogError

#: Type III at 530 nm, Williamson and Hollins (2022): a 0.0806, b 0.291; K_d of Jerlov (1968) 0.122 at 525 nm and 0.145
#: at 550 nm, so 0.1266 between.
C_III_PER_M, KD_III_PER_M = 0.0806 + 0.291, 0.122 + 0.2 * (0.145 - 0.122)
PURE_B_PER_M = (
    0.001994  # sea water at 530 nm, Zhang, Hu and He (2009), between 0.002075 (525) and 0.001912 (535)
)
RANGES = {
    "c_per_m": (0.055, 20.0),
    "visibility_m": (0.3, 80.0),
    "secchi_m": (0.4, 80.0),
    "turbidity_ntu": (0.02, 15.0),
}
KEYS = st.sampled_from(sorted(RANGES))
TABLES = st.sampled_from([None, "measured", "solonenko-mobley"])


def at_530(water: WaterProfile, values: np.ndarray | None) -> float:
    assert values is not None
    return float(np.interp(AT_NM, water.wavelength_nm, values))


def central(known: Clarity) -> WaterProfile:
    return known.profiles["central"]


def within(key: str, share: float) -> float:
    """A reading of the range that a mission may give, by its logarithm."""
    low, high = RANGES[key]
    return float(low * (high / low) ** share)


# ---------------------------------------------------------------- the published relations, by hand


def test_a_visibility_of_eight_metres_is_an_attenuation_of_0_6():
    # Davies-Colley (1988): 4.8 / 8 m = 0.6 1/m
    assert clarity("visibility_m", 8.0).c_per_m() == pytest.approx(0.6, rel=1e-9)


def test_the_visibility_of_type_iii_gives_type_iii():
    water = central(clarity("visibility_m", 4.8 / C_III_PER_M))  # 12.9 m
    own = water_profile("III", "measured")
    assert own.a_per_m is not None and own.b_per_m is not None
    for values, table in ((water.a_per_m, own.a_per_m), (water.b_per_m, own.b_per_m)):
        assert values is not None
        held = np.interp(water.wavelength_nm, own.wavelength_nm, table)
        assert values == pytest.approx(held, rel=1e-3)  # the table at 530 nm has three digits


def test_the_secchi_depth_of_type_iii_gives_type_iii():
    # Tyler (1968): 8.69 / (0.3716 + 0.1266) = 17.44 m
    known = clarity("secchi_m", 8.69 / (C_III_PER_M + KD_III_PER_M))
    assert known.c_per_m() == pytest.approx(C_III_PER_M, rel=1e-6)


def test_a_secchi_depth_counts_both_attenuations():
    # c + K_d = 8.69 / 10 = 0.869 1/m
    water = central(clarity("secchi_m", 10.0))
    both = at_530(water, water.attenuation_per_m) + at_530(water, water.kd_per_m)
    assert both == pytest.approx(0.869, rel=1e-9)


def test_two_ntu_are_particles_that_scatter_two_per_metre():
    # Kirk (1994): as many 1/m as NTU; the water's own 0.002 on top
    water = central(clarity("turbidity_ntu", 2.0))
    assert at_530(water, water.b_per_m) == pytest.approx(2.0 + PURE_B_PER_M, rel=1e-5)


@pytest.mark.parametrize(
    ("key", "value", "low", "high"),
    [("c_per_m", 0.5, 0.475, 0.6), ("visibility_m", 10.0, 0.41, 0.55)],
)  # fmt: skip
def test_the_range_is_that_of_the_relation(key: str, value: float, low: float, high: float):
    # c: 5 % down, 20 % up; visibility: 4.1 to 5.5 over 10 m
    known = clarity(key, value)
    assert (known.c_per_m("low"), known.c_per_m("high")) == pytest.approx((low, high), rel=1e-9)


@pytest.mark.parametrize("key", RANGES)
def test_every_relation_has_source_spread_and_advice(key: str):
    relation = relations()[key]
    assert relation.source and relation.spread and relation.advice
    assert relation.factors["low"] < relation.factors["central"] < relation.factors["high"]


# ---------------------------------------------------------------- the waters


@pytest.mark.parametrize("table", ["measured", "solonenko-mobley"])
@pytest.mark.parametrize("name", water_types("solonenko-mobley")[2:])
def test_the_attenuation_of_a_type_gives_its_whole_spectrum(name: str, table: str):
    if table == "measured" and name not in water_types("measured"):
        return
    own = water_profile(name, table)  # type: ignore[arg-type]
    water = central(clarity("c_per_m", at_530(own, own.attenuation_per_m), table))  # type: ignore[arg-type]
    inside = (water.wavelength_nm >= 350) & (water.wavelength_nm <= 700)
    nm = water.wavelength_nm[inside]
    for values, at_nm, table_values in (
        (water.a_per_m, own.wavelength_nm, own.a_per_m), (water.b_per_m, own.wavelength_nm, own.b_per_m),
        (water.kd_per_m, own.kd_wavelength_nm, own.kd_per_m),
    ):  # fmt: skip
        assert values is not None and at_nm is not None and table_values is not None
        assert values[inside] == pytest.approx(np.interp(nm, at_nm, table_values), rel=1e-9)


def test_a_quarter_of_the_way_between_types_is_a_quarter_of_the_murkier():
    one, other = water_profile("1C", "measured"), water_profile("3C", "measured")
    c = 0.75 * at_530(one, one.attenuation_per_m) + 0.25 * at_530(other, other.attenuation_per_m)
    water = central(clarity("c_per_m", c))
    for nm in (400.0, 450.0, 600.0, 700.0):
        low, high = (float(np.interp(nm, w.wavelength_nm, w.attenuation_per_m)) for w in (one, other))
        found = float(np.interp(nm, water.wavelength_nm, water.attenuation_per_m))
        assert found == pytest.approx(0.75 * low + 0.25 * high, rel=1e-9)


def test_k_d_of_the_row_agrees_with_another_survey():
    # Shannon (1975), doi:10.1117/12.954489: K = 0.2 c + 0.04 at 535 nm for c of 0.11 to 1.6 1/m, from the US east coast
    # to the Puerto Rico trench. The row of types stays within 21 % of that line (IB), 15 % above
    # 0.25 1/m; the line itself is a fit.
    for c_per_m in np.geomspace(0.12, 1.55, 20):
        water = central(clarity("c_per_m", float(c_per_m)))
        assert water.kd_per_m is not None and water.kd_wavelength_nm is not None
        c = float(np.interp(535.0, water.wavelength_nm, water.attenuation_per_m))
        kd = float(np.interp(535.0, water.kd_wavelength_nm, water.kd_per_m))
        assert kd == pytest.approx(0.2 * c + 0.04, rel=0.215)


def test_beyond_the_murkiest_type_what_is_not_water_grows():
    # twice the particles of 9C: a_w + 2 (a - a_w) at 450 nm
    own, pure = water_profile("9C"), pure_water()
    pure_c = float(np.interp(AT_NM, pure.wavelength_nm, pure.a_per_m + pure.b_sea_per_m))
    water = central(clarity("c_per_m", pure_c + 2 * (at_530(own, own.attenuation_per_m) - pure_c)))
    own_a = float(np.interp(450.0, own.wavelength_nm, own.a_per_m))  # type: ignore[arg-type]
    pure_a = float(np.interp(450.0, pure.wavelength_nm, pure.a_per_m))
    assert np.interp(450.0, water.wavelength_nm, water.a_per_m) == pytest.approx(  # type: ignore[arg-type]
        pure_a + 2 * (own_a - pure_a), rel=1e-6
    )


def test_a_type_beside_a_reading_lends_its_colour():
    # what 3C absorbs beyond water at 420 nm over that at 530 nm: (0.233 - 0.0029) / (0.128 - 0.0445), whatever c is
    water, pure = central(clarity("c_per_m", 0.3, None, "3C")), pure_water()
    assert at_530(water, water.attenuation_per_m) == pytest.approx(0.3, rel=1e-9)
    assert water.a_per_m is not None
    more = water.a_per_m - np.interp(water.wavelength_nm, pure.wavelength_nm, pure.a_per_m)
    at = {nm: float(np.interp(nm, water.wavelength_nm, more)) for nm in (420.0, 530.0)}
    assert at[420.0] / at[530.0] == pytest.approx((0.233 - 0.0029) / (0.128 - 0.0445), rel=3e-3)


@given(key=KEYS, share=st.floats(0.0, 1.0), table=TABLES)
def test_every_reading_that_may_be_given_has_a_water_with_a_range(key: str, share: float, table: str | None):
    known = clarity(key, within(key, share), table)  # type: ignore[arg-type]
    low, middle, high = (known.c_per_m(end) for end in ("low", "central", "high"))
    assert 0.05 < low < middle < high
    for water in known.profiles.values():
        for values in (water.a_per_m, water.b_per_m, water.kd_per_m):
            assert values is not None and np.all(values > 0)


@given(key=KEYS, shares=st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)), table=TABLES)
def test_the_further_one_sees_the_less_a_water_attenuates(
    key: str, shares: tuple[float, float], table: str | None
):
    low, high = sorted(within(key, share) for share in shares)
    first, second = (clarity(key, value, table).c_per_m() for value in (low, high))  # type: ignore[arg-type]
    if relations()[key].inverse:
        first, second = second, first
    assert first <= second * (1 + 1e-12)


@pytest.mark.parametrize(
    ("key", "value", "water", "said"),
    [("secchi_m", 200.0, None, "secchi_m = 200 m is clearer than any sea: Jerlov I has c = 0.051"),
     ("turbidity_ntu", 3.0, "I", "takes more than 10 times the particles of water as of Jerlov I"),
     ("c_per_m", 0.03, "II", "is clearer than water as of Jerlov II without any particles")],
)  # fmt: skip
def test_what_no_water_has_is_refused_in_words(key: str, value: float, water: str | None, said: str):
    with pytest.raises(CatalogError, match=said):
        clarity(key, value, None, water)


@pytest.mark.parametrize("name", water_types("solonenko-mobley"))
def test_the_eyes_band_may_stand_for_530_nm(name: str):
    # c weighted by V(lambda) and by daylight where half an attenuation length of its clearest colour is passed: the
    # visibility's own c. At most 10.04 % in IA; the range of the relation, 15 %, holds it.
    water, eye = water_profile(name), photopic()
    assert water.kd_per_m is not None and water.kd_wavelength_nm is not None
    nm = np.arange(400.0, 701.0)
    kd = np.interp(nm, water.kd_wavelength_nm, water.kd_per_m)
    weight = np.interp(nm, eye.wavelength_nm, eye.value) * np.exp(-0.5 * kd / kd.min())
    seen = float(
        np.sum(weight * np.interp(nm, water.wavelength_nm, water.attenuation_per_m)) / np.sum(weight)
    )
    assert seen == pytest.approx(at_530(water, water.attenuation_per_m), rel=0.101)

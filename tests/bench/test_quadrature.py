"""The suite `quadrature`: its reference against closed forms and against itself in other coordinates, and its rows."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from thorough import THOROUGH, drawn

from uwopt.bench import quadrature
from uwopt.bench import quadrature_exact as exact
from uwopt.bench.quadrature import AS_USED, DOME, FLAT, IMAGE_VEIL, PIXEL_VEIL, SIGNAL, TARGETS
from uwopt.bench.quadrature_exact import ImageCase, Water
from uwopt.bench.suite import BenchRow, Budget
from uwopt.model.footprint import footprint_illuminance_per_lm
from uwopt.model.imaging import PortShape

WIDE = (0.3, 0.4)


@pytest.fixture(scope="module")
def rows() -> Sequence[BenchRow]:
    return list(quadrature.measure(Budget(quick=True, seconds=math.inf)))


def clear(c_per_m: float = 0.0) -> Water:
    """One colour, K = 0, phase function 1/(4 pi)."""
    one = np.ones(1)
    return Water(0.0 * one, c_per_m * one, one, (one,), (lambda cos: 0.0 * cos + 1.0 / (4.0 * math.pi),))


def test_an_even_disc_over_a_clear_floor_gives_the_mean_of_cos4_in_closed_form() -> None:
    # E = 1/(pi d^2 tan^2 b) everywhere in view; the mean of (1 + u^2 + v^2)^-2 over |u|, |v| <= a is
    # (1/a^2) * int_0^a int_0^a = arctan(a/sqrt(1+a^2)) / (a sqrt(1+a^2))
    a, d, b = 0.3, 2.0, math.radians(45)
    light = ImageCase("even", (a, a), DOME, d, quadrature.lamp(y=0.2), quadrature.disc(45), clear())
    root = math.sqrt(1.0 + a * a)
    by_hand = math.atan(a / root) / (a * root) / (math.pi * d**2 * math.tan(b) ** 2)
    assert exact.mean_signal(light) == pytest.approx(by_hand, rel=1e-10)
    assert exact.polar_mean_signal(light) == pytest.approx(by_hand, rel=1e-10)


def test_a_spot_within_the_image_holds_all_its_light() -> None:
    # without cos^4 and water all of the spot's E dA is what the disc sends: here the spot is tiny, at (x, y) = (0, b)
    d, b, y = 2.0, math.radians(0.05), 0.3
    light = ImageCase("spot", WIDE, DOME, d, quadrature.lamp(y=y), quadrature.disc(0.05), clear())
    scale_m = d + DOME.outer_radius_m
    area_m2 = 4.0 * WIDE[0] * WIDE[1] * scale_m**2
    expected = 1.0 / area_m2 / (1.0 + (y / scale_m) ** 2) ** 2
    assert exact.polar_mean_signal(light) == pytest.approx(expected, rel=10 * b**2)


def test_the_veil_of_even_light_in_clear_water_is_an_arctangent() -> None:
    # axis of a flat port, I = 1/(2 pi), p = 1/(4 pi): integral of dr/(b^2 + r^2) = arctan(d/b)/b
    d, b = 3.0, 0.5
    light = ImageCase("even", WIDE, FLAT, d, quadrature.lamp(y=b), quadrature.cone(90), clear())
    assert exact.ray_veil(0.0, 0.0, light) == pytest.approx(
        math.atan(d / b) / b / (8 * math.pi**2), rel=1e-12
    )


@pytest.mark.parametrize("half_deg", drawn([25], [12, 25]))
def test_both_coordinates_give_the_same_signal(half_deg: float) -> None:
    light = replace(quadrature.cases(True)[2], beam=quadrature.disc(half_deg))
    assert exact.polar_mean_signal(light) == pytest.approx(exact.mean_signal(light), rel=1e-7)


def test_the_double_exponential_rule_stands_still_between_entries(monkeypatch: pytest.MonkeyPatch) -> None:
    light = next(light for light in quadrature.cases(False) if light.beam.kind == "tabulated")
    coarse = quadrature.reference(light, PIXEL_VEIL)
    monkeypatch.setattr(exact, "SHORT_STEP", 0.5 * exact.SHORT_STEP)
    np.testing.assert_allclose(quadrature.reference(light, PIXEL_VEIL), coarse, rtol=1e-9)


def test_rings_refuse_what_they_cannot_do() -> None:
    with pytest.raises(ValueError, match="straight down"):
        exact.polar_mean_signal(quadrature.cases(True)[1])


def test_gauss_legendre_converges_fast_and_cells_with_their_square() -> None:
    smooth, edge = quadrature.cases(True)[0], quadrature.cases(True)[2]
    askew = replace(smooth, lamps=quadrature.lamp(x=0.1))  # nothing mirrors along the motion: n nodes a side
    truth = exact.mean_signal(askew)
    model, places = quadrature.model_of(askew, SIGNAL), quadrature.places_of(askew, SIGNAL)
    errors = [abs(float(model(*places, n)[0]) / truth - 1.0) for n in (4, 6, 8)]
    assert errors[0] > 20 * errors[1] > 400 * errors[2]
    truth = exact.mean_signal(edge)
    model, places = quadrature.model_of(edge, SIGNAL), quadrature.places_of(edge, SIGNAL)
    errors = [abs(float(model(*places, n)[0]) / truth - 1.0) for n in (24, 384)]
    assert errors[1] < 4.0 * errors[0] / 16.0**1.5  # each edge cell errs with the square; signs vary


@pytest.mark.parametrize(
    ("shape", "outward_deg", "half_deg"),
    drawn([(DOME, -12, 20), (FLAT, 0, 20)], [(DOME, 0, 8), (DOME, -12, 20), (FLAT, 0, 20), (FLAT, -12, 8)]),
)
def test_a_small_spot_is_followed_as_well_as_a_large_one(
    shape: PortShape, outward_deg: float, half_deg: float
) -> None:
    # cells over the whole image erred by up to 1.6e-3 where a spot took a third of it
    lamps = quadrature.both(
        quadrature.lamp(share=0.7, outward_deg=outward_deg), quadrature.lamp(x=0.2, share=0.3)
    )
    light = ImageCase("spot", WIDE, shape, 3.0, lamps, quadrature.cone(half_deg), quadrature.water(0.5))
    model, places = quadrature.model_of(light, SIGNAL), quadrature.places_of(light, SIGNAL)
    assert model(*places, None)[0] == pytest.approx(exact.mean_signal(light), rel=1e-4)


def test_a_spot_outside_the_image_gives_nothing() -> None:
    light = ImageCase(
        "off", WIDE, FLAT, 1.0, quadrature.lamp(y=3.0), quadrature.disc(5), quadrature.water(0.5)
    )
    assert quadrature.model_of(light, SIGNAL)(*quadrature.places_of(light, SIGNAL), None)[0] == 0.0
    assert exact.mean_signal(light) == 0.0


def by_eight_nodes(function: Callable[[float], float], low: float, high: float, **_: float) -> tuple[float, None]:
    """Gauss-Legendre between two entries of a measured profile: 1e-6 of the image's signal, in a ninth of the time."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    half = 0.5 * (high - low)
    return half * sum(w * function(low + half * (x + 1.0)) for x, w in zip(nodes, weights, strict=True)), None


@pytest.mark.parametrize("target", TARGETS)
def test_the_default_is_within_a_ten_thousandth(target: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for light in quadrature.cases(False):
        if target == IMAGE_VEIL and (light.beam.kind == "tabulated" or "narrow cone" in light.name):
            continue  # five to ten seconds; the suite measures them
        with monkeypatch.context() as patch:
            if target == SIGNAL and light.beam.kind == "tabulated" and not THOROUGH:
                patch.setattr("scipy.integrate.quad", by_eight_nodes)
            truth = quadrature.reference(light, target)
        value = quadrature.model_of(light, target)(*quadrature.places_of(light, target), None)
        np.testing.assert_allclose(value, truth, rtol=1e-4, err_msg=light.name)


def test_rows_of_a_quick_run_are_well_formed(rows: Sequence[BenchRow]) -> None:
    assert {row.case for row in rows} == {light.name for light in quadrature.cases(True)}
    for row in rows:
        assert row.suite == "quadrature"
        assert row.time_s is not None
        assert row.time_s > 0.0
        assert row.error is not None
        assert 0.0 <= row.error < np.inf
        assert row.method.startswith(TARGETS)
        assert not row.note
    assert len({(row.case, row.method, row.size) for row in rows}) == len(rows)
    used = [row for row in rows if row.method.endswith(AS_USED)]
    assert len(used) == len(TARGETS) * len(quadrature.cases(True))
    assert all(row.error is not None and row.error < 1e-4 for row in used)


def test_the_tables_have_a_line_for_each_case(rows: Sequence[BenchRow]) -> None:
    made = quadrature.SUITE.tables(rows)
    assert len(made) == len(TARGETS)
    for table in made:
        assert len(table.rows) == len(quadrature.cases(True))
        assert all(len(line) == len(table.head) for line in table.rows)
    assert all(not table.rows for table in quadrature.SUITE.tables([]))


def test_a_suite_without_time_measures_nothing() -> None:
    assert list(quadrature.measure(Budget(quick=True, seconds=0.0))) == []


def test_dark_pixels_stay_dark() -> None:
    light = quadrature.cases(True)[2]
    truth = quadrature.reference(light, PIXEL_VEIL)
    value = quadrature.model_of(light, PIXEL_VEIL)(*quadrature.places_of(light, PIXEL_VEIL), None)
    np.testing.assert_array_equal(value == 0.0, truth == 0.0)
    assert np.any(truth == 0.0)
    assert quadrature.chosen_order(light, IMAGE_VEIL) is None


@pytest.mark.parametrize("half_deg", [2, 5, 9])
def test_the_footprints_mean_illuminance_of_a_spot_within_it_is_its_light_over_the_area(
    half_deg: float,
) -> None:
    # a disc in clear water, all of it in the image: one lumen over 4 X Y, X and Y half the footprint behind a dome
    d = 3.0
    mean, _ = footprint_illuminance_per_lm(
        *WIDE, shape=DOME, range_m=d, lamps=quadrature.lamp(y=0.3), beam=quadrature.disc(half_deg),
        weight=np.ones(2), attenuation_per_m=np.zeros(2),
    )  # fmt: skip
    assert mean == pytest.approx(1.0 / (4.0 * WIDE[0] * WIDE[1] * (d + DOME.outer_radius_m) ** 2), rel=5e-5)

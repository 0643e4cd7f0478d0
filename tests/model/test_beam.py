"""Beam shapes: energy, known intensities, profiles bent into water, rays to the floor."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.interpolate import PchipInterpolator

from uwopt.errors import RangeError
from uwopt.model import beam as beams
from uwopt.model.beam import Beam
from uwopt.model.imaging import Lamps, lamp_light

REFERENCE = Path(__file__).parents[1] / "reference"
SEALITE = pd.read_csv(REFERENCE / "beam_profile_dspl_sealite.csv", comment="#")
SEALITE_RAD = np.deg2rad(SEALITE.angle_deg.to_numpy())
FLOOD_PEAK_CD, SPOT_PEAK_CD = 5680.0, 14_400.0
N_W = 1.34
ANGLE_RAD = np.deg2rad([0.0, 20.0, 40.0, 60.0])


def flood(medium: str = "water", total_flux_lm: float | None = None) -> Beam:
    values = FLOOD_PEAK_CD * SEALITE.flood_rel.to_numpy()
    return beams.tabulated_beam(SEALITE_RAD, values, medium=medium, n_w=N_W, total_flux_lm=total_flux_lm)  # type: ignore[arg-type]


DOWNWARD = Lamps(x_m=(0.0,), y_m=(0.0,), z_m=(0.0,), aim=((0.0, 0.0, 1.0),), share=(1.0,))
BEAMS = {
    "disc 45": beams.disc_beam(np.deg2rad(45)),
    "disc 5": beams.disc_beam(np.deg2rad(5)),
    "cone 30": beams.cone_beam(np.deg2rad(30)),
    "cone 90": beams.cone_beam(np.pi / 2),
    "cosine-power 10": beams.cosine_power_beam(np.deg2rad(10)),
    "cosine-power 120": beams.cosine_power_beam(np.deg2rad(120)),
    "table, ends lit": beams.tabulated_beam(ANGLE_RAD, [4, 3, 3, 1], medium="water", n_w=N_W),
    "flood in water": flood(),
    "flood in air": flood("air"),
}


def energy(beam: Beam) -> float:
    """Integral of I/Phi over the sphere: adaptive quadrature, or for tables a million midpoints in angle."""

    def per_angle(angle: np.ndarray | float) -> np.ndarray:
        return beams.intensity_per_sr(np.cos(angle), beam) * 2 * np.pi * np.sin(angle)

    if beam.kind == "tabulated":
        step = np.pi / 1_000_000
        return float(np.sum(per_angle((np.arange(1_000_000) + 0.5) * step)) * step)
    edge = beams.edge_half_angle_rad(beam)
    return float(quad(per_angle, 0, edge)[0] + quad(per_angle, edge, np.pi)[0])


@pytest.mark.parametrize("name", BEAMS)
def test_a_beam_holds_all_of_the_flux(name: str) -> None:
    # tables: the jump at the end is spread over one cell of the look-up, at most 2e-4 of the flux
    assert energy(BEAMS[name]) == pytest.approx(1.0, rel=3e-4 if name == "table, ends lit" else 1e-6)


@pytest.mark.parametrize("name", BEAMS)
def test_nothing_shines_behind_the_front_plane_and_the_peak_is_a_bound(name: str) -> None:
    beam = BEAMS[name]
    assert np.all(beams.intensity_per_sr(np.array([0.0, -1e-12, -0.5, -1.0]), beam) == 0)
    edge = np.cos(beams.edge_half_angle_rad(beam))
    cos = np.r_[np.linspace(-1, 1, 20_001), edge, np.nextafter(edge, 2), 1 - np.geomspace(1e-16, 1, 999)]
    intensity = beams.intensity_per_sr(cos, beam)
    peak = beams.peak_intensity_per_sr(beam)
    assert np.all(np.isfinite(intensity))
    assert 0.999 * peak < intensity.max() <= peak


def test_disc_lights_a_plane_evenly() -> None:
    # E = Phi / (pi d^2 tan^2 b): 1 lm at 2 m within 45 deg is 1 / (4 pi) lx
    x = np.array([0.0, 0.7, 1.9])
    lux, _, _ = lamp_light(x, np.zeros(3), lamps=DOWNWARD, index=0, beam=BEAMS["disc 45"], range_m=2.0)
    assert lux == pytest.approx(np.full(3, 1 / (4 * np.pi)), rel=1e-14)  # rounding


def test_cone_is_even_over_its_solid_angle_and_dark_outside() -> None:
    # 60 deg half-angle: 2 pi (1 - 1/2) = pi sr
    beam = beams.cone_beam(np.pi / 3)
    assert beams.intensity_per_sr([1.0, 0.51, 0.49], beam) == pytest.approx(
        [1 / np.pi, 1 / np.pi, 0], rel=1e-14
    )


def test_lambertian_lamp_is_the_cosine_power_beam_of_120_degrees() -> None:
    # cos 60 deg = 1/2, so m = 1 and I = cos(t) / pi
    beam = BEAMS["cosine-power 120"]
    assert beam.exponent == pytest.approx(1.0, rel=1e-14)
    assert beams.intensity_per_sr([1.0, 0.3], beam) == pytest.approx([1 / np.pi, 0.3 / np.pi], rel=1e-14)


@given(st.floats(0.01, 179))
def test_cosine_power_has_half_its_peak_at_half_the_full_angle(full_deg: float) -> None:
    beam = beams.cosine_power_beam(np.deg2rad(full_deg))
    axis, half = beams.intensity_per_sr(np.cos(np.deg2rad([0.0, full_deg / 2])), beam)
    # the cosine of 0.005 deg keeps 8 digits of its distance from 1
    assert half / axis == pytest.approx(0.5, rel=1e-6)


@pytest.mark.parametrize("build", [beams.disc_beam, beams.cone_beam, beams.cosine_power_beam])
@pytest.mark.parametrize("angle_rad", [0.0, -0.1, 3.2, np.nan])
def test_impossible_angles_are_refused(build: object, angle_rad: float) -> None:
    with pytest.raises(RangeError, match="allowed"):
        build(angle_rad)  # type: ignore[operator]


def test_dspl_flood_integrates_to_the_published_flux() -> None:
    # 5680 cd at the peak: about 7030 lm of a nameplate 10 000 lm, digitised profile
    beam = flood(total_flux_lm=10_000.0)
    assert 10_000 * energy(beam) == pytest.approx(7030, rel=3e-3)  # "about", to the third digit
    assert 10_000 * beams.peak_intensity_per_sr(beam) == pytest.approx(5680, rel=1e-9)  # bound's slack


def test_dspl_spot_integrates_to_the_published_flux() -> None:
    beam = beams.tabulated_beam(
        SEALITE_RAD, SPOT_PEAK_CD * SEALITE.spot_rel, medium="water", n_w=N_W, total_flux_lm=10_000.0
    )
    assert 10_000 * energy(beam) == pytest.approx(4684, rel=1e-2)  # thinned noise floor beyond 50 deg


def test_relative_profile_has_the_flux_of_its_lamp() -> None:
    # 5680 cd / 7030 lm on the brightest ring, whatever the unit of the profile
    assert beams.peak_intensity_per_sr(flood()) == pytest.approx(5680 / 7030, rel=3e-3)  # as above


def test_look_up_follows_a_monotone_cubic_through_the_profile() -> None:
    beam = flood(total_flux_lm=FLOOD_PEAK_CD)
    scipys = PchipInterpolator(SEALITE_RAD, SEALITE.flood_rel.to_numpy())
    angle = np.linspace(0, np.deg2rad(89.9), 50_001)
    # promised by the docstring: 1e-4 of the peak
    assert beams.intensity_per_sr(np.cos(angle), beam) == pytest.approx(scipys(angle), abs=1e-4)


@example([5e3, 1e-310, 0.0, 0.0])
@settings(max_examples=30)
@given(st.lists(st.floats(0, 1e4), min_size=2, max_size=12).filter(lambda v: max(v) > 1))
def test_any_profile_can_be_normalised_and_bounded(values: list[float]) -> None:
    angle = np.linspace(0, np.pi, len(values) + 1)[:-1]
    if max(values[: max(1, int(np.sum(angle < np.pi / 2)))]) <= 1:
        return  # all light goes backwards
    beam = beams.tabulated_beam(angle, values, medium="water", n_w=N_W)
    cos = np.linspace(-1, 1, 4001)
    intensity = beams.intensity_per_sr(cos, beam)
    assert intensity.min() >= 0
    assert intensity.max() <= beams.peak_intensity_per_sr(beam)
    assert hash(beam) == hash(beams.tabulated_beam(angle, values, medium="water", n_w=N_W))


def test_a_lambertian_lamp_in_air_stays_even_in_radiance_in_water() -> None:
    # I_a = cos(a)/pi: I_w = n^2 cos(w)/pi inside the critical angle, nothing outside; flux stays 1
    angle = np.deg2rad(np.arange(0, 90.5, 0.5))
    beam = beams.tabulated_beam(angle, np.cos(angle) / np.pi, medium="air", n_w=N_W, total_flux_lm=1.0)
    critical = np.arcsin(1 / N_W)
    inside = np.linspace(0, critical - 0.001, 500)
    expected = N_W**2 * np.cos(inside) / np.pi
    # the cubic between entries 0.5 deg apart, and its slope near 90 deg
    assert beams.intensity_per_sr(np.cos(inside), beam) == pytest.approx(expected, rel=1e-4)
    assert beams.intensity_per_sr(np.cos(critical + 0.001), beam) == 0
    assert beams.edge_half_angle_rad(beam) == pytest.approx(critical, abs=1e-9)  # where arcsin flattens
    assert beams.has_sharp_edge(beam)


def test_bending_into_water_keeps_the_flux_of_a_measured_profile() -> None:
    in_air, in_water = energy(flood("water", total_flux_lm=1e4)), energy(flood("air", total_flux_lm=1e4))
    # the digitiser's floor beyond 80 deg is cut and the bent table is interpolated anew
    assert in_water == pytest.approx(in_air, rel=2e-3)


def test_a_bent_profile_is_narrower_and_brighter_by_n_squared_on_the_axis() -> None:
    ratio = beams.intensity_per_sr(1.0, flood("air", 1.0)) / beams.intensity_per_sr(1.0, flood("water", 1.0))
    assert ratio == pytest.approx(N_W**2, rel=1e-12)  # both cosines are 1


@given(angle_rad=st.floats(0, np.pi / 2), n_w=st.floats(1.0, 1.4))
def test_snell_for_beam_angles(angle_rad: float, n_w: float) -> None:
    water = beams.half_angle_in_water_rad(angle_rad, n_w=n_w)
    assert n_w * np.sin(water) == pytest.approx(np.sin(angle_rad), abs=1e-15)  # rounding
    assert beams.half_angle_in_water_rad(2.0, n_w=n_w) == pytest.approx(np.arcsin(1 / n_w))


@pytest.mark.parametrize(
    ("angle_deg", "values", "what"),
    [
        ([0, 10], [1], "as many"),
        ([0], [1], "two or more"),
        ([0, 0], [1, 1], "increase"),
        ([0, 190], [1, 1], "0-180"),
        ([95, 120], [1, 1], "before 90"),
        ([0, 10], [1, -1], "negative"),
        ([0, 10], [1, np.nan], "finite"),
        ([0, 10], [0, 0], "no light"),
    ],
)
def test_a_bad_profile_is_refused(angle_deg: list[float], values: list[float], what: str) -> None:
    with pytest.raises(RangeError, match=what):
        beams.tabulated_beam(np.deg2rad(angle_deg), values, medium="water", n_w=N_W)


def test_sharp_edges_are_known() -> None:
    sharp = {name for name, beam in BEAMS.items() if beams.has_sharp_edge(beam)}
    assert sharp == {"disc 45", "disc 5", "cone 30", "cone 90", "table, ends lit"}
    assert beams.edge_half_angle_rad(BEAMS["table, ends lit"]) == pytest.approx(np.pi / 3)


@pytest.mark.parametrize("name", BEAMS)
def test_without_its_edge_a_beam_is_the_same_inside_and_finite_outside(name: str) -> None:
    beam = BEAMS[name]
    smooth = beams.without_edge(beam)
    edge = beams.edge_half_angle_rad(beam)
    inside = np.cos(np.linspace(0, edge * 0.999, 500))
    assert beams.intensity_per_sr(inside, smooth) == pytest.approx(beams.intensity_per_sr(inside, beam))
    everywhere = beams.intensity_per_sr(np.linspace(-1, 1, 4001), smooth)
    assert np.all(everywhere <= beams.peak_intensity_per_sr(smooth))
    assert not beams.has_sharp_edge(smooth)
    if beams.has_sharp_edge(beam) and edge < 1.5:
        across = beams.intensity_per_sr(np.cos([edge * 0.999, edge * 1.001]), smooth)
        assert across[1] == pytest.approx(across[0], rel=0.02)  # no jump


def test_rays_by_hand() -> None:
    # lamp at (0, 3, 0), floor 4 m below it, point below the camera: 3-4-5 triangle
    range_m, cos_beam, cos_incidence = beams.lamp_rays(
        0.0, 0.0, lamp_x_m=0.0, lamp_y_m=3.0, lamp_height_m=4.0, aim_x=0.0, aim_y=-0.6, aim_z=0.8
    )
    assert (range_m, cos_beam, cos_incidence) == pytest.approx((5.0, 1.0, 0.8))


def test_positive_tilts_turn_outward_on_either_side() -> None:
    x, y, z = beams.lamp_aim(0.0, np.deg2rad(45), lamp_x_m=0.0, lamp_y_m=np.array([-0.5, 0.0, 0.5]))
    root = 1 / np.sqrt(2)
    assert np.array([x, y, z]) == pytest.approx(np.array([[0, 0, 0], [-root, root, root], [root] * 3]))


@given(
    tilts=st.tuples(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2)),
    place=st.tuples(st.floats(-3, 3), st.floats(-3, 3)),
)
def test_aim_is_a_unit_vector_down_with_the_given_projected_angles(
    tilts: tuple[float, float], place: tuple[float, float]
) -> None:
    aim = [float(a) for a in beams.lamp_aim(*tilts, lamp_x_m=place[0], lamp_y_m=place[1])]
    assert np.hypot(np.hypot(aim[0], aim[1]), aim[2]) == pytest.approx(1.0, rel=1e-14)  # rounding
    assert aim[2] > 0
    for along, tilt, at in zip(aim, tilts, place, strict=False):
        outward = along if at >= 0 else -along
        assert np.arctan2(outward, aim[2]) == pytest.approx(tilt, abs=1e-14)


def test_all_light_of_a_downward_lamp_reaches_a_large_floor() -> None:
    # flux through the plane = integral of E; cone of 50 deg within a 10 m disc, by quadrature in the radius
    beam = beams.cone_beam(np.deg2rad(50))

    def ring(radius_m: float) -> float:
        at = np.array(radius_m)
        lux, _, _ = lamp_light(at, np.zeros(()), lamps=DOWNWARD, index=0, beam=beam, range_m=2.0)
        return float(lux) * 2 * np.pi * radius_m

    edge_m = 2 * np.tan(np.deg2rad(50))
    assert quad(ring, 0, edge_m * (1 - 1e-12))[0] == pytest.approx(1.0, rel=1e-9)  # adaptive quadrature
    assert ring(edge_m * 1.001) == 0

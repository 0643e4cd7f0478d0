"""The built-in catalogue as records: nothing the model needs is missing, estimates carry range and basis."""

import math
from dataclasses import fields

import pytest

from uwopt.catalog.load import build_rows, read_catalog
from uwopt.catalog.parts.quantity import Quantity
from uwopt.catalog.records import KINDS, Camera, exact
from uwopt.catalog.tables import DATA_DIR, built_in_rows, parse_table
from uwopt.catalog.userparts import typed_rows
from uwopt.documents.faults import plain_name
from uwopt.errors import CatalogError

CATALOG = read_catalog()
EVERY_PART = [part for kind in KINDS for part in CATALOG.parts(kind)]
SEARCHABLE = [part for part in EVERY_PART if not CATALOG.exclusions_of(part.id)]

NEEDED = {
    "camera": (
        "bandwidth_mb_s max_frame_rate_hz read_noise_e saturation_e dark_current_e_s max_gain_db "
        "min_exposure_us max_exposure_us power_w mass_g price qe_scale"
    ),
    "lens": "f_number_min f_number_max image_circle_mm transmission_frac min_object_distance_m mass_g price",
    "port": "thickness_mm mass_g price",
    "light": "output_factor beam_angle_deg mass_g price",
    "housing": "inner_diameter_mm inner_length_mm outer_diameter_mm outer_length_mm depth_rating_m mass_g price",
    "complete": "depth_rating_m outer_diameter_mm outer_length_mm displaced_g mass_g price",
}


@pytest.mark.parametrize("kind", KINDS)
def test_every_searchable_part_has_what_the_model_needs(kind):
    missing = [
        (part.id, name)
        for part in CATALOG.parts(kind)
        if not CATALOG.exclusions_of(part.id)
        for name in NEEDED[kind].split()
        if getattr(part, name) is None
    ]
    assert missing == []


def test_lights_have_what_their_kind_needs():
    needed = {
        "continuous": ("flux_lm", "power_w"),
        "pulsed_led": ("flux_lm", "power_w", "min_pulse_us", "max_pulse_us", "max_duty_frac"),
        "flash": ("flash_energy_j", "flash_efficacy_lm_s_per_j", "flash_duration_us", "recycle_s"),
    }
    lights = [light for light in CATALOG.lights if light in SEARCHABLE]
    assert [(x.id, name) for x in lights for name in needed[x.kind] if getattr(x, name) is None] == []


def test_every_range_holds_its_value_and_every_estimate_its_basis():
    for part in EVERY_PART:
        for f in fields(part):
            value = getattr(part, f.name)
            if isinstance(value, Quantity):
                assert value.low <= value.value <= value.high, (part.id, f.name)
                assert value.source or not value.estimated, (part.id, f.name)


def test_domes_without_a_radius_are_not_searched():
    assert all(
        port.outer_radius_mm for port in CATALOG.ports if port in SEARCHABLE and port.geometry == "dome"
    )


def test_depth_ratings_radii_and_mounts_are_as_the_files_state_them():
    lumen = CATALOG.part("blue-robotics-lumen-current-product-page")
    assert lumen.depth_rating_m is None
    assert CATALOG.part("zwo-asi183mm").mounts == ()
    assert [e.rule for e in CATALOG.exclusions_of("zen-100-mm-dome-port")] == ["port mount"]


@pytest.mark.parametrize(
    ("cells", "low_mm", "high_mm"),
    [
        # a cap of 230 mm: from 230 / 2 to 3/4 230
        ({"mount": "nauticam-n120", "nominal_diameter_mm": "230"}, 115.0, 172.5),
        # a hemisphere on a 4 in tube: half of 101.6 mm as the high end, 44.8 mm where a CAD file was read
        ({"mount": "blue-robotics-4-in", "nominal_diameter_mm": "101.6"}, 44.7, 50.8),
        # a dome of which nothing but its size is known: any of both
        ({"nominal_diameter_mm": "100"}, 44.0, 75.0),
        # ends that a source allows beat the class
        ({"nominal_diameter_mm": "100", "outer_radius_low_mm": "60", "outer_radius_high_mm": "62"}, 60.0, 62.0),
    ],
)
def test_an_unknown_radius_lies_between_ends_and_at_their_geometric_mean(cells, low_mm, high_mm):
    radius = port_of(geometry="dome", **cells).outer_radius_mm
    assert (radius.low, radius.high) == pytest.approx((low_mm, high_mm), rel=1e-3)
    assert radius.value == pytest.approx(math.sqrt(low_mm * high_mm), rel=2e-3)  # the table has three digits
    assert radius.status in ("estimated", "derived")


def test_a_stated_radius_is_no_estimate_and_a_dome_without_any_size_stays_out():
    assert port_of(geometry="dome", outer_radius_mm="60", nominal_diameter_mm="100").outer_radius_mm == exact(60.0)
    assert [p.id for p in CATALOG.ports if p.geometry == "dome" and p.outer_radius_mm is None] == [
        "deepsea-power-light-apex-seacam-dome-port"
    ]


def test_an_unknown_clear_diameter_is_eight_tenths_of_the_nominal_one():
    clear = port_of(geometry="flat", nominal_diameter_mm="100").clear_diameter_mm
    assert (clear.value, clear.low, clear.high) == pytest.approx((80.0, 70.0, 90.0))
    stated = port_of(geometry="flat", nominal_diameter_mm="100", clear_diameter_mm="60").clear_diameter_mm
    assert (stated.value, stated.low) == (60.0, 60.0)


def test_no_depth_rating_follows_from_a_size():
    assert port_of(geometry="dome", nominal_diameter_mm="100").depth_rating_m is None


def port_of(**cells):
    """The port of a published row with these cells."""
    row = {"id": "a-port", **cells}
    table = parse_table(",".join(row) + "\n" + ",".join(row.values()), "ports.csv")
    typed, faults = typed_rows(table, "port", DATA_DIR, built_in=True)
    assert faults == []
    ((_, built),) = build_rows(typed, "published")
    return built.part


def test_published_numbers_reach_the_record_unchanged():
    # FLIR EMVA page of the BFS-U3-51S5M: 2.44 e-, 10970 e-, QE 63.4 % at 525 nm
    camera = CATALOG.part("flir-bfs-u3-51s5m")
    assert (camera.read_noise_e.value, camera.read_noise_e.status) == (2.44, "published")
    assert camera.saturation_e.value == 10970.0
    assert (camera.price.value, camera.price.status) == (1304.0, "quoted")


def test_efficiency_curve_passes_through_the_published_point():
    # curve seed-imx250m has 0.729 at 525 nm (stated by those who gathered it): 0.634 / 0.729 = 0.870
    camera = CATALOG.part("flir-bfs-u3-51s5m")
    assert camera.qe_scale.value == pytest.approx(0.634 / 0.729, rel=3e-3)
    assert camera.qe_scale.status == "derived"


def test_papers_sensor_keeps_its_own_curve():
    camera = CATALOG.part("seed_imx250m")
    assert (camera.qe_curve_id, camera.qe_scale.value) == ("seed-imx250m", 1.0)
    assert camera.exposure_offset_us.value == 13.73


def test_colour_camera_has_three_channels():
    assert set(CATALOG.part("flir-bfs-u3-51s5c").qe_curves) == {"red", "green", "blue"}


def test_saturation_follows_from_the_best_signal_to_noise_ratio():
    # Matrix Vision mvBlueFOX3-2051G: SNRmax 40.3 dB; 10**4.03 = 10715 e- (EMVA 1288)
    saturation = CATALOG.part("mv-bluefox3-2051g").saturation_e
    assert saturation.value == pytest.approx(10715.0, abs=1.0)
    assert saturation.status == "derived"


def test_unknown_sensor_figures_come_from_the_chip():
    # DALSA M2450 (IMX250) states no read noise; the five IMX250 rows span 2.1 to 2.45 e-, median 2.38
    noise = CATALOG.part("dalsa-genie-nano-m2450").read_noise_e
    assert (noise.low, noise.value, noise.high, noise.status) == (2.1, 2.38, 2.45, "estimated")
    assert "camera-read-noise-e-chip-imx250" in noise.source


def test_unknown_frame_rate_is_what_the_interface_carries():
    # BFS-PGE-51S5M: GigE 115 MB/s over 2448 x 2048 px of 12 bit: 115e6 / 7 520 256 byte = 15.292 Hz
    rate = CATALOG.part("flir-bfs-pge-51s5m").max_frame_rate_hz
    assert rate.value == pytest.approx(15.292, abs=1e-3)
    assert rate.estimated


def test_camera_price_follows_the_megapixel_fit_without_a_quote_for_the_chip():
    # IMX546, 2840 x 2840 = 8.0656 MP: 438 * 8.0656**0.38 = 438 * 2.2104 = 968.2 USD; ends 311 and 613
    price = CATALOG.part("basler-a2a2840-48umbas").price
    assert price.value == pytest.approx(968.2, abs=0.5)
    assert price.low == pytest.approx(311 * 2.2104, abs=0.5)
    assert price.estimated


def test_image_circle_follows_from_the_format():
    lens = CATALOG.part("fujinon-hf35xa-5m")
    assert (lens.image_circle_mm, lens.image_circle_status) == (11.0, "derived")


def test_lens_price_class_depends_on_circle_and_rating():
    # CF8ZA: 1.1 in (17.6 mm), 23 MP -> class of the 24 MP 1.1 in lens, 966 EUR
    lens = CATALOG.part("fujinon-cf8za-1s")
    assert (lens.price.value, lens.currency) == (966.0, "EUR")


def test_lamp_power_follows_from_its_flux():
    # Sola Video Pro 8000: 8000 lm at 100 lm/W (34 to 140): 80 W (57.1 to 235.3)
    power = CATALOG.part("light-motion-sola-video-pro-8000").power_w
    assert (power.low, power.value, power.high) == pytest.approx((57.14, 80.0, 235.29), abs=0.01)


def test_pulsed_lamp_power_while_on_follows_from_its_flux():
    # 30 000 lm at 42 (19 to 94) lm/W: 714 W (319 to 1579); the published 16 W is a mean over pauses
    power = CATALOG.part("arctic-rays-dragonfish-mini-strobe").power_w
    assert (power.low, power.value, power.high) == pytest.approx((319.1, 714.3, 1578.9), abs=0.1)


def test_nameplate_lumens_are_derated_and_measured_ones_are_not():
    assert CATALOG.part("blue-robotics-lumen-r2").output_factor.value == 0.7
    measured = CATALOG.part("deepsea-power-light-led-sealite-lsl-flood")
    assert (measured.output_factor.value, measured.output_factor.status) == (0.703, "measured")
    assert len(measured.beam_profile.x) == 109


def test_flash_energy_follows_from_the_guide_number():
    # MF-1: GN 16; 2.15 * 256 = 550.4 cd s. 90 deg lobe: m = ln 0.5 / ln cos 45 = 2,
    # peak 3 / (2 pi) = 0.47746 cd/lm;
    # 550.4 / 0.47746 = 1152.8 lm s; at 35 lm s/J: 32.94 J
    flash = CATALOG.part("backscatter-mini-flash-mf-1")
    assert flash.flash_energy_j.value == pytest.approx(32.94, abs=0.01)
    assert flash.flash_energy_j.estimated
    assert flash.dim_levels == (1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125)  # six levels, sizes not published
    assert flash.dim_status == "estimated"


def test_lamp_without_word_of_dimming_burns_at_full_only():
    assert CATALOG.part("bigblue-vl5500p").dim_levels == (1.0,)
    assert CATALOG.part("blue-robotics-lumen-r2").dim_levels is None


def test_flash_without_any_measure_of_light_is_not_searched():
    assert "guide number" in CATALOG.exclusions_of("ikelite-ds160")[0].reason


def test_thickness_of_a_flat_window_follows_its_class():
    # 4 in acrylic cap: 0.146 * 101.6 mm = 14.83 mm
    port = CATALOG.part("blue-robotics-4-in-acrylic-end-cap-2026")
    assert port.thickness_mm.value == pytest.approx(14.83, abs=0.01)
    assert port.thickness_mm.estimated
    assert (port.glass, port.refractive_index) == ("pmma", None)


def test_mass_of_a_dome_is_that_of_its_wall():
    # 85 mm acrylic hemisphere, wall 0.05 R = 2.125 mm:
    # 2/3 pi (42.5**3 - 40.375**3) = 22 929 mm3 * 1.19e-3 = 27.3 g
    port = CATALOG.part("tap-plastics-acrylic-hemisphere-85-mm")
    assert port.mass_g.value == pytest.approx(27.3, abs=0.1)


def test_generic_parts_are_marked_and_span_a_range():
    generic = [part for part in EVERY_PART if part.generic]
    assert {part.id for part in generic} == {part.id for part in EVERY_PART if part.id.startswith("generic-")}
    assert all(part.price.status == "generic" and part.price.low < part.price.high for part in generic)
    assert all(part.mass_g.low < part.mass_g.high for part in generic)


def test_generic_flood_has_a_hundred_lumens_per_watt_all_of_which_leave_it():
    lamp = CATALOG.part("generic-lamp-flood-5000lm")
    assert (lamp.flux_lm.value, lamp.power_w.value, lamp.output_factor.value) == (5000.0, 50.0, 1.0)
    assert (lamp.beam_angle_deg.value, lamp.beam_medium, lamp.dim_levels) == (90.0, "water", None)


def test_ids_are_unique_in_any_spelling():
    keys = [plain_name(part.id) for part in EVERY_PART]
    assert len(keys) == len(set(keys))


def test_part_is_found_in_any_spelling_and_a_wrong_id_names_near_ones():
    assert CATALOG.part("FLIR_BFS-U3-51S5M").id == "flir-bfs-u3-51s5m"
    with pytest.raises(CatalogError, match="flir-bfs-u3-51s5m"):
        CATALOG.part("flir-bfs-u3-51s5")
    with pytest.raises(CatalogError, match="is a camera, not a lens"):
        CATALOG.part("flir-bfs-u3-51s5m", "lens")


def test_catalogue_is_read_once():
    assert read_catalog() is CATALOG


@pytest.mark.parametrize(
    ("camera", "noise_e", "saturation_e", "qe_share"),
    [  # value, low, high by hand from cameras.csv and class_estimates.csv, of chip or else family
        ("avt-alvium-1800-c-507m", (2.1, 2.0, 3.0), (10400.0, 10400.0, 10820.0), (0.6251 / 0.64, 0.68 / 0.64)),
        ("avt-alvium-1800-c-240m", (2.1, 2.04, 3.06), (10400.0, 10400.0, 11120.0), (0.60 / 0.64, 1.0)),
    ],
)
def test_figures_of_a_pixel_family_are_estimates_of_a_model(
    camera: str, noise_e: tuple[float, ...], saturation_e: tuple[float, ...], qe_share: tuple[float, float]
) -> None:
    part = read_catalog().part(camera)
    assert isinstance(part, Camera)
    for quantity, ends in ((part.read_noise_e, noise_e), (part.saturation_e, saturation_e)):
        assert quantity is not None
        assert (quantity.value, quantity.low, quantity.high) == pytest.approx(ends)
        assert quantity.estimated and "not of this model" in quantity.source
    scale = part.qe_scale
    assert scale is not None and scale.estimated
    assert (scale.low / scale.value, scale.high / scale.value) == pytest.approx(qe_share)


def test_every_note_of_a_family_s_figures_is_graded_so() -> None:
    rows = [row for row in built_in_rows("cameras.csv") if "family, not of this model" in row["note"]]
    assert len(rows) == 11  # counted by hand
    assert {row["perf_quality"] for row in rows} == {"E"}


@pytest.mark.parametrize(
    ("camera", "noise_e"),
    [("basler-aca2000-165uc", 13.0), ("basler-aca2040-90uc", 13.0), ("basler-aca2500-60uc", 9.6)],
)
def test_a_chip_without_figures_is_not_taken_for_as_quiet_as_the_median_of_others(camera: str, noise_e: float) -> None:
    # 2.39 e-, of rows that are mostly of one maker's 3.45 um pixel, made the older, larger pixels win orders
    part = read_catalog().part(camera)
    assert isinstance(part, Camera) and part.read_noise_e is not None
    assert part.read_noise_e.estimated and part.read_noise_e.value == noise_e


@pytest.mark.parametrize("camera", ["basler-aca2000-165uc", "basler-aca2040-90uc"])
def test_dark_current_of_an_older_chip_is_its_maker_s(camera: str) -> None:
    # 1 e-/s, as of a cool chip of today, stood in for the 125 e-/s of the CMV4000's data sheet
    part = read_catalog().part(camera)
    assert isinstance(part, Camera) and part.dark_current_e_s is not None
    assert part.dark_current_e_s.estimated and part.dark_current_e_s.value == 125.0

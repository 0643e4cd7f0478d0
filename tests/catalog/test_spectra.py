"""Spectra, waters and glasses against the printed sources."""

import numpy as np
import pytest

from uwopt.catalog.curves import spectra
from uwopt.errors import CatalogError


def at(spectrum, wavelength_nm):
    return float(np.interp(wavelength_nm, spectrum.wavelength_nm, spectrum.value))


def test_photopic_curve_peaks_at_555_nm_with_the_cie_sum():
    # CIE 018: V(555 nm) = 1; sum over 360-830 nm in 1 nm steps 106.857
    curve = spectra.photopic()
    assert at(curve, 555.0) == pytest.approx(1.0)
    assert curve.value.sum() == pytest.approx(106.857, abs=1e-3)


def test_planck_ratio_matches_hand_calculation():
    # x = 1.438776877e7 / (lambda T), T = 2856 K: x(500) = 10.07547, x(700) = 7.19676
    # (700/500)**5 (exp(7.19676) - 1) / (exp(10.07547) - 1) = 5.37824 * 1334.1 / 23752 = 0.30208
    curve = spectra.light_spectrum("planck-2856")
    assert at(curve, 500.0) / at(curve, 700.0) == pytest.approx(0.30208, rel=2e-4)


def test_illuminant_a_is_a_planck_radiator_of_2856_kelvin():
    # CIE 015: illuminant A is that radiator; 1e-3 covers the rounding of the 5 nm table
    table, planck = spectra.light_spectrum("A"), spectra.light_spectrum("planck-2856")
    for wavelength_nm in (400.0, 500.0, 650.0, 780.0):
        expected = at(planck, wavelength_nm) / at(planck, 560.0)
        assert at(table, wavelength_nm) / at(table, 560.0) == pytest.approx(expected, rel=1e-3)


def test_generic_led_is_the_sum_of_two_normal_densities():
    # 24.49 / (11.67 sqrt(2 pi)) at 451 nm, where the phosphor adds 119.86 N(451; 565.43, 64.63):
    # 0.83722 * exp(-0.5 (0.3/11.67)**2) + 0.73987 * exp(-0.5 (114.43/64.63)**2)
    # = 0.83694 + 0.15432 = 0.99126
    assert at(spectra.light_spectrum("generic-led"), 451.0) == pytest.approx(0.99126, rel=1e-4)


def test_xenon_flash_says_that_it_is_a_proxy():
    assert "6000 K" in spectra.light_spectrum("xenon-flash").notes[0]


def test_names_of_spectra_ignore_case_and_dashes():
    assert spectra.light_spectrum("led_b3").name == "CIE LED-B3"


def test_unknown_spectrum_names_near_ones():
    with pytest.raises(CatalogError, match="CIE D65"):
        spectra.light_spectrum("CIE D56")


def test_flat_seafloors_are_those_of_the_papers_tool():
    values = {name: float(spectra.seafloor_reflectance(name).value[0]) for name in
              ("benthic-average", "sand", "hard", "coral", "organic")}  # fmt: skip
    assert values == {"benthic-average": 0.2, "sand": 0.35, "hard": 0.3, "coral": 0.15, "organic": 0.1}


def test_seafloor_may_be_a_number_or_a_measured_type():
    assert spectra.seafloor_reflectance(0.25).value.tolist() == [0.25, 0.25]
    assert spectra.seafloor_reflectance("sand_coralreef_asu").value[0] == pytest.approx(0.14803)


@pytest.mark.parametrize("floor", [1.2, -0.1, "mud"])
def test_impossible_seafloor_is_refused(floor):
    with pytest.raises(CatalogError):
        spectra.seafloor_reflectance(floor)


def test_user_spectrum_of_the_seafloor(tmp_path):
    (tmp_path / "floor.csv").write_text("# mine\nwavelength_nm,reflectance\n400,0.1\n550,0.2\n700,0.3\n")
    floor = spectra.seafloor_reflectance("floor.csv", tmp_path)
    assert at(floor, 475.0) == pytest.approx(0.15)


def test_water_type_three_differs_between_the_tables_as_published():
    # c(525 nm) of III: 1.06 + 0.0507 (Solonenko, Mobley 2015), 0.292 + 0.0821 (Williamson, Hollins 2022)
    def c_525(table):
        profile = spectra.water_profile("III", table)
        return np.interp(525.0, profile.wavelength_nm, profile.attenuation_per_m)

    assert c_525("solonenko-mobley") == pytest.approx(1.11, abs=0.005)
    assert c_525("measured") == pytest.approx(0.37, abs=0.005)


def test_measured_table_is_the_default_where_it_covers_the_type():
    assert spectra.water_profile("II").table == "measured"
    assert spectra.water_profile("9C").table == "solonenko-mobley"
    with pytest.raises(CatalogError, match="solonenko-mobley"):
        spectra.water_profile("9C", "measured")


def test_diffuse_attenuation_is_jerlovs_in_both_tables():
    # Jerlov (1968), type III at 550 nm: 0.145 per metre (the paper's tool has a slip there)
    for table in ("solonenko-mobley", "measured"):
        profile = spectra.water_profile("III", table)
        assert np.interp(550.0, profile.kd_wavelength_nm, profile.kd_per_m) == pytest.approx(0.145)


def test_replaced_rows_of_the_table_are_told():
    notes = " ".join(spectra.water_profile("5C", "solonenko-mobley").notes)
    assert "a_per_m substituted at 600, 625, 650, 675, 700 nm" in notes or "a substituted at 600" in notes


def test_custom_water_needs_attenuation_or_its_parts(tmp_path):
    (tmp_path / "bay.csv").write_text("wavelength_nm,a_per_m,b_per_m\n400,0.1,0.2\n700,0.6,0.1\n")
    profile = spectra.water_profile("bay.csv", base_dir=tmp_path)
    assert profile.attenuation_per_m.tolist() == pytest.approx([0.3, 0.7])
    assert profile.kd_per_m is None
    (tmp_path / "half.csv").write_text("wavelength_nm,a_per_m\n400,0.1\n700,0.6\n")
    with pytest.raises(CatalogError, match="attenuation_per_m"):
        spectra.water_profile("half.csv", base_dir=tmp_path)


def test_unknown_water_names_the_types():
    with pytest.raises(CatalogError, match="IB"):
        spectra.water_profile("IZ")


def test_bk7_coefficients_give_the_catalogue_index():
    # SCHOTT: n_d(587.56 nm) = 1.5168
    glass = spectra.glass_coefficients("N-BK7")
    assert glass.formula == "sellmeier_2"
    square_um2 = 0.58756**2
    c = glass.coefficients
    n_squared = 1 + c[0] + sum(c[i] * square_um2 / (square_um2 - c[i + 1]) for i in (1, 3, 5))
    assert np.sqrt(n_squared) == pytest.approx(1.51680, abs=1e-5)


def test_quan_fry_coefficients_are_in_order():
    # Quan and Fry (1995), Table 3: n0 = 1.31405, n9 = 1.1455e6
    n = spectra.quan_fry_coefficients()
    assert (n.size, n[0], n[9]) == (10, 1.31405, 1.1455e6)


def test_pure_water_absorbs_as_pope_and_fry_measured_in_the_red():
    # Pope and Fry (1997): a(650 nm) = 0.340 per metre
    water = spectra.pure_water()
    assert np.interp(650.0, water.wavelength_nm, water.a_per_m) == pytest.approx(0.340, abs=0.002)

"""Named phase functions against Petzold's printed figures, and users' files."""

import numpy as np
import pytest
from reference.physics import backscatter_ratio, mean_cosine, solid_angle_integral

from uwopt.catalog.curves import phase_functions
from uwopt.errors import CatalogError, RangeError
from uwopt.model import phase_formulas, scattering

# Petzold (1972), SIO Ref. 72-78: backscatter ratio B/S as printed for each station. Mean cosines: power-law
# integration of the printed functions, made for another table of this project.
PRINTED = {
    "autec-7": (0.025, 0.9154),
    "autec-8": (0.044, 0.8715),
    "autec-9": (0.038, 0.8854),
    "haoce-5": (0.014, 0.9471),
    "haoce-11": (0.013, 0.9470),
    "nuc-2200": (0.019, 0.9213),
    "nuc-2040": (0.020, 0.9198),
    "nuc-2240": (0.018, 0.9269),
}
# Petzold (1972), some printed lines: angle_deg, vsf_per_m_sr, and the printed b
HARBOUR_B_PER_M = 1.8243
HARBOUR_VSF = {0.1: 3262.0, 180.0: 0.0056857, 175.0: 0.0056177, 170.0: 0.0055497}


def petzold(station):
    return phase_functions.phase_function(f"petzold-{station}", backscatter_ratio=0.0183)


@pytest.mark.parametrize("station", PRINTED)
def test_stations_scatter_back_and_ahead_what_petzold_printed(station):
    # B/S is printed with two digits: half a unit in the third decimal
    back, ahead = PRINTED[station]
    function = petzold(station)
    assert backscatter_ratio(function.table) == pytest.approx(back, abs=5.1e-4)
    assert mean_cosine(function.table) == pytest.approx(ahead, abs=5e-4)
    assert solid_angle_integral(function.table) == pytest.approx(1.0, abs=1e-12)


def test_harbour_function_is_the_printed_one():
    # scaled to 1 from an integral 0.9990 of the printed b; at 0.1 deg the table's step adds 3e-4
    function = petzold("nuc-2040")
    for angle_deg, vsf_per_m_sr in HARBOUR_VSF.items():
        got = scattering.look_up(np.cos(np.radians(angle_deg)), function.table)
        assert got == pytest.approx(vsf_per_m_sr / HARBOUR_B_PER_M, rel=2e-3)


@pytest.mark.parametrize("station", PRINTED)
def test_look_up_meets_the_printed_values_to_2e_5_from_5_degrees_on(station):
    import jerlov

    measured = jerlov.petzold_scattering(station.upper().replace("-", " "))
    from_5 = measured.angles_deg >= 5
    cosine = np.cos(np.radians(measured.angles_deg[from_5]))
    ratio = scattering.look_up(cosine, petzold(station).table) / measured.phase_function()[from_5]
    np.testing.assert_allclose(ratio, np.median(ratio), rtol=2e-5)
    assert np.median(ratio) == pytest.approx(1.0, abs=2e-3)  # the scaling to 1


@pytest.mark.parametrize(
    ("alias", "station"),
    [
        ("clear-ocean", "autec-8"),
        ("petzold-coastal-ocean", "haoce-11"),
        ("Petzold turbid_harbour", "nuc-2040"),
    ],
)
def test_friendly_names_lead_to_the_usual_stations(alias, station):
    function = phase_functions.phase_function(alias, backscatter_ratio=0.0183)
    assert function is petzold(station)


def test_every_offered_name_is_known():
    names = phase_functions.phase_function_names()
    assert names[0] == "fournier-forand"
    assert len(names) == len(set(names)) == 2 + 3 + 8
    for name in names:
        phase_functions.phase_function(name, backscatter_ratio=0.0183)


def test_petzold_holds_the_water_and_formulas_do_not():
    assert petzold("autec-8").includes_water
    for name in ("fournier-forand", "henyey-greenstein"):
        assert not phase_functions.phase_function(name, backscatter_ratio=0.01).includes_water


@pytest.mark.parametrize("name", ["fournier-forand", "henyey-greenstein"])
@pytest.mark.parametrize("ratio", [0.002, 0.0183, 0.3])
def test_formulas_have_the_wanted_backscatter_ratio(name, ratio):
    function = phase_functions.phase_function(name, backscatter_ratio=ratio)
    assert backscatter_ratio(function.table) == pytest.approx(ratio, rel=1e-5)


def test_same_formula_is_made_once():
    first = phase_functions.phase_function(backscatter_ratio=0.015)
    assert phase_functions.phase_function("Fournier_Forand", backscatter_ratio=0.015) is first


def test_formula_without_that_ratio_says_what_is_allowed():
    with pytest.raises(CatalogError, match=r"fournier-forand.*0\.0001 to 0\.4"):
        phase_functions.phase_function("fournier-forand", backscatter_ratio=0.0)


def test_unknown_name_suggests_near_ones():
    with pytest.raises(CatalogError, match="did you mean petzold-autec-8"):
        phase_functions.phase_function("petzold-autec8", backscatter_ratio=0.0183)


# ---------------------------------------------------------------- users' files


def written(tmp_path, header, rows):
    lines = "\n".join(",".join(f"{cell}" for cell in row) for row in rows)
    (tmp_path / "mine.csv").write_text(f"# measured by me\n{header}\n{lines}\n")
    return phase_functions.phase_function("mine.csv", backscatter_ratio=0.0183, base_dir=tmp_path)


def henyey_greenstein_rows(factor=1.0):
    angles_deg = np.concatenate([[0.0], np.geomspace(0.5, 180.0, 80)])
    values = phase_formulas.henyey_greenstein_per_sr(np.cos(np.radians(angles_deg)), asymmetry=0.9)
    return [(f"{a:.6f}", f"{factor * v:.9g}") for a, v in zip(angles_deg, values, strict=True)]


def test_users_phase_function_is_taken_as_that_of_particles(tmp_path):
    function = written(tmp_path, "angle_deg,phase_per_sr", henyey_greenstein_rows())
    assert not function.includes_water
    # g = 0.9: b_b/b = (0.1/1.8) (1.9/sqrt(1.81) - 1) = 0.022904; 80 knots leave 1e-3
    assert backscatter_ratio(function.table) == pytest.approx(0.022904, rel=2e-3)


def test_users_volume_scattering_function_is_divided_by_its_integral(tmp_path):
    function = written(tmp_path, "angle_deg,vsf_per_m_sr", henyey_greenstein_rows(factor=0.37))
    assert function.includes_water
    assert solid_angle_integral(function.table) == pytest.approx(1.0, abs=1e-12)
    assert mean_cosine(function.table) == pytest.approx(0.9, abs=1e-3)


def test_phase_function_that_is_not_normalised_is_refused(tmp_path):
    with pytest.raises(CatalogError, match=r"mine\.csv.*12\.5.*0\.98 to 1\.02"):
        written(tmp_path, "angle_deg,phase_per_sr", henyey_greenstein_rows(factor=4 * np.pi))


def test_all_faults_of_a_file_come_in_one_message(tmp_path):
    rows = [(2, 1.0), (5, "0.5 1/sr"), (4, 0.3), (90, -1), ("", 0.1), (150, 0.2)]
    with pytest.raises(CatalogError) as raised:
        written(tmp_path, "angle_deg,vsf_per_m_sr", rows)
    text = str(raised.value)
    for part in (
        "row 4: vsf_per_m_sr = '0.5 1/sr' is not a number",
        "row 5: angle_deg = 4 does not increase",
        "row 6: vsf_per_m_sr = -1 must be a number above 0",
        "row 7: angle_deg is empty",
        "ends at 150 deg",
        "begins at 2 deg",
    ):
        assert part in text


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("angle_deg,phase", "'phase' is unknown"),
        ("angle_deg,phase_per_sr,vsf_per_m_sr", "needs angle_deg and one of"),
        ("wavelength_nm,phase_per_sr", "needs angle_deg"),
    ],
)
def test_wrong_columns_are_named(tmp_path, header, message):
    with pytest.raises(CatalogError, match=message):
        written(tmp_path, header, [(1, 1, 1), (2, 1, 1), (3, 1, 1), (180, 1, 1)])


def test_too_few_rows_are_refused(tmp_path):
    with pytest.raises(CatalogError, match="has 2 usable"):
        written(tmp_path, "angle_deg,phase_per_sr", [(1, 1), (180, 1)])


def test_missing_file_is_named(tmp_path):
    with pytest.raises(CatalogError, match="no such file"):
        phase_functions.phase_function("none.csv", backscatter_ratio=0.0183, base_dir=tmp_path)


# ---------------------------------------------------------------- water itself


def test_sea_water_scatters_a_little_less_than_morel_found():
    # Morel (1974), as Smith and Baker (1981) tabulate it: 0.0029 at 500 nm, 0.0019 at 550 nm (two digits).
    # Zhang, Hu and He (2009) with the lower depolarisation ratio 0.039: 10-13 % less.
    got = phase_functions.pure_water_scattering_per_m([500.0, 550.0])
    assert got / [0.0029, 0.0019] == pytest.approx([0.88, 0.88], abs=0.04)


def test_sea_water_scatters_as_a_power_of_wavelength():
    # Morel (1974): exponent -4.32; the other dispersion of Zhang, Hu and He (2009) makes it a little flatter
    b = phase_functions.pure_water_scattering_per_m([402.5, 697.5])
    assert np.log(b[1] / b[0]) / np.log(697.5 / 402.5) == pytest.approx(-4.32, abs=0.15)


def test_salt_adds_thirty_percent_to_the_scattering_of_water():
    # Morel (1974): sea water of 35-38 psu scatters 1.30 times as pure water
    sea, fresh = (phase_functions.pure_water_scattering_per_m(550.0, salinity_psu=s) for s in (35.0, 0.0))
    assert sea / fresh == pytest.approx(1.30, abs=0.01)


def test_water_outside_its_table_is_refused():
    with pytest.raises(RangeError, match="350-800 nm"):
        phase_functions.pure_water_scattering_per_m([340.0, 500.0])

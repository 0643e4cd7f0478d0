"""`uwopt.solve` at extreme numbers against a closed form in arbitrary precision: files in, certified power out.

One wavelength, a disc beam, physics `paper` and a vehicle at rest leave an optimum that a page of algebra gives: the
least electrons for the SNR (section 6), the lamp's level for those electrons, and the power of that level.
"""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import extreme_cases as cases
import mpmath as mp
import pytest
from thorough import drawn

import uwopt
from uwopt.mission.mission import load_mission

LAMP_LM, LAMP_W, CAMERA_W, TIME_S, F_NUMBER = 1e5, 800.0, 3.0, 0.1, 2.0
PITCH_M, QE, FLOOR, RANGE_M = 3.45e-6, 0.6, 0.2, 2.0
GREEN = ["wavelength_nm,relative_power", "380,0", "549.99,0", "550,1", "550.01,0", "780,0"]
WATERS = {"vacuum": (0.0, 0.0), "absorbs": (0.3, 0.0), "scatters": (0.0, 0.3), "both": (40.0, 60.0)}
mp.mp.dps = 40


def files(folder: Path, *, well_e: float, read_noise_e: float, water: str) -> dict[str, Any]:
    """A mission over one camera, lens, port and lamp of one's own."""
    cases.table(folder / "green.csv", GREEN)
    a, b = WATERS[water]
    head = "id,resolution_x_px,resolution_y_px,pixel_pitch_um,mounts,shutter,colour,bit_depth,read_noise_e," \
        "saturation_e,gain_dn_per_e,gain_bits,max_gain_db,dark_current_e_s,prnu_frac,black_level_dn,qe_curve," \
        "max_frame_rate_hz,min_exposure_us,max_exposure_us,exposure_offset_us,power_w,mass_g,price"  # fmt: skip
    gain = 4095.0 / well_e
    row = f"own-cam,1600,1200,3.45,C,global,mono,12,{read_noise_e},{well_e},{gain!r},12,0,0,0,0,qe.csv,30,1,1e6,0," \
        f"{CAMERA_W},60,900"  # fmt: skip
    cases.table(folder / "qe.csv", ["wavelength_nm,qe", f"380,{QE}", f"780,{QE}"])
    cases.table(folder / "cameras.csv", [head, row])
    cases.table(folder / "lenses.csv", [
        "id,focal_length_mm,f_number_min,f_number_max,aperture_control,image_circle_mm,mounts,transmission_frac,"
        "min_object_distance_m,mass_g,price", f"own-lens,8,{F_NUMBER},{F_NUMBER},fixed,16,C,0.9,0,80,300"])  # fmt: skip
    cases.table(folder / "ports.csv", [
        "id,geometry,outer_radius_mm,thickness_mm,refractive_index,depth_rating_m,mass_g,price",
        "own-port,dome,80,8,1.5,500,500,400"])  # fmt: skip
    cases.table(folder / "lights.csv", [
        "id,kind,flux_lm,power_w,output_factor,beam,beam_angle_deg,beam_medium,dim_levels,spectrum,depth_rating_m,"
        "mass_g,price",
        f"own-light,continuous,{LAMP_LM},{LAMP_W},1,disc,80,water,continuous,green.csv,500,700,500"])  # fmt: skip
    return {
        "practice": "bare", "physics": "paper", "objective": "power",
        "scene": {"water": cases.flat_water(folder, a_per_m=a, b_per_m=b), "seafloor": FLOOR, "depth_m": 50},
        "vehicle": {"altitude_m": RANGE_M, "speed_m_s": 0.0, "light_count": 1, "orientation": "landscape"},
        "requirements": {"frame_interval_s": 1.0}, "limits": {"max_exposure_ms": 1e3 * TIME_S},
        "catalog": {"files": ["cameras.csv", "lenses.csv", "ports.csv", "lights.csv"], "cameras": ["own-*"],
                    "lenses": ["own-*"], "ports": ["own-*"], "lights": ["own-*"], "generic": "never"},
    }  # fmt: skip


def least_level(snr: float, *, well_e: float, read_noise_e: float, water: str) -> Any:
    """The lamp's level for that SNR; None where well or lamp are too small."""
    gain = mp.mpf(4095.0 / well_e) * 16  # physics `paper` counts in 16 bit
    wanted, sigma2 = mp.mpf(snr) ** 2, mp.mpf(read_noise_e) ** 2 + 1 / (12 * gain**2)
    mu = (wanted + mp.sqrt(wanted**2 + 4 * wanted * sigma2)) / 2
    if mu * mp.mpf("1.5") > well_e:
        return None
    lux = mp.mpf(LAMP_LM) / (mp.pi * mp.mpf(RANGE_M) ** 2 * mp.tan(mp.radians(40)) ** 2)
    image = (
        lux / (mp.mpf("683.002") * mp.mpf("0.9949501")) * mp.exp(-2 * mp.mpf(sum(WATERS[water])) * RANGE_M)
    )
    image *= mp.mpf(FLOOR) / mp.pi * mp.pi / 4 * mp.mpf("0.9") / mp.mpf(F_NUMBER) ** 2
    photon_j = mp.mpf("6.62607015e-34") * 299792458 / mp.mpf("550e-9")
    level = mu / (image * mp.mpf(QE) * mp.mpf(PITCH_M) ** 2 * mp.mpf(TIME_S) / photon_j)
    return level if level <= 1 else None


SNRS = [0.1, 1.0, 7.0, 100.0, 2000.0, 1e4]


WELLS_E, NOISES_E = (1e2, 1e4, 1e7, 1e10), (0.0, 2.4)
#: Each SNR before two wells, each well without noise and with it: the ends of all three among them.
SOME = [
    (snr, WELLS_E[(i + 2 * k) % 4], NOISES_E[(i // 2 + k) % 2]) for i, snr in enumerate(SNRS) for k in range(2)
] + [(SNRS[-1], WELLS_E[-1], NOISES_E[0]), (SNRS[0], WELLS_E[0], NOISES_E[0])]


@drawn(pytest.mark.usefixtures("undoubted"), lambda test: test)  # doubts at extremes are told of waters, below
@pytest.mark.parametrize(
    ("snr", "well_e", "read_noise_e"),
    drawn(list(dict.fromkeys(SOME)), list(itertools.product(SNRS, WELLS_E, NOISES_E))),
)
def test_any_snr_behind_any_well(snr: float, well_e: float, read_noise_e: float, tmp_path: Path) -> None:
    """SNR 0.1 to 1e4, wells 1e2 to 1e10, read noise 0 too."""
    assert_solved(tmp_path, snr, well_e=well_e, read_noise_e=read_noise_e, water="absorbs")


@pytest.mark.parametrize("water", WATERS)
@pytest.mark.parametrize("snr", drawn([40.0], [1.0, 40.0]))
def test_waters_of_ones_own(snr: float, water: str, tmp_path: Path) -> None:
    """Nothing, pure absorption, pure scattering, and c r = 200, which lets no light through."""
    assert_solved(tmp_path, snr, well_e=1e4, read_noise_e=2.4, water=water)


def assert_solved(folder: Path, snr: float, **case: Any) -> None:
    """The certified power is that of the closed form; what cannot be is infeasible, with reasons."""
    mission = files(folder, **case)
    mission["requirements"]["min_snr"] = snr
    level = least_level(snr, **case)
    result = uwopt.solve(load_mission(mission, base_dir=folder))
    assert cases.not_finite(result.to_dict()) == []
    assert result.certificate is not None and result.certificate.adds_up()
    if level is None:
        assert result.status == "infeasible"
        assert result.infeasible is not None and result.infeasible["requirements"]
        return
    assert result.status == "optimal"
    figures = cases.assert_sound(result)
    # 1e-6: the shipped V has seven digits; the camera's 3 W are exact
    assert abs((mp.mpf(figures["light_power_w"]) / (LAMP_W * level)) - 1) < 2e-6
    assert result.objective["value"] == pytest.approx(CAMERA_W + float(LAMP_W * level), rel=2e-6)
    assert result.certificate.lower_bound == pytest.approx(result.objective["value"], rel=1e-9)

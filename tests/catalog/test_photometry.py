"""Reading IES LM-63 text."""

import numpy as np
import pytest

from uwopt.catalog.curves.photometry import parse_ies
from uwopt.errors import CatalogError
from uwopt.model.beam import intensity_per_sr, tabulated_beam

# Written by hand after the layout of LM-63-2002: two planes, multiplier 2, ballast factor 0.5.
IES = """IESNA:LM-63-2002
[TEST] made up
[MANUFAC] none
TILT=NONE
2 500 2.0 3 2 1 2 0.1 0.1 0
0.5 1.0 80
0 45 90
0 90
100 80 0
60, 40, 20
"""


def test_planes_are_averaged_and_scaled() -> None:
    # (100 + 60)/2 * 2 * 0.5 = 80; (80 + 40)/2 = 60; (0 + 20)/2 = 10; 2 lamps of 500 lm
    angle_deg, candela, lumens = parse_ies(IES)
    assert angle_deg == pytest.approx([0, 45, 90])
    assert candela == pytest.approx([80, 60, 10])
    assert lumens == 1000


def test_full_circle_counts_its_seam_once() -> None:
    # planes 0, 90, 180, 270, 360 with values 10, 20, 30, 20, 10 on the axis ring: mean of four is 20
    text = IES.replace(" 3 2 1 2 ", " 3 5 1 2 ").replace("\n0 90\n", "\n0 90 180 270 360\n")
    head = text[: text.index("100 80 0")]
    planes = "".join(f"{v} {v} 0\n" for v in (10, 20, 30, 20, 10))
    assert parse_ies(head + planes).candela == pytest.approx([20, 20, 0])


def test_one_plane_is_a_round_beam_and_absolute_photometry_rates_no_flux() -> None:
    text = IES.replace(" 3 2 1 2 ", " 3 1 1 1 ").replace("\n0 90\n", "\n0\n").replace("60, 40, 20\n", "")
    result = parse_ies("\ufeff" + text.replace("2 500", "1 -1"))
    assert result.candela == pytest.approx([100, 80, 0])
    assert result.lamp_lumens is None


def test_a_lambertian_file_makes_a_lambertian_beam() -> None:
    # I = 1000/pi cos: 1000 lm; in water as read, I/Phi on the axis is 1/pi
    angle = np.arange(0, 91, 1.0)
    rows = " ".join(f"{a:g}" for a in angle)
    values = "\n".join(f"{1000 / np.pi * max(0.0, np.cos(np.deg2rad(a))):.6f}" for a in angle)
    text = f"IESNA91\nTILT=NONE\n1 1000 1 {angle.size} 1 1 2 0 0 0\n1 1 10\n{rows}\n0\n{values}\n"
    angle_deg, candela, lumens = parse_ies(text)
    beam = tabulated_beam(np.deg2rad(angle_deg), candela, medium="water", n_w=1.34, total_flux_lm=lumens)
    assert intensity_per_sr(1.0, beam) == pytest.approx(1 / np.pi, rel=1e-8)  # six printed digits


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("TILT=NONE", "TILT=INCLUDE", "line 4: TILT=INCLUDE"),
        ("TILT=NONE", "", "no line begins with TILT="),
        (" 3 2 1 2 ", " 3 2 2 2 ", "line 5: photometric type 2"),
        (" 3 2 1 2 ", " 3 2 1 3 ", "line 5: units type 3"),
        (" 3 2 1 2 ", " 3.5 2 1 2 ", "line 5: number of vertical angles is 3.5"),
        (" 3 2 1 2 ", " 4 2 1 2 ", "line 10: 11 numbers"),
        ("60, 40, 20", "60, forty, 20", "line 10: 'forty'"),
        ("60, 40, 20", "60, nan, 20", "line 10: 'nan'"),
        ("60, 40, 20", "60, -40, 20", "line 10: intensity -40"),
        ("0 45 90", "0 90 45", "line 7: vertical angle 45"),
        ("0 45 90", "90 135 180", "line 7: vertical angles begin at 90"),
        ("\n0 90\n", "\n0 70\n", "line 8: horizontal angles 0-70"),
        ("0.5 1.0 80", "0 1.0 80", "line 6: ballast factor"),
        (IES[IES.index("2 500") :], "1 2 3", "header alone has 13"),
    ],
)
def test_faults_name_their_line(old: str, new: str, message: str) -> None:
    assert old in IES
    with pytest.raises(CatalogError) as caught:
        parse_ies(IES.replace(old, new))
    assert message in str(caught.value)


def test_all_faults_of_the_table_come_at_once() -> None:
    with pytest.raises(CatalogError) as caught:
        parse_ies(IES.replace("0 45 90", "0 90 45").replace("100 80 0", "100 -80 0"))
    assert len(caught.value.faults) == 2

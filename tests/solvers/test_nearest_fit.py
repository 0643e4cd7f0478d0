"""Which size stops the fit, and by how many millimetres, where no camera with its lens goes into any housing."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from test_least_change import FILES

from uwopt.api.solving import solve
from uwopt.report.text.layout import Grid, Text
from uwopt.report.text.nothing_fits import fit_sentence, no_change_helps, none_left_lines
from uwopt.results.basis import NearestFit
from uwopt.results.result import Result

# Camera 30 x 40 mm, 50 mm across the corner, 60 mm deep, 20 mm of plug; lens 50 mm long, pupil 20 mm behind its front.
# Needed: 50 + 2 * 2 = 54 mm across, and 50 - 20 + 60 + 20 behind the pupil + 20 before it + 2 = 132 mm of length.
SIZES = {
    "cameras": ("body_width_mm,body_height_mm,body_length_mm,plug_mm", "30,40,60,20"),
    "lenses": ("length_mm,diameter_mm,pupil_mm", "50,40,20"),
}
HOUSINGS = (
    "id,shape,inner_diameter_mm,inner_length_mm,outer_diameter_mm,outer_length_mm,depth_rating_m,ports,mass_g,price,"
    "currency\n"
    "zz-narrow,tube,{narrow},200,150,220,300,{ports},1000,400,USD\n"
    "zz-short,tube,60,120,140,140,300,{ports},1000,400,USD\n"
)


def sizes(fit: NearestFit) -> dict[str, tuple[float, float]]:
    """What is needed and what there is, by size."""
    return {one.name: (one.needed_mm, one.room_mm) for one in fit.lacking}


def said(told: Result) -> str:
    """The sentence about the fit."""
    text = fit_sentence(told)
    return "" if text is None else text.plain


def result(folder: Path, narrow: float = 50.0, ports: str = "zz-port", snr_db: float = 5.0) -> Result:
    """What is told of one camera with one lens, and of two housings for them."""
    for name in ("cameras", "lenses", "ports", "lights"):
        lines = FILES[name].splitlines()[:2]
        if name in SIZES:
            lines = [f"{line},{more}" for line, more in zip(lines, SIZES[name], strict=True)]
        (folder / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / "housings.csv").write_text(HOUSINGS.format(narrow=narrow, ports=ports), encoding="utf-8")
    mission = {
        "practice": "bare", "name": "no room", "physics": "paper",
        "scene": {"water": "II", "seafloor": "coral", "depth_m": 30.0},
        "vehicle": {
            "altitude_m": 2.0, "speed_m_s": 0.5, "orientation": "landscape", "light_baseline_m": 0.8, "light_count": 1,
        },
        "requirements": {"overlap": 0.6, "min_snr_db": snr_db},
        "catalog": {
            "files": [str(folder / f"{name}.csv") for name in (*SIZES, "ports", "lights", "housings")],
            "cameras": ["zz-*"], "lenses": ["zz-*"], "ports": ["zz-*"], "lights": ["zz-*"], "housings": ["zz-*"],
            "generic": "never", "housing": "required",
        },
    }  # fmt: skip
    return solve(mission, quick=True)


def test_the_size_that_stops_the_fit_is_named_with_what_is_missing(tmp_path: Path) -> None:
    told = result(tmp_path)
    assert told.status == "infeasible" and told.infeasible is not None
    fit = told.infeasible.nearest_fit
    assert fit is not None
    assert fit.hardware == {"camera": "zz-cam", "lens": "zz-lens", "port": "zz-port", "housing": "zz-narrow"}
    assert sizes(fit) == {"housing_diameter_mm": pytest.approx((54.0, 50.0))}
    assert said(told) == (
        "No camera with its lens that meets the rest so far fits into any housing. What comes nearest, zz-cam with "
        "zz-lens behind zz-port in zz-narrow, lacks 4.00 mm of inner diameter of the housing (54.00 mm needed, 50.00 "
        "mm there)."
    )


def test_the_housing_that_lacks_least_is_named(tmp_path: Path) -> None:
    told = result(tmp_path, narrow=40.0)  # 14 mm too narrow; the other is 132 - 120 = 12 mm too short
    fit = told.infeasible and told.infeasible.nearest_fit
    assert fit and fit.hardware["housing"] == "zz-short"
    assert sizes(fit) == {"housing_length_mm": pytest.approx((132.0, 120.0))}


def test_no_size_is_named_where_something_else_stops_it(tmp_path: Path) -> None:
    told = result(tmp_path, narrow=55.0, snr_db=90.0)  # it fits; no lamp is as bright
    assert told.infeasible is not None and told.infeasible.nearest_fit is None
    assert said(told) == ""


@pytest.mark.parametrize(
    ("ports", "told"),
    [
        ("any", "lacks 50.0 mm of diameter of the housing's end (200.0 mm needed, 150.0 mm there)."),
        ("acme-*", "None of the housings is made for any of the ports."),
    ],
    ids=["wide", "none"],
)
def test_ports_that_go_on_no_housing_are_told(tmp_path: Path, ports: str, told: str) -> None:
    assert said(result(tmp_path, ports=ports)).endswith(told)


def test_a_hull_that_lacks_a_size_is_named_with_what_it_lacks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of all that the mission allows none is left, which no requirement could mend."""
    unknown = HOUSINGS.replace("{narrow},200,150", "{narrow},,150").replace("tube,60,120,", "tube,60,,")
    monkeypatch.setattr(sys.modules[__name__], "HOUSINGS", unknown)
    told = result(tmp_path)
    assert told.infeasible is not None
    (none,) = told.infeasible.none_left
    assert none.kind == "housing" and set(none.reasons) == {"zz-narrow", "zz-short"}
    first, table, last = none_left_lines(told)
    assert isinstance(first, Text) and isinstance(table, Grid) and isinstance(last, Text)
    assert first.plain.startswith("No housing is left to choose of the ")
    assert last.plain.startswith("Named, but zz-narrow: length inside unknown; zz-short: ")
    assert no_change_helps(told) == "No requirement alone stands in the way"


def test_no_kind_is_said_to_be_lacking_where_some_are_left(tmp_path: Path) -> None:
    told = result(tmp_path)
    assert told.infeasible is not None and told.infeasible.none_left == []

"""Every mission and system in problems/ loads, names its source, and holds the numbers that were published.

The numbers below were copied by hand from a list of published rigs that was compiled from the named
sources, not from the files; a few (width, pixel, overlap) follow from published ones by arithmetic.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from uwopt.catalog.inline import part_from_inline
from uwopt.catalog.load import read_catalog
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.system import load_system

PROBLEMS = Path(__file__).parents[2] / "problems"
SYSTEMS = sorted(path.name for path in PROBLEMS.glob("*.system.yaml"))
MISSIONS = sorted(path.name for path in PROBLEMS.glob("*.yaml") if path.name not in SYSTEMS)
WITHOUT_SOURCE = "reef-mosaic.yaml"

SOURCES = {
    "paper-tool-window": "github.com/gidobot/UWOpticalSystemsDesignTools",
    "paper-tank": "arxiv.org/abs/2004.06763",
    "mbari-lass-2013": "ui.adsabs.harvard.edu/abs/2013AGUFMOS33A1756C",
    "mbari-lass-2021": "marine-geo.org/tools/files/31288",
    "nui-acfr": "doi.org/10.1594/PANGAEA.921370",
    "whoi-abe": "whoi.edu/page.do?pid=10818",
    "awi-ofobs": "b2find9.cloud.dkrz.de/dataset/73cbdae8-99f8-564a-8428-535dcbd34ea8",
    "biocam": "core.ac.uk/works/145157691",
    "whoi-towcam": "missionlog.noaa.gov/2010/09/29",
    "usgs-seaboss": "2017-030-FA",
    "aims-towvid": "towed-imagery-field-manual.github.io",
    "usgs-squid5": "usgs.gov/centers/pcmsc/science/squid-5-camera-system",
    "ooi-camhd": "oceanobservatories.org/instrument-class/camhd",
}

# name: {section.key: published value}; None where the source asks for nothing.
PUBLISHED: dict[str, dict[str, Any]] = {
    "paper-tool-window": {
        "scene.water": "I", "vehicle.altitude_m": 2.0, "vehicle.speed_m_s": 1.0, "requirements.overlap": 0.25,
    },
    "paper-tank": {
        "scene.water": "I", "scene.salinity_psu": 0.0, "vehicle.altitude_m": 0.45, "vehicle.speed_m_s": 0.0,
    },
    "mbari-lass-2013": {
        "scene.depth_m": 2850.0, "vehicle.altitude_m": 2.0, "vehicle.speed_m_s": 0.15,
        "vehicle.camera_count": 2, "requirements.min_swath_m": 4.0, "requirements.max_gsd_mm": 2.1,
        "requirements.colour": "colour",
    },
    "mbari-lass-2021": {
        "scene.depth_m": 3200.0, "vehicle.altitude_m": 3.0, "vehicle.speed_m_s": 1.0,
        "vehicle.camera_count": 2, "requirements.min_swath_m": 5.0, "requirements.max_gsd_mm": 2.0,
    },
    "nui-acfr": {
        "vehicle.altitude_m": 3.0, "vehicle.speed_m_s": 0.7, "vehicle.camera_count": 2,
        "requirements.frame_interval_s": 1.0, "requirements.overlap": 0.43, "requirements.min_swath_m": 1.6,
        "requirements.max_gsd_mm": 1.2,
    },
    "whoi-abe": {
        "vehicle.altitude_m": 5.0, "vehicle.speed_m_s": 0.4, "requirements.frame_interval_s": 5.0,
        "requirements.overlap": 0.33, "requirements.min_swath_m": 3.0, "requirements.max_gsd_mm": 2.9,
    },
    "awi-ofobs": {
        "vehicle.altitude_m": 1.5, "vehicle.speed_m_s": 0.26, "requirements.frame_interval_s": 15.0,
        "requirements.overlap": None, "requirements.max_gsd_mm": 0.5, "requirements.colour": "colour",
    },
    "biocam": {
        "scene.depth_m": 4000.0, "vehicle.altitude_m": 5.0, "requirements.min_swath_m": 8.0,
        "requirements.max_gsd_mm": 3.0,
    },
    "whoi-towcam": {
        "scene.depth_m": 6000.0, "vehicle.altitude_m": 2.0, "vehicle.speed_m_s": 0.4,
        "requirements.frame_interval_s": 10.0, "requirements.overlap": None, "requirements.colour": "colour",
    },
    "usgs-seaboss": {"vehicle.altitude_m": 1.0, "vehicle.light_count": (1, 2)},
    "aims-towvid": {"scene.depth_m": 250.0, "vehicle.altitude_m": 2.5},
    "usgs-squid5": {
        "vehicle.altitude_m": 5.0, "vehicle.speed_m_s": 1.5, "vehicle.camera_count": 5,
        "limits.power_w": 300.0,
    },
    "ooi-camhd": {"scene.depth_m": 1500.0, "vehicle.speed_m_s": 0.0},
}  # fmt: skip

PUBLISHED_SYSTEMS: dict[str, dict[str, Any]] = {
    "paper-tool-window": {
        "camera": "seed-imx250m", "lens.focal_length_mm": 8, "port.geometry": "dome",
        "port.outer_radius_mm": 100, "port.thickness_mm": 10, "port.refractive_index": 1.5,
        "light.flux_lm": 20_000, "light.beam_half_angle_deg": 45, "settings.f_number": 4.0,
        "settings.exposure_ms": 0.86,
    },
    "paper-tank": {
        "camera": "seed-imx250m", "lens.focal_length_mm": 12, "port.geometry": "flat",
        "port.material": "acrylic", "light.flux_lm": 2500, "light.beam_half_angle_deg": 40,
        "settings.f_number": 4.0, "settings.exposure_ms": 0.597,
    },
    "mbari-lass-2013": {
        "camera.resolution_x_px": 1936, "camera.resolution_y_px": 1456, "camera.colour": "colour",
        "camera_count": 2, "port.geometry": "dome", "light.kind": "flash", "light.flash_energy_j": 100,
        "light_count": 2,
    },
    "nui-acfr": {"camera": "avt-prosilica-gt1380", "camera_count": 2, "settings.frame_rate_hz": 1.0},
    "whoi-abe": {
        "camera.resolution_x_px": 1024, "camera.resolution_y_px": 1024, "camera.bit_depth": 12,
        "camera.colour": "colour", "light_count": 1, "settings.frame_rate_hz": 0.2,
    },
    "awi-ofobs": {"camera.resolution_x_px": 5760, "camera.resolution_y_px": 3840, "light_count": 2},
}  # fmt: skip


@cache
def catalogue_parts() -> dict[str, Any]:
    """Every part that ships, by id."""
    catalog = read_catalog()
    return {p.id: p for kind in ("cameras", "lenses", "ports", "lights") for p in getattr(catalog, kind)}


def built_part(system_name: str, kind: Any) -> Any:
    """The record of one part of a system file."""
    system = load_system(PROBLEMS / system_name)
    part = system.part(kind)
    return catalogue_parts()[part] if isinstance(part, str) else part_from_inline(kind, part, system.base_dir)


def comment_of(name: str) -> str:
    """The comment lines at the head of a file, as one text."""
    lines = (PROBLEMS / name).read_text(encoding="utf-8").splitlines()
    return "\n".join(line for line in lines if line.startswith("#"))


def value_at(thing: Any, path: str) -> Any:
    """A value by its dotted path; `scene` is a mission's only scene."""
    for step in path.split("."):
        if step == "scene" and isinstance(thing, Mission):
            (thing,) = thing.scenes
        else:
            thing = getattr(thing, step)
    return thing


def test_at_least_nine_missions_stand_here_and_each_has_its_numbers_below():
    assert len(MISSIONS) >= 9
    sourced = {name.removesuffix(".yaml") for name in MISSIONS if name != WITHOUT_SOURCE}
    assert sourced == set(PUBLISHED) == set(SOURCES)
    assert {name.removesuffix(".system.yaml") for name in SYSTEMS} == set(PUBLISHED_SYSTEMS)


@pytest.mark.parametrize("name", MISSIONS)
def test_mission_loads_and_every_scene_is_complete(name):
    mission = load_mission(PROBLEMS / name)
    (view,) = mission.views
    assert view.requirements.min_snr is not None  # without it the darkest picture would do
    assert 10.0 <= view.requirements.min_snr <= 10**1.5 + 1e-9  # 20 to 30 dB


@pytest.mark.parametrize("name", SYSTEMS)
def test_system_loads_beside_its_mission_and_its_parts_can_be_built(name):
    mission = load_mission(PROBLEMS / name.replace(".system.yaml", ".yaml"))
    load_system(PROBLEMS / name).check_scenes(mission)
    for kind in ("camera", "lens", "port", "light"):
        assert built_part(name, kind) is not None


@pytest.mark.parametrize("name", [*MISSIONS, *SYSTEMS])
def test_file_names_its_source_and_what_is_published(name):
    comment = comment_of(name)
    assert re.search(r"^# Source: \S", comment, re.MULTILINE)
    assert re.search(r"^# Published: \S", comment, re.MULTILINE)
    if name != WITHOUT_SOURCE:
        assert SOURCES[name.removesuffix(".yaml").removesuffix(".system")] in comment


@pytest.mark.parametrize("name", [n for n in MISSIONS if n != WITHOUT_SOURCE])
def test_each_assumption_of_a_mission_gives_a_reason(name):
    blocks = re.split(r"\n# (?=\S)", comment_of(name))
    assumptions = [block for block in blocks if block.startswith("assumed:")]
    assert assumptions
    for block in assumptions:
        assert re.search(r"\(.+\)", block, re.DOTALL), block


@pytest.mark.parametrize("name", sorted(PUBLISHED))
def test_mission_holds_the_published_numbers(name):
    mission = load_mission(PROBLEMS / f"{name}.yaml")
    assert {path: value_at(mission, path) for path in PUBLISHED[name]} == PUBLISHED[name]


@pytest.mark.parametrize("name", sorted(PUBLISHED_SYSTEMS))
def test_system_holds_the_published_hardware(name):
    system = load_system(PROBLEMS / f"{name}.system.yaml")
    assert {path: value_at(system, path) for path in PUBLISHED_SYSTEMS[name]} == PUBLISHED_SYSTEMS[name]


@pytest.mark.parametrize(
    ("name", "pixels", "altitude_m", "width_m"),
    [
        ("mbari-lass-2013", 1936, 2.0, 4.0),
        ("nui-acfr", 1360, 3.0, 1.6),
        ("whoi-abe", 1024, 5.0, 3.0),
        ("awi-ofobs", 5760, 1.5, (4.0 * 1.5) ** 0.5),  # 4 m2 at 3:2
    ],
)
def test_rig_as_built_sees_the_published_width(name, pixels, altitude_m, width_m):
    # Behind a dome rays start one radius behind the vertex: width = n p / f * (d + R).
    # 0.5 %: focal lengths are rounded.
    camera, lens, port = (built_part(f"{name}.system.yaml", kind) for kind in ("camera", "lens", "port"))
    sensor_width_mm = pixels * camera.pixel_pitch_um * 1e-3
    seen_m = sensor_width_mm / lens.focal_length_mm * (altitude_m + port.outer_radius_mm.value * 1e-3)
    assert seen_m == pytest.approx(width_m, rel=0.005)


def test_strobes_of_biocam_stand_where_they_are_published():
    # Both on the centre line, 1.08 m ahead of the colour camera and 1.75 m behind it.
    mounts = load_mission(PROBLEMS / "biocam.yaml").vehicle.light_mounts
    assert mounts is not None
    assert [(mount.x_m, mount.y_m, mount.z_m) for mount in mounts] == [(1.08, 0.0, 0.0), (-1.75, 0.0, 0.0)]


@pytest.mark.parametrize(("name", "images_per_s"), [("usgs-seaboss", 60.0), ("ooi-camhd", 30.0)])
def test_video_missions_want_the_published_image_rate(name, images_per_s):
    # 0.5 %: intervals are written with four decimals.
    interval_s = load_mission(PROBLEMS / f"{name}.yaml").requirements.frame_interval_s
    assert interval_s == pytest.approx(1.0 / images_per_s, rel=0.005)


def test_tank_mission_wants_the_measured_level():
    # Measured: 12466 of 65535 after 597 us with IMX250 and 12 mm F4.0. 0.5 %: two decimals.
    mission = load_mission(PROBLEMS / "paper-tank.yaml")
    assert mission.requirements.mean_level == pytest.approx(12466 / 65535, rel=0.005)
    assert mission.limits.max_exposure_ms == pytest.approx(0.597, rel=0.01)


def test_readme_lists_every_mission_and_how_to_run_them():
    readme = (PROBLEMS / "README.md").read_text(encoding="utf-8")
    for name in MISSIONS:
        assert f"`{name}`" in readme
    for address in SOURCES.values():
        assert address in readme
    assert "uwopt solve problems/" in readme
    assert "uwopt evaluate problems/" in readme

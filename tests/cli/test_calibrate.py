"""`uwopt calibrate`: the founding paper's tank, a lamp of the catalogue, what it writes, changes and refuses."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import make_full_table
import pytest
import yaml
from typer.testing import CliRunner

import uwopt
from uwopt.api.calibrating import calibrate
from uwopt.cli.app import app
from uwopt.mission.mission import load_mission
from uwopt.mission.shots import read_shots

PROBLEMS = Path(__file__).parents[2] / "problems"
TANK, TANK_SYSTEM = PROBLEMS / "paper-tank.yaml", PROBLEMS / "paper-tank.system.yaml"
HEAD = "shot,exposure_us,gain,distance_m,level_dn,dark_dn"


def run(*arguments: object) -> Any:
    return CliRunner().invoke(app, [str(word) for word in arguments])


TANK_SHOTS = PROBLEMS / "paper-tank.shots.csv"


def test_shipped_shots_are_the_published_readings() -> None:
    (series,) = (one for one in make_full_table.SERIES if one.name == "IMX250, 12 mm F4.0")
    read = {round(1e6 * shot.exposure_s): shot.level for shot in read_shots(TANK_SHOTS)}
    assert read == series.measured_dn


def test_tank_readings_are_fitted_by_one_factor() -> None:
    """docs/validation_full.md fits all lens sets by one number; board x concentration is the same within 5 %."""
    page = (Path(__file__).parents[2] / "docs" / "validation_full.md").read_text("utf-8")
    product = float(re.findall(r"that is (\d\.\d+) for reflectance", " ".join(page.split()))[0])
    made = calibrate(TANK, TANK_SYSTEM, TANK_SHOTS, at="middle", again=False)
    assert 0.9 * made.fit.factors["light"].value == pytest.approx(product, rel=0.05)
    assert made.fit.rms_frac < 0.02 and not made.fit.outlier.any()
    assert made.fit.factors["water"].held and made.fit.factors["back"].held


def test_command_tells_fits_and_writes_what_loads(tmp_path: Path) -> None:
    out = tmp_path / "made" / "tank.yaml"
    done = run("calibrate", TANK, TANK_SYSTEM, TANK_SHOTS, "--at", "middle", "--out", out)
    assert done.exit_code == 0, done.output
    said = " ".join(done.output.split())
    assert "1.65 to 1.69" in said and "only another distance tells water from light" in said
    assert "The floor would give back more light than it gets, so that it is put down to the lamp." in said
    assert {path.name for path in out.parent.iterdir()} == {"tank.yaml", "tank.system.yaml"}
    before, after = (
        uwopt.evaluate(mission, system, physics="full").design
        for mission, system in ((TANK, TANK_SYSTEM), (out, out.parent / "tank.system.yaml"))
    )
    assert before is not None and after is not None
    signal = [one.scenes[0].figures["electrons_signal"] for one in (before, after)]
    factor = float(re.findall(r"times (\d\.\d+)", out.read_text("utf-8"))[0])
    assert 1.65 <= factor <= 1.69 and signal[1] / signal[0] == pytest.approx(factor, rel=1e-3)


PATCH = {"resolution_x_px": 32, "resolution_y_px": 32}
LAMP = "arctic-rays-dragonfish-mini-strobe-65deg-10hz"
CARD = """\
exposure_ms,gain,distance_m,level_pct,dark_pct
{rows}"""


@pytest.fixture(scope="module")
def card_shots(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, Path]:
    """A mission that may use one lamp of the catalogue, its system, and shots of a card of 0.18 that show 0.7 of it."""
    folder = tmp_path_factory.mktemp("card")
    mission = {
        "practice": "bare", "name": "pool", "physics": "full",
        "scene": {"water": "II", "seafloor": "sand", "depth_m": 10},
        "vehicle": {"altitude_m": 1.0, "speed_m_s": 0.0, "light_count": 2},
        "requirements": {"frame_interval_s": 1.0, "min_snr_db": 36, "max_gsd_mm": 1.0},
        "catalog": {"cameras": ["avt-alvium-1800-c-040m"], "lenses": ["computar-m0814*"], "lights": [LAMP]},
    }  # fmt: skip
    system = {
        "camera": {
            "resolution_x_px": 2448, "resolution_y_px": 2048, "pixel_pitch_um": 3.45, "read_noise_e": 2.4,
            "quantum_efficiency": 0.6, "gain_dn_per_e": 0.35, "bit_depth": 12,
        },
        "lens": {"focal_length_mm": 8.0, "transmission": 0.9},
        "port": {"geometry": "dome", "outer_radius_mm": 80, "thickness_mm": 10, "refractive_index": 1.5},
        "light": LAMP, "light_count": 2, "settings": {"f_number": 4.0},
    }  # fmt: skip
    rows = []
    for distance_m in (0.8, 1.6):
        for exposure_ms in (0.1, 0.2):
            card = mission | {"scene": {"water": "II", "seafloor": 0.18 * 0.7, "depth_m": 10}}
            card["vehicle"] = {"altitude_m": distance_m, "speed_m_s": 0.0, "light_count": 2}
            small = system | {"camera": {**system["camera"], **PATCH}, "settings": {  # type: ignore[dict-item]
                "f_number": 4.0, "exposure_ms": exposure_ms, "gain": 1.0}}
            seen = uwopt.evaluate(card, small).design
            assert seen is not None
            level = 100.0 * float(seen.scenes[0].figures["mean_level"])
            rows.append(f"{exposure_ms},1,{distance_m},{level!r},0")
    files = folder / "pool.yaml", folder / "rig.yaml", folder / "shots.csv"
    files[0].write_text(yaml.safe_dump(mission), "utf-8")
    files[1].write_text(yaml.safe_dump(system), "utf-8")
    files[2].write_text(CARD.format(rows="\n".join(rows)) + "\n", "utf-8")
    return files


def test_a_card_tells_the_lamp_and_the_search_takes_it(card_shots: tuple[Path, Path, Path], tmp_path: Path) -> None:
    mission, system, shots = card_shots
    out = tmp_path / "new.yaml"
    words = ("--card", "0.18", "--out", out, "--fit-only", "--date", "2026-11-23")
    done = run("calibrate", mission, system, shots, *words)
    assert done.exit_code == 0, done.output
    before, after = (uwopt.load_catalog(load_mission(one)).part(LAMP, "light") for one in (mission, out))
    factors = [part.output_factor.value for part in (before, after)]  # type: ignore[union-attr]
    assert factors[1] / factors[0] == pytest.approx(0.7, rel=2e-2)  # what water sends back was not dimmed with the card
    assert load_mission(out).scenes[0].seafloor == "sand"


def test_what_it_changes_is_told(card_shots: tuple[Path, Path, Path]) -> None:
    made = calibrate(*card_shots, card=0.18)
    assert made.before is not None and made.after is not None
    power = [result.objective.value for result in (made.before, made.after)]
    assert made.searched and power[0] is not None and (power[1] is None or power[1] > power[0])


# ---------------------------------------------------------------- refused


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--card", "18"], "card = 18 is not a reflectance above 0 and up to 1"),
        (["--scene", "reef"], "--scene 'reef' is none of scene 1"),
        (["--date", "3.4.2026"], "date = '3.4.2026' is no day; write YYYY-MM-DD"),
    ],
)
def test_calls_that_make_no_sense_are_refused(tmp_path: Path, words: list[str], message: str) -> None:
    done = run("calibrate", TANK, TANK_SYSTEM, TANK_SHOTS, "--fit-only", *words)
    assert done.exit_code == 2 and message in " ".join(done.output.split())


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("a,100,1,0.45,2329,0", "1 shot can be used, two are the least"),
        ("a,100,1,0.45,2329,0\nb,200,1,0.45,65535,0", "1 shot can be used, two are the least (b: saturated)"),
        ("a,100,1,0.45,2329,0\nb,200,1,0.45,70000,0", "shot b: level 70000 is more than the camera's 16 bits can say"),
        ("a,100,1,0.45,2329,0\nb,200,1,0.02,9000,0", "two are the least (b: by the model no light gets there)"),
        ("a,100,1,0.45,2329,0\nb,200,1,0.4,9000,0", ""),
    ],
)  # fmt: skip
def test_shots_that_tell_nothing_are_refused_by_name(tmp_path: Path, rows: str, message: str) -> None:
    (tmp_path / "few.csv").write_text(f"{HEAD}\n{rows}\n", "utf-8")
    words = ("--fit-only", "--at", "middle", "--out", tmp_path / "new.yaml")
    done = run("calibrate", TANK, TANK_SYSTEM, tmp_path / "few.csv", *words)
    assert done.exit_code == (2 if message else 0), done.output
    assert message in " ".join(done.output.split()) and "Traceback" not in done.output
    assert (tmp_path / "new.yaml").exists() is not bool(message)


def test_what_is_calibrated_is_not_written_over(tmp_path: Path) -> None:
    mission = tmp_path / "tank.yaml"
    mission.write_text(TANK.read_text("utf-8"), "utf-8")
    done = run("calibrate", mission, TANK_SYSTEM, TANK_SHOTS, "--fit-only", "--out", mission)
    assert done.exit_code == 2 and "name another file for --out" in " ".join(done.output.split())
    assert mission.read_text("utf-8") == TANK.read_text("utf-8")

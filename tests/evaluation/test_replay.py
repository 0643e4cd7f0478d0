"""A design is recomputed from its result file: same inputs, same figures."""

from __future__ import annotations

import json
from dataclasses import replace as changed
from pathlib import Path
from typing import Any

import pytest
from plain_replay import plain_figures_of
from thorough import drawn

import uwopt
from uwopt.errors import UwoptError
from uwopt.evaluation.recompute import ReplayError, mount_of, replay
from uwopt.results.design import Design, LampPlace
from uwopt.results.result import Result

PROBLEMS = Path(__file__).parents[2] / "problems"
TWO_SCENES: dict[str, Any] = {
    "practice": "bare", "name": "two", "physics": "full",
    "scenes": [
        {"name": "clear", "water": "IB", "seafloor": "sand", "depth_m": 20},
        {"name": "murky", "water": "1C", "seafloor": 0.2, "depth_m": 5, "vehicle": {"altitude_m": 1.2}},
    ],
    "vehicle": {"altitude_m": 1.5, "altitude_tolerance_m": 0.1, "speed_m_s": 0.4, "light_count": 2,
                "light_baseline_m": [0.5, 0.55], "light_tilt_deg": 5},
    "requirements": {"overlap": 0.5, "max_blur_px": 2.0, "min_snr_db": 20, "max_gsd_mm": 1.5, "min_dof_m": 0.3},
    "catalog": {"cameras": ["flir-bfs-u3-51s5m"], "lenses": ["kowa-lm8jc5mc"], "lights": ["arctic*"],
                "generic": "never"},
}  # fmt: skip


def stored(result: Result) -> Result:
    """A result as it comes back from its file."""
    return Result.from_dict(json.loads(result.to_json()))


def assert_same_figures(result: Result, design: Design) -> None:
    made = replay(
        result.mission,
        design,
        physics=result.physics,
        mission_file=result.mission_file,
        system=result.system,
    )
    for index, scene in enumerate(design.scenes):
        again = json.loads(json.dumps(plain_figures_of(made, index)))
        for name, value in scene.figures.items():
            assert again[name] == (pytest.approx(value, rel=1e-9) if isinstance(value, float) else value), (
                name
            )


@pytest.mark.parametrize("name", drawn(["whoi-abe"], ["whoi-abe", "paper-tool-window"]))
def test_designs_that_were_searched_give_the_same_figures(name, undoubted):
    result = stored(uwopt.solve(PROBLEMS / f"{name}.yaml", top=2))
    for design in (result.recommendation, *result.runners_up, result.generic_alternative):
        if design is not None:
            assert_same_figures(result, design)


@pytest.mark.parametrize("name", ["nui-acfr", "paper-tank", "whoi-abe", "awi-ofobs"])
def test_systems_that_were_evaluated_give_the_same_figures(name):
    result = stored(uwopt.evaluate(PROBLEMS / f"{name}.yaml", PROBLEMS / f"{name}.system.yaml"))
    assert result.system is not None
    assert_same_figures(result, result.design)


def test_every_scene_gives_the_same_figures(undoubted):
    result = stored(uwopt.solve(TWO_SCENES, top=1))
    assert len(result.recommendation.scenes) == 2
    assert_same_figures(result, result.recommendation)


def test_results_carry_the_mission_as_it_was_written(tmp_path):
    text = (PROBLEMS / "paper-tank.yaml").read_text(encoding="utf-8")
    result = uwopt.evaluate(PROBLEMS / "paper-tank.yaml", PROBLEMS / "paper-tank.system.yaml")
    assert result.mission_file == {"name": "paper-tank.yaml", "folder": "", "text": text}
    assert uwopt.evaluate(result.mission, result.system).mission_file is None


def water_file(folder: Path) -> Path:
    """A mission with a water of its own, in a folder."""
    rows = "\n".join(f"{nm},0.2,0.1,0.1,0.15" for nm in range(380, 790, 10))
    (folder / "own.csv").write_text(
        f"# own water\nwavelength_nm,attenuation_per_m,a_per_m,b_per_m,kd_per_m\n{rows}\n"
    )
    text = (PROBLEMS / "nui-acfr.yaml").read_text(encoding="utf-8").replace("water: IB", "water: own.csv")
    (folder / "mission.yaml").write_text(text, encoding="utf-8")
    return folder / "mission.yaml"


def test_files_are_found_beside_the_mission_and_missed_when_they_move(tmp_path):
    mission = water_file(tmp_path)
    result = stored(uwopt.evaluate(mission, PROBLEMS / "nui-acfr.system.yaml"))
    assert result.mission_file["folder"] == str(tmp_path)
    assert_same_figures(result, result.design)
    (tmp_path / "own.csv").unlink()
    with pytest.raises(ReplayError, match=r"cannot be recomputed.*own\.csv"):
        assert_same_figures(result, result.design)


def test_a_part_that_left_the_catalogue_is_named(undoubted):
    result = stored(uwopt.solve(PROBLEMS / "paper-tool-window.yaml", top=1))
    design = result.recommendation
    gone = changed(
        design, hardware=changed(design.hardware, lens=changed(design.hardware.lens, id="acme-9mm"))
    )
    with pytest.raises(UwoptError, match="acme-9mm"):
        assert_same_figures(result, gone)


def test_other_figures_than_the_files_are_refused():
    result = stored(uwopt.evaluate(PROBLEMS / "paper-tank.yaml", PROBLEMS / "paper-tank.system.yaml"))
    scene = result.design.scenes[0]
    other = changed(
        scene, figures=scene.figures | {"electrons_signal": scene.figures["electrons_signal"] * 1.01}
    )
    with pytest.raises(ReplayError, match="electrons_signal"):
        assert_same_figures(result, changed(result.design, scenes=[other]))


def test_lights_on_the_grid_are_one_mount_and_others_stand_one_by_one():
    pair = [LampPlace(0.0, y_m, 0.0, 0.0, 5.0) for y_m in (0.8, -0.8, 0.8)]
    assert (mount_of(pair, []).baseline_m, mount_of(pair, []).tilt_deg) == (0.8, 5.0)
    moved = [*pair[:2], changed(pair[2], x_m=0.1)]
    assert len(mount_of(moved, []).explicit) == 3


DIVER: dict[str, Any] = {
    "camera": {"resolution_x_px": 2000, "resolution_y_px": 1000, "pixel_pitch_um": 5.0, "read_noise_e": 5.0,
               "quantum_efficiency": 0.5, "gain_dn_per_e": 0.05, "max_gain_db": 20},
    "lens": {"focal_length_mm": 10.0, "f_number_min": 1.4, "f_number_max": 16.0},
    "port": {"geometry": "flat", "gap_mm": 5.0, "thickness_mm": 10.0},
    "light": {"flux_lm": 10_000, "power_w": 100.0, "beam": "cosine-power", "beam_half_angle_deg": 40.0,
              "kind": "pulsed_led"},
    "settings": {"f_number": 5.6, "exposure_ms": 2.0, "pulse_ms": 0.7, "gain": 3.0, "dim_frac": 0.4,
                 "frame_rate_hz": 1.5, "focus_distance_m": 1.25},
}  # fmt: skip
DIVE: dict[str, Any] = {
    "practice": "bare",
    "scene": {"water": "II", "seafloor": 0.2, "depth_m": 30.0}, "vehicle": {"altitude_m": 1.5, "speed_m_s": 0.2},
}  # fmt: skip


def replayed_from(result: Result) -> Any:
    kept = stored(result)
    assert kept.design is not None
    return replay(kept.mission, kept.design, physics=kept.physics, system=kept.system)


def test_settings_of_a_result_come_back_in_si():
    made = replayed_from(uwopt.evaluate(DIVE, DIVER, physics="paper"))
    rows = made.settings[0]
    found = [rows.f_number, rows.exposure_s, rows.pulse_s, rows.gain, rows.level, rows.rate_hz]
    assert [float(column[0]) for column in found] == pytest.approx(
        [5.6, 2e-3, 0.7e-3, 3.0, 0.4, 1.5], rel=1e-12
    )
    assert plain_figures_of(made)["focus_distance_m"] == pytest.approx(1.25, rel=1e-12)


def test_effects_that_were_left_out_stay_out():
    result = uwopt.evaluate({**DIVE, "tolerance": 0.5}, DIVER, physics="auto")
    left_out = {item["name"] for item in result.physics["effects"] if not item["kept"]}
    assert left_out
    effects = replayed_from(result).model.problem.effects
    assert {name for name, kept in vars(effects).items() if not kept} == left_out

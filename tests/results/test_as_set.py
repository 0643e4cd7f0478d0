"""What a design is at the settings that a person sets: figures, margins and totals of those, not of the optimum."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from pathlib import Path

import pytest

import uwopt
from uwopt.report.page.sections import scene_bars
from uwopt.report.text.console import print_blocks
from uwopt.report.text.short import short_text_blocks
from uwopt.report.text.tables import design_blocks
from uwopt.report.write import system_yaml
from uwopt.results.reading import read_solved
from uwopt.results.result import Result

MISSION = {
    "name": "Reef", "practice": "bare",
    "scene": {"water": "II", "seafloor": "coral", "depth_m": 30},
    "vehicle": {"altitude_m": 2.0, "altitude_tolerance_m": 0.25, "speed_m_s": 0.5, "light_baseline_m": 0.8,
                "light_count": [1, 2]},
    "requirements": {"overlap": 0.6, "max_blur_px": 1.0, "min_snr_db": 30, "mean_level": 0.3, "min_dof_m": 0.6},
    "limits": {"power_w": 150, "depth_rating_m": 100},
    "catalog": {"cameras": ["avt-alvium-1800-c-234m"], "lenses": ["thorlabs-mvl16m1"],
                "ports": ["blue-robotics-4-in-dome-plastic-ring-2026"], "generic": "never"},
    "objective": "power", "confidence": "central",
}  # fmt: skip


@pytest.fixture(scope="module")
def solved() -> Result:
    """A mission whose exact optimum nobody can type in."""
    return uwopt.solve(MISSION, quick=True)


@pytest.fixture(scope="module")
def again(solved: Result, tmp_path_factory: pytest.TempPathFactory) -> Result:
    """What `evaluate` says of the system.yaml that `solve` wrote: settings typed in, nothing known of a search."""
    file: Path = tmp_path_factory.mktemp("round") / "system.yaml"
    file.write_text(system_yaml(solved), "utf-8")
    return uwopt.evaluate(MISSION, file)


def numbers(values: dict[str, object]) -> dict[str, float]:
    """What is a number of some values."""
    return {name: float(value) for name, value in values.items() if isinstance(value, (int, float))}


def text_of(blocks: object) -> str:
    """Blocks as one line of text."""
    stream = io.StringIO()
    print_blocks(blocks, stream)  # type: ignore[arg-type]
    return " ".join(stream.getvalue().split())


def test_as_set_is_what_evaluate_says_of_the_settings_typed_in(solved: Result, again: Result) -> None:
    assert solved.best is not None and again.best is not None
    shown, typed = solved.best.as_set, again.best
    assert shown.objective_value == pytest.approx(typed.objective_value, rel=1e-8)  # 9 digits are typed
    assert shown.totals.power_w == pytest.approx(typed.totals.power_w, rel=1e-8)
    for ours, theirs in zip(shown.scenes, typed.scenes, strict=True):
        assert numbers(ours.figures) == pytest.approx(numbers(theirs.figures), rel=1e-6)
        told = numbers({m.requirement: m.value for m in theirs.margins})
        assert numbers({m.requirement: m.value for m in ours.margins}) == pytest.approx(told, rel=1e-6)


def test_evaluate_does_not_disown_what_solve_wrote(again: Result) -> None:
    level = next(m for m in again.best.scenes[0].margins if m.requirement == "mean_level")  # type: ignore[union-attr]
    assert again.status == "feasible" and level.value != level.limit  # met by a step of the gain, as it was set
    assert [note.message for note in again.warnings if note.code == "outside_search"] == []


def test_evaluate_tells_of_a_focus_that_solve_would_not_set(again: Result) -> None:
    system = dict(again.system or {})
    scene = again.best.scenes[0]  # type: ignore[union-attr]
    level = next(m for m in scene.margins if m.requirement == "mean_level")
    assert scene.settings["gain"] and level.value and level.limit
    off_step = 1.006 * scene.settings["gain"] * level.limit / level.value  # 0.05 dB beside the exact gain
    off = {"settings.focus_distance_m": {"focus_distance_m": 3.0}, "settings.gain": {"gain": off_step}}
    for code, change in off.items():
        scenes = {name: one | change for name, one in system["scenes"].items()}
        told = uwopt.evaluate(MISSION, system | {"scenes": scenes})
        assert [note.path for note in told.warnings if note.code == "outside_search"] == [code]


def test_proof_keeps_the_exact_optimum(solved: Result) -> None:
    best, proof = solved.best, solved.certificate
    assert best is not None and proof is not None and best.objective_value is not None
    assert proof.best_value == pytest.approx(best.objective_value, rel=1e-9)
    set_w = best.as_set.objective_value
    assert set_w is not None and set_w > best.objective_value  # rounding costs something, and is shown
    limits = {m.requirement: m for m in best.scenes[0].margins}
    assert limits["min_snr_db"].binding  # the optimum has nothing in hand; what is set has a little
    assert {m.requirement: m.margin for m in best.as_set.scenes[0].margins}["min_snr_db"] > 1e-4


def test_pages_show_what_is_set_and_the_optimum_beside_it(solved: Result) -> None:
    best = solved.best
    assert best is not None
    snr = next(m for m in best.as_set.scenes[0].margins if m.requirement == "min_snr_db")
    rate_hz = (best.scenes[0].settings_to_set or {})["frame_rate_hz"]
    assert f"frame rate {rate_hz:.3g} Hz" in text_of(short_text_blocks(solved))
    bars = {bar.name: bar for bar in next(scene_bars(best)).bars}
    assert snr.value is not None and f"{snr.value:.2f}"[:5] in bars["signal to noise"].value
    assert bars["signal to noise"].exact.startswith("30.0")  # what was asked for, to which the optimum keeps
    assert bars["signal to noise"].state == "binding"
    assert " worst at exact " in text_of(design_blocks(solved, best))


def test_figures_as_set_are_kept_in_the_file(solved: Result, tmp_path: Path) -> None:
    file = tmp_path / "result.json"
    file.write_text(solved.to_json(), "utf-8")
    read = read_solved(file)
    assert read.best is not None and solved.best is not None
    assert read.best.as_set == solved.best.as_set


def test_file_of_before_is_read_and_shows_the_optimum(solved: Result, tmp_path: Path) -> None:
    data = solved.to_dict()
    for scene in data["recommendation"]["scenes"]:
        del scene["figures_as_set"], scene["margins_as_set"]
    del data["recommendation"]["rounded"]["totals"]
    file = tmp_path / "old.json"
    file.write_text(json.dumps(data), "utf-8")
    read = read_solved(file)
    assert read.best is not None
    assert read.best.as_set is read.best


def test_what_cannot_be_set_shows_its_exact_numbers(solved: Result) -> None:
    best = solved.best
    assert best is not None and best.rounded is not None
    unset = replace(best, rounded=replace(best.rounded, feasible=False))
    assert unset.as_set is unset


def test_frames_are_of_what_is_set(solved: Result) -> None:
    assert solved.best is not None
    row = solved.frame("margins").set_index("requirement").loc["min_snr_db"]
    assert row["margin"] == {m.requirement: m.margin for m in solved.best.as_set.scenes[0].margins}["min_snr_db"]

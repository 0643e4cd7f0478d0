"""The settings card: what it says, and that its page is safe and prints on one sheet."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from priced_system import PRICED
from typer.testing import CliRunner

from uwopt.api.evaluating import evaluate
from uwopt.cli.app import app
from uwopt.evaluation.setting_limits import LEVEL, SettingEnd, SettingLimit
from uwopt.report.card.blocks import (
    ROUND_CEILING,
    ROUND_FLOOR,
    SettingsCard,
    breaks,
    delay_ms,
    end_text,
    focus_sentences,
    limit_texts,
    settings_card,
    short_text,
    work_rows,
)
from uwopt.report.card.page import card_html
from uwopt.report.card.water import change_text, water_text
from uwopt.report.text.layout import Facts, Grid
from uwopt.report.write import json_text
from uwopt.results.result import Result
from uwopt.solvers.explain.worse_water import InWorseWater

Make = Callable[..., Any]
MISSION: dict[str, Any] = {
    "name": "<script>alert(1)</script> reef", "physics": "paper", "practice": "bare",
    "scene": {"water": "II", "seafloor": "sand", "depth_m": 20},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, "light_count": 2},
    "requirements": {"overlap": 0.6, "max_blur_px": 1.0, "min_snr_db": 26.5},
}  # fmt: skip
SETTINGS = {"f_number": 4.0, "exposure_ms": 3.0, "pulse_ms": 1.0, "gain": 4.0, "frame_rate_hz": 2.0}


@pytest.fixture(scope="module")
def result() -> Result:
    light = PRICED["light"] | {"flux_lm": 30_000.0}
    return evaluate(MISSION, PRICED | {"light": light, "light_count": 2, "settings": SETTINGS})


@pytest.fixture(scope="module")
def card(result: Result) -> SettingsCard:
    made = settings_card(result)
    assert made is not None
    return made


def rows(card: SettingsCard, title: str) -> dict[str, list[str]]:
    """Cells of a block's table by what stands first."""
    (found,) = (block for block in card.blocks if block.title == title)
    return {
        row[0].plain: [cell.plain for cell in row[1:]]
        for line in found.lines
        if isinstance(line, Grid)
        for row in line.rows
    }


def test_every_setting_has_its_limits_and_what_breaks_there(card: SettingsCard) -> None:
    # 26.72 dB may fall by 0.22 dB: to 0.950 of the light where shot noise is all, to 0.974 where read noise is
    told = rows(card, "Set")
    assert told["light pulse"] == ["1 ms", "0.952 ms", "signal to noise", "1.5 ms", "motion blur"]
    assert told["frame rate"][1:5] == ["1.67 Hz", "overlap along track", "10 Hz", "frame rate of the camera"]
    assert told["exposure"][3] == "any"


def test_a_setting_s_own_end_is_told_by_which_end_it_is() -> None:
    assert breaks(SettingEnd(1.0, "min_exposure_ms")) == "shortest"
    assert breaks(SettingEnd(1.0, "f_number_min")) == "widest of the lens"
    assert breaks(SettingEnd(1.0, "max_white_balance")) == "white balance"


def focus_said(nearer: float, farther: float) -> str:
    low, high = SettingEnd(1.0 - nearer, "dof_far_m"), SettingEnd(1.0 + farther, "dof_near_m")
    return " ".join(focus_sentences({"focus_distance_m": 0.15}, SettingLimit("focus_distance_m", low, high, low, high)))


def test_a_focus_finer_than_a_scale_is_set_says_how_to_reach_it_and_what_widens_it() -> None:
    said = focus_said(0.02, 0.03)
    assert said.startswith("Focus: 3.0 mm nearer or 4.5 mm farther than 0.15 m is all there is")
    assert "live view on a chart at that distance" in said and "takes twice the light" in said
    assert focus_said(0.08, 0.09) == ""


def test_brightness_that_no_end_breaks_holds_over_the_whole_range() -> None:
    free, level = SettingEnd(2.0, "dof_far_m"), SettingEnd(1.5, LEVEL)
    assert limit_texts("gain_db", 6.0, SettingLimit("gain_db", free, free, free, free))[4] == "all of that"
    assert limit_texts("exposure_ms", 2.0, SettingLimit("exposure_ms", free, level, free, free))[4] == "up to 3 ms"


def test_readings_of_water_are_told_in_words_with_their_unit() -> None:
    assert [water_text(f"{key} 2") for key in ("c_per_m", "visibility_m", "secchi_m", "turbidity_ntu")] == [
        "beam attenuation 2 per metre", "visibility 2 m", "Secchi depth 2 m", "turbidity 2 NTU"
    ]  # fmt: skip
    assert water_text("Jerlov III") == "Jerlov III"


@pytest.mark.parametrize(
    ("rounding", "factor", "text"),
    [(ROUND_CEILING, 0.98761, "1.98 m"), (ROUND_FLOOR, 1.01999, "2.03 m"), (ROUND_FLOOR, 1.0001, "as set")],
)
def test_ends_are_rounded_to_the_safe_side(rounding: str, factor: float, text: str) -> None:
    assert end_text("focus_distance_m", 2.0, SettingEnd(factor, "x"), rounding) == text


def test_slow_rates_are_told_as_intervals_alone() -> None:
    assert short_text("frame_rate_hz", 1.0 / 3600.0) == "every 60 min"
    assert short_text("exposure_ms", 2.5) == "2.5 ms"


def test_what_keeps_the_vehicle_from_going_nearer_is_told(result: Result) -> None:
    scenes = [replace(s, margins=[replace(m, satisfied=False) for m in s.margins]) for s in result.best.scenes]
    planned = replace(result.best, scenes=scenes, feasible=False)
    item = InWorseWater("Jerlov 9C", planned, 0.3, None, "min_swath_m")
    assert "down to 30 % of the altitude: swath too narrow; wait" in change_text(item, result.best)


@pytest.mark.parametrize(
    ("gain_db", "factor", "rounding", "text"),
    [(12.0, 2.0, ROUND_FLOOR, "18 dB"), (6.02060, 0.5, ROUND_CEILING, "0 dB"), (1.5, 0.99, ROUND_CEILING, "1.5 dB")],
)
def test_gain_moves_in_decibels(gain_db: float, factor: float, rounding: str, text: str) -> None:
    assert end_text("gain_db", gain_db, SettingEnd(factor, "x"), rounding) == text


def test_nothing_is_changed_where_all_holds_in_worse_water(result: Result) -> None:
    scenes = [replace(scene, settings=scene.settings | {"f_number": 2.0}) for scene in result.best.scenes]
    item = InWorseWater("Jerlov III", result.best, 1.0, replace(result.best, scenes=scenes))
    assert change_text(item, result.best) == "nothing"


def test_the_pulse_may_come_late_by_what_the_exposure_is_longer(card: SettingsCard) -> None:
    said = [getattr(line, "plain", "") for line in card.blocks[0].lines]
    assert "Trigger: the pulse begins with the exposure, or up to 2.0 ms later without any loss." in said


@pytest.mark.parametrize(
    ("least_ms", "spare_ms", "told"), [(78.7968, 0.01, 78.8), (78.7968, 0.001, 78.797), (0.00123, 1.0, 0.002)]
)
def test_a_delay_has_digits_that_are_set_and_is_never_too_short(least_ms: float, spare_ms: float, told: float) -> None:
    assert delay_ms(least_ms, spare_ms) == told


@pytest.mark.parametrize(("exposure_ms", "told"), [
    # 2 ms to 7 % of the peak: tau = 2 / ln(1 / 0.07) = 0.7521 ms, over at 1 % after 3.46 ms. Till 0.448 ms it gives
    # (1 - exp(-0.5957)) / 0.99 = 45.3 %; u = 0.2979, sigma = tau sqrt(1 - (u / sinh u)^2) = 0.1286 ms, 2 sqrt(3) of it
    (0.448, "45.3 % of its light falls within the exposure, and no more is counted; it blurs as 0.44 ms"),
    # the whole: truncated exponential at ln 100, sigma = 0.8839 tau
    (20.0, "100 % of its light falls within the exposure, and no more is counted; it blurs as 2.3 ms"),
])  # fmt: skip
def test_what_a_flash_gives_within_the_exposure_is_told(exposure_ms: float, told: str) -> None:
    settings = {"f_number": 4.0, "exposure_ms": exposure_ms, "gain": 4.0, "frame_rate_hz": 0.5}
    mission = {**MISSION, "physics": "full", "requirements": {"overlap": 0.0, "min_snr_db": 5}}
    made = evaluate(mission, PRICED | {"light": "generic-flash-50j", "light_count": 2, "settings": settings})
    card = settings_card(made)
    assert card is not None
    said = [getattr(line, "plain", "") for line in card.blocks[0].lines]
    assert any(told in line for line in said)
    assert rows(card, "Set")["light pulse"][0] == "3.46 ms, its own"  # tau ln 100 = 3.4635 ms, which nobody sets
    others = "The shutter is open for 20.0 ms all the same: other lights of the vehicle must be off"
    assert any(others in line for line in said) == (exposure_ms == 20.0)


@pytest.mark.parametrize("between", ["off", "on"])
def test_what_is_off_between_images_is_told_when_it_is_switched_on(between: str) -> None:
    """A plate seen once an hour was told that its lamps burn all the time, which a battery of weeks would not last."""
    vehicle = {"altitude_m": 2.0, "speed_m_s": 0.0, "light_count": 2, "duration_h": 10.0,
               "lamps_between_images": between, "camera_between_images": between}  # fmt: skip
    mission = {**MISSION, "physics": "full", "vehicle": vehicle, "requirements": {"frame_interval_s": 600}}
    light = {key: value for key, value in PRICED["light"].items() if key != "max_pulse_ms"}
    light |= {"kind": "continuous", "flux_lm": 30_000.0, "warm_up_s": 2.5}
    # the image of 2 Mpx goes over within 1/10 s: 7 s and that
    parts = PRICED | {"light": light, "camera": PRICED["camera"] | {"wake_up_s": 7.0, "max_frame_rate_hz": 10.0}}
    settings = {"f_number": 4.0, "exposure_ms": 3.0, "gain": 4.0, "frame_rate_hz": 1 / 600}
    card = settings_card(evaluate(mission, parts | {"light_count": 2, "settings": settings}))
    assert card is not None
    said = [getattr(line, "plain", "") for line in card.blocks[0].lines]
    off = "Trigger: the lamps are off between images; on 2.5 s before the exposure, off when it is over."
    assert (off in said) == (between == "off")
    assert ("The lamps burn all the time: nothing is triggered." in said) == (between == "on")
    awake = "The camera is off between images: for each it is on for 7.1 s, waking up and transfer, and the exposure."
    assert (awake in said) == (between == "off")


def test_the_day_s_work_is_that_of_an_hour(card: SettingsCard, result: Result) -> None:
    # by hand: 1.504 m at 0.5 m/s for 3600 s; 2 images of 2000 x 1000 px in a second for an hour at 1.5 or 2 byte each
    told = rows(card, "The day's work")
    assert told["area in an hour"] == ["2 707 m2/h"]
    rate = result.best.scenes[0].figures["data_rate_mb_s"]
    assert told["data in an hour"] == [f"{3.6 * rate:.1f} GB"]
    power = result.best.totals.power_w
    assert told["hours from 100 Wh"] == [f"{100 / power:.1f} h"]
    of_water = replace(result, mission=result.mission | {"scenes": [{"name": "here", "target": "mid_water"}]})
    names = {name for name, _ in work_rows(of_water, result.best)}
    assert "data in an hour" in names and not {"area in an hour", "distance between lines"} & names


def test_no_lines_are_told_of_a_camera_that_stands(result: Result) -> None:
    """A camera that faced one coral for a year was told the distance between its lines."""
    figures = {**result.best.scenes[0].figures, "area_m2_h": 0.0}
    still = replace(result.best, scenes=[replace(result.best.scenes[0], figures=figures)])
    names = {name for name, _ in work_rows(result, still)}
    assert "swath" in names and not {"area in an hour", "distance between lines"} & names


def test_what_does_not_fly_is_not_told_to_fly_lower() -> None:
    missed = SimpleNamespace(feasible=False)
    nothing: Any = SimpleNamespace(as_planned=missed, design=None, altitude_frac=0.3, obstacle="")
    told = [change_text(nothing, nothing, flies=flies) for flies in (True, False)]
    assert [text.partition(",")[2].partition(",")[0] for text in told] == [
        " nor does flying lower", " nor does going nearer",
    ]  # fmt: skip
    lower: Any = SimpleNamespace(as_planned=missed, altitude_frac=0.8, design=SimpleNamespace(
        scenes=[], totals=SimpleNamespace(power_w=1.0)))  # fmt: skip
    planned: Any = SimpleNamespace(scenes=[])
    assert change_text(lower, planned, flies=False).startswith("go to 80 % of the altitude")


def test_worse_water_says_what_breaks_and_what_to_change(card: SettingsCard) -> None:
    told = rows(card, "If the water is worse than planned")
    assert told["Jerlov III"][0].startswith("signal to noise ")
    assert told["Jerlov III"][1].startswith("fly at 60 % of the altitude; ")  # the iris of a manual lens stays
    assert all("f-number" not in change for _, change in told.values())


def test_page_escapes_names_and_runs_no_script(result: Result, card: SettingsCard) -> None:
    page = card_html(result, card)
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt; reef" in page
    assert re.findall(r"<script(?! type=\"application/json\")", page) == []


def test_card_without_its_inputs_tells_the_settings_all_the_same(make_result: Make) -> None:
    made = settings_card(make_result())
    assert made is not None
    assert rows(made, "Set")["f-number"][0] == "2.8"
    assert any("cannot be recomputed" in getattr(line, "plain", "") for block in made.blocks for line in block.lines)


def test_how_it_stands_is_told(card: SettingsCard) -> None:
    (facts,) = (line for block in card.blocks if block.title == "How it stands" for line in block.lines)
    assert isinstance(facts, Facts)
    assert facts.pairs[0] == ("camera", "landscape: the image's height along the motion")


def test_command_prints_the_card_and_writes_its_page(tmp_path: Path, result: Result) -> None:
    file = tmp_path / "result.json"
    file.write_text(json_text(result), "utf-8")
    done = CliRunner().invoke(app, ["card", str(file), "--out", str(tmp_path / "card.html")])
    assert done.exit_code == 0
    assert done.output.index(str(result.mission["name"])) < done.output.index("If the water is worse than planned")
    assert "<h2>Set</h2>" in (tmp_path / "card.html").read_text("utf-8")


def test_command_refuses_a_result_without_a_system(tmp_path: Path, make_result: Make) -> None:
    file = tmp_path / "result.json"
    file.write_text(json_text(replace(make_result(), recommendation=None, status="infeasible")), "utf-8")
    done = CliRunner().invoke(app, ["card", str(file)])
    assert done.exit_code == 2
    assert "holds no system" in done.output

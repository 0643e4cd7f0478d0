"""A cap of gain that yields: held while anything fits below it, lifted with a warning where nothing does."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

import uwopt
from uwopt.api import searching
from uwopt.api.common import beyond_cap
from uwopt.evaluation.recompute import replay
from uwopt.forward.assembly import load_catalog
from uwopt.mission.mission import load_mission
from uwopt.objectives.goal import goal_of
from uwopt.report.order.tender_lines import lines_of
from uwopt.solvers import recommend

LIGHT = "deepsea-power-light-led-sealite-lsl-flood"
HARDWARE = {
    "cameras": ["flir-bfs-u3-120s4m"], "lenses": ["kowa"], "lights": [LIGHT], "accept_unrated": [LIGHT],
    "generic": "never",
}  # fmt: skip
CAP_DB = 20.0


def survey(cap_db: float | None, *, dark: bool) -> dict[str, Any]:
    """A survey with one camera, from so near that there is light enough, or from farther and faster."""
    return {
        "practice": "bare", "scene": {"water": "II", "seafloor": 0.2, "depth_m": 30}, "physics": "paper",
        "vehicle": {
            "altitude_m": 2.5 if dark else 1.0, "speed_m_s": 0.3 if dark else 0.1, "light_count": [1, 1 if dark else 8],
        },
        "requirements": {"overlap": 0.3, "max_blur_px": 1.0, "mean_level": 0.3 if dark else 0.15, "min_snr_db": 10},
        "catalog": HARDWARE, "reserve": {} if cap_db is None else {"max_gain_db": cap_db},
    }  # fmt: skip


@cache
def solved(cap_db: float | None, *, dark: bool) -> Any:
    """What is found for it."""
    return uwopt.solve(survey(cap_db, dark=dark), top=1, quick=True)


def gain_db(result: Any) -> float:
    """Of the recommendation."""
    return float(result.recommendation.scenes[0].settings["gain_db"])


def test_a_gain_that_is_not_needed_stays_below_its_cap() -> None:
    free, held = solved(None, dark=False), solved(CAP_DB, dark=False)
    assert gain_db(free) > CAP_DB >= gain_db(held) - 1e-6
    assert "gain_cap" not in [note.code for note in held.warnings]


def test_a_cap_below_which_nothing_fits_is_lifted_with_a_warning() -> None:
    free, held = solved(None, dark=True), solved(CAP_DB, dark=True)
    assert gain_db(held) == pytest.approx(gain_db(free))
    told = [note.message for note in held.warnings if note.code == "gain_cap"]
    assert told == [f"gain {gain_db(free):.3g} dB, beyond 20 dB, below which nothing fits: light is out of reach"]


def test_a_gain_just_beyond_its_cap_does_not_look_like_it() -> None:
    assert beyond_cap(12.0412, 12.0) == "gain 12.04 dB, beyond 12 dB"  # a ratio of 4


def test_a_front_lifts_a_cap_below_which_nothing_fits() -> None:
    front = uwopt.pareto(survey(CAP_DB, dark=True), objectives=["power", "cost"], solver="exact")
    best = solved(CAP_DB, dark=True)
    assert min(point.values["power"] for point in front.points) == pytest.approx(best.objective.value, rel=1e-6)
    told = [note.message for note in front.warnings if note.code == "gain_cap"]
    assert len(told) == 1 and told[0].endswith("beyond 20 dB, below which nothing fits: light is out of reach")
    assert front.mission["reserve"]["max_gain_db"] == CAP_DB
    bright = uwopt.pareto(survey(CAP_DB, dark=False), objectives=["power", "cost"], solver="exact")
    assert bright.points and "gain_cap" not in [note.code for note in bright.warnings]


def test_what_a_part_must_fulfil_is_asked_without_a_cap_that_yielded() -> None:
    free, held = (needed_of_lens(solved(cap_db, dark=True)) for cap_db in (None, CAP_DB))
    assert held["transmission_frac"] == free["transmission_frac"] != "at least 0.900"
    assert not held["mass_g"]  # the mission limits no mass
    below = solved(CAP_DB, dark=False)
    assert replay(below.mission, below.best.as_set, physics=below.physics).model.problem.mission.reserve.max_gain_db


def needed_of_lens(result: Any) -> dict[str, str]:
    """What a tender says that the lens needs."""
    (lens,) = [line for line in lines_of(result, "it") if line.kind == "lens"]
    return {fact.key: fact.needed for fact in lens.facts}


def dark_survey(*, fits: bool) -> dict[str, Any]:
    """One whose lamps have to be made, and lift the cap; or whose signal to noise nothing reaches."""
    asked = survey(CAP_DB, dark=True)
    asked["catalog"] = {**HARDWARE, "generic": "fallback", "lights": [LIGHT]}
    if not fits:
        asked["requirements"]["min_snr_db"] = 200.0
    return asked


@pytest.mark.parametrize("fits", [True, False])
def test_parts_to_be_made_are_searched_once_where_nothing_fits(fits: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    # Without its cap the same mission decides for all parts; where it has a design, cap and order hold as ever.
    asked: list[tuple[bool, str]] = []

    def seek(mission: Any, *args: Any, **named: Any) -> Any:
        asked.append((mission.reserve.max_gain_db is not None, named["generic"]))
        return recommend.seek(mission, *args, **named)

    monkeypatch.setattr(searching, "seek", seek)
    result = uwopt.solve(dark_survey(fits=fits), top=1, quick=True, explain=False)
    assert (result.recommendation is not None) == fits
    assert asked[:2] == [(True, "never"), (False, "allow")]
    assert asked[2:] == ([(True, "allow"), (False, "never"), (False, "allow")] if fits else [(False, "never")])
    assert result.certificate.adds_up()


@pytest.mark.parametrize("fits", [True, False])
def test_what_is_known_to_fit_is_not_asked_about(fits: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    # Without its cap alone, so the cap is lifted as ever; what is wrongly taken to fit is not told to.
    asked: list[bool] = []

    def seek(mission: Any, *args: Any, **named: Any) -> Any:
        asked.append(named.get("enough", False))
        return recommend.seek(mission, *args, **named)

    monkeypatch.setattr(searching, "seek", seek)
    mission = load_mission(dark_survey(fits=fits))
    searches = searching.Searches(load_catalog(mission), goal_of(mission))
    plain = searches.of(mission)
    assert any(asked)
    asked.clear()
    known = searches.of(mission, fits=True)
    assert not any(asked) and known.fits == plain.fits == fits
    if fits:
        assert known.sought.outcome.best[0].minimised == plain.sought.outcome.best[0].minimised


@pytest.mark.parametrize(("dark", "min_snr_db"), [(True, 200.0), (True, 10.0), (False, 10.0)])
def test_what_is_left_in_vain_is_answered_all_the_same(
    dark: bool, min_snr_db: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Nothing fits at all, nothing below the cap, and something below it: as where no search is left.
    mission = survey(CAP_DB, dark=dark)
    mission["requirements"]["min_snr_db"] = min_snr_db
    whole = uwopt.solve(mission, top=1, quick=True, explain=False)
    asked: list[tuple[bool, bool]] = []

    def seek(mission: Any, *args: Any, **named: Any) -> Any:
        found = recommend.seek(mission, *args, **named)
        asked.append((mission.reserve.max_gain_db is not None, found.search.is_in_vain))
        return found

    monkeypatch.setattr(searching, "seek", seek)
    monkeypatch.setattr(searching, "MOST_IN_VAIN", -1)  # left at once
    left = uwopt.solve(mission, top=1, quick=True, explain=False)
    assert left.status == whole.status
    assert left.objective.value == whole.objective.value
    assert left.certificate.adds_up()
    if min_snr_db == 200.0:
        assert asked == [(True, True), (False, False)]  # not below the cap once more
    elif dark:
        assert asked[0] == (True, True)


def test_a_number_of_the_requirements_is_hard() -> None:
    mission = load_mission({
        "practice": "bare",
        "scene": {"water": "II", "seafloor": 0.2, "depth_m": 30}, "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3},
        "requirements": {"overlap": 0.3, "max_gain_db": 0}, "reserve": "recommended",
    })  # fmt: skip
    assert mission.views[0].requirements.max_gain_db == 0.0
    assert mission.without_gain_cap.views[0].requirements.max_gain_db == 0.0
    assert mission.reserve.max_gain_db == 12.0


GIVEN: dict[str, Any] = {
    "camera": "flir-bfs-u3-120s4m", "lens": "kowa-lm8jc10m", "port": "generic-flat-acrylic-100mm",
    "light": LIGHT, "light_count": 1,
}  # fmt: skip
PLAIN: dict[str, Any] = {
    "scene": {"water": "II", "seafloor": 0.2, "depth_m": 30}, "practice": "bare", "physics": "paper",
    "vehicle": {"altitude_m": 1.0, "speed_m_s": 0.1, "light_count": 1}, "requirements": {"overlap": 0.3},
}  # fmt: skip


@pytest.mark.parametrize(("gain", "told"), [(10.0, 1), (1.0, 0)])
def test_a_given_gain_beyond_the_cap_is_told_and_not_refused(gain: float, told: int) -> None:
    # a gain of 10 is 20 dB, 8 beyond the 12 that are recommended
    mission = {**PLAIN, "reserve": {"max_gain_db": 12}}
    result = uwopt.evaluate(mission, {**GIVEN, "settings": {"gain": gain}})
    assert result.design is not None
    scene = result.design.scenes[0]
    notes = [note.message for note in result.warnings if note.code == "gain_cap"]
    assert [text.startswith(f"{scene.name}: gain 20 dB, beyond 12 dB;") for text in notes] == [True] * told
    assert "max_gain_db" not in [margin.requirement for margin in scene.margins]


def test_good_practice_may_be_asked_for_by_its_word() -> None:
    keys = ("max_gain_db", "lens_stop_down", "max_airy_px", "max_white_balance")
    wanted = {"overlap": 0.3, **dict.fromkeys(keys, "Recommended")}
    asked = load_mission({**PLAIN, "requirements": wanted}).views[0].asked
    assert [getattr(asked, key) for key in keys] == [12.0, 1.0, 2.0, 4.0]

"""`solve` and `evaluate` agree on what is allowed; what lies outside of the search is told.

The systems here once passed `evaluate` and beat, or contradicted, the certificate of `solve`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import uwopt
from uwopt.results.result import Result

PARTS = Path(__file__).parents[1] / "rule_parts"
SYSTEM: dict[str, Any] = {
    "camera": "zz-global", "lens": "zz-12mm", "port": "zz-window", "light": "zz-led", "light_count": 1,
    "light_baseline_m": 0.8, "orientation": "landscape",
    "settings": {"f_number": 1.4, "exposure_ms": 0.5, "pulse_ms": 0.5, "dim_frac": 1.0, "gain": 1.0},
}  # fmt: skip
VEHICLE: dict[str, Any] = {
    "altitude_m": 2.0, "speed_m_s": 1.0, "orientation": "landscape", "light_baseline_m": 0.8, "light_count": 1,
}  # fmt: skip
TWO_SCENES = [
    {"name": "near", "water": "II", "seafloor": 0.5, "depth_m": 30, "altitude_m": 1.0, "min_dof_m": 0.6},
    {"name": "far", "water": "3C", "seafloor": 0.1, "depth_m": 30, "altitude_m": 3.0},
]


def mission(physics: str = "paper", **sections: Any) -> dict[str, Any]:
    """A mission over the parts of this folder's catalogue."""
    names = {"cameras": "zz-global", "lenses": "zz-12mm", "ports": "zz-window", "lights": "zz-led"}
    own = {kind: [name] for kind, name in {**names, **sections.pop("parts", {})}.items()}
    files = [str(PARTS / f"{kind}.csv") for kind in own]
    scenes = sections.pop("scenes", None)
    where = {"scenes": scenes} if scenes else {"scene": {"water": "II", "seafloor": "coral", "depth_m": 30}}
    return {
        "name": "rules", "practice": "bare", "objective": "power", "physics": physics, **where,
        "vehicle": {**VEHICLE, **sections.pop("vehicle", {})},
        "requirements": {"min_snr_db": 12, "max_blur_px": 2.0, **sections.pop("requirements", {})},
        "catalog": {"files": files, "generic": "never", **own}, **sections,
    }  # fmt: skip


def system(**changes: Any) -> dict[str, Any]:
    """The system with other parts; `settings` are merged, a setting of None is left out."""
    settings = {**SYSTEM["settings"], **changes.pop("settings", {})}
    return {**SYSTEM, **changes, "settings": {k: v for k, v in settings.items() if v is not None}}


def missed(result: Result) -> set[str]:
    """Requirements that an evaluated design misses in some scene."""
    assert result.design is not None
    return {m.requirement for scene in result.design.scenes for m in scene.margins if not m.satisfied}


def notes(result: Result) -> set[str]:
    """Paths of the notes that a system lies outside of the search."""
    return {note["path"] for note in result.warnings if note["code"] == "outside_search"}


# ---------------------------------------------------------------- images that just touch


def test_images_must_touch_where_nothing_fixes_their_rate() -> None:
    assert missed(uwopt.evaluate(mission(), system(settings={"frame_rate_hz": 0.001}))) == {"overlap"}


def test_images_that_just_touch_are_enough_where_nothing_fixes_their_rate() -> None:
    # 2 m at an effective focal length of 1.33 * 12 mm: 1216 pixels of 5.86 um see 0.893 m; 1 m/s over that
    rate_hz = 1.0 / (2.0 * 1216 * 5.86e-6 / (1.33 * 12e-3))
    given = uwopt.evaluate(mission(), system(settings={"frame_rate_hz": rate_hz}))
    assert missed(given) == set()
    left_out = uwopt.evaluate(mission(), system())
    assert left_out.design is not None
    assert left_out.design.scenes[0].settings["frame_rate_hz"] == pytest.approx(rate_hz, rel=1e-12)


def test_an_interval_alone_lets_images_lie_apart() -> None:
    asked = mission(requirements={"frame_interval_s": 1000.0})
    assert missed(uwopt.evaluate(asked, system(settings={"frame_rate_hz": 0.001}))) == set()


# ---------------------------------------------------------------- one lens for all scenes


def two_scenes(lens: str, **near: Any) -> Result:
    """The lens at F3.6 and 0.5 m nearer in the first scene, unless set otherwise."""
    own = {"f_number": 3.6, "focus_distance_m": 1.2, **near}
    asked = mission("full", scenes=TWO_SCENES, parts={"lenses": lens}, requirements={"min_snr_db": -40})
    far = {"f_number": 1.4, "focus_distance_m": 3.0}
    return uwopt.evaluate(asked, {**system(lens=lens), "scenes": {"near": own, "far": far}})


def test_a_manual_lens_cannot_be_set_anew_between_scenes() -> None:
    assert {"common_f_number", "common_focus_m"} <= missed(two_scenes("zz-12mm"))


def test_one_f_number_and_one_focus_suit_a_manual_lens() -> None:
    result = two_scenes("zz-12mm", f_number=1.4, focus_distance_m=3.0)
    assert not {"common_f_number", "common_focus_m"} & missed(result)


def test_a_motorised_lens_may_be_set_anew_and_its_focus_is_told() -> None:
    result = two_scenes("zz-12mm-motor")
    assert not {"common_f_number", "common_focus_m"} & missed(result)
    assert "settings.focus_distance_m" in notes(result)


def test_scenes_without_a_given_focus_share_the_one_that_solve_takes() -> None:
    asked = mission("full", scenes=TWO_SCENES, requirements={"min_snr_db": -40})
    result = uwopt.evaluate(asked, system(settings={"f_number": 8.0}))
    assert not {"common_f_number", "common_focus_m"} & missed(result)
    assert "settings.focus_distance_m" not in notes(result)


# ---------------------------------------------------------------- flashes and pulses


def test_no_setting_cuts_a_flash_short() -> None:
    # The flash lasts 5 ms; a rolling shutter of 40 Hz is open in all rows for 31 - 25 = 6 ms.
    parts = {"cameras": "zz-rolling", "lights": "zz-flash"}
    cut = system(camera="zz-rolling", light="zz-flash", settings={"exposure_ms": 31, "pulse_ms": 1.0})
    asked = mission(parts=parts, requirements={"max_blur_px": 100.0})
    assert "min_pulse_ms" in missed(uwopt.evaluate(asked, cut))
    whole = {**cut, "settings": {**cut["settings"], "pulse_ms": 5.0}}
    assert "min_pulse_ms" not in missed(uwopt.evaluate(asked, whole))


def test_a_global_shutter_cuts_a_flash_short() -> None:
    cut = system(light="zz-flash", settings={"exposure_ms": 1.0, "pulse_ms": 1.0})
    assert "min_pulse_ms" not in missed(uwopt.evaluate(mission(parts={"lights": "zz-flash"}), cut))


@pytest.mark.parametrize(("pulse_ms", "told"), [(0.5, False), (0.6, True)])
def test_a_pulse_longer_than_the_exposure_is_told(pulse_ms: float, told: bool) -> None:
    result = uwopt.evaluate(mission(), system(settings={"pulse_ms": pulse_ms}))
    assert ("settings.pulse_ms" in notes(result)) == told


# ---------------------------------------------------------------- what the vehicle carries

ELSEWHERE: dict[str, tuple[dict[str, Any], str]] = {
    "light count": ({"light_count": 2}, "light_count"),
    "camera count": ({"camera_count": 2}, "camera_count"),
    "light places": ({"light_baseline_m": 0.5}, "light_mounts"),
    "orientation": ({"orientation": "portrait"}, "orientation"),
}


@pytest.mark.parametrize("rule", ELSEWHERE)
def test_what_the_vehicle_states_binds(rule: str) -> None:
    change, path = ELSEWHERE[rule]
    result = uwopt.evaluate(mission(vehicle={"camera_count": 1}), system(**change))
    assert f"fits: {rule}" in missed(result) and path in notes(result)


OPEN = {"light_count": 9, "camera_count": 2, "light_baseline_m": 0.7}


@pytest.mark.parametrize("key", OPEN)
def test_what_the_vehicle_leaves_open_is_told(key: str) -> None:
    plain = mission()
    plain["vehicle"] = {"altitude_m": 2.0, "speed_m_s": 1.0}
    result = uwopt.evaluate(plain, {**system(light_baseline_m=0.5), key: OPEN[key]})
    assert not any(name.startswith("fits") for name in missed(result))
    assert notes(result) == {"light_mounts" if key == "light_baseline_m" else key}


def test_a_physics_of_the_call_leaves_the_vehicle_as_open_as_it_was() -> None:
    plain = mission()
    plain["vehicle"] = {"altitude_m": 2.0, "speed_m_s": 1.0}
    result = uwopt.evaluate(plain, system(camera_count=2, light_baseline_m=0.5), physics="full")
    assert not any(name.startswith("fits") for name in missed(result))


@pytest.mark.parametrize(("baseline_m", "inside"), [(0.45, True), (0.47, False), (0.6, False)])
def test_places_between_those_that_solve_tries_are_told(baseline_m: float, inside: bool) -> None:
    result = uwopt.evaluate(
        mission(vehicle={"light_baseline_m": [0.4, 0.5]}), system(light_baseline_m=baseline_m)
    )
    assert ("light_mounts" in notes(result)) != inside
    assert ("fits: light places" in missed(result)) == (baseline_m > 0.5)


def test_mounts_written_out_are_the_same_places() -> None:
    own = system(light_count=2, light_mounts=[{"y_m": -0.8}, {"y_m": 0.8}])
    del own["light_baseline_m"]
    result = uwopt.evaluate(mission(vehicle={"light_count": 2}), own)
    assert notes(result) == set() and "fits: light places" not in missed(result)


def test_parts_outside_of_the_selection_are_told() -> None:
    assert notes(uwopt.evaluate(mission(), system(light="zz-small-led"))) == {"light"}
    inline = {"focal_length_mm": 12, "f_number_min": 1.4, "f_number_max": 16, "transmission": 0.9}
    assert notes(uwopt.evaluate(mission(), system(lens=inline))) == {"lens"}


# ---------------------------------------------------------------- an image is wanted


def test_the_nominal_altitude_must_be_sharp_where_no_depth_of_field_is_asked() -> None:
    far = uwopt.evaluate(mission("full"), system(settings={"focus_distance_m": 10_000}))
    # Hyperfocal distance in air: f^2 / (N c) = 0.012^2 / (1.4 * 11.72e-6) = 8.8 m: 2 m of water is nearer than that.
    assert missed(far) == {"dof_near_m"}
    assert missed(uwopt.evaluate(mission("full"), system())) == set()


@pytest.mark.usefixtures("undoubted")
def test_asking_for_a_little_depth_of_field_costs_a_little() -> None:
    """At 0.15 m half a millimetre of depth takes a smaller aperture, none takes the widest."""
    near = {"altitude_m": 0.15, "speed_m_s": 0.02, "light_baseline_m": 0.2}
    parts = {"lenses": "zz-35mm", "lights": "zz-small-led"}
    f_numbers = []
    for depth in (None, 0.0003, 0.0006):
        wanted = {"overlap": 0.5} | ({} if depth is None else {"min_dof_m": depth})
        best = uwopt.solve(mission("full", vehicle=near, parts=parts, requirements=wanted)).recommendation
        assert best is not None
        f_numbers.append(float(best.scenes[0].settings["f_number"]))
    assert f_numbers[:2] == [1.4, 1.4] and 1.4 < f_numbers[2] < 4.0


def test_a_focus_that_saves_light_is_told() -> None:
    told = uwopt.evaluate(mission("full"), system(settings={"focus_distance_m": 2.1}))
    assert missed(told) == set() and notes(told) == {"settings.focus_distance_m"}
    assert notes(uwopt.evaluate(mission("full"), system(settings={"focus_distance_m": 2.0}))) == set()

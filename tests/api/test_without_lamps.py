"""Missions that may do without lamps, in the sun."""

from __future__ import annotations

from typing import Any

import pytest
import yaml

import uwopt
from uwopt.errors import MissionError
from uwopt.forward import lamp_light
from uwopt.report.write import system_yaml

CAMERA, LENS, PORT, LIGHT = (
    "daheng-mer2-041-528u3m", "raspberry-pi-16-mm-telephoto-hq-camera", "blue-robotics-3-in-acrylic-end-cap-2026",
    "deepsea-power-light-led-sealite-lsl-flood",
)  # fmt: skip
FEW = {"cameras": [CAMERA], "lenses": [LENS], "ports": [PORT], "generic": "never"}


def mission(count: Any, *, sun_lux: float = 80_000.0, depth_m: float = 6.0, **wanted: Any) -> dict[str, Any]:
    """A reef that a diver swims over."""
    return {
        "practice": "bare", "name": "diver", "objective": "power", "physics": "full",
        "scenes": [{"water": "IB", "seafloor": "coral", "depth_m": depth_m, "sun_lux": sun_lux}],
        "vehicle": {"altitude_m": 1.5, "altitude_tolerance_m": 0.3, "speed_m_s": 0.3, "light_count": count},
        "requirements": {"overlap": 0.7, "max_blur_px": 2.0, "min_snr_db": 25.0, "min_dof_m": 0.4, **wanted},
        "catalog": FEW,
    }  # fmt: skip


pytestmark = pytest.mark.usefixtures("undoubted")


@pytest.fixture(scope="module")
def unlit() -> uwopt.Result:
    """The result where no lamp is allowed."""
    return uwopt.solve(mission(0))


def test_nothing_is_bought_set_or_judged_of_a_lamp(unlit: uwopt.Result) -> None:
    best = unlit.best
    assert unlit.status == "optimal" and best is not None
    assert (best.hardware["light_count"], best.hardware["light_mounts"]) == (0, [])
    assert [row.kind for row in best.bom] == ["camera", "lens", "port"]
    assert best.totals["light_power_w"] == best.totals["light_peak_power_w"] == 0.0
    settings = best.scenes[0].settings_to_set
    assert settings is not None and settings["flux_lm"] is None and settings["dim_frac"] is None
    assert not [m.requirement for m in best.scenes[0].margins if "light" in m.requirement]


def test_a_table_names_no_lamp_where_none_is_carried() -> None:
    """`no lamp`, as the system of `solve` has it, not `1 x no-lamp`."""
    (system,) = uwopt.whatif(mission(0), {"speed_m_s": [0.2, 0.3]}).systems
    assert system.light_count == 0 and system.parts == f"{CAMERA} + {LENS} + {PORT} + no lamp"


def test_no_lamp_is_warned_of_in_the_system_that_solve_writes(unlit: uwopt.Result) -> None:
    again = uwopt.evaluate(mission(0), yaml.safe_load(system_yaml(unlit)))
    assert again.best is not None and again.best.feasible
    warned = [note.message for note in (*again.warnings, *again.best.warnings)]
    assert not [text for text in warned if "lamp stands" in text or "lights stand" in text]


def test_the_sun_alone_is_what_an_idle_lamp_leaves(unlit: uwopt.Result) -> None:
    assert unlit.best is not None
    told = ("gain_db", "focus_scale_m")  # beside what is set
    exact = unlit.best.scenes[0].settings
    settings = {name: value for name, value in exact.items() if name not in told and value is not None}
    parts = {"camera": CAMERA, "lens": LENS, "port": PORT, "orientation": unlit.best.hardware["orientation"]}
    none = uwopt.evaluate(mission(0), parts | {"light": "no-lamp", "light_count": 0, "settings": settings})
    idle = uwopt.evaluate(mission(1), parts | {"light": LIGHT, "settings": settings | {"dim_frac": 0.0}})
    assert none.best is not None and idle.best is not None
    for name in ("snr_db", "snr_db_min", "contrast", "electrons_sun"):
        assert none.best.scenes[0].figures[name] == pytest.approx(idle.best.scenes[0].figures[name], rel=1e-9)


def test_light_of_no_lamp_is_not_integrated(monkeypatch: pytest.MonkeyPatch) -> None:
    called = []
    made = lamp_light.field_means

    def integrated(*args: Any, **how: Any) -> Any:
        called.append(args)
        return made(*args, **how)

    monkeypatch.setattr(lamp_light, "field_means", integrated)
    uwopt.solve(mission(1) | {"catalog": {**FEW, "lights": [LIGHT], "accept_unrated": [LIGHT]}}, quick=True)
    of_a_lamp = len(called)
    uwopt.solve(mission(0, snr_at="worst"), quick=True)
    assert len(called) - of_a_lamp <= 2 < of_a_lamp  # what a lamp's veils would be, which is told


@pytest.mark.parametrize(("depth_m", "lamps"), [(6.0, False), (120.0, True)])
def test_lamps_are_taken_where_the_sun_does_not_reach(depth_m: float, lamps: bool) -> None:
    # 6 m under 80 000 lux some 10^4 lux are left; at 120 m nearly nothing
    lamps_too = {**FEW, "lights": [LIGHT], "accept_unrated": [LIGHT]}
    result = uwopt.solve(mission([0, 2], depth_m=depth_m, min_uniformity=0.01) | {"catalog": lamps_too})
    assert result.best is not None and result.certificate is not None and result.certificate.adds_up()
    assert (result.best.hardware["light_count"] > 0) is lamps
    assert ("no lamp" in repr(result)) is not lamps
    assert "0 ×" not in repr(result)


@pytest.mark.parametrize(("depth_m", "lamps"), [(6.0, False), (120.0, True)])
def test_lamps_are_switched_by_electronics_only_where_there_are_some(depth_m: float, lamps: bool) -> None:
    counted = {**FEW, "lights": [LIGHT], "accept_unrated": [LIGHT], "rest": "estimate"}
    best = uwopt.solve(mission([0, 2], depth_m=depth_m) | {"catalog": counted}, quick=True).best
    assert best is not None and (best.hardware["light_count"] > 0) is lamps
    assert ("rest-lamp-control" in [row.id for row in best.bom]) is lamps
    # the sum is that of the bill: what the search counts is what is bought
    assert best.totals.cost.value == pytest.approx(sum(row.to_buy * (row.unit_price or 0.0) for row in best.bom))
    assert best.scenes[0].figures["cost"] == pytest.approx(best.totals.cost.value)


def test_lamps_evenness_is_nothing_to_the_sun() -> None:
    result = uwopt.solve(mission(0, min_uniformity=1.0))
    assert result.best is not None and result.best.hardware["light_count"] == 0


def test_darkness_without_lamps_is_a_fault() -> None:
    with pytest.raises(MissionError, match="nothing would be seen"):
        uwopt.solve(mission([0, 2], sun_lux=0.0))


def test_places_of_lamps_ask_for_lamps() -> None:
    asked = mission([0, 1])
    asked["vehicle"]["light_mounts"] = [{"y_m": 0.5}]
    with pytest.raises(MissionError, match="begins at 0"):
        uwopt.solve(asked)

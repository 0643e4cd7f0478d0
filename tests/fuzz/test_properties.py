"""What no change of a mission or a catalogue may do to the optimum: each a property of random small problems.

The order of the catalogue, an added part and all requirements eased at once are in `tests/extreme/test_catalogues.py`;
here one limit or requirement at a time, other words for the same wish, and the same wish twice.
"""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from typing import Any

import extreme_cases as cases
import numpy as np
import pytest
import small_catalogues as small
from fuzz_files import PLAIN_PARTS, examples, plain_mission
from hypothesis import given
from hypothesis import strategies as st

import uwopt
from uwopt.catalog.records import exact
from uwopt.forward.parts import Parts

SAME = 1e-9  # below that two designs count as equal and part ids decide
VEILED = 1e-6  # the search closes bounds of veiled scenes to about that
FOCUS = 1e-3  # the focus follows the depth of field that is asked for, and the working f-number the focus
seeds = st.integers(0, 1_000_000)
Plain = dict[str, Any]


def random_case(seed: int) -> tuple[Parts, Plain]:
    """Up to two parts a kind, and a mission."""
    rng = np.random.default_rng(seed)
    parts, wanted = small.parts(rng, 2), small.mission(rng)
    wanted["physics"] = "paper" if seed % 2 else "full"
    return parts, wanted


def best(parts: Parts, wanted: Plain, objective: Any) -> Any:
    """The best design found; None where nothing is feasible."""
    found = cases.searched(parts, wanted, objective, top=1)
    assert found.complete and found.account.adds_up()
    return found.best[0] if found.best else None


def value(parts: Parts, wanted: Plain, objective: Any) -> float:
    """What is minimised, at its optimum; infinite where nothing is feasible."""
    found = best(parts, wanted, objective)
    return math.inf if found is None else float(found.minimised)


def assert_no_worse(new: float, old: float, *, within: float = SAME) -> None:
    """Smaller is better."""
    assert math.isinf(old) or new <= old + within * abs(old), (new, old)


def assert_same(new: float, old: float) -> None:
    """Both infeasible, or the same optimum."""
    assert new == old or new == pytest.approx(old, rel=VEILED)


# ---------------------------------------------------------------- one thing eased


EASED: dict[str, dict[str, bool]] = {  # whether more of it is easier
    "requirements": {
        "overlap": False, "frame_interval_s": True, "max_blur_px": True, "max_skew_px": True, "min_dof_m": False,
        "min_snr": False, "max_gsd_mm": True, "min_swath_m": False, "highlight_ratio": False, "min_contrast": False,
        "min_uniformity": False, "circle_of_confusion_px": True,
    },
    "limits": {"cost": True, "power_w": True, "peak_power_w": True, "mass_kg": True, "data_rate_mb_s": True,
               "max_exposure_ms": True},
}  # fmt: skip
TIGHT = {
    "overlap": 0.5, "frame_interval_s": 1.0, "max_blur_px": 0.7, "max_skew_px": 5.0, "min_dof_m": 0.2, "min_snr": 10.0,
    "max_gsd_mm": 1.5, "min_swath_m": 0.7, "highlight_ratio": 2.5, "min_contrast": 0.3, "min_uniformity": 0.1,
    "circle_of_confusion_px": 1.0, "cost": 4000.0, "power_w": 100.0, "peak_power_w": 300.0, "mass_kg": 3.0,
    "data_rate_mb_s": 20.0, "max_exposure_ms": 1.0,
}  # fmt: skip


@examples(6)
@given(
    seed=seeds, place=st.sampled_from([(s, k) for s, keys in EASED.items() for k in keys]), room=st.floats(1.0, 4.0),
    objective=st.sampled_from(["power", "cost", "mass", "snr_db"]),
)  # fmt: skip
def test_one_thing_eased_never_makes_the_optimum_worse(
    seed: int, place: Any, room: float, objective: str
) -> None:
    parts, wanted = random_case(seed)
    section, key = place
    wanted["requirements"].pop("min_snr_db", None)
    tight, eased = copy.deepcopy(wanted), copy.deepcopy(wanted)
    tight[section][key] = TIGHT[key]
    eased[section][key] = TIGHT[key] * room if EASED[section][key] else TIGHT[key] / room
    if key == "highlight_ratio":
        eased[section][key] = max(1.0, eased[section][key])
    hard, easy = value(parts, tight, objective), value(parts, eased, objective)
    within = FOCUS if key == "min_dof_m" else SAME
    assert_no_worse(easy, hard, within=within)
    if key not in ("highlight_ratio", "circle_of_confusion_px", "overlap", "frame_interval_s"):
        open_ = copy.deepcopy(wanted)
        open_[section].pop(key, None)  # what is left out asks for nothing
        assert_no_worse(value(parts, open_, objective), easy, within=within)


@examples(2)
@given(seed=seeds, objective=st.sampled_from(["power", "cost", "snr_db"]))
def test_more_choice_never_makes_the_optimum_worse(seed: int, objective: str) -> None:
    parts, wanted = random_case(seed)
    wanted["vehicle"].pop("light_mounts", None)
    for key, few, many in (
        ("orientation", "portrait", "any"), ("light_count", [2, 2], [1, 3]), ("light_baseline_m", 0.4, [0.4, 0.5]),
    ):  # fmt: skip
        narrow, wide = copy.deepcopy(wanted), copy.deepcopy(wanted)
        narrow["vehicle"][key], wide["vehicle"][key] = few, many
        assert_no_worse(value(parts, wide, objective), value(parts, narrow, objective))


@examples(2)
@given(seed=seeds, factor=st.floats(1.0, 100.0))
def test_a_brighter_lamp_that_dims_never_lowers_the_best_snr(seed: int, factor: float) -> None:
    """At the same power and price; dimmed freely from nothing, it can be what it was."""
    parts, wanted = random_case(seed)
    dims: Plain = {"kind": "continuous", "dim_levels": None, "dim_min_frac": 0.0, "power_w": exact(100.0)}
    plain = {field: getattr(parts, field) for field in ("cameras", "lenses", "ports")}

    def lit(flux_lm: float) -> Parts:
        lamps = tuple(replace(lamp, flux_lm=exact(flux_lm), **dims) for lamp in parts.lights)
        return Parts(lights=lamps, **plain)

    assert_no_worse(value(lit(1e4 * factor), wanted, "snr_db"), value(lit(1e4), wanted, "snr_db"))


# ---------------------------------------------------------------- other words for the same


@examples(2)
@given(seed=seeds, snr_db=st.floats(0.0, 30.0), objective=st.sampled_from(["power", "cost"]))
def test_decibels_and_ratios_ask_for_the_same(seed: int, snr_db: float, objective: str) -> None:
    parts, wanted = random_case(seed)
    wanted["physics"] = "paper"  # the wish is read before physics
    one, other = copy.deepcopy(wanted), copy.deepcopy(wanted)
    for scene in (*one["scenes"], *other["scenes"]):
        scene.pop("min_snr_db", None)
    other["requirements"].pop("min_snr_db", None)
    one["requirements"]["min_snr_db"], other["requirements"]["min_snr"] = snr_db, 10 ** (snr_db / 20)
    assert_same(value(parts, one, objective), value(parts, other, objective))


@examples(2)
@given(seed=seeds, factor=st.floats(1e-3, 1e3))
def test_weights_times_a_factor_choose_the_same(seed: int, factor: float) -> None:
    parts, wanted = random_case(seed)
    weights = {"power": 1.0, "cost": 0.01, "snr_db": 0.3}
    one = best(parts, wanted, weights)
    other = best(parts, wanted, {name: weight * factor for name, weight in weights.items()})
    assert (one is None) == (other is None)
    if one is not None:
        assert other.minimised == pytest.approx(one.minimised * factor, rel=1e-4)  # sums: gap of the search


@examples(2)
@given(seed=seeds, rate=st.floats(1e-3, 1e3), objective=st.sampled_from(["power", "cost"]))
def test_another_currency_chooses_the_same(seed: int, rate: float, objective: str) -> None:
    """One XXX is `rate` USD; a limit in it is the limit in USD over the rate."""
    parts, wanted = random_case(seed)
    wanted.pop("catalog", None)
    usd, own = copy.deepcopy(wanted), copy.deepcopy(wanted)
    usd["limits"]["cost"] = 4000.0
    own["limits"] |= {"cost": 4000.0 / rate, "currency": "XXX", "rates": {"XXX": rate}}
    one, other = value(parts, usd, objective), value(parts, own, objective)
    assert_same(other * (rate if objective == "cost" else 1.0), one)


@examples(2)
@given(seed=seeds, objective=st.sampled_from(["power", "cost", "snr_db"]))
def test_the_same_scene_twice_or_in_another_order_changes_nothing(seed: int, objective: str) -> None:
    parts, wanted = random_case(seed)
    if wanted["physics"] == "paper":  # which focuses at the altitude of its one scene, and best for several
        wanted["requirements"].pop("min_dof_m", None)
    once = value(parts, wanted, objective)
    turned = {**wanted, "scenes": wanted["scenes"][::-1]}
    twice = {**wanted, "scenes": [*wanted["scenes"], {**wanted["scenes"][0], "name": "again"}]}
    assert_same(value(parts, turned, objective), once)
    assert_same(value(parts, twice, objective), once)


@examples(2)
@given(seed=seeds, objective=st.sampled_from(["power", "cost"]))
def test_what_every_scene_overrides_may_stand_in_the_vehicle_and_back(seed: int, objective: str) -> None:
    parts, wanted = random_case(seed)
    wanted["scenes"] = wanted["scenes"][:1]
    inside = copy.deepcopy(wanted)
    for section, keys in (
        ("vehicle", ("altitude_m", "altitude_tolerance_m", "speed_m_s")),
        ("requirements", ("overlap",)),
    ):
        for key in keys:
            if key in inside[section]:
                inside["scenes"][0].setdefault(key, inside[section].pop(key))
    assert_same(value(parts, inside, objective), value(parts, wanted, objective))


# ---------------------------------------------------------------- a given system


MORE_SIGNAL = [("light", "flux_lm"), ("light", "output_factor"), ("camera", "quantum_efficiency"),
               ("lens", "transmission"), ("settings", "exposure_ms")]  # fmt: skip


@examples(12)
@given(
    place=st.sampled_from(MORE_SIGNAL), low=st.floats(1e-3, 0.9), factor=st.floats(1.0, 1.1),
    water=st.sampled_from(["I", "II", "5C", "9C"]), physics=st.sampled_from(["full", "auto", "paper"]),
    noise=st.just(0.0) | st.floats(1e-12, 1e3),
)  # fmt: skip
def test_more_signal_never_lowers_snr(
    place: Any, low: float, factor: float, water: str, physics: str, noise: float
) -> None:
    """At given settings: flux, output, efficiency, transmission, exposure."""
    kind, key = place
    scale = {"flux_lm": 1e5, "exposure_ms": 100.0}.get(key, 1.0)
    mission = plain_mission() | {"physics": physics}
    mission["scene"]["water"] = water
    found = []
    for share in (low, low * factor):
        system: Plain = {name: dict(part) for name, part in PLAIN_PARTS.items()}
        system["settings"] = {"f_number": 4.0, "exposure_ms": 1.0, "gain": 1.0}
        system["camera"]["read_noise_e"] = noise
        system[kind][key] = share * scale
        result = uwopt.evaluate(mission, system)
        assert result.design is not None
        found.append(result.design.scenes[0].figures["snr"])
    assert found[1] >= found[0] * (1 - 1e-12)

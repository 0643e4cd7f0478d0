"""The search among complete cameras, held against enumeration: their pieces go together, and with nothing else."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import small_catalogues as small
from agreement import agree
from random_cases import Case, case, enumerated, in_batches, lamp, planted, ranked
from thorough import drawn

from uwopt.evaluation.design_model import DesignModel
from uwopt.forward.designs import Hardware, SceneSettings
from uwopt.forward.parts import Parts
from uwopt.solvers.exact.outline import Level, OutlineRows
from uwopt.solvers.exact.port_groups import port_tree

CASES = drawn((35, 48), tuple(range(100)))  # quickly enumerated; complete cameras stand among their feasible designs
BURNING = lamp("burning", kind="continuous", flux_lm=20_000.0, power_w=100.0)
FLASHING = lamp(
    "flashing", kind="flash", flash_energy_j=60.0, flash_efficacy_lm_s_per_j=35.0, flash_duration_us=500.0,
    recycle_s=0.2, charging_efficiency_frac=0.7,
)  # fmt: skip


def alone(lights: Any = (BURNING,), *, limits: dict[str, Any] | None = None, **camera: Any) -> Case:
    """One complete camera of 2448 x 2048 pixels of 12 bits, once a second for two hours."""
    size = {"resolution_x_px": 2448, "resolution_y_px": 2048, "bit_depth": 12, "pixel_pitch_um": 3.45}
    made = planted(
        "power", lights, {"min_snr_db": 10.0, "overlap": None, "frame_interval_s": 1.0},
        camera={"mounts": ("complete",), "complete": "whole", **size, **camera}, duration_h=2.0,
    )  # fmt: skip
    glass = replace(made.parts.lenses[0], mounts=("complete",), complete="whole")
    window = replace(made.parts.ports[0], complete="whole")
    return replace(made, parts=Parts(made.parts.cameras, (glass,), (window,), made.parts.lights))


@pytest.mark.parametrize(("batches", "seed"), in_batches(CASES), indirect=["batches"])
def test_search_among_complete_cameras_equals_enumeration(batches: str, seed: int) -> None:
    """Best designs, feasibility and account, with two complete cameras beside the others."""
    agree(case(seed, whole=True), case(seed, whole=True).solve()[1], ranked(enumerated(seed, whole=True)))


def test_pieces_with_other_parts_are_all_discarded_and_counted() -> None:
    """Of C cameras, L lenses and P ports with two complete ones, C L P + 2 go together of (C+2) (L+2) (P+2)."""
    for seed in CASES:
        made = case(seed, whole=True)
        parts = made.parts
        sizes = np.array([len(parts.cameras), len(parts.lenses), len(parts.ports)])
        torn = int(np.prod(sizes) - np.prod(sizes - 2) - 2)
        factor = made.problem().count_range[1] - made.problem().count_range[0] + 1
        factor *= len(parts.lights) * len(made.problem().mounts) * len(made.mission.vehicle.orientations)
        assert made.solve()[1].account.discarded["complete"] == torn * factor


def test_no_group_of_ports_loses_the_complete_camera_of_one_of_them() -> None:
    """What goes behind some port of a group may pass as a whole, and ports of complete cameras stand apart."""
    parts = small.with_completes(np.random.default_rng(3), case(CASES[0]).parts, count=12)
    problem = case(CASES[0]).problem(parts)
    of_camera, of_lens, of_port = problem.ties
    pair = np.argwhere(of_camera[:, None] == of_lens[None, :])
    for groups in port_tree(problem):
        level = Level(problem, groups)
        for number, (start, stop) in enumerate(zip(groups.start, groups.stop, strict=True)):
            held = of_port[groups.order[start:stop]]
            assert (held > 0).all() or not held.any()
            rows = OutlineRows(pair[:, 0], pair[:, 1], np.ones(len(pair), bool), np.full(len(pair), number))
            passes = dict(level.rules(rows, level.imagers(rows)))["complete"]
            assert np.all(passes | ~np.isin(of_camera[pair[:, 0]], held))


def test_a_camera_that_fires_no_lamp_gets_one_that_burns() -> None:
    """The flash takes less power; only a camera that fires it may have it."""
    fires, not_ = (alone((BURNING, FLASHING), fires_lamps=may).solve()[1].best[0] for may in (True, False))
    assert (fires.light, not_.light) == (1, 0)
    assert not alone((FLASHING,), fires_lamps=False).solve()[1].best


def test_images_of_the_whole_mission_fit_on_the_card() -> None:
    """2448 x 2048 x 1.5 byte once a second for 7200 s are 54.146 GB, by hand."""
    assert alone(storage_gb=54.2).solve()[1].best
    small_card = alone(storage_gb=54.1).solve()[1]
    assert not small_card.best and small_card.account.discarded["card_gb"]


@pytest.mark.parametrize(
    ("camera", "light", "name", "value", "limit"),
    [
        ({"storage_gb": 54.2}, BURNING, "card_gb", 54.1458, 54.2),
        ({"storage_gb": 54.1}, BURNING, "card_gb", 54.1458, 54.1),
        ({"run_time_h": 2.1}, BURNING, "run_time_h", 2.1, 2.0),
        ({"run_time_h": 1.9}, BURNING, "run_time_h", 1.9, 2.0),
        ({"fires_lamps": False}, FLASHING, "lamp_trigger", 0.0, 1.0),
    ],
)
def test_design_says_what_its_card_and_its_trigger_miss(
    camera: dict[str, Any], light: Any, name: str, value: float, limit: float
) -> None:
    """As evaluation reads it: 2448 * 2048 * 1.5 * 7200 byte = 54.1458 GB."""
    problem = alone((light,), **camera).problem()
    model = DesignModel(problem, Hardware(0, 0, 0, True, 0, 1, problem.mounts[0]))
    settings = model.settings(0, SceneSettings(gain=1.0))
    margin = {m.requirement: m for m in model.margins(0, settings, model.figures(0, settings))}[name]
    assert (float(margin.value[0]), float(margin.limit[0])) == pytest.approx((value, limit), rel=1e-4)
    assert bool(margin.satisfied[0]) is (value <= limit if name == "card_gb" else value >= limit)


def test_the_timer_limits_the_rate() -> None:
    """One image a second from a timer of a second, none from one of 1.1 s."""
    assert alone(min_interval_s=1.0).solve()[1].best
    assert not alone(min_interval_s=1.1).solve()[1].best

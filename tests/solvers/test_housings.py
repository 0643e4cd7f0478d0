"""The search among housings, held against enumeration: which fit, which another one makes needless, and the account."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import random_cases
from agreement import agree, combinations
from random_cases import RICH, Case, case, enumerated, in_batches, ranked
from thorough import drawn

from uwopt.catalog.records import Housing, exact
from uwopt.forward.enclosures import fits_inside
from uwopt.solvers.exact.outline import Level, OutlineRows
from uwopt.solvers.exact.port_groups import port_tree

CASES = drawn(RICH[1:3], tuple(range(100)))


def needless(case_: Case, found: dict[tuple[int, ...], Any], key: tuple[int, ...]) -> bool:
    """Whether the same parts do as well in another housing, which costs and weighs no more."""
    parts = case_.parts

    def worth(port: int) -> tuple[float, float, float]:
        one = parts.ports[port].housing
        return one.price.value, one.price.value, one.mass_g.value

    camera, lens, port, light = key
    for other in found:
        twin = other[:2] == (camera, lens) and other[3] == light and other[2] != port
        if twin and parts.ports[other[2]].id == parts.ports[port].id:
            mine, its = worth(port), worth(other[2])
            if all(a <= b for a, b in zip(its, mine, strict=True)) and (its != mine or other[2] < port):
                return True
    return False


def worth_having(case_: Case, hardware: list[Any]) -> dict[tuple[int, ...], Any]:
    """What enumeration finds, without what another housing makes needless."""
    found = ranked(hardware)
    return {key: best for key, best in found.items() if not needless(case_, found, key)}


@pytest.mark.parametrize(("batches", "seed"), in_batches(CASES), indirect=["batches"])
def test_search_among_housings_equals_enumeration(batches: str, seed: int) -> None:
    """Best designs, feasibility and account, with three housings to each port."""
    housed, found = case(seed, housed=True), enumerated(seed, housed=True)
    agree(housed, housed.solve()[1], worth_having(housed, found))


@pytest.mark.usefixtures("batches")
def test_ports_that_are_left_when_a_search_ends_are_counted_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three parts of each kind: whole groups of ports wait behind a row when nothing can be better any more."""
    monkeypatch.setattr(random_cases, "THOROUGH", True)
    more = case.__wrapped__(17, housed=True)
    account = more.solve()[1].account
    assert account.adds_up() and account.total == combinations(more.problem())


def test_rules_of_housings_discard_something_in_these_cases() -> None:
    """Else the comparison above would say nothing of them."""
    discarded = [case(seed, housed=True).solve()[1].account.discarded for seed in CASES]
    for rule in ("housing", "better_housing"):
        assert any(one[rule] for one in discarded), rule


def test_no_group_of_ports_is_tighter_than_its_roomiest_housing() -> None:
    """What fits behind some port of a group may pass as a whole."""
    problem = case(CASES[0], housed=True).problem()
    n_camera, n_lens = len(problem.parts.cameras), len(problem.parts.lenses)
    camera, lens = (index.ravel() for index in np.meshgrid(range(n_camera), range(n_lens), indexing="ij"))
    fits = fits_inside(problem.cameras.take(camera), problem.lenses.take(lens), 0.0, problem.ports)
    assert fits.any() and not fits.all()
    for groups in port_tree(problem):
        level = Level(problem, groups)
        for number, (start, stop) in enumerate(zip(groups.start, groups.stop, strict=True)):
            rows = OutlineRows(camera, lens, np.ones(len(camera), bool), np.full(len(camera), number))
            some = fits[:, groups.order[start:stop]].any(axis=1)
            assert np.all(level.may_fit(rows) | ~some)


def test_a_cap_behind_whose_rim_the_tube_is_narrower_is_refused() -> None:
    # 72 mm inside and open over 100 mm: the pupil stands 51.8 mm behind the rim. The lens of 8 mm sees the corner of
    # the sensor at tan t; a mouth of 2 * 51.8 mm * tan t lets it pass, and a hair less does not, though it costs less.
    made = random_cases.planted("cost", (random_cases.lamp("on", kind="continuous", flux_lm=2e4, power_w=200.0),), {})
    cap = replace(
        made.parts.ports[0], outer_radius_mm=80.0, thickness_mm=exact(8.0), clear_diameter_mm=exact(100.0)
    )
    camera = made.parts.cameras[0]
    half_mm = np.hypot(camera.resolution_x_px, camera.resolution_y_px) * camera.pixel_pitch_um * 1e-3 / 2.0
    needed_mm = 2.0 * np.sqrt(72.0**2 - 50.0**2) * half_mm / 8.0
    assert needed_mm < 100.0  # else the rim itself cuts the view

    def tube(name: str, inner_mm: float, price: float) -> Housing:
        return Housing(
            name, inner_diameter_mm=inner_mm, inner_length_mm=900.0, outer_diameter_mm=exact(120.0),
            outer_length_mm=exact(950.0), price=exact(price), mass_g=exact(1000.0), depth_rating_m=6000.0,
        )  # fmt: skip

    housings = (tube("narrow", 0.999 * needed_mm, 100.0), tube("wide", 1.001 * needed_mm, 900.0))
    parts = replace(made.parts, ports=tuple(replace(cap, housing=one) for one in housings))
    _, outcome = replace(made, parts=parts).solve(top=2)
    assert [parts.ports[found.port].housing.id for found in outcome.best] == ["wide"]
    assert outcome.account.discarded["housing"] > 0

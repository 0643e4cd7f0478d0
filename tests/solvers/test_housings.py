"""The search among housings, held against enumeration: which fit, which another one makes needless, and the account."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import random_cases
from agreement import agree, combinations
from random_cases import RICH, Case, case, enumerated, ranked
from thorough import drawn

from uwopt.forward.enclosures import fits_inside
from uwopt.solvers.exact.outline import Level, OutlineRows, port_tree

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


@pytest.mark.usefixtures("batches")
@pytest.mark.parametrize("seed", CASES)
def test_search_among_housings_equals_enumeration(seed: int) -> None:
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

"""Imagers are bounded in the order of what they are at best without any light, and none that cannot matter."""

from __future__ import annotations

from typing import Any

import pytest
from one_of_each import one, with_parts
from test_any_lighting import POWER, bounds_of, reef

from uwopt.deadline import OutOfTimeError
from uwopt.solvers.exact import search as exact_search
from uwopt.solvers.exact.bounds import Bounds
from uwopt.solvers.exact.search import Search


def search_of(min_snr_db: float) -> Search:
    """Of the reef with an SNR."""
    return Search(bounds_of(reef(min_snr_db)).problem, POWER, top=1)


def one_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Imagers are bounded one by one, then as many again."""
    for name in ("FIRST_BATCH", "FIRST_BOUNDED"):
        monkeypatch.setattr(exact_search, name, 1)


def test_imagers_that_cannot_beat_what_is_found_are_not_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are counted as discarded by their bound, and what is found is as good as where all are bounded."""
    best = search_of(20.0).whole().best[0]
    bounded, of_nodes = set[int](), Bounds.of_nodes

    def counting(self: Bounds, k: int, rows: Any, *more: Any) -> Any:
        bounded.update(rows.tolist())
        return of_nodes(self, k, rows, *more)

    monkeypatch.setattr(Bounds, "of_nodes", counting)
    monkeypatch.setattr(Bounds, "can_refine", lambda self: False)
    one_at_a_time(monkeypatch)
    outcome = search_of(20.0).whole()
    assert outcome.best[0].minimised == pytest.approx(best.minimised, rel=1e-6)
    assert outcome.account.adds_up()
    assert 0 < len(bounded) < len(outcome.imagers)


def test_what_is_not_bounded_when_time_is_up_bounds_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    """By what it is at best without any light, which is less than what the first imager needs with it."""
    best, of_nodes, asked = search_of(30.0).whole().best[0], Bounds.of_nodes, list[int]()

    def once(self: Bounds, k: int, rows: Any, *more: Any) -> Any:
        asked.append(k)
        if asked.count(k) > 1:
            raise OutOfTimeError
        return of_nodes(self, k, rows, *more)

    monkeypatch.setattr(Bounds, "of_nodes", once)
    monkeypatch.setattr(Bounds, "leaves_dark", lambda self, rows, *_: rows < 0)
    one_at_a_time(monkeypatch)
    search = search_of(30.0)
    outcome = search.run()
    assert not outcome.complete and not outcome.best
    assert 0.0 < outcome.lower_bound <= float(search.imagers.camera_power_w.max()) < best.minimised
    assert outcome.account.adds_up()


def test_where_nothing_bounded_waits_those_that_cannot_matter_end_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second camera takes three times what all of the first system does: no bound of it is asked for."""
    one_at_a_time(monkeypatch)
    monkeypatch.setattr(exact_search, "TOO_FEW_TO_BOUND", 0)
    outcome = with_parts(one("power"), cameras=[{"power_w": 1000.0}]).solve(top=1)[1]
    assert outcome.complete and outcome.best[0].camera == 0
    assert outcome.account.adds_up() and outcome.account.discarded["bound"] >= 1

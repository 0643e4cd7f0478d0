"""The exact search's proof attacked: bounds that must hold, an account that must add up, an audit that can fail."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import small_catalogues as small
from random_cases import FEW, Case, case, lamp, planted, solved
from thorough import drawn

from uwopt.catalog.records import exact
from uwopt.deadline import Deadline
from uwopt.forward.assembly import load_catalog
from uwopt.forward.problem import Problem
from uwopt.objectives.objective import Objective
from uwopt.solvers.exact import search as exact_search
from uwopt.solvers.exact.account import Outcome
from uwopt.solvers.exact.audit import audit
from uwopt.solvers.exact.certificate import certificate
from uwopt.solvers.exact.imagers import enumerate_imagers
from uwopt.solvers.exact.light_tables import FieldTables
from uwopt.solvers.exact.search import Search
from uwopt.solvers.recommend import seek

# ---------------------------------------------------------------- bounds and the audit


@pytest.mark.parametrize("seed", drawn(range(0, 40, 6), range(300)))
def test_bound_of_the_signal_is_a_bound(seed: int) -> None:
    """No image gets more light than its bound says: flat and dome, wide and long, narrow beams, turbid water."""
    rng = np.random.default_rng(seed)
    parts, plain = small.parts(rng), small.mission(rng)
    plain |= {"physics": "full", "requirements": {"frame_interval_s": 1.0}, "limits": {}}
    plain["vehicle"] |= {
        "light_baseline_m": small.pick(rng, [0.0, 0.5, 2.0]),
        "light_tilt_deg": small.pick(rng, [-20.0, 0.0, 20.0, 40.0]),
    }
    angles = [6.0, 12.0, 20.0, 40.0, 80.0, 120.0]
    lights = tuple(replace(p, beam_angle_deg=exact(small.pick(rng, angles))) for p in parts.lights)
    lenses = tuple(
        replace(
            p, mounts=("C", "S"), image_circle_mm=20.0, focal_length_mm=small.pick(rng, [2.5, 4.0, 8.0, 16.0])
        )
        for p in parts.lenses
    )
    problem = Problem(small.loaded(plain), replace(parts, lights=lights, lenses=lenses), paper=False)
    imagers = enumerate_imagers(problem)
    if len(imagers) == 0:
        pytest.skip("no imager")
    tables, rows = FieldTables(problem, imagers), rng.permutation(len(imagers))[:5]
    for index, scene in enumerate(problem.scenes):
        for lighting in tables.lightings:
            found = tables.exact(index, lighting, rows, veils="none").signal_e
            for altitude in range(len(scene.range_m)):
                bound = tables.bound(index, lighting, altitude, rows)
                assert (found[:, altitude] <= bound * (1 + 1e-6)).all(), (lighting, altitude)


def sabotaged(case_: Case, monkeypatch: pytest.MonkeyPatch, share: float) -> tuple[Search, Outcome]:
    """A search whose signal bounds are a share of what they should be."""
    honest = FieldTables.bound
    monkeypatch.setattr(FieldTables, "bound", lambda self, *a, **k: share * honest(self, *a, **k))
    for name, value in (("FIRST_BATCH", 1), ("LARGEST_BATCH", 1), ("TOO_FEW_TO_BOUND", 0)):
        monkeypatch.setattr(exact_search, name, value)
    return case_.solve(top=1)


def one_camera_two_lights() -> Case:
    """A bright and a dim lamp: the dim one is enough and draws far less."""
    bright = lamp("bright", flux_lm=1e6, power_w=2e4, beam_angle_deg=90.0)
    dim = lamp("dim", flux_lm=2e4, power_w=100.0, beam_angle_deg=60.0)
    return planted("power", (bright, dim), {"max_blur_px": 1.0, "min_snr_db": 25.0})


def test_audit_finds_what_a_wrong_bound_discards(monkeypatch: pytest.MonkeyPatch) -> None:
    """With bounds far too low the better lamp is thrown away, and the audit says so."""
    case_ = one_camera_two_lights()
    search, outcome = sabotaged(case_, monkeypatch, 0.02)
    assert [case_.parts.lights[f.light].id for f in outcome.best] == ["bright"]
    report = audit(search, case_.objective, count=20, seed=0, best_value=outcome.best[0].minimised)
    assert not report["passed"]
    assert {found["light"] for found in report["better"]} == {"dim"}


def test_audit_of_an_honest_search_passes() -> None:
    """The same catalogue without sabotage: the dim lamp wins and nothing discarded is better."""
    case_ = one_camera_two_lights()
    search, outcome = case_.solve(top=1)
    assert [case_.parts.lights[f.light].id for f in outcome.best] == ["dim"]
    assert audit(search, case_.objective, count=20, seed=0, best_value=outcome.best[0].minimised)["passed"]


@pytest.mark.parametrize("seed", drawn(FEW[2:], FEW))
def test_audit_passes_on_random_cases(seed: int) -> None:
    """What an honest search discards does not hold anything better, nor anything feasible if it found nothing."""
    search, outcome = case(seed).solve(top=1)
    best = outcome.best[0].minimised if outcome.best else None
    report = audit(search, case(seed).objective, count=12, seed=seed, best_value=best)
    assert report["passed"], report["better"]


def test_audit_fails_when_a_sabotaged_search_calls_all_infeasible(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bounds of nothing: no design is found, and the audit finds some."""
    case_ = one_camera_two_lights()
    search, outcome = sabotaged(case_, monkeypatch, 1e-9)
    assert outcome.best == []
    assert not audit(search, case_.objective, count=20, seed=0, best_value=None)["passed"]


# ---------------------------------------------------------------- the account


@pytest.mark.parametrize("seed", FEW)
@pytest.mark.parametrize("calls", [0, 1, 2])
def test_account_adds_up_when_interrupted(seed: int, calls: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C in the middle of a batch: nothing is counted twice and the bound stays valid."""
    search = case(seed).searcher()
    honest, made = Search._evaluate_pairs, []

    def stopping(self: Search, *given: Any) -> None:
        if len(made) == calls:
            raise KeyboardInterrupt
        made.append(1)
        honest(self, *given)

    full = solved(seed)
    monkeypatch.setattr(Search, "_evaluate_pairs", stopping)
    outcome = search.run()
    assert outcome.account.adds_up()
    if full.best:
        assert outcome.lower_bound <= full.best[0].minimised + 1e-9 * abs(full.best[0].minimised)
    assert outcome.complete == (outcome.account.discarded.get("not_reached", 0) == 0)


@pytest.mark.parametrize("seed", FEW)
def test_a_search_without_time_claims_nothing(seed: int) -> None:
    """A deadline of zero leaves a bound that the optimum respects, and an account that adds up."""
    full, outcome = solved(seed), case(seed).solve(deadline=Deadline.after(0.0))[1]
    assert outcome.account.adds_up()
    if full.best and not outcome.complete:
        assert outcome.lower_bound <= full.best[0].minimised


def test_certificate_adds_up_over_the_catalogue() -> None:
    """Every combination loaded is evaluated or discarded by one rule, selection included."""
    mission = small.loaded(
        {
            "practice": "bare", "objective": "power", "physics": "paper", "limits": {"power_w": 60.0},
            "requirements": {"overlap": 0.3, "max_blur_px": 1.0, "min_snr_db": 25.0, "max_gsd_mm": 2.0},
            "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3, "light_count": [1, 2]},
            "scenes": [{"water": "II", "seafloor": 0.2, "depth_m": 300.0}],
            "catalog": {"generic": "never"},
        }
    )  # fmt: skip
    objective = Objective.of("power")
    sought = seek(mission, load_catalog(mission), objective, generic="never", top=3)
    proof = certificate(sought.selection, sought.problem, sought.outcome, objective)
    catalog = sought.selection.catalog
    sizes = [len(parts) for parts in (catalog.cameras, catalog.lenses, catalog.ports, catalog.lights)]
    assert proof.complete and proof.adds_up()
    assert proof.loaded == math.prod(sizes) * 2 * 2  # two numbers of lights, two orientations

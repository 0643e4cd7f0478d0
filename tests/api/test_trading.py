"""`uwopt.pareto`: what it says of bad input, of fronts cut short, empty or of one point, and what its result holds.

Points are held against `evaluate_design` by the front's own tests; here picks, names, methods and JSON are tried.
"""

from __future__ import annotations

import json
import math
import os
import select
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import uwopt
from uwopt.api.front_asked import checked_objectives
from uwopt.api.front_found import check_point_claim, history, reference
from uwopt.api.trading import ParetoCall, here_alone
from uwopt.api.watch import STAGES, Watch
from uwopt.errors import MissionError, SolverError
from uwopt.objectives.axes import Axes, Frame
from uwopt.objectives.own import OwnObjective
from uwopt.results.basis import WhyNothing
from uwopt.results.front import FrontObjective, FrontResult
from uwopt.solvers.beside import cores, side_by_side

PROBLEMS = Path(__file__).parents[2] / "problems"
MISSION = PROBLEMS / "mbari-lass-2013.yaml"  # few combinations
TRIPLE = ("power", "cost", "snr_db")
PLAIN = {"physics": "paper"}  # where nothing depends on it: of runs cut short, empty or made twice
pytestmark = pytest.mark.usefixtures("unhurried")


def mission(**changes: Any) -> dict[str, Any]:
    """The mission as plain values, sections merged with changes."""
    plain = uwopt.load_mission(MISSION).to_dict(absolute_paths=True)
    for section, values in changes.items():
        plain[section] = {**plain[section], **values} if isinstance(values, dict) else values
    return plain


@pytest.fixture(scope="module")
def exact(unhurried: None) -> FrontResult:
    """The exact front beside a short one of NSGA-II."""
    return uwopt.pareto(MISSION, objectives=TRIPLE, solver=("exact", "nsga2"), seed=3)


# ---------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"objectives": ["power"]}, r"one objective has no front.*uwopt solve"),
        ({"objectives": []}, r"0 objectives have no front"),
        ({"objectives": "power,cost,mass,gsd_mm"}, r"4 objectives have no front"),
        ({"objectives": ["power", "costs"]}, r"'costs' is no figure.*did you mean cost\?"),
        ({"objectives": ["power", "Power "]}, r"power stands twice"),
        ({"objectives": ["power", len, max, min]}, r"4 are named; a front has two or three"),
        ({"objectives": [len]}, r"1 are named; a front has two or three"),
        ({"objectives": ["pwoer", len]}, r"'pwoer' is no figure.*did you mean power\?"),
        ({"objectives": ["cost", len, " Cost"]}, r"cost stands twice"),
        ({"seconds": -1.0}, r"seconds = -1.0 is no number of seconds; give None for no limit"),
        ({"seconds": math.nan}, r"seconds = nan is no number of seconds; give None for no limit"),
        ({"seed": -1}, r"seed = -1 is no whole number from 0"),
        ({"solver": "nsga22"}, r"solver 'nsga22' is not known; did you mean nsga2\?"),
        ({"solver": "magic"}, r"solver 'magic' is not known; there are exact, nsga2"),
        ({"solver": []}, r"solver: none is named"),
        ({"solver": ["exact", "exat"]}, r"solver 'exat' is not known; did you mean exact\?"),
        ({"objectives": ["snr_db", "information"], "solver": "exact"}, r"both depend on the settings.*nsga2"),
        ({"objectives": ["cost", len, len]}, r"len stands twice"),
    ],
)
def test_bad_input_is_told_with_a_way_out(options, message):
    with pytest.raises(MissionError, match=message):
        uwopt.pareto(MISSION, **options)


@pytest.mark.parametrize("name", ["information", "Information", " information "])
def test_information_needs_a_footprint_however_it_is_written(name):
    plain = mission(requirements={"frame_interval_s": 2.0})
    for key in ("min_swath_m", "overlap"):
        plain["requirements"].pop(key, None)
    with pytest.raises(MissionError, match="information grows without end"):
        uwopt.pareto(plain, objectives=["power", name], solver="exact")


def test_information_is_unknown_to_physics_paper():
    with pytest.raises(MissionError, match="physics paper"):
        uwopt.pareto(MISSION, objectives=["power", "information"], physics="paper")


@pytest.mark.parametrize(
    "own", [lambda f: f["no_such"], lambda f: f["cost"] * np.nan, lambda f: f["cost"] + np.inf]
)
def test_fault_of_an_own_function_is_told(own):
    with pytest.raises(MissionError, match="objective <lambda>"):
        uwopt.pareto(MISSION, objectives=["cost", own], solver="nsga2")


# ---------------------------------------------------------------- the result


def test_points_are_named_in_order_and_no_two_are_alike(exact):
    assert exact.status == "complete"
    assert [p.id for p in exact.points] == [f"p{n + 1}" for n in range(len(exact.points))]
    power = [p.values["power"] for p in exact.points]
    assert power == sorted(power)
    values = np.array([[p.values[name] for name in TRIPLE] for p in exact.points])
    for row in range(len(values)):
        near = np.abs(values - values[row]) <= 1e-3 * np.maximum(np.abs(values), np.abs(values[row]))
        assert near.all(axis=1).sum() == 1


def test_points_of_one_curve_share_their_hardware(exact):
    hardware = {}
    for point in exact.points:
        hardware.setdefault(point.curve, []).append(repr(point.design.hardware))
    assert all(len(set(rows)) == 1 for rows in hardware.values())
    assert len({rows[0] for rows in hardware.values()}) == len(hardware)


def place_in_box(front, point):
    """Of a point in the box of the whole front: 0 is the best of an axis, 1 its worst; logarithms of power and cost."""
    box, unit = front.reference, []
    for name in TRIPLE:
        scaled = math.log if box["log"][name] else float
        best, worst, own = (scaled(v) for v in (box["ideal"][name], box["nadir"][name], point.values[name]))
        unit.append((own - best) / (worst - best))
    return unit


def test_picks_are_what_their_definitions_say(exact):
    named = {pick.name: exact.point(pick.name) for pick in exact.picks}
    assert list(named) == ["cheapest", "least power", "best image", "knee"]
    for name, figure, best in (
        ("cheapest", "cost", min), ("least power", "power", min), ("best image", "snr_db", max),
    ):  # fmt: skip
        wanted = best(p.values[figure] for p in exact.points)
        tied = [p for p in exact.points if p.values[figure] == pytest.approx(wanted, rel=1e-3)]
        chosen = min(tied, key=lambda p: sum(place_in_box(exact, p)))
        assert named[name].id == chosen.id
        told = next(pick.definition for pick in exact.picks if pick.name == name)
        assert told.endswith(", and of those within 0.1 % of it the best in the other objectives") == (len(tied) > 1)
    knee = next(pick.definition for pick in exact.picks if pick.name == "knee")
    assert knee.endswith("(logarithms of power and cost)")  # and of no other: the third is in decibels
    # the knee by hand: nearest to the best corner
    far = {p.id: math.hypot(*place_in_box(exact, p)) for p in exact.points}
    assert named["knee"].id == min(far, key=lambda name: far[name])


def test_figures_of_a_point_are_its_values(exact):
    for point in exact.points[:5]:
        assert point.values["power"] == pytest.approx(point.design.totals["power_w"], rel=1e-12)
        assert point.values["cost"] == point.design.totals["cost"]["value"]
        assert point.design.feasible


def test_account_adds_up_and_the_bound_holds(exact):
    proof = exact.certificate
    assert proof["complete"]
    assert proof["loaded"] == proof["evaluated"] + sum(item["count"] for item in proof["discarded"])
    assert proof["hypervolume"] <= proof["hypervolume_bound"]
    assert 0.0 <= proof["gap_rel"] <= 1e-3


def test_methods_are_measured_in_one_frame(exact):
    mine, peer = exact.methods
    assert (mine.name, peer.name, peer.seed) == ("exact", "nsga2", 3)
    assert mine.hypervolume_ratio == 1.0
    assert mine.igd_plus == 0.0
    assert peer.hypervolume <= 1.001 * mine.hypervolume_bound
    assert peer.igd_plus >= 0.0
    assert exact.peers
    assert {p["method"] for p in exact.peers} == {"nsga2"}


def test_reference_is_a_tenth_beyond_the_worst_corner(exact):
    box = exact.reference
    assert box["log"] == {"power": True, "cost": True, "snr_db": False}
    for name in TRIPLE:
        ideal, nadir, point = (box[key][name] for key in ("ideal", "nadir", "point"))
        if box["log"][name]:
            ideal, nadir, point = (math.log(v) for v in (ideal, nadir, point))
        assert point - ideal == pytest.approx(1.1 * (nadir - ideal), rel=1e-6)
    assert box["ideal"]["snr_db"] > box["nadir"]["snr_db"]


def test_json_holds_no_nan_and_comes_back(exact):
    text = exact.to_json()
    assert "NaN" not in text
    assert "Infinity" not in text
    back = FrontResult.from_dict(json.loads(text))
    assert back.to_dict() == json.loads(text)
    assert back.point("knee").values == exact.point("knee").values


def test_table_has_a_row_a_point_and_says_all(exact):
    table = exact.frame()
    assert len(table) == len(exact.points)
    wanted = {
        "point",
        "pick",
        "curve",
        "method",
        "camera",
        "lens",
        "port",
        "light",
        "light_count",
        "orientation",
    }
    wanted |= {f"objective: {name}" for name in TRIPLE} | {"set: f_number", "margin: min_snr_db", "snr_db"}
    assert wanted <= set(table.columns)
    assert table.columns.is_unique
    assert set(table["point"]) == {p.id for p in exact.points}
    assert set(table.loc[table["pick"] != "", "point"]) == {pick.point for pick in exact.picks}


# ---------------------------------------------------------------- nothing, one point, cut short


def test_what_nothing_meets_is_infeasible_with_reasons(monkeypatch):
    why = WhyNothing([], [], None)
    monkeypatch.setattr("uwopt.solvers.infeasible.why_nothing.why_nothing", lambda *given: why)
    result = uwopt.pareto(
        mission(requirements={"min_snr_db": 95.0}), objectives=["power", "cost"], solver="exact", **PLAIN
    )
    assert result.status == "infeasible"
    assert result.points == []
    assert result.picks == []
    assert result.infeasible == why
    assert "NaN" not in result.to_json()


@pytest.mark.usefixtures("undoubted")
def test_requirements_that_leave_one_point_are_told():
    best = uwopt.solve(MISSION, objective="cost", top=1).recommendation
    assert best is not None
    limits = {"cost": best.totals["cost"]["value"] * (1 + 1e-9), "cost_basis": "central"}
    only = {kind: [best.hardware[kind]["id"]] for kind in ("camera", "lens", "port", "light")}
    plain = mission(limits=limits, catalog={f"{k}es" if k == "lens" else f"{k}s": v for k, v in only.items()})
    result = uwopt.pareto(plain | {"confidence": 0.9}, objectives=["cost", "gsd_mm"], solver="exact")
    assert [w["path"] for w in result.warnings if w["code"] == "central_numbers"] == ["confidence"]
    assert len(result.points) == 1
    assert {pick.point for pick in result.picks} == {"p1"}
    assert any(w["code"] == "one_point" for w in result.warnings)
    assert "NaN" not in result.to_json()


def test_interrupted_it_keeps_what_was_found():
    told = []

    def once(share, what):
        told.append(what)
        if len(told) == 1:
            raise KeyboardInterrupt

    result = uwopt.pareto(
        MISSION, objectives=TRIPLE, solver=("exact", "nsga2"), progress=once, alternatives=True, **PLAIN
    )
    assert result.status == "interrupted"
    assert result.points and not result.alternatives and STAGES["alternatives"] not in told  # nor a new stage
    assert [m.name for m in result.methods] == ["exact"]  # who interrupts does not want the next solver
    assert result.certificate is not None
    assert not result.certificate["complete"]
    proof = result.certificate
    assert proof["loaded"] == proof["evaluated"] + sum(item["count"] for item in proof["discarded"])
    assert any(w["code"] == "interrupted" for w in result.warnings)


def test_interrupted_while_its_points_are_worked_out_it_keeps_them(monkeypatch):
    told, points = [], ParetoCall.points

    def once(*args):
        told.append(args)
        if len(told) == 1:
            raise KeyboardInterrupt
        return points(*args)

    monkeypatch.setattr(ParetoCall, "points", once)
    monkeypatch.setattr("uwopt.api.trading.PEER_S", 0.1)
    try:
        result = uwopt.pareto(MISSION, objectives=TRIPLE, solver=("exact", "nsga2"), **PLAIN)
    except KeyboardInterrupt:
        pytest.fail("the front is lost")
    assert result.status == "complete" and result.points  # the exact front
    assert [m.name for m in result.methods] == ["exact"]
    assert any(w["code"] == "interrupted" for w in result.warnings)


def test_a_front_does_not_tell_how_many_cores_worked_on_it():
    one, two = (front_of_cores(count) for count in (1, 2))
    assert {m.name for m in two.methods} == {"exact", "nsga2"} and two.peers
    for name in ("status", "points", "picks", "certificate", "warnings"):
        assert getattr(two, name) == getattr(one, name)
    assert {"exact", "nsga2", "evaluation"} <= set(two.timing_s)


def front_of_cores(count):
    with cores(count):
        return uwopt.pareto(MISSION, objectives=TRIPLE, solver=("exact", "nsga2"), seed=3, **PLAIN)


def test_a_copy_tells_no_progress():
    told: list[str] = []
    progress = here_alone(lambda share, what: told.append(what))
    here = os.getpid()

    def work() -> None:
        if os.getpid() == here:
            select.select([], [], [], 0.2)  # so that a copy has some to do
        else:
            progress(0.5, "from a copy")

    progress(0.0, "here")
    with cores(2):
        side_by_side([work] * 4, lists=[told])
    assert told == ["here"]


def test_out_of_time_it_claims_nothing():
    result = uwopt.pareto(MISSION, objectives=TRIPLE, solver="exact", seconds=1e-9)
    assert result.status == "stopped"
    assert result.points == []
    proof = result.certificate
    assert proof is not None
    assert not proof["complete"]
    assert proof["hypervolume_bound"] is None
    best = uwopt.solve(MISSION, objective="cost", top=1)
    assert result.parts_left is not None and result.parts_left == best.parts_left
    assert proof["loaded"] == proof["evaluated"] + sum(item["count"] for item in proof["discarded"])
    assert "NaN" not in result.to_json()


# ---------------------------------------------------------------- population solvers


def test_two_qualities_of_settings_are_left_to_the_population_solver():
    result = uwopt.pareto(MISSION, objectives=["snr_db", "information"], solver=("exact", "nsga2"), seed=5)
    assert result.seed == 5
    assert [m.name for m in result.methods] == ["nsga2"]
    assert result.certificate is None
    assert result.points
    assert {p.method for p in result.points} == {"nsga2"}


def test_own_objective_is_an_axis_of_the_result():
    worth = OwnObjective("swath_per_watt", lambda f: f["swath_m"] / f["power_w"], "maximise", "m/W")
    result = uwopt.pareto(MISSION, objectives=[" Cost", worth], solver=("exact", "nsga2"), **PLAIN)
    assert [(o.name, o.direction, o.unit, o.own) for o in result.objectives][1] == (
        "swath_per_watt",
        "maximise",
        "m/W",
        True,
    )
    for point in result.points:
        figures = point.design.scenes[0].figures
        assert point.values["swath_per_watt"] == pytest.approx(
            figures["swath_m"] / figures["power_w"], rel=1e-4
        )
    assert "NaN" not in result.to_json()


# ---------------------------------------------------------------- parts of it


def test_claim_that_the_model_does_not_bear_out_is_a_defect(exact):
    design = exact.points[0].design
    check_point_claim({"power": 10.0}, {"power": 10.0 * (1 + 1e-7)}, design)
    check_point_claim({"contrast": 0.5}, {"contrast": 0.5 * (1 + 2e-6)}, design)  # veils on other grids
    with pytest.raises(SolverError, match="claims power = 10"):
        check_point_claim({"power": 10.0}, {"power": 10.0 * (1 + 1e-5)}, design)


def test_reference_and_history_by_hand():
    frame = Frame.of(Axes(("power", "snr_db")), np.array([[1.0, -10.0], [100.0, -30.0]]))
    objectives = [FrontObjective("power", "minimise", "W"), FrontObjective("snr_db", "maximise", "dB")]
    box = reference(objectives, frame)
    assert box["ideal"] == pytest.approx({"power": 1.0, "snr_db": 30.0})
    assert box["nadir"] == pytest.approx({"power": 100.0, "snr_db": 10.0})
    assert box["point"] == pytest.approx({"power": 10.0**2.2, "snr_db": 8.0})
    assert box["log"] == {"power": True, "snr_db": False}
    # one point in the best corner fills the box; none fills nothing
    told = history([(0.5, np.empty((0, 2))), (1.0, np.array([[1.0, -30.0]]))], frame)
    assert told == [[0.5, 0.0], [1.0, pytest.approx(1.0)]]


def test_run_reads_names_as_axes_do():
    run = ParetoCall(
        uwopt.load_mission(MISSION),
        None,
        checked_objectives([" Power", "SNR-dB"]),
        Axes.of([" Power", "SNR-dB"]),
        ["exact"],
        0,
        Watch(),
    )
    assert run.objectives == ["power", "snr_db"]
    assert dict(run.builtin.weights) == {"power": 1.0, "snr_db": 1.0}

"""`whatif`: every point is the optimum that a search of its own finds, and systems change where they are said to."""

from __future__ import annotations

import csv
import json
import os
import select
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
import yaml
from typer.testing import CliRunner

import uwopt
from uwopt.api import certain_points, varied_work
from uwopt.api import varied as api_varied
from uwopt.api import whatif as api_whatif
from uwopt.api.searching import Searches
from uwopt.cli.app import app
from uwopt.deadline import NEVER, unheard
from uwopt.errors import MissionError
from uwopt.forward.assembly import load_catalog
from uwopt.mission.mission import Mission, load_mission
from uwopt.mission.varying import VariedMission
from uwopt.objectives.goal import goal_of
from uwopt.report.page.whatif import whatif_html
from uwopt.report.pictures.whatif_plots import whatif_figures
from uwopt.report.text.whatif_tables import opening, switch_text
from uwopt.results.design import UsedHardware, UsedPart
from uwopt.results.whatif import WhatIf, WhatIfPoint, WinningSystem
from uwopt.solvers import beside
from uwopt.solvers.beside import cores
from uwopt.solvers.confidence import search
from uwopt.solvers.recommend import with_fewest_lamps
from uwopt.solvers.warm.searches import Warm

PROBLEMS = Path(__file__).parents[2] / "problems"
#: Few parts of the reef's mission among which winners change with speed, water and budget.
FEW: dict[str, Any] = {
    "cameras": ["avt-alvium-1800-c-040m", "avt-alvium-1800-c-234m"],
    "lenses": ["computar-m1214-mp2", "thorlabs-mvl16m1"],
    "ports": ["blue-robotics-4-in-acrylic-end-cap-2026", "blue-robotics-4-in-dome-plastic-ring-2026"],
    "lights": ["arctic-rays-dragonfish-mini-strobe-65deg*"],
    "generic": "never",
}
ONE_VIEW = {"lenses": FEW["lenses"][1:], "ports": FEW["ports"][:1]}
SPEEDS = {"speed_m_s": [0.3, 0.45, 0.6, 1.05, 1.3]}


def reef(**changes: Any) -> Mission:
    """The reef with few parts, and no tolerance of altitude: one altitude instead of five."""
    base = load_mission(PROBLEMS / "reef-mosaic.yaml")
    vehicle = base.to_dict()["vehicle"] | {"altitude_tolerance_m": 0.0}
    return base.with_changes(**{"catalog": base.to_dict()["catalog"] | FEW, "vehicle": vehicle} | changes)


def alone(mission: Mission) -> float | None:
    """The optimum of a mission by a search that knows nothing of others."""
    goal = goal_of(mission)
    sought = Searches(load_catalog(mission), goal, 1).of(mission).sought
    best = sought.outcome.best
    return goal.reported(best[0].minimised) if best else None


@pytest.fixture(scope="module")
def over_speed() -> WhatIf:
    """The optimum over speed in two waters."""
    return uwopt.whatif(reef(), SPEEDS | {"water": ["IB", "II"]})


def test_each_point_is_the_optimum_of_its_own_search(over_speed):
    base = VariedMission(reef(), {})
    keys = [base.varied("speed_m_s", "0.3,1"), base.varied("water", "IB,II")]
    assert len({point.system for point in over_speed.points}) > 1
    for point in over_speed.points:
        mission = base.with_values(dict(zip(keys, point.values, strict=True)))
        assert point.objective == pytest.approx(alone(mission), rel=1e-6)  # the search's claim agrees so nearly


def test_a_table_does_not_tell_how_many_cores_made_it(over_speed):
    """Its waters are solved side by side."""
    with cores(2):
        other = uwopt.whatif(reef(), SPEEDS | {"water": ["IB", "II"]})
    told = [{name: value for name, value in vars(one).items() if name != "timing_s"} for one in (over_speed, other)]
    assert told[0] == told[1]


def test_systems_of_waters_that_are_solved_side_by_side_are_numbered_together(over_speed):
    """Each water has one of its own here."""
    table = uwopt.whatif(reef(), {"speed_m_s": [1.3, 1.31], "water": ["IB", "II"]})
    assert [table.points[place].system for place in (0, 1)] == [0, 1]
    assert table.systems == [over_speed.systems[point.system] for point in over_speed.points[-2:]]


def test_speed_is_not_stricter_where_area_is_asked_for():
    base = load_mission(PROBLEMS / "reef-mosaic.yaml")
    asked = base.to_dict()["requirements"] | {"min_area_m2_h": 100.0}
    for mission, sign in ((base, 1), (base.with_changes(requirements=asked), 0)):
        made = VariedMission(mission, {})
        assert made.varied("speed_m_s", "1,2").stricter(made.base) == sign


def test_systems_change_where_the_table_says(over_speed):
    assert over_speed.switches
    base = VariedMission(reef(), {})
    speed, water = base.varied("speed_m_s", "0.3,1"), base.varied("water", "IB,II")
    goal = goal_of(base.base)
    for switch in over_speed.switches:
        assert switch.proven
        assert 0.0 < switch.high - switch.low < 0.01
        names = []
        for value in (switch.low, switch.high):
            mission = base.with_values({speed: value, water: switch.others[1]})
            sought = with_fewest_lamps(Searches(load_catalog(mission), goal, 1).of(mission).sought)
            found, parts = sought.outcome.best[0], sought.problem.parts
            names.append((parts.cameras[found.camera].id, parts.lights[found.light].id, found.count))
        told = [over_speed.systems[one] for one in (switch.first, switch.second)]
        assert names == [(one.camera, one.light, one.light_count) for one in told]


def test_systems_that_win_between_points_alone_are_counted_and_told_so(over_speed):
    """`4 systems win somewhere` stood beside a chart in which 8 do, and a system was listed that `wins at 0`."""
    switch = replace(over_speed.switches[0], second=None, low=0.2, high=0.393)
    one = replace(over_speed, points=over_speed.points[:1], switches=[switch], systems=over_speed.systems[:1])
    assert "beyond some" in switch_text(one, switch) and "between 0.2" in switch_text(one, switch)
    twice = replace(over_speed, switches=[replace(switch, first=97, second=98)])
    won = len({point.system for point in over_speed.points} - {None})
    assert f"{won + 2} systems win somewhere" in " ".join(opening(twice))


def test_where_nothing_fits_any_more_is_found():
    table = uwopt.whatif(reef(), {"min_snr_db": [30.0, 60.0]})
    assert [point.status for point in table.points] == ["optimal", "infeasible"]
    last = table.switches[-1]
    assert last.second is None
    base = VariedMission(reef(), {})
    key = base.varied("min_snr_db", "30,60")
    assert alone(base.with_values({key: last.low})) is not None
    assert alone(base.with_values({key: last.high})) is None


def test_a_map_has_switches_along_both_keys():
    table = uwopt.whatif(reef(), {"speed_m_s": [0.4, 1.3], "altitude_m": [1.6, 2.0]})
    assert {switch.key for switch in table.switches} >= {"speed_m_s"}
    assert [point.values for point in table.points] == [[0.4, 1.6], [0.4, 2.0], [1.3, 1.6], [1.3, 2.0]]
    assert len({repr(switch) for switch in table.switches}) == len(table.switches)
    assert "Which system wins where" in whatif_html(table)


def test_where_systems_take_over_between_two_halves_of_a_table_is_found_as_in_one(monkeypatch):
    """Altitudes are solved in two halves, side by side; between them another system wins."""
    tables = []
    for fewest in (1, 2):
        monkeypatch.setattr(api_varied, "FEWEST", fewest)
        tables.append(uwopt.whatif(reef(catalog=FEW | ONE_VIEW), {"altitude_m": [1.4, 2.4]}))
    halves, whole = (
        [(one.low, one.high, one.proven, one.first and table.systems[one.first]) for one in table.switches]
        for table in tables
    )
    assert halves == whole and all(proven for *_, proven, _ in whole) and len(whole) > 0


def test_spider_moves_one_quantity_at_a_time(monkeypatch):
    monkeypatch.setattr(varied_work, "SPIDER_FACTORS", (0.8, 1.0, 1.2))
    mission = load_mission({
        "practice": "bare", "scene": {"water": "II", "seafloor": "coral", "depth_m": 30},
        "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, "light_baseline_m": 0.8, "light_count": 2},
        "requirements": {"frame_interval_s": 2.0, "min_snr_db": 30.0},
        "catalog": FEW | ONE_VIEW | {"cameras": FEW["cameras"][1:]},
    })  # fmt: skip
    table = uwopt.whatif(mission, spider=True)
    lines = {line.key: line for line in table.spider}
    assert {"vehicle.altitude_m", "vehicle.speed_m_s", "requirements.min_snr_db"} <= lines.keys()
    best = {point.values[0]: point.objective for point in lines["requirements.min_snr_db"].points}
    assert best[1.0] == pytest.approx(alone(mission), rel=1e-6)
    quieter = mission.with_changes(requirements=mission.to_dict()["requirements"] | {"min_snr_db": 24.0})
    assert best[0.8] == pytest.approx(alone(quieter), rel=1e-6)
    assert all(len(line.points) == 3 for line in table.spider if line.key.startswith("requirements"))


# ---------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ({"speed": "0.2:2:4"}, ["'speed' is no key", "did you mean speed_m_s?"]),
        ({"speed_m_s": "2:2:5"}, ["speed_m_s=2:2:5", "empty range"]),
        ({"speed_m_s": "0.2:2:0"}, ["empty range"]),
        ({"speed_m_s": []}, ["empty range"]),
        ({"speed_m_s": "0.2:2"}, ["is no range", "from:to:how many"]),
        ({"water": "I,,II"}, ["a value is empty"]),
        ({"water": "I,I"}, ["'I' stands twice"]),
        ({"water": "I,VI"}, ["vary water: ", "'VI' is not one of I, IA"]),
        ({"max_gain_db": "1,2"}, ["requirements.max_gain_db or reserve.max_gain_db"]),
        ({"altitude_m": "0.1:0.2:2"}, ["at altitude_m = 0.1", "altitude_tolerance_m = 0.25 is not below"]),
        ({"depth_rating_m": "5:20:4"}, ["4 of 4 points", "raise it"]),
        ({"speed_m_s": "1:2:3", "water": "I,II", "cost": "1,2"}, ["3 keys", "leave some out"]),
        ({}, ["no key is varied"]),
        ({"speed_m_s": [1.0, None]}, ["null is no value"]),
        ({"speed_m_s": 0.2}, ["vary speed_m_s: has one value"]),
        ("speed_m_s=0.2:2:7", ["is no mapping"]),
    ],
)  # fmt: skip
def test_bad_ranges_are_told_in_one_message(vary, words):
    with pytest.raises(MissionError) as fault:
        uwopt.whatif(PROBLEMS / "reef-mosaic.yaml", vary)
    assert len(fault.value.faults) == 1
    for word in words:
        assert word in str(fault.value)


def test_a_number_that_no_mission_takes_is_refused_at_once():
    with pytest.raises(MissionError, match=r"whatif: vary speed_m_s: -1 is below 0; give the speed"):
        uwopt.whatif(reef(), {"speed_m_s": [-1, 1]})
    with pytest.raises(MissionError, match=r"whatif: vary overlap: 20 is not below 1; .*0\.2 for 20"):
        uwopt.whatif(reef(), {"overlap": [0.2, 20]})


def test_a_value_that_contradicts_the_mission_is_a_row_with_its_reason():
    """A table of sharpness up to 0.95 was refused whole, for pixels alone leave sinc(1/4) = 0.900 of it."""
    table = uwopt.whatif(reef(), {"min_mtf_half_nyquist": [0.95, 0.2]})
    assert [(point.values, point.status) for point in table.points] == [([0.95], "infeasible"), ([0.2], "optimal")]
    (note,) = [note.message for note in table.warnings if note.code == "contradiction"]
    assert "at min_mtf_half_nyquist = 0.95" in note and "0.900 at half the Nyquist frequency" in note
    (rim,) = table.switches  # it lay halfway, at 0.575
    assert rim.second is None and rim.proven and rim.high - rim.low < 0.01 * (0.95 - 0.2)
    needs = reef().to_dict()["requirements"]
    ends = [alone(reef(requirements=needs | {"min_mtf_half_nyquist": end})) for end in (rim.low, rim.high)]
    assert ends[0] is not None and ends[1] is None
    with pytest.raises(MissionError, match="2 of 2 points are like that"):
        uwopt.whatif(reef(), {"min_mtf_half_nyquist": [0.95, 0.97]})


def test_a_mission_ends_where_it_begins_to_contradict_itself_without_a_search():
    """Pixels alone leave sinc(1/4) = sin(pi/4) / (pi/4) = 0.90032 of the contrast at half the Nyquist frequency."""
    base = VariedMission(reef(), {})
    key = base.varied("min_mtf_half_nyquist", "0.2,0.95")
    grid = api_varied.VariedGrid(base, (key,), api_varied.Systems(goal_of(reef())), Warm(NEVER))
    grid.points[(0.2,)], grid.refused[(0.95,)] = WhatIfPoint([0.2], "optimal", 0), "too sharp"
    (rim,) = api_varied.Switches(grid, NEVER, unheard).at_rims(searched=False)
    assert rim.low < 0.90032 < rim.high and rim.high - rim.low < 0.0075
    assert (rim.first, rim.second, rim.proven) == (0, None, False)


def test_where_nothing_fits_no_optimum_is_drawn_and_practice_is_told_as_it_is(over_speed):
    """An empty plot from -1 to 6; and of a mission that nothing meets it was said that it keeps good practice."""
    nothing = [replace(point, objective=None, system=None, status="infeasible") for point in over_speed.points]
    made = whatif_figures(replace(over_speed, points=nothing, switches=[], systems=[]))
    assert "optimum" not in made and "optimum" in whatif_figures(over_speed)
    work = SimpleNamespace(certain=False, given_way=(), base=SimpleNamespace(base=reef(practice="recommended")))
    for fits_nothing, told in ((True, "the mission as it stands has no system either"), (False, "stands keeps it")):
        work.fits_nothing = fits_nothing
        (note,) = api_whatif.full_practice_notes(nothing, work)
        assert told in note.message


def test_a_word_that_no_mission_takes_is_told_as_such():
    with pytest.raises(MissionError) as fault:
        uwopt.whatif(PROBLEMS / "reef-mosaic.yaml", {"water": ["I", "XX"], "speed_m_s": [0.3, 0.6]})
    assert str(fault.value).startswith("whatif: vary water: 'XX' is not one of I, IA")


# ---------------------------------------------------------------- files, command, interruption


@pytest.fixture
def few_file(tmp_path: Path) -> Path:
    """The narrowed mission as a file; its name asks for care."""
    data = yaml.safe_load((PROBLEMS / "reef-mosaic.yaml").read_text(encoding="utf-8"))
    data |= {"name": "=<script>alert(1)</script>", "catalog": FEW}
    file = tmp_path / "few.yaml"
    file.write_text(yaml.safe_dump(data), encoding="utf-8")
    return file


def run(*words: object) -> Any:
    return CliRunner().invoke(app, ["whatif", *(str(word) for word in words)])


def test_command_writes_table_page_and_json(few_file, tmp_path):
    done = run(few_file, "--vary", "speed_m_s=0.4,1.3", "--out", tmp_path / "out", "-q")
    assert done.exit_code == 0, done.output
    assert "beyond speed_m_s" in done.stdout
    with (tmp_path / "out" / "whatif.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["speed_m_s"] for row in rows] == ["0.4", "1.3"]
    data = json.loads((tmp_path / "out" / "whatif.json").read_text(encoding="utf-8"))
    assert WhatIf.from_dict(data).to_dict() == data
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert" in page


def test_interruption_keeps_what_is_solved(few_file, tmp_path, monkeypatch):
    honest = api_varied.Warm.best

    def third_is_interrupted(warm: Warm, mission: Mission, **more: Any) -> Any:
        if mission.vehicle.speed_m_s > 0.7:
            raise KeyboardInterrupt
        return honest(warm, mission, **more)

    monkeypatch.setattr(Warm, "best", third_is_interrupted)
    done = run(few_file, "--vary", "speed_m_s=0.4,0.6,0.8", "--out", tmp_path / "out", "-q")
    assert done.exit_code == 130
    text = (tmp_path / "out" / "whatif.csv").read_text(encoding="utf-8")
    assert len(text.splitlines()) == 3
    assert "Interrupted" in done.stdout


@pytest.mark.skipif(not beside.COPIES, reason="this system makes no copies of a process")
def test_interruption_keeps_what_is_solved_beside(monkeypatch):
    """In the water that a copy of the process solves; this one has found nothing by then."""
    here, honest, (known, knows) = os.getpid(), Warm.best, os.pipe()

    def second_is_interrupted(warm: Warm, mission: Mission, **more: Any) -> Any:
        if os.getpid() == here:
            select.select([known], [], [], 100.0)
            raise KeyboardInterrupt
        if mission.vehicle.speed_m_s < 0.5:
            return honest(warm, mission, **more)
        os.write(knows, b"!")
        return select.select([], [], [], 100.0)

    monkeypatch.setattr(Warm, "best", second_is_interrupted)
    try:
        with cores(2):
            table = uwopt.whatif(reef(), {"speed_m_s": [0.4, 0.6], "water": ["II", "IB"]})
    except KeyboardInterrupt:
        pytest.fail("nothing is kept")
    finally:
        for one in (known, knows):
            os.close(one)
    (point,) = table.points
    assert table.status == "interrupted" and point.values == [0.4, "IB"]
    assert point.system == 0 and len(table.systems) == 1


def test_a_key_without_values_is_refused_by_the_command():
    done = run(PROBLEMS / "reef-mosaic.yaml", "--vary", "speed_m_s")
    assert done.exit_code == 2
    assert "no key with values" in done.output


# ---------------------------------------------------------------- with certainty


def found(*, interrupted: bool = False) -> Any:
    """What the searches of a point find, as far as it is looked at."""
    outcome = SimpleNamespace(best=[None], complete=True, interrupted=interrupted)
    sought = SimpleNamespace(outcome=outcome, problem=None, selection=None)
    return SimpleNamespace(sought=sought, widest=sought)


def chosen(held: float, *, enough: bool) -> Any:
    """What is recommended at a point, as far as it is looked at."""
    part = SimpleNamespace(id="zz", generic=False)
    parts = dict.fromkeys(("camera", "lens", "port", "light"), part)
    totals = SimpleNamespace(power_w=3.0, cost=SimpleNamespace(value=900.0), mass_kg=None)
    hardware = SimpleNamespace(parts=parts, port=part, housing=None, complete=None, light_count=2)
    return SimpleNamespace(
        sought=found().sought, proven=None, is_best=enough, counts=held, cut=False,
        counted=SimpleNamespace(enough=enough, held=held, objective_p50=4.5),
        design=SimpleNamespace(hardware=hardware, totals=totals, is_settable=True),
    )  # fmt: skip


def stub_points(monkeypatch: pytest.MonkeyPatch, searches: list[Any], choices: list[Any]) -> list[Any]:
    """Points that find these, one after another; what each is asked: confidence, speed, and what was counted."""
    asked, told = [], iter(choices)

    def searched(self: Searches, mission: Mission, **more: Any) -> Any:
        asked.append((mission.confidence, mission.vehicle.speed_m_s))
        return searches.pop(0)

    def chosen_of(*given: Any) -> Any:
        asked[-1] = (*asked[-1], given[-1])
        return next(told)

    monkeypatch.setattr(Searches, "of", searched)
    monkeypatch.setattr(certain_points, "chosen_of", chosen_of)
    monkeypatch.setattr(certain_points, "certificate", lambda *_: SimpleNamespace(gap_rel=0.0))
    return asked


def test_with_certainty_each_point_knows_what_was_recommended_at_the_last(monkeypatch):
    one, other = chosen(0.93, enough=True), chosen(0.6, enough=False)
    asked = stub_points(monkeypatch, [found(), found()], [one, other])
    table = uwopt.whatif(reef(), {"speed_m_s": [0.3, 0.6]}, confidence=0.9)
    assert asked == [(0.9, 0.3, None), (0.9, 0.6, 0.93)] and table.confidence == 0.9
    first, second = table.points
    assert (first.status, first.objective) == ("optimal", 4.5)
    assert first.figures == {"held": 0.93, "power_w": 3.0, "cost": 900.0}
    assert (second.status, second.system, second.figures) == ("infeasible", None, {"held": 0.6})
    assert [(switch.low, switch.high) for switch in table.switches] == [(0.3, 0.6)]
    assert "Each holds in 90 % of the scenarios" in opening(table)[1]


def test_a_table_that_time_cut_short_says_first_what_is_known():
    """"Something fits at 0 of them" was said of points that nobody had looked at."""
    table = uwopt.whatif(reef(), {"speed_m_s": [0.3, 0.6, 0.9]}, seconds=1e-9)
    assert table.status == "stopped"
    asked = "3 points over speed_m_s was known. Give it more time (--seconds 60)."
    assert opening(table) == [f"Stopped by a limit before any of {asked}"]
    points = [WhatIfPoint([0.3], "infeasible"), WhatIfPoint([0.6], "stopped")]
    first, second = opening(replace(table, points=points, timing_s={"total": 90.0}))
    assert first == "Stopped by a limit with 1 of 3 points over speed_m_s known. Give it more time (--seconds 300)."
    assert second.startswith("1 point over speed_m_s, ") and "something fits at 0 of them" in second


def test_beside_a_point_that_time_left_unknown_nothing_is_told_to_take_over_or_end():
    """"Between altitude_m 0.900 m and 1.10 m nothing fits" stood above "1.100 m not known"."""
    base = VariedMission(reef(), {})
    key = base.varied("speed_m_s", "0.3,0.6,0.9,1.2")
    grid = api_varied.VariedGrid(base, (key,), api_varied.Systems(goal_of(reef())), Warm(NEVER))
    statuses = {0.3: ("optimal", 0), 0.6: ("stopped", None), 0.9: ("stopped", 1), 1.2: ("infeasible", None)}
    grid.points |= {(speed,): WhatIfPoint([speed], *told) for speed, told in statuses.items()}
    assert [(a, b) for _, a, b in grid.changes()] == [((0.9,), (1.2,))]


def test_with_certainty_an_interruption_keeps_what_is_known(monkeypatch):
    stub_points(monkeypatch, [found(), found(interrupted=True)], [chosen(0.93, enough=True)])
    table = uwopt.whatif(reef(), {"speed_m_s": [0.3, 0.6]}, confidence=0.9)
    assert table.status == "interrupted" and [point.values for point in table.points] == [[0.3]]


def test_with_certainty_a_system_is_named_as_by_likeliest_values():
    """A complete camera by its pieces, which ended in a KeyError; a port in another housing is another system."""

    def named(camera: str, **more: Any) -> WinningSystem:
        ids = {kind: f"{camera} {kind}" for kind in ("camera", "lens", "port", "light")}
        parts = {kind: UsedPart(name, name, False) for kind, name in ids.items()}
        made = UsedHardware(**parts, camera_count=1, light_count=2, orientation="landscape", light_mounts=[], **more)
        return certain_points.system_of(cast(Any, SimpleNamespace(hardware=made)))

    whole, tube = UsedPart("cam", "cam", False), UsedPart("tube", "tube", False)
    assert named("cam", complete=whole) == named("cam") and named("cam").camera == "cam camera"
    assert named("cam", housing=tube).port == "cam port in tube"
    assert named("cam", complete=whole, housing=tube).port == "cam port"


def test_with_certainty_the_points_are_what_solve_recommends(monkeypatch):
    """The second has the light and the hardware of the first; `solve` starts anew."""
    monkeypatch.setattr(search, "FRESH", 256)
    few = load_mission(PROBLEMS / "reef-mosaic.yaml").to_dict()["catalog"] | FEW | ONE_VIEW
    base = VariedMission(reef(doubt={"scenarios": 64, "other_water_table": 0.0}, catalog=few), {})
    table = uwopt.whatif(base.base, {"speed_m_s": [0.3, 0.5]}, confidence=0.7)
    point = table.points[1]
    cold = uwopt.solve(base.with_values({base.varied("speed_m_s", "0.3,1"): 0.5}), confidence=0.7, quick=True)
    assert cold.confidence is not None and cold.recommendation is not None
    assert point.objective == pytest.approx(cold.confidence.objective_p50, rel=1e-6)  # images beside each other
    assert point.figures["held"] == cold.confidence.held and cold.confidence.enough
    won = table.systems[point.system]
    assert {won.camera, won.lens, won.light} <= set(cold.recommendation.hardware.ids)


@pytest.mark.parametrize(
    ("more", "said"), [({"confidence": 90}, "write 0.9"), ({"confidence": 0.9, "spider": True}, "likeliest")]
)
def test_a_confidence_that_cannot_be_is_refused(more, said):
    with pytest.raises(MissionError, match=said):
        uwopt.whatif(reef(), {"speed_m_s": [0.3, 0.6]}, **more)


def test_what_a_call_gives_is_no_fault_of_the_file(few_file):
    for asked in (uwopt.solve, lambda file, **more: uwopt.whatif(file, {"speed_m_s": [0.3, 0.6]}, **more)):
        with pytest.raises(MissionError, match=r"^confidence = '90' is not a share"):
            asked(str(few_file), confidence="90")


def test_a_confidence_of_the_mission_that_is_not_held_is_told_in_one_line():
    """Central numbers without `confidence` in the call; asked for as central there is nothing to tell."""
    values = {"speed_m_s": [0.3, 0.45]}
    told = [note.message for note in uwopt.whatif(reef(confidence=0.9), values).warnings if note.path == "confidence"]
    assert len(told) == 1 and "0.9" in told[0] and "--confidence" in told[0]
    for quiet in (uwopt.whatif(reef(), values), uwopt.whatif(reef(confidence=0.9), values, confidence="central")):
        assert not [note for note in quiet.warnings if note.path == "confidence"]

"""`sweep`: each row is what `solve` says of its mission, and nothing that is done is lost."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

import uwopt
from uwopt.cli.app import app
from uwopt.cli.status import LIMIT_REACHED
from uwopt.deadline import Deadline
from uwopt.errors import MissionError, OutputError
from uwopt.report.text.sweep_tables import sweep_opening
from uwopt.results.result import Result
from uwopt.solvers.warm.searches import Warm
from uwopt.sweeps import inputs as inputs_room
from uwopt.sweeps import neighbours as neighbours_room
from uwopt.sweeps import store as store_room
from uwopt.sweeps import summary as summary_room
from uwopt.sweeps.inputs import job_of
from uwopt.sweeps.job import SweepBatch
from uwopt.sweeps.neighbours import warm_row
from uwopt.sweeps.rows import Row, row_of
from uwopt.sweeps.run import DEATHS, Pace, SweepRun, sweep
from uwopt.sweeps.store import SweepStore
from uwopt.sweeps.work import SweepReply, SweepWorker
from uwopt.sweeps.workers import Died

PROBLEMS = Path(__file__).parents[2] / "problems"
TANK, TANK_SYSTEM = PROBLEMS / "paper-tank.yaml", PROBLEMS / "paper-tank.system.yaml"
#: Few parts, and a name that a spreadsheet or a page must not take for more than text.
FEW: dict[str, Any] = {
    "name": "=1+1 <b>reef</b>",
    "practice": "bare",
    "scene": {"water": "II", "seafloor": "coral", "depth_m": 30},
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.5, "light_baseline_m": 0.8, "light_count": [1, 2]},
    "requirements": {
        "overlap": 0.6,
        "max_blur_px": 1.0,
        "min_snr_db": 30,
        "max_gsd_mm": 1.0,
        "mean_level": 0.3,
    },
    "limits": {"cost": 8000, "cost_basis": "central"},
    "catalog": {
        "cameras": ["avt-alvium-1800-c-040m", "avt-alvium-1800-c-234m"],
        "lenses": ["computar-m1214-mp2"],
        "ports": ["blue-robotics-4-in-dome-plastic-ring-2026"],
        "lights": ["arctic-rays-dragonfish-mini-strobe-65deg*"],
        "generic": "never",
    },
}
VARIED = {"speed_m_s": [0.3, 0.9, 40.0], "vehicle.altitude_m": [1.5, 1e-9]}
Stub = Callable[..., list[tuple[Any, ...]]]


def stored(store: SweepStore, keys: list[str]) -> list[Row]:
    """The rows of some keys in their order."""
    return [row for _, rows in store.pieces(keys) for row in rows.to_pylist()]


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> uwopt.SweepSummary:
    """A sweep with missions that are solved, in which nothing fits, and that contradict themselves."""
    return sweep(FEW, VARIED, out=tmp_path_factory.mktemp("sweep"))


@pytest.fixture(scope="module")
def tank() -> Result:
    """A result at hand, for sweeps that are about everything else."""
    return uwopt.evaluate(TANK, TANK_SYSTEM)


@pytest.fixture
def stub(monkeypatch: pytest.MonkeyPatch, tank: Result) -> Stub:
    """Let missions be worked out at once, without a page; returns their values, `fault` may raise at some."""
    monkeypatch.setattr(summary_room, "page_text", lambda made: "")

    def prepare(fault: Callable[[int], None] = lambda count: None) -> list[tuple[Any, ...]]:
        worked: list[tuple[Any, ...]] = []

        def worked_out(self: SweepWorker, task: Any) -> Row:
            fault(len(worked))
            worked.append(task.values)
            return row_of(tank)

        monkeypatch.setattr(SweepWorker, "_worked_out", worked_out)
        return worked

    return prepare


def rows_in(folder: Path) -> pd.DataFrame:
    """The table without what differs from run to run."""
    return pd.read_parquet(folder / "sweep.parquet").drop(columns=["time_s", "processor_s"])


def assert_same(one: Path, other: Path) -> None:
    """Two folders tell the same of the same missions, to the last digit."""
    pd.testing.assert_frame_equal(rows_in(one), rows_in(other), check_exact=True)


# ---------------------------------------------------------------- what stands in a row


def test_each_row_is_what_solve_says(done: uwopt.SweepSummary):
    rows = done.frame()
    assert list(rows["n"]) == list(range(6))
    for speed in (0.3, 0.9):
        changed = FEW | {"vehicle": FEW["vehicle"] | {"speed_m_s": speed, "altitude_m": 1.5}}
        result = uwopt.solve(changed, quick=True)
        best, row = (
            result.recommendation,
            rows[(rows["speed_m_s"] == speed) & (rows["vehicle.altitude_m"] == 1.5)].iloc[0],
        )
        assert best is not None
        assert row["status"] == result.status == "optimal"
        assert row["objective"] == best.objective_value
        assert [row[kind] for kind in ("camera", "lens", "port", "light")] == best.hardware.ids
        assert row["light_count"] == best.hardware.light_count
        assert row["set_exposure_ms"] == best.scenes[0].settings_to_set["exposure_ms"]
        assert row["snr_db"] == best.scenes[0].figures_as_set["snr_db"]  # what is set is what is told
        assert row["gap_rel"] == 0.0


def test_neighbours_do_not_answer_where_scenarios_are_to_be_counted():
    mission = uwopt.load_mission(FEW)
    assert warm_row(mission.with_changes(confidence=0.9), Warm()) is None


def test_neighbours_do_not_answer_where_what_can_be_set_costs_the_best_much(monkeypatch: pytest.MonkeyPatch):
    mission, warm = uwopt.load_mission(FEW | {"vehicle": FEW["vehicle"] | {"altitude_m": 1.5}}), Warm()
    row = warm_row(mission, warm)
    assert row is not None and row["objective_as_set"] > row["objective"]
    monkeypatch.setattr(neighbours_room, "WORTH_REL", 0.0)
    assert warm_row(mission, warm) is None


def test_missions_that_fail_or_that_nothing_meets_are_rows(done: uwopt.SweepSummary):
    rows = done.frame().set_index(["speed_m_s", "vehicle.altitude_m"])
    assert done.status == "complete"
    assert done.counts == {"failed": 3, "optimal": 2, "infeasible": 1}
    assert rows.loc[(40.0, 1.5), "message"] == "nothing fits"
    assert "altitude_m = 1e-09 is below 0.001" in rows.loc[(0.3, 1e-9), "message"]
    assert [one.count for one in done.failed] == [3]


def test_files_belong_together_and_are_safe_to_open(done: uwopt.SweepSummary):
    folder = Path(done.folder)
    with (folder / "sweep.csv").open(encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    assert {row["mission"] for row in table} == {"'=1+1 <b>reef</b>"}
    assert (
        uwopt.SweepSummary.from_dict(json.loads((folder / "sweep.json").read_text(encoding="utf-8"))) == done
    )
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "<b>reef" not in page
    titles = re.findall(r'<li><a href="#[^"]*">([^<]*)</a>', page)
    assert "Missions of each kit" in titles and len({*titles}) == len(titles)  # "Few kits …" stood twice
    assert sum(kit.wins for kit in done.kits) == 2


def test_inputs_named_as_figures_stand_apart(tmp_path: Path, stub: Stub):
    stub()
    made = sweep(FEW, {"cost": [7000, 9000], "speed_m_s": [0.1, 0.2]}, out=tmp_path)
    rows = made.frame()
    assert list(rows["input.cost"]) == [7000, 7000, 9000, 9000]
    assert set(rows["cost"]).isdisjoint({7000, 9000})


# ---------------------------------------------------------------- nothing lost, nothing twice


def test_a_later_run_works_out_what_is_missing(tmp_path: Path, stub: Stub):
    worked = stub()
    told: list[str] = []
    sweep(FEW, {"speed_m_s": "0.1:0.4:4"}, out=tmp_path, progress=lambda share, what: told.append(what))
    assert told[0] == "0 of 4 missions"  # before the first is done
    again = sweep(FEW, {"speed_m_s": "0.1:0.6:6"}, out=tmp_path)
    assert worked == [(0.1,), (0.2,), (0.3,), (0.4,), (0.5,), (0.6,)]
    assert again.kept == 4
    assert list(again.frame()["speed_m_s"]) == [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]


@pytest.mark.parametrize("what", ["catalogue", "program", "uwopt"])
def test_another_catalogue_or_program_is_noticed(
    tmp_path: Path, stub: Stub, monkeypatch: pytest.MonkeyPatch, what: str
):
    worked = stub()
    sweep(FEW, {"speed_m_s": [0.1, 0.2]}, out=tmp_path)
    changed = inputs_room.program_identity() | {what: "another"}
    monkeypatch.setattr(inputs_room, "program_identity", lambda: changed)
    monkeypatch.setattr("uwopt.sweeps.work.program_identity", lambda: changed)
    again = sweep(FEW, {"speed_m_s": [0.1, 0.2]}, out=tmp_path)
    assert len(worked) == 4
    assert (again.kept, again.passed_over, again.counts) == (0, 2, {"violated": 2})


@pytest.mark.parametrize("changed", ["mission", "file", "file of a file", "system", "confidence"])
def test_a_changed_input_is_noticed(tmp_path: Path, stub: Stub, changed: str):
    worked = stub()
    own, curve, mission = tmp_path / "own.csv", tmp_path / "lamp.csv", tmp_path / "mission.yaml"
    own.write_text("id,spectrum\nx,lamp.csv\n", encoding="utf-8")
    curve.write_text("1\n", encoding="utf-8")
    plain = FEW | {"catalog": FEW["catalog"] | {"files": ["own.csv"]}}
    mission.write_text(json.dumps(plain), encoding="utf-8")
    ways: dict[str, Any] = {"system": TANK_SYSTEM}
    sweep(mission, {"speed_m_s": [0.1, 0.2]}, out=tmp_path / "out", **ways)
    if changed == "mission":
        mission.write_text(json.dumps(plain | {"tolerance": 0.01}), encoding="utf-8")
    elif changed == "system":
        ways["system"] = uwopt.load_system(TANK_SYSTEM).to_dict() | {"orientation": "portrait"}
    elif changed == "confidence":
        ways["confidence"] = "central"
    else:
        (own if changed == "file" else curve).write_text("id,spectrum\nx,lamp.csv\n\n2\n", encoding="utf-8")
    assert sweep(mission, {"speed_m_s": [0.1, 0.2]}, out=tmp_path / "out", **ways).kept == 0
    assert len(worked) == 4
    assert sweep(mission, {"speed_m_s": [0.1, 0.2]}, out=tmp_path / "out", **ways).kept == 2


def test_time_that_is_over_keeps_what_is_done(tmp_path: Path, stub: Stub, monkeypatch: pytest.MonkeyPatch):
    honest, now_s = Deadline.after, [0.0]
    monkeypatch.setattr(Deadline, "after", lambda seconds: honest(seconds, lambda: now_s[0]))

    def fault(count: int) -> None:
        now_s[0] = float(count >= 3)

    stub(fault)
    first = sweep(FEW, {"speed_m_s": "0.1:0.6:6"}, out=tmp_path / "cut", seconds=1e-3)
    n_done = first.counts["violated"]
    assert (first.status, first.counts) == ("stopped", {"violated": n_done, "missing": 6 - n_done})
    assert 3 <= n_done < 6 and "Stopped" in " ".join(sweep_opening(first))
    asked = ["sweep", str(TANK), "--vary", "speed_m_s=0.1:0.8:8", "--out", str(tmp_path / "none"), "--workers", "1"]
    now_s[0] = 0.0
    stub(lambda count: now_s.__setitem__(0, 1.0))
    assert CliRunner().invoke(app, [*asked, "--seconds", "0.001"]).exit_code == LIMIT_REACHED
    worked = stub()
    whole = sweep(FEW, {"speed_m_s": "0.1:0.6:6"}, out=tmp_path / "cut")
    assert (len(worked), whole.kept, whole.status) == (6 - n_done, n_done, "complete")


def test_an_interruption_keeps_what_is_done(tmp_path: Path, stub: Stub):
    def fault(count: int) -> None:
        if count == 3:
            raise KeyboardInterrupt

    stub(fault)
    first = sweep(FEW, {"speed_m_s": "0.1:0.6:6"}, out=tmp_path / "cut")
    assert (first.status, first.counts) == ("interrupted", {"violated": 3, "missing": 3})
    worked = stub()
    whole = sweep(FEW, {"speed_m_s": "0.1:0.6:6"}, out=tmp_path / "cut")
    assert (len(worked), whole.kept, whole.status) == (3, 3, "complete")
    sweep(FEW, {"speed_m_s": "0.1:0.6:6"}, out=tmp_path / "once")
    assert_same(tmp_path / "cut", tmp_path / "once")


def test_a_full_disk_is_told_and_what_is_written_stays_valid(
    tmp_path: Path, stub: Stub, monkeypatch: pytest.MonkeyPatch
):
    worked, write, written = stub(), store_room.write_files, []

    def full(folder: Path, files: Any) -> Any:
        if len(written) == 2:
            raise OutputError(f"{folder}: cannot be written (No space left on device); choose another --out.")
        written.append(files)
        return write(folder, files)

    monkeypatch.setattr(store_room, "write_files", full)
    with pytest.raises(
        OutputError, match=r"No space left.*stays valid, (\d+) of 9 missions.*goes on with the rest"
    ):
        sweep(FEW, {"speed_m_s": "0.1:0.9:9"}, out=tmp_path)
    kept = sum(pq.read_metadata(path).num_rows for path in (tmp_path / "rows").glob("*.parquet"))
    monkeypatch.setattr(store_room, "write_files", write)
    worked = stub()
    assert sweep(FEW, {"speed_m_s": "0.1:0.9:9"}, out=tmp_path).kept == kept > 0
    assert len(worked) == 9 - kept


def test_a_damaged_file_is_set_aside_and_its_missions_worked_out_again(tmp_path: Path, stub: Stub):
    worked = stub()
    sweep(FEW, {"speed_m_s": [0.1, 0.2]}, out=tmp_path)
    first = sorted((tmp_path / "rows").glob("*.parquet"))[0]
    first.write_bytes(first.read_bytes()[:-9])
    (tmp_path / "rows" / ".left.tmp").write_bytes(b"half")
    again = sweep(FEW, {"speed_m_s": [0.1, 0.2]}, out=tmp_path)
    assert len(worked) == 3
    assert [note.code for note in again.warnings] == ["damaged"]
    assert (again.counts, again.missions) == ({"violated": 2}, 2)
    assert sorted(path.suffix for path in (tmp_path / "rows").iterdir()) == [
        "",
        ".damaged",
        ".parquet",
        ".parquet",
    ]


def test_small_files_are_joined_and_rows_that_stand_twice_count_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(store_room, "MOST_SMALL", 3)
    with SweepStore(tmp_path) as store:
        for number in range(7):
            store.add([{"key": f"k{number}", "status": "optimal", "objective": float(number)}])
        store.add([{"key": "k0", "status": "optimal", "objective": 9.0}])
        assert len(list((tmp_path / "rows").glob("*.parquet"))) == 4  # two joined, two small
        rows = stored(store, [f"k{number}" for number in (6, 0, 99, 1, 2, 3, 4, 5)])
    assert [row["key"] for row in rows] == ["k6", "k0", "k1", "k2", "k3", "k4", "k5"]
    assert [row["objective"] for row in rows] == [6.0, 9.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    with SweepStore(tmp_path) as store:
        assert stored(store, [row["key"] for row in rows]) == rows


@pytest.mark.parametrize("piece", [1, 3, 100])
def test_a_table_is_the_same_in_pieces_of_any_size(
    done: uwopt.SweepSummary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, piece: int
) -> None:
    monkeypatch.setattr(store_room, "PIECE", piece)
    monkeypatch.setattr(store_room, "MOST_OPEN", 1)
    whole = pq.read_table(Path(done.folder) / "sweep.parquet")
    with SweepStore(Path(done.folder)) as store:
        pieces = list(summary_room.table_pieces(job_of([FEW], VARIED), store))
    assert max(map(len, pieces)) <= piece
    assert pa.concat_tables(pieces).combine_chunks().equals(whole.combine_chunks())


def test_two_runs_do_not_write_into_one_folder(tmp_path: Path):
    with SweepStore(tmp_path), pytest.raises(OutputError, match="another sweep is writing there"):
        sweep(FEW, VARIED, out=tmp_path)


# ---------------------------------------------------------------- workers that die


class DyingWorkers:
    """Workers whose process ends at some missions, and takes along what else was under way."""

    count = 2

    def __init__(self, deadly: Callable[[tuple[Any, ...]], bool]):
        self.deadly, self.waiting, self.sent = deadly, list[SweepBatch](), list[int]()

    def submit(self, batch: SweepBatch) -> None:
        self.sent.append(len(batch.tasks))
        self.waiting.append(batch)

    def next(self, timeout_s: float) -> tuple[SweepBatch, SweepReply | Died] | None:
        if not self.waiting:
            return None
        batch = self.waiting.pop(0)
        if self.dead or any(self.deadly(task.values) for task in batch.tasks):
            self.dead = bool(self.waiting)
            return batch, Died()
        rows = [{"key": task.key, "status": "optimal", "time_s": 1e-3} for task in batch.tasks]
        return batch, SweepReply(rows, 1.0)

    dead = False

    def close(self) -> None:
        """Nothing to let go."""


def crew_of(workers: Any) -> Any:
    """A crew of workers that are there already."""
    return SimpleNamespace(workers=lambda left: workers)


def test_only_a_mission_that_ends_each_process_is_given_up(tmp_path: Path):
    job = job_of([FEW], {"speed_m_s": "0.1:4:40"})
    with SweepStore(tmp_path) as store:
        run = SweepRun(job, store)
        workers = DyingWorkers(lambda values: values == (3.0,))
        run.all(crew_of(workers))
        keys = [task.key for task in job.tasks()]
        table = stored(store, keys)
        assert sorted(row["key"] for row in table) == sorted(keys)
        failed = [row for row in table if row["status"] == "failed"]
        assert [keys.index(row["key"]) for row in failed] == [29]
        assert f"ended {DEATHS} times" in failed[0]["message"]
        assert len(store.keys) == 39  # a run to come tries it again


def test_what_dies_twice_is_worked_out_all_the_same(tmp_path: Path):
    job, met = job_of([FEW], {"speed_m_s": "0.1:4:40"}), []

    def twice(values: tuple[Any, ...]) -> bool:
        met.append(values)
        return values == (0.1,) and met.count(values) <= 2

    with SweepStore(tmp_path) as store:
        SweepRun(job, store).all(crew_of(DyingWorkers(twice)))
        table = stored(store, [task.key for task in job.tasks()])
    assert len(table) == 40
    assert {row["status"] for row in table} == {"optimal"}


def test_batches_take_seconds_and_shrink_towards_the_end():
    pace = Pace(2)
    assert pace.size(1000) == 1
    pace.learn(10, 1.0)
    assert pace.size(1000) == 20  # 2 s of tasks of 0.1 s
    assert pace.size(8) == 2  # two workers, one batch ahead
    assert Pace(1000, 0.1).size(10**7) == 200  # 20 s, so that one scheduler keeps up


# ---------------------------------------------------------------- what is named


def test_a_table_sets_keys_and_leaves_empty_cells_alone(tmp_path: Path, stub: Stub):
    worked = stub()
    (tmp_path / "t.csv").write_text(
        "# stations\nname,speed_m_s,water,#remark\nnorth,0.2, ,calm\nsouth,,IB,\n", encoding="utf-8"
    )
    made = sweep([tmp_path / "t.csv", FEW], out=tmp_path / "csv")
    assert worked == [("north", 0.2, None), ("south", None, "IB")]
    assert list(made.frame()["mission"]) == ["north", "south"]
    pq.write_table(
        pa.table({"name": ["north", "south"], "speed_m_s": [0.2, None], "water": [None, "IB"]}),
        tmp_path / "t.parquet",
    )
    sweep([tmp_path / "t.parquet", FEW], out=tmp_path / "parquet")
    assert_same(tmp_path / "csv", tmp_path / "parquet")


def test_values_reach_the_mission():
    job = job_of([FEW], {"speed_m_s": [0.2, 0.4], "water": ["IB", "II"]})
    missions = [SweepWorker(job).mission(task) for task in job.tasks()]
    assert [(m.vehicle.speed_m_s, m.scenes[0].water) for m in missions] == [
        (0.2, "IB"), (0.2, "II"), (0.4, "IB"), (0.4, "II"),
    ]  # fmt: skip


def test_a_folder_gives_a_row_for_each_mission_file(tmp_path: Path, stub: Stub):
    stub()
    (tmp_path / "b.yaml").write_text(json.dumps(FEW), encoding="utf-8")
    (tmp_path / "a.yaml").write_text("speed: fast", encoding="utf-8")
    (tmp_path / "c.system.yaml").write_text("camera: x", encoding="utf-8")
    made = sweep(tmp_path, out=tmp_path / "out")
    assert made.missions == 2
    assert list(made.frame()["status"]) == ["failed", "violated"]
    assert made.frame()["message"][0].startswith(str(tmp_path / "a.yaml"))


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("speed\n0.1\n", "speed_m_s"),
        ("speed_m_s,speed_m_s\n1,2\n", "stands twice"),
        ("speed_m_s,vehicle.speed_m_s\n1,2\n", "same key"),
        ("speed_m_s\n", "holds no rows"),
        ("", "holds no"),
        ('speed_m_s\n"1', "is no table"),
    ],
)
def test_a_wrong_table_is_told_in_one_message(tmp_path: Path, table: str, words: str):
    (tmp_path / "t.csv").write_text(table, encoding="utf-8")
    with pytest.raises(MissionError, match=words):
        sweep([tmp_path / "t.csv", FEW], out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere.yaml"], "no such file"),
        ([TANK, "--vary", "sped_m_s=1,2"], "did you mean speed_m_s"),
        ([TANK, "--vary", "speed_m_s=1,2", "--vary", "vehicle.speed_m_s=1,2"], "the same key"),
        (["t.parquet", TANK], "cannot be read"),
        (["a.csv", "b.csv", TANK], "takes one"),
        (["a.csv", TANK, "--vary", "speed_m_s=1,2"], "are both given"),
        (["a.csv"], "no mission is named"),
    ],
)
def test_bad_input_is_told_in_one_message(tmp_path: Path, arguments: list[Any], words: str):
    done = CliRunner().invoke(app, ["sweep", *map(str, arguments), "--out", str(tmp_path / "out"), "-q"])
    assert (done.exit_code, done.stdout) == (2, "")
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_the_command_tells_how_a_given_system_does(tmp_path: Path):
    arguments = [
        TANK,
        "--system",
        TANK_SYSTEM,
        "--vary",
        "speed_m_s=0.01,3",
        "--out",
        tmp_path,
        "--workers",
        1,
    ]
    done = CliRunner().invoke(app, ["sweep", *map(str, arguments)])
    assert done.exit_code == 0, done.output
    rows = pd.read_parquet(tmp_path / "sweep.parquet")
    assert rows["blur_px"][1] == pytest.approx(300 * rows["blur_px"][0])
    assert f"requirement of {(rows['status'] == 'feasible').sum()} of them" in done.stdout


# ---------------------------------------------------------------- trade-offs


def test_each_point_of_a_trade_off_is_a_row(tmp_path: Path) -> None:
    cameras = [*FEW["catalog"]["cameras"], "flir-bfs-u3-51s5m", "basler-daa1280-54um"]
    more = {"cameras": cameras, "lenses": ["computar-m1214-mp2", "fujinon-hf9ha-1b", "kowa-lm8jc"]}
    low = {**FEW, "vehicle": {**FEW["vehicle"], "altitude_m": 1.5}, "catalog": FEW["catalog"] | more}
    made = sweep(low, {"speed_m_s": [0.3, 40.0]}, out=tmp_path, pareto=["cost", "gsd_mm"])
    assert (made.what, made.counts) == ("pareto", {"complete": 1, "infeasible": 1})
    table = pd.read_parquet(tmp_path / "sweep.parquet")
    alone = {**low, "vehicle": {**low["vehicle"], "speed_m_s": 0.3}}
    front = uwopt.pareto(alone, objectives=["cost", "gsd_mm"], solver="exact")
    first = table[table["speed_m_s"] == 0.3]
    assert len(front.points) > 1
    assert first["point"].tolist() == [point.id for point in front.points]
    assert first["front_gsd_mm"].tolist() == [point.values["gsd_mm"] for point in front.points]
    assert first["camera"].tolist() == [point.design.hardware.camera.id for point in front.points]
    assert first["power_w"].tolist() == [point.design.totals.power_w for point in front.points]
    assert set(first["points"]) == {len(front.points)}
    last = table[table["speed_m_s"] == 40.0]
    assert last["status"].tolist() == ["infeasible"]
    assert last["point"].isna().all()
    assert len((tmp_path / "sweep.csv").read_text(encoding="utf-8").splitlines()) == len(front.points) + 2
    again = sweep(low, {"speed_m_s": [0.3, 40.0]}, out=tmp_path, pareto=["cost", "gsd_mm"])
    assert again.kept == 2
    assert pd.read_parquet(tmp_path / "sweep.parquet").equals(table)


@pytest.mark.parametrize(
    ("more", "why"),
    [({"objective": "cost"}, "objective is given beside pareto"), ({"system": TANK_SYSTEM}, "a system is given"),
     ({"confidence": 0.9}, "confidence is given"), ({"pareto": ["power"]}, "two or three"),
     ({"pareto": ["power", "beauty"]}, "beauty")],
)  # fmt: skip
def test_what_is_no_trade_off_is_told(tmp_path: Path, more: dict[str, Any], why: str) -> None:
    with pytest.raises(MissionError, match=why):
        sweep(FEW, out=tmp_path, **({"pareto": ["power", "cost"]} | more))

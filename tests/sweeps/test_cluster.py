"""A sweep on a real Dask cluster of this machine: the same rows as without one, though a worker is killed."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import uwopt
from uwopt.errors import SchedulerError
from uwopt.sweeps import cluster as cluster_room
from uwopt.sweeps import inputs as inputs_room
from uwopt.sweeps import run as run_room
from uwopt.sweeps.identity import program_identity
from uwopt.sweeps.run import sweep

ROOT = Path(__file__).parents[2]
PROGRAM = Path(__file__).parent / "dask_processes.py"
MISSION, SYSTEM = ROOT / "problems" / "paper-tank.yaml", ROOT / "problems" / "paper-tank.system.yaml"
SPEEDS = {"speed_m_s": "0.001:3:10"}
WATER = "wavelength_nm,attenuation_per_m,a_per_m\n300,0.1,0.05\n1000,0.1,0.05\n"
Cluster = dict[str, Any]


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """A scheduler and two workers, as processes of their own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    words = [sys.executable, str(PROGRAM), "2", str(tmp_path_factory.mktemp("dask"))]
    with subprocess.Popen(
        words, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as running:  # fmt: skip
        assert running.stdout is not None
        yield json.loads(running.stdout.readline())


def mission_with_own_water(folder: Path) -> dict[str, Any]:
    """The tank in a water that a file beside the mission describes."""
    folder.mkdir()
    (folder / "own.csv").write_text(WATER, encoding="utf-8")
    plain = uwopt.load_mission(MISSION).to_dict()
    scenes = [plain["scenes"][0] | {"water": str(folder / "own.csv"), "water_table": None}]
    return plain | {"scenes": scenes}


def test_rows_are_those_of_one_process_though_a_worker_is_killed(
    cluster: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(run_room, "BATCH_S", 0.05)
    mission = mission_with_own_water(tmp_path / "files")
    alone = sweep(mission, SPEEDS, system=SYSTEM, out=tmp_path / "alone")
    killed: list[int] = []

    def progress(share: float, text: str) -> None:
        shutil.rmtree(
            tmp_path / "files", ignore_errors=True
        )  # workers have what was sent, as on other machines
        if share > 0.2 and not killed:
            killed.append(cluster["workers"].pop())
            os.kill(killed[0], signal.SIGKILL)

    made = sweep(
        mission,
        SPEEDS,
        system=SYSTEM,
        out=tmp_path / "cluster",
        scheduler=cluster["address"],
        progress=progress,
    )
    assert killed
    assert (made.status, made.counts) == ("complete", alone.counts)
    tables = [pd.read_parquet(tmp_path / name / "sweep.parquet") for name in ("alone", "cluster")]
    one, other = (table.drop(columns=["time_s", "processor_s"]) for table in tables)
    pd.testing.assert_frame_equal(one, other, check_exact=True)
    assert set(one["status"]) <= {"feasible", "violated"}


def test_workers_with_another_program_are_refused(
    cluster: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    known = program_identity() | {"catalogue": "another"}
    monkeypatch.setattr(inputs_room, "program_identity", lambda: known)
    with pytest.raises(
        SchedulerError, match=r"worker tcp\S+ has the catalogue's tables \w+ instead of another; install the same"
    ):
        sweep(MISSION, SPEEDS, system=SYSTEM, out=tmp_path, scheduler=cluster["address"])


def test_a_scheduler_that_does_not_answer_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    monkeypatch.setattr(cluster_room, "REACH_S", 0.2)
    with pytest.raises(SchedulerError, match="no Dask scheduler answers"):
        sweep(MISSION, SPEEDS, system=SYSTEM, out=tmp_path, scheduler=f"tcp://127.0.0.1:{port}")

"""Sweeps over real processes: the same rows as in one, and nothing lost when all of them are killed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq
from thorough import drawn

from uwopt.sweeps.run import sweep

ROOT = Path(__file__).parents[2]
MISSION, SYSTEM = ROOT / "problems" / "paper-tank.yaml", ROOT / "problems" / "paper-tank.system.yaml"
COUNT = drawn(12, 400)
SPEEDS = f"0.001:3:{COUNT}"
#: A sweep of its own program, in small batches, which goes on until somebody ends it.
SWEEP = """
import sys
from uwopt.sweeps import run, workers
from uwopt.sweeps.run import sweep
if __name__ == "__main__":
    run.BATCH_S, workers.START_S = 0.05, 0.0
    mission, system, out, speeds = sys.argv[1:]
    sweep(mission, {"speed_m_s": speeds}, system=system, out=out, workers=2)
"""


def rows_on_disk(folder: Path) -> list[str]:
    """Keys of the rows that stand in finished files."""
    files = sorted((folder / "rows").glob("*.parquet"))
    return [key for file in files for key in pq.read_table(file, columns=["key"]).column("key").to_pylist()]


def killed_in_the_middle(folder: Path, tmp_path: Path) -> None:
    """Start a sweep on two processes and kill all of them once some rows are there."""
    script = tmp_path / "program.py"
    script.write_text(SWEEP, encoding="utf-8")
    words = [sys.executable, str(script), str(MISSION), str(SYSTEM), str(folder), SPEEDS]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    running = subprocess.Popen(
        words, env=environment, start_new_session=True, stderr=subprocess.PIPE, text=True
    )
    try:
        while len(rows_on_disk(folder)) < 3:
            assert running.poll() is None, running.communicate()[1]
            time.sleep(0.05)
    finally:
        os.killpg(running.pid, signal.SIGKILL)
        running.communicate()


def test_a_run_that_is_killed_with_all_its_processes_loses_nothing_that_is_done(tmp_path: Path):
    cut, whole = tmp_path / "cut", tmp_path / "whole"
    killed_in_the_middle(cut, tmp_path)
    there = rows_on_disk(cut)
    assert 3 <= len(there) == len(set(there)) < COUNT
    again = sweep(MISSION, {"speed_m_s": SPEEDS}, system=SYSTEM, out=cut)
    assert (again.status, again.kept, again.missions) == ("complete", len(there), COUNT)
    keys = rows_on_disk(cut)
    assert len(keys) == len(set(keys)) == COUNT  # nothing lost, nothing twice
    sweep(MISSION, {"speed_m_s": SPEEDS}, system=SYSTEM, out=whole)
    tables = [pd.read_parquet(folder / "sweep.parquet") for folder in (cut, whole)]
    one, other = (table.drop(columns=["time_s", "processor_s"]) for table in tables)
    pd.testing.assert_frame_equal(one, other, check_exact=True)
    assert json.loads((cut / "sweep.json").read_text(encoding="utf-8"))["counts"] == again.counts

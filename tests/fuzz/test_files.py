"""Files, right and wrong: whatever a mission, system or table holds, the outcome is sound or one clean error."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fuzz_files as files
import fuzz_judge as judge
import pytest
from fuzz_files import examples
from hypothesis import given
from hypothesis import strategies as st

import uwopt
from uwopt.catalog.load import read_catalog
from uwopt.errors import CatalogError, MissionError, UwoptError
from uwopt.mission.mission import load_mission
from uwopt.mission.system import load_system


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where files are written, with waters of one's own beside them."""
    made = tmp_path_factory.mktemp("fuzz")
    for name, (a, b) in WATERS.items():
        rows = [f"{nm},{a},{b},{a}" for nm in (380, 780)]
        (made / name).write_text("\n".join(["wavelength_nm,a_per_m,b_per_m,kd_per_m", *rows, ""]))
    return made


WATERS = {"vacuum.csv": (0, 0), "absorbs.csv": (0.3, 0), "scatters.csv": (0, 0.3), "ink.csv": (300, 500)}


# ---------------------------------------------------------------- form


@pytest.mark.parametrize(("load", "whole"), [(load_mission, files.missions()), (load_system, files.systems())],
                         ids=["mission", "system"])  # fmt: skip
@examples(200)
@given(data=st.data())
def test_a_broken_file_is_told_in_clean_words(load: Any, whole: Any, folder: Path, data: Any) -> None:
    file = folder / "fuzzed.yaml"
    file.write_bytes(data.draw(files.texts(files.broken(whole))))
    found = judge.outcome(lambda: load(str(file)))
    if isinstance(found, UwoptError):
        assert isinstance(found, MissionError)
        judge.assert_clean(found, name="fuzzed.yaml")
    else:
        assert load(found.to_dict()).to_dict() == found.to_dict()


@examples(100)
@given(source=st.recursive(st.sampled_from(files.HOSTILE), lambda inner: st.lists(inner, max_size=3) | st.dictionaries(
    st.sampled_from(["scene", "vehicle", "requirements", "catalog", "camera", "x"]), inner, max_size=4)))  # fmt: skip
def test_anything_from_python_is_refused_in_clean_words(source: Any) -> None:
    for load in (load_mission, load_system):
        if not isinstance(source, str):
            assert isinstance(judge.outcome(lambda load=load: load(source)), MissionError)


@examples(120)
@given(data=st.data())
def test_a_broken_table_of_parts_is_told_in_clean_words(folder: Path, data: Any) -> None:
    parts = data.draw(files.own_parts())
    kind = data.draw(st.sampled_from(list(parts)))
    for _ in range(data.draw(st.integers(1, 3))):
        row = data.draw(st.sampled_from(parts[kind]))
        name = data.draw(st.sampled_from([*row, "colour", "focal_lenght_mm", ""]))
        row[name] = data.draw(st.sampled_from([v for v in files.HOSTILE if not isinstance(v, (list, dict))]))
    files.write_parts(folder, {kind: parts[kind]})
    found = judge.outcome(lambda: read_catalog([f"{kind}s.csv"], None, folder))
    if isinstance(found, UwoptError):
        assert isinstance(found, CatalogError)
        judge.assert_clean(found, name=f"{kind}s.csv")


# ---------------------------------------------------------------- substance


@examples(80)
@given(mission=files.missions(waters=tuple(WATERS)), system=files.systems())
def test_evaluate_is_sound_or_refuses(folder: Path, mission: Any, system: Any) -> None:
    def call() -> Any:
        return uwopt.evaluate(load_mission(mission, base_dir=folder), system)

    found = judge.outcome(call)
    if not isinstance(found, UwoptError):
        judge.assert_sound(found)


@examples(25)
@given(mission=files.missions(waters=tuple(WATERS)), parts=files.own_parts())
def test_solve_is_sound_or_refuses(folder: Path, mission: Any, parts: Any) -> None:
    mission["catalog"] = files.write_parts(folder, parts)
    found = judge.outcome(lambda: uwopt.solve(load_mission(mission, base_dir=folder), seconds=10, audit=2))
    if not isinstance(found, UwoptError):
        judge.assert_sound(found)


@examples(8)
@given(
    mission=files.missions(waters=tuple(WATERS)), parts=files.own_parts(),
    names=st.lists(st.sampled_from(["power", "cost", "mass", "gsd_mm"]), min_size=1, max_size=2, unique=True),
    quality=st.sampled_from(["snr_db", "contrast"]),
)  # fmt: skip
def test_pareto_is_sound_or_refuses(folder: Path, mission: Any, parts: Any, names: Any, quality: str) -> None:
    mission["catalog"] = files.write_parts(folder, parts)
    wanted = [*names, quality]

    def call() -> Any:
        return uwopt.pareto(
            load_mission(mission, base_dir=folder), objectives=wanted, solver="exact", seconds=10
        )

    found = judge.outcome(call)
    if isinstance(found, UwoptError):
        return
    assert list(judge.not_a_number(found)) == []
    assert found.status in ("complete", "stopped", "infeasible")

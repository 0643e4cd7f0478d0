"""Kept values of slow references are taken while nothing that they are made from has changed."""

from __future__ import annotations

import json
from pathlib import Path

import kept_values
import pytest
from kept_values import Kept, mark_of


@pytest.mark.parametrize("changed", ["", "code.py", "table.csv"])
def test_a_value_is_kept_until_code_or_table_changes(
    changed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kept_values, "THOROUGH", False)
    monkeypatch.delenv(kept_values.REMADE, raising=False)
    code, table, file = (tmp_path / name for name in ("code.py", "table.csv", "kept.json"))
    code.write_text("x")
    table.write_text("1")
    file.write_text(json.dumps({"of": mark_of(code, table), "values": {"mean 2": 5.0}}))
    if changed:
        (tmp_path / changed).write_text("other")
    kept = Kept(file, code, table)

    def mean(case: int) -> float:
        return 7.0 * case

    assert (kept.is_current, kept.values(mean)(2)) == ((False, 14.0) if changed else (True, 5.0))
    assert kept.values(mean)(3) == 21.0


def test_what_is_remade_is_written_and_nothing_is_known(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(kept_values.REMADE, "1")
    code, file = tmp_path / "code.py", tmp_path / "kept.json"
    code.write_text("x")
    file.write_text(json.dumps({"of": mark_of(code), "values": {"pair_of 2": [0.0, 0.0]}}))

    def pair_of(case: int) -> tuple[float, float]:
        return case, 2.0 * case

    assert list(Kept(file, code).values(pair_of)(2)) == [2.0, 4.0]
    assert json.loads(file.read_text())["values"] == {"pair_of 2": [2.0, 4.0]}

"""CSVs of test shots: units in the header, and one clear message for all that is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from uwopt.errors import MissionError
from uwopt.mission.shots import read_shots

HEAD = "exposure_ms,gain_db,distance_m,level_dn,dark_dn"
ROW = "2,6,1.5,900,64"


def read(folder: Path, text: str) -> list[object]:
    (folder / "shots.csv").write_text(text, encoding="utf-8")
    return list(read_shots(folder / "shots.csv"))


def test_units_of_the_header_come_to_si(tmp_path: Path) -> None:
    (a,) = read_shots_of(tmp_path, f"{HEAD},f_number,light_pct,pulse_us,shot\n{ROW},4,50,800,one\n")
    assert (a.name, a.exposure_s, a.distance_m, a.f_number, a.light_frac) == ("one", 2e-3, 1.5, 4.0, 0.5)
    assert a.gain == pytest.approx(10 ** (6 / 20)) and a.pulse_s == pytest.approx(8e-4)
    (b,) = read_shots_of(tmp_path, "exposure_s,gain,distance_mm,level_pct,dark_frac\n0.002,2,1500,30,0.01\n")
    assert (b.exposure_s, b.gain, b.distance_m) == (0.002, 2.0, 1.5)
    assert (b.level, b.dark, b.unit) == (pytest.approx(0.3), 0.01, "frac")
    assert b.name == "row 2" and b.f_number is None


def read_shots_of(folder: Path, text: str):  # type: ignore[no-untyped-def]
    (folder / "shots.csv").write_text(text, encoding="utf-8")
    return read_shots(folder / "shots.csv")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("exposure_ms,distance_m,level_dn\n2,1,900\n", "has no column of gain over the camera's lowest (gain_db or "
         "gain); level without light (dark_dn, dark_pct or dark_frac)."),
        (f"{HEAD.replace('exposure_ms', 'exposure')}\n{ROW}\n", "column 'exposure' is not known; the unit belongs in "
         "its name: exposure_ms, exposure_us or exposure_s."),
        (f"{HEAD.replace('exposure_ms', 'exposure_min')}\n{ROW}\n", "column 'exposure_min' is not known; did you mean"),
        (f"{HEAD},distance_cm\n{ROW},150\n", "distance from port to target stands in distance_m and in distance_cm"),
        (f"{HEAD.replace('dark_dn', 'dark_pct')}\n{ROW}\n", "level and dark are in different units"),
        (f"{HEAD}\n2,6,nan,900,64\n", "row 2: distance_m = 'nan' is not a finite number"),
        (f"{HEAD}\n2,6,1.5 m,900,64\n", "row 2: distance_m = '1.5 m' is not a number; the unit belongs in the header."),
        (f"{HEAD}\n2,6,,900,64\n", "row 2: distance_m is empty; fill it in, or leave out the row."),
        (f"{HEAD}\n0,6,1.5,900,64\n", "row 2: exposure_ms = '0' is 0; it must be above."),
        (f"{HEAD}\n2,6,-1.5,900,64\n", "row 2: distance_m = '-1.5' is below 0"),
        (f"{HEAD.replace('_db', '')}\n2,0,1.5,900,64\n", "gain = '0' is 0 as a ratio; 1 is the camera's lowest"),
        (f"{HEAD.replace('_dn', '_pct')}\n2,6,1.5,900,64\n", "level_pct = '900' is more than the whole"),
        (f"shot,{HEAD}\na,{ROW}\na,{ROW}\n", "row 3: shot 'a' stands twice"),
        (f"{HEAD}\n", "holds no shot; write one row for each."),
        ("", "holds no header row"),
        (f"{HEAD}\n{ROW},7\n", "has 6 cells, the header has 5"),
        (f"{HEAD.replace(',', ';')}\n", "columns are separated by"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_with_its_place(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(MissionError) as caught:
        read(tmp_path, text)
    assert message in str(caught.value), caught.value
    assert "catalog template" not in str(caught.value)


def test_all_faults_are_told_at_once(tmp_path: Path) -> None:
    with pytest.raises(MissionError) as caught:
        read(tmp_path, f"{HEAD}\n2,6,nan,900,64\n-2,6,1,900,64\n")
    assert "row 2" in str(caught.value) and "row 3" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("kind,id,model,price,currency,count,owned,mass\ncamera,a,b,1,USD,1,no,3\n", "columns 'kind', 'id', 'model', "
         "'price', 'currency', 'count' and 2 more are unknown; known are exposure_ms, "),
        ("name: reef\n# shallow\nlimits: {cost: 1, power_w: 2}\n", "column 'name: reef' is unknown; known are "),
    ],
    ids=["a bill", "a mission"],
)  # fmt: skip
def test_a_file_of_another_kind_is_told_by_its_columns_alone(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(MissionError) as caught:
        read_shots_of(tmp_path, text)
    first, second = str(caught.value).splitlines()
    assert told in first and "has no column of exposure" in second


@pytest.mark.parametrize(
    ("raw", "kind"), [(b"PK\x03\x04\xff", "a workbook or an archive"), (b"\n<!DOCTYPE html>", "a web page")]
)
def test_a_file_that_is_no_table_is_told_as_what_it_is(tmp_path: Path, raw: bytes, kind: str) -> None:
    (tmp_path / "shots.csv").write_bytes(raw)
    with pytest.raises(MissionError, match=f"shots.csv: is {kind}, no table; export the table"):
        read_shots(tmp_path / "shots.csv")


def test_a_file_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match="no such file"):
        read_shots(tmp_path / "none.csv")

"""A mission as it was solved: read again it asks for the same, with as much of the user's text as can be kept."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from uwopt.mission.as_solved import HEAD, as_solved, means
from uwopt.mission.mission import load_mission
from uwopt.mission.yielding import YIELDS, with_yields

START = """\
# what we want
scene: {water: II, seafloor: sand, depth_m: 30}
vehicle:
  altitude_m: 2
  speed_m_s: 0.3  # slow
"""
GIVEN_WAY = [one for one in YIELDS if one.path in ("requirements.snr_at_less_db", "requirements.refuse", "reserve.dof")]
WRITTEN = {
    "in lines": "requirements:  # of images\n\n    # how sharp\n    max_blur_px: 1.0\n    overlap: 0.3\n",
    "in braces": "requirements: {max_blur_px: 1.0, overlap: 0.3}\nreserve: {swath: 0.05}\n",
    "with the key itself": "requirements:\n  overlap: 0.3\n  max_blur_px: 1.0\n  refuse: all  # of it\n",
    "with a word": "reserve: recommended\nrequirements: {overlap: 0.3, max_blur_px: 1.0}\n",
    "with the last line open": "confidence: 0.8\nrequirements: {overlap: 0.3, max_blur_px: 1.0}",
}


@pytest.mark.parametrize("written", [*WRITTEN])
def test_the_users_text_is_kept_and_states_what_gave_way(tmp_path: Path, written: str) -> None:
    file = tmp_path / "reef.yaml"
    file.write_text(START + WRITTEN[written], "utf-8")
    solved = with_yields(load_mission(file), GIVEN_WAY).with_changes(objective="cost", confidence=0.8)
    text = as_solved(solved, GIVEN_WAY)
    assert text.startswith(HEAD + START)  # with its comments
    assert means(text, solved)
    again = load_mission(yaml.safe_load(text))
    assert again.to_dict() == solved.to_dict()
    assert (again.objective, again.confidence) == ("cost", 0.8)
    assert again.requirements.snr_at_less_db == 10.0 and "white_balance" not in again.requirements.refuse
    assert again.reserve.dof == 0.0 and again.reserve.blur == load_mission(file).reserve.blur


def test_what_cannot_be_added_to_or_names_files_is_written_in_full(tmp_path: Path) -> None:
    (tmp_path / "own.csv").write_text("id,price\n", "utf-8")
    odd = START + '"requirements": {overlap: 0.3, max_blur_px: 1.0}\n'
    named = odd.replace('"', "") + "catalog: {prices: own.csv}\n"
    for text in (odd, named):
        file = tmp_path / "reef.yaml"
        file.write_text(text, "utf-8")
        solved = with_yields(load_mission(file), GIVEN_WAY)
        made = as_solved(solved, GIVEN_WAY)
        assert "slow" not in made
        assert load_mission(yaml.safe_load(made)).to_dict() == solved.to_dict(absolute_paths=True)
    from_python = with_yields(load_mission(yaml.safe_load(odd)), GIVEN_WAY)
    assert load_mission(yaml.safe_load(as_solved(from_python, GIVEN_WAY))).to_dict() == from_python.to_dict()

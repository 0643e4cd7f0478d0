"""Colours: what sensor was chosen is told."""

from __future__ import annotations

import pytest
from random_cases import lamp, planted

from uwopt.forward.designs import Hardware
from uwopt.solvers.recommend import colour_notes

BURNING = lamp("burning", flux_lm=2e4, power_w=200.0)


@pytest.mark.parametrize(
    ("asked", "sensor", "words"),
    [
        ("any", "mono", "Camera is mono: no colour was asked for; requirements.colour: colour asks for it"),
        ("any", "colour", "requirements.colour: mono asks for the other"),
        ("colour", "colour", ""),
    ],
)
def test_the_sensor_is_told_where_the_mission_leaves_it_open(asked: str, sensor: str, words: str) -> None:
    case = planted("power", (BURNING,), {"colour": asked}, camera={"colour": sensor})
    problem = case.problem()
    notes = colour_notes(problem, Hardware(0, 0, 0, True, 0, 1, problem.mounts[0]))
    assert [note.message.endswith(words) for note in notes] == [True] * bool(words)

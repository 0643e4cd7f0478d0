"""What is told beyond a proof takes a while at most where nobody has given a time, and what is left out is told."""

from __future__ import annotations

from typing import Any

import pytest

import uwopt
from uwopt import deadline
from uwopt.api import doubting, explaining
from uwopt.api.search_notes import patience_warnings
from uwopt.api.watch import Watch

LIGHT = "deepsea-power-light-led-sealite-lsl-flood"
MISSION: dict[str, Any] = {
    "scene": {"water": "II", "seafloor": 0.2, "depth_m": 30}, "practice": "bare", "physics": "paper",
    "vehicle": {"altitude_m": 2.0, "speed_m_s": 0.3, "light_count": [1, 4]},
    "requirements": {"overlap": 0.3, "max_blur_px": 1.0, "min_snr_db": 10},
    "catalog": {
        "cameras": ["flir-bfs-u3-120s4m"], "lenses": ["kowa"], "lights": [LIGHT], "accept_unrated": [LIGHT],
        "generic": "never",
    },
}  # fmt: skip


@pytest.mark.parametrize(("patience_s", "told"), [(0.0, True), (1e9, False)])
def test_doubts_beyond_patience_are_left_out_and_told(
    monkeypatch: pytest.MonkeyPatch, patience_s: float, told: bool
) -> None:
    monkeypatch.setattr(doubting, "DOUBTS_S", patience_s)
    monkeypatch.setattr(doubting, "DOUBTS_SHARE", 0.0)
    result = uwopt.solve(MISSION, top=1)
    assert result.status == "optimal" and result.recommendation is not None
    notes = [note.message for note in result.warnings if note.code == "time"]
    said = "the answer stands without what was not worked out beside it in 0 s; the same command with --seconds 60"
    assert [text.startswith(f"{said} gives it more: ") for text in notes] == [True] * told
    assert all("how firm the answer is; " in text for text in notes)
    assert (result.robustness is None) == told
    assert result.recommendation.rounded is not None  # settings to set are no doubt


def test_doubts_have_a_quarter_of_what_a_long_answer_took(monkeypatch: pytest.MonkeyPatch) -> None:
    """Six seconds after minutes told nothing of most doubts."""
    had_s = []
    for spent_s in (0.0, 20.0, 24.0, 240.0):
        monkeypatch.setattr(doubting, "processor_s", lambda spent_s=spent_s: 5.0 + spent_s)
        had_s.append(doubting.doubts_s(Watch(since_s=5.0)))
    assert had_s == pytest.approx([6.0, 6.0, 6.0, 60.0])


def test_time_that_would_do_is_more_than_all_took(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half as much again as 100 s, and 25 s: 175 s, which 300 s are the next of those told to give."""
    monkeypatch.setattr("uwopt.api.search_notes.time.perf_counter", lambda: 107.0)
    late = deadline.Deadline(left_out=["other waters", "other waters"])
    (note,) = patience_warnings(late, 25.0, 7.0)
    assert "in 25 s; the same command with --seconds 300 gives it more: other waters" in note.message
    assert note.message.count("other waters") == 1 and note.message.count(": ") == 1  # pages take it apart there


@pytest.mark.parametrize("work", ["ranged", "others_in_time"])
def test_what_stands_beside_an_answer_takes_no_patience_from_its_doubts(
    monkeypatch: pytest.MonkeyPatch, work: str
) -> None:
    """It is worked out first, and here takes all the time there is."""
    now = [0.0]

    def long(*given: object) -> list[object]:
        now[0] += 1e6
        return []

    monkeypatch.setattr(deadline, "processor_s", lambda: now[0])
    monkeypatch.setattr(doubting, work, long)
    result = uwopt.solve(MISSION, top=2, ranges=True)
    assert now[0] == 1e6 and result.robustness is not None


def test_a_quicker_search_never_leaves_less_for_what_would_help(monkeypatch: pytest.MonkeyPatch) -> None:
    """An answer is there after 8.8 s of the processor, or 6 s after a search that took long."""
    left_s = []
    for spent_s in (1.0, 2.0, 4.0, 20.0, 100.0):
        monkeypatch.setattr(explaining, "processor_s", lambda spent_s=spent_s: spent_s)
        left_s.append(explaining.left_s(Watch(since_s=0.0)))
    assert left_s == pytest.approx([7.8, 6.8, 6.0, 6.0, 6.0])

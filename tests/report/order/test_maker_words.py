"""What makers are asked stands in their words: no key of a file, no unit twice, nothing that is the buyer's own."""

from __future__ import annotations

import re

import pytest

from uwopt.catalog.columns import COLUMNS
from uwopt.catalog.parts.part import KINDS
from uwopt.report.order.maker_words import words_for
from uwopt.report.order.tender_lines import ALWAYS, NOT_ASKED, VITAL

ASKED = [(kind, key) for kind in KINDS for key in (*VITAL.get(kind, ()), *ALWAYS) if key in COLUMNS.get(kind, {})]


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind in COLUMNS])
def test_no_fact_names_a_key_or_says_its_unit_twice(kind: str) -> None:
    said = [words_for(column) for column in COLUMNS[kind].values() if column.form == "number"]
    odd = re.compile(r"[a-z]_[a-z]|Nyquist|\bin (micro|milli)?metres|in watts")
    never_asked = ("bit depth that",)  # what a maker's own sheet of gains is given in
    assert not [text for text in said if odd.search(text) and not text.startswith(never_asked)]


def test_what_each_maker_is_asked_is_worded() -> None:
    told = {key: words_for(COLUMNS[kind][key]) for kind, key in ASKED}
    assert all(text and "_" not in text for text in told.values())
    assert told["supply_v_min"] == "lowest supply voltage (V)" and told["trigger_jitter_us"] == "jitter of that delay"
    assert words_for(COLUMNS["camera"]["pixel_pitch_um"]) == "pixel pitch"
    assert words_for(COLUMNS["lens"]["focal_length_mm"]) == "focal length in air"
    assert {"host_power_w", "host_price"} <= {*NOT_ASKED}

"""What a part is made and sold for: what serves something else is left to those who name it."""

from __future__ import annotations

import pytest

from uwopt.catalog.choose import Choice, select
from uwopt.catalog.load import built_in_catalog
from uwopt.catalog.tables import built_in_rows

TORCH = "orcatorch-dc710"  # 6 degrees, 150 m, priced, held in the hand


def searched_lights(**choice: object) -> set[str]:
    """Ids of the lamps that a mission with that choice may use."""
    return {light.id for light in select(built_in_catalog(), Choice(**choice)).lights}  # type: ignore[arg-type]


@pytest.mark.parametrize("file", ["cameras.csv", "lights.csv", "ports.csv"])
def test_every_row_says_what_it_is_sold_for(file: str) -> None:
    assert [row["id"] for row in built_in_rows(file) if not row["purpose"]] == []


def test_hand_torches_are_counted_by_their_purpose_and_video_lights_stay() -> None:
    found = select(built_in_catalog(), Choice())
    left_out = {e.part_id for e in found.excluded if e.rule == "purpose"}
    assert TORCH in left_out
    assert "bigblue-al2600xwp" not in left_out  # a flood of 120 degrees
    assert "bigblue-al2600xwp" in {light.id for light in found.lights}


def test_a_torch_is_used_by_whom_names_or_owns_it() -> None:
    assert TORCH not in searched_lights()
    assert TORCH in searched_lights(lights=[TORCH])
    assert TORCH in searched_lights(owned=[TORCH])
    assert TORCH not in searched_lights(lights=["orcatorch*"])  # a pattern names no part


def test_a_camera_of_its_own_and_one_for_telescopes_are_no_bodies_to_build_in() -> None:
    rules = {e.part_id: e.rule for e in select(built_in_catalog(), Choice()).excluded if e.kind == "camera"}
    assert rules["zimo-subsea-camera"] == rules["zwo-asi183mm"] == "purpose"
    assert rules["seed-imx250m"] == "availability"

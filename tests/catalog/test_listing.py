"""Rows for `uwopt catalog list` and `show`."""

import pytest

from uwopt.catalog.listing import list_parts, show_part
from uwopt.catalog.load import read_catalog
from uwopt.errors import CatalogError

CATALOG = read_catalog()


def test_list_of_a_kind_shows_only_what_can_be_searched():
    lines = list_parts(CATALOG, "camera", "basler")
    assert lines and all(line.manufacturer == "Basler" and line.searchable for line in lines)


def test_searchable_and_excluded_parts_make_up_the_catalogue():
    ids = [line.id for excluded in (False, True) for line in list_parts(CATALOG, excluded=excluded)]
    assert sorted(ids) == sorted(CATALOG.ids())


def test_excluded_parts_say_why():
    (line,) = list_parts(CATALOG, "port", "zen", excluded=True)
    assert line.reasons == ("port mount: needs a photo housing with the mount photo-housing",)


def test_show_tells_range_status_and_source_of_an_estimate():
    lines, exclusions = show_part(CATALOG, "light_motion_sola_video_pro_8000")
    power = next(line for line in lines if line.name == "power_w")
    assert (power.value, power.status) == ("80", "estimated")
    assert (power.low, power.high) == pytest.approx((57.14, 235.29), abs=0.01)
    assert "light-efficacy-lm-per-w-led" in power.source
    assert exclusions == ()


def test_show_of_an_unknown_id_names_near_ones():
    with pytest.raises(CatalogError, match="did you mean"):
        show_part(CATALOG, "light_motion_sola_4001")


def test_summary_writes_numbers_as_people_do_and_marks_estimates():
    (line,) = list_parts(CATALOG, "light", "deepsea-power-light-led-sealite-lsl-flood")
    assert line.summary == "continuous, 10000 lm, ~100 W, 75 deg (medium not stated)"

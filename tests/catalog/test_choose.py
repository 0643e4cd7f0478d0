"""Which parts a mission lets into the search."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from uwopt.catalog.catalogue import Catalog, Exclusion
from uwopt.catalog.choose import Choice, matches, select
from uwopt.catalog.load import assembled, build_rows, read_catalog
from uwopt.catalog.parts.camera import Camera
from uwopt.catalog.parts.housing import Housing
from uwopt.catalog.parts.lens import Lens
from uwopt.catalog.parts.light import Light
from uwopt.catalog.parts.port import Port
from uwopt.catalog.parts.quantity import Quantity
from uwopt.catalog.records import exact
from uwopt.catalog.tables import DATA_DIR, parse_table
from uwopt.catalog.userparts import typed_rows
from uwopt.errors import CatalogError

CATALOG = Catalog(
    cameras=(
        Camera(id="flir-bfs-1", manufacturer="Teledyne FLIR", colour="mono", price=exact(800.0)),
        Camera(id="avt-1800", manufacturer="Allied Vision", colour="colour", price=exact(700.0)),
        Camera(
            id="basler-aca",
            manufacturer="Basler",
            shutter="rolling",
            price=Quantity(500, 300, 900, "estimated"),
        ),
        Camera(id="seed-imx250m", manufacturer="Paper's tool", availability="not_a_product"),
    ),
    lenses=(
        Lens(id="kowa-8", manufacturer="Kowa", price=exact(200.0)),
        Lens(id="kowa-no-mount", manufacturer="Kowa"),
    ),
    ports=(
        Port(id="dome-100", depth_rating_m=100.0),
        Port(id="dome-unrated"),
        Port(id="generic-dome", generic=True, depth_rating_m=6000.0),
    ),
    lights=(
        Light(id="lamp-300", depth_rating_m=300.0, price=exact(100.0)),
        Light(id="generic-lamp", generic=True, depth_rating_m=6000.0),
    ),
    exclusions=(
        Exclusion("seed-imx250m", "camera", "availability", "no product"),
        Exclusion("kowa-no-mount", "lens", "vital facts", "no mount stated"),
    ),
)


def rules_of(selection):
    return {exclusion.part_id: exclusion.rule for exclusion in selection.excluded}


@pytest.mark.parametrize(
    ("pattern", "hit"),
    [("flir", True), ("FLIR", True), ("teledyne-flir", True), ("flir_bfs", True), ("flir bfs*", True),
     ("allied*", False), ("*", True), ("bfs-?", False), ("*bfs-?", True), ("", False)],
)  # fmt: skip
def test_pattern_looks_at_id_and_manufacturer(pattern, hit):
    assert matches(pattern, CATALOG.cameras[0]) == hit


def test_without_wishes_everything_sound_is_searched_and_generic_parts_wait():
    selection = select(CATALOG)
    assert selection.indices == {
        "camera": (0, 1, 2), "lens": (0,), "port": (0, 1), "light": (0,), "housing": (), "complete": (),
    }  # fmt: skip
    assert rules_of(selection) == {
        "seed-imx250m": "availability",
        "kowa-no-mount": "vital facts",
        "generic-dome": "generic",
        "generic-lamp": "generic",
    }


def test_every_part_is_selected_or_counted_once():
    selection = select(
        CATALOG, {"cameras": ["flir"], "exclude": ["lamp*"]}, required_depth_m=200.0, colour="colour"
    )
    for kind, parts in (("camera", 4), ("lens", 2), ("port", 3), ("light", 2)):
        assert len(selection.indices[kind]) + sum(selection.counts[kind].values()) == parts


def test_a_part_that_is_no_product_is_searched_when_its_id_stands_there():
    assert select(CATALOG, Choice(cameras=["SEED_IMX250M"])).indices["camera"] == (3,)
    assert select(CATALOG, Choice(cameras=["seed"])).indices["camera"] == ()


def test_missing_vital_facts_stay_out_even_when_named():
    assert select(CATALOG, Choice(lenses=["kowa-no-mount"])).indices["lens"] == ()


def test_first_rule_counts():
    # the Basler is both excluded and rolling; `exclude` stands before `shutter`
    selection = select(CATALOG, SimpleNamespace(exclude=["basler"]), shutter="global")
    assert rules_of(selection)["basler-aca"] == "exclude"


def test_colour_and_shutter_filter_cameras():
    assert select(CATALOG, colour="colour").indices["camera"] == (1,)
    assert select(CATALOG, shutter="rolling").indices["camera"] == (2,)


def test_unknown_depth_rating_never_passes_unless_accepted():
    assert select(CATALOG, required_depth_m=50.0).indices["port"] == (0,)
    accepting = select(CATALOG, Choice(accept_unrated=["dome_unrated"]), required_depth_m=50.0)
    assert accepting.indices["port"] == (0, 1)


def test_a_rating_for_short_dives_serves_no_longer_ones():
    short = Port(id="cap", depth_rating_m=100.0, rated_time_h=336.0)
    tube = Housing(id="tube", depth_rating_m=100.0, rated_time_h=336.0)
    known = replace(CATALOG, ports=(short, CATALOG.ports[0]), housings=(tube,))
    for hours, ports, housings in ((None, (0, 1), (0,)), (336.0, (0, 1), (0,)), (337.0, (1,), ())):
        chosen = select(known, duration_h=hours)
        assert (chosen.indices["port"], chosen.indices["housing"]) == (ports, housings)
    assert [e.reason for e in chosen.excluded if e.rule == "rated time"] == [
        "its depth rating holds for 336 h, 337 h are needed"
    ] * 2


def test_makers_acrylic_that_is_rated_for_two_weeks_is_left_out_of_a_season():
    # "only for short-term submersions lasting less than two weeks": the maker's page of enclosures
    season = select(read_catalog(), Choice(generic="allow"), duration_h=2000.0)
    left = {e.part_id for e in season.excluded if e.rule == "rated time"}
    assert {"blue-robotics-3-in-acrylic-tube-150", "blue-robotics-3-in-acrylic-end-cap-2026"} < left
    assert all("acrylic" in name for name in left)
    assert all(one.material != "acrylic" for one in season.housings)


def test_generic_parts_step_in_where_no_real_part_is_left():
    selection = select(CATALOG, required_depth_m=1000.0)
    assert selection.indices["port"] == (2,)
    assert selection.indices["light"] == (1,)


def test_generic_parts_can_be_wanted_or_forbidden():
    assert select(CATALOG, Choice(generic="allow")).indices["light"] == (0, 1)
    assert select(CATALOG, Choice(generic="never"), required_depth_m=1000.0).indices["light"] == ()


def test_estimated_price_does_not_count_as_verified():
    selection = select(CATALOG, Choice(verified=["price"]))
    assert selection.indices["camera"] == (0, 1)
    assert rules_of(selection)["basler-aca"] == "verified"


def test_pattern_without_match_warns_with_near_names():
    (warning,) = select(CATALOG, Choice(cameras=["basller"])).warnings
    assert "basller" in warning and "Basler" in warning


def test_owned_camera_costs_nothing():
    selection = select(CATALOG, Choice(owned=[{"id": "flir-bfs-1", "quantity": 1}]))
    assert selection.cameras[0].price == exact(0.0, "user", "owned")
    one_of_two = select(CATALOG, Choice(owned=[{"id": "flir-bfs-1"}]), camera_count=2).cameras[0].price
    assert one_of_two is not None and one_of_two.value == 400.0  # each of the two costs half of 800
    none = (
        select(CATALOG, Choice(owned=[{"id": "flir-bfs-1", "quantity": 0}]), camera_count=1).cameras[0].price
    )
    assert none == exact(800.0)


def test_owned_part_that_does_not_exist_is_a_fault_with_near_ids():
    with pytest.raises(CatalogError, match=r"did you mean.*lamp-300"):
        select(CATALOG, Choice(owned=[{"id": "lamp-30"}]))


@pytest.mark.parametrize(
    ("depth_m", "ports", "lights"), [(100.0, (0,), (0,)), (101.0, (2,), (0,)), (301.0, (2,), (1,))]
)
def test_part_serves_down_to_its_rating_and_no_deeper(depth_m, ports, lights):
    selection = select(CATALOG, required_depth_m=depth_m)
    assert (selection.indices["port"], selection.indices["light"]) == (ports, lights)


@pytest.mark.parametrize(
    ("status", "verified"), [("published", True), ("quoted", True), ("estimated", False)]
)
def test_price_counts_as_verified_by_its_status(status, verified):
    lamp = Light(id="lamp", price=Quantity(100.0, 90.0, 120.0, status))
    catalog = Catalog(cameras=(), lenses=(), ports=(), lights=(lamp,), exclusions=())
    chosen = select(catalog, Choice(verified=["price"], generic="allow")).indices["light"]
    assert chosen == ((0,) if verified else ())


def test_owned_cameras_save_their_share_of_several():
    # one of two is at hand: each costs half of 800 on average
    selection = select(CATALOG, Choice(owned=[{"id": "flir-bfs-1", "quantity": 1}]), camera_count=2)
    assert selection.cameras[0].price.value == 400.0


def housed(*mounts):
    """A catalogue of ports with these mounts, as a file of parts states them."""
    head = "id,geometry,mount,thickness_mm,nominal_diameter_mm,depth_rating_m\n"
    rows = "".join(f"port-{n},flat,{mount},10,100,100\n" for n, mount in enumerate(mounts))
    table = parse_table(head + rows, "ports.csv")
    typed, faults = typed_rows(table, "port", DATA_DIR, built_in=True)
    assert faults == []
    return assembled(build_rows(typed, "published"))


def test_a_port_of_a_photo_housing_waits_for_the_mount_the_port_or_its_owner():
    catalog = housed("", "blue-robotics-4-in", "nauticam-n120", "degz-h-50", "nobody-knows-it")
    assert select(catalog).indices["port"] == (0, 1)
    assert set(rules_of(select(catalog)).values()) == {"port mount"}
    assert select(catalog, Choice(port_mounts=["Nauticam_N120"])).indices["port"] == (0, 1, 2)
    assert select(catalog, Choice(ports=["port-3"])).indices["port"] == (3,)
    assert select(catalog, Choice(ports=["port-*"])).indices["port"] == (0, 1)
    assert select(catalog, Choice(owned=[{"id": "port-4"}])).indices["port"] == (0, 1, 4)


def test_a_mount_that_no_port_has_warns_with_near_ones():
    (warning,) = select(housed("nauticam-n120"), Choice(port_mounts=["nauticam-n12"])).warnings
    assert "nauticam-n120" in warning

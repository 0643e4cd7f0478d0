"""Planted defects of housings: what fits, what an enclosure costs, weighs and bears, and which are needless."""

from __future__ import annotations

from planted.defect import Defect

ROOM = "tests/model/test_enclosure.py::"
HULL = "tests/model/test_hull.py::"
BUILT = "tests/forward/test_enclosures.py::"
NEEDLESS = BUILT + "test_needless_is_what_another_housing_that_fits_does_for_no_more"

FIT = "tests/solvers/test_nearest_fit.py::"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="a borehole is asked for the length of a housing",
        file="uwopt/forward/enclosures.py",
        old="return np.asarray(ports.outer_diameter_m * 1e3)",
        new="return np.asarray(ports.outer_length_m * 1e3)",
        test="tests/solvers/test_rules.py::test_a_rule_keeps_what_is_a_millionth_inside[diameter_mm]",
    ),
    Defect(
        name="a housing to be made is ordered for what is drawn",
        file="uwopt/catalog/parts/doubts.py",
        old="if name in PRICES or name in SIZES:",
        new="if name in PRICES:",
        test="tests/forward/test_enclosures.py::test_a_size_that_is_drawn_smaller_orders_no_shorter_housing",
    ),
    Defect(
        name="a housing to be made is ordered for the middle of what a camera may be",
        file="uwopt/forward/enclosures.py",
        old="at_most=bool(port.to_be_made[0])",
        new="at_most=False",
        test="tests/forward/test_enclosures.py::"
        "test_a_housing_to_be_made_is_ordered_for_the_largest_camera[True-56.31-151.0]",
    ),
    Defect(
        name="a housing to be made is ordered for the middle of where the pupil may lie",
        file="uwopt/forward/enclosures.py",
        old="long + spacers_m, farthest, nearest)",
        new="long + spacers_m, lenses.pupil_m)",
        test="tests/forward/test_enclosures.py::"
        "test_a_housing_to_be_made_has_room_wherever_the_pupil_lies[True-117.0-28.63]",
    ),
    Defect(
        name="where a pupil is drawn it was known before the housing was ordered",
        file="uwopt/catalog/parts/doubts.py",
        old="if name in EITHER_SIZE:",
        new="if name in EITHER_SIZE[1:]:",
        test="tests/forward/test_enclosures.py::test_a_size_that_is_drawn_smaller_orders_no_shorter_housing",
    ),
    Defect(
        name="all housings are held to the largest camera",
        file="uwopt/forward/enclosures.py",
        old="at_most=bool(port.to_be_made[0])",
        new="at_most=True",
        test="tests/forward/test_enclosures.py::"
        "test_a_housing_to_be_made_is_ordered_for_the_largest_camera[False-46.43-111.0]",
    ),
    Defect(
        name="a fit is refused though something fits",
        file="uwopt/solvers/infeasible/nearest_fit.py",
        old="        if short_m <= 0.0:\n            return None\n",
        new="",
        test=FIT + "test_no_size_is_named_where_something_else_stops_it",
    ),
    Defect(
        name="the search looks through the wall of a tube",
        file="uwopt/solvers/exact/imagers.py",
        old="np.zeros(count) if problem.paper else widest_corner([scene.view for scene in sharp.scenes])",
        new="np.zeros(count)",
        test="tests/solvers/test_housings.py::test_a_cap_behind_whose_rim_the_tube_is_narrower_is_refused",
    ),
    Defect(
        name="the mouth of a tube is half as wide as it must be",
        file="uwopt/model/enclosure.py",
        old="2.0 * np.asarray(gap_m)",
        new="1.0 * np.asarray(gap_m)",
        test=ROOM + "test_the_corner_ray_of_a_cap_needs_a_mouth_as_wide_as_it_is_there",
    ),
    Defect(
        name="whichever housing is looked at last comes nearest",
        file="uwopt/solvers/infeasible/nearest_fit.py",
        old="int(np.argmin(short_m))",
        new="short_m.size - 1",
        test=FIT + "test_the_size_that_stops_the_fit_is_named_with_what_is_missing",
    ),
    Defect(
        name="a port too wide for every housing is not told",
        file="uwopt/solvers/infeasible/nearest_fit.py",
        old="return nearest_port(relaxer.selection)",
        new="return None",
        test=FIT + "test_ports_that_go_on_no_housing_are_told[none]",
    ),
    Defect(
        name="an enclosure is rated as its port alone",
        file="uwopt/evaluation/design_model.py",
        old="[port, *([port.housing] if port.housing else [])]",
        new="[port]",
        test=BUILT + "test_rating_of_an_enclosure_is_the_least_of_port_and_housing",
    ),
    Defect(
        name="the lens takes no length in a housing",
        file="uwopt/model/enclosure.py",
        old="self.lens_length_m - self.frontmost_m + self.camera_length_m",
        new="self.camera_length_m",
        test=ROOM + "test_tube_behind_a_dome_begins_at_the_pupil",
    ),
    Defect(
        name="the lens may stand in the glass of a flat port",
        file="uwopt/model/enclosure.py",
        old="np.maximum(bodies.frontmost_m, gap_m)",
        new="gap_m",
        test=ROOM + "test_tube_behind_a_flat_port_holds_the_whole_lens",
    ),
    Defect(
        name="a square body goes through a hole as wide as its side",
        file="uwopt/model/enclosure.py",
        old="np.hypot(self.camera_width_m, self.camera_height_m)",
        new="np.maximum(self.camera_width_m, self.camera_height_m)",
        test=ROOM + "test_tube_behind_a_dome_begins_at_the_pupil",
    ),
    Defect(
        name="the housing is for nothing",
        file="uwopt/forward/part_rows.py",
        old="name: bare[name] + hulls.pop(name) for name in bare",
        new="name: bare[name] + 0.0 * hulls.pop(name) for name in bare",
        test=BUILT + "test_enclosure_costs_and_weighs_as_port_and_housing",
    ),
    Defect(
        name="the housing weighs nothing",
        file="uwopt/forward/part_rows.py",
        old='known["mass_kg"] + hulls.pop("mass_kg")',
        new='known["mass_kg"] + 0.0 * hulls.pop("mass_kg")',
        test=BUILT + "test_enclosure_costs_and_weighs_as_port_and_housing",
    ),
    Defect(
        name="the dearer housing makes the cheaper one needless",
        file="uwopt/forward/enclosures.py",
        old="no_worse &= column[:, None] <= column[None, :]",
        new="no_worse &= column[:, None] >= column[None, :]",
        test=NEEDLESS,
    ),
    Defect(
        name="a housing that does not fit makes another needless",
        file="uwopt/forward/enclosures.py",
        old="(product(alike.astype(np.float32), beats",
        new="(product(np.ones(alike.shape, np.float32), beats",
        test=NEEDLESS,
    ),
    Defect(
        name="pairs are taken for alike by the first eight housings",
        file="uwopt/forward/enclosures.py",
        old="groups_alike(*words.T)",
        new="groups_alike(bits[:, 0])",
        test="tests/forward/test_enclosures.py::test_needless_of_many_pairs_is_that_of_each",
    ),
    Defect(
        name="groups of ports are as roomy as their tightest housing",
        file="uwopt/solvers/exact/port_groups.py",
        old='(*sizes, "price", "limit_price", "mass_kg"), ("refractive_index", "room_diameter_m", "room_length_m")',
        new='(*sizes, "price", "limit_price", "mass_kg", "room_diameter_m", "room_length_m"), ("refractive_index",)',
        test="tests/solvers/test_housings.py::test_no_group_of_ports_is_tighter_than_its_roomiest_housing",
    ),
    Defect(
        name="a row of a large search counts as one port",
        file="uwopt/solvers/exact/tree.py",
        old="int(self.imagers_in(depth, block.rows.take(lost)).sum()) * self.designs",
        new="len(lost) * self.designs",
        test="tests/solvers/test_housings.py::test_ports_that_are_left_when_a_search_ends_are_counted_one_by_one",
    ),
    Defect(
        name="a wide dome needs no flange",
        file="uwopt/forward/adapters.py",
        old="wide_mm > housing.outer_diameter_mm.value",
        new="wide_mm > 9.0 * housing.outer_diameter_mm.value",
        test=BUILT + "test_a_dome_that_is_wider_than_its_tube_stands_on_a_flange_that_is_paid_for",
    ),
    Defect(
        name="the rim of a spherical cap cuts no view",
        file="uwopt/catalog/parts/port.py",
        old="return math.sqrt(max(inner_mm**2 - (0.5 * opening.value) ** 2, 0.0))",
        new="return 0.0",
        test=(
            BUILT + "test_a_spherical_cap_stands_out_less_than_a_hemisphere_and_displaces_less",
            "tests/solvers/test_rules.py::test_the_rim_of_a_spherical_cap_must_be_clear_of_the_corner",
        ),
    ),
    Defect(
        name="the search sees past the rim of a spherical cap",
        file="uwopt/solvers/exact/imager_rules.py",
        old="clears = corner * ports.rim_gap_m[port] <= ports.clear_radius_m[port]",
        new="clears = corner * ports.gap_m[port] <= ports.clear_radius_m[port]",
        test="tests/solvers/test_rules.py::test_the_rim_of_a_spherical_cap_must_be_clear_of_the_corner",
    ),
    Defect(
        name="an opening that is guessed cuts the view",
        file="uwopt/catalog/parts/port.py",
        old="opening is None or opening.status in GUESSED:",
        new="opening is None:",
        test=BUILT + "test_a_dome_that_is_wider_than_its_tube_stands_on_a_flange_that_is_paid_for",
    ),
    Defect(
        name="behind a cap the pupil stands in the tube's mouth",
        file="uwopt/model/enclosure.py",
        old="np.where(is_dome, gap_m, np.maximum",
        new="np.where(is_dome, 0.0, np.maximum",
        test="tests/model/test_enclosure.py::test_behind_a_spherical_cap_the_pupil_stands_deeper_in_the_tube",
    ),
    Defect(
        name="a flange is listed but not paid for",
        file="uwopt/forward/part_rows.py",
        old="hull_prices[name] = hull_prices[name] + np.array(",
        new="hull_prices[name] = hull_prices[name] + 0.0 * np.array(",
        test=BUILT + "test_a_dome_that_is_wider_than_its_tube_stands_on_a_flange_that_is_paid_for",
    ),
    Defect(
        name="a port goes on ends that are narrower than itself",
        file="uwopt/forward/enclosures.py",
        old="port.width_mm is None else port.width_mm - widest.value",
        new="port.width_mm is None else 0.0",
        test=BUILT + "test_port_goes_where_it_is_named_and_on_ends_made_for_it_unless_it_is_wider",
    ),
    Defect(
        name="housings bear any depth",
        file="uwopt/catalog/choose.py",
        old="isinstance(part, Port | Light | Housing | Complete)",
        new="isinstance(part, Port | Light | Complete)",
        test=BUILT + "test_housing_that_is_too_shallow_is_left_out",
    ),
    Defect(
        name="tubes do not buckle",
        file="uwopt/model/hull.py",
        old="max(inner_diameter_mm * slender / (1.0 - slender), ",
        new="max(0.0, ",
        test=HULL + "test_thin_tube_buckles_at_the_pressure_of_its_ring",
    ),
    Defect(
        name="what floats in water is weighed in air",
        file="uwopt/forward/enclosures.py",
        old="(inside + ports.mass_kg - ports.displaced_kg)",
        new="(inside + ports.mass_kg)",
        test=BUILT + "test_mass_in_water_and_size_of_a_tube_with_a_dome",
    ),
    Defect(
        name="a rival in another housing is taken for one in the first",
        file="uwopt/solvers/one_hardware.py",
        old="[own_id(own) for own in lists[kind]].index(own_id(part))",
        new="[own.id for own in lists[kind]].index(part.id)",
        test="tests/solvers/test_robustness.py::test_a_rival_keeps_its_housing_among_the_catalogue",
    ),
)

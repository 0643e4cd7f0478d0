"""Planted defects of oblique views: their rays and light, what the mission is told of them, and the search's bounds."""

from __future__ import annotations

from planted.defect import Defect

MODEL, SEEN, SEARCHED = "tests/model/test_oblique.py", "tests/forward/test_oblique.py", "tests/solvers/test_oblique.py"
IMAGING, VIEWS, BOUNDS = "uwopt/model/imaging.py", "uwopt/forward/views.py", "uwopt/solvers/exact/oblique.py"
RULES = "tests/solvers/test_rules.py"

DEFECTS = (
    Defect(
        name="rays start on the axis of a tilted port",
        file=IMAGING,
        old="return (range_m + shape.slope * start_m * tan_along) / descent(",
        new="return range_m / descent(",
        test=f"{MODEL}::test_rays_meet_the_level_floor_where_snell_and_a_turned_camera_send_them",
    ),
    Defect(
        name="lamps light a tilted floor as if it were square to the axis",
        file="uwopt/model/beam.py",
        old="cos_incidence = np.maximum(cos_incidence - slope * x / range_m, 0.0) / np.hypot(1.0, slope)",
        new="pass",
        test=f"{MODEL}::test_light_of_a_pixel_is_that_of_lambert_on_the_tilted_plane",
    ),
    Defect(
        name="lamps light a tilted floor at the range of its middle",
        file=IMAGING,
        old="range_m - lamps.z_m[index] + slope * x_m if slope else range_m - lamps.z_m[index]",
        new="range_m - lamps.z_m[index]",
        test=f"{MODEL}::test_light_of_a_pixel_is_that_of_lambert_on_the_tilted_plane",
    ),
    Defect(
        name="half of an oblique image stands for the whole",
        file="uwopt/model/image_mean.py",
        old="return upright and shape.slope == 0.0",
        new="return upright",
        test=f"{MODEL}::test_backscatter_of_an_oblique_image_ends_at_the_tilted_floor",
    ),
    Defect(
        name="backscatter goes on behind a tilted floor",
        file="uwopt/model/veil/geometry.py",
        old="    range_m = axial_range_m(along, across, shape=shape, range_m=range_m)\n",
        new="",
        test=f"{MODEL}::test_backscatter_of_an_oblique_image_ends_at_the_tilted_floor",
    ),
    Defect(
        name="spots on a tilted floor are looked for where they would be on a square one",
        file="uwopt/model/image_mean.py",
        old="over, port_m = levelled(lamps, shape.slope, range_m)",
        new="over, port_m = lamps, range_m",
        test=f"{MODEL}::test_narrow_cones_on_an_oblique_floor_are_found_where_they_are",
    ),
    Defect(
        name="an oblique footprint is weighed as evenly as a square one",
        file="uwopt/model/footprint.py",
        old="    if shape.slope:\n        return floor_steps",
        new="    if False:\n        return floor_steps",
        test=f"{MODEL}::test_evenness_of_an_oblique_footprint_is_that_of_its_floor",
    ),
    Defect(
        name="the swath is that of the far edge",
        file=VIEWS,
        old="wide = 2.0 * point(near, side)[1]",
        new="wide = 2.0 * point(far, side)[1]",
        test=f"{SEEN}::test_footprint_is_the_trapezoid_of_height_and_angles",
    ),
    Defect(
        name="near and far end of an oblique view are told for each other",
        file="uwopt/evaluation/figures_by_name.py",
        old='(("near", -along), ("centre", 0.0), ("far", along))',
        new='(("near", along), ("centre", 0.0), ("far", -along))',
        test=f"{SEEN}::test_pixel_and_way_of_each_end_are_those_of_its_ray",
    ),
    Defect(
        name="pixels are compared in the near corner alone",
        file=VIEWS,
        old="u, v = np.array([-1.0, 1.0]), np.ones(2)",
        new="u, v = np.array([-1.0, -1.0]), np.ones(2)",
        test=f"{SEEN}::test_the_largest_pixel_lies_in_the_far_corner",
    ),
    Defect(
        name="what moves sideways in the image does not blur",
        file="uwopt/model/footprint.py",
        old="along, across = np.hypot(self.across_v, self.across_u), np.hypot(self.along_v, self.along_u)",
        new="along, across = np.abs(self.across_v), np.abs(self.along_u)",
        test=(
            f"{SEEN}::test_the_near_corner_blurs_most",
            f"{MODEL}::test_moving_the_floor_by_the_least_way_moves_the_image_by_one_tangent",
        ),
    ),
    Defect(
        name="an oblique camera that nods sweeps the plane as one that looks square at it",
        file="uwopt/forward/motion.py",
        old="lever_m=lever_m * secant,",
        new="lever_m=lever_m,",
        test=f"{SEEN}::test_a_camera_that_nods_blurs_by_its_own_turn_whatever_the_pitch",
    ),
    Defect(
        name="corners of an oblique frame are focused as those of a square one",
        file=VIEWS,
        old="        own[..., 1] *= fall\n",
        new="",
        test=f"{SEEN}::test_what_is_near_and_what_is_far_in_the_frame_must_both_be_sharp",
    ),
    Defect(
        name="daylight comes up to an oblique camera as to one that looks down",
        file="uwopt/forward/sun_light.py",
        old="logs_at = self.oblique_logs if self.shape.slope else self.radial_logs",
        new="logs_at = self.radial_logs",
        test=f"{SEEN}::test_daylight_from_an_oblique_floor_loses_what_its_way_takes",
    ),
    Defect(
        name="altitudes of an oblique view are told as ranges",
        file="uwopt/forward/scene.py",
        old="return np.asarray(self.range_m * np.cos(self.pitch_rad))",
        new="return self.range_m",
        test=f"{SEEN}::test_the_largest_pixel_lies_in_the_far_corner",
    ),
    Defect(
        name="a frame may reach the horizon",
        file="uwopt/solvers/exact/imagers.py",
        old='yield "horizon", all_of(view.farthest <= FARTHEST * ROUND for view in seen)',
        new='yield "horizon", all_of(view.farthest <= np.inf for view in seen)',
        test=f"{RULES}::test_a_rule_discards_what_is_a_millionth_outside[horizon]",
    ),
    Defect(
        name="outlines discard frames that stay below the horizon",
        file="uwopt/solvers/exact/outline.py",
        old='passes["horizon"] &= self.descents(scene, rows)[1] * FARTHEST * COARSE_ROUND >= 1.0',
        new='passes["horizon"] &= self.descents(scene, rows)[1] * FARTHEST >= 1.1',
        test=f"{RULES}::test_an_outline_keeps_what_is_inside[horizon]",
    ),
    Defect(
        name="physics paper looks obliquely",
        file="uwopt/forward/scene_checks.py",
        old='if mission.physics == "paper" and view.vehicle.pitch_deg:',
        new="if False:",
        test=f"{SEEN}::test_what_cannot_be_is_told_in_one_message",
    ),
    Defect(
        name="open water has a tilt",
        file="uwopt/mission/checks.py",
        old='if vehicle.get("pitch_deg"):',
        new="if False:",
        test=f"{SEEN}::test_what_cannot_be_is_told_in_one_message",
    ),
    Defect(
        name="samples lie as densely near as in the middle of an oblique image",
        file=BOUNDS,
        old="(centre_m / np.maximum(centre_m + slope * x_m, BESIDE_PORT * centre_m)) ** 3",
        new="np.minimum(centre_m / np.maximum(centre_m + slope * x_m, BESIDE_PORT * centre_m), 0.9) ** 3",
        test=f"{SEARCHED}::test_no_oblique_image_gets_more_light_than_its_bounds",
    ),
    Defect(
        name="samples of an oblique image are thought to lie as far apart ahead as behind",
        file=BOUNDS,
        old="np.maximum(steep_m - twist_m, 1e-12)",
        new="np.maximum(steep_m, 1e-12)",
        test=f"{SEARCHED}::test_traced_rays_stay_within_what_is_said_of_oblique_images",
    ),
    Defect(
        name="the part behind the axis of an oblique image ends where the flattest ray would",
        file=BOUNDS,
        old="/ (1.0 + slope * u * per_c)",
        new="/ (1.0 + slope * u * per_u)",
        test=f"{SEARCHED}::test_traced_rays_stay_within_what_is_said_of_oblique_images",
    ),
    Defect(
        name="oblique rays are thought to be as long as from an axis without a port",
        file=BOUNDS,
        old="field2 = aside2 / np.square(high_m + deepest_m)",
        new="field2 = aside2 / np.square(high_m)",
        test=f"{SEARCHED}::test_traced_rays_stay_within_what_is_said_of_oblique_images",
    ),
    Defect(
        name="light behind the axis of an oblique image does not count",
        file="uwopt/solvers/exact/light_tables.py",
        old="if self.behind is not None:",
        new="if False:",
        test=f"{SEARCHED}::test_no_oblique_image_gets_more_light_than_its_bounds",
    ),
    Defect(
        name="outlines take the near edge of oblique images for wider than it is",
        file="uwopt/solvers/exact/outline.py",
        old="near = 1.0 + scene.slope * along * self.per_metre(scene, rows, corner)",
        new="near = 1.0",
        test=f"{SEARCHED}::test_outlines_of_oblique_views_bound_their_imagers",
    ),
    Defect(
        name="outlines take the largest pixel of an oblique image for larger than it is",
        file="uwopt/solvers/exact/outline.py",
        old="return np.asarray(np.hypot(1.0, scene.slope) * np.maximum(middle, edge))",
        new="return np.asarray(1.3 * np.hypot(1.0, scene.slope) * np.maximum(middle, edge))",
        test=f"{SEARCHED}::test_outlines_of_oblique_views_bound_their_imagers",
    ),
    Defect(
        name="water is tabulated from the altitude on, which oblique rays from a dome undercut",
        file="uwopt/forward/problem.py",
        old="return max(float(scene.altitude_m[altitude]) - float(lower.max(initial=0.0)), 1e-4)",
        new="return float(scene.range_m[altitude])",
        test=f"{SEARCHED}::test_no_oblique_image_gets_more_light_than_its_bounds",
    ),
)

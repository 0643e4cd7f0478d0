"""Planted defects of what physics `auto` leaves out, and of light that is worked out once for two uses."""

from __future__ import annotations

from planted.defect import Defect

BOUNDS = "tests/forward/test_effects.py::test_no_effect_changes_more_than_its_bound"

DEFECTS: tuple[Defect, ...] = (
    Defect(
        name="bound of the forward veil a fifth too low",
        file="uwopt/forward/effects.py",
        old="return most * FORWARD_MARGIN",
        new="return most * 0.8 * FORWARD_MARGIN",
        test=f"{BOUNDS}[(13, 9)]",
    ),
    Defect(
        name="bound of backscatter half as high",
        file="uwopt/forward/effects.py",
        old="return most * margin(field)",
        new="return most * 0.5 * margin(field)",
        test=f"{BOUNDS}[(13, 10)]",
    ),
    Defect(
        name="bound of the window's angle a fifth too low",
        file="uwopt/forward/effects.py",
        old="(float(np.max(1.0 - oblique / head_on)), 0.0)",
        new="(0.8 * float(np.max(1.0 - oblique / head_on)), 0.0)",
        test=f"{BOUNDS}[(8, 5)]",
    ),
    Defect(
        name="darkest pixel taken for the mean where pixels count",
        file="uwopt/evaluation/design_light.py",
        old="return means.with_pixels(light)",
        new="return light",
        test="tests/evaluation/test_light_in_parts.py::test_light_with_pixels_has_the_means_and_pixels_of_light_taken_at_once",
    ),
    Defect(
        name="pixels of a figure at the lowest altitude",
        file="uwopt/evaluation/design_model.py",
        old="there = scene.nominal",
        new="there = 0",
        test="tests/evaluation/test_light_in_parts.py"
        "::test_pixels_at_the_nominal_altitude_are_those_that_a_mission_asks_for_at_all",
    ),
    Defect(
        name="a design evaluated has the light that a search left behind",
        file="uwopt/forward/remembered.py",
        old='    memory = "light of one image"',
        new='    memory = "light"',
        test="tests/evaluation/test_light_in_parts.py"
        "::test_light_of_a_design_is_that_of_its_image_alone_whatever_was_searched_before",
    ),
    Defect(
        name="polynomials of daylight end before the image does",
        file="uwopt/forward/sun_light.py",
        old="np.floor(STEPS_AN_OCTAVE * np.log2(tangent) + 1.0)",
        new="np.floor(STEPS_AN_OCTAVE * np.log2(tangent))",
        test="tests/forward/test_remembered.py::test_daylight_of_images_of_all_sizes_is_that_of_each_ray",
    ),
    Defect(
        name="daylight of one port is taken for that of another",
        file="uwopt/forward/sun_light.py",
        old='key = ("sun fit", self.multiple, self.shape, *water,',
        new='key = ("sun fit", *water,',
        test="tests/forward/test_remembered.py::test_daylight_of_images_of_all_sizes_is_that_of_each_ray",
    ),
    Defect(
        name="rows that agree in the first column count as alike",
        file="uwopt/forward/columns.py",
        old="new[1:] |= ordered[1:] != ordered[:-1]",
        new="new[1:] |= columns[0][order][1:] != columns[0][order][:-1]",
        test="tests/forward/test_columns.py::test_rows_that_agree_in_all_columns_are_found_once",
    ),
    Defect(
        name="few pixels of the sun are remembered as all",
        file="uwopt/forward/remembered.py",
        old="pixels, half_grid, few, points,",
        new="pixels, half_grid, points,",
        test="tests/forward/test_remembered.py::test_few_pixels_of_the_sun_alone_decide_as_all_do",
    ),
    Defect(
        name="the sun's few pixels are those of another question",
        file="uwopt/forward/sun_light.py",
        old="grid = likely_dark_places(view, pixels)",
        new='grid = likely_dark_places(view, "darkest")',
        test="tests/forward/test_remembered.py::test_few_pixels_of_the_sun_alone_decide_as_all_do",
    ),
    Defect(
        name="what stands for no lamp shines as one does",
        file="uwopt/forward/lamp_light.py",
        old="NEXT_TO_NONE_PER_M2 = 1e-9",
        new="NEXT_TO_NONE_PER_M2 = 1e6",
        test="tests/api/test_without_lamps.py::test_the_sun_alone_is_what_an_idle_lamp_leaves",
    ),
    Defect(
        name="the light of no lamp is integrated",
        file="uwopt/forward/lamp_light.py",
        old="return NoLampField if problem.is_dark(optics) else of_lamps",
        new="return of_lamps",
        test="tests/api/test_without_lamps.py::test_light_of_no_lamp_is_not_integrated",
    ),
)

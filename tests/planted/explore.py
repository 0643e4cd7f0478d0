"""Planted defects of plots and of the page that explores: what is drawn, and what the controls say."""

from __future__ import annotations

from planted.defect import Defect

PLOTS = "tests/explore/test_plotting.py"

DEFECTS = (
    Defect(
        name="a map's rows are its columns",
        file="uwopt/api/mapping.py",
        old="values[row][column], met[row][column] = found",
        new="values[row][column - 1], met[row][column] = found",
        test=f"{PLOTS}::test_map_holds_what_evaluate_says",
    ),
    Defect(
        name="the lamps' attenuation is drawn as the camera's",
        file="uwopt/report/pictures/passing.py",
        old="camera_leg_per_m=scene.attenuation_per_m,",
        new="camera_leg_per_m=2.0 * scene.attenuation_per_m,",
        test=f"{PLOTS}::test_attenuation_is_that_of_the_table",
    ),
    Defect(
        name="an image is empty",
        file="uwopt/report/pictures/static.py",
        old="for part, picture in zip(parts, pictures, strict=True):",
        new="for part, picture in zip(parts[:0], pictures[:0], strict=True):",
        test=f"{PLOTS}::test_images_are_images_of_every_pane",
    ),
)

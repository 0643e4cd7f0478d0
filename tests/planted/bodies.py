"""Planted defects of lamps' bodies: room between them, beside the port and beside the view."""

from __future__ import annotations

from planted.defect import Defect

PLACES, TESTS = "uwopt/forward/lamp_views.py", "tests/solvers/test_lamp_bodies.py"

DEFECTS = (
    Defect(
        name="lamps stand in the port",
        file=PLACES,
        old="return np.asarray(beside & apart)",
        new="return np.asarray((beside | True) & apart)",
        test=f"{TESTS}::test_no_lamp_stands_in_the_port",
    ),
    Defect(
        name="half of a lamp stands in the port",
        file=PLACES,
        old="(port_radius_m(problem, port) + 0.5 * size_m)",
        new="(port_radius_m(problem, port) + 0.0 * size_m)",
        test=f"{TESTS}::test_no_lamp_stands_in_the_port",
    ),
    Defect(
        name="lamps stand in one another",
        file=PLACES,
        old="return np.asarray(beside & apart)",
        new="return np.asarray(beside & (apart | True))",
        test=f"{TESTS}::test_more_than_two_lamps_with_bodies_stand_in_rows",
    ),
    Defect(
        name="a body may reach into the view",
        file=PLACES,
        old="return LAMP_FRONT_M if size_m is None else max(0.5 * size_m, LAMP_FRONT_M)",
        new="return LAMP_FRONT_M",
        test=f"{TESTS}::test_the_body_not_the_front_must_be_clear_of_the_view",
    ),
    Defect(
        name="margins take a lamp for its middle",
        file="uwopt/evaluation/design_model.py",
        old="beside = port_radius_m(problem, np.array([hw.port])) + 0.5 * size_m",
        new="beside = port_radius_m(problem, np.array([hw.port]))",
        test=f"{TESTS}::test_margins_tell_how_much_room_is_left",
    ),
    Defect(
        name="lamps of a side begin their row at the port's middle",
        file="uwopt/forward/lamps.py",
        old="x_m = (n // 2 - 0.5 * (of_side - 1)) * spacing_m",
        new="x_m = (n // 2) * spacing_m",
        test=f"{TESTS}::test_lamps_of_a_side_stand_in_a_row_about_the_middle_of_the_port",
    ),
    Defect(
        name="lamps anywhere are told as rows",
        file="uwopt/report/text/words.py",
        old="if len(steps) == 1 and centred and 0.0 not in steps else None",
        new="if steps else None",
        test="tests/report/test_words.py::test_lamps_in_rows_are_told_by_their_sides_and_steps",
    ),
    Defect(
        name="another number of lamps stands in a row's places",
        file=PLACES,
        old="if mount.explicit and len(mount.explicit) != count:",
        new="if False:",
        test=f"{TESTS}::test_a_row_is_for_its_own_number_of_lamps",
    ),
    Defect(
        name="physics paper puts lamps in rows",
        file="uwopt/forward/lamps.py",
        old='or mission.physics == "paper":',
        new="or False:",
        test=f"{TESTS}::test_a_system_of_four_lamps_has_them_in_rows",
    ),
    Defect(
        name="mounts in one another are not named",
        file="uwopt/forward/scene_checks.py",
        old="apart_m < vehicle.lamp_size_m * (1 - 1e-9):",
        new="apart_m < 0.0:",
        test=f"{TESTS}::test_mounts_in_one_another_are_named",
    ),
)

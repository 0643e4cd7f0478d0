"""Planted defects of what the catalogue knows of ports: mounts, and radii that are estimated."""

from __future__ import annotations

from planted.defect import Defect

DEFECTS = (
    Defect(
        name="ports of photo housings are searched alone",
        file="uwopt/catalog/mounts.py",
        old="return not mount or (mount in mount_table() and mount_table()[mount].free)",
        new="return True",
        test="tests/catalog/test_choose.py::test_a_port_of_a_photo_housing_waits_for_the_mount_the_port_or_its_owner",
    ),
    Defect(
        name="a pattern for many ports opens every mount",
        file="uwopt/catalog/choose.py",
        old="(None if wanted else self._needs_housing(part))",
        new="(None if wanted or patterns else self._needs_housing(part))",
        test="tests/catalog/test_choose.py::test_a_port_of_a_photo_housing_waits_for_the_mount_the_port_or_its_owner",
    ),
    Defect(
        name="a mission's mounts open nothing",
        file="uwopt/catalog/choose.py",
        old="in map(plain_name, self.wish.port_mounts):",
        new="in ():",
        test="tests/catalog/test_choose.py::test_a_port_of_a_photo_housing_waits_for_the_mount_the_port_or_its_owner",
    ),
    Defect(
        name="a cap is taken for a hemisphere",
        file="uwopt/catalog/readers/read_port.py",
        old='"photo housing": "spherical-cap"}',
        new='"photo housing": "hemisphere"}',
        test="tests/catalog/test_load.py::test_an_unknown_radius_lies_between_ends_and_at_their_geometric_mean",
    ),
    Defect(
        name="the centre of a radius is its good end",
        file="uwopt/catalog/readers/read_port.py",
        old="return Quantity(math.sqrt(low_mm * high_mm), low_mm",
        new="return Quantity(high_mm, low_mm",
        test="tests/catalog/test_load.py::test_an_unknown_radius_lies_between_ends_and_at_their_geometric_mean",
    ),
    Defect(
        name="a stated clear diameter is estimated again",
        file="uwopt/catalog/readers/read_port.py",
        old='known(row, "clear_diameter_mm", origin) or _clear_diameter(row)',
        new='_clear_diameter(row) or known(row, "clear_diameter_mm", origin)',
        test="tests/catalog/test_load.py::test_an_unknown_clear_diameter_is_eight_tenths_of_the_nominal_one",
    ),
    Defect(
        name="doubts see no radius",
        file="uwopt/solvers/explain/robustness.py",
        old='with_either_end(bad["port"]):',
        new='[bad["port"]]:',
        test="tests/solvers/test_robustness.py::test_a_dome_whose_radius_is_estimated_fails_at_whichever_end_harms",
    ),
    Defect(
        name="only a small dome is doubted",
        file="uwopt/solvers/one_hardware.py",
        old='known.low if end == "low" else known.high',
        new="known.low",
        test="tests/solvers/test_robustness.py::test_a_dome_whose_radius_is_estimated_fails_at_whichever_end_harms",
    ),
    Defect(
        name="rivals keep the radius that is estimated",
        file="uwopt/solvers/explain/robustness.py",
        old='else with_either_end(at_end(part, "good"))',
        new='else [at_end(part, "good")]',
        test="tests/solvers/test_robustness.py::test_a_rival_dome_may_have_any_radius_of_its_range",
    ),
    Defect(
        name="a price is a month older from the first on",
        file="uwopt/catalog/stale.py",
        old=" - (now[2] < then[2])",
        new="",
        test="tests/catalog/test_stale.py::test_a_price_is_as_old_as_whole_months_since_its_date",
    ),
    Defect(
        name="the least used is asked for first",
        file="uwopt/catalog/stale.py",
        old="key=lambda row: (-row.uses,",
        new="key=lambda row: (row.uses,",
        test="tests/catalog/test_stale.py::test_what_recommendations_rest_on_comes_first_and_alone",
    ),
    Defect(
        name="an estimated price is a quote",
        file="uwopt/catalog/stale.py",
        old='part.price is None or part.price.status == "estimated"',
        new="part.price is None",
        test="tests/catalog/test_stale.py::test_each_fault_of_a_row_is_told",
    ),
    Defect(
        name="the bill keeps silent on what a port needs behind it",
        file="uwopt/evaluation/bill.py",
        old="words = [made_for, needs, part.note]",
        new="words = [made_for, part.note]",
        test="tests/evaluation/test_design_model.py::test_what_limits_a_port_stands_in_the_bill",
    ),
    Defect(
        name="ports of one name share their views, whatever their radius",
        file="uwopt/forward/problem.py",
        old="(part.id, *(float(column[index]) for column in columns))",
        new="part.id",
        test="tests/solvers/test_robustness.py::test_a_dome_whose_radius_is_estimated_fails_at_whichever_end_harms",
    ),
)

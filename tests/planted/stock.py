"""Planted defects of what the catalogue knows of ports: their mounts."""

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
)

"""Generic parts "to be made": classes of lamps and ports that no shop sells under a name."""

from __future__ import annotations

from uwopt.catalog.columns import Kind

#: Kind -> file of generic parts, in the columns of the built-in files.
GENERIC_FILES: dict[Kind, str] = {"port": "generic_ports.csv", "light": "generic_lights.csv"}
GENERIC_PREFIX = "generic-"


def is_generic_id(part_id: str) -> bool:
    """Whether an id names a part to be made."""
    return part_id.casefold().replace("_", "-").startswith(GENERIC_PREFIX)

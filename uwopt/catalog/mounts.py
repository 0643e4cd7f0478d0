"""What ports are fastened to: free flanges, tube series sold as parts, and housings that take no other camera."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from uwopt.catalog.tables import built_in_rows


@dataclass(frozen=True, slots=True)
class PortMount:
    """One row of port_mounts.csv: what a port of that mount is fastened to, and whether a camera of one's own fits."""

    on: str  # photo housing, chamber, tube series
    free: bool


@cache
def mount_table() -> dict[str, PortMount]:
    """All known mounts by name."""
    return {
        row["mount"]: PortMount(row["on"], row["free"] == "yes")
        for row in built_in_rows("port_mounts.csv")
    }


def is_free(mount: str) -> bool:
    """Whether a port of that mount serves without a housing of its maker; a mount that nobody knows does not."""
    return not mount or (mount in mount_table() and mount_table()[mount].free)


def counterpart(mount: str) -> str:
    """What a port of that mount needs behind it, in words."""
    found = mount_table().get(mount)
    return f"a {found.on} with the mount {mount}" if found else f"a housing with the mount {mount}"

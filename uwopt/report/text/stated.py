"""What the catalogue's tables state of a part that an order names."""

from __future__ import annotations

from uwopt.catalog.interfaces import fed_v


def cells_of(part_id: str) -> dict[str, str]:
    """The cells of a part of the catalogue as they stand in its table; none of a part of one's own."""
    from uwopt.catalog.changes import built_in_cells
    from uwopt.documents.faults import plain_name

    for origin in ("published", "generic"):
        found = built_in_cells(origin).get(plain_name(part_id))
        if found is not None:
            return {name: text for name, text in found[1].cells.items() if text}
    return {}


def has_own_battery(part_id: str) -> bool:
    """Whether the catalogue states that a lamp burns on a battery of its own."""
    return cells_of(part_id).get("supply") == "battery"


def supply_volts(part_id: str) -> str:
    """The voltage that a part is fed with in words, `12 to 24 V`; empty where the catalogue does not state it."""
    cells = cells_of(part_id)
    low, high = (cells.get(name, "") for name in ("supply_v_min", "supply_v_max"))
    interface = cells.get("interface", "")
    if not (low or high) and (over := span_text(*fed_v(interface))):
        return f"{over} over its {interface} cable"
    return span_text(low, high)


def span_text(low: str, high: str) -> str:
    """`12 to 24 V`, or what is known of it."""
    if low and high:
        return f"{low} V" if low == high else f"{low} to {high} V"
    return f"at least {low} V" if low else f"at most {high} V" if high else ""

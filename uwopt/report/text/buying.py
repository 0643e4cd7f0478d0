"""What to buy, how to set it, and what it costs."""

from __future__ import annotations

from uwopt.report.text import formats, words
from uwopt.report.text.layout import Block, Line, Text, block, columns, fact_lines
from uwopt.report.text.not_counted import not_counted
from uwopt.report.text.tables import (
    hardware_block,
    rounding_lines,
    scenes_to_set,
    settings_table,
)
from uwopt.results.design import (
    BillRow,
    Cost,
    Design,
)
from uwopt.results.result import Result
from uwopt.units import counted, format_within

SHARED_FOCUS = "nearer than what is sharp, on purpose: middle and corners of a curved image share it"
GIVEN_FOCUS = "nearer than what is sharp: the corners of a curved image are sharp farther away than its middle"
BATTERY, MUCH = "rest-battery", 0.4  # its line of the bill, and of the price from which it is named


def buy_block(design: Design, title: str) -> Block:
    """Parts with number and what is to pay for them, as a range."""
    heads = (("", "right"), ("part", "left"), ("name", "left"), ("to pay", "right"), ("price", "left"))
    table = columns(*heads)
    for row in design.bom:
        kind = formats.one_line(row.kind, 12)
        texts = (f"{row.count} x", kind, bought_name(row), formats.due_text(row), formats.known_price(row))
        table.add_row(*map(Text, texts))
    if not design.bom:
        table = hardware_block(design, "").lines[0]
    return block(title, [table])


def bought_name(row: BillRow) -> str:
    """Maker and model; of a class of parts its name and that it is to be made."""
    return words.made_name(f"{row.manufacturer} {row.model}".strip() or row.id, generic=row.generic)


def focused_before_the_sharp(design: Design) -> bool:
    """Whether the lens is focused nearer than the nearest that is sharp all over the image, as behind a dome."""
    return any(
        (focus := scene.settings.get("focus_distance_m")) is not None
        and focus < (scene.figures.get("dof_near_m") or 0.0)
        for scene in design.as_set.scenes
    )


def set_block(result: Result, design: Design) -> Block:
    """Settings to type in, and how camera and lights stand."""
    hardware = design.hardware
    stands = [
        ("camera", words.camera_stand(hardware)),
        ("lights", words.mounts_text(hardware.light_mounts)),
    ]
    if focused_before_the_sharp(design):
        stands.insert(0, ("focus", GIVEN_FOCUS if result.command == "evaluate" else SHARED_FOCUS))
    lines: list[Line] = [settings_table(scenes_to_set(design), exact=False), fact_lines(stands)]
    if design.rounded is None or not design.is_settable:
        lines += rounding_lines(result, design)
    return block("Set", lines)


def cost_block(result: Result, design: Design) -> Block:
    """Money as a range, and against the limit; power and mass."""
    cost, totals = design.totals.cost, design.totals
    text = formats.cost_text(cost)
    if formats.money(cost.low) != formats.money(cost.high):
        text += f", {middle_price(result, cost)}"
    if cost.value:
        text += f"; {words.quoted_share(cost)}"
    unpriced = words.n_unpriced(design.bom)
    if unpriced and not cost.value:
        text = "not known"
    elif unpriced:
        text += f"; without {counted(unpriced, 'part')} of unknown price"
    facts = [("price", text)]
    limit = (result.mission.get("limits") or {}).get("cost")
    if isinstance(limit, (int, float)) and cost.high > limit:
        end = "Its high end" if cost.value <= limit else "It"
        facts.append(("", f"{end} is above your limit of {formats.money(float(limit), cost.currency)}."))
    if said := dear_battery(design):
        facts.append(("most of it", said))
    if said := not_in_it(result, design):
        facts.append(("not in it", said))
    facts.append(("power", power_text(design)))
    if totals.mass_kg:
        facts.append(("mass", formats.quantity(totals.mass_kg, "kg") + words.housing_clause(totals)))
    if used_up := words.used_up_clause(totals).removeprefix(", "):
        facts.append(("used up", used_up))
    return block("What it costs", [fact_lines(facts)])


def middle_price(result: Result, cost: Cost) -> str:
    """The middle of a price that is a range: where scenarios drew it their median, else the sum of what is likeliest.

    Prices lean to the high side, so that the median of a sum is more than the sum of what is likeliest of each.
    """
    known = result.confidence
    if known is not None and known.price_p50 is not None and cost.low <= known.price_p50 <= cost.high:
        return f"median about {format_within(known.price_p50, cost.low, cost.high)}"
    return f"sum of the likeliest prices about {format_within(cost.value, cost.low, cost.high)}"


def dear_battery(design: Design) -> str:
    """The battery that a mission asks for by its size, where it takes much of the price; else nothing.

    It is no part that a search could choose another of: only the mission can ask for less.
    """
    row, cost = next((row for row in design.bom if row.id == BATTERY), None), design.totals.cost
    if row is None or not row.unit_price or not cost.value or row.unit_price * row.to_buy < MUCH * cost.value:
        return ""
    share = 100.0 * row.unit_price * row.to_buy / cost.value
    used_wh = design.totals.energy_wh
    of_it = "" if used_wh is None else f", of which the mission uses up {formats.quantity(used_wh, 'Wh')}"
    return f"{bought_name(row)}{of_it}: {formats.due_text(row)}, {share:.0f} % of the price; vehicle.battery_wh sets it"


def not_in_it(result: Result, design: Design) -> str:
    """What must be bought and is not in the price."""
    return ", ".join(item.what for item in not_counted(result, design) if item.bought)


def power_text(design: Design) -> str:
    """`3.05 W on average, the lamps 638 W while they burn`, at the settings to type in where there are any."""
    text = f"{formats.quantity(design.power_as_set_w, 'W')} on average"
    if burning := words.burning_text(design):
        text += f", the {burning}"
    return text

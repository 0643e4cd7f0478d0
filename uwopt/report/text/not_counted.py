"""What an order needs beside the lines of its bill, with what the result knows of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from uwopt.catalog.interfaces import IN_HOUSING
from uwopt.report.text import formats, words
from uwopt.report.text.helps import factor_of_depth
from uwopt.report.text.stated import cells_of, has_own_battery, supply_volts
from uwopt.results.design import BillRow, Design
from uwopt.results.result import Result
from uwopt.units import counted, format_number


@dataclass(frozen=True)
class NotCounted:
    """Something to be bought whose price is not in the sum, or to be asked for it."""

    what: str
    known: str
    bought: bool = True


def not_counted(result: Result, best: Design) -> list[NotCounted]:
    """What the bill lacks; what it holds already is not named."""
    return list(_not_counted(result, best))


def _not_counted(result: Result, best: Design) -> Iterator[NotCounted]:
    ids = {row.id for row in best.bom}
    hardware, totals = best.hardware, best.totals
    depth = formats.quantity(depth_m(result), "m")
    cameras = counted(hardware.camera_count, "camera")
    if hardware.housing is None and hardware.complete is None:
        yield NotCounted(
            "housing",
            f"one for each of {cameras}, {words.part_name(hardware.camera)} with {words.part_name(hardware.lens)}; "
            f"rated {depth} or more; takes the port {words.part_name(hardware.port)}",
        )
    if not any(name.startswith(("rest-camera-connection", "rest-lamp-connection")) for name in ids):
        lamps = counted(hardware.light_count, "lamp")
        yield NotCounted("connectors and cables", f"for {cameras} and {lamps}, rated {depth} or more")
    if "host-computer" not in ids:
        rate = max((float(s.figures.get("data_rate_mb_s") or 0.0) for s in best.scenes), default=0.0)
        yield NotCounted(
            "computer with storage",
            f"takes {formats.quantity(rate, 'mb_s')}, {formats.quantity(3.6 * rate, 'gb')} in an hour, "
            "as images are taken",
        )
    if "rest-battery" not in ids:
        energy = "" if totals.energy_wh is None else f"; {formats.quantity(totals.energy_wh, 'wh')} over the mission"
        burning = words.burning_text(best)
        drawn = f"{formats.quantity(totals.power_w, 'w')} on average{burning and ', '}{burning}{energy}"
        if own := brings_batteries(result, best):
            yield NotCounted("batteries", f"{drawn}; {own}")
        else:
            yield NotCounted("power from the vehicle", f"{drawn}; vehicle.supply: battery brings one", bought=False)
    if lasts := charge_needed(result, best):
        yield NotCounted("charge of the lamps", lasts, bought=False)
    in_camera = hardware.housing is not None and any(row.note.startswith(IN_HOUSING) for row in best.bom)
    apart = [name for name in UNHOUSED if name != "host-computer" or not in_camera]
    if inside := [row.model for row in best.bom if row.id in apart]:
        what = "a place for computer and electronics" if "host-computer" in ids and not in_camera else ELECTRONICS
        yield NotCounted(what, place_needed(inside, depth))
    if (lift_kg := -(totals.mass_water_kg or 0.0)) > FLOATS_KG:
        yield NotCounted("ballast", ballast_needed(lift_kg))
    if growth := growth_kept_off(result):
        yield NotCounted("what keeps growth off", growth)
    if corrosion := corrosion_kept_off(result, best):
        yield NotCounted("what keeps corrosion off", corrosion)
    if fed := supply_voltages(best.bom):
        yield NotCounted("supply voltages", fed, bought=False)
    if "rest-spares" in ids:
        yield NotCounted("spare cameras and lamps", "O-rings and fuses are a line above")
    else:
        yield NotCounted("spares", "none is counted")
    yield NotCounted("shipping and insurance", "not known")


#: Lines of a bill that have neither size nor mass there, and are no cable.
UNHOUSED = ("host-computer", "rest-lamp-control", "rest-synchronisation", "rest-link")
ELECTRONICS = "a place for electronics"
LEAD_KG_L, WATER_KG_L = 11.34, 1.025  # lead at 20 C (CRC handbook), sea water
FLOATS_KG = 0.1  # of lift that nobody need make up for
GROWS_H, LIT_M = 336.0, 200.0  # from two weeks on, and down to the depth that sunlight reaches: both by convention
FRESH_PSU = 0.5  # from here on water is brackish (Venice system)
FED = ("camera", "complete", "light")  # kinds of parts that take power; so does the computer


def brings_batteries(result: Result, best: Design) -> str:
    """What of a system feeds itself, though no battery is a line of its bill; empty where the vehicle feeds it all."""
    if best.hardware.complete is not None and best.totals.run_time_h is not None:
        return "the cameras have their own: spare ones"
    asked = (result.mission.get("vehicle") or {}).get("lamp_supply") == "battery"
    own_lamps = asked or has_own_battery(best.hardware.light.id)
    return "the lamps have their own, the vehicle feeds the rest" if own_lamps and best.hardware.light_count else ""


def charge_needed(result: Result, best: Design) -> str:
    """How long lamps with batteries of their own must burn, where no source states how long these last; else empty."""
    hours, light = (result.mission.get("vehicle") or {}).get("duration_h"), best.hardware.light
    cells = cells_of(light.id) if best.hardware.light_count else {}
    if hours is None or cells.get("supply") != "battery" or cells.get("run_time_min"):
        return ""
    needed = formats.quantity(hours, "h")
    return f"nobody states how long {words.part_name(light)} burns at full; {needed} are needed: ask"


def place_needed(names: Sequence[str], depth: str) -> str:
    """Where what has no size and no mass in the bill must go."""
    return (
        f"{', '.join(names)}: neither size nor mass is counted, nor a housing for them; the cameras' housings are "
        "chosen for camera and lens alone. Ask whether a housing of the vehicle has room; else one more is to be "
        f"bought, rated {depth} or more"
    )


def ballast_needed(lift_kg: float) -> str:
    """What keeps housings down that float: lead weighs 1 / (1 - its water's density over its own) of that in air."""
    lead = formats.quantity(lift_kg / (1.0 - WATER_KG_L / LEAD_KG_L), "kg", 3)
    lift = formats.quantity(lift_kg, "kg", 3)
    return f"cameras in their housings float with {lift}; {lead} of lead hold them; lamps and cables are not counted"


def days_that_tell(result: Result) -> str:
    """How many days a system stays under water, where these are weeks; empty elsewhere."""
    hours = (result.mission.get("vehicle") or {}).get("duration_h")
    return "" if hours is None or hours < GROWS_H else format_number(hours / 24.0)


def growth_kept_off(result: Result) -> str:
    """What keeps port and lamps clear where they stay for weeks in water that light reaches; empty elsewhere."""
    days = days_that_tell(result)
    depths = [scene["depth_m"] for scene in result.mission.get("scenes") or [] if scene.get("depth_m") is not None]
    if not days or not depths or min(depths) > LIT_M:
        return ""
    return (
        f"{days} days under water: what grows on port and lamps takes light and is not "
        "modelled; ask for a wiper, copper around the port, or a coating"
    )


def corrosion_kept_off(result: Result, best: Design) -> str:
    """What protects housings of aluminium that stay for weeks in salt water; empty where there are none."""
    days = days_that_tell(result)
    salt = any(scene.get("salinity_psu", 0.0) > FRESH_PSU for scene in result.mission.get("scenes") or [])
    named = [best.hardware.housing, best.hardware.light if best.hardware.light_count else None]
    wet = [words.part_name(part) for part in named if part is not None]
    if not days or not salt or not any("aluminium" in name.casefold() for name in wet):
        return ""
    return (
        f"{days} days in salt water: aluminium pits where its skin is scratched, and is eaten "
        "where it touches steel or titanium; ask for anodes, and for mounts that keep them apart"
    )


def supply_voltages(rows: Sequence[BillRow]) -> str:
    """At what voltage each part that takes power is fed, and what is to be asked; empty where none takes any."""
    fed = {row.id: supply_volts(row.id) for row in rows if row.kind in FED or row.id == "host-computer"}
    known = [f"{name}: {volts}" for name, volts in fed.items() if volts]
    unknown = [name for name, volts in fed.items() if not volts]
    ask = f"supply voltage not known: ask, for {', '.join(unknown)}" if unknown else ""
    return "; ".join(text for text in (*known, ask) if text)


def depth_m(result: Result) -> float | None:
    """The depth that every part must be rated for: what the mission asks for, or its deepest scene and its reserve."""
    asked = (result.mission.get("limits") or {}).get("depth_rating_m")
    scenes = [scene.get("depth_m") for scene in result.mission.get("scenes") or []]
    known_m = [float(value) for value in (asked, *scenes) if value is not None]
    return max(known_m) * factor_of_depth(result.mission) if known_m else None

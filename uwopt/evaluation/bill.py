"""A design as parts to buy: hardware by ids, bill of materials, cost with its range."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from uwopt.catalog.interfaces import IN_HOUSING, does_reach, leaves_housing, reaches_m
from uwopt.catalog.mounts import counterpart, is_free
from uwopt.catalog.records import Camera, Part, Port, Quantity
from uwopt.catalog.rest import RestItem, disk_item
from uwopt.catalog.spacers import rings_in_words, spacer_mass_g, spacer_price
from uwopt.forward.adapters import adapter_of
from uwopt.forward.designs import Hardware
from uwopt.forward.problem import Problem
from uwopt.results.design import BillRow, Cost, LampPlace, UsedHardware, UsedPart

PLAIN_PURPOSES = ("camera port", "vehicle lamp", "industrial camera")  # made for what they are bought for


def used_hardware(problem: Problem, hw: Hardware, spacer_m: float) -> UsedHardware:
    """The hardware by ids, and where its lights stand."""
    parts = problem.parts.of(hw)
    port = parts["port"]
    asked = problem.mission.catalog.housing != "none"
    housing = port.housing if asked or not port.complete else None  # as of the other designs beside it
    return UsedHardware(
        **{kind: used_part(part) for kind, part in parts.items()},
        camera_count=problem.mission.vehicle.camera_count,
        light_count=problem.lamps_carried(hw),
        orientation="landscape" if hw.landscape else "portrait",
        light_mounts=[] if problem.unlit(hw.light) else lamp_places(hw),
        housing=None if housing is None else used_part(housing),
        spacer_mm=spacer_m * 1e3,
        complete=used_part(whole(port)) if port.complete else None,
        camera_baseline_m=problem.mission.vehicle.camera_baseline_m,
        camera_convergence_deg=problem.mission.vehicle.camera_convergence_deg,
    )


def whole(port: Port) -> Port:
    """The complete camera that a port is a piece of, by what is bought: its price, mass and source are the port's."""
    return replace(port, id=port.complete)


def used_part(part: Part) -> UsedPart:
    """A part by its names."""
    return UsedPart(part.id, f"{part.manufacturer} {part.model}".strip() or part.id, part.generic)


def lamp_places(hw: Hardware) -> list[LampPlace]:
    """Lamps where the mission has them, or alternately at plus and minus the baseline."""
    if hw.mount.explicit:
        return [LampPlace(**place.model_dump()) for place in hw.mount.explicit]
    sides_m = (hw.mount.baseline_m, -hw.mount.baseline_m)
    return [LampPlace(0.0, sides_m[n % 2], 0.0, 0.0, hw.mount.tilt_deg) for n in range(hw.count)]


def bought(problem: Problem, hw: Hardware) -> list[tuple[str, Part, int, int]]:
    """Each part of a design with how many there are and how many of them are owned."""
    parts, n = problem.parts.of(hw), problem.mission.vehicle.camera_count
    light, port = parts["light"], parts["port"]
    owned = min(hw.count, problem.owned_lights.get(light.id, 0))
    lamps: list[tuple[str, Part, int, int]] = [("light", light, hw.count, owned)]
    burning = [] if problem.unlit(hw.light) else lamps
    if port.complete:
        return [("complete", whole(port), n, 0), *burning]
    return [
        *((kind, parts[kind], n, 0) for kind in ("camera", "lens", "port")),
        *([] if port.housing is None else [("housing", port.housing, n, 0)]),
        *burning,
    ]


def price_status(part: Part) -> str:
    """How the price is known, in one word."""
    if part.price is None:
        return "unknown"
    if part.generic:
        return "to be made"
    return {"published": "list", "user": "own", "quoted": "quoted"}.get(part.price.status, part.price.status)


def bill_of_materials(
    problem: Problem, hw: Hardware, spacer_m: float = 0.0, drawn_w: Mapping[str, float] | None = None,
    disks_gb: float = 0.0,
) -> list[BillRow]:  # fmt: skip
    """What to order: part, number, price with its range and status, source; mass, and mean power by `drawn_w`."""
    drawn = drawn_w or {}
    currency = problem.mission.limits.currency
    rows = []
    for kind, part, count, owned in bought(problem, hw):
        price = part.price or Quantity(0.0, 0.0, 0.0, "user")
        rate = problem.money(1.0, part.currency)
        value, low, high = (rate * end if part.price else None for end in (price.value, price.low, price.high))
        rows.append(
            BillRow(
                kind=kind, id=part.id, manufacturer=part.manufacturer, model=part.model, count=count, owned=owned,
                unit_price=value, unit_price_low=low, unit_price_high=high, currency=currency,
                price_status=price_status(part), price_date=part.price_date, generic=part.generic,
                source=part.source_url, price_basis=price.source, note=remark(part), purpose=purpose_of(kind, part),
                availability="" if part.generic or part.inline else part.availability, checked=part.checked,
                unit_mass_kg=None if part.mass_g is None else 1e-3 * part.mass_g.value, power_w=drawn.get(kind),
            )
        )  # fmt: skip
    camera = problem.parts.cameras[hw.camera]
    if problem.counts_host and camera.takes_a_host:
        rows.append(replace(host_row(problem, camera), power_w=drawn.get("computer")))
    rows += [rest_row(problem, item, count) for item, count in beside_parts(problem, hw, spacer_m, disks_gb)]
    return rows + [
        BillRow(
            kind="extra", id=extra.name, manufacturer="", model=extra.name, count=1, owned=0,
            unit_price=extra.cost, unit_price_low=extra.cost, unit_price_high=extra.cost, currency=currency,
            price_status="own", price_date="", generic=False, source="mission", price_basis="", purpose="extra",
            unit_mass_kg=extra.mass_kg, power_w=extra.power_w,
        )
        for extra in problem.mission.catalog.extras
    ]  # fmt: skip


def remark(part: Part) -> str:
    """What a buyer must know of a part: what it was made for, what it is fastened to, and the catalogue's note."""
    purpose = getattr(part, "purpose", "")
    made_for = "" if purpose in ("", *PLAIN_PURPOSES) else f"made as {'an' if purpose[0] in 'ai' else 'a'} {purpose}"
    words = [made_for, part.note]
    if isinstance(part, Port) and not part.complete:
        needs = "" if is_free(part.mount) else f"needs {counterpart(part.mount)}; the adapter is not in the bill"
        words = [made_for, needs, part.note]
    return "; ".join(word for word in words if word)


#: What a part does in the system, where the catalogue does not say what it was made for.
PURPOSES = {"port": "camera port", "housing": "housing of a camera", "light": "lamp"}


def purpose_of(kind: str, part: Part) -> str:
    """What a part was made for."""
    return getattr(part, "purpose", "") or PURPOSES.get(kind, kind)


def host_row(problem: Problem, camera: Camera) -> BillRow:
    """The computer that takes the images: one for all cameras, or one beside each where its cable does not reach."""
    rate, price = problem.money(1.0, "USD"), camera.host_price or Quantity(0.0, 0.0, 0.0, "user")
    beside = problem.beside_camera(camera)
    return BillRow(
        kind="extra", id="host-computer", manufacturer="",
        model=f"computer {'beside each camera' if beside else 'that takes the images'}",
        count=problem.computers(camera), owned=0, purpose="computer",
        note=place_of_computer(camera.interface, problem.mission.vehicle.cable_m),
        unit_price=rate * price.value, unit_price_low=rate * price.low, unit_price_high=rate * price.high,
        currency=problem.mission.limits.currency,
        price_status="own" if price.status == "user" else price.status,
        price_date="", generic=False, source="class estimate by the camera's interface",
        price_basis=price.source,
    )  # fmt: skip


def place_of_computer(interface: str, cable_m: float | None) -> str:
    """Where the computer must stand, as far as the cables of an interface tell."""
    reach_m = reaches_m().get(interface)
    if not leaves_housing(interface):
        return f"{IN_HOUSING}, for {interface} reaches {reach_m:g} m"
    if does_reach(interface, cable_m):
        return ""
    reach = f"{interface} reaches {reach_m:g} m" if reach_m else "how far its interface reaches is not known"
    return f"{reach}, {cable_m:g} m are asked for; that it fits into the housing is not checked"


def beside_parts(problem: Problem, hw: Hardware, spacer_m: float, disks_gb: float) -> list[tuple[RestItem, int]]:
    """What is bought beside parts and computer, with how many: flanges, rings, disks and the rest of the system."""
    cameras = problem.mission.vehicle.camera_count
    made = []
    if (flange := adapter_of(problem.parts.ports[hw.port])) is not None:
        name = f"adapter flange of {flange.wide_mm:.0f} mm between port and housing"
        made.append((RestItem("adapter-flange", name, "camera", flange.price, flange.mass_g), cameras))
    if spacer_m > 0.0:
        rings = rings_in_words(problem.parts.lenses[hw.lens].mounts, spacer_m * 1e3)
        name = f"spacer ring {rings} between lens and camera"
        made.append((RestItem("spacer-ring", name, "camera", spacer_price(), spacer_mass_g()), cameras))
    lamps = sum(count - owned for kind, _, count, owned in bought(problem, hw) if kind == "light")
    cables = cameras if problem.parts.cameras[hw.camera].tethered else 0
    wired = int(problem.wired[hw.light])
    numbers = {"system": 1, "camera": cables, "lamp": wired * lamps, "lighting": wired}
    if disks_gb > 0.0:
        computers = problem.computers(problem.parts.cameras[hw.camera])
        made.append((disk_item(disks_gb / computers, computers), computers))
    return made + [(item, numbers[item.per]) for item in problem.rest if numbers[item.per]]


def rest_row(problem: Problem, item: RestItem, count: int) -> BillRow:
    """What every system needs beside its parts."""
    rate, price = problem.money(1.0, "USD"), item.price
    return BillRow(
        kind="extra", id=item.id, manufacturer="", model=item.name, count=count, owned=0,
        unit_price=rate * price.value, unit_price_low=rate * price.low, unit_price_high=rate * price.high,
        currency=problem.mission.limits.currency, price_status=price.status, price_date="", generic=False,
        source="class estimate", price_basis=price.source, purpose="rest of the system",
        unit_mass_kg=None if item.mass_g is None else 1e-3 * item.mass_g.value,
    )  # fmt: skip


def cost_range(problem: Problem, rows: Sequence[BillRow]) -> Cost:
    """Cost of a bill with the range that estimated prices leave, and how much of it is estimated."""

    def total(price: str, *, of_estimates: bool = False) -> float:
        wanted = (row for row in rows if row[price] is not None and (row.estimated or not of_estimates))
        return float(sum(row.to_buy * row[price] for row in wanted))

    prices = ("unit_price", "unit_price_low", "unit_price_high")
    value, low, high = (total(price) for price in prices)
    estimated = (total(price, of_estimates=True) for price in prices)
    return Cost(value, low, high, problem.mission.limits.currency, *estimated)

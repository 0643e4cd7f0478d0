"""A design as parts to buy: hardware by ids, bill of materials, cost with its range."""

from __future__ import annotations

from typing import Any

from uwopt.catalog.records import Part, Quantity
from uwopt.forward.designs import Hardware
from uwopt.forward.problem import Problem


def hardware_dict(problem: Problem, hw: Hardware) -> dict[str, Any]:
    """The hardware by ids, and where its lights stand."""
    parts = problem.parts
    mounts = (
        [m.model_dump(mode="json") for m in hw.mount.explicit] if hw.mount.explicit else default_mounts(hw)
    )
    return {
        **{
            kind: {
                "id": part.id,
                "name": f"{part.manufacturer} {part.model}".strip() or part.id,
                "generic": part.generic,
            }
            for kind, part in (
                ("camera", parts.cameras[hw.camera]),
                ("lens", parts.lenses[hw.lens]),
                ("port", parts.ports[hw.port]),
                ("light", parts.lights[hw.light]),
            )
        },
        "camera_count": problem.mission.vehicle.camera_count,
        "light_count": hw.count,
        "orientation": "landscape" if hw.landscape else "portrait",
        "light_mounts": mounts,
    }


def default_mounts(hw: Hardware) -> list[dict[str, float]]:
    """Lamps alternately at plus and minus the baseline."""
    return [
        {
            "x_m": 0.0,
            "y_m": hw.mount.baseline_m * (1.0 if n % 2 == 0 else -1.0),
            "z_m": 0.0,
            "tilt_x_deg": 0.0,
            "tilt_y_deg": hw.mount.tilt_deg,
        }
        for n in range(hw.count)
    ]


def bought(problem: Problem, hw: Hardware) -> list[tuple[str, Part, int, int]]:
    """Each part of a design with how many there are and how many of them are owned."""
    parts, n = problem.parts, problem.mission.vehicle.camera_count
    light = parts.lights[hw.light]
    owned = min(hw.count, problem.owned_lights.get(light.id, 0))
    return [
        ("camera", parts.cameras[hw.camera], n, 0),
        ("lens", parts.lenses[hw.lens], n, 0),
        ("port", parts.ports[hw.port], n, 0),
        ("light", light, hw.count, owned),
    ]


def price_status(part: Part) -> str:
    """How the price is known, in one word."""
    if part.price is None:
        return "unknown"
    if part.generic:
        return "to be made"
    return {"published": "list", "user": "own", "quoted": "quoted"}.get(part.price.status, part.price.status)


def bill_of_materials(problem: Problem, hw: Hardware) -> list[dict[str, Any]]:
    """What to order: part, number, price with its range and status, source."""
    currency = problem.mission.limits.currency
    rows = []
    for kind, part, count, owned in bought(problem, hw):
        price = part.price or Quantity(0.0, 0.0, 0.0, "user")
        rate = problem.money(1.0, part.currency)
        rows.append(
            {
                "kind": kind, "id": part.id, "manufacturer": part.manufacturer, "model": part.model, "count": count,
                "owned": owned, "unit_price": price.value * rate if part.price else None,
                "unit_price_low": price.low * rate if part.price else None,
                "unit_price_high": price.high * rate if part.price else None, "currency": currency,
                "price_status": price_status(part), "price_date": part.price_date, "generic": part.generic,
                "source": part.source_url, "price_basis": price.source,
            }
        )  # fmt: skip
    extras = problem.mission.catalog.extras
    return rows + [
        {
            "kind": "extra", "id": extra.name, "manufacturer": "", "model": extra.name, "count": 1, "owned": 0,
            "unit_price": extra.cost, "unit_price_low": extra.cost, "unit_price_high": extra.cost,
            "currency": currency, "price_status": "own", "price_date": "", "generic": False, "source": "mission",
            "price_basis": "",
        }
        for extra in extras
    ]  # fmt: skip


def cost_range(problem: Problem, hw: Hardware) -> dict[str, Any]:
    """Cost with the range that estimated prices leave, and how much of it is estimated."""
    value = low = high = estimated = estimated_low = estimated_high = 0.0
    for row in bill_of_materials(problem, hw):
        number = row["count"] - row["owned"]
        if row["unit_price"] is None:
            continue
        value += number * row["unit_price"]
        low += number * row["unit_price_low"]
        high += number * row["unit_price_high"]
        if row["price_status"] in ("estimated", "to be made"):
            estimated += number * row["unit_price"]
            estimated_low += number * row["unit_price_low"]
            estimated_high += number * row["unit_price_high"]
    return {
        "value": value, "low": low, "high": high, "currency": problem.mission.limits.currency,
        "estimated": estimated, "estimated_low": estimated_low, "estimated_high": estimated_high,
    }  # fmt: skip

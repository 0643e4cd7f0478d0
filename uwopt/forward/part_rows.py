"""Parts of each kind made into columns: at the central values of what is estimated, or at an end."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from functools import cache

import numpy as np

from uwopt.arrays import Array
from uwopt.catalog.compatibility import rated_pitch_um
from uwopt.catalog.parts.cell import Field, kept_fields
from uwopt.catalog.parts.kinds import FAVOURED
from uwopt.catalog.records import Camera, Curve, Housing, Lens, Light, Part, Port, Quantity
from uwopt.catalog.rest import DISK_GB
from uwopt.forward.adapters import NO_ADAPTER, adapter_of
from uwopt.forward.columns import Columns, each_once
from uwopt.forward.part_columns import CONTINUOUS, FLASH, PULSED, Cameras, End, Lenses, Lights, Ports
from uwopt.model import flash as flash_model
from uwopt.model.aberration import aberration_at_f1, aberration_exponent
from uwopt.model.hull import SEAWATER_KG_M3
from uwopt.model.light import flash_light_lm_s, measured_lumens
from uwopt.units import convert, db_to_ratio

Money = Callable[[float, str], float]  # amount, currency -> amount in the mission's currency
KIND_CODES = {"continuous": CONTINUOUS, "pulsed_led": PULSED, "flash": FLASH}
PAPER_BITS = 16
NOT_IN_PAPER = ("black_level_dn", "exposure_offset_s", "dark_current_e_s", "prnu_frac")
SI_UNITS = {"um": "m", "mm": "m", "us": "s", "g": "kg"}


def number(
    quantity: Quantity | float | None, default: float, end: End = "central", favoured: int = 0
) -> float:
    """The value of a quantity at one end of its doubt."""
    if quantity is None:
        return default
    if not isinstance(quantity, Quantity):
        return float(quantity)
    if end == "central" or favoured == 0:
        return quantity.value
    return quantity.high if (favoured > 0) == (end == "good") else quantity.low


def quantity_ends(quantity: Quantity | None) -> tuple[float, float]:
    """The low and the high end of a quantity, 0 where it is not known."""
    return (0.0, 0.0) if quantity is None else (quantity.low, quantity.high)


def column(parts: Sequence[Part], field: Field, end: End = "central") -> Array:
    """One field of all parts as a float column in SI; what is unknown is what its cell says."""
    scale, favoured = in_si(field.name)[1], FAVOURED.get(field.name, 0)
    values = [getattr(part, field.name) for part in parts]
    return np.array(each_once(values, lambda value: number(value, field.cell.unknown, end, favoured) * scale), float)


@cache
def in_si(name: str) -> tuple[str, float]:
    """The name of a field in the SI unit, and the factor to it: `min_pulse_us` is `min_pulse_s`, 1e-6."""
    stem, _, unit = name.rpartition("_")
    si = SI_UNITS.get(unit, unit)
    return (f"{stem}_{si}", convert(1.0, unit, si) or 1.0) if si != unit else (name, 1.0)


def columns_of(record: type[Part], parts: Sequence[Part], end: End) -> dict[str, Array]:
    """The numbers of parts as columns in SI, each by its name there; the price apart, which has a currency."""
    return {
        in_si(field.name)[0]: column(parts, field, end)
        for field in kept_fields(record)
        if field.form == "number" and field.name != "price"
    }


def high_ends(record: type[Part], parts: Sequence[Part], names: Sequence[str]) -> Array:
    """Sizes at the high ends of their doubt [m], (n, n_names), 0 where they are not known."""
    fields_by_name = {field.name: field for field in kept_fields(record)}
    return np.stack([column(parts, fields_by_name[name], "bad") for name in names], axis=1)


def of_table(table: type[Columns], known: Mapping[str, Array]) -> dict[str, Array]:
    """Those columns that stand in a table as they are."""
    return {f.name: known[f.name] for f in fields(table) if f.name in known}


def prices(parts: Sequence[Part], money: Money, end: End, high_basis: bool) -> dict[str, Array]:
    """Prices in the mission's currency; an inline part without a price costs nothing."""
    return {
        "price": _prices(parts, money, end),
        "limit_price": _prices(parts, money, limit_end(end, high_basis)),
    }


def limit_end(end: End, high_basis: bool) -> End:
    """The end of an estimated price that counts against a budget."""
    return "bad" if high_basis else end


def _prices(parts: Sequence[Part], money: Money, end: End) -> Array:
    amounts = each_once([part.price for part in parts], lambda price: number(price, 0.0, end, FAVOURED["price"]))
    worth = each_once([part.currency for part in parts], lambda currency: money(1.0, currency))
    return np.array(amounts, float) * np.array(worth, float)


def with_host(
    known: dict[str, Array], parts: Sequence[Camera], money: Money, end: End, high_basis: bool, share: Array
) -> dict[str, Array]:
    """Prices of cameras with the share (n,) of a computer's that each pays, which is stated in USD."""

    def host(at: End) -> Array:
        amounts = each_once([part.host_price for part in parts], lambda p: number(p, 0.0, at, FAVOURED["host_price"]))
        return np.array(amounts, float) * money(1.0, "USD")

    return {
        "price": known["price"] + share * host(end),
        "limit_price": known["limit_price"] + share * host(limit_end(end, high_basis)),
    }


def camera_rows(
    parts: Sequence[Camera],
    *,
    money: Money,
    end: End = "central",
    paper: bool = False,
    high_basis: bool = False,
    host_share: Array | float = 0.0,
    computers: Array | float = 1.0,
) -> tuple[Cameras, list[dict[str, Curve]]]:
    """Cameras as columns, and the distinct efficiency curves they point to.

    Physics `paper` counts 16-bit numbers and knows no exposure offset, dark current or PRNU. Each camera draws and
    costs its share of the computers that take the images, which are so many.
    """
    curves: list[dict[str, Curve]] = []
    index_of: dict[tuple[tuple[str, Curve], ...], int] = {}

    def index(own: Mapping[str, Curve]) -> int:
        key = tuple(sorted(own.items()))
        if key not in index_of:
            index_of[key] = len(curves)
            curves.append(dict(own))
        return index_of[key]

    bits = np.array([PAPER_BITS if paper else part.bit_depth for part in parts], float)
    known = columns_of(Camera, parts, end)
    if paper:
        known |= {name: 0.0 * known[name] for name in NOT_IN_PAPER}
    pixels = known["resolution_x_px"] * known["resolution_y_px"]
    frame_mb = pixels * known["bit_depth"] / 8.0 / 1e6
    rate = np.minimum(known["max_frame_rate_hz"], known["bandwidth_mb_s"] / frame_mb)
    with np.errstate(divide="ignore"):
        timer_hz = 1.0 / known["min_interval_s"]  # of a timer of its own; inf where there is none
    rolling = np.array([part.shutter == "rolling" for part in parts], bool)
    rows = Cameras(
        **of_table(Cameras, known)
        | with_host(prices(parts, money, end, high_basis), parts, money, end, high_basis, np.asarray(host_share))
        | {
            "power_w": known["power_w"] + host_share * known["host_power_w"],
            "gain_dn_per_e": _gain(parts, bits, known),
            "bits": bits,
            "max_gain": db_to_ratio(known["max_gain_db"]),
            "max_rate_hz": np.minimum(rate, timer_hz),
            "awake_s": known["wake_up_s"] + 1.0 / rate,
            "readout_s": np.where(rolling & np.isfinite(rate), 1.0 / np.maximum(rate, 1e-9), 0.0),
            "frame_mb": frame_mb,
            "qe_index": np.array(each_once([part.qe_curves for part in parts], index), int),
            "most_body_m": high_ends(Camera, parts, ("body_width_mm", "body_height_mm", "body_length_mm", "plug_mm")),
            "fires_lamps": np.array([part.fires_lamps for part in parts], bool),
            "disk_gb": np.where(np.isfinite(known["storage_gb"]), np.inf, computers * DISK_GB),
        }
    )
    return rows, curves


def _gain(parts: Sequence[Camera], bits: Array, known: Mapping[str, Array]) -> Array:
    """Numbers of so many bits per electron; full scale at saturation where it is not known."""
    stated = np.array(
        [
            np.nan if part.gain_dn_per_e is None else part.gain_dn_per_e * 2.0 ** (b - (part.gain_bits or b))
            for part, b in zip(parts, bits, strict=True)
        ],
        float,
    )
    black, saturation = known["black_level_dn"], known["saturation_e"]
    with np.errstate(invalid="ignore", divide="ignore"):
        at_saturation = np.where(np.isfinite(saturation), (2.0**bits - 1.0 - black) / saturation, 1.0)
    return np.where(np.isnan(stated), at_saturation, stated)


def lens_rows(
    parts: Sequence[Lens], *, money: Money, end: End = "central", high_basis: bool = False
) -> Lenses:
    """Lenses as columns."""
    known = columns_of(Lens, parts, end)
    return Lenses(
        **of_table(Lenses, known)
        | prices(parts, money, end, high_basis)
        | {
            "transmission": known["transmission_frac"],
            "aberration_f1_m": aberration_at_f1(
                known["aberration_pitch_m"], f_number_min=known["f_number_min"]
            ),
            "aberration_exponent": aberration_exponent(known["f_number_min"]),
            "spacers_m": _spacers(parts),
            "most_body_m": high_ends(Lens, parts, ("diameter_mm", "length_mm")),
            "pupil_ends_m": 1e-3 * np.array(each_once([part.pupil_mm for part in parts], quantity_ends), float),
            "rated_pitch_m": np.array([(rated_pitch_um(part) or 0.0) * 1e-6 for part in parts], float),
            "motorised": np.array([part.aperture_control == "motorised" for part in parts], bool),
        }
    )


def _spacers(parts: Sequence[Lens]) -> Array:
    """Lengths of the rings that may stand behind each lens in rising order, NaN-padded."""
    lengths = each_once([part.spacers_mm for part in parts], lambda own: sorted(own or ()))
    most = max(map(len, lengths), default=0)
    rows = each_once(lengths, lambda own: own + [np.nan] * (most - len(own)))
    return np.array(rows, float).reshape(len(parts), most) * 1e-3


def port_rows(
    parts: Sequence[Port], *, money: Money, glass_index: Callable[[str], float], end: End = "central",
    high_basis: bool = False,
) -> Ports:  # fmt: skip
    """Ports as columns; the index of a named glass comes from `glass_index` at the design wavelength."""

    def index_of(part: Port) -> float:
        if part.refractive_index is not None:
            return number(part.refractive_index, 1.5, end, FAVOURED["refractive_index"])
        return glass_index(part.glass) if part.glass else 1.5

    def radius_of(part: Port) -> float:
        return number(part.outer_radius_mm, 0.0) * 1e-3 if part.geometry == "dome" else 0.0

    known = columns_of(Port, parts, end)
    bare = prices(parts, money, end, high_basis)
    hulls = housing_columns(parts, money, end, high_basis)
    return Ports(
        **of_table(Ports, known)
        | {name: bare[name] + hulls.pop(name) for name in bare}
        | {"mass_kg": known["mass_kg"] + hulls.pop("mass_kg")}
        | hulls
        | {
            "is_dome": np.array([part.geometry == "dome" for part in parts], bool),
            "outer_radius_m": np.array([radius_of(part) for part in parts], float),
            "refractive_index": np.array([index_of(part) for part in parts], float),
            "clear_radius_m": known["clear_diameter_m"] / 2.0,
            "rim_gap_m": np.where([part.geometry == "dome" for part in parts], _inset_m(parts), known["gap_m"]),
        }
    )


def _inset_m(parts: Sequence[Port]) -> Array:
    """How far the middles of domes lie behind their rims; 0 of hemispheres and of windows."""
    return np.array([part.rim_inset_mm for part in parts], float) * 1e-3


def housing_columns(
    parts: Sequence[Port], money: Money, end: End, high_basis: bool
) -> dict[str, Array]:
    """What the housings of ports add to them; of a port without one nothing, and room without end."""
    housed = np.array([part.housing is not None for part in parts], bool)
    hulls = [part.housing or Housing("none", inner_diameter_mm=math.inf) for part in parts]
    known = columns_of(Housing, hulls, end)
    sphere = np.array([hull.shape == "sphere" for hull in hulls], bool)
    port_mm = [number(part.outer_radius_mm, 0.0) if part.geometry == "dome" else 0.0 for part in parts]
    radius_m = np.where(sphere | ~housed, 0.0, np.array(port_mm, float) * 1e-3)
    inset_m = np.minimum(_inset_m(parts), radius_m)
    stands_out = radius_m - inset_m
    inner = known["inner_diameter_m"]

    def outer(outside: str, inside: str) -> Array:
        known_or_inner = np.where(known[outside] > 0.0, known[outside], known[inside])
        return np.where(housed, known_or_inner, 0.0)

    diameter = outer("outer_diameter_m", "inner_diameter_m")
    length = np.where(sphere, diameter, outer("outer_length_m", "inner_length_m"))
    volume = np.where(sphere, np.pi / 6.0 * diameter**3, np.pi / 4.0 * diameter**2 * length)
    volume += np.pi / 3.0 * stands_out**2 * (2.0 * radius_m + inset_m)  # of a dome in front
    hull_prices = prices(hulls, money, end, high_basis)
    flanges = [adapter_of(part) or NO_ADAPTER for part in parts]
    for name, at in (("price", end), ("limit_price", limit_end(end, high_basis))):
        hull_prices[name] = hull_prices[name] + np.array(
            [money(number(one.price, 0.0, at, FAVOURED["price"]), "USD") for one in flanges], float
        )
    flange_g = np.array([number(one.mass_g, 0.0, end, FAVOURED["mass_g"]) for one in flanges], float)
    flange_displaced_g = np.array([one.displaced_g.value for one in flanges], float)
    displaced_kg = np.where(known["displaced_kg"] > 0.0, known["displaced_kg"], SEAWATER_KG_M3 * volume)
    return {
        **hull_prices,
        "mass_kg": known["mass_kg"] + 1e-3 * flange_g,
        "housed": housed,
        "roomy": housed & np.array([not part.complete for part in parts], bool),
        "is_sphere": sphere,
        "to_be_made": np.array([hull.generic for hull in hulls], bool),
        "room_diameter_m": inner,
        "room_length_m": np.where(sphere, inner, known["inner_length_m"]),
        "outer_diameter_m": np.maximum(diameter, 2.0 * np.sqrt(radius_m**2 - inset_m**2)),
        "outer_length_m": length + stands_out,
        "displaced_kg": displaced_kg + 1e-3 * flange_displaced_g,
    }


def light_rows(
    parts: Sequence[Light], *, money: Money, optics_index: Sequence[int], end: End = "central", paper: bool = False,
    high_basis: bool = False, self_fed: bool = False,
) -> Lights:  # fmt: skip
    """Lights as columns; physics `paper` does not derate lumens, and its flashes do not fade.

    self_fed : whether lamps with a battery of their own draw nothing from that of the system or vehicle
    """
    known = columns_of(Light, parts, end)
    kind = np.array([KIND_CODES[part.kind] for part in parts], int)
    flash = kind == FLASH
    stored, rate = known["flash_energy_j"], known["max_rate_hz"]
    fed = np.array([not (self_fed and part.supply == "battery") for part in parts], float)
    drawn_j, recycle_s = np.where(flash, stored / known["charging_efficiency_frac"], 0.0) * fed, known["recycle_s"]
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.where(flash, np.minimum(rate, 1.0 / recycle_s), rate)
        charging_w = np.where(flash & (recycle_s > 0.0), drawn_j / recycle_s, 0.0)
    fading = flash & (not paper)
    faded_to = np.where(fading, known["flash_duration_at_frac"], 1.0)
    flash_lm_s = flash_light_lm_s(stored, efficacy_lm_s_per_j=known["flash_efficacy_lm_s_per_j"])
    return Lights(
        **of_table(Lights, known)
        | prices(parts, money, end, high_basis)
        | {
            "kind": kind,
            "full_light": np.where(flash, flash_lm_s, known["flux_lm"]),
            "output_factor": np.ones(len(parts)) if paper else _output(parts, known),
            "full_power_w": np.where(flash, 0.0, fed * known["power_w"]),
            "standby_w": fed * known["standby_w"],
            "pulse_energy_j": drawn_j,
            "charging_power_w": charging_w,
            "flash_duration_s": flash_model.whole_s(known["flash_duration_s"], at_frac=faded_to),
            "flash_decay_s": flash_model.decay_s(known["flash_duration_s"], at_frac=faded_to),
            "stored_energy_j": np.where(flash, stored, 0.0),
            "levels": _levels(parts),
            "min_level": known["dim_min_frac"],
            "dims_freely": np.array([part.dim_levels is None for part in parts], bool),
            "max_duty": known["max_duty_frac"],
            "switchable": np.array([part.switchable == "yes" for part in parts], bool),
            "max_rate_hz": rate,
            "optics_index": np.array(optics_index, int),
        }
    )


def _levels(parts: Sequence[Light]) -> Array:
    """Shares of full light in rising order, NaN-padded; a row of NaN: continuous."""
    n_levels = max([1] + [len(part.dim_levels) for part in parts if part.dim_levels is not None])
    levels = np.full((len(parts), n_levels), np.nan)
    for row, part in enumerate(parts):
        if part.dim_levels is not None:
            levels[row, : len(part.dim_levels)] = sorted(part.dim_levels)
    return levels


def _output(parts: Sequence[Light], known: Mapping[str, Array]) -> Array:
    """Share of the nameplate flux that leaves the window; measured where the profile is in candela."""
    output = known["output_factor"].copy()
    for row, part in enumerate(parts):
        if part.beam_profile_is_candela and part.beam_profile is not None and part.flux_lm is not None:
            output[row] = measured_lumens(part.beam_profile.x, part.beam_profile.y) / known["flux_lm"][row]
    return output

"""Parts as arrays in SI units, ready for the model: one row a part, one column a property.

The catalogue's records carry the field's units and a range for what is estimated; here each number
becomes one column in SI, taken at its central value, or at the end that favours (`good`) or harms
(`bad`) a design. Money is converted once, into the mission's currency.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from uwopt.catalog.compatibility import rated_pitch_um
from uwopt.catalog.parts.kinds import FAVOURED as FAVOURED
from uwopt.catalog.records import Camera, Curve, Lens, Light, Part, Port, Quantity
from uwopt.model.light import flash_light_lm_s

Array = NDArray[Any]
End = Literal["central", "good", "bad"]
Money = Callable[[float, str], float]  # amount, currency -> amount in the mission's currency
T = TypeVar("T", bound="Rows")

CONTINUOUS, PULSED, FLASH = 0, 1, 2
KIND_CODES = {"continuous": CONTINUOUS, "pulsed_led": PULSED, "flash": FLASH}
PAPER_BITS = 16


@dataclass(frozen=True)
class Rows:
    """Columns of equal length; `take` gathers rows."""

    def take(self: T, index: Array | slice) -> T:
        """The same columns at these rows."""
        columns = {f.name: getattr(self, f.name) for f in fields(self)}
        return replace(
            self,
            **{name: column[index] for name, column in columns.items() if isinstance(column, np.ndarray)},
        )


@dataclass(frozen=True)
class Cameras(Rows):
    """Camera columns; `qe_index` points into the list of distinct efficiency curves."""

    resolution_x_px: Array
    resolution_y_px: Array
    pixel_pitch_m: Array
    read_noise_e: Array
    saturation_e: Array
    gain_dn_per_e: Array  # at unit gain, in DN of `bits`
    bits: Array
    black_level_dn: Array
    max_gain: Array
    min_exposure_s: Array
    max_exposure_s: Array
    exposure_offset_s: Array
    dark_current_e_s: Array
    prnu_frac: Array
    max_rate_hz: Array
    readout_s: Array  # 0 for a global shutter
    frame_mb: Array  # 10^6 byte
    qe_index: Array
    qe_scale: Array
    price: Array
    limit_price: Array  # what counts against a budget: the price, or its high end
    mass_kg: Array
    power_w: Array


@dataclass(frozen=True)
class Lenses(Rows):
    """Lens columns."""

    focal_length_m: Array
    f_number_min: Array
    f_number_max: Array
    transmission: Array
    min_object_distance_m: Array
    rated_pitch_m: Array  # pixel pitch that the maker rates the lens for; 0 when unknown
    motorised: Array
    price: Array
    limit_price: Array  # what counts against a budget: the price, or its high end
    mass_kg: Array


@dataclass(frozen=True)
class Ports(Rows):
    """Port columns; `outer_radius_m` is 0 for a flat port."""

    is_dome: Array
    outer_radius_m: Array
    thickness_m: Array
    refractive_index: Array
    gap_m: Array
    clear_radius_m: Array  # inf when unknown
    price: Array
    limit_price: Array  # what counts against a budget: the price, or its high end
    mass_kg: Array


@dataclass(frozen=True)
class Lights(Rows):
    """Light columns, one lamp each. Light of a flash is in lm s, of the others in lm."""

    kind: Array
    full_light: Array  # nameplate lm (continuous, pulsed) or lm s a pulse (flash)
    output_factor: Array
    full_power_w: Array  # continuous, pulsed: while on; flash: 0
    pulse_energy_j: Array  # flash: taken from the supply for one full pulse; others 0
    stored_energy_j: Array  # flash: in the tube
    levels: Array  # (n, n_levels) shares of full light, NaN-padded; a column of NaN: continuous
    min_level: Array
    dims_freely: Array
    min_pulse_s: Array
    max_pulse_s: Array
    max_duty: Array
    max_rate_hz: Array  # inf when no limit; of a flash 1 / recycle time
    flash_duration_s: Array
    front_radius_m: Array
    optics_index: Array  # into the list of distinct (beam, spectrum)
    price: Array
    limit_price: Array  # what counts against a budget: the price, or its high end
    mass_kg: Array


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


def column(
    parts: Sequence[Part], name: str, default: float, *, scale: float = 1.0, end: End = "central"
) -> Array:
    """One property of all parts as a float column in SI (value times scale)."""
    favoured = FAVOURED.get(name, 0)
    return np.array(
        [number(getattr(part, name), default / scale, end, favoured) * scale for part in parts], float
    )


def price_column(parts: Sequence[Part], money: Money, end: End) -> Array:
    """Prices in the mission's currency; an inline part without a price costs nothing."""
    return np.array([money(number(p.price, 0.0, end, FAVOURED["price"]), p.currency) for p in parts], float)


def limit_end(end: End, high_basis: bool) -> End:
    """Which end of a price counts against a budget."""
    return "bad" if high_basis else end


def camera_rows(
    parts: Sequence[Camera],
    *,
    money: Money,
    end: End = "central",
    paper: bool = False,
    high_basis: bool = False,
) -> tuple[Cameras, list[dict[str, Curve]]]:
    """Cameras as columns, and the distinct efficiency curves they point to.

    Physics `paper` counts 16-bit numbers and knows no exposure offset, dark current or PRNU.
    """
    curves: list[dict[str, Curve]] = []
    index_of: dict[tuple[tuple[str, Curve], ...], int] = {}
    qe_index = []
    for part in parts:
        key = tuple(sorted(part.qe_curves.items()))
        if key not in index_of:
            index_of[key] = len(curves)
            curves.append(dict(part.qe_curves))
        qe_index.append(index_of[key])
    bits = np.array([PAPER_BITS if paper else part.bit_depth for part in parts], float)
    sent_bits = np.array([part.bit_depth for part in parts], float)
    black = column(parts, "black_level_dn", 0.0) * (0.0 if paper else 1.0)
    saturation = column(parts, "saturation_e", np.inf, end=end)
    full_scale = 2.0**bits - 1.0
    gain = np.array(
        [
            np.nan if part.gain_dn_per_e is None else part.gain_dn_per_e * 2.0 ** (b - (part.gain_bits or b))
            for part, b in zip(parts, bits, strict=True)
        ],
        float,
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        at_saturation = np.where(np.isfinite(saturation), (full_scale - black) / saturation, 1.0)
    gain = np.where(np.isnan(gain), at_saturation, gain)
    pixels = column(parts, "resolution_x_px", 0.0) * column(parts, "resolution_y_px", 0.0)
    frame_mb = pixels * sent_bits / 8.0 / 1e6
    bandwidth = column(parts, "bandwidth_mb_s", np.inf, end=end)
    rate = np.minimum(column(parts, "max_frame_rate_hz", np.inf, end=end), bandwidth / frame_mb)
    rolling = np.array([part.shutter == "rolling" for part in parts], bool)
    off = 0.0 if paper else 1.0
    rows = Cameras(
        resolution_x_px=column(parts, "resolution_x_px", 0.0),
        resolution_y_px=column(parts, "resolution_y_px", 0.0),
        pixel_pitch_m=column(parts, "pixel_pitch_um", 0.0, scale=1e-6),
        read_noise_e=column(parts, "read_noise_e", 0.0, end=end),
        saturation_e=saturation,
        gain_dn_per_e=gain,
        bits=bits,
        black_level_dn=black,
        max_gain=10.0 ** (column(parts, "max_gain_db", 0.0, end=end) / 20.0),
        min_exposure_s=column(parts, "min_exposure_us", 0.0, scale=1e-6, end=end),
        max_exposure_s=column(parts, "max_exposure_us", np.inf, scale=1e-6, end=end),
        exposure_offset_s=column(parts, "exposure_offset_us", 0.0, scale=1e-6, end=end) * off,
        dark_current_e_s=column(parts, "dark_current_e_s", 0.0, end=end) * off,
        prnu_frac=column(parts, "prnu_frac", 0.0, end=end) * off,
        max_rate_hz=rate,
        readout_s=np.where(rolling & np.isfinite(rate), 1.0 / np.maximum(rate, 1e-9), 0.0),
        frame_mb=frame_mb,
        qe_index=np.array(qe_index, int),
        qe_scale=column(parts, "qe_scale", 1.0, end=end),
        price=price_column(parts, money, end),
        limit_price=price_column(parts, money, limit_end(end, high_basis)),
        mass_kg=column(parts, "mass_g", 0.0, scale=1e-3, end=end),
        power_w=column(parts, "power_w", 0.0, end=end),
    )
    return rows, curves


def lens_rows(
    parts: Sequence[Lens], *, money: Money, end: End = "central", high_basis: bool = False
) -> Lenses:
    """Lenses as columns."""
    return Lenses(
        focal_length_m=column(parts, "focal_length_mm", 0.0, scale=1e-3),
        f_number_min=column(parts, "f_number_min", 1.0, end=end),
        f_number_max=column(parts, "f_number_max", 16.0, end=end),
        transmission=column(parts, "transmission_frac", 1.0, end=end),
        min_object_distance_m=column(parts, "min_object_distance_m", 0.0, end=end),
        rated_pitch_m=np.array([(rated_pitch_um(part) or 0.0) * 1e-6 for part in parts], float),
        motorised=np.array([part.aperture_control == "motorised" for part in parts], bool),
        price=price_column(parts, money, end),
        limit_price=price_column(parts, money, limit_end(end, high_basis)),
        mass_kg=column(parts, "mass_g", 0.0, scale=1e-3, end=end),
    )


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
        return (part.outer_radius_mm or 0.0) * 1e-3 if part.geometry == "dome" else 0.0

    return Ports(
        is_dome=np.array([part.geometry == "dome" for part in parts], bool),
        outer_radius_m=np.array([radius_of(part) for part in parts], float),
        thickness_m=column(parts, "thickness_mm", 0.0, scale=1e-3, end=end),
        refractive_index=np.array([index_of(part) for part in parts], float),
        gap_m=column(parts, "gap_mm", 0.0, scale=1e-3),
        clear_radius_m=column(parts, "clear_diameter_mm", np.inf, scale=0.5e-3),
        price=price_column(parts, money, end),
        limit_price=price_column(parts, money, limit_end(end, high_basis)),
        mass_kg=column(parts, "mass_g", 0.0, scale=1e-3, end=end),
    )


def measured_lumens(profile: Curve) -> float:
    """Flux of a profile of absolute intensity [cd] over the angle from the axis: 2 pi integral of I sin."""
    angle = np.deg2rad(np.asarray(profile.x, float))
    fine = np.linspace(angle[0], angle[-1], 4001)
    intensity = np.interp(fine, angle, np.asarray(profile.y, float))
    return float(2.0 * np.pi * np.trapezoid(intensity * np.sin(fine), fine))


def light_rows(
    parts: Sequence[Light], *, money: Money, optics_index: Sequence[int], end: End = "central", paper: bool = False,
    high_basis: bool = False,
) -> Lights:  # fmt: skip
    """Lights as columns; physics `paper` does not derate lumens."""
    kind = np.array([KIND_CODES[part.kind] for part in parts], int)
    flash = kind == FLASH
    stored = column(parts, "flash_energy_j", 0.0, end=end)
    flux = column(parts, "flux_lm", 0.0, end=end)
    efficacy = column(parts, "flash_efficacy_lm_s_per_j", 35.0, end=end)
    n_levels = max([1] + [len(part.dim_levels) for part in parts if part.dim_levels is not None])
    levels = np.full((len(parts), n_levels), np.nan)
    for row, part in enumerate(parts):
        if part.dim_levels is not None:
            steps = sorted(part.dim_levels)
            levels[row, : len(steps)] = steps
    recycle = column(parts, "recycle_s", 0.0, end=end)
    rate = column(parts, "max_rate_hz", np.inf, end=end)
    with np.errstate(divide="ignore"):
        rate = np.where(flash, np.minimum(rate, 1.0 / recycle), rate)
    charging = column(parts, "charging_efficiency_frac", 1.0, end=end)
    output = column(parts, "output_factor", 1.0, end=end)
    for row, part in enumerate(parts):
        if part.beam_profile_is_candela and part.beam_profile is not None and part.flux_lm is not None:
            output[row] = measured_lumens(part.beam_profile) / flux[row]
    return Lights(
        kind=kind,
        full_light=np.where(flash, flash_light_lm_s(stored, efficacy_lm_s_per_j=efficacy), flux),
        output_factor=np.ones(len(parts)) if paper else output,
        full_power_w=np.where(flash, 0.0, column(parts, "power_w", 0.0, end=end)),
        pulse_energy_j=np.where(flash, stored / charging, 0.0),
        stored_energy_j=np.where(flash, stored, 0.0),
        levels=levels,
        min_level=np.array([part.dim_min_frac for part in parts], float),
        dims_freely=np.array([part.dim_levels is None for part in parts], bool),
        min_pulse_s=column(parts, "min_pulse_us", 0.0, scale=1e-6, end=end),
        max_pulse_s=column(parts, "max_pulse_us", np.inf, scale=1e-6, end=end),
        max_duty=column(parts, "max_duty_frac", 1.0, end=end),
        max_rate_hz=rate,
        flash_duration_s=column(parts, "flash_duration_us", np.inf, scale=1e-6, end=end),
        front_radius_m=column(parts, "front_radius_mm", 0.02, scale=1e-3),
        optics_index=np.array(optics_index, int),
        price=price_column(parts, money, end),
        limit_price=price_column(parts, money, limit_end(end, high_basis)),
        mass_kg=column(parts, "mass_g", 0.0, scale=1e-3, end=end),
    )

"""Numbers, names and short sentences for people; the tables and pages of a report share them."""

from __future__ import annotations

import unicodedata
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from uwopt.results.design import BillRow, Cost, Design, LampPlace, Margin, Totals, UsedHardware, UsedPart
from uwopt.results.result import Certificate, Result
from uwopt.units import (
    SLOW_HZ,
    format_difference,
    format_interval,
    format_money,
    format_number,
    format_price,
    format_quantity,
    format_within,
    round_within,
    split_unit,
    symbol,
    texts_apart,
    without_zeros,
)

if TYPE_CHECKING:
    from uwopt.results.front import FrontObjective, FrontPoint

STATUS_SENTENCES: Mapping[str, str] = {
    "optimal": "best of the catalogue under these assumptions, proven",
    "feasible": "every requirement is met",
    "violated": "requirements are missed",
    "infeasible": "no system of the catalogue meets every requirement",
    "stopped": "stopped by a limit before the proof was complete, so better may exist",
}

#: Settings in the order in which they are set, with their unit.
SETTINGS: Mapping[str, tuple[str, str]] = {
    "f_number": ("f-number", ""),
    "focus_distance_m": ("focus, in water from the port", "m"),
    "spacer_mm": ("spacer ring behind the lens", "mm"),
    "focus_scale_m": ("focus on the lens's own scale", "m"),
    "exposure_ms": ("exposure", "ms"),
    "pulse_ms": ("light pulse", "ms"),
    "gain_db": ("gain", "dB"),
    "frame_rate_hz": ("frame rate", "Hz"),
    "flux_lm": ("light of all lamps", "lm"),
    "dim_frac": ("light level", ""),
    "flash_energy_j": ("energy of a flash", "J"),
}

REQUIREMENTS: Mapping[str, str] = {
    "max_blur_px": "motion blur",
    "max_skew_px": "rolling-shutter skew",
    "overlap": "overlap along track",
    "frame_interval_s": "time between images",
    "frame_rate": "frame rate of the camera",
    "nearest_focus_m": "nearest focus of the lens",
    "farthest_focus_m": "farthest focus of the lens on its spacer ring",
    "port_clears_view_mm": "view clear of the port's edge",
    "horizon": "far edge of the frame, times as far as its middle",
    "dof_near_m": "near end of sharp depth",
    "dof_far_m": "far end of sharp depth",
    "min_dof_m": "depth of field",
    "max_gsd_mm": "pixel on the floor",
    "min_swath_m": "swath",
    "min_common_swath_m": "swath of both cameras",
    "max_depth_error_mm": "error of a distance by stereo",
    "min_snr_db": "signal to noise",
    "min_snr": "signal to noise",
    "min_snr_red_db": "signal to noise of red",
    "max_white_balance": "white balance, strongest over weakest channel",
    "min_contrast": "contrast",
    "min_uniformity": "evenness of the light",
    "min_mtf_half_nyquist": "sharpness at half Nyquist",
    "resolve_mm": "finest bars that arrive",
    "mean_level": "mean image level",
    "saturation_fraction": "highlights, share of saturation",
    "f_number_min": "f-number, widest of the lens",
    "lens_stop_down": "lens closed from its widest opening",
    "max_airy_px": "Airy disc",
    "max_gain_db": "gain",
    "lamp_clear_m": "lamps clear of the view",
    "lamp_beside_port_m": "lamps beside the port's body",
    "lamps_apart_m": "lamps beside each other",
    "f_number_max": "f-number, smallest of the lens",
    "gain_min": "gain as a ratio, lowest",
    "gain_max": "gain as a ratio, highest",
    "max_exposure_ms": "exposure, longest",
    "min_exposure_ms": "exposure, shortest",
    "light_level_max": "light level, full",
    "light_level": "light level, a step of the lamp",
    "fixed_f_number": "f-number, fixed by the mission",
    "fixed_exposure_ms": "exposure, fixed by the mission",
    "fixed_gain": "gain as a ratio, fixed by the mission",
    "fixed_dim_frac": "light level, fixed by the mission",
    "max_pulse_ms": "pulse, longest",
    "min_pulse_ms": "pulse, shortest",
    "light_duty": "duty of the lamp",
    "light_rate": "rate of the lamp",
    "shutter_open_ms": "whole sensor open for the pulse",
    "common_f_number": "f-number, one for all scenes",
    "common_focus_m": "focus, one for all scenes",
    "cost": "cost",
    "power_w": "power",
    "peak_power_w": "peak power of the lamps",
    "mass_kg": "mass",
    "mass_water_kg": "mass in water",
    "size_mm": "size of the housing",
    "housing_diameter_mm": "width of camera and lens in the housing",
    "housing_length_mm": "length of camera and lens in the housing",
    "dome_radius_mm": "front of the lens in the dome",
    "tube_mouth_mm": "view through the mouth of the housing",
    "data_rate_mb_s": "data rate",
    "energy_wh": "energy of the whole mission",
    "storage_gb": "storage of the whole mission",
    "card_gb": "storage that the cameras have themselves",
    "run_time_h": "time that the cameras' own batteries last",
    "lamp_trigger": "signal that fires the lamps",
    "depth_rating_m": "depth rating",
}

SIZES: Mapping[str, str] = {  # that stop a fit
    "housing_diameter_mm": "inner diameter of the housing",
    "housing_length_mm": "inner length of the housing",
    "dome_radius_mm": "inner radius of the dome",
    "tube_mouth_mm": "diameter of the housing's mouth",
    "port_width_mm": "diameter of the housing's end",
}

RULES: Mapping[str, str] = {
    "availability": "no longer sold, or never was",
    "purpose": "made and sold for something else",
    "vital facts": "a fact that the model needs is unknown",
    "pattern": "not among the parts the mission names",
    "exclude": "excluded by the mission",
    "port mount": "fits only its maker's housing",
    "verified": "a field that must be sourced is not",
    "colour": "sensor of the other colour type",
    "shutter": "shutter of the other type",
    "interface": "camera's interface is not one that the host has, or unknown",
    "lamp supply": "lamp has its own battery, or its supply is unknown",
    "run time": "its own battery does not last",
    "trigger": "nothing fires the lamp with the camera",
    "depth rating": "depth rating too shallow or unknown",
    "setting": "cannot be set as the mission fixes it",
    "generic": "parts to be made, real ones are left",
    "complete": "piece of a complete camera, with other parts",
    "form": "complete cameras or assembled ones, of which the others are asked for",
    "mount": "lens mount does not fit the camera",
    "image_circle": "image circle smaller than the sensor",
    "lens_rating": "lens not sharp enough for the sensor's pixels",
    "view": "port cuts into the view",
    "horizon": "far edge of the frame too near to the horizon, or beyond",
    "focus": "lens cannot focus on the floor through the port",
    "max_gsd_mm": "pixel on the floor too large",
    "min_swath_m": "swath too narrow",
    "min_common_swath_m": "strip that both cameras see too narrow",
    "max_depth_error_mm": "distance by stereo too uncertain",
    "frame_rate": "camera too slow",
    "data_rate_mb_s": "data rate too high",
    "storage_gb": "more images than the storage holds",
    "card_gb": "more images than the camera's own card holds",
    "lens_stop_down": "lens cannot be closed as far as asked",
    "min_dof_m": "depth of field too short at every f-number",
    "max_blur_px": "blurred at the shortest exposure",
    "min_snr": "too little light for the wanted signal",
    "light": "no light gives the wanted signal",
    "max_white_balance": "colours too far apart",
    "cost": "too expensive",
    "mass_kg": "too heavy",
    "mass_water_kg": "too heavy in water",
    "size_mm": "housing too large",
    "housing": "camera with lens does not fit into the housing",
    "housing: port": "port does not go on the housing",
    "better_housing": "fits as well into a housing that costs and weighs no more",
    "power_w": "too much power",
    "energy_wh": "too much energy over the mission",
    "bound": "proven not better than the systems shown",
    "not_reached": "not reached in the time allowed",
}

PIECES = ("camera", "lens", "port")  # of a complete camera: the ends of their ids

PARTS_OF_THE_SEARCH = ("search_imagers", "search_bounds", "search_evaluation")

#: What stands for signs that a terminal without Unicode cannot show.
PLAIN_SIGNS = str.maketrans(
    {
        "–": "-", "—": "-", "−": "-", "µ": "u", "μ": "u", "°": " deg", "²": "2", "³": "3", "⁻": "-", "·": "*",
        "×": "x", "≤": "<=", "≥": ">=", "≈": "~", "±": "+/-", "…": "...", "‘": "'", "’": "'", "“": '"', "”": '"',
        "\u00a0": " ", "\u202f": " ",
    }
)  # fmt: skip
#: Information per area of floor, as objectives and figures name it, and the prefixes that it is read with.
BITS = ("bit/m2", "bit/m²", "bit_per_m2", "_bit_per_m2")
PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"))


def in_encoding(text: str, encoding: str) -> str:
    """The text with only signs that an encoding knows: `µm` is `um` in ASCII, a foreign letter its base."""
    try:
        text.encode(encoding)
    except (UnicodeEncodeError, LookupError):
        plain = unicodedata.normalize("NFKD", text.translate(PLAIN_SIGNS))
        return (
            "".join(c for c in plain if not unicodedata.combining(c))
            .encode("ascii", "replace")
            .decode("ascii")
        )
    return text


def printable(text: str) -> str:
    """Text from files without control signs, which could steer a terminal; line ends stay."""
    return "".join(c if c in "\n\t" or not unicodedata.category(c).startswith("C") else "?" for c in text)


def one_line(text: object, longest: int = 400) -> str:
    """Text from files on one line, shortened."""
    line = " ".join(printable(str(text)).split())
    return line if len(line) <= longest else line[: longest - 3] + "..."


# ---------------------------------------------------------------- numbers


def quantity(value: float | None, unit: str = "", digits: int = 3) -> str:
    """A number with its unit, or a dash; bits get the prefix that keeps the number short."""
    per, unit = prefixed(unit, value or 0.0)
    return format_quantity(None if value is None else value / per, unit, digits)


def quantities_apart(*values: float | None, unit: str = "", digits: int = 3) -> tuple[str, ...]:
    """Quantities that stand side by side, with as many digits as tell them apart."""
    return texts_apart(*values, text=lambda value, more: quantity(value, unit, more), digits=digits)


def prefixed(unit: str, largest: float) -> tuple[float, str]:
    """What to divide by and the unit then: 2.5e6 bit/m2 are read as 2.5 Mbit/m²; other units stay."""
    if unit not in BITS:
        return 1.0, unit
    per, prefix = next((step for step in PREFIXES if abs(largest) >= step[0]), (1.0, ""))
    return per, f"{prefix}bit/m²"


def change(value: float, unit: str, scale: float, digits: int = 3) -> str:
    """A difference with its sign; what is only rounding of numbers as large as `scale` is 0."""
    if abs(value) <= 1e-9 * abs(scale):
        return format_difference(0.0, unit)
    return ("+" if value > 0 else "") + format_difference(value, unit, digits)


def margin_ends(margin: Margin, cost: Cost | None = None) -> tuple[str, str]:
    """What is reached of a requirement, a number with its unit or the word in its place; and its limit."""
    if (told := told_cost(margin, cost)) is not None:
        return money(told, margin.unit), money(margin.limit, margin.unit)
    value, limit = quantities_apart(margin.value, margin.limit, unit=margin.unit, digits=4)
    return one_line(margin.word) if margin.value is None and margin.word else value, limit


def told_cost(margin: Margin, cost: Cost | None) -> float | None:
    """A cost with no more digits than its range leaves it, unless it takes them to tell it from its limit.

    None of other requirements, and where all digits are needed.
    """
    if cost is None or margin.requirement != "cost" or margin.value is None or margin.limit is None:
        return None
    spent, most = margin.value, margin.limit
    known = [round_within(spent, cost.low, cost.high)]
    known += [round(spent, -digits) for digits in (3, 2, 1) if spent > 10.0 ** (digits + 1)]
    return next((told for told in known if told != most and (told < most) == (spent < most)), None)


def margin_text(margin: Margin, cost: Cost | None = None) -> str:
    """What is left of a requirement, in its unit; of a cost what is left of the numbers that are told."""
    if margin.margin is None:
        return quantity(None)
    told = told_cost(margin, cost)
    if told is not None and margin.limit is not None:
        return money(margin.limit - told, margin.unit)
    scale = max(abs(margin.limit or 0.0), abs(margin.value or 0.0))
    small = abs(margin.margin) <= (1e-6 if margin.satisfied else 1e-12) * scale  # 1e-6: what counts as met
    return format_difference(0.0 if small else margin.margin, margin.unit)


def reserve_text(margin: Margin) -> str:
    """What a limit is made of: `3 dB reserve on 30.00 dB asked`."""
    joint = "of" if margin.sense == "<=" else "on"
    return f"{kept_text(margin)} reserve {joint} {quantity(margin.asked, margin.unit, 4)} asked"


def kept_text(margin: Margin) -> str:
    """How much of a limit is reserve."""
    return f"{digits_of(round(margin.reserve, 9))} {symbol(margin.unit)}".strip()


def setting_text(name: str, value: float | None) -> str:
    """A setting as it is typed in: every digit that was rounded to, no more; a dash where there is none."""
    unit = SETTINGS[name][1] if name in SETTINGS else split_unit(name)[1]
    if value is None:
        return quantity(None)
    if name == "dim_frac":
        return f"{digits_of(100.0 * value)} %"
    if unit == "ms" and 0 < abs(value) < 0.1:
        return f"{digits_of(value * 1e3)} {symbol('us')}"
    typed = f"{digits_of(value)} {symbol(unit)}".strip()
    return f"{typed}, {format_interval(1.0 / value)}" if unit == "Hz" and 0 < value < SLOW_HZ else typed


def digits_of(value: float) -> str:
    """A number with up to six significant digits, without zeros at its end."""
    return without_zeros(format_number(value, 6))


def share(value: float) -> str:
    """A share as per cent; what is all but nothing is told as such."""
    if 0 < abs(value) < 1e-5:
        return "below 0.001 %"
    return f"{format_number(100.0 * value)} %"


def signed_share(value: float) -> str:
    """A relative difference as per cent with its sign."""
    return ("+" if value >= 1e-5 else "") + share(value)


def count_text(number: float | int) -> str:
    """A whole number with blanks at the thousands; beyond 10^15 rounded."""
    return f"{int(number):,}".replace(",", " ") if abs(number) < 1e15 else f"{float(number):.3e}"


def money(value: float | None, currency: str = "") -> str:
    """An amount of money in whole units, below a hundred to three digits."""
    return format_money(value, one_line(currency, 8))


def price(low: float, high: float, currency: str) -> str:
    """`5 000 to 19 000 USD` where nobody quotes it; one amount, in full, where somebody does."""
    return format_price(low, high, one_line(currency, 8))


def cost_text(cost: Cost) -> str:
    """What a system costs, as a range where prices are estimated."""
    return price(cost.low, cost.high, cost.currency)


def known_price(row: BillRow) -> str:
    """How a price is known: `list, 2026-05-01`, or that there is no quote."""
    if row.unit_price is None:
        return "unknown"
    if row.estimated:
        return "no quote" if row.price_status == "estimated" else f"{one_line(row.price_status, 20)}, no quote"
    return one_line(", ".join(word for word in (row.price_status, row.price_date) if word), 60)


def ends_of(row: BillRow) -> tuple[float, float] | None:
    """Both ends of the price of one piece; None where nobody knows it."""
    if row.unit_price is None:
        return None
    low, high = row.unit_price_low, row.unit_price_high
    return (row.unit_price,) * 2 if low is None or high is None else (low, high)


def due_text(row: BillRow) -> str:
    """What the pieces that are not owned cost together."""
    if not row.to_buy:
        return "owned"
    ends = ends_of(row)
    return "price unknown" if ends is None else price(ends[0] * row.to_buy, ends[1] * row.to_buy, row.currency)


# ---------------------------------------------------------------- names


def requirement_name(requirement: str, kinds: Mapping[str, str] | None = None) -> str:
    """A requirement in words; of `depth_rating_m (lamp-1)` the kind of part is told where `kinds` knows the id."""
    stem, _, rest = requirement.partition(" (")
    words = REQUIREMENTS.get(stem, stem.replace("_", " "))
    kind = (kinds or {}).get(rest.rstrip(")"))
    if kind:
        return f"{words} of the {kind}"
    return one_line(words + (f" ({rest}" if rest else ""))


def rule_name(rule: str) -> str:
    """A rule of the search in words; `light: availability` keeps the kind in front."""
    kind, _, name = rule.rpartition(": ")
    return (f"{one_line(kind)}: " if kind else "") + RULES.get(name, one_line(name.replace("_", " ")))


def part_name(part: UsedPart) -> str:
    """Maker and model of a part."""
    return one_line(part.name or part.id or "inline", 80)


def part_id(part: UsedPart) -> str:
    """Id of a part, with the mark of those that no shop sells as such."""
    return one_line(part.id or "inline", 60) + (" (to be made)" if part.generic else "")


def differing_parts(design: Design, best: Design) -> str:
    """What a design has that the best one has not: `lens kowa-lm6hc, 3 lights`."""
    mine, other = design.hardware, best.hardware
    theirs = {part.id for part in other.named.values()}
    words = [f"{kind} {part_id(part)}" for kind, part in mine.named.items() if part.id not in theirs]
    if mine.light_count != other.light_count:
        words.append(counted(mine.light_count, "light"))
    if mine.orientation != other.orientation:
        words.append(mine.orientation)
    if mine.light_mounts != other.light_mounts and mine.light_count == other.light_count:
        words.append(f"lights {mounts_text(mine.light_mounts)}")
    return ", ".join(words) or "the same hardware, other settings"


def equal_sentence(result: Result, most: int = 2) -> str:
    """Which systems the estimates cannot tell from the recommendation, `most` of them; empty where there is none."""
    places = [item.get("runner_up") for item in (result.robustness or {}).get("equal") or []]
    others = [result.runners_up[place] for place in places if isinstance(place, int) and place < len(result.runners_up)]
    if result.best is None or not others:
        return ""
    instead = "; ".join(differing_parts(design, result.best) for design in others[:most])
    more = f"; {len(others) - most} more" if len(others) > most else ""
    return f"Equal within the estimates: this system, and the same with {instead}{more}. Choose by quote and delivery"


def camera_stand(hardware: UsedHardware) -> str:
    """Which side of the image lies along the motion, and how the cameras of a stereo pair stand."""
    height = {"landscape": "height", "portrait": "width"}.get(hardware.orientation, "height")
    turned = f"{hardware.orientation}: the image's {height} along the motion"
    if hardware.camera_baseline_m is None:
        return turned
    half = 0.5 * hardware.camera_convergence_deg
    inward = f"each turned {half:g}° inward" if half else "side by side, not turned"
    return f"{turned}; ports {hardware.camera_baseline_m:g} m apart across track, {inward}"


def mounts_text(mounts: Sequence[LampPlace]) -> str:
    """Where the lights stand and how far they lean, and which way."""
    if not mounts:
        return ""
    step_m = row_step_m(mounts)
    fore = any(m.x_m or m.z_m or m.tilt_x_deg for m in mounts)
    if fore and step_m is None:
        return "at " + "; ".join(
            f"x {m.x_m:g} m, y {m.y_m:g} m, z {m.z_m:g} m, tilt {m.tilt_x_deg:g}/{m.tilt_y_deg:g} deg"
            for m in mounts
        )
    number = Counter(f"{m.y_m:+g} m" for m in mounts)
    uneven = len(set(number.values())) > 1
    places = ", ".join(f"{n} at {place}" if uneven else place for place, n in number.items())
    tilt = mounts[0].tilt_y_deg
    if step_m is not None:
        places = ", ".join(f"{n} at {place}" for place, n in number.items())
    row = "" if step_m is None else f", each side in a row, {step_m:g} m apart along track"
    return f"{'' if uneven or row else 'at '}{places} across track{row}" + (
        f", tilted {abs(tilt):g} deg {'outward' if tilt > 0 else 'inward'}" if tilt else ", aimed straight down"
    )


def row_step_m(mounts: Sequence[LampPlace]) -> float | None:
    """How far lamps stand apart that are in a row on each side, alike but for their place in it; None of others."""
    if any(m.z_m or m.tilt_x_deg or m.tilt_y_deg != mounts[0].tilt_y_deg for m in mounts):
        return None
    rows = [sorted(m.x_m for m in mounts if m.y_m == y) for y in {m.y_m for m in mounts}]
    steps = {round(b - a, 6) for row in rows for a, b in pairwise(row)}
    centred = all(abs(row[0] + row[-1]) < 1e-6 for row in rows)
    return steps.pop() if len(steps) == 1 and centred and 0.0 not in steps else None


def counted(number: int, noun: str) -> str:
    """`1 light`, `2 lights`."""
    return f"{count_text(number)} {noun}" + ("" if number == 1 else "s")


def listed(names: Sequence[str]) -> str:
    """`a`, `a and b`, `a, b and c`."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


# ---------------------------------------------------------------- sentences


def capital(text: str) -> str:
    """With a capital letter."""
    return text[:1].upper() + text[1:]


def as_sentence(text: str) -> str:
    """With a capital letter and a full stop."""
    return capital(text) + ("" if text.endswith(".") else ".")


def cost_sentence(design: Design) -> str:
    """`cost 3 600 to 5 300 USD, of which 1 700 to 3 400 estimated`."""
    cost = design.totals.cost
    text = f"cost {cost_text(cost)}"
    if unpriced := n_unpriced(design.bom):
        text += f", without {counted(unpriced, 'part')} of unknown price"
    if not cost.estimated:
        return f"{text}, nothing of it estimated"
    return f"{text}, of which {format_price(cost.estimated_low, cost.estimated_high)} estimated"


def quoted_share(cost: Cost) -> str:
    """How much of a price nobody has quoted: `55 % of it not quoted`."""
    if not cost.estimated or not cost.value:
        return "nothing of it estimated"
    not_quoted = 100.0 * cost.estimated / cost.value
    return "none of it quoted" if not_quoted > 99.5 else f"{format_number(not_quoted, 2)} % of it not quoted"


def burning_text(design: Design) -> str:
    """`lamps 638 W while they burn`; empty where that is no more than the whole system draws on average."""
    peak = design.totals.light_peak_power_w
    return f"lamps {quantity(peak, 'W')} while they burn" if peak and peak > (design.power_as_set_w or 0.0) else ""


def power_sentence(totals: Totals) -> str:
    """`power 3.05 W (lights 1.15 W on average, 638 W at peak), mass 1.08 kg`."""
    return (
        f"power {quantity(totals.power_w, 'W')}"
        f" (lights {quantity(totals.light_power_w, 'W')} on average,"
        f" {quantity(totals.light_peak_power_w, 'W')} at peak),"
        f" mass {quantity(totals.mass_kg, 'kg')}"
        f"{housing_clause(totals)}"
        f"{used_up_clause(totals)}"
    )


def housing_clause(totals: Totals) -> str:
    """` (camera in its housing -0.2 kg in water, 248 x 114 mm)`; nothing without a housing."""
    if totals.mass_water_kg is None or totals.size_mm is None:
        return ""
    length, diameter = (format_number(measure, 3) for measure in totals.size_mm)
    in_water = quantity(totals.mass_water_kg, "kg")
    return f" (cameras in their housings {in_water} in water, each {length} × {diameter} mm)"


def used_up_clause(totals: Totals) -> str:
    """`, energy 412 Wh, storage 86 GB, battery lasts 9.7 h` of what the mission lets know; else nothing."""
    said = (
        ("energy", totals.energy_wh, "Wh"), ("storage", totals.storage_gb, "GB"),
        ("battery lasts", totals.endurance_h, "h"), ("the cameras' own batteries last", totals.run_time_h, "h"),
    )  # fmt: skip
    return "".join(f", {name} {quantity(value, unit)}" for name, value, unit in said if value is not None)


def n_unpriced(bom: Sequence[BillRow]) -> int:
    """Pieces that must be bought at a price that nobody knows."""
    return sum(row.to_buy for row in bom if row.unit_price is None)


def objective_text(result: Result, value: float | None, digits: int = 4) -> str:
    """A value of the objective with its unit."""
    return format_quantity(value, result.objective.unit, digits)


def bound_text(result: Result, value: float | None, gap: float | None) -> str:
    """A value of the objective in the proof; a cost that is proven to the last digit as its range leaves it."""
    if result.objective.name == "cost" and value is not None and result.best is not None and not gap:
        cost = result.best.totals.cost
        return format_within(value, cost.low, cost.high, cost.currency)
    return objective_text(result, value, 6)


def value_text(result: Result, design: Design, value: float | None) -> str:
    """The objective of a design; of a cost its range, for nobody knows it better."""
    if result.objective.name == "cost" and value is not None:
        return cost_text(design.totals.cost)
    return objective_text(result, value)


def axis_text(objective: FrontObjective, point: FrontPoint, digits: int = 4) -> str:
    """The same of a point of a front, in one objective."""
    if objective.name == "cost":
        return cost_text(point.design.totals.cost)
    return quantity(point.values[objective.name], objective.unit, digits)


def status_sentence(result: Result) -> str:
    """What came out, in one sentence."""
    if result.best is not None and result.command == "evaluate":
        missed = [m for scene in result.best.scenes for m in scene.margins if not m.satisfied]
        if missed:
            verb = "is" if len(missed) == 1 else "are"
            return f"{counted(len(missed), 'requirement')} {verb} missed"
    if result.status == "feasible" and result.best is not None and not result.best.is_settable:
        return "the exact design meets every requirement, but no settings that can be typed in were found that do"
    if result.status == "feasible" and any(note.code == "better_unsettable" for note in result.warnings):
        return "the best that can be set; by exact numbers that cannot, other parts are better"
    if result.status == "stopped" and result.best is None:
        interrupted = any(warning.code == "interrupted" for warning in result.warnings)
        return f"{'interrupted' if interrupted else 'stopped by a limit'} before a system was found"
    return STATUS_SENTENCES.get(result.status, result.status)


def account_sentence(certificate: Certificate) -> str:
    """Whether every combination is accounted for."""
    gone = sum(item.count for item in certificate.discarded)
    verdict = "adds up" if certificate.adds_up() else "DOES NOT ADD UP, please report it"
    return (
        f"{count_text(certificate.evaluated)} evaluated + {count_text(gone)} discarded"
        f" {'=' if certificate.adds_up() else 'against'} {count_text(certificate.loaded)} loaded: {verdict}"
    )


def run_time_sentence(timing_s: Mapping[str, float]) -> str:
    """`0.43 s (search 0.30 s, report 0.13 s)`."""
    steps = {name: value for name, value in timing_s.items() if name not in ("total", *PARTS_OF_THE_SEARCH)}
    total = timing_s.get("total", sum(steps.values()))
    listed = ", ".join(
        f"{one_line(name.replace('_', ' '))} {quantity(value, 's', 2)}" for name, value in steps.items()
    )
    return quantity(total, "s", 3) + (f" ({listed})" if listed and len(steps) > 1 else "")


def as_bought(ids: Sequence[str]) -> list[str]:
    """Ids of parts with those of a complete camera's pieces as one: `x camera, x lens, x port` is `x`."""
    wholes = {name.removesuffix(" port") for name in ids if name.endswith(" port")}
    told: list[str] = []
    for name in ids:
        stem = next((whole for whole in wholes for piece in PIECES if name == f"{whole} {piece}"), name)
        told += [] if stem in told else [stem]
    return told

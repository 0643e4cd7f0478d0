"""What may go wrong with a recommended or given system, the most serious first, from what its result knows.

Every rule looks at the result alone and gives risks with a weight: 100 for what fails now, about 80 for what fails
when estimates turn out badly, about 50 for what is worse than the figures say, below 30 for what is good to know.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from uwopt.evaluation.breathing import BREATHING
from uwopt.mission.practice import ACCEPTABLE_SNR_DB
from uwopt.mission.reserves import BATTERY_IN_HAND, RECOMMENDED_RESERVE, REFUSED
from uwopt.mission.weakened import LEAST_SNR_DB
from uwopt.model.sharpness import RESOLVED_CONTRAST
from uwopt.quantities import REQUIREMENTS
from uwopt.results.basis import MISSED, MISSED_OF_PRACTICE, Risk
from uwopt.results.design import AS_CENTRAL, PRACTICE_MISSED, Design, Margin, Note, SceneResult
from uwopt.results.result import Result
from uwopt.tolerances import SATISFIED_REL
from uwopt.units import (
    format_at_most,
    format_difference,
    format_money,
    format_price,
    format_quantity,
    listed,
    percent,
    texts_apart,
)

Weighed = Iterator[tuple[float, Risk]]

#: Ends of the ranges that settings may have, what a setting with room left can mend, and what another rule tells.
OF_SETTINGS = (
    "f_number_min", "f_number_max", "gain_min", "gain_max", "max_exposure_ms", "min_exposure_ms", "light_level_max",
    "light_level", "max_pulse_ms", "min_pulse_ms", "light_duty", "light_rate", "shutter_open_ms", "common_f_number",
    "common_focus_m", "nearest_focus_m", "frame_rate", "frame_interval_s", "overlap", "saturation_fraction",
    "cost", "lens_stop_down", "max_gain_db", "fixed_f_number", "fixed_exposure_ms", "fixed_gain", "fixed_dim_frac",
    "depth_rating_m",
)  # fmt: skip
NOTHING_IN_HAND = 0.02  # of a limit
#: Ends of the depth of field, and what uses up the little margin there.
OFF_FOCUS = {
    "dof_near_m": "a floor that is any nearer, or a focus set any farther, is not sharp",
    "dof_far_m": "a floor that is any farther, or a focus set any nearer, is not sharp",
}
TO_CORNERS = " to the corners"
OF_NOISE = ("min_snr", "min_snr_db", "min_snr_mean_db", "min_snr_red_db", "resolve_mm")
EVEN, VERY_UNEVEN = 0.3, 0.1  # darkest place against the mean
TELLING_PX = 1.0  # a blur this wide is a cause of detail that is lost
SEEN_PX = 2.0  # a blur, skew or coloured edge wider than this is seen
STILL_MM_S = 10.0  # a hand, a line or a hovering vehicle drifts faster; a frame on the floor does not
STEADY_DEG = 3.0  # as well as a lamp's direction is kept on a vehicle
DEPTH_IN_HAND = 0.1
WARMEST_C = 50.0  # around an industrial camera, by most makers' sheets (assumed; no column of the catalogue has it)
CARRIED_KG = 10.0  # of lead, beyond which nobody adds it without a thought: a diver's belt holds some 5 to 10 kg
BUOYANT_KG = 0.5  # that a mount and its screws weigh in water; beyond it ballast is needed (assumed)
MOST_GAIN_DB = RECOMMENDED_RESERVE["max_gain_db"]
UNNOTICED = 0.01  # of a goal: its estimated numbers leave far more open
MUCH_ESTIMATED = 0.3  # of the price

#: Weights of notes by code; of those that are not named, the last. 0: another rule tells it, or it is no risk.
NOTES = {
    "not_settable": 95.0, AS_CENTRAL: 93.0, "practice_yields": 92.0,
    "no_image": 90.0, "dark_image": 77.0, "lamp_in_view": 68.0, "measure_the_camera": 62.0,
    BREATHING: 0.0, PRACTICE_MISSED: 0.0, "better_unsettable": 24.0, "snr_instead": 0.0,
    "colour_left_open": 0.0, "uneven_light": 0.0, "pattern": 0.0, "tolerance": 0.0, "interrupted": 0.0, "time": 0.0,
}  # fmt: skip
OTHER_NOTE = 15.0


def with_risks(result: Result) -> Result:
    """The result with its risks filled in."""
    return replace(result, risks=risks_of(result))


def risks_of(result: Result) -> list[Risk]:
    """What may go wrong, most serious first; nothing where there is no system."""
    if result.best is None:
        return []
    found = [item for rule in RULES for item in rule(result, result.best.as_set)]
    return [risk for _, risk in sorted(found, key=lambda item: -item[0])]


# ---------------------------------------------------------------- what is asked for


def missed(result: Result, design: Design) -> Weighed:
    """Requirements that fail as it stands."""
    by, because = "asked for", MISSED
    if any(note.code == PRACTICE_MISSED for note in result.warnings):
        by, because = "good practice asks", MISSED_OF_PRACTICE
    for name, margin in {asked_name(m): m for m in design.missed}.items():
        yield 100.0, Risk(f"{name} is not as {by}", because, missed_figure(margin, sharp_where(result)))


def uncertain(result: Result, design: Design) -> Weighed:
    """That it holds less often than was asked for."""
    known = result.confidence
    if known is None or known.enough:
        return
    because = f"settings that meet every requirement exist in {percent(known.held)} of the scenarios"
    if known.lost_to:
        first = known.lost_to[0].requirement
        because += f"; else {LOST_TO.get(first) or in_words(first)} is missed first"
    wanted = "all ends" if known.asked == "ends" else f"{100.0 * float(known.asked):g} % asked"
    yield 95.0, Risk("it may not do what is asked", because, wanted)


LOST_TO = {"light": "enough signal without saturation", "rules": "rate, pulse or power of the lamp, or the shutter,"}


def at_bad_ends(result: Result, design: Design) -> Weighed:
    """Requirements that may fail when estimated numbers turn out badly."""
    if result.confidence is not None or (result.robustness or {}).get("feasible_at_bad_end") is not False:
        return  # what was counted in scenarios says more
    number = sum(
        1 for item in result.assumptions if item.low != item.high and not item.path.endswith(".price")
    )
    because = "with its estimated numbers at the bad ends of their ranges a requirement is missed"
    if names := in_hand_names(design):
        because += f", for there is no margin in {names}"
    yield 80.0, Risk("it may not do what is asked", because, counted(number, "estimated number"))


def nothing_in_hand(result: Result, design: Design) -> Weighed:
    """Requirements that are met to the last digit; where estimates tell the same, they do."""
    least = tight(design)
    if result.confidence is not None and result.confidence.enough:
        return  # settings are found anew where the scenario asks for others
    if not least or (result.robustness or {}).get("feasible_at_bad_end") is False:
        return
    because = (
        f"there is no margin in {in_hand_names(design)}: whatever is a little worse than computed misses it"
    )
    if (end := least[0].key) in OFF_FOCUS:
        because += f"; {OFF_FOCUS[end]}{sharp_where(result)}"
    yield 52.0, Risk("it may not do what is asked", because, tight_figure(least[0], sharp_where(result)))


def shallow(result: Result, design: Design) -> Weighed:
    """Depth ratings that are used up by the deepest scene; good to know where the mission itself asks for that rating.

    Instruments that are rated for a depth work there: see `depth_factor` of the mission.
    """
    deepest_m, few = result.deepest_m, dict[str, float]()
    for margin in design.margins:
        if not margin.satisfied or margin.key != "depth_rating_m" or margin.value is None:
            continue
        if deepest_m > 0.0 and margin.value < deepest_m * (1.0 + DEPTH_IN_HAND):
            few[margin.requirement.partition(" (")[2].rstrip(")") or "a part"] = margin.value
    if few:
        asked = (result.mission.get("limits") or {}).get("depth_rating_m") is not None
        what = "a part may not stand the pressure" if len(few) == 1 else "parts may not stand the pressure"
        those = f"{listed([*few])} {'is' if len(few) == 1 else 'are'}"
        because = f"{those} rated for little more than the depth of the mission"
        because += ", as limits.depth_rating_m allows" if asked else ""
        figure = " against ".join(format_quantity(depth_m, "m") for depth_m in (min(few.values()), deepest_m))
        yield (29.0 if asked else 62.0), Risk(what, because, figure)


def drained(result: Result, design: Design) -> Weighed:
    """A battery that the mission uses up, or nearly so; told as missed where a limit on energy says so."""
    battery_wh = (result.mission.get("vehicle") or {}).get("battery_wh")
    used_wh = design.totals.energy_wh
    told = any(margin.key == "energy_wh" for margin in design.missed)
    if battery_wh is None or used_wh is None or told:
        return
    if used_wh <= (1.0 - BATTERY_IN_HAND) * battery_wh * (1.0 + SATISFIED_REL):  # the reserve is just kept
        return
    what = "the battery is nearly used up" if used_wh <= battery_wh else "the battery does not last"
    because = f"cells that are old or cold give less than their plate says: keep {100 * BATTERY_IN_HAND:.0f} % in hand"
    of, all_of = texts_apart(used_wh, battery_wh, text=lambda value, digits: format_quantity(value, "wh", digits))
    yield 58.0, Risk(what, because, f"{of} of {all_of}")


def overheated(result: Result, design: Design) -> Weighed:
    """Air in a housing that may be warmer than cameras are made for."""
    warmer_k, heat_w = design.totals.housing_warmer_k, design.totals.housing_heat_w
    if warmer_k is None or heat_w is None:
        return
    water_c = max(float(scene["temperature_c"]) for scene in result.mission["scenes"])
    if water_c + warmer_k[1] <= WARMEST_C:
        return
    low, high = (f"{water_c + kelvin:.0f}" for kelvin in warmer_k)
    because = (
        f"{format_quantity(heat_w, 'w')} warm the air in its housing; most makers allow {WARMEST_C:.0f} °C around a "
        "camera: lead its heat into a metal end cap, take a housing of metal, or ask"
    )
    figure = f"{low} to {high} °C in water of {water_c:g} °C"
    yield 57.0, Risk("the camera may become too warm", because, figure)


def floats(result: Result, design: Design) -> Weighed:
    """Housings that displace more than they weigh."""
    weight_kg = design.totals.mass_water_kg
    if weight_kg is not None and weight_kg < -BUOYANT_KG:
        because = "the housings displace more water than they weigh, lamps not counted; ballast is no part of the order"
        figure = f"{format_quantity(-weight_kg, 'kg')} of ballast in water"
        most_kg = (result.mission.get("limits") or {}).get("mass_water_kg")
        is_much = -weight_kg > (CARRIED_KG if most_kg is None else most_kg)  # a limit of weight holds no lift
        great = 56.0 if most_kg is None else 66.0  # who limits weight in water counts on it
        yield (great if is_much else 33.0), Risk("the cameras float and need ballast", because, figure)


# ---------------------------------------------------------------- water and lamps


def in_other_water(result: Result, design: Design) -> Weighed:
    """Descriptions of the same water in which a requirement is missed."""
    waters = (result.robustness or {}).get("waters") or []
    failed = sum(1 for water in waters if water.get("objective_value") is None)
    if failed:
        because = "measured tables of one type of water differ, and so does what is lost on the lamps' way"
        if not any(scene.get("water") for scene in result.mission.get("scenes") or []):
            because = "water as clear may scatter and absorb in other shares, and then more is lost on the lamps' way"
        yield 60.0 + 15.0 * failed / len(waters), Risk(
            "it fails in water a little different", because, f"in {failed} of {len(waters)} other waters"
        )  # fmt: skip


def lamps_off(result: Result, design: Design) -> Weighed:
    """How little the lamps may lean from where they are aimed."""
    tilt = (result.robustness or {}).get("tilt") or {}
    held, helped = least_of(tilt, "held"), least_of(tilt, "readjusted")
    if held is None or held >= STEADY_DEG:
        return
    names = listed(dict.fromkeys(map(in_words, tilt.get("first_to_break", []))))
    because = f"when one leans further, {names or 'a requirement'} cannot be kept"
    if helped is not None and helped > held:
        because += f"; with light, exposure and gain set anew up to {helped:.1f}° can be borne"
    weight = 70.0 if helped is None or helped < STEADY_DEG else 45.0
    yield weight, Risk("a lamp slightly off its aim spoils the images", because, f"{held:.1f}° as set")


def noisy(result: Result, design: Design) -> Weighed:
    """Images that drown in noise, as the mission asks for no signal to noise: light is then saved on."""
    if any(margin.key in OF_NOISE for margin in design.margins):
        return
    scene, snr_db = worst(design, "snr_db", least=True)
    if scene is None or snr_db >= ACCEPTABLE_SNR_DB:
        return
    what = "the images show nothing but noise" if snr_db < LEAST_SNR_DB else "the images are noisy"
    because = "no signal to noise is asked for, so light is saved on" + in_scene(design, scene)
    because += f"; requirements.min_snr_db: {ACCEPTABLE_SNR_DB:g} asks for images that can be used"
    figure = f"signal to noise {format_quantity(snr_db, 'dB')}"
    yield (96.0 if snr_db < LEAST_SNR_DB else 60.0), Risk(what, because, figure)


def uneven(result: Result, design: Design) -> Weighed:
    """Light that leaves part of the image dark."""
    scene, value = worst(design, "uniformity", least=True)
    if scene is None or value >= EVEN:
        return
    because = f"the darkest place of the floor{in_scene(design, scene)} gets so much less light than the mean"
    figure = f"{100 * value:.2g} % of the mean light"
    if (snr_db := scene.figures.get("snr_db_min")) is not None:
        figure += f", signal to noise there {format_quantity(snr_db, 'dB')}"
    yield (78.0 if value < VERY_UNEVEN else 50.0), Risk("part of the image is dark", because, figure)


# ---------------------------------------------------------------- what the optics do beside what was asked


#: Figure, risk, reason: what is seen when it is wider than two pixels.
SEEN = (
    ("defocus_corner_px", "corners of the image are out of focus", "depth of field holds on the axis alone"),
    ("skew_px", "moving scenes are skewed", "the rolling shutter reads row after row while the vehicle moves"),
    ("lateral_colour_px", "edges blur or get coloured rims", "the flat port bends colours by different amounts"),
)  # fmt: skip


def seen_in_the_image(result: Result, design: Design) -> Weighed:
    """Faults of the image that no requirement holds, but for what `lost_in_corners` tells."""
    told = [name for name, _ in BLURS] if any(True for _ in lost_in_corners(result, design)) else []
    for name, what, because in SEEN:
        scene, value = worst(design, name)
        if scene is not None and value > SEEN_PX and name not in told:
            weight = 40.0 + min(35.0, value)
            yield weight, Risk(what, because + in_scene(design, scene), f"{format_quantity(value, 'px')}")


#: What takes the detail of the corners, by how far it spreads a point.
BLURS = (("defocus_corner_px", "they are out of focus by"), ("lateral_colour_px", "the flat port spreads colours over"))


def lost_in_corners(result: Result, design: Design) -> Weighed:
    """Corners in which bars of two pixels (half of Nyquist's frequency) keep too little contrast to be resolved.

    The less they keep, the larger the part of every image that shows no detail, as where it is dark.
    """
    scene, kept = worst(design, "mtf_half_nyquist_corner", least=True)
    if scene is None or kept >= RESOLVED_CONTRAST:
        return
    known = [(told, scene.figures.get(name) or 0.0) for name, told in BLURS]
    causes = listed([f"{told} {format_quantity(value, 'px')}" for told, value in known if value >= TELLING_PX])
    because = (causes or "lens, diffraction and motion blur them") + in_scene(design, scene)
    share = f"{100.0 * kept:.2g} %" if kept > 0.0 else "none"
    figure = f"two-pixel bars keep {share} of their contrast"
    yield 78.0 - 20.0 * kept / RESOLVED_CONTRAST, Risk("fine detail is lost in the corners", because, figure)


def smeared_subjects(result: Result, design: Design) -> Weighed:
    """Subjects that move while the mission asks for no limit of motion blur."""
    swim = any(given.get("subject_speed_m_s") for given in result.mission.get("scenes") or [])
    if not swim or any(margin.requirement == "max_blur_px" for margin in design.margins):
        return
    scene, value = worst(design, "blur_px")
    if scene is not None and value > SEEN_PX:
        because = f"no limit of motion blur is asked for{in_scene(design, scene)}"
        yield 44.0, Risk("what moves is smeared", because, format_quantity(value, "px"))


def must_stand_still(result: Result, design: Design) -> Weighed:
    """Light that is gathered so long that a slow drift smears it, where the mission says that nothing moves."""
    still = [scene for scene in design.scenes if scene.figures.get("blur_px") == 0.0 and scene.figures.get("gsd_mm")]
    lit = [(gathering_s(result, scene), scene) for scene in still]
    if not lit:
        return
    lit_s, scene = max(lit, key=lambda item: item[0] / item[1].figures["gsd_mm"])
    drift_mm_s = scene.figures["gsd_mm"] / lit_s if lit_s else math.inf
    if drift_mm_s < STILL_MM_S:
        because = (
            f"{format_quantity(1e3 * lit_s, 'ms')} of light smear by a pixel at a drift of "
            f"{format_quantity(drift_mm_s, 'mm/s')}{in_scene(design, scene)}, and the mission says that nothing moves; "
            "speed_m_s or limits.max_exposure_ms asks for less"
        )
        yield 58.0, Risk("camera and scene must stand still", because, "")


def gathering_s(result: Result, scene: SceneResult) -> float:
    """How long an image gathers light: the pulse in the dark, the exposure under the sun or where lamps burn."""
    sunlit = any(one.get("sun_lux") for one in result.mission.get("scenes") or [] if one.get("name") == scene.name)
    exposure_ms, pulse_ms = (scene.settings.get(key) or 0.0 for key in ("exposure_ms", "pulse_ms"))
    return 1e-3 * (min(exposure_ms, pulse_ms) if pulse_ms and not sunlit else exposure_ms)


def weak_colours(result: Result, design: Design) -> Weighed:
    """Channels that must be amplified much."""
    scene, value = worst(design, "white_balance")
    if scene is None or value <= REFUSED["white_balance"][1]:
        return
    lifted = {"green": 1.0} | {name: scene.figures.get(f"white_balance_{name}") or 0.0 for name in ("red", "blue")}
    colour = max(lifted, key=lambda name: lifted[name])
    because = f"so little {colour} arrives that white balance lifts it, and its noise"
    yield 42.0, Risk(f"{colour} is mostly noise", because, f"white balance x {value:.2g}")


def wide_open(result: Result, design: Design) -> Weighed:
    """A lens at its widest."""
    if any(m.requirement == "f_number_min" and m.binding for m in design.margins):
        stop = min(s.settings.get("f_number") or 0.0 for s in design.scenes)
        because = (
            "every lens is least sharp there, above all in the corners; stopping down asks for more light"
        )
        yield 35.0, Risk("the lens is used wide open", because, f"f/{stop:.3g}")


def high_gain(result: Result, design: Design) -> Weighed:
    """Gain in place of light."""
    gain_db = max((s.settings.get("gain_db") or 0.0) for s in design.scenes)
    if gain_db > MOST_GAIN_DB:
        because = "little of the pixel's capacity is used, so highlights are lost early"
        yield 26.0, Risk("gain stands in for light", because, format_quantity(gain_db, "dB"))


# ---------------------------------------------------------------- money and choice


def price(result: Result, design: Design) -> Weighed:
    """A price above the limit at its high end, or one that nobody has quoted."""
    cost = design.totals.cost
    limit = (result.mission.get("limits") or {}).get("cost")
    share = cost.estimated / cost.value if cost.value else 0.0
    told = "nearly all" if 0.995 <= share < 1.0 else f"{100 * share:.0f} %"  # which would round to all of it
    because = f"{told} of the price is estimated"
    if limit is not None and cost.value <= limit < cost.high:
        end = format_at_most(max(cost.low, limit), cost.high)  # with the digits that tell it from the limit
        figure = f"up to {end} against {format_money(limit, cost.currency)}"
        yield 58.0, Risk("it may cost more than allowed", because, figure)
    elif share > MUCH_ESTIMATED:
        figure = format_price(cost.low, cost.high, cost.currency)
        width = (cost.high - cost.low) / cost.value
        yield 20.0 + 30.0 * min(1.0, width), Risk("the price is not known", because, figure)
    unknown = sum(row.to_buy for row in design.bom if row.unit_price is None)
    if unknown and result.command == "solve":
        because = "nobody tells their price, so the sum leaves them out"
        yield 57.0, Risk("parts without a price", because, counted(unknown, "part"))


def dearer_than_it_must(result: Result, design: Design) -> Weighed:
    """A system that costs much less and is as good, as far as anybody will notice."""
    cheap = result.less_money
    if cheap is None or (more := cheap.value / cheap.value_of_best - 1.0) > UNNOTICED:
        return
    if cheap.is_less_even(design.least("uniformity")):
        return
    prices = (float(f"{amount:.2g}") for amount in (cheap.price_of_best, cheap.price))
    ours, theirs = (format_money(amount, cheap.currency) for amount in prices)
    which = "better" if more < -UNNOTICED else "as good within what anybody notices"
    because = f"another system is {which}: `For less money` names it"
    yield 90.0, Risk("it costs more than it must", because, f"{ours} against {theirs}")


def held_back(result: Result, design: Design) -> Weighed:
    """A limit of power or cost below which the best image has not come to its knee."""
    if result.knee is None:
        return
    for item in result.knee.bought:
        asked = result.knee.per_w if item.name == "power_w" else result.knee.per_100_usd
        if item.beyond_limit and item.gain > asked:
            what = "power" if item.name == "power_w" else "cost"
            because = f"{format_quantity(item.more, item.unit)} above it would better the images by more than it takes"
            yield 32.0, Risk(f"your limit of {what} holds the image back", because, f"{100.0 * item.gain:.2g} %")


def to_be_made(result: Result, design: Design) -> Weighed:
    """Parts that no shop sells."""
    kinds = [kind for kind, part in design.hardware.parts.items() if part.generic]
    if kinds:
        because = f"{listed(kinds)} must be found or made; figures and prices are those of their class"
        share = f"{len(kinds)} of {len(design.hardware.parts)} parts"
        yield 65.0, Risk("parts that no shop sells under a name", because, share)


def maybe_withdrawn(result: Result, design: Design) -> Weighed:
    """Parts of which nobody says whether they are still sold."""
    unsure = [row for row in design.bom if row.availability == "unknown" and row.to_buy]
    if unsure and result.command == "solve":
        because = f"no source says so of {listed([row.id for row in unsure])}"
        yield 18.0, Risk("parts that may be sold no longer", because, counted(len(unsure), "part"))


def idle_lamps(result: Result, design: Design) -> Weighed:
    """Lamps that are bought and never lit."""
    lamps = design.hardware.light_count
    if lamps and all(scene.settings.get("dim_frac") == 0.0 for scene in design.scenes):
        because = "daylight alone does what is asked; vehicle.light_count: 0 leaves them out"
        yield 34.0, Risk("lamps are bought that stay off", because, counted(lamps, "lamp"))


def better_elsewhere(result: Result, design: Design) -> Weighed:
    """What may be the better system after all."""
    doubt = result.robustness or {}
    if result.status == "stopped" and result.certificate is not None:
        gap = format_quantity(result.certificate.gap_abs, result.objective.unit)
        yield (
            40.0,
            Risk("a better system may exist", "the search was stopped before it was done", f"by up to {gap}"),
        )
    if quotes := doubt.get("quotes_that_matter"):
        because = "one estimated number, known better, would change the answer"
        yield 28.0, Risk("another system may be the better buy", because, counted(len(quotes), "such number"))
    elif (doubt.get("max_regret") or 0.0) > 0.0:
        because = "estimated numbers decide between them"
        figure = f"by up to {format_quantity(doubt['max_regret'], result.objective.unit)}"
        yield 20.0, Risk("another system may be the better buy", because, figure)


def noted(result: Result, design: Design) -> Weighed:
    """What the run and the parts have noted."""
    messages: dict[str, Note] = {
        note.message or note.code: note for note in [*result.warnings, *design.warnings]
    }
    for message, note in messages.items():
        weight = NOTES.get(note.code, OTHER_NOTE)
        if note.code == AS_CENTRAL and result.confidence is not None and result.confidence.enough:
            weight = OTHER_NOTE  # it holds as often as was asked, however it was chosen
        if weight:
            yield weight, Risk(message, "", "")


RULES: Sequence[Callable[[Result, Design], Weighed]] = (
    missed, uncertain, at_bad_ends, nothing_in_hand, shallow, drained, overheated, floats, in_other_water, lamps_off,
    noisy, uneven, lost_in_corners, seen_in_the_image, smeared_subjects, must_stand_still, weak_colours, wide_open,
    high_gain, held_back, dearer_than_it_must, price, to_be_made, maybe_withdrawn, idle_lamps, better_elsewhere, noted,
)  # fmt: skip


# ---------------------------------------------------------------- margins and figures


def tight(design: Design) -> list[Margin]:
    """Requirements on the images and the vehicle with next to no margin, the tightest first."""
    found = [(left, m) for m in design.margins if m.key not in OF_SETTINGS
             and m.satisfied and (left := m.share_left) is not None and left < NOTHING_IN_HAND]  # fmt: skip
    return [margin for _, margin in sorted(found, key=lambda item: item[0])]


def in_hand_names(design: Design) -> str:
    """The same in words."""
    return listed(dict.fromkeys(asked_name(margin) for margin in tight(design)))


def sharp_where(result: Result) -> str:
    """` to the corners` where the depth of field must hold there; empty where it holds on the axis."""
    asked = (result.mission.get("requirements") or {}).get("dof_at")
    return TO_CORNERS if asked == "corner" and result.physics.name != "paper" else ""


def missed_figure(margin: Margin, where: str) -> str:
    """Value and limit of what is missed; of an end of the depth of field what is sharp, where, and what should be."""
    if margin.key not in OFF_FOCUS or margin.value is None:
        return against_limit(margin)
    value, limit = value_and_limit(margin)
    side = "from" if margin.sense == "<=" else "to"
    return f"sharp{where} only {side} {value}, not {side} {limit}"


def tight_figure(margin: Margin, where: str) -> str:
    """What is tightest, with value and limit; an end of the depth of field as what is still sharp there."""
    if margin.key not in OFF_FOCUS:
        return f"{asked_name(margin)} {against_limit(margin)}"
    assert margin.margin is not None and margin.limit is not None
    rounding = abs(margin.margin) <= SATISFIED_REL * abs(margin.limit)
    (value, limit), left = value_and_limit(margin), format_difference(0.0 if rounding else margin.margin, margin.unit)
    side, wanted = ("from", "nearest") if margin.sense == "<=" else ("to", "farthest")
    return f"sharp{where} {side} {value}, the {wanted} floor at {limit}: margin {left}"


def asked_name(margin: Margin) -> str:
    """A requirement in words."""
    return in_words(margin.key)


def against_limit(margin: Margin) -> str:
    """`29.0 dB against 30.0 dB`."""
    value, limit = value_and_limit(margin)
    return f"{margin.word if margin.value is None and margin.word else value} against {limit}"


def value_and_limit(margin: Margin) -> tuple[str, ...]:
    """Value and limit, with as many digits as tell them apart."""
    return texts_apart(margin.value, margin.limit, text=lambda x, digits: format_quantity(x, margin.unit, digits))


def in_words(requirement: str) -> str:
    """A key in words, without the part that it is about."""
    key = requirement.partition(" (")[0]
    return "depth of field" if key in OFF_FOCUS else REQUIREMENTS.get(key, key).partition(",")[0]


def worst(design: Design, figure: str, *, least: bool = False) -> tuple[SceneResult | None, float]:
    """The scene that has the most of a figure, or the least, and how much."""
    known = [
        (float(s.figures[figure]), s)
        for s in design.scenes
        if isinstance(s.figures.get(figure), (int, float))
    ]
    if not known:
        return None, 0.0
    value, scene = (min if least else max)(known, key=lambda item: item[0])
    return scene, value


def least_of(tilt: dict[str, float | None], name: str) -> float | None:
    """The smaller of both ways that a lamp can lean."""
    known = [v for way in ("outward", "inward") if (v := tilt.get(f"{name}_{way}_deg")) is not None]
    return min(known, default=None)


# ---------------------------------------------------------------- words


def in_scene(design: Design, scene: SceneResult) -> str:
    """Which scene, where there are several."""
    return f" in {scene.name}" if len(design.scenes) > 1 else ""


def counted(number: int, noun: str) -> str:
    """`1 part`, `2 parts`."""
    return f"{number} {noun}" + ("" if number == 1 else "s")

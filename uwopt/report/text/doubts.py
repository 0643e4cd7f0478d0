"""How far a result may be trusted, as text: certificate, robustness, second opinions, assumptions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from uwopt.catalog.records import OF_A_DESIGN
from uwopt.report.text import formats, words
from uwopt.report.text.layout import Block, Line, Text, block, columns, fact_lines, sentence
from uwopt.results.basis import Assumption, Opinion
from uwopt.results.certainty import Confidence
from uwopt.results.result import Certificate, Result
from uwopt.units import count_text, counted, format_number, format_within, is_number, split_unit

if TYPE_CHECKING:
    from uwopt.results.front import FrontResult

MOST_ASSUMPTIONS = 12
LONGEST_REASON = 80
NO_QUOTE_MATTERS = "no single number, known better, would change the answer"


def certificate_block(result: Result, certificate: Certificate) -> Block:
    """Bound, best value and gap, and where every combination went."""
    return block("Certificate", [fact_lines(claim_facts(result, certificate)), *account_lines(certificate)])


def claim_facts(result: Result, certificate: Certificate) -> list[tuple[str, str]]:
    """What is claimed, and how far the claim reaches."""
    gap = formats.quantity(certificate.gap_abs, result.objective.unit)
    if certificate.gap_rel is not None:
        gap += f" ({formats.share(certificate.gap_rel)} of the best value)"
    maximised = result.objective.direction == "maximise"
    return [
        (
            "no system can be " + ("above" if maximised else "below"),
            words.bound_text(result, certificate.lower_bound, certificate.gap_abs),
        ),
        ("best found", words.bound_text(result, certificate.best_value, certificate.gap_abs)),
        ("as set", as_set_clause(result)),
        ("gap", gap),
        ("complete", "yes" if certificate.complete else "no, the search was stopped"),
        ("covers", certificate.scope),
    ]


def as_set_clause(result: Result) -> str:
    """`2.31 W, 0.24 % worse than with exact settings: ...`; empty where rounding costs nothing that is told."""
    design = result.recommendation
    if design is None or design.rounded is None or not design.is_settable:
        return ""
    exact, shown = design.objective_value, design.rounded.objective_value
    text = words.value_text(result, design, shown)
    if not exact or shown is None or text == words.value_text(result, design, exact):
        return ""
    better = (shown > exact) == (result.objective.direction == "maximise")
    by = f"{formats.share(abs(shown - exact) / abs(exact))} {'better' if better else 'worse'} than with exact settings"
    return f"{text}, {by}: stops, times, gain and light are rounded to what can be set"


def account_lines(certificate: Certificate) -> list[Line]:
    """Where every combination went, and whether that adds up."""
    account = columns(("", "right"), ("", "left"), header=False)
    account.add_row(
        Text(count_text(certificate.loaded)), Text("combinations loaded: all parts of the catalogue")
    )
    account.add_row(
        Text(count_text(certificate.selected)), Text("of them of parts that the mission allows")
    )
    account.add_row(Text(count_text(certificate.evaluated)), Text("evaluated"))
    account.add_row(Text(""), Text("discarded, each by the first rule that applies:"))
    for item in certificate.discarded:
        if item.count:
            account.add_row(Text(count_text(item.count)), Text("  " + words.rule_name(item.rule)))
    return [account, sentence(words.account_sentence(certificate))]


def robustness_block(result: Result) -> Block:
    """What the estimated numbers could change."""
    doubt = result.robustness or {}
    facts = [("could be beaten by", regret_text(result))]
    if doubt.get("complete") is False:
        facts.append(("", "the search for a rival was cut short, for each takes long here: a better one may be left; "
                          "where settings have no closed form single quotes were not tried"))  # fmt: skip
    facts.append(("rival", rival_text(doubt.get("rival"))))
    facts.append(("a toss", words.equal_sentence(result, most=9)))
    facts.append(("same sensor", words.sibling_sentence(result, most=9)))
    if result.confidence is not None:
        facts.append(("scenarios draw", drawn_text(result.confidence)))
    facts.append(("at the bad ends", bad_ends_text(doubt)))
    facts += [("other water", water_text(other, result)) for other in doubt.get("waters") or []]
    advice = dict.fromkeys(water.advice for water in result.physics.waters)
    facts += [("the water", formats.one_line(text)) for text in advice]
    facts += tilt_facts(doubt)
    quotes = doubt.get("quotes_that_matter") or []
    facts.append(("to ask for first", "" if quotes else f"nothing: {NO_QUOTE_MATTERS}"))
    return block("How firm this is", [fact_lines(facts), *quote_lines(quotes, result)])


def quote_lines(quotes: Sequence[Any], result: Result) -> list[Line]:
    """What to ask for first, below the system that each of these numbers would let win: a rival is named once."""
    if not quotes:
        return []
    by_rival: dict[str, list[str]] = {}
    for item in quotes:
        by_rival.setdefault(rival_of(item, result), []).append(quoted_number(item))
    head = "Ask for these first; one alone, at the end of its range, would change the recommendation:"
    lines: list[Line] = [sentence(head)]
    for rival, numbers in by_rival.items():
        lines += [sentence(f"Then better with {rival}:")] if rival else []
        lines += [sentence("- " + formats.one_line(number)) for number in numbers]
    return lines


def drawn_text(known: Confidence) -> str:
    """What the scenarios of a confidence draw."""
    return "; ".join(map(formats.one_line, known.drawn)) or "nothing"


def regret_text(result: Result) -> str:
    """How much better a rival could be; "" where that was not worked out."""
    doubt = result.robustness or {}
    regret = doubt.get("max_regret")
    if isinstance(regret, (int, float)):
        if regret <= 0:
            return "none: no end of the estimates makes another system better"
        value = words.objective_text(result, float(regret))
        return f"{value} at most, the estimates at their ends"
    if doubt.get("feasible_at_bad_end") is False:
        return "any that fits: with its estimates at their bad ends this system misses a requirement"
    return ""


def bad_ends_text(doubt: Mapping[str, Any]) -> str:
    """Whether the requirements hold with all estimates at their bad ends; "" where that is not known."""
    holds = doubt.get("feasible_at_bad_end")
    if holds is None:
        return ""
    return "every requirement still holds" if holds else "a requirement may be missed"


def effect_lines(result: Result | FrontResult) -> list[str]:
    """Each effect with the bound of its influence, and whether the model keeps it here."""
    shown = []
    for item in result.physics.effects:
        if item.bound is None:
            size = "asked for by a requirement or the objective"
        elif item.bound == 0.0:
            size = "not in this scene"
        else:
            size = f"changes a requirement by up to {format_number(100 * item.bound, 2)} %"
        saved = f", about {item.time_saved_s:.2g} s saved" if item.time_saved_s else ""
        name = formats.one_line(item.name).replace("_", " ")
        shown.append(f"- {name}: {size}; {'kept' if item.kept else 'left out'}{saved}")
    return ["effects:", *shown] if shown else []


def tilt_facts(doubt: Mapping[str, Any]) -> list[tuple[str, str]]:
    """How far the lamps' tilt may be off, and what places between the grid's points would give."""
    facts = []
    tilt: Mapping[str, Any] = doubt.get("tilt") or {}
    if tilt:
        most = tilt["tried_up_to_deg"]

        def ends(name: str) -> str:
            shown = [tilt.get(f"{name}_{way}_deg") for way in ("outward", "inward")]
            if None in shown:
                return "not known"
            out, inward = (f"{v:.1f}°" + (" or more" if v >= most else "") for v in shown)
            return f"{out} outward, {inward} inward"

        broken = ", ".join(words.requirement_name(name) for name in tilt["first_to_break"])
        then = f" (then {broken})" if broken else ""
        facts.append(("tilt may be off", f"{ends('held')} with light and exposure as set{then}"))
        facts.append(("", f"{ends('readjusted')} if light, exposure and gain are set anew"))
    better = doubt.get("outside_certificate")
    if better and better["gain_rel"] > 1e-6:
        facts.append(
            (
                "lamps between the places tried",
                f"{100 * better['gain_rel']:.2g} % better with baseline {better['baseline_m']:.3f} m, "
                f"tilt {better['tilt_deg']:.2f}°",
            )
        )
    return facts


#: Fields of parts whose names say little to who has to ask for them.
NUMBERS = {"qe_scale": "quantum efficiency (as a factor)", "output_factor": "share of its light that leaves the window",
           "flash_duration_at_frac": "light left when the stated flash duration ends (share of the peak)",
           "saturation_e": "full-well capacity", "read_noise_e": "read noise", "dark_current_e_s": "dark current",
           "standby_w": "standby power", "wake_up_s": "time to wake up", "warm_up_s": "time to warm up",
           "recycle_s": "recycling time", "min_object_distance_m": "nearest focus", "f_number_min": "widest f-number",
           "f_number_max": "narrowest f-number", "min_exposure_us": "shortest exposure",
           "min_pulse_us": "shortest pulse", "max_exposure_us": "longest exposure", "max_pulse_us": "longest pulse",
           "max_rate_hz": "highest rate", "max_duty_frac": "highest duty", "max_gain_db": "highest gain",
           "colour_temperature_k": "colour temperature",
           "aberration_pitch_um": "smallest pixel that the lens serves"}  # fmt: skip
PRICES = ("price", "host price")
#: What is taken for the loss of light between lamp and floor, by the name in a result.
LAMP_LOSSES = {
    "as the model has it": "lamp light lost as modelled",
    "the least": "as little lamp light lost as can be",
    "the most": "as much lamp light lost as can be",
}


def water_text(other: Mapping[str, Any], result: Result) -> str:
    """What becomes of the recommendation when another water table, or another K, is believed."""
    case = other.get("case") or {}
    lost = str(case.get("lamp_attenuation", ""))
    table = f"{formats.one_line(case.get('water_table', ''))} table, {LAMP_LOSSES.get(lost, formats.one_line(lost))}"
    if reading := case.get("reading"):
        table = formats.one_line(reading)
    value = other.get("objective_value")
    if value is None:
        held = f"{table}: this system misses a requirement"
    else:
        held = f"{table}: this system then has {words.objective_text(result, float(value))}"
    if not other.get("changes"):
        return held + "; of those shown it stays the best"
    best = other.get("best_of_shown")
    return held + (f"; {' + '.join(best)} is then better" if best else "; so does all else that is shown")


def rival_text(rival: Any) -> str:
    """The system that could win, by its parts."""
    if rival is None:
        return "none"
    if not isinstance(rival, Mapping):
        return formats.one_line(rival)
    hardware = rival.get("hardware", rival)
    parts = [hardware[kind] for kind in OF_A_DESIGN if hardware.get(kind)]
    named = [formats.one_line(part) for part in words.as_bought(parts)]
    count = hardware.get("light_count")
    return " + ".join(named) + (f", {counted(count, 'light')}" if count else "")


def quote_text(item: Any, result: Result) -> str:
    """One number worth asking for: whose, how it stands, and who wins otherwise."""
    rival = rival_of(item, result)
    return formats.one_line(quoted_number(item) + (f"; then better with {rival}" if rival else ""))


def rival_of(item: Any, result: Result) -> str:
    """What the system has that would win, where it differs from the recommendation; "" where none is told."""
    rival = str(item.get("then_better") or "") if isinstance(item, Mapping) else ""
    own = result.best.hardware.ids if result.best is not None else []
    different = words.as_bought([name for name in rival.split(" + ") if name not in own])
    return formats.one_line(" + ".join(different) or "another number of lights") if rival else ""


def number_name(field: str) -> str:
    """A field of a part as its maker calls it."""
    return NUMBERS.get(field, split_unit(field)[0].removesuffix("_frac").replace("_", " "))


def quoted_number(item: Any) -> str:
    """`price of acme-lamp (1 700 to 3 400 USD)`, `output of acme-lamp ~0.7 (0.5 to 0.9)`."""
    if not isinstance(item, Mapping):
        return formats.one_line(item)
    number = number_name(str(item.get("field") or ""))
    unit = str(item.get("unit") or "")
    whose = item.get("part") or item.get("id") or item.get("path")
    if number in PRICES and is_number(item.get("low")) and is_number(item.get("high")):
        return f"{number} of {whose} ({formats.price_text(item['low'], item['high'], unit)})"
    span = range_text(item.get("low"), item.get("high"), unit)
    standing = f" ~{formats.quantity(item.get('value'), unit)}" + (f" ({span})" if span else "")
    return f"{number} of {whose}{standing}"


def second_opinion_block(result: Result) -> Block:
    """What other solvers and the audit say."""
    lines: list[Line] = []
    if result.solvers:
        table = columns(
            ("solver", "left"),
            ("hardware", "left"),
            ("objective", "right"),
            ("off by", "right"),
            ("verdict", "left"),
        )
        for item in result.solvers:
            off = item.difference_rel
            table.add_row(
                Text(formats.one_line(item.method)),
                Text(whose(result, item.hardware)),
                Text(words.objective_text(result, item.objective_value)),
                Text(formats.quantity(None) if off is None else formats.share(off)),
                Text(*opinion_verdict(item)),
            )  # fmt: skip
        lines += [sentence("The settings solved again by other means:"), table]
        why = dict.fromkeys(item.message for item in result.solvers if item.method == "bonmin" or not item.agrees)
        lines += [sentence(formats.one_line(text)) for text in why if text]
    if result.audit:
        lines.append(audit_sentence(result.audit))
    return block("Second opinions", lines)


#: What another solver says where it does not agree, by its status.
DISAGREES = {
    "optimal": "has another optimum", "feasible": "settings that fit, not shown to be best",
    "infeasible": "finds no settings that fit", "failed": "came to no end",
}  # fmt: skip


def opinion_verdict(item: Opinion) -> tuple[str, str]:
    """Whether another solver agrees, or what it says instead, and the style of that."""
    if item.agrees:
        return "agrees", ""
    return DISAGREES.get(item.status, formats.one_line(item.status)), "yellow"


def whose(result: Result, hardware: list[str]) -> str:
    """Which design of the result has this hardware."""
    if result.best is not None and result.best.hardware.ids == hardware:
        return "the recommendation"
    for number, design in enumerate(result.runners_up, start=2):
        if design.hardware.ids == hardware:
            return f"runner-up {number}"
    return formats.one_line(" + ".join(hardware), 120)


def audit_sentence(audit: Mapping[str, Any]) -> Text:
    """Outcome of the attack on what was not recommended."""
    tried = counted(int(audit.get("tried") or 0), "other combination")
    if audit.get("passed", True):
        return sentence(f"Audit: {tried} tried again by a generic search; none beats the recommendation.")
    better = audit.get("better") or [{}]
    return sentence(
        f"Audit FAILED: {tried} tried again, {len(better)} better, first {plain_facts(better[0])}.",
        "bold red",
    )


def plain_facts(facts: Mapping[str, Any]) -> str:
    """`name value` pairs with units; long lists and inner tables are left to the result file."""
    return ", ".join(
        f"{formats.one_line(name.replace('_', ' '))} {fact}"
        for name, value in facts.items()
        if (fact := plain_fact(name, value))
    )


def plain_fact(name: str, value: Any) -> str:
    """One value in words; "" for what does not fit on a line."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (int, float)):
        return (
            count_text(value)
            if isinstance(value, int)
            else formats.quantity(value, split_unit(name)[1], 4)
        )
    return formats.one_line(value, 120) if isinstance(value, str) else ""


def assumption_blocks(result: Result | FrontResult) -> Iterator[Block]:
    """What was assumed, and what the physics leaves out."""
    if result.assumptions:
        yield block(f"Assumptions ({len(result.assumptions)})", assumption_lines(result))
    yield model_block(result)


def model_block(result: Result | FrontResult) -> Block:
    """Which physics, what it leaves out here, and what it never has."""
    physics = [f"physics {formats.one_line(result.physics.name)}"]
    left = [effect for effect in result.physics.effects if not effect.kept]
    if left:
        bound, names = sum(effect.bound or 0.0 for effect in left), ", ".join(effect.name for effect in left)
        physics.append(f"left out as too small here (together at most {formats.share(bound)}): {names}")
    lines: list[Line] = [sentence("; ".join(physics))]
    if result.physics.not_modelled:
        lines.append(sentence("not modelled: " + "; ".join(result.physics.not_modelled)))
    lines += [sentence(text) for text in effect_lines(result)]
    return block("Model", lines)


def assumption_lines(result: Result | FrontResult, *, whole: bool = False) -> list[Line]:
    """What the model takes for granted, then estimated numbers, one a line; the first of them unless `whole`."""
    most, longest = (len(result.assumptions), 400) if whole else (MOST_ASSUMPTIONS, LONGEST_REASON)
    ranked = sorted(result.assumptions, key=lambda item: item.low is not None)
    table = columns(("what", "left"), ("value", "right"), ("range", "right"), ("why", "left"))
    for item in ranked[:most]:
        table.add_row(
            Text(formats.one_line(item.path, longest // 2)),
            *map(Text, assumed_texts(item)),
            Text(formats.one_line(item.source, longest)),
        )
    rest = len(ranked) - most
    return [
        table,
        *([sentence(f"and {rest} more; --json and result.json list all", "dim")] if rest > 0 else []),
    ]


def assumed_texts(item: Assumption) -> tuple[str, str]:
    """What is taken, and its range; of a price no more digits than the range leaves."""
    low, high = item.low, item.high
    if item.path.endswith("price") and is_number(item.value) and low is not None and high is not None:
        return "~" + format_within(item.value, low, high, item.unit), formats.price_text(low, high, item.unit)
    return assumed(item.value, item.unit), range_text(low, high, item.unit)


def assumed(value: Any, unit: str) -> str:
    """An assumed value, estimated numbers with their mark."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return formats.one_line(value if value is not None else "", 30)
    return "~" + formats.quantity(float(value), unit)


def range_text(low: Any, high: Any, unit: str) -> str:
    """The range of an estimate."""
    if not isinstance(low, (int, float)) or not isinstance(high, (int, float)) or low == high:
        return ""
    return f"{formats.quantity(float(low))} to {formats.quantity(float(high), unit)}"

"""The verdict in two sentences: what to buy or what the trade-off is, and how sure that is.

Every word is taken from the result; nothing is judged here.
"""

from __future__ import annotations

from uwopt.front_result import FrontObjective, FrontResult
from uwopt.report import words
from uwopt.report.doubts import (
    HELPFUL,
    NO_QUOTE_MATTERS,
    bad_ends_text,
    miss_text,
    quote_text,
    relaxation_texts,
    relaxations_of,
)
from uwopt.report.tables import nearest_miss
from uwopt.result import Design, Result
from uwopt.units import format_number

OBJECTIVE_NAMES = {
    "power": "power", "cost": "cost", "mass": "mass", "snr_db": "signal to noise", "gsd_mm": "pixel on the floor",
    "contrast": "contrast", "information": "information",
}  # fmt: skip


def verdict(result: Result | FrontResult) -> tuple[str, str]:
    """What the result says, and how sure it is."""
    if isinstance(result, FrontResult):
        first, second = (front_sentence(result), front_trust(result)) if result.points else nothing(result)
    elif result.best is None:
        first, second = nothing(result)
    else:
        first, second = best_sentence(result, result.best), best_trust(result, result.best)
    return words.as_sentence(first), words.as_sentence(second)


def system_text(design: Design) -> str:
    """`1 × camera with 1 × lens behind 1 × port, and 2 × light`."""
    hardware = design.hardware
    many, lights = hardware.get("camera_count") or 1, hardware.get("light_count") or 1
    names = {kind: words.part_name(hardware[kind]) for kind in ("camera", "lens", "port", "light")}
    return (
        f"{many} × {names['camera']} with {many} × {names['lens']} behind {many} × {names['port']}"
        f", and {lights} × {names['light']}"
    )


def best_sentence(result: Result, design: Design) -> str:
    """What to buy, what it costs and draws; of a given system, whether it does what is asked."""
    cost = words.cost_sentence(design.totals.get("cost") or {}, words.n_unpriced(design.bom))
    figures = f"{cost}; power {words.quantity(design.totals.get('power_w'), 'W')}"
    if result.command == "evaluate":
        return f"{words.status_sentence(result)} by {system_text(design)}: {figures}".replace(
            "is met by", "is met with"
        )
    return f"Buy {system_text(design)}: {figures}"


def best_trust(result: Result, design: Design) -> str:
    """The certificate's claim, and what could change the answer."""
    if result.command == "evaluate":
        missed = list(
            dict.fromkeys(
                words.requirement_name(margin.requirement)
                for scene in design.scenes
                for margin in scene.margins
                if not margin.satisfied
            )
        )
        estimated = sum(1 for item in result.assumptions if item.get("low") is not None)
        said = [f"missed: {', '.join(missed)}"] if missed else []
        said.append(f"computed with physics {words.one_line(result.physics.get('name') or '')}")
        if estimated:
            said.append(f"{words.counted(estimated, 'number')} of it estimated, listed under assumptions")
        return "; ".join(said)
    said = [words.status_sentence(result)]
    proof = result.certificate
    if proof is not None and proof.gap_abs is not None:
        gap = words.quantity(proof.gap_abs, str(result.objective.get("unit") or ""))
        said.append(f"the gap between bound and best value is {gap}")
    doubt = result.robustness or {}
    if ends := bad_ends_text(doubt):
        said.append(f"with all estimates at their bad ends {ends}")
    if quotes := doubt.get("quotes_that_matter"):
        said.append(f"ask first for {quote_text(quotes[0], result)}")
    elif result.robustness:
        said.append(NO_QUOTE_MATTERS)
    return "; ".join(said)


def nothing(result: Result | FrontResult) -> tuple[str, str]:
    """Why there is no system, and which changes would help."""
    if isinstance(result, Result):
        first = words.status_sentence(result)
    else:
        first = words.STATUS_SENTENCES.get(result.status, f"the search was {result.status}")
        if result.status != "infeasible":
            first = f"{first} and no system was found"
    miss = nearest_miss(result)
    if miss is not None:
        nearest = miss_text(result)
        first += f"; the nearest miss, {system_text(miss)}," + (
            f" {nearest}" if nearest else " is shown below"
        )
    helpful = relaxations_of(result.infeasible or {})
    if helpful:
        changes = (relaxation_texts(result, item) for item in helpful)
        listed = ", ".join(f"{name.partition(' (')[0]} {possible}" for name, _, possible in changes)
        return first, f"{HELPFUL} {listed}"
    if result.status == "stopped":
        return first, "Give it more time, or a mission with fewer combinations, to know more"
    return first, "No single requirement stands in the way; at least two have to give"


# ---------------------------------------------------------------- fronts


def axis_name(objective: FrontObjective) -> str:
    """An objective in words."""
    return words.one_line(OBJECTIVE_NAMES.get(objective.name, objective.name.replace("_", " ")), 40)


def front_sentence(front: FrontResult) -> str:
    """How many systems trade what against what, over which ranges."""
    spans = []
    for objective in front.objectives:
        values = [point.values[objective.name] for point in front.points]
        best, worst = min(values), max(values)
        if objective.direction == "maximise":
            best, worst = worst, best
        span = words.quantity(best, objective.unit)
        if best != worst:
            span += f" to {words.quantity(worst, objective.unit)}"
        spans.append(f"{axis_name(objective)} {span}")
    number = len(front.points)
    if number == 1:
        return f"One system is best in all of {words.listed([axis_name(o) for o in front.objectives])}: " + (
            f"{system_text(front.points[0].design)}; {', '.join(spans)}"
        )
    hardware = len({point.curve for point in front.points})
    return (
        f"{words.counted(number, 'system')} of {words.counted(hardware, 'choice')} of hardware are left of which"
        f" none is better than another in everything: {', '.join(spans)}"
    )


def front_trust(front: FrontResult) -> str:
    """How each method fared, and how much of the prices is estimated."""
    said = []
    for method in front.methods:
        if method.name == "exact":
            status = "complete" if method.status == "complete" else f"{method.status}, so not complete"
            said.append(f"the exact front is {status}")
        else:
            ratio = method.hypervolume_ratio
            reached = "" if ratio is None else f" and reached {words.share(ratio)} of the exact hypervolume"
            said.append(f"{words.one_line(method.name, 20)} searched on its own{reached}")
    if not front.methods:
        said.append(f"the search is {front.status}")
    costs = [point.design.totals.get("cost") or {} for point in front.points]
    shares = [c["estimated"] / c["value"] for c in costs if c.get("value") and c.get("estimated") is not None]
    if shares:
        low, high = (format_number(100 * end, 2) for end in (min(shares), max(shares)))
        span = f"{low} %" if low == high else f"{low} to {high} %"
        said.append("no price is estimated" if max(shares) == 0 else f"of the cost {span} is estimated")
    return "; ".join(said)

"""The verdict in two sentences: what to buy or what the trade-off is, and how sure that is.

Every word is taken from the result; nothing is judged here.
"""

from __future__ import annotations

from uwopt.quantities import TERMS
from uwopt.report.text import formats, vocabulary, words
from uwopt.report.text.doubts import NO_QUOTE_MATTERS, bad_ends_text, quote_text
from uwopt.report.text.in_hand import fails_first
from uwopt.report.text.nothing_fits import (
    change_texts,
    in_more_time,
    miss_text,
    more_time,
    no_change_helps,
    what_helps,
)
from uwopt.report.text.tables import nearest_miss
from uwopt.results.design import PRACTICE_YIELDS, Design, lamps_in_words
from uwopt.results.front import FrontObjective, FrontPoint, FrontResult
from uwopt.results.result import Result
from uwopt.units import count_text, counted, format_number

CUT = {"stopped": "stopped by a limit", "interrupted": "interrupted"}  # of a front, by its status
OBJECTIVE_NAMES = {term: one.words for term, one in TERMS.items()}


def verdict(result: Result | FrontResult) -> tuple[str, str]:
    """What the result says, and how sure it is."""
    if isinstance(result, FrontResult):
        first, second = (front_sentence(result), front_trust(result)) if result.points else nothing(result)
        if result.points and result.status in CUT:
            first = f"{CUT[result.status]}, so better may exist. {first}"
            second = f"{second}. {more_time(result)}" if result.status == "stopped" else second
    elif result.best is None:
        first, second = nothing(result)
    else:
        first, second = best_sentence(result, result.best), best_trust(result, result.best)
    return words.as_sentence(first), words.as_sentence(second)


def system_text(design: Design) -> str:
    """`1 × camera with 1 × lens behind 1 × port, and 2 × light`."""
    hardware = design.hardware
    many = hardware.camera_count
    names = {kind: words.part_name(part) for kind, part in hardware.named.items()}
    lamps = lamps_in_words(hardware.light_count, names["light"], "×")
    if "complete" in names:
        return f"{many} × {names['complete']}, complete with lens and port, and {lamps}"
    return (
        f"{many} × {names['camera']} with {many} × {names['lens']} behind {many} × {names['port']}"
        + (f" in {many} × {names['housing']}" if "housing" in names else "")
        + f", and {lamps}"
    )


def best_sentence(result: Result, design: Design) -> str:
    """What to buy, what it costs and draws; of a given system, whether it does what is asked."""
    figures = f"{words.cost_sentence(design)}; power {formats.quantity(design.power_as_set_w, 'W')}"
    if result.command == "evaluate":
        return f"{words.status_sentence(result)} by {system_text(design)}: {figures}".replace(
            "is met by", "is met with"
        )
    return f"Buy {system_text(design)}: {figures}"


def best_trust(result: Result, design: Design) -> str:
    """The certificate's claim, and what could change the answer."""
    if result.command == "evaluate":
        missed = words.missed_names(design)
        estimated = sum(1 for item in result.assumptions if item.low is not None)
        first = fails_first(design.as_set, result.deepest_m)
        said = [f"missed: {', '.join(missed)}"] if missed else [f"fails first: {first}"] if first else []
        said.append(f"computed with physics {formats.one_line(result.physics.name)}")
        if estimated:
            said.append(f"{counted(estimated, 'number')} of it estimated, listed under assumptions")
        return "; ".join(said)
    first = fails_first(design.as_set, result.deepest_m)
    said = [text for text in (words.status_sentence(result), first and f"fails first: {first}") if text]
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
        cut = CUT.get(result.status)
        first = f"{cut} before a system was found" if cut else vocabulary.STATUS_SENTENCES[result.status]
    miss = nearest_miss(result)
    if miss is not None:
        nearest = miss_text(result)
        first += f"; the nearest miss, {system_text(miss)}," + (
            f" {nearest}" if nearest else " is shown below"
        )
    said, helpful = what_helps(result)
    if helpful:
        changes = (change_texts(result, item) for item in helpful)
        listed = ", ".join(f"{name.partition(' (')[0]} {possible}" for name, _, possible in changes)
        return first, f"{said} {listed}"
    if result.status in CUT:
        return first, in_more_time(result)
    return first, no_change_helps(result)


# ---------------------------------------------------------------- fronts


def axis_name(objective: FrontObjective) -> str:
    """An objective in words."""
    return formats.one_line(OBJECTIVE_NAMES.get(objective.name, objective.name.replace("_", " ")), 40)


def front_sentence(front: FrontResult) -> str:
    """Between what the choice is: the cheapest system, and what the others give for what more."""
    if len(front.points) == 1:
        point = front.points[0]
        return f"One system is best in all of {words.listed([axis_name(o) for o in front.objectives])}: " + (
            f"{system_text(point.design)}; {', '.join(value_texts(front, point))}"
        )
    picked = picked_points(front)
    if not picked:
        return f"{choices_text(front)}: {', '.join(span_texts(front))}"
    (names, lead), *others = picked
    said = [f"the {names} is {short_system(lead)} at {words.listed(value_texts(front, lead))}"]
    said += [f"{names}: {short_system(point)}, {gain_text(front, point, lead)}" for names, point in others]
    return f"{choices_text(front)}: {'; '.join(said)}"


def choices_text(front: FrontResult) -> str:
    """How many choices are left, or found until the search was stopped."""
    left = "left" if front.status == "complete" else "found so far"
    number = len({point.curve for point in front.points})
    ways = f"in {counted(len(front.points), 'setting')}"
    if number == 1:
        return f"One choice of hardware is {left}, {ways} of which none is better than another in everything"
    return f"{number} choices of hardware are {left}, {ways}, none better than another in everything"


def picked_points(front: FrontResult) -> list[tuple[str, FrontPoint]]:
    """Points that are best in something with their names, the cheapest first; several names of one are joined."""
    named: dict[str, list[str]] = {}
    for pick in sorted(front.picks, key=lambda pick: pick.name != "cheapest"):
        if pick.name != "knee":
            named.setdefault(pick.point, []).append(formats.one_line(pick.name, 40))
    return [(words.listed(names), front.as_told(front.point(point))) for point, names in named.items()]


def short_system(point: FrontPoint) -> str:
    """Camera and lights, by which people tell systems apart."""
    hardware = point.design.hardware
    camera, light = words.part_name(hardware.camera), words.part_name(hardware.light)
    return f"{hardware.camera_count} × {camera} with {lamps_in_words(hardware.light_count, light, '×')}"


def value_texts(front: FrontResult, point: FrontPoint) -> list[str]:
    """Every objective of a point; its name where the unit does not tell it."""
    return [
        (f"{axis_name(o)} " if o.name not in ("cost", "power") else "") + words.axis_text(o, point, 3)
        for o in sorted(front.objectives, key=lambda o: o.name != "cost")
    ]  # fmt: skip


def span_texts(front: FrontResult) -> list[str]:
    """The range of every objective, the better end first."""
    spans = []
    for objective in front.objectives:
        best, worst = (words.axis_text(objective, point, 3) for point in best_and_worst(front, objective))
        spans.append(f"{axis_name(objective)} {best}" + (f" to {worst}" if best != worst else ""))
    return spans


def best_and_worst(front: FrontResult, objective: FrontObjective) -> tuple[FrontPoint, FrontPoint]:
    """The points with the best and the worst of an objective."""
    ordered = sorted(front.points, key=lambda point: point.values[objective.name])
    ends = (ordered[0], ordered[-1])
    return ends[::-1] if objective.direction == "maximise" else ends


def gain_text(front: FrontResult, point: FrontPoint, lead: FrontPoint) -> str:
    """What a point has better than the lead, and what that takes: `3.05 W for 40 % more cost`."""
    gains, prices = [], []
    for objective in front.objectives:
        own, other = point.values[objective.name], lead.values[objective.name]
        worse = own < other if objective.direction == "maximise" else own > other
        if abs(own - other) <= 0.001 * abs(other):
            continue
        if not worse:
            name = "" if objective.name in ("cost", "power") else f"{axis_name(objective)} "
            gains.append(f"{name}{words.axis_text(objective, point, 3)}")
        elif objective.name.endswith("_db") or other <= 0:
            prices.append(f"{formats.quantity(abs(own - other), objective.unit)} worse {axis_name(objective)}")
        else:
            prices.append(ratio_text(own / other, axis_name(objective)))
    return (words.listed(gains) or "the same") + (f" for {words.listed(prices)}" if prices else "")


def ratio_text(ratio: float, name: str) -> str:
    """`40 % more cost`, `4.3 times the cost`."""
    if ratio >= 2:
        return f"{format_number(ratio, 2)} times the {name}"
    return f"{format_number(100 * abs(ratio - 1), 2)} % {'more' if ratio > 1 else 'less'} {name}"


def front_trust(front: FrontResult) -> str:
    """Whether anything is missing from the front, what another method says, how firm the prices are."""
    gave_way = any(note.code == PRACTICE_YIELDS for note in front.warnings)
    said = ["not all of good practice is kept, as the notes say"] if gave_way else []
    proof = front.certificate or {}
    for method in front.methods:
        name = formats.one_line(method.name, 20)
        if method.name == "exact" and method.status == "complete":
            loaded, gap = proof.get("loaded"), proof.get("gap_rel")
            every = f": each of {count_text(loaded)} combinations is accounted for" if loaded else ""
            left = (
                f", and no other system can add more than {formats.share(gap)} to the trade-off" if gap else ""
            )
            said.append(f"the list is proven complete{every}{left}")
        elif method.name == "exact":
            said.append(
                f"the exact search was {formats.one_line(method.status, 20)}, so the list is not complete"
            )
        elif method.hypervolume_ratio is not None:
            ratio = formats.share(method.hypervolume_ratio)
            said.append(
                f"a second method, {name}, searched on its own and reached {ratio} of the exact hypervolume"
            )
        else:
            said.append(f"{name} searched alone, so nothing is proven")
    if not front.methods:
        said.append(f"the search is {front.status}")
    costs = [point.design.totals.cost for point in front.points]
    shares = [cost.estimated / cost.value for cost in costs if cost.value]
    if shares:
        low, high = (format_number(100 * end, 2) for end in (min(shares), max(shares)))
        span = f"{low} %" if low == high else f"{low} to {high} %"
        asked = f"{span} of the cost rests on estimated prices, so ask for quotes before buying"
        said.append("no price is estimated" if max(shares) == 0 else asked)
    return "; ".join(said)

"""The report as one HTML file: made from a result alone, at home without a network.

The file itself is made in `html_file`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from uwopt.deadline import NEVER, Deadline
from uwopt.errors import UwoptError
from uwopt.report.page import sections as page_parts
from uwopt.report.page.front import front_cards, front_data, goal_texts, history_figure
from uwopt.report.page.html_file import compact_json, gzip_text, rendered, safe_id, slim
from uwopt.report.page.sections import DesignPart
from uwopt.report.page.svg import clean_svg
from uwopt.report.text import doubts, exactness, formats, nothing_fits, tables, words
from uwopt.report.text.front_tables import METHOD_HEADS, method_rows, pick_names
from uwopt.report.text.layout import Block, Line, block, fact_lines
from uwopt.report.text.looked_at import in_figure, in_page, wording_of
from uwopt.report.text.opening import first_to_fail, goal_told, how_far, noise_clause, practice_sentences
from uwopt.report.text.short import MOST_RISKS, questions, short_blocks, shown_risks
from uwopt.report.text.verdict import system_text, verdict
from uwopt.results.design import Design
from uwopt.results.front import FrontResult
from uwopt.results.record import plain
from uwopt.results.result import Certificate, Result
from uwopt.solvers.beside import side_by_side
from uwopt.units import percent

TITLES = {"solve": "Recommendation", "evaluate": "Evaluation of a given system", "pareto": "Trade-off"}
GROUPS = {
    "picture": "What the camera would see", "drawing": "Drawing to scale",
    "light": "Light, from its source to the sensor",
    "sharp": "Depth of field", "operation": "Frame rate and exposure", "image": "Light and noise over the image",
}  # fmt: skip
HISTORY = {
    "id": "history", "kind": "plotly", "title": "Hypervolume over time",
    "caption": "How fast each method approached what it reached.",
    "alt": "Lines of the hypervolume that each method had reached over the seconds of its search",
}  # fmt: skip
MOST_ON_PAPER = 40  # points of a front in the printed table, beside the picks
DETAIL_PX = 160  # of the coarsest design, over the width of a detail that all picks show
IMAGE = re.compile(r"data:image/(?:png|jpeg|webp);base64,[A-Za-z0-9+/=]+\Z")


@dataclass
class Pictures:
    """Figures of the page: what the template places, what the script draws, and why some are missing."""

    shown: list[dict[str, Any]] = field(default_factory=list)
    drawn: dict[str, Any] = field(default_factory=dict)
    missing: list[str] = field(default_factory=list)

    def add(self, pictures: list[Any], prefix: str) -> list[dict[str, Any]]:
        """Take pictures in; ids are made unique by the prefix."""
        taken = []
        for picture in pictures:
            item: dict[str, Any] = {
                "id": f"{prefix}-{safe_id(picture.id)}", "group": picture.group, "title": picture.title,
                "caption": picture.caption, "alt": picture.alt, "kind": picture.kind, "content": None,
            }  # fmt: skip
            if picture.kind == "plotly":
                self.drawn[item["id"]] = picture.content  # plain and short already
            elif picture.kind == "svg":
                item["content"] = clean_svg(picture.content, item["id"], picture.alt)
            elif IMAGE.match(picture.content):
                item["content"] = picture.content
            if picture.kind == "plotly" or item["content"]:
                taken.append(item)
        return taken


def report_html(result: Result | FrontResult, deadline: Deadline = NEVER) -> str:
    """The page of a result or a front, with the pictures for which there is time."""
    front = result if isinstance(result, FrontResult) else None
    pictures = Pictures()
    parts = list(design_parts(result, pictures, deadline))
    table = front_data(front) if front and front.points else None
    facts = front_facts(front, pictures) if table and front else None
    data = {"figures": pictures.drawn, "front": table}
    first, second, facts_first = opening(result)
    scripts = ("front.js", "page.js") if data["front"] else ("page.js",)
    said = wording_of(result)
    data["figures"] = in_figure(data["figures"], said)
    page = rendered(
        "page.html", scripts, data, result=result, front=front, version=result.uwopt_version, table=table,
        quantity=formats.quantity, title=TITLES.get(result.command, "Result"),
        name=formats.one_line(result.mission.get("name") or "Mission", 120), first=first, second=second,
        in_words=facts_first,
        parts=parts, pictures=pictures, groups=GROUPS, facts=facts,
        short=list(short_blocks(result)) if isinstance(result, Result) else [],
        alternatives=page_parts.alternatives(result), why=why_block(result), trust=list(trust_blocks(result)),
        others=list(tables.runner_up_blocks(result)) if isinstance(result, Result) else [],
        stages=page_parts.stages(result.timing_s), run_time=words.run_time_sentence(result.timing_s),
        mission_text=mission_text(result), raw=gzip_text(compact_json(result.to_dict())),
        raw_name="front.json" if front else "result.json", status=status_words(result),
    )  # fmt: skip
    return in_page(page, said)


def opening(result: Result | FrontResult) -> tuple[str, str, Block | None]:
    """What stands under the title: how far the answer may be believed; of one system what it is, fails by and needs."""
    if isinstance(result, FrontResult) or (design := result.best) is None:
        said, beside = verdict(result)
        told_below = isinstance(result, Result) and result.status == "stopped"  # as what would help: more time
        return said, "" if told_below else beside, None
    said = " ".join([words.as_sentence(how_far(result)), *practice_sentences(result)])
    facts = {
        "system" if result.command == "evaluate" else "buy": system_text(design),
        "goal": goal_told(result, design),
        "fails first": first_to_fail(result, design),
        "risks": "; ".join(risk.what for risk in shown_risks(result)[:MOST_RISKS]),
        "do first": next(questions(result, design), ""),
    }
    told = [(name, words.as_sentence(formats.one_line(text, 400))) for name, text in facts.items() if text]
    return said, "", block("", [fact_lines(told)])


# ---------------------------------------------------------------- designs and their pictures


def design_parts(
    result: Result | FrontResult, pictures: Pictures, deadline: Deadline
) -> Iterator[DesignPart]:
    """The designs that the page shows in full: the best, or the nearest miss, or a front's picks."""
    if isinstance(result, FrontResult) and result.points:
        names = pick_names(result) or {result.points[0].id: "First point"}
        designs = [result.point(point_id).design for point_id in names]
        width_mm = common_width_mm(designs)
        works = [
            partial(drawn_by_model, result, design, name, deadline, whole=number == 0, width_mm=width_mm)
            for number, (name, design) in enumerate(zip(names.values(), designs, strict=True))
        ]
        made = side_by_side(works, lists=[deadline.left_out])
        for number, ((point_id, name), design) in enumerate(zip(names.items(), designs, strict=True)):
            definition = " ".join(
                words.as_sentence(formats.one_line(pick.definition)) for pick in result.picks if pick.point == point_id
            )  # fmt: skip
            goals = goal_texts(result, result.point(point_id))
            part = page_parts.design_part(
                result, design, name, part_id=point_id, definition=definition, goals=goals
            )
            made[number].place(pictures, f"d{number}", part)
            yield part
        return
    best = result.best if isinstance(result, Result) else None
    shown, name = best, "Recommendation" if result.command == "solve" else "System"
    if shown is None:
        shown, name = tables.nearest_miss(result), "Nearest miss"
    if shown is not None:
        part = page_parts.design_part(result, shown, name)
        drawn_by_model(result, shown, part.name, deadline, whole=True).place(pictures, "d0", part)
        yield part


def common_width_mm(designs: Sequence[Design]) -> float | None:
    """A piece of floor that is a detail to the coarsest of the designs, so that all show the same."""
    sizes = [design.scenes[0].figures.get("gsd_mm") for design in designs if design.scenes]
    known = [float(size) for size in sizes if size]
    return float(f"{DETAIL_PX * max(known):.2g}") if known else None


@dataclass(frozen=True)
class DrawnByModel:
    """Pictures of one design, and why some are missing."""

    pictures: list[Any]
    missing: str = ""

    def place(self, pictures: Pictures, prefix: str, part: DesignPart) -> None:
        """Place them on the page."""
        if self.missing:
            pictures.missing.append(self.missing)
        part.pictures.extend(pictures.add(self.pictures, prefix))
        pictures.shown.extend(part.pictures)


def drawn_by_model(
    result: Result | FrontResult, design: Design, name: str, deadline: Deadline, *, whole: bool,
    width_mm: float | None = None,
) -> DrawnByModel:  # fmt: skip
    """Let the model draw a design: everything, or only the pair of chart and simulated picture."""
    known = len(deadline.left_out)
    try:
        from uwopt.report.pictures import design_pictures as studio

        made = studio.design_pictures(result, design.as_set, whole=whole, width_mm=width_mm, deadline=deadline)
    except UwoptError as fault:
        return DrawnByModel([], f"{name}: {fault}")
    except Exception as fault:  # the result must not be lost for want of a picture
        return DrawnByModel(
            [], f"{name}: a defect of uwopt, please report it: {type(fault).__name__}: {fault}"
        )
    late = deadline.left_out[known:]
    missing = f"{name}: no time was left for {', '.join(late)}; `uwopt report` makes them." if late else ""
    return DrawnByModel(list(made), missing)


# ---------------------------------------------------------------- why, and how sure


def why_block(result: Result | FrontResult) -> Block | None:
    """Why nothing fits, if so."""
    return nothing_fits.infeasible_block(result) if result.infeasible else None


def trust_blocks(result: Result | FrontResult) -> Iterator[Block]:
    """Certificate, doubts, second opinions, assumptions, model, accuracy, warnings."""
    yield from tables.warning_blocks(result)
    if isinstance(result, Result):
        yield from tables.argument_blocks(result)
    elif result.certificate:
        yield Block("Certificate", tuple(front_certificate(result.certificate)))
    yield doubts.model_block(result)
    if isinstance(result, Result) and exactness.has_errors(result):
        yield exactness.exactness_block(result)
    elif result.accuracy:
        yield Block("Numerical error", (fact_lines(page_parts.flat_facts(result.accuracy)),))
    if result.assumptions:
        title = f"Assumptions ({len(result.assumptions)})"
        yield Block(title, tuple(doubts.assumption_lines(result, whole=True)))


def front_certificate(certificate: Mapping[str, Any]) -> list[Line]:
    """What is claimed of a front, and where every combination went."""
    counts = ("loaded", "selected", "evaluated", "discarded")
    lines: list[Line] = [
        fact_lines(page_parts.flat_facts({k: v for k, v in certificate.items() if k not in counts}))
    ]
    if all(certificate.get(name) is not None for name in counts):
        account = Certificate(None, None, None, None, True, "", *(certificate[name] for name in counts))
        lines += doubts.account_lines(account)
    return lines


def front_facts(front: FrontResult, pictures: Pictures) -> dict[str, Any]:
    """What a front has beside its points."""
    history = history_figure(front)
    kinds = list(front.points[0].design.hardware.parts) if front.points else []
    if history is not None:
        pictures.drawn[HISTORY["id"]] = slim(history)
    return {
        "history": HISTORY if history is not None else None,
        "cards": front_cards(front),
        "heads": METHOD_HEADS, "methods": method_rows(front),
        "paper_step": -(-len(front.points) // MOST_ON_PAPER),
        "kinds": kinds, "peers": bool(front.peers), "three": len(front.objectives) == 3,
    }  # fmt: skip


def status_words(result: Result | FrontResult) -> tuple[str, str]:
    """Status and the colour that it is shown in."""
    mark = {
        "optimal": "good",
        "feasible": "good",
        "complete": "good",
        "stopped": "warn",
        "interrupted": "warn",
    }
    text, kind = formats.one_line(result.status, 30), mark.get(result.status, "bad")
    if isinstance(result, Result) and result.confidence is not None:
        known = result.confidence
        text, kind = f"holds in {percent(known.held)}", "good" if known.enough else "bad"
    elif result.status == "optimal":
        text = "best of the catalogue"
    if kind == "good" and isinstance(result, Result) and (practice_sentences(result) or noise_clause(result)):
        kind = "warn"
    return text, kind


def mission_text(result: Result | FrontResult) -> str:
    """The mission as the user wrote it, or as it was understood."""
    text = (result.mission_file or {}).get("text")
    if text:
        return formats.printable(str(text))
    import yaml

    return str(yaml.safe_dump(plain(result.mission), sort_keys=False, allow_unicode=True))

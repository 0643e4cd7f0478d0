"""The page of a result: complete, well built, escaped, legible, and without a tie to any network."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from html.parser import HTMLParser
from itertools import pairwise
from typing import Any

import pytest

from uwopt.deadline import Deadline
from uwopt.report.page import style as page_style
from uwopt.report.page.front import goal_texts
from uwopt.report.page.html_file import json_for_script
from uwopt.report.page.page import Pictures, common_width_mm, design_parts, report_html
from uwopt.report.page.sections import alternatives, bar, cards, web_link
from uwopt.report.page.svg import clean_svg
from uwopt.report.pictures import design_pictures
from uwopt.report.pictures.design_pictures import Picture
from uwopt.results.design import SettableCheck
from uwopt.solvers.beside import cores

Make = Callable[..., Any]
VOID = {"meta", "link", "img", "br", "hr", "input", "rect", "circle", "line", "path"}
HOSTILE = (
    "<script>alert(1)</script>", '"><img src=x onerror=alert(2)>', "</script><script>alert(3)</script>",
    "<!--", "</style>", "{{ 7*7 }}", "\u2028", "javascript:alert(4)",
)  # fmt: skip


@dataclass
class Element:
    """One element with what is in it."""

    tag: str
    attributes: dict[str, str]
    inside: list[Element] = field(default_factory=list)
    text: str = ""


class Tree(HTMLParser):
    """Elements in their order; fails where tags do not close."""

    def __init__(self, page: str):
        super().__init__()
        self.all: list[Element] = []
        self.open: list[Element] = []
        self.feed(page)
        self.close()
        assert self.open == [], [e.tag for e in self.open]

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        element = Element(tag, {name: value or "" for name, value in attrs})
        self.all.append(element)
        for outer in self.open:
            outer.inside.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_startendtag(self, tag: str, attrs: Any) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open and self.open[-1].tag == tag, (tag, [e.tag for e in self.open[-3:]])
            self.open.pop()

    def handle_data(self, data: str) -> None:
        shown = self.open if self.open and self.open[-1].tag not in ("script", "style") else self.open[-1:]
        for outer in shown:
            outer.text += data

    def tags(self, *names: str) -> Iterator[Element]:
        return (element for element in self.all if element.tag in names)

    def text(self) -> str:
        return " ".join(next(self.tags("body")).text.split())


KINDS = [
    "solve",
    "evaluate",
    "violated",
    "infeasible",
    "stopped",
    "front3",
    "front2",
    "front1",
    "front0",
    "scenes",
]


@pytest.fixture
def make_kind(
    make_result: Make, make_front: Make, make_design: Make, make_scene: Make, make_margin: Make
) -> Make:
    """A result of each kind that a page is made of."""

    def make(kind: str) -> Any:
        missed = make_scene(
            "reef", margins=[make_margin("max_blur_px", 2.0, 1.0, "<=", "px", satisfied=False)]
        )
        given = {"recommendation": None, "runners_up": [], "generic_alternative": None, "certificate": None}
        why = {
            "requirements": [{"name": "cost", "n_excluded": 12, "n_is_bound": True}],
            "relaxations": [{"name": "cost", "limit": 900.0, "needed": 2140.0, "miss_rel": 1.4}],
            "nearest_miss": make_design(scenes=[missed]),
        }  # fmt: skip
        return {
            "solve": lambda: make_result(alternatives=[
                {"kind": "camera", "maker": "Sony", "hardware": {"camera": "sony-1"}, "values": {"power": 50.0},
                 "outcome": "worse", "by": None, "rule": None, "text": "Sony's best needs 50 W."},
            ]),
            "evaluate": lambda: make_result(command="evaluate", status="feasible", design=make_design(), **given),
            "violated": lambda: make_result(
                command="evaluate", status="violated", design=make_design(scenes=[missed]), **given
            ),
            "infeasible": lambda: make_result(status="infeasible", infeasible=why, **given),
            "stopped": lambda: make_result(status="stopped", **given),
            "front3": make_front,
            "front2": lambda: make_front("power", "cost"),
            "front1": lambda: make_front("cost", "information", points=1),
            "front0": lambda: make_front(points=0, infeasible=why),
            "scenes": lambda: make_result(
                recommendation=make_design(scenes=[make_scene(name) for name in ("reef", "sand", "wreck", "wall")])
            ),
        }[kind]()  # fmt: skip

    return make


def data_of(tree: Tree) -> Any:
    """What the page hands to its script."""
    return json.loads(next(e for e in tree.tags("script") if e.attributes.get("id") == "data").text)


# ---------------------------------------------------------------- build


@pytest.mark.parametrize("kind", KINDS)
def test_page_is_well_built(make_kind: Make, kind: str) -> None:
    page = report_html(make_kind(kind))
    tree = Tree(page)
    assert page.startswith("<!doctype html>") and next(tree.tags("html")).attributes["lang"] == "en"
    levels = [int(e.tag[1]) for e in tree.tags("h1", "h2", "h3", "h4", "h5", "h6")]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(later <= earlier + 1 for earlier, later in pairwise(levels))
    ids = [e.attributes["id"] for e in tree.all if "id" in e.attributes]
    assert len(ids) == len(set(ids))
    for element in tree.all:
        for name in ("aria-labelledby", "aria-controls", "for"):
            assert element.attributes.get(name, ids[0]) in ids
        if element.attributes.get("href", "").startswith("#"):
            assert element.attributes["href"][1:] in ids
    assert {"header", "nav", "main", "footer"} <= {e.tag for e in tree.all}
    assert next(tree.tags("a")).attributes["href"] == "#main"  # the skip link comes first


@pytest.mark.parametrize("kind", KINDS)
def test_everything_has_a_name_for_those_who_cannot_see_it(make_kind: Make, kind: str) -> None:
    tree = Tree(report_html(make_kind(kind)))
    for image in tree.tags("img"):
        assert image.attributes["alt"]
    for table in tree.tags("table"):
        assert [e.text for e in table.inside if e.tag == "caption"] != []
        heads = [e for e in table.inside if e.tag == "th"]
        assert all(e.attributes.get("scope") in ("col", "row") for e in heads)
        assert all(e.text.strip() for e in heads)
    for element in tree.tags("input", "select"):
        outer = [e for e in tree.tags("label") if element in e.inside]
        assert outer or element.attributes.get("aria-label")
    for element in tree.tags("button", "a", "summary"):
        assert element.text.strip() or element.attributes.get("aria-label")
    for svg in tree.tags("svg"):
        assert svg.attributes.get("aria-label") or svg.attributes.get("aria-hidden") == "true"


@pytest.mark.parametrize("kind", KINDS)
def test_page_reaches_for_nothing_outside(make_kind: Make, kind: str) -> None:
    page = report_html(make_kind(kind))
    tree = Tree(page)
    for element in tree.all:
        for name in ("src", "srcset", "data", "poster", "action", "background", "xlink:href"):
            assert not re.match(r"\s*(?:https?:)?//", element.attributes.get(name, ""))
        assert not any(name.startswith("on") for name in element.attributes)
        assert element.tag not in ("link", "iframe", "object", "embed", "base", "form")
    style = "".join(e.text for e in tree.tags("style"))
    assert "url(" not in style and "@import" not in style
    assert len(page.encode()) < 8e6


@pytest.mark.parametrize("kind", ["solve", "front3"])
def test_policy_allows_the_pages_own_scripts_and_no_connection(make_kind: Make, kind: str) -> None:
    tree = Tree(report_html(make_kind(kind)))
    policy = next(e for e in tree.tags("meta") if e.attributes.get("http-equiv")).attributes["content"]
    assert "default-src 'none'" in policy and "unsafe-eval" not in policy
    scripts = policy.partition("script-src")[2].partition(";")[0]
    assert "unsafe-inline" not in scripts
    texts = [e.text for e in tree.tags("script") if "type" not in e.attributes]
    texts += [unpacked(e.text) for e in tree.tags("script") if e.attributes.get("id") == "plots"]
    assert len(texts) == (2 if kind == "front3" else 1)
    for text in texts:
        assert base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() in scripts


def unpacked(text: str) -> str:
    return gzip.decompress(base64.b64decode(text)).decode()


def test_result_can_be_taken_from_the_page(make_result: Make, make_front: Make) -> None:
    for result in (make_result(), make_front()):
        link = next(e for e in Tree(report_html(result)).tags("a") if "download" in e.attributes)
        assert json.loads(unpacked(link.attributes["href"].partition(",")[2])) == json.loads(result.to_json())


# ---------------------------------------------------------------- content


@pytest.mark.parametrize(("kind", "expected"), [
    ("solve", ["Best of the catalogue under these assumptions, proven.", "Least power, 40.50 W at these settings",
               "1 700 to 3 400 USD", "Cost 3 600 to 5 400 USD, of which 1 700 to 3 400 estimated",
               "Bill of materials", "Settings to type in", "12.345 ms", "At its limit: overlap along track",
               "Sony's best needs 50 W.", "Runners-up", "With parts to be made", "Certificate", "adds up",
               "How firm this is", "Second opinions", "not modelled: fish", "Assumptions (2)", "Took 0.430 s"]),
    ("evaluate", ["Every requirement is met.", "The system", "Margins to the requirements"]),
    ("violated", ["1 requirement is missed", "Missed: motion blur."]),
    ("infeasible", ["No system of the catalogue meets every requirement", "Why nothing fits", "cost 2 140 USD",
                    "Nearest miss", "meets all that is asked but cost"]),
    ("stopped", ["Stopped by a limit before a system was found"]),
    ("front3", ["3 choices of hardware are left, in 8 settings", "the cheapest is 1 × Acme camera",
                "with 2 × Acme light", "at 3 400 to 5 100 USD, 40.0 W and information 1.00 Mbit/m²",
                "19.0 W and information 5.90 Mbit/m² for 88 % more cost", "each of 100 combinations is accounted for",
                "reached 99.5 % of the exact", "% of the cost rests on estimated prices",
                "The least cost.", "Parallel coordinates", "Three dimensions", "IGD+", "name: Reef # <b>"]),
    ("front2", ["Parallel coordinates", "Pairs of objectives"]),
    ("front1", ["One system is best in all of cost and information"]),
    ("front0", ["No system of the catalogue meets every requirement", "Each of these changes alone"]),
    ("scenes", ["Margins, Recommendation, wreck", "wall"]),
])  # fmt: skip
def test_page_tells_what_the_result_holds(make_kind: Make, kind: str, expected: list[str]) -> None:
    text = Tree(report_html(make_kind(kind))).text()
    for words in expected:
        assert words in text


def test_a_search_that_was_stopped_says_once_what_would_help(make_kind: Make) -> None:
    text = Tree(report_html(make_kind("stopped"))).text()
    assert text.count("to choose from, and nothing was found so far") <= 1 == text.count("Give it more time")


def test_amounts_in_the_head_of_a_page_do_not_break_between_thousands(make_result: Make) -> None:
    cards = report_html(make_result()).partition('<dl class="cards">')[2].partition("</dl>")[0]
    assert "3\u00a0600 to 5\u00a0400\u00a0USD" in cards


@pytest.mark.parametrize(("kind", "folded"), [("solve", True), ("violated", True), ("front2", False)])
def test_proof_is_folded_on_the_page_of_one_system(make_kind: Make, kind: str, folded: bool) -> None:
    folds = [e for e in Tree(report_html(make_kind(kind))).tags("details") if "fold" in e.attributes.get("class", "")]
    assert len(folds) >= 2
    assert all(("open" not in fold.attributes) == folded for fold in folds)


def test_two_objectives_have_no_third_dimension(make_kind: Make) -> None:
    tree = Tree(report_html(make_kind("front2")))
    assert "Three dimensions" not in next(tree.tags("main")).text
    assert 'id="space"' not in report_html(make_kind("front2"))


def test_points_of_the_table_and_of_the_script_are_the_same(make_front: Make) -> None:
    front = make_front()
    tree = Tree(report_html(front))
    table = next(e for e in tree.tags("table") if e.attributes.get("id") == "points")
    rows = [e for e in table.inside if "data-index" in e.attributes]
    data = data_of(tree)["front"]
    assert [point["id"] for point in data["points"]] == [point.id for point in front.points]
    for row, point in zip(rows, data["points"], strict=True):
        assert all(data["texts"][number] in row.text for number in point["shown"])
    per = (1.0, 1.0, 1e6)  # information is read in Mbit/m²
    for shown, point in zip(data["points"], front.points, strict=True):
        assert shown["values"][:3] == [v / p for v, p in zip(point.values.values(), per, strict=True)]
    assert [o["unit"] for o in data["objectives"]] == ["W", "USD", "Mbit/m²"]


def test_picks_of_one_point_are_shown_once(make_front: Make) -> None:
    front = make_front(points=1)
    heads = [e.text for e in Tree(report_html(front)).tags("h3", "h4")]
    assert heads.count("Settings to type in") == 1
    assert "Cheapest, least power: point p1" in heads


def test_cards_say_where_their_figures_are(make_result: Make) -> None:
    best = make_result().best
    best.scenes[0].figures.update(gsd_mm=0.86, snr_db=30.0, frame_rate_hz=1.0)
    notes = {card.title: card.note for card in cards(best)}
    assert notes["Pixel on the floor"] == "at the nominal altitude" and notes["Frame rate"] == ""
    assert notes["Signal to noise"] == "mean over the frame, at the nominal altitude"


def test_a_pick_has_one_price_and_one_power(make_front: Make) -> None:
    """The table had 3 459 USD beside a card of 2 000 to 7 000 USD, and 75.84 W, exact, beside 75.9 W, as set."""
    (pick,) = design_parts(make_front(points=1), Pictures(), Deadline.after(-1.0))
    told = {card.title: card.value for card in pick.cards}
    assert pick.goals[:2] == [told["Power"], told["Cost"]] and " to " in pick.goals[1]
    front = make_front(points=1)
    unset = replace(front.points[0].design, rounded=SettableCheck(False, None, ["min_snr"]))
    assert goal_texts(front, replace(front.points[0], design=unset)) == [f"{text} (exact)" for text in pick.goals]
    assert "all is told at the settings to type in" in Tree(report_html(make_front(points=1))).text()


def test_parts_are_shortened_as_long_as_they_stay_apart() -> None:
    from uwopt.report.page.front import short_id

    others = ["blue-robotics-3-in-acrylic-end-cap-2026", "blue-robotics-penetrator"]
    assert short_id("blue-robotics-4-in-acrylic-end-cap-2026", others) == "blue-robotics-4…"
    lamps = ["generic-pulsed-flood-30000lm (to be made)"]
    assert short_id("generic-pulsed-flood-15000lm (to be made)", lamps) == "generic-pulsed-flood-15000lm…"
    assert short_id("sony-1", []) == "sony-1"


def test_makers_of_one_reason_stand_in_one_row_after_those_with_a_chance(make_result: Make) -> None:
    def maker(name: str, outcome: str, text: str, **hardware: str) -> dict[str, Any]:
        values = {"power": 50.0} if hardware else {}
        return {"kind": "camera", "maker": name, "hardware": hardware or None, "values": values, "outcome": outcome,
                "by": None, "rule": None, "text": text}  # fmt: skip

    kept_out = [maker(name, "not allowed", "not among flir, basler") for name in ("Lucid", "IDS")]
    items = [*kept_out, maker("Old", "not allowed", "no longer sold"), maker("Sony", "worse", "50 W", camera="s-1"),
             maker("Dim", "infeasible", "too little light")]  # fmt: skip
    heads, (tried, rest) = alternatives(make_result(alternatives=items))
    assert heads == ["power"]
    assert [(row.makers, row.mark) for row in tried[1]] == [("Sony", "warn"), ("Dim", "bad")]
    assert [(row.makers, row.kind, row.mark) for row in rest[1]] == [
        ("Lucid, IDS", "cameras", ""),
        ("Old", "camera", ""),
    ]


def test_picks_of_a_front_show_the_same_width_of_floor(make_front: Make) -> None:
    front = make_front()  # pixels of 1.00 mm to 0.93 mm
    assert common_width_mm([point.design for point in front.points]) == 160.0
    assert common_width_mm([]) is None


def test_missing_pictures_leave_a_note(make_result: Make) -> None:
    # the parts of the result made by hand are in no catalogue, so the model cannot draw them
    assert "Pictures are missing." in Tree(report_html(make_result())).text()


@pytest.mark.parametrize("count", [1, 2])
def test_pictures_of_picks_stand_with_their_own_design_however_many_cores_draw(
    count: int, make_front: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    def drawn(mission: Any, design: Any, **inputs: Any) -> list[Picture]:
        inputs["deadline"].left_out.append("what is dear")
        costs = f"costs {design.totals['cost']['value']:.0f}"
        return [Picture("one", "drawing", costs, costs, costs, "svg", "<svg/>")]

    monkeypatch.setattr(design_pictures, "design_pictures", drawn)
    late, pictures = Deadline(), Pictures()
    with cores(count):
        parts = list(design_parts(make_front(), pictures, late))
    assert [[p["title"] for p in part.pictures] for part in parts] == [["costs 4000"], ["costs 7500"]]
    assert [p["id"] for p in pictures.shown] == ["d0-one", "d1-one"]
    assert late.left_out == ["what is dear"] * 2
    assert [note.partition(": ")[0] for note in pictures.missing] == [part.name for part in parts]


@pytest.mark.parametrize("kind", ["result", "front"])
def test_a_page_without_time_for_pictures_says_so_and_keeps_the_rest(kind, make_result: Make, make_front: Make) -> None:
    made = make_result() if kind == "result" else make_front()
    late = report_html(made, Deadline(end_s=0.0))
    assert "Pictures are missing." in late
    assert "no time was left for drawings, simulated pictures" in late
    assert "no time was left" not in report_html(made)


@pytest.mark.parametrize(("sense", "value", "limit", "room"), [
    ("<=", 0.5, 1.0, 0.5), ("<=", 1.5, 1.0, -0.5), (">=", 3.0, 1.0, 2.0), (">=", 0.25, 1.0, -0.75),
    ("==", 0.3, 0.3, None), (">=", 1.0, 0.0, None),
])  # fmt: skip
def test_room_is_the_share_of_the_limit_that_is_left(
    make_margin: Make, sense: str, value: float, limit: float, room: float | None
) -> None:
    made = bar(make_margin("overlap", value, limit, sense, "", satisfied=(room or 0) >= 0), {})
    assert made.room == (None if room is None else pytest.approx(room))
    assert made.start >= 0 and made.start + made.width <= 100.01


# ---------------------------------------------------------------- hostile texts


def poisoned(value: Any, poison: str) -> Any:
    """A result's plain values with every text that files may hold replaced."""
    keep = {"schema", "command", "status", "sense", "requirement", "rule", "outcome", "kind", "currency", "unit",
            "direction", "id", "point", "curve", "method", "orientation", "objective", "price_status"}  # fmt: skip
    if isinstance(value, dict):
        return {k: v if k in keep and isinstance(v, str) else poisoned(v, poison) for k, v in value.items()}
    if isinstance(value, list):
        return [poisoned(item, poison) for item in value]
    return poison if isinstance(value, str) else value


@pytest.mark.parametrize("poison", HOSTILE)
@pytest.mark.parametrize("kind", ["solve", "infeasible", "front3"])
def test_texts_of_files_never_become_markup(make_kind: Make, kind: str, poison: str) -> None:
    clean = make_kind(kind)
    data = poisoned(json.loads(clean.to_json()), poison)
    if kind == "front3":  # names of objectives are keys elsewhere
        data["objectives"] = json.loads(clean.to_json())["objectives"]
    page = report_html(type(clean).from_dict(data))
    tree, normal = Tree(page), Tree(report_html(clean))
    assert [e.tag for e in tree.tags("script", "style", "iframe")] == [
        e.tag for e in normal.tags("script", "style", "iframe")
    ]
    assert not any(e.attributes.get("src") == "x" for e in tree.tags("img"))
    assert not any(name.startswith("on") for e in tree.all for name in e.attributes)
    for element in tree.tags("a"):
        assert element.attributes["href"].startswith(("#", "https://", "http://", "data:application/gzip;"))
    data_of(tree)  # still JSON
    assert "49" not in next(tree.tags("h1")).text


def test_json_in_the_page_cannot_end_its_block() -> None:
    text = json_for_script({"a": "</script><!--&\u2028\u2029"})
    assert not set("<>&\u2028\u2029") & set(text)
    assert json.loads(text) == {"a": "</script><!--&\u2028\u2029"}


@pytest.mark.parametrize(("source", "link"), [
    ("https://shop.example/a?b=1&c=2", "https://shop.example/a?b=1&c=2"),
    ("http://shop.example", "http://shop.example"),
    ("www.shop.example/part", "https://www.shop.example/part"),
    ("shop.example/part", "https://shop.example/part"),
    ("javascript:alert(1)", ""),
    ("JavaScript://shop.example/%0aalert(1)", ""),
    ("data:text/html,x", ""),
    ("file:///etc/passwd", ""),
    ("https://user@shop.example/", ""),
    ("https://shop.example/a b", ""),
    ('https://shop.example/"onclick="x', ""),
    ("https://", ""),
    ("//shop.example/x", ""),
    ("quote of 2026-01-05", ""),
    ("mission", ""),
    ("", ""),
])  # fmt: skip
def test_only_pages_of_the_web_become_links(source: str, link: str) -> None:
    assert web_link(source) == link


def test_links_tell_nobody_where_they_come_from(make_result: Make) -> None:
    result = make_result()
    result.best.bom[0] = replace(result.best.bom[0], source="www.shop.example/cam")
    link = next(e for e in Tree(report_html(result)).tags("a") if e.attributes["href"].startswith("http"))
    assert link.attributes["href"] == "https://www.shop.example/cam"
    assert "noopener" in link.attributes["rel"]


def test_drawings_pass_with_shapes_only() -> None:
    drawn = clean_svg(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9" onload="x()"><script>x()</script>'
        '<style>rect { fill: red } @import "http://x"</style><foreignObject><p>x</p></foreignObject>'
        '<g id="a" onclick="x()"><use href="#a"/><use href="http://x/#a"/><rect fill="url(#a)" width="3"/></g>'
        '<a href="javascript:x()"><text>t</text></a><text>A &lt;b&gt;</text></svg>', "d0", "a rig",
    )  # fmt: skip
    for sign in ("onload", "onclick", "script", "foreignObject", "http://x", "@import", "<a "):
        assert sign not in drawn
    assert 'id="d0-a"' in drawn and 'href="#d0-a"' in drawn and 'fill="url(#d0-a)"' in drawn
    assert "A &lt;b&gt;" in drawn and 'aria-label="a rig"' in drawn
    assert clean_svg("<svg><g></svg>", "d0", "x") == "" and clean_svg("<p>x</p>", "d0", "x") == ""


# ---------------------------------------------------------------- colours

#: Text on a ground: each pair must have a contrast of 4.5 or more in both lists.
TEXT_ON: tuple[tuple[str, str], ...] = (
    *((text, ground) for text in ("ink", "muted", "accent") for ground in ("bg", "panel", "soft")),
    *((text, ground) for text in ("good", "warn", "bad") for ground in ("bg", "panel", "soft")),
    ("on-accent", "accent"), ("accent", "accent-soft"), ("ink", "accent-soft"), ("good", "good-soft"),
    ("warn", "warn-soft"), ("bad", "bad-soft"),
)  # fmt: skip


def contrast(first: str, second: str) -> float:
    """Ratio of luminances of two colours, 1 to 21, as WCAG 2.2 defines it."""
    light, dark = sorted((luminance(first), luminance(second)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def luminance(colour: str) -> float:
    """Relative luminance of an sRGB colour `#rrggbb`."""
    levels = [int(colour[start : start + 2], 16) / 255 for start in (1, 3, 5)]
    red, green, blue = (v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in levels)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def test_contrast_is_that_of_the_standard() -> None:
    # WCAG 2.2: black on white is 21; #767676 on white is the lightest grey with 4.5 (4.54)
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#767676", "#ffffff") == pytest.approx(4.54, abs=0.005)


@pytest.mark.parametrize("colours", [page_style.LIGHT, page_style.DARK], ids=["light", "dark"])
@pytest.mark.parametrize(("text", "ground"), TEXT_ON, ids="-on-".join)
def test_text_stands_out_from_its_ground(colours: dict[str, str], text: str, ground: str) -> None:
    assert contrast(colours[text], colours[ground]) >= 4.5


@pytest.mark.parametrize(("scale", "colours"), [
    (page_style.SCALE_LIGHT, page_style.LIGHT), (page_style.SCALE_DARK, page_style.DARK),
], ids=["light", "dark"])  # fmt: skip
def test_points_stand_out_from_their_ground_at_both_ends_of_the_scale(
    scale: list[str], colours: dict[str, str]
) -> None:
    # WCAG 2.2, 1.4.11: graphics need 3
    assert all(contrast(colour, colours["bg"]) >= 3.0 for colour in scale)


def test_both_themes_name_the_same_colours_and_the_page_uses_no_other(make_result: Make) -> None:
    assert list(page_style.LIGHT) == list(page_style.DARK)
    style = "".join(e.text for e in Tree(report_html(make_result())).tags("style"))
    assert set(re.findall(r"var\(--([\w-]+)\)", style)) <= set(page_style.LIGHT)


def test_page_is_the_same_each_time(make_result: Make, make_front: Make) -> None:
    for result in (make_result(), make_front()):
        assert report_html(result) == report_html(replace(result))


def test_the_bill_of_a_page_tells_purpose_note_and_dates(make_result: Make) -> None:
    result = make_result()
    result.best.bom[0] = replace(
        result.best.bom[0], note="Rated for two weeks.", purpose="subsea camera", availability="unknown",
        checked="2026-10-05",
    )  # fmt: skip
    bill = Tree(report_html(result)).text().partition("Bill of materials")[2]
    for said in ("subsea camera", "Rated for two weeks; whether it is still sold is not known", "quoted, 2026-08-14",
                 "read 2026-10-05"):  # fmt: skip
        assert said in bill

"""What changes on the page, as elements: figures and margins of all systems, their plots, faults."""

from __future__ import annotations

import base64
from typing import Any

from uwopt.api.comparing import apart
from uwopt.errors import FaultsError, UwoptError
from uwopt.explore.controls import CONTROLS
from uwopt.explore.dash_door import dcc, html
from uwopt.explore.outcome import SHOWN, KeptResults, shown_figures, shown_margins, shown_rig
from uwopt.explore.state import State
from uwopt.report.notebook import goal_and_value
from uwopt.report.pictures.design_pictures import Picture
from uwopt.results.result import Result

PLOT_LAYOUT = {"font": {"color": "#16212b"}, "margin": {"l": 64, "r": 16, "t": 40, "b": 52}}


def results(outcomes: KeptResults, state: State) -> list[Result | UwoptError]:
    """What each system does, or what is wrong with it."""
    made: list[Result | UwoptError] = []
    for index in range(len(state["systems"])):
        try:
            made.append(outcomes.result(state, index))
        except UwoptError as fault:
            made.append(fault)
    return made


def system_names(state: State) -> list[str]:
    """Names of the systems, by number where they have none, told apart."""
    return apart([str(system.get("name") or f"system {n}") for n, system in enumerate(state["systems"], 1)])


def fault_texts(fault: UwoptError) -> list[str]:
    """Each fault alone."""
    return fault.faults if isinstance(fault, FaultsError) else [str(fault)]


def fault_list(state: State, found: list[Result | UwoptError]) -> Any:
    """What is wrong, and where; nothing where all is well."""
    items = [
        html.Li(f"{name}: {text}" if len(found) > 1 else text)
        for name, one in zip(system_names(state), found, strict=True)
        if isinstance(one, UwoptError)
        for text in fault_texts(one)
    ]
    if not items:
        return []
    return [html.P("These values do not work; the figures wait until they do."), html.Ul(items)]


def marked(state: State, found: list[Result | UwoptError]) -> list[list[str]]:
    """Controls that a fault of the shown system names, with its text."""
    one = found[state["shown"]]
    if not isinstance(one, UwoptError):
        return []
    told = []
    for control in CONTROLS:
        path = ".".join(filter(None, (control.section.replace("scene", ""), control.key)))
        texts = [text for text in fault_texts(one) if f"{path} " in text.split(" = ")[0] + " "]
        if texts:
            told.append([control.id, texts[0]])
    return told


def figure_table(state: State, found: list[Result | UwoptError]) -> Any:
    """Figures of all systems side by side."""
    columns = [shown_figures(one, state["scene"]) if isinstance(one, Result) else {} for one in found]
    head = html.Tr([html.Th("Figure", scope="col"), *(html.Th(name, scope="col") for name in system_names(state))])
    rows = [
        html.Tr(
            [
                html.Th(label, scope="row"),
                *(
                    html.Td(column.get(name, "not known"), **{"data-figure": f"{n}-{name}"})
                    for n, column in enumerate(columns)
                ),
            ]
        )
        for name, label in SHOWN.items()
    ]
    goals = [goal_and_value(one) if isinstance(one, Result) else "not known" for one in found]
    rows.append(html.Tr([html.Th("What is to be best", scope="row"), *map(html.Td, goals)]))
    return html.Table([html.Thead(head), html.Tbody(rows)])


def margin_table(state: State, found: list[Result | UwoptError]) -> Any:
    """Requirements of all systems below each other, met or missed as colour and word."""
    rows = []
    for name, one in zip(system_names(state), found, strict=True):
        if not isinstance(one, Result):
            continue
        missed = sum(not margin[4] for margin in shown_margins(one, state["scene"]))
        verdict = "every requirement is met" if not missed else f"{missed} missed"
        mark = "is-bad" if missed else "is-good"
        rows.append(html.Tr(html.Th(f"{name}: {verdict}", colSpan="5", scope="colgroup", className=mark)))
        for requirement, value, limit, left, met in shown_margins(one, state["scene"]):
            rows.append(html.Tr([
                html.Th(requirement, scope="row"), html.Td(value), html.Td(limit), html.Td(left),
                html.Td("met" if met else "missed", className="is-good" if met else "is-bad"),
            ]))  # fmt: skip
    head = html.Tr([html.Th(text, scope="col") for text in ("Requirement", "Value", "Limit", "In hand", "Verdict")])
    return html.Table([html.Thead(head), html.Tbody(rows)])


def rig(state: State, found: list[Result | UwoptError]) -> dict[str, Any]:
    """What the drawing of the lamps is made of; nothing while the shown system cannot be evaluated."""
    one = found[state["shown"]]
    return shown_rig(one, state["scene"]) if isinstance(one, Result) else {}


# ---------------------------------------------------------------- plots


def plot_list(outcomes: KeptResults, state: State, name: str) -> list[Any]:
    """The chosen plot of every system that can be evaluated."""
    made: list[Any] = []
    for index, (title, one) in enumerate(zip(system_names(state), results(outcomes, state), strict=True)):
        if isinstance(one, UwoptError):
            continue
        try:
            pictures = pictures_of(one, name, state["scene"])
        except UwoptError as fault:
            made.append(html.P(f"{title}: {outcomes.plain(str(fault))}"))
            continue
        many = len(state["systems"]) > 1
        made += [figure(picture, title if many else "", f"plot-{index}-{picture.id}") for picture in pictures]
    return made


def pictures_of(result: Result, name: str, scene: int) -> list[Picture]:
    """Pictures of one plot of the page: those of `uwopt plot`, the rig and the simulated picture."""
    from uwopt.explore.plotting import drawn_by, result_pictures
    from uwopt.report.pictures import curves, design_pictures

    if name == "rig":
        return drawn_by(
            result, scene, lambda made, at: design_pictures.drawings(
                curves.rig_measures(made, at), on_axis=made.model.problem.paper
            )
        )  # fmt: skip
    if name == "picture":
        return drawn_by(result, scene, design_pictures.simulated)
    return result_pictures(result, name, scene)


def figure(picture: Picture, title: str, name: str) -> Any:
    """A picture with its caption."""
    head = f"{title}: {picture.title}" if title else picture.title
    if picture.kind == "plotly":
        content = {"data": picture.content["data"], "layout": {**picture.content["layout"], **PLOT_LAYOUT}}
        graph = dcc.Graph(id=name, figure=content, config={"responsive": True, "displayModeBar": False})
        box = html.Div(graph, role="img", **{"aria-label": picture.alt})
    else:
        source = picture.content
        if picture.kind == "svg":
            source = "data:image/svg+xml;base64," + base64.b64encode(picture.content.encode()).decode()
        box = html.Img(src=source, alt=picture.alt)
    return html.Figure([box, html.Figcaption([html.Strong(head + ". "), picture.caption])])

"""Results in a notebook: a line, a card of HTML, plots as plotly figures."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING, Any

from uwopt.errors import RangeError
from uwopt.results.design import Design, lamps_in_words
from uwopt.results.front import FrontResult
from uwopt.results.result import Result

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from uwopt.evaluation.recompute import Replay
    from uwopt.report.pictures.design_pictures import Picture

AnyResult = Result | FrontResult
FRONT = "front"


def short_text(result: AnyResult) -> str:
    """`<Result solve 'Reef': optimal, power 3.05 W, camera + lens + port + 2 × light>`."""
    from uwopt.report.text import formats
    from uwopt.report.text.verdict import axis_name

    name = formats.one_line(result.mission.get("name") or "mission", 40)
    if isinstance(result, FrontResult):
        axes = ", ".join(axis_name(one) for one in result.objectives)
        return f"<FrontResult {name!r}: {result.status}, {len(result.points)} points of {axes}>"
    head = f"<Result {result.command} {name!r}: {result.status}"
    if result.best is None:
        return head + ">"
    return f"{head}, {goal_and_value(result)}, {parts_text(result.best)}>"


def goal_and_value(result: Result) -> str:
    """Name and value of the objective, with its unit."""
    from uwopt.report.text import formats

    goal = result.objective
    return f"{formats.one_line(goal.name)} {formats.quantity(goal.value, goal.unit)}"


def parts_text(design: Design) -> str:
    """Ids of the parts, with the number of lights."""
    hardware = design.hardware
    *ids, light = (part.id for part in hardware.named.values())
    return " + ".join([*ids, lamps_in_words(hardware.light_count, light, "×")])


# ---------------------------------------------------------------- HTML


def html(result: AnyResult) -> str:
    """Verdict, bill and margins; of a front its verdict and picks. All text is escaped."""
    from uwopt.report.text.verdict import verdict

    first, second = verdict(result)
    parts = [f"<p><b>{escape(first)}</b><br>{escape(second)}</p>"]
    if isinstance(result, FrontResult):
        parts.append(
            table("Picks", ("pick", "point", *(one.name for one in result.objectives)), pick_cells(result))
        )
    elif result.best is not None:
        parts.append(
            table("Bill of materials", ("", "part", "each", "to pay", "price"), bill_cells(result.best))
        )
        for scene in result.best.as_set.scenes:
            title = "Margins" if len(result.best.scenes) == 1 else f"Margins, {scene.name}"
            heads = ("requirement", "value", "limit", "margin", "")
            parts.append(table(title, heads, margin_cells(result.best, scene.margins)))
    return "<div>" + "".join(parts) + "</div>"


def table(title: str, heads: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """One table with its title; nothing where there are no rows."""
    if not rows:
        return ""
    head = "".join(f"<th>{escape(text)}</th>" for text in heads)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><caption>{escape(title)}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def bill_cells(design: Design) -> list[tuple[str, ...]]:
    """Number, part, price, what is to pay and how that is known."""
    from uwopt.report.text.tables import bom_line

    lines = [bom_line(row) for row in design.bom]
    return [(line.number, line.id, line.each, line.due, line.known) for line in lines]


def margin_cells(design: Design, margins: list[Any]) -> list[tuple[str, ...]]:
    """Requirement, value, limit, what is left, and whether it is missed or binds."""
    from uwopt.report.text.tables import has_no_limit, kinds_by_id, margin_state, margin_texts

    kinds, cost = kinds_by_id(design), design.totals.cost
    return [
        (*margin_texts(margin, kinds, cost)[:4], {"met": ""}.get(margin_state(margin), margin_state(margin)))
        for margin in margins
        if not has_no_limit(margin)
    ]


def pick_cells(front: FrontResult) -> list[tuple[str, ...]]:
    """Each pick with its values."""
    from uwopt.report.text.verdict import value_texts

    return [(pick.name, pick.point, *value_texts(front, front.point(pick.point))) for pick in front.picks]


# ---------------------------------------------------------------- plots


def plot_makers() -> dict[str, Callable[[Replay, int], list[Picture]]]:
    """What draws each plot of a design; the others of its group come with it."""
    from uwopt.report.pictures import curves, design_pictures, maps

    def light(made: Replay, scene: int) -> list[Picture]:
        return [design_pictures.light_picture(curves.spectrum_way(made, scene))]

    def sharp(made: Replay, scene: int) -> list[Picture]:
        return design_pictures.sharp_pictures(curves.depth_of_field(made, scene))

    def operation(made: Replay, scene: int) -> list[Picture]:
        return design_pictures.operation_pictures(curves.operation_curves(made, scene))

    def image(made: Replay, scene: int) -> list[Picture]:
        return design_pictures.map_pictures(maps.image_map(made, scene), maps.floor_map(made, scene))

    return {
        "spectrum": light, "dof-aperture": sharp, "dof-focus": sharp, "rate": operation, "exposure": operation,
        "illuminance": image, "snr": image,
    }  # fmt: skip


def figure_names(result: AnyResult) -> tuple[str, ...]:
    """Plots that a result has."""
    of_designs = tuple(plot_makers())
    if isinstance(result, FrontResult):
        return (FRONT, *of_designs) if result.points else ()
    return of_designs if result.best is not None else ()


def figure(result: AnyResult, name: str, *, scene: int = 0, point: str | None = None) -> go.Figure:
    """A plot of the report as a plotly figure."""
    import plotly.graph_objects as go

    names = figure_names(result)
    if name not in names:
        there = ", ".join(names) or "none, for there is no design"
        raise RangeError(f"there is no figure {name!r}; there are {there}")
    if isinstance(result, FrontResult) and name == FRONT:
        return go.Figure(front_plot(result))
    design = design_of(result, point)
    from uwopt.evaluation.recompute import replayed

    made = replayed(result, design, scene)
    picture = next((one for one in plot_makers()[name](made, scene) if one.id == name), None)
    if picture is None:
        why = f"physics {result.physics.name} knows no field, or no lamp shines"
        raise RangeError(f"there is no figure {name!r}: {why}")
    return go.Figure(picture.content).update_layout(title=picture.title, template="plotly_white", margin_t=64)


def design_of(result: AnyResult, point: str | None) -> Design:
    """The design that is drawn; a RangeError names the points of a front."""
    if isinstance(result, Result):
        assert result.best is not None  # or it would have no figure
        return result.best.as_set
    if point is None:
        return result.points[0].design.as_set
    known = [one.id for one in result.points] + [pick.name for pick in result.picks]
    if point not in known:
        raise RangeError(f"there is no point {point!r}; there are {', '.join(known[:12])} ...")
    return result.point(point).design.as_set


def front_plot(front: FrontResult) -> dict[str, Any]:
    """Points over the first two objectives, the third as colour; hardware where the pointer rests."""
    from uwopt.report.text.verdict import axis_name

    names = [axis_name(one) + (f" [{one.unit}]" if one.unit else "") for one in front.objectives]
    columns = [[point.values[one.name] for point in front.points] for one in front.objectives]
    marker: dict[str, Any] = {"size": 9}
    if len(columns) > 2:
        marker |= {
            "color": columns[2],
            "colorscale": "Viridis",
            "showscale": True,
            "colorbar": {"title": names[2]},
        }
    trace = {
        "type": "scatter", "mode": "markers", "x": columns[0], "y": columns[1], "marker": marker,
        "text": [f"{escape(point.id)}: {escape(parts_text(point.design))}" for point in front.points],
    }  # fmt: skip
    axes = {"xaxis": {"title": {"text": names[0]}}, "yaxis": {"title": {"text": names[1]}}}
    return {"data": [trace], "layout": {**axes, "template": "plotly_white", "title": {"text": "Trade-off"}}}

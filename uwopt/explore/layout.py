"""The page's elements: controls in groups, figures, margins, plots, and what leads to a decision.

Choices are native selects and sliders native ranges, which keyboards and screen readers know; `explore.js` hands what
is chosen to Dash.
"""

from __future__ import annotations

import json
import math
from typing import Any

from uwopt.explore.controls import CONTROLS, GROUPS, OWN, PARTS, Control
from uwopt.explore.dash_door import dcc, html
from uwopt.explore.jobs import JOBS, PINS
from uwopt.explore.outcome import OF_THE_PAGE, SHOWN
from uwopt.explore.state import MOST_FILE_BYTES, MOST_SYSTEMS, State, shown_system, text_of, yaml_text
from uwopt.forward.assembly import load_catalog

PLOTS = {
    "dof": "Depth of field", "framerate": "Frame rate", "exposure": "Exposure", "spectrum": "Spectrum, lamp to sensor",
    "attenuation": "Attenuation of the water", "sensor": "Sensor, lens and port", "light": "Light over the floor",
    "rig": "The rig, drawn to scale", "picture": "Simulated picture",
}  # fmt: skip
OPEN_GROUPS = ("Light", "Lens", "Camera", "Port", "Operation", "Settings")
STEPS = 400  # of a slider


def page(state: State, host: str) -> Any:
    """The whole page with a state's values in its controls."""
    return html.Div([
        html.A("Skip to the figures", href="#figures", className="skip"),
        dcc.Store(id="state", data=state), dcc.Store(id="kick", data=0), dcc.Store(id="address"),
        dcc.Store(id="opened"), dcc.Store(id="lamps"),
        dcc.Store(id="marked", data=[]), dcc.Store(id="extra", data={}), dcc.Store(id="job"), dcc.Store(id="sync"),
        dcc.Interval(id="clock", interval=500, disabled=True),
        *[dcc.Download(id=f"get-{name}") for name in ("mission", "system", "report", "made")],
        html.Header([
            html.H1("Explore"), html.P(id="name", className="dim"),
            html.P(f"Served from {host}. This tab alone holds what you set; its address brings it back.",
                   className="dim"),
        ], className="top"),
        html.Div([
            html.Section([html.H2("Controls"), system_bar(), *[group(name, state) for name in GROUPS]],
                         className="controls", **{"aria-label": "Controls"}),
            html.Main([outputs(), plots(), lamps(), decide(), figure_map(), files(state), work()], id="main"),
        ], className="layout"),
    ])  # fmt: skip


# ---------------------------------------------------------------- controls


def system_bar() -> Any:
    """Which system the controls act on, and in which scene."""
    return html.Div([
        field("Controls act on", select("c-shown", [], "0")),
        field("Scene", select("c-scene", [], "0"), id="scene-field"),
        html.Div([button("add", "Add a copy beside it"), button("remove", "Remove it")], className="buttons"),
        html.P(f"Two to {MOST_SYSTEMS} systems stand side by side.", className="dim"),
    ], className="bar")  # fmt: skip


def group(name: str, state: State) -> Any:
    """One group of controls, folded where it is seldom wanted."""
    inside = [control_field(one, state) for one in CONTROLS if one.group == name]
    return html.Details([html.Summary(name), html.Div(inside, className="fields")], open=name in OPEN_GROUPS)


def control_field(control: Control, state: State) -> Any:
    """A control with its label, unit and slider."""
    label = control.label + (f" [{control.unit}]" if control.unit else "")
    value = text_of(state, control)
    own_of = control.section if control.section in PARTS else ""
    box: Any
    if control.choices or control.is_part:
        box = select(f"c-{control.id}", part_options(control.key) if control.is_part else [*control.choices], value)
    else:
        text = dcc.Input(id=f"c-{control.id}", type="text", inputMode="decimal", value=value, debounce=0.15)
        box = html.Div([text, slider(control, value)] if control.low is not None else [text], className="pair")
    return html.Div(
        [field(label, box, title=control.meaning), html.P(id=f"f-{control.id}", className="fault", hidden=True)],
        id=f"w-{control.id}", hidden=bool(own_of) and not is_own(state, own_of),
        **({"data-log": "yes"} if control.log else {}),
    )  # fmt: skip


def is_own(state: State, kind: str) -> bool:
    """Whether a part states its own numbers."""
    return isinstance(state["systems"][state["shown"]].get(kind), dict)


def slider(control: Control, value: str) -> Any:
    """A native range beside the number; of its logarithm where that is how one turns it."""
    low, high = ends(control)
    try:
        at = position(control, float(value))
    except ValueError:
        at = low
    return dcc.Input(id=f"r-{control.id}", type="range", min=low, max=high, step=step(control), value=at)


def ends(control: Control) -> tuple[float, float]:
    """Ends of a slider, as positions."""
    assert control.low is not None and control.high is not None  # it has a slider
    low, high = control.low, control.high
    return (round(math.log10(low), 4), round(math.log10(high), 4)) if control.log else (low, high)


def step(control: Control) -> float:
    """How far a slider goes at once: whole for what is counted."""
    low, high = ends(control)
    if control.key.endswith("_count"):
        return 1
    return float(f"{(high - low) / STEPS:.1g}")


def position(control: Control, value: float) -> float:
    """Where a number stands on its slider."""
    low, high = ends(control)
    if control.log:
        value = math.log10(value) if value > 0 else low
    return min(max(value, low), high)


def part_options(kind: str) -> list[tuple[str, str]]:
    """Parts of the catalogue by id, after own numbers."""
    parts = load_catalog().parts(kind)  # pyrefly: ignore[bad-argument-type]
    named = sorted((" ".join(filter(None, (part.manufacturer, part.model))) or part.id, part.id) for part in parts)
    return [(OWN, OWN), *((part_id, name) for name, part_id in named)]


def select(name: str, options: list[Any], value: str = "") -> Any:
    """A native select, and the hidden input that holds its value for Dash.

    Its options are data that `explore.js` makes elements of: a thousand more components would slow every change.
    """
    pairs = [option if isinstance(option, tuple) else (option, option) for option in options]
    return html.Div([
        html.Select(id=f"s-{name}", **{"data-for": name, "data-options": json.dumps(pairs)}),
        dcc.Input(id=name, type="hidden", value=value),
    ], className="select")  # fmt: skip


def field(label: str, box: Any, **more: Any) -> Any:
    """A labelled box."""
    return html.Label([html.Span(label), box], className="field", **more)


def button(name: str, text: str, **more: Any) -> Any:
    """A button that Dash counts clicks of."""
    return html.Button(text, id=f"do-{name}", type="button", n_clicks=0, **more)


# ---------------------------------------------------------------- what is shown


def outputs() -> Any:
    """Faults, figures and margins."""
    return html.Section([
        html.H2("Figures", id="figures", tabIndex="-1"),
        html.Div(id="faults", role="alert"), html.P(id="told", role="status"),
        html.Div(id="figure-table", className="scroll", tabIndex="0", role="region", **{"aria-label": "Figures"}),
        html.H2("Requirements"),
        html.Div(id="margin-table", className="scroll", tabIndex="0", role="region", **{"aria-label": "Requirements"}),
    ], className="panel")  # fmt: skip


def plots() -> Any:
    """The plot that is chosen, of every system."""
    options: list[Any] = [*PLOTS.items()]
    return html.Section([html.H2("Plots"), field("Plot", select("c-plot", options, "dof")), html.Div(id="plots")],
                        className="panel")  # fmt: skip


def lamps() -> Any:
    """Where lamps stand and how they lean: a drawing to move them on, and numbers beside; `lamps.js` fills both in."""
    return html.Section([
        html.H2("Lamps on the rig"),
        html.P("Drag a lamp, or choose it and move it by the arrow keys, 5 cm at a time, 1 cm with Shift; Page Up and "
               "Page Down lean it outward and inward by 2.5°. Physics paper takes lamps for standing at the camera.",
               className="dim", id="lamps-how"),
        html.Div(id="lamp-drawings", className="drawings"),
        html.Div(id="lamp-numbers", className="scroll", tabIndex="0", role="region",
                 **{"aria-label": "Places of the lamps"}),
    ], className="panel")  # fmt: skip


MAP_FIELDS = {"figure": "snr_db", "across": "altitude_m=1:4:8", "up": "f_number=2:8:7"}


def figure_map() -> Any:
    """Any figure over any two inputs of the mission or the system."""
    def text(name: str, label: str, **more: Any) -> Any:
        return field(label, dcc.Input(id=f"map-{name}", type="text", value=MAP_FIELDS[name], **more))

    return html.Section([
        html.H2("Map"),
        html.P("Any figure of the system over any two inputs of mission or system, each a range from:to:how many, or a "
               "list.", className="dim"),
        html.Datalist([html.Option(value=name) for name in SHOWN if name not in OF_THE_PAGE], id="figure-names"),
        html.Div([text("figure", "Figure", list="figure-names"), text("across", "Across: a key and its values"),
                  text("up", "Up: a key and its values")], className="three"),
        html.Div([button("job-map", JOBS["map"][0])], className="buttons"),
        html.Div(id="map-plot"),
    ], className="panel")  # fmt: skip


def work() -> Any:
    """What runs in the background, at the foot of the window while there is any."""
    return html.Section([
        html.P(id="job-text", role="status"),
        html.Progress(id="job-bar", max="1", value="0", **{"aria-label": "Progress"}),
        html.Div([button("cancel", "Cancel, and keep what is found", disabled=True),
                  button("get-made", "Download the report of this work", disabled=True)], className="buttons"),
    ], className="panel work", **{"aria-label": "Work in the background"})  # fmt: skip


def decide() -> Any:
    """From exploring to deciding: pins, jobs in the background, reports."""
    pins = [html.Label([dcc.Input(id=f"c-pin-{name}", type="hidden", value=""),
                        html.Button(f"Pin {text}", id=f"pin-{name}", type="button", className="pin",
                                    **{"aria-pressed": "false", "data-for": f"c-pin-{name}"})], className="pin-label")
            for name, text in PINS.items()]  # fmt: skip
    jobs = [button(f"job-{name}", text) for name, (text, _) in JOBS.items() if name != "map"]
    return html.Section([
        html.H2("Decide"),
        html.P("Pin what is to stay as it is; the certified search chooses the rest, settings included, and puts what "
               "it recommends beside your system."),
        html.Div(pins, className="buttons"),
        field("What if: a key of the mission and its values",
              dcc.Input(id="vary", type="text", value="speed_m_s=0.5:1.5:3")),
        html.Div(jobs, className="buttons"),
        html.Div(id="job-found"),
    ], className="panel")  # fmt: skip


def files(state: State) -> Any:
    """Files in and out."""
    size = f"up to {MOST_FILE_BYTES // 1_000_000} MB"

    def upload(name: str, text: str) -> Any:
        return dcc.Upload(html.Span(text), id=f"put-{name}", multiple=False, className="upload")

    return html.Section([
        html.H2("Files"),
        html.Div([upload("mission", f"Load a mission file ({size})"), upload("system", f"Load a system file ({size})"),
                  upload("own", f"Load own parts, a camera, water or a spectrum (CSV, {size})")], className="buttons"),
        html.P(id="own-files", className="dim"),
        html.Div([button("get-mission", "Save the mission file"), button("get-system", "Save the system file"),
                  button("get-report", "Save the report of this system")], className="buttons"),
        html.Details([
            html.Summary("The whole mission and system, as files"),
            field("Mission", dcc.Textarea(id="mission-text", value=yaml_text(state["mission"]), rows=18)),
            field("System", dcc.Textarea(id="system-text", value=yaml_text(shown_system(state)), rows=18)),
            html.Div([button("apply", "Take these texts")], className="buttons"),
        ]),
    ], className="panel")  # fmt: skip

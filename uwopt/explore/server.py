"""The server of the page: what a change of a control, a click or a file does.

It holds no state of a tab. Each request brings the tab's state with it and gets the next one back; what is kept is what
results are made from (`KeptResults`) and work in the background, by a name that its tab alone knows.
"""

from __future__ import annotations

import base64
import binascii
import json
from collections.abc import Callable
from typing import Any

from uwopt.errors import MissionError, UwoptError
from uwopt.explore import showing
from uwopt.explore import state as states
from uwopt.explore.controls import CONTROLS, OWN, PARTS
from uwopt.explore.dash_door import Dash, Input, Output, PreventUpdate, State, ctx, html, no_update
from uwopt.explore.jobs import JOBS, OF_SETTINGS, PINNED_JOBS, PINS, Jobs, pinned
from uwopt.explore.layout import MAP_FIELDS, ends, page
from uwopt.explore.outcome import KeptResults
from uwopt.report.page.style import LIGHT, tokens
from uwopt.report.text.formats import printable

MOST_REQUEST_BYTES = 20_000_000
IDS = [one.id for one in CONTROLS]
PART_IDS = [one.id for one in CONTROLS if one.is_part]
SLIDERS = [one for one in CONTROLS if one.low is not None]
CLICKS = ("add", "remove", "apply")
UPLOADS = ("mission", "system", "own")
HEAD = """<!DOCTYPE html>
<html lang="en"><head>{%metas%}<title>{%title%}</title>{%favicon%}{%css%}
<style>:root { color-scheme: light; LIGHT }</style></head>
<body>{%app_entry%}<footer>{%config%}{%scripts%}{%renderer%}</footer></body></html>"""


class Explorer:
    """The page with all that answers it."""

    def __init__(self, opening: states.State, host: str, hosts: frozenset[str] | None):
        """`hosts`: names under which it may be asked for; None for any."""
        self.outcomes, self.jobs, self.hosts = KeptResults(), Jobs(), hosts
        self.opening = opening
        self.app = Dash(
            "uwopt.explore", assets_folder=str(ASSETS), title="uwopt explore", update_title="", serve_locally=True,
            enable_mcp=False, meta_tags=[{"name": "viewport", "content": "width=device-width, initial-scale=1"}],
            index_string=HEAD.replace("LIGHT", tokens(LIGHT)),
        )  # fmt: skip
        self.app.layout = lambda: page(self.opening, host)
        self._callbacks()
        self._guards()
        showing.results(self.outcomes, opening)  # the catalogue is read before the first page asks

    def close(self) -> None:
        """Work is ended, own files are taken away."""
        self.jobs.close()
        self.outcomes.close()

    # ------------------------------------------------------------ what answers what

    def _callbacks(self) -> None:
        on, held = self.app.callback, [State(f"c-{name}", "value") for name in IDS]
        texts = [State(f"c-{name}", "value") if name in PART_IDS else Input(f"c-{name}", "value") for name in IDS]
        moves = [Input(name, "value") for name in ("c-shown", "c-scene", *(f"c-{name}" for name in PART_IDS))]
        clicks = [Input(f"do-{name}", "n_clicks") for name in CLICKS]
        uploads = [Input(f"put-{name}", "contents") for name in UPLOADS]
        on(
            Output("state", "data"), Output("figure-table", "children"), Output("margin-table", "children"),
            Output("faults", "children"), Output("marked", "data"), Output("address", "data"),
            Output("name", "children"), Output("extra", "data"), Output("own-files", "children"),
            *texts, Input("lamps", "data"), Input("kick", "data"), State("state", "data"),
        )(self.changed)  # fmt: skip
        on(
            *(Output(f"c-{name}", "value") for name in IDS), Output("state", "data", allow_duplicate=True),
            Output("kick", "data"), Output("told", "children"), Output("mission-text", "value"),
            Output("system-text", "value"), Input("opened", "data"), *moves, *clicks, *uploads,
            *(State(f"put-{name}", "filename") for name in UPLOADS), State("mission-text", "value"),
            State("system-text", "value"), *held, State("state", "data"), State("kick", "data"),
            prevent_initial_call=True,
        )(self.acted)  # fmt: skip
        on(Output("plots", "children"), Input("state", "data"), Input("c-plot", "value"))(self.plotted)
        for name in ("mission", "system", "report"):
            on(Output(f"get-{name}", "data"), Input(f"do-get-{name}", "n_clicks"), State("state", "data"),
               prevent_initial_call=True)(self._saver(name))  # fmt: skip
        on(
            Output("job", "data"), Output("job-text", "children", allow_duplicate=True), Output("clock", "disabled"),
            *(Input(f"do-job-{name}", "n_clicks") for name in JOBS), State("vary", "value"),
            *(State(f"map-{name}", "value") for name in MAP_FIELDS),
            *(State(f"c-pin-{name}", "value") for name in PINS), State("job", "data"), State("state", "data"),
            prevent_initial_call=True,
        )(self.started)  # fmt: skip
        on(
            *(Output(f"c-{name}", "value", allow_duplicate=True) for name in IDS),
            Output("state", "data", allow_duplicate=True), Output("kick", "data", allow_duplicate=True),
            Output("job-text", "children"), Output("job-bar", "value"),
            Output("clock", "disabled", allow_duplicate=True),
            Output("do-cancel", "disabled"), Output("do-get-made", "disabled"), Output("job-found", "children"),
            Output("map-plot", "children"),
            Input("clock", "n_intervals"), State("job", "data"), State("state", "data"), State("kick", "data"),
            prevent_initial_call=True,
        )(self.polled)  # fmt: skip
        on(Output("job-text", "children", allow_duplicate=True), Input("do-cancel", "n_clicks"), State("job", "data"),
           prevent_initial_call=True)(self.cancelled)  # fmt: skip
        on(Output("get-made", "data"), Input("do-get-made", "n_clicks"), State("job", "data"),
           prevent_initial_call=True)(self.made_report)  # fmt: skip
        self._in_browser()

    def _in_browser(self) -> None:
        """What the browser does alone: sliders follow numbers, parts fold, the address follows the state."""
        spans = [[one.id, *ends(one), one.log] for one in SLIDERS]
        follow = """(...texts) => texts.map((text, i) => {
            const [name, low, high, log] = SPANS[i]; let x = parseFloat(text);
            if (!isFinite(x)) return dash_clientside.no_update;
            if (log) x = x > 0 ? Math.log10(x) : low;
            x = Math.min(Math.max(x, low), high);
            const range = document.getElementById('r-' + name);
            return range && Math.abs(range.value - x) <= range.step / 2 ? dash_clientside.no_update : x; })"""
        follow = follow.replace("SPANS", json.dumps(spans))
        on = self.app.clientside_callback
        on(follow, *(Output(f"r-{one.id}", "value") for one in SLIDERS),
           *(Input(f"c-{one.id}", "value") for one in SLIDERS))  # fmt: skip
        own = [one for one in CONTROLS if one.section in PARTS]
        fold = "(...kinds) => SECTIONS.map(kind => kinds[PARTS.indexOf(kind)] !== OWN)"
        sections = [one.section for one in own]
        for sign, value in (("SECTIONS", sections), ("PARTS", list(PARTS)), ("OWN", OWN)):
            fold = fold.replace(sign, json.dumps(value))
        on(fold, *(Output(f"w-{one.id}", "hidden") for one in own), *(Input(f"c-s-{kind}", "value") for kind in PARTS))
        on("(...all) => { window.uwoptExplore && window.uwoptExplore.follow(...all); return 0; }",
           Output("sync", "data"), *(Input(name, "data") for name in ("address", "marked", "extra")))  # fmt: skip

    # ------------------------------------------------------------ exploring

    def changed(self, *given: Any) -> tuple[Any, ...]:
        """Controls were turned: the next state, its figures and what is wrong with it."""
        *texts, moved_lamps, _, state = given
        made = states.with_lamps(states.with_texts(state, dict(zip(IDS, texts, strict=True))), moved_lamps)
        found = showing.results(self.outcomes, made)
        faults = showing.fault_list(made, found)
        marks = showing.marked(made, found)
        files = sorted(made["files"])
        extra = {
            "systems": showing.system_names(made), "shown": made["shown"],
            "scenes": [str(scene.get("name") or f"scene {n}") for n, scene in enumerate(made["mission"]["scenes"], 1)],
            "scene": made["scene"], "files": [name for name in files if name.casefold().endswith(".csv")],
            "parts": self.own_parts(made), "rig": showing.rig(made, found),
        }  # fmt: skip
        shown: tuple[Any, Any] = (showing.figure_table(made, found), showing.margin_table(made, found))
        if all(isinstance(one, UwoptError) for one in found):
            shown = (no_update, no_update)
        held = f"Own files in this tab: {', '.join(files)}. The address does not hold them." if files else ""
        name = printable(str(made["mission"].get("name") or "mission"))[:120]
        return (
            no_update if made == state else made, *shown, faults, marks, states.address_of(made), name, extra, held,
        )  # fmt: skip

    def own_parts(self, state: states.State) -> dict[str, list[str]]:
        """Ids of parts that the mission's own files add, by kind."""
        from uwopt.forward.assembly import load_catalog
        from uwopt.mission.mission import load_mission

        if not state["files"]:
            return {}
        try:
            catalog = load_catalog(load_mission(self.outcomes.with_files(state, state["mission"])))
        except UwoptError:  # told with the figures
            return {}
        known = {kind: {part.id for part in load_catalog().parts(kind)} for kind in PARTS}
        return {
            kind: [part.id for part in catalog.parts(kind) if part.id not in known[kind]]
            for kind in PARTS
        }

    def acted(self, *given: Any) -> tuple[Any, ...]:
        """A system or part was chosen, added or loaded, or an address opened: the next state, every control anew."""
        address, shown, scene, *_ = given
        given = given[3 + len(PART_IDS) + len(CLICKS) :]
        contents, names = given[: len(UPLOADS)], given[len(UPLOADS) : 2 * len(UPLOADS)]
        mission_text, system_text, *texts, state, kick = given[2 * len(UPLOADS) :]
        what = ctx.triggered_id
        files = dict(zip(UPLOADS, zip(contents, names, strict=True), strict=True))
        try:
            if what != "opened":
                state = states.with_texts(state, dict(zip(IDS, texts, strict=True)))
            made, told = self._act(what, state, address, (shown, scene), files, (mission_text, system_text))
        except UwoptError as fault:
            said = html.Ul([html.Li(text) for text in showing.fault_texts(fault)])
            return (*(no_update for _ in IDS), no_update, no_update, said, no_update, no_update)
        made = {**made, "move": state.get("move")}  # of the lamps is done, whatever came instead
        return (
            *(states.text_of(made, one) for one in CONTROLS), made, kick + 1, told,
            states.yaml_text(made["mission"]), states.yaml_text(states.shown_system(made)),
        )  # fmt: skip

    def _act(
        self, what: Any, state: states.State, address: Any, places: tuple[Any, Any], files: dict[str, tuple[Any, Any]],
        texts: tuple[Any, Any],
    ) -> tuple[states.State, str]:  # fmt: skip
        """The next state, and what is said of it."""
        if what == "opened":
            return states.unpacked(str(address or "").partition(" ")[0].removeprefix("#s=")), "Opened from the address."
        if what in ("c-shown", "c-scene"):
            return moved(state, *places), ""
        if str(what).removeprefix("c-") in PART_IDS:
            return state, ""
        if what == "do-add":
            return states.with_copy(state), "A copy stands beside it; the controls act on the copy."
        if what == "do-remove":
            return states.without_shown(state), "Removed."
        if what == "do-apply":
            made = states.with_mission(state, states.loaded(str(texts[0]), "mission", "mission"))
            return states.with_system(made, states.loaded(str(texts[1]), "system", "system")), "Taken."
        kind = str(what).removeprefix("put-")
        content, name = files[kind]
        return with_upload(state, kind, str(content or ""), printable(str(name or "file")))

    def plotted(self, state: states.State, name: str) -> list[Any]:
        """The chosen plot of all systems."""
        return showing.plot_list(self.outcomes, state, name)

    def _saver(self, name: str) -> Callable[..., Any]:
        """What hands out the mission, the system or the report."""

        def saved(_: Any, state: states.State) -> Any:
            if name == "mission":
                return {"content": states.yaml_text(state["mission"]), "filename": "mission.yaml"}
            if name == "system":
                return {"content": states.yaml_text(states.shown_system(state)), "filename": "system.yaml"}
            from uwopt.report.write import page_text

            try:
                text = page_text(self.outcomes.result(state, state["shown"]))
            except UwoptError:  # told with the figures
                raise PreventUpdate from None
            return {"content": self.outcomes.plain(text), "filename": "report.html"}

        return saved

    # ------------------------------------------------------------ deciding

    def started(self, *given: Any) -> tuple[Any, ...]:
        """Begin work in the background."""
        vary, *given_rest = given[len(JOBS) :]
        figure, *inputs = given_rest[: len(MAP_FIELDS)]
        *pins, running, state = given_rest[len(MAP_FIELDS) :]
        kind = str(ctx.triggered_id).removeprefix("do-job-")
        before = self.jobs.get(running)
        try:
            if before is not None and before.done is None:
                raise MissionError("this tab has work running already; wait for it, or cancel it.")
            wanted = state["mission"]
            if kind in PINNED_JOBS:
                wanted = self._pinned(state, [name for name, on in zip(PINS, pins, strict=True) if on == "on"])
            mission = self.outcomes.with_files(state, wanted)
            system = self.outcomes.with_files(state, states.shown_system(state))
            asked = "\n".join(str(text or "") for text in (figure, *inputs)) if kind == "map" else str(vary or "")
            return self.jobs.start(kind, mission, system, asked), "Starting.", False
        except UwoptError as fault:
            return no_update, html.Ul([html.Li(text) for text in showing.fault_texts(fault)]), no_update

    def _pinned(self, state: states.State, pins: list[str]) -> dict[str, Any]:
        """The mission with what is pinned of the shown system, as it is set now."""
        design = None
        if any(name in (*OF_SETTINGS, "places") for name in pins):
            design = self.outcomes.result(state, state["shown"]).best
        return pinned(state, pins, design)

    def polled(self, _: Any, name: str | None, state: states.State, kick: int) -> tuple[Any, ...]:
        """What the work says by now; at its end the state with what it found."""
        still = [no_update] * (len(IDS) + 2)
        job = self.jobs.get(name)
        if job is None:
            return (*still, "", "0", True, True, True, no_update, no_update)
        if job.done is None:
            of_all = job.kind == "map"  # else of the step that is named; a bar without a value only moves
            share = f", {100 * job.share:.0f} %{'' if of_all else ' of this step'}" if job.share else ""
            bar = str(job.share) if of_all else None
            return (*still, job.what + share, bar, False, job.stopped_at is not None, True, [], no_update)
        if job.is_handed_over:  # the clock had ticked once more
            raise PreventUpdate
        job.is_handed_over = True
        word, said, system, _text = job.done
        if word == "fault":
            return (*still, self.outcomes.plain(str(said)), "0", True, True, True, [], no_update)
        if job.kind == "map":
            return (*still, "Done: the map is drawn.", "1", True, True, False, [], showing.figure(said, "", "plot-map"))
        lines = [html.P(self.outcomes.plain(text)) for text in said]
        if system is None:
            return (*still, "Done.", "1", True, True, False, lines, no_update)
        made = states.with_copy(state) if len(state["systems"]) < states.MOST_SYSTEMS else state
        made = states.with_system(made, {**system, "name": "recommended"})
        values = [states.text_of(made, one) for one in CONTROLS]
        told = "Done: what is recommended stands beside your system, and the controls act on it."
        return (*values, made, kick + 1, told, "1", True, True, False, lines, no_update)

    def cancelled(self, _: Any, name: str | None) -> str:
        """Ask the work to stop."""
        job = self.jobs.get(name)
        if job is None:
            raise PreventUpdate
        job.stop()
        return "Stopping; what is found by now is kept."

    def made_report(self, _: Any, name: str | None) -> Any:
        """The page of what the work found."""
        job = self.jobs.get(name)
        if job is None or job.done is None or not job.done[3]:
            raise PreventUpdate
        return {"content": self.outcomes.plain(job.done[3]), "filename": f"{job.kind}.html"}

    # ------------------------------------------------------------ who may ask

    def _guards(self) -> None:
        """Only names of this machine are answered, only its own pages may ask, and nothing is loaded from elsewhere."""
        server = self.app.server
        server.config["MAX_CONTENT_LENGTH"] = MOST_REQUEST_BYTES
        policy = "; ".join((
            "default-src 'none'", "script-src 'self' " + " ".join(self.app.csp_hashes()),
            "style-src 'self' 'unsafe-inline'", "img-src 'self' data: blob:", "font-src 'self' data:",
            "connect-src 'self'", "base-uri 'none'",
            "form-action 'none'", "frame-ancestors 'none'",
        ))  # fmt: skip

        def only_own() -> Any:
            from flask import request

            asked = request.host.rpartition(":")[0] or request.host
            if self.hosts is not None and asked.strip("[]") not in self.hosts:
                return "uwopt explore: asked for under another name than that of this machine.\n", 403
            origin = request.headers.get("Origin")
            if request.method == "POST" and origin is not None and origin.partition("://")[2] != request.host:
                return "uwopt explore: another page may not ask.\n", 403
            return None

        def with_headers(response: Any) -> Any:
            response.headers["Content-Security-Policy"] = policy
            response.headers["X-Content-Type-Options"] = "nosniff"
            response.headers["Referrer-Policy"] = "no-referrer"
            return response

        server.before_request(only_own)
        server.after_request(with_headers)


def moved(state: states.State, shown: Any, scene: Any) -> states.State:
    """Another system or scene for the controls."""
    try:
        system, place = int(shown or 0), int(scene or 0)
    except ValueError:
        raise PreventUpdate from None
    inside = 0 <= system < len(state["systems"]) and 0 <= place < len(state["mission"]["scenes"])
    if not inside or (system, place) == (state["shown"], state["scene"]):
        raise PreventUpdate
    return {**state, "shown": system, "scene": place}


def with_upload(state: states.State, kind: str, content: str, name: str) -> tuple[states.State, str]:
    """The state with a file that was loaded; raises MissionError where it cannot be."""
    head, _, code = content.partition(",")
    if not code or "base64" not in head:
        raise MissionError(f"{name}: is empty, or was not sent whole; load it again.")
    if len(code) > 1.4 * states.MOST_FILE_BYTES:
        raise MissionError(f"{name}: is larger than {states.MOST_FILE_BYTES // 1_000_000} MB, and was not read.")
    try:
        text = base64.b64decode(code, validate=True).decode("utf-8-sig")
    except (binascii.Error, UnicodeDecodeError):
        raise MissionError(f"{name}: is no text in UTF-8; save it as such.") from None
    if kind == "own":
        made = states.with_file(state, name, text)
        return made, f"{name} is loaded. {how_to_use(made, name)}"
    data = states.loaded(text, name, kind)
    made = states.with_mission(state, data) if kind == "mission" else states.with_system(state, data)
    return made, f"{name} is loaded."


def how_to_use(state: states.State, name: str) -> str:
    """A table of parts is taken into the mission at once; a curve is chosen by its name."""
    first = next((line for line in state["files"][name].splitlines() if line and not line.startswith("#")), "")
    columns = {cell.strip().strip('"') for cell in first.split(",")}
    if "id" not in columns:
        return "Choose it by its name as water, bottom or light type."
    key = "prices" if columns <= {"id", "price", "price_low", "price_high", "currency", "date", "note"} else "files"
    catalog = state["mission"].setdefault("catalog", {})
    catalog[key] = name if key == "prices" else sorted({*(catalog.get("files") or []), name})
    return "Its prices hold now." if key == "prices" else "Its parts stand in the lists of parts now."


def _assets() -> Any:
    from importlib import resources

    return resources.files("uwopt.explore").joinpath("assets")


ASSETS = _assets()

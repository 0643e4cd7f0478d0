/* The trade-off: plots, parallel coordinates, table and card, all showing one state. */
function showFront(page) {
"use strict";
const {data: {front}, colour, later, plot} = page;
const {objectives, columns, points, picks, peers, texts} = front;
const byId = (id) => document.getElementById(id);
const state = {text: "", parts: ["", "", "", ""], ranges: new Map(), chosen: -1, peers: peers.length > 0};
let passing = points.map(() => true);
const plots = [];  // {element, at: index of each trace, place: values of a point}
const rows = [...byId("points").tBodies[0].rows];

function el(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}
function shape(tag, attributes = {}, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}
const plain = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
const titled = (o) => o.title + (o.unit ? " [" + o.unit + "]" : "");
const axisTitle = (o) => titled(o) + (o.maximise ? " (more is better)" : " (less is better)");
const system = (p) => {
  const [camera, lens, port, light] = p.parts.map((n) => texts[n]);
  return [camera, lens, port, p.counts[3] + " × " + light];
};

function hover(p) {
  const head = "<b>" + plain(p.id) + (p.pick ? ": " + plain(p.pick) : "") + "</b>";
  const values = objectives.map((o, k) => plain(o.title) + " " + plain(texts[p.shown[k]]));
  return [head, ...values, ...system(p).map(plain)].join("<br>");
}
const hovers = points.map(hover);
const peerHovers = peers.map((peer) => ["<b>" + plain(peer.method) + "</b>",
  ...objectives.map((o, k) => plain(o.title) + " " + plain(texts[peer.shown[k]])),
  plain(texts[peer.hardware])].join("<br>"));

/* ---- plots */
const GREY = "#7a8894", CHOSEN = "#d9822b", SIZE = 7, RING = 15;
const scale = () => { const steps = front.scales[page.isDark() ? "dark" : "light"]; return steps.map((c, n) => [n / (steps.length - 1), c]); };
const opacities = () => points.map((p, i) => (passing[i] ? 1 : 0.07));
const everyPick = points.map((p, i) => i).filter((i) => points[i].pick);
const curves = new Map();  // points of the same hardware
points.forEach((p, i) => curves.set(p.curve, [...(curves.get(p.curve) || []), i]));
const joined = [...curves.values()].filter((c) => c.length > 1).flatMap((c) => [...c, -1]);

const warped = (k, v) => (objectives[k].log ? Math.log10(v) : v);
function hueTicks(k) {  // colours follow the axis: by logarithm where that is one
  const logs = points.map((p) => warped(k, p.values[k])), ends = [Math.min(...logs), Math.max(...logs)];
  if (!objectives[k].log || ends[0] === ends[1]) return {nticks: 6, exponentformat: "none", separatethousands: true};
  const values = logTicks(ends);
  return {tickvals: values.map(Math.log10), ticktext: values.map(spaced)};
}
function tracesFor(axes, three) {
  const names = ["x", "y", "z"].slice(0, axes.length), type = three ? "scatter3d" : "scatter";
  const place = (values) => Object.fromEntries(names.map((name, k) => [name, values(axes[k])]));
  const third = objectives.map((o, k) => k).find((k) => !axes.includes(k));
  const hue = three ? 2 : third;
  const marker = {size: three ? SIZE * 0.6 : SIZE, opacity: three ? 1 : opacities(), line: {width: 0}};
  if (hue !== undefined) Object.assign(marker, {color: points.map((p) => warped(hue, p.values[hue])), colorscale: scale(), showscale: !three, colorbar: {
    title: {text: plain(titled(objectives[hue])), side: "right", font: {size: 12}}, thickness: 9, len: 1, x: 1.03, xpad: 0, outlinewidth: 0, tickfont: {size: 11}, ...hueTicks(hue)}});
  else marker.color = colour("accent");
  const traces = [], at = {hued: hue !== undefined};
  if (joined.length) traces.push({type, mode: "lines", name: "same hardware", hoverinfo: "skip", line: {width: three ? 2 : 1.3, color: GREY}, opacity: 0.75,
    connectgaps: false, ...place((k) => joined.map((i) => (i < 0 ? null : points[i].values[k])))});
  if (peers.length) {
    at.peers = traces.length;
    traces.push({type, mode: "markers", name: "other methods", visible: state.peers, text: peerHovers, hovertemplate: "%{text}<extra></extra>",
      marker: {symbol: "diamond-open", size: three ? 4 : 10, color: GREY, line: {width: 1, color: GREY}, opacity: 0.7},
      ...place((k) => peers.map((peer) => peer.values[k]))});
  }
  at.points = traces.length;
  traces.push({type, mode: "markers", name: "front", text: hovers, hovertemplate: "%{text}<extra></extra>", customdata: points.map((p, i) => i), marker,
    ...place((k) => points.map((p) => p.values[k]))});
  traces.push({type, mode: three ? "markers+text" : "markers", name: "picks", text: everyPick.map((i) => plain(points[i].pick)), hoverinfo: "skip",
    textposition: "top center", textfont: {size: 12, color: colour("ink")}, cliponaxis: false,
    marker: {symbol: "circle-open", size: three ? 9 : RING, color: colour("accent"), line: {width: 2, color: colour("accent")}},
    ...place((k) => everyPick.map((i) => points[i].values[k]))});
  at.chosen = traces.length;
  traces.push({type, mode: "markers", name: "chosen", hoverinfo: "skip", cliponaxis: false,
    marker: {symbol: "circle-open", size: three ? 13 : 22, color: CHOSEN, line: {width: 3, color: CHOSEN}},
    ...place((k) => (state.chosen < 0 ? [] : [points[state.chosen].values[k]]))});
  return {traces, at, names};
}

/* names of picks: each with a line to its ring, where it covers neither another name nor a ring, nor leaves the plot */
const pen = document.createElement("canvas").getContext("2d");
function nameBoxes(rings, marks, width, height) {  // in pixels from the corner of the axes
  const taken = [];
  pen.font = "12px " + getComputedStyle(document.body).fontFamily;
  return rings.map(({x, y, name}, own) => {
    const w = pen.measureText(name).width + 8, h = 18;
    let best = null;
    for (const [far, cost] of [[22, 0], [38, 6], [58, 14], [82, 24]]) {
      for (let n = 0; n < 16; n++) {
        const turn = (n * Math.PI) / 8, dx = Math.cos(turn), dy = Math.sin(turn);
        const cx = x + dx * (far + w / 2 * Math.abs(dx)), cy = y + dy * (far + h / 2 * Math.abs(dy));
        const box = [cx - w / 2, cy - h / 2, cx + w / 2, cy + h / 2];
        const inside = ([px, py], room) => px > box[0] - room && px < box[2] + room && py > box[1] - room && py < box[3] + room;
        const out = Math.max(0, 2 - box[0]) + Math.max(0, 2 - box[1]) + Math.max(0, box[2] - width + 2) + Math.max(0, box[3] - height + 2);
        let bad = cost + 40 * out + marks.filter((m) => inside(m, 4)).length * 2;
        rings.forEach((other, k) => {
          if (k === own) return;
          if (inside([other.x, other.y], 10)) bad += 300;
          const nearer = Math.hypot(cx - other.x, cy - other.y) < Math.hypot(cx - x, cy - y);
          if (nearer) bad += 60;
        });
        for (const t of taken) if (box[0] < t[2] + 3 && box[2] > t[0] - 3 && box[1] < t[3] + 3 && box[3] > t[1] - 3) bad += 400;
        if (!best || bad < best.bad) best = {bad, box, ax: cx - x, ay: cy - y};
      }
    }
    taken.push(best.box);
    return best;
  });
}
function namePicks({element, axes}) {
  const {xaxis, yaxis} = element._fullLayout;
  const spot = (i) => [xaxis.d2p(points[i].values[axes[0]]), yaxis.d2p(points[i].values[axes[1]])];
  const seen = everyPick.filter((i) => { const [x, y] = spot(i); return x >= -1 && x <= xaxis._length + 1 && y >= -1 && y <= yaxis._length + 1; });
  const rings = seen.map((i) => { const [x, y] = spot(i); return {x, y, name: points[i].pick}; });
  const boxes = nameBoxes(rings, points.map((p, i) => spot(i)), xaxis._length, yaxis._length);
  const on = (a, v) => (a.type === "log" ? Math.log10(v) : v);
  return Plotly.relayout(element, {...ticks(element), annotations: seen.map((i, n) => ({
    x: on(xaxis, points[i].values[axes[0]]), y: on(yaxis, points[i].values[axes[1]]), text: plain(points[i].pick), font: {size: 12},
    ax: boxes[n].ax, ay: boxes[n].ay, showarrow: true, arrowhead: 0, arrowwidth: 1.2, arrowcolor: GREY, standoff: RING / 2, borderpad: 1, captureevents: false}))});
}

function axis(o) {
  const made = {title: {text: plain(axisTitle(o)), font: {size: 13}}, showline: true, ticks: "outside", ticklen: 4, zeroline: false};
  return o.log ? {...made, type: "log", tickangle: 0} : {...made, nticks: 7};
}
/* ticks of an axis of logarithms as whole numbers: the coarsest steps that leave four in sight */
const STEPS = [[1], [1, 3], [1, 2, 5], [1, 1.5, 2, 3, 4, 5, 7], [1, 1.2, 1.4, 1.6, 1.8, 2, 2.5, 3, 3.5, 4, 4.5, 5, 6, 7, 8, 9]];
function logTicks([low, high]) {
  const from = Math.floor(low), to = Math.ceil(high), inside = (v) => Math.log10(v) >= low && Math.log10(v) <= high;
  const exact = (v) => Number(v.toPrecision(12));
  for (const steps of STEPS) {
    const found = [];
    for (let power = from; power <= to; power++) found.push(...steps.map((step) => exact(step * 10 ** power)).filter(inside));
    if (found.length >= 4) return found;
  }
  const [bottom, top] = [10 ** low, 10 ** high], power = 10 ** Math.floor(Math.log10((top - bottom) / 4));
  const step = [5, 2, 1].map((n) => n * power).find((one) => (top - bottom) / one >= 4) || power;
  const found = [];
  for (let v = Math.ceil(bottom / step) * step; v <= top; v += step) found.push(exact(v));
  return found;
}
const spaced = (v) => { const [whole, part] = String(v).split("."); return whole.replace(/\B(?=(\d{3})+$)/g, "\u2009") + (part ? "." + part : ""); };
function ticks(element) {
  const changes = {};
  for (const name of ["xaxis", "yaxis"]) {
    if (element._fullLayout[name].type !== "log") continue;
    const values = logTicks(element._fullLayout[name].range);
    Object.assign(changes, {[name + ".tickvals"]: values, [name + ".ticktext"]: values.map(spaced)});
  }
  return changes;
}

function addPlot(element, axes, layout, three) {
  element.classList.add("plot");
  later(element, async () => {
    const {traces, at, names} = tracesFor(axes, three), drawn = version;
    await plot(element, traces, {showlegend: false, hovermode: "closest", ...layout});
    const made = {element, at, axes, names, three};
    plots.push(made);
    if (!three) {
      await namePicks(made);
      element.on("plotly_relayout", (event) => { if (Object.keys(event).some((key) => /range|autosize/.test(key))) namePicks(made); });
    }
    element.on("plotly_click", (event) => {
      const hit = event.points.find((p) => p.customdata !== undefined) || event.points[0];
      if (hit && hit.customdata !== undefined) choose(hit.customdata, false);
    });
    if (version !== drawn || three) follow();  // what changed while it was drawn; in space, what is filtered
  });
}

const pairs = objectives.length === 3 ? [[1, 0], [2, 0], [2, 1]] : objectives.length === 2 ? [[1, 0]] : [];
for (const pair of pairs) {
  const [x, y] = pair.map((k) => objectives[k]);
  const element = el("div", {class: "front-plot", role: "img", "data-pair": pair.join("-"),
    "aria-label": y.title + " against " + x.title + ", " + points.length + " systems; the table below holds the same numbers"});
  byId("pairs").append(element);
  addPlot(element, pair, {xaxis: axis(x), yaxis: axis(y), margin: {l: 58, r: objectives.length === 3 ? 8 : 20, t: 14, b: 50}}, false);
}
byId("pairs").classList.toggle("is-single", pairs.length === 1);
byId("pairs-key").append(...[["front", "a system of the front"], ...(joined.length ? [["curve", "the same hardware, set otherwise"]] : []),
  ...(peers.length ? [["peer", "found by " + [...new Set(peers.map((p) => p.method))].join(", ")]] : []), ["pick", "a pick"], ["chosen", "chosen"]]
  .map(([kind, words]) => el("li", {}, el("span", {class: "key-" + kind, "aria-hidden": "true"}), words)));
const space = byId("space");
function spaceTicks(k) {
  if (!objectives[k].log) return {type: "linear", nticks: 5};
  const logs = points.map((p) => Math.log10(p.values[k])), values = logTicks([Math.min(...logs) - 0.01, Math.max(...logs) + 0.01]);
  return {type: "log", tickvals: values, ticktext: values.map(spaced)};
}
if (space) {
  const canvas = document.createElement("canvas");
  if (canvas.getContext("webgl2") || canvas.getContext("webgl")) {
    const look = () => ({gridcolor: colour("line"), zerolinecolor: colour("line"), color: colour("ink"), backgroundcolor: "rgba(0,0,0,0)"});
    const scene = () => Object.fromEntries(["xaxis", "yaxis", "zaxis"].map((name, k) => [name,
      {title: {text: plain(titled(objectives[k]))}, ...spaceTicks(k), ...look()}]));
    addPlot(space, [0, 1, 2], {scene: {...scene(), camera: {eye: {x: 1.75, y: 1.75, z: 0.95}, center: {x: 0, y: 0, z: -0.12}}}, margin: {l: 0, r: 0, t: 0, b: 0}}, true);
    page.themed.push(() => {
      if (!space.data) return;
      const changes = {"font.color": colour("ink")};
      for (const name of ["xaxis", "yaxis", "zaxis"]) for (const [key, value] of Object.entries(look())) changes["scene." + name + "." + key] = value;
      Plotly.relayout(space, changes);
    });
  } else page.note(space, "This browser has no WebGL, so the view in three dimensions is left out; the pairs show the same points.");
}
page.themed.push(() => plots.forEach(({element, at}) => {
  Plotly.restyle(element, at.hued ? {"marker.colorscale": [scale()]} : {"marker.color": colour("accent")}, [at.points]);
  Plotly.restyle(element, {"textfont.color": colour("ink"), "marker.color": colour("accent"), "marker.line.color": colour("accent")}, [at.points + 1]);
}));
/* the card of the chosen system: the last cell of three pairs, else beside the view */
function placeCard() {
  const among = pairs.length === 3 && page.visible(byId("pairs"));
  const home = among ? byId("pairs") : document.querySelector(".explore");
  if (byId("chosen").parentElement !== home) home.append(byId("chosen"));
  document.querySelector(".explore").classList.toggle("is-whole", among);
}
document.querySelector(".explore > .tabs").addEventListener("shown", placeCard);
placeCard();

/* ---- parallel coordinates */
const WIDE = 860, HIGH = 400, TOP = 72, BOTTOM = 34;
const lanes = columns.map((c, k) => k).filter((k) => {
  const known = points.map((p) => p.values[k]).filter((v) => v !== null);
  return known.length && (k < objectives.length || Math.max(...known) > Math.min(...known));
}).slice(0, 8);
const scales = lanes.map((k, n) => {
  const known = points.map((p) => p.values[k]).filter((v) => v !== null);
  const low = Math.min(...known), high = Math.max(...known), o = objectives[k];
  const warp = o && o.log ? Math.log : (v) => v, back = o && o.log ? Math.exp : (v) => v;
  const turned = Boolean(o) && !o.maximise, span = warp(high) - warp(low) || 1;
  const x = lanes.length > 1 ? 70 + (n * (WIDE - 140)) / (lanes.length - 1) : WIDE / 2;
  const share = (v) => (high === low ? 0.5 : (warp(v) - warp(low)) / span);
  return {k, x, low, high, turned, y: (v) => TOP + (HIGH - TOP - BOTTOM) * (turned ? share(v) : 1 - share(v)),
    value: (y) => { const s = Math.min(1, Math.max(0, (y - TOP) / (HIGH - TOP - BOTTOM))); const up = turned ? s : 1 - s; return up === 0 ? low : up === 1 ? high : back(warp(low) + span * up); }};
});
const shownAt = (k, v) => { const i = points.findIndex((p) => p.values[k] === v); return i < 0 ? "" : texts[points[i].shown[k]]; };
const lines = points.map((p, i) => {
  const path = scales.filter((s) => p.values[s.k] !== null).map((s, n) => (n ? "L" : "M") + s.x.toFixed(1) + " " + s.y(p.values[s.k]).toFixed(1)).join("");
  const line = shape("path", {d: path, class: "lane" + (p.pick ? " is-pick" : ""), "data-index": i}, shape("title", {}, [p.id, p.pick, ...system(p)].filter(Boolean).join(", ")));
  line.addEventListener("click", () => choose(i, false));
  return line;
});
const brushes = new Map();
const chart = shape("svg", {viewBox: "0 0 " + WIDE + " " + HIGH, role: "group", "aria-label": "Parallel coordinates of " + points.length + " systems; the table and its range filters hold the same"}, ...lines);
for (const s of scales) {
  const c = columns[s.k], brush = shape("rect", {class: "brush", x: s.x - 9, width: 18, y: 0, height: 0});
  const hit = shape("rect", {class: "hit", x: s.x - 16, width: 32, y: TOP - 6, height: HIGH - TOP - BOTTOM + 12, "data-column": s.k});
  const top = s.turned ? s.low : s.high, bottom = s.turned ? s.high : s.low;
  chart.append(shape("g", {class: "lane-axis"},
    shape("line", {x1: s.x, x2: s.x, y1: TOP, y2: HIGH - BOTTOM}),
    shape("text", {x: s.x, y: scales.indexOf(s) % 2 ? 32 : 14}, c.title), shape("text", {x: s.x, y: TOP - 14, class: "end"}, shownAt(s.k, top)),
    shape("text", {x: s.x, y: HIGH - BOTTOM + 20, class: "end"}, shownAt(s.k, bottom)), brush, hit));
  brushes.set(s.k, {brush, s});
  let from = null;
  const place = (event) => { const box = chart.getBoundingClientRect(); return ((event.clientY - box.top) / box.height) * HIGH; };
  hit.addEventListener("pointerdown", (event) => { from = place(event); hit.setPointerCapture(event.pointerId); });
  hit.addEventListener("pointermove", (event) => {
    if (from === null) return;
    const to = place(event);
    if (Math.abs(to - from) > 4) setRange(s.k, ...[s.value(from), s.value(to)].sort((a, b) => a - b));
  });
  const end = (event) => { if (from !== null && Math.abs(place(event) - from) <= 4) setRange(s.k, null, null); from = null; };
  hit.addEventListener("pointerup", end);
  hit.addEventListener("pointercancel", () => { from = null; });
}
byId("lanes").append(chart);

/* ---- filters */
const selects = [...document.querySelectorAll("select[data-part]")];
selects.forEach((select) => {
  const kind = Number(select.dataset.part);
  [...new Set(points.map((p) => texts[p.parts[kind]]))].sort().forEach((name) => select.append(el("option", {value: name}, name)));
  select.addEventListener("change", () => { state.parts[kind] = select.value; filter(); });
});
byId("filter-text").addEventListener("input", (event) => { state.text = event.target.value.toLowerCase().trim(); filter(); });
const inputs = new Map();
columns.forEach((c, k) => {
  const ends = ["at least", "at most"].map((word) => el("input", {type: "number", step: "any", placeholder: word, "aria-label": c.title + " " + word}));
  ends.forEach((input) => input.addEventListener("input", () => setRange(k, ...ends.map((e) => (e.value === "" ? null : Number(e.value))), true)));
  inputs.set(k, ends);
  document.querySelector("#ranges .range-grid").append(el("fieldset", {}, el("legend", {}, titled(c)), ...ends));
});
byId("filter-reset").addEventListener("click", () => {
  Object.assign(state, {text: "", parts: ["", "", "", ""], ranges: new Map()});
  byId("filter-text").value = "";
  selects.forEach((select) => { select.value = ""; });
  inputs.forEach((ends) => ends.forEach((input) => { input.value = ""; }));
  filter();
});
byId("peers")?.addEventListener("change", (event) => {
  state.peers = event.target.checked;
  plots.forEach(({element, at}) => { if (at.peers !== undefined) Plotly.restyle(element, {visible: state.peers}, [at.peers]); });
});

function setRange(k, low, high, typed) {
  if (low === null && high === null) state.ranges.delete(k); else state.ranges.set(k, [low, high]);
  if (!typed) inputs.get(k).forEach((input, n) => { const v = [low, high][n]; input.value = v === null ? "" : Number(v.toPrecision(4)); });
  filter();
}

const haystacks = points.map((p) => [p.id, p.pick, p.method, ...p.parts.map((n) => texts[n]), ...p.names.map((n) => texts[n])].join(" ").toLowerCase());
function filter() {
  passing = points.map((p, i) =>
    state.text.split(/\s+/).every((word) => haystacks[i].includes(word))
    && state.parts.every((name, kind) => !name || texts[p.parts[kind]] === name)
    && [...state.ranges].every(([k, [low, high]]) => p.values[k] !== null && (low === null || p.values[k] >= low) && (high === null || p.values[k] <= high)));
  follow();
}

let waiting = false, version = 0;
function follow() {  // all views show the state, at most once a frame
  version += 1;
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => {
    waiting = false;
    rows.forEach((row) => { row.hidden = !passing[row.dataset.index]; });
    lines.forEach((line, i) => { line.classList.toggle("is-out", !passing[i]); line.classList.toggle("is-chosen", i === state.chosen); });
    brushes.forEach(({brush, s}, k) => {
      const [low, high] = state.ranges.get(k) || [null, null], any = state.ranges.has(k);
      const ends = any ? [low ?? s.low, high ?? s.high].map((v) => s.y(Math.min(s.high, Math.max(s.low, v)))).sort((a, b) => a - b) : [0, 0];
      brush.setAttribute("y", ends[0]);
      brush.setAttribute("height", any ? Math.max(3, ends[1] - ends[0]) : 0);
    });
    const left = passing.filter(Boolean).length;
    byId("filter-count").textContent = left === points.length ? "All " + points.length + " systems are shown." : left + " of " + points.length + " systems are shown.";
    plots.forEach(({element, at, axes, names, three}) => {
      if (three) {
        const keep = (k) => points.map((p, i) => (passing[i] ? p.values[k] : null));
        Plotly.restyle(element, Object.fromEntries(names.map((name, n) => [name, [keep(axes[n])]])), [at.points]);
      } else Plotly.restyle(element, {"marker.opacity": [opacities()]}, [at.points]);
      Plotly.restyle(element, Object.fromEntries(names.map((name, n) => [name, [state.chosen < 0 ? [] : [points[state.chosen].values[axes[n]]]]])), [at.chosen]);
    });
  });
}

/* ---- table */
let sorted = {key: "id", down: false};
const order = new Intl.Collator("en", {numeric: true}).compare;
const sortValue = (key) => (i) => {
  const p = points[i];
  if (key.startsWith("part-")) return texts[p.parts[Number(key.slice(5))]];
  return key === "id" || key === "pick" || key === "method" ? p[key] : p.values[Number(key)];
};
const heads = [...document.querySelectorAll("#points th[data-sort]")];
heads.forEach((head) => {
  const button = el("button", {type: "button"}, ...head.childNodes);
  head.append(button);
  button.addEventListener("click", () => {
    sorted = {key: head.dataset.sort, down: sorted.key === head.dataset.sort && !sorted.down};
    heads.forEach((other) => other.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", sorted.down ? "descending" : "ascending");
    const value = sortValue(sorted.key), sign = sorted.down ? -1 : 1;
    const absent = (v) => v === null || v === "";
    rows.sort((a, b) => {
      const x = value(Number(a.dataset.index)), y = value(Number(b.dataset.index));
      if (absent(x) || absent(y)) return absent(x) - absent(y);  // what is not known stands last either way
      return sign * (typeof x === "number" ? x - y : order(x, y));
    });
    byId("points").tBodies[0].append(...rows);
  });
});
rows.forEach((row) => row.addEventListener("click", () => choose(Number(row.dataset.index), true)));

/* ---- the chosen system */
function facts(pairs) {
  return el("dl", {class: "facts"}, ...pairs.map(([name, value, small]) => el("div", {}, el("dt", {}, name), el("dd", {}, value, ...(small ? [el("small", {}, small)] : [])))));
}
function marginLine([name, value, limit, left, status, start, width]) {
  const drawn = shape("svg", {class: "bar", viewBox: "0 0 100 10", preserveAspectRatio: "none", "aria-hidden": "true"},
    shape("rect", {class: "rail", x: 0, y: 3, width: 100, height: 4}), shape("rect", {class: "fill", x: start, y: 1, width: Math.max(width, 0.7), height: 8}),
    shape("rect", {class: "zero", x: 24.6, y: 0, width: 0.8, height: 10}));
  const mark = texts[status] === "met" ? [] : [" ", el("span", {class: "tag " + (texts[status] === "missed" ? "bad" : "warn")}, texts[status])];
  return el("div", {class: "margin " + texts[status]}, el("span", {}, el("span", {}, texts[name], ...mark), el("span", {}, texts[value])),
    el("small", {}, texts[limit] + ", left " + texts[left]), drawn);
}
byId("more-columns").addEventListener("change", (event) => {
  byId("points").classList.toggle("is-whole", event.target.checked);
  page.markScrolling();
});
function choose(index, fromTable, quiet) {
  state.chosen = index;
  const p = points[index];
  rows.forEach((row) => {
    const own = Number(row.dataset.index) === index;
    row.classList.toggle("is-chosen", own);
    row.querySelector(".choose").setAttribute("aria-pressed", String(own));
    if (own && !fromTable && !row.hidden) {
      const box = byId("points").parentElement;
      box.scrollTop = row.offsetTop - box.clientHeight / 2;
    }
  });
  const kinds = ["camera", "lens", "port", "light"];
  const card = [el("h3", {}, "Point " + p.id + (p.pick ? ": " + p.pick : ""))];
  picks.filter((pick) => pick.point === p.id && pick.definition).forEach((pick) => card.push(el("p", {class: "dim"}, pick.definition[0].toUpperCase() + pick.definition.slice(1) + ".")));
  card.push(el("ul", {}, ...kinds.map((kind, k) => el("li", {}, p.counts[k] + " × " + texts[p.names[k]], el("small", {class: "mono"}, texts[p.parts[k]])))));
  card.push(el("p", {class: "dim"}, texts[p.stand]));
  card.push(el("h4", {}, "Figures"), facts([...objectives.map((o, k) => [o.title, texts[p.shown[k]]]),
    ...p.cards.map((c) => c.map((n) => texts[n])).filter(([title]) => !objectives.some((o) => o.title === title.toLowerCase()))]));
  p.scenes.forEach((scene) => {
    const where = texts[scene.name] ? ", " + texts[scene.name] : "";
    card.push(el("h4", {}, texts[scene.title] + where), facts(scene.settings.map((pair) => pair.map((n) => texts[n]))));
    card.push(el("h4", {}, "Margins" + where), ...scene.margins.map(marginLine));
  });
  byId("chosen").replaceChildren(...card);
  byId("chosen").scrollTop = 0;
  if (!quiet) byId("chosen-note").textContent = "Point " + p.id + " is chosen: " + system(p).join(", ") + ". Its card stands beside the plots.";
  follow();
}
window.uwopt.choose = choose;
const first = picks.find((pick) => pick.name === "knee") || picks[0];  // so that the card shows what it is for
choose(Math.max(0, points.findIndex((p) => first && p.id === first.point)), true, true);
}

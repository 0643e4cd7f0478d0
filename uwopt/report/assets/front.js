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
const sizes = points.map((p) => (p.pick ? 11 : 8));
const opacities = () => points.map((p, i) => (passing[i] ? 1 : 0.07));
const everyPick = points.map((p, i) => i).filter((i) => points[i].pick);

function tracesFor(axes, three) {
  const names = ["x", "y", "z"].slice(0, axes.length), type = three ? "scatter3d" : "scatter";
  const place = (values) => Object.fromEntries(names.map((name, k) => [name, values(axes[k])]));
  const third = objectives.map((o, k) => k).find((k) => !axes.includes(k));
  const hues = third === undefined ? null : points.map((p) => p.values[third]);
  const marker = {size: three ? sizes.map((s) => s * 0.55) : sizes, opacity: three ? 1 : opacities(), line: {width: three ? 0 : 1, color: colour("panel")}};
  if (hues) {
    Object.assign(marker, {color: hues, colorscale: "Viridis", showscale: true, colorbar: {
      title: {text: titled(objectives[third]), side: "right", font: {size: 12}}, thickness: 10, outlinewidth: 0, tickfont: {size: 11}}});
  } else marker.color = three ? points.map((p) => p.values[2]) : colour("accent");
  if (three) Object.assign(marker, {colorscale: "Viridis", showscale: false});
  const traces = [], at = {};
  if (!three) {
    const curves = new Map();
    points.forEach((p, i) => curves.set(p.curve, [...(curves.get(p.curve) || []), i]));
    const joined = [...curves.values()].filter((c) => c.length > 1).flatMap((c) => [...c, -1]);
    if (joined.length) traces.push({type, mode: "lines", hoverinfo: "skip", showlegend: false, line: {width: 1, color: "#8a9aa6"}, opacity: 0.6,
      ...place((k) => joined.map((i) => (i < 0 ? null : points[i].values[k])))});
  }
  if (peers.length) {
    at.peers = traces.length;
    traces.push({type, mode: "markers", name: "other methods", visible: state.peers, text: peerHovers, hovertemplate: "%{text}<extra></extra>",
      marker: {symbol: three ? "diamond-open" : "x-thin", size: three ? 3 : 6, color: "#8a9aa6", line: {width: 1.4, color: "#8a9aa6"}, opacity: 0.75},
      ...place((k) => peers.map((peer) => peer.values[k]))});
  }
  at.points = traces.length;
  traces.push({type, mode: "markers", name: "front", text: hovers, hovertemplate: "%{text}<extra></extra>", customdata: points.map((p, i) => i), marker,
    ...place((k) => points.map((p) => p.values[k]))});
  traces.push({type, mode: "markers+text", name: "picks", text: everyPick.map((i) => plain(points[i].pick)), hoverinfo: "skip",
    textposition: three ? "top center" : everyPick.map((i, n) => ["top right", "bottom right", "top left", "bottom left"][n % 4]),
    textfont: {size: 12, color: colour("ink")}, cliponaxis: false,
    marker: {symbol: "circle-open", size: three ? 9 : 17, color: colour("accent"), line: {width: 2, color: colour("accent")}},
    ...place((k) => everyPick.map((i) => points[i].values[k]))});
  at.chosen = traces.length;
  traces.push({type, mode: "markers", name: "chosen", hoverinfo: "skip", marker: {symbol: "circle-open", size: three ? 13 : 24, color: "#d9822b", line: {width: 3, color: "#d9822b"}},
    ...place((k) => (state.chosen < 0 ? [] : [points[state.chosen].values[k]]))});
  return {traces, at, names};
}

function axis(o) {
  const made = {title: {text: plain(axisTitle(o)), font: {size: 13}}, showline: true, ticks: "outside", ticklen: 4, zeroline: false};
  if (!o.log) return made;
  const values = [...points, ...peers].map((p) => p.values[objectives.indexOf(o)]).filter((v) => v > 0);
  const wide = Math.max(...values) / Math.min(...values) > 8;
  return {...made, type: "log", ...(wide ? {dtick: "D2"} : {nticks: 6}), minor: {}};
}

function addPlot(element, axes, layout, three) {
  element.classList.add("plot");
  later(element, async () => {
    const {traces, at, names} = tracesFor(axes, three);
    await plot(element, traces, {showlegend: false, hovermode: "closest", ...layout});
    plots.push({element, at, axes, names, three});
    element.on("plotly_click", (event) => {
      const hit = event.points.find((p) => p.customdata !== undefined) || event.points[0];
      if (hit && hit.customdata !== undefined) choose(hit.customdata, false);
    });
    follow();
  });
}

const pairs = objectives.length === 3 ? [[1, 0], [2, 0], [2, 1]] : objectives.length === 2 ? [[1, 0]] : [];
for (const pair of pairs) {
  const [x, y] = pair.map((k) => objectives[k]);
  const element = el("div", {class: "front-plot", role: "img", "data-pair": pair.join("-"),
    "aria-label": y.title + " against " + x.title + ", " + points.length + " systems; the table below holds the same numbers"});
  if (pairs.length === 1) element.style.minHeight = "480px";
  byId("pairs").append(element);
  addPlot(element, pair, {xaxis: axis(x), yaxis: axis(y), margin: {l: 70, r: 20, t: 26, b: 56}}, false);
}
const space = byId("space");
if (space) {
  const canvas = document.createElement("canvas");
  if (canvas.getContext("webgl2") || canvas.getContext("webgl")) {
    const look = () => ({gridcolor: colour("line"), zerolinecolor: colour("line"), color: colour("ink"), backgroundcolor: "rgba(0,0,0,0)"});
    const scene = () => Object.fromEntries(["xaxis", "yaxis", "zaxis"].map((name, k) => [name,
      {title: {text: plain(titled(objectives[k]))}, type: objectives[k].log ? "log" : "linear", nticks: 5, ...look()}]));
    addPlot(space, [0, 1, 2], {scene: {...scene(), camera: {eye: {x: 1.5, y: 1.5, z: 0.9}}}, margin: {l: 0, r: 0, t: 0, b: 0}}, true);
    page.themed.push(() => {
      if (!space.data) return;
      const changes = {"font.color": colour("ink")};
      for (const name of ["xaxis", "yaxis", "zaxis"]) for (const [key, value] of Object.entries(look())) changes["scene." + name + "." + key] = value;
      Plotly.relayout(space, changes);
    });
  } else page.note(space, "This browser has no WebGL, so the view in three dimensions is left out; the pairs show the same points.");
}
page.themed.push(() => plots.filter((p) => !p.three).forEach(({element, at}) => {
  Plotly.restyle(element, {"marker.line.color": colour("panel")}, [at.points]);
  Plotly.restyle(element, {"textfont.color": colour("ink"), "marker.color": colour("accent"), "marker.line.color": colour("accent")}, [at.points + 1]);
}));

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

let waiting = false;
function follow() {  // all views show the state, at most once a frame
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
function choose(index, fromTable) {
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
  picks.filter((pick) => pick.point === p.id && pick.definition).forEach((pick) => card.push(el("p", {class: "dim"}, pick.definition)));
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
  byId("chosen-note").textContent = "Point " + p.id + " is chosen: " + system(p).join(", ") + ". Its card stands beside the plots.";
  follow();
}
window.uwopt.choose = choose;
follow();
}

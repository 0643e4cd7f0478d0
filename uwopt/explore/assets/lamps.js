"use strict";
/* Lamps on a drawing of the rig: moved by pointer, keys or numbers; each move is handed to Dash as all their places. */
(() => {
  const SVG = "http://www.w3.org/2000/svg", WIDE = 360, HIGH = 260, EDGE = 34;
  const KEYS = [["x_m", "Forward [m]", 0.05], ["y_m", "Starboard [m]", 0.05], ["z_m", "Down [m]", 0.05],
                ["tilt_x_deg", "Forward tilt [°]", 2.5], ["tilt_y_deg", "Outward tilt [°]", 2.5]];
  const part = id => document.getElementById(id);
  const neat = x => String(+(+x).toFixed(3));
  let rig = null, places = [], shown = "", last = 0, timer = null, held = null, sent = 0;

  function element(name, attributes, text) {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    return made;
  }

  /* Moves are told at most every 80 ms, as those of sliders are. */
  function tell() {
    clearTimeout(timer);
    const send = () => {
      last = Date.now();
      sent = last;
      window.dash_clientside.set_props("lamps", {data: {places, move: last + "-" + Math.random()}});
    };
    if (Date.now() - last > 80) send(); else timer = setTimeout(send, 80);
  }

  function set(n, key, value) {
    const end = key.startsWith("tilt") ? 85 : 20;
    places[n] = {...places[n], [key]: +Math.min(Math.max(value, -end), end).toFixed(3)};
    show();
    tell();
  }

  /* The two views: which key runs across and which up the page, and how far what is drawn reaches. */
  function views() {
    const far = Math.max(...places.map(one => Math.max(Math.abs(one.y_m), Math.abs(one.x_m))), 0.3);
    const side = Math.max(rig.across_m / 2, far) * 1.15, ahead = Math.max(rig.along_m / 2, far) * 1.15;
    const top = Math.max(...places.map(one => -one.z_m), 0.1 * rig.altitude_m) * 1.15;
    const sign = rig.looks_up ? -1 : 1, ends = [-top, rig.altitude_m].map(z => sign * z);  // of what is ahead, on the page
    return [
      {name: "behind", title: "From behind", across: "y_m", up: "z_m", sign, tilt: "tilt_y_deg",
       low: -side, high: side, top: Math.min(...ends), bottom: Math.max(...ends)},
      {name: "above", title: "From above, forward is up", across: "y_m", up: "x_m", sign: -1, tilt: "tilt_x_deg",
       low: -side, high: side, top: -ahead, bottom: ahead},
    ];
  }

  function frame(view) {
    const scale = Math.min((WIDE - 2 * EDGE) / (view.high - view.low), (HIGH - 2 * EDGE) / (view.bottom - view.top));
    const left = WIDE / 2 - scale * (view.high + view.low) / 2, down = HIGH / 2 - scale * (view.bottom + view.top) / 2;
    return {scale, x: m => left + scale * m, y: m => down + scale * m,
            back: (px, py) => [(px - left) / scale, (py - down) / scale]};
  }

  const ahead = () => rig.looks_up ? "up" : "down";

  function told(one, n) {
    return `Lamp ${n + 1}: ${neat(one.x_m)} m forward, ${neat(one.y_m)} m to starboard, ${neat(one.z_m)} m ${ahead()}, ` +
      `leans ${neat(one.tilt_y_deg)}° outward`;
  }

  function draw(view, at = frame(view)) {
    const svg = element("svg", {viewBox: `0 0 ${WIDE} ${HIGH}`, role: "group", "aria-label": "Lamps, " + view.title});
    svg.append(element("text", {x: 8, y: 16}, view.title));
    const half = rig.across_m / 2;
    if (view.name === "behind") {
      const floor = view.sign * rig.altitude_m;
      svg.append(element("polygon", {class: "view", points: [[0, 0], [-half, floor], [half, floor]]
        .map(([x, y]) => at.x(x) + "," + at.y(y)).join(" ")}));
      svg.append(element("line", {class: "floor", x1: 6, x2: WIDE - 6, y1: at.y(floor), y2: at.y(floor)}));
    } else {
      svg.append(element("rect", {class: "view", x: at.x(-half), y: at.y(-rig.along_m / 2),
        width: at.scale * rig.across_m, height: at.scale * rig.along_m}));
    }
    svg.append(element("rect", {x: at.x(0) - 5, y: at.y(0) - 5, width: 10, height: 10, fill: "currentColor"}));
    places.forEach((one, n) => {
      const x = at.x(one[view.across]), y = at.y(view.sign * one[view.up]);
      const lamp = element("g", {class: "lamp", tabindex: 0, role: "button", "data-lamp": n, "data-view": view.name,
        "aria-label": told(one, n), "aria-describedby": "lamps-how"});
      const out = one[view.across] < 0 ? -1 : 1, lean = one.tilt_y_deg * Math.PI / 180;
      if (view.name === "behind") {
        lamp.append(element("line", {class: "aim", x1: x, y1: y, x2: x + 34 * out * Math.sin(lean), y2: y + view.sign * 34 * Math.cos(lean)}));
      }
      lamp.append(element("circle", {cx: x, cy: y, r: 9}), element("text", {x: x + 12, y: y - 8}, String(n + 1)));
      svg.append(lamp);
    });
    return svg;
  }

  /* The scale stays while a lamp is moved. */
  const drawn = () => views().map(view => held && held.view.name === view.name ? draw(held.view, held.at) : draw(view));

  function rows() {
    const table = document.createElement("table"), head = table.createTHead().insertRow();
    for (const text of ["Lamp", ...KEYS.map(([key, label]) => key === "z_m" && rig.looks_up ? "Up [m]" : label)]) {
      const cell = document.createElement("th");
      cell.scope = "col";
      cell.textContent = text;
      head.append(cell);
    }
    const body = table.createTBody();
    places.forEach((one, n) => {
      const row = body.insertRow(), name = document.createElement("th");
      name.scope = "row";
      name.textContent = String(n + 1);
      row.append(name);
      for (const [key, label, step] of KEYS) {
        const box = document.createElement("input");
        Object.assign(box, {type: "number", step, value: neat(one[key]), id: `lamp-${n}-${key}`});
        box.setAttribute("aria-label", `Lamp ${n + 1}, ${label}`);
        row.insertCell().append(box);
      }
    });
    return table;
  }

  function show() {
    const drawings = part("lamp-drawings"), numbers = part("lamp-numbers");
    if (!drawings || !rig) return;
    shown = "";
    const focus = document.activeElement, lamp = focus && focus.dataset && focus.dataset.lamp, from = lamp && focus.dataset.view;
    drawings.replaceChildren(...(places.length ? drawn() : ["No lamps."]));
    if (from) drawings.querySelector(`[data-lamp="${lamp}"][data-view="${from}"]`).focus();
    const fresh = places.length && numbers.dataset.ahead === ahead() && numbers.querySelectorAll("tbody tr").length === places.length;
    if (!fresh) numbers.replaceChildren(rows());
    numbers.dataset.ahead = ahead();
    places.forEach((one, n) => KEYS.forEach(([key]) => {
      const box = part(`lamp-${n}-${key}`);
      if (box !== document.activeElement) box.value = neat(one[key]);
    }));
  }

  function moved(svg, view, event) {
    const seen = svg.getBoundingClientRect(), at = held.at;
    const [right, down] = at.back((event.clientX - seen.left) * WIDE / seen.width, (event.clientY - seen.top) * HIGH / seen.height);
    const near = m => Math.round(m * 100) / 100;
    places[held.n] = {...places[held.n], [view.across]: near(right), [view.up]: near(view.sign * down)};
  }

  document.addEventListener("pointerdown", event => {
    const lamp = event.target.closest && event.target.closest(".lamp");
    if (!lamp) return;
    const view = views().find(one => one.name === lamp.dataset.view);
    held = {n: +lamp.dataset.lamp, view, at: frame(view)};
    lamp.focus();
    event.preventDefault();
  });
  document.addEventListener("pointermove", event => {
    if (!held) return;
    const svg = part("lamp-drawings").querySelector(`[data-view="${held.view.name}"]`).closest("svg");
    moved(svg, held.view, event);
    show();
    tell();
  });
  for (const end of ["pointerup", "pointercancel"]) document.addEventListener(end, () => { if (held) { held = null; show(); } });
  document.addEventListener("keydown", event => {
    const lamp = event.target.closest && event.target.closest(".lamp");
    if (!lamp) return;
    const n = +lamp.dataset.lamp, view = views().find(one => one.name === lamp.dataset.view), step = event.shiftKey ? 0.01 : 0.05;
    const moves = {ArrowLeft: [view.across, -step], ArrowRight: [view.across, step],
      ArrowUp: [view.up, -view.sign * step], ArrowDown: [view.up, view.sign * step],
      PageUp: ["tilt_y_deg", 2.5], PageDown: ["tilt_y_deg", -2.5]};
    if (!moves[event.key]) return;
    event.preventDefault();
    const [key, by] = moves[event.key];
    set(n, key, places[n][key] + by);
  });
  document.addEventListener("input", event => {
    const found = /^lamp-(\d+)-(\w+)$/.exec(event.target.id || "");
    if (found && event.target.value !== "" && isFinite(+event.target.value)) set(+found[1], found[2], +event.target.value);
  });

  window.uwoptLamps = {
    /* What the server says holds, unless a later move is on its way. */
    follow: now => {
      if (!now || !now.places || held || Date.now() - sent < 400) {
        if (now && now.places) clearTimeout(window.uwoptLamps.late), window.uwoptLamps.late = setTimeout(
          () => window.uwoptLamps.follow(now), 450);
        return;
      }
      const text = JSON.stringify(now);
      if (text === shown) return;
      rig = now;
      places = now.places;
      show();
      shown = text;
    },
    late: null,
  };
})();

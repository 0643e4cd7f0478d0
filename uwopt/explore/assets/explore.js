"use strict";
/* Native selects, ranges, pins and faults: what is chosen is handed to Dash, what Dash sets is shown.
   Dash has neither a native select nor a range of a logarithm that keyboards and screen readers know. */
(() => {
  const part = id => document.getElementById(id);
  const set = (id, props) => window.dash_clientside.set_props(id, props);
  let last = 0, timer = null;

  function choose(select, value) {
    if (![...select.options].some(option => option.value === value)) {
      select.add(new Option(value === "" ? "as the file leaves it" : value, value), 0);
    }
    if (select.value !== value) select.value = value;
  }

  /* Sliders speak at most every 80 ms: the server takes about half of that for a change. */
  function slide(range) {
    const text = part("c-" + range.id.slice(2));
    const log = part("w-" + range.id.slice(2)).dataset.log === "yes";
    const x = log ? Math.pow(10, +range.value) : +range.value;
    const told = log ? String(+x.toPrecision(3)) : String(+x.toPrecision(12));
    range.setAttribute("aria-valuetext", told);
    clearTimeout(timer);
    const send = () => { last = Date.now(); set(text.id, {value: told}); };
    if (Date.now() - last > 80) send(); else timer = setTimeout(send, 80);
  }

  document.addEventListener("change", event => {
    const element = event.target;
    if (element.matches("select[data-for]")) set(element.dataset.for, {value: element.value});
  });
  document.addEventListener("input", event => {
    if (event.target.matches("input[type=range]")) slide(event.target);
  });
  document.addEventListener("click", event => {
    const pin = event.target.closest("button.pin");
    if (!pin) return;
    const on = pin.getAttribute("aria-pressed") !== "true";
    pin.setAttribute("aria-pressed", String(on));
    set(pin.dataset.for, {value: on ? "on" : ""});
  });

  /* Names for what Dash leaves without, and selects that show what their hidden inputs hold. */
  let arrived = location.hash.startsWith("#s=") ? location.hash : "";
  function dress() {
    if (arrived && part("do-add")) {
      const address = arrived;
      arrived = "";
      setTimeout(() => set("opened", {data: address}), 0);
    }
    for (const range of document.querySelectorAll("input[type=range]:not([aria-label])")) {
      const field = range.closest("label");
      range.setAttribute("aria-label", field.firstElementChild.textContent + ", slider");
      range.tabIndex = 0;
    }
    for (const text of document.querySelectorAll(".pair input[type=text]:not([aria-label])")) {
      text.setAttribute("aria-label", text.closest("label").firstElementChild.textContent);
    }
    for (const file of document.querySelectorAll(".upload input[type=file]:not([aria-label])")) {
      file.setAttribute("aria-label", file.parentElement.textContent);
    }
    for (const select of document.querySelectorAll("select[data-options]")) {
      const pairs = JSON.parse(select.dataset.options);
      delete select.dataset.options;
      select.replaceChildren(...pairs.map(([key, text]) => new Option(text, key)));
    }
    for (const select of document.querySelectorAll("select[data-for]")) {
      const held = part(select.dataset.for);
      if (held && held.value !== select.value) choose(select, held.value);
    }
  }
  window.addEventListener("hashchange", () => {
    if (!location.hash.startsWith("#s=")) return;
    if (part("do-add")) set("opened", {data: location.hash + " " + Date.now()}); else arrived = location.hash;
  });
  new MutationObserver(dress).observe(document.documentElement, {
    subtree: true, childList: true, attributes: true, attributeFilter: ["value"],
  });

  function options(select, pairs, value) {
    const now = [...select.options].map(option => option.value + "=" + option.text).join();
    if (now !== pairs.map(pair => pair.join("=")).join()) {
      select.replaceChildren(...pairs.map(([key, text]) => new Option(text, key)));
    }
    const held = part(select.dataset.for);
    if (held.value !== value) set(held.id, {value});
    select.value = value;
  }

  function extend(id, names) {
    const select = part("s-c-" + id);
    for (const name of names) {
      if (![...select.options].some(option => option.value === name)) select.add(new Option(name, name));
    }
  }

  window.uwoptExplore = {
    follow: (address, marked, extra, state) => {
      dress();
      if (address) history.replaceState(null, "", "#s=" + address);
      for (const note of document.querySelectorAll("p.fault")) note.hidden = true;
      for (const field of document.querySelectorAll("[aria-invalid]")) field.removeAttribute("aria-invalid");
      for (const [id, text] of marked || []) {
        const note = part("f-" + id), field = part("c-" + id);
        note.textContent = text;
        note.hidden = false;
        field.setAttribute("aria-invalid", "true");
      }
      if (!extra || !extra.systems) return;
      window.uwoptLamps.follow(extra.rig);
      options(part("s-c-shown"), extra.systems.map((name, n) => [String(n), name]), String(extra.shown));
      options(part("s-c-scene"), extra.scenes.map((name, n) => [String(n), name]), String(extra.scene));
      part("scene-field").hidden = extra.scenes.length < 2;
      for (const id of ["m-scene-water", "m-scene-seafloor", "s-light-spectrum"]) extend(id, extra.files);
      for (const kind of Object.keys(extra.parts)) extend("s-" + kind, extra.parts[kind]);
    },
  };
})();

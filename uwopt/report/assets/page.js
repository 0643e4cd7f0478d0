/* The report's behaviour: theme, tabs, plots drawn when they are looked at, print, download. */
(() => {
"use strict";
const root = document.documentElement;
const data = JSON.parse(document.getElementById("data").textContent);
const dark = matchMedia("(prefers-color-scheme: dark)");
const themeButton = document.getElementById("theme");
const config = {responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"]};
const pending = new Map();  // element -> what draws it
const themed = [];  // what follows the theme beyond CSS
root.classList.add("js");

const colour = (name) => getComputedStyle(root).getPropertyValue("--" + name).trim();
const isDark = () => (root.dataset.theme || (dark.matches ? "dark" : "light")) === "dark";

function dressed(layout) {
  const base = {
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", autosize: true, separators: ".\u2009",
    font: {family: getComputedStyle(document.body).fontFamily, size: 12, color: colour("ink")},
    margin: {l: 64, r: 16, t: 24, b: 52}, hoverlabel: {align: "left", bgcolor: "#16212b", font: {color: "#ffffff"}},
  };
  const made = {...base, ...layout, font: {...base.font, ...(layout.font || {}), color: colour("ink")}};
  made.margin = {...base.margin, ...(layout.margin || {})};
  for (const key of Object.keys(made)) {
    if (/^[xy]axis\d*$/.test(key)) made[key] = {automargin: true, linecolor: colour("muted"), ...made[key]};
  }
  return made;
}

function note(element, text) {
  element.replaceChildren(Object.assign(document.createElement("p"), {className: "plot-note", textContent: text}));
}

/* the plot library: packed in the page, unpacked when the first plot is looked at */
async function unpacked(base64) {
  const letters = atob(base64), bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip")));
}
let library = null;
function withLibrary() {
  library ??= (async () => {
    const code = document.createElement("script");
    code.textContent = await (await unpacked(document.getElementById("plots").textContent)).text();
    document.head.append(code);
    if (!window.Plotly) throw new Error("the plot library did not start");
    root.dataset.plots = "ready";
  })();
  return library;
}

async function draw(element) {
  const make = pending.get(element);
  if (!make) return;
  pending.delete(element);
  watcher.unobserve(element);
  try {
    if (!window.Plotly) await withLibrary();
    await make(element);
    element.dataset.drawn = "true";
  } catch (fault) {
    note(element, "This plot could not be drawn by this browser; the tables hold its numbers. (" + fault.message + ")");
    element.dataset.drawn = "failed";
  }
}

const watcher = new IntersectionObserver(
  (entries) => entries.filter((e) => e.isIntersecting).forEach((e) => draw(e.target)), {rootMargin: "300px"});

function later(element, make) {
  pending.set(element, make);
  watcher.observe(element);
}

const visible = (element) => element.getClientRects().length > 0;
const whenIdle = window.requestIdleCallback || ((work) => setTimeout(work, 60));
async function drawRest() {  // what is off the screen, one by one while nothing else is to do
  const next = [...pending.keys()].find(visible);
  if (next) { await draw(next); whenIdle(drawRest); }
}

function plot(element, traces, layout) {
  element.classList.add("plot");
  return Plotly.newPlot(element, traces, dressed(layout), config);
}

window.uwopt = {data, colour, isDark, later, plot, note, themed, visible, markScrolling};

/* theme */
function showTheme() {
  themeButton.setAttribute("aria-pressed", String(isDark()));
  themed.forEach((follow) => follow());
}
themeButton.addEventListener("click", () => {
  root.dataset.theme = isDark() ? "light" : "dark";
  showTheme();
});
dark.addEventListener("change", showTheme);

/* tabs: panels become tabs only where scripts run */
document.querySelectorAll("[data-tabs]").forEach((group, g) => {
  const panels = [...group.children];
  if (panels.length < 2) return;
  const list = document.createElement("div");
  list.setAttribute("role", "tablist");
  list.setAttribute("aria-label", group.dataset.tabs);
  const tabs = panels.map((panel, index) => {
    const tab = document.createElement("button");
    tab.type = "button";
    tab.id = "tab-" + g + "-" + index;
    tab.textContent = panel.dataset.label;
    tab.setAttribute("role", "tab");
    tab.setAttribute("aria-controls", panel.id = "panel-" + g + "-" + index);
    panel.setAttribute("role", "tabpanel");
    panel.setAttribute("aria-labelledby", tab.id);
    panel.tabIndex = 0;
    list.append(tab);
    return tab;
  });
  const show = (index, focus) => {
    tabs.forEach((tab, other) => {
      tab.setAttribute("aria-selected", String(other === index));
      tab.tabIndex = other === index ? 0 : -1;
      panels[other].hidden = other !== index;
    });
    if (focus) tabs[index].focus();
    group.dispatchEvent(new Event("shown"));
    panels[index].querySelectorAll("[data-drawn='true']").forEach((p) => p.data && Plotly.Plots.resize(p));
    markScrolling();
  };
  tabs.forEach((tab, index) => tab.addEventListener("click", () => show(index, false)));
  list.addEventListener("keydown", (event) => {
    const at = tabs.indexOf(event.target), last = tabs.length - 1;
    const to = {ArrowRight: at === last ? 0 : at + 1, ArrowLeft: at === 0 ? last : at - 1, Home: 0, End: last}[event.key];
    if (at >= 0 && to !== undefined) { event.preventDefault(); show(to, true); }
  });
  group.prepend(list);
  show(0, false);
});

/* tables wider than the page can be scrolled by keyboard */
function markScrolling() {
  document.querySelectorAll(".scroll").forEach((box) => {
    const wide = box.scrollWidth > box.clientWidth + 1 || box.scrollHeight > box.clientHeight + 1;
    if (wide) {
      box.tabIndex = 0;
      box.setAttribute("role", "region");
      box.setAttribute("aria-label", box.querySelector("caption").textContent);
    } else {
      ["tabindex", "role", "aria-label"].forEach((name) => box.removeAttribute(name));
    }
  });
}
markScrolling();
addEventListener("resize", markScrolling);

/* figures */
document.querySelectorAll("[data-figure]").forEach((element) => {
  const figure = data.figures[element.dataset.figure];
  if (!figure) return;
  const {height, width, ...layout} = figure.layout || {};  // the width is the page's
  if (height) element.style.height = height + "px";
  later(element, (here) => plot(here, figure.data, layout));
});

/* where one is */
/* what is folded opens when a link leads to it */
function unfold() {
  const fold = location.hash && document.getElementById(location.hash.slice(1))?.querySelector(":scope > details.fold");
  if (fold) fold.open = true;
}
addEventListener("hashchange", unfold);
unfold();

const links = new Map([...document.querySelectorAll(".contents a")].map((a) => [a.hash.slice(1), a]));
const here = new IntersectionObserver((entries) => entries.forEach((e) => {
  if (!e.isIntersecting) return;
  links.forEach((a) => a.removeAttribute("aria-current"));
  links.get(e.target.id)?.setAttribute("aria-current", "true");
}), {rootMargin: "-20% 0px -70% 0px"});
links.forEach((_, id) => { const part = document.getElementById(id); if (part) here.observe(part); });

/* print: open what is folded or behind a tab, draw everything, let plots scale with the paper */
let onPaper = false;
function toPaper() {
  if (onPaper) return;
  onPaper = true;
  document.querySelectorAll("details.whole:not([open])").forEach((d) => { d.open = true; d.dataset.folded = "true"; });
  document.querySelectorAll(".tabs > .panel[hidden]").forEach((p) => { p.hidden = false; p.dataset.folded = "true"; });
  [...pending.keys()].filter(visible).forEach(draw);
  document.querySelectorAll(".plot .svg-container").forEach((box) => {
    box.style.aspectRatio = box.clientWidth + " / " + box.clientHeight;
    box.querySelectorAll(".main-svg").forEach((svg) => {
      const width = svg.getAttribute("width"), height = svg.getAttribute("height");
      if (width && height) svg.setAttribute("viewBox", "0 0 " + parseFloat(width) + " " + parseFloat(height));
    });
  });
}
function fromPaper() {
  onPaper = false;
  document.querySelectorAll("details[data-folded]").forEach((d) => { d.open = false; delete d.dataset.folded; });
  document.querySelectorAll(".panel[data-folded]").forEach((p) => { p.hidden = true; delete p.dataset.folded; });
  document.querySelectorAll(".plot .svg-container").forEach((box) => {
    box.style.aspectRatio = "";
    box.querySelectorAll(".main-svg").forEach((svg) => svg.removeAttribute("viewBox"));
  });
}
document.getElementById("print").addEventListener("click", () => print());
addEventListener("beforeprint", toPaper);
addEventListener("afterprint", fromPaper);
matchMedia("print").addEventListener("change", (paper) => paper.matches ? toPaper() : fromPaper());

/* the result itself: unpacked where the browser can, else as it is */
const raw = document.getElementById("raw");
raw.addEventListener("click", async (event) => {
  if (!window.DecompressionStream || raw.dataset.busy) return;
  event.preventDefault();
  raw.dataset.busy = "true";
  try {
    const content = await (await unpacked(raw.href.split(",", 2)[1])).arrayBuffer();
    const blob = new Blob([content], {type: "application/json"});
    const link = Object.assign(document.createElement("a"), {href: URL.createObjectURL(blob), download: raw.dataset.name});
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  } finally {
    delete raw.dataset.busy;
  }
});

if (data.front) showFront(window.uwopt);
showTheme();
addEventListener("load", () => {
  if (pending.size) withLibrary().catch(() => {});  // print cannot wait for it
  whenIdle(drawRest);
});
})();

// The page: takes what the server sends into one view, and draws the view.

import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { METHODS, NAMES } from "./methods.js";
import { DENSITIES, curvesShown, legend, makePanels } from "./panels.js";
import { Phase } from "./phase.js";
import { Scene } from "./scene.js";
import { State, lengthScale } from "./state.js";
import { Table, gapOf, gapText, isSilent, isTransient } from "./table.js";
import { Track } from "./track.js";
import { copy, csv, png, save, say } from "./share.js";
import { grouped, short, typeset, withError, withErrorHtml } from "./numbers.js";
import { onTheme, palette, startTheme } from "./theme.js";

const element = (id) => document.getElementById(id);
const SHOWN_RADIANS = 40; // of the path, in 1/Omega
const TRACES_EVERY = 28; // ms

const state = new State();
const connection = new Connection(state);
const track = new Track();

const view = {
  track, state,
  drawn: new Set(["averaging_printed"]),
  low: 0, high: 3, fastest: 3, peak: {},
  theory: null, growth: null, curve: null,
  old: { theory: false, growth: false, curve: false }, // which of these three answer a question of before
  measured: null, densities: null, grown: null, marker: null, copies: null,
  get values() { return state.values; },
  get si() { return state.units === "si"; },
  timeWindow() {
    const wide = SHOWN_RADIANS / state.values.natural_frequency;
    return track.now.t > wide ? [track.now.t - wide, track.now.t] : [0, wide];
  },
};
let chosenByHand = false; // which methods are drawn
let playing = true;
let question = null; // the newest
const answered = {}; // what theory, growth and curve depend on, when they came
const dirty = new Set();

startTheme(element("theme"));
const controls = new Controls(state, element("form"));
const scene = new Scene(element("scene"), track);
const phase = new Phase(element("phase"), track, () => (matchMedia("(max-width: 700px)").matches ? 300 : 318));
const panels = makePanels(view, element, { onOrder: (order) => state.set({ order }) });
const table = new Table(element("table"), element("warnings"), element("silent"), view.drawn, () => { chosenByHand = true; drawnChanged(); });

// --- answers -------------------------------------------------------------------------------------------------------

const on = (kind, handle) => connection.addEventListener(kind, (event) => handle(event.detail));

on("connection", ({ open, text, reason }) => {
  status(open ? "live" : "off", open ? "connected" : text);
  notice("connection", reason ? `The server ended the connection: ${reason}` : open ? "" : connection.failures ? "No connection to the server: is springpot explore still running? Trying again…" : "");
});
on("status", ({ theory, kernel }) => {
  if (kernel) status("live", "live");
  else status("loading", theory ? "loading the kernel (the first time it is compiled)…" : "loading theory and kernel…");
});
on("asked", (problem) => {
  question = problem;
  track.restart();
  Object.assign(view, { measured: null, densities: null, grown: null, copies: null });
  for (const [kind, matters] of Object.entries(dependsOn(question))) view.old[kind] = view[kind] !== null && answered[kind] !== matters;
  if (view.old.curve) view.marker = null;
  element("tile-paths-note").textContent = "\u00a0";
  showOld();
});
on("accepted", (message) => { view.copies = message; notice("question", ""); });
on("refused", ({ sentence }) => notPossible(sentence));
on("trouble", ({ sentence }) => notPossible(sentence));
on("searching", () => { element("tile-paths-note").textContent = "finding the stationary start…"; });
on("theory", (message) => {
  if (!chosenByHand) {
    view.drawn.clear();
    const best = message.recommended;
    for (const name of [best, best === "averaging" ? "averaging_printed" : "averaging"]) if (name && message.methods[name]) view.drawn.add(name);
  }
  take("theory", message);
  setBounds();
});
on("growth", (message) => take("growth", message));
on("curve", (message) => take("curve", message));
on("estimates", (message) => {
  view.measured = message;
  view.marker = { order: question.order, value: message.values.amplitude_mean_square, error: message.errors.amplitude_mean_square };
  for (const name of ["numbers", "curve"]) dirty.add(name);
});
on("densities", ({ arrays }) => {
  view.densities = {};
  Object.keys(DENSITIES).forEach((name, i) => { view.densities[name] = { edges: arrays[2 * i], density: arrays[2 * i + 1] }; });
  for (const name of Object.keys(DENSITIES)) dirty.add(name);
});
on("grown", ({ arrays: [mean, error] }) => { view.grown = { mean, error }; dirty.add("growth"); });
on("motion", ({ arrays }) => {
  const hits = track.take(arrays);
  if (hits) for (const hit of track.hits.slice(-Math.min(hits, 4))) scene.flash(hit.speed);
  stretch(arrays[1], arrays[2]);
  dirty.add("motion");
});

// neither seed nor paths matter to any of them
function dependsOn({ order, start, coefficient, natural_frequency, intensity, wall, position, restitution }) {
  const all = [coefficient, natural_frequency, intensity, ...(wall ? [position, restitution] : [])];
  return { theory: String([...all, order]), growth: String([...all, order, start]), curve: String(all) };
}

function take(kind, message) {
  view[kind] = message;
  view.old[kind] = false;
  answered[kind] = dependsOn(question)[kind];
  showOld();
}

// what belongs to a question of before is grey, and not to be had as a file
function showOld() {
  for (const card of document.querySelectorAll("[data-chart]")) {
    const old = Boolean(view.old[DENSITIES[card.dataset.chart] ? "theory" : card.dataset.chart]);
    card.classList.toggle("old", old);
    for (const button of card.querySelectorAll(".tool")) button.disabled = old;
  }
  drawnChanged();
}

// nothing will come in the place of what is old
function notPossible(sentence) {
  notice("question", `Not possible: ${typeset(sentence, view.si)}`);
  if (!view.measured) view.marker = null;
  element("tile-paths-note").textContent = "\u00a0";
  for (const kind of Object.keys(view.old)) {
    if (view.old[kind]) view[kind] = null;
    view.old[kind] = false;
  }
  setBounds();
  showOld();
}

function setBounds() {
  const places = view.theory?.places ?? {}, { values } = state;
  if (places.x) {
    [view.low, view.high] = [places.x[0], places.x[places.x.length - 1]];
    view.fastest = places.v[places.v.length - 1];
  } else {
    const scale = lengthScale(values);
    view.low = values.wall ? values.position : -3 * scale;
    view.high = (values.wall ? Math.max(values.position, 0) : 0) + 3 * scale;
    view.fastest = 3 * scale * values.natural_frequency;
  }
}

// rare large motions, and growing ones, make room for themselves
function stretch(x, v) {
  const slack = 0.15 * (view.high - view.low);
  for (const value of x) {
    if (value > view.high) view.high = value + slack;
    if (value < view.low - 1e-3 * slack && !(state.values.wall && value >= state.values.position - slack)) view.low = value - slack;
  }
  for (const value of v) if (Math.abs(value) > view.fastest) view.fastest = 1.15 * Math.abs(value);
}

// --- drawing -------------------------------------------------------------------------------------------------------

// the answer to trust, if there is one to this question
const trusted = () => (view.old.theory ? null : view.theory?.methods[view.theory.recommended]);

function rmsSpeed() {
  const square = (trusted()?.moments ?? view.measured?.values)?.v_mean_square;
  return square > 0 ? Math.sqrt(square) : view.fastest / 3;
}

const unitsOf = () => (view.si ? { length: "m", speed: "m/s" } : { length: "", speed: "" });
const boundsOf = () => [Math.min(view.low, view.values.wall ? view.values.position : view.low), view.high];

function drawMotion() {
  scene.draw({ values: view.values, unit: unitsOf().length, bounds: boundsOf(), rms: rmsSpeed() });
  const time = track.now.t ?? 0, [since, until] = view.timeWindow();
  const places = Math.min(Math.max(Math.round(2.6 - Math.log10(until - since)), 0), 8); // a tenth of a second in 40
  element("clock").textContent = track.path === null ? "" : `path ${grouped(track.path)} · ${view.si ? "t" : "Ωt"} = ${time.toFixed(places)}${view.si ? " s" : ""} of ${short(track.end, 4)}`;
}

function drawTraces() {
  const units = unitsOf(), bounds = boundsOf(), pad = 0.04 * (bounds[1] - bounds[0]);
  phase.draw({
    values: view.values, bounds: [bounds[0] - pad, bounds[1]], fastest: view.fastest, units,
    mu: view.measured?.values.amplitude_mean_square ?? trusted()?.moments.amplitude_mean_square ?? 0,
    window: SHOWN_RADIANS / view.values.natural_frequency,
  });
  panels.traceX.update();
  panels.traceV.update();
}

function drawNumbers() {
  const { measured, si } = view, old = view.old.theory;
  const unit = (text) => (si ? ` <small>${text}</small>` : "");
  table.show(view.theory, measured, si, old);
  element("tile-theory").classList.toggle("stale", old);
  const best = view.theory?.recommended, answer = best && view.theory.methods[best];
  element("tile-theory-name").textContent = best ? METHODS[best].label : "";
  element("tile-theory").innerHTML = answer ? short(answer.moments.amplitude_mean_square) + unit("m²") : "–";
  const value = measured?.values.amplitude_mean_square, error = measured?.errors.amplitude_mean_square;
  const gap = answer && measured && !old && !isTransient(measured) ? gapText(gapOf(answer.moments.amplitude_mean_square, value, error)) : "";
  element("tile-theory-note").textContent = gap ? `gap ${gap}` : isTransient(measured) && best && !old ? "stationary; the run is not" : view.theory && !best && !old ? (isSilent(view.theory) ? "no stationary answer" : "no method to trust here") : "\u00a0";
  element("tile-measured").innerHTML = measured ? withErrorHtml(value, error, unit("m²")) : "–";
  element("tile-measured-note").textContent = measured ? `± one standard error, t > ${short(measured.settings.window[0], 3)}${si ? " s" : ""}` : "\u00a0";
  element("tile-rate").innerHTML = measured ? withErrorHtml(measured.values.impact_rate, measured.errors.impact_rate, unit("1/s")) : "–";
  element("tile-rate-note").textContent = answer && !old && view.values.wall ? `${METHODS[best].label}: ${short(answer.moments.impact_rate)}` : "\u00a0";
  element("tile-paths").textContent = measured ? grouped(measured.paths) : "0";
  element("progress").value = measured ? measured.paths / measured.of : 0;
  if (measured) {
    const steps = measured.paths * Math.round(measured.settings.duration / measured.settings.step);
    element("tile-paths-note").textContent = measured.complete ? `done: ${short(steps, 2)} steps in ${short(measured.seconds, 2)} s` : `of ${grouped(measured.of)}${playing ? "" : ": paused"}`;
  } else if (!playing) element("tile-paths-note").textContent = "paused: Play or Step";
  if (measured?.complete && !old && view.spoken !== connection.generation) {
    view.spoken = connection.generation;
    element("spoken").textContent = `Monte Carlo ${withError(value, error)}${answer ? `, ${METHODS[best].label} ${short(answer.moments.amplitude_mean_square)}` : ""}.`;
  }
  element("results").dataset.complete = String(Boolean(measured?.complete && view.theory) && !old);
  element("results").dataset.generation = String(connection.generation);
}

function drawnChanged() {
  const drawn = NAMES.filter((name) => view.drawn.has(name) && view.theory?.methods[name]);
  element("curve-legend").innerHTML = legend(curvesShown(view));
  element("density-legend").innerHTML = element("growth-legend").innerHTML = legend(drawn);
  const front = drawn.includes(view.theory?.recommended) ? view.theory.recommended : drawn[0];
  const height = front && view.theory.methods[front].densities.x;
  scene.density = height && !view.old.theory ? { place: view.theory.places.x, height: height.map((h) => h ?? 0) } : null;
  scene.density_color = front ?? "envelope";
  for (const name of [...Object.keys(DENSITIES), "growth", "curve", "motion", "numbers"]) dirty.add(name);
}

const drawings = {
  motion: drawMotion, traces: drawTraces, numbers: drawNumbers,
  ...Object.fromEntries([...Object.keys(DENSITIES), "growth", "curve"].map((name) => [name, () => panels[name].update()])),
};

let drawnFrames = 0, tracesAt = 0;
function frame(now) {
  if (scene.canvas.changed || phase.canvas.changed || scene.flashes.length) dirty.add("motion");
  scene.canvas.changed = phase.canvas.changed = false;
  if (dirty.has("motion")) {
    drawnFrames += 1;
    dirty.add("traces");
  }
  const due = [...dirty];
  dirty.clear();
  for (const name of due) {
    // 60 times a second for the mass, half as often for the charts that scroll
    if (name === "traces" && now - tracesAt < TRACES_EVERY) dirty.add(name);
    else drawings[name]();
    if (name === "traces" && !dirty.has(name)) tracesAt = now;
  }
  requestAnimationFrame(frame);
}

onTheme(() => { for (const name of Object.keys(drawings)) dirty.add(name); });

// --- what a person does --------------------------------------------------------------------------------------------

function status(kind, text) {
  element("status").dataset.state = kind;
  element("status").textContent = text;
}

// each origin has its own: what the connection has to say does not take back what was wrong with a link
const notices = { link: "", connection: "", question: "" };
function notice(origin, text) {
  if (notices[origin] === text) return;
  notices[origin] = text;
  const said = Object.values(notices).filter(Boolean).map((sentence) => Object.assign(document.createElement("p"), { textContent: sentence }));
  element("banner").replaceChildren(...said);
  element("banner").hidden = !said.length;
}

const speedOf = (place) => 0.2 * 500 ** (place / 100); // from 0.2 to 100
function setSpeed() {
  const speed = Number(speedOf(Number(element("speed").value)).toPrecision(2));
  element("speed-shown").textContent = `${speed} /Ω per s`;
  element("speed").setAttribute("aria-valuetext", `${speed} over Omega per second`);
  connection.setPlay({ playing, speed });
}

function setPlaying(now) {
  playing = now;
  element("play").textContent = playing ? "Pause" : "Play";
  element("play").setAttribute("aria-pressed", String(playing));
  dirty.add("numbers");
  setSpeed();
}

element("play").addEventListener("click", () => setPlaying(!playing));
element("step").addEventListener("click", () => { if (playing) setPlaying(false); connection.step(); });
element("reset").addEventListener("click", () => connection.ask(true));
element("next").addEventListener("click", () => connection.nextPath());
element("speed").addEventListener("input", setSpeed);
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.target.closest("input, select, textarea, button, summary, a, [contenteditable]")) return;
  const button = { " ": "play", ".": "step", r: "reset", n: "next" }[event.key];
  if (!button) return;
  event.preventDefault();
  element(button).click();
});

const described = () => {
  const v = state.values;
  const wall = v.wall ? `b = ${v.position}, r = ${v.restitution}` : "no wall";
  return `alpha = ${v.order}, C = ${v.coefficient}, Omega = ${v.natural_frequency}, q = ${v.intensity}, ${wall}, start ${v.start}, seed ${v.seed}, ${v.paths} paths${view.si ? "" : " (dimensionless)"}`;
};
const fileName = (name, kind) => `springpot-${name}.${kind}`;
const note = element("copied");
element("copy-link").addEventListener("click", () => copy(location.origin + location.pathname + state.link(), "Link copied.", note));
const copyOf = (kind, said) => (view.copies ? copy(view.copies[kind], said, note) : say("Not copied: the server has not taken these numbers.", note));
element("copy-python").addEventListener("click", () => copyOf("python", "Python copied."));
element("copy-command").addEventListener("click", () => copyOf("command", "Command copied."));
element("save-csv").addEventListener("click", () => {
  const { theory, measured } = view, rows = [];
  for (const [name, value] of Object.entries(measured?.values ?? {})) rows.push(["monte_carlo", name, value, measured.errors[name]]);
  for (const [method, answer] of Object.entries((!view.old.theory && theory?.methods) || {})) {
    for (const [name, value] of Object.entries(answer.moments)) rows.push([method, name, value, ""]);
  }
  const columns = ["method", "quantity", "value", "standard_error"].map((name, i) => [name, rows.map((row) => row[i] ?? "")]);
  save(fileName("numbers", "csv"), csv(described(), columns));
});

// each card gets its two buttons
const CHARTS = { traces: ["traceX", "traceV"], growth: ["growth"], curve: ["curve"], ...Object.fromEntries(Object.keys(DENSITIES).map((name) => [name, [name]])) };
for (const card of document.querySelectorAll("[data-chart]")) {
  const name = card.dataset.chart, title = card.querySelector("h2, h3").textContent;
  const heading = DENSITIES[name] ? `Density of the ${title.toLowerCase()}` : title;
  const tools = document.createElement("span");
  tools.className = "tools";
  if (CHARTS[name]) {
    tools.append(tool("CSV", `${title} as CSV`, () => save(fileName(name, "csv"), csv(described(), panels[CHARTS[name][0]].columns()))));
  }
  tools.append(tool("PNG", `${title} as PNG`, async () => {
    const canvases = [];
    for (const key of CHARTS[name] ?? []) canvases.push(await panels[key].snapshot(720, CHARTS[name].length > 1 ? 230 : 400));
    const colours = { page: palette.panel, text: palette.text, muted: palette.muted };
    save(fileName(name, "png"), png(canvases.length ? canvases : [phase.canvas.element], heading, described(), lines(name), colours));
  }));
  card.querySelector(".card-head").append(tools);
}

function lines(name) {
  if (!DENSITIES[name] && name !== "growth" && name !== "curve") return [];
  const shown = name === "curve" ? curvesShown(view) : NAMES.filter((method) => view.drawn.has(method) && view.theory?.methods[method]);
  return [
    { label: "Monte Carlo", color: palette.measured, dash: [], box: true },
    ...shown.map((method) => ({ label: METHODS[method].label, color: palette[method], dash: METHODS[method].dash })),
  ];
}

function tool(text, label, act) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "tool";
  button.textContent = text;
  button.setAttribute("aria-label", label);
  button.title = label;
  button.addEventListener("click", act);
  return button;
}

// --- begin ---------------------------------------------------------------------------------------------------------

let linkTimer = null;
let linkShown = "";
function takeLink() {
  const unsound = state.readLink(location.hash);
  notice("link", !unsound.length ? "" : `The link holds what cannot be: ${unsound.join(", ")}. The usual values were taken instead.`);
}
let unitsShown = null;
state.onChange(() => {
  element("law").hidden = !state.values.wall;
  notice("link", "");
  if (unitsShown !== state.units) {
    unitsShown = state.units;
    for (const panel of Object.values(panels)) panel?.relabel();
    dirty.add("numbers");
  }
  clearTimeout(linkTimer);
  linkTimer = setTimeout(() => {
    linkShown = state.link();
    if (location.hash !== linkShown) history.replaceState(null, "", linkShown);
  }, 250);
  connection.ask();
});
addEventListener("hashchange", () => { if (location.hash !== linkShown) takeLink(); });
takeLink();
setSpeed();
if (matchMedia("(max-width: 900px)").matches) element("controls").open = false;
connection.open();
requestAnimationFrame(frame);

// for whoever measures the page
window.springpotExplorer = { get frames() { return connection.frames; }, get drawn() { return drawnFrames; }, get time() { return track.now.t; }, get generation() { return connection.generation; } };

// The page: takes what the server sends into one view, and draws the view.

import { boundsOf, outOfView, setBounds, stretch } from "./bounds.js";
import { Connection } from "./connection.js";
import { Controls, goTo } from "./controls.js";
import { METHODS, NAMES } from "/methods.js";
import { DENSITIES, addDensityCards, curvesShown, legend, makePanels, saidOf } from "./panels.js";
import { Phase } from "./phase.js";
import { showPinned, snapshot } from "./pinned.js";
import { OPENED, ORDERS, POINTS, circuitsOf, hasWalls, ends, isSeveral, isSoft, isThermal, linksOf, orderOf, wallsOf } from "./problem.js";
import { Scene } from "./scene.js";
import { makePartsCard, showEquation } from "./parts.js";
import { DEFAULTS, State } from "./state.js";
import { Table, fadeWhereCut, isTransient } from "./table.js";
import { showTiles } from "./tiles.js";
import { Track } from "./track.js";
import { startSaving } from "./saving.js";
import { save } from "./share.js";
import { grouped, short, typeset, withError } from "./numbers.js";
import { onTheme, startTheme } from "./theme.js";
import { unitOf } from "./units.js";

const element = (id) => document.getElementById(id);
const SHOWN_RADIANS = 40; // of the path, in 1/Omega
const TRACES_EVERY = 28; // ms
const QUIET = 1500; // ms after the first answer, until the cards below are loaded: they are there when the page is printed

const state = new State();
const connection = new Connection(state);
const track = new Track(POINTS.length);

const view = {
  track, state,
  drawn: new Set(),
  reach: [], // of what can be followed: how far and how fast it goes, and its walls
  chosen: OPENED.followed[0].name, // of it: what the large numbers and the charts of the path show
  peak: {},
  theory: null, growth: null, curve: null,
  failed: false, // no answer will come
  old: { theory: false, growth: false, curve: false }, // which of these three answer a question of before
  measured: null, densities: null, grown: null, marker: null, copies: null, pin: null,
  sizes: OPENED.sizes, // how fast and how far the mass moves, roughly
  followed: OPENED.followed,
  groups: OPENED.groups, // tables of results
  equation: [], equations: [], // of several masses one of each
  excitation: [], // its charts
  get seen() { return this.reach.find(({ name }) => name === this.chosen) ?? this.reach[0]; },
  get values() { return state.values; },
  get frequency() { return this.sizes.frequency; },
  get walls() { return wallsOf(state.values); },
  // the time from which on averages are taken
  after(time) { return `${state.si ? "t" : "Ωt"} > ${short(time * unitOf("time", state).factor, 3)}${state.si ? " s" : ""}`; },
  timeWindow() {
    const wide = SHOWN_RADIANS / this.frequency;
    return track.now.t > wide ? [track.now.t - wide, track.now.t] : [0, wide];
  },
};
let chosenByHand = false; // which methods are drawn
let playing = true;
let compiling = false; // the kernel
let question = null; // the newest
const answered = {}; // what theory, growth and curve depend on, when they came
const dirty = new Set();

startTheme(element("theme"));
for (const one of document.querySelectorAll(isSeveral ? ".of-one" : ".of-several")) one.hidden = true;
for (const one of document.querySelectorAll(isSeveral ? ".of-several" : ".of-one")) one.hidden = false;
addDensityCards(element("densities"));
setBounds(view);
const controls = new Controls(state, element("form"));
const scene = new Scene(element("scene"), track);
const phase = new Phase(element("phase"), track, () => (matchMedia("(max-width: 700px)").matches ? 300 : 318));
const panels = makePanels(view, element, { onOrder: (order) => state.set(Object.fromEntries(ORDERS.map((name) => [name, order]))) });
const partsCard = makePartsCard(element("parts-table"));
const table = new Table(element("table"), element("warnings"), element("silent"), view.drawn, () => { chosenByHand = true; drawnChanged(); });

// what stands far below is loaded when it comes near
let excitationCard = null, below = null;
const loadBelow = () => { below ??= makeBelow(); return below; };
async function makeBelow() {
  document.head.append(Object.assign(document.createElement("link"), { rel: "stylesheet", href: "/static/below.css" }));
  const [{ ExcitationCard, RequestsCard }, { RareCard }, { ScatterCard }, { FitCard }] = await Promise.all([import("./requests.js"), import("./rare.js"), import("./scatter.js"), import("./fit.js"), import("./drawn.js"), import("./files.js")]);
  new FitCard(element, connection, controls);
  new RequestsCard(element, connection, state);
  new RareCard(element, connection, state);
  new ScatterCard(element, connection, state, controls);
  excitationCard = new ExcitationCard(element, connection, state);
  excitationCard.show(view.excitation, state);
  showJumps();
}
new IntersectionObserver((seen) => { if (seen.some(({ isIntersecting }) => isIntersecting)) loadBelow(); }, { rootMargin: "400px" }).observe(element("asked"));

// to a part of the page: what stands above it has its height first
const jumps = [...document.querySelectorAll("[data-to]")];
for (const jump of jumps) {
  jump.addEventListener("click", async () => {
    await loadBelow();
    element(jump.dataset.to).scrollIntoView({ block: "start" });
  });
}
function showJumps() { for (const jump of jumps) jump.hidden = element(jump.dataset.to).hidden; }
new ResizeObserver(() => document.documentElement.style.setProperty("--head", `${document.querySelector(".top").offsetHeight}px`)).observe(document.querySelector(".top"));

// --- answers -------------------------------------------------------------------------------------------------------

const on = (kind, handle) => connection.addEventListener(kind, (event) => handle(event.detail));

on("connection", ({ open, text, reason }) => {
  status(open ? "live" : "off", open ? "connected" : text);
  notice("connection", reason ? `The server ended the connection: ${reason}` : open ? "" : connection.failures ? "No connection to the server: is springpot explore still running? Trying again…" : "");
});
on("status", ({ theory, kernel }) => {
  if (kernel) { if (!compiling) status("live", "live"); }
  else status("loading", theory ? "loading the simulation…" : "loading theory and simulation…");
});
on("compiling", () => {
  compiling = true;
  status("loading", "compiling, once for all systems…");
  element("tile-paths-note").textContent = "compiling, once for all systems…";
});
on("view", ({ equation, equations, sizes, paper, followed, groups, excitation }) => {
  excitationCard?.show(excitation, state);
  Object.assign(view, { sizes, followed, groups, excitation, equation, equations });
  showEquation(element, view);
  showChoice();
  state.paper = paper;
  showPaper();
  setSpeed();
  setBounds(view);
  drawnChanged();
});
on("file", ({ name, text }) => save(name, new Blob([text], { type: "application/toml" })));
on("asked", (problem) => {
  question = problem;
  compiled();
  track.restart();
  scene.deepest.clear();
  Object.assign(view, { measured: null, densities: null, grown: null, copies: null, failed: false });
  for (const [kind, matters] of Object.entries(dependsOn(question))) view.old[kind] = view[kind] !== null && answered[kind] !== matters;
  if (view.old.curve) view.marker = null;
  element("tile-paths-note").textContent = "\u00a0";
  showOld();
  drawNumbers(); // that theory is computing is seen at once
});
on("accepted", (message) => { view.copies = message; controls.showLaws(message.laws); notice("question", ""); });
on("refused", ({ sentence, asked }) => {
  if (asked === null) return notPossible(sentence);
  if (!connection.good) { // the numbers of a link
    state.set({ ...DEFAULTS });
    return notice("link", `The link's numbers are not possible: ${sentence} The usual ones are used.`);
  }
  // the last good state stays, and goes on; beside the number stands why
  if (!controls.refuse(sentence, connection.good)) notice("question", `Not possible: ${sentence}`);
});
on("trouble", ({ sentence }) => { compiled(); notPossible(sentence); });
on("searching", () => {
  compiled();
  element("tile-paths-note").textContent = "finding the stationary start…";
});
on("theory", (message) => {
  if (!chosenByHand) {
    view.drawn.clear();
    for (const name of message.drawn) view.drawn.add(name);
  }
  for (const { moments } of Object.values(message.methods)) addRoots(moments);
  take("theory", message);
  setBounds(view);
});
on("growth", (message) => take("growth", message));
on("curve", (message) => take("curve", message));
on("estimates", (message) => {
  const { values, errors } = message;
  addRoots(values, errors);
  compiled();
  view.measured = message;
  view.marker = { order: orderOf(connection.good, state.paper), value: message.values.amplitude_mean_square, error: message.errors.amplitude_mean_square };
  for (const name of ["numbers", "curve"]) dirty.add(name);
});
on("densities", ({ arrays }) => {
  view.densities = {};
  Object.keys(DENSITIES).forEach((name, i) => { view.densities[name] = { edges: arrays[2 * i], density: arrays[2 * i + 1] }; });
  if (view.measured?.undefined && !isSeveral) view.densities.impact_speed = { edges: [], density: [] }; // of as many as the step counts
  setBounds(view);
  drawnChanged();
});
on("grown", ({ arrays }) => {
  view.grown = Object.fromEntries(view.followed.map(({ name }, i) => [name, { mean: arrays[2 * i], error: arrays[2 * i + 1] }]));
  dirty.add("growth");
});
on("motion", ({ arrays }) => {
  const hits = track.take(arrays);
  if (hits) for (const hit of track.hits.slice(-Math.min(hits, 4))) scene.flash(hit);
  stretch(view, arrays[1], arrays[2]);
  dirty.add("motion");
});

function compiled() {
  if (compiling) status("live", "live");
  compiling = false;
}

function addRoots(values, errors) {
  for (const square of Object.keys(values)) {
    const name = square.replace(/((^|_)[xv]|_elongation)_mean_square$/, "$1_rms");
    if (name === square) continue;
    const root = values[name] = rootOf(values[square]);
    if (errors) errors[name] = root > 0 && errors[square] !== null ? errors[square] / (2 * root) : null;
  }
}
const rootOf = (square) => (square >= 0 && square !== null ? Math.sqrt(square) : null);

// neither seed nor paths matter to any of them
function dependsOn({ numbers, without, start }) {
  const left = Object.entries(numbers).filter(([name]) => !without.some((part) => name.startsWith(`${part}-`)));
  const all = JSON.stringify([left, without]);
  return { theory: all, growth: all + start, curve: JSON.stringify([left.filter(([name]) => !ORDERS.includes(name)), without]) };
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
    const coming = card.dataset.chart === "curve" && view.curve?.missing.length > 0;
    for (const button of card.querySelectorAll(".tool")) button.disabled = old || coming;
  }
  drawnChanged();
}

// nothing will come in the place of what is old
function notPossible(sentence) {
  notice("question", `Not possible: ${typeset(sentence)}`);
  view.failed = true;
  if (!view.measured) view.marker = null;
  element("tile-paths-note").textContent = "\u00a0";
  for (const kind of Object.keys(view.old)) {
    if (view.old[kind]) view[kind] = null;
    view.old[kind] = false;
  }
  setBounds(view);
  showOld();
}

// --- drawing -------------------------------------------------------------------------------------------------------

// the answer to trust, if there is one to this question
const trusted = () => (view.old.theory ? null : view.theory?.methods[view.theory.shown ?? view.theory.recommended]);

// of each mass
function rmsSpeeds() {
  return POINTS.map(({ name }, i) => {
    const square = (trusted()?.moments ?? view.measured?.values)?.[isSeveral ? `${name}_v_mean_square` : "v_mean_square"];
    return square > 0 ? Math.sqrt(square) : view.reach[i].fastest / 3;
  });
}

const unitsOf = () => ({ length: unitOf("x", state), speed: unitOf("v", state) });

function drawMotion() {
  const { values, walls, reach } = view, bounds = boundsOf(reach[0]), { length } = unitsOf();
  const hidden = scene.draw({ walls, reach, links: linksOf(values), circuits: circuitsOf(values), unit: length, bounds, rms: rmsSpeeds() });
  const far = outOfView(hidden, (position) => `${short(position * length.factor)} ${length.name}`);
  element("out-of-view").textContent = far;
  element("out-of-view").hidden = !far;
  const time = track.now.t ?? 0, [since, until] = view.timeWindow();
  const inUnits = unitOf("time", state).factor, places = Math.min(Math.max(Math.round(2.6 - Math.log10((until - since) * inUnits)), 0), 8); // a tenth of a second in 40
  element("clock").textContent = track.path === null ? "" : `path ${grouped(track.path)} · ${state.si ? "t" : "Ωt"} = ${(time * inUnits).toFixed(places)}${state.si ? " s" : ""} of ${short(track.end * inUnits, 4)}`;
}

function drawTraces() {
  const units = unitsOf(), bounds = boundsOf(view.seen), pad = 0.04 * (bounds[1] - bounds[0]);
  const { paper } = state, mu = paper && (view.measured?.values.amplitude_mean_square ?? trusted()?.moments.amplitude_mean_square);
  phase.draw({
    walls: view.seen.walls, bounds: [bounds[0] - pad, bounds[1] + pad], fastest: view.seen.fastest, units,
    ring: mu > 0 ? { radius: Math.sqrt(mu), frequency: paper.frequency } : null,
    window: SHOWN_RADIANS / view.frequency, said: ["x", "v"].map((what) => saidOf(view, what)),
  });
  panels.traceX.update();
  panels.traceV.update();
}

function drawNumbers() {
  const { measured, theory } = view, old = view.old.theory;
  table.show(view, old);
  partsCard(view);
  showTiles(view, element, playing);
  showPinned(view, element);
  showStart();
  element("pin").disabled = !measured?.complete || old;
  if (measured?.complete && !old && view.spoken !== connection.generation) {
    view.spoken = connection.generation;
    const { name: whose, title } = view.followed[0], name = `${whose}x_rms`;
    const { factor, name: unit } = unitOf(name, state), best = theory?.shown ?? theory?.recommended, answer = theory?.methods[best];
    const theirs = answer ? `, ${METHODS[best].label} ${short(answer.moments[name] * factor)}` : "";
    element("spoken").textContent = `x rms${title ? ` of ${title}` : ""} by Monte Carlo ${withError(measured.values[name] * factor, measured.errors[name] * factor)}${theirs} ${unit}.`;
  }
  if (measured?.complete && theory && !below) setTimeout(loadBelow, QUIET);
  element("results").dataset.complete = String(Boolean(measured?.complete && theory) && !old);
  element("results").dataset.generation = String(connection.generation);
}

// what only the paper's problem has, and what is called otherwise in it
function showPaper() {
  const { paper } = state;
  for (const one of document.querySelectorAll(".of-paper")) one.hidden = !paper;
  const { pair, title } = view.seen;
  element("growth-head").textContent = paper ? "μ(t) = ⟨A²⟩ after the start" : pair ? `⟨elongation²⟩ from ${title} after the start` : `⟨x²⟩${title ? ` of ${title}` : ""} after the start`;
  element("phase-note").textContent = [paper ? "Dashed: the ring of amplitude √⟨A²⟩, A² = x² + v²/Ω²." : "", !view.seen.walls.length ? "" : isSoft ? "Shaded, behind the dashed line: in the soft contact." : "Shaded: behind a wall."].filter(Boolean).join(" ");
  if (paper) {
    const wall = paper.wall === null ? "no wall" : `wall at ${short(paper.wall)} √(q/Ω³), restitution r = ${short(paper.restitution)}`;
    element("paper-numbers").textContent = `The paper's problem: order α = ${short(paper.order)}, strength c = ${short(paper.strength)}, ${wall}.`;
  }
  for (const panel of Object.values(panels)) panel?.relabel();
}

// which mass, or which two, the large numbers and the charts of the path are of
function showChoice() {
  const choice = element("seen");
  const group = (pairs, label) => {
    const made = Object.assign(document.createElement("optgroup"), { label });
    made.append(...view.followed.filter(({ pair }) => pair === pairs).map(({ name, title }) => new Option(title, name)));
    return made.children.length ? [made] : [];
  };
  choice.replaceChildren(...group(false, "a mass"), ...group(true, "the elongation between"));
  if (!view.followed.some(({ name }) => name === view.chosen)) view.chosen = view.followed[0].name;
  choice.value = view.chosen;
  follow(view.chosen);
}

function follow(name) {
  view.chosen = name;
  track.follow(view.followed.find((one) => one.name === name).row);
  setBounds(view);
  showPaper();
  drawnChanged();
}

// what a start means for the numbers and for the curve of <A^2> over time
function showStart() {
  const { measured } = view, fromRest = (measured?.settings.start ?? view.values.start) === "rest";
  const window = measured ? ` All other numbers are averages over ${view.after(measured.settings.window[0])}.` : "";
  element("growth-note").textContent = (fromRest
    ? "Mean over all paths, which start at rest, with two standard errors on either side. Methods without a transient are horizontal lines."
    : isThermal ? "Mean over all paths, with two standard errors on either side. Each path starts from Boltzmann's law. Theory: stationary values."
    : "Mean over all paths, with two standard errors on either side. Each path starts at the stationary mean displacement with zero velocity, so the curve still rises at first. Theory: stationary values.")
    + window;
  element("transient").hidden = !isTransient(measured);
  element("use-stationary").hidden = Boolean(ends) || view.values.start !== "rest";
}

function drawnChanged() {
  const drawn = NAMES.filter((name) => view.drawn.has(name) && view.theory?.methods[name]);
  element("curve-legend").innerHTML = legend(curvesShown(view), view.pin);
  element("density-legend").innerHTML = element("growth-legend").innerHTML = legend(drawn, view.pin);
  const front = drawn.includes(view.theory?.recommended) ? view.theory.recommended : drawn[0];
  scene.densities = POINTS.map((_, i) => {
    const name = `${OPENED.followed[i].name}x`, height = front && view.theory.methods[front].densities[name];
    if (height && !view.old.theory) return { place: view.theory.places[name], height: height.map((h) => h ?? 0), color: front };
    const { edges, density } = view.densities?.[name] ?? {}; // where no theory has one, that of the paths
    return density?.length ? { place: Array.from(density, (_, k) => 0.5 * (edges[k] + edges[k + 1])), height: [...density], color: "measured" } : null;
  });
  for (const name of [...Object.keys(DENSITIES), "growth", "curve", "motion", "numbers"]) dirty.add(name);
}

const drawings = {
  motion: drawMotion, traces: drawTraces, numbers: drawNumbers,
  ...Object.fromEntries([...Object.keys(DENSITIES), "growth", "curve"].map((name) => [name, () => panels[name]?.update()])),
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
addEventListener("beforeprint", () => { for (const draw of Object.values(drawings)) draw(); }); // before the next frame

// --- what a person does --------------------------------------------------------------------------------------------

function status(kind, text) {
  element("status").dataset.state = kind;
  element("status").textContent = text;
}

// each origin has its own: what the connection has to say does not take back what was wrong with a link
const notices = { link: "", file: "", connection: "", question: "" };
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
  const times = short((speed / view.frequency) * unitOf("time", state).factor, 2);
  const said = state.si ? `${times} × real time` : `Ωt: ${times} per s`;
  element("speed-shown").textContent = said;
  element("speed").setAttribute("aria-valuetext", said);
  if (connection.play.playing !== playing || connection.play.speed !== speed) connection.setPlay({ playing, speed });
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

fadeWhereCut(element("pinned-table"));
element("pin").addEventListener("click", () => { view.pin = snapshot(view); drawnChanged(); });
element("unpin").addEventListener("click", () => { view.pin = null; drawnChanged(); });
element("pin-return").addEventListener("click", () => state.set(view.pin.values));
element("seen").addEventListener("change", () => follow(element("seen").value));
element("open-file").addEventListener("change", async ({ target }) => {
  const [file] = target.files, { send } = await import("./files.js");
  const fault = file && await send(file, "system", connection, { large: ": open it with the command springpot explore.", binary: "." });
  target.value = "";
  notice("file", fault || "");
});
on("shelved", async ({ of, place, said, fault }) => {
  if (said) (await import("./files.js")).keepNote(said);
  if (!fault) goTo(place, state);
  else if (of === "table") excitationCard.refuse(fault);
  else notice("file", fault);
});
element("use-stationary").addEventListener("click", () => state.set({ start: "stationary" }));
startSaving({ view, element, state, connection, panels, phase });

// --- begin ---------------------------------------------------------------------------------------------------------

if (OPENED.file) document.title = `${OPENED.file} · springpot explorer`;
if (!OPENED.writable) Object.assign(element("save-file"), { disabled: true, title: "A function cannot be written to a file" });
element("impact-mark").hidden = !hasWalls;
if (!isSeveral) document.querySelector("[data-chart=impact_speed]").hidden = !hasWalls;
if (OPENED.place === null) notice("file", "The system of this address is not on this server any more: open its file again. This is the one that the page was opened with.");
if (ends) element("transient").firstChild.textContent = `${ends[0].toUpperCase()}${ends.slice(1)}: these numbers are averages over its length. Theory is for the stationary state, so no deviations are shown. `;
showPaper();

let linkTimer = null;
let linkShown = "";
function takeLink() {
  const unsound = state.readLink(location.hash);
  notice("link", !unsound.length ? "" : `The link has invalid values for ${listed(unsound)}; defaults are used.`);
}
const listed = (names) => (names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names.at(-1)}`);
let unitsShown = null;
state.onChange((_, another) => {
  notice("link", "");
  const units = [state.units, ...Object.values(state.shown)].join();
  if (unitsShown !== units) {
    unitsShown = units;
    showPaper();
    showEquation(element, view);
    excitationCard?.show(view.excitation, state);
    drawnChanged();
  }
  setSpeed();
  clearTimeout(linkTimer);
  linkTimer = setTimeout(() => {
    linkShown = state.link();
    if (location.hash !== linkShown) history.replaceState(null, "", linkShown);
  }, 250);
  if (another) connection.ask();
});
addEventListener("hashchange", () => { if (location.hash !== linkShown) takeLink(); });
takeLink();
// where there is one column, the picture stands above the sliders and stays in view while one moves
const column = matchMedia("(max-width: 900px)");
const placePicture = () => { if (column.matches) element("bench").prepend(element("motion")); else element("main-numbers").after(element("motion")); };
column.addEventListener("change", placePicture);
placePicture();
if (column.matches) element("controls").open = false;
connection.open();
requestAnimationFrame(frame);

// for whoever measures the page
window.springpotExplorer = { get frames() { return connection.frames; }, get drawn() { return drawnFrames; }, get time() { return track.now.t; }, get generation() { return connection.generation; } };

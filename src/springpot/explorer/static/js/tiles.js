// The main numbers, large.

import { METHODS } from "/methods.js";
import { grouped, short, withErrorHtml } from "./numbers.js";
import { hasCircuit, hasWalls, isSeveral } from "./problem.js";
import { gapOf, gapText, isSilent, isTransient } from "./table.js";
import { unitOf } from "./units.js";

// what the tiles show: their names, and the quantities
const RMS = ["x rms", "x_rms"], LAST = hasWalls ? ["Impact rate", "impact_rate"] : ["Input power", "input_power"];
const tilesOf = ({ paper }) => [...(paper ? [["⟨A²⟩", "amplitude_mean_square"], RMS] : [RMS, hasCircuit ? ["harvested", "harvested_power"] : ["v rms", "v_rms"]]), LAST];

// of several masses those of what is followed
function tilesAlong({ name, title, pair, walls: [wall] }) {
  const own = pair ? [["elongation rms", "rms"], ["mean elongation", "mean"]] : [["x rms", "x_rms"], ["v rms", "v_rms"]];
  const last = wall ? [`Impact rate, ${wall.name}`, `${wall.part}_impact_rate`] : ["Input power", "input_power"];
  return [...own.map(([said, what]) => [`${said} of ${title}`, name + what]), last];
}

export function showTiles(view, element, playing) {
  const [MAIN, BESIDE, LAST] = isSeveral ? tilesAlong(view.seen) : tilesOf(view.state);
  element("tile-measured").previousElementSibling.lastElementChild.textContent = MAIN[0];
  element("tile-rms").previousElementSibling.lastElementChild.textContent = BESIDE[0];
  element("tile-rate").previousElementSibling.textContent = LAST[0];
  const { theory, measured, state } = view, old = view.old.theory, best = theory?.shown ?? theory?.recommended;
  const answer = best && theory.methods[best], transient = isTransient(measured);
  const write = (id, html) => { element(id).innerHTML = html; };
  const say = (id, text) => { element(id).textContent = text || "\u00a0"; };
  const number = (value, quantity, error) => {
    const { factor, name } = unitOf(quantity, state);
    return Number.isFinite(value) ? withErrorHtml(value * factor, Number.isFinite(error) ? error * factor : null, name) : "–";
  };
  const measuredOf = (quantity) => (measured ? number(measured.values[quantity], quantity, measured.errors[quantity]) : "–");
  const plainly = (quantity) => {
    const { factor } = unitOf(quantity, state);
    const value = answer?.moments[quantity] ?? null;
    return answer && !old && value !== null ? `${METHODS[best].label}: ${short(value * factor)}` : "";
  };

  write("tile-measured", measuredOf(MAIN[1]));
  say("tile-measured-note", measured && `mean, ${view.after(measured.settings.window[0])}`);
  write("tile-rms", measuredOf(BESIDE[1]));
  say("tile-rms-note", plainly(BESIDE[1]));
  const none = LAST[1].includes("impact") && measured?.undefined && (measured.values[LAST[1]] ?? null) === null;
  write("tile-rate", none ? "no value" : measuredOf(LAST[1]));
  say("tile-rate-note", none ? "infinitely many impacts" : view.walls.length && plainly(LAST[1]));

  element("tile-theory").classList.toggle("stale", old);
  say("tile-theory-name", best ? METHODS[best].label : "");
  write("tile-theory", answer ? number(answer.moments[MAIN[1]], MAIN[1]) : "–");
  const { values, errors } = measured ?? { values: {}, errors: {} }, name = MAIN[1];
  const gap = answer && measured && !old && !transient ? gapText(gapOf(answer.moments[name], values[name], errors[name])) : "";
  const silent = theory && !best && !old ? (isSilent(theory) ? "no analytical method covers this" : "no method is recommended here") : "";
  say("tile-theory-note", gap ? `gap ${gap}` : silent || (answer && transient ? "of the stationary state" : ""));

  say("tile-paths", grouped(measured?.paths ?? 0));
  element("progress").value = measured ? measured.paths / measured.of : 0;
  if (measured) {
    const steps = measured.paths * Math.round(measured.settings.duration / measured.settings.step);
    say("tile-paths-note", measured.complete ? `done: ${short(steps, 2)} steps in ${short(measured.seconds, 2)} s` : `of ${grouped(measured.of)}${playing ? "" : ": paused"}`);
  } else if (!playing) say("tile-paths-note", "paused: Play or Step");
}

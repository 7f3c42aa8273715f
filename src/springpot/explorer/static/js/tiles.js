// The main numbers, large: four that an engineer asks first, and below them theory and the rates of the stops.

import { METHODS } from "/methods.js";
import { grouped, short, withError, withErrorHtml } from "./numbers.js";
import { OPENED, POINTS, hasCircuit, hasWalls, isSeveral, isSoft } from "./problem.js";
import { escaped, gapOf, gapText, isComputing, isSilent, isTransient } from "./table.js";
import { unitOf } from "./units.js";

const FAST = "impact_speed_quantile_0.99", PEAK = "acceleration_peak_mean";
const isFelt = (name) => OPENED.offered.forces.some(([own, , , why]) => own === name && !why);
const TILES = ["rms", "rate", "speed", "peak"];

// titles and quantities
const tilesOf = () => [
  ["x rms", "x_rms"],
  hasWalls ? ["Impact rate", "impact_rate"] : ["v rms", "v_rms"],
  hasWalls ? ["99 % impact speed", FAST] : hasCircuit ? ["Harvested power", "harvested_power"] : ["Input power", "input_power"],
  isFelt("acceleration") ? ["Peak acceleration", PEAK] : hasWalls ? ["v rms", "v_rms"] : ["mean x", "x_mean"],
];

// of several masses those of what is followed, and of the first stop at it
function tilesAlong({ name, title, pair, row, walls: [along] }, walls) {
  const wall = along ?? (pair ? null : walls.find(({ ends }) => ends.some((end) => row[end] === 1)));
  const point = POINTS[row.indexOf(1)], own = `${point.name}_acceleration`;
  return [
    pair ? [`elongation rms of ${title}`, `${name}rms`] : [`x rms of ${title}`, `${name}x_rms`],
    wall ? [`Impact rate, ${wall.name}`, `${wall.part}_impact_rate`] : pair ? [`mean elongation of ${title}`, `${name}mean`] : [`v rms of ${title}`, `${name}v_rms`],
    wall ? [`99 % impact speed, ${wall.name}`, `${wall.part}_${FAST}`] : ["Input power", "input_power"],
    isFelt(own) ? [`Peak acceleration of ${point.title}`, `${own.replace("acceleration", PEAK)}`] : [`v rms of ${point.title}`, `${point.name}_v_rms`],
  ];
}

// what stands in lines below the tiles: of the paper's problem <A²>, of circuits their power, of stops their rates
function linesOf({ state, walls }) {
  const rates = walls.length > 1 || isSeveral ? walls.map(({ name, part }) => [`impacts on ${name}`, `${part}_impact_rate`]) : [];
  return [...(state.paper ? [["⟨A²⟩", "amplitude_mean_square"]] : []), ...(hasCircuit && (hasWalls || isSeveral) ? [["harvested power", "harvested_power"]] : []), ...rates];
}

export function showTiles(view, element, playing) {
  const { theory, measured, state } = view, old = view.old.theory, best = theory?.shown ?? theory?.recommended;
  const tiles = isSeveral ? tilesAlong(view.seen, view.walls) : tilesOf();
  const answer = best && theory.methods[best], transient = isTransient(measured);
  const write = (id, html) => { element(id).innerHTML = html; };
  const say = (id, text) => { element(id).textContent = text || "\u00a0"; };
  const isNone = (quantity) => quantity.includes("impact") && measured?.undefined && (measured.values[quantity] ?? null) === null;
  const scaled = (quantity, shown) => {
    const { factor, name } = unitOf(quantity, state), value = measured?.values[quantity] ?? null, error = measured?.errors[quantity] ?? null;
    return isNone(quantity) ? "no value" : value === null ? "–" : shown(value * factor, error === null ? null : error * factor, name);
  };
  const theirs = (quantity) => {
    const { factor } = unitOf(quantity, state), value = answer?.moments[quantity] ?? null;
    return answer && !old && value !== null ? `${METHODS[best].label}: ${short(value * factor)}` : "";
  };
  const since = measured && `mean, ${view.after(measured.settings.window[0])}`;

  TILES.forEach((id, i) => {
    const [title, quantity] = tiles[i];
    element(`tile-${id}`).previousElementSibling.textContent = title;
    write(`tile-${id}`, scaled(quantity, withErrorHtml));
    say(`tile-${id}-note`, isNone(quantity) ? "infinitely many impacts" : noteOf(quantity, measured) ?? (i ? theirs(quantity) : since));
  });

  // theory beside the first number, or beside <A²> where the problem is the paper's
  const [name, title] = state.paper ? ["amplitude_mean_square", "⟨A²⟩"] : [tiles[0][1], tiles[0][0]];
  const { values, errors } = measured ?? { values: {}, errors: {} }, { factor, name: unit } = unitOf(name, state), computing = isComputing(view);
  const gap = answer && measured && !old && !transient ? gapText(gapOf(answer.moments[name], values[name], errors[name])) : "";
  const silent = theory && !best && !old ? (isSilent(theory) ? "no analytical method covers this" : "no method is recommended here") : "";
  const value = answer?.moments[name] ?? null;
  element("tile-theory").classList.toggle("stale", old);
  element("tile-theory-note").classList.toggle("computing", computing);
  say("tile-theory-name", best ? METHODS[best].label : "");
  write("tile-theory", value === null ? "–" : `<small>${title}</small> ${withErrorHtml(value * factor, null, unit)}`);
  say("tile-theory-note", computing ? "computing…" : gap ? `deviation ${gap}` : silent || (answer && transient ? "of the stationary state" : ""));

  const lines = linesOf(view);
  element("tile-lines").parentElement.hidden = !lines.length;
  write("tile-lines", lines.map(([said, quantity]) => `<div data-quantity="${quantity}"><dt>${escaped(said)}</dt><dd>${scaled(quantity, (number, error, its) => `${withError(number, error)}${its ? ` <small>${its}</small>` : ""}`)}</dd></div>`).join(""));

  say("tile-paths", grouped(measured?.paths ?? 0));
  element("progress").value = measured ? measured.paths / measured.of : 0;
  if (measured) {
    const steps = measured.paths * Math.round(measured.settings.duration / measured.settings.step);
    say("tile-paths-note", measured.complete ? `done: ${short(steps, 2)} steps in ${short(measured.seconds, 2)} s` : `of ${grouped(measured.of)}${playing ? "" : ": paused"}`);
  } else if (!playing) say("tile-paths-note", "paused: Play or Step");
}

// what a number is, where its name does not say it
function noteOf(quantity, measured) {
  if (quantity.endsWith(FAST)) return "one impact in 100 is faster";
  if (!quantity.endsWith(PEAK)) return null;
  const [from, to] = measured?.settings.window ?? [0, 0];
  return measured ? `mean of the largest in ${short(to - from, 2)} s${hasWalls && !isSoft ? ", between impacts" : ""}` : "";
}

// A second design, pinned beside the one of the sliders: a copy of its numbers and curves, taken when it is pinned.

import { short } from "./numbers.js";
import { OPENED, PARAMETERS, ofSystem } from "./problem.js";
import { converted, lengthScale } from "./state.js";
import { QUANTITIES, columnsFor, headOf, isTransient, measuredCells } from "./table.js";
import { DIMENSIONS } from "./units.js";

export function snapshot({ state, measured, densities, theory, growth, grown }) {
  const { units, scales, values } = state;
  const ends = (places) => (places ? [places[0], places.at(-1)] : null);
  return {
    units, scales: { ...scales }, values: { ...values },
    measured: { values: measured.values, errors: measured.errors, stationary: measured.stationary },
    densities: Object.fromEntries(Object.entries(densities ?? {}).map(([name, { edges, density }]) => [
      name, { edges: [...edges], density: [...density], range: ends(theory?.places[name]) ?? ends(edges) ?? [0, 1] },
    ])),
    times: [...(growth?.times ?? [])], mean: [...(grown?.mean ?? [])],
  };
}

// the pin in the units of now: the same design, whichever of the two it was pinned in
const inUnits = new WeakMap();
export function pinOf({ pin, state }) {
  if (!pin || pin.units === state.units) return pin ?? null;
  if (!inUnits.has(pin)) inUnits.set(pin, changed(pin, state.units));
  return inUnits.get(pin);
}

function changed(pin, units) {
  const values = converted(pin.values, units === "si" ? pin.scales : { natural_frequency: 1, intensity: 1 });
  const length = lengthScale(values) / lengthScale(pin.values);
  const time = pin.values.natural_frequency / values.natural_frequency;
  const factor = (name) => { const [l, t] = DIMENSIONS[name] ?? [0, 0]; return length ** l * time ** t; };
  const scaled = (numbers) => Object.fromEntries(Object.entries(numbers).map(([name, v]) => [name, v === null ? null : v * factor(name)]));
  const scales = units === "si" ? pin.scales : { natural_frequency: pin.values.natural_frequency, intensity: pin.values.intensity };
  return {
    units, scales, values,
    measured: { ...pin.measured, values: scaled(pin.measured.values), errors: scaled(pin.measured.errors) },
    densities: Object.fromEntries(Object.entries(pin.densities).map(([name, { edges, density, range }]) => {
      const f = factor(name);
      return [name, { edges: edges.map((v) => v * f), density: density.map((v) => v / f), range: range.map((v) => v * f) }];
    })),
    times: pin.times.map((t) => t * time), mean: pin.mean.map((v) => v * length ** 2),
  };
}

export const pinnedDensity = (view, name) => pinOf(view)?.densities[name];
export const pinnedGrowth = pinOf;
export function pinnedMarker(view) {
  const pin = pinOf(view);
  if (!pin) return null;
  const { values, errors } = pin.measured;
  return { order: pin.values.order, value: values.amplitude_mean_square, error: errors.amplitude_mean_square };
}

// change of the design of now against the pinned one, in per cent with its standard error
export function changeText(value, error, other, otherError) {
  if (![value, error, other, otherError].every(Number.isFinite) || Math.abs(other) <= 3 * otherError || other === 0) return "–";
  const ratio = value / other, deviation = 100 * Math.abs(ratio) * Math.hypot(error / value || 0, otherError / other);
  const places = deviation > 0 && deviation < 0.095 ? 2 : deviation < 9.5 ? 1 : 0, percent = 100 * (ratio - 1);
  return `${percent < 0 ? "−" : "+"}${Math.abs(percent).toFixed(places)} ± ${deviation.toFixed(places)} %`;
}

const SYMBOLS = { order: "α", coefficient: "C", natural_frequency: "Ω", intensity: "q", position: "b", restitution: "r" };

function numbersOf(now, pin) {
  return OPENED.parts.flatMap(({ name, title }) => Object.entries(PARAMETERS)
    .filter(([number]) => number.startsWith(`${name}-`) && now[number] !== pin[number])
    .map(([number, { symbol }]) => `${symbol} of ${title} = ${short(pin[number])}`));
}

function differences(now, pin) {
  const found = ofSystem ? numbersOf(now, pin) : Object.entries(SYMBOLS).filter(([name]) => now[name] !== pin[name] && (pin.wall || !["position", "restitution"].includes(name)))
    .map(([name, symbol]) => `${symbol} = ${short(pin[name])}`);
  if (now.wall !== pin.wall) found.push(pin.wall ? "a wall" : "no wall");
  if (now.start !== pin.start) found.push(pin.start === "rest" ? "start from rest" : "stationary start");
  if (now.paths !== pin.paths) found.push(`${pin.paths} paths`);
  if (now.seed !== pin.seed) found.push(`seed ${pin.seed}`);
  return found.length ? `The pinned design has ${found.join(", ")}; all else is the same.` : "Both designs are the same: move a slider.";
}

export function showPinned(view, element) {
  const pin = pinOf(view), { state, measured } = view;
  element("pinned").hidden = !pin;
  if (!pin) return;
  const columns = columnsFor(state, [pin.measured, measured]);
  const row = (label, swatch, one) => `<tr class="measured"><th scope=row><span class="swatch ${swatch}"></span>${label}</th>${measuredCells(one, columns)}</tr>`;
  const change = QUANTITIES.map(([name]) => {
    const of = ({ values, errors }) => [values[name], errors[name]];
    return `<td data-quantity="${name}">${measured ? changeText(...of(measured), ...of(pin.measured)) : "–"}</td>`;
  });
  element("pinned-table").innerHTML = `<caption class="sr">Monte Carlo of this design and of the pinned one</caption><thead><tr>${headOf("design", columns)}</tr></thead>
    <tbody>${row("this design", "box", measured)}${row("pinned", "pinned", pin.measured)}<tr><th scope=row>change</th>${change.join("")}</tr></tbody>`;
  element("pinned-note").textContent = `${differences(state.values, pin.values)}${[measured, pin.measured].some(isTransient) ? " From rest, before the motion is stationary, both depend on how long the run is." : ""}`;
}

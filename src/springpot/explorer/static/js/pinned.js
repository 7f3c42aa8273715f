// A second design, pinned beside the one of the sliders: a copy of its numbers and curves, taken when it is pinned.

import { short } from "./numbers.js";
import { OPENED, PARAMETERS, orderOf, titleOf } from "./problem.js";
import { bodiesOf, columnsFor, columnsOf, escaped, headOf, isTransient, measuredCells } from "./table.js";

export function snapshot({ state, measured, densities, theory, growth, grown }) {
  const ends = (places) => (places ? [places[0], places.at(-1)] : null);
  return {
    values: { ...state.values }, paper: state.paper,
    measured: { values: measured.values, errors: measured.errors, stationary: measured.stationary },
    densities: Object.fromEntries(Object.entries(densities ?? {}).map(([name, { edges, density }]) => [
      name, { edges: [...edges], density: [...density], range: ends(theory?.places[name]) ?? ends(edges) ?? [0, 1] },
    ])),
    times: [...(growth?.times ?? [])], means: Object.fromEntries(Object.entries(grown ?? {}).map(([name, { mean }]) => [name, [...mean]])),
  };
}

export const pinnedDensity = (view, name) => view.pin?.densities[name];
export const pinnedGrowth = ({ pin, chosen }) => (pin?.means[chosen] ? { times: pin.times, mean: pin.means[chosen] } : null);
export function pinnedMarker(view) {
  const { pin } = view;
  if (!pin) return null;
  const { values, errors } = pin.measured;
  return { order: orderOf(pin.values, pin.paper), value: values.amplitude_mean_square, error: errors.amplitude_mean_square };
}

// change of the design of now against the pinned one, in per cent with its standard error
export function changeText(value, error, other, otherError) {
  if (![value, error, other, otherError].every(Number.isFinite) || Math.abs(other) <= 3 * otherError || other === 0) return "–";
  const ratio = value / other, deviation = 100 * Math.abs(ratio) * Math.hypot(error / value || 0, otherError / other);
  const places = deviation > 0 && deviation < 0.095 ? 2 : deviation < 9.5 ? 1 : 0, percent = 100 * (ratio - 1);
  return `${percent < 0 ? "−" : "+"}${Math.abs(percent).toFixed(places)} ± ${deviation.toFixed(places)} %`;
}

function differences(now, pin) {
  const found = Object.keys(PARAMETERS).filter((name) => now[name] !== pin[name])
    .map((name) => `${PARAMETERS[name].symbol} of ${titleOf(name)} = ${short(pin[name])}`);
  for (const { name, title } of OPENED.parts) {
    if (now.without.includes(name) !== pin.without.includes(name)) found.push(`${pin.without.includes(name) ? "no" : "a"} ${title}`);
  }
  if (now.start !== pin.start) found.push(pin.start === "rest" ? "start from rest" : "stationary start");
  if (now.paths !== pin.paths) found.push(`${pin.paths} paths`);
  if (now.seed !== pin.seed) found.push(`seed ${pin.seed}`);
  return found.length ? `The pinned design has ${found.join(", ")}; all else is the same.` : "Both designs are the same: move a slider.";
}

export function showPinned(view, element) {
  const { pin, state, measured } = view;
  element("pinned").hidden = !pin;
  if (!pin) return;
  const parts = view.groups.map((group) => {
    const columns = columnsFor(view, group, [pin.measured, measured]);
    const rows = group.rows.map(([whose, title]) => {
      const own = columnsOf(whose, columns), of = title ? `${escaped(title)}, ` : "";
      const row = (label, swatch, one) => `<tr class="measured"><th scope=row><span class="swatch ${swatch}"></span>${of}${label}</th>${measuredCells(one, own)}</tr>`;
      const change = own.map(({ name }) => {
        const found = ({ values, errors }) => [values[name], errors[name]];
        return `<td data-quantity="${name}">${measured ? changeText(...found(measured), ...found(pin.measured)) : "–"}</td>`;
      });
      return `${row("this design", "box", measured)}${row("pinned", "pinned", pin.measured)}<tr><th scope=row>change</th>${change.join("")}</tr>`;
    });
    return { head: headOf("design", columns), rows };
  });
  element("pinned-table").innerHTML = `<caption class="sr">Monte Carlo of this design and of the pinned one</caption>${bodiesOf(parts)}`;
  element("pinned-note").textContent = `${differences(state.values, pin.values)}${[measured, pin.measured].some(isTransient) ? " From rest, before the motion is stationary, both depend on how long the run is." : ""}`;
}

// The equations, and the table of what belongs to parts.

import { withError } from "./numbers.js";
import { escaped } from "./table.js";
import { CHOICES, unitOf, unitShown } from "./units.js";

// one for each mass, then in small print the units, excitations and walls
export function showEquation(element, { equation: [first = "", ...more], equations, state }) {
  const lines = equations.length ? equations : [first], rest = document.createElement("small"), said = equations.length ? [first, ...more] : more;
  const sums = lines.map((text) => Object.assign(document.createElement("span"), { className: "sum", innerHTML: mathematical(text) }));
  rest.innerHTML = said.map((text) => mathematical(inLength(text, state))).join(" · ");
  element("equation").replaceChildren(...sums, rest);
  element("equation").setAttribute("aria-label", [...lines, ...said].join("; "));
}

// places of walls in the length that is chosen
function inLength(text, { shown }) {
  const { factor, name } = CHOICES.length[shown.length];
  return text.replace(/([<>]= )(-?[\d.]+(?:e[+-]?\d+)?) m(?![\w/])/g, (_, sign, place) => `${sign}${Number((factor * place).toPrecision(6))} ${name}`);
}

// the library's plain text with signs: x'', powers, and the minus
const mathematical = (text) => escaped(text).replace(/(\d)e([+-]?)0*(\d+)/g, (_, digit, sign, power) => `${digit}·10<sup>${sign === "-" ? "−" : ""}${power}</sup>`)
  .replace(/x(_\w+)?&#39;&#39;/g, "ẍ$1").replace(/x(_\w+)?&#39;/g, "ẋ$1").replace(/([xẋẍ])_(\w+)/g, "$1<sub>$2</sub>").replace(/V&#39;/g, "V̇").replace(/d&#39;/g, "ḋ")
  .replace(/\^\(?(-?[\d.]+)\)?/g, (_, power) => `<sup>${power.replace("-", "−")}</sup>`)
  .replace(/(^|[\s(])-(?=[\s\d(a-z])/g, "$1−").replace(/&#62;=/g, "≥").replace(/&#60;=/g, "≤");

// the numbers of the parts: powers, walls, circuits
export function makePartsCard(table) {
  return ({ measured, state }) => {
    const rows = (measured?.labels ?? []).map(([name, said, own]) => {
      const { factor, name: unit } = state.si ? unitShown(own, state) : unitOf(name, state);
      const value = measured.values[name];
      const why = value === null && measured.undefined ? `no value: ${measured.undefined}` : "";
      const shown = value === null ? (why ? "no value" : "–") : withError(value * factor, measured.errors[name] === null ? null : measured.errors[name] * factor);
      return `<tr><th scope=row>${escaped(said)}</th><td data-quantity="${name}" data-value="${value ?? ""}" data-error="${measured.errors[name] ?? ""}"${why ? ` title="${escaped(why)}"` : ""}>${shown}${unit && value !== null ? ` <small>${unit}</small>` : ""}</td></tr>`;
    });
    table.innerHTML = `<caption class="sr">Powers, impacts and voltages by Monte Carlo, with one standard error</caption><tbody>${rows.join("")}</tbody>`;
  };
}


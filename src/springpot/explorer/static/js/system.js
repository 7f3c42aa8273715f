// What a system's page has that an oscillator's has not, and the other way round.

import { OPENED, hasWalls, isRecorded, isSoft, ofSystem } from "./problem.js";
import { withError } from "./numbers.js";
import { escaped } from "./table.js";

// before anything is drawn: other headings, and no controls that an oscillator alone has
export function startSystem(element) {
  document.title = `${OPENED.file} · springpot explorer`;
  document.body.classList.add("of-system");
  for (const one of document.querySelectorAll(".of-oscillator")) one.hidden = true;
  for (const one of document.querySelectorAll(".of-system-only")) one.hidden = false;
  element("file-name").textContent = OPENED.file;
  const button = Object.assign(document.createElement("button"), {
    type: "button", className: "button", id: "save-file", textContent: "Download TOML", disabled: !OPENED.writable,
    title: OPENED.writable ? "The system with the numbers of now, as a TOML file" : "A function cannot be written to a file",
  });
  element("save-csv").after(button);
  document.querySelector("#controls summary span").textContent = "System and run";
  document.querySelector("[data-chart=growth] h2").textContent = "⟨x²⟩ after the start";
  document.querySelector("[data-chart=phase] .caption").textContent = !hasWalls ? "" : isSoft ? "Shaded, behind the dashed line: in the soft contact." : "Shaded: behind a wall.";
  document.querySelector("[data-chart=amplitude]").hidden = true;
  document.querySelector("[data-chart=impact_speed]").hidden = !hasWalls;
  document.querySelector(".mark.impact").parentElement.hidden = !hasWalls;
  document.querySelector("#scene canvas").setAttribute("aria-label", `The mass of ${OPENED.file} on its springs and dampers, between its walls`);
  document.querySelector("#phase canvas").setAttribute("aria-label", "Velocity against displacement of the path, with the walls");
  if (isRecorded) element("transient").firstChild.textContent = "A record has a beginning and an end: these numbers are averages over its length. Theory is for the stationary state, so no gaps are shown. ";
  showEquation(element, []);
}

export function showEquation(element, [first = "", ...more]) {
  const line = document.createElement("span"), rest = document.createElement("small");
  line.className = "sum";
  line.innerHTML = mathematical(first);
  rest.innerHTML = more.map(mathematical).join(" · ");
  element("equation").replaceChildren(line, rest);
  element("equation").setAttribute("aria-label", [first, ...more].join("; "));
}

// the library's plain text with signs: x'', powers, and the minus
const mathematical = (text) => escaped(text).replace(/(\d)e([+-]?)0*(\d+)/g, (_, digit, sign, power) => `${digit}·10<sup>${sign === "-" ? "−" : ""}${power}</sup>`)
  .replace(/x&#39;&#39;/g, "ẍ").replace(/x&#39;/g, "ẋ").replace(/V&#39;/g, "V̇").replace(/d&#39;/g, "ḋ")
  .replace(/\^\(?(-?[\d.]+)\)?/g, (_, power) => `<sup>${power.replace("-", "−")}</sup>`)
  .replace(/(^|[\s(])-(?=[\s\d(a-z])/g, "$1−").replace(/&#62;=/g, "≥").replace(/&#60;=/g, "≤");

// the numbers of the parts: powers, walls, circuits
export function makePartsCard(table) {
  return ({ measured }) => {
    if (!ofSystem) return;
    const rows = (measured?.labels ?? []).map(([name, said, unit]) => {
      const value = measured.values[name];
      const why = value === null && measured.undefined ? `no value: ${measured.undefined}` : "";
      const shown = value === null ? (why ? "no value" : "–") : withError(value, measured.errors[name]);
      return `<tr><th scope=row>${escaped(said)}</th><td data-quantity="${name}" data-value="${value ?? ""}" data-error="${measured.errors[name] ?? ""}"${why ? ` title="${escaped(why)}"` : ""}>${shown}${unit && value !== null ? ` <small>${unit}</small>` : ""}</td></tr>`;
    });
    table.innerHTML = `<caption class="sr">Powers, impacts and voltages by Monte Carlo, with one standard error</caption><tbody>${rows.join("")}</tbody>`;
  };
}


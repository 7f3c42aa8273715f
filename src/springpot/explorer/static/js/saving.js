// What is copied and saved: the link, programs, numbers, and each chart as CSV and PNG.

import { PINNED_DASH } from "./charts.js";
import { METHODS, NAMES } from "/methods.js";
import { DENSITIES, curvesShown } from "./panels.js";
import { OPENED } from "./problem.js";
import { copy, csv, png, save, say } from "./share.js";
import { palette } from "./theme.js";

const fileName = (name, kind) => `springpot-${name}.${kind}`;

export function described({ state }) {
  const v = state.values;
  const numbers = OPENED.file ? state.changes() : Object.fromEntries(OPENED.sliders.map(({ name }) => [name, v[name]]));
  const said = [...Object.entries(numbers).map(([name, value]) => `${name} = ${value}`), ...Object.entries(v.tolerances).map(([name, spread]) => `tolerance of ${name} = ${spread}`), ...v.without.map((name) => `without ${name}`)];
  return [...(OPENED.file ? [OPENED.file] : []), ...said, `start ${v.start}, seed ${v.seed}, ${v.paths} paths`].join(", ");
}

export function startSaving({ view, element, state, connection, panels, phase }) {
  const note = element("copied");
  element("copy-link").addEventListener("click", () => copy(location.origin + location.pathname + location.search + state.link(), "Link copied.", note));
  const copyOf = (kind, said) => (view.copies ? copy(view.copies[kind], said, note) : say("Not copied: the server has not accepted these numbers.", note));
  element("copy-python").addEventListener("click", () => copyOf("python", "Python copied."));
  element("copy-command").addEventListener("click", () => copyOf("command", "Command copied."));
  element("save-file").addEventListener("click", () => connection.file());
  element("save-csv").addEventListener("click", () => {
    const { theory, measured } = view, rows = [];
    for (const [name, value] of Object.entries(measured?.values ?? {})) rows.push(["monte_carlo", name, value, measured.errors[name]]);
    for (const [method, answer] of Object.entries((!view.old.theory && theory?.methods) || {})) {
      for (const [name, value] of Object.entries(answer.moments)) rows.push([method, name, value, ""]);
    }
    const columns = ["method", "quantity", "value", "standard_error"].map((name, i) => [name, rows.map((row) => row[i] ?? "")]);
    save(fileName("numbers", "csv"), csv(described(view), columns));
  });

  // each card gets its two buttons
  const CHARTS = { traces: ["traceX", "traceV"], growth: ["growth"], curve: ["curve"], ...Object.fromEntries(Object.keys(DENSITIES).map((name) => [name, [name]])) };
  for (const card of document.querySelectorAll("[data-chart]")) {
    const name = card.dataset.chart, title = card.querySelector("h2, h3").textContent;
    const heading = card.dataset.heading ?? title;
    const tools = document.createElement("span");
    tools.className = "tools";
    if (CHARTS[name]) {
      tools.append(tool("CSV", `${title} as CSV`, () => save(fileName(name, "csv"), csv(described(view), panels[CHARTS[name][0]].columns()))));
    }
    tools.append(tool("PNG", `${title} as PNG`, async () => {
      const canvases = [];
      for (const key of CHARTS[name] ?? []) canvases.push(await panels[key].snapshot(720, CHARTS[name].length > 1 ? 230 : 400));
      const colors = { page: palette.panel, text: palette.text, muted: palette.muted };
      save(fileName(name, "png"), png(canvases.length ? canvases : [phase.canvas.element], heading, described(view), lines(view, name), colors));
    }));
    card.querySelector(".card-head").append(tools);
  }
}

function lines(view, name) {
  if (!DENSITIES[name] && name !== "growth" && name !== "curve") return [];
  const shown = name === "curve" ? curvesShown(view) : NAMES.filter((method) => view.drawn.has(method) && view.theory?.methods[method]);
  return [
    { label: "Monte Carlo", color: palette.measured, dash: [], box: true },
    ...shown.map((method) => ({ label: METHODS[method].label, color: palette[method], dash: METHODS[method].dash })),
    ...(view.pin ? [{ label: "pinned", color: palette.pinned, dash: PINNED_DASH }] : []),
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

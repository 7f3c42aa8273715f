// Charts of a fit: measured points with the fit through them, or a measured path with the simulated one over it.

import { Chart } from "./charts.js";
import { palette } from "./theme.js";

const COLORS = ["path", "impact", "pinned"];

// on a card with plot, residuals and legend; gives the charts
export const drawFit = (card, found) => (found.groups[0].residual ? drawPaths : drawPoints)(card, found);

// measured paths with the simulated ones over them, and below what is left
function drawPaths({ plot, residuals, legend }, { groups, axis }) {
  const color = (i) => palette[COLORS[i % COLORS.length]], one = groups[0].unit, alike = groups.every(({ unit }) => unit === one);
  const x = () => ({ what: axis, factor: 1, unit: "" }), none = { points: { show: false } };
  plot.hidden = residuals.hidden = false;
  const paths = new Chart(plot, {
    height: () => 260, x, y: () => ({ what: groups.length === 1 ? groups[0].name : "", factor: 1, unit: alike ? one : "" }), ySize: 62,
    series: groups.flatMap((_, i) => [{ ...none, stroke: () => color(i), width: 4, alpha: 0.5 }, { ...none, stroke: () => palette.text, width: 1.2 }]),
    readout: (_, i) => (i === null ? [] : [["time", groups[0].at[i]], ...groups.flatMap(({ name, data, fitted }) => [[`${name} measured`, data[i]], [`${name} simulated`, fitted[i]]])]),
  });
  paths.set([groups[0].at, ...groups.flatMap(({ data, fitted }) => [data, fitted])]);
  const left = new Chart(residuals, {
    height: () => 190, x, y: () => ({ what: "residual (sd)", factor: 1, unit: "" }), ySize: 62,
    series: groups.map((_, i) => ({ ...none, stroke: () => color(i), width: 1.2 })),
    readout: (_, i) => (i === null ? [] : [["time", groups[0].at[i]], ...groups.map(({ name, residual }) => [name, residual[i]])]),
  });
  left.set([groups[0].at, ...groups.map(({ residual }) => residual)]);
  legend.replaceChildren(...groups.flatMap(({ name }, i) => [["measured", COLORS[i % COLORS.length]], ["simulated", "text"]].map(([what, own]) => {
    const item = Object.assign(document.createElement("span"), { className: "item" }), mark = document.createElement("span");
    mark.textContent = "—\u2002";
    mark.style.color = `var(--${own})`;
    item.append(mark, `${name} ${what}`);
    return item;
  })));
  return [paths, left];
}

function drawPoints({ plot, legend }, { groups, axis, logarithmic }) {
  plot.hidden = false;
  const place = (at, i) => at ?? i + 1;
  const places = [...new Set(groups.flatMap(({ at }) => at.map(place)))].sort((a, b) => a - b);
  const columns = groups.flatMap(({ at, data, fitted }) => [data, fitted].map((values) => {
    const by = new Map(at.map((one, i) => [place(one, i), values[i]]));
    return places.map((one) => by.get(one) ?? null);
  }));
  const positive = columns.flat().every((value) => value === null || value > 0);
  const series = groups.flatMap((_, i) => {
    const stroke = () => palette[COLORS[i % COLORS.length]], hollow = i % 2 === 1;
    return [
      { paths: () => null, stroke, points: { show: true, size: 7, width: 1.5, stroke, fill: hollow ? () => palette.panel : stroke } },
      { stroke, width: 2, spanGaps: true, dash: hollow ? [6, 4] : [], points: { show: false } },
    ];
  });
  const chart = new Chart(plot, {
    height: () => 280, x: () => ({ what: axis, factor: 1, unit: "" }), y: () => ({ what: "", factor: 1, unit: "" }), series,
    xLog: logarithmic, yLog: logarithmic && positive, ySize: 62,
    readout: (_, i) => (i === null ? [] : [["", places[i]], ...groups.flatMap(({ name }, n) => (columns[2 * n][i] === null ? [] : [[name, columns[2 * n][i]], ["fit", columns[2 * n + 1][i]]]))]),
  });
  chart.set([places, ...columns]);
  legend.replaceChildren(...groups.map(({ name }, i) => {
    const item = Object.assign(document.createElement("span"), { className: "item" }), mark = document.createElement("span");
    mark.textContent = i % 2 ? "○ ╌\u2002" : "● —\u2002";
    mark.style.color = `var(--${COLORS[i % COLORS.length]})`;
    item.append(mark, `${name}: data and fit`);
    return item;
  }));
  return [chart];
}

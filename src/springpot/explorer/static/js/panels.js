// The charts of the page: what each shows, of the newest answers in `view`.

import { Chart, bars, methodSeries, outline, polyline } from "./charts.js";
import { METHODS, NAMES } from "/methods.js";
import { OPENED, ORDERS, POINTS, isSeveral, orderOf } from "./problem.js";
import { escaped } from "./table.js";
import { withError } from "./numbers.js";
import { pinnedDensity, pinnedGrowth, pinnedMarker } from "./pinned.js";
import { palette } from "./theme.js";
import { densityUnitOf, unitOf } from "./units.js";

const TITLES = { x: "Displacement", v: "Velocity", amplitude: "Amplitude", impact_speed: "Impact speed" };
const AXES = { x: "x", v: "v", amplitude: "A", impact_speed: "impact speed" };
export const DENSITIES = Object.fromEntries(OPENED.densities.map((name) => [name, AXES[name] ?? "x"])); // names of their axes
const CURVES = NAMES.filter((name) => METHODS[name].over_order).reverse();
const SLACK = 1.06;

const quantity = (view, what, name) => () => { const { factor, name: unit } = unitOf(name, view.state); return { what, factor, unit }; };
const timeAxis = (view) => () => { const { factor, name: unit } = unitOf("time", view.state); return { what: timeName(view), factor, unit }; };
const muAxis = (view) => () => quantity(view, view.state.paper ? "μ" : view.seen?.pair ? "⟨elongation²⟩" : "⟨x²⟩", "amplitude_mean_square")();
const timeName = (view) => (view.state.si ? "t" : "Ωt");
const timeOf = (view, t) => t * unitOf("time", view.state).factor;

// a card for each density: of x, v, A and the impact speed, or of the displacement of each of several masses
export function addDensityCards(group) {
  const card = (name, i) => `<div class="card quarter${name === "amplitude" ? " of-paper" : ""}" data-chart="${name}" data-heading="Density of the ${isSeveral ? `displacement of ${escaped(POINTS[i].title)}` : TITLES[name].toLowerCase()}"><div class="card-head"><h3>${isSeveral ? escaped(POINTS[i].title) : TITLES[name]}</h3></div><div class="plot" id="density-${name}"></div></div>`;
  group.insertAdjacentHTML("beforeend", OPENED.densities.map(card).join(""));
}

export function makePanels(view, element, { onOrder }) {
  const small = () => (matchMedia("(max-width: 700px)").matches ? 170 : 190);
  const panels = { x: null };
  panels.traceX = trace(view, element("trace-x"), "x", () => (small() === 170 ? 150 : 182));
  panels.traceV = trace(view, element("trace-v"), "v", () => (small() === 170 ? 150 : 182));
  for (const name of Object.keys(DENSITIES)) panels[name] = density(view, element(`density-${name}`), name, small);
  panels.growth = growth(view, element("growth"), () => 250);
  panels.curve = curve(view, element("curve"), () => 250, onOrder);
  return panels;
}

// what the axes of a path are called
export const saidOf = ({ seen }, what) => (!seen?.pair ? what : what === "x" ? "elongation" : "its velocity");

// --- x(t) and v(t) -------------------------------------------------------------------------------------------------

function trace(view, host, what, height) {
  const chart = new Chart(host, {
    height, x: timeAxis(view), y: () => quantity(view, saidOf(view, what), what)(),
    series: [{ stroke: () => palette.path, width: 1.6, points: { show: false } }],
    xRange: () => view.timeWindow(),
    readout: (t, i) => (i === null || !chart.data[0].length ? [] : [[timeName(view), timeOf(view, chart.data[0][i])], [saidOf(view, what), chart.data[1][i] * unitOf(what, view.state).factor]]),
    yRange: () => (what === "x" ? [view.seen.low - 0.04 * (view.seen.high - view.seen.low), view.seen.high + 0.04 * (view.seen.high - view.seen.low)] : [-view.seen.fastest, view.seen.fastest]),
    draw: (u, g, ratio) => {
      if (what !== "x") return;
      const { left, width, top, height: tall } = u.bbox;
      for (const { position, lower, soft } of view.seen.walls) {
        const y = u.valToPos(position, "y", true);
        g.fillStyle = palette.faint;
        g.globalAlpha = soft ? 0.55 : 1;
        g.fillRect(left, lower ? y : top, width, Math.max(lower ? top + tall - y : y - top, 0));
        g.globalAlpha = 1;
        g.strokeStyle = palette.steel;
        g.lineWidth = 1.5 * ratio;
        g.setLineDash(soft ? [5 * ratio, 4 * ratio] : []);
        g.beginPath();
        g.moveTo(left, y + 0.75 * ratio);
        g.lineTo(left + width, y + 0.75 * ratio);
        g.stroke();
        g.setLineDash([]);
      }
    },
    over: (u, g, ratio) => {
      const [from] = view.timeWindow(), hits = view.track.hits;
      g.fillStyle = g.strokeStyle = palette.impact;
      g.lineWidth = 1.5 * ratio;
      for (let i = hits.length - 1; i >= 0 && hits[i].t >= from; i -= 1) {
        const wall = view.seen.walls.find(({ number }) => number === hits[i].wall);
        if (!wall) continue;
        const speed = wall.sign * hits[i].speed;
        const at = u.valToPos(hits[i].t, "x", true);
        g.beginPath();
        if (what === "x") {
          const y = u.valToPos(wall.position, "y", true), r = 4.5 * ratio, to = wall.lower ? 1 : -1;
          g.moveTo(at, y - 2 * to * ratio);
          g.lineTo(at - r, y + 1.6 * to * r);
          g.lineTo(at + r, y + 1.6 * to * r);
          g.fill();
        } else {
          g.moveTo(at, u.valToPos(-speed, "y", true));
          g.lineTo(at, u.valToPos(wall.restitution(Math.abs(speed)) * speed, "y", true));
          g.stroke();
        }
      }
    },
  });
  chart.update = () => {
    const { track } = view, first = Math.max(track.from(view.timeWindow()[0]) - 1, 0);
    chart.set([track.t.slice(first), (what === "x" ? track.x : track.v).slice(first)]);
  };
  const all = (name) => POINTS.map((point, i) => [isSeveral ? `${point.name}_${name}` : name, view.track.states[i][name]]);
  chart.columns = () => [["t", view.track.t], ...all("x"), ...all("v")];
  return chart;
}

// --- densities -----------------------------------------------------------------------------------------------------

function density(view, host, name, height) {
  const what = DENSITIES[name], place = quantity(view, what, name);
  const tall = () => { const { factor, name: unit } = densityUnitOf(name, view.state); return { what: "density", factor, unit }; };
  const chart = new Chart(host, {
    height, x: place, y: tall, ySize: 48,
    series: NAMES.map((method) => methodSeries(method)),
    xRange: (u, low, high) => {
      const { range } = pinnedDensity(view, name) ?? {};
      if (low === null) return range ?? [0, 1];
      return range ? [Math.min(low, range[0]), Math.max(high, range[1])] : [low, high];
    },
    yRange: () => [0, view.peak[name] > 0 ? SLACK * view.peak[name] : 1],
    readout: (at, i) => {
      const found = view.densities?.[name], bin = found ? found.edges.findIndex((edge) => edge > at) - 1 : -1;
      return [[what, at * place().factor], ["Monte Carlo", (bin >= 0 ? found.density[bin] : 0) * tall().factor],
        ...methodsAt(chart, i, 1, NAMES, tall().factor)];
    },
    draw: (u, g) => {
      const found = view.densities?.[name];
      if (found) bars(u, g, found.edges, found.density, palette["measured-soft"], palette.measured);
      const own = view.reach.find((one) => !one.pair && `${one.name}x` === name);
      for (const wall of own?.walls ?? []) upright(u, g, wall);
    },
    over: (u, g, ratio) => {
      const { edges, density: heights } = pinnedDensity(view, name) ?? {};
      if (edges) outline(u, g, edges, heights, palette.pinned);
      const said = name !== "impact_speed" ? "" : noImpacts(view);
      if (!said) return;
      g.fillStyle = palette.muted;
      g.font = `${13 * ratio}px system-ui, sans-serif`;
      g.textAlign = "center";
      g.fillText(said, u.bbox.left + u.bbox.width / 2, u.bbox.top + u.bbox.height / 2);
    },
  });
  chart.update = () => {
    const place = view.theory?.places[name] ?? edgesOf(view, name);
    const lines = NAMES.map((method) => {
      const curve = view.drawn.has(method) ? view.theory?.methods[method]?.densities[name] : null;
      return curve ?? place.map(() => null);
    });
    const found = view.densities?.[name];
    const inside = found ? Math.max(0, ...found.density) : 0;
    // curves may rise without bound at a lossy wall: the bars then say how high to draw
    const curves = Math.max(0, ...lines.flat().filter(Number.isFinite));
    const nearby = found?.density.length ? Math.min(curves, 1.6 * inside) : curves;
    view.peak[name] = Math.max(inside, nearby, ...(pinnedDensity(view, name)?.density ?? []));
    chart.set([place, ...lines]);
  };
  chart.columns = () => {
    const found = view.densities?.[name], place = view.theory?.places[name] ?? [];
    const theory = NAMES.filter((method) => view.theory?.methods[method]?.densities[name]);
    return [
      ["bin_begin", found ? [...found.edges].slice(0, -1) : []], ["bin_end", found ? [...found.edges].slice(1) : []],
      ["monte_carlo", found ? [...found.density] : []], [name, place],
      ...theory.map((method) => [method, view.theory.methods[method].densities[name]]),
    ];
  };
  return chart;
}

// the place of a wall, dashed for a soft contact
function upright(u, g, { position, soft }) {
  const ratio = devicePixelRatio || 1, at = u.valToPos(position, "x", true);
  g.strokeStyle = palette.steel;
  g.lineWidth = 2 * ratio;
  g.setLineDash(soft ? [5 * ratio, 4 * ratio] : []);
  g.beginPath();
  g.moveTo(at, u.bbox.top);
  g.lineTo(at, u.bbox.top + u.bbox.height);
  g.stroke();
  g.setLineDash([]);
}

function noImpacts(view) {
  if (view.measured?.undefined) return "infinitely many impacts";
  if (!view.walls.length) return "no wall, no impacts";
  return view.measured?.values.impact_rate === 0 ? "no impacts" : "";
}

// what the methods' series, from one of them on, are worth at an index
function methodsAt(chart, index, first, methods, factor) {
  return methods.map((method, k) => [METHODS[method].label, chart.data[first + k]?.[index] ?? null])
    .filter(([, value]) => value !== null).map(([label, value]) => [label, value * factor]);
}

function edgesOf(view, name) {
  const edges = view.densities?.[name]?.edges;
  if (edges?.length > 1) return Array.from(edges);
  const own = view.reach.find((one) => !one.pair && `${one.name}x` === name);
  return own ? [own.low, own.high] : [0, 1];
}

// --- mu(t) ---------------------------------------------------------------------------------------------------------

function growth(view, host, height) {
  const chart = new Chart(host, {
    height, x: timeAxis(view), y: muAxis(view),
    series: [
      { stroke: () => "transparent", points: { show: false } }, { stroke: () => "transparent", points: { show: false } },
      { stroke: () => palette.measured, width: 2, points: { show: false } },
      ...NAMES.map((method) => methodSeries(method)),
    ],
    bands: [{ series: [1, 2], fill: () => palette["measured-soft"] }],
    xRange: (u, low, high) => [0, high ?? 1],
    readout: (t, i) => {
      if (i === null || !view.growth) return [];
      const { factor } = muAxis(view)(), grown = view.grown?.[view.chosen];
      const measured = grown ? withError(grown.mean[i] * factor, grown.error[i] * factor) : "–";
      return [[timeName(view), timeOf(view, chart.data[0][i])], ["Monte Carlo", measured], ...methodsAt(chart, i, 4, NAMES, factor)];
    },
    yRange: (u, low, high) => [0, SLACK * Math.max(high ?? 0, ...(pinnedGrowth(view)?.mean ?? []), 0) || 1],
    draw: (u, g, ratio) => {
      const begin = view.measured?.settings.window[0], { left, width, top, height: tall } = u.bbox;
      if (begin === undefined || begin >= u.scales.x.max) return;
      const at = u.valToPos(begin, "x", true);
      g.fillStyle = palette.faint;
      g.globalAlpha = 0.6;
      g.fillRect(at, top, left + width - at, tall);
      g.globalAlpha = 1;
    },
    over: (u, g) => {
      const pin = pinnedGrowth(view);
      if (pin) polyline(u, g, pin.times, pin.mean, palette.pinned);
    },
  });
  chart.update = () => {
    const times = view.growth?.times ?? [0, 1], none = times.map(() => null);
    // times come with the curves: those of an older question are not this ensemble's
    const own = view.grown?.[view.chosen], grown = !view.old.growth && own?.mean.length === times.length ? own : null;
    const error = (sign) => (grown ? Array.from(grown.mean, (m, i) => m + sign * 2 * (grown.error[i] || 0)) : none);
    const lines = NAMES.map((method) => (view.drawn.has(method) ? view.growth?.methods[view.chosen]?.[method] : null) ?? none);
    chart.set([times, error(1), error(-1), grown ? Array.from(grown.mean) : none, ...lines]);
  };
  chart.columns = () => {
    const { mean = [], error = [] } = view.grown?.[view.chosen] ?? {}, methods = Object.entries(view.growth?.methods[view.chosen] ?? {});
    return [["t", view.growth?.times ?? []], ["monte_carlo", [...mean]], ["monte_carlo_se", [...error]], ...methods];
  };
  return chart;
}

// --- mu over alpha -------------------------------------------------------------------------------------------------

function curve(view, host, height, onOrder) {
  const chart = new Chart(host, {
    height, x: () => ({ what: "α", factor: 1, unit: "" }), y: muAxis(view), yLog: true,
    series: CURVES.map((method) => methodSeries(method)),
    xRange: () => [-0.02, 1.02], // a marker at either end is seen whole
    readout: (order, i) => (i === null || !view.curve ? [] : [["α", chart.data[0][i]], ...methodsAt(chart, i, 1, CURVES, muAxis(view)().factor)]),
    yRange: () => {
      const curves = CURVES.flatMap((method) => view.curve?.methods[method] ?? []);
      const all = [...curves, view.marker?.value, pinnedMarker(view)?.value].filter((v) => v > 0);
      return all.length ? [roundBelow(Math.min(...all) / 1.1), Math.max(...all) * 1.25] : [0.1, 10];
    },
    over: (u, g, ratio) => {
      const at = u.valToPos(orderOf(view.values, view.state.paper) ?? 0, "x", true);
      g.strokeStyle = palette.muted;
      g.setLineDash([4 * ratio, 4 * ratio]);
      g.lineWidth = ratio;
      g.beginPath();
      g.moveTo(at, u.bbox.top);
      g.lineTo(at, u.bbox.top + u.bbox.height);
      g.stroke();
      g.setLineDash([]);
      const pin = pinnedMarker(view);
      if (pin?.value > 0) marker(u, g, ratio, pin, palette.pinned, true);
      if (view.marker?.value > 0) marker(u, g, ratio, view.marker, palette.measured, false);
    },
  });
  chart.host.addEventListener("click", (event) => {
    if (!ORDERS.length) return;
    const { left, right } = chart.plot.over.getBoundingClientRect(), order = chart.plot.posToVal(event.clientX - left, "x");
    if (event.clientX >= left && event.clientX <= right) onOrder(Math.round(100 * Math.min(Math.max(order, 0), 1)) / 100);
  });
  chart.update = () => {
    const orders = view.curve?.orders ?? [0, 1];
    // the line goes on through what is still to come (undefined), and not through what has no answer (null)
    const coming = new Set(view.curve?.missing ?? []);
    chart.set([orders, ...CURVES.map((method) => (view.curve?.methods[method] ?? orders.map(() => null))
      .map((value, i) => (value === null && METHODS[method].over_order === "one by one" && coming.has(i) ? undefined : value)))]);
  };
  chart.columns = () => [
    ["order", view.curve?.orders ?? []], ...CURVES.map((method) => [method, view.curve?.methods[method] ?? []]),
  ];
  return chart;
}

function marker(u, g, ratio, { order, value, error }, fill, square) {
  const x = u.valToPos(order, "x", true), y = (v) => u.valToPos(v, "y", true), r = 5 * ratio;
  g.strokeStyle = palette.text;
  g.fillStyle = fill;
  g.lineWidth = 2 * ratio;
  g.beginPath();
  g.moveTo(x, y(value + 2 * (error || 0)));
  g.lineTo(x, y(Math.max(value - 2 * (error || 0), 1e-3 * value)));
  g.stroke();
  g.beginPath();
  if (square) g.rect(x - r, y(value) - r, 2 * r, 2 * r); else g.arc(x, y(value), r, 0, 7);
  g.fill();
  g.stroke();
}

// ticks of a logarithmic axis are counted from its lower end
function roundBelow(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  return Number((Math.floor(value / decade) * decade).toPrecision(1));
}

// those that have an answer here
export const curvesShown = (view) => CURVES.filter((method) => view.curve?.methods[method]?.some((v) => v !== null));

export function legend(methods, pinned) {
  const measured = '<span class="swatch box"></span>Monte Carlo';
  const other = pinned ? ['<span class="swatch pinned"></span>pinned'] : [];
  return [measured, ...methods.map((m) => `<span class="swatch" data-method="${m}"></span>${METHODS[m].label}`), ...other]
    .map((item) => `<span class="item">${item}</span>`).join("");
}

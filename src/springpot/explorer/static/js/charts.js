// uPlot with this page's axes, colors and sizes.

import { ticks } from "./canvas.js";
import { palette, onTheme } from "./theme.js";
import { METHODS } from "/methods.js";
import { exponentFor, scaledUnit, short } from "./numbers.js";
import { withUnit } from "./units.js";

const FONT = "12px system-ui, sans-serif";
const SPACE = 14; // px between two numbers below a chart
const all = new Set();
onTheme(() => all.forEach((chart) => chart.plot?.redraw(false)));

// quantity: of now, { what, factor, unit }; numbers far from 1 are shown without a power of ten, which is in the label
const axis = (scale, quantity, size, log = false) => {
  const exponent = (u) => {
    const { min, max } = u.scales[scale];
    return log ? 0 : exponentFor(Math.max(Math.abs(min), Math.abs(max)) * quantity().factor);
  };
  return {
    label: (u) => withUnit(quantity().what, scaledUnit(exponent(u), quantity().unit)),
    labelSize: 20, labelFont: FONT, font: FONT, size, gap: 4, labelGap: 0,
    stroke: () => palette.muted,
    ...(scale === "x" ? { space: (u, _, low, high) => SPACE + longest(u, low, high, quantity, exponent) } : {}),
    grid: { stroke: () => palette.faint, width: 1 },
    ticks: { stroke: () => palette.faint, width: 1, size: 4 },
    // round in the unit that is shown
    splits: (u, _, low, high, increment) => {
      const { factor } = quantity(), power = Math.log10(factor);
      if (log) return decades(low * factor, high * factor).map((v) => v / factor);
      if (Math.abs(power - Math.round(power)) < 1e-9) return multiples(low, high, increment);
      return ticks(low * factor, high * factor, (high - low) / increment).map((v) => v / factor);
    },
    values: (u, splits) => splits.map((v) => (v === null ? "" : short((v * quantity().factor) / 10 ** exponent(u), 4))),
  };
};

// how wide the longer one of the numbers near both ends of an axis is, in px: 7 for each sign
function longest(u, low, high, quantity, exponent) {
  const said = (value) => short((value * quantity().factor) / 10 ** exponent(u), 2).length;
  return 7 * Math.max(5, said(low), said(high));
}

export const methodSeries = (name, width = 2) => ({
  label: METHODS[name].label, stroke: () => palette[name], width, dash: METHODS[name].dash, points: { show: false },
});

function multiples(low, high, step) {
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high * (1 + 1e-9); i += 1) found.push(i === 0 ? 0 : i * step);
  return found;
}

function decades(low, high) {
  const found = [];
  for (let power = Math.floor(Math.log10(low)); 10 ** power <= high; power += 1) {
    for (let digit = 1; digit < 10; digit += 1) found.push(Number(`${digit}e${power}`));
  }
  return found.filter((v) => v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9));
}

// labels of a logarithmic axis: 1, 2, 5; all of them where there is less than a decade, 1 only where there are many
const ofLogarithm = (scale, quantity) => (u, splits) => {
  const { factor } = quantity(), ratio = u.scales[scale].max / u.scales[scale].min, few = ratio < 12, shown = ratio > 3e3 ? /^1/ : /^[125]/;
  return splits.map((v) => (few || shown.test(Number((v * factor).toPrecision(6)).toExponential()) ? v : null));
};

export class Chart {
  // x, y: functions that give what is on the axes, see axis; the data stay in the page's own units
  // draw: called with (plot, context) under the lines; over: above them
  // readout: of a place on the x axis, [[name, value], ...] to show there
  constructor(host, { height, x, y, series, draw, over, readout, xLog = false, yLog = false, xRange, yRange, bands, ySize = 52 }) {
    this.host = host;
    this.tip = document.createElement("div");
    this.tip.className = "tip";
    this.tip.hidden = true;
    host.append(this.tip);
    this.height = height;
    this.options = {
      width: 300, height: height(),
      padding: [8, 18, 0, 0], // half of the last number of an axis has room
      legend: { show: false },
      cursor: { drag: { x: false, y: false }, points: { show: false }, y: false },
      scales: {
        x: { time: false, distr: xLog ? 3 : 1, range: xRange },
        y: { distr: yLog ? 3 : 1, range: yRange },
      },
      axes: [
        { ...axis("x", x, 30, xLog), ...(xLog ? { filter: ofLogarithm("x", x) } : {}) },
        { ...axis("y", y, ySize, yLog), ...(yLog ? { filter: ofLogarithm("y", y) } : {}) },
      ],
      series: [{}, ...series],
      bands,
      hooks: {
        drawAxes: draw ? [(u) => clipped(u, draw)] : [],
        draw: over ? [(u) => clipped(u, over)] : [],
        setCursor: readout ? [(u) => this.tell(u, readout)] : [],
      },
    };
    this.data = [[], ...series.map(() => [])];
    this.make();
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(host);
    all.add(this);
  }

  destroy() {
    all.delete(this);
    this.observer.disconnect();
    this.plot.destroy();
    this.tip.remove();
  }

  tell(u, readout) {
    const { left, top } = u.cursor, outside = left === undefined || left < 0 || top < 0;
    const found = outside ? [] : readout(u.posToVal(left, "x"), u.cursor.idx);
    this.tip.hidden = !found.length;
    if (!found.length) return;
    this.tip.replaceChildren(...found.map(([name, value]) => {
      const line = document.createElement("div");
      line.textContent = `${name} ${typeof value === "number" ? short(value) : value}`;
      return line;
    }));
    const place = u.over.offsetLeft + left, wide = this.tip.offsetWidth;
    this.tip.style.left = `${Math.max(place + wide + 14 > this.host.clientWidth ? place - wide - 10 : place + 10, 0)}px`;
  }

  make() {
    this.plot?.destroy();
    this.options.width = Math.max(this.host.clientWidth, 120);
    this.options.height = this.height();
    this.plot = new uPlot(this.options, this.data, this.host);
  }

  resize() {
    const width = Math.max(this.host.clientWidth, 120), height = this.height();
    if (width !== this.plot.width || height !== this.plot.height) this.plot.setSize({ width, height });
  }

  set(data) {
    this.data = data;
    this.plot.setData(data, true);
  }

  relabel() { this.plot.redraw(false, true); }

  // a copy at a size fit for a report, whatever the size on the page; nobody sees the change between two frames
  async snapshot(width, height) {
    this.plot.setSize({ width, height });
    await Promise.resolve();
    const { canvas } = this.plot.ctx, copy = document.createElement("canvas");
    copy.width = canvas.width;
    copy.height = canvas.height;
    copy.getContext("2d").drawImage(canvas, 0, 0);
    this.plot.setSize({ width: Math.max(this.host.clientWidth, 120), height: this.height() });
    return copy;
  }
}

function clipped(u, draw) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  draw(u, ctx, devicePixelRatio || 1);
  ctx.restore();
}

// bars between edges, from the bottom up to a density
export function bars(u, ctx, edges, density, fill, stroke) {
  if (!density.length) return;
  const floor = u.valToPos(0, "y", true);
  ctx.beginPath();
  ctx.moveTo(u.valToPos(edges[0], "x", true), floor);
  for (let i = 0; i < density.length; i += 1) {
    const top = u.valToPos(density[i], "y", true);
    ctx.lineTo(u.valToPos(edges[i], "x", true), top);
    ctx.lineTo(u.valToPos(edges[i + 1], "x", true), top);
  }
  ctx.lineTo(u.valToPos(edges[density.length], "x", true), floor);
  ctx.fillStyle = fill;
  ctx.fill();
  ctx.strokeStyle = stroke;
  ctx.lineWidth = devicePixelRatio || 1;
  ctx.stroke();
}

// the same as a line only, dotted
export function outline(u, g, edges, density, color) {
  const places = [], heights = [];
  density.forEach((height, i) => { places.push(edges[i], edges[i + 1]); heights.push(height, height); });
  polyline(u, g, places, heights, color);
}

export const PINNED_DASH = [3, 3];

export function polyline(u, g, places, heights, color) {
  const ratio = devicePixelRatio || 1;
  g.beginPath();
  places.forEach((place, i) => g.lineTo(u.valToPos(place, "x", true), u.valToPos(heights[i], "y", true)));
  g.strokeStyle = color;
  g.lineWidth = 2 * ratio;
  g.setLineDash(PINNED_DASH.map((dash) => dash * ratio));
  g.stroke();
  g.setLineDash([]);
}

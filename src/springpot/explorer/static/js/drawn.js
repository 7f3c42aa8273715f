// Charts whose axes, lines and bars the server states: of the excitation, and of what a run was asked for.

import { Chart, bars } from "./charts.js";
import { csv, save } from "./share.js";
import { escaped } from "./table.js";
import { palette } from "./theme.js";
import { unitShown } from "./units.js";

const COLORS = ["path", "impact", "pinned", "mass", "steel"], DASHES = [[], [8, 4], [2, 3]];
const colorOf = (i) => palette[COLORS[i % COLORS.length]], dashOf = (i) => DASHES[Math.floor(i / COLORS.length) % DASHES.length];

export class Drawn {
  constructor(host, name) {
    Object.assign(this, { host, name, charts: [], text: "" });
  }

  // the same charts are not drawn anew
  show(stated) {
    const text = JSON.stringify(stated);
    if (text === this.text) return;
    this.text = text;
    for (const chart of this.charts) chart.destroy();
    this.host.replaceChildren();
    this.charts = stated.map((one, i) => this.add(one, i));
  }

  add(stated, number) {
    const { title, note = "", at, lines, bars: heights = null } = stated, box = document.createElement("div");
    const legend = lines.length > 1 ? lines.map(({ name }, i) => `<span class="item"><span class="dash-mark" data-line="${i}"></span>${escaped(name)}</span>`).join("") : "";
    box.innerHTML = `<div class="card-head"><h3>${escaped(title)}</h3><span class="legend">${legend}</span><span class="tools"><button type="button" class="tool" aria-label="${escaped(title)} as CSV">CSV</button></span></div><div class="plot"></div><p class="caption">${escaped(note)}</p>`;
    this.host.append(box);
    for (const mark of box.querySelectorAll("[data-line]")) mark.style.borderTop = `2.5px ${["solid", "dashed", "dotted"][Math.floor(mark.dataset.line / COLORS.length) % 3]} var(--${COLORS[mark.dataset.line % COLORS.length]})`;
    box.querySelector(".tool").addEventListener("click", () => {
      const columns = heights ? [["bin_begin", at.slice(0, -1)], ["bin_end", at.slice(1)], ["density", heights]]
        : [[stated.x[0], at], ...lines.flatMap(({ name, values, low, high }) => [[name, values], ...(low ? [[`${name} low`, low], [`${name} high`, high]] : [])])];
      save(`springpot-${this.name}-${number + 1}.csv`, csv(`${title}; ${stated.x.join(" in ")}; ${stated.y.join(" in ")}`, columns));
    });
    return this.draw(box.querySelector(".plot"), stated, heights);
  }

  draw(host, { x, y, at, lines, logarithmic = false, mark = null }, heights) {
    const [quantity, tall] = [x, y].map(([what, unit]) => () => ({ what, factor: 1, unit }));
    const hidden = { stroke: () => "transparent", points: { show: false } };
    const series = lines.flatMap((_, i) => [hidden, hidden, { stroke: () => colorOf(i), width: 2, dash: dashOf(i), points: { show: false } }]);
    const none = at.map(() => null), edge = 0.03 * (at.at(-1) - at[0]);
    const all = [...lines.flatMap(({ values, low = [], high = [] }) => [...values, ...low, ...high]), ...(heights ?? [])].filter(Number.isFinite);
    const low = Math.min(0, ...all), high = Math.max(0, ...all), xLog = logarithmic === true;
    const chart = new Chart(host, {
      height: () => 220, x: quantity, y: tall, series: series.length ? series : [hidden], xLog, yLog: Boolean(logarithmic), ySize: 58,
      bands: lines.map((_, i) => ({ series: [3 * i + 1, 3 * i + 2], fill: () => palette["measured-soft"] })),
      // the last numbers of the axis have room
      xRange: () => (xLog ? [at[0] / 1.04, at.at(-1) * 1.04] : heights ? [at[0] - edge, at.at(-1) + edge] : [at[0], at.at(-1)]),
      // a logarithmic axis shows a whole decade at least
      yRange: () => (logarithmic ? [10 ** Math.floor(Math.log10(Math.min(...all)) - 0.05), 10 ** Math.ceil(Math.log10(high) + 0.05)] : [low, 1.06 * high || 1]),
      readout: (place, i) => (heights ? [[x[0], place], [y[0], heights[at.findIndex((edge) => edge > place) - 1] ?? 0]]
        : i === null ? [] : [[x[0], at[i]], ...lines.map(({ name, values }) => [name, values[i]])]),
      draw: (u, g, ratio) => {
        if (heights) bars(u, g, at, heights, palette["measured-soft"], palette.measured);
        if (mark === null) return;
        const there = u.valToPos(mark, "x", true);
        g.strokeStyle = palette.muted;
        g.lineWidth = ratio;
        g.setLineDash([4 * ratio, 4 * ratio]);
        g.beginPath();
        g.moveTo(there, u.bbox.top);
        g.lineTo(there, u.bbox.top + u.bbox.height);
        g.stroke();
        g.setLineDash([]);
      },
    });
    chart.set([at, ...(series.length ? lines.flatMap(({ values, low: under, high: over }) => [over ?? none, under ?? none, values]) : [none])]);
    return chart;
  }
}

// a chart of the server's units in those of the page
export function inUnits(stated, state) {
  const [x, y] = [stated.x, stated.y].map(([what, unit]) => ({ what, ...unitShown(unit, state) }));
  const times = (values, { factor }) => values && (factor === 1 ? values : values.map((value) => (value === null ? null : value * factor)));
  return {
    ...stated, x: [x.what, x.name], y: [y.what, y.name], at: times(stated.at, x), bars: times(stated.bars, y), mark: stated.mark && stated.mark * x.factor,
    lines: stated.lines.map((line) => ({ ...line, values: times(line.values, y), low: times(line.low, y), high: times(line.high, y) })),
  };
}

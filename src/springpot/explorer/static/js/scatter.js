// Devices that differ by the tolerances of their numbers: how results scatter, and which number matters.

import { Request } from "./requests.js";
import { wholeName, PARAMETERS } from "./problem.js";
import { escaped } from "./table.js";

const SCATTER = `
  <form id="scatter-form" autocomplete="off">
    <div class="many"><label>devices <select name="devices"><option>256</option><option selected>512</option><option>1024</option><option>2048</option></select></label></div>
    <div class="fit-ask"><button type="submit" class="button primary" id="scatter-run">Simulate devices</button><button type="button" class="button" id="scatter-stop" hidden>Stop</button><progress id="scatter-progress" max="1" hidden aria-label="Share of the devices done"></progress></div>
  </form>
  <p id="scatter-numbers-of" class="caption"></p>
  <p id="scatter-said" class="caption" role="status"></p>
  <div id="scatter-found" hidden>
    <label class="many">result <select id="scatter-of"></select></label>
    <div class="scatter-shown">
      <div><table id="scatter-numbers"></table><div id="scatter-charts"></div></div>
      <div id="scatter-matters"><h3>Which input matters: share of the variance between devices</h3><div class="bars" id="scatter-bars"></div>
        <p class="caption">Alone: what would go if this number had no tolerance. With all others: what would stay if it alone had one.</p></div>
    </div>
  </div>
  <div id="scatter-warnings" class="warnings"></div>`;

const percent = ([value, low, high]) => `${(100 * value).toFixed(1)} % (${(100 * low).toFixed(1)} to ${(100 * high).toFixed(1)})`.replaceAll("-", "−");
const place = (share) => `${100 * Math.min(Math.max(share, 0), 1)}%`;

export class ScatterCard extends Request {
  constructor(element, connection, state, controls) {
    super(element, connection, state, { name: "scatter", content: SCATTER, kind: "scatter", stop: "stop-scatter", caption: "The result from device to device" });
    for (const name of ["found", "of", "bars", "matters", "numbers-of"]) this[name] = element(`scatter-${name}`);
    this.controls = controls;
    this.of.addEventListener("change", () => this.show());
    connection.addEventListener("accepted", () => this.list());
    this.list();
  }

  asked() { return { kind: "scatter", devices: Number(this.fields.devices.value) }; }

  // the numbers that have a tolerance
  list() {
    const said = Object.keys(PARAMETERS).map((name) => [wholeName(name), this.controls.saidTolerance(name)]).filter(([, tolerance]) => tolerance);
    this["numbers-of"].textContent = said.length ? `Devices differ in ${said.map((words) => words.join(" ")).join("; ")}. All else on the page is of the nominal device.`
      : "No number has a tolerance: tick Tolerances above the sliders, and say how much numbers differ.";
  }

  take({ results, ...found }) {
    super.take({ ...found, numbers: undefined });
    if (found.numbers) results = []; // forgotten
    if (!results) return;
    this.results = results;
    this.found.hidden = !results.length;
    const before = this.of.value;
    this.of.replaceChildren(...results.map(({ title }) => new Option(title, title)));
    if (results.some(({ title }) => title === before)) this.of.value = before;
    if (results.length) this.show();
  }

  // an input by the numbers of the system that it is, with the name that the file gives it
  nameOf(input) {
    const whose = Object.keys(PARAMETERS).filter((name) => PARAMETERS[name].tolerance.name === input), isNamed = whose.some((name) => name.replaceAll("-", "_") !== input);
    return `${isNamed ? `${input}: ` : ""}${whose.map(wholeName).join(" and ") || input}`;
  }

  show() {
    const { numbers, charts, inputs, left } = this.results.find(({ title }) => title === this.of.value);
    super.take({ running: false, fault: "", numbers, charts });
    this.matters.hidden = !inputs.length;
    const row = (kind, words, share) => `<span class="how">${words}</span><span class="track ${kind}"><span class="bar"></span><span class="interval"></span></span><span class="number">${percent(share)}</span>`;
    this.bars.innerHTML = inputs.map(({ name, alone, together }) => `<h4>${escaped(this.nameOf(name))}</h4>${row("alone", "alone", alone)}${row("together", "with all others", together)}`).join("")
      + (left ? `<h4>not explained</h4>${row("left", "", left)}` : "");
    const shares = [...inputs.flatMap(({ alone, together }) => [alone, together]), left];
    [...this.bars.querySelectorAll(".track")].forEach((track, i) => {
      const [value, low, high] = shares[i], [bar, interval] = track.children;
      bar.style.width = place(value);
      interval.style.left = place(low);
      interval.style.right = place(1 - high);
    });
  }
}

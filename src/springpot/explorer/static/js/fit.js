// A file of measured data beside the system: it is read here, and the server fits the ticked numbers to it.

import { send } from "./files.js";
import { PARAMETERS, wholeName } from "./problem.js";
import { short, withError } from "./numbers.js";

const ADVICE = { large: ": fit it with the command springpot fit.", binary: ": save its table as CSV." };

export class FitCard {
  constructor(element, connection, controls) {
    Object.assign(this, { connection, controls });
    for (const name of ["file", "run", "stop", "running", "progress", "said", "use", "many", "count", "set", "note", "free", "plot", "residuals", "legend", "table", "statistics", "warnings"]) this[name] = element(`fit-${name}`);
    this.found = null;
    this.charts = [];
    this.ready = false;
    this.file.addEventListener("change", () => this.send(this.file.files[0]));
    this.run.addEventListener("click", () => connection.fit(controls.ticked()));
    this.stop.addEventListener("click", () => {
      this.stop.disabled = true;
      connection.stopFit();
    });
    this.use.addEventListener("click", () => this.take());
    this.count.addEventListener("input", () => this.showCount());
    controls.onTick = () => this.showFree();
    this.send(this.file.files[0]); // chosen before this was loaded
    connection.addEventListener("data", ({ detail }) => this.taken(detail));
    connection.addEventListener("fit", ({ detail }) => this.fitted(detail));
    connection.addEventListener("connection", ({ detail }) => { if (detail.open && this.sent) this.send(this.sent); }); // another session
  }

  async send(file) {
    if (!file) return;
    this.forget();
    this.sent = file;
    this.say(`reading ${file.name}…`);
    const fault = await send(file, "data", this.connection, ADVICE, { wanted: () => this.sent === file });
    if (fault) this.say(fault, true);
  }

  forget() {
    this.found = null;
    this.work({ running: false });
    this.ready = false;
    this.clear();
    for (const host of [this.plot, this.residuals, this.legend, this.table, this.statistics, this.warnings, this.set]) host.replaceChildren();
    document.getElementById("fit").classList.add("unasked"); // is left out on paper
    this.use.hidden = this.many.hidden = true;
    this.run.disabled = true;
  }

  taken({ name, said, fault }) {
    this.ready = !fault;
    if (!fault) document.body.classList.add("fitting");
    this.say(fault || `${name}: ${said}.`, Boolean(fault));
    this.showFree();
  }

  showFree() {
    const ticked = this.controls.ticked();
    this.free.textContent = !this.ready ? "" : ticked.length ? `To be found: ${ticked.map(wholeName).join("; ")}.` : "Tick the numbers that are to be found, beside their sliders.";
    this.run.disabled = !this.ready || !ticked.length;
  }

  async fitted(found) {
    this.work(found);
    if (found.running) return;
    this.showFree();
    if (found.fault) return this.say(found.fault, true);
    const { sent } = this, { drawFit } = await import("./fitted.js"); // with the first fit
    if (this.sent !== sent) return; // another file
    this.found = found;
    this.use.hidden = false;
    this.many.hidden = !found.values.some(({ adds }) => adds);
    this.set.textContent = "";
    this.showCount();
    this.warnings.replaceChildren(...found.warnings.map((sentence) => Object.assign(document.createElement("p"), { textContent: sentence })));
    this.clear();
    document.getElementById("fit").classList.remove("unasked");
    if (found.statistics.length) this.list(found.statistics); else this.charts = drawFit(this, found);
  }

  // how many of what was measured the device has
  get times() { return this.many.hidden || !this.count.checkValidity() || !this.count.value ? 1 : Number(this.count.value); }

  showCount() {
    const { times } = this, these = times > 1 ? `${times} of these mounts` : "these numbers";
    this.use.textContent = `Set the sliders to ${these}`;
    this.count.setAttribute("aria-invalid", String(!this.count.value || !this.count.checkValidity()));
    this.table.innerHTML = `<thead><tr><th scope="col">number</th><th scope="col">value</th><th scope="col">95 % interval</th>${times > 1 ? `<th scope="col">${these}</th>` : ""}</tr></thead><tbody></tbody>`;
    for (const { name, value, error, interval, bound, adds } of this.found.values) {
      const row = this.table.tBodies[0].insertRow(), head = document.createElement("th"), { unit } = PARAMETERS[name];
      head.scope = "row";
      head.textContent = wholeName(name);
      row.append(head);
      row.insertCell().textContent = `${withError(value, error)}${unit ? ` ${unit}` : ""}`;
      row.insertCell().textContent = bound ? `held at its ${bound === "low" ? "lower" : "upper"} bound` : `${short(interval[0])} to ${short(interval[1])}`;
      if (times > 1) row.insertCell().textContent = short(adds ? times * value : value);
    }
  }

  // side by side, stiffnesses and coefficients add up, and orders stay
  take() {
    const { times } = this;
    this.controls.set(Object.fromEntries(this.found.values.map(({ name, value, adds }) => [name, adds ? times * value : value])), null);
    this.set.textContent = times > 1 ? `The sliders were set to ${times} of these mounts: ${times} times the stiffness and the coefficients, and the same orders.` : "";
  }

  // statistics have many units: they stand in a table
  list(statistics) {
    this.statistics.innerHTML = '<thead><tr><th scope="col">statistic, in SI units</th><th scope="col">measured</th><th scope="col">fit</th><th scope="col">difference in standard errors</th></tr></thead><tbody></tbody>';
    for (const { name, data, error, fitted, residual } of statistics) {
      const row = this.statistics.tBodies[0].insertRow();
      row.append(Object.assign(document.createElement("th"), { scope: "row", textContent: name.replaceAll("_", " ") }));
      for (const text of [withError(data, error), short(fitted), residual.toFixed(1).replace("-", "−")]) row.insertCell().textContent = text;
    }
  }

  // how far a fit is, while it runs
  work({ running, done, seconds }) {
    this.run.disabled = running;
    this.run.textContent = running ? "Fitting…" : "Fit";
    if (this.running.hidden === running) this.stop.disabled = !running;
    this.running.hidden = this.stop.hidden = !running;
    if (done > 0) this.progress.value = done; else this.progress.removeAttribute("value");
    const left = seconds === null || seconds === undefined ? "looking for where to simulate" : `about ${seconds < 90 ? `${Math.max(Math.ceil(seconds), 1)} s` : `${Math.ceil(seconds / 60)} min`} left`;
    this.said.textContent = !running || done === null ? "" : this.stop.disabled ? "stopping…" : left;
  }

  clear() {
    this.charts.forEach((chart) => chart.destroy());
    this.charts = [];
    this.plot.hidden = this.residuals.hidden = true;
  }

  say(sentence, wrong = false) {
    this.note.textContent = sentence;
    this.note.classList.toggle("wrong", wrong);
  }
}

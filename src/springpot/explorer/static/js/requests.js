// What is asked beside the moments: a table of densities for the excitation, and forces, cycles, passages, profiles of a run.

import { Drawn, inUnits } from "./drawn.js";
import { send, takeNote } from "./files.js";
import { OPENED } from "./problem.js";
import { escaped } from "./table.js";
import { typeset } from "./numbers.js";
import { unitShown } from "./units.js";

const { displacements, forces, of_impacts: ofImpacts } = OPENED.offered;

const EXCITATION = `
  <label class="many" hidden>densities in <select id="density-unit"><option value="psd">(m/s²)²/Hz</option><option value="g">g²/Hz</option></select></label>
  <div class="charts" id="excitation-charts"></div>
  <details id="table-ask">
    <summary>Another table of densities</summary>
    <p class="caption">One line for each break point, with the units in the header: frequency_Hz or frequency_rad/s, and psd_g2/Hz, psd_m2/s4/Hz or psd_N2/Hz, one-sided. Between the points the density is a straight line on logarithmic axes. The table takes the place of the present one, or of white, colored or Kanai-Tajimi noise.</p>
    <textarea id="table-text" spellcheck="false" aria-label="Table of densities"></textarea>
    <label class="many">unit of the densities, if the header has none <select id="table-unit"><option value="">–</option><option value="g2/Hz">g²/Hz</option><option value="m2/s4/Hz">(m/s²)²/Hz</option><option value="N2/Hz">N²/Hz</option></select></label>
    <div class="fit-ask"><button type="button" class="button primary" id="table-use">Use this table</button>
      <label class="button">File… <input type="file" id="table-file" accept=".csv,.txt,.tsv,.dat,.asc,.mat,.uff,.unv,.58,text/csv,text/plain" class="sr"></label></div>
  </details>
  <p id="table-said" class="caption" role="status"></p>
  <p id="table-note" class="caption wrong" role="status"></p>`;

const ASKED = `
  <form id="asked-form" autocomplete="off">
    <fieldset><legend>Forces and accelerations: mean, rms and histogram</legend><div id="asked-forces" class="many"></div></fieldset>
    <fieldset><legend>First passage of levels</legend><div class="many"><label>of <select name="levels_of" aria-label="First passage of"></select></label><label>levels <input name="levels" type="text" inputmode="decimal" placeholder="0.003 0.004"></label></div></fieldset>
    <fieldset><legend>Rainflow cycles and damage</legend><div class="many"><label>of <select name="cycles_of" aria-label="Cycles of"><option value="">nothing</option></select></label><label>slope k <input name="exponent" type="number" min="1" max="50" step="any" value="5" required></label><label>amplitude <input name="strength" type="number" min="0" step="any" value="1" required></label><label>endured for cycles <input name="cycles" type="number" min="0" step="any" value="1000000" required></label></div></fieldset>
    <fieldset><legend>Profile over time: mean squares and impact rate</legend><div class="many"><label>bins <input name="bins" type="number" min="0" max="400" step="1" value="0" required></label></div></fieldset>
    <div class="fit-ask"><button type="submit" class="button primary" id="asked-run">Simulate</button><button type="button" class="button" id="asked-stop" hidden>Stop</button><progress id="asked-progress" max="1" hidden aria-label="Share of the simulation done"></progress></div>
  </form>
  <p id="asked-said" class="caption" role="status"></p>
  <div class="charts" id="asked-charts"></div>
  <div class="scroll" tabindex="0" role="region" aria-label="Table of forces, cycles and passages"><table id="asked-numbers"></table></div>
  <div id="asked-warnings" class="warnings"></div>`;

export class ExcitationCard {
  constructor(element, connection, state) {
    element("excitation").insertAdjacentHTML("beforeend", EXCITATION);
    const note = element("table-note"), text = element("table-text"), say = (said) => { note.textContent = said; };
    const take = async (file) => say(file ? await send(file, "table", connection, { large: ".", binary: ": save it as CSV." }, { unit: element("table-unit").value }) : "");
    this.drawn = new Drawn(element("excitation-charts"), "excitation");
    this.card = element("excitation");
    text.value = OPENED.table;
    text.rows = Math.min(Math.max(OPENED.table.split("\n").length + 1, 4), 12);
    element("table-ask").hidden = !OPENED.table;
    element("table-use").addEventListener("click", () => take(new File([text.value], "the table")));
    element("table-file").addEventListener("change", ({ target }) => { take(target.files[0]); target.value = ""; });
    this.refuse = say;
    element("table-said").textContent = takeNote();
    this.unit = element("density-unit");
    this.unit.addEventListener("change", () => state.setShown("excitation", this.unit.value));
  }

  show(charts, state) {
    const inDensity = charts.some(({ y: [, unit] }) => unit === "(m/s²)²/Hz");
    this.drawn.show(charts.map((one) => inUnits(one, state)));
    this.card.hidden = !charts.length && !OPENED.table;
    this.card.classList.toggle("unasked", !charts.length);
    this.unit.parentElement.hidden = !inDensity;
    this.unit.value = state.shown.excitation === "g" ? "g" : "psd";
  }
}

// what the server works out for a form of the page: how far it is, what it has found, and its end
export class Request {
  constructor(element, connection, state, { name, content, kind, stop, caption }) {
    this.state = state;
    this.units = []; // of the choices
    element(name).insertAdjacentHTML("beforeend", content);
    this.card = element(name);
    for (const part of ["form", "run", "stop", "progress", "said", "numbers", "warnings"]) this[part] = element(`${name}-${part}`);
    this.fields = this.form.elements;
    this.drawn = new Drawn(element(`${name}-charts`), name);
    this.caption = caption;
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      connection.send({ ...this.asked(), length: state.shown.length });
    });
    state.onChange(() => this.showUnits());
    this.stop.addEventListener("click", () => connection.send({ kind: stop }));
    connection.addEventListener(kind, ({ detail }) => this.take(detail));
    connection.addEventListener("asked", () => this.forget());
  }

  // what a field may choose; but what cannot be seen
  offer(field, things) {
    for (const [value, words, unit] of things.filter(([, , , why]) => !why)) {
      const option = new Option("", value);
      field.append(option);
      this.units.push(() => { option.textContent = `${words} (${unitShown(unit, this.state).name})`; });
    }
    this.showUnits();
  }

  // lengths and speeds are asked and shown in the unit of the page
  showUnits() { for (const show of this.units) show(); }

  // other numbers of the system
  forget() {
    this.take({ running: false, fault: "", numbers: [], charts: [], said: [] });
  }

  take({ running, fault, done, seconds, numbers, charts, said }) {
    this.progress.hidden = this.stop.hidden = !running;
    this.run.hidden = running;
    if (done > 0) this.progress.value = done; else this.progress.removeAttribute("value");
    this.said.textContent = fault || (running && seconds ? `about ${Math.ceil(seconds)} s left` : "");
    this.said.classList.toggle("wrong", Boolean(fault));
    if (said) this.warnings.innerHTML = said.map((sentence) => `<p>${escaped(typeset(sentence))}</p>`).join("");
    if (!numbers) return;
    this.drawn.show(charts);
    this.card.classList.toggle("unasked", !numbers.length && !charts.length); // is left out on paper
    this.numbers.innerHTML = numbers.length ? `<caption class="sr">${this.caption}</caption><tbody>${numbers.map(([words, text]) => `<tr><th scope="row">${escaped(words)}</th><td>${escaped(text)}</td></tr>`).join("")}</tbody>` : "";
  }
}

export class RequestsCard extends Request {
  constructor(element, connection, state) {
    super(element, connection, state, { name: "asked", content: ASKED, kind: "observed", stop: "stop-observing", caption: "Forces, cycles and passages by Monte Carlo" });
    element("asked-forces").innerHTML = [...forces, ...ofImpacts].map(([name, words, , why]) => `<label${why ? ` title="${escaped(why)}"` : ""}><input type="checkbox" name="forces" value="${escaped(name)}"${why ? " disabled" : ""}>${escaped(words)}</label>`).join("") || "none";
    this.units.push(() => { this.fields.levels.placeholder = state.shown.length === "mm" ? "3 4" : "0.003 0.004"; });
    for (const name of ["levels_of", "cycles_of"]) this.offer(this.fields[name], [...displacements, ...forces]);
    this.form.addEventListener("input", () => this.check());
    this.check();
  }

  asked() {
    const number = (name) => Number(this.fields[name].value), levels = this.fields.levels.value.split(/[\s;,]+/).filter(Boolean).map(Number);
    return {
      kind: "observe", forces: [...this.form.querySelectorAll("[name=forces]:checked")].map(({ value }) => value),
      levels_of: this.fields.levels_of.value, levels, cycles_of: this.fields.cycles_of.value,
      exponent: number("exponent"), strength: number("strength"), cycles: number("cycles"), bins: number("bins"),
    };
  }

  // nothing asked, or a level that is no number
  check() {
    const { forces: felt, levels, cycles_of: counted, bins } = this.asked();
    this.fields.levels.setCustomValidity(levels.every(Number.isFinite) ? "" : "Levels are numbers, such as 0.003 0.004.");
    this.run.disabled = !this.form.checkValidity() || !(felt.length || levels.length || counted || bins);
  }
}

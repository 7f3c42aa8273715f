// Rare events: a curve of level against return period, which grows to the right while the server splits paths.

import { Drawn } from "./drawn.js";
import { typeset } from "./numbers.js";
import { OPENED } from "./problem.js";
import { escaped } from "./table.js";

const { levels, forces } = OPENED.offered;

const RARE = `
  <form id="rare-form" autocomplete="off">
    <fieldset><legend>How often a level is exceeded, and how likely within a time</legend><div class="many"><label>of <select name="of" aria-label="Levels of"></select></label><label>from level <input name="low" type="number" step="any" required></label><label>to <input name="high" type="number" step="any" required></label><label>within <input name="duration" type="number" min="0" step="any" value="60" required> s</label><label>standard error <input name="rtol" type="number" min="1" max="100" step="any" value="20" required> %</label></div></fieldset>
    <div class="fit-ask"><button type="submit" class="button primary" id="rare-run">Start</button><button type="button" class="button" id="rare-stop" hidden>Stop, and keep the curve so far</button><progress id="rare-progress" max="1" hidden aria-label="Share of the curve done"></progress></div>
  </form>
  <p id="rare-said" class="caption" role="status"></p>
  <div class="charts" id="rare-charts"></div>
  <details id="rare-table" hidden><summary>Probabilities</summary>
    <div class="scroll" tabindex="0" role="region" aria-label="Table of probabilities"><table id="rare-numbers"></table></div></details>
  <div id="rare-warnings" class="warnings"></div>`;

export class RareCard {
  constructor(element, connection) {
    element("rare").insertAdjacentHTML("beforeend", RARE);
    for (const name of ["form", "run", "stop", "progress", "said", "table", "numbers", "warnings"]) this[name] = element(`rare-${name}`);
    this.drawn = new Drawn(element("rare-charts"), "rare");
    const fields = this.form.elements, seen = [...levels, ...forces.filter(([, , , why]) => !why)];
    fields.of.append(...seen.map(([value, words, unit]) => new Option(`${words} (${unit})`, value)));
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      const [low, high, duration, percent] = ["low", "high", "duration", "rtol"].map((name) => Number(fields[name].value));
      this.forget();
      connection.send({ kind: "rare", of: fields.of.value, low, high, duration, rtol: percent / 100 });
    });
    this.stop.addEventListener("click", () => connection.send({ kind: "stop-rare" }));
    connection.addEventListener("rare", ({ detail }) => this.take(detail));
    connection.addEventListener("asked", () => this.forget());
  }

  // other numbers of the system
  forget() {
    this.take({ running: false, fault: "", numbers: [], charts: [], said: [] });
  }

  take({ running, fault, done, numbers, charts, said }) {
    this.progress.hidden = this.stop.hidden = !running;
    this.run.hidden = running;
    if (done > 0) this.progress.value = done; else this.progress.removeAttribute("value");
    this.said.textContent = fault;
    this.said.classList.toggle("wrong", Boolean(fault));
    if (said) this.warnings.innerHTML = said.map((sentence) => `<p>${escaped(typeset(sentence))}</p>`).join("");
    if (!numbers) return;
    this.drawn.show(charts);
    this.table.hidden = !numbers.length;
    this.numbers.innerHTML = `<caption class="sr">Probabilities and return periods</caption><tbody>${numbers.map(([words, text]) => `<tr><th scope="row">${escaped(words)}</th><td>${escaped(text)}</td></tr>`).join("")}</tbody>`;
  }
}

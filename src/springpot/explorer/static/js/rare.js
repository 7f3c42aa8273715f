// Rare events: a curve of level against return period, which grows to the right while the server splits paths.

import { OPENED } from "./problem.js";
import { Request } from "./requests.js";

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

export class RareCard extends Request {
  constructor(element, connection, state) {
    super(element, connection, state, { name: "rare", content: RARE, kind: "rare", stop: "stop-rare", caption: "Probabilities and return periods" });
    this.table = element("rare-table");
    this.offer(this.fields.of, [...levels, ...forces]);
    this.form.addEventListener("submit", () => this.forget()); // the curve begins anew
  }

  asked() {
    const [low, high, duration, percent] = ["low", "high", "duration", "rtol"].map((name) => Number(this.fields[name].value));
    return { kind: "rare", of: this.fields.of.value, low, high, duration, rtol: percent / 100 };
  }

  take(found) {
    super.take(found);
    if (found.numbers) this.table.hidden = !found.numbers.length;
  }
}

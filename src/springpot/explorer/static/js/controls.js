// Sliders and fields: what a person changes, and how it is shown.

import { OPENED, PARAMETERS, isWall, titleOf, wholeName } from "./problem.js";
import { checked, tidy } from "./state.js";
import { plain, short } from "./numbers.js";
import { CHOICES, askedAs, shownAs } from "./units.js";

const FINEST = 300; // a slider whose end is so many times its number is moved to it

export class Controls {
  constructor(state, form) {
    this.state = state;
    this.form = form;
    this.rows = {};
    this.refused = null; // the number that the system does not take, and why
    for (const part of OPENED.parts) form.querySelector("#sliders").append(this.part(part));
    this.simple("paths", "change");
    this.simple("start", "change");
    this.simple("seed", "input");
    form.querySelector("#tolerances").addEventListener("change", ({ target }) => document.body.classList.toggle("scattering", target.checked));
    form.querySelector("#seed").addEventListener("blur", () => this.show());
    form.querySelector("#new-seed").addEventListener("click", () => state.set({ seed: Math.floor(Math.random() * 1e6) }));
    for (const radio of document.querySelectorAll("[name=units]")) radio.addEventListener("change", () => state.setUnits(radio.value));
    this.examples = form.querySelector("#example");
    const others = Object.assign(document.createElement("optgroup"), { label: "Other systems" });
    others.append(...OPENED.systems.filter(([place]) => place !== OPENED.place).map(([place, title]) => new Option(title, `system ${place}`)));
    this.examples.append(...OPENED.examples.map(({ label }, i) => new Option(label, i)), new Option("your own", "own"), others);
    this.examples.addEventListener("change", () => {
      const [word, place] = this.examples.value.split(" ");
      if (word === "system") return goTo(place, state);
      const chosen = OPENED.examples[this.examples.value];
      if (!chosen) return;
      this.touched = this.refused = null;
      state.take(chosen);
    });
    form.addEventListener("submit", (event) => event.preventDefault());
    state.onChange(() => this.show());
  }

  // the numbers of a part under its name; a wall can be left out
  part({ name, title, note, glyph }) {
    const own = Object.keys(PARAMETERS).filter((number) => number.startsWith(`${name}-`));
    const group = document.createElement("section"), head = document.createElement("h3");
    group.className = "part";
    group.dataset.part = name;
    head.textContent = title;
    if (note) head.append(" ", Object.assign(document.createElement("small"), { textContent: note }));
    if (isWall({ glyph })) {
      const box = Object.assign(document.createElement("input"), { type: "checkbox", id: `with-${name}`, title: "uncheck to leave this wall out" });
      box.setAttribute("aria-label", `with ${title}`);
      box.addEventListener("change", () => {
        const { without } = this.state.values;
        this.set({ without: box.checked ? without.filter((one) => one !== name) : [...without, name] }, null);
      });
      head.prepend(box);
    }
    group.append(head, ...own.map((number) => this.row(number)));
    return group;
  }

  // a change by hand; if the system does not take it, the reason is shown beside this number
  set(changes, name) {
    this.touched = name;
    this.refused = null;
    this.state.set(changes);
  }

  // what was not taken stays in its field, with the reason, until the field is left or another number is changed
  refuse(sentence, values) {
    this.refused = this.touched ? { name: this.touched, sentence } : null;
    this.state.restore(values);
    if (this.refused) this.rows[this.touched].element.scrollIntoView({ block: "nearest" }); // with the reason
    return Boolean(this.refused);
  }

  // the numbers that are to be found from data
  ticked() { return Object.keys(this.rows).filter((name) => this.rows[name].element.querySelector(".tick").checked); }

  simple(name, event) {
    const field = this.form.querySelector(`#${name}`);
    field.addEventListener(event, () => {
      const value = checked(name, field.value);
      if (value === null) mark(field, false); else this.state.set({ [name]: value });
    });
  }

  row(name) {
    const { kind, steps, free, tolerance } = PARAMETERS[name], percent = tolerance.kind === "cov", whose = wholeName(name);
    const element = document.createElement("div");
    element.className = "parameter";
    const choices = kind ? Object.entries(CHOICES[kind]).map(([key, unit]) => `<option value="${key}">${unit.name}</option>`).join("") : "";
    element.innerHTML = `<input type="checkbox" class="tick" id="free-${name}" aria-label="find ${whose} from data" title="find this number from data"${free ? " checked" : ""}>
      <label for="field-${name}"><i></i> <span></span> <small class="hint"></small></label>
      <input type="range" id="slider-${name}" min="0" max="${steps}" step="1" aria-label="${whose}">
      <span class="entry"><input type="number" id="field-${name}" step="any" inputmode="decimal" aria-describedby="range-${name}"><small class="unit"></small>${kind ? `<select id="unit-${name}" class="unit" aria-label="unit of the ${whose}">${choices}</select>` : ""}</span>
      <span class="tolerance" title="how much this number differs from device to device: standard deviation${percent ? ", in per cent of the value" : ""}">± <input type="number" id="tolerance-${name}" min="0" step="any" inputmode="decimal" placeholder="0" aria-label="tolerance of ${whose}" aria-describedby="range-${name}"><small></small></span>
      <small class="law"></small>
      <small class="range" id="range-${name}" hidden></small>`;
    const slider = element.querySelector("[type=range]"), field = element.querySelector(".entry input"), spread = element.querySelector(".tolerance input");
    const choice = element.querySelector("select");
    slider.addEventListener("input", () => this.move(name, this.fromSlider(name, Number(slider.value))));
    field.addEventListener("input", () => {
      const value = this.fromField(name);
      if (value === null) mark(field, false); else this.move(name, value);
    });
    spread.addEventListener("input", () => {
      const given = this.givenTolerance(name), { [tolerance.name]: _, ...others } = this.state.values.tolerances;
      if (given === undefined) mark(spread, false);
      else this.set({ tolerances: given === null || given === tolerance.spread && !tolerance.other ? others : { ...others, [tolerance.name]: given } }, name);
    });
    for (const one of [field, spread]) {
      one.addEventListener("blur", () => {
        if (this.refused?.name === name) this.refused = null;
        this.show();
      });
    }
    choice?.addEventListener("change", () => this.state.setShown(kind, choice.value));
    element.querySelector(".tick").addEventListener("change", () => this.onTick?.());
    this.rows[name] = {
      element, slider, field, spread, choice, decades: 0, law: element.querySelector(".law"), ofSpread: element.querySelector(".tolerance small"),
      symbol: element.querySelector("label i"), name: element.querySelector("label span"),
      unit: element.querySelector("small.unit"), hint: element.querySelector(".hint"), range: element.querySelector(".range"),
    };
    return element;
  }

  // numbers that follow from one uncertain number move with each other
  move(name, value) {
    const { name: own, follows: [times, plus, power] } = PARAMETERS[name].tolerance, changes = { [name]: value };
    const base = ((value - plus) / times) ** (1 / power);
    for (const [other, { tolerance }] of Object.entries(PARAMETERS)) {
      if (other !== name && tolerance.name === own && Number.isFinite(base)) changes[other] = tidy(tolerance.follows[0] * base ** tolerance.follows[2] + tolerance.follows[1]);
    }
    this.set(changes, name);
  }

  // factor and unit of a tolerance: per cent, or the unit of its number
  ofTolerance(name) {
    const { tolerance, unit } = PARAMETERS[name], choice = this.unit(name);
    return tolerance.kind === "cov" ? { factor: 100, unit: "%" } : { factor: choice.factor ?? 1, unit: choice.name ?? unit };
  }

  // what a field has: null for the law of the file, undefined if it is none
  givenTolerance(name) {
    const { spread } = this.rows[name], { other } = PARAMETERS[name].tolerance, value = Number(spread.value);
    if (!spread.validity.valid || value < 0) return undefined;
    return spread.value === "" ? other ? null : 0 : tidy(value / this.ofTolerance(name).factor);
  }

  // a tolerance in words, if there is one
  saidTolerance(name) {
    const spread = this.state.toleranceOf(PARAMETERS[name]), { factor, unit } = this.ofTolerance(name);
    if (this.state.values.without.includes(name.split("-")[0])) return "";
    return spread === null ? `(${this.rows[name].law.textContent})` : spread ? `± ${[short(spread * factor), unit].filter(Boolean).join(" ")}` : "";
  }

  // laws of now that one number does not describe
  showLaws(laws) {
    for (const [name, { law }] of Object.entries(this.rows)) law.textContent = laws[PARAMETERS[name].tolerance.name] ?? "";
  }

  // the unit in which a number is shown and typed
  unit(name) {
    const { kind } = PARAMETERS[name];
    return kind ? CHOICES[kind][this.state.shown[kind]] : {};
  }

  fromField(name) {
    const value = checked(name, this.rows[name].field.value), unit = this.unit(name);
    return value === null || (unit.factor ?? 1) === 1 && !unit.power ? value : tidy(askedAs(value, unit));
  }

  // the ends of a slider move by whole decades to where a value from elsewhere lies
  ends(name) {
    const { begin, end } = PARAMETERS[name], { decades } = this.rows[name];
    return [begin * 10 ** decades, end * 10 ** decades];
  }

  reach(name, value) {
    const { begin, end, log, unit, kind } = PARAMETERS[name], [low, high] = this.ends(name), size = Math.abs(value);
    if (!unit && !kind) return; // orders and shares have ends of their own
    const least = log ? low * 0.999 : high / FINEST;
    if (!(size > 0) || (log && !(value > 0)) || (size > least && size < high * 1.001)) return;
    const usual = log ? value >= begin && value <= end : size <= end && size > end / FINEST;
    this.rows[name].decades = usual ? 0 : Math.round(Math.log10(size / (log ? Math.sqrt(begin * end) : 0.3 * end)));
  }

  fromSlider(name, place) {
    const { log, steps } = PARAMETERS[name], [from, to] = this.ends(name);
    const part = place / steps;
    return Number((log ? from * (to / from) ** part : from + (to - from) * part).toPrecision(log ? 3 : 4));
  }

  toSlider(name, value) {
    const { log, steps } = PARAMETERS[name], [from, to] = this.ends(name);
    const part = log ? Math.log(Math.max(value, from) / from) / Math.log(to / from) : (value - from) / (to - from);
    return Math.round(Math.min(Math.max(part, 0), 1) * steps);
  }

  show() {
    const { values, shown, units } = this.state;
    for (const [name, row] of Object.entries(this.rows)) {
      const choice = this.unit(name), said = { ...PARAMETERS[name], ...choice };
      this.reach(name, values[name]);
      row.slider.value = this.toSlider(name, values[name]);
      row.slider.setAttribute("aria-valuetext", `${short(shownAs(values[name], choice))} ${choice.name ?? said.unit}`);
      const refused = this.refused?.name === name;
      if (document.activeElement !== row.field || (!refused && this.fromField(name) !== values[name])) {
        row.field.value = plain(shownAs(values[name], choice));
      }
      row.range.textContent = refused ? this.refused.sentence : "a number";
      mark(row.field, !refused);
      const { tolerance } = PARAMETERS[name], spread = this.state.toleranceOf(PARAMETERS[name]), { factor, unit } = this.ofTolerance(name);
      if (document.activeElement !== row.spread || (!refused && this.givenTolerance(name) !== spread)) row.spread.value = spread ? plain(spread * factor) : spread === 0 && tolerance.other ? "0" : "";
      row.spread.setAttribute("aria-invalid", String(refused));
      row.spread.placeholder = spread === null ? "law" : "0";
      row.ofSpread.textContent = unit;
      row.element.classList.toggle("uncertain", spread !== 0 || tolerance.spread > 0 || tolerance.other || document.activeElement === row.spread);
      row.symbol.textContent = said.symbol;
      row.name.textContent = said.said;
      row.hint.textContent = said.hint;
      row.unit.textContent = row.choice ? "" : said.unit;
      if (row.choice) row.choice.value = shown[said.kind];
    }
    for (const group of this.form.querySelectorAll(".part")) {
      const out = values.without.includes(group.dataset.part), box = group.querySelector("h3 input");
      if (box) box.checked = !out;
      group.classList.toggle("off", out);
      for (const field of group.querySelectorAll(".parameter input")) field.disabled = out;
    }
    const example = OPENED.examples.findIndex((one) => this.state.is(one));
    this.examples.value = example < 0 ? "own" : example;
    this.form.querySelector("#example-note").textContent = OPENED.examples[example]?.note ?? "";
    document.querySelector(`[name=units][value=${units}]`).checked = true;
    for (const name of ["paths", "start", "seed"]) {
      const field = this.form.querySelector(`#${name}`);
      if (field.tagName === "SELECT" && ![...field.options].some((o) => o.value === String(values[name]))) {
        field.append(new Option(String(values[name]), String(values[name])));
      }
      if (document.activeElement !== field || field.tagName === "SELECT") field.value = values[name];
      mark(field, true);
    }
  }
}

// the page of another system, with as many paths
export function goTo(place, { values: { paths } }) { location.assign(`${location.pathname}${place ? `?system=${place}` : ""}#paths=${paths}`); }

// a number that is refused shows which ones are not
function mark(field, sound) {
  field.setAttribute("aria-invalid", String(!sound));
  const range = document.getElementById(field.getAttribute("aria-describedby"));
  if (range) range.hidden = sound;
}

// Sliders and fields: what a person changes, and how it is shown.

import { OPENED, ofSystem } from "./problem.js";
import { DEFAULTS, PARAMETERS, checked, lengthScale, rangeOf, tidy } from "./state.js";
import { plain, short } from "./numbers.js";
import { CHOICES } from "./units.js";

export const PRESETS = {
  paper: { label: "The paper: wall at rest, elastic", note: "Half-order springpot at C = Ω = q = 1, the middle of the paper's figure.", values: {} },
  light: { label: "Light damping", note: "Where averaging is accurate: a narrow band, and a slow approach to the stationary state.", values: { coefficient: 0.1 } },
  dashpot: { label: "Dashpot: solved exactly", note: "At α = 1 the impacting oscillator is the mirrored linear one, and all theories must meet.", values: { order: 1 } },
  rubber: { label: "Rubber-like: small order", note: "Nearly a spring with a long memory: a run from rest stays transient for long.", values: { order: 0.2 } },
  pounding: { label: "Pounding across a gap", note: "A building with a neighbour: wall half a length scale away, lossy impacts, light damping.", values: { order: 0.6, coefficient: 0.15, position: -0.5, restitution: 0.65 } },
  preload: { label: "Preload: pressed to a stop", note: "The spring presses the mass to the wall, as in a valve or a contact probe: short hops.", values: { coefficient: 0.5, position: 0.6, restitution: 0.8 } },
  lossy: { label: "Very lossy wall", note: "Energy leaves at the wall; slow impacts crowd together.", values: { coefficient: 0.1, restitution: 0.5 } },
  fast: { label: "Ω = 3: the misprint shows", note: "Away from Ω = 1 the formula as printed is off by the factor Ω that was lost on the way to Eq. 18.", values: { order: 0.7, coefficient: 0.2, natural_frequency: 3 } },
  free: { label: "No wall", note: "The linear fractional oscillator, with an exact spectrum to compare with.", values: { wall: false } },
  undamped: { label: "α = 0: no stationary state", note: "An elastic element dissipates nothing: the energy grows as q t / 2, and no theory claims otherwise.", values: { order: 0 } },
};

export class Controls {
  constructor(state, form) {
    this.state = state;
    this.rows = {};
    const sliders = form.querySelector("#sliders");
    this.refused = null; // the number that the system does not take, and why
    if (ofSystem) this.parts(sliders, form);
    else {
      for (const name of Object.keys(PARAMETERS)) sliders.append(this.row(name));
      this.wall = form.querySelector("#wall");
      sliders.insertBefore(this.wall.closest("label"), this.rows.position.element);
      this.wall.addEventListener("change", () => state.set({ wall: this.wall.checked }));
    }
    this.simple(form, "paths", "change");
    this.simple(form, "start", "change");
    this.simple(form, "seed", "input");
    form.querySelector("#seed").addEventListener("blur", () => this.show());
    form.querySelector("#new-seed").addEventListener("click", () => state.set({ seed: Math.floor(Math.random() * 1e6) }));
    if (!ofSystem) {
      for (const radio of form.querySelectorAll("[name=units]")) {
        radio.addEventListener("change", () => state.setUnits(radio.value));
      }
      this.presets(form);
    }
    form.addEventListener("submit", (event) => event.preventDefault());
    this.form = form;
    state.onChange(() => this.show());
  }

  // the numbers of a system, under the name of each part
  parts(sliders, form) {
    for (const { name, title, note } of OPENED.parts) {
      const own = Object.keys(PARAMETERS).filter((number) => number.startsWith(`${name}-`));
      const group = document.createElement("section");
      group.className = "part";
      group.append(Object.assign(document.createElement("h3"), { textContent: title }), ...own.map((number) => this.row(number)));
      if (note) group.firstChild.append(" ", Object.assign(document.createElement("small"), { textContent: note }));
      sliders.append(group);
    }
    form.querySelector("#to-file").addEventListener("click", () => this.set(Object.fromEntries(Object.keys(PARAMETERS).map((name) => [name, DEFAULTS[name]])), null));
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
  ticked() { return Object.keys(this.rows).filter((name) => this.rows[name].element.querySelector(".tick")?.checked); }

  simple(form, name, event) {
    const field = form.querySelector(`#${name}`);
    field.addEventListener(event, () => {
      const value = checked(name, field.value);
      if (value === null) mark(field, false); else this.state.set({ [name]: value });
    });
  }

  presets(form) {
    this.preset = form.querySelector("#preset");
    this.presetNote = form.querySelector("#preset-note");
    this.preset.append(new Option("your own", "own"));
    for (const [name, { label }] of Object.entries(PRESETS)) this.preset.append(new Option(label, name));
    this.preset.addEventListener("change", () => {
      const chosen = PRESETS[this.preset.value];
      if (!chosen) return;
      const base = {
        order: 0.5, coefficient: 1, natural_frequency: 1, intensity: 1, wall: true, position: 0, restitution: 1,
      };
      if (chosen.values.natural_frequency) this.state.units = "si";
      this.state.set({ ...base, ...chosen.values });
    });
  }

  row(name) {
    const { said, kind } = PARAMETERS[name], whose = ofSystem ? `${OPENED.parts.find((part) => name.startsWith(`${part.name}-`)).title}, ${said}` : said;
    const element = document.createElement("div");
    element.className = "parameter";
    const choices = kind ? Object.entries(CHOICES[kind]).map(([key, unit]) => `<option value="${key}">${unit.name}</option>`).join("") : "";
    const tick = ofSystem ? `<input type="checkbox" class="tick" id="free-${name}" aria-label="find ${whose} from data" title="find this number from data"${PARAMETERS[name].free ? " checked" : ""}>` : "";
    element.innerHTML = `${tick}
      <label for="field-${name}"><i></i> <span></span> <small class="hint"></small></label>
      <input type="range" id="slider-${name}" min="0" max="${PARAMETERS[name].steps}" step="1" aria-label="${whose}">
      <span class="entry"><input type="number" id="field-${name}" step="any" inputmode="decimal" aria-describedby="range-${name}"><small class="unit"></small>${kind ? `<select id="unit-${name}" class="unit" aria-label="unit of the ${whose}">${choices}</select>` : ""}</span>
      <small class="range" id="range-${name}" hidden></small>`;
    const slider = element.querySelector("[type=range]"), field = element.querySelector("[type=number]");
    const choice = element.querySelector("select");
    slider.addEventListener("input", () => this.set({ [name]: this.fromSlider(name, Number(slider.value)) }, name));
    field.addEventListener("input", () => {
      const value = this.fromField(name);
      if (value === null) mark(field, false); else this.set({ [name]: value }, name);
    });
    field.addEventListener("blur", () => {
      if (this.refused?.name === name) this.refused = null;
      this.show();
    });
    choice?.addEventListener("change", () => this.state.setShown(kind, choice.value));
    element.querySelector(".tick")?.addEventListener("change", () => this.onTick?.());
    this.rows[name] = {
      element, slider, field, choice, decades: 0,
      symbol: element.querySelector("label i"), name: element.querySelector("label span"),
      unit: element.querySelector("small.unit"), hint: element.querySelector(".hint"), range: element.querySelector(".range"),
    };
    return element;
  }

  // what a number in the page's own units is multiplied with to be shown
  factor(name) {
    const { kind } = PARAMETERS[name];
    return kind && this.state.units === "si" ? CHOICES[kind][this.state.shown[kind]].factor : 1;
  }

  fromField(name) {
    const { value } = this.rows[name].field, factor = this.factor(name);
    return value.trim() === "" || factor === 1 ? checked(name, value) : checked(name, tidy(Number(value) / factor));
  }

  // the ends of a logarithmic slider move by whole decades to where a value from elsewhere lies
  ends(name) {
    const { begin, end } = PARAMETERS[name], { decades } = this.rows[name];
    return [begin * 10 ** decades, end * 10 ** decades];
  }

  reach(name, value) {
    const { begin, end, log } = PARAMETERS[name], [low, high] = this.ends(name);
    if (!log || !(value > 0) || (value > low * 0.999 && value < high * 1.001)) return;
    const usual = value >= begin && value <= end;
    this.rows[name].decades = usual ? 0 : Math.round(Math.log10(value / Math.sqrt(begin * end)));
  }

  fromSlider(name, place) {
    const { log, scaled, steps } = PARAMETERS[name], [from, to] = this.ends(name);
    const part = place / steps;
    if (log) return Number((from * (to / from) ** part).toPrecision(3));
    const value = from + (to - from) * part;
    return Number((scaled ? value * lengthScale(this.state.values) : value).toPrecision(4));
  }

  toSlider(name, value) {
    const { log, scaled, steps } = PARAMETERS[name], [from, to] = this.ends(name);
    const inner = scaled ? value / lengthScale(this.state.values) : value;
    const part = log ? Math.log(Math.max(inner, from) / from) / Math.log(to / from) : (inner - from) / (to - from);
    return Math.round(Math.min(Math.max(part, 0), 1) * steps);
  }

  show() {
    const { values, units, shown } = this.state, si = units === "si";
    for (const [name, row] of Object.entries(this.rows)) {
      const label = PARAMETERS[name], choice = si ? shown[label.kind] : undefined, factor = this.factor(name);
      const said = { ...label, ...label.other?.[choice] };
      const unit = si ? (choice ? CHOICES[label.kind][choice].name : label.unit ?? "") : label.dimensionless ?? "";
      const [low, high] = rangeOf(name, values).map((end) => end * factor);
      this.reach(name, values[name]);
      row.slider.value = this.toSlider(name, values[name]);
      row.slider.setAttribute("aria-valuetext", `${short(values[name] * factor)} ${unit}`);
      const refused = this.refused?.name === name;
      if (document.activeElement !== row.field || (!refused && this.fromField(name) !== values[name])) {
        row.field.value = plain(values[name] * factor);
      }
      if (ofSystem) {
        row.range.textContent = refused ? this.refused.sentence : "a number";
        mark(row.field, !refused);
      } else {
        Object.assign(row.field, { min: low, max: high, title: `from ${short(low, 3)} to ${short(high, 3)}` });
        row.range.textContent = row.field.title;
        mark(row.field, (name === "position" && !values.wall) || (low <= values[name] * factor && values[name] * factor <= high));
      }
      row.symbol.textContent = said.symbol;
      row.name.textContent = said.said;
      row.hint.textContent = said.hint ?? "";
      row.unit.textContent = row.choice && si ? "" : unit;
      if (row.choice) Object.assign(row.choice, { hidden: !si, value: choice ?? row.choice.value });
    }
    if (!ofSystem) this.showOscillator(values, si);
    for (const name of ["paths", "start", "seed"]) {
      const field = this.form.querySelector(`#${name}`);
      if (field.tagName === "SELECT" && ![...field.options].some((o) => o.value === String(values[name]))) {
        field.append(new Option(String(values[name]), String(values[name])));
      }
      if (document.activeElement !== field || field.tagName === "SELECT") field.value = values[name];
      mark(field, true);
    }
  }

  showOscillator(values, si) {
    this.rows.coefficient.symbol.textContent = si ? "C" : "c";
    for (const name of ["natural_frequency", "intensity"]) this.rows[name].element.hidden = !si;
    for (const name of ["position", "restitution"]) {
      this.rows[name].slider.disabled = this.rows[name].field.disabled = !values.wall;
      this.rows[name].element.classList.toggle("off", !values.wall);
    }
    this.wall.checked = values.wall;
    this.form.querySelector(`[name=units][value=${si ? "si" : "dimensionless"}]`).checked = true;
    this.showPreset();
  }

  showPreset() {
    const { values } = this.state;
    const base = { order: 0.5, coefficient: 1, natural_frequency: 1, intensity: 1, wall: true, position: 0, restitution: 1 };
    const match = Object.entries(PRESETS).find(([, preset]) =>
      Object.entries({ ...base, ...preset.values }).every(([name, value]) => values[name] === value));
    this.preset.value = match ? match[0] : "own";
    this.presetNote.textContent = match ? match[1].note : "";
  }
}

// a number that is refused shows which ones are not
function mark(field, sound) {
  field.setAttribute("aria-invalid", String(!sound));
  const range = document.getElementById(field.getAttribute("aria-describedby"));
  if (range) range.hidden = sound;
}

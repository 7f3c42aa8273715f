// Sliders and fields: what a person changes, and how it is shown.

import { PARAMETERS, checked, lengthScale, rangeOf } from "./state.js";
import { plain, short } from "./numbers.js";

const LABELS = {
  order: { symbol: "α", name: "order", si: "", hint: "0 spring – 1 dashpot" },
  coefficient: { symbol: "C", name: "springpot", si: "s^(α−2)", dimensionless: "c = C Ω^(α−2)" },
  natural_frequency: { symbol: "Ω", name: "natural frequency", si: "rad/s" },
  intensity: { symbol: "q", name: "noise intensity", si: "m²/s³" },
  position: { symbol: "b", name: "wall at", si: "m", dimensionless: "√(q/Ω³)", hint: "gap < 0" },
  restitution: { symbol: "r", name: "restitution", si: "", hint: "lossy – elastic" },
};

export const PRESETS = {
  paper: { label: "The paper: wall at rest, elastic", note: "Half-order springpot at C = Ω = q = 1, the middle of the paper's figure.", values: {} },
  light: { label: "Light damping", note: "Where averaging is at home: a narrow band, and a slow approach to the stationary state.", values: { coefficient: 0.1 } },
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
    for (const name of Object.keys(PARAMETERS)) sliders.append(this.row(name));
    this.wall = form.querySelector("#wall");
    sliders.insertBefore(this.wall.closest("label"), this.rows.position.element);
    this.wall.addEventListener("change", () => state.set({ wall: this.wall.checked }));
    this.simple(form, "paths", "change");
    this.simple(form, "start", "change");
    this.simple(form, "seed", "input");
    form.querySelector("#seed").addEventListener("blur", () => this.show());
    form.querySelector("#dice").addEventListener("click", () => state.set({ seed: Math.floor(Math.random() * 1e6) }));
    for (const radio of form.querySelectorAll("[name=units]")) {
      radio.addEventListener("change", () => state.setUnits(radio.value));
    }
    this.presets(form);
    form.addEventListener("submit", (event) => event.preventDefault());
    this.form = form;
    state.onChange(() => this.show());
  }

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
    const { symbol, name: said } = LABELS[name];
    const element = document.createElement("div");
    element.className = "parameter";
    element.innerHTML = `
      <label for="field-${name}"><i>${symbol}</i> <span>${said}</span> <small class="hint"></small></label>
      <input type="range" id="slider-${name}" min="0" max="${PARAMETERS[name].steps}" step="1" aria-label="${said} ${symbol}">
      <span class="entry"><input type="number" id="field-${name}" step="any" inputmode="decimal" aria-describedby="range-${name}"><small class="unit"></small></span>
      <small class="range" id="range-${name}" hidden></small>`;
    const slider = element.querySelector("[type=range]"), field = element.querySelector("[type=number]");
    slider.addEventListener("input", () => this.state.set({ [name]: this.fromSlider(name, Number(slider.value)) }));
    field.addEventListener("input", () => {
      const value = checked(name, field.value);
      if (value === null) mark(field, false); else this.state.set({ [name]: value });
    });
    field.addEventListener("blur", () => this.show());
    this.rows[name] = {
      element, slider, field,
      unit: element.querySelector(".unit"), hint: element.querySelector(".hint"), range: element.querySelector(".range"),
    };
    return element;
  }

  fromSlider(name, place) {
    const { from, to, log, scaled, steps } = PARAMETERS[name];
    const part = place / steps;
    if (log) return Number((from * (to / from) ** part).toPrecision(3));
    const value = from + (to - from) * part;
    return Number((scaled ? value * lengthScale(this.state.values) : value).toPrecision(4));
  }

  toSlider(name, value) {
    const { from, to, log, scaled, steps } = PARAMETERS[name];
    const inner = scaled ? value / lengthScale(this.state.values) : value;
    const part = log ? Math.log(Math.max(inner, from) / from) / Math.log(to / from) : (inner - from) / (to - from);
    return Math.round(Math.min(Math.max(part, 0), 1) * steps);
  }

  show() {
    const { values, units } = this.state, si = units === "si";
    for (const [name, row] of Object.entries(this.rows)) {
      const label = LABELS[name], [low, high] = rangeOf(name, values);
      row.slider.value = this.toSlider(name, values[name]);
      row.slider.setAttribute("aria-valuetext", `${short(values[name])} ${si ? label.si : label.dimensionless ?? ""}`);
      if (document.activeElement !== row.field || checked(name, row.field.value) !== values[name]) {
        row.field.value = plain(values[name]);
      }
      Object.assign(row.field, { min: low, max: high, title: `from ${short(low, 3)} to ${short(high, 3)}` });
      row.range.textContent = row.field.title;
      mark(row.field, (name === "position" && !values.wall) || (low <= values[name] && values[name] <= high));
      row.unit.textContent = si ? label.si : label.dimensionless ?? "";
      row.hint.textContent = label.hint ?? "";
    }
    this.rows.coefficient.element.querySelector("label i").textContent = si ? "C" : "c";
    for (const name of ["natural_frequency", "intensity"]) this.rows[name].element.hidden = !si;
    for (const name of ["position", "restitution"]) {
      this.rows[name].slider.disabled = this.rows[name].field.disabled = !values.wall;
      this.rows[name].element.classList.toggle("off", !values.wall);
    }
    this.wall.checked = values.wall;
    for (const name of ["paths", "start", "seed"]) {
      const field = this.form.querySelector(`#${name}`);
      if (field.tagName === "SELECT" && ![...field.options].some((o) => o.value === String(values[name]))) {
        field.append(new Option(String(values[name]), String(values[name])));
      }
      if (document.activeElement !== field || field.tagName === "SELECT") field.value = values[name];
      mark(field, true);
    }
    this.form.querySelector(`[name=units][value=${units}]`).checked = true;
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

// The state of a tab: the problem, its units, and the link that reproduces it.

import { OPENED, PARAMETERS, isRecorded, ofSystem } from "./problem.js";
import { CHOICES, USUAL } from "./units.js";

export const DEFAULTS = Object.freeze({
  ...Object.fromEntries(OPENED.sliders.map(({ name, value }) => [name, value])),
  ...(ofSystem ? {} : { wall: true }),
  seed: 1, paths: ofSystem ? 5000 : 10000, start: isRecorded ? "rest" : "stationary",
});

const SHORT = ofSystem ? { seed: "seed", paths: "paths", start: "start" } : {
  order: "a", coefficient: "C", natural_frequency: "W", intensity: "q", position: "b", restitution: "r",
  seed: "seed", paths: "paths", start: "start",
};
const SCALES = { natural_frequency: "sW", intensity: "sq" }; // in a link of dimensionless numbers: the way back
const NAMES = {
  order: "order", coefficient: "springpot", natural_frequency: "natural frequency", intensity: "noise intensity",
  position: "wall position", restitution: "restitution",
};
const MOST_PATHS = 100000;
const FARTHEST_WALL = 20;
const STRONGEST = 1000;

export { PARAMETERS };
export const lengthScale = (s) => Math.sqrt(s.intensity / s.natural_frequency ** 3);

// what the server takes, which for wall and springpot depends on the rest
export function rangeOf(name, values) {
  if (ofSystem) return [-Infinity, Infinity]; // the system itself says what it does not take
  if (name === "coefficient") return [0, STRONGEST * values.natural_frequency ** (2 - values.order)];
  if (name !== "position") return [PARAMETERS[name].low, PARAMETERS[name].high];
  const farthest = FARTHEST_WALL * lengthScale(values);
  return [-farthest, farthest];
}

// a number without the dust that a conversion leaves in its last digits
export function tidy(value) {
  const rounded = Number(value.toPrecision(12));
  return Math.abs(rounded - value) <= 1e-14 * Math.abs(value) ? rounded : value;
}

// the same oscillator in other units, whose natural frequency and intensity are given: 1 and 1 if dimensionless
export function converted(values, { natural_frequency, intensity }) {
  const faster = natural_frequency / values.natural_frequency;
  const longer = lengthScale({ natural_frequency, intensity }) / lengthScale(values);
  return {
    ...values, natural_frequency, intensity,
    coefficient: tidy(values.coefficient * faster ** (2 - values.order)), position: tidy(values.position * longer),
  };
}

const PLAIN = Object.freeze({ natural_frequency: 1, intensity: 1 });

export class State {
  constructor() {
    this.values = { ...DEFAULTS };
    this.units = "si";
    this.shown = { ...USUAL }; // in which units, of those that there are for length, frequency and excitation
    this.scales = { ...PLAIN }; // to come back from dimensionless numbers
    this.listeners = new Set();
  }

  // listeners are called with this state, and with whether the problem may be another one
  onChange(listener) { this.listeners.add(listener); }

  set(changes) {
    Object.assign(this.values, changes);
    this.tell(true);
  }

  tell(another) { for (const listener of this.listeners) listener(this, another); }

  setShown(kind, choice) {
    this.shown[kind] = choice;
    this.tell(false);
  }

  setUnits(units) {
    if (units === this.units) return;
    const { natural_frequency, intensity } = this.values, there = units === "dimensionless";
    const scales = there ? PLAIN : this.scales;
    if (there) this.scales = { natural_frequency, intensity };
    this.units = units;
    this.set(converted(this.values, scales));
  }

  // the numbers of a system that differ from its file
  changes() {
    return Object.fromEntries(Object.keys(PARAMETERS).filter((name) => this.values[name] !== DEFAULTS[name]).map((name) => [name, this.values[name]]));
  }

  problem(generation) {
    if (!ofSystem) return { kind: "problem", generation, ...this.values };
    const { seed, paths, start } = this.values;
    return { kind: "system", generation, numbers: this.changes(), seed, paths, start };
  }

  // the values of a question that was taken, after one that was not
  restore(values) {
    this.values = { ...values };
    this.tell(false);
  }

  link() {
    const words = Object.entries(SHORT).map(([name, key]) => `${key}=${this.values[name]}`);
    if (ofSystem) words.unshift(...Object.entries(this.changes()).map(([name, value]) => `${name}=${value}`));
    else if (!this.values.wall) words.push("wall=0");
    if (this.units !== "si") {
      words.push("units=dimensionless");
      for (const [name, key] of Object.entries(SCALES)) words.push(`${key}=${this.scales[name]}`);
    }
    for (const [kind, choice] of Object.entries(this.shown)) if (choice !== USUAL[kind]) words.push(`${kind}=${choice}`);
    return `#${words.join("&")}`;
  }

  // Takes what is valid from a link; returns the names of what is not.
  readLink(hash) {
    const given = new URLSearchParams(hash.replace(/^#/, ""));
    const values = { ...DEFAULTS }, unsound = [];
    const keys = ofSystem ? { ...Object.fromEntries(Object.keys(PARAMETERS).map((name) => [name, name])), ...SHORT } : SHORT;
    for (const [name, key] of Object.entries(keys)) {
      if (!given.has(key)) continue;
      const sound = checked(name, given.get(key));
      if (sound === null) unsound.push(NAMES[name] ?? name); else values[name] = sound;
    }
    if (given.get("wall") === "0") values.wall = false;
    this.units = given.get("units") === "dimensionless" && !ofSystem ? "dimensionless" : "si";
    this.scales = { ...PLAIN };
    for (const kind of Object.keys(USUAL)) {
      const choice = given.get(kind) ?? USUAL[kind], known = Object.hasOwn(CHOICES[kind], choice);
      this.shown[kind] = known ? choice : USUAL[kind];
      if (!known) unsound.push(`unit of ${kind}`);
    }
    if (this.units === "dimensionless") {
      values.natural_frequency = values.intensity = 1;
      for (const [name, key] of Object.entries(SCALES)) {
        if (!given.has(key)) continue;
        const sound = checked(name, given.get(key));
        if (sound === null) unsound.push(NAMES[name]); else this.scales[name] = sound;
      }
    }
    this.set(values);
    return unsound;
  }
}

export function checked(name, text) {
  if (name === "start") return text === "rest" || text === "stationary" ? text : null;
  const value = Number(text);
  if (String(text).trim() === "" || !Number.isFinite(value)) return null;
  if (name === "seed") return Number.isSafeInteger(value) && value >= 0 ? value : null;
  if (name === "paths") return Number.isInteger(value) && value >= 2 && value <= MOST_PATHS ? value : null;
  const { low, high } = PARAMETERS[name];
  return value >= low && value <= high ? value : null;
}

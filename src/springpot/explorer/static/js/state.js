// The state of a tab: the problem, how it is shown, and the link that reproduces both.

import { OPENED, PARAMETERS, ends, titleOf } from "./problem.js";
import { CHOICES, USUAL } from "./units.js";

const RUN = ["seed", "paths", "start"];
export const DEFAULTS = Object.freeze({
  ...Object.fromEntries(OPENED.sliders.map(({ name, value }) => [name, value])),
  without: [], tolerances: {}, seed: 1, paths: 10000, start: ends ? "rest" : "stationary",
});
const MOST_PATHS = 100000;
const TOLERANCE = "tolerance."; // in front of the name of an uncertain number, in a link

// a number without the dust that a conversion leaves in its last digits
export function tidy(value) {
  const rounded = Number(value.toPrecision(12));
  return Math.abs(rounded - value) <= 1e-14 * Math.abs(value) ? rounded : value;
}

export class State {
  constructor() {
    this.values = { ...DEFAULTS };
    this.units = "si"; // of results: or "dimensionless", where the problem is the paper's
    this.paper = OPENED.paper; // what the paper's problem adds
    this.shown = { ...USUAL }; // in which units, of those that there are to choose from
    this.listeners = new Set();
  }

  get si() { return this.units === "si" || !this.paper; }

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
    this.units = units;
    this.tell(false);
  }

  // the numbers that differ from those of the page when it was opened
  changes() {
    return Object.fromEntries(Object.keys(PARAMETERS).filter((name) => this.values[name] !== DEFAULTS[name]).map((name) => [name, this.values[name]]));
  }

  // of a number, from device to device: what was given by hand, or what the file has; null if it has a law that one number does not describe
  toleranceOf({ tolerance: { name, spread, other } }) { return this.values.tolerances[name] ?? (other ? null : spread); }

  // one of the page's cases
  take({ numbers, without }) {
    const usual = Object.fromEntries(Object.keys(PARAMETERS).map((name) => [name, DEFAULTS[name]]));
    this.set({ ...usual, ...numbers, without, tolerances: {} });
  }

  is({ numbers, without }) {
    return Object.keys(PARAMETERS).every((name) => this.values[name] === (numbers[name] ?? DEFAULTS[name])) && String(this.values.without) === String(without);
  }

  problem(generation) {
    const { without, tolerances, seed, paths, start } = this.values;
    return { kind: "problem", generation, numbers: this.changes(), tolerances, without, seed, paths, start };
  }

  // the values of a question that was taken, after one that was not
  restore(values) {
    this.values = { ...values };
    this.tell(false);
  }

  link() {
    const words = [...Object.entries(this.changes()), ...RUN.map((name) => [name, this.values[name]])];
    for (const [name, spread] of Object.entries(this.values.tolerances)) words.push([`${TOLERANCE}${name}`, spread]);
    if (this.values.without.length) words.push(["without", this.values.without]);
    if (this.units !== "si") words.push(["units", this.units]);
    for (const [kind, choice] of Object.entries(this.shown)) if (choice !== USUAL[kind]) words.push([kind, choice]);
    return `#${words.map(([name, value]) => `${name}=${value}`).join("&")}`;
  }

  // Takes what is valid from a link; returns the names of what is not.
  readLink(hash) {
    const values = { ...DEFAULTS }, unsound = [];
    this.units = "si";
    this.shown = { ...USUAL };
    for (const [name, text] of new URLSearchParams(hash.replace(/^#/, ""))) {
      if (name === "units" && ["si", "dimensionless"].includes(text)) this.units = text;
      else if (name === "without") values.without = text.split(",");
      else if (name.startsWith(TOLERANCE)) {
        const own = name.slice(TOLERANCE.length), whose = Object.values(PARAMETERS).find(({ tolerance }) => tolerance.name === own);
        const spread = whose ? checked(name, text) : null;
        if (spread === null || spread < 0) unsound.push(`tolerance of ${own.slice(0, 40)}`); else values.tolerances = { ...values.tolerances, [own]: spread };
      }
      else if (Object.hasOwn(USUAL, name)) {
        if (Object.hasOwn(CHOICES[name], text)) this.shown[name] = text; else unsound.push(`unit of ${name}`);
      } else {
        const sound = Object.hasOwn(DEFAULTS, name) ? checked(name, text) : null;
        if (sound === null) unsound.push(PARAMETERS[name] ? `${PARAMETERS[name].said} of ${titleOf(name)}` : name.slice(0, 40)); else values[name] = sound;
      }
    }
    this.set(values);
    return unsound;
  }
}

// a value of a field or link, if it is one; whether a number is possible the system itself says
export function checked(name, text) {
  if (name === "start") return text === "rest" || text === "stationary" ? text : null;
  const value = Number(text);
  if (String(text).trim() === "" || !Number.isFinite(value)) return null;
  if (name === "seed") return Number.isSafeInteger(value) && value >= 0 ? value : null;
  if (name === "paths") return Number.isInteger(value) && value >= 2 && value <= MOST_PATHS ? value : null;
  return value;
}

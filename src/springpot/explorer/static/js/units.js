// Units: the page keeps m, s, rad/s, ...; what it shows and what is typed in is a factor, and for Ω a power, away from them.

import { OPENED, isHeavy } from "./problem.js";

const GRAVITY = 9.80665; // m/s²
const DENSITY = { symbol: "S", said: "one-sided PSD" };

export const CHOICES = {
  length: { m: { factor: 1, name: "m" }, mm: { factor: 1000, name: "mm" } },
  // the stiffness per unit mass, as the frequency of the mass on that spring
  stiffness: {
    rad: { factor: 1, power: 0.5, name: "rad/s", symbol: "Ω", said: "natural frequency" },
    Hz: { factor: 1 / (2 * Math.PI), power: 0.5, name: "Hz", symbol: "f", said: "natural frequency" },
    k: { factor: 1, name: "1/s²" },
  },
  frequency: { rad: { factor: 1, name: "rad/s" }, Hz: { factor: 1 / (2 * Math.PI), name: "Hz" } },
  // white noise with E[ζ(t) ζ(s)] = q δ(t − s) has the one-sided spectral density 2 q per Hz
  excitation: {
    q: { factor: 1, name: "m²/s³" },
    psd: { factor: 2, name: "(m/s²)²/Hz", ...DENSITY },
    g: { factor: 2 / GRAVITY ** 2, name: "g²/Hz", ...DENSITY },
  },
  force_noise: { q: { factor: 1, name: "N² s" }, psd: { factor: 2, name: "N²/Hz", ...DENSITY } }, // of a force
};
const USUAL_SI = { length: "m", stiffness: "rad", frequency: "rad", excitation: "q", force_noise: "q" };
const FEWER = 3; // digits, by which another unit must be shorter: 0.480852 m²/s³ was stated as 0.01 g²/Hz
const SHORT = 0.1; // m

const signed = (value, power) => Math.sign(value) * Math.abs(value) ** power;
export const shownAs = (value, { factor = 1, power = 1 } = {}) => factor * signed(value, power);
// in which unit the numbers of a kind were stated, as far as their digits tell
function statedIn(kind) {
  const own = OPENED.sliders.filter((one) => one.kind === kind && one.value !== 0).map(({ value }) => value);
  if (kind === "length") return isHeavy && Math.max(0, ...own.map(Math.abs), own.length ? 0 : 3 * OPENED.sizes.length) < SHORT ? "mm" : "m";
  if (kind === "excitation" && !own.length && OPENED.table.includes("g2/Hz")) return "g";
  const digits = (choice) => Math.max(0, ...own.map((value) => shownAs(value, CHOICES[kind][choice]).toExponential(9).replace(/0*e.*/, "").length));
  const [best] = Object.keys(CHOICES[kind]).filter((choice) => choice !== "k").sort((a, b) => digits(a) - digits(b));
  return digits(best) <= digits(USUAL_SI[kind]) - FEWER ? best : USUAL_SI[kind];
}

export const USUAL = Object.freeze(Object.fromEntries(Object.keys(CHOICES).map((kind) => [kind, statedIn(kind)]))); // at first
export const askedAs = (value, { factor = 1, power = 1 } = {}) => signed(value / factor, 1 / power);

// powers of length and time
const DIMENSIONS = {
  amplitude_mean_square: [2, 0], x_mean: [1, 0], x_rms: [1, 0], x_mean_square: [2, 0], v_mean_square: [2, -2],
  v_rms: [1, -1], impact_rate: [0, -1], impact_speed_mean: [1, -1], impact_speed_mean_square: [2, -2],
  "impact_speed_quantile_0.99": [1, -1], acceleration_peak_mean: [1, -2],
  x: [1, 0], v: [1, -1], amplitude: [1, 0], impact_speed: [1, -1], time: [0, 1], energy_residual: [0, 0],
};
// of parts, of each of several masses, and of what is between them
const POWER = [2, -3], ENDS = { ...DIMENSIONS, elongation_mean: [1, 0], elongation_rms: [1, 0] };
const dimensionsOf = (quantity) => DIMENSIONS[quantity] ?? ENDS[Object.keys(ENDS).find((end) => quantity.endsWith(`_${end}`))] ?? POWER;

// factor and name of a quantity's unit; dimensionless numbers have none, and rates are counted per 1/Ω
export function unitOf(quantity, { si, paper, shown }) {
  const [length, time] = dimensionsOf(quantity), isPower = length === POWER[0] && time === POWER[1];
  if (!si) {
    const factor = paper.length ** -length * paper.frequency ** time / (isPower ? paper.mass : 1);
    return { factor, name: length === 0 && time === -1 ? "Ω" : "" };
  }
  if (isPower) return { factor: 1, name: isHeavy ? "W" : "m²/s³" };
  if (time === -2 && length === 1) return shown.excitation === "g" ? { factor: 1 / GRAVITY, name: "g" } : { factor: 1, name: "m/s²" };
  const { factor, name } = CHOICES.length[shown.length];
  return { factor: factor ** length, name: written(power(name, length), power("s", time)) };
}

// a unit of the library as the page shows it: lengths and speeds in the length that is chosen, densities of accelerations in g²/Hz
export function unitShown(unit, { shown }) {
  const { factor, name } = CHOICES.length[shown.length];
  if (unit === "(m/s²)²/Hz" && shown.excitation === "g") return { factor: 1 / GRAVITY ** 2, name: "g²/Hz" };
  if (["m", "m/s"].includes(unit)) return { factor, name: unit.replace("m", name) };
  if (["m²", "m²/s²"].includes(unit)) return { factor: factor ** 2, name: unit.replace("m", name) };
  if (["1/m", "s/m"].includes(unit)) return { factor: 1 / factor, name: unit.replace("m", name) };
  return { factor: 1, name: unit };
}

// the unit of a density of a quantity
export function densityUnitOf(quantity, state) {
  const { factor } = unitOf(quantity, state), [length, time] = dimensionsOf(quantity);
  if (!state.si) return { factor: 1 / factor, name: "" };
  return { factor: 1 / factor, name: written(power(state.shown.length, -length), power("s", -time)) };
}

function power(name, exponent) {
  return { above: exponent > 0 ? raised(name, exponent) : "", below: exponent < 0 ? raised(name, -exponent) : "" };
}
const raised = (name, exponent) => name + { 1: "", 2: "²" }[exponent];
const written = (...powers) => {
  const above = powers.map((p) => p.above).join(" ").trim() || "1", below = powers.map((p) => p.below).join(" ").trim();
  return below ? `${above}/${below}` : above === "1" ? "" : above;
};

export const withUnit = (what, unit) => (unit ? `${what} (${unit})` : what);

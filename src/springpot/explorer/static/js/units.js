// Units: the page keeps m, s, rad/s and m²/s³; what it shows and what is typed in is a factor away from them.

import { isHeavy } from "./problem.js";

const GRAVITY = 9.80665; // m/s²

export const CHOICES = {
  length: { m: { factor: 1, name: "m" }, mm: { factor: 1000, name: "mm" } },
  frequency: { rad: { factor: 1, name: "rad/s" }, Hz: { factor: 1 / (2 * Math.PI), name: "Hz" } },
  // white noise with E[ζ(t) ζ(s)] = q δ(t − s) has the one-sided spectral density 2 q per Hz
  excitation: {
    q: { factor: 1, name: "m²/s³" },
    psd: { factor: 2, name: "(m/s²)²/Hz" },
    g: { factor: 2 / GRAVITY ** 2, name: "g²/Hz" },
  },
  force_noise: { q: { factor: 1, name: "N² s" }, psd: { factor: 2, name: "N²/Hz" } }, // of a force; one-sided per Hz
};
export const USUAL = Object.freeze({ length: "m", frequency: "rad", excitation: "q", force_noise: "q" });

// powers of length and time
export const DIMENSIONS = {
  amplitude_mean_square: [2, 0], x_mean: [1, 0], x_rms: [1, 0], x_mean_square: [2, 0], v_mean_square: [2, -2],
  v_rms: [1, -1], impact_rate: [0, -1], impact_speed_mean: [1, -1], impact_speed_mean_square: [2, -2],
  x: [1, 0], v: [1, -1], amplitude: [1, 0], impact_speed: [1, -1], time: [0, 1],
};

// factor and name of a quantity's unit; dimensionless numbers have none, and rates are counted per 1/Ω
export function unitOf(quantity, { units, shown }) {
  const known = DIMENSIONS[quantity] ?? (quantity.endsWith("impact_rate") ? DIMENSIONS.impact_rate : null);
  if (!known) return { factor: 1, name: isHeavy && quantity !== "springpot_power" ? "W" : "m²/s³" }; // a power
  const [length, time] = known;
  if (units !== "si") return { factor: 1, name: length === 0 && time === -1 ? "Ω" : "" };
  const { factor, name } = CHOICES.length[shown.length];
  return { factor: factor ** length, name: written(power(name, length), power("s", time)) };
}

// the unit of a density of a quantity
export function densityUnitOf(quantity, state) {
  const { factor } = unitOf(quantity, state), [length, time] = DIMENSIONS[quantity];
  if (state.units !== "si") return { factor: 1, name: "" };
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

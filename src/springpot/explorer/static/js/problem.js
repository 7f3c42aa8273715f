// What the page was opened with, and what of it is drawn: walls, elements, excitations, circuits.

import { OPENED } from "/opened.js";

export { OPENED };
export const ofSystem = OPENED.kind === "system";

// sliders by name; a limit that there is none of is infinite
export const PARAMETERS = Object.fromEntries(OPENED.sliders.map((one) => [one.name, { ...one, low: one.low ?? -Infinity, high: one.high ?? Infinity }]));

const PARTS = OPENED.parts ?? [];
const of = (...kinds) => PARTS.filter(({ kind }) => kinds.includes(kind));
const LINEAR_SPRINGS = ["spring"], DAMPERS = ["dashpot", "polynomial_dashpot", "van_der_pol"];
export const hasCircuit = of("piezoelectric_circuit").length > 0;
export const isHeavy = of("mass").length > 0;
export const isThermal = of("thermal_noise").length > 0;
export const isSoft = of("contact").length > 0;
export const isRecorded = of("recorded_excitation").length > 0;
export const hasWalls = !ofSystem || of("barrier", "contact").length > 0;

// rigid walls and soft contacts, in the order of the parts: lower ones keep x above them
export function wallsOf(values) {
  if (!ofSystem) return values.wall ? [{ name: "wall", lower: true, soft: false, position: values.position, restitution: () => values.restitution }] : [];
  return of("barrier", "contact").map(({ name, title, kind, side }) => ({
    name: title, lower: side === "above", soft: kind === "contact", position: values[`${name}-position`], restitution: restitutionOf(name, values),
  }));
}

// a number, or that of a law of the speed; 0 where the law is a function that only the server knows
function restitutionOf(name, values) {
  const value = (field) => values[`${name}-restitution${field}`];
  return (speed) => value("") ?? (value("-speed") ? Math.min(1, value("-restitution") * (speed / value("-speed")) ** -value("-exponent")) : 0);
}

// what connects mass and support: at most four rows of it are drawn
export function elementsOf(values) {
  if (!ofSystem) return [{ draw: "spring" }, { draw: "springpot", order: values.order }];
  const curved = of("polynomial_spring").some(({ name }) => PARAMETERS[`${name}-coefficients-2`]);
  const springs = of(...LINEAR_SPRINGS, "polynomial_spring").length ? [{ draw: "spring", curved }] : [];
  const pots = of("springpot").map(({ name }) => ({ draw: "springpot", order: values[`${name}-order`] }));
  const arms = of("fractional_maxwell").map(({ name }) => ({ draw: "springpot", order: values[`${name}-springpot-order`], arm: true }));
  const dampers = of(...DAMPERS).slice(0, 1).map(() => ({ draw: "dashpot" }));
  const maxwell = of("maxwell").slice(0, 1).map(() => ({ draw: "dashpot", arm: true }));
  // where there are many, their marks stand beside each other
  return [...springs, ...pots, ...arms, ...dampers, ...maxwell].slice(0, 4).map((one, i, all) => ({ ...one, aside: all.length > 2 ? (i % 2 ? -0.13 : 0.13) : 0 }));
}

export const rubs = of("friction").length > 0;

const WAVES = {
  white_noise: ["rough", "white noise"], colored_noise: ["smooth", "colored noise"], kanai_tajimi_noise: ["smooth", "filtered noise"],
  harmonic: ["sine", "harmonic"], recorded: ["rough", "record"], poisson_impulses: ["spikes", "impulses"],
  parametric_noise: ["rough", "noise times x"], thermal_noise: ["rough", "thermal noise"], constant: ["flat", "constant force"], force: ["sine", "own force"],
};
export const excitations = PARTS.filter(({ kind }) => WAVES[kind]).map(({ kind, on }) => ({ wave: WAVES[kind][0], said: WAVES[kind][1], ground: on === "ground" }));

// the resistors of the circuits, whose voltages come with the motion
export const circuitsOf = (values) => of("piezoelectric_circuit").map(({ name, title }) => ({ title, resistance: values[`${name}-resistance`] }));

// What the page was opened with, and what of it is drawn: walls, elements, excitations, circuits.

import { OPENED } from "/opened.js";

export { OPENED };

// sliders by name
export const PARAMETERS = Object.fromEntries(OPENED.sliders.map((one) => [one.name, one]));
const TITLES = Object.fromEntries(OPENED.parts.map(({ name, title }) => [name, title]));
export const titleOf = (number) => TITLES[number.split("-")[0]];
export const wholeName = (number) => `${titleOf(number)}, ${PARAMETERS[number].said}`;

const of = (...kinds) => OPENED.parts.filter(({ kind }) => kinds.includes(kind));
const LINEAR_SPRINGS = ["spring"], DAMPERS = ["dashpot", "polynomial_dashpot", "van_der_pol"], WALLS = ["barrier", "contact"];
export const hasCircuit = of("piezoelectric_circuit").length > 0;
export const isHeavy = of("mass").length > 0;
export const isThermal = of("thermal_noise").length > 0;
export const isSoft = of("contact").length > 0;
export const isRecorded = of("recorded_excitation").length > 0;
export const hasWalls = of(...WALLS).length > 0;

// walls may be left out
export const isWall = ({ kind }) => WALLS.includes(kind);
export const ORDERS = of("springpot").map(({ name }) => `${name}-order`);
export const orderOf = (values, paper) => values?.[ORDERS[0]] ?? paper?.order;

// rigid walls and soft contacts, in the order of the parts: lower ones keep x above them
export function wallsOf(values) {
  return of(...WALLS).filter(({ name }) => !values.without.includes(name)).map(({ name, title, kind, side }) => ({
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
  harmonic: ["sine", "harmonic"], recorded_excitation: ["rough", "record"], poisson_impulses: ["spikes", "impulses"],
  parametric_noise: ["rough", "noise times x"], thermal_noise: ["rough", "thermal noise"], constant: ["flat", "constant force"], force: ["sine", "own force"],
};
export const excitations = OPENED.parts.filter(({ kind }) => WAVES[kind]).map(({ kind, on }) => ({ wave: WAVES[kind][0], said: WAVES[kind][1], ground: on === "ground" }));

// the resistors of the circuits, whose voltages come with the motion
export const circuitsOf = (values) => of("piezoelectric_circuit").map(({ name, title }) => ({ title, resistance: values[`${name}-resistance`] }));

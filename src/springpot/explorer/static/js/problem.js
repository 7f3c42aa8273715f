// What the page was opened with, and what of it is drawn: walls, elements, excitations, circuits.

import { OPENED } from "/opened.js";

export { OPENED };

// sliders by name
export const PARAMETERS = Object.fromEntries(OPENED.sliders.map((one) => [one.name, one]));
const TITLES = Object.fromEntries(OPENED.parts.map(({ name, title }) => [name, title]));
export const titleOf = (number) => TITLES[number.split("-")[0]];
export const wholeName = (number) => `${titleOf(number)}, ${PARAMETERS[number].said}`;

const of = (...glyphs) => OPENED.parts.filter(({ glyph }) => glyphs.includes(glyph));
const isOf = (kind) => OPENED.parts.some((part) => part.kind === kind);
const WALL = "stop"; // rigid or soft
export const hasCircuit = of("circuit").length > 0;
export const hasWalls = of(WALL).length > 0;
export const isSoft = of(WALL).some(({ soft }) => soft);
export const isHeavy = OPENED.heavy; // with a mass: forces are in N
export const isThermal = isOf("thermal_noise");
export const isRecorded = isOf("recorded_excitation");

// walls may be left out
export const isWall = ({ glyph }) => glyph === WALL;
const orderNumber = ({ name }) => Object.keys(PARAMETERS).find((number) => number.startsWith(`${name}-`) && number.endsWith("order"));
export const ORDERS = of("springpot").map(orderNumber);
export const orderOf = (values, paper) => values?.[ORDERS[0]] ?? paper?.order;

// rigid walls and soft contacts, in the order of the parts: lower ones keep x above them
export function wallsOf(values) {
  return of(WALL).filter(({ name }) => !values.without.includes(name)).map(({ name, title, soft, side }) => ({
    name: title, lower: side === "above", soft, position: values[`${name}-position`], restitution: restitutionOf(name, values),
  }));
}

// a number, or that of a law of the speed; 0 where the law is a function that only the server knows
function restitutionOf(name, values) {
  const value = (field) => values[`${name}-restitution${field}`];
  return (speed) => value("") ?? (value("-speed") ? Math.min(1, value("-restitution") * (speed / value("-speed")) ** -value("-exponent")) : 0);
}

// what connects mass and support: at most four rows of it are drawn
export function elementsOf(values) {
  const springs = of("spring"), arms = of("springpot arm").map((part) => ({ draw: "springpot", order: values[orderNumber(part)], arm: true }));
  const rows = [
    ...(springs.length ? [{ draw: "spring", curved: springs.some(({ linear }) => !linear) }] : []),
    ...of("springpot").map((part) => ({ draw: "springpot", order: values[orderNumber(part)] })), ...arms,
    ...of("dashpot").slice(0, 1).map(() => ({ draw: "dashpot" })), ...of("dashpot arm").slice(0, 1).map(() => ({ draw: "dashpot", arm: true })),
  ];
  // where there are many, their marks stand beside each other
  return rows.slice(0, 4).map((one, i, all) => ({ ...one, aside: all.length > 2 ? (i % 2 ? -0.13 : 0.13) : 0 }));
}

export const rubs = of("friction").length > 0;

const WAVES = ["rough", "smooth", "sine", "spikes", "flat"];
export const excitations = of(...WAVES).map(({ glyph, said, on }) => ({ wave: glyph, said, ground: on === "ground" }));

// the resistors of the circuits, whose voltages come with the motion
export const circuitsOf = (values) => of("circuit").map(({ name, title }) => ({ title, resistance: values[`${name}-resistance`] }));

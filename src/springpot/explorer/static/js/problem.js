// What the page was opened with, and what of it is drawn: walls, elements, excitations, circuits.

export const { OPENED } = globalThis; // of another script

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
export const POINTS = OPENED.points; // the masses
export const isSeveral = POINTS.length > 1;
export const isThermal = isOf("thermal_noise");
export const { ends } = OPENED.offered; // why the excitation does not last; empty if it does

// walls may be left out
export const isWall = ({ glyph }) => glyph === WALL;
const orderNumber = ({ name }) => Object.keys(PARAMETERS).find((number) => number.startsWith(`${name}-`) && number.endsWith("order"));
export const ORDERS = of("springpot").map(orderNumber);
export const orderOf = (values, paper) => values?.[ORDERS[0]] ?? paper?.order;

// rigid walls and soft contacts, in the order of the parts: lower ones keep what they see of the motion above them
export function wallsOf(values) {
  return of(WALL).filter(({ name }) => !values.without.includes(name)).map(({ name, title, soft, free_side, ends }, number) => ({
    number, part: name, name: title, lower: free_side === "above", soft, ends, sign: 1,
    position: values[`${name}-position`], restitution: restitutionOf(name, values),
  }));
}

// those that limit one combination of the displacements, as seen along it
export function wallsAlong(walls, row) {
  const same = ({ ends }, sign) => row.every((g, i) => sign * g === (ends[1] === i) - (ends[0] === i));
  return walls.flatMap((wall) => (same(wall, 1) ? [wall] : same(wall, -1) ? [{ ...wall, lower: !wall.lower, position: -wall.position, sign: -1 }] : []));
}

export const GROUND = -1; // among the numbers of the points at which a part ends

// a number, or that of a law of the speed; 0 where the law is a function that only the server knows
function restitutionOf(name, values) {
  const value = (field) => values[`${name}-restitution${field}`];
  return (speed) => value("") ?? (value("-speed") ? Math.min(1, value("-restitution") * (speed / value("-speed")) ** -value("-exponent")) : 0);
}

const CONNECTED = OPENED.parts.filter(({ ends }) => ends);
const sameEnds = (a, b) => (a[0] === b[0] && a[1] === b[1]) || (a[0] === b[1] && a[1] === b[0]);

// what connects two masses, or one with the ground: of each two ends at most four rows are drawn
export function linksOf(values) {
  const links = [];
  for (const { ends } of CONNECTED) if (!links.some((link) => sameEnds(link.ends, ends))) links.push({ ends: [Math.min(...ends), Math.max(...ends)] });
  return links.map(({ ends }) => ({ ends, elements: elementsOf(values, ends), rubs: between(ends, "friction").length > 0 }));
}

const between = (ends, ...glyphs) => CONNECTED.filter((part) => glyphs.includes(part.glyph) && sameEnds(part.ends, ends));

function elementsOf(values, ends) {
  const found = (...glyphs) => between(ends, ...glyphs);
  const springs = found("spring"), arms = found("springpot arm").map((part) => ({ draw: "springpot", order: values[orderNumber(part)], arm: true }));
  const rubbing = ends[0] === GROUND ? [] : found("friction").slice(0, 1).map(() => ({ draw: "dashpot" }));
  const rows = [
    ...(springs.length ? [{ draw: "spring", curved: springs.some(({ linear }) => !linear) }] : []),
    ...found("springpot").map((part) => ({ draw: "springpot", order: values[orderNumber(part)] })), ...arms,
    ...found("dashpot").slice(0, 1).map(() => ({ draw: "dashpot" })), ...found("dashpot arm").slice(0, 1).map(() => ({ draw: "dashpot", arm: true })),
    ...found("slider arm").slice(0, 1).map(() => ({ draw: "slider", arm: true })),
    ...found("inerter").slice(0, 1).map(() => ({ draw: "inerter" })), ...rubbing,
  ];
  // where there are many, their marks stand beside each other
  return rows.slice(0, 4).map((one, i, all) => ({ ...one, aside: all.length > 2 ? (i % 2 ? -0.13 : 0.13) : 0 }));
}

const WAVES = ["rough", "smooth", "sine", "spikes", "flat"];
export const excitations = of(...WAVES).map(({ glyph, said, on }) => ({ wave: glyph, said: isSeveral && on && on !== "ground" ? `${said} on ${on}` : said, ground: on === "ground" }));

// the resistors of the circuits, whose voltages come with the motion
export const circuitsOf = (values) => of("circuit").map(({ name, title }) => ({ title, resistance: values[`${name}-resistance`] }));

// Where the masses stand while they rest, and how many pixels a metre is.

import { GROUND, POINTS, hasCircuit, isSeveral, linksOf } from "./problem.js";

export const MIDDLE = 84; // px, the height of the masses
const LANE = 34, LAST = POINTS.length - 1, POST = 18, LEAST = 14;

// one mass: from its lower walls to its support
function single(W, { walls, bounds: [low, high] }) {
  const narrow = W < 520, size = narrow ? 46 : 60;
  const left = walls.some((wall) => wall.lower) ? 40 : 22, right = W - (narrow ? 90 : 150) - size, scale = (right - left) / (high - low);
  return { size, scale, left, right, homes: [left - low * scale], supports: [null, W - 26], floor: floorOf(size) };
}

// several in a row: what is between two of them is as wide as they come near to each other
function row(W, { links, walls, reach }) {
  const size = Math.min(Math.max(W / (2.7 * POINTS.length + 1.5), 24), 60), margin = 22;
  const held = (at) => links.some(({ ends, elements }) => ends[0] === GROUND && ends[1] === at && elements.length);
  const least = POINTS.map((_, k) => (k ? 0.6 * size : held(0) ? 0.8 * size : LEAST)).concat(held(LAST) ? 0.8 * size : LEAST);
  for (const { ends: [from, at] = [], lower } of walls) if (from === GROUND) least[lower ? at : at + 1] += POST;
  const near = POINTS.map((_, k) => (k ? nearing(reach, k) : -reach[0].low)).concat(reach[LAST].high);
  const wide = W - 2 * margin - POINTS.length * size - sum(least), whole = sum(near);
  const scale = whole > 0 ? Math.max(wide, 0.1 * W) / whole : 1, homes = [];
  near.forEach((most, k) => { if (k <= LAST) homes.push((k ? homes[k - 1] + size : margin) + least[k] + scale * most); });
  return { size, scale, left: margin, right: W - margin, homes, supports: [margin, W - margin], floor: floorOf(size) };
}

// how much nearer two neighbors come than they rest
function nearing(reach, k) {
  const between = reach.find(({ row }) => row[k] === 1 && row[k - 1] === -1 && row.every((g, i) => !g || i === k || i === k - 1));
  const turned = reach.find(({ row }) => row[k] === -1 && row[k - 1] === 1 && row.every((g, i) => !g || i === k || i === k - 1));
  return Math.max(between ? -between.low : turned ? turned.high : reach[k - 1].high - reach[k].low, 0);
}

const sum = (numbers) => numbers.reduce((all, one) => all + Math.max(one, 0), 0);
export const layout = isSeveral ? row : single;

// the lane of each link: 0 between neighbors, others under the masses
export function laneOf({ ends: [i, j] }) { return LANES.get(`${i} ${j}`) ?? 0; }
const LANES = new Map(), taken = [];
const apart = (isSeveral ? linksOf({ without: [] }) : []).filter(({ ends: [i, j], elements }) => (i === GROUND ? elements.length && j > 0 && j < LAST : j > i + 1));
const spans = apart.map(({ ends: [i, j] }) => ({ i, j, from: i === GROUND ? j - 1 : i, to: j })).sort((a, b) => a.to - a.from - b.to + b.from);
for (const { i, j, from, to } of spans) {
  let lane = 0;
  while (taken[lane]?.some(([begin, end]) => begin < to && from < end)) lane += 1;
  (taken[lane] ??= []).push([from, to]);
  LANES.set(`${i} ${j}`, lane + 1);
}
export const laneY = (lane, size) => MIDDLE + size / 2 + 16 + LANE * (lane - 1);
const floorOf = (size) => MIDDLE + size / 2 + 10 + LANE * taken.length;
export const TALL = 236 + LANE * taken.length + (isSeveral && hasCircuit ? 26 : 0);

// Which displacements and velocities the pictures of the motion show, of all that can be followed.

import { POINTS, wallsAlong } from "./problem.js";

const DEVIATIONS = 4.5; // on either side of a mean

export function setBounds(view) {
  view.reach = view.followed.map((one, k) => {
    const walls = wallsAlong(view.walls, one.row), { low, high, fastest } = sizeOf(view, one, view.sizes.of[k]), [floor, roof] = endsOf(walls);
    return { ...one, walls, low: Math.max(low, floor), high: Math.min(high, roof), fastest };
  });
}

function sizeOf({ theory, densities, measured }, { name, row }, size) {
  const places = theory?.places[`${name}x`], { edges } = densities?.[`${name}x`] ?? {}, { edges: speeds } = densities?.[`${name}v`] ?? {};
  const values = measured?.values ?? {}, root = values[`${name}rms`], mean = values[`${name}mean`];
  const around = root > 0 ? [mean - DEVIATIONS * root, mean + DEVIATIONS * root] : null; // of what has no density
  const from = edges?.length > 2 ? edges : around ?? places ?? [size.low, size.high];
  const speed = Math.hypot(...row.map((g, i) => g * (values[`${POINTS[i].name}_v_rms`] ?? 0)));
  const fastest = speeds?.length > 2 ? 1.1 * Math.max(-speeds[0], speeds[speeds.length - 1]) : Math.min(DEVIATIONS * speed || Infinity, size.fastest);
  return { low: from[0], high: from[from.length - 1], fastest };
}

// between which rigid walls it stays
function endsOf(walls) {
  const rigid = walls.filter(({ soft }) => !soft);
  return [rigid.find(({ lower }) => lower)?.position ?? -Infinity, rigid.find(({ lower }) => !lower)?.position ?? Infinity];
}

// rare large motions, and growing ones, make room for themselves
export function stretch(view, x, v) {
  const points = view.followed[0].row.length, count = x.length / points;
  for (const reach of view.reach) {
    const { row, walls } = reach, slack = 0.15 * (reach.high - reach.low), [floor, roof] = endsOf(walls);
    for (let k = 0; k < count; k += 1) {
      let place = 0, speed = 0;
      for (let i = 0; i < points; i += 1) {
        place += row[i] * x[i * count + k];
        speed += row[i] * v[i * count + k];
      }
      if (place > reach.high && place <= roof) reach.high = Math.min(place + slack, roof);
      if (place < reach.low - 1e-3 * slack && place >= floor) reach.low = Math.max(place - slack, floor);
      if (Math.abs(speed) > reach.fastest) reach.fastest = 1.15 * Math.abs(speed);
    }
  }
}

// with every wall that is not far away
export function boundsOf({ low, high, walls }) {
  const wide = high - low, near = walls.filter(({ position }) => position > low - 1.2 * wide && position < high + 1.2 * wide);
  const soft = 0.03 * wide;
  return [Math.min(low, ...near.filter(({ lower }) => lower).map((wall) => wall.position - (wall.soft ? soft : 0))),
    Math.max(high, ...near.filter(({ lower }) => !lower).map((wall) => wall.position + (wall.soft ? soft : 0)))];
}

// the walls that are too far away to be drawn, in words
export function outOfView(far, written) {
  const said = far.map(({ name, lower, position }) => (lower ? `← ${name} at ${written(position)}` : `${name} at ${written(position)} →`));
  return said.length ? `Out of view: ${said.join(" · ")}` : "";
}

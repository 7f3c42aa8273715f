// The moving masses between walls and supports, with springs and dampers; below a single one the density of x.

import { Canvas, ticks } from "./canvas.js";
import { arm, bumper, circuit, element, excitation, hatched, post, rubbing, tether } from "./elements.js";
import { MIDDLE, TALL, laneOf, laneY, layout } from "./layout.js";
import { GROUND, POINTS, excitations, isSeveral } from "./problem.js";
import { palette } from "./theme.js";
import { exponentFor, scaledUnit, short } from "./numbers.js";
import { withUnit } from "./units.js";

const FLASH = 350; // ms that an impact is seen
const LABELS_APART = 8; // px between two numbers of an axis
const LAST = POINTS.length - 1;

// as its second end sees it
function oriented(wall) {
  const [first, second] = wall.ends;
  return first < second ? wall : { ...wall, ends: [second, first], lower: !wall.lower, position: -wall.position };
}

export class Scene {
  constructor(host, track) {
    this.canvas = new Canvas(host, () => TALL);
    this.track = track;
    this.flashes = [];
    this.deepest = new Map(); // penetration of each soft contact that was seen
    this.densities = []; // of x of each mass: {place, height, color}
  }

  flash({ speed, wall }) { this.flashes.push({ at: performance.now(), speed, wall }); if (this.flashes.length > 12) this.flashes.shift(); }

  // returns the walls that are too far away
  draw(shown) {
    const g = this.canvas.clear(), W = this.canvas.width, { links, circuits, unit, bounds, rms } = shown, narrow = W < 520;
    const walls = shown.walls.map(oriented);
    const place = layout(W, { ...shown, walls }), { size, scale, floor, homes } = place;
    const X = homes.map((home) => (value) => home + scale * value);
    const stop = isSeveral ? null : walls.find((wall) => wall.lower && !wall.soft); // which the lines of a path may pass
    const x = this.track.states.map((state) => Math.max(state.x.at(-1) ?? 0, stop?.position ?? -Infinity));
    const at = x.map((value, i) => X[i](value)), axisY = floor + 70, half = isSeveral ? size / 2 : 0; // marks of places stand under it
    const tops = this.densities.map((one) => (one ? drawnTop(one.height) : 0)), highest = Math.max(...tops);

    X.forEach((to, i) => this.underneath(g, (value) => to(value) + half, this.densities[i], isSeveral ? [shown.reach[i].low, shown.reach[i].high] : bounds, highest, axisY));
    if (isSeveral) this.scaleBar(g, scale, unit, W); else this.axis(g, X[0], ...bounds, axisY, unit, W);
    this.ground(g, place.left, W, floor);
    const inside = walls.filter((wall) => isInside(wall, place, bounds)), grounded = inside.filter(({ ends }) => ends[0] === GROUND);
    for (const { soft, lower, ends: [, i], position } of grounded) {
      if (soft) continue;
      if (lower && !isSeveral) this.wall(g, X[i](position), floor);
      else post(g, X[i](position) + (lower ? 0 : size), MIDDLE, floor, size, lower ? -1 : 1);
    }
    homes.forEach((home, i) => {
      this.equilibrium(g, home + half, floor, axisY, place);
      this.trail(g, X[i], this.track.states[i].x, size);
    });
    for (const link of links) this.link(g, link, at, place);
    at.forEach((left, i) => {
      const { massive } = POINTS[i]; // or moves as a combination of masses
      g.fillStyle = massive ? palette.mass : palette.panel;
      g.strokeStyle = massive ? palette.panel : palette.mass;
      g.lineWidth = 2;
      rounded(g, left, MIDDLE - size / 2, size, size, 8);
      g.fill();
      g.stroke();
      this.velocity(g, left + size / 2, MIDDLE - size / 2 - (isSeveral ? 22 : 14), this.track.states[i].v.at(-1) ?? 0, rms[i], isSeveral ? size : 70);
      if (isSeveral) this.name(g, POINTS[i].title, homes[i] + half, axisY + 8, 1.6 * size);
    });
    for (const wall of inside) {
      const { soft, lower, ends: [first, second], position } = wall;
      let where = X[second](position) + (lower ? 0 : size);
      if (first !== GROUND) where = this.between(g, wall, at, place);
      else if (soft) this.bumper(g, wall, { walls: grounded.filter(({ ends }) => ends[1] === second), X: X[second], x: x[second], mass: size, middle: MIDDLE, floor });
      this.impacts(g, wall, where, Math.max(...rms));
    }
    this.flashes = this.flashes.filter((flash) => performance.now() - flash.at < FLASH);
    for (const { ends: [first, i], rubs } of links) if (rubs && first === GROUND) rubbing(g, at[i], size, floor);
    excitation(g, excitations, W - 12, 14, narrow);
    if (isSeveral) circuit(g, circuits, this.track.voltages, place.left, TALL - 24, W, 130);
    else circuit(g, circuits, this.track.voltages, place.right + 12, floor + 14, W);
    for (const left of at) {
      g.strokeStyle = g.fillStyle = palette.path;
      g.lineWidth = 2;
      g.beginPath();
      g.moveTo(left + half, floor);
      g.lineTo(left + half, axisY);
      g.stroke();
      g.beginPath();
      g.arc(left + half, axisY, 4.5, 0, 7);
      g.fill();
    }
    return walls.filter((wall) => !inside.includes(wall));
  }

  // springs and dampers between two masses, or to a support at the side; in a lane under the masses if these are apart
  link(g, { ends: [first, second], elements }, at, { size, homes, supports }) {
    const lane = laneOf({ ends: [first, second] }), rows = elements.length;
    if (!rows && !(lane && first !== GROUND)) return;
    const tall = rows < 2 ? 0 : lane ? 14 : (rows > 2 ? 0.76 : 0.54) * size, apart = tall / Math.max(rows - 1, 1);
    const middle = lane ? laneY(lane, size) : MIDDLE, grounded = first === GROUND, right = grounded && !lane && second === LAST;
    let from = grounded ? supports[0] : at[first] + size, to = at[second];
    if (right) [from, to] = [at[second] + size, supports[1]];
    if (lane) {
      from = grounded ? homes[second] - 0.6 * size : at[first] + size / 2;
      to = at[second] + size / 2;
      g.strokeStyle = palette.steel;
      g.lineWidth = 3;
      for (const stem of grounded ? [to] : [from, to]) {
        g.beginPath();
        g.moveTo(stem, MIDDLE);
        g.lineTo(stem, middle + tall / 2 + 1);
        g.stroke();
      }
    }
    const still = grounded ? (right ? supports[1] - homes[second] : homes[second] - supports[0]) : homes[second] - homes[first];
    const coils = isSeveral ? Math.min(Math.max(Math.round((still - size) / 7), 4), 12) : 12; // as many while it moves
    elements.forEach((one, i) => element(g, { ...one, coils }, from, to, middle + i * apart - 0.5 * tall, rows > 1 || lane ? Math.min(1, (lane ? 16 : apart) / 24) : 1));
    if (grounded) hatched(g, right ? to : from, middle - (lane ? 12 : size / 2 + 6), middle + (lane ? 12 : size / 2 + 6), right ? 1 : -1, lane ? 8 : 14, "transparent");
  }

  // a wall or contact between two masses; returns where they meet
  between(g, { ends: [first, second], lower, position, soft }, at, { size, homes, scale }) {
    const lane = laneOf({ ends: [first, second] }), half = lane ? size / 2 : 0;
    const from = at[first] + size - half, to = at[second] + half, meet = from + homes[second] - homes[first] - size + 2 * half + scale * position;
    const y = lane ? laneY(lane, size) - 8 : MIDDLE + (lower ? -1 : 1) * (size / 2 + 6);
    if (lower) arm(g, { from, tip: meet, to, y, soft }); else tether(g, { from, taut: meet, to, y });
    return lower ? to : from;
  }

  name(g, title, x, y, wide) {
    g.font = "12px system-ui, sans-serif";
    g.fillStyle = palette.muted;
    g.textAlign = "center";
    g.textBaseline = "top";
    let said = title;
    while (said.length > 2 && g.measureText(said).width > wide) said = `${said.slice(0, -2)}…`;
    g.fillText(said, x, y);
  }

  // how large the motion is drawn
  scaleBar(g, scale, unit, W) {
    const most = 90 / scale * unit.factor, power = 10 ** Math.floor(Math.log10(most)), size = [5, 2, 1].map((m) => m * power).find((s) => s <= most) ?? power;
    const wide = (size / unit.factor) * scale, right = W - 12, y = TALL - 12;
    g.strokeStyle = g.fillStyle = palette.muted;
    g.lineWidth = 1.5;
    g.beginPath();
    for (const [from, to, at] of [[right - wide, right, y], [right - wide, right - wide, y], [right, right, y]]) {
      g.moveTo(from, from === to ? at - 4 : at);
      g.lineTo(to, from === to ? at + 4 : at);
    }
    g.stroke();
    g.font = "12px system-ui, sans-serif";
    g.textAlign = "right";
    g.textBaseline = "middle";
    g.fillText(`${short(size, 2)} ${unit.name}`, right - wide - 8, y);
  }

  // the density of x, under the path it belongs to
  underneath(g, X, density, [low, high], top, axisY) {
    if (!density) return;
    const { place, height, color } = density;
    g.save();
    g.beginPath();
    g.rect(X(low) - 1, axisY - 60, X(high) - X(low) + 2, 62);
    g.clip();
    g.beginPath();
    g.moveTo(X(place[0]), axisY);
    for (let i = 0; i < place.length; i += 1) g.lineTo(X(place[i]), axisY - 46 * Math.min(height[i] / top, 1));
    g.lineTo(X(place[place.length - 1]), axisY);
    g.closePath();
    g.globalAlpha = 0.16;
    g.fillStyle = palette[color];
    g.fill();
    g.globalAlpha = 0.9;
    g.strokeStyle = palette[color];
    g.lineWidth = 1.5;
    g.stroke();
    g.restore();
  }

  axis(g, X, low, high, y, unit, W) {
    g.strokeStyle = palette.line;
    g.fillStyle = palette.muted;
    g.lineWidth = 1;
    g.font = "12px system-ui, sans-serif";
    g.textAlign = "center";
    g.textBaseline = "top";
    g.beginPath();
    g.moveTo(X(low), y + 0.5);
    g.lineTo(X(high), y + 0.5);
    const exponent = exponentFor(Math.max(Math.abs(low), Math.abs(high)) * unit.factor);
    const marks = (about) => ticks(low * unit.factor, high * unit.factor, about).map((value) => [X(value / unit.factor), short(value / 10 ** exponent, 3)]);
    const apart = (all) => all.every(([at, said], i) => !i || at - all[i - 1][0] > (g.measureText(said).width + g.measureText(all[i - 1][1]).width) / 2 + LABELS_APART);
    for (const [at, said] of [9, 7, 5, 4, 3].map(marks).find(apart) ?? marks(2)) {
      g.moveTo(Math.round(at) + 0.5, y);
      g.lineTo(Math.round(at) + 0.5, y + 5);
      g.fillText(said, at, y + 9);
    }
    g.stroke();
    g.textAlign = "left";
    g.fillText(withUnit("x", scaledUnit(exponent, unit.name)), X(high) + 12, y - 7);
  }

  ground(g, left, W, floor) {
    g.strokeStyle = palette.line;
    g.lineWidth = 1.5;
    g.beginPath();
    g.moveTo(left - 28, floor + 0.5);
    g.lineTo(W - 12, floor + 0.5);
    g.stroke();
  }

  wall(g, at, floor) { hatched(g, at, MIDDLE - 58, floor, -1, 22); }

  equilibrium(g, at, floor, axisY, { left, right }) {
    if (at < left || at > right) return;
    g.strokeStyle = palette.muted;
    g.lineWidth = 1;
    g.setLineDash([3, 4]);
    g.beginPath();
    g.moveTo(Math.round(at) + 0.5, floor);
    g.lineTo(Math.round(at) + 0.5, axisY);
    g.stroke();
    g.setLineDash([]);
  }

  trail(g, X, x, mass) {
    const n = x.length;
    g.strokeStyle = palette.mass;
    g.lineWidth = 2;
    for (let k = 1; k <= 5; k += 1) {
      const i = n - 1 - 5 * k;
      if (i < 0) break;
      g.globalAlpha = 0.22 * (1 - k / 6);
      rounded(g, X(x[i]), MIDDLE - mass / 2, mass, mass, 8);
      g.stroke();
    }
    g.globalAlpha = 1;
  }

  velocity(g, at, y, v, rms, most) {
    const length = Math.max(-most, Math.min(most, (v / (rms || 1)) * 0.43 * most));
    if (Math.abs(length) < 3) return;
    const sign = Math.sign(length);
    g.strokeStyle = g.fillStyle = palette.path;
    g.lineWidth = 2.5;
    g.beginPath();
    g.moveTo(at, y);
    g.lineTo(at + length - sign * 4, y);
    g.stroke();
    g.beginPath();
    g.moveTo(at + length, y);
    g.lineTo(at + length - sign * 8, y - 5);
    g.lineTo(at + length - sign * 8, y + 5);
    g.fill();
  }

  // as long as it has been pressed in, or up to the rigid wall behind it
  bumper(g, wall, { walls, X, x, ...place }) {
    const to = wall.lower ? 1 : -1, depth = Math.max(0, to * (wall.position - x));
    const deepest = Math.max(depth, this.deepest.get(wall.name) ?? 0), behind = walls.find((other) => !other.soft && other.lower === wall.lower);
    this.deepest.set(wall.name, deepest);
    const free = X(wall.position), end = behind ? X(behind.position) : free - to * Math.max(24, 1.15 * Math.abs(X(wall.position - to * deepest) - free));
    bumper(g, { ...place, to, depth, free, face: X(wall.position - to * depth), plate: end });
  }

  impacts(g, { lower, number }, at, rms) {
    const now = performance.now();
    for (const flash of this.flashes) {
      if (flash.wall !== number || now - flash.at >= FLASH) continue;
      const age = (now - flash.at) / FLASH, size = 10 + 26 * Math.min(Math.abs(flash.speed) / (rms || 1), 2.5) * age;
      g.globalAlpha = 0.9 * (1 - age);
      g.strokeStyle = palette.impact;
      g.lineWidth = 3 * (1 - age) + 1;
      g.beginPath();
      g.arc(at, MIDDLE, size, (lower ? 0 : Math.PI) - 1.15, (lower ? 0 : Math.PI) + 1.15);
      g.stroke();
    }
    g.globalAlpha = 1;
  }
}

// a wall is drawn where its mass is seen when it strikes
function isInside({ ends: [first, second], lower, position }, { size, scale, homes, supports }, [low, high]) {
  if (!isSeveral) return position >= low && position <= high;
  const before = second ? homes[second - 1] + size : supports[0], after = homes[second + 1] ?? supports[1];
  const meet = homes[second] + scale * position;
  if (first !== GROUND) return !lower || meet > homes[first] + size + 8;
  return lower ? meet > before + 4 : meet + size < after - 4;
}

// a density may rise without bound at a lossy wall: a few points of it must not flatten the rest
function drawnTop(height) {
  const sorted = [...height].sort((a, b) => a - b);
  return Math.min(sorted.at(-1), 1.5 * sorted[Math.floor(0.95 * sorted.length)]) || sorted.at(-1) || 1;
}

function rounded(g, x, y, w, h, r) {
  g.beginPath();
  g.roundRect(x, y, w, h, r);
}

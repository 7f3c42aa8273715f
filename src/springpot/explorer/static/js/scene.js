// The moving mass between its wall and the support, with spring and springpot; below it the density of x.

import { Canvas, ticks } from "./canvas.js";
import { bumper, circuit, element, excitation, post, rubbing } from "./elements.js";
import { excitations, rubs } from "./problem.js";
import { palette } from "./theme.js";
import { exponentFor, scaledUnit, short } from "./numbers.js";
import { withUnit } from "./units.js";

const FLASH = 350; // ms that an impact is seen
const TALL = 236;

export class Scene {
  constructor(host, track) {
    this.canvas = new Canvas(host, () => TALL);
    this.track = track;
    this.flashes = [];
    this.deepest = new Map(); // penetration of each soft contact that was seen
    this.density = null;
    this.density_color = null;
  }

  flash({ speed, wall }) { this.flashes.push({ at: performance.now(), speed, wall }); if (this.flashes.length > 12) this.flashes.shift(); }

  draw({ walls, elements, circuits, unit, bounds, rms }) {
    const c = this.canvas, g = c.clear(), W = c.width;
    const lower = walls.find((wall) => wall.lower && !wall.soft), x = lower ? Math.max(this.track.now.x, lower.position) : this.track.now.x;
    const { v } = this.track.now;
    const [low, high] = bounds;
    const narrow = W < 520;
    const mass = narrow ? 46 : 60, left = walls.some((wall) => wall.lower) ? 40 : 22, right = W - (narrow ? 90 : 150) - mass;
    const X = (value) => left + ((value - low) / (high - low)) * (right - left);
    const middle = 84, floor = middle + mass / 2 + 10, axisY = floor + 70;

    // the density of x, under the path it belongs to
    if (this.density) {
      const { place, height } = this.density, top = drawnTop(height);
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
      g.fillStyle = palette[this.density_color];
      g.fill();
      g.globalAlpha = 0.9;
      g.strokeStyle = palette[this.density_color];
      g.lineWidth = 1.5;
      g.stroke();
      g.restore();
    }
    this.axis(g, X, low, high, axisY, unit, W);
    this.ground(g, left, W, floor);
    const inside = walls.filter(({ position }) => position >= low && position <= high);
    for (const wall of inside) {
      if (!wall.soft && wall.lower) this.wall(g, X(wall.position), middle, floor);
      else if (!wall.soft) post(g, X(wall.position) + mass, middle, floor, mass);
    }
    this.equilibrium(g, X(0), floor, axisY, left, right);

    const at = X(x), back = at + mass, support = W - 26;
    this.trail(g, X, middle, mass);
    const rows = elements.length, tall = rows < 2 ? 0 : (rows > 2 ? 0.76 : 0.54) * mass, apart = tall / Math.max(rows - 1, 1);
    elements.forEach((one, i) => element(g, one, back, support, middle + i * apart - 0.5 * tall, rows > 1 ? Math.min(1, apart / 24) : 1));
    this.support(g, support, middle, mass);

    g.fillStyle = palette.mass;
    g.strokeStyle = palette.panel;
    g.lineWidth = 2;
    rounded(g, at, middle - mass / 2, mass, mass, 8);
    g.fill();
    g.stroke();
    this.velocity(g, at + mass / 2, middle - mass / 2 - 14, v, rms);
    for (const wall of inside) {
      if (wall.soft) this.bumper(g, wall, { walls, X, x, mass, middle, floor });
      this.impacts(g, wall, walls.indexOf(wall), X(wall.position) + (wall.lower ? 0 : mass), middle, rms);
    }
    this.flashes = this.flashes.filter((flash) => performance.now() - flash.at < FLASH);
    if (rubs) rubbing(g, at, mass, floor);
    excitation(g, excitations, W - 12, 14, narrow);
    circuit(g, circuits, this.track.voltages, X(high) + 12, floor + 14, W);
    g.strokeStyle = palette.path;
    g.lineWidth = 2;
    g.beginPath();
    g.moveTo(at, floor);
    g.lineTo(at, axisY);
    g.stroke();
    g.fillStyle = palette.path;
    g.beginPath();
    g.arc(at, axisY, 4.5, 0, 7);
    g.fill();
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
    for (const value of ticks(low * unit.factor, high * unit.factor, W < 520 ? 5 : 9)) {
      const at = X(value / unit.factor);
      g.moveTo(Math.round(at) + 0.5, y);
      g.lineTo(Math.round(at) + 0.5, y + 5);
      g.fillText(short(value / 10 ** exponent, 3), at, y + 9);
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

  wall(g, at, middle, floor) {
    const top = middle - 58, width = 22;
    g.save();
    g.beginPath();
    g.rect(at - width, top, width, floor - top);
    g.clip();
    g.fillStyle = palette.faint;
    g.fill();
    g.strokeStyle = palette.steel;
    g.lineWidth = 1.5;
    for (let y = top - width; y < floor; y += 9) {
      g.beginPath();
      g.moveTo(at - width, y + width);
      g.lineTo(at, y);
      g.stroke();
    }
    g.restore();
    g.strokeStyle = palette.text;
    g.lineWidth = 3;
    g.beginPath();
    g.moveTo(at - 1.5, top);
    g.lineTo(at - 1.5, floor);
    g.stroke();
  }

  support(g, at, middle, mass) {
    const top = middle - mass / 2 - 6, tall = mass + 12;
    g.save();
    g.beginPath();
    g.rect(at, top, 14, tall);
    g.clip();
    g.strokeStyle = palette.steel;
    g.lineWidth = 1.5;
    for (let y = top - 14; y < top + tall + 14; y += 8) {
      g.beginPath();
      g.moveTo(at, y + 14);
      g.lineTo(at + 14, y);
      g.stroke();
    }
    g.restore();
    g.strokeStyle = palette.text;
    g.lineWidth = 2.5;
    g.beginPath();
    g.moveTo(at, top);
    g.lineTo(at, top + tall);
    g.stroke();
  }

  equilibrium(g, at, floor, axisY, left, right) {
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

  trail(g, X, middle, mass) {
    const { x } = this.track, n = x.length;
    g.strokeStyle = palette.mass;
    g.lineWidth = 2;
    for (let k = 1; k <= 5; k += 1) {
      const i = n - 1 - 5 * k;
      if (i < 0) break;
      g.globalAlpha = 0.22 * (1 - k / 6);
      rounded(g, X(x[i]), middle - mass / 2, mass, mass, 8);
      g.stroke();
    }
    g.globalAlpha = 1;
  }

  velocity(g, at, y, v, rms) {
    const length = Math.max(-70, Math.min(70, (v / (rms || 1)) * 30));
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

  impacts(g, { lower }, number, at, middle, rms) {
    const now = performance.now();
    for (const flash of this.flashes) {
      if (flash.wall !== number || now - flash.at >= FLASH) continue;
      const age = (now - flash.at) / FLASH, size = 10 + 26 * Math.min(Math.abs(flash.speed) / (rms || 1), 2.5) * age;
      g.globalAlpha = 0.9 * (1 - age);
      g.strokeStyle = palette.impact;
      g.lineWidth = 3 * (1 - age) + 1;
      g.beginPath();
      g.arc(at, middle, size, (lower ? 0 : Math.PI) - 1.15, (lower ? 0 : Math.PI) + 1.15);
      g.stroke();
    }
    g.globalAlpha = 1;
  }
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

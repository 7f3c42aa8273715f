// The moving mass between its wall and the support, with spring and springpot; below it the density of x.

import { Canvas, ticks } from "./canvas.js";
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
    this.density = null;
    this.density_color = null;
  }

  flash(speed) { this.flashes.push({ at: performance.now(), speed }); if (this.flashes.length > 12) this.flashes.shift(); }

  draw({ values, unit, bounds, rms }) {
    const c = this.canvas, g = c.clear(), W = c.width;
    const { v } = this.track.now, x = values.wall ? Math.max(this.track.now.x, values.position) : this.track.now.x;
    const [low, high] = bounds;
    const narrow = W < 520;
    const mass = narrow ? 46 : 60, left = values.wall ? 40 : 22, right = W - (narrow ? 90 : 150) - mass;
    const X = (value) => left + ((value - low) / (high - low)) * (right - left);
    const middle = 84, floor = middle + mass / 2 + 10, axisY = floor + 70;

    // the density of x, under the path it belongs to
    if (this.density) {
      const { place, height } = this.density, top = drawnTop(height);
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
      g.globalAlpha = 1;
    }
    this.axis(g, X, low, high, axisY, unit, W);
    this.ground(g, left, W, floor);
    if (values.wall) this.wall(g, X(values.position), middle, floor);
    this.equilibrium(g, X(0), floor, axisY, left, right);

    const at = X(x), back = at + mass, support = W - 26;
    this.trail(g, X, middle, mass);
    this.spring(g, back, support, middle - mass * 0.27);
    this.springpot(g, back, support, middle + mass * 0.27, values.order);
    this.support(g, support, middle, mass);

    g.fillStyle = palette.mass;
    g.strokeStyle = palette.panel;
    g.lineWidth = 2;
    rounded(g, at, middle - mass / 2, mass, mass, 8);
    g.fill();
    g.stroke();
    this.velocity(g, at + mass / 2, middle - mass / 2 - 14, v, rms);
    if (values.wall) this.impacts(g, X(values.position), middle, rms);
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
    for (const value of ticks(low, high, W < 520 ? 5 : 9)) {
      g.moveTo(Math.round(X(value)) + 0.5, y);
      g.lineTo(Math.round(X(value)) + 0.5, y + 5);
      g.fillText(short((value * unit.factor) / 10 ** exponent, 3), X(value), y + 9);
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

  spring(g, from, to, y) {
    const coils = 12, lead = Math.min(14, (to - from) * 0.12), pitch = (to - from - 2 * lead) / coils;
    g.strokeStyle = palette.steel;
    g.lineWidth = 2;
    g.lineJoin = "round";
    g.beginPath();
    g.moveTo(from, y);
    g.lineTo(from + lead, y);
    for (let i = 0; i < coils; i += 1) {
      g.lineTo(from + lead + (i + 0.25) * pitch, y - 9);
      g.lineTo(from + lead + (i + 0.75) * pitch, y + 9);
    }
    g.lineTo(to - lead, y);
    g.lineTo(to, y);
    g.stroke();
  }

  // the rhombus that stands for an element between a spring and a dashpot
  springpot(g, from, to, y, order) {
    const middle = (from + to) / 2, half = Math.min(26, (to - from) * 0.3), tall = 12;
    g.strokeStyle = palette.steel;
    g.lineWidth = 2;
    g.beginPath();
    g.moveTo(from, y);
    g.lineTo(middle - half, y);
    g.moveTo(middle + half, y);
    g.lineTo(to, y);
    g.stroke();
    g.beginPath();
    g.moveTo(middle - half, y);
    g.lineTo(middle, y - tall);
    g.lineTo(middle + half, y);
    g.lineTo(middle, y + tall);
    g.closePath();
    g.fillStyle = palette.panel;
    g.fill();
    g.stroke();
    if (half > 18) {
      g.fillStyle = palette.text;
      g.font = "italic 12px Georgia, serif";
      g.textAlign = "center";
      g.textBaseline = "middle";
      g.fillText(short(order, 2), middle, y + 0.5);
    }
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

  impacts(g, at, middle, rms) {
    const now = performance.now();
    this.flashes = this.flashes.filter((flash) => now - flash.at < FLASH);
    for (const flash of this.flashes) {
      const age = (now - flash.at) / FLASH, size = 10 + 26 * Math.min(flash.speed / (rms || 1), 2.5) * age;
      g.globalAlpha = 0.9 * (1 - age);
      g.strokeStyle = palette.impact;
      g.lineWidth = 3 * (1 - age) + 1;
      g.beginPath();
      g.arc(at, middle, size, -1.15, 1.15);
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

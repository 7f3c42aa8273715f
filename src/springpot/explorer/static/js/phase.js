// Velocity against displacement: the newest part of the path bright, the older part fading.

import { Canvas, ticks } from "./canvas.js";
import { palette } from "./theme.js";
import { exponentFor, scaledUnit, short } from "./numbers.js";
import { withUnit } from "./units.js";

const SHADES = 8;

export class Phase {
  constructor(host, track, height) {
    this.canvas = new Canvas(host, height);
    this.track = track;
  }

  draw({ walls, bounds, fastest, ring, window, units, said }) {
    const c = this.canvas, g = c.clear();
    const left = 56, right = c.width - 12, top = 8, bottom = c.tall - 44;
    const [low, high] = bounds;
    const X = (x) => left + ((x - low) / (high - low)) * (right - left);
    const Y = (v) => (top + bottom) / 2 - (v / fastest) * ((bottom - top) / 2);
    this.axes(g, { X, Y, left, right, top, bottom, low, high, fastest, units, said });
    g.save();
    g.beginPath();
    g.rect(left, top, right - left, bottom - top);
    g.clip();
    for (const { position, lower, soft } of walls) {
      const at = X(position);
      g.fillStyle = palette.faint;
      g.globalAlpha = soft ? 0.55 : 1;
      g.fillRect(lower ? left : at, top, Math.max(lower ? at - left : right - at, 0), bottom - top);
      g.globalAlpha = 1;
      g.strokeStyle = palette.text;
      g.lineWidth = 2;
      g.setLineDash(soft ? [5, 4] : []);
      line(g, at, top, at, bottom);
      g.setLineDash([]);
    }
    this.path(g, X, Y, window, walls);
    if (ring) {
      const { radius, frequency } = ring, [wall] = walls, side = wall?.lower === false ? -1 : 1, cut = wall ? (side * wall.position) / radius : -1;
      const half = Math.acos(Math.min(Math.max(cut, -1), 1)); // of the arc in front of the wall
      g.strokeStyle = palette.text;
      g.setLineDash([5, 4]);
      g.lineWidth = 1.5;
      g.beginPath();
      for (let i = 0; i <= 96; i += 1) {
        const p = (i / 48 - 1) * half;
        g.lineTo(X(side * radius * Math.cos(p)), Y(radius * frequency * Math.sin(p)));
      }
      g.stroke();
      g.setLineDash([]);
    }
    g.restore();
  }

  path(g, X, Y, window, walls) {
    const { t, x, v, now, hits } = this.track, first = this.track.from(now.t - window);
    g.lineWidth = 1.6;
    g.lineJoin = "round";
    g.strokeStyle = palette.path;
    const count = t.length - first, part = Math.ceil(count / SHADES);
    for (let s = 0; s < SHADES; s += 1) {
      const begin = first + s * part, end = Math.min(begin + part, t.length - 1);
      if (begin >= end) break;
      g.globalAlpha = 0.12 + 0.88 * ((s + 1) / SHADES) ** 2;
      g.beginPath();
      g.moveTo(X(x[begin]), Y(v[begin]));
      for (let i = begin + 1; i <= end; i += 1) g.lineTo(X(x[i]), Y(v[i]));
      g.stroke();
    }
    g.fillStyle = palette.impact;
    for (let i = hits.length - 1; i >= 0 && hits[i].t >= now.t - window; i -= 1) {
      const wall = walls.find(({ number }) => number === hits[i].wall);
      if (!wall) continue;
      g.globalAlpha = 0.35 + 0.65 * (1 - (now.t - hits[i].t) / window);
      g.beginPath();
      const at = this.track.from(hits[i].t), speed = wall.sign * hits[i].speed;
      const near = speed < 0 ? Math.max : Math.min;
      g.arc(X(near(x[Math.max(at - 1, 0)], x[at] ?? x[at - 1])), Y(-speed), 3, 0, 7);
      g.fill();
    }
    g.globalAlpha = 1;
    if (count > 0) {
      g.fillStyle = palette.path;
      g.strokeStyle = palette.panel;
      g.lineWidth = 2;
      g.beginPath();
      g.arc(X(now.x), Y(now.v), 6, 0, 7);
      g.fill();
      g.stroke();
    }
  }

  axes(g, { X, Y, left, right, top, bottom, low, high, fastest, units, said }) {
    g.font = "12px system-ui, sans-serif";
    g.fillStyle = palette.muted;
    g.strokeStyle = palette.faint;
    g.lineWidth = 1;
    const { length, speed } = units;
    const powers = [exponentFor(Math.max(Math.abs(low), Math.abs(high)) * length.factor), exponentFor(fastest * speed.factor)];
    g.textAlign = "center";
    g.textBaseline = "top";
    for (const x of ticks(low * length.factor, high * length.factor, Math.max((right - left) / 60, 2))) {
      const at = X(x / length.factor), tick = short(x / 10 ** powers[0], 3), most = this.canvas.width - g.measureText(tick).width / 2;
      line(g, Math.round(at) + 0.5, top, Math.round(at) + 0.5, bottom);
      g.fillText(tick, Math.min(at, most), bottom + 6);
    }
    g.textAlign = "right";
    g.textBaseline = "middle";
    for (const v of ticks(-fastest * speed.factor, fastest * speed.factor, Math.max((bottom - top) / 45, 2))) {
      const at = Y(v / speed.factor);
      line(g, left, Math.round(at) + 0.5, right, Math.round(at) + 0.5);
      g.fillText(short(v / 10 ** powers[1], 3), left - 6, at);
    }
    g.textAlign = "center";
    g.textBaseline = "bottom";
    g.fillText(withUnit(said[0], scaledUnit(powers[0], length.name)), (left + right) / 2, this.canvas.tall - 4);
    g.save();
    g.translate(11, (top + bottom) / 2);
    g.rotate(-Math.PI / 2);
    g.textBaseline = "middle";
    g.fillText(withUnit(said[1], scaledUnit(powers[1], speed.name)), 0, 0);
    g.restore();
  }
}

function line(g, x0, y0, x1, y1) {
  g.beginPath();
  g.moveTo(x0, y0);
  g.lineTo(x1, y1);
  g.stroke();
}

// Springs, dampers, stops, circuits and excitations, as they are drawn beside the mass.

import { palette } from "./theme.js";
import { short } from "./numbers.js";
import { isHeavy } from "./problem.js";

const WORDS = "12px system-ui, sans-serif";

// one row between mass and support; small where there are many
export function element(g, { draw, order, arm, curved, aside = 0, coils = 12 }, from, to, y, size) {
  g.strokeStyle = palette.steel;
  g.lineWidth = 2;
  g.lineJoin = "round";
  if (draw === "spring") spring(g, from, to, y, size, curved, coils);
  else {
    // an arm is a spring in series with what remembers, damps or slips
    const begin = arm ? from + 0.45 * (to - from) : from;
    if (arm) spring(g, from, begin, y, 0.7 * size, false, coils);
    if (draw === "inerter") inerter(g, from, to, y, size, aside);
    else if (draw === "springpot") springpot(g, begin, to, y, order, size, aside);
    else if (draw === "slider") slider(g, begin, to, y, size, aside);
    else dashpot(g, begin, to, y, size, aside);
  }
}

function spring(g, from, to, y, size, curved, coils) {
  const lead = Math.min(14, (to - from) * 0.12), pitch = (to - from - 2 * lead) / coils;
  g.beginPath();
  g.moveTo(from, y);
  g.lineTo(from + lead, y);
  for (let i = 0; i < coils; i += 1) {
    g.lineTo(from + lead + (i + 0.25) * pitch, y - 9 * size);
    g.lineTo(from + lead + (i + 0.75) * pitch, y + 9 * size);
  }
  g.lineTo(to - lead, y);
  g.lineTo(to, y);
  g.stroke();
  if (!curved) return;
  // the arrow of a spring whose stiffness changes
  const middle = (from + to) / 2, wide = 12, tall = 13 * size;
  g.beginPath();
  g.moveTo(middle - wide, y + tall);
  g.lineTo(middle + wide, y - tall);
  g.moveTo(middle + wide - 7, y - tall + 1);
  g.lineTo(middle + wide, y - tall);
  g.lineTo(middle + wide - 1.5, y - tall + 7);
  g.stroke();
}

// the rhombus that stands for an element between a spring and a dashpot
function springpot(g, from, to, y, order, size, aside) {
  const middle = (from + to) / 2 + aside * (to - from), half = Math.min(26, (to - from) * 0.3), tall = 12 * size;
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
    g.font = `italic ${size > 0.75 ? 12 : 10}px Georgia, serif`;
    g.textAlign = "center";
    g.textBaseline = "middle";
    g.fillText(short(order, 2), middle, y + 0.5);
  }
}

function dashpot(g, from, to, y, size, aside) {
  const middle = (from + to) / 2 + aside * (to - from), half = Math.min(14, (to - from) * 0.2), tall = 8 * size;
  g.beginPath();
  g.moveTo(from, y);
  g.lineTo(middle + 0.2 * half, y);
  g.moveTo(middle + 0.2 * half, y - 0.75 * tall);
  g.lineTo(middle + 0.2 * half, y + 0.75 * tall);
  g.moveTo(middle - half, y - tall);
  g.lineTo(middle + half, y - tall);
  g.lineTo(middle + half, y + tall);
  g.lineTo(middle - half, y + tall);
  g.moveTo(middle + half, y);
  g.lineTo(to, y);
  g.stroke();
}

// a block that slips on a plate
function slider(g, from, to, y, size, aside) {
  const middle = (from + to) / 2 + aside * (to - from), half = Math.min(12, (to - from) * 0.18), tall = 9 * size;
  g.beginPath();
  g.moveTo(from, y);
  g.lineTo(middle - half, y);
  g.rect(middle - half, y - 0.5 * tall, 2 * half, tall);
  g.moveTo(middle - 1.8 * half, y + 0.5 * tall + 2);
  g.lineTo(middle + 1.8 * half, y + 0.5 * tall + 2);
  g.lineTo(middle + 1.8 * half, y);
  g.lineTo(to, y);
  g.stroke();
}

// a wheel that turns as its ends move apart
function inerter(g, from, to, y, size, aside) {
  const middle = (from + to) / 2 + aside * (to - from), radius = 11 * size;
  g.beginPath();
  g.moveTo(from, y);
  g.lineTo(to, y);
  g.stroke();
  g.beginPath();
  g.arc(middle, y, radius, 0, 7);
  g.fillStyle = palette.panel;
  g.fill();
  g.stroke();
  g.beginPath();
  const turn = (to - from) / 20;
  for (const angle of [turn, turn + Math.PI / 2]) {
    g.moveTo(middle - radius * Math.cos(angle), y - radius * Math.sin(angle));
    g.lineTo(middle + radius * Math.cos(angle), y + radius * Math.sin(angle));
  }
  g.stroke();
}

// a wall through which springs and dampers pass: two stops; to: 1 if the mass is on its left
export function post(g, at, middle, floor, mass, to = 1) {
  const wide = 16, top = middle - 58;
  for (const [from, until] of [[top, middle - 0.4 * mass], [middle + 0.4 * mass, floor]]) hatched(g, at, from, until, to, wide);
}

// a piece of a wall or support, and the line of its face
export function hatched(g, at, from, until, to, wide, fill = palette.faint) {
  const begin = to > 0 ? at : at - wide;
  g.save();
  g.beginPath();
  g.rect(begin, from, wide, until - from);
  g.clip();
  g.fillStyle = fill;
  g.fill();
  g.strokeStyle = palette.steel;
  g.lineWidth = 1.5;
  for (let y = from - wide; y < until + wide; y += 9) {
    g.beginPath();
    g.moveTo(begin, y + wide);
    g.lineTo(begin + wide, y);
    g.stroke();
  }
  g.restore();
  g.strokeStyle = palette.text;
  g.lineWidth = 3;
  g.beginPath();
  g.moveTo(at + 1.5 * to, from);
  g.lineTo(at + 1.5 * to, until);
  g.stroke();
}

// a soft contact: a pad before a plate, pressed together while the mass is in it, and how deep
// to: 1 if it pushes to the right; its free face, its face now, and the plate behind it
export function bumper(g, { to, depth, mass, middle, floor, ...at }) {
  const [free, face, plate] = [at.free, at.face, at.plate].map((place) => place + (to > 0 ? 0 : mass));
  const tops = to > 0 ? [[middle - 0.38 * mass, middle + 0.38 * mass]] : [[middle - 0.66 * mass, middle - 0.42 * mass], [middle + 0.42 * mass, middle + 0.62 * mass]];
  const begin = Math.min(plate, face), wide = Math.abs(plate - face);
  for (const [from, until] of tops) {
    g.beginPath();
    g.roundRect(begin, from, wide, until - from, 5);
    g.fillStyle = palette.impact;
    g.globalAlpha = depth > 0 ? 0.55 : 0.22;
    g.fill();
    g.globalAlpha = 1;
    g.strokeStyle = palette.impact;
    g.lineWidth = 1.5;
    g.stroke();
    g.strokeStyle = palette.text;
    g.lineWidth = 3;
    g.beginPath();
    g.moveTo(plate, from - 4);
    g.lineTo(plate, until + 4);
    g.stroke();
  }
  g.strokeStyle = palette.impact;
  g.lineWidth = 1;
  g.setLineDash([3, 3]);
  g.beginPath();
  g.moveTo(free, middle - 0.72 * mass);
  g.lineTo(free, floor);
  g.stroke();
  g.setLineDash([]);
  if (!(depth > 0)) return;
  g.fillStyle = palette.impact;
  g.font = WORDS;
  g.textAlign = to > 0 ? "left" : "right";
  g.textBaseline = "top";
  g.fillText(`${prefixed(depth)}m deep`, to > 0 ? Math.max(plate, 4) : plate, floor + 5);
}

// friction: what the mass rubs on
export function rubbing(g, at, mass, floor) {
  g.strokeStyle = palette.steel;
  g.lineWidth = 1.5;
  for (let x = at + 3; x < at + mass - 2; x += 7) {
    g.beginPath();
    g.moveTo(x, floor);
    g.lineTo(x + 5, floor - 8);
    g.stroke();
  }
}

const SHAPES = {
  rough: [0, 5, -4, 3, -6, 6, -2, 4, -5, 1, 0], smooth: [0, 3, 5, 3, -1, -5, -4, 0, 3, 2, 0],
  sine: [0, 3.5, 5, 3.5, 0, -3.5, -5, -3.5, 0], spikes: [0, 0, 6, 0, 0, -5, 0, 0, 0, 6, 0], flat: [-3, -3, -3],
};

// what excites the motion, at the upper right: a small picture of it, its name, and whether it is of the ground
export function excitation(g, kinds, right, y, narrow) {
  g.font = WORDS;
  g.textAlign = "right";
  g.textBaseline = "middle";
  let x = right;
  const shown = kinds.slice(0, narrow ? 1 : 3), more = kinds.length > shown.length ? ` + ${kinds.length - shown.length}` : "";
  for (const { wave, said, ground } of shown.reverse()) {
    const words = `${said}${ground ? " of the ground" : ""}${x === right ? more : ""}`, shape = SHAPES[wave], wide = 34;
    g.fillStyle = palette.muted;
    g.fillText(words, x, y);
    x -= g.measureText(words).width + 6 + wide;
    g.strokeStyle = palette.accent ?? palette.path;
    g.lineWidth = 1.5;
    g.beginPath();
    shape.forEach((height, i) => g.lineTo(x + (i / (shape.length - 1)) * wide, y - height));
    g.stroke();
    x -= 16;
  }
}

// the resistor of each circuit, with its voltage and power of now: below each other, or apart from each other
export function circuit(g, circuits, voltages, begin, y, W, apart = 0) {
  circuits.slice(0, 2).forEach(({ resistance }, i) => {
    const volts = voltages[i] ?? 0, left = begin + apart * i, top = apart ? y : y + 44 * i, wide = Math.min(34, 0.4 * (W - left));
    g.strokeStyle = palette.steel;
    g.lineWidth = 1.5;
    g.beginPath();
    g.moveTo(left, top);
    for (let k = 0; k <= 8; k += 1) g.lineTo(left + wide * (0.15 + (0.7 * k) / 8), top + (k % 8 ? (k % 2 ? -5 : 5) : 0));
    g.lineTo(left + wide, top);
    g.stroke();
    g.fillStyle = palette.text;
    g.font = WORDS;
    g.textAlign = "left";
    g.textBaseline = "middle";
    g.fillText(`${prefixed(volts)}V`, left + wide + 6, top);
    g.fillStyle = palette.muted;
    g.fillText(`${prefixed(volts ** 2 / resistance)}${isHeavy ? "W" : "m²/s³"}`, left + wide + 6, top + 15);
  });
}

const PREFIXES = { "-12": "p", "-9": "n", "-6": "µ", "-3": "m", 0: "", 3: "k", 6: "M" };
function prefixed(value) {
  const size = Math.abs(value), power = size > 0 ? Math.min(Math.max(3 * Math.floor(Math.log10(size) / 3 + 1e-9), -12), 6) : 0;
  return `${(value / 10 ** power).toPrecision(3).replace("-", "−").replace(/e.*/, "")} ${PREFIXES[power]}`;
}

// a stop between two masses: an arm on the one, whose tip meets the horn of the other
export function arm(g, { from, tip, to, y, soft }) {
  const pad = soft ? 10 : 0, touched = to <= tip + 1, face = Math.min(tip, to), base = Math.min(tip - pad, face - (soft ? 2 : 0));
  g.strokeStyle = g.fillStyle = touched ? palette.impact : palette.text;
  g.lineWidth = 3;
  g.beginPath();
  g.moveTo(from - 6, y + 7);
  g.lineTo(from - 6, y);
  g.lineTo(base, y);
  g.moveTo(base, y - 6);
  g.lineTo(base, y + 6);
  g.moveTo(to + 1.5, y - 6);
  g.lineTo(to + 1.5, y + 7);
  g.stroke();
  if (!soft) return;
  g.globalAlpha = touched ? 0.8 : 0.4;
  g.fillStyle = palette.impact;
  g.fillRect(base, y - 6, Math.max(face - base, 2), 12);
  g.globalAlpha = 1;
}

// what keeps two masses from moving further apart: a string, straight when it is taut
export function tether(g, { from, taut, to, y }) {
  const slack = Math.max(taut - to, 0), sag = Math.min(Math.sqrt(0.375 * slack * Math.max(to - from, 1)), 26);
  g.strokeStyle = slack > 1 ? palette.steel : palette.impact;
  g.lineWidth = slack > 1 ? 1.5 : 2.5;
  g.beginPath();
  g.moveTo(from, y);
  g.quadraticCurveTo((from + to) / 2, y + 2 * sag, to, y);
  g.stroke();
}

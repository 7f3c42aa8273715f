// Colors for the canvases, from the style sheet's variables; the methods' lines; and the switch between dark and light.

import { METHODS } from "/methods.js";

const COLORS = [
  "text", "muted", "faint", "line", "panel", "page", "measured", "measured-soft", "pinned", "impact", "path", "steel", "mass",
];
export const palette = {};
const listeners = new Set();
const dark = matchMedia("(prefers-color-scheme: dark)");

function read() {
  const style = getComputedStyle(document.documentElement);
  for (const name of COLORS) palette[name] = style.getPropertyValue(`--${name}`).trim();
  for (const [name, { color }] of Object.entries(METHODS)) palette[name] = style.getPropertyValue(`--method-${color}`).trim();
  for (const listener of listeners) listener();
}

export function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : dark.matches;
}

export function onTheme(listener) { listeners.add(listener); }

// a method's swatch is a piece of its line
function swatch([name, { color, dash }]) {
  let end = 0;
  const stops = dash.map((length, i) => `${i % 2 ? "transparent" : `var(--method-${color})`} ${end}px ${end += length}px`);
  const line = stops.length ? `repeating-linear-gradient(90deg, ${stops.join(", ")})` : `var(--method-${color})`;
  return `.swatch[data-method="${name}"] { background: ${line}; }`;
}

export function startTheme(button) {
  const swatches = new CSSStyleSheet();
  swatches.replaceSync(Object.entries(METHODS).map(swatch).join("\n"));
  document.adoptedStyleSheets = [swatches];
  button.addEventListener("click", () => {
    const next = isDark() ? "light" : "dark";
    document.documentElement.dataset.theme = next;
    try { localStorage.setItem("springpot-theme", next); } catch { /* it then lasts as long as the page */ }
    read();
  });
  dark.addEventListener("change", read);
  let before;
  addEventListener("beforeprint", () => { before = document.documentElement.dataset.theme; document.documentElement.dataset.theme = "light"; read(); }); // on paper
  addEventListener("afterprint", () => { if (before) document.documentElement.dataset.theme = before; else delete document.documentElement.dataset.theme; read(); });
  read();
}

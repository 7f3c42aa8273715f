// Colours for the canvases, from the style sheet's variables; and the switch between dark and light.

const NAMES = [
  "text", "muted", "faint", "line", "panel", "page", "measured", "measured-soft", "pinned", "impact", "path", "steel", "mass",
  "exact", "fokker_planck", "envelope", "closure", "averaging_shifted", "averaging", "averaging_printed",
];
export const palette = {};
const listeners = new Set();
const dark = matchMedia("(prefers-color-scheme: dark)");

function read() {
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) palette[name] = style.getPropertyValue(`--${name}`).trim();
  for (const listener of listeners) listener();
}

export function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : dark.matches;
}

export function onTheme(listener) { listeners.add(listener); }

export function startTheme(button) {
  button.addEventListener("click", () => {
    const next = isDark() ? "light" : "dark";
    document.documentElement.dataset.theme = next;
    try { localStorage.setItem("springpot-theme", next); } catch { /* it then lasts as long as the page */ }
    read();
  });
  dark.addEventListener("change", read);
  read();
}

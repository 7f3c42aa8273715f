// Every theory beside Monte Carlo: value, gap in per cent and in standard errors, warnings; and which ones are drawn.

import { METHODS, NAMES } from "/methods.js";
import { exponentFor, scaledUnit, short, typeset, withError } from "./numbers.js";
import { unitOf } from "./units.js";

const SMALL = 2, LARGE = 5; // per cent

export function gapOf(theory, value, error) {
  if (![theory, value, error].every(Number.isFinite) || !(error > 0)) return null;
  const percent = Math.abs(value) > 3 * error ? 100 * (theory / value - 1) : null;
  return { percent, errors: (theory - value) / error };
}

export function gapText(gap) {
  if (!gap) return "";
  const signed = (number, places) => (number < 0 ? "−" : "+") + Math.abs(number).toFixed(places);
  const deviation = Math.abs(gap.errors) < 9.95 ? Math.abs(gap.errors).toFixed(1) : Math.round(Math.abs(gap.errors));
  return gap.percent === null ? `(${deviation} se)` : `${signed(gap.percent, 1)} % (${deviation} se)`;
}

// of each quantity of a table its unit, with one power of ten for the whole column; ``of`` a row they have full names
export function columnsFor({ state }, { rows, columns }, sources) {
  return columns.map(([name, symbol]) => {
    const { factor, name: unit } = unitOf(rows[0][0] + name, state);
    const sizes = sources.filter(Boolean).flatMap(({ values }) => rows.map(([whose]) => Math.abs(values[whose + name] ?? 0) * factor));
    const exponent = exponentFor(Math.max(0, ...sizes));
    return { name, symbol, factor: factor / 10 ** exponent, unit: scaledUnit(exponent, unit) };
  });
}

export const columnsOf = (whose, columns) => columns.map((column) => ({ ...column, name: whose + column.name }));

export function headOf(first, columns) {
  return [`<th scope=col>${first}</th>`, ...columns.map(({ symbol, unit }) => `<th scope=col>${symbol} <small>${unit || "&nbsp;"}</small></th>`)].join("");
}

// the head of a table, and its rows; what follows has a head of its own between the rows
export function bodiesOf(parts) {
  return parts.map(({ head, rows }, i) => `${i ? "" : `<thead><tr>${head}</tr></thead>`}<tbody>${i ? `<tr class="head">${head}</tr>` : ""}${rows.join("")}</tbody>`).join("");
}

export function measuredCells(measured, columns) {
  return columns.map(({ name, factor }) => {
    const value = measured?.values[name] ?? null, error = measured?.errors[name] ?? null;
    const [number, deviation] = value === null ? ["–"] : withError(value * factor, error === null ? null : error * factor, false).split(/ (?=± )/);
    if (value === null && measured?.undefined && name.includes("impact")) return `<td data-quantity="${name}" data-value="" data-error=""><abbr title="${escaped(measured.undefined)}">no value</abbr></td>`;
    return `<td data-quantity="${name}" data-value="${value ?? ""}" data-error="${error ?? ""}">${number}<span class="gap">${deviation ?? ""}</span></td>`;
  }).join("");
}

// a table that is wider than its place fades out at the right
export function fadeWhereCut(table) {
  const scroll = table.parentElement;
  const cut = () => scroll.classList.toggle("cut", scroll.scrollWidth - scroll.clientWidth - scroll.scrollLeft > 1);
  scroll.addEventListener("scroll", cut);
  for (const one of [scroll, table]) new ResizeObserver(cut).observe(one);
}

export class Table {
  constructor(element, warnings, silent, drawn, changed) {
    this.element = element;
    this.warnings = warnings;
    this.silent = silent;
    this.drawn = drawn; // Set of names
    this.changed = changed;
    fadeWhereCut(element);
  }

  show(view, stale) {
    const { theory, measured } = view, best = theory?.recommended;
    this.element.classList.toggle("stale", stale);
    const source = measured ?? (best && { values: theory.methods[best].moments });
    // numbers that still depend on the start are no measure of theories of the stationary state
    const judge = stale || isTransient(measured) ? null : measured;
    const parts = view.groups.map((group) => {
      const columns = columnsFor(view, group, [source]);
      const rows = group.rows.flatMap(([whose, title]) => {
        const own = columnsOf(whose, columns), by = title ? `${escaped(title)} <small>Monte Carlo</small>` : "Monte Carlo";
        const found = [`<tr class="measured"><th scope=row><span class="swatch box"></span>${by}</th>${measuredCells(measured, own)}</tr>`];
        for (const name of theory ? NAMES : []) {
          const answer = theory.methods[name];
          if (answer) found.push(this.row(name, answer, best === name && !isTransient(measured), judge, own));
        }
        return found;
      });
      return { head: headOf(group.head, columns), rows };
    });
    if (isComputing(view)) parts.at(-1).rows.push(`<tr class="computing"><th scope=row colspan="${1 + view.groups.at(-1).columns.length}">theory: computing…</th></tr>`);
    const focused = document.activeElement?.dataset?.draw;
    this.element.innerHTML = `<caption class="sr">Moments by Monte Carlo and by every method of the theory</caption>${bodiesOf(parts)}`;
    for (const box of this.element.querySelectorAll("[data-draw]")) {
      box.addEventListener("change", () => {
        if (box.checked) this.drawn.add(box.dataset.draw); else this.drawn.delete(box.dataset.draw);
        this.changed();
      });
      if (box.dataset.draw === focused) box.focus();
    }
    this.showWarnings(theory, measured);
  }

  row(name, answer, best, measured, columns) {
    const cells = columns.map(({ name: quantity, factor }) => {
      const value = answer.moments[quantity];
      const gap = measured ? gapOf(value, measured.values[quantity], measured.errors[quantity]) : null;
      const size = gap?.percent === null || !gap ? "" : Math.abs(gap.percent) < SMALL ? "small" : Math.abs(gap.percent) < LARGE ? "middle" : "large";
      return `<td data-quantity="${quantity}" data-value="${value ?? ""}">${short(value === null ? null : value * factor)}<span class="gap ${size}">${gapText(gap)}</span></td>`;
    });
    const warning = answer.warnings.length ? `<abbr class="warn" title="${escaped(typeset(answer.warnings.join(" ")))}">⚠</abbr>` : "";
    const star = best ? `<span class="best" title="recommended here">★</span>` : "";
    return `<tr data-method="${name}"${best ? ' class="recommended"' : ""}><th scope=row><label><input type="checkbox" data-draw="${name}" ${this.drawn.has(name) ? "checked" : ""} aria-label="draw ${METHODS[name].label}"><span class="swatch" data-method="${name}"></span>${METHODS[name].label}</label>${star}${warning}</th>${cells.join("")}</tr>`;
  }

  showWarnings(theory, measured) {
    const silent = theory ? NAMES.filter((name) => theory.statements[name]) : [];
    const groups = new Map(); // methods often say the same
    for (const name of silent) groups.set(theory.statements[name], [...(groups.get(theory.statements[name]) ?? []), name]);
    const labels = (names) => names.map((name) => METHODS[name].label).join("; ");
    this.silent.innerHTML = [...groups].map(([sentence, names]) => `<p><b>${labels(names)}</b> ${names.length > 1 ? "have" : "has"} no answer here: ${escaped(typeset(sentence))}</p>`).join("");
    const said = [];
    if (theory && !theory.recommended) {
      said.push(["theory", isSilent(theory) ? "no analytical method covers this." : "no method is recommended here: compare with Monte Carlo."]);
    }
    if (measured?.undefined && !measured.warnings.length) said.push(["Monte Carlo", `impact rate and speeds have no value: ${measured.undefined}.`]);
    for (const sentence of measured?.warnings ?? []) said.push(["Monte Carlo", sentence]);
    for (const name of theory ? NAMES : []) {
      const answer = theory.methods[name];
      if (answer && (theory.recommended === name || this.drawn.has(name))) {
        for (const sentence of answer.warnings) said.push([METHODS[name].label, sentence]);
      }
    }
    this.warnings.innerHTML = said.map(([who, sentence]) => `<p><span aria-hidden="true">⚠</span> <b>${who}:</b> ${escaped(typeset(sentence))}</p>`).join("");
  }
}

// theory is of the stationary state: beside a run that is not, a gap would say nothing
export const isTransient = (measured) => measured?.stationary === false;
// the analytical methods of this question are not known yet, and will be
export const isComputing = ({ theory, old, failed }) => !failed && (!theory || old.theory);
export const isSilent = (theory) => Object.keys(theory.methods).length === 0;

export function escaped(text) {
  return text.replace(/[&<>"']/g, (c) => `&#${c.charCodeAt(0)};`);
}

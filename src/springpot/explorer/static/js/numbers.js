// How numbers are shown.

export function short(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    return `${Number(mantissa)}·10${superscript(Number(exponent))}`.replace("-", "−");
  }
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

// powers of ten are left out where a head or a label has them
export function withError(value, error, powers = true) {
  if (value === null || value === undefined) return "–";
  if (error === null || error === undefined || !(error > 1e-12 * Math.abs(value))) return short(value); // rounding is no error
  const size = Math.max(Math.abs(value), error);
  if (powers && (size >= 1e5 || size < 1e-3)) {
    const exponent = Math.floor(Math.log10(size));
    return `(${fixed(value / 10 ** exponent, error / 10 ** exponent)})·10${superscript(exponent)}`;
  }
  return fixed(value, error);
}

// two digits of an error that begins with 1 or 2, one of any other
function fixed(value, error) {
  const first = Math.floor(Math.log10(error)), digits = error / 10 ** first < 2.95 ? 1 : 0;
  const places = Math.min(Math.max(digits - first, 0), 8);
  return `${value.toFixed(places).replace("-", "−")} ± ${error.toFixed(places)}`;
}

// a number large, its error smaller below it, each with the power of ten that both share, and the unit
export function withErrorHtml(value, error, unit) {
  const [number, deviation] = withError(value, error).replace(/^\((.*)\)(·10.*)$/, "$1$2").split(" ± ");
  const [digits, power = ""] = (deviation ?? "").split(/(?=·10)/);
  const named = unit ? `\u00a0<small>${unit}</small>` : "";
  return deviation ? `${number}${power}${named} <span>± ${digits}${power}</span>` : number + named;
}

// what the library says, with symbols
export function typeset(sentence) {
  return sentence.replace(/<([A-Za-z]+)\^2>/g, "⟨$1²⟩").replace(/<([A-Za-z]+)>/g, "⟨$1⟩")
    .replace(/\balpha\b/g, "α").replace(/\bOmega\b/g, "Ω").replace(/\^\(α ?- ?2\)/g, "^(α−2)").replace(/<=/g, "≤").replace(/>=/g, "≥");
}

export function grouped(count) { return String(count).replace(/\B(?=(\d{3})+$)/g, "\u202f"); }

export function superscript(exponent) {
  const digits = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  return String(exponent).replace(/[0-9]/g, (d) => digits[d]).replace("-", "⁻");
}

// for fields that a person edits: plain, no more digits than they carry
export function plain(value) { return String(Number(value.toPrecision(6))); }

// the power of ten, a multiple of three, that numbers up to a size are shown without; 0 if they are handy as they are
export function exponentFor(largest) {
  const size = Math.abs(largest);
  if (!(size > 0) || !Number.isFinite(size) || (size >= 0.01 && size < 1e5)) return 0;
  return 3 * Math.floor(Math.log10(size) / 3 + 1e-9);
}

// a unit with that power of ten in front
export function scaledUnit(exponent, unit) {
  return [exponent ? `10${superscript(exponent)}` : "", unit].filter(Boolean).join("\u00a0");
}

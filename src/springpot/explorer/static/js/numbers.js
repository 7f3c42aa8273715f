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

export function withError(value, error) {
  if (value === null || value === undefined) return "–";
  if (error === null || error === undefined || !(error > 0)) return short(value);
  const size = Math.max(Math.abs(value), error);
  if (size >= 1e5 || size < 1e-3) {
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

// the number large, its error smaller and on one line with the unit
export function withErrorHtml(value, error, unit) {
  const [number, deviation] = withError(value, error).split(" ± ");
  return number + (deviation ? ` <span>± ${deviation}</span>\u00a0${unit.trim()}` : unit);
}

// what the library says, in a typesetter's hand; numbers without dimensions carry no units
export function typeset(sentence, si = true) {
  return (si ? sentence : sentence.replace(/(\d) (?:m\/s|rad\/s|1\/s|per s|m|s)(?![\w^/])/g, "$1"))
    .replace(/<([A-Za-z]+)\^2>/g, "⟨$1²⟩").replace(/<([A-Za-z]+)>/g, "⟨$1⟩")
    .replace(/\balpha\b/g, "α").replace(/\bOmega\b/g, "Ω").replace(/\^\(α ?- ?2\)/g, "^(α−2)").replace(/<=/g, "≤").replace(/>=/g, "≥");
}

export function grouped(count) { return String(count).replace(/\B(?=(\d{3})+$)/g, "\u202f"); }

export function superscript(exponent) {
  const digits = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  return String(exponent).replace(/[0-9]/g, (d) => digits[d]).replace("-", "⁻");
}

// for fields that a person edits: plain, no more digits than they carry
export function plain(value) { return String(Number(value.toPrecision(6))); }
